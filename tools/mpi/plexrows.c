/* plexrows: a copy of PETSc's file in which only coordinates differ.
 *
 * Each process has a stretch of the rows, one for each node in the order of their numbers, and
 * writes them where they stand. That the rows are these is not taken for granted: they must be the
 * coordinates that the mesh was read with.
 */
#include "mpi/plexrows.h"

#include "base/checksum.h"
#include "base/memory.h"
#include "io/plex/plex.h"

#include <petscsf.h>

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/** Rows that stand one after another. */
typedef struct stretch {
    int64_t first, n; /* rows */
    int64_t offset;   /* in the file */
} stretch;

/** The rows. Everything is owned. */
typedef struct rows {
    stretch *stretch; /* [n_stretches] of all rows */
    int64_t n_stretches;
    int64_t *begin;   /* [ranks + 1] rows of the processes */
    int64_t first, n; /* those of this process */
    double *x;        /* [n][dim] */
} rows;

/* ---- where they stand ----------------------------------------------------------------------- */

/** Copy a file; 0, or -1: errno. */
static int copy_file(const char *from, const char *to) {
    enum { AT_ONCE = 1 << 20 };
    FILE *in = fopen(from, "rb"), *out = in ? fopen(to, "wb") : NULL;
    char *buffer = out ? malloc(AT_ONCE) : NULL;
    size_t n = 0;
    while (buffer && (n = fread(buffer, 1, AT_ONCE, in)) > 0)
        if (fwrite(buffer, 1, n, out) != n)
            break;
    int status = buffer && n == 0 && !ferror(in) ? 0 : -1;
    free(buffer);
    if (out && fclose(out) != 0)
        status = -1;
    if (in)
        fclose(in);
    return status;
}

const char *pl_plexrows_refusal(const char *path, pl_plexform *form) {
    io_plex_outline o;
    io_span *span = NULL;
    int64_t n_spans;
    planish_error error;
    const int newest = PETSC_VERSION_LT(3, 19, 0) ? 2 : 3; /* that this PETSc can read */
    if (io_plex_outline_of(path, &o, &error))
        return "";
    snprintf(form->name, sizeof form->name, "%s", o.name);
    snprintf(form->coordinates, sizeof form->coordinates, "%s", o.coordinates);
    /* Whether coordinates stand in the file as doubles, row by row. */
    if (io_hdf5_find_rows(path, o.coordinates, o.n_nodes, o.dim, &span, &n_spans, &error))
        n_spans = 0;
    pl_free(span);
    return o.version > newest ? "this PETSc cannot read its storage version"
           : o.columns != o.dim
               ? "its nodes have three coordinates, and its elements two dimensions"
           : !o.has_simplices_alone ? "not all of its elements are simplices"
           : !o.has_regions_alone
               ? "it has labels besides 'Cell Sets', or elements in two of these, or a set -1"
           : o.has_copies ? "it has its coordinates more than once, or vectors as long as they are"
           : n_spans == 0 ? "its coordinates do not stand there as doubles, row by row"
                          : NULL;
}

/** Share the stretches that the first process has found, and decide who has which rows. */
static PetscErrorCode share_stretches(const pl_plexfile *f, rows *r) {
    PetscMPIInt n_ranks, rank;
    MPI_Comm_size(f->comm, &n_ranks);
    MPI_Comm_rank(f->comm, &rank);
    MPI_Bcast(&r->n_stretches, 1, MPI_INT64_T, 0, f->comm);
    if (rank != 0)
        r->stretch = pl_new_array(r->n_stretches, sizeof *r->stretch);
    r->begin = pl_new_array(n_ranks + 1, sizeof *r->begin);
    for (int k = 0; r->begin && k <= n_ranks; k++)
        r->begin[k] = f->n_nodes / n_ranks * k + f->n_nodes % n_ranks * k / n_ranks;
    r->first = r->begin ? r->begin[rank] : 0;
    r->n = r->begin ? r->begin[rank + 1] - r->first : 0;
    r->x = pl_new_array(r->n * f->dim, sizeof *r->x);
    PetscCheck(r->stretch && r->begin && r->x, PETSC_COMM_SELF, PETSC_ERR_MEM, "Rows");
    MPI_Bcast(r->stretch, (int)(r->n_stretches * (int64_t)sizeof *r->stretch), MPI_BYTE, 0,
              f->comm);
    return 0;
}

/* ---- reading and writing -------------------------------------------------------------------- */

/** All n bytes; 0, or -1. */
static int move_bytes(int fd, char *bytes, int64_t n, int64_t offset, int writes) {
    while (n > 0) {
        const ssize_t done = writes ? pwrite(fd, bytes, (size_t)n, (off_t)offset)
                                    : pread(fd, bytes, (size_t)n, (off_t)offset);
        if (done < 0 && errno == EINTR)
            continue;
        if (done <= 0)
            return -1;
        bytes += done;
        offset += done;
        n -= done;
    }
    return 0;
}

/** The rows of this process from the file, or to it; 0, or -1. */
static int move_rows(const pl_plexfile *f, const rows *r, const char *path, int writes) {
    const int64_t size = f->dim * (int64_t)sizeof *r->x;
    const int fd = open(path, writes ? O_WRONLY : O_RDONLY);
    int status = fd < 0 ? -1 : 0;
    int64_t moved = 0;
    for (int64_t i = 0; i < r->n_stretches && !status; i++) {
        const stretch *s = &r->stretch[i];
        const int64_t first = s->first > r->first ? s->first : r->first;
        const int64_t s_end = s->first + s->n, end = r->first + r->n;
        const int64_t n = (s_end < end ? s_end : end) - first;
        if (n <= 0)
            continue;
        status = move_bytes(fd, (char *)(r->x + (first - r->first) * f->dim), n * size,
                            s->offset + (first - s->first) * size, writes);
        moved += n;
    }
    if (fd >= 0 && close(fd) != 0)
        status = -1;
    return moved == r->n ? status : -1;
}

/* ---- what is in them ------------------------------------------------------------------------ */

/** Coordinates [n][dim] of nodes to their rows. */
static PetscErrorCode put_rows(const pl_plexfile *f, const rows *r, int64_t n, const int64_t *node,
                               const double *x, double *row) {
    PetscSF sf;
    PetscSFNode *root;
    MPI_Datatype type;
    PetscMPIInt n_ranks;
    MPI_Comm_size(f->comm, &n_ranks);
    PetscCall(PetscMalloc1((size_t)n + 1, &root));
    for (int64_t i = 0; i < n; i++) {
        const int rank = pl_owner_of(r->begin, n_ranks, node[i]);
        root[i] = (PetscSFNode){.rank = rank, .index = (PetscInt)(node[i] - r->begin[rank])};
    }
    PetscCall(PetscSFCreate(f->comm, &sf));
    PetscCall(PetscSFSetGraph(sf, (PetscInt)r->n, (PetscInt)n, NULL, PETSC_OWN_POINTER, root,
                              PETSC_OWN_POINTER));
    MPI_Type_contiguous(f->dim, MPI_DOUBLE, &type);
    MPI_Type_commit(&type);
    PetscCall(PetscSFReduceBegin(sf, type, x, row, MPI_REPLACE));
    PetscCall(PetscSFReduceEnd(sf, type, x, row, MPI_REPLACE));
    MPI_Type_free(&type);
    return PetscSFDestroy(&sf);
}

/** Whether the rows are the coordinates that the mesh was read with. */
static PetscErrorCode compare(const pl_plexfile *f, const rows *r, int *same) {
    const size_t size = (size_t)(r->n * f->dim) * sizeof *r->x;
    int64_t n, *node;
    double *x, *row = pl_new_array(r->n * f->dim, sizeof *row);
    PetscCheck(row, PETSC_COMM_SELF, PETSC_ERR_MEM, "Rows");
    memcpy(row, r->x, size);
    PetscCall(pl_plexfile_nodes(f, &n, &node, &x));
    PetscCall(put_rows(f, r, n, node, x, row));
    *same = memcmp(row, r->x, size) == 0;
    free(node);
    free(x);
    free(row);
    return 0;
}

/** The coordinates of share into the rows. */
static PetscErrorCode fill_rows(const pl_plexfile *f, const pl_share *share, rows *r) {
    int64_t n = 0, *node = pl_new_array(share->mesh.n_nodes, sizeof *node);
    double *x = pl_new_array(share->mesh.n_nodes * f->dim, sizeof *x);
    PetscCheck(node && x, PETSC_COMM_SELF, PETSC_ERR_MEM, "Rows");
    for (int64_t i = 0; i < share->mesh.n_nodes; i++) {
        if (share->role[i] == PLANISH_ROLE_GHOST)
            continue;
        memcpy(x + n * f->dim, share->coordinates + i * f->dim, (size_t)f->dim * sizeof *x);
        node[n++] = share->node_number[i];
    }
    PetscCall(put_rows(f, r, n, node, x, r->x));
    free(node);
    free(x);
    return 0;
}

/* ---- all of it ------------------------------------------------------------------------------ */

/** Sum up all rows, one process after another: the last one tells the first. */
static uint64_t add_up(const pl_plexfile *f, const rows *r) {
    enum { TAG = 1 };
    PetscMPIInt n_ranks, rank;
    uint64_t sum = 0;
    MPI_Comm_size(f->comm, &n_ranks);
    MPI_Comm_rank(f->comm, &rank);
    if (rank > 0)
        MPI_Recv(&sum, 1, MPI_UINT64_T, rank - 1, TAG, f->comm, MPI_STATUS_IGNORE);
    for (int64_t i = 0; i < r->n * f->dim; i++)
        sum = pl_checksum_add(sum, r->x[i], (int)(i % f->dim));
    if (rank < n_ranks - 1)
        MPI_Send(&sum, 1, MPI_UINT64_T, rank + 1, TAG, f->comm);
    MPI_Bcast(&sum, 1, MPI_UINT64_T, n_ranks - 1, f->comm);
    return sum;
}

/** Whether a step was done in all processes; if not, *reason of those that have failed. */
static int is_done(const pl_plexfile *f, int failed, int *reason) {
    int done = !failed;
    *reason = failed ? errno : 0;
    if (failed && !errno) /* the file is shorter than it was */
        *reason = EIO;
    MPI_Allreduce(MPI_IN_PLACE, &done, 1, MPI_INT, MPI_MIN, f->comm);
    return done;
}

/** In the copy at path. */
static PetscErrorCode change(const pl_plexfile *f, const pl_share *share, const char *path, rows *r,
                             uint64_t *checksums, int *reason) {
    int same = 0;
    PetscCall(share_stretches(f, r));
    errno = 0;
    if (!is_done(f, r->n_stretches == 0 || move_rows(f, r, path, 0), reason))
        return 0;
    PetscCall(compare(f, r, &same));
    errno = 0;
    if (!is_done(f, !same, reason))
        return 0;
    if (checksums)
        checksums[0] = add_up(f, r);
    PetscCall(fill_rows(f, share, r));
    if (checksums)
        checksums[1] = add_up(f, r);
    errno = 0;
    is_done(f, move_rows(f, r, path, 1), reason);
    return 0;
}

PetscErrorCode pl_plexrows_write(const pl_plexfile *f, const pl_share *share, const char *path,
                                 uint64_t *checksums, int *reason) {
    rows r = {.n_stretches = 0};
    io_span *span = NULL;
    int64_t n = 0;
    planish_error error;
    PetscMPIInt rank;
    MPI_Comm_rank(f->comm, &rank);
    errno = 0;
    if (!is_done(f, rank == 0 && copy_file(f->path, path), reason))
        return 0;
    if (rank == 0) { /* which finds the stretches */
        if (io_hdf5_find_rows(path, f->form.coordinates, f->n_nodes, f->dim, &span, &n, &error))
            n = 0;
        r.stretch = pl_new_array(n, sizeof *r.stretch);
        r.n_stretches = r.stretch ? n : 0;
        for (int64_t i = 0; i < r.n_stretches; i++)
            r.stretch[i] = (stretch){span[i].first_node, span[i].n_nodes, span[i].offset};
        pl_free(span);
    }
    const PetscErrorCode code = change(f, share, path, &r, checksums, reason);
    free(r.stretch);
    free(r.begin);
    free(r.x);
    return code;
}
