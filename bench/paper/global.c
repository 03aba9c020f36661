/* global: smooth a mesh as one nonlinear problem in all free coordinates, by IPOPT.
 *
 *   global IN OUT [--min-volume-fraction F] [--area-weight MU2] [--max-iterations N]
 *          [--tolerance T] [--derivative-test]
 *
 * The reference that planish's node-by-node result is compared with; docs/paper.md. IN and OUT: any
 * format that planish writes back; all elements of IN must be positive (RR^2 has no value
 * elsewhere; below delta they may be). Where the solver asks for a place with an inverted element
 * it is told that there is no value, and shortens its step. Exact Hessian, or with an area weight,
 * whose square roots would fill it, IPOPT's limited-memory one. Prints JSON; exit status 0 where
 * IPOPT says that it converged, 1 otherwise, 2 on errors.
 */
#include "problem.h"

#include <planish/planish_io.h>

#include <IpStdCInterface.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { MAX_HISTORY = 3001 };

typedef struct options {
    const char *input, *output;
    double fraction, area_weight, tolerance;
    int max_iterations, derivative_test;
} options;

typedef struct run {
    problem problem;
    int values, gradients, jacobians, hessians; /* evaluations of the whole mesh */
    int n_history;
    double history[MAX_HISTORY]; /* F by iteration */
} run;

static int fail(const char *what) {
    fprintf(stderr, "global: %s\n", what);
    return 2;
}

/* ---- What IPOPT calls ---------------------------------------------------------------------- */

static void move_to(run *r, Bool new_x, const double x[]) {
    if (new_x)
        problem_set_variables(&r->problem, x);
}

static Bool objective(Index n, Number *x, Bool new_x, Number *value, UserDataPtr user) {
    (void)n;
    run *r = user;
    move_to(r, new_x, x);
    r->values++;
    return problem_objective(&r->problem, value) == 0;
}

static Bool gradient(Index n, Number *x, Bool new_x, Number *entry, UserDataPtr user) {
    (void)n;
    run *r = user;
    move_to(r, new_x, x);
    r->gradients++;
    return problem_gradient(&r->problem, entry) == 0;
}

static Bool constraints(Index n, Number *x, Bool new_x, Index m, Number *value, UserDataPtr user) {
    (void)n;
    run *r = user;
    move_to(r, new_x, x);
    if (m > 0)
        problem_constraints(&r->problem, value);
    return TRUE;
}

static Bool jacobian(Index n, Number *x, Bool new_x, Index m, Index n_entries, Index *row,
                     Index *column, Number *entry, UserDataPtr user) {
    (void)n;
    (void)n_entries;
    run *r = user;
    if (m == 0)
        return TRUE;
    if (!entry) {
        problem_jacobian_places(&r->problem, row, column);
        return TRUE;
    }
    move_to(r, new_x, x);
    r->jacobians++;
    problem_jacobian(&r->problem, entry);
    return TRUE;
}

static Bool hessian(Index n, Number *x, Bool new_x, Number factor, Index m, Number *multiplier,
                    Bool new_multiplier, Index n_entries, Index *row, Index *column, Number *entry,
                    UserDataPtr user) {
    (void)n;
    (void)m;
    (void)new_multiplier;
    (void)n_entries;
    run *r = user;
    if (!entry) {
        problem_hessian_places(&r->problem, row, column);
        return TRUE;
    }
    move_to(r, new_x, x);
    r->hessians++;
    problem_hessian(&r->problem, factor, multiplier, entry);
    return TRUE;
}

static Bool iteration(Index mode, Index count, Number value, Number inf_pr, Number inf_du,
                      Number mu, Number d_norm, Number regularisation, Number alpha_du,
                      Number alpha_pr, Index trials, UserDataPtr user) {
    (void)mode, (void)count, (void)inf_pr, (void)inf_du, (void)mu, (void)d_norm;
    (void)regularisation, (void)alpha_du, (void)alpha_pr, (void)trials;
    run *r = user;
    if (r->n_history < MAX_HISTORY)
        r->history[r->n_history++] = r->problem.area_weight > 0 ? value : sqrt(value);
    return TRUE;
}

/* ---- Solving ------------------------------------------------------------------------------- */

static void set_options(IpoptProblem ipopt, const options *o) {
    AddIpoptIntOption(ipopt, "print_level", o->derivative_test ? 4 : 0);
    AddIpoptStrOption(ipopt, "sb", "yes");
    AddIpoptIntOption(ipopt, "max_iter", o->max_iterations);
    AddIpoptNumOption(ipopt, "tol", o->tolerance);
    if (o->area_weight > 0)
        AddIpoptStrOption(ipopt, "hessian_approximation", "limited-memory");
    if (o->derivative_test) {
        AddIpoptStrOption(ipopt, "derivative_test",
                          o->area_weight > 0 ? "first-order" : "second-order");
        AddIpoptNumOption(ipopt, "derivative_test_tol", 1e-4);
        AddIpoptNumOption(ipopt, "point_perturbation_radius", 0);
    }
}

static void fill(double a[], int n, double value) {
    for (int i = 0; i < n; i++)
        a[i] = value;
}

/** Move the nodes to a solution; *status is IPOPT's. bound [2 n + 2 m] and x [n] are scratch. */
static int solve_in(run *r, const options *o, double bound[], double x[],
                    enum ApplicationReturnStatus *status) {
    int n = r->problem.n_variables, m = r->problem.delta > 0 ? r->problem.n_movable : 0;
    double *x_lower = bound, *x_upper = x_lower + n, *g_lower = x_upper + n, *g_upper = g_lower + m;
    fill(x_lower, n, -2e19); /* beyond 1e19 IPOPT sees no bound */
    fill(x_upper, n, 2e19);
    fill(g_lower, m, 1);
    fill(g_upper, m, 2e19);
    IpoptProblem ipopt = CreateIpoptProblem(n, x_lower, x_upper, m, g_lower, g_upper,
                                            m > 0 ? r->problem.n_jacobian : 0, r->problem.n_hessian,
                                            0, objective, constraints, gradient, jacobian, hessian);
    if (!ipopt)
        return -1;
    set_options(ipopt, o);
    SetIntermediateCallback(ipopt, iteration);
    problem_get_variables(&r->problem, x);
    *status = IpoptSolve(ipopt, x, NULL, NULL, NULL, NULL, NULL, r);
    problem_set_variables(&r->problem, x);
    FreeIpoptProblem(ipopt);
    return 0;
}

static int solve(run *r, const options *o, enum ApplicationReturnStatus *status) {
    size_t n = (size_t)r->problem.n_variables, m = (size_t)r->problem.n_movable;
    double *scratch = malloc((3 * n + 2 * m) * sizeof *scratch);
    int result = scratch ? solve_in(r, o, scratch, scratch + 2 * (n + m), status) : -1;
    free(scratch);
    return result;
}

/* ---- Report -------------------------------------------------------------------------------- */

static void report(const run *r, const options *o, int status, double seconds) {
    const problem *p = &r->problem;
    printf("{\n  \"status\": %d, \"delta\": %.17g, \"variables\": %d, \"constraints\": %d,\n",
           status, p->delta, p->n_variables, o->fraction > 0 ? p->n_movable : 0);
    printf("  \"objective\": {\"area_weight\": %g, \"before\": %.17g, \"after\": %.17g},\n",
           p->area_weight, r->n_history > 0 ? r->history[0] : 0, problem_f(p));
    printf("  \"iterations\": %d, \"evaluations\": {\"values\": %d, \"gradients\": %d, "
           "\"jacobians\": %d, \"hessians\": %d},\n",
           r->n_history - 1, r->values, r->gradients, r->jacobians, r->hessians);
    printf("  \"cpu_seconds\": %.6f,\n  \"history\": [", seconds);
    for (int i = 0; i < r->n_history; i++)
        printf("%s%.9g", i > 0 ? ", " : "", r->history[i]);
    printf("]\n}\n");
}

static int smooth(planish_file *file, const options *o, run *r) {
    planish_error error;
    if (problem_create(&r->problem, planish_file_mesh(file), planish_file_coordinates(file),
                       o->fraction, o->area_weight))
        return fail("the input has elements that are not positive, or memory is short");
    enum ApplicationReturnStatus status = Internal_Error;
    clock_t start = clock();
    int result = solve(r, o, &status) ? fail("IPOPT does not take the problem") : 0;
    double seconds = (double)(clock() - start) / CLOCKS_PER_SEC;
    if (!result)
        report(r, o, status, seconds);
    if (!result && planish_file_write(file, o->output, r->problem.coordinates,
                                      &(planish_write_options){.threads = 1}, &error))
        result = fail(error.text);
    problem_destroy(&r->problem);
    if (result)
        return result;
    return status == Solve_Succeeded || status == Solved_To_Acceptable_Level ? 0 : 1;
}

/* ---- Command line -------------------------------------------------------------------------- */

static int parse(int argc, char **argv, options *o) {
    int positional = 0;
    for (int i = 1; i < argc; i++) {
        if (!strcmp(argv[i], "--derivative-test"))
            o->derivative_test = 1;
        else if (!strncmp(argv[i], "--", 2) && i + 1 == argc)
            return -1;
        else if (!strcmp(argv[i], "--min-volume-fraction"))
            o->fraction = strtod(argv[++i], NULL);
        else if (!strcmp(argv[i], "--area-weight"))
            o->area_weight = strtod(argv[++i], NULL);
        else if (!strcmp(argv[i], "--tolerance"))
            o->tolerance = strtod(argv[++i], NULL);
        else if (!strcmp(argv[i], "--max-iterations"))
            o->max_iterations = (int)strtol(argv[++i], NULL, 10);
        else if (positional == 0 && ++positional)
            o->input = argv[i];
        else if (positional == 1 && ++positional)
            o->output = argv[i];
        else
            return -1;
    }
    return positional == 2 && (o->area_weight == 0 || o->fraction > 0) ? 0 : -1;
}

int main(int argc, char **argv) {
    options o = {.tolerance = 1e-8, .max_iterations = 3000};
    planish_file *file = NULL;
    planish_error error;
    if (parse(argc, argv, &o))
        return fail("usage: global IN OUT [--min-volume-fraction F] [--area-weight MU2] "
                    "[--max-iterations N] [--tolerance T] [--derivative-test]");
    if (planish_file_open(o.input, NULL, 1, &file, &error))
        return fail(error.text);
    run *r = calloc(1, sizeof *r);
    int result = r ? smooth(file, &o, r) : fail("memory is short");
    free(r);
    planish_file_close(file);
    return result;
}
