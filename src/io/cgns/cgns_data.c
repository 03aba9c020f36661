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

#include <string.h>

/** Read the arrays of a solution, unless one of their name is seen already. */
static int read_solution(cgns_reader *r, const char *name, io_hdf5_names *seen) {
    const io_hdf5_path path = cgns_child(r, &r->zone, name);
    char location[32] = "";
    io_hdf5_names arrays = {0};
    int status = cgns_text(r, &path, "GridLocation", location, sizeof location);
    if (!status && strcmp(location, "CellCenter") == 0)
        status = cgns_children(r, &path, "DataArray_t", &arrays);
    for (int64_t i = 0; i < arrays.n && !status && seen->n < IO_MOST_ARRAYS; i++) {
        int is_seen = 0;
        for (int64_t k = 0; k < seen->n && !is_seen; k++)
            is_seen = strcmp(seen->name[k], arrays.name[i]) == 0;
        if (is_seen)
            continue;
        const io_hdf5_path array = cgns_child(r, &path, arrays.name[i]);
        status = io_hdf5_cell_array(r->file, cgns_child(r, &array, " data").text, arrays.name[i],
                                    r->n_elements, 1);
        if (status && status != PLANISH_ERROR_FORMAT)
            break;
        status = io_hdf5_names_add(r->file, seen, arrays.name[i]);
        arrays.name[i] = NULL;
    }
    io_hdf5_names_release(&arrays);
    /* What cannot be read is passed over: solutions need not be for the mesh to be. */
    return status == PLANISH_ERROR_FORMAT ? PLANISH_OK : status;
}

int cgns_read_data(cgns_reader *r) {
    const io_cells *cells = io_model_elements(r->model);
    io_hdf5_names solutions, seen = {0}; /* names of arrays that have been looked at */
    if (cells->n == 0 || cells->n != r->n_elements)
        return PLANISH_OK;
    int status = cgns_children(r, &r->zone, "FlowSolution_t", &solutions);
    for (int64_t i = 0; i < solutions.n && !status; i++)
        status = read_solution(r, solutions.name[i], &seen);
    io_hdf5_names_release(&solutions);
    io_hdf5_names_release(&seen);
    return status;
}

#endif
