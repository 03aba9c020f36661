/* patch: some nodes as one vector.
 *
 * Sweeps move one node at a time and repair errors within a few elements. Where much is tangled,
 * or a boundary has moved far, all nodes must move together. Vectors are over the patch's nodes
 * in visiting order, [n][dim]; their products are sums over the nodes, rounded once.
 *
 *   pl_patch_create, _destroy, _vector, _node         a patch, its vectors and nodes
 *   pl_patch_for, _product, _combine                  arithmetic of vectors
 *   pl_patch_take, _put, _admit                       exchange with the mesh
 *   pl_patch_centre                                   nodes to the mean of their neighbours
 */
#ifndef PL_IMPROVE_PATCH_H
#define PL_IMPROVE_PATCH_H

#include "base/parallel.h"
#include "sweep/run.h"

/** A patch; arrays are owned. */
typedef struct pl_patch {
    pl_run *run;
    const pl_star_problem *problem; /* says where nodes can be */
    int dim;
    int64_t n, n_all; /* nodes; and of all processes */
    int32_t *star;    /* [n] */
    double *vectors;  /* those that pl_patch_create was asked for, zero at first */
    double *field;    /* [n_nodes][dim] by inner numbers, 0 outside of the patch */
} pl_patch;

/** Make a patch of the nodes that in_patch [n_nodes] marks by inner numbers. Returns 0 without
 * memory; destroy the patch in any case. */
int pl_patch_create(pl_run *run, const pl_star_problem *problem, const uint8_t *in_patch,
                    int n_vectors, pl_patch *p);

/** Free the arrays of p. */
void pl_patch_destroy(pl_patch *p);

/** Vector i of the patch, [n][dim]; the patch owns it. */
static inline double *pl_patch_vector(const pl_patch *p, int i) {
    return p->vectors + p->n * p->dim * i;
}

/** Inner number of the patch's node i. */
static inline int64_t pl_patch_node(const pl_patch *p, int64_t i) {
    return p->run->plan->interior.centre[p->star[i]];
}

/** Call body for chunks of the patch's nodes. */
void pl_patch_for(const pl_patch *p, pl_chunk_fn *body, void *context);

/** Return b . c. */
double pl_patch_product(const pl_patch *p, const double *b, const double *c);

/** Set a to b + factor c; b NULL: to 0 + factor c, whose zeros have no sign. */
void pl_patch_combine(const pl_patch *p, double *a, const double *b, double factor,
                      const double *c);

/** Set a from an array field [n_nodes][dim]. */
void pl_patch_take(const pl_patch *p, double *a, const double *field);

/** Copy a vector a of the patch to an array field [n_nodes][dim]. */
void pl_patch_put(const pl_patch *p, double *field, const double *a);

/** Put the nodes to x, or as near as their bounds let them, or where that is not to be stored to
 *  start. x becomes where they are. */
void pl_patch_admit(const pl_patch *p, double *x, const double *start);

/** Move the nodes to the places at which each is at the mean of its neighbours, by conjugate
 *  gradients. The patch has at least PL_CENTRE_VECTORS vectors. The iterations end early if
 *  tally->stopped is set. */
void pl_patch_centre(const pl_patch *p, pl_sweep_tally *tally);

enum { PL_CENTRE_VECTORS = 6 };

#endif
