/* corner: elements of every type as corners.
 *
 * Where dim edges meet, an element has a corner: a simplex of the corner and its dim neighbours. An
 * element's AR^2 is the mean of its corners' mu^2, mu the mean ratio against the ideal corner of the
 * element's shape (docs/measures.md). A simplex has one corner, which is itself. In the star of a
 * node x a corner is the facet opposite x, with a form: how x and the facet's nodes, p0 to p2, enter
 *
 *     E = sum of weights * squared edges,    mu^2 = factor * E^2 * D^-k,  k = 4/3, in 2-D 2
 *
 * D is the determinant of the corner's edges, positive in a valid mesh. So E = c |x - o|^2 + e0 with
 * constants of the facet, and D is affine in x.
 *
 *   pl_kind_of_shape, pl_shape_of_kind    kinds of shapes
 *   pl_corner_code, _kind, _index         the byte that says which corner of which shape
 *   pl_form_code                          the byte of a link facet: the corner, and where x is in it
 *   pl_corner_form, pl_corner_forms_make  the forms of all codes
 *   pl_opposite_corner                    the corner of a hexahedron that shares no face
 *   pl_ideal_edges                        edges of an ideal corner
 *   pl_mean_square                        mu^2 of a corner
 *   pl_blunt_mean_square                  mu^2 up to which no corner is sharp
 */
#ifndef PL_GEOMETRY_CORNER_H
#define PL_GEOMETRY_CORNER_H

#include "geometry/cell.h"
#include "geometry/cube_root.h"

#include <math.h>

/** Shapes by their ideal corners. */
enum { PL_KIND_SIMPLEX = 0, PL_KIND_BRICK = 1, PL_KIND_WEDGE = 2, PL_KIND_PYRAMID = 3 };

enum { PL_N_FORMS = 32 }; /* codes of link facets */

/** Code of corner index of an element of kind; of its nodes, the corner comes first, then its
 *  neighbours, right-handed (pl_cell_shape.neighbour). BRICK: hexahedra, in 2-D quadrilaterals. The
 *  nodes of a simplex stand as they are listed. */
static inline uint8_t pl_corner_code(int kind, int index) {
    return (uint8_t)(kind << 3 | index);
}

/** Kind of a code. */
static inline int pl_corner_kind(uint8_t code) {
    return code >> 3;
}

/** Corner of its element that a code means. */
static inline int pl_corner_index(uint8_t code) {
    return code & 7;
}

/** Code of a link facet, which lies opposite node place (0 .. dim) of a corner. turned: its nodes
 *  are those that are left, but for the last two of them in 3-D, the first two in 2-D, which are
 *  exchanged (topology/rings.c). */
static inline uint8_t pl_form_code(uint8_t corner, int place, int turned) {
    return (uint8_t)(pl_corner_kind(corner) << 3 | place << 1 | (turned != 0));
}

/** Form of a link facet. */
typedef struct pl_corner_form {
    double weight[6];   /* of |x - p0|^2, |x - p1|^2, |x - p2|^2, then of the facet's edges p0 p1,
                           p0 p2, p1 p2; in 2-D of |x - p0|^2, |x - p1|^2, p0 p1 */
    double factor;      /* mu^2 = factor E^2 D^-k */
    double share;       /* of the corner in its element: 1 / its corners */
    double determinant; /* of the ideal corner with edges of 1 */
    double volume;      /* D times it counts as the element's volume: what a minimum volume is of */
    int corner;         /* which node is the corner: 0 .. 2 for p0 .. p2; -1: x */
    uint8_t is_edge[6]; /* 1: the element has the edge; in the order of weight */
    double row[8];      /* as kernels load them: o = p0 + row[0] (p1 - p0) + row[1] (p2 - p0); c;
                           share; e0 = sum of row[4 + k] |edge k|^2 over p0 p1, p0 p2, p1 p2; 0.
                           E, so c and e0, times the root of factor: mu^2 = E^2 D^-k */
} pl_corner_form;

/** Make the forms of all codes for elements of dimension dim. */
void pl_corner_forms_make(int dim, pl_corner_form form[PL_N_FORMS]);

/** Kind of a shape. */
int pl_kind_of_shape(const pl_cell_shape *shape);

/** Shape of a kind; NULL: there is none of dimension dim. */
const pl_cell_shape *pl_shape_of_kind(int dim, int kind);

/** Edges [dim][dim] of the ideal corner of a shape, from the corner to its neighbours; all are 1 long. edges is 0. */
void pl_ideal_edges(const pl_cell_shape *shape, double edges[3][3]);

/** mu^2 from E and D, divided by the determinant of the ideal corner: the same bits at every scale
 *  that is a power of two. E^3 and D^2 must be in a double's range. */
PL_INLINE double pl_mean_square(int dim, double e, double d) {
    if (dim == 2)
        return e / (2 * d) * (e / (2 * d));
    const double root = pl_cube_root(e * e * e / (27 * (d * d)));
    return root * root;
}

/** Return the mu^2 up to which no corner has a larger 1 / SJ^2 than acuteness; kinds: bit 1 << kind of
 *  those that there are. */
double pl_blunt_mean_square(int dim, unsigned kinds, double acuteness);

/** The corner of a hexahedron that shares no face with corner index. */
static inline int pl_opposite_corner(int index) {
    return index < 4 ? (index + 2) % 4 + 4 : (index + 2) % 4;
}

#endif
