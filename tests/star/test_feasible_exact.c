/* What a star's node can reach, against rational arithmetic: nearest feasible places, and proofs
 * that there are none. Every answer is checked by an exact certificate (Farkas' lemma), and the
 * exact answer is found besides, by projection and by the simplex method, which must agree.
 */
#define PL_PACK 1
#include "star/kernel_feasible.h"
#include "support/cone_problems.h"
#include "support/hand_star.h"
#include "support/rational.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#ifdef PLANISH_HAVE_GMP

static double number(const mpq_t q) {
    return mpq_get_d(q);
}

/* ---- the nearest feasible place ------------------------------------------------------------- */

/** {(d, t) : normal . d + c t <= 0} with normals of unit length, or 0, and c of any size. */
static void make_rows(cone_problem *q, uint64_t *random) {
    const double sizes[] = {0, 1, 1, 1e-3, 1e-9, 1e6};
    do
        cone_problem_make(q, random);
    while (q->n < 3);
    for (int d = 0; d < CONE_DIM; d++)
        q->p[d] = d == q->n - 1;
    for (int j = 0; j < q->m; j++) {
        double *a = q->rows[j], length = sqrt(cone_dot(a, a, q->n - 1));
        for (int d = 0; length > 0 && d < q->n - 1; d++)
            a[d] /= length;
        if (random_below(random, 2))
            a[q->n - 1] = sizes[random_below(random, 6)] * random_between(random, -1, 1);
    }
}

/** -row . d >= c, for the simplex method. */
static void set_system(const rational_cone *c, rational_system *s) {
    s->m = c->m;
    s->n = c->n - 1;
    for (int j = 0; j < c->m; j++) {
        for (int d = 0; d < s->n; d++)
            mpq_neg(s->row[j][d], c->row[j][d]);
        mpq_set(s->least[j], c->row[j][s->n]);
    }
}

/* A displacement may break a row by what the projection may, scaled as it is, and rounding. */
#define ROW_BROKEN 1.01e-12
/* A proof holds within so many sizes at least, as far as weights above WEIGHT_LEAST reach; or as
 * far as multipliers can say that are rounded by this part of them. */
#define PROVED_WITHIN 3e4
#define ROUNDED       1e-15

/** Exactly: the displacement keeps all rows, to the tolerance. */
static int is_place(rational_cone *c, const double *displacement, double weight) {
    mpq_t x;
    int holds = 1;
    mpq_init(x);
    for (int j = 0; j < c->m; j++) {
        double length2 = 0;
        mpq_set(c->t[0], c->row[j][c->n - 1]);
        for (int d = 0; d < c->n; d++)
            length2 += number(c->row[j][d]) * number(c->row[j][d]);
        for (int d = 0; d < c->n - 1; d++) {
            mpq_set_d(x, displacement[d]);
            rational_add_product(c->t[0], x, c->row[j][d]);
        }
        holds &= number(c->t[0]) <= ROW_BROKEN * sqrt(length2) / weight;
    }
    mpq_clear(x);
    return holds;
}

/** Exactly: how far away a feasible place is at least, by the multipliers; 0 if they prove nothing:
 *  sum lambda_j row_j = (r, s), so a place d has r . d + s <= 0. */
static double proved_within(rational_cone *c, const cone_point *found) {
    double rest = 0, weights = 0;
    mpq_t sum, weight;
    mpq_inits(sum, weight, NULL);
    for (int i = 0; i < found->n_active; i++)
        weights += found->multiplier[i];
    for (int d = 0; d < c->n; d++) {
        mpq_set_ui(sum, 0, 1);
        for (int i = 0; i < found->n_active; i++) {
            mpq_set_d(weight, found->multiplier[i]);
            rational_add_product(sum, weight, c->row[found->active[i]][d]);
        }
        rest = d < c->n - 1 ? hypot(rest, number(sum)) : rest;
    }
    const double within = mpq_sgn(sum) > 0 ? number(sum) / fmax(0, rest - ROUNDED * weights) : 0;
    mpq_clears(sum, weight, NULL);
    return within;
}

static void places_are_proved(void **state) {
    const int64_t n = effort(20000, 300000);
    uint64_t random = effort_seed(30);
    int64_t places = 0, exact_places = 0, thin = 0;
    rational_cone c;
    rational_system s;
    (void)state;
    rational_cone_init(&c);
    rational_system_init(&s);
    for (int64_t i = 0; i < n; i++) {
        cone_problem q = {.nearly = ldexp(1, -2 - (int)(i % 50))};
        double displacement[3];
        cone_point found;
        make_rows(&q, &random);
        const active a = {q.rows, q.m, NULL};
        const int place = shortest_displacement(&a, displacement, &found, q.n - 1);
        rational_cone_set(&c, (const double(*)[CONE_DIM])q.rows, q.m, q.p, q.n);
        rational_cone_project(&c, found.active, found.n_active);
        set_system(&c, &s);
        const int exact = mpq_sgn(c.y[q.n - 1]) > 0;
        assert_int_equal(exact, rational_system_solve(&s));
        if (place)
            assert_true(is_place(&c, displacement, found.point[q.n - 1]));
        else
            assert_true(proved_within(&c, &found) >= PROVED_WITHIN);
        places += place;
        exact_places += exact;
        thin += place != exact;
    }
    rational_system_clear(&s);
    rational_cone_clear(&c);
    figure(
        "nearest places: %lld problems, %lld with a place, %lld exactly; %lld differ, all within "
        "the tolerances",
        (long long)n, (long long)places, (long long)exact_places, (long long)thin);
    assert_true(exact_places > n / 4 && n - exact_places > n / 20);
}

/* ---- what is given up at a star ------------------------------------------------------------- */

/** A star, and D_j = normal_j . x + constant_j of its elements, exact, with the floors that they
 * are held to. */
typedef struct star_case {
    hand_star s;
    pl_star_guard guard;
    double own[HAND_STAR_MAX_FACETS]; /* minimum volumes */
    uint8_t is_fixed[HAND_STAR_MAX_NODES], part[HAND_STAR_MAX_FACETS];
    mpq_t normal[HAND_STAR_MAX_FACETS][3], constant[HAND_STAR_MAX_FACETS];
    double length[HAND_STAR_MAX_FACETS]; /* of the normals */
    double floor[HAND_STAR_MAX_FACETS];  /* 0: the element is not asked for */
    double middle[3], size;
    int has_volumes; /* some are asked for */
    int is_flat;     /* planes are so nearly parallel that a place might be, as far as CONE_VIOLATED
                        tells, nearer than proofs have to reach: they may be missed */
} star_case;

static int64_t facets(const star_case *k) {
    return k->s.link_offset[1];
}

/** What may be wrong with a link, or hard. */
static void deform(star_case *k, uint64_t *random) {
    const int dim = k->s.dim, n = (int)k->s.ring_offset[1], kind = (int)random_below(random, 8);
    double *x = k->s.coordinates, amount = 1.5 * random_unit(random);
    k->is_flat = kind == 2;
    for (int i = dim; i < (n + 1) * dim; i++)
        x[i] += kind == 0 ? 0 : amount * random_between(random, -1, 1);
    for (int i = dim; i < (n + 1) * dim; i++)
        switch (kind) {
        case 1: /* many planes and lines in common */
            x[i] = round(2 * x[i]) / 2;
            break;
        case 2:
            x[i] *= i % dim == 0 ? 1e-5 : 1;
            break;
        case 3: /* far from the origin */
            x[i] += 100;
            break;
        case 4: /* small */
            x[i] *= 1e-5;
        }
    if (kind == 5) /* two nodes at one place */
        memcpy(x + dim, x + 2 * dim, (size_t)dim * sizeof *x);
    for (int d = 0; d < dim; d++)
        x[d] = x[(1 + random_below(random, n)) * dim + d] + random_between(random, -0.5, 0.5);
}

/** constant + normal . x = -det(p - x, q - x, r - x), in the plane det(p - x, q - x). */
static void find_planes(star_case *k) {
    const int dim = k->s.dim;
    mpq_t p[3][3], t;
    mpq_init(t);
    for (int i = 0; i < 9; i++)
        mpq_init(p[i / 3][i % 3]);
    for (int64_t f = 0; f < facets(k); f++) {
        for (int i = 0; i < dim * dim; i++)
            mpq_set_d(p[i / dim][i % dim],
                      k->s.coordinates[(1 + k->s.link[f * dim + i / dim]) * dim + i % dim]);
        mpq_set_ui(k->constant[f], 0, 1);
        for (int d = 0; d < dim; d++) {
            const int e = (d + 1) % 3, g = (d + 2) % 3;
            mpq_set_ui(k->normal[f][d], 0, 1);
            for (int i = 0; dim == 3 && i < 3; i++) { /* cross products of p, q and r */
                rational_add_product(k->normal[f][d], p[i][e], p[(i + 1) % 3][g]);
                mpq_neg(t, p[i][g]);
                rational_add_product(k->normal[f][d], t, p[(i + 1) % 3][e]);
            }
        }
        if (dim == 2) {
            mpq_sub(k->normal[f][0], p[0][1], p[1][1]);
            mpq_sub(k->normal[f][1], p[1][0], p[0][0]);
        }
        for (int d = 0; d < dim; d++) { /* 0 at p */
            mpq_neg(t, p[0][d]);
            rational_add_product(k->constant[f], t, k->normal[f][d]);
        }
    }
    for (int i = 0; i < 9; i++)
        mpq_clear(p[i / 3][i % 3]);
    mpq_clear(t);
}

/** D of the element with the node at x, rounded but once. */
static double measure_of(const star_case *k, int64_t f, const double *x) {
    mpq_t sum, t;
    mpq_inits(sum, t, NULL);
    mpq_set(sum, k->constant[f]);
    for (int d = 0; d < k->s.dim; d++) {
        mpq_set_d(t, x[d]);
        rational_add_product(sum, t, k->normal[f][d]);
    }
    const double result = number(sum);
    mpq_clears(sum, t, NULL);
    return result;
}

/** The floors as feasibility.c says: the minimum volume, or a part of the mean measure or of that
 * of the facet times the star's size. */
static void find_floors(star_case *k) {
    const int dim = k->s.dim;
    const int64_t n = k->s.ring_offset[1];
    double mean = 0, size2 = 0;
    for (int d = 0; d < dim; d++) {
        k->middle[d] = 0;
        for (int64_t i = 1; i <= n; i++)
            k->middle[d] += k->s.coordinates[i * dim + d] / (double)n;
    }
    for (int64_t f = 0; f < facets(k); f++) {
        const double *p = k->s.coordinates + (1 + k->s.link[f * dim]) * dim;
        k->length[f] = 0;
        for (int d = 0; d < dim; d++) {
            k->length[f] = hypot(k->length[f], number(k->normal[f][d]));
            size2 += (p[d] - k->middle[d]) * (p[d] - k->middle[d]) / (double)facets(k);
        }
        mean += fabs(measure_of(k, f, k->middle)) / (double)facets(k);
    }
    k->size = sqrt(size2);
    for (int64_t f = 0; f < facets(k); f++) {
        int asked = k->length[f] > 0;
        for (int j = 0; j < dim; j++)
            asked &= k->is_fixed[1 + k->s.link[f * dim + j]];
        k->floor[f] = k->own[f] > 0 ? k->own[f] * (dim == 3 ? 6 : 2)
                                    : 1e-9 * fmin(mean, k->length[f] * k->size);
        k->floor[f] = asked ? k->floor[f] : 0;
    }
}

/** A star with its exact planes; the initialised numbers of *k are used again. */
static void make_star(star_case *k, int dim, uint64_t *random) {
    hand_star_create(&k->s, dim, 0.5 * random_unit(random),
                     (unsigned)random_below(random, 1 << 30));
    k->guard = (pl_star_guard){.ratio_weight = 1, .link_min_volume = k->own};
    k->s.problem.guard = &k->guard;
    deform(k, random);
    const int free_part = (int)random_below(random, 2), volumes = (int)random_below(random, 4);
    const double part = volumes == 3 ? pow(10, random_between(random, -16, 0)) : 1;
    for (int i = 0; i < HAND_STAR_MAX_NODES; i++)
        k->is_fixed[i] = i > 0 && (free_part || random_below(random, 8));
    find_planes(k);
    k->has_volumes = volumes > 0;
    for (int64_t f = 0; f < facets(k); f++) {
        const double V = fabs(measure_of(k, f, k->s.coordinates)) * random_unit(random) * part;
        k->own[f] = volumes == 0 || (volumes == 1 && random_below(random, 2)) ? 0 : V;
    }
    find_floors(k);
}

/** {x : D_j >= part floor_j - slack |normal_j| size for the facets that wanted has}, within reach
 *  sizes of the middle. */
static int has_place(const star_case *k, const uint8_t *wanted, double part, double slack,
                     double reach, rational_system *s) {
    mpq_t t;
    mpq_init(t);
    s->m = 0;
    s->n = k->s.dim;
    for (int64_t f = 0; f < facets(k); f++) {
        if (!wanted[f])
            continue;
        mpq_set_d(t, part * k->floor[f] - slack * k->length[f] * k->size);
        mpq_sub(s->least[s->m], t, k->constant[f]);
        for (int d = 0; d < s->n; d++)
            mpq_set(s->row[s->m][d], k->normal[f][d]);
        s->m++;
    }
    for (int i = 0; i < 2 * s->n; i++, s->m++) {
        const int sign = i % 2 ? 1 : -1;
        for (int d = 0; d < s->n; d++)
            mpq_set_si(s->row[s->m][d], d == i / 2 ? sign : 0, 1);
        mpq_set_d(s->least[s->m], sign * k->middle[i / 2] - reach * k->size);
    }
    mpq_clear(t);
    return rational_system_solve(s);
}

/* Rounding of planes that are computed, by the star's size. */
#define PLANE_ROUNDING 1e-7
/* Proofs hold within so many sizes of the star, by whatever is called its size; of places that are
 * farther away nothing is said. */
#define PROVED 1e5
#define REACH  1e12

typedef struct verdicts {
    int64_t stars, proofs, given_up, missed;
    int64_t inverted,
        thin; /* proofs without minimum volumes; with a place for very thin elements */
} verdicts;

/** What is part of a proof contradicts itself; the rest, where something was given up or not, does
 *  not. */
static void judge(star_case *k, int n_given_up, rational_system *s, verdicts *v) {
    uint8_t members[HAND_STAR_MAX_FACETS], rest[HAND_STAR_MAX_FACETS];
    int n = 0;
    for (int64_t f = 0; f < facets(k); f++) {
        members[f] = k->part[f] != PL_PROOF_NONE;
        rest[f] = k->floor[f] > 0 && k->part[f] != PL_PROOF_GIVEN_UP;
        assert_true(!members[f] || k->floor[f] > 0);
        n += k->part[f] == PL_PROOF_GIVEN_UP;
    }
    assert_int_equal(n, n_given_up);
    if (n > 0)
        assert_false(has_place(k, members, 1, 0, PROVED, s));
    const int missed = !has_place(k, rest, 1 - PLANISH_VOLUME_TOLERANCE, PLANE_ROUNDING, REACH, s);
    assert_true(!missed || k->is_flat);
    v->missed += missed;
    if (!k->has_volumes && n > 0) {
        v->inverted++;
        v->thin += has_place(k, members, 1e-9, 0, PROVED, s);
    }
    v->stars++;
    v->proofs += n > 0;
    v->given_up += n;
}

static void what_is_given_up_is_proved(void **state) {
    const int dim = *(int *)*state;
    const int64_t n = effort(1500, 40000);
    uint64_t random = effort_seed(40 + (uint64_t)dim);
    static star_case k;
    rational_system s;
    verdicts v = {0};
    rational_system_init(&s);
    for (int i = 0; i < HAND_STAR_MAX_FACETS * 3; i++)
        mpq_init(k.normal[i / 3][i % 3]);
    for (int i = 0; i < HAND_STAR_MAX_FACETS; i++)
        mpq_init(k.constant[i]);
    for (int64_t i = 0; i < n; i++) {
        make_star(&k, dim, &random);
        const int n_given_up =
            (int)pl_star_infeasible(&k.s.problem, 0, dim, k.is_fixed, k.s.scratch, k.part, NULL);
        judge(&k, n_given_up, &s, &v);
        hand_star_destroy(&k.s);
    }
    for (int i = 0; i < HAND_STAR_MAX_FACETS * 3; i++)
        mpq_clear(k.normal[i / 3][i % 3]);
    for (int i = 0; i < HAND_STAR_MAX_FACETS; i++)
        mpq_clear(k.constant[i]);
    rational_system_clear(&s);
    figure(
        "stars in %d-D: %lld, %lld with a contradiction, %lld elements given up; of %lld without "
        "minimum volumes %lld could have elements of 1e-18 of the mean; %lld "
        "missed in flat ones",
        dim, (long long)v.stars, (long long)v.proofs, (long long)v.given_up, (long long)v.inverted,
        (long long)v.thin, (long long)v.missed);
    assert_true(v.proofs > n / 10 && v.proofs < n - n / 10);
}

int main(void) {
    static int dims[] = {2, 3};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(places_are_proved),
        {"what is given up is proved, 2-D", what_is_given_up_is_proved, NULL, NULL, &dims[0]},
        {"what is given up is proved, 3-D", what_is_given_up_is_proved, NULL, NULL, &dims[1]},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    print_message("built without GMP (libgmp-dev): skipped\n");
    return 0;
}

#endif
