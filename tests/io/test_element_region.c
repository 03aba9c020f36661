/* The region of an element as a tag: what it is called in every kind of format, and that the tag
 * means the element again. */
#include "support/data_files.h"
#include "support/files.h"
#include "support/reading.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { TAG_SIZE = 64 };

/** Fails the test unless the elements' tags are those of expected, each with a '|' behind it. */
static void check(const io_format *format, const char *text, const char *expected) {
    planish_file *file = reading_text(format, text);
    char all[256] = "";
    for (int64_t i = 0; i < planish_file_mesh(file).n_elements; i++) {
        char tag[TAG_SIZE] = "not filled";
        const int length = planish_file_element_region(file, i, tag, sizeof tag);
        assert_int_equal(length, (int)strlen(tag));
        strcat(strcat(all, tag), "|");
    }
    assert_string_equal(all, expected);
    planish_file_close(file);
}

/* Tetrahedra of: a named group; a name that triangles have, too; a group without a name; a name
 * that reads as a number; no group. Entity 7 is without a group, too, but group 7 has its number.
 */
static const char gmsh[] =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n4\n3 1 \"left\"\n3 2 \"both\"\n2 9 \"both\"\n3 4 \"12\"\n$EndPhysicalNames\n"
    "$Nodes\n4\n1 0 0 0\n2 0 0 1\n3 1 0 0\n4 0 1 0\n$EndNodes\n"
    "$Elements\n8\n1 2 2 9 5 1 2 3\n2 4 2 1 6 1 2 3 4\n3 4 2 2 17 1 2 3 4\n4 4 2 3 8 1 2 3 4\n"
    "5 4 2 4 9 1 2 3 4\n6 4 2 0 20 1 2 3 4\n7 4 2 7 10 1 2 3 4\n8 4 2 0 7 1 2 3 4\n$EndElements\n";

static void groups_of_gmsh(void **state) {
    (void)state;
    static const char one[] = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
                              "$Nodes\n4\n1 0 0 0\n2 0 0 1\n3 1 0 0\n4 0 1 0\n$EndNodes\n"
                              "$Elements\n1\n1 4 2 %s 1 2 3 4\n$EndElements\n";
    static const char *const tags[][2] = {
        {"0 20", "3:20|"}, {"3 20", "3:3|"}, {"7 7", "3:7|"}, {"0 -2", "3:-2|"}};
    for (size_t i = 0; i < sizeof tags / sizeof *tags; i++) {
        char text[512];
        snprintf(text, sizeof text, one, tags[i][0]);
        check(&io_format_gmsh, text, tags[i][1]);
    }
    check(&io_format_gmsh, gmsh, "left|3:2|3:3|3:4|3:20|3:7||");
}

static void references_of_medit(void **state) {
    (void)state;
    check(&io_format_medit,
          "MeshVersionFormatted 2 Dimension 3 Vertices 5 0 0 0 3 1 0 0 1 0 1 0 2 0 0 1 2 1 1 1.5 3 "
          "Tetrahedra 2 1 2 3 4 7 2 3 4 5 0 Triangles 1 1 2 3 4 End",
          "3:7|3:0|");
    check(&io_format_medit,
          "MeshVersionFormatted 2 Dimension 2 Vertices 4 0 0 0 1 0 0 1 1 0 0 1 0 "
          "Triangles 2 1 2 3 1 1 3 4 6 Edges 1 1 2 9 End",
          "2:1|2:6|");
}

#define PAIR                                                                                       \
    "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n*ELEMENT,TYPE=C3D4\n1,1,2,3,4\n2,2,3,4,"  \
    "5\n"

/** Their numbers are none of the file's: an element of no set has none. */
static void sets_of_abaqus(void **state) {
    (void)state;
    check(&io_format_abaqus, PAIR, "||");
    check(&io_format_abaqus, PAIR "*ELSET,ELSET=B\n2\n", "|B|");
    check(&io_format_abaqus, PAIR "*ELSET,ELSET=3\n1\n*ELSET,ELSET=\"b 1\"\n2,1\n", "3|b 1|");
    check(&io_format_abaqus, PAIR "*NSET,NSET=N\n1,2,3,4\n", "||");
}

static void materials_of_netgen(void **state) {
    (void)state;
    check(&io_format_netgen,
          "mesh3d\ndimension\n2\ngeomtype\n0\n\nsurfaceelements\n2\n 2 1 0 0 3 1 2 3\n 2 2 0 0 0 1 "
          "3 4\nvolumeelements\n0\n\n\nedgesegmentsgi2\n1\n 6 0 1 2 0 0 1 0 9 0 1 0.2\n"
          "points\n4\n0 0 0\n1 0 0\n1 1 0\n0 1 0\nmaterials\n1\n2 air\nendmesh\n",
          "2:1|air|");
}

#define VTK_OF_TWO                                                                                 \
    "# vtk DataFile Version 3.0\nof two\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"      \
    "0 0 0 1 0 0 0 1 0 0 0 1 0 0 -1\nCELLS 2 10\n4 0 1 2 3 4 0 2 1 4\nCELL_TYPES 2\n10 10\n"

static void regions_of_vtk(void **state) {
    (void)state;
    check(&io_format_vtk, VTK_OF_TWO, "||");
    check(&io_format_vtk, VTK_OF_TWO "CELL_DATA 2\nFIELD data 1\nregion 1 2 int\n-1 5\n",
          "3:-1|3:5|");
}

/** Every element's tag names a group that has the element. */
static void check_round_trip(const char *name, const char *path) {
    char tag[TAG_SIZE];
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open(path, NULL, 1, &file, &error))
        fail_msg("%s: %s", name, error.text);
    const planish_mesh mesh = planish_file_mesh(file);
    double *least = calloc((size_t)mesh.n_elements, sizeof *least);
    uint8_t *constraint = malloc((size_t)mesh.n_nodes);
    for (int64_t i = 0; i < mesh.n_elements; i += 1 + mesh.n_elements / 40) {
        const char *const tags = tag;
        const double one = 1;
        assert_true(planish_file_element_region(file, i, tag, sizeof tag) > 0);
        if (planish_file_min_volumes(file, &tags, &one, 1, least, &error))
            fail_msg("%s: %s", name, error.text);
        assert_true(least[i] == 1);
        const planish_hold hold = {.tags = &tags, .n_tags = 1, .ignore_regions = 1};
        assert_int_equal(planish_file_constraints(file, &hold, constraint, &error), 0);
        for (int k = 0; k <= mesh.dim; k++)
            assert_int_equal(constraint[mesh.elements[i * (mesh.dim + 1) + k]],
                             PLANISH_CONSTRAINT_FIXED);
    }
    free(constraint);
    free(least);
    planish_file_close(file);
}

static void tags_mean_the_element(void **state) {
    (void)state;
    char path[TEST_PATH_SIZE];
    for (const test_data_file *data = test_data_files; data->name; data++)
        if (data->has_regions && test_data_path(path, data))
            check_round_trip(data->name, path);
}

static void arguments_are_checked(void **state) {
    (void)state;
    char tag[TAG_SIZE];
    planish_file *file = reading_text(&io_format_gmsh, gmsh);
    assert_int_equal(planish_file_element_region(NULL, 0, tag, sizeof tag), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_element_region(file, -1, tag, 9), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_element_region(file, 7, tag, 9), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_element_region(file, 0, NULL, 9), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_element_region(file, 0, tag, 0), 4);
    assert_int_equal(planish_file_element_region(file, 0, NULL, 0), 4);
    assert_int_equal(planish_file_element_region(file, 0, tag, 3), 4); /* cut short */
    assert_string_equal(tag, "le");
    planish_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(groups_of_gmsh),        cmocka_unit_test(references_of_medit),
        cmocka_unit_test(sets_of_abaqus),        cmocka_unit_test(materials_of_netgen),
        cmocka_unit_test(regions_of_vtk),        cmocka_unit_test(tags_mean_the_element),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
