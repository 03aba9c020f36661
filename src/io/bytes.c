/* bytes: the content of a file, mapped where it can be. */
#include "io/bytes.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum { MAPPED_NO, MAPPED_YES, MAPPED_BORROWED }; /* io_bytes.mapped */

/* What a device of characters may give: a terminal, somebody's typing. Others have no end. */
static const int64_t LARGEST_OF_DEVICE = 1 << 20;

/** How much may come of what is no regular file: half of the machine's memory, since what never
 *  ends would take all of it, and the process would be killed. */
static int64_t largest_stream(const pl_file_status *about) {
    return about->kind == PL_FILE_CHARACTERS ? LARGEST_OF_DEVICE : pl_system_memory() / 2;
}

static int fail_endless(int64_t largest, const char *path, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: there are more than %lld MB, and no end: give a mesh file, which is not "
                   "read into memory",
                   path, (long long)(largest >> 20));
}

static int read_stream(int fd, int64_t largest, io_bytes *bytes, planish_error *error) {
    enum { BLOCK = 1 << 20 };
    char *data = NULL;
    int64_t size = 0, capacity = 0;
    for (;;) {
        char *grown = pl_grow(data, size, size + BLOCK, &capacity, 1);
        if (!grown) {
            pl_free(data);
            return pl_fail_memory(error, bytes->path);
        }
        data = grown;
        ssize_t got = read(fd, data + size, BLOCK);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0) {
            pl_free(data);
            return pl_fail_errno(error, bytes->path, "cannot be read");
        }
        if (got == 0)
            break;
        size += got;
        if (size > largest) {
            pl_free(data);
            return fail_endless(largest, bytes->path, error);
        }
    }
    bytes->data = data;
    bytes->size = size;
    bytes->mapped = MAPPED_NO;
    return PLANISH_OK;
}

static int is_as_before(const pl_file_status *now, int64_t size, int64_t modified) {
    return now->size == size && now->modified == modified;
}

static int fail_changed(const io_bytes *bytes, planish_error *error) {
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: was changed while it was in use; run again when it is complete",
                   bytes->path);
}

/** Read a file to its end where none can be mapped. */
static int read_regular(int fd, const pl_file_status *about, io_bytes *bytes,
                        planish_error *error) {
    pl_file_status now;
    int status = read_stream(fd, INT64_MAX, bytes, error);
    if (!status && pl_file_find_open(fd, &now))
        status = pl_fail_errno(error, bytes->path, "cannot be read");
    if (!status && !is_as_before(&now, about->size, about->modified))
        status = fail_changed(bytes, error);
    return status;
}

/** The descriptor stays open: the file may get another name meanwhile. */
static int map_regular(int fd, const pl_file_status *about, io_bytes *bytes, planish_error *error) {
    const char *data = pl_file_map(fd, about->size);
    if (!data && errno == ENOSYS)
        return read_regular(fd, about, bytes, error);
    if (!data)
        return pl_fail_errno(error, bytes->path, "cannot be mapped");
    bytes->data = data;
    bytes->size = about->size;
    bytes->mapped = MAPPED_YES;
    bytes->fd = fd;
    bytes->modified = about->modified;
    return PLANISH_OK;
}

static int open_descriptor(int fd, io_bytes *bytes, planish_error *error) {
    pl_file_status about;
    if (pl_file_find_open(fd, &about))
        return pl_fail_errno(error, bytes->path, "cannot be read");
    if (about.kind == PL_FILE_FOLDER)
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: is a folder; give a mesh file", bytes->path);
    int status = PLANISH_OK;
    if (about.kind != PL_FILE_REGULAR)
        status = read_stream(fd, largest_stream(&about), bytes, error);
    else if (about.size > 0)
        status = map_regular(fd, &about, bytes, error);
    if (!status && bytes->size == 0)
        status = pl_fail(error, PLANISH_ERROR_FORMAT, "%s: the file is empty", bytes->path);
    return status;
}

int io_bytes_open(const char *path, io_bytes *bytes, planish_error *error) {
    *bytes = (io_bytes){.path = pl_copy_text(path), .fd = -1};
    if (!bytes->path)
        return pl_fail_memory(error, path);
    int fd = pl_file_open(path, PL_FILE_READ);
    int status =
        fd < 0 ? pl_fail_errno(error, path, "cannot be opened") : open_descriptor(fd, bytes, error);
    if (fd >= 0 && bytes->fd != fd)
        close(fd);
    if (status)
        io_bytes_close(bytes);
    return status;
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

int io_bytes_check_unchanged(const io_bytes *bytes, planish_error *error) {
    pl_file_status now;
    if (bytes->mapped != MAPPED_YES)
        return PLANISH_OK;
    if (pl_file_find_open(bytes->fd, &now))
        return pl_fail_errno(error, bytes->path, "cannot be read");
    return is_as_before(&now, bytes->size, bytes->modified) ? PLANISH_OK
                                                            : fail_changed(bytes, error);
}

int io_bytes_are_of(const io_bytes *bytes, int fd) {
    pl_file_status input, other;
    return bytes->mapped == MAPPED_YES && pl_file_find_open(bytes->fd, &input) == 0 &&
           pl_file_find_open(fd, &other) == 0 && pl_file_is_same(&input, &other);
}

void io_bytes_close(io_bytes *bytes) {
    if (bytes->mapped == MAPPED_YES) {
        pl_file_unmap(bytes->data, bytes->size);
        close(bytes->fd);
    }
    if (bytes->mapped == MAPPED_NO)
        pl_free((void *)(uintptr_t)bytes->data);
    pl_free(bytes->path);
    *bytes = (io_bytes){.fd = -1};
}
