/* memberships: which sets each of many things is in. */
#include "io/core/memberships.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

int io_memberships_begin(io_memberships *m, int64_t n, planish_error *error) {
    *m = (io_memberships){.n = n,
                          .start = pl_alloc_zero(n + 2, sizeof *m->start),
                          .last = pl_alloc_zero(n, sizeof *m->last)};
    return m->start && m->last ? PLANISH_OK : pl_fail_memory(error, "the sets of the file");
}

/* While counted, thing i has its number at start[i + 2]; while listed, the end of its list so far
 * at start[i + 1]: then start[i] is where the list begins, in the end. */
void io_memberships_add(io_memberships *m, int64_t thing, int32_t tag) {
    if (m->last[thing] == tag)
        return;
    m->last[thing] = tag;
    if (m->is_counted)
        m->list[m->start[thing + 1]++] = tag;
    else
        m->start[thing + 2]++;
}

int io_memberships_counted(io_memberships *m, planish_error *error) {
    for (int64_t i = 0; i < m->n; i++)
        m->start[i + 2] += m->start[i + 1];
    memset(m->last, 0, (size_t)m->n * sizeof *m->last);
    m->is_counted = 1;
    m->list = pl_alloc(m->start[m->n + 1], sizeof *m->list);
    return m->list ? PLANISH_OK : pl_fail_memory(error, "the sets of the file");
}

int32_t io_memberships_entity(const io_memberships *m, io_model *model, int64_t thing, int dim,
                              int32_t tag, int32_t last, planish_error *error) {
    const int32_t *list = m->list + m->start[thing];
    const int64_t n = m->start[thing + 1] - m->start[thing];
    const io_entity *e = last >= 0 ? &model->entity[last] : NULL;
    if (e && e->dim == dim && e->tag == tag && e->n_physical == n &&
        (n == 0 || memcmp(e->physical, list, (size_t)n * sizeof *list) == 0))
        return last;
    return io_model_entity(model, dim, tag, (int)n, list, error);
}

int io_memberships_of_nodes(const io_memberships *m, io_model *model, planish_error *error) {
    int32_t last = -1;
    model->node_entity = pl_alloc(model->n_nodes, sizeof *model->node_entity);
    if (!model->node_entity)
        return pl_fail_memory(error, "the sets of nodes");
    for (int64_t i = 0; i < model->n_nodes; i++) {
        model->node_entity[i] = -1;
        if (m->start[i] == m->start[i + 1])
            continue;
        last = io_memberships_entity(m, model, i, 0, 0, last, error);
        if (last < 0)
            return last;
        model->node_entity[i] = last;
    }
    return PLANISH_OK;
}

void io_memberships_destroy(io_memberships *m) {
    pl_free(m->start);
    pl_free(m->list);
    pl_free(m->last);
    *m = (io_memberships){.n = 0};
}
