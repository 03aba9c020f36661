/* picture: what a page draws of a mesh, as data for the viewer (viewer/), in base64. */
#include "report/picture.h"

#include "report/still.h"
#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a page draws at most: with these it stays below 3 MB. Of a mesh of more than MOST_INSIDE elements
 * a sample is drawn, and a grid. */
enum { MOST_TRIANGLES = 40000, MOST_INSIDE = 16000, SAMPLE_INSIDE = 2500, MOST_CUBES = 32000 };

struct pl_picture {
    pl_drawn_mesh mesh;
    int has_plane; /* it is drawn in a plane other than that of x and y, */
    planish_plane plane;
    int64_t n_nodes, n_elements; /* of the mesh */
    int has_features;            /* of the shape of its surface: */
    int32_t *edge;               /* [n_edges][2] points of edges of features, owned */
    int64_t n_edges;
    int32_t *corner; /* [n_corners] points of corners, owned */
    int64_t n_corners;
    char name[PL_PICTURE_MOST_STATES][16]; /* of states */
    pl_drawn_state states[PL_PICTURE_MOST_STATES];
    int n_states;
    pl_picture_step *step; /* [n_steps] between them, owned */
    int n_steps, n_sweeps; /* of all sweeps */
};

static void find_box(pl_drawn_mesh *drawn, const planish_mesh *mesh) {
    const int dim = mesh->dim;
    for (int d = 0; d < dim; d++) {
        double low = INFINITY, high = -INFINITY;
        for (int64_t i = 0; i < mesh->n_nodes; i++) {
            low = fmin(low, mesh->coordinates[i * dim + d]);
            high = fmax(high, mesh->coordinates[i * dim + d]);
        }
        drawn->low[d] = low;
        drawn->high[d] = high;
        drawn->size = fmax(drawn->size, high - low);
    }
    if (drawn->size == 0)
        drawn->size = 1;
}

/** Find the points of features: edges that coarsening leaves, and corners. */
static int find_features(pl_picture *picture, const pl_job *job) {
    const planish_shape *shape = job->curved.shape;
    const int64_t n = job->curved.info.n_edges, n_nodes = job->mesh.n_nodes;
    const int32_t *point = picture->mesh.surface.point;
    if (!shape || picture->mesh.dim != 3)
        return 0;
    uint8_t *node_class = malloc((size_t)n_nodes + 1);
    picture->edge = malloc(2 * ((size_t)n + 1) * sizeof *picture->edge);
    picture->corner =
        malloc(((size_t)picture->mesh.surface.n_points + 1) * sizeof *picture->corner);
    uint8_t *is_corner = calloc((size_t)picture->mesh.surface.n_points + 1, 1);
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
    for (int32_t i = 0; i < picture->mesh.surface.n_points && !failed; i++)
        if (is_corner[i])
            picture->corner[picture->n_corners++] = i;
    picture->has_features = !failed;
    free(node_class);
    free(is_corner);
    return failed ? pl_job_complain_memory(job, "the picture") : 0;
}

int pl_picture_begin(const pl_job *job, pl_picture **result) {
    planish_error error;
    pl_picture *picture = calloc(1, sizeof *picture);
    *result = picture;
    if (!picture)
        return pl_job_complain_memory(job, "the picture");
    pl_drawn_mesh *mesh = &picture->mesh;
    mesh->dim = job->mesh.dim;
    mesh->has_types = job->has_types;
    mesh->is_surface = job->is_surface;
    mesh->n_measures = pl_drawn_measures(job, mesh->measure);
    picture->n_nodes = job->mesh.n_nodes;
    picture->n_elements = job->mesh.n_elements;
    picture->has_plane = planish_file_plane(job->file, &picture->plane);
    find_box(mesh, &job->mesh);
    if (pl_drawn_surface_find(&job->mesh, MOST_TRIANGLES, &mesh->surface, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    mesh->is_solid = mesh->dim == 3 && !mesh->is_surface && isfinite(mesh->size);
    if (mesh->is_solid) {
        const int fewer = mesh->has_types ? 2 : 1; /* elements have up to 8 corners */
        const int status =
            pl_drawn_inside_find(job, MOST_INSIDE / fewer, SAMPLE_INSIDE / fewer, &mesh->inside);
        if (status)
            return status;
        mesh->grid = pl_drawn_grid_find(mesh->low, mesh->high, MOST_CUBES);
    }
    return find_features(picture, job);
}

/* ---- a state -------------------------------------------------------------------------------- */

int pl_picture_fits(const pl_picture *picture, const pl_job *job) {
    return job->mesh.n_nodes == picture->n_nodes && job->mesh.n_elements == picture->n_elements &&
           job->mesh.dim == picture->mesh.dim;
}

int pl_picture_take(pl_picture *picture, const pl_job *job, const char *name) {
    const int i = picture->n_states;
    if (i == PL_PICTURE_MOST_STATES || !pl_picture_fits(picture, job))
        return pl_complain(PL_EXIT_FAILED, "%s: is another mesh than the one in the picture",
                           job->arguments->input);
    if (!isfinite(picture->mesh.size))
        return 0;
    strncpy(picture->name[i], name, sizeof picture->name[i] - 1);
    picture->n_states++;
    return pl_drawn_state_take(&picture->mesh, job, &picture->states[i]);
}

void pl_picture_keep_steps(pl_picture *picture, pl_picture_step *step, int n, int n_sweeps) {
    picture->step = step;
    picture->n_steps = n;
    picture->n_sweeps = n_sweeps;
}

const pl_drawn_mesh *pl_picture_mesh(const pl_picture *picture) {
    return &picture->mesh;
}

int pl_picture_has_features(const pl_picture *picture) {
    return picture->has_features;
}

int64_t pl_picture_stride(const pl_picture *picture) {
    return picture->mesh.is_solid ? picture->mesh.inside.stride : 0;
}

int pl_picture_n_states(const pl_picture *picture) {
    return picture ? picture->n_states : 0;
}

const char *pl_picture_state_name(const pl_picture *picture, int i) {
    return picture->name[i];
}

const pl_picture_step *pl_picture_steps(const pl_picture *picture, int *n, int *n_sweeps) {
    *n = picture->n_steps;
    *n_sweeps = picture->n_sweeps;
    return picture->step;
}

void pl_picture_count(const pl_picture *picture, int64_t *n_all, int64_t *n_drawn) {
    *n_all = picture->mesh.surface.n_all;
    *n_drawn = picture->mesh.surface.n_triangles;
}

int64_t pl_picture_length(const pl_picture *picture) {
    const pl_drawn_mesh *mesh = &picture->mesh;
    const pl_drawn_surface *surface = &mesh->surface;
    const int64_t n = 3 * surface->n_triangles + 2 * picture->n_edges + picture->n_corners +
                      mesh->inside.n_corners; /* numbers of points, of up to 4 bytes */
    int64_t length = n * 4 / 3 * 4;
    for (int i = 0; i < picture->n_states; i++)
        length += pl_drawn_state_length(mesh, &picture->states[i], i ? &picture->states[0] : NULL);
    return length;
}

/* ---- for the viewer ------------------------------------------------------------------------- */

static void put_little_endian(uint32_t value, int size, uint8_t *out) {
    for (int i = 0; i < size; i++)
        out[i] = (uint8_t)(value >> (8 * i));
}

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
    const pl_drawn_surface *surface = &picture->mesh.surface;
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
    for (int m = 0; m < picture->mesh.n_measures; m++) {
        const pl_drawn_measure *of = picture->mesh.measure[m];
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
    const pl_drawn_inside *inside = &picture->mesh.inside;
    const pl_drawn_grid *grid = &picture->mesh.grid;
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
    if (picture->mesh.has_types)
        put_array(page, "inside_sizes", inside->size, inside->n);
    if (inside->stride > 1)
        pl_markup_put(page, ",\n\"grid\":{\"n\":[%d,%d,%d],\"size\":%.17g}", grid->n[0], grid->n[1],
                      grid->n[2], grid->size);
    free(bytes);
}

/** Put the states, and the steps between them. */
static void put_states(pl_markup *page, const pl_picture *picture) {
    const pl_drawn_mesh *mesh = &picture->mesh;
    const pl_drawn_state *first = &picture->states[0]; /* surfaces are most often the same */
    pl_markup_put(page, ",\n\"states\":[");
    for (int i = 0; i < picture->n_states; i++) {
        pl_markup_put(page, "%s{\"name\":\"%s\"", i ? ",\n" : "", picture->name[i]);
        pl_drawn_state_put(page, mesh, &picture->states[i], i ? first : NULL);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]");
    if (picture->n_steps == 0)
        return;
    pl_markup_put(page, ",\n\"sweeps\":%d,\"steps\":[", picture->n_sweeps);
    for (int i = 0; i < picture->n_steps; i++) {
        pl_markup_put(page, "%s{\"sweep\":%d", i ? ",\n" : "", picture->step[i].sweep);
        pl_drawn_state_put(page, mesh, &picture->step[i].state, first);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]");
}

void pl_picture_put(pl_markup *page, const pl_picture *picture) {
    const pl_drawn_mesh *mesh = &picture->mesh;
    const double *low = mesh->low, *high = mesh->high;
    const int solid = mesh->dim == 3;
    pl_markup_put(page, "{\"dim\":%d,\"low\":[%.17g,%.17g,%.17g],\"high\":[%.17g,%.17g,%.17g]",
                  mesh->dim, low[0], low[1], solid ? low[2] : 0, high[0], high[1],
                  solid ? high[2] : 0);
    pl_markup_put(page, ",\"elements\":%" PRId64 ",\"coarse\":%s", picture->n_elements,
                  picture->mesh.surface.n_triangles < picture->mesh.surface.n_all ? "true"
                                                                                  : "false");
    if (mesh->is_surface)
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
    if (mesh->is_solid)
        put_inside(page, picture);
    put_states(page, picture);
    pl_markup_put(page, "}");
}

/* ---- a still picture -------------------------------------------------------------------------- */

/** Draw the surface: of flat elements in the colours of their ratios. */
static void draw_surface(const pl_drawn_mesh *mesh, const pl_drawn_state *s, pl_still *still) {
    double place[3][3];
    for (int64_t i = 0; i < mesh->surface.n_triangles; i++) {
        pl_drawn_state_triangle(mesh, s, i, place);
        pl_still_draw(still, (const double(*)[3])place,
                      s->code ? pl_drawn_class(mesh->measure[0], s->code[i]) : -1);
    }
}

/** Draw a bad element with n corners: all triangles between these cover it. */
static void draw_element(const pl_drawn_mesh *mesh, const uint8_t *corner, int n, int colour,
                         pl_still *still) {
    double at[8][3], middle[3] = {0};
    pl_drawn_state_corners(mesh, corner, n, at);
    for (int k = 0; k < n; k++)
        for (int d = 0; d < mesh->dim; d++)
            middle[d] += at[k][d] / n;
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
static void draw_bad(const pl_drawn_mesh *mesh, const pl_drawn_state *s, pl_still *still) {
    const double worse_than = mesh->is_solid ? 3 : INFINITY;
    const uint8_t *corner = s->corner;
    for (int64_t i = 0; i < s->n_bad; corner += 4 * mesh->dim * s->size[i++]) {
        const double ratio = pl_drawn_state_ratio(s, i);
        if (!(ratio > 0) || ratio > worse_than)
            draw_element(mesh, corner, s->size[i], pl_drawn_class(mesh->measure[0], s->bad_code[i]),
                         still);
    }
}

void pl_picture_put_still(pl_markup *page, const pl_picture *picture, int i, const char *title) {
    const pl_drawn_mesh *mesh = &picture->mesh;
    double extent[3] = {0};
    for (int d = 0; d < mesh->dim; d++)
        extent[d] = (mesh->high[d] - mesh->low[d]) / mesh->size;
    pl_still *still = pl_still_begin(extent);
    if (!still) {
        page->failed = 1;
        return;
    }
    draw_surface(mesh, &picture->states[i], still);
    pl_still_cover(still);
    draw_bad(mesh, &picture->states[i], still);
    pl_still_put(page, still, title);
    pl_still_free(still);
}

void pl_picture_free(pl_picture *picture) {
    if (!picture)
        return;
    for (int i = 0; i < picture->n_states; i++)
        pl_drawn_state_free(&picture->states[i]);
    for (int i = 0; i < picture->n_steps; i++)
        pl_drawn_state_free(&picture->step[i].state);
    free(picture->step);
    pl_drawn_inside_free(&picture->mesh.inside);
    pl_drawn_surface_free(&picture->mesh.surface);
    free(picture->edge);
    free(picture->corner);
    free(picture);
}
