/* quality: the command `planish quality`: what a mesh is worth; nothing is changed. */
#include "commands.h"

#include "job.h"
#include "layers.h"
#include "message.h"
#include "output.h"
#include "result.h"
#include "table.h"
#include "volumes.h"

#include <math.h>
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

static int write_report(const pl_job *job, const planish_quality *quality,
                        const pl_volumes *volumes) {
    const char *path = job->arguments->json;
    if (!path)
        return 0;
    char *text = pl_result_quality_json(job, quality, volumes);
    if (!text)
        return pl_complain(PL_EXIT_FAILED, "out of memory for the report %s", path);
    planish_error error;
    const int failure = pl_output_write_text(path, text, strlen(text), &error);
    free(text);
    if (failure)
        return pl_complain(PL_EXIT_FAILED, "the report: %s", error.text);
    return 0;
}

/** The least volume that the options ask for; total: the sum of the signed volumes. */
static double least_volume(const planish_options *options, double total) {
    const double fraction = options->min_volume_fraction;
    return fraction > 0 ? fraction * fabs(total) : options->min_volume;
}

static void print_table(const pl_job *job, const planish_quality *quality,
                        const pl_volumes *volumes) {
    const pl_arguments *arguments = job->arguments;
    const int stdout_is_taken = arguments->json && (strcmp(arguments->json, "-") == 0 ||
                                                    pl_output_is_stdout(arguments->json));
    if (arguments->verbosity == PL_QUIET)
        return;
    pl_table_oddities(stderr, job);
    pl_table_quality(stdout_is_taken ? stderr : stdout, job, quality, volumes);
    pl_volumes_print(stderr, job, volumes);
    pl_layers_print(stderr, job);
}

static int measure_job(pl_job *job, pl_volumes *volumes) {
    planish_quality quality;
    int status;
    if ((status = pl_job_plan(job)))
        return status;
    if (pl_job_is_told(job) && (status = pl_job_count_slides(job)))
        return status;
    if ((status = pl_job_measure(job, &quality)))
        return status;
    if (pl_job_is_told(job) && (status = pl_layers_count(job, &quality)))
        return status;
    const double least = least_volume(&job->options, quality.total_volume);
    if ((status = pl_volumes_find(job, least, volumes)))
        return status;
    print_table(job, &quality, volumes);
    return pl_flush_stdout(write_report(job, &quality, volumes), PL_EXIT_FAILED);
}

int pl_quality_command(const pl_arguments *arguments) {
    pl_job job;
    pl_volumes volumes = {0};
    int status = check_report(arguments);
    if (status)
        return status;
    status = pl_job_read(&job, arguments);
    if (!status)
        status = measure_job(&job, &volumes);
    pl_volumes_free(&volumes);
    pl_job_close(&job);
    return status;
}
