/* piece: a mesh is cut and handed out by DMPlex. */
#include "mpi/piece.h"

#include "mpi/partition.h"

#include <petscsf.h>

#include <stdlib.h>

void *pl_new_array(int64_t n, size_t size) {
    return calloc((size_t)n + 1, size);
}

int pl_owner_of(const int64_t *begin, int n_ranks, int64_t i) {
    int low = 0, high = n_ranks;
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (begin[middle] <= i)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/** Room for values of a piece. */
static PetscErrorCode make_room(void *array, int64_t n, size_t size) {
    void **to = array;
    *to = pl_new_array(n, size);
    PetscCheck(*to, PETSC_COMM_SELF, PETSC_ERR_MEM, "Piece");
    return 0;
}

PetscErrorCode pl_bring(PetscSF sf, MPI_Datatype type, int count, const void *from, void *to) {
    MPI_Datatype row;
    MPI_Type_contiguous(count, type, &row);
    MPI_Type_commit(&row);
    PetscCall(PetscSFBcastBegin(sf, row, from, to, MPI_REPLACE));
    PetscCall(PetscSFBcastEnd(sf, row, from, to, MPI_REPLACE));
    MPI_Type_free(&row);
    return 0;
}

/* ---- cut and handed out --------------------------------------------------------------------- */

/** The mesh as a DMPlex, all of it in the first process. */
static PetscErrorCode make_plex(MPI_Comm comm, const pl_outline *o, const planish_mesh *whole,
                                DM *dm) {
    const PetscInt n_cells = whole ? (PetscInt)o->n_elements : 0;
    const PetscInt n_nodes = whole ? (PetscInt)o->n_nodes : 0;
    const PetscInt corners = o->dim + 1;
    PetscInt *corner = NULL;
    PetscReal *zero = NULL; /* the coordinates are brought later: here one of them is enough */
    PetscCall(PetscMalloc1((size_t)n_cells * (size_t)corners + 1, &corner));
    PetscCall(PetscCalloc1((size_t)n_nodes + 1, &zero));
    for (int64_t i = 0; i < (int64_t)n_cells * corners; i++)
        corner[i] = whole->elements[i];
    PetscCall(DMPlexCreateFromCellListPetsc(comm, o->dim, n_cells, n_nodes, corners, PETSC_FALSE,
                                            corner, 1, zero, dm));
    PetscCall(PetscFree(corner));
    return PetscFree(zero);
}

PetscErrorCode pl_piece_hand_out(DM dm, int64_t n, const int32_t *corner, PetscSF *migration,
                                 DM *out) {
    PetscInt dim;
    PetscCall(DMGetDimension(dm, &dim));
    PetscCall(DMSetBasicAdjacency(dm, PETSC_FALSE, PETSC_TRUE));
    PetscCall(pl_partition(PetscObjectComm((PetscObject)dm), (int)dim, n, corner, dm));
    return DMPlexDistribute(dm, 1, migration, out);
}

PetscErrorCode pl_select_points(MPI_Comm comm, PetscSF migration, int64_t begin, int64_t n,
                                const int64_t *root_begin, int64_t n_roots, PetscSF *sf) {
    PetscInt n_leaves, *leaf = NULL, found = 0;
    const PetscInt *local;
    const PetscSFNode *remote;
    PetscSFNode *root = NULL;
    PetscCall(PetscSFGetGraph(migration, NULL, &n_leaves, &local, &remote));
    PetscCall(PetscMalloc1((size_t)n + 1, &leaf));
    PetscCall(PetscMalloc1((size_t)n + 1, &root));
    for (PetscInt i = 0; i < n_leaves && found < n; i++) {
        const PetscInt point = local ? local[i] : i;
        if (point < begin || point >= begin + n)
            continue;
        leaf[found] = point - (PetscInt)begin;
        root[found].rank = remote[i].rank;
        root[found].index = remote[i].index - (PetscInt)root_begin[remote[i].rank];
        found++;
    }
    PetscCheck(found == n, PETSC_COMM_SELF, PETSC_ERR_PLIB, "Points from nowhere");
    PetscCall(PetscSFCreate(comm, sf));
    return PetscSFSetGraph(*sf, (PetscInt)n_roots, found, leaf, PETSC_OWN_POINTER, root,
                           PETSC_OWN_POINTER);
}

PetscErrorCode pl_piece_begin(MPI_Comm comm, DM dm, pl_piece *p) {
    PetscInt dim, first, last, node_first, node_last, point_last, n_leaves;
    const PetscInt *local;
    const PetscSFNode *remote;
    MPI_Comm_rank(comm, &p->rank);
    PetscCall(DMGetDimension(dm, &dim));
    PetscCall(DMPlexGetChart(dm, NULL, &point_last));
    PetscCall(DMPlexGetHeightStratum(dm, 0, &first, &last));
    PetscCall(DMPlexGetDepthStratum(dm, 0, &node_first, &node_last));
    PetscCheck(first == 0, PETSC_COMM_SELF, PETSC_ERR_PLIB, "Elements are not the first points");
    p->dim = (int)dim;
    p->n_points = point_last;
    p->n_elements = last;
    p->n_nodes = last > 0 ? node_last - node_first : 0;
    p->first_point = node_first;
    PetscCall(DMGetPointSF(dm, &p->points));
    PetscCall(PetscObjectReference((PetscObject)p->points));
    PetscCall(PetscSFGetGraph(p->points, NULL, &n_leaves, &local, &remote));
    PetscCall(make_room(&p->owner, p->n_nodes, sizeof *p->owner));
    for (int64_t i = 0; i < p->n_nodes; i++)
        p->owner[i] = p->rank;
    for (PetscInt i = 0; i < n_leaves; i++) {
        const int64_t node = (local ? local[i] : i) - p->first_point;
        if (node >= 0 && node < p->n_nodes)
            p->owner[node] = (int)remote[i].rank;
    }
    PetscCall(make_room(&p->element, p->n_elements, sizeof *p->element));
    PetscCall(make_room(&p->node, p->n_nodes, sizeof *p->node));
    PetscCall(make_room(&p->corner, p->n_elements * (dim + 1), sizeof *p->corner));
    return make_room(&p->coordinates, p->n_nodes * dim, sizeof *p->coordinates);
}

/** The numbers of sf's leaves, in the first process's order. */
static PetscErrorCode find_numbers(PetscSF sf, int32_t *number) {
    PetscInt n;
    const PetscInt *local;
    const PetscSFNode *remote;
    PetscCall(PetscSFGetGraph(sf, NULL, &n, &local, &remote));
    for (PetscInt i = 0; i < n; i++)
        number[local ? local[i] : i] = (int32_t)remote[i].index;
    return 0;
}

/** Numbers and values of what has come to dm, to which migration has led. */
static PetscErrorCode fill_piece(MPI_Comm comm, PetscSF migration, const pl_outline *o,
                                 const planish_mesh *whole, pl_piece *p) {
    static const planish_mesh nothing = {.dim = 0};
    const planish_mesh *from = whole ? whole : &nothing;
    const int dim = o->dim;
    const int64_t first = 0; /* all comes from the first process: there are no others */
    PetscSF elements, nodes;
    PetscCall(pl_select_points(comm, migration, 0, p->n_elements, &first, whole ? o->n_elements : 0,
                               &elements));
    PetscCall(pl_select_points(comm, migration, p->first_point, p->n_nodes, &o->n_elements,
                               whole ? o->n_nodes : 0, &nodes));
    PetscCall(find_numbers(elements, p->element));
    PetscCall(find_numbers(nodes, p->node));
    PetscCall(pl_bring(elements, MPI_INT32_T, dim + 1, from->elements, p->corner));
    PetscCall(pl_bring(nodes, MPI_DOUBLE, dim, from->coordinates, p->coordinates));
    if (o->has_constraint) {
        PetscCall(make_room(&p->constraint, p->n_nodes, 1));
        PetscCall(pl_bring(nodes, MPI_UNSIGNED_CHAR, 1, from->constraint, p->constraint));
    }
    if (o->has_direction) {
        PetscCall(make_room(&p->direction, p->n_nodes * dim, sizeof *p->direction));
        PetscCall(pl_bring(nodes, MPI_DOUBLE, dim, from->direction, p->direction));
    }
    if (o->has_min_volume) {
        PetscCall(make_room(&p->min_volume, p->n_elements, sizeof *p->min_volume));
        PetscCall(pl_bring(elements, MPI_DOUBLE, 1, from->min_volume, p->min_volume));
    }
    PetscCall(PetscSFDestroy(&elements));
    return PetscSFDestroy(&nodes);
}

PetscErrorCode pl_piece_cut(MPI_Comm comm, const pl_outline *outline, const planish_mesh *whole,
                            pl_piece *piece) {
    DM dm = NULL, out = NULL;
    PetscSF migration = NULL;
    *piece = (pl_piece){.dim = outline->dim};
    PetscCall(make_plex(comm, outline, whole, &dm));
    PetscCall(pl_piece_hand_out(dm, whole ? outline->n_elements : 0, whole ? whole->elements : NULL,
                                &migration, &out));
    PetscCall(DMDestroy(&dm));
    PetscCall(pl_piece_begin(comm, out, piece));
    PetscCall(DMDestroy(&out));
    PetscCall(fill_piece(comm, migration, outline, whole, piece));
    return PetscSFDestroy(&migration);
}

void pl_piece_destroy(pl_piece *p) {
    free(p->element);
    free(p->corner);
    free(p->node);
    free(p->owner);
    free(p->coordinates);
    free(p->constraint);
    free(p->direction);
    free(p->min_volume);
    free(p->region);
    PetscSFDestroy(&p->points);
    *p = (pl_piece){.dim = 0};
}
