/* The same mesh in other forms: turned, mirrored, moved, numbered otherwise. What is measured is
 * the same, what is smoothed comes to the same. */
#include "support/effort.h"
#include "support/forms.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* RR is worst determined where it is large: by so much of itself for each unit of it. In the same
 * coordinates by the rounding of sums; where they are rounded anew, by that of 5 edges to 53 bits;
 * where they are 1e9 edges away, to 1.2e-7 of an edge. Seen: 2e-15, 3e-15 and 1.5e-7. */
static const double BEFORE[] = {
    [FORM_RENAMED] = 2e-14, [FORM_SHIFTED] = 0, [FORM_ROUNDED] = 4e-14, [FORM_FAR] = 2e-6};

/* Of RR above it the sign may turn where coordinates are rounded anew. */
#define FLAT 1e5

/* How far the objectives may be apart in the end, relative. There are several optima, and which one
 * is converged to hangs on the order of visits; but that is rare, and they are close. */
#define APART   0.02
#define USUALLY 1e-4 /* in 9 of 10 cases */

/** Whether what is converged to is an optimum of F, and not of the worst element, which F may be
 *  given for, nor the state after some sweeps. The edge ratio has next to no derivative where edges
 *  change places as the longest. */
static int is_optimum(test_wish wish) {
    return wish < WISH_LAPLACIAN && wish != WISH_WORST_RATIO && wish != WISH_WORST_ANGLE &&
           wish != WISH_EDGE_RATIO;
}

/** A form of a problem, and both solved. */
typedef struct pair {
    const test_form *form;
    test_wish wish;
    test_problem p;
    test_outcome a, b;
} pair;

static void create(pair *t, int dim, test_wish wish, const test_form *form, unsigned seed) {
    test_problem other;
    *t = (pair){.form = form, .wish = wish};
    test_problem_create(&t->p, dim, dim == 3 ? 3 : 5, wish, seed);
    test_problem_create(&other, dim, dim == 3 ? 3 : 5, wish, seed);
    if (wish < WISH_LAPLACIAN) { /* as far as it goes */
        t->p.options.tolerance = other.options.tolerance = 1e-12;
        t->p.options.max_sweeps = other.options.max_sweeps = 2000;
    }
    form->apply(&other, seed);
    t->a = test_problem_solve(&t->p);
    t->b = test_problem_solve(&other);
    test_problem_destroy(&other);
}

static void destroy(pair *t) {
    test_problem_destroy(&t->p);
    test_outcome_destroy(&t->a);
    test_outcome_destroy(&t->b);
}

static void differ(const pair *t, const char *what, double a, double b) {
    fail_msg("%d-D, %s, %s: %s is %.17g, was %.17g", t->p.mesh.dim, test_wish_names[t->wish],
             t->form->name, what, b, a);
}

static void expect_equal(const pair *t, const char *what, int64_t a, int64_t b) {
    if (a != b)
        differ(t, what, (double)a, (double)b);
}

static void expect_near(const pair *t, const char *what, double a, double b, double tolerance) {
    if (!(fabs(b - a) <= tolerance * fabs(a)))
        differ(t, what, a, b);
}

/** The elements' ratios and signs as they are given; returns the largest deviation. */
static double compare_elements(const pair *t) {
    const int is_exact = t->form->kind == FORM_RENAMED || t->form->kind == FORM_SHIFTED;
    double worst = 0;
    for (int64_t i = 0; i < t->p.mesh.n_elements; i++) {
        const double a = t->a.ratio_before[i], b = t->b.ratio_before[i];
        expect_equal(t, "an element that is not known", isnan(a), isnan(b));
        if (isnan(a) || (!is_exact && (a > FLAT || b > FLAT)))
            continue;
        expect_equal(t, "the sign of an element", a > 0, b > 0);
        if (a > 0) {
            expect_near(t, "a radius ratio", a, b, BEFORE[t->form->kind] * a);
            worst = fmax(worst, fabs(b / a - 1) / a);
        }
    }
    return worst;
}

/** What the plan finds, and what is measured before. */
static void compare_before(const pair *t) {
    const planish_plan_info *a = &t->a.info, *b = &t->b.info;
    const planish_quality *p = &t->a.before, *q = &t->b.before;
    expect_equal(t, "n_free", a->n_free, b->n_free);
    expect_equal(t, "n_sliding", a->n_sliding, b->n_sliding);
    expect_equal(t, "n_fixed_elements", a->n_fixed_elements, b->n_fixed_elements);
    if (t->wish != WISH_ONLY_WORSE && t->wish != WISH_AROUND) /* counted there only if needed */
        expect_equal(t, "n_boundary_facets", a->n_boundary_facets, b->n_boundary_facets);
    expect_equal(t, "n_fixed", p->n_fixed_elements, q->n_fixed_elements);
    if (t->form->kind > FORM_SHIFTED && t->wish == WISH_HOPELESS)
        return; /* flat elements, and proofs that need more than rounding */
    expect_equal(t, "inverted", p->n_inverted, q->n_inverted);
    if (t->wish == WISH_HOPELESS) /* which ones of several proofs: that hangs on their order */
        expect_equal(t, "anything unfixable", t->a.unfixable > 0, t->b.unfixable > 0);
    else
        expect_equal(t, "unfixable", t->a.unfixable, t->b.unfixable);
    const double tolerance = 2 * BEFORE[t->form->kind] * p->max_radius_ratio;
    expect_near(t, "rms_radius_ratio", p->rms_radius_ratio, q->rms_radius_ratio, tolerance);
    expect_near(t, "max_radius_ratio", p->max_radius_ratio, q->max_radius_ratio, tolerance);
    if (t->form->kind == FORM_SHIFTED && memcmp(p, q, sizeof *p) != 0)
        differ(t, "the quality", 0, 1);
}

/** Elements that are brought above their minimum volume may become worse than the worst. */
static int asks_for_volumes(test_wish wish) {
    return wish == WISH_LEAST_VOLUME || wish == WISH_OWN_VOLUMES || wish == WISH_FRACTION;
}

/** What it is smoothed to; returns how far F is from that of the first form. */
static double compare_after(const pair *t) {
    const planish_quality *before = &t->b.before, *q = &t->b.after;
    if (t->wish == WISH_HOPELESS) {
        assert_true(q->n_inverted <= before->n_inverted);
        return 0;
    }
    expect_equal(t, "inverted in the end", t->a.after.n_inverted, q->n_inverted);
    expect_equal(t, "below minimum volumes", t->a.below > 0, t->b.below > 0);
    expect_near(t, "the objective", t->a.result.objective, t->b.result.objective, APART);
    const int may_be_worse = t->wish >= WISH_LAPLACIAN || asks_for_volumes(t->wish);
    if (before->n_inverted == 0 && !may_be_worse && q->max_radius_ratio > before->max_radius_ratio)
        differ(t, "the worst", before->max_radius_ratio, q->max_radius_ratio);
    return fabs(t->b.result.objective / t->a.result.objective - 1);
}

static void forms_are_the_same_mesh(void **state) {
    const int dim = *(int *)*state;
    uint64_t random = effort_seed(23 + (uint64_t)dim);
    double element = 0, farthest = 0, far = 0, usual = 0;
    int n = 0, n_optima = 0, n_apart = 0;
    for (int i = 0; i < effort(1, 40); i++)
        for (int wish = 0; wish < WISHES; wish++)
            for (const test_form *form = test_forms; form->name; form++) {
                if (!test_form_suits(form, (test_wish)wish))
                    continue;
                pair t;
                create(&t, dim, (test_wish)wish, form, (unsigned)random_bits(&random));
                compare_before(&t);
                double *worst = form->kind == FORM_FAR ? &far : &element;
                *worst = fmax(*worst, compare_elements(&t));
                const int optimum = is_optimum((test_wish)wish);
                const double apart = compare_after(&t);
                double *most = optimum ? &usual : &farthest;
                *most = fmax(*most, apart);
                n_optima += optimum;
                n_apart += optimum && apart > USUALLY;
                destroy(&t);
                n++;
            }
    figure("%d-D: %d forms; RR differs by %.1e of its square, far away by %.1e; F in the end by "
           "more than %g in %d of %d cases, at most %.1e; for the worst, edges and averages %.1e",
           dim, n, element, far, USUALLY, n_apart, n_optima, usual, farthest);
    assert_true(n_apart < n_optima / 10);
}

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        {"forms 2-D", forms_are_the_same_mesh, NULL, NULL, &two},
        {"forms 3-D", forms_are_the_same_mesh, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
