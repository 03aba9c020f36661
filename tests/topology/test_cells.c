/* Tests of src/topology/cells.c: what is refused, and of which element and node. */
#include "topology/cells.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <string.h>
#include <cmocka.h>

enum { N_NODES = 30, N_THREADS = 2 };

static planish_cells cells_of(int64_t n, const uint8_t type[], const int64_t offset[],
                              const int32_t node[]) {
    return (planish_cells){.n = n, .type = type, .offset = offset, .node = node};
}

static void every_type_is_accepted(void **state) {
    (void)state;
    static const struct {
        uint8_t type;
        int n_nodes;
    } TYPES[] = {{1, 1},   {3, 2},  {5, 3},   {9, 4},   {10, 4},  {12, 8},  {13, 6},
                 {14, 5},  {21, 3}, {22, 6},  {23, 8},  {24, 10}, {25, 20}, {26, 15},
                 {27, 13}, {28, 9}, {29, 27}, {32, 18}, {128, 14}};
    enum { N = sizeof TYPES / sizeof *TYPES };
    int32_t node[N_NODES];
    for (int i = 0; i < N_NODES; i++)
        node[i] = i;
    for (int i = 0; i < N; i++) {
        planish_error error;
        const int64_t offset[] = {0, TYPES[i].n_nodes};
        planish_cells cells = cells_of(1, &TYPES[i].type, offset, node);
        assert_int_equal(pl_check_cells(&cells, N_NODES, N_THREADS, &error), PLANISH_OK);
        for (int wrong = -1; wrong <= 1; wrong += 2) {
            const int64_t other[] = {0, TYPES[i].n_nodes + wrong};
            cells.offset = other;
            assert_int_equal(pl_check_cells(&cells, N_NODES, N_THREADS, &error),
                             PLANISH_ERROR_MESH);
            assert_int_equal(error.element, 0);
        }
    }
}

static void wrong_elements_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *name;
        uint8_t type;
        int n;
        int32_t node[10];
        int64_t wrong_node; /* -2: accepted */
    } CASES[] = {
        {"a type that is none", 2, 4, {0, 1, 2, 3}, -1},
        {"type 0", 0, 1, {0}, -1},
        {"a node too high", 9, 4, {0, 1, 2, 30}, 30},
        {"the highest node", 9, 4, {0, 1, 2, 29}, -2},
        {"a negative node", 9, 4, {0, -1, 2, 3}, -1},
        {"a very negative node", 24, 10, {0, 1, 2, 3, -2, 5, 6, 7, 8, 9}, -2147483647 - 1},
        {"a missing mid", 24, 10, {0, 1, 2, 3, -1, 5, 6, -1, 8, -1}, -2},
        {"a missing corner", 24, 10, {0, 1, 2, -1, 4, 5, 6, 7, 8, 9}, -1},
        {"a missing middle of a face", 28, 9, {0, 1, 2, 3, 4, 5, 6, 7, -1}, -1},
        {"missing mids of a quadrilateral", 28, 9, {0, 1, 2, 3, -1, -1, -1, -1, 8}, -2},
        {"a node twice in a triangle", 5, 3, {4, 7, 4}, 4},
        {"a node twice in a tetrahedron of order 2", 24, 10, {0, 1, 2, 3, 4, 5, 6, 7, 8, 4}, 4},
        {"a node twice in a quadrilateral", 9, 4, {0, 1, 2, 2}, -2},
        {"a missing node of a line", 21, 3, {0, 1, -1}, -1},
    };
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        /* The last of three, the others of which are right. */
        const uint8_t type[] = {5, 1, CASES[i].type};
        const int64_t offset[] = {0, 3, 4, 4 + CASES[i].n};
        int32_t node[14] = {0, 1, 2, 3};
        planish_error error = {.element = -5, .node = -5};
        memcpy(node + 4, CASES[i].node, (size_t)CASES[i].n * sizeof *node);
        if (CASES[i].wrong_node == -2147483647 - 1)
            node[8] = INT32_MIN;
        const planish_cells cells = cells_of(3, type, offset, node);
        const int status = pl_check_cells(&cells, N_NODES, N_THREADS, &error);
        if (CASES[i].wrong_node == -2) {
            if (status)
                fail_msg("%s: %s", CASES[i].name, error.text);
            continue;
        }
        if (status != PLANISH_ERROR_MESH || error.code != status || error.element != 2 ||
            error.node != CASES[i].wrong_node || !strstr(error.text, "element 2 "))
            fail_msg("%s: %d, element %d, node %d, %s", CASES[i].name, status, (int)error.element,
                     (int)error.node, error.text);
    }
}

static void offsets_that_do_not_ascend_are_refused(void **state) {
    (void)state;
    static const uint8_t TYPE[] = {1, 1, 1};
    static const int32_t NODE[] = {0, 1, 2};
    static const struct {
        int64_t offset[4], element;
    } CASES[] = {{{1, 2, 3, 4}, 0}, {{-1, 0, 1, 2}, 0}, {{0, 1, 0, 1}, 1}, {{0, 1, 2, -7}, 2}};
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        planish_error error;
        const planish_cells cells = cells_of(3, TYPE, CASES[i].offset, NODE);
        assert_int_equal(pl_check_cells(&cells, N_NODES, N_THREADS, &error), PLANISH_ERROR_MESH);
        assert_int_equal(error.element, CASES[i].element);
        assert_int_equal(error.node, -1);
    }
}

static void wrong_arguments_are_refused(void **state) {
    (void)state;
    static const uint8_t TYPE[] = {1};
    static const int64_t OFFSET[] = {0, 1};
    static const int32_t NODE[] = {0};
    const planish_cells wrong[] = {
        cells_of(-1, TYPE, OFFSET, NODE), cells_of((int64_t)INT32_MAX + 1, TYPE, OFFSET, NODE),
        cells_of(1, NULL, OFFSET, NODE),  cells_of(1, TYPE, NULL, NODE),
        cells_of(1, TYPE, OFFSET, NULL),
    };
    planish_error error;
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(pl_check_cells(&wrong[i], N_NODES, N_THREADS, &error),
                         PLANISH_ERROR_ARGUMENT);
    const planish_cells none = {.n = 0};
    assert_int_equal(pl_check_cells(&none, N_NODES, N_THREADS, &error), PLANISH_OK);
}

/** Of many wrong elements the first one is named, on any number of threads. */
static void the_first_wrong_element_is_named(void **state) {
    (void)state;
    enum { N = 50000, FIRST = 20011 };
    static uint8_t type[N];
    static int64_t offset[N + 1];
    static int32_t node[N];
    for (int i = 0; i < N; i++) {
        type[i] = 1;
        offset[i + 1] = i + 1;
        node[i] = i >= FIRST && i % 3 != 0 ? -1 : 0;
    }
    const planish_cells cells = cells_of(N, type, offset, node);
    for (int threads = 1; threads <= 5; threads++) {
        planish_error error;
        assert_int_equal(pl_check_cells(&cells, 1, threads, &error), PLANISH_ERROR_MESH);
        assert_int_equal(error.element, FIRST);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_type_is_accepted),
        cmocka_unit_test(wrong_elements_are_refused),
        cmocka_unit_test(offsets_that_do_not_ascend_are_refused),
        cmocka_unit_test(wrong_arguments_are_refused),
        cmocka_unit_test(the_first_wrong_element_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
