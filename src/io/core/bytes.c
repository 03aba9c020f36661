/* bytes: the content of a file, in memory of its own or mapped. */
#include "io/core/bytes.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { MAPPED_NO, MAPPED_YES, MAPPED_BORROWED }; /* io_bytes.mapped */
/* Largest single read(): Linux takes no more than just below 2^31 bytes. */
enum { READ_AT_ONCE = 1 << 30 };

/* What a device of characters may give: a terminal, somebody's typing. Others have no end. */
static const int64_t LARGEST_OF_DEVICE = 1 << 20;

/** Read what is no regular file to its end. At most half of the machine's memory may come of it, as
 *  what never ends would take all of it, and the process would be killed. */
static int read_stream(int fd, const pl_file_status *about, io_bytes *bytes, planish_error *error) {
    enum { BLOCK = 1 << 20 };
    const int64_t largest =
        about->kind == PL_FILE_CHARACTERS ? LARGEST_OF_DEVICE : pl_system_memory() / 2;
    char *data = NULL;
    int64_t size = 0, capacity = 0;
    int status = PLANISH_OK;
    while (!status) {
        char *grown = pl_grow(data, size, size + BLOCK, &capacity, 1);
        if (!grown) {
            status = pl_fail_memory(error, bytes->path);
            break;
        }
        data = grown;
        const ssize_t got = read(fd, data + size, BLOCK);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            status = pl_fail_errno(error, bytes->path, "cannot be read");
        if (got <= 0)
            break;
        size += got;
        if (size > largest)
            status = pl_fail(error, PLANISH_ERROR_FILE,
                             "%s: gives more than %lld MB, and no end: save it as a regular file, "
                             "which planish does not read into memory",
                             bytes->path, (long long)(largest >> 20));
    }
    if (status) {
        pl_free(data);
        return status;
    }
    bytes->data = data;
    bytes->size = size;
    bytes->mapped = MAPPED_NO;
    return PLANISH_OK;
}

int io_bytes_fail_changed(const io_bytes *bytes, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: was changed while it was in use; run again when it is complete",
                   bytes->path);
}

static int fail_shorter(const io_bytes *bytes, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: became shorter while it was in use; run again when it is complete",
                   bytes->path);
}

/** Compare a regular file with what it was when it was opened. */
static int check_now(int fd, const io_bytes *bytes, planish_error *error) {
    pl_file_status now;
    if (pl_file_find_open(fd, &now))
        return pl_fail_errno(error, bytes->path, "cannot be read");
    if (now.size < bytes->size)
        return fail_shorter(bytes, error);
    if (now.size != bytes->size || now.modified != bytes->modified)
        return io_bytes_fail_changed(bytes, error);
    return PLANISH_OK;
}

/** Read a file of a known size, all of which must be of one moment. Where a mapped file could be
 *  replaced the descriptor stays open: the file may get another name meanwhile. */
static int copy_regular(int fd, io_bytes *bytes, planish_error *error) {
    char *data = pl_alloc(bytes->size, 1);
    int status = data ? PLANISH_OK : pl_fail_memory(error, bytes->path);
    for (int64_t done = 0; done < bytes->size && !status;) {
        const int64_t left = bytes->size - done;
        const ssize_t got =
            read(fd, data + done, left < READ_AT_ONCE ? (unsigned)left : READ_AT_ONCE);
        if (got > 0)
            done += got;
        else if (got == 0)
            status = fail_shorter(bytes, error);
        else if (errno != EINTR)
            status = pl_fail_errno(error, bytes->path, "cannot be read");
    }
    if (!status)
        status = check_now(fd, bytes, error);
    if (status) {
        pl_free(data);
        return status;
    }
    bytes->data = data;
    bytes->mapped = MAPPED_NO;
    bytes->fd = pl_file_open_is_replaceable() ? fd : -1;
    return PLANISH_OK;
}

/** The content of an open file; *bytes keeps the descriptor of one that is mapped. */
static int open_descriptor(int fd, int64_t largest_copy, io_bytes *bytes, planish_error *error) {
    pl_file_status about;
    if (pl_file_find_open(fd, &about))
        return pl_fail_errno(error, bytes->path, "cannot be read");
    if (about.kind == PL_FILE_FOLDER)
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: is a folder; give a mesh file", bytes->path);
    if (about.kind != PL_FILE_REGULAR)
        return read_stream(fd, &about, bytes, error);
    if (about.size == 0)
        return PLANISH_OK;
    bytes->size = about.size;
    bytes->modified = about.modified;
    const char *data = about.size > largest_copy ? pl_file_map(fd, about.size) : NULL;
    if (data) {
        bytes->data = data;
        bytes->mapped = MAPPED_YES;
        bytes->fd = fd;
        return PLANISH_OK;
    }
    if (about.size > largest_copy && errno != ENOSYS)
        return pl_fail_errno(error, bytes->path, "cannot be mapped");
    return copy_regular(fd, bytes, error);
}

int io_bytes_open(const char *path, int64_t largest_copy, io_bytes *bytes, planish_error *error) {
    *bytes = (io_bytes){.path = pl_copy_text(path), .fd = -1};
    if (!bytes->path)
        return pl_fail_memory(error, path);
    int fd = pl_file_open(path, PL_FILE_READ);
    int status = fd < 0 ? pl_fail_errno(error, path, "cannot be opened")
                        : open_descriptor(fd, largest_copy, bytes, error);
    if (!status && bytes->size == 0)
        status = pl_fail(error, PLANISH_ERROR_FORMAT, "%s: the file is empty", path);
    if (fd >= 0 && bytes->fd != fd)
        close(fd);
    if (status)
        io_bytes_close(bytes);
    return status;
}

int io_bytes_open_beside(const char *path, int64_t largest_copy, io_bytes *bytes,
                         planish_error *error) {
    pl_file_status about;
    *bytes = (io_bytes){.fd = -1};
    if (pl_file_find(path, &about) == 0 && about.kind != PL_FILE_REGULAR)
        return pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: is %s, but the mesh needs a regular file there", path,
                       about.kind == PL_FILE_FOLDER ? "a folder" : "a pipe or device");
    return io_bytes_open(path, largest_copy, bytes, error);
}

int io_bytes_borrow(const char *path, const char *data, int64_t size, io_bytes *bytes,
                    planish_error *error) {
    *bytes = (io_bytes){.path = pl_copy_text(path),
                        .data = data,
                        .size = size,
                        .mapped = MAPPED_BORROWED,
                        .fd = -1};
    return bytes->path ? PLANISH_OK : pl_fail_memory(error, path);
}

void io_bytes_rest(const io_bytes *bytes) {
    if (bytes->mapped == MAPPED_YES)
        pl_file_rest(bytes->data, bytes->size);
}

int io_bytes_can_change(const io_bytes *bytes) {
    return bytes->mapped == MAPPED_YES;
}

int io_bytes_own(io_bytes *bytes, planish_error *error) {
    io_bytes copy = *bytes;
    if (bytes->mapped != MAPPED_YES || bytes->size > pl_system_memory() / 4)
        return PLANISH_OK;
    if (lseek(bytes->fd, 0, SEEK_SET) < 0)
        return pl_fail_errno(error, bytes->path, "cannot be read");
    const int status = copy_regular(bytes->fd, &copy, error);
    if (status)
        return status;
    pl_file_unmap(bytes->data, bytes->size);
    *bytes = copy;
    return PLANISH_OK;
}

int io_bytes_check_unchanged(const io_bytes *bytes, planish_error *error) {
    return bytes->fd < 0 ? PLANISH_OK : check_now(bytes->fd, bytes, error);
}

int io_bytes_are_of(const io_bytes *bytes, int fd) {
    pl_file_status input, other;
    return bytes->fd >= 0 && pl_file_find_open(bytes->fd, &input) == 0 &&
           pl_file_find_open(fd, &other) == 0 && pl_file_is_same(&input, &other);
}

void io_bytes_close(io_bytes *bytes) {
    if (bytes->mapped == MAPPED_YES)
        pl_file_unmap(bytes->data, bytes->size);
    if (bytes->fd >= 0)
        close(bytes->fd);
    if (bytes->mapped == MAPPED_NO)
        pl_free((void *)(uintptr_t)bytes->data);
    pl_free(bytes->path);
    *bytes = (io_bytes){.fd = -1};
}
