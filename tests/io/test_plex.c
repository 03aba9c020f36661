/* DMPlex: elements by their points, with the corners in PETSc's order; labels; all three forms. */
#include "support/files.h"
#include "support/hdf5_builder.h"
#include "support/reading.h"

#include "io/core/bytes.h"
#include "io/plex/plex.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5

/* Six tetrahedra, with faces and edges, as DMView of PETSc 3.18 has written them, and the corners
 * of these tetrahedra as DMPlexGetTransitiveClosure has them. */
enum { N_ELEMENTS = 6, N_NODES = 8, N_FACES = 18, N_EDGES = 19, N_POINTS = 51, N_CONES = 116 };

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

static const int32_t corners[N_ELEMENTS * 4] = {1, 0, 2, 3, 3, 2, 1, 4, 2, 3, 0, 5,
                                                2, 1, 4, 7, 0, 1, 2, 7, 0, 6, 1, 7};

static const double places[N_NODES * 3] = {0, 0, 0, 1,  0, 0,    0,   1, 0,  0,    0,   1,
                                           1, 1, 1, -1, 0, 0.25, 0.5, 0, -1, 0.25, 0.5, -1};

/** Points of one kind, in version 3 a stratum: as PETSc numbers them. */
static const struct {
    int depth, first, n, size, below;
} kinds[] = {{3, 0, N_ELEMENTS, 4, 14},
             {0, 6, N_NODES, 0, 0},
             {2, 14, N_FACES, 3, 32},
             {1, 32, N_EDGES, 2, 6}};

/** A file with its labels; and what is wrong in it: the value there, -1: nothing. */
/* Where coordinates stand once more: as a function of Firedrake's, a vector that nobody calls
 * coordinates, for viewers; or as a function alone; or another link to the same. */
enum { FUNCTION = 1, VECTOR = 2, VIEWED = 4, FUNCTION_ALONE = 8, LINK = 16 };

typedef struct plex {
    int version;
    int copies;         /* of those above */
    int has_no_copy;    /* they have other values */
    int is_extruded;    /* and there is a mesh made of this one */
    int is_reversed;    /* the function has the last node first */
    int is_permuted;    /* points stand from the last to the first */
    int has_nodes_last; /* behind faces and edges */
    int is_flat;        /* elements are bounded by nodes, and the last one is a pyramid */
    int chunk, is_packed, is_float;
    int is_dangling;                  /* a link for a label leads nowhere */
    int is_one_chunk, has_user_block; /* all data in one chunk; bytes before HDF5's own */
    int dim, cone, order, size, labelled, row, rows, meshes;
    double x; /* of the second node */
} plex;

static const plex right = {.version = 1,
                           .dim = 3,
                           .cone = -1,
                           .order = -1,
                           .size = -1,
                           .labelled = -1,
                           .row = -1,
                           .rows = N_NODES,
                           .meshes = 1,
                           .x = 1};

static void put(hdf5_builder *b, const char *group, const char *name, int n, const int *values) {
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
    put(b, group, "order", N_POINTS, order);
    put(b, group, "cones", N_POINTS, size);
    put(b, group, "orientation", N_CONES, around);
    put(b, group, "cells", N_CONES, below);
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
        below[i] = corners[i] + N_ELEMENTS;
    memcpy(below + 20, last, sizeof last);
    put(b, group, "order", 14, order);
    put(b, group, "cones", 14, size);
    put(b, group, "orientation", 25, zero);
    put(b, group, "cells", 25, below);
    put_dim(b, group, "cells", 3);
}

static void put_strata(hdf5_builder *b, const plex *p, const char *group) {
    static const int permutation[] = {3, 0, 2, 1};
    int from = 0;
    char stratum[128];
    hdf5_attribute(b, group, "cell_dim", p->dim);
    put(b, group, "permutation", 4, permutation);
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
        put(b, stratum, "cone_sizes", kinds[k].n, size);
        if (n > 0)
            put(b, stratum, "cones", n, below);
        if (n > 0)
            put(b, stratum, "orientations", n, orientations + from);
        from += n;
    }
}

static void put_set(hdf5_builder *b, const char *root, const char *set, int n, const int *points) {
    char path[128];
    snprintf(path, sizeof path, "%s/labels/%s", root, set);
    hdf5_group(b, path);
    put(b, path, "indices", n, points);
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
    put(b, group, "order", N_NODES, order);
    put(b, group, "section/atlasDof", N_NODES, size);
    put(b, group, "section/atlasOff", N_NODES, begin);
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
        xyz[i] = places[p->is_reversed ? 3 * (N_NODES - 1 - i / 3) + i % 3 : i];
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
    memcpy(xyz, places, sizeof places);
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

static file_builder make(const plex *p) {
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

static planish_file *read_plex(const plex *p) {
    planish_file *file;
    planish_error error = {.text = ""};
    file_builder b = make(p);
    assert_int_equal(io_format_plex.recognise(b.data, b.size), 1);
    assert_int_equal(io_format_med.recognise(b.data, b.size), 0);
    assert_int_equal(io_format_cgns.recognise(b.data, b.size), 0);
    if (builder_read(&b, &io_format_plex, 1, &file, &error))
        fail_msg("%s", error.text);
    builder_release(&b);
    return file;
}

/* ---- what is read -------------------------------------------------------------------------- */

static void check_mesh(planish_file *file) {
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.dim, 3);
    assert_int_equal(mesh.n_nodes, N_NODES);
    assert_int_equal(mesh.n_elements, N_ELEMENTS);
    assert_memory_equal(mesh.elements, corners, sizeof corners);
    assert_memory_equal(mesh.coordinates, places, sizeof places);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_other_elements, 0);
    assert_int_equal(planish_file_node_number(file, 3), 3);
    assert_int_equal(planish_file_element_number(file, 5), 5);
}

static void all_forms_are_read(void **state) {
    (void)state;
    for (int version = 1; version <= 3; version++)
        for (int how = 0; how < 8; how++) {
            plex p = right;
            p.version = version;
            p.is_permuted = version < 3 && (how & 1);
            p.is_one_chunk = how >> 1 & 1;
            p.has_user_block = how >> 2;
            planish_file *file = read_plex(&p);
            check_mesh(file);
            planish_file_close(file);
        }
}

/** Firedrake's group of mixed meshes is no mesh; labels may be many, and of nothing. */
static void other_groups_are_no_meshes(void **state) {
    (void)state;
    plex p = right;
    p.version = 3;
    p.meshes = 3;
    planish_file *file = read_plex(&p);
    check_mesh(file);
    planish_file_close(file);
}

static int count_held(planish_file *file, const planish_hold *hold, uint8_t *constraint) {
    planish_error error = {.text = ""};
    int n = 0;
    if (planish_file_constraints(file, hold, constraint, &error))
        return -1;
    for (int i = 0; i < N_NODES; i++)
        n += constraint[i] == PLANISH_FIXED;
    return n;
}

/** The corners, in any sense. */
static void check_triangle(const int32_t *nodes, const int32_t *expected) {
    for (int i = 0; i < 3; i++) {
        int found = 0;
        for (int j = 0; j < 3; j++)
            found += nodes[j] == expected[i];
        assert_int_equal(found, 1);
    }
}

/** Of the sets of facets and edges these hold their nodes, of the others a name may. */
static void labels_are_surfaces_lines_and_groups(void **state) {
    (void)state;
    planish_file *file = read_plex(&right);
    const io_model *model = &file->model;
    static const int32_t faces[] = {0, 1, 2, 1, 2, 3, 0, 2, 5}, edge[] = {3, 4};
    uint8_t constraint[N_NODES];
    assert_int_equal(model->triangle.n, 3);
    for (int i = 0; i < 3; i++)
        check_triangle(model->triangle.nodes + 3 * i, faces + 3 * i);
    assert_int_equal(model->line.n, 1);
    assert_memory_equal(model->line.nodes, edge, sizeof edge);
    assert_true(model->triangle.entity[0] == model->triangle.entity[1] &&
                model->triangle.entity[0] != model->triangle.entity[2]);
    const char *tip[] = {"tip"}, *wall[] = {"wall:1"}, *cells[] = {"Cell Sets:8"}, *no[] = {"x"};
    planish_hold hold = {.ignore_regions = 1};
    assert_int_equal(count_held(file, &hold, constraint), 6); /* not 6 and 7 */
    hold.slide = 1;
    assert_int_equal(count_held(file, &hold, constraint), 0);
    hold.tags = tip;
    hold.n_tags = 1;
    assert_int_equal(count_held(file, &hold, constraint), 1);
    assert_int_equal(constraint[6], PLANISH_FIXED);
    hold.tags = wall;
    assert_int_equal(count_held(file, &hold, constraint), 3);
    assert_true(constraint[0] && constraint[2] && constraint[5]);
    hold.tags = cells;
    assert_int_equal(count_held(file, &hold, constraint), 6); /* not 5 and 6 */
    assert_true(!constraint[5] && !constraint[6]);
    hold.tags = no;
    assert_int_equal(count_held(file, &hold, constraint), -1);
    planish_surface surface = planish_file_surface(file, &hold);
    assert_int_equal(surface.n_facets, 3);
    assert_int_equal(surface.n_edges, 1);
    char region[32];
    planish_file_element_region(file, 1, region, sizeof region);
    assert_string_equal(region, "Cell Sets:8");
    planish_file_close(file);
}

static void other_elements_hold_their_nodes(void **state) {
    (void)state;
    plex p = right;
    p.is_flat = 1;
    planish_file *file = read_plex(&p);
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.n_elements, N_ELEMENTS - 1);
    assert_memory_equal(mesh.elements, corners, 5 * 4 * sizeof *corners);
    assert_int_equal(info.n_other_elements, 1);
    static const uint8_t held[N_NODES] = {1, 1, 1, 1, 0, 0, 0, 1};
    for (int i = 0; i < N_NODES; i++)
        assert_int_equal(file->model.hold[i], held[i] ? IO_HELD_BY_OTHER : 0);
    planish_file_close(file);
}

static void an_outline_says_what_there_is(void **state) {
    char path[TEST_PATH_SIZE];
    io_plex_outline outline;
    planish_error error = {.text = ""};
    plex p = right;
    p.version = 2;
    file_builder b = make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(test_path(path, *state, "in.h5"), &outline, &error), 0);
    assert_int_equal(outline.version, 2);
    assert_string_equal(outline.name, "mine");
    assert_string_equal(outline.coordinates, "/topologies/mine/dms/where/vecs/x/x");
    assert_true(outline.dim == 3 && outline.columns == 3 && outline.n_nodes == N_NODES);
    assert_true(outline.has_simplices_alone && !outline.has_regions_alone);
    builder_release(&b);
    p = right;
    p.is_flat = 1; /* its one label is that of regions */
    b = make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(path, &outline, &error), 0);
    assert_true(outline.version == 1 && outline.name[0] == '\0' && outline.has_regions_alone);
    assert_false(outline.has_simplices_alone);
    assert_string_equal(outline.coordinates, "/geometry/vertices");
    builder_release(&b);
    p.labelled = 1; /* an element of two regions */
    b = make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(path, &outline, &error), 0);
    assert_false(outline.has_regions_alone);
    builder_release(&b);
    p = right;
    p.cone = 3; /* an element that bounds another one */
    b = make(&p);
    test_write(*state, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(io_plex_outline_of(path, &outline, &error), 0);
    assert_false(outline.has_simplices_alone);
    builder_release(&b);
    assert_int_not_equal(io_plex_outline_of("/nowhere.h5", &outline, &error), 0);
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void refuse(const plex *p, const char *part) {
    file_builder b = make(p);
    builder_expect_error(&b, &io_format_plex, part);
    builder_release(&b);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    plex p;
    for (int version = 1; version <= 3; version++) {
        p = right;
        p.version = version;
        plex q;
        refuse(((void)(q = p, q.dim = 1), &q), "elements of dimension 1");
        refuse(((void)(q = p, q.cone = 51), &q), "none of its kind");
        refuse(((void)(q = p, q.cone = version < 3 ? 3 : 20), &q), "none of its kind");
        refuse(((void)(q = p, q.size = 2), &q), "in all");
        refuse(((void)(q = p, q.size = 100), &q), "bounded by 100 others");
        refuse(((void)(q = p, q.labelled = N_POINTS), &q), "point 51 is not in 0 .. 50");
        refuse(((void)(q = p, q.rows = N_NODES - 1), &q),
               "21 coordinates in rows of 3 for 8 nodes");
        refuse(((void)(q = p, q.x = 0.0 / 0.0), &q), "not finite");
    }
    p = right;
    refuse(((void)(p = right, p.is_dangling = 1), &p), "/labels/gone: cannot be looked at");
    refuse(((void)(p = right, p.order = 2), &p), "twice");
    refuse(((void)(p = right, p.has_nodes_last = 1), &p), "numbered between elements and nodes");
    refuse(((void)(p = right, p.order = N_POINTS), &p), "point 51");
    refuse(((void)(p = right, p.version = 2, p.row = 7), &p), "one place for each node");
    refuse(((void)(p = right, p.version = 2, p.meshes = 2), &p), "2 meshes (mine, other, ...)");
    p = right;
    p.version = 3;
    p.has_no_copy = 1;
    refuse(((void)(p.copies = FUNCTION), &p), "coordinates of 'm', too, but not the same values");
    refuse(((void)(p.copies = VIEWED), &p), "/viz/geometry/vertices: these are coordinates");
    p.has_no_copy = 0;
    p.is_reversed = 1;
    refuse(((void)(p.copies = FUNCTION), &p), "coordinates of 'm', too, but not the same values");
    refuse(((void)(p.copies = FUNCTION_ALONE), &p), "one place for each node, in their order");
    p = right;
    p.version = 2;
    refuse(((void)(p.is_extruded = 1), &p), "another mesh ('e') with coordinates of its own");
    reading_fails(&io_format_plex, "no HDF5", "no HDF5 file");
}

static void nothing_breaks_it(void **state) {
    (void)state;
    for (int version = 1; version <= 3; version++) {
        plex p = right;
        p.version = version;
        file_builder b = make(&p);
        builder_try_to_break(&b, &io_format_plex);
        builder_expect_same_on_threads(&b, &io_format_plex);
        builder_release(&b);
    }
}

static void nothing_breaks_copies(void **state) {
    (void)state;
    plex p = right;
    p.version = 3;
    p.copies = FUNCTION | VECTOR | VIEWED;
    file_builder b = make(&p);
    builder_try_to_break(&b, &io_format_plex);
    builder_release(&b);
}

/* ---- writing ------------------------------------------------------------------------------- */

static void check_writing(const char *folder, const plex *p) {
    char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE];
    planish_error error = {.text = ""};
    planish_file *file, *again;
    size_t n_copies = 1;
    for (int bit = FUNCTION; bit <= VIEWED && !p->has_no_copy; bit *= 2)
        n_copies += p->copies & bit ? 1 : 0;
    file_builder b = make(p);
    test_write(folder, "in.h5", b.data, (size_t)b.size);
    assert_int_equal(planish_file_open(test_path(in, folder, "in.h5"), NULL, 1, &file, &error), 0);
    double *xyz = planish_file_coordinates(file);
    xyz[20] = -1.5;
    test_path(out, folder, "out.h5");
    assert_int_equal(planish_file_write(file, out, xyz, 1, NULL, 0, &error), 0);
    assert_int_equal(planish_file_open(out, NULL, 1, &again, &error), 0);
    assert_memory_equal(planish_file_coordinates(again), xyz, sizeof places);
    if (!p->is_packed) {
        size_t size, changed = 0;
        char *content = test_read(out, &size);
        assert_int_equal(size, b.size);
        for (size_t i = 0; i < size; i++)
            changed += content[i] != b.data[i];
        assert_in_range(changed, n_copies, 8 * n_copies);
        assert_int_equal(changed % n_copies, 0);
        free(content);
    }
    planish_file_close(file);
    planish_file_close(again);
    builder_release(&b);
}

static void coordinates_come_back(void **state) {
    for (int version = 1; version <= 3; version++)
        for (int how = 0; how < 16; how++) {
            plex p = right;
            p.version = version;
            p.chunk = how % 4 > 0 ? 3 : 0;
            p.is_packed = how % 4 > 1;
            p.is_float = how % 4 == 3;
            p.is_one_chunk = how >> 2 & 1;
            p.has_user_block = how >> 3;
            check_writing(*state, &p);
        }
}

/** The value at 8 bytes a number of a dataset. */
static double value_of(const char *path, const char *dataset, int i) {
    double values[3 * N_NODES];
    hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    hid_t data = H5Dopen2(file, dataset, H5P_DEFAULT);
    assert_true(H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Dclose(data);
    H5Fclose(file);
    return values[i];
}

/** All that are the same move together; what is another field stays. */
static void copies_move_together(void **state) {
    static const int cases[] = {FUNCTION,       VECTOR, VIEWED, FUNCTION | VECTOR | VIEWED,
                                FUNCTION_ALONE, LINK};
    for (int version = 2; version <= 3; version++)
        for (int how = 0; how < 4; how++)
            for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
                plex p = right;
                p.version = version;
                p.chunk = how > 0 && cases[i] != LINK ? 4 : 0;
                p.is_packed = how > 1 && cases[i] != LINK;
                p.is_float = how == 3;
                p.copies = cases[i];
                check_writing(*state, &p);
                char path[TEST_PATH_SIZE];
                test_path(path, *state, "out.h5");
                if (p.copies & (FUNCTION | FUNCTION_ALONE))
                    assert_true(value_of(path,
                                         "/topologies/mine/dms/firedrake_dm/vecs/its "
                                         "coordinates/its coordinates",
                                         20) == -1.5);
                if (p.copies & VECTOR)
                    assert_true(value_of(path,
                                         "/topologies/mine/dms/another/vecs/position/position",
                                         20) == -1.5);
                if (p.copies & VIEWED)
                    assert_true(value_of(path, "/viz/geometry/vertices", 20) == -1.5);
            }
    plex p = right;
    p.version = 3;
    p.copies = VECTOR;
    p.has_no_copy = 1;
    check_writing(*state, &p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_forms_are_read),
        cmocka_unit_test(labels_are_surfaces_lines_and_groups),
        cmocka_unit_test(other_elements_hold_their_nodes),
        cmocka_unit_test_setup_teardown(an_outline_says_what_there_is, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(nothing_breaks_it),
        cmocka_unit_test(nothing_breaks_copies),
        cmocka_unit_test(other_groups_are_no_meshes),
        cmocka_unit_test_setup_teardown(copies_move_together, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test_setup_teardown(coordinates_come_back, test_folder_create,
                                        test_folder_remove),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
