/* system: operating-system services: memory, files and their names. Either system_posix.c or
 * system_windows.c is built; tools/terminal/platform.h has the services that only the program
 * needs.
 *
 * Paths are UTF-8 on Windows and bytes elsewhere. Files are descriptors of the C library, for its
 * read, write and close. A function that fails sets errno.
 *
 *   pl_system_allocate, _reserve, _discard, _memory ...    memory and its pages
 *   pl_path_*, pl_folder_check_writable                    names
 *   pl_folder_create, pl_folder_list                       folders
 *   pl_file_find, _open, _map, _replace, _remove ...       files
 *   pl_file_take_access                                    permissions of a file that is replaced
 *   pl_system_explain, pl_process_number                   errors, and this process
 */
#ifndef PL_BASE_SYSTEM_H
#define PL_BASE_SYSTEM_H

#include <stddef.h>
#include <stdint.h>

/* ---- memory --------------------------------------------------------------------------------- */

/** Allocate bytes, a multiple of alignment; NULL: there are none. Released by pl_system_release
 * alone. */
void *pl_system_allocate(size_t alignment, size_t bytes);

/** Release memory of pl_system_allocate; start may be NULL. */
void pl_system_release(void *start);

enum { PL_HUGE_PAGE = 1 << 21 };

/** Reserve bytes of pages of their own, from a multiple of PL_HUGE_PAGE on. No page is resident
 *  before it is written. NULL if the system refuses. */
void *pl_system_reserve(size_t bytes);

/** Release bytes of pages of pl_system_reserve. */
void pl_system_unreserve(void *start, size_t bytes);

/** Ask for huge pages where there is room for them within so many bytes; and give whole pages among
 *  them back, whose content nobody will read again. A refusal does no harm. */
void pl_system_want_huge_pages(void *begin, size_t bytes);

/** Give back whole pages whose content nobody will read again. */
void pl_system_discard(void *begin, size_t bytes);

/** Make the whole pages within so many bytes, 64 kB or more of which most will be written,
 * resident: at once that takes less time than one after the other, on virtual machines much less.
 * What they hold stays. A refusal does no harm. */
void pl_system_populate(void *begin, size_t bytes);

/** Bytes of memory that the machine has; INT64_MAX: not known. */
int64_t pl_system_memory(void);

/* ---- names of files ------------------------------------------------------------------------- */

/** Whether c ends the name of a folder in a path. */
int pl_path_is_separator(char c);

/** The part of path behind its folder; all of it if it has none. */
const char *pl_path_name(const char *path);

/** Whether path begins at a root, not at the present folder. */
int pl_path_is_absolute(const char *path);

/** The path that the link at path leads to, in text [size] with its '\0'; -1: it is no link. */
int pl_path_read_link(const char *path, char *text, size_t size);

/** Return path without links, from the root; to be freed, or NULL. */
char *pl_path_resolve(const char *path);

/** Whether files can be made in the folder at path: 0, or not 0 and errno. */
int pl_folder_check_writable(const char *path);

/** Make a folder where nothing is yet (else EEXIST): 0, or not 0 and errno. pl_file_remove removes
 *  it. */
int pl_folder_create(const char *path);

/** Take the name of an entry of a folder. Not 0: take no more. */
typedef int pl_folder_take(void *user, const char *name);

/** Call take for each entry of the folder at path, in any order, but not for the folder itself and
 *  the one around it: 0, or not 0 and errno. */
int pl_folder_list(const char *path, pl_folder_take *take, void *user);

/* ---- files ---------------------------------------------------------------------------------- */

typedef enum pl_file_kind {
    PL_FILE_REGULAR,
    PL_FILE_FOLDER,
    PL_FILE_CHARACTERS, /* a terminal, or a device such as /dev/null */
    PL_FILE_STREAM      /* a pipe, and all else that has no size */
} pl_file_kind;

typedef struct pl_file_status {
    pl_file_kind kind;
    int64_t size;            /* in bytes */
    int64_t modified;        /* when it was last written to, in ns */
    uint64_t device, number; /* both together are of one file alone */
} pl_file_status;

/** Find the status of the file at path, links followed, or of an open one. Returns 0, or not 0
 *  and errno. */
int pl_file_find(const char *path, pl_file_status *status);

/** Find the status of an open file, as pl_file_find does. */
int pl_file_find_open(int fd, pl_file_status *status);

/** Whether there is something at path, links followed. */
int pl_file_exists(const char *path);

/** Whether both are of one file. */
int pl_file_is_same(const pl_file_status *a, const pl_file_status *b);

typedef enum pl_file_use {
    PL_FILE_READ,
    PL_FILE_WRITE,         /* a file that exists */
    PL_FILE_REWRITE,       /* the same, emptied first */
    PL_FILE_CREATE,        /* one that does not (else EEXIST), as open for others as any new one */
    PL_FILE_CREATE_PRIVATE /* for nobody else */
} pl_file_use;

/** Open a file: a descriptor that started programs do not inherit, or -1. Signals do not interrupt
 *  it. */
int pl_file_open(const char *path, pl_file_use use);

/** Close a descriptor. Returns 0, or errno. */
int pl_file_close(int fd);

/** Whether a file that is open can be replaced by another one. */
int pl_file_open_is_replaceable(void);

/** Return another descriptor of the file open as fd, or -1. */
int pl_file_duplicate(int fd);

/** The size bytes of a regular file, which will be read in their order; NULL: it cannot be mapped,
 *  with errno ENOSYS where no file can, as one that is mapped could not be replaced. */
const char *pl_file_map(int fd, int64_t size);

/** Unmap a file of pl_file_map. */
void pl_file_unmap(const char *data, int64_t size);

/** Say that a mapped file will not be read for some time: it need not be in memory until then. */
void pl_file_rest(const char *data, int64_t size);

/** Wait until written bytes are on the disk, if the file system can tell: 0, or errno. */
int pl_file_sync(int fd);

/** Allow to read and write the file at path: what it was before, for pl_file_set_mode; -1: nothing
 * is to do, or can be done. */
int pl_file_make_accessible(const char *path);

/** Set the mode of the file at path to the result of pl_file_make_accessible. */
void pl_file_set_mode(const char *path, int mode);

/** Give the file at from the name to, in one step, whether or not there is one. 0, or errno. */
int pl_file_replace(const char *from, const char *to);

/** Remove a file or an empty folder; a signal handler may. */
int pl_file_remove(const char *path);

/** Give an open file, which nobody else may read yet, the owner, mode, access list and extended
 *  attributes (user.*) of the file at path, as far as the system allows. Where it cannot have the
 *  owner's group, neither the new group nor all others get a right that both classes did not have;
 *  where it cannot have the access list, it stays its owner's alone. */
void pl_file_take_access(int fd, const char *path);

/** Write the meaning of an errno to text [size]. strerror's own text may be another thread's by
 *  now. */
void pl_system_explain(int number, char *text, size_t size);

/** Return a number that no other running process has. */
long pl_process_number(void);

#endif
