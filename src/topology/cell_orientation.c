/* cell_orientation: which handedness each element of any type has, by its neighbours.
 *
 * Two elements on either side of a facet go around it in opposite directions if they have the same
 * handedness. So elements that facets join have one handedness relative to one another, whatever
 * the order of their nodes and wherever these are; where signs alone were asked, an inverted element
 * would be one of the other handedness. Of each set of joined elements the sign of most is the right
 * one. Elements that nothing joins, as where each has nodes of its own, have that of most of their
 * type.
 */
#include "base/memory.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "geometry/simplex.h"
#include "topology/cells.h"

#include <string.h>

enum { FACET_NODES = 4, FACETS = 8 /* numbers of facets of an element, for numbering all */ };

/** Facet as it is compared: the lowest node, the lower one beside it, and so on around; -1: none. */
typedef struct facet {
    int32_t node[FACET_NODES];
    int n;
    int direction; /* +1: the element goes around it in this order; -1: the other way */
} facet;

/** Sets of elements with one handedness (union-find with parity). */
typedef struct cell_sets {
    const planish_cells *cells;
    int dim;
    int32_t *parent; /* [n] an element of the same set; itself: it stands for the set */
    int8_t *flip;    /* [n] -1: of the other handedness than parent, else 1 */
    int64_t *slot;   /* [mask + 1] FACETS * element + facet, or -1 */
    int64_t mask;
} cell_sets;

static const pl_cell_type *counted_type(const cell_sets *s, int64_t element) {
    const pl_cell_type *type = pl_cell_type_of(s->cells->type[element]);
    return type && type->shape->dim == s->dim ? type : NULL;
}

/** Find facet k of an element. Nodes that are there twice count once. Returns 0 if there is no facet
 *  left then. */
static int find_facet(const cell_sets *s, int64_t element, int k, facet *f) {
    const pl_cell_shape *shape = counted_type(s, element)->shape;
    const int32_t *node = s->cells->node + s->cells->offset[element];
    int32_t around[FACET_NODES];
    int lowest = 0, n = 0;
    for (int i = 0; i < FACET_NODES && shape->facet[k][i] >= 0; i++) {
        const int32_t next = node[shape->facet[k][i]];
        if (n == 0 || (around[n - 1] != next && (around[0] != next)))
            around[n++] = next;
    }
    if (n < s->dim)
        return 0;
    for (int i = 1; i < n; i++)
        lowest = around[i] < around[lowest] ? i : lowest;
    const int32_t next = around[(lowest + 1) % n], last = around[(lowest + n - 1) % n];
    /* The ends of an edge have one order, so that its direction is where its lowest node is. */
    f->direction = n == 2 ? (lowest == 0 ? 1 : -1) : next < last ? 1 : -1;
    f->n = n;
    for (int i = 0; i < FACET_NODES; i++)
        f->node[i] = -1;
    for (int i = 0; i < n; i++)
        f->node[i] = around[(lowest + (n == 2 ? i : f->direction * i) + n) % n];
    return 1;
}

static uint64_t hash_of(const facet *f) {
    uint64_t hash = 0;
    for (int i = 0; i < FACET_NODES; i++) {
        hash = (hash ^ (uint32_t)f->node[i]) * 0x9e3779b97f4a7c15u;
        hash ^= hash >> 29;
    }
    return hash;
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
        const int own = s->flip[element];
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

/** Whether an element is listed twice. */
static int is_same(const cell_sets *s, int64_t a, int64_t b) {
    const int64_t *offset = s->cells->offset;
    const int64_t n = offset[a + 1] - offset[a];
    return s->cells->type[a] == s->cells->type[b] &&
           memcmp(s->cells->node + offset[a], s->cells->node + offset[b],
                  (size_t)n * sizeof *s->cells->node) == 0;
}

/** Put facet k of an element into the table, or join the element with the one that has it. */
static void add_facet(cell_sets *s, int64_t element, int k) {
    facet own, other;
    if (!find_facet(s, element, k, &own))
        return;
    for (int64_t at = (int64_t)(hash_of(&own) & (uint64_t)s->mask);; at = (at + 1) & s->mask) {
        if (s->slot[at] < 0) {
            s->slot[at] = FACETS * element + k;
            return;
        }
        find_facet(s, s->slot[at] / FACETS, (int)(s->slot[at] % FACETS), &other);
        if (memcmp(own.node, other.node, sizeof own.node) == 0) {
            if (!is_same(s, s->slot[at] / FACETS, element))
                join(s, (int32_t)(s->slot[at] / FACETS), (int32_t)element,
                     own.direction == other.direction ? -1 : 1);
            return;
        }
    }
}

/** Sign of an element by its corners together; 0: flat. */
static int sign_by_corners(const cell_sets *s, const double *coordinates, int64_t element) {
    const pl_cell_shape *shape = counted_type(s, element)->shape;
    const int32_t *node = s->cells->node + s->cells->offset[element];
    double sum = 0;
    for (int c = 0; c < shape->n_measured; c++) {
        double edges[3][3] = {{0}};
        const double *from = coordinates + (int64_t)node[c] * s->dim;
        for (int j = 0; j < s->dim; j++)
            pl_subtract(s->dim, coordinates + (int64_t)node[shape->neighbour[c][j]] * s->dim, from,
                        edges[j]);
        sum += pl_determinant_of_edges(s->dim, edges);
    }
    return sum > 0 ? 1 : sum < 0 ? -1 : 0;
}

/** Surplus of positive signs among the elements of a set, and their number. */
typedef struct set_count {
    int64_t surplus, n;
} set_count;

/** Find the sign of each element. count [n], zeroed, is for the sets. */
static void find_signs(cell_sets *s, const double *coordinates, set_count *count, int8_t *sign) {
    int64_t of_type[UINT8_MAX + 1] = {0};
    int flip;
    for (int64_t i = 0; i < s->cells->n; i++)
        if (counted_type(s, i)) {
            const int own = sign_by_corners(s, coordinates, i);
            const int32_t set = find_set(s, (int32_t)i, &flip);
            of_type[s->cells->type[i]] += own;
            count[set].surplus += flip * own;
            count[set].n++;
        }
    for (int64_t i = 0; i < s->cells->n; i++) {
        const int32_t set = find_set(s, (int32_t)i, &flip);
        const int is_alone = count[set].n == 1;
        const int64_t surplus = is_alone ? of_type[s->cells->type[i]] : count[set].surplus;
        sign[i] = (int8_t)(surplus >= 0 ? flip : -flip);
    }
}

int pl_orient_cells(const planish_cells *cells, int dim, const double *coordinates, int8_t *sign,
                    planish_error *error) {
    cell_sets s = {.cells = cells, .dim = dim};
    int64_t n_facets = 0, n_slots = 1;
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = counted_type(&s, i);
        n_facets += type ? type->shape->n_facets : 0;
    }
    while (n_slots < n_facets + n_facets / 2)
        n_slots *= 2;
    s.mask = n_slots - 1;
    s.slot = pl_alloc(n_slots, sizeof *s.slot);
    s.parent = pl_alloc(cells->n, sizeof *s.parent);
    s.flip = pl_alloc(cells->n, sizeof *s.flip);
    set_count *count = pl_alloc_zero(cells->n, sizeof *count);
    const int is_there = s.slot && s.parent && s.flip && count;
    if (is_there) {
        memset(s.slot, -1, (size_t)n_slots * sizeof *s.slot);
        for (int64_t i = 0; i < cells->n; i++) {
            s.parent[i] = (int32_t)i;
            s.flip[i] = 1;
        }
        for (int64_t i = 0; i < cells->n; i++) {
            const pl_cell_type *type = counted_type(&s, i);
            for (int k = 0; type && k < type->shape->n_facets; k++)
                add_facet(&s, i, k);
        }
        find_signs(&s, coordinates, count, sign);
    }
    pl_free(s.slot);
    pl_free(s.parent);
    pl_free(s.flip);
    pl_free(count);
    return is_there ? PLANISH_OK : pl_fail_memory(error, "the orientation of elements");
}
