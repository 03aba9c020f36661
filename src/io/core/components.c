/* components: coordinates of files that have all x, then all y, then all z. */
#include "io/core/components.h"

#include "base/parallel.h"
#include "base/status.h"
#include "io/core/binary.h"

#include <stdatomic.h>

/* ---- values ------------------------------------------------------------------------------- */

typedef struct component_job {
    io_strided from;
    double *to; /* the component of the first node */
    _Atomic int64_t bad;
} component_job;

/** Note a node whose coordinate is not finite, unless one before it is known. */
static void note_bad(component_job *job, int64_t node) {
    int64_t known = atomic_load(&job->bad);
    while ((known < 0 || node < known) && !atomic_compare_exchange_weak(&job->bad, &known, node))
        continue;
}

static void load_chunk(void *context, int64_t begin, int64_t end, int thread) {
    component_job *job = context;
    const io_strided from = job->from;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const char *at = from.data + i * from.stride;
        const double value =
            from.size == 4 ? (double)io_load_f32(at, from.swapped) : io_load_f64(at, from.swapped);
        job->to[3 * i] = value;
        if (!isfinite(value)) {
            note_bad(job, i);
            return;
        }
    }
}

int64_t io_load_component(io_model *model, io_strided from, int component) {
    enum { NODES_AT_ONCE = 1 << 14 };
    component_job job = {.from = from, .to = model->xyz + 3 * from.first + component, .bad = -1};
    const int64_t n = from.n > 0 ? from.n : model->n_nodes;
    pl_parallel_for(io_model_threads(model), n, NODES_AT_ONCE, load_chunk, &job);
    const int64_t bad = atomic_load(&job.bad);
    return bad < 0 ? bad : from.first + bad;
}

/* ---- places ------------------------------------------------------------------------------- */

int io_components_end(io_model *model, planish_error *error) {
    io_model_sort_spans(model);
    for (int64_t i = 1; i < model->n_spans; i++) {
        const io_span *s = &model->span[i - 1];
        const int size = s->encoding == IO_FLOAT32 ? 4 : 8;
        const int64_t next = model->span[i].offset;
        if (s->offset + (s->n_nodes - 1) * s->stride + s->n_components * size > next)
            return io_fail_at(model, model->input.data + next, error,
                              "two arrays of coordinates share bytes; the file is damaged");
    }
    for (int64_t i = 0; model->columns < 3 && i < model->n_nodes; i++)
        model->xyz[3 * i + 2] = 0;
    return PLANISH_OK;
}
