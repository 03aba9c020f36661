/* piece: the elements and nodes that PETSc's DMPlex hands out to a process, in its order.
 *
 *     pl_piece_cut                         of a mesh that the first process has
 *     pl_piece_hand_out, _begin            the steps of that
 *     pl_select_points, pl_bring           values to where DMPlex has moved their points
 */
#ifndef PL_TOOLS_MPI_PIECE_H
#define PL_TOOLS_MPI_PIECE_H

#include <planish/planish.h>

#include <petscdmplex.h>

/** With all elements at the nodes that this process owns, and more. Everything is owned. */
typedef struct pl_piece {
    int dim, rank;
    int64_t n_elements, n_nodes;
    int32_t *element;              /* [n_elements] numbers in the whole mesh, as all that follow */
    int32_t *corner;               /* [n_elements][dim + 1] */
    int32_t *node;                 /* [n_nodes] */
    int *owner;                    /* [n_nodes] rank */
    double *coordinates;           /* [n_nodes][dim] */
    uint8_t *constraint;           /* [n_nodes] or NULL, */
    double *direction;             /* [n_nodes][dim] likewise, */
    double *min_volume;            /* [n_elements] likewise, */
    int32_t *region;               /* [n_elements] likewise */
    PetscSF points;                /* of DMPlex's points, those that other processes own; */
    int64_t first_point, n_points; /* that of node 0, and how many there are */
} pl_piece;

/** Facts on the whole mesh that each process must know. */
typedef struct pl_outline {
    int64_t n_nodes, n_elements;
    int dim, has_constraint, has_direction, has_min_volume;
} pl_outline;

/** Cut whole (NULL in all processes but the first) and hand it out. Collective; to be destroyed in
 *  any case. */
PetscErrorCode pl_piece_cut(MPI_Comm comm, const pl_outline *outline, const planish_mesh *whole,
                            pl_piece *piece);

/** The first steps of that, for dm without faces, of which each process has n elements with corners
 *  [n][dim + 1]: cut it by elements, and give each process its piece, out, with all elements at the
 *  piece's nodes. */
PetscErrorCode pl_piece_hand_out(DM dm, int64_t n, const int32_t *corner, PetscSF *migration,
                                 DM *out);

/** Then, the piece that migration has led to dm, without its numbers and values. */
PetscErrorCode pl_piece_begin(MPI_Comm comm, DM dm, pl_piece *piece);

/** Select the part of migration that leads to the n points from begin on here, which are elements
 * or nodes, renumbered from 0: their first one is point root_begin [ranks] in a process; here there
 *  are n_roots. */
PetscErrorCode pl_select_points(MPI_Comm comm, PetscSF migration, int64_t begin, int64_t n,
                                const int64_t *root_begin, int64_t n_roots, PetscSF *sf);

/** Values of count numbers of type, from where sf's roots are to where its leaves are. */
PetscErrorCode pl_bring(PetscSF sf, MPI_Datatype type, int count, const void *from, void *to);

void pl_piece_destroy(pl_piece *piece);

/** The process that has item i of all, of which process k has begin[k] ... begin[k + 1]. */
int pl_owner_of(const int64_t *begin, int n_ranks, int64_t i);

/** An array of n values, all 0; at least one, so that NULL is want of memory. */
void *pl_new_array(int64_t n, size_t size);

#endif
