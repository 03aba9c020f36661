/* exodus_groups: groups of nodes and facets of a mesh that is written, as node sets and side sets.
 *
 *   exodus_group, exodus_groups                       sets and their members
 *   exodus_groups_of_nodes, _of_facets, _release      those of a mesh
 *   exodus_give_ids                                   numbers of sets and blocks
 */
#ifndef PL_IO_EXODUS_EXODUS_GROUPS_H
#define PL_IO_EXODUS_EXODUS_GROUPS_H

#include "io/exodus/exodus_facets.h"

/** Something that is in a set. */
typedef struct exodus_member {
    int32_t group;  /* the first one that has the name of the set; -1: it has no name, */
    int is_entity;  /* and is of entities in no group */
    int64_t number; /* of the set in the model: the tag of a group or an entity */
    int32_t place;  /* of the node in the file, or of the element that has the side, from 1 */
    int32_t side;   /* 0: of a node */
} exodus_member;

/** A set: all groups of one name, or of one number without a name. */
typedef struct exodus_group {
    int32_t id;
    int64_t number;   /* that it would have: the least positive one of its groups */
    const char *name; /* "": it has none; borrowed */
    int32_t group;    /* the first one that has this name, or -1 */
    int64_t first, n; /* members */
} exodus_group;

typedef struct exodus_groups {
    exodus_member *member; /* sorted by their sets; owned */
    exodus_group *group;   /* [n] by their ids; owned */
    int64_t n, n_members, capacity, member_capacity;
} exodus_groups;

/** Make the node sets of a mesh: by the names of groups of nodes, and by the numbers of nodes but 0 in no
 *  such group. To be released in any case. Error: _MEMORY. */
int exodus_groups_of_nodes(const io_view *view, exodus_groups *groups, planish_error *error);

/** Make the side sets of a mesh: by the names of groups of facets, and by the numbers of facets in no
 *  such group. Facets that are not sides are in none. To be released in any case. Error: _MEMORY. */
int exodus_groups_of_facets(const io_view *view, const io_view_blocks *blocks,
                            const exodus_facets *facets, exodus_groups *groups,
                            planish_error *error);
void exodus_groups_release(exodus_groups *groups);

/** Give ids [n], distinct and from 1: those that are wanted, the first of equal ones, others behind
 *  them. Error: _MEMORY. */
int exodus_give_ids(const int64_t *wanted, int64_t n, int32_t *id, planish_error *error);

#endif
