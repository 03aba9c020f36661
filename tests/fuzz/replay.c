/* replay: gives the fuzz target that it is linked with every file of the folders named, without a
 * fuzzer. The last name on standard error is that of the file that broke it.
 */
#include <dirent.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { PATH_SIZE = 4096 };

/** A block that ends where the file does: a sanitizer sees what is read behind it. */
static uint8_t *read_file(const char *path, size_t *size) {
    struct stat about;
    FILE *file = fopen(path, "rb");
    if (!file || fstat(fileno(file), &about) || !S_ISREG(about.st_mode)) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(1);
    }
    *size = (size_t)about.st_size;
    uint8_t *data = malloc(*size ? *size : 1);
    if (!data || fread(data, 1, *size, file) != *size) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(1);
    }
    fclose(file);
    return data;
}

static void replay(const char *path) {
    size_t size;
    uint8_t *data = read_file(path, &size);
    fprintf(stderr, "%s\n", path);
    LLVMFuzzerTestOneInput(data, size);
    free(data);
}

/** How many files there are in folder. */
static int replay_folder(const char *folder) {
    struct dirent **entry;
    const int n = scandir(folder, &entry, NULL, alphasort);
    int n_files = 0;
    for (int i = 0; i < n; i++) {
        char path[PATH_SIZE];
        if (entry[i]->d_name[0] != '.') {
            snprintf(path, sizeof path, "%s/%s", folder, entry[i]->d_name);
            replay(path);
            n_files++;
        }
        free(entry[i]);
    }
    if (n >= 0)
        free(entry);
    return n_files;
}

int main(int argc, char **argv) {
    int n_files = 0;
    for (int i = 1; i < argc; i++)
        n_files += replay_folder(argv[i]);
    printf("%d inputs\n", n_files);
    return n_files > 0 ? 0 : 1;
}
