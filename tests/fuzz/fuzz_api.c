/* Bytes decide on a mesh, options and a few calls of planish.h. Whatever they are, a call fails
 * with a code and a text and leaves its outputs alone, or does what the header promises: only free
 * nodes move, within their bounds; no more elements are inverted than were; no element gets worse
 * than the worst; the same bits on any number of threads and by any kernel. Elements are given as
 * cells, too, some of second order.
 */
#include "fuzz_options.h"

#include <math.h>

#define FUZZ_NEARLY_FLAT 1e6 /* an RR from which on rounding may decide on the sign */

/** All that the calls of one input work on. */
typedef struct work {
    fuzz_bytes bytes;
    fuzz_mesh mesh;
    planish_options options;
    fuzz_user user;
    planish_plan *plan;
    double *x;        /* [mesh.n_coordinates] what is smoothed */
    uint8_t *is_free; /* [n_nodes] */
} work;

/** Whether a call did what was asked; if not, its error is one. */
static int succeeded(int status, const planish_error *error) {
    if (status == 0)
        return 1;
    fuzz_require(status < 0 && status >= PLANISH_ERROR_FORMAT, "a failure has a code");
    fuzz_require(error->code == status && error->text[0] && !strchr(error->text, '\n') &&
                     strlen(error->text) < sizeof error->text,
                 "a failure is told in a line");
    return 0;
}

static int64_t count_ones(const uint8_t *flag, int64_t n) {
    int64_t ones = 0;
    for (int64_t i = 0; i < n; i++) {
        fuzz_require(flag[i] <= 1, "flags are 0 or 1");
        ones += flag[i];
    }
    return ones;
}

static void *copy_of(const void *data, int64_t n, size_t size) {
    void *copy = malloc((size_t)n * size + 1);
    fuzz_require(copy != NULL, "memory");
    if (n > 0)
        memcpy(copy, data, (size_t)n * size);
    return copy;
}

/* ---- before there is a plan ----------------------------------------------------------------- */

static void find_layers(const work *w) {
    const planish_mesh *mesh = &w->mesh.mesh;
    uint8_t *is_layer = mesh->n_elements > 0 ? calloc((size_t)mesh->n_elements, 1) : NULL;
    int64_t n;
    planish_error error;
    if (is_layer && succeeded(planish_find_layers(mesh, 1, is_layer, &n, &error), &error))
        fuzz_require(count_ones(is_layer, mesh->n_elements) == n, "layers are counted");
    free(is_layer);
}

/** Nodes that can slide become such, where the bytes want it. */
static void find_slides(work *w) {
    planish_mesh *mesh = &w->mesh.mesh;
    const int n_facets = take_below(&w->bytes, 4), dim = mesh->dim;
    uint8_t *constraint = fuzz_block(&w->mesh, mesh->n_nodes, 1);
    double *direction = fuzz_block(&w->mesh, mesh->n_nodes * dim, sizeof *direction);
    int32_t *region = fuzz_block(&w->mesh, mesh->n_elements, sizeof *region);
    int32_t facets[3 * 4], edges[2 * 2], tags[4];
    for (int64_t i = 0; i < mesh->n_elements && take_chance(&w->bytes, 2); i++)
        region[i] = (int32_t)take_integer(&w->bytes);
    for (int i = 0; i < 12; i++)
        facets[i] = (int32_t)take_integer(&w->bytes);
    for (int i = 0; i < 4; i++)
        edges[i] = tags[i] = (int32_t)take_integer(&w->bytes);
    const planish_surface surface = {.region = take_below(&w->bytes, 2) ? region : NULL,
                                     .n_facets = n_facets,
                                     .facets = facets,
                                     .facet_tag = tags,
                                     .n_edges = take_below(&w->bytes, 3),
                                     .edges = edges,
                                     .tagged_only = take_chance(&w->bytes, 4),
                                     .tolerance = take_real(&w->bytes) / 1e5};
    planish_slide_info info;
    planish_error error;
    if (!succeeded(planish_find_slides(mesh, take_chance(&w->bytes, 4) ? &surface : NULL, 1,
                                       constraint, direction, &info, &error),
                   &error))
        return;
    int64_t n = 0;
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int before = mesh->constraint ? mesh->constraint[i] : PLANISH_CONSTRAINT_FREE;
        fuzz_require(before == PLANISH_CONSTRAINT_FREE || constraint[i] == before,
                     "nodes that are not free stay what they are");
        n += before == PLANISH_CONSTRAINT_FREE && constraint[i] > PLANISH_CONSTRAINT_FIXED;
    }
    fuzz_require(n <= info.n_on_plane + info.n_on_line && info.n_surface <= mesh->n_nodes,
                 "nodes that slide are counted");
    mesh->constraint = constraint;
    mesh->direction = direction;
}

/* ---- looking at coordinates ----------------------------------------------------------------- */

static int measure(const work *w, const planish_plan *plan, planish_quality *quality) {
    planish_error error;
    if (!succeeded(planish_measure(plan, w->x, quality, &error), &error))
        return 0;
    fuzz_require(quality->n_inverted >= 0 && quality->n_inverted <= quality->n_elements,
                 "inverted elements are some of all");
    fuzz_require(!isnan(quality->rms_radius_ratio) && !isnan(quality->min_angle_deg),
                 "measures are numbers");
    fuzz_require(quality->max_radius_ratio == 0 || quality->max_radius_ratio > 1 - 1e-9,
                 "radius ratios are 1 or more");
    return 1;
}

static void look_at_elements(const work *w) {
    const int64_t n = w->mesh.mesh.n_elements;
    double *ratio = malloc((size_t)n * sizeof *ratio);
    uint8_t *state = malloc((size_t)n);
    int64_t counted, ones = 0;
    planish_error error;
    planish_quality quality;
    if (measure(w, w->plan, &quality) &&
        succeeded(planish_measure_elements(w->plan, w->x, ratio, &error), &error)) {
        for (int64_t i = 0; i < n; i++)
            ones += ratio[i] == 0;
        fuzz_require(ones == quality.n_inverted, "elements that are not positive have ratio 0");
        if (succeeded(planish_find_infeasible(w->plan, w->x, NULL, state, &counted, NULL, &error),
                      &error)) {
            fuzz_require(count_ones(state, n) == counted, "unfixable elements are counted");
            for (int64_t i = 0; i < n; i++)
                fuzz_require(!state[i] || ratio[i] == 0, "a positive element needs no mending");
        }
    }
    ones = 0;
    if (succeeded(planish_check_volumes(w->plan, w->x, &w->options, state, &counted, NULL, &error),
                  &error)) {
        for (int64_t i = 0; i < n; i++)
            ones += state[i] != PLANISH_VOLUME_MET;
        fuzz_require(ones == counted, "elements below their minimum volume are counted");
    }
    free(ratio);
    free(state);
}

/* ---- smoothing ------------------------------------------------------------------------------ */

static int may_move(const work *w, int64_t node) {
    const uint8_t *constraint = w->mesh.mesh.constraint;
    return w->is_free[node] || (constraint && constraint[node] > PLANISH_CONSTRAINT_FIXED);
}

/** Nodes that may not move, and gaps between coordinates, have their bits; others are finite. */
static void check_moves(const work *w, const double *before) {
    const planish_mesh *mesh = &w->mesh.mesh;
    double *expected = copy_of(before, w->mesh.n_coordinates, sizeof *expected);
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        for (int d = 0; d < mesh->dim && may_move(w, i); d++) {
            const int64_t at = fuzz_at(mesh, i, d);
            fuzz_require(isfinite(w->x[at]), "coordinates are finite");
            expected[at] = w->x[at];
        }
    fuzz_require(memcmp(expected, w->x, (size_t)w->mesh.n_coordinates * sizeof *expected) == 0,
                 "only nodes that may move do");
    free(expected);
}

/** Coordinates that changed are within what the options say. */
static void check_bounds(const work *w, const double *before) {
    const planish_options *o = &w->options;
    const planish_mesh *mesh = &w->mesh.mesh;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        for (int d = 0; d < mesh->dim; d++) {
            const int64_t at = fuzz_at(mesh, i, d);
            const double x = w->x[at];
            if (x == before[at])
                continue;
            fuzz_require(!(x < o->box_lower[d] || x > o->box_upper[d]), "nodes stay in the box");
            fuzz_require(!(o->lower && x < o->lower[i * mesh->dim + d]) &&
                             !(o->upper && x > o->upper[i * mesh->dim + d]),
                         "nodes stay in their bounds");
            fuzz_require(o->max_displacement == 0 || o->displacement_unit != PLANISH_UNIT_MESH ||
                             fabs(x - before[at]) <= o->max_displacement * (1 + 1e-9),
                         "nodes stay near their start");
        }
}

static void check_gain(const work *w, const planish_quality *before, const planish_quality *after,
                       const planish_result *result) {
    const planish_options *o = &w->options;
    /* The result goes by doubles, and planish_measure decides exactly. */
    if (after->n_inverted == 0 && after->max_radius_ratio < FUZZ_NEARLY_FLAT)
        fuzz_require(result->n_inverted == 0, "the result counts what is inverted");
    fuzz_require(after->n_inverted <= before->n_inverted,
                 "no more elements are inverted than were");
    const int asks_volumes =
        o->min_volume > 0 || o->min_volume_fraction > 0 || w->mesh.mesh.min_volume;
    if (before->n_inverted > 0 || asks_volumes)
        return;
    fuzz_require(after->max_radius_ratio_movable <= before->max_radius_ratio_movable * (1 + 1e-9),
                 "no element gets worse than the worst");
    if (o->worst == PLANISH_WORST_NONE)
        fuzz_require(!(result->objective > result->objective_before * (1 + 1e-9)),
                     "the objective does not rise");
}

/** The same with another plan: other threads, the plain kernel. */
static void check_bits(const work *w, const double *before) {
    work other = *w;
    planish_result result;
    planish_error error;
    if (w->options.progress || w->options.allocator)
        return;
    other.options.threads = w->options.threads == 1 ? 3 : 1;
    other.options.parallel = fuzz_parallel;
    other.options.isa = PLANISH_ISA_PLAIN;
    other.x = copy_of(before, w->mesh.n_coordinates, sizeof *other.x);
    planish_mesh mesh = w->mesh.mesh;
    const int made = planish_plan_create(&mesh, &other.options, &other.plan, &error) == 0;
    fuzz_require(made, "what made a plan does so on other threads");
    fuzz_require(planish_smooth(other.plan, other.x, &other.options, &result, &error) == 0,
                 "what could be smoothed can be on other threads");
    fuzz_require(memcmp(other.x, w->x, (size_t)w->mesh.n_coordinates * sizeof *w->x) == 0,
                 "the same bits on any threads and by any kernel");
    planish_plan_destroy(other.plan);
    free(other.x);
}

/** Nodes that the call holds stay; held [n_nodes]: as found before. */
static void check_held(const work *w, const uint8_t *held, const double *before) {
    const planish_mesh *mesh = &w->mesh.mesh;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        for (int d = 0; d < mesh->dim; d++) {
            const int64_t at = fuzz_at(mesh, i, d);
            fuzz_require(held[i] <= PLANISH_HELD_BY_SURFACE && (!held[i] || w->x[at] == before[at]),
                         "nodes that are held by the call stay");
        }
}

/** is_first: coordinates are still those that the plan was made with. */
static void smooth(work *w, int is_first) {
    planish_result result;
    planish_quality quality, after;
    planish_error error;
    double *before = copy_of(w->x, w->mesh.n_coordinates, sizeof *before);
    const int known = measure(w, w->plan, &quality);
    const int same_bits = !take_chance(&w->bytes, 4) && is_first;
    uint8_t *held = calloc((size_t)w->mesh.mesh.n_nodes + 1, 1);
    fuzz_require(held != NULL, "memory");
    succeeded(planish_find_held(w->plan, w->x, &w->options, held, &error), &error);
    if (succeeded(planish_smooth(w->plan, w->x, &w->options, &result, &error), &error)) {
        check_moves(w, before);
        check_bounds(w, before);
        check_held(w, held, before);
        if (known && measure(w, w->plan, &after) && w->options.method == PLANISH_METHOD_PLANISH)
            check_gain(w, &quality, &after, &result);
        if (same_bits)
            check_bits(w, before);
    } else {
        fuzz_require(memcmp(before, w->x, (size_t)w->mesh.n_coordinates * sizeof *before) == 0,
                     "coordinates are untouched by a failure");
    }
    free(held);
    free(before);
}

/** Other coordinates for the same plan. */
static void move_some(work *w) {
    for (int k = 1 + take_below(&w->bytes, 8); k > 0 && w->mesh.n_coordinates > 0; k--)
        take_change(&w->bytes, w->x, w->mesh.n_coordinates);
}

static void use_plan(work *w) {
    const int64_t n = w->mesh.mesh.n_nodes;
    planish_plan_info info;
    int is_first = 1;
    w->is_free = malloc((size_t)n + 1);
    w->x = copy_of(w->mesh.mesh.coordinates, w->mesh.n_coordinates, sizeof *w->x);
    fuzz_require(w->is_free != NULL, "memory");
    planish_plan_get_info(w->plan, &info);
    planish_plan_get_free(w->plan, w->is_free);
    fuzz_require(count_ones(w->is_free, n) == info.n_free, "free nodes are counted");
    for (int i = 0; i < n && w->mesh.mesh.constraint; i++)
        fuzz_require(!w->is_free[i] || w->mesh.mesh.constraint[i] == PLANISH_CONSTRAINT_FREE,
                     "free nodes were called free");
    for (int k = 1 + take_below(&w->bytes, 3); k > 0; k--) {
        const int what = take_below(&w->bytes, 4);
        if (what == 3)
            move_some(w);
        if (what == 2)
            look_at_elements(w);
        else
            smooth(w, is_first);
        is_first &= what == 2;
    }
    free(w->x);
    free(w->is_free);
}

/* ---- cells ---------------------------------------------------------------------------------- */

/** Cells of the mesh in the place of its elements, being filled. */
typedef struct making {
    work *w;
    planish_mesh mesh; /* which has the cells, and a node for each mid */
    double *x;         /* [n_nodes][dim] */
    uint8_t *type;
    int64_t *offset;
    int32_t *node;
    planish_cells cells;
} making;

enum { MOST_OF_CELL = 27 };

/** Add an element as a cell, of order 2 where the bytes want it: mids are missing, in the middle,
 *  or off it. */
static void add_element(making *m, int64_t element) {
    static const uint8_t ends[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    const planish_mesh *plain = &m->w->mesh.mesh;
    fuzz_bytes *bytes = &m->w->bytes;
    const int dim = plain->dim, kind = take_below(bytes, 4);
    int32_t *to = m->node + m->offset[m->cells.n];
    int n = dim + 1;
    for (int j = 0; j <= dim; j++)
        to[j] = plain->elements ? plain->elements[element * (dim + 1) + j]
                                : (int32_t)plain->elements64[element * (dim + 1) + j];
    for (int e = 0; kind > 0 && e < (dim == 3 ? 6 : 3); e++) {
        const int64_t a = to[ends[e][0]], b = to[ends[e][1]];
        const int is_known = a >= 0 && b >= 0 && a < plain->n_nodes && b < plain->n_nodes;
        const double bend = kind == 3 ? take_finite(bytes) / 16 : 0;
        to[n++] = is_known && !take_chance(bytes, 16) ? (int32_t)m->mesh.n_nodes : -1;
        for (int d = 0; d < dim && to[n - 1] >= 0; d++)
            m->x[m->mesh.n_nodes * dim + d] =
                (m->x[a * dim + d] + m->x[b * dim + d]) / 2 + (d == 0 ? bend : 0);
        m->mesh.n_nodes += to[n - 1] >= 0;
    }
    m->type[m->cells.n++] =
        (uint8_t)(dim == 3 ? (kind > 0 ? PLANISH_CELL_TETRAHEDRON10 : PLANISH_CELL_TETRAHEDRON)
                           : (kind > 0 ? PLANISH_CELL_TRIANGLE6 : PLANISH_CELL_TRIANGLE));
    m->offset[m->cells.n] = m->offset[m->cells.n - 1] + n;
}

/** Add a cell of some type, or of one that there is not, with any nodes. */
static void add_other(making *m) {
    static const uint8_t types[][2] = {{12, 8},  {13, 6}, {14, 5},  {25, 20}, {26, 15}, {9, 4},
                                       {3, 2},   {1, 1},  {29, 27}, {32, 18}, {27, 13}, {23, 8},
                                       {42, 12}, {7, 5},  {28, 9},  {10, 4}};
    fuzz_bytes *bytes = &m->w->bytes;
    const uint8_t *of = types[take_below(bytes, 16)];
    const int64_t from = m->offset[m->cells.n];
    const int first = take_byte(bytes), step = 1 + take_below(bytes, 7);
    for (int i = 0; i < of[1]; i++)
        m->node[from + i] = (int32_t)((first + i * step) % m->mesh.n_nodes);
    m->type[m->cells.n++] = of[0];
    m->offset[m->cells.n] = from + of[1];
}

/** Whether a mesh has the arrays that its numbers say. */
static int is_whole(const fuzz_mesh *m) {
    const planish_mesh *mesh = &m->mesh;
    return mesh->n_nodes > 0 && (mesh->elements || mesh->elements64) &&
           m->n_coordinates == fuzz_at(mesh, mesh->n_nodes - 1, mesh->dim - 1) + 1;
}

/** Make cells of the elements, some others, and something wrong at times. */
static void make_cells(making *m) {
    work *w = m->w;
    const planish_mesh *plain = &w->mesh.mesh;
    const int64_t n = plain->n_elements, most = n + 4;
    m->mesh = *plain;
    m->type = fuzz_block(&w->mesh, most, 1);
    m->offset = fuzz_block(&w->mesh, most + 1, sizeof *m->offset);
    m->node = fuzz_block(&w->mesh, most * MOST_OF_CELL, sizeof *m->node);
    m->x = fuzz_block(&w->mesh, (plain->n_nodes + 6 * n) * plain->dim, sizeof *m->x);
    for (int64_t i = 0; i < plain->n_nodes; i++)
        for (int d = 0; d < plain->dim; d++)
            m->x[i * plain->dim + d] = plain->coordinates[fuzz_at(plain, i, d)];
    for (int64_t i = 0; i < n; i++)
        add_element(m, i);
    for (int k = take_below(&w->bytes, 4); k > 0; k--)
        add_other(m);
    if (take_chance(&w->bytes, 8))
        m->type[take_byte(&w->bytes) % m->cells.n] = take_byte(&w->bytes);
    if (take_chance(&w->bytes, 8)) {
        const int64_t at = take_byte(&w->bytes) % (m->cells.n + 1);
        if (at < m->cells.n) /* the last one says how many nodes there are */
            m->offset[at] = take_integer(&w->bytes);
    }
    if (take_chance(&w->bytes, 8)) {
        const int64_t at = take_byte(&w->bytes) % m->offset[m->cells.n];
        m->node[at] = (int32_t)take_integer(&w->bytes);
    }
    m->cells.type = m->type;
    m->cells.offset = m->offset;
    m->cells.node = m->node;
    m->mesh.cells = &m->cells;
    m->mesh.elements = NULL;
    m->mesh.elements64 = NULL;
    m->mesh.n_elements = m->cells.n;
    m->mesh.coordinates = m->x;
    m->mesh.node_stride = m->mesh.component_stride = 0;
    m->mesh.constraint = NULL;
    m->mesh.direction = NULL;
    m->mesh.min_volume = NULL;
    m->mesh.neighbours = NULL;
    m->mesh.neighbours64 = NULL;
}

static int measure_cells(const making *m, const double *x, planish_cell_quality *quality) {
    planish_mesh mesh = m->mesh;
    planish_error error;
    mesh.coordinates = x;
    if (!succeeded(planish_measure_cells(&mesh, 0, 1, quality, NULL, &error), &error))
        return 0;
    fuzz_require(quality->all.n_elements <= m->cells.n &&
                     quality->all.n_inverted + quality->all.n_uncertified <=
                         quality->all.n_elements,
                 "elements are counted");
    return 1;
}

/** Smooth x [n_nodes][dim] with so many threads. Returns 0 if that is refused, 1 if some elements
 *  were inverted, 2 if none was, by the plan's orientation. */
static int smooth_cells(const making *m, int threads, double *x) {
    planish_options options;
    planish_plan *plan;
    planish_result result;
    planish_quality before, after;
    planish_error error;
    planish_options_init(&options);
    options.threads = threads;
    if (!succeeded(planish_plan_create(&m->mesh, &options, &plan, &error), &error))
        return 0;
    fuzz_require(planish_measure(plan, x, &before, &error) == 0, "what has a plan is measured");
    const int done = succeeded(planish_smooth(plan, x, &options, &result, &error), &error);
    fuzz_require(planish_measure(plan, x, &after, &error) == 0, "what is smoothed is measured");
    fuzz_require(after.n_inverted <= before.n_inverted, "no more elements are inverted than were");
    planish_plan_destroy(plan);
    return !done ? 0 : before.n_inverted > 0 ? 1 : 2;
}

/** Cells are refused in a line, or smoothed with the same bits on other threads; where all elements
 *  were valid they stay so, curved ones as well. */
static void use_cells(work *w) {
    making m = {.w = w};
    planish_cell_quality before, after;
    make_cells(&m);
    const int64_t n = m.mesh.n_nodes * m.mesh.dim;
    const int known = measure_cells(&m, m.x, &before);
    double *x = copy_of(m.x, n, sizeof *x), *again = copy_of(m.x, n, sizeof *again);
    const int done = smooth_cells(&m, 1, x);
    fuzz_require(smooth_cells(&m, 2, again) == done, "other threads can do the same");
    fuzz_require(memcmp(x, again, (size_t)n * sizeof *x) == 0, "the same bits on two threads");
    fuzz_require(done || memcmp(x, m.x, (size_t)n * sizeof *x) == 0, "a failure moves nothing");
    fuzz_require(!done || known, "what is smoothed can be measured");
    if (done && measure_cells(&m, x, &after) && done == 2 &&
        before.all.n_inverted + before.all.n_uncertified == 0)
        fuzz_require(after.all.n_inverted == 0, "valid elements stay valid");
    free(x);
    free(again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    work w = {.bytes = {data, data + size}};
    planish_quality quality;
    planish_error error;
    fuzz_mesh_make(&w.bytes, &w.mesh);
    const int first = take_byte(&w.bytes);
    const int is_counted = w.mesh.mesh.n_nodes <= 1000 && w.mesh.mesh.n_nodes >= 0 &&
                           w.mesh.mesh.n_elements > 0 && w.mesh.mesh.n_elements <= 1000 &&
                           w.mesh.mesh.coordinates && (w.mesh.mesh.dim | 1) == 3;
    if (is_counted && (first & 192) == 192 && is_whole(&w.mesh))
        use_cells(&w);
    if (is_counted && (first & 3) == 3)
        find_slides(&w);
    if (is_counted && (first & 12) == 12)
        find_layers(&w);
    if (is_counted)
        fuzz_options_make(&w.bytes, &w.mesh, &w.user, &w.options);
    else
        planish_options_init(&w.options);
    if ((first & 48) == 48)
        succeeded(planish_measure_mesh(&w.mesh.mesh, &w.options, &quality, &error), &error);
    if (succeeded(planish_plan_create(&w.mesh.mesh, &w.options, &w.plan, &error), &error)) {
        use_plan(&w);
        planish_plan_destroy(w.plan);
    }
    fuzz_require(w.user.n_held == 0, "all blocks are released");
    fuzz_mesh_release(&w.mesh);
    return 0;
}
