/* bytes: the content of a file, mapped where it can be. */
#include "io/bytes.h"

#include "io/descriptor.h"

#include "base/memory.h"
#include "base/status.h"

#include <errno.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { MAPPED_NO, MAPPED_YES, MAPPED_BORROWED }; /* io_bytes.mapped */

/* What a device of characters may give: a terminal, somebody's typing. Others have no end. */
static const int64_t LARGEST_OF_DEVICE = 1 << 20;

static char *copy_text(const char *text) {
    size_t size = strlen(text) + 1;
    char *copy = pl_alloc((int64_t)size, 1);
    if (copy)
        memcpy(copy, text, size);
    return copy;
}

/** When a file was last written to, in ns. */
static int64_t time_of(const struct stat *about) {
    return (int64_t)about->st_mtim.tv_sec * 1000000000 + about->st_mtim.tv_nsec;
}

/** The descriptor stays open: the file may get another name meanwhile. */
static int map_regular(int fd, const struct stat *about, io_bytes *bytes, planish_error *error) {
    void *data = mmap(NULL, (size_t)about->st_size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return pl_fail_errno(error, bytes->path, "cannot be mapped");
    madvise(data, (size_t)about->st_size, MADV_SEQUENTIAL);
    bytes->data = data;
    bytes->size = about->st_size;
    bytes->mapped = MAPPED_YES;
    bytes->fd = fd;
    bytes->modified = time_of(about);
    return PLANISH_OK;
}

/** How much may come of what is no regular file: half of the machine's memory, since what never
 *  ends would take all of it, and the process would be killed. */
static int64_t largest_stream(const struct stat *about) {
    const int64_t pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    if (S_ISCHR(about->st_mode))
        return LARGEST_OF_DEVICE;
    return pages > 0 && size > 0 ? pages / 2 * size : INT64_MAX;
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

static int open_descriptor(int fd, io_bytes *bytes, planish_error *error) {
    struct stat about;
    if (fstat(fd, &about))
        return pl_fail_errno(error, bytes->path, "cannot be read");
    if (S_ISDIR(about.st_mode))
        return pl_fail(error, PLANISH_ERROR_FILE, "%s: is a folder; give a mesh file", bytes->path);
    int status = PLANISH_OK;
    if (!S_ISREG(about.st_mode))
        status = read_stream(fd, largest_stream(&about), bytes, error);
    else if (about.st_size > 0)
        status = map_regular(fd, &about, bytes, error);
    if (!status && bytes->size == 0)
        status = pl_fail(error, PLANISH_ERROR_FORMAT, "%s: the file is empty", bytes->path);
    return status;
}

int io_bytes_open(const char *path, io_bytes *bytes, planish_error *error) {
    *bytes = (io_bytes){.path = copy_text(path), .fd = -1};
    if (!bytes->path)
        return pl_fail_memory(error, path);
    int fd = io_descriptor_open(path, O_RDONLY, 0);
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
    *bytes = (io_bytes){
        .path = copy_text(path), .data = data, .size = size, .mapped = MAPPED_BORROWED, .fd = -1};
    return bytes->path ? PLANISH_OK : pl_fail_memory(error, path);
}

void io_bytes_rest(const io_bytes *bytes) {
    if (bytes->mapped == MAPPED_YES) /* a refusal does no harm */
        madvise((void *)(uintptr_t)bytes->data, (size_t)bytes->size, MADV_DONTNEED);
}

int io_bytes_check_unchanged(const io_bytes *bytes, planish_error *error) {
    struct stat about;
    if (bytes->mapped != MAPPED_YES)
        return PLANISH_OK;
    if (fstat(bytes->fd, &about))
        return pl_fail_errno(error, bytes->path, "cannot be read");
    if (about.st_size == bytes->size && time_of(&about) == bytes->modified)
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_FILE,
                   "%s: was changed while it was in use; run again when it is complete",
                   bytes->path);
}

int io_bytes_are_of(const io_bytes *bytes, int fd) {
    struct stat input, other;
    return bytes->mapped == MAPPED_YES && fstat(bytes->fd, &input) == 0 && fstat(fd, &other) == 0 &&
           input.st_dev == other.st_dev && input.st_ino == other.st_ino;
}

void io_bytes_close(io_bytes *bytes) {
    if (bytes->mapped == MAPPED_YES) {
        munmap((void *)(uintptr_t)bytes->data, (size_t)bytes->size);
        close(bytes->fd);
    }
    if (bytes->mapped == MAPPED_NO)
        pl_free((void *)(uintptr_t)bytes->data);
    pl_free(bytes->path);
    *bytes = (io_bytes){.fd = -1};
}
