/* random_calls: a mesh, a plan and a call with everything that can be chosen, drawn at random. */
#include "support/random_calls.h"

#include "support/effort.h"
#include "support/facets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const pairs_factor random_factors[N_FACTORS] = {
    [OF_DIM] = {"dim", {2, 3}},
    [OF_SHAPE] = {"shape", {3, 2, 2, 2, 2, 3, 1, 1}},
    [OF_CUT] = {"cut", {4, 1, 1}},
    [OF_PARTS] = {"parts", {6, 1, 1, 1, 1}},
    [OF_EXTRA] = {"extra", {6, 1, 1}},
    [OF_ORDER] = {"order", {4, 1, 1}},
    [OF_TANGLE] = {"tangle", {12, 1, 1, 1, 1, 1, 1}},
    [OF_PLACE] = {"place", {4, 2, 1, 1, 1}},
    [OF_PERIODIC] = {"periodic", {2, 1}},
    [OF_CONSTRAINT] = {"constraint", {4, 2, 4, 2, 2, 1}},
    [OF_LAYOUT] = {"layout", {2, 1, 1}},
    [OF_WIDTH] = {"width", {2, 1}},
    [OF_NEIGHBOURS] = {"neighbours", {2, 1, 1}},
    [OF_THREADS] = {"threads", {3, 2, 1, 1, 1}},
    [OF_BIND] = {"bind", {4, 1}},
    [OF_ISA] = {"isa", {2, 1, 1, 1, 1}},
    [OF_METHOD] = {"method", {12, 1, 1, 1}},
    [OF_OBJECTIVE] = {"objective", {2, 1, 1}},
    [OF_DIRECTION] = {"direction", {2, 1}},
    [OF_LEAST] = {"minimum volume", {6, 1, 1, 1, 1, 1, 1}},
    [OF_AREA_WEIGHT] = {"area_weight", {4, 1, 1}},
    [OF_LOWER] = {"lower", {3, 1}},
    [OF_UPPER] = {"upper", {3, 1}},
    [OF_BOX] = {"box", {3, 1, 1}},
    [OF_DISPLACEMENT] = {"max_displacement", {4, 1, 1}},
    [OF_UNIT] = {"displacement_unit", {1, 1}},
    [OF_PRECISION] = {"precision", {3, 1, 1}},
    [OF_UNTANGLE] = {"untangle", {1, 3}},
    [OF_WORST] = {"worst", {3, 1, 1}},
    [OF_WORST_RISE] = {"worst_rise", {1, 1, 1}},
    [OF_MAX_SWEEPS] = {"max_sweeps", {1, 1, 2, 4}},
    [OF_TOLERANCE] = {"tolerance", {1, 3, 1}},
    [OF_TIME_LIMIT] = {"time_limit", {6, 1, 1, 1}},
    [OF_WORSE_THAN] = {"only_worse_than", {4, 1, 1, 1}},
    [OF_SCOPE] = {"scope", {1, 1, 1}},
    [OF_RINGS] = {"rings", {2, 1, 1}},
    [OF_AROUND] = {"around", {6, 1, 1}},
    [OF_PROGRESS] = {"progress", {3, 1, 2, 1}},
    [OF_PROJECT] = {"project", {1, 2}},
    [OF_ALLOCATOR] = {"allocator", {6, 2, 1}},
    [OF_PARALLEL] = {"parallel", {4, 1}},
    [OF_LOG] = {"log", {3, 1}},
};

int random_levels_allowed(int a, int level_a, int b, int level_b) {
    if (a == OF_METHOD && b == OF_WORST)
        return level_a == PLANISH_METHOD_PLANISH || level_b == PLANISH_WORST_NONE;
    if (a == OF_LEAST && b == OF_AREA_WEIGHT)
        return level_b == 0 || (level_a != LEAST_NONE && level_a != LEAST_OWN_SOME);
    if (a == OF_LEAST && b == OF_AROUND)
        return level_a != LEAST_FRACTION || level_b == 0;
    return 1;
}

/* ---- the caller's memory ------------------------------------------------------------------- */

/** A block of the caller's, zeroed. */
static void *take(random_call *call, int64_t n, size_t size) {
    random_block *b = &call->block[call->n_blocks++];
    b->size = (size_t)n * size;
    b->data = calloc((size_t)n + 1, size);
    if (!b->data || call->n_blocks > RANDOM_BLOCKS)
        abort();
    return b->data;
}

static void *take_copy(random_call *call, const void *data, int64_t n, size_t size) {
    return memcpy(take(call, n, size), data, (size_t)n * size);
}

/** From here on nobody may change the blocks. */
static void remember(random_call *call) {
    for (int i = 0; i < call->n_blocks; i++) {
        random_block *b = &call->block[i];
        b->copy = malloc(b->size + 1);
        if (!b->copy)
            abort();
        memcpy(b->copy, b->data, b->size);
    }
}

/** Where coordinate d of a node is. */
static int64_t place_of(const random_call *call, int64_t node, int d) {
    const planish_mesh *m = &call->given;
    const int64_t step = m->node_stride ? m->node_stride : m->dim;
    return node * step + d * (m->component_stride ? m->component_stride : 1);
}

void random_call_put(const random_call *call, const double *x) {
    const int dim = call->dense.dim;
    for (int64_t i = 0; i < call->dense.n_nodes * dim; i++)
        call->coordinates[place_of(call, i / dim, (int)(i % dim))] = x[i];
}

void random_call_get(const random_call *call, double *x) {
    const int dim = call->dense.dim;
    for (int64_t i = 0; i < call->dense.n_nodes * dim; i++)
        x[i] = call->coordinates[place_of(call, i / dim, (int)(i % dim))];
}

int random_call_is_untouched(const random_call *call) {
    int same = 1;
    for (int i = 0; i < call->n_blocks; i++) {
        const random_block *b = &call->block[i];
        const int dim = call->dense.dim;
        double *copy = b->copy;
        for (int64_t k = 0; b->data == call->coordinates && k < call->dense.n_nodes * dim; k++) {
            const int64_t at = place_of(call, k / dim, (int)(k % dim));
            copy[at] = call->coordinates[at]; /* these may; what is between them may not */
        }
        same &= memcmp(b->data, b->copy, b->size) == 0;
    }
    return same;
}

/* ---- the mesh ------------------------------------------------------------------------------ */

int random_call_points(const int *level, int most, uint64_t *state) {
    enum { FEWEST = 4, MOST_TANGLED = 40 }; /* untangling may take long, and be in vain */
    const int tangled = level[OF_TANGLE] != RANDOM_VALID || level[OF_SHAPE] == RANDOM_GARBAGE;
    if (tangled && most > MOST_TANGLED)
        most = MOST_TANGLED;
    return (int)exp(random_between(state, log(FEWEST), log(most)));
}

static void draw_mesh(random_call *call, int n_points, uint64_t *state) {
    const int *l = call->level;
    const random_choice choice = {.dim = 2 + l[OF_DIM],
                                  .shape = (random_shape)l[OF_SHAPE],
                                  .cut = (random_cut)l[OF_CUT],
                                  .parts = (random_parts)l[OF_PARTS],
                                  .extra = (random_extra)l[OF_EXTRA],
                                  .order = (random_order)l[OF_ORDER],
                                  .tangle = (random_tangle)l[OF_TANGLE],
                                  .place = (random_place)l[OF_PLACE],
                                  .is_periodic = l[OF_PERIODIC],
                                  .n_points = n_points};
    random_mesh_create(&call->mesh, &choice, state);
    if (l[OF_PRECISION] == PLANISH_PRECISION_FLOAT)
        random_mesh_to_floats(&call->mesh);
    call->dense = call->mesh.base.mesh;
}

static void draw_slide(planish_constraint *kind, double *direction, int dim, uint64_t *state) {
    static const planish_constraint kinds[] = {PLANISH_CONSTRAINT_FREE, PLANISH_CONSTRAINT_FIXED,
                                               PLANISH_CONSTRAINT_ON_PLANE,
                                               PLANISH_CONSTRAINT_ON_LINE};
    *kind = kinds[random_below(state, 4)];
    for (int d = 0; d < dim; d++)
        direction[d] = random_between(state, -3, 3);
    if (random_below(state, 2)) /* along an axis */
        for (int d = 0, axis = (int)random_below(state, dim); d < dim; d++)
            direction[d] = d == axis ? 2 : 0;
}

/** How a node may move; any: what has been drawn for it. */
static planish_constraint constraint_of(int how, planish_constraint any, uint64_t *state) {
    const int some = random_below(state, 4) == 0;
    if (how == CONSTRAINT_ALL)
        return PLANISH_CONSTRAINT_FIXED;
    if (how == CONSTRAINT_ANY)
        return any;
    if (how == CONSTRAINT_SOME)
        return some ? PLANISH_CONSTRAINT_FIXED : PLANISH_CONSTRAINT_FREE;
    return some ? PLANISH_CONSTRAINT_FREE : PLANISH_CONSTRAINT_ON_SURFACE;
}

static void draw_constraints(random_call *call, uint64_t *state) {
    planish_mesh *mesh = &call->dense;
    const int how = call->level[OF_CONSTRAINT], dim = mesh->dim;
    if (how == CONSTRAINT_NONE)
        return;
    uint8_t *constraint = take(call, mesh->n_nodes, 1);
    double *direction = take(call, mesh->n_nodes * dim, sizeof *direction);
    if (how == CONSTRAINT_FOUND &&
        planish_find_slides(mesh, NULL, 1, constraint, direction, NULL, NULL))
        abort();
    for (int64_t i = 0; how != CONSTRAINT_FOUND && i < mesh->n_nodes; i++) {
        planish_constraint any;
        draw_slide(&any, direction + i * dim, dim, state);
        constraint[i] = (uint8_t)constraint_of(how, any, state);
    }
    mesh->constraint = constraint;
    mesh->direction = direction;
}

static void draw_minimum_volumes(random_call *call, uint64_t *state) {
    planish_mesh *mesh = &call->dense;
    const int how = call->level[OF_LEAST];
    const double mean = pow(call->mesh.size, mesh->dim) / (double)mesh->n_elements;
    const double least = mean * (how == LEAST_MET ? 1e-6 : random_between(state, 0.01, 0.8));
    planish_options *o = &call->options;
    if (how == LEAST_MET || how == LEAST_SOME || how == LEAST_BOTH)
        o->min_volume = least;
    if (how == LEAST_FRACTION)
        o->min_volume_fraction = random_between(state, 0.01, 0.5) / (double)mesh->n_elements;
    if (how < LEAST_OWN_SOME)
        return;
    double *own = take(call, mesh->n_elements, sizeof *own);
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        own[i] = mean * random_between(state, 0.01, 0.5);
        if (how != LEAST_OWN && (i == 0 || random_below(state, 3) == 0))
            own[i] = 0;
    }
    mesh->min_volume = own;
}

static void lay_out_elements(random_call *call) {
    planish_mesh *mesh = &call->given;
    const int64_t n = mesh->n_elements * (mesh->dim + 1);
    int32_t *elements = take_copy(call, call->dense.elements, n, sizeof *elements);
    int32_t *neighbours = take(call, n, sizeof *neighbours);
    mesh->elements = elements;
    test_neighbours(mesh, neighbours);
    if (call->level[OF_NEIGHBOURS] == 1)
        mesh->neighbours = neighbours;
    int64_t *wide = take(call, n, sizeof *wide), *far = take(call, n, sizeof *far);
    for (int64_t i = 0; i < n; i++) {
        wide[i] = elements[i];
        far[i] = neighbours[i];
    }
    if (call->level[OF_NEIGHBOURS] == 2)
        mesh->neighbours64 = far;
    if (call->level[OF_WIDTH] == 1) {
        mesh->elements64 = wide;
        mesh->elements = NULL;
    }
}

/** The arrays as the caller has them. */
static void lay_out(random_call *call) {
    planish_mesh *mesh = &call->given;
    const int dim = call->dense.dim, layout = call->level[OF_LAYOUT];
    const int64_t n = call->dense.n_nodes;
    enum { GAP = 3 };
    *mesh = call->dense;
    if (layout == 1)
        mesh->node_stride = dim + GAP;
    if (layout == 2) {
        mesh->node_stride = 1;
        mesh->component_stride = n + GAP;
    }
    const int64_t values = (n + GAP) * (dim + GAP);
    call->coordinates = take(call, values, sizeof(double));
    for (int64_t i = 0; i < values; i++)
        call->coordinates[i] = -7e77;
    random_call_put(call, call->mesh.base.coordinates);
    mesh->coordinates = take_copy(call, call->coordinates, values, sizeof(double));
    lay_out_elements(call);
    if (call->level[OF_PERIODIC]) {
        mesh->n_periodic = call->dense.n_periodic = call->mesh.n_periodic;
        mesh->periodic = call->dense.periodic = take_copy(
            call, call->mesh.periodic, 2 * call->mesh.n_periodic, sizeof *call->mesh.periodic);
    }
}

/* ---- options ------------------------------------------------------------------------------- */

/** Bounds of nodes: of most of them, some steps away; of some none, and some are beyond theirs. */
static const double *draw_bounds(random_call *call, int sign, uint64_t *state) {
    const int64_t n = call->dense.n_nodes * call->dense.dim;
    double *bound = take(call, n, sizeof *bound);
    for (int64_t i = 0; i < n; i++) {
        const double way = random_between(state, -0.005, 0.2) * call->mesh.size;
        bound[i] = call->mesh.base.coordinates[i] + sign * way;
        if (random_below(state, 4) == 0)
            bound[i] = sign > 0 ? INFINITY : -INFINITY;
        if (random_below(state, 4) == 0)
            bound[i] = call->mesh.base.coordinates[i];
    }
    return bound;
}

/** A box around the mesh, or around some of it. */
static void draw_box(random_call *call, uint64_t *state) {
    const int dim = call->dense.dim;
    const double *x = call->mesh.base.coordinates;
    const double more = call->level[OF_BOX] == 1 ? 0.1 : -0.2;
    for (int d = 0; d < dim; d++) {
        double low = x[d], high = x[d];
        for (int64_t i = 0; i < call->dense.n_nodes; i++) {
            low = fmin(low, x[i * dim + d]);
            high = fmax(high, x[i * dim + d]);
        }
        if (random_below(state, 4) > 0)
            call->options.box_lower[d] = low - more * (high - low);
        if (random_below(state, 4) > 0)
            call->options.box_upper[d] = high + more * (high - low);
    }
}

static void draw_around(random_call *call, uint64_t *state) {
    const int64_t n = 1 + random_below(state, 4);
    int64_t *node = take(call, n, sizeof *node), *element = take(call, n, sizeof *element);
    const int corners = call->dense.dim + 1;
    for (int64_t i = 0; i < n; i++) {
        element[i] = random_below(state, call->dense.n_elements);
        node[i] = call->dense.elements[element[i] * corners + random_below(state, corners)];
    }
    call->options.n_around = n;
    call->options.around = node;
    call->options.around_elements = call->level[OF_AROUND] == 2 ? element : NULL;
}

static void draw_limits(random_call *call, uint64_t *state) {
    static const double weights[] = {0, 0.3, 1}, far[] = {0, 0.02, 3}, rises[] = {0, 0.01, 0.5};
    static const double tolerances[] = {0, 1e-5, 0.5}, times[] = {0, 1e-9, 1e-3, 60};
    static const int sweeps[] = {0, 1, 3, 200}, rings[] = {0, 1, 3};
    const int *l = call->level;
    planish_options *o = &call->options;
    o->area_weight = weights[l[OF_AREA_WEIGHT]];
    o->displacement_unit = (planish_length_unit)l[OF_UNIT];
    o->max_displacement = far[l[OF_DISPLACEMENT]];
    if (o->displacement_unit == PLANISH_UNIT_MESH)
        o->max_displacement *= call->mesh.size;
    o->worst_rise = rises[l[OF_WORST_RISE]];
    o->max_sweeps = sweeps[l[OF_MAX_SWEEPS]];
    o->tolerance = tolerances[l[OF_TOLERANCE]];
    o->time_limit = times[l[OF_TIME_LIMIT]];
    o->rings = rings[l[OF_RINGS]];
    if (l[OF_LOWER])
        o->lower = draw_bounds(call, -1, state);
    if (l[OF_UPPER])
        o->upper = draw_bounds(call, 1, state);
    if (l[OF_BOX])
        draw_box(call, state);
    if (l[OF_AROUND])
        draw_around(call, state);
}

static void draw_choices(random_call *call) {
    static const int threads[] = {1, 2, 3, 8, 0};
    const int *l = call->level;
    planish_options *o = &call->options;
    o->threads = threads[l[OF_THREADS]];
    o->bind = l[OF_BIND];
    o->isa = (planish_isa)l[OF_ISA];
    o->method = (planish_method)l[OF_METHOD];
    o->objective = (planish_objective)l[OF_OBJECTIVE];
    o->search = (planish_search)l[OF_DIRECTION];
    o->precision = (planish_precision)l[OF_PRECISION];
    o->untangle = l[OF_UNTANGLE];
    o->worst = (planish_worst)l[OF_WORST];
    call->quantum = call->mesh.size * 1e-5;
}

/* ---- the call ------------------------------------------------------------------------------ */

/** Most of what would be refused is taken back. */
static void reconcile(int *level, uint64_t *state) {
    static const int giving_way[] = {OF_WORST, OF_AREA_WEIGHT, OF_AROUND};
    enum { EVERY = 8 };
    if (random_below(state, EVERY) == 0)
        return;
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < N_FACTORS; a++)
            if (!random_levels_allowed(a, level[a], giving_way[i], level[giving_way[i]]))
                level[giving_way[i]] = 0;
    if (level[OF_SCOPE] != SCOPE_CALL && level[OF_WORSE_THAN] > 0)
        level[OF_AROUND] = 0;
}

void random_call_create(random_call *call, const int *level, int n_points, uint64_t *state) {
    static const double worse_than[] = {0, 1.3, 3, 1e300};
    *call = (random_call){.n_blocks = 0};
    memcpy(call->level, level, sizeof call->level);
    reconcile(call->level, state);
    level = call->level;
    planish_options_init(&call->options);
    draw_mesh(call, n_points, state);
    draw_constraints(call, state);
    draw_minimum_volumes(call, state);
    lay_out(call);
    draw_choices(call);
    draw_limits(call, state);
    random_callbacks_draw(call, state);
    call->plan_options = call->options;
    if (level[OF_SCOPE] != SCOPE_CALL)
        call->plan_options.only_worse_than = worse_than[level[OF_WORSE_THAN]];
    if (level[OF_SCOPE] != SCOPE_PLAN)
        call->options.only_worse_than = worse_than[level[OF_WORSE_THAN]];
    remember(call);
}

void random_call_destroy(random_call *call) {
    for (int i = 0; i < call->n_blocks; i++) {
        free(call->block[i].data);
        free(call->block[i].copy);
    }
    random_mesh_destroy(&call->mesh);
}

void random_call_describe(const random_call *call, char *text, size_t size) {
    size_t at = (size_t)snprintf(text, size, "%lld nodes, %lld elements",
                                 (long long)call->dense.n_nodes, (long long)call->dense.n_elements);
    for (int i = 0; i < N_FACTORS; i++)
        if (call->level[i] != 0 && at < size)
            at += (size_t)snprintf(text + at, size - at, ", %s %d", random_factors[i].name,
                                   call->level[i]);
}
