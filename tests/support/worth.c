/* worth: what a mesh is worth, in long double and from textbook formulas. */
#include "support/worth.h"

#include "quality/certificate.h"

#include <math.h>

/* Volumes are told apart by more than this of themselves and of the product of the edges. */
#define VOLUME_ROUNDING 1e-14L

/** An element in units of its longest edge. */
typedef struct shape {
    int dim;
    real x[4][3];   /* its vertices, the first at 0, in its positive order */
    real unit;      /* the longest edge */
    real length[6]; /* of the edges */
    int n_edges;
    real normal[4][3]; /* of the facets opposite to the vertices, outwards */
    real size[4];      /* their areas, or lengths in 2-D, times dim - 1 */
    real determinant;  /* dim! times the volume */
} shape;

static real dot(const real *a, const real *b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const real *a, const real *b, real *c) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void subtract(const real *a, const real *b, real *c) {
    for (int d = 0; d < 3; d++)
        c[d] = a[d] - b[d];
}

/** Of the facet opposite to corner. In 2-D that is an edge, turned by a right angle. */
static void find_normal(shape *s, int corner) {
    static const int others[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
    real a[3], b[3] = {0, 0, 1};
    if (s->dim == 2) {
        subtract(s->x[(corner + 2) % 3], s->x[(corner + 1) % 3], a);
    } else {
        subtract(s->x[others[corner][1]], s->x[others[corner][0]], a);
        subtract(s->x[others[corner][2]], s->x[others[corner][0]], b);
    }
    cross(a, b, s->normal[corner]);
    s->size[corner] = sqrtl(dot(s->normal[corner], s->normal[corner]));
}

static shape shape_of(const worth_problem *p, const double *coordinates, int64_t element) {
    const int dim = p->mesh->dim;
    const int32_t *node = p->mesh->elements + element * (dim + 1);
    shape s = {.dim = dim};
    for (int j = 1; j <= dim; j++) {
        const int from = p->sign[element] < 0 && j < 3 ? 3 - j : j; /* the first two swapped */
        for (int d = 0; d < dim; d++)
            s.x[j][d] = (real)coordinates[(int64_t)node[from] * dim + d] -
                        (real)coordinates[(int64_t)node[0] * dim + d];
    }
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++) {
            real e[3];
            subtract(s.x[j], s.x[i], e);
            s.length[s.n_edges++] = sqrtl(dot(e, e));
            s.unit = fmaxl(s.unit, s.length[s.n_edges - 1]);
        }
    for (int i = 0; i < s.n_edges && s.unit > 0; i++)
        s.length[i] /= s.unit;
    for (int j = 0; j <= dim && s.unit > 0; j++)
        for (int d = 0; d < 3; d++)
            s.x[j][d] /= s.unit;
    for (int j = 0; j <= dim; j++)
        find_normal(&s, j);
    s.determinant = -dot(s.normal[1], s.x[1]); /* of base and height */
    return s;
}

/* ---- measures ------------------------------------------------------------------------------ */

static real volume_of(const shape *s) {
    real unit = s->unit;
    for (int d = 1; d < s->dim; d++)
        unit *= s->unit;
    return s->determinant / (s->dim == 3 ? 6 : 2) * unit;
}

/** R / (dim r). The circumcentre from vertex 0 is sum |e_j|^2 n_j / (2 D), with n_j the normals
 *  inwards of the facets at it; the inradius is dim times the volume by the boundary. */
static real radius_ratio(const shape *s) {
    real centre[3] = {0}, boundary = 0;
    for (int j = 0; j <= s->dim; j++) {
        boundary += s->size[j];
        for (int d = 0; d < 3; d++)
            centre[d] += dot(s->x[j], s->x[j]) * s->normal[j][d] / (2 * s->determinant);
    }
    const real inradius = s->determinant / boundary;
    return sqrtl(dot(centre, centre)) / (s->dim * inradius);
}

/** Mean square edge, by that of the regular element of the same volume. */
static real mean_ratio(const shape *s) {
    real square = 0;
    for (int i = 0; i < s->n_edges; i++)
        square += s->length[i] * s->length[i] / s->n_edges;
    const real edge = s->dim == 3 ? cbrtl(s->determinant * sqrtl(2)) /* D = a^3 / sqrt(2) */
                                  : sqrtl(s->determinant * 2 / sqrtl(3));
    return square / (edge * edge);
}

/** docs/algorithm.md: the means of l^64 and of l^-64. */
static real edge_ratio(const shape *s) {
    const real power = 64;
    real shortest = 1, high = 0, low = 0;
    for (int i = 0; i < s->n_edges; i++)
        shortest = fminl(shortest, s->length[i]);
    for (int i = 0; i < s->n_edges; i++) {
        high += powl(s->length[i], power) / s->n_edges;
        low += powl(shortest / s->length[i], power) / s->n_edges;
    }
    return powl(high, 1 / power) * powl(low, 1 / power) / shortest;
}

static real aspect_ratio(const shape *s, planish_objective objective) {
    return objective == PLANISH_OBJECTIVE_RADIUS_RATIO ? radius_ratio(s)
           : objective == PLANISH_OBJECTIVE_MEAN_RATIO ? mean_ratio(s)
                                                       : edge_ratio(s);
}

/** Between facets, from their normals: Kahan's formula, exact near 0 and 180 degrees. */
static real smallest_angle(const shape *s) {
    real least = 180;
    for (int i = 0; i < s->dim; i++)
        for (int j = i + 1; j <= s->dim; j++) {
            real sum = 0, difference = 0;
            for (int d = 0; d < 3; d++) {
                const real a = s->normal[i][d] / s->size[i], b = -s->normal[j][d] / s->size[j];
                sum += (a + b) * (a + b);
                difference += (a - b) * (a - b);
            }
            least = fminl(least, 2 * atan2l(sqrtl(difference), sqrtl(sum)) * 180 / acosl(-1));
        }
    return least;
}

double worth_least(const worth_problem *p, int64_t element) {
    const double own = p->mesh->min_volume ? p->mesh->min_volume[element] : 0;
    return own > 0 ? own : p->min_volume;
}

int worth_is_positive(const worth_problem *p, const double *coordinates, int64_t element) {
    const int dim = p->mesh->dim;
    const double *vertex[4];
    for (int j = 0; j <= dim; j++)
        vertex[j] = coordinates + (int64_t)p->mesh->elements[element * (dim + 1) + j] * dim;
    return pl_measure_sign(dim, vertex) * p->sign[element] > 0;
}

real worth_ratio(const worth_problem *p, const double *coordinates, int64_t element) {
    const shape s = shape_of(p, coordinates, element);
    return worth_is_positive(p, coordinates, element) ? radius_ratio(&s) : 0;
}

real worth_volume(const worth_problem *p, const double *coordinates, int64_t element) {
    const shape s = shape_of(p, coordinates, element);
    return volume_of(&s);
}

/* ---- the mesh ------------------------------------------------------------------------------ */

/** Whether the element has one of the nodes that are marked. */
static int has_one(const worth_problem *p, const uint8_t *marked, int64_t element) {
    int has = 0;
    for (int j = 0; j <= p->mesh->dim; j++)
        has |= marked[p->mesh->elements[element * (p->mesh->dim + 1) + j]];
    return has;
}

/** Sums over the valid elements. */
typedef struct sums {
    real square, square_movable, square_ratio, square_g;
    real loss, loss_movable, loss_ratio, loss_g; /* of squares times what is lost of them */
    real loss_domain;
    int64_t n, n_movable;
} sums;

static void add_volume(const worth_problem *p, int64_t element, const shape *s, sums *sum,
                       worth *w) {
    const real v = volume_of(s), least = worth_least(p, element) * (1 - PLANISH_VOLUME_TOLERANCE);
    const real cube = s->determinant != 0 ? v / s->determinant : 0;
    const real doubt = VOLUME_ROUNDING * (fabsl(cube) + least);
    w->domain += v;
    sum->loss_domain += fabsl(cube);
    w->mean += fabsl(v);
    if (least > 0) {
        w->below += v < least - doubt;
        w->nearly += v < least + doubt;
    }
}

static void add_valid(const worth_problem *p, int64_t element, const shape *s, sums *sum,
                      worth *w) {
    const real ratio = radius_ratio(s), aspect = aspect_ratio(s, p->objective);
    const double least = worth_least(p, element);
    const real v = volume_of(s), g = least > 0 ? 1 - v / least : 0;
    const real loss = 1 / s->determinant; /* edges are of length 1: what cancels in it */
    sum->n++;
    sum->square += aspect * aspect;
    sum->square_ratio += ratio * ratio;
    sum->loss += aspect * aspect * loss;
    sum->loss_ratio += ratio * ratio * loss;
    sum->square_g += g * g;
    sum->loss_g += g * g * loss;
    w->smallest = sum->n == 1 ? v : fminl(w->smallest, v);
    if (has_one(p, p->is_movable, element)) {
        sum->n_movable++;
        sum->square_movable += aspect * aspect;
        sum->loss_movable += aspect * aspect * loss;
    }
    if (!has_one(p, p->moves, element))
        return;
    w->worst = fmaxl(w->worst, ratio);
    w->smallest_angle = fminl(w->smallest_angle, smallest_angle(s));
}

static real ratio(real a, real b) {
    return b > 0 ? a / b : 0;
}

static real rms(real sum, int64_t n) {
    return n > 0 ? sqrtl(sum / (real)n) : 0;
}

worth worth_of(const worth_problem *p, const double *coordinates) {
    worth w = {.smallest_angle = 180};
    sums sum = {0};
    for (int64_t i = 0; i < p->mesh->n_elements; i++) {
        if (p->is_known && !p->is_known[i])
            continue;
        const shape s = shape_of(p, coordinates, i);
        w.n_elements++;
        add_volume(p, i, &s, &sum, &w);
        if (worth_is_positive(p, coordinates, i))
            add_valid(p, i, &s, &sum, &w);
        else
            w.inverted++;
    }
    w.mean /= w.n_elements > 0 ? (real)w.n_elements : 1;
    w.rms = rms(sum.square, sum.n);
    w.rms_movable = rms(sum.square_movable, sum.n_movable);
    w.rms_ratio = rms(sum.square_ratio, sum.n);
    w.multiple = rms(sum.square_g, sum.n);
    w.loss = ratio(sum.loss, sum.square);
    w.loss_movable = ratio(sum.loss_movable, sum.square_movable);
    w.loss_ratio = ratio(sum.loss_ratio, sum.square_ratio);
    w.loss_domain = ratio(sum.loss_domain, fabsl(w.domain));
    w.objective = (1 - (real)p->area_weight) * w.rms + (real)p->area_weight * w.multiple;
    w.loss_objective =
        ratio((1 - (real)p->area_weight) * w.rms * w.loss +
                  (real)p->area_weight * w.multiple * ratio(sum.loss_g, sum.square_g),
              w.objective);
    return w;
}
