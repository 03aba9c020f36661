/* plexfile: meshes in PETSc's HDF5. */
#include "mpi/plexfile.h"

#include "mpi/partition.h"
#include "mpi/plexrows.h"
#include "terminal/signals.h"

#include "base/status.h"
#include "base/system.h"

#include <petscsf.h>
#include <petscviewer.h>

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What DMPlex, and those who give it meshes, call the regions of elements. */
static const char regions[] = "Cell Sets";

/* The name of a mesh in PETSc's own file, where that does not have it, and in those made here. */
static const char own_name[] = "plex";

int pl_plexfile_is(const char *path) {
    static const char extension[] = ".h5";
    const size_t length = strlen(path), n = sizeof extension - 1;
    return length > n && strcmp(path + length - n, extension) == 0;
}

/** HDF5 tells of an error in a page, on standard error; it is told in a line here. Returns what
 *  standard error was, for speak. */
static int keep_silent(void) {
    fflush(stderr);
    const int before = dup(STDERR_FILENO), nothing = open("/dev/null", O_WRONLY);
    if (before >= 0 && nothing >= 0)
        dup2(nothing, STDERR_FILENO);
    if (nothing >= 0)
        close(nothing);
    return before;
}

static void speak(int before) {
    fflush(stderr);
    if (before < 0)
        return;
    dup2(before, STDERR_FILENO);
    close(before);
}

static PetscErrorCode open_viewer(MPI_Comm comm, const char *path, PetscFileMode mode,
                                  PetscViewer *viewer) {
    PetscCall(PetscViewerCreate(comm, viewer));
    PetscCall(PetscViewerSetType(*viewer, PETSCVIEWERHDF5));
    PetscCall(PetscViewerFileSetMode(*viewer, mode));
    PetscCall(PetscViewerFileSetName(*viewer, path));
    return PetscViewerPushFormat(*viewer, PETSC_VIEWER_HDF5_PETSC);
}

/* ---- reading -------------------------------------------------------------------------------- */

static PetscErrorCode load(pl_plexfile *f, PetscViewer viewer) {
    DMLabel types;
    PetscCall(DMCreate(f->comm, &f->dm));
    PetscCall(DMSetType(f->dm, DMPLEX));
    PetscCall(PetscObjectSetName((PetscObject)f->dm, f->form.name[0] ? f->form.name : own_name));
    PetscCall(DMPlexTopologyLoad(f->dm, viewer, &f->load));
    PetscCall(DMPlexCoordinatesLoad(f->dm, viewer, f->load));
    PetscCall(DMPlexLabelsLoad(f->dm, viewer, f->load));
    /* Made when first asked for, which processes without elements never do; then some would have a
     * label to write that the others have not. */
    return DMPlexGetCellTypeLabel(f->dm, &types);
}

/** Counts, of all processes, and where the nodes begin in the file. */
static PetscErrorCode measure(pl_plexfile *f) {
    PetscInt dim, n_roots, n_leaves, first, last, node_first, node_last;
    PetscMPIInt n_ranks, rank;
    const PetscInt *local;
    const PetscSFNode *remote;
    MPI_Comm_size(f->comm, &n_ranks);
    MPI_Comm_rank(f->comm, &rank);
    PetscCall(DMGetDimension(f->dm, &dim));
    PetscCall(PetscSFGetGraph(f->load, &n_roots, &n_leaves, &local, &remote));
    f->begin = pl_new_array(n_ranks, sizeof *f->begin);
    PetscCheck(f->begin, PETSC_COMM_SELF, PETSC_ERR_MEM, "Stretches");
    int64_t mine = n_roots, range[2] = {INT64_MAX, INT64_MAX}; /* first node; minus the last */
    MPI_Allgather(&mine, 1, MPI_INT64_T, f->begin + 1, 1, MPI_INT64_T, f->comm);
    for (int k = 0; k < n_ranks; k++)
        f->begin[k + 1] += f->begin[k];
    PetscCall(DMPlexGetHeightStratum(f->dm, 0, &first, &last));
    PetscCall(DMPlexGetDepthStratum(f->dm, 0, &node_first, &node_last));
    for (PetscInt i = 0; i < n_leaves; i++) {
        const PetscInt point = local ? local[i] : i;
        const int64_t number = f->begin[remote[i].rank] + remote[i].index;
        if (point < node_first || point >= node_last || last == 0)
            continue;
        range[0] = number < range[0] ? number : range[0];
        range[1] = -number < range[1] ? -number : range[1];
    }
    MPI_Allreduce(MPI_IN_PLACE, range, 2, MPI_INT64_T, MPI_MIN, f->comm);
    f->dim = (int)dim;
    f->first_node = range[0];
    f->n_nodes = range[0] < INT64_MAX ? -range[1] - range[0] + 1 : 0;
    f->n_elements = f->n_nodes > 0 ? f->first_node : 0; /* they are a file's first points */
    return 0;
}

static PetscErrorCode read_all(pl_plexfile *f, const char *path) {
    PetscViewer viewer;
    PetscCall(open_viewer(f->comm, path, FILE_MODE_READ, &viewer));
    /* Where that fails, perhaps in one process alone, HDF5 cannot be closed: it would wait. */
    PetscCall(load(f, viewer));
    PetscCall(measure(f));
    return PetscViewerDestroy(&viewer);
}

/** Whether planish can work on it: simplices in their own dimension. */
static int check(pl_plexfile *f, const char *path, planish_error *error) {
    PetscInt space = 0, first = 0, last = 0;
    int wrong = f->dim != 2 && f->dim != 3;
    if (DMGetCoordinateDim(f->dm, &space) || DMPlexGetHeightStratum(f->dm, 0, &first, &last))
        return pl_fail_petsc(error, PETSC_ERR_LIB);
    for (PetscInt i = first; i < last && !wrong; i++) {
        PetscInt size;
        wrong = DMPlexGetConeSize(f->dm, i, &size) || size != f->dim + 1;
    }
    wrong |= space != f->dim;
    MPI_Allreduce(MPI_IN_PLACE, &wrong, 1, MPI_INT, MPI_MAX, f->comm);
    if (wrong)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%.300s: is not a mesh of tetrahedra in space, or of triangles in the plane",
                       path);
    if (f->n_elements == 0)
        return pl_fail(error, PLANISH_ERROR_FORMAT, "%.300s: has no elements", path);
    return f->n_elements <= INT32_MAX ? PLANISH_OK
                                      : pl_fail(error, PLANISH_ERROR_FORMAT,
                                                "%.300s: has more than 2147483647 elements", path);
}

int pl_plexfile_read(pl_plexfile *file, MPI_Comm comm, const char *path, const pl_plexform *form,
                     planish_error *error) {
    *file = (pl_plexfile){.comm = comm, .path = path, .form = *form};
    const int before = keep_silent();
    const PetscErrorCode code = read_all(file, path);
    speak(before);
    file->is_broken = code != 0;
    if (code)
        return pl_fail(error, PLANISH_ERROR_FORMAT, "%.300s: cannot be read by PETSc", path);
    return check(file, path, error);
}

void pl_plexfile_close(pl_plexfile *file) {
    DMDestroy(&file->dm);
    PetscSFDestroy(&file->load);
    free(file->begin);
    file->begin = NULL;
}

/* ---- pieces --------------------------------------------------------------------------------- */

/** The file's numbers of dm's points (elements and nodes alone are asked for). */
static PetscErrorCode number_points(const pl_plexfile *f, int64_t *number) {
    PetscInt n;
    const PetscInt *local;
    const PetscSFNode *remote;
    PetscCall(PetscSFGetGraph(f->load, NULL, &n, &local, &remote));
    for (PetscInt i = 0; i < n; i++)
        number[local ? local[i] : i] = f->begin[remote[i].rank] + remote[i].index;
    return 0;
}

/** Corners [.][dim + 1] of dm's elements, as numbers of nodes. */
static PetscErrorCode find_corners(const pl_plexfile *f, const int64_t *number, PetscInt node_first,
                                   PetscInt node_last, PetscInt n, int32_t *corner) {
    const int corners = f->dim + 1;
    for (PetscInt i = 0; i < n; i++) {
        PetscInt *closure = NULL, size, found = 0;
        PetscCall(DMPlexGetTransitiveClosure(f->dm, i, PETSC_TRUE, &size, &closure));
        for (PetscInt k = 0; k < size; k++) {
            const PetscInt point = closure[2 * k];
            if (point < node_first || point >= node_last)
                continue;
            if (found < corners)
                corner[i * corners + found] = (int32_t)(number[point] - f->first_node);
            found++;
        }
        PetscCall(DMPlexRestoreTransitiveClosure(f->dm, i, PETSC_TRUE, &size, &closure));
        if (found != corners) /* faces that are not those of one element */
            return PETSC_ERR_ARG_WRONG;
    }
    return 0;
}

/** Numbers, corners and coordinates as they are here. */
typedef struct loaded {
    PetscInt n_elements, node_first, node_last;
    int64_t *number;
    int32_t *corner;
    int32_t *region; /* [n_elements] */
    double *x;
} loaded;

/** Coordinates [node_last - node_first][dim] as they were read. */
static PetscErrorCode take_coordinates(const pl_plexfile *f, PetscInt node_first,
                                       PetscInt node_last, double *to) {
    Vec vector;
    const PetscScalar *x;
    PetscSection section;
    PetscCall(DMGetCoordinatesLocal(f->dm, &vector));
    PetscCall(DMGetCoordinateSection(f->dm, &section));
    PetscCall(VecGetArrayRead(vector, &x));
    for (PetscInt i = node_first; i < node_last; i++) {
        PetscInt at;
        PetscCall(PetscSectionGetOffset(section, i, &at));
        for (int d = 0; d < f->dim; d++)
            to[(i - node_first) * f->dim + d] = (double)x[at + d];
    }
    return VecRestoreArrayRead(vector, &x);
}

static PetscErrorCode take_loaded(const pl_plexfile *f, loaded *l) {
    PetscInt first, last;
    PetscBool has_regions;
    Vec vector;
    PetscCall(DMGetCoordinatesLocal(f->dm, &vector)); /* collective: what can fail comes behind */
    PetscCall(DMPlexGetChart(f->dm, NULL, &last));
    PetscCall(DMPlexGetHeightStratum(f->dm, 0, &first, &l->n_elements));
    PetscCall(DMPlexGetDepthStratum(f->dm, 0, &l->node_first, &l->node_last));
    const int64_t n = l->node_last - l->node_first;
    l->number = pl_new_array(last, sizeof *l->number);
    l->corner = pl_new_array((int64_t)l->n_elements * (f->dim + 1), sizeof *l->corner);
    l->region = pl_new_array(l->n_elements, sizeof *l->region);
    l->x = pl_new_array(n * f->dim, sizeof *l->x);
    PetscCheck(l->number && l->corner && l->region && l->x, PETSC_COMM_SELF, PETSC_ERR_MEM,
               "Loaded");
    PetscCall(number_points(f, l->number));
    PetscCall(find_corners(f, l->number, l->node_first, l->node_last, l->n_elements, l->corner));
    PetscCall(DMHasLabel(f->dm, regions, &has_regions));
    for (PetscInt i = 0; has_regions && i < l->n_elements; i++) {
        PetscInt region;
        PetscCall(DMGetLabelValue(f->dm, regions, i, &region));
        l->region[i] = (int32_t)region;
    }
    return take_coordinates(f, l->node_first, l->node_last, l->x);
}

PetscErrorCode pl_plexfile_nodes(const pl_plexfile *f, int64_t *n, int64_t **number, double **x) {
    PetscInt first, last, node_first, node_last;
    PetscCall(DMPlexGetChart(f->dm, &first, &last));
    PetscCall(DMPlexGetDepthStratum(f->dm, 0, &node_first, &node_last));
    *n = last > 0 ? node_last - node_first : 0;
    int64_t *of_point = pl_new_array(last, sizeof *of_point);
    *number = pl_new_array(*n, sizeof **number);
    *x = pl_new_array(*n * f->dim, sizeof **x);
    PetscCheck(of_point && *number && *x, PETSC_COMM_SELF, PETSC_ERR_MEM, "Nodes");
    PetscCall(number_points(f, of_point));
    for (int64_t i = 0; i < *n; i++)
        (*number)[i] = of_point[node_first + i] - f->first_node;
    free(of_point);
    return take_coordinates(f, node_first, node_first + (PetscInt)*n, *x);
}

/** Numbers of n points that sf leads to, less base. */
static PetscErrorCode bring_numbers(PetscSF sf, const int64_t *from, int64_t n, int64_t base,
                                    int32_t *to) {
    int64_t *wide = pl_new_array(n, sizeof *wide);
    PetscCheck(wide, PETSC_COMM_SELF, PETSC_ERR_MEM, "Numbers");
    const PetscErrorCode code = pl_bring(sf, MPI_INT64_T, 1, from, wide);
    for (int64_t i = 0; i < n; i++)
        to[i] = (int32_t)(wide[i] - base);
    free(wide);
    return code;
}

/** Hold the nodes between elements of different regions of dm, which has no faces: of
 *  those that this process owns all elements are here, of the others their processes say so. */
static PetscErrorCode hold_interfaces(DM dm, pl_piece *p) {
    const int32_t *region = p->region;
    int32_t *low = pl_new_array(p->n_points, sizeof *low);
    int32_t *high = pl_new_array(p->n_points, sizeof *high);
    uint8_t *between = pl_new_array(p->n_points, 1), *known = pl_new_array(p->n_points, 1);
    p->constraint = pl_new_array(p->n_nodes, 1);
    PetscCheck(low && high && between && known && p->constraint, PETSC_COMM_SELF, PETSC_ERR_MEM,
               "Regions");
    for (int64_t i = 0; i < p->n_points; i++) {
        low[i] = INT32_MAX;
        high[i] = INT32_MIN;
    }
    for (PetscInt i = 0; i < p->n_elements; i++) {
        const PetscInt *corner;
        PetscCall(DMPlexGetCone(dm, i, &corner));
        for (int j = 0; j <= p->dim; j++) {
            low[corner[j]] = region[i] < low[corner[j]] ? region[i] : low[corner[j]];
            high[corner[j]] = region[i] > high[corner[j]] ? region[i] : high[corner[j]];
        }
    }
    for (int64_t i = 0; i < p->n_points; i++)
        known[i] = between[i] = low[i] < high[i];
    PetscCall(pl_bring(p->points, MPI_UNSIGNED_CHAR, 1, between, known));
    for (int64_t i = 0; i < p->n_nodes; i++)
        p->constraint[i] =
            known[p->first_point + i] ? PLANISH_CONSTRAINT_FIXED : PLANISH_CONSTRAINT_FREE;
    free(low);
    free(high);
    free(between);
    free(known);
    return 0;
}

/** One process: all of it is its piece. */
static PetscErrorCode take_all(const pl_plexfile *f, DM dm, const loaded *l, pl_piece *p) {
    PetscCall(pl_piece_begin(f->comm, dm, p));
    memcpy(p->corner, l->corner, (size_t)p->n_elements * (size_t)(f->dim + 1) * sizeof *p->corner);
    memcpy(p->coordinates, l->x, (size_t)(p->n_nodes * f->dim) * sizeof *p->coordinates);
    for (int64_t i = 0; i < p->n_elements; i++)
        p->element[i] = (int32_t)l->number[i];
    for (int64_t i = 0; i < p->n_nodes; i++)
        p->node[i] = (int32_t)(l->number[l->node_first + i] - f->first_node);
    if (f->ignore_regions)
        return 0;
    p->region = pl_new_array(p->n_elements, sizeof *p->region);
    PetscCheck(p->region, PETSC_COMM_SELF, PETSC_ERR_MEM, "Regions");
    memcpy(p->region, l->region, (size_t)p->n_elements * sizeof *p->region);
    return f->slides ? 0 : hold_interfaces(dm, p);
}

/** Take the piece that migration has led to dm. */
static PetscErrorCode take_piece(const pl_plexfile *f, DM dm, const loaded *l, PetscSF migration,
                                 pl_piece *p) {
    PetscMPIInt n_ranks;
    PetscSF elements, nodes;
    PetscCall(pl_piece_begin(f->comm, dm, p));
    MPI_Comm_size(f->comm, &n_ranks);
    int64_t *zero = pl_new_array(n_ranks, sizeof *zero),
            *begin = pl_new_array(n_ranks, sizeof *begin);
    PetscCheck(zero && begin, PETSC_COMM_SELF, PETSC_ERR_MEM, "Beginnings");
    const int64_t mine = l->node_first;
    MPI_Allgather(&mine, 1, MPI_INT64_T, begin, 1, MPI_INT64_T, f->comm);
    PetscCall(
        pl_select_points(f->comm, migration, 0, p->n_elements, zero, l->n_elements, &elements));
    PetscCall(pl_select_points(f->comm, migration, p->first_point, p->n_nodes, begin,
                               l->node_last - l->node_first, &nodes));
    PetscCall(bring_numbers(elements, l->number, p->n_elements, 0, p->element));
    PetscCall(bring_numbers(nodes, l->number + l->node_first, p->n_nodes, f->first_node, p->node));
    PetscCall(pl_bring(elements, MPI_INT32_T, f->dim + 1, l->corner, p->corner));
    PetscCall(pl_bring(nodes, MPI_DOUBLE, f->dim, l->x, p->coordinates));
    if (!f->ignore_regions) {
        p->region = pl_new_array(p->n_elements, sizeof *p->region);
        PetscCheck(p->region, PETSC_COMM_SELF, PETSC_ERR_MEM, "Regions");
        PetscCall(pl_bring(elements, MPI_INT32_T, 1, l->region, p->region));
        if (!f->slides)
            PetscCall(hold_interfaces(dm, p));
    }
    PetscCall(PetscSFDestroy(&elements));
    PetscCall(PetscSFDestroy(&nodes));
    free(zero);
    free(begin);
    return 0;
}

static PetscErrorCode cut(pl_plexfile *f, const loaded *l, pl_piece *piece) {
    DM dm = NULL, out = NULL;
    PetscSF migration = NULL;
    PetscMPIInt n_ranks;
    PetscInt depth;
    MPI_Comm_size(f->comm, &n_ranks);
    /* Faces and edges are of no use here. */
    PetscCall(DMPlexGetDepth(f->dm, &depth));
    MPI_Allreduce(MPI_IN_PLACE, &depth, 1, MPIU_INT, MPI_MAX, f->comm);
    if (depth > 1) {
        PetscCall(DMPlexUninterpolate(f->dm, &dm));
    } else {
        dm = f->dm;
        PetscCall(PetscObjectReference((PetscObject)dm));
    }
    if (n_ranks == 1) {
        PetscCall(take_all(f, dm, l, piece));
    } else {
        PetscCall(pl_piece_hand_out(dm, l->n_elements, l->corner, &migration, &out));
        PetscCall(take_piece(f, out, l, migration, piece));
    }
    PetscCall(DMDestroy(&dm));
    PetscCall(DMDestroy(&out));
    return PetscSFDestroy(&migration);
}

int pl_plexfile_cut(pl_plexfile *file, pl_piece *piece, planish_error *error) {
    loaded l = {.n_elements = 0};
    *piece = (pl_piece){.dim = 0};
    int code = take_loaded(file, &l);
    MPI_Allreduce(MPI_IN_PLACE, &code, 1, MPI_INT, MPI_MAX, file->comm);
    const int is_damaged = code == PETSC_ERR_ARG_WRONG;
    if (!code)
        code = cut(file, &l, piece);
    free(l.number);
    free(l.corner);
    free(l.region);
    free(l.x);
    if (is_damaged)
        return pl_fail(
            error, PLANISH_ERROR_MESH,
            "an element has faces that are not those of one simplex; the file is damaged");
    return code ? pl_fail_petsc(error, code) : PLANISH_OK;
}

/* ---- writing -------------------------------------------------------------------------------- */

static PetscErrorCode view(MPI_Comm comm, DM dm, const char *path) {
    PetscViewer viewer;
    PetscCall(open_viewer(comm, path, FILE_MODE_WRITE, &viewer));
    PetscCall(DMView(dm, viewer)); /* if that fails HDF5 cannot be closed: it would wait for ever */
    return PetscViewerDestroy(&viewer);
}

static pl_temporaries temporaries(void) {
    return (pl_temporaries){pl_signals_temporary(PL_TEMPORARY_MESH), PL_TEMPORARY_SIZE};
}

/** Make the file beside path, in the first process; all know its name, in text [size]. Its owner
 * may read and write it whatever mode it is to have. */
static int begin_beside(MPI_Comm comm, const char *path, pl_plexout *out, char *text, int size,
                        planish_error *error) {
    int rank, code = PLANISH_OK;
    MPI_Comm_rank(comm, &rank);
    *out = (pl_plexout){.output = {.fd = -1}, .mode = -1};
    if (rank == 0)
        code = pl_output_open(path, temporaries(), &out->output, error);
    const char *temporary = code ? NULL : out->output.temporary;
    if (rank == 0 && !code && !temporary)
        code = pl_fail(error, PLANISH_ERROR_FILE, "%.300s: is a pipe or device; HDF5 needs a file",
                       path);
    if (rank == 0 && !code) {
        out->mode = pl_file_make_accessible(temporary);
        if (snprintf(text, (size_t)size, "%s", temporary) >= size)
            code = pl_fail(error, PLANISH_ERROR_FILE, "%.300s: has too long a name", path);
    }
    MPI_Bcast(&code, 1, MPI_INT, 0, comm);
    MPI_Bcast(text, size, MPI_BYTE, 0, comm);
    if (rank > 0 && !code) { /* whichever process a signal ends removes it */
        char *list = temporaries().paths;
        memcpy(list + 1, text + 1, (size_t)size - 1);
        list[0] = text[0];
    }
    return code;
}

int pl_plexfile_finish(pl_plexout *out, int code, planish_error *error) {
    pl_output *output = &out->output;
    if (output->temporary && out->mode >= 0)
        pl_file_set_mode(output->temporary, out->mode);
    if (output->temporary && !code)
        code = pl_output_finish(output, error);
    if (output->temporary && !code)
        code = pl_output_commit(output, temporaries(), error);
    pl_output_release(output, temporaries());
    memset(temporaries().paths, 0, PL_TEMPORARY_SIZE);
    return code;
}

int pl_plexfile_write(pl_plexfile *file, const pl_share *share, const char *path, pl_plexout *out,
                      uint64_t *checksums, planish_error *error) {
    char temporary[2 * PATH_MAX] = "";
    int reason = 0;
    const int status = begin_beside(file->comm, path, out, temporary, (int)sizeof temporary, error);
    if (status)
        return status;
    const PetscErrorCode code = pl_plexrows_write(file, share, temporary, checksums, &reason);
    if (code)
        return pl_fail_petsc(error, code);
    if (!reason)
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_FILE, "%.300s: cannot be written: %s", path,
                   strerror(reason));
}

static PetscErrorCode make_plex(MPI_Comm comm, const planish_mesh *whole, const int32_t *region,
                                DM *dm) {
    static const planish_mesh nothing = {.dim = 0};
    const planish_mesh *w = whole ? whole : &nothing;
    int dim = w->n_elements * (w->dim + 1) + w->n_nodes > PETSC_MAX_INT ? -1 : w->dim;
    PetscInt *corner;
    MPI_Bcast(&dim, 1, MPI_INT, 0, comm);
    if (dim < 0)
        return PETSC_ERR_ARG_OUTOFRANGE;
    const int64_t n = w->n_elements * (dim + 1);
    PetscCall(PetscMalloc1((size_t)n + 1, &corner));
    for (int64_t i = 0; i < n; i++)
        corner[i] = w->elements[i];
    PetscCall(DMPlexCreateFromCellListPetsc(comm, dim, (PetscInt)w->n_elements,
                                            (PetscInt)w->n_nodes, dim + 1, PETSC_FALSE, corner, dim,
                                            w->coordinates, dm));
    PetscCall(PetscFree(corner));
    PetscCall(DMCreateLabel(*dm, regions));
    for (int64_t i = 0; region && i < w->n_elements; i++)
        PetscCall(DMSetLabelValue(*dm, regions, (PetscInt)i, region[i]));
    return PetscObjectSetName((PetscObject)*dm, own_name);
}

/** Find by more bytes why HDF5 cannot write the file at path, of which it does not tell: an errno, or 0. */
static int find_reason(const char *path) {
    static const char block[1 << 16];
    enum { MOST = 256 };
    int reason = 0;
    const int fd = open(path, O_WRONLY | O_APPEND);
    for (int i = 0; i < MOST && fd >= 0 && !reason; i++)
        if (write(fd, block, sizeof block) < 0)
            reason = errno;
    if (fd >= 0)
        close(fd);
    return fd >= 0 ? reason : errno;
}

int pl_plexfile_convert(MPI_Comm comm, const planish_mesh *whole, const int32_t *region,
                        const char *path, pl_plexout *out, planish_error *error) {
    char temporary[2 * PATH_MAX] = "";
    DM dm = NULL;
    int status = begin_beside(comm, path, out, temporary, (int)sizeof temporary, error);
    if (status)
        return status;
    PetscErrorCode code = make_plex(comm, whole, region, &dm);
    if (code)
        status = pl_fail_petsc(error, code);
    const int before = keep_silent();
    if (!status && view(comm, dm, temporary)) {
        const int reason = find_reason(temporary);
        status = pl_fail(error, PLANISH_ERROR_FILE, "%.300s: cannot be written%s%s", path,
                         reason ? ": " : "", reason ? strerror(reason) : "");
    }
    speak(before);
    DMDestroy(&dm);
    return status;
}
