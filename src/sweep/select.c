/* select: the nodes of bad elements, and layers around them: all that --only-worse-than is about.
 * One pass over the mesh finds them; everything behind it then costs by what is bad. */
#include "sweep/sweep.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "quality/measure.h"
#include "quality/objective.h"

#include <math.h>
#include <string.h>

enum {
    CHUNK = 4096,
    UNTANGLING_LAYERS = 4 /* around elements that are not positive: they need room */
};

/** The work on all elements. Levels are stored atomically: several threads may store the same. */
typedef struct work {
    const planish_mesh *mesh;
    const uint8_t *state; /* [m] */
    int least;            /* state of elements whose nodes are wanted */
    uint8_t level;        /* nodes up to it are chosen; those that follow get the next */
    uint8_t *of_node;     /* [n] level, 0: not chosen */
    int any;              /* an element was found */
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

/** One more layer: the nodes of elements that have a chosen one. */
static void choose_layer(void *context, int64_t begin, int64_t end, int thread) {
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

/** Choose the nodes of elements of at least that state, and layers around them; not 0 if there are
 *  such elements. */
static int spread(work *w, int threads, int least, int layers) {
    const int64_t m = w->mesh->n_elements;
    w->least = least;
    w->any = 0;
    pl_parallel_for(threads, m, CHUNK, choose_bad, w);
    for (int i = 1; i <= layers && w->any; i++) {
        w->level = (uint8_t)i;
        pl_parallel_for(threads, m, CHUNK, choose_layer, w);
    }
    return w->any;
}

/** Elements below their least volume are bad, too. */
static int add_below(const planish_mesh *mesh, const int8_t *sign, const planish_options *options,
                     const uint8_t *is_selected, int threads, uint8_t *state,
                     planish_error *error) {
    pl_objective_problem problem = {.dim = mesh->dim,
                                    .n_elements = mesh->n_elements,
                                    .elements = mesh->elements,
                                    .sign = sign,
                                    .is_free = is_selected,
                                    .coordinates = mesh->coordinates,
                                    .min_volume = options->min_volume,
                                    .own_min_volume = mesh->min_volume,
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

int pl_select(const planish_mesh *mesh, const int8_t *sign, const planish_options *options,
              int threads, uint8_t *is_selected, int *all_positive, planish_error *error) {
    const int64_t n = mesh->n_nodes;
    uint8_t *state = pl_alloc(mesh->n_elements, sizeof *state), *tangled = NULL;
    work w = {.mesh = mesh, .state = state, .of_node = is_selected};
    int status = state ? PLANISH_OK : pl_fail_memory(error, "the elements that are bad");
    memset(is_selected, 0, (size_t)n);
    if (!status)
        pl_find_worse(mesh->dim, mesh->n_elements, mesh->elements, sign, is_selected,
                      mesh->coordinates, options->only_worse_than, INFINITY, threads, state);
    if (!status &&
        (options->min_volume > 0 || options->min_volume_fraction > 0 || mesh->min_volume))
        status = add_below(mesh, sign, options, is_selected, threads, state, error);
    *all_positive = !status && !spread(&w, threads, PL_INVERTED, UNTANGLING_LAYERS);
    if (!status && !*all_positive) {
        tangled = pl_alloc(n, sizeof *tangled);
        if (tangled) {
            memcpy(tangled, is_selected, (size_t)n);
            memset(is_selected, 0, (size_t)n);
        } else {
            status = pl_fail_memory(error, "the elements that are bad");
        }
    }
    if (!status)
        spread(&w, threads, PL_WORSE, options->layers);
    for (int64_t i = 0; !status && tangled && i < n; i++)
        is_selected[i] |= tangled[i];
    pl_free(state);
    pl_free(tangled);
    return status;
}
