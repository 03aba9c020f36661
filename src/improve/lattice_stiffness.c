/* lattice_stiffness: the Hessian of the sum of RR^2 by the vertices of a lattice; forces and moves of
 * nodes. Layers of cells or vertices with one between them share nothing that is written. */
#include "improve/bend.h"
#include "improve/lattice_places.h"

#include "star/kernel_direction.h"

#include <math.h>
#include <string.h>

/* ---- stiffness ------------------------------------------------------------------------------- */

/** Four elements of a simplex: their nodes, and the weights of its vertices at these; 0 at nodes that
 *  are not free. */
typedef struct four {
    bend_pack x[PL_MAX_CORNERS][3], weight[PL_MAX_CORNERS][PL_MAX_CORNERS];
} four;

PL_INLINE void gather_four(const pl_lattice *l, const pl_simplex *s, const int32_t *corner,
                           int64_t n, four *f, const int dim) {
    for (int lane = 0; lane < 4; lane++) {
        for (int j = 0; j <= dim; j++) {
            const int32_t inner = corner[(lane < n ? lane : 0) * (dim + 1) + j];
            double x[3], weight[PL_MAX_CORNERS] = {0};
            pl_unit_place(l, inner, x, dim);
            if (l->is_free[inner] && lane < n)
                pl_weights_at(s, x, weight, dim);
            for (int d = 0; d < dim; d++)
                f->x[j][d][lane] = x[d];
            for (int a = 0; a <= dim; a++)
                f->weight[j][a][lane] = weight[a];
        }
    }
}

/** Sums over elements of a simplex: blocks of its vertices a <= b, in this order. */
typedef struct simplex_sums {
    bend_pack block[10][9];
} simplex_sums;

PL_INLINE void add_four(const four *f, simplex_sums *sums, const int dim) {
    const int n = dim * dim;
    bend_block h[BEND_BLOCKS];
    bend_vector e[3];
    bend_pack by_edge[3][PL_MAX_CORNERS], half[3][PL_MAX_CORNERS][9];
    for (int k = 0; k < dim; k++) {
        e[k].x = f->x[k + 1][0] - f->x[0][0];
        e[k].y = f->x[k + 1][1] - f->x[0][1];
        e[k].z = dim == 3 ? f->x[k + 1][2] - f->x[0][2] : bend_of(0);
        for (int a = 0; a <= dim; a++)
            by_edge[k][a] = f->weight[k + 1][a] - f->weight[0][a];
    }
    if (dim == 3)
        bend_tetrahedra(e, h);
    else
        bend_triangles(e, h);
    for (int i = 0; i < dim; i++)
        for (int a = 0; a <= dim; a++)
            for (int c = 0; c < n; c++) {
                bend_pack sum = bend_of(0);
                for (int j = 0; j < dim; j++) {
                    const int low = i < j ? i : j, high = i < j ? j : i;
                    const int at = low * dim - low * (low - 1) / 2 + high - low;
                    sum += by_edge[j][a] * h[at][i <= j ? c : c % dim * dim + c / dim];
                }
                half[i][a][c] = sum;
            }
    for (int a = 0, at = 0; a <= dim; a++)
        for (int b = a; b <= dim; b++, at++)
            for (int c = 0; c < n; c++) {
                bend_pack sum = by_edge[0][a] * half[0][b][c];
                for (int i = 1; i < dim; i++)
                    sum += by_edge[i][a] * half[i][b][c];
                sums->block[at][c] += sum;
            }
}

PL_INLINE void add_simplex(const pl_lattice *l, const pl_grid *g, int64_t number, const int dim) {
    const int64_t begin = l->element_begin[number], end = l->element_begin[number + 1];
    const int n = dim * dim;
    if (begin == end)
        return;
    const pl_simplex s = pl_simplex_of(g, number, dim);
    simplex_sums sums;
    four f;
    memset(&sums, 0, sizeof sums);
    for (int64_t i = begin; i < end; i += 4) {
        gather_four(l, &s, l->corner + i * (dim + 1), end - i, &f, dim);
        add_four(&f, &sums, dim);
    }
    for (int a = 0, at = 0; a <= dim; a++)
        for (int b = a; b <= dim; b++, at++) {
            double *to =
                g->stiffness + (s.vertex[a] * PL_LATTICE_BLOCKS + (s.bits[a] ^ s.bits[b])) * n;
            for (int c = 0; c < n; c++)
                to[c] += (sums.block[at][c][0] + sums.block[at][c][1]) +
                         (sums.block[at][c][2] + sums.block[at][c][3]);
        }
}

PL_INLINE void add_layer(const pl_layer_pass *p, int64_t layer, const int dim) {
    const int64_t stride = pl_stride_of(p->g, dim - 1) * pl_orders_of(dim);
    for (int64_t i = layer * stride; i < (layer + 1) * stride; i++)
        add_simplex(p->l, p->g, p->g->first + i, dim);
}

static void add_layer_3d(const pl_layer_pass *p, int64_t layer) {
    add_layer(p, layer, 3);
}

static void add_layer_2d(const pl_layer_pass *p, int64_t layer) {
    add_layer(p, layer, 2);
}

#if defined(PL_X86_KERNELS)
__attribute__((target("avx2"))) static void add_layer_3d_wide(const pl_layer_pass *p,
                                                              int64_t layer) {
    add_layer(p, layer, 3);
}
#endif

/** Function that adds the elements of a layer. */
static void (*adder_of(int dim))(const pl_layer_pass *, int64_t) {
#if defined(PL_X86_KERNELS)
    if (dim == 3 && __builtin_cpu_supports("avx2"))
        return add_layer_3d_wide;
#endif
    return dim == 3 ? add_layer_3d : add_layer_2d;
}

/** Add block K, or its transpose, of fine vertex i, of weight for coarse vertex a, and j. */
static void add_block(const pl_grid *coarse, int64_t vertex, const int64_t a[3],
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
        double *to = coarse->stiffness + (vertex * PL_LATTICE_BLOCKS + bits) * dim * dim;
        const double w = parity ? 0.5 * weight : weight;
        for (int r = 0; r < dim; r++)
            for (int c = 0; c < dim; c++)
                to[r * dim + c] += w * K[is_transposed ? c * dim + r : r * dim + c];
    }
}

/** Set the stiffness of coarse vertices from the finer grid. */
static void coarsen_layer(const pl_layer_pass *p, int64_t layer) {
    const pl_grid *g = p->g, *fine = g - 1;
    const int dim = p->l->dim, n = dim * dim, corners = 1 << dim;
    const int64_t stride = pl_stride_of(g, dim - 1);
    for (int64_t v = layer * stride; v < (layer + 1) * stride; v++) {
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
                          fine->stiffness + (row * PL_LATTICE_BLOCKS + to) * n, q >= corners, dim);
            }
        }
    }
}

/** Invert a block; 0 unless it is positive definite. */
static int invert_block(const double *k, double *inverse, int dim) {
    if (dim == 2) {
        const double determinant = k[0] * k[3] - k[1] * k[2];
        if (!(k[0] > 0 && determinant > 0))
            return 0;
        const double factor = 1 / determinant;
        inverse[0] = k[3] * factor;
        inverse[1] = inverse[2] = -k[1] * factor;
        inverse[3] = k[0] * factor;
        return 1;
    }
    const double packed_block[6] = {k[0], k[1], k[2], k[4], k[5], k[8]};
    double six[6];
    if (!invert(packed_block, six))
        return 0;
    const double all[9] = {six[0], six[1], six[2], six[1], six[3], six[4], six[2], six[4], six[5]};
    memcpy(inverse, all, sizeof all);
    return 1;
}

/* First shift of a vertex's block that is not positive definite, of its largest entry. */
#define SHIFT 0x1p-6

static void invert_layer(const pl_layer_pass *p, int64_t layer) {
    const pl_grid *g = p->g;
    const int dim = p->l->dim, n = dim * dim;
    const int64_t stride = pl_stride_of(g, dim - 1);
    for (int64_t v = layer * stride; v < (layer + 1) * stride; v++) {
        double *k = g->stiffness + v * PL_LATTICE_BLOCKS * n, largest = 0;
        for (int d = 0; d < dim; d++) {
            largest = fmax(largest, k[d * (dim + 1)]);
        }
        memset(g->inverse + v * n, 0, (size_t)n * sizeof(double));
        double shift = largest * SHIFT;
        for (int i = 0; largest > 0 && !invert_block(k, g->inverse + v * n, dim) && i < 16; i++) {
            for (int d = 0; d < dim; d++)
                k[d * (dim + 1)] += shift;
            shift *= 4;
        }
    }
}

void pl_lattice_assemble(pl_lattice *l) {
    for (int i = 0; i < l->n_levels; i++) {
        const pl_grid *g = &l->grid[i];
        pl_layer_pass pass = {.l = l, .g = g};
        memset(g->stiffness, 0,
               (size_t)(g->n_vertices * PL_LATTICE_BLOCKS * l->dim * l->dim) * sizeof(double));
        if (i > 0) {
            pass.body = coarsen_layer;
            pl_visit_layers(&pass, g->n[l->dim - 1]);
        }
        pass.body = adder_of(l->dim);
        pl_visit_layers(&pass, g->n[l->dim - 1] - 1);
    }
    /* Shifts of one grid are none of the next. */
    for (int i = 0; i < l->n_levels; i++) {
        pl_layer_pass pass = {.l = l, .g = &l->grid[i], .body = invert_layer};
        pl_visit_layers(&pass, l->grid[i].n[l->dim - 1]);
    }
}

/* ---- forces and moves of nodes --------------------------------------------------------------- */

PL_INLINE void restrict_layer(const pl_layer_pass *p, int64_t layer, const int dim) {
    const pl_lattice *l = p->l;
    const int64_t stride = pl_stride_of(p->g, dim - 1) * pl_orders_of(dim);
    for (int64_t i = p->g->first + layer * stride; i < p->g->first + (layer + 1) * stride; i++) {
        if (l->star_begin[i] == l->star_begin[i + 1])
            continue;
        const pl_simplex s = pl_simplex_of(p->g, i, dim);
        for (int64_t k = l->star_begin[i]; k < l->star_begin[i + 1]; k++) {
            double x[3], weight[PL_MAX_CORNERS];
            pl_unit_place(l, l->plan->interior.centre[l->star[k]], x, dim);
            pl_weights_at(&s, x, weight, dim);
            for (int a = 0; a <= dim; a++)
                for (int d = 0; d < dim; d++) {
                    if (p->to)
                        p->to[l->star[k] * (int64_t)dim + d] +=
                            weight[a] * p->g->total[s.vertex[a] * dim + d] * l->spacing;
                    else
                        p->g->force[s.vertex[a] * dim + d] +=
                            weight[a] * p->from[l->star[k] * (int64_t)dim + d] * l->spacing;
                }
        }
    }
}

static void nodes_of_layer(const pl_layer_pass *p, int64_t layer) {
    if (p->l->dim == 3)
        restrict_layer(p, layer, 3);
    else
        restrict_layer(p, layer, 2);
}

void pl_lattice_restrict(pl_lattice *l, const double *force) {
    for (int i = 0; i < l->n_levels; i++) {
        const pl_grid *g = &l->grid[i];
        pl_layer_pass pass = {.l = l, .g = g, .from = force, .body = nodes_of_layer};
        memset(g->force, 0, (size_t)(g->n_vertices * l->dim) * sizeof(double));
        pl_visit_layers(&pass, g->n[l->dim - 1] - 1);
    }
}

void pl_lattice_prolong(const pl_lattice *l, double *move) {
    memset(move, 0, (size_t)(l->plan->interior.stars.n_stars * l->dim) * sizeof(double));
    for (int i = 0; i < l->n_levels; i++) {
        pl_layer_pass pass = {
            .l = (pl_lattice *)l, .g = &l->grid[i], .to = move, .body = nodes_of_layer};
        pl_visit_layers(&pass, l->grid[i].n[l->dim - 1] - 1);
    }
}
