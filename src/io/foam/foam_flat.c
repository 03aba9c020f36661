/* foam_flat: a layer of cells between empty patches is a mesh of two dimensions.
 *
 * OpenFOAM's meshes of two dimensions are one cell thick, across x, y or z. Points come in pairs, one on
 * either side. A pair becomes one node with two places, which have the same coordinates in the plane:
 * what smoothing moves is written to both. The coordinate across stays that of each place.
 *
 * The mesh stays one of three dimensions, whose nodes are all held, if it is not such a layer to the
 * last digit. A few pairs may differ by roundings: their nodes are held, and the point of the
 * other side stays a node of its own, of no element.
 */
#include "io/foam/foam_flat.h"

#include "base/memory.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef enum side { NO_SIDE, LOWER, UPPER, N_SIDES } side;

typedef struct layer {
    foam_mesh *mesh;
    uint8_t *is_of_side; /* [n_faces] the face is on an empty patch, and on a side of the layer */
    uint8_t *side;       /* [n_points] */
    int32_t *partner;    /* [n_points] the point on the other side; -1: none is known */
    int axis;            /* across the layer */
    double bound[2];     /* of the coordinate there: both that occur */
} layer;

/* ---- the two sides -------------------------------------------------------------------------- */

/** Find the smallest and the largest coordinate of points along an axis. */
static void find_bounds(layer *l, int axis) {
    const foam_mesh *mesh = l->mesh;
    l->axis = axis;
    l->bound[0] = DBL_MAX;
    l->bound[1] = -DBL_MAX;
    for (int64_t k = 0; k < mesh->start[mesh->n_faces]; k++) {
        const double x = mesh->model->xyz[3 * (int64_t)mesh->node[k] + axis];
        l->bound[0] = x < l->bound[0] ? x : l->bound[0];
        l->bound[1] = x > l->bound[1] ? x : l->bound[1];
    }
}

/** Return whether all points of a face have the smallest or the largest coordinate. */
static int is_on_side(const layer *l, int64_t face) {
    const foam_mesh *mesh = l->mesh;
    const double *xyz = mesh->model->xyz + l->axis;
    const double x = xyz[3 * (int64_t)mesh->node[mesh->start[face]]];
    if (x != l->bound[0] && x != l->bound[1])
        return 0;
    for (int64_t k = mesh->start[face]; k < mesh->start[face + 1]; k++)
        if (xyz[3 * (int64_t)mesh->node[k]] != x)
            return 0;
    return 1;
}

/** Mark the faces of empty patches that are on a side. Return their number. */
static int64_t mark_sides(const layer *l, const foam_patches *patches) {
    int64_t n = 0;
    memset(l->is_of_side, 0, (size_t)l->mesh->n_faces);
    for (int64_t i = 0; i < patches->n; i++) {
        const foam_patch *p = &patches->patch[i];
        for (int64_t face = p->first; face < p->first + p->n && io_slice_is(p->type, "empty", 0);
             face++) {
            l->is_of_side[face] = (uint8_t)is_on_side(l, face);
            n += l->is_of_side[face];
        }
    }
    return n;
}

/** Find the sides of points, and of each cell the face on the lower one. Return whether each cell has one
 *  on either side. */
static int find_sides(const layer *l) {
    foam_mesh *mesh = l->mesh;
    int64_t n_upper = 0;
    for (int64_t i = 0; i < mesh->n_cells; i++)
        mesh->base[i] = -1;
    for (int64_t i = 0; i < mesh->n_faces; i++) {
        if (!l->is_of_side[i])
            continue;
        const double x = mesh->model->xyz[3 * (int64_t)mesh->node[mesh->start[i]] + l->axis];
        const side s = x == l->bound[0] ? LOWER : UPPER;
        for (int64_t k = mesh->start[i]; k < mesh->start[i + 1]; k++)
            l->side[mesh->node[k]] = (uint8_t)s;
        n_upper += s == UPPER;
        if (s == LOWER && mesh->base[mesh->owner[i]] >= 0)
            return 0;
        if (s == LOWER)
            mesh->base[mesh->owner[i]] = (int32_t)i;
    }
    for (int64_t i = 0; i < mesh->n_cells; i++)
        if (mesh->base[i] < 0)
            return 0;
    return n_upper == mesh->n_cells;
}

/* ---- pairs ---------------------------------------------------------------------------------- */

/** Note that two points are a pair. Return 0 if one of them has another partner. */
static int note_pair(const layer *l, int32_t a, int32_t b) {
    if ((l->partner[a] >= 0 && l->partner[a] != b) || (l->partner[b] >= 0 && l->partner[b] != a))
        return 0;
    l->partner[a] = b;
    l->partner[b] = a;
    return 1;
}

/** Find the pairs of points by the faces across the layer: quadrilaterals with two points on either side.
 *  Return whether all are such. */
static int find_pairs(const layer *l) {
    enum { CORNERS = 4 };
    const foam_mesh *mesh = l->mesh;
    for (int64_t i = 0; i < mesh->n_faces; i++) {
        const int32_t *p = mesh->node + mesh->start[i];
        int n_across = 0;
        if (l->is_of_side[i])
            continue;
        if (mesh->start[i + 1] - mesh->start[i] != CORNERS)
            return 0;
        for (int k = 0; k < CORNERS; k++) {
            const int32_t a = p[k], b = p[(k + 1) % CORNERS];
            if (l->side[a] == NO_SIDE)
                return 0;
            if (l->side[a] == l->side[b])
                continue;
            n_across++;
            if (!note_pair(l, a, b))
                return 0;
        }
        if (n_across != 2 ||
            l->side[p[0]] + l->side[p[1]] + l->side[p[2]] + l->side[p[3]] != 2 * (LOWER + UPPER))
            return 0;
    }
    return 1;
}

/** Return how far the points of a pair are apart in the plane. */
static double offset_of(const layer *l, int32_t point) {
    const double *a = l->mesh->model->xyz + 3 * (int64_t)point;
    const double *b = l->mesh->model->xyz + 3 * (int64_t)l->partner[point];
    double most = 0;
    for (int d = 0; d < 3; d++)
        if (d != l->axis)
            most = fmax(most, fabs(a[d] - b[d]));
    return most;
}

/** Return whether all pairs stand across the layer, but for roundings. */
static int are_across(const layer *l) {
    const double of_thickness = 1e-6;
    const foam_mesh *mesh = l->mesh;
    for (int64_t i = 0; i < mesh->model->n_nodes; i++)
        if (l->side[i] != NO_SIDE &&
            (l->partner[i] < 0 ||
             offset_of(l, (int32_t)i) > of_thickness * (l->bound[1] - l->bound[0])))
            return 0;
    return 1;
}

/* ---- nodes ---------------------------------------------------------------------------------- */

/** Make one node of each pair: that of its first point, with the lower one's coordinate across. */
static int unite_pairs(const layer *l, planish_error *error) {
    io_model *model = l->mesh->model;
    const int64_t n = model->n_nodes;
    int32_t *first = pl_alloc(n, sizeof *first);
    model->place_across = pl_alloc(n, sizeof *model->place_across);
    model->node_number = pl_alloc(n, sizeof *model->node_number);
    if (!first || !model->place_across || !model->node_number) {
        pl_free(first);
        return pl_fail_memory(error, "the nodes of the file");
    }
    for (int64_t i = 0; i < n; i++) {
        double *across = &model->xyz[3 * i + l->axis];
        const int32_t b = l->partner[i];
        model->place_across[i] = *across;
        model->node_number[i] = i;
        first[i] = (int32_t)i;
        if (b < 0)
            continue;
        if (offset_of(l, (int32_t)i) > 0)
            model->hold[i] |= IO_HELD_REQUIRED;
        else
            first[i] = b < i ? b : (int32_t)i;
        *across = l->bound[0];
    }
    io_unite_places(model, first);
    return PLANISH_OK;
}

/** Return whether the mesh is a layer: l and mesh->base say more then. */
static int is_layer(layer *l, const foam_patches *patches) {
    for (int axis = 2; axis >= 0; axis--) {
        find_bounds(l, axis);
        if (mark_sides(l, patches) == 2 * l->mesh->n_cells && find_sides(l))
            return find_pairs(l) && are_across(l);
    }
    return 0;
}

int foam_flatten(foam_mesh *mesh, const foam_patches *patches, planish_error *error) {
    const int64_t n = mesh->model->n_nodes;
    int is_empty = 0;
    for (int64_t i = 0; i < patches->n; i++)
        is_empty |= io_slice_is(patches->patch[i].type, "empty", 0);
    if (!is_empty)
        return PLANISH_OK;
    layer l = {.mesh = mesh,
               .is_of_side = pl_alloc_zero(mesh->n_faces, 1),
               .side = pl_alloc_zero(n, 1),
               .partner = pl_alloc(n, sizeof *l.partner)};
    mesh->base = pl_alloc(mesh->n_cells, sizeof *mesh->base);
    int status = l.is_of_side && l.side && l.partner && mesh->base
                     ? PLANISH_OK
                     : pl_fail_memory(error, "the nodes of the file");
    for (int64_t i = 0; i < n && !status; i++)
        l.partner[i] = -1;
    if (!status && is_layer(&l, patches)) {
        mesh->dim = 2;
        status = unite_pairs(&l, error);
    }
    pl_free(l.is_of_side);
    pl_free(l.side);
    pl_free(l.partner);
    return status;
}
