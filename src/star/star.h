/* star: the local problem of one node.
 *
 * A star is a free node x with the elements around it. Each element is seen as its facet opposite
 * x (a link facet) and x itself. A visit minimises the sum of RR^2 over the star, or with a guard
 * what is asked for, one step at a time, and never leaves the polytope in which every element is
 * positive (docs/algorithm.md).
 *
 * The kernel starts no thread, allocates no memory and opens no file: a visit works in the scratch
 * memory that its caller gives. It has two effects besides moving its node. Threads visit stars of
 * one colour at the same time, so the flags pl_star_problem.changed are read and written atomically
 * (kernel_local.h, kernel_visit.h, kernel_guarded.h). A node that slides on the caller's surface
 * calls the caller's function, outside of the context of the call (kernel_slide.h).
 *
 * The same source is compiled for several instruction sets (kernel_entry.h); all of them, and the
 * plain one, give the same bits.
 *
 *   pl_star_problem, _guard, _untangling, _slide, _limits    input of visits
 *   pl_star_tally, _optimality, _value, _energy              their output
 *   pl_star_scratch_size, _of                                memory that they need
 *   pl_star_kernel_select                                    the functions of an instruction set
 *   pl_star_visit_of, _evaluate_of, _ratio_of                those for a problem
 *   pl_star_is_held, _admit, _slide_to                       places that a node may take
 *   pl_star_infeasible                                       feasibility.c: proofs
 *   pl_star_update_shifts                                    multipliers.c: augmented Lagrangian
 */
#ifndef PL_STAR_H
#define PL_STAR_H

#include "base/clock.h"
#include "geometry/corner.h"
#include "geometry/link.h"
#include "geometry/target.h"
#include "base/round.h"
#include "base/sum.h"

#include <planish/planish.h>

#include <math.h>

/** Lanes of every sum over link facets: facet i goes to lane i % 4, whatever the CPU has. */
enum { PL_LANES = 4 };

/** Objectives of the worst elements alone: the sum is of high powers of RR^2 / worst_limit, or, of
 *  all angles, of 1 / (sin^2 worst_limit). With forms: of mu^2 / worst_limit, or of
 *  1 / (SJ^2 worst_limit), SJ the scaled Jacobian of a corner. Stars without anything above the limit
 *  are left alone. */
enum pl_star_worst {
    PL_WORST_RATIO = PLANISH_OBJECTIVE_EDGE_RATIO + 1,
    PL_WORST_ANGLE,   /* of simplices */
    PL_WORST_JACOBIAN /* with forms */
};

/** Further input of the guarded kernel, which serves every objective, minimum volumes and bounds.
 *  The arrays over nodes are by inner numbers; any array may be NULL: nothing asked. */
typedef struct pl_star_guard {
    int objective;                      /* a planish_objective, or one of pl_star_worst */
    double worst_limit;                 /* for these: what no element shall have more of */
    double ratio_weight, volume_weight; /* of sum AR^2 and sum g^2 in a star's function */
    double min_volume;                  /* of elements without their own; 0: none */
    int keep_below;                /* 1: violated elements are not brought up, but not lowered */
    int strict;                    /* 1: elements are violated as soon as they are below */
    const double *link_min_volume; /* [link_offset[n_stars]] of the facets' elements, 0: none */
    double penalty;                /* rho, above 0: minimum volumes by augmented Lagrangian */
    double *link_shift;            /* [link_offset[n_stars]] lambda / rho of the elements then */
    const double *lower, *upper;   /* [n_nodes][dim] */
    const double *start;           /* [n_nodes][dim] where the nodes were, */
    const double *radius;          /* [n_nodes] and how far they may go */
} pl_star_guard;

/** Whether the bounds leave the node no room: it is held. */
static inline int pl_star_is_held(const pl_star_guard *guard, int32_t node, int dim) {
    int held = guard->lower && guard->upper;
    for (int d = 0; held && d < dim; d++)
        held = guard->lower[(int64_t)node * dim + d] == guard->upper[(int64_t)node * dim + d];
    return held;
}

/** Input of untangling (kernel_untangle.h): the regularised energy of the elements around the
 *  nodes of a patch. Arrays over nodes are by inner numbers. */
typedef struct pl_star_untangling {
    const uint8_t *in_patch;  /* [n_nodes] 1: the node may move */
    const double *size;       /* [n_nodes] length of edges that is wanted there */
    const uint8_t *link_skip; /* [link_offset[n_stars]] 1: the facet's element cannot be helped and
                                 does not count; NULL: all count */
    double epsilon;           /* of the regularisation */
    double target_size;       /* with targets, whose measures times it are wanted instead */
} pl_star_untangling;

/** Plane or line on which a node slides. */
typedef struct pl_star_slide {
    planish_constraint kind; /* PLANISH_CONSTRAINT_ON_PLANE, _ON_LINE or _ON_SURFACE */
    int32_t node;            /* its number, the caller's */
    double point[3];         /* of the plane or line: where the node was, */
    double direction[3];     /* and its unit normal, or direction */
} pl_star_slide;

/** Bring x [dim] to the plane or line on which a node slides. */
static inline void pl_star_slide_to(const pl_star_slide *slide, int dim, double *x) {
    double way[3] = {0}, along = 0;
    for (int d = 0; d < dim; d++)
        way[d] = x[d] - slide->point[d];
    for (int d = 0; d < dim; d++)
        along += way[d] * slide->direction[d];
    for (int d = 0; d < dim; d++)
        x[d] = slide->kind == PLANISH_CONSTRAINT_ON_LINE
                   ? slide->point[d] + slide->direction[d] * along
                   : slide->point[d] + (way[d] - slide->direction[d] * along);
}

/** Limits on how bad an element may become; infinite: as bad as it likes. */
typedef struct pl_star_limits {
    double rr2;       /* largest RR^2, with forms mu^2, */
    double acuteness; /* and acuteness of the smallest angle (geometry/angle.h); with forms the
                         largest 1 / SJ^2, SJ the scaled Jacobian of a corner */
    double rr2_blunt; /* RR^2, or mu^2, up to which no element has such an angle */
} pl_star_limits;

/** Limits that no star exceeds. */
static inline pl_star_limits pl_star_no_limits(void) {
    return (pl_star_limits){INFINITY, INFINITY, INFINITY};
}

/** Hessian that a star of tetrahedra keeps from one visit to the next: it changes little once
 *  the star's function does. */
typedef struct pl_star_kept {
    float inverse[6]; /* xx xy xz yy yz zz, in the scale that the star had */
    float sum; /* the star's function where it was that; 0: nothing is kept; PL_SCALE_ALONE */
    int32_t exponent; /* of that scale */
} pl_star_kept;

/* As sum: there is no Hessian, but the scale that the star had. */
#define PL_SCALE_ALONE (-1)

/** Row besides those of link facets: if the node, and what follows it, moves by d,
 *  E = e + 2 slope_e . d + c |d|^2 and D = D0 + slope_d . d, and mu^2 = factor E^2 D^-k counts with
 *  this weight in the sum. weight 0: D is to stay positive, no more. In the scale of the mesh. */
typedef struct pl_star_row {
    double weight, factor;
    double share; /* of the row that the star counts in a sum over stars (pl_star_energy) */
    double size;  /* length of edges that is wanted there, as pl_star_untangling.size */
    double e, slope_e[3], c;
    double D0, slope_d[3];
} pl_star_row;

/** Fill row with the further rows of a star, where its node is; returns how many there are. */
typedef int64_t pl_star_more_fn(const void *user, int64_t star, pl_star_row *row);

/** Data that all visits of one sweep share. Nodes are numbered along the plan's curve. */
typedef struct pl_star_problem {
    double *coordinates;        /* [n_nodes][dim] */
    const int32_t *node;        /* [n_stars] the node of each star */
    const int64_t *ring_offset; /* [n_stars + 1] */
    const int32_t *ring;        /* neighbours, see pl_stars */
    const int64_t *link_offset; /* [n_stars + 1] */
    pl_link link;               /* of all stars, see pl_stars */
    const uint8_t *link_form;   /* [link_offset[n_stars]] codes of the facets, whose elements are
                                   corners (geometry/corner.h): ratios are mean ratios then; NULL:
                                   simplices */
    const pl_corner_form *form; /* [PL_N_FORMS] by codes */
    const pl_target
        *target; /* [elements] what corners are to be; NULL: ideal ones of their shapes */
    const pl_metric
        *metric;        /* [elements] then: in which they are to be that; NULL: lengths are usual */
    double size_weight; /* of sizes against shapes then, 0 .. 1 (geometry/target.h) */
    const int32_t *link_element; /* [link_offset[n_stars]] then: the facets' elements */
    pl_star_more_fn *more; /* rows besides those of the facets, at most max_more of a star, and
                                   ratios are mean ratios then; NULL: none */
    const void *more_user;
    const uint8_t *has_more; /* [n_stars] 1: the star has such rows */
    int64_t max_more;
    double *scratch; /* [threads][scratch_stride], see pl_star_scratch_size */
    int64_t scratch_stride;
    uint8_t *changed;   /* [n_nodes] flags of the node's star, see PL_CHANGED */
    pl_star_kept *kept; /* [n_stars], for Newton's direction in space; NULL: none */
    planish_search search;
    pl_star_limits limits;       /* a move that makes an element worse is refused */
    double still;                /* a move shorter than this fraction of the star's size changes
                                   nothing for the stars around, */
    double calm;                 /* nor does one that brought less than this part of the star's
                                   function */
    double rr2_skip;             /* stars whose largest RR^2 is not above it are left alone */
    pl_storage storage;          /* positions are rounded to it before they are judged */
    planish_objective objective; /* without a guard and forms: RADIUS_RATIO, or MEAN_RATIO if there
                                    is neither an rr2_skip nor a limit but that of RR^2 */
    const pl_star_guard *guard;  /* NULL: the sum of that ratio, or with forms of mu^2; volumes
                                    positive, no bounds */
    const pl_star_slide *slide; /* [n_stars] with a guard: where the nodes slide, their links may be
                                   open; NULL: the nodes may go anywhere */
    planish_project_fn *project; /* of nodes on a surface, called with */
    void *project_user;
    const pl_star_untangling *untangling; /* NULL but for visits that untangle */
} pl_star_problem;

/** Flags of a star. PL_CHANGED: the star must be visited; without it the star is skipped. PL_TOLD:
 *  its node has moved and told its neighbours; no neighbour has told it of a move since. PL_BAD:
 *  the star may have an element above rr2_skip; a neighbour that moves must wake it. Without PL_BAD
 *  only a neighbour whose own star is bad wakes it. Moves shorter than `still` wake nobody. */
enum { PL_CHANGED = 1, PL_TOLD = 2, PL_BAD = 4 };

/** Gain by the visit of one star, as added to a tally. */
typedef struct pl_star_gain {
    double fall;  /* to decrease */
    double ratio; /* to largest */
    uint8_t improved, restored;
} pl_star_gain;

/** Tally of a range of visits. */
typedef struct pl_star_tally {
    pl_sum decrease;     /* of the stars' functions, at least 0; by what restored nothing */
    int64_t visits;      /* stars looked at */
    int64_t evaluations; /* of their function */
    int64_t improved;    /* stars whose function fell by more than a hundredth of itself */
    int64_t restored;    /* stars in which elements were brought nearer to their minimum volume */
    double largest;      /* ratio of the stars, RR^2 or mu^2, after their visits; with a guard and
                            without forms, AR^2 of its objective */
    pl_star_gain *gain;  /* [stars of the range] set for those that are moved, by kernels that
                            minimise; NULL: not wanted */
    int64_t first;       /* star of the range, for gain */
} pl_star_tally;

/** First-order optimality of a range of stars. */
typedef struct pl_star_optimality {
    double residual;   /* largest |P| h / f: P the projection of -grad f, h the star's size */
    pl_sum residual2;  /* sum of the squares of these */
    double multiplier; /* largest of a g_k, for the star's function f */
    int64_t n_active;  /* constraints with a multiplier */
    int64_t n_stars;   /* feasible stars looked at */
} pl_star_optimality;

/** Scratch of a thread. */
static inline double *pl_star_scratch_of(const pl_star_problem *problem, int thread) {
    return problem->scratch + problem->scratch_stride * thread;
}

/** Bytes of scratch (64-byte aligned, one per thread) for stars of at most max_ring neighbours,
 *  max_link facets and max_more further rows. */
int64_t pl_star_scratch_size(int dim, int64_t max_ring, int64_t max_link, int64_t max_more);

/** Bring x [dim], where the node shall go, to a place that can be stored and is within its bounds.
 *  Return 0 if the node has to stay. */
int pl_star_admit(const pl_star_problem *problem, int32_t node, int dim, double *x);

/** Role of an element in the proof that not all elements of a star can reach their minimum
 *  volumes. */
typedef enum pl_proof_role {
    PL_PROOF_NONE = 0,
    PL_PROOF_MEMBER = 1,  /* it contradicts others */
    PL_PROOF_GIVEN_UP = 2 /* in a proof, and the others need not fail without it */
} pl_proof_role;

/** Give up elements of the star's fixed link facets, and return how many: one element of each
 * contradiction found. The others can then have their minimum volume, or be positive if they have
 * none, for some place of the node; 0 if there is no proof that any must be (feasibility.c).
 * is_fixed [n_nodes] by inner numbers; part [link facets of the star] is set to pl_proof_role.
 * scratch as for visits. limit (may be NULL): if it is reached, the search ends there; what it has
 * found is proved. */
int64_t pl_star_infeasible(const pl_star_problem *problem, int64_t star_index, int dim,
                           const uint8_t *is_fixed, double *scratch, uint8_t *part,
                           pl_stop_check *limit);

/** Raise the multipliers of the elements of stars begin .. end-1 to max(0, lambda + rho g), and
 *  count the stars as changed where they change, or (if wake) where a minimum volume is in force
 *  (multipliers.c). Returns the largest change of a shift. scratch as for visits. */
double pl_star_update_shifts(const pl_star_problem *problem, int dim, int wake, int64_t begin,
                             int64_t end, double *scratch);

/** Visit the changed ones of stars begin .. end-1, which must be independent, and add to *tally. */
typedef void pl_star_visit_fn(const pl_star_problem *problem, int64_t begin, int64_t end,
                              double *scratch, pl_star_tally *tally);

/** Sum (with a guard, the star's function) and largest of RR^2 (AR^2) over one star at its present
 *  position, and the sum's derivatives. Used by the acceleration, tests and benchmarks. Returns 0
 *  if an element is not positive. hessian: xx, xy, xz, yy, yz, zz (2-D: xx, xy, yy). */
typedef struct pl_star_value {
    double sum, max;
    double error; /* relative, of both: what rounding can have done */
    int certain;  /* every element is positive beyond doubt of rounding */
    double gradient[3], hessian[6];
    double size; /* with derivatives: RMS distance of the node from its facets */
} pl_star_value;
typedef int pl_star_evaluate_fn(const pl_star_problem *problem, int64_t star, double *scratch,
                                int with_derivatives, pl_star_value *value);

/* As with_derivatives, in space: no Hessian, and the gradient as a visit by a kept one computes it.
 * Where a guard's function is not that of one ratio alone, and of triangles, it is as 1. */
enum { PL_GRADIENT_ALONE = 2 };

/** Add the optimality of stars begin .. end-1 to *optimality; the problem has a guard. */
typedef void pl_star_optimality_fn(const pl_star_problem *problem, int64_t begin, int64_t end,
                                   double *scratch, pl_star_optimality *optimality);

/** Regularised energy of elements around a range of stars. Elements of several free nodes of the
 * patch are shared by these nodes, so that sums over the patch's stars count each element once. */
typedef struct pl_star_energy {
    pl_sum sum;      /* of the elements' energies */
    double least;    /* smallest measure, less its floor, relative to the one that is wanted */
    int64_t tangled; /* elements that are not positive beyond doubt, or below their floor, times
                        PL_SHARES */
} pl_star_energy;

enum { PL_SHARES = 12 }; /* divided by 1, 2, 3 and 4 nodes of a patch */

/** Gradient and Hessian of the patch's energy by one node; see pl_star_value for the order. */
typedef struct pl_star_slope {
    double gradient[3], hessian[6];
} pl_star_slope;

/** Return the energy of stars begin .. end-1, without those whose nodes are not in the patch. slope
 * [end - begin] may be NULL; those of nodes that are not in the patch are not written. */
typedef pl_star_energy pl_star_energy_fn(const pl_star_problem *problem, int64_t begin, int64_t end,
                                         double *scratch, pl_star_slope *slope);

/** Functions for problems with a guard. */
typedef struct pl_star_guarded {
    pl_star_visit_fn *visit[2];           /* [dim - 2] */
    pl_star_evaluate_fn *evaluate[2];     /* [dim - 2] */
    pl_star_optimality_fn *optimality[2]; /* [dim - 2] */
    pl_star_visit_fn *untangle[2];        /* [dim - 2] lower the patch's energy */
    pl_star_energy_fn *energy[2];         /* [dim - 2] */
} pl_star_guarded;

/** Functions for problems without a guard whose ratio is the mean ratio. */
typedef struct pl_star_mean {
    pl_star_visit_fn *visit[2];       /* [dim - 2] */
    pl_star_evaluate_fn *evaluate[2]; /* [dim - 2] */
} pl_star_mean;

/** Functions of one instruction set: for problems without a guard, and with one. */
typedef struct pl_star_kernel {
    const char *name;
    pl_star_visit_fn *visit[2];       /* [dim - 2] radius ratio of simplices */
    pl_star_evaluate_fn *evaluate[2]; /* [dim - 2] */
    const pl_star_mean *mean;
    const pl_star_guarded *guarded;
} pl_star_kernel;

/** Whether the limits of a problem are of mean ratios: else of radius ratios. */
static inline int pl_star_is_mean(const pl_star_problem *problem) {
    return problem->link_form != NULL || problem->more != NULL;
}

/** Whether visits of a problem without a guard lower mean ratios. */
static inline int pl_star_lowers_mean(const pl_star_problem *problem) {
    return pl_star_is_mean(problem) || problem->objective == PLANISH_OBJECTIVE_MEAN_RATIO;
}

/** Return the function that visits the stars of a problem. */
static inline pl_star_visit_fn *pl_star_visit_of(const pl_star_kernel *kernel,
                                                 const pl_star_problem *problem, int dim) {
    return problem->guard                 ? kernel->guarded->visit[dim - 2]
           : pl_star_lowers_mean(problem) ? kernel->mean->visit[dim - 2]
                                          : kernel->visit[dim - 2];
}

/** Return the function that evaluates the ratios that limits of a problem are of. */
static inline pl_star_evaluate_fn *pl_star_ratio_of(const pl_star_kernel *kernel,
                                                    const pl_star_problem *problem, int dim) {
    return pl_star_is_mean(problem) ? kernel->mean->evaluate[dim - 2] : kernel->evaluate[dim - 2];
}

/** Return the function that evaluates the objective of a problem's visits. */
static inline pl_star_evaluate_fn *pl_star_evaluate_of(const pl_star_kernel *kernel,
                                                       const pl_star_problem *problem, int dim) {
    return problem->guard                 ? kernel->guarded->evaluate[dim - 2]
           : pl_star_lowers_mean(problem) ? kernel->mean->evaluate[dim - 2]
                                          : kernel->evaluate[dim - 2];
}

/** Return the variant isa (AUTO: the fastest that this CPU has), or NULL if the CPU lacks it. */
const pl_star_kernel *pl_star_kernel_select(planish_isa isa);

extern const pl_star_kernel pl_star_kernel_plain, pl_star_kernel_vector, pl_star_kernel_avx2,
    pl_star_kernel_avx512;
extern const pl_star_mean pl_star_mean_plain, pl_star_mean_vector, pl_star_mean_avx2,
    pl_star_mean_avx512;
extern const pl_star_guarded pl_star_guarded_plain, pl_star_guarded_vector, pl_star_guarded_avx2,
    pl_star_guarded_avx512;

#endif
