/* smooth: the command `planish smooth`, from mesh file to better mesh file.
 *
 *     options -> read -> plan -> measure -> smooth -> measure -> write -> report
 *
 * Every step returns 0, or an exit status after a message; the first that fails ends the run.
 */
#include "commands.h"

#include "job.h"
#include "message.h"
#include "output.h"
#include "progress.h"
#include "result.h"
#include "signals.h"
#include "table.h"

#include "base/clock.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* The RMS before and after is summed over the same elements, most of which are unchanged: a rise
 * within the rounding of such a sum says nothing. Relative. */
static const double RMS_ROUNDING = 1e-12;

/** What the command line says about outputs, checked before the work begins. */
static int check_outputs(const pl_arguments *arguments) {
    const char *output = arguments->output, *json = arguments->json;
    const int json_is_stdout = json && (strcmp(json, "-") == 0 || pl_output_is_stdout(json));
    if (json_is_stdout && pl_output_is_stdout(output))
        return pl_complain_usage("smooth", "mesh and report cannot both go to standard output");
    if (json && strcmp(json, "-") != 0) {
        if (pl_output_hits_mesh(json, output) || pl_output_hits_mesh(json, arguments->input))
            return pl_complain_usage("smooth", "the report would overwrite the mesh '%s'", json);
        const int status = pl_output_check(json);
        if (status)
            return status;
    }
    return pl_output_check(output);
}

/** Another extension than the input's would ask for a conversion. */
static int check_extension(const pl_job *job) {
    const char *output = job->arguments->output;
    if (planish_file_can_write(job->file, output))
        return 0;
    return pl_complain_usage("smooth",
                             "'%s' does not have the extension of a %s file, and the format cannot "
                             "be changed: name the output like the input",
                             output, job->file_info.format);
}

static int run_sweeps(pl_job *job, pl_result *result, pl_progress *progress) {
    planish_error error;
    const double begin = pl_seconds();
    pl_signals_install_stop(); /* before, there is nothing to save: a signal just ends the program
                                */
    job->options.progress = pl_progress_step;
    job->options.progress_user = progress;
    const int code = planish_smooth(job->plan, planish_file_coordinates(job->file), &job->options,
                                    &result->smooth, &error);
    result->smooth_seconds = pl_seconds() - begin;
    pl_progress_clear(progress);
    if (code)
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    if (progress->out_of_memory) /* no reason to lose the mesh */
        fprintf(stderr,
                "note: out of memory for the history of the sweeps; the report lacks some\n");
    return 0;
}

/** The library promises not to make anything worse; a mesh that says otherwise is not written. */
static int check_promises(const pl_job *job, const pl_result *result) {
    const planish_quality *before = &result->before, *after = &result->after;
    if (after->inverted > before->inverted)
        return pl_complain(PL_EXIT_FAILED,
                           "%s: internal error: %" PRId64 " elements inverted after smoothing, "
                           "%" PRId64 " before; nothing was written, please report this",
                           job->arguments->input, after->inverted, before->inverted);
    if (after->max_radius_ratio > before->max_radius_ratio)
        return pl_complain(PL_EXIT_FAILED,
                           "%s: internal error: the worst radius ratio rose from %.17g to %.17g; "
                           "nothing was written, please report this",
                           job->arguments->input, before->max_radius_ratio,
                           after->max_radius_ratio);
    if (after->rms_radius_ratio > before->rms_radius_ratio * (1 + RMS_ROUNDING))
        return pl_complain(PL_EXIT_FAILED,
                           "%s: internal error: the RMS rose from %.17g to %.17g; nothing was "
                           "written, please report this",
                           job->arguments->input, before->rms_radius_ratio,
                           after->rms_radius_ratio);
    return 0;
}

static int write_mesh(const pl_job *job, pl_result *result) {
    planish_error error;
    const double begin = pl_seconds();
    const int code = planish_file_write(
        job->file, job->arguments->output, job->mesh.coordinates, job->options.threads,
        pl_signals_temporary(PL_TEMPORARY_MESH), PL_TEMPORARY_SIZE, &error);
    result->write_seconds = pl_seconds() - begin;
    return code ? pl_job_complain(job, PL_EXIT_FAILED, &error) : 0;
}

/** Whether all that was asked for was reached, and if not (or if there was nothing to do) why. */
static int judge(const pl_job *job, pl_result *result) {
    char *reason = result->reason;
    const size_t size = sizeof result->reason;
    if (result->after.inverted > 0) {
        snprintf(reason, size, "%" PRId64 " inverted element%s left; nodes beside them stayed",
                 result->after.inverted, result->after.inverted == 1 ? " is" : "s are");
        return PL_EXIT_PARTLY;
    }
    if (result->smooth.stop == PLANISH_STOP_TIME_LIMIT) {
        snprintf(reason, size, "stopped by the time limit of %g s before convergence",
                 job->options.time_limit);
        return PL_EXIT_PARTLY;
    }
    if (result->smooth.stop == PLANISH_STOP_INTERRUPTED) {
        snprintf(reason, size, "interrupted by a signal before convergence");
        return PL_EXIT_PARTLY;
    }
    if (job->plan_info.n_free == 0)
        snprintf(reason, size, "no node is free to move: the mesh is written back as it was");
    return PL_EXIT_DONE;
}

/** The JSON report. The mesh is already written, so a failure makes the run a partial one. */
static int write_report(const pl_job *job, const pl_result *result, const pl_progress *progress) {
    const char *path = job->arguments->json;
    if (!path)
        return 0;
    char *text = pl_result_smooth_json(job, result, progress);
    if (!text)
        return pl_complain(PL_EXIT_PARTLY, "out of memory for the report %s", path);
    planish_error error;
    const int failure = pl_output_write_text(path, text, strlen(text), &error);
    free(text);
    if (failure)
        return pl_complain(PL_EXIT_PARTLY, "the report: %s", error.text);
    return 0;
}

/** Table and reason; the table gives way to standard error if standard output carries data. */
static void print_table(const pl_job *job, const pl_result *result, int status) {
    const pl_arguments *arguments = job->arguments;
    const int stdout_is_taken = pl_output_is_stdout(arguments->output) ||
                                (arguments->json && (strcmp(arguments->json, "-") == 0 ||
                                                     pl_output_is_stdout(arguments->json)));
    if (arguments->verbosity != PL_QUIET)
        pl_table_smooth(stdout_is_taken ? stderr : stdout, job, result);
    if (result->reason[0] && (status || arguments->verbosity != PL_QUIET))
        pl_complain(status, "%s: %s", arguments->output, result->reason);
}

static void print_setup(const pl_job *job) {
    const planish_plan_info *info = &job->plan_info;
    if (job->arguments->verbosity != PL_QUIET)
        pl_table_oddities(stderr, job);
    if (job->arguments->verbosity == PL_VERBOSE)
        fprintf(stderr, "%d thread%s (%s), kernel %s, %d colours, plan of %.1f MB\n", info->threads,
                info->threads == 1 ? "" : "s", info->binding, info->isa, info->n_colours,
                (double)info->bytes / 1e6);
}

static int smooth_job(pl_job *job, pl_result *result, pl_progress *progress) {
    int status;
    if ((status = pl_job_plan(job)))
        return status;
    print_setup(job);
    if ((status = pl_job_measure(job, &result->before)))
        return status;
    if ((status = run_sweeps(job, result, progress)))
        return status;
    if ((status = pl_job_measure(job, &result->after)))
        return status;
    if ((status = check_promises(job, result)))
        return status;
    if ((status = write_mesh(job, result)))
        return status;
    result->total_seconds = pl_seconds() - job->begin;
    status = judge(job, result);
    print_table(job, result, status);
    const int report = write_report(job, result, progress);
    return pl_flush_stdout(status ? status : report, PL_EXIT_PARTLY);
}

int pl_smooth_command(const pl_arguments *arguments) {
    pl_job job;
    pl_result result = {.reason = ""};
    pl_progress progress;
    int status = check_outputs(arguments);
    if (status)
        return status;
    pl_progress_init(&progress, arguments->verbosity);
    status = pl_job_read(&job, arguments);
    if (!status)
        status = check_extension(&job);
    if (!status)
        status = smooth_job(&job, &result, &progress);
    pl_progress_free(&progress);
    pl_job_close(&job);
    return status;
}
