/* rational: small problems with linear constraints, solved without rounding. */
#include "support/rational.h"

#ifdef PLANISH_HAVE_GMP

#include <stdio.h>
#include <stdlib.h>

void rational_add_product(mpq_t sum, const mpq_t a, const mpq_t b) {
    mpq_t product;
    if (mpq_sgn(a) == 0 || mpq_sgn(b) == 0)
        return;
    mpq_init(product);
    mpq_mul(product, a, b);
    mpq_add(sum, sum, product);
    mpq_clear(product);
}

void rational_dot(mpq_t result, const mpq_t *a, const mpq_t *b, int n) {
    mpq_set_ui(result, 0, 1);
    for (int d = 0; d < n; d++)
        rational_add_product(result, a[d], b[d]);
}

/** a -= factor b, n numbers; t is scratch. */
static void subtract_multiple(mpq_t *a, const mpq_t factor, const mpq_t *b, int n, mpq_t t) {
    for (int i = 0; i < n; i++) {
        mpq_mul(t, factor, b[i]);
        mpq_sub(a[i], a[i], t);
    }
}

static void init_all(mpq_t *a, int n) {
    for (int i = 0; i < n; i++)
        mpq_init(a[i]);
}

static void clear_all(mpq_t *a, int n) {
    for (int i = 0; i < n; i++)
        mpq_clear(a[i]);
}

/* ---- projection on a cone ------------------------------------------------------------------- */

static void for_all_of_cone(rational_cone *c, void (*act)(mpq_t *, int)) {
    for (int j = 0; j < RATIONAL_ROWS; j++)
        act(c->row[j], RATIONAL_DIM);
    for (int i = 0; i < RATIONAL_DIM; i++)
        act(c->gram[i], RATIONAL_DIM + 1);
    act(c->p, RATIONAL_DIM);
    act(c->y, RATIONAL_DIM);
    act(c->multiplier, RATIONAL_DIM);
    act(c->t, 2);
}

void rational_cone_init(rational_cone *c) {
    for_all_of_cone(c, init_all);
}

void rational_cone_clear(rational_cone *c) {
    for_all_of_cone(c, clear_all);
}

void rational_cone_set(rational_cone *c, const double (*rows)[RATIONAL_DIM], int64_t m,
                       const double *p, int n) {
    c->m = (int)m;
    c->n = n;
    for (int d = 0; d < n; d++) {
        mpq_set_d(c->p[d], p[d]);
        for (int j = 0; j < m; j++)
            mpq_set_d(c->row[j][d], rows[j][d]);
    }
}

/** Bring column k of the normal equations to that of the identity; 0 if the rows are dependent. A
 *  Gram matrix needs no exchange of rows: its pivots are 0 only then. */
static int eliminate(rational_cone *c, int k) {
    const int width = c->n_set + 1;
    if (mpq_sgn(c->gram[k][k]) == 0)
        return 0;
    for (int j = width - 1; j >= k; j--)
        mpq_div(c->gram[k][j], c->gram[k][j], c->gram[k][k]);
    for (int i = 0; i < c->n_set; i++) {
        if (i == k || mpq_sgn(c->gram[i][k]) == 0)
            continue;
        mpq_set(c->t[0], c->gram[i][k]);
        subtract_multiple(c->gram[i] + k, c->t[0], c->gram[k] + k, width - k, c->t[1]);
    }
    return 1;
}

/** Multipliers of the set by the normal equations; 0 if some are negative, or the rows dependent.
 */
static int find_multipliers(rational_cone *c) {
    for (int i = 0; i < c->n_set; i++) {
        const mpq_t *row = c->row[c->set[i]];
        for (int j = 0; j < c->n_set; j++)
            rational_dot(c->gram[i][j], row, c->row[c->set[j]], c->n);
        rational_dot(c->gram[i][c->n_set], row, c->p, c->n);
    }
    for (int k = 0; k < c->n_set; k++)
        if (!eliminate(c, k))
            return 0;
    for (int i = 0; i < c->n_set; i++) {
        mpq_set(c->multiplier[i], c->gram[i][c->n_set]);
        if (mpq_sgn(c->multiplier[i]) < 0)
            return 0;
    }
    return 1;
}

/** Whether the set is that of the projection: the conditions of Karush, Kuhn and Tucker, which are
 *  sufficient. That rows of the set are 0 at y is how the multipliers were found. */
static int is_projection(rational_cone *c) {
    if (!find_multipliers(c))
        return 0;
    for (int d = 0; d < c->n; d++)
        mpq_set(c->y[d], c->p[d]);
    for (int i = 0; i < c->n_set; i++)
        subtract_multiple(c->y, c->multiplier[i], c->row[c->set[i]], c->n, c->t[0]);
    for (int j = 0; j < c->m; j++) {
        rational_dot(c->t[0], c->row[j], c->y, c->n);
        if (mpq_sgn(c->t[0]) > 0)
            return 0;
    }
    return 1;
}

/** Sets that extend the present one by rows from number first on. */
static int search_sets(rational_cone *c, int first) {
    if (is_projection(c))
        return 1;
    if (c->n_set == c->n)
        return 0;
    const int k = c->n_set;
    for (int j = first; j < c->m; j++) {
        c->set[k] = j;
        c->n_set = k + 1;
        if (search_sets(c, j + 1))
            return 1;
        c->n_set = k;
    }
    return 0;
}

int rational_cone_project(rational_cone *c, const int64_t *set, int n_set) {
    c->n_set = n_set;
    for (int i = 0; i < n_set; i++)
        c->set[i] = (int)set[i];
    if (is_projection(c))
        return 1;
    c->n_set = 0;
    if (!search_sets(c, 0)) {
        fprintf(stderr, "rational: no set of rows gives the projection\n");
        abort();
    }
    return 0;
}

/* ---- linear inequalities -------------------------------------------------------------------- */

/* Phase 1 of the simplex method for weights >= 0 with sum weight_j (row_j, least_j) = (0, 1): there
 * are n + 1 equations, with an artificial variable each, whose sum is minimised. Bland's rule keeps
 * it from cycling. If the sum ends at 0 there are weights; if not, the dual variables are an x. */

static void for_all_of_system(rational_system *s, void (*act)(mpq_t *, int)) {
    for (int j = 0; j < RATIONAL_ROWS; j++)
        act(s->row[j], RATIONAL_DIM);
    for (int i = 0; i <= RATIONAL_DIM; i++)
        act(s->tableau[i], RATIONAL_ROWS + RATIONAL_DIM + 1);
    act(s->least, RATIONAL_ROWS);
    act(s->weight, RATIONAL_ROWS);
    act(s->x, RATIONAL_DIM);
    act(s->t, 2);
}

void rational_system_init(rational_system *s) {
    for_all_of_system(s, init_all);
}

void rational_system_clear(rational_system *s) {
    for_all_of_system(s, clear_all);
}

/** The tableau: a row for each equation, with the right side at the end, and below the reduced
 *  costs, negated: their sum. */
static void fill_tableau(rational_system *s) {
    const int rows = s->n + 1, width = s->m + rows + 1;
    for (int j = 0; j < width; j++)
        mpq_set_ui(s->tableau[rows][j], 0, 1);
    for (int i = 0; i < rows; i++) {
        s->basis[i] = s->m + i;
        for (int j = 0; j < width; j++)
            mpq_set_ui(s->tableau[i][j], j == s->m + i || (j == width - 1 && i == s->n), 1);
        for (int j = 0; j < s->m; j++) {
            mpq_set(s->tableau[i][j], i < s->n ? s->row[j][i] : s->least[j]);
            mpq_add(s->tableau[rows][j], s->tableau[rows][j], s->tableau[i][j]);
        }
        mpq_add(s->tableau[rows][width - 1], s->tableau[rows][width - 1], s->tableau[i][width - 1]);
    }
}

/** The equation whose basic variable limits the entering one first; -1: none. */
static int leaving(rational_system *s, int column) {
    const int rows = s->n + 1, right = s->m + rows;
    int best = -1;
    for (int i = 0; i < rows; i++) {
        if (mpq_sgn(s->tableau[i][column]) <= 0)
            continue;
        mpq_div(s->t[0], s->tableau[i][right], s->tableau[i][column]);
        const int order = best < 0 ? -1 : mpq_cmp(s->t[0], s->t[1]);
        if (order > 0 || (order == 0 && s->basis[i] > s->basis[best]))
            continue;
        best = i;
        mpq_set(s->t[1], s->t[0]);
    }
    return best;
}

static void pivot(rational_system *s, int row, int column) {
    const int rows = s->n + 1, width = s->m + rows + 1;
    mpq_inv(s->t[0], s->tableau[row][column]);
    for (int j = 0; j < width; j++)
        mpq_mul(s->tableau[row][j], s->tableau[row][j], s->t[0]);
    for (int i = 0; i <= rows; i++) {
        if (i == row || mpq_sgn(s->tableau[i][column]) == 0)
            continue;
        mpq_set(s->t[0], s->tableau[i][column]);
        subtract_multiple(s->tableau[i], s->t[0], s->tableau[row], width, s->t[1]);
    }
    s->basis[row] = column;
}

static void minimise(rational_system *s) {
    for (;;) {
        int column = 0;
        while (column < s->m && mpq_sgn(s->tableau[s->n + 1][column]) <= 0)
            column++;
        const int row = column < s->m ? leaving(s, column) : -1;
        if (row < 0)
            return;
        pivot(s, row, column);
    }
}

static int weights_prove(rational_system *s) {
    int holds = 1;
    for (int j = 0; j < s->m; j++)
        mpq_set_ui(s->weight[j], 0, 1);
    for (int i = 0; i <= s->n; i++)
        if (s->basis[i] < s->m)
            mpq_set(s->weight[s->basis[i]], s->tableau[i][s->m + s->n + 1]);
    for (int d = 0; d <= s->n; d++) {
        mpq_set_ui(s->t[0], 0, 1);
        for (int j = 0; j < s->m; j++)
            rational_add_product(s->t[0], s->weight[j], d < s->n ? s->row[j][d] : s->least[j]);
        holds &= mpq_sgn(s->t[0]) == (d == s->n);
    }
    for (int j = 0; j < s->m; j++)
        holds &= mpq_sgn(s->weight[j]) >= 0;
    return holds;
}

/** The dual variables u, by their artificial columns: u . (row, least) <= 0, u_n > 0; x is their
 *  part of the rows by -u_n. */
static int point_proves(rational_system *s) {
    mpq_t one;
    int holds = 1;
    mpq_init(one);
    mpq_set_ui(one, 1, 1);
    mpq_add(s->t[1], s->tableau[s->n + 1][s->m + s->n], one);
    for (int d = 0; d < s->n; d++) {
        mpq_add(s->x[d], s->tableau[s->n + 1][s->m + d], one);
        mpq_div(s->x[d], s->x[d], s->t[1]);
        mpq_neg(s->x[d], s->x[d]);
    }
    mpq_clear(one);
    for (int j = 0; j < s->m; j++) {
        rational_dot(s->t[0], s->row[j], s->x, s->n);
        holds &= mpq_cmp(s->t[0], s->least[j]) >= 0;
    }
    return holds;
}

int rational_system_solve(rational_system *s) {
    fill_tableau(s);
    minimise(s);
    const int exists = mpq_sgn(s->tableau[s->n + 1][s->m + s->n + 1]) > 0;
    if (!(exists ? point_proves(s) : weights_prove(s))) {
        fprintf(stderr, "rational: the answer of the simplex method is not proved\n");
        abort();
    }
    return exists;
}

#endif
