/* select: the nodes of bad elements, and rings of elements around them: all that --only-worse-than
 * is about. One pass over the mesh finds them; everything behind it then costs by what is bad. */
#include "topology/walk.h"
#include "plan/draft.h"

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

static const char WHAT[] = "the elements that are bad";

/** Nodes being chosen. Levels are stored atomically: several threads may store the same. */
typedef struct selection {
    const planish_mesh *mesh;
    const planish_options *options;
    const pl_view *corners; /* has those of the mesh, if its elements are corners */
    int threads;
    uint8_t *state;   /* [m] */
    int least;        /* state of elements whose nodes are wanted */
    uint8_t level;    /* nodes up to it are chosen; those that follow get the next */
    uint8_t *of_node; /* [n] level, 0: not chosen */
    int any;          /* an element was found */
} selection;

/** Choose the nodes of bad elements: they get level 1. */
static void choose_bad(void *context, int64_t begin, int64_t end, int thread) {
    selection *w = context;
    const int corners = w->mesh->dim + 1;
    int any = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        any |= w->state[i] >= w->least;
        for (int j = 0; w->state[i] >= w->least && j < corners; j++)
            __atomic_store_n(&w->of_node[w->mesh->elements[i * corners + j]], 1, __ATOMIC_RELAXED);
    }
    if (any)
        __atomic_store_n(&w->any, 1, __ATOMIC_RELAXED);
}

/** Range of the elements of cell i: the corners that it has, or element i itself. */
static void find_range(const selection *w, int64_t i, int64_t *begin, int64_t *end) {
    const int32_t *cell_begin = w->corners->cell_begin;
    *begin = cell_begin ? cell_begin[i] : i;
    *end = cell_begin ? cell_begin[i + 1] : i + 1;
}

/** Choose one more ring: the nodes of elements, or cells, that have a chosen one. */
static void choose_ring(void *context, int64_t begin, int64_t end, int thread) {
    const selection *w = context;
    const int corners = w->mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int64_t first, last;
        find_range(w, i, &first, &last);
        const int32_t *node = w->mesh->elements + first * corners;
        const int64_t n = (last - first) * corners;
        int has_chosen = 0;
        for (int64_t j = 0; j < n; j++) {
            const uint8_t level = __atomic_load_n(&w->of_node[node[j]], __ATOMIC_RELAXED);
            has_chosen |= level > 0 && level <= w->level;
        }
        for (int64_t j = 0; has_chosen && j < n; j++)
            if (__atomic_load_n(&w->of_node[node[j]], __ATOMIC_RELAXED) == 0)
                __atomic_store_n(&w->of_node[node[j]], (uint8_t)(w->level + 1), __ATOMIC_RELAXED);
    }
}

/** Choose so many rings around the nodes of level 1. Not all elements of a ghost are here: its
 *  process tells its level. */
static void choose_rings(selection *w, int rings) {
    pl_parts_update(NULL, w->of_node, sizeof *w->of_node);
    for (int i = 1; i <= rings; i++) {
        w->level = (uint8_t)i;
        pl_parallel_for(w->threads, w->corners->corner ? w->corners->n_cells : w->mesh->n_elements,
                        CHUNK, choose_ring, w);
        pl_parts_update(NULL, w->of_node, sizeof *w->of_node);
    }
}

/** Choose the nodes of elements of at least that state, and rings of elements around them. Return
 *  whether there are such elements. */
static int choose_around_bad(selection *w, int least, int rings) {
    w->least = least;
    w->any = 0;
    pl_parallel_for(w->threads, w->mesh->n_elements, CHUNK, choose_bad, w);
    w->any = pl_parts_any(w->any);
    if (w->any)
        choose_rings(w, rings);
    return w->any;
}

/** Find the states of the elements: bad are also those below their minimum volume. */
static int find_states(const selection *w, const int8_t *sign, planish_error *error) {
    const planish_mesh *mesh = w->mesh;
    const planish_options *options = w->options;
    const pl_view view = {.dim = mesh->dim,
                          .corner = w->corners->corner,
                          .n_cells = w->corners->n_cells,
                          .cell_begin = w->corners->cell_begin,
                          .target = w->corners->target,
                          .metric = w->corners->metric,
                          .n_nodes = mesh->n_nodes,
                          .n_elements = mesh->n_elements,
                          .elements = mesh->elements,
                          .sign = sign,
                          .min_volume = mesh->min_volume,
                          .mobility = w->of_node,
                          .is_counted = mesh->part ? mesh->part->is_counted : NULL};
    pl_objective_problem problem =
        pl_objective_problem_of(&view, mesh->coordinates, options, options->min_volume, w->threads);
    memset(w->of_node, 0, (size_t)mesh->n_nodes);
    pl_find_worse(&view, mesh->coordinates, options->only_worse_than, INFINITY, w->threads,
                  w->state);
    if (!(options->min_volume > 0) && !(options->min_volume_fraction > 0) && !mesh->min_volume)
        return PLANISH_OK;
    uint8_t *below = pl_alloc(mesh->n_elements, sizeof *below);
    if (!below)
        return pl_fail_memory(error, WHAT);
    problem.min_volume = pl_minimum_volume_of(options, &problem);
    pl_find_below(&problem, below);
    for (int64_t i = 0; i < mesh->n_elements; i++)
        if (below[i] != PLANISH_VOLUME_MET && w->state[i] == PL_FINE)
            w->state[i] = PL_WORSE;
    pl_free(below);
    return PLANISH_OK;
}

/** Walk from the bad elements to the subset around them, where the mesh has neighbours and few
 *  elements are bad: *subset is filled then, and the choice. A walk looks at every element of
 *  each node, at some LOOKS times the cost of a look in passing. */
static int walk_from_bad(const selection *w, pl_subset *subset, planish_error *error) {
    enum { LOOKS = 1000 };
    const planish_mesh *mesh = w->mesh;
    const int corners = mesh->dim + 1;
    const int64_t m = mesh->n_elements;
    int64_t n_bad = 0, wide = 1 + 2 * w->options->rings;
    for (int64_t i = 0; i < m; i++)
        n_bad += w->state[i] >= PL_WORSE;
    if (!(mesh->neighbours || mesh->neighbours64) || n_bad == 0 ||
        n_bad > m / (LOOKS * wide * wide * wide))
        return PLANISH_OK;
    int64_t *node = pl_alloc(n_bad * corners, sizeof *node);
    int64_t *element = pl_alloc(n_bad * corners, sizeof *element);
    int status = node && element ? PLANISH_OK : pl_fail_memory(error, WHAT);
    int64_t n = 0;
    for (int64_t i = 0; i < m && !status; i++)
        for (int j = 0; w->state[i] >= PL_WORSE && j < corners; j++) {
            node[n] = mesh->elements[i * corners + j];
            element[n++] = i;
        }
    const pl_seeds seeds = {n, node, element};
    if (!status)
        status = pl_subset_by_walk(mesh, &seeds, w->options->rings, subset, error);
    pl_free(node);
    pl_free(element);
    for (int64_t i = 0; i < subset->n_nodes; i++)
        w->of_node[subset->node[i]] = subset->is_selected[i];
    return status;
}

int pl_draft_select(pl_draft *d, planish_error *error) {
    const int64_t n = d->mesh->n_nodes;
    uint8_t *tangled = NULL;
    if (!d->is_selected)
        d->is_selected = pl_alloc(n, sizeof *d->is_selected);
    if (!d->is_selected)
        return pl_fail_memory(error, "the nodes of bad elements");
    d->plan->is_selective = 1;
    pl_subset_destroy(&d->subset);
    selection w = {.mesh = d->mesh,
                   .options = d->options,
                   .corners = &d->plan->work,
                   .threads = d->plan->threads,
                   .state = pl_alloc(d->mesh->n_elements, sizeof *w.state),
                   .of_node = d->is_selected};
    int status = w.state ? find_states(&w, d->boundary.sign, error) : pl_fail_memory(error, WHAT);
    d->all_positive = !status && !choose_around_bad(&w, PL_INVERTED, UNTANGLING_RINGS);
    if (!status && !d->all_positive) {
        tangled = pl_alloc(n, sizeof *tangled);
        status = tangled ? PLANISH_OK : pl_fail_memory(error, WHAT);
    } else if (!status && d->mesh->n_periodic == 0 && !d->mesh->part) {
        status = walk_from_bad(&w, &d->subset, error);
    }
    /* The nodes of bad elements join those of tangled ones, which are chosen already. */
    if (!status && tangled) {
        memcpy(tangled, d->is_selected, (size_t)n);
        memset(d->is_selected, 0, (size_t)n);
    }
    if (!status && d->subset.n_elements == 0)
        choose_around_bad(&w, PL_WORSE, d->options->rings);
    for (int64_t i = 0; !status && tangled && i < n; i++)
        d->is_selected[i] |= tangled[i];
    pl_free(tangled);
    pl_free(w.state);
    return status;
}

void pl_select_around(const planish_mesh *mesh, const pl_view *corners,
                      const planish_options *options, int threads, uint8_t *is_selected) {
    selection w = {.mesh = mesh, .corners = corners, .threads = threads, .of_node = is_selected};
    for (int64_t i = 0; i < options->n_around; i++)
        is_selected[options->around[i]] = 1;
    choose_rings(&w, options->rings);
}
