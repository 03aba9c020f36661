/* vtu_groups: the named groups of a mesh that is written as VTK's XML file, one for each name.
 *
 *   vtu_groups, vtu_groups_make, _release     the groups
 */
#ifndef PL_IO_VTK_VTU_GROUPS_H
#define PL_IO_VTK_VTU_GROUPS_H

#include "io/view/view.h"

/** Groups of one name and dimension are one, which has the first of their numbers. They stay apart, and
 *  have names with their numbers, where one of these has other names, too. */
typedef struct vtu_groups {
    int32_t *first;  /* [n_groups] of the model: the first group of the same name */
    int32_t *one;    /* [n_groups] the group that each is one with: itself, or one before */
    int32_t *number; /* [n_entities] number of the first group of cells, or 0 */
    int has_joined;  /* some groups of distinct numbers are one */
} vtu_groups;

/** Find the groups; may_join: they may become one. To be released in any case. Error: _MEMORY. */
int vtu_groups_make(const io_view *view, int may_join, vtu_groups *groups, planish_error *error);
/** Release groups. */
void vtu_groups_release(vtu_groups *groups);

/** Note names and numbers that change. */
void vtu_groups_lose(const io_view *view, const vtu_groups *groups, io_losses *losses);

#endif
