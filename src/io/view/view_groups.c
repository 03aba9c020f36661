/* view_groups: named groups of a mesh that is written, found by their numbers: meshes may have as many
 * as elements.
 */
#include "io/view/view.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- the order of numbers ------------------------------------------------------------------- */

static int compare_keys(const void *a, const void *b) {
    const io_view_key *x = a, *y = b;
    if (x->dim != y->dim)
        return x->dim < y->dim ? -1 : 1;
    if (x->tag != y->tag)
        return x->tag < y->tag ? -1 : 1;
    return (x->group > y->group) - (x->group < y->group);
}

/** Find the first group of a number that is not before that one, or -1. */
static int32_t find_from(const io_view *view, int dim, int32_t tag, int32_t group) {
    const io_view_key key = {dim, tag, group};
    int64_t low = 0, high = view->model->n_groups;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (compare_keys(&view->key[middle], &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    const io_view_key *found = low < view->model->n_groups ? &view->key[low] : NULL;
    return found && found->dim == dim && found->tag == tag ? found->group : -1;
}

/** Set the bytes of all groups of a number, of which that one is the first; bytes of groups of one
 *  number are equal. */
static void mark_number(const io_view *view, int32_t first, uint8_t *mark) {
    for (int32_t g = first; g >= 0 && !mark[g]; g = io_view_next_of_number(view, g))
        mark[g] = 1;
}

int io_view_groups_begin(io_view *view, planish_error *error) {
    const io_model *model = view->model;
    view->is_physical = pl_alloc_zero(model->n_groups, 1);
    view->key = pl_alloc(model->n_groups, sizeof *view->key);
    if (!view->is_physical || !view->key)
        return pl_fail_memory(error, "groups");
    for (int32_t g = 0; g < model->n_groups; g++)
        view->key[g] = (io_view_key){model->group[g].dim, model->group[g].tag, g};
    qsort(view->key, (size_t)model->n_groups, sizeof *view->key, compare_keys);
    for (int32_t i = 0; i < model->n_entities; i++) {
        const io_entity *e = &model->entity[i];
        for (int k = 0; k < e->n_physical; k++)
            mark_number(view, find_from(view, e->dim, e->physical[k], 0), view->is_physical);
    }
    return PLANISH_OK;
}

void io_view_groups_end(io_view *view) {
    pl_free(view->is_physical);
    pl_free(view->key);
    view->is_physical = NULL;
    view->key = NULL;
}

/* ---- groups of an entity -------------------------------------------------------------------- */

int32_t io_view_first_group(const io_view *view, int dim, int64_t tag) {
    return tag < INT32_MIN || tag > INT32_MAX ? -1 : find_from(view, dim, (int32_t)tag, 0);
}

int32_t io_view_next_of_number(const io_view *view, int32_t group) {
    const io_group *of = &view->model->group[group];
    return find_from(view, of->dim, of->tag, group + 1);
}

int io_view_n_numbers(const io_view *view, int32_t entity) {
    return entity < 0 ? 0 : view->model->entity[entity].n_physical + 1;
}

/** Find the first group of number k of an entity, as io_view_group_at, from that group on. */
static int32_t find_at(const io_view *view, int32_t entity, int k, int32_t from) {
    const io_entity *e = &view->model->entity[entity];
    const int is_own = k == e->n_physical;
    const int32_t group = find_from(view, e->dim, is_own ? e->tag : e->physical[k], from);
    return group >= 0 && !(is_own && view->is_physical[group]) ? group : -1;
}

int32_t io_view_group_at(const io_view *view, int32_t entity, int k) {
    return find_at(view, entity, k, 0);
}

int32_t io_view_next_group(const io_view *view, int32_t entity, int32_t after) {
    int32_t next = -1;
    for (int k = 0; k < io_view_n_numbers(view, entity); k++) {
        const int32_t group = find_at(view, entity, k, after + 1);
        next = group >= 0 && (next < 0 || group < next) ? group : next;
    }
    return next;
}

void io_view_mark_groups(const io_view *view, int32_t entity, uint8_t *mark) {
    for (int k = 0; k < io_view_n_numbers(view, entity); k++)
        mark_number(view, io_view_group_at(view, entity, k), mark);
}

int io_view_group_text(const io_model *model, int32_t group, char *text, size_t size) {
    const io_group *g = &model->group[group];
    return snprintf(text, size, "%d:%ld %s", g->dim, (long)g->tag, g->name);
}

/* ---- names ---------------------------------------------------------------------------------- */

int io_view_name_length(const char *name, int most) {
    enum { MOST_TAIL = 3 }; /* bytes of a character behind its first one */
    const size_t length = strlen(name);
    int cut = most;
    if (length <= (size_t)most)
        return (int)length;
    while (cut > 0 && cut > most - MOST_TAIL && (name[cut] & 0xC0) == 0x80)
        cut--;
    return (name[cut] & 0xC0) == 0x80 ? most : cut; /* bytes that are no UTF-8 are cut anywhere */
}

typedef struct named_group {
    const char *name;
    int32_t group;
} named_group;

static int compare_names(const void *a, const void *b) {
    const named_group *x = a, *y = b;
    const int order = strcmp(x->name, y->name);
    return order ? order : (x->group > y->group) - (x->group < y->group);
}

int io_view_find_names(const io_view *view, int32_t **first, planish_error *error) {
    const int64_t n = view->model->n_groups;
    named_group *named = pl_alloc(n, sizeof *named);
    *first = pl_alloc(n, sizeof **first);
    const int status = named && *first ? PLANISH_OK : pl_fail_memory(error, "names of groups");
    for (int32_t g = 0; g < n && !status; g++)
        named[g] = (named_group){view->model->group[g].name, g};
    if (!status)
        qsort(named, (size_t)n, sizeof *named, compare_names);
    for (int64_t i = 0, begin = 0; i < n && !status; i++) {
        begin = strcmp(named[begin].name, named[i].name) == 0 ? begin : i;
        (*first)[named[i].group] = named[begin].group;
    }
    pl_free(named);
    return status;
}
