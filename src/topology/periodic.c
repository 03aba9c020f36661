/* periodic: nodes that are one another's images by translations and move together.
 *
 * Of each group of such nodes one leads and the others follow. The leader's star has the elements
 * around all of them, those of a follower as they are next to the leader: the mesh gets a layer of
 * copies, the elements at followers moved by the translation that brings these to their leaders.
 * Nodes of a copy are nodes of the mesh where there is one in the same group, and else images, new
 * nodes that are where another one is but for the translation.
 */
#include "topology/topology.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/corner.h"
#include "geometry/simplex.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum {
    MAX_SHIFTS = 64, /* translations that are told apart: a box has 26; rotations have any number */
    MAX_GROUP = 64,  /* nodes of one: at most 8 of a box */
    MIN_PAIRS = 2,   /* of one translation: two nodes alone could be anything */
    NO_SHIFT = 255
};
/* Translations differ by more than this times the size of the mesh, or are one. */
#define SHIFT_TOLERANCE 1e-8
/* Normals and lines of a group are parallel if their unit vectors differ by no more than this. */
#define PARALLEL_TOLERANCE 1e-12

/** All groups; arrays [n] over the mesh's nodes. */
typedef struct groups {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const uint8_t *corner; /* [m] or NULL */
    double tolerance;      /* of lengths */
    int32_t *next;         /* circular lists of groups */
    int32_t *leader;       /* of each node, itself outside of groups */
    uint8_t *shift_of;     /* followers: their translation, else NO_SHIFT */
    int n_shifts;
    double shift[MAX_SHIFTS][3]; /* from leader to follower */
    int64_t pairs[MAX_SHIFTS];   /* followers of each */
    int32_t *image;              /* of the shift under way, or -1 */
    uint8_t *is_copied;          /* [m] elements, likewise */
    int64_t follower_capacity, element_capacity, source_capacity;
    pl_periodic *out;
} groups;

static const double *place(const groups *g, int32_t node) {
    return g->mesh->coordinates + (int64_t)node * g->mesh->dim;
}

/* ---- groups -------------------------------------------------------------------------------- */

/** Hold all nodes of a group. */
static void hold(const groups *g, int32_t node, uint8_t *slides) {
    slides[node] = 0;
    for (int32_t i = g->next[node]; i != node; i = g->next[i])
        slides[i] = 0;
}

/** Splice the lists of both nodes, unless they are one. Hold both if the group would be too large.
 */
static void join(const groups *g, int32_t a, int32_t b, uint8_t *slides) {
    int size = 1;
    for (int32_t i = g->next[a]; i != a; i = g->next[i], size++)
        if (i == b)
            return;
    if (a == b)
        return;
    for (int32_t i = g->next[b]; i != b; i = g->next[i])
        size++;
    if (size >= MAX_GROUP) {
        hold(g, a, slides);
        hold(g, b, slides);
        return;
    }
    const int32_t next = g->next[a];
    g->next[a] = g->next[b];
    g->next[b] = next;
}

/** Return how far a node is along a direction that no translation of a lattice is orthogonal to. */
static double along(const groups *g, int32_t node) {
    static const double generic[3] = {1, 0.6180339887498949, 0.3141592653589793};
    return pl_dot(g->mesh->dim, place(g, node), generic);
}

/** Whether two nodes may move in the same directions; of surfaces that is not known. */
static int move_alike(const planish_mesh *mesh, int32_t a, int32_t b) {
    const int dim = mesh->dim;
    double u[3], v[3], same = 0, opposite = 0;
    if (mesh->constraint[a] != mesh->constraint[b] ||
        mesh->constraint[a] >= PLANISH_CONSTRAINT_ON_SURFACE ||
        !pl_unit(dim, mesh->direction + (int64_t)a * dim, u) ||
        !pl_unit(dim, mesh->direction + (int64_t)b * dim, v))
        return 0;
    for (int d = 0; d < dim; d++) {
        same = fmax(same, fabs(u[d] - v[d]));
        opposite = fmax(opposite, fabs(u[d] + v[d]));
    }
    return fmin(same, opposite) <= PARALLEL_TOLERANCE;
}

static int is_shift(const groups *g, const double *shift, const double *from, const double *to) {
    double largest = 0;
    for (int d = 0; d < g->mesh->dim; d++)
        largest = fmax(largest, fabs(to[d] - from[d] - shift[d]));
    return largest <= g->tolerance;
}

/** The translation of a follower, made if it is new; NO_SHIFT if there are too many. */
static uint8_t find_shift(groups *g, int32_t node) {
    const double *from = place(g, g->leader[node]), *to = place(g, node);
    for (int s = 0; s < g->n_shifts; s++)
        if (is_shift(g, g->shift[s], from, to))
            return (uint8_t)s;
    if (g->n_shifts == MAX_SHIFTS)
        return NO_SHIFT;
    pl_subtract(g->mesh->dim, to, from, g->shift[g->n_shifts]);
    return (uint8_t)g->n_shifts++;
}

/* Pairs that are listed: more than any mesh of INT32_MAX nodes needs. */
static const int64_t MOST_PAIRS = (int64_t)64 * INT32_MAX;

int pl_check_periodic(const planish_mesh *mesh, planish_error *error) {
    if (mesh->n_periodic < 0 || (mesh->n_periodic > 0 && !mesh->periodic))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_periodic is %" PRId64 "%s; give pairs, or 0 for none",
                       mesh->n_periodic, mesh->periodic ? "" : " and mesh.periodic is NULL");
    if (mesh->n_periodic > MOST_PAIRS)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_periodic is %" PRId64 "; it must be at most %" PRId64,
                       mesh->n_periodic, MOST_PAIRS);
    for (int64_t i = 0; i < 2 * mesh->n_periodic; i++)
        if (mesh->periodic[i] < 0 || mesh->periodic[i] >= mesh->n_nodes)
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, mesh->periodic[i],
                              "pair %" PRId64 " of mesh.periodic has node %" PRId32
                              ", which is not in 0 .. %" PRId64,
                              i / 2, mesh->periodic[i], mesh->n_nodes - 1);
    return PLANISH_OK;
}

/** Find groups, their leaders and translations. Hold the groups that cannot move together. */
static void find_groups(groups *g, uint8_t *slides) {
    const planish_mesh *mesh = g->mesh;
    const int corners = mesh->dim + 1;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        g->next[i] = (int32_t)i;
    for (int64_t i = 0; i < mesh->n_periodic; i++)
        join(g, mesh->periodic[2 * i], mesh->periodic[2 * i + 1], slides);
    /* The first along that direction leads. */
    for (int32_t node = 0; node < mesh->n_nodes; node++) {
        int32_t first = node;
        for (int32_t i = g->next[node]; i != node; i = g->next[i])
            if (along(g, i) < along(g, first) || (along(g, i) == along(g, first) && i < first))
                first = i;
        g->leader[node] = first;
        g->shift_of[node] = NO_SHIFT;
    }
    for (int32_t node = 0; node < mesh->n_nodes; node++) {
        const int32_t leader = g->leader[node];
        if (leader == node)
            continue;
        const uint8_t shift = find_shift(g, node);
        g->shift_of[node] = shift;
        if (shift != NO_SHIFT)
            g->pairs[shift]++;
        if (!slides[node] || !slides[leader] || shift == NO_SHIFT ||
            !move_alike(mesh, leader, node))
            hold(g, node, slides);
    }
    for (int32_t node = 0; node < mesh->n_nodes; node++)
        if (g->shift_of[node] != NO_SHIFT && g->pairs[g->shift_of[node]] < MIN_PAIRS)
            hold(g, node, slides);
    /* Elements with two nodes of one group would not be what their copies are. */
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int32_t *node = mesh->elements + i * corners;
        for (int j = 0; j < corners; j++)
            for (int k = j + 1; k < corners; k++)
                if (g->leader[node[j]] == g->leader[node[k]])
                    hold(g, node[j], slides);
    }
}

/* ---- copies -------------------------------------------------------------------------------- */

/** Find the node that stands next to a follower as node stands next to its leader: a node of the
 *  mesh, or an image; -1 without memory. */
static int32_t moved_node(groups *g, int32_t node, int32_t follower, int s) {
    for (int32_t i = g->next[node]; i != node; i = g->next[i])
        if (is_shift(g, g->shift[s], place(g, i), place(g, node)))
            return i;
    if (g->image[node] < 0) {
        const pl_follower image = {.node = (int32_t)g->out->n_nodes,
                                   .of = node,
                                   .from = follower,
                                   .to = g->leader[follower]};
        if (g->out->n_nodes == INT32_MAX || !pl_append(&g->out->follower, &g->out->n_followers,
                                                       &g->follower_capacity, &image, sizeof image))
            return -1;
        g->image[node] = (int32_t)g->out->n_nodes++;
    }
    return g->image[node];
}

/** Append a copy of an element at a follower. */
static int copy_element(groups *g, int32_t element, int32_t follower, int s) {
    pl_periodic *out = g->out;
    const int corners = g->mesh->dim + 1;
    int32_t copy[4];
    for (int j = 0; j < corners; j++) {
        copy[j] = moved_node(g, g->mesh->elements[(int64_t)element * corners + j], follower, s);
        if (copy[j] < 0)
            return -1;
    }
    int64_t n = out->n_elements;
    return out->n_elements < INT32_MAX &&
                   pl_append(&out->elements, &n, &g->element_capacity, copy,
                             (size_t)corners * sizeof *copy) &&
                   pl_append(&out->source, &out->n_elements, &g->source_capacity, &element,
                             sizeof element)
               ? 0
               : -1;
}

/** Append copies of an element, or of all corners of its cell, unless there are some. */
static int copy_cell(groups *g, int32_t element, int32_t follower, int s) {
    int32_t e = element;
    if (g->is_copied[element])
        return 0;
    if (g->corner)
        e -= pl_corner_index(g->corner[element]);
    do {
        if (copy_element(g, e, follower, s) != 0)
            return -1;
        g->is_copied[e++] = 1;
    } while (g->corner && e < g->mesh->n_elements && pl_corner_index(g->corner[e]) > 0);
    return 0;
}

/** Copies of the elements at the followers that move, for one translation. */
static int copy_layer(groups *g, const uint8_t *slides, int s) {
    const pl_incidence *incidence = g->incidence;
    for (int64_t i = 0; i < g->mesh->n_nodes; i++)
        g->image[i] = -1;
    memset(g->is_copied, 0, (size_t)g->mesh->n_elements);
    for (int64_t i = 0; i < g->mesh->n_nodes; i++) {
        if (g->shift_of[i] != s || !slides[i])
            continue;
        for (int64_t k = incidence->offset[i]; k < incidence->offset[i + 1]; k++)
            if (copy_cell(g, incidence->element[k], (int32_t)i, s) != 0)
                return -1;
    }
    return 0;
}

/** Make the mesh with its copies. The signs and minimum volumes of copies are those of their
 *  elements. -1 without memory. */
static int copy_mesh(groups *g, const int8_t *sign, uint8_t *slides) {
    const planish_mesh *mesh = g->mesh;
    pl_periodic *out = g->out;
    const int64_t n = mesh->n_nodes, m = mesh->n_elements;
    const int corners = mesh->dim + 1;
    out->n_nodes = n;
    out->n_elements = g->element_capacity = g->source_capacity = m;
    out->elements = pl_alloc(m * corners, sizeof *out->elements);
    out->source = pl_alloc(m, sizeof *out->source);
    if (!out->elements || !out->source)
        return -1;
    memcpy(out->elements, mesh->elements, (size_t)(m * corners) * sizeof *out->elements);
    for (int64_t i = 0; i < m; i++)
        out->source[i] = (int32_t)i;
    find_groups(g, slides);
    for (int32_t node = 0; node < n; node++) {
        const int32_t leader = g->leader[node];
        const pl_follower follower = {.node = node, .of = leader, .from = leader, .to = node};
        if (g->shift_of[node] != NO_SHIFT && slides[node] &&
            !pl_append(&out->follower, &out->n_followers, &g->follower_capacity, &follower,
                       sizeof follower))
            return -1;
    }
    for (int s = 0; s < g->n_shifts; s++)
        if (copy_layer(g, slides, s) != 0)
            return -1;
    out->moves_with = pl_alloc(out->n_nodes, sizeof *out->moves_with);
    out->sign = sign ? pl_alloc(out->n_elements, sizeof *out->sign) : NULL;
    out->min_volume = mesh->min_volume ? pl_alloc(out->n_elements, sizeof *out->min_volume) : NULL;
    out->corner = g->corner ? pl_alloc(out->n_elements, sizeof *out->corner) : NULL;
    if (!out->moves_with || (sign && !out->sign) || (mesh->min_volume && !out->min_volume) ||
        (g->corner && !out->corner))
        return -1;
    memcpy(out->moves_with, g->leader, (size_t)n * sizeof *g->leader);
    for (int64_t k = 0; k < out->n_followers; k++) /* an image: with the leader of its source */
        out->moves_with[out->follower[k].node] = g->leader[out->follower[k].of];
    for (int64_t i = 0; sign && i < out->n_elements; i++)
        out->sign[i] = sign[out->source[i]];
    for (int64_t i = 0; g->corner && i < out->n_elements; i++)
        out->corner[i] = g->corner[out->source[i]];
    for (int64_t i = 0; mesh->min_volume && i < out->n_elements; i++)
        out->min_volume[i] = mesh->min_volume[out->source[i]];
    return 0;
}

int pl_periodic_create(const planish_mesh *mesh, const pl_incidence *incidence, const int8_t *sign,
                       const uint8_t *corner, uint8_t *slides, pl_periodic *out,
                       planish_error *error) {
    *out = (pl_periodic){0};
    groups g = {.mesh = mesh,
                .incidence = incidence,
                .corner = corner,
                .next = pl_alloc(mesh->n_nodes, sizeof *g.next),
                .leader = pl_alloc(mesh->n_nodes, sizeof *g.leader),
                .shift_of = pl_alloc(mesh->n_nodes, 1),
                .image = pl_alloc(mesh->n_nodes, sizeof *g.image),
                .is_copied = pl_alloc(mesh->n_elements, 1),
                .out = out};
    /* Half the longest side of the box of all nodes of pairs: others may be anywhere. */
    double half_size = 0;
    for (int d = 0; d < mesh->dim; d++) {
        double low = INFINITY, high = -INFINITY;
        for (int64_t i = 0; i < 2 * mesh->n_periodic; i++) {
            low = fmin(low, place(&g, mesh->periodic[i])[d]);
            high = fmax(high, place(&g, mesh->periodic[i])[d]);
        }
        half_size = fmax(half_size, high / 2 - low / 2);
    }
    g.tolerance = 2 * SHIFT_TOLERANCE * half_size;
    const int done = g.next && g.leader && g.shift_of && g.image && g.is_copied &&
                     copy_mesh(&g, sign, slides) == 0;
    pl_free(g.next);
    pl_free(g.leader);
    pl_free(g.shift_of);
    pl_free(g.image);
    pl_free(g.is_copied);
    return done ? PLANISH_OK : pl_fail_memory(error, "periodic nodes");
}

void pl_periodic_destroy(pl_periodic *periodic) {
    pl_free(periodic->elements);
    pl_free(periodic->source);
    pl_free(periodic->sign);
    pl_free(periodic->min_volume);
    pl_free(periodic->corner);
    pl_free(periodic->moves_with);
    pl_free(periodic->follower);
    *periodic = (pl_periodic){0};
}
