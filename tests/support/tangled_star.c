/* tangled_star: a hand-made star with all that untangling asks. */
#include "support/tangled_star.h"

#include "support/meshes.h"

#include <math.h>
#include <string.h>

double test_few_bits(double x) {
    return ldexp(rint(ldexp(x, 10)), -10);
}

static void put_node(tangled_star *t, int where, unsigned *random) {
    const int dim = t->s.dim;
    const uint16_t *facet =
        t->s.link; /* its mean, of few bits, is on it in 2-D only; near enough */
    for (int d = 0; d < dim; d++) {
        const double there = t->s.coordinates[(1 + facet[0]) * dim + d];
        const double next = t->s.coordinates[(1 + facet[1]) * dim + d];
        const double way = 2 * test_random(random) - 1;
        double *x = t->s.coordinates + d;
        *x = where == INSIDE      ? 0.3 * way
             : where == OUTSIDE   ? 3 * way
             : where == FAR_AWAY  ? 500 * way
             : where == ON_A_NODE ? there
                                  : 0.5 * (there + next);
        *x = where == ON_A_FACET ? *x : test_few_bits(*x);
    }
}

void tangled_create(tangled_star *t, int dim, unsigned seed) {
    unsigned random = seed * 2654435761u + 1;
    memset(t, 0, sizeof *t);
    hand_star_create(&t->s, dim, 0.5 * test_random(&random), seed);
    for (int i = 0; i < HAND_STAR_MAX_NODES; i++) {
        for (int d = 0; d < dim; d++)
            t->s.coordinates[i * dim + d] = test_few_bits(t->s.coordinates[i * dim + d]);
        t->size[i] = 0.3 + 2 * test_random(&random);
    }
    put_node(t, (int)(seed % PLACES), &random);
    t->guard.ratio_weight = 1;
    t->in_patch[0] = 1;
    t->asked = (pl_star_untangling){.in_patch = t->in_patch, .size = t->size, .epsilon = 1};
    t->s.problem.guard = &t->guard;
    t->s.problem.untangling = &t->asked;
}

void tangled_ask_for_more(tangled_star *t, unsigned seed) {
    unsigned random = seed * 2246822519u + 7;
    t->guard.min_volume = test_few_bits(0.2 * test_random(&random));
    t->guard.link_min_volume = t->floors;
    t->asked.link_skip = t->skip;
    for (int i = 0; i < HAND_STAR_MAX_FACETS; i++) {
        t->floors[i] = test_random(&random) < 0.5 ? 0 : test_few_bits(0.5 * test_random(&random));
        t->skip[i] = test_random(&random) < 0.2;
    }
    for (int i = 1; i < HAND_STAR_MAX_NODES; i++)
        t->in_patch[i] = test_random(&random) < 0.5;
}

void tangled_destroy(tangled_star *t) {
    hand_star_destroy(&t->s);
}

int64_t tangled_facets(const tangled_star *t) {
    return t->s.link_offset[1];
}

pl_star_energy tangled_energy(tangled_star *t, planish_isa isa, pl_star_slope *slope) {
    return pl_star_kernel_select(isa)->guarded->energy[t->s.dim - 2](&t->s.problem, 0, 1,
                                                                     t->s.scratch, slope);
}

pl_star_tally tangled_visit(tangled_star *t, planish_isa isa) {
    pl_star_tally tally = {.visits = 0};
    pl_star_kernel_select(isa)->guarded->untangle[t->s.dim - 2](&t->s.problem, 0, 1, t->s.scratch,
                                                                &tally);
    return tally;
}

double tangled_energy_sum(tangled_star *t, planish_isa isa) {
    const pl_star_energy found = tangled_energy(t, isa, NULL);
    return pl_sum_value(&found.sum);
}

double tangled_decrease(tangled_star *t) {
    const pl_star_tally tally = tangled_visit(t, PLANISH_ISA_AUTO);
    return pl_sum_value(&tally.decrease);
}

void tangled_position(const tangled_star *t, long double *x) {
    for (int d = 0; d < t->s.dim; d++)
        x[d] = t->s.coordinates[d];
}
