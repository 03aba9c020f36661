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
    return is_as_before(&now, bytes->size, bytes->modified) ? PLANISH_OK
                                                            : io_bytes_fail_changed(bytes, error);
}

/** Fill data [bytes->size] from the beginning of the file. */
static int fill(int fd, char *data, const io_bytes *bytes, planish_error *error) {
    for (int64_t done = 0; done < bytes->size;) {
        const int64_t left = bytes->size - done;
        const ssize_t got =
            read(fd, data + done, left < READ_AT_ONCE ? (unsigned)left : READ_AT_ONCE);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return pl_fail_errno(error, bytes->path, "cannot be read");
        if (got == 0)
            return fail_shorter(bytes, error);
        done += got;
    }
    return check_now(fd, bytes, error);
}

/** Read a file of a known size, all of which must be of one moment. Where a mapped file could be
 *  replaced the descriptor stays open: the file may get another name meanwhile. */
static int copy_regular(int fd, io_bytes *bytes, planish_error *error) {
    char *data = pl_alloc(bytes->size, 1);
    if (!data)
        return pl_fail_memory(error, bytes->path);
    const int status = fill(fd, data, bytes, error);
    if (status) {
        pl_free(data);
        return status;
    }
    bytes->data = data;
    bytes->mapped = MAPPED_NO;
    bytes->fd = pl_file_open_is_replaceable() ? fd : -1;
    return PLANISH_OK;
}

/** The descriptor stays open, too. */
static int map_regular(int fd, io_bytes *bytes, planish_error *error) {
    const char *data = pl_file_map(fd, bytes->size);
    if (!data && errno == ENOSYS)
        return copy_regular(fd, bytes, error);
    if (!data)
        return pl_fail_errno(error, bytes->path, "cannot be mapped");
    bytes->data = data;
    bytes->mapped = MAPPED_YES;
    bytes->fd = fd;
    return PLANISH_OK;
}

static int open_regular(int fd, const pl_file_status *about, int64_t largest_copy, io_bytes *bytes,
                        planish_error *error) {
    bytes->size = about->size;
    bytes->modified = about->modified;
    const int status = about->size <= largest_copy ? copy_regular(fd, bytes, error)
                                                   : map_regular(fd, bytes, error);
    if (status)
        bytes->size = 0;
    return status;
}

static int open_descriptor(int fd, int64_t largest_copy, io_bytes *bytes, planish_error *error) {
    pl_file_status about;
    if (pl_file_find_open(fd, &about))
        return pl_fail_errno(error, bytes->path, "cannot be read");
    if (about.kind == PL_FILE_FOLDER)
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: is a folder; give a mesh file", bytes->path);
    int status = PLANISH_OK;
    if (about.kind != PL_FILE_REGULAR)
        status = read_stream(fd, largest_stream(&about), bytes, error);
    else if (about.size > 0)
        status = open_regular(fd, &about, largest_copy, bytes, error);
    if (!status && bytes->size == 0)
        status = pl_fail(error, PLANISH_ERROR_FORMAT, "%s: the file is empty", bytes->path);
    return status;
}

int io_bytes_open(const char *path, int64_t largest_copy, io_bytes *bytes, planish_error *error) {
    *bytes = (io_bytes){.path = pl_copy_text(path), .fd = -1};
    if (!bytes->path)
        return pl_fail_memory(error, path);
    int fd = pl_file_open(path, PL_FILE_READ);
    int status = fd < 0 ? pl_fail_errno(error, path, "cannot be opened")
                        : open_descriptor(fd, largest_copy, bytes, error);
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
