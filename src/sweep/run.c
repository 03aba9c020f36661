/* run: the sweeps of one call of planish_smooth, and the mesh quality meanwhile. */
#include "sweep/run.h"

#include "base/clock.h"
#include "base/context.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/positions.h"
#include "geometry/angle.h"
#include "sweep/positions.h"

#include <limits.h>
#include <math.h>
#include <string.h>

enum { CHUNK_NODES = 4096 };

/* Where the tracked sum has fallen below this fraction of the one measured last, rounding, of some
 * 1e-15 of that one, could come near to the tolerance: measure again. */
#define MEASURE_AGAIN 0.01

/** Copy the present coordinates in the order of the plan's mesh, for measuring. */
static void transfer_measured(void *context, int64_t begin, int64_t end, int thread) {
    const pl_run *r = context;
    const planish_plan *plan = r->plan;
    const int dim = plan->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim; d++)
            plan->scratch.to_measure[i * dim + d] =
                plan->scratch.coordinates[(int64_t)plan->inner[i] * dim + d] * r->measure_scale;
}

/* ---- the quality of the mesh -------------------------------------------------------------- */

double pl_run_objective(const pl_run *r) {
    return pl_objective_of_all(r->options, &r->sums);
}

/** Largest RR^2, with corners mu^2. */
static double worst_ratio(const pl_run *r) {
    return r->plan->work.corner ? r->sums.corner_max : r->sums.radius_max;
}

double pl_run_blunt(const pl_run *r, double acuteness) {
    if (r->plan->work.target && acuteness < INFINITY) /* these say nothing of angles */
        return 0;
    return r->plan->work.corner ? pl_blunt_mean_square(r->plan->dim, r->kinds, acuteness)
                                : pl_blunt_ratio_square(r->plan->dim, acuteness);
}

pl_star_limits pl_run_worst_limits(const pl_run *r, double margin) {
    const double acuteness = r->may_be_sharp ? INFINITY : r->sums.acuteness * margin;
    return (pl_star_limits){worst_ratio(r) * margin, acuteness, pl_run_blunt(r, acuteness)};
}

int pl_run_is_within(const pl_run *r, double ratio, double acuteness) {
    return worst_ratio(r) <= ratio && r->sums.acuteness <= acuteness;
}

pl_objective_problem pl_run_objective_problem(const pl_run *r) {
    const planish_plan *plan = r->plan;
    pl_view mesh = pl_view_of_all_elements(&plan->work);
    if (r->guard.mobility)
        mesh.mobility = r->guard.mobility;
    return pl_objective_problem_of(&mesh, plan->scratch.to_measure, r->options, r->guard.min_volume,
                                   plan->threads);
}

/** Sum over a mesh at x: of a plain run of simplices the radius ratios alone. */
static void sum_up(const pl_run *r, const pl_view *mesh, const double *x, pl_objective_sums *sums) {
    pl_ratio_sums plain;
    if (!r->plain || mesh->corner) {
        const pl_objective_problem problem =
            pl_objective_problem_of(mesh, x, r->options, r->guard.min_volume, r->plan->threads);
        pl_sum_objective(&problem, sums);
        return;
    }
    pl_sum_radius_ratio(mesh, x, r->plan->threads, &plain);
    *sums = (pl_objective_sums){.ratio = {plain.fixed, plain.movable},
                                .n = {(double)plain.n_fixed, (double)plain.n_movable},
                                .radius_max = plain.max,
                                .acuteness = plain.acuteness,
                                .inverted = (double)plain.inverted};
}

double pl_run_rms_of_movable(const pl_run *r, const pl_objective_sums *sums) {
    return pl_rms(sums->ratio[1] + r->ratio_of_held, sums->n[1] + r->n_of_held);
}

/** Sum over the elements whose nodes are held. They do not change, but for sizes that are fitted to
 *  the mesh. */
static void measure_held(pl_run *r) {
    pl_objective_problem problem = pl_run_objective_problem(r);
    pl_objective_sums sums;
    if (!r->guard.is_held || (r->knows_held && !r->plan->sizes))
        return;
    problem.mesh.is_movable = r->guard.is_held;
    pl_sum_objective(&problem, &sums);
    r->ratio_of_held = sums.ratio[1];
    r->n_of_held = sums.n[1];
    r->knows_held = 1;
}

void pl_run_measure(pl_run *r) {
    const planish_plan *plan = r->plan;
    const pl_objective_problem problem = pl_run_objective_problem(r);
    pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, transfer_measured, r);
    sum_up(r, r->plain ? &plan->work : &problem.mesh, plan->scratch.to_measure, &r->sums);
    r->sums.inside = (double)pl_watch_measure(&r->watch);
    r->sums.inverted += r->sums.inside;
    r->measured_sum = r->sums.ratio[1];
    measure_held(r);
    if (plan->all == &plan->work)
        return;
    r->sums.ratio[0] = r->sums_of_fixed.ratio[0];
    r->sums.volume[0] = r->sums_of_fixed.volume[0];
    r->sums.n[0] = r->sums_of_fixed.n[0];
}

void pl_run_measure_inverted(pl_run *r) {
    if (r->sums.inverted > 0)
        pl_run_measure(r);
}

void pl_run_measure_fixed(pl_run *r, const double *all) {
    const planish_plan *plan = r->plan;
    const uint8_t *mobility = r->guard.mobility ? r->guard.mobility : plan->work.mobility;
    const int corners = plan->dim + 1;
    pl_view whole = plan->whole;
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        plan->scratch.is_movable[plan->element_of[i]] =
            (uint8_t)pl_any_moves(mobility, plan->work.elements + i * corners, corners);
    whole.is_movable = plan->scratch.is_movable;
    sum_up(r, &whole, all, &r->sums_of_fixed);
}

/* ---- progress and limits ------------------------------------------------------------------- */

/** Progress for the caller. A trial stays hidden: the figures are those of the mesh that would be
 *  returned. */
static planish_progress progress_of(const pl_run *r, int colour, int64_t visits) {
    const double now = pl_seconds();
    const pl_objective_sums *seen = r->shown ? &r->shown->standing : &r->sums;
    return (planish_progress){
        .sweep = r->sweep,
        .colour = colour,
        .n_colours = pl_plan_colours(r->plan),
        .rms = pl_rms_of_all(seen),
        .rms_movable = pl_run_rms_of_movable(r, seen),
        .objective = pl_objective_of_all(r->options, seen),
        .n_inverted = (int64_t)(seen->inverted + r->sums_of_fixed.inverted),
        .n_below_min_volume = (int64_t)(seen->below + r->sums_of_fixed.below),
        .phase = r->shown && r->phase == PLANISH_PHASE_UNTANGLE ? PLANISH_PHASE_SMOOTH : r->phase,
        .visits = visits,
        .seconds = now - r->sweep_start,
        .elapsed = now - r->start_seconds};
}

/** Positions of the mesh that the figures of progress are about. */
static pl_positions positions_of(const pl_run *r) {
    const planish_plan *plan = r->plan;
    return (pl_positions){.plan = plan,
                          .given = r->given,
                          .now = r->shown ? r->shown->before : plan->scratch.coordinates,
                          .mids = pl_watch_has_mids(&r->watch) ? &r->watch.mids : NULL,
                          .skin = &r->skin,
                          .saved = r->shown ? r->shown->skin : NULL};
}

int pl_ask_caller(const planish_options *options, const planish_progress *progress) {
    if (!options->progress)
        return 0;
    pl_context *before = pl_context_enter(NULL);
    const int failed = before->failed; /* not what the caller asks of the plan meanwhile */
    const int answer = options->progress(progress, options->progress_user);
    before->failed = failed;
    pl_context_enter(before);
    return answer;
}

int pl_run_after_colour(void *run, int colours_done, int64_t visits) {
    const pl_run *r = run;
    planish_progress progress = progress_of(r, colours_done, 0);
    progress.colour_visits = visits;
    if (pl_ask_caller(r->options, &progress))
        return PLANISH_STOP_INTERRUPTED;
    if (r->options->time_limit > 0 && progress.elapsed >= r->options->time_limit)
        return PLANISH_STOP_TIME_LIMIT;
    return 0;
}

static int ask_between_sweeps(void *run) {
    return pl_run_after_colour(run, 0, 0);
}

pl_stop_check pl_run_stop_check(pl_run *r) {
    return pl_limit_of(ask_between_sweeps, r);
}

int pl_run_ask_all(pl_run *r, int colours_done, int64_t visits) {
    double answer = pl_run_after_colour(r, colours_done, visits);
    pl_parts_largest(&answer, 1);
    return (int)answer;
}

int pl_run_sweeps_left(const pl_run *r) {
    const int uncounted =
        r->uncounted_sweeps > 0 ? r->uncounted_sweeps : r->result->untangling_sweeps;
    return r->options->max_sweeps - (r->sweep - uncounted);
}

int pl_run_has_followers(const pl_run *r) {
    return r->options->method == PLANISH_METHOD_PLANISH && r->plan->sliding.n_followers > 0;
}

/* ---- sweeps ------------------------------------------------------------------------------- */

/* See pl_star_problem.calm, as a part of the tolerance. Twice as much would save as much again, but
 * leave the gradient three times as large. */
#define CALM 0.5

/* Where elements can have the shapes that they are to have, the RMS is flat: what is left of it is the
 * square of how far nodes are off, in lengths of the error. So less may be left, down to rounding. */
#define PART_WITH_TARGETS 0.01
#define LEAST_TOLERANCE   1e-15
#define LEAST_EXCESS      1e-12

/** The tolerance of the sweeps. */
static double tolerance_of(const pl_run *r) {
    const double tolerance = r->options->tolerance;
    return r->plan->work.target ? fmax(tolerance * PART_WITH_TARGETS, LEAST_TOLERANCE) : tolerance;
}

double pl_run_excess(const pl_run *r) {
    return r->plan->work.target ? fmax(1 - 1 / pl_rms_of_movable(&r->sums), LEAST_EXCESS) : 1;
}

/* The worst cell may move only if it becomes better by more than rounding. */
#define CELL_MARGIN (1 - 1e-12)

/** Limits of the ordinary sweeps. Corners can be too sharp long before they are flat, and an average
 *  over a cell hides it: their limit is in force from the first sweep on. */
static pl_star_limits limits_of_sweeps(const pl_run *r) {
    const planish_options *o = r->options;
    const pl_star_limits worst = pl_run_worst_limits(r, PL_LIMIT_MARGIN);
    if (r->plan->work.corner && pl_is_mean(o->objective) && !(o->area_weight > 0))
        return worst;
    pl_star_limits limits = pl_star_no_limits();
    limits.rr2 = worst.rr2;
    return limits;
}

/** Let elements whose targets go with them be as bad as the worst of the mesh as it came: the limits of the
 *  mesh as it is become narrower with each sweep. */
static void widen_to_start(pl_run *r) {
    if (!r->plan->sizes || !(r->worst_at_start < INFINITY))
        return;
    r->problem.limits.rr2 = fmax(r->problem.limits.rr2, r->limits_at_start.rr2 * PL_LIMIT_MARGIN);
    r->watch.worst_ar2 = fmax(r->watch.worst_ar2, r->worst_at_start * PL_LIMIT_MARGIN);
}

void pl_run_prepare(pl_run *r) {
    const planish_plan *plan = r->plan;
    const double worse = r->options->only_worse_than;
    r->problem = pl_plan_problem(plan, &plan->interior);
    r->problem.search = r->options->search;
    r->problem.limits = limits_of_sweeps(r);
    r->watch.worst_ar2 = plan->work.corner ? r->sums.radius_max * CELL_MARGIN : INFINITY;
    widen_to_start(r);
    /* In rings around bad elements good stars are meant, too. */
    r->problem.rr2_skip = plan->is_selective && r->options->rings > 0 ? 0 : worse * worse;
    r->problem.calm = plan->is_selective ? 0 : CALM * tolerance_of(r);
    r->problem.storage = pl_storage_of(r->options);
    r->problem.objective = r->options->objective;
    r->problem.guard = r->guard.in_visits ? &r->guard.star : NULL;
    if (r->options->search == PLANISH_SEARCH_NEWTON)
        r->problem.kept = plan->scratch.kept;
    pl_run_begin_anew(r);
}

pl_star_problem pl_run_sliding_problem(pl_run *r) {
    pl_star_problem problem = pl_plan_problem(r->plan, &r->plan->sliding);
    r->sliding_guard = r->guard.star;
    r->sliding_guard.link_min_volume = r->plan->sliding.stars.min_volume;
    problem.guard = &r->sliding_guard;
    problem.search = r->problem.search;
    if (r->problem.kept)
        problem.kept = r->problem.kept + r->plan->interior.stars.n_stars;
    problem.limits = r->problem.limits;
    problem.calm = r->problem.calm;
    problem.rr2_skip = r->problem.rr2_skip;
    problem.storage = r->problem.storage;
    problem.project = r->options->project;
    problem.project_user = r->options->project_user;
    if (r->skin.shape) {
        problem.project = pl_skin_ask;
        problem.project_user = &r->skin;
    }
    return problem;
}

static void forget(void *context, int64_t begin, int64_t end, int thread) {
    pl_star_kept *kept = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        kept[i].sum = 0;
}

void pl_run_begin_anew(pl_run *r) {
    const planish_plan *plan = r->plan;
    memset(plan->scratch.changed, 1, (size_t)plan->work.n_nodes);
    pl_watch_measure(&r->watch); /* nodes may have moved otherwise than by visits */
    pl_watch_limit(&r->watch, r->watch.worst_ar2);
    if (r->problem.kept)
        pl_parallel_for(plan->threads, plan->interior.stars.n_stars + plan->sliding.stars.n_stars,
                        CHUNK_NODES, forget, r->problem.kept);
}

void pl_run_begin_sweep(pl_run *r) {
    r->sweep++;
    r->sweep_start = pl_seconds();
}

int pl_run_end_sweep(pl_run *r, const pl_sweep_tally *tally) {
    r->result->visits += tally->stars.visits;
    r->result->evaluations += tally->stars.evaluations;
    const pl_positions from = positions_of(r);
    const struct planish_positions positions = {pl_positions_fill, &from, r->plan->context,
                                                r->coordinates};
    planish_progress progress = progress_of(r, tally->colours, tally->stars.visits);
    progress.sweep_done = 1;
    progress.positions = &positions;
    const int stopped = pl_parts_any(pl_ask_caller(r->options, &progress));
    if (!tally->stopped && !stopped)
        return 0;
    /* The reason to stop that there was before stands, whatever the answer. */
    r->stop = tally->stopped ? (planish_stop)tally->stopped : PLANISH_STOP_INTERRUPTED;
    return 1;
}

void pl_run_sweep_colours(pl_run *r, pl_sweep_tally *tally) {
    const planish_method method = r->options->method;
    pl_sweep(r->plan, &r->plan->interior, &r->problem, method, pl_run_after_colour, r, tally);
    /* Averages know no surfaces, and multipliers are those of the interior's elements. */
    if (method == PLANISH_METHOD_PLANISH && !(r->guard.star.penalty > 0)) {
        const pl_star_problem problem = pl_run_sliding_problem(r);
        pl_skin_follow(&r->skin);
        pl_sweep(r->plan, &r->plan->sliding, &problem, method, pl_run_after_colour, r, tally);
    }
}

/** Let the limits be no narrower than the mesh as measured. */
static void widen_limits(pl_run *r) {
    pl_star_limits *limits = &r->problem.limits;
    limits->rr2 = fmax(worst_ratio(r), limits->rr2);
    if (!r->plan->work.corner)
        return;
    limits->acuteness = fmax(r->sums.acuteness, limits->acuteness);
    limits->rr2_blunt = pl_run_blunt(r, limits->acuteness);
    pl_watch_limit(&r->watch, fmax(r->sums.radius_max * CELL_MARGIN, r->watch.worst_ar2));
}

int pl_run_sweep(pl_run *r, int64_t *visits) {
    double *sum = &r->sums.ratio[1];
    pl_sweep_tally tally = {0};
    pl_run_begin_sweep(r);
    if (!r->plain)
        r->factor = pl_guard_weigh(&r->guard, r->options, &r->sums);
    pl_run_sweep_colours(r, &tally);
    const int restores = tally.stars.restored > 0;
    r->phase = restores ? PLANISH_PHASE_UNTANGLE : PLANISH_PHASE_SMOOTH;
    r->improved = tally.stars.improved;
    *visits = tally.stars.visits;
    /* The sum of RR^2, or AR^2, over the movable elements falls by what the visits say, unless
     * other things happened: then, and where rounding could show, it is measured. With multipliers
     * it is another function that falls; the sum is measured in the end. */
    if (!(r->guard.star.penalty > 0)) {
        *sum -= pl_sum_value(&tally.stars.decrease);
        if (restores || r->options->area_weight > 0 ||
            r->options->method != PLANISH_METHOD_PLANISH ||
            !(*sum > MEASURE_AGAIN * r->measured_sum))
            pl_run_measure(r);
        if (restores) /* of elements that were brought up */
            widen_limits(r);
    }
    return pl_run_end_sweep(r, &tally);
}

/* A sweep that improved more than this part of the stars is not calm, whatever F says: a few
 * elements that cannot be repaired may be all that F shows. */
#define MANY_STARS 1e-3

/** Take note of a sweep; not 0 if another one is not worth its time. The averages may raise F: for
 *  them it must stay as it is. */
static int has_converged(const pl_run *r, pl_convergence *convergence, double before,
                         int64_t visits) {
    const double after = pl_objective_of_movable(r->options, &r->sums);
    const int64_t n_stars = r->plan->interior.n_all + r->plan->sliding.n_all;
    if (visits == 0)
        return 1;
    if (r->phase == PLANISH_PHASE_UNTANGLE || (double)r->improved > MANY_STARS * (double)n_stars) {
        convergence->n_falls = 0;
        return 0;
    }
    if (r->options->method != PLANISH_METHOD_PLANISH)
        return pl_converged(convergence, fmax(before, after), fmin(before, after), tolerance_of(r));
    return pl_converged(convergence, before, after, tolerance_of(r));
}

/* A mesh whose sweeps bring less than the first of these after so many of them, and would bring
 * more than the second in the end, is slow: something is wrong that is much larger than the
 * elements. */
enum { SWEEPS_UNTIL_SLOW = 20 };
#define SLOW_FALL      0.1
#define SLOW_REMAINDER 0.01

static void forget_refusers(pl_run *r) {
    const pl_star_problem plain = pl_plan_problem(r->plan, &r->plan->interior);
    pl_marked_destroy(&r->refusers);
    r->problem.more = NULL;
    r->problem.scratch = plain.scratch;
    r->problem.scratch_stride = plain.scratch_stride;
}

/** Make the coefficients of cells that keep refusing moves constraints of the visits around them, so
 *  that directions and steps heed them; those of cells that were found before are so already. */
static void heed_refusers(pl_run *r) {
    const int64_t n = pl_watch_find_refusers(&r->watch, NULL);
    if (n == r->refusers.n)
        return;
    forget_refusers(r);
    uint8_t *state = n > 0 ? pl_alloc_zero(r->plan->work.n_elements, sizeof *state) : NULL;
    if (!state)
        return;
    pl_watch_find_refusers(&r->watch, state);
    if (!pl_marked_make(&r->watch, state, 0, &r->refusers, NULL))
        pl_marked_use(&r->refusers, &r->problem);
    pl_free(state);
}

/* Newton's steps are due where sweeps are forecast to leave more than the part LEFT of what the RMS
 * can fall by even after so many more; the first sweeps of all do not count. The steps take as long
 * as some 12 visits to each node, so at least the part BUSY of the nodes must need visits. */
enum { SWEEPS_AHEAD = 24, SWEEPS_UNTIL_FORECAST = 5 };
#define LEFT 0.0005
#define BUSY 0.5

/** Whether the error is one of the whole mesh by now: falls shrink from sweep to sweep, and visits do
 *  not grow. Visits that grow mean an error that spreads, as in a mesh that leaves a saddle; a fall
 *  that grows means an element that was repaired. */
static int is_settled(const pl_convergence *trend, int64_t visits, int64_t visits_before) {
    if (trend->n_falls < PL_CALM_SWEEPS || visits > visits_before)
        return 0;
    for (int i = 1; i < PL_CALM_SWEEPS; i++)
        if (!(trend->fall[i] > 0 && trend->fall[i] <= trend->fall[i - 1]))
            return 0;
    return 1;
}

/* Steps may be tried again after so many sweeps, which remove what the steps failed for: twice as many
 * after each try. */
enum { SWEEPS_BETWEEN_STEPS = 8 };

/** Take note of a try of steps after n sweeps in a row, before which the sum of RR^2 was before. Return
 *  whether it fell. */
static int note_steps(pl_run *r, int n, double before) {
    const int is_better = r->sums.ratio[1] < before;
    const int wait = SWEEPS_BETWEEN_STEPS << r->n_step_tries++;
    r->steps_from = (is_better ? 0 : n) + wait;
    return is_better;
}

/** Whether Newton's steps are due: visits of the last sweep, visits_before of the sweep before that. */
static int steps_are_due(const pl_run *r, const pl_convergence *trend, int64_t visits,
                         int64_t visits_before) {
    const double n_stars = (double)(r->plan->interior.n_all + r->plan->sliding.n_all);
    return trend->n_falls >= SWEEPS_UNTIL_FORECAST && trend->n_falls >= r->steps_from &&
           (double)visits >= BUSY * n_stars && is_settled(trend, visits, visits_before) &&
           trend->fall[PL_CALM_SWEEPS - 1] < SLOW_FALL &&
           pl_left_after(trend, SWEEPS_AHEAD) > LEFT * pl_run_excess(r);
}

/** Whether all nodes may move at once if sweeps are slow. */
static int may_accelerate(const pl_run *r) {
    return r->plain && r->plan->interior.n_all > 0 && r->options->search == PLANISH_SEARCH_NEWTON &&
           !(r->problem.rr2_skip > 0);
}

/** Sweep until that converges or may go on no more: r->stop. */
static void sweep_on(pl_run *r) {
    const double tolerance = tolerance_of(r);
    const int may_be_slow = may_accelerate(r);
    pl_convergence calm = {{0}, 0};                           /* of sweeps that leave stars calm */
    pl_convergence trend = {{0}, 0};                          /* of all */
    int patience = may_be_slow ? SWEEPS_UNTIL_SLOW : INT_MAX; /* sweeps until a mesh is slow */
    int n_accelerated = 0, is_polished = 0;
    int64_t visits = 0;
    r->stop = PLANISH_STOP_MAX_SWEEPS;
    while (pl_run_sweeps_left(r) > 0) {
        const double before = pl_objective_of_movable(r->options, &r->sums);
        const int64_t visits_before = visits;
        if (pl_run_sweep(r, &visits))
            return;
        heed_refusers(r);
        pl_converged(&trend, before, pl_objective_of_movable(r->options, &r->sums), 0);
        double fall = trend.fall[PL_CALM_SWEEPS - 1];
        if (may_be_slow && steps_are_due(r, &trend, visits, visits_before)) {
            const double sum = r->sums.ratio[1];
            if (r->accelerate(r, PL_COARSE, fall))
                return;
            if (note_steps(r, trend.n_falls, sum)) {
                calm = trend = (pl_convergence){{0}, 0};
                continue;
            }
        }
        if (has_converged(r, &calm, before, visits)) {
            /* The sweeps of a slow mesh may still promise more: L-BFGS has the last word, once. */
            if (n_accelerated == 0 || is_polished || !(pl_remainder(&trend) > tolerance)) {
                r->stop = PLANISH_STOP_CONVERGED;
                return;
            }
            is_polished = 1;
            fall = tolerance;
        } else if (trend.n_falls < patience || !(fall < SLOW_FALL) ||
                   !(pl_remainder(&trend) > SLOW_REMAINDER)) {
            continue;
        }
        /* Centring comes first; after each L-BFGS sweeps have twice as long. */
        const pl_acceleration next = n_accelerated == 0 ? PL_CENTRING : PL_DESCENT;
        if (n_accelerated++ > 0)
            patience *= 2;
        calm = trend = (pl_convergence){{0}, 0};
        if (r->accelerate(r, next, fall))
            return;
        if (next == PL_CENTRING)
            r->steps_from = r->n_step_tries = 0; /* the mesh is another one */
    }
}

void pl_run_sweeps(pl_run *r) {
    sweep_on(r);
    forget_refusers(r);
}

/* ---- trials ------------------------------------------------------------------------------- */

static size_t size_of_coordinates(const pl_run *r) {
    return (size_t)r->plan->work.n_nodes * (size_t)r->plan->dim *
           sizeof *r->plan->scratch.coordinates;
}

void pl_trial_begin(pl_run *r, int is_hidden, double *before, pl_trial *trial) {
    *trial = (pl_trial){.run = r,
                        .standing = r->sums,
                        .before = before,
                        .problem = r->problem,
                        .guard = r->guard.star,
                        .phase = r->phase,
                        .shown = r->shown,
                        .skin = pl_skin_save(&r->skin)};
    memcpy(before, r->plan->scratch.coordinates, size_of_coordinates(r));
    if (!r->shown) /* a trial within a hidden one is hidden, too */
        r->shown = is_hidden ? trial : NULL;
}

void pl_trial_end(const pl_trial *trial, int is_taken) {
    pl_run *r = trial->run;
    r->shown = trial->shown;
    r->problem = trial->problem;
    r->guard.star = trial->guard;
    r->phase = trial->phase;
    if (!is_taken) {
        memcpy(r->plan->scratch.coordinates, trial->before, size_of_coordinates(r));
        pl_skin_restore(&r->skin, trial->skin);
        pl_run_measure(r);
    }
    pl_free(trial->skin);
}
