/* finish: a model as a reader leaves it becomes a mesh to be smoothed.
 *
 * In: nodes and cells. Out: the dimension, the plane of triangles, coordinates, and which nodes
 * lines, triangles and points hold.
 */
#include "io/file/finish.h"

#include "io/file/plane.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

enum { CHUNK_NODES = 1 << 14 };

/** Cells that hold their nodes. */
typedef struct holders {
    io_model *model;
    const io_cells *cells;
    int corners;
    uint8_t reason;
} holders;

static void hold_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const holders *h = context;
    (void)thread;
    for (int64_t i = h->corners * begin; i < h->corners * end; i++)
        __atomic_fetch_or(&h->model->hold[h->cells->nodes[i]], h->reason, __ATOMIC_RELAXED);
}

static void hold_cells(io_model *model, const io_cells *cells, int corners, uint8_t reason) {
    holders h = {model, cells, corners, reason};
    pl_parallel_for(model->threads, io_cells_telling(cells), CHUNK_NODES, hold_chunk, &h);
}

static int finish_solid(io_model *model, planish_error *error) {
    if (model->columns < 3)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: tetrahedra in two dimensions; a third coordinate is missing",
                       model->input.path);
    model->dim = model->written = 3;
    model->coordinates = model->xyz;
    model->n_lower += model->triangle.n;
    hold_cells(model, &model->triangle, 3, IO_HELD_BY_TRIANGLE);
    return PLANISH_OK;
}

/** z is not smoothed, but shown (view.c). */
static int keep_z(io_model *model, planish_error *error) {
    int any = 0;
    for (int64_t i = 0; i < model->n_nodes; i++)
        any |= model->xyz[3 * i + 2] != 0;
    if (!any)
        return PLANISH_OK;
    model->z = pl_alloc(model->n_nodes, sizeof *model->z);
    if (!model->z)
        return pl_fail_memory(error, "coordinates");
    for (int64_t i = 0; i < model->n_nodes; i++)
        model->z[i] = model->xyz[3 * i + 2];
    return PLANISH_OK;
}

/** The file's own places are kept where its columns are not those of the coordinates. */
static int finish_plane(io_model *model, const io_format *format, planish_error *error) {
    int status = io_plane_find(model, format, error);
    if (status)
        return status;
    model->dim = 2;
    model->written = io_plane_is_xy(&model->plane) ? 2 : 3;
    model->coordinates = pl_alloc(model->n_nodes, 2 * sizeof *model->coordinates);
    if (!model->coordinates)
        return pl_fail_memory(error, "coordinates");
    for (int64_t i = 0; i < model->n_nodes; i++)
        io_plane_project(&model->plane, model->xyz + 3 * i, model->coordinates + 2 * i);
    if (model->plane.is_tilted)
        return io_plane_keep(model, error);
    if (model->written == 3)
        return PLANISH_OK;
    status = keep_z(model, error);
    pl_free(model->xyz);
    model->xyz = NULL;
    return status;
}

/** Points that name every node say nothing of any: Mmg writes all vertices so, and others vertex
 *  cells. */
static void drop_plain_points(io_model *model) {
    for (int64_t i = 0; i < model->n_nodes; i++)
        if (!(model->hold[i] & IO_HELD_BY_POINT))
            return;
    for (int64_t i = 0; i < model->n_nodes; i++)
        model->hold[i] &= (uint8_t)~IO_HELD_BY_POINT;
}

int io_model_finish(io_model *model, const io_format *format, planish_error *error) {
    const int status = io_model_find_plain(model, error);
    if (status)
        return status;
    drop_plain_points(model);
    model->n_lower += model->line.n;
    hold_cells(model, &model->line, 2, IO_HELD_BY_LINE);
    if (model->tetrahedron.n > 0)
        return finish_solid(model, error);
    if (model->triangle.n > 0)
        return finish_plane(model, format, error);
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: no tetrahedron and no triangle in it: there is nothing to smooth",
                   model->input.path);
}
