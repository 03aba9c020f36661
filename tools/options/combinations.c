/* combinations: options that exclude or need one another. */
#include "options/combinations.h"

#include "terminal/message.h"

#include <string.h>
#include <strings.h>

int pl_arguments_bound_volumes(const pl_arguments *arguments) {
    const planish_options *library = &arguments->library;
    return library->min_volume > 0 || library->min_volume_fraction > 0 ||
           arguments->n_min_volumes > 0;
}

/** The copy for viewing of the command quality. */
static int check_view(const pl_arguments *arguments) {
    const char *path = arguments->output;
    const size_t length = strlen(path), n = strlen(".vtu");
    const char *end = path + (length > n ? length - n : 0);
    if (strcasecmp(end, ".vtu") != 0 && strcasecmp(end, ".vtk") != 0)
        return pl_complain_usage("quality", "--output '%s' must end in .vtu or .vtk", path);
    if (arguments->n_inputs > 1)
        return pl_complain_usage("quality", "--output takes one mesh, but %d are named",
                                 arguments->n_inputs);
    return 0;
}

/** Check how smooth is told where to write. */
static int check_outputs(const pl_arguments *arguments) {
    if (arguments->output && (arguments->in_place || arguments->output_dir))
        return pl_complain_usage("smooth", "give --output or %s, not both",
                                 arguments->in_place ? "--in-place" : "--output-dir");
    if (arguments->in_place && arguments->output_dir)
        return pl_complain_usage("smooth", "give --in-place or --output-dir, not both");
    if (!arguments->output && !arguments->in_place && !arguments->output_dir)
        return pl_complain_usage("smooth", "no output file is named: give -o OUT");
    return 0;
}

/** Options that have no place beside --onto. */
static int check_onto(const pl_arguments *arguments) {
    const planish_options *library = &arguments->library;
    const char *command = pl_command_name(arguments->command);
    const char *name = arguments->slide                ? "slide"
                       : arguments->n_box > 0          ? "box"
                       : library->max_displacement > 0 ? "max-displacement"
                       : library->only_worse_than > 0  ? "only-worse-than"
                       : arguments->surface_of         ? "surface-of"
                                                       : NULL;
    if (arguments->slide && arguments->curved_if_any)
        return pl_complain_usage(command, "give --onto or --best, not both: --onto goes with "
                                          "--objective worst");
    return name ? pl_complain_usage(command, "give --onto or --%s, not both", name) : 0;
}

/** Find the options that say what elements are to become like: targets [5] in the order in which they are
 *  named. Returns how many are given. */
static int find_targets(const pl_arguments *arguments, const char **targets) {
    int n = 0;
    if (arguments->like)
        targets[n++] = "--like";
    if (arguments->layers == PL_LAYERS_KEPT)
        targets[n++] = "--layers keep";
    if (arguments->size)
        targets[n++] = "--size";
    if (arguments->size_from)
        targets[n++] = "--size-from";
    if (arguments->keep_sizes)
        targets[n++] = "--keep-sizes";
    return n;
}

int pl_arguments_have_sizes(const pl_arguments *arguments) {
    return arguments->size || arguments->size_from || arguments->keep_sizes;
}

const char *pl_arguments_target(const pl_arguments *arguments) {
    const char *targets[5];
    return find_targets(arguments, targets) > 0 ? targets[0] : NULL;
}

/** Check what stands beside options of targets. */
static int check_targets(const pl_arguments *arguments) {
    const planish_objective objective = arguments->library.objective;
    const char *command = pl_command_name(arguments->command), *targets[5] = {NULL};
    const int n = find_targets(arguments, targets);
    const int is_sized = pl_arguments_have_sizes(arguments);
    if (arguments->library.size_weight > 0 && !is_sized && !arguments->like)
        return pl_complain_usage(command, "--size-weight has no effect without --like or sizes "
                                          "(--size, --size-from, --keep-sizes)");
    if (arguments->library.size_weight == 0 && arguments->keep_sizes)
        return pl_complain_usage(
            command, "--keep-sizes has no effect with --size-weight 0: give a larger weight");
    if (n > 1)
        return pl_complain_usage(command, "give %s or %s, not both", targets[0], targets[1]);
    if (n == 1 && is_sized && arguments->n_inputs > 1)
        return pl_complain_usage(command, "%s takes one mesh, but %d are named", targets[0],
                                 arguments->n_inputs);
    if (n == 0 || !arguments->objective_given ||
        (objective == PLANISH_OBJECTIVE_MEAN_RATIO && !arguments->worst))
        return 0;
    if (strcmp(arguments->objective_given, "--best") == 0)
        return pl_complain_usage(command, "%s minimises the mean-ratio: leave out --best",
                                 targets[0]);
    return pl_complain_usage(command, "%s minimises the mean-ratio: leave out --objective %s",
                             targets[0], arguments->worst ? "worst" : pl_objective_name(objective));
}

int pl_arguments_check(const pl_arguments *arguments) {
    const planish_options *library = &arguments->library;
    const char *command = pl_command_name(arguments->command);
    if (library->min_volume > 0 && library->min_volume_fraction > 0)
        return pl_complain_usage(command, "give --min-volume for all elements or "
                                          "--min-volume-fraction, not both");
    if (library->area_weight > 0 && !pl_arguments_bound_volumes(arguments))
        return pl_complain_usage(
            command,
            "--area-weight needs a minimum volume: give --min-volume or --min-volume-fraction");
    if (arguments->fix_layers &&
        (arguments->layers == PL_LAYERS_IGNORED || arguments->layers == PL_LAYERS_KEPT))
        return pl_complain_usage(command, "give --fix-layers or --layers %s, not both",
                                 arguments->layers == PL_LAYERS_KEPT ? "keep" : "ignore");
    if (library->rings > 0 && !(library->only_worse_than > 0))
        return pl_complain_usage(command, "--rings has no effect without --only-worse-than");
    if (arguments->of_worst && !arguments->worst)
        return pl_complain_usage(command, "--%s has no effect without --objective worst",
                                 arguments->of_worst);
    if (arguments->command == PL_COMMAND_SMOOTH && check_outputs(arguments))
        return PL_EXIT_USAGE;
    if (arguments->onto && check_onto(arguments))
        return PL_EXIT_USAGE;
    if (check_targets(arguments))
        return PL_EXIT_USAGE;
    if (arguments->surface_of && arguments->n_inputs > 1)
        return pl_complain_usage(command, "--surface-of takes one mesh, but %d are named",
                                 arguments->n_inputs);
    if (arguments->command == PL_COMMAND_QUALITY && arguments->output && check_view(arguments))
        return PL_EXIT_USAGE;
    if (arguments->report && arguments->n_inputs > 1)
        return pl_complain_usage(command, "--report takes one mesh, but %d are named",
                                 arguments->n_inputs);
    if (arguments->history > 0 && !arguments->report)
        return pl_complain_usage(command, "--history has no effect without an HTML report: give "
                                          "--report FILE.html, too");
    if (arguments->json && arguments->n_inputs > 1 && arguments->command == PL_COMMAND_SMOOTH)
        return pl_complain_usage(command, "--json takes one mesh, but %d are named",
                                 arguments->n_inputs);
    if (arguments->n_worst > 0 && arguments->verbosity == PL_QUIET && !arguments->json &&
        !arguments->report)
        return pl_complain_usage(
            command, "--worst has no effect with --quiet: give --json or --report, too");
    const char *optimiser =
        arguments->layers == PL_LAYERS_KEPT ? "layers keep" : arguments->optimiser;
    if (library->method != PLANISH_METHOD_PLANISH && optimiser)
        return pl_complain_usage(command, "--%s has no effect with --method %s", optimiser,
                                 pl_method_name(library->method));
    return 0;
}
