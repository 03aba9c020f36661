/* cell_orientation: which handedness each element of any type has, by its neighbours.
 *
 * Two elements on either side of a facet go around it in opposite directions if they have the same
 * handedness. So elements that facets join have one handedness relative to one another, whatever
 * the order of their nodes and wherever these are; where signs alone were asked, an inverted element
 * would be one of the other handedness. Of each set of joined elements the sign of their summed
 * measure is the right one, which depends on the set's boundary alone: also where most are inverted.
 * Where that tells nothing, as without a boundary, it is that of most. Elements that nothing joins,
 * as where each has nodes of its own, have that of most of their type.
 *
 * Facets are listed at their lowest nodes, and compared there, on all threads. Then elements are
 * joined one after the other: in a mesh that has no orientation their order decides.
 */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "geometry/simplex.h"
#include "topology/cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    FACET_NODES = 4,
    FACETS = PL_CELL_FACET_PLACES,
    FEW = 256,        /* facets at a node that are compared one by one; more are sorted */
    ROUNDS = 4,       /* in which all facets are compared */
    CHUNK = 4096,     /* elements, */
    NODE_CHUNK = 1024 /* or nodes, that one thread looks at at a time */
};

/** Facet as it is listed at its lowest node and compared: the other nodes around, from the lower one
 *  beside that; -1: none. Elements are listed in any order, so that what is read later lies together. */
typedef struct facet {
    int32_t element; /* -1: nothing is left of the facet */
    int32_t node[FACET_NODES - 1];
    uint8_t place;    /* which of the element's */
    int8_t direction; /* +1: the element goes around it in this order; -1: the other way */
} facet;

/** Sets of elements with one handedness (union-find with parity). */
typedef struct cell_sets {
    const planish_cells *cells;
    const double *coordinates;
    const uint8_t
        *is_inside; /* [n_nodes] facets with such a corner are not listed; NULL: all are */
    int dim;
    int32_t *parent;         /* [n] an element of the same set; itself: it stands for the set */
    int8_t *flip;            /* [n] -1: of the other handedness than parent, else 1 */
    int64_t *end;            /* [n_nodes + 1] where the facets of each lowest node end in listed */
    facet *listed;           /* of nodes from .. to - 1, the first one's from 0 */
    int64_t from, to, begin; /* begin: where the first one's would be if all were listed */
    uint32_t
        *joins;   /* [FACETS * n] 0, or 1 + (element to join << 1 | it has the same handedness) */
    int8_t *sign; /* [n] the result */
    double *measure;            /* [n] dim! times that of each element, by its own order */
    pl_cell_census *census;     /* NULL: not asked for */
    int64_t n_alone, n_crowded; /* facets of one element, of more than two; shared */
} cell_sets;

const pl_cell_type *pl_counted_type(const planish_cells *cells, int dim, int64_t element) {
    const pl_cell_type *type = pl_cell_type_of(cells->type[element]);
    return type && type->shape->dim == dim ? type : NULL;
}

int pl_cell_facet(const planish_cells *cells, int64_t element, int k, int32_t *node) {
    const int8_t *corner = pl_cell_type_of(cells->type[element])->shape->facet[k];
    const int32_t *of_element = cells->node + cells->offset[element];
    int n = 0;
    for (int i = 0; i < FACET_NODES && corner[i] >= 0; i++) {
        const int32_t next = of_element[corner[i]];
        if (n == 0 || (node[n - 1] != next && (node[0] != next)))
            node[n++] = next;
    }
    return n;
}

/** Find facet k of an element. Nodes that are there twice count once. */
static facet find_facet(const cell_sets *s, int64_t element, int k) {
    facet f = {.element = -1, .node = {-1, -1, -1}};
    int32_t around[FACET_NODES];
    const int n = pl_cell_facet(s->cells, element, k, around);
    int lowest = 0;
    if (n < 2 || n < s->dim)
        return f;
    for (int i = 1; i < n; i++)
        lowest = around[i] < around[lowest] ? i : lowest;
    const int32_t next = around[lowest + 1 < n ? lowest + 1 : 0];
    const int32_t last = around[lowest > 0 ? lowest - 1 : n - 1];
    f.element = (int32_t)element;
    f.place = (uint8_t)k;
    /* The ends of an edge have one order, so that its direction is where its lowest node is. */
    f.direction = n == 2 ? (lowest == 0 ? 1 : -1) : next < last ? 1 : -1;
    f.node[0] = next < last ? next : last;
    if (n == 4)
        f.node[1] = around[lowest ^ 2];
    if (n > 2)
        f.node[n - 2] = next < last ? last : next;
    return f;
}

/** Return what stands for the set of an element; *flip: the element's handedness against it. */
static int32_t find_set(cell_sets *s, int32_t element, int *flip) {
    int32_t top = element;
    int total = 1;
    for (; s->parent[top] != top; top = s->parent[top])
        total *= s->flip[top];
    *flip = total;
    while (s->parent[element] != top && element != top) { /* straight to the top from now on */
        const int32_t next = s->parent[element];
        const int own = s->flip[element] < 0 ? -1 : 1;
        s->parent[element] = top;
        s->flip[element] = (int8_t)total;
        total *= own;
        element = next;
    }
    return top;
}

/** Join the sets of two elements, whose handedness is the same (1) or not (-1). Where that is known
 *  to be otherwise, as in a Moebius strip, nothing changes. */
static void join(cell_sets *s, int32_t a, int32_t b, int same) {
    int flip_a, flip_b;
    const int32_t top_a = find_set(s, a, &flip_a), top_b = find_set(s, b, &flip_b);
    if (top_a == top_b)
        return;
    const int32_t low = top_a < top_b ? top_a : top_b, high = top_a < top_b ? top_b : top_a;
    s->parent[high] = low;
    s->flip[high] = (int8_t)(same * flip_a * flip_b);
}

/** Whether all corners of an element are corners of another one of its type. */
static int has_corners(const cell_sets *s, int64_t element, int64_t of) {
    const int32_t *node = s->cells->node + s->cells->offset[element];
    const int32_t *other = s->cells->node + s->cells->offset[of];
    const int n = pl_cell_type_of(s->cells->type[element])->shape->n_corners;
    int n_found = 0;
    for (int i = 0; i < n && n_found == i; i++)
        for (int j = 0; j < n && n_found == i; j++)
            n_found += node[i] == other[j];
    return n_found == n;
}

/** Whether two elements have the same corners, in any order. */
static int is_same(const cell_sets *s, int64_t a, int64_t b) {
    return s->cells->type[a] == s->cells->type[b] && has_corners(s, a, b) && has_corners(s, b, a);
}

/* ---- facets by their lowest nodes --------------------------------------------------------------- */

/** Lowest node of facet k of an element; -1: the facet is not listed. */
static int32_t lowest_of(const cell_sets *s, const pl_cell_shape *shape, int64_t element, int k) {
    const int32_t *node = s->cells->node + s->cells->offset[element];
    int32_t lowest = INT32_MAX;
    for (int i = 0; i < FACET_NODES && shape->facet[k][i] >= 0; i++) {
        const int32_t next = node[shape->facet[k][i]];
        if (s->is_inside && s->is_inside[next])
            return -1;
        lowest = next < lowest ? next : lowest;
    }
    return lowest;
}

/** Count the facets of each lowest node; none joins anything so far. */
static void count_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const cell_sets *s = context;
    (void)thread;
    memset(s->joins + FACETS * begin, 0, (size_t)(FACETS * (end - begin)) * sizeof *s->joins);
    for (int64_t i = begin; i < end; i++) {
        const pl_cell_type *type = pl_counted_type(s->cells, s->dim, i);
        for (int k = 0; type && k < type->shape->n_facets; k++) {
            const int32_t lowest = lowest_of(s, type->shape, i, k);
            if (lowest >= 0)
                __atomic_fetch_add(&s->end[lowest], 1, __ATOMIC_RELAXED);
        }
    }
}

/** Whether an element has a corner whose facets are listed in this round. */
static int is_in_round(const cell_sets *s, const pl_cell_shape *shape, int64_t element) {
    const int32_t *node = s->cells->node + s->cells->offset[element];
    int any = 0;
    for (int i = 0; i < shape->n_corners; i++)
        any |= node[i] >= s->from && node[i] < s->to;
    return any;
}

/** List the facets of some nodes, in any order; their ends become that from where the lists begin. */
static void list_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const cell_sets *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const pl_cell_type *type = pl_counted_type(s->cells, s->dim, i);
        if (!type || !is_in_round(s, type->shape, i))
            continue;
        for (int k = 0; k < type->shape->n_facets; k++) {
            const int32_t lowest = lowest_of(s, type->shape, i, k);
            if (lowest < s->from || lowest >= s->to)
                continue;
            const int64_t at = __atomic_fetch_add(&s->end[lowest], 1, __ATOMIC_RELAXED);
            s->listed[at - s->begin] = find_facet(s, i, k);
        }
    }
}

static int64_t place_of(const facet *f) {
    return FACETS * (int64_t)f->element + f->place;
}

static int is_alike(const facet *a, const facet *b) {
    return memcmp(a->node, b->node, sizeof a->node) == 0;
}

/** Note that a facet is that of an earlier element, the first one that has it. */
static void note_join(const cell_sets *s, const facet *first, const facet *later) {
    const uint32_t same = first->direction != later->direction;
    s->joins[place_of(later)] = 1 + ((uint32_t)first->element << 1 | same);
}

/** Whether an element is another one, or (may_be) has the corners of that; then it is a duplicate. */
static int note_twin(const cell_sets *s, const facet *earlier, const facet *later, int may_be) {
    const int is_twin = earlier->element == later->element ||
                        (may_be && is_same(s, earlier->element, later->element));
    if (is_twin && s->census && s->census->is_duplicate)
        pl_set_flag(&s->census->is_duplicate[later->element], 1);
    return is_twin;
}

/** Note what facet i of a node has to do with earlier ones that are alike, the first of them first[i].
 *  To read the corners of elements takes long. Neighbours go around a facet in opposite directions, and
 *  have only one facet in common; of a duplicate several facets are at its lowest node, side by side. */
static void note_alike(const cell_sets *s, const facet *listed, const int *first, int i,
                       int n_alike) {
    const facet *own = &listed[i], *of = &listed[first[i]];
    const int has_other = i > 0 && own[-1].element == own->element && first[i - 1] < i - 1 &&
                          listed[first[i - 1]].element == of->element;
    const int is_twin = note_twin(s, of, own, has_other || of->direction == own->direction);
    for (int k = first[i] + 1; n_alike > 2 && k < i; k++)
        if (first[k] == first[i])
            note_twin(s, &listed[k], own, 1);
    if (!is_twin)
        note_join(s, of, own);
}

/** Note that so many elements share a facet. */
static void note_sharing(const cell_sets *s, const facet *f, int n) {
    s->census->n_sharing[place_of(f)] = (uint8_t)(n < 3 ? n : 3);
}

/** Count a facet of n elements. */
static void count_facet(const cell_sets *s, int64_t n) {
    cell_sets *shared = (cell_sets *)(uintptr_t)s;
    if (n != 2)
        __atomic_fetch_add(n == 1 ? &shared->n_alone : &shared->n_crowded, 1, __ATOMIC_RELAXED);
}

/** Compare the facets of a node, a few. */
static void compare_few(const cell_sets *s, facet *listed, int n) {
    int first[FEW], n_alike[FEW];
    for (int i = 1; i < n; i++) { /* in order */
        const facet own = listed[i];
        int k = i;
        for (; k > 0 && place_of(&listed[k - 1]) > place_of(&own); k--)
            listed[k] = listed[k - 1];
        listed[k] = own;
    }
    for (int i = 0; i < n; i++) {
        n_alike[i] = 0;
        for (first[i] = 0; first[i] < i; first[i]++)
            if (first[first[i]] == first[i] && is_alike(&listed[first[i]], &listed[i]))
                break;
        n_alike[first[i]]++;
        if (first[i] < i && listed[i].element >= 0)
            note_alike(s, listed, first, i, n_alike[first[i]]);
    }
    for (int i = 0; s->census && i < n; i++) {
        if (listed[i].element < 0)
            continue;
        note_sharing(s, &listed[i], n_alike[first[i]]);
        if (first[i] == i)
            count_facet(s, n_alike[i]);
    }
}

/** Order of facets by nodes, then as they are numbered. */
static int order_of(const void *a, const void *b) {
    const facet *f = a, *g = b;
    const int order = memcmp(f->node, g->node, sizeof f->node);
    const int64_t way = place_of(f) - place_of(g);
    return order ? order : way < 0 ? -1 : way > 0;
}

/** Compare the facets of a node with many: they are sorted first. */
static void compare_many(const cell_sets *s, facet *listed, int64_t n) {
    qsort(listed, (size_t)n, sizeof *listed, order_of);
    for (int64_t i = 0, end; i < n; i = end) {
        for (end = i + 1; end < n && is_alike(&listed[i], &listed[end]);)
            end++;
        if (listed[i].element < 0)
            continue;
        for (int64_t k = i + 1; k < end; k++) {
            for (int64_t j = k - 1; j > i && j > k - FEW; j--)
                note_twin(s, &listed[j], &listed[k], 1);
            if (!note_twin(s, &listed[i], &listed[k], 1))
                note_join(s, &listed[i], &listed[k]);
        }
        for (int64_t k = i; s->census && k < end; k++)
            note_sharing(s, &listed[k], end - i < 3 ? (int)(end - i) : 3);
        if (s->census)
            count_facet(s, end - i);
    }
}

static void compare_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const cell_sets *s = context;
    (void)thread;
    for (int64_t node = s->from + begin; node < s->from + end; node++) {
        const int64_t from = node > 0 ? s->end[node - 1] : 0, n = s->end[node] - from;
        facet *listed = s->listed + (from - s->begin);
        if (n <= FEW)
            compare_few(s, listed, (int)n);
        else
            compare_many(s, listed, n);
    }
}

/** Join the elements at both sides of all facets. */
static void join_all(cell_sets *s) {
    for (int64_t i = 0; i < s->cells->n; i++) {
        s->parent[i] = (int32_t)i;
        s->flip[i] = 1;
        for (int k = 0; k < FACETS; k++) {
            const uint32_t join_with = s->joins[FACETS * i + k];
            if (join_with > 0)
                join(s, (int32_t)((join_with - 1) >> 1), (int32_t)i, (join_with - 1) & 1 ? 1 : -1);
        }
    }
}

/* ---- signs ------------------------------------------------------------------------------------- */

/** Sign of an element by its corners together; 0: flat. */
static int sign_by_corners(const cell_sets *s, int64_t element) {
    const pl_cell_shape *shape = pl_counted_type(s->cells, s->dim, element)->shape;
    const int32_t *node = s->cells->node + s->cells->offset[element];
    double sum = 0;
    for (int c = 0; c < shape->n_measured; c++) {
        double edges[3][3] = {{0}};
        const double *from = s->coordinates + (int64_t)node[c] * s->dim;
        for (int j = 0; j < s->dim; j++)
            pl_subtract(s->dim, s->coordinates + (int64_t)node[shape->neighbour[c][j]] * s->dim,
                        from, edges[j]);
        sum += pl_determinant_of_edges(s->dim, edges);
    }
    return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

/** dim! times what facet k of an element adds to its measure: of the pyramid from the element's first
 *  node to the facet. A quadrilateral is cut along either diagonal, for the mean of both. */
static double facet_measure(const cell_sets *s, const pl_cell_shape *shape, const int32_t *node,
                            int k) {
    const int8_t *corner = shape->facet[k];
    const int n = s->dim == 2 ? 2 : corner[3] < 0 ? 3 : 4;
    const double *origin = s->coordinates + (int64_t)node[0] * s->dim;
    double x[4][3] = {{0}}, edges[3][3] = {{0}};
    int has_origin = 0;
    for (int j = 0; j < n; j++) {
        pl_subtract(s->dim, s->coordinates + (int64_t)node[corner[j]] * s->dim, origin, x[j]);
        has_origin |= corner[j] == 0;
    }
    if (n < 4)
        return has_origin ? 0 : pl_determinant_of_edges(s->dim, x);
    for (int d = 0; d < 3; d++) {
        edges[0][d] = 0.25 * (x[0][d] + x[1][d] + x[2][d] + x[3][d]);
        edges[1][d] = x[2][d] - x[0][d];
        edges[2][d] = x[3][d] - x[1][d];
    }
    return pl_determinant_of_edges(3, edges);
}

/** dim! times the measure of an element. */
static double measure_of(const cell_sets *s, int64_t element) {
    const pl_cell_shape *shape = pl_counted_type(s->cells, s->dim, element)->shape;
    const int32_t *node = s->cells->node + s->cells->offset[element];
    double sum = 0;
    for (int k = 0; k < shape->n_facets; k++)
        sum += facet_measure(s, shape, node, k);
    return sum;
}

/** Surplus of positive signs among the elements of a set, and their number; their measures, and these
 *  without signs. */
typedef struct set_count {
    int64_t surplus, n;
    double measure, size;
} set_count;

/* A summed measure tells the sign where it is more than this part of the measures without signs. */
#define TELLING 1e-9

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const cell_sets *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        s->measure[i] = pl_counted_type(s->cells, s->dim, i) ? measure_of(s, i) : 0;
}

static void find_own_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const cell_sets *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        s->sign[i] = (int8_t)(pl_counted_type(s->cells, s->dim, i) ? sign_by_corners(s, i) : 0);
}

/** Number the sets: parent becomes the number of each element's set, and flip what it is against
 *  the set. What stands for a set is its lowest element. Returns how many there are. */
static int64_t number_sets(cell_sets *s) {
    int32_t n = 0;
    for (int64_t i = 0; i < s->cells->n; i++) {
        const int32_t above = s->parent[i];
        if (above == i) {
            s->parent[i] = n++;
            continue;
        }
        s->flip[i] = (int8_t)(s->flip[i] * s->flip[above]);
        s->parent[i] = s->parent[above];
    }
    return n;
}

/** Measure all sets. One element after the other, so that sums are the same on any number of threads. */
static void measure_sets(const cell_sets *s, set_count *count) {
    for (int64_t i = 0; i < s->cells->n; i++) {
        set_count *set = &count[s->parent[i]];
        set->n += pl_counted_type(s->cells, s->dim, i) != NULL;
        set->measure += s->flip[i] * s->measure[i];
        set->size += fabs(s->measure[i]);
    }
}

static int tells(const set_count *set) {
    return fabs(set->measure) > TELLING * set->size;
}

/** Count the signs of the elements of all sets; of_type: the surplus of positive ones by types. */
static void count_signs(const cell_sets *s, set_count *count, int64_t *of_type) {
    for (int64_t i = 0; i < s->cells->n; i++) {
        of_type[s->cells->type[i]] += s->sign[i];
        count[s->parent[i]].surplus += s->flip[i] * s->sign[i];
    }
}

/** Find the sign of each element by the measure of its set; where that does not tell, by the elements'
 *  own signs, which are looked at only then. */
static int find_signs(cell_sets *s, int threads) {
    int64_t of_type[UINT8_MAX + 1] = {0};
    const int64_t n = s->cells->n, n_sets = number_sets(s);
    s->measure = pl_alloc(n, sizeof *s->measure);
    set_count *count = pl_alloc_zero(n_sets, sizeof *count);
    const int is_there = s->measure && count;
    int all_tell = 1;
    if (is_there) {
        pl_parallel_for(threads, n, CHUNK, measure_chunk, s);
        measure_sets(s, count);
    }
    for (int64_t k = 0; is_there && k < n_sets; k++)
        all_tell &= count[k].n == 0 || (count[k].n > 1 && tells(&count[k]));
    if (!all_tell) {
        pl_parallel_for(threads, n, CHUNK, find_own_chunk, s);
        count_signs(s, count, of_type);
    }
    for (int64_t i = 0; is_there && i < n; i++) {
        const set_count *set = &count[s->parent[i]];
        const pl_cell_type *type = pl_counted_type(s->cells, s->dim, i);
        const int is_alone = set->n == 1 && type && type->shape->n_simplices != 1;
        const int64_t surplus = is_alone ? of_type[s->cells->type[i]] : set->surplus;
        const int is_positive = tells(set) && !is_alone ? set->measure > 0 : surplus >= 0;
        s->sign[i] = (int8_t)(is_positive ? s->flip[i] : -s->flip[i]);
    }
    pl_free(s->measure);
    pl_free(count);
    return is_there;
}

/** Go on to the nodes whose facets are listed next: as many as have so many facets, one at least; end is
 *  where each one's begin. Returns how many facets these are. */
static int64_t next_nodes(cell_sets *s, int64_t n_nodes, int64_t most) {
    s->from = s->to;
    s->begin = s->end[s->from];
    while (s->to < n_nodes && (s->to == s->from || s->end[s->to + 1] - s->begin <= most))
        s->to++;
    return s->end[s->to] - s->begin;
}

/** Find out which elements facets join. In rounds, as listed facets take more memory than all else. */
static int find_joins(cell_sets *s, int64_t n_nodes, int threads) {
    const int64_t n = s->cells->n;
    int64_t most = 0, room = 0;
    s->end = pl_alloc_zero(n_nodes + 1, sizeof *s->end);
    if (s->end && s->joins) {
        pl_parallel_for(threads, n, CHUNK, count_chunk, s);
        most = pl_prefix_sum(threads, n_nodes, s->end) / ROUNDS + FEW;
        for (s->to = 0; s->to < n_nodes;) {
            const int64_t own = next_nodes(s, n_nodes, most);
            room = own > room ? own : room;
        }
        s->listed = pl_alloc(room, sizeof *s->listed);
    }
    const int is_there = s->listed != NULL;
    for (s->to = 0; is_there && s->to < n_nodes;) {
        next_nodes(s, n_nodes, most);
        pl_parallel_for(threads, n, CHUNK, list_chunk, s);
        pl_parallel_for(threads, s->to - s->from, NODE_CHUNK, compare_chunk, s);
    }
    pl_free(s->end);
    pl_free(s->listed);
    return is_there;
}

/** Find the signs, and the census if there is one. */
static int orient(cell_sets *s, int64_t n_nodes, int threads, planish_error *error) {
    const int64_t n = s->cells->n;
    s->joins = pl_alloc(FACETS * n, sizeof *s->joins);
    int is_there = find_joins(s, n_nodes, threads);
    s->parent = pl_alloc(is_there ? n : -1, sizeof *s->parent);
    s->flip = pl_alloc(is_there ? n : -1, sizeof *s->flip);
    is_there = is_there && s->parent && s->flip;
    if (is_there) {
        join_all(s);
        is_there = find_signs(s, threads);
    }
    pl_free(s->parent);
    pl_free(s->flip);
    return is_there ? PLANISH_OK : pl_fail_memory(error, "the orientation of elements");
}

int pl_orient_cells(const planish_cells *cells, int dim, int64_t n_nodes, const double *coordinates,
                    int threads, int8_t *sign, planish_error *error) {
    cell_sets s = {.cells = cells, .coordinates = coordinates, .dim = dim, .sign = sign};
    const int status = orient(&s, n_nodes, threads, error);
    pl_free(s.joins);
    return status;
}

/* ---- the census -------------------------------------------------------------------------------- */

/** Whether the elements at facet k of an element, the later of two, contradict each other. */
static int is_contradicted(const cell_sets *s, int64_t element, int k) {
    const uint32_t with = s->joins[FACETS * element + k];
    return with > 0 && s->sign[(with - 1) >> 1] * s->sign[element] != ((with - 1) & 1 ? 1 : -1);
}

/** Hold the corners of duplicates, and of facets that two elements do not share as they should. */
static void hold_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const cell_sets *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const pl_cell_type *type = pl_counted_type(s->cells, s->dim, i);
        const int32_t *node = s->cells->node + s->cells->offset[i];
        for (int j = 0; s->census->is_duplicate[i] && j < type->shape->n_corners; j++)
            pl_set_flag(&s->census->on_boundary[node[j]], 1);
        for (int k = 0; type && k < type->shape->n_facets; k++) {
            const int n = s->census->n_sharing[FACETS * i + k];
            for (int j = 0; (n == 1 || n > 2 || is_contradicted(s, i, k)) && j < FACET_NODES; j++)
                if (type->shape->facet[k][j] >= 0)
                    pl_set_flag(&s->census->on_boundary[node[type->shape->facet[k][j]]], 1);
        }
    }
}

int pl_cell_census_find(const planish_cells *cells, int dim, int64_t n_nodes,
                        const double *coordinates, int threads, pl_cell_census *census,
                        planish_error *error) {
    *census = (pl_cell_census){.sign = pl_alloc(cells->n, sizeof *census->sign),
                               .n_sharing = pl_alloc_zero(FACETS * cells->n, 1),
                               .on_boundary = pl_alloc_zero(n_nodes, 1),
                               .is_duplicate = pl_alloc_zero(cells->n, 1)};
    cell_sets s = {.cells = cells,
                   .coordinates = coordinates,
                   .dim = dim,
                   .sign = census->sign,
                   .census = census};
    int status = census->sign && census->n_sharing && census->on_boundary && census->is_duplicate
                     ? orient(&s, n_nodes, threads, error)
                     : pl_fail_memory(error, "the facets of elements");
    if (!status)
        pl_parallel_for(threads, cells->n, CHUNK, hold_chunk, &s);
    census->n_boundary_facets = s.n_alone;
    census->n_nonmanifold_facets = s.n_crowded;
    for (int64_t i = 0; !status && i < cells->n; i++)
        census->n_duplicate_elements += census->is_duplicate[i];
    pl_free(s.joins);
    if (status)
        pl_cell_census_destroy(census);
    return status;
}

/** Turn joins into what pl_cell_facets_find gives: in place. */
static void note_first_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const cell_sets *s = context;
    int32_t *with = (int32_t *)s->joins;
    (void)thread;
    for (int64_t i = FACETS * begin; i < FACETS * end; i++)
        with[i] = s->joins[i] > 0 ? (int32_t)((s->joins[i] - 1) >> 1) : -1;
}

int pl_cell_facets_find(const planish_cells *cells, int dim, int64_t n_nodes,
                        const uint8_t *is_inside, int threads, int32_t *with, uint8_t *n_sharing,
                        planish_error *error) {
    pl_cell_census census = {.n_sharing = n_sharing};
    cell_sets s = {.cells = cells,
                   .is_inside = is_inside,
                   .dim = dim,
                   .census = &census,
                   .joins = (uint32_t *)with};
    memset(n_sharing, 0, (size_t)(FACETS * cells->n));
    if (!find_joins(&s, n_nodes, threads))
        return pl_fail_memory(error, "the facets of elements");
    pl_parallel_for(threads, cells->n, CHUNK, note_first_chunk, &s);
    return PLANISH_OK;
}

void pl_cell_census_destroy(pl_cell_census *census) {
    pl_free(census->sign);
    pl_free(census->n_sharing);
    pl_free(census->on_boundary);
    pl_free(census->is_duplicate);
    *census = (pl_cell_census){.n_boundary_facets = 0};
}
