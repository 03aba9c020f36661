/* plan: all that smoothing needs to know of one connectivity, made once. */
#ifndef PL_SWEEP_PLAN_H
#define PL_SWEEP_PLAN_H

#include "star/star.h"
#include "sweep/placement.h"
#include "topology/topology.h"

/** Stars in the order of their visits: colour by colour. Everything is owned. */
typedef struct pl_visits {
    pl_stars stars;        /* rings in inner numbers */
    int32_t *centre;       /* [n_stars] inner number of each star's node */
    int64_t *colour_begin; /* [n_colours + 1] first star of each colour */
    int n_colours;
    int64_t n_followers;
    pl_follower
        *follower; /* nodes that move with those of the stars, and images: by inner numbers */
} pl_visits;

/** What is_free says of a node. */
enum { PL_HELD = 0, PL_INTERIOR = 1, PL_SLIDES = 2 };

/** n nodes, m elements; "inner" numbers run along the space-filling curve. Everything is owned but
 *  elements. */
struct planish_plan {
    int dim;
    int64_t n_nodes, n_elements;
    const int32_t *elements; /* [m][dim + 1] the caller's */
    double *min_volume;      /* [m] mesh->min_volume, or NULL */
    int8_t *sign;            /* [m] orientation of the elements, NULL: all +1 */
    uint8_t *is_free;        /* [n] by the caller's numbers: PL_HELD, ... */
    uint8_t *is_used;        /* [n] likewise: by an element */
    int32_t *inner;          /* [n] inner number of each of the caller's nodes */
    int is_selective;        /* only nodes of bad elements are free, see pl_select */
    pl_visits interior;      /* of the nodes that may go anywhere, */
    pl_visits sliding;       /* and of those that stay on a plane, line or surface: */
    int64_t n_images;        /* nodes after the mesh's own, see pl_periodic */
    pl_star_slide *slide;    /* [sliding.stars.n_stars] which; point is where a call starts */
    pl_placement *placement;
    int threads;
    const pl_star_kernel *kernel;
    planish_plan_info info;
    /* Scratch of planish_smooth: */
    double *coordinates; /* [n + n_images][dim] by inner numbers, scaled */
    double *measured;    /* [n][dim] by the caller's numbers, scaled: for measuring */
    uint8_t *changed;    /* [n + n_images] by inner numbers, see pl_star_problem */
    double *partial;     /* decrease of each chunk of a colour */
    double *scratch;     /* [threads][scratch_stride] of the kernels */
    int64_t scratch_stride;
};

/** The local problem of the plan's interior (or sliding) stars in its arrays, with the first
 *  direction and no limits. */
pl_star_problem pl_plan_problem(const planish_plan *plan);
pl_star_problem pl_plan_sliding_problem(const planish_plan *plan);

/** Colours of both. */
int pl_plan_colours(const planish_plan *plan);

/** Copy the caller's coordinates [n][dim] to inside [n][dim], by inner numbers. */
void pl_plan_order(const planish_plan *plan, const double *coordinates, double *inside);

enum { PL_CHUNK_STARS = 32 }; /* stars that one thread takes at a time */

#endif
