/* problem: see problem.h. */
#include "problem.h"

#include "../boundary_nodes.h"
#include "element.h"

#include <stdlib.h>
#include <string.h>

/* ---- Elements ------------------------------------------------------------------------------ */

static void vertices_of(const problem *p, int64_t element, const double *vertex[4]) {
    int dim = p->mesh.dim;
    for (int j = 0; j <= dim; j++)
        vertex[j] = p->coordinates + dim * (int64_t)p->mesh.elements[element * (dim + 1) + j];
}

static double determinant_at(const problem *p, int64_t element) {
    const double *vertex[4];
    double edges[3][3];
    vertices_of(p, element, vertex);
    pl_edges(p->mesh.dim, vertex, edges);
    return pl_determinant_of_edges(p->mesh.dim, edges);
}

static double volume_at(const problem *p, int64_t element) {
    return determinant_at(p, element) / (p->mesh.dim == 3 ? 6 : 2);
}

static double ratio_at(const problem *p, int64_t element) {
    const double *vertex[4];
    vertices_of(p, element, vertex);
    return p->mesh.dim == 3 ? element_ratio(3, 0, vertex).value : element_ratio(2, 0, vertex).value;
}

static of_vertices ratio_gradient(const problem *p, int64_t element) {
    const double *vertex[4];
    vertices_of(p, element, vertex);
    return p->mesh.dim == 3 ? element_ratio(3, 1, vertex) : element_ratio(2, 1, vertex);
}

static of_vertices ratio_hessian(const problem *p, int64_t element) {
    const double *vertex[4];
    vertices_of(p, element, vertex);
    return p->mesh.dim == 3 ? element_ratio(3, 2, vertex) : element_ratio(2, 2, vertex);
}

static of_vertices determinant_derivatives(const problem *p, int64_t element) {
    const double *vertex[4];
    vertices_of(p, element, vertex);
    return p->mesh.dim == 3 ? element_determinant(3, 2, vertex) : element_determinant(2, 2, vertex);
}

/** Volume of the regular unit of D, in units of delta. */
static double volume_scale(const problem *p) {
    return 1 / ((p->mesh.dim == 3 ? 6 : 2) * p->delta);
}

/* ---- Which nodes are free ------------------------------------------------------------------ */

/** Mark in variable the nodes of facets of one element only with -1. */
static int mark_boundary(const planish_mesh *mesh, int variable[]) {
    uint8_t *is_on_boundary = calloc((size_t)mesh->n_nodes, 1);
    const int done = is_on_boundary && bench_find_boundary(mesh, is_on_boundary);
    for (int64_t i = 0; i < mesh->n_nodes && done; i++)
        if (is_on_boundary[i])
            variable[i] = -1;
    free(is_on_boundary);
    return done ? 0 : -1;
}

/** Number the variables: dim for each node of an element that is not on the boundary. */
static int number_variables(problem *p) {
    const planish_mesh *mesh = &p->mesh;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        p->variable[i] = -1;
    for (int64_t k = 0; k < mesh->n_elements * (mesh->dim + 1); k++)
        p->variable[mesh->elements[k]] = 0;
    if (mark_boundary(mesh, p->variable))
        return -1;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        if (p->variable[i] == 0) {
            p->variable[i] = p->n_variables;
            p->n_variables += mesh->dim;
        }
    return 0;
}

/* ---- Making it ----------------------------------------------------------------------------- */

/** The variables of an element's vertices: places [return value] are indices among its dim (dim +
 * 1) coordinates, variables the numbers there. */
static int variables_of(const problem *p, int64_t element, int places[VERTEX_VARIABLES],
                        int variables[VERTEX_VARIABLES]) {
    int dim = p->mesh.dim, n = 0;
    for (int j = 0; j <= dim; j++) {
        int first = p->variable[p->mesh.elements[element * (dim + 1) + j]];
        for (int d = 0; d < dim && first >= 0; d++) {
            places[n] = dim * j + d;
            variables[n++] = first + d;
        }
    }
    return n;
}

static double constraint_square(const problem *p, int64_t element) {
    double g = p->delta > 0 ? 1 - volume_at(p, element) / p->delta : 0;
    return g * g;
}

/** List the movable elements, count triplets, and sum up what cannot change. */
static int sort_elements(problem *p) {
    for (int64_t k = 0; k < p->mesh.n_elements; k++) {
        int places[VERTEX_VARIABLES], variables[VERTEX_VARIABLES];
        int n = variables_of(p, k, places, variables);
        if (determinant_at(p, k) <= 0)
            return -1;
        if (n == 0) {
            p->fixed_ratios += ratio_at(p, k);
            p->fixed_constraints += constraint_square(p, k);
            continue;
        }
        p->movable[p->n_movable++] = (int)k;
        p->n_jacobian += n;
        p->n_hessian += n * (n + 1) / 2;
    }
    return 0;
}

static double domain_volume(const problem *p) {
    double sum = 0;
    for (int64_t k = 0; k < p->mesh.n_elements; k++)
        sum += volume_at(p, k);
    return sum;
}

int problem_create(problem *p, planish_mesh mesh, double *coordinates, double fraction,
                   double area_weight) {
    *p = (problem){.mesh = mesh, .coordinates = coordinates, .area_weight = area_weight};
    p->variable = malloc((size_t)mesh.n_nodes * sizeof *p->variable);
    p->movable = malloc((size_t)mesh.n_elements * sizeof *p->movable);
    p->delta = fraction * domain_volume(p);
    if (p->variable && p->movable && !number_variables(p) && !sort_elements(p))
        return 0;
    problem_destroy(p);
    return -1;
}

void problem_destroy(problem *p) {
    free(p->variable);
    free(p->movable);
    p->variable = p->movable = NULL;
}

/* ---- Variables ----------------------------------------------------------------------------- */

void problem_get_variables(const problem *p, double x[]) {
    int dim = p->mesh.dim;
    for (int64_t i = 0; i < p->mesh.n_nodes; i++)
        for (int d = 0; d < dim && p->variable[i] >= 0; d++)
            x[p->variable[i] + d] = p->coordinates[dim * i + d];
}

void problem_set_variables(problem *p, const double x[]) {
    int dim = p->mesh.dim;
    for (int64_t i = 0; i < p->mesh.n_nodes; i++)
        for (int d = 0; d < dim && p->variable[i] >= 0; d++)
            p->coordinates[dim * i + d] = x[p->variable[i] + d];
}

/* ---- Objective ----------------------------------------------------------------------------- */

/** f1 and f2, or -1 where an element is not positive. */
static int criteria(const problem *p, double *f1, double *f2) {
    double ratios = p->fixed_ratios, constraints = p->fixed_constraints;
    for (int m = 0; m < p->n_movable; m++) {
        if (!(determinant_at(p, p->movable[m]) > 0))
            return -1;
        ratios += ratio_at(p, p->movable[m]);
        if (p->area_weight > 0)
            constraints += constraint_square(p, p->movable[m]);
    }
    *f1 = sqrt(ratios / (double)p->mesh.n_elements);
    *f2 = sqrt(constraints / (double)p->mesh.n_elements);
    return 0;
}

int problem_objective(const problem *p, double *value) {
    double f1, f2;
    if (criteria(p, &f1, &f2))
        return -1;
    *value = p->area_weight > 0 ? (1 - p->area_weight) * f1 + p->area_weight * f2 : f1 * f1;
    return 0;
}

double problem_f(const problem *p) {
    double value;
    if (problem_objective(p, &value))
        return -1;
    return p->area_weight > 0 ? value : sqrt(value);
}

/** gradient += weight times what an element's function has for its vertices. */
static void scatter(const problem *p, int64_t element, double weight, const of_vertices *f,
                    double gradient[]) {
    int places[VERTEX_VARIABLES], variables[VERTEX_VARIABLES];
    int n = variables_of(p, element, places, variables);
    for (int i = 0; i < n; i++)
        gradient[variables[i]] += weight * f->gradient[places[i]];
}

int problem_gradient(const problem *p, double gradient[]) {
    double f1, f2, of_ratio = 1 / (double)p->mesh.n_elements, of_constraint = 0;
    if (criteria(p, &f1, &f2))
        return -1;
    if (p->area_weight > 0) {
        of_constraint = -p->area_weight * of_ratio / f2 * volume_scale(p);
        of_ratio *= (1 - p->area_weight) / (2 * f1);
    }
    memset(gradient, 0, (size_t)p->n_variables * sizeof *gradient);
    for (int m = 0; m < p->n_movable; m++) {
        int64_t k = p->movable[m];
        const of_vertices ratio = ratio_gradient(p, k);
        scatter(p, k, of_ratio, &ratio, gradient);
        if (p->area_weight > 0) {
            const of_vertices d = determinant_derivatives(p, k);
            scatter(p, k, of_constraint * (1 - volume_at(p, k) / p->delta), &d, gradient);
        }
    }
    return 0;
}

/* ---- Constraints and second derivatives ---------------------------------------------------- */

void problem_constraints(const problem *p, double value[]) {
    for (int m = 0; m < p->n_movable; m++)
        value[m] = volume_at(p, p->movable[m]) / p->delta;
}

void problem_jacobian_places(const problem *p, int row[], int column[]) {
    int entry = 0, places[VERTEX_VARIABLES], variables[VERTEX_VARIABLES];
    for (int m = 0; m < p->n_movable; m++) {
        int n = variables_of(p, p->movable[m], places, variables);
        for (int i = 0; i < n; i++, entry++) {
            row[entry] = m;
            column[entry] = variables[i];
        }
    }
}

void problem_jacobian(const problem *p, double entry[]) {
    int places[VERTEX_VARIABLES], variables[VERTEX_VARIABLES];
    for (int m = 0; m < p->n_movable; m++) {
        const of_vertices d = determinant_derivatives(p, p->movable[m]);
        int n = variables_of(p, p->movable[m], places, variables);
        for (int i = 0; i < n; i++)
            *entry++ = d.gradient[places[i]] * volume_scale(p);
    }
}

void problem_hessian_places(const problem *p, int row[], int column[]) {
    int entry = 0, places[VERTEX_VARIABLES], variables[VERTEX_VARIABLES];
    for (int m = 0; m < p->n_movable; m++) {
        int n = variables_of(p, p->movable[m], places, variables);
        for (int i = 0; i < n; i++)
            for (int j = 0; j <= i; j++, entry++) {
                int a = variables[i], b = variables[j];
                row[entry] = a > b ? a : b;
                column[entry] = a > b ? b : a;
            }
    }
}

void problem_hessian(const problem *p, double factor, const double multiplier[], double entry[]) {
    int places[VERTEX_VARIABLES], variables[VERTEX_VARIABLES];
    double mean = factor / (double)p->mesh.n_elements;
    for (int m = 0; m < p->n_movable; m++) {
        const of_vertices ratio = ratio_hessian(p, p->movable[m]);
        const of_vertices d = determinant_derivatives(p, p->movable[m]);
        double of_d = p->delta > 0 ? multiplier[m] * volume_scale(p) : 0;
        int n = variables_of(p, p->movable[m], places, variables);
        for (int i = 0; i < n; i++)
            for (int j = 0; j <= i; j++)
                *entry++ = mean * ratio.hessian[places[i]][places[j]] +
                           of_d * d.hessian[places[i]][places[j]];
    }
}
