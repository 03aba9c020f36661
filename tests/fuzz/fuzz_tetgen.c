/* Any bytes as TetGen's files: the first byte says which of .node and .ele is opened from memory,
 * where a sanitizer sees reads behind its end; then .node, .ele and .face, parted by '\0'. */
#include "fuzz_reader.h"

enum { N_PARTS = 3 };

typedef struct part {
    const char *data;
    size_t size;
} part;

static void cut(const char *data, size_t size, part *parts) {
    for (int i = 0; i < N_PARTS; i++) {
        const char *zero = i + 1 < N_PARTS ? memchr(data, '\0', size) : NULL;
        parts[i] = (part){data, zero ? (size_t)(zero - data) : size};
        data += parts[i].size;
        size -= parts[i].size;
        if (zero) {
            data++;
            size--;
        }
    }
}

static void put(const char *path, part p) {
    FILE *file = fopen(path, "wb");
    fuzz_require(file && fwrite(p.data, 1, p.size, file) == p.size && fclose(file) == 0,
                 "the input can be written");
}

/** A copy that ends where the part ends. */
static char *copy_of(part p) {
    char *copy = malloc(p.size ? p.size : 1);
    fuzz_require(copy != NULL, "memory");
    memcpy(copy, p.data, p.size);
    return copy;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const char *const endings[N_PARTS] = {".node", ".ele", ".face"};
    char path[N_PARTS][FUZZ_PATH_SIZE], output[FUZZ_PATH_SIZE];
    part parts[N_PARTS];
    planish_file *file;
    planish_error error = {.code = 0};
    if (size == 0)
        return 0;
    cut((const char *)data + 1, size - 1, parts);
    for (int i = 0; i < N_PARTS; i++)
        put(fuzz_path(path[i], endings[i]), parts[i]);
    if (parts[2].size == 0)
        unlink(path[2]);
    for (int i = 1; i < N_PARTS; i++) /* of the run before, which had other files */
        unlink(fuzz_path(output, i == 1 ? "-out.ele" : "-out.face"));
    int named = data[0] & 1;
    char *copy = copy_of(parts[named]);
    int status = io_file_from_memory(&io_format_tetgen, path[named], copy,
                                     (int64_t)parts[named].size, 1, &file, &error);
    if (status) {
        fuzz_require(error.code == status && error.text[0], "a failure has a code and a text");
    } else {
        fuzz_check_mesh(file);
        fuzz_check_cells(file);
        fuzz_check_questions(file);
        fuzz_check_converted(file);
        fuzz_path(output, "-out.node");
        fuzz_check_same(file, output, parts[0].data, parts[0].size, 0);
        fuzz_check_moved(file, output);
        fuzz_require(fuzz_same_bytes(fuzz_path(output, "-out.ele"), parts[1].data, parts[1].size),
                     "the elements are written along as they are");
        planish_file_close(file);
    }
    free(copy);
    return 0;
}
