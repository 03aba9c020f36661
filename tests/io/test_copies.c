/* Nodes that a file gives more than once: one node, whose places in the file move together. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- text --------------------------------------------------------------------------------- */

/* Node 5 is inside, and is the first of the file; then it is there again, written otherwise. */
#define ABAQUS_REST                                                                                \
    "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n"                                                         \
    "*ELEMENT,TYPE=C3D4\n1,1,2,3,5\n2,1,2,4,5\n3,1,3,4,5\n4,2,3,4,5\n"
#define NASTRAN_REST                                                                               \
    "GRID,1\nGRID,2,,1.\nGRID,3,,,1.\nGRID,4,,,,1.\n"                                              \
    "CTETRA,1,1,1,2,3,5\nCTETRA,2,1,1,2,4,5\nCTETRA,3,1,1,3,4,5\nCTETRA,4,1,2,3,4,5\nENDDATA\n"
#define GMSH_REST                                                                                  \
    "$EndNodes\n$Elements\n4\n1 4 2 0 1 1 2 3 5\n2 4 2 0 1 1 2 4 5\n3 4 2 0 1 1 3 4 5\n"           \
    "4 4 2 0 1 2 3 4 5\n$EndElements\n"

static const char abaqus[] =
    "*NODE\n5,.25,.125,.2\n*NODE,NSET=REF\n 5, 2.5E-1 , 0.125,.20\n2,1,0,0\n" ABAQUS_REST;
static const char nastran[] =
    "GRID    5               .25     .125    .2\nGRID,5,,2.5-1,.125,.2\n" NASTRAN_REST;
static const char gmsh[] =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n7\n5 .25 .125 .2\n"
    "1 0 0 0\n2 1 0 0\n3 0 1 0\n5 2.5e-1 1.25e-1  2e-1\n2 1 -0. 0\n4 0 0 1\n" GMSH_REST;

static const struct {
    const io_format *format;
    const char *text;
} texts[] = {{&io_format_abaqus, abaqus}, {&io_format_nastran, nastran}, {&io_format_gmsh, gmsh}};
enum { N_TEXTS = sizeof texts / sizeof *texts };

static void copies_are_one_node(void **state) {
    (void)state;
    for (int i = 0; i < N_TEXTS; i++) {
        planish_file *file = reading_text(texts[i].format, texts[i].text);
        const planish_mesh mesh = planish_file_mesh(file);
        assert_int_equal(mesh.n_nodes, 5);
        assert_int_equal(mesh.n_elements, 4);
        assert_int_equal(planish_file_node_number(file, 0), 5);
        for (int k = 0; k < 4; k++)
            assert_int_equal(mesh.elements[4 * k + 3], 0);
        assert_true(mesh.coordinates[1] == .125);
        assert_int_equal(file->model.n_places - mesh.n_nodes, i == 1 ? 1 : 2);
        planish_file_close(file);
        reading_every_beginning(texts[i].format, texts[i].text, (int64_t)strlen(texts[i].text));
        const file_builder builder = builder_of(texts[i].text);
        builder_let_allocations_fail(&builder, texts[i].format);
    }
}

static void copies_move_together(void **state) {
    rewriting_gives(&io_format_abaqus, abaqus, "xz",
                    "*NODE\n5,.125,.125,123456.789\n*NODE,NSET=REF\n 5, .125 , 0.125,123456.789\n"
                    "2,1,0,0\n" ABAQUS_REST,
                    *state);
    rewriting_gives(
        &io_format_nastran, nastran, "x",
        "GRID    5               .125    .125    .2\nGRID,5,,.125,.125,.2\n" NASTRAN_REST, *state);
    static const char expected[] =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n7\n5 0.125 .125 .2\n1 0 0 0\n2 1 0 0\n"
        "3 0 1 0\n5 0.125 1.25e-1  2e-1\n2 1 -0. 0\n4 0 0 1\n" GMSH_REST;
    char path[TEST_PATH_SIZE];
    planish_error error = {.text = ""};
    planish_file *file = reading_text(&io_format_gmsh, gmsh);
    planish_file_coordinates(file)[0] = .125;
    test_path(path, *state, "out.msh");
    if (planish_file_write(file, path, planish_file_coordinates(file),
                           &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
    char *written = test_read(path, NULL);
    assert_string_equal(written, expected);
    free(written);
    planish_file_close(file);
}

static void other_places_are_refused(void **state) {
    (void)state;
    static const char message[] = "node number 2 occurs twice, at different places";
    reading_fails(&io_format_abaqus, "*NODE\n2,1,0,1e-300\n" ABAQUS_REST, message);
    reading_fails(&io_format_nastran, "GRID,2,,1.,1.-9\n" NASTRAN_REST, message);
    reading_fails(&io_format_gmsh,
                  "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n6\n5 .25 .125 .2\n1 0 0 0\n"
                  "2 1 0 0\n3 0 1 0\n4 0 0 1\n2 1.0000000000000002 0 0\n" GMSH_REST,
                  message);
}

/* ---- binary ------------------------------------------------------------------------------- */

/* Triangles about node 9 of a plane, which has two places; far apart numbers. MSH 4 has them in two
 * blocks. */
static file_builder make_binary(int is_4, int swapped) {
    static const int numbers[] = {9, 1, 2, 900000, 4, 9};
    static const double xy[][2] = {{.4, .5}, {0, 0}, {1, 0}, {1, 1}, {0, 1}, {.4, .5}};
    static const int triangles[][3] = {{1, 2, 9}, {2, 900000, 9}, {900000, 4, 9}, {4, 1, 9}};
    file_builder file = {.binary = 1, .swapped = swapped};
    const int size = is_4 ? 8 : 4;
    builder_text(&file, "$MeshFormat\n%s 1 8\n", is_4 ? "4.1" : "2.2");
    builder_integer(&file, 1, 4);
    builder_text(&file, "\n$EndMeshFormat\n$Nodes\n%s", is_4 ? "" : "6\n");
    for (int i = 0; i < 4 && is_4; i++)
        builder_integer(&file, (const int[]){6, 6, 1, 900000}[i], 8);
    for (int i = 0; i < 6; i++) {
        for (int k = 0; k < 3 && is_4; k++)
            builder_integer(&file, (const int[]){2, 1, 0}[k], 4);
        if (is_4)
            builder_integer(&file, 1, 8);
        builder_integer(&file, numbers[i], size);
        for (int d = 0; d < 3; d++)
            builder_real(&file, d < 2 ? xy[i][d] : 0, 8);
    }
    builder_text(&file, "\n$EndNodes\n$Elements\n%s", is_4 ? "" : "4\n");
    for (int i = 0; i < 4 && is_4; i++)
        builder_integer(&file, (const int[]){1, 4, 1, 4}[i], 8);
    for (int k = 0; k < 3; k++)
        builder_integer(&file, is_4 ? (const int[]){2, 1, 2}[k] : (const int[]){2, 4, 0}[k], 4);
    if (is_4)
        builder_integer(&file, 4, 8);
    for (int i = 0; i < 4; i++) {
        builder_integer(&file, i + 1, size);
        for (int k = 0; k < 3; k++)
            builder_integer(&file, triangles[i][k], size);
    }
    builder_text(&file, "\n$EndElements\n");
    return file;
}

/* Read again, both places of the moved node must be the same: else it would be refused. */
static void check_binary(const file_builder *builder, const char *folder) {
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    if (builder_read(builder, &io_format_gmsh, 1, &file, &error))
        fail_msg("%s", error.text);
    assert_int_equal(planish_file_mesh(file).n_nodes, 5);
    double *coordinates = planish_file_coordinates(file);
    coordinates[0] = .25;
    coordinates[1] = .75;
    test_path(path, folder, "out.msh");
    if (planish_file_write(file, path, coordinates, &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
    planish_file_close(file);
    size_t size;
    char *data = test_read(path, &size);
    assert_int_equal(size, builder->size);
    int n_differ = 0;
    for (size_t i = 0; i < size; i++)
        n_differ += data[i] != builder->data[i];
    assert_in_range(n_differ, 4, 2 * 2 * sizeof(double));
    assert_int_equal(
        io_file_from_memory(&io_format_gmsh, "out.msh", data, (int64_t)size, 1, &file, &error),
        PLANISH_OK);
    assert_true(planish_file_mesh(file).coordinates[0] == .25);
    planish_file_close(file);
    free(data);
}

static void copies_in_binary_files(void **state) {
    for (int i = 0; i < 4; i++) {
        file_builder builder = make_binary(i / 2, i % 2);
        check_binary(&builder, *state);
        builder_try_to_break(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(copies_are_one_node),
        cmocka_unit_test_setup_teardown(copies_move_together, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(other_places_are_refused),
        cmocka_unit_test_setup_teardown(copies_in_binary_files, test_folder_create,
                                        test_folder_remove),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
