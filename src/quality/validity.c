/* validity: coefficients in doubles, bisections, and the same in integers. */
#include "quality/validity.h"
#include "base/exact.h"
#include "base/memory.h"
#include "geometry/inline.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <string.h>

enum { LANES = PL_JACOBIAN_LANES };

typedef double pack[LANES];

/* ---- Doubles ------------------------------------------------------------------------------- */

static const double ROUNDING = 0x1p-53;

/* Underflow loses at most 2^-1074 each time. What is lost meets two derivatives afterwards, which
 * are below 2^75 (validity.h), and whole numbers below 2^24, less than 2^20 times in all. */
static const double UNDERFLOW_ERROR = 0x1p-850;

/* Coefficients that are larger are left to integers, as halves of the shape could overflow. */
static const double LARGEST_COEFFICIENT = 0x1p1000;

/* How far a coefficient can be from the one of the element itself, with u = 2^-53 = ROUNDING.
 *
 * Nodes (order 2 only). Differences to the first node are off by u of themselves, and mids that are
 * missing by u more. With X the largest of them, and W the largest sum of the absolute weights of a
 * control, a control of n nodes is off by rounding = (n + 2) u W X: u or 2 u from its terms, u from
 * each product, (n - 1) u from their sum. Linear elements have no controls: rounding = 0.
 *
 * Derivatives. The difference of two controls is off by 2 rounding, and by u of itself.
 *
 * Determinants. Let s_m be the largest component of the derivatives as computed, in direction m. A
 * determinant has dim! products of one component in each direction. With components off by 2 r,
 * r = rounding, these dim! products are off by at most
 *     dim! (product of (s_m + 2 r) - product of s_m)
 *       = 6 (2 r (s0 s1 + s0 s2 + s1 s2) + 4 r^2 (s0 + s1 + s2) + 8 r^3)   or   2 (2 r (s0 + s1) + 4 r^2).
 * Besides each product carries factors 1 + u: 3 of its components, 1 of the product in a component
 * of the normal, 1 of their difference, 1 of the product with it, 2 of the sum of three, 1 of the
 * weight, n - 1 of the sum of the n products of the coefficient, 1 of its factor: n + 9, of which
 * u (n + 12) is more than enough.
 *
 * Coefficients. Weights times factors add up to common, as Bernstein polynomials add up to 1. So
 * the bound of a coefficient is common times that of a determinant.
 *
 * Terms of u^2 and r u are below 2^-40 of those above, like the roundings of the bound itself. The
 * factor of 1.01 pays for them. Scaling by powers of two changes nothing but underflow. */

/** Find the controls of a block of order 2, and the bound of their rounding. */
PL_INLINE void find_controls(const pl_jacobian_rule *rule, const pl_jacobian_block *b,
                             double control[][3][LANES], pack rounding, const int dim) {
    pack largest = {0};
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < dim; d++)
            for (int l = 0; l < LANES; l++) {
                const double a = fabs(b->x[i][d][l]);
                largest[l] = a > largest[l] ? a : largest[l];
            }
    for (int l = 0; l < LANES; l++)
        rounding[l] = largest[l] * rule->control_weight * (rule->n_nodes + 2) * ROUNDING;
    for (int c = 0; c < rule->n_controls; c++)
        for (int d = 0; d < 3; d++)
            for (int l = 0; l < LANES; l++)
                control[c][d][l] = 0;
    for (int t = 0; t < rule->n_control_terms; t++) {
        const pl_jacobian_term *term = &rule->control_term[t];
        for (int d = 0; d < dim; d++)
            for (int l = 0; l < LANES; l++)
                control[term->to][d][l] += term->weight * b->x[term->from][d][l];
    }
}

/** Bound of the error of a coefficient, as derived above. */
PL_INLINE double error_bound(const pl_jacobian_rule *rule, const double size[3], double rounding,
                             const int dim) {
    const double *s = size, r = rounding;
    const double rounded = (rule->n_products_each + 12) * ROUNDING;
    const double bound = dim == 3
                             ? 6 * (rounded * (s[0] * s[1] * s[2]) +
                                    2 * r * (s[0] * s[1] + s[0] * s[2] + s[1] * s[2]) +
                                    4 * r * r * (s[0] + s[1] + s[2] + 2 * r))
                             : 2 * (rounded * (s[0] * s[1]) + 2 * r * (s[0] + s[1]) + 4 * r * r);
    return 1.01 * rule->common * bound + UNDERFLOW_ERROR;
}

PL_INLINE void evaluate(const pl_jacobian_rule *rule, const double sign[], pl_jacobian_block *b,
                        const int dim) {
    double control[PL_CELL_NODES][3][LANES];
    double derivative[3][PL_JACOBIAN_DERIVATIVES][3][LANES];
    double size[3][LANES] = {{0}};
    pack rounding = {0};
    if (rule->n_control_terms > 0)
        find_controls(rule, b, control, rounding, dim);
    double(*const from)[3][LANES] = rule->n_control_terms > 0 ? control : b->x;
    for (int m = 0; m < dim; m++)
        for (int i = 0; i < rule->n_derivatives[m]; i++) {
            const pl_jacobian_derivative *of = &rule->derivative[m][i];
            for (int d = 0; d < dim; d++)
                for (int l = 0; l < LANES; l++) {
                    const double difference = from[of->plus][d][l] - from[of->minus][d][l];
                    const double a = fabs(difference);
                    derivative[m][i][d][l] = difference;
                    size[m][l] = a > size[m][l] ? a : size[m][l];
                }
        }
    for (int c = 0; c < rule->n_coefficients; c++)
        for (int l = 0; l < LANES; l++)
            b->coefficient[c][l] = 0;
    double normal[3][LANES] = {{0}};
    for (int p = 0; p < rule->n_products; p++) {
        const pl_jacobian_product *product = &rule->product[p];
        const double(*v)[LANES] = derivative[1][product->j],
              (*w)[LANES] = derivative[2][product->k];
        const double(*u)[LANES] = derivative[0][product->i];
        double *const sum = b->coefficient[product->coefficient];
        const double weight = product->weight;
        if (dim == 2) {
            for (int l = 0; l < LANES; l++)
                sum[l] += weight * (u[0][l] * v[1][l] - u[1][l] * v[0][l]);
            continue;
        }
        if (p == 0 || product->j != product[-1].j || product->k != product[-1].k)
            for (int l = 0; l < LANES; l++) {
                normal[0][l] = v[1][l] * w[2][l] - v[2][l] * w[1][l];
                normal[1][l] = v[2][l] * w[0][l] - v[0][l] * w[2][l];
                normal[2][l] = v[0][l] * w[1][l] - v[1][l] * w[0][l];
            }
        for (int l = 0; l < LANES; l++)
            sum[l] +=
                weight * (u[0][l] * normal[0][l] + u[1][l] * normal[1][l] + u[2][l] * normal[2][l]);
    }
    pack least, total = {0};
    for (int l = 0; l < LANES; l++)
        least[l] = INFINITY;
    for (int c = 0; c < rule->n_coefficients; c++)
        for (int l = 0; l < LANES; l++) {
            const double value = b->coefficient[c][l] * (rule->factor[c] * sign[l]);
            b->coefficient[c][l] = value;
            least[l] = value < least[l] ? value : least[l];
            total[l] += value;
        }
    for (int l = 0; l < LANES; l++) {
        const double sizes[3] = {size[0][l], size[1][l], size[2][l]};
        b->error[l] = error_bound(rule, sizes, rounding[l], dim);
        b->mean[l] = total[l] / rule->n_coefficients;
        b->least[l] = total[l] - total[l] == 0 ? least[l] : NAN;
    }
}

PL_INLINE void inline_evaluate(const pl_jacobian_rule *rule, const double sign[],
                               pl_jacobian_block *b) {
    if (rule->type->shape->dim == 3)
        evaluate(rule, sign, b, 3);
    else
        evaluate(rule, sign, b, 2);
}

/* With wider vectors, as in measure.c; the bits are the same. */
#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void
wide_evaluate(const pl_jacobian_rule *rule, const double sign[], pl_jacobian_block *b) {
    inline_evaluate(rule, sign, b);
}
#endif

void pl_jacobian_evaluate(const pl_jacobian_rule *rule, const double sign[], pl_jacobian_block *b) {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2")) {
        wide_evaluate(rule, sign, b);
        return;
    }
#endif
    inline_evaluate(rule, sign, b);
}

/* ---- Floats -------------------------------------------------------------------------------- */

/* Hexahedra of order 1. With edges U_jk, V_ik, W_ij in the three directions coefficient abc is the
 * mean of det(U_jk, V_ik, W_ij) over i + i' = a, j + j' = b, k + k' = c, where V has i and W i', U
 * has j and W j', U has k and V k'. Where a = 1 a coefficient takes normals of both
 * V_0 W_1 and V_1 W_0, summed first.
 *
 * Rounding, u = 2^-24: as above, with a corner off by r = u X, X the largest coordinate, an edge by
 * 2 r, and each of the 6 products of a determinant by less than 20 u of itself: 3 of components, 2
 * of the normal, 1 of a sum of normals, 3 of the product with U, 4 of sums. Edges' lengths s0, s1, s2
 * stand for their components. 1.01 pays for what is left out.
 *
 * Room. A move of corner 000 by d changes U_00, V_00 and W_00 by d, and no other edge. In
 * coefficient abc these take part by g(b) g(c), g(a) g(c), g(a) g(b), g(0) = 1, g(1) = 1/2, g(2) =
 * 0. So a coefficient that is at no corner changes by at most |d| times
 *     s1 s2 + (s0 s2 + s0 s1) / 2     or the like:  f = (the largest of the products + their sum) / 2
 * as det is at most the product of its columns' lengths, and takes d once. Edges grow by D at most
 * while corners go D in all. So f is at most f + f' D + 2 D^2 then, f' = (the two longest of s0, s1, s2
 * + twice their sum) / 2, and coefficients fall by at most the integral of that,
 *     h(D) = D (f + f' D / 2 + 2 D^2 / 3).
 * All D with h(D) <= b = coefficient - floor will do. As D <= a = b / f, and g(D) = b D / h(D) falls,
 * g(a) is below the largest such D, and g(g(a)) above; between them h is below its chord, as it is
 * convex: where the chord is b is below, too. Each room is less by 1e-4 of itself for the rounding of
 * all this. */

#pragma GCC diagnostic ignored "-Wpsabi" /* all of these are inlined */

typedef float floats __attribute__((vector_size(LANES * sizeof(float))));
typedef int32_t floats_mask __attribute__((vector_size(LANES * sizeof(float))));
typedef float floats_kept
    __attribute__((vector_size(LANES * sizeof(float)), aligned(4), may_alias));

/** Load LANES floats. */
PL_INLINE floats floats_load(const float *kept) {
    return *(const floats_kept *)kept;
}

PL_INLINE floats floats_of(float x) {
    return (floats){x, x, x, x, x, x, x, x};
}

PL_INLINE floats floats_select(floats_mask mask, floats a, floats b) {
    return (floats)((mask & (floats_mask)a) | (~mask & (floats_mask)b));
}

/** The smaller one; b where a is NaN. */
PL_INLINE floats floats_min(floats a, floats b) {
    return floats_select(a < b, a, b);
}

PL_INLINE floats floats_max(floats a, floats b) {
    return floats_select(a > b, a, b);
}

PL_INLINE floats floats_abs(floats a) {
    return (floats)((floats_mask)a & INT32_MAX);
}

PL_INLINE floats floats_sqrt(floats a) {
    floats root;
    for (int l = 0; l < LANES; l++)
        root[l] = sqrtf(a[l]);
    return root;
}

PL_INLINE floats floats_dot(const floats a[3], const floats b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

PL_INLINE void floats_cross(const floats a[3], const floats b[3], floats normal[3]) {
    normal[0] = a[1] * b[2] - a[2] * b[1];
    normal[1] = a[2] * b[0] - a[0] * b[2];
    normal[2] = a[0] * b[1] - a[1] * b[0];
}

/** Edges of bricks: [direction][which][component], which of two bits: jk, ik, ij as above. */
typedef struct brick_edges {
    floats of[3][4][3];
    floats longest[3]; /* of each direction */
    floats size;       /* largest coordinate of a corner */
} brick_edges;

/* Corners of each edge, in the order of brick_edges. */
static const uint8_t BRICK_EDGE[3][4][2] = {{{0, 1}, {4, 5}, {3, 2}, {7, 6}},
                                            {{0, 3}, {4, 7}, {1, 2}, {5, 6}},
                                            {{0, 4}, {3, 7}, {1, 5}, {2, 6}}};

PL_INLINE void find_brick_edges(const pl_brick_block *b, brick_edges *e) {
    floats x[8][3];
    e->size = floats_of(0);
    for (int i = 0; i < 8; i++)
        for (int d = 0; d < 3; d++) {
            x[i][d] = floats_load(b->x[i][d]);
            e->size = floats_max(floats_abs(x[i][d]), e->size);
        }
    for (int m = 0; m < 3; m++) {
        floats square = floats_of(0);
        for (int i = 0; i < 4; i++) {
            const floats *from = x[BRICK_EDGE[m][i][0]], *to = x[BRICK_EDGE[m][i][1]];
            for (int d = 0; d < 3; d++)
                e->of[m][i][d] = to[d] - from[d];
            square = floats_max(floats_dot(e->of[m][i], e->of[m][i]), square);
        }
        e->longest[m] = floats_sqrt(square);
    }
}

/** Find the least coefficient of those at corners, and of the others. */
PL_INLINE void find_brick_least(const brick_edges *e, floats least[2]) {
    floats sum[3][3][3];
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            for (int c = 0; c < 3; c++)
                sum[a][b][c] = floats_of(0);
    for (int k = 0; k < 2; k++)       /* of V; V_ik is 2 i + k, */
        for (int j = 0; j < 2; j++) { /* of W; W_ij is 2 i + j */
            floats normal[3][3], other[3];
            floats_cross(e->of[1][k], e->of[2][j], normal[0]);
            floats_cross(e->of[1][k], e->of[2][2 + j], normal[1]);
            floats_cross(e->of[1][2 + k], e->of[2][j], other);
            floats_cross(e->of[1][2 + k], e->of[2][2 + j], normal[2]);
            for (int d = 0; d < 3; d++)
                normal[1][d] += other[d];
            for (int own = 0; own < 4; own++) /* U_jk is 2 j + k */
                for (int a = 0; a < 3; a++)
                    sum[a][own / 2 + j][own % 2 + k] += floats_dot(e->of[0][own], normal[a]);
        }
    least[0] = least[1] = floats_of(INFINITY);
    static const float part[3] = {1, 0.5F, 1};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            for (int c = 0; c < 3; c++) {
                const floats mean = sum[a][b][c] * floats_of(part[a] * part[b] * part[c]);
                const int is_inner = a == 1 || b == 1 || c == 1;
                least[is_inner] = floats_min(mean, least[is_inner]);
            }
}

/** h(D) / D: see above. */
PL_INLINE floats brick_slope(floats f, floats half, floats way) {
    return f + way * (half + way * floats_of(2.0F / 3));
}

PL_INLINE void certify_bricks(pl_brick_block *b) {
    brick_edges e;
    floats least[2];
    const floats floor = floats_load(b->floor);
    find_brick_edges(b, &e);
    find_brick_least(&e, least);
    const float u = 0x1p-24F;
    const floats *s = e.longest, r = e.size * floats_of(u);
    const floats p0 = s[1] * s[2], p1 = s[0] * s[2], p2 = s[0] * s[1], sum = p0 + p1 + p2;
    const floats error =
        floats_of(0x1p-120F) + /* underflow */
        floats_of(1.01F * 6) * (floats_of(20 * u) * (s[0] * p0) + floats_of(2) * r * sum +
                                floats_of(4) * r * r * (s[0] + s[1] + s[2] + floats_of(2) * r));
    const floats f = floats_of(0.5F) * (sum + floats_max(p0, floats_max(p1, p2)));
    const floats t = floats_min(s[0], floats_min(s[1], s[2]));
    const floats half = floats_of(0.25F) * (floats_of(3) * (s[0] + s[1] + s[2]) - t);
    const floats fall = least[1] - error - floor, a = fall / f;
    const floats below = fall / brick_slope(f, half, a);
    const floats above = fall / brick_slope(f, half, below);
    const floats from = below * brick_slope(f, half, below);
    const floats to = above * brick_slope(f, half, above);
    const floats chord = below + (fall - from) * ((above - below) / (to - from));
    const floats room =
        floats_of(1 - 1e-4F) * floats_select(to > from, floats_min(chord, above), below);
    const floats_mask is_sized =
        (e.size >= floats_of(PL_BRICK_SMALL)) & (e.size <= floats_of(PL_BRICK_LARGE));
    const floats_mask is_above = (least[0] - error - floor > floats_of(0)) & (a > floats_of(0));
    *(floats_kept *)b->room = floats_select(is_sized & is_above, room, floats_of(0));
}

#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void wide_certify_bricks(pl_brick_block *b) {
    certify_bricks(b);
}
#endif

void pl_bricks_certify(pl_brick_block *b) {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2")) {
        wide_certify_bricks(b);
        return;
    }
#endif
    certify_bricks(b);
}

/* ---- Floats, any type ----------------------------------------------------------------------- */

/* As in doubles, with u = 2^-24. Nodes of linear elements are off by u X, and so are the controls that
 * they are; of order 2 that is in the (n + 2) u W X of controls. A derivative's length is off by less
 * than 4 r. Within the bounds of X no sum overflows. */

static const float FLOATS_SMALL = 0x1p-20F, FLOATS_LARGE = 0x1p20F;

/** Find the controls; returns the bound of their rounding, and *largest: X. */
PL_INLINE floats find_float_controls(const pl_jacobian_rule *rule, const pl_float_block *b,
                                     floats control[][3], floats *largest, const int dim) {
    floats node[PL_CELL_NODES][3];
    const int has_terms = rule->n_control_terms > 0;
    floats(*const nodes)[3] = has_terms ? node : control;
    *largest = floats_of(0);
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < dim; d++) {
            nodes[i][d] = floats_load(b->x[i][d]);
            *largest = floats_max(floats_abs(nodes[i][d]), *largest);
        }
    for (int c = 0; has_terms && c < rule->n_controls; c++)
        for (int d = 0; d < dim; d++)
            control[c][d] = floats_of(0);
    for (int t = 0; t < rule->n_control_terms; t++) {
        const pl_jacobian_term *term = &rule->control_term[t];
        for (int d = 0; d < dim; d++)
            control[term->to][d] += floats_of(term->weight) * node[term->from][d];
    }
    const int roundings = has_terms ? rule->control_weight * (rule->n_nodes + 2) : 1;
    return *largest * floats_of((float)roundings * 0x1p-24F);
}

PL_INLINE floats floats_square(const floats *a, const floats *b, const int dim) {
    floats sum = floats_of(0);
    for (int d = 0; d < dim; d++)
        sum += (a[d] - b[d]) * (a[d] - b[d]);
    return sum;
}

/** Find the derivatives, their largest component in each direction, and the square of the longest one
 *  along any edge: differences of two are derivatives along other edges. */
PL_INLINE floats find_float_derivatives(const pl_jacobian_rule *rule, floats control[][3],
                                        floats derivative[3][PL_JACOBIAN_DERIVATIVES][3],
                                        floats size[3], const int dim) {
    floats longest = floats_of(0);
    for (int m = 0; m < dim; m++) {
        size[m] = floats_of(0);
        for (int i = 0; i < rule->n_derivatives[m]; i++) {
            const pl_jacobian_derivative *of = &rule->derivative[m][i];
            const floats *plus = control[of->plus];
            for (int d = 0; d < dim; d++) {
                derivative[m][i][d] = plus[d] - control[of->minus][d];
                size[m] = floats_max(floats_abs(derivative[m][i][d]), size[m]);
            }
            longest = floats_max(floats_square(plus, control[of->minus], dim), longest);
            for (int k = 0; k < m; k++)
                if (rule->turn[k] == rule->turn[m])
                    longest = floats_max(
                        floats_square(plus, control[rule->derivative[k][i].plus], dim), longest);
        }
    }
    return longest;
}

/** Find the sums of products. */
PL_INLINE void find_float_sums(const pl_jacobian_rule *rule,
                               floats derivative[3][PL_JACOBIAN_DERIVATIVES][3], floats sum[],
                               const int dim) {
    floats normal[3] = {floats_of(0), floats_of(0), floats_of(0)};
    for (int c = 0; c < rule->n_coefficients; c++)
        sum[c] = floats_of(0);
    for (int p = 0; p < rule->n_products; p++) {
        const pl_jacobian_product *of = &rule->product[p];
        const floats *u = derivative[0][of->i], *v = derivative[1][of->j];
        if (dim == 3 && (p == 0 || of->j != of[-1].j || of->k != of[-1].k))
            floats_cross(v, derivative[2][of->k], normal);
        sum[of->coefficient] +=
            floats_of(of->weight) * (dim == 3 ? floats_dot(u, normal) : u[0] * v[1] - u[1] * v[0]);
    }
}

/** Bound of the error of a coefficient, as error_bound. */
PL_INLINE floats float_error(const pl_jacobian_rule *rule, const floats s[3], floats r,
                             const int dim) {
    const floats rounded = floats_of((float)(rule->n_products_each + 12) * 0x1p-24F);
    const floats two = floats_of(2), four = floats_of(4);
    const floats bound =
        dim == 3 ? floats_of(6) * (rounded * (s[0] * s[1] * s[2]) +
                                   two * r * (s[0] * s[1] + s[0] * s[2] + s[1] * s[2]) +
                                   four * r * r * (s[0] + s[1] + s[2] + two * r))
                 : two * (rounded * (s[0] * s[1]) + two * r * (s[0] + s[1]) + four * r * r);
    return floats_of(1.01F * (float)rule->common) * bound + floats_of(0x1p-90F);
}

PL_INLINE void bound_floats(const pl_jacobian_rule *rule, const uint8_t is_passed_over[],
                            pl_float_block *b, const int dim) {
    floats control[PL_CELL_NODES][3], derivative[3][PL_JACOBIAN_DERIVATIVES][3];
    floats sum[PL_JACOBIAN_COEFFICIENTS], size[3], largest;
    floats all = floats_of(INFINITY), inner = all;
    const floats sign = floats_load(b->sign);
    const floats r = find_float_controls(rule, b, control, &largest, dim);
    const floats square = find_float_derivatives(rule, control, derivative, size, dim);
    find_float_sums(rule, derivative, sum, dim);
    for (int c = 0; c < rule->n_coefficients; c++) {
        const floats value = sum[c] * floats_of(rule->factor[c]) * sign;
        all = floats_min(value, all);
        if (!is_passed_over[c])
            inner = floats_min(value, inner);
    }
    const floats error = float_error(rule, size, r, dim);
    const floats_mask is_sized =
        (largest >= floats_of(FLOATS_SMALL)) & (largest <= floats_of(FLOATS_LARGE));
    *(floats_kept *)b->all = floats_select(is_sized, all - error, floats_of(0));
    *(floats_kept *)b->inner = floats_select(is_sized, inner - error, floats_of(0));
    *(floats_kept *)b->longest = floats_of(1 + 0x1p-20F) * floats_sqrt(square) + floats_of(4) * r;
}

PL_INLINE void bound_any(const pl_jacobian_rule *rule, const uint8_t is_passed_over[],
                         pl_float_block *b) {
    if (rule->type->shape->dim == 3)
        bound_floats(rule, is_passed_over, b, 3);
    else
        bound_floats(rule, is_passed_over, b, 2);
}

#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void
wide_bound(const pl_jacobian_rule *rule, const uint8_t is_passed_over[], pl_float_block *b) {
    bound_any(rule, is_passed_over, b);
}
#endif

void pl_jacobian_bound(const pl_jacobian_rule *rule, const uint8_t is_passed_over[],
                       pl_float_block *b) {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2")) {
        wide_bound(rule, is_passed_over, b);
        return;
    }
#endif
    bound_any(rule, is_passed_over, b);
}

/* ---- Bisections ---------------------------------------------------------------------------- */

/** Decide by the coefficients b [n_coefficients] of an element or of a piece of it, if they do. All
 *  are finite. */
static int decides(const pl_jacobian_rule *rule, const double b[], double error,
                   pl_validity *validity) {
    double least = INFINITY;
    for (int c = 0; c < rule->n_coefficients; c++)
        least = b[c] < least ? b[c] : least;
    if (least > error) {
        *validity = PL_VALID;
        return 1;
    }
    for (int c = 0; c < rule->n_corners; c++)
        if (b[rule->corner[c]] < -error) {
            *validity = PL_INVALID;
            return 1;
        }
    return 0;
}

/** Put the halves of piece [2][n_coefficients], of which the first is whole. */
static void halve(const pl_jacobian_rule *rule, int h, double *piece) {
    const int n_coefficients = rule->n_coefficients;
    double whole[PL_JACOBIAN_COEFFICIENTS];
    memcpy(whole, piece, (size_t)n_coefficients * sizeof *whole);
    memset(piece, 0, 2 * (size_t)n_coefficients * sizeof *piece);
    for (int half = 0; half < 2; half++) {
        double *const to = piece + half * n_coefficients;
        for (int t = 0; t < rule->n_half_terms[h][half]; t++) {
            const pl_jacobian_term *term = &rule->half_term[h][half][t];
            to[term->to] += term->weight * whole[term->from];
        }
        for (int c = 0; c < n_coefficients; c++)
            to[c] *= 1.0 / (1 << rule->half_shift[h]);
    }
}

/** Decide by bisections of piece [PL_VALIDITY_DEPTH + 2][n_coefficients], of which the first is filled in,
 *  depth first. error: of its coefficients; rounding: of each bisection. */
static pl_validity bisect_pieces(const pl_jacobian_rule *rule, double *piece, double error,
                                 double rounding) {
    int depth[PL_VALIDITY_DEPTH + 2] = {0}, n = 1, n_boxes = 0;
    while (n > 0) {
        const int at = n - 1;
        double *const last = piece + at * rule->n_coefficients;
        pl_validity validity;
        if (decides(rule, last, error + depth[at] * rounding, &validity)) {
            if (validity == PL_INVALID)
                return PL_INVALID;
            n--;
            continue;
        }
        if (rule->n_turns == 0 || depth[at] == PL_VALIDITY_DEPTH || ++n_boxes > PL_VALIDITY_BOXES)
            return PL_UNCERTIFIED;
        halve(rule, rule->turn[depth[at] % rule->n_turns], last);
        depth[at + 1] = ++depth[at];
        n++;
    }
    return PL_VALID;
}

/** Decide one lane by bisections in doubles. */
static pl_validity bisect(const pl_jacobian_rule *rule, const pl_jacobian_block *b, int l) {
    const int64_t n_coefficients = rule->n_coefficients;
    double largest = 0;
    for (int c = 0; c < n_coefficients; c++)
        largest = fmax(largest, fabs(b->coefficient[c][l]));
    if (!(b->least[l] >= -largest && largest < LARGEST_COEFFICIENT)) /* some may be no numbers */
        return PL_UNCERTIFIED;
    double *piece = pl_alloc((PL_VALIDITY_DEPTH + 2) * n_coefficients, sizeof *piece);
    if (!piece)
        return PL_OUT_OF_MEMORY;
    for (int c = 0; c < n_coefficients; c++)
        piece[c] = b->coefficient[c][l];
    /* A bisection takes weighted means of at most 6 coefficients. Each product and sum is rounded;
       errors of the coefficients themselves get no larger. */
    const pl_validity validity = bisect_pieces(rule, piece, b->error[l], 8 * ROUNDING * largest);
    pl_free(piece);
    return validity;
}

/* ---- Integers ------------------------------------------------------------------------------ */

/** Memory of an exact decision. */
typedef struct exact_element {
    pl_exact node[PL_CELL_NODES][3]; /* [n_nodes][dim] twice their difference to the first one */
    pl_exact control[PL_CELL_NODES][3];
    pl_exact derivative[3][PL_JACOBIAN_DERIVATIVES][3];
} exact_element;

/** Set a to 0. Its sign is read, too. */
static void set_to_zero(pl_exact *a) {
    a->sign = 1;
    a->n = 0;
}

/** Add weight * from to *to. */
static void add_times(int weight, const pl_exact *from, pl_exact *to) {
    const uint32_t size = (uint32_t)(weight < 0 ? -weight : weight);
    const pl_exact factor = {.sign = weight < 0 ? -1 : 1, .n = size > 0, .limb = {size}};
    pl_exact product, before = *to;
    pl_exact_multiply(&factor, from, &product);
    pl_exact_add(&before, &product, 1, to);
}

/** Compute a b - c d. */
static void minor(const pl_exact *a, const pl_exact *b, const pl_exact *c, const pl_exact *d,
                  pl_exact *result) {
    pl_exact ab, cd;
    pl_exact_multiply(a, b, &ab);
    pl_exact_multiply(c, d, &cd);
    pl_exact_add(&ab, &cd, -1, result);
}

/** Find e->node of coordinates, of none of which pl_exact_unit is below unit. */
static void find_exact_nodes(const pl_jacobian_rule *rule, const int32_t node[],
                             const double *coordinates, int unit, exact_element *e) {
    const int dim = rule->type->shape->dim;
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < dim; d++) {
            pl_exact half[2];
            for (int end = 0; end < 2; end++) {
                const int at = node[i] >= 0 ? i : rule->type->between[i][end];
                pl_exact_difference(coordinates[(int64_t)node[at] * dim + d],
                                    coordinates[(int64_t)node[0] * dim + d], unit, &half[end]);
            }
            pl_exact_add(&half[0], &half[1], 1, &e->node[i][d]);
        }
}

static void find_exact_derivatives(const pl_jacobian_rule *rule, exact_element *e) {
    const int dim = rule->type->shape->dim;
    pl_exact(*from)[3] = e->node;
    if (rule->n_control_terms > 0) {
        for (int c = 0; c < rule->n_controls; c++)
            for (int d = 0; d < dim; d++)
                set_to_zero(&e->control[c][d]);
        for (int t = 0; t < rule->n_control_terms; t++)
            for (int d = 0; d < dim; d++)
                add_times(rule->control_term[t].weight, &e->node[rule->control_term[t].from][d],
                          &e->control[rule->control_term[t].to][d]);
        from = e->control;
    }
    for (int m = 0; m < dim; m++)
        for (int i = 0; i < rule->n_derivatives[m]; i++)
            for (int d = 0; d < dim; d++)
                pl_exact_add(&from[rule->derivative[m][i].plus][d],
                             &from[rule->derivative[m][i].minus][d], -1, &e->derivative[m][i][d]);
}

/** Find the coefficients b [n_coefficients] from e's derivatives. */
static void find_exact_coefficients(const pl_jacobian_rule *rule, const exact_element *e,
                                    double sign, pl_exact b[]) {
    const int dim = rule->type->shape->dim;
    for (int c = 0; c < rule->n_coefficients; c++)
        set_to_zero(&b[c]);
    for (int p = 0; p < rule->n_products; p++) {
        const pl_jacobian_product *product = &rule->product[p];
        const int weight = product->weight * rule->factor[product->coefficient] * (int)sign;
        const pl_exact *u = e->derivative[0][product->i], *v = e->derivative[1][product->j];
        const pl_exact *w = e->derivative[2][product->k];
        pl_exact determinant;
        if (dim == 2) {
            minor(&u[0], &v[1], &u[1], &v[0], &determinant);
            add_times(weight, &determinant, &b[product->coefficient]);
            continue;
        }
        for (int d = 0; d < 3; d++) {
            const int next = (d + 1) % 3, last = (d + 2) % 3;
            pl_exact normal;
            minor(&v[next], &w[last], &v[last], &w[next], &normal);
            pl_exact_multiply(&u[d], &normal, &determinant);
            add_times(weight, &determinant, &b[product->coefficient]);
        }
    }
}

static int exact_sign(const pl_exact *a) {
    return a->n == 0 ? 0 : a->sign;
}

/** Decide by the exact coefficients of a piece, if they do. Coefficients of 0 leave det J positive:
 *  a point is inside of the piece, or of a face or an edge of it, where the polynomial of each
 *  corner is positive, and so is the corner's coefficient. */
static int decides_exactly(const pl_jacobian_rule *rule, const pl_exact b[],
                           pl_validity *validity) {
    *validity = PL_INVALID;
    for (int c = 0; c < rule->n_corners; c++)
        if (exact_sign(&b[rule->corner[c]]) <= 0)
            return 1;
    *validity = PL_VALID;
    for (int c = 0; c < rule->n_coefficients; c++)
        if (exact_sign(&b[c]) < 0)
            return 0;
    return 1;
}

/** Decide by bisections of the coefficients in piece [PL_VALIDITY_DEPTH + 2][n_coefficients], of
 *  which the first is filled in and one more is for use. */
static pl_validity bisect_exactly(const pl_jacobian_rule *rule, pl_exact *piece) {
    const int n_coefficients = rule->n_coefficients;
    pl_exact *const whole = piece + (PL_VALIDITY_DEPTH + 1) * n_coefficients;
    int depth[PL_VALIDITY_DEPTH + 1] = {0}, n = 1, n_boxes = 0;
    while (n > 0) {
        const int at = n - 1;
        pl_validity validity;
        if (decides_exactly(rule, piece + at * n_coefficients, &validity)) {
            if (validity == PL_INVALID)
                return PL_INVALID;
            n--;
            continue;
        }
        if (rule->n_turns == 0 || depth[at] == PL_VALIDITY_DEPTH || ++n_boxes > PL_VALIDITY_BOXES)
            return PL_UNCERTIFIED;
        const int h = rule->turn[depth[at] % rule->n_turns];
        for (int c = 0; c < n_coefficients; c++)
            whole[c] = piece[at * n_coefficients + c];
        for (int half = 0; half < 2; half++) {
            pl_exact *const to = piece + (at + half) * n_coefficients;
            for (int c = 0; c < n_coefficients; c++)
                set_to_zero(&to[c]);
            for (int t = 0; t < rule->n_half_terms[h][half]; t++) {
                const pl_jacobian_term *term = &rule->half_term[h][half][t];
                add_times(term->weight, &whole[term->from], &to[term->to]);
            }
        }
        depth[at + 1] = ++depth[at];
        n++;
    }
    return PL_VALID;
}

pl_validity pl_validity_exactly(const pl_jacobian_rule *rule, const int32_t node[],
                                const double *coordinates, double sign) {
    const int dim = rule->type->shape->dim;
    int unit = INT_MAX;
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < dim && node[i] >= 0; d++) {
            const double a = coordinates[(int64_t)node[i] * dim + d];
            const int own = a != 0 ? pl_exact_unit(a) : INT_MAX;
            unit = own < unit ? own : unit;
        }
    if (unit == INT_MAX)
        return PL_INVALID; /* all at one place */
    exact_element *e = pl_alloc(1, sizeof *e);
    pl_exact *piece =
        pl_alloc((PL_VALIDITY_DEPTH + 2) * (int64_t)rule->n_coefficients, sizeof *piece);
    pl_validity validity = PL_OUT_OF_MEMORY;
    if (e && piece) {
        find_exact_nodes(rule, node, coordinates, unit, e);
        find_exact_derivatives(rule, e);
        find_exact_coefficients(rule, e, sign, piece);
        validity = bisect_exactly(rule, piece);
    }
    pl_free(e);
    pl_free(piece);
    return validity;
}

pl_validity pl_validity_of_lane(const pl_jacobian_rule *rule, const pl_jacobian_block *b, int l,
                                const int32_t node[], const double *coordinates, double sign) {
    if (b->least[l] > b->error[l])
        return PL_VALID;
    const pl_validity validity = bisect(rule, b, l);
    return validity != PL_UNCERTIFIED ? validity
                                      : pl_validity_exactly(rule, node, coordinates, sign);
}
