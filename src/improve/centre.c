/* centre: the nodes of a patch to where each is at the mean of its neighbours, by conjugate
 * gradients. */
#include "improve/patch.h"

#include "base/parts.h"

#include <math.h>
#include <string.h>

/* Conjugate gradients end when the residual has fallen to this fraction, or after so many steps. */
#define CENTRED 1e-4
enum { CENTRE_STEPS = 1000 };

/* Exponents of the scale stay within this, so that it and its inverse are doubles. */
enum { SCALE_LIMIT = 1000 };

pl_box pl_box_of_fixed(const planish_plan *plan) {
    const int dim = plan->dim;
    pl_box b;
    double width = 0;
    int exponent;
    for (int d = 0; d < dim; d++) {
        b.lower[d] = INFINITY;
        b.upper[d] = -INFINITY;
    }
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        for (int d = 0; d < dim && plan->is_used[i] && plan->work.mobility[i] != PL_INTERIOR; d++) {
            const double x = plan->coordinates[(int64_t)plan->inner[i] * dim + d];
            b.lower[d] = fmin(b.lower[d], x);
            b.upper[d] = fmax(b.upper[d], x);
        }
    pl_parts_smallest(b.lower, dim);
    pl_parts_largest(b.upper, dim);
    for (int d = 0; d < dim; d++)
        width = fmax(width, 0.5 * b.upper[d] - 0.5 * b.lower[d]);
    frexp(width, &exponent);
    exponent = exponent > SCALE_LIMIT ? SCALE_LIMIT : exponent;
    b.scale = ldexp(1, exponent < -SCALE_LIMIT ? SCALE_LIMIT : -exponent);
    return b;
}

/** An operation on vectors under way. */
typedef struct operation {
    const pl_patch *p;
    double *a;
    const double *b;
    const pl_box *within;
} operation;

/** a = sum over the neighbours of (b of the node - b of the neighbour), b an array over nodes. */
static void difference_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const pl_stars *stars = &o->p->run->plan->interior.stars;
    const int dim = o->p->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t star = o->p->star[i];
        const double *mine = o->b + pl_patch_node(o->p, i) * dim;
        double sum[3] = {0, 0, 0};
        for (int64_t k = stars->ring_offset[star]; k < stars->ring_offset[star + 1]; k++)
            for (int d = 0; d < dim; d++)
                sum[d] += mine[d] - o->b[(int64_t)stars->ring[k] * dim + d];
        memcpy(o->a + i * dim, sum, (size_t)dim * sizeof *o->a);
    }
}

static void difference(const pl_patch *p, double *a, const double *field) {
    operation o = {p, a, field, NULL};
    pl_patch_for(p, difference_chunk, &o);
}

/** a = b / number of neighbours. */
static void share_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    const int64_t *offset = o->p->run->plan->interior.stars.ring_offset;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < o->p->dim; d++)
            o->a[i * o->p->dim + d] = o->b[i * o->p->dim + d] /
                                      (double)(offset[o->p->star[i] + 1] - offset[o->p->star[i]]);
}

static void share(const pl_patch *p, double *a, const double *b) {
    operation o = {p, a, b, NULL};
    pl_patch_for(p, share_chunk, &o);
}

/** a = b, but within the box of the fixed nodes: from far away the way back would be lost in
 * rounding.
 */
static void clamp_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const operation *o = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < o->p->dim; d++) {
            const int64_t k = i * o->p->dim + d;
            o->a[k] = fmin(fmax(o->b[k], o->within->lower[d]), o->within->upper[d]);
        }
}

static void clamp(const pl_patch *p, const pl_box *within, double *a, const double *b) {
    operation o = {p, a, b, within};
    pl_patch_for(p, clamp_chunk, &o);
}

/** Solve sum over the neighbours of (x_i - x_j) = 0, preconditioned by the diagonal. All but start
 * is in the scale of the domain. */
void pl_patch_centre(const pl_patch *p, pl_sweep_tally *tally) {
    pl_run *r = p->run;
    const pl_box fixed = pl_box_of_fixed(r->plan);
    double *x = pl_patch_vector(p, 0), *residual = pl_patch_vector(p, 1),
           *z = pl_patch_vector(p, 2), *way = pl_patch_vector(p, 3);
    double *image = pl_patch_vector(p, 4), *start = pl_patch_vector(p, 5);
    pl_patch_take(p, start, r->plan->coordinates);
    clamp(p, &fixed, x, start);
    pl_patch_put(p, r->plan->coordinates, x);
    difference(p, residual, r->plan->coordinates);
    pl_patch_scale(p, x, fixed.scale, x);
    pl_patch_scale(p, residual, -fixed.scale, residual);
    share(p, z, residual);
    pl_patch_combine(p, way, z, 0, z);
    double square = pl_patch_product(p, residual, z), goal = CENTRED * CENTRED * square;
    for (int i = 0; i < CENTRE_STEPS && square > goal && !tally->stopped; i++) {
        pl_patch_put(p, p->field, way);
        difference(p, image, p->field);
        const double step = square / pl_patch_product(p, way, image), last = square;
        if (!(step > 0) || !(step < INFINITY))
            break;
        pl_patch_combine(p, x, x, step, way);
        pl_patch_combine(p, residual, residual, -step, image);
        share(p, z, residual);
        square = pl_patch_product(p, residual, z);
        pl_patch_combine(p, way, z, square / last, way);
        tally->visits += p->n_all;
        tally->stopped = pl_run_ask_all(r, pl_plan_colours(r->plan), p->n);
    }
    pl_patch_scale(p, x, 1 / fixed.scale, x);
    pl_patch_admit(p, x, start);
}
