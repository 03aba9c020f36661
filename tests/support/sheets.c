#include "support/sheets.h"

#include "shape/walk.h"
#include "support/effort.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void *zeroed(int64_t n, size_t size) {
    return calloc((size_t)(n > 0 ? n : 1), size);
}

planish_shape *sheet_of(int64_t n_nodes, const double (*x)[3], int64_t n_facets,
                        const int32_t (*facet)[3], int64_t n_edges, const int32_t (*edge)[2]) {
    uint8_t *type = zeroed(n_facets, sizeof *type);
    int64_t *offset = zeroed(n_facets + 1, sizeof *offset);
    for (int64_t i = 0; i < n_facets; i++) {
        type[i] = PLANISH_CELL_TRIANGLE;
        offset[i + 1] = 3 * (i + 1);
    }
    const planish_cells cells = {.n = n_facets, .type = type, .offset = offset, .node = facet[0]};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = n_nodes, .n_elements = n_facets, .coordinates = x[0], .cells = &cells};
    const planish_surface surface = {
        .n_edges = n_edges, .edges = n_edges ? edge[0] : NULL, .crease_angle = 40};
    planish_shape *shape;
    planish_error error = {.text = ""};
    if (planish_shape_create(&mesh, &surface, 1, &shape, NULL, &error))
        fail_msg("%s", error.text);
    free(type);
    free(offset);
    return shape;
}

/* ---- sheets by rule ------------------------------------------------------------------------- */

/** A grid of n[0] by n[1] quadrilaterals, which may be joined at the ends of the first direction. */
typedef struct grid {
    int n[2];
    int joins; /* 0, 1, or -1: turned over */
    int64_t n_nodes, n_facets;
    double (*x)[3];
    int32_t (*facet)[3];
    int64_t n_edges; /* of a crease */
    int32_t edge[16][2];
} grid;

enum { MOST = 400 };

static int32_t node_at(const grid *g, int i, int j) {
    if (g->joins && i == g->n[0]) {
        i = 0;
        j = g->joins < 0 ? g->n[1] - j : j;
    }
    return (int32_t)(i * (g->n[1] + 1) + j);
}

static void add_facet(grid *g, int32_t a, int32_t b, int32_t c) {
    int32_t *node = g->facet[g->n_facets++];
    node[0] = a;
    node[1] = b;
    node[2] = c;
}

/** Add two triangles between the corners of a quadrilateral. */
static void add_quadrilateral(grid *g, int32_t a, int32_t b, int32_t c, int32_t d, int other) {
    add_facet(g, a, b, other ? d : c);
    add_facet(g, other ? b : a, c, d);
}

static grid make_grid(int n, int m, int joins, double holes, uint64_t *state) {
    grid g = {.n = {n, m}, .joins = joins, .n_nodes = (n + !joins) * (m + 1)};
    g.x = zeroed(2 * MOST, sizeof *g.x);
    g.facet = zeroed(4 * MOST, sizeof *g.facet);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < m; j++)
            if (!(random_unit(state) < holes))
                add_quadrilateral(&g, node_at(&g, i, j), node_at(&g, i + 1, j),
                                  node_at(&g, i + 1, j + 1), node_at(&g, i, j + 1),
                                  (int)random_below(state, 2));
    return g;
}

/** A number of -1 .. 1 inside of a direction, 0 at its ends. */
static double jitter(int i, int n, uint64_t *state) {
    const double r = random_between(state, -1, 1);
    return i > 0 && i < n ? r : 0;
}

/** Waves of a smooth height. */
typedef struct waves {
    double factor[3][3], size[3];
} waves;

static waves random_waves(double most, uint64_t *state) {
    waves w;
    for (int i = 0; i < 3; i++) {
        for (int d = 0; d < 3; d++)
            w.factor[i][d] = random_between(state, -0.7, 0.7);
        w.size[i] = random_between(state, 0, most);
    }
    return w;
}

static double height(const waves *w, double x, double y) {
    double z = 0;
    for (int i = 0; i < 3; i++)
        z += w->size[i] * sin(w->factor[i][0] * x + w->factor[i][1] * y + 3 * w->factor[i][2]);
    return z;
}

static void place_open(grid *g, int kind, uint64_t *state) {
    const waves w = random_waves(random_between(state, 0, 0.5), state);
    const double slope = random_between(state, 0.1, 1.2), rough = random_between(state, 0, 0.28);
    const int fold = g->n[0] / 2;
    for (int i = 0; i <= g->n[0]; i++)
        for (int j = 0; j <= g->n[1]; j++) {
            double *x = g->x[node_at(g, i, j)];
            x[0] = i + rough * jitter(i, g->n[0], state);
            x[1] = j + rough * jitter(j, g->n[1], state);
            if (kind == SHEET_PLANE) {
                const double u = 2 * x[0] / g->n[0] - 1, v = 2 * x[1] / g->n[1] - 1;
                x[0] = g->n[0] / 2. * u * sqrt(1 - v * v / 2);
                x[1] = g->n[1] / 2. * v * sqrt(1 - u * u / 2);
                continue;
            }
            x[2] =
                kind == SHEET_CRUMPLED ? random_between(state, 0, slope) : height(&w, x[0], x[1]);
            if (kind == SHEET_CREASE) {
                const double line = fold + 0.3 * sin(0.6 * j);
                if (i == fold)
                    x[0] = line;
                if (i == fold && j > 0) {
                    g->edge[g->n_edges][0] = node_at(g, i, j - 1);
                    g->edge[g->n_edges++][1] = node_at(g, i, j);
                }
                x[2] = 0.2 * x[2] + slope * fabs(x[0] - line);
            }
        }
}

/** Place a grid that joins its ends around an axis. */
static void place_joined(grid *g, int kind, uint64_t *state) {
    const double pi = acos(-1.), radius = g->n[0] / (2 * pi),
                 twist = kind == SHEET_MOEBIUS ? 0.5 : 0;
    const double rough = random_between(state, 0, 0.28), bulge = random_between(state, -0.3, 0.3);
    for (int i = 0; i < g->n[0]; i++)
        for (int j = 0; j <= g->n[1]; j++) {
            double *x = g->x[node_at(g, i, j)];
            const double a = 2 * pi * (i + rough * random_between(state, -1, 1)) / g->n[0];
            const double y = j + rough * jitter(j, g->n[1], state) - g->n[1] / 2.;
            double r = radius + y * sin(twist * a), z = y * cos(twist * a);
            if (kind == SHEET_TUBE)
                r *= 1 + bulge * cos(pi * y / g->n[1]);
            if (kind == SHEET_SPHERE) {
                const double b = pi * (y + g->n[1] / 2. + 1) / (g->n[1] + 2);
                r = radius * sin(b);
                z = -radius * cos(b);
            }
            x[0] = r * cos(a);
            x[1] = r * sin(a);
            x[2] = z;
        }
    if (kind != SHEET_SPHERE)
        return;
    for (int end = 0; end < 2; end++) {
        const int32_t pole = (int32_t)g->n_nodes++;
        g->x[pole][2] = end ? radius : -radius;
        for (int i = 0; i < g->n[0]; i++) {
            const int32_t a = node_at(g, i, end * g->n[1]), b = node_at(g, i + 1, end * g->n[1]);
            add_facet(g, end ? a : b, end ? b : a, pole);
        }
    }
}

/** Add the same grid so much lower, turned over. */
static void add_lower(grid *g, double thickness) {
    const int32_t n = (int32_t)g->n_nodes;
    const int64_t n_facets = g->n_facets;
    for (int32_t i = 0; i < n; i++) {
        memcpy(g->x[n + i], g->x[i], sizeof *g->x);
        g->x[n + i][2] -= thickness;
    }
    for (int64_t f = 0; f < n_facets; f++)
        add_facet(g, n + g->facet[f][0], n + g->facet[f][2], n + g->facet[f][1]);
    g->n_nodes = 2 * n;
}

/** Make a plate of an open grid: the other side, and a rim. */
static void add_side(grid *g, double thickness) {
    const int32_t n = (int32_t)g->n_nodes;
    add_lower(g, thickness);
    for (int side = 0; side < 2; side++)
        for (int end = 0; end < 2; end++)
            for (int i = 0; i < g->n[side]; i++) {
                const int at = end * g->n[!side];
                const int32_t a = side ? node_at(g, at, i) : node_at(g, i, at);
                const int32_t b = side ? node_at(g, at, i + 1) : node_at(g, i + 1, at);
                if (side == end)
                    add_quadrilateral(g, a, n + a, n + b, b, 0);
                else
                    add_quadrilateral(g, b, n + b, n + a, a, 0);
            }
}

/** Scale, turn and shift: nothing may hang on the axes. */
static void turn(grid *g, int kind, uint64_t *state) {
    const double scale = ldexp(1, -(int)random_below(state, 8)), pi = acos(-1.);
    const double thin = kind == SHEET_NEEDLES ? pow(10, -4 * random_unit(state)) : 1;
    double angle[3], shift[3];
    for (int d = 0; d < 3; d++) {
        angle[d] = random_between(state, 0, 2 * pi);
        shift[d] = random_between(state, -1, 1);
    }
    for (int64_t i = 0; i < g->n_nodes; i++) {
        double *x = g->x[i];
        x[0] *= thin;
        for (int d = 0; d < 3; d++) {
            double *a = &x[d], *b = &x[(d + 1) % 3];
            const double u = *a * cos(angle[d]) - *b * sin(angle[d]);
            *b = *a * sin(angle[d]) + *b * cos(angle[d]);
            *a = u;
        }
        for (int d = 0; d < 3; d++)
            x[d] = scale * x[d] + shift[d];
    }
}

planish_shape *sheet_create(int kind, uint64_t *state) {
    const int n = 4 + (int)random_below(state, 6), m = 3 + (int)random_below(state, 5);
    const int joins = kind == SHEET_SPHERE || kind == SHEET_TUBE ? 1
                      : kind == SHEET_MOEBIUS                    ? -1
                                                                 : 0;
    grid g = make_grid(joins ? 2 * n : n, m, joins, kind == SHEET_HOLES ? 0.1 : 0, state);
    if (joins)
        place_joined(&g, kind, state);
    else
        place_open(&g, kind, state);
    if (kind == SHEET_PLATE)
        add_side(&g, 0.1);
    if (kind == SHEET_TWO)
        add_lower(&g, 0.1);
    turn(&g, kind, state);
    planish_shape *s =
        sheet_of(g.n_nodes, (const double(*)[3])g.x, g.n_facets, (const int32_t(*)[3])g.facet,
                 g.n_edges, (const int32_t(*)[2])g.edge);
    free(g.x);
    free(g.facet);
    return s;
}

/* ---- moves ---------------------------------------------------------------------------------- */

static void random_vector(double length, uint64_t *state, double v[3]) {
    for (int d = 0; d < 3; d++)
        v[d] = length * random_between(state, -1, 1);
}

void sheet_move(const planish_shape *s, double far, double off, double share, uint64_t *state,
                double (*x)[3], pl_place *place) {
    memcpy(x, s->x, (size_t)s->n_nodes * sizeof *x);
    for (int64_t i = 0; i < s->n_nodes; i++) {
        place[i] = (pl_place){-1, {0}};
        if (s->node_class[i] == PL_CORNER || !(random_unit(state) < share))
            continue;
        double v[3], w[3];
        random_vector(far * s->edge_length[i], state, v);
        random_vector(off * s->edge_length[i], state, w);
        for (int d = 0; d < 3; d++)
            v[d] += x[i][d];
        const int is_curve = s->node_class[i] == PL_ON_CURVE;
        place[i].at = is_curve ? s->edge_at[i][0] : s->facet_of[s->offset[i]];
        pl_shape_walk(s, s->node_class[i], v, &place[i]);
        const int32_t *node = is_curve ? s->edge[place[i].at] : s->facet[place[i].at];
        for (int d = 0; d < 3; d++) {
            x[i][d] = w[d];
            for (int k = 0; k < 3 - is_curve; k++)
                x[i][d] += place[i].weight[k] * s->x[node[k]][d];
        }
    }
}

/* ---- distances ------------------------------------------------------------------------------ */

double sheet_from_segment(const double a[3], const double b[3], const double point[3]) {
    double square = 0, along = 0, off = 0;
    for (int d = 0; d < 3; d++) {
        square += (b[d] - a[d]) * (b[d] - a[d]);
        along += (point[d] - a[d]) * (b[d] - a[d]);
    }
    double t = square > 0 ? along / square : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    for (int d = 0; d < 3; d++) {
        const double v = (1 - t) * (point[d] - a[d]) + t * (point[d] - b[d]);
        off += v * v;
    }
    return sqrt(off);
}

/** Distance of a point from a triangle: from its plane, if the point is between the planes through its
 *  sides; else from a side. */
static double from_triangle(const double corner[3][3], const double point[3]) {
    double u[3], v[3], normal[3], least = INFINITY;
    int is_between = 1;
    pl_subtract(3, corner[1], corner[0], u);
    pl_subtract(3, corner[2], corner[0], v);
    pl_cross(u, v, normal);
    for (int k = 0; k < 3; k++) {
        double side[3], to[3], across[3];
        pl_subtract(3, corner[(k + 1) % 3], corner[k], side);
        pl_subtract(3, point, corner[k], to);
        pl_cross(normal, side, across);
        is_between &= pl_dot(3, across, to) > 0;
        least = fmin(least, sheet_from_segment(corner[k], corner[(k + 1) % 3], point));
    }
    if (!is_between)
        return least;
    pl_subtract(3, point, corner[0], u);
    return fmin(least, fabs(pl_dot(3, normal, u)) / pl_length(normal));
}

sheet_judge sheet_judge_create(const planish_shape *s, const double (*x)[3]) {
    sheet_judge j = {.n = s->n_facets, .patch = s->patch};
    j.corner = zeroed(j.n, sizeof *j.corner);
    j.middle = zeroed(j.n, sizeof *j.middle);
    j.radius = zeroed(j.n, sizeof *j.radius);
    for (int64_t f = 0; f < j.n; f++) {
        for (int k = 0; k < 3; k++)
            for (int d = 0; d < 3; d++) {
                j.corner[f][k][d] = x[s->facet[f][k]][d];
                j.middle[f][d] += j.corner[f][k][d] / 3;
            }
        for (int k = 0; k < 3; k++)
            j.radius[f] = fmax(j.radius[f], pl_distance(3, j.middle[f], j.corner[f][k]));
    }
    return j;
}

void sheet_judge_destroy(sheet_judge *j) {
    free(j->corner);
    free(j->middle);
    free(j->radius);
}

double sheet_judge_distance(const sheet_judge *j, int32_t patch, const double point[3]) {
    double least = INFINITY;
    for (int64_t f = 0; f < j->n; f++) {
        if (patch >= 0 && j->patch[f] != patch)
            continue;
        double square = 0;
        for (int d = 0; d < 3; d++)
            square += (point[d] - j->middle[f][d]) * (point[d] - j->middle[f][d]);
        const double near = least + j->radius[f];
        if (square <= near * near)
            least = fmin(least, from_triangle((const double(*)[3])j->corner[f], point));
    }
    return least;
}

double sheet_judge_sample(const sheet_judge *judge, int32_t patch, const double corner[3][3],
                          int divisions) {
    double most = 0;
    for (int i = 0; i <= divisions; i++)
        for (int j = 0; i + j <= divisions; j++) {
            double p[3];
            for (int d = 0; d < 3; d++)
                p[d] = (i * corner[0][d] + j * corner[1][d] + (divisions - i - j) * corner[2][d]) /
                       divisions;
            most = fmax(most, sheet_judge_distance(judge, patch, p));
        }
    return most;
}

/** Six times the volume of the tetrahedron of four points. */
static double volume6(const double *a, const double *b, const double *c, const double *d) {
    double u[3], v[3], w[3], normal[3];
    pl_subtract(3, b, a, u);
    pl_subtract(3, c, a, v);
    pl_subtract(3, d, a, w);
    pl_cross(u, v, normal);
    return pl_dot(3, normal, w);
}

/** Whether the segment from p to q goes through a triangle, clearly. */
static int goes_through(const double *p, const double *q, const double x[3][3], double least) {
    const double from = volume6(x[0], x[1], x[2], p), to = volume6(x[0], x[1], x[2], q);
    double side[3];
    if (!(fabs(from) > least && fabs(to) > least && (from > 0) != (to > 0)))
        return 0;
    for (int k = 0; k < 3; k++)
        side[k] = volume6(p, q, x[k], x[(k + 1) % 3]);
    return (side[0] > least && side[1] > least && side[2] > least) ||
           (side[0] < -least && side[1] < -least && side[2] < -least);
}

/** Whether an edge of facet a that has no node of b goes through b. */
static int edges_go_through(const sheet_judge *j, const planish_shape *s, int64_t a, int64_t b) {
    const double size = j->radius[a] + j->radius[b], least = 1e-12 * size * size * size;
    const int32_t *other = s->facet[b];
    for (int k = 0; k < 3; k++) {
        int shared = 0;
        for (int i = 0; i < 6; i++)
            shared |= s->facet[a][(k + i / 3) % 3] == other[i % 3];
        if (!shared && goes_through(j->corner[a][k], j->corner[a][(k + 1) % 3],
                                    (const double(*)[3])j->corner[b], least))
            return 1;
    }
    return 0;
}

int sheet_cross(const sheet_judge *j, const planish_shape *s, int64_t a, int64_t b) {
    if (pl_distance(3, j->middle[a], j->middle[b]) > j->radius[a] + j->radius[b])
        return 0;
    return edges_go_through(j, s, a, b) || edges_go_through(j, s, b, a);
}

double sheet_cosine(const sheet_judge *j, int32_t a, int32_t b) {
    double normal[2][3];
    for (int i = 0; i < 2; i++) {
        const double(*x)[3] = (const double(*)[3])j->corner[i ? b : a];
        double u[3], v[3];
        pl_subtract(3, x[1], x[0], u);
        pl_subtract(3, x[2], x[0], v);
        pl_cross(u, v, normal[i]);
    }
    return pl_dot(3, normal[0], normal[1]) / (pl_length(normal[0]) * pl_length(normal[1]));
}
