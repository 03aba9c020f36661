/* Any bytes as a mesh that is a folder: the first byte chooses the format; behind it are its files, parted
 * by a line "=====". A file without bytes is not there. */
#include "fuzz_reader.h"

#include <sys/stat.h>

static const char separator[] = "\n=====\n";

/* The files of each format, the one with the coordinates first. */
static const char *const names[2][9] = {
    {"mesh.nodes", "mesh.header", "mesh.elements", "mesh.boundary", "mesh.names", NULL},
    {"points", "faces", "owner", "neighbour", "boundary", "cellZones", "faceZones", "pointZones",
     NULL}};

/** Find the separator; NULL: there is none. */
static const char *find_separator(const char *data, size_t size) {
    const size_t length = sizeof separator - 1;
    for (size_t i = 0; i + length <= size; i++)
        if (memcmp(data + i, separator, length) == 0)
            return data + i;
    return NULL;
}

static const char *join(char *text, const char *folder, const char *name) {
    const int length = snprintf(text, FUZZ_PATH_SIZE, "%s/%s", folder, name);
    fuzz_require(length < FUZZ_PATH_SIZE, "TMPDIR is short");
    return text;
}

/** Write a file of the folder, or remove the one of the run before. */
static void put(const char *folder, const char *name, const char *data, size_t size) {
    char path[FUZZ_PATH_SIZE];
    unlink(join(path, folder, name));
    if (size == 0)
        return;
    FILE *file = fopen(path, "wb");
    fuzz_require(file && fwrite(data, 1, size, file) == size && fclose(file) == 0,
                 "the input can be written");
}

/** Remove a folder with files. */
static void remove_folder(const char *folder) {
    char path[FUZZ_PATH_SIZE];
    for (int i = 0; i < 2; i++)
        for (int k = 0; names[i][k]; k++)
            unlink(join(path, folder, names[i][k]));
    rmdir(folder);
}

/** Write the mesh unchanged, and moved, to a new folder. */
static void check_written(const planish_file *file, const char *name, const char *points,
                          size_t size) {
    char folder[FUZZ_PATH_SIZE], path[FUZZ_PATH_SIZE];
    planish_file *again = NULL;
    planish_error error = {.code = 0};
    const planish_mesh mesh = planish_file_mesh(file);
    fuzz_path(folder, "-out");
    remove_folder(folder);
    if (planish_file_write(file, folder, mesh.coordinates, &(planish_write_options){.threads = 1},
                           &error))
        fuzz_require(0, error.text);
    fuzz_require(fuzz_same_bytes(join(path, folder, name), points, size),
                 "unchanged coordinates give the same bytes");
    remove_folder(folder);
    double *moved = fuzz_move(file);
    if (planish_file_write(file, folder, moved, &(planish_write_options){.threads = 1}, &error))
        fuzz_require(0, error.text);
    if (planish_file_open(folder, NULL, 1, &again, &error))
        fuzz_require(fuzz_has_noise(file), error.text);
    const planish_mesh other = planish_file_mesh(again);
    if (again && !fuzz_changes_plane(file, again))
        fuzz_require(other.n_nodes == mesh.n_nodes && other.n_elements == mesh.n_elements &&
                         (mesh.dim == 2 || memcmp(other.coordinates, moved,
                                                  3 * (size_t)mesh.n_nodes * sizeof *moved) == 0),
                     "what is written is read");
    planish_file_close(again);
    remove_folder(folder);
    free(moved);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    char folder[FUZZ_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error = {.code = 0};
    if (size == 0)
        return 0;
    const int format = data[0] & 1;
    const char *at = (const char *)data + 1, *end = (const char *)data + size, *points = at;
    size_t points_size = 0;
    fuzz_path(folder, "-mesh");
    remove_folder(folder);
    fuzz_require(mkdir(folder, 0777) == 0, "a folder can be made");
    for (int i = 0; names[format][i]; i++) {
        const char *next = find_separator(at, (size_t)(end - at));
        const size_t length = (size_t)((next ? next + 1 : end) - at);
        put(folder, names[format][i], at, length);
        points_size = i == 0 ? length : points_size;
        at = next ? next + sizeof separator - 1 : end;
    }
    const int status = planish_file_open(folder, NULL, 1, &file, &error);
    if (status) {
        fuzz_require(error.code == status && error.text[0], "a failure has a code and a text");
    } else {
        fuzz_check_mesh(file);
        fuzz_check_cells(file);
        fuzz_check_questions(file);
        fuzz_check_converted(file);
        check_written(file, names[format][0], points, points_size);
        planish_file_close(file);
    }
    remove_folder(folder);
    return 0;
}
