/* folder_write: where a mesh that is a folder is written.
 *
 * OUT is a new folder, or the input itself. A new folder is made complete beside its place: the files
 * of the mesh stand in it as they do in the input, copied but for the one with the coordinates. Of the
 * input that one file is replaced.
 */
#include "io/core/bytes.h"
#include "io/core/folder.h"
#include "io/core/gzip.h"
#include "io/file/file.h"
#include "io/file/folder.h"

#include "base/folder.h"
#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- checks --------------------------------------------------------------------------------- */

int io_folder_is_input(const planish_file *file, const char *path) {
    pl_file_status input, output;
    return pl_file_find(file->model.folder, &input) == 0 && pl_file_find(path, &output) == 0 &&
           pl_file_is_same(&input, &output);
}

/** Return whether path names no file: no pipe, device or standard output, no extension of files. */
static int is_name_of_folder(const char *path) {
    char name[PATH_MAX];
    size_t length = strlen(path);
    if (length == 0 || length >= sizeof name)
        return 0;
    memcpy(name, path, length + 1);
    while (length > 1 && pl_path_is_separator(name[length - 1]))
        name[--length] = '\0';
    return strcmp(name, "-") != 0 && !pl_output_is_stream(name) && !io_format_by_extension(name);
}

int io_folder_can_write(const planish_file *file, const char *path) {
    return io_folder_is_input(file, path) || is_name_of_folder(path);
}

typedef struct prefix {
    const char *text;
    char name[256]; /* of an entry that begins with it, or "" */
} prefix;

static int has_prefix(void *user, const char *name) {
    prefix *p = user;
    if (strncmp(name, p->text, strlen(p->text)) != 0)
        return 0;
    snprintf(p->name, sizeof p->name, "%s", name);
    return 1;
}

/** Fail if the input's folder has copies of the coordinates, which would stay as they are beside new
 *  ones. */
static int check_copies(const planish_file *file, planish_error *error) {
    prefix p = {.text = file->format->folder->of_places};
    if (!p.text)
        return PLANISH_OK;
    char *folder = io_folder_path(&file->model, "");
    if (!folder)
        return pl_fail_memory(error, file->model.folder);
    pl_folder_list(folder, has_prefix, &p);
    pl_free(folder);
    if (!p.name[0])
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: %s in it has coordinates, too, which would stay; write to a new folder, or "
                   "remove it and make it again afterwards",
                   file->model.folder, p.name);
}

int io_folder_check(const planish_file *file, const char *path, planish_error *error) {
    if (io_folder_is_input(file, path))
        return check_copies(file, error);
    if (!is_name_of_folder(path))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: is the name of a file; the mesh is a folder: give the name of a new "
                       "folder",
                       path);
    if (pl_file_exists(path))
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: exists already; give the name of a new folder, or %s to replace its "
                       "coordinates",
                       path, file->model.folder);
    return PLANISH_OK;
}

/* ---- writing -------------------------------------------------------------------------------- */

/** Names of entries. */
typedef struct names {
    char **name; /* [n] owned */
    int64_t n, capacity;
    int is_out_of_memory;
} names;

static int note_name(void *user, const char *name) {
    names *l = user;
    char *copy = pl_copy_text(name);
    if (!copy || !pl_append(&l->name, &l->n, &l->capacity, &copy, sizeof copy)) {
        pl_free(copy);
        l->is_out_of_memory = 1;
    }
    return l->is_out_of_memory;
}

static void release_names(names *l) {
    for (int64_t i = 0; i < l->n; i++)
        pl_free(l->name[i]);
    pl_free(l->name);
}

typedef struct writer {
    const planish_file *file;
    const double *coordinates;
    int threads;
    pl_temporaries temporaries;
    pl_folder_output folder;
    planish_error *error;
    char *roots[2]; /* the input's folder, and that of its files within, without links; of malloc */
} writer;

/** Copy the file at path to output. */
static int copy_file(const char *path, pl_output *output, planish_error *error) {
    enum { BLOCK = 1 << 20 };
    char *block = pl_alloc(BLOCK, 1);
    const int fd = block ? pl_file_open(path, PL_FILE_READ) : -1;
    int status = !block   ? pl_fail_memory(error, path)
                 : fd < 0 ? pl_fail_errno(error, path, "cannot be opened")
                          : PLANISH_OK;
    while (!status) {
        const ssize_t got = read(fd, block, BLOCK);
        if (got == 0)
            break;
        if (got > 0)
            status = pl_output_write(output, block, got, error);
        else if (errno != EINTR)
            status = pl_fail_errno(error, path, "cannot be read");
    }
    if (fd >= 0)
        pl_file_close(fd);
    pl_free(block);
    return status;
}

/** Find the bytes of a file of the mesh that has been read; NULL: it has not. */
static const io_bytes *find_companion(const io_model *model, const char *path) {
    for (int i = 0; i < model->n_companions; i++)
        if (strcmp(model->companion[i].path, path) == 0)
            return &model->companion[i];
    return NULL;
}

/** Write a file called name to the folder: from the one at path, or with the coordinates. */
static int write_file(writer *w, const char *name, const char *path) {
    const io_model *model = &w->file->model;
    const io_bytes *companion = find_companion(model, path);
    pl_output output = {.fd = -1};
    int status = pl_folder_file(&w->folder, name, w->temporaries, &output, w->error);
    if (!status && strcmp(path, model->input.path) == 0)
        status = io_write_coordinates(w->file, w->coordinates, w->threads, &output, w->error);
    else if (!status && companion)
        status = pl_output_write(&output, companion->data, companion->size, w->error);
    else if (!status)
        status = copy_file(path, &output, w->error);
    if (!status && output.fd >= 0)
        status = pl_output_finish(&output, w->error);
    pl_output_release(&output, w->temporaries);
    return status;
}

static int write_entries(writer *w, const char *place, const char *inner, int is_mesh);

/** Find the folders that files are copied from. */
static int find_roots(writer *w, const char *place) {
    w->roots[0] = pl_path_resolve(w->file->model.folder);
    w->roots[1] = pl_path_resolve(place);
    return w->roots[0] && w->roots[1] ? PLANISH_OK
                                      : pl_fail_errno(w->error, place, "cannot be read");
}

/** Check that what is at path is in the input's folder: a link may lead to anything else, which nobody
 *  means to hand on with the mesh. What the mesh has been read from may be elsewhere. */
static int check_place(const writer *w, const char *path) {
    const io_model *model = &w->file->model;
    int is_within = strcmp(path, model->input.path) == 0 || find_companion(model, path);
    char *own = is_within ? NULL : pl_path_resolve(path);
    if (!is_within && !own)
        return pl_fail_errno(w->error, path, "cannot be read");
    for (int i = 0; i < 2 && !is_within; i++) {
        const size_t length = strlen(w->roots[i]);
        is_within = strncmp(own, w->roots[i], length) == 0 &&
                    (pl_path_is_separator(own[length]) || pl_path_is_separator(own[length - 1]));
    }
    free(own);
    return is_within ? PLANISH_OK
                     : pl_fail(w->error, PLANISH_ERROR_FILE,
                               "%s: is a link to something elsewhere, which is not copied into the "
                               "new folder; put a copy in its place, or remove it",
                               path);
}

/** Write an entry of a folder, at path, to target: a file that is wanted, or a folder with its files. */
static int write_entry(writer *w, const char *name, const char *path, const char *target,
                       int is_mesh) {
    const io_folder *kind = w->file->format->folder;
    const int is_wanted = !is_mesh || !kind->is_copied || kind->is_copied(name);
    pl_file_status about;
    int is_folder = 0;
    for (const char *const *f = kind->folders; is_mesh && f && *f; f++)
        is_folder |= strcmp(name, *f) == 0;
    if (!is_wanted && !is_folder)
        return PLANISH_OK;
    if (pl_file_find(path, &about)) /* a link may lead nowhere */
        return errno == ENOENT ? PLANISH_OK : pl_fail_errno(w->error, path, "cannot be read");
    const int is_file = is_wanted && about.kind == PL_FILE_REGULAR;
    if (!is_file && (!is_folder || about.kind != PL_FILE_FOLDER))
        return PLANISH_OK;
    int status = check_place(w, path);
    if (status || is_file)
        return status ? status : write_file(w, target, path);
    status = pl_folder_add(&w->folder, target, w->temporaries, w->error);
    return status ? status : write_entries(w, path, target, 0);
}

/** Write what is in the folder at place, to where it is to be in the new one. is_mesh: it is the
 *  folder of the mesh; else one that is copied along. */
static int write_entries(writer *w, const char *place, const char *inner, int is_mesh) {
    names list = {.n = 0};
    int status = PLANISH_OK;
    if (pl_folder_list(place, note_name, &list))
        status = pl_fail_errno(w->error, place, "cannot be read");
    if (list.is_out_of_memory)
        status = pl_fail_memory(w->error, place);
    for (int64_t i = 0; i < list.n && !status; i++) {
        const char *name = list.name[i];
        const size_t size = strlen(place) + strlen(inner) + strlen(name) + 2;
        char *path = pl_alloc((int64_t)size, 1), *target = pl_alloc((int64_t)size, 1);
        if (path && target) {
            snprintf(path, size, "%s/%s", place, name);
            snprintf(target, size, "%s%s%s", inner, *inner ? "/" : "", name);
            status = write_entry(w, name, path, target, is_mesh);
        } else {
            status = pl_fail_memory(w->error, place);
        }
        pl_free(path);
        pl_free(target);
    }
    release_names(&list);
    return status;
}

/** Make the folders within which the mesh has its files: those of model->inner. */
static int make_inner_folders(writer *w) {
    char *inner = pl_copy_text(w->file->model.inner);
    int status = inner ? PLANISH_OK : pl_fail_memory(w->error, w->folder.target);
    for (char *at = inner; !status && at && *at;) {
        char *separator = strchr(at, '/');
        if (separator)
            *separator = '\0';
        status = pl_folder_add(&w->folder, inner, w->temporaries, w->error);
        if (separator)
            *separator = '/';
        at = separator ? separator + 1 : NULL;
    }
    pl_free(inner);
    return status;
}

int io_folder_write(const planish_file *file, const char *path, const double *coordinates,
                    int threads, pl_temporaries temporaries, planish_error *error) {
    const io_model *model = &file->model;
    writer w = {file, coordinates, threads, temporaries, {.n = 0}, error, {NULL, NULL}};
    char *target = io_folder_trim(path), *place = io_folder_path(model, "");
    planish_error changed;
    int status =
        target && place ? io_check_inputs_unchanged(file, error) : pl_fail_memory(error, path);
    if (!status)
        status = pl_folder_begin(target, temporaries, &w.folder, error);
    if (!status)
        status = make_inner_folders(&w);
    if (!status) {
        place[strlen(place) - 1] = '\0'; /* the separator at its end */
        status = find_roots(&w, place);
    }
    if (!status) {
        status = write_entries(&w, place, model->inner, 1);
    }
    /* A failure that comes of an input that changed is better told so. */
    if (target && place && io_check_inputs_unchanged(file, &changed)) {
        status = changed.code;
        if (error)
            *error = changed;
    }
    if (!status)
        status = pl_folder_commit(&w.folder, temporaries, error);
    pl_folder_release(&w.folder, temporaries);
    for (int i = 0; i < 2; i++)
        free(w.roots[i]);
    pl_free(target);
    pl_free(place);
    return status;
}
