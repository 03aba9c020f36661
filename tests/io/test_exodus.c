/* Exodus: what is read, held and refused, sets and names, data, and what is written; in netCDF of
 * every kind. */
#include "support/effort.h"
#include "support/files.h"
#include "support/folder_files.h"
#include "support/hdf5_builder.h"
#include "support/netcdf_builder.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5
#include <hdf5.h>
#endif
#ifdef __linux__
#include <sys/inotify.h>
#include <unistd.h>
#endif

enum { N = 6 };

static const int kinds[] = {1, 2, 5, 4};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

/** Put two tetrahedra of different blocks, a bar, a point and an empty block, with sets. is_one: one
 *  array has all coordinates. */
static void put_mesh(netcdf_builder *b, int kind, int is_one, int type) {
    static const double xyz[] = {0, 1, 0, 0, 1, 2, 0, 0, 1, 0, 1, 2, 0, 0, 0, 1, 1.5, 2};
    static const double data[] = {1, 2, 3, 4, 5, 6, -1, -2, -3, -4, -5, -6};
    *b = (netcdf_builder){.kind = kind};
    netcdf_put_reals(b, "vals_nod_var1", NETCDF_AS_DOUBLE, 2, N, data)->is_by_step = 1;
    netcdf_put_reals(b, "time_whole", NETCDF_AS_FLOAT, 2, 1, data)->is_by_step = 1;
    netcdf_put_texts(b, "name_nod_var", 2, (const char *const[]){"size", "missing"});
    netcdf_put_texts(b, "eb_names", 5, (const char *const[]){"lower", "upper", "", "point", ""});
    netcdf_put_integers(b, "eb_prop1", 5, 0, (const int[]){10, 20, 30, 40, 50});
    netcdf_put_integers(b, "elem_num_map", 4, 0, (const int[]){101, 102, 103, 104});
    netcdf_put_integers(b, "node_num_map", N, 0, (const int[]){10, 20, 30, 40, 50, 60});
    for (int d = 2; d >= 0 && !is_one; d--)
        netcdf_put_reals(b,
                         d == 2   ? "coordz"
                         : d == 1 ? "coordy"
                                  : "coordx",
                         type, N, 0, xyz + d * N);
    if (is_one)
        netcdf_put_reals(b, "coord", type, 3, N, xyz);
    static const char *const types[] = {"TETRA", "tet4", "BAR2", "SPHERE"};
    static const int widths[] = {4, 4, 2, 1};
    static const int nodes[][4] = {{1, 2, 3, 4}, {2, 3, 4, 5}, {5, 6}, {6}};
    for (int k = 0; k < 4; k++) {
        char name[32];
        snprintf(name, sizeof name, "connect%d", k + 1);
        netcdf_part *part = netcdf_put_integers(b, name, 1, widths[k], nodes[k]);
        strcpy(part->text, types[k]);
    }
    netcdf_put_integers(b, "ns_prop1", 3, 0, (const int[]){7, 8, 9});
    netcdf_put_texts(b, "ns_names", 3, (const char *const[]){"pinned", "", "empty"});
    netcdf_put_integers(b, "node_ns1", 2, 0, (const int[]){3, 6});
    netcdf_put_integers(b, "node_ns2", 1, 0, (const int[]){1});
    netcdf_put_integers(b, "ss_prop1", 2, 0, (const int[]){5, 6});
    netcdf_put_texts(b, "ss_names", 2, (const char *const[]){"bottom", ""});
    netcdf_put_integers(b, "elem_ss1", 1, 0, (const int[]){1});
    netcdf_put_integers(b, "side_ss1", 1, 0, (const int[]){4});
    netcdf_put_integers(b, "elem_ss2", 3, 0, (const int[]){1, 1, 2}); /* the last is inside, */
    netcdf_put_integers(b, "side_ss2", 3, 0, (const int[]){4, 2, 4}); /* and from both sides */
}

/* ---- what is read -------------------------------------------------------------------------- */

static void check_mesh(const planish_file *file, int is_float) {
    static const int32_t nodes[] = {0, 1, 2, 3, 1, 2, 3, 4};
    static const uint8_t hold[] = {0, 0, 0, 0, IO_HELD_BY_LINE, IO_HELD_BY_LINE | IO_HELD_BY_POINT};
    const planish_mesh mesh = planish_file_mesh(file);
    reading_gave(file, &io_format_exodus,
                 &(reading_facts){.dim = 3,
                                  .n_nodes = N,
                                  .n_elements = 2,
                                  .n_regions = 2,
                                  .n_lower = 4, /* two facets are one: a bar, a point, two sides */
                                  .precision = is_float ? PLANISH_PRECISION_FLOAT
                                                        : PLANISH_PRECISION_DOUBLE});
    assert_memory_equal(mesh.elements, nodes, sizeof nodes);
    assert_true(mesh.coordinates[3] == 1 && mesh.coordinates[14] == 1.5 &&
                mesh.coordinates[16] == 2);
    assert_memory_equal(file->model.hold, hold, sizeof hold);
    assert_int_equal(planish_file_node_number(file, 5), 60);
    assert_int_equal(planish_file_element_number(file, 1), 102);
}

static void a_mesh_is_read_in_every_kind(void **state) {
    (void)state;
    for (int i = 0; i < 4 * N_KINDS; i++) {
        const int is_float = i / N_KINDS % 2;
        netcdf_builder n;
        put_mesh(&n, kinds[i % N_KINDS], i / N_KINDS / 2,
                 is_float ? NETCDF_AS_FLOAT : NETCDF_AS_DOUBLE);
        if (n.kind == 5)
            netcdf_find_part(&n, "connect1")->type = NETCDF_AS_INT64;
        n.is_packed = is_float;
        file_builder b = netcdf_end_file(&n);
        assert_int_equal(io_format_exodus.recognise(b.data, b.size), 1);
        assert_int_equal(io_format_vtkhdf.read && io_format_vtkhdf.recognise(b.data, b.size), 0);
        planish_file *file = builder_file(&b, &io_format_exodus);
        check_mesh(file, is_float);
        planish_file_close(file);
        builder_release(&b);
    }
}

static void sets_are_groups(void **state) {
    (void)state;
    netcdf_builder n;
    put_mesh(&n, 1, 0, NETCDF_AS_DOUBLE);
    file_builder b = netcdf_end_file(&n);
    planish_file *file = builder_file(&b, &io_format_exodus);
    unit_expect_held(file, NULL, "000011"); /* without regions */
    const struct {
        const char *tag, *held;
    } groups[] = {{"bottom", "111000"}, {"2:5", "111000"},    {"5", "111000"},
                  {"6", "111100"},      {"pinned", "001001"}, {"0:7", "001001"},
                  {"8", "100000"},      {"empty", "000000"},  {"lower", "111100"},
                  {"3:20", "011110"},   {"upper", "011110"},  {"1:30", "000011"}};
    for (size_t i = 0; i < sizeof groups / sizeof *groups; i++) {
        /* Sliding, neither interface nor lines hold; the point does. */
        const planish_hold hold = {.tags = &groups[i].tag, .n_tags = 1, .slide = 1};
        uint8_t constraint[N];
        planish_error error = {.text = ""};
        if (planish_file_constraints(file, &hold, constraint, &error))
            fail_msg("%s", error.text);
        for (int k = 0; k < N; k++)
            if ((constraint[k] == PLANISH_CONSTRAINT_FIXED) !=
                (k == N - 1 || groups[i].held[k] == '1'))
                fail_msg("%s: node %d", groups[i].tag, k);
    }
    const char *const unknown[] = {"0", "2:1", "9"}; /* places and tags of ours are no numbers */
    for (int i = 0; i < 3; i++) {
        const planish_hold hold = {.tags = &unknown[i], .n_tags = 1};
        uint8_t constraint[N];
        planish_error error;
        assert_int_equal(planish_file_constraints(file, &hold, constraint, &error),
                         i == 2 ? PLANISH_OK : PLANISH_ERROR_ARGUMENT);
    }
    char region[32];
    planish_file_element_region(file, 1, region, sizeof region);
    assert_string_equal(region, "upper");
    const char *const slide[] = {"bottom"};
    const planish_hold sliding = {.slide = 1, .slide_tags = slide, .n_slide_tags = 1};
    uint8_t constraint[N];
    planish_error error;
    assert_int_equal(planish_file_constraints(file, &sliding, constraint, &error), 0);
    assert_int_equal(constraint[0], PLANISH_CONSTRAINT_FREE);
    assert_int_equal(constraint[3], PLANISH_CONSTRAINT_FIXED); /* of the facet that is not named */
    planish_file_close(file);
    builder_release(&b);
}

/** A shell and side sets of number 2, node sets and the nodes of a side set of number 5: each name is
 *  that of one. */
static void names_of_one_number_are_groups(void **state) {
    (void)state;
    static const double xyz[] = {0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    static const struct {
        const char *tag, *held;
    } cases[] = {{"shell", "1011"}, {"bottom", "1110"}, {"2:2", "1111"}, {"solid", "1111"},
                 {"pin", "0100"},   {"top", "1011"},    {"5", "1111"},   {"0:5", "1111"}};
    netcdf_builder n = {.kind = 1};
    netcdf_put_texts(&n, "eb_names", 2, (const char *const[]){"solid", "shell"});
    netcdf_put_integers(&n, "eb_prop1", 2, 0, (const int[]){1, 2});
    for (int d = 2; d >= 0; d--)
        netcdf_put_reals(&n,
                         d == 2   ? "coordz"
                         : d == 1 ? "coordy"
                                  : "coordx",
                         NETCDF_AS_DOUBLE, 4, 0, xyz + 4 * d);
    strcpy(netcdf_put_integers(&n, "connect1", 1, 4, (const int[]){1, 2, 3, 4})->text, "TETRA");
    strcpy(netcdf_put_integers(&n, "connect2", 1, 3, (const int[]){1, 3, 4})->text, "SHELL3");
    netcdf_put_integers(&n, "ns_prop1", 1, 0, (const int[]){5});
    netcdf_put_texts(&n, "ns_names", 1, (const char *const[]){"pin"});
    netcdf_put_integers(&n, "node_ns1", 1, 0, (const int[]){2});
    netcdf_put_integers(&n, "ss_prop1", 2, 0, (const int[]){2, 5});
    netcdf_put_texts(&n, "ss_names", 2, (const char *const[]){"bottom", "top"});
    netcdf_put_integers(&n, "elem_ss1", 1, 0, (const int[]){1});
    netcdf_put_integers(&n, "side_ss1", 1, 0, (const int[]){4});
    netcdf_put_integers(&n, "elem_ss2", 1, 0, (const int[]){2});
    netcdf_put_integers(&n, "side_ss2", 1, 0, (const int[]){1});
    file_builder b = netcdf_end_file(&n);
    planish_file *file = builder_file(&b, &io_format_exodus);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const planish_hold hold = {.tags = &cases[i].tag, .n_tags = 1};
        uint8_t reason[4];
        assert_int_equal(planish_file_get_held(file, &hold, reason, NULL), 0);
        for (int k = 0; k < 4; k++)
            if ((reason[k] & PLANISH_FILE_FIX) != (cases[i].held[k] == '1' ? PLANISH_FILE_FIX : 0))
                fail_msg("%s: node %d", cases[i].tag, k);
    }
    static const char *const slide[] = {"bottom"};
    const planish_hold sliding = {.slide = 1, .slide_tags = slide, .n_slide_tags = 1};
    uint8_t constraint[4];
    assert_int_equal(planish_file_constraints(file, &sliding, constraint, NULL), 0);
    for (int k = 0; k < 4; k++) /* the shell does not slide */
        assert_int_equal(constraint[k],
                         k == 1 ? PLANISH_CONSTRAINT_FREE : PLANISH_CONSTRAINT_FIXED);
    planish_file_close(file);
    builder_release(&b);
}

static void shared_nodes_are_held(void **state) {
    static const char *const lists[] = {"n_comm_nids", "node_mapb", "node_mape"};
    (void)state;
    for (int i = 0; i < 3; i++) {
        netcdf_builder n;
        put_mesh(&n, 2, 0, NETCDF_AS_DOUBLE);
        netcdf_put_integers(&n, lists[i], 1, 0, (const int[]){1});
        file_builder b = netcdf_end_file(&n);
        planish_file *file = builder_file(&b, &io_format_exodus);
        assert_int_equal(file->model.hold[0], IO_HELD_REQUIRED);
        assert_int_equal(file->model.hold[1], 0);
        planish_file_close(file);
        builder_release(&b);
    }
}

static void a_plane_is_read(void **state) {
    static const double xy[] = {0, 1, 1, 0, 0, 0, 1, 1};
    (void)state;
    for (int i = 0; i < 2 * N_KINDS; i++) {
        netcdf_builder n = {.kind = kinds[i / 2]};
        if (i % 2)
            netcdf_put_reals(&n, "coord", NETCDF_AS_DOUBLE, 2, 4, xy);
        for (int d = 0; d < 2 && i % 2 == 0; d++)
            netcdf_put_reals(&n, d ? "coordy" : "coordx", NETCDF_AS_DOUBLE, 4, 0, xy + 4 * d);
        netcdf_put_integers(&n, "eb_prop1", 1, 0, (const int[]){0});
        strcpy(netcdf_put_integers(&n, "connect1", 2, 3, (const int[]){1, 2, 3, 1, 3, 4})->text,
               "TRI");
        file_builder b = netcdf_end_file(&n);
        planish_file *file = builder_file(&b, &io_format_exodus);
        const planish_mesh mesh = planish_file_mesh(file);
        assert_int_equal(mesh.dim, 2);
        assert_int_equal(mesh.n_elements, 2);
        assert_true(mesh.coordinates[2] == 1 && mesh.coordinates[5] == 1);
        assert_int_equal(planish_file_element_number(file, 1), 2);
        assert_int_equal(planish_file_node_number(file, 3), 4);
        planish_file_close(file);
        builder_release(&b);
    }
}

static void data_are_read(void **state) {
    (void)state;
    for (int i = 0; i < 2 * N_KINDS; i++) {
        static const double heat[] = {7.5, -1, 0}; /* at two steps of each block */
        netcdf_builder n;
        planish_data data;
        planish_error error = {.text = ""};
        put_mesh(&n, kinds[i / 2], 0, NETCDF_AS_DOUBLE);
        n.is_packed = i % 2;
        netcdf_put_texts(&n, "name_elem_var", 2, (const char *const[]){"part", "heat"});
        netcdf_put_reals(&n, "vals_elem_var1eb1", NETCDF_AS_DOUBLE, 2, 1, heat)->is_by_step = 1;
        netcdf_put_reals(&n, "vals_elem_var2eb1", NETCDF_AS_FLOAT, 2, 1, heat)->is_by_step = 1;
        netcdf_put_reals(&n, "vals_elem_var2eb2", NETCDF_AS_FLOAT, 2, 1, heat + 1)->is_by_step = 1;
        file_builder b = netcdf_end_file(&n);
        planish_file *file = builder_file(&b, &io_format_exodus);
        assert_int_equal(file->model.n_data, 4); /* size, part, and heat in two blocks */
        file->model.is_isolated = i % 2;
        int status = planish_file_data(file, "size", &data, &error);
        assert_int_equal(status, PLANISH_OK);
        for (int k = 0; k < N; k++)
            assert_true(data.values[k] == k + 1);
        planish_data_free(&data);
        status = planish_file_data(file, "heat", &data, &error);
        assert_int_equal(status, PLANISH_OK);
        assert_true(data.of_elements && data.n == 2 && data.values[0] == 7.5 &&
                    data.values[1] == -1);
        planish_data_free(&data);
        assert_int_equal(planish_file_data(file, "part", &data, &error), PLANISH_ERROR_FORMAT);
        assert_non_null(strstr(error.text, "values for 1 of 2 elements"));
        assert_int_equal(planish_file_data(file, "missing", &data, &error), PLANISH_ERROR_ARGUMENT);
        planish_file_close(file);
        builder_release(&b);
    }
}

/** A variable must have real numbers, one for each node. */
static void wrong_data_are_refused(void **state) {
    static const struct {
        int rows, columns, type;
    } wrong[] = {{2, 5, NETCDF_AS_DOUBLE}, {5, 0, NETCDF_AS_FLOAT}, {2, 6, NETCDF_AS_INT}};
    (void)state;
    for (size_t i = 0; i < 2 * sizeof wrong / sizeof *wrong; i++) {
        netcdf_builder n;
        planish_data data;
        planish_error error = {.text = ""};
        put_mesh(&n, i % 2 ? 4 : 2, 0, NETCDF_AS_DOUBLE);
        netcdf_part *part = netcdf_find_part(&n, "vals_nod_var1");
        part->rows = wrong[i / 2].rows;
        part->columns = wrong[i / 2].columns;
        part->type = wrong[i / 2].type;
        part->is_by_step = part->columns > 0;
        file_builder b = netcdf_end_file(&n);
        planish_file *file = builder_file(&b, &io_format_exodus);
        assert_int_equal(planish_file_data(file, "size", &data, &error), PLANISH_ERROR_FORMAT);
        if (!strstr(error.text, "vals_nod_var1: 6 real numbers were expected"))
            fail_msg("%s", error.text);
        planish_file_close(file);
        builder_release(&b);
    }
}

/* ---- what is refused ----------------------------------------------------------------------- */

static void wrong_values_are_refused(void **state) {
    static const struct {
        const char *name;
        int at;
        double value;
        const char *part;
    } wrong[] = {
        {"connect1", 3, 7, "connect1: number 4 of the list: node 7 is not in 1 .. 6"},
        {"connect2", 0, 0, "node 0 is not in"},
        {"connect3", 1, -1, "node -1 is not in"},
        {"connect4", 0, 99, "node 99 is not in"},
        {"node_ns1", 1, 7, "node_ns1: number 2 of the list: node 7"},
        {"elem_ss1", 0, 5, "elem_ss1: element 5 is not in 1 .. 4"},
        {"elem_ss2", 0, 0, "element 0 is not in"},
        {"side_ss1", 0, 5, "element 1 has no side 5"},
        {"side_ss2", 1, -3, "has no side -3"},
        {"eb_prop1", 1, 10, "element block number 10 occurs twice"},
        {"coordx", 1, HUGE_VAL, "coordx: node 2 has a coordinate that is not finite"},
        {"coordz", 0, -HUGE_VAL, "not finite"},
    };
    (void)state;
    for (size_t i = 0; i < 2 * sizeof wrong / sizeof *wrong; i++) {
        netcdf_builder n;
        put_mesh(&n, i % 2 ? 4 : 2, 0, NETCDF_AS_DOUBLE);
        netcdf_find_part(&n, wrong[i / 2].name)->value[wrong[i / 2].at] = wrong[i / 2].value;
        file_builder b = netcdf_end_file(&n);
        builder_expect_error(&b, &io_format_exodus, wrong[i / 2].part);
        builder_release(&b);
    }
}

static void wrong_shapes_are_refused(void **state) {
    static const struct {
        const char *name;
        int rows, columns, type;
        const char *part;
    } wrong[] = {
        {"coordy", 5, 0, 0, "5 coordinates for 6 nodes"},
        {"coordy", 6, 0, NETCDF_AS_FLOAT, "another precision"},
        {"coordx", 6, 0, NETCDF_AS_INT, "4 or 8 bytes|float or double"},
        {"connect1", 1, 4, NETCDF_AS_DOUBLE, "whole numbers"},
        {"elem_num_map", 3, 0, 0, "3 numbers for 4 elements"},
        {"node_num_map", 5, 0, 0, "5 numbers for 6 nodes"},
        {"side_ss2", 2, 0, 0, "3 elements and 2 sides"},
        {"eb_names", 5, 8, NETCDF_AS_INT, "text was expected"},
        {"ns_prop1", 1, 0, NETCDF_AS_FLOAT, "whole numbers"},
    };
    (void)state;
    for (size_t i = 0; i < 2 * sizeof wrong / sizeof *wrong; i++) {
        netcdf_builder n;
        planish_file *file;
        planish_error error = {.text = ""};
        put_mesh(&n, i % 2 ? 4 : 1, 0, NETCDF_AS_DOUBLE);
        netcdf_part *part = netcdf_find_part(&n, wrong[i / 2].name);
        part->rows = wrong[i / 2].rows;
        part->columns = wrong[i / 2].columns;
        part->type = wrong[i / 2].type ? wrong[i / 2].type : part->type;
        file_builder b = netcdf_end_file(&n);
        assert_int_equal(builder_read(&b, &io_format_exodus, 1, &file, &error),
                         PLANISH_ERROR_FORMAT);
        const char *other = strchr(wrong[i / 2].part, '|');
        char first[64];
        snprintf(first, sizeof first, "%.*s",
                 (int)(other ? other - wrong[i / 2].part : (long)strlen(wrong[i / 2].part)),
                 wrong[i / 2].part);
        if (!strstr(error.text, first) && !(other && strstr(error.text, other + 1)))
            fail_msg("%s: %s", wrong[i / 2].name, error.text);
        builder_release(&b);
    }
}

static void other_files_are_refused(void **state) {
    (void)state;
    netcdf_builder n = {.kind = 1};
    netcdf_put_integers(&n, "data", 1, 0, (const int[]){1});
    file_builder b = netcdf_end_file(&n);
    builder_expect_error(&b, &io_format_exodus, "is not an Exodus file");
    builder_release(&b);
    n = (netcdf_builder){.kind = 1};
    netcdf_put_reals(&n, "coordx", NETCDF_AS_DOUBLE, 1, 0, (const double[]){1});
    b = netcdf_end_file(&n);
    builder_expect_error(&b, &io_format_exodus, "1 coordinates of each node");
    b.data[3] = 3;
    assert_int_equal(io_format_exodus.recognise(b.data, b.size), 0);
    builder_expect_error(&b, &io_format_exodus, "not a netCDF file");
    builder_release(&b);
    put_mesh(&n, 1, 0, NETCDF_AS_DOUBLE);
    netcdf_find_part(&n, "connect1")->is_by_step = 1;
    b = netcdf_end_file(&n);
    builder_expect_error(&b, &io_format_exodus, "for each time step");
    builder_release(&b);
}

static void missing_variables_are_refused(void **state) {
    (void)state;
    for (int i = 0; i < N_KINDS; i++) {
        netcdf_builder n;
        put_mesh(&n, kinds[i], 0, NETCDF_AS_DOUBLE);
        netcdf_put_dimension(&n, "num_dim", 3);
        strcpy(netcdf_find_part(&n, "coordz")->name, "other");
        file_builder without = netcdf_end_file(&n);
        builder_expect_error(&without, &io_format_exodus,
                             "each node has 2 coordinates, but the file");
        builder_release(&without);
        put_mesh(&n, kinds[i], 0, NETCDF_AS_DOUBLE);
        netcdf_put_dimension(&n, "num_el_in_blk5", 3);
        file_builder b = netcdf_end_file(&n);
        builder_expect_error(&b, &io_format_exodus, "connect5: the nodes of 3 elements");
        builder_release(&b);
    }
}

/** Let a variable of a classic file begin where its values are those of another one, or the header. */
static void shared_bytes_are_refused(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        netcdf_builder n;
        put_mesh(&n, 1, 0, NETCDF_AS_DOUBLE);
        file_builder b = netcdf_end_file(&n);
        int64_t at = 0; /* of its name and rank */
        while (at < b.size - 40 && memcmp(b.data + at, "coordx\0\0\0\0\0\1", 12) != 0)
            at++;
        char *place = b.data + at + 32; /* behind dimension, attributes, type and size */
        place[3] = i ? (char)(place[3] - 8) : 0;
        place[2] = i ? place[2] : 0;
        builder_expect_error(&b, &io_format_exodus, "'coordx' begin within those of another one");
        builder_release(&b);
    }
}

/** Put other bytes at every place of the header of a classic file, and read it. */
static void no_header_breaks_it(void **state) {
    static const char bytes[] = {0, 1, 0x7f, (char)0x80, (char)0xff};
    const int step = effort_step(3);
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        netcdf_builder n;
        put_mesh(&n, kind ? 5 : 1, 0, NETCDF_AS_DOUBLE);
        file_builder b = netcdf_end_file(&n);
        int64_t n_refused = 0, n_header = b.size - 400;
        for (int64_t i = 4; i < n_header; i += step)
            for (size_t k = 0; k < sizeof bytes; k++) {
                const char kept = b.data[i];
                planish_file *file;
                planish_error error = {.text = ""};
                b.data[i] = bytes[k];
                if (builder_read(&b, &io_format_exodus, 1, &file, &error)) {
                    assert_true(strlen(error.text) > 0);
                    n_refused++;
                }
                planish_file_close(file);
                b.data[i] = kept;
            }
        assert_true(n_refused > n_header / 2 / step);
        builder_release(&b);
    }
}

static void nothing_breaks_it(void **state) {
    (void)state;
    for (int i = 0; i < N_KINDS; i++) {
        netcdf_builder n;
        planish_file *file;
        planish_error error;
        put_mesh(&n, kinds[i], i % 2, NETCDF_AS_DOUBLE);
        file_builder b = netcdf_end_file(&n);
        builder_try_to_break(&b, &io_format_exodus);
        builder_expect_same_on_threads(&b, &io_format_exodus);
        /* A file without its last value is cut short, whatever that is of. */
        for (b.size -= 4; n.kind != 4 && b.size > 0; b.size -= 8)
            assert_int_equal(builder_read(&b, &io_format_exodus, 1, &file, &error),
                             PLANISH_ERROR_FORMAT);
        builder_release(&b);
    }
}

/* ---- writing ------------------------------------------------------------------------------- */

static void coordinates_alone_are_written(void **state) {
    for (int i = 0; i < 4 * N_KINDS; i++) {
        netcdf_builder n;
        put_mesh(&n, kinds[i % N_KINDS], i / N_KINDS / 2,
                 i / N_KINDS % 2 ? NETCDF_AS_FLOAT : NETCDF_AS_DOUBLE);
        file_builder b = netcdf_end_file(&n);
        rewriting_keeps_the_rest(&io_format_exodus, b.data, b.size, *state);
        builder_release(&b);
    }
#ifdef PL_HDF5
    for (int i = 0; i < 2 * HDF5_SUPERBLOCKS; i++) {
        netcdf_builder n;
        put_mesh(&n, 4, i % 2, NETCDF_AS_DOUBLE);
        n.is_packed = 1;
        hdf5_superblock = hdf5_superblocks[i / 2];
        file_builder b = netcdf_end_file(&n);
        rewriting_in_place(b.data, b.size, 1, *state, "in.exo");
        builder_release(&b);
    }
    hdf5_superblock = 0;
#endif
}

/* ---- other files ---------------------------------------------------------------------------- */

#ifdef PL_HDF5

/** Ways in which a variable's values can be in another file. */
typedef enum outside_way { BY_LINK, BY_STORAGE, BY_VIRTUAL, N_WAYS } outside_way;

/** Put in place of the variable at path in a netCDF-4 file that of the file outside. */
static void put_outside(const char *file_path, const char *path, const char *outside,
                        outside_way way) {
    const hid_t file = H5Fopen(file_path, H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t old = H5Dopen2(file, path, H5P_DEFAULT), type = H5Dget_type(old);
    const hid_t space = H5Dget_space(old), list = H5Pcreate(H5P_DATASET_CREATE);
    assert_true(file >= 0 && old >= 0 && type >= 0 && space >= 0 && list >= 0);
    H5Dclose(old);
    assert_true(H5Ldelete(file, path, H5P_DEFAULT) >= 0);
    if (way == BY_LINK) {
        assert_true(H5Lcreate_external(outside, path, file, path, H5P_DEFAULT, H5P_DEFAULT) >= 0);
    } else {
        if (way == BY_STORAGE)
            assert_true(H5Pset_external(list, outside, 0, H5F_UNLIMITED) >= 0);
        else
            assert_true(H5Pset_virtual(list, space, outside, path, space) >= 0);
        const hid_t made = H5Dcreate2(file, path, type, space, H5P_DEFAULT, list, H5P_DEFAULT);
        assert_true(made >= 0);
        H5Dclose(made);
    }
    H5Pclose(list);
    H5Sclose(space);
    H5Tclose(type);
    H5Fclose(file);
}

/** Write in/mesh.e, whose variable at path is in the file outside. */
static void write_with_outside(const char *folder, const char *path, const char *outside,
                               outside_way way) {
    char file_path[TEST_PATH_SIZE];
    netcdf_builder n;
    put_mesh(&n, 4, 0, NETCDF_AS_DOUBLE);
    file_builder b = netcdf_end_file(&n);
    test_write(folder, "in/mesh.e", b.data, (size_t)b.size);
    builder_release(&b);
    put_outside(test_path(file_path, folder, "in/mesh.e"), path, outside, way);
}

/** The file outside is a mesh with all variables: whoever opens it reads a mesh. */
static void no_other_file_is_opened(void **state) {
    static const char *const needed[] = {"/coordx", "/connect1", "/eb_prop1"};
    static const char *const words[] = {[BY_LINK] = "is a link to another file",
                                        [BY_STORAGE] = "stored in other files",
                                        [BY_VIRTUAL] = "virtual dataset"};
    char path[TEST_PATH_SIZE], outside[TEST_PATH_SIZE];
    const char *folder = *state;
    netcdf_builder n;
    put_mesh(&n, 4, 0, NETCDF_AS_DOUBLE);
    file_builder b = netcdf_end_file(&n);
    test_write(folder, "outside.e", b.data, (size_t)b.size);
    builder_release(&b);
    planish_file_close(folder_open(folder, "outside.e"));
    test_path(outside, folder, "outside.e");
    test_folder_in(path, folder, "in");
#ifdef __linux__
    const int watch = inotify_init1(IN_NONBLOCK);
    assert_true(inotify_add_watch(watch, outside, IN_OPEN) >= 0);
#endif
    for (int way = 0; way < N_WAYS; way++) {
        planish_data data;
        planish_error error = {.text = ""};
        for (size_t i = 0; i < sizeof needed / sizeof *needed; i++) {
            write_with_outside(folder, needed[i], outside, (outside_way)way);
            folder_open_fails(folder, "in/mesh.e", words[way]);
        }
        write_with_outside(folder, "/vals_nod_var1", outside, (outside_way)way);
        if (way == BY_LINK) {
            folder_open_fails(folder, "in/mesh.e", words[way]);
            continue;
        }
        planish_file *file = folder_open(folder, "in/mesh.e");
        assert_int_not_equal(planish_file_data(file, "size", &data, &error), 0);
        assert_non_null(strstr(error.text, "there is no array 'size'"));
        planish_file_close(file);
    }
#ifdef __linux__
    char event[512];
    assert_int_equal(read(watch, event, sizeof event), -1);
    close(watch);
#endif
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_mesh_is_read_in_every_kind),
        cmocka_unit_test(sets_are_groups),
        cmocka_unit_test(names_of_one_number_are_groups),
        cmocka_unit_test(shared_nodes_are_held),
        cmocka_unit_test(a_plane_is_read),
        cmocka_unit_test(data_are_read),
        cmocka_unit_test(wrong_data_are_refused),
        cmocka_unit_test(wrong_values_are_refused),
        cmocka_unit_test(wrong_shapes_are_refused),
        cmocka_unit_test(other_files_are_refused),
        cmocka_unit_test(missing_variables_are_refused),
        cmocka_unit_test(shared_bytes_are_refused),
        cmocka_unit_test(no_header_breaks_it),
        cmocka_unit_test(nothing_breaks_it),
        cmocka_unit_test_setup_teardown(coordinates_alone_are_written, test_folder_create,
                                        test_folder_remove),
#ifdef PL_HDF5
        cmocka_unit_test_setup_teardown(no_other_file_is_opened, test_folder_create,
                                        test_folder_remove),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
