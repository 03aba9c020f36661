/* random_meshes: small meshes of all kinds, drawn at random: good, bad, torn and tangled ones. */
#ifndef TEST_SUPPORT_RANDOM_MESHES_H
#define TEST_SUPPORT_RANDOM_MESHES_H

#include "support/meshes.h"

/** What it is made from. All have coordinates in [0, 1], and positive elements but TEST_GARBAGE. */
typedef enum random_shape {
    RANDOM_DELAUNAY,  /* of random points, some on the sides */
    RANDOM_GRADED,    /* of points that crowd in a corner */
    RANDOM_LATTICE,   /* Delaunay of a coarse lattice, then shaken: slivers */
    RANDOM_BOX,       /* structured, and shaken */
    RANDOM_STRETCHED, /* Delaunay, flat in one direction */
    RANDOM_SPOILED,   /* Delaunay, with elements that nearly are none */
    RANDOM_ONE,       /* one element, or those around a node */
    RANDOM_GARBAGE    /* elements of any nodes */
} random_shape;

typedef enum random_cut { RANDOM_WHOLE, RANDOM_CAVITY, RANDOM_HOLES } random_cut;

/** Whether there is another mesh beside it: apart, or with a node or (3-D) an edge in common, or
 *  with an inner node in common. */
typedef enum random_parts {
    RANDOM_ALONE,
    RANDOM_APART,
    RANDOM_AT_NODE,
    RANDOM_AT_EDGE,
    RANDOM_AT_INNER_NODE
} random_parts;

/** What is too much: elements twice, or three at a facet. */
typedef enum random_extra { RANDOM_NOTHING, RANDOM_DUPLICATES, RANDOM_THIRDS } random_extra;

/** The order of the elements' nodes. */
typedef enum random_order { RANDOM_POSITIVE, RANDOM_MIXED, RANDOM_NEGATIVE } random_order;

typedef enum random_tangle {
    RANDOM_VALID,
    RANDOM_MOVED_FEW,
    RANDOM_MOVED_MANY,
    RANDOM_COLLAPSED, /* nodes at the place of a neighbour */
    RANDOM_SWAPPED,   /* nodes in the place of one another */
    RANDOM_THROWN,    /* one node far away */
    RANDOM_ALL_IN_ONE /* all at one place */
} random_tangle;

typedef enum random_place {
    RANDOM_UNIT,
    RANDOM_ROTATED,
    RANDOM_FAR,  /* 10^6 sizes from the origin */
    RANDOM_TINY, /* 2^-100 */
    RANDOM_HUGE  /* 1e30 */
} random_place;

typedef struct random_choice {
    int dim;
    random_shape shape;
    random_cut cut;
    random_parts parts;
    random_extra extra;
    random_order order;
    random_tangle tangle;
    random_place place;
    int is_periodic; /* opposite sides have the same nodes, which are pairs */
    int n_points;    /* about as many */
} random_choice;

typedef struct random_mesh {
    test_mesh base;
    double size; /* of the box */
    int64_t n_periodic;
    int32_t *periodic; /* [n_periodic][2], owned */
} random_mesh;

void random_mesh_create(random_mesh *mesh, const random_choice *choice, uint64_t *state);
void random_mesh_destroy(random_mesh *mesh);

/** Round coordinates to floats. */
void random_mesh_to_floats(random_mesh *mesh);

#endif
