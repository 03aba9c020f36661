/* gmsh_write_groups: the physical groups of a file of Gmsh's that is written.
 *
 *   gmsh_physical, gmsh_groups           groups, and which of them entities are in
 *   gmsh_groups_make, _release           make and release them
 *   gmsh_groups_count, _number           those of an entity
 */
#ifndef PL_IO_GMSH_GMSH_WRITE_GROUPS_H
#define PL_IO_GMSH_GMSH_WRITE_GROUPS_H

#include "io/view/view_blocks.h"

/** A physical group: all groups of a name and dimension, or those of a number that has no name. */
typedef struct gmsh_physical {
    int dim;
    int is_own;       /* one of its numbers is the file's */
    const char *name; /* borrowed, or NULL */
} gmsh_physical;

/** Physical groups of a mesh. */
typedef struct gmsh_groups {
    gmsh_physical *group; /* [n] in the file's order, those without a name last */
    int64_t *number;      /* [n] positive, distinct within a dimension; -1: the group is left out */
    int64_t n;
    int64_t *start, *member; /* [n_entities + 1]; the groups of each entity: indices */
} gmsh_groups;

/** Find the groups of entities, and note what is lost. To be released in any case. Error: _MEMORY. */
int gmsh_groups_make(const io_view *view, const io_view_blocks *blocks, gmsh_groups *groups,
                     io_losses *losses, planish_error *error);
/** Release them. */
void gmsh_groups_release(gmsh_groups *groups);

/** Return how many groups an entity (-1: none) is in. */
int64_t gmsh_groups_count(const gmsh_groups *groups, int32_t entity);

/** Return the number of group k, from 0, of an entity; 0: it is in no more groups. */
int64_t gmsh_groups_number(const gmsh_groups *groups, int32_t entity, int64_t k);

#endif
