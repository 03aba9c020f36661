/* convert: the command `planish convert`: a mesh in another format, its nodes where they are. */
#include "commands/commands.h"

#include "job/output.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include "base/status.h"

#include <planish/planish_io.h>

#include <stdlib.h>
#include <string.h>

static int complain(const pl_arguments *arguments, const planish_error *error) {
    if (strncmp(error->text, arguments->input, strlen(arguments->input)) == 0 ||
        strncmp(error->text, arguments->output, strlen(arguments->output)) == 0)
        return pl_complain(PL_EXIT_FAILED, "%s", error->text);
    return pl_complain(PL_EXIT_FAILED, "%s: %s", arguments->input, error->text);
}

/** Find the nodes that the file holds by itself, not as those of its lines, facets and regions, which
 *  are converted: constraint [n], owned; NULL: none is held. */
static int find_held(const planish_file *file, int64_t n, uint8_t **constraint,
                     planish_error *error) {
    const unsigned by_mesh =
        PLANISH_FILE_LINE_OR_POINT | PLANISH_FILE_FACE | PLANISH_FILE_INTERFACE;
    int64_t n_held = 0;
    *constraint = malloc((size_t)n + 1);
    if (!*constraint)
        return pl_fail_memory(error, "nodes that the file holds");
    const int status = planish_file_get_held(file, NULL, *constraint, error);
    for (int64_t i = 0; i < n && !status; i++) {
        const int is_held = ((*constraint)[i] & ~by_mesh) != 0;
        (*constraint)[i] = is_held ? PLANISH_CONSTRAINT_FIXED : PLANISH_CONSTRAINT_FREE;
        n_held += is_held;
    }
    if (n_held == 0) {
        free(*constraint);
        *constraint = NULL;
    }
    return status;
}

static int convert(const pl_arguments *arguments, planish_file *file) {
    const planish_mesh mesh = planish_file_mesh(file);
    planish_error error;
    char lost[512];
    planish_convert_options options = {.format = arguments->to,
                                       .temporary = pl_signals_temporary(PL_TEMPORARY_MESH),
                                       .temporary_size = PL_TEMPORARY_SIZE,
                                       .lost = lost,
                                       .lost_size = sizeof lost};
    uint8_t *constraint = NULL;
    int status = find_held(file, mesh.n_nodes, &constraint, &error);
    const int taken = status ? 0 : pl_output_check_still_new(arguments);
    options.constraint = constraint;
    if (!status && !taken)
        status = planish_file_convert(file, arguments->output, mesh.coordinates, &options, &error);
    free(constraint);
    if (taken)
        return taken;
    if (status)
        return complain(arguments, &error);
    if (arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s lacks %s", arguments->output, lost);
    return 0;
}

int pl_convert_command(const pl_arguments *arguments) {
    const planish_open_options how = {
        .format = arguments->format, .threads = arguments->library.threads, .isolated = 1};
    planish_file *file = NULL;
    planish_error error;
    if (!arguments->to && !planish_file_target_of(arguments->output))
        return pl_complain_usage(
            "convert", "'%s' has no extension of a format that planish converts to: give --to NAME",
            arguments->output);
    int status = pl_output_check_all(arguments);
    if (status)
        return status;
    pl_signals_set_input(arguments->input);
    if (planish_file_open_with(arguments->input, &how, &file, &error))
        return complain(arguments, &error);
    status = convert(arguments, file);
    planish_file_close(file);
    return status;
}
