/* memberships: the sets that each of many things is in, and the entities of the model for them.
 *
 *   io_memberships_begin, _add, _counted, _destroy   make the lists
 *   io_memberships_renumber                          give sets other numbers
 *   io_memberships_entities, _of_nodes               make entities of them
 *
 * Every set says twice what is in it: the first time that is counted, the second time listed. If it
 * says something else the second time, as its file has changed, the lists are wrong, but no memory
 * is. The model owns the results.
 */
#ifndef PL_IO_CORE_MEMBERSHIPS_H
#define PL_IO_CORE_MEMBERSHIPS_H

#include "io/core/model.h"

/** Sets of thing i: list[start[i]] .. list[start[i + 1] - 1], in order, by their tags. */
typedef struct io_memberships {
    int64_t n;
    int64_t *start; /* [n + 1] */
    int32_t *list;
    int32_t *last; /* [n] the set that had the thing last, or 0 */
    int is_counted;
    int is_renumbered;
} io_memberships;

/** Begin the lists of n things. To be destroyed in any case. */
int io_memberships_begin(io_memberships *memberships, int64_t n, planish_error *error);

/** Put a thing into the set of that tag, 1 or more; once more does no harm. Sets come one after
 *  another, both times in the same order. */
void io_memberships_add(io_memberships *memberships, int64_t thing, int32_t tag);

/** Note that all have been counted: next they are to be listed. */
int io_memberships_counted(io_memberships *memberships, planish_error *error);

/** Replace the tag k of each set by number[k - 1], once all have been listed. */
void io_memberships_renumber(io_memberships *memberships, const int32_t *number);

/** Find the entities of n things from first on, made if new: entity [n], which the caller has
 * allocated (for cells: by io_cells_reserve, with_entity). Their physical tags are the sets of the
 * thing, their tag is 1 + region [n], or 0 where region is NULL (renumbered: the number of the first
 * set). With dim 0 a thing in no set has none (-1). */
int io_memberships_entities(const io_memberships *memberships, io_model *model, int dim,
                            int64_t first, int64_t n, const int32_t *region, int32_t *entity,
                            planish_error *error);

/** Find the entities of all nodes, which the things are, and allocate model->node_entity for them.
 */
int io_memberships_of_nodes(const io_memberships *memberships, io_model *model,
                            planish_error *error);

/** Release the lists. */
void io_memberships_destroy(io_memberships *memberships);

#endif
