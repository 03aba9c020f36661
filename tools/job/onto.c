/* onto: the surface of the mesh is fitted to that of another file. */
#include "job/onto.h"

#include "job/joined.h"
#include "terminal/message.h"
#include "terminal/signals.h"

#include "base/clock.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where a fit takes the worst ratio so many times up that is said. */
static const double WORSE = 1.001;

/* ---- the other surface ---------------------------------------------------------------------- */

static int complain(const pl_job *job, const planish_error *error) {
    return pl_complain(PL_EXIT_FAILED, "--onto %s: %s", job->arguments->onto, error->text);
}

/** Return the tags that a file gives facets and edges. */
static planish_surface surface_of(const pl_job *job, const planish_file *file) {
    planish_hold hold = {.slide = 1};
    if (file == job->file) {
        hold = pl_job_hold(job);
        hold.slide = 1;
    }
    planish_surface surface = {.n_facets = 0};
    if (planish_file_mesh(file).dim == 3)
        surface = planish_file_surface(file, &hold);
    surface.crease_angle = job->arguments->crease_angle;
    return surface;
}

/** Make the shape of the other surface. */
static int make_other(pl_job *job, const planish_mesh *mesh, const planish_surface *surface,
                      planish_error *error) {
    planish_shape_destroy(job->onto.shape);
    job->onto.shape = NULL;
    return planish_shape_create(mesh, surface, job->options.threads, &job->onto.shape,
                                &job->onto.info, error)
               ? complain(job, error)
               : 0;
}

/** Take the facets of the other surface, but for collapsed ones, if it has no other elements. */
static int take_facets(pl_job *job, planish_mesh *mesh, planish_surface *surface,
                       pl_joined *joined) {
    if (!mesh->cells)
        return 0;
    if (!pl_joined_take(mesh, surface, joined))
        return pl_job_complain_memory(job, "the other surface");
    if (joined->cells.n == 0)
        return 0;
    job->onto.n_left_out = joined->n_left_out;
    job->onto.n_quadrilaterals_out = joined->n_quadrilaterals_out;
    mesh->cells = &joined->cells;
    mesh->n_elements = joined->cells.n;
    surface->region = joined->region;
    surface->edges = joined->edges;
    return 0;
}

/** Make the shape of the other surface again if its facets are to be joined. */
static int join_other(pl_job *job, planish_mesh *mesh, const planish_surface *surface,
                      pl_joined *joined, planish_error *error) {
    pl_onto *onto = &job->onto;
    if (joined->cells.n == 0 ||
        (onto->info.n_open_edges == 0 && onto->info.n_nonmanifold_edges == 0))
        return 0;
    if (!pl_joined_join(mesh, surface->n_edges, joined))
        return pl_job_complain_memory(job, "the other surface");
    if (joined->cells.n == 0 || (joined->n_points == 0 && joined->n_left_out == onto->n_left_out))
        return 0;
    onto->n_joined = joined->n_points;
    onto->n_left_out = joined->n_left_out;
    onto->n_quadrilaterals_out = joined->n_quadrilaterals_out;
    mesh->n_elements = joined->cells.n;
    return make_other(job, mesh, surface, error);
}

/** Take the elements of a flat mesh, and its coordinates in space. */
static int take_flat(pl_job *job, planish_file *file, planish_mesh *mesh, planish_cells *cells,
                     double *places, planish_error *error) {
    int code = planish_file_cells(file, cells, error);
    if (!code)
        code = planish_file_space_coordinates(file, 0, mesh->n_nodes, mesh->coordinates, places,
                                              error);
    *mesh = (planish_mesh){.dim = 3,
                           .n_nodes = mesh->n_nodes,
                           .n_elements = cells->n,
                           .cells = cells,
                           .coordinates = places};
    return code ? complain(job, error) : 0;
}

/** Read the file of --onto, make its shape, and find its box. */
static int read_other(pl_job *job, pl_job_box *box) {
    const planish_open_options how = {.threads = job->options.threads, .isolated = 1};
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open_with(job->arguments->onto, &how, &file, &error))
        return pl_complain(PL_EXIT_FAILED, "--onto: %s", error.text);
    planish_surface surface = surface_of(job, file);
    planish_mesh mesh = planish_file_mesh(file);
    planish_cells cells;
    pl_joined joined = {.node = NULL};
    double *places = malloc(((size_t)mesh.n_nodes * 3 + 1) * sizeof *places);
    int status = places ? 0 : pl_job_complain_memory(job, "the other surface");
    if (!status && mesh.dim == 2)
        status = take_flat(job, file, &mesh, &cells, places, &error);
    if (!status)
        status = take_facets(job, &mesh, &surface, &joined);
    if (!status)
        status = make_other(job, &mesh, &surface, &error);
    if (!status)
        status = join_other(job, &mesh, &surface, &joined, &error);
    if (!status)
        pl_job_box_widen(box, 3, mesh.coordinates, mesh.n_nodes);
    pl_joined_free(&joined);
    free(places);
    planish_file_close(file);
    return status;
}

/* ---- the fit --------------------------------------------------------------------------------- */

static int stop_if_asked(const planish_progress *step, void *user) {
    (void)step;
    (void)user;
    return pl_signals_stop_asked();
}

/** Find the places of nodes, as the file, without its marks if asked, and options hold them. Points, lines,
 *  facets and interfaces that the file lists only say where something ends. */
static int find_places(pl_job *job, int ignore_marked) {
    const uint8_t none = PLANISH_FILE_LINE_OR_POINT | PLANISH_FILE_FACE | PLANISH_FILE_INTERFACE;
    planish_error error;
    pl_onto *onto = &job->onto;
    planish_hold hold = pl_job_hold(job);
    hold.ignore_marked = ignore_marked;
    if (planish_file_get_held(job->file, &hold, job->constraint, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    for (int64_t i = 0; i < job->mesh.n_nodes; i++)
        job->constraint[i] = job->constraint[i] & (uint8_t)~none ? PLANISH_CONSTRAINT_FIXED
                                                                 : PLANISH_CONSTRAINT_FREE;
    pl_job_hold_layers(job, job->constraint);
    planish_fit_destroy(onto->fit);
    onto->fit = NULL;
    if (!planish_fit_create(&job->mesh, onto->own, onto->shape, 0, &job->options, &onto->fit,
                            &onto->before, &error))
        return 0;
    /* An element or node is one of the input. */
    return error.element >= 0 || error.node >= 0 ? pl_job_complain(job, PL_EXIT_FAILED, &error)
                                                 : complain(job, &error);
}

/** Move the nodes; of the time limit the rest is for smoothing. */
static int move_nodes(pl_job *job) {
    const double least = 1e-6, begin = pl_seconds();
    planish_options options = job->options;
    planish_error error;
    options.progress = stop_if_asked;
    if (planish_fit_move(job->onto.fit, &job->mesh, planish_file_coordinates(job->file), &options,
                         &job->onto.after, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    if (job->options.time_limit > 0)
        job->options.time_limit = fmax(least, job->options.time_limit - (pl_seconds() - begin));
    return 0;
}

/** Set job->goal to the box of the mesh, and of what of the other surface, in box, is near it: nodes may still
 *  come there. */
static void bound_goal(pl_job *job, const pl_job_box *box) {
    const double part = 0.1; /* of the longest side: the other surface may be that of much more */
    pl_job_box *goal = &job->goal;
    double size = 0;
    pl_job_box_widen(goal, 3, job->mesh.coordinates, job->mesh.n_nodes);
    for (int d = 0; d < 3; d++)
        size = fmax(size, goal->high[d] - goal->low[d]);
    const double near = fmax(part * size, job->onto.after.farthest);
    for (int d = 0; d < 3; d++) {
        goal->low[d] = fmin(goal->low[d], fmax(box->low[d], goal->low[d] - near));
        goal->high[d] = fmax(goal->high[d], fmin(box->high[d], goal->high[d] + near));
    }
}

/** Measure the mesh before anything moves. */
static int measure_before(pl_job *job) {
    planish_error error;
    planish_quality quality;
    planish_options options;
    planish_options_init(&options);
    options.threads = job->options.threads;
    options.size_weight = job->options.size_weight; /* ratios are against sizes in the end, too */
    if (planish_measure_mesh(&job->mesh, &options, &quality, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    job->onto.worst_before = quality.max_radius_ratio;
    job->onto.input_checksum = pl_job_checksum(job);
    return 0;
}

int pl_onto_fit(pl_job *job) {
    planish_error error;
    pl_onto *onto = &job->onto;
    const double begin = pl_seconds();
    pl_job_box other = {.is_known = 0};
    int status;
    if (!job->arguments->onto)
        return 0;
    if (job->engine != &pl_engine_here || !job->file)
        return pl_complain(PL_EXIT_FAILED,
                           "--onto needs a single process: use planish, not planish-mpi");
    if (job->mesh.dim == 2 || job->mesh.n_elements == 0)
        return pl_complain(PL_EXIT_FAILED,
                           "%s: has no solid elements: --onto fits the surface of solid elements "
                           "to another surface",
                           job->arguments->input);
    pl_signals_install_stop();
    if ((status = read_other(job, &other)))
        return status;
    const planish_surface surface = surface_of(job, job->file);
    if (planish_shape_create(&job->mesh, &surface, job->options.threads, &onto->own, NULL, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    if ((status = find_places(job, 0)))
        return status;
    /* Where the file marks all of the surface it says no more than where that is. */
    if (onto->before.n_held == onto->before.n_nodes &&
        planish_file_get_marked(job->file, NULL) > 0 && (status = find_places(job, 1)))
        return status;
    if ((status = measure_before(job)) || (status = move_nodes(job)))
        return status;
    bound_goal(job, &other);
    planish_fit_constrain(onto->fit, job->constraint);
    job->options.project = planish_fit_project;
    job->options.project_user = onto->fit;
    onto->seconds = pl_seconds() - begin;
    return 0;
}

int pl_onto_measure(pl_job *job) {
    planish_error error;
    if (!job->onto.fit)
        return 0;
    return planish_fit_measure(job->onto.fit, &job->mesh, &job->onto.distance, &error)
               ? pl_job_complain(job, PL_EXIT_FAILED, &error)
               : 0;
}

/** Say which points of the other surface were joined, and which facets are left out. */
static void note_joined(FILE *stream, const pl_onto *onto, const char *file) {
    if (onto->n_joined > 0)
        pl_note(stream, "%" PRId64 " point%s of %s %s where others are, and joined to them",
                onto->n_joined, onto->n_joined == 1 ? "" : "s", file,
                onto->n_joined == 1 ? "is" : "are");
    if (onto->n_left_out > 0)
        pl_note(stream, "%" PRId64 " %s%s of %s %s left out: without area, or there twice",
                onto->n_left_out, onto->n_quadrilaterals_out > 0 ? "facet" : "triangle",
                onto->n_left_out == 1 ? "" : "s", file, onto->n_left_out == 1 ? "is" : "are");
}

/** Say that the triangles of the other surface join nothing, as where each has points of its own. */
static void note_loose(FILE *stream, const planish_shape_info *info, const char *file) {
    const int64_t n_loose = info->n_open_edges + info->n_nonmanifold_edges;
    if (2 * info->n_patches <= info->n_facets || 2 * n_loose <= info->n_facets)
        return;
    pl_note(stream,
            "the %" PRId64 " triangles of %s are %" PRId64
            " patches, and nodes stay in theirs: join "
            "its points, and remove what is there twice",
            info->n_facets, file, info->n_patches);
}

void pl_onto_note(FILE *stream, const pl_job *job, double worst) {
    const pl_onto *onto = &job->onto;
    const char *file = job->arguments->onto;
    if (!onto->fit)
        return;
    note_joined(stream, onto, file);
    note_loose(stream, &onto->info, file);
    const int64_t n_far = onto->before.n_out_of_reach - onto->before.n_unclear;
    if (n_far > 0)
        pl_note(stream,
                "%" PRId64
                " node%s of the surface %s no place on %s within 3 mean edge lengths, and stay%s",
                n_far, n_far == 1 ? "" : "s", n_far == 1 ? "has" : "have", file,
                n_far == 1 ? "s" : "");
    if (onto->before.n_unclear > 0)
        pl_note(stream,
                "%" PRId64
                " nodes of the surface stay: several pieces of it are nearest to the same "
                "one of %s. Bring it nearer, or fit the bodies one by one",
                onto->before.n_unclear, file);
    if (onto->before.n_unused > 0)
        pl_note(stream, "%" PRId64 " piece%s of %s %s no node of the mesh", onto->before.n_unused,
                onto->before.n_unused == 1 ? "" : "s", file,
                onto->before.n_unused == 1 ? "has" : "have");
    if (onto->before.n_cut > 0)
        pl_note(stream,
                "%" PRId64 " corner%s of the surface %s not at a corner of %s, though one is near: "
                "edges are cut off there",
                onto->before.n_cut, onto->before.n_cut == 1 ? "" : "s",
                onto->before.n_cut == 1 ? "is" : "are", file);
    if (onto->before.n_held > 0)
        pl_note(stream, "%" PRId64 " node%s of the surface %s held, and not fitted to %s",
                onto->before.n_held, onto->before.n_held == 1 ? "" : "s",
                onto->before.n_held == 1 ? "is" : "are", file);
    if (worst > onto->worst_before * WORSE)
        pl_note(stream,
                "fitting changed the worst %s ratio from %.4g to %.4g; smoothing makes no element "
                "worse than that",
                job->has_types ? "aspect" : "radius", onto->worst_before, worst);
}
