/* visit: Newton's step in the directions that a node has, a place on the surface, and what refuses
 * it. */
#include "surface/visit.h"

#include <math.h>
#include <string.h>

enum { HALVINGS = 10 };

/* A step is no longer than this part of the mean edge: beyond, triangles at the node fold. */
#define LONGEST_STEP 0.7
/* Part of the fall that the slope promises which is enough (Armijo). */
#define ENOUGH 1e-4
/* The slope of a step that promises less than this part of the sum is lost in rounding. */
#define NOTHING 1e-14
/* Part of the Hessian's diagonal by which it is shifted at first, and factor from then on. */
#define FIRST_SHIFT 1e-3
#define NEXT_SHIFT  4
/* A Hessian whose determinant is no larger than this part of its diagonal's product is singular. */
#define SINGULAR 1e-8
/* As pl_star_tally.improved. */
#define IMPROVED 0.01

/** A star under work. */
typedef struct surface_star {
    const pl_surface_problem *problem;
    pl_skin_visit
        *on_skin; /* NULL: the node is on a plane or line, and changes nothing of the shape */
    const pl_star_slide *slide;
    int32_t node;
    const pl_facet_term *term;
    int64_t n_terms;
    planish_constraint kind; /* _ON_PLANE: in a plane or patch, _ON_LINE: on a line or curve */
    double direction[3];
    double basis[2][3];
} surface_star;

/** Value of a star with its node somewhere. */
typedef struct star_value {
    double sum, worst, acuteness;
    int positive;
} star_value;

static double weight_of(const surface_star *s, int64_t i) {
    return s->term[i].role == PL_TERM_TRIANGLE ? 1 : 0.25;
}

/** Vectors of a term with the node at x, in the shape's units. */
static void vectors_of(const surface_star *s, int64_t i, const double *x, pl_facet_vectors *v) {
    const pl_surface_problem *problem = s->problem;
    const double scale = problem->mesh->shape->scale;
    const double *p = problem->x[s->term[i].p], *q = problem->x[s->term[i].q];
    double at[3], to_p[3], to_q[3];
    for (int d = 0; d < 3; d++) {
        at[d] = x[d] * scale;
        to_p[d] = p[d] * scale;
        to_q[d] = q[d] * scale;
    }
    pl_facet_vectors_of((pl_term_role)s->term[i].role, at, to_p, to_q, v);
}

/** Return a quarter of the ratio of the corner opposite to the node, in the quadrilateral whose terms
 *  begin at i. */
static double ratio_opposite(const surface_star *s, int64_t i) {
    const double(*x)[3] = (const double(*)[3])s->problem->x;
    const pl_facet_term *own = &s->term[i];
    pl_facet_vectors v;
    pl_facet_vectors_of(PL_TERM_OWN, x[s->term[i + 1].q], x[own->q], x[own->p], &v);
    return pl_facet_ratio(PL_TERM_OWN, 0, &v) / 4;
}

/** Find the star's value with the node at x; derivatives may be NULL. The three terms of a
 *  quadrilateral stand together, its own corner first. */
static star_value value_at(const surface_star *s, const double *x, pl_facet_sum *derivatives) {
    const pl_surface_problem *problem = s->problem;
    const pl_surface_mesh *mesh = problem->mesh;
    star_value value = {0, 0, 0, 1};
    pl_facet_sum sum = {0};
    double ratio = 0; /* of the element */
    for (int64_t i = 0; i < s->n_terms; i++) {
        const pl_term_role role = (pl_term_role)s->term[i].role;
        pl_facet_vectors v;
        double first[3];
        vectors_of(s, i, x, &v);
        pl_kept_normal(mesh->shape, s->term[i].facet, first);
        value.positive &= pl_dot(3, v.n, first) > 0;
        if (role == PL_TERM_TRIANGLE || role == PL_TERM_OWN)
            ratio = role == PL_TERM_OWN ? ratio_opposite(s, i) : 0;
        ratio += weight_of(s, i) * pl_facet_ratio(role, mesh->by_radius, &v);
        if (role == PL_TERM_TRIANGLE || role == PL_TERM_BEFORE)
            value.worst = fmax(value.worst, ratio);
        value.acuteness = fmax(value.acuteness, pl_facet_acuteness(role, &v));
        if (derivatives)
            pl_facet_term_add(role, problem->measure, problem->limit, weight_of(s, i), &v,
                              (const double(*)[3])s->basis, &sum);
        else
            sum.sum +=
                weight_of(s, i) * pl_facet_term_value(role, problem->measure, problem->limit, &v);
    }
    value.sum = sum.sum;
    value.positive &= sum.sum < INFINITY;
    if (derivatives)
        *derivatives = sum;
    return value;
}

/** Find two unit vectors across direction; or direction itself and 0. */
static void find_basis(surface_star *s) {
    const double *n = s->direction;
    const int along = s->kind == PLANISH_CONSTRAINT_ON_LINE;
    int least = 0;
    double axis[3] = {0, 0, 0};
    for (int d = 0; d < 3; d++) {
        s->basis[0][d] = along ? n[d] : 0;
        s->basis[1][d] = 0;
        least = fabs(n[d]) < fabs(n[least]) ? d : least;
    }
    if (along)
        return;
    axis[least] = 1;
    pl_cross(n, axis, s->basis[0]);
    pl_unit(3, s->basis[0], s->basis[0]);
    pl_cross(n, s->basis[0], s->basis[1]);
}

/** Ask where the node may go; 0: nowhere. */
static int find_directions(surface_star *s, const double *x) {
    double place[3] = {x[0], x[1], x[2]};
    s->kind = s->slide->kind;
    memcpy(s->direction, s->slide->direction, sizeof s->direction);
    if (s->on_skin)
        s->kind = pl_skin_project(s->slide->node, place, s->direction, s->on_skin);
    if (s->kind != PLANISH_CONSTRAINT_ON_PLANE && s->kind != PLANISH_CONSTRAINT_ON_LINE)
        return 0;
    find_basis(s);
    return 1;
}

/** Solve for the step, with the Hessian shifted until it is positive definite; returns its slope. */
static double find_step(const pl_facet_sum *f, double step[2]) {
    const double size = fmax(fabs(f->hessian[0]), fabs(f->hessian[2]));
    double shift = 0;
    for (int k = 0; k < 40 && size > 0 && size < INFINITY; k++) {
        const double a = f->hessian[0] + shift, b = f->hessian[1], c = f->hessian[2] + shift;
        const double determinant = a * c - b * b;
        if (a > 0 && c > 0 && determinant > SINGULAR * size * size) {
            step[0] = (b * f->gradient[1] - c * f->gradient[0]) / determinant;
            step[1] = (b * f->gradient[0] - a * f->gradient[1]) / determinant;
            return f->gradient[0] * step[0] + f->gradient[1] * step[1];
        }
        shift = shift > 0 ? shift * NEXT_SHIFT : FIRST_SHIFT * size;
    }
    return 0;
}

/** Bring x to the plane or line of the node, as it is stored. */
static void slide_to(const surface_star *s, double *x) {
    const double *point = s->slide->point;
    double way[3];
    pl_subtract(3, x, point, way);
    const double along = pl_dot(3, s->direction, way);
    for (int d = 0; d < 3; d++) {
        const double part = s->direction[d] * along;
        x[d] = pl_store(&s->problem->storage,
                        point[d] + (s->kind == PLANISH_CONSTRAINT_ON_LINE ? part : way[d] - part));
    }
}

/** Whether the bounds of the node allow x. */
static int is_inside(const surface_star *s, const double *x) {
    const pl_surface_problem *problem = s->problem;
    const double *start = problem->start[s->node];
    double square = 0;
    int inside = 1;
    for (int d = 0; d < 3; d++) {
        square += (x[d] - start[d]) * (x[d] - start[d]);
        inside &= !problem->lower ||
                  (problem->lower[s->node][d] <= x[d] && x[d] <= problem->upper[s->node][d]);
    }
    return inside && (!problem->radius || sqrt(square) <= problem->radius[s->node]);
}

/** Search along a step; x becomes the place that is found. Returns by how much the sum fell; 0: none
 *  was found. */
static double search_along(const surface_star *s, const star_value *now, const double step[2],
                           double slope, double *x, int64_t *evaluations) {
    const pl_surface_problem *problem = s->problem;
    double way[3], length = 0, part = 1;
    for (int d = 0; d < 3; d++) {
        way[d] = step[0] * s->basis[0][d] + step[1] * s->basis[1][d];
        length += way[d] * way[d];
    }
    const planish_shape *shape = problem->mesh->shape;
    const double most = LONGEST_STEP * shape->edge_length[s->node];
    part = sqrt(length) > most ? most / sqrt(length) : 1;
    for (int k = 0; k < HALVINGS; k++, part /= 2) {
        double place[3];
        for (int d = 0; d < 3; d++)
            place[d] = x[d] + part * way[d] / shape->scale;
        if (s->on_skin) {
            double direction[3];
            pl_skin_project(s->slide->node, place, direction, s->on_skin);
        } else {
            slide_to(s, place);
        }
        if (pl_skin_is_at(place, x))
            return 0;
        if (!is_inside(s, place))
            continue;
        const star_value there = value_at(s, place, NULL);
        ++*evaluations;
        if (!there.positive || !(there.worst <= problem->worst) ||
            !(there.acuteness <= problem->acuteness) ||
            !(there.sum < now->sum + ENOUGH * part * slope))
            continue;
        for (int d = 0; d < 3; d++)
            x[d] = place[d];
        return now->sum - there.sum;
    }
    return 0;
}

/** Have the stars around a node that has moved visited. */
static void wake_others(const surface_star *s) {
    uint8_t *changed = s->problem->changed;
    for (int64_t i = 0; i < s->n_terms; i++) {
        __atomic_store_n(&changed[s->term[i].p], 1, __ATOMIC_RELAXED);
        __atomic_store_n(&changed[s->term[i].q], 1, __ATOMIC_RELAXED);
    }
}

/** Move the node of a star, if that pays, to x, where it is; returns by how much the star's sum fell. */
static double move(surface_star *s, double *x, star_value *now, pl_star_tally *tally) {
    const pl_surface_problem *problem = s->problem;
    pl_facet_sum derivatives;
    double step[2] = {0, 0};
    if (!find_directions(s, x))
        return 0;
    *now = value_at(s, x, &derivatives);
    tally->evaluations++;
    const double bad = problem->measure == PL_FACET_ACUTENESS ? now->acuteness : now->worst;
    if (!now->positive || !(bad > problem->skip))
        return 0;
    if (s->kind == PLANISH_CONSTRAINT_ON_LINE) { /* the second direction is none */
        derivatives.hessian[1] = 0;
        derivatives.hessian[2] = derivatives.hessian[0];
    }
    const double slope = find_step(&derivatives, step);
    if (!(-slope > NOTHING * now->sum))
        return 0;
    return search_along(s, now, step, slope, x, &tally->evaluations);
}

static void visit_star(const pl_surface_problem *problem, int64_t star, pl_skin_visit *visit,
                       pl_star_tally *tally) {
    const pl_surface_mesh *mesh = problem->mesh;
    const int64_t begin = mesh->term_offset[star];
    const int is_of_skin = problem->skin->node[star] >= 0;
    surface_star s = {.problem = problem,
                      .on_skin = is_of_skin ? visit : NULL,
                      .slide = &problem->slide[star],
                      .node = mesh->node[star],
                      .term = mesh->term + begin,
                      .n_terms = mesh->term_offset[star + 1] - begin};
    double *place = problem->x[s.node], x[3] = {place[0], place[1], place[2]};
    star_value now = {0, 0, 0, 0};
    if (!is_of_skin && problem->skin->moves[s.node] != PL_SKIN_FLAT)
        return;
    if (is_of_skin)
        pl_skin_begin_visit(visit, star);
    const double fall = move(&s, x, &now, tally);
    memcpy(place, x, sizeof x);
    const int stands = !is_of_skin || pl_skin_end_visit(visit);
    if (!(fall > 0) || !stands)
        return;
    if (fall > problem->calm * now.sum)
        wake_others(&s);
    if (fall > IMPROVED * now.sum) /* it is not at its best yet */
        __atomic_store_n(&problem->changed[s.node], 1, __ATOMIC_RELAXED);
    tally->improved += fall > IMPROVED * now.sum;
}

void pl_surface_visit(const pl_surface_problem *problem, int64_t begin, int64_t end, int thread,
                      pl_star_tally *tally) {
    pl_skin_visit visit;
    pl_skin_prepare(problem->skin, thread, &visit);
    for (int64_t i = begin; i < end; i++) {
        uint8_t *changed = &problem->changed[problem->mesh->node[i]];
        if (!__atomic_load_n(changed, __ATOMIC_RELAXED))
            continue;
        __atomic_store_n(changed, 0, __ATOMIC_RELAXED);
        tally->visits++;
        visit_star(problem, i, &visit, tally);
    }
}
