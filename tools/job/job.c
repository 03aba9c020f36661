/* job: what smooth and quality have in common: a mesh file, the nodes it holds, and a plan for it.
 */
#include "job/job.h"
#include "options/combinations.h"

#include "job/cells.h"
#include "job/curved.h"
#include "terminal/message.h"
#include "terminal/signals.h"
#include "terminal/threads.h"

#include "base/clock.h"
#include "base/nearer.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** Complain as pl_job_complain, but of the command line if an argument is wrong. */
static int complain_of_arguments(const pl_job *job, const planish_error *error) {
    if (error->code == PLANISH_ERROR_ARGUMENT)
        return pl_complain_usage(pl_command_name(job->arguments->typed), "%s", error->text);
    return pl_job_complain(job, PL_EXIT_FAILED, error);
}

/* ---- reading -------------------------------------------------------------------------------- */

/** Fill constraint with what the file and hold say. */
static int find_held(const pl_job *job, const planish_hold *hold, uint8_t *constraint) {
    static const char *const words[] = {"auto", "curved", "none"};
    const char *nearest = NULL;
    planish_error error;
    if (planish_file_constraints(job->file, hold, constraint, &error) == PLANISH_OK)
        return 0;
    for (int i = 0; i < hold->n_slide_tags; i++) /* an unknown one may be meant to be a word */
        for (size_t k = 0; k < sizeof words / sizeof *words && error.code == PLANISH_ERROR_ARGUMENT;
             k++)
            nearest = pl_nearer(hold->slide_tags[i], nearest, words[k]);
    if (nearest)
        return pl_complain_usage(pl_command_name(job->arguments->typed),
                                 "%s; did you mean --slide %s?", error.text, nearest);
    return complain_of_arguments(job, &error);
}

int pl_job_layer_mesh(const pl_job *job, planish_cells *cells, planish_mesh *mesh) {
    planish_error error;
    *mesh = job->mesh;
    if (!job->file || planish_file_mesh(job->file).n_elements + job->file_info.n_other_elements <=
                          job->mesh.n_elements)
        return 0;
    if (planish_file_cells(job->file, cells, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    mesh->cells = cells;
    mesh->elements = NULL;
    mesh->n_elements = cells->n;
    return 0;
}

int pl_job_find_layers(const pl_job *job, uint8_t **is_layer, int64_t *n) {
    planish_mesh mesh;
    planish_cells cells;
    planish_error error;
    *is_layer = NULL;
    *n = 0;
    const int status = pl_job_layer_mesh(job, &cells, &mesh);
    if (status)
        return status;
    *is_layer = malloc((size_t)mesh.n_elements + 1);
    if (!*is_layer)
        return pl_job_complain_memory(job, "values of elements");
    if (mesh.n_elements > 0 &&
        planish_find_layers(&mesh, job->options.threads, *is_layer, n, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    return 0;
}

void pl_job_hold_layers(const pl_job *job, uint8_t *constraint) {
    for (int64_t i = 0; job->in_layer && i < job->mesh.n_nodes; i++)
        if (job->in_layer[i])
            constraint[i] = PLANISH_CONSTRAINT_FIXED;
}

/** Put value at all nodes of an element. */
static void mark_nodes(const pl_job *job, int64_t element, uint8_t value, uint8_t *mark) {
    const planish_cells *cells = job->mesh.cells;
    const int corners = job->mesh.dim + 1;
    const int64_t begin = cells ? cells->offset[element] : element * corners;
    const int64_t end = cells ? cells->offset[element + 1] : begin + corners;
    const int32_t *node = cells ? cells->node : job->mesh.elements;
    for (int64_t k = begin; k < end; k++)
        if (node[k] >= 0)
            mark[node[k]] = value;
}

/** Whether layers of a type are kept unless an option says otherwise: wedges, hexahedra and quadrilaterals.
 */
static int is_kept_by_default(planish_cell_type type) {
    const int n = pl_cell_corners(type);
    return n == 6 || n == 8 || (n == 4 && !pl_cell_is_simplex(type));
}

/** Whether they are held where they cannot be kept. Quadrilaterals alone are not: meshes of these are often
 *  stretched throughout. */
static int is_held_by_default(planish_cell_type type, int has_triangles) {
    return is_kept_by_default(type) && (pl_cell_corners(type) != 4 || has_triangles);
}

/** Mark the elements whose layers are held, all or by their types; *n: their number. */
static void choose_types(const pl_job *job, uint8_t *is_chosen, int64_t *n) {
    const planish_cells *cells = job->mesh.cells;
    const int all = job->arguments->layers == PL_LAYERS_HELD;
    int has_triangles = 0;
    *n = 0;
    for (int64_t i = 0; cells && i < cells->n; i++)
        has_triangles |= pl_cell_corners((planish_cell_type)cells->type[i]) == 3;
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        is_chosen[i] =
            (uint8_t)(all || (cells && is_held_by_default((planish_cell_type)cells->type[i],
                                                          has_triangles)));
        *n += is_chosen[i];
    }
}

/** Free the nodes that layers hold on elements that are not valid: among tangled elements thin ones are
 *  thin by chance. Free all of them where such elements are many, as a wall was moved through its
 *  layers. state [n_elements]. */
static void free_invalid(pl_job *job, const uint8_t *state) {
    enum { MANY = 20 }; /* one in so many of those that are held */
    int64_t n = 0;
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        int corners, is_held = 0;
        const int32_t *corner = pl_job_corners(job, i, &corners);
        for (int k = 0; state[i] != PLANISH_CELL_STATE_VALID && k < corners; k++)
            is_held |= job->in_layer[corner[k]];
        n += is_held;
    }
    for (int64_t i = 0; n * MANY <= job->layers.n_held && i < job->mesh.n_elements; i++)
        if (state[i] != PLANISH_CELL_STATE_VALID)
            mark_nodes(job, i, 0, job->in_layer);
    if (n * MANY > job->layers.n_held) {
        memset(job->in_layer, 0, (size_t)job->mesh.n_nodes);
        job->layers.n_held = 0;
    }
}

/** Hold the nodes of the chosen elements of layers: by default not of elements that are not valid. is_chosen
 *  [n_elements]. */
static int hold_layers(pl_job *job, const uint8_t *is_chosen) {
    uint8_t *state = NULL;
    int status = 0;
    job->in_layer = calloc((size_t)job->mesh.n_nodes + 1, 1);
    if (!job->in_layer)
        return pl_job_complain_memory(job, "values of nodes");
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        if (!job->is_layer[i] || !is_chosen[i])
            continue;
        mark_nodes(job, i, 1, job->in_layer);
        job->layers.n_held++;
    }
    if (job->has_types && job->layers.n_held > 0 && job->arguments->layers != PL_LAYERS_HELD)
        status = pl_cells_find_states(job, &state);
    if (state)
        free_invalid(job, state);
    free(state);
    pl_job_hold_layers(job, job->constraint);
    return status;
}

/** Hold the nodes of layers that are asked for, or usual. */
static int find_held_layers(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    int64_t n;
    /* Layers that are targets need not be held to survive. */
    if (arguments->layers == PL_LAYERS_IGNORED || arguments->layers == PL_LAYERS_KEPT ||
        job->is_surface ||
        (arguments->layers == PL_LAYERS_BY_TYPE &&
         (!job->has_types || job->layers.n >= 0 || (job->like.place && !job->like.sizes.size))))
        return 0;
    uint8_t *is_chosen = malloc((size_t)job->mesh.n_elements + 1);
    if (!is_chosen)
        return pl_job_complain_memory(job, "values of elements");
    choose_types(job, is_chosen, &n);
    int status = n > 0 ? pl_job_find_layers(job, &job->is_layer, &job->layers.n) : 0;
    if (!status && job->layers.n > 0)
        status = hold_layers(job, is_chosen);
    free(is_chosen);
    return status;
}

static int find_min_volumes(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const planish_options *options = &job->options;
    planish_error error;
    if (arguments->n_min_volumes == 0)
        return 0;
    const size_t n_of_file = (size_t)planish_file_mesh(job->file).n_elements;
    job->min_volume = malloc((n_of_file + 1) * sizeof *job->min_volume);
    if (!job->min_volume)
        return pl_job_complain_memory(job, "values of elements");
    if (planish_file_min_volumes(job->file, (const char *const *)arguments->min_volume_tag,
                                 arguments->min_volume_value, arguments->n_min_volumes,
                                 job->min_volume, &error))
        return complain_of_arguments(job, &error);
    job->mesh.min_volume = job->min_volume;
    /* Area enters F as 1 - V/delta, so that with a weight every element needs its delta. */
    if (options->area_weight == 0 || options->min_volume > 0 || options->min_volume_fraction > 0)
        return 0;
    for (int64_t i = 0; i < job->mesh.n_elements; i++)
        if (job->min_volume[i] == 0)
            return pl_complain_usage(pl_command_name(arguments->typed),
                                     "--area-weight needs a minimum volume for every element, but "
                                     "element %" PRId64 " is in none of the named groups",
                                     planish_file_element_number(job->file, i));
    return 0;
}

/** The bounds of a mesh of triangles are in the file's axes, in their order: x z of y = 0, which
 * has z as its first coordinate. */
static int find_box(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const int dim = job->mesh.dim;
    planish_plane plane;
    planish_file_plane(job->file, &plane);
    if (arguments->n_box > 0 && plane.is_tilted)
        return pl_complain(PL_EXIT_FAILED,
                           "%s: --box follows the axes of the file, but the triangles are in a "
                           "tilted plane; hold nodes by --fix, or rotate the mesh",
                           arguments->input);
    if (arguments->n_box == 0)
        return 0;
    if (arguments->n_box != 2 * dim)
        return pl_complain_usage(pl_command_name(arguments->typed),
                                 "--box has %d numbers, but a mesh of %s needs %d",
                                 arguments->n_box,
                                 job->is_surface ? "a surface in space"
                                 : dim == 3      ? "tetrahedra"
                                                 : "triangles",
                                 2 * dim);
    const int is_turned = dim == 2 && plane.axis[0] > plane.axis[1];
    for (int d = 0; d < dim; d++) {
        const int of_axis = is_turned ? 1 - d : d;
        job->options.box_lower[d] = arguments->box[of_axis];
        job->options.box_upper[d] = arguments->box[dim + of_axis];
    }
    return 0;
}

/** Leave the simplices alone in the mesh, which come first in a file's: the command quality measures
 *  all elements by themselves (pl_cells_measure), and makes a plan of these. */
static void keep_simplices(pl_job *job) {
    const planish_cells *cells = job->mesh.cells;
    if (!cells)
        return;
    job->simplices = *cells;
    job->simplices.n = 0;
    while (job->simplices.n < cells->n &&
           pl_cell_is_simplex((planish_cell_type)cells->type[job->simplices.n]))
        job->simplices.n++;
    if (job->is_surface && job->simplices.n < cells->n) /* whose shape is of all elements */
        job->simplices.n = 0;
    job->mesh.cells = &job->simplices;
    job->mesh.n_elements = job->simplices.n;
}

int pl_job_lacks_types(const pl_job *job) {
    return job->simplices.type && planish_file_mesh(job->file).n_elements > job->mesh.n_elements;
}

/** Find out how elements are measured. */
static void find_types(pl_job *job) {
    const planish_cells *cells = job->mesh.cells;
    job->has_types =
        job->mesh.reference || (cells && pl_cells_have_types(cells, pl_job_element_dim(job)));
}

void pl_job_take_all(pl_job *job) {
    const planish_mesh mesh = planish_file_mesh(job->file);
    job->mesh.elements = job->like.place ? NULL : mesh.elements;
    job->mesh.cells = job->like.place ? &job->like.cells : mesh.cells;
    job->mesh.n_elements = mesh.n_elements;
    pl_like_give(&job->like, &job->mesh);
    find_types(job);
}

/** Check that the measures that were asked for are those of the mesh's elements, and choose the one
 *  for the worst elements where none was. */
static int check_measures(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const planish_worst asked = arguments->worst_measure;
    const int is_of_types =
        asked == PLANISH_WORST_ASPECT_RATIO || asked == PLANISH_WORST_SCALED_JACOBIAN;
    const char *command = pl_command_name(arguments->typed), *input = arguments->input;
    if (job->has_types && arguments->objective_given && !arguments->worst &&
        arguments->library.objective == PLANISH_OBJECTIVE_RADIUS_RATIO)
        return pl_complain_usage(command,
                                 "--objective radius-ratio is of triangles and tetrahedra alone, "
                                 "but %s has other elements: choose mean-ratio or edge-ratio",
                                 input);
    if (!arguments->worst)
        return 0;
    if (asked == PLANISH_WORST_NONE && job->has_types)
        job->options.worst = PLANISH_WORST_SCALED_JACOBIAN;
    if (job->has_types && asked != PLANISH_WORST_NONE && !is_of_types)
        return pl_complain_usage(command,
                                 "--worst-measure %s is of triangles and tetrahedra alone, but %s "
                                 "has other elements: choose scaled-jacobian or aspect-ratio",
                                 pl_worst_name(asked), input);
    if (!job->has_types && is_of_types)
        return pl_complain_usage(command,
                                 "--worst-measure %s is of other elements than those of %s: choose "
                                 "dihedral or radius-ratio",
                                 pl_worst_name(asked), input);
    return 0;
}

/** Refuse options for curved surfaces where no node slides on one, and quality looks at none. */
static int check_curved(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const int is_of_onto = arguments->onto && arguments->of_curved &&
                           strcmp(arguments->of_curved, "crease-angle") == 0;
    if (arguments->command == PL_COMMAND_QUALITY && arguments->of_curved && !job->is_surface &&
        !arguments->surface_of && !arguments->report && arguments->n_inputs == 1)
        return pl_complain_usage(pl_command_name(arguments->typed),
                                 "--%s has no effect without --surface-of or --report",
                                 arguments->of_curved);
    if (!arguments->of_curved || arguments->slide_curved || is_of_onto || job->is_surface ||
        arguments->command != PL_COMMAND_SMOOTH)
        return 0;
    return pl_complain_usage(pl_command_name(arguments->typed),
                             arguments->onto ? "--%s has no effect with --onto"
                                             : "--%s has no effect without --slide curved",
                             arguments->of_curved);
}

/** Say what layers cannot be kept with, NULL: nothing. */
static const char *not_kept_with(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    const planish_objective objective = arguments->library.objective;
    const char *target = pl_arguments_target(arguments);
    return target                                                ? target
           : arguments->library.method != PLANISH_METHOD_PLANISH ? "--method"
           : arguments->worst                                    ? "--objective worst"
           : arguments->objective_given && objective != PLANISH_OBJECTIVE_MEAN_RATIO
               ? "--objective edge-ratio"
               : NULL;
}

/** Whether an element has a type whose layers are kept by default. */
static int has_kept_type(const pl_job *job, int64_t element) {
    const planish_cells *cells = job->mesh.cells;
    return cells && is_kept_by_default((planish_cell_type)cells->type[element]);
}

/** Whether the mesh has elements whose layers are kept by default. */
static int may_keep_layers(const pl_job *job) {
    int found = 0;
    for (int64_t i = 0; !found && i < job->mesh.n_elements; i++)
        found = has_kept_type(job, i);
    return found && !job->is_surface && job->arguments->command != PL_COMMAND_COMPARE;
}

/** Find out whether elements that are not valid are many beside those of layers: these may be thin by chance
 *  then. */
static int find_tangled(pl_job *job) {
    enum { MANY = 20 };
    uint8_t *state;
    int64_t n = 0;
    const int status = pl_cells_find_states(job, &state);
    for (int64_t i = 0; !status && i < job->mesh.n_elements; i++)
        n += state[i] != PLANISH_CELL_STATE_VALID;
    job->layers.is_tangled = n * MANY > job->layers.n;
    free(state);
    return status;
}

/** Find the layers, and make them targets if there are any; by default only if they have elements of types
 *  whose layers are kept, and the mesh is not tangled. By default the command quality counts what smooth
 *  would keep, but measures without targets. */
static int keep_layers(pl_job *job) {
    const int is_default = job->arguments->layers == PL_LAYERS_BY_TYPE;
    uint8_t *is_layer;
    int64_t n_of_types = 0;
    int status = pl_job_find_layers(job, &is_layer, &job->layers.n);
    for (int64_t i = 0; !status && i < job->mesh.n_elements; i++)
        n_of_types += is_layer[i] && has_kept_type(job, i);
    if (!status && is_default && n_of_types > 0)
        status = find_tangled(job);
    if (status || job->layers.is_tangled || (n_of_types == 0 && is_default)) {
        job->is_layer = is_layer; /* what is said of them needs no other search */
        return status;
    }
    job->layers.n_kept = job->layers.n;
    job->layers.n_of_types = n_of_types;
    if (is_default && job->arguments->command == PL_COMMAND_QUALITY) {
        job->is_layer = is_layer;
        return 0;
    }
    if (job->layers.n > 0)
        return pl_like_layers(job->arguments, job->file, is_layer, &job->mesh, &job->like);
    free(is_layer);
    return 0;
}

/** Keep the layers that are asked for; those of some types by default, if nothing speaks against it. */
static int find_kept_layers(pl_job *job) {
    const pl_layers_asked asked = job->arguments->layers;
    const char *reason = not_kept_with(job);
    if (asked == PL_LAYERS_KEPT && !job->is_surface)
        return keep_layers(job);
    if (asked != PL_LAYERS_BY_TYPE || !may_keep_layers(job))
        return 0;
    if (!reason)
        return keep_layers(job);
    snprintf(job->layers.not_kept, sizeof job->layers.not_kept, "%s", reason);
    return 0;
}

/** Open the file: its mesh, and the shapes or sizes that its elements are to have. */
static int open_mesh(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    planish_error error;
    int status;
    const planish_open_options how = {.format = arguments->format,
                                      .threads = job->options.threads,
                                      .isolated = 1,
                                      .plane_tolerance = arguments->slide_tolerance};
    if (planish_file_open_with(arguments->input, &how, &job->file, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    if (planish_file_choose_regions(job->file, arguments->regions, arguments->n_regions, &error))
        return complain_of_arguments(job, &error);
    planish_file_get_info(job->file, &job->file_info);
    job->options.precision = job->file_info.precision;
    job->options.round = job->file_info.round;
    job->options.round_user = job->file_info.round_user;
    job->mesh = planish_file_mesh(job->file);
    job->is_surface = pl_curved_is_surface(&job->mesh);
    if (job->engine->choose)
        job->engine->choose(job);
    if (arguments->like && !job->is_surface &&
        (status = pl_like_read(arguments, job->file, job->options.threads, &job->mesh, &job->like)))
        return status;
    if ((status = find_kept_layers(job)))
        return status;
    if (pl_arguments_have_sizes(arguments) && !job->is_surface &&
        (status =
             pl_like_sizes(arguments, job->file, job->options.threads, &job->mesh, &job->like)))
        return status;
    if (arguments->command == PL_COMMAND_QUALITY)
        keep_simplices(job);
    else
        pl_like_give(&job->like, &job->mesh);
    find_types(job);
    if ((status = check_measures(job)))
        return status;
    return job->is_surface ? pl_curved_begin_surface(job) : 0;
}

/** Find out what the file says of nodes and elements. */
static int find_constraints(pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    planish_plane plane;
    int status;
    /* The tolerance is for nodes that slide, and for those of a tilted plane. */
    planish_file_plane(job->file, &plane);
    if (arguments->typed == PL_COMMAND_SMOOTH && arguments->slide_tolerance > 0 &&
        !arguments->slide && !plane.is_tilted)
        return pl_complain_usage(pl_command_name(arguments->typed),
                                 "--slide-tolerance has no effect without --slide, except on "
                                 "triangles in a tilted plane");
    job->constraint = malloc(job->mesh.n_nodes ? (size_t)job->mesh.n_nodes : 1);
    if (!job->constraint)
        return pl_job_complain_memory(job, "values of nodes");
    job->mesh.constraint = job->constraint;
    planish_hold hold = pl_job_hold(job);
    hold.slide = arguments->slide;
    if ((status = find_held(job, &hold, job->constraint)))
        return status;
    if ((status = find_held_layers(job)))
        return status;
    return find_min_volumes(job);
}

int pl_job_read(pl_job *job, const pl_arguments *arguments, const pl_engine *engine) {
    planish_error error;
    memset(job, 0, sizeof *job);
    job->could_slide = job->layers.n = -1;
    job->begin = pl_seconds();
    job->arguments = arguments;
    job->engine = engine;
    job->options = arguments->library;
    /* The user may have told planish or OpenMP otherwise. */
    job->options.bind = !arguments->leave_unbound && !getenv("OMP_PLACES") &&
                        !getenv("OMP_PROC_BIND") && !getenv("GOMP_CPU_AFFINITY");
    job->options.threads = pl_threads_to_use(arguments->library.threads);
    if (strcmp(arguments->input, "-") == 0)
        return pl_complain_usage(pl_command_name(arguments->typed),
                                 "'-' is not a file; standard input is /dev/stdin");
    pl_signals_set_input(arguments->input);
    pl_signals_set_before_smoothing(arguments->command == PL_COMMAND_SMOOTH);
    int status = 0;
    const char *target = pl_arguments_target(arguments);
    if (target && engine != &pl_engine_here)
        return pl_complain(PL_EXIT_FAILED,
                           "%s needs a single process: use planish, not planish-mpi", target);
    if (!engine->read) {
        status = open_mesh(job);
        status = status ? status : find_constraints(job);
    } else if (engine->read(job, &error)) {
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    }
    if (!status)
        status = check_curved(job);
    if (!status)
        status = find_box(job);
    job->read_seconds = pl_seconds() - job->begin;
    return status;
}

/* ---- nodes that slide ----------------------------------------------------------------------- */

/** Let the library find what slides, once constraint is what hold says. is_inside: as in
 *  planish_surface. */
static int find_unheld(const pl_job *job, int ignore_marked, const uint8_t *is_inside,
                       uint8_t *constraint, double *direction) {
    planish_hold hold = pl_job_hold(job);
    hold.slide = 1;
    hold.ignore_marked = ignore_marked;
    planish_error error;
    planish_mesh mesh = job->mesh;
    planish_surface surface = planish_file_surface(job->file, &hold);
    const int status = find_held(job, &hold, constraint);
    if (status)
        return status;
    mesh.constraint = constraint;
    surface.is_inside = is_inside;
    surface.shape = pl_curved_is_asked(job) ? job->curved.shape : NULL;
    surface.slide_interfaces = job->arguments->slide_interfaces;
    if (job->arguments->slide_tolerance > 0)
        surface.tolerance = job->arguments->slide_tolerance;
    if (planish_find_slides(&mesh, &surface, job->options.threads, constraint, direction, NULL,
                            &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    return 0;
}

/** Return whether the file marks all nodes of the surface, which says no more than that
 *  they are there; those inside are fixed then. constraint: found without heeding the marks. */
static int marks_are_the_surface(const pl_job *job, const uint8_t *marked, uint8_t *constraint) {
    for (int64_t i = 0; i < job->mesh.n_nodes; i++)
        if (!marked[i] && constraint[i] != PLANISH_CONSTRAINT_FREE)
            return 0;
    for (int64_t i = 0; i < job->mesh.n_nodes; i++)
        if (marked[i] && constraint[i] == PLANISH_CONSTRAINT_FREE)
            constraint[i] = PLANISH_CONSTRAINT_FIXED;
    return 1;
}

/** Find what slides, and what the file's marks, if it has any, leave to slide: constraint [n_nodes]
 *  and direction [n_nodes][dim] are filled. */
static int find_slides(const pl_job *job, const uint8_t *is_inside, uint8_t *constraint,
                       double *direction) {
    int status = 0, is_found = 0;
    if (planish_file_get_marked(job->file, NULL) > 0) {
        uint8_t *marked = malloc((size_t)job->mesh.n_nodes);
        if (!marked)
            return pl_job_complain_memory(job, "values of nodes");
        planish_file_get_marked(job->file, marked);
        status = find_unheld(job, 1, is_inside, constraint, direction);
        is_found = status || marks_are_the_surface(job, marked, constraint);
        free(marked);
    }
    if (!is_found)
        status = find_unheld(job, 0, is_inside, constraint, direction);
    pl_job_hold_layers(job, constraint);
    return status;
}

static double *new_directions(const pl_job *job) {
    const size_t n = (size_t)job->mesh.n_nodes * (size_t)job->mesh.dim;
    return malloc(n ? n * sizeof(double) : 1);
}

/** Return which nodes are inside, as planish_surface says, if the shape tells, which was made of the same
 *  elements and tags; NULL: that is not known. */
static uint8_t *find_inside(const pl_job *job) {
    const int64_t n = job->mesh.n_nodes;
    uint8_t *is_inside = job->curved.shape ? malloc((size_t)n + 1) : NULL;
    if (is_inside)
        planish_shape_get_classes(job->curved.shape, is_inside);
    for (int64_t i = 0; is_inside && i < n; i++)
        is_inside[i] = is_inside[i] == PLANISH_SHAPE_NONE;
    return is_inside;
}

int pl_job_find_slides(pl_job *job) {
    const double begin = pl_seconds();
    if (!job->arguments->slide || !job->file || job->onto.fit) /* that says what slides */
        return 0;
    job->direction = new_directions(job);
    int status = job->direction ? 0 : pl_job_complain_memory(job, "values of nodes");
    if (!status && (job->is_surface || pl_curved_is_asked(job)))
        status = pl_curved_create(job);
    uint8_t *is_inside = find_inside(job);
    if (!status)
        status = find_slides(job, is_inside, job->constraint, job->direction);
    free(is_inside);
    if (!status && job->is_surface)
        pl_curved_hold(job);
    job->mesh.direction = job->direction;
    pl_curved_count(job);
    job->shape_seconds = pl_seconds() - begin;
    return status;
}

int pl_job_is_told(const pl_job *job) {
    const pl_arguments *arguments = job->arguments;
    return arguments->json || arguments->report || arguments->verbosity != PL_QUIET;
}

int pl_job_count_bound(pl_job *job) {
    const size_t n = (size_t)job->mesh.n_nodes + 1;
    if (planish_file_get_parametric(job->file, NULL) == 0 &&
        planish_file_get_supported(job->file, NULL) == 0)
        return 0;
    uint8_t *has = malloc(n), *is_supported = malloc(n), *is_free = malloc(n);
    const int status = has && is_supported && is_free
                           ? pl_job_get_free(job, is_free)
                           : pl_job_complain_memory(job, "values of nodes");
    if (!status) {
        planish_file_get_parametric(job->file, has);
        planish_file_get_supported(job->file, is_supported);
    }
    for (int64_t i = 0; !status && i < job->mesh.n_nodes; i++) {
        const int is_movable = is_free[i] || job->constraint[i] > PLANISH_CONSTRAINT_FIXED;
        job->n_with_parameters += has[i] && is_movable;
        job->n_supported += is_supported[i] && is_movable;
    }
    free(has);
    free(is_supported);
    free(is_free);
    return status;
}

int pl_job_need_released_by(pl_job *job) {
    if (!job->released_by)
        job->released_by = calloc((size_t)job->mesh.n_nodes + 1, 1);
    return job->released_by ? 0 : pl_job_complain_memory(job, "values of nodes");
}

int pl_job_count_slides(pl_job *job) {
    const double begin = pl_seconds();
    const size_t n = (size_t)job->mesh.n_nodes + 1;
    int64_t n_sliding = 0;
    int status = 0;
    if (job->arguments->slide || job->onto.fit || !job->file || job->options.only_worse_than > 0 ||
        job->options.method != PLANISH_METHOD_PLANISH)
        return 0;
    uint8_t *constraint = malloc(n), *is_inside = malloc(n);
    double *direction = new_directions(job);
    if (!constraint || !is_inside || !direction)
        status = pl_job_complain_memory(job, "values of nodes");
    if (!status)
        status = pl_job_get_free(job, is_inside);
    if (!status)
        status = find_slides(job, is_inside, constraint, direction);
    if (!status)
        status = pl_job_need_released_by(job);
    for (int64_t i = 0; !status && i < job->mesh.n_nodes; i++)
        if (constraint[i] > PLANISH_CONSTRAINT_FIXED) {
            job->released_by[i] |= PL_RELEASED_BY_SLIDE;
            n_sliding++;
        }
    if (!status)
        job->could_slide = n_sliding;
    free(constraint);
    free(is_inside);
    free(direction);
    job->shape_seconds += pl_seconds() - begin;
    return status;
}

int pl_job_is_blunt(const pl_job *job) {
    return !job->like.place || (job->like.is_layer && job->layers.n_of_types > 0);
}

planish_objective pl_job_objective(const pl_job *job) {
    const planish_objective objective = job->options.objective;
    return job->has_types && objective == PLANISH_OBJECTIVE_RADIUS_RATIO
               ? PLANISH_OBJECTIVE_MEAN_RATIO
               : objective;
}

int pl_job_changes_objective(const pl_job *job) {
    const planish_objective usual =
        job->has_types ? PLANISH_OBJECTIVE_MEAN_RATIO : PLANISH_OBJECTIVE_RADIUS_RATIO;
    return pl_job_objective(job) != usual || job->options.area_weight > 0 ||
           job->options.size_weight > 0;
}

/* ---- the plan, and measures ----------------------------------------------------------------- */

int pl_job_plan(pl_job *job) {
    planish_error error;
    const double begin = pl_seconds();
    if (job->engine->plan_create(job, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    job->setup_seconds = pl_seconds() - begin;
    snprintf(job->binding, sizeof job->binding, "%s", job->plan_info.binding);
    job->plan_info.binding = job->binding;
    if (job->plan_info.n_wrapped == 0)
        return 0;
    /* Kept, as the plan will be gone when that is told. */
    job->wrapped = calloc((size_t)job->mesh.n_elements, 1);
    if (!job->wrapped)
        return pl_job_complain_memory(job, "values of elements");
    planish_find_wrapped(job->plan, job->wrapped, NULL);
    return 0;
}

uint64_t pl_job_checksum(const pl_job *job) {
    planish_plane plane;
    planish_mesh mesh = job->mesh;
    if (!job->file || !planish_file_plane(job->file, &plane) || !plane.is_tilted)
        return planish_checksum(&mesh);
    double *places = malloc(((size_t)mesh.n_nodes * 3 + 1) * sizeof *places);
    const int is_placed = places && !planish_file_space_coordinates(job->file, 0, mesh.n_nodes,
                                                                    mesh.coordinates, places, NULL);
    mesh.dim = 3;
    mesh.coordinates = places;
    const uint64_t checksum = is_placed ? planish_checksum(&mesh) : 0;
    free(places);
    return checksum;
}

int pl_job_get_free(const pl_job *job, uint8_t *is_free) {
    planish_error error;
    return job->engine->get_free(job, is_free, &error)
               ? pl_job_complain(job, PL_EXIT_FAILED, &error)
               : 0;
}

int pl_angle_is_smaller(double after, double before) {
    static const double RELATIVE = 1e-9, ABSOLUTE = 1e-12; /* of degrees */
    return after < before * (1 - RELATIVE) - ABSOLUTE;
}

int pl_job_measure(const pl_job *job, planish_quality *quality) {
    planish_error error;
    *quality = (planish_quality){.worst_element = -1, .min_volume = NAN, .max_volume = NAN};
    /* Without a straight simplex there is no plan. */
    if ((!job->file || job->mesh.n_elements > 0) && job->engine->measure(job, quality, &error))
        return pl_job_complain(job, PL_EXIT_FAILED, &error);
    /* A measure over no element has no value; 0 would read as better than perfect. */
    if (quality->max_radius_ratio == 0) {
        const planish_spread none = {NAN, NAN, NAN};
        quality->radius_ratio = quality->circumradius_to_edge = quality->edge_to_inradius = none;
        quality->edge_ratio = quality->mean_ratio = quality->scaled_jacobian = none;
        quality->smallest_angle_deg = quality->largest_angle_deg = none;
        quality->min_angle_deg = quality->max_angle_deg = NAN;
    }
    double *const ratios[] = {
        &quality->rms_radius_ratio,         &quality->rms_radius_ratio_movable,
        &quality->mean_radius_ratio,        &quality->max_radius_ratio,
        &quality->fixed_rms_radius_ratio,   &quality->fixed_max_radius_ratio,
        &quality->max_radius_ratio_movable, &quality->min_angle_deg_movable};
    for (size_t i = 0; i < sizeof ratios / sizeof *ratios; i++)
        if (*ratios[i] == 0)
            *ratios[i] = NAN;
    return 0;
}

void pl_job_close(pl_job *job) {
    free(job->wanted.is_layer);
    free(job->wanted.place);
    free(job->wanted.constraint);
    free(job->wanted.is_released);
    if (job->engine)
        job->engine->plan_destroy(job);
    planish_fit_destroy(job->onto.fit);
    planish_shape_destroy(job->onto.own);
    planish_shape_destroy(job->onto.shape);
    pl_curved_destroy(job);
    pl_like_free(&job->like);
    free(job->min_volume);
    free(job->wrapped);
    free(job->is_layer);
    free(job->in_layer);
    free(job->held_in_run);
    free(job->released_by);
    free(job->direction);
    free(job->constraint);
    planish_file_close(job->file);
}
