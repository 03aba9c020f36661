/* XDMF files: what is read and refused, wherever their numbers stand, and what is written. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/folder_files.h"
#include "support/hdf5_builder.h"
#include "support/reading.h"
#include "support/unit_elements.h"

#include "io/core/binary.h"
#include "io/file/file.h"
#include "io/xdmf/xdmf_markup.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define XDMF(content)                                                                              \
    "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n"                            \
    "<Xdmf Version=\"3.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><Domain>\n" content        \
    "</Domain></Xdmf>\n"
#define GRID(content) "<Grid Name=\"mesh\" GridType=\"Uniform\">" content "</Grid>\n"
#define WHOLE(dimensions, text)                                                                    \
    "<DataItem NumberType=\"Int\" Dimensions=\"" dimensions "\">" text "</DataItem>"
#define REAL(dimensions, text)                                                                     \
    "<DataItem Precision=\"8\" Dimensions=\"" dimensions "\">" text "</DataItem>"
#define TOPOLOGY(type, n, dimensions, text)                                                        \
    "<Topology TopologyType=\"" type "\" NumberOfElements=\"" n                                    \
    "\">" WHOLE(dimensions, text) "</Topology>"
#define GEOMETRY(content) "<Geometry GeometryType=\"XYZ\">" content "</Geometry>"
#define FIVE              "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 1 1"
#define TWO               TOPOLOGY("Tetrahedron", "2", "2 4", "0 1 2 3  1 2 3 4")
#define POINTS            GEOMETRY(REAL("5 3", FIVE))
#define INCLUDE(path)     "<xi:include xpointer=\"xpointer(" path ")\"/>"

static void fails(const char *text, const char *word) {
    reading_fails(&io_format_xdmf, text, word);
}

static planish_file *reads(const char *text) {
    return reading_text(&io_format_xdmf, text);
}

/** Read text, and expect so many nodes and elements. */
static void gives(const char *text, int64_t n_nodes, int64_t n_elements) {
    planish_file *file = reads(text);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.n_nodes, n_nodes);
    assert_int_equal(mesh.n_elements, n_elements);
    planish_file_close(file);
}

/* ---- elements ------------------------------------------------------------------------------- */

static const struct {
    const char *name, *other_name;
    int code, n_nodes, type;
} types[] = {{"Triangle", "Tri", 4, 3, PLANISH_CELL_TRIANGLE},
             {"Quadrilateral", "quadrilateral", 5, 4, PLANISH_CELL_QUADRILATERAL},
             {"Tetrahedron", "TETRAHEDRON", 6, 4, PLANISH_CELL_TETRAHEDRON},
             {"Pyramid", "pyramid", 7, 5, PLANISH_CELL_PYRAMID},
             {"Wedge", "WEDGE", 8, 6, PLANISH_CELL_WEDGE},
             {"Hexahedron", "hexahedron", 9, 8, PLANISH_CELL_HEXAHEDRON},
             {"Quadrilateral_9", "Quad_9", 35, 9, PLANISH_CELL_QUADRILATERAL9},
             {"Triangle_6", "Tri_6", 36, 6, PLANISH_CELL_TRIANGLE6},
             {"Quadrilateral_8", "Quad_8", 37, 8, PLANISH_CELL_QUADRILATERAL8},
             {"Tetrahedron_10", "Tet_10", 38, 10, PLANISH_CELL_TETRAHEDRON10},
             {"Pyramid_13", "PYRAMID_13", 39, 13, PLANISH_CELL_PYRAMID13},
             {"Wedge_15", "WEDGE_15", 40, 15, PLANISH_CELL_WEDGE15},
             {"Wedge_18", "WEDGE_18", 41, 18, PLANISH_CELL_WEDGE18},
             {"Hexahedron_20", "Hex_20", 48, 20, PLANISH_CELL_HEXAHEDRON20},
             {"Hexahedron_27", "HEX_27", 50, 27, PLANISH_CELL_HEXAHEDRON27}};
enum { N_TYPES = sizeof types / sizeof *types, TEXT_SIZE = 4096 };

/** Expect the one element of a file to have that type and the nodes in this order. */
static void expect_element(const char *text, int type, int n_nodes) {
    planish_file *file = reads(text);
    planish_cells cells;
    assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
    assert_int_equal(cells.n, 1);
    assert_int_equal(cells.type[0], type);
    for (int i = 0; i < n_nodes; i++)
        assert_int_equal(cells.node[i], i);
    planish_file_close(file);
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    for (int i = 0; i < N_TYPES; i++) {
        const int n = types[i].n_nodes;
        char nodes[256] = "", points[1024] = "", text[TEXT_SIZE];
        for (int k = 0; k < n; k++) {
            snprintf(nodes + strlen(nodes), sizeof nodes - strlen(nodes), "%d ", k);
            snprintf(
                points + strlen(points), sizeof points - strlen(points), "%d %d %d ", k, k * k,
                types[i].type < PLANISH_CELL_TETRAHEDRON || n == 9 || n == 6 || n == 8 ? 0 : k % 3);
        }
        for (int form = 0; form < 3; form++) {
            char topology[1024];
            if (form < 2)
                snprintf(topology, sizeof topology,
                         "<Topology %s=\"%s\" Dimensions=\"1\">" WHOLE("1 %d", "%s") "</Topology>",
                         form ? "Type" : "TopologyType", form ? types[i].other_name : types[i].name,
                         n, nodes);
            else
                snprintf(topology, sizeof topology,
                         "<Topology TopologyType=\"Mixed\" NumberOfElements=\"1\">" WHOLE(
                             "%d", "%d %s") "</Topology>",
                         n + 1, types[i].code, nodes);
            snprintf(text, sizeof text, XDMF(GRID("%s" GEOMETRY(REAL("%d 3", "%s")))), topology, n,
                     points);
            expect_element(text, types[i].type, n);
        }
    }
}

static void elements_of_several_types_stand_in_one_list(void **state) {
    (void)state;
    planish_file *file = reads(XDMF(
        GRID(TOPOLOGY("Mixed", "7", "45",
                      "6 0 1 2 3  1 1 0  2 2 0 1  3 3 1 2 3  16 4 3 0 2 1 3 0 1 3 3 1 2 3 3 2 0 3  "
                      "6 1 2 3 4  2 3 0 1 2") POINTS)));
    planish_file_info info;
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    assert_int_equal(file->model.line.n, 1);
    assert_int_equal(file->model.triangle.n, 1);
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_other_elements, 1);
    planish_file_close(file);
    gives(XDMF(GRID(TOPOLOGY("Mixed", "10", "10", "6 0 1 2 3 6 1 2 3 4") POINTS)), 5, 2);
    fails(XDMF(GRID(TOPOLOGY("Mixed", "2", "5", "6 0 1 2 3") POINTS)), "2 elements should be");
    fails(XDMF(GRID(TOPOLOGY("Mixed", "1", "5", "99 0 1 2 3") POINTS)), "element 0");
    fails(XDMF(GRID(TOPOLOGY("Mixed", "1", "4", "6 0 1 2") POINTS)), "nodes are not all there");
    fails(XDMF(GRID(TOPOLOGY("Mixed", "1", "4", "16 1 9 0") POINTS)), "nodes are not all there");
    fails(XDMF(GRID(TOPOLOGY("Mixed", "1", "3", "3 -1 0") POINTS)), "nodes are not all there");
}

static void numbers_of_nodes_may_have_a_base(void **state) {
    (void)state;
    gives(XDMF(GRID("<Topology Type=\"Tetrahedron\" BaseOffset=\"1\">" WHOLE(
              "2 4", "1 2 3 4 2 3 4 5") "</Topology>" POINTS)),
          5, 2);
    fails(XDMF(GRID("<Topology Type=\"Tetrahedron\" BaseOffset=\"1\">" WHOLE(
              "2 4", "0 2 3 4 2 3 4 5") "</Topology>" POINTS)),
          "not among the points");
    /* Of a polyhedron faces and nodes are counted, which have no base. */
    planish_file *file = reads(XDMF(GRID("<Topology Type=\"Mixed\" BaseOffset=\"1\">" WHOLE(
        "28", "6 1 2 3 4  16 4 3 1 3 2 3 1 2 4 3 2 3 4 3 3 1 4  6 2 3 4 5") "</Topology>" POINTS)));
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    assert_int_equal(info.n_other_elements, 1);
    planish_file_close(file);
}

/* ---- points --------------------------------------------------------------------------------- */

/** Write a file that was read from memory with node moved by 1/8 in x: text, to be freed. */
static char *move_node(planish_file *file, int node, const char *folder, const char *name) {
    char path[TEST_PATH_SIZE];
    const int dim = planish_file_mesh(file).dim;
    planish_error error = {.text = ""};
    planish_file_coordinates(file)[node * dim] += 0.125;
    if (planish_file_write(file, test_path(path, folder, name), planish_file_coordinates(file),
                           &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
    return test_read(path, NULL);
}

static void only_digits_of_text_change(void **state) {
    static const char *const forms[][2] = {
        {XDMF(GRID(TWO POINTS)),
         XDMF(GRID(TWO GEOMETRY(REAL("5 3", "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1.125 1 1"))))},
        {XDMF(GRID(TWO "<Geometry Type=\"x_y_z\">" REAL("5", "0 1 0 0 1") REAL("5", "0 0 1 0 1")
                       REAL("5", "0 0 0 1 1") "</Geometry>")),
         XDMF(GRID(TWO "<Geometry Type=\"x_y_z\">" REAL("5", "0 1 0 0 1.125") REAL("5", "0 0 1 0 1")
                       REAL("5", "0 0 0 1 1") "</Geometry>"))},
        {XDMF(GRID(TOPOLOGY("Triangle", "2", "6", "0 1 2 1 4 2") "<Geometry Type=\"XY\">" REAL(
             "5 2", "0 0 1 0 0 1 9 9 1 1") "</Geometry>")),
         XDMF(GRID(TOPOLOGY("Triangle", "2", "6", "0 1 2 1 4 2") "<Geometry Type=\"XY\">" REAL(
             "5 2", "0 0 1 0 0 1 9 9 1.125 1") "</Geometry>"))},
        {XDMF(GRID(TOPOLOGY("Triangle", "2", "6", "0 1 2 1 4 2") "<Geometry Type=\"X_Y\">" REAL(
             "5", "0 1 0 9 1") REAL("5", "0 0 1 9 1") "</Geometry>")),
         XDMF(GRID(TOPOLOGY("Triangle", "2", "6", "0 1 2 1 4 2") "<Geometry Type=\"X_Y\">" REAL(
             "5", "0 1 0 9 1.125") REAL("5", "0 0 1 9 1") "</Geometry>"))}};
    for (size_t i = 0; i < sizeof forms / sizeof *forms; i++) {
        planish_file *file = reads(forms[i][0]);
        char *written = move_node(file, 4, *state, "out.xdmf");
        assert_string_equal(written, forms[i][1]);
        free(written);
        planish_file_close(file);
    }
}

static void points_have_the_precision_that_is_said(void **state) {
    (void)state;
    planish_file_info info;
    planish_file *file =
        reads(XDMF(GRID(TWO GEOMETRY("<DataItem Dimensions=\"5 3\">" FIVE "</DataItem>"))));
    planish_file_get_info(file, &info);
    assert_int_equal(info.precision, PLANISH_PRECISION_FLOAT);
    planish_file_close(file);
    file = reads(XDMF(GRID(TWO POINTS)));
    planish_file_get_info(file, &info);
    assert_int_equal(info.precision, PLANISH_PRECISION_DOUBLE);
    planish_file_close(file);
}

/* ---- references and grids ------------------------------------------------------------------- */

#define STEP(content)                                                                              \
    "<Grid Name=\"f\" GridType=\"Uniform\">" content "<Time Value=\"1\"/></Grid>\n"
#define SERIES(content)                                                                            \
    "<Grid Name=\"f\" GridType=\"Collection\" CollectionType=\"Temporal\">\n" content "</Grid>\n"
#define SPATIAL(content)                                                                           \
    "<Grid Name=\"f\" GridType=\"Collection\" CollectionType=\"Spatial\">\n" content "</Grid>\n"
#define BOTH                                                                                       \
    INCLUDE("/Xdmf/Domain/Grid[@GridType='Uniform'][1]/*[self::Topology or self::Geometry]")

static void references_are_followed(void **state) {
    (void)state;
    gives(XDMF("<DataItem Name=\"a\" Dimensions=\"5 3\">" FIVE "</DataItem>" GRID(
              TWO GEOMETRY("<DataItem Reference=\"XML\">/Xdmf/Domain/DataItem[@Name=\"a\"]"
                           "</DataItem>"))),
          5, 2);
    gives(XDMF("<DataItem Name=\"a\" Dimensions=\"5 3\">" FIVE "</DataItem>" GRID(
              TWO GEOMETRY("<DataItem Reference=\"/Xdmf/Domain/DataItem[1]\"/>"))),
          5, 2);
    gives(XDMF(GRID(TWO POINTS) SERIES(STEP(BOTH) STEP(BOTH) STEP(INCLUDE(
              "//Grid[@Name=&quot;mesh&quot;]/Topology") "<xi:include "
                                                         "xpointer=\"element(/1/1/1/2)\"/>"))),
          5, 2);
    fails(XDMF(GRID(TWO GEOMETRY("<DataItem Reference=\"/Xdmf/Nothing\"/>"))),
          "something that does not exist");
    fails(XDMF("<DataItem Name=\"a\" Reference=\"/Xdmf/Domain/DataItem\"/>" GRID(
              TWO GEOMETRY("<DataItem Reference=\"/Xdmf/Domain/DataItem\"/>"))),
          "refers to itself");
    fails(XDMF(GRID(TWO GEOMETRY("<DataItem Reference=\"/Xdmf/Domain[last()]\"/>"))),
          "is not understood");
    fails(XDMF(GRID("<xi:include href=\"other.xmf\"/>" POINTS)), "another XML file is included");
    fails(XDMF(GRID(INCLUDE("/Xdmf/None") POINTS)), "includes something that does not exist");
}

/** A path that is not understood is refused each time. */
static void wrong_paths_stay_wrong(void **state) {
    (void)state;
    planish_file *file = reads(XDMF("<DataItem Name=\"a\" Dimensions=\"2\">1 2</DataItem>" GRID(
        TWO POINTS "<Attribute Name=\"a\" Center=\"Cell\"><DataItem "
                   "Reference=\"/Xdmf/Domain/DataItem)\"/></Attribute>")));
    assert_int_equal(file->model.n_data, 0);
    assert_int_equal(file->n_regions, 1);
    planish_file_close(file);
}

/** Paths stop at the position that they name; those that look at too many elements are refused. */
static void paths_look_at_few_elements(void **state) {
    enum { N = 1000 };
    static const char item[] = "<a/>", begin[] = "<Xdmf><b Reference=\"/Xdmf/a[2]\"/>"
                                                 "<b Reference=\"/Xdmf/a[self::a][self::a][3]\"/>";
    char text[sizeof begin + N * (sizeof item - 1) + sizeof "</Xdmf>"];
    planish_error error = {.text = ""};
    xdmf_document d;
    int64_t found;
    (void)state;
    strcpy(text, begin);
    for (int i = 0; i < N; i++)
        strcat(text, item);
    strcat(text, "</Xdmf>");
    const io_model model = {.input = {.path = "test", .data = text, .size = (int64_t)strlen(text)}};
    if (xdmf_markup_read(&model, &d, &error))
        fail_msg("%s", error.text);
    assert_int_equal(xdmf_resolve(&d, 1, &found), 0);
    assert_int_equal(found, 4);
    assert_true(d.n_looked_at < 10);
    assert_int_equal(xdmf_resolve(&d, 2, &found), 0);
    assert_int_equal(found, 5);
    assert_true(d.n_looked_at > 3 * N);
    d.n_looked_at = INT64_C(1) << 28;
    assert_int_equal(xdmf_resolve(&d, 1, &found), PLANISH_ERROR_FORMAT);
    assert_non_null(strstr(error.text, "too many elements"));
    xdmf_markup_release(&d);
}

static void steps_must_have_one_mesh(void **state) {
    (void)state;
    fails(XDMF(SERIES(STEP(TWO POINTS) STEP(TWO POINTS))), "points or elements of its own");
    fails(XDMF(SERIES(STEP(TWO POINTS) STEP(TWO INCLUDE("/Xdmf/Domain/Grid/Grid/Geometry")))),
          "points or elements of its own");
    gives(XDMF(SERIES(STEP(TWO POINTS))), 5, 2);
}

static void grids_side_by_side_are_pieces(void **state) {
    const char *text = XDMF(SPATIAL(GRID(TWO POINTS) GRID(TOPOLOGY(
        "Tetrahedron", "1", "4", "0 1 2 3") GEOMETRY(REAL("4 3", "5 5 5 6 5 5 5 6 5 5 5 6")))));
    planish_file *file = reads(text);
    planish_cells cells;
    assert_int_equal(planish_file_mesh(file).n_nodes, 9);
    assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
    assert_int_equal(cells.n, 3);
    assert_int_equal(cells.node[8], 5);
    assert_int_equal(planish_file_element_number(file, 2), 2);
    char *written = move_node(file, 8, *state, "out.xdmf"), *at = strstr(written, "5.125 5 6");
    assert_non_null(at);
    assert_int_equal(strlen(written), strlen(text) + 4);
    free(written);
    planish_file_close(file);
    /* Points that pieces share are there once. */
    gives(XDMF(GRID(TOPOLOGY("Tetrahedron", "1", "4", "0 1 2 3") POINTS) GRID(
              TOPOLOGY("Tetrahedron", "1", "4", "1 2 3 4") INCLUDE("/Xdmf/Domain/Grid/Geometry"))),
          5, 2);
    fails(XDMF(SPATIAL(GRID(TWO POINTS) GRID(
              TOPOLOGY("Triangle", "1", "3", "0 1 2") "<Geometry Type=\"XY\">" REAL(
                  "3 2", "0 0 1 0 0 1") "</Geometry>"))),
          "two coordinates and some three");
}

/** DOLFINx lists the cells that have tags once more, in any order, and facets. */
static void grids_of_tags_give_values(void **state) {
    (void)state;
    planish_file *file = reads(XDMF(
        GRID(TWO POINTS) GRID(TOPOLOGY("Tetrahedron", "2", "8", "4 1 3 2 3 2 1 0") INCLUDE(
            "/Xdmf/Domain/Grid/Geometry") "<Attribute Name=\"cell_tags\" "
                                          "Center=\"Cell\">" WHOLE("2", "7 8") "</Attribute>")
            GRID(TOPOLOGY("Triangle", "1", "3", "0 1 2") INCLUDE(
                "/Xdmf/Domain/Grid/Geometry") "<Attribute Name=\"facet_tags\" "
                                              "Center=\"Cell\">" WHOLE("1", "9") "</Attribute>")));
    planish_data data;
    const char *tag = "9";
    uint8_t reason[5];
    const planish_hold hold = {.tags = &tag, .n_tags = 1};
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    assert_int_equal(file->n_regions, 2);
    assert_int_equal(planish_file_data(file, "cell_tags", &data, NULL), 0);
    assert_true(data.of_elements && data.n == 2 && data.values[0] == 8 && data.values[1] == 7);
    planish_data_free(&data);
    assert_int_equal(planish_file_get_held(file, &hold, reason, NULL), 0);
    assert_true(reason[1] & PLANISH_FILE_FIX);
    assert_false(reason[4] & PLANISH_FILE_FIX);
    planish_file_close(file);
}

/** Elements that are listed once more are looked at as all others are. */
static void wrong_nodes_of_tags_are_refused(void **state) {
    (void)state;
    fails(XDMF(GRID(TOPOLOGY("Triangle_6", "1", "6", "0 1 2 3 4 5") "<Geometry Type=\"XY\">" REAL(
              "6 2", "0 0 2 0 0 2 1 0 1 1 0 1") "</Geometry>")
                   GRID(TOPOLOGY("Triangle_6", "1", "6", "0 1 2 3 4 2000000000") INCLUDE(
                       "/Xdmf/Domain/Grid/Geometry") "<Set Name=\"a\" "
                                                     "SetType=\"Cell\">" WHOLE("1", "0") "</Set>")),
          "not among the points");
}

/* ---- data and sets -------------------------------------------------------------------------- */

#define ATTRIBUTE(name, more, content)                                                             \
    "<Attribute Name=\"" name "\" " more ">" content "</Attribute>"

static void attributes_are_data(void **state) {
    (void)state;
    planish_file *file = reads(
        XDMF(GRID(TWO POINTS ATTRIBUTE("region", "Center=\"Cell\"", WHOLE("2", "4 5"))
                      ATTRIBUTE("fixed", "Center=\"Node\"", WHOLE("5", "0 0 0 0 1"))
                          ATTRIBUTE("v", "AttributeType=\"Vector\"",
                                    REAL("5 3", "1 2 3 4 5 6 7 8 9 10 11 12 13 14 15.5"))
                              ATTRIBUTE("t", "AttributeType=\"Tensor6\" Center=\"Cell\"",
                                        REAL("2 6", "1 2 3 4 5 6 1 2 3 4 5 6"))
                                  ATTRIBUTE("short", "Center=\"Node\"", REAL("2", "1 2"))
                                      ATTRIBUTE("whole", "Center=\"Grid\"", REAL("1", "1")))));
    planish_data data;
    planish_error error;
    uint8_t reason[5];
    static const double tensor[] = {1, 2, 4, 3, 5, 6};
    assert_int_equal(file->n_regions, 2);
    assert_string_equal(planish_file_region_arrays(file)[0], "region");
    assert_int_equal(planish_file_get_held(file, NULL, reason, NULL), 0);
    assert_true(reason[4] & PLANISH_FILE_REQUIRED);
    assert_false(reason[0] & PLANISH_FILE_REQUIRED);
    assert_int_equal(planish_file_data(file, "v", &data, NULL), 0);
    assert_true(!data.of_elements && data.n == 5 && data.n_components == 3);
    assert_true(data.values[14] == 15.5);
    planish_data_free(&data);
    assert_int_equal(planish_file_data(file, "t", &data, NULL), 0);
    assert_true(data.of_elements && data.n == 2 && data.n_components == 6);
    assert_memory_equal(data.values + 6, tensor, sizeof tensor);
    planish_data_free(&data);
    assert_int_not_equal(planish_file_data(file, "short", &data, &error), 0);
    assert_int_not_equal(planish_file_data(file, "whole", &data, &error), 0);
    planish_file_close(file);
    fails(XDMF(GRID(TWO POINTS ATTRIBUTE("region", "Center=\"Cell\"", WHOLE("2", "4 x")))),
          "number expected");
}

#define SET(name, type, items) "<Set Name=\"" name "\" SetType=\"" type "\">" items "</Set>"
#define SETS                                                                                       \
    SET("ends", "Node", WHOLE("2", "0 4"))                                                         \
    SET("second", "Cell", WHOLE("1", "1"))                                                         \
    SET("face", "Face", WHOLE("2", "0 1") WHOLE("2", "3 1"))                                       \
    SET("edge", "Edge", WHOLE("1", "9"))

/** Check that the groups of SETS hold their nodes, and no others. */
static void expect_groups(const planish_file *file) {
    static const struct {
        const char *name;
        int nodes; /* bits */
    } sets[] = {{"ends", 17}, {"second", 30}, {"face", 7 | 28}};
    for (size_t i = 0; i < sizeof sets / sizeof *sets; i++) {
        uint8_t reason[5];
        const planish_hold hold = {.tags = &sets[i].name, .n_tags = 1};
        planish_error error;
        if (planish_file_get_held(file, &hold, reason, &error))
            fail_msg("%s", error.text);
        for (int k = 0; k < 5; k++)
            assert_int_equal((reason[k] & PLANISH_FILE_FIX) != 0, sets[i].nodes >> k & 1);
    }
}

static void sets_are_groups_of_nodes(void **state) {
    static const char *const none[] = {NULL};
    (void)state;
    planish_file *file = reads(XDMF(GRID(TWO POINTS SETS)));
    expect_groups(file);
    planish_file_close(file);
    /* Arrays of regions make other groups, and leave these. */
    file = reads(XDMF(GRID(TWO POINTS SETS "<Attribute Name=\"region\" Center=\"Cell\">" WHOLE(
        "2", "4 5") "</Attribute>")));
    expect_groups(file);
    assert_int_equal(planish_file_choose_regions(file, none, 0, NULL), 0);
    expect_groups(file);
    planish_file_close(file);
    fails(XDMF(GRID(TWO POINTS SET("a", "Node", WHOLE("1", "5")))), "is not in 0 .. 4");
    fails(XDMF(GRID(TWO POINTS SET("a", "Face", WHOLE("1", "0") WHOLE("1", "4")))),
          "has no face 4");
}

/** Sets of faces have their mids and middles, too. */
static void faces_have_all_their_nodes(void **state) {
    (void)state;
    const int type = PLANISH_CELL_HEXAHEDRON27;
    const char *const name = "S";
    const planish_hold hold = {.tags = &name, .n_tags = 1};
    double x[UNIT_NODES][3];
    uint8_t reason[UNIT_NODES];
    file_builder text = {0};
    const int n = unit_places(type,
                              "0 1 2 3 4 5 6 7 01 12 23 30 45 56 67 74 04 15 26 37 0374 1265 0154 "
                              "2376 0123 4567 01234567",
                              x);
    builder_text(&text, "%s",
                 "<Xdmf Version=\"3.0\"><Domain><Grid>"
                 "<Topology TopologyType=\"Hexahedron_27\" NumberOfElements=\"1\">"
                 "<DataItem NumberType=\"Int\" Dimensions=\"1 27\">");
    for (int i = 0; i < n; i++)
        builder_text(&text, " %d", i);
    builder_text(&text, "%s",
                 "</DataItem></Topology><Geometry>"
                 "<DataItem Precision=\"8\" Dimensions=\"27 3\">");
    for (int i = 0; i < n; i++)
        builder_text(&text, " %.17g %.17g %.17g", x[i][0], x[i][1], x[i][2]);
    builder_text(&text, "%s",
                 "</DataItem></Geometry>" SET(
                     "S", "Face", WHOLE("1", "0") WHOLE("1", "1")) "</Grid></Domain></Xdmf>\n");
    builder_text(&text, "%c", 0);
    planish_file *file = reads(text.data);
    assert_int_equal(planish_file_get_held(file, &hold, reason, NULL), 0);
    for (int i = 0; i < n; i++) /* of the face 1 2 6 5 */
        assert_int_equal((reason[i] & PLANISH_FILE_FIX) != 0,
                         "011001100100010001100100000"[i] == '1');
    planish_file_close(file);
    builder_release(&text);
}

/* ---- files beside --------------------------------------------------------------------------- */

/** Expect a failure of writing to name, with word in its text, that leaves n files. */
static void writing_fails(planish_file *file, const char *folder, const char *name,
                          const char *word, int n) {
    char path[TEST_PATH_SIZE];
    planish_error error = {.text = ""};
    test_path(path, folder, name);
    assert_int_not_equal(planish_file_check_output(file, path, &error), 0);
    assert_int_not_equal(planish_file_write(file, path, planish_file_coordinates(file),
                                            &(planish_write_options){.threads = 1}, &error),
                         0);
    if (!strstr(error.text, word))
        fail_msg("'%s' was expected in: %s", word, error.text);
    assert_int_equal(test_count_files(folder), n);
}

static const double five[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};

#define BYTES(name)                                                                                \
    GEOMETRY("<DataItem Format=\"Binary\" Precision=\"8\" Seek=\"4\" Dimensions=\"5 3\">\n " name  \
             " </DataItem>")

/** Write mesh.xdmf, whose points are in a file of bytes, and cells in another one. */
static void write_mesh(const char *folder) {
    char bytes[4 + sizeof five] = "head";
    const int32_t cells[] = {0, 1, 2, 3, 1, 2, 3, 4};
    memcpy(bytes + 4, five, sizeof five);
    test_write(folder, "mesh.bin", bytes, sizeof bytes);
    test_write(folder, "cells.bin", (const char *)cells, sizeof cells);
    folder_write(
        folder, "mesh.xdmf",
        XDMF(GRID("<Topology Type=\"Tetrahedron\"><DataItem Format=\"Binary\" "
                  "NumberType=\"Int\" Dimensions=\"2 4\">cells.bin</DataItem></Topology>" BYTES(
                      "mesh.bin"))));
}

/** Expect that the file has the points with the last one moved as move_node does. */
static void expect_moved(const char *folder, const char *name) {
    char path[TEST_PATH_SIZE];
    size_t size;
    double points[15];
    char *bytes = test_read(test_path(path, folder, name), &size);
    assert_int_equal(size, 4 + sizeof points);
    memcpy(points, bytes + 4, sizeof points);
    assert_true(points[12] == 1.125);
    points[12] = 1;
    assert_memory_equal(points, five, sizeof points);
    assert_memory_equal(bytes, "head", 4);
    free(bytes);
}

static void expect_same(const char *folder, const char *a, const char *b) {
    char path[TEST_PATH_SIZE];
    size_t n, m;
    char *x = test_read(test_path(path, folder, a), &n);
    char *y = test_read(test_path(path, folder, b), &m);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, n);
    free(x);
    free(y);
}

static void a_file_beside_is_written(void **state) {
    char path[TEST_PATH_SIZE];
    const char *folder = *state;
    write_mesh(folder);
    /* In the same folder the name is exchanged, where the XML has it and nowhere else. */
    planish_file *file = folder_open(folder, "mesh.xdmf");
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    free(move_node(file, 4, folder, "out.xdmf"));
    expect_moved(folder, "out.bin");
    assert_int_equal(test_count_files(folder), 5);
    char *xml = test_read(test_path(path, folder, "out.xdmf"), NULL);
    assert_non_null(strstr(xml, "\n out.bin "));
    assert_non_null(strstr(xml, ">cells.bin<"));
    assert_null(strstr(xml, "mesh.bin"));
    free(xml);
    planish_file_close(file);
    /* Once more: OUT names the file that is there. */
    file = folder_open(folder, "mesh.xdmf");
    free(move_node(file, 4, folder, "out.xdmf"));
    planish_file_close(file);
    /* In another folder all files keep their names. */
    test_folder_in(path, folder, "new");
    file = folder_open(folder, "mesh.xdmf");
    free(move_node(file, 4, folder, "new/other.xdmf"));
    planish_file_close(file);
    expect_moved(folder, "new/mesh.bin");
    expect_same(folder, "cells.bin", "new/cells.bin");
    expect_same(folder, "mesh.xdmf", "new/other.xdmf");
    file = folder_open(folder, "new/other.xdmf");
    planish_file_close(file);
    /* In place the XML stays. */
    file = folder_open(folder, "mesh.xdmf");
    free(move_node(file, 4, folder, "mesh.xdmf"));
    planish_file_close(file);
    expect_moved(folder, "mesh.bin");
    expect_same(folder, "mesh.xdmf", "new/other.xdmf");
    assert_int_equal(test_count_files(folder), 6);
}

static void other_files_are_not_overwritten(void **state) {
    char path[TEST_PATH_SIZE];
    const char *folder = *state;
    write_mesh(folder);
    folder_write(folder, "out.bin", "precious");
    planish_file *file = folder_open(folder, "mesh.xdmf");
    writing_fails(file, folder, "out.xdmf", "out.bin: exists", 4);
    writing_fails(file, folder, "cells.xdmf", "cells.bin: is a file of the input", 4);
    static const char *const names[] = {"a&b.xdmf",  "a|b.xdmf",   " a.xdmf",
                                        "a\nb.xdmf", "a\xFF.xdmf", "a\xC3.xdmf"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        writing_fails(file, folder, names[i], "cannot stand in the XML", 4);
    writing_fails(file, folder, "out.vtu", "does not have an extension", 4);
    test_folder_in(path, folder, "new");
    folder_write(folder, "new/cells.bin", "precious");
    writing_fails(file, folder, "new/out.xdmf", "cells.bin: exists", 5);
    assert_int_equal(test_count_files(path), 1);
    planish_error error;
    assert_int_not_equal(planish_file_write(file, "/dev/null", planish_file_coordinates(file),
                                            &(planish_write_options){.threads = 1}, &error),
                         0);
    assert_non_null(strstr(error.text, "cannot be written to a pipe"));
    planish_file_close(file);
    /* A file that names "notout.bin" does not name out.bin. */
    folder_write(folder, "out.xdmf", "<a>notout.bin</a><b>out.bin2</b>");
    file = folder_open(folder, "mesh.xdmf");
    writing_fails(file, folder, "out.xdmf", "out.bin: exists", 6);
    planish_file_close(file);
    folder_write(folder, "out.xdmf", "out.bin");
    file = folder_open(folder, "mesh.xdmf");
    free(move_node(file, 4, folder, "out.xdmf"));
    planish_file_close(file);
    /* Where the name does not begin as that of the XML does, OUT must be in another folder. */
    test_write(folder, "points.bin", "head", 4);
    char *bytes = test_read(test_path(path, folder, "mesh.bin"), NULL);
    test_write(folder, "points.bin", bytes, 4 + sizeof five);
    free(bytes);
    folder_write(folder, "mesh.xdmf", XDMF(GRID(TWO BYTES("points.bin"))));
    file = folder_open(folder, "mesh.xdmf");
    writing_fails(file, folder, "out.xdmf", "give an OUT in another folder", 7);
    planish_file_close(file);
}

/** A name is the same with backslashes, repeated slashes and "./". */
static void one_file_may_have_several_spellings(void **state) {
    char path[TEST_PATH_SIZE];
    const char *folder = *state;
    write_mesh(folder);
    test_folder_in(path, folder, "sub");
    test_folder_in(path, folder, "new");
    test_folder_in(path, folder, "new/sub");
    char *bytes = test_read(test_path(path, folder, "mesh.bin"), NULL);
    test_write(folder, "sub/mesh.bin", bytes, 4 + sizeof five);
    free(bytes);
    folder_write(
        folder, "mesh.xdmf",
        XDMF("<DataItem Format=\"Binary\" Dimensions=\"1\">./sub//./mesh.bin</DataItem>" GRID(
            TWO BYTES("sub\\mesh.bin"))));
    planish_file *file = folder_open(folder, "mesh.xdmf");
    free(move_node(file, 4, folder, "new/mesh.xdmf"));
    expect_moved(folder, "new/sub/mesh.bin");
    planish_file_close(file);
    file = folder_open(folder, "mesh.xdmf");
    free(move_node(file, 4, folder, "out.xdmf"));
    planish_file_close(file);
    expect_moved(folder, "sub/out.bin");
    char *xml = test_read(test_path(path, folder, "out.xdmf"), NULL);
    assert_non_null(strstr(xml, ">./sub/out.bin<"));
    assert_null(strstr(xml, "mesh.bin"));
    free(xml);
}

/** OUT and a file that it names must have two names. */
static void out_is_none_of_the_files_that_it_names(void **state) {
    char path[TEST_PATH_SIZE];
    const char *folder = *state;
    write_mesh(folder);
    char *bytes = test_read(test_path(path, folder, "mesh.bin"), NULL);
    test_write(folder, "points.xdmf", bytes, 4 + sizeof five);
    free(bytes);
    folder_write(folder, "mesh.xdmf", XDMF(GRID(TWO BYTES("points.xdmf"))));
    test_folder_in(path, folder, "new");
    planish_file *file = folder_open(folder, "mesh.xdmf");
    writing_fails(file, folder, "new/points.xdmf", "is also the name of a file", 5);
    assert_int_equal(test_count_files(path), 0);
    planish_file_close(file);
}

/** The name of a file may hold any bytes, where the XML is not read by Expat. */
static void names_with_zeros_are_no_names(void **state) {
    enum { PIECE = 1 << 16, ZEROS = 5000 };
    static const char begin[] = "<Xdmf><Domain>" GRID(TWO POINTS),
                      item[] = "<DataItem Format=\"HDF\">",
                      end[] = "a.h5:/x</DataItem></Domain></Xdmf>";
    const size_t n_begin = sizeof begin - 1, n_item = sizeof item - 1;
    char *text = malloc(PIECE + ZEROS + sizeof end);
    assert_non_null(text);
    memset(text, ' ', PIECE);
    memcpy(text, begin, n_begin);
    memcpy(text + PIECE - n_item, item, n_item);
    memset(text + PIECE, 0, ZEROS);
    text[PIECE] = 'x';
    memcpy(text + PIECE + ZEROS, end, sizeof end);
    test_write(*state, "mesh.xdmf", text, PIECE + ZEROS + sizeof end - 1);
    free(text);
    planish_file *file = folder_open(*state, "mesh.xdmf");
    assert_int_equal(file->model.n_beside, 0);
    planish_file_close(file);
}

static void bytes_are_read_as_they_are_said_to_be(void **state) {
    static const char *const orders[] = {"Little", "Big"};
    const char *folder = *state;
    for (int is_big = 0; is_big < 2; is_big++)
        for (int is_float = 0; is_float < 2; is_float++) {
            char text[TEXT_SIZE], bytes[sizeof five];
            const int size = is_float ? 4 : 8;
            for (int i = 0; i < 15; i++) {
                const float single = (float)five[i];
                char *at = bytes + i * size;
                if (is_float)
                    memcpy(at, &single, sizeof single);
                else
                    memcpy(at, &five[i], sizeof five[i]);
                for (int k = 0; k < size / 2 && is_big == io_machine_is_little(); k++) {
                    const char byte = at[k];
                    at[k] = at[size - 1 - k];
                    at[size - 1 - k] = byte;
                }
            }
            test_write(folder, "mesh.bin", bytes, (size_t)(15 * size));
            snprintf(text, sizeof text,
                     XDMF(GRID(TWO GEOMETRY("<DataItem Format=\"binary\" Endian=\"%s\" "
                                            "Precision=\"%d\" Dimensions=\"5 3\">mesh.bin"
                                            "</DataItem>"))),
                     orders[is_big], size);
            folder_write(folder, "mesh.xmf", text);
            planish_file *file = folder_open(folder, "mesh.xmf");
            assert_true(planish_file_coordinates(file)[12] == 1);
            free(move_node(file, 4, folder, "mesh.xmf"));
            planish_file_close(file);
            file = folder_open(folder, "mesh.xmf");
            assert_true(planish_file_coordinates(file)[12] == 1.125);
            assert_true(planish_file_coordinates(file)[3] == 1);
            planish_file_close(file);
        }
    folder_write(folder, "mesh.xmf",
                 XDMF(GRID(TWO GEOMETRY("<DataItem Format=\"Binary\" Seek=\"80\" Precision=\"8\" "
                                        "Dimensions=\"5 3\">mesh.bin</DataItem>"))));
    folder_open_fails(folder, "mesh.xmf", "Dimensions or Seek are wrong");
}

static void names_must_not_lead_outside(void **state) {
    char path[TEST_PATH_SIZE], link[TEST_PATH_SIZE];
    const char *folder = *state;
    static const char *const names[] = {"../mesh.bin", "/etc/passwd",  "link.bin",
                                        "sub/../../x", "..\\mesh.bin", "../in/mesh.bin"};
    test_folder_in(path, folder, "in");
    write_mesh(folder);
    assert_int_equal(symlink("../mesh.bin", test_path(link, folder, "in/link.bin")), 0);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char text[TEXT_SIZE];
        snprintf(text, sizeof text, XDMF(GRID(TWO BYTES("%s"))), names[i]);
        folder_write(folder, "in/mesh.xdmf", text);
        folder_open_fails(folder, "in/mesh.xdmf",
                          strstr(names[i], "..") ? "has '..' in it"
                                                 : "is not beside this file or below its folder");
    }
    /* What is named is copied beside OUT, too. */
    static const char *const hidden[] = {".mesh.bin", "./.mesh.bin", ".sub/mesh.bin", "sub\\.bin"};
    for (size_t i = 0; i < sizeof hidden / sizeof *hidden; i++) {
        char text[TEXT_SIZE];
        snprintf(text, sizeof text, XDMF(GRID(TWO BYTES("%s"))), hidden[i]);
        folder_write(folder, "in/mesh.xdmf", text);
        folder_open_fails(folder, "in/mesh.xdmf", "is a hidden file");
    }
    folder_write(folder, "in/mesh.xdmf", XDMF(GRID(TWO BYTES("none.bin"))));
    folder_open_fails(folder, "in/mesh.xdmf", "No such file");
    fails("<!DOCTYPE Xdmf [<!ENTITY a SYSTEM \"/etc/passwd\">]>\n<Xdmf>&a;</Xdmf>", "an entity");
    fails("<!DOCTYPE Xdmf SYSTEM \"a.dtd\">\n<Xdmf a=\"&b;\"><Domain/></Xdmf>", "");
}

/* ---- HDF5 ----------------------------------------------------------------------------------- */

#define HDF(type, dimensions, name)                                                                \
    "<DataItem Format=\"HDF\" NumberType=\"" type "\" Precision=\"8\" Dimensions=\"" dimensions    \
    "\">" name "</DataItem>"
#define HDF_MESH                                                                                   \
    XDMF(GRID("<Topology TopologyType=\"Tetrahedron\">" HDF(                                       \
        "Int", "2 4",                                                                              \
        "mesh.h5:/cells") "</Topology>" GEOMETRY(HDF("Float", "5 3", "./mesh.h5:points"))          \
                  ATTRIBUTE("region", "Center=\"Cell\"", HDF("Int", "2", "mesh.h5:/region"))))

#ifdef PL_HDF5

static void write_hdf5(const char *folder, int is_packed) {
    const int cells[] = {0, 1, 2, 3, 1, 2, 3, 4}, region[] = {4, 5};
    hdf5_builder b;
    hdf5_begin(&b, 0);
    b.is_packed = is_packed;
    b.chunk[0] = is_packed ? 2 : 0;
    b.chunk[1] = 3;
    hdf5_array(&b, "/points", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 5, 3, five);
    b.is_packed = 0;
    b.chunk[0] = b.chunk[1] = 0;
    hdf5_array(&b, "/cells", H5T_STD_I64LE, H5T_NATIVE_INT, 2, 4, cells);
    hdf5_integers(&b, "/region", 2, region);
    file_builder f = hdf5_end(&b);
    test_write(folder, "mesh.h5", f.data, (size_t)f.size);
    builder_release(&f);
    folder_write(folder, "mesh.xdmf", HDF_MESH);
}

static void files_of_hdf5_are_read_and_written(void **state) {
    char path[TEST_PATH_SIZE];
    const char *folder = *state;
    for (int i = 0; i < 2 * HDF5_SUPERBLOCKS; i++) {
        hdf5_superblock = hdf5_superblocks[i / 2];
        write_hdf5(folder, i % 2);
        planish_file *file = folder_open(folder, "mesh.xdmf");
        planish_data data;
        assert_int_equal(file->n_regions, 2);
        assert_int_equal(planish_file_data(file, "region", &data, NULL), 0);
        assert_true(data.values[1] == 5);
        planish_data_free(&data);
        free(move_node(file, 4, folder, "out.xdmf"));
        planish_file_close(file);
        char *xml = test_read(test_path(path, folder, "out.xdmf"), NULL);
        assert_non_null(strstr(xml, "./out.h5:points"));
        assert_null(strstr(xml, "mesh.h5"));
        free(xml);
        file = folder_open(folder, "out.xdmf");
        assert_true(planish_file_coordinates(file)[12] == 1.125);
        assert_true(planish_file_coordinates(file)[13] == 1);
        planish_file_close(file);
        assert_int_equal(test_count_files(folder), 4);
    }
    hdf5_superblock = 0;
}

static void pieces_stand_in_one_file_of_hdf5(void **state) {
    const double more[12] = {5, 5, 5, 6, 5, 5, 5, 6, 5, 5, 5, 6};
    const char *folder = *state;
    for (int is_packed = 0; is_packed < 2; is_packed++) {
        hdf5_builder b;
        hdf5_begin(&b, 0);
        b.is_packed = is_packed;
        b.chunk[0] = is_packed ? 2 : 0;
        b.chunk[1] = 3;
        hdf5_array(&b, "/b", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 4, 3, more);
        hdf5_array(&b, "/a", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 5, 3, five);
        file_builder f = hdf5_end(&b);
        test_write(folder, "mesh.h5", f.data, (size_t)f.size);
        builder_release(&f);
        folder_write(folder, "mesh.xdmf",
                     XDMF(SPATIAL(GRID(TWO GEOMETRY(HDF("Float", "5 3", "mesh.h5:/a")))
                                      GRID(TOPOLOGY("Tetrahedron", "1", "4", "0 1 2 3")
                                               GEOMETRY(HDF("Float", "4 3", "mesh.h5:/b"))))));
        planish_file *file = folder_open(folder, "mesh.xdmf");
        assert_int_equal(planish_file_mesh(file).n_nodes, 9);
        assert_true(planish_file_coordinates(file)[15] == 5);
        planish_file_coordinates(file)[12] = 1.5;
        free(move_node(file, 8, folder, "mesh.xdmf"));
        planish_file_close(file);
        file = folder_open(folder, "mesh.xdmf");
        assert_true(planish_file_coordinates(file)[12] == 1.5);
        assert_true(planish_file_coordinates(file)[24] == 5.125);
        assert_true(planish_file_coordinates(file)[0] == 0);
        planish_file_close(file);
    }
}

static void wrong_files_of_hdf5_are_refused(void **state) {
    const char *folder = *state;
    write_hdf5(folder, 0);
    folder_write(folder, "a.xdmf",
                 XDMF(GRID(TWO GEOMETRY(HDF("Float", "6 3", "mesh.h5:/points")))));
    folder_open_fails(folder, "a.xdmf", "Dimensions say 18 values, and there are 15");
    folder_write(folder, "a.xdmf", XDMF(GRID(TWO GEOMETRY(HDF("Float", "5 3", "mesh.h5:/none")))));
    folder_open_fails(folder, "a.xdmf", "/none: there is no such array");
    folder_write(folder, "a.xdmf", XDMF(GRID(TWO GEOMETRY(HDF("Float", "5 3", "a.xdmf:/points")))));
    folder_open_fails(folder, "a.xdmf", "not an HDF5 file");
    folder_write(folder, "a.xdmf",
                 XDMF(GRID(TWO GEOMETRY(HDF("Float", "5 3", "mesh.h5:/points|0 0:1 1:5 3")))));
    folder_open_fails(folder, "a.xdmf", "a part of an array");
    folder_write(folder, "a.xdmf", XDMF(GRID(TWO GEOMETRY(HDF("Float", "5 3", "points")))));
    folder_open_fails(folder, "a.xdmf", "as in mesh.h5:/nodes");
}

/** Points have one name, however it is spelled, and each value is of one axis. */
static void arrays_of_hdf5_are_told_apart(void **state) {
    const char *folder = *state;
    for (int is_packed = 0; is_packed < 2; is_packed++) {
        write_hdf5(folder, is_packed);
        folder_write(folder, "a.xdmf",
                     XDMF(SPATIAL(GRID(TWO GEOMETRY(HDF("Float", "5 3", "mesh.h5:/points"))) GRID(
                         TOPOLOGY("Tetrahedron", "1", "4", "0 1 2 3")
                             GEOMETRY(HDF("Float", "5 3", ".//mesh.h5://points"))))));
        planish_file *file = folder_open(folder, "a.xdmf");
        assert_int_equal(planish_file_mesh(file).n_nodes, 5);
        planish_file_close(file);
        folder_write(
            folder, "a.xdmf",
            XDMF(GRID(TOPOLOGY("Triangle", "1", "3", "0 1 2") "<Geometry Type=\"X_Y\">" HDF(
                "Float", "5 3", "mesh.h5:/points")
                          HDF("Float", "5 3", "mesh.h5:points") "</Geometry>")));
        folder_open_fails(folder, "a.xdmf", "coordinates twice");
    }
}

/** A file beside may be another one when data are asked for. */
static void changed_cells_are_noticed(void **state) {
    const int cells[] = {0, 1, 2, 3}, region[] = {4};
    const char *folder = *state;
    planish_data data;
    planish_error error = {.text = ""};
    write_hdf5(folder, 0);
    folder_write(folder, "mesh.xdmf",
                 XDMF(GRID("<Topology TopologyType=\"Tetrahedron\"><DataItem Format=\"HDF\">"
                           "mesh.h5:/cells</DataItem></Topology>" POINTS ATTRIBUTE(
                               "region", "Center=\"Cell\"",
                               "<DataItem Format=\"HDF\">mesh.h5:/region</DataItem>"))));
    planish_file *file = folder_open(folder, "mesh.xdmf");
    assert_int_equal(planish_file_data(file, "region", &data, NULL), 0);
    planish_data_free(&data);
    hdf5_builder b;
    hdf5_begin(&b, 0);
    hdf5_array(&b, "/cells", H5T_STD_I64LE, H5T_NATIVE_INT, 1, 4, cells);
    hdf5_integers(&b, "/region", 1, region);
    file_builder f = hdf5_end(&b);
    test_write(folder, "mesh.h5", f.data, (size_t)f.size);
    builder_release(&f);
    assert_int_not_equal(planish_file_data(file, "region", &data, &error), 0);
    assert_non_null(strstr(error.text, "was changed"));
    planish_file_close(file);
}

#else

static void the_library_is_asked_for(void **state) {
    test_write(*state, "mesh.h5", "anything", 8);
    folder_write(*state, "mesh.xdmf", HDF_MESH);
    folder_open_fails(*state, "mesh.xdmf", "built without HDF5");
}

#endif

/* ---- damage --------------------------------------------------------------------------------- */

static void damaged_files_are_refused(void **state) {
    static const char *const cases[][2] = {
        {"<Xdmf/>", "there is no Grid"},
        {"<VTK/>", "Xdmf expected"},
        {XDMF(""), "there is no Grid"},
        {XDMF(GRID(TWO)), "a Topology and a Geometry"},
        {XDMF(GRID(POINTS)), "a Topology and a Geometry"},
        {XDMF(GRID(TWO POINTS POINTS)), "more than one Geometry"},
        {XDMF("<Grid GridType=\"Subset\"/>"), "GridType Subset"},
        {XDMF(GRID(TWO POINTS) "</Domain><Domain>" GRID(TWO POINTS)), "more than one"},
        {XDMF(GRID("<Topology Type=\"3DSMesh\" Dimensions=\"2 2 2\"/>" POINTS)), "structured"},
        {XDMF(GRID("<Topology Type=\"Blob\"/>" POINTS)), "not known"},
        {XDMF(GRID("<Topology>" WHOLE("4", "0 1 2 3") "</Topology>" POINTS)), "no TopologyType"},
        {XDMF(GRID("<Topology Type=\"Tetrahedron\"/>" POINTS)), "there is no DataItem"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "3", "2 4", "0 1 2 3 1 2 3 4") POINTS)), "3 elements"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "x", "2 4", "0 1 2 3 1 2 3 4") POINTS)),
         "not a whole number"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "2", "9", "0 1 2 3 1 2 3 4 5") POINTS)), "9 numbers"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "2", "2 4", "0 1 2 3 1 2 3 x") POINTS)),
         "number expected"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "2", "2 4", "0 1 2 3 1 2 3 5") POINTS)), "points"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "2", "2 4", "0 1 2 3 1 2 3 4 4") POINTS)), "more than"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "2", "", "0 1 2 3 1 2 3 4") POINTS)), "no Dimensions"},
        {XDMF(GRID("<Topology Type=\"Tetrahedron\" NodesPerElement=\"8\">" WHOLE(
             "8", "0 1 2 3 1 2 3 4") "</Topology>" POINTS)),
         "as NodesPerElement says"},
        {XDMF(GRID(TOPOLOGY("Tetrahedron", "2", "2 -4", "0 1") POINTS)), "not whole numbers"},
        {XDMF(GRID(TWO GEOMETRY(REAL("99999999 3", FIVE)))), "cannot be where they should"},
        {XDMF(GRID(TWO GEOMETRY(REAL("9223372036854775807 9", FIVE)))), "not whole numbers"},
        {XDMF(GRID(TWO GEOMETRY(REAL("7 2", "0 0 0 1 0 0 0 1 0 0 0 1 1 1")))),
         "do not make points"},
        {XDMF(GRID(TWO GEOMETRY(REAL("5 3", "0 0 0 1 0 0 0 1 0 0 0 1 1 1 nan")))), "not finite"},
        {XDMF(GRID(TWO GEOMETRY(REAL("5 3", "0 0 0 1 0 0 <!-- a -->0 1 0 0 0 1 1 1 1")))),
         "markup"},
        {XDMF(GRID(TWO GEOMETRY(REAL("5 3", "<!-- a -->" FIVE)))), "markup"},
        {XDMF("<DataItem Dimensions=\"3\">0 1 2</DataItem>" GRID(TOPOLOGY(
             "Triangle", "1", "3", "0 1 2") "<Geometry Type=\"X_Y\"><DataItem "
                                            "Reference=\"/Xdmf/Domain/DataItem\"/><DataItem "
                                            "Reference=\"/Xdmf/Domain/DataItem\"/></Geometry>")),
         "coordinates twice"},
        {XDMF(GRID(TWO GEOMETRY(REAL("5 3", FIVE) REAL("5 3", FIVE)))), "1 DataItem"},
        {XDMF(GRID(TWO GEOMETRY("<DataItem ItemType=\"HyperSlab\"/>"))), "HyperSlab is not read"},
        {XDMF(GRID(TWO GEOMETRY("<DataItem Format=\"TIFF\">a</DataItem>"))), "Format TIFF"},
        {XDMF(GRID(TWO GEOMETRY("<DataItem NumberType=\"Complex\">1</DataItem>"))), "Complex"},
        {XDMF(GRID(TWO GEOMETRY("<DataItem>1 2 3</DataItem>"))), "no Dimensions"},
        {XDMF(GRID(TWO "<Geometry Type=\"ORIGIN_DXDYDZ\"/>")), "ORIGIN_DXDYDZ is not read"},
        {XDMF(GRID(TWO "<Geometry Type=\"X_Y_Z\">" REAL("5 3", FIVE) "</Geometry>")), "3 DataItem"},
        {"<Xdmf><Domain>", "XML"}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        fails(cases[i][0], cases[i][1]);
}

static void every_beginning_is_a_mesh_or_an_error(void **state) {
    const char *text =
        XDMF(GRID(TWO POINTS ATTRIBUTE("region", "Center=\"Cell\"", WHOLE("2", "4 5")))
                 SERIES(STEP(BOTH) STEP(BOTH)));
    (void)state;
    reading_every_beginning(&io_format_xdmf, text, (int64_t)strlen(text));
}

#define IN_FOLDER(test)                                                                            \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(elements_of_several_types_stand_in_one_list),
        cmocka_unit_test(numbers_of_nodes_may_have_a_base),
        IN_FOLDER(only_digits_of_text_change),
        cmocka_unit_test(points_have_the_precision_that_is_said),
        cmocka_unit_test(references_are_followed),
        cmocka_unit_test(wrong_paths_stay_wrong),
        cmocka_unit_test(paths_look_at_few_elements),
        cmocka_unit_test(steps_must_have_one_mesh),
        IN_FOLDER(grids_side_by_side_are_pieces),
        cmocka_unit_test(grids_of_tags_give_values),
        cmocka_unit_test(wrong_nodes_of_tags_are_refused),
        cmocka_unit_test(attributes_are_data),
        cmocka_unit_test(sets_are_groups_of_nodes),
        cmocka_unit_test(faces_have_all_their_nodes),
        IN_FOLDER(a_file_beside_is_written),
        IN_FOLDER(other_files_are_not_overwritten),
        IN_FOLDER(one_file_may_have_several_spellings),
        IN_FOLDER(out_is_none_of_the_files_that_it_names),
        IN_FOLDER(names_with_zeros_are_no_names),
        IN_FOLDER(bytes_are_read_as_they_are_said_to_be),
        IN_FOLDER(names_must_not_lead_outside),
#ifdef PL_HDF5
        IN_FOLDER(files_of_hdf5_are_read_and_written),
        IN_FOLDER(pieces_stand_in_one_file_of_hdf5),
        IN_FOLDER(arrays_of_hdf5_are_told_apart),
        IN_FOLDER(changed_cells_are_noticed),
        IN_FOLDER(wrong_files_of_hdf5_are_refused),
#else
        IN_FOLDER(the_library_is_asked_for),
#endif
        cmocka_unit_test(damaged_files_are_refused),
        cmocka_unit_test(every_beginning_is_a_mesh_or_an_error),
    };
    if (!reading_knows_vtu())
        return 0; /* planish was built without Expat */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
