/* Elements of OpenFOAM's cells: the walk over faces finds what the search by each cell's faces finds, in meshes of all
 * shapes and in any that are damaged. */
#include "io/foam/foam_cells.h"

#include "base/memory.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { MOST = 4096, FACE_NODES = 5 };

/** Faces of a mesh, one by one. */
typedef struct faces {
    int n, n_cells;
    int size[MOST];
    int32_t node[MOST][FACE_NODES], owner[MOST], neighbour[MOST];
} faces;

static uint32_t random_state;

static int random_below(int n) {
    random_state = random_state * 1664525 + 1013904223;
    return (int)((random_state >> 8) % (uint32_t)n);
}

/** Add the faces of one more cell, whose corners are the nodes first, first + 1, ... turned: its faces and their nodes
 *  begin anywhere. */
static void add_cell(faces *f, const char *const *shape, int first) {
    int n = 0;
    while (shape[n])
        n++;
    const int from = random_below(n);
    for (int i = 0; i < n; i++) {
        const char *c = shape[(from + i) % n];
        const int size = (int)strlen(c), turn = random_below(size), at = f->n++;
        f->size[at] = size;
        for (int k = 0; k < size; k++)
            f->node[at][k] = first + c[(k + turn) % size] - '0';
        f->owner[at] = f->n_cells;
        f->neighbour[at] = -1;
    }
    f->n_cells++;
}

static const char *const tetrahedron[] = {"021", "013", "123", "203", NULL};
static const char *const pyramid[] = {"0321", "014", "124", "234", "304", NULL};
static const char *const wedge[] = {"021", "345", "0143", "1254", "2035", NULL};
static const char *const hexahedron[] = {"0321", "4567", "0154", "1265", "2376", "3047", NULL};
static const char *const split[] = {"0321", "4567", "015", "054", "1265", "2376", "3047", NULL};
static const char *const column[] = {"43210", "56789", "0165", "1276",
                                     "2387",  "3498",  "4059", NULL};
static const char *const *const shapes[] = {tetrahedron, pyramid, wedge, hexahedron, split, column};

/** Give faces to the cell behind them instead, as its neighbour: those faces are the other way around. */
static void turn_some(faces *f) {
    for (int i = 0; i < f->n; i++) {
        if (random_below(2) || f->owner[i] == f->n_cells - 1)
            continue;
        for (int a = 0, b = f->size[i] - 1; a < b; a++, b--) {
            const int32_t node = f->node[i][a];
            f->node[i][a] = f->node[i][b];
            f->node[i][b] = node;
        }
        f->neighbour[i] = f->owner[i];
        f->owner[i] = f->n_cells - 1; /* one cell more, of which nothing is right */
    }
}

/** Change a node, the order of nodes or the cell of some faces. */
static void damage(faces *f) {
    for (int i = random_below(6); i > 0; i--) {
        const int at = random_below(f->n), k = random_below(f->size[at]);
        int32_t *node = f->node[at], *other = f->node[random_below(f->n)], old = node[k];
        switch (random_below(4)) {
        case 0:
            node[k] = other[0];
            break;
        case 1:
            node[k] = node[(k + 1) % f->size[at]];
            node[(k + 1) % f->size[at]] = old;
            break;
        case 2:
            f->owner[at] = f->owner[random_below(f->n)];
            break;
        default:
            f->size[at] = f->size[at] > 3 ? f->size[at] - 1 : 3;
        }
        if (f->owner[at] == f->neighbour[at])
            f->neighbour[at] = -1;
    }
}

/** Put faces in any order. */
static void shuffle(faces *f) {
    for (int i = f->n - 1; i > 0; i--) {
        const int k = random_below(i + 1);
        const faces old = {
            .size[0] = f->size[i], .owner[0] = f->owner[i], .neighbour[0] = f->neighbour[i]};
        int32_t node[FACE_NODES];
        memcpy(node, f->node[i], sizeof node);
        memcpy(f->node[i], f->node[k], sizeof node);
        memcpy(f->node[k], node, sizeof node);
        f->size[i] = f->size[k], f->owner[i] = f->owner[k], f->neighbour[i] = f->neighbour[k];
        f->size[k] = old.size[0], f->owner[k] = old.owner[0], f->neighbour[k] = old.neighbour[0];
    }
}

/** Find elements of faces with and without the walk, which must be the same. Adds the number of each type. */
static void compare(const faces *f, int threads, int *n_of_type) {
    static int32_t start[MOST + 1], node[MOST * FACE_NODES];
    io_model model = {.threads = threads, .input.path = (char[]){"points"}};
    foam_mesh mesh = {.model = &model,
                      .dim = 3,
                      .n_faces = f->n,
                      .n_cells = f->n_cells,
                      .n_listed = f->n,
                      .start = start,
                      .node = node,
                      .owner = (int32_t *)(uintptr_t)f->owner,
                      .neighbour = (int32_t *)(uintptr_t)f->neighbour};
    for (int i = 0; i < f->n; i++) {
        memcpy(node + start[i], f->node[i], (size_t)f->size[i] * sizeof *node);
        start[i + 1] = start[i] + f->size[i];
    }
    foam_elements by_walk, plain;
    planish_error error = {.text = ""}, plain_error = {.text = ""};
    const int status = foam_find_elements(&mesh, 0, &by_walk, &error);
    assert_int_equal(status, foam_find_elements(&mesh, 1, &plain, &plain_error));
    assert_string_equal(error.text, plain_error.text);
    assert_int_equal(by_walk.width, plain.width);
    for (int i = 0; i < f->n_cells && !status; i++) {
        const int type = plain.type[i];
        assert_int_equal(by_walk.type[i], type);
        n_of_type[type]++;
        const int n = type == PLANISH_CELL_TETRAHEDRON ? 4
                      : type == PLANISH_CELL_PYRAMID   ? 5
                      : type == PLANISH_CELL_WEDGE     ? 6
                      : type                           ? 8
                                                       : 0;
        assert_memory_equal(by_walk.node + i * by_walk.width, plain.node + i * plain.width,
                            (size_t)n * sizeof *node);
    }
    n_of_type[UINT8_MAX] += status != 0;
    pl_free(by_walk.type);
    pl_free(by_walk.node);
    pl_free(plain.type);
    pl_free(plain.node);
}

/** Make cells of the first n shapes, with nodes of their own, some of which are those of the cell before. */
static void make(faces *f, int n, int n_cells) {
    *f = (faces){.n = 0};
    for (int i = 0; i < n_cells; i++)
        add_cell(f, shapes[random_below(n)], 6 * i);
    add_cell(f, hexahedron, 6 * n_cells);
}

static void whole_cells_are_found(void **state) {
    static faces f;
    int n_of_type[UINT8_MAX + 1] = {0};
    (void)state;
    for (random_state = 0; random_state < 200; random_state++) {
        const uint32_t seed = random_state;
        make(&f, 6, 100);
        turn_some(&f);
        shuffle(&f);
        compare(&f, 1 + (seed & 1), n_of_type);
        random_state = seed;
    }
    static const int types[] = {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_PYRAMID, PLANISH_CELL_WEDGE,
                                PLANISH_CELL_HEXAHEDRON};
    for (int i = 0; i < 4; i++)
        assert_in_range(n_of_type[types[i]], 2500, 4500);
    assert_in_range(n_of_type[0], 5000, 9000);
    assert_int_equal(n_of_type[UINT8_MAX], 0);
}

static void damaged_cells_are_the_same(void **state) {
    static faces f;
    int n_of_type[UINT8_MAX + 1] = {0};
    (void)state;
    for (random_state = 0; random_state < 60000; random_state++) {
        const uint32_t seed = random_state;
        random_state = seed * 2654435761u;
        make(&f, seed & 1 ? 1 : 4, 1 + random_below(3));
        if (seed & 2)
            turn_some(&f);
        damage(&f);
        shuffle(&f);
        compare(&f, 1, n_of_type);
        random_state = seed;
    }
    assert_in_range(n_of_type[PLANISH_CELL_TETRAHEDRON], 10000, 120000);
    assert_in_range(n_of_type[PLANISH_CELL_HEXAHEDRON], 5000, 120000);
    assert_in_range(n_of_type[0], 10000, 120000);
    assert_in_range(n_of_type[UINT8_MAX], 1000, 60000);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_cells_are_found),
        cmocka_unit_test(damaged_cells_are_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
