/* vtkhdf: VTK's unstructured grids in HDF5, of one or several partitions.
 *
 * All partitions' points stand one after another in one array, and so do their cells, whose nodes
 * count from the first point of their partition. A point-data array called "fixed" marks nodes, and
 * cell data may tell regions, as in VTK's other files. All other data are not looked at.
 */
#ifdef PL_HDF5
#include "io/core/format.h"
#include "io/core/arrays.h"
#include "io/hdf5/hdf5.h"
#include "io/core/records.h"
#include "io/vtk/vtk_cells.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

#define GRID "/VTKHDF"

typedef struct reader {
    io_model *model;
    io_hdf5 *file;
    planish_error *error;
    io_hdf5_integers points, cells, ids;           /* how many each partition has, */
    io_hdf5_integers connectivity, offsets, types; /* and those of all */
    int64_t n_cells;
} reader;

/* ---- what kind of grid --------------------------------------------------------------------- */

static int check_type(reader *r) {
    char type[64] = "";
    int found;
    int status = io_hdf5_text_attribute(r->file, GRID, "Type", type, sizeof type, &found);
    if (!status && io_hdf5_kind_of(r->file, GRID) != IO_HDF5_GROUP)
        return io_hdf5_fail(r->file, GRID, "there is no such group: this is no VTKHDF file");
    if (!status && strcmp(type, "UnstructuredGrid") != 0)
        status = io_hdf5_fail(r->file, GRID,
                              "its Type is '%s'; planish smooths an UnstructuredGrid: write one, "
                              "with ParaView's filter Append Datasets for instance",
                              type);
    return status;
}

/** A series of grids cannot be smoothed at once. */
static int check_steps(reader *r) {
    int64_t n = 1;
    int found;
    if (io_hdf5_kind_of(r->file, GRID "/Steps") != IO_HDF5_GROUP)
        return PLANISH_OK;
    int status = io_hdf5_attribute(r->file, GRID "/Steps", "NSteps", &n, &found);
    if (!status && n != 1)
        status = io_hdf5_fail(r->file, GRID "/Steps",
                              "there are %lld time steps; write the one that is to be smoothed to "
                              "a file of its own",
                              (long long)n);
    return status;
}

/** The sum of what partitions have must be what there is. */
static int check_sum(reader *r, const char *path, const io_hdf5_integers *counts, int64_t more,
                     int64_t there) {
    int64_t sum = 0;
    for (int64_t i = 0; i < counts->n; i++) {
        const int64_t count = io_hdf5_integer(counts, i);
        if (count < 0 || count > there - sum - more)
            return io_hdf5_fail(r->file, path, "partition %lld has %lld, more than there are",
                                (long long)i, (long long)count);
        sum += count + more;
    }
    if (sum != there)
        return io_hdf5_fail(r->file, path, "partitions have %lld in all, and there are %lld",
                            (long long)sum, (long long)there);
    return PLANISH_OK;
}

static int read_counts(reader *r) {
    int status = io_hdf5_integers_read(r->file, GRID "/NumberOfPoints", &r->points);
    if (!status)
        status = io_hdf5_integers_read(r->file, GRID "/NumberOfCells", &r->cells);
    if (!status)
        status = io_hdf5_integers_read(r->file, GRID "/NumberOfConnectivityIds", &r->ids);
    if (!status && (r->cells.n != r->points.n || r->ids.n != r->points.n))
        status = io_hdf5_fail(r->file, GRID "/NumberOfCells",
                              "%lld partitions of points, %lld of cells, %lld of connectivity",
                              (long long)r->points.n, (long long)r->cells.n, (long long)r->ids.n);
    return status;
}

/* ---- points ------------------------------------------------------------------------------- */

static int read_points(reader *r) {
    io_hdf5_shape shape;
    char path[] = GRID "/Points";
    int status = io_hdf5_shape_of(r->file, path, &shape);
    if (!status && (shape.rank != 2 || shape.dims[1] != 3))
        status = io_hdf5_fail(r->file, path, "three coordinates a point were expected");
    if (!status)
        status = check_sum(r, GRID "/NumberOfPoints", &r->points, 0, shape.dims[0]);
    if (!status)
        status = io_model_nodes(r->model, shape.dims[0], 0, r->error);
    if (status)
        return status;
    r->model->columns = 3;
    r->model->first_number = 0;
    const io_hdf5_place place = {path, 0, 3, 3, 1};
    status = io_hdf5_coordinates(r->file, &place);
    return status ? status : io_hdf5_coordinates_end(r->file);
}

/* ---- cells -------------------------------------------------------------------------------- */

static int read_cell_lists(reader *r) {
    int status = io_hdf5_integers_read(r->file, GRID "/Connectivity", &r->connectivity);
    if (!status)
        status = io_hdf5_integers_read(r->file, GRID "/Offsets", &r->offsets);
    if (!status)
        status = io_hdf5_integers_read(r->file, GRID "/Types", &r->types);
    if (!status)
        status = check_sum(r, GRID "/NumberOfCells", &r->cells, 0, r->types.n);
    if (!status)
        status = check_sum(r, GRID "/NumberOfConnectivityIds", &r->ids, 0, r->connectivity.n);
    if (!status)
        status = check_sum(r, GRID "/NumberOfCells", &r->cells, 1, r->offsets.n);
    r->n_cells = r->types.n;
    return status;
}

/** Offsets of a partition must rise from 0 to the size of its list. */
static int take_offsets(reader *r, const vtk_grid *grid, int64_t first) {
    int64_t last = 0;
    for (int64_t i = 0; i <= grid->n; i++) {
        const int64_t offset = io_hdf5_integer(&r->offsets, first + i);
        if (offset < last || offset > grid->n_connectivity || (i == 0 && offset != 0))
            return io_hdf5_fail(r->file, GRID "/Offsets",
                                "offset %lld is %lld: they must rise from 0 to the size of the "
                                "connectivity",
                                (long long)(first + i), (long long)offset);
        grid->offset[i] = last = offset;
    }
    return PLANISH_OK;
}

/** n numbers from first to narrow ones; those that do not fit are no node and no type. */
static void narrow_integers(const io_hdf5_integers *from, int64_t first, int64_t n, int32_t *to) {
    for (int64_t i = 0; i < n; i++) {
        const int64_t value = io_hdf5_integer(from, first + i);
        to[i] = value >= 0 && value <= INT32_MAX ? (int32_t)value : -1;
    }
}

/** Store the cells of a partition; first_id: its first number in Connectivity. */
static int store_partition(reader *r, int64_t partition, vtk_grid *grid, int64_t first_id) {
    int32_t *type = pl_alloc(grid->n, sizeof *type);
    grid->connectivity = pl_alloc(grid->n_connectivity, sizeof *grid->connectivity);
    grid->offset = pl_alloc(grid->n + 1, sizeof *grid->offset);
    int status = type && grid->connectivity && grid->offset ? PLANISH_OK
                                                            : pl_fail_memory(r->error, "the cells");
    if (!status)
        status = take_offsets(r, grid, grid->first_cell + partition);
    if (!status) {
        narrow_integers(&r->types, grid->first_cell, grid->n, type);
        narrow_integers(&r->connectivity, first_id, grid->n_connectivity, grid->connectivity);
        grid->type = type;
        status = vtk_cells_store(r->model, grid, r->error);
    }
    pl_free(grid->offset);
    pl_free(grid->connectivity);
    pl_free(type);
    return status;
}

/** Of polyhedra the nodes of all faces, which count from the first point of their partition. */
static int hold_faces(reader *r, const io_hdf5_integers *counts, const io_hdf5_integers *nodes) {
    static const char path[] = GRID "/FaceConnectivity";
    int64_t first = 0, first_point = 0;
    if (counts->n != r->points.n)
        return io_hdf5_fail(r->file, GRID "/NumberOfFaceConnectivityIds",
                            "%lld partitions, and %lld of points", (long long)counts->n,
                            (long long)r->points.n);
    int status = check_sum(r, path, counts, 0, nodes->n);
    for (int64_t i = 0; i < counts->n && !status; i++) {
        const int64_t n = io_hdf5_integer(counts, i), n_points = io_hdf5_integer(&r->points, i);
        for (int64_t k = 0; k < n && !status; k++) {
            const int64_t node = io_hdf5_integer(nodes, first + k);
            if (node < 0 || node >= n_points)
                status = io_hdf5_fail(r->file, path, "a node is not among the points: %lld",
                                      (long long)node);
            else
                io_hold_node(r->model, first_point + node, IO_HELD_BY_OTHER);
        }
        first += n;
        first_point += n_points;
    }
    return status;
}

static int read_faces(reader *r) {
    io_hdf5_integers counts = {0}, nodes = {0};
    if (io_hdf5_kind_of(r->file, GRID "/FaceConnectivity") != IO_HDF5_DATASET)
        return PLANISH_OK;
    int status = io_hdf5_integers_read(r->file, GRID "/NumberOfFaceConnectivityIds", &counts);
    if (!status)
        status = io_hdf5_integers_read(r->file, GRID "/FaceConnectivity", &nodes);
    if (!status)
        status = hold_faces(r, &counts, &nodes);
    io_hdf5_integers_release(&nodes);
    io_hdf5_integers_release(&counts);
    return status;
}

static int read_cells(reader *r) {
    int64_t first_point = 0, first_cell = 0, first_id = 0;
    int status = read_cell_lists(r);
    for (int64_t i = 0; i < r->cells.n && !status; i++) {
        vtk_grid grid = {.n = io_hdf5_integer(&r->cells, i),
                         .n_connectivity = io_hdf5_integer(&r->ids, i),
                         .n_points = io_hdf5_integer(&r->points, i),
                         .first_point = first_point,
                         .first_cell = first_cell,
                         .is_piece = r->cells.n > 1};
        status = store_partition(r, i, &grid, first_id);
        first_point += grid.n_points;
        first_cell += grid.n;
        first_id += grid.n_connectivity;
    }
    return status;
}

/* ---- data --------------------------------------------------------------------------------- */

static int hold_fixed(reader *r, const char *path) {
    double *values = NULL;
    io_hdf5_shape shape = {0};
    int status = io_hdf5_reals_read(r->file, path, &values, &shape);
    if (!status && shape.dims[0] != r->model->n_nodes)
        status = io_hdf5_fail(r->file, path, "%lld values for %lld points",
                              (long long)shape.dims[0], (long long)r->model->n_nodes);
    for (int64_t i = 0; i < shape.n && !status; i++)
        if (values[i] != 0)
            io_hold_node(r->model, i / shape.dims[1], IO_HELD_MARKED);
    pl_free(values);
    return status;
}

static int read_fixed(reader *r) {
    char path[IO_HDF5_PATH_SIZE];
    io_hdf5_names names = {0};
    if (io_hdf5_kind_of(r->file, GRID "/PointData") != IO_HDF5_GROUP)
        return PLANISH_OK;
    int status = io_hdf5_list(r->file, GRID "/PointData", &names);
    for (int64_t i = 0; i < names.n && !status; i++) {
        if (!io_word_is(names.name[i], (int64_t)strlen(names.name[i]), "fixed", 0))
            continue;
        status = io_hdf5_path(r->file, path, GRID "/PointData/%s", names.name[i]);
        if (!status)
            status = hold_fixed(r, path);
    }
    io_hdf5_names_release(&names);
    return status;
}

/** The values of an array of cells, of either kind. */
typedef struct values {
    io_hdf5_integers whole;
    double *real; /* owned, or NULL: whole */
} values;

static int read_values(reader *r, const char *path, io_hdf5_numbers numbers, values *v) {
    io_hdf5_shape shape;
    *v = (values){.real = NULL};
    return numbers == IO_HDF5_WHOLE ? io_hdf5_integers_read(r->file, path, &v->whole)
                                    : io_hdf5_reals_read(r->file, path, &v->real, &shape);
}

static void release_values(values *v, io_hdf5_numbers numbers) {
    if (numbers == IO_HDF5_WHOLE)
        io_hdf5_integers_release(&v->whole);
    pl_free(v->real);
}

static int fill_array(reader *r, const char *name, const values *v) {
    io_array_filler filler;
    int status = io_array_begin(r->model, name, r->n_cells, &filler, r->error);
    if (status)
        return status;
    for (int64_t i = 0; i < r->n_cells && !status && !filler.is_broken; i++) {
        int64_t value = v->real ? 0 : io_hdf5_integer(&v->whole, i);
        const int is_whole = v->real ? io_array_whole(v->real[i], &value) : 1;
        status = io_array_put(&filler, i, is_whole, value, r->error);
    }
    if (!status)
        return io_array_end(r->model, &filler, r->error);
    io_array_drop(&filler);
    return status;
}

/** Take an array that has one number for each cell; others are passed over. */
static int take_array(reader *r, const char *name) {
    char path[IO_HDF5_PATH_SIZE];
    io_hdf5_shape shape;
    values v;
    int status = io_hdf5_path(r->file, path, GRID "/CellData/%s", name);
    if (status || io_hdf5_kind_of(r->file, path) != IO_HDF5_DATASET)
        return status;
    const io_hdf5_numbers numbers = io_hdf5_numbers_of(r->file, path, &shape);
    if (numbers == IO_HDF5_NEITHER || shape.n != r->n_cells)
        return PLANISH_OK;
    status = read_values(r, path, numbers, &v);
    if (!status)
        status = fill_array(r, name, &v);
    release_values(&v, numbers);
    return status;
}

static int read_cell_data(reader *r) {
    io_hdf5_names names = {0};
    if (io_hdf5_kind_of(r->file, GRID "/CellData") != IO_HDF5_GROUP)
        return PLANISH_OK;
    int status = io_hdf5_list(r->file, GRID "/CellData", &names);
    for (int64_t i = 0; i < names.n && i < IO_MOST_ARRAYS && !status; i++)
        status = take_array(r, names.name[i]);
    io_hdf5_names_release(&names);
    return status;
}

/* ---- the format --------------------------------------------------------------------------- */

static int read_grid(reader *r) {
    int status = check_type(r);
    if (!status)
        status = check_steps(r);
    if (!status)
        status = read_counts(r);
    if (!status)
        status = read_points(r);
    if (!status)
        status = read_cells(r);
    if (!status)
        status = read_faces(r);
    if (!status)
        status = read_fixed(r);
    return status ? status : read_cell_data(r);
}

static int vtkhdf_read(io_model *model, planish_error *error) {
    reader r = {.model = model, .error = error};
    int status = io_hdf5_open(model, &r.file, error);
    if (!status)
        status = read_grid(&r);
    if (!status)
        status = io_hdf5_check(r.file);
    io_hdf5_integers *const lists[] = {&r.points,       &r.cells,   &r.ids,
                                       &r.connectivity, &r.offsets, &r.types};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        io_hdf5_integers_release(lists[i]);
    io_hdf5_close(r.file);
    return status;
}

static int vtkhdf_recognise(const char *data, int64_t size) {
    return io_hdf5_recognise(data, size, GRID);
}

static const char *const extensions[] = {".vtkhdf", ".hdf", NULL};

const io_format io_format_vtkhdf = {.name = "vtkhdf",
                                    .extensions = extensions,
                                    .recognise = vtkhdf_recognise,
                                    .read = vtkhdf_read,
                                    .amend = io_hdf5_amend,
                                    .release = io_hdf5_release};

#endif
