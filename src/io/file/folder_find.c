/* folder_find: which mesh is in a folder.
 *
 * Formats say where their files may be (io_folder). All places are looked at: a folder that has
 * several meshes is refused, as nobody but the user knows which one is meant.
 */
#include "io/core/bytes.h"
#include "io/core/folder.h"
#include "io/core/gzip.h"
#include "io/file/file.h"
#include "io/file/folder.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const io_format *const folders[] = {&io_format_elmer, &io_format_foam};
enum { N_FOLDERS = sizeof folders / sizeof *folders };

/** A mesh in a folder. */
typedef struct found {
    const io_format *format;
    char *inner; /* owned */
} found;

typedef struct finder {
    const char *path;        /* of the folder */
    const io_format *format; /* that is looked at, and */
    const char *place;       /* one of its places */
    found *mesh;             /* [n] owned */
    int64_t n, capacity;
    const io_format *partial; /* has some of its files, but not */
    const char *missing;      /* this one, in the folder */
    char partial_inner[128];  /* behind the path */
    int is_out_of_memory;
    int reason; /* errno of a folder that cannot be listed, or 0 */
} finder;

/* ---- paths ---------------------------------------------------------------------------------- */

int io_folder_is(const char *path) {
    pl_file_status status;
    return pl_file_find(path, &status) == 0 && status.kind == PL_FILE_FOLDER;
}

char *io_folder_trim(const char *path) {
    char *text = pl_copy_text(path);
    size_t length = text ? strlen(text) : 0;
    while (length > 1 && pl_path_is_separator(text[length - 1]))
        text[--length] = '\0';
    return text;
}

/** Join a, b and c by separators, those that are not empty. Owned; NULL without memory. */
static char *join(const char *a, const char *b, const char *c) {
    const size_t size = strlen(a) + strlen(b) + strlen(c) + 3;
    char *path = pl_alloc((int64_t)size, 1);
    if (path)
        snprintf(path, size, "%s%s%s%s%s", a, *a && *b ? "/" : "", b, *c && (*a || *b) ? "/" : "",
                 c);
    return path;
}

/* ---- looking for meshes --------------------------------------------------------------------- */

/** Return whether a file of the format, or the packed one in its place, is in a folder. */
static int has_file(finder *f, const char *place, const char *name) {
    const io_folder *folder = f->format->folder;
    char packed[64];
    snprintf(packed, sizeof packed, "%s.gz", name);
    char *path = join(place, name, ""), *packed_path = join(place, packed, "");
    const int is_there = (path && pl_file_exists(path)) ||
                         (folder->may_be_packed && packed_path && pl_file_exists(packed_path));
    f->is_out_of_memory |= !path || !packed_path;
    pl_free(path);
    pl_free(packed_path);
    return is_there;
}

/** Note the mesh of the format that is in the inner folder, if all of its files are. */
static void look_at(finder *f, const char *inner) {
    const io_folder *folder = f->format->folder;
    char *place = join(f->path, inner, "");
    const char *missing = NULL;
    f->is_out_of_memory |= !place;
    int n = 0;
    for (const char *const *name = folder->files; place && *name; name++) {
        const int is_there = has_file(f, place, *name);
        missing = is_there || missing ? missing : *name;
        n += is_there;
    }
    pl_free(place);
    if (f->is_out_of_memory)
        return;
    if (missing && n > 0 && !f->partial) {
        f->partial = f->format;
        f->missing = missing;
        snprintf(f->partial_inner, sizeof f->partial_inner, "%s%s", *inner ? "/" : "", inner);
    }
    if (missing)
        return;
    found mesh = {f->format, pl_copy_text(inner)};
    if (!mesh.inner || !pl_append(&f->mesh, &f->n, &f->capacity, &mesh, sizeof mesh)) {
        pl_free(mesh.inner);
        f->is_out_of_memory = 1;
    }
}

/** Look at the place with name where it has "*". */
static int take_name(void *user, const char *name) {
    finder *f = user;
    const char *star = strchr(f->place, '*');
    const size_t size = strlen(f->place) + strlen(name) + 1;
    char *inner = pl_alloc((int64_t)size, 1);
    f->is_out_of_memory |= !inner;
    if (inner) {
        snprintf(inner, size, "%.*s%s%s", (int)(star - f->place), f->place, name, star + 1);
        look_at(f, inner);
    }
    pl_free(inner);
    return f->is_out_of_memory;
}

/** Look at all places of a format, but at nothing within a folder that is itself a mesh. */
static void look_for(finder *f, const io_format *format) {
    f->format = format;
    for (const char *const *place = format->folder->places; *place; place++) {
        const char *star = strchr(*place, '*');
        f->place = *place;
        if (!star) {
            look_at(f, *place);
        } else {
            char *around = join(f->path, *place, "");
            f->is_out_of_memory |= !around;
            if (around) { /* as far as the separator before "*" */
                around[strlen(around) - strlen(star) - 1] = '\0';
                if (pl_folder_list(around, take_name, f)) /* without such a folder there is none */
                    f->reason = errno == ENOENT || errno == ENOTDIR ? f->reason : errno;
            }
            pl_free(around);
        }
        if (f->n > 0 && !**place)
            return;
    }
}

static int compare(const void *a, const void *b) {
    return strcmp(((const found *)a)->inner, ((const found *)b)->inner);
}

/* ---- one of them ---------------------------------------------------------------------------- */

static int fail_several(const finder *f, planish_error *error) {
    char list[320] = "";
    size_t used = 0;
    for (int64_t i = 0; i < f->n && used < sizeof list; i++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s/%s", i ? ", " : "", f->path,
                                 f->mesh[i].inner);
    return pl_fail(error, PLANISH_ERROR_FILE, "%s: has %lld meshes; give one of them: %s", f->path,
                   (long long)f->n, list);
}

static int fail_none(const finder *f, planish_error *error) {
    if (f->partial)
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s%s: is not a complete mesh of the format %s: it has no file %s", f->path,
                       f->partial_inner, f->partial->name, f->missing);
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: is a folder without a mesh: give a mesh file, or a folder with a mesh of "
                   "Elmer (mesh.header, mesh.nodes, mesh.elements, mesh.boundary) or OpenFOAM "
                   "(constant/polyMesh, or points, faces, owner, neighbour, boundary)",
                   f->path);
}

/** Find the mesh. *format and *inner (owned) are set on success. */
static int find(finder *f, const char *name, const io_format **format, char **inner,
                planish_error *error) {
    const io_format *wanted = name ? io_format_by_name(name) : NULL;
    if (name && (!wanted || !wanted->folder))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: is a folder; meshes of the format '%s' are %s", f->path, name,
                       wanted ? "files" : "unknown");
    for (int i = 0; i < N_FOLDERS; i++)
        if (!wanted || folders[i] == wanted)
            look_for(f, folders[i]);
    if (f->is_out_of_memory)
        return pl_fail_memory(error, f->path);
    errno = f->reason;
    if (f->reason)
        return pl_fail_errno(error, f->path, "cannot be read");
    if (f->n == 0)
        return fail_none(f, error);
    qsort(f->mesh, (size_t)f->n, sizeof *f->mesh, compare);
    if (f->n > 1)
        return fail_several(f, error);
    *format = f->mesh[0].format;
    *inner = f->mesh[0].inner;
    f->mesh[0].inner = NULL;
    return PLANISH_OK;
}

static void release(finder *f) {
    for (int64_t i = 0; i < f->n; i++)
        pl_free(f->mesh[i].inner);
    pl_free(f->mesh);
}

/** Open the file with the coordinates, unpacked. */
static int open_coordinates(io_model *model, const io_folder *folder, planish_error *error) {
    char packed[64];
    snprintf(packed, sizeof packed, "%s.gz", folder->files[0]);
    char *path = io_folder_path(model, folder->files[0]);
    const int is_packed = path && folder->may_be_packed && !pl_file_exists(path);
    if (is_packed) {
        pl_free(path);
        path = io_folder_path(model, packed);
    }
    int status = path ? PLANISH_OK : pl_fail_memory(error, model->folder);
    if (!status)
        status = io_bytes_open_beside(path, model->largest_copy, &model->input, error);
    pl_free(path);
    if (!status && is_packed) {
        model->packed = model->input;
        status = io_gunzip(&model->packed, &model->input, error);
    }
    return status;
}

int io_folder_find_mesh(planish_file *file, const char *path, const char *name,
                        planish_error *error) {
    io_model *model = &file->model;
    model->folder = io_folder_trim(path);
    if (!model->folder)
        return pl_fail_memory(error, path);
    finder f = {.path = model->folder};
    int status = find(&f, name, &file->format, &model->inner, error);
    release(&f);
    return status ? status : open_coordinates(model, file->format->folder, error);
}

char *io_folder_mesh_file(const char *path, int i) {
    const io_format *format = NULL;
    planish_error ignored;
    char *inner = NULL, *result = NULL;
    finder f = {.path = path};
    if (find(&f, NULL, &format, &inner, &ignored) == PLANISH_OK && format) {
        const int step = format->folder->may_be_packed ? 2 : 1;
        const char *const *name = format->folder->files;
        for (int k = 0; *name && k < i / step; k++)
            name++;
        char file[64];
        snprintf(file, sizeof file, "%s%s", *name ? *name : "", i % step ? ".gz" : "");
        result = *name ? join(path, inner, file) : NULL;
    }
    pl_free(inner);
    release(&f);
    return result;
}
