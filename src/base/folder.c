/* folder: make a folder complete beside its place, and rename it. */
#include "base/folder.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/** Join a folder and a name: owned, or NULL without memory. */
static char *join(const char *folder, const char *name) {
    const size_t size = strlen(folder) + strlen(name) + 2;
    char *path = pl_alloc((int64_t)size, 1);
    if (path)
        snprintf(path, size, "%s/%s", folder, name);
    return path;
}

/** Make the folder under the first temporary name that is free. 0, or -1 and errno. */
static int create(pl_folder_output *folder, pl_temporaries temporaries) {
    errno = ENOMEM;
    for (int i = 0; i < PL_TEMPORARY_NAMES; i++) {
        char *name = pl_temporary_name(folder->target, i);
        int reason = name ? EEXIST : ENOMEM; /* another one's must not be removed */
        if (name && !pl_file_exists(name)) {
            pl_temporaries_add(temporaries, name); /* it is listed before it is there */
            reason = pl_folder_create(name) ? errno : 0;
        }
        if (!reason) {
            folder->temporary = name;
            return 0;
        }
        if (name)
            pl_temporaries_remove(temporaries, name);
        pl_free(name);
        errno = reason;
        if (reason != EEXIST)
            break;
    }
    return -1;
}

int pl_folder_begin(const char *path, pl_temporaries temporaries, pl_folder_output *folder,
                    planish_error *error) {
    *folder = (pl_folder_output){.target = pl_output_target(path)};
    if (!folder->target)
        return pl_fail_errno(error, path, "cannot be written");
    if (pl_file_exists(folder->target))
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: exists already", path);
    return create(folder, temporaries) ? pl_fail_errno(error, path, "cannot be written")
                                       : PLANISH_OK;
}

/** Note that something will be made at the path of name within: *path, which the folder owns. */
static int note(pl_folder_output *folder, const char *name, pl_temporaries temporaries,
                const char **path, planish_error *error) {
    char *made = join(folder->temporary, name);
    if (!made || !pl_append(&folder->made, &folder->n, &folder->capacity, &made, sizeof made)) {
        pl_free(made);
        return pl_fail_memory(error, folder->target);
    }
    pl_temporaries_add(temporaries, made);
    *path = made;
    return PLANISH_OK;
}

int pl_folder_add(pl_folder_output *folder, const char *name, pl_temporaries temporaries,
                  planish_error *error) {
    const char *path;
    const int status = note(folder, name, temporaries, &path, error);
    if (!status && pl_folder_create(path))
        return pl_fail_errno(error, folder->target, "cannot be written");
    return status;
}

int pl_folder_file(pl_folder_output *folder, const char *name, pl_temporaries temporaries,
                   pl_output *output, planish_error *error) {
    const char *path;
    *output = (pl_output){.fd = -1, .target = join(folder->target, name)};
    int status = output->target ? PLANISH_OK : pl_fail_memory(error, folder->target);
    if (!status)
        status = note(folder, name, temporaries, &path, error);
    if (status)
        return status;
    output->fd = pl_file_open(path, PL_FILE_CREATE);
    return output->fd < 0 ? pl_fail_errno(error, output->target, "cannot be written") : PLANISH_OK;
}

int pl_folder_commit(pl_folder_output *folder, pl_temporaries temporaries, planish_error *error) {
    if (pl_file_exists(folder->target)) /* the system might let it take the place of an empty one */
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: exists now", folder->target);
    if (pl_file_replace(folder->temporary, folder->target))
        return pl_fail_errno(error, folder->target, "cannot be written");
    for (int64_t i = folder->n - 1; i >= 0; i--)
        pl_temporaries_remove(temporaries, folder->made[i]);
    pl_temporaries_remove(temporaries, folder->temporary);
    pl_free(folder->temporary);
    folder->temporary = NULL;
    return PLANISH_OK;
}

void pl_folder_release(pl_folder_output *folder, pl_temporaries temporaries) {
    for (int64_t i = folder->n - 1; i >= 0; i--) {
        if (folder->temporary) {
            pl_file_remove(folder->made[i]);
            pl_temporaries_remove(temporaries, folder->made[i]);
        }
        pl_free(folder->made[i]);
    }
    if (folder->temporary) {
        pl_file_remove(folder->temporary);
        pl_temporaries_remove(temporaries, folder->temporary);
    }
    pl_free(folder->made);
    pl_free(folder->temporary);
    pl_free(folder->target);
    *folder = (pl_folder_output){.n = 0};
}
