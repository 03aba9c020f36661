/* promises: whether a call of planish_smooth kept what planish.h promises of it. */
#include "support/promises.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* F, ratios and angles are as good as before if they are so to this. */
#define SLACK 1e-12L
/* Angles, in degrees: near 0 and 180 a cosine in doubles says no more. */
#define ANGLE_SLACK 1e-9L
/* What the library says in doubles, against long double. */
#define REPORTED 1e-9L
/* and this for each rounding that the volumes of bad elements magnify. */
#define DOUBLES 1e-15L
/* Where that is more, doubles say nothing of the elements. */
#define HOPELESS 1e-2L

/* ---- nodes --------------------------------------------------------------------------------- */

/** One call that is judged. */
typedef struct trial {
    promise *p;
    const planish_options *options;
    const planish_mesh *mesh;
    const double *before, *after;
    const planish_result *result;
    double ulp; /* what coordinates are rounded by */
    worth was, is;
    worth_problem problem;
    uint8_t *is_movable; /* [n_nodes] owned: that planish calls free or sliding */
    uint8_t *moves;      /* [n_nodes] owned: that it may have moved */
    int is_sure;         /* about is_movable */
} trial;

static int has_moved(const trial *t, int64_t node) {
    const size_t size = (size_t)t->mesh->dim * sizeof(double);
    return memcmp(t->before + node * t->mesh->dim, t->after + node * t->mesh->dim, size) != 0;
}

static double largest_coordinate(const trial *t) {
    double largest = 0;
    for (int64_t i = 0; i < t->mesh->n_nodes * t->mesh->dim; i++)
        largest = fmax(largest, fmax(fabs(t->before[i]), fabs(t->after[i])));
    return largest;
}

/** How far a node that slides is off its plane, line or surface. */
static double off_course(const trial *t, int64_t node) {
    const int dim = t->mesh->dim, kind = t->mesh->constraint[node];
    double along = 0, length = 0, square = 0;
    if (kind == PLANISH_CONSTRAINT_ON_SURFACE)
        return random_surface_distance(&t->p->call->surface, node, t->after + node * dim);
    for (int d = 0; d < dim; d++)
        length += t->mesh->direction[node * dim + d] * t->mesh->direction[node * dim + d];
    for (int d = 0; d < dim; d++)
        along += (t->after[node * dim + d] - t->before[node * dim + d]) *
                 t->mesh->direction[node * dim + d] / sqrt(length);
    for (int d = 0; d < dim; d++) {
        const double way = t->after[node * dim + d] - t->before[node * dim + d];
        const double off = way - along * t->mesh->direction[node * dim + d] / sqrt(length);
        square += off * off;
    }
    return kind == PLANISH_CONSTRAINT_ON_PLANE ? fabs(along) : sqrt(square);
}

/** Whether a coordinate is one that can be stored. */
static int is_storable(const trial *t, double x) {
    volatile float narrow = (float)x;
    if (t->options->precision == PLANISH_PRECISION_FLOAT)
        return (double)narrow == x;
    return t->options->precision == PLANISH_PRECISION_DOUBLE ||
           t->options->round(x, t->options->round_user) == x;
}

static int check_coordinate(const trial *t, int64_t node, int d) {
    const planish_options *o = t->options;
    const int64_t k = node * t->mesh->dim + d;
    const double x = t->after[k];
    if (x < o->box_lower[d] || x > o->box_upper[d] || (o->lower && x < o->lower[k]) ||
        (o->upper && x > o->upper[k]))
        return promise_break(t->p, "node %lld is beyond its bounds at %.17g", (long long)node, x);
    if (t->p->is_free[node] && x != t->before[k] && !is_storable(t, x))
        return promise_break(t->p, "node %lld cannot be stored at %.17g", (long long)node, x);
    return 1;
}

/** A node that is not where it was. */
static int check_moved(const trial *t, int64_t node) {
    const int dim = t->mesh->dim;
    const planish_options *o = t->options;
    const int kind = t->mesh->constraint ? t->mesh->constraint[node] : PLANISH_CONSTRAINT_FREE;
    double square = 0;
    if (!t->moves[node] || !t->p->may_move[node])
        return promise_break(t->p, "node %lld moved, but must not", (long long)node);
    for (int d = 0; d < dim; d++) {
        const double way = t->after[node * dim + d] - t->before[node * dim + d];
        square += way * way;
        if (!isfinite(t->after[node * dim + d]))
            return promise_break(t->p, "node %lld is not finite", (long long)node);
        if (!check_coordinate(t, node, d))
            return 0;
    }
    if (o->max_displacement > 0 && o->displacement_unit == PLANISH_UNIT_MESH &&
        sqrt(square) > o->max_displacement * (1 + 1e-12) + 4 * t->ulp)
        return promise_break(t->p, "node %lld went %g, farther than %g", (long long)node,
                             sqrt(square), o->max_displacement);
    if (kind != PLANISH_CONSTRAINT_FREE && off_course(t, node) > 4 * t->ulp)
        return promise_break(t->p, "node %lld slid off by %g, %g ulp", (long long)node,
                             off_course(t, node), off_course(t, node) / t->ulp);
    return 1;
}

/** How many nodes moved, and the farthest. */
static int check_count(const trial *t) {
    const int dim = t->mesh->dim;
    int64_t moved = 0;
    real farthest = 0;
    for (int64_t i = 0; i < t->mesh->n_nodes; i++) {
        real square = 0;
        for (int d = 0; d < dim; d++) {
            const real way = (real)t->after[i * dim + d] - (real)t->before[i * dim + d];
            square += way * way;
        }
        moved += square > 0;
        farthest = fmaxl(farthest, sqrtl(square));
    }
    if (moved != t->result->n_moved_nodes)
        return promise_break(t->p, "%lld nodes moved, not %lld", (long long)moved,
                             (long long)t->result->n_moved_nodes);
    if (fabsl(farthest - t->result->max_displacement) > REPORTED * farthest)
        return promise_break(t->p, "the farthest node went %Lg, not %g", farthest,
                             t->result->max_displacement);
    return 1;
}

/** Pairs move by the same. */
static int check_pairs(const trial *t) {
    const int dim = t->mesh->dim;
    for (int64_t i = 0; i < t->mesh->n_periodic; i++)
        for (int d = 0; d < dim; d++) {
            const int64_t a = (int64_t)t->mesh->periodic[2 * i] * dim + d;
            const int64_t b = (int64_t)t->mesh->periodic[2 * i + 1] * dim + d;
            const double of_a = t->after[a] - t->before[a], of_b = t->after[b] - t->before[b];
            if (fabs(of_a - of_b) > 4 * t->ulp)
                return promise_break(t->p, "pair %lld moved by %.17g and %.17g", (long long)i, of_a,
                                     of_b);
        }
    return 1;
}

static int check_nodes(const trial *t) {
    for (int64_t i = 0; i < t->mesh->n_nodes; i++)
        if (has_moved(t, i) && !check_moved(t, i))
            return 0;
    return check_count(t) && check_pairs(t);
}

/* ---- elements ------------------------------------------------------------------------------ */

/** With untangle = 0 what is not positive, or below its minimum volume, is left alone. */
static int check_left_alone(const trial *t) {
    const int corners = t->mesh->dim + 1;
    for (int64_t i = 0; i < t->mesh->n_elements; i++) {
        const int32_t *node = t->mesh->elements + i * corners;
        if (!t->p->is_known[i])
            continue;
        const int was = worth_is_positive(&t->problem, t->before, i);
        if (was && !worth_is_positive(&t->problem, t->after, i))
            return promise_break(t->p, "element %lld was positive", (long long)i);
        for (int j = 0; !was && j < corners; j++)
            if (has_moved(t, node[j]))
                return promise_break(t->p, "node %d of the inverted element %lld moved",
                                     (int)node[j], (long long)i);
    }
    return 1;
}

/** Untangling may invert elements, but repairs more. */
static int check_repairs_more(const trial *t) {
    for (int64_t i = 0; t->is.inverted == t->was.inverted && i < t->mesh->n_elements; i++)
        if (t->p->is_known[i] && worth_is_positive(&t->problem, t->before, i) &&
            !worth_is_positive(&t->problem, t->after, i))
            return promise_break(t->p, "element %lld was positive, and no more are repaired",
                                 (long long)i);
    return 1;
}

/** Of a mesh that is as it should be: F, the worst element and the smallest angle. */
static int check_no_worse(const trial *t) {
    const planish_options *o = t->options;
    const real rise = t->result->worst_sweeps > 0 ? o->worst_rise : 0;
    const real most = t->was.objective * (1 + rise);
    if (t->is.objective > most * (1 + SLACK))
        return promise_break(t->p, "F rose from %.18Lg to %.18Lg, by %.2Le of it", t->was.objective,
                             t->is.objective, t->is.objective / t->was.objective - 1);
    if (t->is.worst > t->was.worst * (1 + SLACK))
        return promise_break(t->p, "the worst RR rose from %.18Lg to %.18Lg", t->was.worst,
                             t->is.worst);
    if (o->objective == PLANISH_OBJECTIVE_RADIUS_RATIO && !(o->area_weight > 0) &&
        t->is.smallest_angle < t->was.smallest_angle - ANGLE_SLACK)
        return promise_break(t->p, "the smallest angle fell from %.18Lg to %.18Lg",
                             t->was.smallest_angle, t->is.smallest_angle);
    return 1;
}

static int check_elements(const trial *t) {
    if (t->options->method != PLANISH_METHOD_PLANISH)
        return 1;
    if (t->is.inverted > t->was.inverted)
        return promise_break(t->p, "%lld elements are inverted, %lld were",
                             (long long)t->is.inverted, (long long)t->was.inverted);
    if (t->is.below > t->was.nearly && t->is.inverted >= t->was.inverted)
        return promise_break(t->p, "%lld elements are below their minimum volume, %lld were",
                             (long long)t->is.below, (long long)t->was.nearly);
    if (!t->options->untangle && !check_left_alone(t))
        return 0;
    if (!check_repairs_more(t))
        return 0;
    return t->was.inverted > 0 || t->was.nearly > 0 || check_no_worse(t);
}

/* ---- what the result says ------------------------------------------------------------------ */

/** Of a mean over elements which may be off by loss roundings. */
static int agree(const trial *t, const char *what, real mine, real loss, double theirs) {
    if (DOUBLES * loss > HOPELESS || fabsl(mine - theirs) <= (REPORTED + DOUBLES * loss) * mine)
        return 1;
    return promise_break(t->p, "%s is %.18Lg, not %.17g", what, mine, theirs);
}

static int check_stop(const trial *t) {
    const planish_result *r = t->result;
    const planish_options *o = t->options;
    const random_watch *w = &t->p->call->watch;
    const int stopped = w->has_stopped && o->progress && r->stop != PLANISH_STOP_TIME_LIMIT;
    if ((r->stop == PLANISH_STOP_INTERRUPTED) != stopped ||
        (r->stop == PLANISH_STOP_TIME_LIMIT && !(o->time_limit > 0)) ||
        (r->stop == PLANISH_STOP_INFEASIBLE && r->n_below_min_volume == 0) ||
        r->stop < PLANISH_STOP_CONVERGED || r->stop > PLANISH_STOP_INFEASIBLE)
        return promise_break(t->p, "stop is %d", (int)r->stop);
    if (r->sweeps < r->untangling_sweeps + r->worst_sweeps ||
        r->sweeps - r->untangling_sweeps - r->worst_sweeps >
            o->max_sweeps * (r->n_put_back > 0 ? 2 : 1))
        return promise_break(t->p, "%d sweeps, %d untangling, %d for the worst", r->sweeps,
                             r->untangling_sweeps, r->worst_sweeps);
    if (o->progress && w->is_wrong)
        return promise_break(t->p, "progress is not what it should be");
    return 1;
}

static int check_result(const trial *t) {
    const planish_result *r = t->result;
    const planish_options *o = t->options;
    if (!check_stop(t))
        return 0;
    if (r->n_inverted != t->is.inverted)
        return promise_break(t->p, "%lld elements are inverted, not %lld",
                             (long long)t->is.inverted, (long long)r->n_inverted);
    if (r->n_below_min_volume < t->is.below || r->n_below_min_volume > t->is.nearly)
        return promise_break(t->p, "%lld elements are below, not %lld", (long long)t->is.below,
                             (long long)r->n_below_min_volume);
    if (!(isnan(r->kkt_residual) || r->kkt_residual >= 0) || !(r->seconds >= 0) ||
        !(r->max_multiplier >= 0) || r->visits < 0 || r->evaluations < 0 || r->n_active < 0)
        return promise_break(t->p, "numbers of the result make no sense");
    /* The minimum volume may be a fraction of what is left when volumes cancel. */
    const real least = o->area_weight > 0 && o->min_volume_fraction > 0 ? t->was.loss_domain : 0;
    return agree(t, "F before", t->was.objective, t->was.loss_objective + least,
                 r->objective_before) &&
           agree(t, "F", t->is.objective, t->is.loss_objective + least, r->objective) &&
           agree(t, "rms", t->is.rms, t->is.loss, r->rms) &&
           (!t->is_sure ||
            agree(t, "rms_movable", t->is.rms_movable, t->is.loss_movable, r->rms_movable));
}

/** Elements below their minimum volume, which is a fraction of the domain's as it is now: where
 * nodes slide on what is not flat it is not what it was. */
static int check_volumes(const trial *t) {
    worth_problem problem = t->problem;
    int64_t n;
    if (t->options->min_volume_fraction > 0)
        problem.min_volume = (double)(t->options->min_volume_fraction * fabsl(t->is.domain));
    const worth now = worth_of(&problem, t->after);
    if (planish_check_volumes(t->p->plan, t->p->call->coordinates, t->options, NULL, &n, NULL,
                              NULL) ||
        n < now.below || n > now.nearly)
        return promise_break(t->p, "planish_check_volumes: %lld, not %lld", (long long)n,
                             (long long)now.below);
    return 1;
}

/** The calls that only look. */
static int check_looks(const trial *t) {
    planish_quality q;
    int64_t n;
    if (planish_measure(t->p->plan, t->p->call->coordinates, &q, NULL) ||
        q.n_inverted != t->is.inverted || q.n_elements != t->is.n_elements)
        return promise_break(t->p, "planish_measure: %lld inverted elements, not %lld",
                             (long long)q.n_inverted, (long long)t->is.inverted);
    if (!agree(t, "RR", t->is.rms_ratio, t->is.loss_ratio, q.rms_radius_ratio))
        return 0;
    if (!check_volumes(t))
        return 0;
    if (planish_find_infeasible(t->p->plan, t->p->call->coordinates, NULL, NULL, &n, NULL, NULL) ||
        n < 0 || n > t->is.inverted)
        return promise_break(t->p, "planish_find_infeasible: %lld", (long long)n);
    return 1;
}

/** What planish calls free, and what may slide; of these it may hold some, and does where a node
 *  starts outside of its bounds. */
static void find_movable_now(trial *t) {
    const planish_options *o = t->options;
    const int dim = t->mesh->dim;
    t->is_sure = o->precision == PLANISH_PRECISION_DOUBLE;
    for (int64_t i = 0; i < t->mesh->n_nodes; i++) {
        const int slides =
            t->mesh->constraint && t->mesh->constraint[i] >= PLANISH_CONSTRAINT_ON_PLANE;
        int outside = 0;
        for (int d = 0; d < dim; d++) {
            const double x = t->before[i * dim + d];
            outside |= x < o->box_lower[d] || x > o->box_upper[d] ||
                       (o->lower && x < o->lower[i * dim + d]) ||
                       (o->upper && x > o->upper[i * dim + d]);
        }
        t->is_movable[i] = slides || t->p->is_free[i];
        t->moves[i] = t->is_movable[i] && !outside;
        t->is_sure &= !t->mesh->constraint || t->mesh->constraint[i] < PLANISH_CONSTRAINT_ON_PLANE;
    }
}

const char *promise_broken(promise *p, const planish_options *options, const double *before,
                           const double *after, const planish_result *result) {
    trial t = {.p = p,
               .options = options,
               .mesh = &p->call->dense,
               .before = before,
               .after = after,
               .result = result};
    t.is_movable = malloc((size_t)t.mesh->n_nodes + 1);
    t.moves = malloc((size_t)t.mesh->n_nodes + 1);
    if (!t.is_movable || !t.moves)
        abort();
    find_movable_now(&t);
    t.ulp = largest_coordinate(&t) * DBL_EPSILON;
    if (options->precision == PLANISH_PRECISION_FLOAT)
        t.ulp = largest_coordinate(&t) * (double)FLT_EPSILON;
    if (options->precision == PLANISH_PRECISION_ROUNDED)
        t.ulp += p->call->quantum;
    t.problem = (worth_problem){.mesh = t.mesh,
                                .sign = p->sign,
                                .is_known = p->is_known,
                                .is_movable = t.is_movable,
                                .moves = t.moves,
                                .objective = options->objective,
                                .area_weight = options->area_weight,
                                .min_volume = options->min_volume};
    if (options->min_volume_fraction > 0) {
        t.was = worth_of(&t.problem, before);
        t.problem.min_volume = (double)(options->min_volume_fraction * fabsl(t.was.domain));
    }
    t.was = worth_of(&t.problem, before);
    t.is = worth_of(&t.problem, after);
    if (check_nodes(&t) && p->n_doubtful == 0 && check_elements(&t) && check_result(&t))
        check_looks(&t);
    free(t.is_movable);
    free(t.moves);
    return p->text[0] ? p->text : NULL;
}
