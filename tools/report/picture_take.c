/* picture_take: takes the mesh as it is now, for a picture: places, and codes of measures. */
#include "report/bytes.h"
#include "report/picture_take.h"

#include "job/worst.h"
#include "terminal/message.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bad elements of a state at most, and of one in brief; half as many where they have up to 8 corners. */
enum { MOST_BAD = 4000, MOST_BAD_IN_BRIEF = 800, MOST_CORNERS = 8 };

/** The place of a coordinate in the box: from 0 to 1. */
static double place_of(const pl_picture *picture, int d, double x) {
    const double extent = picture->high[d] - picture->low[d];
    return extent > 0 ? fmin(fmax((x - picture->low[d]) / extent, 0), 1) : 0;
}

/* ---- what is taken --------------------------------------------------------------------------- */

/** Take the points of the surface, which lie in the middle of their nodes. */
static int take_surface(const pl_picture *picture, const pl_job *job, pl_drawn_state *to) {
    const int dim = picture->dim;
    const size_t n = (size_t)picture->surface.n_points + 1;
    const double *x = job->mesh.coordinates;
    double *sum = calloc(n * (size_t)dim, sizeof *sum);
    int32_t *count = calloc(n, sizeof *count);
    to->point = malloc(2 * n * (size_t)dim);
    const int failed = !sum || !count || !to->point;
    for (int64_t i = 0; i < job->mesh.n_nodes && !failed; i++) {
        const int64_t point = picture->surface.point[i];
        if (point < 0)
            continue;
        for (int d = 0; d < dim; d++)
            sum[point * dim + d] += place_of(picture, d, x[i * dim + d]);
        count[point]++;
    }
    for (int64_t i = 0; i < picture->surface.n_points * dim && !failed; i++)
        pl_bytes_put((uint32_t)lround(PL_PICTURE_PLACES * sum[i] / count[i / dim]), 2,
                     to->point + 2 * i);
    free(sum);
    free(count);
    return failed ? pl_job_complain_memory(job, "the picture") : 0;
}

/** Take the points of the elements inside. */
static int take_inside(const pl_picture *picture, const pl_job *job, pl_drawn_state *to) {
    const pl_drawn_inside *inside = &picture->inside;
    to->inside = malloc(6 * (size_t)inside->n_points + 1);
    if (!to->inside)
        return pl_job_complain_memory(job, "the picture");
    for (int64_t i = 0; i < 3 * inside->n_points; i++) {
        const double x = job->mesh.coordinates[3 * (int64_t)inside->node[i / 3] + i % 3];
        pl_bytes_put((uint32_t)lround(PL_PICTURE_PLACES * place_of(picture, (int)(i % 3), x)), 2,
                     to->inside + 2 * i);
    }
    return 0;
}

/** By how much fewer elements are drawn where they have up to 8 corners. */
static int fewer_of(const pl_picture *picture) {
    return picture->is_solid && picture->has_types ? 2 : 1;
}

/** Put direction d of a corner of a bad element, as a float from the middle of the box, whose longest side is
 *  1, or (size 2) in 16 bits. */
static void put_corner(const pl_picture *picture, int d, double x, int size, uint8_t *out) {
    const double middle = (picture->low[d] + picture->high[d]) / 2;
    if (size == 2)
        pl_bytes_put((uint32_t)lround(PL_PICTURE_PLACES * place_of(picture, d, x)), 2, out);
    else
        pl_bytes_put_float((x - middle) / picture->size, out);
}

/** Take up to most of the worst elements: their corners, in numbers of size bytes, and ratios. element
 *  [to->n_bad]: which they are, owned by the caller, also after a failure. */
static int take_worst(const pl_picture *picture, const pl_job *job, int64_t most, int size,
                      pl_drawn_state *to, int32_t **element) {
    const int dim = picture->dim, point_size = size * dim;
    const double *x = job->mesh.coordinates;
    pl_worst worst = {0};
    int status = pl_worst_select(job, most / fewer_of(picture), &worst);
    uint8_t *corner = malloc((size_t)(worst.n * MOST_CORNERS * point_size) + 1);
    *(size == 2 ? &to->place : &to->corner) = corner;
    to->size = malloc((size_t)worst.n + 1);
    to->bad_ratio = malloc((size_t)(4 * worst.n) + 1);
    *element = malloc(((size_t)worst.n + 1) * sizeof **element);
    if (!status && (!corner || !to->size || !to->bad_ratio || !*element))
        status = pl_job_complain_memory(job, "the picture");
    for (int64_t i = 0; !status && i < worst.n; i++) {
        int n;
        const int32_t *node = pl_job_corners(job, worst.bad[i].element, &n);
        uint8_t *out = corner + to->n_corners * point_size;
        to->size[i] = (uint8_t)n;
        to->n_corners += n;
        for (int j = 0; j < n; j++)
            for (int d = 0; d < dim; d++, out += size)
                put_corner(picture, d, x[(int64_t)node[j] * dim + d], size, out);
        pl_bytes_put_float(worst.bad[i].ratio, to->bad_ratio + 4 * i);
        (*element)[i] = (int32_t)worst.bad[i].element;
    }
    to->n_bad = status ? 0 : worst.n;
    to->n_inverted = worst.n_inverted;
    pl_worst_free(&worst);
    return status;
}

/** Set *code to the codes [n_measures][n] of n elements, owned by the caller: those at the places at [n] of
 *  values, or (NULL) from first. */
static int take_codes(const pl_job *job, const pl_drawn_values *values, const int32_t *at,
                      int64_t first, int64_t n, uint8_t **code) {
    *code = malloc((size_t)(values->n_measures * n) + 1);
    if (!*code)
        return pl_job_complain_memory(job, "the picture");
    for (int m = 0; m < values->n_measures; m++)
        for (int64_t i = 0; i < n; i++)
            (*code)[m * n + i] = values->code[m * values->n + (at ? at[i] : first + i)];
    return 0;
}

/** Take the codes of all that is drawn, and the grid, from the values of all elements. bad [to->n_bad]: the bad
 *  ones. */
static int take_all_codes(const pl_picture *picture, const pl_job *job,
                          const pl_drawn_values *values, const int32_t *bad, pl_drawn_state *to) {
    const pl_drawn_inside *inside = &picture->inside;
    const pl_drawn_surface *surface = &picture->surface;
    int status = take_codes(job, values, bad, 0, to->n_bad, &to->bad_code);
    if (!status && !picture->is_solid)
        return take_codes(job, values, surface->element, 0, surface->n_triangles, &to->code);
    if (!status)
        status = take_codes(job, values, inside->element, 0, inside->n, &to->inside_code);
    if (status || inside->stride == 1)
        return status;
    to->cube = malloc((size_t)(picture->n_measures * picture->grid.n_cells));
    if (!to->cube)
        return pl_job_complain_memory(job, "the picture");
    pl_drawn_grid_take(&picture->grid, job, values, to->cube);
    return 0;
}

int pl_picture_take_whole(const pl_picture *picture, const pl_job *job, pl_drawn_state *state) {
    pl_drawn_values values;
    int32_t *bad = NULL;
    int status = pl_drawn_values_find(job, NULL, job->mesh.n_elements, &values);
    if (!status)
        status = take_surface(picture, job, state);
    if (!status)
        status = take_worst(picture, job, MOST_BAD, 4, state, &bad);
    if (!status && picture->is_solid)
        status = take_inside(picture, job, state);
    if (!status)
        status = take_all_codes(picture, job, &values, bad, state);
    pl_drawn_values_free(&values);
    free(bad);
    return status;
}

/* ---- in brief -------------------------------------------------------------------------------- */

/** Whether all elements are drawn inside. */
static int is_complete(const pl_picture *picture) {
    return picture->is_solid && picture->inside.stride == 1;
}

int64_t pl_picture_brief_bad(const pl_picture *picture) {
    return is_complete(picture) ? 0 : MOST_BAD_IN_BRIEF / fewer_of(picture);
}

/** Take the codes of n shown elements and of those bad [to->n_bad]: only these are measured, but for their
 *  ratios. */
static int take_few_codes(const pl_job *job, const int32_t *shown, int64_t n, const int32_t *bad,
                          uint8_t **code, pl_drawn_state *to) {
    const int64_t n_bad = to->n_bad;
    int32_t *element = malloc((size_t)(n + n_bad + 1) * sizeof *element);
    pl_drawn_values values = {.n = 0};
    if (!element)
        return pl_job_complain_memory(job, "the picture");
    if (n > 0)
        memcpy(element, shown, (size_t)n * sizeof *element);
    if (n_bad > 0)
        memcpy(element + n, bad, (size_t)n_bad * sizeof *element);
    int status = pl_drawn_values_find(job, element, n + n_bad, &values);
    if (!status && shown)
        status = take_codes(job, &values, NULL, 0, n, code);
    if (!status && bad)
        status = take_codes(job, &values, NULL, n, n_bad, &to->bad_code);
    pl_drawn_values_free(&values);
    free(element);
    return status;
}

int pl_picture_take_brief(const pl_picture *picture, const pl_job *job, pl_drawn_state *state) {
    const pl_drawn_inside *inside = &picture->inside;
    int32_t *bad = NULL;
    int status = take_surface(picture, job, state);
    if (!status && is_complete(picture)) {
        status = take_inside(picture, job, state);
        if (!status)
            status =
                take_few_codes(job, inside->element, inside->n, NULL, &state->inside_code, state);
        for (int64_t i = 0; i < inside->n && !status; i++)
            state->n_inverted += state->inside_code[i] == 0;
        return status;
    }
    if (!status)
        status = take_worst(picture, job, MOST_BAD_IN_BRIEF, 2, state, &bad);
    if (!status)
        status = picture->is_solid
                     ? take_few_codes(job, NULL, 0, bad, NULL, state)
                     : take_few_codes(job, picture->surface.element, picture->surface.n_triangles,
                                      bad, &state->code, state);
    free(bad);
    return status;
}

void pl_drawn_state_free(pl_drawn_state *s) {
    free(s->point);
    free(s->code);
    free(s->corner);
    free(s->place);
    free(s->size);
    free(s->bad_ratio);
    free(s->bad_code);
    free(s->inside);
    free(s->inside_code);
    free(s->cube);
    *s = (pl_drawn_state){.n_bad = 0};
}
