/* disc: the graph of a patch around a node.
 *
 * Flood the facets from those of the node across every edge that may be over the disc. All turn the same
 * way round there, so the number of them over a point of the disc changes at features alone; features,
 * and facets that turn otherwise, end the disc. Over the node there is a facet: so they cover the disc.
 */
#include "shape/disc.h"

#include <math.h>

enum { MOST_FACETS = 64 };

/* The disc reaches so much farther than the facets at its node. */
#define REACH 1.25
/* Margins for roundings, of lengths and squares. */
#define MORE (1 + 0x1p-30)
#define LESS (1 - 0x1p-30)
/* Area that a facet has for certain, in units of the lengths that it is made from. */
#define LEAST_AREA 0x1p-40
/* A quadratic function is not determined if a pivot is below this part of the diagonal. */
#define SINGULAR 1e-6

/** The larger of two numbers; fmax would be a call. */
static inline double larger(double a, double b) {
    return a > b ? a : b;
}

/** Facets around a node. */
typedef struct flood {
    const planish_shape *shape;
    pl_disc_frame frame;
    double square; /* of the radius */
    int n;
    int32_t facet[MOST_FACETS];
    double near[MOST_FACETS];    /* square of the distance of the nearest edge that leads there */
    double x[MOST_FACETS][3][3]; /* corners in the frame */
} flood;

void pl_disc_set_frame(const planish_shape *shape, int32_t node, const pl_disc *disc,
                       pl_disc_frame *frame) {
    const int32_t f = shape->facet_of[shape->offset[node]];
    const double *normal = pl_corner_normal(shape, f, pl_corner_at(shape, f, node));
    int least = 0;
    double axis[3] = {0, 0, 0};
    for (int d = 0; d < 3; d++) {
        frame->axis[2][d] = normal[d];
        least = fabs(normal[d]) < fabs(normal[least]) ? d : least;
    }
    axis[least] = 1;
    pl_cross(normal, axis, frame->axis[0]);
    pl_unit(3, frame->axis[0], frame->axis[0]);
    pl_cross(normal, frame->axis[0], frame->axis[1]);
    frame->disc = disc;
    frame->origin = shape->x[node];
}

/* ---- the facets over the disc ----------------------------------------------------------------- */

/** Square of the distance of the origin from an edge, in the plane of the disc. */
static double square_of_edge(const double *a, const double *b) {
    const double way[2] = {b[0] - a[0], b[1] - a[1]};
    const double square = pl_dot(2, way, way), along = -pl_dot(2, a, way);
    const double t = along > 0 ? (along < square ? along / square : 1) : 0;
    const double x = a[0] + t * way[0], y = a[1] + t * way[1];
    return x * x + y * y;
}

/** Reach a facet by an edge of that distance. What there is no room for ends the disc. */
static void reach(flood *w, int32_t facet, double square) {
    int i = 0;
    while (i < w->n && w->facet[i] != facet)
        i++;
    if (i < w->n) {
        w->near[i] = square < w->near[i] ? square : w->near[i];
    } else if (i < MOST_FACETS) {
        w->facet[i] = facet;
        w->near[i] = square;
        w->n++;
    } else {
        w->square = square < w->square ? square : w->square;
    }
}

/** Compute the corners of facet i. */
static void see(flood *w, int i) {
    const int32_t *node = w->shape->facet[w->facet[i]];
    for (int k = 0; k < 3; k++) {
        double way[3];
        pl_from_to(3, w->frame.origin, w->shape->x[node[k]], way);
        for (int d = 0; d < 3; d++)
            w->x[i][k][d] = pl_dot(3, way, w->frame.axis[d]);
    }
}

/** Whether a facet turns as those of the node do, for certain. */
static int is_upright(const double x[3][3]) {
    const double u[2] = {x[1][0] - x[0][0], x[1][1] - x[0][1]};
    const double v[2] = {x[2][0] - x[0][0], x[2][1] - x[0][1]};
    return u[0] * v[1] - u[1] * v[0] >
           LEAST_AREA * (fabs(u[0]) + fabs(u[1])) * (fabs(v[0]) + fabs(v[1]));
}

/** Reach the facets across the edges of facet i that are over the disc. */
static void go_on(flood *w, int i) {
    const double(*x)[3] = (const double(*)[3])w->x[i];
    for (int k = 0; k < 3; k++) {
        const int32_t across = w->shape->across[w->facet[i]][k];
        const double square = square_of_edge(x[k], x[(k + 1) % 3]) * LESS;
        if (!(square < w->square))
            continue;
        if (across >= 0)
            reach(w, across, square);
        else
            w->square = square;
    }
}

/** Go on from facet to facet, as long as one is over the disc: shorter ways to a facet may be found late. n_own:
 *  those of the node, which have been seen. */
static void spread(flood *w, int n_own) {
    uint8_t is_done[MOST_FACETS] = {0};
    int n_seen = n_own;
    for (int is_more = 1; is_more;) {
        is_more = 0;
        for (int i = 0; i < w->n; i++) {
            while (n_seen <= i)
                see(w, n_seen++);
            if (is_done[i] || !(w->near[i] < w->square) || !is_upright((const double(*)[3])w->x[i]))
                continue;
            is_done[i] = 1;
            is_more = 1;
            go_on(w, i);
        }
    }
}

/** Flood the disc, which becomes smaller where it has to; 0: there is none. */
static int flood_disc(flood *w, int32_t node) {
    const planish_shape *s = w->shape;
    double farthest = 0;
    w->n = 0;
    for (int64_t i = s->offset[node]; i < s->offset[node + 1] && i < s->offset[node] + MOST_FACETS;
         i++)
        reach(w, s->facet_of[i], 0);
    const int n_own = w->n;
    for (int i = 0; i < n_own; i++) {
        see(w, i);
        for (int k = 0; k < 3; k++)
            farthest = larger(pl_dot(2, w->x[i][k], w->x[i][k]), farthest);
    }
    w->square = REACH * REACH * farthest;
    spread(w, n_own);
    for (int i = 0; i < w->n; i++)
        if (w->near[i] < w->square && !is_upright((const double(*)[3])w->x[i]))
            w->square = w->near[i];
    return w->square > 0;
}

/* ---- heights ---------------------------------------------------------------------------------- */

/** Solve the equations m [row][unknown, .., right side], positive definite; 0: they are singular. */
static int solve(double m[3][4], double x[3]) {
    const double diagonal[3] = {m[0][0], m[1][1], m[2][2]};
    for (int i = 0; i < 3; i++) {
        if (!(m[i][i] > SINGULAR * diagonal[i]))
            return 0;
        for (int j = i + 1; j < 3; j++) {
            const double factor = m[j][i] / m[i][i];
            for (int k = i; k < 4; k++)
                m[j][k] -= factor * m[i][k];
        }
    }
    for (int i = 2; i >= 0; i--) {
        double rest = m[i][3];
        for (int k = i + 1; k < 3; k++)
            rest -= m[i][k] * x[k];
        x[i] = rest / m[i][i];
    }
    return 1;
}

/** Fit q to the corners of all facets: least squares. */
static void fit(const flood *w, float curve[3]) {
    double m[3][4] = {{0}}, x[3] = {0, 0, 0};
    for (int i = 0; i < w->n; i++)
        for (int k = 0; k < 3 && w->near[i] < w->square; k++) {
            const double u = w->x[i][k][0], v = w->x[i][k][1];
            const double row[4] = {u * u, u * v, v * v, w->x[i][k][2]};
            for (int a = 0; a < 3; a++)
                for (int b = 0; b < 4; b++)
                    m[a][b] += row[a] * row[b];
        }
    const int is_fit = solve(m, x);
    for (int d = 0; d < 3; d++)
        curve[d] = is_fit ? (float)x[d] : 0;
}

/** Return twice the rise of q between two points: at most a quarter of that is between them. */
static double bend_between(const pl_disc *disc, const pl_disc_point *a, const pl_disc_point *b) {
    const double u = b->u - a->u, v = b->v - a->v;
    return u * (disc->curve[0] * u + disc->curve[1] * v) + v * v * disc->curve[2];
}

/** Set the range of r over a triangle of three points.
 *
 *  At the point with weights l r is the mean of the corners' r plus the sum of l_i l_j B_ij, B_ij the bend
 *  along the edge of corners i and j. The sum is no more than a / 4 + c / 12, a the largest of them, c the
 *  least, both or neither above 0. */
static void range_of(const pl_disc *disc, const pl_disc_point *const p[3], double *lowest,
                     double *highest) {
    double least = INFINITY, most = -INFINITY;
    *lowest = INFINITY;
    *highest = -INFINITY;
    for (int k = 0; k < 3; k++) {
        const double bend = bend_between(disc, p[k], p[k < 2 ? k + 1 : 0]);
        least = bend < least ? bend : least;
        most = bend > most ? bend : most;
        *lowest = p[k]->r < *lowest ? p[k]->r : *lowest;
        *highest = p[k]->r > *highest ? p[k]->r : *highest;
    }
    if (most > 0)
        *highest += most / 4 + (least > 0 ? least / 12 : 0);
    if (least < 0)
        *lowest += least / 4 + (most < 0 ? most / 12 : 0);
}

double pl_disc_bound(const pl_disc_frame *f, const pl_disc_point *a, const pl_disc_point *b,
                     const pl_disc_point *c) {
    const pl_disc_point *const p[3] = {a, b, c};
    double lowest, highest;
    range_of(f->disc, p, &lowest, &highest);
    const double above = highest - f->disc->lowest, below = f->disc->highest - lowest;
    return (above > below ? above : below) * MORE;
}

/** Set the range of r of the facets, with a margin for roundings. */
static void find_range(const flood *w, pl_disc *disc) {
    double lowest = 0, highest = 0, reach = 0;
    for (int i = 0; i < w->n; i++) {
        pl_disc_point at[3];
        double low, high;
        if (!(w->near[i] < w->square))
            continue;
        for (int k = 0; k < 3; k++) {
            const double *x = w->x[i][k];
            at[k] = (pl_disc_point){x[0], x[1], 0};
            at[k].r = x[2] - (x[0] * (disc->curve[0] * x[0] + disc->curve[1] * x[1]) +
                              x[1] * x[1] * disc->curve[2]);
            reach = larger(fabs(x[0]) + fabs(x[1]) + fabs(x[2]) + fabs(at[k].r), reach);
        }
        range_of(disc, (const pl_disc_point *const[3]){&at[0], &at[1], &at[2]}, &low, &high);
        lowest = low < lowest ? low : lowest;
        highest = larger(high, highest);
    }
    /* a float has 24 bits */
    disc->lowest = (float)(lowest - (highest - lowest) * 0x1p-20 - reach * 0x1p-40);
    disc->highest = (float)(highest + (highest - lowest) * 0x1p-20 + reach * 0x1p-40);
    disc->radius2 = (float)(w->square * (1 - 0x1p-20));
}

void pl_disc_find(const planish_shape *shape, int32_t node, pl_disc *disc) {
    flood w = {.shape = shape};
    *disc = (pl_disc){.radius2 = 0};
    pl_disc_set_frame(shape, node, disc, &w.frame);
    if (!flood_disc(&w, node))
        return;
    fit(&w, disc->curve);
    find_range(&w, disc);
}
