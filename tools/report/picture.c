/* picture: takes what a page draws of a mesh. */
#include "report/picture.h"

#include "report/picture_take.h"
#include "terminal/message.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* What a page draws at most: with these it stays below 3 MB. Of a mesh of more than MOST_INSIDE elements
 * a sample is drawn, and a grid. */
enum { MOST_TRIANGLES = 40000, MOST_INSIDE = 16000, SAMPLE_INSIDE = 2500, MOST_CUBES = 32000 };
/* With a history it draws this part of them, so that there is room for its states. */
enum { PART_WITH_HISTORY = 2 };

/** Find the box of the mesh as it is, and as it will be if that is known. */
static void find_box(pl_picture *picture, const pl_job *job) {
    pl_job_box box = job->goal;
    pl_job_box_widen(&box, job->mesh.dim, job->mesh.coordinates, job->mesh.n_nodes);
    for (int d = 0; d < job->mesh.dim; d++) {
        picture->low[d] = box.low[d];
        picture->high[d] = box.high[d];
        picture->size = fmax(picture->size, box.high[d] - box.low[d]);
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
    picture->n_measures = pl_drawn_measures(job, picture->measure);
    picture->has_plane = planish_file_plane(job->file, &picture->plane);
    find_box(picture, job);
    const int part = job->arguments->history > 0 ? PART_WITH_HISTORY : 1;
    if (pl_drawn_surface_find(&job->mesh, MOST_TRIANGLES / part, &picture->surface, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    picture->is_solid = picture->dim == 3 && !picture->is_surface && isfinite(picture->size);
    if (picture->is_solid) {
        const int fewer = picture->has_types ? 2 : 1; /* elements have up to 8 corners */
        const int status =
            pl_drawn_inside_find(job, MOST_INSIDE / fewer, SAMPLE_INSIDE / fewer, &picture->inside);
        if (status)
            return status;
        picture->grid = pl_drawn_grid_find(picture->low, picture->high, MOST_CUBES / part);
    }
    return find_features(picture, job);
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
    strncpy(to->name, name, sizeof to->name - 1);
    picture->n_states++;
    return pl_picture_take_whole(picture, job, to);
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

int pl_picture_n_steps(const pl_picture *picture, int *n_sweeps) {
    *n_sweeps = picture->n_sweeps;
    return picture->n_steps;
}

void pl_picture_count(const pl_picture *picture, int64_t *n_all, int64_t *n_drawn) {
    *n_all = picture->surface.n_all;
    *n_drawn = picture->surface.n_triangles;
}

void pl_picture_free(pl_picture *picture) {
    if (!picture)
        return;
    for (int i = 0; i < picture->n_states; i++)
        pl_drawn_state_free(&picture->states[i]);
    for (int i = 0; i < picture->n_steps; i++)
        pl_drawn_state_free(&picture->step[i]);
    free(picture->step);
    pl_drawn_inside_free(&picture->inside);
    pl_drawn_surface_free(&picture->surface);
    free(picture->edge);
    free(picture->corner);
    free(picture);
}
