/* exodus_groups: groups of nodes and facets of a mesh that is written, as node sets and side sets. Each
 * member is listed with its set; the sorted list has the sets one after another. Programs look sets up
 * by their names, so that all groups of one name are one set. Sets may overlap.
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

/** Sets under way. */
typedef struct set_search {
    const io_view *view;
    int dim;        /* of the members */
    int32_t *first; /* [n_groups] the first group of the name of each; owned */
    exodus_groups *groups;
} set_search;

/** Compare the sets of two members: those with names come first. */
static int compare_sets(const exodus_member *x, const exodus_member *y) {
    if (x->group != y->group)
        return (uint32_t)x->group < (uint32_t)y->group ? -1 : 1;
    if (x->group >= 0 || (x->is_entity == y->is_entity && x->number == y->number))
        return 0;
    if (x->is_entity != y->is_entity)
        return x->is_entity - y->is_entity;
    return x->number < y->number ? -1 : 1;
}

static int compare_members(const void *a, const void *b) {
    const exodus_member *x = a, *y = b;
    const int sets = compare_sets(x, y);
    if (sets)
        return sets;
    if (x->place != y->place)
        return x->place < y->place ? -1 : 1;
    return x->side != y->side ? x->side - y->side
                              : (x->number > y->number) - (x->number < y->number);
}

static int add_member(exodus_groups *groups, exodus_member member) {
    return pl_append(&groups->member, &groups->n_members, &groups->member_capacity, &member,
                     sizeof member) != NULL;
}

/** Put a member of a number into the sets of all names that the number has; without one into that of the
 *  number, if that is a group's or is_listed. Returns 0 without memory. */
static int add_to_number(const set_search *s, exodus_member member, int is_listed) {
    int32_t g = io_view_first_group(s->view, s->dim, member.number);
    int is_done = 1;
    if (g >= 0 && s->view->is_physical[g] == member.is_entity)
        g = -1;
    member.group = -1;
    if (g < 0 && is_listed)
        return add_member(s->groups, member);
    for (; g >= 0 && is_done; g = io_view_next_of_number(s->view, g)) {
        member.group = s->first[g];
        is_done = add_member(s->groups, member);
    }
    return is_done;
}

/** Put a side, or the node at side.element, of an entity (-1: none) into its sets. region: its number if
 *  it is in no group. Returns 0 without memory. */
static int add_to_sets(const set_search *s, int32_t entity, int64_t region, exodus_side side) {
    const io_entity *e = entity >= 0 ? &s->view->model->entity[entity] : NULL;
    const int n = e ? e->n_physical : 0;
    exodus_member member = {
        .is_entity = 1, .number = region, .place = side.element, .side = side.side};
    int is_done = add_to_number(s, member, n == 0 && (s->dim > 0 || region != 0));
    member.is_entity = 0;
    for (int k = 0; k < n && is_done; k++) {
        member.number = e->physical[k];
        is_done = add_to_number(s, member, 1);
    }
    return is_done;
}

static int compare_ids(const void *a, const void *b) {
    const exodus_group *x = a, *y = b;
    return (x->id > y->id) - (x->id < y->id);
}

/** Give the sets their ids, and sort them by these. */
static int number_sets(exodus_groups *groups, planish_error *error) {
    int64_t *wanted = pl_alloc(groups->n, sizeof *wanted);
    int32_t *id = pl_alloc(groups->n, sizeof *id);
    int status = wanted && id ? PLANISH_OK : pl_fail_memory(error, "node sets and side sets");
    for (int64_t i = 0; i < groups->n && !status; i++)
        wanted[i] = groups->group[i].number;
    if (!status)
        status = exodus_give_ids(wanted, groups->n, id, error);
    for (int64_t i = 0; i < groups->n && !status; i++)
        groups->group[i].id = id[i];
    if (groups->n > 0)
        qsort(groups->group, (size_t)groups->n, sizeof *groups->group, compare_ids);
    pl_free(wanted);
    pl_free(id);
    return status;
}

/** Return whether two members are the same in the same set. */
static int is_same(const exodus_member *x, const exodus_member *y) {
    return compare_sets(x, y) == 0 && x->place == y->place && x->side == y->side;
}

/** Return the file's number of a set, or the number of a region, which may be larger. */
static int64_t file_number(const io_view *view, int64_t number) {
    const int is_group = number >= INT32_MIN && number <= INT32_MAX;
    return is_group ? io_model_file_number(view->model, (int32_t)number) : number;
}

/** Find the sets of the sorted members, each of which is once in a set. */
static int find_sets(exodus_groups *groups, const io_view *view, planish_error *error) {
    exodus_member *member = groups->member;
    int64_t n = 0;
    for (int64_t i = 0; i < groups->n_members; i++) {
        const exodus_member *m = &member[i];
        if (n == 0 || compare_sets(&member[n - 1], m) != 0) {
            const exodus_group set = {.number = file_number(view, m->number),
                                      .name = m->group < 0 ? "" : view->model->group[m->group].name,
                                      .group = m->group,
                                      .first = n};
            if (!pl_append(&groups->group, &groups->n, &groups->capacity, &set, sizeof set))
                return pl_fail_memory(error, "node sets and side sets");
        }
        exodus_group *set = &groups->group[groups->n - 1];
        const int64_t number = file_number(view, m->number);
        if (number > 0 && (set->number <= 0 || number < set->number))
            set->number = number;
        if (set->n > 0 && is_same(&member[n - 1], m))
            continue;
        member[n++] = *m;
        set->n++;
    }
    groups->n_members = n;
    return PLANISH_OK;
}

/** Make the sets of the members that are listed. */
static int make_sets(const set_search *s, planish_error *error) {
    exodus_groups *groups = s->groups;
    if (groups->n_members > 0)
        qsort(groups->member, (size_t)groups->n_members, sizeof *groups->member, compare_members);
    const int status = find_sets(groups, s->view, error);
    return status ? status : number_sets(groups, error);
}

/** List the nodes of sets. Returns 0 without memory. */
static int list_nodes(const set_search *s) {
    const io_model *model = s->view->model;
    int is_done = 1;
    for (int64_t i = 0; i < model->n_nodes && model->node_entity && is_done; i++) {
        const int32_t entity = model->node_entity[i];
        if (entity >= 0)
            is_done =
                add_to_sets(s, entity, model->entity[entity].tag, (exodus_side){(int32_t)i + 1, 0});
    }
    return is_done;
}

/** List the facets that are sides. Returns 0 without memory. */
static int list_facets(const set_search *s, const io_view_blocks *blocks,
                       const exodus_facets *facets) {
    int64_t facet = 0;
    int is_done = 1;
    for (int64_t b = 0; b < blocks->n; b++) {
        const io_view_block *block = &blocks->block[b];
        for (int64_t i = 0; i < block->n && block->dim == facets->dim && is_done; i++, facet++)
            if (facets->side[facet].element > 0)
                is_done = add_to_sets(s, block->entity, block->region, facets->side[facet]);
    }
    return is_done;
}

int exodus_groups_of_nodes(const io_view *view, exodus_groups *groups, planish_error *error) {
    set_search s = {.view = view, .dim = 0, .groups = groups};
    *groups = (exodus_groups){.n = 0};
    int status = io_view_find_names(view, &s.first, error);
    if (!status)
        status = list_nodes(&s) ? make_sets(&s, error) : pl_fail_memory(error, "node sets");
    pl_free(s.first);
    return status;
}

int exodus_groups_of_facets(const io_view *view, const io_view_blocks *blocks,
                            const exodus_facets *facets, exodus_groups *groups,
                            planish_error *error) {
    set_search s = {.view = view, .dim = facets->dim, .groups = groups};
    *groups = (exodus_groups){.n = 0};
    int status = io_view_find_names(view, &s.first, error);
    if (!status)
        status = list_facets(&s, blocks, facets) ? make_sets(&s, error)
                                                 : pl_fail_memory(error, "side sets");
    pl_free(s.first);
    return status;
}

void exodus_groups_release(exodus_groups *groups) {
    pl_free(groups->member);
    pl_free(groups->group);
    *groups = (exodus_groups){.n = 0};
}
