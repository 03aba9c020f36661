/* select: the nodes of bad elements, and rings of elements around them: all that --only-worse-than
 * is about. One pass over the mesh finds them; everything behind it then costs by what is bad. */
#include "plan/select.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "quality/measure.h"
#include "quality/objective.h"

#include <math.h>
#include <string.h>

enum {
    CHUNK = 4096,
    UNTANGLING_RINGS = 4 /* around elements that are not positive: they need room */
};

/** The work on all elements. Levels are stored atomically: several threads may store the same. */
typedef struct work {
    const planish_mesh *mesh;
    uint8_t *state;   /* [m] */
    int least;        /* state of elements whose nodes are wanted */
    uint8_t level;    /* nodes up to it are chosen; those that follow get the next */
    uint8_t *of_node; /* [n] level, 0: not chosen */
    int any;          /* an element was found */
} work;

static void choose(const work *w, int32_t node, uint8_t level) {
    __atomic_store_n(&w->of_node[node], level, __ATOMIC_RELAXED);
}

/** The nodes of elements that are bad get level 1. */
static void choose_bad(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    const int corners = w->mesh->dim + 1;
    int any = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (w->state[i] < w->least)
            continue;
        any = 1;
        for (int j = 0; j < corners; j++)
            choose(w, w->mesh->elements[i * corners + j], 1);
    }
    if (any)
        __atomic_store_n(&w->any, 1, __ATOMIC_RELAXED);
}

/** One more ring: the nodes of elements that have a chosen one. */
static void choose_ring(void *context, int64_t begin, int64_t end, int thread) {
    const work *w = context;
    const int corners = w->mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *node = w->mesh->elements + i * corners;
        int has_chosen = 0;
        for (int j = 0; j < corners; j++) {
            const uint8_t level = __atomic_load_n(&w->of_node[node[j]], __ATOMIC_RELAXED);
            has_chosen |= level > 0 && level <= w->level;
        }
        for (int j = 0; has_chosen && j < corners; j++)
            if (__atomic_load_n(&w->of_node[node[j]], __ATOMIC_RELAXED) == 0)
                choose(w, node[j], (uint8_t)(w->level + 1));
    }
}

/** Update the choices of ghosts: not all elements of a ghost are here. */
static void hear_of_ghosts(const work *w) {
    pl_parts_update(NULL, w->of_node, sizeof *w->of_node);
}

/** Layers around the nodes of level 1. */
static void spread_rings(work *w, int threads, int rings) {
    hear_of_ghosts(w);
    for (int i = 1; i <= rings; i++) {
        w->level = (uint8_t)i;
        pl_parallel_for(threads, w->mesh->n_elements, CHUNK, choose_ring, w);
        hear_of_ghosts(w);
    }
}

/** Choose the nodes of elements of at least that state, and rings of elements around them; not 0 if
 * there are such elements. */
static int spread(work *w, int threads, int least, int rings) {
    w->least = least;
    w->any = 0;
    pl_parallel_for(threads, w->mesh->n_elements, CHUNK, choose_bad, w);
    w->any = pl_parts_any(w->any);
    if (w->any)
        spread_rings(w, threads, rings);
    return w->any;
}

/** The mesh with the nodes of mobility [n]. */
static pl_view view_of(const planish_mesh *mesh, const int8_t *sign, const uint8_t *mobility) {
    return (pl_view){.dim = mesh->dim,
                     .n_nodes = mesh->n_nodes,
                     .n_elements = mesh->n_elements,
                     .elements = mesh->elements,
                     .sign = sign,
                     .min_volume = mesh->min_volume,
                     .mobility = mobility,
                     .is_counted = mesh->part ? mesh->part->is_counted : NULL};
}

/** Elements below their minimum volume are bad, too. */
static int add_below(const planish_mesh *mesh, const int8_t *sign, const planish_options *options,
                     const uint8_t *is_selected, int threads, uint8_t *state,
                     planish_error *error) {
    pl_objective_problem problem = {.mesh = view_of(mesh, sign, is_selected),
                                    .coordinates = mesh->coordinates,
                                    .min_volume = options->min_volume,
                                    .threads = threads};
    uint8_t *below = pl_alloc(mesh->n_elements, sizeof *below);
    if (!below)
        return pl_fail_memory(error, "the elements that are bad");
    if (options->min_volume_fraction > 0) {
        pl_objective_sums sums;
        pl_sum_objective(&problem, &sums);
        problem.min_volume = options->min_volume_fraction * fabs(sums.domain);
    }
    pl_find_below(&problem, below);
    for (int64_t i = 0; i < mesh->n_elements; i++)
        if (below[i] != PLANISH_VOLUME_MET && state[i] == PL_FINE)
            state[i] = PL_WORSE;
    pl_free(below);
    return PLANISH_OK;
}

/** Walk from the bad elements to the subset around them, where the mesh has neighbours and few
 *  elements are bad: *subset is filled then, and is_selected. A walk looks at every element of
 *  each node, at some LOOKS times the cost of a look in passing. */
static int walk_from_bad(const work *w, const planish_options *options, uint8_t *is_selected,
                         pl_subset *subset, planish_error *error) {
    enum { LOOKS = 1000 };
    const planish_mesh *mesh = w->mesh;
    const int corners = mesh->dim + 1;
    const int64_t m = mesh->n_elements;
    int64_t n_bad = 0, wide = 1 + 2 * options->rings;
    for (int64_t i = 0; i < m; i++)
        n_bad += w->state[i] >= PL_WORSE;
    if (!(mesh->neighbours || mesh->neighbours64) || n_bad == 0 ||
        n_bad > m / (LOOKS * wide * wide * wide))
        return PLANISH_OK;
    int64_t *node = pl_alloc(n_bad * corners, sizeof *node);
    int64_t *element = pl_alloc(n_bad * corners, sizeof *element);
    int status = node && element ? PLANISH_OK : pl_fail_memory(error, "the elements that are bad");
    int64_t n = 0;
    for (int64_t i = 0; i < m && !status; i++)
        for (int j = 0; w->state[i] >= PL_WORSE && j < corners; j++) {
            node[n] = mesh->elements[i * corners + j];
            element[n++] = i;
        }
    const pl_seeds seeds = {n, node, element};
    if (!status)
        status = pl_subset_by_walk(mesh, &seeds, options->rings, subset, error);
    pl_free(node);
    pl_free(element);
    for (int64_t i = 0; i < subset->n_nodes; i++)
        is_selected[subset->node[i]] = subset->is_selected[i];
    return status;
}

/** Look at the elements: their states, and whether all are positive. */
static int find_states(work *w, const int8_t *sign, const planish_options *options, int threads,
                       int *all_positive, planish_error *error) {
    const planish_mesh *mesh = w->mesh;
    int status = PLANISH_OK;
    memset(w->of_node, 0, (size_t)mesh->n_nodes);
    const pl_view view = view_of(mesh, sign, w->of_node);
    pl_find_worse(&view, mesh->coordinates, options->only_worse_than, INFINITY, threads, w->state);
    if (options->min_volume > 0 || options->min_volume_fraction > 0 || mesh->min_volume)
        status = add_below(mesh, sign, options, w->of_node, threads, w->state, error);
    *all_positive = !status && !spread(w, threads, PL_INVERTED, UNTANGLING_RINGS);
    return status;
}

/** The nodes of bad elements join those of tangled ones, which are chosen already. */
static int add_bad(work *w, const planish_options *options, int threads, planish_error *error) {
    const int64_t n = w->mesh->n_nodes;
    uint8_t *tangled = pl_alloc(n, sizeof *tangled);
    if (!tangled)
        return pl_fail_memory(error, "the elements that are bad");
    memcpy(tangled, w->of_node, (size_t)n);
    memset(w->of_node, 0, (size_t)n);
    spread(w, threads, PL_WORSE, options->rings);
    for (int64_t i = 0; i < n; i++)
        w->of_node[i] |= tangled[i];
    pl_free(tangled);
    return PLANISH_OK;
}

int pl_select(const planish_mesh *mesh, const int8_t *sign, const planish_options *options,
              int threads, uint8_t *is_selected, int *all_positive, pl_subset *subset,
              planish_error *error) {
    uint8_t *state = pl_alloc(mesh->n_elements, sizeof *state);
    work w = {.mesh = mesh, .state = state, .of_node = is_selected};
    if (!state)
        return pl_fail_memory(error, "the elements that are bad");
    int status = find_states(&w, sign, options, threads, all_positive, error);
    if (!status && !*all_positive)
        status = add_bad(&w, options, threads, error);
    else if (!status && mesh->n_periodic == 0 && !mesh->part)
        status = walk_from_bad(&w, options, is_selected, subset, error);
    if (!status && *all_positive && subset->n_elements == 0)
        spread(&w, threads, PL_WORSE, options->rings);
    pl_free(state);
    return status;
}

void pl_select_around(const planish_mesh *mesh, const planish_options *options, int threads,
                      uint8_t *is_selected) {
    work w = {.mesh = mesh, .of_node = is_selected};
    for (int64_t i = 0; i < options->n_around; i++)
        choose(&w, (int32_t)options->around[i], 1);
    spread_rings(&w, threads, options->rings);
}
