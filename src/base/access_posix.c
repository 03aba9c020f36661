/* access: owners, modes, and (of Linux) access lists and extended attributes.
 *
 * The rights are given in one step, the last: until then the file is its owner's alone, as it was
 * created. Access lists are the bytes of an extended attribute, so that no library is needed.
 */
#include "base/access.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#ifdef __linux__
#include <sys/xattr.h>
#endif

enum { SPECIAL = S_ISUID | S_ISGID | S_ISVTX };

/** Owner and group: 1 where the new file has those of the file that it replaces. */
typedef struct kept {
    int owner, group;
} kept;

/** Only root may give a file away, and others a group that they are in: else it is as any new file.
 */
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

/** The mode of the old file. Members of its group are others now where the group is another, and
 * the new group's were: both may do what both might. */
static mode_t allowed_mode(mode_t old, kept k) {
    mode_t mode = old & (S_IRWXU | S_IRWXG | S_IRWXO | SPECIAL);
    if (!k.owner)
        mode &= (mode_t)~S_ISUID;
    if (k.group)
        return mode;
    const mode_t both = mode >> 3 & mode & S_IRWXO;
    return (mode & (S_IRWXU | S_ISUID | S_ISVTX)) | both << 3 | both;
}

#ifdef __linux__

/* ---- access lists: a version, and entries of a tag, rights and (of some) a number; little-endian
 */

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

/** Restrict an access list as allowed_mode does. Returns 0, or -1 if list is not an access list. */
static int restrict_list(unsigned char *list, ssize_t size) {
    unsigned char *group = find_rights(list, size, TAG_OWNING_GROUP);
    unsigned char *others = find_rights(list, size, TAG_OTHERS);
    if (!group || !others)
        return -1;
    *group = *others = *group & *others;
    return 0;
}

/** Give the file the access list of the one at path, and with it the mode. Not 0: that has none,
 * and the file has none; negative: it has one that cannot be kept. */
static int take_list(int fd, const char *path, kept k) {
    unsigned char *list = malloc(LONGEST_LIST);
    const ssize_t size = list ? getxattr(path, ACCESS_LIST, list, LONGEST_LIST) : -1;
    const int is_absent = list && size < 0 && (errno == ENODATA || errno == ENOTSUP);
    int status = -1;
    if (is_absent) /* the folder may have given it one */
        status =
            fremovexattr(fd, ACCESS_LIST) == 0 || errno == ENODATA || errno == ENOTSUP ? 1 : -1;
    else if (size > 0 && (k.group || restrict_list(list, size) == 0))
        status = fsetxattr(fd, ACCESS_LIST, list, (size_t)size, 0) ? -1 : 0;
    free(list);
    return status;
}

/* ---- extended attributes ----------------------------------------------------------------------
 */

/** Whether the attribute of this name belongs to the file's content or says who may see it.
 *  Capabilities of programs (security.capability) and sums over the old content do not. */
static int is_copied(const char *name) {
    static const char user[] = "user.";
    return strncmp(name, user, sizeof user - 1) == 0 || strcmp(name, "security.selinux") == 0;
}

static void copy_attribute(int fd, const char *path, const char *name) {
    const ssize_t room = getxattr(path, name, NULL, 0);
    char *value = room >= 0 ? malloc((size_t)room + 1) : NULL;
    const ssize_t size = value ? getxattr(path, name, value, (size_t)room) : -1;
    if (size >= 0 && fsetxattr(fd, name, value, (size_t)size, 0))
        errno = 0; /* a file system that has none, or has no room */
    free(value);
}

static void copy_attributes(int fd, const char *path) {
    const ssize_t room = listxattr(path, NULL, 0);
    char *names = room > 0 ? malloc((size_t)room) : NULL;
    const ssize_t size = names ? listxattr(path, names, (size_t)room) : 0;
    for (ssize_t at = 0; at < size; at += (ssize_t)strlen(names + at) + 1)
        if (is_copied(names + at))
            copy_attribute(fd, path, names + at);
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
    const mode_t mode = allowed_mode(old.st_mode, k);
    copy_attributes(fd, path);
    const int list = take_list(fd, path, k);
    if (list > 0)
        fchmod(fd, mode);
    else if (list < 0)
        fchmod(fd, mode & S_IRWXU);
    else if ((mode & SPECIAL) && fstat(fd, &now) == 0) /* with a list these bits are apart */
        fchmod(fd, (now.st_mode & ~(mode_t)SPECIAL) | (mode & SPECIAL));
}
