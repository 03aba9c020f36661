/* hand_star: one star made by hand, as the kernels see it. */
#include "support/hand_star.h"

#include "base/memory.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846

static double uniform(unsigned *state) {
    *state = *state * 1664525u + 1013904223u;
    return (double)(*state >> 8) / (1 << 24);
}

static const double golden = 1.6180339887498949;

/** The icosahedron's vertices, and its facets: the triples at the shortest distance. */
static void icosahedron(hand_star *s) {
    double *x = s->coordinates + 3;
    int n = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int sign = 0; sign < 4; sign++, n++) {
            x[3 * n + axis] = 0;
            x[3 * n + (axis + 1) % 3] = sign & 1 ? 1 : -1;
            x[3 * n + (axis + 2) % 3] = (sign & 2 ? 1 : -1) * golden;
        }
    int64_t facets = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++)
            for (int k = 0; k < n; k++) {
                const double *p = x + 3 * i, *q = x + 3 * j, *r = x + 3 * k;
                double pq = 0, qr = 0, rp = 0;
                for (int d = 0; d < 3; d++) {
                    pq += (p[d] - q[d]) * (p[d] - q[d]);
                    qr += (q[d] - r[d]) * (q[d] - r[d]);
                    rp += (r[d] - p[d]) * (r[d] - p[d]);
                }
                double inward =
                    -(p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
                      p[2] * (q[0] * r[1] - q[1] * r[0]));
                int first = i < j && i < k; /* one of three rotations */
                if (first && inward > 0 && pq < 4.1 && qr < 4.1 && rp < 4.1) {
                    s->link[3 * facets] = (uint16_t)i;
                    s->link[3 * facets + 1] = (uint16_t)j;
                    s->link[3 * facets++ + 2] = (uint16_t)k;
                }
            }
    s->ring_offset[1] = n;
    s->link_offset[1] = facets;
}

static void polygon(hand_star *s, int corners) {
    for (int i = 0; i < corners; i++) {
        s->coordinates[2 + 2 * i] = cos(2 * PI * i / corners);
        s->coordinates[3 + 2 * i] = sin(2 * PI * i / corners);
        s->link[2 * i] = (uint16_t)i;
        s->link[2 * i + 1] = (uint16_t)((i + 1) % corners);
    }
    s->ring_offset[1] = s->link_offset[1] = corners;
}

/** Number of the link's edge between two of the ring's nodes, counted in order of appearance. */
static int edge_of(const hand_star *s, int p, int q) {
    int seen = 0;
    for (int i = 0; i < 3 * s->link_offset[1]; i++) {
        const int a = s->link[i], b = s->link[i % 3 < 2 ? i + 1 : i - 2];
        int first = 1;
        for (int j = 0; j < i && first; j++) {
            const int c = s->link[j], d = s->link[j % 3 < 2 ? j + 1 : j - 2];
            first = !((a == c && b == d) || (a == d && b == c));
        }
        if ((a == p && b == q) || (a == q && b == p))
            return seen;
        seen += first;
    }
    return -1;
}

void hand_star_pack_link(hand_star *s) {
    const int64_t n = s->link_offset[1];
    const pl_link link = {s->positions, NULL};
    for (int64_t i = 0; i < n * s->dim; i++)
        pl_link_set(&link, i, s->link[i]);
    for (int64_t i = 0; s->dim == 3 && i < 3 * n; i++) {
        const int p = s->link[i], q = s->link[i % 3 < 2 ? i + 1 : i - 2], edge = edge_of(s, p, q);
        pl_link_set(&link, 3 * n + i, edge);
        if (edge < pl_link_edges(3, n)) { /* not so of links that are not closed */
            pl_link_set(&link, 6 * n + 2 * edge, p);
            pl_link_set(&link, 6 * n + 2 * edge + 1, q);
        }
    }
}

void hand_star_create(hand_star *s, int dim, double unevenness, unsigned seed) {
    memset(s, 0, sizeof *s);
    s->dim = dim;
    if (dim == 3)
        icosahedron(s);
    else
        polygon(s, 5 + (int)(seed % 3));
    unsigned state = seed * 2654435761u + 1;
    for (int64_t i = 0; i < s->ring_offset[1]; i++) {
        double radius = 1 + unevenness * (2 * uniform(&state) - 1);
        for (int d = 0; d < dim; d++)
            s->coordinates[(i + 1) * dim + d] *= radius;
        s->ring[i] = (int32_t)(i + 1);
    }
    for (int d = 0; d < dim; d++)
        s->coordinates[d] = 0.3 * unevenness * (2 * uniform(&state) - 1);
    hand_star_pack_link(s);
    memset(s->changed, 1, sizeof s->changed);
    s->scratch = pl_alloc(pl_star_scratch_size(dim, s->ring_offset[1], s->link_offset[1], 0), 1);
    s->problem = (pl_star_problem){.coordinates = s->coordinates,
                                   .node = &s->node,
                                   .ring_offset = s->ring_offset,
                                   .ring = s->ring,
                                   .link_offset = s->link_offset,
                                   .link = {s->positions, NULL},
                                   .changed = s->changed,
                                   .limits = pl_star_no_limits()};
}

void hand_star_destroy(hand_star *s) {
    pl_free(s->scratch);
}

/* ---- textbook radius ratio ---------------------------------------------------------------- */

static long double length(const long double *p, const long double *q, int dim) {
    long double sum = 0;
    for (int d = 0; d < dim; d++)
        sum += (p[d] - q[d]) * (p[d] - q[d]);
    return sqrtl(sum);
}

/** Heron. */
static long double area(long double a, long double b, long double c) {
    long double p = (a + b + c) / 2;
    return sqrtl(p * (p - a) * (p - b) * (p - c));
}

static long double triangle_ratio(const long double *p[]) {
    long double a = length(p[0], p[1], 2), b = length(p[1], p[2], 2), c = length(p[2], p[0], 2);
    long double A = area(a, b, c);
    long double R = a * b * c / (4 * A), r = 2 * A / (a + b + c);
    return R / (2 * r);
}

/** R from the products of opposite edges (Crelle), r from volume and surface. */
static long double tetrahedron_ratio(const long double *p[]) {
    long double e[4][4], u[3], v[3], w[3];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++)
            e[i][j] = length(p[i], p[j], 3);
    for (int d = 0; d < 3; d++) {
        u[d] = p[1][d] - p[0][d];
        v[d] = p[2][d] - p[0][d];
        w[d] = p[3][d] - p[0][d];
    }
    long double V = fabsl(u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
                          u[2] * (v[0] * w[1] - v[1] * w[0])) /
                    6;
    long double S = area(e[0][1], e[1][2], e[2][0]) + area(e[0][1], e[1][3], e[3][0]) +
                    area(e[0][2], e[2][3], e[3][0]) + area(e[1][2], e[2][3], e[3][1]);
    long double R = area(e[0][1] * e[2][3], e[0][2] * e[1][3], e[0][3] * e[1][2]) / (6 * V);
    return R * S / (9 * V);
}

/** The corners of an element: those of the facet, then x. */
static void corners_of(const hand_star *s, int64_t facet, const long double *x,
                       long double corner[4][3]) {
    for (int j = 0; j <= s->dim; j++)
        for (int d = 0; d < s->dim; d++)
            corner[j][d] =
                j == s->dim ? x[d] : s->coordinates[(1 + s->link[facet * s->dim + j]) * s->dim + d];
}

long double hand_star_sum(const hand_star *s, const long double *x) {
    long double sum = 0;
    for (int64_t f = 0; f < s->link_offset[1]; f++) {
        long double ratio = hand_star_aspect(s, f, x, PLANISH_OBJECTIVE_RADIUS_RATIO);
        sum += ratio * ratio;
    }
    return sum;
}

/* ---- the guarded function ----------------------------------------------------------------- */

long double hand_star_measure(const hand_star *s, int64_t facet, const long double *x) {
    long double p[4][3], v[3][3];
    corners_of(s, facet, x, p);
    for (int j = 0; j < s->dim; j++)
        for (int d = 0; d < s->dim; d++)
            v[j][d] = p[j][d] - x[d];
    if (s->dim == 2)
        return (v[0][0] * v[1][1] - v[0][1] * v[1][0]) / 2;
    return -(v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
             v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
             v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0])) /
           6;
}

long double hand_star_floor(const hand_star *s, int64_t facet) {
    const pl_star_guard *guard = s->problem.guard;
    long double own = guard->link_min_volume ? guard->link_min_volume[facet] : 0;
    return own > 0 ? own : guard->min_volume;
}

/** Mean square edge to that of the regular element of the same measure. */
static long double mean_ratio(const hand_star *s, long double measure, long double squares) {
    if (s->dim == 2)
        return squares / 3 / (4 * measure / sqrtl(3));
    long double edge = cbrtl(6 * sqrtl(2) * measure);
    return squares / 6 / (edge * edge);
}

/** The angle at the edge between corners i and j of a tetrahedron, or at corner i of a triangle. */
static long double angle_at(const long double *p[], int i, int j, int dim) {
    long double u[3], v[3], e[3] = {0}, uu = 0, vv = 0, uv = 0, ee = 0, ue = 0, ve = 0;
    const int k = dim == 2 ? (i + 1) % 3 : i != 0 && j != 0 ? 0 : i != 1 && j != 1 ? 1 : 2;
    const int l = dim == 2 ? (i + 2) % 3 : 6 - i - j - k;
    for (int d = 0; d < dim; d++) {
        e[d] = dim == 3 ? p[j][d] - p[i][d] : 0;
        u[d] = p[k][d] - p[i][d];
        v[d] = p[l][d] - p[i][d];
        ee += e[d] * e[d];
        ue += u[d] * e[d];
        ve += v[d] * e[d];
    }
    for (int d = 0; d < dim; d++) { /* what is orthogonal to the edge */
        u[d] -= dim == 3 ? ue / ee * e[d] : 0;
        v[d] -= dim == 3 ? ve / ee * e[d] : 0;
        uu += u[d] * u[d];
        vv += v[d] * v[d];
        uv += u[d] * v[d];
    }
    return atan2l(sqrtl(uu * vv - uv * uv), uv);
}

static int n_angles(int dim) {
    return dim == 3 ? 6 : 3;
}

static long double angle(const hand_star *s, int64_t facet, const long double *x, int which) {
    static const int ends[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
    long double corner[4][3];
    const long double *p[4] = {corner[0], corner[1], corner[2], corner[3]};
    corners_of(s, facet, x, corner);
    return s->dim == 2 ? angle_at(p, which, 0, 2) : angle_at(p, ends[which][0], ends[which][1], 3);
}

long double hand_star_angle(const hand_star *s, const long double *x) {
    long double smallest = INFINITY;
    for (int64_t f = 0; f < s->link_offset[1]; f++)
        for (int i = 0; i < n_angles(s->dim); i++)
            smallest = fminl(smallest, angle(s, f, x, i));
    return smallest;
}

/** Root of what an element adds to the sum of the worst: the 32nd powers of its measure's square by
 *  the limit, or of those of its angles. */
static long double part_of_worst(const hand_star *s, int64_t facet, const long double *x,
                                 int measure) {
    const long double limit = s->problem.guard->worst_limit;
    long double sum = 0;
    if (measure == PL_WORST_RATIO) {
        const long double ratio = hand_star_aspect(s, facet, x, PLANISH_OBJECTIVE_RADIUS_RATIO);
        return powl(ratio * ratio / limit, 16);
    }
    for (int i = 0; i < n_angles(s->dim); i++) {
        const long double sine = sinl(angle(s, facet, x, i));
        sum += powl(1 / (sine * sine * limit), 32);
    }
    return sqrtl(sum);
}

long double hand_star_aspect(const hand_star *s, int64_t facet, const long double *x,
                             int objective) {
    const int n = s->dim == 3 ? 6 : 3;
    long double corner[4][3], squares = 0, large = 0, small = 0;
    const long double *p[4] = {corner[0], corner[1], corner[2], corner[3]};
    corners_of(s, facet, x, corner);
    if (objective == PL_WORST_RATIO || objective == PL_WORST_ANGLE)
        return part_of_worst(s, facet, x, objective);
    if (objective == PLANISH_OBJECTIVE_RADIUS_RATIO)
        return s->dim == 3 ? tetrahedron_ratio(p) : triangle_ratio(p);
    for (int i = 0; i < s->dim; i++)
        for (int j = i + 1; j <= s->dim; j++) {
            long double edge = length(p[i], p[j], s->dim), power = edge * edge;
            squares += edge * edge;
            for (int k = 0; k < 5; k++) /* to 32 */
                power *= power;
            large += power / n;
            small += 1 / power / n;
        }
    if (objective == PLANISH_OBJECTIVE_MEAN_RATIO)
        return mean_ratio(s, hand_star_measure(s, facet, x), squares);
    return powl(large * small, 1.0L / 64);
}

long double hand_star_function(const hand_star *s, const long double *x) {
    const pl_star_guard *guard = s->problem.guard;
    long double ratios = 0, volumes = 0;
    for (int64_t f = 0; f < s->link_offset[1]; f++) {
        long double ratio = hand_star_aspect(s, f, x, guard->objective);
        long double least = hand_star_floor(s, f);
        long double g = least > 0 ? 1 - hand_star_measure(s, f, x) / least : 0;
        ratios += ratio * ratio;
        volumes += g * g;
    }
    return guard->ratio_weight * ratios + guard->volume_weight * volumes;
}
