/* copies: nodes that a file gives more than once, with the same coordinates.
 *
 * The model has each of them once, at the index of the first; the places in the file stay as they
 * are, and what is written goes to all of them. Programs that own such formats take the same node
 * again, too. One that is given at different places is refused: which is meant, nobody knows.
 */
#include "io/core/copies.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK_NODES = 1 << 14 };

typedef struct numbered {
    int64_t number;
    int32_t place;
} numbered;

static int compare(const void *a, const void *b) {
    const numbered *p = a, *q = b;
    if (p->number != q->number)
        return p->number < q->number ? -1 : 1;
    return (p->place > q->place) - (p->place < q->place);
}

static int is_same_place(const io_model *model, int32_t a, int32_t b) {
    for (int d = 0; d < 3; d++)
        if (model->xyz[3 * (int64_t)a + d] != model->xyz[3 * (int64_t)b + d])
            return 0;
    return 1;
}

/** first [n]: for each place the first one of the same number. */
static int find_first(const io_model *model, int32_t *first, planish_error *error) {
    const int64_t n = model->n_nodes;
    numbered *sorted = pl_alloc(n, sizeof *sorted);
    if (!sorted)
        return pl_fail_memory(error, "node numbers");
    for (int64_t i = 0; i < n; i++)
        sorted[i] = (numbered){model->node_number[i], (int32_t)i};
    if (n > 0)
        qsort(sorted, (size_t)n, sizeof *sorted, compare);
    int status = PLANISH_OK;
    for (int64_t i = 0, begin = 0; i < n && !status; i++) {
        if (sorted[i].number != sorted[begin].number)
            begin = i;
        first[sorted[i].place] = sorted[begin].place;
        if (!is_same_place(model, sorted[begin].place, sorted[i].place))
            status = pl_fail(error, PLANISH_ERROR_FORMAT,
                             "%s: node number %lld occurs twice, at different places",
                             model->input.path, (long long)sorted[i].number);
    }
    pl_free(sorted);
    return status;
}

/** Close the gaps that copies leave; first becomes the node of each place. */
static void unite(io_model *model, int32_t *first) {
    const int64_t n = model->n_nodes;
    int32_t kept = 0;
    for (int64_t i = 0; i < n; i++) {
        if (first[i] != i) { /* the first stands before it, and is a node already */
            first[i] = first[first[i]];
            model->hold[first[i]] |= model->hold[i];
            continue;
        }
        memmove(model->xyz + 3 * (int64_t)kept, model->xyz + 3 * i, 3 * sizeof *model->xyz);
        model->node_number[kept] = model->node_number[i];
        model->hold[kept] = model->hold[i];
        first[i] = kept++;
    }
    model->n_nodes = kept;
    model->n_places = n;
    model->place_node = first;
}

int io_unite_copies(io_model *model, planish_error *error) {
    int32_t *first = pl_alloc(model->n_nodes, sizeof *first);
    if (!first)
        return pl_fail_memory(error, "node numbers");
    const int status = find_first(model, first, error);
    if (status)
        pl_free(first);
    else
        unite(model, first);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------ */

typedef struct copying {
    const io_model *model;
    const double *nodes;
    double *places;
} copying;

static void copy_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const copying *c = context;
    const int width = c->model->written;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        memcpy(c->places + width * i, c->nodes + width * (int64_t)c->model->place_node[i],
               (size_t)width * sizeof *c->places);
}

int io_copies_places(const io_model *model, const double *nodes, int threads, const double **places,
                     double **owned, planish_error *error) {
    *owned = NULL;
    *places = nodes;
    if (!model->place_node)
        return PLANISH_OK;
    *places = *owned = pl_alloc(model->n_places, (size_t)model->written * sizeof **owned);
    if (!*owned)
        return pl_fail_memory(error, "the places of nodes");
    copying c = {model, nodes, *owned};
    pl_parallel_for(threads, model->n_places, CHUNK_NODES, copy_chunk, &c);
    return PLANISH_OK;
}
