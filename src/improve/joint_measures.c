/* joint_measures: angles and ratios of elements. */
#include "improve/joint_measures.h"

#include "base/parallel.h"
#include "base/parts.h"
#include "quality/measure_block.h"

#include <math.h>

pl_joint_measure pl_joint_measure_of(const pl_run *r, int other) {
    const planish_worst worst = r->options->worst;
    const int is_angle =
        (worst == PLANISH_WORST_ANGLE || worst == PLANISH_WORST_SCALED_JACOBIAN) != (other != 0);
    if (r->plan->work.corner)
        return is_angle ? PL_JOINT_JACOBIAN : PL_JOINT_MEAN;
    return is_angle ? PL_JOINT_ANGLE : PL_JOINT_RATIO;
}

double pl_joint_value_of_square(pl_joint_measure kind, double square) {
    if (!(square < INFINITY))
        return 0;
    return kind == PL_JOINT_ANGLE ? pl_angle_between(1, sqrt(fmax(square - 1, 0)))
                                  : 1 / sqrt(square);
}

double pl_joint_value_of(const pl_run *r, double square) {
    return pl_joint_value_of_square(pl_joint_measure_of(r, 0), square);
}

void pl_joint_find_vertices(const pl_joint *joint, const pl_joint_element *e, double x[4][3]) {
    const int dim = joint->run->plan->dim;
    for (int v = 0; v <= dim; v++)
        for (int d = 0; d < dim; d++)
            x[v][d] = pl_joint_place(joint, e->node[v])[d] * joint->run->measure_scale;
}

int pl_joint_measures_of(const pl_run *r, pl_joint_measure kind, uint8_t form, const double x[4][3],
                         int derive, pl_slope slope[]) {
    const int dim = r->plan->dim;
    const pl_corner_form *of = &r->plan->form[form];
    if (kind == PL_JOINT_ANGLE)
        return dim == 3 ? pl_angle_slopes(3, x, derive, slope)
                        : pl_angle_slopes(2, x, derive, slope);
    if (kind == PL_JOINT_JACOBIAN)
        return pl_jacobian_slopes(dim, x, of, pl_corner_kind(form) == PL_KIND_SIMPLEX, derive,
                                  slope);
    if (kind == PL_JOINT_MEAN)
        pl_mean_slope(dim, x, of, derive, slope);
    else
        pl_ratio_slope(dim, x, derive, slope);
    return 1;
}

double pl_joint_least_measure(const pl_run *r, pl_joint_measure kind, uint8_t form,
                              const double x[4][3]) {
    pl_slope slope[PL_MOST_SLOPES];
    const int n = pl_joint_measures_of(r, kind, form, x, 0, slope);
    double least = INFINITY;
    for (int k = 0; k < n; k++)
        least = slope[k].value < least ? slope[k].value : least;
    return least;
}

double pl_joint_value(const pl_joint *joint, const pl_joint_element *e) {
    double x[4][3] = {{0}};
    pl_joint_find_vertices(joint, e, x);
    return pl_joint_least_measure(joint->run, pl_joint_measure_of(joint->run, 0), e->form,
                                  (const double(*)[3])x);
}

double pl_joint_determinant_of(int dim, const double x[4][3], int *certain) {
    double edge[3][3], product = 1;
    for (int j = 0; j < dim; j++) {
        double norm = 0;
        for (int d = 0; d < dim; d++) {
            edge[j][d] = x[j + 1][d] - x[0][d];
            norm += fabs(edge[j][d]);
        }
        product *= norm;
    }
    const double D = pl_determinant_of_edges(dim, (const double(*)[3])edge);
    *certain = D > (dim == 3 ? PL_ERROR_3D : PL_ERROR_2D) * product;
    return D;
}

/* ---- the largest angle ---------------------------------------------------------------------- */

enum { LANES = 8 }; /* elements whose angles are found at once */

/** Search for the largest angle: the smallest cosine. */
typedef struct angle_search {
    const pl_run *run;
    const double *coordinates; /* [.][dim] */
    const int32_t *number;     /* of the mesh's nodes in them; NULL: the same */
    double *cosine;            /* [threads] */
} angle_search;

/** Lower s->cosine of the thread to those of the elements from first to first + LANES - 1 that are
 *  before end and have a movable node. */
PL_INLINE void search_elements(const angle_search *s, int64_t first, int64_t end, int thread,
                               const int dim) {
    const planish_plan *plan = s->run->plan;
    double x[4][3][LANES], cosine[LANES];
    for (int l = 0; l < LANES; l++) {
        const int64_t i = first + l < end ? first + l : first;
        const int32_t *node = plan->work.elements + i * (dim + 1);
        for (int v = 0; v <= dim; v++)
            for (int d = 0; d < dim; d++)
                x[v][d][l] =
                    s->coordinates[(s->number ? s->number[node[v]] : node[v]) * (int64_t)dim + d] *
                    s->run->measure_scale;
    }
    for (int l = 0; l < LANES; l++) {
        double edge[3][3];
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                edge[j][d] = x[j + 1][d][l] - x[0][d][l];
        cosine[l] = pl_shape_of_edges(dim, (const double(*)[3])edge).smallest_cosine;
    }
    for (int l = 0; l < LANES && first + l < end; l++)
        if (cosine[l] < s->cosine[thread] &&
            pl_any_moves(plan->work.mobility, plan->work.elements + (first + l) * (dim + 1),
                         dim + 1))
            s->cosine[thread] = cosine[l];
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const angle_search *s = context;
    for (int64_t i = begin; i < end; i += LANES)
        if (s->run->plan->dim == 3)
            search_elements(s, i, end, thread, 3);
        else
            search_elements(s, i, end, thread, 2);
}

double pl_joint_find_largest_angle(const pl_run *r) {
    enum { CHUNK = 4096 };
    const planish_plan *plan = r->plan;
    double cosine[PL_MAX_THREADS] = {0}, least = 1;
    const angle_search now = {r, plan->scratch.coordinates, plan->inner, cosine},
                       start = {r, r->given, NULL, cosine};
    for (int t = 0; t < plan->threads; t++)
        cosine[t] = 1;
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, search_chunk,
                    (void *)(uintptr_t)&now);
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, search_chunk,
                    (void *)(uintptr_t)&start);
    for (int t = 0; t < plan->threads; t++)
        least = cosine[t] < least ? cosine[t] : least;
    pl_parts_smallest(&least, 1);
    return pl_arc_cosine(least);
}
