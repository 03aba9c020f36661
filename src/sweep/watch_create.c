/* watch_create: search for the cells to be watched, and their lists. */
#include "sweep/watch_cell.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "quality/measure_block.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <string.h>

enum {
    CHUNK = 256,       /* cells that one thread takes at a time, */
    CHUNK_NODES = 4096 /* or nodes */
};

/** A search for cells. */
typedef struct search {
    pl_watch *watch;
    const planish_options *options;
    double min_volume; /* of cells without their own */
    uint8_t *is_off;   /* [nodes of the mesh] nodes that may be off the middle of their corners */
    int32_t *
        leader; /* [n_nodes] by inner numbers: the node that each follows, -1: none; NULL: none does */
    uint8_t has_type[PL_WATCH_TYPES]; /* shared, as are these: */
    int64_t n_curved;
    int64_t lowest; /* node that is not finite, or INT64_MAX */
    double largest; /* coordinate of these nodes, absolute */
    int fills;      /* lists: count, or fill in */
} search;

/** Whether a node may be off the middle of an edge by more than a part of an element's longest edge: by half as much of
 *  this edge. Differences are rounded once. */
static int may_be_off(const pl_mids *mids, int32_t node, const double *from, const double *to) {
    const double part = 0.5 * PL_STRAIGHT;
    const int dim = mids->start.dim;
    double off = 0, edge = 0;
    for (int d = 0; d < dim; d++) {
        const double way = to[d] - from[d];
        const double x = pl_mid_coordinate(mids, node, d, 0) - from[d] - 0.5 * way;
        off += x * x;
        edge += way * way;
    }
    return off > part * part * edge;
}

/** Find the nodes that may be off, and the lowest that is not finite. */
static void mids_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    const pl_mids *m = &s->watch->mids;
    const int dim = m->start.dim;
    int64_t lowest = INT64_MAX;
    double largest = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        s->is_off[i] = 0;
        if (m->end[i][0] == PL_NO_MID)
            continue;
        /* Of a node with several parents any may be noted: its cells decide each by its own. */
        s->is_off[i] =
            m->end[i][0] == PL_OF_MORE || m->plan->role[i] & PL_OF_EDGES ||
            (m->end[i][0] >= 0 && may_be_off(m, (int32_t)i, m->given + (int64_t)m->end[i][0] * dim,
                                             m->given + (int64_t)m->end[i][1] * dim));
        for (int d = 0; d < dim; d++) {
            const double x = pl_mid_coordinate(m, (int32_t)i, d, 0);
            largest = pl_larger(fabs(x), largest);
            if (!isfinite(x) && i < lowest)
                lowest = i;
        }
    }
    pl_raise_double(&s->largest, largest);
    pl_lower_to(&s->lowest, lowest);
}

/** Put the missing mids of the cell in lane 0 in the middle, where bends find them. */
static void fill_missing(const pl_cell_type *type, int dim, pl_watch_block *b) {
    double(*const x)[3][PL_JACOBIAN_LANES] = b->jacobian.x;
    for (int i = type->shape->n_corners; i < type->n_nodes; i++)
        for (int d = 0; d < dim && b->node[0][i] < 0; d++)
            x[i][d][0] = 0.5 * (x[type->between[i][0]][d][0] + x[type->between[i][1]][d][0]);
}

/** Whether a cell of order 2 is curved with its nodes as they were given. */
static int is_curved_as_given(const pl_watch *w, const pl_cell_type *type, int64_t cell) {
    const int dim = w->plan->dim;
    pl_watch_block b;
    pl_bends bends;
    b.n = 0;
    memset(b.jacobian.x, 0, sizeof b.jacobian.x);
    pl_watch_take(w, w->rule[type->type], cell, 2, &b);
    fill_missing(type, dim, &b);
    if (dim == 3)
        pl_find_bends(&b.rule->jacobian, &b.jacobian, &bends, 3);
    else
        pl_find_bends(&b.rule->jacobian, &b.jacobian, &bends, 2);
    const double rounding = ldexp(w->rounding, -b.exponent[0]);
    if (!pl_is_bent(&bends, 0, 0) || pl_is_bent(&bends, 0, rounding))
        return pl_is_bent(&bends, 0, 0);
    pl_watch_evaluate(w, &b);
    return pl_is_curved(&bends, &b.jacobian, 0, rounding, pl_watch_is_lane_valid(&b, 0));
}

/** Whether a cell is curved. Most have no node that may be off. */
static int is_cell_curved(const search *s, int64_t cell) {
    const planish_plan *plan = s->watch->plan;
    const pl_cell_type *type = pl_plan_cell_type(plan, cell);
    const int32_t *node = plan->cells.node + plan->cells.offset[pl_plan_given_cell(plan, cell)];
    int may_be = 0;
    for (int i = type->shape->n_corners; i < type->n_nodes && type->order > 1; i++)
        may_be |= node[i] >= 0 && s->is_off[node[i]];
    return may_be && is_curved_as_given(s->watch, type, cell);
}

/** The type whose rule decides a cell during sweeps; 0: its corners do. */
static int deciding_type(const pl_watch *w, int64_t cell) {
    const pl_cell_type *type = pl_plan_cell_type(w->plan, cell);
    if (w->is_curved && w->is_curved[cell])
        return type->type;
    return type->shape->dim == 3 && type->shape->n_corners >= 6 ? pl_linear_type(type->shape)->type
                                                                : 0;
}

static void note_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    pl_watch *w = s->watch;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        const pl_cell_type *type = pl_plan_cell_type(w->plan, cell);
        if (type->order > 1)
            pl_mids_note(&w->mids, cell, type, s->fills);
    }
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        const int is_found = is_cell_curved(s, cell);
        s->watch->is_curved[cell] = (uint8_t)is_found;
        n += is_found;
    }
    __atomic_fetch_add(&s->n_curved, n, __ATOMIC_RELAXED);
}

/** Find mids and curved cells, all at once. */
static int find_curved(search *s, const double *given, const double *start, planish_error *error) {
    pl_watch *w = s->watch;
    const int threads = w->plan->threads;
    const int64_t n_cells = pl_view_cells(&w->plan->work);
    int status = pl_mids_create(w->plan, s->options, given, start, &w->mids, error);
    if (status)
        return status;
    s->is_off = pl_alloc(w->mids.start.n, sizeof *s->is_off);
    w->is_curved = pl_alloc(n_cells, sizeof *w->is_curved);
    if (!s->is_off || !w->is_curved)
        return pl_fail_memory(error, "the curved elements");
    pl_parallel_for(threads, n_cells, CHUNK, note_chunk, s);
    status = pl_mids_number(&w->mids, error);
    if (status)
        return status;
    s->fills = w->mids.n_more > 0;
    if (s->fills)
        pl_parallel_for(threads, n_cells, CHUNK, note_chunk, s);
    pl_parallel_for(threads, w->mids.start.n, CHUNK_NODES, mids_chunk, s);
    if (s->lowest < INT64_MAX)
        return pl_fail_at(error, PLANISH_ERROR_MESH, -1, s->lowest,
                          "node %" PRId64 " has a coordinate that is not a finite number",
                          s->lowest);
    pl_parallel_for(threads, n_cells, CHUNK, search_chunk, s);
    return PLANISH_OK;
}

static void type_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    uint8_t has[PL_WATCH_TYPES] = {0};
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++)
        has[pl_plan_cell_type(s->watch->plan, cell)->type] = 1;
    for (int t = 0; t < PL_WATCH_TYPES; t++)
        if (has[t])
            pl_set_flag(&s->has_type[t], 1);
}

static int make_rule(pl_watch *w, const pl_cell_type *type) {
    pl_watch_rule **rule = &w->rule[type->type];
    if (!*rule)
        *rule = pl_watch_rule_make(type);
    return *rule != NULL;
}

/** Make the rules of the types that need them, and find whether there are any of order 2. */
static int make_rules(search *s, int *order_2) {
    int made = 1;
    *order_2 = 0;
    for (int t = 0; t < PL_WATCH_TYPES; t++) {
        const pl_cell_type *type = s->has_type[t] ? pl_cell_type_of(t) : NULL;
        if (!type)
            continue;
        if (type->order > 1 || (type->shape->dim == 3 && type->shape->n_corners >= 6))
            made = made && make_rule(s->watch, type);
        if (type->order > 1 && type->shape->n_simplices > 1)
            made = made && make_rule(s->watch, pl_linear_type(type->shape));
        *order_2 |= type->order > 1;
    }
    return made;
}

/** The floor of a cell's coefficients: by its own minimum volume, or that of all. */
static double floor_of(const search *s, int64_t cell, int type) {
    const planish_plan *plan = s->watch->plan;
    const int64_t first = pl_first_of_cell(&plan->work, cell);
    const double own = plan->work.min_volume ? plan->work.min_volume[first] : 0;
    const double volume = own > 0 ? own : s->min_volume;
    if (!type)
        return 0;
    const pl_jacobian_rule *rule = &s->watch->rule[type]->jacobian;
    double scale = 1; /* as in is_plain */
    for (int t = 0; t < rule->n_control_terms && rule->control_term[t].to == 0; t++)
        scale = 0.5 * rule->control_term[t].weight;
    return volume / plan->form[pl_form_code(plan->work.corner[first], 0, 0)].volume * rule->common *
           scale * scale * (plan->dim == 3 ? scale : 1);
}

static void cell_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    pl_watch *w = s->watch;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = pl_watch_cell(w, i);
        const int type = deciding_type(w, cell);
        w->type[i] = (uint8_t)type;
        if (type)
            pl_set_flag(&w->decides, 1);
        w->room[i] = type ? 0 : INFINITY;
        w->state[i] = PL_WATCH_VALID;
        w->n_refused_of[i] = 0;
        if (w->quality)
            w->quality[i] = INFINITY;
        if (w->floor)
            w->floor[i] = floor_of(s, cell, type);
        if (!w->node)
            continue;
        int32_t corner[PL_CELL_CORNERS];
        const int n = pl_plan_cell_corners(w->plan, cell, corner);
        const int turned = pl_watch_sign(w, cell) < 0 ? n / 2 : 0;
        const int is_turned = n == 8 || n == 6; /* top first: a reflection */
        for (int j = 0; j < PL_CELL_CORNERS; j++)
            w->node[i][j] = j < n ? w->plan->inner[corner[is_turned ? (j + turned) % n : j]] : -1;
    }
}

/** The movable nodes of a watched cell, by inner numbers, and those that they follow. */
static int nodes_of(const void *context, int64_t i, int32_t node[PL_CELL_NODES]) {
    const search *s = context;
    const pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    int32_t corner[PL_CELL_CORNERS];
    const int n = pl_plan_cell_corners(plan, pl_watch_cell(w, i), corner);
    for (int j = 0; j < n; j++) {
        node[j] = plan->work.mobility[corner[j]] != 0 ? plan->inner[corner[j]] : -1;
        node[n + j] = s->leader && node[j] >= 0 ? s->leader[node[j]] : -1;
    }
    return 2 * n;
}

/** Follower k, as of its leader: images are none. */
static int leader_of(const void *context, int64_t k, int32_t node[PL_CELL_NODES]) {
    const planish_plan *plan = context;
    const pl_follower *f = &plan->sliding.follower[k];
    node[0] = f->node < plan->work.n_nodes ? f->of : -1;
    return 1;
}

/** Find who follows whom. */
static int find_followers(search *s) {
    const planish_plan *plan = s->watch->plan;
    const pl_visits *sliding = &plan->sliding;
    if (sliding->n_followers == 0)
        return 1;
    s->leader = pl_alloc(plan->work.n_nodes, sizeof *s->leader);
    if (!s->leader || !pl_items_of_nodes(plan->work.n_nodes, sliding->n_followers, leader_of, plan,
                                         plan->threads, &s->watch->follower))
        return 0;
    memset(s->leader, -1, (size_t)plan->work.n_nodes * sizeof *s->leader);
    for (int64_t k = 0; k < sliding->n_followers; k++)
        if (sliding->follower[k].node < plan->work.n_nodes)
            s->leader[sliding->follower[k].node] = sliding->follower[k].of;
    return 1;
}

/** Whether a watched cell comes before another one at a node. */
static int is_before(const pl_watch *w, int32_t cell, int32_t other) {
    const int type = w->type[cell] ? w->type[cell] : PL_WATCH_TYPES;
    const int of_other = w->type[other] ? w->type[other] : PL_WATCH_TYPES;
    return type < of_other || (type == of_other && cell < other);
}

/** Sort the cells of each node by type, then number; those without a type come last. */
static void sort_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    pl_watch *w = s->watch;
    (void)thread;
    for (int64_t node = begin; node < end; node++)
        for (int64_t k = w->begin[node] + 1; k < w->begin[node + 1]; k++) {
            const int32_t cell = w->watched[k];
            int64_t at = k;
            for (; at > w->begin[node]; at--) {
                const int32_t other = w->watched[at - 1];
                if (is_before(w, other, cell))
                    break;
                w->watched[at] = other;
            }
            w->watched[at] = cell;
        }
}

/** List the watched cells of each node. */
static int make_lists(search *s) {
    pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    pl_incidence cells;
    if (!find_followers(s) ||
        !pl_items_of_nodes(plan->work.n_nodes, w->n, nodes_of, s, plan->threads, &cells))
        return 0;
    w->begin = cells.offset;
    w->watched = cells.element;
    pl_parallel_for(plan->threads, plan->work.n_nodes, CHUNK_NODES, sort_chunk, s);
    return 1;
}

/** The lowest inner number of the nodes of a cell. */
static int32_t lowest_node(const planish_plan *plan, int64_t cell) {
    int32_t corner[PL_CELL_CORNERS], lowest = INT32_MAX;
    const int n = pl_plan_cell_corners(plan, cell, corner);
    for (int j = 0; j < n; j++)
        lowest = plan->inner[corner[j]] < lowest ? plan->inner[corner[j]] : lowest;
    return lowest;
}

/** List all cells of the plan along its curve, so that what visits one after the other need lies
 *  side by side. */
static int order_cells(pl_watch *w) {
    const planish_plan *plan = w->plan;
    int64_t *place = pl_alloc_zero(plan->work.n_nodes + 1, sizeof *place);
    if (!place)
        return 0;
    for (int64_t cell = 0; cell < w->n; cell++)
        place[lowest_node(plan, cell) + 1]++;
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        place[i + 1] += place[i];
    for (int64_t cell = 0; cell < w->n; cell++)
        w->cell[place[lowest_node(plan, cell)]++] = (int32_t)cell;
    pl_free(place);
    return 1;
}

/** Make room for cells that wait: not if some have floors, or if nodes follow others, or move elsewhere. */
static int make_late(pl_watch *w) {
    const planish_plan *plan = w->plan;
    const int64_t interior = plan->interior.stars.n_stars, sliding = plan->sliding.stars.n_stars;
    const int64_t n_followers = plan->interior.n_followers + plan->sliding.n_followers;
    if (!w->node || w->floor || n_followers > 0 || plan->n_images > 0)
        return 1;
    w->late.way = pl_alloc(plan->work.n_nodes + 1, sizeof *w->late.way);
    w->late.record = pl_alloc(interior > sliding ? interior : sliding, sizeof *w->late.record);
    w->late.has_at_once = pl_alloc(plan->work.n_nodes, 1);
    w->late.when = pl_alloc(w->n, 1);
    return w->late.way && w->late.record && w->late.has_at_once && w->late.when;
}

/** Make the watched cells: curved ones, with corners all. */
static int make_cells(search *s) {
    pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    const int64_t n_cells = pl_view_cells(&plan->work);
    int64_t n = 0;
    for (int64_t cell = 0; w->is_curved && cell < n_cells; cell++)
        n += w->is_curved[cell];
    w->n = plan->work.corner ? n_cells : n;
    w->cell = pl_alloc(w->n, sizeof *w->cell);
    w->node = plan->work.corner ? pl_alloc(w->n, sizeof *w->node) : NULL;
    w->type = pl_alloc(w->n, sizeof *w->type);
    w->room = pl_alloc(w->n, sizeof *w->room);
    w->state = pl_alloc(w->n, sizeof *w->state);
    w->n_refused_of = pl_alloc(w->n, sizeof *w->n_refused_of);
    w->quality = w->is_curved ? pl_alloc(w->n, sizeof *w->quality) : NULL;
    const int has_floor = plan->work.corner && (plan->work.min_volume || s->min_volume > 0);
    w->floor = has_floor ? pl_alloc(w->n, sizeof *w->floor) : NULL;
    if ((plan->work.corner && !w->node) || !w->cell || !w->type || !w->room || !w->state ||
        !w->n_refused_of || (w->is_curved && !w->quality) || (has_floor && !w->floor) ||
        !make_late(w))
        return 0;
    n = 0;
    if (plan->work.corner && !order_cells(w))
        return 0;
    for (int64_t cell = 0; !plan->work.corner && cell < n_cells; cell++)
        if (w->is_curved[cell])
            w->cell[n++] = (int32_t)cell;
    pl_parallel_for(plan->threads, w->n, CHUNK, cell_chunk, s);
    return make_lists(s);
}

/** How far a node may stray from where it follows; largest: coordinate of such nodes. */
static double stray_of(const pl_watch *w, const planish_options *options, double largest) {
    for (int64_t i = 0; i < w->plan->work.n_nodes * w->plan->dim; i++)
        largest = fmax(largest, fabs(w->mids.given[i]));
    /* Nodes may go beyond where nodes were, but not far. */
    enum { BEYOND = 4, ROUNDINGS = 8 };
    const double unit = options->precision == PLANISH_PRECISION_DOUBLE ? DBL_EPSILON : FLT_EPSILON;
    return options->precision == PLANISH_PRECISION_ROUNDED ? INFINITY
                                                           : BEYOND * ROUNDINGS * unit * largest;
}

static int create(search *s, const double *given, const double *start, planish_error *error) {
    pl_watch *w = s->watch;
    const planish_plan *plan = w->plan;
    int order_2, status = PLANISH_OK;
    pl_parallel_for(plan->threads, pl_view_cells(&plan->work), CHUNK_NODES, type_chunk, s);
    if (!make_rules(s, &order_2))
        return pl_fail_memory(error, "the elements to be watched");
    if (!order_2 && !plan->work.corner)
        return PLANISH_OK;
    w->mids.given = given;
    if (order_2)
        status = find_curved(s, given, start, error);
    if (status)
        return status;
    w->stray = order_2 ? stray_of(w, s->options, s->largest) : 0;
    w->n_curved = s->n_curved;
    return make_cells(s) ? PLANISH_OK : pl_fail_memory(error, "the elements to be watched");
}

int pl_watch_create(const planish_plan *plan, const planish_options *options, const double *given,
                    const double *start, double min_volume, pl_watch *w, planish_error *error) {
    *w = (pl_watch){.plan = plan,
                    .worst_ar2 = INFINITY,
                    .min_volume = min_volume,
                    .rounding = options->rounding};
    search s = {.watch = w, .options = options, .min_volume = min_volume, .lowest = INT64_MAX};
    if (plan->cells.n == 0)
        return PLANISH_OK;
    const int status = create(&s, given, start, error);
    pl_free(s.is_off);
    pl_free(s.leader);
    return status;
}

static void free_cells(pl_watch *w) {
    pl_free(w->cell);
    pl_free(w->type);
    pl_free(w->node);
    pl_free(w->room);
    pl_free(w->floor);
    pl_free(w->state);
    pl_free(w->n_refused_of);
    pl_free(w->quality);
    pl_free(w->begin);
    pl_free(w->watched);
    pl_incidence_destroy(&w->follower);
    pl_free(w->late.way);
    pl_free(w->late.record);
    pl_free(w->late.has_at_once);
    pl_free(w->late.when);
    w->late = (pl_watch_late){.is_on = 0};
    w->cell = w->watched = NULL;
    w->node = NULL;
    w->type = w->state = w->n_refused_of = NULL;
    w->room = NULL;
    w->floor = NULL;
    w->quality = NULL;
    w->begin = NULL;
    w->n = 0;
}

int64_t pl_cell_with(const planish_plan *plan, int64_t element) {
    int64_t begin = 0, end = pl_view_cells(&plan->work);
    while (plan->work.corner && end - begin > 1) {
        const int64_t middle = begin + (end - begin) / 2;
        *(pl_first_of_cell(&plan->work, middle) <= element ? &begin : &end) = middle;
    }
    return plan->work.corner ? begin : element;
}

int pl_watch_add(pl_watch *w, int64_t n, const int32_t *element, planish_error *error) {
    search s = {.watch = w, .min_volume = w->min_volume};
    int64_t n_new = 0;
    for (int64_t i = 0; i < n; i++) {
        uint8_t *is_curved = &w->is_curved[pl_cell_with(w->plan, element[i])];
        n_new += !*is_curved;
        *is_curved = 1;
    }
    if (n_new == 0)
        return PLANISH_OK;
    free_cells(w);
    const int is_made = make_cells(&s);
    pl_free(s.leader);
    return is_made ? PLANISH_OK : pl_fail_memory(error, "the elements to be watched");
}

void pl_watch_destroy(pl_watch *w) {
    if (w->mids.end)
        pl_mids_destroy(&w->mids);
    for (int t = 0; t < PL_WATCH_TYPES; t++)
        pl_free(w->rule[t]);
    pl_free(w->is_curved);
    pl_free(w->has_large);
    free_cells(w);
    *w = (pl_watch){.n = 0};
}
