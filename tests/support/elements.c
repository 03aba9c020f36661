/* elements: elements of any type by the places of their nodes. */
#include "support/elements.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

static const double simplex[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const double box[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
static const double wedge[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
static const double pyramid[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5, .5, .7}};

static const double (*corners_of(int dim, int n_corners))[3] {
    switch (n_corners) {
    case 3:
        return simplex;
    case 4:
        return dim == 2 ? box : simplex;
    case 5:
        return pyramid;
    case 6:
        return wedge;
    default:
        return box;
    }
}

static void swap(double a[3], double b[3]) {
    for (int d = 0; d < 3; d++) {
        const double kept = a[d];
        a[d] = b[d];
        b[d] = kept;
    }
}

elements_places elements_find(int dim, const char *nodes, int swapped) {
    elements_places p = {.dim = dim};
    int n_corners = 0;
    for (const char *c = nodes; *c; c++)
        n_corners = *c - '0' > n_corners ? *c - '0' : n_corners;
    const double(*corner)[3] = corners_of(dim, n_corners);
    for (const char *c = nodes; *c; p.n++) {
        double x[3] = {0};
        int n = 0;
        for (; *c && *c != ' '; c++, n++)
            for (int d = 0; d < 3; d++)
                x[d] += corner[*c - '1'][d];
        c += *c == ' ';
        for (int d = 0; d < 3; d++)
            x[d] /= n;
        p.xyz[p.n][0] = x[0] + 0.1 * x[1] * x[1] + 0.15 * x[1] * x[2];
        p.xyz[p.n][1] = x[1] + 0.1 * x[0] * x[0] + 0.1 * x[0] * x[2];
        p.xyz[p.n][2] = x[2] + (dim == 3 ? 0.15 * x[0] * x[1] : 0);
    }
    if (swapped && n_corners == 5)
        swap(p.xyz[2], p.xyz[3]);
    else if (swapped)
        swap(p.xyz[p.n - 2], p.xyz[p.n - 1]);
    return p;
}

void elements_check(planish_file *file, int type, int64_t number, int n_held, int is_valid) {
    planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    planish_cell_quality quality;
    planish_file_info info;
    planish_error error = {.text = ""};
    planish_file_get_info(file, &info);
    assert_int_equal(mesh.n_elements, 0);
    assert_int_equal(info.n_other_elements, 1);
    assert_int_equal(planish_file_cells(file, &cells, &error), 0);
    assert_int_equal(cells.n, 1);
    assert_int_equal(cells.type[0], type);
    assert_int_equal(planish_file_element_number(file, 0), number);
    planish_mesh all = mesh;
    all.elements = NULL;
    all.cells = &cells;
    all.n_elements = all.cells->n;
    int status = planish_measure_cells(&all, 0, 1, &quality, NULL, &error);
    if (status)
        print_error("%s\n", error.text);
    assert_int_equal(status, 0);
    assert_int_equal(quality.all.n_elements, 1);
    assert_int_equal(quality.all.n_uncertified, 0);
    assert_int_equal(quality.all.n_inverted, !is_valid);
    int held = 0;
    for (int64_t i = 0; i < mesh.n_nodes; i++)
        held += file->model.hold[i] == IO_HELD_BY_OTHER;
    assert_int_equal(held, n_held);
    planish_file_close(file);
}
