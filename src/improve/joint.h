/* joint: the nodes of a small patch move at once, so that the worst element around them becomes better.
 *
 * A patch has some movable nodes around a bad element, and all elements that touch these. A step solves
 * a small max-min problem (maxmin.h): raise the least measure of the elements, linearised where the nodes
 * are, within a radius. It is taken where the true measures say so: the least one has risen by a part
 * of the promise, every element is positive beyond doubt of rounding, no limit is exceeded, and
 * watched cells stay valid. Where the step is blocked the patch grows by the nodes of the elements
 * that block it; a patch that neither gains nor grows is at its limit.
 *
 * Patches without a common cell may be worked on at the same time. The coordinates are the plan's.
 *
 *   pl_joint_create, _destroy     input of all patches of a run, memory for them
 *   pl_joint_value_of             a square limit of the run as a value of measures
 *   pl_joint_seed                 a patch around an element
 *   pl_joint_value                the least measure of an element
 *   pl_joint_pin, _compare        elements at their limits
 *   pl_joint_visits               the star of a node
 *   pl_joint_improve              steps of a patch
 */
#ifndef PL_IMPROVE_JOINT_H
#define PL_IMPROVE_JOINT_H

#include "sweep/run.h"

/** Most nodes of a patch. */
enum { PL_JOINT_NODES = 20 };

/* Elements at their limits may lose this part of their measure to others, unless they are the worst of
 * all. */
#define PL_JOINT_LOSS 1e-3

struct pl_joint_room;

/** Input of all patches. Limits of measures are of values that are larger the better an element is
 *  (geometry/slope.h). */
typedef struct pl_joint {
    pl_run *run;
    int32_t
        *star_of; /* [n_nodes + n_images] by inner numbers: star of the interior; -2 - star of those
                         that slide; PL_JOINT_HELD. Owned */
    double wanted; /* of the measure that is raised: patches stop when they have reached it */
    double least;  /* of that measure, in the mesh: no element shall fall below */
    double largest_angle; /* of simplices whose angles are raised: none shall become larger */
    double kept[2]; /* of the other measure: none shall fall below [0], or where that is in the way,
                         below [1] */
    struct pl_joint_pinned *pinned; /* [n_pinned] ascending by nodes, the caller's */
    int64_t n_pinned;
    struct pl_joint_room *room; /* [threads] owned */
} pl_joint;

/** An element at its limit. */
typedef struct pl_joint_pinned {
    int32_t node[4]; /* ascending; in 2-D the last one is 0 */
    double value;    /* of its measure then */
} pl_joint_pinned;

enum { PL_JOINT_HELD = -1 };

/** An element, by the inner numbers of its vertices. */
typedef struct pl_joint_element {
    int32_t node[4]; /* of a link facet, then the star's */
    uint8_t form;    /* code of the corner; 0: a simplex */
    int64_t facet;   /* place of the facet among all, unique: those of sliding stars are negative */
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
    double value; /* of the element */
    pl_joint_state state;
    int is_loose; /* kept[1] holds, not [0] */
    int n;
    int32_t node[PL_JOINT_NODES];
    int has_moved; /* in the last try */
} pl_joint_patch;

/** Make the input of a run that is measured: largest_angle, kept and star_of. limits [2]: kept[0] and
 *  [1]. Errors: _MEMORY. */
int pl_joint_create(pl_run *run, const pl_star_limits limits[2], pl_joint *joint,
                    planish_error *error);

/** Free the arrays of joint. */
void pl_joint_destroy(pl_joint *joint);

/** Return the value of the measure that is raised where the run's limit of it is square. */
double pl_joint_value_of(const pl_run *run, double square);

/** Return the star of a movable node and in *visits those that it is of. */
static inline int64_t pl_joint_visits(const pl_joint *joint, int32_t node,
                                      const pl_visits **visits) {
    const int32_t star = joint->star_of[node];
    const planish_plan *plan = joint->run->plan;
    *visits = star >= 0 ? &plan->interior : &plan->sliding;
    return star >= 0 ? star : -2 - star;
}

/** Return the least measure of an element, of the kind that is raised. */
double pl_joint_value(const pl_joint *joint, const pl_joint_element *element);

/** Return the element as one that is at its limit. */
pl_joint_pinned pl_joint_pin(const pl_joint *joint, const pl_joint_element *element);

/** Compare the nodes of two such elements a and b, for qsort. */
int pl_joint_compare(const void *a, const void *b);

/** Set patch to one of the movable nodes of an element of the plan's mesh. Return 0 if there is none to
 *  be made: no node can be in one, its measure is not below wanted, or the element is pinned. */
int pl_joint_seed(const pl_joint *joint, int64_t element, pl_joint_patch *patch);

/** Try to bring the patch's element to the wanted measure, and let the patch grow. */
void pl_joint_improve(const pl_joint *joint, int thread, pl_joint_patch *patch);

#endif
