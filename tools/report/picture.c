/* picture: what a page draws of a mesh, as data for the viewer (viewer/).
 *
 * Places are taken relative to the box of the mesh: those of the surface in 16 bits for each axis,
 * finer than any screen, those of bad elements, which may be tiny, as floats. All numbers are
 * little- endian, in base64.
 */
#include "report/picture.h"

#include "report/drawn_inside.h"
#include "report/drawn_surface.h"
#include "report/drawn_values.h"
#include "report/still.h"
#include "terminal/message.h"
#include "job/worst.h"

#include <inttypes.h>
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

/* Places on each side of the box, for points. */
static const double PLACES = 65535;

typedef struct drawn_state {
    char name[16];
    uint8_t *point;     /* [n_points][dim] of 16 bits */
    uint8_t *code;      /* [n_measures][n_triangles] of flat elements, else NULL */
    int64_t n_inverted; /* in the mesh, */
    int64_t n_bad;      /* and bad elements that are drawn */
    uint8_t *corner;    /* [n_corners][dim] floats, those of an element one after the other */
    uint8_t *size;      /* [n_bad] corners of each */
    int64_t n_corners;
    uint8_t *bad_ratio;   /* [n_bad] floats; 0: inverted */
    uint8_t *bad_code;    /* [n_measures][n_bad] */
    uint8_t *inside;      /* [inside.n_points][3] of 16 bits, of solid elements, else NULL; */
    uint8_t *inside_code; /* [n_measures][inside.n] theirs, */
    uint8_t *cube;        /* and [n_measures][grid.n_cells], or NULL: all elements are drawn */
} drawn_state;

struct pl_picture {
    int dim;
    int is_surface; /* of flat elements in space */
    int has_types;  /* elements are not all simplices: ratios are aspect ratios */
    int has_plane;  /* it is drawn in a plane other than that of x and y, */
    planish_plane plane;
    int64_t n_nodes, n_elements; /* of the mesh */
    double low[3], high[3];      /* its box as it was at first */
    double size;                 /* the longest side of that */
    pl_drawn_surface surface;
    int is_solid; /* has solid elements: */
    pl_drawn_inside inside;
    pl_drawn_grid grid;
    const pl_drawn_measure *measure[PL_DRAWN_MEASURES]; /* [n_measures] */
    int n_measures;
    int has_features; /* of the shape of its surface: */
    int32_t *edge;    /* [n_edges][2] points of edges of features, owned */
    int64_t n_edges;
    int32_t *corner; /* [n_corners] points of corners, owned */
    int64_t n_corners;
    drawn_state states[PL_PICTURE_MOST_STATES];
    int n_states;
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

static void put_little_endian(uint32_t value, int size, uint8_t *out) {
    for (int i = 0; i < size; i++)
        out[i] = (uint8_t)(value >> (8 * i));
}

static void put_float(double value, uint8_t *out) {
    const double largest = 1e38; /* that a float holds */
    const float rounded = (float)fmin(value, largest);
    uint32_t bits;
    memcpy(&bits, &rounded, sizeof bits);
    put_little_endian(bits, 4, out);
}

/** Put the place of a coordinate in the box: from 0 to 1. */
static double place_of(const pl_picture *picture, int d, double x) {
    const double extent = picture->high[d] - picture->low[d];
    return extent > 0 ? fmin(fmax((x - picture->low[d]) / extent, 0), 1) : 0;
}

/** Take the points of the surface, which lie in the middle of their nodes. */
static int take_surface(const pl_picture *picture, const pl_job *job, drawn_state *to) {
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
        put_little_endian((uint32_t)lround(PLACES * sum[i] / count[i / dim]), 2, to->point + 2 * i);
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
                       drawn_state *to) {
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
        put_little_endian((uint32_t)lround(PLACES * place_of(picture, (int)(i % 3), x)), 2,
                          to->inside + 2 * i);
    }
    if (to->cube)
        pl_drawn_grid_take(&picture->grid, job, values, to->cube);
    return 0;
}

static int take_worst(const pl_picture *picture, const pl_job *job, const pl_drawn_values *values,
                      drawn_state *to) {
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
                put_float((x[(int64_t)node[j] * dim + d] - middle) / picture->size, out);
            }
        put_float(worst.bad[i].ratio, to->bad_ratio + 4 * i);
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
                      drawn_state *to) {
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
    drawn_state *to = &picture->states[picture->n_states];
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

/* ---- for the viewer ------------------------------------------------------------------------- */

static void put_array(pl_markup *page, const char *name, const void *bytes, int64_t n) {
    pl_markup_put(page, ",\n\"%s\":\"", name);
    pl_markup_put_base64(page, bytes, n);
    pl_markup_put(page, "\"");
}

/** Put n numbers of points, in 16 bits if that is enough. */
static void put_points(pl_markup *page, const char *name, const pl_drawn_surface *surface,
                       const int32_t *point, int64_t n) {
    const int size = surface->n_points <= 65536 ? 2 : 4;
    uint8_t *bytes = malloc((size_t)(n * size) + 1);
    if (!bytes) {
        page->failed = 1;
        return;
    }
    for (int64_t i = 0; i < n; i++)
        put_little_endian((uint32_t)point[i], size, bytes + i * size);
    put_array(page, name, bytes, n * size);
    free(bytes);
}

/** Corners of the triangles, and features. */
static void put_triangles(pl_markup *page, const pl_picture *picture) {
    const pl_drawn_surface *surface = &picture->surface;
    pl_markup_put(page, ",\n\"index_bits\":%d", surface->n_points <= 65536 ? 16 : 32);
    put_points(page, "triangles", surface, surface->triangle, 3 * surface->n_triangles);
    if (surface->sides)
        put_array(page, "sides", surface->sides, surface->n_triangles);
    if (!picture->has_features)
        return;
    put_points(page, "features", surface, picture->edge, 2 * picture->n_edges);
    put_points(page, "corners", surface, picture->corner, picture->n_corners);
}

static void put_reals(pl_markup *page, const char *name, const double *value, int n) {
    pl_markup_put(page, ",\"%s\":[", name);
    for (int i = 0; i < n; i++)
        pl_markup_put(page, isfinite(value[i]) ? "%s%.17g" : "%snull", i ? "," : "", value[i]);
    pl_markup_put(page, "]");
}

/** Put the measures by which elements are coloured. */
static void put_measures(pl_markup *page, const pl_picture *picture) {
    pl_markup_put(page, ",\n\"codes\":%d,\"measures\":[", PL_DRAWN_CODES);
    for (int m = 0; m < picture->n_measures; m++) {
        const pl_drawn_measure *of = picture->measure[m];
        pl_markup_put(
            page, "%s{\"key\":\"%s\",\"name\":\"%s\",\"unit\":\"%s\",\"more_is_better\":%s",
            m ? ",\n" : "", of->key, of->name, of->unit, of->more_is_better ? "true" : "false");
        put_reals(page, "edges", of->edge, of->n_bins + 1);
        put_reals(page, "limits", of->limit, PL_DRAWN_CLASSES - 1);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]");
}

/** Put the elements inside, which states have in common. */
static void put_inside(pl_markup *page, const pl_picture *picture) {
    const pl_drawn_inside *inside = &picture->inside;
    const int size = inside->n_points <= 65536 ? 2 : 4;
    uint8_t *bytes = malloc((size_t)(inside->n_corners * size) + 1);
    if (!bytes) {
        page->failed = 1;
        return;
    }
    for (int64_t i = 0; i < inside->n_corners; i++)
        put_little_endian((uint32_t)inside->corner[i], size, bytes + i * size);
    pl_markup_put(page, ",\n\"stride\":%" PRId64 ",\"inside_bits\":%d", inside->stride, 8 * size);
    put_array(page, "inside_corners", bytes, inside->n_corners * size);
    if (picture->has_types)
        put_array(page, "inside_sizes", inside->size, inside->n);
    if (inside->stride > 1)
        pl_markup_put(page, ",\n\"grid\":{\"n\":[%d,%d,%d],\"size\":%.17g}", picture->grid.n[0],
                      picture->grid.n[1], picture->grid.n[2], picture->grid.size);
    free(bytes);
}

/** Put what a state draws of the elements inside. */
static void put_state_inside(pl_markup *page, const pl_picture *picture, const drawn_state *s) {
    put_array(page, "inside", s->inside, 6 * picture->inside.n_points);
    put_array(page, "inside_codes", s->inside_code, picture->n_measures * picture->inside.n);
    if (s->cube)
        put_array(page, "cubes", s->cube, picture->n_measures * picture->grid.n_cells);
}

void pl_picture_put(pl_markup *page, const pl_picture *picture) {
    const double *low = picture->low, *high = picture->high;
    const int64_t dim = picture->dim, size = 2 * picture->surface.n_points * dim;
    const int solid = dim == 3;
    pl_markup_put(page, "{\"dim\":%d,\"low\":[%.17g,%.17g,%.17g],\"high\":[%.17g,%.17g,%.17g]",
                  picture->dim, low[0], low[1], solid ? low[2] : 0, high[0], high[1],
                  solid ? high[2] : 0);
    pl_markup_put(page, ",\"elements\":%" PRId64 ",\"coarse\":%s", picture->n_elements,
                  picture->surface.n_triangles < picture->surface.n_all ? "true" : "false");
    if (picture->is_surface)
        pl_markup_put(page, ",\"flat\":true");
    if (picture->has_plane) { /* which takes places of the file to those of the picture */
        const double *u = picture->plane.direction[0], *v = picture->plane.direction[1];
        const double *o = picture->plane.origin;
        pl_markup_put(page, ",\"origin\":[%.17g,%.17g,%.17g]", o[0], o[1], o[2]);
        pl_markup_put(page, ",\"directions\":[[%.17g,%.17g,%.17g],[%.17g,%.17g,%.17g]]", u[0], u[1],
                      u[2], v[0], v[1], v[2]);
    }
    put_measures(page, picture);
    put_triangles(page, picture);
    if (picture->is_solid)
        put_inside(page, picture);
    pl_markup_put(page, ",\n\"states\":[");
    for (int i = 0; i < picture->n_states; i++) {
        const drawn_state *s = &picture->states[i];
        pl_markup_put(page, "%s{\"name\":\"%s\",\"inverted\":%" PRId64, i ? ",\n" : "", s->name,
                      s->n_inverted);
        /* Surfaces before and after are most often the same. */
        if (i == 0 || memcmp(s->point, picture->states[0].point, (size_t)size) != 0)
            put_array(page, "points", s->point, size);
        if (s->code)
            put_array(page, "codes", s->code, picture->n_measures * picture->surface.n_triangles);
        put_array(page, "corners", s->corner, 4 * s->n_corners * dim);
        if (picture->has_types || picture->is_surface)
            put_array(page, "sizes", s->size, s->n_bad);
        put_array(page, "bad_ratios", s->bad_ratio, 4 * s->n_bad);
        put_array(page, "bad_codes", s->bad_code, picture->n_measures * s->n_bad);
        if (picture->is_solid)
            put_state_inside(page, picture, s);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]}");
}

/* ---- a still picture -------------------------------------------------------------------------- */

static uint32_t get_little_endian(const uint8_t *from, int size) {
    uint32_t value = 0;
    for (int i = 0; i < size; i++)
        value |= (uint32_t)from[i] << (8 * i);
    return value;
}

static double get_float(const uint8_t *from) {
    const uint32_t bits = get_little_endian(from, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/** Draw the surface: of flat elements in the colours of their ratios. */
static void draw_surface(const pl_picture *picture, const drawn_state *s, const double *extent,
                         pl_still *still) {
    const int dim = picture->dim;
    for (int64_t i = 0; i < picture->surface.n_triangles; i++) {
        double place[3][3] = {{0}};
        for (int k = 0; k < 3 * dim; k++) {
            const int64_t point = picture->surface.triangle[3 * i + k / dim];
            const uint32_t at = get_little_endian(s->point + 2 * (point * dim + k % dim), 2);
            place[k / dim][k % dim] = (at / PLACES - 0.5) * extent[k % dim];
        }
        pl_still_draw(still, place, s->code ? pl_drawn_class(picture->measure[0], s->code[i]) : -1);
    }
}

/** Draw a bad element: all triangles between its corners cover it. */
static void draw_element(int dim, const uint8_t *corner, int n, int colour, pl_still *still) {
    double at[8][3] = {{0}}, middle[3] = {0};
    for (int k = 0; k < n; k++)
        for (int d = 0; d < dim; d++) {
            at[k][d] = get_float(corner + 4 * (k * dim + d));
            middle[d] += at[k][d] / n;
        }
    for (int a = 0; a < n; a++)
        for (int b = a + 1; b < n; b++)
            for (int c = b + 1; c < n; c++) {
                double place[3][3];
                memcpy(place[0], at[a], sizeof at[a]);
                memcpy(place[1], at[b], sizeof at[b]);
                memcpy(place[2], at[c], sizeof at[c]);
                pl_still_draw(still, (const double(*)[3])place, colour);
            }
    pl_still_dot(still, middle, colour);
}

/** Draw the elements that are worse than the viewer shows at first; of flat meshes inverted ones. */
static void draw_bad(const pl_picture *picture, const drawn_state *s, pl_still *still) {
    const double worse_than = picture->is_solid ? 3 : INFINITY;
    const uint8_t *corner = s->corner;
    for (int64_t i = 0; i < s->n_bad; corner += 4 * picture->dim * s->size[i++]) {
        const double ratio = get_float(s->bad_ratio + 4 * i);
        if (!(ratio > 0) || ratio > worse_than)
            draw_element(picture->dim, corner, s->size[i],
                         pl_drawn_class(picture->measure[0], s->bad_code[i]), still);
    }
}

void pl_picture_put_still(pl_markup *page, const pl_picture *picture, int i, const char *title) {
    const drawn_state *s = &picture->states[i];
    double extent[3] = {0};
    for (int d = 0; d < picture->dim; d++)
        extent[d] = (picture->high[d] - picture->low[d]) / picture->size;
    pl_still *still = pl_still_begin(extent);
    if (!still) {
        page->failed = 1;
        return;
    }
    draw_surface(picture, s, extent, still);
    pl_still_cover(still);
    draw_bad(picture, s, still);
    pl_still_put(page, still, title);
    pl_still_free(still);
}

void pl_picture_free(pl_picture *picture) {
    if (!picture)
        return;
    for (int i = 0; i < picture->n_states; i++) {
        drawn_state *s = &picture->states[i];
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
