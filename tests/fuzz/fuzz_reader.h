/* fuzz_reader: any bytes given to the reader of one format. A fuzz target is
 *
 *     #include "fuzz_reader.h"
 *     FUZZ_READER(io_format_NAME)
 *
 * Nothing may crash, leak or hang. A mesh that is read has nodes in range and finite coordinates;
 * written unchanged it is the same bytes; written with other coordinates it reads as these;
 * converted it reads as the same mesh. Files are written to the folder that TMPDIR names.
 */
#ifndef FUZZ_READER_H
#define FUZZ_READER_H

#include "fuzz_require.h"

#include "io/file/file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { FUZZ_PATH_SIZE = 256 };

/** A path of this process for a file with that ending, in text. */
static inline const char *fuzz_path(char *text, const char *ending) {
    const char *folder = getenv("TMPDIR");
    const int length = snprintf(text, FUZZ_PATH_SIZE, "%s/planish-fuzz-%ld%s",
                                folder ? folder : "/tmp", (long)getpid(), ending);
    fuzz_require(length < FUZZ_PATH_SIZE, "TMPDIR is short");
    return text;
}

/** The corners of an element; mids stand behind them where the mesh has cells. */
static inline const int32_t *fuzz_corners(const planish_mesh *mesh, int64_t element) {
    return mesh->cells ? mesh->cells->node + mesh->cells->offset[element]
                       : mesh->elements + element * (mesh->dim + 1);
}

/** Not more than the corners of an element: those of a simplex of the mesh's dimension, or of a triangle in
 *  space. */
static inline int fuzz_count_corners(const planish_mesh *mesh, int64_t element) {
    const int type = mesh->cells ? mesh->cells->type[element] : -1;
    const int is_triangle = type == PLANISH_CELL_TRIANGLE || type == PLANISH_CELL_TRIANGLE6;
    return is_triangle ? 3 : mesh->dim + 1;
}

static inline void fuzz_check_mesh(const planish_file *file) {
    planish_mesh mesh = planish_file_mesh(file);
    fuzz_require(!mesh.cells != !mesh.elements || mesh.n_elements == 0, "elements or cells");
    for (int64_t i = 0; i < mesh.n_elements; i++) {
        const int32_t *corners = fuzz_corners(&mesh, i);
        const int64_t n = mesh.cells ? mesh.cells->offset[i + 1] - mesh.cells->offset[i] : 0;
        const int n_corners = fuzz_count_corners(&mesh, i);
        for (int k = 0; k < n_corners; k++)
            fuzz_require(corners[k] >= 0 && corners[k] < mesh.n_nodes, "nodes in range");
        for (int64_t k = n_corners; k < n; k++)
            fuzz_require(corners[k] >= -1 && corners[k] < mesh.n_nodes, "mids in range");
    }
    for (int64_t i = 0; i < mesh.n_nodes * mesh.dim; i++)
        fuzz_require(isfinite(mesh.coordinates[i]), "coordinates are finite");
}

/** All elements that are measured have nodes in range, and can be measured unless one is collapsed.
 */
static inline void fuzz_check_cells(planish_file *file) {
    const planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    planish_cell_quality quality;
    planish_error error = {.code = 0};
    fuzz_require(planish_file_cells(file, &cells, &error) == 0, "there are cells");
    fuzz_require(cells.n >= mesh.n_elements && cells.n > 0, "elements are cells");
    fuzz_require(cells.offset[0] == 0, "offsets begin with 0");
    for (int64_t i = 0; i < cells.n; i++) {
        fuzz_require(cells.offset[i] < cells.offset[i + 1], "offsets ascend");
        planish_file_element_number(file, i);
    }
    for (int64_t i = 0; i < cells.offset[cells.n]; i++)
        fuzz_require(cells.node[i] >= -1 && cells.node[i] < mesh.n_nodes, "nodes in range");
    fuzz_require(!mesh.cells || mesh.cells->node == cells.node, "elements are the first cells");
    planish_mesh all = mesh;
    all.elements = NULL;
    all.cells = &cells;
    all.n_elements = all.cells->n;
    const int status = planish_measure_cells(&all, 0, 1, &quality, NULL, &error);
    fuzz_require(status == 0 || (status == PLANISH_ERROR_MESH && error.text[0]),
                 "cells are measured, or one is wrong");
}

/** The region of an element has no tag, or one that names it. */
static inline void fuzz_check_region(const planish_file *file, uint8_t *constraint) {
    char text[256];
    const char *tag = text;
    const planish_hold hold = {.tags = &tag, .n_tags = 1};
    const int64_t last = planish_file_mesh(file).n_elements - 1;
    const int length = planish_file_element_region(file, last, text, sizeof text);
    fuzz_require(length >= 0 && strlen(text) < sizeof text, "the length is that of the tag");
    if (length > 0 && length < (int)sizeof text)
        fuzz_require(planish_file_constraints(file, &hold, constraint, NULL) == 0,
                     "the tag is one");
}

/** Each array that may tell regions can be chosen, in its turn the last of them. */
static inline void fuzz_choose_regions(planish_file *file) {
    const char *const *names = planish_file_cell_arrays(file);
    int n = 0;
    while (names[n])
        n++;
    fuzz_require(planish_file_choose_regions(file, names + (n > 0 ? n - 1 : 0), n > 0, NULL) == 0,
                 "an array of the file can be chosen");
}

/** Each array of data has finite values, or an error says why not. */
static inline void fuzz_check_data(planish_file *file) {
    planish_data_info info;
    for (int64_t i = 0; i < 64 && planish_file_data_info(file, i, &info); i++) {
        planish_data data;
        planish_error error = {.code = 0};
        const int status = planish_file_data(file, info.name, &data, &error);
        fuzz_require(status ? error.code == status && error.text[0] && !data.values
                            : data.n_components >= 1 && data.values != NULL,
                     "data have values, or an error a text");
        for (int64_t k = 0; k < data.n * data.n_components; k++)
            fuzz_require(isfinite(data.values[k]), "data are finite");
        planish_data_free(&data);
    }
}

static inline void fuzz_check_questions(const planish_file *file) {
    static const char *const tags[] = {"1"};
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_error error;
    planish_hold hold = {.tags = tags, .n_tags = 1};
    uint8_t *constraint = malloc((size_t)mesh.n_nodes + 1);
    fuzz_require(constraint != NULL, "memory");
    planish_file_get_info(file, &info);
    fuzz_require(planish_file_constraints(file, NULL, constraint, &error) == 0, "constraints");
    if (planish_file_constraints(file, &hold, constraint, &error))
        fuzz_require(strstr(error.text, "'1'") != NULL, "the error names the tag");
    if (mesh.n_nodes > 0)
        planish_file_node_number(file, mesh.n_nodes - 1);
    if (mesh.n_elements > 0)
        fuzz_check_region(file, constraint);
    hold.slide = 1;
    const planish_surface surface = planish_file_surface(file, &hold);
    fuzz_require(surface.tolerance >= 0 && surface.tolerance < 1, "the surface's tolerance");
    free(constraint);
}

/** Whether the file at path is these bytes. */
static inline int fuzz_same_bytes(const char *path, const void *data, size_t size) {
    FILE *file = fopen(path, "rb");
    char *copy = malloc(size + 1);
    fuzz_require(file && copy, "the written file can be read");
    size_t got = fread(copy, 1, size + 1, file);
    int same = got == size && (size == 0 || memcmp(copy, data, size) == 0);
    free(copy);
    fclose(file);
    return same;
}

/** Other coordinates, of the file's precision. */
static inline double *fuzz_move(const planish_file *file) {
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    int64_t n = mesh.n_nodes * mesh.dim;
    double *moved = malloc(((size_t)n + 1) * sizeof *moved);
    fuzz_require(moved != NULL, "memory");
    for (int64_t i = 0; i < n; i++) {
        double value = mesh.coordinates[i] / 3 + 0.1;
        volatile float single = (float)value;
        value = info.precision == PLANISH_PRECISION_FLOAT     ? (double)single
                : info.precision == PLANISH_PRECISION_ROUNDED ? info.round(value, info.round_user)
                                                              : value;
        moved[i] = i % 3 || !isfinite(value) ? mesh.coordinates[i] : value;
    }
    return moved;
}

/** Write file, unchanged: input is its bytes. may_refuse: an error is an answer, too. */
static inline void fuzz_check_same(const planish_file *file, const char *path, const void *input,
                                   size_t size, int may_refuse) {
    planish_error error = {.code = 0};
    const int status = planish_file_write(file, path, planish_file_mesh(file).coordinates,
                                          &(planish_write_options){.threads = 1}, &error);
    if (status)
        fuzz_require(may_refuse && error.code == status, error.text);
    else
        fuzz_require(fuzz_same_bytes(path, input, size),
                     "unchanged coordinates give the same bytes");
}

/** Whether the nodes are in a plane but for noise, which another place of them may make too large;
 *  in a tilted plane roundings are that. */
static inline int fuzz_has_noise(const planish_file *file) {
    const double *z = file->model.z;
    planish_plane plane;
    if (planish_file_plane(file, &plane) && plane.is_tilted)
        return 1;
    for (int64_t i = 1; z && i < file->model.n_nodes; i++)
        if (z[i] != z[0])
            return 1;
    /* Of another plane parallel to two axes all three columns are kept. */
    const double *across = file->model.dim == 2 && file->model.xyz
                               ? file->model.xyz + file->model.plane.axis[2]
                               : NULL;
    for (int64_t i = 1; across && i < file->model.n_nodes; i++)
        if (across[3 * i] != across[0])
            return 1;
    return 0;
}

/** Whether one file is in a plane and the other one, of the same flat elements, is not any more, or not
 *  yet: by a tolerance that depends on digits and size. */
static inline int fuzz_changes_plane(const planish_file *a, const planish_file *b) {
    return io_model_dim(&a->model) == 2 && io_model_dim(&b->model) == 2 &&
           io_model_is_surface(&a->model) != io_model_is_surface(&b->model);
}

/** Whether both files have their nodes at the same places in space: another plane may fit these
 *  better, in which they have other coordinates. */
static inline int fuzz_same_places(const planish_file *a, const double *at, const planish_file *b) {
    const planish_mesh mesh = planish_file_mesh(b);
    for (int64_t i = 0; i < mesh.n_nodes; i++) {
        double of_a[3], of_b[3];
        fuzz_require(planish_file_space_coordinates(a, i, 1, at + mesh.dim * i, of_a, NULL) == 0 &&
                         planish_file_space_coordinates(b, i, 1, mesh.coordinates + mesh.dim * i,
                                                        of_b, NULL) == 0,
                     "nodes have places");
        for (int d = 0; d < 3; d++)
            if (!(of_a[d] == of_b[d]))
                return 0;
    }
    return 1;
}

/** Whether two nodes stand at one place, which become one in a file that has points in place of nodes;
 *  roundings in a tilted plane may do that, too. */
static inline int fuzz_meet(const planish_file *file, const double *x) {
    const planish_mesh mesh = planish_file_mesh(file);
    const char *name = file->format->name;
    const int is_welded = strcmp(name, "stl") == 0 || strcmp(name, "mfem") == 0;
    if (is_welded && fuzz_has_noise(file))
        return 1;
    for (int64_t i = 0; is_welded && i < mesh.n_nodes; i++)
        for (int64_t k = 0; k < i; k++) {
            int is_same = 1;
            for (int d = 0; d < mesh.dim; d++)
                is_same &= x[i * mesh.dim + d] == x[k * mesh.dim + d];
            if (is_same)
                return 1;
        }
    return 0;
}

/** A surface in space may be a line without some of its elements, or with other coordinates. */
static inline int fuzz_is_line(const planish_file *file, const planish_error *error) {
    return io_model_is_surface(&file->model) && strstr(error->text, "near one line");
}

/** Write file with other coordinates, and read it again. */
static inline void fuzz_check_moved(const planish_file *file, const char *path) {
    planish_mesh mesh = planish_file_mesh(file), other;
    planish_file *again;
    planish_error error;
    double *moved = fuzz_move(file);
    if (planish_file_write(file, path, moved, &(planish_write_options){.threads = 1}, &error))
        fuzz_require(0, error.text);
    if (planish_file_open(path, file->format->name, 1, &again, &error)) {
        fuzz_require(fuzz_has_noise(file) || fuzz_is_line(file, &error) || fuzz_meet(file, moved),
                     error.text);
        unlink(path);
        free(moved);
        return;
    }
    other = planish_file_mesh(again);
    if (fuzz_meet(file, moved) || fuzz_changes_plane(file, again)) {
        planish_file_close(again);
        unlink(path);
        free(moved);
        return;
    }
    fuzz_require(other.dim == mesh.dim && other.n_nodes == mesh.n_nodes &&
                     other.n_elements == mesh.n_elements,
                 "the written mesh has the same size");
    const int is_plane = planish_file_plane(file, NULL) || planish_file_plane(again, NULL);
    for (int64_t i = 0; i < mesh.n_nodes * mesh.dim && !is_plane; i++)
        fuzz_require(memcmp(&other.coordinates[i], &moved[i], sizeof moved[i]) == 0,
                     "the written coordinates are those given");
    fuzz_require(!is_plane || fuzz_same_places(file, moved, again),
                 "the written places are those given");
    fuzz_require(!mesh.cells == !other.cells, "the written mesh has the same order");
    for (int64_t i = 0; i < mesh.n_elements; i++) {
        const int64_t n =
            mesh.cells ? mesh.cells->offset[i + 1] - mesh.cells->offset[i] : mesh.dim + 1;
        fuzz_require(!mesh.cells || (mesh.cells->type[i] == other.cells->type[i] &&
                                     mesh.cells->offset[i + 1] == other.cells->offset[i + 1]),
                     "the written elements have the same types");
        fuzz_require(memcmp(fuzz_corners(&mesh, i), fuzz_corners(&other, i),
                            (size_t)n * sizeof(int32_t)) == 0,
                     "the written mesh has the same elements");
    }
    planish_file_close(again);
    unlink(path);
    free(moved);
}

/** A copy for viewing has the same elements, and all others; those without a mid become straight. */
static inline void fuzz_check_same_mesh(planish_file *of_a, planish_file *of_b) {
    const planish_mesh a = planish_file_mesh(of_a), b = planish_file_mesh(of_b);
    planish_cells all, copied;
    fuzz_require(a.dim == b.dim && a.n_nodes == b.n_nodes && a.n_elements <= b.n_elements,
                 "the converted mesh has the same size");
    for (int64_t i = 0; i < a.n_nodes * a.dim; i++)
        fuzz_require(a.coordinates[i] == b.coordinates[i],
                     "the converted mesh has the same coordinates");
    for (int64_t i = 0; i < a.n_elements; i++) {
        const int32_t *of = fuzz_corners(&a, i), *to = fuzz_corners(&b, i);
        const int64_t n = b.cells ? b.cells->offset[i + 1] - b.cells->offset[i] : b.dim + 1;
        int is_missing = 0;
        for (int64_t k = 0; k < n; k++)
            fuzz_require(of[k] == to[k], "the converted mesh has the same elements");
        for (int64_t k = n; a.cells && k < a.cells->offset[i + 1] - a.cells->offset[i]; k++)
            is_missing |= of[k] < 0;
        /* VTK knows no middle of a pyramid's base. */
        fuzz_require(!a.cells || is_missing || a.cells->type[i] == PLANISH_CELL_PYRAMID14 ||
                         a.cells->offset[i + 1] - a.cells->offset[i] == n,
                     "an element is straight only where a mid is missing");
    }
    fuzz_require(planish_file_cells(of_a, &all, NULL) == 0 &&
                     planish_file_cells(of_b, &copied, NULL) == 0 && all.n == copied.n,
                 "the converted mesh has all elements");
}

/** Convert the file to one of the formats that are no VTK's, and read it again: it has as many nodes
 *  and elements. */
static inline void fuzz_check_target(planish_file *file) {
    enum { GMSH22 = 1, SURFACES = 6, N = 9 };
    static const char *const targets[N][2] = {
        {"gmsh", ".msh"},   {"gmsh22", ".msh"},  {"medit", ".mesh"},
        {"abaqus", ".inp"}, {"nastran", ".bdf"}, {"exodus", ".e"},
        {"stl", ".stl"},    {"obj", ".obj"},     {"ply", ".ply"}};
    const planish_mesh mesh = planish_file_mesh(file);
    const int t = (int)(file->model.input.size % N), is_surface = t >= SURFACES;
    const planish_convert_options data = {.format = targets[t][0]};
    char path[FUZZ_PATH_SIZE];
    planish_cells all, copied;
    planish_file *again = NULL;
    planish_error error;
    fuzz_path(path, targets[t][1]);
    const int status = planish_file_convert(file, path, mesh.coordinates, &data, &error);
    if (status && is_surface && strstr(error.text, "has no triangles or quadrilaterals"))
        return;
    fuzz_require(status == 0, error.text);
    if (planish_file_open(path, NULL, 1, &again, &error)) {
        fuzz_require(fuzz_has_noise(file) || is_surface || fuzz_is_line(file, &error), error.text);
    } else if (!is_surface && !fuzz_changes_plane(file, again)) {
        fuzz_require(planish_file_cells(file, &all, NULL) == 0 &&
                         planish_file_cells(again, &copied, NULL) == 0 &&
                         (all.n == copied.n || (t == GMSH22 && all.n > copied.n)),
                     "the converted mesh has all elements, but for copies");
        fuzz_require(planish_file_mesh(again).n_nodes == mesh.n_nodes,
                     "the converted mesh has all nodes");
    }
    planish_file_close(again);
    unlink(path);
}

/** Convert the file to VTK's XML, or its legacy format, and read it again. */
static inline void fuzz_check_converted(planish_file *file) {
    const int to_legacy = strcmp(file->format->name, "vtu") == 0;
    const planish_mesh mesh = planish_file_mesh(file);
    char path[FUZZ_PATH_SIZE], lost[64];
    uint8_t *constraint = malloc((size_t)mesh.n_nodes + 1);
    double *ratio = calloc((size_t)mesh.n_elements + 1, sizeof *ratio);
    planish_file *again = NULL;
    planish_error error;
    fuzz_require(constraint && ratio, "memory");
    fuzz_path(path, to_legacy ? ".vtk" : ".vtu");
    if (planish_file_constraints(file, NULL, constraint, &error) ||
        planish_file_convert(file, path, mesh.coordinates,
                             &(planish_convert_options){.constraint = constraint,
                                                        .radius_ratio = ratio,
                                                        .lost = lost,
                                                        .lost_size = sizeof lost},
                             &error))
        fuzz_require(0, error.text);
    fuzz_require(strlen(lost) < sizeof lost, "what is lost is a text");
    const int status = planish_file_open(path, NULL, 1, &again, &error);
    if (!status && fuzz_changes_plane(file, again)) {
        fuzz_require(fuzz_has_noise(file) || io_model_is_surface(&file->model),
                     "a plane is lost by noise alone");
    } else if (!status) {
        fuzz_check_same_mesh(file, again);
    } else if (!strstr(error.text, "this planish was built without")) {
        fuzz_require(fuzz_has_noise(file), error.text);
    }
    planish_file_close(again);
    unlink(path);
    free(constraint);
    free(ratio);
    fuzz_check_target(file);
}

/** tells: what is written with other coordinates reads as these. */
static inline int fuzz_reader(const io_format *format, const uint8_t *data, size_t size,
                              int tells) {
    char path[FUZZ_PATH_SIZE];
    planish_file *file;
    planish_error error = {.code = 0};
    int status =
        io_file_from_memory(format, "fuzz", (const char *)data, (int64_t)size, 1, &file, &error);
    format->recognise((const char *)data, (int64_t)size);
    if (status) {
        fuzz_require(error.code == status && error.text[0], "a failure has a code and a text");
        return 0;
    }
    fuzz_check_mesh(file);
    fuzz_check_cells(file);
    fuzz_check_questions(file);
    fuzz_check_data(file);
    fuzz_choose_regions(file);
    fuzz_check_questions(file);
    fuzz_check_converted(file);
    fuzz_path(path, format->extensions[0]);
    if (!planish_file_can_write(file, path)) /* Medit in binary */
        fuzz_path(path, format->extensions[1]);
    fuzz_check_same(file, path, data, size, !tells);
    if (tells) {
        fuzz_check_moved(file, path);
    } else {
        double *moved = fuzz_move(file);
        planish_file_write(file, path, moved, &(planish_write_options){.threads = 1}, &error);
        free(moved);
    }
    unlink(path);
    planish_file_close(file);
    return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define FUZZ_READER(format)                                                                        \
    int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {                                 \
        return fuzz_reader(&format, data, size, 1);                                                \
    }

#endif
