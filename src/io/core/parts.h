/* parts: faces and edges of elements by their corners, in VTK's order.
 *
 *   io_parts, io_parts_of, io_part_corners    parts of an element
 */
#ifndef PL_IO_CORE_PARTS_H
#define PL_IO_CORE_PARTS_H

#include <stdint.h>

/** Faces, of 3 or 4 corners, and edges of an element; of flat elements edges alone. The mid of edge i,
 *  where there are mids, is node i behind the corners (VTK). */
typedef struct io_parts {
    int n_faces, n_edges;
    int8_t face[6][4]; /* -1: none */
    int8_t edge[12][2];
    int8_t middle[6]; /* of face i, where faces have nodes: which node behind the mids; -1: none */
} io_parts;

/** Return the parts of an element of that many corners in that dimension, 2 or 3. */
static inline const io_parts *io_parts_of(int dim, int corners) {
    static const io_parts triangle = {0, 3, {{0}}, {{0, 1}, {1, 2}, {2, 0}}, {0}},
                          quadrilateral = {0, 4, {{0}}, {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, {0}};
    static const io_parts tetrahedron = {
        4,
        6,
        {{0, 1, 2, -1}, {0, 1, 3, -1}, {1, 2, 3, -1}, {2, 0, 3, -1}},
        {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}},
        {-1, -1, -1, -1}};
    static const io_parts pyramid = {
        5,
        8,
        {{0, 1, 2, 3}, {0, 1, 4, -1}, {1, 2, 4, -1}, {2, 3, 4, -1}, {3, 0, 4, -1}},
        {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {0, 4}, {1, 4}, {2, 4}, {3, 4}},
        {0, -1, -1, -1, -1}};
    static const io_parts wedge = {
        5,
        9,
        {{0, 1, 2, -1}, {3, 4, 5, -1}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}},
        {{0, 1}, {1, 2}, {2, 0}, {3, 4}, {4, 5}, {5, 3}, {0, 3}, {1, 4}, {2, 5}},
        {-1, -1, 0, 1, 2}};
    static const io_parts hexahedron = {
        6,
        12,
        {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}},
        {{0, 1},
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
        {4, 5, 2, 1, 3, 0}};
    if (dim == 2)
        return corners == 3 ? &triangle : &quadrilateral;
    return corners == 4   ? &tetrahedron
           : corners == 5 ? &pyramid
           : corners == 6 ? &wedge
                          : &hexahedron;
}

/** Return the number of corners of a face. */
static inline int io_part_corners(const io_parts *parts, int face) {
    return parts->face[face][3] < 0 ? 3 : 4;
}

#endif
