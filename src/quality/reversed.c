/* reversed: the elements that are numbered the other way round than most, by exact signs.
 *
 * Two passes over the elements: signs are found and counted; then the rarer sign is marked.
 */
#include "quality/reversed.h"

#include "base/parallel.h"
#include "base/parts.h"
#include "quality/certificate.h"

enum { CHUNK = 4096 }; /* elements that one thread takes at a time */

/** Values of state between the passes. */
enum { FLAT = 0, POSITIVE = 1, NEGATIVE = 2 };

typedef struct work {
    const pl_view *view;
    const double *coordinates;
    uint8_t *state;    /* [n_elements] */
    int64_t counts[2]; /* positive and negative elements; shared */
    uint8_t rarer;     /* POSITIVE or NEGATIVE */
} work;

static uint8_t state_of(const work *w, int64_t element) {
    const int32_t *node = w->view->elements + element * (w->view->dim + 1);
    const double *vertex[4];
    for (int j = 0; j <= w->view->dim; j++)
        vertex[j] = w->coordinates + (int64_t)node[j] * w->view->dim;
    const int sign = pl_measure_sign(w->view->dim, vertex);
    return sign > 0 ? POSITIVE : sign < 0 ? NEGATIVE : FLAT;
}

static void sign_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    int64_t n_positive = 0, n_negative = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int counts = !w->view->is_counted || w->view->is_counted[i];
        w->state[i] = state_of(w, i);
        n_positive += counts && w->state[i] == POSITIVE;
        n_negative += counts && w->state[i] == NEGATIVE;
    }
    __atomic_fetch_add(&w->counts[0], n_positive, __ATOMIC_RELAXED);
    __atomic_fetch_add(&w->counts[1], n_negative, __ATOMIC_RELAXED);
}

static void mark_chunk(void *context, int64_t begin, int64_t end, int thread) {
    work *w = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        w->state[i] = w->state[i] == w->rarer;
}

int64_t pl_find_reversed(const pl_view *view, const double *coordinates, int threads,
                         uint8_t *reversed) {
    work w = {view, coordinates, reversed, {0}, NEGATIVE};
    pl_parallel_for(threads, view->n_elements, CHUNK, sign_chunk, &w);
    pl_parts_add(w.counts, 2);
    const int64_t n = pl_count_reversed(w.counts[0], w.counts[1]);
    w.rarer = w.counts[0] >= w.counts[1] ? NEGATIVE : POSITIVE;
    pl_parallel_for(threads, view->n_elements, CHUNK, mark_chunk, &w);
    return n;
}
