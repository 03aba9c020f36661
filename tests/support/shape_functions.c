/* shape_functions: written down by type, in the order of VTK's nodes. */
#include "support/shape_functions.h"

#include "geometry/cell.h"
#include "support/loose_cells.h"

/* ---- Reference elements, by VTK's figures ---------------------------------------------------- */

static const double TRIANGLE[][3] = {{0, 0, 0},  {1, 0, 0},   {0, 1, 0},
                                     {.5, 0, 0}, {.5, .5, 0}, {0, .5, 0}};
static const double QUADRILATERAL[][3] = {{0, 0, 0},  {1, 0, 0},  {1, 1, 0},
                                          {0, 1, 0},  {.5, 0, 0}, {1, .5, 0},
                                          {.5, 1, 0}, {0, .5, 0}, {.5, .5, 0}};
static const double TETRAHEDRON[][3] = {{0, 0, 0},   {1, 0, 0},   {0, 1, 0},  {0, 0, 1},
                                        {.5, 0, 0},  {.5, .5, 0}, {0, .5, 0}, {0, 0, .5},
                                        {.5, 0, .5}, {0, .5, .5}};
static const double HEXAHEDRON[][3] = {
    {0, 0, 0},   {1, 0, 0},   {1, 1, 0},   {0, 1, 0},   {0, 0, 1},   {1, 0, 1},   {1, 1, 1},
    {0, 1, 1},   {.5, 0, 0},  {1, .5, 0},  {.5, 1, 0},  {0, .5, 0},  {.5, 0, 1},  {1, .5, 1},
    {.5, 1, 1},  {0, .5, 1},  {0, 0, .5},  {1, 0, .5},  {1, 1, .5},  {0, 1, .5},  {0, .5, .5},
    {1, .5, .5}, {.5, 0, .5}, {.5, 1, .5}, {.5, .5, 0}, {.5, .5, 1}, {.5, .5, .5}};
static const double WEDGE[][3] = {{0, 0, 0},   {1, 0, 0},    {0, 1, 0},   {0, 0, 1},  {1, 0, 1},
                                  {0, 1, 1},   {.5, 0, 0},   {.5, .5, 0}, {0, .5, 0}, {.5, 0, 1},
                                  {.5, .5, 1}, {0, .5, 1},   {0, 0, .5},  {1, 0, .5}, {0, 1, .5},
                                  {.5, 0, .5}, {.5, .5, .5}, {0, .5, .5}};
static const double PYRAMID[][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5, .5, .7}};

const double (*shape_place(int type))[3] {
    static const loose_point *const of[] = {TRIANGLE, QUADRILATERAL, TETRAHEDRON,
                                            PYRAMID,  WEDGE,         HEXAHEDRON};
    return loose_choose(type, of);
}

/** Lagrange's polynomial on the line that is 1 at the place at (0, 1/2, 1) and 0 at the others. */
static double on_line(int order, double at, double t) {
    if (order == 1)
        return at > 0.5 ? t : 1 - t;
    return at < 0.25 ? (1 - t) * (1 - 2 * t) : at < 0.75 ? 4 * t * (1 - t) : t * (2 * t - 1);
}

/** The same on a simplex; at and t have dim components. */
static double on_simplex(int order, int dim, const double at[], const double t[]) {
    double first = 1, first_at = 1, product = 1;
    for (int d = 0; d < dim; d++) {
        first -= t[d];
        first_at -= at[d];
    }
    for (int d = -1; d < dim; d++) {
        const double lambda = d < 0 ? first : t[d], place = d < 0 ? first_at : at[d];
        if (place > 0.75)
            product *= order == 1 ? lambda : lambda * (2 * lambda - 1);
        else if (place > 0.25)
            product *= 2 * lambda;
    }
    return product;
}

/** Serendipity quadrilaterals and hexahedra, in -1 .. 1. */
static double serendipity(int dim, const double at[], const double t[]) {
    double product = 1, sum = 0;
    int n_middle = 0;
    for (int d = 0; d < dim; d++) {
        const double x = 2 * t[d] - 1, place = 2 * at[d] - 1;
        const int is_middle = place == 0;
        n_middle += is_middle;
        product *= is_middle ? 1 - x * x : (1 + x * place) / 2;
        sum += x * place;
    }
    return n_middle > 0 ? product : product * (sum - (dim - 1));
}

double shape_value(int type, int node, const double t[3]) {
    const double *at = shape_place(type)[node];
    const int order = pl_cell_type_of(type)->order;
    switch (type) {
    case PLANISH_CELL_TRIANGLE:
    case PLANISH_CELL_TRIANGLE6:
        return on_simplex(order, 2, at, t);
    case PLANISH_CELL_TETRAHEDRON:
    case PLANISH_CELL_TETRAHEDRON10:
        return on_simplex(order, 3, at, t);
    case PLANISH_CELL_QUADRILATERAL8:
        return serendipity(2, at, t);
    case PLANISH_CELL_HEXAHEDRON20:
        return serendipity(3, at, t);
    case PLANISH_CELL_QUADRILATERAL:
    case PLANISH_CELL_QUADRILATERAL9:
        return on_line(order, at[0], t[0]) * on_line(order, at[1], t[1]);
    case PLANISH_CELL_WEDGE:
    case PLANISH_CELL_WEDGE18:
        return on_simplex(order, 2, at, t) * on_line(order, at[2], t[2]);
    case PLANISH_CELL_WEDGE15: {
        const double flat[2] = {at[0], at[1]}, z = 2 * t[2] - 1, side = 2 * at[2] - 1;
        const double lambda = on_simplex(1, 2, flat, t);
        if (side == 0)
            return lambda * (1 - z * z);
        if (node >= 6)
            return on_simplex(2, 2, at, t) * (1 + side * z) / 2;
        return lambda * (1 + side * z) * (2 * lambda - 1) / 2 - lambda * (1 - z * z) / 2;
    }
    case PLANISH_CELL_PYRAMID: { /* collapsed: z is the share of the apex */
        if (node == 4)
            return t[2];
        return on_line(1, at[0], t[0]) * on_line(1, at[1], t[1]) * (1 - t[2]);
    }
    default:
        return on_line(order, at[0], t[0]) * on_line(order, at[1], t[1]) *
               on_line(order, at[2], t[2]);
    }
}

/* They have degree 2 in each variable at most, so that differences over a step are exact. */
void shape_slopes(int type, const double t[3], double slope[SHAPE_NODES][3]) {
    const pl_cell_type *of = pl_cell_type_of(type);
    for (int m = 0; m < of->shape->dim; m++) {
        double after[3] = {t[0], t[1], t[2]}, before[3] = {t[0], t[1], t[2]};
        after[m] += 0.25;
        before[m] -= 0.25;
        for (int i = 0; i < of->n_nodes; i++)
            slope[i][m] = 2 * (shape_value(type, i, after) - shape_value(type, i, before));
    }
}
