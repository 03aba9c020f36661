/* cell: the table of types. Orders of nodes: VTK's vtkCellType.h and the classes named there; of
 * PYRAMID14, that of Gmsh with the middle of the base last. */
#include "geometry/cell.h"
#include "planish/planish.h"

#include <stddef.h>

static const pl_cell_shape TRIANGLE = {
    .name = "triangle",
    .dim = 2,
    .n_corners = 3,
    .n_measured = 3,
    .n_edges = 3,
    .n_facets = 3,
    .n_simplices = 1,
    .n_vertices = {3},
    .vertex = {{0}, {1}, {2}},
    .edge = {{0, 1}, {1, 2}, {2, 0}},
    .facet = {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 0, -1, -1}},
    .neighbour = {{1, 2}, {2, 0}, {0, 1}},
    .to_corner = {2.0 / 3, 2.0 / 3},
    .between = {2.0 / 3},
    .determinant = 0.8660254037844386,
};

static const pl_cell_shape QUADRILATERAL = {
    .name = "quadrilateral",
    .dim = 2,
    .n_corners = 4,
    .n_measured = 4,
    .n_edges = 4,
    .n_facets = 4,
    .n_simplices = 2,
    .n_vertices = {2, 2},
    .vertex = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
    .edge = {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
    .facet = {{0, 1, -1, -1}, {1, 2, -1, -1}, {2, 3, -1, -1}, {3, 0, -1, -1}},
    .neighbour = {{1, 3}, {2, 0}, {3, 1}, {0, 2}},
    .to_corner = {1, 1},
    .determinant = 1,
};

static const pl_cell_shape TETRAHEDRON = {
    .name = "tetrahedron",
    .dim = 3,
    .n_corners = 4,
    .n_measured = 4,
    .n_edges = 6,
    .n_facets = 4,
    .n_simplices = 1,
    .n_vertices = {4},
    .vertex = {{0}, {1}, {2}, {3}},
    .edge = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}},
    .facet = {{0, 2, 1, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {0, 3, 2, -1}},
    .neighbour = {{1, 2, 3}, {2, 0, 3}, {0, 1, 3}, {0, 2, 1}},
    .to_corner = {0.5, 0.5, 0.5},
    .between = {0.5, 0.5, 0.5},
    .determinant = 0.7071067811865476,
};

static const pl_cell_shape HEXAHEDRON = {
    .name = "hexahedron",
    .dim = 3,
    .n_corners = 8,
    .n_measured = 8,
    .n_edges = 12,
    .n_facets = 6,
    .n_simplices = 3,
    .n_vertices = {2, 2, 2},
    .vertex =
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}},
    .edge = {{0, 1},
             {1, 2},
             {2, 3},
             {3, 0},
             {4, 5},
             {5, 6},
             {6, 7},
             {7, 4},
             {0, 4},
             {1, 5},
             {2, 6},
             {3, 7}},
    .facet = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}},
    .neighbour =
        {{1, 3, 4}, {2, 0, 5}, {3, 1, 6}, {0, 2, 7}, {7, 5, 0}, {4, 6, 1}, {5, 7, 2}, {6, 4, 3}},
    .to_corner = {1, 1, 1},
    .determinant = 1,
};

static const pl_cell_shape WEDGE = {
    .name = "wedge",
    .dim = 3,
    .n_corners = 6,
    .n_measured = 6,
    .n_edges = 9,
    .n_facets = 5,
    .n_simplices = 2,
    .n_vertices = {3, 2},
    .vertex = {{0, 0}, {1, 0}, {2, 0}, {0, 1}, {1, 1}, {2, 1}},
    .edge = {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
    .facet = {{0, 2, 1, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}},
    .neighbour = {{1, 2, 3}, {2, 0, 4}, {0, 1, 5}, {5, 4, 0}, {3, 5, 1}, {4, 3, 2}},
    .to_corner = {2.0 / 3, 2.0 / 3, 1},
    .between = {2.0 / 3, 0, 0},
    .determinant = 0.8660254037844386,
};

static const pl_cell_shape PYRAMID = {
    .name = "pyramid",
    .dim = 3,
    .n_corners = 5,
    .n_measured = 4,
    .n_edges = 8,
    .n_facets = 5,
    .edge = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}},
    .facet = {{0, 3, 2, 1}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}},
    .neighbour = {{1, 3, 4}, {2, 0, 4}, {3, 1, 4}, {0, 2, 4}},
    .to_corner = {1, 1, 0},
    .between = {-0.5, 1, 1},
    .determinant = 0.7071067811865476,
};

static const uint8_t CORNERS[][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3},
                                     {4, 4}, {5, 5}, {6, 6}, {7, 7}};
static const uint8_t TRIANGLE6[][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};
static const uint8_t QUADRILATERAL9[][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1},
                                            {1, 2}, {2, 3}, {3, 0}, {0, 2}};
static const uint8_t TETRAHEDRON10[][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {0, 1},
                                           {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
static const uint8_t HEXAHEDRON27[][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}, {6, 6},
                                          {7, 7}, {0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                          {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}, {0, 7},
                                          {1, 6}, {0, 5}, {3, 6}, {0, 2}, {4, 6}, {0, 6}};
static const uint8_t WEDGE18[][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5},
                                     {0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3},
                                     {0, 3}, {1, 4}, {2, 5}, {0, 4}, {1, 5}, {2, 3}};
static const uint8_t PYRAMID14[][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {0, 1}, {1, 2},
                                       {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}, {0, 2}};

/* By their numbers. */
static const pl_cell_type TYPES[] = {
    [PLANISH_CELL_TRIANGLE] = {&TRIANGLE, PLANISH_CELL_TRIANGLE, 1, 3, CORNERS, "triangles"},
    [PLANISH_CELL_TRIANGLE6] = {&TRIANGLE, PLANISH_CELL_TRIANGLE6, 2, 6, TRIANGLE6,
                                "quadratic triangles"},
    [PLANISH_CELL_QUADRILATERAL] = {&QUADRILATERAL, PLANISH_CELL_QUADRILATERAL, 1, 4, CORNERS,
                                    "quadrilaterals"},
    [PLANISH_CELL_QUADRILATERAL8] = {&QUADRILATERAL, PLANISH_CELL_QUADRILATERAL8, 2, 8,
                                     QUADRILATERAL9, "quadratic quadrilaterals"},
    [PLANISH_CELL_QUADRILATERAL9] = {&QUADRILATERAL, PLANISH_CELL_QUADRILATERAL9, 2, 9,
                                     QUADRILATERAL9, "biquadratic quadrilaterals"},
    [PLANISH_CELL_TETRAHEDRON] = {&TETRAHEDRON, PLANISH_CELL_TETRAHEDRON, 1, 4, CORNERS,
                                  "tetrahedra"},
    [PLANISH_CELL_TETRAHEDRON10] = {&TETRAHEDRON, PLANISH_CELL_TETRAHEDRON10, 2, 10, TETRAHEDRON10,
                                    "quadratic tetrahedra"},
    [PLANISH_CELL_HEXAHEDRON] = {&HEXAHEDRON, PLANISH_CELL_HEXAHEDRON, 1, 8, CORNERS, "hexahedra"},
    [PLANISH_CELL_HEXAHEDRON20] = {&HEXAHEDRON, PLANISH_CELL_HEXAHEDRON20, 2, 20, HEXAHEDRON27,
                                   "quadratic hexahedra"},
    [PLANISH_CELL_HEXAHEDRON27] = {&HEXAHEDRON, PLANISH_CELL_HEXAHEDRON27, 2, 27, HEXAHEDRON27,
                                   "triquadratic hexahedra"},
    [PLANISH_CELL_WEDGE] = {&WEDGE, PLANISH_CELL_WEDGE, 1, 6, CORNERS, "wedges"},
    [PLANISH_CELL_WEDGE15] = {&WEDGE, PLANISH_CELL_WEDGE15, 2, 15, WEDGE18, "quadratic wedges"},
    [PLANISH_CELL_WEDGE18] = {&WEDGE, PLANISH_CELL_WEDGE18, 2, 18, WEDGE18, "biquadratic wedges"},
    [PLANISH_CELL_PYRAMID] = {&PYRAMID, PLANISH_CELL_PYRAMID, 1, 5, CORNERS, "pyramids"},
    [PLANISH_CELL_PYRAMID13] = {&PYRAMID, PLANISH_CELL_PYRAMID13, 2, 13, PYRAMID14,
                                "quadratic pyramids"},
    [PLANISH_CELL_PYRAMID14] = {&PYRAMID, PLANISH_CELL_PYRAMID14, 2, 14, PYRAMID14,
                                "biquadratic pyramids"},
};

const pl_cell_type *pl_cell_type_of(int type) {
    enum { N = sizeof TYPES / sizeof *TYPES };
    return type >= 0 && type < N && TYPES[type].shape ? &TYPES[type] : NULL;
}

/** Whether a list of n corners (-1: none) has corner. */
static int has_corner(const int8_t *list, int n, int corner) {
    int found = 0;
    for (int i = 0; i < n; i++)
        found |= list[i] == corner;
    return found;
}

uint8_t pl_cell_parents(const pl_cell_type *type, int node) {
    const pl_cell_shape *shape = type->shape;
    const int a = type->between[node][0], b = type->between[node][1];
    const uint8_t ends = (uint8_t)(1 << a | 1 << b);
    if (a == b)
        return ends;
    for (int e = 0; e < shape->n_edges; e++)
        if ((1 << shape->edge[e][0] | 1 << shape->edge[e][1]) == ends)
            return ends;
    for (int f = 0; f < shape->n_facets && shape->dim == 3; f++) {
        uint8_t corners = 0;
        if (!has_corner(shape->facet[f], 4, a) || !has_corner(shape->facet[f], 4, b))
            continue;
        for (int i = 0; i < 4 && shape->facet[f][i] >= 0; i++)
            corners |= (uint8_t)(1 << shape->facet[f][i]);
        return corners;
    }
    return (uint8_t)((1 << shape->n_corners) - 1);
}
