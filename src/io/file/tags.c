/* tags: what a text means as a tag of planish_hold, and the tag of an element's region. Names and numbers
 * are sorted once, since there may be as many regions as elements.
 */
#include "io/file/tags.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

io_tag io_tag_parse(const char *text, int dim) {
    io_tag t = {text, 0, dim, 0};
    char *end;
    const char *digits = text;
    if (text[0] >= '0' && text[0] <= '3' && text[1] == ':') {
        t.dim = text[0] - '0';
        digits = text + 2;
    }
    t.number = strtoll(digits, &end, 10);
    t.has_number = end != digits && *end == '\0';
    return t;
}

int32_t io_element_entity(const io_model *model, int64_t i) {
    const io_cells *cells = io_model_elements(model);
    const io_others *others = io_model_other_elements(model);
    const int32_t *entity = i < cells->n ? cells->entity : others->entity;
    return entity ? entity[i < cells->n ? i : i - cells->n] : -1;
}

/* ---- names ---------------------------------------------------------------------------------- */

/** Return the key of a number of groups of a dimension. */
static int64_t key_of(int dim, int32_t number) {
    return (int64_t)dim * ((int64_t)1 << 32) + number;
}

static int compare_names(const void *a, const void *b) {
    const io_group *p = *(const io_group *const *)a, *q = *(const io_group *const *)b;
    const int order = strcmp(p->name, q->name);
    return order ? order : p->dim - q->dim;
}

static int compare_named(const void *a, const void *b) {
    const io_named *p = a, *q = b;
    if (p->key != q->key)
        return p->key < q->key ? -1 : 1;
    return (p->group > q->group) - (p->group < q->group);
}

/** Find the groups whose names may be given as tags: no numbers, and no group of another dimension has
 *  them, too. Where numbers are none of the file's, there is nothing but names. */
static void find_named(const io_model *model, const io_group **by_name, io_tags *tags) {
    const int64_t n = model->n_groups;
    for (int64_t i = 0; i < n; i++)
        by_name[i] = &model->group[i];
    qsort(by_name, (size_t)n, sizeof *by_name, compare_names);
    for (int64_t i = 0, end; i < n; i = end) {
        const char *name = by_name[i]->name;
        for (end = i + 1; end < n && strcmp(by_name[end]->name, name) == 0;)
            end++;
        const int is_clear =
            by_name[i]->dim == by_name[end - 1]->dim && !io_tag_parse(name, -1).has_number;
        for (int64_t k = i; k < end && name[0] && (is_clear || model->groups_by_name); k++)
            tags->named[tags->n_named++] =
                (io_named){key_of(by_name[k]->dim, by_name[k]->tag), by_name[k] - model->group};
    }
    qsort(tags->named, (size_t)tags->n_named, sizeof *tags->named, compare_named);
}

/** Return the name of the first group of a number, if it may be given as a tag, or NULL. */
static const char *name_of(const planish_file *file, int dim, int32_t number) {
    const io_named *named = file->tags.named, key = {key_of(dim, number), 0};
    int64_t low = 0, high = file->tags.n_named;
    while (low < high) { /* the first one that is not before the key */
        const int64_t middle = low + (high - low) / 2;
        if (compare_named(&named[middle], &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    const int is_found = low < file->tags.n_named && named[low].key == key.key;
    return is_found ? file->model.group[named[low].group].name : NULL;
}

/* ---- numbers -------------------------------------------------------------------------------- */

static int compare_keys(const void *a, const void *b) {
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/** Collect the numbers of physical groups, sorted. */
static void find_physical(const io_model *model, io_tags *tags) {
    for (int32_t i = 0; i < model->n_entities; i++)
        for (int k = 0; k < model->entity[i].n_physical; k++)
            tags->physical[tags->n_physical++] =
                key_of(model->entity[i].dim, model->entity[i].physical[k]);
    qsort(tags->physical, (size_t)tags->n_physical, sizeof *tags->physical, compare_keys);
}

/** Return whether the number of an entity is one by which it may be given: as a tag a number means the
 *  physical group that has it, if there is one. */
static int has_tag(const planish_file *file, const io_entity *entity) {
    if (entity->n_physical > 0)
        return 1;
    const int64_t key = key_of(entity->dim, entity->tag);
    return !file->model.groups_by_name &&
           !bsearch(&key, file->tags.physical, (size_t)file->tags.n_physical, sizeof key,
                    compare_keys);
}

/* ---- all ------------------------------------------------------------------------------------ */

int io_tags_make(planish_file *file, planish_error *error) {
    const io_model *model = &file->model;
    io_tags *tags = &file->tags;
    int64_t n_physical = 0;
    for (int32_t i = 0; i < model->n_entities; i++)
        n_physical += model->entity[i].n_physical;
    const io_group **by_name = pl_alloc(model->n_groups, sizeof *by_name);
    tags->named = pl_alloc(model->n_groups, sizeof *tags->named);
    tags->physical = pl_alloc(n_physical, sizeof *tags->physical);
    const int has_memory = by_name && tags->named && tags->physical;
    if (has_memory) {
        find_named(model, by_name, tags);
        find_physical(model, tags);
    }
    pl_free(by_name);
    return has_memory ? PLANISH_OK : pl_fail_memory(error, "the tags of regions");
}

void io_tags_free(planish_file *file) {
    pl_free(file->tags.named);
    pl_free(file->tags.physical);
    file->tags = (io_tags){.n_named = 0};
}

/** Put a name as snprintf does: faster, since names may be very long. */
static int put_name(const char *name, char *text, size_t size) {
    const size_t length = strlen(name), n = length < size ? length : size - 1;
    if (size > 0) {
        memcpy(text, name, n);
        text[n] = '\0';
    }
    return (int)length;
}

int planish_file_element_region(const planish_file *file, int64_t element, char *text,
                                size_t size) {
    if (!file || element < 0 || element >= io_model_n_elements(&file->model) || (!text && size > 0))
        return PLANISH_ERROR_ARGUMENT;
    if (size > 0)
        text[0] = '\0';
    const io_model *model = &file->model;
    if (io_element_entity(model, element) < 0)
        return 0;
    const io_entity *entity = &model->entity[io_element_entity(model, element)];
    if (!has_tag(file, entity))
        return 0;
    const int32_t *number = entity->n_physical > 0 ? entity->physical : &entity->tag;
    const int n = entity->n_physical > 0 ? entity->n_physical : 1;
    for (int i = 0; i < n; i++) {
        const char *name = name_of(file, entity->dim, number[i]);
        if (name)
            return put_name(name, text, size);
    }
    return model->groups_by_name ? 0
                                 : snprintf(text, size, "%d:%d", entity->dim,
                                            (int)io_model_file_number(model, number[0]));
}
