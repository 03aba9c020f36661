/* jacobian: rules are made by counting exponents.
 *
 * A Bernstein polynomial on a product of simplices has an exponent for each vertex of each simplex.
 * Those of a simplex add up to the degree, so that the one of vertex 0 need not be kept: a point has
 * one exponent for each direction, from vertex 0 of a simplex to another vertex of it. */
#include "geometry/jacobian.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_DEGREE = 5 };

/** Exponents along each direction. */
typedef struct point {
    int along[3];
} point;

/** Directions of a shape. */
typedef struct directions {
    int n;          /* dim */
    int simplex[3]; /* of direction d, which leads from its vertex 0 */
    int vertex[3];  /* to this one */
} directions;

/** All points whose exponents add up to degree [simplex]. */
typedef struct lattice {
    const directions *of;
    int degree[PL_CELL_SIMPLICES];
    int n;
    point point[PL_JACOBIAN_COEFFICIENTS];
} lattice;

static directions directions_of(const pl_cell_shape *shape) {
    directions d = {.n = 0};
    for (int s = 0; s < shape->n_simplices; s++)
        for (int v = 1; v < shape->n_vertices[s]; v++) {
            d.simplex[d.n] = s;
            d.vertex[d.n++] = v;
        }
    return d;
}

/** Return the exponent of a vertex of a simplex. */
static int exponent(const lattice *l, point p, int simplex, int vertex) {
    int first = l->degree[simplex];
    for (int d = 0; d < l->of->n; d++) {
        if (l->of->simplex[d] != simplex)
            continue;
        if (l->of->vertex[d] == vertex)
            return p.along[d];
        first -= p.along[d];
    }
    return first; /* of vertex 0 */
}

static void add_to_exponent(const directions *of, point *p, int simplex, int vertex, int n) {
    for (int d = 0; d < of->n; d++)
        if (of->simplex[d] == simplex && of->vertex[d] == vertex)
            p->along[d] += n;
}

/** Fill l, whose degrees are set. */
static void fill(lattice *l) {
    const int base = MAX_DEGREE + 1, n = base * base * base;
    l->n = 0;
    for (int i = 0; i < n; i++) {
        const point p = {{i % base, i / base % base, i / base / base}};
        int is_inside = 1;
        for (int d = 0; d < 3; d++)
            is_inside &= d < l->of->n ? exponent(l, p, l->of->simplex[d], 0) >= 0 : p.along[d] == 0;
        if (is_inside)
            l->point[l->n++] = p;
    }
}

static int find(const lattice *l, point p) {
    int i = 0;
    while (i < l->n && memcmp(&l->point[i], &p, sizeof p) != 0)
        i++;
    return i;
}

/** Return the number of ways to put things in order of which so many are alike: the factor of a
 *  Bernstein polynomial. */
static int multinomial(const lattice *l, point p) {
    int product = 1;
    for (int s = 0, d = 0; s < PL_CELL_SIMPLICES; s++) {
        int rest = l->degree[s];
        for (; d < l->of->n && l->of->simplex[d] == s; d++)
            for (int e = 1; e <= p.along[d]; e++, rest--)
                product = product * rest; /* divided below, where it comes out whole */
    }
    for (int d = 0; d < l->of->n; d++)
        for (int e = 2; e <= p.along[d]; e++)
            product /= e;
    return product;
}

/* ---- Controls ------------------------------------------------------------------------------ */

/** Return the point of a lattice of the type's order where its node is. */
static point point_of_node(const pl_cell_type *type, const directions *of, int node) {
    point p = {{0}};
    for (int end = 0; end < type->order; end++)
        for (int s = 0; s < type->shape->n_simplices; s++)
            add_to_exponent(of, &p, s, type->shape->vertex[type->between[node][end]][s], 1);
    return p;
}

/** Find the ends of the middle of simplex s that p, of order 2, is in. Return 0 if it is at a vertex
 *  there. */
static int find_ends(const lattice *l, const pl_cell_shape *shape, point p, int s, int end[2]) {
    int n = 0;
    for (int v = 0; v < shape->n_vertices[s]; v++)
        if (exponent(l, p, s, v) == 1)
            end[n++ & 1] = v;
    return n;
}

/** Return in how many simplices p, of order 2, is in the middle of two vertices. */
static int n_middles(const lattice *l, const pl_cell_shape *shape, point p) {
    int n = 0, end[2];
    for (int s = 0; s < shape->n_simplices; s++)
        n += find_ends(l, shape, p, s, end) > 0;
    return n;
}

/** Whether node is of the edge, face or cell that p is in the middle of. */
static int is_around(const lattice *l, const pl_cell_shape *shape, point node, point p) {
    for (int s = 0; s < shape->n_simplices; s++)
        for (int v = 0; v < shape->n_vertices[s]; v++)
            if (exponent(l, node, s, v) > 0 && exponent(l, p, s, v) == 0)
                return 0;
    return 1;
}

/** Add times 4 times the map at p, of order 2, to the sum of nodes. Where there is no node, in the
 *  middle of k = 2 or 3 directions of a serendipity element, the map is that of the mids of edges
 *  around it by 1 / 2^(k - 1), less that of the corners by (k - 1) / 2^k. */
static void add_map(const pl_cell_type *type, const lattice *l, point p, int times, int sum[]) {
    const int middles = n_middles(l, type->shape, p);
    int other[PL_CELL_NODES] = {0};
    for (int node = 0; node < type->n_nodes; node++) {
        const point own = point_of_node(type, l->of, node);
        if (memcmp(&own, &p, sizeof p) == 0) {
            sum[node] += 4 * times;
            return;
        }
        if (!is_around(l, type->shape, own, p))
            continue;
        const int kind = n_middles(l, type->shape, own);
        other[node] = kind == 0 ? -1 : kind > 1 ? 0 : middles == 2 ? 2 : 1;
    }
    for (int node = 0; node < type->n_nodes; node++)
        sum[node] += times * other[node];
}

/** Find the Bezier point p of the map of order 2, times 4 2^simplices, as a sum of nodes. In each
 *  simplex it is the map itself at a vertex; between two, twice the map less half of that at
 *  either. */
static void find_control(const pl_cell_type *type, const lattice *l, point p, int sum[]) {
    const pl_cell_shape *shape = type->shape;
    for (int choice = 0; choice < 27; choice++) { /* of the middle and two ends, in each simplex */
        int times = 1, rest = choice;
        point at = p;
        for (int s = 0; s < PL_CELL_SIMPLICES; s++, rest /= 3) {
            int end[2];
            if (s >= shape->n_simplices || !find_ends(l, shape, p, s, end)) {
                times *= rest % 3 > 0 ? 0 : s < shape->n_simplices ? 2 : 1;
            } else if (rest % 3 == 0) {
                times *= 4;
            } else {
                times = -times;
                add_to_exponent(l->of, &at, s, end[rest % 3 - 1], 1);
                add_to_exponent(l->of, &at, s, end[2 - rest % 3], -1);
            }
        }
        if (times != 0)
            add_map(type, l, at, times, sum);
    }
}

/** Find the corners of the edge, face or cell that each node is in the middle of. */
static void find_straight(const pl_cell_type *type, const lattice *controls,
                          pl_jacobian_rule *rule) {
    for (int node = 0; node < type->n_nodes; node++)
        for (int c = 0; c < type->shape->n_corners; c++)
            if (is_around(controls, type->shape, point_of_node(type, controls->of, c),
                          point_of_node(type, controls->of, node)))
                rule->straight[node] |= (uint8_t)(1 << c);
}

static void make_controls(const pl_cell_type *type, const lattice *controls,
                          pl_jacobian_rule *rule) {
    rule->n_controls = controls->n;
    for (int c = 0; c < controls->n; c++) {
        int sum[PL_CELL_NODES] = {0}, weight = 0;
        find_control(type, controls, controls->point[c], sum);
        for (int node = 0; node < type->n_nodes; node++) {
            if (sum[node] == 0)
                continue;
            rule->control_term[rule->n_control_terms++] = (pl_jacobian_term){
                .weight = (int16_t)sum[node], .from = (uint16_t)node, .to = (uint16_t)c};
            weight += abs(sum[node]);
        }
        rule->control_weight = weight > rule->control_weight ? weight : rule->control_weight;
    }
}

/* ---- Products ------------------------------------------------------------------------------ */

/** Derivatives along d: differences of controls, on a lattice of one degree less in d's simplex. */
static void make_derivatives(const lattice *controls, int d, lattice *derivatives,
                             pl_jacobian_rule *rule) {
    const directions *of = controls->of;
    *derivatives = *controls;
    derivatives->degree[of->simplex[d]]--;
    fill(derivatives);
    rule->n_derivatives[d] = derivatives->n;
    for (int i = 0; i < derivatives->n; i++) {
        point plus = derivatives->point[i];
        plus.along[d]++;
        rule->derivative[d][i] =
            (pl_jacobian_derivative){.plus = (uint8_t)find(controls, plus),
                                     .minus = (uint8_t)find(controls, derivatives->point[i])};
    }
}

static int common_multiple(int a, int b) {
    int multiple = a;
    while (multiple % b != 0)
        multiple += a;
    return multiple;
}

/** Products of Bernstein polynomials are Bernstein polynomials: exponents add up, and factors are
 *  divided by the product's. All are multiplied by common to come out whole. */
static void make_products(const lattice derivatives[3], const lattice *coefficients,
                          pl_jacobian_rule *rule) {
    const int dim = coefficients->of->n;
    int n_of[PL_JACOBIAN_COEFFICIENTS] = {0};
    rule->n_coefficients = coefficients->n;
    rule->common = 1;
    for (int c = 0; c < coefficients->n; c++)
        rule->common =
            common_multiple(rule->common, multinomial(coefficients, coefficients->point[c]));
    for (int c = 0; c < coefficients->n; c++)
        rule->factor[c] =
            (uint16_t)(rule->common / multinomial(coefficients, coefficients->point[c]));
    for (int j = 0; j < derivatives[1].n; j++)
        for (int k = 0; k < (dim == 3 ? derivatives[2].n : 1); k++)
            for (int i = 0; i < derivatives[0].n; i++) {
                const int at[3] = {i, j, k};
                point p = {{0}};
                int weight = 1;
                for (int d = 0; d < dim; d++) {
                    const point factor = derivatives[d].point[at[d]];
                    weight *= multinomial(&derivatives[d], factor);
                    for (int e = 0; e < dim; e++)
                        p.along[e] += factor.along[e];
                }
                const int c = find(coefficients, p);
                rule->product[rule->n_products++] =
                    (pl_jacobian_product){.i = (uint8_t)i,
                                          .j = (uint8_t)j,
                                          .k = (uint8_t)k,
                                          .coefficient = (uint16_t)c,
                                          .weight = (uint16_t)weight};
                n_of[c]++;
                rule->n_products_each =
                    n_of[c] > rule->n_products_each ? n_of[c] : rule->n_products_each;
            }
}

/* ---- Bisections ---------------------------------------------------------------------------- */

/** Bisect simplex s at the middle m of its first and last vertex. The vertices of half 0 are then
 *  the first, m and those between; of half 1 the last, m and those between, so that the edges take
 *  turns. A coefficient is the polar form at the vertices that its exponents name; at m it is the
 *  mean of that at the two (de Casteljau). */
static void make_halves(const pl_cell_shape *shape, const lattice *coefficients, int s,
                        pl_jacobian_rule *rule) {
    const int last = shape->n_vertices[s] - 1;
    rule->half_shift[s] = coefficients->degree[s];
    for (int half = 0; half < 2; half++)
        for (int to = 0; to < coefficients->n; to++) {
            const point p = coefficients->point[to];
            const int at_middle = exponent(coefficients, p, s, 1);
            point from = p; /* exponents of the half's vertices moved to the whole's */
            for (int v = 1; v <= last; v++)
                add_to_exponent(coefficients->of, &from, s, v,
                                (v < last ? exponent(coefficients, p, s, v + 1) : 0) -
                                    exponent(coefficients, p, s, v));
            if (half == 1) /* what vertex 0 has, last has, too */
                add_to_exponent(coefficients->of, &from, s, last, exponent(coefficients, p, s, 0));
            int ways = 1;
            for (int k = 0; k <= at_middle; k++) { /* k of the exponents of m become last's */
                point source = from;
                add_to_exponent(coefficients->of, &source, s, last, k);
                const int n = rule->n_half_terms[s][half]++;
                rule->half_term[s][half][n] = (pl_jacobian_term){
                    .weight = (int16_t)(ways << (coefficients->degree[s] - at_middle)),
                    .from = (uint16_t)find(coefficients, source),
                    .to = (uint16_t)to};
                ways = ways * (at_middle - k) / (k + 1);
            }
        }
}

/* ---- Rules --------------------------------------------------------------------------------- */

/** Pyramid: det J over the base is bilinear, and of one sign along lines to the apex; its values at
 *  the corners of the base are its coefficients. */
static void make_pyramid(pl_jacobian_rule *rule) {
    static const pl_jacobian_derivative derivative[3][4] = {
        {{1, 0}, {2, 3}}, {{3, 0}, {2, 1}}, {{4, 0}, {4, 1}, {4, 2}, {4, 3}}};
    static const pl_jacobian_product product[] = {
        {0, 0, 0, 0, 1}, {0, 1, 1, 1, 1}, {1, 1, 2, 2, 1}, {1, 0, 3, 3, 1}};
    rule->n_nodes = rule->n_controls = 5;
    rule->n_derivatives[0] = rule->n_derivatives[1] = 2;
    rule->n_derivatives[2] = 4;
    for (int d = 0; d < 3; d++)
        memcpy(rule->derivative[d], derivative[d], sizeof derivative[d]);
    rule->n_products = rule->n_coefficients = rule->n_corners = 4;
    rule->n_products_each = rule->common = 1;
    memcpy(rule->product, product, sizeof product);
    for (int c = 0; c < 4; c++) {
        rule->factor[c] = 1;
        rule->corner[c] = (uint16_t)c;
    }
}

static void note_points(const lattice *l, uint8_t to[][3]) {
    for (int i = 0; i < l->n; i++)
        for (int d = 0; d < 3; d++)
            to[i][d] = (uint8_t)l->point[i].along[d];
}

void pl_jacobian_rule_make(const pl_cell_type *type, pl_jacobian_rule *rule) {
    const pl_cell_shape *shape = type->shape;
    memset(rule, 0, sizeof *rule);
    rule->type = type;
    if (shape->n_simplices == 0) {
        make_pyramid(rule);
        return;
    }
    const directions of = directions_of(shape);
    lattice controls = {.of = &of}, derivatives[3] = {{.n = 0}}, coefficients = {.of = &of};
    for (int s = 0; s < shape->n_simplices; s++) {
        controls.degree[s] = type->order;
        coefficients.degree[s] = shape->dim * type->order - (shape->n_vertices[s] - 1);
    }
    rule->n_nodes = type->n_nodes;
    fill(&controls);
    fill(&coefficients);
    if (type->order == 1) { /* the nodes themselves */
        rule->n_controls = type->n_nodes;
        for (int node = 0; node < type->n_nodes; node++)
            controls.point[node] = point_of_node(type, &of, node);
    } else {
        make_controls(type, &controls, rule);
    }
    note_points(&controls, rule->control_point);
    note_points(&coefficients, rule->coefficient_point);
    for (int s = 0; s < shape->n_simplices; s++)
        rule->degree[s] = (uint8_t)coefficients.degree[s];
    find_straight(type, &controls, rule);
    for (int d = 0; d < shape->dim; d++)
        make_derivatives(&controls, d, &derivatives[d], rule);
    make_products(derivatives, &coefficients, rule);
    rule->n_corners = shape->n_corners;
    for (int c = 0; c < shape->n_corners; c++) {
        point p = {{0}};
        for (int s = 0; s < shape->n_simplices; s++)
            add_to_exponent(&of, &p, s, shape->vertex[c][s], coefficients.degree[s]);
        rule->corner[c] = (uint16_t)find(&coefficients, p);
    }
    rule->n_turns = of.n; /* as often as a simplex has directions */
    for (int d = 0; d < of.n; d++)
        rule->turn[d] = (uint8_t)of.simplex[d];
    for (int s = 0; s < shape->n_simplices; s++)
        make_halves(shape, &coefficients, s, rule);
}
