/* Tests of meshes as Exodus files: sides, blocks, sets and variables, read again; and of the netCDF files
 * that they are. */
#include "support/converting.h"
#include "support/data_files.h"
#include "support/files.h"
#include "support/reading.h"

#include "io/netcdf/netcdf_header.h"
#include "io/netcdf/netcdf_write.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static planish_file *to_exodus(const char *folder, planish_file *file, char lost[512]) {
    return converting_to(folder, file, "exodus", ".e", lost);
}

/** Expect that a tag holds the same nodes, some but not all, in both files. */
static void check_tag(planish_file *a, planish_file *b, const char *tag) {
    const size_t n = (size_t)planish_file_mesh(a).n_nodes;
    uint8_t *x = converting_nodes_of(a, tag), *y = converting_nodes_of(b, tag);
    assert_int_equal(planish_file_mesh(b).n_nodes, n);
    if (memcmp(x, y, n) != 0)
        fail_msg("tag %s has other nodes", tag);
    assert_non_null(memchr(x, 1, n));
    assert_non_null(memchr(x, 0, n));
    free(x);
    free(y);
}

/** What is converted twice has the same bytes: sets, numbers, names and the order of all. */
static void exodus_files_are_converted_to_themselves(void **state) {
    for (const test_data_file *f = test_data_files; f->name; f++) {
        char path[TEST_PATH_SIZE], lost[512];
        size_t n, m;
        if (!test_data_path(path, f))
            continue;
        planish_file *file = converting_open(path);
        planish_file *copy = to_exodus(*state, file, lost);
        test_path(path, *state, "out-exodus.e");
        char *before = test_read(path, &n);
        planish_file_close(file);
        file = to_exodus(*state, copy, lost);
        char *after = test_read(path, &m);
        if (n != m || memcmp(before, after, n) != 0)
            fail_msg("%s changes when it is converted again", f->name);
        free(before);
        free(after);
        planish_file_close(copy);
        planish_file_close(file);
    }
}

/** Names and numbers of an Exodus file stay. */
static void sets_and_numbers_stay(void **state) {
    char path[TEST_PATH_SIZE], lost[512];
    test_path_from(path, "PLANISH_TEST_DATA", "cube.exo");
    planish_file *file = converting_open(path);
    planish_file *copy = to_exodus(*state, file, lost);
    static const char *const tags[] = {"skin", "corner", "lower part", "upper part", "3:1", "2:3"};
    for (size_t i = 0; i < sizeof tags / sizeof *tags; i++)
        check_tag(file, copy, tags[i]);
    assert_string_equal(lost, "parameters and comments");
    planish_file_close(copy);
    planish_file_close(file);
}

/* ---- sides ---------------------------------------------------------------------------------- */

/** Put a triangle or quadrilateral for each face of a pyramid, a wedge, a hexahedron and a tetrahedron
 *  that share no nodes: face k has reference k + 1. Returns how many. */
static int put_solids(file_builder *b) {
    static const char *const faces[] = {/* pyramid */ "1 2 3 4",
                                        "1 2 5",
                                        "2 3 5",
                                        "3 4 5",
                                        "4 1 5",
                                        /* wedge */ "6 7 8",
                                        "9 10 11",
                                        "6 7 10 9",
                                        "7 8 11 10",
                                        "8 6 9 11",
                                        /* hexahedron */ "12 13 14 15",
                                        "16 17 18 19",
                                        "12 13 17 16",
                                        "13 14 18 17",
                                        "14 15 19 18",
                                        "15 12 16 19",
                                        /* tetrahedron */ "20 21 22",
                                        "20 21 23",
                                        "21 22 23",
                                        "22 20 23"};
    enum { N_FACES = sizeof faces / sizeof *faces, N_TRIANGLES = 10 };
    builder_text(b, "MeshVersionFormatted 2\nDimension 3\nVertices\n27\n"
                    "0 0 0 0 1 0 0 0 1 1 0 0 0 1 0 0 0.5 0.5 1 0\n"
                    "2 0 0 0 3 0 0 0 2 1 0 0 2 0 1 0 3 0 1 0 2 1 1 0\n");
    builder_text(b, "4 0 0 0 5 0 0 0 5 1 0 0 4 1 0 0 4 0 1 0 5 0 1 0 5 1 1 0 4 1 1 0\n"
                    "6 0 0 0 7 0 0 0 6 1 0 0 6 0 1 0\n9 0 0 7 9 1 0 7 9 0 1 7 9 1 1 7\n");
    builder_text(b, "Pyramids\n1\n1 2 3 4 5 1\nPrisms\n1\n6 7 8 9 10 11 1\nHexahedra\n1\n"
                    "12 13 14 15 16 17 18 19 2\nTetrahedra\n1\n20 21 22 23 2\n");
    for (int corners = 3; corners <= 4; corners++) {
        builder_text(b, corners == 3 ? "Triangles\n%d\n" : "Quadrilaterals\n%d\n",
                     corners == 3 ? N_TRIANGLES + 1 : N_FACES - N_TRIANGLES);
        for (int k = 0; k < N_FACES; k++) {
            int n_blanks = 0;
            for (const char *c = faces[k]; *c; c++)
                n_blanks += *c == ' ';
            if (n_blanks + 1 == corners)
                builder_text(b, "%s %d\n", faces[k], k + 1);
        }
        builder_text(b, corners == 3 ? "24 25 26 77\n" : "");
    }
    builder_text(b, "Edges\n2\n24 27 5\n1 2 6\nEnd\n");
    return N_FACES;
}

/** All faces of all solids are sides of them. A facet of none is a block, and so are lines. */
static void faces_of_solids_are_sides(void **state) {
    file_builder b = {.binary = 0};
    char lost[512], tag[16];
    const int n = put_solids(&b);
    planish_file *file = converting_open_built(*state, "solids.mesh", &b);
    planish_file *copy = to_exodus(*state, file, lost);
    for (int k = 0; k < n; k++) {
        snprintf(tag, sizeof tag, "2:%d", k + 1);
        check_tag(file, copy, tag);
    }
    check_tag(file, copy, "2:77");
    check_tag(file, copy, "1:5");
    check_tag(file, copy, "0:7");
    assert_int_equal(copy->model.triangle.n, file->model.triangle.n);
    assert_int_equal(copy->model.flat.n, file->model.flat.n);
    assert_int_equal(copy->model.line.n, 2);
    assert_int_equal(copy->n_regions, 4); /* two of two types each */
    assert_non_null(strstr(lost, "regions of several types as one"));
    planish_file_close(copy);
    planish_file_close(file);
}

/** Edges of flat elements are sides, in a plane and in space, where they begin behind two faces. */
static void edges_of_flat_elements_are_sides(void **state) {
    for (int is_space = 0; is_space < 2; is_space++) {
        static const char *const edges[] = {"1 2", "2 5", "5 6", "6 1", "2 3", "3 5"};
        enum { N_EDGES = sizeof edges / sizeof *edges };
        file_builder b = {.binary = 0};
        char lost[512], tag[16];
        builder_text(&b,
                     "MeshVersionFormatted 2\nDimension 3\nVertices\n7\n0 0 0 0\n1 0 %d 0\n"
                     "2 0 0 0\n3 0 0 0\n1 1 0 0\n0 1 0 0\n3 3 0 0\nTriangles\n1\n2 3 5 1\n"
                     "Quadrilaterals\n1\n1 2 5 6 1\nEdges\n%d\n4 7 50\n",
                     is_space, N_EDGES + 1);
        for (int k = 0; k < N_EDGES; k++)
            builder_text(&b, "%s %d\n", edges[k], k + 1);
        builder_text(&b, "End\n");
        planish_file *file = converting_open_built(*state, "flat.mesh", &b);
        planish_file *copy = to_exodus(*state, file, lost);
        assert_int_equal(planish_file_mesh(file).dim, is_space ? 3 : 2);
        assert_int_equal(planish_file_mesh(copy).dim, is_space ? 3 : 2);
        assert_int_equal(copy->model.columns, is_space ? 3 : 2);
        for (int k = 0; k < N_EDGES; k++) {
            snprintf(tag, sizeof tag, "1:%d", k + 1);
            check_tag(file, copy, tag);
        }
        check_tag(file, copy, "1:50");
        assert_int_equal(copy->model.line.n, N_EDGES + 1);
        planish_file_close(copy);
        planish_file_close(file);
    }
}

/** Facets keep the nodes in their middle, where the element has them. */
static void facets_keep_their_middles(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 27 double\n0 0 0 2 0 0 2 2 0 0 2 0 0 0 2 2 0 2 2 2 2 0 2 2\n"
                     "1 0 0 2 1 0 1 2 0 0 1 0 1 0 2 2 1 2 1 2 2 0 1 2 0 0 1 2 0 1 2 2 1 0 2 1\n"
                     "0 1 1 2 1 1 1 0 1 1 2 1 1 1 0 1 1 2 1 1 1\nCELLS 7 88\n27");
    for (int i = 0; i < 27; i++)
        builder_text(&b, " %d", i);
    builder_text(&b, "\n9 0 3 2 1 11 10 9 8 24\n9 4 5 6 7 12 13 14 15 25\n"
                     "9 0 1 5 4 8 17 12 16 22\n9 1 2 6 5 9 18 13 17 21\n"
                     "9 2 3 7 6 10 19 14 18 23\n9 3 0 4 7 11 16 15 19 20\n"
                     "CELL_TYPES 7\n29 28 28 28 28 28 28\n");
    planish_file *file = converting_open_built(*state, "whole.vtk", &b);
    planish_file *copy = to_exodus(*state, file, lost);
    const io_others *flat = &copy->model.flat;
    assert_int_equal(flat->n, 6);
    for (int i = 0; i < 6; i++) {
        const int32_t *node = flat->node + flat->offset[i];
        assert_int_equal(flat->type[i], PLANISH_CELL_QUADRILATERAL9);
        for (int d = 0; d < 3; d++)
            assert_true(2 * copy->model.xyz[3 * node[8] + d] ==
                        copy->model.xyz[3 * node[0] + d] + copy->model.xyz[3 * node[2] + d]);
    }
    planish_file_close(copy);
    planish_file_close(file);
}

/* ---- groups --------------------------------------------------------------------------------- */

/** Groups of several blocks, and blocks of several groups, keep what a file has room for. */
static void groups_name_blocks(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "*NODE\n10,0,0,0\n20,1,0,0\n30,0,1,0\n40,0,0,1\n50,1,1,1\n60,2,0,0\n"
                     "*ELEMENT, TYPE=C3D4, ELSET=one\n7,10,20,30,40\n"
                     "*ELEMENT, TYPE=C3D4, ELSET=two\n9,20,30,40,50\n"
                     "*ELEMENT, TYPE=C3D4\n8,20,30,60,50\n"
                     "*NSET, NSET=\"my nodes\"\n20,50\n*ELSET, ELSET=both\none,two\n");
    planish_file *file = converting_open_built(*state, "sets.inp", &b);
    planish_file *copy = to_exodus(*state, file, lost);
    static const char *const tags[] = {"my nodes", "one", "two"};
    for (size_t i = 0; i < sizeof tags / sizeof *tags; i++)
        check_tag(file, copy, tags[i]);
    assert_non_null(strstr(lost, "all but the first group of elements that are in several"));
    assert_null(strstr(lost, "as one"));
    assert_int_equal(planish_file_node_number(copy, 4), 50);
    for (int i = 0; i < 3; i++) { /* blocks are in the order of the entities */
        const int64_t number = planish_file_element_number(copy, i);
        assert_true(number >= 7 && number <= 9);
    }
    planish_file_close(copy);
    planish_file_close(file);
}

/** Blocks of one group have names of their own. */
static void names_of_blocks_are_distinct(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n3 4 \"solid\"\n"
                     "3 9 \"nothing\"\n$EndPhysicalNames\n$Nodes\n6\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                     "4 0 0 1\n5 1 1 1\n6 2 0 0\n$EndNodes\n$Elements\n3\n1 4 2 4 1 1 2 3 4\n"
                     "2 4 2 4 2 2 3 4 5\n3 4 2 4 2 2 3 6 5\n$EndElements\n");
    planish_file *file = converting_open_built(*state, "solid.msh", &b);
    planish_file *copy = to_exodus(*state, file, lost);
    assert_non_null(strstr(lost, "groups of several blocks as one"));
    assert_non_null(strstr(lost, "names of groups without elements"));
    assert_int_equal(copy->model.n_groups, 2);
    assert_string_equal(copy->model.group[0].name, "solid");
    assert_string_equal(copy->model.group[1].name, "solid_2");
    planish_file_close(copy);
    planish_file_close(file);
}

/** Read the converted file to model, the bytes of which are to be freed, and its header, which refers to model. */
static char *read_converted(const char *folder, char path[TEST_PATH_SIZE], size_t *size,
                            io_model *model, netcdf_header *header) {
    planish_error error = {.text = ""};
    char *bytes = test_read(test_path(path, folder, "out-exodus.e"), size);
    *model = (io_model){.input = {.path = path, .data = bytes, .size = (int64_t)*size}};
    if (netcdf_header_read(model, header, &error))
        fail_msg("%s", error.text);
    return bytes;
}

/** Expect that side set k (from 1) of the converted file has n sides and that name. */
static void check_side_set(const char *folder, int k, int n, const char *name) {
    char path[TEST_PATH_SIZE], text[32];
    size_t size;
    netcdf_header header;
    io_model model;
    char *bytes = read_converted(folder, path, &size, &model, &header);
    snprintf(text, sizeof text, "num_side_ss%d", k);
    assert_int_equal(netcdf_header_dimension(&header, text), n);
    const netcdf_variable *v = netcdf_header_find(&header, "ss_names");
    const int64_t length = netcdf_header_dimension(&header, "len_name");
    assert_string_equal(bytes + v->begin + (k - 1) * length, name);
    netcdf_header_release(&header);
    free(bytes);
}

/** Groups of one name are one side set or node set, as programs look sets up by their names. All names of
 *  a number stay. */
static void names_are_sets(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n5\n2 5 \"all\"\n"
                     "2 3 \"all\"\n2 3 \"lid\"\n2 5 \"skin\"\n3 1 \"inside\"\n"
                     "$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 3 3 3\n");
    builder_text(&b, "$EndNodes\n$Elements\n4\n1 4 2 1 1 1 2 3 4\n2 2 2 3 8 1 2 3\n"
                     "3 2 2 5 9 1 2 4\n4 2 2 3 8 1 3 4\n$EndElements\n");
    planish_file *file = converting_open_built(*state, "names.msh", &b);
    planish_file *copy = to_exodus(*state, file, lost);
    assert_string_equal(lost, "parameters and comments");
    assert_int_equal(copy->model.triangle.n, 3);
    assert_int_equal(copy->model.n_groups, 4); /* all of facets but the block's */
    check_side_set(*state, 1, 3, "all");       /* by their ids: 3, 5, and a free one */
    check_side_set(*state, 2, 1, "skin");
    check_side_set(*state, 3, 2, "lid");
    static const char *const tags[] = {"2:3", "2:5", "2:6"};
    static const char held[][6] = {"\1\1\1\1\0", "\1\1\0\1\0", "\1\1\1\1\0"};
    for (int i = 0; i < 3; i++) {
        uint8_t *nodes = converting_nodes_of(copy, tags[i]);
        assert_memory_equal(nodes, held[i], 5);
        free(nodes);
    }
    planish_file_close(copy);
    planish_file_close(file);
}

/** Give all node sets and side sets of the converted file, of which there is one each, number 7, and
 *  open it. */
static planish_file *open_with_one_number(const char *folder) {
    char path[TEST_PATH_SIZE];
    size_t size;
    netcdf_header header;
    io_model model;
    char *bytes = read_converted(folder, path, &size, &model, &header);
    bytes[netcdf_header_find(&header, "ns_prop1")->begin + 3] = 7;
    bytes[netcdf_header_find(&header, "ss_prop1")->begin + 3] = 7;
    netcdf_header_release(&header);
    test_write(folder, "number.e", bytes, size);
    free(bytes);
    return converting_open(test_path(path, folder, "number.e"));
}

/** Where a side set has the number of a node set, their names are not mixed up. */
static void sets_of_one_number_stay_apart(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n"
                     "*NSET, NSET=tip\n4\n*ELEMENT, TYPE=S3, ELSET=skin\n2,1,2,3\n");
    planish_file *file = converting_open_built(*state, "number.inp", &b);
    planish_file_close(to_exodus(*state, file, lost));
    planish_file *numbered = open_with_one_number(*state);
    planish_file *copy = to_exodus(*state, numbered, lost);
    assert_string_equal(lost, "parameters and comments");
    check_tag(file, copy, "tip");
    check_tag(file, copy, "skin");
    assert_int_equal(copy->model.n_groups, 2);
    planish_file_close(copy);
    planish_file_close(numbered);
    planish_file_close(file);
}

/** Facets of an entity in no group are in none that happens to have its number. */
static void entities_are_no_groups(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n2 3 \"skin\"\n"
                     "$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
                     "$Elements\n3\n1 4 2 1 1 1 2 3 4\n2 2 2 3 8 1 2 3\n3 2 2 0 3 1 2 4\n"
                     "$EndElements\n");
    planish_file *file = converting_open_built(*state, "skin.msh", &b);
    planish_file *copy = to_exodus(*state, file, lost);
    check_tag(file, copy, "skin");
    uint8_t *nodes = converting_nodes_of(copy, "2:4"); /* the other one, by the next number */
    assert_memory_equal(nodes, "\1\1\0\1", 4);
    free(nodes);
    planish_file_close(copy);
    planish_file_close(file);
}

/* ---- data ----------------------------------------------------------------------------------- */

/** Expect that an array of one component has these values. */
static void check_values(planish_file *file, const char *name, int64_t n, const double *values) {
    planish_data data;
    planish_error error = {.text = ""};
    if (planish_file_data(file, name, &data, &error))
        fail_msg("%s", error.text);
    assert_int_equal(data.n_components, 1);
    assert_int_equal(data.n, n);
    assert_memory_equal(data.values, values, (size_t)n * sizeof *values);
    planish_data_free(&data);
}

/** Each component is a variable; elements that change places take their values along. */
static void components_are_variables(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 7 double\n0 0 0 1 0 0 0 1 0 0 0 1 1 1 1 3 0 0 3 1 1\n"
                     "CELLS 5 25\n4 0 1 2 3\n5 0 1 4 2 3\n4 1 2 3 4\n4 1 2 3 5\n3 0 1 2\n"
                     "CELL_TYPES 5\n10 14 10 10 5\n");
    builder_text(&b, "POINT_DATA 7\nSCALARS heat double\nLOOKUP_TABLE default\n1 2 3 4 5 6 7\n"
                     "VECTORS flow float\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21\n");
    builder_text(&b, "CELL_DATA 5\nFIELD f 3\nregion 1 5 int\n5 5 4 5 0\nstress 6 5 double\n"
                     "1 2 3 4 5 6 11 12 13 14 15 16 21 22 23 24 25 26 31 32 33 34 35 36\n"
                     "0 0 0 0 0 0\nwide 5 5 double\n"
                     "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 0 0 0 0 0\n");
    planish_file *file = converting_open_built(*state, "data.vtk", &b);
    planish_file *copy = to_exodus(*state, file, lost);
    check_values(copy, "heat", 7, (const double[]){1, 2, 3, 4, 5, 6, 7});
    check_values(copy, "flow_y", 7, (const double[]){2, 5, 8, 11, 14, 17, 20});
    /* Tetrahedra of region 5 come before that of region 4, and before the pyramid. VTK's order of
     * components is xx yy zz xy yz xz. */
    check_values(copy, "stress_xx", 4, (const double[]){1, 31, 21, 11});
    check_values(copy, "stress_zx", 4, (const double[]){6, 36, 26, 16});
    check_values(copy, "stress_yz", 4, (const double[]){5, 35, 25, 15});
    check_values(copy, "wide_5", 4, (const double[]){5, 20, 15, 10});
    assert_non_null(strstr(lost, "data of elements of lower dimensions"));
    planish_file_close(copy);
    planish_file_close(file);
}

/* ---- netCDF --------------------------------------------------------------------------------- */

enum { N_VALUES = 5 };

static const double values[N_VALUES] = {1, -2.5, 3e300, 0, 7};

/** Put the values of the variables of write_netcdf. */
static void put_values(void *context, netcdf_out *out, const netcdf_out_variable *v) {
    (void)context;
    if (v->type == NETCDF_CHAR)
        netcdf_put_text(out, "a name that is cut off", N_VALUES);
    for (int i = 0; i < N_VALUES && v->type == NETCDF_INT; i++)
        netcdf_put_integer(out, -i);
    for (int i = 0; i < N_VALUES && v->type == NETCDF_DOUBLE; i++)
        netcdf_put_double(out, values[i]);
    for (int i = 0; i < N_VALUES && v->type == NETCDF_FLOAT; i++)
        netcdf_put_float(out, (float)i);
}

/** Write variables of all types; those of more than largest bytes are too large for CDF-2. */
static void write_netcdf(const char *path, int64_t largest) {
    static const netcdf_type types[] = {NETCDF_CHAR, NETCDF_INT, NETCDF_FLOAT, NETCDF_DOUBLE};
    netcdf_out out;
    pl_output output = {.fd = -1};
    planish_error error = {.text = ""};
    assert_int_equal(pl_output_open(path, (pl_temporaries){0}, &output, &error), 0);
    netcdf_out_begin(&out, &output, &error);
    out.largest = largest;
    out.n_records = 1;
    const int n = netcdf_out_dimension(&out, (netcdf_out_name){{"values"}, {0}}, N_VALUES);
    const int time = netcdf_out_dimension(&out, (netcdf_out_name){{"time"}, {0}}, 0);
    netcdf_out_text(&out, "title", "five!");
    netcdf_out_integer(&out, "whole", 3);
    netcdf_out_float(&out, "real", 0.5f);
    for (int k = 0; k < 4; k++) {
        netcdf_out_variable v = {.type = types[k], .n_dims = 1, .dim = {n}};
        v.attribute = k == 0 ? "unit" : NULL;
        v.text = "metre";
        v.name = (netcdf_out_name){{"v"}, {k + 1}};
        netcdf_out_variable_add(&out, &v);
    }
    netcdf_out_variable_add(
        &out, &(netcdf_out_variable){
                  .name = {{"steps"}, {0}}, .type = NETCDF_DOUBLE, .n_dims = 2, .dim = {time, n}});
    netcdf_out_write(&out, put_values, NULL);
    assert_int_equal(netcdf_out_end(&out), 0);
    assert_int_equal(pl_output_finish(&output, &error), 0);
    assert_int_equal(pl_output_commit(&output, (pl_temporaries){0}, &error), 0);
    pl_output_release(&output, (pl_temporaries){0});
}

/** Headers and values are read again, in CDF-2 and in CDF-5. */
static void netcdf_files_are_written(void **state) {
    for (int is_wide = 0; is_wide < 2; is_wide++) {
        char path[TEST_PATH_SIZE];
        size_t size;
        netcdf_header header;
        planish_error error = {.text = ""};
        write_netcdf(test_path(path, *state, "out.nc"), is_wide ? 39 : 40);
        char *bytes = test_read(path, &size);
        const io_model model = {.input = {.path = path, .data = bytes, .size = (int64_t)size}};
        assert_int_equal(bytes[3], is_wide ? 5 : 2);
        if (netcdf_header_read(&model, &header, &error))
            fail_msg("%s", error.text);
        assert_int_equal(header.n_records, 1);
        assert_int_equal(netcdf_header_dimension(&header, "values"), N_VALUES);
        const netcdf_variable *v = netcdf_header_find(&header, "v1");
        const io_slice unit = netcdf_header_text_attribute(&header, v, "unit");
        assert_true(unit.begin && strncmp(unit.begin, "metre", 5) == 0);
        assert_memory_equal(bytes + v->begin, "a nam\0\0\0", 8);
        v = netcdf_header_find(&header, "v2");
        assert_memory_equal(bytes + v->begin + 4, "\377\377\377\377", 4);
        v = netcdf_header_find(&header, "v3");
        assert_memory_equal(bytes + v->begin + 8, "\100\0\0\0", 4);
        v = netcdf_header_find(&header, "steps");
        assert_true(v->is_record && v->n == N_VALUES && v->begin + 8 * N_VALUES == (int64_t)size);
        assert_memory_equal(bytes + v->begin + 8, "\300\4\0\0\0\0\0\0", 8);
        netcdf_header_release(&header);
        free(bytes);
    }
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(exodus_files_are_converted_to_themselves),
        IN_A_FOLDER(sets_and_numbers_stay),
        IN_A_FOLDER(faces_of_solids_are_sides),
        IN_A_FOLDER(edges_of_flat_elements_are_sides),
        IN_A_FOLDER(facets_keep_their_middles),
        IN_A_FOLDER(groups_name_blocks),
        IN_A_FOLDER(names_of_blocks_are_distinct),
        IN_A_FOLDER(names_are_sets),
        IN_A_FOLDER(sets_of_one_number_stay_apart),
        IN_A_FOLDER(entities_are_no_groups),
        IN_A_FOLDER(components_are_variables),
        IN_A_FOLDER(netcdf_files_are_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
