/* The kernels' objective against textbook formulas in long double, and the variants against the
 * plain one, bit for bit. */
#include "base/round.h"
#include "support/hand_star.h"

#include "geometry/angle.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { STARS = 200 };

static const planish_isa variants[] = {PLANISH_ISA_VECTOR, PLANISH_ISA_AVX2, PLANISH_ISA_AVX512};

static void evaluate_with(hand_star *s, planish_isa isa, int with_derivatives,
                          pl_star_value *value) {
    memset(value, 0, sizeof *value); /* padding, too, which is compared */
    const pl_star_kernel *kernel = pl_star_kernel_select(isa);
    assert_true(kernel->evaluate[s->dim - 2](&s->problem, 0, s->scratch, with_derivatives, value));
}

static void evaluate(hand_star *s, planish_isa isa, pl_star_value *value) {
    evaluate_with(s, isa, 1, value);
}

static void evaluate_gradient(hand_star *s, planish_isa isa, pl_star_value *value) {
    evaluate_with(s, isa, PL_GRADIENT_ALONE, value);
    memset(value->hessian, 0, sizeof value->hessian);
}

static void regular_star_has_known_value(void **state) {
    (void)state;
    hand_star s;
    pl_star_value value;
    hand_star_create(&s, 2, 0, 1); /* a hexagon: six equilateral triangles */
    evaluate(&s, PLANISH_ISA_PLAIN, &value);
    assert_true(fabs(value.sum - 6) < 1e-13);
    assert_true(fabs(value.max - 1) < 1e-14);
    assert_true(fabs(value.gradient[0]) < 1e-13 && fabs(value.gradient[1]) < 1e-13);
    hand_star_destroy(&s);
}

/** Central differences in long double, extrapolated once, of the sum along direction e_i (+ e_j).
 */
static long double difference(const hand_star *s, int i, int j, int second) {
    long double result[2];
    for (int level = 0; level < 2; level++) {
        long double h = level ? 5e-5L : 1e-4L, f[3];
        for (int k = 0; k < 3; k++) {
            long double x[3];
            for (int d = 0; d < s->dim; d++)
                x[d] = s->coordinates[d] + (k - 1) * h * ((d == i) + (d == j));
            f[k] = hand_star_sum(s, x);
        }
        result[level] = second ? (f[0] - 2 * f[1] + f[2]) / (h * h) : (f[2] - f[0]) / (2 * h);
    }
    return (4 * result[1] - result[0]) / 3;
}

static pl_star_tally visit(hand_star *s, planish_isa isa) {
    pl_star_tally tally = {.visits = 0};
    pl_star_kernel_select(isa)->visit[s->dim - 2](&s->problem, 0, 1, s->scratch, &tally);
    return tally;
}

static void derivatives_match_differences(void **state) {
    int dim = *(int *)*state;
    for (unsigned seed = 0; seed < STARS; seed++) {
        hand_star s;
        pl_star_value value;
        hand_star_create(&s, dim, 0.4 * seed / STARS, seed);
        evaluate(&s, PLANISH_ISA_PLAIN, &value);
        long double x[3];
        for (int d = 0; d < dim; d++)
            x[d] = s.coordinates[d];
        long double sum = hand_star_sum(&s, x);
        assert_true(fabsl(value.sum - sum) < 1e-12L * sum);

        long double size = 0, second[3][3];
        for (int i = 0; i < dim; i++)
            size += fabsl(second[i][i] = difference(&s, i, -1, 1));
        for (int i = 0, k = 0; i < dim; i++)
            for (int j = i; j < dim; j++, k++) {
                /* along e_i + e_j the second difference is H_ii + 2 H_ij + H_jj */
                long double wanted =
                    i == j ? second[i][i]
                           : (difference(&s, i, j, 1) - second[i][i] - second[j][j]) / 2;
                assert_true(fabsl(value.hessian[k] - wanted) < 1e-7L * size);
            }
        for (int i = 0; i < dim; i++)
            assert_true(fabsl(value.gradient[i] - difference(&s, i, -1, 0)) < 1e-9L * size);
        hand_star_destroy(&s);
    }
}

static void variants_give_the_same_bits(void **state) {
    int dim = *(int *)*state;
    for (size_t v = 0; v < sizeof variants / sizeof *variants; v++) {
        if (!pl_star_kernel_select(variants[v]))
            continue;
        for (unsigned seed = 0; seed < STARS; seed++) {
            hand_star plain, other;
            pl_star_value a, b;
            hand_star_create(&plain, dim, 0.5 * seed / STARS, seed);
            hand_star_create(&other, dim, 0.5 * seed / STARS, seed);
            plain.problem.search = other.problem.search =
                seed % 2 ? PLANISH_SEARCH_NEWTON : PLANISH_SEARCH_FLETCHER_REEVES;
            evaluate(&plain, PLANISH_ISA_PLAIN, &a);
            evaluate(&other, variants[v], &b);
            assert_memory_equal(&a, &b, sizeof a);
            evaluate_gradient(&plain, PLANISH_ISA_PLAIN, &a);
            evaluate_gradient(&other, variants[v], &b);
            assert_memory_equal(&a, &b, sizeof a);
            for (int i = 0; i < 3; i++) {
                pl_star_tally p = visit(&plain, PLANISH_ISA_PLAIN), q = visit(&other, variants[v]);
                assert_memory_equal(&p, &q, sizeof p);
                assert_memory_equal(plain.coordinates, other.coordinates, sizeof plain.coordinates);
            }
            hand_star_destroy(&plain);
            hand_star_destroy(&other);
        }
    }
}

static void an_inverted_star_is_left_alone(void **state) {
    int dim = *(int *)*state;
    hand_star s;
    hand_star_create(&s, dim, 0.2, 7);
    s.coordinates[0] = 5; /* outside */
    pl_star_tally tally = visit(&s, PLANISH_ISA_AUTO);
    assert_int_equal(tally.visits, 1);
    assert_true(pl_sum_value(&tally.decrease) == 0 && s.coordinates[0] == 5);
    hand_star_destroy(&s);
}

/** Move the centre 0.999 of the way to where an element would lose its last volume. */
static void move_to_the_brink(hand_star *s) {
    double from[3], low = 0, high = 4;
    memcpy(from, s->coordinates, sizeof from);
    for (int i = 0; i < 60; i++) {
        pl_star_value value;
        double middle = 0.5 * (low + high);
        s->coordinates[0] = from[0] + middle;
        int valid = pl_star_kernel_select(PLANISH_ISA_PLAIN)
                        ->evaluate[s->dim - 2](&s->problem, 0, s->scratch, 0, &value);
        *(valid ? &low : &high) = middle;
    }
    s->coordinates[0] = from[0] + 0.999 * low;
}

/** From next to a facet, where RR^2 is huge, visits must come to a local minimum. */
static void visits_reach_a_minimum(void **state) {
    int dim = *(int *)*state;
    for (unsigned seed = 0; seed < STARS; seed++) {
        hand_star s;
        hand_star_create(&s, dim, 0.2, seed);
        s.problem.search = seed % 2 ? PLANISH_SEARCH_NEWTON : PLANISH_SEARCH_FLETCHER_REEVES;
        move_to_the_brink(&s);
        pl_star_value before, after;
        evaluate(&s, PLANISH_ISA_AUTO, &before);
        for (int i = 0; i < 60; i++) {
            s.changed[0] = 1;
            visit(&s, PLANISH_ISA_AUTO);
        }
        evaluate(&s, PLANISH_ISA_AUTO, &after);
        assert_true(after.sum < before.sum / 100);
        double trace =
            after.hessian[0] + (dim == 3 ? after.hessian[3] + after.hessian[5] : after.hessian[2]);
        for (int d = 0; d < dim; d++)
            assert_true(fabs(after.gradient[d]) < 1e-4 * trace);
        hand_star_destroy(&s);
    }
}

/** Visit a regular star whose centre is displaced by this part of its radius. */
static pl_star_tally visit_displaced(int dim, double amount) {
    hand_star s;
    pl_star_value value;
    hand_star_create(&s, dim, 0, 3);
    for (int d = 0; d < dim; d++)
        s.coordinates[d] = d == 0 ? amount : 0;
    evaluate(&s, PLANISH_ISA_AUTO, &value);
    pl_star_tally tally = visit(&s, PLANISH_ISA_AUTO);
    const double decrease = pl_sum_value(&tally.decrease);
    assert_true(decrease > 0 && tally.visits == 1);
    assert_int_equal(tally.improved, decrease > 0.01 * value.sum);
    hand_star_destroy(&s);
    return tally;
}

/** A step takes a look at derivatives and at one trial here; another one follows where the first
 *  brought more than a tenth. */
static void a_visit_steps_again_where_that_pays(void **state) {
    const int dim = *(int *)*state;
    assert_int_equal(visit_displaced(dim, 0.02).evaluations, 2);
    assert_int_equal(visit_displaced(dim, 0.6).evaluations, 4);
}

/* ---- Hessians that are kept ---------------------------------------------------------------- */

static pl_star_tally visit_flagged(hand_star *s, planish_isa isa, int flags) {
    s->changed[0] = (uint8_t)flags;
    return visit(s, isa);
}

static pl_star_tally visit_changed(hand_star *s, planish_isa isa) {
    return visit_flagged(s, isa, PL_CHANGED);
}

static void nudge_ring(hand_star *s, double distance) {
    for (int n = 1; n < 5; n++)
        s->coordinates[n * s->dim] += distance;
}

/** Visit until the Hessian is kept: as soon as the node rests. */
static void settle_and_keep(hand_star *s, pl_star_kept *kept, planish_isa isa) {
    *kept = (pl_star_kept){.sum = 0};
    s->problem.kept = kept;
    for (int i = 0; i < 20 && !(kept->sum > 0); i++)
        visit_changed(s, isa);
    assert_true(kept->sum > 0);
}

/** Whether what is kept is about the inverse of this, which is in the mesh's scale. */
static void expect_inverse(const pl_star_kept *kept, const double *hessian) {
    static const int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    const double scale = ldexp(1, -2 * kept->exponent);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double sum = i == j ? -1 : 0;
            for (int k = 0; k < 3; k++)
                sum += (double)kept->inverse[at[i][k]] * scale * hessian[at[k][j]];
            assert_true(fabs(sum) < 0.2);
        }
}

/** Where little has changed a step needs no Hessian; where much has, it does. Every variant moves
 *  the node to the same bits. */
static void a_hessian_is_kept_while_it_serves(void **state) {
    (void)state;
    for (int isa = PLANISH_ISA_PLAIN; isa <= PLANISH_ISA_AVX512; isa++)
        for (unsigned seed = 0; seed < STARS && pl_star_kernel_select((planish_isa)isa); seed++) {
            hand_star s, plain;
            pl_star_kept kept, plain_kept;
            pl_star_value before, after;
            hand_star_create(&s, 3, 0.3 * seed / STARS, seed);
            hand_star_create(&plain, 3, 0.3 * seed / STARS, seed);
            settle_and_keep(&s, &kept, (planish_isa)isa);
            settle_and_keep(&plain, &plain_kept, PLANISH_ISA_PLAIN);
            const pl_star_kept settled = kept;
            evaluate(&s, PLANISH_ISA_PLAIN, &before);
            expect_inverse(&kept, before.hessian);
            nudge_ring(&s, 1e-4);
            nudge_ring(&plain, 1e-4);
            evaluate(&s, PLANISH_ISA_PLAIN, &before);
            pl_star_tally tally = visit_changed(&s, (planish_isa)isa);
            visit_changed(&plain, PLANISH_ISA_PLAIN);
            evaluate(&s, PLANISH_ISA_PLAIN, &after);
            assert_true(after.sum < before.sum && pl_sum_value(&tally.decrease) > 0);
            assert_int_equal(tally.evaluations, 2);
            assert_memory_equal(&kept, &settled, sizeof kept);
            assert_memory_equal(s.coordinates, plain.coordinates, sizeof s.coordinates);

            do {
                nudge_ring(&s, 0.02);
                nudge_ring(&plain, 0.02);
                evaluate(&s, PLANISH_ISA_PLAIN, &before);
            } while (!(fabs(before.sum - (double)kept.sum) > 0.01 * before.sum));
            tally = visit_changed(&s, (planish_isa)isa);
            visit_changed(&plain, PLANISH_ISA_PLAIN);
            assert_true(pl_sum_value(&tally.decrease) > 0 && tally.evaluations >= 3);
            assert_true(memcmp(&kept, &settled, sizeof kept) != 0);
            assert_memory_equal(&kept, &plain_kept, sizeof kept);
            assert_memory_equal(s.coordinates, plain.coordinates, sizeof s.coordinates);
            hand_star_destroy(&s);
            hand_star_destroy(&plain);
        }
}

/** The step is what was kept times the gradient, in the mesh's scale, whatever the star's scale was
 *  and is. A Hessian that leads nowhere is given up. */
static void a_kept_hessian_gives_the_step(void **state) {
    const double part = 0x1p-14; /* of the gradient: shorter than Newton's step */
    (void)state;
    for (int exponent = -1; exponent <= 1; exponent++) {
        hand_star s;
        pl_star_kept kept;
        pl_star_value value;
        double start[3], gradient2 = 0, along = 0, moved2 = 0;
        hand_star_create(&s, 3, 0.3, 6);
        settle_and_keep(&s, &kept, PLANISH_ISA_AUTO);
        nudge_ring(&s, 1e-4);
        memcpy(start, s.coordinates, sizeof start);
        evaluate(&s, PLANISH_ISA_AUTO, &value);
        kept.exponent += exponent;
        for (int i = 0; i < 6; i++)
            kept.inverse[i] =
                i == 0 || i == 3 || i == 5 ? (float)ldexp(part, 2 * kept.exponent) : 0;
        assert_int_equal(visit_changed(&s, PLANISH_ISA_AUTO).evaluations, 2);
        for (int d = 0; d < 3; d++) {
            gradient2 += value.gradient[d] * value.gradient[d];
            along -= value.gradient[d] * (s.coordinates[d] - start[d]);
            moved2 += (s.coordinates[d] - start[d]) * (s.coordinates[d] - start[d]);
        }
        assert_true(fabs(along / sqrt(gradient2 * moved2) - 1) < 1e-9);
        const double factor = sqrt(moved2 / gradient2) / part; /* over-relaxation */
        assert_true(fabs(factor - 1.4) < 1e-6 || fabs(factor - 1.7) < 1e-6);
        hand_star_destroy(&s);
    }
}

static void a_kept_hessian_that_misleads_is_given_up(void **state) {
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        static const float entries[] = {0, -1, INFINITY, NAN};
        hand_star s, other;
        pl_star_kept kept;
        hand_star_create(&s, 3, 0.3, 5);
        settle_and_keep(&s, &kept, PLANISH_ISA_AUTO);
        nudge_ring(&s, 1e-4);
        hand_star_create(&other, 3, 0.3, 5);
        memcpy(other.coordinates, s.coordinates, sizeof s.coordinates);
        for (int i = 0; i < 6; i++)
            kept.inverse[i] = i == 0 || i == 3 || i == 5 ? entries[kind] : 0;
        visit_changed(&s, PLANISH_ISA_AUTO);
        visit_changed(&other, PLANISH_ISA_AUTO); /* keeps none */
        assert_memory_equal(s.coordinates, other.coordinates, sizeof s.coordinates);
        hand_star_destroy(&s);
        hand_star_destroy(&other);
    }
}

/** A visit with the scale of another size of star, by 2^-off, with the Hessian that was kept or
 *  none, as of a node around which others have moved or not (PL_TOLD). */
static void visit_with_scale(int off, int with_hessian, int flags) {
    hand_star s, other;
    pl_star_kept kept, right;
    hand_star_create(&s, 3, 0.3, 5);
    settle_and_keep(&s, &kept, PLANISH_ISA_AUTO);
    nudge_ring(&s, 1e-4);
    hand_star_create(&other, 3, 0.3, 5);
    memcpy(other.coordinates, s.coordinates, sizeof s.coordinates);
    right = kept;
    other.problem.kept = &right;
    kept.exponent += off;
    for (int j = 0; j < 6; j++)
        kept.inverse[j] = ldexpf(kept.inverse[j], 2 * off);
    if (!with_hessian) {
        kept.sum = PL_SCALE_ALONE;
        right.sum = 0;
    }
    if (abs(off) > 100) {
        assert_int_equal(visit_flagged(&s, PLANISH_ISA_AUTO, flags).improved, 0);
        assert_int_equal(s.changed[0], PL_CHANGED);
        assert_true(kept.sum == 0);
        assert_memory_equal(s.coordinates, other.coordinates, sizeof s.coordinates);
        right.sum = 0;
    }
    visit_flagged(&s, PLANISH_ISA_AUTO, flags);
    visit_flagged(&other, PLANISH_ISA_AUTO, flags);
    assert_memory_equal(s.coordinates, other.coordinates, sizeof s.coordinates);
    assert_true(kept.sum != 0 && right.sum == kept.sum);
    hand_star_destroy(&s);
    hand_star_destroy(&other);
}

/** The scale of the visit before serves, too. No bit tells which it was; but where the star has
 *  left what it was for, the visit does nothing, and the next chooses its own. */
static void a_scale_serves_while_it_fits(void **state) {
    static const int off[] = {-9, 9, -300, 300, 900};
    (void)state;
    for (size_t i = 0; i < sizeof off / sizeof *off; i++)
        for (int with_hessian = 0; with_hessian < 2; with_hessian++) {
            visit_with_scale(off[i], with_hessian, PL_CHANGED);
            visit_with_scale(off[i], with_hessian, PL_CHANGED | PL_TOLD);
        }
}

static void float_positions_are_floats(void **state) {
    int dim = *(int *)*state;
    hand_star s;
    hand_star_create(&s, dim, 0.3, 3);
    s.problem.storage.precision = PLANISH_PRECISION_FLOAT;
    double before = s.coordinates[0];
    visit(&s, PLANISH_ISA_AUTO);
    assert_true(s.coordinates[0] != before);
    for (int d = 0; d < dim; d++)
        assert_true(pl_round_to_float(s.coordinates[d]) == s.coordinates[d]);
    hand_star_destroy(&s);
}

static void limit_refuses_worse_elements(void **state) {
    int dim = *(int *)*state;
    hand_star s;
    pl_star_value value;
    hand_star_create(&s, dim, 0.4, 11);
    evaluate(&s, PLANISH_ISA_AUTO, &value);
    s.problem.limits.rr2 = 0.5; /* below what any element can have */
    double before[3];
    memcpy(before, s.coordinates, sizeof before);
    visit(&s, PLANISH_ISA_AUTO);
    assert_memory_equal(before, s.coordinates, (size_t)dim * sizeof(double));
    hand_star_destroy(&s);
}

/** The smallest angle of a star that is visited until it rests, by the kernel or the guarded one,
 *  with the smallest at first as its limit or without; radians. */
static long double angle_after(const hand_star *s, int guarded, int limited, double *x) {
    const pl_star_guard guard = {.ratio_weight = 1};
    const pl_star_kernel *kernel = pl_star_kernel_select(PLANISH_ISA_AUTO);
    hand_star copy = *s;
    long double place[3];
    for (int d = 0; d < s->dim; d++)
        place[d] = s->coordinates[d];
    const long double sine = sinl(hand_star_angle(s, place));
    copy.problem.coordinates = copy.coordinates;
    copy.problem.changed = copy.changed;
    copy.problem.guard = guarded ? &guard : NULL;
    if (limited) {
        copy.problem.limits.acuteness = (double)(1 / (sine * sine));
        copy.problem.limits.rr2_blunt =
            pl_blunt_ratio_square(s->dim, copy.problem.limits.acuteness);
    }
    for (int i = 0; i < 20; i++) {
        pl_star_tally tally = {.visits = 0};
        copy.changed[0] = 1;
        (guarded ? kernel->guarded->visit : kernel->visit)[s->dim - 2](&copy.problem, 0, 1,
                                                                       copy.scratch, &tally);
    }
    for (int d = 0; d < s->dim; d++)
        place[d] = x[d] = copy.coordinates[d];
    return hand_star_angle(&copy, place);
}

/** Visits lower the smallest angle now and then, but not where it is the limit; and the limit does
 *  not keep stars from becoming better. */
static void limit_refuses_smaller_angles(void **state) {
    enum { MANY = 3000 };
    const int dim = *(int *)*state;
    int lowered = 0, moved = 0;
    for (unsigned seed = 0; seed < MANY; seed++)
        for (int guarded = 0; guarded < 2; guarded++) {
            hand_star s;
            double free[3], limited[3];
            long double x[3];
            hand_star_create(&s, dim, 0.9 * seed / MANY, seed);
            for (int d = 0; d < dim; d++)
                x[d] = s.coordinates[d];
            const long double before = hand_star_angle(&s, x);
            lowered += angle_after(&s, guarded, 0, free) < before * (1 - 1e-9L);
            assert_true(angle_after(&s, guarded, 1, limited) >= before * (1 - 1e-9L));
            moved += memcmp(limited, s.coordinates, (size_t)dim * sizeof *limited) != 0;
            hand_star_destroy(&s);
        }
    assert_true(lowered > 20 && moved > MANY);
}

/** The largest RR^2 of a star that is visited for its mean ratios with a limit of RR^2, by the kernel of
 *  isa; x: where its node is then. */
static long double ratio_after(const hand_star *s, planish_isa isa, double limit, double *x) {
    hand_star copy = *s;
    long double place[3], worst = 0;
    copy.problem.coordinates = copy.coordinates;
    copy.problem.changed = copy.changed;
    copy.problem.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
    copy.problem.limits.rr2 = limit;
    for (int i = 0; i < 20; i++) {
        pl_star_tally tally = {.visits = 0};
        copy.changed[0] = 1;
        pl_star_visit_of(pl_star_kernel_select(isa), &copy.problem, s->dim)(&copy.problem, 0, 1,
                                                                            copy.scratch, &tally);
    }
    for (int d = 0; d < s->dim; d++)
        place[d] = x[d] = copy.coordinates[d];
    for (int64_t f = 0; f < s->link_offset[1]; f++) {
        const long double rr = hand_star_aspect(s, f, place, PLANISH_OBJECTIVE_RADIUS_RATIO);
        const long double mu = hand_star_aspect(s, f, place, PLANISH_OBJECTIVE_MEAN_RATIO);
        assert_true(rr <= (s->dim == 3 ? mu * mu * mu : mu * mu) * (1 + 1e-12L));
        worst = fmaxl(worst, rr * rr);
    }
    return worst;
}

/** Visits that lower mean ratios raise the largest radius ratio now and then, but not where it is the
 *  limit; all variants take the same steps, and the limit lets stars become better. */
static void limit_holds_for_mean_ratios(void **state) {
    enum { MANY = 3000 };
    const int dim = *(int *)*state;
    int raised = 0, moved = 0, differ = 0;
    for (unsigned seed = 0; seed < MANY; seed++) {
        hand_star s;
        double free[3], limited[3], other[3];
        hand_star_create(&s, dim, 0.9 * seed / MANY, seed);
        for (unsigned times = 0; times < seed % 3; times++) /* bring the node nearer to its link */
            for (int d = 0; d < dim; d++)
                s.coordinates[d] = 0.7 * s.coordinates[d] + 0.3 * s.coordinates[dim + d];
        long double x[3], before = 0;
        for (int d = 0; d < dim; d++)
            x[d] = s.coordinates[d];
        for (int64_t f = 0; f < s.link_offset[1]; f++)
            before = fmaxl(before, hand_star_aspect(&s, f, x, PLANISH_OBJECTIVE_RADIUS_RATIO));
        const double limit = (double)(before * before * (1 + 1e-9L));
        raised += ratio_after(&s, PLANISH_ISA_PLAIN, INFINITY, free) > limit;
        assert_true(ratio_after(&s, PLANISH_ISA_PLAIN, limit, limited) <= limit * (1 + 1e-9L));
        moved += memcmp(limited, s.coordinates, (size_t)dim * sizeof *limited) != 0;
        differ += memcmp(limited, free, (size_t)dim * sizeof *limited) != 0;
        for (int isa = PLANISH_ISA_VECTOR; isa <= PLANISH_ISA_AVX512; isa++) {
            if (!pl_star_kernel_select((planish_isa)isa))
                continue;
            ratio_after(&s, (planish_isa)isa, limit, other);
            assert_memory_equal(limited, other, (size_t)dim * sizeof *limited);
        }
        hand_star_destroy(&s);
    }
    assert_true(raised > 100 && differ >= raised && moved > MANY * 9 / 10);
}

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(regular_star_has_known_value),
        {"derivatives 2-D", derivatives_match_differences, NULL, NULL, &two},
        {"derivatives 3-D", derivatives_match_differences, NULL, NULL, &three},
        {"variants 2-D", variants_give_the_same_bits, NULL, NULL, &two},
        {"variants 3-D", variants_give_the_same_bits, NULL, NULL, &three},
        {"inverted 2-D", an_inverted_star_is_left_alone, NULL, NULL, &two},
        {"inverted 3-D", an_inverted_star_is_left_alone, NULL, NULL, &three},
        {"minimum 2-D", visits_reach_a_minimum, NULL, NULL, &two},
        {"minimum 3-D", visits_reach_a_minimum, NULL, NULL, &three},
        {"again 2-D", a_visit_steps_again_where_that_pays, NULL, NULL, &two},
        {"again 3-D", a_visit_steps_again_where_that_pays, NULL, NULL, &three},
        cmocka_unit_test(a_hessian_is_kept_while_it_serves),
        cmocka_unit_test(a_kept_hessian_gives_the_step),
        cmocka_unit_test(a_kept_hessian_that_misleads_is_given_up),
        cmocka_unit_test(a_scale_serves_while_it_fits),
        {"float 2-D", float_positions_are_floats, NULL, NULL, &two},
        {"float 3-D", float_positions_are_floats, NULL, NULL, &three},
        {"limit 2-D", limit_refuses_worse_elements, NULL, NULL, &two},
        {"limit 3-D", limit_refuses_worse_elements, NULL, NULL, &three},
        {"angles 2-D", limit_refuses_smaller_angles, NULL, NULL, &two},
        {"angles 3-D", limit_refuses_smaller_angles, NULL, NULL, &three},
        {"mean ratios 2-D", limit_holds_for_mean_ratios, NULL, NULL, &two},
        {"mean ratios 3-D", limit_holds_for_mean_ratios, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
