/* plane: the plane that a mesh of triangles lies in, and the coordinates that it has there.
 *
 * Of planes across an axis the other two columns of the file are the coordinates, in the order in
 * which they turn as x and y do: y z, z x. The column across stays as it is in the file.
 *
 * In a tilted plane a node is where it is seen along the column across that is nearest to the
 * normal, so that triangles have the signs that they have there; whatever it is off the plane it is
 * off along that column. A node that moves lands on the plane; one that does not keeps its bytes.
 */
#include "io/file/plane.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"

#include "io/file/digits.h"
#include "io/core/number.h"

#include <math.h>

enum { CHUNK_NODES = 1 << 14 };

/* What geometry kernels and roundings leave of a constant column, as a part of the longer side. */
static const double NOISE = 1e-8;

/* ---- finding it ------------------------------------------------------------------------------ */

/** The box of the nodes of triangles. */
typedef struct box {
    double low[3], high[3];
} box;

static box find_box(const io_model *model) {
    const int32_t *nodes = model->triangle.nodes;
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int64_t i = 0; i < 3 * model->triangle.n; i++)
        for (int d = 0; d < 3; d++) {
            const double x = model->xyz[3 * (int64_t)nodes[i] + d];
            b.low[d] = x < b.low[d] ? x : b.low[d];
            b.high[d] = x > b.high[d] ? x : b.high[d];
        }
    return b;
}

/** Whether all nodes of triangles share what column axis has, but for noise. */
static int is_across(const io_model *model, const box *b, int axis) {
    const int p = (axis + 1) % 3, q = (axis + 2) % 3;
    const double most =
        fmax(NOISE * b->high[p] - NOISE * b->low[p], NOISE * b->high[q] - NOISE * b->low[q]);
    const double first = model->xyz[3 * (int64_t)model->triangle.nodes[0] + axis];
    return fabs(b->low[axis] - first) <= most && fabs(b->high[axis] - first) <= most;
}

static int refuse_surface(const io_model *model, const io_plane *plane, int is_thin,
                          double tolerance, planish_error *error) {
    if (is_thin && plane->off <= tolerance * plane->size)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: triangles in space whose nodes lie along a line, as far as can be told "
                       "(they are up to %.3g off it): no plane can be found for them",
                       model->input.path, plane->off);
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: triangles in space (nodes are up to %.3g off the plane that fits them "
                   "best, and %.3g is allowed, %.3g of the size): only meshes in one plane can be "
                   "smoothed, surfaces cannot (a larger tolerance is given by "
                   "--slide-tolerance)",
                   model->input.path, plane->off, tolerance * plane->size, tolerance);
}

static int find_tilted(io_model *model, const io_format *format, const box *b,
                       planish_error *error) {
    const double usual = 1e-8;           /* as planish_find_slides has it */
    const double of_narrow_field = 1e-5; /* where some numbers have fewer digits than others */
    const int narrow_field = 8;
    double tolerance = model->flatness;
    int is_thin = 0;
    if (!(tolerance > 0))
        tolerance = format ? io_tolerance_of_digits(model, format) : 0;
    if (!(tolerance > 0))
        tolerance = usual;
    if (!(model->flatness > 0) && model->precision == PLANISH_ROUNDED &&
        model->field_width <= narrow_field)
        tolerance = fmax(tolerance, of_narrow_field);
    const int status = io_plane_fit(model, b->low, b->high, &model->plane, &is_thin, error);
    if (status || (!is_thin && model->plane.off <= tolerance * model->plane.size))
        return status;
    return refuse_surface(model, &model->plane, is_thin, tolerance, error);
}

int io_plane_find(io_model *model, const io_format *format, planish_error *error) {
    static const int order[] = {2, 0, 1}; /* x and y first: all meshes had to be so once */
    const box b = find_box(model);
    for (int i = 0; i < 3; i++)
        if (is_across(model, &b, order[i])) {
            const double across = model->xyz[3 * (int64_t)model->triangle.nodes[0] + order[i]];
            model->plane = (io_plane){.axis = {(order[i] + 1) % 3, (order[i] + 2) % 3, order[i]},
                                      .origin = {0, 0, across}};
            return PLANISH_OK;
        }
    return find_tilted(model, format, &b, error);
}

/* ---- between plane and file ------------------------------------------------------------------ */

void io_plane_project(const io_plane *plane, const double xyz[3], double uv[2]) {
    const double x = xyz[plane->axis[0]], y = xyz[plane->axis[1]];
    uv[0] = x;
    uv[1] = y;
    if (plane->is_tilted) {
        const double dx = x - plane->origin[0], dy = y - plane->origin[1];
        uv[0] = plane->xu * dx + plane->yu * dy;
        uv[1] = plane->yv * dy;
    }
}

/** What the file holds of a value. */
static double store(const io_model *model, double value) {
    return model->precision == PLANISH_FLOAT ? pl_round_to_float(value)
           : model->precision == PLANISH_ROUNDED
               ? io_round_to_field(value, model->field_width, model->implied_exponent)
               : value;
}

/** On the plane, but for the roundings of the file. */
static void place_on_plane(const io_model *model, const double uv[2], double xyz[3]) {
    const io_plane *plane = &model->plane;
    const double dy = uv[1] / plane->yv, dx = (uv[0] - plane->yu * dy) / plane->xu;
    const double x = store(model, plane->origin[0] + dx), y = store(model, plane->origin[1] + dy);
    const double up =
        plane->slope[0] * (x - plane->origin[0]) + plane->slope[1] * (y - plane->origin[1]);
    xyz[plane->axis[0]] = x;
    xyz[plane->axis[1]] = y;
    xyz[plane->axis[2]] = store(model, plane->origin[2] + up);
}

int io_plane_has_moved(const io_model *model, int64_t node, const double *uv) {
    const double *before = model->uv_read + 2 * node;
    return !pl_is_same(uv[0], before[0]) || !pl_is_same(uv[1], before[1]);
}

static double column_across(const io_model *model, int64_t node) {
    return model->xyz ? model->xyz[3 * node + model->plane.axis[2]] : model->z ? model->z[node] : 0;
}

void io_model_place(const io_model *model, int64_t node, const double *at, double xyz[3]) {
    const io_plane *plane = &model->plane;
    if (model->dim == 3) {
        for (int d = 0; d < 3; d++)
            xyz[d] = at[d];
        return;
    }
    if (plane->is_tilted && io_plane_has_moved(model, node, at)) {
        place_on_plane(model, at, xyz);
        return;
    }
    if (plane->is_tilted) {
        for (int d = 0; d < 3; d++)
            xyz[d] = model->xyz[3 * node + d];
        return;
    }
    xyz[plane->axis[0]] = at[0];
    xyz[plane->axis[1]] = at[1];
    xyz[plane->axis[2]] = column_across(model, node);
}

/** Nodes to be placed. */
typedef struct placing {
    const io_model *model;
    const double *coordinates;
    double *places;
} placing;

static void place_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const placing *p = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        io_model_place(p->model, i, p->coordinates + p->model->dim * i, p->places + 3 * i);
}

int io_model_places(const io_model *model, const double *coordinates, int threads,
                    const double **places, double **owned, planish_error *error) {
    *owned = NULL;
    *places = coordinates;
    if (model->dim == model->written)
        return PLANISH_OK;
    *places = *owned = pl_alloc(model->n_nodes, 3 * sizeof **owned);
    if (!*owned)
        return pl_fail_memory(error, "the places of nodes");
    placing p = {model, coordinates, *owned};
    pl_parallel_for(threads, model->n_nodes, CHUNK_NODES, place_chunk, &p);
    return PLANISH_OK;
}

const double *io_model_places_read(const io_model *model) {
    return model->xyz ? model->xyz : model->coordinates;
}

/* ---- questions ------------------------------------------------------------------------------- */

int planish_file_place(const planish_file *file, int64_t first, int64_t n,
                       const double *coordinates, double *xyz, planish_error *error) {
    if (!file || n < 0 || (n > 0 && (!coordinates || !xyz)))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, coordinates and xyz must not be NULL, and n not be negative");
    if (first < 0 || first > file->model.n_nodes || n > file->model.n_nodes - first)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "nodes %lld to %lld are not all among the %lld of the file",
                       (long long)first, (long long)(first + n - 1),
                       (long long)file->model.n_nodes);
    const pl_outside outside = pl_call_enter(NULL);
    for (int64_t i = 0; i < n; i++)
        io_model_place(&file->model, first + i, coordinates + file->model.dim * i, xyz + 3 * i);
    pl_call_leave(&outside);
    return PLANISH_OK;
}

/** The frame in space: u goes along the slope of x, v turns left of it. */
static void describe(const io_plane *p, planish_plane *plane) {
    const double *slope = p->slope;
    const double xu = p->is_tilted ? p->xu : 1, yv = p->is_tilted ? p->yv : 1;
    const double length = sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
    const double u[3] = {1 / xu, 0, slope[0] / xu};
    const double v[3] = {-p->yu * u[0] / yv, 1 / yv, (slope[1] - p->yu * u[2]) / yv};
    const double normal[3] = {-slope[0] / length, -slope[1] / length, 1 / length};
    plane->is_tilted = p->is_tilted;
    plane->off = p->off;
    for (int d = 0; d < 3; d++) {
        const int axis = plane->axis[d] = p->axis[d];
        plane->origin[axis] = p->origin[d];
        plane->direction[0][axis] = u[d];
        plane->direction[1][axis] = v[d];
        plane->normal[axis] = normal[d];
    }
}

int planish_file_plane(const planish_file *file, planish_plane *plane) {
    if (plane)
        *plane = (planish_plane){.axis = {0, 1, 2}};
    if (!file || file->model.dim == 3)
        return 0;
    const io_plane *p = &file->model.plane;
    if (plane)
        describe(p, plane);
    return !io_plane_is_xy(p);
}
