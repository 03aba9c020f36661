/* tangle: find what is tangled, what of that cannot be helped, how large elements should be, and
 * the patch of nodes around what is tangled. */
#include "improve/untangle/proofs.h"
#include "improve/untangle/tangle.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/cube_root.h"
#include "geometry/simplex.h"
#include "improve/patch.h"

#include <math.h>
#include <string.h>

/* ---- elements ------------------------------------------------------------------------------ */

/** The elements found that are tangled; of all processes. */
static void count_tangled(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const uint8_t *is_counted = plan->work.is_counted;
    t->n_tangled = 0;
    for (int64_t i = 0; i < plan->work.n_elements; i++)
        t->n_tangled += t->state[i] == PL_TANGLED && (!is_counted || is_counted[i]);
    pl_parts_add(&t->n_tangled, 1);
}

void pl_tangle_find(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    pl_objective_problem problem = pl_run_objective_problem(t->run);
    problem.min_volume = t->guard.min_volume;
    if (!t->guard.link_min_volume)
        problem.mesh.min_volume = NULL;
    pl_find_tangled(&problem, t->state);
    for (int64_t i = 0; t->is_hopeless && i < plan->work.n_elements; i++)
        if (t->is_hopeless[i] && t->state[i] == PL_TANGLED)
            t->state[i] = PL_HOPELESS;
    count_tangled(t);
}

/** Elements in parts of the mesh whose boundary encloses nothing are given up, with their nodes. */
static int find_lost(pl_tangle *t, planish_error *error) {
    const planish_plan *plan = t->run->plan;
    int64_t n = 0;
    if (t->guard.min_volume > 0 || t->guard.link_min_volume || pl_part_here())
        return PLANISH_OK;
    t->is_lost = pl_alloc_zero(plan->work.n_nodes, sizeof *t->is_lost);
    if (!t->is_lost)
        return pl_fail_memory(error, "the elements that cannot be helped");
    const int status = pl_mark_enclosed(plan, plan->coordinates, t->state, t->is_lost, &n, error);
    t->run->result->not_enclosed = n;
    return status;
}

/** Elements that cannot be helped are given up (INFEASIBLE is HOPELESS): those without a free node,
 * and as many of those that contradict each other as must be. */
static int find_hopeless(pl_tangle *t, planish_error *error) {
    const planish_plan *plan = t->run->plan;
    pl_infeasible found = {0, 0};
    pl_limit limit = pl_run_limit(t->run);
    uint8_t *part = NULL;
    int status = find_lost(t, error);
    if (!status)
        status = pl_mark_infeasible(plan, &t->problem, t->state, &limit, &found, &part, error);
    t->stopped = limit.answer;
    if (status || t->stopped || !pl_parts_any(found.n > 0)) {
        pl_free(part);
        return status;
    }
    status = pl_share_hopeless(plan, part, t->state, error);
    t->link_skip = part;
    for (int64_t i = 0; i < plan->interior.stars.link_offset[plan->interior.stars.n_stars]; i++)
        part[i] = part[i] == PL_PROOF_GIVEN_UP;
    t->is_hopeless = pl_alloc(plan->work.n_elements, sizeof *t->is_hopeless);
    if (!status && !t->is_hopeless)
        status = pl_fail_memory(error, "the elements that cannot be helped");
    for (int64_t i = 0; !status && i < plan->work.n_elements; i++)
        t->is_hopeless[i] = t->state[i] == PL_HOPELESS;
    if (!status)
        count_tangled(t);
    return status;
}

/* ---- sizes --------------------------------------------------------------------------------- */

/* Sizes are averaged as numbers that grow nearly like their logarithms, made without libm: exponent
 * and mantissa side by side. Meshes may be graded by orders of magnitude. The exponents are counted
 * from that of the largest size, so that the scale of a mesh changes no bit. */
static double to_level(double size, int of_largest) {
    int exponent;
    double mantissa = frexp(size, &exponent);
    return exponent - of_largest + 2 * mantissa - 2;
}

static double from_level(double level, int of_largest) {
    double whole = floor(level);
    return ldexp(0.5 * (level - whole) + 0.5, (int)whole + 1 + of_largest);
}

/** measure^(1/dim), with the same bits at every scale. */
static double size_of(double measure, int dim) {
    int exponent, third;
    if (dim == 2)
        return sqrt(measure);
    double mantissa = frexp(measure, &exponent);
    third = (exponent - ((exponent % 3 + 3) % 3)) / 3;
    return ldexp(pl_cube_root(ldexp(mantissa, exponent - 3 * third)), third);
}

/** The work on sizes; arrays over nodes, by inner numbers. Of ghosts there is what their processes
 *  find. */
typedef struct sizing {
    const planish_plan *plan;
    const uint8_t *is_ghost; /* NULL: there are none */
    double *sum;      /* of the measures (times dim!) of the node's elements; then its level */
    double *absolute; /* of their absolute values; then of levels around */
    int32_t *count;   /* elements of the node; then 1, or 0: nothing is known of it */
    int32_t *around;  /* levels in absolute */
    int of_largest;   /* exponent of the largest size */
    double scale;     /* of the lengths in here */
} sizing;

static void inner_nodes(const planish_plan *plan, int64_t element, int32_t *node) {
    for (int j = 0; j <= plan->dim; j++)
        node[j] = plan->inner[plan->work.elements[element * (plan->dim + 1) + j]];
}

/** D of an element in the scale of sizes, positive in the mesh's orientation. */
static double measure_of(const sizing *s, int64_t element, const int32_t *node) {
    const planish_plan *plan = s->plan;
    const int dim = plan->dim;
    const double *x0 = plan->coordinates + (int64_t)node[0] * dim;
    double e[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = (plan->coordinates[(int64_t)node[j + 1] * dim + d] - x0[d]) * s->scale;
    const double D = pl_determinant_of_edges(dim, (const double(*)[3])e);
    return plan->work.sign ? D * plan->work.sign[element] : D;
}

static void add_measures(const sizing *s) {
    const planish_plan *plan = s->plan;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        int32_t node[4];
        inner_nodes(plan, i, node);
        const double D = measure_of(s, i, node);
        for (int j = 0; j <= plan->dim; j++) {
            s->sum[node[j]] += D;
            s->absolute[node[j]] += fabs(D);
            s->count[node[j]]++;
        }
    }
}

/* The measures around a node tell its size where their sum is more than this part of the sum of
 * their absolute values, and not next to nothing. */
#define TELLING       0.1
#define LEAST_MEASURE 0x1p-1000

/** Sizes at the nodes whose elements tell them. */
static void find_sizes(const sizing *s) {
    const int dim = s->plan->dim;
    const double of_regular = dim == 3 ? 1.4142135623730951 : 1.1547005383792515; /* edge 1 */
    for (int64_t i = 0; i < s->plan->work.n_nodes; i++) {
        const double measure = s->count[i] > 0 ? s->sum[i] / s->count[i] * of_regular : 0;
        const int tells = measure > LEAST_MEASURE && s->sum[i] > TELLING * s->absolute[i];
        s->sum[i] = tells ? size_of(measure, dim) : 0;
    }
    pl_ghosts_update(s->plan, s->sum, sizeof *s->sum);
}

static int is_own(const sizing *s, int64_t node) {
    return !s->is_ghost || !s->is_ghost[node];
}

/** Sizes become levels; returns of how many nodes nothing is known. */
static int64_t find_levels(sizing *s) {
    double largest = 0;
    int64_t unknown = 0;
    for (int64_t i = 0; i < s->plan->work.n_nodes; i++)
        largest = fmax(largest, s->sum[i]);
    pl_parts_largest(&largest, 1);
    frexp(largest, &s->of_largest);
    for (int64_t i = 0; i < s->plan->work.n_nodes; i++) {
        unknown += s->count[i] > 0 && !(s->sum[i] > 0) && is_own(s, i);
        s->count[i] = s->sum[i] > 0;
        s->sum[i] = s->sum[i] > 0 ? to_level(s->sum[i], s->of_largest) : 0;
    }
    pl_parts_add(&unknown, 1);
    return unknown;
}

/** Nodes of which nothing is known take the mean level of those of their elements that are known,
 *  one ring of them at a time; returns how many this one had. */
static int64_t spread_levels(const sizing *s) {
    const planish_plan *plan = s->plan;
    int64_t grown = 0;
    memset(s->absolute, 0, (size_t)plan->work.n_nodes * sizeof *s->absolute);
    memset(s->around, 0, (size_t)plan->work.n_nodes * sizeof *s->around);
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        int32_t node[4];
        inner_nodes(plan, i, node);
        for (int j = 0; j <= plan->dim; j++)
            for (int k = 0; s->count[node[j]] == 0 && k <= plan->dim; k++) {
                s->absolute[node[j]] += s->count[node[k]] > 0 ? s->sum[node[k]] : 0;
                s->around[node[j]] += s->count[node[k]] > 0;
            }
    }
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        if (s->around[i] > 0 && is_own(s, i)) {
            s->sum[i] = s->absolute[i] / s->around[i];
            s->count[i] = 1;
            grown++;
        }
    pl_ghosts_update(plan, s->sum, sizeof *s->sum);
    pl_ghosts_update(plan, s->count, sizeof *s->count);
    pl_parts_add(&grown, 1);
    return grown;
}

/** The mean of all for those that are too far from known ones. */
static void fill_levels(const sizing *s) {
    pl_sum sum = {.n_added = 0};
    int64_t n = 0;
    for (int64_t i = 0; i < s->plan->work.n_nodes; i++)
        if (s->count[i] > 0 && is_own(s, i)) {
            pl_sum_add(&sum, s->sum[i]);
            n++;
        }
    pl_parts_add_sums(&sum, 1);
    pl_parts_add(&n, 1);
    const double mean = n > 0 ? pl_sum_value(&sum) / (double)n : 0;
    for (int64_t i = 0; n > 0 && i < s->plan->work.n_nodes; i++)
        s->sum[i] = s->count[i] > 0 ? s->sum[i] : mean;
}

/* Each ring costs a look at all elements. */
enum { MOST_SPREADS = 64 };

void pl_tangle_find_sizes(pl_tangle *t) {
    const int64_t n = t->run->plan->work.n_nodes;
    sizing s = {.plan = t->run->plan,
                .is_ghost = t->is_ghost,
                .scale = t->scale,
                .sum = pl_alloc_zero(n, sizeof *s.sum),
                .absolute = pl_alloc_zero(n, sizeof *s.absolute),
                .count = pl_alloc_zero(n, sizeof *s.count),
                .around = pl_alloc(n, sizeof *s.around)};
    if (s.sum && s.absolute && s.count && s.around) {
        add_measures(&s);
        find_sizes(&s);
        int64_t left = find_levels(&s), grown = 1;
        for (int i = 0; i < MOST_SPREADS && left > 0 && grown > 0; i++, left -= grown)
            grown = spread_levels(&s);
        if (left > 0)
            fill_levels(&s);
        for (int64_t i = 0; i < n; i++)
            t->size[i] = from_level(s.sum[i], s.of_largest) / t->scale;
    }
    pl_free(s.sum);
    pl_free(s.absolute);
    pl_free(s.count);
    pl_free(s.around);
}

/* ---- the patch ----------------------------------------------------------------------------- */

static void mark_tangled(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    memset(t->in_patch, 0, (size_t)plan->work.n_nodes);
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        if (t->state[i] != PL_TANGLED)
            continue;
        int32_t node[4];
        inner_nodes(plan, i, node);
        for (int j = 0; j <= plan->dim; j++)
            t->in_patch[node[j]] = 1;
    }
    pl_ghosts_update(plan, t->in_patch, 1);
}

static void note_ghosts(pl_tangle *t) {
    for (int64_t i = 0; i < t->n_ghosts; i++)
        t->was_in_patch[i] = t->in_patch[t->ghost[i]];
}

/** Mark the free neighbours of what is marked, and queue their stars. Returns how many they are. */
static int64_t mark_first_ring(pl_tangle *t) {
    const pl_stars *stars = &t->run->plan->interior.stars;
    const int32_t *centre = t->run->plan->interior.centre;
    int64_t n = 0;
    for (int64_t s = 0; s < stars->n_stars; s++) {
        int beside = 0;
        for (int64_t i = stars->ring_offset[s];
             !t->in_patch[centre[s]] && !beside && i < stars->ring_offset[s + 1]; i++)
            beside = t->in_patch[stars->ring[i]];
        if (beside)
            t->queue[n++] = (int32_t)s;
    }
    note_ghosts(t);
    for (int64_t i = 0; i < n; i++)
        t->in_patch[centre[t->queue[i]]] = 1;
    pl_ghosts_update(t->run->plan, t->in_patch, 1);
    return n;
}

/** Mark a free node, and queue its star, unless that has been done. */
static void mark_node(pl_tangle *t, int32_t node, int64_t *n) {
    if (t->in_patch[node] || t->star_of[node] < 0)
        return;
    t->in_patch[node] = 1;
    t->queue[(*n)++] = t->star_of[node];
}

/** Mark the neighbours of ghosts that the last ring has marked in their processes. */
static void mark_around_ghosts(pl_tangle *t, int64_t *n) {
    const pl_ghosts *g = &t->run->plan->ghosts;
    for (int64_t i = 0; i < t->n_ghosts; i++) {
        const int32_t node = t->ghost_node[i];
        if (!t->in_patch[t->ghost[i]] || t->was_in_patch[i])
            continue;
        for (int64_t k = g->offset[node]; k < g->offset[node + 1]; k++)
            mark_node(t, g->neighbour[k], n);
    }
}

/** The rings after the first, breadth first: the stars queue[0 .. n-1] are the first ring. */
static void mark_rings(pl_tangle *t, int64_t n, int rings) {
    const pl_stars *stars = &t->run->plan->interior.stars;
    for (int64_t begin = 0, end = n; rings > 0 && pl_parts_any(begin < end); rings--) {
        for (int64_t k = begin; k < end; k++)
            for (int64_t i = stars->ring_offset[t->queue[k]];
                 i < stars->ring_offset[t->queue[k] + 1]; i++)
                mark_node(t, stars->ring[i], &n);
        mark_around_ghosts(t, &n);
        begin = end;
        end = n;
        note_ghosts(t);
        pl_ghosts_update(t->run->plan, t->in_patch, 1);
    }
}

void pl_tangle_mark(pl_tangle *t, int rings) {
    const planish_plan *plan = t->run->plan;
    mark_tangled(t);
    if (rings > 0)
        mark_rings(t, mark_first_ring(t), rings - 1);
    t->n_patch = 0;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t node = plan->inner[i];
        t->in_patch[node] = t->in_patch[node] && plan->work.mobility[i] == PL_INTERIOR &&
                            !pl_star_is_held(&t->guard, node, plan->dim) &&
                            !(t->is_lost && t->is_lost[node]);
        t->n_patch += t->in_patch[node] && !(t->is_ghost && t->is_ghost[node]);
    }
    pl_parts_add(&t->n_patch, 1);
}

/* ---- energy -------------------------------------------------------------------------------- */

static void add(pl_star_energy *energy, pl_star_energy *part) {
    pl_sum_share(&energy->sum, &part->sum);
    energy->least = fmin(energy->least, part->least);
    energy->tangled += part->tangled;
}

void pl_tangle_add(pl_tangle *t, int thread, pl_star_energy *found) {
    add(&t->of_thread[thread], found);
}

static const pl_star_energy NO_ENERGY = {.least = INFINITY};

void pl_tangle_total(pl_tangle *t, pl_chunk_fn *add_chunk, void *context) {
    const planish_plan *plan = t->run->plan;
    for (int i = 0; i < plan->threads; i++)
        t->of_thread[i] = NO_ENERGY;
    pl_parallel_for(plan->threads, plan->interior.stars.n_stars, PL_TANGLE_CHUNK, add_chunk,
                    context);
    t->energy = NO_ENERGY;
    for (int i = 0; i < plan->threads; i++)
        add(&t->energy, &t->of_thread[i]);
    pl_parts_add_sums(&t->energy.sum, 1);
    pl_parts_smallest(&t->energy.least, 1);
    pl_parts_add(&t->energy.tangled, 1);
}

double pl_tangle_energy(const pl_tangle *t) {
    return pl_sum_value(&t->energy.sum);
}

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    pl_tangle *t = context;
    const planish_plan *plan = t->run->plan;
    pl_star_energy found = plan->kernel->guarded->energy[plan->dim - 2](
        &t->problem, begin, end, plan->scratch + plan->scratch_stride * thread, NULL);
    pl_tangle_add(t, thread, &found);
}

void pl_tangle_measure(pl_tangle *t) {
    pl_tangle_total(t, measure_chunk, t);
}

/* ---- all of it ----------------------------------------------------------------------------- */

/** The ghosts that may be in the patch. */
static int list_ghosts(pl_tangle *t) {
    const planish_plan *plan = t->run->plan;
    const planish_part *part = plan->context->part;
    if (!part)
        return 1;
    const int64_t n = pl_parts_ghosts(plan->work.n_nodes);
    t->is_ghost = pl_alloc_zero(plan->work.n_nodes, sizeof *t->is_ghost);
    t->ghost = pl_alloc(n, sizeof *t->ghost);
    t->ghost_node = pl_alloc(n, sizeof *t->ghost_node);
    t->was_in_patch = pl_alloc_zero(n, sizeof *t->was_in_patch);
    if (!t->is_ghost || !t->ghost || !t->ghost_node || !t->was_in_patch)
        return 0;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        if (part->node_role[i] != PLANISH_GHOST)
            continue;
        t->is_ghost[plan->inner[i]] = 1;
        if (plan->work.mobility[i] != PL_INTERIOR)
            continue;
        t->ghost[t->n_ghosts] = plan->inner[i];
        t->ghost_node[t->n_ghosts++] = (int32_t)i;
    }
    return 1;
}

int pl_tangle_create(pl_run *r, int floors, pl_tangle *t, planish_error *error) {
    const planish_plan *plan = r->plan;
    *t = (pl_tangle){.run = r, .problem = r->problem, .guard = r->guard.star};
    t->guard.ratio_weight = 1;
    if (!floors) {
        t->guard.min_volume = 0;
        t->guard.link_min_volume = NULL;
    }
    t->problem.guard = &t->guard;
    t->problem.limits = pl_star_no_limits();
    t->problem.calm = 0;
    t->state = pl_alloc(plan->work.n_elements, sizeof *t->state);
    if (!t->state)
        return pl_fail_memory(error, "the tangled elements");
    pl_tangle_find(t);
    int status = t->n_tangled > 0 ? find_hopeless(t, error) : PLANISH_OK;
    if (status || t->n_tangled == 0 || t->stopped)
        return status;
    t->in_patch = pl_alloc_zero(plan->work.n_nodes, sizeof *t->in_patch);
    t->size = pl_alloc_zero(plan->work.n_nodes, sizeof *t->size);
    t->best = pl_alloc(plan->work.n_nodes * plan->dim, sizeof *t->best);
    t->star_of = pl_alloc(plan->work.n_nodes, sizeof *t->star_of);
    t->queue = pl_alloc(plan->interior.stars.n_stars, sizeof *t->queue);
    t->of_thread = pl_alloc(plan->threads, sizeof *t->of_thread);
    if (!t->in_patch || !t->size || !t->best || !t->star_of || !t->queue || !t->of_thread ||
        !list_ghosts(t))
        return pl_fail_memory(error, "untangling");
    pl_plan_number_stars(t->run->plan, t->star_of);
    t->scale = pl_box_of_fixed(plan).scale;
    t->asked = (pl_star_untangling){t->in_patch, t->size, t->link_skip, 1};
    return PLANISH_OK;
}

void pl_tangle_destroy(pl_tangle *t) {
    pl_free(t->state);
    pl_free(t->is_hopeless);
    pl_free(t->is_lost);
    pl_free(t->link_skip);
    pl_free(t->in_patch);
    pl_free(t->size);
    pl_free(t->best);
    pl_free(t->star_of);
    pl_free(t->is_ghost);
    pl_free(t->ghost);
    pl_free(t->ghost_node);
    pl_free(t->was_in_patch);
    pl_free(t->queue);
    pl_free(t->of_thread);
    *t = (pl_tangle){0};
}
