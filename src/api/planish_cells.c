/* planish_cells: elements of every type: check, enter, measure. */
#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "quality/cell_measure.h"
#include "topology/cells.h"

#include <inttypes.h>
#include <float.h>
#include <math.h>

int planish_measure_cells(const planish_cells *cells, int dim, int64_t n_nodes,
                          const double *coordinates, double rounding, int threads,
                          planish_cell_quality *quality, double *aspect_ratio,
                          planish_error *error) {
    if (!cells || !quality || (n_nodes > 0 && !coordinates))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "cells, coordinates and quality must not be NULL");
    if (dim != 2 && dim != 3)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "dim is %d; give 2 or 3", dim);
    if (n_nodes < 0 || n_nodes > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "n_nodes is %" PRId64 "; give 0 to %d",
                       n_nodes, INT32_MAX);
    if (!(rounding >= 0))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "rounding is %g; give 0 or more", rounding);
    if (threads < 0 || threads > PL_MAX_THREADS)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "threads is %d; give 1 to %d, or 0 for as many as OpenMP would use", threads,
                       PL_MAX_THREADS);
    for (int64_t i = 0; i < n_nodes * dim; i++)
        if (!(fabs(coordinates[i]) <= DBL_MAX))
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, i / dim,
                              "node %" PRId64 " has the coordinate %g; give finite ones", i / dim,
                              coordinates[i]);
    const pl_outside outside = pl_call_enter(NULL);
    const int n_threads = pl_thread_count(threads);
    int8_t *sign = NULL;
    pl_cell_rules rules = {.n = 0};
    int status = pl_check_cells(cells, n_nodes, n_threads, error);
    if (!status && !(sign = pl_alloc(cells->n, sizeof *sign)))
        status = pl_fail_memory(error, "the measures of elements");
    if (!status)
        status = pl_orient_cells(cells, dim, coordinates, sign, error);
    if (!status) {
        const pl_cell_mesh mesh = {dim, cells, coordinates, sign, rounding};
        status = pl_cell_rules_make(&mesh, &rules);
        if (!status)
            status = pl_measure_cells(&mesh, &rules, n_threads, quality, aspect_ratio);
        pl_cell_rules_free(&rules);
        if (status)
            pl_fail_memory(error, "the measures of elements");
    }
    pl_free(sign);
    pl_call_leave(&outside);
    return status;
}
