/* like: the target of each element is its shape in another file, or what its layer says. */
#include "job/like.h"
#include "options/combinations.h"

#include "job/same.h"
#include "job/sizes.h"
#include "terminal/message.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/** The file of --like, and the mesh that it is to have. */
typedef struct fitting {
    const char *path, *input; /* of the file, and of the input */
    planish_file *file, *mine;
    planish_mesh other; /* the file's, with cells */
    const planish_mesh *mesh;
    int threads;
    planish_cells cells; /* of other */
} fitting;

/** Complain of an error of the file at path, which the texts on files name by themselves. */
static int complain(const char *path, const planish_error *error) {
    if (error->code == PLANISH_ERROR_FILE || error->code == PLANISH_ERROR_FORMAT)
        return pl_complain(PL_EXIT_FAILED, "--like: %s", error->text);
    return pl_complain(PL_EXIT_FAILED, "--like %s: %s", path, error->text);
}

/* ---- whether it fits ------------------------------------------------------------------------- */

/** Return the longest way along an axis between nodes of an element of the file. */
static double extent_of(const fitting *f, int64_t element) {
    const int32_t *node = f->cells.node + f->cells.offset[element];
    const int64_t n = f->cells.offset[element + 1] - f->cells.offset[element];
    const int dim = f->other.dim;
    double extent = 0;
    for (int64_t i = 0; i < n * dim; i++) {
        const double *x = f->other.coordinates + i % dim;
        extent = fmax(extent, fabs(x[(int64_t)node[i / dim] * dim] - x[(int64_t)node[0] * dim]));
    }
    return extent;
}

/** Say why an element of the file is no target: by itself, or beside the input. */
static const char *flaw_of(const fitting *f, int64_t element) {
    planish_cell_quality ignored;
    planish_error error;
    const double extent = extent_of(f, element);
    double *jacobian = malloc((size_t)f->other.n_elements * sizeof *jacobian);
    const planish_cell_values values = {.scaled_jacobian = jacobian};
    const char *flaw = "is not valid there";
    if (jacobian && !planish_measure_cells(&f->other, 0, f->threads, &ignored, &values, &error))
        flaw = jacobian[element] < 0                      ? "is inverted"
               : !(jacobian[element] > 0)                 ? "is flat"
               : extent > pow(DBL_MAX, 1. / f->other.dim) ? "is too large"
               : extent < pow(DBL_MIN, 1. / f->other.dim)
                   ? "is too small"
                   : "is oriented otherwise than in the input";
    free(jacobian);
    return flaw;
}

/** Check that each element has a shape there. */
static int check_targets(const fitting *f, const double *place) {
    planish_mesh mesh = *f->mesh;
    planish_cell_quality ignored;
    planish_error error;
    mesh.reference = place;
    const int code = planish_measure_cells(&mesh, 0, f->threads, &ignored, NULL, &error);
    if (!code)
        return 0;
    if (code != PLANISH_ERROR_MESH || error.element < 0)
        return complain(f->path, &error);
    return pl_complain(PL_EXIT_FAILED,
                       "--like %s: element %" PRId64
                       " %s: every element must be valid there, because it is a target",
                       f->path, planish_file_element_number(f->file, error.element),
                       flaw_of(f, error.element));
}

/** Check that the mesh is one that may have targets. */
static int check_mesh(const planish_mesh *mesh, const char *input) {
    if (mesh->n_periodic > 0)
        return pl_complain(PL_EXIT_FAILED,
                           "%s: has periodic nodes: --like is not for such meshes yet", input);
    if (mesh->n_elements == 0)
        return pl_complain(PL_EXIT_FAILED, "%s: has no elements: --like has no effect", input);
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

/** Find twice the area of a flat element's first corner. */
static double area_at_corner(const planish_cells *cells, int64_t element, const double *x) {
    const int32_t *node = cells->node + cells->offset[element];
    const planish_cell_type type = (planish_cell_type)cells->type[element];
    const int is_triangle = type == PLANISH_CELL_TRIANGLE || type == PLANISH_CELL_TRIANGLE6;
    const double *a = x + 2 * (int64_t)node[0], *b = x + 2 * (int64_t)node[1];
    const double *c = x + 2 * (int64_t)node[is_triangle ? 2 : 3];
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/** Mirror places in another plane than that of a flat mesh, if most elements are seen from behind there. */
static void face_alike(const planish_mesh *mesh, double *place) {
    int64_t n_alike = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const double here = area_at_corner(mesh->cells, i, mesh->coordinates);
        const double there = area_at_corner(mesh->cells, i, place);
        n_alike += (here > 0) == (there > 0) ? 1 : -1;
    }
    for (int64_t i = 0; n_alike < 0 && i < mesh->n_nodes; i++)
        place[2 * i + 1] = -place[2 * i + 1];
}

/** Take the places of the nodes in the open file. */
static int take_places(fitting *f, pl_like *like) {
    planish_error error;
    f->other = planish_file_mesh(f->file);
    if (planish_file_cells(f->file, &f->cells, &error))
        return complain(f->path, &error);
    f->other.elements = NULL;
    f->other.cells = &f->cells;
    const pl_same_mesh mine = {f->input, f->mine, f->mesh}, other = {f->path, f->file, &f->other};
    const int status =
        pl_same_check(&mine, &other, "--like needs the same mesh before it was deformed");
    if (status)
        return status;
    const size_t size = (size_t)(f->other.n_nodes * f->other.dim) * sizeof *like->place;
    like->checksum = planish_checksum(&f->other);
    like->place = malloc(size);
    if (!like->place)
        return pl_complain(PL_EXIT_FAILED, "--like %s: out of memory for the targets", f->path);
    memcpy(like->place, f->other.coordinates, size);
    if (f->other.dim == 2 && !are_in_same_plane(f->mine, f->file))
        face_alike(f->mesh, like->place);
    return check_targets(f, like->place);
}

int pl_like_read(const pl_arguments *arguments, planish_file *file, int threads, planish_mesh *mesh,
                 pl_like *like) {
    const planish_open_options how = {.threads = threads, .isolated = 1};
    fitting f = {.path = arguments->like,
                 .input = arguments->input,
                 .mine = file,
                 .mesh = mesh,
                 .threads = threads};
    planish_error error;
    int status = check_mesh(mesh, arguments->input);
    if (status)
        return status;
    if (planish_file_cells(file, &like->cells, &error))
        return pl_complain(PL_EXIT_FAILED, "%s: %s", arguments->input, error.text);
    mesh->elements = NULL;
    mesh->cells = &like->cells;
    if (planish_file_open_with(arguments->like, &how, &f.file, &error))
        return complain(arguments->like, &error);
    status = take_places(&f, like);
    planish_file_close(f.file);
    return status;
}

/** Let the elements of mesh, as they are in file, be what the targets are made of; what: the option, if it
 *  is not for periodic meshes, or NULL. */
static int take_own(const char *input, const char *what, planish_file *file, planish_mesh *mesh,
                    pl_like *like) {
    const size_t size = (size_t)(mesh->n_nodes * mesh->dim) * sizeof *like->place;
    planish_error error;
    if (mesh->n_periodic > 0 && what)
        return pl_complain(PL_EXIT_FAILED, "%s: has periodic nodes: %s is not for such meshes yet",
                           input, what);
    if (planish_file_cells(file, &like->cells, &error))
        return pl_complain(PL_EXIT_FAILED, "%s: %s", input, error.text);
    like->place = malloc(size);
    if (!like->place)
        return pl_complain(PL_EXIT_FAILED, "%s: out of memory for the targets", input);
    memcpy(like->place, mesh->coordinates, size);
    mesh->elements = NULL;
    mesh->cells = &like->cells;
    return 0;
}

int pl_like_layers(const pl_arguments *arguments, planish_file *file, uint8_t *is_layer,
                   planish_mesh *mesh, pl_like *like) {
    like->is_layer = is_layer;
    return take_own(arguments->input, NULL, file, mesh, like);
}

int pl_like_sizes(const pl_arguments *arguments, planish_file *file, int threads,
                  planish_mesh *mesh, pl_like *like) {
    const int status = take_own(arguments->input, pl_arguments_target(arguments), file, mesh, like);
    return status ? status : pl_sizes_read(arguments, file, threads, mesh, &like->sizes);
}

void pl_like_give(const pl_like *like, planish_mesh *mesh) {
    mesh->reference = like->place;
    mesh->is_layer = like->is_layer;
    mesh->size = like->sizes.size;
    mesh->metric = like->sizes.metric;
}

void pl_like_free(pl_like *like) {
    free(like->place);
    free(like->is_layer);
    pl_sizes_free(&like->sizes);
    like->place = NULL;
    like->is_layer = NULL;
}
