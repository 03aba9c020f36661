/* fit: the surface of a mesh is brought onto a shape that is not its own.
 *
 * Each node of the boundary has a place on the other shape: on a patch, on a curve if it is itself
 * on one, or at a corner. It goes there straight, by the largest step that keeps its elements
 * valid. Smoothing between these rounds is done elsewhere.
 *
 *   create.h     pl_fit_create, _destroy      the nodes, and the elements around them
 *   pieces.h     pl_fit_find_pieces           what the outside of a shape consists of
 *   hollows.h    pl_fit_turn_hollows          which of these lie in others
 *   partners.h   pl_fit_find_partners         which piece is for which
 *   sides.h      pl_fit_are_alike             features by what they bound
 *   places.h     pl_fit_find_places           the other shape's places of the nodes
 *                pl_fit_project               the place near a point
 *                pl_fit_is_place              whether a point is one
 *   move.h       pl_fit_round                 a step of all nodes, and then of each
 *                pl_fit_arrive, pl_fit_stay   which nodes are at their places
 *   distance.h   pl_fit_measure               how far the surfaces are apart, both ways
 */
#ifndef PL_FIT_FIT_H
#define PL_FIT_FIT_H

#include "base/round.h"
#include "quality/validity.h"
#include "shape/curved.h"
#include "shape/tree.h"
#include "topology/points.h"

/** A node of the surface is one of these. */
enum {
    PL_FIT_INSIDE = 0, /* it is at no facet of the boundary */
    PL_FIT_HELD = 1,   /* the caller holds it, or an element of it does */
    PL_FIT_FAR = 2,    /* the other shape is out of its reach */
    PL_FIT_PLACED = 3, /* it has a place */
    PL_FIT_UNCLEAR = 4 /* it has one where other nodes have theirs, too */
};

enum { PL_FIT_TYPES = 4 /* of solids */ };

/** An element with a node that has a place. */
typedef struct pl_fit_element {
    int32_t node[PL_CELL_CORNERS]; /* the mesh's */
    int8_t sign;
    uint8_t type; /* number of its rule */
} pl_fit_element;

/** Pieces of the outside of a shape. Arrays are owned. */
typedef struct pl_fit_pieces {
    int32_t n;
    int32_t *of;        /* [facets] piece of each; -1: it is not of the outside */
    int32_t *first;     /* [n] its lowest facet */
    uint8_t *is_closed; /* [n] 1: it has a border nowhere */
    int8_t *outward; /* [n] -1: its facets turn into the room that it encloses, if it is closed */
    int8_t *turn;    /* [n] -1: they turn into the body, if it is closed */
    int32_t *nest;   /* [n] the outermost of closed ones in one another; -1: it is by itself */
    double *area;    /* [n] */
    pl_box3 *box;    /* [n] */
} pl_fit_pieces;

/** A fit. Nodes have the numbers of the mesh's own shape, which is not owned, nor is the other one.
 *  Lengths are in the unit of the other shape unless it says otherwise. Arrays are owned. */
struct planish_fit {
    const planish_shape *own, *onto;
    int64_t n_nodes; /* of own */
    int threads;
    double reach;       /* in mean edges of a node */
    double to_own;      /* from onto's unit to that of own */
    pl_storage storage; /* of what a node is moved to */
    uint8_t *state;     /* [n_nodes] PL_FIT_.. */
    uint8_t *kind;      /* [n_nodes] PL_ON_PATCH, PL_ON_CURVE, PL_CORNER of the other shape */
    uint8_t *
        is_cut; /* [n_nodes] 1: a corner of three bends or more, and none of those in reach is for it */
    uint8_t *slides;        /* [n_nodes] 1: it moves along the other shape when it is there */
    uint8_t *is_there;      /* [n_nodes] 1: it has come to its place */
    pl_place *place;        /* [n_nodes] of a corner at is its node */
    double (*goal)[3];      /* [n_nodes] the place, in the mesh's units */
    double (*direction)[3]; /* [n_nodes] normal there, out of the mesh; or tangent */
    pl_fit_pieces pieces;   /* of onto */
    pl_fit_pieces own_pieces;
    int32_t *piece_of; /* [n_nodes] of own; -1: none */
    int8_t *side;      /* [pieces] -1: closed ones, as turn says, have the mesh outside */
    int32_t *partner;  /* [own_pieces] the piece of onto for each; -1: it may use all */
    uint8_t *is_taken; /* [pieces] 1: it is the partner of one; 2: of several */
    double *covered;   /* [pieces] area of the facets of those there */
    int64_t n_unused;  /* pieces where no node has a place */
    int8_t *turn;      /* [patches of onto] -1: its facets turn into the mesh */
    int64_t n_turns;
    uint8_t *is_corner;             /* [nodes of onto] 1: curves end there */
    pl_tree facets, edges, corners; /* of onto */
    int64_t n_elements;
    pl_fit_element *element;
    double *least;       /* [n_elements] least det J of a corner; 0 or less: it is not valid */
    int64_t *offset;     /* [n_nodes + 1] */
    int32_t *element_of; /* elements of each node */
    int n_rules;
    pl_jacobian_rule *rule[PL_FIT_TYPES];
    pl_jacobian_block **block; /* [threads] room */
    /* Of a round: */
    double (*from)[3];  /* [n_nodes] where it began, in the mesh's units */
    double *part;       /* [n_nodes] of its way that a node goes */
    double *cosine;     /* [n_nodes] least between its facets and direction */
    uint8_t *is_marked; /* [n_nodes] */
};

/** Set x to where a node is, times scale. */
static inline void pl_fit_at(const pl_points *points, int64_t node, double scale, double x[3]) {
    for (int d = 0; d < 3; d++)
        x[d] = points->x[pl_point_at(points, node, d)] * scale;
}

/** Whether a facet of the mesh's surface is of its boundary. */
static inline int pl_fit_is_outer(const planish_shape *shape, int32_t facet) {
    return !shape->is_interface[facet];
}

#endif
