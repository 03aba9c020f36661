/* like: the target of each element is its shape in another file. */
#include "job/like.h"

#include "job/cells.h"
#include "terminal/message.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static int complain(const pl_job *job, const planish_error *error) {
    return pl_complain(PL_EXIT_FAILED, "--like %s: %s", job->arguments->like, error->text);
}

/* ---- whether it fits ------------------------------------------------------------------------- */

/** Number of nodes of an element. */
static int64_t n_nodes_of(const planish_cells *cells, int64_t element) {
    return cells->offset[element + 1] - cells->offset[element];
}

/** Find the first element that has other nodes, or another type, in b than in a; -1: there is none. */
static int64_t find_difference(const planish_cells *a, const planish_cells *b) {
    for (int64_t i = 0; i < a->n; i++) {
        const int64_t n = n_nodes_of(a, i);
        if (a->type[i] != b->type[i] || n_nodes_of(b, i) != n ||
            memcmp(a->node + a->offset[i], b->node + b->offset[i], (size_t)n * sizeof *a->node) !=
                0)
            return i;
    }
    return -1;
}

/** Check that the file has the mesh of the input but for coordinates. */
static int check_same(const pl_job *job, const planish_file *file, const planish_mesh *other) {
    static const char *const advice = "--like needs the same mesh before it was deformed";
    const char *path = job->arguments->like, *input = job->arguments->input;
    const planish_mesh *mine = &job->mesh;
    if (other->dim != mine->dim)
        return pl_complain(PL_EXIT_FAILED, "%s is a mesh in %d dimensions, %s in %d; %s", path,
                           other->dim, input, mine->dim, advice);
    if (other->n_nodes != mine->n_nodes)
        return pl_complain(PL_EXIT_FAILED, "%s has %" PRId64 " nodes, %s has %" PRId64 "; %s", path,
                           other->n_nodes, input, mine->n_nodes, advice);
    if (other->n_elements != mine->n_elements)
        return pl_complain(PL_EXIT_FAILED, "%s has %" PRId64 " elements, %s has %" PRId64 "; %s",
                           path, other->n_elements, input, mine->n_elements, advice);
    const int64_t i = find_difference(mine->cells, other->cells);
    if (i < 0)
        return 0;
    const planish_cell_type type = (planish_cell_type)mine->cells->type[i];
    const planish_cell_type there = (planish_cell_type)other->cells->type[i];
    if (type != there)
        return pl_complain(
            PL_EXIT_FAILED, "element %" PRId64 " of %s is a %s, element %" PRId64 " of %s a %s; %s",
            planish_file_element_number(file, i), path, pl_cell_type_name(there),
            planish_file_element_number(job->file, i), input, pl_cell_type_name(type), advice);
    return pl_complain(PL_EXIT_FAILED,
                       "element %" PRId64 " of %s has other nodes than element %" PRId64
                       " of %s; %s",
                       planish_file_element_number(file, i), path,
                       planish_file_element_number(job->file, i), input, advice);
}

/** What is wrong with an element of the file that is no target: it is so by itself, or only there. */
static const char *flaw_of(const pl_job *job, const planish_mesh *other, int64_t element) {
    planish_cell_quality ignored;
    planish_error error;
    double *jacobian = malloc((size_t)other->n_elements * sizeof *jacobian);
    const planish_cell_values values = {.scaled_jacobian = jacobian};
    const char *flaw = "is not valid there";
    if (jacobian &&
        !planish_measure_cells(other, 0, job->options.threads, &ignored, &values, &error))
        flaw = jacobian[element] < 0   ? "is inverted"
               : jacobian[element] > 0 ? "is oriented otherwise than in the input"
                                       : "is flat";
    free(jacobian);
    return flaw;
}

/** Check that each element has a shape there. */
static int check_targets(const pl_job *job, const planish_file *file, const planish_mesh *other) {
    planish_mesh mesh = job->mesh;
    planish_cell_quality ignored;
    planish_error error;
    mesh.reference = job->like.place;
    const int code = planish_measure_cells(&mesh, 0, job->options.threads, &ignored, NULL, &error);
    if (!code)
        return 0;
    if (code != PLANISH_ERROR_MESH || error.element < 0)
        return complain(job, &error);
    return pl_complain(PL_EXIT_FAILED,
                       "--like %s: element %" PRId64 " %s: every element must be valid there, to "
                       "be a target",
                       job->arguments->like, planish_file_element_number(file, error.element),
                       flaw_of(job, other, error.element));
}

/** Check that the mesh of the job is one that may have targets. */
static int check_mesh(const pl_job *job) {
    if (job->mesh.n_periodic > 0)
        return pl_complain(PL_EXIT_FAILED,
                           "%s: has periodic nodes: --like is not for such meshes yet",
                           job->arguments->input);
    if (job->mesh.n_elements == 0)
        return pl_complain(PL_EXIT_FAILED, "%s: has no elements: --like has no effect",
                           job->arguments->input);
    return 0;
}

/* ---- the file --------------------------------------------------------------------------------- */

/** Whether flat meshes lie in planes whose coordinates go along the same axes. */
static int are_in_same_plane(const planish_file *a, const planish_file *b) {
    planish_plane p, q;
    planish_file_plane(a, &p);
    planish_file_plane(b, &q);
    return !p.is_tilted && !q.is_tilted && memcmp(p.axis, q.axis, sizeof p.axis) == 0;
}

/** Twice the area of a flat element's first corner. */
static double area_at_corner(const planish_cells *cells, int64_t element, const double *x) {
    const int32_t *node = cells->node + cells->offset[element];
    const int n = pl_cell_corners((planish_cell_type)cells->type[element]);
    const double *a = x + 2 * (int64_t)node[0], *b = x + 2 * (int64_t)node[1];
    const double *c = x + 2 * (int64_t)node[n - 1];
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/** A flat mesh that lies in another plane may be seen from behind there: mirror it if most elements are. */
static void face_alike(const planish_mesh *mine, double *place) {
    int64_t n_alike = 0;
    for (int64_t i = 0; i < mine->n_elements; i++) {
        const double here = area_at_corner(mine->cells, i, mine->coordinates);
        const double there = area_at_corner(mine->cells, i, place);
        n_alike += (here > 0) == (there > 0) ? 1 : -1;
    }
    for (int64_t i = 0; n_alike < 0 && i < mine->n_nodes; i++)
        place[2 * i + 1] = -place[2 * i + 1];
}

/** Take the places of the nodes in the open file. */
static int take_places(pl_job *job, planish_file *file) {
    planish_error error;
    planish_cells cells;
    planish_mesh other = planish_file_mesh(file);
    if (planish_file_cells(file, &cells, &error))
        return complain(job, &error);
    other.elements = NULL;
    other.cells = &cells;
    int status = check_same(job, file, &other);
    if (status)
        return status;
    const size_t size = (size_t)(other.n_nodes * other.dim) * sizeof *job->like.place;
    job->like.checksum = planish_checksum(&other);
    job->like.place = malloc(size);
    if (!job->like.place)
        return pl_job_complain_memory(job, "the targets");
    memcpy(job->like.place, other.coordinates, size);
    if (other.dim == 2 && !are_in_same_plane(job->file, file))
        face_alike(&job->mesh, job->like.place);
    return check_targets(job, file, &other);
}

int pl_like_read(pl_job *job) {
    const planish_open_options how = {.threads = job->options.threads, .isolated = 1};
    planish_file *file = NULL;
    planish_error error;
    int status = check_mesh(job);
    if (status)
        return status;
    if (planish_file_cells(job->file, &job->like.cells, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    job->mesh.elements = NULL;
    job->mesh.cells = &job->like.cells;
    if (planish_file_open_with(job->arguments->like, &how, &file, &error))
        return pl_complain(PL_EXIT_FAILED, "--like: %s", error.text);
    status = take_places(job, file);
    planish_file_close(file);
    return status;
}

void pl_like_free(pl_job *job) {
    free(job->like.place);
    job->like.place = NULL;
}
