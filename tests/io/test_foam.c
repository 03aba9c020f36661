/* OpenFOAM's meshes: every encoding, elements from faces, patches and zones, damage. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/foam_builder.h"
#include "support/unit_elements.h"

#include "io/file/file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static const foam_form ascii = {.label_size = 4, .scalar_size = 8};
static const char *const one_patch[] = {"all wall", NULL};

static int on_one(const double *middle) {
    (void)middle;
    return 0;
}

static planish_file *open_at(const char *folder, int threads) {
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open(folder, NULL, threads, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/** Opening must fail with an error that has all of these texts (NULL: fewer). */
static void open_fails(const char *folder, const char *about, const char *word) {
    planish_file *file = NULL;
    planish_error error;
    assert_true(planish_file_open(folder, NULL, 1, &file, &error) < 0);
    assert_null(file);
    if (!strstr(error.text, about) || !strstr(error.text, word))
        fail_msg("'%s' is not about %s and '%s'", error.text, about, word);
}

/** Replace the first place of a text in a file. */
static void replace(const char *folder, const char *name, const char *old, const char *new) {
    char path[TEST_PATH_SIZE];
    size_t size;
    char *data = test_read(test_path(path, folder, name), &size);
    char *at = strstr(data, old);
    if (!at)
        fail_msg("there is no '%s' in %s", old, name);
    const size_t before = (size_t)(at - data), length = strlen(new);
    const size_t behind = size - before - strlen(old);
    char *text = malloc(size + length);
    memcpy(text, data, before);
    memcpy(text + before, new, length);
    memcpy(text + before + length, at + strlen(old), behind);
    test_write(folder, name, text, before + length + behind);
    free(text);
    free(data);
}

/** Three layers of bricks, wedges among them. */
static foam_cells *make_mixed(void) {
    foam_cells *cells = malloc(sizeof *cells);
    assert_non_null(cells);
    foam_make_bricks(cells, 3, 3, 3);
    for (int k = 0; k < 3; k++)
        foam_split_brick(cells, 9 * k + 4);
    return cells;
}

static int compare(const void *a, const void *b) {
    return *(const int32_t *)a - *(const int32_t *)b;
}

/** Check that an element is that cell: of its type, with its nodes, in any order. */
static void expect_cell(const planish_cells *read, int64_t i, const foam_cells *cells,
                        int64_t cell) {
    const int64_t begin = read->offset[i], n = read->offset[i + 1] - begin;
    int32_t found[8], wanted[8];
    assert_int_equal(read->type[i], cells->type[cell]);
    for (int64_t k = 0; k < n; k++) {
        found[k] = read->node[begin + k];
        wanted[k] = cells->node[cell][k];
    }
    qsort(found, (size_t)n, sizeof *found, compare);
    qsort(wanted, (size_t)n, sizeof *wanted, compare);
    assert_memory_equal(found, wanted, (size_t)n * sizeof *found);
}

/* ---- encodings ------------------------------------------------------------------------------ */

static void check_mixed(const planish_file *file, const foam_cells *cells, int is_float) {
    planish_cells read;
    assert_int_equal(planish_file_cells((planish_file *)(uintptr_t)file, &read, NULL), PLANISH_OK);
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(mesh.dim, 3);
    assert_int_equal(mesh.n_nodes, cells->n_points);
    assert_int_equal(read.n, cells->n_cells);
    for (int64_t i = 0; i < read.n; i++)
        expect_cell(&read, i, cells, planish_file_element_number(file, i));
    for (int i = 0; i < cells->n_points; i++)
        for (int d = 0; d < 3; d++)
            assert_true(mesh.coordinates[3 * i + d] ==
                        (is_float ? (double)(float)cells->x[i][d] : cells->x[i][d]));
    unit_expect_valid((planish_file *)(uintptr_t)file, read.n);
}

/** Write the file to a new folder, unchanged and with a node moved. */
static void check_writing(const planish_file *file, const char *in, const char *folder) {
    static const char *const names[] = {"points", "faces", "owner", "neighbour", "boundary"};
    char out[TEST_PATH_SIZE], a[TEST_PATH_SIZE], b[TEST_PATH_SIZE];
    planish_error error;
    const planish_mesh mesh = planish_file_mesh(file);
    test_path(out, folder, "out");
    for (int is_moved = 0; is_moved < 2; is_moved++) {
        double *x = malloc(3 * (size_t)mesh.n_nodes * sizeof *x);
        memcpy(x, mesh.coordinates, 3 * (size_t)mesh.n_nodes * sizeof *x);
        x[3 * 21 + 1] += is_moved ? 0.0625 : 0;
        if (planish_file_write(file, out, x, &(planish_write_options){.threads = 1}, &error))
            fail_msg("%s", error.text);
        assert_int_equal(test_count_files(out), 5);
        for (int i = 0; i < 5; i++) {
            size_t before, after;
            char *old = test_read(test_path(a, in, names[i]), &before);
            char *new = test_read(test_path(b, out, names[i]), &after);
            const int is_same = before == after && memcmp(old, new, before) == 0;
            assert_int_equal(is_same, i > 0 || !is_moved);
            size_t differ = 0;
            for (size_t k = 0; i == 0 && before == after && k < before; k++)
                differ += old[k] != new[k];
            assert_in_range(differ, 0, 24);
            free(old);
            free(new);
        }
        planish_file *again = open_at(out, 1);
        const double *read = planish_file_coordinates(again);
        for (int64_t i = 0; i < 3 * mesh.n_nodes; i++)
            assert_true(
                read[i] ==
                (file->model.precision == PLANISH_PRECISION_FLOAT ? (double)(float)x[i] : x[i]));
        planish_file_close(again);
        free(x);
        void *made = strdup(out);
        assert_int_equal(test_folder_remove(&made), 0);
    }
}

static void all_encodings_are_one_mesh(void **state) {
    foam_cells *cells = make_mixed();
    char in[TEST_PATH_SIZE];
    test_folder_in(in, *state, "polyMesh");
    for (int k = 0; k < 36; k++) {
        const int is_binary = k >= 4;
        const foam_form form = {.binary = is_binary,
                                .label_size = k & 1 ? 8 : 4,
                                .scalar_size = k & 2 ? 4 : 8,
                                .swapped = is_binary && k / 4 & 1,
                                .single_faces = is_binary && k / 4 & 2,
                                .has_no_arch = k / 4 & 4 && !(k / 4 & 1)};
        foam_build(in, cells, &form, one_patch, on_one);
        planish_file *file = open_at(in, 1 + (k & 1));
        planish_file_info info;
        planish_file_get_info(file, &info);
        assert_string_equal(info.format, "openfoam");
        assert_int_equal(info.precision, form.scalar_size == 4 ? PLANISH_PRECISION_FLOAT
                                                               : PLANISH_PRECISION_DOUBLE);
        check_mixed(file, cells, form.scalar_size == 4);
        if (k < 8)
            check_writing(file, in, *state);
        planish_file_close(file);
    }
    free(cells);
}

/** What else the syntax allows: comments, lists in one line, faces without a number, equal numbers, no number of
 *  patches. */
static void other_ways_to_write_lists(void **state) {
    foam_cells *cells = malloc(sizeof *cells);
    foam_make_bricks(cells, 1, 1, 1);
    foam_build(*state, cells, &ascii, one_patch, on_one);
    replace(*state, "owner", "6\n(\n0 \n0 \n0 \n0 \n0 \n0 \n)", "6{0}");
    replace(*state, "neighbour", "0\n(\n)", "0()");
    replace(*state, "boundary", "1\n(", "( /* 5 ( */");
    replace(*state, "faces", "\n4(", " /* ) */(");
    replace(*state, "points", "(0 0 0)", "( 0 0 // 7 )\n 0 )");
    planish_file *file = open_at(*state, 1);
    unit_expect_valid(file, 1);
    planish_error error;
    char out[TEST_PATH_SIZE], path[TEST_PATH_SIZE];
    double x[24];
    memcpy(x, planish_file_coordinates(file), sizeof x);
    x[2] = -0.25;
    if (planish_file_write(file, test_path(out, *state, "out"), x,
                           &(planish_write_options){.threads = 1}, &error))
        fail_msg("%s", error.text);
    char *text = test_read(test_path(path, out, "points"), NULL);
    assert_non_null(strstr(text, "( 0 0 // 7 )\n -0.25 )\n(1 0 0)"));
    free(text);
    planish_file_close(file);
    free(cells);
}

/* ---- elements ------------------------------------------------------------------------------- */

static void each_shape_is_found(void **state) {
    static const int types[] = {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_PYRAMID, PLANISH_CELL_WEDGE,
                                PLANISH_CELL_HEXAHEDRON};
    foam_cells *cells = calloc(1, sizeof *cells);
    for (int k = 0; k < 4; k++) {
        cells->type[0] = types[k];
        cells->n_cells = 1;
        cells->n_points = unit_places(types[k], unit_vtk_nodes(types[k]), cells->x);
        for (int turned = 0; turned < 2; turned++) {
            for (int i = 0; i < 8; i++)
                cells->node[0][i] = i;
            foam_build(*state, cells, &ascii, one_patch, on_one);
            planish_file *file = open_at(*state, 1);
            unit_expect(file, 0, types[k]);
            unit_expect_valid(file, 1);
            planish_file_close(file);
            unit_mirror(cells->n_points, cells->x);
        }
    }
    free(cells);
}

/** The sign of an element is that of its faces, wherever its nodes are. */
static void inverted_cells_stay_inverted(void **state) {
    foam_cells *cells = make_mixed();
    double *a = cells->x[21], *b = cells->x[22]; /* of inner nodes side by side */
    for (int d = 0; d < 3; d++) {
        const double x = a[d];
        a[d] = b[d];
        b[d] = x;
    }
    foam_build(*state, cells, &ascii, one_patch, on_one);
    planish_file *file = open_at(*state, 1);
    const planish_cell_quality quality = unit_measure(file, cells->n_cells);
    assert_int_equal(quality.all.n_inverted, 4);
    planish_file_close(file);
    free(cells);
}

static void polyhedra_hold_their_nodes(void **state) {
    foam_cells *cells = malloc(sizeof *cells);
    foam_make_bricks(cells, 4, 4, 4);
    cells->merged[22] = 1; /* with 21, beside the middle */
    foam_build(*state, cells, &ascii, one_patch, on_one);
    planish_file *file = open_at(*state, 1);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_other_elements, 1);
    assert_int_equal(planish_file_mesh(file).n_elements, 62);
    int n_held = 0;
    for (int i = 0; i < cells->n_points; i++)
        n_held += (file->model.hold[i] & IO_HELD_BY_OTHER) != 0;
    assert_int_equal(n_held, 12);
    planish_file_close(file);
    memset(cells->merged, 1, sizeof cells->merged);
    cells->merged[0] = 0;
    foam_build(*state, cells, &ascii, one_patch, on_one);
    open_fails(*state, "points", "other polyhedra cannot be smoothed");
    free(cells);
}

static void threads_read_the_same(void **state) {
    foam_cells *cells = malloc(sizeof *cells);
    foam_make_bricks(cells, 15, 15, 15);
    for (int is_binary = 0; is_binary < 2; is_binary++) {
        const foam_form form = {.binary = is_binary, .label_size = 4, .scalar_size = 8};
        foam_build(*state, cells, &form, one_patch, on_one);
        planish_file *on[2] = {open_at(*state, 1), open_at(*state, 2)};
        const planish_mesh a = planish_file_mesh(on[0]), b = planish_file_mesh(on[1]);
        assert_int_equal(a.n_elements, 3375);
        assert_memory_equal(a.cells->node, b.cells->node, 8 * 3375 * sizeof *a.cells->node);
        assert_memory_equal(a.coordinates, b.coordinates, 3 * 4096 * sizeof(double));
        planish_file_close(on[0]);
        planish_file_close(on[1]);
    }
    free(cells);
}

/* ---- patches and zones ---------------------------------------------------------------------- */

/** Patches of 3 * 3 * 3 bricks: the sides of x, of y, and the rest. */
static int by_side(const double *middle) {
    return middle[0] == 0 ? 0 : middle[0] == 3 ? 1 : middle[1] == 0 ? 2 : middle[1] == 3 ? 3 : 4;
}

static int count_bits(const planish_file *file, uint8_t bit) {
    int n = 0;
    for (int64_t i = 0; i < file->model.n_nodes; i++)
        n += (file->model.hold[i] & bit) != 0;
    return n;
}

/** Count the nodes that a tag and nothing else of the file holds with --slide. */
static int count_held_by(const planish_file *file, const char *tag) {
    uint8_t *constraint = malloc((size_t)file->model.n_nodes);
    planish_error error;
    int n = 0;
    const planish_hold hold = {.tags = &tag, .n_tags = 1, .ignore_regions = 1, .slide = 1};
    if (planish_file_constraints(file, &hold, constraint, &error))
        fail_msg("%s", error.text);
    for (int64_t i = 0; i < file->model.n_nodes; i++)
        n += constraint[i] == PLANISH_CONSTRAINT_FIXED;
    free(constraint);
    return n;
}

static void patches_are_groups(void **state) {
    static const char *const patches[] = {
        "inlet patch inGroups List<word> 2(open ends);",
        "outlet patch inGroups (open);",
        "side wall inGroups 1(wall); physicalType \"a ; b\"; transform { type none; n (0 0 1); }",
        "other symmetryPlane inGroups open;",
        "rest wall",
        NULL};
    static const struct {
        const char *tag;
        int n_held;
    } tags[] = {{"inlet", 16}, {"ends", 16}, {"open", 40},
                {"side", 16},  {"wall", 16}, {"rest", 32}};
    foam_cells *cells = make_mixed();
    foam_build(*state, cells, &ascii, patches, by_side);
    planish_file *file = open_at(*state, 1);
    for (int i = 0; i < 6; i++)
        if (count_held_by(file, tags[i].tag) != tags[i].n_held)
            fail_msg("%s holds %d nodes", tags[i].tag, count_held_by(file, tags[i].tag));
    assert_int_equal(count_bits(file, IO_HELD_REQUIRED), 0);
    assert_int_equal(count_bits(file, IO_HELD_BY_FACE), 56);
    planish_file_close(file);
    free(cells);
}

static void cells_of_zones_are_regions(void **state) {
    foam_cells *cells = make_mixed();
    static const char head[] = "FoamFile { format ascii; class regIOobject; object zones; }\n";
    char text[1024], tag[32];
    foam_build(*state, cells, &ascii, one_patch, on_one);
    snprintf(
        text, sizeof text,
        "%s1\n(\nrotor\n{\n type cellZone;\ncellLabels List<label> 9(0 1 2 3 5 6 7 8 27);\n}\n)",
        head);
    test_write(*state, "cellZones", text, strlen(text));
    snprintf(
        text, sizeof text,
        "%s2(inner { type faceZone; faceLabels List<label> 2(0 1); flipMap List<bool> 2(0 1); } "
        "none {type faceZone; faceLabels (); flipMap (); })",
        head);
    test_write(*state, "faceZones", text, strlen(text));
    snprintf(text, sizeof text, "%s(probes { type pointZone; pointLabels 2(21 22); })", head);
    test_write(*state, "pointZones", text, strlen(text));
    planish_file *file = open_at(*state, 1);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 2);
    for (int64_t i = 0; i < planish_file_mesh(file).n_elements; i++) {
        const int64_t number = planish_file_element_number(file, i);
        planish_file_element_region(file, i, tag, sizeof tag);
        assert_string_equal(tag, number == 27 || (number < 9 && number != 4) ? "rotor" : "");
    }
    /* 56 nodes of the boundary slide; those of the zone inside do not. */
    assert_int_equal(count_held_by(file, "probes"), 2);
    assert_in_range(count_held_by(file, "inner"), 4, 6);
    assert_int_equal(count_held_by(file, "none"), 0);
    assert_in_range(count_bits(file, IO_HELD_BY_FACE), 57, 60);
    planish_file_close(file);
    free(cells);
}

static void special_patches_hold(void **state) {
    static const char *const kinds[] = {"empty", "wedge", "processor", "cyclicAMI", "unheardOf"};
    foam_cells *cells = make_mixed();
    for (int i = 0; i < 5; i++) {
        char special[64];
        snprintf(special, sizeof special, "side %s", kinds[i]);
        const char *const patches[] = {special,  "b patch",         "c symmetry",
                                       "d wall", "e symmetryPlane", NULL};
        foam_build(*state, cells, &ascii, patches, by_side);
        planish_file *file = open_at(*state, 1);
        assert_int_equal(count_bits(file, IO_HELD_REQUIRED), 16);
        planish_file_close(file);
    }
    free(cells);
}

static void cyclic_patches_are_periodic(void **state) {
    static const char *const patches[] = {"left cyclic neighbourPatch right;",
                                          "right cyclic neighbourPatch left;",
                                          "c cyclic neighbourPatch x;",
                                          "d wall",
                                          "e wall",
                                          NULL};
    foam_cells *cells = malloc(sizeof *cells);
    foam_make_bricks(cells, 3, 3, 3);
    foam_build(*state, cells, &ascii, patches, by_side);
    planish_file *file = open_at(*state, 1);
    const io_model *model = &file->model;
    assert_int_equal(model->n_periodic, 16);
    for (int64_t i = 0; i < model->n_periodic; i++) {
        assert_int_equal(model->periodic[2 * i] % 4, 0);
        assert_int_equal(model->periodic[2 * i + 1] - model->periodic[2 * i], 3);
    }
    assert_int_equal(count_bits(file, IO_HELD_PERIODIC), 32);
    assert_int_equal(count_bits(file, IO_HELD_REQUIRED), 16); /* its partner does not know of it */
    planish_file_close(file);
    free(cells);
}

/* ---- damage --------------------------------------------------------------------------------- */

static void damage_is_refused(void **state) {
    static const struct {
        const char *name, *old, *new, *about, *word;
    } cases[] = {
        {"points", "FoamFile", "FoamFilm", "points:2", "no FoamFile"},
        {"points", "ascii", "asciii", "points:5", "ascii or binary"},
        {"points", "label=32", "label=33", "points:6", "32 or 64"},
        {"points", "\n64\n(", "\n65\n(", "points", "point 64"},
        {"points", "\n64\n(", "\n63\n(", "points", "')' expected"},
        {"points", "\n64\n(", "\n4611686018427387904\n(", "points", "4611686018427387904 points"},
        {"points", "\n64\n(", "\n-1\n(", "points", "number of points"},
        {"points", "(0 0 0)", "(0 0)", "points", "point 0: (x y z)"},
        {"points", "(0 0 0)", "(0 0 nan)", "points", "not finite"},
        {"points", "(0 0 0)", "(0 0 1e999)", "points", "not finite"},
        {"points", "(0 0 0)", "(0 0 0 0)", "points", "point 0"},
        {"points", "\n64\n(", "\n$n\n(", "points", "macros"},
        {"points", "\n64\n(", "\n#include \"n\"\n(", "points", "directives"},
        {"faces", "4(", "5(", "faces", "4 nodes follow, not 5"},
        {"faces", "4(", "2(", "faces", "face 0"},
        {"faces", "4(", "4[", "faces", "face 0"},
        {"faces", "4(0 ", "4(64 ", "faces", "no node 64"},
        {"faces", "4(0 ", "4(-1 ", "faces", "no node -1"},
        {"owner", "(\n0 ", "(\n-1 ", "owner", "is -1"},
        {"owner", "(\n0 ", "(\n2147483647 ", "owner", "is 2147483647"},
        {"owner", "(\n0 ", "(\n2147483000 ", "points", "cell 2147483000"},
        {"owner", "(\n0 ", "(\n400 ", "points", "cell 400"},
        {"owner", "(\n0 ", "(\n30 ", "points", "faces: four at least"},
        {"owner", "\n0 ", "\n", "owner", "whole number 107"},
        {"neighbour", "(\n1 ", "(\n0 ", "points", "both sides"},
        {"boundary", "nFaces", "nFace", "boundary", "type, nFaces and startFace"},
        {"boundary", "nFaces ", "nFaces x", "boundary", "number of faces"},
        {"boundary", "nFaces 54", "nFaces 55", "boundary", "not 55"},
        {"boundary", "startFace", "nFaces 54; startFace 0; //", "boundary", "between two cells"},
        {"boundary", "type", "$type", "boundary", "macros"},
        {"boundary", "1\n(\n", "2\n(\n first { type wall; startFace 54; nFaces 1; }\n", "boundary",
         "patches before"},
        {"owner", "108\n(", "70000{0} // (", "owner", "equal numbers are too many"},
        {"boundary", "{\n", "{ #include \"x\"\n", "boundary", "directives"},
        {"boundary", "1\n(", "2\n(", "boundary", "one more"},
        {"boundary", "1\n(", "0\n(", "boundary", "')' expected"},
    };
    foam_cells *cells = malloc(sizeof *cells);
    foam_make_bricks(cells, 3, 3, 3);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        planish_file *file = NULL;
        planish_error error = {.text = "none"};
        foam_build(*state, cells, &ascii, one_patch, on_one);
        replace(*state, cases[i].name, cases[i].old, cases[i].new);
        if (planish_file_open(*state, NULL, 1, &file, &error) == PLANISH_OK ||
            !strstr(error.text, cases[i].about) || !strstr(error.text, cases[i].word))
            fail_msg("case %zu: '%s' is not about %s and '%s'", i, error.text, cases[i].about,
                     cases[i].word);
        assert_null(file);
    }
    free(cells);
}

/** Files that are cut short, or have another byte, are an error or a mesh. */
static void any_bytes_are_safe(void **state) {
    static const char *const names[] = {"points",   "faces",     "owner",    "neighbour",
                                        "boundary", "cellZones", "faceZones"};
    static const char zones[] =
        "FoamFile { format ascii; class regIOobject; }\n1(a { type faceZone; "
        "faceLabels List<label> 2(0 1); flipMap List<bool> 2(0 1); })";
    static const char cell_zones[] =
        "FoamFile{format ascii;}1(a { cellLabels List<label> 3{1}; b (1 2) ; })";
    foam_cells *cells = malloc(sizeof *cells);
    char path[TEST_PATH_SIZE];
    uint32_t random = 1;
    int n_read = 0, n_refused = 0;
    foam_make_bricks(cells, 2, 2, 1);
    for (int k = 0; k < 4; k++) {
        const foam_form form = {.binary = k > 0,
                                .label_size = k == 2 ? 8 : 4,
                                .scalar_size = 8,
                                .single_faces = k == 3};
        foam_build(*state, cells, &form, one_patch, on_one);
        test_write(*state, "faceZones", zones, strlen(zones));
        test_write(*state, "cellZones", cell_zones, strlen(cell_zones));
        for (int i = 0; i < 7; i++) {
            size_t size;
            char *data = test_read(test_path(path, *state, names[i]), &size);
            for (size_t at = 0; at < 2 * size; at += 7) {
                planish_file *file = NULL;
                planish_error error;
                const size_t place = at % size;
                const char old = data[place];
                random = random * 1664525 + 1013904223;
                data[place] = at < size ? old : (char)(random >> 24);
                unlink(test_path(path, *state, names[i]));
                test_write(*state, names[i], data, at < size ? at : size);
                const int status = planish_file_open(*state, NULL, 1, &file, &error);
                n_read += status == PLANISH_OK;
                n_refused += status != PLANISH_OK;
                planish_file_close(file);
                data[place] = old;
            }
            test_write(*state, names[i], data, size);
            free(data);
        }
    }
    assert_in_range(n_read, 400, 4000);
    assert_in_range(n_refused, 400, 4000);
    free(cells);
}

/* ---- folders -------------------------------------------------------------------------------- */

/** A case has its mesh below constant, or that of a region. */
static void a_case_has_its_mesh(void **state) {
    char constant[TEST_PATH_SIZE], region[TEST_PATH_SIZE], mesh[TEST_PATH_SIZE],
        out[TEST_PATH_SIZE], path[TEST_PATH_SIZE];
    foam_cells *cells = make_mixed();
    planish_error error;
    test_folder_in(constant, *state, "constant");
    test_folder_in(region, constant, "fluid");
    test_folder_in(mesh, region, "polyMesh");
    open_fails(*state, "is a folder without a mesh", "constant/polyMesh");
    foam_build(mesh, cells, &ascii, one_patch, on_one);
    test_write(test_folder_in(path, mesh, "sets"), "cells", "a set", 5);
    planish_file *file = open_at(*state, 1);
    test_path(out, *state, "out");
    assert_int_equal(planish_file_write(file, out, planish_file_coordinates(file),
                                        &(planish_write_options){.threads = 1}, &error),
                     PLANISH_OK);
    struct stat about;
    assert_int_equal(stat(test_path(path, out, "constant/fluid/polyMesh/sets/cells"), &about), 0);
    assert_int_equal(stat(test_path(path, out, "constant/fluid/polyMesh/points"), &about), 0);
    planish_file *again = open_at(out, 1);
    planish_file_close(again);
    planish_file_close(file);
    /* Two meshes are one too many. */
    test_folder_in(mesh, constant, "polyMesh");
    foam_build(mesh, cells, &ascii, one_patch, on_one);
    open_fails(*state, "has 2 meshes", "/constant/fluid/polyMesh");
    open_fails(constant, "has 2 meshes", "/fluid/polyMesh");
    file = open_at(mesh, 1);
    planish_file_close(file);
    unlink(test_path(path, mesh, "owner"));
    file = open_at(*state, 1); /* that of the region is whole */
    planish_file_close(file);
    open_fails(mesh, "openfoam", "no file owner");
    open_fails(test_path(path, mesh, "faces"), "faces", "give the folder");
    free(cells);
}

int main(void) {
#define TEST(name) cmocka_unit_test_setup_teardown(name, test_folder_create, test_folder_remove)
    const struct CMUnitTest tests[] = {
        TEST(all_encodings_are_one_mesh), TEST(other_ways_to_write_lists),
        TEST(each_shape_is_found),        TEST(inverted_cells_stay_inverted),
        TEST(polyhedra_hold_their_nodes), TEST(threads_read_the_same),
        TEST(patches_are_groups),         TEST(cells_of_zones_are_regions),
        TEST(special_patches_hold),       TEST(cyclic_patches_are_periodic),
        TEST(damage_is_refused),          TEST(any_bytes_are_safe),
        TEST(a_case_has_its_mesh),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
