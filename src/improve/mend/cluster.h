/* cluster: nodes that are moved together, and the elements at them.
 *
 * A cluster is filled (_add_element, _add_nodes), begun, moved, and emptied again. It is moved
 * serially, in the order in which nodes were added: the same bits on any number of threads.
 */
#ifndef PL_IMPROVE_MEND_CLUSTER_H
#define PL_IMPROVE_MEND_CLUSTER_H

#include "improve/mend/star.h"

/** Elements and nodes that are worked on together. Arrays are owned. */
typedef struct pl_cluster {
    pl_mend *curve;
    pl_mend_star star; /* its target is of the elements */
    int64_t n_handles, n_elements, handle_room, element_room;
    pl_handle *handle;  /* [n_handles] */
    int32_t *element;   /* [n_elements] */
    uint8_t *was_valid; /* [n_elements] of pl_cluster_note_valid; NULL: not called yet */
    int32_t *handle_of; /* [nodes of the mesh] -1: none */
    uint8_t *is_member; /* [elements of the plan] */
} pl_cluster;

/** Make an empty cluster. To be destroyed in any case. Errors: _MEMORY. */
int pl_cluster_create(pl_mend *curve, pl_cluster *c, planish_error *error);

/** Free the arrays of c. */
void pl_cluster_destroy(pl_cluster *c);

/** Remove all nodes and elements. */
void pl_cluster_empty(pl_cluster *c);

/** Add an element, if it is not there. */
void pl_cluster_add_element(pl_cluster *c, int32_t element);

/** Add the nodes of an element that are mids, or (with_corners) free corners, and the elements at
 *  them. */
void pl_cluster_add_nodes(pl_cluster *c, int64_t element, int with_corners);

/** Set the wanted D of the elements: their own as straight ones, or the mean around where that is not
 *  positive; and note which elements are valid. */
void pl_cluster_begin(pl_cluster *c);

/** Note which elements are valid now. */
void pl_cluster_note_valid(pl_cluster *c);

/** Keep the places of all nodes. */
void pl_cluster_save(pl_cluster *c);

/** Return all nodes to the places that were kept. */
void pl_cluster_restore(const pl_cluster *c);

/** Return nodes to their places until no element that was valid before is invalid. */
void pl_cluster_restore_invalid(const pl_cluster *c);

/** Whether the present places can be taken: fewer elements are invalid, or (or_as_many) as many, and
 *  none that was valid; and if corners have moved no element is worse than any was at the start. */
int pl_cluster_can_be_taken(const pl_cluster *c, int or_as_many);

/** Sweep until the elements that are not given up have positive coefficients. *effort falls by the
 *  visits; the sweeps end when it is negative. */
void pl_cluster_untangle(pl_cluster *c, int64_t *effort);

/** Minimise the mean ratios. */
void pl_cluster_smooth(pl_cluster *c);

#endif
