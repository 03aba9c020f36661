/* joint: PROTOTYPE patches around worst elements */
#include "improve/improve.h"
#include "improve/joint.h"
#include "improve/maxmin.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/slope.h"
#include "quality/measure_block.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_NODES = 40, MOST_ELEMENTS = 1500, MOST_ROWS = 1500, STEPS = 8, TRIES = 5 };

typedef struct joint_node {
    int32_t node;
    int n; /* directions */
    int first;
    double basis[3][3];
    double scale;
    double start[3];
} joint_node;

typedef struct joint_element {
    int32_t node[4];
    int8_t own[4];
    uint8_t form;
} joint_element;

typedef struct seed {
    int64_t element;
    double value;
    int n, state; /* 0 alive, 1 done, 2 pinned */
    int32_t node[MOST_NODES];
    /* result of the round */
    int gained;
    double rise; /* of sum RR^2 */
    double start[MOST_NODES][3];
    double before, after;
} seed;

typedef struct work {
    joint_node node[MOST_NODES];
    joint_element element[MOST_ELEMENTS];
    int n_nodes, n_elements, n_variables, n_rows;
    double rr_floor;
    pl_maxmin_row row[MOST_ROWS];
    int element_of[MOST_ROWS];
    double x[3 * MOST_NODES], multiplier[3 * MOST_NODES + 1];
    int active[3 * MOST_NODES + 1];
    double room[2 * (3 * MOST_NODES + 1) * (3 * MOST_NODES + 1) + 5 * (3 * MOST_NODES + 1)];
} work;

typedef struct joint {
    pl_run *run;
    int32_t *star_of; /* [n_nodes] interior s, sliding -2 - s, -1 none */
    int32_t *stamp, *touched;
    int32_t round;
    work *work; /* [threads] */
    seed *seeds;
    int n_seeds;
    int *chosen, n_chosen;
    double limit; /* wanted */
    double limit_large; /* no angle above */
    double most_rr; /* least 1/RR allowed */
    int solves, steps, evaluations, qps;
} joint;

static double env(const char *name, double d) { const char *s = getenv(name); return s ? atof(s) : d; }

static int star_at(const joint *j, int32_t node, const pl_visits **visits) {
    const planish_plan *plan = j->run->plan;
    const int32_t s = j->star_of[node];
    *visits = s >= 0 ? &plan->interior : &plan->sliding;
    return s >= 0 ? s : -2 - s;
}

static void gather(const joint *j, const joint_element *e, double x[4][3]) {
    const planish_plan *plan = j->run->plan;
    const int dim = plan->dim;
    for (int v = 0; v <= dim; v++)
        for (int d = 0; d < dim; d++)
            x[v][d] = plan->scratch.coordinates[(int64_t)e->node[v] * dim + d] * j->run->measure_scale;
}

static int measures(const joint *j, const double x[4][3], int derive, pl_slope *slope) {
    const int dim = j->run->plan->dim;
    if (j->run->options->worst == PLANISH_WORST_ANGLE)
        return dim == 3 ? pl_angle_slopes(3, x, derive, slope) : pl_angle_slopes(2, x, derive, slope);
    if (dim == 3)
        pl_ratio_slope_3d(x, derive, slope);
    else
        pl_ratio_slope_2d(x, derive, slope);
    return 1;
}

static double ratio_of(const joint *j, const double x[4][3]) {
    pl_slope s;
    if (j->run->plan->dim == 3)
        pl_ratio_slope_3d(x, 0, &s);
    else
        pl_ratio_slope_2d(x, 0, &s);
    return s.value;
}

/* least measure; 0 if anything is invalid; stops below floor */
static double least_of(const joint *j, const work *w, double floor) {
    const int dim = j->run->plan->dim;
    double least = INFINITY;
    for (int i = 0; i < w->n_elements; i++) {
        double x[4][3], edges[3][3];
        const double *v[4] = {x[0], x[1], x[2], x[3]};
        gather(j, &w->element[i], x);
        pl_edges(dim, v, edges);
        double product = 1;
        for (int k = 0; k < dim; k++) {
            double norm = 0;
            for (int d = 0; d < dim; d++)
                norm += fabs(edges[k][d]);
            product *= norm;
        }
        const double D = pl_determinant_of_edges(dim, (const double(*)[3])edges);
        if (!(D > (dim == 3 ? PL_ERROR_3D : PL_ERROR_2D) * product))
            return -1;
        pl_slope s[PL_MOST_SLOPES];
        const int n = measures(j, (const double(*)[3])x, 0, s);
        for (int k = 0; k < n; k++) {
            least = s[k].value < least ? s[k].value : least;
            if (j->run->options->worst == PLANISH_WORST_ANGLE && !(s[k].value <= j->limit_large))
                return -1;
        }
        if (!(least > floor))
            return least;
    }
    return least;
}

static double sum_of(const joint *j, const work *w) {
    double sum = 0;
    for (int i = 0; i < w->n_elements; i++) {
        double x[4][3];
        gather(j, &w->element[i], x);
        const double q = ratio_of(j, (const double(*)[3])x);
        sum += 1 / (q * q);
    }
    return sum;
}
static double least_ratio_of(const joint *j, const work *w) {
    double least = INFINITY;
    for (int i = 0; i < w->n_elements; i++) {
        double x[4][3];
        gather(j, &w->element[i], x);
        least = fmin(least, ratio_of(j, (const double(*)[3])x));
    }
    return least;
}

static int make_patch(const joint *j, const seed *s, work *w) {
    const planish_plan *plan = j->run->plan;
    const int dim = plan->dim;
    w->n_nodes = s->n;
    w->n_elements = w->n_variables = 0;
    for (int i = 0; i < s->n; i++) {
        joint_node *node = &w->node[i];
        const pl_visits *visits;
        const int star = star_at(j, s->node[i], &visits);
        const pl_stars *stars = &visits->stars;
        node->node = s->node[i];
        node->n = dim;
        node->first = w->n_variables;
        for (int d = 0; d < 3; d++)
            for (int k = 0; k < 3; k++)
                node->basis[d][k] = d == k;
        const double *at = plan->scratch.coordinates + (int64_t)node->node * dim;
        memcpy(node->start, at, (size_t)dim * sizeof *at);
        double square = 0;
        const int64_t r0 = stars->ring_offset[star], r1 = stars->ring_offset[star + 1];
        for (int64_t k = r0; k < r1; k++) {
            const double *p = plan->scratch.coordinates + (int64_t)stars->ring[k] * dim;
            for (int d = 0; d < dim; d++) {
                const double diff = (p[d] - at[d]) * j->run->measure_scale;
                square += diff * diff;
            }
        }
        node->scale = sqrt(square / (double)(r1 - r0));
        if (visits == &plan->sliding) {
            const pl_star_slide *slide = &plan->slide[star];
            if (slide->kind == PLANISH_CONSTRAINT_ON_LINE) {
                node->n = 1;
                memcpy(node->basis[0], slide->direction, sizeof node->basis[0]);
            } else {
                node->n = dim - 1;
                const double *nn = slide->direction;
                if (dim == 2) {
                    node->basis[0][0] = -nn[1];
                    node->basis[0][1] = nn[0];
                } else {
                    int small = fabs(nn[0]) <= fabs(nn[1]) && fabs(nn[0]) <= fabs(nn[2]) ? 0 : fabs(nn[1]) <= fabs(nn[2]) ? 1 : 2;
                    double axis[3] = {small == 0, small == 1, small == 2};
                    pl_cross(nn, axis, node->basis[0]);
                    const double l = sqrt(pl_dot(3, node->basis[0], node->basis[0]));
                    for (int d = 0; d < 3; d++)
                        node->basis[0][d] /= l;
                    pl_cross(nn, node->basis[0], node->basis[1]);
                }
            }
        }
        w->n_variables += node->n;
        const int64_t f0 = stars->link_offset[star], nf = stars->link_offset[star + 1] - f0;
        const pl_link link = pl_link_at(&stars->link, pl_link_positions(dim, stars->form != NULL), f0);
        for (int64_t f = 0; f < nf; f++) {
            if (w->n_elements == MOST_ELEMENTS)
                return 0;
            joint_element *e = &w->element[w->n_elements];
            int first = 1;
            e->node[0] = s->node[i];
            e->own[0] = (int8_t)i;
            for (int k = 0; k < dim; k++) {
                e->node[k + 1] = stars->ring[r0 + pl_link_get(&link, f * dim + k)];
                e->own[k + 1] = -1;
                for (int o = 0; o < s->n; o++)
                    if (s->node[o] == e->node[k + 1]) {
                        e->own[k + 1] = (int8_t)o;
                        first &= o > i;
                    }
            }
            /* 3-D: (x - p0).((p1-p0)x(p2-p0)) > 0: order p0 p1 p2 x is positive: x p0 p1 p2 is negative */
            if (dim == 3) {
                int32_t t = e->node[2]; e->node[2] = e->node[3]; e->node[3] = t;
                int8_t o = e->own[2]; e->own[2] = e->own[3]; e->own[3] = o;
            }
            e->form = stars->form ? stars->form[f0 + f] : 0;
            w->n_elements += first;
        }
    }
    return 1;
}

static void make_rows(const joint *j, work *w, double least, double band) {
    const int dim = j->run->plan->dim, of_angle = j->run->options->worst == PLANISH_WORST_ANGLE;
    w->n_rows = 0;
    for (int i = 0; i < w->n_elements; i++) {
        const joint_element *e = &w->element[i];
        double x[4][3];
        pl_slope s[PL_MOST_SLOPES + 1];
        gather(j, e, x);
        int n = measures(j, (const double(*)[3])x, 1, s);
        const int rr = of_angle && w->rr_floor > 0 ? n : -1;
        if (rr >= 0) {
            if (dim == 3) pl_ratio_slope_3d((const double(*)[3])x, 1, &s[n]); else pl_ratio_slope_2d((const double(*)[3])x, 1, &s[n]);
            n += s[n].value < w->rr_floor + 0.25;
        }
        for (int k = 0; k < n && w->n_rows < MOST_ROWS; k++) {
            const int raised = k != rr && s[k].value < least + band;
            if (!raised && k != rr && !(of_angle && s[k].value > j->limit_large - band))
                continue;
            pl_maxmin_row *row = &w->row[w->n_rows];
            w->element_of[w->n_rows++] = i;
            row->is_raised = (uint8_t)raised;
            row->value = raised ? s[k].value - least : fmax(0, k == rr ? s[k].value - w->rr_floor * 1.02 : j->limit_large - 0.01 - s[k].value);
            row->n_blocks = 0;
            for (int v = 0; v <= dim; v++) {
                if (e->own[v] < 0)
                    continue;
                const joint_node *node = &w->node[e->own[v]];
                const int b = row->n_blocks++;
                row->first[b] = node->first;
                row->width[b] = (uint8_t)node->n;
                for (int d = 0; d < node->n; d++) {
                    double sum = 0;
                    for (int q = 0; q < dim; q++)
                        sum += s[k].by[v][q] * node->basis[d][q];
                    row->slope[b][d] = (raised || k == rr ? 1 : -1) * sum * node->scale;
                }
            }
        }
    }
}

static void put(const joint *j, const work *w, const double *x, double start[][3]) {
    const planish_plan *plan = j->run->plan;
    const pl_star_problem *problem = &j->run->problem;
    for (int i = 0; i < w->n_nodes; i++) {
        const joint_node *node = &w->node[i];
        double at[3];
        for (int d = 0; d < plan->dim; d++) {
            at[d] = start[i][d];
            for (int k = 0; x && k < node->n; k++)
                at[d] += x[node->first + k] * node->basis[k][d] * node->scale / j->run->measure_scale;
            if (x)
                at[d] = pl_store(&problem->storage, at[d]);
        }
        memcpy(plan->scratch.coordinates + (int64_t)node->node * plan->dim, at, (size_t)plan->dim * sizeof *at);
    }
}

static void take(const joint *j, const work *w, double start[][3]) {
    const planish_plan *plan = j->run->plan;
    for (int i = 0; i < w->n_nodes; i++)
        memcpy(start[i], plan->scratch.coordinates + (int64_t)w->node[i].node * plan->dim, (size_t)plan->dim * sizeof **start);
}

static void solve(joint *j, seed *s, work *w) {
    double start[MOST_NODES][3];
    const int of_angle = j->run->options->worst == PLANISH_WORST_ANGLE;
    const double band = of_angle ? 0.35 : 0.3;
    s->gained = 0;
    s->rise = 0;
    if (!make_patch(j, s, w)) {
        s->state = 2;
        return;
    }
    j->solves++;
    w->rr_floor = env("NORR", 0) ? 0 : fmin(j->most_rr, least_ratio_of(j, w));
    take(j, w, s->start);
    double least = least_of(j, w, -1), reach = env("REACH", 0.1), radius = env("RADIUS", 0.2), rr_floor = w->rr_floor;
    const double sum = sum_of(j, w);
    s->before = least;
    const double wanted = j->limit * (1 + env("OVER", 0.02));
    pl_maxmin p = {.n = w->n_variables, .row = w->row, .room = w->room, .x = w->x, .active = w->active, .multiplier = w->multiplier};
    for (int step = 0; step < STEPS && least < j->limit; step++) {
        int taken = 0;
        make_rows(j, w, least, band);
        take(j, w, start);
        p.m = w->n_rows;
        p.target = wanted - least;
        p.spread = env("SPREAD", 0.3);
        if (p.target > p.spread) p.target = p.spread;
        for (int t = 0; t < TRIES && !taken; t++) {
            double most = 0;
            for (int q = 0; q < 8; q++) {
                p.reach = reach;
                pl_maxmin_solve(&p);
                j->qps++;
                most = 0;
                for (int i = 0; i < w->n_nodes; i++) {
                    double l = 0;
                    for (int k = 0; k < w->node[i].n; k++)
                        l += w->x[w->node[i].first + k] * w->x[w->node[i].first + k];
                    most = fmax(most, sqrt(l));
                }
                if (most > radius)
                    reach *= fmax(0.05, 0.8 * radius / most);
                else if (most < 0.5 * radius && p.t < 0.9 * p.target && reach < 1e6)
                    reach *= fmin(10, 0.8 * radius / (most + 1e-300));
                else
                    break;
            }
            if (!(p.t > 1e-5)) {
                if (getenv("TRACE2")) { fprintf(stderr, "      no gain: t %g active %d rows %d vars %d reach %g most %g:", p.t, p.n_active, p.m, p.n, reach, most); for (int a = 0; a < p.n_active; a++) fprintf(stderr, " %d(%g,%d) %g", w->element_of[p.active[a]], w->row[p.active[a]].value*57, w->row[p.active[a]].is_raised, p.multiplier[a]); fprintf(stderr, "\n"); }
                break;
            }
            if (most > radius * 1.5)
                for (int i = 0; i < p.n; i++) w->x[i] *= radius / most;
            put(j, w, w->x, start);
            const double now = least_of(j, w, least + 0.1 * p.t);
            j->evaluations++;
            if (getenv("TRACE2")) fprintf(stderr, "      step %d try %d reach %g radius %g most %g predicted %g got %g active %d rows %d vars %d least %g\n", step, t, reach, radius, most, p.t, now - least, p.n_active, p.m, p.n, least * 57.2958);
            if (now > least + 0.1 * p.t && least_ratio_of(j, w) >= rr_floor) {
                if (now > least + 0.7 * p.t)
                    radius = fmin(0.5, 2 * radius);
                taken = 1;
                j->steps++;
                least = now;
            } else {
                put(j, w, NULL, start);
                radius = 0.3 * fmin(radius, most);
            }
        }
        if (!taken)
            break;
    }
    s->after = least;
    s->gained = least > s->before;
    s->rise = s->gained ? sum_of(j, w) - sum : 0;
    if (least >= j->limit) {
        s->state = 1;
        return;
    }
    /* grow by what blocks */
    make_rows(j, w, least, band);
    p.m = w->n_rows;
    p.target = fmin(wanted - least, p.spread);
    pl_maxmin_solve(&p);
    const int n = s->n;
    for (int a = 0; a < p.n_active; a++) {
        const joint_element *e = &w->element[w->element_of[p.active[a]]];
        for (int v = 0; v <= j->run->plan->dim; v++) {
            int known = e->own[v] >= 0 || j->star_of[e->node[v]] == -1;
            for (int o = n; o < s->n && !known; o++)
                known = s->node[o] == e->node[v];
            if (known || s->n == MOST_NODES)
                continue;
            s->node[s->n++] = e->node[v];
        }
    }
    if (s->n == n && s->after < s->before + 1e-4)
        s->state = 2;
}

static void solve_chunk(void *context, int64_t begin, int64_t end, int thread) {
    joint *j = context;
    for (int64_t i = begin; i < end; i++)
        solve(j, &j->seeds[j->chosen[i]], &j->work[thread]);
}

static int by_value(const void *a, const void *b) {
    const seed *x = a, *y = b;
    return x->value < y->value ? -1 : x->value > y->value ? 1 : x->element < y->element ? -1 : 1;
}

static void element_of_plan(const joint *j, int64_t element, joint_element *e) {
    const planish_plan *plan = j->run->plan;
    const int dim = plan->dim;
    for (int v = 0; v <= dim; v++) {
        e->node[v] = pl_plan_inner(plan, element, v);
        e->own[v] = -1;
    }
    if (plan->work.sign && plan->work.sign[element] < 0) {
        int32_t t = e->node[0]; e->node[0] = e->node[1]; e->node[1] = t;
    }
}

static double value_of(const joint *j, const joint_element *e) {
    double x[4][3], least = INFINITY;
    pl_slope s[PL_MOST_SLOPES];
    gather(j, e, x);
    const int n = measures(j, (const double(*)[3])x, 0, s);
    for (int k = 0; k < n; k++)
        least = fmin(least, s[k].value);
    return least;
}

/** Choose independent patches, worst first. */
static void choose(joint *j) {
    const planish_plan *plan = j->run->plan;
    j->n_chosen = 0;
    j->round++;
    for (int i = 0; i < j->n_seeds; i++) {
        seed *s = &j->seeds[i];
        if (s->state)
            continue;
        joint_element e;
        element_of_plan(j, s->element, &e);
        s->value = value_of(j, &e);
        if (s->value >= j->limit) {
            s->state = 1;
            continue;
        }
        int free = 1;
        for (int k = 0; k < s->n && free; k++) {
            const pl_visits *visits;
            const int star = star_at(j, s->node[k], &visits);
            free = j->touched[s->node[k]] != j->round;
            for (int64_t r = visits->stars.ring_offset[star]; free && r < visits->stars.ring_offset[star + 1]; r++)
                free = j->stamp[visits->stars.ring[r]] != j->round;
        }
        if (!free)
            continue;
        for (int k = 0; k < s->n; k++) {
            const pl_visits *visits;
            const int star = star_at(j, s->node[k], &visits);
            j->touched[s->node[k]] = j->stamp[s->node[k]] = j->round;
            for (int64_t r = visits->stars.ring_offset[star]; r < visits->stars.ring_offset[star + 1]; r++)
                j->touched[visits->stars.ring[r]] = j->round;
        }
        j->chosen[j->n_chosen++] = i;
    }
    (void)plan;
}

int pl_joint_run(pl_run *r, uint8_t *state, double most, int64_t (*find)(void *, double), void *user) {
    const planish_plan *plan = r->plan;
    const int dim = plan->dim, of_angle = r->options->worst == PLANISH_WORST_ANGLE;
    const int64_t n_nodes = plan->work.n_nodes + plan->n_images;
    joint j = {.run = r};
    if (getenv("NOJOINT")) return 0;
    j.star_of = pl_alloc(n_nodes, sizeof *j.star_of);
    j.stamp = pl_alloc_zero(n_nodes, sizeof *j.stamp);
    j.touched = pl_alloc_zero(n_nodes, sizeof *j.touched);
    j.work = pl_alloc(plan->threads, sizeof *j.work);
    for (int64_t i = 0; i < n_nodes; i++)
        j.star_of[i] = -1;
    for (int64_t s = 0; s < plan->interior.stars.n_stars; s++)
        j.star_of[plan->interior.centre[s]] = (int32_t)s;
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++)
        if (plan->slide[s].kind != PLANISH_CONSTRAINT_ON_SURFACE)
            j.star_of[plan->sliding.centre[s]] = (int32_t)(-2 - s);
    r->phase = PLANISH_PHASE_WORST;
    /* largest angle */
    j.limit_large = 0;
    if (of_angle)
        for (int64_t i = 0; i < plan->work.n_elements; i++) {
            if (!pl_any_moves(plan->work.mobility, plan->work.elements + i * (dim + 1), dim + 1)) continue;
            joint_element e;
            double x[4][3];
            pl_slope s[PL_MOST_SLOPES];
            element_of_plan(&j, i, &e);
            gather(&j, &e, x);
            int n = measures(&j, (const double(*)[3])x, 0, s);
            for (int k = 0; k < n; k++) j.limit_large = fmax(j.limit_large, s[k].value);
            for (int v = 0; v <= dim; v++) for (int d = 0; d < dim; d++) x[v][d] = r->given[(int64_t)plan->work.elements[i * (dim + 1) + v] * dim + d] * r->measure_scale;
            if (plan->work.sign && plan->work.sign[i] < 0) for (int d = 0; d < dim; d++) { double t = x[0][d]; x[0][d] = x[1][d]; x[1][d] = t; }
            n = measures(&j, (const double(*)[3])x, 0, s);
            for (int k = 0; k < n; k++) j.limit_large = fmax(j.limit_large, s[k].value);
        }
    j.most_rr = 1 / sqrt(r->sums.radius_max);
    const double D = of_angle ? 57.29577951308232 : 1;
    fprintf(stderr, "joint: largest %g least 1/RR %g\n", j.limit_large * D, j.most_rr);
    const int trace = getenv("TRACE") != NULL;
    for (int level = 0; level < 200; level++) {
        const pl_star_limits worst = pl_run_worst_limits(r, 1);
        const double reached = sqrt(of_angle ? worst.acuteness : worst.rr2);
        if (!(reached > 1.05)) break;
        const double next = 1 + (reached - 1) * env("FACTOR", 0.9);
        j.limit = of_angle ? pl_angle_between(1, sqrt(next * next - 1)) : 1 / next;
        const int64_t n_bad = find(user, next * next);
        j.seeds = pl_alloc(n_bad + 1, sizeof *j.seeds);
        j.chosen = pl_alloc(n_bad, sizeof *j.chosen);
        j.n_seeds = 0;
        for (int64_t i = 0; i < plan->work.n_elements; i++) {
            if (state[i] != PL_WORSE)
                continue;
            seed *s = &j.seeds[j.n_seeds];
            joint_element e;
            element_of_plan(&j, i, &e);
            *s = (seed){.element = i, .value = value_of(&j, &e)};
            for (int v = 0; v <= dim; v++)
                if (j.star_of[e.node[v]] != -1)
                    s->node[s->n++] = e.node[v];
            j.n_seeds += s->n > 0;
        }
        int rounds = 0;
        double sum_rise = 0;
        for (; rounds < 100; rounds++) {
            qsort(j.seeds, (size_t)j.n_seeds, sizeof *j.seeds, by_value);
            choose(&j);
            if (j.n_chosen == 0)
                break;
            pl_parallel_for(plan->threads, j.n_chosen, 1, solve_chunk, &j);
            for (int i = 0; i < j.n_chosen; i++)
                sum_rise += j.seeds[j.chosen[i]].rise;
            if (trace)
                for (int i = 0; i < j.n_chosen && i < 20; i++) {
                    seed *s = &j.seeds[j.chosen[i]];
                    fprintf(stderr, "   seed %ld: %g -> %g, nodes %d state %d\n", (long)s->element, s->before * D, s->after * D, s->n, s->state);
                }
            if (pl_run_ask_all(r, 0, 0))
                break;
        }
        const double F = pl_run_objective(r);
        pl_run_measure(r);
        int pinned = 0;
        double lowest = INFINITY;
        for (int i = 0; i < j.n_seeds; i++) { pinned += j.seeds[i].state == 2; if (j.seeds[i].state == 2) lowest = fmin(lowest, j.seeds[i].after); }
        const pl_star_limits now = pl_run_worst_limits(r, 1);
        const double got = of_angle ? D * pl_angle_between(1, sqrt(now.acuteness - 1)) : sqrt(now.rr2);
        fprintf(stderr, "level %d: wanted %g, seeds %d, rounds %d, pinned %d (%g), now %g, F %g -> %g (%g), solves %d steps %d qps %d, rise %g\n", level, j.limit * D, j.n_seeds, rounds,
                pinned, lowest * D, got, F, pl_run_objective(r), most, j.solves, j.steps, j.qps, sum_rise);
        pl_free(j.seeds);
        pl_free(j.chosen);
        r->result->worst_sweeps++;
        if (pinned || got != got || now.acuteness >= worst.acuteness)
            break;
    }
    pl_free(j.star_of); pl_free(j.stamp); pl_free(j.touched); pl_free(j.work);
    return 0;
}
