/* rows: coefficients and their slopes are sums of products; elements are looked up by nodes. */
#include "sweep/rows.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/cube_root.h"
#include "geometry/simplex.h"

#include <math.h>
#include <string.h>

enum { NODES = PL_CELL_NODES, DERIVATIVES = PL_JACOBIAN_DERIVATIVES };

/* ---- rules ---------------------------------------------------------------------------------- */

/** Simplex of the shape that direction d is in; *vertex: the one it leads to. */
static int simplex_of(const pl_cell_shape *shape, int d, int *vertex) {
    int s = 0;
    while (d >= shape->n_vertices[s] - 1)
        d -= shape->n_vertices[s++] - 1;
    *vertex = d + 1;
    return s;
}

/** Value of a Bernstein polynomial at the point xi [dim]. along: its exponents in each direction;
 *  degree: in each simplex. */
static double bernstein(const pl_cell_shape *shape, const int degree[], const uint8_t along[],
                        const double xi[]) {
    double value = 1;
    for (int s = 0, d = 0; s < shape->n_simplices; s++) {
        double first = 1;
        int rest = degree[s];
        for (int v = 1; v < shape->n_vertices[s]; v++, d++) {
            first -= xi[d];
            for (int e = 1; e <= along[d]; e++)
                value *= xi[d] * rest-- / e; /* rest of degree things, e alike */
        }
        for (; rest > 0; rest--)
            value *= first;
    }
    return value;
}

/** Find the derivatives of the shape functions at the point xi: as those of the map, whose
 *  derivatives are sums of differences of two controls. */
static void find_gradients(const pl_row_rule *rule, const double xi[], double gradient[][3]) {
    const pl_jacobian_rule *jacobian = &rule->jacobian;
    const pl_cell_type *type = jacobian->type;
    double control[NODES][NODES] = {{0}};
    for (int t = 0; t < jacobian->n_control_terms; t++) {
        const pl_jacobian_term *term = &jacobian->control_term[t];
        control[term->to][term->from] += term->weight / rule->control_unit;
    }
    for (int c = 0; jacobian->n_control_terms == 0 && c < jacobian->n_controls; c++)
        control[c][c] = 1;
    for (int d = 0; d < type->shape->dim; d++) {
        int vertex, degree[PL_CELL_SIMPLICES];
        const int own = simplex_of(type->shape, d, &vertex);
        for (int s = 0; s < PL_CELL_SIMPLICES; s++)
            degree[s] = type->order - (s == own);
        for (int node = 0; node < type->n_nodes; node++)
            gradient[node][d] = 0;
        for (int i = 0; i < jacobian->n_derivatives[d]; i++) {
            const pl_jacobian_derivative *of = &jacobian->derivative[d][i];
            const double value = type->order * bernstein(type->shape, degree,
                                                         jacobian->control_point[of->minus], xi);
            for (int node = 0; node < type->n_nodes; node++)
                gradient[node][d] += value * (control[of->plus][node] - control[of->minus][node]);
        }
    }
}

/** Find the coefficients' unit: what they are of the reference element, whose det J is 1. */
static double find_unit(const pl_row_rule *rule) {
    const pl_cell_type *type = rule->jacobian.type;
    const pl_cell_shape *shape = type->shape;
    double x[NODES * 3], coefficient[PL_JACOBIAN_COEFFICIENTS];
    for (int node = 0; node < type->n_nodes; node++)
        for (int d = 0; d < shape->dim; d++) {
            int vertex;
            const int s = simplex_of(shape, d, &vertex);
            x[node * shape->dim + d] = 0.5 * (shape->vertex[type->between[node][0]][s] == vertex) +
                                       0.5 * (shape->vertex[type->between[node][1]][s] == vertex);
        }
    pl_row_coefficients(rule, x, 1, coefficient);
    return coefficient[0];
}

/** |T|^2 by the weights of the edges of an ideal corner. */
static void find_metric(const pl_cell_shape *shape, double metric[6]) {
    static const int PAIR[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    memset(metric, 0, 6 * sizeof *metric);
    for (int a = 0, pair = 0; a < shape->dim; a++) {
        metric[PAIR[a][a]] += shape->to_corner[a];
        for (int b = a + 1; b < shape->dim; b++, pair++) {
            metric[PAIR[a][a]] += shape->between[pair];
            metric[PAIR[b][b]] += shape->between[pair];
            metric[PAIR[a][b]] -= shape->between[pair];
        }
    }
}

pl_row_rule *pl_row_rule_make(const pl_cell_type *type) {
    const pl_cell_shape *shape = type->shape;
    pl_row_rule *rule = pl_alloc_zero(1, sizeof *rule);
    if (!rule)
        return NULL;
    pl_jacobian_rule_make(type, &rule->jacobian);
    const pl_jacobian_rule *jacobian = &rule->jacobian;
    rule->gradient = pl_alloc(jacobian->n_coefficients, sizeof *rule->gradient);
    if (!rule->gradient) {
        pl_row_rule_free(rule);
        return NULL;
    }
    rule->unit = 1;
    rule->control_unit = jacobian->n_control_terms > 0 ? jacobian->control_term[0].weight : 1;
    rule->unit = find_unit(rule);
    rule->k = shape->dim == 3 ? 4.0 / 3 : 2;
    const double w = shape->determinant;
    rule->factor = shape->dim == 3 ? w * pl_cube_root(w) / 9 : w * w / 4;
    find_metric(shape, rule->metric);
    for (int c = 0; c < jacobian->n_coefficients; c++) {
        double xi[3];
        for (int d = 0; d < shape->dim; d++) {
            int vertex;
            xi[d] = (double)jacobian->coefficient_point[c][d] /
                    jacobian->degree[simplex_of(shape, d, &vertex)];
        }
        find_gradients(rule, xi, rule->gradient[c]);
    }
    return rule;
}

void pl_row_point(const pl_row_rule *rule, const double *xi, double blend[], double gradient[][3]) {
    const pl_jacobian_rule *jacobian = &rule->jacobian;
    int degree[PL_CELL_SIMPLICES];
    for (int s = 0; s < PL_CELL_SIMPLICES; s++)
        degree[s] = jacobian->degree[s];
    for (int c = 0; c < jacobian->n_coefficients; c++)
        blend[c] = bernstein(jacobian->type->shape, degree, jacobian->coefficient_point[c], xi);
    find_gradients(rule, xi, gradient);
}

void pl_row_rule_free(pl_row_rule *rule) {
    if (rule)
        pl_free(rule->gradient);
    pl_free(rule);
}

/* ---- an element ----------------------------------------------------------------------------- */

void pl_row_handle(const pl_row_rule *rule, int node, double rate[]) {
    const pl_jacobian_rule *jacobian = &rule->jacobian;
    if (node >= jacobian->n_corners) {
        rate[node] += 1;
        return;
    }
    for (int j = 0; j < jacobian->n_nodes; j++) {
        int n = 0;
        for (int c = 0; c < jacobian->n_corners; c++)
            n += jacobian->straight[j] >> c & 1;
        rate[j] += jacobian->straight[j] >> node & 1 ? 1.0 / n : 0;
    }
}

/** Derivatives of an element's map, by the rule's directions: [dim][n_derivatives]. */
typedef double derivatives[3][DERIVATIVES][3];

/** Find the derivatives of a map with the nodes x [n_nodes][width], less the first one if
 *  is_relative. */
static void find_derivatives(const pl_jacobian_rule *rule, const double *x, int width,
                             int is_relative, derivatives to) {
    double node[NODES][3] = {{0}}, control[NODES][3] = {{0}};
    for (int i = 0; i < rule->n_nodes; i++)
        for (int d = 0; d < width; d++)
            node[i][d] = x[i * width + d] - (is_relative ? x[d] : 0);
    for (int t = 0; t < rule->n_control_terms; t++) {
        const pl_jacobian_term *term = &rule->control_term[t];
        for (int d = 0; d < width; d++)
            control[term->to][d] += term->weight * node[term->from][d];
    }
    double(*const from)[3] = rule->n_control_terms > 0 ? control : node;
    for (int m = 0; m < rule->type->shape->dim; m++)
        for (int i = 0; i < rule->n_derivatives[m]; i++) {
            const pl_jacobian_derivative *of = &rule->derivative[m][i];
            for (int d = 0; d < 3; d++)
                to[m][i][d] = from[of->plus][d] - from[of->minus][d];
        }
}

/** A coefficient while it is summed up. */
typedef struct coefficient {
    double D0, slope[3];
    int depends; /* on the handle */
} coefficient;

/** Sum up the coefficients of derivatives v, and their slopes; speed: of the derivatives, in the
 *  first component. In 2-D the third direction is the normal of the plane. */
static void sum_products(const pl_jacobian_rule *rule, derivatives v, derivatives speed,
                         coefficient *to) {
    const int dim = rule->type->shape->dim;
    static const double NORMAL[3] = {0, 0, 1};
    for (int p = 0; p < rule->n_products; p++) {
        const pl_jacobian_product *of = &rule->product[p];
        coefficient *c = &to[of->coefficient];
        const double *a = v[0][of->i], *b = v[1][of->j], *w = dim == 3 ? v[2][of->k] : NORMAL;
        const double ra = speed[0][of->i][0], rb = speed[1][of->j][0];
        const double rw = dim == 3 ? speed[2][of->k][0] : 0;
        double bw[3], wa[3], ab[3];
        pl_cross(b, w, bw);
        c->D0 += of->weight * pl_dot(3, a, bw);
        if (ra == 0 && rb == 0 && rw == 0)
            continue;
        pl_cross(w, a, wa);
        pl_cross(a, b, ab);
        c->depends = 1;
        for (int d = 0; d < dim; d++)
            c->slope[d] += of->weight * (ra * bw[d] + rb * wa[d] + rw * ab[d]);
    }
}

/** Fill in E of a row at the point of coefficient c; returns whether it depends on the handle. way
 *  [n_nodes]: of the nodes from the first one. */
PL_INLINE int fill_ratio(const pl_row_rule *rule, int c, const double way[][3], const double rate[],
                         pl_star_row *row, const int dim) {
    double J[3][3] = {{0}}, g[3] = {0};
    for (int j = 0; j < rule->jacobian.n_nodes; j++)
        for (int a = 0; a < dim; a++) {
            const double slope = rule->gradient[c][j][a];
            g[a] += rate[j] * slope;
            for (int d = 0; d < dim; d++)
                J[a][d] += slope * way[j][d];
        }
    for (int a = 0, pair = 0; a < 3; a++)
        for (int b = a; b < 3; b++, pair++) {
            const double m = rule->metric[pair] * (a == b ? 1 : 2);
            row->e += m * pl_dot(3, J[a], J[b]);
            row->c += m * g[a] * g[b];
            for (int d = 0; d < dim; d++)
                row->slope_e[d] += 0.5 * m * (g[a] * J[b][d] + g[b] * J[a][d]);
        }
    return row->c > 0;
}

int pl_rows_of_element(const pl_row_rule *rule, const double *x, double sign, const double rate[],
                       double weight, pl_star_row *row, uint8_t *index) {
    const pl_jacobian_rule *jacobian = &rule->jacobian;
    const int dim = jacobian->type->shape->dim;
    derivatives v, speed;
    coefficient sum[PL_JACOBIAN_COEFFICIENTS];
    double way[NODES][3] = {{0}};
    int n = 0;
    memset(sum, 0, (size_t)jacobian->n_coefficients * sizeof *sum);
    for (int i = 0; i < jacobian->n_nodes; i++)
        for (int d = 0; d < dim; d++)
            way[i][d] = x[i * dim + d] - x[d];
    find_derivatives(jacobian, x, dim, 1, v);
    find_derivatives(jacobian, rate, 1, 0, speed);
    sum_products(jacobian, v, speed, sum);
    for (int c = 0; c < jacobian->n_coefficients; c++) {
        const double unit = jacobian->factor[c] / rule->unit * sign;
        pl_star_row *to = &row[n];
        *to = (pl_star_row){.weight = weight / jacobian->n_coefficients,
                            .factor = rule->factor,
                            .D0 = sum[c].D0 * unit};
        for (int d = 0; d < dim; d++)
            to->slope_d[d] = sum[c].slope[d] * unit;
        const int depends = dim == 3 ? fill_ratio(rule, c, (const double(*)[3])way, rate, to, 3)
                                     : fill_ratio(rule, c, (const double(*)[3])way, rate, to, 2);
        if (!depends && !sum[c].depends)
            continue;
        if (index)
            index[n] = (uint8_t)c;
        n++;
    }
    return n;
}

void pl_row_coefficients(const pl_row_rule *rule, const double *x, double sign,
                         double coefficients[]) {
    const pl_jacobian_rule *jacobian = &rule->jacobian;
    derivatives v, still = {{{0}}};
    coefficient sum[PL_JACOBIAN_COEFFICIENTS];
    memset(sum, 0, (size_t)jacobian->n_coefficients * sizeof *sum);
    find_derivatives(jacobian, x, jacobian->type->shape->dim, 1, v);
    sum_products(jacobian, v, still, sum);
    for (int c = 0; c < jacobian->n_coefficients; c++)
        coefficients[c] = sum[c].D0 * jacobian->factor[c] / rule->unit * sign;
}

/* ---- marked elements of a plan -------------------------------------------------------------- */

const pl_cell_type *pl_places_of_element(const pl_watch *watch, int64_t element, double *x,
                                         int32_t *node) {
    const planish_plan *plan = watch->plan;
    const int dim = plan->dim;
    const int64_t cell = pl_plan_element(plan, element);
    const pl_cell_type *type = pl_cell_type_of(plan->cells.type[cell]);
    const int32_t *given = plan->cells.node + plan->cells.offset[cell];
    const int32_t *corner = plan->work.elements + element * (dim + 1);
    for (int i = 0; i < type->n_nodes; i++) {
        double *to = x + i * dim;
        const int p = type->between[i][0], q = type->between[i][1];
        if (node)
            node[i] = given[i];
        if (i < type->shape->n_corners) {
            const int32_t own = plan->work.corner ? given[i] : corner[i];
            memcpy(to, plan->scratch.coordinates + (int64_t)plan->inner[own] * dim,
                   (size_t)dim * sizeof *to);
        } else if (given[i] >= 0) {
            pl_mid_place(&watch->mids, given[i], to);
        } else {
            for (int d = 0; d < dim; d++)
                to[d] = 0.5 * x[p * dim + d] + 0.5 * x[q * dim + d];
        }
    }
    return type;
}

/** Type of a marked element. */
static const pl_cell_type *type_of(const planish_plan *plan, int64_t element) {
    return pl_cell_type_of(plan->cells.type[pl_plan_element(plan, element)]);
}

/** Node of the plan that is corner i of an element. */
static int32_t corner_of(const planish_plan *plan, int64_t element, int i) {
    const int64_t cell = pl_plan_element(plan, element);
    return plan->work.corner ? plan->cells.node[plan->cells.offset[cell] + i]
                             : plan->work.elements[element * (plan->dim + 1) + i];
}

/** The movable corners of a marked element, by inner numbers. */
static int nodes_of(const void *context, int64_t i, int32_t node[PL_CELL_NODES]) {
    const pl_marked *m = context;
    const planish_plan *plan = m->watch->plan;
    const int n = type_of(plan, m->element[i])->shape->n_corners;
    for (int j = 0; j < n; j++) {
        const int32_t corner = corner_of(plan, m->element[i], j);
        node[j] = plan->work.mobility[corner] != 0 ? plan->inner[corner] : -1;
    }
    return n;
}

static int has_rows(const planish_plan *plan, int64_t element) {
    return type_of(plan, element)->shape->n_simplices > 0;
}

/** Make the rule of each type that is marked. */
static int make_rules(pl_marked *m) {
    for (int64_t i = 0; i < m->n; i++) {
        const pl_cell_type *type = type_of(m->watch->plan, m->element[i]);
        if (!m->rule[type->type])
            m->rule[type->type] = pl_row_rule_make(type);
        if (!m->rule[type->type])
            return 0;
    }
    return 1;
}

/** Find which stars have marked elements, and how many rows at most. */
static void find_stars(pl_marked *m) {
    const pl_visits *visits = &m->watch->plan->interior;
    for (int64_t s = 0; s < visits->stars.n_stars; s++) {
        const int32_t node = visits->centre[s];
        int64_t n = 0;
        for (int64_t k = m->begin[node]; k < m->begin[node + 1]; k++)
            n += m->rule[type_of(m->watch->plan, m->element[m->place[k]])->type]
                     ->jacobian.n_coefficients;
        m->has_more[s] = n > 0;
        m->max_more = n > m->max_more ? n : m->max_more;
    }
}

/** Make the lists of the elements that are marked. */
static int make_lists(pl_marked *m, const uint8_t *is_marked) {
    const planish_plan *plan = m->watch->plan;
    pl_incidence marked;
    int64_t n = 0;
    for (int64_t e = 0; e < plan->work.n_elements; e++)
        n += is_marked[e] && has_rows(plan, e);
    m->element = pl_alloc(n, sizeof *m->element);
    m->has_more = pl_alloc(plan->interior.stars.n_stars, sizeof *m->has_more);
    if (!m->element || !m->has_more)
        return 0;
    for (int64_t e = 0; e < plan->work.n_elements; e++)
        if (is_marked[e] && has_rows(plan, e))
            m->element[m->n++] = (int32_t)e;
    if (!pl_items_of_nodes(plan->work.n_nodes, m->n, nodes_of, m, 1, &marked))
        return 0;
    m->begin = marked.offset;
    m->place = marked.element;
    return make_rules(m);
}

int pl_marked_make(const pl_watch *watch, const uint8_t *is_marked, double weight, pl_marked *m,
                   planish_error *error) {
    *m = (pl_marked){.watch = watch, .weight = weight};
    if (!make_lists(m, is_marked))
        return pl_fail_memory(error, "the coefficients of elements");
    find_stars(m);
    const planish_plan *plan = watch->plan;
    const pl_stars *stars = &plan->interior.stars;
    m->scratch_stride =
        pl_star_scratch_size(plan->dim, stars->max_ring, stars->max_link, m->max_more) /
        (int64_t)sizeof *m->scratch;
    m->scratch = pl_alloc(m->scratch_stride * plan->threads, sizeof *m->scratch);
    return m->scratch ? PLANISH_OK : pl_fail_memory(error, "the coefficients of elements");
}

void pl_marked_destroy(pl_marked *m) {
    pl_free(m->element);
    pl_free(m->begin);
    pl_free(m->place);
    pl_free(m->has_more);
    pl_free(m->scratch);
    for (int t = 0; t < PL_WATCH_TYPES; t++)
        pl_row_rule_free(m->rule[t]);
    *m = (pl_marked){.n = 0};
}

/** Share of each node of the patch in the rows of an element. */
static double share_of(const pl_marked *m, int64_t element, const pl_cell_type *type) {
    const planish_plan *plan = m->watch->plan;
    int n = 0;
    for (int j = 0; m->in_patch && j < type->shape->n_corners; j++) {
        const int32_t node = corner_of(plan, element, j);
        int is_first = m->in_patch[plan->inner[node]];
        for (int k = 0; k < j; k++)
            is_first &= corner_of(plan, element, k) != node;
        n += is_first;
    }
    return n > 0 ? 1.0 / n : 1;
}

/** Mean length of edges that is wanted at the corners of an element. */
static double size_of(const pl_marked *m, int64_t element, const pl_cell_type *type) {
    const planish_plan *plan = m->watch->plan;
    const int n = type->shape->n_corners;
    double sum = 0;
    for (int j = 0; m->size && j < n; j++)
        sum += m->size[plan->inner[corner_of(plan, element, j)]];
    return m->size ? sum / n : 1;
}

/** Rows of marked elements at a star's node, at the plan's present coordinates (pl_star_more_fn);
 *  marked: a pl_marked. */
static int64_t marked_rows(const void *marked, int64_t star, pl_star_row *row) {
    const pl_marked *m = marked;
    const planish_plan *plan = m->watch->plan;
    const int32_t node = plan->interior.centre[star];
    int64_t n = 0;
    for (int64_t k = m->begin[node]; k < m->begin[node + 1]; k++) {
        const int64_t element = m->element[m->place[k]];
        double x[NODES * 3], rate[NODES] = {0};
        const pl_cell_type *type = pl_places_of_element(m->watch, element, x, NULL);
        const pl_row_rule *rule = m->rule[type->type];
        for (int j = 0; j < type->shape->n_corners; j++)
            if (plan->inner[corner_of(plan, element, j)] == node)
                pl_row_handle(rule, j, rate);
        const double share = share_of(m, element, type);
        const int rows = pl_rows_of_element(rule, x, plan->work.sign ? plan->work.sign[element] : 1,
                                            rate, m->weight, row + n, NULL);
        const double size = size_of(m, element, type);
        for (int i = 0; i < rows; i++) {
            row[n + i].share = share;
            row[n + i].size = size;
        }
        n += rows;
    }
    return n;
}

void pl_marked_use(const pl_marked *m, pl_star_problem *problem) {
    problem->more = m->n > 0 ? marked_rows : NULL;
    problem->more_user = m;
    problem->has_more = m->has_more;
    problem->max_more = m->max_more;
    problem->scratch = m->scratch;
    problem->scratch_stride = m->scratch_stride;
}
