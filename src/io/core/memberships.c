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
    if (!m->is_counted)
        m->start[thing + 2]++;
    else if (m->start[thing + 1] < m->start[thing + 2]) /* else the file has changed meanwhile */
        m->list[m->start[thing + 1]++] = tag;
}

int io_memberships_counted(io_memberships *m, planish_error *error) {
    for (int64_t i = 0; i < m->n; i++)
        m->start[i + 2] += m->start[i + 1];
    memset(m->last, 0, (size_t)m->n * sizeof *m->last);
    m->is_counted = 1;
    m->list = pl_alloc_zero(m->start[m->n + 1], sizeof *m->list);
    return m->list ? PLANISH_OK : pl_fail_memory(error, "the sets of the file");
}

void io_memberships_renumber(io_memberships *m, const int32_t *number) {
    for (int64_t i = 0; i < m->start[m->n]; i++)
        m->list[i] = m->list[i] > 0 ? number[m->list[i] - 1] : 0;
    m->is_renumbered = 1;
}

int io_memberships_entities(const io_memberships *m, io_model *model, int dim, int64_t first,
                            int64_t n, const int32_t *region, int32_t *entity,
                            planish_error *error) {
    int32_t last = -1; /* most often the next thing is of the same entity */
    for (int64_t i = 0; i < n; i++) {
        const int64_t begin = m->start[first + i];
        const int n_sets = (int)(m->start[first + i + 1] - begin);
        const int32_t *list = m->list + begin, first_set = m->is_renumbered && n_sets ? *list : 0;
        const int32_t tag = region ? region[i] + 1 : first_set;
        const io_entity *e = last >= 0 ? &model->entity[last] : NULL;
        entity[i] = -1;
        if (dim == 0 && n_sets == 0)
            continue;
        if (!e || e->tag != tag || e->n_physical != n_sets ||
            (n_sets > 0 && memcmp(e->physical, list, (size_t)n_sets * sizeof *list) != 0))
            last = io_model_entity(model, dim, tag, n_sets, list, error);
        if (last < 0)
            return last;
        entity[i] = last;
    }
    return PLANISH_OK;
}

int io_memberships_of_nodes(const io_memberships *m, io_model *model, planish_error *error) {
    model->node_entity = pl_alloc(model->n_nodes, sizeof *model->node_entity);
    if (!model->node_entity)
        return pl_fail_memory(error, "the sets of nodes");
    return io_memberships_entities(m, model, 0, 0, model->n_nodes, NULL, model->node_entity, error);
}

void io_memberships_destroy(io_memberships *m) {
    pl_free(m->start);
    pl_free(m->list);
    pl_free(m->last);
    *m = (io_memberships){.n = 0};
}
