/* groups: the groups that a file names or numbers, as tags for planish_hold. */
#include "io/core/format.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { NUMBER_SIZE = 16 }; /* "3:-2147483648" */

/** Dimension and number of a group, and how many elements or nodes it has. */
typedef struct numbered {
    int dim;
    int32_t number;
    int64_t n;
} numbered;

static int compare(const void *a, const void *b) {
    const numbered *p = a, *q = b;
    if (p->dim != q->dim)
        return p->dim < q->dim ? -1 : 1;
    return (p->number > q->number) - (p->number < q->number);
}

/** Count the numbers by which tags mean entities. */
static int64_t count_numbers(const io_model *model) {
    int64_t n = 0;
    for (int32_t i = 0; i < model->n_entities; i++)
        n += model->entity[i].n_physical > 0 ? model->entity[i].n_physical : 1;
    return n;
}

/** Count the elements or nodes of each entity: used [n_entities], zeroed. */
static void count_used(const io_model *model, int64_t *used) {
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
        const io_list list = io_model_list(model, k);
        for (int64_t i = 0; list.entity && i < list.n; i++)
            used[list.entity[i]]++;
    }
    for (int64_t i = 0; model->node_entity && i < model->n_nodes; i++)
        if (model->node_entity[i] >= 0)
            used[model->node_entity[i]]++;
}

/** Find these numbers of used entities, each once and sorted: found [count_numbers]. Returns how many
 *  there are. */
static int64_t find_numbers(const io_model *model, const int64_t *used, numbered *found) {
    int64_t n = 0, n_kept = 0;
    for (int32_t i = 0; i < model->n_entities; i++) {
        const io_entity *entity = &model->entity[i];
        for (int j = 0; used[i] && (j < entity->n_physical || j == 0); j++)
            found[n++] = (numbered){
                entity->dim, entity->n_physical ? entity->physical[j] : entity->tag, used[i]};
    }
    qsort(found, (size_t)n, sizeof *found, compare);
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || compare(&found[i], &found[n_kept - 1]) != 0)
            found[n_kept++] = found[i];
        else
            found[n_kept - 1].n += found[i].n;
    return n_kept;
}

/** Collect the numbers of groups with a name, sorted: named [n_groups]. */
static void find_named(const io_model *model, numbered *named) {
    for (int32_t i = 0; i < model->n_groups; i++)
        named[i] = (numbered){model->group[i].dim, model->group[i].tag, 0};
    qsort(named, (size_t)model->n_groups, sizeof *named, compare);
}

/** Order groups by dimension, name and number. */
static int compare_groups(const void *a, const void *b) {
    const io_group *p = *(const io_group *const *)a, *q = *(const io_group *const *)b;
    if (p->dim != q->dim)
        return p->dim < q->dim ? -1 : 1;
    const int order = strcmp(p->name, q->name);
    return order ? order : (p->tag > q->tag) - (p->tag < q->tag);
}

static int are_of_one_name(const io_group *a, const io_group *b) {
    return a->dim == b->dim && strcmp(a->name, b->name) == 0;
}

/** Count the elements or nodes of groups [n_groups] of one name and dimension together, each number once:
 *  count[i] of the first in the file, -1 of the others. sorted [n_groups] is room. */
static void count_named(const io_model *model, const numbered *number, int64_t n,
                        const io_group **sorted, int64_t *count) {
    const int64_t n_groups = model->n_groups;
    for (int64_t i = 0; i < n_groups; i++)
        sorted[i] = &model->group[i];
    qsort(sorted, (size_t)n_groups, sizeof *sorted, compare_groups);
    for (int64_t begin = 0, end = 0; begin < n_groups; begin = end) {
        const io_group *first = sorted[begin];
        int64_t total = 0;
        for (; end < n_groups && are_of_one_name(sorted[begin], sorted[end]); end++) {
            const numbered key = {sorted[end]->dim, sorted[end]->tag, 0};
            const numbered *found = bsearch(&key, number, (size_t)n, sizeof *number, compare);
            const int is_counted = end > begin && sorted[end - 1]->tag == key.number;
            total += found && !is_counted ? found->n : 0;
            first = sorted[end] < first ? sorted[end] : first;
            count[sorted[end] - model->group] = -1;
        }
        count[first - model->group] = total;
    }
}

/** Fill in the list: names with their count [n_groups] of count_named, then numbers [n] that are not among
 *  named [n_groups], whose texts have room in text. */
static void fill(const io_model *model, const int64_t *count, const numbered *named,
                 const numbered *number, int64_t n, char *text, planish_file *file) {
    planish_group *group = file->group;
    for (int32_t i = 0; i < model->n_groups; i++)
        if (count[i] >= 0)
            *group++ = (planish_group){
                .tag = model->group[i].name, .dim = model->group[i].dim, .n = count[i]};
    for (int64_t i = 0; i < n && !model->groups_by_name; i++) {
        if (bsearch(&number[i], named, (size_t)model->n_groups, sizeof *named, compare))
            continue;
        snprintf(text, NUMBER_SIZE, "%d:%d", number[i].dim,
                 (int)io_model_file_number(model, number[i].number));
        *group++ = (planish_group){.tag = text, .dim = number[i].dim, .n = number[i].n};
        text += NUMBER_SIZE;
    }
    file->n_groups = group - file->group;
}

/** Make the list. Returns whether there is memory for it. */
static int make_list(planish_file *file) {
    const io_model *model = &file->model;
    const int64_t n_numbers = count_numbers(model);
    numbered *number = pl_alloc(n_numbers, sizeof *number);
    numbered *named = pl_alloc(model->n_groups, sizeof *named);
    int64_t *used = pl_alloc_zero(model->n_entities, sizeof *used);
    const io_group **sorted = pl_alloc(model->n_groups, sizeof *sorted);
    int64_t *count = pl_alloc(model->n_groups, sizeof *count);
    file->group = pl_alloc(model->n_groups + n_numbers, sizeof *file->group);
    file->group_text = pl_alloc(n_numbers, NUMBER_SIZE);
    const int has_memory =
        number && named && used && sorted && count && file->group && file->group_text;
    if (has_memory) {
        count_used(model, used);
        find_named(model, named);
        const int64_t n = find_numbers(model, used, number);
        count_named(model, number, n, sorted, count);
        fill(model, count, named, number, n, file->group_text, file);
    }
    pl_free(count);
    pl_free(sorted);
    pl_free(used);
    pl_free(named);
    pl_free(number);
    return has_memory;
}

int planish_file_groups(planish_file *file, const planish_group **groups, int64_t *n,
                        planish_error *error) {
    if (n)
        *n = 0;
    if (!file || !groups || !n)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file, groups and n must not be NULL");
    if (!file->group && !make_list(file)) {
        io_file_free_groups(file);
        return pl_fail_memory(error, "the list of groups");
    }
    *groups = file->group;
    *n = file->n_groups;
    return PLANISH_OK;
}
