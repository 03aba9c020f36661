/* Abaqus input files: nodes, elements, sets, what is held, what is refused, what is written. */
#include "support/file_builder.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const io_format *const format = &io_format_abaqus;

/* A cube's corner in four tetrahedra about node 50, in two sections; nodes in two blocks. */
static const char solid[] =
    "** made by hand\n*Heading\n 1, 2, 3 is no node\n*Preprint, echo=NO\n"
    "*nOdE , NSET = \"Some Nodes\"\n"
    "  10, 0., 0., 0.\n** a comment\n12,1.,0.\n\n\t13 ,, 1.0D0 ,\n"
    "*NODE\n7,0,0,+1E0, 0., 0., 1.\n50,.25,.25,.25\n"
    "*ELEMENT, TYPE=C3D4,\n ELSET=Inner\n"
    "11, 10, 12, 13, 50\n 12, 10, 12,\n 7, 50\n"
    "*Element,Type = c3d4h\n13,10,13,7,50\n14,12,13,7,50,\n"
    "*ELEMENT, TYPE=S3R, ELSET=Skin\n21,10,12,13\n"
    "*ELEMENT, TYPE=B31, ELSET=Rib\n31, 10, 12\n"
    "*ELSET, ELSET=Outer\n13, 14\n"
    "*ELSET, ELSET=All\nINNER, outer, 21\n"
    "*ELSET, ELSET=Odd, GENERATE\n 11, 31, 2\n"
    "*NSET, NSET=Top, GENERATE\n 7, 12\n"
    "*NSET, NSET=both\n\"SOME nodes\", Top, 50\n"
    "*NSET, NSET=ofrib, ELSET=Rib\n"
    "*SOLID SECTION, ELSET=Inner, MATERIAL=A\n*SOLID SECTION, ELSET=Outer, MATERIAL=A\n"
    "*BOUNDARY\n50, 1, 3\n*STEP\n*STATIC\n*NODE PRINT\nU\n*NODE FILE\nU\n*END STEP\n";

static void everything_is_read(void **state) {
    (void)state;
    planish_file *file = reading_text(format, solid);
    const planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    reading_gave_four(&mesh);
    assert_int_equal(planish_file_node_number(file, 4), 50);
    assert_int_equal(planish_file_element_number(file, 3), 14);
    assert_int_equal(info.precision, PLANISH_PRECISION_ROUNDED);
    assert_true(info.round(1.0 / 300, info.round_user) == 1.0 / 300);
    assert_true(info.round(-1.0 / 3e7, info.round_user) == -3.33333333333333e-8);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_lower_elements, 2);
    assert_int_equal(file->model.hold[0], IO_HELD_BY_LINE | IO_HELD_BY_FACE);
    assert_int_equal(file->model.hold[4], 0);
    planish_file_close(file);
}

/* Two tetrahedra that share a face, and nodes 6 to 9 of none. */
#define PAIR                                                                                       \
    "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n6,6,0,0\n7,7,0,0\n8,8,0,0\n9,9,0,0\n"     \
    "*ELEMENT,TYPE=C3D4\n1,1,2,3,4\n2,2,3,4,5\n"

#define AGAIN                                                                                      \
    "*NODE,NSET=A\n1,0,0,0\n2,1,0,0\n3,0,1,0\n1,0,0,0\n4,0,0,1\n"                                  \
    "*NODE,NSET=B\n1,0,0,0\n5,1,1,1\n*ELEMENT,TYPE=C3D4\n1,1,2,3,4\n2,2,3,4,5\n"

static void sets_are_groups(void **state) {
    (void)state;
    static const struct {
        const char *text, *tag, *held;
    } cases[] = {
        {PAIR, NULL, "000000000"},
        {PAIR "*ELSET,ELSET=A\n1\n", "A", "111100000"},
        {PAIR "*ELSET,ELSET=A\n1\n*ELSET,ELSET=B\n2\n*ELSET,ELSET=a\n2", "A", "111110000"},
        {PAIR "*ELSET,ELSET=A\n1\n*ELSET,ELSET=B\n2\n*ELSET,ELSET=C\n2,A", "B", "011110000"},
        {PAIR "*ELSET,ELSET=A\n1\n*ELSET,ELSET=B\n2\n*ELSET,ELSET=C\n2,A", "C", "111110000"},
        {PAIR "*ELSET,ELSET=A,GENERATE\n2,2000000000\n", "A", "011110000"},
        {PAIR "*ELSET,ELSET=A,GENERATE\n1,2,1\n", "A", "111110000"},
        {PAIR "*ELSET,ELSET=A,GENERATE\n1,9,3\n", "A", "111100000"},
        {PAIR "*ELSET,ELSET=A\n1.0, 77\n", "A", "111100000"},
        {PAIR "*NSET,NSET=2E0\n9\n*NSET,NSET=A\n2e0\n", "A", "000000001"}, /* a name */
        {PAIR "*NSET,NSET=N\n1,9\n*NSET,NSET=M\n2\n*NSET,NSET=O\nN,M,3", "N", "100000001"},
        {PAIR "*NSET,NSET=N\n1,9\n*NSET,NSET=M\n2\n*NSET,NSET=O\nN,M,3", "M", "010000000"},
        {PAIR "*NSET,NSET=N\n1,9\n*NSET,NSET=M\n2\n*NSET,NSET=O\nN,M,3", "O", "111000001"},
        {PAIR "*ELSET,ELSET=A\n2\n*NSET,NSET=N,ELSET=A\n", "N", "011110000"},
        {PAIR "*ELEMENT,TYPE=S4,ELSET=Q\n3,6,7,8,9\n", "Q", "000001111"},
        {AGAIN, "A", "11110"}, /* a node that is given again stands in several places */
        {AGAIN, "B", "10001"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        reading_text_holds(format, cases[i].text, cases[i].tag, READING_REGIONS, cases[i].held);
    reading_text_holds(format, solid, "both", 0, "11111");
    reading_text_holds(format, solid, "Some Nodes", 0, "11100");
    reading_text_holds(format, solid, "Top", 0, "11110");
    reading_text_holds(format, solid, "ofrib", 0, "11100");
    reading_text_holds(format, solid, "Outer", 0, "11111");
    reading_text_holds(format, solid, "Odd", 0, "11111");
}

static void nodes_are_held(void **state) {
    (void)state;
    static const struct {
        const char *text, *held;
    } cases[] = {
        {PAIR "*ELEMENT,TYPE=S3R\n3,6,7,8\n", "000001110"},
        {PAIR "*ELEMENT,TYPE=SFM3D3\n3,6,7,8\n", "000001110"},
        {PAIR "*ELEMENT,TYPE=STRI3\n3,6,7,8\n", "000001110"},
        {PAIR "*ELEMENT,TYPE=CPS4R\n3,6,7,8,9\n", "000001111"},
        {PAIR "*ELEMENT,TYPE=C3D8R\n3,1,2,3,4,5,\n6,7,8\n4,9,9,9,9,9,9,9,9\n", "000000000"},
        {PAIR "*ELEMENT,TYPE=C3D6\n3,1,2,3\n6,7,8\n", "000000000"}, /* no comma: six there are */
        {PAIR "*ELEMENT,TYPE=T3D2\n3,6,7\n", "000001100"},
        {PAIR "*ELEMENT,TYPE=B31\n3,6,7,8\n", "000001100"}, /* 8 tells a direction */
        {PAIR "*ELEMENT,TYPE=B32\n3,6,7,8\n", "000001110"},
        {PAIR "*ELEMENT,TYPE=MASS\n3,9\n", "000000001"},
        {PAIR "*ELEMENT,TYPE=U1\n3,6,\n7\n4,9", "000001101"},
        {PAIR "*ELEMENT,TYPE=U1\n3,-9223372036854775808,9223372036854775807,6\n", "000001000"},
        {PAIR "*EQUATION\n2\n6,1,1.,7,1,-1.\n3\n8,1,1.,9,2,1.\n1,3,5.\n", "100001111"},
        {PAIR "*NSET,NSET=N\n6,8\n*EQUATION\n2\nN,1,1.,7,1,-1.\n", "000001110"},
        {PAIR "*MPC\nTIE,6,7\nBEAM,9,8\n", "000001111"},
        {PAIR "*BOUNDARY\n6,1,3\n*CLOAD\n7,1,2.\n", "000000000"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        reading_text_holds(format, cases[i].text, NULL, READING_REGIONS, cases[i].held);
}

static void regions_are_blocks_and_sections(void **state) {
    (void)state;
    static const char two[] = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
                              "*ELEMENT,TYPE=C3D4,ELSET=A\n1,1,2,3,4\n"
                              "*ELEMENT,TYPE=C3D4,ELSET=B\n2,2,3,4,5\n";
    reading_text_holds(format, two, NULL, READING_REGIONS, "01110");
    reading_text_holds(format, two, NULL, 0, "00000");
    static const char commented[] =
        "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
        "*ELEMENT,TYPE=C3D4,\n** a comment, and more\n\nELSET=A\n1,1,2,3,4\n"
        "*ELEMENT,\n**\n TYPE=C3D4,\n** ELSET=A,\n** one more\nELSET=B\n2,2,3,4,5\n";
    reading_text_holds(format, commented, NULL, READING_REGIONS, "01110");
    reading_text_holds(format, PAIR "*ELSET,ELSET=A\n1\n*ELSET,ELSET=B\n2\n", NULL, READING_REGIONS,
                       "000000000");
    reading_text_holds(format, PAIR "*ELSET,ELSET=A\n1\n*SOLID SECTION,ELSET=A\n1.\n", NULL,
                       READING_REGIONS, "011100000");
    reading_text_holds(format,
                       PAIR "*ELSET,ELSET=A\n1,2\n*ELSET,ELSET=B\n2\n*Solid Section,elset=a\n1.\n",
                       NULL, READING_REGIONS, "000000000");
}

/* Quotes keep commas, blanks and the case of letters. */
#define QUOTED(a, b, more)                                                                         \
    "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"                                         \
    "*ELEMENT,TYPE=\"C3D4\",ELSET=" a "\n1,1,2,3,4\n"                                              \
    "*ELEMENT,TYPE=C3D4, ELSET = " b "\n2,2,3,4,5\n" more

static void names_may_be_quoted(void **state) {
    (void)state;
    static const struct {
        const char *text, *tag, *held;
    } cases[] = {
        {QUOTED("\"st, 1\"", "\"st, 2\"", ""), NULL, "01110"},
        {QUOTED("\"st, 1\"", "\"st, 2\"", ""), "st, 2", "01111"},
        {QUOTED("\"st, 1\"", "\"ST, 1\"", ""), NULL, "01110"},
        {QUOTED("\"st, 1\"", "\"st, 1\"", ""), NULL, "00000"},
        {QUOTED("st", "ST", ""), NULL, "00000"},
        {QUOTED("\"ST\"", "st", ""), NULL, "00000"},
        {QUOTED("\"st\"", "st", ""), NULL, "01110"},
        {QUOTED("\"st", "\"st", ""), NULL, "00000"},
        {QUOTED("\"a\"\"b\"", "\"a\"\"c\"", ""), NULL, "01110"},
        {QUOTED("\"a, 1\"", "B", "*ELSET,ELSET=C\n\"a, 1\",\n"), "C", "11110"},
        {QUOTED("\"a\"", "\"A\"", "*ELSET,ELSET=C\nA\n"), "C", "01111"},
        {QUOTED("\"a\"", "B", "*ELSET,ELSET=C\nA\n"), "C", "11110"}, /* there is no other */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        reading_text_holds(format, cases[i].text, cases[i].tag, READING_REGIONS, cases[i].held);
}

/** Sets that the file comes back to name a member once. */
static void members_are_counted_once(void **state) {
    (void)state;
    planish_file *file =
        reading_text(format, PAIR "*ELSET,ELSET=A\n1,1\n*ELSET,ELSET=B\n1\n*ELSET,ELSET=A\n1\n");
    const io_entity *entity = &file->model.entity[file->model.tetrahedron.entity[0]];
    assert_int_equal(entity->n_physical, 2);
    assert_int_equal(file->model.entity[file->model.tetrahedron.entity[1]].n_physical, 0);
    planish_file_close(file);
}

static void types_are_known(void **state) {
    (void)state;
    static const char *const tetrahedra[] = {"C3D4", "c3d4h", "DC3D4", "AC3D4", "C3D4T",
                                             "Q3D4", "F3D4",  "C3D4E", "FC3D4", "EMC3D4"};
    static const char *const triangles[] = {
        "CPS3", "CPE3",  "S3",  "S3R", "STRI3", "M3D3",   "CAX3",    "DC2D3",  "R3D3",  "CPE3H",
        "DS3",  "CPEG3", "US3", "us3", "F3D3",  "STRI35", "WARP2D3", "CGAX3H", "AC2D3", "SFM3D3"};
    char text[512];
    for (size_t i = 0; i < sizeof tetrahedra / sizeof *tetrahedra; i++) {
        snprintf(text, sizeof text,
                 "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=%s\n1,1,2,3,4\n",
                 tetrahedra[i]);
        planish_file *file = reading_text(format, text);
        assert_int_equal(planish_file_mesh(file).dim, 3);
        planish_file_close(file);
    }
    for (size_t i = 0; i < sizeof triangles / sizeof *triangles; i++) {
        snprintf(text, sizeof text, "*NODE\n1,0,0\n2,1,0\n3,0,1\n*ELEMENT,TYPE=%s\n1,1,2,3\n",
                 triangles[i]);
        planish_file *file = reading_text(format, text);
        assert_int_equal(planish_file_mesh(file).dim, 2);
        assert_int_equal(planish_file_mesh(file).n_elements, 1);
        planish_file_close(file);
    }
}

/** Nodes of other elements must be there, and be numbers. */
static void nodes_of_other_elements_are_checked(void **state) {
    (void)state;
    reading_fails(format, PAIR "*ELEMENT,TYPE=C3D8\n3,1,2,3,4,6,7,8,99\n",
                  "element 3: there is no node 99");
    reading_fails(format, PAIR "*ELEMENT,TYPE=C3D8\n3,1,2,3,4,6,7,8,\n", "expected");
    reading_fails(format, PAIR "*ELEMENT,TYPE=C3D6\n3,1,2,3,4,6,7,8,9\n",
                  "element 3 has more than the 6 nodes of its type");
    reading_fails(format, PAIR "*ELEMENT,TYPE=C3D8\n3,1,2,x,4,6,7,8,9\n", "'x' where the number");
    reading_fails(format, PAIR "*ELEMENT,TYPE=C3D8\nx,1,2,3,4,6,7,8,9\n", "'x' where the number");
}

/* CalculiX' fluid: a prism of six nodes is no triangle of second order. */
static void fluid_is_of_first_order(void **state) {
    (void)state;
    reading_text_holds(format, PAIR "*ELEMENT,TYPE=F3D6\n3,1,3,4,6,7,8\n", NULL, READING_REGIONS,
                       "000000000");
    reading_text_holds(format, PAIR "*ELEMENT,TYPE=F3D8\n3,1,2,3,4,6,7,8,\n9\n", NULL,
                       READING_REGIONS, "000000000");
    planish_file *file = reading_text(format, PAIR "*ELEMENT,TYPE=F3D4\n3,2,3,4,6\n");
    assert_int_equal(planish_file_mesh(file).n_elements, 3);
    planish_file_close(file);
    /* Abaqus' quadrilaterals around a cavity. */
    static const char cavity[] =
        PAIR "*ELEMENT,TYPE=F3D4\n3,2,3,4,6\n*Fluid Property, TYPE=HYDRAULIC\n";
    reading_text_holds(format, cavity, NULL, READING_REGIONS, "011101000");
    file = reading_text(format, cavity);
    assert_int_equal(planish_file_mesh(file).n_elements, 2);
    planish_file_close(file);
    reading_every_beginning(format, cavity, (int64_t)sizeof cavity - 1);
}

/** What can be given instead of a name that the file has not: names, and each of them once. */
static void names_are_listed(void **state) {
    (void)state;
    static const struct {
        const char *text, *end;
    } cases[] = {
        {PAIR "*ELSET,ELSET=A\n1\n*NSET,NSET=\"b c\"\n2\n", "the file has: A, b c"},
        {PAIR "*ELSET,ELSET=A\n1\n*NSET,NSET=A\n2\n*SOLID SECTION,ELSET=A\n", "the file has: A"},
        {PAIR, "the file has: none"},
    };
    static const char *const wrong[] = {"wrong", "0:1", "1"}; /* sets have no numbers */
    for (size_t i = 0; i < 3 * sizeof cases / sizeof *cases; i++) {
        planish_file *file = reading_text(format, cases[i / 3].text);
        const char *const tag = wrong[i % 3];
        const planish_hold hold = {.tags = &tag, .n_tags = 1};
        uint8_t constraint[9];
        planish_error error = {.text = ""};
        assert_int_equal(planish_file_constraints(file, &hold, constraint, &error),
                         PLANISH_ERROR_ARGUMENT);
        const size_t length = strlen(error.text), end = strlen(cases[i / 3].end);
        assert_true(length > end);
        assert_string_equal(error.text + length - end, cases[i / 3].end);
        planish_file_close(file);
    }
}

/* As Abaqus/CAE writes it: a part, an instance, sets and a reference point of the assembly. */
static const char parts[] =
    "*Heading\n*Part, name=P\n*Node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
    "*Element, type=C3D4\n1,1,2,3,4\n2,2,3,4,5\n*Nset, nset=S\n1,\n*End Part\n"
    "*Part, name=Empty\n*End Part\n"
    "*Assembly, name=A\n*Instance, name=P-1, part=P\n 1., 2., 3.\n*End Instance\n"
    "*Node\n1, 9., 9., 9.\n*Nset, nset=Ref\n1,\n*Nset, nset=T, instance=P-1\n 4,\n"
    "*Nset, nset=Dotted\nP-1.5, P-1.S\n*Elset, elset=E, instance=P-1\n 2,\n"
    "*Element, type=CONN3D2\n1, P-1.2, 1\n"
    "*End Assembly\n*Material, name=M\n";

static void parts_are_understood(void **state) {
    (void)state;
    reading_text_holds(format, parts, NULL, READING_REGIONS, "01000");
    reading_text_holds(format, parts, "S", READING_REGIONS, "11000");
    reading_text_holds(format, parts, "Ref", READING_REGIONS, "01000");
    reading_text_holds(format, parts, "T", READING_REGIONS, "01010");
    reading_text_holds(format, parts, "Dotted", READING_REGIONS, "11001");
    reading_text_holds(format, parts, "E", READING_REGIONS, "01111");
    static const struct {
        const char *lines, *held;
    } cases[] = {
        {"*NSET,NSET=X,INSTANCE=P-1\n2.0, 4.\n", "010100000"},
        {"*NSET,NSET=X\nP-1.2.0, 4., P-1.5\n", "010010000"},
        {"*NSET,NSET=X,GENERATE,INSTANCE=P-1\n2.0, 4.0\n", "011100000"},
        {"*NSET,NSET=\"a 2.5\",INSTANCE=P-1\n2\n*NSET,NSET=X\n\"a 2.5\"\n", "010000000"},
        {"*NSET,NSET=\"5\",INSTANCE=P-1\n2\n*NSET,NSET=X\nP-1.\"5\"\n", "010000000"},
        {"*NSET,NSET=X\n*MPC\nTIE,P-1.2.,P-1.5\n", "010010000"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text,
                 "*PART,NAME=P\n" PAIR "*END PART\n*ASSEMBLY,NAME=A\n%s*END ASSEMBLY\n",
                 cases[i].lines);
        reading_text_holds(format, text, "X", READING_REGIONS, cases[i].held);
    }
    reading_fails(format,
                  "*PART,NAME=A\n*NODE\n1,0,0\n*END PART\n*PART,NAME=B\n*NODE\n1,0,0\n*END PART\n",
                  "test:6: several parts or instances have nodes");
}

/* The mesh of an independent instance of Abaqus/CAE is the instance's own. */
static const char instance[] =
    "*Heading\n*Part, name=P\n*End Part\n*Assembly, name=A\n*Instance, name=P-1, part=P\n"
    "*Node\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n5,1,1,1\n"
    "*Element, type=C3D4\n1,1,2,3,4\n2,2,3,4,5\n*Nset, nset=S\n1,\n*End Instance\n"
    "*Instance, name=Q-1, part=P\n*End Instance\n"
    "*Node\n1, 9., 9., 9.\n*Nset, nset=Ref\n1,\n*Nset, nset=T, instance=P-1\n 4,\n"
    "*Nset, nset=Dotted\nP-1.5, P-1.S\n*Elset, elset=E, instance=P-1\n 2,\n"
    "*Element, type=CONN3D2\n1, P-1.2, 1\n"
    "*End Assembly\n*Material, name=M\n";

static void meshes_of_instances_are_understood(void **state) {
    (void)state;
    reading_text_holds(format, instance, NULL, READING_REGIONS, "01000");
    reading_text_holds(format, instance, "S", READING_REGIONS, "11000");
    reading_text_holds(format, instance, "Ref", READING_REGIONS, "01000");
    reading_text_holds(format, instance, "T", READING_REGIONS, "01010");
    reading_text_holds(format, instance, "Dotted", READING_REGIONS, "11001");
    reading_text_holds(format, instance, "E", READING_REGIONS, "01111");
    reading_fails(format,
                  "*PART,NAME=A\n*NODE\n1,0,0\n*END PART\n*ASSEMBLY,NAME=B\n*INSTANCE,NAME=C\n"
                  "*NODE\n1,0,0\n*END INSTANCE\n*END ASSEMBLY\n",
                  "test:7: several parts or instances have nodes");
}

/* Sets of the part, sections of these, and sets of the assembly that have the same names. */
#define NAMES(more)                                                                                \
    "*PART,NAME=P\n" PAIR "*ELSET,ELSET=A\n1\n*ELSET,ELSET=B\n2\n*NSET,NSET=N\n1\n"                \
    "*SOLID SECTION,ELSET=A\n*SOLID SECTION,ELSET=B\n*END PART\n"                                  \
    "*PART,NAME=Q\n*ELSET,ELSET=A\n*SOLID SECTION,ELSET=A\n*END PART\n"                            \
    "*ASSEMBLY,NAME=X\n*INSTANCE,NAME=P-1,PART=P\n*END INSTANCE\n" more "*END ASSEMBLY\n"

static void names_are_of_part_or_assembly(void **state) {
    (void)state;
    static const struct {
        const char *text, *tag, *held;
    } cases[] = {
        {NAMES("*ELSET,ELSET=B,INSTANCE=P-1,GENERATE\n1,2\n"), NULL, "011100000"},
        {NAMES("*ELSET,ELSET=A,INSTANCE=P-1\n2\n"), "A", "111110000"},
        {NAMES("*ELSET,ELSET=B,INSTANCE=P-1\n1\n*ELSET,ELSET=C\nB\n"), "C", "111100000"},
        {NAMES("*ELSET,ELSET=B,INSTANCE=P-1\n1\n*ELSET,ELSET=C\nP-1.B\n"), "C", "011110000"},
        {NAMES("*ELSET,ELSET=B,INSTANCE=P-1\n1\n*ELSET,ELSET=C,INSTANCE=P-1\nB\n"), "C",
         "011110000"},
        {NAMES("*NSET,NSET=N,INSTANCE=P-1\n9\n*EQUATION\n1\nN,1,1.\n"), NULL, "011100001"},
        {NAMES("*NSET,NSET=N,INSTANCE=P-1\n9\n*MPC\nTIE,P-1.N\n"), NULL, "111100000"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        reading_text_holds(format, cases[i].text, cases[i].tag, READING_REGIONS, cases[i].held);
}

static void wrong_files_are_refused(void **state) {
    (void)state;
    static const reading_refusal cases[] = {
        {"", "no *NODE"},
        {"*NODE\n*ELEMENT,TYPE=C3D4\n", "no *NODE"},
        {"*NODE\n1,0,0,0\n", "nothing to smooth"},
        {PAIR "*NODE\n3,1,1,1\n", "node number 3 occurs twice"},
        {PAIR "*ELEMENT,TYPE=C3D4\n1,1,2,3,5\n*ELSET,ELSET=A\n1\n",
         "element number 1 occurs twice"},
        {PAIR "*ELEMENT,TYPE=C3D4\n3,1,2,3,10\n", "test:15: element 3: there is no node 10"},
        {PAIR "*ELEMENT,TYPE=C3D4\n3,1,2,3\n", "number of a node"},
        {PAIR "*ELEMENT,TYPE=C3D4\n3,1,2,3,4,5\n", "more than the 4 nodes"},
        {PAIR "*ELEMENT,TYPE=C3D4\n3,1,2,x,4\n", "'x'"},
        {PAIR "*ELEMENT,TYPE=C3D4\nx,1,2,3,4\n", "'x'"},
        {PAIR "*ELEMENT\n", "without TYPE"},
        {"*NODE\n1,0,x,0\n", "test:2: node 1: 'x' is no"},
        {"*NODE\n1,0,nan,0\n", "finite"},
        {"*NODE\n1,0,1e999,0\n", "finite"},
        {"*NODE\n-1,0,0,0\n", "'-1'"},
        {"*NODE\n99999999999,0,0,0\n", "'99999999999'"},
        {PAIR "*ELSET,ELSET=A\nB\n", "defined before"},
        {PAIR "*ELSET\n1\n", "without a name"},
        {PAIR "*ELSET,ELSET=A,GENERATE\n1,x\n", "GENERATE"},
        {"*NODE,SYSTEM=C\n1,0,0,0\n", "cylindrical"},
        {"*SYSTEM\n1,2,3\n", "*SYSTEM"},
        {"*NODE,INPUT=nodes.txt\n", "INPUT="},
        {PAIR "*ELEMENT,TYPE=C3D4,INPUT=e.txt\n", "e.txt: "},
        {PAIR "*INCLUDE,INPUT=more.inp\n", "more.inp: "},
        {PAIR "*NGEN\n1,9,1\n", "*NGEN"},
        {PAIR "*n fill\n1,9,1\n", "*NFILL"},
        {PAIR "*ELGEN\n1,9,1\n", "*ELGEN"},
        {PAIR "*NCOPY,OLD SET=A\n", "*NCOPY"},
    };
    reading_refuses(format, cases, sizeof cases / sizeof *cases);
    reading_gives_surface(
        format, "*NODE\n1,0,0,0\n2,1\n3,0,1,1\n4,1,1\n*ELEMENT,TYPE=S3\n1,1,2,3\n2,2,4,3\n");
}

/** The file of n nodes in the set N and n elements in the set A, and n times what repeated says
 *  (a format for a number). */
static char *repeating(int n, const char *more, const char *repeated) {
    file_builder builder = {.data = NULL};
    builder_text(&builder, "*NODE,NSET=N\n1,0,0\n2,1,0\n3,0,1\n");
    for (int i = 3; i < n; i++)
        builder_text(&builder, "%d,0,0\n", i + 1);
    builder_text(&builder, "*ELEMENT,TYPE=CPS3,ELSET=A\n");
    for (int i = 0; i < n; i++)
        builder_text(&builder, "%d,1,2,3\n", i + 1);
    builder_text(&builder, "%s", more);
    for (int i = 0; i < n; i++)
        builder_text(&builder, repeated, i);
    builder_text(&builder, "\n%c", '\0');
    return builder.data;
}

/** Sets that a small file makes large again and again. */
static void sets_have_a_limit(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"", "*ELSET,ELSET=X%d\nA\n"},
        {"", "*NSET,NSET=X%d,ELSET=A\n"},
        {"", "*ELSET,ELSET=X\nA\n*ELSET,ELSET=Y\nA\n** %d\n"},
        {"*ELSET,ELSET=X,GENERATE\n", "1,2000,1\n** %d\n"},
        {"*NSET,NSET=X,GENERATE\n", "1,999999,1\n** %d\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *text = repeating(2000, cases[i][0], cases[i][1]);
        reading_fails(format, text, "too many for a file of this size");
        free(text);
        text = repeating(200, cases[i][0], cases[i][1]);
        planish_file_close(reading_text(format, text));
        free(text);
    }
}

/** Sets that a file names very often, as constraints and sections do: none of these is walked more
 *  than once (that would take minutes). */
static void sets_may_be_named_often(void **state) {
    (void)state;
    static const char *const cases[][2] = {
        {"*MPC\n", "BEAM,N,N,N,N,N,N,N,N\n** %d\n"},
        {"*EQUATION\n", "4\nN,1,1.,N,2,1.,N,3,1.,N,1,1.\n** %d\n"},
        {"", "*SOLID SECTION,ELSET=A\n** %d\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *text = repeating(300000, cases[i][0], cases[i][1]);
        planish_file *file = reading_text(format, text);
        assert_int_equal(file->model.hold[299999], i < 2 ? IO_HELD_REQUIRED : 0);
        planish_file_close(file);
        free(text);
    }
}

/** Of sections that have the same element the last tells. */
static void sections_may_overlap(void **state) {
    (void)state;
    static const char sets[] = PAIR "*ELSET,ELSET=A\n1\n*ELSET,ELSET=B\n1,2\n";
    static const struct {
        const char *sections, *held;
    } cases[] = {
        {"*SOLID SECTION,ELSET=A\n*SOLID SECTION,ELSET=B\n", "000000000"},
        {"*SOLID SECTION,ELSET=B\n*SOLID SECTION,ELSET=A\n", "011100000"},
        {"*SOLID SECTION,ELSET=B\n*Surface Section,ELSET=A\n", "011100000"},
        {"*SOLID SECTION,ELSET=B\n*SHELL SECTION,ELSET=A\n", "011100000"},
        {"*SOLID SECTION,ELSET=B\n*SHELL GENERAL SECTION,ELSET=A\n", "011100000"},
        {"*SOLID SECTION,ELSET=B\n*MEMBRANE SECTION,ELSET=A\n", "011100000"},
        {"*SOLID SECTION,ELSET=B\n*EULERIAN SECTION,ELSET=A\n", "011100000"},
        {"*SOLID SECTION,ELSET=B\n*SURFACE,ELSET=A\n", "000000000"},
        {"*SOLID SECTION,ELSET=B\n*SOLID SECTION,ELSET=A\n*SOLID SECTION,ELSET=B\n", "000000000"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char text[512];
        snprintf(text, sizeof text, "%s%s", sets, cases[i].sections);
        reading_text_holds(format, text, NULL, READING_REGIONS, cases[i].held);
    }
}

static void contents_are_recognised(void **state) {
    (void)state;
    static const char *const yes[] = {solid, PAIR, "** c\n\n*heading", " *Part, name=x\n",
                                      "\xEF\xBB\xBF*Node\n"};
    static const char *const no[] = {"", "**\n", "*KEYWORD\n*NODE\n", "1 2 3\n", "*nodes\n", "*\n"};
    reading_tells(format, yes, sizeof yes / sizeof *yes, 1);
    reading_tells(format, no, sizeof no / sizeof *no, 0);
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
        text[n - (kind == 1 ? 2 : 1)] = '\0';
        planish_file *file = reading_text(format, text);
        assert_int_equal(planish_file_mesh(file).n_elements, 4);
        assert_true(planish_file_mesh(file).coordinates[14] == .25);
        assert_int_equal(file->model.n_groups, 13);
        planish_file_close(file);
    }
    free(text);
}

/** A byte order mark before the first keyword. */
static void text_may_begin_with_a_mark(void **state) {
    (void)state;
    reading_text_holds(format, "\xEF\xBB\xBF" PAIR "*ELSET,ELSET=A\n1\n", "A", READING_REGIONS,
                       "111100000");
    reading_text_holds(format, "\xEF\xBB\xBF** a comment\n" PAIR, NULL, READING_REGIONS,
                       "000000000");
    reading_fails(format, "\xEF\xBB\xBF", "no *NODE");
    reading_fails(format, "\xEF\xBB", "no *NODE");
}

static void build(file_builder *builder, const char *text) {
    for (const char *line = text, *end; *line; line = end + 1) {
        end = strchr(line, '\n');
        builder_text(builder, "%.*s\n", (int)(end - line), line);
    }
}

static void bad_files_do_no_harm(void **state) {
    (void)state;
    file_builder builder = {.data = NULL};
    build(&builder, solid);
    builder_try_to_break(&builder, format);
    builder_release(&builder);
    build(&builder, parts);
    builder_try_to_break(&builder, format);
    builder_release(&builder);
}

/** The file whose *NODE has this line for node 9, its first: rewriting_gives. */
static void check_writing(void **state, const char *before, const char *move, const char *after) {
    static const char tail[] = "1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1.0\n*ELEMENT,TYPE=C3D4\n"
                               "1,1,2,3,4\n*NODE\n77,1e0\n";
    char text[512], expected[512];
    snprintf(text, sizeof text, "*NODE\n%s%s", before, tail);
    snprintf(expected, sizeof expected, "*NODE\n%s%s", after, tail);
    rewriting_gives(format, text, move, expected, *state);
}

static void only_what_changed_is_written(void **state) {
    static const char *const cases[][3] = {
        {"9, 1., 2., 3.\n", "xyz", "9, .125, -.3333333333333333, 123456.789\n"},
        {" 9 , 1.\t, 2. , 3. \n", "y", " 9 , 1.\t, -.3333333333333333 , 3. \n"},
        {"9,1.,2.,3.,0.,0.,1.\n", "z", "9,1.,2.,123456.789,0.,0.,1.\n"},
        {"9, , 2.,\r\n", "xz", "9, .125, 2.,123456.789\r\n"},
        {"9,1.,2.,\n", "", "9,1.,2.,\n"},
        {"9,1.,2.\n", "z", "9,1.,2., 123456.789\n"},
        {"9\n", "z", "9, , , 123456.789\n"},
        {"9,\n", "y", "9,, -.3333333333333333\n"},
        {"9,\n", "xyz", "9,.125, -.3333333333333333, 123456.789\n"},
        {"9,1. \n", "yz", "9,1. , -.3333333333333333, 123456.789\n"},
        {"9,0.12345678901234567890123,0,0\n", "z", "9,0.12345678901234567890123,0,123456.789\n"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_writing(state, cases[i][0], cases[i][1], cases[i][2]);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_read),
        cmocka_unit_test(sets_are_groups),
        cmocka_unit_test(nodes_are_held),
        cmocka_unit_test(regions_are_blocks_and_sections),
        cmocka_unit_test(names_may_be_quoted),
        cmocka_unit_test(members_are_counted_once),
        cmocka_unit_test(names_are_listed),
        cmocka_unit_test(types_are_known),
        cmocka_unit_test(nodes_of_other_elements_are_checked),
        cmocka_unit_test(fluid_is_of_first_order),
        cmocka_unit_test(parts_are_understood),
        cmocka_unit_test(meshes_of_instances_are_understood),
        cmocka_unit_test(names_are_of_part_or_assembly),
        cmocka_unit_test(wrong_files_are_refused),
        cmocka_unit_test(sets_have_a_limit),
        cmocka_unit_test(sets_may_be_named_often),
        cmocka_unit_test(sections_may_overlap),
        cmocka_unit_test(contents_are_recognised),
        cmocka_unit_test(line_ends_may_be_any),
        cmocka_unit_test(text_may_begin_with_a_mark),
        cmocka_unit_test(bad_files_do_no_harm),
        cmocka_unit_test_setup_teardown(only_what_changed_is_written, test_folder_create,
                                        test_folder_remove),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
