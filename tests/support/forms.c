#include "support/forms.h"

#include "support/meshes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- where it is ------------------------------------------------------------------------------
 */

void test_problem_scale(test_problem *p, int exponent) {
    const int dim = p->mesh.dim;
    for (int64_t i = 0; i < p->mesh.n_nodes * dim; i++) {
        p->coordinates[i] = ldexp(p->coordinates[i], exponent);
        p->lower[i] = ldexp(p->lower[i], exponent);
        p->upper[i] = ldexp(p->upper[i], exponent);
    }
    for (int64_t i = 0; i < p->mesh.n_elements; i++)
        p->min_volume[i] = ldexp(p->min_volume[i], dim * exponent);
    for (int d = 0; d < 3; d++) {
        p->options.box_lower[d] = ldexp(p->options.box_lower[d], exponent);
        p->options.box_upper[d] = ldexp(p->options.box_upper[d], exponent);
    }
    p->options.min_volume = ldexp(p->options.min_volume, dim * exponent);
    p->options.max_displacement = ldexp(p->options.max_displacement, exponent);
}

void test_problem_move(test_problem *p, double factor, double shift) {
    const int dim = p->mesh.dim;
    for (int64_t i = 0; i < p->mesh.n_nodes * dim; i++) {
        p->coordinates[i] = p->coordinates[i] * factor + shift;
        p->lower[i] = p->lower[i] * factor + shift;
        p->upper[i] = p->upper[i] * factor + shift;
    }
    for (int64_t i = 0; i < p->mesh.n_elements; i++)
        for (int d = 0; d < dim; d++) /* one by one: 0 stays 0 */
            p->min_volume[i] *= factor;
    for (int d = 0; d < 3; d++) {
        p->options.box_lower[d] = p->options.box_lower[d] * factor + shift;
        p->options.box_upper[d] = p->options.box_upper[d] * factor + shift;
    }
    for (int d = 0; d < dim; d++)
        p->options.min_volume *= factor;
    p->options.max_displacement *= factor;
}

static void turn(double *x, int dim, const int *axis, const int *sign) {
    double old[3];
    memcpy(old, x, (size_t)dim * sizeof *x);
    for (int d = 0; d < dim; d++)
        x[d] = sign[d] * old[axis[d]];
}

/** Lower bounds become upper ones where the sign changes. */
static void turn_bounds(double *lower, double *upper, int dim, const int *axis, const int *sign) {
    turn(lower, dim, axis, sign);
    turn(upper, dim, axis, sign);
    for (int d = 0; d < dim; d++)
        if (sign[d] < 0) {
            const double low = upper[d];
            upper[d] = lower[d];
            lower[d] = low;
        }
}

void test_problem_turn_axes(test_problem *p, const int *axis, const int *sign) {
    const int dim = p->mesh.dim;
    for (int64_t i = 0; i < p->mesh.n_nodes; i++) {
        turn(p->coordinates + i * dim, dim, axis, sign);
        turn(p->direction + i * dim, dim, axis, sign);
        turn_bounds(p->lower + i * dim, p->upper + i * dim, dim, axis, sign);
    }
    turn_bounds(p->options.box_lower, p->options.box_upper, dim, axis, sign);
}

static void rotate(double *x, int i, int j, double angle) {
    const double a = x[i], b = x[j];
    x[i] = cos(angle) * a - sin(angle) * b;
    x[j] = sin(angle) * a + cos(angle) * b;
}

void test_problem_rotate(test_problem *p) {
    const int dim = p->mesh.dim;
    for (int64_t i = 0; i < 2 * p->mesh.n_nodes; i++) {
        double *x = (i % 2 ? p->direction : p->coordinates) + i / 2 * dim;
        rotate(x, 0, 1, 0.7);
        if (dim == 3) {
            rotate(x, 1, 2, 1.1);
            rotate(x, 2, 0, 2.3);
        }
    }
}

/* ---- how it is numbered -----------------------------------------------------------------------
 */

static int32_t *permutation(int64_t n, unsigned *state) {
    int32_t *place = calloc((size_t)n + 1, sizeof *place);
    for (int64_t i = 0; i < n; i++) {
        const int64_t j = (int64_t)(test_random(state) * (double)(i + 1));
        place[i] = place[j];
        place[j] = (int32_t)i;
    }
    return place;
}

/** Row i of array goes to row place[i]. */
static void put(void *array, size_t row, int64_t n, const int32_t *place) {
    char *old = malloc((size_t)n * row + 1), *now = array;
    memcpy(old, array, (size_t)n * row);
    for (int64_t i = 0; i < n; i++)
        memcpy(now + (size_t)place[i] * row, old + (size_t)i * row, row);
    free(old);
}

void test_problem_renumber_nodes(test_problem *p, unsigned seed) {
    const int dim = p->mesh.dim;
    const int64_t n = p->mesh.n_nodes;
    const size_t row = (size_t)dim * sizeof(double);
    int32_t *place = permutation(n, &seed);
    put(p->coordinates, row, n, place);
    put(p->direction, row, n, place);
    put(p->lower, row, n, place);
    put(p->upper, row, n, place);
    put(p->constraint, 1, n, place);
    for (int64_t i = 0; i < p->mesh.n_elements * (dim + 1); i++)
        p->elements[i] = place[p->elements[i]];
    for (int64_t i = 0; i < 2 * p->mesh.n_periodic; i++)
        p->periodic[i] = place[p->periodic[i]];
    for (int i = 0; i < 2; i++)
        p->around[i] = place[p->around[i]];
    for (int64_t i = 0; i < n; i++)
        p->node_now[i] = place[p->node_now[i]];
    free(place);
}

void test_problem_renumber_elements(test_problem *p, unsigned seed) {
    const int64_t m = p->mesh.n_elements;
    int32_t *place = permutation(m, &seed);
    put(p->elements, (size_t)(p->mesh.dim + 1) * sizeof(int32_t), m, place);
    put(p->min_volume, sizeof(double), m, place);
    for (int64_t i = 0; i < m; i++)
        p->element_now[i] = place[p->element_now[i]];
    free(place);
}

static void exchange(int32_t *corner, int i, int j) {
    const int32_t first = corner[i];
    corner[i] = corner[j];
    corner[j] = first;
}

void test_problem_turn_corners(test_problem *p, int only_even, unsigned seed) {
    const int dim = p->mesh.dim;
    for (int64_t i = 0; i < p->mesh.n_elements; i++) {
        int32_t *corner = p->elements + i * (dim + 1);
        int exchanges = 0;
        for (int j = dim; j > 0; j--) {
            const int k = (int)(test_random(&seed) * (j + 1));
            exchange(corner, j, k);
            exchanges += j != k;
        }
        if (only_even && exchanges % 2)
            exchange(corner, 0, 1);
    }
}

void test_problem_reverse(test_problem *p) {
    for (int64_t i = 0; i < p->mesh.n_elements; i++)
        exchange(p->elements + i * (p->mesh.dim + 1), 0, 1);
}

/* ---- the forms --------------------------------------------------------------------------------
 */

static void axes(test_problem *p, unsigned seed) {
    static const int two[] = {1, 0}, three[] = {1, 2, 0}, sign[] = {1, 1, 1};
    (void)seed;
    test_problem_turn_axes(p, p->mesh.dim == 3 ? three : two, sign);
}

/** One of the 48 symmetries of a box, or of the 8 of a rectangle. */
static void symmetry(test_problem *p, unsigned seed) {
    int32_t *place = permutation(p->mesh.dim, &seed);
    int axis[3] = {0, 0, 0}, sign[3];
    for (int d = 0; d < 3; d++) {
        axis[d] = d < p->mesh.dim ? place[d] : 0;
        sign[d] = test_random(&seed) < 0.5 ? -1 : 1;
    }
    test_problem_turn_axes(p, axis, sign);
    free(place);
}

static void mirror(test_problem *p, unsigned seed) {
    static const int axis[] = {0, 1, 2}, sign[] = {-1, 1, 1};
    (void)seed;
    test_problem_turn_axes(p, axis, sign);
}

static void mirror_positive(test_problem *p, unsigned seed) {
    mirror(p, seed);
    test_problem_reverse(p);
}

static void reverse(test_problem *p, unsigned seed) {
    (void)seed;
    test_problem_reverse(p);
}

static void even_corners(test_problem *p, unsigned seed) {
    test_problem_turn_corners(p, 1, seed);
}

static void any_corners(test_problem *p, unsigned seed) {
    test_problem_turn_corners(p, 0, seed);
}

static void renumber(test_problem *p, unsigned seed) {
    test_problem_renumber_nodes(p, seed);
    test_problem_renumber_elements(p, seed + 1);
}

static void shift(test_problem *p, unsigned seed) {
    (void)seed;
    test_problem_move(p, 1, -0x1p20);
}

static void thirds(test_problem *p, unsigned seed) {
    (void)seed;
    test_problem_move(p, 1.0 / 3, 0);
}

static void far_away(test_problem *p, unsigned seed) {
    (void)seed;
    test_problem_move(p, 1e-3, 1e6);
}

static void rotated(test_problem *p, unsigned seed) {
    (void)seed;
    test_problem_rotate(p);
}

static void everything(test_problem *p, unsigned seed) {
    rotated(p, seed);
    symmetry(p, seed);
    thirds(p, seed);
    renumber(p, seed);
    any_corners(p, seed);
}

const test_form test_forms[] = {
    {"axes", FORM_RENAMED, axes},
    {"symmetry", FORM_RENAMED, symmetry},
    {"mirrored", FORM_RENAMED, mirror},
    {"mirrored, positive", FORM_RENAMED, mirror_positive},
    {"reversed", FORM_RENAMED, reverse},
    {"even corners", FORM_RENAMED, even_corners},
    {"any corners", FORM_RENAMED, any_corners},
    {"nodes", FORM_RENAMED, test_problem_renumber_nodes},
    {"elements", FORM_RENAMED, test_problem_renumber_elements},
    {"both", FORM_RENAMED, renumber},
    {"shifted", FORM_SHIFTED, shift},
    {"by thirds", FORM_ROUNDED, thirds},
    {"rotated", FORM_ROUNDED, rotated},
    {"everything", FORM_ROUNDED, everything},
    {"far away", FORM_FAR, far_away},
    {0},
};

int test_form_suits(const test_form *form, test_wish wish) {
    const int turns = form->apply == rotated || form->apply == everything;
    if (wish == WISH_BOUNDS && turns)
        return 0;
    return wish != WISH_FLOAT || form->kind == FORM_RENAMED;
}
