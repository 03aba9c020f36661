/* vtkhdf: VTK's unstructured grids in HDF5, of one or several partitions.
 *
 * All partitions' points stand one after another in one array, and so do their cells, whose nodes
 * count from the first point of their partition. A point-data array called "fixed" marks nodes, and
 * cell data may tell regions, as in VTK's other files. All other data are read when somebody asks.
 */
#ifdef PL_HDF5
#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/core/data.h"
#include "io/core/format.h"
#include "io/core/records.h"
#include "io/hdf5/hdf5.h"
#include "io/vtk/vtk_cells.h"
#include "io/vtk/vtk_numbers.h"

#include <stdio.h>
#include <string.h>

#define GRID "/VTKHDF"

typedef struct vtkhdf_reader {
    io_model *model;
    io_hdf5 *file;
    planish_error *error;
    io_hdf5_integers points, cells, ids;           /* how many each partition has, */
    io_hdf5_integers connectivity, offsets, types; /* and those of all */
    int64_t n_cells;
} vtkhdf_reader;

/* ---- what the file has --------------------------------------------------------------------- */

/** Refuse other kinds of VTKHDF files, and a series of grids, which cannot be smoothed at once. */
static int check_kind(vtkhdf_reader *r) {
    char type[64] = "";
    int64_t n = 1;
    int status = io_hdf5_text_attribute(r->file, GRID, "Type", type, sizeof type, NULL);
    if (status)
        return status;
    if (io_hdf5_kind_of(r->file, GRID) != IO_HDF5_GROUP)
        return io_hdf5_fail(r->file, GRID, "this group does not exist: this is not a VTKHDF file");
    if (strcmp(type, "UnstructuredGrid") != 0)
        return io_hdf5_fail(r->file, GRID,
                            "its Type is '%s'; planish smooths an UnstructuredGrid: write one, "
                            "with ParaView's filter Append Datasets for instance",
                            type);
    if (io_hdf5_kind_of(r->file, GRID "/Steps") == IO_HDF5_GROUP)
        status = io_hdf5_attribute(r->file, GRID "/Steps", "NSteps", &n, NULL);
    if (!status && n != 1)
        return io_hdf5_fail(r->file, GRID "/Steps",
                            "there are %lld time steps; write the one that is to be smoothed to "
                            "a file of its own",
                            (long long)n);
    return status;
}

/** Check that the sum of what partitions have, and more of each, is what there is. */
static int check_sum(vtkhdf_reader *r, const char *path, const io_hdf5_integers *counts,
                     int64_t more, int64_t there) {
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

/** Read the points, the lists of the cells, and how many each partition has. */
static int read_lists(vtkhdf_reader *r) {
    const struct {
        const char *path;
        io_hdf5_integers *to;
    } lists[] = {{GRID "/NumberOfPoints", &r->points},
                 {GRID "/NumberOfCells", &r->cells},
                 {GRID "/NumberOfConnectivityIds", &r->ids},
                 {GRID "/Connectivity", &r->connectivity},
                 {GRID "/Offsets", &r->offsets},
                 {GRID "/Types", &r->types}};
    static const char path[] = GRID "/Points";
    io_hdf5_shape shape;
    int status = PLANISH_OK;
    for (size_t i = 0; i < sizeof lists / sizeof *lists && !status; i++)
        status = io_hdf5_integers_read(r->file, lists[i].path, lists[i].to);
    if (!status)
        status = io_hdf5_shape_of(r->file, path, &shape);
    if (status)
        return status;
    r->n_cells = r->types.n;
    if (r->cells.n != r->points.n || r->ids.n != r->points.n)
        return io_hdf5_fail(r->file, GRID "/NumberOfCells",
                            "%lld partitions of points, %lld of cells, %lld of connectivity",
                            (long long)r->points.n, (long long)r->cells.n, (long long)r->ids.n);
    if (shape.rank != 2 || shape.dims[1] != 3)
        return io_hdf5_fail(r->file, path, "three coordinates a point were expected");
    status = check_sum(r, GRID "/NumberOfPoints", &r->points, 0, shape.dims[0]);
    if (!status)
        status = check_sum(r, GRID "/NumberOfCells", &r->cells, 0, r->n_cells);
    if (!status)
        status = check_sum(r, GRID "/NumberOfConnectivityIds", &r->ids, 0, r->connectivity.n);
    if (!status)
        status = check_sum(r, GRID "/NumberOfCells", &r->cells, 1, r->offsets.n);
    if (!status)
        status = io_model_alloc_nodes(r->model, shape.dims[0], 0, r->error);
    if (status)
        return status;
    const io_hdf5_place place = {{GRID "/Points"}, 0, 3, 3, 1, 0, 0};
    status = io_hdf5_coordinates(r->file, &place);
    return status ? status : io_hdf5_coordinates_end(r->file);
}

/* ---- cells --------------------------------------------------------------------------------- */

/** Make n numbers from first narrow ones; those that do not fit are no node and no type. */
static int32_t *narrow_integers(const io_hdf5_integers *from, int64_t first, int64_t n) {
    int32_t *to = pl_alloc(n, sizeof *to);
    for (int64_t i = 0; i < n && to; i++) {
        const int64_t value = io_hdf5_integer(from, first + i);
        to[i] = value >= 0 && value <= INT32_MAX ? (int32_t)value : -1;
    }
    return to;
}

static int read_cells(vtkhdf_reader *r) {
    int64_t first_point = 0, first_cell = 0, first_id = 0;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->cells.n && !status; i++) {
        vtk_grid grid = {.n = io_hdf5_integer(&r->cells, i),
                         .n_connectivity = io_hdf5_integer(&r->ids, i),
                         .n_points = io_hdf5_integer(&r->points, i),
                         .first_point = first_point,
                         .first_cell = first_cell,
                         .is_piece = r->cells.n > 1};
        grid.type = narrow_integers(&r->types, first_cell, grid.n);
        grid.connectivity = narrow_integers(&r->connectivity, first_id, grid.n_connectivity);
        grid.offset = pl_alloc(grid.n + 1, sizeof *grid.offset);
        for (int64_t k = 0; k <= grid.n && grid.offset; k++)
            grid.offset[k] = io_hdf5_integer(&r->offsets, first_cell + i + k);
        status = grid.type && grid.connectivity && grid.offset
                     ? vtk_cells_store(r->model, &grid, r->error)
                     : pl_fail_memory(r->error, "the cells");
        vtk_grid_release(&grid);
        first_point += grid.n_points;
        first_cell += grid.n;
        first_id += grid.n_connectivity;
    }
    return status;
}

/** Hold the nodes of all faces of polyhedra, counts of each partition, which count from its first
 *  point. */
static int hold_faces(vtkhdf_reader *r, const io_hdf5_integers *counts,
                      const io_hdf5_integers *nodes) {
    static const char path[] = GRID "/FaceConnectivity";
    int64_t first = 0, first_point = 0;
    if (counts->n != r->points.n)
        return io_hdf5_fail(r->file, GRID "/NumberOfFaceConnectivityIds",
                            "%lld partitions, and %lld of points", (long long)counts->n,
                            (long long)r->points.n);
    const int status = check_sum(r, path, counts, 0, nodes->n);
    if (status)
        return status;
    for (int64_t i = 0; i < counts->n; i++) {
        const int64_t end = first + io_hdf5_integer(counts, i);
        const int64_t n_points = io_hdf5_integer(&r->points, i);
        for (; first < end; first++) {
            const int64_t node = io_hdf5_integer(nodes, first);
            if (node < 0 || node >= n_points)
                return io_hdf5_fail(r->file, path, "a node is not among the points: %lld",
                                    (long long)node);
            io_hold_node(r->model, first_point + node, IO_HELD_BY_OTHER);
        }
        first_point += n_points;
    }
    return PLANISH_OK;
}

static int read_faces(vtkhdf_reader *r) {
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

/* ---- data ---------------------------------------------------------------------------------- */

/** Hold the nodes that the point data called fixed mark. */
static int read_fixed(vtkhdf_reader *r) {
    static const char path[] = GRID "/PointData/fixed";
    double *values = NULL;
    io_hdf5_shape shape = {0};
    if (io_hdf5_kind_of(r->file, path) == IO_HDF5_NONE)
        return PLANISH_OK;
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

/** Read the cell data that may tell regions. */
static int read_cell_data(vtkhdf_reader *r) {
    static const char group[] = GRID "/CellData";
    io_hdf5_names names;
    if (io_hdf5_kind_of(r->file, group) != IO_HDF5_GROUP)
        return PLANISH_OK;
    int status = io_hdf5_list(r->file, group, &names);
    for (int64_t i = 0; i < names.n && i < IO_MOST_ARRAYS && !status; i++) {
        const io_hdf5_path path = io_hdf5_path_of(r->file, "%s/%s", group, names.name[i]);
        status = io_hdf5_cell_array(r->file, path.text, names.name[i], r->n_cells, 0, NULL);
    }
    return status;
}

/** Return the path of point or cell data. */
static io_hdf5_path path_of_data(io_hdf5 *file, int of_elements, const char *name) {
    return io_hdf5_path_of(file, "%s/%s/%s", GRID, of_elements ? "CellData" : "PointData", name);
}

/** Note the place of an array of numbers; others are passed over. */
static int note_array(vtkhdf_reader *r, int of_elements, const char *name) {
    const io_hdf5_path path = path_of_data(r->file, of_elements, name);
    const int64_t n = of_elements ? r->n_cells : r->model->n_nodes;
    io_hdf5_shape shape;
    int is_integer;
    char text[96];
    if (!of_elements && strcmp(name, "fixed") == 0)
        return PLANISH_OK;
    if (!io_hdf5_is_numbers(r->file, path.text, &shape, &is_integer)) {
        snprintf(text, sizeof text, "the array '%.64s'", name);
        return io_model_note_lost(r->model, 1, text, r->error);
    }
    return io_data_note(r->model,
                        (io_data){.name = (char *)name, /* it is copied */
                                  .of_elements = of_elements,
                                  .width = shape.rank == 2 ? shape.dims[1] : 1,
                                  .is_integer = is_integer,
                                  .n = n,
                                  .n_cells = r->n_cells},
                        r->error);
}

static int note_data(vtkhdf_reader *r) {
    const int has_fields = io_hdf5_kind_of(r->file, GRID "/FieldData") == IO_HDF5_GROUP;
    int status = PLANISH_OK;
    for (int of_elements = 0; of_elements < 2 && !status; of_elements++) {
        const char *group = of_elements ? GRID "/CellData" : GRID "/PointData";
        io_hdf5_names names = {.n = 0};
        if (io_hdf5_kind_of(r->file, group) == IO_HDF5_GROUP)
            status = io_hdf5_list(r->file, group, &names);
        for (int64_t i = 0; i < names.n && !status; i++)
            status = note_array(r, of_elements, names.name[i]);
    }
    return status ? status : io_model_note_lost(r->model, has_fields, "field data", r->error);
}

/** Read the values of an array, rows of points or of cells. */
static int read_rows(io_hdf5 *file, const io_model *model, const io_data *data, double *values) {
    const io_hdf5_path path = path_of_data(file, data->of_elements, data->name);
    const int64_t n = data->of_elements ? io_model_n_elements(model) : model->n_nodes;
    io_hdf5_shape shape;
    double *all = NULL;
    int status = io_hdf5_reals_read(file, path.text, &all, &shape);
    if (!status && shape.n != data->n * data->width)
        status = io_hdf5_fail(file, path.text, "%lld numbers in place of %lld", (long long)shape.n,
                              (long long)(data->n * data->width));
    if (!status && data->of_elements)
        io_data_pick(model, all, data->n, data->width, values);
    else if (!status && n > 0)
        memcpy(values, all, (size_t)(n * data->width) * sizeof *values);
    if (!status)
        vtk_order_tensors(values, n, data->width);
    pl_free(all);
    return status;
}

static int vtkhdf_read_data(io_model *model, const io_data *data, double *values,
                            planish_error *error) {
    io_hdf5 *file;
    int status = io_hdf5_open(model, &file, error);
    if (!status)
        status = read_rows(file, model, data, values);
    return io_hdf5_end(file, status);
}

/* ---- the format ---------------------------------------------------------------------------- */

static int vtkhdf_read(io_model *model, planish_error *error) {
    vtkhdf_reader r = {.model = model, .error = error};
    int status = io_hdf5_open(model, &r.file, error);
    if (!status)
        status = check_kind(&r);
    if (!status)
        status = read_lists(&r);
    if (!status)
        status = read_cells(&r);
    if (!status)
        status = read_faces(&r);
    if (!status)
        status = read_fixed(&r);
    if (!status)
        status = read_cell_data(&r);
    if (!status)
        status = note_data(&r);
    io_hdf5_integers *const lists[] = {&r.points,       &r.cells,   &r.ids,
                                       &r.connectivity, &r.offsets, &r.types};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++)
        io_hdf5_integers_release(lists[i]);
    return io_hdf5_end(r.file, status);
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
                                    .read_data = vtkhdf_read_data,
                                    .release = io_hdf5_release};

#endif
