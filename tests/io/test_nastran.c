/* Nastran bulk data: fields of every kind, what is held, what is refused, what is written. */
#include "support/file_builder.h"
#include "support/files.h"
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

static const io_format *const format = &io_format_nastran;

/* A tetrahedron about node 20, in fields of all kinds. */
static const char solid[] =
    "SOL 101\nCEND\nTITLE = a GRID in a title\nINCLUDE 'case.inc'\nBEGIN BULK\n"
    "$ a comment\n"
    "$HMNAME PROP                   7\"core part\" 5\n"
    "CTETRA  11      7       10      12      13      20\n"
    "GRID    10              0.      0.      0.\n"
    "GRID*   12                              1.              0.              MARK\n"
    "*MARK   0.              \n"
    "GRID,13,,0.,1.0+0,0.\n"
    "grid*,14,,.0,0.D0,*\n"
    "*,1000.-3\n"
    "GRID    20              .25     .25     .25$ inside\n"
    "\n"
    "CTETRA*,12,7,10,12,\n*,14,20\n"
    "CTETRA* 13              8               10              13\n"
    "$ between\n"
    "*       14              20\n"
    "CTETRA  14      8       12      13      14      20\n+\n"
    "CTRIA3  21      3       10      12      13\n"
    "CBAR    31      4       10      12      0.      0.      1.\n"
    "FORCE   1       20      0       1.      1.      0.      0.\n"
    "ENDDATA\nGRID    10\n";

static void every_kind_of_field_is_read(void **state) {
    (void)state;
    planish_file *file = reading_text(format, solid);
    const planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    reading_gave_four(&mesh);
    assert_int_equal(planish_file_node_number(file, 4), 20);
    assert_int_equal(planish_file_element_number(file, 3), 14);
    assert_int_equal(info.precision, PLANISH_PRECISION_ROUNDED);
    assert_true(info.round(1.0 / 3, info.round_user) == .3333333);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_lower_elements, 2);
    assert_int_equal(file->model.line.n, 1);
    assert_int_equal(file->model.n_groups, 1);
    assert_string_equal(file->model.group[0].name, "core part");
    planish_file_close(file);
}

#define NINE                                                                                       \
    "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,0.,1.,0.\nGRID,4,,0.,0.,1.\nGRID,5,,5.,0.,1.\n"   \
    "GRID,6,,6.,0.,1.\nGRID,7,,7.,0.,1.\nGRID,8,,8.,0.,1.\nGRID,9,,9.,0.,1.\n"                     \
    "CTETRA,1,1,1,2,3,4\n"

/** Nodes that a text and a tag (or NULL) hold, whatever the regions: constraints as digits. */
typedef struct held_case {
    const char *text, *tag, *held;
} held_case;

static void expect_all_held(const held_case *cases, size_t n) {
    for (size_t i = 0; i < n; i++)
        reading_text_holds(format, cases[i].text, cases[i].tag, 0, cases[i].held);
}

static void nodes_are_held(void **state) {
    (void)state;
    static const held_case cases[] = {
        {NINE, NULL, "000000000"},
        {NINE, "1", "111100000"},
        {NINE "CTRIA3,2,1,5,6,7\n", NULL, "000011100"},
        {NINE "CTRIA3,2,1,5,6,7\n", "2:1", "000011100"},
        {NINE "CQUAD4,2,1,5,6,7,8,3,.5\n", NULL, "000011110"},
        {NINE "CHEXA,2,1,1,2,3,4,5,6\n,7,8\n", NULL, "000000000"},
        {NINE "CBAR,2,1,5,6,1.,0.,0.\n", NULL, "000011000"},
        {NINE "CBEAM,2,1,5,6,9\nCBUSH,3,1,5,6,8\n", NULL, "000011011"},
        {NINE "CGAP,2,1,5,6,1.,0.,0.\n", NULL, "000011000"},
        {NINE "CONROD,2,5,6,7,1.\n", NULL, "000011000"},
        {NINE "CELAS1,2,1,5,1,6,3\n", NULL, "000011000"},
        {NINE "CONM2,2,9,0,1.5\n", NULL, "000000001"},
        {NINE "RBE2,2,5,3,6,7,8\n", NULL, "000011110"},
        {NINE "RBE3,2,,5,3,1.,4,6,7,\n,8,1.,2,9\n", NULL, "000011111"},
        {NINE "MPC,2,5,1,1.,6,2,-1.\n,,7,3,1.,8,1,1.\n", NULL, "000011110"},
        {NINE "COTHER,2,1,9\n", NULL, "000000001"},
        {NINE "RBE2,2,1,3,1,2,3,4,1,+\n+,5\n", NULL, "111110000"},
        {NINE "RBE2,2,1,3,1,2,3,4,1,+1,,\n+1,5\n", NULL, "111110000"},
        {NINE "RBE2,2,1,3,1,2,3,4,1,A\t\n,5,\t6\n", NULL, "111111000"},
        {NINE "RBAR1,2,8,9,123\n", NULL, "000000011"},
        {NINE "RJOINT,2,6,7,123\n", NULL, "000001100"},
        {NINE "RSSCON,2,GRID,5,8,9\n", NULL, "000010011"},
        {NINE "ROTHER,1,6,7,.5,8\n", NULL, "000001110"},
        {NINE "RFORCE,2,5,,1.,0.,0.,1.\nRLOAD1,5,6,7\nRELEASE,6,7,8\n", NULL, "000000000"},
        {NINE "CORD1R,1,7,8,9,2,5,6,7\n", NULL, "000011111"},
        {NINE "CORD1C,1,7,8,9\nCORD1S,6,5,1,2\n", NULL, "110010111"},
        {NINE "CORD3R,1,7,8,9\n", NULL, "000000111"},
        {NINE "CORD2R,9,8,7,6,5,4,3,2\n", NULL, "000000000"},
        {NINE "SPC1,9,123,1,2\nFORCE,1,3,0,1.\nTEMP,1,5,20.\n", NULL, "000000000"},
        {NINE "$HMNAME PROP 1\"one\"\n", "one", "111100000"},
    };
    expect_all_held(cases, sizeof cases / sizeof *cases);
}

/** All nodes from the one to the other, in files whose numbers are in order and in others. */
static void ranges_are_held(void **state) {
    (void)state;
    static const held_case cases[] = {
        {NINE "RBE2,2,1,3,5,THRU,8\n", NULL, "100011110"},
        {NINE "RBE2,2,1,3,8,THRU,99\n", NULL, "100000011"},
        {NINE "RBE2,2,1,3,7,thru,9\nRBE2,3,1,3,2,THRU,3\n"
              "RBE2,4,1,3,3,THRU,4\n",
         NULL, "111100111"},
        {"GRID,99\nGRID,77\nGRID,88\n" NINE "RBE2,2,1,3,8,THRU,80\n", NULL, "010100000011"},
        {NINE "RBE2,2,1,3,5,THRU\nRBE2,2,1,3,5,THRU,4\n", NULL, "100110000"},
    };
    expect_all_held(cases, sizeof cases / sizeof *cases);
}

/** Words that are cards' names in lines that go on with a card; and other ends of files. */
static void lines_that_begin_with_blanks_go_on(void **state) {
    (void)state;
    static const held_case cases[] = {
        {NINE "RBE2,2,5,3,6\n ,7\n    $ GRID\n  x\n", NULL, "000011100"},
        {NINE "DESVAR,1\n        GRID    1\n"
              "  GRIDS 1\n",
         NULL, "000000000"},
        {NINE "COTHER,2,1,9\nENDDATA", NULL, "000000001"},
        {NINE "COTHER,2,1,9\r", NULL, "000000001"},
        {NINE "COTHER,2,1,9,-9223372036854775808\n", NULL, "000000001"},
    };
    expect_all_held(cases, sizeof cases / sizeof *cases);
}

static void regions_are_properties(void **state) {
    (void)state;
    planish_file *file = reading_text(format, solid);
    uint8_t constraint[5];
    planish_error error;
    assert_int_equal(planish_file_constraints(file, NULL, constraint, &error), 0);
    assert_int_equal(constraint[4], PLANISH_CONSTRAINT_FIXED);
    planish_file_close(file);
    /* None is one. */
    file = reading_text(format, NINE "CTETRA,2,,2,3,4,5\nCTETRA,3,,2,4,5,6\n");
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 2);
    planish_file_close(file);
}

/** Each name costs the same: if it were to look at all properties, minutes. */
static void properties_may_be_many(void **state) {
    (void)state;
    enum { N = 200000 };
    file_builder b = {.data = NULL};
    builder_text(&b, NINE);
    for (int i = 0; i < N; i++)
        builder_text(&b, "CTETRA,%d,%d,1,2,3,4\n$HMNAME PROP %d\"p%d\"\n", i + 2, i + 2, i + 2, i);
    planish_file *file = builder_file(&b, format);
    assert_int_equal(file->model.n_groups, N);
    planish_file_close(file);
    builder_release(&b);
}

static void systems_are_looked_at(void **state) {
    (void)state;
    planish_file_close(reading_text(
        format,
        "GRID,1,5,0.,0.\nGRID,2,5,1.\nGRID,3,5,,1.\nCTRIA3,1,1,1,2,3\nCORD2R,5,,0.,0.,0.\n"));
    planish_file_close(reading_text(format, "GRDSET,,5\nGRID,1,,0.,0.\nGRID,2,,1.\nGRID,3,5,,1.\n"
                                            "CTRIA3,1,1,1,2,3\nCORD1R,4,1,2,3,5,1,2,3\n"));
    reading_fails(format, "GRID,1,5,0.,0.\nGRID,2,,1.\nGRID,3,5,,1.\nCTRIA3,1,1,1,2,3\n",
                  "test:2: GRIDs are in coordinate systems 5 and 0");
    reading_fails(format,
                  "GRID,1,5,0.,0.\nGRID,2,5,1.\nGRID,3,5,,1.\nCTRIA3,1,1,1,2,3\n"
                  "CORD2C,5,,0.,0.,0.\n",
                  "no CORD1R or CORD2R");
}

/** Nodes of elements, as the Quick Reference Guide numbers them. */
static const struct {
    const char *nodes;
    int type;
    const char *names[8];
} types[] = {
    {"1 2 3 4",
     PLANISH_CELL_QUADRILATERAL,
     {"CQUAD4", "CQUADR", "CSHEAR", "CQUAD8", "CQUAD", "CPLSTN4", "CPLSTS4"}},
    {"1 2 3 12 23 31", PLANISH_CELL_TRIANGLE6, {"CTRIA6", "CPLSTN6", "CPLSTS6", "CTRIAX"}},
    {"1 12 2 23 3 31", PLANISH_CELL_TRIANGLE6, {"CTRIAX6", "CTRAX6"}},
    {"1 2 3 4 12 23 34 41", PLANISH_CELL_QUADRILATERAL8, {"CQUAD8", "CQUAD", "CPLSTN8", "CPLSTS8"}},
    {"1 2 3 4 12 23 34 41 1234", PLANISH_CELL_QUADRILATERAL9, {"CQUAD", "CQUADX"}},
    {"1 2 3 4 12 23 31 14 24 34", PLANISH_CELL_TETRAHEDRON10, {"CTETRA"}},
    {"1 2 3 4 5", PLANISH_CELL_PYRAMID, {"CPYRAM", "CPYRA"}},
    {"1 2 3 4 5 12 23 34 41 15 25 35 45", PLANISH_CELL_PYRAMID13, {"CPYRAM", "CPYRA"}},
    {"1 2 3 4 5 6", PLANISH_CELL_WEDGE, {"CPENTA"}},
    {"1 2 3 4 5 6 7 8", PLANISH_CELL_HEXAHEDRON, {"CHEXA"}},
    {"1 2 3 4 5 6 12 23 31 14 25 36 45 56 64", PLANISH_CELL_WEDGE15, {"CPENTA"}},
    {"1 2 3 4 5 6 7 8 12 23 34 41 15 26 37 48 56 67 78 85", PLANISH_CELL_HEXAHEDRON20, {"CHEXA"}},
};

/** Write an element of number 7; without node number missing. Return its length. */
static int write_element(char *text, size_t size, const char *name, int n, double x[UNIT_NODES][3],
                         int missing) {
    int length = 0;
    for (int i = 0; i < n; i++)
        length += snprintf(text + length, size - (size_t)length, "GRID,%d,,%.8f,%.8f,%.8f\n", i + 1,
                           x[i][0], x[i][1], x[i][2]);
    length += snprintf(text + length, size - (size_t)length, "%s,7,1", name);
    for (int i = 0; i < n; i++) {
        const char *before = i > 0 && (i + 2) % 8 == 0 ? "\n," : ",";
        length += i + 1 == missing
                      ? snprintf(text + length, size - (size_t)length, "%s", before)
                      : snprintf(text + length, size - (size_t)length, "%s%d", before, i + 1);
    }
    return length + snprintf(text + length, size - (size_t)length, "\n");
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    char text[4096];
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        for (int j = 0; j < 8 && types[i].names[j]; j++)
            for (int swapped = 0; swapped < 2; swapped++) {
                double x[UNIT_NODES][3];
                const int n = unit_places(types[i].type, types[i].nodes, x);
                if (swapped)
                    unit_swap(types[i].type, n, x);
                const int length = write_element(text, sizeof text, types[i].names[j], n, x, 0);
                planish_file *file = reading_text(format, text);
                if (!swapped)
                    unit_expect(file, 0, types[i].type);
                unit_expect_alone(file, types[i].type, 7, unit_is_smoothed(types[i].type) ? 0 : n,
                                  !swapped);
                reading_every_beginning(format, text, length);
            }
}

/** A mid that is missing is in the middle of its edge; 0 says the same, and so does a word. */
static void mids_may_be_missing(void **state) {
    (void)state;
    char text[4096];
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        double x[UNIT_NODES][3];
        const int n = unit_places(types[i].type, types[i].nodes, x);
        for (int node = 1; node <= n; node++) {
            const char *at = types[i].nodes;
            for (int word = 1; word < node; word++)
                at = strchr(at, ' ') + 1;
            if (at[1] == '\0' || at[1] == ' ' || at[2] == '3') /* a corner; the inside */
                continue;
            write_element(text, sizeof text, types[i].names[0], n, x, node);
            planish_file *file = reading_text(format, text);
            unit_expect(file, 0, types[i].type);
            unit_expect_alone(file, types[i].type, 7, unit_is_smoothed(types[i].type) ? 0 : n - 1,
                              1);
        }
    }
    static const char *const straight[] = {"CTETRA,1,1,1,2,3,4\n", "CTETRA,1,1,1,2,3,4,0,0\n,0,0\n",
                                           "CTETRA,1,1,1,2,3,4\n,CORDM,1\n",
                                           "CTETRA,1,1,1,2,3,4,,\n,,\n"};
    for (size_t i = 0; i < sizeof straight / sizeof *straight; i++) {
        char whole[512];
        snprintf(whole, sizeof whole, "GRID,1\nGRID,2,,1.\nGRID,3,,0.,1.\nGRID,4,,0.,0.,1.\n%s",
                 straight[i]);
        planish_file *file = reading_text(format, whole);
        assert_int_equal(planish_file_mesh(file).n_elements, 1);
        assert_int_equal(file->model.hold[0], 0);
        planish_file_close(file);
    }
    planish_file *file = reading_text(format, NINE "CTRIA3,2,1,1,2,3\nCTRIA6,3,1,1,2,4\n");
    assert_int_equal(file->model.triangle.n, 2);
    planish_file_close(file);
}

/* Tetrahedra of both orders and a triangle: unit_expect_both_orders. */
#define BOTH_ORDERS                                                                                \
    "GRID,1\nGRID,2,,1.\nGRID,3,,0.,1.\nGRID,4,,0.,0.,1.\nGRID,5,,1.,1.,1.\nGRID,6,,.5,.5\n"       \
    "GRID,7,,,.5,.5\nGRID,8,,.5,,.5\nGRID,9,,1.,.5,.5\nGRID,10,,.5,1.,.5\nGRID,11,,.5,.5,1.\n"     \
    "CTETRA,2,2,2,3,4,5,6,7\n,8,9,10,11\nCTETRA,1,1,1,2,3,4\nCTRIA6,3,3,3,4,5,7,11,10\n"

/** Simplices come first, then the others in the order of the file. */
static void both_orders_may_be_in_a_file(void **state) {
    planish_file *file = reading_text(format, "GRID,10,,.5,.5,.0\nCTETRA,5,1,1,2,3,4,10\n" NINE
                                              "CQUAD4,8,1,1,2,3,4\n");
    static const int32_t nodes[] = {1, 2, 3, 4, 0, -1, -1, -1, -1, -1, 1, 2, 3, 4};
    planish_cells cells;
    planish_error error;
    assert_int_equal(planish_file_cells(file, &cells, &error), 0);
    assert_int_equal(cells.n, 2);
    assert_int_equal(cells.type[0], PLANISH_CELL_TETRAHEDRON10);
    assert_int_equal(cells.type[1], PLANISH_CELL_TETRAHEDRON);
    assert_memory_equal(cells.node, nodes, sizeof nodes);
    assert_int_equal(planish_file_element_number(file, 0), 5);
    assert_int_equal(planish_file_element_number(file, 1), 1);
    planish_file_close(file);
    file = reading_text(format, BOTH_ORDERS);
    unit_expect_both_orders(file, 0);
    assert_int_equal(file->model.entity[file->model.triangle.entity[0]].tag, 3);
    unit_expect_held(file, NULL, "00111010011");
    planish_file_close(file);
    /* Node 12 is a mid, and the first node. */
    rewriting_gives(format, "GRID,12,,.5,.0,.0\n" BOTH_ORDERS "CTETRA,7,1,1,2,3,4,12\n", "xyz",
                    "GRID,12,,.125,-.333333,123456.8\n" BOTH_ORDERS "CTETRA,7,1,1,2,3,4,12\n",
                    *state);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    reading_fails(format, "", "no GRID");
    reading_fails(format, "BEGIN BULK\nENDDATA\n", "no GRID");
    reading_fails(format, "GRID,1\nGRID,2,,1.\n", "nothing to smooth");
    reading_fails(format, NINE "GRID,3,,0.,0.,2.\nGRID,77\n", "node number 3 occurs twice");
    reading_fails(format, NINE "CTETRA,2,1,1,2,3,10\n", "test:11: CTETRA 2: there is no node 10");
    reading_fails(format, NINE "CTETRA,2,1,1,2,3\n", "a node is missing");
    reading_fails(format, NINE "CTETRA,2,1,1,2,x,4\n", "'x'");
    reading_fails(format, NINE "CTETRA,2,1,1,2,3,4,5,6\n,7,8,9,10\n",
                  "test:12: CTETRA 2: there is no node 10");
    reading_fails(format, NINE "CTETRA,2,1,1,2,3,4,5,-6\n", "'-6' is not the number of a mid-side");
    reading_fails(format, NINE "CTRIA6,2,1,1,2\n", "a node is missing");
    reading_fails(format, NINE "CHEXA,2,1,1,2,3,4,5,6\n,7\n", "a node is missing");
    reading_fails(format, NINE "CHEXA,2,1,1,2,3,4,5,6\n,7,11\n", "CHEXA 2: there is no node 11");
    reading_fails(format, NINE "GRID,x\n", "'x'");
    reading_fails(format, NINE "GRID,-1\n", "'-1'");
    reading_fails(format, NINE "GRID,99999999999\n", "'99999999999'");
    reading_fails(format, NINE "GRID,10,,1.x\n", "node 10: '1.x' is not a coordinate");
    reading_fails(format, NINE "GRID,10,,nan\n", "finite");
    reading_fails(format, NINE "GRID,10,,1.+999\n", "finite");
    reading_fails(format, NINE "GRID    10\t\t1.\n", "expand");
    reading_fails(format, NINE "GRID*   10                              1.\n*\t5.\n",
                  "test:12: GRID: a tab");
    reading_fails(format, NINE "RBE2    2       5       3       6\n+\t7\n", "expand");
    reading_fails(format, NINE "GRID*,10,,1.,2.,7\n", "test:11: GRID: a number behind the four");
    reading_fails(format, NINE "GRID*,10,,1.,2.,*,-.5\n*,3.\n", "a number behind the four");
    reading_fails(format, NINE "RBE2,2,5,3,6,7,8,9,1,2\n", "a number behind the eight");
    reading_fails(format, NINE "GRID,=,,*(1.),=\n", "test:11: GRID: replication");
    reading_fails(format, NINE "GRID,*(1),,*(1.),=\n", "replication");
    reading_fails(format, NINE "=,*(1),,*(1.),==\n=(3)\n", "test:11: =: replication");
    reading_fails(format, NINE "RBE2,2,=,3,6\n", "replication");
    reading_fails(format, NINE " RBE2,2,5,3,6\n", "test:11: RBE2 behind blanks");
    reading_fails(format, NINE "\tgrid*   9\n", "GRID behind blanks");
    reading_fails(format, NINE "CTR",
                  "test:11: there is no ENDDATA, and the last line has no line end");
    reading_fails(format, NINE "INCLUDE 'mesh.bdf'\n", "mesh.bdf: ");
    reading_fails(format, "BEGIN BULK\n" NINE "BEGIN SUPER=1\n", "superelements");
    reading_gives_surface(
        format,
        "GRID,1\nGRID,2,,1.\nGRID,3,,,1.,1.\nGRID,4,,1.,1.\nCTRIA3,1,1,1,2,3\nCTRIA3,2,1,2,4,3\n");
}

static void contents_are_recognised(void **state) {
    (void)state;
    static const char *const yes[] = {solid,
                                      NINE,
                                      "$Comment\nGRID*   1       \n",
                                      "begin bulk\n",
                                      "  BEGIN   BULK $ x",
                                      "\xef\xbb\xbfGRID,1,,0.\n",
                                      "Grid of the wing\nGRID    12      \n"};
    static const char *const no[] = {"",
                                     "$MeshFormat\n4.1 0 8\n",
                                     "GRID\n",
                                     "GRIDS 1\n",
                                     "BEGINBULK",
                                     "*NODE\n1,2\n",
                                     "BEGIN\n",
                                     "Grid of the wing, 2nd version\n",
                                     "GRID 2nd version\n"};
    reading_tells(format, yes, sizeof yes / sizeof *yes, 1);
    reading_tells(format, no, sizeof no / sizeof *no, 0);
    assert_ptr_equal(io_format_find("x.dat", solid, sizeof solid - 1), format);
    /* Much may be before it: comments, of a kind that looks like Gmsh's sections, too. */
    enum { LINES = 4000 };
    static const char comment[] = "$ANSA_VERSION;22.1.0;  a comment\n";
    char *text = malloc(LINES * (sizeof comment - 1) + sizeof solid);
    for (int i = 0; i < LINES; i++)
        memcpy(text + (size_t)i * (sizeof comment - 1), comment, sizeof comment - 1);
    memcpy(text + LINES * (sizeof comment - 1), solid, sizeof solid);
    assert_ptr_equal(io_format_find("x.dat", text, (int64_t)strlen(text)), format);
    assert_false(io_format_gmsh.recognise(text, (int64_t)strlen(text)));
    free(text);
}

static void bad_files_do_no_harm(void **state) {
    (void)state;
    file_builder builder = {.data = NULL};
    for (const char *line = solid, *end; *line; line = end + 1) {
        end = strchr(line, '\n');
        builder_text(&builder, "%.*s\n", (int)(end - line), line);
    }
    builder_try_to_break(&builder, format);
    builder_release(&builder);
}

/** Line ends of every kind, none at the end. */
static void line_ends_may_be_any(void **state) {
    (void)state;
    char *text = malloc(2 * sizeof solid);
    for (int kind = 0; kind < 3; kind++) {
        size_t n = 0;
        for (const char *c = solid; *c; c++) {
            if (*c == '\n' && kind > 0)
                text[n++] = '\r';
            if (*c != '\n' || kind < 2)
                text[n++] = *c;
        }
        text[n] = '\0';
        *strstr(text, "ENDDATA") = '\0';
        planish_file *file = reading_text(format, text);
        assert_int_equal(planish_file_mesh(file).n_elements, 4);
        assert_true(planish_file_mesh(file).coordinates[14] == .25);
        planish_file_close(file);
    }
    free(text);
}

/* ---- writing ------------------------------------------------------------------------------ */

/* A mesh of long fields, so that a GRID before it decides how wide the narrowest is. */
static const char four[] =
    "GRID*   1                               0.              0.              \n*       0.\n"
    "GRID*   2                               1.              0.              \n*       0.\n"
    "GRID*   3                               0.              1.              \n*       0.\n"
    "GRID*   4                               0.              0.              \n*       1.\n"
    "CTETRA  1       1       1       2       3       4\n";

/** The file that begins with these lines, which have node 0: rewriting_gives. */
static void check_writing(void **state, const char *before, const char *move, const char *after) {
    char text[1024], expected[1024];
    snprintf(text, sizeof text, "%s%s", before, four);
    snprintf(expected, sizeof expected, "%s%s", after, four);
    rewriting_gives(format, text, move, expected, *state);
}

static void numbers_are_put_into_their_columns(void **state) {
    static const char *const cases[][3] = {
        {"GRID    5       0       1.      2.      3.      \n", "xyz",
         "GRID    5       0       .125    -.333333123456.8\n"},
        {"GRID    5       0       1.      2.      3.      7\n", "y",
         "GRID    5       0       1.      -.3333333.      7\n"},
        {"GRID    5       0            1.      2.       3\n", "xz",
         "GRID    5       0       .125         2. 123456.8\n"},
        {"GRID    5       0       1.      2.      3.\n", "y",
         "GRID    5       0       1.      -.3333333.\n"},
        {"GRID    5       0       1.      2.      3.\n", "",
         "GRID    5       0       1.      2.      3.\n"},
        {"GRID    5       0       1.      2.      3.\n", "z",
         "GRID    5       0       1.      2.      123456.8\n"},
        {"GRID    5       0       1.      2.      123456.78\n", "x",
         "GRID    5       0       .125    2.      123456.78\n"},
        {"GRID*   5               0               1.              2.              M\n*M      3.\n",
         "xyz",
         "GRID*   5               0               .125            -.33333333333333M\n"
         "*M      123456.789\n"},
        {"GRID*   5               0               1.              2.\n$ c\n\n*       3.      \n",
         "z",
         "GRID*   5               0               1.              2.\n$ c\n\n"
         "*       123456.789\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_writing(state, cases[i][0], cases[i][1], cases[i][2]);
}

static void fields_that_are_not_there_are_made(void **state) {
    static const char *const cases[][3] = {
        {"GRID    5\n", "x", "GRID    5               .125\n"},
        {"GRID    5\n", "z", "GRID    5                               123456.8\n"},
        {"GRID    5\n", "xyz", "GRID    5               .125    -.333333123456.8\n"},
        {"GRID    5               1.\n", "z", "GRID    5               1.              123456.8\n"},
        {"GRID    5               1.\r\n", "xz",
         "GRID    5               .125            123456.8\r\n"},
        {"GRID    5               1.$ c\n", "y", "GRID    5               1.      -.333333$ c\n"},
        {"GRID    5               1.      2\n", "z",
         "GRID    5               1.      2       123456.8\n"},
        {"GRID    5                       2.      \n", "x",
         "GRID    5               .125    2.      \n"},
        {"GRID*   5\n*\n", "z", "GRID*   5\n*       123456.789\n"},
        {"GRID*   5                               1.\n", "yz",
         "GRID*   5                               1.              -.33333333333333\n"
         "*       123456.789\n"},
        {"GRID*   5                               1.              2.              M\r\n", "z",
         "GRID*   5                               1.              2.              M\r\n"
         "*M      123456.789\r\n"},
        {"GRID*   5                               1.              2.              +ABCDEFG9\n", "z",
         "GRID*   5                               1.              2.              +ABCDEFG9\n"
         "*ABCDEFG123456.789\n"},
        {"GRID*   5                               1.              2.              * 7\r", "z",
         "GRID*   5                               1.              2.              * 7\r"
         "*7      123456.789\r"},
        {"GRID*   5                               1.      $       c                       x\n", "z",
         "GRID*   5                               1.      $       c                       x\n"
         "*       123456.789\n"},
        {"GRID*   5                               1.      $ c\n", "yz",
         "GRID*   5                               1.              -.33333333333333$ c\n"
         "*       123456.789\n"},
        {"GRID*   5                               1.              2.              \n", "xz",
         "GRID*   5                               .125            2.              \n"
         "*       123456.789\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_writing(state, cases[i][0], cases[i][1], cases[i][2]);
}

static void free_fields_keep_their_commas(void **state) {
    static const char *const cases[][3] = {
        {"\xef\xbb\xbfGRID,5,,1.,2.,3.\n", "y", "\xef\xbb\xbfGRID,5,,1.,-.333333,3.\n"},
        {"GRID,5,,1.,2.,3.,7\n", "xyz", "GRID,5,,.125,-.333333,123456.8,7\n"},
        {"GRID, 5 ,, 1. , 2. ,3. $ c\n", "y", "GRID, 5 ,, 1. , -.333333 ,3. $ c\n"},
        {"GRID,5,,,2.\n", "xz", "GRID,5,,.125,2.,123456.8\n"},
        {"GRID,5\n", "z", "GRID,5,,,,123456.8\n"},
        {"GRID,5\n", "x", "GRID,5,,.125\n"},
        {"GRID,5,,\n", "y", "GRID,5,,,-.333333\n"},
        {"GRID,5,,1.23456789,2.,3.\n", "yz", "GRID,5,,1.23456789,-.33333333333333,123456.789\n"},
        {"GRID*,5,,1.\n*,3.\n", "y", "GRID*,5,,1.,-.33333333333333\n*,3.\n"},
        {"GRID*,5,,1.,2.\n", "z", "GRID*,5,,1.,2.\n*,123456.789\n"},
        {"GRID*,5,,1.,2.\r\n", "z", "GRID*,5,,1.,2.\r\n*,123456.789\r\n"},
        {"GRID*,5,,1.,2.,*\n*,3.,7\n", "xz", "GRID*,5,,.125,2.,*\n*,123456.789,7\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_writing(state, cases[i][0], cases[i][1], cases[i][2]);
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_of_field_is_read),
        cmocka_unit_test(nodes_are_held),
        cmocka_unit_test(ranges_are_held),
        cmocka_unit_test(lines_that_begin_with_blanks_go_on),
        cmocka_unit_test(regions_are_properties),
        cmocka_unit_test(properties_may_be_many),
        cmocka_unit_test(systems_are_looked_at),
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(mids_may_be_missing),
        IN_A_FOLDER(both_orders_may_be_in_a_file),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(contents_are_recognised),
        cmocka_unit_test(bad_files_do_no_harm),
        cmocka_unit_test(line_ends_may_be_any),
        IN_A_FOLDER(numbers_are_put_into_their_columns),
        IN_A_FOLDER(fields_that_are_not_there_are_made),
        IN_A_FOLDER(free_fields_keep_their_commas),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
