/* steps: a mesh that has been read is planned, measured, smoothed, measured and checked.
 *
 * Every step returns 0, or an exit status after a message; the first that fails ends the run.
 */
#include "commands/steps.h"

#include "commands/promises.h"
#include "commands/rounds.h"
#include "job/curved.h"
#include "job/entities.h"
#include "job/heights.h"
#include "job/held.h"
#include "job/layers.h"
#include "job/moved.h"
#include "job/onto.h"
#include "job/states.h"
#include "job/unjoined.h"
#include "job/valid_ratios.h"
#include "report/history.h"
#include "report/page.h"
#include "report/table.h"
#include "terminal/message.h"
#include "terminal/platform.h"
#include "terminal/terminal.h"
#include "terminal/text.h"

#include "base/status.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

static int has_mids(const planish_cells *cells) {
    for (int64_t i = 0; cells && i < cells->n; i++)
        if (cells->offset[i + 1] - cells->offset[i] >
            pl_cell_corners((planish_cell_type)cells->type[i]))
            return 1;
    return 0;
}

/** Say that nodes with boundary conditions may move, and what holds them. */
static void note_supported(const pl_job *job) {
    enum { MOST_NAMED = 6 };
    const char *const *group = planish_file_supported_groups(job->file);
    pl_memory_stream stream;
    if (job->n_supported == 0)
        return;
    pl_memory_stream_open(&stream);
    for (int i = 0; stream.file && group[i]; i++) {
        fputs(i == 0           ? "; hold them with --fix "
              : i < MOST_NAMED ? " --fix "
                               : " ...",
              stream.file);
        if (i == MOST_NAMED)
            break;
        pl_text_put_word(stream.file, group[i]);
    }
    char *options = pl_memory_stream_close(&stream);
    pl_note(stderr,
            "%" PRId64 " of the %" PRId64
            " nodes with boundary conditions in the file may move%s%s",
            job->n_supported, planish_file_get_supported(job->file, NULL),
            has_mids(job->mesh.cells) ? ", and mid-side nodes follow" : "", options ? options : "");
    free(options);
}

/** Print what is odd about the mesh, and with -v how it is worked on. */
static void print_plan(const pl_job *job) {
    const planish_plan_info *info = &job->plan_info;
    char text[512];
    if (job->arguments->verbosity != PL_QUIET)
        pl_table_oddities(stderr, job);
    if (job->arguments->verbosity != PL_QUIET && job->n_with_parameters > 0)
        pl_note(stderr,
                "%" PRId64 " movable %s geometry parameters (u, v) in the "
                "file, which planish does not update. Remove them before you refine or curve the "
                "mesh (docs/formats.md)",
                job->n_with_parameters, job->n_with_parameters == 1 ? "node has" : "nodes have");
    if (job->arguments->verbosity != PL_QUIET)
        note_supported(job);
    if (job->arguments->verbosity != PL_QUIET && job->file_info.has_normals &&
        info->n_free + info->n_sliding > 0)
        pl_note(stderr, "the file has normals of nodes, which planish does not update: the normals "
                        "of moved nodes are out of date (docs/formats.md)");
    if (job->arguments->verbosity < PL_VERBOSE)
        return;
    if (job->is_surface) {
        snprintf(text, sizeof text, "%d thread%s", info->threads, info->threads == 1 ? "" : "s");
        pl_terminal_wrap(stderr, text);
        pl_held_print(stderr, job);
        return;
    }
    snprintf(text, sizeof text, "%d thread%s (%s), kernel %s, %d colour%s, plan of %.1f MB",
             info->threads, info->threads == 1 ? "" : "s", info->binding, info->isa,
             info->n_colours, info->n_colours == 1 ? "" : "s", (double)info->bytes / 1e6);
    pl_terminal_wrap(stderr, text);
    pl_held_print(stderr, job);
}

/** Collect for the reports the mesh as it is now, called name. */
static int take_for_reports(const pl_job *job, const char *name, const pl_cells_validity *validity,
                            uint64_t *checksum, pl_worst *worst, pl_picture **picture) {
    pl_cells cells = {.has_others = job->has_types};
    if (!job->mesh.coordinates)
        return 0; /* the engine has the mesh */
    if (job->arguments->json || job->arguments->report)
        *checksum = pl_job_checksum(job);
    if (job->has_types) {
        cells.cells = *job->mesh.cells;
        cells.aspect_ratio = validity->aspect_ratio;
    }
    const int status = pl_worst_find_asked(job, &cells, worst);
    return status ? status : pl_report_draw(job, name, picture);
}

/** Measure the surface and the volumes of regions, before or after. */
static int measure_surface(const pl_job *job, int is_after, pl_result *result) {
    pl_surface_state *state = &result->surface;
    int status = 0;
    if (is_after || job->arguments->surface_of)
        status = pl_curved_measure(job, is_after ? &state->after : &state->before);
    state->is_known = !status && is_after;
    return status ? status : pl_volumes_of_regions(job, is_after, state);
}

/** From the mesh that was read to the sweeps: plan and measure. */
static int prepare(pl_job *job, pl_result *result, pl_progress *progress) {
    const int is_told = pl_job_is_told(job);
    int status;
    pl_progress_stage(progress, PL_STAGE_PLANNING);
    if (job->mesh.cells && !job->is_surface)
        job->options.rounding = pl_cells_rounding(job);
    if ((status = pl_onto_fit(job)))
        return status;
    if ((status = pl_job_find_slides(job)))
        return status;
    if ((status = pl_job_plan(job)))
        return status;
    pl_progress_stage(progress, PL_STAGE_MEASURING);
    if ((status = pl_job_count_bound(job)))
        return status;
    if ((status = pl_held_count(job)))
        return status;
    if (is_told && (status = pl_entities_count(job)))
        return status;
    if (is_told && (status = pl_unjoined_count(job)))
        return status;
    print_plan(job);
    if (is_told && (status = pl_job_count_slides(job)))
        return status;
    if ((status = pl_measure_valid(job, &result->before, &result->validity_before)))
        return status;
    if (is_told && (status = pl_layers_count(job, &result->before)))
        return status;
    if (is_told && (status = pl_heights_begin(job)))
        return status;
    if (job->arguments->verbosity != PL_QUIET) {
        pl_layers_print(stderr, job);
        pl_curved_note_held(stderr, job, result->validity_before.quality.all.n_curved,
                            result->before.n_inverted);
        pl_onto_note(stderr, job, result->before.max_radius_ratio);
    }
    if (job->curved.shape && (status = measure_surface(job, 0, result)))
        return status;
    if ((status = pl_volumes_count(job, &result->below_before)))
        return status;
    if ((status = pl_reversed_find(job, result->before.n_reversed, &result->reversed.before)))
        return status;
    const int is_compared = job->arguments->command == PL_COMMAND_COMPARE; /* whoever moved nodes */
    if (!is_compared && (status = pl_held_find_in_run(job)))
        return status;
    status = take_for_reports(job, "before", &result->validity_before, &result->input_checksum,
                              &result->worst_before, &result->picture);
    if (job->onto.fit) /* the file's, not that of the mesh as it was fitted */
        result->input_checksum = job->onto.input_checksum;
    return status;
}

/** Find out what came of the sweeps, and whether it may be written. */
static int check_result(pl_job *job, pl_result *result) {
    const planish_result *smooth = &result->smooth;
    int status;
    if ((status = pl_promises_keep(job, result)))
        return status;
    if ((status = pl_measure_valid(job, &result->after, &result->validity_after)))
        return status;
    if ((status = pl_volumes_find(job, smooth->min_volume, smooth, &result->volumes)))
        return status;
    const int64_t n_inverted =
        job->has_types ? pl_cells_validity_faults(&result->validity_after, &result->after)
                       : result->after.n_inverted;
    if ((status = pl_unfixable_find(job, n_inverted, smooth, &result->unfixable)))
        return status;
    if ((status = pl_unfixable_add_inside(job, &result->validity_after, smooth->n_infeasible_curved,
                                          &result->unfixable)))
        return status;
    if ((status = pl_reversed_compare(job, &result->after, &result->reversed)))
        return status;
    if (job->curved.shape && (status = measure_surface(job, 1, result)))
        return status;
    if ((status = pl_onto_measure(job)))
        return status;
    if (pl_job_is_told(job) && (status = pl_heights_measure(job, &result->heights)))
        return status;
    return pl_promises_check(job, result);
}

/** Complain of a mesh without any element that is smoothed, and say what it has. */
static int complain_of_types(const pl_job *job) {
    planish_error error;
    planish_cells cells;
    char counts[256];
    if (planish_file_cells(job->file, &cells, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    pl_cells_count(&cells, counts, sizeof counts);
    return pl_complain(PL_EXIT_FAILED,
                       "%s: %s: 'planish quality' measures these elements, but planish does not "
                       "smooth them; their nodes stay",
                       job->arguments->input, counts);
}

/** Whether an element of the mesh is of a type that is smoothed. */
static int has_smoothed(const pl_job *job) {
    const planish_cells *cells = job->mesh.cells;
    int has_simplex = !cells && job->mesh.n_elements > 0;
    for (int64_t i = 0; cells && i < cells->n && !has_simplex; i++)
        has_simplex = pl_cell_is_simplex((planish_cell_type)cells->type[i]);
    return has_simplex || job->has_types;
}

int pl_steps_check(const pl_job *job) {
    return job->file && !has_smoothed(job) ? complain_of_types(job) : 0;
}

/** From the sweeps to the result. */
static int smooth(pl_job *job, pl_result *result, pl_listeners *to) {
    int status;
    if ((status = pl_rounds_smooth(job, result, to)))
        return status;
    pl_progress_stage(to->progress, PL_STAGE_CHECKING);
    if ((status = check_result(job, result)))
        return status;
    /* That takes no more memory than it did before the sweeps, and is no reason to lose the mesh. */
    result->lacks_reports =
        take_for_reports(job, "after", &result->validity_after, &result->checksum,
                         &result->worst_after, &result->picture) != 0;
    if (!result->lacks_reports)
        result->lacks_history = pl_history_end(to->history, result->picture, &result->smooth) != 0;
    return 0;
}

int pl_steps_smooth(pl_job *job, pl_result *result, pl_progress *progress) {
    pl_listeners to = {.progress = progress};
    int status = prepare(job, result, progress);
    if (!status)
        status = pl_history_begin(job, result->picture, &to.history);
    if (!status)
        status = smooth(job, result, &to);
    job->options.progress = NULL; /* the listeners are gone */
    pl_history_free(to.history);
    return status;
}

int pl_steps_compare(pl_job *job, const planish_file *after, pl_result *result,
                     pl_progress *progress) {
    int status;
    if (job->arguments->report && (status = pl_moved_bound(job, after)))
        return status;
    if ((status = prepare(job, result, progress)))
        return status;
    if ((status = pl_moved_take(job, after, &result->smooth)))
        return status;
    pl_progress_stage(progress, PL_STAGE_CHECKING);
    if ((status = pl_measure_valid(job, &result->after, &result->validity_after)))
        return status;
    if ((status = pl_reversed_compare(job, &result->after, &result->reversed)))
        return status;
    if (pl_job_is_told(job) && (status = pl_heights_measure(job, &result->heights)))
        return status;
    result->before.n_fixed_elements = result->after.n_fixed_elements = 0; /* whatever moved them */
    status = take_for_reports(job, "after", &result->validity_after, &result->checksum,
                              &result->worst_after, &result->picture);
    if (job->arguments->json || job->arguments->report)
        result->checksum = pl_moved_checksum(after); /* of what the file has, to its last bit */
    return status;
}

void pl_steps_free(pl_result *result) {
    pl_cells_validity_free(&result->validity_before);
    pl_cells_validity_free(&result->validity_after);
    pl_volumes_free(&result->volumes);
    pl_unfixable_free(&result->unfixable);
    pl_reversed_free(&result->reversed);
    pl_surface_state_free(&result->surface);
    pl_worst_free(&result->worst_before);
    pl_worst_free(&result->worst_after);
    pl_picture_free(result->picture);
}
