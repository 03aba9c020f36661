/* problems: small meshes with everything that planish_smooth can be asked for, and other forms of
 * them: the same mesh scaled, moved, turned, mirrored, numbered otherwise.
 */
#ifndef TEST_SUPPORT_PROBLEMS_H
#define TEST_SUPPORT_PROBLEMS_H

#include <planish/planish.h>

/** What is asked for. */
typedef enum test_wish {
    WISH_PLAIN,
    WISH_CONJUGATE, /* directions of Fletcher and Reeves */
    WISH_MEAN_RATIO,
    WISH_EDGE_RATIO,
    WISH_TANGLED,
    WISH_HOPELESS, /* tangled on its boundary, too */
    WISH_TANGLED_SLIDING,
    WISH_SLIDING,
    WISH_WORST_RATIO,
    WISH_WORST_ANGLE,
    WISH_LEAST_VOLUME, /* of all elements, with a weight */
    WISH_OWN_VOLUMES,  /* of each element */
    WISH_FRACTION,     /* of the domain */
    WISH_BOUNDS,       /* of each node and of all */
    WISH_DISPLACEMENT,
    WISH_ONLY_WORSE,
    WISH_AROUND,
    WISH_PERIODIC,
    WISH_FLOAT,
    WISH_LAPLACIAN,
    WISH_AREA_LAPLACIAN,
    WISH_LENGTH_LAPLACIAN,
    WISHES
} test_wish;

extern const char *const test_wish_names[WISHES];

/** All arrays are its own. */
typedef struct test_problem {
    planish_mesh mesh;
    planish_options options;
    double *coordinates;   /* [n][dim], that of mesh */
    int32_t *elements;     /* [m][dim + 1] */
    uint8_t *constraint;   /* [n] */
    double *direction;     /* [n][dim] */
    int32_t *periodic;     /* [n_periodic][2] */
    double *min_volume;    /* [m] */
    double *lower, *upper; /* [n][dim] */
    int64_t *around;
    int32_t *node_now;    /* [n] number of each node that was made, and of each element */
    int32_t *element_now; /* [m] */
} test_problem;

/** A box of so many cells each way, of size 1 each, its nodes shaken by multiples of 2^-20. */
void test_problem_create(test_problem *p, int dim, int cells, test_wish wish, unsigned seed);
void test_problem_destroy(test_problem *p);

/** Multiply all that has a unit of length by 2^exponent. */
void test_problem_scale(test_problem *p, int exponent);

/** Multiply all that has a unit of length by factor, then add shift to each coordinate. */
void test_problem_move(test_problem *p, double factor, double shift);

/** The new coordinate d is sign[d] times coordinate axis[d]. */
void test_problem_turn_axes(test_problem *p, const int *axis, const int *sign);

/** Rotate by some angles about axes; there must be no bounds. */
void test_problem_rotate(test_problem *p);

/** Number the nodes, or the elements, at random. */
void test_problem_renumber_nodes(test_problem *p, unsigned seed);
void test_problem_renumber_elements(test_problem *p, unsigned seed);

/** Permute the corners of the elements at random, by even permutations, or by any. */
void test_problem_turn_corners(test_problem *p, int only_even, unsigned seed);

/** Exchange two corners of all elements. */
void test_problem_reverse(test_problem *p);

/** What planish makes of a problem, by the numbers that nodes and elements were made with. */
typedef struct test_outcome {
    double *coordinates;          /* [n][dim] smoothed, */
    double *ratio_before, *ratio; /* [m] radius ratios */
    planish_quality before, after;
    planish_result result;
    planish_plan_info info;
    int64_t unfixable, below;
} test_outcome;

/** The test fails if a call does. */
test_outcome test_problem_solve(const test_problem *p);
void test_outcome_destroy(test_outcome *o);

#endif
