/* output: write a file beside its place and rename it, or straight into a pipe or device. */
#include "base/output.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MAX_LINKS = 40, LONGEST_KEPT = 200 };
/* Largest single write(): Linux takes no more than just below 2^31 bytes. */
enum { WRITE_AT_ONCE = 1 << 30 };

/* ---- the list of temporary files ---------------------------------------------------------- */

/* Both are written so that the list is whole at any moment a signal may read it: what stands behind
 * a path begins to count with its first byte. */

static void set_first(char *path, char byte) {
    __atomic_store_n(path, byte, __ATOMIC_SEQ_CST);
}

void pl_temporaries_add(pl_temporaries list, const char *path) {
    size_t at = 0, length = strlen(path);
    if (!list.paths)
        return;
    while (at < list.size && list.paths[at])
        at += strlen(list.paths + at) + 1;
    if (at + length + 2 > list.size)
        return;
    list.paths[at + length + 1] = '\0';
    memcpy(list.paths + at + 1, path + 1, length);
    set_first(&list.paths[at], path[0]);
}

void pl_temporaries_remove(pl_temporaries list, const char *path) {
    size_t at = 0;
    if (!list.paths)
        return;
    while (at < list.size && list.paths[at] && strcmp(list.paths + at, path) != 0)
        at += strlen(list.paths + at) + 1;
    if (at >= list.size || !list.paths[at])
        return;
    const size_t next = at + strlen(list.paths + at) + 1;
    const char first = list.paths[next];
    set_first(&list.paths[at], '\0');
    memmove(list.paths + at + 1, list.paths + next + 1, list.size - next - 1);
    set_first(&list.paths[at], first);
}

/* ---- where it goes ------------------------------------------------------------------------ */

/** The open descriptor that path is a name of, or -1. What it leads to may be a regular file, which
 *  others write, too (>> log): it must not be replaced. */
static int named_descriptor(const char *path) {
    static const char *const folders[] = {"/dev/fd/", "/proc/self/fd/"};
    if (strcmp(path, "/dev/stdin") == 0)
        return STDIN_FILENO;
    if (strcmp(path, "/dev/stdout") == 0)
        return STDOUT_FILENO;
    if (strcmp(path, "/dev/stderr") == 0)
        return STDERR_FILENO;
    for (int i = 0; i < 2; i++) {
        size_t length = strlen(folders[i]);
        if (strncmp(path, folders[i], length) != 0)
            continue;
        size_t digits = strspn(path + length, "0123456789");
        if (digits > 0 && digits < 9 && path[length + digits] == '\0')
            return (int)strtol(path + length, NULL, 10);
    }
    return -1;
}

int pl_output_is_stream(const char *path) {
    pl_file_status about;
    return named_descriptor(path) >= 0 ||
           (pl_file_find(path, &about) == 0 && about.kind != PL_FILE_REGULAR &&
            about.kind != PL_FILE_FOLDER);
}

char *pl_output_target(const char *path) {
    char *at = pl_alloc(PATH_MAX, 1), *link = pl_alloc(PATH_MAX, 1);
    int status = !at || !link ? ENOMEM : strlen(path) < PATH_MAX ? 0 : ENAMETOOLONG;
    pl_file_status there, found;
    if (!status)
        strcpy(at, path);
    for (int i = 0; !status && pl_path_read_link(at, link, PATH_MAX) == 0; i++) {
        /* In a folder such as /tmp the system may refuse to follow (Linux, fs.protected_symlinks),
         * as another user may have put the link there; one that is read here and followed by its
         * text must be refused, too. What it leads to need not be there. */
        if (pl_file_find(at, &there) && errno != ENOENT) {
            status = errno;
            break;
        }
        const size_t length = strlen(link);
        const size_t folder = pl_path_is_absolute(link) ? 0 : (size_t)(pl_path_name(at) - at);
        if (i == MAX_LINKS || folder + length >= PATH_MAX)
            status = ELOOP;
        else
            memcpy(at + folder, link, length + 1);
    }
    /* path must still lead to the file at at, or both to none. */
    if (!status && strcmp(path, at) != 0) {
        const int is_absent = pl_file_find(path, &there) != 0;
        const int is_missing = pl_file_find(at, &found) != 0;
        if (is_absent != is_missing || (!is_absent && !pl_file_is_same(&there, &found)))
            status = EACCES;
    }
    pl_free(link);
    if (status) {
        pl_free(at);
        errno = status;
        return NULL;
    }
    return at;
}

char *pl_temporary_name(const char *target, int i) {
    const size_t folder = (size_t)(pl_path_name(target) - target);
    const size_t size = folder + LONGEST_KEPT + 48, length = strlen(target);
    /* The whole name must be legal, too. */
    const size_t kept = length > folder + LONGEST_KEPT ? folder + LONGEST_KEPT : length;
    char *name = pl_alloc((int64_t)size, 1);
    if (name)
        snprintf(name, size, "%.*s.planish-%ld-%d", (int)kept, target, pl_process_number(), i);
    return name;
}

/** Create TARGET.planish-PROCESS-N beside target: as open for others as any new file if there is no
 *  target whose mode it will get. Return its descriptor, or -1: errno. */
static int create_temporary(pl_temporaries temporaries, pl_output *output) {
    const pl_file_use use =
        pl_file_exists(output->target) ? PL_FILE_CREATE_PRIVATE : PL_FILE_CREATE;
    errno = ENOMEM;
    for (int i = 0; i < PL_TEMPORARY_NAMES; i++) {
        char *name = pl_temporary_name(output->target, i);
        int fd = -1, reason = name ? EEXIST : ENOMEM; /* another one's must not be removed */
        if (name && !pl_file_exists(name)) {
            pl_temporaries_add(temporaries, name); /* it is listed before it is there */
            fd = pl_file_open(name, use);
            reason = errno;
        }
        if (fd >= 0) {
            output->temporary = name;
            return fd;
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

static int open_beside(const char *path, pl_temporaries temporaries, pl_output *output,
                       planish_error *error) {
    pl_file_status about;
    output->target = pl_output_target(path);
    if (!output->target)
        return pl_fail_errno(error, path, "cannot be written");
    if (pl_file_find(output->target, &about) == 0 && about.kind == PL_FILE_FOLDER)
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: is a folder; give a file to write", path);
    output->fd = create_temporary(temporaries, output);
    if (output->fd < 0)
        return pl_fail_errno(error, path, "cannot be written");
    output->replaces = pl_file_exists(output->target);
    pl_file_take_access(output->fd, output->target);
    return PLANISH_OK;
}

int pl_output_open(const char *path, pl_temporaries temporaries, pl_output *output,
                   planish_error *error) {
    *output = (pl_output){.fd = -1};
    if (!pl_output_is_stream(path))
        return open_beside(path, temporaries, output, error);
    int named = named_descriptor(path);
    output->fd = named >= 0 ? pl_file_duplicate(named) : pl_file_open(path, PL_FILE_WRITE);
    output->target = pl_alloc((int64_t)strlen(path) + 1, 1);
    if (output->fd < 0)
        return pl_fail_errno(error, path, "cannot be written");
    if (!output->target)
        return pl_fail_memory(error, path);
    strcpy(output->target, path);
    return PLANISH_OK;
}

int pl_output_write(pl_output *output, const char *data, int64_t size, planish_error *error) {
    return output->pack ? output->pack(output, data, size, error)
                        : pl_output_write_as_it_is(output, data, size, error);
}

int pl_output_write_as_it_is(pl_output *output, const char *data, int64_t size,
                             planish_error *error) {
    while (size > 0) {
        unsigned wanted = size < WRITE_AT_ONCE ? (unsigned)size : WRITE_AT_ONCE;
        ssize_t written = write(output->fd, data, wanted);
        if (written < 0 && errno == EINTR)
            continue;
        if (written == 0)
            errno = ENOSPC; /* a device that takes no more and says no why */
        if (written <= 0)
            return pl_fail_errno(error, output->target, "cannot be written");
        data += written;
        size -= written;
    }
    return PLANISH_OK;
}

int pl_output_finish(pl_output *output, planish_error *error) {
    const int status = output->pack ? output->pack(output, NULL, 0, error) : PLANISH_OK;
    if (status || output->fd < 0)
        return status;
    /* What it replaces may be the only copy: the bytes must be on the disk before the rename. */
    int failed = output->replaces && pl_file_sync(output->fd);
    const int reason = errno;
    if (pl_file_close(output->fd) == 0)
        errno = reason;
    else
        failed = 1;
    output->fd = -1;
    return failed ? pl_fail_errno(error, output->target, "cannot be written") : PLANISH_OK;
}

int pl_output_rewrite(pl_output *output, const char *data, int64_t size, planish_error *error) {
    output->fd = pl_file_open(output->temporary, PL_FILE_REWRITE);
    if (output->fd < 0)
        return pl_fail_errno(error, output->target, "cannot be written");
    const int status = pl_output_write(output, data, size, error);
    return status ? status : pl_output_finish(output, error);
}

int pl_output_commit(pl_output *output, pl_temporaries temporaries, planish_error *error) {
    if (!output->temporary)
        return PLANISH_OK;
    if (pl_file_replace(output->temporary, output->target))
        return pl_fail_errno(error, output->target, "cannot be replaced");
    pl_temporaries_remove(temporaries, output->temporary);
    pl_free(output->temporary);
    output->temporary = NULL;
    output->is_committed = 1;
    return PLANISH_OK;
}

void pl_output_undo(const pl_output *output) {
    if (output->is_committed && !output->replaces)
        unlink(output->target);
}

void pl_output_release(pl_output *output, pl_temporaries temporaries) {
    if (output->fd >= 0)
        close(output->fd);
    if (output->temporary) {
        pl_file_remove(output->temporary);
        pl_temporaries_remove(temporaries, output->temporary);
    }
    pl_free(output->temporary);
    pl_free(output->target);
    *output = (pl_output){.fd = -1};
}
