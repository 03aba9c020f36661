/* plex: files of PETSc's DMPlex, for those who load them with PETSc. */
#ifndef PL_IO_PLEX_PLEX_H
#define PL_IO_PLEX_PLEX_H

#include "io/hdf5/hdf5.h"

typedef struct io_plex_outline {
    int version;
    char name[256];                      /* of the mesh; "": version 1 has none */
    char coordinates[IO_HDF5_PATH_SIZE]; /* path of their dataset */
    int dim, columns;                    /* of the elements; coordinates of a node */
    int64_t n_nodes;
    int has_simplices_alone; /* as elements, and all points are bounded as they must be */
    int has_copies;          /* of the coordinates, or other arrays that are as long */
    int has_regions_alone;   /* no labels but that of regions; an element is of one, never of -1 */
} io_plex_outline;

/** Read the outline of the file at path; but for places of nodes, nothing in it can be out of range
 *  then. */
int io_plex_outline_of(const char *path, io_plex_outline *outline, planish_error *error);

#endif
