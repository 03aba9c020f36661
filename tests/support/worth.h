/* worth: what a mesh is worth, in long double and from textbook formulas: what planish promises is
 * measured by it, and by nothing of src but the exact sign of a measure. */
#ifndef TEST_SUPPORT_WORTH_H
#define TEST_SUPPORT_WORTH_H

#include <planish/planish.h>

typedef long double real;

/** What is asked of the mesh; arrays are by the caller's numbers. */
typedef struct worth_problem {
    const planish_mesh *mesh;  /* dense, of 32 bits; its coordinates are not looked at */
    const int8_t *sign;        /* [n_elements] times the measure is positive in a valid mesh */
    const uint8_t *is_known;   /* [n_elements] what is measured, or NULL: all */
    const uint8_t *is_movable; /* [n_nodes] nodes that are free or slide */
    const uint8_t *moves;      /* [n_nodes] those of them that may have moved */
    planish_objective objective;
    double area_weight;
    double min_volume; /* of elements without their own; 0: none */
} worth_problem;

typedef struct worth {
    int64_t n_elements;                  /* known ones */
    int64_t inverted;                    /* decided exactly */
    int64_t below;                       /* below 0.997 of the minimum volume, beyond rounding, */
    int64_t nearly;                      /* and those and what may be so by rounding */
    real objective;                      /* F over the valid elements */
    real rms, rms_movable, rms_ratio;    /* of AR; of those with a movable node; of RR */
    real loss, loss_movable, loss_ratio; /* how many roundings of double these may be off by, */
    real loss_objective, loss_domain;    /* and F, and the domain */
    real worst;                          /* largest RR of valid elements with a movable node, */
    real smallest_angle;                 /* and smallest angle of these, degrees; 180 without any */
    real domain;                         /* sum of the signed volumes */
    real multiple;                       /* RMS of g */
    real smallest, mean;                 /* volume of valid elements, and mean |volume| */
} worth;

/** At coordinates [n_nodes][dim]. */
worth worth_of(const worth_problem *problem, const double *coordinates);

/** RR of an element, 0 if it is not positive. */
real worth_ratio(const worth_problem *problem, const double *coordinates, int64_t element);

/** Its signed volume. */
real worth_volume(const worth_problem *problem, const double *coordinates, int64_t element);

/** Exactly: whether an element is positive. */
int worth_is_positive(const worth_problem *problem, const double *coordinates, int64_t element);

/** The minimum volume of an element; 0: none. */
double worth_least(const worth_problem *problem, int64_t element);

#endif
