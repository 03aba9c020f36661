/* points: coordinates as the caller has them: any stride, all nodes or some; and rows of arrays.
 *
 *   pl_points_of, pl_point_at                    where the coordinates are
 *   pl_points_check, _are_dense, _gather         check them, copy them
 *   pl_points_find_doubled                       points at the place of another one
 *   pl_rows_take, pl_rows_put                    rows of any arrays by numbers
 */
#ifndef PL_TOPOLOGY_POINTS_H
#define PL_TOPOLOGY_POINTS_H

#include <planish/planish.h>

/** Points, n of dim coordinates: coordinate d of point i is x[node * step + d * apart], where node
 * is node_of[i], or i without that. */
typedef struct pl_points {
    const double *x;
    int64_t n;
    int dim;
    int64_t step, apart;
    const int32_t *node_of; /* [n] or NULL */
} pl_points;

/** Index in x of coordinate d of point i. */
static inline int64_t pl_point_at(const pl_points *p, int64_t i, int d) {
    return (p->node_of ? p->node_of[i] : i) * p->step + d * p->apart;
}

/** Describe the coordinates x of a mesh's nodes: [n_nodes][dim], or as its strides say. */
pl_points pl_points_of(const planish_mesh *mesh, const double *x);

/** Whether x is [n][dim] as it stands. */
static inline int pl_points_are_dense(const pl_points *p) {
    return !p->node_of && p->step == p->dim && p->apart == 1;
}

/** Copy them to dense [n][dim]. */
void pl_points_gather(const pl_points *p, int threads, double *dense);

/** Check that they are finite. The lowest offender is reported, by the caller's number. */
int pl_points_check(const pl_points *p, int threads, planish_error *error);

/** Find the points that lie at exactly the place of another one: is_doubled [n] becomes 1 for them,
 *  else 0. Causes of doubled points: parts written side by side have the nodes between them twice,
 *  a crack has its nodes twice, and some programs give each element its own points. At most
 *  INT32_MAX points. Errors: _MEMORY. */
int pl_points_find_doubled(const pl_points *points, uint8_t *is_doubled, planish_error *error);

/** Return the rows row [n], of size bytes, of from, as an array of their own. NULL if from is; if it
 *  is not, *failed becomes 1. */
void *pl_rows_take(const void *from, const int32_t *row, int64_t n, size_t size, int threads,
                   int *failed);

/** Copy the n rows of from, of size bytes, to the rows row [n] of to; NULL: to the same. */
void pl_rows_put(const void *from, const int32_t *row, int64_t n, size_t size, int threads,
                 void *to);

#endif
