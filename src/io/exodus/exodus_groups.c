/* exodus_groups: groups of nodes and facets of a mesh that is written, as node sets and side sets. Each
 * member is listed with the number of its set; the sorted list has the sets one after another.
 */
#include "io/exodus/exodus_groups.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>

/* ---- ids ------------------------------------------------------------------------------------ */

/** A wanted number of set or block at. */
typedef struct wanted_id {
    int64_t number, at;
} wanted_id;

static int compare_wanted(const void *a, const void *b) {
    const wanted_id *x = a, *y = b;
    if (x->number != y->number)
        return x->number < y->number ? -1 : 1;
    return (x->at > y->at) - (x->at < y->at);
}

int exodus_give_ids(const int64_t *wanted, int64_t n, int32_t *id, planish_error *error) {
    wanted_id *all = pl_alloc(n, sizeof *all);
    if (!all)
        return pl_fail_memory(error, "numbers of blocks and sets");
    for (int64_t i = 0; i < n; i++) {
        all[i] = (wanted_id){wanted[i], i};
        id[i] = 0;
    }
    qsort(all, (size_t)n, sizeof *all, compare_wanted);
    int64_t next = 1;
    for (int64_t i = 0; i < n; i++)
        if (all[i].number >= next && all[i].number <= INT32_MAX - n) {
            id[all[i].at] = (int32_t)all[i].number;
            next = all[i].number + 1;
        }
    for (int64_t i = 0; i < n; i++)
        if (id[i] == 0)
            id[i] = (int32_t)next++;
    pl_free(all);
    return PLANISH_OK;
}

/* ---- sets ----------------------------------------------------------------------------------- */

/** Find the group that the set of members like this one is, or -1. */
static int32_t group_of(const io_view *view, const exodus_member *member, int dim) {
    const int32_t g = io_view_first_group(view, dim, member->number);
    return g >= 0 && view->is_physical[g] == !member->is_entity ? g : -1;
}

static int compare_sets(const exodus_member *x, const exodus_member *y) {
    if (x->is_entity != y->is_entity)
        return x->is_entity - y->is_entity;
    return (x->number > y->number) - (x->number < y->number);
}

static int compare_members(const void *a, const void *b) {
    const exodus_member *x = a, *y = b;
    const int sets = compare_sets(x, y);
    if (sets)
        return sets;
    return x->place != y->place ? (x->place < y->place ? -1 : 1) : x->side - y->side;
}

static int add_member(exodus_groups *groups, exodus_member member) {
    return pl_append(&groups->member, &groups->n_members, &groups->member_capacity, &member,
                     sizeof member) != NULL;
}

/** Put a side, or the node at side.element, of an entity (-1: none) into its sets. region: its number if
 *  it is in no group. Returns 0 without memory. */
static int add_to_sets(const io_view *view, exodus_groups *groups, int32_t entity, int64_t region,
                       exodus_side side) {
    const io_entity *e = entity >= 0 ? &view->model->entity[entity] : NULL;
    int is_done = 1;
    if (!e || e->n_physical == 0)
        return add_member(groups, (exodus_member){region, 1, side.element, side.side});
    for (int k = 0; k < e->n_physical && is_done; k++)
        is_done = add_member(groups, (exodus_member){e->physical[k], 0, side.element, side.side});
    return is_done;
}

/** Give the sets their ids. */
static int number_sets(exodus_groups *groups, planish_error *error) {
    int64_t *wanted = pl_alloc(groups->n, sizeof *wanted);
    int32_t *id = pl_alloc(groups->n, sizeof *id);
    int status = wanted && id ? PLANISH_OK : pl_fail_memory(error, "node sets and side sets");
    for (int64_t i = 0; i < groups->n && !status; i++)
        wanted[i] = groups->member[groups->group[i].first].number;
    if (!status)
        status = exodus_give_ids(wanted, groups->n, id, error);
    for (int64_t i = 0; i < groups->n && !status; i++)
        groups->group[i].id = id[i];
    pl_free(wanted);
    pl_free(id);
    return status;
}

/** Sort the members, each once in a set. */
static void sort_members(exodus_groups *groups) {
    exodus_member *member = groups->member;
    int64_t n = 0;
    if (groups->n_members > 0)
        qsort(member, (size_t)groups->n_members, sizeof *member, compare_members);
    for (int64_t i = 0; i < groups->n_members; i++)
        if (n == 0 || compare_members(&member[n - 1], &member[i]) != 0)
            member[n++] = member[i];
    groups->n_members = n;
}

/** Make the sets of the members that are listed, of a dimension. */
static int make_sets(const io_view *view, int dim, exodus_groups *groups, planish_error *error) {
    sort_members(groups);
    const exodus_member *member = groups->member;
    for (int64_t i = 0; i < groups->n_members; i++) {
        if (i == 0 || compare_sets(&member[i - 1], &member[i]) != 0) {
            const int32_t g = group_of(view, &member[i], dim);
            const exodus_group set = {
                .name = g < 0 ? "" : view->model->group[g].name, .group = g, .first = i};
            if (!pl_append(&groups->group, &groups->n, &groups->capacity, &set, sizeof set))
                return pl_fail_memory(error, "node sets and side sets");
        }
        groups->group[groups->n - 1].n++;
    }
    return number_sets(groups, error);
}

int exodus_groups_of_nodes(const io_view *view, exodus_groups *groups, planish_error *error) {
    const io_model *model = view->model;
    int is_done = 1;
    *groups = (exodus_groups){.n = 0};
    for (int64_t i = 0; i < model->n_nodes && model->node_entity && is_done; i++) {
        const int32_t entity = model->node_entity[i];
        const io_entity *e = entity >= 0 ? &model->entity[entity] : NULL;
        if (e && (e->n_physical > 0 || e->tag != 0))
            is_done = add_to_sets(view, groups, entity, e->tag, (exodus_side){(int32_t)i + 1, 0});
    }
    return is_done ? make_sets(view, 0, groups, error) : pl_fail_memory(error, "node sets");
}

int exodus_groups_of_facets(const io_view *view, const io_view_blocks *blocks,
                            const exodus_facets *facets, exodus_groups *groups,
                            planish_error *error) {
    int64_t facet = 0;
    int is_done = 1;
    *groups = (exodus_groups){.n = 0};
    for (int64_t b = 0; b < blocks->n; b++) {
        const io_view_block *block = &blocks->block[b];
        for (int64_t i = 0; i < block->n && block->dim == facets->dim && is_done; i++, facet++)
            if (facets->side[facet].element > 0)
                is_done =
                    add_to_sets(view, groups, block->entity, block->region, facets->side[facet]);
    }
    return is_done ? make_sets(view, facets->dim, groups, error)
                   : pl_fail_memory(error, "side sets");
}

void exodus_groups_release(exodus_groups *groups) {
    pl_free(groups->member);
    pl_free(groups->group);
    *groups = (exodus_groups){.n = 0};
}
