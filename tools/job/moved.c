/* moved: the nodes of a mesh go where another file has them.
 *
 * In a tilted plane each file has coordinates of its own. The places in space are compared there: those of
 * a node that nobody has moved have the same bits. */
#include "job/moved.h"

#include "terminal/message.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SPACE = 3 };

/* Sine of the largest angle between the planes of two states of a flat mesh: above it figures would be
 * wrong in their first five digits. */
static const double MOST_TURNED = 1e-3;

/** Find the places [n_nodes][3] in space of the nodes of file; owned, or NULL without memory. */
static double *find_places(const planish_file *file) {
    const planish_mesh mesh = planish_file_mesh(file);
    double *places = malloc(((size_t)mesh.n_nodes * SPACE + 1) * sizeof *places);
    if (places &&
        planish_file_space_coordinates(file, 0, mesh.n_nodes, mesh.coordinates, places, NULL)) {
        free(places);
        return NULL;
    }
    return places;
}

/** Put the coordinates in the plane of a place in space into x [2]. */
static void put_in_plane(const planish_plane *plane, const double *place, double *x) {
    for (int k = 0; k < 2; k++) {
        x[k] = 0;
        for (int d = 0; d < SPACE; d++)
            x[k] += (place[d] - plane->origin[d]) * plane->direction[k][d];
    }
}

static double find_distance(const double *a, const double *b, int dim) {
    double square = 0;
    for (int d = 0; d < dim; d++)
        square += (b[d] - a[d]) * (b[d] - a[d]);
    return sqrt(square);
}

/** Find the distance that coordinates [n] in single precision cannot tell from none. */
static double find_precision(const double *x, int64_t n) {
    double largest = 0;
    for (int64_t i = 0; i < n; i++)
        largest = fmax(largest, fabs(x[i]));
    return largest * (double)FLT_EPSILON;
}

/** Whether all places [n][3] have single precision: of a file in a tilted plane it is not told. */
static int are_single(const double *place, int64_t n) {
    for (int64_t i = 0; i < n * SPACE; i++)
        if (place[i] != (double)(float)place[i])
            return 0;
    return 1;
}

static int is_single(const planish_file *file) {
    planish_file_info info;
    planish_file_get_info(file, &info);
    return info.precision == PLANISH_PRECISION_FLOAT;
}

/** Count a node that goes that far; no farther than near: it stays. */
static void count_way(double way, double near, planish_result *moved) {
    if (!(way > near))
        return;
    moved->n_moved_nodes++;
    moved->max_displacement = fmax(moved->max_displacement, way);
}

/** pl_moved_take where one of the planes is tilted. */
static int take_in_plane(pl_job *job, const planish_plane *plane, const planish_file *after,
                         planish_result *moved) {
    const int64_t n = job->mesh.n_nodes;
    double *x = planish_file_coordinates(job->file);
    double *from = find_places(job->file), *to = find_places(after);
    const int has_memory = from && to;
    const int is_rough = has_memory && (are_single(from, n) || are_single(to, n));
    const double near = is_rough ? find_precision(from, n * SPACE) : 0;
    for (int64_t i = 0; i < n && has_memory; i++) {
        const double *a = from + SPACE * i, *b = to + SPACE * i;
        const double way = find_distance(a, b, SPACE);
        count_way(way, near, moved);
        if (way > 0)
            put_in_plane(plane, b, x + 2 * i);
    }
    free(from);
    free(to);
    return has_memory ? 0 : pl_job_complain_memory(job, "the places of nodes");
}

/** Whether the planes are parallel, seen from either side. */
static int are_parallel(const planish_plane *plane, const planish_plane *other) {
    const double *a = plane->normal, *b = other->normal;
    const double sine[SPACE] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                a[0] * b[1] - a[1] * b[0]};
    const double none[SPACE] = {0, 0, 0};
    return find_distance(none, sine, SPACE) <= MOST_TURNED;
}

int pl_moved_take(pl_job *job, const planish_file *after, planish_result *moved) {
    const int dim = job->mesh.dim;
    const int64_t n = job->mesh.n_nodes;
    const double *to = planish_file_mesh(after).coordinates;
    double *x = planish_file_coordinates(job->file);
    planish_plane plane, other;
    planish_file_plane(job->file, &plane);
    planish_file_plane(after, &other);
    if (!are_parallel(&plane, &other)) /* of solids both normals are 0 */
        return pl_complain(PL_EXIT_FAILED,
                           "%s lies in another plane than %s; planish quality compares such meshes",
                           job->arguments->output, job->arguments->input);
    if (plane.is_tilted || other.is_tilted)
        return take_in_plane(job, &plane, after, moved);
    const int is_rough = is_single(job->file) || is_single(after);
    const double near = is_rough ? find_precision(x, n * dim) : 0;
    for (int64_t i = 0; i < n; i++)
        count_way(find_distance(x + dim * i, to + dim * i, dim), near, moved);
    memcpy(x, to, (size_t)(n * dim) * sizeof *x);
    return 0;
}

int pl_moved_bound(pl_job *job, const planish_file *after) {
    const planish_mesh mesh = planish_file_mesh(after);
    planish_plane plane, other;
    planish_file_plane(job->file, &plane);
    planish_file_plane(after, &other);
    if (!plane.is_tilted && !other.is_tilted) {
        pl_job_box_widen(&job->goal, mesh.dim, mesh.coordinates, mesh.n_nodes);
        return 0;
    }
    double *place = find_places(after);
    for (int64_t i = 0; i < mesh.n_nodes && place; i++) {
        double x[2];
        put_in_plane(&plane, place + SPACE * i, x);
        pl_job_box_widen(&job->goal, 2, x, 1);
    }
    const int status = place ? 0 : pl_job_complain_memory(job, "the places of nodes");
    free(place);
    return status;
}

uint64_t pl_moved_checksum(const planish_file *file) {
    const pl_job job = {.file = (planish_file *)file, .mesh = planish_file_mesh(file)};
    return pl_job_checksum(&job);
}
