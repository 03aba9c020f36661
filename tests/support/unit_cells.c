/* unit_cells: one straight element of any type, with its nodes in the order of a format. */
#include "support/unit_cells.h"

#include "geometry/cell.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

int unit_cell_dim(const unit_cell *cell) {
    return pl_cell_type_of(cell->type)->shape->dim;
}

int unit_cell_nodes(const unit_cell *cell) {
    const pl_cell_type *type = pl_cell_type_of(cell->type);
    assert_int_equal(type->n_nodes, type->shape->n_corners + (int)(strlen(cell->mids) + 1) / 3);
    return type->n_nodes;
}

int unit_cell_is_kept(const unit_cell *cell) {
    return cell->type == PLANISH_CELL_TRIANGLE || cell->type == PLANISH_CELL_TETRAHEDRON;
}

/** Place of a corner in the unit element. */
static void corner_place(const pl_cell_shape *shape, int corner, double at[3]) {
    static const double simplex[][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    static const double square[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const int n = shape->n_corners, is_wedge = n == 6;
    const int is_simplex = is_wedge || n == shape->dim + 1;
    const int in_base = is_wedge ? 3 : 4;
    if (is_simplex) {
        for (int d = 0; d < 3; d++)
            at[d] = simplex[is_wedge ? corner % 3 : corner][d];
    } else {
        at[0] = n == 5 && corner == 4 ? 0.5 : square[corner % 4][0];
        at[1] = n == 5 && corner == 4 ? 0.5 : square[corner % 4][1];
        at[2] = 0;
    }
    if (n > 4)
        at[2] = corner / in_base;
}

int unit_cell_places(const unit_cell *cell, int is_mirrored, double *xyz) {
    static const double skew[3][3] = {{1, 0.25, 0.125}, {0.125, 1.5, 0.25}, {0, -0.125, 0.75}};
    const pl_cell_shape *shape = pl_cell_type_of(cell->type)->shape;
    const int n = unit_cell_nodes(cell);
    for (int i = 0; i < n; i++) {
        const char *ends = cell->mids + 3 * (i - shape->n_corners);
        for (int d = 0; d < 3; d++)
            xyz[3 * i + d] = 0;
        if (i < shape->n_corners) {
            double at[3];
            corner_place(shape, i, at);
            at[0] *= is_mirrored ? -1 : 1;
            for (int d = 0; d < shape->dim; d++)
                for (int k = 0; k < shape->dim; k++)
                    xyz[3 * i + d] += skew[d][k] * at[k];
        } else {
            for (int d = 0; d < shape->dim; d++)
                xyz[3 * i + d] = (xyz[3 * (ends[0] - '1') + d] + xyz[3 * (ends[1] - '1') + d]) / 2;
        }
    }
    return n;
}

/** Fail unless node i of an element is between its corners. */
static void check_node(const planish_mesh *mesh, const int32_t *nodes, int i, const uint8_t *ends) {
    const double *x = mesh->coordinates;
    const int dim = mesh->dim;
    for (int d = 0; d < dim; d++) {
        const double middle = (x[dim * nodes[ends[0]] + d] + x[dim * nodes[ends[1]] + d]) / 2;
        if (fabs(x[dim * nodes[i] + d] - middle) > 1e-12)
            fail_msg("node %d is not between corners %d and %d", i, ends[0], ends[1]);
    }
}

void unit_cell_check(planish_file *file, const unit_cell *cell, int n) {
    const pl_cell_type *type = pl_cell_type_of(cell->type);
    const planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    planish_cell_quality quality;
    planish_error error = {.text = ""};
    assert_int_equal(planish_file_cells(file, &cells, &error), 0);
    assert_int_equal(cells.n, n);
    assert_int_equal(mesh.dim, type->shape->dim);
    for (int64_t k = 0; k < cells.n; k++) {
        assert_int_equal(cells.type[k], cell->type);
        for (int i = 0; i < type->n_nodes; i++)
            check_node(&mesh, cells.node + cells.offset[k], i, type->between[i]);
    }
    planish_mesh all = mesh;
    all.elements = NULL;
    all.cells = &cells;
    all.n_elements = all.cells->n;
    if (planish_measure_cells(&all, 0, 1, &quality, NULL, &error))
        fail_msg("%s", error.text);
    assert_int_equal(quality.all.n_elements, n);
    assert_int_equal(quality.all.n_inverted, 0);
    assert_int_equal(quality.all.n_uncertified, 0);
    assert_int_equal(quality.all.n_curved, 0);
}
