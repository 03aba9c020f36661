/* lattice_solve: conjugate gradients over the vertices of a lattice, with a V-cycle each. */
#include "improve/lattice_places.h"

#include <string.h>

/** Set residual to b - K x of vertex v of a slab, without its own block unless with_own; b NULL: 0. */
PL_INLINE void residual_at(const pl_grid *g, const double *b, const double *x, int64_t slab,
                           int64_t v, int with_own, double *residual, int dim) {
    const int blocks = 1 << dim;
    const int64_t begin = (slab - 1) * g->per_slab, end = (slab + 2) * g->per_slab;
    for (int d = 0; d < dim; d++)
        residual[d] = b ? b[v * dim + d] : 0;
    for (int bits = with_own ? 0 : 1; bits < blocks; bits++) {
        const int64_t way = pl_offset_of(g, bits), after = v + way, before = v - way;
        /* Blocks to vertices outside of the grid are 0. What they are taken for is in a slab next to
         * this one, or it is not read: other threads write there. */
        if (after < g->n_vertices && after < end) {
            const double *k = g->stiffness + (v * blocks + bits) * (dim * dim);
            for (int r = 0; r < dim; r++)
                for (int c = 0; c < dim; c++)
                    residual[r] -= k[r * dim + c] * x[after * dim + c];
        }
        if (bits > 0 && before >= 0 && before >= begin) {
            const double *k = g->stiffness + (before * blocks + bits) * (dim * dim);
            for (int r = 0; r < dim; r++)
                for (int c = 0; c < dim; c++)
                    residual[r] -= k[c * dim + r] * x[before * dim + c];
        }
    }
}

PL_INLINE void relax_slab_in(const pl_slab_pass *p, int64_t slab, int dim) {
    const pl_grid *g = p->g;
    const int64_t stride = g->per_slab;
    for (int64_t i = 0; i < stride; i++) {
        const int64_t v = slab * stride + (p->is_backward ? stride - 1 - i : i);
        double residual[3];
        if (!g->is_active[v])
            continue;
        residual_at(g, g->load, g->move, slab, v, 0, residual, dim);
        for (int r = 0; r < dim; r++) {
            double sum = 0;
            for (int c = 0; c < dim; c++)
                sum += g->inverse[(v * dim + r) * dim + c] * residual[c];
            g->move[v * dim + r] = sum;
        }
    }
}

static void relax_slab(const pl_slab_pass *p, int64_t slab) {
    if (p->l->plan->dim == 3)
        relax_slab_in(p, slab, 3);
    else
        relax_slab_in(p, slab, 2);
}

PL_INLINE void residual_slab_in(const pl_slab_pass *p, int64_t slab, int dim) {
    const int64_t stride = p->g->per_slab;
    for (int64_t v = slab * stride; v < (slab + 1) * stride; v++)
        residual_at(p->g, p->b, p->x, slab, v, 1, p->y + v * dim, dim);
}

/** Set y to b - K x. */
static void residual_slab(const pl_slab_pass *p, int64_t slab) {
    if (p->l->plan->dim == 3)
        residual_slab_in(p, slab, 3);
    else
        residual_slab_in(p, slab, 2);
}

PL_INLINE void restrict_slab_in(const pl_slab_pass *p, int64_t slab, int dim) {
    const pl_grid *g = p->g, *fine = g - 1;
    const int corners = 1 << dim; /* of a cube */
    const int64_t stride = g->per_slab;
    for (int64_t v = slab * stride; v < (slab + 1) * stride; v++) {
        int64_t twice[3];
        pl_find_coordinates(g, v, twice);
        for (int d = 0; d < dim; d++)
            twice[d] *= 2;
        for (int k = 0; k < 2 * corners - 1; k++) {
            const int bits = k < corners ? k : k - corners + 1;
            const pl_vertex_at i = pl_vertex_by(fine, twice, bits, k < corners ? 1 : -1);
            for (int d = 0; i.number >= 0 && d < dim; d++)
                p->y[v * dim + d] += (bits ? 0.5 : 1) * p->x[i.number * dim + d];
        }
    }
}

/** Add x of the finer grid to y of this one. */
static void restrict_slab(const pl_slab_pass *p, int64_t slab) {
    if (p->l->plan->dim == 3)
        restrict_slab_in(p, slab, 3);
    else
        restrict_slab_in(p, slab, 2);
}

PL_INLINE void prolong_slab_in(const pl_slab_pass *p, int64_t slab, int dim) {
    const pl_grid *g = p->g, *coarse = g + 1;
    const int64_t stride = g->per_slab;
    for (int64_t v = slab * stride; v < (slab + 1) * stride; v++) {
        int64_t at[3], from = 0;
        int parity = 0;
        pl_find_coordinates(g, v, at);
        for (int d = 0; d < dim; d++) {
            from += at[d] / 2 * pl_stride_of(coarse, d);
            parity |= (int)(at[d] & 1) << d;
        }
        const int64_t to = from + pl_offset_of(coarse, parity);
        for (int d = 0; d < dim; d++)
            p->y[v * dim + d] += 0.5 * (p->x[from * dim + d] + p->x[to * dim + d]);
    }
}

/** Add x of the coarser grid to y of this one. */
static void prolong_slab(const pl_slab_pass *p, int64_t slab) {
    if (p->l->plan->dim == 3)
        prolong_slab_in(p, slab, 3);
    else
        prolong_slab_in(p, slab, 2);
}

typedef void slab_body(const pl_slab_pass *pass, int64_t slab);

static void relax(pl_lattice *l, int level, int is_backward) {
    pl_slab_pass pass = {
        .l = l, .g = &l->grid[level], .body = relax_slab, .is_backward = is_backward};
    pl_visit_slabs(&pass, l->grid[level].n_slabs);
}

/** Call body on the vertices of a grid. */
static void visit_vertices(pl_lattice *l, int level, slab_body *body, const double *b,
                           const double *x, double *y) {
    pl_slab_pass pass = {.l = l, .g = &l->grid[level], .body = body, .b = b, .x = x, .y = y};
    pl_visit_slabs(&pass, l->grid[level].n_slabs);
}

static size_t bytes_of(const pl_lattice *l, int level) {
    return (size_t)(l->grid[level].n_vertices * l->plan->dim) * sizeof(double);
}

/** Set move to about the solution for force: one V-cycle. */
static void cycle(pl_lattice *l) {
    enum { SMOOTHINGS = 1, OF_COARSEST = 8 };
    const int last = l->n_levels - 1;
    for (int i = 0; i <= last; i++) {
        pl_grid *g = &l->grid[i];
        memset(g->move, 0, bytes_of(l, i));
        memcpy(g->load, g->force, bytes_of(l, i));
        if (i > 0)
            visit_vertices(l, i, restrict_slab, NULL, g[-1].residual, g->load);
        for (int k = 0; k < (i == last ? OF_COARSEST : SMOOTHINGS); k++)
            relax(l, i, 0);
        if (i < last)
            visit_vertices(l, i, residual_slab, g->load, g->move, g->residual);
    }
    for (int i = last; i >= 0; i--) {
        pl_grid *g = &l->grid[i];
        if (i < last)
            visit_vertices(l, i, prolong_slab, NULL, g[1].move, g->move);
        for (int k = 0; k < (i == last ? OF_COARSEST : SMOOTHINGS); k++)
            relax(l, i, 1);
    }
}

static void dot_slab(const pl_slab_pass *p, int64_t slab) {
    const int64_t stride = p->g->per_slab * p->l->plan->dim;
    double sum = 0;
    for (int64_t i = slab * stride; i < (slab + 1) * stride; i++)
        sum += p->b[i] * p->x[i];
    p->y[slab] = sum;
}

/** Set y to x + factor y. */
static void step_slab(const pl_slab_pass *p, int64_t slab) {
    const int64_t stride = p->g->per_slab * p->l->plan->dim;
    for (int64_t i = slab * stride; i < (slab + 1) * stride; i++)
        p->y[i] = p->x[i] + p->factor * p->y[i];
}

/** Set y to y + factor x. */
static void add_slab(const pl_slab_pass *p, int64_t slab) {
    const int64_t stride = p->g->per_slab * p->l->plan->dim;
    for (int64_t i = slab * stride; i < (slab + 1) * stride; i++)
        p->y[i] += p->factor * p->x[i];
}

/** Return b . x over a grid. */
static double dot_of(pl_lattice *l, int level, const double *b, const double *x) {
    double sum = 0;
    visit_vertices(l, level, dot_slab, b, x, l->of_slab);
    for (int64_t i = 0; i < l->grid[level].n_slabs; i++)
        sum += l->of_slab[i];
    return sum;
}

static void combine(pl_lattice *l, int level, slab_body *body, double factor, const double *x,
                    double *y) {
    pl_slab_pass pass = {
        .l = l, .g = &l->grid[level], .body = body, .x = x, .y = y, .factor = factor};
    pl_visit_slabs(&pass, l->grid[level].n_slabs);
}

/** Set change to minus the stiffness of what belongs to each grid, times direction. */
static void apply(pl_lattice *l) {
    for (int i = 0; i < l->n_levels; i++) {
        pl_grid *g = &l->grid[i], *fine = g - 1;
        if (i > 0 && !g->has_own)
            continue;
        visit_vertices(l, i, residual_slab, NULL, g->direction, g->change);
        if (i == 0)
            continue;
        /* Without what finer grids have. */
        memset(fine->residual, 0, bytes_of(l, i - 1));
        visit_vertices(l, i - 1, prolong_slab, NULL, g->direction, fine->residual);
        visit_vertices(l, i - 1, residual_slab, NULL, fine->residual, fine->load);
        combine(l, i - 1, step_slab, -2, fine->load, fine->load);
        visit_vertices(l, i, restrict_slab, NULL, fine->load, g->change);
    }
}

int pl_lattice_solve(pl_lattice *l, double part, int n, pl_lattice_ask_fn *ask, void *context) {
    double before = 0, goal = 0;
    int k = 0, stopped = 0;
    for (int i = 0; i < l->n_levels; i++) {
        memset(l->grid[i].total, 0, bytes_of(l, i));
        memset(l->grid[i].direction, 0, bytes_of(l, i));
    }
    for (;; k++) {
        double product = 0, curvature = 0;
        cycle(l);
        for (int i = 0; i < l->n_levels; i++)
            if (i == 0 || l->grid[i].has_own)
                product += dot_of(l, i, l->grid[i].force, l->grid[i].move);
        if (k == 0)
            goal = part * part * product;
        stopped = ask(context);
        if (!(product > goal) || k == n || stopped)
            break;
        for (int i = 0; i < l->n_levels; i++)
            combine(l, i, step_slab, k > 0 ? product / before : 0, l->grid[i].move,
                    l->grid[i].direction);
        apply(l);
        for (int i = 0; i < l->n_levels; i++)
            if (i == 0 || l->grid[i].has_own)
                curvature -= dot_of(l, i, l->grid[i].change, l->grid[i].direction);
        if (!(curvature > 0))
            break;
        before = product;
        for (int i = 0; i < l->n_levels; i++) {
            combine(l, i, add_slab, product / curvature, l->grid[i].direction, l->grid[i].total);
            if (i == 0 || l->grid[i].has_own)
                combine(l, i, add_slab, product / curvature, l->grid[i].change, l->grid[i].force);
        }
    }
    if (k == 0) /* of negative curvature: an approximate direction is better than none */
        for (int i = 0; i < l->n_levels; i++)
            memcpy(l->grid[i].total, l->grid[i].move, bytes_of(l, i));
    return stopped;
}
