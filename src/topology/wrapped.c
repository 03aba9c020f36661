/* wrapped: elements that reach around a periodic domain, from one side to the other.
 *
 * Where a domain is periodic and each node is there once, the elements of the seam have nodes at
 * two opposite sides: as drawn they lie across the whole domain, and most of them are inverted.
 * Their edges jump. What tells a seam from a tangle is its topology: there is a way through the
 * mesh that jumps more often one way than the other, and yet comes back to where it began. No mesh
 * of a domain without holes has such a way, wherever its nodes were thrown, as long as each element
 * agrees on the jumps of its edges; so all must. And with their nodes of one side moved by the
 * period the elements have the sign that the others have.
 *
 * In: the components of the mesh. Out: flags of elements. Directions are those of the axes.
 */
#include "topology/wrapped.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/simplex.h"

#include <math.h>
#include <string.h>

/* An edge jumps if it is longer than this part of the component's extent. */
#define JUMP 0.6
/* Of the elements of a component at most this part jumps in one direction. */
#define MOST_JUMPING 0.45
/* Of the elements that do not jump this part has one sign. */
#define AGREEING 0.66
/* Of those that jump in one direction alone so many have the other sign, and of all that jump so
 * many the same when they are unwrapped. */
#define CONVINCING 0.8

enum { FEWEST_ELEMENTS = 12, FEWEST_JUMPING = 2 };

/** Facts about a component in one direction. */
typedef struct direction {
    double low, high;   /* its extent; then the period in high */
    double sum;         /* of the extents of elements that do not jump */
    int64_t n_jumping;  /* elements that jump, */
    int64_t n_divided;  /* whose edges disagree about it, */
    int64_t n_single;   /* that jump in this direction alone, */
    int64_t n_contrary; /* of these: with another sign than most, */
    int64_t n_agreeing; /* and of n_jumping with the same when unwrapped */
    int is_seam;        /* 1: elements that jump may wrap around */
    int has_way;        /* 1: there is a way that jumps more often one way than the other */
} direction;

typedef struct component {
    direction in[3];
    int64_t n;          /* elements, */
    int64_t n_staying;  /* that jump in no direction that is a seam, */
    int64_t n_positive; /* of a positive measure in the component's order, */
    int64_t n_negative; /* and of a negative one */
    int sign;           /* what most of them have */
} component;

/** The work; arrays are owned but for link and flags. */
typedef struct work {
    const planish_mesh *mesh;
    const uint32_t *link;
    uint8_t *flags;
    int32_t *slot; /* [m] the component of each root; -1: it is left out */
    component *component;
    int64_t n_components;
    uint16_t *high;        /* [m] 4 bits for each direction: nodes at the high end of a jump */
    int32_t *parent, *way; /* [n_nodes] of a union-find structure: jumps to the parent */
} work;

/** The component of an element; NULL: it is left out. */
static component *component_of(const work *w, int64_t element) {
    const int32_t slot = w->slot[w->link[element] >> 1];
    return slot < 0 ? NULL : &w->component[slot];
}

static double coordinate(const work *w, int64_t element, int corner, int d) {
    const int dim = w->mesh->dim;
    const int32_t node = w->mesh->elements[element * (dim + 1) + corner];
    return w->mesh->coordinates[(int64_t)node * dim + d];
}

static unsigned high_nodes(const work *w, int64_t element, int d) {
    return (unsigned)w->high[element] >> 4 * d & 15;
}

/* ---- components ----------------------------------------------------------------------------- */

/** List the components that can be oriented and have some elements. 0 without memory. */
static int list_components(work *w, const int8_t *conflict) {
    const int64_t m = w->mesh->n_elements;
    memset(w->slot, 0, (size_t)m * sizeof *w->slot);
    for (int64_t i = 0; i < m; i++)
        w->slot[w->link[i] >> 1]++;
    for (int64_t i = 0; i < m; i++) {
        if (w->link[i] >> 1 != i)
            continue;
        const int is_listed = w->slot[i] >= FEWEST_ELEMENTS && !conflict[i];
        w->slot[i] = is_listed ? (int32_t)w->n_components++ : -1;
    }
    w->component = pl_alloc_zero(w->n_components, sizeof *w->component);
    for (int64_t k = 0; w->component && k < w->n_components; k++)
        for (int d = 0; d < 3; d++)
            w->component[k].in[d] = (direction){.low = INFINITY, .high = -INFINITY};
    return w->component != NULL;
}

static void find_extents(work *w) {
    const int dim = w->mesh->dim;
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        component *c = component_of(w, i);
        if (!c)
            continue;
        c->n++;
        for (int j = 0; j <= dim; j++)
            for (int d = 0; d < dim; d++) {
                const double x = coordinate(w, i, j, d);
                c->in[d].low = x < c->in[d].low ? x : c->in[d].low;
                c->in[d].high = x > c->in[d].high ? x : c->in[d].high;
            }
    }
}

/* ---- jumps ---------------------------------------------------------------------------------- */

/** Which nodes of an element are at the high end of a jump in direction d; 0: it does not jump. An
 *  element some of whose nodes are between the ends is divided about it. */
static unsigned jump_of(const work *w, int64_t element, int d, direction *in) {
    double x[4], low = INFINITY, high = -INFINITY, below = -INFINITY, above = INFINITY;
    unsigned mask = 0;
    const int dim = w->mesh->dim;
    const double least = JUMP * (in->high - in->low);
    for (int j = 0; j <= dim; j++) {
        x[j] = coordinate(w, element, j, d);
        low = fmin(low, x[j]);
        high = fmax(high, x[j]);
    }
    if (!(high - low > least) || !(least > 0))
        return 0;
    for (int j = 0; j <= dim; j++) {
        const int is_high = x[j] - low > high - x[j];
        mask |= (unsigned)is_high << j;
        below = is_high ? below : fmax(below, x[j]);
        above = is_high ? fmin(above, x[j]) : above;
    }
    in->n_divided += !(above - below > least);
    return mask;
}

static void find_jumps(work *w) {
    const int dim = w->mesh->dim;
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        component *c = component_of(w, i);
        w->high[i] = 0;
        for (int d = 0; d < dim && c; d++) {
            const unsigned mask = jump_of(w, i, d, &c->in[d]);
            w->high[i] = (uint16_t)(w->high[i] | mask << 4 * d);
            c->in[d].n_jumping += mask != 0;
        }
    }
}

/** Whether any component may have a seam, by the numbers of its elements. */
static int find_candidates(work *w) {
    int any = 0;
    for (int64_t k = 0; k < w->n_components; k++) {
        component *c = &w->component[k];
        for (int d = 0; d < w->mesh->dim; d++) {
            direction *in = &c->in[d];
            in->is_seam = in->n_divided == 0 && in->n_jumping >= FEWEST_JUMPING &&
                          (double)in->n_jumping <= MOST_JUMPING * (double)c->n;
            any |= in->is_seam;
        }
    }
    return any;
}

/* ---- ways around ---------------------------------------------------------------------------- */

/** The root of node; *jumps gets those on the way to it. */
static int32_t find_root(work *w, int32_t node, int32_t *jumps) {
    *jumps = 0;
    while (w->parent[node] != node) {
        const int32_t up = w->parent[node];
        w->way[node] += w->way[up]; /* path halving: up's own is 0 if it is a root */
        w->parent[node] = w->parent[up];
        *jumps += w->way[node];
        node = w->parent[node];
    }
    return node;
}

/** Note that b is jumps from a; 0 if that contradicts what is known. */
static int join(work *w, int32_t a, int32_t b, int32_t jumps) {
    int32_t to_a, to_b;
    const int32_t root_a = find_root(w, a, &to_a), root_b = find_root(w, b, &to_b);
    if (root_a == root_b)
        return to_b == to_a + jumps;
    const int32_t low = root_a < root_b ? root_a : root_b;
    const int32_t high = low == root_a ? root_b : root_a;
    const int32_t between = to_a + jumps - to_b; /* of root_b from root_a */
    w->parent[high] = low;
    w->way[high] = high == root_b ? between : -between;
    return 1;
}

/** Find the components that have a way around in direction d. */
static void find_ways(work *w, int d) {
    const int dim = w->mesh->dim;
    for (int64_t i = 0; i < w->mesh->n_nodes; i++) {
        w->parent[i] = (int32_t)i;
        w->way[i] = 0;
    }
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        component *c = component_of(w, i);
        direction *in = c ? &c->in[d] : NULL;
        const int32_t *node = w->mesh->elements + i * (dim + 1);
        const unsigned high = high_nodes(w, i, d);
        for (int j = 1; j <= dim && in && in->is_seam && !in->has_way; j++)
            in->has_way =
                !join(w, node[0], node[j], (int32_t)(high >> j & 1) - (int32_t)(high & 1));
    }
}

/** Seams are where there is a way around. */
static int keep_ways(work *w) {
    int any = 0;
    for (int d = 0; d < w->mesh->dim; d++) {
        int wanted = 0;
        for (int64_t k = 0; k < w->n_components; k++)
            wanted |= w->component[k].in[d].is_seam;
        if (wanted)
            find_ways(w, d);
        for (int64_t k = 0; k < w->n_components; k++) {
            direction *in = &w->component[k].in[d];
            in->is_seam = in->is_seam && in->has_way;
            any |= in->is_seam;
        }
    }
    return any;
}

/* ---- signs ---------------------------------------------------------------------------------- */

/** How many directions that are seams an element jumps in. */
static int count_jumps(const work *w, const component *c, int64_t element) {
    int n = 0;
    for (int d = 0; d < w->mesh->dim && c; d++)
        n += c->in[d].is_seam && high_nodes(w, element, d) != 0;
    return n;
}

/** The sign of an element in its component's order, as drawn, or with the nodes of the low side
 *  moved by the period. Lengths are in units of the component's extents. */
static int sign_of(const work *w, const component *c, int64_t element, int unwrapped) {
    const int dim = w->mesh->dim;
    double edges[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++) {
            const direction *in = &c->in[d];
            const unsigned high = in->is_seam && unwrapped ? high_nodes(w, element, d) : 0;
            const double period = 1 + in->sum;
            const double x = (coordinate(w, element, j + 1, d) - in->low) / (in->high - in->low);
            const double x0 = (coordinate(w, element, 0, d) - in->low) / (in->high - in->low);
            edges[j][d] = x - x0;
            if (high)
                edges[j][d] += period * ((int)(high & 1) - (int)(high >> (j + 1) & 1));
        }
    const double measure = pl_determinant_of_edges(dim, (const double(*)[3])edges);
    const int sign = measure > 0 ? 1 : measure < 0 ? -1 : 0;
    return w->link[element] & 1 ? -sign : sign;
}

/** Find the common sign of the elements that do not jump, and their mean extent in units of the
 *  component's. */
static void look_at_staying(work *w) {
    const int dim = w->mesh->dim;
    for (int64_t k = 0; k < w->n_components; k++) {
        component *c = &w->component[k];
        c->n_positive = c->n_negative = c->n_staying = 0;
        for (int d = 0; d < dim; d++)
            c->in[d].sum = 0;
    }
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        component *c = component_of(w, i);
        if (!c || !(c->in[0].is_seam || c->in[1].is_seam || c->in[2].is_seam) ||
            count_jumps(w, c, i) > 0)
            continue;
        const int sign = sign_of(w, c, i, 0);
        c->n_staying++;
        c->n_positive += sign > 0;
        c->n_negative += sign < 0;
        for (int d = 0; d < dim; d++) {
            double low = INFINITY, high = -INFINITY;
            for (int j = 0; j <= dim; j++) {
                low = fmin(low, coordinate(w, i, j, d));
                high = fmax(high, coordinate(w, i, j, d));
            }
            c->in[d].sum += (high - low) / (c->in[d].high - c->in[d].low);
        }
    }
    for (int64_t k = 0; k < w->n_components; k++) {
        component *c = &w->component[k];
        const int64_t most = c->n_positive > c->n_negative ? c->n_positive : c->n_negative;
        c->sign = c->n_positive > c->n_negative ? 1 : -1;
        if (!((double)most >= AGREEING * (double)c->n_staying))
            c->sign = 0;
        for (int d = 0; d < dim && c->n_staying > 0; d++)
            c->in[d].sum /= (double)c->n_staying;
    }
}

static void look_at_jumping(work *w) {
    const int dim = w->mesh->dim;
    for (int64_t k = 0; k < w->n_components; k++)
        for (int d = 0; d < dim; d++)
            w->component[k].in[d].n_jumping = w->component[k].in[d].n_single =
                w->component[k].in[d].n_contrary = w->component[k].in[d].n_agreeing = 0;
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        component *c = component_of(w, i);
        const int n = count_jumps(w, c, i);
        const int contrary = n == 1 && sign_of(w, c, i, 0) == -c->sign;
        const int agreeing = n > 0 && sign_of(w, c, i, 1) == c->sign;
        for (int d = 0; d < dim && n > 0; d++) {
            direction *in = &c->in[d];
            if (!in->is_seam || high_nodes(w, i, d) == 0)
                continue;
            in->n_jumping++;
            in->n_single += n == 1;
            in->n_contrary += contrary;
            in->n_agreeing += agreeing;
        }
    }
}

/** Directions in which the elements that jump do not look wrapped are no seams; 0: all did. */
static int drop_unconvincing(work *w) {
    int dropped = 0;
    for (int64_t k = 0; k < w->n_components; k++) {
        component *c = &w->component[k];
        for (int d = 0; d < w->mesh->dim; d++) {
            direction *in = &c->in[d];
            const int convinces = c->sign != 0 && in->n_single >= FEWEST_JUMPING &&
                                  (double)in->n_contrary >= CONVINCING * (double)in->n_single &&
                                  (double)in->n_agreeing >= CONVINCING * (double)in->n_jumping;
            dropped |= in->is_seam && !convinces;
            in->is_seam = in->is_seam && convinces;
        }
    }
    return dropped;
}

/* ---- all of it ------------------------------------------------------------------------------ */

static int64_t set_flags(const work *w) {
    int64_t n = 0;
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        if (count_jumps(w, component_of(w, i), i) == 0)
            continue;
        w->flags[i] |= PL_WRAPPED;
        w->flags[w->link[i] >> 1] |= PL_HAS_WRAPPED;
        n++;
    }
    return n;
}

/** 0 without memory. */
static int find(work *w, const int8_t *conflict, int64_t *n) {
    if (!list_components(w, conflict))
        return 0;
    find_extents(w);
    find_jumps(w);
    if (!find_candidates(w))
        return 1;
    w->parent = pl_alloc(w->mesh->n_nodes, sizeof *w->parent);
    w->way = pl_alloc(w->mesh->n_nodes, sizeof *w->way);
    if (!w->parent || !w->way)
        return 0;
    if (!keep_ways(w))
        return 1;
    do {
        look_at_staying(w);
        look_at_jumping(w);
    } while (drop_unconvincing(w));
    *n = set_flags(w);
    return 1;
}

int pl_wrapped_find(const planish_mesh *mesh, const uint32_t *link, const int8_t *conflict,
                    uint8_t *flags, int64_t *n, planish_error *error) {
    work w = {.mesh = mesh, .link = link, .flags = flags};
    *n = 0;
    w.slot = pl_alloc(mesh->n_elements, sizeof *w.slot);
    w.high = pl_alloc(mesh->n_elements, sizeof *w.high);
    const int done = w.slot && w.high && find(&w, conflict, n);
    pl_free(w.slot);
    pl_free(w.high);
    pl_free(w.component);
    pl_free(w.parent);
    pl_free(w.way);
    return done ? PLANISH_OK : pl_fail_memory(error, "the elements that wrap around");
}
