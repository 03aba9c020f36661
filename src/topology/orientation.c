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
#include "topology/topology.h"

#include "base/context.h"
#include "geometry/fetch.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "topology/facets.h"
#include "topology/frame.h"

#include <inttypes.h>
#include <string.h>

enum { CHUNK = 8192 }; /* elements that one thread takes at a time */

/** The signs of one mesh. Counters and marks are written from several threads. */
typedef struct signs {
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
    uint8_t *flags;   /* [m] PL_WRAPPED, ..; NULL in a mesh in parts */
    pl_settlement settlement; /* in a mesh in parts */
    int any_reversed;
    int n_conflicts; /* facets at which the parities contradict one another: some, or 0 */
} signs;

/** Values of boundary->sign until the signs are known: about an element's component. */
enum { ORIENTABLE = 0, CONFLICT = 1 };

/** Measure an element in units of frame. anchor: the place of nodes that are not on the boundary;
 *  NULL: where they are. */
static inline double measure_of(int dim, const signs *s, const pl_frame *frame,
                                const double *anchor, int64_t element) {
    const int32_t *node = s->mesh->elements + element * (dim + 1);
    const double *x[4];
    double edges[3][3];
    for (int j = 0; j <= dim; j++)
        x[j] = anchor && !s->boundary->on_boundary[node[j]]
                   ? anchor
                   : s->mesh->coordinates + (int64_t)node[j] * dim;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edges[j][d] = pl_frame_difference(frame, x[j + 1][d], x[0][d]);
    return pl_determinant_of_edges(dim, (const double(*)[3])edges);
}

/* ---- the usual case: everybody agrees ----------------------------------------------------- */

enum { AHEAD = 8 }; /* elements whose nodes are asked for before they are needed */

static inline void count_signs(signs *s, int dim, const pl_frame *frame, int64_t begin,
                               int64_t end) {
    int64_t not_positive = 0, not_negative = 0;
    for (int64_t i = begin; i < end; i++) {
        if (i + AHEAD < end)
            pl_fetch_nodes(dim, s->mesh->elements, s->mesh->coordinates, i + AHEAD);
        const double measure = measure_of(dim, s, frame, NULL, i);
        not_positive += !(measure > 0);
        not_negative += !(measure < 0);
    }
    __atomic_fetch_add(&s->n_not_positive, not_positive, __ATOMIC_RELAXED);
    __atomic_fetch_add(&s->n_not_negative, not_negative, __ATOMIC_RELAXED);
}

static void count_chunk(void *context, int64_t begin, int64_t end, int thread) {
    signs *s = context;
    pl_frame plain;
    (void)thread;
    const int is_plain = pl_frame_is_plain(&s->frame, &plain);
    if (s->mesh->dim == 2)
        count_signs(s, 2, &s->frame, begin, end);
    else if (is_plain)
        count_signs(s, 3, &plain, begin, end);
    else
        count_signs(s, 3, &s->frame, begin, end);
}

/* ---- components --------------------------------------------------------------------------- */

static int replace(signs *s, uint32_t element, uint32_t expected, uint32_t desired) {
    return __atomic_compare_exchange_n(s->link + element, &expected, desired, 0, __ATOMIC_RELAXED,
                                       __ATOMIC_RELAXED);
}

/** Root of element; *parity is flipped if their orders are opposite. Shortens the path: a link that
 *  another thread has changed meanwhile says the same, so that losing the race does no harm. */
static uint32_t find_root(signs *s, uint32_t element, uint32_t *parity) {
    for (;;) {
        const uint32_t up = __atomic_load_n(s->link + element, __ATOMIC_RELAXED), parent = up >> 1;
        if (parent == element)
            return element;
        const uint32_t next = __atomic_load_n(s->link + parent, __ATOMIC_RELAXED);
        if (next >> 1 != parent)
            replace(s, element, up, next ^ (up & 1));
        *parity ^= up & 1;
        element = parent;
    }
}

/** Join the components of a and b, whose orders are opposite if parity is 1. Returns 0 if they were
 *  joined before in the other way. The smaller root stays one, so that the roots in the end are
 *  the smallest elements of their components, whatever the order of the calls. */
static int join(signs *s, uint32_t a, uint32_t b, uint32_t parity) {
    for (;;) {
        uint32_t total = parity;
        uint32_t root_a = find_root(s, a, &total), root_b = find_root(s, b, &total);
        if (root_a == root_b)
            return total == 0;
        uint32_t low = root_a < root_b ? root_a : root_b, high = root_a ^ root_b ^ low;
        if (replace(s, high, high << 1, low << 1 | total))
            return 1;
    }
}

static void start_components(void *context, int64_t begin, int64_t end, int thread) {
    signs *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        s->link[i] = (uint32_t)i << 1;
    memset(s->boundary->sign + begin, ORIENTABLE, (size_t)(end - begin));
}

static void join_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                        int thread) {
    signs *s = context;
    (void)thread;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (!pl_facet_joins(facet) || !pl_facet_is_here(s->mesh->part, node, facet))
            continue;
        uint32_t parity = facet->parity[0] == facet->parity[1];
        if (!join(s, (uint32_t)facet->element[0], (uint32_t)facet->element[1], parity)) {
            __atomic_store_n(s->boundary->sign + facet->element[0], CONFLICT, __ATOMIC_RELAXED);
            __atomic_store_n(&s->n_conflicts, 1, __ATOMIC_RELAXED);
        }
    }
}

/** Hold the nodes of facets that contradict the file's order in a component that keeps it. */
static void hold_conflicts(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                           int thread) {
    signs *s = context;
    (void)thread;
    uint8_t *held = s->boundary->on_boundary;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        uint32_t parity = 0;
        if (!pl_facet_joins(facet) || !pl_facet_is_here(s->mesh->part, node, facet) ||
            facet->parity[0] != facet->parity[1] ||
            s->boundary->sign[find_root(s, (uint32_t)facet->element[0], &parity)] != CONFLICT)
            continue;
        pl_set_flag(held + node, 1);
        for (int i = 0; i < 2 && facet->node[i] >= 0; i++)
            pl_set_flag(held + facet->node[i], 1);
    }
}

/** Link every element to its root, and hand its conflict on to the root, where the whole component
 *  finds it. Which elements saw the conflict depends on the threads; that the component has one
 *  does not. */
static void link_chunk(void *context, int64_t begin, int64_t end, int thread) {
    signs *s = context;
    int8_t *sign = s->boundary->sign;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        uint32_t parity = 0, root = find_root(s, (uint32_t)i, &parity);
        __atomic_store_n(s->link + i, root << 1 | parity, __ATOMIC_RELAXED);
        if (__atomic_load_n(sign + i, __ATOMIC_RELAXED) == CONFLICT)
            __atomic_store_n(sign + root, CONFLICT, __ATOMIC_RELAXED);
    }
}

/** Find roots, parities and conflicts of the components, of which other processes may have parts,
 *  and hold the nodes at conflicts. */
static int find_components(signs *s, const pl_incidence *incidence, int threads,
                           planish_error *error) {
    const planish_mesh *mesh = s->mesh;
    const int64_t m = mesh->n_elements;
    pl_parallel_for(threads, m, CHUNK, start_components, s);
    int status = pl_facets_match(mesh, incidence, NULL, threads, join_facets, s, error);
    if (status)
        return status;
    pl_parallel_for(threads, m, CHUNK, link_chunk, s);
    if (mesh->part) {
        s->settlement.conflict = s->boundary->sign;
        status = pl_components_settle(mesh, incidence, s->link, &s->settlement, error);
        for (int64_t i = 0; i < m && !s->n_conflicts; i++)
            s->n_conflicts = s->boundary->sign[i] == CONFLICT;
    }
    if (!status && s->n_conflicts)
        status = pl_facets_match(mesh, incidence, NULL, threads, hold_conflicts, s, error);
    return status;
}

/* ---- signs of components ------------------------------------------------------------------ */

/** The first node on the boundary. */
static void find_anchor(signs *s) {
    const planish_part *part = s->mesh->part;
    const size_t size = (size_t)s->mesh->dim * sizeof *s->anchor;
    int64_t i = 0, place[3] = {0, 0, 0};
    while (i < s->mesh->n_nodes && !(s->boundary->on_boundary[i] && pl_is_own(part, i)))
        i++;
    const int64_t number = i == s->mesh->n_nodes ? INT64_MAX : part ? part->node_number[i] : i;
    int64_t first = number;
    pl_parts_smallest_integers(&first, 1);
    s->has_anchor = first < INT64_MAX;
    if (first == number && s->has_anchor)
        memcpy(place, s->mesh->coordinates + i * s->mesh->dim, size);
    pl_parts_add(place, 3); /* bits: those of the others are 0 */
    memcpy(s->anchor, place, sizeof s->anchor);
}

/** Measure every element in the order of its component; its parity is from now on that to it.
 *
 *  Interior nodes are taken to be at the anchor. The sum over a component does not depend on where
 *  they are, but its rounding does, and whether a measure is a number: interior nodes, and nodes of
 *  no element, may have been thrown far out of the domain. Elements that wrap around have no
 *  measure, and so the sum of the others does depend on where the interior nodes are. */
static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    signs *s = context;
    const int dim = s->mesh->dim;
    const double *anchor = s->has_anchor ? s->anchor : NULL;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const uint32_t root = s->link[i] >> 1;
        const int has_conflict = s->boundary->sign[root] == CONFLICT;
        uint32_t opposite = 0;
        double measure = 0;
        if (!has_conflict)
            opposite =
                (s->link[i] & 1) ^ (s->settlement.reversed ? s->settlement.reversed[root] : 0);
        if (has_conflict || (s->flags && s->flags[root] & PL_HAS_WRAPPED))
            measure = measure_of(dim, s, &s->frame, NULL, i);
        else
            measure = measure_of(dim, s, &s->of_boundary, anchor, i);
        if (s->flags && s->flags[i] & PL_WRAPPED)
            measure = 0;
        s->measure[i] = opposite ? -measure : measure;
        s->link[i] = root << 1 | opposite;
    }
}

/** Turn components whose measure is 0 so that the element of the smallest id keeps its order, as it
 *  does in a mesh in parts. */
static int turn_flat(signs *s, planish_error *error) {
    const int64_t m = s->mesh->n_elements;
    int any = 0;
    for (int64_t i = 0; i < m && !any; i++)
        any = s->link[i] >> 1 == i && s->measure[i] == 0;
    if (!any)
        return PLANISH_OK;
    int64_t *least = pl_alloc(m, sizeof *least);
    if (!least)
        return pl_fail_memory(error, "the components of the mesh");
    for (int64_t i = 0; i < m; i++) /* roots are the first of their components */
        least[i] = INT64_MAX;
    for (int64_t i = 0; i < m; i++) {
        const uint32_t root = s->link[i] >> 1;
        const double sum = s->measure[root];
        if (sum != 0 && !(least[root] < INT64_MAX))
            continue;
        const int64_t id = pl_element_id(s->mesh, i);
        if (id >= least[root])
            continue;
        least[root] = id;
        s->measure[root] = s->link[i] & 1 ? -1 : 0;
    }
    pl_free(least);
    return PLANISH_OK;
}

/* ---- elements that wrap around, and components without a boundary ---------------------------- */

/** Mark the components that have a node on the boundary. */
static void mark_bounded(void *context, int64_t begin, int64_t end, int thread) {
    signs *s = context;
    const int k = s->mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *node = s->mesh->elements + i * k;
        int any = 0;
        for (int j = 0; j < k; j++)
            any |= s->boundary->on_boundary[node[j]];
        uint8_t *flags = s->flags + (s->link[i] >> 1);
        if (any && !(__atomic_load_n(flags, __ATOMIC_RELAXED) & PL_HAS_BOUNDARY))
            __atomic_fetch_or(flags, PL_HAS_BOUNDARY, __ATOMIC_RELAXED);
    }
}

/** Find the elements that wrap around, and hold their nodes. */
static int find_wrapped(signs *s, int threads, planish_error *error) {
    const int64_t m = s->mesh->n_elements;
    const int k = s->mesh->dim + 1;
    int64_t n;
    s->flags = pl_alloc_zero(m, sizeof *s->flags);
    if (!s->flags)
        return pl_fail_memory(error, "the components of the mesh");
    pl_parallel_for(threads, m, CHUNK, mark_bounded, s);
    const int status = pl_wrapped_find(s->mesh, s->link, s->boundary->sign, s->flags, &n, error);
    s->boundary->n_wrapped = n;
    if (status || n == 0)
        return status;
    for (int64_t i = 0; i < m; i++)
        for (int j = 0; j < k && s->flags[i] & PL_WRAPPED; j++)
            s->boundary->on_boundary[s->mesh->elements[i * k + j]] = 1;
    return PLANISH_OK;
}

/** Whether the elements of a component may decide by their number. */
static int may_count(const signs *s, int64_t root) {
    return s->boundary->sign[root] != CONFLICT &&
           (s->flags[root] & PL_HAS_WRAPPED || !(s->flags[root] & PL_HAS_BOUNDARY));
}

/* Elements of such a component that overrule the sum, in parts of a hundred. */
enum { OVERRULING = 80 };

/** The sum of signed measures says little of components without a boundary, where it is nothing but
 *  rounding, and where elements wrap around: the number of elements decides where it is telling. */
static int let_elements_decide(signs *s, planish_error *error) {
    const int64_t m = s->mesh->n_elements;
    int64_t n = 0, n_turned = 0;
    for (int64_t i = 0; i < m; i++)
        n += s->link[i] >> 1 == i && may_count(s, i);
    if (n == 0)
        return PLANISH_OK;
    int32_t *voters = pl_alloc_zero(m, sizeof *voters);   /* of each component, at its root */
    int32_t *against = pl_alloc_zero(m, sizeof *against); /* those that contradict its sum */
    const int done = voters && against;
    for (int64_t i = 0; done && i < m; i++) {
        const int64_t root = s->link[i] >> 1;
        if (!may_count(s, root) || s->flags[i] & PL_WRAPPED)
            continue;
        const double drawn = measure_of(s->mesh->dim, s, &s->frame, NULL, i);
        const double measure = s->link[i] & 1 ? -drawn : drawn;
        voters[root]++;
        against[root] += s->measure[root] < 0 ? measure > 0 : measure < 0;
    }
    for (int64_t i = 0; done && i < m; i++) {
        if (voters[i] == 0 || 100 * (int64_t)against[i] < OVERRULING * (int64_t)voters[i])
            continue;
        s->measure[i] = s->measure[i] < 0 ? 1 : -1;
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
    signs *s = context;
    const uint8_t *is_counted = s->mesh->part ? s->mesh->part->is_counted : NULL;
    int64_t n_reversed = 0;
    int any = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int negative = s->measure[s->link[i] >> 1] < 0;
        int reversed = negative ^ (int)(s->link[i] & 1);
        s->boundary->sign[i] = reversed ? -1 : 1;
        n_reversed += reversed && (!is_counted || is_counted[i]);
        any |= reversed;
    }
    __atomic_fetch_add(&s->boundary->n_reversed, n_reversed, __ATOMIC_RELAXED);
    __atomic_fetch_or(&s->any_reversed, any, __ATOMIC_RELAXED);
}

static int orient_components(signs *s, const pl_incidence *incidence, int threads,
                             planish_error *error) {
    const planish_mesh *mesh = s->mesh;
    uint8_t *on_boundary = s->boundary->on_boundary;
    const int64_t m = mesh->n_elements;
    s->link = pl_alloc(m, sizeof *s->link);
    s->measure = pl_alloc(m, sizeof *s->measure);
    if (!s->link || !s->measure)
        return pl_fail_memory(error, "the components of the mesh");
    int status = find_components(s, incidence, threads, error);
    if (!status && !mesh->part)
        status = find_wrapped(s, threads, error);
    if (status)
        return status;
    find_anchor(s);
    pl_parts_update(NULL, on_boundary, sizeof *on_boundary);
    s->of_boundary = s->frame;
    if (s->has_anchor)
        status = pl_frame_create(mesh, on_boundary, threads, &s->of_boundary, error);
    if (status)
        return status;
    pl_parallel_for(threads, m, CHUNK, measure_chunk, s);
    status = pl_components_sum(mesh, s->link, mesh->part ? &s->settlement : NULL, s->measure,
                               &s->boundary->n_components, error);
    if (!status && !mesh->part)
        status = turn_flat(s, error);
    if (!status && !mesh->part)
        status = let_elements_decide(s, error);
    if (!status)
        pl_parallel_for(threads, m, CHUNK, sign_chunk, s);
    return status;
}

/* ---- orientation -------------------------------------------------------------------------- */

int pl_orientation_guess(const planish_mesh *mesh, int threads, pl_boundary *boundary,
                         planish_error *error) {
    int64_t m = mesh->n_elements;
    signs s = {.mesh = mesh, .boundary = boundary};
    int status = pl_frame_create(mesh, NULL, threads, &s.frame, error);
    if (status)
        return status;
    pl_parallel_for(threads, m, CHUNK, count_chunk, &s);
    s.n_not_positive = pl_parts_any(s.n_not_positive > 0);
    s.n_not_negative = pl_parts_any(s.n_not_negative > 0);
    boundary->is_guess = s.n_not_positive == 0 || s.n_not_negative == 0;
    if (s.n_not_negative > 0)
        return PLANISH_OK;
    boundary->sign = pl_alloc(m, sizeof *boundary->sign);
    if (!boundary->sign)
        return pl_fail_memory(error, "the orientation of the elements");
    boundary->n_reversed = m;
    for (int64_t i = 0; mesh->part && i < m; i++)
        boundary->n_reversed -= !mesh->part->is_counted[i];
    memset(boundary->sign, -1, (size_t)m);
    return PLANISH_OK;
}

int pl_orientation_create(const planish_mesh *mesh, const pl_incidence *incidence, int threads,
                          pl_boundary *boundary, planish_error *error) {
    signs s = {.mesh = mesh, .boundary = boundary};
    int status = pl_frame_create(mesh, NULL, threads, &s.frame, error);
    if (status)
        return status;
    if (!boundary->sign)
        boundary->sign = pl_alloc(mesh->n_elements, sizeof *boundary->sign);
    if (!boundary->sign)
        return pl_fail_memory(error, "the orientation of the elements");
    boundary->is_guess = 0;
    boundary->n_reversed = 0;
    status = orient_components(&s, incidence, threads, error);
    pl_free(s.link);
    pl_free(s.measure);
    if (!status && boundary->n_wrapped > 0)
        boundary->flags = s.flags;
    else
        pl_free(s.flags);
    pl_settlement_destroy(&s.settlement);
    if (!status && !s.any_reversed) {
        pl_free(boundary->sign);
        boundary->sign = NULL;
    }
    return status;
}
