/* gather: patches of a mesh in parts.
 *
 * A patch can have nodes of several processes. Every process therefore gathers the stars of the
 * nodes in patches, those of all processes, and all processes choose the same patches. The
 * owner of a patch's first node moves the patch; then all take the places. Without a mesh in parts
 * nothing here is called.
 *
 * All processes call a function at the same time, with the same arguments but for own elements. It
 * returns 0 if a process lacks memory or is not reached; the stage is to be undone then.
 *
 *   pl_gather_create, _destroy    the stars of this process
 *   pl_gather_begin               forget all stars
 *   pl_gather_elements            the elements of all processes, and stars for patches around them
 *   pl_gather_patches             the stars of the nodes in patches
 *   pl_gather_is_own              whether this process moves a patch
 *   pl_gather_places              take over what all processes have done to their patches
 */
#ifndef PL_IMPROVE_GATHER_H
#define PL_IMPROVE_GATHER_H

#include "improve/joint.h"

/** Stars gathered from all processes; its arrays are owned. */
typedef struct pl_gather {
    pl_joint *joint;       /* whose mesh is this one's once it is made */
    pl_joint_mesh local;   /* the plan's */
    uint8_t *movable;      /* [plan's n_nodes] by inner numbers: the node can be in a patch */
    int rank, n_processes; /* of those that have nodes; rank -1: this process has none */
    pl_stars stars;
    pl_star_slide *slide;                   /* [stars.n_stars] kind 0: the node may go anywhere */
    pl_star_guard guard;                    /* with bounds [n] of nodes with a star */
    double *lower, *upper, *start, *radius; /* those of guard */
    int64_t n;                              /* nodes of joint->mesh */
    int64_t room, star_room, ring_room, link_room;
    int32_t *place; /* [n_places] a hash table of nodes by number; -1: none. A power of two */
    int64_t n_places;
} pl_gather;

/** Make an empty gather and let joint have its mesh. Errors: _MEMORY. */
int pl_gather_create(pl_joint *joint, pl_gather *g, planish_error *error);

/** Free the arrays, and give joint its own mesh again. */
void pl_gather_destroy(pl_gather *g);

/** Forget all stars: coordinates may have changed. */
void pl_gather_begin(pl_gather *g);

/** List the elements of all processes that have a movable node: state [elements of the plan] PL_WORSE in
 *  this process' ones. *node [*n][dim + 1], for pl_joint_seed, is the caller's to free, also after
 *  a failure. */
int pl_gather_elements(pl_gather *g, const uint8_t *state, int32_t **node, int64_t *n);

/** Gather the stars of all nodes of n patches that lack them. */
int pl_gather_patches(pl_gather *g, const pl_joint_patch *patch, int64_t n);

/** Whether this process moves a patch. */
int pl_gather_is_own(const pl_gather *g, const pl_joint_patch *patch);

/** Take over the n patches that were moved by their owners, and the places of their nodes, in the plan's
 *  coordinates, too. */
int pl_gather_places(pl_gather *g, pl_joint_patch *const *patch, int64_t n);

#endif
