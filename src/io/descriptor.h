/* descriptor: the system's calls for open files that a signal may interrupt, made again until they
 * are through. */
#ifndef PL_IO_DESCRIPTOR_H
#define PL_IO_DESCRIPTOR_H

#include <errno.h>
#include <fcntl.h>
#include <unistd.h>

static inline int io_descriptor_open(const char *path, int flags, mode_t mode) {
    int fd;
    do
        fd = open(path, flags | O_CLOEXEC, mode);
    while (fd < 0 && errno == EINTR);
    return fd;
}

static inline int io_descriptor_sync(int fd) {
    int status;
    do
        status = fsync(fd);
    while (status && errno == EINTR);
    return status;
}

/** Interrupted, it is closed all the same: again would be another file by now. */
static inline int io_descriptor_close(int fd) {
    return close(fd) && errno != EINTR ? -1 : 0;
}

#endif
