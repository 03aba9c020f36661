/* measure: what a mesh is worth, for the caller: with a plan and without; its checksum. */
#include "sweep/sweep.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "quality/measure.h"

#include <string.h>

/* ---- with a plan --------------------------------------------------------------------------- */

/** Of all of the mesh if the plan knows that, else of its part. */
static int measure(const planish_plan *plan, const double *coordinates, planish_quality *quality,
                   planish_error *error) {
    const pl_whole *whole = &plan->whole;
    if (whole->elements)
        return pl_measure(plan->dim, whole->n_elements, whole->elements, whole->sign,
                          whole->is_free, coordinates, plan->threads, quality, error);
    const int status = pl_measure(plan->dim, plan->n_elements, plan->elements, plan->sign,
                                  plan->is_free, coordinates, plan->threads, quality, error);
    if (!status && plan->element_of && quality->worst_element >= 0)
        quality->worst_element = plan->element_of[quality->worst_element];
    return status;
}

static int check_and_measure(const planish_plan *plan, const double *coordinates,
                             planish_quality *quality, planish_error *error) {
    const pl_points points = pl_plan_all_points(plan, coordinates);
    const int is_dense = pl_points_are_dense(&points);
    int status = pl_points_check(&points, plan->threads, error);
    if (status)
        return status;
    double *room = is_dense ? NULL : pl_alloc(points.n * points.dim, sizeof *room);
    if (!is_dense && !room)
        return pl_fail_memory(error, "the coordinates");
    status = measure(plan, pl_plan_dense(plan, &points, room), quality, error);
    pl_free(room);
    return status;
}

int planish_measure(const planish_plan *plan, const double *coordinates, planish_quality *quality,
                    planish_error *error) {
    if (!plan || !coordinates || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plan, coordinates and quality must not be NULL");
    pl_context *before = pl_context_enter(plan->context);
    const int status = check_and_measure(plan, coordinates, quality, error);
    pl_context_enter(before);
    return status;
}

/* ---- without ------------------------------------------------------------------------------- */

/** The work on all nodes. */
typedef struct freedom {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    uint8_t *on_boundary; /* becomes is_free */
} freedom;

enum { CHUNK_NODES = 4096 };

static void find_free(void *context, int64_t begin, int64_t end, int thread) {
    const freedom *f = context;
    const uint8_t *constraint = f->mesh->constraint;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t n = f->incidence->offset[i + 1] - f->incidence->offset[i];
        f->on_boundary[i] = n > 0 && n <= PL_MAX_LINK && !f->on_boundary[i] &&
                            (!constraint || constraint[i] == PLANISH_FREE);
    }
}

/** mesh is dense and valid. */
static int measure_dense(const planish_mesh *mesh, int threads, planish_quality *quality,
                         planish_error *error) {
    pl_boundary boundary = {0};
    pl_incidence incidence = {0};
    int status = pl_boundary_create(mesh, 0, threads, &boundary, error);
    if (!status)
        status = pl_incidence_create(mesh, NULL, threads, &incidence, error);
    if (!status)
        status = pl_boundary_find(mesh, &incidence, NULL, threads, &boundary, error);
    if (!status) {
        freedom f = {mesh, &incidence, boundary.on_boundary};
        pl_parallel_for(threads, mesh->n_nodes, CHUNK_NODES, find_free, &f);
        status = pl_measure(mesh->dim, mesh->n_elements, mesh->elements, boundary.sign,
                            boundary.on_boundary, mesh->coordinates, threads, quality, error);
    }
    pl_incidence_destroy(&incidence);
    pl_boundary_destroy(&boundary);
    return status;
}

static int measure_mesh(const planish_mesh *mesh, int threads, planish_quality *quality,
                        planish_error *error) {
    pl_dense dense;
    int status = pl_dense_create(mesh, threads, &dense, error);
    if (status)
        return status;
    status = measure_dense(&dense.mesh, threads, quality, error);
    pl_dense_destroy(&dense);
    return status;
}

int planish_measure_mesh(const planish_mesh *mesh, const planish_options *options,
                         planish_quality *quality, planish_error *error) {
    planish_options defaults;
    if (!mesh || !quality)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and quality must not be NULL");
    planish_options_init(&defaults);
    options = options ? options : &defaults;
    int status = pl_options_check(options, error);
    if (status)
        return status;
    pl_context *context = pl_context_create(options);
    if (!context)
        return pl_fail_memory(error, "the measuring of a mesh");
    pl_context *before = pl_context_enter(context);
    status = measure_mesh(mesh, pl_thread_count(pl_threads_for(mesh, options)), quality, error);
    pl_context_enter(before);
    pl_context_destroy(context);
    return status;
}

/* ---- the checksum -------------------------------------------------------------------------- */

/** One more word; a multiplication spreads it upwards, a shift back down. */
static uint64_t stir(uint64_t hash, uint64_t word) {
    hash = (hash ^ word) * UINT64_C(0x9E3779B97F4A7C15);
    return hash ^ hash >> 32;
}

uint64_t planish_checksum(const planish_mesh *mesh) {
    uint64_t hash = 0;
    if (!mesh || !mesh->coordinates || pl_check_counts(mesh, NULL))
        return 0;
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    for (int64_t i = 0; i < points.n; i++)
        for (int d = 0; d < points.dim; d++) {
            uint64_t word;
            memcpy(&word, points.x + pl_point_at(&points, i, d), sizeof word);
            hash = stir(hash, word + (uint64_t)d);
        }
    return hash;
}
