/* exodus: Exodus II files (Cubit, Sierra, MOOSE, libMesh, SEACAS) in netCDF of any kind.
 *
 * Read are the coordinates, the blocks of elements, node sets and side sets with their names, and
 * the nodes that processors share, and, when somebody asks for them, variables of nodes and elements
 * at the first time step. All else (attributes, edge and face blocks) is not looked at.
 */
#include "io/exodus/exodus_reader.h"
#include "io/exodus/exodus_write.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/records.h"

/* ---- nodes ---------------------------------------------------------------------------------- */

static const char *const axes[] = {"coordx", "coordy", "coordz"};

/** Find how many nodes there are, and coordinates of each: from the array of all, or the arrays of
 *  each direction; *is_one: it is the array of all. */
static int find_nodes(exodus_reader *r, int64_t *n, int *columns, int *is_one) {
    netcdf_shape shape;
    int status = netcdf_shape_of(r->file, "coord", &shape);
    *is_one = shape.is_there;
    *columns = shape.rank == 2 && shape.dims[0] < 4 ? (int)shape.dims[0] : 0;
    *n = shape.rank == 2 ? shape.dims[1] : 0;
    for (int d = 0; d < 3 && !*is_one && !status; d++) {
        status = netcdf_shape_of(r->file, axes[d], &shape);
        if (!shape.is_there)
            break;
        *columns = d + 1;
        *n = d == 0 ? shape.n : *n;
    }
    if (!status && *columns == 0 && !*is_one)
        return netcdf_fail(r->file, "coord",
                           "there are no coordinates (coord, or coordx and so on): this netCDF "
                           "file is not an Exodus file, or has no nodes");
    int64_t dim = 0;
    if (!status)
        status = netcdf_dimension(r->file, "num_dim", &dim);
    if (!status && dim > 0 && dim != *columns)
        return netcdf_fail(r->file, *is_one ? "coord" : axes[0],
                           "each node has %d coordinates, but the file says %lld (num_dim)",
                           *columns, (long long)dim);
    if (!status && *columns != 2 && *columns != 3)
        return netcdf_fail(r->file, *is_one ? "coord" : axes[0],
                           "%d coordinates of each node; planish smooths in 2 and 3 dimensions",
                           *columns);
    return status;
}

/** Read the nodes' own numbers, if they are not 1, 2, 3, ... */
static int read_node_numbers(exodus_reader *r) {
    static const char name[] = "node_num_map";
    io_model *model = r->model;
    io_hdf5_integers numbers = {0};
    int64_t counted = 0;
    int status = netcdf_integers_read(r->file, name, &numbers);
    model->first_number = 1;
    if (!status && numbers.n > 0 && numbers.n != model->n_nodes)
        status = netcdf_fail(r->file, name, "%lld numbers for %lld nodes", (long long)numbers.n,
                             (long long)model->n_nodes);
    while (!status && counted < numbers.n && io_hdf5_integer(&numbers, counted) == counted + 1)
        counted++;
    if (!status && counted < numbers.n) {
        model->node_number = pl_alloc(model->n_nodes, sizeof *model->node_number);
        if (!model->node_number)
            status = pl_fail_memory(r->error, "the numbers of nodes");
        for (int64_t i = 0; i < numbers.n && !status; i++)
            model->node_number[i] = io_hdf5_integer(&numbers, i);
    }
    netcdf_integers_release(&numbers);
    return status;
}

/** Hold the nodes that this part of a mesh shares with those of other processors (Nemesis). */
static int hold_shared_nodes(exodus_reader *r) {
    static const char *const lists[] = {"n_comm_nids", "node_mapb", "node_mape"};
    int status = PLANISH_OK;
    for (size_t k = 0; k < sizeof lists / sizeof *lists && !status; k++) {
        io_hdf5_integers list = {0};
        status = netcdf_integers_read(r->file, lists[k], &list);
        for (int64_t i = 0; i < list.n && !status; i++) {
            int32_t node;
            status = exodus_take_node(r, lists[k], &list, i, &node, r->error);
            if (!status)
                io_hold_node(r->model, node, IO_HELD_REQUIRED);
        }
        netcdf_integers_release(&list);
    }
    return status;
}

static int read_nodes(exodus_reader *r) {
    int64_t n = 0;
    int columns = 0, is_one = 0;
    int status = find_nodes(r, &n, &columns, &is_one);
    r->model->columns = columns;
    if (!status)
        status = io_model_alloc_nodes(r->model, n, 0, r->error);
    for (int d = 0; d < (is_one ? 1 : columns) && !status; d++)
        status = netcdf_coordinates(r->file, is_one ? "coord" : axes[d], d, is_one ? columns : 1);
    if (!status)
        status = netcdf_coordinates_end(r->file);
    if (!status)
        status = read_node_numbers(r);
    return status ? status : hold_shared_nodes(r);
}

/* ---- the format ----------------------------------------------------------------------------- */

static int exodus_read(io_model *model, planish_error *error) {
    exodus_reader r = {.model = model, .error = error};
    int status = netcdf_open(model, &r.file, error);
    if (!status)
        status = read_nodes(&r);
    if (!status)
        status = exodus_read_blocks(&r);
    if (!status)
        status = exodus_read_sets(&r);
    for (int dim = 1; dim <= 3 && !status; dim++)
        io_reduce_cell_numbers(io_model_cells(model, dim));
    if (!status)
        status = exodus_note_data(&r);
    netcdf_integers_release(&r.numbers);
    exodus_labels_release(&r.labels);
    pl_free(r.block);
    return netcdf_end(r.file, status);
}

static int exodus_recognise(const char *data, int64_t size) {
    return netcdf_recognise(data, size, "/eb_prop1");
}

static const char *const extensions[] = {".exo", ".e",   ".ex2",     ".exii", ".exoii",
                                         ".g",   ".gen", ".genesis", NULL};

const io_format io_format_exodus = {.name = "exodus",
                                    .extensions = extensions,
                                    .recognise = exodus_recognise,
                                    .read = exodus_read,
#ifdef PL_HDF5
                                    .amend = io_hdf5_amend,
                                    .release = io_hdf5_release,
#endif
                                    .read_data = exodus_read_data,
                                    .targets = exodus_targets};
