/* xdmf: XDMF files: an XML file, whose numbers stand in it or in files of HDF5 or bytes beside it.
 *
 * The file with the coordinates is the model's input: the XML file itself, or another one, which that
 * names as its document. Files are read that stand beside the XML or below its folder.
 */
#include "io/xdmf/xdmf.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"
#include "io/core/include.h"

#include <string.h>
#include <strings.h>

/* ---- names of files ------------------------------------------------------------------------- */

/** Take each DataItem that names a file, in the file's order. */
typedef int take_name(xdmf_reader *r, const xdmf_item *item, void *user);

static int for_all_names(xdmf_reader *r, take_name *take, void *user) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->document.n && !status; i++) {
        xdmf_item item;
        if (!xdmf_is(&r->document, i, "DataItem") || xdmf_attribute(&r->document, i, "Reference"))
            continue;
        status = xdmf_item_of(r, i, &item);
        if (status == PLANISH_ERROR_FORMAT) /* what cannot be read names nothing */
            status = PLANISH_OK;
        else if (!status && item.form != XDMF_TEXT)
            status = take(r, &item, user);
    }
    return status;
}

enum { MOST_FILES = 16384 };

static int is_name(const char *name, io_slice slice) {
    return io_include_compare((io_slice){name, name + strlen(name)}, slice) == 0;
}

/** Find a name among those of files, which are sorted behind that of the input. Return its place, or that
 *  of the first one behind it. */
static int64_t find_name(const io_model *model, io_slice name) {
    int64_t low = model->document.data && model->n_beside > 0, high = model->n_beside;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        const char *there = model->beside[middle];
        if (io_include_compare((io_slice){there, there + strlen(there)}, name) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/** Note the name of a file, and where the document names the input. */
static int note_name(xdmf_reader *r, const xdmf_item *item, void *user) {
    io_model *model = r->model;
    const char *data = r->document.view.input.data;
    (void)user;
    if (model->document.data && model->n_beside > 0 && is_name(model->beside[0], item->file)) {
        const io_edit place = {item->file.begin - data, item->file.end - data, NULL, 0};
        return io_edits_add(&model->input_names, place, r->error);
    }
    const int64_t at = find_name(model, item->file);
    if (at < model->n_beside && is_name(model->beside[at], item->file))
        return PLANISH_OK;
    if (model->n_beside == MOST_FILES)
        return xdmf_fail(&r->document, item->element, "more than %d files are named", MOST_FILES);
    char *path;
    const int status = io_include_find(&r->document.view, item->file, &path, r->error);
    if (status || !path) /* it is not copied along */
        return status;
    const int64_t n = io_slice_length(item->file);
    char *name = path + strlen(path) - n;
    memmove(path, name, (size_t)n + 1);
    if (!pl_append(&model->beside, &model->n_beside, &model->beside_capacity, &path, sizeof path)) {
        pl_free(path);
        return pl_fail_memory(r->error, "the names of files");
    }
    memmove(model->beside + at + 1, model->beside + at,
            (size_t)(model->n_beside - 1 - at) * sizeof path);
    model->beside[at] = path;
    return PLANISH_OK;
}

/** Note the files that the XML names, that of the coordinates first. */
static int note_names(xdmf_reader *r, const xdmf_mesh *mesh) {
    const xdmf_item *item = &mesh->geometry[0].item[0];
    int status = r->model->document.data ? note_name(r, item, NULL) : PLANISH_OK;
    if (!status)
        status = for_all_names(r, note_name, NULL);
    if (!status && r->error)
        *r->error = (planish_error){.code = PLANISH_OK};
    return status;
}

/* ---- the format ----------------------------------------------------------------------------- */

static int xdmf_read(io_model *model, planish_error *error) {
    xdmf_reader r;
    xdmf_mesh mesh = {0};
    int status = xdmf_begin(model, &r, error);
    if (!status)
        status = xdmf_mesh_find(&r, &mesh);
    if (!status)
        status = xdmf_read_nodes(&r, &mesh);
    if (!status)
        status = xdmf_read_cells(&r, &mesh);
    if (!status)
        status = xdmf_read_attributes(&r, &mesh);
    if (!status)
        status = note_names(&r, &mesh);
    xdmf_mesh_release(&mesh);
    return xdmf_close(&r, status);
}

/** Bytes of the files of HDF5, of which the last is known by its name. */
typedef struct hdf5_sum {
    io_slice last;
    int64_t bytes;
} hdf5_sum;

static int add_hdf5(xdmf_reader *r, const xdmf_item *item, void *user) {
    hdf5_sum *sum = user;
    pl_file_status about;
    if (item->form != XDMF_HDF5 || io_include_compare(sum->last, item->file) == 0)
        return PLANISH_OK;
    char *path;
    const int status = io_include_find(&r->document.view, item->file, &path, r->error);
    if (path && pl_file_find(path, &about) == 0 && about.size < INT64_MAX / 4 - sum->bytes)
        sum->bytes += about.size;
    pl_free(path);
    sum->last = item->file;
    return status;
}

static int64_t xdmf_hdf5_bytes(const io_model *model) {
    xdmf_reader r;
    hdf5_sum sum = {{NULL, NULL}, 0};
    planish_error ignored;
    io_model opened = *model;
    if (!xdmf_begin(&opened, &r, &ignored))
        for_all_names(&r, add_hdf5, &sum);
    xdmf_close(&r, PLANISH_OK);
    return sum.bytes;
}

static int xdmf_recognise(const char *data, int64_t size) {
    enum { LOOKED_AT = 4096 };
    static const char mark[] = "<Xdmf";
    const int64_t length = (int64_t)sizeof mark - 1, most = size < LOOKED_AT ? size : LOOKED_AT;
    for (int64_t i = 0; i + length <= most; i++)
        if (data[i] == '<' && strncasecmp(data + i, mark, (size_t)length) == 0)
            return 1;
    return 0;
}

static const char *const extensions[] = {".xdmf", ".xmf", ".xdmf2", ".xdmf3", NULL};

const io_format io_format_xdmf = {.name = "xdmf",
                                  .extensions = extensions,
                                  .recognise = xdmf_recognise,
                                  .read = xdmf_read,
                                  .hdf5_bytes = xdmf_hdf5_bytes,
#ifdef PL_HDF5
                                  .amend = io_hdf5_amend,
                                  .release = io_hdf5_release,
#endif
                                  .read_data = xdmf_read_data};
