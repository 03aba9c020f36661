/* plane: the plane that a mesh of triangles lies in, and the coordinates that it has there.
 *
 * Of planes across an axis the other two columns of the file are the coordinates, in the order in
 * which they turn as x and y do: y z, z x. The column across stays as it is in the file.
 */
#include "io/plane.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include "io/file.h"

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

int io_plane_find(io_model *model, planish_error *error) {
    static const int order[] = {2, 0, 1}; /* x and y first: all meshes had to be so once */
    const box b = find_box(model);
    for (int i = 0; i < 3; i++)
        if (is_across(model, &b, order[i])) {
            model->plane = (io_plane){.axis = {(order[i] + 1) % 3, (order[i] + 2) % 3, order[i]}};
            return PLANISH_OK;
        }
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: triangles in space: "
                   "only meshes in a plane can be smoothed, surfaces cannot",
                   model->input.path);
}

/* ---- between plane and file ------------------------------------------------------------------ */

void io_plane_project(const io_plane *plane, const double xyz[3], double uv[2]) {
    uv[0] = xyz[plane->axis[0]];
    uv[1] = xyz[plane->axis[1]];
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

int planish_file_plane(const planish_file *file, planish_plane *plane) {
    if (plane)
        *plane = (planish_plane){.axis = {0, 1, 2}};
    if (!file || file->model.dim == 3)
        return 0;
    const io_plane *p = &file->model.plane;
    if (plane) {
        for (int d = 0; d < 3; d++)
            plane->axis[d] = p->axis[d];
        for (int d = 0; d < 2; d++)
            plane->direction[d][p->axis[d]] = 1;
        plane->normal[p->axis[2]] = 1;
    }
    return !io_plane_is_xy(p);
}
