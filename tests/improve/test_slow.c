/* What planish_smooth does about meshes that are far from their optimum on a large scale: the box
 * is drawn out smoothly, every star looks like its neighbours', and sweeps bring the news on by one
 * element each. */
#include "support/allocations.h"
#include "support/effort.h"
#include "support/meshes.h"
#include "support/run.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Sweeps until help comes, and some with it, but not all. */
enum { PATIENCE = 20, WITH_HELP = PATIENCE + 8, EARLY = 3 };

/** What helps a squeezed box: Newton's steps on a lattice, unless it has few nodes. */
typedef enum help { CENTRING, LATTICE_IN_PLANE, LATTICE_IN_SPACE } help;

static help centring = CENTRING, in_plane = LATTICE_IN_PLANE, in_space = LATTICE_IN_SPACE;

/** Rows of a table of cmocka: test with the lattice in the plane and in space. */
#define WITH_LATTICE(test)                                                                         \
    {#test " in the plane", test, NULL, NULL, &in_plane}, {                                        \
#test " in space", test, NULL, NULL, &in_space                                             \
    }

/** And with centring. */
#define WITH_ALL(test) {#test " by centring", test, NULL, NULL, &centring}, WITH_LATTICE(test)

static help help_of(void **state) {
    return *(help *)*state;
}

static int dim_of(help by) {
    return by == LATTICE_IN_SPACE ? 3 : 2;
}

/** Cells along an edge of the box: a sanitizer sees as much in a smaller one. */
static int cells_along(help by) {
    return by == CENTRING ? 22 : by == LATTICE_IN_PLANE ? 60 : effort_step(2) > 1 ? 14 : 22;
}

static void squeezed_box(test_mesh *mesh, help by) {
    test_mesh_squeezed_box(mesh, dim_of(by), cells_along(by));
}

typedef struct smoothed {
    double *coordinates; /* owned */
    planish_quality before, after;
    planish_result result;
} smoothed;

static void smooth(const planish_mesh *mesh, const planish_options *options, smoothed *s) {
    const size_t bytes = (size_t)mesh->n_nodes * (size_t)mesh->dim * sizeof(double);
    planish_plan *plan;
    assert_int_equal(planish_plan_create(mesh, options, &plan, NULL), 0);
    s->coordinates = malloc(bytes);
    memcpy(s->coordinates, mesh->coordinates, bytes);
    assert_int_equal(planish_measure(plan, s->coordinates, &s->before, NULL), 0);
    assert_int_equal(planish_smooth(plan, s->coordinates, options, &s->result, NULL), 0);
    assert_int_equal(planish_measure(plan, s->coordinates, &s->after, NULL), 0);
    planish_plan_destroy(plan);
}

/* ---- a history ----------------------------------------------------------------------------- */

enum { MOST = 400 };

typedef struct history {
    int n, stop_at;
    double rms[MOST];
    int64_t visits[MOST];
} history;

static int record(const planish_progress *progress, void *user) {
    history *h = user;
    if (!progress->sweep_done)
        return h->stop_at && progress->sweep >= h->stop_at && progress->colour > 0;
    if (h->n < MOST) {
        h->visits[h->n] = progress->visits;
        h->rms[h->n++] = progress->rms;
    }
    return 0;
}

/** Sweeps until the RMS is at most wanted; MOST if never. */
static int sweeps_to(const history *h, double wanted) {
    for (int i = 0; i < h->n; i++)
        if (h->rms[i] <= wanted)
            return i + 1;
    return MOST;
}

/* ---- tests --------------------------------------------------------------------------------- */

/** The box as it was before it was squeezed, smoothed, is as good as it gets. */
static double rms_of_box(help by) {
    test_mesh box;
    smoothed s;
    planish_options options = test_options(1);
    test_mesh_box(&box, dim_of(by), cells_along(by));
    smooth(&box.mesh, &options, &s);
    free(s.coordinates);
    test_mesh_destroy(&box);
    return s.after.rms_radius_ratio;
}

static void help_comes_and_brings_it_home(void **state) {
    const help by = help_of(state);
    const double wanted = 1.01 * rms_of_box(by);
    test_mesh mesh;
    smoothed s;
    history h = {0};
    planish_options options = test_options(1);
    options.progress = record;
    options.progress_user = &h;
    squeezed_box(&mesh, by);
    smooth(&mesh.mesh, &options, &s);
    assert_int_equal(s.before.n_inverted, 0);
    assert_int_equal(s.after.n_inverted, 0);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    assert_true(s.before.rms_radius_ratio > 1.5 * wanted);
    for (int i = 1; i < h.n; i++)
        assert_true(h.rms[i] <= h.rms[i - 1] * (1 + 1e-12));
    if (by == CENTRING)
        assert_true(h.rms[PATIENCE - 1] > wanted); /* not before, but soon after that */
    assert_true(sweeps_to(&h, wanted) <= WITH_HELP);
    assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** Count what the log tells of Newton's steps. */
static void note_steps(planish_log_level level, const char *text, void *user) {
    int *told = user;
    (void)level;
    *told += strstr(text, "Newton's steps") != NULL;
}

/** A box is home before sweeps have been slow for long: by steps on a lattice. */
static void a_lattice_helps_early(void **state) {
    const double wanted =
        (help_of(state) == LATTICE_IN_SPACE ? 1.001 : 1.01) * rms_of_box(help_of(state));
    test_mesh mesh;
    smoothed s;
    history h = {0};
    int told = 0;
    planish_options options = test_options(1);
    options.progress = record;
    options.progress_user = &h;
    options.log = note_steps;
    options.log_user = &told;
    squeezed_box(&mesh, help_of(state));
    smooth(&mesh.mesh, &options, &s);
    assert_int_equal(told, 1);
    assert_true(sweeps_to(&h, wanted) < PATIENCE);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** Throw a node over the middle of its neighbours in the first element that has it, some nodes apart. */
static void throw_nodes(test_mesh *mesh, int64_t apart) {
    const int dim = mesh->mesh.dim;
    for (int64_t i = apart; i < mesh->mesh.n_elements; i += apart) {
        const int32_t *node = mesh->elements + i * (dim + 1);
        for (int d = 0; d < dim; d++) {
            double middle = 0;
            for (int j = 1; j <= dim; j++)
                middle += mesh->coordinates[node[j] * dim + d] / dim;
            double *x = &mesh->coordinates[node[0] * dim + d];
            *x = middle + 0.1 * (middle - *x);
        }
    }
}

/** Without untangling inverted elements stay as they are: steps on the lattice move none of their nodes, so that
 *  none is repaired at the cost of another one. */
static void a_lattice_leaves_inverted_elements(void **state) {
    const int dim = dim_of(help_of(state));
    test_mesh mesh;
    smoothed s;
    int told = 0;
    int64_t n_inverted = 0;
    planish_options options = test_options(1);
    options.untangle = 0;
    options.log = note_steps;
    options.log_user = &told;
    squeezed_box(&mesh, help_of(state));
    throw_nodes(&mesh, mesh.mesh.n_elements / 7);
    smooth(&mesh.mesh, &options, &s);
    assert_true(told > 0 && s.after.rms_radius_ratio < s.before.rms_radius_ratio);
    for (int64_t i = 0; i < mesh.mesh.n_elements; i++) {
        const int32_t *node = mesh.elements + i * (dim + 1);
        if (test_measure_of(&mesh.mesh, mesh.coordinates, i) > 0)
            continue;
        n_inverted++;
        for (int j = 0; j <= dim; j++)
            assert_memory_equal(s.coordinates + node[j] * dim, mesh.coordinates + node[j] * dim,
                                (size_t)dim * sizeof(double));
    }
    assert_int_equal(n_inverted, s.before.n_inverted);
    assert_int_equal(n_inverted, s.after.n_inverted);
    assert_true(n_inverted > 0);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
}

/** Smooth a mesh; returns how often the log told of Newton's steps, and the sweeps in *sweeps. */
static int count_steps(const planish_mesh *mesh, int *sweeps) {
    smoothed s;
    int told = 0;
    planish_options options = test_options(1);
    options.log = note_steps;
    options.log_user = &told;
    smooth(mesh, &options, &s);
    free(s.coordinates);
    *sweeps = s.result.sweeps;
    return told;
}

/** Meshes that converge soon see no lattice. */
static void rough_meshes_see_no_lattice(void **state) {
    test_mesh mesh;
    int sweeps;
    test_mesh_box(&mesh, dim_of(help_of(state)), cells_along(help_of(state)));
    test_mesh_perturb(&mesh, 0.14, 3);
    assert_int_equal(count_steps(&mesh.mesh, &sweeps), 0);
    test_mesh_destroy(&mesh);
}

/** Box whose nodes are perturbed, and about one in a hundred is thrown by up to an edge. */
static void box_of_thrown_nodes(unsigned seed, int cells, test_mesh *mesh) {
    test_mesh_box(mesh, 3, cells);
    test_mesh_perturb(mesh, 0.14, seed);
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        double *x = mesh->coordinates + i * 3;
        if (test_is_inside_box(x, 3, cells) && test_random(&seed) < 0.01)
            for (int d = 0; d < 3; d++)
                x[d] += 2 * test_random(&seed) - 1;
    }
}

/** A sweep that repairs an element may lower the RMS by more than the sweep before: falls that grow
 *  forecast nothing. Of 300 boxes two have such falls when few are left to come. */
static void repaired_elements_call_no_lattice(void **state) {
    static const unsigned SEEDS[] = {165, 241};
    (void)state;
    for (size_t k = 0; k < sizeof SEEDS / sizeof *SEEDS; k++) {
        test_mesh mesh;
        int sweeps;
        box_of_thrown_nodes(SEEDS[k], 9, &mesh);
        assert_int_equal(count_steps(&mesh.mesh, &sweeps), 0);
        assert_true(sweeps < PATIENCE);
        test_mesh_destroy(&mesh);
    }
}

/** Few nodes see no lattice: sweeps between them are cheaper. */
static void few_nodes_see_no_lattice(void **state) {
    test_mesh mesh;
    int sweeps;
    squeezed_box(&mesh, help_of(state));
    assert_int_equal(count_steps(&mesh.mesh, &sweeps), 0);
    assert_true(sweeps > PATIENCE);
    test_mesh_destroy(&mesh);
}

/** In the plane, steps that fail are tried again, after more sweeps each time: those of triangles six
 *  times as high as wide invert some at first. */
static void failed_steps_are_tried_again(void **state) {
    test_mesh mesh;
    int sweeps;
    squeezed_box(&mesh, help_of(state));
    for (int64_t i = 0; i < mesh.mesh.n_nodes; i++)
        mesh.coordinates[i * 2] /= 6;
    const int tries = count_steps(&mesh.mesh, &sweeps);
    assert_true(tries > 1 && tries < 5);
    test_mesh_destroy(&mesh);
}

/** A history, and the sweeps before Newton's steps; 0: there were none. */
typedef struct steps_in_history {
    history h;
    int sweeps_before;
} steps_in_history;

static void note_when(planish_log_level level, const char *text, void *user) {
    steps_in_history *s = user;
    (void)level;
    if (strstr(text, "Newton's steps"))
        s->sweeps_before = s->h.n;
}

/** Steps wait as long as an error spreads from a part of the mesh, and sweeps visit more nodes each
 *  time. */
static void a_lattice_waits_while_an_error_spreads(void **state) {
    (void)state;
    const int cells = cells_along(LATTICE_IN_SPACE), part = cells / 2;
    test_mesh mesh, corner;
    smoothed s;
    steps_in_history when = {0};
    planish_options options = test_options(1);
    options.progress = record;
    options.progress_user = &when; /* its history */
    options.log = note_when;
    options.log_user = &when;
    test_mesh_box(&mesh, 3, cells);
    test_mesh_squeezed_box(&corner, 3, part);
    for (int k = 0; k <= part; k++)
        for (int j = 0; j <= part; j++)
            memcpy(mesh.coordinates + ((k * (cells + 1) + j) * (cells + 1)) * (int64_t)3,
                   corner.coordinates + ((k * (part + 1) + j) * (part + 1)) * (int64_t)3,
                   (size_t)(part + 1) * 3 * sizeof(double));
    smooth(&mesh.mesh, &options, &s);
    const int last = when.sweeps_before - 1;
    if (last > 0) {
        assert_true(2 * when.h.visits[last] >= (int64_t)pow(cells - 1, 3));
        assert_true(when.h.visits[last] <= when.h.visits[last - 1]);
    }
    assert_true((double)when.h.visits[3] > 1.1 * (double)when.h.visits[2]);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
    test_mesh_destroy(&corner);
}

/* ---- nodes that slide ------------------------------------------------------------------------ */

/** A box that slides on its planes and lines, drawn to corner 0: with its surface, unlike a squeezed one. */
typedef struct drawn_box {
    test_mesh mesh;
    planish_mesh sliding; /* the same, with */
    uint8_t *constraint;
    double *direction;
} drawn_box;

static void drawn_box_create(drawn_box *box, int dim, int cells, double power) {
    const int64_t n = cells + 1, n_nodes = dim == 3 ? n * n * n : n * n;
    test_mesh_box(&box->mesh, dim, cells);
    for (int64_t i = 0; i < n_nodes * dim; i++)
        box->mesh.coordinates[i] = cells * pow(box->mesh.coordinates[i] / cells, power);
    box->constraint = malloc((size_t)n_nodes);
    box->direction = malloc((size_t)(n_nodes * dim) * sizeof *box->direction);
    box->sliding = box->mesh.mesh;
    assert_int_equal(
        planish_find_slides(&box->sliding, NULL, 1, box->constraint, box->direction, NULL, NULL),
        0);
    box->sliding.constraint = box->constraint;
    box->sliding.direction = box->direction;
}

static void drawn_box_destroy(drawn_box *box) {
    free(box->constraint);
    free(box->direction);
    test_mesh_destroy(&box->mesh);
}

/** Coordinates on the surface of the box are as they were, and others moved. */
static void check_surface(const drawn_box *box, int cells, const double *coordinates) {
    int64_t n_moved = 0;
    for (int64_t i = 0; i < box->sliding.n_nodes * box->sliding.dim; i++) {
        const double was = box->sliding.coordinates[i];
        if (was == 0 || was == cells)
            assert_true(coordinates[i] == was);
        n_moved += coordinates[i] != was;
    }
    assert_true(n_moved > 0);
}

/** The surface goes with the interior: sweeps alone would need more than a hundred. */
static void nodes_that_slide_make_steps(void **state) {
    const help by = help_of(state);
    enum { SWEEPS = 25 };
    drawn_box box, even;
    smoothed s, wanted;
    int told = 0;
    planish_options options = test_options(1);
    drawn_box_create(&even, dim_of(by), cells_along(by), 1);
    drawn_box_create(&box, dim_of(by), cells_along(by), 1.5);
    smooth(&even.sliding, &options, &wanted);
    options.log = note_steps;
    options.log_user = &told;
    smooth(&box.sliding, &options, &s);
    assert_true(told >= 1);
    assert_true(s.result.sweeps < SWEEPS);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    assert_int_equal(s.after.n_inverted, 0);
    assert_true(s.after.rms_radius_ratio < 1.001 * wanted.after.rms_radius_ratio);
    assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
    check_surface(&box, cells_along(by), s.coordinates);
    free(s.coordinates);
    free(wanted.coordinates);
    drawn_box_destroy(&even);
    drawn_box_destroy(&box);
}

/** They go to the same bits with other threads and instruction sets. */
static void nodes_that_slide_have_the_same_bits(void **state) {
    const help by = help_of(state);
    drawn_box box;
    smoothed one, other;
    planish_options options = test_options(1);
    drawn_box_create(&box, dim_of(by), cells_along(by), 1.5);
    test_mesh_perturb(&box.mesh, 0.01, 3);
    options.isa = PLANISH_ISA_PLAIN;
    smooth(&box.sliding, &options, &one);
    options.isa = PLANISH_ISA_AUTO;
    options.threads = 3;
    smooth(&box.sliding, &options, &other);
    assert_memory_equal(one.coordinates, other.coordinates,
                        (size_t)(box.sliding.n_nodes * box.sliding.dim) * sizeof(double));
    free(one.coordinates);
    free(other.coordinates);
    drawn_box_destroy(&box);
}

/** Nodes of a squeezed box, whose surface has nowhere to go, do no harm. */
static void a_lattice_helps_where_nodes_slide(void **state) {
    const help by = help_of(state);
    drawn_box box;
    test_mesh mesh;
    smoothed s, wanted;
    int told = 0;
    planish_options options = test_options(1);
    drawn_box_create(&box, dim_of(by), cells_along(by), 1);
    squeezed_box(&mesh, by);
    smooth(&box.sliding, &options, &wanted);
    options.log = note_steps;
    options.log_user = &told;
    box.sliding.coordinates = mesh.coordinates;
    smooth(&box.sliding, &options, &s);
    assert_int_equal(told, 1);
    assert_int_equal(s.result.stop, PLANISH_STOP_CONVERGED);
    assert_true(s.after.rms_radius_ratio < 1.001 * wanted.after.rms_radius_ratio);
    free(s.coordinates);
    free(wanted.coordinates);
    test_mesh_destroy(&mesh);
    drawn_box_destroy(&box);
}

/** Whoever stops it in the middle of help gets what was reported last, unless that has a smaller
 *  angle than the mesh had. */
static void cut_short_it_leaves_what_stood(void **state) {
    const help by = help_of(state);
    test_mesh mesh;
    int put_back = 0;
    squeezed_box(&mesh, by);
    const int first = by == CENTRING ? PATIENCE - 1 : EARLY; /* a lattice helps earlier */
    for (int stop_at = first; stop_at < first + WITH_HELP - PATIENCE; stop_at += effort_step(3)) {
        smoothed s;
        history h = {.stop_at = stop_at};
        planish_options options = test_options(1);
        options.progress = record;
        options.progress_user = &h;
        smooth(&mesh.mesh, &options, &s);
        assert_int_equal(s.result.stop, PLANISH_STOP_INTERRUPTED);
        assert_int_equal(s.after.n_inverted, 0);
        assert_true(s.after.min_angle_deg >= s.before.min_angle_deg);
        if (s.result.n_put_back > 0) /* all nodes, if they have gone too far for some to return */
            assert_true(s.after.rms_radius_ratio <= s.before.rms_radius_ratio);
        else
            assert_true(s.after.rms_radius_ratio <= h.rms[stop_at - 2] * (1 + 1e-12));
        put_back += s.result.n_put_back > 0;
        free(s.coordinates);
    }
    assert_true(put_back < WITH_HELP - PATIENCE);
    test_mesh_destroy(&mesh);
}

/** Calls of the progress function. */
typedef struct calls {
    int n, first, stop_at; /* first: those before Newton's steps */
    double rms;            /* as told last */
} calls;

static int count_call(const planish_progress *progress, void *user) {
    calls *c = user;
    c->rms = progress->rms;
    return ++c->n == c->stop_at;
}

static void note_first(planish_log_level level, const char *text, void *user) {
    calls *c = user;
    (void)level;
    if (strstr(text, "Newton's steps"))
        c->first = c->n;
}

/** Any answer of the progress function may end a step: each of the first ones does. The mesh is valid
 *  then, and no worse than it was. */
static void end_at_calls(const planish_mesh *mesh) {
    enum { ANSWERS = 60 };
    smoothed s;
    calls c = {.stop_at = -1};
    planish_options options = test_options(1);
    options.progress = count_call;
    options.progress_user = &c;
    options.log = note_first;
    options.log_user = &c;
    smooth(mesh, &options, &s);
    free(s.coordinates);
    const int first = c.first;
    assert_true(first > 0 && c.n > first + ANSWERS);
    for (int k = 1; k < ANSWERS; k += effort_step(5)) {
        c = (calls){.stop_at = first + k};
        smooth(mesh, &options, &s);
        assert_int_equal(s.result.stop, PLANISH_STOP_INTERRUPTED);
        assert_int_equal(s.after.n_inverted, 0);
        assert_true(s.after.min_angle_deg >= s.before.min_angle_deg);
        assert_true(s.after.max_radius_ratio <= s.before.max_radius_ratio);
        assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
        if (s.result.n_put_back == 0)
            assert_true(s.after.rms_radius_ratio <= c.rms * (1 + 1e-12));
        free(s.coordinates);
    }
}

static void a_step_ends_at_any_call(void **state) {
    const int dim = dim_of(help_of(state));
    test_mesh mesh;
    drawn_box box;
    test_mesh_squeezed_box(&mesh, dim, dim == 3 ? 11 : 30);
    end_at_calls(&mesh.mesh);
    test_mesh_destroy(&mesh);
    drawn_box_create(&box, dim, dim == 3 ? 11 : 30, 1.5);
    end_at_calls(&box.sliding);
    drawn_box_destroy(&box);
}

static void the_most_sweeps_are_the_most(void **state) {
    test_mesh mesh;
    squeezed_box(&mesh, help_of(state));
    for (int most = PATIENCE; most < WITH_HELP; most += effort_step(3)) {
        smoothed s;
        planish_options options = test_options(1);
        options.max_sweeps = most;
        smooth(&mesh.mesh, &options, &s);
        assert_true(s.result.sweeps <= (s.result.n_put_back > 0 ? 2 : 1) * most);
        assert_int_equal(s.after.n_inverted, 0);
        assert_true(s.result.sweeps == most || s.result.stop == PLANISH_STOP_CONVERGED ||
                    s.result.n_put_back > 0);
        free(s.coordinates);
    }
    test_mesh_destroy(&mesh);
}

static void same_bits(void **state) {
    test_mesh mesh;
    smoothed one, other;
    planish_options options = test_options(1);
    squeezed_box(&mesh, help_of(state));
    options.isa = PLANISH_ISA_PLAIN;
    options.max_sweeps = 3 * PATIENCE;
    smooth(&mesh.mesh, &options, &one);
    options.isa = PLANISH_ISA_AUTO;
    options.threads = 3;
    smooth(&mesh.mesh, &options, &other);
    assert_memory_equal(one.coordinates, other.coordinates,
                        (size_t)(mesh.mesh.n_nodes * mesh.mesh.dim) * sizeof(double));
    free(one.coordinates);
    free(other.coordinates);
    test_mesh_destroy(&mesh);
}

/** With a tolerance that L-BFGS has something to do for. */
static void powers_of_two_change_no_bit(void **state) {
    static const int exponents[] = {-800, -520, -250, -9, 1, 250, 520, 700};
    test_mesh mesh;
    smoothed one, other;
    planish_options options = test_options(1);
    options.tolerance = 1e-9;
    options.max_sweeps = 4 * PATIENCE;
    squeezed_box(&mesh, help_of(state));
    smooth(&mesh.mesh, &options, &one);
    for (size_t k = 0; k < sizeof exponents / sizeof *exponents; k += (size_t)effort_step(4)) {
        test_mesh_transform(&mesh, ldexp(1, exponents[k]), 0);
        smooth(&mesh.mesh, &options, &other);
        for (int64_t i = 0; i < mesh.mesh.n_nodes * mesh.mesh.dim; i++)
            assert_true(ldexp(one.coordinates[i], exponents[k]) == other.coordinates[i]);
        assert_true(one.result.rms == other.result.rms);
        test_mesh_transform(&mesh, ldexp(1, -exponents[k]), 0);
        free(other.coordinates);
    }
    free(one.coordinates);
    test_mesh_destroy(&mesh);
}

/** Nodes that slide stay on their lines and planes in meshes of any size; there the very large and
 *  very small are not helped. */
static void what_slides_stays_where_it_slides(void **state) {
    static const int exponents[] = {0, -230, 230};
    const help by = help_of(state);
    const int dim = dim_of(by);
    test_mesh mesh;
    squeezed_box(&mesh, by);
    test_mesh_transform(&mesh, 1, 0.5);
    const int64_t n = mesh.mesh.n_nodes;
    uint8_t *constraint = malloc((size_t)n);
    double *direction = malloc((size_t)(n * dim) * sizeof *direction);
    assert_int_equal(planish_find_slides(&mesh.mesh, NULL, 1, constraint, direction, NULL, NULL),
                     0);
    planish_mesh sliding = mesh.mesh;
    sliding.constraint = constraint;
    sliding.direction = direction;
    for (int k = 0; k < 3; k += effort_step(3)) {
        planish_options options = test_options(1);
        const double scale = ldexp(1, exponents[k]), near = scale * 0.5;
        const double far = scale * (cells_along(by) + 0.5);
        smoothed s;
        test_mesh_transform(&mesh, scale, 0);
        smooth(&sliding, &options, &s);
        assert_true(s.result.n_moved_nodes > 0);
        for (int64_t i = 0; i < n * dim; i++)
            if (mesh.coordinates[i] == near || mesh.coordinates[i] == far)
                assert_true(s.coordinates[i] == mesh.coordinates[i]);
        test_mesh_transform(&mesh, 1 / scale, 0);
        free(s.coordinates);
    }
    free(constraint);
    free(direction);
    test_mesh_destroy(&mesh);
}

/** An unused node far away, and a component that cannot be helped, keep nothing from its help. */
static void strangers_change_nothing(void **state) {
    const int dim = dim_of(help_of(state));
    test_mesh mesh, strange;
    smoothed one, other;
    planish_options options = test_options(1);
    options.max_sweeps = 2 * PATIENCE;
    squeezed_box(&mesh, help_of(state));
    smooth(&mesh.mesh, &options, &one);
    const int64_t n = mesh.mesh.n_nodes;
    double *x = calloc((size_t)((n + 1) * dim), sizeof *x);
    memcpy(x, mesh.coordinates, (size_t)(n * dim) * sizeof *x);
    x[n * dim] = 1e250;
    test_mesh_create(&strange, dim, n + 1, x, mesh.mesh.n_elements, mesh.elements);
    smooth(&strange.mesh, &options, &other);
    assert_true(fabs(one.result.rms / other.result.rms - 1) < 1e-6);
    assert_int_equal(other.result.n_inverted, 0);
    free(x);
    free(one.coordinates);
    free(other.coordinates);
    test_mesh_destroy(&mesh);
    test_mesh_destroy(&strange);
}

/** Floats: nodes that are none and never moved stay what they are. */
static void floats_stay_valid(void **state) {
    const int dim = dim_of(help_of(state));
    test_mesh mesh, small;
    smoothed s;
    planish_options options = test_options(1);
    options.tolerance = 1e-9;
    options.max_sweeps = 4 * PATIENCE;
    options.precision = PLANISH_PRECISION_FLOAT;
    squeezed_box(&mesh, help_of(state));
    for (int64_t i = 0; i < mesh.mesh.n_nodes * dim; i++)
        mesh.coordinates[i] = (float)mesh.coordinates[i];
    test_mesh_box(&small, dim, 4); /* its cells are lost where floats are as large as that */
    test_mesh_transform(&small, 0x1p-30, 1 + 2.0 * cells_along(LATTICE_IN_PLANE));
    test_mesh_append(&mesh, &small, 0);
    smooth(&mesh.mesh, &options, &s);
    assert_int_equal(s.before.n_inverted, 0);
    assert_int_equal(s.after.n_inverted, 0);
    assert_true(s.after.rms_radius_ratio < s.before.rms_radius_ratio);
    free(s.coordinates);
    test_mesh_destroy(&mesh);
    test_mesh_destroy(&small);
}

/** Without memory for it there is no help, but sweeps go on. */
static void without_memory_there_is_no_help(void **state) {
    const help by = help_of(state);
    test_mesh mesh;
    planish_options options = test_options(1);
    planish_plan *plan;
    planish_result result;
    squeezed_box(&mesh, by);
    assert_int_equal(planish_plan_create(&mesh.mesh, &options, &plan, NULL), 0);
    const size_t bytes = (size_t)(mesh.mesh.n_nodes * mesh.mesh.dim) * sizeof(double);
    double *x = malloc(bytes);
    const int most = by == CENTRING ? 12 : 90; /* a lattice has some 60 arrays */
    for (int permitted = 0; permitted < most;
         permitted += effort_step(4) * (by == CENTRING ? 1 : 3)) {
        memcpy(x, mesh.coordinates, bytes);
        allocations_permit(permitted);
        int status = planish_smooth(plan, x, &options, &result, NULL);
        allocations_permit(-1);
        if (status == PLANISH_ERROR_MEMORY)
            assert_memory_equal(x, mesh.coordinates, bytes);
        else
            assert_true(status == PLANISH_OK && result.n_inverted == 0);
    }
    free(x);
    planish_plan_destroy(plan);
    test_mesh_destroy(&mesh);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_LATTICE(a_lattice_helps_early),
        WITH_LATTICE(a_lattice_leaves_inverted_elements),
        WITH_LATTICE(rough_meshes_see_no_lattice),
        cmocka_unit_test(repaired_elements_call_no_lattice),
        cmocka_unit_test_prestate(few_nodes_see_no_lattice, &centring),
        cmocka_unit_test_prestate(failed_steps_are_tried_again, &in_plane),
        cmocka_unit_test(a_lattice_waits_while_an_error_spreads),
        WITH_LATTICE(nodes_that_slide_make_steps),
        WITH_LATTICE(nodes_that_slide_have_the_same_bits),
        cmocka_unit_test_prestate(a_lattice_helps_where_nodes_slide, &in_space),
        WITH_ALL(help_comes_and_brings_it_home),
        WITH_ALL(cut_short_it_leaves_what_stood),
        WITH_LATTICE(a_step_ends_at_any_call),
        WITH_ALL(the_most_sweeps_are_the_most),
        WITH_ALL(same_bits),
        WITH_ALL(powers_of_two_change_no_bit),
        WITH_ALL(what_slides_stays_where_it_slides),
        WITH_ALL(strangers_change_nothing),
        WITH_ALL(floats_stay_valid),
        WITH_ALL(without_memory_there_is_no_help),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
