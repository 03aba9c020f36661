/* picture: takes what a page draws of a mesh. */
#include "report/picture.h"

#include "job/worst.h"
#include "report/bytes.h"
#include "report/picture_state.h"
#include "terminal/message.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a page draws at most: with these it stays below 3 MB. Of a mesh of more than MOST_INSIDE elements
 * a sample is drawn, and a grid. */
enum {
    MOST_TRIANGLES = 40000,
    MOST_BAD = 4000,
    MOST_INSIDE = 16000,
    SAMPLE_INSIDE = 2500,
    MOST_CUBES = 32000
};

static void find_box(pl_picture *picture, const planish_mesh *mesh) {
    const int dim = mesh->dim;
    for (int d = 0; d < dim; d++) {
        double low = INFINITY, high = -INFINITY;
        for (int64_t i = 0; i < mesh->n_nodes; i++) {
            low = fmin(low, mesh->coordinates[i * dim + d]);
            high = fmax(high, mesh->coordinates[i * dim + d]);
        }
        picture->low[d] = low;
        picture->high[d] = high;
        picture->size = fmax(picture->size, high - low);
    }
    if (picture->size == 0)
        picture->size = 1;
}

/** Find the points of features: edges that coarsening leaves, and corners. */
static int find_features(pl_picture *picture, const pl_job *job) {
    const planish_shape *shape = job->curved.shape;
    const int64_t n = job->curved.info.n_edges, n_nodes = job->mesh.n_nodes;
    const int32_t *point = picture->surface.point;
    if (!shape || picture->dim != 3)
        return 0;
    uint8_t *node_class = malloc((size_t)n_nodes + 1);
    picture->edge = malloc(2 * ((size_t)n + 1) * sizeof *picture->edge);
    picture->corner = malloc(((size_t)picture->surface.n_points + 1) * sizeof *picture->corner);
    uint8_t *is_corner = calloc((size_t)picture->surface.n_points + 1, 1);
    const int failed = !node_class || !picture->edge || !picture->corner || !is_corner;
    if (!failed) {
        planish_shape_get_edges(shape, picture->edge);
        planish_shape_get_classes(shape, node_class);
    }
    for (int64_t i = 0; i < n && !failed; i++) {
        const int32_t a = point[picture->edge[2 * i]], b = point[picture->edge[2 * i + 1]];
        picture->edge[2 * picture->n_edges] = a;
        picture->edge[2 * picture->n_edges + 1] = b;
        picture->n_edges += a >= 0 && b >= 0 && a != b;
    }
    for (int64_t i = 0; i < n_nodes && !failed; i++)
        if (node_class[i] == PLANISH_SHAPE_CORNER && point[i] >= 0)
            is_corner[point[i]] = 1;
    for (int32_t i = 0; i < picture->surface.n_points && !failed; i++)
        if (is_corner[i])
            picture->corner[picture->n_corners++] = i;
    picture->has_features = !failed;
    free(node_class);
    free(is_corner);
    return failed ? pl_job_complain_memory(job, "the picture") : 0;
}

/** By how much fewer elements are drawn where they have up to 8 corners. */
static int fewer_of(const pl_picture *picture) {
    return picture->is_solid && picture->has_types ? 2 : 1;
}

int pl_picture_begin(const pl_job *job, pl_picture **result) {
    planish_error error;
    pl_picture *picture = calloc(1, sizeof *picture);
    *result = picture;
    if (!picture)
        return pl_job_complain_memory(job, "the picture");
    picture->dim = job->mesh.dim;
    picture->has_types = job->has_types;
    picture->is_surface = job->is_surface;
    picture->n_nodes = job->mesh.n_nodes;
    picture->n_elements = job->mesh.n_elements;
    picture->has_plane = planish_file_plane(job->file, &picture->plane);
    find_box(picture, &job->mesh);
    if (pl_drawn_surface_find(&job->mesh, MOST_TRIANGLES, &picture->surface, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    picture->is_solid = picture->dim == 3 && !picture->is_surface && isfinite(picture->size);
    if (picture->is_solid) {
        const int fewer = fewer_of(picture);
        const int status =
            pl_drawn_inside_find(job, MOST_INSIDE / fewer, SAMPLE_INSIDE / fewer, &picture->inside);
        if (status)
            return status;
        picture->grid = pl_drawn_grid_find(picture->low, picture->high, MOST_CUBES);
    }
    return find_features(picture, job);
}

/* ---- a state -------------------------------------------------------------------------------- */

/** Put the place of a coordinate in the box: from 0 to 1. */
static double place_of(const pl_picture *picture, int d, double x) {
    const double extent = picture->high[d] - picture->low[d];
    return extent > 0 ? fmin(fmax((x - picture->low[d]) / extent, 0), 1) : 0;
}

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

/** Return the codes [n_measures][n] of element [n], owned by the caller; NULL without memory. */
static uint8_t *codes_of(const pl_drawn_values *values, const int32_t *element, int64_t n) {
    uint8_t *code = malloc((size_t)(values->n_measures * n) + 1);
    for (int m = 0; m < values->n_measures && code; m++)
        for (int64_t i = 0; i < n; i++)
            code[m * n + i] = values->code[m * values->n + element[i]];
    return code;
}

/** Take the elements inside, and the grid if these are a sample. */
static int take_inside(const pl_picture *picture, const pl_job *job, const pl_drawn_values *values,
                       pl_drawn_state *to) {
    const pl_drawn_inside *inside = &picture->inside;
    if (!picture->is_solid)
        return 0;
    to->inside = malloc(6 * (size_t)inside->n_points + 1);
    to->inside_code = codes_of(values, inside->element, inside->n);
    if (inside->stride > 1)
        to->cube = malloc((size_t)(values->n_measures * picture->grid.n_cells));
    if (!to->inside || !to->inside_code || (inside->stride > 1 && !to->cube))
        return pl_job_complain_memory(job, "the picture");
    for (int64_t i = 0; i < 3 * inside->n_points; i++) {
        const double x = job->mesh.coordinates[3 * (int64_t)inside->node[i / 3] + i % 3];
        pl_bytes_put((uint32_t)lround(PL_PICTURE_PLACES * place_of(picture, (int)(i % 3), x)), 2,
                     to->inside + 2 * i);
    }
    if (to->cube)
        pl_drawn_grid_take(&picture->grid, job, values, to->cube);
    return 0;
}

static int take_worst(const pl_picture *picture, const pl_job *job, const pl_drawn_values *values,
                      pl_drawn_state *to) {
    enum { MOST_CORNERS = 8 };
    const int dim = picture->dim, point_size = 4 * dim;
    const double *x = job->mesh.coordinates;
    pl_worst worst = {0};
    int status = pl_worst_select(job, MOST_BAD / fewer_of(picture), &worst);
    to->corner = malloc((size_t)(worst.n * MOST_CORNERS * point_size) + 1);
    to->size = malloc((size_t)worst.n + 1);
    to->bad_ratio = malloc((size_t)(4 * worst.n) + 1);
    to->bad_code = malloc((size_t)(values->n_measures * worst.n) + 1);
    if (!status && (!to->corner || !to->size || !to->bad_ratio || !to->bad_code))
        status = pl_job_complain_memory(job, "the picture");
    for (int64_t i = 0; !status && i < worst.n; i++) {
        /* Corners relative to the middle of the box, whose longest side is 1. */
        int n;
        const int32_t *node = pl_job_corners(job, worst.bad[i].element, &n);
        uint8_t *out = to->corner + to->n_corners * point_size;
        to->size[i] = (uint8_t)n;
        to->n_corners += n;
        for (int j = 0; j < n; j++)
            for (int d = 0; d < dim; d++, out += 4) {
                const double middle = (picture->low[d] + picture->high[d]) / 2;
                pl_bytes_put_float((x[(int64_t)node[j] * dim + d] - middle) / picture->size, out);
            }
        pl_bytes_put_float(worst.bad[i].ratio, to->bad_ratio + 4 * i);
        for (int m = 0; m < values->n_measures; m++)
            to->bad_code[m * worst.n + i] = values->code[m * values->n + worst.bad[i].element];
    }
    to->n_bad = worst.n;
    to->n_inverted = worst.n_inverted;
    pl_worst_free(&worst);
    return status;
}

/** Take all that is drawn of the mesh as it is now. */
static int take_state(pl_picture *picture, const pl_job *job, const pl_drawn_values *values,
                      pl_drawn_state *to) {
    picture->n_measures = values->n_measures;
    memcpy(picture->measure, values->measure, sizeof picture->measure);
    int status = take_surface(picture, job, to);
    if (!status)
        status = take_worst(picture, job, values, to);
    if (!status)
        status = take_inside(picture, job, values, to);
    if (!status && !picture->is_solid) {
        to->code = codes_of(values, picture->surface.element, picture->surface.n_triangles);
        status = to->code ? 0 : pl_job_complain_memory(job, "the picture");
    }
    return status;
}

int pl_picture_fits(const pl_picture *picture, const pl_job *job) {
    return job->mesh.n_nodes == picture->n_nodes && job->mesh.n_elements == picture->n_elements &&
           job->mesh.dim == picture->dim;
}

int pl_picture_take(pl_picture *picture, const pl_job *job, const char *name) {
    pl_drawn_state *to = &picture->states[picture->n_states];
    if (picture->n_states == PL_PICTURE_MOST_STATES || !pl_picture_fits(picture, job))
        return pl_complain(PL_EXIT_FAILED, "%s: is another mesh than the one in the picture",
                           job->arguments->input);
    if (!isfinite(picture->size))
        return 0;
    pl_drawn_values values;
    strncpy(to->name, name, sizeof to->name - 1);
    picture->n_states++;
    int status = pl_drawn_values_find(job, &values);
    if (!status)
        status = take_state(picture, job, &values, to);
    pl_drawn_values_free(&values);
    return status;
}

double pl_picture_start(const pl_picture *picture) {
    enum { FEW = 10 };
    const double usual = 3;
    double worst = 1, start = 1;
    for (int i = 0; i < picture->n_states; i++) {
        const pl_drawn_state *s = &picture->states[i];
        const double first = s->n_bad > 0 ? pl_bytes_get_float(s->bad_ratio) : 1;
        double ratio = first;
        if (!(first > 0) || first > usual)
            return usual;
        for (int64_t k = FEW; k < s->n_bad && ratio == first; k++)
            ratio = pl_bytes_get_float(s->bad_ratio + 4 * k);
        if (first > worst) {
            worst = first;
            start = ratio < first ? ratio : 1;
        }
    }
    return start;
}

/* ---- questions ------------------------------------------------------------------------------ */

int pl_picture_has_features(const pl_picture *picture) {
    return picture->has_features;
}

int64_t pl_picture_stride(const pl_picture *picture) {
    return picture->is_solid ? picture->inside.stride : 0;
}

int pl_picture_n_states(const pl_picture *picture) {
    return picture ? picture->n_states : 0;
}

const char *pl_picture_state_name(const pl_picture *picture, int i) {
    return picture->states[i].name;
}

void pl_picture_count(const pl_picture *picture, int64_t *n_all, int64_t *n_drawn) {
    *n_all = picture->surface.n_all;
    *n_drawn = picture->surface.n_triangles;
}

void pl_picture_free(pl_picture *picture) {
    if (!picture)
        return;
    for (int i = 0; i < picture->n_states; i++) {
        pl_drawn_state *s = &picture->states[i];
        free(s->point);
        free(s->code);
        free(s->corner);
        free(s->size);
        free(s->bad_ratio);
        free(s->bad_code);
        free(s->inside);
        free(s->inside_code);
        free(s->cube);
    }
    pl_drawn_inside_free(&picture->inside);
    pl_drawn_surface_free(&picture->surface);
    free(picture->edge);
    free(picture->corner);
    free(picture);
}
