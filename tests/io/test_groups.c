/* The groups that a file lists: what they are called in every kind of format, and that each is a tag. */
#include "support/data_files.h"
#include "support/files.h"
#include "support/reading.h"

#include <planish/planish_io.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** List the groups of file, "DIM TAG (N)|" for each, as text [size]. */
static void list(planish_file *file, char *text, size_t size) {
    const planish_group *group;
    planish_error error;
    int64_t n;
    size_t used = 0;
    text[0] = '\0';
    assert_int_equal(planish_file_groups(file, &group, &n, &error), 0);
    for (int64_t i = 0; i < n && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%d %s (%d)|", group[i].dim,
                                 group[i].tag, (int)group[i].n);
}

static void check(const io_format *format, const char *text, const char *expected) {
    planish_file *file = reading_text(format, text);
    char found[512], again[512];
    list(file, found, sizeof found);
    assert_string_equal(found, expected);
    list(file, again, sizeof again);
    assert_string_equal(again, found);
    planish_file_close(file);
}

#define NODES "$Nodes\n4\n1 0 0 0\n2 0 0 1\n3 1 0 0\n4 0 1 0\n$EndNodes\n"

static void names_come_first(void **state) {
    (void)state;
    check(&io_format_gmsh,
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
          "$PhysicalNames\n2\n3 1 \"left half\"\n2 9 \"wall\"\n$EndPhysicalNames\n" NODES
          "$Elements\n4\n1 2 2 9 5 1 2 3\n2 4 2 1 6 1 2 3 4\n3 4 2 -2 17 1 2 3 4\n"
          "4 2 2 0 7 1 2 4\n$EndElements\n",
          "3 left half (1)|2 wall (1)|2 2:7 (1)|3 3:-2 (1)|");
    check(&io_format_medit,
          "MeshVersionFormatted 2 Dimension 3 Vertices 5 0 0 0 3 1 0 0 1 0 1 0 2 0 0 1 2 1 1 1.5 3 "
          "Tetrahedra 2 1 2 3 4 7 2 3 4 5 0 Triangles 2 1 2 3 4 1 2 4 4 End",
          "0 0:1 (1)|0 0:2 (2)|0 0:3 (2)|2 2:4 (2)|3 3:0 (1)|3 3:7 (1)|");
    check(&io_format_abaqus,
          "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=part\n1,1,2,3,4\n"
          "*NSET,NSET=\"fixed end\"\n1,2\n",
          "3 part (1)|0 fixed end (2)|");
    check(&io_format_off, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "");
}

/** Several numbers of one name are one group, which has the elements of each of them once. */
static void numbers_of_a_name_are_counted(void **state) {
    (void)state;
    check(&io_format_gmsh,
          "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
          "$PhysicalNames\n6\n3 2 \"A\"\n2 1 \"A\"\n3 9 \"B\"\n3 1 \"A\"\n3 2 \"A\"\n3 4 \"A\"\n"
          "$EndPhysicalNames\n" NODES
          "$Elements\n5\n1 4 2 1 1 1 2 3 4\n2 4 2 2 2 1 2 3 4\n3 4 2 2 3 1 2 3 4\n"
          "4 2 2 1 4 1 2 3\n5 4 2 4 5 1 2 3 4\n$EndElements\n",
          "3 A (4)|2 A (1)|3 B (0)|");
    check(&io_format_mfem,
          "MFEM mesh v1.3\n\ndimension\n2\n\nelements\n3\n1 2 0 1 2\n2 2 1 3 2\n3 2 1 4 3\n\n"
          "attribute_sets\n2\n\"A\"\n2\n1 3\n\"only\"\n1\n2\n\nboundary\n0\n\n"
          "bdr_attribute_sets\n0\n\nvertices\n5\n2\n0 0\n1 0\n0 1\n1 1\n2 0\n\nmfem_mesh_end\n",
          "2 A (2)|2 only (1)|");
    check(&io_format_nastran,
          "BEGIN BULK\n$HMNAME PROP 1\"A\"\n$HMNAME PROP 2\"A\"\n"
          "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
          "CTRIA3,1,1,1,2,3\nCTRIA3,2,2,1,2,4\nCTRIA3,3,2,1,3,4\nENDDATA\n",
          "2 A (3)|");
}

/** Every group that is listed can be held. */
static void each_is_a_tag(void **state) {
    (void)state;
    char path[TEST_PATH_SIZE];
    int64_t n_groups = 0;
    for (const test_data_file *data = test_data_files; data->name; data++) {
        const planish_group *group;
        planish_file *file = NULL;
        planish_error error;
        int64_t n;
        if (!test_data_path(path, data))
            continue;
        if (planish_file_open(path, NULL, 1, &file, &error))
            fail_msg("%s: %s", data->name, error.text);
        assert_int_equal(planish_file_groups(file, &group, &n, &error), 0);
        uint8_t *constraint = malloc((size_t)planish_file_mesh(file).n_nodes + 1);
        for (int64_t i = 0; i < n && i < 50; i++) {
            const planish_hold hold = {.tags = &group[i].tag, .n_tags = 1};
            if (planish_file_constraints(file, &hold, constraint, &error))
                fail_msg("%s: '%s': %s", data->name, group[i].tag, error.text);
        }
        n_groups += n;
        free(constraint);
        planish_file_close(file);
    }
    assert_true(n_groups > 50);
}

static void arguments_are_checked(void **state) {
    (void)state;
    const planish_group *group;
    planish_error error;
    int64_t n = 7;
    assert_int_equal(planish_file_groups(NULL, &group, &n, &error), PLANISH_ERROR_ARGUMENT);
    assert_int_equal(n, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_come_first),
        cmocka_unit_test(numbers_of_a_name_are_counted),
        cmocka_unit_test(each_is_a_tag),
        cmocka_unit_test(arguments_are_checked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
