/* cells: the elements of every type that a mesh file has: measures, and copies for viewing. */
#include "job/cells.h"

#include "job/engine.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include "base/status.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Rounding in a field that is wide, and tolerance of a narrow one, of the diagonal. */
static const double WIDE_FIELD = 1e-8, OF_NARROW_FIELD = 1e-5;

/* Distance from the middle, in those that rounding takes nodes off a plane: three nodes are rounded,
 * in two directions. */
static const double OF_OFF = 4;

double pl_cells_rounding(const pl_job *job) {
    const int dim = job->mesh.dim;
    double square = 0;
    for (int d = 0; d < dim; d++) {
        double low = INFINITY, high = -INFINITY;
        for (int64_t i = 0; i < job->mesh.n_nodes; i++) {
            const double x = job->mesh.coordinates[i * dim + d];
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        const double extent = high > low ? high - low : 0;
        square += extent * extent;
    }
    const double size = sqrt(square), third = size / 3;
    const planish_file_info *info = &job->file_info;
    double tolerance = planish_file_surface(job->file, NULL).tolerance;
    /* In a narrow field some numbers have fewer digits than others. */
    if (info->precision == PLANISH_PRECISION_ROUNDED &&
        fabs(info->round(third, info->round_user) - third) > WIDE_FIELD * size)
        tolerance = fmax(tolerance, OF_NARROW_FIELD);
    /* Coordinates in a tilted plane are none of those that were rounded; it took nodes off it. */
    planish_plane plane;
    planish_file_plane(job->file, &plane);
    const double off = job->mesh.dim == 2 && plane.is_tilted ? OF_OFF * plane.off : 0;
    const double rounding = fmax(tolerance * size, off);
    return isfinite(rounding) ? rounding : 0;
}

/** Replace measures over no valid element by NAN: 0 would read as better than perfect. */
static void mark_missing(planish_cell_measures *of) {
    if (of->max_aspect_ratio == 0)
        of->rms_aspect_ratio = of->mean_aspect_ratio = of->max_aspect_ratio = NAN;
    if (of->n_curved == 0)
        of->min_jacobian_ratio = NAN;
}

static void mark_all_missing(planish_cell_quality *quality) {
    mark_missing(&quality->all);
    for (int i = 0; i < quality->n_types; i++)
        mark_missing(&quality->by_type[i]);
}

/** Whether all elements of a surface in space are straight triangles. */
static int are_triangles(const planish_cells *cells) {
    for (int64_t i = 0; i < cells->n; i++)
        if (cells->type[i] != PLANISH_CELL_TRIANGLE)
            return 0;
    return 1;
}

/** Measure cells, which have the nodes of the mesh, as it is now; sizes, if not NULL, where they are
 *  asked for. */
static int measure(const pl_job *job, const planish_cells *cells, planish_cell_quality *quality,
                   planish_size_quality *sizes, const planish_cell_values *values,
                   planish_error *error) {
    planish_mesh all = job->mesh;
    all.elements = NULL;
    pl_like_give(&job->like, &all);
    all.cells = cells;
    all.n_elements = cells->n;
    if (job->is_surface) {
        planish_quality ignored;
        return planish_measure_surface(job->curved.shape, &all, job->options.threads, &ignored,
                                       NULL, quality, values, error);
    }
    const double rounding =
        job->options.rounding > 0 ? job->options.rounding : pl_cells_rounding(job);
    const int code =
        planish_measure_cells(&all, rounding, job->options.threads, quality, values, error);
    return code || !pl_like_has_sizes(&job->like) || !sizes
               ? code
               : planish_measure_sizes(&all, job->options.threads, sizes, NULL, error);
}

int pl_cells_measure(const pl_job *job, pl_cells *cells) {
    planish_error error;
    *cells = (pl_cells){.has_others = 0};
    if (!job->file || (job->file_info.n_other_elements == 0 && !job->mesh.cells))
        return 0;
    if (planish_file_cells(job->file, &cells->cells, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    if (cells->cells.n == job->mesh.n_elements && !job->mesh.cells) /* no type that is measured */
        return 0;
    if (job->is_surface && are_triangles(&cells->cells))
        return 0;
    cells->has_others = 1;
    cells->aspect_ratio = malloc(((size_t)cells->cells.n + 1) * sizeof *cells->aspect_ratio);
    if (!cells->aspect_ratio)
        return pl_job_complain_memory(job, "values of elements");
    const planish_cell_values values = {.aspect_ratio = cells->aspect_ratio};
    if (measure(job, &cells->cells, &cells->quality, &cells->sizes, &values, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    mark_all_missing(&cells->quality);
    return 0;
}

/* ---- validity ------------------------------------------------------------------------------- */

/** Mark the elements that are not valid though their corners are positive. corner [n_elements]: above
 *  0 where they are. */
static void mark_inside(const pl_job *job, const double *corner, pl_cells_validity *validity) {
    for (int64_t i = 0; i < job->mesh.n_elements; i++)
        if (validity->state[i] != PLANISH_CELL_STATE_VALID && corner[i] > 0) {
            validity->state[i] = PL_INVERTED_INSIDE;
            validity->n_inside++;
        }
}

int pl_cells_validity_find(const pl_job *job, pl_cells_validity *validity) {
    const size_t n = (size_t)job->mesh.n_elements + 1;
    planish_error error;
    *validity = (pl_cells_validity){.is_known = job->mesh.cells != NULL};
    if (!validity->is_known)
        return 0;
    double *corner = malloc(n * sizeof *corner);
    validity->state = malloc(n);
    validity->aspect_ratio = malloc(n * sizeof *validity->aspect_ratio);
    const planish_cell_values values = {.state = validity->state,
                                        .aspect_ratio = validity->aspect_ratio,
                                        .scaled_jacobian = corner};
    int code = corner && values.state && values.aspect_ratio
                   ? PLANISH_OK
                   : pl_fail_memory(&error, "states of elements");
    if (!code)
        code = measure(job, job->mesh.cells, &validity->quality, &validity->sizes, &values, &error);
    if (!code && !job->has_types) /* of simplices the plan tells exactly */
        code = job->engine->measure_elements(job, corner, &error);
    if (!code)
        mark_inside(job, corner, validity);
    free(corner);
    mark_all_missing(&validity->quality);
    return code ? pl_job_complain(job, PL_EXIT_FAILED, &error) : 0;
}

void pl_cells_validity_free(pl_cells_validity *validity) {
    free(validity->state);
    free(validity->aspect_ratio);
    validity->state = NULL;
    validity->aspect_ratio = NULL;
}

int pl_cells_find_states(const pl_job *job, uint8_t **state) {
    planish_cell_quality quality;
    planish_error error;
    const planish_cell_values values = {.state = *state = malloc((size_t)job->mesh.n_elements + 1)};
    if (!*state)
        return pl_job_complain_memory(job, "states of elements");
    if (!measure(job, job->mesh.cells, &quality, NULL, &values, &error))
        return 0;
    free(*state);
    *state = NULL;
    return pl_job_complain(job, PL_EXIT_FAILED, &error);
}

/** Mark the simplices that are inverted. */
static int find_inverted(const pl_job *job, uint8_t *is_faulty) {
    const int64_t n = job->mesh.n_elements;
    planish_error error;
    double *ratio = malloc(((size_t)n + 1) * sizeof *ratio);
    if (!ratio)
        return pl_job_complain_memory(job, "values of elements");
    const int code = job->engine->measure_elements(job, ratio, &error);
    for (int64_t i = 0; !code && i < n; i++)
        is_faulty[i] = ratio[i] == 0;
    free(ratio);
    return code ? pl_job_complain(job, PL_EXIT_FAILED, &error) : 0;
}

int pl_cells_find_faults(const pl_job *job, uint8_t **is_faulty) {
    const int64_t n = job->mesh.n_elements;
    if (!job->mesh.cells) {
        *is_faulty = malloc((size_t)n + 1);
        return *is_faulty ? find_inverted(job, *is_faulty)
                          : pl_job_complain_memory(job, "states of elements");
    }
    const int status = pl_cells_find_states(job, is_faulty);
    for (int64_t i = 0; !status && i < n; i++)
        (*is_faulty)[i] = (*is_faulty)[i] == PLANISH_CELL_STATE_INVERTED ||
                          (*is_faulty)[i] == PLANISH_CELL_STATE_UNCERTIFIED;
    return status;
}

int64_t pl_cells_validity_faults(const pl_cells_validity *validity,
                                 const planish_quality *quality) {
    const planish_cell_measures *all = &validity->quality.all;
    return validity->is_known ? all->n_inverted + all->n_uncertified : quality->n_inverted;
}

int pl_cells_measure_values(const pl_job *job, const planish_cell_values *values,
                            planish_error *error) {
    planish_cell_quality quality;
    return measure(job, job->mesh.cells, &quality, NULL, values, error);
}

int pl_cells_measure_elements(const pl_job *job, double *ratio, planish_error *error) {
    const int64_t n = job->mesh.n_elements;
    if (job->has_types) {
        const planish_cell_values of = {.aspect_ratio = ratio};
        return pl_cells_measure_values(job, &of, error);
    }
    int code = job->engine->measure_elements(job, ratio, error);
    if (code || !job->mesh.cells)
        return code;
    const planish_cell_values values = {.state = malloc((size_t)n + 1)};
    code = values.state ? pl_cells_measure_values(job, &values, error)
                        : pl_fail_memory(error, "states of elements");
    for (int64_t i = 0; i < n && !code; i++)
        ratio[i] = values.state[i] == PLANISH_CELL_STATE_VALID ? ratio[i] : 0;
    free(values.state);
    return code;
}

/* ---- copies for viewing --------------------------------------------------------------------- */

enum { N_MEASURES = 4 }; /* arrays of planish_cell_values of real numbers */

/** Write the copy; memory is where the arrays of measures are to be. */
static int convert(const pl_job *job, const char *path, const planish_cells *cells, double *memory,
                   char lost[512], planish_error *error) {
    planish_cell_quality quality;
    double *ratio = memory + N_MEASURES * cells->n;
    planish_convert_options options = {
        .cells = {.aspect_ratio = memory,
                  .scaled_jacobian = memory + cells->n,
                  .jacobian_ratio = memory + 2 * cells->n,
                  .edge_ratio = memory + 3 * cells->n,
                  .state = (uint8_t *)(ratio + job->mesh.n_elements),
                  .is_curved = (uint8_t *)(ratio + job->mesh.n_elements) + cells->n},
        .constraint = job->constraint,
        .temporary = pl_signals_temporary(PL_TEMPORARY_MESH),
        .temporary_size = PL_TEMPORARY_SIZE,
        .lost = lost,
        .lost_size = 512};
    int code = measure(job, cells, &quality, NULL, &options.cells, error);
    if (job->has_types && job->mesh.cells->type == cells->type) { /* they have just been measured */
        options.radius_ratio = options.cells.aspect_ratio;
    } else if (!code && job->mesh.n_elements > 0) {
        options.radius_ratio = ratio;
        code = pl_cells_measure_elements(job, ratio, error);
    }
    return code ? code
                : planish_file_convert(job->file, path, job->mesh.coordinates, &options, error);
}

int pl_cells_convert(const pl_job *job, const char *path) {
    planish_error error;
    planish_cells cells;
    char lost[512];
    int code = planish_file_cells(job->file, &cells, &error);
    if (!code) {
        const size_t n = (size_t)cells.n;
        double *memory =
            malloc((N_MEASURES * n + (size_t)job->mesh.n_elements + 1) * sizeof *memory + 2 * n);
        code = memory ? convert(job, path, &cells, memory, lost, &error)
                      : pl_fail_memory(&error, "the measures of elements");
        free(memory);
    }
    if (code)
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    if (job->arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s is converted; it lacks %s", path, lost);
    return 0;
}

void pl_cells_free(pl_cells *cells) {
    free(cells->aspect_ratio);
    cells->aspect_ratio = NULL;
    cells->cells = (planish_cells){.n = cells->cells.n};
}
