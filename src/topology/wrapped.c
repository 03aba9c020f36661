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
#include "topology/topology.h"

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

/** Facts about a component. */
typedef struct component {
    direction in[3];
    int64_t n;          /* elements, */
    int64_t n_staying;  /* that jump in no direction that is a seam, */
    int64_t n_positive; /* of a positive measure in the component's order, */
    int64_t n_negative; /* and of a negative one */
    int sign;           /* what most of them have */
} component;

/** The search for seams; arrays are owned but for link. */
typedef struct seams {
    const planish_mesh *mesh;
    const uint32_t *link;
    int32_t *slot; /* [m] the component of each root; -1: it is left out */
    component *component;
    int64_t n_components;
    uint16_t *high;        /* [m] 4 bits for each direction: nodes at the high end of a jump */
    int32_t *parent, *way; /* [n_nodes] of a union-find structure: jumps to the parent */
} seams;

/** The component of an element; NULL: it is left out. */
static component *component_of(const seams *s, int64_t element) {
    const int32_t slot = s->slot[s->link[element] >> 1];
    return slot < 0 ? NULL : &s->component[slot];
}

static double coordinate(const seams *s, int64_t element, int corner, int d) {
    const int dim = s->mesh->dim;
    const int32_t node = s->mesh->elements[element * (dim + 1) + corner];
    return s->mesh->coordinates[(int64_t)node * dim + d];
}

static unsigned high_nodes(const seams *s, int64_t element, int d) {
    return (unsigned)s->high[element] >> 4 * d & 15;
}

/* ---- jumps ---------------------------------------------------------------------------------- */

/** List the components that can be oriented and have some elements, and find their extents. 0
 *  without memory. */
static int list_components(seams *s, const int8_t *conflict) {
    const int dim = s->mesh->dim;
    const int64_t m = s->mesh->n_elements;
    memset(s->slot, 0, (size_t)m * sizeof *s->slot);
    for (int64_t i = 0; i < m; i++)
        s->slot[s->link[i] >> 1]++;
    for (int64_t i = 0; i < m; i++) {
        if (s->link[i] >> 1 != i)
            continue;
        const int is_listed = s->slot[i] >= FEWEST_ELEMENTS && !conflict[i];
        s->slot[i] = is_listed ? (int32_t)s->n_components++ : -1;
    }
    s->component = pl_alloc_zero(s->n_components, sizeof *s->component);
    if (!s->component)
        return 0;
    for (int64_t k = 0; k < s->n_components; k++)
        for (int d = 0; d < 3; d++)
            s->component[k].in[d] = (direction){.low = INFINITY, .high = -INFINITY};
    for (int64_t i = 0; i < m; i++) {
        component *c = component_of(s, i);
        if (!c)
            continue;
        c->n++;
        for (int j = 0; j <= dim; j++)
            for (int d = 0; d < dim; d++) {
                const double x = coordinate(s, i, j, d);
                c->in[d].low = x < c->in[d].low ? x : c->in[d].low;
                c->in[d].high = x > c->in[d].high ? x : c->in[d].high;
            }
    }
    return 1;
}

/** Nodes of an element, in bits, that are at the high end of a jump in direction d; 0: it does not
 * jump. An element some of whose nodes are between the ends is divided about it. */
static unsigned jump_of(const seams *s, int64_t element, int d, direction *in) {
    double x[4], low = INFINITY, high = -INFINITY, below = -INFINITY, above = INFINITY;
    unsigned mask = 0;
    const int dim = s->mesh->dim;
    const double least = JUMP * (in->high - in->low);
    for (int j = 0; j <= dim; j++) {
        x[j] = coordinate(s, element, j, d);
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

/** Find the elements that jump; whether any component may have a seam, by their numbers. */
static int find_candidates(seams *s) {
    const int dim = s->mesh->dim;
    int any = 0;
    for (int64_t i = 0; i < s->mesh->n_elements; i++) {
        component *c = component_of(s, i);
        s->high[i] = 0;
        for (int d = 0; d < dim && c; d++) {
            const unsigned mask = jump_of(s, i, d, &c->in[d]);
            s->high[i] = (uint16_t)(s->high[i] | mask << 4 * d);
            c->in[d].n_jumping += mask != 0;
        }
    }
    for (int64_t k = 0; k < s->n_components; k++)
        for (int d = 0; d < dim; d++) {
            direction *in = &s->component[k].in[d];
            in->is_seam = in->n_divided == 0 && in->n_jumping >= FEWEST_JUMPING &&
                          (double)in->n_jumping <= MOST_JUMPING * (double)s->component[k].n;
            any |= in->is_seam;
        }
    return any;
}

/* ---- ways around ---------------------------------------------------------------------------- */

/** The root of node; *jumps gets those on the way to it. */
static int32_t find_root(seams *s, int32_t node, int32_t *jumps) {
    *jumps = 0;
    while (s->parent[node] != node) {
        const int32_t up = s->parent[node];
        s->way[node] += s->way[up]; /* path halving: up's own is 0 if it is a root */
        s->parent[node] = s->parent[up];
        *jumps += s->way[node];
        node = s->parent[node];
    }
    return node;
}

/** Join a and b, which is jumps from a; 0 if that contradicts what is known. */
static int join(seams *s, int32_t a, int32_t b, int32_t jumps) {
    int32_t to_a, to_b;
    const int32_t root_a = find_root(s, a, &to_a), root_b = find_root(s, b, &to_b);
    if (root_a == root_b)
        return to_b == to_a + jumps;
    const int32_t low = root_a < root_b ? root_a : root_b;
    const int32_t high = low == root_a ? root_b : root_a;
    const int32_t between = to_a + jumps - to_b; /* of root_b from root_a */
    s->parent[high] = low;
    s->way[high] = high == root_b ? between : -between;
    return 1;
}

/** Find the components that have a way around, in each direction: seams are there only. Whether
 *  any has one. */
static int find_ways(seams *s) {
    const int dim = s->mesh->dim;
    int any = 0;
    for (int d = 0; d < dim; d++) {
        int is_wanted = 0;
        for (int64_t k = 0; k < s->n_components; k++)
            is_wanted |= s->component[k].in[d].is_seam;
        if (!is_wanted)
            continue;
        for (int64_t i = 0; i < s->mesh->n_nodes; i++) {
            s->parent[i] = (int32_t)i;
            s->way[i] = 0;
        }
        for (int64_t i = 0; i < s->mesh->n_elements; i++) {
            component *c = component_of(s, i);
            direction *in = c ? &c->in[d] : NULL;
            const int32_t *node = s->mesh->elements + i * (dim + 1);
            const unsigned high = high_nodes(s, i, d);
            for (int j = 1; j <= dim && in && in->is_seam && !in->has_way; j++)
                in->has_way =
                    !join(s, node[0], node[j], (int32_t)(high >> j & 1) - (int32_t)(high & 1));
        }
        for (int64_t k = 0; k < s->n_components; k++) {
            direction *in = &s->component[k].in[d];
            in->is_seam = in->is_seam && in->has_way;
            any |= in->is_seam;
        }
    }
    return any;
}

/* ---- signs ---------------------------------------------------------------------------------- */

/** Number of the directions that are seams which an element jumps in. */
static int count_jumps(const seams *s, const component *c, int64_t element) {
    int n = 0;
    for (int d = 0; d < s->mesh->dim && c; d++)
        n += c->in[d].is_seam && high_nodes(s, element, d) != 0;
    return n;
}

/** The sign of an element in its component's order, as drawn, or with the nodes of the low side
 *  moved by the period. Lengths are in units of the component's extents. */
static int sign_of(const seams *s, const component *c, int64_t element, int unwrapped) {
    const int dim = s->mesh->dim;
    double edges[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++) {
            const direction *in = &c->in[d];
            const unsigned high = in->is_seam && unwrapped ? high_nodes(s, element, d) : 0;
            const double period = 1 + in->sum;
            const double x = (coordinate(s, element, j + 1, d) - in->low) / (in->high - in->low);
            const double x0 = (coordinate(s, element, 0, d) - in->low) / (in->high - in->low);
            edges[j][d] = x - x0;
            if (high)
                edges[j][d] += period * ((int)(high & 1) - (int)(high >> (j + 1) & 1));
        }
    const double measure = pl_determinant_of_edges(dim, (const double(*)[3])edges);
    const int sign = measure > 0 ? 1 : measure < 0 ? -1 : 0;
    return s->link[element] & 1 ? -sign : sign;
}

/** Find the common sign of the elements that do not jump, and their mean extent in units of the
 *  component's. */
static void measure_staying(seams *s) {
    const int dim = s->mesh->dim;
    for (int64_t k = 0; k < s->n_components; k++) {
        component *c = &s->component[k];
        c->n_positive = c->n_negative = c->n_staying = 0;
        for (int d = 0; d < dim; d++)
            c->in[d].sum = 0;
    }
    for (int64_t i = 0; i < s->mesh->n_elements; i++) {
        component *c = component_of(s, i);
        if (!c || !(c->in[0].is_seam || c->in[1].is_seam || c->in[2].is_seam) ||
            count_jumps(s, c, i) > 0)
            continue;
        const int sign = sign_of(s, c, i, 0);
        c->n_staying++;
        c->n_positive += sign > 0;
        c->n_negative += sign < 0;
        for (int d = 0; d < dim; d++) {
            double low = INFINITY, high = -INFINITY;
            for (int j = 0; j <= dim; j++) {
                low = fmin(low, coordinate(s, i, j, d));
                high = fmax(high, coordinate(s, i, j, d));
            }
            c->in[d].sum += (high - low) / (c->in[d].high - c->in[d].low);
        }
    }
    for (int64_t k = 0; k < s->n_components; k++) {
        component *c = &s->component[k];
        const int64_t most = c->n_positive > c->n_negative ? c->n_positive : c->n_negative;
        c->sign = c->n_positive > c->n_negative ? 1 : -1;
        if (!((double)most >= AGREEING * (double)c->n_staying))
            c->sign = 0;
        for (int d = 0; d < dim && c->n_staying > 0; d++)
            c->in[d].sum /= (double)c->n_staying;
    }
}

/** Directions in which the elements that jump do not look wrapped are no seams; 0: all did. */
static int drop_unconvincing(seams *s) {
    const int dim = s->mesh->dim;
    int dropped = 0;
    for (int64_t k = 0; k < s->n_components; k++)
        for (int d = 0; d < dim; d++)
            s->component[k].in[d].n_jumping = s->component[k].in[d].n_single =
                s->component[k].in[d].n_contrary = s->component[k].in[d].n_agreeing = 0;
    for (int64_t i = 0; i < s->mesh->n_elements; i++) {
        component *c = component_of(s, i);
        const int n = count_jumps(s, c, i);
        const int contrary = n == 1 && sign_of(s, c, i, 0) == -c->sign;
        const int agreeing = n > 0 && sign_of(s, c, i, 1) == c->sign;
        for (int d = 0; d < dim && n > 0; d++) {
            direction *in = &c->in[d];
            if (!in->is_seam || high_nodes(s, i, d) == 0)
                continue;
            in->n_jumping++;
            in->n_single += n == 1;
            in->n_contrary += contrary;
            in->n_agreeing += agreeing;
        }
    }
    for (int64_t k = 0; k < s->n_components; k++)
        for (int d = 0; d < dim; d++) {
            direction *in = &s->component[k].in[d];
            const int convinces = s->component[k].sign != 0 && in->n_single >= FEWEST_JUMPING &&
                                  (double)in->n_contrary >= CONVINCING * (double)in->n_single &&
                                  (double)in->n_agreeing >= CONVINCING * (double)in->n_jumping;
            dropped |= in->is_seam && !convinces;
            in->is_seam = in->is_seam && convinces;
        }
    return dropped;
}

/* ---- all of it ------------------------------------------------------------------------------ */

int pl_wrapped_find(const planish_mesh *mesh, const uint32_t *link, const int8_t *conflict,
                    uint8_t *flags, int64_t *n, planish_error *error) {
    const int64_t m = mesh->n_elements;
    seams s = {.mesh = mesh,
               .link = link,
               .slot = pl_alloc(m, sizeof *s.slot),
               .high = pl_alloc(m, sizeof *s.high)};
    *n = 0;
    int done = s.slot && s.high && list_components(&s, conflict);
    const int has_candidates = done && find_candidates(&s);
    if (has_candidates) {
        s.parent = pl_alloc(mesh->n_nodes, sizeof *s.parent);
        s.way = pl_alloc(mesh->n_nodes, sizeof *s.way);
        done = s.parent && s.way;
    }
    if (has_candidates && done && find_ways(&s)) {
        do
            measure_staying(&s);
        while (drop_unconvincing(&s));
        for (int64_t i = 0; i < m; i++) {
            if (count_jumps(&s, component_of(&s, i), i) == 0)
                continue;
            flags[i] |= PL_WRAPPED;
            flags[link[i] >> 1] |= PL_HAS_WRAPPED;
            ++*n;
        }
    }
    pl_free(s.slot);
    pl_free(s.high);
    pl_free(s.component);
    pl_free(s.parent);
    pl_free(s.way);
    return done ? PLANISH_OK : pl_fail_memory(error, "the elements that wrap around");
}
