/* Tests of meshes as files of Gmsh's: names, numbers and tensors, in the text that is written: planish
 * reads more than Gmsh does. */
#include "support/converting.h"
#include "support/data_files.h"
#include "support/files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char *const versions[] = {"gmsh", "gmsh22"};

/** Convert a file: the text, to be freed. */
static char *text_of(const char *folder, planish_file *file, const char *version, char lost[512]) {
    char path[TEST_PATH_SIZE], base[64];
    planish_file_close(converting_to(folder, file, version, ".msh", lost));
    snprintf(base, sizeof base, "out-%s.msh", version);
    return test_read(test_path(path, folder, base), NULL);
}

/** Return where the lines of a section begin, behind the first, which counts them; NULL: there is none.
 *  *end: behind them. */
static const char *find_section(const char *text, const char *name, const char **end) {
    char mark[64];
    snprintf(mark, sizeof mark, "$%s\n", name);
    const char *begin = strstr(text, mark);
    snprintf(mark, sizeof mark, "$End%s\n", name);
    *end = begin ? strstr(begin, mark) : NULL;
    assert_true(!begin || *end);
    return begin ? strchr(begin + strlen(name) + 2, '\n') + 1 : NULL;
}

/** Expect the lines of a section; "": that there is none. */
static void check_section(const char *text, const char *name, const char *lines) {
    const char *end, *begin = find_section(text, name, &end);
    const size_t length = begin ? (size_t)(end - begin) : 0;
    if (length != strlen(lines) || (begin && memcmp(begin, lines, length) != 0))
        fail_msg("$%s has\n%.*s", name, (int)length, begin ? begin : "");
}

static void check_names(const char *text, const char *lines) {
    check_section(text, "PhysicalNames", lines);
}

/** Expect the entities of MSH 4.1: "TAG: GROUPS;" of each, by dimension. */
static void check_entities(const char *text, const char *expected) {
    const char *end, *at = find_section(text, "Entities", &end);
    char found[1024] = "";
    size_t used = 0;
    for (; at < end; at = strchr(at, '\n') + 1) {
        long tag, n;
        int length;
        assert_int_equal(sscanf(at, "%ld %*f %*f %*f %*f %*f %*f %ld%n", &tag, &n, &length), 2);
        used += (size_t)snprintf(found + used, sizeof found - used, "%ld:", tag);
        for (const char *group = at + length; n > 0; n--) {
            assert_int_equal(sscanf(group, "%ld%n", &tag, &length), 1);
            used += (size_t)snprintf(found + used, sizeof found - used, " %ld", tag);
            group += length;
        }
        used += (size_t)snprintf(found + used, sizeof found - used, ";");
    }
    assert_string_equal(found, expected);
}

/** Expect the elements of MSH 2.2: "GROUP ENTITY;" of each. */
static void check_elements(const char *text, const char *expected) {
    const char *end, *at = find_section(text, "Elements", &end);
    char found[1024] = "";
    size_t used = 0;
    for (; at < end; at = strchr(at, '\n') + 1) {
        long group, entity;
        assert_int_equal(sscanf(at, "%*d %*d 2 %ld %ld", &group, &entity), 2);
        used += (size_t)snprintf(found + used, sizeof found - used, "%ld %ld;", group, entity);
    }
    assert_string_equal(found, expected);
}

/** Open a file of MSH 2.2 with two tetrahedra and a triangle, by its names, and group and entity of each. */
static planish_file *open_mesh(const char *folder, int n, const char *names, const int tags[3][2]) {
    file_builder b = {.binary = 0};
    builder_text(&b,
                 "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n%s"
                 "$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n"
                 "$EndNodes\n$Elements\n3\n",
                 n, names);
    builder_text(&b, "1 4 2 %d %d 1 2 3 4\n", tags[0][0], tags[0][1]);
    builder_text(&b, "2 4 2 %d %d 2 3 4 5\n", tags[1][0], tags[1][1]);
    builder_text(&b, "3 2 2 %d %d 1 2 3\n$EndElements\n", tags[2][0], tags[2][1]);
    return converting_open_built(folder, "mesh.msh", &b);
}

/* ---- groups --------------------------------------------------------------------------------- */

/** Numbers of the file stay if each has a name and each name one: also those without a name, in any order,
 *  and of groups without elements. */
static void own_numbers_stay(void **state) {
    static const int tags[3][2] = {{50, 9}, {30, 4}, {70, 6}};
    const char *names = "3 50 \"b\"\n3 30 \"a\"\n2 77 \"empty\"\n2 50 \"b\"\n";
    char lost[512];
    planish_file *file = open_mesh(*state, 4, names, tags);
    char *text = text_of(*state, file, "gmsh", lost);
    check_names(text, names);
    check_entities(text, "6: 70;9: 50;4: 30;");
    assert_null(strstr(lost, "numbers"));
    free(text);
    text = text_of(*state, file, "gmsh22", lost);
    check_names(text, names);
    check_elements(text, "50 9;30 4;70 6;");
    assert_null(strstr(lost, "numbers"));
    free(text);
    planish_file_close(file);
}

/** Groups of negative numbers, as MED's families have, get free ones: no two of any dimension one. */
static void negative_numbers_are_replaced(void **state) {
    static const int tags[3][2] = {{-6, 1}, {-7, 2}, {-8, 1}};
    char lost[512];
    planish_file *file = open_mesh(*state, 5,
                                   "3 -6 \"first\"\n3 -6 \"both\"\n3 -7 \"both\"\n2 -8 \"skin\"\n"
                                   "3 -9 \"unused\"\n",
                                   tags);
    for (int v = 0; v < 2; v++) {
        char *text = text_of(*state, file, versions[v], lost);
        check_names(text, "3 1 \"first\"\n3 2 \"both\"\n2 3 \"skin\"\n");
        if (v == 0)
            check_entities(text, "1: 3;1: 1 2;2: 2;");
        else
            check_elements(text, "1 1;2 2;3 1;");
        assert_null(strstr(lost, "numbers"));
        assert_int_equal(strstr(lost, "all but the first group") != NULL, v == 1);
        free(text);
    }
    planish_file_close(file);
}

/** Negative numbers without a name are lost, and that is said. */
static void numbers_without_names_are_told(void **state) {
    static const int tags[3][2] = {{-6, 1}, {2, 2}, {1, 1}};
    char lost[512];
    planish_file *file = open_mesh(*state, 2, "3 2 \"two\"\n2 1 \"\"\n", tags);
    char *text = text_of(*state, file, "gmsh", lost);
    check_names(text, "3 2 \"two\"\n");
    check_entities(text, "1: 1;1: 3;2: 2;");
    assert_non_null(strstr(lost, "numbers of groups"));
    free(text);
    planish_file_close(file);
}

/** Of several names of a number and several numbers of a name one each is kept. */
static void names_have_one_number(void **state) {
    static const int tags[3][2] = {{4, 4}, {7, 7}, {4, 4}};
    char lost[512];
    planish_file *file = open_mesh(*state, 6,
                                   "3 4 \"bottom\"\n3 4 \"skin\"\n3 7 \"top\"\n3 7 \"lid\"\n"
                                   "3 7 \"skin\"\n2 4 \"skin\"\n",
                                   tags);
    for (int v = 0; v < 2; v++) {
        char *text = text_of(*state, file, versions[v], lost);
        check_names(text, "3 4 \"bottom\"\n3 1 \"skin\"\n3 7 \"top\"\n3 2 \"lid\"\n2 4 \"skin\"\n");
        if (v == 0)
            check_entities(text, "4: 4;4: 4 1;7: 7 2 1;");
        else
            check_elements(text, "4 4;7 7;4 4;");
        assert_non_null(strstr(lost, "numbers of groups"));
        free(text);
    }
    planish_file_close(file);
}

/** Quotes in names are told; groups whose names differ by them alone stay apart. */
static void quotes_are_told(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\ng a_b\nf 1 2 3\ng a\"b\nf 1 3 4\n");
    planish_file *file = converting_open_built(*state, "quotes.obj", &b);
    char *text = text_of(*state, file, "gmsh", lost);
    check_names(text, "2 1 \"a_b\"\n2 2 \"a_b\"\n");
    assert_non_null(strstr(lost, "quotes and control characters (now '_') in names of groups"));
    free(text);
    planish_file_close(file);
}

/** The numbers of OBJ's groups are none of the file's: they begin at 1, and no group is empty. */
static void groups_of_obj_are_all_there(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 1\nv 2 1 1\ng wall\nf 1 2 3\n"
                     "g inlet\nf 1 3 4\ng outlet wall\nf 2 5 6 3\n");
    planish_file *file = converting_open_built(*state, "groups.obj", &b);
    char *text = text_of(*state, file, "gmsh", lost);
    check_names(text, "2 1 \"wall\"\n2 2 \"inlet\"\n2 3 \"outlet\"\n");
    check_entities(text, "1: 1;2: 2;3: 1 3;");
    assert_null(strstr(lost, "numbers"));
    free(text);
    text = text_of(*state, file, "gmsh22", lost);
    check_names(text, "2 1 \"wall\"\n2 2 \"inlet\"\n2 3 \"outlet\"\n");
    check_elements(text, "1 1;2 2;1 3;");
    free(text);
    planish_file_close(file);
}

/** Of a thousand names of one number, which has a thousand entities, the first is left. */
static void many_names_are_told(void **state) {
    enum { N = 1002 };
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%d\n", N);
    for (int i = 0; i < N; i++)
        builder_text(&b, "3 5 \"name %d\"\n", i);
    builder_text(&b,
                 "$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
                 "$EndNodes\n$Elements\n%d\n",
                 N);
    for (int i = 1; i <= N; i++)
        builder_text(&b, "%d 4 2 5 %d 1 2 3 4\n", i, i);
    builder_text(&b, "$EndElements\n");
    planish_file *file = converting_open_built(*state, "many.msh", &b);
    char *text = text_of(*state, file, "gmsh", lost);
    check_names(text, "3 5 \"name 0\"\n");
    assert_non_null(strstr(lost, "all but the first name of each group (there are too many)"));
    free(text);
    planish_file_close(file);
}

/** Expect that no line of names has the dimension and number, or the dimension and name, of another. */
static void check_distinct(const char *text, const char *file) {
    const char *end, *at = find_section(text, "PhysicalNames", &end);
    for (; at && at < end; at = strchr(at, '\n') + 1)
        for (const char *next = strchr(at, '\n') + 1; next < end; next = strchr(next, '\n') + 1) {
            const size_t number = strcspn(at, "\""), name = strcspn(at + number, "\n");
            const char *quote = strchr(next, '"');
            if (strncmp(at, next, number) == 0 ||
                (*at == *next && strncmp(at + number, quote, name + 1) == 0))
                fail_msg("%s: %.*s and %.*s", file, (int)(number + name), at,
                         (int)strcspn(next, "\n"), next);
        }
}

/** Names of all formats are distinct; MSH 4.1 has all groups of elements. */
static void files_keep_their_groups(void **state) {
    for (const test_data_file *f = test_data_files; f->name; f++) {
        char path[TEST_PATH_SIZE], lost[512];
        if (!test_data_path(path, f))
            continue;
        planish_file *file = converting_open(path);
        for (int v = 1; v >= 0; v--) {
            char *text = text_of(*state, file, versions[v], lost);
            check_distinct(text, f->name);
            free(text);
        }
        planish_file *copy = converting_open(test_path(path, *state, "out-gmsh.msh"));
        for (int32_t g = 0; g < file->model.n_groups; g++) {
            const io_group *group = &file->model.group[g];
            uint8_t *a, *b;
            if (group->dim == 0)
                continue;
            a = converting_nodes_of(file, group->name);
            b = converting_nodes_of(copy, group->name);
            if (memcmp(a, b, (size_t)planish_file_mesh(file).n_nodes) != 0)
                fail_msg("%s: %s has other nodes", f->name, group->name);
            free(a);
            free(b);
        }
        planish_file_close(copy);
        planish_file_close(file);
    }
}

/** Groups that come back from Gmsh's format are those that went there. */
static void groups_come_back(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
                     "*ELEMENT, TYPE=C3D4, ELSET=one\n7,1,2,3,4\n"
                     "*ELEMENT, TYPE=C3D4, ELSET=two\n9,2,3,4,5\n*ELSET, ELSET=both\none,two\n");
    planish_file *file = converting_open_built(*state, "sets.inp", &b);
    planish_file *msh = converting_to(*state, file, "gmsh", ".msh", lost);
    assert_null(strstr(lost, "groups"));
    planish_file *copy = converting_to(*state, msh, "abaqus", ".inp", lost);
    static const char *const names[] = {"one", "two", "both"};
    for (int k = 0; k < 3; k++) {
        uint8_t *p = converting_nodes_of(file, names[k]), *q = converting_nodes_of(copy, names[k]);
        assert_memory_equal(p, q, 5);
        free(p);
        free(q);
    }
    planish_file_close(copy);
    planish_file_close(msh);
    planish_file_close(file);
}

/* ---- regions -------------------------------------------------------------------------------- */

/** Medit's references stay, in any order; those that are 0 or negative get free numbers. */
static void references_stay(void **state) {
    static const struct {
        int reference[3];
        const char *entities;
        int is_told;
    } cases[] = {{{50, 30, 70}, "50:;30:;70:;", 0},
                 {{50, 0, 1}, "50:;2:;1:;", 0},
                 {{50, -30, 70}, "50:;1:;70:;", 1}};
    for (int k = 0; k < 3; k++) {
        file_builder b = {.binary = 0};
        char lost[512];
        builder_text(&b,
                     "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n0 0 0 0\n1 0 0 0\n"
                     "0 1 0 0\n1 1 1 0\n2 0 2 0\nTriangles\n3\n1 2 3 %d\n2 4 3 %d\n"
                     "2 5 4 %d\nEnd\n",
                     cases[k].reference[0], cases[k].reference[1], cases[k].reference[2]);
        planish_file *file = converting_open_built(*state, "references.mesh", &b);
        char *text = text_of(*state, file, "gmsh", lost);
        check_entities(text, cases[k].entities);
        assert_int_equal(strstr(lost, "numbers of regions") != NULL, cases[k].is_told);
        free(text);
        planish_file_close(file);
    }
}

/** Entities of one number that are in different groups become several. */
static void shared_numbers_of_entities_are_told(void **state) {
    static const int tags[3][2] = {{1, 5}, {2, 5}, {3, 5}};
    char lost[512];
    planish_file *file = open_mesh(*state, 0, "", tags);
    char *text = text_of(*state, file, "gmsh", lost);
    check_entities(text, "5: 3;5: 1;1: 2;");
    assert_non_null(strstr(lost, "numbers of regions"));
    free(text);
    planish_file_close(file);
}

/* ---- data ----------------------------------------------------------------------------------- */

/** A tensor of two dimensions is one of three: its rows stay rows. */
static void plane_tensors_become_solid(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 3 double\n0 0 0 1 0 0 0 1 0\nCELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n"
                     "CELL_DATA 1\nFIELD f 1\nt 4 1 double\n1 2 3 4\n");
    planish_file *file = converting_open_built(*state, "tensor.vtk", &b);
    for (int v = 0; v < 2; v++) {
        char *text = text_of(*state, file, versions[v], lost);
        check_section(text, "ElementData", "\"t\"\n1\n0\n3\n0\n9\n1\n1 1 2 0 3 4 0 0 0 0\n");
        free(text);
    }
    planish_file_close(file);
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(own_numbers_stay),
        IN_A_FOLDER(negative_numbers_are_replaced),
        IN_A_FOLDER(numbers_without_names_are_told),
        IN_A_FOLDER(names_have_one_number),
        IN_A_FOLDER(quotes_are_told),
        IN_A_FOLDER(groups_of_obj_are_all_there),
        IN_A_FOLDER(many_names_are_told),
        IN_A_FOLDER(files_keep_their_groups),
        IN_A_FOLDER(groups_come_back),
        IN_A_FOLDER(references_stay),
        IN_A_FOLDER(shared_numbers_of_entities_are_told),
        IN_A_FOLDER(plane_tensors_become_solid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
