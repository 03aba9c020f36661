/* kernel_local: everything about the star under visit, and the bounds of its node.
 *
 *   local_init, to_star, to_mesh                        gather a star; scale to it and back
 *   claim, acquit, note_ratio, move_node                flags, ratio and place of its node
 *   bounds_init, within_bounds, clamp, bounds_rate      bounds of the node
 */
#ifndef PL_STAR_KERNEL_LOCAL_H
#define PL_STAR_KERNEL_LOCAL_H

#include "base/round.h"
#include "geometry/simplex.h"
#include "star/kernel_objectives.h"
#include "star/kernel_direction.h"
#include "star/kernel_gather.h"
#include "star/kernel_slide.h"

/** Bounds of the node's position, in the star's scale. */
typedef struct bounds {
    int any; /* 0: nowhere in particular, and the rest is not set */
    double lower[3], upper[3];
    double start[3], radius; /* radius infinite: any distance from start */
} bounds;

/** Star under visit. q, b, slide, kind and constrained are for the guarded kernel. */
typedef struct local {
    const pl_star_problem *problem;
    star s;
    question q;
    bounds b;
    sliding slide;
    planish_search kind; /* of the direction under way */
    int constrained;     /* constraints were active in the last step */
    int alone;           /* nothing around has changed since the last visit */
    int64_t *evaluations;
} local;

/* A direction that approaches a constraint by less than this, relative to the lengths of both, is
 * parallel to it. */
#define PARALLEL 1e-9
/* Constraints with g above it are active, as in the paper; for the distance moved g is
 * distance / radius - 1. */
#define ACTIVE_ABOVE (-0.05)
/* A position pulled back to the distance allowed ends this fraction inside, for rounding. */
#define RADIUS_MARGIN 0x1p-40
/* And is within it beyond doubt of rounding. */
#define RADIUS_ROUNDING 0x1p-50

/** Set the bounds of a node, in the star's scale. */
static inline void bounds_init(bounds *b, const pl_star_problem *problem, int32_t node,
                               double scale, const int dim) {
    const pl_star_guard *guard = problem->guard;
    b->any = guard->lower || guard->upper || guard->radius;
    if (!b->any)
        return;
    for (int d = 0; d < dim; d++) {
        int64_t i = (int64_t)node * dim + d;
        b->lower[d] = guard->lower ? guard->lower[i] * scale : -INFINITY;
        b->upper[d] = guard->upper ? guard->upper[i] * scale : INFINITY;
        b->start[d] = guard->radius ? guard->start[i] * scale : 0;
    }
    b->radius = guard->radius ? guard->radius[node] * scale : INFINITY;
}

/** Gather the star of index into scratch, with its node at place. Set up in place: a copy of what
 *  has just been written would wait for it. */
PL_INLINE void local_init(local *here, const pl_star_problem *problem, int64_t index,
                          const double *place, const int *exponent, double *scratch,
                          int64_t *evaluations, const int guarded, const int dim) {
    here->problem = problem;
    here->kind = problem->search;
    here->evaluations = evaluations;
    here->constrained = here->alone = 0;
    here->s = gather(problem, index, place, exponent, scratch, guarded, dim);
    if (guarded) {
        const pl_star_guard *guard = problem->guard;
        here->q = (question){guard->objective, 1 / guard->worst_limit, guard->ratio_weight,
                             guard->volume_weight, guard->penalty};
        bounds_init(&here->b, problem, problem->node[index], here->s.scale, dim);
        sliding_init(&here->slide, problem, index, here->s.scale, dim);
    }
}

/* ---- the node ------------------------------------------------------------------------------ */

/* A star counts as improved where a visit made its function fall by more than this, relative. */
#define IMPROVED 0.01

/** Return the flags of a star that has changed since its last visit, else 0. It then counts as
 *  visited, and as bad until that is known. */
static inline int claim(const pl_star_problem *problem, int64_t index) {
    uint8_t *changed = &problem->changed[problem->node[index]];
    const int flags = __atomic_load_n(changed, __ATOMIC_RELAXED);
    if (!(flags & PL_CHANGED))
        return 0;
    __atomic_store_n(changed, PL_BAD, __ATOMIC_RELAXED);
    return flags;
}

/** Take in the largest ratio of a star that was visited. */
static inline void note_ratio(pl_star_tally *tally, double max) {
    tally->largest = max > tally->largest ? max : tally->largest;
}

/** Take in the gain of a star that was visited, whose largest ratio is known to the tally. */
static inline void note_gain(pl_star_tally *tally, int64_t index, double ratio, double fall,
                             int improved, int restored) {
    pl_sum_add(&tally->decrease, fall);
    tally->improved += improved;
    tally->restored += restored;
    if (tally->gain)
        tally->gain[index - tally->first] =
            (pl_star_gain){fall, ratio, (uint8_t)improved, (uint8_t)restored};
}

/** Note that the star under visit has no element above rr2_skip. */
static inline void acquit(const pl_star_problem *problem, int32_t node) {
    __atomic_store_n(&problem->changed[node], 0, __ATOMIC_RELAXED);
}

/* Fall of a visit that restored volumes, met a constraint or weighs volumes. Such a visit tells its
 * neighbours however little its function fell. Only moves shorter than `still` stay untold. */
#define FALL_TOLD INFINITY

/** Move the node from place (as in the mesh) to x (scaled). There the star is_bad, or may be, and
 *  its function is lower by fall, relative. If the move is large enough, mark the neighbours' stars
 *  as changed: all of them and the node itself if the star is bad, else only bad neighbours.
 *  Several threads may mark one star at the same time; all write one value. */
static inline void move_node(const local *here, int32_t node, const double *x, double size2,
                             double fall, int is_bad, double *place, const int dim) {
    uint8_t *changed = here->problem->changed;
    double moved2 = 0;
    for (int d = 0; d < dim; d++) {
        double move = x[d] - place[d] * here->s.scale;
        moved2 += move * move;
        place[d] = x[d] * here->s.unscale;
    }
    const double still = here->problem->still;
    if (!(moved2 > still * still * size2) || fall < here->problem->calm) {
        if (!is_bad)
            acquit(here->problem, node);
        return;
    }
    __atomic_store_n(&changed[node], is_bad ? PL_CHANGED | PL_TOLD | PL_BAD : PL_TOLD,
                     __ATOMIC_RELAXED);
    for (int64_t i = 0; i < here->s.n_ring; i++)
        if (is_bad || __atomic_load_n(&changed[here->s.ring[i]], __ATOMIC_RELAXED) & PL_BAD)
            __atomic_store_n(&changed[here->s.ring[i]], PL_CHANGED, __ATOMIC_RELAXED);
}

/** Scale place [dim] of the mesh to x in the star. */
static inline void to_star(const local *here, const double *place, double *x, const int dim) {
    for (int d = 0; d < dim; d++)
        x[d] = place[d] * here->s.scale;
}

/** Scale the derivatives to the mesh: gradient [3], hessian [6]. */
static inline void to_mesh(const local *here, const derivatives *derivative, double *gradient,
                           double *hessian) {
    for (int d = 0; d < 3; d++)
        gradient[d] = derivative->gradient[d] * here->s.scale;
    for (int d = 0; d < 6; d++)
        hessian[d] = derivative->hessian[d] * here->s.scale * here->s.scale;
}

/* ---- bounds -------------------------------------------------------------------------------- */

/* Squares outside of these have lost digits, or all of them, to under- or overflow. */
#define SQUARE_LEAST 0x1p-900
#define SQUARE_MOST  0x1p1000

/** Distance of x [dim] from where the node began, without under- or overflow. */
static inline double distance_from_start(const bounds *b, const double *x, const int dim) {
    double square = 0;
    for (int d = 0; d < dim; d++)
        square += (x[d] - b->start[d]) * (x[d] - b->start[d]);
    return square > SQUARE_LEAST && square < SQUARE_MOST ? sqrt(square)
                                                         : pl_distance(dim, b->start, x);
}

/** Whether x [dim] is within the bounds. */
static inline int within_bounds(const bounds *b, const double *x, const int dim) {
    int inside = 1;
    if (!b->any)
        return 1;
    for (int d = 0; d < dim; d++)
        inside &= x[d] >= b->lower[d] && x[d] <= b->upper[d];
    return inside && (!(b->radius < INFINITY) ||
                      distance_from_start(b, x, dim) <= b->radius * (1 - RADIUS_ROUNDING));
}

/** Bring x within bounds. */
static inline void clamp(const bounds *b, double *x, const int dim) {
    if (!b->any)
        return;
    if (b->radius < INFINITY) {
        double far = distance_from_start(b, x, dim);
        if (far > b->radius)
            for (int d = 0; d < dim; d++)
                x[d] = b->start[d] + (x[d] - b->start[d]) * (b->radius * (1 - RADIUS_MARGIN) / far);
    }
    for (int d = 0; d < dim; d++) {
        x[d] = x[d] < b->lower[d] ? b->lower[d] : x[d];
        x[d] = x[d] > b->upper[d] ? b->upper[d] : x[d];
    }
}

/** Return 1 / (largest step within bounds), 0 if there is no bound ahead. */
static inline double bounds_rate(const bounds *b, const double *x, const double *direction,
                                 const int dim) {
    if (!b->any)
        return 0;
    double least = INFINITY;
    if (b->radius < INFINITY) {
        /* largest t with |v + t direction| <= radius, v = x - start; none for directions that do
         * not lead outwards from next to the sphere: the little that they leave it by is clamped */
        double dd = 0, vd = 0, vv = 0;
        for (int d = 0; d < dim; d++) {
            double v = x[d] - b->start[d];
            dd += direction[d] * direction[d];
            vd += v * direction[d];
            vv += v * v;
        }
        double room = b->radius * b->radius - vv;
        int is_inwards =
            vd <= PARALLEL * sqrt(vv * dd) && sqrt(vv) > (1 + ACTIVE_ABOVE) * b->radius;
        if (!is_inwards && dd > 0)
            least = (sqrt(vd * vd + dd * (room > 0 ? room : 0)) - vd) / dd;
    }
    double parallel = PARALLEL * sqrt(dot(direction, direction, dim));
    for (int d = 0; d < dim; d++) {
        double room = direction[d] > 0 ? b->upper[d] - x[d] : b->lower[d] - x[d];
        double step = fabs(direction[d]) > parallel ? room / direction[d] : INFINITY;
        least = step < least ? step : least;
    }
    return least < INFINITY ? 1 / least : 0;
}

#endif
