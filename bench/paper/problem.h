/* problem: smoothing as one nonlinear problem in all free coordinates, as the paper states it.
 *
 * minimise the mean of RR^2, or mu1 f1 + mu2 f2 where mu2 > 0 (equations 1 and 6 to 9 of the
 * paper), subject to V_k / delta >= 1 for each element with a free node. Nodes on the boundary are
 * fixed. Sparse derivatives as triplets, entries of one place to be added up. No solver is named
 * here.
 */
#ifndef PAPER_PROBLEM_H
#define PAPER_PROBLEM_H

#include <planish/planish.h>

typedef struct problem {
    planish_mesh mesh;
    double *coordinates; /* [n_nodes][dim] the mesh's, which follow the variables */
    int *variable;       /* [n_nodes] the first variable of a free node, or -1 */
    int *movable;        /* [n_movable] elements with a free node, ascending */
    int n_variables, n_movable;
    int n_jacobian, n_hessian; /* triplets of the derivatives; Hessian: lower triangle */
    double delta;              /* minimum volume; 0: none, and no constraints */
    double area_weight;        /* mu2 */
    double fixed_ratios;       /* sum of RR^2 over the elements that cannot change */
    double fixed_constraints;  /* and of g^2 */
} problem;

/** Returns 0, or -1 where memory is short or an element is not positive. coordinates belong to the
 *  caller; delta is fraction times the volume. */
int problem_create(problem *p, planish_mesh mesh, double *coordinates, double fraction,
                   double area_weight);
void problem_destroy(problem *p);

void problem_get_variables(const problem *p, double x[]);
void problem_set_variables(problem *p, const double x[]);

/** All below are of the coordinates as they are. 0, or -1 where an element is not positive. */
int problem_objective(const problem *p, double *value);
int problem_gradient(const problem *p, double gradient[]);
/** F = sqrt of the mean of RR^2, or the weighted sum; negative where the objective has no value. */
double problem_f(const problem *p);
void problem_constraints(const problem *p, double value[]); /* [n_movable] V / delta */

void problem_jacobian_places(const problem *p, int row[], int column[]);
void problem_jacobian(const problem *p, double entry[]);
/** Of factor times the objective (area_weight must be 0) plus the constraints times multiplier. */
void problem_hessian_places(const problem *p, int row[], int column[]);
void problem_hessian(const problem *p, double factor, const double multiplier[], double entry[]);

#endif
