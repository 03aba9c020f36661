/* output: write a file beside its place and rename it, or straight into a pipe or device. */
#include "io/output.h"

#include "io/descriptor.h"

#include "base/memory.h"
#include "base/status.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAX_LINKS = 40, MAX_NAMES = 1000, LONGEST_KEPT = 200 };
/* Largest single write(): Linux takes no more than just below 2^31 bytes. */
enum { WRITE_AT_ONCE = 1 << 30 };

static int fail_errno(const char *path, const char *what, planish_error *error) {
    if (errno == ENOMEM)
        return pl_fail_memory(error, path);
    return pl_fail(error, PLANISH_ERROR_FILE, "%s: %s: %s", path, what, strerror(errno));
}

/* ---- the list of temporary files ---------------------------------------------------------- */

/* Both are written so that the list is whole at any moment a signal may read it: what stands behind
 * a path begins to count with its first byte. */

static void set_first(char *path, char byte) {
    __atomic_store_n(path, byte, __ATOMIC_SEQ_CST);
}

static void temporaries_add(io_temporaries list, const char *path) {
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

static void temporaries_remove(io_temporaries list, const char *path) {
    size_t at = 0;
    if (!list.paths)
        return;
    while (at < list.size && list.paths[at] && strcmp(list.paths + at, path))
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
            return atoi(path + length);
    }
    return -1;
}

int io_output_is_stream(const char *path) {
    struct stat about;
    return named_descriptor(path) >= 0 ||
           (stat(path, &about) == 0 && !S_ISREG(about.st_mode) && !S_ISDIR(about.st_mode));
}

/** path with a link at its end followed, also one that leads nowhere yet. Owned; NULL: errno. */
static char *follow_links(const char *path) {
    char *at = pl_alloc(PATH_MAX, 1), *link = pl_alloc(PATH_MAX, 1);
    int status = !at || !link ? ENOMEM : strlen(path) < PATH_MAX ? 0 : ENAMETOOLONG;
    if (!status)
        strcpy(at, path);
    for (int i = 0; !status; i++) {
        ssize_t length = readlink(at, link, PATH_MAX - 1);
        if (length < 0)
            break; /* no link: the end */
        link[length] = '\0';
        char *slash = strrchr(at, '/');
        size_t folder = link[0] == '/' || !slash ? 0 : (size_t)(slash - at) + 1;
        if (i == MAX_LINKS || folder + (size_t)length >= PATH_MAX)
            status = ELOOP;
        else
            memcpy(at + folder, link, (size_t)length + 1);
    }
    pl_free(link);
    if (status) {
        pl_free(at);
        errno = status;
        return NULL;
    }
    return at;
}

/** Create the temporary file, which is listed before it is there. */
static int create(const char *path, mode_t mode, io_temporaries temporaries) {
    if (access(path, F_OK) == 0) {
        errno = EEXIST; /* another one's, which a signal must not remove */
        return -1;
    }
    temporaries_add(temporaries, path);
    const int fd = io_descriptor_open(path, O_WRONLY | O_CREAT | O_EXCL, mode);
    const int reason = errno;
    if (fd < 0)
        temporaries_remove(temporaries, path);
    errno = reason;
    return fd;
}

/** Create TARGET.planish-N beside target: as open for others as any new file if there is no target
 *  whose mode it will get. */
static int create_temporary(io_temporaries temporaries, io_output *output) {
    mode_t mode = access(output->target, F_OK) ? 0666 : 0600;
    const char *slash = strrchr(output->target, '/');
    size_t folder = slash ? (size_t)(slash - output->target) + 1 : 0;
    size_t size = folder + LONGEST_KEPT + 48, kept = strlen(output->target);
    if (kept > folder + LONGEST_KEPT)
        kept = folder + LONGEST_KEPT; /* the whole name must be legal, too */
    output->temporary = pl_alloc((int64_t)size, 1);
    if (!output->temporary) {
        errno = ENOMEM;
        return -1;
    }
    for (int i = 0; i < MAX_NAMES; i++) {
        snprintf(output->temporary, size, "%.*s.planish-%ld-%d", (int)kept, output->target,
                 (long)getpid(), i);
        const int fd = create(output->temporary, mode, temporaries);
        if (fd >= 0 || errno != EEXIST)
            return fd;
    }
    return -1;
}

static void keep_mode_and_owner(int fd, const char *target) {
    struct stat about;
    if (stat(target, &about))
        return;
    /* Only root may give a file away; for others the file becomes theirs, as with any new one. */
    if (about.st_uid != geteuid() || about.st_gid != getegid())
        if (fchown(fd, about.st_uid, about.st_gid))
            errno = 0;
    fchmod(fd, about.st_mode & 07777);
}

static int open_beside(const char *path, io_temporaries temporaries, io_output *output,
                       planish_error *error) {
    struct stat about;
    output->target = follow_links(path);
    if (!output->target)
        return fail_errno(path, "cannot be written", error);
    if (stat(output->target, &about) == 0 && S_ISDIR(about.st_mode))
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: is a folder; give a file to write", path);
    output->fd = create_temporary(temporaries, output);
    if (output->fd < 0) {
        int reason = errno;
        pl_free(output->temporary);
        output->temporary = NULL;
        errno = reason;
        return fail_errno(path, "cannot be written", error);
    }
    output->replaces = access(output->target, F_OK) == 0;
    keep_mode_and_owner(output->fd, output->target);
    return PLANISH_OK;
}

int io_output_open(const char *path, io_temporaries temporaries, io_output *output,
                   planish_error *error) {
    *output = (io_output){.fd = -1};
    if (!io_output_is_stream(path))
        return open_beside(path, temporaries, output, error);
    int named = named_descriptor(path);
    output->fd =
        named >= 0 ? fcntl(named, F_DUPFD_CLOEXEC, 0) : io_descriptor_open(path, O_WRONLY, 0);
    output->target = pl_alloc((int64_t)strlen(path) + 1, 1);
    if (output->fd < 0)
        return fail_errno(path, "cannot be written", error);
    if (!output->target)
        return pl_fail_memory(error, path);
    strcpy(output->target, path);
    return PLANISH_OK;
}

int io_output_write(io_output *output, const char *data, int64_t size, planish_error *error) {
    while (size > 0) {
        size_t wanted = size < WRITE_AT_ONCE ? (size_t)size : WRITE_AT_ONCE;
        ssize_t written = write(output->fd, data, wanted);
        if (written < 0 && errno == EINTR)
            continue;
        if (written == 0)
            errno = ENOSPC; /* a device that takes no more and says no why */
        if (written <= 0)
            return fail_errno(output->target, "cannot be written", error);
        data += written;
        size -= written;
    }
    return PLANISH_OK;
}

/** What it replaces may be the only copy: then the bytes must be on the disk before the rename. Not
 *  0: errno says why they are not. EINVAL: this file system knows no such thing. */
static int settle(const io_output *output, int fd) {
    return output->replaces && io_descriptor_sync(fd) && errno != EINVAL;
}

int io_output_finish(io_output *output, planish_error *error) {
    int failed = settle(output, output->fd);
    int reason = errno;
    if (io_descriptor_close(output->fd) == 0)
        errno = reason;
    else
        failed = 1;
    output->fd = -1;
    return failed ? fail_errno(output->target, "cannot be written", error) : PLANISH_OK;
}

int io_output_rewrite(io_output *output, const char *data, int64_t size, planish_error *error) {
    output->fd = io_descriptor_open(output->temporary, O_WRONLY | O_TRUNC, 0);
    if (output->fd < 0)
        return fail_errno(output->target, "cannot be written", error);
    const int status = io_output_write(output, data, size, error);
    return status ? status : io_output_finish(output, error);
}

int io_output_commit(io_output *output, io_temporaries temporaries, planish_error *error) {
    if (!output->temporary)
        return PLANISH_OK;
    if (rename(output->temporary, output->target))
        return fail_errno(output->target, "cannot be replaced", error);
    temporaries_remove(temporaries, output->temporary);
    pl_free(output->temporary);
    output->temporary = NULL;
    output->is_committed = 1;
    return PLANISH_OK;
}

void io_output_undo(const io_output *output) {
    if (output->is_committed && !output->replaces)
        unlink(output->target);
}

void io_output_release(io_output *output, io_temporaries temporaries) {
    if (output->fd >= 0)
        close(output->fd);
    if (output->temporary) {
        unlink(output->temporary);
        temporaries_remove(temporaries, output->temporary);
    }
    pl_free(output->temporary);
    pl_free(output->target);
    *output = (io_output){.fd = -1};
}
