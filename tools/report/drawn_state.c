/* drawn_state: what a picture draws of a mesh in one state: places, and codes of measures. */
#include "report/drawn_state.h"

#include "job/worst.h"
#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bad elements of a state at most, and of one in brief; half as many where they have up to 8 corners. */
enum { MOST_BAD = 4000, MOST_BAD_IN_BRIEF = 1000, MOST_CORNERS = 8 };

/* Places on each side of the box, for points. */
static const double PLACES = 65535;

/* ---- numbers --------------------------------------------------------------------------------- */

static void put_little_endian(uint32_t value, int size, uint8_t *out) {
    for (int i = 0; i < size; i++)
        out[i] = (uint8_t)(value >> (8 * i));
}

static uint32_t get_little_endian(const uint8_t *from, int size) {
    uint32_t value = 0;
    for (int i = 0; i < size; i++)
        value |= (uint32_t)from[i] << (8 * i);
    return value;
}

static void put_float(double value, uint8_t *out) {
    const double largest = 1e38; /* that a float holds */
    const float rounded = (float)fmin(value, largest);
    uint32_t bits;
    memcpy(&bits, &rounded, sizeof bits);
    put_little_endian(bits, 4, out);
}

static double get_float(const uint8_t *from) {
    const uint32_t bits = get_little_endian(from, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/** The place of a coordinate in the box: from 0 to 1. */
static double place_of(const pl_drawn_mesh *mesh, int d, double x) {
    const double extent = mesh->high[d] - mesh->low[d];
    return extent > 0 ? fmin(fmax((x - mesh->low[d]) / extent, 0), 1) : 0;
}

/* ---- what is taken --------------------------------------------------------------------------- */

/** Take the points of the surface, which lie in the middle of their nodes. */
static int take_surface(const pl_drawn_mesh *mesh, const pl_job *job, pl_drawn_state *to) {
    const int dim = mesh->dim;
    const size_t n = (size_t)mesh->surface.n_points + 1;
    const double *x = job->mesh.coordinates;
    double *sum = calloc(n * (size_t)dim, sizeof *sum);
    int32_t *count = calloc(n, sizeof *count);
    to->point = malloc(2 * n * (size_t)dim);
    const int failed = !sum || !count || !to->point;
    for (int64_t i = 0; i < job->mesh.n_nodes && !failed; i++) {
        const int64_t point = mesh->surface.point[i];
        if (point < 0)
            continue;
        for (int d = 0; d < dim; d++)
            sum[point * dim + d] += place_of(mesh, d, x[i * dim + d]);
        count[point]++;
    }
    for (int64_t i = 0; i < mesh->surface.n_points * dim && !failed; i++)
        put_little_endian((uint32_t)lround(PLACES * sum[i] / count[i / dim]), 2, to->point + 2 * i);
    free(sum);
    free(count);
    return failed ? pl_job_complain_memory(job, "the picture") : 0;
}

/** Take the points of the elements inside. */
static int take_inside(const pl_drawn_mesh *mesh, const pl_job *job, pl_drawn_state *to) {
    const pl_drawn_inside *inside = &mesh->inside;
    to->inside = malloc(6 * (size_t)inside->n_points + 1);
    if (!to->inside)
        return pl_job_complain_memory(job, "the picture");
    for (int64_t i = 0; i < 3 * inside->n_points; i++) {
        const double x = job->mesh.coordinates[3 * (int64_t)inside->node[i / 3] + i % 3];
        put_little_endian((uint32_t)lround(PLACES * place_of(mesh, (int)(i % 3), x)), 2,
                          to->inside + 2 * i);
    }
    return 0;
}

/** By how much fewer elements are drawn where they have up to 8 corners. */
static int fewer_of(const pl_drawn_mesh *mesh) {
    return mesh->is_solid && mesh->has_types ? 2 : 1;
}

/** Take up to most of the worst elements: their corners and ratios. element [to->n_bad]: which they are, owned
 *  by the caller, also after a failure. */
static int take_worst(const pl_drawn_mesh *mesh, const pl_job *job, int64_t most,
                      pl_drawn_state *to, int32_t **element) {
    const int dim = mesh->dim, point_size = 4 * dim;
    const double *x = job->mesh.coordinates;
    pl_worst worst = {0};
    int status = pl_worst_select(job, most / fewer_of(mesh), &worst);
    to->corner = malloc((size_t)(worst.n * MOST_CORNERS * point_size) + 1);
    to->size = malloc((size_t)worst.n + 1);
    to->bad_ratio = malloc((size_t)(4 * worst.n) + 1);
    *element = malloc(((size_t)worst.n + 1) * sizeof **element);
    if (!status && (!to->corner || !to->size || !to->bad_ratio || !*element))
        status = pl_job_complain_memory(job, "the picture");
    for (int64_t i = 0; !status && i < worst.n; i++) {
        int n;
        const int32_t *node = pl_job_corners(job, worst.bad[i].element, &n);
        uint8_t *out = to->corner + to->n_corners * point_size;
        to->size[i] = (uint8_t)n;
        to->n_corners += n;
        for (int j = 0; j < n; j++)
            for (int d = 0; d < dim; d++, out += 4) {
                const double middle = (mesh->low[d] + mesh->high[d]) / 2;
                put_float((x[(int64_t)node[j] * dim + d] - middle) / mesh->size, out);
            }
        put_float(worst.bad[i].ratio, to->bad_ratio + 4 * i);
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
static int take_all_codes(const pl_drawn_mesh *mesh, const pl_job *job,
                          const pl_drawn_values *values, const int32_t *bad, pl_drawn_state *to) {
    const pl_drawn_inside *inside = &mesh->inside;
    const pl_drawn_surface *surface = &mesh->surface;
    int status = take_codes(job, values, bad, 0, to->n_bad, &to->bad_code);
    if (!status && !mesh->is_solid)
        return take_codes(job, values, surface->element, 0, surface->n_triangles, &to->code);
    if (!status)
        status = take_codes(job, values, inside->element, 0, inside->n, &to->inside_code);
    if (status || inside->stride == 1)
        return status;
    to->cube = malloc((size_t)(mesh->n_measures * mesh->grid.n_cells));
    if (!to->cube)
        return pl_job_complain_memory(job, "the picture");
    pl_drawn_grid_take(&mesh->grid, job, values, to->cube);
    return 0;
}

int pl_drawn_state_take(const pl_drawn_mesh *mesh, const pl_job *job, pl_drawn_state *state) {
    pl_drawn_values values;
    int32_t *bad = NULL;
    int status = pl_drawn_values_find(job, NULL, job->mesh.n_elements, &values);
    if (!status)
        status = take_surface(mesh, job, state);
    if (!status)
        status = take_worst(mesh, job, MOST_BAD, state, &bad);
    if (!status && mesh->is_solid)
        status = take_inside(mesh, job, state);
    if (!status)
        status = take_all_codes(mesh, job, &values, bad, state);
    pl_drawn_values_free(&values);
    free(bad);
    return status;
}

/* ---- in brief -------------------------------------------------------------------------------- */

/** Whether all elements are drawn inside. */
static int is_complete(const pl_drawn_mesh *mesh) {
    return mesh->is_solid && mesh->inside.stride == 1;
}

int64_t pl_drawn_state_brief_bad(const pl_drawn_mesh *mesh) {
    return is_complete(mesh) ? 0 : MOST_BAD_IN_BRIEF / fewer_of(mesh);
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

int pl_drawn_state_take_brief(const pl_drawn_mesh *mesh, const pl_job *job, pl_drawn_state *state) {
    const pl_drawn_inside *inside = &mesh->inside;
    int32_t *bad = NULL;
    int status = take_surface(mesh, job, state);
    if (!status && is_complete(mesh)) {
        status = take_inside(mesh, job, state);
        if (!status)
            status =
                take_few_codes(job, inside->element, inside->n, NULL, &state->inside_code, state);
        for (int64_t i = 0; i < inside->n && !status; i++)
            state->n_inverted += state->inside_code[i] == 0;
        return status;
    }
    if (!status)
        status = take_worst(mesh, job, MOST_BAD_IN_BRIEF, state, &bad);
    if (!status)
        status = mesh->is_solid
                     ? take_few_codes(job, NULL, 0, bad, NULL, state)
                     : take_few_codes(job, mesh->surface.element, mesh->surface.n_triangles, bad,
                                      &state->code, state);
    free(bad);
    return status;
}

/* ---- as JSON --------------------------------------------------------------------------------- */

/** An array of a state, for the viewer. */
typedef struct array {
    const char *name;
    const uint8_t *bytes; /* NULL: the state has none */
    int64_t n;
} array;

enum { N_ARRAYS = 9 };

/** List the arrays of a state; points only where they are not those of first. */
static void list_arrays(const pl_drawn_mesh *mesh, const pl_drawn_state *s,
                        const pl_drawn_state *first, array list[N_ARRAYS]) {
    const int64_t dim = mesh->dim, of_points = 2 * mesh->surface.n_points * dim,
                  m = mesh->n_measures;
    const int is_same = first && memcmp(s->point, first->point, (size_t)of_points) == 0;
    const int has_sizes = mesh->has_types || mesh->is_surface;
    const array all[N_ARRAYS] = {
        {"points", is_same ? NULL : s->point, of_points},
        {"codes", s->code, m * mesh->surface.n_triangles},
        {"corners", s->corner, 4 * s->n_corners * dim},
        {"sizes", has_sizes ? s->size : NULL, s->n_bad},
        {"bad_ratios", s->bad_ratio, 4 * s->n_bad},
        {"bad_codes", s->bad_code, m * s->n_bad},
        {"inside", s->inside, 6 * mesh->inside.n_points},
        {"inside_codes", s->inside_code, m * mesh->inside.n},
        {"cubes", s->cube, m * mesh->grid.n_cells},
    };
    memcpy(list, all, sizeof all);
}

void pl_drawn_state_put(pl_markup *page, const pl_drawn_mesh *mesh, const pl_drawn_state *state,
                        const pl_drawn_state *first) {
    array list[N_ARRAYS];
    list_arrays(mesh, state, first, list);
    pl_markup_put(page, ",\"inverted\":%" PRId64, state->n_inverted);
    for (int i = 0; i < N_ARRAYS; i++)
        if (list[i].bytes) {
            pl_markup_put(page, ",\n\"%s\":\"", list[i].name);
            pl_markup_put_base64(page, list[i].bytes, list[i].n);
            pl_markup_put(page, "\"");
        }
}

int64_t pl_drawn_state_length(const pl_drawn_mesh *mesh, const pl_drawn_state *state,
                              const pl_drawn_state *first) {
    array list[N_ARRAYS];
    int64_t length = 0;
    list_arrays(mesh, state, first, list);
    for (int i = 0; i < N_ARRAYS; i++)
        length += list[i].bytes ? list[i].n / 3 * 4 + 30 : 0;
    return length;
}

/* ---- places ---------------------------------------------------------------------------------- */

void pl_drawn_state_triangle(const pl_drawn_mesh *mesh, const pl_drawn_state *state,
                             int64_t triangle, double place[3][3]) {
    const int dim = mesh->dim;
    memset(place, 0, 9 * sizeof **place);
    for (int k = 0; k < 3 * dim; k++) {
        const int d = k % dim;
        const int64_t point = mesh->surface.triangle[3 * triangle + k / dim];
        const uint32_t at = get_little_endian(state->point + 2 * (point * dim + d), 2);
        place[k / dim][d] = (at / PLACES - 0.5) * (mesh->high[d] - mesh->low[d]) / mesh->size;
    }
}

void pl_drawn_state_corners(const pl_drawn_mesh *mesh, const uint8_t *corner, int n,
                            double place[8][3]) {
    memset(place, 0, (size_t)MOST_CORNERS * 3 * sizeof **place);
    for (int k = 0; k < n; k++)
        for (int d = 0; d < mesh->dim; d++)
            place[k][d] = get_float(corner + 4 * (k * mesh->dim + d));
}

double pl_drawn_state_ratio(const pl_drawn_state *state, int64_t i) {
    return get_float(state->bad_ratio + 4 * i);
}

void pl_drawn_state_free(pl_drawn_state *s) {
    free(s->point);
    free(s->code);
    free(s->corner);
    free(s->size);
    free(s->bad_ratio);
    free(s->bad_code);
    free(s->inside);
    free(s->inside_code);
    free(s->cube);
    *s = (pl_drawn_state){.n_bad = 0};
}
