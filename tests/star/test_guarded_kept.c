/* The guarded kernel with Hessians that are kept: the gradient alone, visits that need no Hessian, and
 * those that do, since a constraint is near. */
#include "support/guarded_star.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { STARS = 40 };

enum { FAR_FLOORS, FAR_BOUNDS, ON_PLANE, ON_LINE, SCENES };

/** A star with what it keeps. */
typedef struct kept_star {
    guarded_star g;
    pl_star_kept kept;
    pl_star_slide slide;
} kept_star;

/** Make a star whose constraint, of this scene, is far from where its node goes. */
static void create(kept_star *k, int scene, unsigned seed) {
    guarded_create(&k->g, 3, 0.3 * seed / STARS, seed);
    k->kept = (pl_star_kept){.sum = 0};
    k->g.s.problem.kept = &k->kept;
    k->g.guard.objective = seed % 2 ? PLANISH_OBJECTIVE_MEAN_RATIO : PLANISH_OBJECTIVE_RADIUS_RATIO;
    if (scene == FAR_FLOORS)
        k->g.guard.min_volume = 1e-3 * (double)guarded_mean_measure(&k->g);
    if (scene == FAR_BOUNDS) {
        for (int d = 0; d < 3; d++) {
            k->g.lower[d] = -100;
            k->g.upper[d] = 100;
        }
        k->g.guard.lower = k->g.lower;
        k->g.guard.upper = k->g.upper;
    }
    if (scene == ON_PLANE || scene == ON_LINE) {
        k->slide = (pl_star_slide){.kind = scene == ON_PLANE ? PLANISH_CONSTRAINT_ON_PLANE
                                                             : PLANISH_CONSTRAINT_ON_LINE,
                                   .direction = {0.6, 0, 0.8}};
        memcpy(k->slide.point, k->g.s.coordinates, sizeof k->slide.point);
        k->g.s.problem.slide = &k->slide;
    }
}

/** Visit until the Hessian is kept, then move all but the node a little. */
static void settle(kept_star *k, planish_isa isa) {
    for (int i = 0; i < 20 && !(k->kept.sum > 0); i++)
        guarded_visit(&k->g, isa);
    assert_true(k->kept.sum > 0);
    for (int n = 1; n < 5; n++)
        k->g.s.coordinates[3 * n] += 1e-4;
}

/** Without the Hessian value and gradient have the same bits. */
static void the_gradient_alone_is_the_same(void **state) {
    (void)state;
    for (int scene = 0; scene < SCENES; scene++)
        for (unsigned seed = 0; seed < STARS; seed++) {
            kept_star k;
            pl_star_value whole = {.sum = 0}, alone = {.sum = 0};
            create(&k, scene, seed);
            assert_true(guarded_evaluate(&k.g, PLANISH_ISA_AUTO, 1, &whole));
            assert_true(guarded_evaluate(&k.g, PLANISH_ISA_AUTO, 2, &alone));
            assert_true(whole.sum == alone.sum && whole.max == alone.max);
            assert_memory_equal(whole.gradient, alone.gradient, sizeof whole.gradient);
            guarded_destroy(&k.g);
        }
}

/** A step by the Hessian that was kept takes two evaluations. It leads nearly as far down as that of a
 *  star that keeps none, and all variants take it to the same bits. */
static void a_hessian_is_kept_away_from_constraints(void **state) {
    (void)state;
    for (int isa = PLANISH_ISA_PLAIN; isa <= PLANISH_ISA_AVX512; isa++)
        for (unsigned i = 0; i < SCENES * STARS && pl_star_kernel_select((planish_isa)isa); i++) {
            kept_star k, plain, none;
            pl_star_value before, after, best;
            const int scene = (int)(i % SCENES);
            create(&k, scene, i / SCENES);
            create(&plain, scene, i / SCENES);
            create(&none, scene, i / SCENES);
            settle(&k, (planish_isa)isa);
            settle(&plain, PLANISH_ISA_PLAIN);
            memcpy(none.g.s.coordinates, k.g.s.coordinates, sizeof k.g.s.coordinates);
            none.g.s.problem.kept = NULL;
            const pl_star_kept settled = k.kept;
            guarded_evaluate(&k.g, PLANISH_ISA_PLAIN, 0, &before);
            const pl_star_tally tally = guarded_visit(&k.g, (planish_isa)isa);
            guarded_visit(&plain.g, PLANISH_ISA_PLAIN);
            guarded_visit(&none.g, PLANISH_ISA_PLAIN);
            guarded_evaluate(&k.g, PLANISH_ISA_PLAIN, 0, &after);
            guarded_evaluate(&none.g, PLANISH_ISA_PLAIN, 0, &best);
            assert_true(after.sum < before.sum);
            assert_true(before.sum - after.sum > 0.5 * (before.sum - best.sum));
            assert_int_equal(tally.evaluations, 2);
            assert_memory_equal(&k.kept, &settled, sizeof settled);
            assert_memory_equal(k.g.s.coordinates, plain.g.s.coordinates, sizeof k.g.s.coordinates);
            guarded_destroy(&k.g);
            guarded_destroy(&plain.g);
            guarded_destroy(&none.g);
        }
}

/** A node that slides stays where it belongs when it steps by what was kept. */
static void kept_steps_stay_on_the_plane(void **state) {
    (void)state;
    for (int scene = ON_PLANE; scene <= ON_LINE; scene++)
        for (unsigned seed = 0; seed < STARS; seed++) {
            kept_star k;
            create(&k, scene, seed);
            settle(&k, PLANISH_ISA_AUTO);
            guarded_visit(&k.g, PLANISH_ISA_AUTO);
            double along = 0, way2 = 0;
            for (int d = 0; d < 3; d++) {
                const double way = k.g.s.coordinates[d] - k.slide.point[d];
                along += way * k.slide.direction[d];
                way2 += way * way;
            }
            assert_true(way2 > 0);
            assert_true(scene == ON_PLANE ? fabs(along) < 1e-15 : way2 - along * along < 1e-15);
            guarded_destroy(&k.g);
        }
}

/** Where a constraint is in force nothing is kept, and what was kept before is given up: the node goes
 *  where that of a star that keeps none goes. */
static void nothing_is_kept_next_to_constraints(void **state) {
    (void)state;
    for (unsigned seed = 0; seed < STARS; seed++)
        for (int of_bounds = 0; of_bounds < 2; of_bounds++) {
            kept_star k, none;
            create(&k, FAR_BOUNDS, seed);
            settle(&k, PLANISH_ISA_AUTO);
            if (of_bounds)
                k.g.upper[0] = k.g.s.coordinates[0];
            else
                k.g.guard.min_volume = 0.97 * (double)guarded_mean_measure(&k.g);
            none = k;
            none.g.s.problem = k.g.s.problem;
            none.g.guard.lower = none.g.lower;
            none.g.guard.upper = none.g.upper;
            none.g.s.problem.guard = &none.g.guard;
            none.g.s.problem.coordinates = none.g.s.coordinates;
            none.g.s.problem.changed = none.g.s.changed;
            none.g.s.problem.kept = NULL;
            guarded_visit(&k.g, PLANISH_ISA_AUTO);
            guarded_visit(&none.g, PLANISH_ISA_AUTO);
            assert_true(k.kept.sum == 0);
            assert_memory_equal(k.g.s.coordinates, none.g.s.coordinates, sizeof k.g.s.coordinates);
            guarded_destroy(&k.g);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_gradient_alone_is_the_same),
        cmocka_unit_test(a_hessian_is_kept_away_from_constraints),
        cmocka_unit_test(kept_steps_stay_on_the_plane),
        cmocka_unit_test(nothing_is_kept_next_to_constraints),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
