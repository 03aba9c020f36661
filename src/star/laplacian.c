/* laplacian: move a node to an average of its surroundings: the smoothers that the paper compares
 * with. Unguarded: an element may be inverted. Plain sums in the order of the ring and the link.
 */
#define PL_PACK 1
#include "star/laplacian.h"

#include "star/kernel_step.h"

/** Weighted sum of offsets from the node, in the star's scale. */
typedef struct average {
    double sum[3], weight;
} average;

/** Add an offset [dim] with its weight. */
static void add_offset(average *a, const double *offset, double weight, const int dim) {
    for (int d = 0; d < dim; d++)
        a->sum[d] += weight * offset[d];
    a->weight += weight;
}

/** Find the offset of the ring's node i from x. */
static void offset_of(const local *here, int64_t i, const double *x, double *offset,
                      const int dim) {
    const double *y = here->problem->coordinates + (int64_t)here->s.ring[i] * dim;
    for (int d = 0; d < dim; d++)
        offset[d] = y[d] * here->s.scale - x[d];
}

/** Mark in the fourth column of the ring's rows the nodes that edges of the elements join to the
 *  star's: not all are. */
static void mark_neighbours(const star *s, const int dim) {
    for (int64_t i = 0; i < s->n_ring; i++)
        s->spare[PL_ROW * i + dim] = !s->form;
    for (int64_t i = 0; s->form && i < s->n_facets; i++)
        for (int j = 0; j < dim; j++)
            if (s->forms[s->form[i]].is_edge[j])
                s->spare[s->facet[i * dim + j] + (uint32_t)dim] = 1;
}

/** Whether the elements' centroids are made of this corner's: the node is the corner, or a vertex of a
 *  simplex, or the apex of a pyramid, at which there is no corner. */
static int has_centroid(const star *s, int64_t facet) {
    const uint8_t code = s->form ? (uint8_t)s->form[facet] : 0;
    const int is_simplex = pl_corner_kind(code) == PL_KIND_SIMPLEX;
    return is_simplex || s->forms[code].corner < 0 ||
           code >> 1 == pl_form_code(pl_corner_code(PL_KIND_PYRAMID, 0), 3, 0) >> 1;
}

/** Mean of the neighbours, all alike or weighted by their distance; *size2 becomes the mean square
 *  distance. */
static average of_neighbours(const local *here, const double *x, int by_length, double *size2,
                             const int dim) {
    average a = {{0, 0, 0}, 0};
    int64_t n = 0;
    *size2 = 0;
    mark_neighbours(&here->s, dim);
    for (int64_t i = 0; i < here->s.n_ring; i++)
        n += here->s.spare[PL_ROW * i + dim] > 0;
    for (int64_t i = 0; i < here->s.n_ring; i++) {
        double offset[3] = {0, 0, 0};
        if (!(here->s.spare[PL_ROW * i + dim] > 0))
            continue;
        offset_of(here, i, x, offset, dim);
        double square = dot(offset, offset, dim);
        add_offset(&a, offset, by_length ? sqrt(square) : 1, dim);
        *size2 += square / (double)n;
    }
    return a;
}

/** Mean of the elements' centroids, weighted by their volumes; of corners those at the node. */
static average of_centroids(const local *here, const double *x, const int dim) {
    average a = {{0, 0, 0}, 0};
    for (int64_t i = 0; i < here->s.n_facets; i++) {
        double v[3][3] = {{0}}, centroid[3] = {0, 0, 0};
        if (!has_centroid(&here->s, i))
            continue;
        for (int j = 0; j < dim; j++) {
            offset_of(here, here->s.facet[i * dim + j] / PL_ROW, x, v[j], dim);
            for (int d = 0; d < dim; d++)
                centroid[d] += v[j][d] / (dim + 1);
        }
        const double volume = /* times 2 or 6 */
            dim == 2 ? v[0][0] * v[1][1] - v[0][1] * v[1][0]
                     : v[0][0] * (v[1][1] * v[2][2] - v[1][2] * v[2][1]) +
                           v[0][1] * (v[1][2] * v[2][0] - v[1][0] * v[2][2]) +
                           v[0][2] * (v[1][0] * v[2][1] - v[1][1] * v[2][0]);
        add_offset(&a, centroid, fabs(volume), dim);
    }
    return a;
}

/** Move one node, but no farther than its bounds. */
static void visit(const pl_star_problem *problem, planish_method method, int64_t index,
                  double *scratch, const int dim) {
    const int guarded = problem->guard != NULL;
    const int32_t node = problem->node[index];
    double *place = problem->coordinates + (int64_t)node * dim, x[3], to[3], size2;
    int64_t evaluations = 0;
    local here;
    local_init(&here, problem, index, place, NULL, scratch, &evaluations, guarded, dim);
    to_star(&here, place, x, dim);
    if (guarded && pl_star_is_held(problem->guard, node, dim))
        return;
    if (problem->rr2_skip > 0 && !(value_at(&here.s, x, guarded, dim).max > problem->rr2_skip))
        return;
    average a = of_neighbours(&here, x, method == PLANISH_METHOD_LENGTH_LAPLACIAN, &size2, dim);
    if (method == PLANISH_METHOD_AREA_LAPLACIAN)
        a = of_centroids(&here, x, dim);
    if (!(a.weight > 0) || !(a.weight < INFINITY))
        return;
    for (int d = 0; d < dim; d++)
        a.sum[d] /= a.weight;
    place_along(&here, x, a.sum, 1, to, guarded, dim);
    if (!guarded || within_bounds(&here.b, to, dim)) /* rounding to float may have left them */
        move_node(&here, node, to, size2, FALL_TOLD, 1, place, dim);
}

void pl_star_average(const pl_star_problem *problem, planish_method method, int dim, int64_t begin,
                     int64_t end, double *scratch, pl_star_tally *tally) {
    for (int64_t i = begin; i < end; i++) {
        if (!claim(problem, i))
            continue;
        if (dim == 3)
            visit(problem, method, i, scratch, 3);
        else
            visit(problem, method, i, scratch, 2);
        tally->visits++;
        tally->evaluations++;
    }
}
