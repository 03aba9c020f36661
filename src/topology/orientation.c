/* orientation: which order of its nodes each element has.
 *
 * Neighbours traverse their common facet in opposite directions: that decides the orientation of a
 * component of elements but for one sign, which is that of the component's summed measure. Usually
 * the whole file agrees, and one look at the measures is enough; otherwise the components are
 * found by a union-find structure that carries the parity between an element and its root.
 *
 * A component in which no choice satisfies all facets (a Moebius strip, or a file that is folded on
 * itself) keeps the file's order, and the nodes of the facets that contradict it are held.
 */
#include "topology/orientation.h"

#include "base/fetch.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "topology/facets.h"
#include "topology/frame.h"

#include <string.h>

enum { CHUNK = 8192 }; /* elements that one thread takes at a time */

/** The work on one mesh. Counters and marks are written from several threads. */
typedef struct work {
    const planish_mesh *mesh;
    pl_boundary *boundary;
    pl_frame frame;
    int64_t n_not_positive, n_not_negative; /* elements of such a measure */
    uint32_t *link; /* [m] parent << 1 | parity: 1 if the order is opposite to the parent's; parents
                       have smaller numbers, and a root is its own parent */
    double *measure; /* [m] of the elements in their component's order; of a root, the sum */
    int64_t anchor;  /* a node on the boundary, or -1 */
    int n_conflicts; /* facets at which the parities contradict one another: some, or 0 */
} work;

/** In boundary->sign until the signs are known: what is known of an element's component. */
enum { ORIENTABLE = 0, CONFLICT = 1 };

static inline double measure_at(int dim, const work *w, const double *const x[]) {
    double edges[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edges[j][d] = pl_frame_difference(&w->frame, x[j + 1][d], x[0][d]);
    return pl_determinant_of_edges(dim, (const double(*)[3])edges);
}

static inline double measure_of(int dim, const work *w, int64_t element) {
    const int32_t *node = w->mesh->elements + element * (dim + 1);
    const double *x[4];
    for (int j = 0; j <= dim; j++)
        x[j] = w->mesh->coordinates + (int64_t)node[j] * dim;
    return measure_at(dim, w, x);
}

/** The same with the interior nodes at the anchor. The sum over a component does not depend on
 * where they are, but its rounding does: they may have been thrown far out of the domain. */
static inline double anchored_measure_of(int dim, const work *w, int64_t element) {
    const int32_t *node = w->mesh->elements + element * (dim + 1);
    const double *x[4];
    for (int j = 0; j <= dim; j++) {
        int64_t at = w->boundary->on_boundary[node[j]] || w->anchor < 0 ? node[j] : w->anchor;
        x[j] = w->mesh->coordinates + at * dim;
    }
    return measure_at(dim, w, x);
}

/* ---- the usual case: everybody agrees ----------------------------------------------------- */

enum { AHEAD = 8 }; /* elements whose nodes are asked for before they are needed */

static inline void count_signs(work *w, int dim, int64_t begin, int64_t end) {
    int64_t not_positive = 0, not_negative = 0;
    for (int64_t i = begin; i < end; i++) {
        if (i + AHEAD < end)
            pl_fetch_nodes(dim, w->mesh->elements, w->mesh->coordinates, i + AHEAD);
        double measure = measure_of(dim, w, i);
        not_positive += !(measure > 0);
        not_negative += !(measure < 0);
    }
    __atomic_fetch_add(&w->n_not_positive, not_positive, __ATOMIC_RELAXED);
    __atomic_fetch_add(&w->n_not_negative, not_negative, __ATOMIC_RELAXED);
}

static void count_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    if (w->mesh->dim == 3)
        count_signs(w, 3, begin, end);
    else
        count_signs(w, 2, begin, end);
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

static void join_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets) {
    work *w = context;
    (void)node;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (!pl_facet_joins(facet))
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
static void hold_conflicts(void *context, int32_t node, const pl_facet *facets, int32_t n_facets) {
    work *w = context;
    uint8_t *held = w->boundary->on_boundary;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (!pl_facet_joins(facet) || facet->parity[0] != facet->parity[1] ||
            !is_conflicting(w, facet->element[0]))
            continue;
        __atomic_store_n(held + node, 1, __ATOMIC_RELAXED);
        for (int i = 0; i < 2 && facet->node[i] >= 0; i++)
            __atomic_store_n(held + facet->node[i], 1, __ATOMIC_RELAXED);
    }
}

/* ---- signs of components ------------------------------------------------------------------ */

static int64_t find_anchor(const work *w) {
    int64_t i = 0;
    while (i < w->mesh->n_nodes && !w->boundary->on_boundary[i])
        i++;
    return i < w->mesh->n_nodes ? i : -1;
}

/** Link every element to its root, and measure it in the order of its component. */
static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        uint32_t parity = 0, root = find_root(w, (uint32_t)i, &parity);
        const int conflict = w->boundary->sign[root] == CONFLICT, dim = w->mesh->dim;
        if (conflict)
            parity = 0;
        __atomic_store_n(w->link + i, root << 1 | parity, __ATOMIC_RELAXED);
        double measure = conflict ? measure_of(dim, w, i) : anchored_measure_of(dim, w, i);
        w->measure[i] = parity ? -measure : measure;
    }
}

/** Sum the measures of every component in the order of the elements, at its root: the first of
 *  them, so that its sum is complete only behind all others. Serial: one addition per element. */
static void sum_measures(work *w) {
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        int64_t root = w->link[i] >> 1;
        if (root == i)
            w->boundary->n_components++;
        else
            w->measure[root] += w->measure[i];
    }
}

static void sign_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    int64_t n_reversed = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int negative = w->measure[w->link[i] >> 1] < 0;
        int reversed = negative ^ (int)(w->link[i] & 1);
        w->boundary->sign[i] = reversed ? -1 : 1;
        n_reversed += reversed;
    }
    __atomic_fetch_add(&w->boundary->n_reversed, n_reversed, __ATOMIC_RELAXED);
}

static int orient_components(work *w, const pl_incidence *incidence, int threads,
                             planish_error *error) {
    int64_t m = w->mesh->n_elements;
    w->link = pl_alloc(m, sizeof *w->link);
    if (!w->link)
        return pl_fail_memory(error, "the components of the mesh");
    pl_parallel_for(threads, m, CHUNK, start_components, w);
    int status = pl_facets_match(w->mesh, incidence, NULL, threads, join_facets, w, error);
    if (!status && w->n_conflicts) {
        pl_parallel_for(threads, m, CHUNK, mark_roots, w);
        status = pl_facets_match(w->mesh, incidence, NULL, threads, hold_conflicts, w, error);
    }
    if (status)
        return status;
    w->measure = pl_alloc(m, sizeof *w->measure);
    if (!w->measure)
        return pl_fail_memory(error, "the components of the mesh");
    w->anchor = find_anchor(w);
    pl_parallel_for(threads, m, CHUNK, measure_chunk, w);
    sum_measures(w);
    pl_parallel_for(threads, m, CHUNK, sign_chunk, w);
    return PLANISH_OK;
}

/* ---- orientation -------------------------------------------------------------------------- */

int pl_orientation_guess(const planish_mesh *mesh, int threads, pl_boundary *boundary,
                         planish_error *error) {
    int64_t m = mesh->n_elements;
    work w = {.mesh = mesh, .boundary = boundary};
    int status = pl_frame_create(mesh, threads, &w.frame, error);
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
    int status = pl_frame_create(mesh, threads, &w.frame, error);
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
    if (!status && boundary->n_reversed == 0) {
        pl_free(boundary->sign);
        boundary->sign = NULL;
    }
    return status;
}
