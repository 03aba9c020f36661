/* smooth: the command `planish smooth`, from mesh file to better mesh file.
 *
 *     options -> read -> steps.c -> write -> report
 *
 * Every step returns 0, or an exit status after a message; the first that fails ends the run.
 */
#include "commands/commands.h"

#include "commands/judge.h"
#include "commands/steps.h"
#include "job/cells.h"
#include "job/curved.h"
#include "job/output.h"
#include "report/hint.h"
#include "report/page.h"
#include "report/table.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include "base/clock.h"
#include "base/system.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the mesh that is written --------------------------------------------------------------- */

/** Whether the engine writes the output: of a mesh that it has read, or one that no format of
 *  planish_io writes, of coordinates as they are and elements of first order. */
static int engine_writes(const pl_job *job) {
    const char *output = job->arguments->output;
    return !job->file || (!planish_file_can_write(job->file, output) && !job->mesh.cells &&
                          job->engine->can_write && job->engine->can_write(output) &&
                          !planish_file_plane(job->file, NULL));
}

/** Check before the work what can be known of writing. Another extension than the input's asks for
 * a conversion. */
static int check_output(const pl_job *job) {
    const char *output = job->arguments->output;
    planish_error error;
    if (engine_writes(job))
        return 0;
    if (planish_file_can_write(job->file, output))
        return planish_file_check_output(job->file, output, &error)
                   ? pl_job_complain(job, PL_EXIT_FAILED, &error)
                   : 0;
    if (planish_file_can_convert(job->file, output))
        return planish_file_check_conversion(job->file, output, NULL, &error)
                   ? pl_complain(PL_EXIT_FAILED, "%s", error.text)
                   : 0;
    if (strcmp(output, "-") == 0)
        return pl_complain_usage("smooth", "'-' is not a file; standard output is /dev/stdout");
    planish_file_check_output(job->file, output, &error); /* tells the extensions */
    return pl_complain_usage("smooth", "%s, and no extension of a format that planish converts to",
                             error.text);
}

/** Say which files that the mesh includes are not beside the output. */
static void note_included(const pl_job *job) {
    const char *output = job->arguments->output;
    const char *const *name = planish_file_included(job->file);
    const int folder = (int)(pl_path_name(output) - output);
    char path[4096];
    for (; *name; name++) {
        const int length = snprintf(path, sizeof path, "%.*s%s", folder, output, *name);
        for (char *c = path + folder; length < (int)sizeof path && *c; c++)
            *c = *c == '\\' ? '/' : *c; /* as files of Windows have it */
        if (length < (int)sizeof path && !pl_file_exists(path))
            pl_note(stderr, "%s includes %s, which is not there: copy it", output, *name);
    }
}

static int write_mesh(pl_job *job, pl_result *result) {
    const char *output = job->arguments->output;
    uint64_t checksums[] = {result->input_checksum, result->checksum};
    planish_error error;
    int status;
    const double begin = pl_seconds();
    const int by_engine = engine_writes(job);
    if ((status = pl_output_check_still_new(job->arguments)))
        return status;
    if (!by_engine && !planish_file_can_write(job->file, output)) {
        status = pl_cells_convert(job, output);
    } else {
        /* Its memory is better used for the file's pages: what is written to fresh ones takes
         * longer. */
        job->engine->plan_destroy(job);
        const int code =
            by_engine ? job->engine->write(job, output, checksums, &error)
                      : planish_file_write(job->file, output, job->mesh.coordinates,
                                           &(planish_write_options){
                                               .threads = job->options.threads,
                                               .temporary = pl_signals_temporary(PL_TEMPORARY_MESH),
                                               .temporary_size = PL_TEMPORARY_SIZE},
                                           &error);
        status = code ? pl_job_complain(job, PL_EXIT_FAILED, &error) : 0;
    }
    result->input_checksum = checksums[0];
    result->checksum = checksums[1];
    result->write_seconds = pl_seconds() - begin;
    return status;
}

/* ---- what is told --------------------------------------------------------------------------- */

/** Say what OUT of an OpenFOAM case lacks: all but the mesh. */
static void note_case(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    planish_file_info info;
    pl_file_status input, output, found;
    char system[4096];
    if (!job->file)
        return;
    planish_file_get_info(job->file, &info);
    snprintf(system, sizeof system, "%s/system", arguments->input);
    if (strcmp(info.format, "openfoam") == 0 && pl_file_find(system, &found) == 0 &&
        pl_file_find(arguments->input, &input) == 0 &&
        pl_file_find(arguments->output, &output) == 0 && output.kind == PL_FILE_FOLDER &&
        !pl_file_is_same(&input, &output))
        pl_note(stderr,
                "%s has the mesh alone: to run the case, copy it, and smooth the copy with "
                "--in-place",
                arguments->output);
}

/** Print the table, the elements that fall short, and the reason; the table gives way to standard
 *  error if standard output carries data. */
static void print_table(const pl_job *job, const pl_result *result, int status) {
    const pl_arguments *arguments = job->arguments;
    if (arguments->verbosity != PL_QUIET) {
        FILE *stream = pl_output_takes_stdout(arguments) ? stderr : stdout;
        pl_table_smooth(stream, job, result);
        pl_hint_print(stream, job, result);
        pl_heights_note(stderr, job, &result->heights,
                        pl_cells_validity_faults(&result->validity_before, &result->before) == 0);
        pl_volumes_print(stderr, job, &result->volumes);
        pl_unfixable_print(stderr, job, &result->unfixable);
        pl_inside_print(stderr, job, &result->validity_after, &result->unfixable);
        pl_curved_note_result(stderr, job, &result->surface);
        pl_reversed_print(stderr, job, result->reversed.state, result->after.n_reversed);
        if (result->reversed.n_new == 0)
            pl_table_reversed(stderr, &result->after);
        note_case(job);
        if (job->file && planish_file_can_write(job->file, arguments->output))
            note_included(job);
    }
    if (result->reason[0] && status)
        pl_complain(status, "%s: %s", arguments->output, result->reason);
    else if (result->reason[0] && arguments->verbosity != PL_QUIET)
        pl_note(stderr, "%s: %s", arguments->output, result->reason);
}

/** Tell what came of it, once the mesh is written: table, JSON and page. */
static int report_result(const pl_job *job, pl_result *result, const pl_progress *progress) {
    const pl_arguments *arguments = job->arguments;
    int report = result->lacks_reports ? PL_EXIT_PARTLY : 0;
    result->total_seconds = pl_seconds() - job->begin;
    const int status = pl_judge(job, result);
    print_table(job, result, status);
    /* The mesh is already written, so a failure makes the run a partial one. */
    if (!report && (arguments->json || arguments->report)) {
        char *text = pl_result_smooth_json(job, result, progress);
        report = pl_reports_write(arguments, text, result->picture, PL_EXIT_PARTLY);
        free(text);
    }
    if (!report && result->lacks_history)
        report = PL_EXIT_PARTLY;
    return pl_flush_stdout(status ? status : report, PL_EXIT_PARTLY);
}

static int smooth_job(pl_job *job, pl_result *result, pl_progress *progress) {
    int status;
    if ((status = pl_steps_check(job)))
        return status;
    if ((status = check_output(job)))
        return status;
    if ((status = pl_steps_smooth(job, result, progress)))
        return status;
    pl_progress_stage(progress, PL_STAGE_WRITING);
    if ((status = write_mesh(job, result)))
        return status;
    pl_signals_set_written();
    pl_progress_clear(progress);
    return report_result(job, result, progress);
}

int pl_smooth_by(const pl_arguments *arguments, const pl_engine *engine) {
    pl_job job;
    pl_result result = {.reason = ""};
    pl_progress progress;
    int status = pl_output_check_all(arguments);
    if (status)
        return status;
    pl_signals_set_input(arguments->input); /* before anything is shown that a signal would clear */
    pl_signals_set_before_smoothing(1);
    pl_progress_init(&progress, arguments);
    pl_progress_stage(&progress, PL_STAGE_READING);
    status = pl_job_read(&job, arguments, engine);
    if (!status)
        status = smooth_job(&job, &result, &progress);
    pl_progress_free(&progress);
    pl_steps_free(&result);
    pl_job_close(&job);
    return status;
}

/* ---- several meshes ------------------------------------------------------------------------- */

/** Find the name [*length] of the file or folder at path, behind which separators may stand. */
static const char *name_of(const char *path, int *length) {
    const char *end = path + strlen(path);
    while (end > path && pl_path_is_separator(end[-1]))
        end--;
    const char *name = end;
    while (name > path && !pl_path_is_separator(name[-1]))
        name--;
    *length = (int)(end - name);
    return name;
}

/** Make the path of the smoothed mesh of input; owned, or NULL without memory. */
static char *output_of(const pl_arguments *arguments, const char *input) {
    const char *folder = arguments->output_dir;
    const size_t in_folder = folder ? strlen(folder) : 0, size = strlen(input) + in_folder + 2;
    char *path = malloc(size);
    int length;
    const char *name = name_of(input, &length);
    if (path && folder)
        snprintf(path, size, "%s%s%.*s", folder,
                 pl_path_is_separator(folder[in_folder - 1]) ? "" : "/", length, name);
    else if (path)
        snprintf(path, size, "%s", input);
    return path;
}

static int smooth_one(const pl_arguments *arguments, const char *input) {
    pl_arguments of_one = *arguments;
    char *output = output_of(arguments, input);
    if (!output)
        return pl_complain(PL_EXIT_FAILED, "%s: out of memory", input);
    of_one.input = input;
    of_one.inputs = &input;
    of_one.n_inputs = 1;
    of_one.output = output;
    const int status = pl_smooth_by(&of_one, &pl_engine_here);
    free(output);
    return status;
}

/** The length of a name without its extension. */
static int base_length(const char *name, int length) {
    for (int i = length - 1; i > 0; i--)
        if (name[i] == '.')
            return i;
    return length;
}

/** Whether both paths end in the same name but for its extension. */
static int same_base(const char *a, const char *b) {
    int length_a, length_b;
    const char *name_a = name_of(a, &length_a), *name_b = name_of(b, &length_b);
    length_a = base_length(name_a, length_a);
    return length_a == base_length(name_b, length_b) &&
           strncmp(name_a, name_b, (size_t)length_a) == 0;
}

/** Whether the outputs of two inputs are one mesh; 1 without memory. */
static int same_output(const pl_arguments *arguments, const char *a, const char *b) {
    if (!same_base(a, b))
        return 0;
    char *output_a = output_of(arguments, a), *output_b = output_of(arguments, b);
    const int same =
        !output_a || !output_b || pl_output_is_same_mesh(output_a, output_b, arguments->format);
    free(output_a);
    free(output_b);
    return same;
}

/** Check that each input has a name, and no other one the same, for --output-dir. */
static int check_names(const pl_arguments *arguments) {
    for (int i = 0; i < arguments->n_inputs; i++) {
        const char *input = arguments->inputs[i];
        int length;
        const char *name = name_of(input, &length);
        if (length == 0 || strncmp(name, "..", (size_t)length) == 0) /* a dot, too */
            return pl_complain_usage(
                "smooth",
                "'%s' has no name that --output-dir can use: give the name of the folder itself",
                input);
        for (int j = 0; j < i; j++)
            if (same_output(arguments, input, arguments->inputs[j]))
                return pl_complain_usage("smooth",
                                         "'%s' and '%s' would get the same name in --output-dir: "
                                         "smooth them into different folders",
                                         arguments->inputs[j], input);
    }
    return 0;
}

/** Complain that the smoothed mesh of an input would replace that of an input, perhaps the same. */
static int complain_of_clash(const pl_arguments *arguments, const char *input,
                             const char *replaced) {
    if (arguments->in_place)
        return pl_complain_usage("smooth", "'%s' and '%s' are the same mesh: name it once", input,
                                 replaced);
    if (input == replaced)
        return pl_complain_usage("smooth", "'%s' is in the folder of --output-dir: give --in-place",
                                 input);
    return pl_complain_usage("smooth",
                             "the output of '%s' is a link to '%s', another input: remove the link",
                             input, replaced);
}

/** Check that the smoothed mesh of an input, which takes the place of the file found, replaces no file that
 *  an option names. */
static int check_read_files(const pl_arguments *arguments, const char *input,
                            const pl_file_status *found) {
    pl_file_status about;
    pl_read_file file;
    for (int i = 0; (file = pl_output_read_file(arguments, i)).path; i++)
        if (pl_file_find(file.path, &about) == 0 && pl_file_is_same(found, &about))
            return pl_complain_usage("smooth", "the output of '%s' would overwrite %s '%s'", input,
                                     file.what, file.path);
    return 0;
}

/** Check that no output replaces an input [n_inputs], but its own by --in-place, nor a file that an option
 *  reads, but that of a single mesh by --in-place. input: 0 of those that are not there. */
static int check_clashes(const pl_arguments *arguments, const pl_file_status *input) {
    int status = 0;
    for (int i = 0; i < arguments->n_inputs && !status; i++) {
        char *output = output_of(arguments, arguments->inputs[i]);
        pl_file_status found;
        const int is_there = output && pl_file_find(output, &found) == 0;
        free(output);
        for (int j = 0; j < arguments->n_inputs && is_there; j++)
            if ((j != i || arguments->output_dir) && pl_file_is_same(&found, &input[j]))
                return complain_of_clash(arguments, arguments->inputs[i], arguments->inputs[j]);
        if (is_there && (arguments->output_dir || arguments->n_inputs > 1))
            status = check_read_files(arguments, arguments->inputs[i], &found);
    }
    return status;
}

/** Check before the first mesh what can be known of all outputs. */
static int check_several(const pl_arguments *arguments) {
    pl_file_status *input = calloc((size_t)arguments->n_inputs, sizeof *input);
    if (!input)
        return pl_complain(PL_EXIT_FAILED, "out of memory for the list of meshes");
    for (int i = 0; i < arguments->n_inputs; i++)
        if (pl_file_find(arguments->inputs[i], &input[i]))
            input[i] = (pl_file_status){.number = 0};
    int status = arguments->output_dir ? check_names(arguments) : 0;
    if (!status)
        status = check_clashes(arguments, input);
    free(input);
    return status;
}

/** Smooth input i, unless its output would replace one before: by a link, or where the system ignores the case
 *  of letters. output [i]: the files that these are. */
static int smooth_next(const pl_arguments *arguments, pl_file_status *output, int i) {
    char *path = output_of(arguments, arguments->inputs[i]);
    const int is_there = path && pl_file_find(path, &output[i]) == 0;
    int status = 0;
    for (int j = 0; j < i && is_there && arguments->output_dir && !status; j++)
        if (pl_file_is_same(&output[i], &output[j]))
            status = pl_complain(PL_EXIT_FAILED,
                                 "%s: not smoothed, as the output would replace that of '%s': "
                                 "smooth them into different folders",
                                 arguments->inputs[i], arguments->inputs[j]);
    if (!status)
        status = smooth_one(arguments, arguments->inputs[i]);
    if (!path || pl_file_find(path, &output[i]))
        output[i] = (pl_file_status){.number = 0};
    free(path);
    return status;
}

/** Make a folder where it is missing, and those that it is to be in. Returns 0, or why not as errno. */
static int make_folders(const char *folder) {
    pl_file_status found;
    int length;
    if (pl_folder_create(folder) == 0)
        return 0;
    const int reason = errno;
    if (pl_file_find(folder, &found) == 0 && found.kind == PL_FILE_FOLDER)
        return 0;
    const size_t begin = (size_t)(name_of(folder, &length) - folder);
    char *parent = reason == ENOENT && begin > 0 ? strdup(folder) : NULL;
    if (!parent)
        return reason;
    parent[begin] = '\0';
    const int failed = make_folders(parent);
    free(parent);
    return !failed && pl_folder_create(folder) ? errno : failed;
}

/** Make the folder of outputs where it is missing. */
static int make_folder(const char *folder) {
    const int reason = make_folders(folder);
    return !reason ? 0
                   : pl_complain(PL_EXIT_FAILED, "%s: cannot make this folder: %s", folder,
                                 strerror(reason));
}

int pl_smooth_command(const pl_arguments *arguments) {
    if (arguments->output)
        return pl_smooth_by(arguments, &pl_engine_here);
    int worst = check_several(arguments);
    if (!worst && arguments->output_dir)
        worst = make_folder(arguments->output_dir);
    if (worst)
        return worst;
    pl_file_status *output = calloc((size_t)arguments->n_inputs, sizeof *output);
    if (!output)
        return pl_complain(PL_EXIT_FAILED, "out of memory for the list of meshes");
    for (int i = 0; i < arguments->n_inputs; i++) {
        if (pl_signals_stop_asked()) {
            pl_complain(PL_EXIT_PARTLY,
                        "%s (and %d more): not smoothed, because a signal stopped planish",
                        arguments->inputs[i], arguments->n_inputs - i - 1);
            worst = worst > PL_EXIT_PARTLY ? worst : PL_EXIT_PARTLY;
            break;
        }
        if (i > 0 && arguments->verbosity != PL_QUIET)
            putchar('\n');
        const int status = smooth_next(arguments, output, i);
        worst = status > worst ? status : worst;
    }
    free(output);
    return worst;
}
