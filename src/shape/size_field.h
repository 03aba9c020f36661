/* size_field: the sizes that elements are to have, where they are.
 *
 * Sizes are edge lengths at the nodes of a mesh, or symmetric matrices of those
 * (geometry/metric.h), linear in the simplices that it is cut into (topology/background.h). The
 * target of a corner is an ideal corner of its shape. Its edges are as long as the mean of the
 * sizes at its nodes, times one factor for the whole mesh: a mesh has as many elements as it has,
 * so sizes are met in relation to one another. Let tau be the measure of a corner in units of its
 * wanted measure. The sum of tau over a domain is the number of corners that it would hold with the
 * wanted sizes. So the factor of measures is the mean of tau.
 *
 *   pl_size_field_create, _destroy    the field of a mesh
 *   pl_size_field_begin, _find        sizes at points
 *   pl_sizes_fit                      targets of corners whose nodes have sizes
 *   pl_sized_measure, _metric         measure and metric of one
 */
#ifndef PL_SHAPE_SIZE_FIELD_H
#define PL_SHAPE_SIZE_FIELD_H

#include "geometry/target.h"
#include "topology/background.h"

/** A field of sizes. Arrays are owned. */
typedef struct pl_size_field {
    pl_background background;
    int n_numbers;  /* of a size: 1, or those of a symmetric matrix */
    double largest; /* size that was given; in units of it are */
    double *size;   /* [n_nodes][n_numbers] those at the nodes */
    int32_t *at;    /* [n_nodes] a simplex, where the node was found last; -1: it is of none */
} pl_size_field;

/** Make the field of mesh->size or mesh->metric, of a mesh that is checked, at mesh->reference, or
 *  without that at x [n_nodes][dim]. Places that are not finite, sizes that are not positive and
 *  finite, and sizes that vary by more than 1e12, are errors. *field is to be destroyed in any
 *  case. Errors: _MESH, _MEMORY. */
int pl_size_field_create(const planish_mesh *mesh, const double *x, int threads,
                         pl_size_field *field, planish_error *error);

/** Free what field owns. */
void pl_size_field_destroy(pl_size_field *field);

/** Let the next walks begin at the nodes of the mesh, so that earlier walks do not influence results. */
void pl_size_field_begin(pl_size_field *field);

/** Fill found [n_nodes][n_numbers] with the sizes where the nodes are now: node i at x[place[i]];
 *  place NULL: at x[i]. Walks begin where the last ones have ended. */
void pl_size_field_find(pl_size_field *field, const double *x, const int32_t *place, int threads,
                        double *found);

/** Corners with sizes at their nodes. */
typedef struct pl_sized_corners {
    int dim;
    int64_t n;
    const int32_t *node;   /* [n][dim + 1] */
    const uint8_t *corner; /* [n] geometry/corner.h; NULL: they are simplices */
    int n_numbers;
    const double *size; /* [nodes][n_numbers] */
    const double *x;    /* [.][dim] where nodes are: node i at x[place[i]]; place NULL: x[i] */
    const int32_t *place;
} pl_sized_corners;

/** Make the metric of corner i, which has matrices as sizes. Returns the measure in which it is to be, in
 *  units of that of the ideal corner. */
double pl_sized_metric(const pl_sized_corners *c, int64_t i, pl_metric *metric);

/** Return the measure of corner i, as if it were positive. */
double pl_sized_measure(const pl_sized_corners *c, int64_t i);

/** Fill target [c->n], and if sizes are matrices metric [c->n], which may be NULL. factor: of
 *  lengths; 0: the one by which the domain would hold as many corners as it has. Returns it. */
double pl_sizes_fit(const pl_sized_corners *c, double factor, int threads, pl_target *target,
                    pl_metric *metric);

#endif
