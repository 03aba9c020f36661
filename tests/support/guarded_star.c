/* guarded_star: a hand-made star with bounds, floors and an objective, for the guarded kernel. */
#include "support/guarded_star.h"

#include "support/meshes.h"

#include <math.h>
#include <string.h>

unsigned test_mixed_seed(unsigned seed) {
    return seed * 2654435761u + 12345;
}

void guarded_create(guarded_star *g, int dim, double unevenness, unsigned seed) {
    hand_star_create(&g->s, dim, unevenness, seed);
    g->guard = (pl_star_guard){.ratio_weight = 1, .worst_limit = WORST_LIMIT};
    g->s.problem.guard = &g->guard;
    memset(g->floors, 0, sizeof g->floors);
    for (int i = 0; i < HAND_STAR_MAX_NODES * 3; i++) {
        g->lower[i] = -INFINITY;
        g->upper[i] = INFINITY;
    }
}

void guarded_destroy(guarded_star *g) {
    hand_star_destroy(&g->s);
}

void guarded_position(const guarded_star *g, long double *x) {
    for (int d = 0; d < g->s.dim; d++)
        x[d] = g->s.coordinates[d];
}

long double guarded_measure(const guarded_star *g, int64_t facet) {
    long double x[3];
    guarded_position(g, x);
    return hand_star_measure(&g->s, facet, x);
}

int64_t guarded_facets(const guarded_star *g) {
    return g->s.link_offset[1];
}

long double guarded_worst(const guarded_star *g) {
    long double most = -INFINITY;
    for (int64_t f = 0; f < guarded_facets(g); f++)
        if (hand_star_floor(&g->s, f) > 0)
            most = fmaxl(most, 1 - guarded_measure(g, f) / hand_star_floor(&g->s, f));
    return most;
}

long double guarded_mean_measure(const guarded_star *g) {
    long double sum = 0;
    for (int64_t f = 0; f < guarded_facets(g); f++)
        sum += guarded_measure(g, f);
    return sum / guarded_facets(g);
}

pl_star_tally guarded_visit(guarded_star *g, planish_isa isa) {
    g->s.changed[0] = 1;
    pl_star_tally tally = {.visits = 0};
    pl_star_kernel_select(isa)->guarded->visit[g->s.dim - 2](&g->s.problem, 0, 1, g->s.scratch,
                                                             &tally);
    return tally;
}

void guarded_visits(guarded_star *g, int n) {
    for (int i = 0; i < n; i++)
        guarded_visit(g, PLANISH_ISA_AUTO);
}

int guarded_evaluate(guarded_star *g, planish_isa isa, int derive, pl_star_value *value) {
    memset(value, 0, sizeof *value); /* padding, too, which is compared */
    return pl_star_kernel_select(isa)->guarded->evaluate[g->s.dim - 2](&g->s.problem, 0,
                                                                       g->s.scratch, derive, value);
}

pl_star_optimality guarded_optimality(guarded_star *g, planish_isa isa) {
    pl_star_optimality o = {0};
    pl_star_kernel_select(isa)->guarded->optimality[g->s.dim - 2](&g->s.problem, 0, 1, g->s.scratch,
                                                                  &o);
    return o;
}

void guarded_random_floors(guarded_star *g, unsigned *state) {
    g->guard.min_volume = (double)guarded_mean_measure(g) * 0.5 * test_random(state);
    g->guard.link_min_volume = g->floors;
    for (int64_t f = 0; f < guarded_facets(g); f++)
        g->floors[f] =
            test_random(state) < 0.5 ? 0 : (double)guarded_measure(g, f) * 1.2 * test_random(state);
}
