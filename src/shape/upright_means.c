/* upright_means: means over the elements at uprights: of their heights, and of any values. */
#include "shape/upright_means.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>

/* ---- heights ------------------------------------------------------------------------------------ */

/** Return the sum of the cosines between an upright and edges along the layer. */
static double cosines_of(const pl_columns *c, int64_t upright, const double along[2][3]) {
    const int32_t *end = c->end + 2 * upright;
    double edge[3], sum = 0;
    pl_columns_edge(c, end[0], end[1], edge);
    for (int j = 0; j < c->mesh->dim - 1; j++) {
        const double square = pl_dot(3, edge, edge) * pl_dot(3, along[j], along[j]);
        sum += square > 0 ? pl_dot(3, edge, along[j]) / sqrt(square) : 0;
    }
    return sum;
}

/** Add the heights of an element at its uprights: determinants of corners by what their edges along the
 *  layer span. sum [n_uprights][PL_UPRIGHT_SUMS]. */
static void add_heights(const pl_columns *c, const pl_layer_cell *cell, double *sum) {
    const planish_mesh *mesh = c->mesh;
    const pl_cell_shape *shape = pl_cell_type_of(mesh->cells->type[cell->cell])->shape;
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell->cell];
    const int n_corners = pl_layer_corners(shape, cell);
    for (int k = 0; k < n_corners; k++) {
        double edges[3][3] = {{0}}, along[2][3], normal[3];
        const int32_t upright = cell->upright[pl_columns_corner(c, cell, k, along)];
        double *of = sum + PL_UPRIGHT_SUMS * (int64_t)upright;
        of[PL_UPRIGHT_COSINES] += cosines_of(c, upright, (const double(*)[3])along);
        for (int j = 0; j < shape->dim; j++)
            pl_columns_edge(c, node[k], node[shape->neighbour[k][j]], edges[j]);
        if (shape->dim == 2)
            along[1][2] = 1; /* so that the base is the length */
        pl_cross(along[0], along[1], normal);
        const double base = sqrt(pl_dot(3, normal, normal));
        const double D =
            c->sign[cell->cell] * pl_determinant_of_edges(shape->dim, (const double(*)[3])edges);
        if (base > 0) {
            of[PL_UPRIGHT_HEIGHTS] += D / base;
            of[PL_UPRIGHT_CORNERS] += 1;
            of[PL_UPRIGHT_INVERTED] += !(D > 0);
        }
    }
}

double *pl_columns_sum_heights(const pl_columns *c) {
    double *sum = pl_alloc_zero(PL_UPRIGHT_SUMS * c->n_uprights, sizeof *sum);
    for (int64_t i = 0; sum && i < c->n_cells; i++)
        add_heights(c, &c->cell[i], sum);
    return sum;
}

int pl_columns_measure_heights(const pl_columns *c, double *height, planish_error *error) {
    double *sum = pl_columns_sum_heights(c);
    for (int64_t u = 0; sum && u < c->n_uprights; u++)
        height[u] = sum[PL_UPRIGHT_SUMS * u + PL_UPRIGHT_HEIGHTS] /
                    sum[PL_UPRIGHT_SUMS * u + PL_UPRIGHT_CORNERS];
    pl_free(sum);
    return sum ? PLANISH_OK : pl_fail_memory(error, "the heights of layers");
}

/* ---- any values --------------------------------------------------------------------------------- */

/** Add x and 1 / x to a sum, if x > 0. */
static void add_to_mean(double x, double sum[2]) {
    if (x > 0) {
        sum[0] += x;
        sum[1] += 1 / x;
    }
}

/** The mean of a sum, 0 of none. */
static double mean_of(const double sum[2]) {
    return sum[1] > 0 ? sqrt(sum[0] / sum[1]) : 0;
}

int pl_columns_average(const pl_columns *c, int rounds, double *value, double *of_cell,
                       planish_error *error) {
    double(*sum)[2] = pl_alloc(c->n_uprights, sizeof *sum);
    if (!sum)
        return pl_fail_memory(error, "the heights of layers");
    for (int round = 0; round <= rounds; round++) { /* the last one is for the elements alone */
        for (int64_t i = 0; i < c->n_cells; i++) {
            double of[2] = {0, 0};
            for (int k = 0; k < c->cell[i].n_uprights; k++)
                add_to_mean(value[c->cell[i].upright[k]], of);
            of_cell[i] = mean_of(of);
        }
        for (int64_t u = 0; u < c->n_uprights; u++)
            sum[u][0] = sum[u][1] = 0;
        for (int64_t i = 0; round < rounds && i < c->n_cells; i++)
            for (int k = 0; k < c->cell[i].n_uprights; k++)
                add_to_mean(of_cell[i], sum[c->cell[i].upright[k]]);
        for (int64_t u = 0; round < rounds && u < c->n_uprights; u++)
            value[u] = mean_of(sum[u]);
    }
    pl_free(sum);
    return PLANISH_OK;
}
