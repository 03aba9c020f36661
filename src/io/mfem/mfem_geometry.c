/* mfem_geometry: geometries of elements, and the orders of their nodes. */
#include "io/mfem/mfem_reader.h"

/* MFEM's geometries, with edges and faces in MFEM's order (fem/geom.cpp); those of a square in three
 * dimensions are a face, whose middle is the inside. */
const mfem_geometry mfem_geometries[MFEM_N_GEOMETRIES] = {
    {IO_POINT, 0, 1, 0, 0, 0, {{0}}, {{0}}},
    {IO_LINE, 1, 2, 1, 0, 0, {{0, 1}}, {{0}}},
    {IO_TRIANGLE, 2, 3, 3, 0, 0, {{0, 1}, {1, 2}, {2, 0}}, {{0}}},
    {IO_QUADRILATERAL, 2, 4, 4, 0, 1, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, {{0}}},
    {IO_TETRAHEDRON, 3, 4, 6, 0, 0, {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}, {{0}}},
    {IO_HEXAHEDRON,
     3,
     8,
     12,
     6,
     1,
     {{0, 1},
      {1, 2},
      {3, 2},
      {0, 3},
      {4, 5},
      {5, 6},
      {7, 6},
      {4, 7},
      {0, 4},
      {1, 5},
      {2, 6},
      {3, 7}},
     {{3, 2, 1, 0}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}, {4, 5, 6, 7}}},
    {IO_PRISM,
     3,
     6,
     9,
     3,
     0,
     {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
     {{0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
    {IO_PYRAMID,
     3,
     5,
     8,
     1,
     0,
     {{0, 1}, {1, 2}, {3, 2}, {0, 3}, {0, 4}, {1, 4}, {2, 4}, {3, 4}},
     {{3, 2, 1, 0}}}};

const io_node_order mfem_node_orders[] = {
    {PLANISH_CELL_TETRAHEDRON10, {0, 1, 2, 3, 4, 7, 5, 6, 8, 9}},
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13,
                                 14, 15, 16, 17, 18, 19, 24, 22, 21, 23, 20, 25, 26}},
    {0, {0}}};

int mfem_count_nodes(const mfem_geometry *g, int order) {
    return order == 1 ? g->corners : g->corners + g->n_edges + g->n_quadrilaterals + g->n_inside;
}
