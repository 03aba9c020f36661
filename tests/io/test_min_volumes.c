/* Minimum volumes by group: which elements get which, in every format that has regions. */
#include "support/files.h"
#include "support/reading.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST_TAGS = 4, MOST_ELEMENTS = 8 };

/* Two tetrahedra of the references 7 and 8; 3 and 4 are references of other things. */
static const char solid[] = "MeshVersionFormatted 2 Dimension 3 Vertices 5 0 0 0 3 1 0 0 1 0 1 0 2 "
                            "0 0 1 2 1 1 1.5 3 Tetrahedra 2 1 2 3 4 7 2 3 4 5 8 "
                            "Triangles 1 1 2 3 4 End";

/* Three tetrahedra around an edge, copies of the second in two physical groups (as Gmsh writes an
 * element of several groups); the first and the surface have the number 1 in different dimensions.
 */
static const char groups[] =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    "$PhysicalNames\n4\n3 1 \"left\"\n3 2 \"a=b\"\n2 1 \"skin\"\n2 9 \"left\"\n$EndPhysicalNames\n"
    "$Nodes\n5\n1 0 0 0\n2 0 0 1\n3 1 0 0\n4 0 1 0\n5 -1 -1 0\n$EndNodes\n"
    "$Elements\n5\n1 2 2 1 5 1 2 3\n2 4 2 1 6 1 2 3 4\n3 4 2 1 7 1 2 4 5\n4 4 2 2 7 1 2 4 5\n"
    "5 4 2 2 8 1 2 5 3\n$EndElements\n";

/** "TAG=V TAG=V ...", V one digit, as the lists of planish_file_min_volumes. */
static int fill(const planish_file *file, const char *wishes, double *min_volume,
                planish_error *error) {
    char text[64];
    const char *tags[MOST_TAGS];
    double values[MOST_TAGS];
    int n = 0;
    snprintf(text, sizeof text, "%s", wishes);
    for (char *word = strtok(text, " "); word; word = strtok(NULL, " ")) {
        char *end = strrchr(word, '=');
        *end = '\0';
        values[n] = strtod(end + 1, NULL);
        tags[n] = word;
        n++;
    }
    return planish_file_min_volumes(file, tags, values, n, min_volume, error);
}

/** Fails the test unless the elements get the volumes that expected says, a digit for each. */
static void check(const planish_file *file, const char *wishes, const char *expected) {
    double min_volume[MOST_ELEMENTS];
    planish_error error = {.text = ""};
    for (int i = 0; i < MOST_ELEMENTS; i++)
        min_volume[i] = -1;
    if (fill(file, wishes, min_volume, &error))
        fail_msg("%s: %s", wishes, error.text);
    const int64_t n = planish_file_mesh(file).n_elements;
    assert_int_equal((int64_t)strlen(expected), n);
    for (int64_t i = 0; i < n; i++)
        if (min_volume[i] != expected[i] - '0')
            fail_msg("%s: element %d gets %g instead of %c", wishes, (int)i, min_volume[i],
                     expected[i]);
    assert_true(min_volume[n] == -1);
}

/** Fails the test unless the wishes are refused with part in the text and not without. */
static void refuse(const planish_file *file, const char *wishes, const char *part,
                   const char *without) {
    double min_volume[MOST_ELEMENTS] = {-1};
    planish_error error = {.text = ""};
    assert_int_equal(fill(file, wishes, min_volume, &error), PLANISH_ERROR_ARGUMENT);
    if (!strstr(error.text, part) || (without && strstr(error.text, without)))
        fail_msg("'%s' should be in, and not '%s': %s", part, without ? without : "", error.text);
    assert_true(min_volume[0] == -1);
}

static void references_of_medit(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_medit, solid);
    check(file, "", "00");
    check(file, "8=3", "03");
    check(file, "3:7=2 8=5", "25");
    check(file, "7=2 7=4 3:7=3", "40"); /* the largest, in any order */
    refuse(file, "3=1", "'3' of solid elements", NULL);
    refuse(file, "0:3=1", "3:7, 3:8", "0:3,");
    refuse(file, "4=1", "3:7, 3:8", "2:4");
    refuse(file, "2:4=1", "3:7, 3:8", NULL);
    refuse(file, "7=1 9=1", "'9'", NULL);
    planish_file_close(file);
}

static void triangles_of_the_plane(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_medit, "MeshVersionFormatted 2 Dimension 2 Vertices 4 0 0 0 1 0 0 "
                                       "1 1 0 0 1 0 Triangles 2 1 2 3 1 1 3 4 6 Edges 1 1 2 9 End");
    check(file, "6=2", "02");
    check(file, "2:1=7", "70");
    refuse(file, "9=1", "'9' of triangles or quadrilaterals", "1:9");
    refuse(file, "3:6=1", "2:1, 2:6", NULL);
    planish_file_close(file);
}

static void groups_of_gmsh(void **state) {
    (void)state;
    planish_file *file = reading_text(&io_format_gmsh, groups);
    assert_int_equal(planish_file_mesh(file).n_elements, 3);
    check(file, "left=2", "220");
    check(file, "left=2 a=b=3", "233"); /* the second is in both */
    check(file, "left=4 2=3", "443");
    check(file, "1=1", "110");       /* physical groups first */
    check(file, "8=6 3:6=5", "506"); /* else elementary entities */
    refuse(file, "skin=1", "left, a=b", "skin,");
    refuse(file, "9=1", "'9' of solid elements", NULL);
    refuse(file, "2:1=1", "'2:1' of solid elements", NULL);
    planish_file_close(file);
}

/** How many elements get the volume. */
static int64_t count(const planish_file *file, const char *tag, double value) {
    const int64_t n = planish_file_mesh(file).n_elements;
    double *min_volume = calloc((size_t)n, sizeof *min_volume);
    planish_error error = {.text = ""};
    if (planish_file_min_volumes(file, &tag, &value, 1, min_volume, &error))
        fail_msg("%s: %s", tag, error.text);
    int64_t found = 0;
    for (int64_t i = 0; i < n; i++)
        found += min_volume[i] == value;
    free(min_volume);
    return found;
}

/** The cube of two parts: the same elements by name as by number. */
static void parts_of_the_cube(void **state) {
    (void)state;
    static const char *const names[] = {"ascii22.msh", "binary22.msh", "ascii41.msh",
                                        "binary41.msh"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char path[TEST_PATH_SIZE];
        planish_file *file = NULL;
        planish_error error;
        assert_int_equal(planish_file_open(test_path_from(path, "PLANISH_TEST_DATA", names[i]),
                                           NULL, 1, &file, &error),
                         0);
        const int64_t lower = count(file, "lower part", 0.5), upper = count(file, "3:2", 1e-300);
        assert_true(lower > 0 && upper > 0);
        assert_int_equal(lower + upper, planish_file_mesh(file).n_elements);
        planish_file_close(file);
    }
}

static void regions_of_tetgen(void **state) {
    char path[TEST_PATH_SIZE];
    static const char nodes[] = "5 3 0 1\n0 0 0 0 1\n1 1 0 0 2\n2 0 1 0 2\n3 0 0 1 2\n4 1 1 2 -3\n";
    static const char elements[] = "2 4 1\n0 0 1 2 3 -7\n1 1 2 3 4 8\n";
    test_write(*state, "a.node", nodes, strlen(nodes));
    test_write(*state, "a.ele", elements, strlen(elements));
    planish_file *file = NULL;
    assert_int_equal(planish_file_open(test_path(path, *state, "a.node"), NULL, 1, &file, NULL), 0);
    check(file, "-7=3 3:8=1", "31");
    refuse(file, "-3=1", "3:-7, 3:8", "0:-3");
    planish_file_close(file);
}

#define VTK_OF_TWO                                                                                 \
    "# vtk DataFile Version 3.0\nof two\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n"      \
    "0 0 0 1 0 0 0 1 0 0 0 1 0 0 -1\nCELLS 2 10\n4 0 1 2 3 4 0 2 1 4\nCELL_TYPES 2\n10 10\n"

static void files_without_regions(void **state) {
    (void)state;
    static const char *const text[] = {VTK_OF_TWO, VTK_OF_TWO "CELL_DATA 2\nSCALARS region double\n"
                                                              "LOOKUP_TABLE default\n1.5 2\n"};
    for (int i = 0; i < 2; i++) {
        planish_file *file = reading_text(&io_format_vtk, text[i]);
        refuse(file, "1=1", "the file has: none", NULL);
        planish_file_close(file);
    }
}

/** The array whose name tells most, wherever it stands. */
static void regions_of_vtk(void **state) {
    (void)state;
    planish_file *file =
        reading_text(&io_format_vtk, VTK_OF_TWO "CELL_DATA 2\nFIELD data 3\nmaterial 1 2 int\n9 9\n"
                                                "region 1 2 double\n-1 5\nBlockId 1 2 int\n1 2\n");
    check(file, "-1=3 3:5=1", "31");
    refuse(file, "9=1", "3:-1, 3:5", NULL);
    planish_file_close(file);
    static const char *const names[] = {
        "region",    "gmsh:geometrical", "gmsh:physical", "medit:ref", "CellEntityIds",
        "cell_tags", "MaterialIDs",      "MaterialId",    "material",  "regionId",
        "RegionIds", "subdomain_id",     "BlockId",       "attribute", "ATTRIBUTE"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char text[512];
        snprintf(text, sizeof text, "%sFIELD data 1\n%s 1 2 int\n4 6\n", VTK_OF_TWO "CELL_DATA 2\n",
                 names[i]);
        file = reading_text(&io_format_vtk, text);
        check(file, "6=2", "02");
        planish_file_close(file);
    }
}

static void arguments_are_checked(void **state) {
    (void)state;
    static const double bad[] = {0, -1, (double)INFINITY, (double)NAN};
    planish_file *file = reading_text(&io_format_medit, solid);
    const char *tag = "7";
    double min_volume[2], value = 1;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(planish_file_min_volumes(file, &tag, &bad[i], 1, min_volume, NULL),
                         PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_min_volumes(NULL, &tag, &value, 1, min_volume, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_min_volumes(file, NULL, &value, 1, min_volume, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_min_volumes(file, &tag, NULL, 1, min_volume, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_min_volumes(file, &tag, &value, 1, NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    const char *const nothing = NULL;
    assert_int_equal(planish_file_min_volumes(file, &nothing, &value, 1, min_volume, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_min_volumes(file, &tag, &value, -1, min_volume, NULL),
                     PLANISH_ERROR_ARGUMENT);
    planish_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(references_of_medit),
        cmocka_unit_test(triangles_of_the_plane),
        cmocka_unit_test(groups_of_gmsh),
        cmocka_unit_test(parts_of_the_cube),
        cmocka_unit_test_setup_teardown(regions_of_tetgen, test_folder_create, test_folder_remove),
        cmocka_unit_test(files_without_regions),
        cmocka_unit_test(regions_of_vtk),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
