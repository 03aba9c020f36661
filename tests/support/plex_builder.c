/* plex_builder: a small mesh in all forms of DMPlex, with what may be wrong in it. */
#include "support/plex_builder.h"

#ifdef PL_HDF5

#include "io/core/bytes.h"
#include "io/plex/plex.h"
#include "support/reading.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Six tetrahedra, with faces and edges, as DMView of PETSc 3.18 has written them, and the corners
 * of these tetrahedra as DMPlexGetTransitiveClosure has them. */

static const int cones[N_CONES] = {
    14, 15, 16, 17, 16, 18, 19, 20, 17, 21, 22, 23, 20, 24, 25, 26, 14, 27, 28, 24, 29, 30, 27, 31,
    32, 33, 34, 35, 36, 32, 34, 37, 35, 33, 36, 37, 38, 39, 37, 35, 40, 38, 34, 39, 40, 41, 42, 37,
    33, 43, 41, 36, 42, 43, 44, 45, 34, 39, 46, 44, 40, 45, 46, 47, 45, 32, 33, 44, 47, 48, 49, 32,
    47, 50, 48, 49, 50, 45, 7,  6,  6,  8,  8,  7,  7,  9,  9,  6,  8,  9,  9,  10, 10, 8,  7,  10,
    8,  11, 11, 9,  6,  11, 8,  13, 13, 7,  10, 13, 6,  13, 6,  12, 12, 7,  13, 12};

static const int orientations[N_CONES] = {
    0,  0,  0,  0,  -1, 0, 0, 0,  -2, 0,  0,  0,  -3, 0,  0,  0,  -3, 0,  0, -2,
    0,  0,  -2, 0,  0,  0, 0, 0,  0,  -1, -1, 0,  -1, -1, -1, -1, 0,  0,  0, -1,
    0,  -1, -1, -1, -1, 0, 0, -1, -1, 0,  -1, -1, -1, -1, 0,  0,  -1, -1, 0, -1,
    -1, -1, -1, 0,  0,  0, 0, 0,  -1, 0,  0,  0,  0,  0,  -1, -1, -1};

const int32_t plex_corners[N_ELEMENTS * 4] = {1, 0, 2, 3, 3, 2, 1, 4, 2, 3, 0, 5,
                                              2, 1, 4, 7, 0, 1, 2, 7, 0, 6, 1, 7};

const double plex_places[N_NODES * 3] = {0, 0, 0, 1,  0, 0,    0,   1, 0,  0,    0,   1,
                                         1, 1, 1, -1, 0, 0.25, 0.5, 0, -1, 0.25, 0.5, -1};

/** Points of one kind, in version 3 a stratum: as PETSc numbers them. */
static const struct {
    int depth, first, n, size, below;
} kinds[] = {{3, 0, N_ELEMENTS, 4, 14},
             {0, 6, N_NODES, 0, 0},
             {2, 14, N_FACES, 3, 32},
             {1, 32, N_EDGES, 2, 6}};

/** A file with its labels; and what is wrong in it: the value there, -1: nothing. */

const plex plex_right = {.version = 1,
                         .dim = 3,
                         .cone = -1,
                         .order = -1,
                         .size = -1,
                         .labelled = -1,
                         .row = -1,
                         .rows = N_NODES,
                         .meshes = 1,
                         .x = 1};

void plex_put(hdf5_builder *b, const char *group, const char *name, int n, const int *values) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", group, name);
    hdf5_integers(b, path, (hsize_t)n, values);
}

static void put_dim(hdf5_builder *b, const char *group, const char *name, int dim) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", group, name);
    hdf5_attribute(b, path, "cell_dim", dim);
}

/** The number of a point if nodes come last. */
static int nodes_last(int point) {
    const int is_node = point >= N_ELEMENTS && point < N_ELEMENTS + N_NODES;
    return point < N_ELEMENTS ? point
           : is_node          ? point + N_POINTS - N_ELEMENTS - N_NODES
                              : point - N_NODES;
}

static void put_together(hdf5_builder *b, const plex *p, const char *group) {
    int order[N_POINTS], size[N_POINTS], below[N_CONES], around[N_CONES], n = 0, end = N_CONES;
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < kinds[k].n; i++)
            size[n] = kinds[k].size, order[n] = n, n++;
    memcpy(below, cones, sizeof cones);
    memcpy(around, orientations, sizeof orientations);
    if (p->is_permuted) {
        int from = 0;
        for (int i = 0; i < N_POINTS; i++) {
            order[i] = N_POINTS - 1 - i;
            end -= size[i];
            memcpy(below + end, cones + from, (size_t)size[i] * sizeof *below);
            memcpy(around + end, orientations + from, (size_t)size[i] * sizeof *around);
            from += size[i];
        }
        for (int i = 0; i < N_POINTS / 2; i++) {
            const int other = size[i];
            size[i] = size[N_POINTS - 1 - i];
            size[N_POINTS - 1 - i] = other;
        }
    }
    for (int i = 0; i < N_POINTS && p->has_nodes_last; i++)
        order[i] = nodes_last(order[i]);
    for (int i = 0; i < N_CONES && p->has_nodes_last; i++)
        below[i] = nodes_last(below[i]);
    if (p->cone >= 0)
        below[0] = p->cone;
    if (p->order >= 0)
        order[3] = p->order;
    if (p->size >= 0)
        size[2] = p->size;
    plex_put(b, group, "order", N_POINTS, order);
    plex_put(b, group, "cones", N_POINTS, size);
    plex_put(b, group, "orientation", N_CONES, around);
    plex_put(b, group, "cells", N_CONES, below);
    put_dim(b, group, "cells", p->dim);
}

/** Without faces and edges: five tetrahedra, and a pyramid. */
static void put_flat(hdf5_builder *b, const char *group) {
    static const int size[] = {4, 4, 4, 4, 4, 5, 0, 0, 0, 0, 0, 0, 0, 0};
    static const int last[] = {6, 7, 8, 9, 13}, zero[25] = {0};
    int order[14], below[25];
    for (int i = 0; i < 14; i++)
        order[i] = i;
    for (int i = 0; i < 20; i++)
        below[i] = plex_corners[i] + N_ELEMENTS;
    memcpy(below + 20, last, sizeof last);
    plex_put(b, group, "order", 14, order);
    plex_put(b, group, "cones", 14, size);
    plex_put(b, group, "orientation", 25, zero);
    plex_put(b, group, "cells", 25, below);
    put_dim(b, group, "cells", 3);
}

static void put_strata(hdf5_builder *b, const plex *p, const char *group) {
    static const int permutation[] = {3, 0, 2, 1};
    int from = 0;
    char stratum[128];
    hdf5_attribute(b, group, "cell_dim", p->dim);
    plex_put(b, group, "permutation", 4, permutation);
    for (int k = 0; k < 4; k++) {
        int size[N_FACES + N_EDGES], below[N_CONES];
        const int n = kinds[k].n * kinds[k].size;
        snprintf(stratum, sizeof stratum, "%s/strata/%d", group, kinds[k].depth);
        hdf5_group(b, stratum);
        for (int i = 0; i < kinds[k].n; i++)
            size[i] = kinds[k].size;
        for (int i = 0; i < n; i++)
            below[i] = cones[from + i] - kinds[k].below;
        if (p->cone >= 0 && k == 0)
            below[0] = p->cone;
        if (p->size >= 0 && k == 2)
            size[2] = p->size;
        plex_put(b, stratum, "cone_sizes", kinds[k].n, size);
        if (n > 0)
            plex_put(b, stratum, "cones", n, below);
        if (n > 0)
            plex_put(b, stratum, "orientations", n, orientations + from);
        from += n;
    }
}

static void put_set(hdf5_builder *b, const char *root, const char *set, int n, const int *points) {
    char path[128];
    snprintf(path, sizeof path, "%s/labels/%s", root, set);
    hdf5_group(b, path);
    plex_put(b, path, "indices", n, points);
}

/** Of the first element, which no region would part from its neighbours. */
static const char *const notes[] = {"celltype/6",   "depth/3",           "ghost/1",
                                    "vtk/1",        "interior_facets/1", "exterior_facets/1",
                                    "pyop2_core/1", "pyop2_owned/1",     "pyop2_ghost/1"};

/** Two regions; a surface and one with all that bounds it; a line; nodes; what PETSc notes. */
static void put_labels(hdf5_builder *b, const plex *p, const char *root) {
    int one[] = {0, 2, 5}, two[] = {1, 3, 4}, node[] = {12};
    const int inlet[] = {14, 16}, wall[] = {22, 33, 41, 43, 6, 8, 11}, line[] = {38}, all[] = {0};
    if (p->labelled >= 0)
        one[1] = p->labelled;
    put_set(b, root, "Cell Sets/7", 3, one);
    put_set(b, root, "Cell Sets/8", 3, two);
    for (size_t i = 0; i < sizeof notes / sizeof *notes; i++)
        put_set(b, root, notes[i], 1, all);
    if (p->is_flat)
        return;
    put_set(b, root, "Face Sets/5", 2, inlet);
    put_set(b, root, "wall/1", 7, wall);
    put_set(b, root, "Edge Sets/-3", 1, line);
    put_set(b, root, "tip/1", 1, node);
    if (p->meshes == 3) { /* labels of everything, many times over, and of nothing */
        int everything[N_POINTS];
        char name[64];
        for (int i = 0; i < N_POINTS; i++)
            everything[i] = i;
        for (int i = 0; i < 90; i++) {
            snprintf(name, sizeof name, "label %d/%d", i, 2 * i);
            put_set(b, root, name, N_POINTS, everything);
        }
        snprintf(name, sizeof name, "%s/labels/empty/1", root);
        hdf5_group(b, name);
    }
}

/** The layout of a vector: values of each node. */
static void put_section(hdf5_builder *b, const plex *p, const char *group) {
    int order[N_NODES], size[N_NODES], begin[N_NODES];
    for (int i = 0; i < N_NODES; i++) {
        order[i] = N_ELEMENTS + (p->is_reversed ? N_NODES - 1 - i : i);
        size[i] = 3, begin[i] = 3 * i;
    }
    if (p->row >= 0)
        order[2] = p->row;
    plex_put(b, group, "order", N_NODES, order);
    plex_put(b, group, "section/atlasDof", N_NODES, size);
    plex_put(b, group, "section/atlasOff", N_NODES, begin);
}

static void put_array(hdf5_builder *b, const plex *p, const char *path, const double *xyz,
                      int is_list) {
    b->chunk[0] = (hsize_t)p->chunk * (is_list ? 3 : 1);
    b->chunk[1] = 3;
    b->is_packed = p->is_packed;
    hdf5_array(b, path, p->is_float ? H5T_IEEE_F32LE : H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
               (hsize_t)p->rows * (is_list ? 3 : 1), is_list ? 0 : 3, xyz);
    b->chunk[0] = 0;
}

/** A function of Firedrake, or another vector. */
static void put_vector(hdf5_builder *b, const plex *p, const char *dm, const char *name,
                       const double *xyz) {
    char path[128];
    snprintf(path, sizeof path, "/topologies/mine/dms/%s/section", dm);
    hdf5_group(b, path);
    *strrchr(path, '/') = 0;
    put_section(b, p, path);
    snprintf(path, sizeof path, "/topologies/mine/dms/%s/vecs/%s", dm, name);
    hdf5_group(b, path);
    snprintf(path, sizeof path, "/topologies/mine/dms/%s/vecs/%s/%s", dm, name, name);
    put_array(b, p, path, xyz, 1);
}

static void put_copies(hdf5_builder *b, const plex *p) {
    double xyz[3 * (N_NODES + 1)] = {0};
    for (int i = 0; i < 3 * N_NODES; i++)
        xyz[i] = plex_places[p->is_reversed ? 3 * (N_NODES - 1 - i / 3) + i % 3 : i];
    xyz[7] += p->has_no_copy;
    if (p->copies & (FUNCTION | FUNCTION_ALONE)) {
        hdf5_group(b, "/topologies/mine/firedrake_meshes/m");
        hdf5_text_attribute(b, "/topologies/mine/firedrake_meshes/m", "firedrake_coordinates",
                            "its coordinates");
        put_vector(b, p, "firedrake_dm", "its coordinates", xyz);
    }
    if (p->copies & VECTOR)
        put_vector(b, p, "another", "position", xyz);
    if (p->copies & VIEWED) {
        hdf5_group(b, "/viz/geometry");
        put_array(b, p, "/viz/geometry/vertices", xyz, 0);
    }
    if (p->copies & LINK) {
        hdf5_group(b, "/topologies/mine/dms/linked/vecs/x");
        assert_true(H5Lcreate_hard(b->file, "/topologies/mine/dms/where/vecs/x/x", b->file,
                                   "/topologies/mine/dms/linked/vecs/x/x", H5P_DEFAULT,
                                   H5P_DEFAULT) >= 0);
    }
    if (p->is_extruded) {
        hdf5_group(b, "/topologies/tall/firedrake_meshes/e");
        hdf5_text_attribute(b, "/topologies/tall/firedrake_meshes/e", "firedrake_coordinates", "c");
    }
}

static void put_coordinates(hdf5_builder *b, const plex *p, const char *group, const char *path) {
    double xyz[3 * (N_NODES + 1)] = {0};
    memcpy(xyz, plex_places, sizeof plex_places);
    xyz[3] = p->x;
    put_array(b, p, path, xyz, 0);
    plex straight = *p;
    straight.is_reversed = 0;
    if (p->version > 1)
        put_section(b, &straight, group);
}

/** HDF5 looks for its mark at 512, too. */
static file_builder behind_block(file_builder b) {
    enum { BLOCK = 512 };
    char *data = calloc((size_t)b.size + BLOCK, 1);
    assert_non_null(data);
    memcpy(data + BLOCK, b.data, (size_t)b.size);
    const int64_t size = b.size + BLOCK;
    builder_release(&b);
    return (file_builder){.data = data, .size = size, .capacity = size};
}

file_builder plex_make(const plex *p) {
    hdf5_builder b;
    hdf5_begin(&b, 0);
    b.is_one_chunk = p->is_one_chunk;
    const char *root = p->version == 1 ? "" : "/topologies/mine";
    char group[96];
    snprintf(group, sizeof group, "%s/topology", root);
    hdf5_group(&b, group);
    if (p->version == 3)
        put_strata(&b, p, group);
    else if (p->is_flat)
        put_flat(&b, group);
    else
        put_together(&b, p, group);
    put_labels(&b, p, root);
    if (p->version == 1) {
        hdf5_group(&b, "/geometry");
        put_coordinates(&b, p, "", "/geometry/vertices");
    } else if (!(p->copies & FUNCTION_ALONE)) {
        hdf5_text_attribute(&b, root, "coordinateDMName", "where");
        hdf5_text_attribute(&b, root, "coordinatesName", "x");
        hdf5_group(&b, "/topologies/mine/dms/where/section");
        hdf5_group(&b, "/topologies/mine/dms/where/vecs/x");
        put_coordinates(&b, p, "/topologies/mine/dms/where", "/topologies/mine/dms/where/vecs/x/x");
    }
    put_copies(&b, p);
    if (p->is_dangling)
        assert_true(H5Lcreate_soft("/nowhere", b.file, "/labels/gone", H5P_DEFAULT, H5P_DEFAULT) >=
                    0);
    if (p->meshes > 1)
        hdf5_group(&b, p->meshes == 2 ? "/topologies/other/topology"
                                      : "/topologies/firedrake_mixed_meshes/m");
    return p->has_user_block ? behind_block(hdf5_end(&b)) : hdf5_end(&b);
}

planish_file *plex_read(const plex *p) {
    planish_file *file;
    planish_error error = {.text = ""};
    file_builder b = plex_make(p);
    assert_int_equal(io_format_plex.recognise(b.data, b.size), 1);
    assert_int_equal(io_format_med.recognise(b.data, b.size), 0);
    assert_int_equal(io_format_cgns.recognise(b.data, b.size), 0);
    if (builder_read(&b, &io_format_plex, 1, &file, &error))
        fail_msg("%s", error.text);
    builder_release(&b);
    return file;
}

#endif
