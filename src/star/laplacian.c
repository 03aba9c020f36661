/* laplacian: move a node to an average of its surroundings: the smoothers that the paper compares
 * with. Unguarded: an element may be inverted. Plain sums in the order of the ring and the link.
 */
#include "base/round.h"
#include "star/star.h"

#include <math.h>

/* A move shorter than this fraction of the distance to the neighbours changes nothing for them. */
#define STILL 1e-4

/** A weighted sum of positions relative to the node. */
typedef struct average {
    double sum[3], weight;
} average;

static void add(average *a, const double *offset, double weight, int dim) {
    for (int d = 0; d < dim; d++)
        a->sum[d] += weight * offset[d];
    a->weight += weight;
}

/** offset = neighbour - x, and its length. */
static double offset_of(const pl_star_problem *problem, int32_t neighbour, const double *x,
                        double *offset, int dim) {
    double square = 0;
    for (int d = 0; d < dim; d++) {
        offset[d] = problem->coordinates[(int64_t)neighbour * dim + d] - x[d];
        square += offset[d] * offset[d];
    }
    return sqrt(square);
}

/** Mean of the neighbours, all alike or weighted by their distance; *size2 becomes the mean square
 *  distance. */
static average of_neighbours(const pl_star_problem *problem, int64_t star, const double *x,
                             int by_length, double *size2, int dim) {
    average a = {{0, 0, 0}, 0};
    int64_t begin = problem->ring_offset[star], end = problem->ring_offset[star + 1];
    *size2 = 0;
    for (int64_t i = begin; i < end; i++) {
        double offset[3];
        double length = offset_of(problem, problem->ring[i], x, offset, dim);
        add(&a, offset, by_length ? length : 1, dim);
        *size2 += length * length / (double)(end - begin);
    }
    return a;
}

/** |det| of dim vectors. */
static double volume_of(double v[3][3], int dim) {
    if (dim == 2)
        return fabs(v[0][0] * v[1][1] - v[0][1] * v[1][0]);
    return fabs(v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
                v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
                v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]));
}

/** Mean of the elements' centroids, weighted by their volumes. */
static average of_centroids(const pl_star_problem *problem, int64_t star, const double *x,
                            int dim) {
    average a = {{0, 0, 0}, 0};
    const int32_t *ring = problem->ring + problem->ring_offset[star];
    for (int64_t i = problem->link_offset[star]; i < problem->link_offset[star + 1]; i++) {
        double v[3][3] = {{0}}, centroid[3] = {0, 0, 0};
        for (int j = 0; j < dim; j++) {
            offset_of(problem, ring[problem->link[i * dim + j]], x, v[j], dim);
            for (int d = 0; d < dim; d++)
                centroid[d] += v[j][d] / (dim + 1);
        }
        add(&a, centroid, volume_of(v, dim), dim);
    }
    return a;
}

/* A position pulled back to the distance allowed ends this fraction inside, for rounding. */
#define RADIUS_MARGIN 0x1p-40

static double distance_from_start(const pl_star_guard *guard, int32_t node, const double *x,
                                  int dim) {
    double square = 0;
    for (int d = 0; d < dim; d++) {
        double moved = x[d] - guard->start[(int64_t)node * dim + d];
        square += moved * moved;
    }
    return sqrt(square);
}

/** Bring x within the bounds of the node. */
static void clamp(const pl_star_guard *guard, int32_t node, double *x, int dim) {
    const int64_t first = (int64_t)node * dim;
    double far = guard->radius ? distance_from_start(guard, node, x, dim) : 0;
    for (int d = 0; d < dim; d++) {
        const int64_t i = first + d;
        if (guard->radius && far > guard->radius[node])
            x[d] = guard->start[i] +
                   (x[d] - guard->start[i]) * (guard->radius[node] * (1 - RADIUS_MARGIN) / far);
        if (guard->lower && x[d] < guard->lower[i])
            x[d] = guard->lower[i];
        if (guard->upper && x[d] > guard->upper[i])
            x[d] = guard->upper[i];
    }
}

/** Whether rounding to float has taken x past the distance allowed. */
static int is_too_far(const pl_star_guard *guard, int32_t node, const double *x, int dim) {
    return guard && guard->radius && distance_from_start(guard, node, x, dim) > guard->radius[node];
}

/** Move one node, but no farther than its bounds. */
static void visit(const pl_star_problem *problem, planish_method method, int dim, int64_t star) {
    int32_t node = problem->node[star];
    double *x = problem->coordinates + (int64_t)node * dim, to[3], size2, moved2 = 0;
    average a =
        of_neighbours(problem, star, x, method == PLANISH_METHOD_LENGTH_LAPLACIAN, &size2, dim);
    if (method == PLANISH_METHOD_AREA_LAPLACIAN)
        a = of_centroids(problem, star, x, dim);
    if (!(a.weight > 0) || !(a.weight < INFINITY))
        return;
    for (int d = 0; d < dim; d++)
        to[d] = x[d] + a.sum[d] / a.weight;
    if (problem->guard)
        clamp(problem->guard, node, to, dim);
    for (int d = 0; d < dim; d++) {
        if (problem->to_float)
            to[d] = pl_round_to_float(to[d]);
        moved2 += (to[d] - x[d]) * (to[d] - x[d]);
    }
    if (!(moved2 > 0) || !(moved2 < INFINITY) || is_too_far(problem->guard, node, to, dim))
        return;
    for (int d = 0; d < dim; d++)
        x[d] = to[d];
    if (!(moved2 > STILL * STILL * size2))
        return;
    __atomic_store_n(&problem->changed[node], 1, __ATOMIC_RELAXED);
    for (int64_t i = problem->ring_offset[star]; i < problem->ring_offset[star + 1]; i++)
        __atomic_store_n(&problem->changed[problem->ring[i]], 1, __ATOMIC_RELAXED);
}

pl_star_tally pl_star_average(const pl_star_problem *problem, planish_method method, int dim,
                              int64_t begin, int64_t end) {
    pl_star_tally tally = {0};
    for (int64_t i = begin; i < end; i++) {
        uint8_t *changed = &problem->changed[problem->node[i]];
        if (!__atomic_load_n(changed, __ATOMIC_RELAXED))
            continue;
        __atomic_store_n(changed, 0, __ATOMIC_RELAXED);
        if (problem->guard && pl_star_is_held(problem->guard, problem->node[i], dim))
            continue;
        visit(problem, method, dim, i);
        tally.visits++;
        tally.evaluations++;
    }
    return tally;
}
