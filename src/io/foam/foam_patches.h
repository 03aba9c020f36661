/* foam_patches: patches of the boundary and zones: sets of faces, cells and points.
 *
 *   foam_sets                              sets
 *   foam_read_patches, foam_use_patches    the patches
 *   foam_read_zones                        the zones
 */
#ifndef PL_IO_FOAM_FOAM_PATCHES_H
#define PL_IO_FOAM_FOAM_PATCHES_H

#include "io/foam/foam_faces.h"
#include "io/foam/foam_file.h"

/** Sets of faces, cells or points: patches, groups of patches, zones. */
typedef enum foam_things { FOAM_POINTS, FOAM_FACES, FOAM_CELLS, FOAM_N_THINGS } foam_things;

typedef struct foam_set {
    char *name; /* owned */
    foam_things things;
    int64_t first, n; /* these faces, */
    int32_t *member;  /* or [n] owned ones */
} foam_set;

/** A patch, as the file says. */
typedef struct foam_patch {
    io_slice name, type, neighbour; /* of the other side, if it is cyclic */
    io_slice groups;                /* the value of inGroups */
    int64_t first, n;               /* faces; -1: not said */
    const char *at;
} foam_patch;

typedef struct foam_patches {
    foam_file file;
    foam_patch *patch; /* [n] owned */
    int64_t n, capacity;
    int64_t n_behind; /* faces up to the last of the last patch */
} foam_patches;

typedef struct foam_sets {
    foam_set *set; /* [n] */
    int64_t n, capacity;
} foam_sets;

/** Read the patches of the boundary. To be released in any case. */
int foam_read_patches(const foam_mesh *mesh, foam_patches *patches, planish_error *error);

/** Hold the nodes of patches that must not move, add the sets of faces. */
int foam_use_patches(const foam_mesh *mesh, const foam_patches *patches, foam_sets *sets,
                     planish_error *error);

/** Release the patches. */
void foam_release_patches(foam_patches *patches);

/** Read the zones that are there. */
int foam_read_zones(const foam_mesh *mesh, foam_sets *sets, planish_error *error);

/** Release the sets. */
void foam_release_sets(foam_sets *sets);

#endif
