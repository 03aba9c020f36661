/* system: as POSIX has it. */
#include "base/system.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/xattr.h>
#endif

void *pl_system_allocate(size_t alignment, size_t bytes) {
    return aligned_alloc(alignment, bytes);
}

void pl_system_release(void *start) {
    free(start);
}

static uintptr_t round_up(uintptr_t place, uintptr_t unit) {
    return (place + unit - 1) / unit * unit;
}

void *pl_system_reserve(size_t bytes) {
    const size_t size = round_up(bytes, PL_HUGE_PAGE);
    if (size < bytes || size > SIZE_MAX - PL_HUGE_PAGE)
        return NULL;
    char *start =
        mmap(NULL, size + PL_HUGE_PAGE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (start == MAP_FAILED)
        return NULL;
    const size_t before = round_up((uintptr_t)start, PL_HUGE_PAGE) - (uintptr_t)start;
    if (before > 0)
        munmap(start, before);
    munmap(start + before + size, PL_HUGE_PAGE - before);
    return start + before;
}

void pl_system_unreserve(void *start, size_t bytes) {
    munmap(start, round_up(bytes, PL_HUGE_PAGE));
}

/** Say how a stretch of whole pages of that size within so many bytes will be used. */
static void advise(void *begin, size_t bytes, uintptr_t page, int advice) {
    const uintptr_t first = round_up((uintptr_t)begin, page);
    const uintptr_t end = ((uintptr_t)begin + bytes) / page * page;
    if (end > first)
        madvise((void *)first, end - first, advice);
}

void pl_system_want_huge_pages(void *begin, size_t bytes) {
#ifdef MADV_HUGEPAGE
    advise(begin, bytes, PL_HUGE_PAGE, MADV_HUGEPAGE);
#else
    (void)begin;
    (void)bytes;
#endif
}

void pl_system_discard(void *begin, size_t bytes) {
    advise(begin, bytes, (uintptr_t)sysconf(_SC_PAGESIZE), MADV_DONTNEED);
}

/* The C library may be older than the kernel, which may refuse what it does not know. */
#if defined(__linux__) && !defined(MADV_POPULATE_WRITE)
#define MADV_POPULATE_WRITE 23
#endif

#ifdef MADV_POPULATE_WRITE
void pl_system_populate(void *begin, size_t bytes) {
    enum { MANY = 1 << 16 }; /* bytes of pages */
    if (bytes >= MANY)
        advise(begin, bytes, (uintptr_t)sysconf(_SC_PAGESIZE), MADV_POPULATE_WRITE);
}
#else
void pl_system_populate(void *begin, size_t bytes) {
    (void)begin;
    (void)bytes;
}
#endif

int64_t pl_system_memory(void) {
    const int64_t pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? pages * size : INT64_MAX;
}

/* ---- names of files ------------------------------------------------------------------------- */

int pl_path_is_separator(char c) {
    return c == '/';
}

const char *pl_path_name(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

int pl_path_is_absolute(const char *path) {
    return path[0] == '/';
}

int pl_path_read_link(const char *path, char *text, size_t size) {
    const ssize_t length = readlink(path, text, size - 1);
    if (length >= 0)
        text[length] = '\0';
    return length >= 0 ? 0 : -1;
}

char *pl_path_resolve(const char *path) {
    return realpath(path, NULL);
}

int pl_folder_check_writable(const char *path) {
    return access(path, W_OK | X_OK);
}

int pl_folder_create(const char *path) {
    return mkdir(path, 0777);
}

int pl_folder_list(const char *path, pl_folder_take *take, void *user) {
    DIR *folder = opendir(path);
    const struct dirent *entry;
    if (!folder)
        return -1;
    errno = 0;
    while ((entry = readdir(folder)) != NULL) {
        const char *name = entry->d_name;
        if (strcmp(name, ".") != 0 && strcmp(name, "..") != 0 && take(user, name))
            break;
        errno = 0;
    }
    const int reason = entry ? 0 : errno; /* of readdir */
    closedir(folder);
    errno = reason;
    return reason ? -1 : 0;
}

/* ---- files ---------------------------------------------------------------------------------- */

static pl_file_status status_of(const struct stat *about) {
    return (pl_file_status){.kind = S_ISREG(about->st_mode)   ? PL_FILE_REGULAR
                                    : S_ISDIR(about->st_mode) ? PL_FILE_FOLDER
                                    : S_ISCHR(about->st_mode) ? PL_FILE_CHARACTERS
                                                              : PL_FILE_STREAM,
                            .size = about->st_size,
                            .modified = (int64_t)about->st_mtim.tv_sec * 1000000000 +
                                        about->st_mtim.tv_nsec,
                            .device = about->st_dev,
                            .number = about->st_ino};
}

int pl_file_find(const char *path, pl_file_status *status) {
    struct stat about;
    if (stat(path, &about))
        return -1;
    *status = status_of(&about);
    return 0;
}

int pl_file_find_open(int fd, pl_file_status *status) {
    struct stat about;
    if (fstat(fd, &about))
        return -1;
    *status = status_of(&about);
    return 0;
}

int pl_file_exists(const char *path) {
    return access(path, F_OK) == 0;
}

int pl_file_is_same(const pl_file_status *a, const pl_file_status *b) {
    return a->device == b->device && a->number == b->number;
}

int pl_file_open(const char *path, pl_file_use use) {
    static const int flags[] = {[PL_FILE_READ] = O_RDONLY,
                                [PL_FILE_WRITE] = O_WRONLY,
                                [PL_FILE_REWRITE] = O_WRONLY | O_TRUNC,
                                [PL_FILE_CREATE] = O_WRONLY | O_CREAT | O_EXCL,
                                [PL_FILE_CREATE_PRIVATE] = O_WRONLY | O_CREAT | O_EXCL};
    int fd;
    do
        fd = open(path, flags[use] | O_CLOEXEC, use == PL_FILE_CREATE ? 0666 : 0600);
    while (fd < 0 && errno == EINTR);
    return fd;
}

/** Close a descriptor. Interrupted, it is closed all the same: again would be another file by now.
 */
int pl_file_close(int fd) {
    return close(fd) && errno != EINTR ? -1 : 0;
}

int pl_file_open_is_replaceable(void) {
    return 1;
}

int pl_file_duplicate(int fd) {
    return fcntl(fd, F_DUPFD_CLOEXEC, 0);
}

const char *pl_file_map(int fd, int64_t size) {
    if ((uint64_t)size > SIZE_MAX) {
        errno = ENOMEM;
        return NULL;
    }
    void *data = mmap(NULL, (size_t)size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (data == MAP_FAILED)
        return NULL;
    madvise(data, (size_t)size, MADV_SEQUENTIAL);
    return data;
}

void pl_file_unmap(const char *data, int64_t size) {
    munmap((void *)(uintptr_t)data, (size_t)size);
}

void pl_file_rest(const char *data, int64_t size) {
    madvise((void *)(uintptr_t)data, (size_t)size, MADV_DONTNEED); /* a refusal does no harm */
}

/** EINVAL: this file system knows no such thing. */
int pl_file_sync(int fd) {
    int status;
    do
        status = fsync(fd);
    while (status && errno == EINTR);
    return status && errno != EINVAL;
}

int pl_file_make_accessible(const char *path) {
    const mode_t wanted = S_IRUSR | S_IWUSR;
    struct stat about;
    if (stat(path, &about) || (about.st_mode & wanted) == wanted)
        return -1;
    const mode_t mode = about.st_mode & 07777;
    return chmod(path, mode | wanted) ? -1 : (int)mode;
}

void pl_file_set_mode(const char *path, int mode) {
    chmod(path, (mode_t)mode);
}

int pl_file_replace(const char *from, const char *to) {
    return rename(from, to);
}

/** Linux says EISDIR of a folder, POSIX EPERM. */
int pl_file_remove(const char *path) {
    if (unlink(path) == 0)
        return 0;
    return errno == EISDIR || errno == EPERM ? rmdir(path) : -1;
}

/* ---- owners, modes, and (of Linux) access lists and extended attributes -----------------------
 *
 * The rights are given in one step, the last: until then the file is its owner's alone, as it was
 * created. Access lists are the bytes of an extended attribute, so that no library is needed. */

enum { SPECIAL = S_ISUID | S_ISGID | S_ISVTX };

/** Owner and group: 1 where the new file has those of the file that it replaces. */
typedef struct kept {
    int owner, group;
} kept;

/** Take owner and group of the old file. Only root may give a file away, and others a group that
 *  they are in: else it is as any new file. */
static kept take_owner(int fd, const struct stat *old) {
    struct stat now;
    if (fstat(fd, &now))
        return (kept){0, 0};
    if (now.st_uid != old->st_uid || now.st_gid != old->st_gid)
        if (fchown(fd, old->st_uid, old->st_gid) && fchown(fd, (uid_t)-1, old->st_gid))
            errno = 0; /* what is left is seen below */
    if (fstat(fd, &now))
        return (kept){0, 0};
    return (kept){now.st_uid == old->st_uid, now.st_gid == old->st_gid};
}

#ifdef __linux__

/* Access lists: a version, and entries of a tag, rights and (of some) a number; little-endian. */
#define ACCESS_LIST "system.posix_acl_access"

enum {
    LIST_HEADER = 4,
    LIST_ENTRY = 8,
    RIGHTS_AT = 2,          /* in an entry, behind its tag */
    LONGEST_LIST = 1 << 16, /* as the kernel has it */
    TAG_OWNING_GROUP = 0x04,
    TAG_OTHERS = 0x20
};

/** The rights in the entry with that tag; NULL: there is none. */
static unsigned char *find_rights(unsigned char *list, ssize_t size, int tag) {
    for (ssize_t at = LIST_HEADER; at + LIST_ENTRY <= size; at += LIST_ENTRY)
        if ((list[at] | list[at + 1] << 8) == tag)
            return list + at + RIGHTS_AT;
    return NULL;
}

/** Give the file the access list of the one at path, and with it the mode. Not 0: that has none,
 * and the file has none; negative: it has one that cannot be kept. */
static int take_list(int fd, const char *path, kept k) {
    unsigned char *list = malloc(LONGEST_LIST);
    const ssize_t size = list ? getxattr(path, ACCESS_LIST, list, LONGEST_LIST) : -1;
    const int is_absent = list && size < 0 && (errno == ENODATA || errno == ENOTSUP);
    int status = -1;
    if (is_absent) { /* the folder may have given it one */
        status =
            fremovexattr(fd, ACCESS_LIST) == 0 || errno == ENODATA || errno == ENOTSUP ? 1 : -1;
    } else if (size > 0) {
        unsigned char *group = find_rights(list, size, TAG_OWNING_GROUP);
        unsigned char *others = find_rights(list, size, TAG_OTHERS);
        if (!k.group && group && others) /* as in pl_file_take_access */
            *group = *others = *group & *others;
        if (k.group || (group && others))
            status = fsetxattr(fd, ACCESS_LIST, list, (size_t)size, 0) ? -1 : 0;
    }
    free(list);
    return status;
}

/** Copy the attributes that belong to the file's content or say who may see it. Capabilities of
 *  programs (security.capability) and sums over the old content do not. */
static void copy_attributes(int fd, const char *path) {
    const ssize_t room = listxattr(path, NULL, 0);
    char *names = room > 0 ? malloc((size_t)room) : NULL;
    const ssize_t n = names ? listxattr(path, names, (size_t)room) : 0;
    for (ssize_t at = 0; at < n; at += (ssize_t)strlen(names + at) + 1) {
        const char *name = names + at;
        if (strncmp(name, "user.", 5) != 0 && strcmp(name, "security.selinux") != 0)
            continue;
        const ssize_t longest = getxattr(path, name, NULL, 0);
        char *value = longest >= 0 ? malloc((size_t)longest + 1) : NULL;
        const ssize_t size = value ? getxattr(path, name, value, (size_t)longest) : -1;
        if (size >= 0 && fsetxattr(fd, name, value, (size_t)size, 0))
            errno = 0; /* a file system that has none, or has no room */
        free(value);
    }
    free(names);
}

#else

static int take_list(int fd, const char *path, kept k) {
    (void)fd;
    (void)path;
    (void)k;
    return 1;
}

static void copy_attributes(int fd, const char *path) {
    (void)fd;
    (void)path;
}

#endif

void pl_file_take_access(int fd, const char *path) {
    struct stat old, now;
    if (stat(path, &old))
        return;
    const kept k = take_owner(fd, &old);
    mode_t mode = old.st_mode & (S_IRWXU | S_IRWXG | S_IRWXO | SPECIAL);
    if (!k.owner)
        mode &= (mode_t)~S_ISUID;
    if (!k.group) {
        /* Members of the old file's group are others now, and the new group's were: both may do
         * what both might. */
        const mode_t both = mode >> 3 & mode & S_IRWXO;
        mode = (mode & (S_IRWXU | S_ISUID | S_ISVTX)) | both << 3 | both;
    }
    copy_attributes(fd, path);
    const int list = take_list(fd, path, k);
    if (list > 0)
        fchmod(fd, mode);
    else if (list < 0)
        fchmod(fd, mode & S_IRWXU);
    else if ((mode & SPECIAL) && fstat(fd, &now) == 0) /* with a list these bits are apart */
        fchmod(fd, (now.st_mode & ~(mode_t)SPECIAL) | (mode & SPECIAL));
}

/* ---- errors, and this process --------------------------------------------------------------- */

void pl_system_explain(int number, char *text, size_t size) {
    if (strerror_r(number, text, size) != 0)
        snprintf(text, size, "error %d of the system", number);
}

long pl_process_number(void) {
    return getpid();
}
