/* file: open a mesh file of any format, and what can be asked of it. */
#include "io/file/file.h"
#include "io/file/finish.h"

#include "io/core/arrays.h"
#include "io/core/bytes.h"
#include "io/core/child.h"
#include "io/core/number.h"
#include "io/core/output.h"
#include "io/file/plane.h"
#include "io/abaqus/ucd.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "base/system.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

/* ---- the table of formats ----------------------------------------------------------------- */

static const io_format *const formats[] = {
    &io_format_vtk,     &io_format_vtu, /* first: with numbers whose bytes could be anything */
    &io_format_nastran,                 /* its comments may look like Gmsh's sections */
    &io_format_gmsh,    &io_format_medit, &io_format_vtkhdf, &io_format_tetgen, &io_format_netgen,
    &io_format_abaqus,  &io_format_cgns,  &io_format_med,    &io_format_plex,   &io_format_off};
enum { N_FORMATS = sizeof formats / sizeof *formats };

const char *const *planish_file_formats(void) {
    static const char *const names[] = {"gmsh",   "medit",  "vtk",    "vtu",     "vtkhdf",
                                        "tetgen", "netgen", "abaqus", "nastran", "cgns",
                                        "med",    "dmplex", "off",    NULL};
    return names;
}

/** "gmsh, medit, ..." */
static void list_formats(char *text, size_t size) {
    size_t length = 0;
    text[0] = '\0';
    for (const char *const *name = planish_file_formats(); *name && length < size; name++)
        length += (size_t)snprintf(text + length, size - length, "%s%s", length ? ", " : "", *name);
}

const io_format *io_format_by_name(const char *name) {
    for (int i = 0; i < N_FORMATS; i++)
        if (strcmp(formats[i]->name, name) == 0)
            return formats[i];
    return NULL;
}

const io_format *io_format_by_extension(const char *path) {
    for (int i = 0; i < N_FORMATS; i++)
        if (io_format_has_extension(formats[i], path))
            return formats[i];
    return NULL;
}

const io_format *io_format_find(const char *path, const char *data, int64_t size) {
    enum {
        LOOKED_AT = 1 << 18
    }; /* what begins a file of any format but HDF5 is not farther: most
          can be before it in Nastran's, comments and cases */
    if (size > LOOKED_AT && !io_is_hdf5(data, size))
        size = LOOKED_AT;
    for (int i = 0; i < N_FORMATS; i++)
        if (formats[i]->recognise(data, size))
            return formats[i];
    return io_format_by_extension(path);
}

/* ---- opening ------------------------------------------------------------------------------ */

static int is_gzip(const io_bytes *input) {
    return input->size > 2 && memcmp(input->data, "\x1f\x8b", 2) == 0;
}

/** Text of two bytes a letter begins with their order. */
static int is_utf16(const io_bytes *input) {
    return input->size > 2 &&
           (memcmp(input->data, "\xff\xfe", 2) == 0 || memcmp(input->data, "\xfe\xff", 2) == 0);
}

static int choose_format(planish_file *file, const char *name, planish_error *error) {
    const io_bytes *input = &file->model.input;
    if (io_is_ucd(input->data, input->size))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is an AVS UCD file, which is not read; convert it to another format, "
                       "with ParaView or meshio (meshio convert -i avsucd IN.inp OUT.vtu)",
                       input->path);
    file->format =
        name ? io_format_by_name(name) : io_format_find(input->path, input->data, input->size);
    if (file->format || is_gzip(input) || is_utf16(input))
        return PLANISH_OK; /* of the others read_model says what to do */
    char names[256];
    list_formats(names, sizeof names);
    if (name)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "unknown format '%s'; there are %s", name,
                       names);
    if (io_is_hdf5(input->data, input->size))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is an HDF5 file, but neither CGNS nor MED nor VTKHDF nor PETSc's "
                       "DMPlex, which alone are read of these",
                       input->path);
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: neither content nor extension is of a known mesh format; there are %s "
                   "(docs/formats.md)",
                   input->path, names);
}

static int count_regions(planish_file *file, planish_error *error) {
    const io_cells *cells = io_file_elements(file);
    const int32_t *region = io_cells_regions(cells);
    int32_t last = 0;
    for (int64_t i = 0; region && i < cells->n; i++)
        last = region[i] > last ? region[i] : last;
    file->n_regions = region ? 0 : 1;
    uint8_t *seen = region ? pl_alloc_zero((int64_t)last + 1, 1) : NULL;
    if (region && !seen)
        return pl_fail_memory(error, file->model.input.path);
    for (int64_t i = 0; region && i < cells->n; i++) {
        file->n_regions += !seen[region[i]];
        seen[region[i]] = 1;
    }
    pl_free(seen);
    return PLANISH_OK;
}

static int read_model(planish_file *file, planish_error *error) {
    const io_bytes *input = &file->model.input;
    if (is_gzip(input))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is compressed; unpack it first: gunzip -c %s > OUT", input->path,
                       input->path);
    if (is_utf16(input))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is text in UTF-16; convert it first: iconv -f UTF-16 -t UTF-8 %s > OUT",
                       input->path, input->path);
    int status = file->format->read(&file->model, error);
    if (!status)
        status = io_arrays_settle(&file->model, error);
    if (!status)
        status = io_model_finish(&file->model, file->format, error);
    return status ? status : count_regions(file, error);
}

/** A file that is tried. */
typedef struct trial {
    planish_file file; /* its input, and nothing else yet */
    const char *format;
} trial;

/** Do all that opening the file does, and look whether packed coordinates will be found again; for
 *  a child process, which releases nothing. */
static int try_file(void *data, planish_error *error) {
    trial *t = data;
    planish_file *file = &t->file;
    file->model.threads = 1;
    int status = choose_format(file, t->format, error);
    if (!status)
        status = read_model(file, error);
    io_output none = {.fd = -1}; /* nothing differs that would be written */
    if (!status && file->format->amend)
        status =
            file->format->amend(&file->model, io_model_places_read(&file->model), &none, error);
    return status;
}

/** The HDF5 library crashes on some files: whether it does on this one is tried out in a child. */
static int try_isolated(planish_file *file, const char *format, planish_error *error) {
    const io_bytes *input = &file->model.input;
    trial t = {.file = *file, .format = format}; /* in the child nothing is isolated any more */
    if (!io_is_hdf5(input->data, input->size))
        return PLANISH_OK;
    file->model.is_isolated = 1;
    return io_child_run(try_file, &t, input, error);
}

/** Nothing is read again until it is written. */
static void rest(const io_model *model) {
    io_bytes_rest(&model->input);
    for (int i = 0; i < model->n_companions; i++)
        io_bytes_rest(&model->companion[i]);
}

/** The HDF5 library trusts what it has read before, so that its files must not change. */
static int own_hdf5(planish_file *file, planish_error *error) {
    io_bytes *input = &file->model.input;
    return io_is_hdf5(input->data, input->size) ? io_bytes_own(input, error) : PLANISH_OK;
}

static int open_file(const char *path, const planish_open_options *options, int64_t largest_copy,
                     planish_file **out, planish_error *error) {
    planish_file *file = pl_alloc_zero(1, sizeof *file);
    if (!file)
        return pl_fail_memory(error, path);
    file->model.threads = pl_thread_count(options->threads);
    file->model.flatness = options->plane_tolerance;
    file->model.largest_copy = largest_copy;
    int status = io_bytes_open(path, largest_copy, &file->model.input, error);
    if (!status)
        status = own_hdf5(file, error);
    if (!status && options->isolated)
        status = try_isolated(file, options->format, error);
    if (!status)
        status = choose_format(file, options->format, error);
    if (!status)
        status = read_model(file, error);
    rest(&file->model);
    if (status)
        planish_file_close(file);
    else
        *out = file;
    return status;
}

static int open_as_usual(const char *path, const planish_open_options *options,
                         int64_t largest_copy, planish_file **out, planish_error *error) {
    const double largest = 1e-3;
    if (!path || !out)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "path and file must not be NULL");
    if (!(options->plane_tolerance >= 0 && options->plane_tolerance <= largest))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plane_tolerance is %g; give 0 to %g of the diagonal of the bounding box",
                       options->plane_tolerance, largest);
    const pl_outside outside = pl_call_enter(NULL);
    const int status = open_file(path, options, largest_copy, out, error);
    pl_call_leave(&outside);
    return status;
}

int planish_file_open_with(const char *path, const planish_open_options *options,
                           planish_file **file, planish_error *error) {
    static const planish_open_options usual = {.format = NULL};
    return open_as_usual(path, options ? options : &usual, IO_LARGEST_COPY, file, error);
}

int planish_file_open(const char *path, const char *format, int threads, planish_file **file,
                      planish_error *error) {
    const planish_open_options options = {.format = format, .threads = threads};
    return open_as_usual(path, &options, IO_LARGEST_COPY, file, error);
}

int planish_file_open_isolated(const char *path, const char *format, int threads,
                               planish_file **file, planish_error *error) {
    const planish_open_options options = {.format = format, .threads = threads, .isolated = 1};
    return open_as_usual(path, &options, IO_LARGEST_COPY, file, error);
}

int io_file_open(const char *path, int threads, int64_t largest_copy, planish_file **file,
                 planish_error *error) {
    const planish_open_options options = {.threads = threads};
    return open_as_usual(path, &options, largest_copy, file, error);
}

int io_file_from_memory(const io_format *format, const char *path, const char *data, int64_t size,
                        int threads, planish_file **out, planish_error *error) {
    planish_file *file = pl_alloc_zero(1, sizeof *file);
    if (!file)
        return pl_fail_memory(error, path);
    file->model.threads = threads;
    file->model.largest_copy = IO_LARGEST_COPY;
    file->format = format;
    int status = io_bytes_borrow(path, data, size, &file->model.input, error);
    if (!status)
        status = read_model(file, error);
    if (status)
        planish_file_close(file);
    else
        *out = file;
    return status;
}

void planish_file_close(planish_file *file) {
    if (!file)
        return;
    if (file->format && file->format->release)
        file->format->release(&file->model);
    io_model_destroy(&file->model);
    pl_free(file);
}

/* ---- questions ---------------------------------------------------------------------------- */

static double round_to_field(double value, void *user) {
    const io_model *model = user;
    return io_round_to_field(value, model->field_width, model->implied_exponent);
}

/** Coordinates in a tilted plane are none of those in the file. */
static planish_precision precision_of(const io_model *model) {
    return model->dim == 2 && model->plane.is_tilted ? PLANISH_DOUBLE : model->precision;
}

/** Whether the last line of a text has no end. */
static int ends_open(const io_bytes *bytes) {
    const char last = bytes->data[bytes->size - 1];
    return last != '\n' && last != '\r';
}

const char *planish_file_open_end(const planish_file *file) {
    if (!file || !file->format->has_no_end || !file->model.text_offset)
        return NULL;
    const io_model *model = &file->model;
    if (ends_open(&model->input))
        return model->input.path;
    for (int i = 0; i < model->n_read; i++)
        if (ends_open(&model->companion[i]))
            return model->companion[i].path;
    return NULL;
}

void planish_file_get_info(const planish_file *file, planish_file_info *info) {
    if (!info)
        return;
    *info = (planish_file_info){.format = ""};
    if (!file)
        return;
    *info = (planish_file_info){.format = file->format->name,
                                .precision = precision_of(&file->model),
                                .round = round_to_field,
                                .round_user = (void *)(uintptr_t)&file->model,
                                .n_other_elements = file->model.n_other,
                                .n_lower_elements = file->model.n_lower,
                                .n_regions = file->n_regions,
                                .bytes = file->model.input.size,
                                .ends_open = planish_file_open_end(file) != NULL};
}

planish_mesh planish_file_mesh(const planish_file *file) {
    if (!file)
        return (planish_mesh){.dim = 0};
    const io_cells *cells = io_file_elements(file);
    return (planish_mesh){.dim = file->model.dim,
                          .n_nodes = file->model.n_nodes,
                          .n_elements = cells->n,
                          .coordinates = file->model.coordinates,
                          .elements = cells->nodes,
                          .constraint = NULL,
                          .n_periodic = file->model.n_periodic,
                          .periodic = file->model.periodic};
}

double *planish_file_coordinates(planish_file *file) {
    return file ? file->model.coordinates : NULL;
}

int64_t planish_file_element_number(const planish_file *file, int64_t element) {
    if (!file)
        return -1;
    const io_cells *cells = io_file_elements(file);
    return cells->number ? cells->number[element] : cells->first_number + element;
}

int64_t planish_file_node_number(const planish_file *file, int64_t node) {
    if (!file)
        return -1;
    const io_model *model = &file->model;
    return model->node_number ? model->node_number[node] : model->first_number + node;
}

const char *const *planish_file_cell_arrays(const planish_file *file) {
    static const char *const none[] = {NULL};
    return file && file->model.array_name ? file->model.array_name : none;
}

const char *const *planish_file_region_arrays(const planish_file *file) {
    static const char *const none[] = {NULL};
    return file && file->model.region_name ? file->model.region_name : none;
}

int planish_file_choose_regions(planish_file *file, const char *const *names, int n_names,
                                planish_error *error) {
    int is_whole = file && n_names >= 0 && (names || n_names == 0);
    for (int i = 0; is_whole && i < n_names; i++)
        is_whole = names[i] != NULL;
    if (!is_whole)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file and each of n_names names must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    int status = io_arrays_choose(&file->model, names, n_names, error);
    if (!status)
        status = count_regions(file, error);
    pl_call_leave(&outside);
    return status;
}

int planish_file_can_write(const planish_file *file, const char *path) {
    if (!file || !path)
        return 0;
    const io_format *format = file->format;
    const int is_name = io_format_has_extension(format, path) &&
                        (!format->may_be_called || format->may_be_called(&file->model, path));
    return io_output_is_stream(path) || is_name ||
           strcasecmp(io_extension(path), io_extension(file->model.input.path)) == 0;
}
