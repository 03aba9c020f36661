/* Any lines as the words of a command line, the first byte naming the command: it is understood or
 * refused, and what is understood the library takes.
 */
#include "fuzz_require.h"

#include "options/parse.h"
#include "options/options.h"

#include <getopt.h>
#include <stdint.h>
#include <string.h>

enum { MOST_WORDS = 24 };

/** Lines of text, which become words; how many. */
static int cut(char *text, char **word) {
    int n = 0;
    for (char *line = strtok(text, "\n"); line && n < MOST_WORDS; line = strtok(NULL, "\n"))
        word[n++] = line;
    return n;
}

/** A mesh without minimum volumes of its own has no use for some options; that is told elsewhere.
 */
static void check_library(planish_options options) {
    static const double xyz[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const int32_t nodes[] = {0, 1, 2, 3};
    const planish_mesh mesh = {
        .dim = 3, .n_nodes = 4, .n_elements = 1, .coordinates = xyz, .elements = nodes};
    planish_quality quality;
    planish_error error;
    fuzz_require(options.threads >= 0 && options.threads <= 1024, "threads are a number of them");
    options.threads = 1;
    if (planish_measure_mesh(&mesh, &options, &quality, &error))
        fuzz_require(0, error.text);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static const pl_command commands[] = {PL_COMMAND_SMOOTH, PL_COMMAND_QUALITY, PL_COMMAND_REPORT};
    pl_arguments arguments;
    char *word[MOST_WORDS + 2] = {"planish"}, *none[] = {"planish", NULL};
    if (size == 0)
        return 0;
    char *text = malloc(size);
    fuzz_require(text != NULL, "memory");
    memcpy(text, data + 1, size - 1);
    text[size - 1] = '\0';
    const int n = 1 + cut(text, word + 1);
    optind = 0; /* getopt forgets the words of the input before */
    getopt(1, none, "");
    const int status = pl_arguments_parse(&arguments, commands[data[0] % 3], n, word);
    if (status == 0 && !arguments.help && !arguments.version) {
        fuzz_require(arguments.n_inputs > 0 && arguments.input, "there is an input");
        for (int i = 0; i < arguments.n_min_volumes; i++)
            fuzz_require(arguments.min_volume_value[i] > 0, "minimum volumes are positive");
        check_library(arguments.library);
    }
    pl_arguments_free(&arguments);
    free(text);
    return 0;
}
