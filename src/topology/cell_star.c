/* cell_star: the tables are made from the corners of the shapes, as rings.c takes a corner apart. */
#include "topology/cell_star.h"

#include <string.h>

/** Corners of one kind of cells: nodes [element][place], by their places in the cell. */
typedef struct corner_nodes {
    int n_elements;
    uint8_t node[PL_CELL_CORNERS][4];
} corner_nodes;

static corner_nodes corners_of(const pl_cell_shape *shape) {
    corner_nodes of = {.n_elements = shape->n_simplices == 1 ? 1 : shape->n_measured};
    for (int e = 0; e < of.n_elements; e++) {
        of.node[e][0] = (uint8_t)e;
        for (int j = 0; j < shape->dim; j++)
            of.node[e][j + 1] = shape->n_simplices == 1 ? (uint8_t)(j + 1) : shape->neighbour[e][j];
    }
    return of;
}

/** Add a node to those of a star, if it is new. */
static void add_other(pl_cell_star *star, uint8_t other) {
    if (!memchr(star->other, other, star->n_others))
        star->other[star->n_others++] = other;
}

/** Add corner e of a cell, which has the node of the star at place. */
static void add_facet(int dim, int kind, const corner_nodes *of, int e, int place, int is_negative,
                      pl_cell_star *star) {
    const int turned = ((place + dim) % 2 != 0) != is_negative;
    for (int j = 0; j < dim; j++) {
        const uint8_t other = of->node[e][j + (j >= place)];
        add_other(star, other);
        star->facet[star->n_facets][pl_facet_corner(dim, j, turned)] = other;
    }
    star->corner[star->n_facets] = (uint8_t)e;
    star->form[star->n_facets++] = pl_form_code(pl_corner_code(kind, e), place, turned);
    if (dim == 3 && kind == PL_KIND_BRICK && place == 0)
        add_other(star, (uint8_t)pl_opposite_corner(e));
}

/** Twice the nodes of a closed link that a cell stands for. At a node inside, edges + cells = faces + 2
 *  (Euler), where two cells share each face, and a cell has as many faces as edges there, 3 but for the
 *  apex of a pyramid. A quadrilateral adds the node across it, a hexahedron the one across itself. In
 *  2-D there are as many edges as cells. */
static uint8_t twice_of(int dim, int kind) {
    static const uint8_t TWICE[2][PL_CELL_KINDS] = {{2, 4, 0, 0}, {1, 6, 3, 2}};
    return TWICE[dim - 2][kind];
}

static void make_kind(int dim, int index, pl_cell_kind *kind) {
    const pl_cell_shape *shape = pl_shape_of_kind(dim, index);
    const corner_nodes of = corners_of(shape);
    kind->n_nodes = shape->n_corners;
    kind->twice = twice_of(dim, index);
    for (int e = of.n_elements; e-- > 0;)
        for (int place = dim; place >= 0; place--) /* the first of them in the end */
            kind->at[of.node[e][place]] = (uint8_t)(e * (dim + 1) + place);
    for (int e = 0; e < of.n_elements; e++)
        for (int place = 0; place <= dim; place++)
            for (int is_negative = 0; is_negative < 2; is_negative++)
                add_facet(dim, index, &of, e, place, is_negative,
                          &kind->star[is_negative][of.node[e][place]]);
}

void pl_cell_kinds_make(int dim, pl_cell_kind kind[PL_CELL_KINDS]) {
    memset(kind, 0, PL_CELL_KINDS * sizeof *kind);
    for (int i = 0; i < PL_CELL_KINDS; i++)
        if (pl_shape_of_kind(dim, i))
            make_kind(dim, i, &kind[i]);
}

int pl_cell_facets(const pl_cell_kind *kinds, const uint8_t *corner, const int32_t *elements,
                   int dim, int64_t first, int32_t node) {
    const pl_cell_kind *kind = pl_cell_kind_of(kinds, corner, first);
    int32_t nodes[PL_CELL_CORNERS];
    if (pl_corner_kind(corner[first]) != PL_KIND_PYRAMID) /* the same at all nodes */
        return kind->star[0][0].n_facets;
    pl_cell_nodes(kind, elements + first * (dim + 1), nodes);
    return kind->star[0][pl_cell_place(kind, nodes, node)].n_facets;
}

int pl_cell_facet_elements(const pl_cell_kind *kinds, const uint8_t *corner,
                           const int32_t *elements, int dim, int64_t first, int32_t node,
                           int32_t *element) {
    const pl_cell_kind *kind = pl_cell_kind_of(kinds, corner, first);
    int32_t nodes[PL_CELL_CORNERS];
    pl_cell_nodes(kind, elements + first * (dim + 1), nodes);
    const pl_cell_star *star = &kind->star[0][pl_cell_place(kind, nodes, node)];
    for (int f = 0; f < star->n_facets; f++)
        element[f] = (int32_t)first + star->corner[f];
    return star->n_facets;
}
