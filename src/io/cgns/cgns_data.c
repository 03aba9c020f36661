/* cgns_data: values of cells in the solutions of CGNS files (FlowSolution_t), which may tell
 * regions.
 *
 * In go the zone and its cells; out come arrays (arrays.h). Read are arrays at CellCenter of one
 * number for each cell, if all cells of the zone are elements that are smoothed: then both have the
 * same order. Of arrays of one name, those of time steps say, the first counts. What cannot be
 * read is passed over.
 */
#ifdef PL_HDF5
#include "io/cgns/cgns.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"

#include <string.h>

enum { LOCATION_SIZE = 32 };

typedef struct search {
    cgns_reader *r;
    io_hdf5_names seen; /* names of arrays that have been looked at */
} search;

/** Solutions need not be readable for the mesh to be so. */
static int pass_over(int status) {
    return status == PLANISH_ERROR_FORMAT ? PLANISH_OK : status;
}

/** The elements that are smoothed, if they are all cells of the zone; else NULL. */
static const io_cells *cells_of(cgns_reader *r) {
    const io_cells *cells = io_model_cells(r->model, r->model->tetrahedron.n > 0 ? 3 : 2);
    return cells->n > 0 && cells->n == r->n_elements ? cells : NULL;
}

/* ---- one array ---------------------------------------------------------------------------- */

static int fill(cgns_reader *r, const char *name, const io_hdf5_integers *whole,
                const double *real) {
    io_array_filler filler;
    int status = io_array_begin_elements(r->model, name, &filler, r->error);
    if (status)
        return status;
    for (int64_t i = 0; i < r->n_elements && !status && !filler.is_broken; i++) {
        int64_t value = real ? 0 : io_hdf5_integer(whole, i);
        const int is_whole = real ? io_array_whole(real[i], &value) : 1;
        status = io_array_put_element(&filler, i, is_whole, value, r->error);
    }
    if (!status)
        return io_array_end(r->model, &filler, r->error);
    io_array_drop(&filler);
    return status;
}

/** The array of a node called name whose data are at path. */
static int take_values(cgns_reader *r, const char *path, const char *name) {
    io_hdf5_integers whole = {0};
    double *real = NULL;
    io_hdf5_shape shape;
    const io_hdf5_numbers numbers = io_hdf5_numbers_of(r->file, path, &shape);
    if (numbers == IO_HDF5_NEITHER || shape.n != r->n_elements)
        return PLANISH_OK;
    int status = numbers == IO_HDF5_WHOLE ? io_hdf5_integers_read(r->file, path, &whole)
                                          : io_hdf5_reals_read(r->file, path, &real, &shape);
    if (!status)
        status = fill(r, name, &whole, real);
    io_hdf5_integers_release(&whole);
    pl_free(real);
    return status;
}

static int is_seen(const search *s, const char *name) {
    for (int64_t i = 0; i < s->seen.n; i++)
        if (strcmp(s->seen.name[i], name) == 0)
            return 1;
    return 0;
}

/** Takes over name, which is NULL then. */
static int note_seen(search *s, char **name) {
    char **grown =
        pl_grow(s->seen.name, s->seen.n, s->seen.n + 1, &s->seen.capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(s->r->error, "the arrays of cells");
    s->seen.name = grown;
    s->seen.name[s->seen.n++] = *name;
    *name = NULL;
    return PLANISH_OK;
}

static int take_array(search *s, const char *solution, char **name) {
    char path[IO_HDF5_PATH_SIZE];
    if (s->seen.n == IO_MOST_ARRAYS || is_seen(s, *name))
        return PLANISH_OK;
    int status = io_hdf5_path(s->r->file, path, "%s/%s/ data", solution, *name);
    if (!status)
        status = take_values(s->r, path, *name);
    status = pass_over(status);
    return status ? status : note_seen(s, name);
}

/* ---- solutions ---------------------------------------------------------------------------- */

static int is_of_cells(cgns_reader *r, const char *solution, int *is_so) {
    char path[IO_HDF5_PATH_SIZE], location[LOCATION_SIZE] = "";
    int status = io_hdf5_path(r->file, path, "%s/GridLocation", solution);
    if (!status)
        status = cgns_text(r, path, location, sizeof location);
    *is_so = !status && strcmp(location, "CellCenter") == 0;
    return status;
}

static int take_solution(search *s, const char *name) {
    char path[IO_HDF5_PATH_SIZE];
    io_hdf5_names arrays = {0};
    int is_so = 0;
    int status = io_hdf5_path(s->r->file, path, "%s/%s", s->r->zone, name);
    if (!status)
        status = is_of_cells(s->r, path, &is_so);
    if (!status && is_so)
        status = cgns_children(s->r, path, "DataArray_t", &arrays);
    for (int64_t i = 0; i < arrays.n && !status; i++)
        status = take_array(s, path, &arrays.name[i]);
    io_hdf5_names_release(&arrays);
    return pass_over(status);
}

int cgns_read_data(cgns_reader *r) {
    search s = {.r = r};
    io_hdf5_names solutions;
    if (!cells_of(r))
        return PLANISH_OK;
    int status = cgns_children(r, r->zone, "FlowSolution_t", &solutions);
    for (int64_t i = 0; i < solutions.n && !status; i++)
        status = take_solution(&s, solutions.name[i]);
    io_hdf5_names_release(&solutions);
    io_hdf5_names_release(&s.seen);
    return status;
}

#endif
