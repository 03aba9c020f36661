/* plan: all facts about one connectivity that smoothing needs, computed once.
 *
 * plan.c
 *   pl_plan_destroy                            free a plan; make.h makes one
 *   pl_plan_problem                            the local problem of its stars
 *   pl_plan_colours, _order, _number_stars     colours; coordinates along the curve; stars
 *   pl_plan_points, _all_points, _dense        the caller's coordinates
 *   pl_plan_element, _rows, _given, _node, _inner   the caller's numbers; inner ones
 *   pl_plan_put                                values by elements in the caller's order
 *   pl_box_of_fixed                            extent of the nodes that do not move freely
 *   pl_plan_begin_sizes, _fit_sizes            targets by sizes, where nodes are
 *   pl_plan_check_call                         what every call on coordinates checks
 * check_options.c
 *   pl_options_check                           the values of planish_options
 */
#ifndef PL_PLAN_PLAN_H
#define PL_PLAN_PLAN_H

#include "base/context.h"
#include "geometry/corner.h"
#include "plan/placement.h"
#include "quality/view.h"
#include "star/star.h"
#include "topology/points.h"
#include "topology/topology.h"

/** Stars in the order of their visits: colour by colour. Everything is owned. */
typedef struct pl_visits {
    pl_stars stars;        /* rings in inner numbers */
    int32_t *centre;       /* [n_stars] inner number of each star's node */
    int64_t *colour_begin; /* [n_colours + 1] first star of each colour */
    int64_t *inside_begin; /* [n_colours] first of them that is not SHARED with other processes */
    int n_colours;
    int64_t n_all; /* stars of all processes */
    int64_t n_followers;
    pl_follower *follower; /* nodes that move with those of the stars, and images: by inner
                              numbers */
} pl_visits;

/** Mobility of a node. */
enum { PL_HELD = 0, PL_INTERIOR = 1, PL_SLIDES = 2 };

/** Bits of is_used: the node is used by an element, and what else than its elements holds it. */
enum { PL_USED = 1, PL_FIXED_BY_CALLER = 2, PL_IN_PAIR = 4, PL_NOT_CHOSEN = 8, PL_OF_WRAPPED = 16 };

/** Ghosts of a plan, and their neighbours; inner numbers are those of the plan's arrays. Owned. */
typedef struct pl_ghosts {
    int32_t *node;       /* [n_nodes] the mesh's number of each inner one */
    int64_t *offset;     /* [n_nodes + 1] by the mesh's numbers: where a ghost's neighbours begin */
    int32_t *neighbour;  /* inner numbers of those that are no ghosts */
    uint8_t *is_movable; /* [n_elements] see pl_view.is_movable */
} pl_ghosts;

/** Scope of a plan, and of its measurements. */
typedef enum pl_scope {
    PL_ALL,           /* all of the mesh */
    PL_SUBSET_OF_ALL, /* a subset, and all is measured */
    PL_SUBSET_ALONE   /* a subset, of which alone is known */
} pl_scope;

/** Tally of a thread's visits in a sweep; no line of the cache is shared with another thread's. */
typedef struct pl_thread_tally {
    _Alignas(64) pl_star_tally of;
} pl_thread_tally;

/** Places of a follower and of its leader when the call began. */
typedef struct pl_follower_places {
    double start[3];  /* of the follower, */
    double origin[3]; /* and of its leader */
} pl_follower_places;

struct pl_watch;
struct pl_skin;
struct pl_size_field;

/** Working space of planish_smooth, which a plan keeps from call to call; n nodes. Calls change it
 *  on a plan that is const. Owned. */
typedef struct pl_plan_scratch {
    double *given;       /* [n][dim] the coordinates it starts with, unless the caller's are such */
    double *coordinates; /* [n + n_images][dim] by inner numbers */
    double *to_measure;  /* [n][dim] in the mesh's order, in units of its size: for measuring */
    uint8_t *changed;    /* [n + n_images] by inner numbers, see pl_star_problem */
    double *sizes;       /* [n][plan->sizes->n_numbers]: those where the nodes are */
    pl_star_kept *kept;  /* [stars of interior, then of sliding] likewise; NULL in 2-D */
    uint8_t *is_movable; /* [elements of whole] 1: has a free node in the call that is served */
    pl_follower_places *places; /* [sliding.n_followers] */
    double *kernels;            /* [threads][kernel_stride] */
    int64_t kernel_stride;
    pl_thread_tally *tally; /* [threads] of the sweep under way */
    double *before;         /* [most SHARED nodes of a colour][dim] where they were */
    int32_t *moved;         /* [likewise] those of them that have moved, and */
    char *message; /* what is said of them: coordinates, and whether neighbours were told */
    struct pl_watch *watch; /* of the call under way (sweep/watch.h), or NULL: nothing is watched */
    struct pl_skin *skin;   /* likewise (sweep/skin.h) */
} pl_plan_scratch;

/** Cells that a plan makes of simplices. */
typedef struct pl_own_cells {
    uint8_t *type;   /* [n] */
    int64_t *offset; /* [n + 1] */
    int32_t *node;   /* [offset[n]] */
} pl_own_cells;

/** n nodes, m elements: those of the mesh, or of the subset of it that is worked on; "inner"
 * numbers run along the space-filling curve. Everything is owned, with the arrays of the views, but
 * elements and is_counted. mobility is PL_HELD, PL_INTERIOR or PL_SLIDES. */
struct planish_plan {
    int dim;
    pl_view work;       /* the mesh, or the subset of it that is worked on */
    pl_view whole;      /* all of the mesh, for PL_SUBSET_OF_ALL; else its counts alone */
    const pl_view *all; /* all that is known: &work or &whole */
    pl_corner_form form[PL_N_FORMS];            /* with work.corner */
    int32_t *own_elements, *own_whole_elements; /* those of work and whole, or NULL: the caller's */
    int32_t *wrapped; /* [n_wrapped] elements that wrap around: their nodes are held */
    int64_t n_wrapped;
    uint8_t *is_used; /* [n] 0: by no element; else PL_USED, ... */
    int32_t *inner;   /* [n] inner number of each node */
    int is_blunt;     /* the targets are of layers, not of simplices alone: angles count */
    int is_selective; /* only nodes of bad elements are free, see pl_draft_select */
    int32_t *node_of; /* [n] the caller's number of each node of the plan's mesh; NULL: the same */
    int32_t *element_of;         /* [m] the caller's number of each element */
    planish_cells cells;         /* the mesh's, if they are not linear simplices alone: n above 0 */
    pl_own_cells own_cells;      /* their arrays, of simplices with targets */
    struct pl_size_field *sizes; /* that the targets are made by (shape/size_field.h), or NULL */
    double
        size_factor;  /* of them, as pl_sizes_fit finds it in the mesh of which the plan was made */
    int32_t *cell_of; /* the cell of each element of all, unless element_of has cells; or NULL */
    uint8_t *role;    /* [nodes of the mesh] see pl_dense */
    pl_scope scope;
    int64_t node_stride, component_stride; /* of the caller's coordinates */
    pl_visits interior;                    /* of the nodes that may go anywhere, */
    pl_visits sliding;                     /* and of those that stay on a plane, line or surface: */
    int64_t n_images;                      /* nodes after the mesh's own, see pl_periodic */
    pl_star_slide *slide;       /* [sliding.stars.n_stars] which; point is where a call starts */
    uint8_t *slides_by;         /* [sliding.stars.n_stars] planish_constraint of the caller */
    const planish_shape *shape; /* options.shape that it was made with, the caller's */
    double rounding;            /* options.rounding that it was made with */
    pl_ghosts ghosts;           /* if other processes have parts of the mesh */
    pl_context *context;        /* entered by every call */
    pl_placement *placement;
    int threads;
    const pl_star_kernel *kernel;
    planish_plan_info info;
    pl_plan_scratch scratch;
};

/* ---- plan.c --------------------------------------------------------------------------------- */

/** Free the plan, but not its context. */
void pl_plan_destroy(planish_plan *plan);

/** Return the local problem of the plan's interior or sliding stars, in the plan's arrays, with the
 *  given visits, Newton's search and no limits. */
pl_star_problem pl_plan_problem(const planish_plan *plan, const pl_visits *visits);

/** Number of colours, of the interior and of the nodes that slide. */
int pl_plan_colours(const planish_plan *plan);

/** Copy coordinates [n][dim] to inside [n][dim], by inner numbers. */
void pl_plan_order(const planish_plan *plan, const double *coordinates, double *inside);

/** Set star_of [n], by inner numbers, to the star of each node of the interior; -1: none. */
void pl_plan_number_stars(const planish_plan *plan, int32_t *star_of);

/** Return the coordinates of the plan's nodes, in the caller's array. */
pl_points pl_plan_points(const planish_plan *plan, const double *coordinates);

/** Return the coordinates of all nodes of the mesh that the plan knows, in the caller's array. */
pl_points pl_plan_all_points(const planish_plan *plan, const double *coordinates);

/** Return points as [n][dim]: where they are, or copied to room [n][dim], which is needed if not
 *  pl_points_are_dense. */
const double *pl_plan_dense(const planish_plan *plan, const pl_points *points, double *room);

/** Return the caller's number of an element of the plan's mesh. */
static inline int64_t pl_plan_element(const planish_plan *plan, int64_t element) {
    const int64_t known = plan->element_of ? plan->element_of[element] : element;
    return plan->cell_of ? plan->cell_of[known] : known;
}

/** Return the caller's numbers of the elements of plan->all; NULL: the same. */
static inline const int32_t *pl_plan_rows(const planish_plan *plan) {
    return plan->cell_of || plan->all != &plan->work ? plan->cell_of : plan->element_of;
}

/** Put values from [elements of plan->all], size bytes each, where the caller's elements are: to
 *  [pl_plan_given]. Of corners the first of each cell has its value. */
void pl_plan_put(const planish_plan *plan, const void *from, size_t size, void *to);

/** Return the number of elements of the caller's mesh. */
static inline int64_t pl_plan_given(const planish_plan *plan) {
    return plan->cells.n > 0 ? plan->cells.n : plan->whole.n_elements;
}

/** Return the caller's number of a node of the plan's mesh. */
static inline int64_t pl_plan_node(const planish_plan *plan, int64_t node) {
    return plan->node_of ? plan->node_of[node] : node;
}

/** Return the inner number of corner j of an element of the plan's mesh. */
static inline int32_t pl_plan_inner(const planish_plan *plan, int64_t element, int j) {
    return plan->inner[plan->work.elements[element * (plan->dim + 1) + j]];
}

/** Bounding box of the nodes of elements that do not move freely. */
typedef struct pl_box {
    double lower[3], upper[3];
    double scale; /* a power of two: times it the box is about 1 wide */
} pl_box;

/** Return that box, of the plan's coordinates. */
pl_box pl_box_of_fixed(const planish_plan *plan);

/** Check options, and that coordinates [n][dim] of the caller are finite: every call on coordinates
 *  begins with it. */
int pl_plan_check_call(const planish_plan *plan, const double *coordinates,
                       const planish_options *options, planish_error *error);

/** Make the targets of a plan with sizes from its own coordinates, as for a new plan. */
void pl_plan_begin_sizes(planish_plan *plan);

/** Make the targets of a plan with sizes from coordinates x [.][dim]: node i is at x[place[i]];
 *  place NULL: at x[i]. */
void pl_plan_fit_sizes(planish_plan *plan, const double *x, const int32_t *place);

/* ---- check_options.c ------------------------------------------------------------------------ */

/** Check struct_size and the ranges of all fields. */
int pl_options_check(const planish_options *options, planish_error *error);

enum { PL_CHUNK_STARS = 16 }; /* stars that one thread takes at a time, at most */

#endif
