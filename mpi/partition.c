/* partition: the graph of elements that share a facet is cut.
 *
 * DMPlex would find that graph itself, in minutes for a million elements without faces.
 */
#include "partition.h"

#include "topology/facets.h"

#include <petscis.h>
#include <petscsection.h>
#include <petscvec.h>

/** Elements beyond the facets of each. */
typedef struct graph {
    int corners;
    PetscInt *start;     /* [m + 1] */
    PetscInt *neighbour; /* [start[m]]; while it is made: [m][corners], start the numbers of them */
} graph;

static void join(void *context, int32_t node, const pl_facet *facets, int32_t n_facets) {
    graph *g = context;
    (void)node;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++)
        for (int i = 0; i < 2 && facet->count == 2; i++) {
            const int64_t element = facet->element[i];
            g->neighbour[element * g->corners + g->start[element]++] = facet->element[1 - i];
        }
}

/** From lists of equal length to lists one behind the other. */
static void pack(graph *g, int64_t m) {
    PetscInt n = 0;
    for (int64_t i = 0; i < m; i++) {
        const PetscInt *from = g->neighbour + i * g->corners;
        const PetscInt count = g->start[i];
        g->start[i] = n;
        for (PetscInt k = 0; k < count; k++)
            g->neighbour[n++] = from[k];
    }
    g->start[m] = n;
}

static PetscErrorCode make_graph(const planish_mesh *whole, graph *g) {
    pl_incidence incidence;
    planish_error error;
    const int64_t m = whole ? whole->n_elements : 0;
    g->corners = whole ? whole->dim + 1 : 0;
    PetscCall(PetscCalloc1((size_t)m + 1, &g->start));
    PetscCall(PetscMalloc1((size_t)m * (size_t)g->corners + 1, &g->neighbour));
    if (!whole)
        return 0;
    int code = pl_incidence_create(whole, NULL, 1, &incidence, &error);
    if (!code) {
        code = pl_facets_match(whole, &incidence, NULL, 1, join, g, &error);
        pl_incidence_destroy(&incidence);
    }
    PetscCheck(!code, PETSC_COMM_SELF, PETSC_ERR_MEM, "Facets");
    pack(g, m);
    return 0;
}

PetscErrorCode pl_choose_partitioner(PetscPartitioner partitioner) {
#ifdef PETSC_HAVE_PTSCOTCH
    PetscCall(PetscPartitionerSetType(partitioner, PETSCPARTITIONERPTSCOTCH));
#endif
    return PetscPartitionerSetFromOptions(partitioner);
}

/** The pieces of the graph, one process after the other. */
static PetscErrorCode cut(MPI_Comm comm, graph *g, PetscInt m, PetscSection sizes, IS *pieces) {
    PetscMPIInt n_ranks;
    PetscPartitioner partitioner;
    MPI_Comm_size(comm, &n_ranks);
    PetscCall(PetscPartitionerCreate(comm, &partitioner));
    PetscCall(pl_choose_partitioner(partitioner));
    PetscCall(PetscPartitionerPartition(partitioner, n_ranks, m, g->start, g->neighbour, NULL, NULL,
                                        sizes, pieces));
    return PetscPartitionerDestroy(&partitioner);
}

static PetscErrorCode hand_over(MPI_Comm comm, PetscSection sizes, IS pieces, PetscPartitioner to) {
    PetscMPIInt n_ranks;
    PetscInt *size;
    const PetscInt *element;
    MPI_Comm_size(comm, &n_ranks);
    PetscCall(PetscMalloc1((size_t)n_ranks, &size));
    for (PetscInt i = 0; i < n_ranks; i++)
        PetscCall(PetscSectionGetDof(sizes, i, &size[i]));
    PetscCall(ISGetIndices(pieces, &element));
    PetscCall(PetscPartitionerSetType(to, PETSCPARTITIONERSHELL));
    PetscCall(PetscPartitionerShellSetPartition(to, n_ranks, size, element));
    PetscCall(ISRestoreIndices(pieces, &element));
    return PetscFree(size);
}

PetscErrorCode pl_partition(MPI_Comm comm, const planish_mesh *whole, PetscPartitioner to) {
    graph g;
    PetscSection sizes;
    IS pieces;
    PetscCall(make_graph(whole, &g));
    PetscCall(PetscSectionCreate(comm, &sizes));
    PetscCall(cut(comm, &g, whole ? (PetscInt)whole->n_elements : 0, sizes, &pieces));
    PetscCall(PetscFree(g.start));
    PetscCall(PetscFree(g.neighbour));
    PetscCall(hand_over(comm, sizes, pieces, to));
    PetscCall(PetscSectionDestroy(&sizes));
    return ISDestroy(&pieces);
}
