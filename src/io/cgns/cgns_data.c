/* cgns_data: values of cells in the solutions of CGNS files (FlowSolution_t), which may tell
 * regions.
 *
 * In go the zone and its cells; out come arrays (arrays.h). Read are arrays at CellCenter of one
 * number for each cell, if all cells of the zone are elements that are smoothed: then both have the
 * same order. Of arrays of one name, those of time steps say, the first counts. Arrays that cannot
 * be read are passed over.
 */
#ifdef PL_HDF5
#include "io/cgns/cgns.h"

#include "io/core/arrays.h"

#include "base/memory.h"

#include <string.h>

/** Pass over what cannot be read: solutions need not be for the mesh to be. */
static int pass_over(int status) {
    return status == PLANISH_ERROR_FORMAT ? PLANISH_OK : status;
}

/** Make an array of the values of the array called name in a solution. */
static int read_array(cgns_reader *r, const char *solution, const char *name) {
    char path[IO_HDF5_PATH_SIZE];
    io_array_filler filler;
    io_hdf5_integers whole = {0};
    double *real = NULL;
    io_hdf5_shape shape;
    int status = io_hdf5_path(r->file, path, "%s/%s/ data", solution, name);
    if (status)
        return status;
    const io_hdf5_numbers numbers = io_hdf5_numbers_of(r->file, path, &shape);
    if (numbers == IO_HDF5_NEITHER || shape.n != r->n_elements)
        return PLANISH_OK;
    status = numbers == IO_HDF5_WHOLE ? io_hdf5_integers_read(r->file, path, &whole)
                                      : io_hdf5_reals_read(r->file, path, &real, &shape);
    if (!status)
        status = io_array_begin_elements(r->model, name, &filler, r->error);
    if (!status) {
        for (int64_t i = 0; i < r->n_elements && !status && !filler.is_broken; i++) {
            int64_t value = real ? 0 : io_hdf5_integer(&whole, i);
            const int is_whole = real ? io_array_whole(real[i], &value) : 1;
            status = io_array_put_element(&filler, i, is_whole, value, r->error);
        }
        if (status)
            io_array_drop(&filler);
        else
            status = io_array_end(r->model, &filler, r->error);
    }
    io_hdf5_integers_release(&whole);
    pl_free(real);
    return status;
}

/** Read the arrays of a solution, unless they are seen already. */
static int read_solution(cgns_reader *r, const char *name, io_hdf5_names *seen) {
    char path[IO_HDF5_PATH_SIZE], location[32] = "";
    io_hdf5_names arrays = {0};
    int status = io_hdf5_path(r->file, path, "%s/%s", r->zone, name);
    if (!status)
        status = cgns_text(r, path, "GridLocation", location, sizeof location);
    if (!status && strcmp(location, "CellCenter") == 0)
        status = cgns_children(r, path, "DataArray_t", &arrays);
    for (int64_t i = 0; i < arrays.n && !status && seen->n < IO_MOST_ARRAYS; i++) {
        int is_seen = 0;
        for (int64_t k = 0; k < seen->n && !is_seen; k++)
            is_seen = strcmp(seen->name[k], arrays.name[i]) == 0;
        if (is_seen)
            continue;
        status = pass_over(read_array(r, path, arrays.name[i]));
        if (!status) {
            status = io_hdf5_names_add(r->file, seen, arrays.name[i]);
            arrays.name[i] = NULL;
        }
    }
    io_hdf5_names_release(&arrays);
    return pass_over(status);
}

int cgns_read_data(cgns_reader *r) {
    const io_cells *cells = io_model_elements(r->model);
    io_hdf5_names solutions, seen = {0}; /* names of arrays that have been looked at */
    if (cells->n == 0 || cells->n != r->n_elements)
        return PLANISH_OK;
    int status = cgns_children(r, r->zone, "FlowSolution_t", &solutions);
    for (int64_t i = 0; i < solutions.n && !status; i++)
        status = read_solution(r, solutions.name[i], &seen);
    io_hdf5_names_release(&solutions);
    io_hdf5_names_release(&seen);
    return status;
}

#endif
