/* plexfile: meshes in files of PETSc's own, HDF5, through DMPlex: no process has all of a mesh but
 * where DMPlex wants that (PETSc 3.18 loads elements in the first process).
 *
 *     pl_plexfile_read, _cut, _close    a file, and the piece of each process
 *     pl_plexfile_write                 the file with other coordinates (plexrows.h)
 *     pl_plexfile_convert               a file of another mesh
 *     pl_plexfile_finish                the end of both
 */
#ifndef PL_TOOLS_MPI_PLEXFILE_H
#define PL_TOOLS_MPI_PLEXFILE_H

#include "mpi/share.h"

#include "base/output.h"

/** Facts on a file that PETSc needs to read it. */
typedef struct pl_plexform {
    char name[256];         /* of the mesh; "": the file's form has none */
    char coordinates[1024]; /* path of their dataset */
} pl_plexform;

/** A mesh as it was read: each process has some of it. Everything is owned. */
typedef struct pl_plexfile {
    MPI_Comm comm;    /* the caller's, */
    const char *path; /* likewise */
    DM dm;
    PetscSF load;   /* from the file's points, each process a stretch of them, to those of dm */
    int64_t *begin; /* [ranks + 1] of these stretches */
    int64_t n_elements, n_nodes, first_node; /* of all; the file's point of node 0 */
    int dim;
    pl_plexform form;
    int ignore_regions; /* nodes between regions may move; the caller's to set before it is cut, */
    int slides;         /* as this: they are not held; pieces get the regions */
    int is_broken;      /* it could not be read, and HDF5 cannot be left in peace */
} pl_plexfile;

/** Whether path is that of such a file: by its extension. */
int pl_plexfile_is(const char *path);

/** Read the mesh at path, a file of that form. Collective; to be closed in any case. Returns 0, or
 *  a planish_status with *error. */
int pl_plexfile_read(pl_plexfile *file, MPI_Comm comm, const char *path, const pl_plexform *form,
                     planish_error *error);
void pl_plexfile_close(pl_plexfile *file);

/** The nodes of dm: their numbers [n] and coordinates [n][dim] as they were read, to be freed. A
 *  node may be there in several processes. */
PetscErrorCode pl_plexfile_nodes(const pl_plexfile *file, int64_t *n, int64_t **number, double **x);

/** Cut it into pieces. Collective; piece is to be destroyed in any case. */
int pl_plexfile_cut(pl_plexfile *file, pl_piece *piece, planish_error *error);

/** A file that processes write together, beside its place until it is whole: the first one's. */
typedef struct pl_plexout {
    pl_output output;
    int mode; /* that it is to have in the end; -1: the one that it has */
} pl_plexout;

/** Write the mesh with the coordinates of share to out, which is to become path's: a copy in which
 *  they alone are others. checksums [2]: what planish_checksum says of the mesh before and after,
 * in the first process; NULL: not wanted. Collective; it may fail in some processes alone. out is
 * to be finished in any case. */
int pl_plexfile_write(pl_plexfile *file, const pl_share *share, const char *path, pl_plexout *out,
                      uint64_t *checksums, planish_error *error);

/** Write whole, which the first process has (the others: NULL), as PETSc does, with the region
 *  [n_elements] of each element, or NULL: there are none. Likewise in all else. */
int pl_plexfile_convert(MPI_Comm comm, const planish_mesh *whole, const int32_t *region,
                        const char *path, pl_plexout *out, planish_error *error);

/** Let what has been written take its place; with a code remove it. Returns code, or a
 *  planish_status in the first process. */
int pl_plexfile_finish(pl_plexout *out, int code, planish_error *error);

#endif
