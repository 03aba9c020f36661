/* planish_surface: smooth and measure a mesh that is a surface in space. */
#include "surface/crossings.h"
#include "surface/quality.h"
#include "surface/smooth.h"
#include "surface/begin.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "plan/plan.h"
#include "topology/cells.h"
#include "topology/points.h"
#include "topology/topology.h"

#include <string.h>

static int check_mesh(const planish_mesh *mesh, int threads, planish_error *error) {
    int status = pl_check_counts(mesh, error);
    if (status)
        return status;
    if (mesh->dim != 3 || !mesh->cells || !mesh->cells->type || !pl_is_of_faces(mesh->cells, 3))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh is not a surface in space; give dim 3 and cells that are triangles "
                       "or quadrilaterals, or use planish_smooth and planish_measure");
    if (mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "a surface in space is worked on as a whole, not a part of it");
    if (mesh->n_periodic > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_periodic is %lld; surfaces in space have no pairs: give 0",
                       (long long)mesh->n_periodic);
    if (pl_has_targets(mesh))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "elements of surfaces in space have no targets; leave out mesh.%s",
                       mesh->is_layer ? "is_layer"
                       : mesh->size   ? "size"
                       : mesh->metric ? "metric"
                                      : "reference");
    return pl_check_cells(mesh->cells, mesh->n_nodes, threads, error);
}

static int run_once(pl_surface_run *r, planish_error *error) {
    *r->result = (planish_result){0};
    int status = pl_surface_run_begin(r, error);
    if (!status)
        status = pl_surface_sweeps(r, error);
    if (!status && r->options->worst != PLANISH_WORST_NONE &&
        (r->stop == PLANISH_STOP_CONVERGED || r->stop == PLANISH_STOP_MAX_SWEEPS))
        status = pl_surface_improve_worst(r, error);
    return status;
}

/** Hold the nodes of facets that have come to cross others; if is_last, all. *n: how many more. Errors:
 *  _MEMORY. */
static int hold_crossings(const pl_surface_run *r, int is_last, uint8_t **held, int64_t *n,
                          planish_error *error) {
    const int64_t n_nodes = r->shape->n_nodes;
    if (!*held)
        *held = pl_alloc_zero(n_nodes, sizeof **held);
    if (!*held)
        return pl_fail_memory(error, "the surface of a mesh");
    const int status = pl_surface_hold_crossings(r, *held, n, error);
    if (*n > 0 && is_last)
        memset(*held, 1, (size_t)n_nodes * sizeof **held);
    return status;
}

/** Smooth until no facet crosses another one that it did not cross at the start. */
static int smooth(pl_surface_run *r, planish_error *error) {
    enum { MOST_RUNS = 4 };
    const pl_surface_run given = *r;
    planish_options quiet = *r->options; /* the caller has stopped: a last run moves nothing */
    planish_stop stop = PLANISH_STOP_CONVERGED;
    uint8_t *held = NULL;
    int64_t n = 1;
    int status = PLANISH_OK, is_stopped = 0;
    quiet.progress = NULL;
    quiet.time_limit = 0;
    for (int runs = 1; n > 0 && !status; runs++) {
        pl_surface_run_destroy(r);
        *r = given;
        r->held = held;
        r->options = is_stopped ? &quiet : given.options;
        status = run_once(r, error);
        n = 0;
        if (status || is_stopped)
            break;
        stop = r->stop;
        is_stopped = stop == PLANISH_STOP_INTERRUPTED || stop == PLANISH_STOP_TIME_LIMIT;
        status = hold_crossings(r, is_stopped || runs >= MOST_RUNS, &held, &n, error);
    }
    r->stop = stop;
    if (!status)
        pl_surface_run_end(r);
    pl_surface_run_destroy(r);
    pl_free(held);
    return status;
}

/** Find what a run holds from its start. */
static int find_held(pl_surface_run *r, uint8_t *held, planish_error *error) {
    const int status = pl_surface_run_begin(r, error);
    if (!status)
        pl_surface_run_get_held(r, held);
    pl_surface_run_destroy(r);
    return status;
}

/** Check the arguments, and smooth coordinates; or, if held is not NULL, find what holds nodes there. */
static int run(const planish_mesh *mesh, double *coordinates, const planish_options *options,
               planish_result *result, uint8_t *held, planish_error *error) {
    if (!options)
        return pl_fail(
            error, PLANISH_ERROR_ARGUMENT,
            "options must not be NULL: options.shape is the surface that nodes move along");
    int status = pl_options_check(options, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    pl_context *context = pl_context_create(options);
    if (!context)
        status = pl_fail_memory(error, "the surface of a mesh");
    if (!status) {
        pl_context *before = pl_context_enter(context);
        pl_surface_run r = {.mesh = mesh,
                            .coordinates = coordinates,
                            .options = options,
                            .result = result,
                            .threads = pl_thread_count(options->threads),
                            .start_seconds = pl_seconds()};
        status = check_mesh(mesh, r.threads, error);
        if (!status)
            status = held ? find_held(&r, held, error) : smooth(&r, error);
        pl_context_enter(before);
    }
    pl_context_destroy(context);
    pl_call_leave(&outside);
    return status;
}

int planish_smooth_surface(const planish_mesh *mesh, double *coordinates,
                           const planish_options *options, planish_result *result,
                           planish_error *error) {
    planish_result found = {0};
    if (!mesh || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and coordinates must not be NULL");
    const int status = run(mesh, coordinates, options, &found, NULL, error);
    if (!status && result)
        *result = found;
    return status;
}

int planish_find_held_on_surface(const planish_mesh *mesh, const planish_options *options,
                                 uint8_t *held, planish_error *error) {
    planish_result unused = {0};
    if (!mesh || !mesh->coordinates || !held)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh, mesh.coordinates and held must not be NULL");
    /* A run writes coordinates at its end, which find_held does not come to. */
    return run(mesh, (double *)mesh->coordinates, options, &unused, held, error);
}

/* ---- measures --------------------------------------------------------------------------------- */

int planish_measure_surface(const planish_shape *shape, const planish_mesh *mesh, int threads,
                            planish_quality *quality, double *ratio, planish_cell_quality *cells,
                            const planish_cell_values *values, planish_error *error) {
    if (!shape || !mesh || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "shape, mesh and quality must not be NULL");
    int status = pl_check_threads(threads, error);
    if (!status && values)
        status = pl_check_reserved("planish_cell_values", values->reserved, sizeof values->reserved,
                                   error);
    if (status)
        return status;
    threads = pl_thread_count(threads);
    const pl_outside outside = pl_call_enter(NULL);
    status = check_mesh(mesh, threads, error);
    if (!status && shape->n_mesh != mesh->n_nodes)
        status = pl_fail(error, PLANISH_ERROR_ARGUMENT,
                         "shape was made of a mesh of %lld nodes, mesh has %lld; make it of this "
                         "mesh",
                         (long long)shape->n_mesh, (long long)mesh->n_nodes);
    if (!status) {
        const pl_points points = pl_points_of(mesh, mesh->coordinates);
        const pl_surface_measuring measuring = {shape, mesh,  &points, quality,
                                                ratio, cells, values};
        status = pl_points_check(&points, threads, error);
        if (!status)
            status = pl_surface_quality(&measuring, threads, error);
    }
    pl_call_leave(&outside);
    return status;
}
