/* drawn_values: the measures by which a picture colours elements. */
#include "report/drawn_values.h"

#include "job/angles.h"
#include "job/cells.h"
#include "terminal/message.h"

#include "base/parallel.h"

#include <math.h>
#include <stdlib.h>

#define RATIO_EDGES                                                                                \
    { 1, 1.25, 1.5, 2, 2.5, 3, 4, 6, 10, 30, 100, 1000, INFINITY }
#define RATIO_LIMITS                                                                               \
    { 1.25, 1.5, 2, 3, 4, 6, 10 }

static const pl_drawn_measure radius_ratio = {"histogram", "radius ratio", "",          0,
                                              12,          RATIO_EDGES,    RATIO_LIMITS};
static const pl_drawn_measure aspect_ratio = {"aspect_histogram", "aspect ratio", "", 0, 12,
                                              RATIO_EDGES,        RATIO_LIMITS};
static const pl_drawn_measure edge_ratio = {
    "edge_ratio", "longest / shortest edge", "", 0, 12, RATIO_EDGES, RATIO_LIMITS};
static const pl_drawn_measure smallest_angle = {
    "angle_histogram",
    "smallest angle",
    "°",
    1,
    15,
    {0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75},
    {50, 40, 30, 20, 15, 10, 5}};
static const pl_drawn_measure largest_angle = {
    "largest_angle",
    "largest angle",
    "°",
    0,
    12,
    {60, 70, 80, 90, 100, 110, 120, 130, 140, 150, 160, 170, 180},
    {80, 90, 100, 120, 140, 160, 170}};
static const pl_drawn_measure scaled_jacobian = {
    "scaled_jacobian",
    "scaled Jacobian",
    "",
    1,
    12,
    {0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1},
    {0.9, 0.8, 0.7, 0.5, 0.3, 0.2, 0.1}};

/** Return the code of a value; 0 if it is not a number. */
static uint8_t code_of(const pl_drawn_measure *measure, double value) {
    const int n = measure->n_bins, n_codes = PL_DRAWN_CODES / n;
    int bin = 0;
    if (isnan(value))
        return 0;
    while (bin + 1 < n && value >= measure->edge[bin + 1])
        bin++;
    const double from = measure->edge[bin], to = measure->edge[bin + 1];
    const double place = isfinite(to) ? (value - from) / (to - from) : 1 - from / value;
    const int step = (int)fmin(fmax(floor(place * n_codes), 0), n_codes - 1);
    return (uint8_t)(1 + bin * n_codes + step);
}

/** Limits are edges of bins. */
int pl_drawn_class(const pl_drawn_measure *measure, uint8_t code) {
    int class = 0;
    if (code == 0)
        return PL_DRAWN_CLASSES;
    const double from = measure->edge[(code - 1) / (PL_DRAWN_CODES / measure->n_bins)];
    for (int i = 0; i < PL_DRAWN_CLASSES - 1; i++)
        class += measure->more_is_better ? from < measure->limit[i] : from >= measure->limit[i];
    return class;
}

int pl_drawn_worse(const pl_drawn_measure *measure, uint8_t a, uint8_t b) {
    if (a == PL_DRAWN_NOTHING || b == 0)
        return 0;
    return b == PL_DRAWN_NOTHING || a == 0 || (measure->more_is_better ? a < b : a > b);
}

/* ---- simplices ------------------------------------------------------------------------------ */

/** Measures of simplices: job's mesh, and the ratios that are known. */
typedef struct simplices {
    const pl_job *job;
    const double *ratio;    /* [elements of the mesh] */
    const int32_t *element; /* [n] or NULL: all */
    pl_drawn_values *values;
} simplices;

/** Longest edge by shortest, between vertex [n_corners][dim]. */
static double edge_ratio_of(int dim, const double *const vertex[], int n_corners) {
    double shortest = INFINITY, longest = 0;
    for (int i = 0; i < n_corners; i++)
        for (int j = i + 1; j < n_corners; j++) {
            double square = 0;
            for (int d = 0; d < dim; d++)
                square += (vertex[i][d] - vertex[j][d]) * (vertex[i][d] - vertex[j][d]);
            shortest = fmin(shortest, square);
            longest = fmax(longest, square);
        }
    return sqrt(longest / shortest);
}

static void measure_simplices(void *context, int64_t begin, int64_t end, int thread) {
    const simplices *s = context;
    const pl_job *job = s->job;
    const int dim = job->mesh.dim, n_vertices = pl_job_element_dim(job) + 1;
    const int64_t n = s->values->n;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t element = s->element ? s->element[i] : i;
        const double *vertex[4], ratio = s->ratio[element];
        int n_corners;
        const int32_t *node = pl_job_corners(job, element, &n_corners);
        for (int m = 0; m < s->values->n_measures; m++)
            s->values->code[m * n + i] = PL_DRAWN_NOTHING;
        if (n_corners != n_vertices) /* an element of another dimension */
            continue;
        for (int k = 0; k < n_corners; k++)
            vertex[k] = job->mesh.coordinates + (int64_t)node[k] * dim;
        const pl_angles angles =
            job->is_surface ? pl_angles_find_in_space(vertex) : pl_angles_find(dim, vertex);
        const double value[PL_DRAWN_MEASURES] = {ratio, angles.smallest, angles.largest,
                                                 edge_ratio_of(dim, vertex, n_corners)};
        for (int m = 0; m < s->values->n_measures; m++)
            s->values->code[m * n + i] = ratio > 0 ? code_of(s->values->measure[m], value[m]) : 0;
    }
}

static int find_of_simplices(const pl_job *job, const int32_t *element, const double *ratio,
                             pl_drawn_values *values) {
    enum { CHUNK = 4096 };
    simplices s = {job, ratio, element, values};
    pl_parallel_for(pl_thread_count(job->options.threads), values->n, CHUNK, measure_simplices, &s);
    return 0;
}

/* ---- elements of every type ------------------------------------------------------------------ */

static int find_of_cells(const pl_job *job, const int32_t *element, double *ratio,
                         pl_drawn_values *values) {
    planish_error error;
    const int64_t n = job->mesh.n_elements;
    double *more = malloc(2 * ((size_t)n + 1) * sizeof *more);
    uint8_t *state = malloc((size_t)n + 1);
    const planish_cell_values of = {
        .state = state, .aspect_ratio = ratio, .scaled_jacobian = more, .edge_ratio = more + n};
    const double *value[PL_DRAWN_MEASURES] = {ratio, more, more + n};
    int status = more && state ? 0 : pl_job_complain_memory(job, "the picture");
    if (!status && pl_cells_measure_values(job, &of, &error))
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    for (int64_t k = 0; k < values->n && !status; k++) {
        const int64_t i = element ? element[k] : k;
        for (int m = 0; m < values->n_measures; m++)
            values->code[m * values->n + k] = state[i] == PLANISH_CELL_STATE_NONE ? PL_DRAWN_NOTHING
                                              : ratio[i] > 0
                                                  ? code_of(values->measure[m], value[m][i])
                                                  : 0;
    }
    free(more);
    free(state);
    return status;
}

/* ---- both ----------------------------------------------------------------------------------- */

int pl_drawn_measures(const pl_job *job, const pl_drawn_measure *measure[PL_DRAWN_MEASURES]) {
    static const pl_drawn_measure *const of_cells[] = {&aspect_ratio, &scaled_jacobian,
                                                       &edge_ratio},
                                         *const of_simplices[] = {&radius_ratio, &smallest_angle,
                                                                  &largest_angle, &edge_ratio};
    const int n = job->has_types ? 3 : 4;
    for (int m = 0; m < n; m++)
        measure[m] = job->has_types ? of_cells[m] : of_simplices[m];
    return n;
}

int pl_drawn_values_find(const pl_job *job, const int32_t *element, int64_t n,
                         pl_drawn_values *values) {
    planish_error error;
    int status = 0;
    *values = (pl_drawn_values){.n = n};
    values->n_measures = pl_drawn_measures(job, values->measure);
    values->code = malloc((size_t)(values->n_measures * n) + 1);
    double *ratio = malloc(((size_t)job->mesh.n_elements + 1) * sizeof *ratio);
    if (!values->code || !ratio)
        status = pl_job_complain_memory(job, "the picture");
    else if (job->has_types)
        status = find_of_cells(job, element, ratio, values);
    else if (pl_cells_measure_elements(job, ratio, &error))
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    else
        status = find_of_simplices(job, element, ratio, values);
    free(ratio);
    return status;
}

void pl_drawn_values_free(pl_drawn_values *values) {
    free(values->code);
    values->code = NULL;
}
