/* output: the places that the program writes to. */
#include "output.h"

#include "message.h"
#include "signals.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

int pl_output_is_stream(const char *path) {
    struct stat status;
    return stat(path, &status) == 0 && !S_ISREG(status.st_mode) && !S_ISDIR(status.st_mode);
}

static int same_inode(const struct stat *a, const struct stat *b) {
    return a->st_dev == b->st_dev && a->st_ino == b->st_ino;
}

int pl_output_is_stdout(const char *path) {
    struct stat named, standard;
    if (strcmp(path, "/dev/stdout") == 0)
        return 1;
    return stat(path, &named) == 0 && fstat(STDOUT_FILENO, &standard) == 0 &&
           !S_ISCHR(named.st_mode) && same_inode(&named, &standard);
}

int pl_output_same_file(const char *a, const char *b) {
    struct stat status_a, status_b;
    if (strcmp(a, b) == 0)
        return 1;
    return stat(a, &status_a) == 0 && stat(b, &status_b) == 0 && S_ISREG(status_a.st_mode) &&
           same_inode(&status_a, &status_b);
}

int pl_output_hits_mesh(const char *path, const char *mesh_path) {
    static const char *const parts[] = {".node", ".ele", ".face", ".edge"};
    enum { N_PARTS = sizeof parts / sizeof *parts };
    if (pl_output_same_file(path, mesh_path))
        return 1;
    const char *dot = strrchr(mesh_path, '.');
    int is_part = 0, hit = 0;
    for (int i = 0; dot && i < N_PARTS; i++)
        is_part |= strcmp(dot, parts[i]) == 0;
    for (int i = 0; is_part && i < N_PARTS; i++) {
        char other[PATH_MAX];
        const int size =
            snprintf(other, sizeof other, "%.*s%s", (int)(dot - mesh_path), mesh_path, parts[i]);
        hit |= size > 0 && (size_t)size < sizeof other && pl_output_same_file(path, other);
    }
    return hit;
}

/** The folder that path is in, to be freed; NULL without memory. */
static char *folder_of(const char *path) {
    const char *slash = strrchr(path, '/');
    if (!slash)
        return strdup(".");
    return slash == path ? strdup("/") : strndup(path, (size_t)(slash - path));
}

int pl_output_check(const char *path) {
    struct stat status;
    const int exists = stat(path, &status) == 0;
    if (exists && S_ISDIR(status.st_mode))
        return pl_complain(PL_EXIT_FAILED, "%s: is a folder; name a file in it", path);
    if (exists && !S_ISREG(status.st_mode))
        return 0;
    if (path[0] && path[strlen(path) - 1] == '/')
        return pl_complain(PL_EXIT_FAILED, "%s: is no name for a file", path);
    char *target = exists ? realpath(path, NULL) : strdup(path);
    char *folder = target ? folder_of(target) : NULL;
    int result = 0;
    if (!folder)
        result = pl_complain(PL_EXIT_FAILED, "%s: %s", path, strerror(errno));
    else if (access(folder, W_OK | X_OK) != 0)
        result = pl_complain(PL_EXIT_FAILED, "%s: cannot be written, as its folder is: %s", path,
                             strerror(errno));
    free(folder);
    free(target);
    return result;
}

/** Write and close; 0 or errno. */
static int write_and_close(int descriptor, const char *text, size_t length) {
    int failure = 0;
    while (length > 0 && !failure) {
        const ssize_t written = write(descriptor, text, length);
        if (written >= 0) {
            text += written;
            length -= (size_t)written;
        } else if (errno != EINTR) {
            failure = errno;
        }
    }
    if (close(descriptor) != 0 && !failure)
        failure = errno;
    return failure;
}

static int write_directly(const char *path, const char *text, size_t length) {
    const int descriptor = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    return descriptor < 0 ? errno : write_and_close(descriptor, text, length);
}

static int write_and_rename(const char *target, const struct stat *replaced, const char *text,
                            size_t length) {
    char temporary[PL_TEMPORARY_SIZE];
    const int size =
        snprintf(temporary, sizeof temporary, "%s.planish-%ld", target, (long)getpid());
    if (size < 0 || (size_t)size + 2 > sizeof temporary) /* two: the list's end behind it */
        return ENAMETOOLONG;
    const int descriptor = open(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor < 0)
        return errno;
    char *shown = pl_signals_temporary(PL_TEMPORARY_REPORT);
    memcpy(shown + 1, temporary + 1, (size_t)size);
    shown[0] = temporary[0]; /* last: until now the list is empty */
    if (replaced)
        (void)fchmod(descriptor, replaced->st_mode & 07777);
    int failure = write_and_close(descriptor, text, length);
    if (!failure && rename(temporary, target) != 0)
        failure = errno;
    if (failure)
        unlink(temporary);
    shown[0] = '\0';
    return failure;
}

int pl_output_write_text(const char *path, const char *text, size_t length) {
    struct stat status;
    if (strcmp(path, "-") == 0) {
        errno = 0;
        return fwrite(text, 1, length, stdout) == length && fflush(stdout) == 0 ? 0 : errno;
    }
    const int exists = stat(path, &status) == 0;
    const int is_link = !exists && lstat(path, &status) == 0;
    if (is_link || (exists && !S_ISREG(status.st_mode)))
        return write_directly(path, text, length);
    char *target = exists ? realpath(path, NULL) : strdup(path);
    if (!target)
        return errno;
    const int failure = write_and_rename(target, exists ? &status : NULL, text, length);
    free(target);
    return failure;
}
