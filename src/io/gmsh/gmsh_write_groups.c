/* gmsh_write_groups: the physical groups of a file of Gmsh's that is written.
 *
 * Gmsh keeps one name of a number, meshio one number of a name. So all groups of one name and dimension
 * become one physical group, and an entity is in those of all its names. A group keeps the first of its
 * numbers in the file that no other group has taken; the others get free ones, which no group of
 * any dimension has.
 */
#include "io/gmsh/gmsh_write_groups.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

enum { N_DIMS = 4, NONE = -1 };

/** What is needed to find the groups. */
typedef struct group_finder {
    const io_view *view;
    gmsh_groups *out;
    int64_t capacity;
    int32_t
        *named; /* [n_groups] that group, or the next one of its number, that has a name; or NONE */
    int32_t *n_names;  /* [n_groups] how many there are of these */
    int32_t *of;       /* [n_groups] physical group of each group, or NONE */
    io_view_key *bare; /* [n_bare] numbers without a name, sorted; group: their physical group */
    int64_t n_bare, bare_capacity;
    int is_first; /* of several names of a number the first alone counts */
} group_finder;

/* ---- names of numbers ----------------------------------------------------------------------- */

/** Whether a group is one of elements and has a name. */
static int has_name(const io_group *group) {
    return group->dim > 0 && group->name[0] != '\0';
}

/** Find the groups that have names. */
static int find_named(group_finder *f, planish_error *error) {
    const io_view *view = f->view;
    const int32_t n = (int32_t)view->model->n_groups;
    f->named = pl_alloc(n, sizeof *f->named);
    f->n_names = pl_alloc(n, sizeof *f->n_names);
    if (!f->named || !f->n_names)
        return pl_fail_memory(error, "groups");
    for (int32_t g = n - 1; g >= 0; g--) {
        const int32_t next = io_view_next_of_number(view, g);
        const int is_named = has_name(&view->model->group[g]);
        f->named[g] = is_named ? g : next >= 0 ? f->named[next] : NONE;
        f->n_names[g] = is_named + (next >= 0 ? f->n_names[next] : 0);
    }
    return PLANISH_OK;
}

/** Find the first group of number k of an entity that has a name, or NONE. */
static int32_t first_name(const group_finder *f, int32_t entity, int k) {
    const int32_t group = io_view_group_at(f->view, entity, k);
    return group >= 0 ? f->named[group] : NONE;
}

/** Find the next group of the number of a group that has a name and counts, or NONE. */
static int32_t next_name(const group_finder *f, int32_t group) {
    const int32_t next = f->is_first ? NONE : io_view_next_of_number(f->view, group);
    return next >= 0 ? f->named[next] : NONE;
}

/** Find out whether all names count: entities times names can be too many to write. */
static void look_at_names(group_finder *f) {
    enum { MOST = 1000000 };
    const io_model *model = f->view->model;
    int64_t n = 0;
    for (int32_t e = 0; e < model->n_entities; e++)
        for (int k = 0; model->entity[e].dim > 0 && k < io_view_n_numbers(f->view, e); k++) {
            const int32_t group = first_name(f, e, k);
            n += group >= 0 ? f->n_names[group] - 1 : 0;
        }
    f->is_first = n > MOST;
}

/* ---- groups --------------------------------------------------------------------------------- */

/** Add a physical group. Return its index, or NONE without memory. */
static int32_t add_group(group_finder *f, int dim, const char *name) {
    const gmsh_physical group = {.dim = dim, .name = name};
    const int is_added =
        pl_append(&f->out->group, &f->out->n, &f->capacity, &group, sizeof group) != NULL;
    return is_added ? (int32_t)f->out->n - 1 : NONE;
}

/** Find the physical group of each group that has a name and counts. */
static int find_groups(group_finder *f, planish_error *error) {
    const io_model *model = f->view->model;
    const int32_t n = (int32_t)model->n_groups;
    int32_t *first, *made = pl_alloc(n, N_DIMS * sizeof *made); /* of each name and dimension */
    int status = io_view_find_names(f->view, &first, error);
    f->of = pl_alloc(n, sizeof *f->of);
    if (!status && (!made || !f->of))
        status = pl_fail_memory(error, "groups");
    for (int64_t i = 0; i < N_DIMS * (int64_t)n && !status; i++)
        made[i] = NONE;
    for (int32_t g = 0; g < n && !status; g++) {
        const io_group *group = &model->group[g];
        const int32_t of_number = io_view_first_group(f->view, group->dim, group->tag);
        f->of[g] = NONE;
        if (!has_name(group) || (f->is_first && f->named[of_number] != g))
            continue;
        int32_t *own = &made[N_DIMS * (int64_t)first[g] + group->dim];
        if (*own < 0 && (*own = add_group(f, group->dim, group->name)) < 0)
            status = pl_fail_memory(error, "groups");
        f->of[g] = *own;
    }
    pl_free(first);
    pl_free(made);
    return status;
}

static int compare_bare(const void *a, const void *b) {
    const io_view_key *x = a, *y = b;
    if (x->dim != y->dim)
        return x->dim < y->dim ? -1 : 1;
    return (x->tag > y->tag) - (x->tag < y->tag);
}

/** List the physical numbers of entities that have no name: sorted, each once. */
static int list_bare(group_finder *f, planish_error *error) {
    const io_model *model = f->view->model;
    int64_t n = 0;
    for (int32_t i = 0; i < model->n_entities; i++) {
        const io_entity *e = &model->entity[i];
        for (int k = 0; e->dim > 0 && k < e->n_physical; k++) {
            const io_view_key key = {e->dim, e->physical[k], NONE};
            if (first_name(f, i, k) < 0 &&
                !pl_append(&f->bare, &f->n_bare, &f->bare_capacity, &key, sizeof key))
                return pl_fail_memory(error, "groups");
        }
    }
    if (f->n_bare > 0)
        qsort(f->bare, (size_t)f->n_bare, sizeof *f->bare, compare_bare);
    for (int64_t i = 0; i < f->n_bare; i++)
        if (n == 0 || compare_bare(&f->bare[n - 1], &f->bare[i]) != 0)
            f->bare[n++] = f->bare[i];
    f->n_bare = n;
    return PLANISH_OK;
}

/** Make a physical group of each number that has no name. */
static int find_bare(group_finder *f, planish_error *error) {
    const int status = list_bare(f, error);
    for (int64_t i = 0; i < f->n_bare && !status; i++) {
        f->bare[i].group = add_group(f, f->bare[i].dim, NULL);
        if (f->bare[i].group < 0)
            return pl_fail_memory(error, "groups");
    }
    return status;
}

/* ---- members -------------------------------------------------------------------------------- */

/** Return the physical group of a number without a name, or NONE. */
static int32_t bare_group(const group_finder *f, int dim, int32_t tag) {
    const io_view_key key = {dim, tag, NONE},
                      *found = f->n_bare > 0 ? bsearch(&key, f->bare, (size_t)f->n_bare, sizeof key,
                                                       compare_bare)
                                             : NULL;
    return found ? found->group : NONE;
}

/** Put an entity into the groups of its number k: append those that it is not in yet. seen [n] is for
 *  the last entity, from 1, that is in each. Returns 0 without memory. */
static int add_members(group_finder *f, int32_t entity, int k, int32_t *seen, int64_t *n,
                       int64_t *capacity) {
    const io_entity *e = &f->view->model->entity[entity];
    int32_t name = first_name(f, entity, k);
    int64_t group = name >= 0           ? f->of[name]
                    : k < e->n_physical ? bare_group(f, e->dim, e->physical[k])
                                        : NONE;
    while (group >= 0) {
        if (seen[group] != entity + 1 &&
            !pl_append(&f->out->member, n, capacity, &group, sizeof group))
            return 0;
        seen[group] = entity + 1;
        name = name >= 0 ? next_name(f, name) : NONE;
        group = name >= 0 ? f->of[name] : NONE;
    }
    return 1;
}

static int find_members(group_finder *f, planish_error *error) {
    const io_model *model = f->view->model;
    int64_t n = 0, capacity = 0;
    int32_t *seen = pl_alloc_zero(f->out->n, sizeof *seen);
    f->out->start = pl_alloc_zero((int64_t)model->n_entities + 1, sizeof *f->out->start);
    int is_done = seen && f->out->start;
    for (int32_t e = 0; e < model->n_entities && is_done; e++) {
        for (int k = 0; model->entity[e].dim > 0 && k < io_view_n_numbers(f->view, e) && is_done;
             k++)
            is_done = add_members(f, e, k, seen, &n, &capacity);
        f->out->start[e + 1] = n;
    }
    pl_free(seen);
    return is_done ? PLANISH_OK : pl_fail_memory(error, "groups");
}

/* ---- numbers -------------------------------------------------------------------------------- */

/** Return whether a number is one that the user may know. */
static int is_own_number(const io_model *model, int32_t tag) {
    return tag > 0 && !model->groups_by_name;
}

/** Let groups keep the file's numbers, each number the first group of it that has no other. */
static int keep_numbers(group_finder *f, planish_error *error) {
    const io_model *model = f->view->model;
    gmsh_groups *out = f->out;
    uint8_t *is_taken = pl_alloc_zero(model->n_groups, 1); /* of the first group of each number */
    if (!is_taken)
        return pl_fail_memory(error, "numbers of groups");
    for (int32_t g = 0; g < model->n_groups; g++) {
        const int32_t own = f->of[g], tag = model->group[g].tag;
        if (own < 0 || !is_own_number(model, tag))
            continue;
        uint8_t *taken = &is_taken[io_view_first_group(f->view, model->group[g].dim, tag)];
        if (out->number[own] == 0 && !*taken) {
            out->number[own] = tag;
            *taken = 1;
        }
        out->group[own].is_own = 1;
    }
    for (int64_t i = 0; i < f->n_bare; i++)
        out->number[f->bare[i].group] = f->bare[i].tag > 0 ? f->bare[i].tag : 0;
    pl_free(is_taken);
    return PLANISH_OK;
}

/** Leave out groups without elements, but for those whose numbers are the file's. */
static void leave_out(group_finder *f, const io_view_blocks *blocks) {
    gmsh_groups *out = f->out;
    for (int64_t g = 0; g < out->n; g++)
        if (!out->group[g].is_own && out->number[g] == 0)
            out->number[g] = -1;
    for (int64_t b = 0; b < blocks->n; b++) {
        const int32_t e = blocks->block[b].entity;
        for (int64_t i = e >= 0 ? out->start[e] : 0; e >= 0 && i < out->start[e + 1]; i++)
            if (out->number[out->member[i]] < 0)
                out->number[out->member[i]] = 0;
    }
}

static int number_groups(group_finder *f, const io_view_blocks *blocks, planish_error *error) {
    f->out->number = pl_alloc_zero(f->out->n, sizeof *f->out->number);
    int status =
        f->out->number ? keep_numbers(f, error) : pl_fail_memory(error, "numbers of groups");
    if (!status) {
        leave_out(f, blocks);
        status = io_view_fill_numbers(f->out->number, f->out->n, error);
    }
    return status;
}

/* ---- losses --------------------------------------------------------------------------------- */

/** Return whether a group gets another number than one that the user may know. */
static int is_changed(const group_finder *f) {
    const io_model *model = f->view->model;
    int changed = 0;
    for (int64_t g = 0; g < model->n_groups; g++)
        changed |= f->of[g] >= 0 && is_own_number(model, model->group[g].tag) &&
                   f->out->number[f->of[g]] != io_model_file_number(model, model->group[g].tag);
    for (int64_t i = 0; i < f->n_bare; i++)
        changed |= f->out->number[f->bare[i].group] != io_model_file_number(model, f->bare[i].tag);
    return changed;
}

static void lose_groups(const group_finder *f, io_losses *losses) {
    const io_model *model = f->view->model;
    int has_nodes = 0, is_replaced = 0;
    for (int64_t g = 0; g < model->n_groups; g++)
        has_nodes |= model->group[g].dim == 0;
    for (int64_t g = 0; g < f->out->n; g++)
        for (const char *c = f->out->group[g].name; c && *c; c++)
            is_replaced |= *c == '"' || (unsigned char)*c < ' ';
    io_view_lose_references(f->view, losses);
    if (has_nodes)
        io_losses_add(losses, "groups of nodes");
    if (is_changed(f))
        io_losses_add(losses, "numbers of groups");
    if (f->is_first)
        io_losses_add(losses, "all but the first name of each group (there are too many)");
    if (is_replaced)
        io_losses_add(losses, "quotes and control characters (now '_') in names of groups");
}

/* ---- all ------------------------------------------------------------------------------------ */

int gmsh_groups_make(const io_view *view, const io_view_blocks *blocks, gmsh_groups *groups,
                     io_losses *losses, planish_error *error) {
    group_finder f = {.view = view, .out = groups};
    *groups = (gmsh_groups){.n = 0};
    int status = find_named(&f, error);
    if (!status) {
        look_at_names(&f);
        status = find_groups(&f, error);
    }
    if (!status)
        status = find_bare(&f, error);
    if (!status)
        status = find_members(&f, error);
    if (!status)
        status = number_groups(&f, blocks, error);
    if (!status)
        lose_groups(&f, losses);
    pl_free(f.named);
    pl_free(f.n_names);
    pl_free(f.of);
    pl_free(f.bare);
    return status;
}

void gmsh_groups_release(gmsh_groups *groups) {
    pl_free(groups->group);
    pl_free(groups->number);
    pl_free(groups->start);
    pl_free(groups->member);
    *groups = (gmsh_groups){.n = 0};
}

int64_t gmsh_groups_count(const gmsh_groups *groups, int32_t entity) {
    return entity < 0 ? 0 : groups->start[entity + 1] - groups->start[entity];
}

int64_t gmsh_groups_number(const gmsh_groups *groups, int32_t entity, int64_t k) {
    return k < gmsh_groups_count(groups, entity)
               ? groups->number[groups->member[groups->start[entity] + k]]
               : 0;
}
