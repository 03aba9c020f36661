/* folder: files of a mesh that is a folder, for its reader. */
#include "io/core/folder.h"

#include "io/core/bytes.h"
#include "io/core/gzip.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

char *io_folder_path(const io_model *model, const char *name) {
    const size_t size = strlen(model->folder) + strlen(model->inner) + strlen(name) + 3;
    char *path = pl_alloc((int64_t)size, 1);
    if (path)
        snprintf(path, size, "%s/%s%s%s", model->folder, model->inner, *model->inner ? "/" : "",
                 name);
    return path;
}

/** Find the path of the file called name, or of NAME.gz: *path is owned; NULL: there is neither. */
static int find_path(const io_model *model, const char *name, int may_be_packed, char **path,
                     planish_error *error) {
    const int n = may_be_packed ? 2 : 1;
    char packed[64];
    snprintf(packed, sizeof packed, "%s.gz", name);
    for (int i = 0; i < n; i++) {
        *path = io_folder_path(model, i ? packed : name);
        if (!*path)
            return pl_fail_memory(error, name);
        pl_file_status about;
        if (pl_file_find(*path, &about) == 0)
            return PLANISH_OK;
        const int status =
            errno == ENOENT ? PLANISH_OK : pl_fail_errno(error, *path, "cannot be read");
        pl_free(*path);
        if (status)
            return status;
        *path = NULL;
    }
    return PLANISH_OK;
}

int io_folder_open(io_model *model, const char *name, int may_be_packed, int needed,
                   io_folder_file *file, planish_error *error) {
    *file = (io_folder_file){.view = {.threads = io_model_threads(model)}};
    if (!model->companion)
        model->companion = pl_alloc(IO_FOLDER_FILES, sizeof *model->companion);
    if (!model->companion)
        return pl_fail_memory(error, name);
    char *path;
    int status = find_path(model, name, may_be_packed, &path, error);
    if (status)
        return status;
    if (!path && needed)
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: there is no file %s beside it",
                       model->input.path, name);
    if (!path)
        return PLANISH_OK;
    io_bytes *bytes = &model->companion[model->n_companions];
    status = io_bytes_open_beside(path, model->largest_copy, bytes, error);
    pl_free(path);
    if (status == PLANISH_ERROR_FORMAT && !needed)
        return PLANISH_OK;
    if (status)
        return status;
    model->n_read = ++model->n_companions;
    file->view.input = *bytes;
    const char *behind = strrchr(pl_path_name(bytes->path), '.');
    const int is_packed = behind && strcmp(behind, ".gz") == 0;
    if (is_packed)
        status = io_gunzip(bytes, &file->view.input, error);
    file->is_unpacked = is_packed && !status;
    return status;
}

void io_folder_close(io_folder_file *file) {
    if (file->is_unpacked)
        io_bytes_close(&file->view.input);
    *file = (io_folder_file){.is_unpacked = 0};
}
