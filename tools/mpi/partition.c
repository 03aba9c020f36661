/* partition: the graph of elements that share a facet is cut.
 *
 * DMPlex would find that graph itself, in minutes for a million elements without faces, and in many
 * seconds with faces that it makes first. Here facets are sent to processes by their nodes: the two
 * sides of one meet there, and their elements are told of each other.
 */
#include "mpi/partition.h"

#include "mpi/piece.h"

#include "base/hash.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* Newer versions of PETSc ask for weights of edges. */
#ifdef PL_PETSC_EDGE_WEIGHTS
#define NO_EDGE_WEIGHTS NULL,
#else
#define NO_EDGE_WEIGHTS
#endif

/** Elements beyond the facets of each. */
typedef struct graph {
    int64_t n;           /* elements of this process */
    int64_t *begin;      /* [ranks + 1] the first element of each process, by global numbers */
    PetscInt *start;     /* [n + 1] */
    PetscInt *neighbour; /* [start[n]] global numbers */
} graph;

/** One side of a facet. */
typedef struct side {
    int32_t node[3]; /* ascending; in 2-D the last is -1 */
    int32_t element; /* global number */
} side;

/** An element, and one beyond a facet of it. */
typedef struct pair {
    int32_t element, neighbour;
} pair;

/* ---- post between all processes ------------------------------------------------------------- */

/** Records on their way; arrays are owned. */
typedef struct post {
    int64_t n;
    char *record; /* [n][size] */
    int *to;      /* [n] rank */
} post;

static PetscErrorCode post_create(post *p, int64_t n, size_t size) {
    *p = (post){.record = pl_new_array(n, size), .to = pl_new_array(n, sizeof *p->to)};
    PetscCheck(p->record && p->to, PETSC_COMM_SELF, PETSC_ERR_MEM, "Post");
    return 0;
}

static void post_destroy(post *p) {
    free(p->record);
    free(p->to);
    *p = (post){0};
}

static void post_add(post *p, const void *record, size_t size, int to) {
    memcpy(p->record + (size_t)p->n * size, record, size);
    p->to[p->n++] = to;
}

/** From counts to where each begins; the sum. */
static int64_t sum_up(int n, const int *count, int *begin) {
    int64_t sum = 0;
    for (int k = 0; k < n; k++) {
        begin[k] = (int)sum;
        sum += count[k];
    }
    return sum;
}

/** In place of what is on its way comes what has arrived, whose ranks are not known. */
static PetscErrorCode post_exchange(MPI_Comm comm, post *p, size_t size) {
    int n_ranks;
    MPI_Datatype type;
    MPI_Comm_size(comm, &n_ranks);
    int *count = pl_new_array(4 * (int64_t)n_ranks, sizeof *count);
    char *sorted = pl_new_array(p->n, size);
    PetscCheck(count && sorted, PETSC_COMM_SELF, PETSC_ERR_MEM, "Post");
    PetscCheck(p->n <= INT_MAX, PETSC_COMM_SELF, PETSC_ERR_SUP, "Too many facets for a process");
    int *arriving = count + n_ranks, *begin = count + 2 * n_ranks, *arrival = count + 3 * n_ranks;
    for (int64_t i = 0; i < p->n; i++)
        count[p->to[i]]++;
    sum_up(n_ranks, count, begin);
    for (int64_t i = 0; i < p->n; i++) /* each begin becomes the next one's */
        memcpy(sorted + (size_t)begin[p->to[i]]++ * size, p->record + (size_t)i * size, size);
    sum_up(n_ranks, count, begin);
    MPI_Alltoall(count, 1, MPI_INT, arriving, 1, MPI_INT, comm);
    p->n = sum_up(n_ranks, arriving, arrival);
    PetscCheck(p->n <= INT_MAX, PETSC_COMM_SELF, PETSC_ERR_SUP, "Too many facets for a process");
    free(p->record);
    p->record = pl_new_array(p->n, size);
    PetscCheck(p->record, PETSC_COMM_SELF, PETSC_ERR_MEM, "Post");
    MPI_Type_contiguous((int)size, MPI_BYTE, &type);
    MPI_Type_commit(&type);
    MPI_Alltoallv(sorted, count, begin, type, p->record, arriving, arrival, type, comm);
    MPI_Type_free(&type);
    free(count);
    free(sorted);
    return 0;
}

/* ---- facets ---------------------------------------------------------------------------------- */

/** Return the process at which the sides of a facet meet. */
static int meeting_of(const side *s, int n_ranks) {
    uint64_t hash = 0;
    for (int k = 0; k < 3; k++) {
        hash = (hash ^ (uint32_t)s->node[k]) * UINT64_C(0x9E3779B97F4A7C15);
        hash ^= hash >> 32;
    }
    return (int)(hash % (unsigned)n_ranks);
}

/** Each side of a facet goes to a process that the nodes tell. */
static PetscErrorCode send_sides(MPI_Comm comm, int dim, const graph *g, const int32_t *corner,
                                 post *sides) {
    const int corners = dim + 1;
    int rank, n_ranks;
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &n_ranks);
    PetscCall(post_create(sides, g->n * corners, sizeof(side)));
    for (int64_t i = 0; i < g->n * corners; i++) {
        const int32_t *of = corner + i / corners * corners;
        side s = {{-1, -1, -1}, (int32_t)(g->begin[rank] + i / corners)};
        int n = 0;
        for (int j = 0; j < corners; j++) { /* but the opposite one, sorted */
            int place = n;
            if (j == i % corners)
                continue;
            for (; place > 0 && s.node[place - 1] > of[j]; place--)
                s.node[place] = s.node[place - 1];
            s.node[place] = of[j];
            n++;
        }
        post_add(sides, &s, sizeof s, meeting_of(&s, n_ranks));
    }
    return post_exchange(comm, sides, sizeof(side));
}

/** Sides that have met: the first two of a facet, of different elements. */
static PetscErrorCode match_sides(MPI_Comm comm, const graph *g, const post *sides, post *pairs) {
    enum { NONE = -1, MET = -2 };
    int n_ranks;
    const side *all = (const side *)(const void *)sides->record;
    const int64_t n_slots = sides->n + 1;
    int32_t *first = pl_new_array(n_slots, sizeof *first); /* of each slot's list, */
    int32_t *next = pl_new_array(sides->n, sizeof *next);  /* and on */
    MPI_Comm_size(comm, &n_ranks);
    PetscCheck(first && next, PETSC_COMM_SELF, PETSC_ERR_MEM, "Facets");
    PetscCall(post_create(pairs, sides->n, sizeof(pair)));
    for (int64_t k = 0; k < n_slots; k++)
        first[k] = NONE;
    const pl_hash drawn = pl_hash_draw(first);
    for (int64_t i = 0; i < sides->n; i++) {
        const side *s = &all[i];
        pl_hash hash = drawn;
        pl_hash_add_integers(&hash, s->node, 3);
        int32_t *slot = &first[pl_hash_end(hash) % (uint64_t)n_slots], other = *slot;
        while (other != NONE && memcmp(all[other].node, s->node, sizeof s->node) != 0)
            other = next[other];
        if (other == NONE) {
            next[i] = *slot;
            *slot = (int32_t)i;
            continue;
        }
        const int32_t element = all[other].element;
        if (element == MET || element == s->element)
            continue;
        const pair there = {element, s->element}, back = {s->element, element};
        post_add(pairs, &there, sizeof there, pl_owner_of(g->begin, n_ranks, element));
        post_add(pairs, &back, sizeof back, pl_owner_of(g->begin, n_ranks, s->element));
        ((side *)(void *)sides->record)[other].element = MET;
    }
    free(first);
    free(next);
    return post_exchange(comm, pairs, sizeof(pair));
}

/* ---- the graph ------------------------------------------------------------------------------- */

static PetscErrorCode make_graph(MPI_Comm comm, int dim, const int32_t *corner, graph *g) {
    int rank, n_ranks;
    post sides, pairs;
    const int64_t mine = g->n;
    MPI_Comm_rank(comm, &rank);
    MPI_Comm_size(comm, &n_ranks);
    g->begin = pl_new_array(n_ranks + 1, sizeof *g->begin);
    PetscCheck(g->begin, PETSC_COMM_SELF, PETSC_ERR_MEM, "Counts");
    MPI_Allgather(&mine, 1, MPI_INT64_T, g->begin + 1, 1, MPI_INT64_T, comm);
    for (int k = 0; k < n_ranks; k++)
        g->begin[k + 1] += g->begin[k];
    PetscCheck(g->begin[n_ranks] <= INT32_MAX, PETSC_COMM_SELF, PETSC_ERR_SUP, "Too many elements");
    PetscCall(send_sides(comm, dim, g, corner, &sides));
    PetscCall(match_sides(comm, g, &sides, &pairs));
    post_destroy(&sides);
    /* Lists of neighbours from pairs of elements of this process and others. */
    const pair *all = (const pair *)(const void *)pairs.record;
    const int64_t first = g->begin[rank];
    PetscCall(PetscCalloc1((size_t)g->n + 2, &g->start));
    PetscCall(PetscMalloc1((size_t)pairs.n + 1, &g->neighbour));
    PetscInt *next = g->start + 1; /* becomes the beginning of the element after */
    for (int64_t i = 0; i < pairs.n; i++)
        next[all[i].element - first + 1]++;
    for (int64_t i = 0; i < g->n; i++)
        next[i + 1] += next[i];
    for (int64_t i = 0; i < pairs.n; i++)
        g->neighbour[next[all[i].element - first]++] = all[i].neighbour;
    post_destroy(&pairs);
    free(g->begin);
    return 0;
}

/** The pieces of the graph, one process after the other. */
static PetscErrorCode cut(MPI_Comm comm, const graph *g, PetscSection sizes, IS *pieces) {
    PetscMPIInt n_ranks;
    PetscPartitioner partitioner;
    MPI_Comm_size(comm, &n_ranks);
    PetscCall(PetscPartitionerCreate(comm, &partitioner));
#ifdef PETSC_HAVE_PTSCOTCH
    PetscCall(PetscPartitionerSetType(partitioner, PETSCPARTITIONERPTSCOTCH));
#endif
    PetscCall(PetscPartitionerSetFromOptions(partitioner));
    PetscCall(PetscPartitionerPartition(partitioner, n_ranks, (PetscInt)g->n, g->start,
                                        g->neighbour, NULL, NO_EDGE_WEIGHTS NULL, sizes, pieces));
    return PetscPartitionerDestroy(&partitioner);
}

PetscErrorCode pl_partition(MPI_Comm comm, int dim, int64_t n, const int32_t *corner, DM dm) {
    graph g = {.n = n};
    PetscMPIInt n_ranks;
    PetscSection sizes;
    PetscInt *size;
    const PetscInt *element;
    IS pieces;
    PetscPartitioner to;
    MPI_Comm_size(comm, &n_ranks);
    PetscCall(make_graph(comm, dim, corner, &g));
    PetscCall(PetscSectionCreate(comm, &sizes));
    PetscCall(cut(comm, &g, sizes, &pieces));
    PetscCall(PetscFree(g.start));
    PetscCall(PetscFree(g.neighbour));
    /* dm's partitioner hands these pieces out. */
    PetscCall(PetscMalloc1((size_t)n_ranks, &size));
    for (PetscInt i = 0; i < n_ranks; i++)
        PetscCall(PetscSectionGetDof(sizes, i, &size[i]));
    PetscCall(ISGetIndices(pieces, &element));
    PetscCall(DMPlexGetPartitioner(dm, &to));
    PetscCall(PetscPartitionerSetType(to, PETSCPARTITIONERSHELL));
    PetscCall(PetscPartitionerShellSetPartition(to, n_ranks, size, element));
    PetscCall(ISRestoreIndices(pieces, &element));
    PetscCall(PetscFree(size));
    PetscCall(PetscSectionDestroy(&sizes));
    return ISDestroy(&pieces);
}
