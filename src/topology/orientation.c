/* orientation: which order of its nodes each element has.
 *
 * Neighbours traverse their common facet in opposite directions: that decides the orientation of a
 * component of elements but for one sign, which is that of the component's summed measure. Usually
 * the whole file agrees, and one look at the measures is enough; otherwise the components are
 * found by a union-find structure that carries the parity between an element and its root.
 *
 * A component in which no choice satisfies all facets (a Moebius strip, or a file that is folded on
 * itself) keeps the file's order, and the nodes of the facets that contradict it are held.
 *
 * Of a mesh that is here as a whole, elements that wrap around a periodic domain (wrapped.c) are no
 * part of the sum, and their nodes are held; with such, or without a boundary, the number of
 * elements may overrule it.
 */
#include "topology/orientation.h"

#include "base/context.h"
#include "base/fetch.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "topology/components.h"
#include "topology/facets.h"
#include "topology/frame.h"
#include "topology/wrapped.h"

#include <inttypes.h>
#include <string.h>

enum { CHUNK = 8192 }; /* elements that one thread takes at a time */

/** The work on one mesh. Counters and marks are written from several threads. */
typedef struct work {
    const planish_mesh *mesh;
    pl_boundary *boundary;
    pl_frame frame;                         /* of all nodes, */
    pl_frame of_boundary;                   /* and of those on the boundary, if there are any */
    int64_t n_not_positive, n_not_negative; /* elements of such a measure */
    uint32_t *link; /* [m] parent << 1 | parity: 1 if the order is opposite to the parent's; parents
                       have smaller numbers, and a root is its own parent */
    double *measure;  /* [m] of the elements in their component's order; of a root, the sum */
    double anchor[3]; /* the place of a node on the boundary, */
    int has_anchor;   /* if there is one */
    uint8_t *flags;   /* [m] of wrapped.h; NULL in a mesh in parts */
    pl_settlement settlement; /* in a mesh in parts */
    int any_reversed;
    int n_conflicts; /* facets at which the parities contradict one another: some, or 0 */
} work;

/** In boundary->sign until the signs are known: what is known of an element's component. */
enum { ORIENTABLE = 0, CONFLICT = 1 };

static inline double measure_at(int dim, const pl_frame *frame, const double *const x[]) {
    double edges[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edges[j][d] = pl_frame_difference(frame, x[j + 1][d], x[0][d]);
    return pl_determinant_of_edges(dim, (const double(*)[3])edges);
}

static inline double measure_of(int dim, const planish_mesh *mesh, const pl_frame *frame,
                                int64_t element) {
    const int32_t *node = mesh->elements + element * (dim + 1);
    const double *x[4];
    for (int j = 0; j <= dim; j++)
        x[j] = mesh->coordinates + (int64_t)node[j] * dim;
    return measure_at(dim, frame, x);
}

/** Measure an element with the interior nodes at the anchor, in units of the boundary's frame.
 *  The sum over a component does not depend on where interior nodes are, but its rounding does,
 *  and whether a measure is a number: interior nodes, and nodes of no element, may have been
 *  thrown far out of the domain. */
static inline double anchored_measure_of(int dim, const work *w, int64_t element) {
    const int32_t *node = w->mesh->elements + element * (dim + 1);
    const double *x[4];
    for (int j = 0; j <= dim; j++) {
        x[j] = w->boundary->on_boundary[node[j]] || !w->has_anchor
                   ? w->mesh->coordinates + (int64_t)node[j] * dim
                   : w->anchor;
    }
    return measure_at(dim, &w->of_boundary, x);
}

/* ---- the usual case: everybody agrees ----------------------------------------------------- */

enum { AHEAD = 8 }; /* elements whose nodes are asked for before they are needed */

static inline void count_signs(work *w, int dim, const pl_frame *frame, int64_t begin,
                               int64_t end) {
    int64_t not_positive = 0, not_negative = 0;
    for (int64_t i = begin; i < end; i++) {
        if (i + AHEAD < end)
            pl_fetch_nodes(dim, w->mesh->elements, w->mesh->coordinates, i + AHEAD);
        double measure = measure_of(dim, w->mesh, frame, i);
        not_positive += !(measure > 0);
        not_negative += !(measure < 0);
    }
    __atomic_fetch_add(&w->n_not_positive, not_positive, __ATOMIC_RELAXED);
    __atomic_fetch_add(&w->n_not_negative, not_negative, __ATOMIC_RELAXED);
}

static void count_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    pl_frame plain;
    (void)thread;
    const int is_plain = pl_frame_is_plain(&w->frame, &plain);
    if (w->mesh->dim == 2)
        count_signs(w, 2, &w->frame, begin, end);
    else if (is_plain)
        count_signs(w, 3, &plain, begin, end);
    else
        count_signs(w, 3, &w->frame, begin, end);
}

static void set_negative(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    memset(w->boundary->sign + begin, -1, (size_t)(end - begin));
}

/* ---- components --------------------------------------------------------------------------- */

static uint32_t load(const work *w, uint32_t element) {
    return __atomic_load_n(w->link + element, __ATOMIC_RELAXED);
}

static int replace(work *w, uint32_t element, uint32_t expected, uint32_t desired) {
    return __atomic_compare_exchange_n(w->link + element, &expected, desired, 0, __ATOMIC_RELAXED,
                                       __ATOMIC_RELAXED);
}

/** Root of element; *parity is flipped if their orders are opposite. Shortens the path: a link that
 *  another thread has changed meanwhile says the same, so that losing the race does no harm. */
static uint32_t find_root(work *w, uint32_t element, uint32_t *parity) {
    for (;;) {
        uint32_t up = load(w, element), parent = up >> 1;
        if (parent == element)
            return element;
        uint32_t next = load(w, parent);
        if (next >> 1 != parent)
            replace(w, element, up, next ^ (up & 1));
        *parity ^= up & 1;
        element = parent;
    }
}

/** Join the components of a and b, whose orders are opposite if parity is 1. Returns 0 if they were
 *  joined before in the other way. The smaller root stays one, so that the roots in the end are
 *  the smallest elements of their components, whatever the order of the calls. */
static int join(work *w, uint32_t a, uint32_t b, uint32_t parity) {
    for (;;) {
        uint32_t total = parity;
        uint32_t root_a = find_root(w, a, &total), root_b = find_root(w, b, &total);
        if (root_a == root_b)
            return total == 0;
        uint32_t low = root_a < root_b ? root_a : root_b, high = root_a ^ root_b ^ low;
        if (replace(w, high, high << 1, low << 1 | total))
            return 1;
    }
}

static void start_components(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        w->link[i] = (uint32_t)i << 1;
    memset(w->boundary->sign + begin, ORIENTABLE, (size_t)(end - begin));
}

/** Whether a facet joins two elements, by all that is known: of one whose nodes all belong to
 * others not all elements need to be here. */
static int joins(const work *w, int32_t node, const pl_facet *facet) {
    const planish_part *part = w->mesh->part;
    return pl_facet_joins(facet) && (pl_is_own(part, node) || pl_is_own(part, facet->node[0]) ||
                                     (facet->node[1] >= 0 && pl_is_own(part, facet->node[1])));
}

static void join_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                        int thread) {
    work *w = context;
    (void)thread;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (!joins(w, node, facet))
            continue;
        uint32_t parity = facet->parity[0] == facet->parity[1];
        if (!join(w, (uint32_t)facet->element[0], (uint32_t)facet->element[1], parity)) {
            __atomic_store_n(w->boundary->sign + facet->element[0], CONFLICT, __ATOMIC_RELAXED);
            __atomic_store_n(&w->n_conflicts, 1, __ATOMIC_RELAXED);
        }
    }
}

/** Hand the conflict of an element on to its root, where its whole component finds it. Which
 *  elements saw the conflict depends on the threads; that the component has one does not. */
static void mark_roots(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (__atomic_load_n(w->boundary->sign + i, __ATOMIC_RELAXED) != CONFLICT)
            continue;
        uint32_t parity = 0, root = find_root(w, (uint32_t)i, &parity);
        __atomic_store_n(w->boundary->sign + root, CONFLICT, __ATOMIC_RELAXED);
    }
}

static int is_conflicting(work *w, int32_t element) {
    uint32_t parity = 0, root = find_root(w, (uint32_t)element, &parity);
    return w->boundary->sign[root] == CONFLICT;
}

/** Hold the nodes of facets that contradict the file's order in a component that keeps it. */
static void hold_conflicts(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                           int thread) {
    work *w = context;
    (void)thread;
    uint8_t *held = w->boundary->on_boundary;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (!joins(w, node, facet) || facet->parity[0] != facet->parity[1] ||
            !is_conflicting(w, facet->element[0]))
            continue;
        pl_set_flag(held + node, 1);
        for (int i = 0; i < 2 && facet->node[i] >= 0; i++)
            pl_set_flag(held + facet->node[i], 1);
    }
}

/* ---- signs of components ------------------------------------------------------------------ */

/** The first node on the boundary. */
static void find_anchor(work *w) {
    const planish_part *part = w->mesh->part;
    const size_t size = (size_t)w->mesh->dim * sizeof *w->anchor;
    int64_t i = 0, place[3] = {0, 0, 0};
    while (i < w->mesh->n_nodes && !(w->boundary->on_boundary[i] && pl_is_own(part, i)))
        i++;
    const int64_t number = i == w->mesh->n_nodes ? INT64_MAX : part ? part->node_number[i] : i;
    int64_t first = number;
    pl_parts_smallest_integers(&first, 1);
    w->has_anchor = first < INT64_MAX;
    if (first == number && w->has_anchor)
        memcpy(place, w->mesh->coordinates + i * w->mesh->dim, size);
    pl_parts_add(place, 3); /* bits: those of the others are 0 */
    memcpy(w->anchor, place, sizeof w->anchor);
}

/** Link every element to its root. */
static void link_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        uint32_t parity = 0, root = find_root(w, (uint32_t)i, &parity);
        __atomic_store_n(w->link + i, root << 1 | parity, __ATOMIC_RELAXED);
    }
}

/** Whether an element's order is opposite to that of its component. */
static int is_opposite(const work *w, int64_t element) {
    const uint32_t root = w->link[element] >> 1;
    if (w->boundary->sign[root] == CONFLICT)
        return 0;
    return (int)(w->link[element] & 1) ^
           (w->settlement.reversed ? w->settlement.reversed[root] : 0);
}

/** The measure of an element for its component's sum. Elements that wrap around have none, and so
 *  the sum of the others depends on where the interior nodes are. */
static double summand_of(const work *w, int dim, int64_t element) {
    const int64_t root = w->link[element] >> 1;
    if (w->flags && w->flags[element] & PL_WRAPPED)
        return 0;
    if (w->boundary->sign[root] == CONFLICT || (w->flags && w->flags[root] & PL_HAS_WRAPPED))
        return measure_of(dim, w->mesh, &w->frame, element);
    return anchored_measure_of(dim, w, element);
}

/** Measure every element in the order of its component; its parity is from now on that to it. */
static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    const int dim = w->mesh->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const double measure = summand_of(w, dim, i);
        const int opposite = is_opposite(w, i);
        w->measure[i] = opposite ? -measure : measure;
        w->link[i] = (w->link[i] & ~UINT32_C(1)) | (uint32_t)opposite;
    }
}

/** Components whose measure is 0 are turned so that the element of the smallest id keeps its order,
 *  as it does in a mesh in parts. */
static int turn_flat(work *w) {
    const int64_t m = w->mesh->n_elements;
    int any = 0;
    for (int64_t i = 0; i < m && !any; i++)
        any = w->link[i] >> 1 == i && w->measure[i] == 0;
    if (!any || w->mesh->part)
        return 1;
    int64_t *least = pl_alloc(m, sizeof *least);
    for (int64_t i = 0; least && i < m; i++) /* roots are the first of their components */
        least[i] = INT64_MAX;
    for (int64_t i = 0; least && i < m; i++) {
        const uint32_t root = w->link[i] >> 1;
        const double sum = w->measure[root];
        if (sum != 0 && !(least[root] < INT64_MAX))
            continue;
        const int64_t id = pl_element_id(w->mesh, i);
        if (id >= least[root])
            continue;
        least[root] = id;
        w->measure[root] = w->link[i] & 1 ? -1 : 0;
    }
    pl_free(least);
    return least != NULL;
}

/* ---- elements that wrap around, and components without a boundary ---------------------------- */

/** Mark the components that have a node on the boundary. */
static void mark_bounded(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    const int k = w->mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *node = w->mesh->elements + i * k;
        int any = 0;
        for (int j = 0; j < k; j++)
            any |= w->boundary->on_boundary[node[j]];
        uint8_t *flags = w->flags + (w->link[i] >> 1);
        if (any && !(__atomic_load_n(flags, __ATOMIC_RELAXED) & PL_HAS_BOUNDARY))
            __atomic_fetch_or(flags, PL_HAS_BOUNDARY, __ATOMIC_RELAXED);
    }
}

/** Find the elements that wrap around, and hold their nodes. */
static int find_wrapped(work *w, int threads, planish_error *error) {
    const int64_t m = w->mesh->n_elements;
    const int k = w->mesh->dim + 1;
    int64_t n;
    w->flags = pl_alloc_zero(m, sizeof *w->flags);
    if (!w->flags)
        return pl_fail_memory(error, "the components of the mesh");
    pl_parallel_for(threads, m, CHUNK, mark_bounded, w);
    const int status = pl_wrapped_find(w->mesh, w->link, w->boundary->sign, w->flags, &n, error);
    w->boundary->n_wrapped = n;
    if (status || n == 0)
        return status;
    for (int64_t i = 0; i < m; i++)
        for (int j = 0; j < k && w->flags[i] & PL_WRAPPED; j++)
            w->boundary->on_boundary[w->mesh->elements[i * k + j]] = 1;
    return PLANISH_OK;
}

/** Whether the elements of a component may decide by their number. */
static int may_count(const work *w, int64_t root) {
    return w->boundary->sign[root] != CONFLICT &&
           (w->flags[root] & PL_HAS_WRAPPED || !(w->flags[root] & PL_HAS_BOUNDARY));
}

/* Elements of such a component that overrule the sum, in parts of a hundred. */
enum { OVERRULING = 80 };

/** How many elements of each such component there are, and how many contradict its sum. */
static void count_votes(const work *w, int32_t *voters, int32_t *against) {
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        const int64_t root = w->link[i] >> 1;
        if (!may_count(w, root) || w->flags[i] & PL_WRAPPED)
            continue;
        const double drawn = measure_of(w->mesh->dim, w->mesh, &w->frame, i);
        const double measure = w->link[i] & 1 ? -drawn : drawn;
        voters[root]++;
        against[root] += w->measure[root] < 0 ? measure > 0 : measure < 0;
    }
}

/** The sum of signed measures says little of components without a boundary, where it is nothing but
 *  rounding, and where elements wrap around: the number of elements decides where it is telling. */
static int let_elements_decide(work *w, planish_error *error) {
    const int64_t m = w->mesh->n_elements;
    int64_t n = 0, n_turned = 0;
    for (int64_t i = 0; i < m; i++)
        n += w->link[i] >> 1 == i && may_count(w, i);
    if (n == 0)
        return PLANISH_OK;
    int32_t *voters = pl_alloc_zero(m, sizeof *voters);
    int32_t *against = pl_alloc_zero(m, sizeof *against);
    const int done = voters && against;
    if (done)
        count_votes(w, voters, against);
    for (int64_t i = 0; done && i < m; i++) {
        if (voters[i] == 0 || 100 * (int64_t)against[i] < OVERRULING * (int64_t)voters[i])
            continue;
        w->measure[i] = w->measure[i] < 0 ? 1 : -1;
        n_turned++;
    }
    pl_free(voters);
    pl_free(against);
    if (n_turned > 0)
        pl_log(PLANISH_LOG_NOTE,
               "which elements are inverted was decided by their number, not by the sum of their "
               "measures, in %" PRId64 " %s",
               n_turned, n_turned == 1 ? "part of the mesh" : "parts of the mesh");
    return done ? PLANISH_OK : pl_fail_memory(error, "the components of the mesh");
}

/* ---- all components -------------------------------------------------------------------------- */

static void sign_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    const uint8_t *is_counted = w->mesh->part ? w->mesh->part->is_counted : NULL;
    int64_t n_reversed = 0;
    int any = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int negative = w->measure[w->link[i] >> 1] < 0;
        int reversed = negative ^ (int)(w->link[i] & 1);
        w->boundary->sign[i] = reversed ? -1 : 1;
        n_reversed += reversed && (!is_counted || is_counted[i]);
        any |= reversed;
    }
    __atomic_fetch_add(&w->boundary->n_reversed, n_reversed, __ATOMIC_RELAXED);
    __atomic_fetch_or(&w->any_reversed, any, __ATOMIC_RELAXED);
}

static int has_conflict(const work *w) {
    int any = w->n_conflicts;
    for (int64_t i = 0; i < w->mesh->n_elements && w->mesh->part && !any; i++)
        any = w->boundary->sign[i] == CONFLICT;
    return any;
}

/** Roots, parities and conflicts of the components, of which other processes may have parts. */
static int find_components(work *w, const pl_incidence *incidence, int threads,
                           planish_error *error) {
    const int64_t m = w->mesh->n_elements;
    pl_parallel_for(threads, m, CHUNK, start_components, w);
    int status = pl_facets_match(w->mesh, incidence, NULL, threads, join_facets, w, error);
    if (!status && w->n_conflicts)
        pl_parallel_for(threads, m, CHUNK, mark_roots, w);
    if (!status)
        pl_parallel_for(threads, m, CHUNK, link_chunk, w);
    if (!status && w->mesh->part) {
        w->settlement.conflict = w->boundary->sign;
        status = pl_components_settle(w->mesh, incidence, w->link, &w->settlement, error);
    }
    if (!status && has_conflict(w))
        status = pl_facets_match(w->mesh, incidence, NULL, threads, hold_conflicts, w, error);
    return status;
}

static int orient_components(work *w, const pl_incidence *incidence, int threads,
                             planish_error *error) {
    const int64_t m = w->mesh->n_elements;
    w->link = pl_alloc(m, sizeof *w->link);
    w->measure = pl_alloc(m, sizeof *w->measure);
    if (!w->link || !w->measure)
        return pl_fail_memory(error, "the components of the mesh");
    int status = find_components(w, incidence, threads, error);
    if (!status && !w->mesh->part)
        status = find_wrapped(w, threads, error);
    if (status)
        return status;
    find_anchor(w);
    pl_parts_update(NULL, w->boundary->on_boundary, sizeof *w->boundary->on_boundary);
    w->of_boundary = w->frame;
    if (w->has_anchor)
        status =
            pl_frame_create(w->mesh, w->boundary->on_boundary, threads, &w->of_boundary, error);
    if (status)
        return status;
    pl_parallel_for(threads, m, CHUNK, measure_chunk, w);
    status = pl_components_sum(w->mesh, w->link, w->mesh->part ? &w->settlement : NULL, w->measure,
                               &w->boundary->n_components, error);
    if (!status && !turn_flat(w))
        status = pl_fail_memory(error, "the components of the mesh");
    if (!status && !w->mesh->part)
        status = let_elements_decide(w, error);
    if (!status)
        pl_parallel_for(threads, m, CHUNK, sign_chunk, w);
    return status;
}

/* ---- orientation -------------------------------------------------------------------------- */

int pl_orientation_guess(const planish_mesh *mesh, int threads, pl_boundary *boundary,
                         planish_error *error) {
    int64_t m = mesh->n_elements;
    work w = {.mesh = mesh, .boundary = boundary};
    int status = pl_frame_create(mesh, NULL, threads, &w.frame, error);
    if (status)
        return status;
    pl_parallel_for(threads, m, CHUNK, count_chunk, &w);
    w.n_not_positive = pl_parts_any(w.n_not_positive > 0);
    w.n_not_negative = pl_parts_any(w.n_not_negative > 0);
    boundary->is_guess = w.n_not_positive == 0 || w.n_not_negative == 0;
    if (w.n_not_negative > 0)
        return PLANISH_OK;
    boundary->sign = pl_alloc(m, sizeof *boundary->sign);
    if (!boundary->sign)
        return pl_fail_memory(error, "the orientation of the elements");
    boundary->n_reversed = m;
    for (int64_t i = 0; mesh->part && i < m; i++)
        boundary->n_reversed -= !mesh->part->is_counted[i];
    pl_parallel_for(threads, m, CHUNK, set_negative, &w);
    return PLANISH_OK;
}

int pl_orientation_create(const planish_mesh *mesh, const pl_incidence *incidence, int threads,
                          pl_boundary *boundary, planish_error *error) {
    work w = {.mesh = mesh, .boundary = boundary};
    int status = pl_frame_create(mesh, NULL, threads, &w.frame, error);
    if (status)
        return status;
    if (!boundary->sign)
        boundary->sign = pl_alloc(mesh->n_elements, sizeof *boundary->sign);
    if (!boundary->sign)
        return pl_fail_memory(error, "the orientation of the elements");
    boundary->is_guess = 0;
    boundary->n_reversed = 0;
    status = orient_components(&w, incidence, threads, error);
    pl_free(w.link);
    pl_free(w.measure);
    if (!status && boundary->n_wrapped > 0)
        boundary->flags = w.flags;
    else
        pl_free(w.flags);
    pl_settlement_destroy(&w.settlement);
    if (!status && !w.any_reversed) {
        pl_free(boundary->sign);
        boundary->sign = NULL;
    }
    return status;
}
