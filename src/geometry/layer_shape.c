/* layer_shape: the edges of corners that are wanted. */
#include "geometry/layer_shape.h"

#include <math.h>

int pl_upright_at(const pl_cell_shape *shape, int factor, int c) {
    int n = 0;
    for (int b = 0; b < shape->n_corners; b++) {
        int is_same = 1;
        for (int f = 0; f < shape->n_simplices; f++)
            is_same &= f == factor || shape->vertex[b][f] == shape->vertex[c][f];
        if (is_same)
            return n;
        n += shape->vertex[b][factor] == 0;
    }
    return n;
}

/** Edges of corner c of a product: the upright is the last axis. */
static void product_edges(const pl_cell_shape *shape, const pl_layer_shape *wanted, int c,
                          double edges[3][3]) {
    const int dim = shape->dim;
    int n = 0;
    for (int j = 0; j < dim; j++) {
        const int f = pl_factor_of(shape, c, shape->neighbour[c][j]);
        const double cosine = shape->n_vertices[f] == 3 ? 0.5 : 0;
        if (f == wanted->factor) {
            edges[j][dim - 1] = wanted->height[pl_upright_at(shape, f, c)];
        } else if (n++ == 0) {
            edges[j][0] = wanted->size;
        } else {
            edges[j][0] = cosine * wanted->size;
            edges[j][1] = sqrt(1 - cosine * cosine) * wanted->size;
        }
    }
}

/** Edges of corner c of an element whose other corners are at to, from the first one. */
static void edges_of_corner(const pl_cell_shape *shape, const double (*to)[3], int c,
                            double edges[3][3]) {
    static const double origin[3] = {0, 0, 0};
    const double *from = c > 0 ? to[c - 1] : origin;
    for (int j = 0; j < shape->dim; j++) {
        const int b = shape->neighbour[c][j];
        pl_subtract(shape->dim, b > 0 ? to[b - 1] : origin, from, edges[j]);
    }
}

double pl_own_shape_edges(const pl_cell_shape *shape, const pl_own_shape *own, int c,
                          double edges[3][3]) {
    edges_of_corner(shape, own->edges, c, edges);
    return pl_determinant_of_edges(shape->dim, (const double(*)[3])edges);
}

int pl_layer_target(const pl_cell_shape *shape, const pl_layer_shape *wanted, int c,
                    pl_target *target) {
    double edges[3][3] = {{0}};
    if (!wanted)
        pl_ideal_edges(shape, edges);
    else if (shape->n_simplices == 1)
        edges_of_corner(shape, wanted->edges, c, edges);
    else
        product_edges(shape, wanted, c, edges);
    const double D = pl_determinant_of_edges(shape->dim, (const double(*)[3])edges);
    return pl_target_make(shape->dim, (const double(*)[3])edges, D < 0 ? -1 : 1, target);
}

int pl_layer_shapes_target(const pl_layer_shapes *shapes, const pl_cell_shape *shape, int64_t cell,
                           int c, pl_target *target) {
    const int32_t place = shapes->place[cell];
    double edges[3][3] = {{0}};
    if (place >= -1)
        return pl_layer_target(shape, place < 0 ? NULL : &shapes->shape[place], c, target);
    const double D = pl_own_shape_edges(shape, &shapes->own[-2 - place], c, edges);
    return pl_target_make(shape->dim, (const double(*)[3])edges, D < 0 ? -1 : 1, target);
}
