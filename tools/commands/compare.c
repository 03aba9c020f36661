/* compare: the command `planish compare`: two states of a mesh, as smooth tells of before and after. */
#include "commands/commands.h"

#include "commands/steps.h"
#include "job/output.h"
#include "job/same.h"
#include "report/page.h"
#include "report/table.h"
#include "terminal/message.h"

#include "base/clock.h"

#include <stdlib.h>

/** Tell what came of it: table, JSON and page. */
static int tell(const pl_job *job, pl_result *result, const pl_progress *progress) {
    const pl_arguments *arguments = job->arguments;
    int status = 0;
    result->total_seconds = pl_seconds() - job->begin;
    if (arguments->verbosity != PL_QUIET)
        pl_table_compare(pl_output_takes_stdout(arguments) ? stderr : stdout, job, result);
    if (arguments->json || arguments->report) {
        char *text = pl_result_smooth_json(job, result, progress);
        status = pl_reports_write(arguments, text, result->picture, PL_EXIT_FAILED);
        free(text);
    }
    return pl_flush_stdout(status, PL_EXIT_FAILED);
}

/** Compare the mesh of job with that of the file after. */
static int compare_with(pl_job *job, const planish_file *after, pl_progress *progress) {
    const pl_arguments *arguments = job->arguments;
    const planish_mesh mine = planish_file_mesh(job->file), other = planish_file_mesh(after);
    const pl_same_mesh before = {arguments->input, job->file, &mine};
    const pl_same_mesh second = {arguments->output, after, &other};
    pl_result result = {.reason = ""};
    int status =
        pl_same_check(&before, &second, "for meshes of different sizes use: planish quality A B");
    if (!status)
        status = pl_steps_check(job);
    if (!status)
        status = pl_steps_compare(job, after, &result, progress);
    pl_progress_clear(progress);
    if (!status)
        status = tell(job, &result, progress);
    pl_steps_free(&result);
    return status;
}

int pl_compare_command(const pl_arguments *arguments) {
    const planish_open_options how = {.threads = arguments->library.threads,
                                      .isolated = 1,
                                      .plane_tolerance = arguments->slide_tolerance};
    planish_file *after = NULL;
    planish_error error;
    pl_progress progress;
    pl_job job;
    int status = pl_output_check_all(arguments);
    if (status)
        return status;
    pl_progress_init(&progress, arguments);
    pl_progress_stage(&progress, PL_STAGE_READING);
    status = pl_job_read(&job, arguments, &pl_engine_here);
    if (!status && planish_file_open_with(arguments->output, &how, &after, &error))
        status = pl_complain(PL_EXIT_FAILED, "%s", error.text);
    if (!status)
        status = compare_with(&job, after, &progress);
    planish_file_close(after);
    pl_progress_free(&progress);
    pl_job_close(&job);
    return status;
}
