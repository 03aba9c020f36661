/* lattice_stiffness: the Hessian of the sum of RR^2, with corners that of AR^2, by the vertices of a
 * lattice; forces and moves of nodes. Layers of cells or vertices with one between them share nothing
 * that is written. */
#include "improve/bend_mean.h"
#include "improve/lattice_places.h"
#include "improve/lattice_stiffness.h"

#include "star/kernel_direction.h"

#include <string.h>

/* ---- stiffness ------------------------------------------------------------------------------- */

/* Largest norm of an element's Hessian by vertices, in units; that of a regular element whose edges
 * are 0.4 long is 10. Stiffer elements are as good as rigid, and count as if they had this one. */
#define STIFFEST 0x1p20

enum { NODE_BLOCKS = 10 }; /* of an element's nodes (i, j), i <= j: at most */

/* A displacement that leaves the plane or line of a node counts with this part of the norm of the node's
 * block. Where most nodes slide little else tells such displacements, and blocks of vertices would be
 * nearly singular. */
#define ASIDE 0.25

/** Four elements of a simplex: their nodes, and the weights of its vertices at these; 0 at nodes that
 *  are held. form: of elements that are corners. */
typedef struct four {
    bend_pack x[PL_CORNERS][3], weight[PL_CORNERS][PL_CORNERS];
    int n_sliding; /* elements with a node that slides; if there are any: */
    bend_pack projection[PL_CORNERS][PL_LATTICE_BLOCK]; /* on planes and lines: P, by rows; */
    bend_mask slides;                                   /* which of the four */
    double share; /* of these, which stand for none but themselves */
    bend_form form;
} four;

/** Set the projection of a node. */
PL_INLINE void find_projection(const pl_lattice *l, int32_t inner, double *projection, int dim) {
    const int freedom = l->freedom[inner];
    const double *direction = l->direction + (int64_t)inner * dim;
    for (int r = 0; r < dim; r++)
        for (int c = 0; c < dim; c++) {
            const double part = direction[r] * direction[c], all = r == c; /* free: all */
            projection[r * dim + c] = freedom == PL_LATTICE_ON_LINE    ? part
                                      : freedom == PL_LATTICE_ON_PLANE ? all - part
                                                                       : all;
        }
}

/** Gather the projections of four elements, the first n of corner. */
PL_INLINE void gather_projections(const pl_lattice *l, const int32_t *corner, int64_t n, four *f,
                                  int dim) {
    f->share = 1.0 / l->one_in;
    for (int lane = 0; lane < 4; lane++) {
        int freedom = 0;
        for (int j = 0; j <= dim; j++) {
            const int32_t inner = corner[(lane < n ? lane : 0) * (dim + 1) + j];
            double projection[PL_LATTICE_BLOCK];
            freedom |= l->freedom[inner];
            find_projection(l, inner, projection, dim);
            for (int c = 0; c < dim * dim; c++)
                f->projection[j][c][lane] = projection[c];
        }
        f->slides[lane] = freedom > PL_LATTICE_FREE ? -1 : 0;
    }
}

PL_INLINE void gather_four(const pl_lattice *l, const pl_simplex *s, const int32_t *corner,
                           int64_t n, four *f, int dim) {
    f->n_sliding = 0;
    for (int lane = 0; lane < 4; lane++) {
        int freedom = 0;
        for (int j = 0; j <= dim; j++) {
            const int32_t inner = corner[(lane < n ? lane : 0) * (dim + 1) + j];
            double x[3], weight[PL_CORNERS] = {0};
            pl_unit_place(l, inner, x, dim);
            if (l->freedom[inner] != PL_LATTICE_HELD && lane < n)
                pl_weights_at(s, x, weight, dim);
            freedom |= l->freedom[inner];
            for (int d = 0; d < dim; d++)
                f->x[j][d][lane] = x[d];
            for (int a = 0; a <= dim; a++)
                f->weight[j][a][lane] = weight[a];
        }
        f->n_sliding += freedom > PL_LATTICE_FREE;
    }
    if (f->n_sliding > 0)
        gather_projections(l, corner, n, f, dim);
}

/** Gather the forms of four corners, the first n elements of a simplex. */
PL_INLINE void gather_forms(const planish_plan *plan, const int32_t *element, int64_t n, four *f,
                            int dim) {
    for (int lane = 0; lane < 4; lane++) {
        const uint8_t corner = plan->work.corner[element[lane < n ? lane : 0]];
        const pl_corner_form *form = &plan->form[pl_form_code(corner, 0, 0)];
        double weight[6], factor = form->factor;
        memcpy(weight, form->weight, sizeof weight);
        if (plan->work.target) {
            pl_target_weights(dim, &plan->work.target[element[lane < n ? lane : 0]], weight);
            factor = 1.0 / (dim * dim);
        }
        for (int k = 0; k < dim * (dim + 1) / 2; k++)
            f->form.weight[k][lane] = weight[k];
        f->form.factor[lane] = factor * form->share;
    }
}

/** Sums over elements of a simplex: blocks of its vertices a <= b, in this order. */
typedef struct simplex_sums {
    bend_pack block[10][PL_LATTICE_BLOCK];
} simplex_sums;

/** Number of block (i, j), i <= j, of n x n. */
PL_INLINE int block_of(int i, int j, int n) {
    return i * n - i * (i - 1) / 2 + j - i;
}

/** Entry c of block (i, j) of n x n, of which those with i <= j are kept. */
PL_INLINE bend_pack entry_of(const bend_block *h, int i, int j, int n, int c, int dim) {
    return i <= j ? h[block_of(i, j, n)][c] : h[block_of(j, i, n)][c % dim * dim + c / dim];
}

/** Limit Hessians h of n x n blocks, by edges or nodes whose weights are given: no entry by vertices is
 *  above most, and none is NaN or infinite. */
PL_INLINE void limit_stiffness(bend_pack most, const bend_pack weight[][PL_CORNERS], int n,
                               bend_block *h, int dim) {
    bend_pack of_blocks = bend_of(0), of_weights = bend_of(0);
    for (int i = 0, at = 0; i < n; i++)
        for (int j = i; j < n; j++, at++)
            for (int c = 0; c < dim * dim; c++) /* twice as much where i < j */
                of_blocks += (i == j ? 1.0 : 2.0) * h[at][c] * h[at][c];
    for (int i = 0; i < n; i++)
        for (int a = 0; a <= dim; a++)
            of_weights += weight[i][a] * weight[i][a];
    const bend_pack norm = bend_sqrt(of_blocks) * of_weights, shrink = most / norm;
    const bend_mask is_finite = norm <= 0x1p1000;
    const bend_pack factor = bend_choose(norm > most, shrink, bend_of(1));
    for (int q = 0; q < n * (n + 1) / 2; q++)
        for (int c = 0; c < dim * dim; c++)
            h[q][c] = bend_choose(is_finite, h[q][c] * factor, bend_of(0));
}

/** Set the Hessians of four elements, or corners, by their edges; in the plane their positive part. */
PL_INLINE void find_bends(const four *f, const bend_vector e[3], bend_block h[BEND_BLOCKS],
                          int are_corners, int dim) {
    if (are_corners)
        bend_corners(e, &f->form, h, dim);
    else if (dim == 3)
        bend_tetrahedra(e, h);
    else
        bend_triangles(e, h);
    if (dim == 2)
        bend_keep_positive(e, h);
}

/** Set product to a b; all are [dim][dim] by rows. */
PL_INLINE void multiply(const bend_pack *a, const bend_pack *b, bend_pack *product, int dim) {
    for (int r = 0; r < dim; r++)
        for (int c = 0; c < dim; c++) {
            bend_pack sum = a[r * dim] * b[c];
            for (int k = 1; k < dim; k++)
                sum += a[r * dim + k] * b[k * dim + c];
            product[r * dim + c] = sum;
        }
}

/** Set block to P H Q, for projections P and Q. */
PL_INLINE void project_block(const bend_pack *p, const bend_pack *q, bend_pack *block, int dim) {
    bend_block half;
    multiply(p, block, half, dim);
    multiply(half, q, block, dim);
}

/** Add to a node's block what tells displacements aside: part of norm (I - P). */
PL_INLINE void add_aside(const bend_pack *p, bend_pack norm2, bend_pack *block, int dim) {
    const bend_pack size = bend_sqrt(norm2) * ASIDE;
    for (int r = 0; r < dim; r++)
        for (int c = 0; c < dim; c++)
            block[r * dim + c] += size * ((r == c ? 1.0 : 0.0) - p[r * dim + c]);
}

/** Set the Hessians by nodes, (dim + 1) x (dim + 1) blocks, from those by edges: projected. */
PL_INLINE void find_node_blocks(const four *f, const bend_block h[BEND_BLOCKS],
                                bend_block by_node[NODE_BLOCKS], int dim) {
    for (int c = 0; c < dim * dim; c++) {
        bend_pack all = bend_of(0);
        for (int j = 0; j < dim; j++) {
            bend_pack sum = bend_of(0);
            for (int i = 0; i < dim; i++)
                sum += entry_of(h, i, j, dim, c, dim);
            all += sum;
            by_node[block_of(0, j + 1, dim + 1)][c] = -sum;
            for (int i = 0; i <= j; i++)
                by_node[block_of(i + 1, j + 1, dim + 1)][c] = h[block_of(i, j, dim)][c];
        }
        by_node[0][c] = all;
    }
    for (int i = 0, at = 0; i <= dim; i++)
        for (int j = i; j <= dim; j++, at++) {
            bend_pack norm2 = bend_of(0);
            for (int c = 0; c < dim * dim; c++) {
                by_node[at][c] *= f->share;
                norm2 += by_node[at][c] * by_node[at][c];
            }
            project_block(f->projection[i], f->projection[j], by_node[at], dim);
            if (i == j)
                add_aside(f->projection[i], norm2, by_node[at], dim);
        }
}

/** Add Hessians h of n x n blocks, by edges or nodes whose weights are given, to the sums. */
PL_INLINE void add_blocks(const bend_block *h, const bend_pack weight[][PL_CORNERS], int n,
                          pl_terms terms, simplex_sums *sums, int dim) {
    bend_pack half[PL_CORNERS][PL_CORNERS][PL_LATTICE_BLOCK];
    const bend_pack shift = bend_of(terms.shift);
    for (int i = 0; i < n; i++)
        for (int a = 0; a <= dim; a++)
            for (int c = 0; c < dim * dim; c++) {
                bend_pack sum = bend_of(0);
                for (int j = 0; j < n; j++)
                    sum += weight[j][a] * entry_of(h, i, j, n, c, dim);
                half[i][a][c] = sum;
            }
    for (int a = 0, at = 0; a <= dim; a++)
        for (int b = a; b <= dim; b++, at++)
            for (int c = 0; c < dim * dim; c++) {
                bend_pack sum = weight[0][a] * half[0][b][c];
                for (int i = 1; i < n; i++)
                    sum += weight[i][a] * half[i][b][c];
                sums->block[at][c] += (sum + shift) - shift;
            }
}

/** Add those of four elements that have a node that slides to the sums: by nodes. h: by edges. */
PL_INLINE void add_sliding(const four *f, const bend_block h[BEND_BLOCKS], pl_terms terms,
                           double most, simplex_sums *sums, int dim) {
    bend_block by_node[NODE_BLOCKS];
    bend_pack weight[PL_CORNERS][PL_CORNERS];
    for (int j = 0; j <= dim; j++)
        for (int a = 0; a <= dim; a++)
            weight[j][a] = bend_choose(f->slides, f->weight[j][a], bend_of(0));
    find_node_blocks(f, h, by_node, dim);
    limit_stiffness(bend_of(most), weight, dim + 1, by_node, dim);
    add_blocks(by_node, weight, dim + 1, terms, sums, dim);
}

/** Add four elements to the sums, in terms, none of them above most. Each goes the way that its nodes
 *  ask for, whichever the others are: by edges, of which there are fewer, or by nodes. */
PL_INLINE void add_four(const four *f, pl_terms terms, double most, simplex_sums *sums,
                        int are_corners, int dim) {
    bend_block h[BEND_BLOCKS];
    bend_vector e[3];
    bend_pack by_edge[3][PL_CORNERS];
    for (int k = 0; k < dim; k++) {
        e[k].x = f->x[k + 1][0] - f->x[0][0];
        e[k].y = f->x[k + 1][1] - f->x[0][1];
        e[k].z = dim == 3 ? f->x[k + 1][2] - f->x[0][2] : bend_of(0);
        for (int a = 0; a <= dim; a++)
            by_edge[k][a] = f->weight[k + 1][a] - f->weight[0][a];
    }
    find_bends(f, e, h, are_corners, dim);
    if (f->n_sliding > 0) {
        add_sliding(f, h, terms, most, sums, dim);
        for (int k = 0; k < dim; k++)
            for (int a = 0; a <= dim; a++)
                by_edge[k][a] = bend_choose(f->slides, bend_of(0), by_edge[k][a]);
    }
    if (f->n_sliding < 4) {
        limit_stiffness(bend_of(most), by_edge, dim, h, dim);
        add_blocks(h, by_edge, dim, terms, sums, dim);
    }
}

/** Largest entry that an element may have in the stiffness of a grid. */
static inline double most_of(const pl_grid *g) {
    const double most = fmax(g->per_spacing[0], fmax(g->per_spacing[1], g->per_spacing[2]));
    return STIFFEST * most * most;
}

PL_INLINE void add_simplex(const pl_slab_pass *p, int64_t number, int are_corners, int dim) {
    const pl_lattice *l = p->l;
    const pl_grid *g = p->g;
    const int64_t begin = l->element_begin[number], end = l->element_begin[number + 1];
    if (begin == end)
        return;
    const pl_simplex s = pl_simplex_of(g, number, dim);
    simplex_sums sums;
    four f;
    memset(&sums, 0, sizeof sums);
    for (int64_t i = begin; i < end; i += 4) {
        gather_four(l, &s, l->corner + i * (dim + 1), end - i, &f, dim);
        if (are_corners)
            gather_forms(l->plan, l->element + i, end - i, &f, dim);
        add_four(&f, p->terms, most_of(g), &sums, are_corners, dim);
    }
    for (int a = 0, at = 0; a <= dim; a++)
        for (int b = a; b <= dim; b++, at++) {
            double *to =
                g->stiffness + ((s.vertex[a] << dim) + (s.bits[a] ^ s.bits[b])) * (dim * dim);
            for (int c = 0; c < dim * dim; c++)
                to[c] += l->one_in * ((sums.block[at][c][0] + sums.block[at][c][1]) +
                                      (sums.block[at][c][2] + sums.block[at][c][3]));
        }
}

PL_INLINE void add_slab_in(const pl_slab_pass *p, int64_t slab, int are_corners, int dim) {
    const int64_t stride = p->g->per_slab * pl_simplices_of(dim);
    for (int64_t i = slab * stride; i < (slab + 1) * stride; i++)
        add_simplex(p, p->g->first + i, are_corners, dim);
}

PL_INLINE void add_slab(const pl_slab_pass *p, int64_t slab, int are_corners) {
    if (p->l->plan->dim == 3)
        add_slab_in(p, slab, are_corners, 3);
    else
        add_slab_in(p, slab, are_corners, 2);
}

static void add_slab_of(const pl_slab_pass *p, int64_t slab) {
    add_slab(p, slab, 0);
}

static void add_corners_of(const pl_slab_pass *p, int64_t slab) {
    add_slab(p, slab, 1);
}

#if defined(PL_X86_KERNELS)
__attribute__((target("avx2"))) static void add_slab_wide(const pl_slab_pass *p, int64_t slab) {
    add_slab(p, slab, 0);
}

__attribute__((target("avx2"))) static void add_corners_wide(const pl_slab_pass *p, int64_t slab) {
    add_slab(p, slab, 1);
}
#endif

/** Function that adds the elements of a slab, for the instruction set of the plan. */
static void (*adder_of(const planish_plan *plan))(const pl_slab_pass *, int64_t) {
#if defined(PL_X86_KERNELS)
    if (plan->kernel == pl_star_kernel_select(PLANISH_ISA_AVX2) ||
        plan->kernel == pl_star_kernel_select(PLANISH_ISA_AVX512))
        return plan->work.corner ? add_corners_wide : add_slab_wide;
#endif
    return plan->work.corner ? add_corners_of : add_slab_of;
}

/** Add block K, or its transpose, of fine vertex i, of weight for coarse vertex a, and j. */
PL_INLINE void add_block(const pl_grid *coarse, int64_t vertex, const int64_t a[3],
                         const pl_vertex_at *j, double weight, const double *K, int is_transposed,
                         int dim) {
    int parity = 0;
    for (int d = 0; d < dim; d++)
        parity |= (int)(j->at[d] & 1) << d;
    for (int end = 0; end < (parity ? 2 : 1); end++) {
        int bits = 0, fits = 1;
        for (int d = 0; d < dim; d++) {
            const int64_t way = j->at[d] / 2 + (end ? parity >> d & 1 : 0) - a[d];
            fits &= way == 0 || way == 1;
            bits |= (way == 1) << d;
        }
        if (!fits)
            continue;
        double *to = coarse->stiffness + ((vertex << dim) + bits) * (dim * dim);
        const double w = parity ? 0.5 * weight : weight;
        for (int r = 0; r < dim; r++)
            for (int c = 0; c < dim; c++)
                to[r * dim + c] += w * K[is_transposed ? c * dim + r : r * dim + c];
    }
}

PL_INLINE void coarsen_slab_in(const pl_slab_pass *p, int64_t slab, int dim) {
    const pl_grid *g = p->g, *fine = g - 1;
    const int corners = 1 << dim; /* of a cube */
    const int64_t stride = g->per_slab;
    for (int64_t v = slab * stride; v < (slab + 1) * stride; v++) {
        int64_t a[3], twice[3];
        pl_find_coordinates(g, v, a);
        for (int d = 0; d < 3; d++)
            twice[d] = 2 * a[d];
        for (int k = 0; k < 2 * corners - 1; k++) {
            const int bits = k < corners ? k : k - corners + 1, sign = k < corners ? 1 : -1;
            const pl_vertex_at i = pl_vertex_by(fine, twice, bits, sign);
            if (i.number < 0)
                continue;
            for (int q = 0; q < 2 * corners - 1; q++) {
                const int to = q < corners ? q : q - corners + 1;
                const pl_vertex_at j = pl_vertex_by(fine, i.at, to, q < corners ? 1 : -1);
                if (j.number < 0)
                    continue;
                const int64_t row = q < corners ? i.number : j.number;
                add_block(g, v, a, &j, bits ? 0.5 : 1,
                          fine->stiffness + ((row << dim) + to) * (dim * dim), q >= corners, dim);
            }
        }
    }
}

/** Add the stiffness of the finer grid to that of coarse vertices. */
static void coarsen_slab(const pl_slab_pass *p, int64_t slab) {
    if (p->l->plan->dim == 3)
        coarsen_slab_in(p, slab, 3);
    else
        coarsen_slab_in(p, slab, 2);
}

/** Invert a block [dim][dim]; 0 unless it is positive definite. */
static int invert_block(const double *k, double *inverse, int dim) {
    if (dim == 2) {
        const double determinant = k[0] * k[3] - k[1] * k[1], factor = 1 / determinant;
        const double all[] = {k[3] * factor, -k[1] * factor, -k[1] * factor, k[0] * factor};
        if (!(k[0] > 0 && determinant > 0))
            return 0;
        memcpy(inverse, all, sizeof all);
        return 1;
    }
    const double packed_block[6] = {k[0], k[1], k[2], k[4], k[5], k[8]};
    double six[6];
    if (!invert(packed_block, six))
        return 0;
    const double all[PL_LATTICE_BLOCK] = {six[0], six[1], six[2], six[1], six[3],
                                          six[4], six[2], six[4], six[5]};
    memcpy(inverse, all, sizeof all);
    return 1;
}

/* First shift of a vertex's block that is not positive definite, of its largest entry. */
#define SHIFT 0x1p-6

static void invert_slab(const pl_slab_pass *p, int64_t slab) {
    const pl_grid *g = p->g;
    const int64_t stride = g->per_slab;
    const int dim = p->l->plan->dim, size = dim * dim;
    for (int64_t v = slab * stride; v < (slab + 1) * stride; v++) {
        double *k = g->stiffness + (v << dim) * size;
        double *inverse = g->inverse + v * size;
        double largest = k[0];
        for (int d = 1; d < dim; d++)
            largest = fmax(largest, k[d * (dim + 1)]);
        double shift = largest * SHIFT;
        memset(inverse, 0, (size_t)size * sizeof *inverse);
        for (int i = 0; largest > 0 && !invert_block(k, inverse, dim) && i < 16; i++) {
            for (int d = 0; d < dim; d++)
                k[d * (dim + 1)] += shift;
            shift *= 4;
        }
    }
}

/** Add the elements of a grid, those of all processes. */
static void add_elements(pl_lattice *l, const pl_grid *g) {
    const int dim = l->plan->dim;
    const int64_t n = (g->n_vertices << dim) * dim * dim;
    pl_slab_pass pass = {.l = l,
                         .g = g,
                         .body = adder_of(l->plan),
                         .terms = pl_terms_up_to(most_of(g), l->n_terms * l->one_in)};
    memset(g->stiffness, 0, (size_t)n * sizeof *g->stiffness);
    if (!g->has_own)
        return;
    pl_visit_slabs(&pass, g->n_slabs - 1);
    pl_add_over_parts(pass.terms, g->stiffness, n);
}

void pl_lattice_assemble(pl_lattice *l) {
    for (int i = 0; i < l->n_levels; i++) {
        const pl_grid *g = &l->grid[i];
        pl_slab_pass pass = {.l = l, .g = g, .body = coarsen_slab};
        add_elements(l, g);
        if (i > 0)
            pl_visit_slabs(&pass, g->n_slabs);
    }
    /* Shifts of one grid are none of the next. */
    for (int i = 0; i < l->n_levels; i++) {
        pl_slab_pass pass = {.l = l, .g = &l->grid[i], .body = invert_slab};
        pl_visit_slabs(&pass, l->grid[i].n_slabs);
    }
}

/* ---- forces and moves of nodes --------------------------------------------------------------- */

/* Weights of vertices at a node: it may have left its simplex since it was sorted. */
#define WEIGHT_LEAST (-1.0)
#define WEIGHT_MOST  2.0

PL_INLINE void exchange_slab_in(const pl_slab_pass *p, int64_t slab, int dim) {
    const pl_lattice *l = p->l;
    const int64_t stride = p->g->per_slab * pl_simplices_of(dim);
    const int64_t begin = p->g->first + slab * stride;
    for (int64_t i = begin; i < begin + stride; i++) {
        if (l->star_begin[i] == l->star_begin[i + 1])
            continue;
        const pl_simplex s = pl_simplex_of(p->g, i, dim);
        for (int64_t k = l->star_begin[i]; k < l->star_begin[i + 1]; k++) {
            const int64_t star = l->star[k];
            double x[3], weight[PL_CORNERS];
            pl_unit_place(l, pl_lattice_node(l, star), x, dim);
            pl_weights_at(&s, x, weight, dim);
            for (int a = 0; a <= dim; a++) {
                const double w = fmin(fmax(weight[a], WEIGHT_LEAST), WEIGHT_MOST) * l->spacing;
                for (int d = 0; d < dim; d++) {
                    const int64_t at = s.vertex[a] * dim + d;
                    if (p->to)
                        p->to[star * dim + d] += w * p->g->total[at];
                    else
                        p->g->force[at] += pl_round_term(p->terms, w * p->from[star * dim + d]);
                }
            }
        }
    }
}

/** Exchange between the nodes in the cubes of a slab and the vertices: to gets moves, or forces go
 *  to the vertices. */
static void exchange_slab(const pl_slab_pass *p, int64_t slab) {
    if (p->l->plan->dim == 3)
        exchange_slab_in(p, slab, 3);
    else
        exchange_slab_in(p, slab, 2);
}

/** Forces under way. */
typedef struct force_pass {
    const double *force;
    double largest;
} force_pass;

static void largest_chunk(void *context, int64_t begin, int64_t end, int thread) {
    force_pass *p = context;
    double largest = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        largest = fmax(largest, fabs(p->force[i]));
    pl_raise_double(&p->largest, largest);
}

int pl_lattice_restrict(pl_lattice *l, const double *force) {
    enum { CHUNK = 4096 };
    const int64_t n = l->n_stars, dim = l->plan->dim;
    force_pass forces = {force, 0};
    pl_parallel_for(l->plan->threads, n * dim, CHUNK, largest_chunk, &forces);
    pl_parts_largest(&forces.largest, 1);
    const double most = forces.largest * WEIGHT_MOST * l->spacing;
    if (!(most > 0x1p-900) || !(most < 0x1p900)) /* so that no unit or sum leaves the doubles */
        return 0;
    const pl_terms terms = pl_terms_up_to(most, l->n_moving);
    for (int i = 0; i < l->n_levels; i++) {
        const pl_grid *g = &l->grid[i];
        pl_slab_pass pass = {.l = l, .g = g, .from = force, .body = exchange_slab, .terms = terms};
        memset(g->force, 0, (size_t)(g->n_vertices * dim) * sizeof *g->force);
        if (!g->has_own)
            continue;
        pl_visit_slabs(&pass, g->n_slabs - 1);
        pl_add_over_parts(terms, g->force, g->n_vertices * dim);
    }
    return 1;
}

void pl_lattice_prolong(const pl_lattice *l, double *move) {
    const int64_t n = l->n_stars * l->plan->dim;
    memset(move, 0, (size_t)n * sizeof *move);
    for (int i = 0; i < l->n_levels; i++) {
        pl_slab_pass pass = {
            .l = (pl_lattice *)l, .g = &l->grid[i], .to = move, .body = exchange_slab};
        pl_visit_slabs(&pass, l->grid[i].n_slabs - 1);
    }
}
