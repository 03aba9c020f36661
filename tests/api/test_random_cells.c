/* Valid in, valid out, for elements of any type and order: random meshes, each smoothed with all that can
 * be drawn, and judged in fractions by tests/support/cell_judge.
 *
 * PLANISH_CASE=NUMBER does one case alone, and says what it is. Cases are the same whatever ran before
 * them.
 */
#include "support/cell_judge.h"
#include "support/effort.h"
#include "support/random_surfaces.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#ifdef PLANISH_HAVE_GMP

#include "geometry/cell.h"

enum { DESCRIPTION = 2000 };

/* Of ratios in doubles, against long double. */
#define NOISE 1e-9L

/** What the cases came to. */
typedef struct tally {
    pairs seen;
    int64_t broken, smoothed, elements, were_invalid, repaired, compared, stopped, surfaces;
} tally;

/** The mesh at some coordinates; over elements of the mesh's dimension. */
typedef struct state_of {
    int64_t n_invalid, n_undecided, n_below;
    int all_positive; /* corners */
    long double f,
        largest; /* RMS and largest AR, of elements with positive corners; of the latter, those
                               with a node that moves */
    long double jacobian; /* least of the same */
    int8_t *valid;        /* [cells] owned */
} state_of;

typedef struct trial {
    int64_t number;
    cells_call *call;
    planish_plan *plan;
    planish_result result;
    double *before, *after; /* [n_nodes][dim] */
    uint8_t *moves;         /* [n_nodes] has moved */
    tally *sums;
} trial;

static void complain(const trial *t, const char *what) {
    char text[DESCRIPTION];
    cells_call_describe(t->call, text, sizeof text);
    print_error("PLANISH_CASE=%lld: %s\n    %s\n", (long long)t->number, what, text);
    t->sums->broken++;
}

static void expect(const trial *t, int holds, const char *what) {
    if (!holds)
        complain(t, what);
}

/* ---- the mesh before and after ------------------------------------------------------------------- */

static int counts(const planish_mesh *mesh, int64_t i) {
    const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[i]);
    return type && type->shape->dim == mesh->dim && type->type != PLANISH_CELL_LINE;
}

static int has_moving_node(const trial *t, int64_t i) {
    const planish_cells *cells = t->call->given.cells;
    for (int64_t k = cells->offset[i]; k < cells->offset[i + 1]; k++)
        if (t->moves[cells->node[k]])
            return 1;
    return 0;
}

static double least_of(const cells_call *c, int64_t i) {
    return c->least && c->least[i] != 0 ? c->least[i] : c->options.min_volume;
}

static state_of look(const trial *t, const double *x, int all) {
    const cells_call *c = t->call;
    const planish_mesh *mesh = &c->given;
    state_of s = {.all_positive = 1, .jacobian = INFINITY};
    long double sum = 0;
    int64_t n = 0;
    s.valid = calloc((size_t)mesh->cells->n + 1, 1);
    assert_non_null(s.valid);
    for (int64_t i = 0; i < mesh->cells->n; i++) {
        if (!counts(mesh, i))
            continue;
        const int valid = cell_judge_validity(mesh, i, x, c->sign[i]);
        const cell_worth w = cell_judge_worth(mesh, i, x, c->target,
                                              c->target ? c->options.size_weight : 0, c->sign[i]);
        s.valid[i] = (int8_t)(valid == 1);
        s.n_invalid += valid != 1;
        s.n_undecided += valid < 0;
        s.all_positive &= w.is_positive;
        s.n_below += w.volume < 0.997L * least_of(c, i);
        if (w.is_positive) {
            sum += w.square;
            n++;
        }
        if (w.is_positive && (all || has_moving_node(t, i))) {
            s.largest = fmaxl(s.largest, sqrtl(w.square));
            s.jacobian = fminl(s.jacobian, w.jacobian);
        }
    }
    s.f = n > 0 ? sqrtl(sum / n) : 0;
    return s;
}

/** Whether all elements are simplices of order 1: they have radius ratios, which test_random.c judges. */
static int has_radius_ratios(const cells_call *c) {
    return c->level[CELLS_OF] >= CELLS_TRIANGLES &&
           c->options.objective != PLANISH_OBJECTIVE_MEAN_RATIO &&
           c->level[CELLS_TARGET] == TARGET_NONE;
}

/** Whether F is the RMS of what the judge knows. */
static int is_known(const cells_call *c) {
    const int target = c->level[CELLS_TARGET];
    return target < TARGET_SIZE && c->options.objective != PLANISH_OBJECTIVE_EDGE_RATIO &&
           !(c->options.area_weight > 0) && !has_radius_ratios(c);
}

/* ---- promises ------------------------------------------------------------------------------------ */

static void check_moved(const trial *t, int64_t node) {
    const cells_call *c = t->call;
    const planish_options *o = &c->options;
    const int dim = c->given.dim;
    const int kind = c->constraint ? c->constraint[node] : PLANISH_CONSTRAINT_FREE;
    expect(t, kind != PLANISH_CONSTRAINT_FIXED, "a fixed node moved");
    expect(t, !c->is_held[node], "a node of a line moved");
    const int follows =
        c->level[CELLS_ORDER] > 0 && c->constraint; /* a mid, both ends of which slide */
    expect(t, !c->is_outside[node] || kind >= PLANISH_CONSTRAINT_ON_PLANE || follows,
           "a node of the boundary moved");
    for (int d = 0; d < dim; d++) {
        const double x = t->after[node * dim + d];
        volatile float narrow = (float)x;
        const int bounded = node < c->first_mid; /* mids follow their ends */
        expect(t, isfinite(x), "a coordinate is not finite");
        expect(t, !bounded || x <= o->box_upper[d], "a node is outside of the box");
        expect(t, !bounded || !o->lower || x >= o->lower[node * dim + d],
               "a node is below its bound");
        expect(t, !o->precision || (double)narrow == x || x == t->before[node * dim + d],
               "a coordinate is no float");
    }
}

static void check_nodes(trial *t) {
    const int dim = t->call->given.dim;
    int64_t n = 0;
    for (int64_t i = 0; i < t->call->given.n_nodes; i++) {
        const double *a = t->before + i * dim, *b = t->after + i * dim;
        double square = 0;
        t->moves[i] = memcmp(a, b, (size_t)dim * sizeof *a) != 0;
        n += t->moves[i];
        for (int d = 0; d < dim; d++)
            square += (a[d] - b[d]) * (a[d] - b[d]);
        if (!t->moves[i])
            continue;
        check_moved(t, i);
        const double far = sqrt(square), limit = t->call->options.max_displacement;
        expect(t, far <= t->result.max_displacement * (1 + 1e-12),
               "a node went farther than is said");
        expect(t,
               !(limit > 0) || t->call->options.displacement_unit == PLANISH_UNIT_EDGE ||
                   t->result.n_released_mids > 0 || far <= limit * (1 + 1e-9),
               "a node went farther than it may");
    }
    expect(t, n == t->result.n_moved_nodes, "n_moved_nodes is wrong");
}

static void check_pairs(const trial *t) {
    const cells_call *c = t->call;
    const int dim = c->given.dim;
    double largest = 0;
    for (int64_t i = 0; i < c->given.n_nodes * dim; i++)
        largest = fmax(largest, fabs(t->before[i]));
    for (int64_t i = 0; i < c->given.n_periodic * dim; i++) {
        const int64_t a = (int64_t)c->periodic[i / dim * 2] * dim + i % dim;
        const int64_t b = (int64_t)c->periodic[i / dim * 2 + 1] * dim + i % dim;
        const int follows = a / dim >= c->first_mid || b / dim >= c->first_mid;
        expect(t,
               fabs((t->after[a] - t->before[a]) - (t->after[b] - t->before[b])) <=
                       1e-15 * largest ||
                   follows,
               "nodes of a pair moved differently");
    }
}

/** Whether a mid went as its ends did on average: it follows. */
static int follows(const trial *t, int32_t mid, int32_t a, int32_t b, double slack) {
    const int dim = t->call->given.dim;
    int is = 1;
    for (int d = 0; d < dim; d++) {
        const double way[3] = {t->after[mid * dim + d] - t->before[mid * dim + d],
                               t->after[a * dim + d] - t->before[a * dim + d],
                               t->after[b * dim + d] - t->before[b * dim + d]};
        is &= fabs(way[0] - (way[1] + way[2]) / 2) <= slack;
    }
    return is;
}

/** Mids between regions follow their ends, and do not move on their own, if planish_find_slides was asked. A shape has
 *  its own judge. */
static void check_interfaces(const trial *t) {
    const cells_call *c = t->call;
    const cell_box *box = c->box;
    const int how = c->level[CELLS_CONSTRAINT],
              is_told = how != CELLS_SOME_FIXED && how != CELLS_ANY;
    uint8_t *of = c->region && !c->shape && is_told ? calloc((size_t)box->mesh.n_nodes, 1) : NULL;
    double largest = 0;
    if (!of)
        return;
    for (int64_t i = 0; i < box->cells.n; i++)
        for (int64_t k = box->offset[i]; k < box->offset[i + 1]; k++)
            if (box->node[k] >= 0)
                of[box->node[k]] |= (uint8_t)(1 << c->region[i]);
    for (int64_t i = 0; i < c->given.n_nodes * c->given.dim; i++)
        largest = fmax(largest, fabs(t->before[i]));
    const double slack =
        (c->options.precision == PLANISH_PRECISION_DOUBLE ? 1e-14 : 1e-5) * largest;
    for (int64_t i = 0; i < box->cells.n; i++) {
        const pl_cell_type *type = pl_cell_type_of(box->cells.type[i]);
        const int32_t *node = box->node + box->offset[i];
        const int n = type && type->order > 1 ? type->shape->n_edges : 0;
        for (int e = 0; e < n; e++) {
            const int k = type->shape->n_corners + e;
            const int32_t a = node[type->between[k][0]], b = node[type->between[k][1]];
            if (node[k] >= 0 && (of[node[k]] & of[a] & of[b]) == 3)
                expect(t, follows(t, node[k], a, b, slack),
                       "a mid between regions moved on its own");
        }
    }
    free(of);
}

/** The surface of a call with a shape. */
static void check_surface(const trial *t) {
    const char *wrong = t->call->shape ? cells_check_surface(t->call, t->after) : NULL;
    if (wrong)
        complain(t, wrong);
    for (int64_t i = 0; t->call->shape && i < t->call->given.n_nodes; i++)
        if (t->moves[i] && t->call->constraint[i] >= PLANISH_CONSTRAINT_ON_PATCH) {
            t->sums->surfaces++;
            return;
        }
}

/** By how much F may be off: where it is large, it is that of a corner whose measure is hardly more than its rounding
 *  errors. */
static long double noise_of(long double f) {
    return fmaxl(NOISE, 1e-15L * f);
}

/** Of a mesh that was as it should be. */
static void check_no_worse(const trial *t, const state_of *was, const state_of *is) {
    const cells_call *c = t->call;
    const planish_options *o = &c->options;
    const double rise = t->result.worst_sweeps > 0 ? 1 + o->worst_rise : 1;
    expect(t, t->result.objective <= t->result.objective_before * rise * (1 + (double)NOISE),
           "F is said to have risen");
    if (!is_known(c))
        return;
    t->sums->compared++;
    expect(t, is->f <= was->f * rise * (1 + noise_of(was->f)), "F rose");
    expect(t, fabsl(is->f - t->result.objective) <= noise_of(is->f) * is->f,
           "F is not what the result says");
    expect(t, fabsl(was->f - t->result.objective_before) <= noise_of(was->f) * was->f,
           "F was not what the result says");
    const int is_guarded_by_it =
        c->level[CELLS_OF] < CELLS_TRIANGLES || c->target; /* others by RR */
    if (c->level[CELLS_LEAST] > 0 || !is_guarded_by_it)
        return;
    expect(t, is->largest <= was->largest * (1 + NOISE), "an element is worse than the worst was");
    if (c->level[CELLS_TARGET] == TARGET_NONE)
        expect(t, is->jacobian >= was->jacobian - NOISE, "a scaled Jacobian fell below the least");
}

static void check_elements(const trial *t) {
    state_of was = look(t, t->before, 1), is = look(t, t->after, 0);
    const cells_call *c = t->call;
    t->sums->elements += c->given.cells->n;
    t->sums->were_invalid += was.n_invalid;
    t->sums->repaired += was.n_invalid - is.n_invalid;
    expect(t, is.n_undecided <= was.n_undecided, "the judge cannot decide an element that moved");
    expect(t, is.n_invalid <= was.n_invalid, "more elements are invalid");
    for (int64_t i = 0; i < c->given.cells->n; i++)
        expect(t,
               is.valid[i] || !was.valid[i] ||
                   (is.n_invalid < was.n_invalid && c->options.untangle),
               "an element became invalid, and no more were repaired");
    if (was.n_invalid == 0 && was.all_positive && was.n_below == 0 && c->level[CELLS_LEAST] != 3 &&
        c->level[CELLS_AROUND] == 0)
        check_no_worse(t, &was, &is);
    free(was.valid);
    free(is.valid);
}

/* ---- a case --------------------------------------------------------------------------------------- */

/** Whether a status is a refusal, which is complained of: all that is drawn is allowed. */
static int is_refused(const trial *t, int status, const planish_error *error) {
    if (status == PLANISH_OK)
        return 0;
    expect(t, error->code == status && error->text[0] != '\0', "an error that says nothing");
    complain(t, error->text);
    return 1;
}

/** What the plan says of nodes: those that moved may. Mids follow, whatever is said. */
static void ask_nodes(const trial *t) {
    const cells_call *c = t->call;
    planish_error error = {.text = ""};
    uint8_t *reason = calloc((size_t)c->given.n_nodes, 1),
            *is_free = calloc((size_t)c->given.n_nodes, 1);
    assert_true(reason && is_free);
    planish_plan_get_free(t->plan, is_free);
    if (!is_refused(t, planish_plan_get_held(t->plan, c->start, reason, &error), &error))
        for (int64_t i = 0; i < c->first_mid; i++) {
            const int has_moved = memcmp(t->before + i * c->given.dim, t->after + i * c->given.dim,
                                         (size_t)c->given.dim * sizeof *t->after) != 0;
            expect(t, !has_moved || reason[i] == 0, "a node moved that is said to be held");
            expect(t, !is_free[i] || reason[i] == 0, "a free node is said to be held");
        }
    free(is_free);
    free(reason);
}

/** What the plan says of elements at the end: as the result of the call does. */
static void ask_elements(const trial *t) {
    const cells_call *c = t->call;
    const size_t n = (size_t)c->given.cells->n;
    planish_options options = c->options;
    planish_quality quality;
    planish_error error = {.text = ""};
    int64_t n_below = 0, n_infeasible = 0, n_undecided = 0;
    double *ratio = calloc(n, sizeof *ratio);
    uint8_t *state = calloc(n, 1), *infeasible = calloc(n, 1);
    assert_true(ratio && state && infeasible);
    options.progress = NULL;
    options.time_limit = 0;
    if (!is_refused(t, planish_measure(t->plan, c->coordinates, &quality, &error), &error))
        expect(t,
               c->level[CELLS_ORDER] > 0 ||
                   quality.n_inverted == t->result.n_inverted - t->result.n_inverted_inside,
               "n_inverted is another by planish_measure");
    if (!is_refused(t, planish_measure_elements(t->plan, c->coordinates, ratio, &error), &error))
        for (size_t i = 0; i < n; i++)
            expect(t,
                   ratio[i] == 0 || ratio[i] >= 1 - 1e-12 ||
                       (isnan(ratio[i]) && c->level[CELLS_AROUND]),
                   "a ratio is below 1");
    is_refused(t,
               planish_check_volumes(t->plan, c->coordinates, &options, state, &n_below,
                                     &n_undecided, &error),
               &error);
    is_refused(t,
               planish_find_infeasible(t->plan, c->coordinates, &options, infeasible, &n_infeasible,
                                       &n_undecided, &error),
               &error);
    expect(t, n_infeasible <= quality.n_inverted + t->result.n_inverted_inside,
           "more elements are infeasible than inverted, by their corners or inside");
    free(infeasible);
    free(state);
    free(ratio);
}

/** Make a plan and smooth from the start; 0 if that is refused. */
static int smooth(trial *t) {
    cells_call *c = t->call;
    planish_error error = {.text = ""};
    cells_call_rewind(c);
    t->plan = NULL;
    if (is_refused(t, planish_plan_create(&c->given, &c->plan_options, &t->plan, &error), &error))
        return 0;
    const int status = planish_smooth(t->plan, c->coordinates, &c->options, &t->result, &error);
    const int refused = is_refused(t, status, &error);
    cells_call_get(c, t->after);
    if (!refused) {
        ask_nodes(t);
        ask_elements(t);
    }
    planish_plan_destroy(t->plan);
    if (refused)
        expect(t,
               memcmp(t->before, t->after,
                      (size_t)(c->given.n_nodes * c->given.dim) * sizeof *t->after) == 0,
               "an error moved nodes");
    return !refused;
}

/** The same call with other threads and another kernel. */
static void smooth_otherwise(trial *t, uint64_t *state) {
    static const int threads[] = {1, 2, 3, 5, 8};
    cells_call *c = t->call;
    const size_t size = (size_t)(c->given.n_nodes * c->given.dim) * sizeof(double);
    double *first = malloc(size);
    assert_non_null(first);
    memcpy(first, t->after, size);
    c->options.threads = c->plan_options.threads = threads[random_below(state, 5)];
    c->options.isa = c->plan_options.isa =
        random_below(state, 2) ? PLANISH_ISA_PLAIN : PLANISH_ISA_VECTOR;
    expect(t, smooth(t), "a call is refused with other threads");
    expect(t, memcmp(first, t->after, size) == 0, "other threads or kernels give other bits");
    free(first);
}

/** Smooth a mesh of these levels. Returns how many mids have moved by themselves. */
static int64_t do_call(tally *sums, int64_t number, const int *level, uint64_t *state) {
    trial t = {.number = number, .call = cells_call_create(level, state), .sums = sums};
    const size_t n = (size_t)(t.call->given.n_nodes * t.call->given.dim) + 1;
    t.before = calloc(n, sizeof *t.before);
    t.after = calloc(n, sizeof *t.after);
    t.moves = calloc(n, 1);
    assert_true(t.before && t.after && t.moves);
    cells_call_rewind(t.call);
    cells_call_get(t.call, t.before);
    if (smooth(&t)) {
        sums->smoothed++;
        sums->stopped += t.result.stop == PLANISH_STOP_INTERRUPTED;
        pairs_note(&sums->seen, t.call->level);
        check_nodes(&t);
        check_pairs(&t);
        check_surface(&t);
        check_interfaces(&t);
        if (t.call->options.method == PLANISH_METHOD_PLANISH)
            check_elements(&t);
        if (!(t.call->options.time_limit > 0))
            smooth_otherwise(&t, state);
    }
    free(t.before);
    free(t.after);
    free(t.moves);
    cells_call_destroy(t.call);
    return t.result.n_released_mids;
}

static void do_case(tally *sums, int64_t number) {
    uint64_t state = effort_seed((uint64_t)number);
    int level[N_CELLS_FACTORS];
    pairs_draw(&sums->seen, &state, level);
    if (!test_has_isa(level[CELLS_ISA]))
        level[CELLS_ISA] = PLANISH_ISA_AUTO;
    do_call(sums, number, level, &state);
}

/** Mids between regions follow their ends where elements of order 2 are repaired, also on a curved surface. */
static void mids_between_regions_stay(void **unused) {
    (void)unused;
    tally sums = {.seen = {N_CELLS_FACTORS, cells_factors, {{{{0}}}}}};
    int64_t n_released = 0;
    const uint64_t step = (uint64_t)effort_step(14); /* all kinds of meshes come in turn */
    for (uint64_t seed = 1; seed <= 60; seed += step) {
        uint64_t state = effort_seed(seed);
        const int level[N_CELLS_FACTORS] = {[CELLS_OF] =
                                                seed % 3 == 2 ? CELLS_TRIANGLES : CELLS_TETRAHEDRA,
                                            [CELLS_ORDER] = 1,
                                            [CELLS_BEND] = 2,
                                            [CELLS_UNTANGLE] = 1,
                                            [CELLS_SWEEPS] = 3,
                                            [CELLS_TOLERANCE] = 1,
                                            [CELLS_SURFACE] = seed % 3 == 0,
                                            [CELLS_REGIONS] = 1};
        n_released += do_call(&sums, (int64_t)seed, level, &state);
    }
    assert_int_equal(sums.broken, 0);
    assert_true(n_released > 0);
}

/** Steps for sizes repair no element at the cost of another one. */
static void sizes_keep_valid_elements(void **unused) {
    (void)unused;
    tally sums = {.seen = {N_CELLS_FACTORS, cells_factors, {{{{0}}}}}};
    for (uint64_t seed = 1; seed <= 50; seed += (uint64_t)effort_step(3)) {
        uint64_t state = effort_seed(seed);
        const int level[N_CELLS_FACTORS] = {[CELLS_OF] = CELLS_WEDGES,
                                            [CELLS_ORDER] = 1,
                                            [CELLS_SHAKE] = 2,
                                            [CELLS_BEND] = 2,
                                            [CELLS_TARGET] = TARGET_METRIC,
                                            [CELLS_WEIGHT] = 2,
                                            [CELLS_LOWER] = 1,
                                            [CELLS_SWEEPS] = 3};
        do_call(&sums, (int64_t)seed, level, &state);
    }
    assert_int_equal(sums.broken, 0);
    assert_true(sums.were_invalid > 0);
}

/** Draw a mesh of these levels, to be smoothed. */
static trial draw_trial(tally *sums, const int *level, uint64_t seed) {
    uint64_t state = effort_seed(seed);
    trial t = {.number = (int64_t)seed, .call = cells_call_create(level, &state), .sums = sums};
    const size_t n = (size_t)(t.call->given.n_nodes * t.call->given.dim) + 1;
    t.before = calloc(n, sizeof *t.before);
    t.after = calloc(n, sizeof *t.after);
    t.moves = calloc(n, 1);
    assert_true(t.before && t.after && t.moves);
    cells_call_rewind(t.call);
    cells_call_get(t.call, t.before);
    return t;
}

static void free_trial(trial *t) {
    free(t->before);
    free(t->after);
    free(t->moves);
    cells_call_destroy(t->call);
}

/** Smooth a mesh of these levels twice, with its minimum volume and without. Returns how many fewer elements are
 *  repaired with it. */
static int64_t compare_volumes(const int *level, uint64_t seed) {
    tally sums = {.seen = {N_CELLS_FACTORS, cells_factors, {{{{0}}}}}};
    trial t = draw_trial(&sums, level, seed);
    assert_true(smooth(&t));
    const int64_t with = t.result.n_inverted;
    t.call->options.min_volume = 0;
    assert_true(smooth(&t));
    const int64_t without = t.result.n_inverted;
    free_trial(&t);
    assert_int_equal(sums.broken, 0);
    return with - without;
}

/** Where raising volumes fails, what was repaired before stays. */
static void raised_volumes_keep_repairs(void **unused) {
    (void)unused;
    const int level[N_CELLS_FACTORS] = {[CELLS_OF] = CELLS_HEXAHEDRA,
                                        [CELLS_ORDER] = 1,
                                        [CELLS_SHAKE] = 2,
                                        [CELLS_BEND] = 2,
                                        [CELLS_LEAST] = 2,
                                        [CELLS_UNTANGLE] = 1,
                                        [CELLS_SWEEPS] = 3,
                                        [CELLS_TOLERANCE] = 1};
    static const uint64_t seeds[] = {2, 25, 29, 36}; /* where it invalidates curved elements */
    for (size_t i = 0; i < sizeof seeds / sizeof *seeds; i += (size_t)effort_step(2))
        assert_true(compare_volumes(level, seeds[i]) <= 0);
}

/** A run and planish_measure_cells agree on which elements are curved. */
static void check_curved(const trial *t) {
    planish_mesh mesh = t->call->given;
    planish_cell_quality q;
    mesh.coordinates = t->before;
    mesh.node_stride = mesh.component_stride = 0;
    assert_int_equal(planish_measure_cells(&mesh, t->call->options.rounding, 1, &q, NULL, NULL),
                     PLANISH_OK);
    expect(t, t->result.n_curved == q.all.n_curved, "n_curved is not that of measures");
    expect(t, q.all.n_curved > 0 || q.all.min_jacobian_ratio == 1,
           "a straight element has a ratio");
}

/** However large options.rounding is, elements that are not valid are counted, as curved ones, too, and
 *  repaired. */
static void rounding_hides_no_invalid_elements(void **unused) {
    (void)unused;
    tally sums = {.seen = {N_CELLS_FACTORS, cells_factors, {{{{0}}}}}};
    const uint64_t step = (uint64_t)effort_step(7); /* all levels come in turn */
    for (uint64_t seed = 1; seed <= 60; seed += step) {
        const int level[N_CELLS_FACTORS] = {[CELLS_OF] = (int)seed % 8,
                                            [CELLS_ORDER] = 1 + (int)seed % 2,
                                            [CELLS_SHAKE] = (int)seed % 3,
                                            [CELLS_BEND] = 1 + (int)seed % 3,
                                            [CELLS_UNTANGLE] = seed % 5 != 0,
                                            [CELLS_SWEEPS] = 3,
                                            [CELLS_TOLERANCE] = 1};
        trial t = draw_trial(&sums, level, seed);
        t.call->options.rounding = t.call->plan_options.rounding = 1; /* an edge */
        assert_true(smooth(&t));
        check_nodes(&t);
        check_elements(&t);
        check_curved(&t);
        state_of is = look(&t, t.after, 0);
        expect(&t, t.result.n_inverted == is.n_invalid, "n_inverted is wrong");
        free(is.valid);
        free_trial(&t);
    }
    assert_int_equal(sums.broken, 0);
    assert_true(sums.repaired > sums.were_invalid / 3);
}

static void random_calls_keep_promises(void **state) {
    (void)state;
    const char *one = getenv("PLANISH_CASE");
    const int64_t first = one ? strtoll(one, NULL, 10) : 0;
    const int64_t n = one ? first + 1 : effort(400 / effort_step(4), 100000);
    tally sums = {.seen = {N_CELLS_FACTORS, cells_factors, {{{{0}}}}}};
    int64_t missing = 0;
    for (int64_t i = first; i < n; i++)
        do_case(&sums, i);
    const int64_t all =
        pairs_count(&sums.seen, cells_levels_allowed, getenv("PLANISH_LONG") != NULL, &missing);
    figure("random cells: %lld meshes smoothed, %lld stopped, %lld elements, "
           "%lld invalid, %lld repaired, F compared %lld times, %lld curved surfaces moved, %lld "
           "of %lld pairs",
           (long long)sums.smoothed, (long long)sums.stopped, (long long)sums.elements,
           (long long)sums.were_invalid, (long long)sums.repaired, (long long)sums.compared,
           (long long)sums.surfaces, (long long)(all - missing), (long long)all);
    assert_int_equal(sums.broken, 0);
    assert_true(one ||
                (sums.repaired > 0 && sums.compared > sums.smoothed / 10 && sums.surfaces > 0));
}

/* ---- the judge is judged ---------------------------------------------------------------------------- */

/** A cube whose corners are good but whose inside is not, and the same after so small a change that only
 *  fractions see it. */
static void the_judge_sees_what_corners_hide(void **state) {
    (void)state;
    cell_box *box = cell_box_create(BOX_HEXAHEDRA, 1);
    assert_int_equal(cell_judge_validity(&box->mesh, 0, box->x, 1), 1);
    assert_int_equal(cell_judge_validity(&box->mesh, 0, box->x, -1), 0);
    /* Along the line between the middles of two sides x = t (1 - t) ... : both ends turn. */
    double x[24];
    memcpy(x, box->x, sizeof x);
    for (int k = 0; k < 3; k++) /* corner 0 comes to the plane of its neighbours */
        x[box->node[0] * 3 + k] = 1 / 3.0;
    const cell_worth w = cell_judge_worth(&box->mesh, 0, x, NULL, 0, 1);
    assert_true(fabsl(w.volume) < 1e-15L);
    for (int k = 0; k < 3; k++) /* 0.25 + 0.25 + 0.5 = 1: in fractions exactly */
        x[box->node[0] * 3 + k] = k == 2 ? 0.5 : 0.25;
    assert_int_equal(cell_judge_validity(&box->mesh, 0, x, 1), 0);
    x[box->node[0] * 3] = nextafter(0.25, 0);
    assert_int_equal(cell_judge_worth(&box->mesh, 0, x, NULL, 0, 1).is_positive, 1);
    cell_box_destroy(box);
}

#else

static void sizes_keep_valid_elements(void **state) {
    (void)state;
    skip();
}

static void mids_between_regions_stay(void **state) {
    (void)state;
    skip();
}

static void raised_volumes_keep_repairs(void **state) {
    (void)state;
    skip();
}

static void rounding_hides_no_invalid_elements(void **state) {
    (void)state;
    skip();
}

static void random_calls_keep_promises(void **state) {
    (void)state;
    skip();
}

static void the_judge_sees_what_corners_hide(void **state) {
    (void)state;
    skip();
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_judge_sees_what_corners_hide),
        cmocka_unit_test(mids_between_regions_stay),
        cmocka_unit_test(sizes_keep_valid_elements),
        cmocka_unit_test(raised_volumes_keep_repairs),
        cmocka_unit_test(rounding_hides_no_invalid_elements),
        cmocka_unit_test(random_calls_keep_promises),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
