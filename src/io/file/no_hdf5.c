/* no_hdf5: the formats in HDF5 where planish is built without that library: opening one says so. */
#ifndef PL_HDF5
#include "io/core/format.h"
#include "io/plex/plex.h"

#include "base/status.h"

int io_hdf5_find_rows(const char *path, const char *dataset, int64_t n, int width, io_span **span,
                      int64_t *n_spans, planish_error *error) {
    (void)path, (void)dataset, (void)n, (void)width, (void)error;
    *span = NULL;
    *n_spans = 0;
    return PLANISH_OK;
}

int io_plex_outline_of(const char *path, io_plex_outline *outline, planish_error *error) {
    *outline = (io_plex_outline){.version = 0};
    return pl_fail(error, PLANISH_ERROR_FORMAT, "%s: this planish was built without HDF5", path);
}

static const char *const med[] = {".med", ".mmed", ".rmed", NULL};
static const char *const cgns[] = {".cgns", NULL};
static const char *const plex[] = {".h5", NULL};
static const char *const vtkhdf[] = {".vtkhdf", ".hdf", NULL};

const io_format io_format_med = {.name = "med", .extensions = med};
const io_format io_format_cgns = {.name = "cgns", .extensions = cgns};
const io_format io_format_vtkhdf = {.name = "vtkhdf", .extensions = vtkhdf};
const io_format io_format_plex = {.name = "dmplex", .extensions = plex};

#endif
