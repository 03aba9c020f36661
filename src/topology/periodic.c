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

/** The work on all groups; arrays [n] over the mesh's nodes. */
typedef struct work {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    double tolerance;  /* of lengths */
    int32_t *next;     /* circular lists of groups */
    int32_t *leader;   /* of each node, itself outside of groups */
    uint8_t *shift_of; /* followers: their translation, else NO_SHIFT */
    int n_shifts;
    double shift[MAX_SHIFTS][3]; /* from leader to follower */
    int64_t pairs[MAX_SHIFTS];   /* followers of each */
    int32_t *image;              /* of the shift under way, or -1 */
    uint8_t *is_copied;          /* [m] elements, likewise */
    int64_t image_capacity, copy_capacity;
    pl_periodic *out;
} work;

static const double *place(const work *w, int32_t node) {
    return w->mesh->coordinates + (int64_t)node * w->mesh->dim;
}

/* ---- groups -------------------------------------------------------------------------------- */

/** Hold all nodes of a group. */
static void hold(const work *w, int32_t node, uint8_t *slides) {
    slides[node] = 0;
    for (int32_t i = w->next[node]; i != node; i = w->next[i])
        slides[i] = 0;
}

/** Splice the lists of both nodes, unless they are one; groups that would be too large are held. */
static void join(const work *w, int32_t a, int32_t b, uint8_t *slides) {
    int size = 1;
    for (int32_t i = w->next[a]; i != a; i = w->next[i], size++)
        if (i == b)
            return;
    if (a == b)
        return;
    for (int32_t i = w->next[b]; i != b; i = w->next[i])
        size++;
    if (size >= MAX_GROUP) {
        hold(w, a, slides);
        hold(w, b, slides);
        return;
    }
    const int32_t next = w->next[a];
    w->next[a] = w->next[b];
    w->next[b] = next;
}

/** Nodes of a group in a direction that no translation of a lattice is orthogonal to. */
static double along(const work *w, int32_t node) {
    static const double generic[3] = {1, 0.6180339887498949, 0.3141592653589793};
    return pl_dot(w->mesh->dim, place(w, node), generic);
}

/** The first of its group along that direction leads it. */
static int32_t leader_of(const work *w, int32_t node) {
    int32_t first = node;
    for (int32_t i = w->next[node]; i != node; i = w->next[i])
        if (along(w, i) < along(w, first) || (along(w, i) == along(w, first) && i < first))
            first = i;
    return first;
}

/** Whether two nodes may move in the same directions; of surfaces only the caller knows. */
static int move_alike(const planish_mesh *mesh, int32_t a, int32_t b) {
    const int dim = mesh->dim;
    double u[3], v[3], same = 0, opposite = 0;
    if (mesh->constraint[a] != mesh->constraint[b] || mesh->constraint[a] == PLANISH_ON_SURFACE ||
        !pl_unit(dim, mesh->direction + (int64_t)a * dim, u) ||
        !pl_unit(dim, mesh->direction + (int64_t)b * dim, v))
        return 0;
    for (int d = 0; d < dim; d++) {
        same = fmax(same, fabs(u[d] - v[d]));
        opposite = fmax(opposite, fabs(u[d] + v[d]));
    }
    return fmin(same, opposite) <= PARALLEL_TOLERANCE;
}

static int is_shift(const work *w, const double *shift, const double *from, const double *to) {
    double largest = 0;
    for (int d = 0; d < w->mesh->dim; d++)
        largest = fmax(largest, fabs(to[d] - from[d] - shift[d]));
    return largest <= w->tolerance;
}

/** The translation of a follower, made if it is new; NO_SHIFT if there are too many. */
static uint8_t find_shift(work *w, int32_t node) {
    const double *from = place(w, w->leader[node]), *to = place(w, node);
    for (int s = 0; s < w->n_shifts; s++)
        if (is_shift(w, w->shift[s], from, to))
            return (uint8_t)s;
    if (w->n_shifts == MAX_SHIFTS)
        return NO_SHIFT;
    pl_subtract(w->mesh->dim, to, from, w->shift[w->n_shifts]);
    return (uint8_t)w->n_shifts++;
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

/** Hold groups two of whose nodes are in one element: it would not be what its copies are. */
static void hold_thin(const work *w, uint8_t *slides) {
    const int corners = w->mesh->dim + 1;
    for (int64_t i = 0; i < w->mesh->n_elements; i++) {
        const int32_t *node = w->mesh->elements + i * corners;
        for (int j = 0; j < corners; j++)
            for (int k = j + 1; k < corners; k++)
                if (w->leader[node[j]] == w->leader[node[k]])
                    hold(w, node[j], slides);
    }
}

/** Groups, their leaders and translations; those that cannot move together are held. */
static void find_groups(work *w, uint8_t *slides) {
    const planish_mesh *mesh = w->mesh;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        w->next[i] = (int32_t)i;
    for (int64_t i = 0; i < mesh->n_periodic; i++)
        join(w, mesh->periodic[2 * i], mesh->periodic[2 * i + 1], slides);
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        w->leader[i] = leader_of(w, (int32_t)i);
        w->shift_of[i] = NO_SHIFT;
    }
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int32_t node = (int32_t)i, leader = w->leader[i];
        if (leader == node)
            continue;
        w->shift_of[i] = find_shift(w, node);
        if (w->shift_of[i] != NO_SHIFT)
            w->pairs[w->shift_of[i]]++;
        if (!slides[i] || !slides[leader] || w->shift_of[i] == NO_SHIFT ||
            !move_alike(mesh, leader, node))
            hold(w, node, slides);
    }
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        if (w->shift_of[i] != NO_SHIFT && w->pairs[w->shift_of[i]] < MIN_PAIRS)
            hold(w, (int32_t)i, slides);
    hold_thin(w, slides);
}

/* ---- copies -------------------------------------------------------------------------------- */

/** The node of the mesh where node comes to by the inverse of a translation; -1: there is none. */
static int32_t partner(const work *w, int32_t node, int s) {
    for (int32_t i = w->next[node]; i != node; i = w->next[i])
        if (is_shift(w, w->shift[s], place(w, i), place(w, node)))
            return i;
    return -1;
}

static int add_follower(pl_periodic *out, int64_t *capacity, pl_follower follower) {
    pl_follower *grown =
        pl_grow(out->follower, out->n_followers, out->n_followers + 1, capacity, sizeof *grown);
    if (!grown)
        return -1;
    out->follower = grown;
    out->follower[out->n_followers++] = follower;
    return 0;
}

/** Find the node that stands next to a follower as node stands next to its leader: a node of the
 *  mesh, or an image; -1 without memory. */
static int32_t moved_node(work *w, int32_t node, int32_t follower, int s) {
    const int32_t same = partner(w, node, s);
    if (same >= 0)
        return same;
    if (w->image[node] < 0) {
        if (w->out->n_nodes == INT32_MAX ||
            add_follower(w->out, &w->image_capacity,
                         (pl_follower){.node = (int32_t)w->out->n_nodes,
                                       .of = node,
                                       .from = follower,
                                       .to = w->leader[follower]}) != 0)
            return -1;
        w->image[node] = (int32_t)w->out->n_nodes++;
    }
    return w->image[node];
}

/** Append a copy of an element at a follower. */
static int copy_element(work *w, int32_t element, int32_t follower, int s) {
    pl_periodic *out = w->out;
    const int corners = w->mesh->dim + 1;
    if (out->n_elements == INT32_MAX)
        return -1;
    int64_t capacity = w->copy_capacity;
    int32_t *elements = pl_grow(out->elements, out->n_elements, out->n_elements + 1, &capacity,
                                (size_t)corners * sizeof *elements);
    if (elements)
        out->elements = elements;
    int32_t *source = pl_grow(out->source, out->n_elements, out->n_elements + 1, &w->copy_capacity,
                              sizeof *source);
    if (source)
        out->source = source;
    if (!elements || !source)
        return -1;
    for (int j = 0; j < corners; j++) {
        const int32_t node =
            moved_node(w, w->mesh->elements[(int64_t)element * corners + j], follower, s);
        if (node < 0)
            return -1;
        out->elements[out->n_elements * corners + j] = node;
    }
    out->source[out->n_elements++] = element;
    return 0;
}

/** Copies of the elements at the followers that move, for one translation. */
static int copy_layer(work *w, const uint8_t *slides, int s) {
    const pl_incidence *incidence = w->incidence;
    for (int64_t i = 0; i < w->mesh->n_nodes; i++)
        w->image[i] = -1;
    memset(w->is_copied, 0, (size_t)w->mesh->n_elements);
    for (int64_t i = 0; i < w->mesh->n_nodes; i++) {
        if (w->shift_of[i] != s || !slides[i])
            continue;
        for (int64_t k = incidence->offset[i]; k < incidence->offset[i + 1]; k++) {
            const int32_t element = incidence->element[k];
            if (!w->is_copied[element] && copy_element(w, element, (int32_t)i, s) != 0)
                return -1;
            w->is_copied[element] = 1;
        }
    }
    return 0;
}

/** Find the node that every node moves with: its leader; for an image, the leader of its source. */
static int find_movers(const work *w) {
    pl_periodic *out = w->out;
    out->moves_with = pl_alloc(out->n_nodes, sizeof *out->moves_with);
    if (!out->moves_with)
        return -1;
    memcpy(out->moves_with, w->leader, (size_t)w->mesh->n_nodes * sizeof *w->leader);
    for (int64_t k = 0; k < out->n_followers; k++)
        out->moves_with[out->follower[k].node] = w->leader[out->follower[k].of];
    return 0;
}

/** Signs and minimum volumes of the copies are those of their elements. */
static int extend(const work *w, const int8_t *sign) {
    pl_periodic *out = w->out;
    const double *least = w->mesh->min_volume;
    out->sign = sign ? pl_alloc(out->n_elements, sizeof *out->sign) : NULL;
    out->min_volume = least ? pl_alloc(out->n_elements, sizeof *out->min_volume) : NULL;
    if ((sign && !out->sign) || (least && !out->min_volume))
        return -1;
    for (int64_t i = 0; i < out->n_elements; i++) {
        if (sign)
            out->sign[i] = sign[out->source[i]];
        if (least)
            out->min_volume[i] = least[out->source[i]];
    }
    return 0;
}

static int build(work *w, const int8_t *sign, uint8_t *slides) {
    const planish_mesh *mesh = w->mesh;
    pl_periodic *out = w->out;
    const int64_t n = mesh->n_nodes, m = mesh->n_elements;
    const int corners = mesh->dim + 1;
    out->n_nodes = n;
    out->n_elements = w->copy_capacity = m;
    out->elements = pl_alloc(m * corners, sizeof *out->elements);
    out->source = pl_alloc(m, sizeof *out->source);
    if (!out->elements || !out->source)
        return -1;
    memcpy(out->elements, mesh->elements, (size_t)(m * corners) * sizeof *out->elements);
    for (int64_t i = 0; i < m; i++)
        out->source[i] = (int32_t)i;
    find_groups(w, slides);
    for (int64_t i = 0; i < n; i++)
        if (w->shift_of[i] != NO_SHIFT && slides[i]) {
            const int32_t node = (int32_t)i, leader = w->leader[i];
            if (add_follower(out, &w->image_capacity,
                             (pl_follower){node, leader, leader, node, {0}, {0}}) != 0)
                return -1;
        }
    for (int s = 0; s < w->n_shifts; s++)
        if (copy_layer(w, slides, s) != 0)
            return -1;
    return find_movers(w) != 0 || extend(w, sign) != 0 ? -1 : 0;
}

/** Half the longest side of the box of all nodes of pairs: others may be anywhere. */
static double half_size_of(const planish_mesh *mesh) {
    double size = 0;
    for (int d = 0; d < mesh->dim; d++) {
        double low = INFINITY, high = -INFINITY;
        for (int64_t i = 0; i < 2 * mesh->n_periodic; i++) {
            const double x = mesh->coordinates[(int64_t)mesh->periodic[i] * mesh->dim + d];
            low = fmin(low, x);
            high = fmax(high, x);
        }
        size = fmax(size, high / 2 - low / 2);
    }
    return size;
}

int pl_periodic_create(const planish_mesh *mesh, const pl_incidence *incidence, const int8_t *sign,
                       uint8_t *slides, pl_periodic *out, planish_error *error) {
    int status = PLANISH_OK;
    *out = (pl_periodic){0};
    work w = {.mesh = mesh,
              .incidence = incidence,
              .tolerance = 2 * SHIFT_TOLERANCE * half_size_of(mesh),
              .next = pl_alloc(mesh->n_nodes, sizeof *w.next),
              .leader = pl_alloc(mesh->n_nodes, sizeof *w.leader),
              .shift_of = pl_alloc(mesh->n_nodes, 1),
              .image = pl_alloc(mesh->n_nodes, sizeof *w.image),
              .is_copied = pl_alloc(mesh->n_elements, 1),
              .out = out};
    if (!w.next || !w.leader || !w.shift_of || !w.image || !w.is_copied ||
        build(&w, sign, slides) != 0)
        status = pl_fail_memory(error, "periodic nodes");
    pl_free(w.next);
    pl_free(w.leader);
    pl_free(w.shift_of);
    pl_free(w.image);
    pl_free(w.is_copied);
    return status;
}

void pl_periodic_destroy(pl_periodic *periodic) {
    pl_free(periodic->elements);
    pl_free(periodic->source);
    pl_free(periodic->sign);
    pl_free(periodic->min_volume);
    pl_free(periodic->moves_with);
    pl_free(periodic->follower);
    *periodic = (pl_periodic){0};
}
