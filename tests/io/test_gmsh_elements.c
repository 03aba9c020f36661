/* Tests of the elements of MSH files that are measured only: every type in every encoding, on any
 * number of threads. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/file_builder.h"
#include "support/gmsh_builder.h"
#include "support/reading.h"
#include "support/unit_elements.h"

/* Types and the order of nodes as the figures of Gmsh's manual have them ("Node ordering"). */
#define HEXAHEDRON   "0 1 2 3 4 5 6 7"
#define HEXAHEDRON20 HEXAHEDRON " 01 03 04 12 15 23 26 37 45 47 56 67"
#define WEDGE15      "0 1 2 3 4 5 01 02 03 12 14 25 34 35 45"
#define PYRAMID13    "0 1 2 3 4 01 03 04 12 14 23 24 34"
static const unit_element elements[] = {
    {PLANISH_CELL_TRIANGLE, 2, "0 1 2"},
    {PLANISH_CELL_QUADRILATERAL, 3, "0 1 2 3"},
    {PLANISH_CELL_TRIANGLE6, 9, "0 1 2 01 12 20"},
    {PLANISH_CELL_QUADRILATERAL9, 10, "0 1 2 3 01 12 23 30 0123"},
    {PLANISH_CELL_QUADRILATERAL8, 16, "0 1 2 3 01 12 23 30"},
    {PLANISH_CELL_TETRAHEDRON, 4, "0 1 2 3"},
    {PLANISH_CELL_HEXAHEDRON, 5, HEXAHEDRON},
    {PLANISH_CELL_WEDGE, 6, "0 1 2 3 4 5"},
    {PLANISH_CELL_PYRAMID, 7, "0 1 2 3 4"},
    {PLANISH_CELL_TETRAHEDRON10, 11, "0 1 2 3 01 12 02 03 23 13"},
    {PLANISH_CELL_HEXAHEDRON27, 12, HEXAHEDRON20 " 0321 0154 0473 1265 2376 4567 01234567"},
    {PLANISH_CELL_WEDGE18, 13, WEDGE15 " 0143 0352 1254"},
    {PLANISH_CELL_PYRAMID14, 14, PYRAMID13 " 0123"},
    {PLANISH_CELL_HEXAHEDRON20, 17, HEXAHEDRON20},
    {PLANISH_CELL_WEDGE15, 18, WEDGE15},
    {PLANISH_CELL_PYRAMID13, 19, PYRAMID13},
};
enum { N_ELEMENTS = sizeof elements / sizeof *elements };

enum { MSH1 = 10, MSH2 = 22, MSH40 = 40, MSH41 = 41 };

/** How a file is written; what is in it: times elements of each type of a dimension. */
typedef struct encoding {
    int version, binary, swapped;
    int dim, times;
} encoding;

/** Put the nodes of an element, numbered from first on. Returns their number. */
static int put_nodes(file_builder *file, const encoding *e, const unit_element *element,
                     int first) {
    double x[UNIT_NODES][3];
    const int n = unit_places(element->type, element->nodes, x);
    for (int i = 0; i < n && e->version == MSH41; i++) {
        builder_integer(file, first + i, 8);
        builder_line(file);
    }
    for (int i = 0; i < n; i++) {
        if (e->version != MSH41)
            builder_integer(file, first + i, 4);
        for (int d = 0; d < 3; d++)
            builder_real(file, x[i][d], 8);
        builder_line(file);
    }
    return n;
}

static int put_element(file_builder *file, const encoding *e, const unit_element *element,
                       int number, int first) {
    double x[UNIT_NODES][3];
    const int n = unit_places(element->type, element->nodes, x);
    const int old[] = {number, element->code, 1, 1, n};
    const int text[] = {number, element->code, 2, 1, 1};
    const int binary[] = {element->code, 1, 2, number, 1, 1};
    const int bytes = e->version == MSH41 ? 8 : 4;
    if (e->version >= MSH40)
        builder_integer(file, number, bytes);
    for (int i = 0; i < (e->version >= MSH40 ? 0 : e->binary ? 6 : 5); i++)
        builder_integer(file, e->version == MSH1 ? old[i] : e->binary ? binary[i] : text[i], 4);
    for (int i = 0; i < n; i++)
        builder_integer(file, first + i, bytes);
    builder_line(file);
    return n;
}

/** Write the section of nodes, or that of elements, which are numbered from 100 on. */
static void put_section(file_builder *file, const encoding *e, int of_elements) {
    const struct variant variant = {.is_40 = e->version == MSH40};
    const char *const names[2][2] = {{"Nodes", "Elements"}, {"NOD", "ELM"}};
    const char *name = names[e->version == MSH1][of_elements];
    int total = 0, blocks = 0, at = 1, number = 100;
    for (int i = 0; i < N_ELEMENTS; i++) {
        double x[UNIT_NODES][3];
        if (unit_dim(elements[i].type) != e->dim)
            continue;
        total +=
            of_elements ? e->times : e->times * unit_places(elements[i].type, elements[i].nodes, x);
        blocks += e->times;
    }
    builder_text(file, "\n$%s\n", name);
    if (e->version >= MSH40)
        gmsh_put_section(file, &variant, blocks, total);
    else
        builder_text(file, "%d\n", total);
    for (int time = 0; time < e->times; time++) {
        for (int i = 0; i < N_ELEMENTS; i++) {
            const unit_element *element = &elements[i];
            double x[UNIT_NODES][3];
            const int n = unit_places(element->type, element->nodes, x);
            if (unit_dim(element->type) != e->dim)
                continue;
            if (e->version >= MSH40)
                gmsh_put_head(file, &variant, e->dim, 1, of_elements ? element->code : 0,
                              of_elements ? 1 : n);
            at += of_elements ? put_element(file, e, element, number++, at)
                              : put_nodes(file, e, element, at);
        }
    }
    builder_text(file, "\n$%s%s\n", e->version == MSH1 ? "END" : "End", name);
}

static file_builder make_file(const encoding *e) {
    file_builder file = {.binary = e->binary, .swapped = e->swapped};
    if (e->version != MSH1)
        builder_text(&file, "$MeshFormat\n%d.%d %d 8\n", e->version / 10, e->version % 10,
                     e->binary);
    if (e->binary) {
        builder_integer(&file, 1, 4);
        builder_text(&file, "\n");
    }
    if (e->version != MSH1)
        builder_text(&file, "$EndMeshFormat\n");
    put_section(&file, e, 0);
    put_section(&file, e, 1);
    return file;
}

/** Check what was read: straight triangles or tetrahedra first, then the others in the file's
 *  order, each with its number. */
static void expect_elements(planish_file *file, const encoding *e) {
    const int straight = e->dim == 3 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE;
    int64_t cell = 0;
    for (int pass = 0; pass < 2; pass++) {
        int number = 100;
        for (int i = 0; i < e->times * N_ELEMENTS; i++) {
            const int type = elements[i % N_ELEMENTS].type;
            if (unit_dim(type) != e->dim)
                continue;
            if ((type == straight) == (pass == 0)) {
                unit_expect(file, cell, type);
                assert_int_equal(planish_file_element_number(file, cell++), number);
            }
            number++;
        }
    }
    unit_expect_valid(file, cell);
    assert_int_equal(file->model.n_other, cell - e->times);
}

static const encoding encodings[] = {
    {.version = MSH1},
    {.version = MSH2},
    {.version = MSH2, .binary = 1},
    {.version = MSH2, .binary = 1, .swapped = 1},
    {.version = MSH40},
    {.version = MSH40, .binary = 1},
    {.version = MSH40, .binary = 1, .swapped = 1},
    {.version = MSH41},
    {.version = MSH41, .binary = 1},
    {.version = MSH41, .binary = 1, .swapped = 1},
};
enum { N_ENCODINGS = sizeof encodings / sizeof *encodings };

static void every_type_has_its_nodes_in_order(void **state) {
    (void)state;
    for (int i = 0; i < 2 * N_ENCODINGS; i++) {
        encoding e = encodings[i / 2];
        e.dim = 2 + i % 2;
        e.times = 2;
        planish_file *file;
        planish_error error = {0};
        file_builder builder = make_file(&e);
        if (builder_read(&builder, &io_format_gmsh, 1, &file, &error) != 0)
            fail_msg("MSH %d, binary %d: %s", e.version, e.binary, error.text);
        expect_elements(file, &e);
        planish_file_close(file);
        builder_let_allocations_fail(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

/** So many lines that threads read them. */
static void threads_read_the_same(void **state) {
    (void)state;
    for (int i = 0; i < 2; i++) {
        encoding e = encodings[i];
        e.dim = 3;
        e.times = 1500;
        file_builder builder = make_file(&e);
        builder_expect_same_on_threads(&builder, &io_format_gmsh);
        builder_release(&builder);
    }
}

/** A block of MSH 4 that is long enough for several threads. */
static void threads_read_a_block(void **state) {
    (void)state;
    enum { N = 40000 };
    const struct variant variants[] = {{.is_40 = 0}, {.binary = 1}};
    for (int k = 0; k < 2; k++) {
        file_builder file = {.binary = variants[k].binary};
        builder_text(&file, "$MeshFormat\n4.1 %d 8\n", variants[k].binary);
        if (file.binary) {
            builder_integer(&file, 1, 4);
            builder_text(&file, "\n");
        }
        builder_text(&file, "$EndMeshFormat\n$Nodes\n");
        gmsh_put_section(&file, &variants[k], 1, N + 10);
        gmsh_put_head(&file, &variants[k], 3, 1, 0, N + 10);
        for (int i = 0; i < N + 10; i++) {
            builder_integer(&file, i + 1, 8);
            builder_line(&file);
        }
        for (int i = 0; i < 3 * (N + 10); i++) {
            builder_real(&file, i % 71 + i / 3, 8);
            builder_line(&file);
        }
        builder_text(&file, "\n$EndNodes\n$Elements\n");
        gmsh_put_section(&file, &variants[k], 1, N);
        gmsh_put_head(&file, &variants[k], 3, 1, 11, N);
        for (int i = 0; i < N; i++) {
            builder_integer(&file, 3 * i + 1, 8);
            for (int j = 0; j < 10; j++)
                builder_integer(&file, i + j + 1, 8);
            builder_line(&file);
        }
        builder_text(&file, "\n$EndElements\n");
        builder_expect_same_on_threads(&file, &io_format_gmsh);
        planish_file *read;
        planish_error error;
        assert_int_equal(builder_read(&file, &io_format_gmsh, 3, &read, &error), 0);
        assert_int_equal(read->model.other.n, N);
        assert_int_equal(read->model.other.node[10 * (N - 1) + 9], N + 7); /* the last two swap */
        planish_file_close(read);
        builder_release(&file);
    }
}

/** Gmsh writes an element of several groups once for each of them: it is one element. */
static void copies_are_one_element(void **state) {
    (void)state;
    planish_file *file = reading_text(
        &io_format_gmsh,
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n9\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n"
        "5 0 0 1\n6 1 0 1\n7 1 1 1\n8 0 1 1\n9 2 2 2\n$EndNodes\n$Elements\n5\n"
        "1 5 2 7 1 1 2 3 4 5 6 7 8\n2 7 2 7 1 5 6 7 8 9\n3 5 2 8 1 1 2 3 4 5 6 7 8\n"
        "4 7 2 8 1 5 6 7 8 9\n5 7 2 8 2 5 6 7 8 1\n$EndElements\n");
    assert_int_equal(file->model.other.n, 3);
    assert_int_equal(file->model.n_other, 3);
    static const int numbers[] = {1, 2, 5};
    for (int i = 0; i < 3; i++)
        assert_int_equal(planish_file_element_number(file, i), numbers[i]);
    assert_int_equal(file->model.other.offset[2], 18);
    assert_int_equal(file->model.other.node[17], 0);
    planish_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_has_its_nodes_in_order),
        cmocka_unit_test(threads_read_the_same),
        cmocka_unit_test(threads_read_a_block),
        cmocka_unit_test(copies_are_one_element),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
