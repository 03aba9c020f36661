/* planish_fit: blocks of tetrahedra and hexahedra are brought onto spheres and cylinders of other triangles,
 * and judged by samples. */
#include "support/blocks.h"
#include "support/effort.h"
#include "support/run.h"
#include "support/sheets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- judges ---------------------------------------------------------------------------------- */

/** Distance of x from the form of size 1. */
static double off_form(block_form f, const double x[3]) {
    const double r = sqrt(x[0] * x[0] + x[1] * x[1]);
    if (f == BLOCK_BALL)
        return fabs(sqrt(r * r + x[2] * x[2]) - 1);
    if (fabs(x[2]) > 1 || r > 1)
        return hypot(fmax(r - 1, 0), fmax(fabs(x[2]) - 1, 0));
    return fmin(1 - r, 1 - fabs(x[2]));
}

static double det(const double *a, const double *b, const double *c) {
    return a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
}

/** det J of a hexahedron at p, in 0 .. 1. */
static double hex_jacobian(const double *x, const int32_t *node, const double p[3]) {
    static const uint8_t AT[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                     {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
    double j[3][3] = {{0}};
    for (int c = 0; c < 8; c++)
        for (int d = 0; d < 3; d++) {
            double weight = AT[c][d] ? 1 : -1;
            for (int e = 0; e < 3; e++)
                weight *= e == d ? 1 : AT[c][e] ? p[e] : 1 - p[e];
            for (int e = 0; e < 3; e++)
                j[d][e] += weight * x[3 * (int64_t)node[c] + e];
        }
    return det(j[0], j[1], j[2]);
}

/** Number of elements of which a sample of det J is not positive. */
static int64_t count_inverted(const planish_mesh *mesh, const double *x) {
    enum { STEPS = 4 };
    int64_t n = 0;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int32_t *node = mesh->cells ? mesh->cells->node + 8 * i : mesh->elements + 4 * i;
        double least = INFINITY;
        for (int at = 0; mesh->cells && at < (STEPS + 1) * (STEPS + 1) * (STEPS + 1); at++) {
            const double p[3] = {at % (STEPS + 1) / (double)STEPS,
                                 at / (STEPS + 1) % (STEPS + 1) / (double)STEPS,
                                 at / (STEPS + 1) / (STEPS + 1) / (double)STEPS};
            least = fmin(least, hex_jacobian(x, node, p));
        }
        double v[3][3];
        for (int k = 0; k < 3 && !mesh->cells; k++)
            for (int d = 0; d < 3; d++)
                v[k][d] = x[3 * (int64_t)node[k + 1] + d] - x[3 * (int64_t)node[0] + d];
        if (!mesh->cells)
            least = det(v[0], v[1], v[2]);
        n += !(least > 0);
    }
    return n;
}

/** Largest distance of nodes of the surface from a form. */
static double farthest_node(const block *b, block_form f, const double *x) {
    double most = 0;
    uint8_t *class_of = malloc((size_t)b->mesh.n_nodes);
    planish_shape_get_classes(b->shape, class_of);
    for (int64_t i = 0; i < b->mesh.n_nodes; i++)
        if (class_of[i] != PLANISH_SHAPE_NONE)
            most = fmax(most, off_form(f, x + 3 * i));
    free(class_of);
    return most;
}

/* ---- tests ----------------------------------------------------------------------------------- */

/** A fit, its result, and what smoothing then made of it. */
typedef struct outcome {
    planish_fit_info before, after;
    double *x, *smoothed;
    planish_shape_distance distance;
} outcome;

static void fit(block *b, const block_target *onto, double reach, const planish_options *options,
                outcome *o) {
    planish_fit *f;
    planish_plan *plan;
    planish_error error = {.text = ""};
    planish_options smoothing = *options;
    uint8_t *constraint = calloc((size_t)b->mesh.n_nodes, 1);
    planish_mesh mesh = b->mesh;
    o->x = test_copy_of(&b->mesh);
    if (planish_fit_create(&b->mesh, b->shape, onto->shape, reach, options, &f, &o->before,
                           &error) ||
        planish_fit_move(f, &b->mesh, o->x, options, &o->after, &error))
        fail_msg("%s", error.text);
    mesh.coordinates = o->x;
    o->smoothed = test_copy_of(&mesh);
    planish_fit_constrain(f, constraint);
    mesh.constraint = constraint;
    smoothing.project = planish_fit_project;
    smoothing.project_user = f;
    smoothing.progress = NULL;
    if (planish_plan_create(&mesh, &smoothing, &plan, &error) ||
        planish_smooth(plan, o->smoothed, &smoothing, NULL, &error))
        fail_msg("%s", error.text);
    mesh.coordinates = o->smoothed;
    if (planish_fit_measure(f, &mesh, &o->distance, &error))
        fail_msg("%s", error.text);
    planish_plan_destroy(plan);
    planish_fit_destroy(f);
    free(constraint);
}

static void free_outcome(outcome *o) {
    free(o->x);
    free(o->smoothed);
}

static void say(const char *what, const block *b, const outcome *o) {
    const int64_t n_inverted = count_inverted(&b->mesh, b->given);
    figure("%s: %d inverted; %d nodes on patches, %d on curves, %d at corners, %d out of reach, %d "
           "off by %.3g; "
           "after: %d "
           "off by %.3g; %.3g (%.3g h) there, %.3g (%.3g h) back",
           what, (int)n_inverted, (int)o->before.n_on_patch, (int)o->before.n_on_curve,
           (int)o->before.n_on_corner, (int)o->before.n_out_of_reach, (int)o->before.n_off,
           o->before.farthest, (int)o->after.n_off, o->after.farthest, o->distance.distance,
           o->distance.in_edges, o->distance.distance_back, o->distance.back_in_edges);
}

/** A block, a surface that it is fitted to, and the outcome. */
typedef struct fitted {
    block b;
    block_target fine;
    outcome o;
} fitted;

/** Fit the block, on one thread, and smooth it: nothing is inverted. */
static void fit_one(const char *what, double reach, fitted *t) {
    const planish_options options = test_options(1);
    fit(&t->b, &t->fine, reach, &options, &t->o);
    say(what, &t->b, &t->o);
    assert_int_equal(count_inverted(&t->b.mesh, t->o.x), 0);
    assert_int_equal(count_inverted(&t->b.mesh, t->o.smoothed), 0);
}

/** Make the block of n cubes along each side, of tetrahedra or hexahedra. */
static void make_fitted(int is_tets, block_form f, int n, double size, double shake, fitted *t) {
    uint64_t random = effort_seed(3);
    block_create(is_tets, BOX_HEXAHEDRA, f, n, size, shake, &random, &t->b);
}

static void free_fitted(fitted *t) {
    free_outcome(&t->o);
    block_destroy(&t->b);
    block_target_destroy(&t->fine);
}

static void test_ball(void **state) {
    (void)state;
    fitted t;
    make_fitted(1, BLOCK_BALL, 6, 0.95, 0.02, &t);
    block_target_create(BLOCK_BALL, 24, 1, 1, &t.fine);
    fit_one("ball of tetrahedra", 0, &t);
    assert_int_equal(t.o.after.n_off, 0);
    assert_true(farthest_node(&t.b, BLOCK_BALL, t.o.x) < 2e-3);
    assert_true(farthest_node(&t.b, BLOCK_BALL, t.o.smoothed) < 2e-3);
    free_fitted(&t);
}

static void test_cylinder(void **state) {
    (void)state;
    fitted t;
    make_fitted(0, BLOCK_CYLINDER, 6, 1, 0.02, &t);
    block_target_create(BLOCK_CYLINDER, 24, 1, 0, &t.fine);
    fit_one("cylinder of hexahedra", 0, &t);
    assert_int_equal(t.o.after.n_off, 0);
    assert_true(farthest_node(&t.b, BLOCK_CYLINDER, t.o.x) < 4e-3);
    free_fitted(&t);
}

/** Number of elements that are inverted if each node of the surface goes to the nearest point of a ball. */
static int64_t count_after_projection(const block *b, double radius) {
    double *x = test_copy_of(&b->mesh);
    uint8_t *class_of = malloc((size_t)b->mesh.n_nodes);
    planish_shape_get_classes(b->shape, class_of);
    for (int64_t i = 0; i < b->mesh.n_nodes; i++) {
        const double r =
            sqrt(x[3 * i] * x[3 * i] + x[3 * i + 1] * x[3 * i + 1] + x[3 * i + 2] * x[3 * i + 2]);
        for (int d = 0; d < 3 && class_of[i] != PLANISH_SHAPE_NONE; d++)
            x[3 * i + d] *= radius / r;
    }
    const int64_t n = count_inverted(&b->mesh, x);
    free(class_of);
    free(x);
    return n;
}

/** Plain projection inverts hexahedra: the fit does not, and comes as far. */
static void test_block_onto_ball(void **state) {
    (void)state;
    fitted t;
    make_fitted(0, BLOCK_CUBE, 6, 0.8, 0, &t);
    block_target_create(BLOCK_BALL, 16, 0.5, 0, &t.fine);
    fit_one("block onto a ball", 5, &t);
    assert_true(count_after_projection(&t.b, 0.5) > 0);
    assert_int_equal(t.o.after.n_off, 0);
    free_fitted(&t);
}

/** Nodes inside are held, and no more is possible than they allow. */
static void test_not_there(void **state) {
    (void)state;
    fitted t;
    make_fitted(0, BLOCK_CUBE, 6, 0.8, 0, &t);
    block_target_create(BLOCK_BALL, 16, 0.75, 0, &t.fine);
    uint8_t *constraint = malloc((size_t)t.b.mesh.n_nodes);
    uint8_t *class_of = malloc((size_t)t.b.mesh.n_nodes);
    planish_shape_get_classes(t.b.shape, class_of);
    for (int64_t i = 0; i < t.b.mesh.n_nodes; i++)
        constraint[i] =
            class_of[i] == PLANISH_SHAPE_NONE ? PLANISH_CONSTRAINT_FIXED : PLANISH_CONSTRAINT_FREE;
    t.b.mesh.constraint = constraint;
    fit_one("block whose inside is held", 5, &t);
    assert_true(t.o.after.n_off > 0 && t.o.after.n_off < t.o.before.n_off);
    assert_true(t.o.after.farthest > 0.1 && t.o.after.farthest < t.o.before.farthest);
    for (int64_t i = 0; i < t.b.mesh.n_nodes; i++)
        if (constraint[i] == PLANISH_CONSTRAINT_FIXED)
            assert_memory_equal(t.o.x + 3 * i, t.b.given + 3 * i, 3 * sizeof *t.o.x);
    /* The certificate knows of what is not there. */
    assert_true(t.o.distance.distance > 0.99 * t.o.after.farthest);
    assert_true(t.o.distance.distance_back > 0);
    free(constraint);
    free(class_of);
    free_fitted(&t);
}

/** Largest difference of nodes of the surface from where stretching and shifting the block takes them. */
static double off_affine(const block *b, const double *x, const double stretch[3],
                         const double shift[3]) {
    double most = 0;
    for (int64_t i = 0; i < 3 * b->mesh.n_nodes; i++) {
        const double *at = b->given + i / 3 * 3;
        const int is_at_corner =
            fabs(at[0]) > 0.999 && fabs(at[1]) > 0.999 && fabs(at[2]) > b->given[2] * -0.999;
        if (is_at_corner)
            most = fmax(most, fabs(x[i] - b->given[i] * stretch[i % 3] - shift[i % 3]));
    }
    return most;
}

/** Corners go with the edges that end there, though one of these goes on through them. */
static void test_stretched(void **state) {
    (void)state;
    const double none[3] = {0, 0, 0};
    for (int i = 1; i < 4; i++) {
        const double stretch[3] = {1, i == 3 ? 1.15 : 1, 1 + 0.1 * i};
        fitted t;
        make_fitted(1, BLOCK_CUBE, 6, 1, 0, &t);
        block_target_create(BLOCK_CUBE, 1, 1, 0, &t.fine);
        block_target_place(&t.fine, stretch, none);
        fit_one("cube that is stretched", 0, &t);
        assert_int_equal(t.o.before.n_on_corner, 8);
        assert_int_equal(t.o.before.n_cut, 0);
        assert_int_equal(t.o.after.n_off, 0);
        assert_true(off_affine(&t.b, t.o.smoothed, stretch, none) < 1e-12);
        free_fitted(&t);
    }
}

/** A flat ball goes to one beside it that its upper nodes meet from the wrong side, whichever way its facets turn. The
 *  lower nodes are held. */
static void test_flat(void **state) {
    (void)state;
    const double stretch[3] = {1, 1, 0.15}, shift[3] = {0, 0, 0.24};
    for (int is_turned = 0; is_turned < 2; is_turned++) {
        fitted t;
        double highest = 0;
        make_fitted(1, BLOCK_BALL, 6, 1, 0, &t);
        block_stretch(&t.b, stretch);
        uint8_t *constraint = calloc((size_t)t.b.mesh.n_nodes, 1);
        for (int64_t i = 0; i < t.b.mesh.n_nodes; i++)
            constraint[i] = t.b.given[3 * i + 2] < 0;
        t.b.mesh.constraint = constraint;
        block_target_create(BLOCK_BALL, 6, 1, is_turned, &t.fine);
        block_target_place(&t.fine, stretch, shift);
        fit_one("flat ball", 0, &t);
        for (int64_t i = 0; i < t.b.mesh.n_nodes; i++)
            highest = fmax(highest, t.o.x[3 * i + 2]);
        assert_true(highest > 0.38);
        free(constraint);
        free_fitted(&t);
    }
}

/** Rims and corners of a thin plate keep their sides, though the other ones are nearer. */
static void test_plate(void **state) {
    (void)state;
    const double stretch[3] = {1, 1, 0.1};
    for (int i = 0; i < 4; i++) {
        const double shift[3] = {0, 0, i % 2 ? 0.12 : 0.17};
        fitted t;
        make_fitted(i < 2, BLOCK_CUBE, 6, 1, 0, &t);
        block_stretch(&t.b, stretch);
        block_target_create(BLOCK_CUBE, 2, 1, i < 2, &t.fine);
        block_target_place(&t.fine, stretch, shift);
        fit_one("thin plate", 0, &t);
        assert_int_equal(t.o.before.n_on_corner, 8);
        assert_int_equal(t.o.before.n_on_curve, 12 * 5);
        assert_true(t.o.before.farthest < shift[2] + 1e-12);
        free_fitted(&t);
    }
}

/** Sizes of which squares are no numbers change nothing but the unit. */
static void test_units(void **state) {
    (void)state;
    const double unit[] = {1, 0x1p-540, 0x1p600}, none[3] = {0, 0, 0};
    planish_fit_info info[3];
    for (int i = 0; i < 3; i++) {
        fitted t;
        planish_fit *f;
        const double stretch[3] = {unit[i], unit[i], unit[i]};
        make_fitted(1, BLOCK_BALL, 4, 0.95, 0, &t);
        block_stretch(&t.b, stretch);
        block_target_create(BLOCK_BALL, 8, 1, 0, &t.fine);
        block_target_place(&t.fine, stretch, none);
        assert_int_equal(
            planish_fit_create(&t.b.mesh, t.b.shape, t.fine.shape, 0, NULL, &f, &info[i], NULL), 0);
        info[i].farthest /= unit[i];
        assert_memory_equal(&info[i], &info[0], sizeof *info);
        planish_fit_destroy(f);
        block_destroy(&t.b);
        block_target_destroy(&t.fine);
    }
    assert_true(info[0].n_off > 0 && info[0].farthest > 0.01);
}

/** Make a roof of a cube: both upper edges along x are one. */
static void make_roof(block_target *s) {
    block_target_create(BLOCK_CUBE, 1, 1, 0, s);
    const int32_t *v = s->node;
    int64_t n = 0;
    for (int64_t i = 0; i < 3 * s->cells.n; i++)
        for (int32_t k = 0; k < s->mesh.n_nodes; k++) {
            const double *x = s->x + 3 * (int64_t)v[i], *y = s->x + 3 * (int64_t)k;
            if (x[2] > 0 && x[1] < 0 && y[2] > 0 && y[1] > 0 && y[0] == x[0])
                s->node[i] = k;
        }
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        s->x[3 * i + 1] *= s->x[3 * i + 2] < 0;
    for (int64_t i = 0; i < s->cells.n; i++)
        if (v[3 * i] != v[3 * i + 1] && v[3 * i] != v[3 * i + 2] && v[3 * i + 1] != v[3 * i + 2])
            memmove(s->node + 3 * n++, v + 3 * i, 3 * sizeof *v);
    s->cells.n = s->mesh.n_elements = n;
    block_target_place(s, (const double[3]){1, 1, 1}, (const double[3]){0, 0, 0});
}

/** Corners that are left over are counted. */
static void test_cut(void **state) {
    (void)state;
    fitted t;
    make_fitted(1, BLOCK_CUBE, 6, 1, 0, &t);
    make_roof(&t.fine);
    fit_one("cube onto a roof", 4, &t);
    assert_int_equal(t.o.before.n_on_corner, 6);
    assert_int_equal(t.o.before.n_cut, 2);
    free_fitted(&t);
}

/** Whether no other tetrahedron has the facet that is opposite to a corner. */
static int is_boundary(const planish_mesh *mesh, int64_t element, int corner) {
    const int32_t *node = mesh->elements + 4 * element;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int32_t *other = mesh->elements + 4 * i;
        int n = 0;
        for (int k = 0; k < 16; k++)
            n += k / 4 != corner && node[k / 4] == other[k % 4];
        if (i != element && n == 3)
            return 0;
    }
    return 1;
}

/** The distance is not below samples of it, nor far above. */
static void test_certificate(void **state) {
    (void)state;
    fitted t;
    make_fitted(1, BLOCK_BALL, 5, 0.95, 0.02, &t);
    block_target_create(BLOCK_BALL, 32, 1, 0, &t.fine);
    fit_one("ball whose bound is sampled", 0, &t);
    uint64_t random = effort_seed(5);
    const double sag = 2e-3; /* of the other surface, at most */
    double most = 0;
    for (int64_t i = 0; i < 4 * t.b.mesh.n_elements; i++) {
        const int32_t *node = t.b.mesh.elements + i / 4 * 4;
        for (int n = 0; n < 50 && is_boundary(&t.b.mesh, i / 4, (int)(i % 4)); n++) {
            double w[3] = {random_unit(&random), random_unit(&random), random_unit(&random)};
            double square = 0;
            for (int d = 0; d < 3; d++) {
                double x = 0;
                for (int k = 0; k < 3; k++)
                    x += w[k] / (w[0] + w[1] + w[2]) *
                         t.o.smoothed[3 * (int64_t)node[(i % 4 + 1 + k) % 4] + d];
                square += x * x;
            }
            most = fmax(most, fabs(1 - sqrt(square)));
        }
    }
    figure("certificate: %.4g sampled, %.4g bound", most, t.o.distance.distance);
    assert_true(most < t.o.distance.distance + sag);
    assert_true(most > 0.8 * t.o.distance.distance);
    free_fitted(&t);
}

/** A point of a triangle of order 2 at weights w of its corners. */
static void curved_point(const double *x, const int32_t *node, const double w[3], double p[3]) {
    memset(p, 0, 3 * sizeof *p);
    for (int k = 0; k < 3; k++)
        for (int d = 0; d < 3; d++)
            p[d] += w[k] * (2 * w[k] - 1) * x[3 * (int64_t)node[k] + d] +
                    4 * w[k] * w[(k + 1) % 3] * x[3 * (int64_t)node[3 + k] + d];
}

/** Facets of order 2 of the other surface are curved where distances are proved: here the mesh has their nodes, and
 *  is off between these alone. */
static void test_curved_other(void **state) {
    (void)state;
    enum { STEPS = 12 };
    fitted t;
    planish_fit *f;
    planish_shape_distance distance;
    make_fitted(1, BLOCK_BALL, 2, 1, 0, &t);
    block_target_create_curved(BLOCK_BALL, 1, &t.fine);
    assert_int_equal(
        planish_fit_create(&t.b.mesh, t.b.shape, t.fine.shape, 0, NULL, &f, NULL, NULL), 0);
    assert_int_equal(planish_fit_measure(f, &t.b.mesh, &distance, NULL), 0);
    const planish_shape *s = t.b.shape;
    sheet_judge judge = sheet_judge_create(s, (const double(*)[3])s->x);
    double most = 0;
    for (int i = 0; i < 12 * STEPS * STEPS; i++) {
        const double u = (double)(i % STEPS) / STEPS, v = (double)(i / STEPS % STEPS) / STEPS;
        const double w[3] = {u * (1 - v), (1 - u) * (1 - v), v};
        double p[3];
        curved_point(t.fine.x, t.fine.node + 6 * (i / (STEPS * STEPS)), w, p);
        for (int d = 0; d < 3; d++)
            p[d] *= s->scale;
        most = fmax(most, sheet_judge_distance(&judge, -1, p) / s->scale);
    }
    figure("a curved surface: %.4g sampled, %.4g bound", most, distance.distance_back);
    assert_true(most > 0.01 && most <= distance.distance_back);
    assert_true(most <= distance.distance);
    sheet_judge_destroy(&judge);
    planish_fit_destroy(f);
    block_destroy(&t.b);
    block_target_destroy(&t.fine);
}

/** The bits are the same for two threads. */
static void test_threads(void **state) {
    (void)state;
    for (int is_tets = 0; is_tets < 2; is_tets++) {
        block b;
        block_target fine;
        outcome o[2];
        block_create(is_tets, BOX_HEXAHEDRA, is_tets ? BLOCK_BALL : BLOCK_CUBE, 6, 0.8, 0.02,
                     &(uint64_t){effort_seed(3)}, &b);
        block_target_create(BLOCK_BALL, 16, 0.6, 0, &fine);
        for (int i = 0; i < 2; i++) {
            const planish_options options = test_options(i + 1);
            fit(&b, &fine, 5, &options, &o[i]);
        }
        assert_memory_equal(o[0].x, o[1].x, test_bytes_of(&b.mesh));
        assert_memory_equal(o[0].smoothed, o[1].smoothed, test_bytes_of(&b.mesh));
        assert_memory_equal(&o[0].distance, &o[1].distance, sizeof o[0].distance);
        assert_memory_equal(&o[0].after, &o[1].after, sizeof o[0].after);
        free_outcome(&o[0]);
        free_outcome(&o[1]);
        block_destroy(&b);
        block_target_destroy(&fine);
    }
}

/** Sizes are those of the mesh before it was fitted, whether reference says so or not. */
static void test_sizes(void **state) {
    (void)state;
    block b;
    block_target fine;
    planish_fit *f;
    planish_error error = {.text = ""};
    planish_options options = test_options(1);
    double *x[2];
    options.size_weight = 0.9;
    block_create(0, BOX_HEXAHEDRA, BLOCK_CUBE, 6, 0.8, 0.02, &(uint64_t){effort_seed(3)}, &b);
    block_target_create(BLOCK_BALL, 16, 0.6, 0, &fine);
    planish_mesh mesh = b.mesh;
    double *size = calloc((size_t)mesh.n_nodes, sizeof *size), *start = test_copy_of(&mesh);
    assert_int_equal(planish_find_sizes(&mesh, 1, size, &error), 0);
    mesh.size = size;
    for (int i = 0; i < 2; i++) {
        mesh.reference = i ? start : NULL;
        x[i] = test_copy_of(&mesh);
        if (planish_fit_create(&mesh, b.shape, fine.shape, 5, &options, &f, NULL, &error) ||
            planish_fit_move(f, &mesh, x[i], &options, NULL, &error))
            fail_msg("%s", error.text);
        planish_fit_destroy(f);
    }
    assert_memory_equal(x[0], x[1], test_bytes_of(&mesh));
    assert_memory_not_equal(x[0], start, test_bytes_of(&mesh));
    free(x[0]);
    free(x[1]);
    free(size);
    free(start);
    block_destroy(&b);
    block_target_destroy(&fine);
}

static int stop_soon(const planish_progress *progress, void *left) {
    (void)progress;
    return --*(int *)left <= 0;
}

/** Whenever it is stopped, what it hands out is valid. */
static void test_stop(void **state) {
    (void)state;
    block b;
    block_target fine;
    block_create(0, BOX_HEXAHEDRA, BLOCK_CUBE, 5, 0.8, 0, &(uint64_t){effort_seed(3)}, &b);
    block_target_create(BLOCK_BALL, 16, 0.5, 0, &fine);
    for (int calls = 1; calls < 200; calls *= 6) {
        outcome o;
        int left = calls;
        planish_options options = test_options(1);
        options.progress = stop_soon;
        options.progress_user = &left;
        fit(&b, &fine, 5, &options, &o);
        assert_int_equal(count_inverted(&b.mesh, o.x), 0);
        free_outcome(&o);
    }
    block_destroy(&b);
    block_target_destroy(&fine);
}

/** A mesh on its way, and where it is after a sweep. */
typedef struct onway {
    const planish_mesh *mesh;
    double *const *fitted; /* the array that the call is given */
    double *x;
    int n_sweeps;
} onway;

static int look_at_sweep(const planish_progress *progress, void *user) {
    onway *on = user;
    if (!progress->sweep_done)
        return 0;
    memcpy(on->x, on->mesh->coordinates, test_bytes_of(on->mesh));
    assert_int_equal(planish_progress_get_coordinates(progress, *on->fitted, NULL),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_progress_get_coordinates(progress, on->x, NULL), 0);
    assert_int_equal(count_inverted(on->mesh, on->x), 0);
    on->n_sweeps++;
    return 0;
}

/** After each sweep the positions are those of a valid mesh; they are not written to the array that is
 *  fitted. */
static void test_positions(void **state) {
    (void)state;
    block b;
    block_target fine;
    outcome o;
    block_create(0, BOX_HEXAHEDRA, BLOCK_CUBE, 5, 0.8, 0, &(uint64_t){effort_seed(3)}, &b);
    block_target_create(BLOCK_BALL, 16, 0.5, 0, &fine);
    onway on = {.mesh = &b.mesh, .fitted = &o.x, .x = test_copy_of(&b.mesh)};
    planish_options options = test_options(1);
    options.progress = look_at_sweep;
    options.progress_user = &on;
    fit(&b, &fine, 5, &options, &o);
    assert_true(on.n_sweeps > 0);
    free(on.x);
    free_outcome(&o);
    block_destroy(&b);
    block_target_destroy(&fine);
}

/** Elements of 64 bits give the bits of those of 32. */
static void test_wide(void **state) {
    (void)state;
    fitted t;
    outcome o;
    const planish_options options = test_options(1);
    make_fitted(1, BLOCK_BALL, 3, 0.95, 0.02, &t);
    block_target_create(BLOCK_BALL, 8, 1, 0, &t.fine);
    fit(&t.b, &t.fine, 0, &options, &t.o);
    const int64_t n = 4 * t.b.mesh.n_elements;
    int64_t *wide = malloc((size_t)n * sizeof *wide);
    for (int64_t i = 0; i < n; i++)
        wide[i] = t.b.mesh.elements[i];
    t.b.mesh.elements = NULL;
    t.b.mesh.elements64 = wide;
    fit(&t.b, &t.fine, 0, &options, &o);
    assert_memory_equal(t.o.smoothed, o.smoothed, test_bytes_of(&t.b.mesh));
    assert_memory_equal(&t.o.distance, &o.distance, sizeof o.distance);
    free(wide);
    free_outcome(&o);
    free_fitted(&t);
}

/** Nodes are moved wherever they are: options.around means nothing. */
static void test_around(void **state) {
    (void)state;
    const int64_t node = 0;
    planish_options options = test_options(1);
    fitted t;
    outcome o;
    make_fitted(1, BLOCK_BALL, 3, 0.95, 0.02, &t);
    block_target_create(BLOCK_BALL, 8, 1, 0, &t.fine);
    fit(&t.b, &t.fine, 0, &options, &t.o);
    planish_fit *f;
    assert_int_equal(
        planish_fit_create(&t.b.mesh, t.b.shape, t.fine.shape, 0, NULL, &f, &o.before, NULL), 0);
    o.x = test_copy_of(&t.b.mesh);
    options.around = &node;
    options.n_around = 1;
    assert_int_equal(planish_fit_move(f, &t.b.mesh, o.x, &options, &o.after, NULL), 0);
    assert_memory_equal(t.o.x, o.x, test_bytes_of(&t.b.mesh));
    planish_fit_destroy(f);
    free(o.x);
    free_fitted(&t);
}

/** Move x, with options that are ignored: all nodes come to their places. */
static void move_again(planish_fit *f, const block *b, planish_precision precision, double *x) {
    planish_options options = test_options(1);
    planish_fit_info info;
    planish_error error;
    options.precision = precision;
    options.method = PLANISH_METHOD_LAPLACIAN;
    options.worst = PLANISH_WORST_ANGLE;
    options.max_sweeps = -1;
    if (planish_fit_move(f, &b->mesh, x, &options, &info, &error))
        fail_msg("%s", error.text);
    assert_int_equal(info.n_off, 0);
}

/** Smooth x along the other surface. Returns how many nodes of that have moved. */
static int64_t slide_along(planish_fit *f, const block *b, planish_precision precision, double *x) {
    planish_mesh mesh = b->mesh;
    uint8_t *constraint = calloc((size_t)mesh.n_nodes, 1);
    double *before = malloc(test_bytes_of(&mesh));
    planish_options options = test_options(1);
    planish_plan *plan;
    int64_t n = 0;
    planish_fit_constrain(f, constraint);
    memcpy(before, x, test_bytes_of(&mesh));
    mesh.coordinates = before;
    mesh.constraint = constraint;
    options.precision = precision;
    options.project = planish_fit_project;
    options.project_user = f;
    assert_int_equal(planish_plan_create(&mesh, &options, &plan, NULL), 0);
    assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
    for (int64_t i = 0; i < mesh.n_nodes; i++)
        n += constraint[i] == PLANISH_CONSTRAINT_ON_SURFACE &&
             memcmp(x + 3 * i, before + 3 * i, 3 * sizeof *x) != 0;
    planish_plan_destroy(plan);
    free(before);
    free(constraint);
    return n;
}

static void expect_again(int is_tets, block_form form, int n, planish_precision precision) {
    fitted t;
    planish_fit *f;
    planish_options options = test_options(1);
    options.precision = precision;
    make_fitted(is_tets, form, n, 0.95, 0.02, &t);
    block_target_create(form, 2 * n, 1, 0, &t.fine);
    double *x = t.b.given;
    for (int64_t i = 0; i < 3 * t.b.mesh.n_nodes && precision == PLANISH_PRECISION_FLOAT; i++)
        x[i] = (double)(float)x[i];
    t.b.mesh.coordinates = x;
    assert_int_equal(
        planish_fit_create(&t.b.mesh, t.b.shape, t.fine.shape, 0, &options, &f, NULL, NULL), 0);
    double *first = test_copy_of(&t.b.mesh), *slid, *again = test_copy_of(&t.b.mesh);
    planish_mesh mesh = t.b.mesh;
    move_again(f, &t.b, precision, first);
    mesh.coordinates = first;
    slid = test_copy_of(&mesh);
    assert_true(slide_along(f, &t.b, precision, slid) > 10);
    mesh.coordinates = slid;
    double *same = test_copy_of(&mesh);
    move_again(f, &t.b, precision, same);
    assert_memory_equal(same, slid, test_bytes_of(&mesh));
    move_again(f, &t.b, precision, again);
    assert_memory_equal(again, first, test_bytes_of(&mesh));
    planish_fit_destroy(f);
    free(first);
    free(slid);
    free(same);
    free(again);
    block_destroy(&t.b);
    block_target_destroy(&t.fine);
}

/** A fit moves the mesh wherever it is: nodes that have slid stay, and those that are off again go again. */
static void test_again(void **state) {
    (void)state;
    expect_again(1, BLOCK_BALL, 3, PLANISH_PRECISION_DOUBLE);
    expect_again(1, BLOCK_BALL, 4, PLANISH_PRECISION_FLOAT);
    expect_again(0, BLOCK_CYLINDER, 4, PLANISH_PRECISION_DOUBLE);
    expect_again(0, BLOCK_CYLINDER, 4, PLANISH_PRECISION_FLOAT);
}

/** Coordinates are finite, also if no node is on its way; what is refused stays. */
static void test_not_finite(void **state) {
    (void)state;
    fitted t;
    planish_fit *f;
    planish_fit_info info = {.n_nodes = -1};
    planish_error error;
    make_fitted(1, BLOCK_CUBE, 2, 1, 0, &t);
    block_target_create(BLOCK_CUBE, 2, 1, 0, &t.fine);
    assert_int_equal(
        planish_fit_create(&t.b.mesh, t.b.shape, t.fine.shape, 0, NULL, &f, &info, NULL), 0);
    assert_int_equal(info.n_off, 0);
    double *x = test_copy_of(&t.b.mesh), *given = malloc(test_bytes_of(&t.b.mesh));
    x[4] = NAN;
    memcpy(given, x, test_bytes_of(&t.b.mesh));
    info.n_nodes = -1;
    assert_int_equal(planish_fit_move(f, &t.b.mesh, x, NULL, &info, &error), PLANISH_ERROR_MESH);
    assert_int_equal(error.node, 1);
    planish_options options = test_options(1);
    options.time_limit = -1;
    assert_int_equal(planish_fit_move(f, &t.b.mesh, x, &options, &info, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "options.time_limit is -1; give seconds"));
    assert_int_equal(info.n_nodes, -1);
    assert_memory_equal(x, given, test_bytes_of(&t.b.mesh));
    free(x);
    free(given);
    planish_fit_destroy(f);
    block_destroy(&t.b);
    block_target_destroy(&t.fine);
}

/** Return the error of a fit that is refused. */
static planish_error refusal(const block *b, const planish_mesh *mesh, const planish_shape *onto,
                             double reach) {
    planish_fit *f = NULL;
    planish_error error = {.text = ""};
    assert_int_not_equal(planish_fit_create(mesh, b->shape, onto, reach, NULL, &f, NULL, &error),
                         0);
    assert_null(f);
    return error;
}

/** Node numbers that the mesh has not are found, also those of 64 bits whose low half is a number. */
static void refuse_nodes(const block *hexahedra, const block_target *onto) {
    planish_mesh mesh = hexahedra->mesh;
    planish_cells cells = *mesh.cells;
    const size_t n_nodes = (size_t)cells.offset[cells.n];
    int32_t *node = malloc(n_nodes * sizeof *node);
    memcpy(node, cells.node, n_nodes * sizeof *node);
    node[3] = (int32_t)mesh.n_nodes;
    cells.node = node;
    mesh.cells = &cells;
    planish_error error = refusal(hexahedra, &mesh, onto->shape, 0);
    assert_int_equal(error.code, PLANISH_ERROR_MESH);
    assert_int_equal(error.element, 0);
    free(node);
    block b;
    block_create(1, BOX_HEXAHEDRA, BLOCK_CUBE, 2, 1, 0, &(uint64_t){effort_seed(3)}, &b);
    mesh = b.mesh;
    int64_t *wide = malloc((size_t)mesh.n_elements * 4 * sizeof *wide);
    for (int64_t i = 0; i < 4 * mesh.n_elements; i++)
        wide[i] = mesh.elements[i];
    mesh.elements = NULL;
    mesh.elements64 = wide;
    for (int is_high = 0; is_high < 2; is_high++) {
        wide[4] = is_high ? ((int64_t)1 << 32) + b.mesh.elements[4] : -2;
        error = refusal(&b, &mesh, onto->shape, 0);
        assert_int_equal(error.code, PLANISH_ERROR_MESH);
        assert_int_equal(error.element, 1);
        assert_int_equal(error.node, wide[4]);
    }
    free(wide);
    block_destroy(&b);
}

static void test_refusals(void **state) {
    (void)state;
    block b;
    block_target ball;
    block_create(0, BOX_HEXAHEDRA, BLOCK_CUBE, 2, 1, 0, &(uint64_t){effort_seed(3)}, &b);
    block_target_create(BLOCK_BALL, 8, 1000, 0, &ball);
    planish_error error = refusal(&b, &b.mesh, ball.shape, 0);
    assert_int_equal(error.code, PLANISH_ERROR_MESH);
    assert_non_null(strstr(error.text, "no node of the mesh's surface is within 3 edges"));
    assert_non_null(strstr(error.text, "(-1000 -1000 -1000) to (1000 1000 1000)"));
    for (int is_small = 0; is_small < 2; is_small++) {
        const double unit = is_small ? 0x1p-900 : 0x1p900, none[3] = {0, 0, 0};
        block_target other;
        block_target_create(BLOCK_BALL, 8, 1, 0, &other);
        block_target_place(&other, (const double[3]){unit, unit, unit}, none);
        error = refusal(&b, &b.mesh, other.shape, 0);
        assert_int_equal(error.code, PLANISH_ERROR_MESH);
        assert_non_null(strstr(error.text, "differ in size"));
        block_target_destroy(&other);
    }
    error = refusal(&b, &b.mesh, ball.shape, -1);
    assert_int_equal(error.code, PLANISH_ERROR_ARGUMENT);
    const int32_t pairs[] = {0, 2};
    planish_mesh mesh = b.mesh;
    mesh.n_periodic = 1;
    mesh.periodic = pairs;
    error = refusal(&b, &mesh, ball.shape, 0);
    assert_int_equal(error.code, PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "periodic"));
    const planish_part part = {.node_number = NULL};
    mesh = b.mesh;
    mesh.part = &part;
    error = refusal(&b, &mesh, ball.shape, 0);
    assert_int_equal(error.code, PLANISH_ERROR_PARTS);
    mesh = b.mesh;
    mesh.n_nodes--;
    error = refusal(&b, &mesh, ball.shape, 0);
    assert_int_equal(error.code, PLANISH_ERROR_ARGUMENT);
    refuse_nodes(&b, &ball);
    cell_box *raised = cell_box_raise(b.box, 0);
    planish_shape *shape;
    planish_fit *f;
    assert_int_equal(planish_shape_create(&raised->mesh, NULL, 1, &shape, NULL, NULL), 0);
    assert_int_equal(
        planish_fit_create(&raised->mesh, shape, ball.shape, 0, NULL, &f, NULL, &error),
        PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "of order 2"));
    planish_shape_destroy(shape);
    cell_box_destroy(raised);
    assert_int_equal(planish_fit_project(0, NULL, NULL, NULL), PLANISH_CONSTRAINT_FIXED);
    planish_fit_destroy(NULL);
    block_destroy(&b);
    block_target_destroy(&ball);
}

/* ---- random cases ---------------------------------------------------------------------------- */

/** Count the elements that planish_measure_cells does not certify. */
static int64_t count_not_valid(const planish_mesh *mesh, double *x) {
    planish_cell_quality quality;
    planish_mesh now = *mesh;
    now.coordinates = x;
    assert_int_equal(planish_measure_cells(&now, 0, 1, &quality, NULL, NULL), 0);
    return quality.all.n_inverted + quality.all.n_uncertified;
}

/** Blocks of all types, sizes and forms, near and far from the other surface: what was valid stays so, what is held
 *  stays, and threads change nothing. */
static void test_random(void **state) {
    (void)state;
    const int64_t n_cases = effort(8, 2000);
    int64_t n_there = 0, n_off = 0;
    for (int64_t i = 0; i < n_cases; i += effort_step(4)) {
        uint64_t random = effort_seed((uint64_t)i + 100);
        const cell_box_kind kind = (cell_box_kind)(BOX_HEXAHEDRA + random_below(&random, 4));
        const block_form from = (block_form)random_below(&random, 3),
                         to = (block_form)random_below(&random, 3);
        const double size = random_between(&random, 0.6, 1.6);
        block b;
        block_target other;
        outcome o[2];
        const double shake = random_between(&random, 0, 0.3);
        const int n_cells = 2 + (int)random_below(&random, 3);
        block_create(random_below(&random, 3) == 0, kind, from, n_cells, 1, shake, &random, &b);
        const int is_turned = (int)random_below(&random, 2);
        block_target_create(to, 2 + (int)random_below(&random, 12), size, is_turned, &other);
        uint8_t *constraint = calloc((size_t)b.mesh.n_nodes, 1);
        for (int64_t k = 0; k < b.mesh.n_nodes; k++)
            constraint[k] = random_below(&random, 12) == 0;
        b.mesh.constraint = random_below(&random, 2) ? constraint : NULL;
        for (int k = 0; k < 2; k++) {
            planish_options options = test_options(k + 1);
            options.precision = i % 3 == 0 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
            options.untangle = 0;
            fit(&b, &other, 6, &options, &o[k]);
        }
        const int64_t n_before = count_not_valid(&b.mesh, b.given);
        if (count_not_valid(&b.mesh, o[0].x) > n_before ||
            count_not_valid(&b.mesh, o[0].smoothed) > n_before)
            fail_msg("case %d: an element is not valid any more", (int)i);
        if (memcmp(o[0].smoothed, o[1].smoothed, test_bytes_of(&b.mesh)) != 0 ||
            memcmp(&o[0].distance, &o[1].distance, sizeof o[0].distance) != 0)
            fail_msg("case %d: two threads give another mesh", (int)i);
        for (int64_t k = 0; k < 3 * b.mesh.n_nodes && b.mesh.constraint; k++)
            if (constraint[k / 3] && o[0].x[k] != b.given[k])
                fail_msg("case %d: a node that is held has moved", (int)i);
        if (o[0].after.n_off > 0 && !(o[0].distance.distance > 0))
            fail_msg("case %d: nodes are off, but the surface is not", (int)i);
        n_there += o[0].before.n_off - o[0].after.n_off;
        n_off += o[0].after.n_off;
        free(constraint);
        free_outcome(&o[0]);
        free_outcome(&o[1]);
        block_destroy(&b);
        block_target_destroy(&other);
    }
    figure("random: %d cases, %d nodes came to their places, %d did not", (int)n_cases,
           (int)n_there, (int)n_off);
    assert_true(n_there > 0 && n_off > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ball),
        cmocka_unit_test(test_cylinder),
        cmocka_unit_test(test_block_onto_ball),
        cmocka_unit_test(test_not_there),
        cmocka_unit_test(test_certificate),
        cmocka_unit_test(test_curved_other),
        cmocka_unit_test(test_stretched),
        cmocka_unit_test(test_cut),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_plate),
        cmocka_unit_test(test_flat),
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_stop),
        cmocka_unit_test(test_positions),
        cmocka_unit_test(test_wide),
        cmocka_unit_test(test_around),
        cmocka_unit_test(test_again),
        cmocka_unit_test(test_not_finite),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_random),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
