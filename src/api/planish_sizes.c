/* planish_sizes: sizes of elements: those that they have, and against those that they are to have. */
#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/size_field.h"
#include "topology/topology.h"

#include <math.h>

/** A call, and what it owns. */
typedef struct sizes_call {
    planish_mesh mesh; /* the caller's, but for layers and targets */
    int threads;
    pl_dense dense;
    pl_size_field field;
    double *size;      /* [n_nodes][corners.n_numbers] */
    pl_target *target; /* [corners] */
    pl_sized_corners corners;
} sizes_call;

static void release(sizes_call *c) {
    pl_dense_destroy(&c->dense);
    pl_size_field_destroy(&c->field);
    pl_free(c->size);
    pl_free(c->target);
}

/** Check the mesh, and take its corners and coordinates. */
static int take_mesh(const planish_mesh *mesh, int threads, sizes_call *c, planish_error *error) {
    int status = pl_check_threads(threads, error);
    if (status)
        return status;
    if (mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "sizes of elements are found in the whole mesh, not in a part of it");
    c->threads = pl_thread_count(threads);
    c->mesh = *mesh;
    c->mesh.is_layer = NULL;
    status = pl_dense_create(&c->mesh, c->threads, &c->dense, error);
    if (status)
        return status;
    c->corners = (pl_sized_corners){.dim = mesh->dim,
                                    .n_numbers = 1,
                                    .n = c->dense.mesh.n_elements,
                                    .node = c->dense.mesh.elements,
                                    .corner = c->dense.corner,
                                    .x = c->dense.mesh.coordinates};
    c->target = pl_alloc(c->corners.n, sizeof *c->target);
    c->size = pl_alloc(mesh->n_nodes * PL_MOST_SYMMETRIC, sizeof *c->size);
    if (!c->target || !c->size)
        return pl_fail_memory(error, "the sizes of elements");
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        c->size[i] = 1;
    c->corners.size = c->size;
    pl_sizes_fit(&c->corners, 1, c->threads, c->target, NULL);
    return PLANISH_OK;
}

/** Cells of the corners. */
static int64_t count_cells(const sizes_call *c) {
    return c->dense.corner ? c->dense.n_cells : c->corners.n;
}

/** First corner of a cell. */
static int64_t first_of(const sizes_call *c, int64_t cell) {
    return c->dense.corner ? c->dense.cell_begin[cell] : cell;
}

/** Return the length of a cell in units of what its targets say: the root of the mean of its corners' tau. */
static double ratio_of(const sizes_call *c, int64_t cell) {
    const int64_t begin = first_of(c, cell), end = first_of(c, cell + 1);
    double sum = 0;
    for (int64_t i = begin; i < end; i++)
        sum += pl_sized_measure(&c->corners, i) / c->target[i].measure;
    const double mean = sum / (double)(end - begin);
    return c->mesh.dim == 3 ? pl_cube_root(mean) : sqrt(mean);
}

/** Caller's number of a cell. */
static int64_t number_of(const sizes_call *c, int64_t cell) {
    return c->dense.cell_of ? c->dense.cell_of[first_of(c, cell)] : cell;
}

/* ---- against a field --------------------------------------------------------------------------- */

/** Find the sizes that are wanted where the nodes are, and the targets. Returns the factor of sizes. */
static double fit(sizes_call *c) {
    c->corners.n_numbers = c->field.n_numbers;
    pl_size_field_find(&c->field, c->dense.mesh.coordinates, NULL, c->threads, c->size);
    return pl_sizes_fit(&c->corners, 0, c->threads, c->target, NULL) / c->field.largest;
}

/** Measure all cells. */
static void measure(const sizes_call *c, planish_size_quality *q, double *ratios) {
    double sum = 0;
    q->min = INFINITY;
    q->smallest = q->largest = -1;
    for (int64_t i = 0; i < count_cells(c); i++) {
        const double ratio = ratio_of(c, i);
        const int64_t number = number_of(c, i);
        if (ratios)
            ratios[number] = ratio;
        if (!(ratio > 0))
            continue;
        q->n_elements++;
        sum += log(ratio) * log(ratio);
        if (ratio < q->min) {
            q->min = ratio;
            q->smallest = number;
        }
        if (ratio > q->max) {
            q->max = ratio;
            q->largest = number;
        }
    }
    q->rms_log = q->n_elements > 0 ? sqrt(sum / (double)q->n_elements) : 0;
    q->min = q->n_elements > 0 ? q->min : 0;
}

int planish_measure_sizes(const planish_mesh *mesh, int threads, planish_size_quality *quality,
                          double *ratio, planish_error *error) {
    sizes_call c = {.threads = 1};
    if (!mesh || !quality || !pl_has_sizes(mesh))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh, mesh.size or mesh.metric, and quality must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    int status = take_mesh(mesh, threads, &c, error);
    if (!status)
        status =
            pl_size_field_create(&c.mesh, c.dense.mesh.coordinates, c.threads, &c.field, error);
    if (!status) {
        const int64_t n = mesh->cells ? mesh->cells->n : mesh->n_elements;
        for (int64_t i = 0; ratio && i < n; i++)
            ratio[i] = 0;
        *quality = (planish_size_quality){.factor = fit(&c)};
        measure(&c, quality, ratio);
    }
    release(&c);
    pl_call_leave(&outside);
    return status;
}

/* ---- the mesh's own ---------------------------------------------------------------------------- */

/** Add the length of a cell at its nodes, and count it there. */
static void add_length(const sizes_call *c, int64_t cell, double length, double *size,
                       int32_t *count) {
    const planish_cells *cells = c->mesh.cells;
    const int64_t number = number_of(c, cell);
    const int k = c->mesh.dim + 1;
    const int32_t *node =
        cells ? cells->node + cells->offset[number] : c->dense.mesh.elements + number * k;
    const int64_t n = cells ? cells->offset[number + 1] - cells->offset[number] : k;
    for (int64_t i = 0; i < n; i++) {
        if (node[i] < 0) /* a mid that is not there */
            continue;
        size[node[i]] += length;
        count[node[i]]++;
    }
}

/** Fill size with the mean lengths of the elements of each node. */
static int find_own(sizes_call *c, double *size, planish_error *error) {
    const int64_t n = c->mesh.n_nodes;
    double all = 0, n_all = 0;
    int32_t *count = pl_alloc_zero(n, sizeof *count);
    if (!count)
        return pl_fail_memory(error, "the sizes of elements");
    for (int64_t i = 0; i < n; i++)
        size[i] = 0;
    for (int64_t cell = 0; cell < count_cells(c); cell++) {
        const double length = ratio_of(c, cell);
        if (!(length > 0)) /* flat: it has no size */
            continue;
        all += length;
        n_all++;
        add_length(c, cell, length, size, count);
    }
    for (int64_t i = 0; i < n; i++)
        size[i] = count[i] > 0 ? size[i] / count[i] : n_all > 0 ? all / n_all : 1;
    pl_free(count);
    return PLANISH_OK;
}

int planish_find_sizes(const planish_mesh *mesh, int threads, double *size, planish_error *error) {
    sizes_call c = {.threads = 1};
    if (!mesh || !size)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and size must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    int status = take_mesh(mesh, threads, &c, error);
    if (!status)
        status = find_own(&c, size, error);
    release(&c);
    pl_call_leave(&outside);
    return status;
}
