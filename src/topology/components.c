/* components: of elements that facets join, where several processes have parts of one. */
#include "topology/components.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "base/sum.h"
#include "topology/facets.h"

#include <stdlib.h>
#include <string.h>

static int fail_memory(planish_error *error) {
    return pl_fail_memory(error, "the components of the mesh");
}

static uint32_t root_of(const uint32_t *link, int64_t element) {
    return link[element] >> 1;
}

int64_t pl_element_id(const planish_mesh *mesh, int64_t element) {
    const int dim = mesh->dim;
    const int32_t *node = mesh->elements + element * (dim + 1);
    int32_t sorted[4];
    uint64_t hash = 0;
    pl_sort_element(dim, node, sorted);
    for (int j = 0; j <= dim; j++) {
        hash ^= (uint64_t)(mesh->part ? mesh->part->node_number[sorted[j]] : sorted[j]);
        hash *= UINT64_C(0x9E3779B97F4A7C15);
        hash ^= hash >> 29;
        hash *= UINT64_C(0xBF58476D1CE4E5B9);
        hash ^= hash >> 32;
    }
    return (int64_t)(hash >> 2);
}

/* ---- elements that several processes have ---------------------------------------------------- */

/** Element that has a ghost. */
typedef struct border {
    int64_t id; /* of duplicates that of the first, and one more for each */
    int32_t element;
} border;

static int compare_borders(const void *a, const void *b) {
    const border *p = a, *q = b;
    if (p->id != q->id)
        return p->id < q->id ? -1 : 1;
    return (p->element > q->element) - (p->element < q->element);
}

static int has_ghost(const planish_mesh *mesh, int64_t element) {
    const int32_t *node = mesh->elements + element * (mesh->dim + 1);
    int any = 0;
    for (int j = 0; j <= mesh->dim; j++)
        any |= mesh->part->node_role[node[j]] == PLANISH_GHOST;
    return any;
}

/** The borders, by their ids; processes have the same elements in the same order, and so the same
 *  ids of duplicates. NULL without memory. */
static border *list_borders(const planish_mesh *mesh, int64_t *n) {
    *n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++)
        *n += has_ghost(mesh, i);
    border *all = pl_alloc(*n, sizeof *all);
    int64_t k = 0;
    for (int64_t i = 0; all && i < mesh->n_elements; i++)
        if (has_ghost(mesh, i))
            all[k++] = (border){pl_element_id(mesh, i), (int32_t)i};
    if (all && k > 0)
        qsort(all, (size_t)k, sizeof *all, compare_borders);
    for (int64_t i = 1; i < k && all; i++)
        if (all[i].id <= all[i - 1].id)
            all[i].id = all[i - 1].id + 1;
    return all;
}

/* ---- what is told of them -------------------------------------------------------------------- */

/** Message about one element at a SHARED node, to the processes that have the node as a ghost. */
typedef struct news {
    int64_t id, label;
    int64_t flags; /* REVERSED, CONFLICT */
} news;

enum { REVERSED = 1, CONFLICT = 2 };

_Static_assert(sizeof(news) <= PL_LARGEST_VALUE, "news are sent as values of nodes");

/** The work on all components. */
typedef struct work {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const uint32_t *link;
    pl_settlement *s;
    border *border; /* [n_borders] by ids; owned, as what follows */
    int64_t n_borders;
    int64_t *id_of; /* [m] ids of borders, -1 of other elements */
    int32_t *node;  /* [SHARED nodes] of which something is told, */
    news *news;     /* likewise what */
    int64_t rounds; /* elements at a SHARED node, at most, in any process */
    int changed;    /* news have changed what is known of a component */
} work;

static int64_t flags_of(const work *w, int64_t element) {
    const uint32_t root = root_of(w->link, element);
    const int reversed = (int)(w->link[element] & 1) ^ w->s->reversed[root];
    return (reversed ? REVERSED : 0) | (w->s->conflict[root] ? CONFLICT : 0);
}

/** Report the k-th element of each SHARED node that has so many. */
static void tell(work *w, int64_t k) {
    const pl_context *context = pl_context_current();
    int64_t n = 0;
    for (int64_t i = 0; i < context->n_shared; i++) {
        const int32_t node = context->shared[i];
        const int64_t at = w->incidence->offset[node] + k;
        if (at >= w->incidence->offset[node + 1])
            continue;
        const int32_t element = w->incidence->element[at];
        if (w->id_of[element] < 0) /* no other process has it */
            continue;
        w->node[n] = node;
        w->news[n++] =
            (news){w->id_of[element], w->s->label[root_of(w->link, element)], flags_of(w, element)};
    }
    pl_parts_send(w->node, n, w->news, sizeof *w->news);
}

static const border *find_border(const work *w, int64_t id) {
    const border key = {id, -1};
    int64_t low = 0, high = w->n_borders;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (compare_borders(&w->border[middle], &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low < w->n_borders && w->border[low].id == id ? &w->border[low] : NULL;
}

/** Take in what is told of an element of ghost. */
static void take_in(int32_t ghost, const void *value, void *taker) {
    work *w = taker;
    news n;
    (void)ghost;
    memcpy(&n, value, sizeof n);
    const border *b = find_border(w, n.id);
    if (!b)
        return;
    const uint32_t root = root_of(w->link, b->element);
    const int64_t before = w->s->label[root];
    const int differs = ((flags_of(w, b->element) ^ n.flags) & REVERSED) != 0;
    int conflict = w->s->conflict[root] || (n.flags & CONFLICT);
    if (n.label < before) {
        w->s->label[root] = n.label;
        w->s->reversed[root] ^= (uint8_t)differs;
    } else if (n.label == before && differs) {
        conflict = 1;
    }
    w->changed |= n.label < before || conflict != w->s->conflict[root];
    w->s->conflict[root] = (int8_t)conflict;
}

/** All processes tell all they know; whether anything is new to one of them. */
static int exchange(work *w) {
    w->changed = 0;
    for (int64_t k = 0; k < w->rounds; k++) {
        tell(w, k);
        pl_parts_receive(take_in, w);
    }
    return pl_parts_any(w->changed);
}

/** Labels from the elements here: the smallest id of each component. */
static void label_alone(work *w) {
    const int64_t m = w->mesh->n_elements;
    for (int64_t i = 0; i < m; i++) {
        w->s->label[i] = INT64_MAX;
        w->id_of[i] = -1;
    }
    for (int64_t k = 0; k < w->n_borders; k++)
        w->id_of[w->border[k].element] = w->border[k].id;
    for (int64_t i = 0; i < m; i++) {
        const uint32_t root = root_of(w->link, i);
        const int64_t id = w->id_of[i] >= 0 ? w->id_of[i] : pl_element_id(w->mesh, i);
        if (id >= w->s->label[root])
            continue;
        w->s->label[root] = id;
        w->s->reversed[root] = w->link[i] & 1;
    }
}

static void count_rounds(work *w) {
    const pl_context *context = pl_context_current();
    double most = 0;
    for (int64_t i = 0; i < context->n_shared; i++) {
        const int32_t node = context->shared[i];
        const double n = (double)(w->incidence->offset[node + 1] - w->incidence->offset[node]);
        most = n > most ? n : most;
    }
    pl_parts_largest(&most, 1);
    w->rounds = (int64_t)most;
}

int pl_components_settle(const planish_mesh *mesh, const pl_incidence *incidence,
                         const uint32_t *link, pl_settlement *s, planish_error *error) {
    work w = {.mesh = mesh, .incidence = incidence, .link = link, .s = s};
    s->label = pl_alloc(mesh->n_elements, sizeof *s->label);
    s->reversed = pl_alloc_zero(mesh->n_elements, sizeof *s->reversed);
    w.border = list_borders(mesh, &w.n_borders);
    w.id_of = pl_alloc(mesh->n_elements, sizeof *w.id_of);
    w.node = pl_alloc(pl_context_current()->n_shared, sizeof *w.node);
    w.news = pl_alloc(pl_context_current()->n_shared, sizeof *w.news);
    int status = s->label && s->reversed && w.border && w.id_of && w.node && w.news
                     ? PLANISH_OK
                     : fail_memory(error);
    if (!status) {
        label_alone(&w);
        count_rounds(&w);
        while (exchange(&w)) {
        }
    }
    pl_free(w.border);
    pl_free(w.id_of);
    pl_free(w.node);
    pl_free(w.news);
    return status;
}

void pl_settlement_destroy(pl_settlement *s) {
    pl_free(s->label);
    pl_free(s->reversed);
    *s = (pl_settlement){0};
}

/* ---- sums ------------------------------------------------------------------------------------ */

/** The elements of each component here; arrays are owned. */
typedef struct listing {
    int64_t n;
    uint32_t *root;   /* [n] ascending */
    int64_t *begin;   /* [n + 1], with room for one more */
    int32_t *element; /* [m] */
} listing;

static void listing_destroy(listing *l) {
    pl_free(l->root);
    pl_free(l->begin);
    pl_free(l->element);
}

/** 0, or -1 without memory. */
static int list_elements(const planish_mesh *mesh, const uint32_t *link, listing *l) {
    const int64_t m = mesh->n_elements;
    int32_t *slot = pl_alloc(m, sizeof *slot);
    l->n = 0;
    for (int64_t i = 0; i < m; i++)
        l->n += root_of(link, i) == i;
    l->root = pl_alloc(l->n, sizeof *l->root);
    l->begin = pl_alloc_zero(l->n + 2, sizeof *l->begin);
    l->element = pl_alloc(m, sizeof *l->element);
    const int done = slot && l->root && l->begin && l->element;
    int64_t k = 0;
    for (int64_t i = 0; done && i < m; i++) { /* roots are the first of their components */
        if (root_of(link, i) == i) {
            l->root[k] = (uint32_t)i;
            slot[i] = (int32_t)k++;
        }
        l->begin[slot[root_of(link, i)] + 2]++;
    }
    for (int64_t c = 0; done && c < l->n; c++)
        l->begin[c + 2] += l->begin[c + 1];
    for (int64_t i = 0; done && i < m; i++) /* each begin becomes the next one's */
        l->element[l->begin[slot[root_of(link, i)] + 1]++] = (int32_t)i;
    pl_free(slot);
    return done ? 0 : -1;
}

/** Sum the measures of the elements of component c that this process counts. */
static void sum_one(const planish_mesh *mesh, const listing *l, int64_t c, const double *measure,
                    pl_sum *sum) {
    const uint8_t *is_counted = mesh->part ? mesh->part->is_counted : NULL;
    memset(sum, 0, sizeof *sum);
    for (int64_t k = l->begin[c]; k < l->begin[c + 1]; k++)
        if (!is_counted || is_counted[l->element[k]])
            pl_sum_add(sum, measure[l->element[k]]);
}

/** A component, or what is here of it, that other processes have, too. */
typedef struct partial {
    int64_t label;
    uint32_t root;
    pl_sum sum;
} partial;

enum { SLOTS = 64 }; /* labels whose sums are sent together */

/** Labels are hashes, so that slots have about as many. */
static int slot_of(const partial *p) {
    return (int)(p->label % SLOTS);
}

static int compare_slots(const void *a, const void *b) {
    const partial *p = a, *q = b;
    if (slot_of(p) != slot_of(q))
        return slot_of(p) < slot_of(q) ? -1 : 1;
    return (p->label > q->label) - (p->label < q->label);
}

static int is_partial(const planish_mesh *mesh, const listing *l, int64_t c) {
    int any = 0;
    for (int64_t k = l->begin[c]; k < l->begin[c + 1] && !any; k++)
        any = has_ghost(mesh, l->element[k]);
    return any;
}

/** Remaining entries of a slot, ascending. */
typedef struct slot {
    partial *next, *end;
} slot;

/** Sort those [n] that processes share into slots [SLOTS]. */
static void fill_slots(partial *all, int64_t n, slot *slots) {
    int64_t k = 0;
    if (n > 0)
        qsort(all, (size_t)n, sizeof *all, compare_slots);
    for (int s = 0; s < SLOTS; s++) {
        slots[s].next = all + k;
        while (k < n && slot_of(&all[k]) == s)
            k++;
        slots[s].end = all + k;
    }
}

/** Sum up those [n] that processes share; how many labels there are. Of each slot the smallest
 * label that a process has left is summed up by all, of all slots together. sums: room for SLOTS.
 */
static int64_t sum_together(partial *all, int64_t n, pl_sum *sums, double *measure) {
    slot slots[SLOTS];
    int64_t n_labels = 0, label[SLOTS];
    fill_slots(all, n, slots);
    for (;;) {
        int n_found = 0;
        for (int s = 0; s < SLOTS; s++)
            label[s] = slots[s].next < slots[s].end ? slots[s].next->label : INT64_MAX;
        pl_parts_smallest_integers(label, SLOTS);
        for (int s = 0; s < SLOTS; s++)
            n_found += label[s] < INT64_MAX;
        if (n_found == 0)
            return n_labels;
        memset(sums, 0, SLOTS * sizeof *sums);
        for (int s = 0; s < SLOTS; s++)
            for (partial *p = slots[s].next; p < slots[s].end && p->label == label[s]; p++)
                pl_sum_share(&sums[s], &p->sum);
        pl_parts_add_sums(sums, SLOTS);
        for (int s = 0; s < SLOTS; s++)
            for (; slots[s].next < slots[s].end && slots[s].next->label == label[s];
                 slots[s].next++)
                measure[slots[s].next->root] = pl_sum_value(&sums[s]);
        n_labels += n_found;
    }
}

/** Sum up all components; those that several processes share go to partials, *n_partial of them. */
static void sum_alone(const planish_mesh *mesh, const listing *l, const pl_settlement *s,
                      double *measure, partial *partials, int64_t *n_partial) {
    *n_partial = 0;
    for (int64_t c = 0; c < l->n; c++) {
        pl_sum sum;
        sum_one(mesh, l, c, measure, &sum);
        if (s && is_partial(mesh, l, c))
            partials[(*n_partial)++] =
                (partial){.label = s->label[l->root[c]], .root = l->root[c], .sum = sum};
        else
            measure[l->root[c]] = pl_sum_value(&sum);
    }
}

int pl_components_sum(const planish_mesh *mesh, const uint32_t *link, const pl_settlement *s,
                      double *measure, int64_t *n, planish_error *error) {
    listing l = {0};
    partial *partials = NULL;
    pl_sum *sums = NULL;
    int64_t n_partial = 0;
    int status = list_elements(mesh, link, &l) ? fail_memory(error) : PLANISH_OK;
    for (int64_t c = 0; s && !status && c < l.n; c++)
        n_partial += is_partial(mesh, &l, c);
    if (!status && s) {
        partials = pl_alloc(n_partial, sizeof *partials);
        sums = pl_alloc(SLOTS, sizeof *sums);
        status = partials && sums ? PLANISH_OK : fail_memory(error);
    }
    if (!status) {
        sum_alone(mesh, &l, s, measure, partials, &n_partial);
        *n = l.n - n_partial;
        pl_parts_add(n, 1);
        *n += s ? sum_together(partials, n_partial, sums, measure) : 0;
    }
    pl_free(partials);
    pl_free(sums);
    listing_destroy(&l);
    return status;
}
