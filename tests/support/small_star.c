/* small_star: a node inside a triangle, a tetrahedron or an octahedron. */
#include "support/small_star.h"

#include "support/effort.h"

#include <math.h>

/* Exponents of sizes: derivatives by coordinates of such stars are doubles. */
enum { MOST_SIZE = 250 };

/* Of a triangle, a tetrahedron, an octahedron: nodes 0 1 2 on top, each opposite 3 below. */
static const uint16_t TRIANGLE[] = {0, 1, 1, 2, 2, 0},
                      TETRAHEDRON[] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
static const uint16_t OCTAHEDRON[] = {0, 1, 2, 1, 0, 5, 2, 1, 3, 0, 2, 4,
                                      5, 0, 4, 3, 1, 5, 4, 2, 3, 5, 4, 3};

static long double determinant(const hand_star *s, int64_t facet) {
    long double x[3];
    for (int d = 0; d < s->dim; d++)
        x[d] = s->coordinates[d];
    return hand_star_measure(s, facet, x);
}

static void rotate(uint16_t *node, int steps) {
    for (int i = 0; i < steps; i++) {
        const uint16_t first = node[0];
        node[0] = node[1];
        node[1] = node[2];
        node[2] = first;
    }
}

/** Link facets of dim nodes, in the order that makes the first one positive. */
static void set_link(hand_star *s, const uint16_t *link, int n_nodes, int n_facets,
                     uint64_t *random) {
    const int dim = s->dim;
    s->ring_offset[1] = n_nodes;
    s->link_offset[1] = n_facets;
    for (int turned = 0; turned < 2; turned++) {
        for (int i = 0; i < n_facets * dim; i++)
            s->link[i] = link[!turned || i % dim > 1 ? i : i % dim ? i - 1 : i + 1];
        if (determinant(s, 0) > 0)
            break;
    }
    for (int f = 0; f < n_facets; f++) /* any of their nodes may be first */
        rotate(s->link + f * dim, dim == 3 ? (int)random_below(random, 3) : 0);
    hand_star_pack_link(s);
}

static int is_positive(const hand_star *s) {
    int positive = 1;
    for (int64_t f = 0; f < s->link_offset[1]; f++)
        positive &= determinant(s, f) > 0;
    return positive;
}

/** One more node, on the other side of the star's. */
static void close_by_one(hand_star *s, double x[4][3], uint64_t *random) {
    const int dim = s->dim;
    double *last = s->coordinates + (dim + 1) * dim;
    for (int d = 0; d < dim; d++)
        last[d] = x[0][d];
    for (int j = 1; j <= dim; j++) {
        const double weight = exp2(random_between(random, -6, 1));
        for (int d = 0; d < dim; d++)
            last[d] -= weight * (x[j][d] - x[0][d]);
    }
    set_link(s, dim == 3 ? TETRAHEDRON : TRIANGLE, dim + 1, dim + 1, random);
}

/** Three more around the line from the node to the facet, so that a facet that is small, or far,
 *  has no flat elements next to it. Returns 0 if some are not positive, as with most shapes. */
static int close_by_three(hand_star *s, double x[4][3], uint64_t *random) {
    double middle[3], length = 0;
    for (int d = 0; d < 3; d++) {
        middle[d] = (x[1][d] + x[2][d] + x[3][d]) / 3 - x[0][d];
        length += middle[d] * middle[d];
    }
    for (int j = 1; j <= 3; j++) {
        double away[3], along = 0, square = 0;
        for (int d = 0; d < 3; d++)
            along += (middle[d] + x[0][d] - x[j][d]) * middle[d] / length;
        for (int d = 0; d < 3; d++) {
            away[d] = middle[d] + x[0][d] - x[j][d] - along * middle[d];
            square += away[d] * away[d];
        }
        const double reach = random_between(random, 0.5, 1.5) * sqrt(length / square);
        for (int d = 0; d < 3; d++)
            s->coordinates[3 * (j + 3) + d] = x[0][d] + reach * away[d] - 0.3 * middle[d];
    }
    set_link(s, OCTAHEDRON, 6, 8, random);
    return is_positive(s);
}

int small_star_draw(hand_star *s, shape_kind kind, double thin, uint64_t *random) {
    const int dim = s->dim;
    const shape_place place = shape_place_draw(random, MOST_SIZE);
    double x[4][3];
    shape_draw(kind, dim, thin, &place, random, x);
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            s->coordinates[j * dim + d] = x[j][d];
    if (dim == 2 || random_below(random, 2) || !close_by_three(s, x, random))
        close_by_one(s, x, random);
    return place.size;
}
