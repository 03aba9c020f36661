/* joint_patch: the patch of a thread, with its elements and its problem. */
#ifndef PL_IMPROVE_JOINT_PATCH_H
#define PL_IMPROVE_JOINT_PATCH_H

#include "improve/joint.h"
#include "improve/maxmin.h"

enum {
    PL_JOINT_ELEMENTS = 1000, /* of a patch, at most */
    PL_JOINT_ROWS = 1000,
    PL_JOINT_VARIABLES = 3 * PL_JOINT_NODES
};

/** Node of a patch. */
typedef struct pl_joint_node {
    int32_t node;
    const pl_star_slide *slide; /* NULL: it may go anywhere */
    int n, first;               /* variables */
    double direction[3][3];     /* [n] of unit length */
    double scale;               /* root mean square distance of the ring */
} pl_joint_node;

/** Element of a patch. */
typedef struct pl_joint_member {
    pl_joint_element of;
    int8_t own[4];     /* places of its vertices in the patch, -1: not in it */
    uint8_t is_pinned; /* not raised, only kept */
    double least;      /* where it is pinned, of the measure that is raised: limit */
    double floor;      /* D that it shall not fall below */
} pl_joint_member;

/** Room of a thread: the patch under way. */
typedef struct pl_joint_room {
    pl_joint_node node[PL_JOINT_NODES];
    pl_joint_member element[PL_JOINT_ELEMENTS];
    int n_nodes, n_elements, n_variables;
    int64_t work; /* of the try: evaluations of elements */
    double kept;  /* limit of the other measure */
    double cell;  /* limit of AR^2 of cells */
    pl_maxmin_row row[PL_JOINT_ROWS];
    int element_of[PL_JOINT_ROWS];
    pl_maxmin problem;
    double x[PL_JOINT_VARIABLES], multiplier[PL_JOINT_VARIABLES + 1];
    int active[PL_JOINT_VARIABLES + 1];
    double room[PL_MAXMIN_ROOM(PL_JOINT_VARIABLES)];
} pl_joint_room;

/** Compare the nodes of two elements a and b that are at their limits (pl_joint_pinned), for qsort. */
int pl_joint_compare(const void *a, const void *b);

/** Set patch to one of the movable nodes of the element with vertices node [dim + 1]; the star of the
 *  first movable one is gathered. Return 0 if there is none to be made: no node can be in one, its
 *  measure is not below wanted, or the element is pinned. */
int pl_joint_seed(const pl_joint *joint, const int32_t *node, pl_joint_patch *patch);

/** Write the movable nodes of an element to node; return how many. */
int pl_joint_movable_nodes(const pl_joint *joint, const pl_joint_element *e, int32_t node[4]);

/** Gather the patch in w; return 0 if it has too many elements. */
int pl_joint_gather(const pl_joint *joint, const pl_joint_patch *p, pl_joint_room *w);

/** Judge the elements before the first step: which are pinned, and that limits are not exceeded
 *  already. Return the least measure of the others. */
double pl_joint_judge(const pl_joint *joint, pl_joint_room *w);

#endif
