/* file: open a mesh file of any format, and what can be asked of it. */
#include "io/file/file.h"

#include "io/file/folder.h"

#include "io/core/arrays.h"
#include "io/core/bytes.h"
#include "io/core/cell_types.h"
#include "io/core/child.h"
#include "io/core/data.h"
#include "io/core/gzip.h"
#include "io/core/number.h"
#include "io/file/plane.h"
#include "io/file/tags.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

static const char *const no_names[] = {NULL};

/* ---- opening ------------------------------------------------------------------------------ */

/** Refuse bytes that no reader takes, whatever the format is called. */
static int refuse_others(const io_bytes *input, planish_error *error) {
    const char *path = input->path;
    if (io_is_gzip(input->data, input->size))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is compressed; unpack it first: gunzip -c %s > OUT", path, path);
    /* Text of two bytes a letter begins with their order. */
    if (input->size > 2 &&
        (memcmp(input->data, "\xff\xfe", 2) == 0 || memcmp(input->data, "\xfe\xff", 2) == 0))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is text in UTF-16; convert it first: iconv -f UTF-16 -t UTF-8 %s > OUT",
                       path, path);
    return PLANISH_OK;
}

/** Choose the format called name, or that of content and extension. */
static int choose_format(planish_file *file, const char *name, planish_error *error) {
    const io_bytes *input = &file->model.input;
    const char *path = input->path;
    const int status = refuse_others(input, error);
    if (status)
        return status;
    file->format = name ? io_format_by_name(name) : io_format_find(path, input->data, input->size);
    if (file->format)
        return PLANISH_OK;
    char names[256] = "";
    size_t length = 0;
    for (const char *const *n = planish_file_formats(); *n && length < sizeof names; n++)
        length +=
            (size_t)snprintf(names + length, sizeof names - length, "%s%s", length ? ", " : "", *n);
    if (name)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "unknown format '%s'; there are %s", name,
                       names);
    if (io_is_hdf5(input->data, input->size))
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is an HDF5 file of an unknown format; planish reads CGNS, MED, VTKHDF, "
                       "DMPlex (PETSc) and Exodus",
                       path);
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: neither content nor extension is of a known mesh format; there are %s "
                   "(docs/formats.md)",
                   path, names);
}

/* ---- elements ------------------------------------------------------------------------------ */

/** Set the type of simplex i, and its nodes at node; return their number. It is straight where all
 *  mids are missing. */
static int take_element(const io_cells *elements, int dim, int64_t i, uint8_t *type,
                        int32_t *node) {
    static const uint8_t types[][2] = {{PLANISH_CELL_TRIANGLE, PLANISH_CELL_TRIANGLE6},
                                       {PLANISH_CELL_TETRAHEDRON, PLANISH_CELL_TETRAHEDRON10}};
    const int n_mids = io_n_mids(dim), corners = dim + 1;
    int has_mids = 0;
    for (int k = 0; elements->mid && k < n_mids; k++) {
        node[corners + k] = elements->mid[i * n_mids + k];
        has_mids |= node[corners + k] >= 0;
    }
    memcpy(node, elements->nodes + i * corners, (size_t)corners * sizeof *node);
    *type = types[dim - 2][has_mids];
    return corners + (has_mids ? n_mids : 0);
}

/** Make the arrays of file->cells: simplices, then others. Others alone are these already. */
static int make_cells(planish_file *file, planish_error *error) {
    const io_cells *elements = io_model_elements(&file->model);
    const io_others *others = io_model_other_elements(&file->model);
    const int dim = io_model_dim(&file->model);
    const int64_t n = elements->n + others->n;
    if (elements->n == 0) {
        file->cells = (planish_cells){
            .n = n, .type = others->type, .offset = others->offset, .node = others->node};
        return PLANISH_OK;
    }
    const int64_t most = dim + 1 + (elements->mid ? io_n_mids(dim) : 0);
    uint8_t *type = pl_alloc(n, sizeof *type);
    int64_t *offset = pl_alloc(n + 1, sizeof *offset), n_own = 0;
    int32_t *node = pl_alloc(elements->n * most + others->n_nodes, sizeof *node);
    file->cells = (planish_cells){.n = n, .type = type, .offset = offset, .node = node};
    if (!type || !offset || !node)
        return pl_fail_memory(error, "elements");
    offset[0] = 0;
    for (int64_t i = 0; i < elements->n; i++)
        offset[i + 1] = n_own += take_element(elements, dim, i, &type[i], node + n_own);
    for (int64_t i = 0; i < others->n; i++) {
        type[elements->n + i] = others->type[i];
        offset[elements->n + i + 1] = n_own + others->offset[i + 1];
    }
    if (others->n > 0)
        memcpy(node + n_own, others->node, (size_t)others->n_nodes * sizeof *node);
    return PLANISH_OK;
}

static void release_cells(planish_file *file) {
    if (file->cells.type != io_model_other_elements(&file->model)->type) {
        pl_free((void *)(uintptr_t)file->cells.type);
        pl_free((void *)(uintptr_t)file->cells.offset);
        pl_free((void *)(uintptr_t)file->cells.node);
    }
    file->cells = (planish_cells){.n = 0};
}

/* ---- regions and facets --------------------------------------------------------------------- */

static void release_joined(planish_file *file) {
    pl_free(file->region);
    pl_free(file->facet);
    pl_free(file->facet_offset);
    pl_free(file->facet_tag);
    file->region = file->facet = file->facet_tag = NULL;
    file->facet_offset = NULL;
}

/** Put the regions of the first n cells and those of the first m others one after the other: *joined,
 *  which stays NULL if these have none. */
static int join_regions(const io_cells *cells, int64_t n, const io_others *others, int64_t m,
                        int32_t **joined, planish_error *error) {
    const int32_t *a = io_cells_regions(cells);
    const int32_t *b = others->region ? others->region : others->entity;
    if (!b)
        return PLANISH_OK;
    *joined = pl_alloc_zero(n + m, sizeof **joined);
    if (!*joined)
        return pl_fail_memory(error, "the regions of elements");
    if (a && n > 0)
        memcpy(*joined, a, (size_t)n * sizeof **joined);
    if (m > 0)
        memcpy(*joined + n, b, (size_t)m * sizeof **joined);
    return PLANISH_OK;
}

/** Put triangles and quadrilaterals that are facets one after the other. */
static int join_facets(planish_file *file, planish_error *error) {
    const io_cells *triangles = &file->model.triangle;
    const io_others *others = &file->model.flat;
    const int64_t n = io_cells_telling(triangles), m = io_others_telling(others);
    int64_t *offset = file->facet_offset = pl_alloc(n + m + 1, sizeof *offset);
    int32_t *node = file->facet = pl_alloc(3 * n + 4 * m, sizeof *node);
    if (!offset || !node)
        return pl_fail_memory(error, "the facets of the file");
    if (n > 0)
        memcpy(node, triangles->nodes, (size_t)(3 * n) * sizeof *node);
    for (int64_t i = 0; i <= n + m; i++)
        offset[i] = i <= n ? 3 * i : 4 * i - n;
    for (int64_t i = 0; i < m; i++)
        memcpy(node + offset[n + i], others->node + others->offset[i], 4 * sizeof *node);
    return join_regions(triangles, n, others, m, &file->facet_tag, error);
}

/** Join what is of simplices and of others, and count the distinct regions of the elements:
 *  file->n_regions. */
static int find_regions(planish_file *file, planish_error *error) {
    const io_model *model = &file->model;
    const io_cells *cells = io_model_elements(model);
    const io_others *others = io_model_other_elements(model);
    int32_t last = 0;
    int status = PLANISH_OK;
    release_joined(file);
    if (others->n > 0)
        status = join_regions(cells, cells->n, others, others->n, &file->region, error);
    if (!status && io_model_dim(model) == 3 && model->flat.n > 0)
        status = join_facets(file, error);
    const int32_t *region = io_file_regions(file);
    const int64_t n = io_model_n_elements(model);
    file->n_regions = region ? 0 : 1;
    if (status || !region)
        return status;
    for (int64_t i = 0; i < n; i++)
        last = region[i] > last ? region[i] : last;
    uint8_t *seen = pl_alloc_zero((int64_t)last + 1, 1);
    if (!seen)
        return pl_fail_memory(error, file->model.input.path);
    for (int64_t i = 0; i < n; i++) {
        file->n_regions += !seen[region[i]];
        seen[region[i]] = 1;
    }
    pl_free(seen);
    return PLANISH_OK;
}

static int read_model(planish_file *file, planish_error *error) {
    if (!file->format->read)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: this planish was built without HDF5, which %s files need: install "
                       "libhdf5-dev and build again",
                       file->model.input.path, file->format->name);
    int status = file->format->read(&file->model, error);
    io_numbers_destroy(file->model.numbers);
    file->model.numbers = NULL;
    const int has_others = io_model_other_elements(&file->model)->n > 0;
    if (!status && (has_others || io_model_elements(&file->model)->mid))
        status = make_cells(file, error);
    if (!status)
        status = io_arrays_find_regions(&file->model, has_others ? &file->cells : NULL, error);
    if (!status)
        status = io_model_finish(&file->model, file->format, error);
    if (!status && io_model_is_surface(&file->model) && !file->cells.offset)
        status = make_cells(file, error);
    if (!status)
        status = find_regions(file, error);
    return status ? status : io_tags_make(file, error);
}

/* ---- opening -------------------------------------------------------------------------------- */

/** A file that is tried. */
typedef struct trial {
    planish_file file; /* its input, and nothing else yet */
    const char *format;
} trial;

/** Read an array, which is read later in the process itself. */
static void try_data(planish_file *file, const io_data *data) {
    io_model *model = &file->model;
    planish_error ignored;
    const int64_t n = data->of_elements ? io_model_n_elements(model) : model->n_nodes;
    double *values =
        data->width <= IO_MOST_WIDTH ? pl_alloc(n * data->width, sizeof *values) : NULL;
    if (values)
        file->format->read_data(model, data, values, &ignored);
    pl_free(values);
}

/** Do all that opening the file does, and look whether packed coordinates will be found again; for
 *  a child process, which releases nothing. */
static int try_file(void *data, planish_error *error) {
    trial *t = data;
    planish_file *file = &t->file;
    file->model.threads = 1;
    int status = file->format ? PLANISH_OK : choose_format(file, t->format, error);
    if (!status)
        status = read_model(file, error);
    pl_output none = {.fd = -1}; /* nothing differs that would be written */
    if (!status && file->format->amend)
        status = file->format->amend(&file->model, io_written_as_read(&file->model), &none, error);
    for (int64_t i = 0; i < file->model.n_data && !status && file->format->hdf5_bytes; i++)
        try_data(file, &file->model.data[i]);
    return status;
}

/** Try the file in a child, in which nothing is isolated any more. size: bytes that are read. */
static int try_in_child(planish_file *file, int64_t size, const planish_open_options *options,
                        planish_error *error) {
    trial t = {.file = *file, .format = options->format};
    io_bytes read = file->model.input;
    read.size = size;
    file->model.is_isolated = options->isolated;
    return options->isolated ? io_child_run(try_file, &t, &read, error) : PLANISH_OK;
}

/** Open path, whose options are in order, as file, which is closed on failure by the caller. */
static int open_file(planish_file *file, const char *path, const planish_open_options *options,
                     planish_error *error) {
    io_model *model = &file->model;
    const int is_folder = io_folder_is(path);
    int status = is_folder ? io_folder_find_mesh(file, path, options->format, error)
                           : io_bytes_open(path, model->largest_copy, &model->input, error);
    if (!status && !is_folder && io_is_hdf5(model->input.data, model->input.size)) {
        /* The HDF5 library trusts what it has read before, so that its files must not change. And
         * it crashes on some files: whether it does on this one is tried out in a child. */
        status = io_bytes_own(&model->input, error);
        if (!status)
            status = try_in_child(file, model->input.size, options, error);
    }
    if (!status && !is_folder)
        status = choose_format(file, options->format, error);
    const int64_t beside =
        !status && file->format->hdf5_bytes ? file->format->hdf5_bytes(model) : 0;
    if (beside > 0)
        status = try_in_child(file, model->input.size + beside, options, error);
    if (!status)
        status = read_model(file, error);
    io_bytes_rest(&model->input); /* nothing is read again until it is written */
    for (int i = 0; i < model->n_companions; i++)
        io_bytes_rest(&model->companion[i]);
    return status;
}

static int open_as_usual(const char *path, const planish_open_options *options,
                         int64_t largest_copy, planish_file **out, planish_error *error) {
    const double largest = 1e-3;
    if (out)
        *out = NULL;
    if (!path || !out)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "path and file must not be NULL");
    if (!(options->plane_tolerance >= 0 && options->plane_tolerance <= largest))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "plane_tolerance is %g; give 0 to %g of the diagonal of the bounding box",
                       options->plane_tolerance, largest);
    int status = pl_check_reserved("planish_open_options", options->reserved,
                                   sizeof options->reserved, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    planish_file *file = pl_alloc_zero(1, sizeof *file);
    status = file ? PLANISH_OK : pl_fail_memory(error, path);
    if (!status) {
        io_model_set_threads(&file->model, pl_thread_count(options->threads));
        file->model.flatness = options->plane_tolerance;
        file->model.largest_copy = largest_copy;
        status = open_file(file, path, options, error);
    }
    if (status)
        planish_file_close(file);
    else
        *out = file;
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
    io_model_set_threads(&file->model, threads);
    file->model.largest_copy = IO_LARGEST_COPY;
    file->format = format;
    int status = io_bytes_borrow(path, data, size, &file->model.input, error);
    if (!status)
        status = refuse_others(&file->model.input, error);
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
    release_cells(file);
    release_joined(file);
    io_file_free_groups(file);
    io_tags_free(file);
    io_model_destroy(&file->model);
    pl_free(file);
}

const char *planish_io_version(void) {
    return PLANISH_VERSION;
}

/* ---- questions ---------------------------------------------------------------------------- */

static double round_as_stored(double value, void *user) {
    return io_stored(user, value);
}

/** Return whether the last line of a text has no end. */
static int is_unterminated(const io_bytes *bytes) {
    const char last = bytes->data[bytes->size - 1];
    return last != '\n' && last != '\r';
}

const char *planish_file_unterminated_path(const planish_file *file) {
    if (!file || !file->format->has_no_end || !file->model.text_offset)
        return NULL;
    const io_model *model = &file->model;
    if (is_unterminated(&model->input))
        return model->input.path;
    for (int i = 0; i < model->n_read; i++)
        if (is_unterminated(&model->companion[i]))
            return model->companion[i].path;
    return NULL;
}

const char *const *planish_file_supported_groups(const planish_file *file) {
    return file ? io_names_list(&file->model.supported_group) : no_names;
}

const char *const *planish_file_included(const planish_file *file) {
    return file ? io_names_list(&file->model.included_name) : no_names;
}

/** Count the elements whose nodes do not move for their type. */
static int64_t count_held(const planish_file *file) {
    const io_others *others = io_model_other_elements(&file->model);
    int64_t n = 0;
    for (int64_t i = 0; i < others->n; i++)
        n += !io_cell_type_is_smoothed(others->type[i]);
    return n;
}

void planish_file_get_info(const planish_file *file, planish_file_info *info) {
    if (!info)
        return;
    *info = (planish_file_info){.format = ""};
    if (!file)
        return;
    const io_model *model = &file->model;
    /* Coordinates in a tilted plane are none of those in the file. */
    const int is_tilted = model->dim == 2 && model->plane.is_tilted;
    *info =
        (planish_file_info){.format = file->format->name,
                            .precision = is_tilted ? PLANISH_PRECISION_DOUBLE : model->precision,
                            .round = round_as_stored,
                            .round_user = (void *)(uintptr_t)model,
                            .n_other_elements = model->n_other + count_held(file),
                            .n_lower_elements = model->n_lower,
                            .n_regions = file->n_regions,
                            .bytes = model->input.size,
                            .is_unterminated = planish_file_unterminated_path(file) != NULL,
                            .has_normals = model->has_normals,
                            .off_plane = io_model_is_surface(model) && model->plane.size > 0
                                             ? model->plane.off / model->plane.size
                                             : 0};
}

planish_mesh planish_file_mesh(const planish_file *file) {
    if (!file)
        return (planish_mesh){.dim = 0};
    const io_model *model = &file->model;
    const int is_surface = io_model_is_surface(model);
    const int is_plain =
        !is_surface && !io_model_elements(model)->mid && io_model_other_elements(model)->n == 0;
    return (planish_mesh){.dim = model->dim,
                          .n_nodes = model->n_nodes,
                          .n_elements = io_model_n_elements(model),
                          .coordinates = model->coordinates,
                          .elements = is_plain ? io_model_elements(model)->nodes : NULL,
                          .cells = is_plain ? NULL : &file->cells,
                          .constraint = NULL,
                          .n_periodic = is_surface ? 0 : model->n_periodic,
                          .periodic = is_surface ? NULL : model->periodic};
}

int planish_file_cells(planish_file *file, planish_cells *cells, planish_error *error) {
    if (!file || !cells)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and cells must not be NULL");
    if (!file->cells.offset) {
        const int status = make_cells(file, error);
        if (status) {
            release_cells(file);
            return status;
        }
    }
    *cells = file->cells;
    return PLANISH_OK;
}

double *planish_file_coordinates(planish_file *file) {
    return file ? file->model.coordinates : NULL;
}

int64_t planish_file_element_number(const planish_file *file, int64_t element) {
    return file ? io_element_number(&file->model, element) : -1;
}

int64_t planish_file_node_number(const planish_file *file, int64_t node) {
    return file ? io_node_number(&file->model, node) : -1;
}

const char *const *planish_file_cell_arrays(const planish_file *file) {
    return file && file->model.array_name ? file->model.array_name : no_names;
}

const char *const *planish_file_region_arrays(const planish_file *file) {
    return file && file->model.region_name ? file->model.region_name : no_names;
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
    if (!status && n_names > 0) {
        io_file_free_groups(file); /* as they were listed before */
        status = io_model_hold_again(&file->model, error);
    }
    if (!status)
        status = find_regions(file, error);
    pl_call_leave(&outside);
    return status;
}
