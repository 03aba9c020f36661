/* no_hdf5: the formats in HDF5 where planish is built without that library: they say so. */
#ifndef PL_HDF5
#include "io/core/format.h"
#include "io/plex/plex.h"

#include "base/status.h"

static int recognise_nothing(const char *data, int64_t size) {
    (void)data;
    (void)size;
    return 0;
}

static int fail(const io_model *model, const char *format, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: this planish was built without HDF5, which %s files need: install "
                   "libhdf5-dev and build again",
                   model->input.path, format);
}

static int read_med(io_model *model, planish_error *error) {
    return fail(model, "MED", error);
}

static int read_cgns(io_model *model, planish_error *error) {
    return fail(model, "CGNS", error);
}

static int read_vtkhdf(io_model *model, planish_error *error) {
    return fail(model, "VTKHDF", error);
}

static int read_plex(io_model *model, planish_error *error) {
    return fail(model, "DMPlex", error);
}

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

const io_format io_format_med = {
    .name = "med", .extensions = med, .recognise = recognise_nothing, .read = read_med};
const io_format io_format_cgns = {
    .name = "cgns", .extensions = cgns, .recognise = recognise_nothing, .read = read_cgns};
const io_format io_format_vtkhdf = {
    .name = "vtkhdf", .extensions = vtkhdf, .recognise = recognise_nothing, .read = read_vtkhdf};
const io_format io_format_plex = {
    .name = "dmplex", .extensions = plex, .recognise = recognise_nothing, .read = read_plex};

#endif
