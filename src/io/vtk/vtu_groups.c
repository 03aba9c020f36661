/* vtu_groups: named groups for VTK's XML files, in which an array of the field data is called by a name:
 * arrays of one name would be one, and a cell has one number.
 */
#include "io/vtk/vtu_groups.h"

#include "base/memory.h"
#include "base/status.h"

enum { N_DIMS = 4 };

/** Find the first group of the name and dimension of each. */
static int find_first(const io_view *view, vtu_groups *groups, planish_error *error) {
    const io_model *model = view->model;
    int32_t *made = pl_alloc_zero(model->n_groups, N_DIMS * sizeof *made); /* from 1 */
    const int status = made ? PLANISH_OK : pl_fail_memory(error, "groups");
    for (int32_t g = 0; g < model->n_groups && !status; g++) {
        int32_t *first = &made[N_DIMS * (int64_t)groups->first[g] + model->group[g].dim];
        *first = *first ? *first : g + 1;
        groups->one[g] = *first - 1;
    }
    pl_free(made);
    return status;
}

static int has_number_of(const io_model *model, int32_t g, int32_t h) {
    return model->group[g].tag == model->group[h].tag;
}

/** Set the bytes of the groups whose name has a number that has another name, too. */
static void mark_mixed(const io_view *view, const vtu_groups *groups, uint8_t *is_mixed) {
    const io_model *model = view->model;
    for (int32_t g = 0; g < model->n_groups; g++) {
        const int32_t next = io_view_next_of_number(view, g);
        if (next >= 0 && groups->one[next] != groups->one[g])
            is_mixed[groups->one[g]] = is_mixed[groups->one[next]] = 1;
    }
}

/** Part groups of one name again that cannot be one. */
static int part_groups(const io_view *view, int may_join, vtu_groups *groups,
                       planish_error *error) {
    const io_model *model = view->model;
    uint8_t *is_mixed = pl_alloc_zero(model->n_groups, 1);
    const int status = is_mixed ? PLANISH_OK : pl_fail_memory(error, "groups");
    if (!status)
        mark_mixed(view, groups, is_mixed);
    for (int32_t g = 0; g < model->n_groups && !status; g++) {
        if (has_number_of(model, g, groups->one[g]))
            continue;
        if (!may_join || is_mixed[groups->one[g]])
            groups->one[g] = g;
        groups->has_joined |= groups->one[g] != g;
    }
    pl_free(is_mixed);
    return status;
}

/** Return the number of the first group that cells of an entity are in, or 0. */
static int32_t number_of(const io_view *view, const vtu_groups *groups, int32_t entity) {
    const io_entity *e = &view->model->entity[entity];
    const int32_t group = io_view_group_at(view, entity, 0);
    return group >= 0 ? view->model->group[groups->one[group]].tag
                      : (e->n_physical > 0 ? e->physical[0] : 0);
}

int vtu_groups_make(const io_view *view, int may_join, vtu_groups *groups, planish_error *error) {
    const io_model *model = view->model;
    *groups = (vtu_groups){.one = pl_alloc(model->n_groups, sizeof *groups->one),
                           .number = pl_alloc(model->n_entities, sizeof *groups->number)};
    int status = io_view_find_names(view, &groups->first, error);
    if (!status && (!groups->one || !groups->number))
        status = pl_fail_memory(error, "groups");
    if (!status)
        status = find_first(view, groups, error);
    if (!status)
        status = part_groups(view, may_join, groups, error);
    for (int32_t e = 0; e < model->n_entities && !status; e++)
        groups->number[e] = number_of(view, groups, e);
    return status;
}

void vtu_groups_release(vtu_groups *groups) {
    pl_free(groups->first);
    pl_free(groups->one);
    pl_free(groups->number);
    *groups = (vtu_groups){.first = NULL};
}

void vtu_groups_lose(const io_view *view, const vtu_groups *groups, io_losses *losses) {
    const io_model *model = view->model;
    int has_suffixes = 0;
    for (int32_t g = 0; g < model->n_groups; g++)
        has_suffixes |= groups->one[g] == g && groups->first[g] < g;
    if (has_suffixes)
        io_losses_add(losses, "names of several groups (now with their numbers)");
    if (groups->has_joined && !model->groups_by_name)
        io_losses_add(losses, "numbers of groups");
}
