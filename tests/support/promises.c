/* promises: whether a call of planish_smooth kept what planish.h promises of it. */
#include "support/promises.h"

#include "support/facets.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* F, ratios and angles are as good as before if they are so to this. */
#define SLACK 1e-12L
/* Angles, in degrees: near 0 and 180 a cosine in doubles says no more. */
#define ANGLE_SLACK 1e-9L
/* What the library says in doubles, against long double. */
#define REPORTED 1e-9L
/* times that the worse the elements are, */
#define DOUBLES 1e-13L
/* Where elements are so bad that doubles say nothing of them. */
#define HOPELESS 1e7L

static void *checked(void *memory) {
    if (!memory)
        abort();
    return memory;
}

/** Note what is broken; the first one stands. Returns 0 for short statements. */
static int broken(promise *p, const char *format, ...) __attribute__((format(printf, 2, 3)));

static int broken(promise *p, const char *format, ...) {
    va_list arguments;
    if (p->text[0])
        return 0;
    va_start(arguments, format);
    vsnprintf(p->text, sizeof p->text, format, arguments);
    va_end(arguments);
    return 0;
}

/* ---- which nodes may move ------------------------------------------------------------------ */

/** Nodes of elements that are bad for options.only_worse_than, beyond rounding or nearly. */
static void select_bad(const promise *p, const double *x, uint8_t *selected) {
    const planish_options *o = &p->call->plan_options;
    const planish_mesh *mesh = &p->call->dense;
    const int corners = mesh->dim + 1;
    const worth_problem problem = {.mesh = mesh, .sign = p->sign, .min_volume = o->min_volume};
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const real ratio = worth_ratio(&problem, x, i);
        const int bad = !(ratio > 0) || ratio > o->only_worse_than * (1 - REPORTED) ||
                        worth_least(&problem, i) > 0 || o->min_volume_fraction > 0;
        for (int j = 0; bad && j < corners; j++)
            selected[mesh->elements[i * corners + j]] = 1;
    }
}

/** The nodes of so many layers of elements around, and their partners. */
static void spread(const planish_mesh *mesh, int layers, uint8_t *selected) {
    const int corners = mesh->dim + 1;
    for (int k = 0; k < layers; k++) {
        uint8_t *before = checked(malloc((size_t)mesh->n_nodes + 1));
        memcpy(before, selected, (size_t)mesh->n_nodes);
        for (int64_t i = 0; i < mesh->n_elements; i++) {
            int has = 0;
            for (int j = 0; j < corners; j++)
                has |= before[mesh->elements[i * corners + j]];
            for (int j = 0; has && j < corners; j++)
                selected[mesh->elements[i * corners + j]] = 1;
        }
        free(before);
    }
    for (int64_t k = 0; k < 8; k++)
        for (int64_t i = 0; i < mesh->n_periodic; i++) {
            uint8_t *a = &selected[mesh->periodic[2 * i]],
                    *b = &selected[mesh->periodic[2 * i + 1]];
            *a = *b = *a | *b;
        }
}

/** selected [n_nodes]: 1 for what the plan may work on. */
static void select_nodes(const promise *p, const double *x, uint8_t *selected) {
    enum { AROUND_TANGLES = 4 };
    const planish_options *o = &p->call->plan_options;
    const int64_t n = p->call->dense.n_nodes;
    if (o->around) {
        for (int64_t i = 0; i < o->n_around; i++)
            selected[o->around[i]] = 1;
        spread(&p->call->dense, o->layers, selected);
    } else if (o->only_worse_than > 0) {
        const worth_problem problem = {
            .mesh = &p->call->dense, .sign = p->sign, .is_movable = selected};
        const int tangled = worth_of(&problem, x).inverted > 0;
        select_bad(p, x, selected);
        spread(&p->call->dense, tangled && o->layers < AROUND_TANGLES ? AROUND_TANGLES : o->layers,
               selected);
    } else {
        memset(selected, 1, (size_t)n);
    }
}

/** Whether the plan knows only those elements of a node that are joined to a given one there. */
static int walks(const random_call *call) {
    return call->plan_options.around_elements &&
           (call->given.neighbours || call->given.neighbours64);
}

static void find_movable(promise *p, const double *x) {
    const planish_mesh *mesh = &p->call->dense;
    const planish_options *o = &p->call->options;
    uint8_t *inside = checked(malloc((size_t)mesh->n_nodes + 1));
    uint8_t *selected = checked(calloc((size_t)mesh->n_nodes + 1, 1));
    test_inside(mesh, walks(p->call) ? p->is_known : NULL, inside);
    select_nodes(p, x, selected);
    for (int64_t i = 0; i < mesh->n_periodic * 2; i++)
        inside[mesh->periodic[i]] = 0; /* these slide or stay */
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int kind = mesh->constraint ? mesh->constraint[i] : PLANISH_FREE;
        const int slides = kind == PLANISH_ON_PLANE || kind == PLANISH_ON_LINE ||
                           (kind == PLANISH_ON_SURFACE && o->project);
        p->may_move[i] = selected[i] && (slides || (kind == PLANISH_FREE && inside[i]));
        if (p->is_free[i] && (kind != PLANISH_FREE || !p->may_move[i]))
            broken(p, "node %lld is free, but must not be", (long long)i);
    }
    free(inside);
    free(selected);
}

/* ---- what is known ------------------------------------------------------------------------- */

/** The one order of the file's that all known elements are positive in: +1 or -1; 0: there is none.
 */
static int common_order(const promise *p, const double *x) {
    const planish_mesh *mesh = &p->call->dense;
    int64_t positive = 0, negative = 0, n = 0;
    int8_t *sign = checked(malloc((size_t)mesh->n_elements + 1));
    const worth_problem problem = {.mesh = mesh, .sign = sign};
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        n += p->is_known[i];
        sign[i] = 1;
        positive += p->is_known[i] && worth_is_positive(&problem, x, i);
        sign[i] = -1;
        negative += p->is_known[i] && worth_is_positive(&problem, x, i);
    }
    free(sign);
    return positive == n ? 1 : negative == n ? -1 : 0;
}

/** What the plan knows of, and the signs of these elements. Where measures cancel they are
 *  planish's; and where the plan is for some nodes, and measures agree, facets are not asked. */
static void find_known(promise *p, const double *x) {
    const planish_mesh *mesh = &p->call->dense;
    const planish_options *o = &p->call->plan_options;
    double *ratio = checked(malloc((size_t)mesh->n_elements * sizeof *ratio + 1));
    if (planish_measure_elements(p->plan, p->call->coordinates, ratio, NULL))
        broken(p, "planish_measure_elements failed");
    for (int64_t i = 0; i < mesh->n_elements; i++)
        p->is_known[i] = (uint8_t)!isnan(ratio[i]);
    const int64_t doubtful = test_orient(mesh, x, p->is_known, p->sign);
    const int order = o->around || o->only_worse_than > 0 ? common_order(p, x) : 0;
    const worth_problem problem = {.mesh = mesh, .sign = p->sign};
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        if (!p->is_known[i] || worth_is_positive(&problem, x, i) == (ratio[i] > 0))
            continue;
        p->sign[i] = (int8_t)(order ? order : -p->sign[i]);
        if ((doubtful == 0 && order == 0) || worth_is_positive(&problem, x, i) != (ratio[i] > 0))
            broken(p, "element %lld has RR %g", (long long)i, ratio[i]);
    }
    free(ratio);
}

void promise_create(promise *p, const random_call *call, const planish_plan *plan,
                    const double *coordinates) {
    const size_t n = (size_t)call->dense.n_nodes + 1, m = (size_t)call->dense.n_elements + 1;
    *p = (promise){.call = call, .plan = plan};
    p->sign = checked(malloc(m));
    p->is_known = checked(malloc(m));
    p->is_free = checked(malloc(n));
    p->may_move = checked(malloc(n));
    planish_plan_get_info(plan, &p->info);
    planish_plan_get_free(plan, p->is_free);
    find_known(p, coordinates);
    find_movable(p, coordinates);
}

void promise_destroy(promise *p) {
    free(p->sign);
    free(p->is_known);
    free(p->is_free);
    free(p->may_move);
}

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
    uint8_t *is_movable; /* [n_nodes] owned: that planish may have moved */
    int is_sure;         /* that it calls free or sliding */
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
    if (kind == PLANISH_ON_SURFACE)
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
    return kind == PLANISH_ON_PLANE ? fabs(along) : sqrt(square);
}

/** Whether a coordinate is one that can be stored. */
static int is_storable(const trial *t, double x) {
    volatile float narrow = (float)x;
    if (t->options->precision == PLANISH_FLOAT)
        return (double)narrow == x;
    return t->options->precision == PLANISH_DOUBLE ||
           t->options->round(x, t->options->round_user) == x;
}

static int check_coordinate(const trial *t, int64_t node, int d) {
    const planish_options *o = t->options;
    const int64_t k = node * t->mesh->dim + d;
    const double x = t->after[k];
    if (x < o->box_lower[d] || x > o->box_upper[d] || (o->lower && x < o->lower[k]) ||
        (o->upper && x > o->upper[k]))
        return broken(t->p, "node %lld is beyond its bounds at %.17g", (long long)node, x);
    if (t->p->is_free[node] && x != t->before[k] && !is_storable(t, x))
        return broken(t->p, "node %lld cannot be stored at %.17g", (long long)node, x);
    return 1;
}

/** A node that is not where it was. */
static int check_moved(const trial *t, int64_t node) {
    const int dim = t->mesh->dim;
    const planish_options *o = t->options;
    const int kind = t->mesh->constraint ? t->mesh->constraint[node] : PLANISH_FREE;
    double square = 0;
    if (!t->is_movable[node] || !t->p->may_move[node])
        return broken(t->p, "node %lld moved, but must not", (long long)node);
    for (int d = 0; d < dim; d++) {
        const double way = t->after[node * dim + d] - t->before[node * dim + d];
        square += way * way;
        if (!isfinite(t->after[node * dim + d]))
            return broken(t->p, "node %lld is not finite", (long long)node);
        if (!check_coordinate(t, node, d))
            return 0;
    }
    if (o->max_displacement > 0 && o->displacement_unit == PLANISH_UNIT_MESH &&
        sqrt(square) > o->max_displacement * (1 + 1e-12) + 4 * t->ulp)
        return broken(t->p, "node %lld went %g, farther than %g", (long long)node, sqrt(square),
                      o->max_displacement);
    if (kind != PLANISH_FREE && off_course(t, node) > 4 * t->ulp)
        return broken(t->p, "node %lld slid off by %g, %g ulp", (long long)node,
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
    if (moved != t->result->moved_nodes)
        return broken(t->p, "%lld nodes moved, not %lld", (long long)moved,
                      (long long)t->result->moved_nodes);
    if (fabsl(farthest - t->result->max_displacement) > REPORTED * farthest)
        return broken(t->p, "the farthest node went %Lg, not %g", farthest,
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
                return broken(t->p, "pair %lld moved by %.17g and %.17g", (long long)i, of_a, of_b);
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

/** With untangle = 0 what is not positive, or below its least volume, is left alone. */
static int check_left_alone(const trial *t) {
    const int corners = t->mesh->dim + 1;
    for (int64_t i = 0; i < t->mesh->n_elements; i++) {
        const int32_t *node = t->mesh->elements + i * corners;
        if (!t->p->is_known[i])
            continue;
        const int was = worth_is_positive(&t->problem, t->before, i);
        if (was && !worth_is_positive(&t->problem, t->after, i))
            return broken(t->p, "element %lld was positive", (long long)i);
        for (int j = 0; !was && j < corners; j++)
            if (has_moved(t, node[j]))
                return broken(t->p, "node %d of the inverted element %lld moved", (int)node[j],
                              (long long)i);
    }
    return 1;
}

/** Of a mesh that is as it should be: F, the worst element and the smallest angle. */
static int check_no_worse(const trial *t) {
    const planish_options *o = t->options;
    const real rise = t->result->worst_sweeps > 0 ? o->worst_rise : 0;
    const real most = t->was.objective * (1 + rise);
    if (t->is.objective > most * (1 + SLACK))
        return broken(t->p, "F rose from %.18Lg to %.18Lg, by %.2Le of it", t->was.objective,
                      t->is.objective, t->is.objective / t->was.objective - 1);
    if (t->is.worst > t->was.worst * (1 + SLACK))
        return broken(t->p, "the worst RR rose from %.18Lg to %.18Lg", t->was.worst, t->is.worst);
    if (o->objective == PLANISH_RADIUS_RATIO && !(o->area_weight > 0) &&
        t->is.smallest_angle < t->was.smallest_angle - ANGLE_SLACK)
        return broken(t->p, "the smallest angle fell from %.18Lg to %.18Lg", t->was.smallest_angle,
                      t->is.smallest_angle);
    return 1;
}

static int check_elements(const trial *t) {
    if (t->options->method != PLANISH_METHOD_PLANISH)
        return 1;
    if (t->is.inverted > t->was.inverted)
        return broken(t->p, "%lld elements are inverted, %lld were", (long long)t->is.inverted,
                      (long long)t->was.inverted);
    if (t->is.below > t->was.nearly && t->is.inverted >= t->was.inverted)
        return broken(t->p, "%lld elements are below their least volume, %lld were",
                      (long long)t->is.below, (long long)t->was.nearly);
    if (!t->options->untangle && !check_left_alone(t))
        return 0;
    return t->was.inverted > 0 || t->was.nearly > 0 || check_no_worse(t);
}

/* ---- what the result says ------------------------------------------------------------------ */

static int agree(const trial *t, const char *what, real mine, double theirs) {
    const real ratio = fmaxl(t->was.rms_ratio, t->is.rms_ratio); /* about what is lost of D */
    if (fabsl(mine - theirs) <= (REPORTED + DOUBLES * ratio) * fabsl(mine))
        return 1;
    return broken(t->p, "%s is %.18Lg, not %.17g", what, mine, theirs);
}

static int check_stop(const trial *t) {
    const planish_result *r = t->result;
    const planish_options *o = t->options;
    const random_watch *w = &t->p->call->watch;
    const int stopped = w->has_stopped && o->progress && r->stop != PLANISH_STOP_TIME_LIMIT;
    if ((r->stop == PLANISH_STOP_INTERRUPTED) != stopped ||
        (r->stop == PLANISH_STOP_TIME_LIMIT && !(o->time_limit > 0)) ||
        (r->stop == PLANISH_STOP_INFEASIBLE && r->below_min_volume == 0) ||
        r->stop < PLANISH_STOP_CONVERGED || r->stop > PLANISH_STOP_INFEASIBLE)
        return broken(t->p, "stop is %d", (int)r->stop);
    if (r->sweeps < r->untangling_sweeps + r->worst_sweeps ||
        r->sweeps - r->untangling_sweeps - r->worst_sweeps >
            o->max_sweeps * (r->put_back > 0 ? 2 : 1))
        return broken(t->p, "%d sweeps, %d untangling, %d for the worst", r->sweeps,
                      r->untangling_sweeps, r->worst_sweeps);
    if (o->progress && w->is_wrong)
        return broken(t->p, "progress is not what it should be");
    return 1;
}

static int check_result(const trial *t) {
    const planish_result *r = t->result;
    if (!check_stop(t))
        return 0;
    if (r->inverted != t->is.inverted)
        return broken(t->p, "%lld elements are inverted, not %lld", (long long)t->is.inverted,
                      (long long)r->inverted);
    if (r->below_min_volume < t->is.below || r->below_min_volume > t->is.nearly)
        return broken(t->p, "%lld elements are below, not %lld", (long long)t->is.below,
                      (long long)r->below_min_volume);
    if (!(isnan(r->kkt_residual) || r->kkt_residual >= 0) || !(r->seconds >= 0) ||
        !(r->max_multiplier >= 0) || r->visits < 0 || r->evaluations < 0 || r->n_active < 0)
        return broken(t->p, "numbers of the result make no sense");
    if (t->was.rms_ratio > HOPELESS || t->is.rms_ratio > HOPELESS)
        return 1;
    return agree(t, "F before", t->was.objective, r->objective_before) &&
           agree(t, "F", t->is.objective, r->objective) && agree(t, "rms", t->is.rms, r->rms) &&
           (!t->is_sure || agree(t, "rms_movable", t->is.rms_movable, r->rms_movable));
}

/** Elements below their least volume, which is a fraction of the domain's as it is now: where nodes
 *  slide on what is not flat it is not what it was. */
static int check_volumes(const trial *t) {
    worth_problem problem = t->problem;
    int64_t n;
    if (t->options->min_volume_fraction > 0)
        problem.min_volume = (double)(t->options->min_volume_fraction * fabsl(t->is.domain));
    const worth now = worth_of(&problem, t->after);
    if (planish_check_volumes(t->p->plan, t->p->call->coordinates, t->options, NULL, &n, NULL) ||
        n < now.below || n > now.nearly)
        return broken(t->p, "planish_check_volumes: %lld, not %lld", (long long)n,
                      (long long)now.below);
    return 1;
}

/** The calls that only look. */
static int check_looks(const trial *t) {
    planish_quality q;
    int64_t n;
    if (planish_measure(t->p->plan, t->p->call->coordinates, &q, NULL) ||
        q.inverted != t->is.inverted || q.n_elements != t->is.n_elements)
        return broken(t->p, "planish_measure: %lld inverted elements, not %lld",
                      (long long)q.inverted, (long long)t->is.inverted);
    if (t->is.rms_ratio < HOPELESS && !agree(t, "RR", t->is.rms_ratio, q.rms_radius_ratio))
        return 0;
    if (!check_volumes(t))
        return 0;
    if (planish_find_unfixable(t->p->plan, t->p->call->coordinates, NULL, &n, NULL) || n < 0 ||
        n > t->is.inverted)
        return broken(t->p, "planish_find_unfixable: %lld", (long long)n);
    return 1;
}

/** What planish calls free, and what may slide; of these it may hold some, and does where a node
 *  starts outside of its bounds. */
static void find_movable_now(trial *t) {
    const planish_options *o = t->options;
    const int dim = t->mesh->dim;
    t->is_sure = o->precision == PLANISH_DOUBLE;
    for (int64_t i = 0; i < t->mesh->n_nodes; i++) {
        const int slides = t->mesh->constraint && t->mesh->constraint[i] >= PLANISH_ON_PLANE;
        int outside = 0;
        for (int d = 0; d < dim; d++) {
            const double x = t->before[i * dim + d];
            outside |= x < o->box_lower[d] || x > o->box_upper[d] ||
                       (o->lower && x < o->lower[i * dim + d]) ||
                       (o->upper && x > o->upper[i * dim + d]);
        }
        t->is_movable[i] = (slides || t->p->is_free[i]) && !outside;
        t->is_sure &= !t->mesh->constraint || t->mesh->constraint[i] < PLANISH_ON_PLANE;
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
    t.is_movable = checked(malloc((size_t)t.mesh->n_nodes + 1));
    find_movable_now(&t);
    t.ulp = largest_coordinate(&t) * DBL_EPSILON;
    if (options->precision == PLANISH_FLOAT)
        t.ulp = largest_coordinate(&t) * (double)FLT_EPSILON;
    if (options->precision == PLANISH_ROUNDED)
        t.ulp += p->call->quantum;
    t.problem = (worth_problem){.mesh = t.mesh,
                                .sign = p->sign,
                                .is_known = p->is_known,
                                .is_movable = t.is_movable,
                                .objective = options->objective,
                                .area_weight = options->area_weight,
                                .min_volume = options->min_volume};
    if (options->min_volume_fraction > 0) {
        t.was = worth_of(&t.problem, before);
        t.problem.min_volume = (double)(options->min_volume_fraction * fabsl(t.was.domain));
    }
    t.was = worth_of(&t.problem, before);
    t.is = worth_of(&t.problem, after);
    p->put_back += result->put_back;
    if (check_nodes(&t) && check_elements(&t) && check_result(&t))
        check_looks(&t);
    free(t.is_movable);
    return p->text[0] ? p->text : NULL;
}

/* ---- what is refused ----------------------------------------------------------------------- */

int promise_refusal(const random_call *call) {
    const planish_options *o = &call->options, *of_plan = &call->plan_options;
    const double *own = call->dense.min_volume;
    int all = o->min_volume > 0 || o->min_volume_fraction > 0;
    if (o->worst != PLANISH_WORST_NONE && o->method != PLANISH_METHOD_PLANISH)
        return 1;
    if (o->around && (of_plan->only_worse_than > 0 || o->min_volume_fraction > 0))
        return 1;
    if (!all && own) {
        all = 1;
        for (int64_t i = 0; i < call->dense.n_elements; i++)
            all &= own[i] > 0;
    }
    if (o->area_weight > 0 && !all)
        return o->around ? -1 : 1; /* of the elements around */
    /* Fractions of no domain, weights of volumes that differ by orders of magnitude: */
    return call->level[OF_TANGLE] != RANDOM_VALID || call->level[OF_SHAPE] == RANDOM_GARBAGE ? -1
                                                                                             : 0;
}
