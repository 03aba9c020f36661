/* system: as Windows has it, by the wide functions of its API; names are UTF-8 outside. Modes and
 * owners of files stay what the folder gives to them. */
#include "base/system.h"

#include <errno.h>
#include <fcntl.h>
#include <io.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <windows.h>

void *pl_system_allocate(size_t alignment, size_t bytes) {
    return _aligned_malloc(bytes, alignment);
}

void pl_system_release(void *start) {
    _aligned_free(start);
}

void *pl_system_reserve(size_t bytes) {
    (void)bytes;
    return NULL;
}

void pl_system_unreserve(void *start, size_t bytes) {
    (void)start;
    (void)bytes;
}

void pl_system_want_huge_pages(void *begin, size_t bytes) {
    (void)begin;
    (void)bytes;
}

void pl_system_discard(void *begin, size_t bytes) {
    (void)begin;
    (void)bytes;
}

void pl_system_populate(void *begin, size_t bytes) {
    (void)begin;
    (void)bytes;
}

int64_t pl_system_memory(void) {
    MEMORYSTATUSEX status = {.dwLength = sizeof status};
    return GlobalMemoryStatusEx(&status) ? (int64_t)status.ullTotalPhys : INT64_MAX;
}

/** Set errno from GetLastError; returns -1. */
static int fail(void) {
    switch (GetLastError()) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
    case ERROR_INVALID_NAME:
    case ERROR_BAD_PATHNAME:
        errno = ENOENT;
        break;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS:
        errno = EEXIST;
        break;
    case ERROR_ACCESS_DENIED:
    case ERROR_SHARING_VIOLATION:
    case ERROR_WRITE_PROTECT:
        errno = EACCES;
        break;
    case ERROR_NOT_ENOUGH_MEMORY:
    case ERROR_OUTOFMEMORY:
        errno = ENOMEM;
        break;
    case ERROR_FILENAME_EXCED_RANGE:
        errno = ENAMETOOLONG;
        break;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL:
        errno = ENOSPC;
        break;
    default:
        errno = EIO;
    }
    return -1;
}

/** UTF-8 as Windows writes it, to be freed; NULL and errno. */
static wchar_t *wide_of(const char *text) {
    const int size = MultiByteToWideChar(CP_UTF8, 0, text, -1, NULL, 0);
    wchar_t *wide = malloc((size_t)size * sizeof *wide);
    if (wide)
        MultiByteToWideChar(CP_UTF8, 0, text, -1, wide, size);
    else
        errno = ENOMEM;
    return wide;
}

/* ---- names of files ------------------------------------------------------------------------- */

int pl_path_is_separator(char c) {
    return c == '/' || c == '\\';
}

const char *pl_path_name(const char *path) {
    const char *name = path[0] && path[1] == ':' ? path + 2 : path; /* behind the drive */
    for (const char *c = name; *c; c++)
        if (pl_path_is_separator(*c))
            name = c + 1;
    return name;
}

int pl_path_is_absolute(const char *path) {
    return pl_path_is_separator(path[0]) || (path[0] && path[1] == ':');
}

/** Links are rare here, and those to files lead to nothing that could not be replaced. */
int pl_path_read_link(const char *path, char *text, size_t size) {
    (void)path;
    (void)text;
    (void)size;
    errno = EINVAL;
    return -1;
}

char *pl_path_resolve(const char *path) {
    wchar_t *name = wide_of(path), *full = name ? _wfullpath(NULL, name, 0) : NULL;
    const int size = full ? WideCharToMultiByte(CP_UTF8, 0, full, -1, NULL, 0, NULL, NULL) : 0;
    char *text = full ? malloc((size_t)size) : NULL;
    if (text)
        WideCharToMultiByte(CP_UTF8, 0, full, -1, text, size, NULL, NULL);
    free(full);
    free(name);
    return text;
}

/** Who may write where is not asked here in advance: only whether there is such a folder. */
int pl_folder_check_writable(const char *path) {
    pl_file_status status;
    if (pl_file_find(path, &status))
        return -1;
    errno = ENOTDIR;
    return status.kind != PL_FILE_FOLDER;
}

int pl_folder_create(const char *path) {
    wchar_t *name = wide_of(path);
    const int result = name && CreateDirectoryW(name, NULL) ? 0 : fail();
    free(name);
    return result;
}

/** The pattern that finds all entries of the folder at path; to be freed, or NULL and errno. */
static wchar_t *pattern_of(const char *path) {
    static const char all[] = "/*";
    char *text = malloc(strlen(path) + sizeof all);
    if (!text) {
        errno = ENOMEM;
        return NULL;
    }
    strcpy(text, path);
    strcat(text, all);
    wchar_t *pattern = wide_of(text);
    free(text);
    return pattern;
}

int pl_folder_list(const char *path, pl_folder_take *take, void *user) {
    enum { BYTES_A_LETTER = 4 };
    char name[MAX_PATH * BYTES_A_LETTER];
    WIN32_FIND_DATAW entry;
    wchar_t *pattern = pattern_of(path);
    HANDLE folder = pattern ? FindFirstFileW(pattern, &entry) : INVALID_HANDLE_VALUE;
    free(pattern);
    if (folder == INVALID_HANDLE_VALUE)
        return fail();
    do {
        WideCharToMultiByte(CP_UTF8, 0, entry.cFileName, -1, name, sizeof name, NULL, NULL);
        if (strcmp(name, ".") != 0 && strcmp(name, "..") != 0 && take(user, name))
            break;
    } while (FindNextFileW(folder, &entry));
    FindClose(folder);
    return 0;
}

/* ---- files ---------------------------------------------------------------------------------- */

static uint64_t both(DWORD high, DWORD low) {
    return (uint64_t)high << 32 | low;
}

static int find(HANDLE file, pl_file_status *status) {
    BY_HANDLE_FILE_INFORMATION about;
    const DWORD type = GetFileType(file);
    *status = (pl_file_status){.kind = type == FILE_TYPE_CHAR ? PL_FILE_CHARACTERS : PL_FILE_STREAM,
                               .number = (uintptr_t)file};
    if (type != FILE_TYPE_DISK)
        return 0;
    if (!GetFileInformationByHandle(file, &about))
        return fail();
    enum { UNIT_NS = 100 };
    const FILETIME written = about.ftLastWriteTime;
    status->kind =
        about.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY ? PL_FILE_FOLDER : PL_FILE_REGULAR;
    status->size = (int64_t)both(about.nFileSizeHigh, about.nFileSizeLow);
    status->modified = (int64_t)(both(written.dwHighDateTime, written.dwLowDateTime) * UNIT_NS);
    status->device = about.dwVolumeSerialNumber;
    status->number = both(about.nFileIndexHigh, about.nFileIndexLow);
    return 0;
}

/** Whoever has the file open may have it renamed and removed meanwhile. */
static HANDLE open_handle(const char *path, DWORD access, DWORD creation, DWORD flags) {
    const DWORD sharing = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;
    wchar_t *name = wide_of(path);
    if (!name)
        return INVALID_HANDLE_VALUE;
    HANDLE file = CreateFileW(name, access, sharing, NULL, creation, flags, NULL);
    free(name);
    if (file == INVALID_HANDLE_VALUE)
        fail();
    return file;
}

int pl_file_find(const char *path, pl_file_status *status) {
    HANDLE file = open_handle(path, 0, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS); /* folders too */
    if (file == INVALID_HANDLE_VALUE)
        return -1;
    const int result = find(file, status);
    CloseHandle(file);
    return result;
}

int pl_file_find_open(int fd, pl_file_status *status) {
    const intptr_t file = _get_osfhandle(fd);
    return file == -1 ? -1 : find((HANDLE)file, status);
}

int pl_file_exists(const char *path) {
    pl_file_status status;
    return pl_file_find(path, &status) == 0;
}

int pl_file_is_same(const pl_file_status *a, const pl_file_status *b) {
    return a->kind == b->kind && a->device == b->device && a->number == b->number;
}

int pl_file_open(const char *path, pl_file_use use) {
    static const DWORD creation[] = {[PL_FILE_READ] = OPEN_EXISTING,
                                     [PL_FILE_WRITE] = OPEN_EXISTING,
                                     [PL_FILE_REWRITE] = TRUNCATE_EXISTING,
                                     [PL_FILE_CREATE] = CREATE_NEW,
                                     [PL_FILE_CREATE_PRIVATE] = CREATE_NEW};
    /* A folder can be opened only so; reading it is refused later, with a better message. */
    const DWORD flags = use == PL_FILE_READ ? FILE_FLAG_BACKUP_SEMANTICS : FILE_ATTRIBUTE_NORMAL;
    HANDLE file =
        open_handle(path, use == PL_FILE_READ ? GENERIC_READ : GENERIC_WRITE, creation[use], flags);
    if (file == INVALID_HANDLE_VALUE)
        return -1;
    const int fd = _open_osfhandle((intptr_t)file, _O_BINARY | _O_NOINHERIT |
                                                       (use == PL_FILE_READ ? _O_RDONLY : 0));
    if (fd < 0)
        CloseHandle(file);
    return fd;
}

int pl_file_close(int fd) {
    return _close(fd);
}

int pl_file_open_is_replaceable(void) {
    return 0;
}

int pl_file_duplicate(int fd) {
    return _dup(fd);
}

/* A file that is mapped cannot be replaced. */
const char *pl_file_map(int fd, int64_t size) {
    (void)fd;
    (void)size;
    errno = ENOSYS;
    return NULL;
}

void pl_file_unmap(const char *data, int64_t size) {
    (void)data;
    (void)size;
}

void pl_file_rest(const char *data, int64_t size) {
    (void)data;
    (void)size;
}

int pl_file_sync(int fd) {
    return _commit(fd);
}

int pl_file_make_accessible(const char *path) {
    (void)path;
    return -1;
}

void pl_file_set_mode(const char *path, int mode) {
    (void)path;
    (void)mode;
}

int pl_file_replace(const char *from, const char *to) {
    wchar_t *old_name = wide_of(from), *new_name = wide_of(to);
    const DWORD flags = MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH;
    int result = -1;
    if (old_name && new_name)
        result = MoveFileExW(old_name, new_name, flags) ? 0 : fail();
    free(old_name);
    free(new_name);
    return result;
}

int pl_file_remove(const char *path) {
    wchar_t *name = wide_of(path);
    const int result = name && (DeleteFileW(name) || RemoveDirectoryW(name)) ? 0 : fail();
    free(name);
    return result;
}

/* A new file inherits an access list from its folder. */
void pl_file_take_access(int fd, const char *path) {
    (void)fd;
    (void)path;
}

void pl_system_explain(int number, char *text, size_t size) {
    if (strerror_s(text, size, number) != 0)
        snprintf(text, size, "error %d of the system", number);
}

long pl_process_number(void) {
    return (long)GetCurrentProcessId();
}
