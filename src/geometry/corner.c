/* corner: the forms of link facets, from the ideal corners of the shapes. */
#include "geometry/corner.h"

#include "geometry/cube_root.h"
#include "planish/planish.h"

#include <math.h>
#include <string.h>

/** A type of each kind, in 2-D and 3-D; 0: there is none. */
static const uint8_t TYPE[2][4] = {
    {PLANISH_CELL_TRIANGLE, PLANISH_CELL_QUADRILATERAL, 0, 0},
    {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_WEDGE, PLANISH_CELL_PYRAMID}};

int pl_kind_of_shape(const pl_cell_shape *shape) {
    int kind = 0;
    while (pl_cell_type_of(TYPE[shape->dim - 2][kind])->shape != shape)
        kind++;
    return kind;
}

/** Weights of the edges between the nodes of a corner, the corner being node 0. */
static void find_weights(const pl_cell_shape *shape, double weight[4][4]) {
    memset(weight, 0, 16 * sizeof weight[0][0]);
    for (int i = 0; i < shape->dim; i++)
        weight[0][i + 1] = weight[i + 1][0] = shape->to_corner[i];
    for (int i = 0, pair = 0; i < shape->dim; i++)
        for (int j = i + 1; j < shape->dim; j++, pair++)
            weight[i + 1][j + 1] = weight[j + 1][i + 1] = shape->between[pair];
}

/** Volume of an element whose corners all have the determinant 1. */
static double volume_of(const pl_cell_shape *shape) {
    static const double VOLUME[2][4] = {{1.0 / 2, 1, 0, 0}, {1.0 / 6, 1, 1.0 / 2, 1.0 / 3}};
    return VOLUME[shape->dim - 2][pl_kind_of_shape(shape)];
}

/** Fill the row that kernels load. e0 = sum over the edges of the facet of (w_i w_j / c + w_ij)
 * |edge|^2, which loses nothing to cancellation. */
static void make_row(pl_corner_form *form, int dim) {
    const double root = sqrt(form->factor);
    double c = 0;
    for (int j = 0; j < dim; j++)
        c += form->weight[j];
    for (int j = 1; j < dim; j++)
        form->row[j - 1] = form->weight[j] / c;
    form->row[2] = root * c;
    form->row[3] = form->share;
    for (int i = 0, pair = dim; i < dim; i++)
        for (int j = i + 1; j < dim; j++, pair++)
            form->row[4 + pair - dim] =
                root * (form->weight[i] * form->weight[j] / c + form->weight[pair]);
}

/** Whether an element has the edge between nodes i and j of a corner, the corner being node 0. The
 *  edge of a pyramid to its apex has no weight, the diagonal of its base has one. */
static int has_edge(const pl_cell_shape *shape, double weight[4][4], int i, int j) {
    const int is_pyramid = shape->n_simplices == 0;
    return weight[i][j] > 0 || (is_pyramid && weight[i][j] == 0);
}

static void make_form(const pl_cell_shape *shape, int place, int turned, pl_corner_form *form) {
    const int dim = shape->dim;
    double weight[4][4];
    int node[3] = {0, 0, 0}, k = 0;
    find_weights(shape, weight);
    for (int j = 0; j <= dim; j++)
        if (j != place)
            node[k++] = j;
    if (turned) {
        const int first = dim - 2, kept = node[first];
        node[first] = node[first + 1];
        node[first + 1] = kept;
    }
    form->corner = -1;
    for (int i = 0, pair = dim; i < dim; i++) {
        form->weight[i] = weight[place][node[i]];
        form->is_edge[i] = (uint8_t)has_edge(shape, weight, place, node[i]);
        form->corner = node[i] == 0 ? i : form->corner;
        for (int j = i + 1; j < dim; j++, pair++) {
            form->weight[pair] = weight[node[i]][node[j]];
            form->is_edge[pair] = (uint8_t)has_edge(shape, weight, node[i], node[j]);
        }
    }
    const double w = shape->determinant;
    form->factor = dim == 3 ? w * pl_cube_root(w) / 9 : w * w / 4;
    form->share = shape->n_simplices == 1 ? 1 : 1.0 / shape->n_measured;
    form->determinant = w;
    form->volume = volume_of(shape);
    make_row(form, dim);
}

void pl_corner_forms_make(int dim, pl_corner_form form[PL_N_FORMS]) {
    memset(form, 0, PL_N_FORMS * sizeof *form);
    for (int kind = 0; kind < 4 && TYPE[dim - 2][kind] != 0; kind++)
        for (int place = 0; place <= dim; place++)
            for (int turned = 0; turned < 2; turned++)
                make_form(pl_cell_type_of(TYPE[dim - 2][kind])->shape, place, turned,
                          &form[pl_form_code(pl_corner_code(kind, 0), place, turned)]);
}
