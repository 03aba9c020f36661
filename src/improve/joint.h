/* joint: the nodes of a small patch move at once, so that the worst element around them becomes better.
 *
 * A patch has some movable nodes around a bad element, and all elements that touch these. A step solves
 * a small max-min problem (maxmin.h): raise the least measure of the elements, linearised where the nodes
 * are, within a radius. It is kept if the true measures are better: the least one has risen by a part
 * of the promise, every element is positive beyond doubt of rounding, no limit is exceeded, and
 * watched cells stay valid. Where the step is blocked the patch grows by the nodes of the elements
 * that block it; a patch that neither gains nor grows is at its limit.
 *
 * Patches without a common cell may be worked on at the same time. The coordinates are the plan's; of a
 * mesh in parts they are those that the processes have gathered (gather.h).
 *
 *   here               what patches are made of, and their state
 *   joint_create.h     pl_joint_create, _destroy     input of all patches of a run, memory for them
 *   joint_measures.h   pl_joint_value, _value_of     measures of elements, and their limits
 *   joint_patch.h      pl_joint_seed, _compare       a patch around an element; elements at their limits
 *   joint_steps.h      pl_joint_improve              steps of a patch
 */
#ifndef PL_IMPROVE_JOINT_H
#define PL_IMPROVE_JOINT_H

#include "sweep/run.h"

/** Most nodes of a patch. */
enum { PL_JOINT_NODES = 20 };

/* Elements at their limits may lose this part of their measure to others, unless they are the worst of
 * all. */
#define PL_JOINT_LOSS 1e-3

/** Multiplications of a problem's solution that take as long as one evaluation of an element. */
enum { PL_JOINT_MULTIPLICATIONS = 400 };

struct pl_joint_room;

/** Nodes and stars that patches are made of: those of the plan, by inner numbers; or of a mesh in parts
 *  those that have been gathered. Stars of the interior and those that slide may be one array. */
typedef struct pl_joint_mesh {
    double *coordinates;      /* [n][dim] */
    int32_t *star_of;         /* [n] number of a star of the interior; -2 - that of one that slides;
                                  PL_JOINT_HELD, PL_JOINT_ELSEWHERE */
    int64_t *number;          /* [n] numbers of the nodes in the whole mesh, the caller's */
    int32_t *moved, *near;    /* [n] round in which a node is in a patch, or a neighbour */
    const pl_stars *stars[2]; /* the interior; those that slide */
    const pl_star_slide *slide; /* [stars of stars[1]] */
    pl_star_problem problem;    /* storage and bounds of nodes */
} pl_joint_mesh;

enum {
    PL_JOINT_HELD = -1,            /* the node cannot be in a patch */
    PL_JOINT_ELSEWHERE = INT32_MIN /* it can, but the star is not gathered */
};

/** The star of a node. */
typedef struct pl_joint_star {
    const pl_stars *stars;
    int64_t at;                 /* number in stars */
    const pl_star_slide *slide; /* NULL: the node may go anywhere */
} pl_joint_star;

/** Input of all patches. Limits of measures are of values that are larger the better an element is
 *  (geometry/slope.h). */
typedef struct pl_joint {
    pl_run *run;
    pl_joint_mesh mesh; /* its arrays are owned, unless the mesh is in parts */
    double wanted;      /* of the measure that is raised: patches stop when they have reached it */
    double least;       /* of that measure, in the mesh: no element shall fall below */
    double largest_angle; /* of simplices whose angles are raised: none shall become larger */
    double most_of_cell;  /* with corners: AR^2 above which no cell shall get */
    double kept[2]; /* of the other measure: none shall fall below [0], or where that is in the way,
                         below [1] */
    struct pl_joint_pinned *pinned; /* [n_pinned] ascending by nodes, the caller's */
    int64_t n_pinned;
    int leaves_nodes;           /* some nodes that can move cannot be in patches */
    struct pl_joint_room *room; /* [threads] owned */
} pl_joint;

/** An element at its limit. */
typedef struct pl_joint_pinned {
    int64_t node[4]; /* numbers in the whole mesh, ascending; in 2-D the last one is 0 */
    double value;    /* of its measure then */
} pl_joint_pinned;

/** An element, by the numbers of its vertices in pl_joint_mesh. */
typedef struct pl_joint_element {
    int32_t node[4]; /* of a link facet, then the star's */
    uint8_t form;    /* code of the corner; 0: a simplex */
    int64_t facet;   /* place of the facet in the stars */
} pl_joint_element;

/** State of a patch. */
typedef enum pl_joint_state {
    PL_JOINT_OPEN,   /* worth another try */
    PL_JOINT_DONE,   /* its element has the wanted measure */
    PL_JOINT_PINNED, /* at its limit */
} pl_joint_state;

/** A patch around an element. */
typedef struct pl_joint_patch {
    pl_joint_element seed;
    pl_joint_pinned of; /* the same element, for comparisons */
    double value;       /* of the element */
    pl_joint_state state;
    int is_loose; /* kept[1] holds, not [0] */
    int n;
    int32_t node[PL_JOINT_NODES];
    int has_moved; /* in the last try, */
    int64_t work;  /* and the work of it: evaluations of an element's measures */
} pl_joint_patch;

/** Return the coordinates [dim] of a node. */
static inline double *pl_joint_place(const pl_joint *joint, int32_t node) {
    return joint->mesh.coordinates + (int64_t)node * joint->run->plan->dim;
}

/** Return the star of a node that can be in a patch, and is gathered. */
static inline pl_joint_star pl_joint_star_of(const pl_joint *joint, int32_t node) {
    const int32_t star = joint->mesh.star_of[node];
    if (star >= 0)
        return (pl_joint_star){joint->mesh.stars[0], star, NULL};
    return (pl_joint_star){joint->mesh.stars[1], -2 - star, &joint->mesh.slide[-2 - star]};
}

#endif
