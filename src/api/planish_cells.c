/* planish_cells: elements of every type: check, enter, measure. */
#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/target.h"
#include "quality/cell_measure.h"
#include "shape/layer_heights.h"
#include "shape/layer_shapes.h"
#include "shape/size_field.h"
#include "topology/cells.h"
#include "topology/points.h"
#include "topology/topology.h"

#include <inttypes.h>
#include <string.h>

/** A measurement, and what it owns. */
typedef struct cells_call {
    int threads;
    planish_cells cells; /* those of the mesh, or its simplices */
    uint8_t *type;       /* of simplices, or NULL */
    int64_t *offset;
    int32_t *node;
    double *coordinates; /* without strides, or NULL: the mesh's are such */
    double *reference;   /* the same of mesh.reference */
    int8_t *sign;
    pl_cell_rules rules;
    pl_layer_shapes layers;
    pl_size_field field; /* of metrics */
    double *sizes;       /* [n_nodes][field.n_numbers] where the nodes are */
} cells_call;

static void release(cells_call *c) {
    pl_free(c->type);
    pl_free(c->offset);
    pl_free(c->node);
    pl_free(c->coordinates);
    pl_free(c->reference);
    pl_free(c->sign);
    pl_cell_rules_free(&c->rules);
    pl_layer_shapes_free(&c->layers);
    pl_size_field_destroy(&c->field);
    pl_free(c->sizes);
}

/** Make cells of the mesh's simplices. */
static int take_simplices(const planish_mesh *mesh, cells_call *c, planish_error *error) {
    const int64_t n = mesh->n_elements, k = mesh->dim + 1;
    const int is_wide = mesh->elements == NULL;
    c->type = pl_alloc(n, sizeof *c->type);
    c->offset = pl_alloc(n + 1, sizeof *c->offset);
    c->node = is_wide ? pl_alloc(n * k, sizeof *c->node) : NULL;
    if (!c->type || !c->offset || (is_wide && !c->node))
        return pl_fail_memory(error, "the measures of elements");
    memset(c->type, mesh->dim == 3 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE, (size_t)n);
    for (int64_t i = 0; i <= n; i++)
        c->offset[i] = i * k;
    for (int64_t i = 0; i < n; i++) {
        const int status = pl_check_element(mesh, i, error);
        if (status)
            return status;
        for (int j = 0; is_wide && j < k; j++)
            c->node[i * k + j] = (int32_t)pl_corner(mesh, i, j);
    }
    c->cells = (planish_cells){
        .n = n, .type = c->type, .offset = c->offset, .node = is_wide ? c->node : mesh->elements};
    return PLANISH_OK;
}

/** Coordinates without strides; NULL: no memory. */
static double *gather(const planish_mesh *mesh, const double *x, int threads) {
    const pl_points points = pl_points_of(mesh, x);
    double *dense = pl_alloc(mesh->n_nodes * mesh->dim, sizeof *dense);
    if (dense)
        pl_points_gather(&points, threads, dense);
    return dense;
}

/** Check the mesh, and take its elements and coordinates. */
static int take_mesh(const planish_mesh *mesh, cells_call *c, planish_error *error) {
    const int is_empty = mesh->cells && mesh->cells->n == 0 && mesh->n_elements == 0;
    int status = is_empty ? pl_check_nodes(mesh, error) : pl_check_counts(mesh, error);
    if (!status && !mesh->cells)
        status = take_simplices(mesh, c, error);
    if (status)
        return status;
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    status = pl_points_check(&points, c->threads, error);
    if (!status && mesh->cells) {
        c->cells = *mesh->cells;
        status = pl_check_cells(&c->cells, mesh->n_nodes, c->threads, error);
    }
    if (status || pl_points_are_dense(&points))
        return status;
    c->coordinates = gather(mesh, mesh->coordinates, c->threads);
    c->reference = mesh->reference ? gather(mesh, mesh->reference, c->threads) : NULL;
    return c->coordinates && !c->reference == !mesh->reference
               ? PLANISH_OK
               : pl_fail_memory(error, "the coordinates");
}

/** Elements as they are to be. */
typedef struct wanted {
    int dim;
    const planish_cells *cells;
    const double *reference; /* [n_nodes][dim] */
    const int8_t *sign;      /* [cells] */
    const pl_layer_shapes *layers;
    int n_numbers;
    const double *sizes; /* [n_nodes][n_numbers] matrices */
} wanted;

/** Edges of corner c of a cell in the reference; returns its determinant. */
static double reference_edges(const wanted *w, int64_t cell, int c, double edges[3][3]) {
    const uint8_t *neighbour = pl_cell_type_of(w->cells->type[cell])->shape->neighbour[c];
    const int32_t *node = w->cells->node + w->cells->offset[cell];
    const double *x[4] = {w->reference + (int64_t)node[c] * w->dim};
    for (int j = 0; j < w->dim; j++)
        x[j + 1] = w->reference + (int64_t)node[neighbour[j]] * w->dim;
    pl_edges(w->dim, x, edges);
    return w->sign[cell] * pl_determinant_of_edges(w->dim, (const double(*)[3])edges);
}

/** Target of a corner by the reference. */
static int target_of_reference(const void *targets, int64_t cell, int c, pl_target *target,
                               pl_metric *metric) {
    const wanted *w = targets;
    (void)metric;
    double edges[3][3] = {{0}};
    reference_edges(w, cell, c, edges);
    return pl_target_make(w->dim, (const double(*)[3])edges, w->sign[cell], target);
}

/** Target of a corner by its layer. */
static int target_of_layer(const void *targets, int64_t cell, int c, pl_target *target,
                           pl_metric *metric) {
    const wanted *w = targets;
    (void)metric;
    return pl_layer_shapes_target(w->layers, pl_cell_type_of(w->cells->type[cell])->shape, cell, c,
                                  target);
}

/** Target of a corner by the metrics at its nodes. */
static int target_of_metric(const void *targets, int64_t cell, int c, pl_target *target,
                            pl_metric *metric) {
    const wanted *w = targets;
    const pl_cell_shape *shape = pl_cell_type_of(w->cells->type[cell])->shape;
    const int32_t *of_cell = w->cells->node + w->cells->offset[cell];
    int32_t node[4] = {of_cell[c]};
    double edges[3][3] = {{0}};
    for (int j = 0; j < w->dim; j++)
        node[j + 1] = of_cell[shape->neighbour[c][j]];
    const pl_sized_corners corner = {
        .dim = w->dim, .n = 1, .node = node, .n_numbers = w->n_numbers, .size = w->sizes};
    pl_sized_metric(&corner, 0, metric);
    pl_ideal_edges(shape, edges);
    return pl_target_make(w->dim, (const double(*)[3])edges, 1, target);
}

/** Find the sizes of metrics where the nodes are. */
static int find_metrics(const planish_mesh *mesh, const double *coordinates, cells_call *c,
                        planish_error *error) {
    const int status = pl_size_field_create(mesh, coordinates, c->threads, &c->field, error);
    if (status)
        return status;
    c->sizes = pl_alloc(mesh->n_nodes * c->field.n_numbers, sizeof *c->sizes);
    if (!c->sizes)
        return pl_fail_memory(error, "the measures of elements");
    pl_size_field_find(&c->field, coordinates, NULL, c->threads, c->sizes);
    return PLANISH_OK;
}

/** Say what is wrong with a cell that has no target. */
static int complain(const wanted *w, int64_t cell, planish_error *error) {
    double edges[3][3] = {{0}}, D = NAN;
    pl_target target;
    for (int c = 0; c < pl_cell_type_of(w->cells->type[cell])->shape->n_measured; c++) {
        D = reference_edges(w, cell, c, edges);
        if (!target_of_reference(w, cell, c, &target, NULL))
            break;
    }
    return pl_fail_at(error, PLANISH_ERROR_MESH, cell, -1,
                      "element %" PRId64 " %s in mesh.reference; all elements must be valid there, "
                      "oriented as in the mesh",
                      cell, pl_target_flaw(w->dim, (const double(*)[3])edges, D));
}

/** Return the mesh at its reference, or without one at coordinates. */
static planish_mesh as_before(const planish_mesh *mesh, const cells_call *c,
                              const double *coordinates) {
    const double *reference = c->reference ? c->reference : mesh->reference;
    return (planish_mesh){.dim = mesh->dim,
                          .n_nodes = mesh->n_nodes,
                          .coordinates = reference ? reference : coordinates,
                          .cells = &c->cells,
                          .n_elements = c->cells.n};
}

/** Find the elements as they are to be. */
static int find_wanted(const planish_mesh *mesh, cells_call *c, wanted *w, planish_error *error) {
    const double *reference = c->reference ? c->reference : mesh->reference;
    const double *coordinates = c->coordinates ? c->coordinates : mesh->coordinates;
    const planish_mesh as_it_was = as_before(mesh, c, coordinates);
    if (mesh->metric) {
        const int status = find_metrics(mesh, coordinates, c, error);
        if (status)
            return status;
    }
    *w = (wanted){.dim = mesh->dim,
                  .cells = &c->cells,
                  .reference = reference,
                  .sign = c->sign,
                  .layers = &c->layers,
                  .n_numbers = c->field.n_numbers,
                  .sizes = c->sizes};
    return mesh->is_layer
               ? pl_layer_shapes_find(&as_it_was, mesh->is_layer, c->threads, &c->layers, error)
               : PLANISH_OK;
}

/** Measure the cells that have been taken. */
static int measure(const planish_mesh *mesh, double rounding, cells_call *c,
                   planish_cell_quality *quality, const planish_cell_values *values,
                   planish_error *error) {
    const double *coordinates = c->coordinates ? c->coordinates : mesh->coordinates;
    wanted w;
    c->sign = pl_alloc(c->cells.n, sizeof *c->sign);
    if (!c->sign)
        return pl_fail_memory(error, "the measures of elements");
    int status = pl_orient_cells(&c->cells, mesh->dim, mesh->n_nodes, coordinates, c->threads,
                                 c->sign, error);
    if (!status)
        status = find_wanted(mesh, c, &w, error);
    if (status)
        return status;
    /* With sizes all shapes are the ideal ones. */
    const pl_cell_mesh cells = {.dim = mesh->dim,
                                .cells = &c->cells,
                                .coordinates = coordinates,
                                .sign = c->sign,
                                .rounding = rounding,
                                .target = mesh->metric      ? target_of_metric
                                          : mesh->size      ? NULL
                                          : mesh->is_layer  ? target_of_layer
                                          : mesh->reference ? target_of_reference
                                                            : NULL,
                                .targets = &w,
                                .has_metric = mesh->metric != NULL};
    int64_t flawed = -1;
    status = pl_cell_rules_make(&cells, &c->rules);
    if (!status)
        status = pl_measure_cells(&cells, &c->rules, c->threads, quality, values, &flawed);
    return status == PLANISH_ERROR_MESH ? complain(&w, flawed, error)
           : status                     ? pl_fail_memory(error, "the measures of elements")
                                        : PLANISH_OK;
}

/** Check what every call is given. */
static int check_call(const planish_mesh *mesh, int threads, planish_error *error) {
    if (mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "elements of any type are measured in the whole mesh, not in a part of it");
    return pl_check_threads(threads, error);
}

int planish_measure_cells(const planish_mesh *mesh, double rounding, int threads,
                          planish_cell_quality *quality, const planish_cell_values *values,
                          planish_error *error) {
    cells_call c = {.cells = {.n = 0}};
    planish_mesh without_targets;
    if (!mesh || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and quality must not be NULL");
    if (!(rounding >= 0))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "rounding is %g; give 0 or more", rounding);
    int status = check_call(mesh, threads, error);
    if (!status && values)
        status = pl_check_reserved("planish_cell_values", values->reserved, sizeof values->reserved,
                                   error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    c.threads = pl_thread_count(threads);
    status = take_mesh(mesh, &c, error);
    if (!status)
        mesh = pl_drop_targets(mesh, &without_targets);
    if (!status)
        status = measure(mesh, rounding, &c, quality, values, error);
    release(&c);
    pl_call_leave(&outside);
    return status;
}

int planish_measure_layers(const planish_mesh *mesh, int threads, planish_layer_heights *heights,
                           double *off, planish_error *error) {
    cells_call c = {.cells = {.n = 0}};
    if (heights)
        *heights = (planish_layer_heights){.n_rows = 0};
    if (!mesh || !mesh->is_layer || !heights)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh, mesh.is_layer and heights must not be NULL");
    const int refused = check_call(mesh, threads, error);
    if (refused)
        return refused;
    const pl_outside outside = pl_call_enter(NULL);
    c.threads = pl_thread_count(threads);
    int status = take_mesh(mesh, &c, error);
    if (!status) {
        const double *now = c.coordinates ? c.coordinates : mesh->coordinates;
        const planish_mesh as_it_was = as_before(mesh, &c, now);
        status =
            pl_layer_heights_find(&as_it_was, mesh->is_layer, now, c.threads, heights, off, error);
    }
    release(&c);
    pl_call_leave(&outside);
    return status;
}
