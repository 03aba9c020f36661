/* plane_fit: the tilted plane that fits the nodes of triangles best.
 *
 * Least squares: the normal is the direction in which the nodes spread least. What spreads little
 * is seen in a frame that goes along with it, so that a narrow strip has as good a normal as a
 * square; the frame is found again in its own coordinates. Sums are over nodes in their order.
 */
#include "io/file/plane.h"

#include "base/memory.h"
#include "base/status.h"

#include <float.h>
#include <math.h>

/** The nodes of triangles about the middle of their box, in units of its diagonal. */
typedef struct cloud {
    const io_model *model;
    const uint8_t *is_used;
    double middle[3], size;
} cloud;

/** frame [3][3]: unit vectors in rows. */
static void coordinates_in(const cloud *c, const double frame[3][3], int64_t node, double out[3]) {
    double x[3];
    for (int d = 0; d < 3; d++)
        x[d] = (c->model->xyz[3 * node + d] - c->middle[d]) / c->size;
    for (int i = 0; i < 3; i++)
        out[i] = frame[i][0] * x[0] + frame[i][1] * x[1] + frame[i][2] * x[2];
}

static void find_mean(const cloud *c, const double frame[3][3], double mean[3]) {
    int64_t n = 0;
    double x[3];
    mean[0] = mean[1] = mean[2] = 0;
    for (int64_t node = 0; node < c->model->n_nodes; node++) {
        if (!c->is_used[node])
            continue;
        coordinates_in(c, frame, node, x);
        for (int d = 0; d < 3; d++)
            mean[d] += x[d];
        n++;
    }
    for (int d = 0; d < 3; d++)
        mean[d] /= (double)n;
}

static void find_spread(const cloud *c, const double frame[3][3], const double mean[3],
                        double spread[3][3]) {
    double x[3];
    for (int i = 0; i < 9; i++)
        spread[i / 3][i % 3] = 0;
    for (int64_t node = 0; node < c->model->n_nodes; node++) {
        if (!c->is_used[node])
            continue;
        coordinates_in(c, frame, node, x);
        for (int i = 0; i < 9; i++)
            spread[i / 3][i % 3] += (x[i / 3] - mean[i / 3]) * (x[i % 3] - mean[i % 3]);
    }
}

/** Turn rows p and q of the frame, and the spread along with it, so that spread[p][q] vanishes. */
static void turn(double spread[3][3], double frame[3][3], int p, int q) {
    if (spread[p][q] == 0)
        return;
    const double theta = (spread[q][q] - spread[p][p]) / (2 * spread[p][q]);
    const double t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));
    const double c = 1 / sqrt(t * t + 1), s = t * c;
    for (int i = 0; i < 3; i++) {
        const double a = spread[i][p], b = spread[i][q];
        spread[i][p] = c * a - s * b;
        spread[i][q] = s * a + c * b;
    }
    for (int i = 0; i < 3; i++) {
        const double a = spread[p][i], b = spread[q][i], f = frame[p][i], g = frame[q][i];
        spread[p][i] = c * a - s * b;
        spread[q][i] = s * a + c * b;
        frame[p][i] = c * f - s * g;
        frame[q][i] = s * f + c * g;
    }
}

/** Jacobi's method. */
static void turn_to_axes(double spread[3][3], double frame[3][3]) {
    enum { SWEEPS = 30 };
    for (int i = 0; i < SWEEPS; i++) {
        turn(spread, frame, 0, 1);
        turn(spread, frame, 0, 2);
        turn(spread, frame, 1, 2);
    }
}

/** The row along which nodes spread least, or but for one. */
static int rank(const double spread[3][3], int wanted) {
    int order[3] = {0, 1, 2};
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            if (spread[order[k]][order[k]] > spread[order[k + 1]][order[k + 1]]) {
                const int swapped = order[k];
                order[k] = order[k + 1];
                order[k + 1] = swapped;
            }
    return order[wanted];
}

static void make_unit(double v[3]) {
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int d = 0; d < 3; d++)
        v[d] /= length;
}

/** The column that the normal is nearest to; of equals z, then x. */
static int column_across(const double normal[3]) {
    const double equal = 1 - 1e-6;
    const double most = fmax(fabs(normal[0]), fmax(fabs(normal[1]), fabs(normal[2])));
    return fabs(normal[2]) >= equal * most ? 2 : fabs(normal[0]) >= equal * most ? 0 : 1;
}

/** Where the columns are the origin's: 0 where that is near, so that nothing is rounded. */
static void set_origin(const cloud *c, const double mean[3], io_plane *plane) {
    const double near = 2;
    double from_mean[2];
    for (int d = 0; d < 2; d++) {
        const double middle = c->middle[plane->axis[d]];
        plane->origin[d] = fabs(middle) > near * c->size ? middle : 0;
        from_mean[d] = (plane->origin[d] - middle) - c->size * mean[plane->axis[d]];
    }
    plane->origin[2] = c->middle[plane->axis[2]] +
                       (c->size * mean[plane->axis[2]] + plane->slope[0] * from_mean[0] +
                        plane->slope[1] * from_mean[1]);
}

static void set_frame(const double normal[3], io_plane *plane) {
    plane->axis[2] = column_across(normal);
    plane->axis[0] = (plane->axis[2] + 1) % 3;
    plane->axis[1] = (plane->axis[2] + 2) % 3;
    const double *n = normal;
    const double p = plane->slope[0] = -n[plane->axis[0]] / n[plane->axis[2]];
    const double q = plane->slope[1] = -n[plane->axis[1]] / n[plane->axis[2]];
    plane->xu = sqrt(1 + p * p);
    plane->yu = p * q / plane->xu;
    plane->yv = sqrt((1 + p * p + q * q) / (1 + p * p));
}

/** How far the nodes are off, at most. */
static double find_off(const cloud *c, const double normal[3], const double mean[3]) {
    double most = 0;
    for (int64_t node = 0; node < c->model->n_nodes; node++) {
        double sum = 0;
        for (int d = 0; c->is_used[node] && d < 3; d++)
            sum += normal[d] * ((c->model->xyz[3 * node + d] - c->middle[d]) / c->size - mean[d]);
        most = fmax(most, fabs(sum));
    }
    return most * c->size;
}

/** 0, or -1: the nodes are on a line, as far as can be told. */
static int fit(const cloud *c, io_plane *plane) {
    enum { PASSES = 3 };
    const double narrow = 1e-12, thick = 30; /* of the diagonal; times what they are off */
    const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, spread[3][3], mean[3];
    int64_t n = 0;
    for (int64_t node = 0; node < c->model->n_nodes; node++)
        n += c->is_used[node];
    for (int pass = 0; pass < PASSES; pass++) {
        find_mean(c, frame, mean);
        find_spread(c, frame, mean, spread);
        turn_to_axes(spread, frame);
        for (int i = 0; i < 3; i++)
            make_unit(frame[i]);
    }
    const int least = rank(spread, 0), second = rank(spread, 1);
    const double width = c->size * sqrt(fmax(spread[second][second], 0) / (double)n);
    find_mean(c, axes, mean);
    set_frame(frame[least], plane);
    set_origin(c, mean, plane);
    plane->size = c->size;
    plane->off = find_off(c, frame[least], mean);
    plane->is_tilted = 1;
    return width > narrow * c->size && width > thick * plane->off ? 0 : -1;
}

static uint8_t *find_used(const io_model *model) {
    uint8_t *is_used = pl_alloc_zero(model->n_nodes, 1);
    for (int64_t i = 0; is_used && i < 3 * model->triangle.n; i++)
        is_used[model->triangle.nodes[i]] = 1;
    return is_used;
}

int io_plane_fit(const io_model *model, const double low[3], const double high[3], io_plane *plane,
                 int *is_thin, planish_error *error) {
    cloud c = {.model = model, .size = 0};
    *plane = (io_plane){.off = INFINITY};
    for (int d = 0; d < 3; d++) {
        c.middle[d] = low[d] + (high[d] - low[d]) / 2;
        c.size = hypot(c.size, high[d] - low[d]);
    }
    if (!(c.size <= DBL_MAX && c.size >= DBL_MIN))
        return PLANISH_OK;
    uint8_t *is_used = find_used(model);
    if (!is_used)
        return pl_fail_memory(error, "the plane of the triangles");
    c.is_used = is_used;
    *is_thin = fit(&c, plane) != 0;
    pl_free(is_used);
    return PLANISH_OK;
}
