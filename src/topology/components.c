/* components: of elements that facets join, where several processes have parts of one. */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "base/sum.h"
#include "topology/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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
        any |= mesh->part->node_role[node[j]] == PLANISH_ROLE_GHOST;
    return any;
}

/** The borders, by their ids; processes have the same elements in the same order, and so the same
 *  ids of duplicates. NULL without memory. */
static border *list_borders(const planish_mesh *mesh, int64_t *n) {
    *n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++)
        *n += has_ghost(mesh, i);
    border *all = pl_alloc(*n, sizeof *all);
    if (!all)
        return NULL;
    int64_t k = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++)
        if (has_ghost(mesh, i))
            all[k++] = (border){pl_element_id(mesh, i), (int32_t)i};
    if (k > 0)
        qsort(all, (size_t)k, sizeof *all, compare_borders);
    for (int64_t i = 1; i < k; i++)
        if (all[i].id <= all[i - 1].id)
            all[i].id = all[i - 1].id + 1;
    return all;
}

/* ---- messages about them ----------------------------------------------------------------------
 */

/** Message about one element at a SHARED node, to the processes that have the node as a ghost. */
typedef struct news {
    int64_t id, label;
    int64_t flags; /* REVERSED, CONFLICT */
} news;

enum { REVERSED = 1, CONFLICT = 2 };

_Static_assert(sizeof(news) <= PL_LARGEST_VALUE, "news are sent as values of nodes");

/** The exchange about all components. */
typedef struct exchange {
    const uint32_t *link;
    pl_settlement *s;
    border *border; /* [n_borders] by ids */
    int64_t n_borders;
    int changed; /* news have changed what is known of a component */
} exchange;

static int64_t flags_of(const exchange *e, int64_t element) {
    const uint32_t root = root_of(e->link, element);
    const int reversed = (int)(e->link[element] & 1) ^ e->s->reversed[root];
    return (reversed ? REVERSED : 0) | (e->s->conflict[root] ? CONFLICT : 0);
}

/** Take over the news about an element of ghost. */
static void receive_news(int32_t ghost, const void *value, void *taker) {
    exchange *e = taker;
    news n;
    (void)ghost;
    memcpy(&n, value, sizeof n);
    int64_t low = 0, high = e->n_borders;
    while (low < high) {
        const int64_t middle = (low + high) / 2;
        if (e->border[middle].id < n.id)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == e->n_borders || e->border[low].id != n.id)
        return;
    const int32_t element = e->border[low].element;
    const uint32_t root = root_of(e->link, element);
    const int64_t before = e->s->label[root];
    const int differs = ((flags_of(e, element) ^ n.flags) & REVERSED) != 0;
    int conflict = e->s->conflict[root] || (n.flags & CONFLICT);
    if (n.label < before) {
        e->s->label[root] = n.label;
        e->s->reversed[root] ^= (uint8_t)differs;
    } else if (n.label == before && differs) {
        conflict = 1;
    }
    e->changed |= n.label < before || conflict != e->s->conflict[root];
    e->s->conflict[root] = (int8_t)conflict;
}

/** Label the components with the smallest id of their elements here. id_of [m]: ids of borders, -1
 *  of other elements. */
static void label_alone(const planish_mesh *mesh, const uint32_t *link, const int64_t *id_of,
                        pl_settlement *s) {
    for (int64_t i = 0; i < mesh->n_elements; i++)
        s->label[i] = INT64_MAX;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const uint32_t root = root_of(link, i);
        const int64_t id = id_of[i] >= 0 ? id_of[i] : pl_element_id(mesh, i);
        if (id >= s->label[root])
            continue;
        s->label[root] = id;
        s->reversed[root] = link[i] & 1;
    }
}

/** Send news of the k-th element of each SHARED node that has so many. node and message have room
 *  for all SHARED nodes. */
static void send_news(const exchange *e, const pl_incidence *incidence, const int64_t *id_of,
                      int64_t k, int32_t *node, news *message) {
    const pl_context *context = pl_context_current();
    int64_t n = 0;
    for (int64_t i = 0; i < context->n_shared; i++) {
        const int32_t shared = context->shared[i];
        const int64_t at = incidence->offset[shared] + k;
        if (at >= incidence->offset[shared + 1])
            continue;
        const int32_t element = incidence->element[at];
        if (id_of[element] < 0) /* no other process has it */
            continue;
        node[n] = shared;
        message[n++] =
            (news){id_of[element], e->s->label[root_of(e->link, element)], flags_of(e, element)};
    }
    pl_parts_send(node, n, message, sizeof *message);
}

int pl_components_settle(const planish_mesh *mesh, const pl_incidence *incidence,
                         const uint32_t *link, pl_settlement *s, planish_error *error) {
    const pl_context *context = pl_context_current();
    const int64_t m = mesh->n_elements;
    exchange e = {.link = link, .s = s};
    s->label = pl_alloc(m, sizeof *s->label);
    s->reversed = pl_alloc_zero(m, sizeof *s->reversed);
    e.border = list_borders(mesh, &e.n_borders);
    int64_t *id_of = pl_alloc(m, sizeof *id_of);
    int32_t *node = pl_alloc(context->n_shared, sizeof *node);
    news *message = pl_alloc(context->n_shared, sizeof *message);
    const int done = s->label && s->reversed && e.border && id_of && node && message;
    if (done) {
        for (int64_t i = 0; i < m; i++)
            id_of[i] = -1;
        for (int64_t k = 0; k < e.n_borders; k++)
            id_of[e.border[k].element] = e.border[k].id;
        label_alone(mesh, link, id_of, s);
        double rounds = 0; /* elements at a SHARED node, at most, in any process */
        for (int64_t i = 0; i < context->n_shared; i++) {
            const int64_t *offset = incidence->offset + context->shared[i];
            rounds = fmax(rounds, (double)(offset[1] - offset[0]));
        }
        pl_parts_largest(&rounds, 1);
        do { /* all processes tell all they know, until nothing is new to any of them */
            e.changed = 0;
            for (int64_t k = 0; k < (int64_t)rounds; k++) {
                send_news(&e, incidence, id_of, k, node, message);
                pl_parts_receive(receive_news, &e);
            }
        } while (pl_parts_any(e.changed));
    }
    pl_free(e.border);
    pl_free(id_of);
    pl_free(node);
    pl_free(message);
    return done ? PLANISH_OK : pl_fail_memory(error, "the components of the mesh");
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

/** Sum up those [n] that processes share; how many labels there are. Of each slot the smallest
 * label that a process has left is summed up by all, of all slots together. sums: room for SLOTS.
 */
static int64_t sum_together(partial *all, int64_t n, pl_sum *sums, double *measure) {
    struct {
        partial *next, *end;
    } slot[SLOTS]; /* remaining entries, ascending */
    int64_t n_labels = 0, label[SLOTS];
    if (n > 0)
        qsort(all, (size_t)n, sizeof *all, compare_slots);
    partial *next = all;
    for (int s = 0; s < SLOTS; s++) {
        slot[s].next = next;
        while (next < all + n && slot_of(next) == s)
            next++;
        slot[s].end = next;
    }
    for (;;) {
        int n_found = 0;
        for (int s = 0; s < SLOTS; s++)
            label[s] = slot[s].next < slot[s].end ? slot[s].next->label : INT64_MAX;
        pl_parts_smallest_integers(label, SLOTS);
        for (int s = 0; s < SLOTS; s++)
            n_found += label[s] < INT64_MAX;
        if (n_found == 0)
            return n_labels;
        memset(sums, 0, SLOTS * sizeof *sums);
        for (int s = 0; s < SLOTS; s++)
            for (partial *p = slot[s].next; p < slot[s].end && p->label == label[s]; p++)
                pl_sum_merge(&sums[s], &p->sum);
        pl_parts_add_sums(sums, SLOTS);
        for (int s = 0; s < SLOTS; s++)
            for (; slot[s].next < slot[s].end && slot[s].next->label == label[s]; slot[s].next++)
                measure[slot[s].next->root] = pl_sum_value(&sums[s]);
        n_labels += n_found;
    }
}

int pl_components_sum(const planish_mesh *mesh, const uint32_t *link, const pl_settlement *s,
                      double *measure, int64_t *n, planish_error *error) {
    const uint8_t *is_counted = mesh->part ? mesh->part->is_counted : NULL;
    listing l = {0};
    int64_t n_partial = 0;
    int done = list_elements(mesh, link, &l) == 0;
    for (int64_t c = 0; s && done && c < l.n; c++)
        n_partial += is_partial(mesh, &l, c);
    partial *partials = pl_alloc(n_partial, sizeof *partials);
    pl_sum *sums = pl_alloc(s ? SLOTS : 0, sizeof *sums);
    done = done && partials && sums;
    n_partial = 0;
    for (int64_t c = 0; done && c < l.n; c++) {
        const uint32_t root = l.root[c];
        pl_sum sum;
        memset(&sum, 0, sizeof sum);
        for (int64_t k = l.begin[c]; k < l.begin[c + 1]; k++)
            if (!is_counted || is_counted[l.element[k]])
                pl_sum_add(&sum, measure[l.element[k]]);
        if (s && is_partial(mesh, &l, c))
            partials[n_partial++] = (partial){.label = s->label[root], .root = root, .sum = sum};
        else
            measure[root] = pl_sum_value(&sum);
    }
    if (done) {
        *n = l.n - n_partial;
        pl_parts_add(n, 1);
        *n += s ? sum_together(partials, n_partial, sums, measure) : 0;
    }
    pl_free(partials);
    pl_free(sums);
    pl_free(l.root);
    pl_free(l.begin);
    pl_free(l.element);
    return done ? PLANISH_OK : pl_fail_memory(error, "the components of the mesh");
}
