/* Tests of cells that wait for the end of a sweep to be decided: which moves are undone where they turn out
 * not to be valid. */
#include "support/cell_meshes.h"
#include "support/meshes.h"
#include "sweep/watch_late.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SIDE = 5, SEEDS = 40 };

/** Of a star's move. */
enum { IS_MADE, IS_TO_GO, IS_BACK };

/** A box whose nodes a test moves as a sweep would. Arrays go by stars. */
typedef struct world {
    cell_box *box;
    planish_plan *plan;
    pl_watch watch;
    pl_star_problem problem;
    int64_t n; /* stars */
    double (*before)[3], (*after)[3];
    uint8_t *is_undone; /* IS_MADE, ... */
} world;

static double *place_of(const world *t, int64_t star) {
    return t->plan->scratch.coordinates + (int64_t)t->problem.node[star] * 3;
}

static void begin(world *t, cell_box_kind kind) {
    planish_options o;
    planish_error error;
    planish_options_init(&o);
    o.threads = 2;
    t->box = cell_box_create(kind, SIDE);
    if (planish_plan_create(&t->box->mesh, &o, &t->plan, &error) ||
        pl_watch_create(t->plan, &o, t->box->x, t->box->x, 0, &t->watch, &error))
        fail_msg("%s", error.text);
    pl_plan_order(t->plan, t->box->x, t->plan->scratch.coordinates);
    memset(t->plan->scratch.changed, 0, (size_t)t->plan->work.n_nodes);
    assert_int_equal(pl_watch_measure(&t->watch), 0);
    t->problem = pl_plan_problem(t->plan, &t->plan->interior);
    t->n = t->plan->interior.stars.n_stars;
    assert_true(t->n >= (SIDE - 1) * (SIDE - 1) * (SIDE - 1));
    t->before = calloc((size_t)t->n, sizeof *t->before);
    t->after = calloc((size_t)t->n, sizeof *t->after);
    t->is_undone = calloc((size_t)t->n, 1);
}

static void end(world *t) {
    free(t->before);
    free(t->after);
    free(t->is_undone);
    pl_watch_destroy(&t->watch);
    planish_plan_destroy(t->plan);
    cell_box_destroy(t->box);
}

/** Move all stars in their order by up to far in each direction, and note that each brought 1. */
static void move_all(world *t, double far, unsigned *seed) {
    const pl_star_gain gain = {.fall = 1, .improved = 1};
    pl_watch_begin_sweep(&t->watch, 1);
    assert_true(t->watch.late.is_on);
    for (int64_t s = 0; s < t->n; s++) {
        memcpy(t->before[s], place_of(t, s), sizeof *t->before);
        for (int d = 0; d < 3; d++)
            place_of(t, s)[d] += far * (2 * test_random(seed) - 1);
        memcpy(t->after[s], place_of(t, s), sizeof *t->after);
        pl_watch_note_move(&t->watch, s, t->problem.node[s], t->before[s],
                           pl_watch_distance(3, t->before[s], t->after[s]), &gain);
    }
}

/** Whether a watched cell has the node of a star. */
static int has_star(const world *t, int64_t cell, int64_t star) {
    int any = 0;
    for (int j = 0; j < PL_CELL_CORNERS; j++)
        any |= t->watch.node[cell][j] == t->problem.node[star];
    return any;
}

/** Undo the last move of each cell that is not valid. Returns how many moves these are. */
static int64_t undo_last(world *t) {
    int64_t n = 0;
    for (int64_t i = 0; i < t->watch.n; i++) {
        if (!t->watch.type[i] ||
            pl_watch_decide(&t->watch, pl_watch_cell(&t->watch, i)) == PL_VALID)
            continue;
        int64_t last = t->n - 1;
        while (last >= 0 && (t->is_undone[last] == IS_BACK || !has_star(t, i, last)))
            last--;
        assert_true(last >= 0);
        t->is_undone[last] = IS_TO_GO;
        n++;
    }
    return n;
}

/** Undo the moves after undone ones, of nodes of the same cells; and put all of these back. */
static void undo_later(world *t) {
    for (int64_t s = 0; s < t->n; s++)
        for (int64_t i = 0; t->is_undone[s] && i < t->watch.n; i++)
            for (int64_t later = s + 1; has_star(t, i, s) && later < t->n; later++)
                if (has_star(t, i, later))
                    t->is_undone[later] = IS_TO_GO;
    for (int64_t s = 0; s < t->n; s++)
        if (t->is_undone[s]) {
            memcpy(place_of(t, s), t->before[s], sizeof *t->before);
            t->is_undone[s] = IS_BACK;
        }
}

/** The end of a sweep undoes the moves that the rule says, and counts no more what they brought. */
static void moves_are_undone_by_the_rule(void **state) {
    static const cell_box_kind kinds[] = {BOX_HEXAHEDRA, BOX_WEDGES, BOX_MIXED};
    int64_t n_all = 0, n_kept = 0;
    (void)state;
    for (int k = 0; k < 3; k++)
        for (unsigned seed = 1; seed <= SEEDS; seed++) {
            world t;
            unsigned random = seed;
            pl_star_tally tally = {.improved = 0};
            int64_t n_undone = 0;
            begin(&t, kinds[k]);
            move_all(&t, 0.1 + 0.01 * seed, &random);
            while (undo_last(&t) > 0)
                undo_later(&t);
            for (int64_t s = 0; s < t.n; s++)
                memcpy(place_of(&t, s), t.after[s], sizeof *t.after);
            pl_watch_end_sweep(&t.watch, &t.problem, t.n, &tally);
            for (int64_t s = 0; s < t.n; s++) {
                const double *place = t.is_undone[s] ? t.before[s] : t.after[s];
                assert_memory_equal(place_of(&t, s), place, sizeof *t.before);
                assert_true(!t.is_undone[s] || t.problem.changed[t.problem.node[s]]);
                n_undone += t.is_undone[s] != 0;
            }
            assert_true(pl_sum_value(&tally.decrease) == -(double)n_undone);
            assert_int_equal(tally.improved, -n_undone);
            assert_int_equal(t.watch.n_refused, n_undone);
            n_all += n_undone;
            n_kept += t.n - n_undone;
            end(&t);
        }
    assert_true(n_all > 100 && n_kept > 100);
}

/** A cell that has refused a move is decided after each visit from then on. */
static void cells_that_refused_wait_no_more(void **state) {
    world t;
    unsigned random = 7;
    pl_star_tally tally = {.improved = 0};
    int64_t n = 0;
    (void)state;
    begin(&t, BOX_HEXAHEDRA);
    move_all(&t, 0.01, &random);
    const int64_t star = t.n / 2;
    const pl_star_gain gain = {.fall = 1};
    place_of(&t, star)[0] += 2;
    pl_watch_note_move(&t.watch, star, t.problem.node[star], t.before[star], 2, &gain);
    pl_watch_end_sweep(&t.watch, &t.problem, t.n, &tally);
    assert_memory_equal(place_of(&t, star), t.before[star], sizeof *t.before);
    assert_false(t.watch.late.is_on);
    pl_watch_begin_sweep(&t.watch, 1);
    for (int64_t i = 0; i < t.watch.n; i++) {
        assert_int_equal(t.watch.late.when[i],
                         t.watch.n_refused_of[i] > 0 ? PL_WATCH_AT_ONCE : PL_WATCH_WAITS);
        n += t.watch.late.when[i] == PL_WATCH_AT_ONCE;
    }
    assert_true(n > 0 && n <= 8 && t.watch.late.has_at_once[t.problem.node[star]]);
    end(&t);
}

/** Where too many cells may not wait, none does; nor where they are not to. */
static void cells_wait_where_most_may(void **state) {
    world t;
    (void)state;
    begin(&t, BOX_WEDGES);
    pl_watch_begin_sweep(&t.watch, 0);
    assert_false(t.watch.late.is_on);
    for (int64_t i = 0; i < t.watch.n / 4; i++)
        t.watch.n_refused_of[i] = 1;
    pl_watch_begin_sweep(&t.watch, 1);
    assert_false(t.watch.late.is_on);
    end(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(moves_are_undone_by_the_rule),
        cmocka_unit_test(cells_that_refused_wait_no_more),
        cmocka_unit_test(cells_wait_where_most_may),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
