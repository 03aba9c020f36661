/* random_cells: a small mesh of elements of any type and order, and a call, drawn at random. */
#include "support/random_cells.h"

#include "support/effort.h"
#include "support/random_surfaces.h"
#include "support/shape_functions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const pairs_factor cells_factors[N_CELLS_FACTORS] = {
    [CELLS_OF] = {"of", {2, 2, 3, 3, 2, 3, 2, 3}},
    [CELLS_ORDER] = {"order", {4, 2, 2}},
    [CELLS_SHAKE] = {"shake", {1, 4, 2}},
    [CELLS_BEND] = {"bend", {2, 2, 1, 1}},
    [CELLS_TORN] = {"torn", {6, 1, 1}},
    [CELLS_TURNED] = {"turned", {6, 1, 1}},
    [CELLS_PLACE] = {"place", {6, 1, 1, 1}},
    [CELLS_CONSTRAINT] = {"constraint", {3, 1, 3, 1, 1}},
    [CELLS_PERIODIC] = {"periodic", {5, 1}},
    [CELLS_LAYOUT] = {"layout", {3, 1, 1}},
    [CELLS_TARGET] = {"target", {6, 1, 1, 1, 1, 1}},
    [CELLS_WEIGHT] = {"size_weight", {2, 1, 1}},
    [CELLS_CURVE] = {"curve_quality", {2, 1, 1}},
    [CELLS_THREADS] = {"threads", {2, 2, 1, 1, 1}},
    [CELLS_ISA] = {"isa", {2, 1, 1, 1, 1}},
    [CELLS_METHOD] = {"method", {12, 1, 1, 1}},
    [CELLS_OBJECTIVE] = {"objective", {3, 1, 1}},
    [CELLS_SEARCH] = {"search", {4, 1}},
    [CELLS_LEAST] = {"minimum volume", {6, 1, 1, 1, 1}},
    [CELLS_AREA_WEIGHT] = {"area_weight", {4, 1, 1}},
    [CELLS_BOX] = {"box", {4, 1}},
    [CELLS_LOWER] = {"lower", {4, 1}},
    [CELLS_DISPLACEMENT] = {"max_displacement", {4, 1, 1}},
    [CELLS_UNIT] = {"displacement_unit", {1, 1}},
    [CELLS_PRECISION] = {"precision", {4, 1}},
    [CELLS_UNTANGLE] = {"untangle", {1, 4}},
    [CELLS_WORST] = {"worst", {4, 1, 1, 1, 1}},
    [CELLS_SWEEPS] = {"max_sweeps", {1, 1, 2, 4}},
    [CELLS_TOLERANCE] = {"tolerance", {1, 3, 1}},
    [CELLS_TIME_LIMIT] = {"time_limit", {8, 1}},
    [CELLS_WORSE_THAN] = {"only_worse_than", {4, 1, 1}},
    [CELLS_SCOPE] = {"scope", {1, 1}},
    [CELLS_RINGS] = {"rings", {2, 1, 1}},
    [CELLS_AROUND] = {"around", {6, 1}},
    [CELLS_PROGRESS] = {"progress", {3, 1}},
    [CELLS_SURFACE] = {"surface", {5, 2, 1, 1}},
    [CELLS_REGIONS] = {"regions", {5, 1, 1}},
};

static int is_chosen(uint64_t *state, double chance) {
    return random_unit(state) < chance;
}

static void *zeroed(int64_t n, size_t size) {
    void *block = calloc((size_t)n + 1, size);
    if (!block)
        abort();
    return block;
}

/* ---- elements ---------------------------------------------------------------------------------- */

/** Cut quadrilaterals into triangles, hexahedra into tetrahedra (Kuhn). */
static void cut(cell_box *b) {
    static const uint8_t flat[2][3] = {{0, 1, 2}, {0, 2, 3}};
    static const uint8_t solid[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6},
                                        {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
    const int dim = b->mesh.dim, corners = dim + 1, parts = dim == 2 ? 2 : 6;
    const int64_t n = b->cells.n * parts;
    int32_t *node = zeroed(n * corners, sizeof *node);
    free(b->type);
    b->type = zeroed(n, 1);
    for (int64_t i = 0; i < n * corners; i++) {
        const int64_t element = i / corners, from = element / parts;
        const uint8_t k =
            dim == 2 ? flat[element % parts][i % corners] : solid[element % parts][i % corners];
        node[i] = b->node[b->offset[from] + k];
        b->type[element] = dim == 2 ? PLANISH_CELL_TRIANGLE : PLANISH_CELL_TETRAHEDRON;
    }
    free(b->node);
    free(b->offset);
    b->node = node;
    b->offset = zeroed(n, sizeof *b->offset);
    for (int64_t i = 0; i <= n; i++)
        b->offset[i] = i * corners;
}

/** Tell the mesh of n cells where its arrays are. */
static void link_arrays(cell_box *b, int64_t n) {
    b->cells.n = b->mesh.n_elements = n;
    b->cells.type = b->type;
    b->cells.offset = b->offset;
    b->cells.node = b->node;
}

/** The type of order 1 that has the corners of a type. */
static int straight(int type) {
    switch (type) {
    case PLANISH_CELL_TRIANGLE6:
        return PLANISH_CELL_TRIANGLE;
    case PLANISH_CELL_QUADRILATERAL8:
    case PLANISH_CELL_QUADRILATERAL9:
        return PLANISH_CELL_QUADRILATERAL;
    case PLANISH_CELL_TETRAHEDRON10:
        return PLANISH_CELL_TETRAHEDRON;
    case PLANISH_CELL_HEXAHEDRON20:
    case PLANISH_CELL_HEXAHEDRON27:
        return PLANISH_CELL_HEXAHEDRON;
    case PLANISH_CELL_WEDGE15:
    case PLANISH_CELL_WEDGE18:
        return PLANISH_CELL_WEDGE;
    default:
        return type;
    }
}

/** Place the mids of an element where its map of order 1 has them. */
static void place_mids(cell_box *b, int64_t i) {
    const int type = b->type[i], of = straight(type), dim = b->mesh.dim;
    const int n = (int)(b->offset[i + 1] - b->offset[i]);
    const int32_t *node = b->node + b->offset[i];
    int corners = 0;
    while (corners < n && shape_place(type)[corners][0] != 0.5 &&
           shape_place(type)[corners][1] != 0.5 && shape_place(type)[corners][2] != 0.5)
        corners++;
    for (int k = corners; of != type && k < n; k++)
        for (int d = 0; d < dim; d++) {
            double sum = 0;
            for (int c = 0; c < corners; c++)
                sum += shape_value(of, c, shape_place(type)[k]) * b->x[(int64_t)node[c] * dim + d];
            b->x[(int64_t)node[k] * dim + d] = sum;
        }
}

/** Make the box of a call. *regular: its coordinates before nodes are pushed, to be freed; *first: the first
 *  mid. */
static cell_box *box_of(const int *level, uint64_t *state, double **regular, int64_t *first) {
    static const cell_box_kind kinds[] = {BOX_QUADRILATERALS, BOX_MIXED_2D, BOX_HEXAHEDRA,
                                          BOX_WEDGES,         BOX_PYRAMIDS, BOX_MIXED,
                                          BOX_QUADRILATERALS, BOX_HEXAHEDRA};
    static const double noise[] = {0.2, 0.18, 0.2, 0.2, 0.14, 0.14, 0.15, 0.1};
    const int of = level[CELLS_OF], is_cut = of >= CELLS_TRIANGLES;
    const int is_flat = kinds[of] == BOX_QUADRILATERALS || kinds[of] == BOX_MIXED_2D;
    const int n = 2 + (int)random_below(state, is_flat ? 4 : level[CELLS_ORDER] ? 1 : 2);
    cell_box *box = cell_box_create(kinds[of], n);
    if (is_cut) {
        cut(box);
        link_arrays(box, box->cells.n * (is_flat ? 2 : 6));
    }
    cell_box *result = level[CELLS_ORDER] ? cell_box_raise(box, level[CELLS_ORDER] == 2) : box;
    const size_t size = (size_t)(result->mesh.n_nodes * result->mesh.dim) * sizeof **regular;
    *first = box->mesh.n_nodes;
    *regular =
        memcpy(zeroed(result->mesh.n_nodes * result->mesh.dim, sizeof **regular), result->x, size);
    if (level[CELLS_SHAKE])
        cell_box_shake(box,
                       level[CELLS_SHAKE] == 1 ? noise[of] * random_unit(state)
                                               : random_between(state, 0.2, 0.7),
                       random_bits(state));
    if (level[CELLS_SURFACE])
        cells_bulge(box->x, box->mesh.n_nodes, n, state);
    memcpy(result->x, box->x, (size_t)(*first * box->mesh.dim) * sizeof *box->x);
    for (int64_t i = 0; i < result->cells.n; i++)
        place_mids(result, i);
    if (result != box)
        cell_box_destroy(box);
    return result;
}

/** Find the nodes on a side of the box, as it was before nodes were pushed. */
static void find_outside(cells_call *c, const double *regular) {
    const int dim = c->box->mesh.dim;
    double size = 0;
    for (int64_t i = 0; i < c->box->mesh.n_nodes * dim; i++)
        size = fmax(size, regular[i]);
    for (int64_t i = 0; i < c->box->mesh.n_nodes * dim; i++)
        c->is_outside[i / dim] |= regular[i] == 0 || regular[i] == size;
}

/** Push mids off the middle. */
static void bend(cells_call *c, uint64_t *state) {
    static const double amounts[] = {0, 0.05, 0.4, 0.05};
    const int level = c->level[CELLS_BEND], dim = c->box->mesh.dim;
    for (int64_t i = c->first_mid * dim; i < c->box->mesh.n_nodes * dim; i++)
        if (level == 3 || !c->is_outside[i / dim])
            c->box->x[i] += random_between(state, -amounts[level], amounts[level]);
}

/** Leave out some elements. */
static void tear(cell_box *b, uint64_t *state) {
    int64_t n = 0, at = 0;
    for (int64_t i = 0; i < b->cells.n; i++) {
        const int64_t begin = b->offset[i], end = b->offset[i + 1];
        if (i + 1 < b->cells.n && is_chosen(state, 0.15))
            continue;
        memmove(b->node + at, b->node + begin, (size_t)(end - begin) * sizeof *b->node);
        b->type[n] = b->type[i];
        b->offset[n++] = at;
        at += end - begin;
    }
    b->offset[n] = at;
    link_arrays(b, n);
}

/** Add lines between neighbours, which hold them. */
static void add_lines(cells_call *c, uint64_t *state) {
    enum { LINES = 2 };
    cell_box *b = c->box;
    const int64_t n = b->cells.n, used = b->offset[n];
    b->type = realloc(b->type, (size_t)n + LINES);
    b->offset = realloc(b->offset, (size_t)(n + LINES + 1) * sizeof *b->offset);
    b->node = realloc(b->node, (size_t)(used + 2 * LINES) * sizeof *b->node);
    if (!b->type || !b->offset || !b->node)
        abort();
    for (int64_t i = n; i < n + LINES; i++) {
        const int64_t of = b->offset[random_below(state, n)], at = b->offset[i];
        b->type[i] = PLANISH_CELL_LINE;
        b->offset[i + 1] = at + 2;
        for (int k = 0; k < 2; k++) {
            b->node[at + k] = b->node[of + k];
            c->is_held[b->node[of + k]] = 1;
        }
    }
    link_arrays(b, n + LINES);
}

/** Reverse the order in which an element of order 1 is listed. */
static void reverse(cells_call *c, int64_t i) {
    static const uint8_t orders[PLANISH_CELL_PYRAMID + 1][8] = {
        [PLANISH_CELL_TRIANGLE] = {0, 2, 1},
        [PLANISH_CELL_QUADRILATERAL] = {0, 3, 2, 1},
        [PLANISH_CELL_TETRAHEDRON] = {0, 2, 1, 3},
        [PLANISH_CELL_HEXAHEDRON] = {4, 5, 6, 7, 0, 1, 2, 3},
        [PLANISH_CELL_WEDGE] = {3, 4, 5, 0, 1, 2},
        [PLANISH_CELL_PYRAMID] = {0, 3, 2, 1, 4}};
    int32_t *node = c->box->node + c->box->offset[i], old[8];
    const int n = (int)(c->box->offset[i + 1] - c->box->offset[i]);
    memcpy(old, node, (size_t)n * sizeof *old);
    for (int k = 0; k < n; k++)
        node[k] = old[orders[c->box->type[i]][k]];
    c->sign[i] = (int8_t)-c->sign[i];
}

static void turn(cells_call *c, uint64_t *state) {
    cell_box *b = c->box;
    for (int64_t i = 0; i < b->cells.n; i++)
        c->sign[i] = c->level[CELLS_TURNED] == 1 ? -1 : 1;
    for (int64_t i = 0; c->level[CELLS_TURNED] == 1 && i < b->mesh.n_nodes; i++)
        b->x[i * b->mesh.dim] *= -1;
    for (int64_t i = 0; c->level[CELLS_TURNED] == 2 && i < b->cells.n; i++)
        if (b->type[i] != PLANISH_CELL_LINE && is_chosen(state, 0.2))
            reverse(c, i);
}

static void put(cells_call *c) {
    static const double shifts[] = {0, 1e5, 0, 0}, scales[] = {1, 1, 0x1p-60, 0x1p60};
    const int place = c->level[CELLS_PLACE];
    for (int64_t i = 0; i < c->box->mesh.n_nodes * c->box->mesh.dim; i++) {
        c->box->x[i] = (c->box->x[i] + shifts[place]) * scales[place];
        if (c->level[CELLS_PRECISION])
            c->box->x[i] = (float)c->box->x[i];
    }
}

/** The mesh as it was before nodes were pushed: what it is to look like. */
static void draw_target(cells_call *c, const double *regular, uint64_t *state) {
    const int dim = c->box->mesh.dim, kind = c->level[CELLS_TARGET];
    const int64_t n = c->box->mesh.n_nodes;
    const double stretch = kind == TARGET_STRETCHED ? random_between(state, 0.2, 5) : 1;
    c->target = zeroed(n * dim, sizeof *c->target);
    for (int64_t i = 0; i < n * dim; i++)
        c->target[i] = regular[i] * (i % dim == 1 ? stretch : 1);
    if (c->level[CELLS_TURNED] == 1)
        for (int64_t i = 0; i < n; i++)
            c->target[i * dim] *= -1;
}

static void draw_mesh(cells_call *c, uint64_t *state) {
    double *regular;
    c->box = box_of(c->level, state, &regular, &c->first_mid);
    c->is_outside = zeroed(c->box->mesh.n_nodes, 1);
    c->is_held = zeroed(c->box->mesh.n_nodes, 1);
    find_outside(c, regular);
    bend(c, state);
    if (c->level[CELLS_TARGET] == TARGET_BOX || c->level[CELLS_TARGET] == TARGET_STRETCHED)
        draw_target(c, regular, state);
    if (c->level[CELLS_TORN] == 1)
        tear(c->box, state);
    if (c->level[CELLS_TORN] == 2)
        add_lines(c, state);
    c->sign = zeroed(c->box->cells.n, 1);
    turn(c, state);
    put(c);
    cells_draw_surface(c, regular);
    free(regular);
}

/* ---- arrays ------------------------------------------------------------------------------------- */

/** Lay out [n_nodes][dim] as the caller has it; free with free. */
static double *laid_out(const cells_call *c, const double *x) {
    const int dim = c->box->mesh.dim;
    const int64_t n = c->box->mesh.n_nodes;
    double *out = zeroed((n + 1) * (dim + 1), sizeof *out);
    for (int64_t i = 0; i < n * dim; i++) {
        const int64_t step = c->given.node_stride ? c->given.node_stride : dim;
        const int64_t far = c->given.component_stride ? c->given.component_stride : 1;
        out[i / dim * step + i % dim * far] = x[i];
    }
    return out;
}

static double scale_of(const cells_call *c) {
    return c->level[CELLS_PLACE] == 2 ? 0x1p-60 : c->level[CELLS_PLACE] == 3 ? 0x1p60 : 1;
}

static void draw_constraints(cells_call *c, uint64_t *state) {
    const int how = c->level[CELLS_CONSTRAINT], dim = c->given.dim;
    const int64_t n = c->given.n_nodes;
    if (how == CELLS_FREE && !c->level[CELLS_SURFACE] && !c->level[CELLS_REGIONS])
        return;
    c->constraint = zeroed(n, 1);
    c->direction = zeroed(n * dim, sizeof *c->direction);
    if (how != CELLS_SOME_FIXED && how != CELLS_ANY)
        cells_find_slides(c);
    for (int64_t i = 0; i < n; i++) {
        static const uint8_t kinds[] = {PLANISH_CONSTRAINT_FREE, PLANISH_CONSTRAINT_FIXED,
                                        PLANISH_CONSTRAINT_ON_PLANE, PLANISH_CONSTRAINT_ON_LINE};
        if (how == CELLS_ANY)
            c->constraint[i] = kinds[random_below(state, 4)];
        for (int d = 0; how == CELLS_ANY && d < dim; d++)
            c->direction[i * dim + d] = random_between(state, -2, 2);
        if ((how == CELLS_SOME_FIXED || how == CELLS_SLIDES_FIXED) && is_chosen(state, 0.15))
            c->constraint[i] = PLANISH_CONSTRAINT_FIXED;
    }
    c->given.constraint = c->constraint;
    c->given.direction = c->direction;
}

/** Nodes of both ends along the first direction, in pairs. */
static void draw_pairs(cells_call *c) {
    const int dim = c->given.dim;
    const int64_t n = c->given.n_nodes;
    const double *x = c->box->x;
    double low = INFINITY, high = -INFINITY;
    for (int64_t i = 0; i < n; i++) {
        low = fmin(low, x[i * dim]);
        high = fmax(high, x[i * dim]);
    }
    c->periodic = zeroed(2 * n, sizeof *c->periodic);
    for (int64_t a = 0; a < n; a++)
        for (int64_t b = 0; x[a * dim] == low && b < n; b++)
            if (x[b * dim] == high &&
                memcmp(x + a * dim + 1, x + b * dim + 1, (size_t)(dim - 1) * sizeof *x) == 0) {
                c->periodic[2 * c->given.n_periodic] = (int32_t)a;
                c->periodic[2 * c->given.n_periodic++ + 1] = (int32_t)b;
            }
    c->given.periodic = c->periodic;
}

static void draw_sizes(cells_call *c, uint64_t *state) {
    const int dim = c->given.dim, of_metric = dim * (dim + 1) / 2;
    const int64_t n = c->given.n_nodes;
    const double scale = scale_of(c);
    c->size = zeroed(n, sizeof *c->size);
    c->metric = zeroed(n * of_metric, sizeof *c->metric);
    const double skew = random_between(state, -0.5, 0.5), longer = random_between(state, 1, 20);
    for (int64_t i = 0; i < n; i++) {
        c->size[i] = scale * random_between(state, 0.5, 1);
        double *m = c->metric + i * of_metric;
        m[0] = longer / (scale * scale);
        m[1] = skew / (scale * scale);
        m[2] = m[of_metric - 1] = 1 / (scale * scale);
    }
    if (c->level[CELLS_TARGET] == TARGET_SIZE)
        c->given.size = c->size;
    else
        c->given.metric = c->metric;
}

static void draw_layer(cells_call *c) {
    c->is_layer = zeroed(c->box->cells.n, 1);
    for (int64_t i = 0; i < c->box->cells.n / 3 + 1; i++)
        c->is_layer[i] = 1;
    c->given.is_layer = c->is_layer;
}

static double volume_of(const cells_call *c) {
    return pow(scale_of(c), c->given.dim);
}

static void draw_volumes(cells_call *c, uint64_t *state) {
    const int how = c->level[CELLS_LEAST];
    planish_options *o = &c->options;
    if (how == 1 || how == 2)
        o->min_volume = volume_of(c) * (how == 1 ? 1e-4 : random_between(state, 0.05, 0.5));
    if (how == 3)
        o->min_volume_fraction = random_between(state, 1e-5, 0.01);
    if (how != 4)
        return;
    c->least = zeroed(c->box->cells.n, sizeof *c->least);
    for (int64_t i = 0; i < c->box->cells.n; i++)
        c->least[i] = is_chosen(state, 0.4) ? volume_of(c) * random_between(state, 0, 0.3) : 0;
    c->given.min_volume = c->least;
}

/* ---- options ------------------------------------------------------------------------------------ */

/** Stop at a call after a colour or a sweep: while proofs are searched for, calls come by the clock. */
static int stop(const planish_progress *progress, void *user) {
    cells_call *c = user;
    return (progress->colour > 0 || progress->sweep_done) && c->calls++ == c->stop_at;
}

static void draw_choices(cells_call *c) {
    static const int threads[] = {1, 2, 3, 5, 8};
    static const double weights[] = {0, 0.4, 1}, curves[] = {0.3, 0, 1};
    const int *l = c->level;
    planish_options *o = &c->options;
    o->threads = threads[l[CELLS_THREADS]];
    o->isa = (planish_isa)l[CELLS_ISA];
    o->method = (planish_method)l[CELLS_METHOD];
    o->objective = (planish_objective)l[CELLS_OBJECTIVE];
    o->search = (planish_search)l[CELLS_SEARCH];
    o->precision = (planish_precision)l[CELLS_PRECISION];
    o->untangle = l[CELLS_UNTANGLE];
    o->worst = (planish_worst)l[CELLS_WORST];
    o->size_weight = weights[l[CELLS_WEIGHT]];
    o->curve_quality = curves[l[CELLS_CURVE]];
}

static void draw_limits(cells_call *c, uint64_t *state) {
    static const double weights[] = {0, 0.3, 1}, far[] = {0, 0.05, 2},
                        tolerances[] = {0, 1e-5, 0.5};
    static const int sweeps[] = {0, 1, 5, 200}, rings[] = {0, 1, 3};
    const int *l = c->level, dim = c->given.dim;
    const double scale = scale_of(c), shift = l[CELLS_PLACE] == 1 ? 1e5 : 0;
    planish_options *o = &c->options;
    o->area_weight = weights[l[CELLS_AREA_WEIGHT]];
    o->displacement_unit = (planish_length_unit)l[CELLS_UNIT];
    o->max_displacement = far[l[CELLS_DISPLACEMENT]];
    if (o->displacement_unit == PLANISH_UNIT_MESH)
        o->max_displacement *= scale;
    o->max_sweeps = sweeps[l[CELLS_SWEEPS]];
    o->tolerance = tolerances[l[CELLS_TOLERANCE]];
    o->time_limit = l[CELLS_TIME_LIMIT] ? 1e-3 : 0;
    o->rings = rings[l[CELLS_RINGS]];
    o->worst_rise = random_between(state, 0, 0.1);
    for (int d = 0; l[CELLS_BOX] && d < dim; d++)
        o->box_upper[d] = (random_between(state, 1.5, 4) + shift) * scale;
    if (l[CELLS_LOWER]) {
        c->lower = zeroed(c->given.n_nodes * dim, sizeof *c->lower);
        for (int64_t i = 0; i < c->given.n_nodes * dim; i++)
            c->lower[i] = is_chosen(state, 0.3)
                              ? -INFINITY
                              : c->box->x[i] - random_between(state, -0.01, 0.3) * scale;
        o->lower = c->lower;
    }
    c->stop_at = random_below(state, 30);
    o->progress = l[CELLS_PROGRESS] ? stop : NULL;
    o->progress_user = c;
}

static void draw_around(cells_call *c, uint64_t *state) {
    for (int k = 0; k < 2; k++)
        c->around[k] = c->box->node[random_below(state, c->box->offset[c->box->cells.n])];
    c->plan_options.n_around = 2;
    c->plan_options.around = c->around;
}

/** What is asked of the plan alone, or of the call alone. */
static void draw_scopes(cells_call *c, uint64_t *state) {
    static const double bad[] = {0, 1.05, 1.5};
    const double worse = bad[c->level[CELLS_WORSE_THAN]];
    c->plan_options = c->options;
    if (c->level[CELLS_SCOPE] == 0)
        c->plan_options.only_worse_than = worse;
    else
        c->options.only_worse_than = worse;
    if (c->level[CELLS_AROUND])
        draw_around(c, state);
}

/* ---- calls -------------------------------------------------------------------------------------- */

int cells_levels_allowed(int a, int level_a, int b, int level_b) {
    if (a > b)
        return cells_levels_allowed(b, level_b, a, level_a);
    if (a == CELLS_OF && b == CELLS_WORST)
        return level_b == 0 || (level_a >= CELLS_TRIANGLES) == (level_b <= PLANISH_WORST_ANGLE);
    if (a == CELLS_TARGET && b == CELLS_WORST)
        return level_a == TARGET_NONE || level_b == 0;
    if (a == CELLS_TARGET && b == CELLS_OBJECTIVE)
        return level_a == TARGET_NONE || level_b != PLANISH_OBJECTIVE_EDGE_RATIO;
    if (a == CELLS_OF && b == CELLS_SURFACE)
        return level_b == 0 || (level_a >= CELLS_HEXAHEDRA && level_a != CELLS_TRIANGLES);
    if (a == CELLS_CONSTRAINT && b == CELLS_SURFACE)
        return level_b == 0 || (level_a != CELLS_SOME_FIXED && level_a != CELLS_ANY);
    if (a == CELLS_METHOD && b == CELLS_WORST)
        return level_a == 0 || level_b == 0;
    if (a == CELLS_LEAST && b == CELLS_AREA_WEIGHT)
        return level_b == 0 || (level_a != 0 && level_a != 4);
    if (a == CELLS_LEAST && b == CELLS_AROUND)
        return level_a != 3 || level_b == 0;
    if (a == CELLS_PERIODIC && b == CELLS_TARGET)
        return level_a == 0 || level_b == TARGET_NONE || level_b == TARGET_LAYER;
    return 1;
}

static void reconcile(int *level) {
    static const int giving_way[] = {CELLS_OBJECTIVE, CELLS_WORST,    CELLS_AREA_WEIGHT,
                                     CELLS_AROUND,    CELLS_PERIODIC, CELLS_SURFACE};
    enum { N_GIVING_WAY = sizeof giving_way / sizeof *giving_way };
    if (level[CELLS_OF] >= CELLS_TRIANGLES && level[CELLS_WORST] > 0) /* they have other measures */
        level[CELLS_WORST] = (level[CELLS_WORST] + 1) / 2;
    else if (level[CELLS_WORST] > 0)
        level[CELLS_WORST] = (level[CELLS_WORST] + 1) / 2 + 2;
    if (level[CELLS_ORDER] > 0 && level[CELLS_TURNED] == 2)
        level[CELLS_TURNED] = 0;
    if (level[CELLS_ORDER] == 0)
        level[CELLS_BEND] = 0;
    /* An element that nothing joins has the handedness of most, and may then count as inverted. */
    if (level[CELLS_TORN] == 1 && level[CELLS_TURNED] == 2)
        level[CELLS_TURNED] = 0;
    for (int i = 0; i < N_GIVING_WAY; i++)
        for (int a = 0; a < N_CELLS_FACTORS; a++)
            if (!cells_levels_allowed(a, level[a], giving_way[i], level[giving_way[i]]))
                level[giving_way[i]] = 0;
    if (level[CELLS_SCOPE] == 0 && level[CELLS_WORSE_THAN] > 0)
        level[CELLS_AROUND] = 0;
    if (level[CELLS_TARGET] == TARGET_SIZE && level[CELLS_WEIGHT] == 0)
        level[CELLS_WEIGHT] = 1;
    if (level[CELLS_TARGET] == TARGET_NONE || level[CELLS_TARGET] == TARGET_LAYER)
        level[CELLS_WEIGHT] = 0;
}

cells_call *cells_call_create(const int *level, uint64_t *state) {
    cells_call *c = zeroed(1, sizeof *c);
    memcpy(c->level, level, sizeof c->level);
    reconcile(c->level);
    planish_options_init(&c->options);
    draw_mesh(c, state);
    c->given = c->box->mesh;
    draw_constraints(c, state);
    if (c->level[CELLS_PERIODIC])
        draw_pairs(c);
    if (c->level[CELLS_TARGET] == TARGET_SIZE || c->level[CELLS_TARGET] == TARGET_METRIC)
        draw_sizes(c, state);
    if (c->level[CELLS_TARGET] == TARGET_LAYER)
        draw_layer(c);
    draw_volumes(c, state);
    draw_choices(c);
    draw_limits(c, state);
    draw_scopes(c, state);
    c->given.node_stride = c->level[CELLS_LAYOUT] == 1 ? c->given.dim + 1 : 0;
    if (c->level[CELLS_LAYOUT] == 2) {
        c->given.node_stride = 1;
        c->given.component_stride = c->given.n_nodes + 1;
    }
    c->coordinates = laid_out(c, c->box->x);
    c->start = laid_out(c, c->box->x);
    c->given.coordinates = c->start;
    if (c->target) {
        c->reference = laid_out(c, c->target);
        c->given.reference = c->reference;
    }
    return c;
}

void cells_call_destroy(cells_call *c) {
    void *const owned[] = {c->coordinates, c->sign,     c->is_outside, c->is_held,
                           c->constraint,  c->is_layer, c->direction,  c->least,
                           c->reference,   c->size,     c->metric,     c->lower,
                           c->start,       c->target,   c->periodic,   c->region};
    for (size_t i = 0; i < sizeof owned / sizeof *owned; i++)
        free(owned[i]);
    planish_shape_destroy(c->shape);
    cell_box_destroy(c->box);
    free(c);
}

void cells_call_rewind(cells_call *c) {
    const int dim = c->given.dim;
    memcpy(c->coordinates, c->start,
           (size_t)((c->given.n_nodes + 1) * (dim + 1)) * sizeof *c->coordinates);
    c->calls = 0;
}

void cells_call_get(const cells_call *c, double *x) {
    const int dim = c->given.dim;
    const int64_t step = c->given.node_stride ? c->given.node_stride : dim;
    const int64_t far = c->given.component_stride ? c->given.component_stride : 1;
    for (int64_t i = 0; i < c->given.n_nodes * dim; i++)
        x[i] = c->coordinates[i / dim * step + i % dim * far];
}

void cells_call_describe(const cells_call *c, char *text, size_t size) {
    size_t at = (size_t)snprintf(text, size, "%lld nodes, %lld cells", (long long)c->given.n_nodes,
                                 (long long)c->box->cells.n);
    for (int i = 0; i < N_CELLS_FACTORS; i++)
        if (c->level[i] != 0 && at < size)
            at += (size_t)snprintf(text + at, size - at, ", %s %d", cells_factors[i].name,
                                   c->level[i]);
}
