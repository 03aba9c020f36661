/* quality: the command `planish quality`: what meshes are worth; nothing is changed.
 *
 * One mesh is told in full. Several are read, measured and released one after another, and compared
 * in the end; one that cannot be measured has its message, and the others go on.
 */
#include "commands/commands.h"
#include "options/combinations.h"

#include "report/comparison.h"
#include "job/curved.h"
#include "job/entities.h"
#include "job/held.h"
#include "job/job.h"
#include "job/layers.h"
#include "terminal/message.h"
#include "job/output.h"
#include "terminal/platform.h"
#include "job/progress.h"
#include "report/page.h"
#include "report/result.h"
#include "report/table.h"
#include "terminal/text.h"
#include "job/states.h"
#include "job/worst.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/** State that the meshes of a command line share. */
typedef struct quality_run {
    const pl_arguments *arguments;
    pl_progress progress;
    pl_quality_report report;
    pl_picture *picture; /* for a page, owned, or NULL */
    FILE *stream;        /* for tables */
    pl_compared *mesh;   /* [n] those that were measured; owned */
    int n;
} quality_run;

static int is_comparison(const quality_run *r) {
    return r->arguments->n_inputs > 1;
}

/** Keep the notes of a mesh until its row is printed. */
static int keep_notes(const quality_run *r, const pl_job *job, pl_compared *mesh) {
    if (r->arguments->verbosity == PL_QUIET || !is_comparison(r))
        return 0;
    pl_memory_stream stream;
    pl_memory_stream_open(&stream);
    if (stream.file) {
        pl_table_oddities(stream.file, job);
        pl_table_reversed(stream.file, &mesh->measured.quality);
        pl_held_note(stream.file, job);
        pl_layers_print(stream.file, job);
    }
    mesh->notes = pl_memory_stream_close(&stream);
    if (!mesh->notes)
        return pl_complain(PL_EXIT_FAILED, "%s: out of memory for the notes", mesh->name);
    return 0;
}

/** There is no memory for the meshes together. */
static int complain_meshes(const pl_arguments *arguments, const char *what) {
    return pl_complain(PL_EXIT_FAILED, "%s (and %d more): out of memory for %s",
                       arguments->inputs[0], arguments->n_inputs - 1, what);
}

/** All of one mesh. */
static void print_table(quality_run *r, const pl_job *job, const pl_measured *measured) {
    if (r->arguments->verbosity == PL_QUIET || is_comparison(r))
        return;
    pl_progress_clear(&r->progress);
    pl_table_oddities(stderr, job);
    pl_table_quality(r->stream, job, measured);
    pl_table_worst(r->stream, &measured->worst, r->arguments->n_worst);
    pl_volumes_print(stderr, job, &measured->volumes);
    pl_reversed_print(stderr, job, measured->reversed, measured->quality.n_reversed);
    pl_table_reversed(stderr, &measured->quality);
    pl_layers_print(stderr, job);
    pl_held_note(stderr, job);
}

/** Measure the straight simplices, and find out what is odd about them. */
static int measure_simplices(quality_run *r, pl_job *job, pl_measured *measured) {
    int status;
    pl_progress_stage(&r->progress, PL_STAGE_PLANNING);
    if ((status = pl_job_plan(job)))
        return status;
    pl_progress_stage(&r->progress, PL_STAGE_MEASURING);
    if ((status = pl_job_count_bound(job)))
        return status;
    if ((status = pl_held_count(job)))
        return status;
    if (pl_job_is_told(job) && (status = pl_entities_count(job)))
        return status;
    if (pl_job_is_told(job) && (status = pl_job_count_slides(job)))
        return status;
    if ((status = pl_job_measure(job, &measured->quality)))
        return status;
    if (pl_job_is_told(job) && (status = pl_layers_count(job, &measured->quality)))
        return status;
    const double fraction = job->options.min_volume_fraction;
    const double least =
        fraction > 0 ? fraction * fabs(measured->quality.total_volume) : job->options.min_volume;
    if ((status = pl_volumes_find(job, least, NULL, &measured->volumes)))
        return status;
    return pl_job_is_told(job)
               ? pl_reversed_find(job, measured->quality.n_reversed, &measured->reversed)
               : 0;
}

/** Find the features of a surface for the picture, and how far it is off that of another file. */
static int measure_surface(pl_job *job, pl_surface_state *state) {
    const pl_arguments *arguments = job->arguments;
    if (!arguments->surface_of && arguments->report)
        pl_curved_try(job);
    if (!arguments->surface_of)
        return 0;
    int status = pl_curved_create(job);
    if (!status)
        status = pl_curved_measure(job, &state->after);
    state->is_known = !status;
    return status;
}

static int measure_job(quality_run *r, pl_job *job, pl_compared *mesh) {
    pl_measured *measured = &mesh->measured;
    int status = job->is_surface ? pl_curved_create(job) : 0;
    if (status)
        return status;
    status = job->mesh.n_elements > 0 ? measure_simplices(r, job, measured)
                                      : pl_job_measure(job, &measured->quality);
    if (status)
        return status;
    pl_progress_stage(&r->progress, PL_STAGE_MEASURING);
    if ((status = pl_cells_measure(job, &measured->cells)))
        return status;
    if (job->is_surface && (status = pl_held_find_in_run(job)))
        return status;
    if ((status = pl_worst_find_asked(job, &measured->cells, &measured->worst)))
        return status;
    if ((status = measure_surface(job, &measured->surface)))
        return status;
    if (pl_job_is_told(job) && (status = pl_heights_begin(job)))
        return status;
    if (pl_job_is_told(job) && (status = pl_heights_measure(job, &measured->heights)))
        return status;
    print_table(r, job, measured);
    if ((status = keep_notes(r, job, mesh)))
        return status;
    if ((status = pl_report_draw(job, "mesh", &r->picture)))
        return status;
    if (r->arguments->output && (status = pl_cells_convert(job, r->arguments->output)))
        return status;
    if (r->arguments->json || r->arguments->report)
        pl_quality_report_add(&r->report, job, measured);
    return 0;
}

static void free_compared(pl_compared *mesh) {
    pl_worst_free(&mesh->measured.worst);
    free(mesh->notes);
    mesh->notes = NULL;
}

/** One mesh, from its file to a row of the comparison. */
static int measure_file(quality_run *r, const char *input) {
    pl_arguments arguments = *r->arguments;
    pl_compared *mesh = &r->mesh[r->n];
    pl_job job;
    arguments.input = input;
    mesh->name = input;
    pl_progress_stage(&r->progress, PL_STAGE_READING);
    int status = pl_job_read(&job, &arguments, &pl_engine_here);
    if (!status)
        status = measure_job(r, &job, mesh);
    mesh->n_elements =
        mesh->measured.cells.has_others ? mesh->measured.cells.cells.n : job.mesh.n_elements;
    pl_job_close(&job);
    pl_cells_free(&mesh->measured.cells);
    pl_volumes_free(&mesh->measured.volumes);
    free(mesh->measured.reversed);
    mesh->measured.reversed = NULL;
    if (status)
        free_compared(mesh);
    else
        r->n++;
    return status;
}

static int print_comparison(const quality_run *r) {
    const int n_worst = r->arguments->n_worst;
    if (r->arguments->verbosity == PL_QUIET || !is_comparison(r))
        return 0;
    if (pl_comparison_print(r->stream, r->mesh, r->n, pl_arguments_bound_volumes(r->arguments)))
        return complain_meshes(r->arguments, "the table");
    for (int i = 0; i < r->n && n_worst > 0; i++) {
        fputc('\n', r->stream);
        pl_text_put(r->stream, r->mesh[i].name);
        fputs(":\n", r->stream);
        pl_table_worst(r->stream, &r->mesh[i].measured.worst, n_worst);
    }
    fflush(r->stream);               /* what is odd about a mesh comes behind its row */
    for (int i = 0; i < r->n; i++) { /* "note: NAME: TEXT" for each */
        const int skip = (int)strlen("note: ");
        for (const char *line = r->mesh[i].notes; line && *line;) {
            const int length = (int)strcspn(line, "\n");
            pl_note(stderr, "%s: %.*s", r->mesh[i].name, length - skip, line + skip);
            line += length + (line[length] == '\n');
        }
    }
    return 0;
}

/** All meshes; the status is the worst of theirs. */
static int measure_all(quality_run *r) {
    const pl_arguments *arguments = r->arguments;
    int status = 0;
    for (int i = 0; i < arguments->n_inputs; i++) {
        r->progress.file = i;
        const int of_file = measure_file(r, arguments->inputs[i]);
        if (of_file && is_comparison(r))
            status = PL_EXIT_FAILED;
        else if (of_file)
            status = of_file;
    }
    pl_progress_clear(&r->progress);
    const int table = print_comparison(r);
    int report = 0;
    if ((arguments->json || arguments->report) && (r->n > 0 || is_comparison(r))) {
        char *text = pl_quality_report_finish(&r->report, is_comparison(r));
        report = pl_reports_write(arguments, text, r->picture, PL_EXIT_FAILED);
        free(text);
    }
    if (!status)
        status = table ? table : report;
    return pl_flush_stdout(status, PL_EXIT_FAILED);
}

int pl_quality_command(const pl_arguments *arguments) {
    quality_run r = {.arguments = arguments};
    int status = pl_output_check_all(arguments);
    if (status)
        return status;
    r.stream = pl_output_takes_stdout(arguments) ? stderr : stdout;
    r.mesh = calloc((size_t)arguments->n_inputs, sizeof *r.mesh);
    if (!r.mesh)
        return complain_meshes(arguments, "the figures");
    pl_progress_init(&r.progress, arguments);
    pl_quality_report_begin(&r.report);
    status = measure_all(&r);
    pl_quality_report_free(&r.report);
    pl_picture_free(r.picture);
    for (int i = 0; i < r.n; i++)
        free_compared(&r.mesh[i]);
    pl_progress_free(&r.progress);
    free(r.mesh);
    return status;
}
