/* shim: a library to be preloaded that lets one call of a program to the system fail, once.
 *
 *   FAULT=CALL:N:WHAT  the N-th CALL (from 0) of the program, any of those below, fails with the
 *                      error number WHAT; or it is "short": it does the half of what it was asked
 *   FAULT_LOG=FILE     gets a line "CALL N LIBRARY" where the fault happened, in whose code it was,
 *                      and without FAULT, as the program ends, a line "CALL N -" for each CALL: how
 *                      many there were
 *
 *   PROTECTED_LINKS=1  stat and access refuse links of others in folders such as /tmp, as Linux
 *                      does with fs.protected_symlinks
 *
 * What happens before main and in the system's libraries without their names being looked up is not
 * counted. Linux with glibc.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

typedef enum call {
    MALLOC,
    CALLOC,
    REALLOC,
    ALIGNED_ALLOC,
    POSIX_MEMALIGN,
    MMAP,
    MADVISE,
    MUNMAP,
    OPEN,
    FOPEN,
    CLOSE,
    FCLOSE,
    READ,
    PREAD,
    FREAD,
    WRITE,
    PWRITE,
    FWRITE,
    FFLUSH,
    LSEEK,
    FTRUNCATE,
    FSYNC,
    RENAME,
    UNLINK,
    FSTAT,
    STAT,
    LSTAT,
    ACCESS,
    READLINK,
    CHMOD,
    FCHMOD,
    FCHOWN,
    FCNTL,
    FLOCK,
    PTHREAD_CREATE,
    N_CALLS
} call;

static const char *const names[N_CALLS] = {
    "malloc",   "calloc", "realloc", "aligned_alloc", "posix_memalign", "mmap",  "madvise",
    "munmap",   "open",   "fopen",   "close",         "fclose",         "read",  "pread",
    "fread",    "write",  "pwrite",  "fwrite",        "fflush",         "lseek", "ftruncate",
    "fsync",    "rename", "unlink",  "fstat",         "stat",           "lstat", "access",
    "readlink", "chmod",  "fchmod",  "fchown",        "fcntl",          "flock", "pthread_create"};

enum { DONE, FAILS, SHORT }; /* what becomes of a call */

static int links_are_protected;

static struct {
    int is_on, wanted, is_short, error_number;
    long number;
    const char *log;
    atomic_long count[N_CALLS];
} fault = {.wanted = -1};

/* ---- the fault ----------------------------------------------------------------------------- */

static void write_log(const char *name, long n, const char *library) {
    char line[512];
    const int length = snprintf(line, sizeof line, "%s %ld %s\n", name, n, library);
    const long fd = fault.log ? syscall(SYS_openat, AT_FDCWD, fault.log,
                                        O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600)
                              : -1;
    if (fd >= 0 && syscall(SYS_write, fd, line, length) == length)
        syscall(SYS_close, fd);
}

/** Where library code begins that address is in, or NULL; its file. */
static void *library_of(void *address, const char **file) {
    Dl_info about = {.dli_fname = "-"};
    void *base = dladdr(address, &about) ? about.dli_fbase : NULL;
    *file = about.dli_fname;
    return base;
}

/** The file of the innermost caller but this library and the C library, which calls for others. */
static const char *caller(void) {
    void *frame[64];
    const char *file = "-";
    void *own = library_of(&fault, &file), *system = library_of(dlsym(RTLD_NEXT, "abort"), &file);
    const int n = backtrace(frame, sizeof frame / sizeof *frame);
    for (int i = 0; i < n; i++) {
        void *library = library_of(frame[i], &file);
        if (library && library != own && library != system)
            return file;
    }
    return "-";
}

/** What is to become of this call; errno is set if it fails. */
static int meet(call c) {
    if (!fault.is_on || atomic_fetch_add(&fault.count[c], 1) != fault.number ||
        (int)c != fault.wanted)
        return DONE;
    fault.is_on = 0; /* there is no other */
    write_log(names[c], fault.number, caller());
    errno = fault.error_number;
    return fault.is_short ? SHORT : FAILS;
}

static int fails(call c) {
    return meet(c) == FAILS;
}

/** The bytes that a call that may be short is to ask for. */
static size_t half(int what, size_t bytes) {
    return what == SHORT && bytes > 1 ? bytes / 2 : bytes;
}

static void read_fault(void) {
    char text[64];
    links_are_protected = getenv("PROTECTED_LINKS") != NULL;
    const char *asked = getenv("FAULT");
    fault.log = getenv("FAULT_LOG");
    snprintf(text, sizeof text, "%s", asked ? asked : "");
    char *number = strchr(text, ':'), *what = number ? strchr(number + 1, ':') : NULL;
    if (!what)
        return;
    *number = *what = '\0';
    for (int c = 0; c < N_CALLS; c++)
        if (strcmp(names[c], text) == 0)
            fault.wanted = c;
    fault.number = strtol(number + 1, NULL, 10);
    fault.is_short = strcmp(what + 1, "short") == 0;
    fault.error_number = (int)strtol(what + 1, NULL, 10);
}

/* ---- links ---------------------------------------------------------------------------------- */

/** Where path has its last component, as text: the folder ends there. */
static size_t folder_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash + 1 - path) : 0;
}

/** Whether the link, whose state is about, is of somebody who might lay traps in its folder. */
static int is_trap(const char *path, const struct stat *about) {
    char folder[4096];
    struct stat place;
    const size_t length = folder_length(path);
    snprintf(folder, sizeof folder, "%.*s.", (int)length, path);
    return fstatat(AT_FDCWD, folder, &place, 0) == 0 && (place.st_mode & S_ISVTX) &&
           (place.st_mode & S_IWOTH) && about->st_uid != geteuid() && about->st_uid != place.st_uid;
}

/** Whether one of the links that path leads through, at its end, is not to be followed: then errno
 *  is set. */
static int is_refused(const char *path) {
    enum { MOST = 40 };
    char at[4096], link[4096];
    struct stat about;
    snprintf(at, sizeof at, "%s", path);
    for (int i = 0; links_are_protected && i < MOST; i++) {
        if (fstatat(AT_FDCWD, at, &about, AT_SYMLINK_NOFOLLOW) || !S_ISLNK(about.st_mode))
            return 0;
        if (is_trap(at, &about)) {
            errno = EACCES;
            return 1;
        }
        const ssize_t length = readlinkat(AT_FDCWD, at, link, sizeof link - 1);
        const size_t folder = link[0] == '/' ? 0 : folder_length(at);
        if (length < 0 || folder + (size_t)length >= sizeof at)
            return 0;
        memcpy(at + folder, link, (size_t)length);
        at[folder + (size_t)length] = '\0';
    }
    return 0;
}

/* ---- the beginning and the end --------------------------------------------------------------- */

static int (*real_main)(int, char **, char **);

static int main_with_faults(int argc, char **argv, char **environment) {
    void *frame[1];
    read_fault();
    backtrace(frame, 1);    /* what it needs is loaded now */
    unsetenv("LD_PRELOAD"); /* of what the program starts nothing is counted */
    fault.is_on = 1;
    return real_main(argc, argv, environment);
}

int __libc_start_main(int (*main)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*rtld_fini)(void), void *stack_end);
int __libc_start_main(int (*main)(int, char **, char **), int argc, char **argv, void (*init)(void),
                      void (*fini)(void), void (*rtld_fini)(void), void *stack_end) {
    int (*next)(int (*)(int, char **, char **), int, char **, void (*)(void), void (*)(void),
                void (*)(void), void *);
    *(void **)&next = dlsym(RTLD_NEXT, "__libc_start_main");
    real_main = main;
    return next(main_with_faults, argc, argv, init, fini, rtld_fini, stack_end);
}

__attribute__((destructor)) static void write_counts(void) {
    fault.is_on = 0;
    for (int c = 0; c < N_CALLS && fault.wanted < 0; c++)
        write_log(names[c], atomic_load(&fault.count[c]), "-");
}

/* ---- memory -------------------------------------------------------------------------------- */

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *block, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

void *malloc(size_t size) {
    return fails(MALLOC) ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size) {
    return fails(CALLOC) ? NULL : __libc_calloc(count, size);
}

void *realloc(void *block, size_t size) {
    return fails(REALLOC) ? NULL : __libc_realloc(block, size);
}

void *aligned_alloc(size_t alignment, size_t size) {
    return fails(ALIGNED_ALLOC) ? NULL : __libc_memalign(alignment, size);
}

int posix_memalign(void **block, size_t alignment, size_t size) {
    void *fresh = fails(POSIX_MEMALIGN) ? NULL : __libc_memalign(alignment, size);
    if (!fresh)
        return ENOMEM;
    *block = fresh;
    return 0;
}

void *mmap(void *at, size_t size, int protection, int flags, int fd, off_t offset) {
    return fails(MMAP) ? MAP_FAILED
                       : (void *)syscall(SYS_mmap, at, size, protection, flags, fd, offset);
}

int munmap(void *at, size_t size) {
    return fails(MUNMAP) ? -1 : (int)syscall(SYS_munmap, at, size);
}

int madvise(void *at, size_t size, int advice) {
    return fails(MADVISE) ? -1 : (int)syscall(SYS_madvise, at, size, advice);
}

int pthread_create(pthread_t *thread, const pthread_attr_t *attributes, void *(*start)(void *),
                   void *data) {
    int (*next)(pthread_t *, const pthread_attr_t *, void *(*)(void *), void *);
    *(void **)&next = dlsym(RTLD_NEXT, "pthread_create");
    return fails(PTHREAD_CREATE) ? EAGAIN : next(thread, attributes, start, data);
}

/* ---- descriptors --------------------------------------------------------------------------- */

static int open_at(int folder, const char *path, int flags, mode_t mode) {
    return fails(OPEN) ? -1 : (int)syscall(SYS_openat, folder, path, flags, mode);
}

static mode_t mode_of(int flags, va_list arguments) {
    return flags & (O_CREAT | __O_TMPFILE) ? va_arg(arguments, mode_t) : 0;
}

int open(const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return open_at(AT_FDCWD, path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = mode_of(flags, arguments);
    va_end(arguments);
    return open_at(folder, path, flags, mode);
}

/** The descriptor is closed all the same, as Linux does. */
int close(int fd) {
    const int what = meet(CLOSE), error_number = errno;
    const int status = (int)syscall(SYS_close, fd);
    if (what == DONE)
        return status;
    errno = error_number;
    return -1;
}

ssize_t read(int fd, void *to, size_t size) {
    const int what = meet(READ);
    return what == FAILS ? -1 : syscall(SYS_read, fd, to, half(what, size));
}

ssize_t pread(int fd, void *to, size_t size, off_t at) {
    const int what = meet(PREAD);
    return what == FAILS ? -1 : syscall(SYS_pread64, fd, to, half(what, size), at);
}

ssize_t write(int fd, const void *from, size_t size) {
    const int what = meet(WRITE);
    return what == FAILS ? -1 : syscall(SYS_write, fd, from, half(what, size));
}

ssize_t pwrite(int fd, const void *from, size_t size, off_t at) {
    const int what = meet(PWRITE);
    return what == FAILS ? -1 : syscall(SYS_pwrite64, fd, from, half(what, size), at);
}

off_t lseek(int fd, off_t offset, int whence) {
    return fails(LSEEK) ? -1 : syscall(SYS_lseek, fd, offset, whence);
}

int ftruncate(int fd, off_t size) {
    return fails(FTRUNCATE) ? -1 : (int)syscall(SYS_ftruncate, fd, size);
}

int fsync(int fd) {
    return fails(FSYNC) ? -1 : (int)syscall(SYS_fsync, fd);
}

int flock(int fd, int operation) {
    return fails(FLOCK) ? -1 : (int)syscall(SYS_flock, fd, operation);
}

int fcntl(int fd, int command, ...) {
    va_list arguments;
    va_start(arguments, command);
    const long argument = va_arg(arguments, long);
    va_end(arguments);
    return fails(FCNTL) ? -1 : (int)syscall(SYS_fcntl, fd, command, argument);
}

/* ---- names and modes ----------------------------------------------------------------------- */

int rename(const char *from, const char *to) {
    return fails(RENAME) ? -1 : renameat(AT_FDCWD, from, AT_FDCWD, to);
}

int unlink(const char *path) {
    return fails(UNLINK) ? -1 : unlinkat(AT_FDCWD, path, 0);
}

int fstat(int fd, struct stat *about) {
    return fails(FSTAT) ? -1 : fstatat(fd, "", about, AT_EMPTY_PATH);
}

int stat(const char *path, struct stat *about) {
    return fails(STAT) || is_refused(path) ? -1 : fstatat(AT_FDCWD, path, about, 0);
}

int lstat(const char *path, struct stat *about) {
    return fails(LSTAT) ? -1 : fstatat(AT_FDCWD, path, about, AT_SYMLINK_NOFOLLOW);
}

int access(const char *path, int mode) {
    return fails(ACCESS) || is_refused(path) ? -1 : faccessat(AT_FDCWD, path, mode, 0);
}

ssize_t readlink(const char *path, char *text, size_t size) {
    return fails(READLINK) ? -1 : readlinkat(AT_FDCWD, path, text, size);
}

int chmod(const char *path, mode_t mode) {
    return fails(CHMOD) ? -1 : fchmodat(AT_FDCWD, path, mode, 0);
}

int fchmod(int fd, mode_t mode) {
    return fails(FCHMOD) ? -1 : (int)syscall(SYS_fchmod, fd, mode);
}

int fchown(int fd, uid_t user, gid_t group) {
    return fails(FCHOWN) ? -1 : (int)syscall(SYS_fchown, fd, user, group);
}

/* ---- streams ------------------------------------------------------------------------------- */

FILE *fopen(const char *path, const char *mode) {
    FILE *(*next)(const char *, const char *);
    *(void **)&next = dlsym(RTLD_NEXT, "fopen");
    return fails(FOPEN) ? NULL : next(path, mode);
}

int fclose(FILE *stream) {
    int (*next)(FILE *);
    *(void **)&next = dlsym(RTLD_NEXT, "fclose");
    const int what = meet(FCLOSE), error_number = errno, status = next(stream);
    if (what == DONE)
        return status;
    errno = error_number;
    return EOF;
}

/** The bit that ferror tells of. */
static void set_error(FILE *stream) {
    stream->_flags |= 0x20; /* _IO_ERR_SEEN */
}

size_t fread(void *to, size_t size, size_t count, FILE *stream) {
    size_t (*next)(void *, size_t, size_t, FILE *);
    *(void **)&next = dlsym(RTLD_NEXT, "fread");
    const int what = meet(FREAD);
    if (what == FAILS)
        set_error(stream);
    return what == FAILS ? 0 : next(to, size, half(what, count), stream);
}

size_t fwrite(const void *from, size_t size, size_t count, FILE *stream) {
    size_t (*next)(const void *, size_t, size_t, FILE *);
    *(void **)&next = dlsym(RTLD_NEXT, "fwrite");
    const int what = meet(FWRITE);
    if (what != DONE) /* half of it is written, and then the device is full */
        set_error(stream);
    return what == FAILS ? 0 : next(from, size, half(what, count), stream);
}

int fflush(FILE *stream) {
    int (*next)(FILE *);
    *(void **)&next = dlsym(RTLD_NEXT, "fflush");
    const int what = meet(FFLUSH);
    if (what == FAILS && stream)
        set_error(stream);
    return what == FAILS ? EOF : next(stream);
}
