/* planish_fit: blocks of tetrahedra and hexahedra are brought onto spheres and cylinders of other triangles,
 * and judged by samples. */
#include "support/cell_meshes.h"
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

/* ---- forms ----------------------------------------------------------------------------------- */

/** Forms that the cube -1 .. 1 is taken to, times a size. */
typedef enum form { FORM_CUBE, FORM_BALL, FORM_CYLINDER } form;

static void to_form(form f, double size, double x[3]) {
    const double u = x[0] * x[0], v = x[1] * x[1], w = x[2] * x[2];
    if (f == FORM_BALL) {
        x[0] *= sqrt(1 - v / 2 - w / 2 + v * w / 3);
        x[1] *= sqrt(1 - w / 2 - u / 2 + w * u / 3);
        x[2] *= sqrt(1 - u / 2 - v / 2 + u * v / 3);
    } else if (f == FORM_CYLINDER) {
        x[0] *= sqrt(1 - v / 2);
        x[1] *= sqrt(1 - u / 2);
    }
    for (int d = 0; d < 3; d++)
        x[d] *= size;
}

/** Distance of x from the form of size 1. */
static double off_form(form f, const double x[3]) {
    const double r = sqrt(x[0] * x[0] + x[1] * x[1]);
    if (f == FORM_BALL)
        return fabs(sqrt(r * r + x[2] * x[2]) - 1);
    if (fabs(x[2]) > 1 || r > 1)
        return hypot(fmax(r - 1, 0), fmax(fabs(x[2]) - 1, 0));
    return fmin(1 - r, 1 - fabs(x[2]));
}

/* ---- other surfaces -------------------------------------------------------------------------- */

/** The surface of a cube of n squares along each side, as triangles, taken to a form. */
typedef struct sheet {
    planish_mesh mesh;
    planish_cells cells;
    double *x;
    int32_t *node;
    int64_t *offset;
    uint8_t *type;
    planish_shape *shape;
} sheet;

/** Return the number of the node at at[3], which is made if there is none. */
static int32_t sheet_node(sheet *s, int32_t *number, int n, const int at[3]) {
    int32_t *of = &number[(at[0] * (n + 1) + at[1]) * (n + 1) + at[2]];
    if (*of >= 0)
        return *of;
    for (int d = 0; d < 3; d++)
        s->x[3 * s->mesh.n_nodes + d] = 2. * at[d] / n - 1;
    return *of = (int32_t)s->mesh.n_nodes++;
}

static void sheet_face(sheet *s, int32_t *number, int n, int axis, int side, int is_turned) {
    for (int i = 0; i < n * n; i++) {
        int32_t v[4];
        for (int k = 0; k < 4; k++) {
            int at[3];
            at[axis] = side * n;
            at[(axis + 1) % 3] = i / n + (k == 1 || k == 2);
            at[(axis + 2) % 3] = i % n + (k >= 2);
            v[k] = sheet_node(s, number, n, at);
        }
        const int turn = (side == 0) != is_turned;
        for (int k = 0; k < 2; k++) {
            int32_t *to = s->node + 3 * s->cells.n++;
            to[0] = v[0];
            to[1 + turn] = v[1 + k];
            to[2 - turn] = v[2 + k];
        }
    }
}

/** Take the nodes of a surface to a form, and make its shape. */
static void finish_sheet(form f, double size, sheet *s) {
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        to_form(f, size, s->x + 3 * i);
    s->cells.type = s->type;
    s->cells.offset = s->offset;
    s->cells.node = s->node;
    s->mesh.dim = 3;
    s->mesh.coordinates = s->x;
    s->mesh.cells = &s->cells;
    s->mesh.n_elements = s->cells.n;
    assert_int_equal(planish_shape_create(&s->mesh, NULL, 1, &s->shape, NULL, NULL), 0);
}

/** Make a surface; is_turned: its triangles turn inwards. */
static void make_sheet(form f, int n, double size, int is_turned, sheet *s) {
    const size_t most = (size_t)(12 * n * n), grid = (size_t)((n + 1) * (n + 1) * (n + 1));
    int32_t *number = malloc(grid * sizeof *number);
    memset(number, -1, grid * sizeof *number);
    *s = (sheet){.x = malloc(most * 3 * sizeof *s->x),
                 .node = malloc(most * 3 * sizeof *s->node),
                 .offset = malloc((most + 1) * sizeof *s->offset),
                 .type = malloc(most)};
    for (int side = 0; side < 6; side++)
        sheet_face(s, number, n, side / 2, side % 2, is_turned);
    free(number);
    memset(s->type, PLANISH_CELL_TRIANGLE, most);
    for (int64_t i = 0; i <= s->cells.n; i++)
        s->offset[i] = 3 * i;
    finish_sheet(f, size, s);
}

static void free_sheet(sheet *s) {
    planish_shape_destroy(s->shape);
    free(s->x);
    free(s->node);
    free(s->offset);
    free(s->type);
}

/** Make a surface of six faces of two triangles of order 2 each. */
static void make_curved_sheet(form f, double size, sheet *s) {
    int32_t number[27];
    memset(number, -1, sizeof number);
    make_sheet(FORM_CUBE, 1, 1, 0, s);
    sheet straight = *s;
    *s = (sheet){.x = malloc(26 * 3 * sizeof *s->x),
                 .node = malloc(12 * 6 * sizeof *s->node),
                 .offset = malloc(13 * sizeof *s->offset),
                 .type = malloc(12)};
    for (int i = 0; i < 12 * 6; i++) {
        const int32_t *corner = straight.node + i / 6 * 3;
        int at[3];
        for (int d = 0; d < 3; d++) {
            const double a = straight.x[3 * corner[i % 3] + d];
            const double b = straight.x[3 * corner[(i + 1) % 3] + d];
            at[d] = (int)(i % 6 < 3 ? a + 1 : (a + b) / 2 + 1);
        }
        s->node[i] = sheet_node(s, number, 2, at);
    }
    free_sheet(&straight);
    memset(s->type, PLANISH_CELL_TRIANGLE6, 12);
    for (int i = 0; i <= 12; i++)
        s->offset[i] = 6 * (int64_t)i;
    s->cells.n = 12;
    finish_sheet(f, size, s);
}

/* ---- blocks ---------------------------------------------------------------------------------- */

/** A block of cubes, as hexahedra or as six tetrahedra each, in a form. */
typedef struct block {
    cell_box *box;
    int32_t *tetrahedron;
    planish_mesh mesh;
    double *given; /* its coordinates at first */
    planish_shape *shape;
} block;

static void split(const int32_t *hex, int32_t *to) {
    static const int8_t ROUND[7] = {1, 2, 3, 7, 4, 5, 1};
    for (int i = 0; i < 6; i++) {
        const int32_t tetrahedron[4] = {hex[0], hex[ROUND[i]], hex[ROUND[i + 1]], hex[6]};
        memcpy(to + 4 * i, tetrahedron, sizeof tetrahedron);
    }
}

static int is_at_surface(const double *x, int n) {
    int any = 0;
    for (int d = 0; d < 3; d++)
        any |= x[d] == 0 || x[d] == n;
    return any;
}

/** Make a block; shake: how far nodes of the surface are off it, in parts of an edge. */
static void make_block(int is_tets, cell_box_kind kind, form f, int n, double size, double shake,
                       uint64_t *state, block *b) {
    *b = (block){.box = cell_box_create(is_tets ? BOX_HEXAHEDRA : kind, n)};
    b->mesh = b->box->mesh;
    for (int64_t i = 0; i < b->mesh.n_nodes; i++) {
        double *x = b->box->x + 3 * i;
        const int is_shaken = is_at_surface(x, n);
        for (int d = 0; d < 3; d++)
            x[d] = 2 * x[d] / n - 1;
        to_form(f, size, x);
        for (int d = 0; d < 3; d++)
            x[d] += is_shaken * shake * size * 2 / n * random_between(state, -1, 1);
    }
    if (is_tets) {
        const planish_cells *cells = b->mesh.cells;
        b->tetrahedron = malloc((size_t)cells->n * 24 * sizeof *b->tetrahedron);
        for (int64_t i = 0; i < cells->n; i++)
            split(cells->node + cells->offset[i], b->tetrahedron + 24 * i);
        b->mesh.cells = NULL;
        b->mesh.elements = b->tetrahedron;
        b->mesh.n_elements = 6 * cells->n;
    }
    b->given = test_copy_of(&b->mesh);
    assert_int_equal(planish_shape_create(&b->mesh, NULL, 1, &b->shape, NULL, NULL), 0);
}

static void free_block(block *b) {
    planish_shape_destroy(b->shape);
    cell_box_destroy(b->box);
    free(b->tetrahedron);
    free(b->given);
}

/* ---- judges ---------------------------------------------------------------------------------- */

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
static double farthest_node(const block *b, form f, const double *x) {
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

static void fit(block *b, const sheet *onto, double reach, const planish_options *options,
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

/** A block, a sheet that it is fitted to, and the outcome; random: what the block is drawn by. */
typedef struct fitted {
    uint64_t random;
    block b;
    sheet fine;
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

static void free_fitted(fitted *t) {
    free_outcome(&t->o);
    free_block(&t->b);
    free_sheet(&t->fine);
}

static void test_ball(void **state) {
    (void)state;
    fitted t = {.random = effort_seed(3)};
    make_block(1, BOX_HEXAHEDRA, FORM_BALL, 6, 0.95, 0.02, &t.random, &t.b);
    make_sheet(FORM_BALL, 24, 1, 1, &t.fine);
    fit_one("ball of tetrahedra", 0, &t);
    assert_int_equal(t.o.after.n_off, 0);
    assert_true(farthest_node(&t.b, FORM_BALL, t.o.x) < 2e-3);
    assert_true(farthest_node(&t.b, FORM_BALL, t.o.smoothed) < 2e-3);
    free_fitted(&t);
}

static void test_cylinder(void **state) {
    (void)state;
    fitted t = {.random = effort_seed(3)};
    make_block(0, BOX_HEXAHEDRA, FORM_CYLINDER, 6, 1, 0.02, &t.random, &t.b);
    make_sheet(FORM_CYLINDER, 24, 1, 0, &t.fine);
    fit_one("cylinder of hexahedra", 0, &t);
    assert_int_equal(t.o.after.n_off, 0);
    assert_true(farthest_node(&t.b, FORM_CYLINDER, t.o.x) < 4e-3);
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
    fitted t = {.random = effort_seed(3)};
    make_block(0, BOX_HEXAHEDRA, FORM_CUBE, 6, 0.8, 0, &t.random, &t.b);
    make_sheet(FORM_BALL, 16, 0.5, 0, &t.fine);
    fit_one("block onto a ball", 5, &t);
    assert_true(count_after_projection(&t.b, 0.5) > 0);
    assert_int_equal(t.o.after.n_off, 0);
    free_fitted(&t);
}

/** Nodes inside are held, and no more is possible than they allow. */
static void test_not_there(void **state) {
    (void)state;
    fitted t = {.random = effort_seed(3)};
    make_block(0, BOX_HEXAHEDRA, FORM_CUBE, 6, 0.8, 0, &t.random, &t.b);
    make_sheet(FORM_BALL, 16, 0.75, 0, &t.fine);
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
    fitted t = {.random = effort_seed(3)};
    make_block(1, BOX_HEXAHEDRA, FORM_BALL, 5, 0.95, 0.02, &t.random, &t.b);
    make_sheet(FORM_BALL, 32, 1, 0, &t.fine);
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
    fitted t = {.random = effort_seed(3)};
    planish_fit *f;
    planish_shape_distance distance;
    make_block(1, BOX_HEXAHEDRA, FORM_BALL, 2, 1, 0, &t.random, &t.b);
    make_curved_sheet(FORM_BALL, 1, &t.fine);
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
    free_block(&t.b);
    free_sheet(&t.fine);
}

/** The bits are the same for two threads. */
static void test_threads(void **state) {
    (void)state;
    for (int is_tets = 0; is_tets < 2; is_tets++) {
        block b;
        sheet fine;
        outcome o[2];
        make_block(is_tets, BOX_HEXAHEDRA, is_tets ? FORM_BALL : FORM_CUBE, 6, 0.8, 0.02,
                   &(uint64_t){effort_seed(3)}, &b);
        make_sheet(FORM_BALL, 16, 0.6, 0, &fine);
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
        free_block(&b);
        free_sheet(&fine);
    }
}

static int stop_soon(const planish_progress *progress, void *left) {
    (void)progress;
    return --*(int *)left <= 0;
}

/** Whenever it is stopped, what it hands out is valid. */
static void test_stop(void **state) {
    (void)state;
    block b;
    sheet fine;
    make_block(0, BOX_HEXAHEDRA, FORM_CUBE, 5, 0.8, 0, &(uint64_t){effort_seed(3)}, &b);
    make_sheet(FORM_BALL, 16, 0.5, 0, &fine);
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
    free_block(&b);
    free_sheet(&fine);
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

static void test_refusals(void **state) {
    (void)state;
    block b;
    sheet ball;
    make_block(0, BOX_HEXAHEDRA, FORM_CUBE, 2, 1, 0, &(uint64_t){effort_seed(3)}, &b);
    make_sheet(FORM_BALL, 8, 1000, 0, &ball);
    planish_error error = refusal(&b, &b.mesh, ball.shape, 0);
    assert_int_equal(error.code, PLANISH_ERROR_MESH);
    assert_non_null(strstr(error.text, "no node of the mesh's surface is within 3 edges"));
    assert_non_null(strstr(error.text, "(-1000 -1000 -1000) to (1000 1000 1000)"));
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
    free_block(&b);
    free_sheet(&ball);
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
        const form from = (form)random_below(&random, 3), to = (form)random_below(&random, 3);
        const double size = random_between(&random, 0.6, 1.6);
        block b;
        sheet other;
        outcome o[2];
        const double shake = random_between(&random, 0, 0.3);
        const int n_cells = 2 + (int)random_below(&random, 3);
        make_block(random_below(&random, 3) == 0, kind, from, n_cells, 1, shake, &random, &b);
        const int is_turned = (int)random_below(&random, 2);
        make_sheet(to, 2 + (int)random_below(&random, 12), size, is_turned, &other);
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
        free_block(&b);
        free_sheet(&other);
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
        cmocka_unit_test(test_threads),
        cmocka_unit_test(test_stop),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_random),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
