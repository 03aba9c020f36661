/* A project of C alone, with the static libraries. */
#include <planish/planish_io.h>

#include <stdio.h>

int main(int argc, char **argv) {
    planish_file *file = NULL;
    planish_error error;
    if (argc != 2 || planish_file_open(argv[1], NULL, 1, &file, &error)) {
        fprintf(stderr, "%s\n", argc == 2 ? error.text : "which file?");
        return 1;
    }
    printf("%lld elements\n", (long long)planish_file_mesh(file).n_elements);
    planish_file_close(file);
    return 0;
}
