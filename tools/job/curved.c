/* curved: curved surfaces: the shape that nodes slide on, how far the surface is off it, and volumes.
 */
#include "job/curved.h"
#include "options/combinations.h"

#include "job/cell_types.h"
#include "job/engine.h"
#include "job/same.h"
#include "terminal/message.h"

#include "geometry/cell.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* So many tolerances may be between the surfaces before a warning. Each step of the run was within one:
 * the bound at the end is a little above, as it looks for the places of nodes anew. */
static const double MOST_THERE = 1.1, MOST_BACK = 1.5;

int pl_curved_is_asked(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const int is_planar = job->mesh.dim == 2 && arguments->curved_if_any; /* as auto there */
    return arguments->slide && arguments->slide_curved && job->file && !is_planar;
}

/* ---- surfaces in space -------------------------------------------------------------------------- */

int pl_curved_is_surface(const planish_mesh *mesh) {
    return mesh->dim == 3 && mesh->cells && mesh->cells->n > 0 && pl_cells_are_flat(mesh->cells);
}

/** The first option that was given and means nothing on a surface, or NULL. */
static const char *find_meaningless(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const planish_options *library = &arguments->library;
    return library->method != PLANISH_METHOD_PLANISH            ? "--method"
           : library->objective == PLANISH_OBJECTIVE_EDGE_RATIO ? "--objective edge-ratio"
           : library->objective == PLANISH_OBJECTIVE_MEAN_RATIO && !job->has_types
               ? "--objective mean-ratio without quadrilaterals"
           : library->search != PLANISH_SEARCH_NEWTON ? "--direction"
           : pl_arguments_bound_volumes(arguments)    ? "a minimum volume"
           : arguments->layers == PL_LAYERS_HELD      ? "--layers hold"
           : arguments->slide_interfaces              ? "--slide-interfaces"
           : arguments->onto                          ? "--onto"
                                                      : pl_arguments_target(arguments);
}

int pl_curved_begin_surface(pl_job *job) {
    const char *const meaningless = find_meaningless(job);
    if (meaningless)
        return pl_complain_usage(pl_command_name(job->arguments->typed),
                                 "%s is a surface in space: %s has no effect there, leave it out",
                                 job->arguments->input, meaningless);
    if (job->engine != &pl_engine_here)
        return pl_complain(
            PL_EXIT_FAILED,
            "%s: is a surface in space, which needs a single process: use planish, not planish-mpi",
            job->arguments->input);
    job->own = *job->arguments;
    job->own.slide_curved = !job->own.slide_given || job->own.slide_curved || !job->own.slide ||
                            job->own.n_slide_tags > 0;
    job->own.slide = 1;
    job->arguments = &job->own;
    job->engine = &pl_engine_of_surface;
    return 0;
}

void pl_curved_hold(pl_job *job) {
    const planish_constraint none[] = {PLANISH_CONSTRAINT_ON_LINE, PLANISH_CONSTRAINT_ON_CURVE};
    const planish_cells *cells = planish_file_mesh(job->file).cells;
    for (int64_t i = 0; job->own.slides_none && i < job->mesh.n_nodes; i++)
        if (job->constraint[i] == none[0] || job->constraint[i] == none[1])
            job->constraint[i] = PLANISH_CONSTRAINT_FIXED;
    /* Mids would have to follow along the surface. */
    for (int64_t i = 0; i < cells->n; i++)
        for (int64_t k = cells->offset[i]; k < cells->offset[i + 1]; k++)
            if (cells->node[k] >= 0 && pl_cell_corners((planish_cell_type)cells->type[i]) <
                                           cells->offset[i + 1] - cells->offset[i])
                job->constraint[cells->node[k]] = PLANISH_CONSTRAINT_FIXED;
}

/* ---- the mesh that the surface comes from ------------------------------------------------------- */

/** Open the file of --surface-of, and check that its mesh is that of the input. */
static int open_original(const pl_job *job, const planish_mesh *mine, planish_file **file) {
    planish_error error;
    const planish_open_options how = {.format = job->arguments->format,
                                      .threads = job->options.threads,
                                      .isolated = 1,
                                      .plane_tolerance = job->arguments->slide_tolerance};
    if (planish_file_open_with(job->arguments->surface_of, &how, file, &error))
        return pl_complain(PL_EXIT_FAILED, "--surface-of: %s", error.text);
    const planish_mesh other = planish_file_mesh(*file);
    const pl_same_mesh of_input = {job->arguments->input, job->file, mine};
    const pl_same_mesh of_original = {job->arguments->surface_of, *file, &other};
    return pl_same_check(&of_input, &of_original,
                         "--surface-of: give the mesh that this one was made of");
}

/* ---- the shape ------------------------------------------------------------------------------------ */

/** Make the shape of a mesh that is the file's but for coordinates. Returns a planish_status. */
static int make_shape(pl_job *job, const double *coordinates, planish_error *error) {
    planish_hold hold = pl_job_hold(job);
    hold.slide = 1;
    planish_surface surface = planish_file_surface(job->file, &hold);
    planish_mesh mesh = planish_file_mesh(job->file);
    mesh.coordinates = coordinates;
    surface.crease_angle = job->arguments->crease_angle;
    const int code = planish_shape_create(&mesh, &surface, job->options.threads, &job->curved.shape,
                                          &job->curved.info, error);
    job->options.shape = job->curved.shape;
    return code;
}

int pl_curved_create(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const planish_mesh mesh = planish_file_mesh(job->file);
    planish_file *original = NULL;
    planish_error error;
    if (job->curved.shape)
        return 0;
    if (mesh.dim == 2)
        return pl_complain(
            PL_EXIT_FAILED,
            "%s: is a mesh in a plane, which has no curved surface: use --slide auto",
            arguments->input);
    int status = arguments->surface_of ? open_original(job, &mesh, &original) : 0;
    if (!status &&
        make_shape(job, original ? planish_file_coordinates(original) : mesh.coordinates, &error))
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    planish_file_close(original);
    return status;
}

void pl_curved_try(pl_job *job) {
    planish_error ignored;
    planish_file *original = NULL;
    const planish_mesh mesh = planish_file_mesh(job->file);
    if (mesh.dim != 3 || mesh.n_elements == 0 || job->curved.shape)
        return;
    int is_there = 1;
    if (job->arguments->surface_of) {
        is_there = !planish_file_open_with(
            job->arguments->surface_of,
            &(planish_open_options){.threads = job->options.threads, .isolated = 1}, &original,
            &ignored);
        const planish_mesh other = planish_file_mesh(original);
        is_there = is_there && pl_same_meshes(&mesh, &other);
    }
    if (is_there)
        make_shape(job, original ? planish_file_coordinates(original) : mesh.coordinates, &ignored);
    planish_file_close(original);
}

void pl_curved_destroy(pl_job *job) {
    planish_shape_destroy(job->curved.shape);
    job->curved.shape = NULL;
    job->options.shape = NULL;
}

void pl_curved_count(pl_job *job) {
    pl_curved *curved = &job->curved;
    memset(curved->n, 0, sizeof curved->n);
    for (int64_t i = 0; i < job->mesh.n_nodes; i++)
        curved->n[job->constraint[i]]++;
}

int pl_curved_measure(const pl_job *job, planish_shape_distance *distance) {
    planish_error error;
    planish_mesh mesh = planish_file_mesh(job->file);
    *distance = (planish_shape_distance){.distance = 0};
    return planish_shape_measure(job->curved.shape, &mesh, job->options.threads, distance, &error)
               ? pl_job_complain(job, PL_EXIT_FAILED, &error)
               : 0;
}

/** Whether a distance, absolute and in edges, is above factor times the tolerance in its unit. */
static int is_above(const pl_job *job, double factor, double distance, double in_edges) {
    const double usual = 0.05; /* planish_options.surface_tolerance */
    const planish_options *options = &job->options;
    const double rounding = 1e-9;
    if (options->surface_tolerance > 0 && options->surface_tolerance_unit == PLANISH_UNIT_MESH)
        return distance > factor * options->surface_tolerance * (1 + rounding);
    const double tolerance = options->surface_tolerance > 0 ? options->surface_tolerance : usual;
    return in_edges > factor * tolerance * (1 + rounding);
}

/* ---- volumes ---------------------------------------------------------------------------------------- */

/** Six times the volume below a triangle. */
static double below(const double *o, const double *a, const double *b, const double *c) {
    double u[3], v[3], w[3];
    for (int d = 0; d < 3; d++) {
        u[d] = a[d] - o[d];
        v[d] = b[d] - o[d];
        w[d] = c[d] - o[d];
    }
    return u[0] * (v[1] * w[2] - v[2] * w[1]) + u[1] * (v[2] * w[0] - v[0] * w[2]) +
           u[2] * (v[0] * w[1] - v[1] * w[0]);
}

/** Volume of an element between its corners; faces of four are bilinear, whose volume is the mean of
 *  both pairs of triangles. */
static double volume_of(const planish_mesh *mesh, int64_t element) {
    const planish_cells *cells = mesh->cells;
    const double *x = mesh->coordinates;
    double sum = 0;
    if (!cells) {
        const int32_t *node = mesh->elements + 4 * element;
        return fabs(below(x + 3 * (int64_t)node[0], x + 3 * (int64_t)node[1],
                          x + 3 * (int64_t)node[2], x + 3 * (int64_t)node[3])) /
               6;
    }
    const pl_cell_type *type = pl_cell_type_of(cells->type[element]);
    const int32_t *node = cells->node + cells->offset[element];
    if (!type || type->shape->dim != 3)
        return 0;
    for (int f = 0; f < type->shape->n_facets; f++) {
        const int8_t *facet = type->shape->facet[f];
        const double *at[4];
        for (int k = 0; k < 4; k++)
            at[k] = x + 3 * (int64_t)node[facet[k] < 0 ? 0 : facet[k]];
        const double *o = x + 3 * (int64_t)node[0];
        if (facet[3] < 0)
            sum += below(o, at[0], at[1], at[2]);
        else
            sum += (below(o, at[0], at[1], at[2]) + below(o, at[0], at[2], at[3]) +
                    below(o, at[0], at[1], at[3]) + below(o, at[1], at[2], at[3])) /
                   2;
    }
    return fabs(sum) / 6;
}

/** Make room for the regions of the mesh: region [n_elements], 0 and up, or NULL. */
static int make_regions(const pl_job *job, const int32_t *region, pl_surface_state *state) {
    int64_t n = 1;
    for (int64_t i = 0; region && i < job->mesh.n_elements; i++)
        n = region[i] >= n ? (int64_t)region[i] + 1 : n;
    state->region = calloc((size_t)n, sizeof *state->region);
    state->n_regions = n;
    if (!state->region)
        return pl_job_complain_memory(job, "the volumes of regions");
    for (int64_t i = job->mesh.n_elements - 1; i >= 0; i--)
        state->region[region ? region[i] : 0].element = i;
    return 0;
}

int pl_volumes_of_regions(const pl_job *job, int has_before, pl_surface_state *state) {
    const planish_hold hold = pl_job_hold(job);
    const int32_t *region = planish_file_surface(job->file, &hold).region;
    if (job->is_surface) /* which has none */
        return 0;
    const int status = has_before ? 0 : make_regions(job, region, state);
    for (int64_t i = 0; !status && i < job->mesh.n_elements; i++) {
        pl_region_volume *of = &state->region[region ? region[i] : 0];
        *(has_before ? &of->after : &of->before) += volume_of(&job->mesh, i);
    }
    return status;
}

void pl_surface_state_free(pl_surface_state *state) {
    free(state->region);
    *state = (pl_surface_state){.is_known = 0};
}

/* ---- notes -------------------------------------------------------------------------------------------- */

void pl_curved_note_held(FILE *stream, const pl_job *job, int64_t n_curved, int64_t n_inverted) {
    if (!job->curved.shape)
        return;
    if (job->mesh.n_periodic > 0)
        pl_note(stream, "periodic nodes slide only in planes and along straight lines: those of "
                        "curved surfaces do not move");
    if (n_curved > 0 && job->curved.info.n_mids == 0)
        pl_note(stream, "nodes at curved second-order edges of the surface do not move: the "
                        "mid-side nodes would leave the surface");
    if (n_inverted > 0 && !job->is_surface)
        pl_note(stream, "nodes of the surface do not move while planish repairs inverted elements; "
                        "they slide afterwards");
}

void pl_curved_note_result(FILE *stream, const pl_job *job, const pl_surface_state *state) {
    const planish_shape_distance *d = &state->after;
    if (!state->is_known)
        return;
    if (d->n_unproved > 0)
        pl_note(stream,
                "planish could not prove the distance from the original surface for %" PRId64
                " facet%s: look at the result there, or give a smaller --surface-tolerance",
                d->n_unproved, d->n_unproved == 1 ? "" : "s");
    if (is_above(job, MOST_THERE, d->distance, d->in_edges))
        pl_note(stream,
                "the surface is up to %.3g (%.3g h) off the original one, above the tolerance: "
                "some parts were that far off before, and planish left them there",
                d->distance, d->in_edges);
    if (is_above(job, MOST_BACK, d->distance_back, d->back_in_edges))
        pl_note(stream,
                "the original surface is up to %.3g (%.3g h) off the new one, more than "
                "%g tolerances: give a smaller --surface-tolerance",
                d->distance_back, d->back_in_edges, MOST_BACK);
}
