/* parts: faces and edges of elements by their corners, in VTK's order.
 *
 *   io_parts, io_parts_of, io_part_corners    parts of an element
 *   io_part_nodes                             all nodes of a part
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

/** Find the nodes, in VTK's order, of a part of an element of that many corners, which has those whose
 *  bits are set: the bits of these, of the mids of edges both of whose ends it has, and of the middle of
 *  the face. The element may have fewer nodes. */
static inline uint32_t io_part_nodes(const io_parts *parts, int corners, uint32_t has) {
    const uint32_t one = 1;
    uint32_t nodes = has;
    for (int e = 0; e < parts->n_edges; e++)
        if ((has >> parts->edge[e][0] & 1) && (has >> parts->edge[e][1] & 1))
            nodes |= one << (corners + e);
    for (int f = 0; f < parts->n_faces; f++) {
        uint32_t face = 0;
        for (int i = 0; i < io_part_corners(parts, f); i++)
            face |= one << parts->face[f][i];
        if (face == has && parts->middle[f] >= 0)
            nodes |= one << (corners + parts->n_edges + parts->middle[f]);
    }
    if (parts->n_faces == 0 && has == (one << corners) - 1) /* a flat element is its only face */
        nodes |= one << (corners + parts->n_edges);
    return nodes;
}

#endif
