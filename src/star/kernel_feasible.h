/* kernel_feasible: directions of a star with active or violated constraints, the paper's cases 2
 * and 3.
 *
 * Both are one projection on a cone (kernel_cone.h, docs/algorithm.md). Constraints: g_k = 1 - D_k
 * / floor_k of the elements, the bounds of the coordinates, and the distance moved.
 *
 *   active_none, add_row, add_facet_row, active_within    rows: gradients of constraints
 *   project_direction, is_near_constraint,
 *   guarded_direction                                     case 2: constraints active
 *   shortest_displacement, restore                        case 3: constraints violated
 */
#ifndef PL_STAR_KERNEL_FEASIBLE_H
#define PL_STAR_KERNEL_FEASIBLE_H

#include "star/kernel_cone.h"
#include "star/kernel_step.h"

/* Elements with g above it are violated: V >= 0.997 delta counts as met, as in the paper. */
#define VIOLATED_ABOVE PLANISH_VOLUME_TOLERANCE
/* Constraints count as active within bands of g that become thinner, so that an optimum with
 * constraints in force is found and not just its surroundings. */
#define BAND_FACTOR 0.1
enum { BANDS = 5 };
/* Push-off factors theta = min(50, (1 + g / |ct|)^2), ct = ACTIVE_ABOVE, and phi: 5, 50, 500,
 * no more than 1000; the values of CONMIN (Vanderplaats 1973), with gradients normalised. */
#define PUSH_OFF_LARGEST 50.0
#define PHI_FIRST        5.0
#define PHI_FACTOR       10.0
#define PHI_LAST         1000.0

/* A star is brought above its floors by this fraction of them, if it can be, else by next to none.
 */
#define RESTORE_MARGIN      0.05
#define RESTORE_MARGIN_LAST 1e-6
/* Sufficient decrease of sum max(0, g)^2, relative: what falls by less is stuck. */
#define RESTORE_FALL 1e-3
enum { RESTORE_TRIALS = 10 };
/* A homogeneous solution with less weight than this has none: the star is infeasible. */
#define WEIGHT_LEAST 1e-9

/** Return the g above which an element is violated. */
static inline double violated_above(const local *here) {
    return here->problem->guard->strict ? GRAZE : VIOLATED_ABOVE;
}

/** Margin above the minimum volume to which elements are brought up. */
static inline double restore_margin(const local *here) {
    return here->problem->guard->strict ? RESTORE_MARGIN_LAST : RESTORE_MARGIN;
}

/* Where elements are brought up they shall be sound, too: this high over their link facet, relative
 * to the star's size. A minimum volume may be next to nothing. */
#define SOUND_HEIGHT 0.02

/** Return by how much D of element i, at the position of GVALUE, falls short of its final goal, if
 *  that can be reached: above its floor by margin, and sound if it has to be brought up. */
static inline double missing_measure(const local *here, int64_t i, double margin, double size) {
    const star *s = &here->s;
    double floor = *entry(s, FLOOR, i) * (1 + margin);
    double sound = SOUND_HEIGHT * size * *entry(s, LENGTH, i);
    int is_violated = *entry(s, GVALUE, i) > violated_above(here);
    int is_raised = is_violated && !here->problem->guard->strict && sound > floor;
    return (is_raised ? sound : floor) - (1 - *entry(s, GVALUE, i)) * *entry(s, FLOOR, i);
}

/* ---- rows ---------------------------------------------------------------------------------- */

/** Gradients of constraints, of unit length, in the star's spare columns; of a node that slides
 *  what is left of them in its directions. */
typedef struct active {
    double (*rows)[ROW_LENGTH];
    int64_t m;
    const sliding *slide;
} active;

/** Set of active constraints without any row. */
static inline active active_none(const local *here) {
    return (active){(double(*)[ROW_LENGTH])(void *)here->s.spare, 0, &here->slide};
}

/** Add a constraint's gradient [dim] to the active set; returns its row. */
static inline double *add_row(active *a, const double *gradient, const int dim) {
    double *row = a->rows[a->m++];
    for (int d = 0; d < ROW_LENGTH; d++)
        row[d] = d < dim ? gradient[d] : 0;
    if (!a->slide || a->slide->kind == PLANISH_CONSTRAINT_FREE)
        return row;
    slide_along(a->slide, row, dim);
    const int nothing = dot(row, row, dim) < SLIDE_NOTHING * SLIDE_NOTHING;
    for (int d = 0; nothing && d < dim; d++)
        row[d] = 0;
    return row;
}

/** Find grad D of facet i, divided by its length; return 0 if it has none. */
static inline int facet_normal(const star *s, int64_t i, double *n, const int dim) {
    double length = *entry(s, LENGTH, i);
    if (dim == 3) {
        for (int d = 0; d < 3; d++)
            n[d] = *entry(s, NX + d, i);
    } else {
        n[0] = *entry(s, P0Y, i) - *entry(s, P1Y, i);
        n[1] = *entry(s, P1X, i) - *entry(s, P0X, i);
    }
    for (int d = 0; d < dim; d++)
        n[d] /= length;
    return length > 0;
}

/** Add grad g of facet i; NULL if it has no direction. */
static inline double *add_facet_row(const star *s, int64_t i, active *a, const int dim) {
    double n[3];
    if (!facet_normal(s, i, n, dim))
        return NULL;
    for (int d = 0; d < dim; d++)
        n[d] = -n[d];
    return add_row(a, n, dim);
}

/** Add the bounds that x is nearer to than band times the star's size, or the radius. */
static inline void add_bound_rows(const local *here, const double *x, double band, double size,
                                  active *a, const int dim) {
    const bounds *b = &here->b;
    for (int d = 0; b->any && d < dim; d++) {
        double unit[3] = {0, 0, 0};
        unit[d] = -1;
        if (x[d] - b->lower[d] < band * size)
            add_row(a, unit, dim);
        unit[d] = 1;
        if (b->upper[d] - x[d] < band * size)
            add_row(a, unit, dim);
    }
    double far = b->any && b->radius < INFINITY ? distance_from_start(b, x, dim) : 0;
    if (far > 0 && far > (1 - band) * b->radius) {
        double outwards[3] = {0, 0, 0};
        for (int d = 0; d < dim; d++)
            outwards[d] = (x[d] - b->start[d]) / far;
        add_row(a, outwards, dim);
    }
}

/* In case 2 rows have at most three numbers; the last entry is the facet, or this. */
enum { OF_BOUND = -1 };

/** The constraints with g above -band, for case 2. */
static inline active active_within(const local *here, const double *x, double band, double size,
                                   const int dim) {
    const star *s = &here->s;
    active a = active_none(here);
    for (int64_t i = 0; i < s->n_facets; i++) {
        double *row = *entry(s, GVALUE, i) > -band ? add_facet_row(s, i, &a, dim) : NULL;
        if (row)
            row[ROW_LENGTH - 1] = (double)i;
    }
    int64_t n_facets = a.m;
    add_bound_rows(here, x, band, size, &a, dim);
    for (int64_t i = n_facets; i < a.m; i++)
        a.rows[i][ROW_LENGTH - 1] = OF_BOUND;
    return a;
}

/* ---- case 2: constraints active ------------------------------------------------------------ */

/** Transform b to the metric in which the model's Hessian is the identity: D^-1/2 L^-1 b. */
static inline void to_metric(const factors *f, const double *b, double *y, const int dim) {
    double z[3];
    substitute_forward(f, b, z, dim);
    for (int d = 0; d < dim; d++)
        y[d] = z[d] / sqrt(f->pivot[d]);
}

/** Project -grad f on the cone that the rows leave: direction [dim]. The rows are changed. */
static inline int project_direction(const derivatives *derivative, const factors *f,
                                    const active *a, double *direction, cone_point *point,
                                    const int dim) {
    double p[3];
    to_metric(f, derivative->gradient, p, dim);
    for (int d = 0; d < dim; d++)
        p[d] = -p[d];
    for (int64_t i = 0; i < a->m; i++)
        to_metric(f, a->rows[i], a->rows[i], dim);
    if (!cone_project((const double(*)[CONE_DIM])a->rows, a->m, p, dim, point))
        return 0;
    double z[3]; /* back from the metric */
    for (int d = 0; d < dim; d++)
        z[d] = point->point[d] * sqrt(f->pivot[d]);
    substitute_back(f, z, direction, dim);
    return 1;
}

/** Find the direction of equation 4 of the paper that promises most, over bands of active
 *  constraints. Newton's is in the metric of the shifted Hessian, in which the projected gradient
 *  is the Newton step within the cone; others are in that of the space. */
static inline int constrained_direction(const local *here, const double *x,
                                        const derivatives *derivative, double *direction,
                                        const int dim) {
    const double *gradient = derivative->gradient;
    const int is_newton = here->kind == PLANISH_SEARCH_NEWTON;
    factors f = {.pivot = {1, 1, 1}, .inverse = {1, 1, 1}};
    if (is_newton && !factorise_shifted(derivative->hessian, &f, dim))
        return 0;
    double best = 0, band = -ACTIVE_ABOVE, size = sqrt(derivative->size2);
    int64_t rows = -1;
    for (int i = 0; i < BANDS; i++, band *= BAND_FACTOR) {
        active a = active_within(here, x, band, size, dim);
        cone_point point;
        double candidate[3];
        int same = a.m == rows; /* bands are nested */
        rows = a.m;
        if (same || !project_direction(derivative, &f, &a, candidate, &point, dim))
            continue;
        if (!is_newton) { /* to the length of a Newton step along it */
            double bend = curvature(derivative->hessian, candidate, dim);
            double square = dot(candidate, candidate, dim), slope = dot(gradient, candidate, dim);
            double length = bend > 0     ? -slope / bend
                            : square > 0 ? sqrt(derivative->size2 / square)
                                         : 0;
            for (int d = 0; d < dim; d++)
                candidate[d] *= length;
        }
        limit_length(candidate, derivative->size2, dim);
        /* by how much the quadratic model falls on the way that is free */
        double rate = limiting_rate(here, x, candidate, 1, dim);
        double step = rate > STEP_FRACTION_FIRST ? STEP_FRACTION_FIRST / rate : 1;
        double fall = -dot(gradient, candidate, dim) * step * (1 - 0.5 * step);
        if (fall > best) {
            best = fall;
            memcpy(direction, candidate, (size_t)dim * sizeof *direction);
        }
    }
    return best > 0;
}

/** Whether constraints are active with the node at x. */
static inline int is_near_constraint(const local *here, const double *x, const objective *now,
                                     const derivatives *derivative, const int dim) {
    active a = active_none(here);
    if (now->largest_g > ACTIVE_ABOVE)
        return 1;
    add_bound_rows(here, x, -ACTIVE_ABOVE, sqrt(derivative->size2), &a, dim);
    return a.m > 0;
}

/** The direction of cases 1 and 2; memory is that of conjugate directions. */
static inline int guarded_direction(local *here, const double *x, const objective *now,
                                    const derivatives *derivative, conjugate *memory,
                                    double *direction, const int dim) {
    here->constrained = is_near_constraint(here, x, now, derivative, dim);
    if (!here->constrained)
        return find_direction(here->kind, derivative, memory, direction, dim);
    memory->gradient2 = 0;
    return constrained_direction(here, x, derivative, direction, dim);
}

/* ---- case 3: constraints violated ---------------------------------------------------------- */

/* Bringing some elements up must not press others flat: none is made lower, over its link facet,
 * than this fraction of the star's size. */
#define LEAST_HEIGHT 0.05

/** Whether no element that was positive at x, or may have been, has become less than positive at
 *  position, or flat. */
static inline int keeps_positive(const star *s, const double *x, const double *position,
                                 double size, const int dim) {
    lanes before[3], after[3];
    for (int d = 0; d < 3; d++) {
        before[d] = lanes_of(d < dim ? x[d] : 0);
        after[d] = lanes_of(d < dim ? position[d] : 0);
    }
    int kept = 1;
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        aspect was, is;
        measure_at(s, i, before, &was, dim);
        measure_at(s, i, after, &is, dim);
        const lanes rounding = load(s, ROUNDING, i), zero = lanes_of(0);
        lanes low = lanes_of(LEAST_HEIGHT * size) * load(s, LENGTH, i);
        lanes_mask inverted =
            lanes_greater(zero, was.D) & lanes_greater(was.D * was.D, rounding * was.aa);
        lanes_mask certain =
            lanes_greater(is.D, zero) & lanes_greater(is.D * is.D, rounding * is.aa);
        lanes_mask lower = lanes_greater(lanes_min(was.D, low), is.D);
        kept &= lanes_all_set(inverted | (certain & ~lower));
    }
    return kept;
}

/** Search along direction for a position that brings the star nearer to its minimum volumes and
 *  breaks nothing; returns whether *best was found. Volumes come first: the limit on the radius
 *  ratio does not count here. */
static inline int restoring_search(const local *here, const double *x, const objective *now,
                                   const double *direction, double step, double size, trial *best,
                                   const int dim) {
    for (int i = 0; i < RESTORE_TRIALS; i++, step *= 0.5) {
        *best = try_step(here, x, direction, step, 1, dim);
        if (best->value.shortfall < (1 - RESTORE_FALL) * now->shortfall &&
            within_bounds(&here->b, best->position, dim) &&
            keeps_positive(&here->s, x, best->position, size, dim))
            return 1;
    }
    return 0;
}

/** Find the direction of equation 5 of the paper for phi, or return 0 if it brings no violated
 * element up. Rows are the violated and active elements and bounds; the entry after the gradient is
 * the push-off factor of the violated ones. */
static inline int push_off_direction(const local *here, const double *x,
                                     const derivatives *derivative, double phi, double *direction,
                                     const int dim) {
    const star *s = &here->s;
    active a = active_none(here);
    for (int64_t i = 0; i < s->n_facets; i++) {
        const double g = *entry(s, GVALUE, i), root = 1 - g / ACTIVE_ABOVE, factor = root * root;
        double *row = g > ACTIVE_ABOVE ? add_facet_row(s, i, &a, dim) : NULL;
        if (row && g > violated_above(here))
            row[dim] = factor < PUSH_OFF_LARGEST ? factor : PUSH_OFF_LARGEST;
    }
    add_bound_rows(here, x, -ACTIVE_ABOVE, sqrt(derivative->size2), &a, dim);
    cone_point point;
    double p[4], norm = sqrt(dot(derivative->gradient, derivative->gradient, dim));
    for (int d = 0; d < dim; d++)
        p[d] = norm > 0 && norm < INFINITY ? -derivative->gradient[d] / norm : 0;
    p[dim] = phi;
    if (!cone_project((const double(*)[CONE_DIM])a.rows, a.m, p, dim + 1, &point))
        return 0;
    memcpy(direction, point.point, (size_t)dim * sizeof *direction);
    return point.point[dim] > WEIGHT_LEAST * phi;
}

/** Restore by the paper's way: push-off with growing phi. The step along each direction brings the
 *  last violated element to its floor, but none below. */
static inline int push_off(const local *here, const double *x, const objective *now,
                           const derivatives *derivative, trial *best, const int dim) {
    const star *s = &here->s;
    const double size = sqrt(derivative->size2);
    for (double phi = PHI_FIRST; phi <= PHI_LAST; phi *= PHI_FACTOR) {
        double direction[3], n[3], goal = 0;
        if (!push_off_direction(here, x, derivative, phi, direction, dim))
            continue;
        for (int64_t i = 0; i < s->n_facets; i++) {
            if (!(*entry(s, GVALUE, i) > violated_above(here)) || !facet_normal(s, i, n, dim))
                continue;
            double rise = dot(n, direction, dim) * *entry(s, LENGTH, i);
            double missing = missing_measure(here, i, restore_margin(here), size);
            double step = rise > 0 ? missing / rise : 0;
            goal = step > goal ? step : goal;
        }
        const double far = sqrt(dot(direction, direction, dim)), limit = STEP_LIMIT * size / far;
        const double rate = limiting_rate(here, x, direction, 1, dim);
        goal = goal < limit ? goal : limit;
        goal = goal * rate > FLOOR_FRACTION ? FLOOR_FRACTION / rate : goal;
        if (restoring_search(here, x, now, direction, goal, size, best, dim))
            return 1;
    }
    return 0;
}

/** Add the row of facet i to those of go_to_feasible, if it has one; 0 if not. */
static inline int add_homogeneous_row(const local *here, int64_t i, double margin, double size,
                                      active *a, const int dim) {
    const star *s = &here->s;
    double *row = *entry(s, FLOOR, i) > 0 ? add_facet_row(s, i, a, dim) : NULL;
    if (row)
        row[dim] = missing_measure(here, i, margin, size) / *entry(s, LENGTH, i);
    return row != NULL;
}

/** Find the shortest displacement to where all elements have their minimum volume; 0 if there is
 * none: then point holds the proof, rows with positive weights whose sum is (0, 1). */
static inline int shortest_displacement(const active *a, double *displacement, cone_point *point,
                                        const int dim) {
    const double p[4] = {0, 0, dim == 2, dim == 3};
    if (!cone_project((const double(*)[CONE_DIM])a->rows, a->m, p, dim + 1, point))
        return 0;
    double weight = point->point[dim];
    for (int d = 0; d < dim; d++)
        displacement[d] = point->point[d] / weight;
    return weight > WEIGHT_LEAST;
}

/** Go straight to the nearest feasible place: sum max(0, g)^2 is convex and 0 there, so it falls on
 * the way. Rows are those of {(d, t): n . d + (D - floor) t >= 0}, all of unit gradient: a
 * feasible displacement d at t = 1. Floors are taken higher by a margin, and of violated elements
 * as high as is sound; if that fails, by next to nothing. */
static inline int go_to_feasible(const local *here, const double *x, const objective *now,
                                 double size, trial *best, const int dim) {
    const double margins[] = {restore_margin(here), RESTORE_MARGIN_LAST}, sizes[] = {size, 0};
    for (int i = 0; i < 2; i++) {
        double displacement[3];
        cone_point point;
        active a = active_none(here);
        for (int64_t facet = 0; facet < here->s.n_facets; facet++)
            add_homogeneous_row(here, facet, margins[i], sizes[i], &a, dim);
        for (int d = 0; here->b.any && d < dim; d++) {
            double unit[3] = {0, 0, 0};
            unit[d] = -1;
            if (here->b.lower[d] > -INFINITY)
                add_row(&a, unit, dim)[dim] = here->b.lower[d] - x[d];
            unit[d] = 1;
            if (here->b.upper[d] < INFINITY)
                add_row(&a, unit, dim)[dim] = x[d] - here->b.upper[d];
        }
        if (shortest_displacement(&a, displacement, &point, dim) &&
            restoring_search(here, x, now, displacement, 1, size, best, dim))
            return 1;
    }
    return 0;
}

/** Take a Newton step of 1/2 sum max(0, g)^2 where no position is feasible. */
static inline int lessen_shortfall(const local *here, const double *x, const objective *now,
                                   double size, trial *best, const int dim) {
    const star *s = &here->s;
    double gradient[3] = {0, 0, 0}, hessian[6] = {0, 0, 0, 0, 0, 0}, direction[3], n[3];
    for (int64_t i = 0; i < s->n_facets; i++) {
        if (!(*entry(s, GVALUE, i) > 0) || !facet_normal(s, i, n, dim))
            continue;
        double steepness = *entry(s, LENGTH, i) * *entry(s, INVERSE_FLOOR, i);
        for (int r = 0, k = 0; r < dim; r++) {
            gradient[r] -= *entry(s, GVALUE, i) * steepness * n[r];
            for (int c = r; c < dim; c++, k++)
                hessian[k] += steepness * steepness * n[r] * n[c];
        }
    }
    if (here->slide.kind != PLANISH_CONSTRAINT_FREE) {
        slide_along(&here->slide, gradient, dim);
        slide_hessian(&here->slide, hessian, dim);
    }
    return newton_direction(gradient, hessian, direction, dim) &&
           restoring_search(here, x, now, direction, 1, size, best, dim);
}

/** Find a position at which fewer constraints are violated; returns whether *best was found. */
static inline int restore(const local *here, const double *x, const objective *now,
                          const derivatives *derivative, trial *best, const int dim) {
    const double size = sqrt(derivative->size2);
    return push_off(here, x, now, derivative, best, dim) ||
           go_to_feasible(here, x, now, size, best, dim) ||
           lessen_shortfall(here, x, now, size, best, dim);
}

#endif
