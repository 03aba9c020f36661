/* quality: the command `planish quality`: what a mesh is worth; nothing is changed. */
#include "commands.h"

#include "job.h"
#include "message.h"
#include "output.h"
#include "result.h"
#include "table.h"

#include <stdlib.h>
#include <string.h>

static int check_report(const pl_arguments *arguments) {
    const char *json = arguments->json;
    if (!json || strcmp(json, "-") == 0)
        return 0;
    if (pl_output_hits_mesh(json, arguments->input))
        return pl_complain_usage("quality", "the report would overwrite the mesh '%s'", json);
    return pl_output_check(json);
}

static int write_report(const pl_job *job, const planish_quality *quality) {
    const char *path = job->arguments->json;
    if (!path)
        return 0;
    char *text = pl_result_quality_json(job, quality);
    if (!text)
        return pl_complain(PL_EXIT_FAILED, "out of memory for the report %s", path);
    planish_error error;
    const int failure = pl_output_write_text(path, text, strlen(text), &error);
    free(text);
    if (failure)
        return pl_complain(PL_EXIT_FAILED, "the report: %s", error.text);
    return 0;
}

static int measure_job(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    planish_quality quality;
    int status;
    if ((status = pl_job_plan(job)))
        return status;
    if ((status = pl_job_measure(job, &quality)))
        return status;
    if (arguments->verbosity != PL_QUIET) {
        const int stdout_is_taken = arguments->json && (strcmp(arguments->json, "-") == 0 ||
                                                        pl_output_is_stdout(arguments->json));
        pl_table_oddities(stderr, job);
        pl_table_quality(stdout_is_taken ? stderr : stdout, job, &quality);
    }
    return pl_flush_stdout(write_report(job, &quality), PL_EXIT_FAILED);
}

int pl_quality_command(const pl_arguments *arguments) {
    pl_job job;
    int status = check_report(arguments);
    if (status)
        return status;
    status = pl_job_read(&job, arguments);
    if (!status)
        status = measure_job(&job);
    pl_job_close(&job);
    return status;
}
