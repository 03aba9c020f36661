/* Tests of meshes that are converted to other formats: what is written is read again. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "io/core/binary.h"
#include "support/converting.h"
#include "support/data_files.h"
#include "support/file_builder.h"
#include "support/files.h"
#include "support/bent_elements.h"
#include "support/reading.h"

/** A format that meshes are converted to, and the types of elements that it lacks: elements of these
 *  lose nodes. */
static const struct target {
    const char *name, *extension;
    int is_near; /* coordinates are rounded to 16 or 20 characters */
    int lacks[5][2];
} targets[] = {
    {"vtu", ".vtu", 0, {{0}}},
    {"vtk", ".vtk", 0, {{0}}},
    {"gmsh", ".msh", 0, {{0}}},
    {"gmsh22", ".msh", 0, {{0}}},
    {"medit",
     ".mesh",
     0,
     {{PLANISH_CELL_QUADRILATERAL8, PLANISH_CELL_QUADRILATERAL},
      {PLANISH_CELL_HEXAHEDRON20, PLANISH_CELL_HEXAHEDRON},
      {PLANISH_CELL_WEDGE15, PLANISH_CELL_WEDGE},
      {PLANISH_CELL_PYRAMID13, PLANISH_CELL_PYRAMID}}},
    {"abaqus",
     ".inp",
     1,
     {{PLANISH_CELL_QUADRILATERAL9, PLANISH_CELL_QUADRILATERAL8},
      {PLANISH_CELL_PYRAMID13, PLANISH_CELL_PYRAMID}}},
    {"nastran",
     ".bdf",
     1,
     {{PLANISH_CELL_QUADRILATERAL9, PLANISH_CELL_QUADRILATERAL8},
      {PLANISH_CELL_HEXAHEDRON27, PLANISH_CELL_HEXAHEDRON20},
      {PLANISH_CELL_WEDGE18, PLANISH_CELL_WEDGE15}}},
    {"exodus", ".e", 0, {{0}}},
};

enum { N_TARGETS = sizeof targets / sizeof *targets };

/* ---- files ---------------------------------------------------------------------------------- */

/** Whether this build reads what is written to a target. */
static int is_read(const struct target *target) {
    return strcmp(target->name, "vtu") != 0 || reading_knows_vtu();
}

/* ---- comparison ----------------------------------------------------------------------------- */

/** Count the elements of each type, inverted ones in place 0. */
static void count_types(planish_file *file, int64_t count[256]) {
    planish_cells cells;
    planish_cell_quality quality;
    planish_error error = {.text = ""};
    const planish_mesh of = planish_file_mesh(file);
    memset(count, 0, 256 * sizeof *count);
    assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
    for (int64_t i = 0; i < cells.n; i++)
        count[cells.type[i]]++;
    const planish_mesh mesh = {.dim = of.dim,
                               .n_nodes = of.n_nodes,
                               .n_elements = cells.n,
                               .coordinates = of.coordinates,
                               .cells = &cells};
    if (planish_measure_cells(&mesh, 0, 1, &quality, NULL, &error))
        fail_msg("%s", error.text);
    count[0] = quality.all.n_inverted + quality.all.n_uncertified;
}

static int compare_keys(const void *a, const void *b) {
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/** Make a sorted list of numbers that tell the elements by their corners, in any order: owned. */
static uint64_t *keys_of(planish_file *file, int64_t *n) {
    planish_cells cells;
    assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
    uint64_t *key = calloc((size_t)cells.n + 1, sizeof *key);
    assert_non_null(key);
    for (int64_t i = 0; i < cells.n; i++)
        for (int k = 0; k < io_cell_type_corners(cells.type[i]); k++) {
            uint64_t bits = 0x9e3779b97f4a7c15u * (uint64_t)(cells.node[cells.offset[i] + k] + 1);
            key[i] += (bits ^ bits >> 29) * 0xbf58476d1ce4e5b9u;
        }
    qsort(key, (size_t)cells.n, sizeof *key, compare_keys);
    *n = cells.n;
    return key;
}

/** Expect the same nodes at the same places, and elements of the same corners. */
static void check_same_mesh(planish_file *a, planish_file *b, int is_near) {
    const planish_mesh p = planish_file_mesh(a), q = planish_file_mesh(b);
    int64_t n, m;
    assert_int_equal(p.dim, q.dim);
    assert_int_equal(p.n_nodes, q.n_nodes);
    for (int64_t i = 0; i < p.dim * p.n_nodes; i++)
        if (fabs(p.coordinates[i] - q.coordinates[i]) >
            (is_near ? 1e-9 : 0) * fabs(p.coordinates[i]))
            fail_msg("coordinate %ld: %.17g and %.17g", (long)i, p.coordinates[i],
                     q.coordinates[i]);
    uint64_t *x = keys_of(a, &n), *y = keys_of(b, &m);
    assert_int_equal(n, m);
    assert_memory_equal(x, y, (size_t)n * sizeof *x);
    free(x);
    free(y);
}

/* ---- all types ------------------------------------------------------------------------------ */

/** Make a legacy VTK file of an element of each type of a dimension, each with its own nodes. */
static planish_file *open_types(const char *folder, int dim) {
    file_builder b = {.binary = 0};
    int n = 0, n_nodes = 0;
    for (int t = 0; t < N_BENT_ELEMENTS; t++) {
        n += bent_elements[t].dim == dim;
        n_nodes += bent_elements[t].dim == dim ? bent_elements[t].n_nodes : 0;
    }
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n");
    builder_text(&b, "POINTS %d double\n", n_nodes);
    for (int t = 0, at = 0; t < N_BENT_ELEMENTS; t++)
        for (int i = 0; i < bent_elements[t].n_nodes && bent_elements[t].dim == dim; i++) {
            double place[3];
            bent_element_place(&bent_elements[t], i, place);
            place[0] += at += 2 * (i == 0);
            for (int d = 0; d < 3; d++)
                builder_real(&b, place[d], 8);
        }
    builder_text(&b, "\nCELLS %d %d\n", n, n + n_nodes);
    for (int t = 0, at = 0; t < N_BENT_ELEMENTS; t++) {
        const int size = bent_elements[t].dim == dim ? bent_elements[t].n_nodes : 0;
        for (int i = -1; i < size && size > 0; i++)
            builder_integer(&b, i < 0 ? size : at++, 4);
    }
    builder_text(&b, "\nCELL_TYPES %d\n", n);
    for (int t = 0; t < N_BENT_ELEMENTS; t++)
        if (bent_elements[t].dim == dim)
            builder_integer(&b, bent_elements[t].type, 4);
    return converting_open_built(folder, "types.vtk", &b);
}

/** Each type of element has its nodes in the right order, or loses the ones that its format lacks. */
static void all_types_are_converted(void **state) {
    for (int dim = 2; dim <= 3; dim++)
        for (int t = 0; t < N_TARGETS; t++) {
            char lost[512];
            int64_t expected[256], found[256];
            int n_lacking = 0;
            if (!is_read(&targets[t]))
                continue;
            planish_file *file = open_types(*state, dim);
            count_types(file, expected);
            assert_int_equal(expected[0], 0);
            for (int k = 0; targets[t].lacks[k][0]; k++) {
                const int64_t n = expected[targets[t].lacks[k][0]];
                n_lacking += n > 0;
                expected[targets[t].lacks[k][1]] += n;
                expected[targets[t].lacks[k][0]] = 0;
            }
            planish_file *copy =
                converting_to(*state, file, targets[t].name, targets[t].extension, lost);
            count_types(copy, found);
            for (int type = 0; type < 256; type++)
                if (expected[type] != found[type])
                    fail_msg("%s, type %d: %ld elements in place of %ld", targets[t].name, type,
                             (long)found[type], (long)expected[type]);
            check_same_mesh(file, copy, targets[t].is_near);
            assert_int_equal(strstr(lost, "elements besides") != NULL, n_lacking > 0);
            planish_file_close(copy);
            planish_file_close(file);
        }
}

/** Lines of second order keep their mids. Straight ones, as in Nastran's files, get those of elements. */
static void lines_are_converted(void **state) {
    for (int t = 0; t < N_TARGETS; t++) {
        file_builder b = {.binary = 0};
        char lost[512];
        if (!is_read(&targets[t]))
            continue;
        builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 "
                         "double\n0 0 0 1 0 0 0 1 0 0.5 0.1 0 0.5 0.5 0 0 0.5 0\n"
                         "CELLS 2 11\n6 0 1 2 3 4 5\n3 0 1 3\nCELL_TYPES 2\n22 21\n");
        planish_file *file = converting_open_built(*state, "lines.vtk", &b);
        planish_file *copy =
            converting_to(*state, file, targets[t].name, targets[t].extension, lost);
        const io_cells *lines = &copy->model.line;
        assert_int_equal(lines->n, 1);
        assert_int_equal(lines->nodes[0], 0);
        assert_int_equal(lines->nodes[1], 1);
        assert_int_equal(lines->mid ? lines->mid[0] : -1, 3);
        planish_file_close(copy);
        planish_file_close(file);
    }
}

/* ---- files of tests/data -------------------------------------------------------------------- */

/** Count the regions that a target has: Exodus has one for each type of elements. */
static int64_t count_regions(planish_file *file, const struct target *target) {
    const int32_t *region = io_file_regions(file);
    planish_cells cells;
    int64_t n = 0;
    if (strcmp(target->name, "exodus") != 0)
        return file->n_regions;
    assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
    for (int64_t i = 0; i < cells.n; i++) {
        int64_t before = 0;
        while (before < i &&
               (cells.type[before] != cells.type[i] || (region && region[before] != region[i])))
            before++;
        n += before == i;
    }
    return n;
}

/** Files of all formats are the same mesh in others, with as many regions. */
static void files_are_converted(void **state) {
    for (const test_data_file *f = test_data_files; f->name; f++) {
        char path[TEST_PATH_SIZE];
        if (!test_data_path(path, f))
            continue;
        planish_file *file = converting_open(path);
        for (int t = 0; t < N_TARGETS; t++) {
            char lost[512];
            if (!is_read(&targets[t]))
                continue;
            planish_file *copy =
                converting_to(*state, file, targets[t].name, targets[t].extension, lost);
            check_same_mesh(file, copy, targets[t].is_near);
            const int64_t n_regions = count_regions(file, &targets[t]);
            if (copy->n_regions != n_regions)
                fail_msg("%s as %s: %ld regions in place of %ld", f->name, targets[t].name,
                         (long)copy->n_regions, (long)n_regions);
            planish_file_close(copy);
        }
        planish_file_close(file);
    }
}

/** Named groups have the same nodes. Abaqus, Exodus and Gmsh have groups of all dimensions, Nastran
 *  names of its properties. */
static void groups_are_converted(void **state) {
    static const char *const names[] = {"skin", "lower part", "upper part"};
    char path[TEST_PATH_SIZE];
    test_path_from(path, "PLANISH_TEST_DATA", "ascii41.msh");
    planish_file *file = converting_open(path);
    const size_t n = (size_t)planish_file_mesh(file).n_nodes;
    for (int t = 0; t < N_TARGETS; t++) {
        char lost[512];
        const int has_names = strncmp(targets[t].name, "gmsh", 4) == 0 || targets[t].is_near ||
                              strcmp(targets[t].name, "exodus") == 0;
        if (!has_names)
            continue;
        planish_file *copy =
            converting_to(*state, file, targets[t].name, targets[t].extension, lost);
        for (int k = 0; k < 3; k++) {
            uint8_t *a = converting_nodes_of(file, names[k]),
                    *b = converting_nodes_of(copy, names[k]);
            assert_memory_equal(a, b, n);
            assert_non_null(memchr(a, 1, n));
            assert_non_null(memchr(a, 0, n));
            free(a);
            free(b);
        }
        planish_file_close(copy);
    }
    planish_file_close(file);
}

/** Sets of nodes stay in Abaqus' files, and are said to be lost in Gmsh's. */
static void sets_of_nodes_are_converted(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "*NODE\n10,0,0,0\n20,1,0,0\n30,0,1,0\n40,0,0,1\n50,1,1,1\n"
                     "*ELEMENT, TYPE=C3D4, ELSET=one\n7,10,20,30,40\n"
                     "*ELEMENT, TYPE=C3D4, ELSET=two\n9,20,30,40,50\n"
                     "*NSET, NSET=\"my nodes\"\n20,50\n*ELSET, ELSET=both\none,two\n");
    planish_file *file = converting_open_built(*state, "sets.inp", &b);
    planish_file *copy = converting_to(*state, file, "abaqus", ".inp", lost);
    static const char *const names[] = {"my nodes", "one", "two", "both"};
    for (int k = 0; k < 4; k++) {
        uint8_t *p = converting_nodes_of(file, names[k]), *q = converting_nodes_of(copy, names[k]);
        assert_memory_equal(p, q, 5);
        free(p);
        free(q);
    }
    assert_int_equal(planish_file_node_number(copy, 4), 50);
    assert_int_equal(planish_file_element_number(copy, 1), 9);
    assert_null(strstr(lost, "groups"));
    planish_file_close(copy);
    copy = converting_to(*state, file, "gmsh", ".msh", lost);
    assert_non_null(strstr(lost, "groups of nodes"));
    assert_int_equal(planish_file_node_number(copy, 4), 50);
    assert_int_equal(planish_file_element_number(copy, 1), 9);
    planish_file_close(copy);
    planish_file_close(file);
}

/** Regions that groups alone tell stay apart, also where the first group is the same. */
static void regions_of_groups_are_converted(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n"
                     "4 0 0 1\n5 1 1 1\n$EndNodes\n$Elements\n3\n1 4 2 7 4 1 2 3 4\n"
                     "2 4 2 7 4 2 3 4 5\n3 4 2 8 4 2 3 4 5\n$EndElements\n");
    planish_file *file = converting_open_built(*state, "regions.msh", &b);
    assert_int_equal(file->n_regions, 2);
    for (int t = 0; t < N_TARGETS; t++) {
        if (!is_read(&targets[t]) || strcmp(targets[t].name, "gmsh22") == 0)
            continue;
        planish_file *copy =
            converting_to(*state, file, targets[t].name, targets[t].extension, lost);
        if (copy->n_regions != 2)
            fail_msg("%s: %ld regions", targets[t].name, (long)copy->n_regions);
        planish_file_close(copy);
    }
    planish_file_close(file);
}

/** Groups of one number have its elements alone, whatever other groups their names have. */
static void names_of_one_number_are_converted(void **state) {
    static const char *const names[] = {"both", "lower", "only"};
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n5\n3 1 \"both\"\n"
                     "3 1 \"both\"\n3 2 \"both\"\n3 1 \"lower\"\n3 1 \"only\"\n"
                     "$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n"
                     "5 1 1 1\n$EndNodes\n$Elements\n2\n1 4 2 1 1 1 2 3 4\n"
                     "2 4 2 2 2 2 3 4 5\n$EndElements\n");
    planish_file *file = converting_open_built(*state, "names.msh", &b);
    planish_file *copy = converting_to(*state, file, "abaqus", ".inp", lost);
    for (int k = 0; k < 3; k++) {
        uint8_t *p = converting_nodes_of(file, names[k]), *q = converting_nodes_of(copy, names[k]);
        assert_memory_equal(p, q, 5);
        assert_int_equal(p[4], k == 0);
        free(p);
        free(q);
    }
    planish_file_close(copy);
    planish_file_close(file);
}

/** Convert three triangles, built as a file called name, to VTU. Expect them to have numbers of groups, and
 *  these words in the file (or, behind '!', not in it). lost: as converting_to. */
static void check_groups_of_vtu(const char *folder, const char *name, const char *text,
                                const double number[3], const char *const *words, char lost[512]) {
    char path[TEST_PATH_SIZE];
    planish_error error;
    planish_data data;
    size_t size;
    test_write(folder, name, text, strlen(text));
    planish_file *file = converting_open(test_path(path, folder, name));
    planish_file *copy = converting_to(folder, file, "vtu", ".vtu", lost);
    if (planish_file_data(copy, "group", &data, &error))
        fail_msg("%s: %s", name, error.text);
    assert_memory_equal(data.values, number, 3 * sizeof *number);
    planish_data_free(&data);
    char *written = test_read(test_path(path, folder, "out-vtu.vtu"), &size);
    for (; *words; words++)
        if ((strstr(written, *words + (**words == '!')) != NULL) != (**words != '!'))
            fail_msg("%s: %s", name, *words);
    free(written);
    planish_file_close(copy);
    planish_file_close(file);
}

/** Groups of one name are one in VTU files, which have one array of a name. Where numbers have other
 *  names, too, they stay apart. */
static void groups_of_one_name_are_joined(void **state) {
    static const char physical[] =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n%s$EndPhysicalNames\n$Nodes\n5\n"
        "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n5 2 1 0\n$EndNodes\n$Elements\n3\n"
        "1 2 2 4 1 1 2 3\n2 2 2 9 2 2 4 3\n3 2 2 5 3 2 5 4\n$EndElements\n";
    static const char *const joined[] = {"Name=\"wall\"", "Name=\"floor\"", "!wall 2:9", NULL};
    static const char *const apart[] = {"Name=\"wall\"", "Name=\"floor\"", "Name=\"wall 2:9\"",
                                        NULL};
    char text[1024], lost[512];
    if (!reading_knows_vtu())
        return;
    snprintf(text, sizeof text, physical, "3\n2 4 \"wall\"\n2 9 \"wall\"\n2 5 \"floor\"\n");
    check_groups_of_vtu(*state, "one.msh", text, (const double[]){4, 4, 5}, joined, lost);
    assert_non_null(strstr(lost, "numbers of groups"));
    snprintf(text, sizeof text, physical, "3\n2 4 \"wall\"\n2 9 \"wall\"\n2 9 \"floor\"\n");
    check_groups_of_vtu(*state, "two.msh", text, (const double[]){4, 9, 5}, apart, lost);
    assert_non_null(strstr(lost, "names of several groups (now with their numbers)"));
    check_groups_of_vtu(*state, "one.bdf",
                        "BEGIN BULK\n$HMNAME PROP                   4\"wall\"\n"
                        "$HMNAME PROP                   9\"wall\"\n"
                        "$HMNAME PROP                   5\"floor\"\n"
                        "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\n"
                        "GRID,4,,1.,1.,0.\nGRID,5,,2.,1.,0.\nCTRIA3,1,4,1,2,3\n"
                        "CTRIA3,2,9,2,4,3\nCTRIA3,3,5,2,5,4\nENDDATA\n",
                        (const double[]){4, 4, 5}, joined, lost);
    assert_non_null(strstr(lost, "numbers of groups"));
}

/** Formats with one name for each element tell which groups they lose. */
static void other_groups_are_told(void **state) {
    static const char *const formats[][2] = {{"obj", ".obj"}, {"stl", ".stl"}, {"nastran", ".bdf"}};
    char lost[512];
    file_builder b = {.binary = 0};
    builder_text(&b, "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,1,1,0\n*ELEMENT, TYPE=S3, ELSET=");
    for (int i = 0; i < 30; i++)
        builder_text(&b, "long_name_");
    builder_text(&b, "\n1,1,2,3\n2,2,4,3\n*ELSET, ELSET=over\n2\n*NSET, NSET=mid\n3\n");
    planish_file *file = converting_open_built(*state, "over.inp", &b);
    for (int t = 0; t < 3; t++) {
        planish_file_close(converting_to(*state, file, formats[t][0], formats[t][1], lost));
        assert_non_null(strstr(lost, "groups of nodes"));
        assert_non_null(strstr(lost, "all but the first group of elements that are in several"));
        assert_non_null(strstr(lost, "the ends of names of more than 256 bytes"));
    }
    planish_file_close(file);
}

/** VTK's formats have one number of each cell, and none of nodes, but the names of all. */
static void groups_beside_arrays_are_told(void **state) {
    for (int t = 0; t < 2; t++)
        for (int is_lost = 0; is_lost < 2; is_lost++) {
            char lost[512];
            file_builder b = {.binary = 0};
            if (!is_read(&targets[t]))
                continue;
            builder_text(&b,
                         "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,1,1,0\n*ELEMENT, TYPE=S3, "
                         "ELSET=all\n1,1,2,3\n2,2,4,3\n%s",
                         is_lost ? "*ELSET, ELSET=over\n2\n*NSET, NSET=mid\n3\n" : "");
            planish_file *file = converting_open_built(*state, "over.inp", &b);
            planish_file_close(
                converting_to(*state, file, targets[t].name, targets[t].extension, lost));
            assert_int_equal(strstr(lost, "groups of nodes") != NULL, is_lost);
            assert_int_equal(strstr(lost, "all but the first group") != NULL, is_lost);
            planish_file_close(file);
        }
}

/** References of vertices stay in Medit's and Exodus' files alone; others tell it. */
static void references_of_nodes_are_told(void **state) {
    static const char *const formats[][3] = {
        {"vtk", ".vtk", "lost"}, {"abaqus", ".inp", "lost"}, {"nastran", ".bdf", "lost"},
        {"obj", ".obj", "lost"}, {"ply", ".ply", "lost"},    {"medit", ".mesh", ""},
        {"exodus", ".e", ""}};
    for (size_t t = 0; t < sizeof formats / sizeof *formats; t++)
        for (int reference = 0; reference < 2; reference++) {
            char lost[512];
            file_builder b = {.binary = 0};
            builder_text(&b,
                         "MeshVersionFormatted 2\nDimension 3\nVertices\n3\n0 0 0 0\n1 0 0 0\n"
                         "0 1 1 %d\nTriangles\n1\n1 2 3 1\nEnd\n",
                         reference);
            planish_file *file = converting_open_built(*state, "node.mesh", &b);
            planish_file_close(converting_to(*state, file, formats[t][0], formats[t][1], lost));
            assert_int_equal(strstr(lost, "references of nodes") != NULL,
                             *formats[t][2] && reference);
            planish_file_close(file);
        }
}

/** Groups of Gmsh's points are references and sets of nodes; points in none are no loss of these. */
static void groups_of_points_are_converted(void **state) {
    char lost[512];
    file_builder b = {.binary = 0};
    builder_text(
        &b,
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n0 5 \"pin\"\n$EndPhysicalNames\n"
        "$Nodes\n3\n1 0 0 0\n2 1 0 0\n3 0 1 0\n$EndNodes\n$Elements\n3\n1 15 2 5 11 1\n"
        "2 15 2 0 12 2\n3 2 2 1 1 1 2 3\n$EndElements\n");
    planish_file *file = converting_open_built(*state, "pin.msh", &b);
    planish_file *out = converting_to(*state, file, "medit", ".mesh", lost);
    assert_int_equal(out->model.entity[out->model.node_entity[0]].tag, 5);
    assert_int_equal(out->model.entity[out->model.node_entity[1]].tag, 0);
    planish_file_close(out);
    out = converting_to(*state, file, "abaqus", ".inp", lost);
    reading_holds(out, "pin", 0, "100");
    assert_null(strstr(lost, "references of nodes"));
    planish_file_close(out);
    planish_file_close(file);
}

/** Groups without names have their numbers, if all of their elements are one entity; else formats without
 *  groups tell that these are lost. */
static void numbers_of_groups_are_told(void **state) {
    static const char *const formats[][2] = {{"abaqus", ".inp"}, {"nastran", ".bdf"},
                                             {"exodus", ".e"},   {"medit", ".mesh"},
                                             {"obj", ".obj"},    {"gmsh22", ".msh"}};
    for (size_t t = 0; t < sizeof formats / sizeof *formats; t++)
        for (int n = 1; n <= 2; n++) {
            char lost[512];
            file_builder b = {.binary = 0};
            builder_text(&b,
                         "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n"
                         "3 0 1 1\n4 1 1 0\n$EndNodes\n$Elements\n2\n1 2 2 100 1 1 2 3\n"
                         "2 2 2 100 %d 2 4 3\n$EndElements\n",
                         n);
            planish_file *file = converting_open_built(*state, "number.msh", &b);
            planish_file_close(converting_to(*state, file, formats[t][0], formats[t][1], lost));
            assert_int_equal(strstr(lost, "numbers of groups") != NULL, n == 2 && t < 5);
            planish_file_close(file);
        }
}

/** Numbers of regions that formats cannot have, or that others have, are told; all others stay. */
static void numbers_of_regions_are_told(void **state) {
    static const struct {
        const char *format, *extension;
        int tetrahedra, triangles; /* numbers, of which a format tells that they change */
        int are_lost;
        const char *words;
    } cases[] = {{"nastran", ".bdf", 7, 5, 0, "       7       1"},
                 {"nastran", ".bdf", 7, 7, 1, "CTRIA3         2       1"},
                 {"nastran", ".bdf", 1, 1, 1, "CTETRA         1       1"},
                 {"nastran", ".bdf", -3, 5, 1, "CTRIA3         2       5"},
                 {"nastran", ".bdf", 0, 5, 0, "CTRIA3         2       5"},
                 {"abaqus", ".inp", 7, 5, 0, "VOLUME7"},
                 {"abaqus", ".inp", -3, 5, 1, "SURFACE5"},
                 {"exodus", ".e", 7, 5, 0, "CDF"},
                 {"exodus", ".e", -3, 5, 1, "CDF"},
                 {"exodus", ".e", 7, -5, 1, "CDF"}};
    for (size_t t = 0; t < sizeof cases / sizeof *cases; t++) {
        char lost[512], path[TEST_PATH_SIZE], name[32];
        file_builder b = {.binary = 0};
        builder_text(&b,
                     "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n"
                     "0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 %d\nTriangles\n1\n1 2 3 %d\nEnd\n",
                     cases[t].tetrahedra, cases[t].triangles);
        planish_file *file = converting_open_built(*state, "regions.mesh", &b);
        planish_file_close(converting_to(*state, file, cases[t].format, cases[t].extension, lost));
        if ((strstr(lost, "numbers of regions") != NULL) != cases[t].are_lost)
            fail_msg("case %zu: %s", t, lost);
        snprintf(name, sizeof name, "out-%s%s", cases[t].format, cases[t].extension);
        char *written = test_read(test_path(path, *state, name), NULL);
        if (!strstr(written, cases[t].words))
            fail_msg("case %zu: %s", t, cases[t].words);
        free(written);
        planish_file_close(file);
    }
}

/** Formats whose names stand between quotes tell those within a name. */
static void quotes_are_told(void **state) {
    static const char *const formats[][2] = {{"abaqus", ".inp"}, {"nastran", ".bdf"}};
    for (int t = 0; t < 2; t++)
        for (int is_lost = 0; is_lost < 2; is_lost++) {
            char lost[512];
            file_builder b = {.binary = 0};
            builder_text(&b,
                         "NDIME= 2\nNELEM= 1\n5 0 1 2\nNPOIN= 3\n0 0\n1 0\n0 1\nNMARK= 1\n"
                         "MARKER_TAG= a %sb\nMARKER_ELEMS= 1\n3 0 1\n",
                         is_lost ? "\"" : "");
            planish_file *file = converting_open_built(*state, "quotes.su2", &b);
            planish_file_close(converting_to(*state, file, formats[t][0], formats[t][1], lost));
            assert_int_equal(strstr(lost, "quotes and control characters (now '_') in the names "
                                          "of 1 group") != NULL,
                             is_lost);
            planish_file_close(file);
        }
}

/** Sets of Abaqus have the references of regions, and numbers behind these without one. */
static void sets_have_references(void **state) {
    static const char *const names[] = {"VOLUME70", "VOLUME9", "VOLUME73"};
    char lost[512];
    file_builder b = {.binary = 0};
    builder_text(&b, "MeshVersionFormatted 2\nDimension 3\nVertices\n6\n0 0 0 0\n1 0 0 0\n"
                     "0 1 0 0\n0 0 1 0\n1 1 1 0\n2 2 2 0\nTetrahedra\n3\n1 2 3 4 70\n2 3 4 5 9\n"
                     "3 4 5 6 0\nEnd\n");
    planish_file *file = converting_open_built(*state, "references.mesh", &b);
    planish_file *copy = converting_to(*state, file, "abaqus", ".inp", lost);
    for (int i = 0; i < 3; i++) {
        uint8_t *nodes = converting_nodes_of(copy, names[i]);
        for (int k = 0; k < 6; k++)
            assert_int_equal(nodes[k], k >= i && k < i + 4);
        free(nodes);
    }
    planish_file_close(copy);
    planish_file_close(file);
}

/** Formats of surfaces tell that they have no other nodes, and names of one word. */
static void surfaces_tell_nodes_and_blanks(void **state) {
    static const char *const formats[][2] = {{"ply", ".ply"}, {"stl", ".stl"}, {"obj", ".obj"}};
    for (int t = 0; t < 3; t++)
        for (int is_lost = 0; is_lost < 2; is_lost++) {
            char lost[512];
            file_builder b = {.binary = 0};
            builder_text(&b,
                         "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,1\n4,1,1,0\n%s*ELEMENT, TYPE=S3, "
                         "ELSET=\"%s\"\n1,1,2,3\n*ELEMENT, TYPE=S3, ELSET=a_b\n2,2,4,3\n",
                         is_lost ? "5,1,1,1\n" : "", is_lost ? "a b" : "c");
            planish_file *file = converting_open_built(*state, "names.inp", &b);
            planish_file_close(converting_to(*state, file, formats[t][0], formats[t][1], lost));
            assert_int_equal(strstr(lost, "1 nodes that are corners of no facet") != NULL, is_lost);
            assert_int_equal(strstr(lost, "blanks and control characters (now '_') in the names "
                                          "of 1 group") != NULL,
                             is_lost && t > 0);
            planish_file_close(file);
        }
}

/** What no conversion carries over is told by the words of the file: of Nastran all other cards, but those
 *  of the mesh. */
static void cards_are_told(void **state) {
    char lost[512];
    file_builder b = {.binary = 0};
    builder_text(&b, "SOL 101\nCEND\nBEGIN BULK\n$ MAT9\nmat1,1,2.1+11,,.3\nPSOLID,1,1\n"
                     "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\n"
                     "CTETRA,1,1,1,2,3,4\nCTRIA3,2,2,1,2,3\nCONM2,3,1,,4.\nMAT1,2,2.1+11,,.3\n");
    builder_text(&b, "RBE2,9,1,123,2,3,\n,4\nSPC1,1,123,1\nFORCE,1,2,,1.,1.,0.,0.\n"
                     "GRAV,1,,9.8,0.,0.,1.\nBSURF,1,1\nENDDATA\nMAT8,1\n");
    planish_file *file = converting_open_built(*state, "deck.bdf", &b);
    planish_file_close(converting_to(*state, file, "gmsh", ".msh", lost));
    assert_string_equal(lost, "GRAV, BSURF, MAT1, PSOLID, CONM2, RBE2, SPC1, FORCE, 1 elements of "
                              "other types, parameters and comments");
    planish_file_close(file);
}

/** Expect what is lost of a file with data, and that words are not among it if it has none. */
static void check_passed_over(const char *folder, const char *name, const char *text, size_t size,
                              const char *words) {
    char path[TEST_PATH_SIZE], lost[512], expected[600];
    test_write(folder, name, text, size);
    planish_file *file = converting_open(test_path(path, folder, name));
    planish_file_close(converting_to(folder, file, "gmsh", ".msh", lost));
    snprintf(expected, sizeof expected, "%sparameters and comments", words);
    assert_string_equal(lost, expected);
    planish_file_close(file);
}

/** Colours, normals, attributes and data of formats that planish does not read them of. */
static void passed_over_data_are_told(void **state) {
    static const struct {
        const char *name, *text, *words;
    } files[] = {
        {"a.avs", "3 1 0 0 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 1 tri 1 2 3\n", ""},
        {"b.avs",
         "3 1 1 1 0\n1 0 0 0\n2 1 0 0\n3 0 1 0\n1 1 tri 1 2 3\n1 1\nt, K\n1 1\n2 1\n3 1\n"
         "1 1\ns, Pa\n1 5\n",
         "data of nodes, data of elements, "},
        {"a.off", "OFF\n3 1 0\n0 0 0 # c\n1 0 0\n0 1 0\n3 0 1 2 # 5\n", ""},
        {"b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n", "colours of faces, "},
        {"c.off", "COFF\n3 1 0\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 1 1 1 1\n3 0 1 2\n",
         "normals or colours of vertices, "},
        {"d.off", "OFF\n3 1 0\n0 0 0\n1 0 0 9\n0 1 0\n3 0 1 2\n",
         "normals or colours of vertices, "},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_index\n"
         "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
         ""},
        {"b.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nproperty uchar red\nelement face 1\n"
         "property list uchar int vertex_index\nproperty int mat\nelement material 1\n"
         "property int a\nend_header\n0 0 0 9\n1 0 0 9\n0 1 0 9\n3 0 1 2 1\n7\n",
         "properties of vertices, properties of faces, elements 'material', "},
        {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\n",
         "texture coordinates, normals of vertices, "},
        {"a.node", "3 2 1 0\n1 0 0 7\n2 1 0 7\n3 0 1 7\n", "attributes of nodes, "},
        {"b.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n", "attributes of elements, "},
        {"c.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n", ""},
    };
    test_write(*state, "a.ele", "1 3 1\n1 1 2 3 5\n", 16);
    test_write(*state, "b.ele", "1 3 1\n1 1 2 3 .5\n", 17);
    test_write(*state, "c.ele", "1 3 1\n1 1 2 3 5\n", 16);
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        check_passed_over(*state, files[i].name, files[i].text, strlen(files[i].text),
                          files[i].words);
}

/** The same of binary files: STL's, and AVS UCD's. */
static void passed_over_bytes_are_told(void **state) {
    static const int corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    for (int has_data = 0; has_data < 2; has_data++) {
        file_builder stl = {.binary = 1, .swapped = !io_machine_is_little()}, ucd = stl;
        for (int i = 0; i < 80; i++)
            builder_integer(&stl, 0, 1);
        builder_integer(&stl, 1, 4);
        for (int i = 0; i < 12; i++)
            builder_real(&stl, i < 3 ? i == 2 : corners[i - 3], 4);
        builder_integer(&stl, has_data << 8, 2);
        check_passed_over(*state, "x.stl", stl.data, (size_t)stl.size,
                          has_data ? "colours of facets, " : "");
        builder_release(&stl);
        const int whole[] = {3, 1, has_data, 0, 0, 3, 1, 1, 3, 2, 1, 2, 3};
        builder_integer(&ucd, 7, 1);
        for (int i = 0; i < 13; i++)
            builder_integer(&ucd, whole[i], 4);
        for (int i = 0; i < 9; i++)
            builder_real(&ucd, corners[i % 3 * 3 + i / 3], 4);
        check_passed_over(*state, "x.ucd", ucd.data, (size_t)ucd.size,
                          has_data ? "data of nodes, " : "");
        builder_release(&ucd);
    }
}

/** Of Medit all keywords but those of the mesh, unless there are none of what they list. */
static void keywords_are_told(void **state) {
    char lost[512];
    file_builder b = {.binary = 0};
    builder_text(&b, "MeshVersionFormatted 2\n# Comment\nDimension 3\nVertices\n4\n0 0 0 0\n"
                     "1 0 0 0\n0 1 0 0\n0 0 1 0\nTetrahedra\n1\n1 2 3 4 1\nEdges\n1\n1 2 1\n"
                     "Ridges\n1\n1\nRequiredEdges\n1\n1\nRequiredVertices\n1\n3\n");
    builder_text(&b, "Corners\n1\n1\nRequiredTriangles\n0\nTangents\n0\nNormals\n1\n1 0 0\n"
                     "Ridges\n1\n1\nEnd\nBehind\n1\n");
    planish_file *file = converting_open_built(*state, "words.mesh", &b);
    planish_file_close(converting_to(*state, file, "medit", ".mesh", lost));
    assert_string_equal(lost, "Ridges, RequiredEdges, Corners, Normals, parameters and comments");
    planish_file_close(file);
}

/** Numbers that are not distinct, or 0, are given anew. */
static void numbers_begin_at_1(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "OFF\n4 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n");
    planish_file *file = converting_open_built(*state, "zero.off", &b);
    planish_file *copy = converting_to(*state, file, "gmsh22", ".msh", lost);
    assert_int_equal(planish_file_node_number(file, 0), 0);
    assert_int_equal(planish_file_node_number(copy, 0), 1);
    assert_int_equal(planish_file_element_number(copy, 1), 2);
    planish_file_close(copy);
    planish_file_close(file);
}

/** Many regions are sorted in little time, and cells of several regions in turn keep theirs. */
static void regions_in_turn_are_converted(void **state) {
    enum { N = 3000 };
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "MeshVersionFormatted 2\nDimension 3\nVertices\n%d\n", 4 * N);
    for (int i = 0; i < N; i++)
        builder_text(&b, "%d 0 0 0 %d.5 0 0 0 %d 1 0 0 %d 0 1 0\n", 2 * i, 2 * i, 2 * i, 2 * i);
    builder_text(&b, "Tetrahedra\n%d\n", N);
    for (int i = 0; i < N; i++)
        builder_text(&b, "%d %d %d %d %d\n", 4 * i + 1, 4 * i + 2, 4 * i + 3, 4 * i + 4,
                     1 + i * 7 % (N / 2));
    builder_text(&b, "End\n");
    planish_file *file = converting_open_built(*state, "regions.mesh", &b);
    for (int t = 2; t < N_TARGETS; t++) {
        planish_file *copy =
            converting_to(*state, file, targets[t].name, targets[t].extension, lost);
        assert_int_equal(copy->n_regions, N / 2);
        planish_file_close(copy);
    }
    planish_file_close(file);
}

/* ---- data ----------------------------------------------------------------------------------- */

/** Arrays of nodes and elements go from VTK's files to Gmsh's and back. */
static void data_are_converted(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 5 double\n0 0 0 1 0 0 0 1 0 0 0 1 1 1 1\n"
                     "CELLS 3 14\n4 0 1 2 3\n4 1 2 3 4\n3 0 1 2\nCELL_TYPES 3\n10 10 5\n");
    builder_text(&b, "POINT_DATA 5\nSCALARS heat double\nLOOKUP_TABLE default\n1 2.5 nan -4 5e300\n"
                     "VECTORS flow float\n1 2 3 4 5 6 7 8 9 10 11 12 13 14 15\n");
    builder_text(
        &b, "CELL_DATA 3\nFIELD f 2\nstress 6 3 double\n1 2 3 4 5 6 7 8 9 10 11 12 0 0 0 0 0 0\n"
            "my%%20id 1 3 int\n7 9 8\n");
    planish_file *file = converting_open_built(*state, "data.vtk", &b);
    planish_file *msh = converting_to(*state, file, "gmsh", ".msh", lost);
    assert_non_null(strstr(lost, "data of elements of lower dimensions"));
    planish_file *vtk = converting_to(*state, msh, "vtk", ".vtk", lost);
    planish_file *direct = converting_to(*state, file, "vtk", ".vtk", lost);
    static const char *const names[] = {"flow", "my id"};
    for (int k = 0; k < 2; k++) {
        planish_data p, q;
        assert_int_equal(planish_file_data(file, names[k], &p, NULL), 0);
        assert_int_equal(planish_file_data(vtk, names[k], &q, NULL), 0);
        assert_int_equal(p.n_components, q.n_components);
        assert_memory_equal(p.values, q.values, (size_t)(p.n * p.n_components) * sizeof(double));
        planish_data_free(&p);
        planish_data_free(&q);
    }
    planish_data p, q, nine;
    assert_int_equal(planish_file_data(file, "stress", &p, NULL), 0);
    assert_int_equal(planish_file_data(direct, "stress", &q, NULL), 0);
    assert_memory_equal(p.values, q.values, 12 * sizeof(double));
    assert_int_equal(planish_file_data(msh, "stress", &nine, NULL), 0);
    assert_int_equal(nine.n_components, 9);
    static const int place[] = {0, 1, 4, 2, 5, 8}; /* of 11 12 22 13 23 33 in rows of three */
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 6; k++)
            assert_true(nine.values[9 * i + place[k]] == p.values[6 * i + k]);
    planish_data_free(&p);
    planish_data_free(&q);
    planish_data_free(&nine);
    /* Values that are no numbers stay what they are. */
    planish_data heat;
    planish_error error;
    assert_int_equal(io_file_read_data(vtk, "heat", 0, &heat, &error), 0);
    assert_true(heat.values[1] == 2.5 && isnan(heat.values[2]) && heat.values[4] == 5e300);
    planish_data_free(&heat);
    planish_file_close(direct);
    planish_file_close(vtk);
    planish_file_close(msh);
    planish_file_close(file);
}

/** An array of the file whose name planish needs for its own is said to be lost. */
static void own_names_are_lost(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\n"
                     "CELL_TYPES 1\n10\n");
    builder_text(&b,
                 "POINT_DATA 4\nFIELD f 2\nnumber 1 4 int\n9 8 7 6\nheat 1 4 double\n1 2 3 4\n");
    planish_file *file = converting_open_built(*state, "own.vtk", &b);
    planish_file *copy = converting_to(*state, file, "vtk", ".vtk", lost);
    assert_non_null(strstr(lost, "the file's own array 'number'"));
    assert_null(strstr(lost, "heat"));
    planish_file_close(copy);
    planish_file_close(file);
}

/** Whole numbers beyond what a double holds exactly become numbers of any size, and that is said. */
static void large_integers_are_told(void **state) {
    file_builder b = {.binary = 0};
    char lost[512];
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 5\n4 0 1 2 3\n"
                     "CELL_TYPES 1\n10\nPOINT_DATA 4\nFIELD f 2\n");
    builder_text(&b, "exact 1 4 long\n9007199254740992 -9007199254740991 0 1\n"
                     "large 1 4 unsigned_long\n18446744073709551615 9223372036854775808 1 0\n");
    planish_file *file = converting_open_built(*state, "large.vtk", &b);
    static const char *const kinds[][2] = {{"vtk", ".vtk"}, {"vtu", ".vtu"}, {"gmsh", ".msh"}};
    for (int t = 0; t < 3; t++) {
        planish_file *copy = converting_to(*state, file, kinds[t][0], kinds[t][1], lost);
        assert_non_null(strstr(lost, "the last digits of the array 'large'"));
        assert_null(strstr(lost, "exact"));
        planish_data exact, large;
        assert_int_equal(planish_file_data(copy, "exact", &exact, NULL), 0);
        assert_int_equal(planish_file_data(copy, "large", &large, NULL), 0);
        assert_true(exact.values[0] == 0x1p53 && exact.values[1] == 1 - 0x1p53);
        assert_true(large.values[0] == 0x1p64 && large.values[1] == 0x1p63 && large.values[2] == 1);
        planish_data_free(&exact);
        planish_data_free(&large);
        planish_file_close(copy);
    }
    planish_file_close(file);
}

/* ---- negative solids ------------------------------------------------------------------------ */

/** Solids that all are the other way round, as TetGen's, become positive; one of many stays. */
static void negative_solids_are_mirrored(void **state) {
    char path[TEST_PATH_SIZE], lost[512];
    test_path_from(path, "PLANISH_TEST_DATA", "tetgen.node");
    planish_file *file = converting_open(path);
    for (int t = 2; t < N_TARGETS; t++) {
        int64_t n_negative = 0;
        planish_file *copy =
            converting_to(*state, file, targets[t].name, targets[t].extension, lost);
        const planish_mesh mesh = planish_file_mesh(copy);
        for (int64_t i = 0; i < mesh.n_elements; i++) {
            double x[4][3];
            for (int k = 0; k < 4; k++)
                for (int d = 0; d < 3; d++)
                    x[k][d] =
                        mesh.coordinates[3 * mesh.elements[4 * i + k] + d] - (k > 0 ? x[0][d] : 0);
            n_negative += x[1][0] * (x[2][1] * x[3][2] - x[2][2] * x[3][1]) +
                              x[1][1] * (x[2][2] * x[3][0] - x[2][0] * x[3][2]) +
                              x[1][2] * (x[2][0] * x[3][1] - x[2][1] * x[3][0]) <
                          0;
        }
        assert_int_equal(n_negative, 0);
        planish_file_close(copy);
    }
    planish_file_close(file);
}

/** VTK's formats keep the order of nodes, and tell where volumes are negative by it. */
static void negative_solids_are_told(void **state) {
    for (int t = 0; t < N_TARGETS; t++)
        for (int is_negative = 0; is_negative < 2; is_negative++) {
            char lost[512];
            file_builder b = {.binary = 0};
            if (!is_read(&targets[t]))
                continue;
            builder_text(&b,
                         "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0\n1 0 0 0\n"
                         "0 1 0 0\n0 0 1 0\nTetrahedra\n1\n%s 1\nEnd\n",
                         is_negative ? "1 2 4 3" : "1 2 3 4");
            planish_file *file = converting_open_built(*state, "negative.mesh", &b);
            planish_file_close(
                converting_to(*state, file, targets[t].name, targets[t].extension, lost));
            assert_int_equal(strstr(lost, "positive volumes of 1 solids") != NULL,
                             is_negative && t < 2);
            planish_file_close(file);
        }
}

/** VTK's wedges are negative by the rule of the other solids. */
static void wedges_of_vtk_are_no_loss(void **state) {
    char lost[512];
    file_builder b = {.binary = 0};
    builder_text(&b, "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 6 "
                     "double\n0 0 0 0 1 0 1 0 0 0 0 1 0 1 1 1 0 1\nCELLS 1 7\n6 0 1 2 3 4 5\n"
                     "CELL_TYPES 1\n13\n");
    planish_file *file = converting_open_built(*state, "wedge.vtk", &b);
    planish_file_close(converting_to(*state, file, "vtk", ".vtk", lost));
    assert_string_equal(lost, "parameters and comments");
    planish_file_close(file);
}

/* ---- surfaces ------------------------------------------------------------------------------- */

/** STL, OBJ and PLY have the facets of a mesh, by their groups, and no other nodes. */
static void surfaces_are_converted(void **state) {
    static const struct {
        const char *name, *extension;
        int n_elements; /* of two triangles and a quadrilateral */
        int n_regions;
    } formats[] = {{"stl", ".stl", 4, 2}, {"obj", ".obj", 3, 2}, {"ply", ".ply", 3, 1}};
    for (int k = 0; k < 3; k++) {
        file_builder b = {.binary = 0};
        char lost[512];
        builder_text(&b, "MeshVersionFormatted 2\nDimension 3\nVertices\n7\n9 9 9 0\n0 0 0.1 0\n"
                         "1 0 0 0\n1 1 0.3 0\n0 1 0 0\n2 0 0 0\n2 1 0.7 0\nTriangles\n2\n"
                         "2 3 4 1\n2 4 5 1\nQuadrilaterals\n1\n3 6 7 4 2\nEdges\n1\n2 3 9\nEnd\n");
        planish_file *file = converting_open_built(*state, "surface.mesh", &b);
        planish_file *copy =
            converting_to(*state, file, formats[k].name, formats[k].extension, lost);
        const planish_mesh mesh = planish_file_mesh(copy);
        assert_int_equal(mesh.n_nodes, 6);
        assert_int_equal(mesh.n_elements, formats[k].n_elements);
        assert_non_null(strstr(lost, "1 solid elements and lines"));
        assert_int_equal(copy->n_regions, formats[k].n_regions);
        planish_file_close(copy);
        planish_file_close(file);
    }
}

/* ---- refusals ------------------------------------------------------------------------------- */

static void wrong_targets_are_refused(void **state) {
    char data[TEST_PATH_SIZE], path[TEST_PATH_SIZE];
    planish_error error;
    test_path_from(data, "PLANISH_TEST_DATA", "tetgen.node");
    planish_file *file = converting_open(data);
    const double *x = planish_file_mesh(file).coordinates;
    const int before = test_count_files(*state);
    const planish_convert_options wrong = {.format = "vrml"};
    assert_int_equal(
        planish_file_convert(file, test_path(path, *state, "a.vtk"), x, &wrong, &error),
        PLANISH_ERROR_ARGUMENT);
    assert_non_null(
        strstr(error.text, "planish cannot convert to the format 'vrml'; it converts to"));
    assert_int_equal(planish_file_convert(file, test_path(path, *state, "a.xyz"), x, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "the extension is of no format"));
    /* TetGen's file has faces; one of solids alone has no surface. */
    file_builder b = {.binary = 0};
    builder_text(&b, "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n0 0 0 0 1 0 0 0 0 1 0 0 0 "
                     "0 1 0\nTetrahedra\n1\n1 2 3 4 0\nEnd\n");
    planish_file *solid = converting_open_built(*state, "solid.mesh", &b);
    assert_int_equal(planish_file_convert(solid, test_path(path, *state, "a.stl"),
                                          planish_file_mesh(solid).coordinates, NULL, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "has no triangles or quadrilaterals"));
    assert_int_equal(test_count_files(*state), before + 1);
    planish_file_close(solid);
    planish_file_close(file);
}

/** What a conversion refuses is known before it, without a file. */
static void conversions_are_checked_before(void **state) {
    static const struct {
        const char *path, *format, *word; /* word: of the error, or NULL: there is none */
    } cases[] = {
        {"a.vtu", NULL, NULL},
        {"a", "gmsh", NULL},
        {"a.stl", NULL, "no triangles"},
        {"a", "ply", "no triangles"},
        {"a.mesh", NULL, NULL},
        {"a.MESHB", "medit", ".mesh"},
        {"a.meshb", NULL, "the extension"},
        {"a.vtu", "none", "cannot convert"},
    };
    char from[TEST_PATH_SIZE];
    (void)state;
    test_path_from(from, "PLANISH_TEST_DATA", "tetgen.node");
    planish_file *file = converting_open(from);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        planish_error error = {.text = ""};
        const int status =
            planish_file_check_conversion(file, cases[i].path, cases[i].format, &error);
        assert_int_equal(status, cases[i].word ? PLANISH_ERROR_ARGUMENT : PLANISH_OK);
        if (cases[i].word)
            assert_non_null(strstr(error.text, cases[i].word));
    }
    assert_int_equal(planish_file_check_conversion(NULL, "a.vtu", NULL, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_check_conversion(file, NULL, NULL, NULL), PLANISH_ERROR_ARGUMENT);
    planish_file_close(file);
}

/** Coordinates that are no numbers are not written: Nastran would have zeros for them. */
static void coordinates_must_be_finite(void **state) {
    char path[TEST_PATH_SIZE], from[TEST_PATH_SIZE];
    test_path_from(from, "PLANISH_TEST_DATA", "tetgen.node");
    planish_file *file = converting_open(from);
    const planish_mesh mesh = planish_file_mesh(file);
    double *x = planish_file_coordinates(file);
    for (int k = 0; k < 2; k++) {
        x[3 * mesh.n_nodes - 1] = k ? INFINITY : NAN;
        for (int t = 0; t < N_TARGETS; t++) {
            planish_error error;
            char name[64];
            snprintf(name, sizeof name, "wrong%s", targets[t].extension);
            test_path(path, *state, name);
            assert_int_equal(planish_file_convert(file, path, x, NULL, &error),
                             PLANISH_ERROR_ARGUMENT);
            assert_int_equal(error.node, mesh.n_nodes - 1);
            assert_null(fopen(path, "rb"));
        }
    }
    planish_file_close(file);
}

/** The names of all targets are known; the first of a format is found by its extension. */
static void targets_are_named(void **state) {
    (void)state;
    int n = 0;
    for (const char *name; (name = planish_file_target(n)); n++)
        assert_true(strlen(name) > 0);
    assert_int_equal(n, N_TARGETS + 3);
    assert_null(planish_file_target(-1));
    assert_string_equal(planish_file_target_of("a/b.MSH"), "gmsh");
    assert_null(planish_file_target_of("a.med"));
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(all_types_are_converted),
        IN_A_FOLDER(lines_are_converted),
        IN_A_FOLDER(files_are_converted),
        IN_A_FOLDER(groups_are_converted),
        IN_A_FOLDER(sets_of_nodes_are_converted),
        IN_A_FOLDER(regions_of_groups_are_converted),
        IN_A_FOLDER(names_of_one_number_are_converted),
        IN_A_FOLDER(groups_of_one_name_are_joined),
        IN_A_FOLDER(other_groups_are_told),
        IN_A_FOLDER(groups_beside_arrays_are_told),
        IN_A_FOLDER(references_of_nodes_are_told),
        IN_A_FOLDER(groups_of_points_are_converted),
        IN_A_FOLDER(numbers_of_groups_are_told),
        IN_A_FOLDER(numbers_of_regions_are_told),
        IN_A_FOLDER(quotes_are_told),
        IN_A_FOLDER(sets_have_references),
        IN_A_FOLDER(surfaces_tell_nodes_and_blanks),
        IN_A_FOLDER(cards_are_told),
        IN_A_FOLDER(keywords_are_told),
        IN_A_FOLDER(passed_over_data_are_told),
        IN_A_FOLDER(passed_over_bytes_are_told),
        IN_A_FOLDER(numbers_begin_at_1),
        IN_A_FOLDER(regions_in_turn_are_converted),
        IN_A_FOLDER(data_are_converted),
        IN_A_FOLDER(own_names_are_lost),
        IN_A_FOLDER(large_integers_are_told),
        IN_A_FOLDER(negative_solids_are_mirrored),
        IN_A_FOLDER(negative_solids_are_told),
        IN_A_FOLDER(wedges_of_vtk_are_no_loss),
        IN_A_FOLDER(surfaces_are_converted),
        IN_A_FOLDER(wrong_targets_are_refused),
        cmocka_unit_test(conversions_are_checked_before),
        IN_A_FOLDER(coordinates_must_be_finite),
        cmocka_unit_test(targets_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
