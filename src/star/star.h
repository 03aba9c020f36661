/* star: the local problem of one node.
 *
 * A star is a free node x with the elements around it. Each element is seen as its facet opposite
 * x (a link facet) and x itself. A visit minimises the sum of RR^2 over the star, one step at a
 * time, and never leaves the polytope in which every element is positive (docs/algorithm.md).
 *
 * Pure: no threads, no allocation, no files. The same source is compiled for several instruction
 * sets (kernel_*.c); all of them, and the plain one, give the same bits.
 */
#ifndef PL_STAR_H
#define PL_STAR_H

#include <planish/planish.h>

/** Lanes of every sum over link facets: facet i goes to lane i % 4, whatever the CPU has. */
enum { PL_LANES = 4 };

/** What the visits of one sweep share. Nodes are numbered along the plan's curve. */
typedef struct pl_star_problem {
    double *coordinates;        /* [n_nodes][dim], scaled to a bounding box of about 1 */
    const int32_t *node;        /* [n_stars] the node of each star */
    const int64_t *ring_offset; /* [n_stars + 1] */
    const int32_t *ring;        /* neighbours, see pl_stars */
    const int64_t *link_offset; /* [n_stars + 1] */
    const uint16_t *link;       /* [.][dim] positions in the ring, see pl_stars */
    uint8_t *changed;           /* [n_nodes] 1: the star of the node changed since its visit */
    planish_direction direction;
    double rr2_limit; /* a move that makes an element's RR^2 larger is refused */
    double rr2_skip;  /* stars whose largest RR^2 is not above it are left alone */
    int to_float;     /* positions are rounded to float before they are judged */
} pl_star_problem;

/** What a range of visits did. */
typedef struct pl_star_tally {
    double decrease; /* of the sum of RR^2 over all elements, at least 0 */
    int64_t visits;  /* stars looked at */
} pl_star_tally;

/** Bytes of scratch (64-byte aligned, one per thread) for stars of at most max_ring neighbours and
 *  max_link facets. */
int64_t pl_star_scratch_size(int dim, int64_t max_ring, int64_t max_link);

/** Visit the changed ones of stars begin .. end-1, which must be independent. */
typedef pl_star_tally pl_star_visit_fn(const pl_star_problem *problem, int64_t begin, int64_t end,
                                       double *scratch);

/** Sum and largest of RR^2 over one star at its present position, and their derivatives: for tests
 *  and benchmarks of a variant. Returns 0 if an element is not positive. hessian: xx, xy, xz, yy,
 *  yz, zz (2-D: xx, xy, yy). */
typedef struct pl_star_value {
    double sum, max;
    double gradient[3], hessian[6];
} pl_star_value;
typedef int pl_star_evaluate_fn(const pl_star_problem *problem, int64_t star, double *scratch,
                                int with_derivatives, pl_star_value *value);

typedef struct pl_star_kernel {
    const char *name;
    pl_star_visit_fn *visit[2];       /* [dim - 2] */
    pl_star_evaluate_fn *evaluate[2]; /* [dim - 2] */
} pl_star_kernel;

/** The variant asked for (AUTO: the fastest that this CPU has), or NULL if the CPU lacks it. */
const pl_star_kernel *pl_star_kernel_select(planish_isa isa);

extern const pl_star_kernel pl_star_kernel_plain, pl_star_kernel_vector, pl_star_kernel_avx2,
    pl_star_kernel_avx512;

#endif
