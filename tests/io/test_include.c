/* Tests of Abaqus and Nastran files that include others: constraints and regions are followed; nodes
 * must be in the file itself. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "io/file/file.h"
#include "support/files.h"
#include "support/folder_files.h"

static int is_fixed_by(const planish_file *file, const char *tag, int node) {
    uint8_t reason[16];
    const planish_hold hold = {.tags = &tag, .n_tags = tag != NULL};
    planish_error error = {.text = ""};
    assert_in_range(planish_file_mesh(file).n_nodes, 1, 16);
    if (planish_file_get_held(file, &hold, reason, &error))
        fail_msg("%s", error.text);
    const int wanted = tag ? PLANISH_FILE_FIX : PLANISH_FILE_REQUIRED | PLANISH_FILE_OTHER_ELEMENT;
    return (reason[node] & wanted) != 0;
}

#define FIVE_NODES "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"

/** Elements, sets and equations of included files count; data go on in them and behind them. */
static void abaqus_files_include_others(void **state) {
    char path[TEST_PATH_SIZE], again[TEST_PATH_SIZE];
    const char *folder = *state;
    size_t n, m;
    test_path(path, folder, "sub");
    assert_int_equal(mkdir(path, 0777), 0);
    folder_write(folder, "main.inp",
                 "*HEADING\na\n" FIVE_NODES "*ELEMENT, TYPE=C3D4, ELSET=one\n"
                 "*INCLUDE, INPUT=sub/more.inp\n3,1,2,3,5\n"
                 "*NSET, NSET=ends, INPUT=ends.txt\n*include , input = \"equations.inp\"\n");
    folder_write(folder, "sub/more.inp", "1,1,2,3,4\n*ELEMENT, TYPE=C3D4, ELSET=two\n2,2,3,4,5\n");
    folder_write(folder, "ends.txt", "1,\n5\n");
    folder_write(folder, "equations.inp", "*EQUATION\n2\n4,1,1.,5,1,-1.\n");
    planish_file *file = folder_open(folder, "main.inp");
    assert_int_equal(planish_file_mesh(file).n_elements, 3);
    assert_int_equal(file->n_regions, 2);
    assert_true(is_fixed_by(file, "ends", 0) && !is_fixed_by(file, NULL, 0));
    assert_true(is_fixed_by(file, NULL, 3) && is_fixed_by(file, NULL, 4));
    /* The file is written as it was, and nothing else. */
    assert_int_equal(planish_file_write(file, test_path(again, folder, "out.inp"),
                                        planish_file_coordinates(file),
                                        &(planish_write_options){.threads = 1}, NULL),
                     0);
    char *a = test_read(test_path(path, folder, "main.inp"), &n), *b = test_read(again, &m);
    assert_int_equal(n, m);
    assert_memory_equal(a, b, n);
    free(a);
    free(b);
    planish_file_close(file);
    assert_int_equal(unlink(test_path(path, folder, "sub/more.inp")), 0);
    assert_int_equal(rmdir(test_path(path, folder, "sub")), 0);
}

static void nastran_files_include_others(void **state) {
    const char *folder = *state;
    folder_write(folder, "main.bdf",
                 "BEGIN BULK\nGRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n"
                 "GRID,4,,0.,0.,1.\nGRID,5,,1.,1.,1.\nINCLUDE 'elements.bdf'\n"
                 "CTETRA,2,20,2,3,4,5\nENDDATA\n");
    folder_write(
        folder, "elements.bdf",
        "$HMNAME PROP       10\"steel\"\nCTETRA,1,10,1,2,3,4\ninclude \"rigid.bdf\"\nENDDATA\n"
        "this is not read\n");
    folder_write(folder, "rigid.bdf", "RBE2,9,5,123,4\n");
    planish_file *file = folder_open(folder, "main.bdf");
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    assert_int_equal(file->n_regions, 2);
    assert_true(is_fixed_by(file, "steel", 0) && !is_fixed_by(file, NULL, 0));
    assert_true(is_fixed_by(file, NULL, 4));
    planish_file_close(file);
}

/** Nodes elsewhere: the error names the file to smooth. */
static void nodes_must_be_in_the_file(void **state) {
    const char *folder = *state;
    folder_write(folder, "main.inp", "*HEADING\na\n*INCLUDE, INPUT=mesh.inp\n*STEP\n*END STEP\n");
    folder_write(folder, "mesh.inp", FIVE_NODES "*ELEMENT, TYPE=C3D4\n1,1,2,3,4\n");
    folder_open_fails(folder, "main.inp", "mesh.inp:2: this file, which ");
    folder_open_fails(folder, "main.inp", "main.inp includes, has nodes: smooth this file instead");
    planish_file_close(folder_open(folder, "mesh.inp"));
    folder_write(folder, "main.bdf", "BEGIN BULK\nINCLUDE 'mesh.bdf'\nENDDATA\n");
    folder_write(folder, "mesh.bdf", "GRID,1,,0.,0.,0.\n");
    folder_open_fails(folder, "main.bdf", "mesh.bdf:1: this file, which ");
    folder_write(folder, "data.inp", "*NODE, INPUT=nodes.txt\n");
    folder_open_fails(folder, "data.inp", "INPUT=: the nodes are in another file");
}

/** Errors of included files name these; files that are not there, elsewhere or endless are refused. */
static void wrong_includes_are_refused(void **state) {
    static const struct {
        const char *name, *text, *part;
    } cases[] = {
        {"a.inp", FIVE_NODES "*INCLUDE, INPUT=bad.inp\n", "bad.inp:2: "},
        {"b.inp", FIVE_NODES "*INCLUDE, INPUT=missing.inp\n", "missing.inp: "},
        {"c.inp", FIVE_NODES "*INCLUDE, INPUT=/etc/hostname\n",
         "c.inp:7: '/etc/hostname' is not beside"},
        {"d.inp", FIVE_NODES "*INCLUDE, INPUT=../../../../../../../../etc/hostname\n",
         "d.inp:7: '../"},
        {"e.inp", FIVE_NODES "*INCLUDE, INPUT=link.inp\n", "e.inp:7: 'link.inp' is not beside"},
        {"f.inp", FIVE_NODES "*INCLUDE, INPUT=f.inp\n", "f.inp"},
        {"g.inp", FIVE_NODES "*INCLUDE\n", "g.inp:7: *INCLUDE without INPUT="},
        {"h.inp", FIVE_NODES "*INCLUDE, INPUT=\n", "the name of the included file is missing"},
        {"loop.inp", FIVE_NODES "*INCLUDE, INPUT=loop2.inp\n",
         "files include one another too deeply"},
        {"a.bdf", "GRID,1,,0.,0.,0.\nINCLUDE 'bad.bdf'\n", "bad.bdf:1: "},
        {"b.bdf", "GRID,1,,0.,0.,0.\nINCLUDE 'loop2.bdf'\n",
         "files include one another too deeply"},
        {"c.bdf", "GRID,1,,0.,0.,0.\nINCLUDE\n", "the name of the included file is missing"},
    };
    const char *folder = *state;
    char link[TEST_PATH_SIZE];
    folder_write(folder, "bad.inp", "*ELEMENT, TYPE=C3D4\n1,1,2,3,99\n");
    folder_write(folder, "bad.bdf", "CTETRA,1,10,1,2,3,99\n");
    folder_write(folder, "loop2.inp", "*INCLUDE, INPUT=loop2.inp\n");
    folder_write(folder, "loop2.bdf", "INCLUDE 'loop2.bdf'\n");
    assert_int_equal(symlink("/etc/hostname", test_path(link, folder, "link.inp")), 0);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        folder_write(folder, cases[i].name, cases[i].text);
        folder_open_fails(folder, cases[i].name, cases[i].part);
    }
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(abaqus_files_include_others), IN_A_FOLDER(nastran_files_include_others),
        IN_A_FOLDER(nodes_must_be_in_the_file), IN_A_FOLDER(wrong_includes_are_refused)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
