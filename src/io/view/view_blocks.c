/* view_blocks: the cells of a mesh that is written, those of one type and entity together. */
#include "io/view/view_blocks.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>

/** Keys by which cells are sorted. */
typedef struct sorted_cell {
    int8_t dim;
    uint8_t type;
    int32_t entity;
    int64_t region, index;
} sorted_cell;

/** Compare the sets of two cells: their dimension, the highest first, entity and region. */
static int compare_sets(const sorted_cell *x, const sorted_cell *y) {
    if (x->dim != y->dim)
        return x->dim > y->dim ? -1 : 1;
    if (x->entity != y->entity)
        return x->entity < y->entity ? -1 : 1;
    return (x->region > y->region) - (x->region < y->region);
}

static int compare_cells(const void *a, const void *b) {
    const sorted_cell *x = a, *y = b;
    const int sets = compare_sets(x, y);
    if (sets != 0)
        return sets;
    if (x->type != y->type)
        return x->type < y->type ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/** Make the sorted list of all cells: owned; NULL without memory. */
static sorted_cell *sort_cells(const io_view *view) {
    sorted_cell *sorted = pl_alloc(view->n_cells, sizeof *sorted);
    io_view_cell cell;
    int is_sorted = 1;
    for (int64_t i = 0; sorted && i < view->n_cells; i++) {
        io_view_cell_at(view, i, &cell);
        sorted[i] = (sorted_cell){.dim = (int8_t)cell.dim,
                                  .type = (uint8_t)cell.type,
                                  .entity = cell.entity,
                                  .region = cell.region,
                                  .index = i};
        is_sorted &= i == 0 || compare_cells(&sorted[i - 1], &sorted[i]) < 0;
    }
    if (sorted && !is_sorted)
        qsort(sorted, (size_t)view->n_cells, sizeof *sorted, compare_cells);
    return sorted;
}

/** Put a sorted cell into the last block, or begin a new one. Returns 0 without memory. */
static int add_cell(io_view_blocks *blocks, int64_t *capacity, const sorted_cell *cell,
                    const sorted_cell *before) {
    const int is_new_set = !before || compare_sets(before, cell) != 0;
    const io_view_block *last = before ? &blocks->block[blocks->n - 1] : NULL;
    if (is_new_set || before->type != cell->type) {
        const int is_new_dim = !before || before->dim != cell->dim;
        const io_view_block block = {.dim = cell->dim,
                                     .type = cell->type,
                                     .entity = cell->entity,
                                     .region = cell->region,
                                     .set = is_new_dim ? 1 : last->set + is_new_set,
                                     .begins_set = is_new_set,
                                     .cell = blocks->cell +
                                             (last ? last->cell - blocks->cell + last->n : 0)};
        if (!pl_append(&blocks->block, &blocks->n, capacity, &block, sizeof block))
            return 0;
    }
    io_view_block *own = &blocks->block[blocks->n - 1];
    blocks->cell[own->cell - blocks->cell + own->n++] = cell->index;
    return 1;
}

/* ---- numbers of sets ----------------------------------------------------------------------- */

/** A number that a set could have. */
typedef struct candidate {
    int64_t number;
    int dim;
} candidate;

static int compare_candidates(const void *a, const void *b) {
    const candidate *x = a, *y = b;
    if (x->number != y->number)
        return x->number < y->number ? -1 : 1;
    return x->dim - y->dim;
}

/** Return the number of the first group of a block's entity, or of its region. */
static int64_t number_of(const io_view *view, const io_view_block *block, int of_group) {
    const io_entity *e = block->entity >= 0 ? &view->model->entity[block->entity] : NULL;
    const int has_group = of_group && e && e->n_physical > 0 && !view->model->groups_by_name;
    return has_group ? e->physical[0] : block->region;
}

/** Sort the candidates [blocks->n], of which the first *n are those of sets. Return whether these are
 *  distinct numbers of 32 bits within their dimension. */
static int find_candidates(const io_view *view, const io_view_blocks *blocks, int of_group,
                           candidate *all, int64_t *n) {
    int is_good = 1;
    *n = 0;
    for (int64_t b = 0; b < blocks->n; b++)
        if (blocks->block[b].begins_set)
            all[(*n)++] =
                (candidate){number_of(view, &blocks->block[b], of_group), blocks->block[b].dim};
    qsort(all, (size_t)*n, sizeof *all, compare_candidates);
    for (int64_t i = 0; i < *n; i++)
        is_good &= all[i].number >= INT32_MIN && all[i].number <= INT32_MAX &&
                   (i == 0 || compare_candidates(&all[i - 1], &all[i]) != 0);
    return is_good;
}

/** Give the sets their properties: their numbers, those of sets of solids first, or free ones. */
static int give_properties(const io_view *view, io_view_blocks *blocks, int of_group,
                           planish_error *error) {
    int64_t *number = pl_alloc(blocks->n, sizeof *number), n = 0;
    if (!number)
        return pl_fail_memory(error, "blocks of elements");
    for (int64_t b = 0; b < blocks->n; b++)
        if (blocks->block[b].begins_set)
            number[n++] = number_of(view, &blocks->block[b], of_group);
    const int status = io_view_distinct_numbers(number, n, IO_VIEW_MOST_NUMBER, error);
    n = 0;
    for (int64_t b = 0; b < blocks->n && !status; b++) {
        n += blocks->block[b].begins_set;
        blocks->block[b].property = (int32_t)number[n - 1];
    }
    pl_free(number);
    return status;
}

/** Number the sets. */
static int number_sets(const io_view *view, io_view_blocks *blocks, planish_error *error) {
    candidate *all = pl_alloc(blocks->n, sizeof *all);
    int64_t n = 0;
    int of_group = 1, is_good = 0;
    if (!all)
        return pl_fail_memory(error, "blocks of elements");
    while (!(is_good = find_candidates(view, blocks, of_group, all, &n)) && of_group)
        of_group = 0;
    pl_free(all);
    for (int64_t b = 0; b < blocks->n; b++) {
        io_view_block *block = &blocks->block[b];
        block->reference = (int32_t)(is_good ? number_of(view, block, of_group) : block->set);
    }
    return give_properties(view, blocks, of_group, error);
}

/* ---- blocks -------------------------------------------------------------------------------- */

int io_view_blocks_make(const io_view *view, io_view_blocks *blocks, planish_error *error) {
    *blocks = (io_view_blocks){.n = 0};
    int64_t capacity = 0;
    sorted_cell *sorted = sort_cells(view);
    blocks->cell = pl_alloc(view->n_cells, sizeof *blocks->cell);
    int is_done = sorted && blocks->cell;
    for (int64_t i = 0; i < view->n_cells && is_done; i++)
        is_done = add_cell(blocks, &capacity, &sorted[i], i > 0 ? &sorted[i - 1] : NULL);
    pl_free(sorted);
    return is_done ? number_sets(view, blocks, error) : pl_fail_memory(error, "blocks of elements");
}

void io_view_blocks_release(io_view_blocks *blocks) {
    pl_free(blocks->block);
    pl_free(blocks->cell);
    *blocks = (io_view_blocks){.n = 0};
}

/* ---- losses -------------------------------------------------------------------------------- */

int io_view_loses_tag(const io_view *view, const io_view_block *block, int64_t number,
                      int has_names) {
    const io_model *model = view->model;
    const io_entity *e = block->entity >= 0 ? &model->entity[block->entity] : NULL;
    int is_lost = 0;
    if (!e || model->groups_by_name || e->n_physical == 0)
        return 0;
    if (!has_names)
        return io_model_file_number(model, e->physical[0]) != number;
    for (int k = 0; k < e->n_physical; k++)
        is_lost |= io_model_file_number(model, e->physical[k]) != number &&
                   io_view_first_group(view, e->dim, e->physical[k]) < 0;
    return is_lost;
}

int io_view_loses_region(const io_view *view, const io_view_block *block, int64_t number) {
    const io_model *model = view->model;
    const io_entity *e = block->entity >= 0 ? &model->entity[block->entity] : NULL;
    const int is_known = e && !model->groups_by_name && e->n_physical == 0 && e->tag != 0;
    return is_known && e->tag == block->region && io_model_file_number(model, e->tag) != number;
}

void io_view_lose_tags(const io_view *view, const io_view_blocks *blocks, int has_properties,
                       int has_names, io_losses *losses) {
    int is_lost = 0, is_changed = 0;
    for (int64_t b = 0; b < blocks->n; b++) {
        const io_view_block *block = &blocks->block[b];
        const int32_t number = has_properties ? block->property : block->reference;
        is_lost |= io_view_loses_tag(view, block, number, has_names);
        is_changed |= io_view_loses_region(view, block, number);
    }
    if (is_lost)
        io_losses_add(losses, "numbers of groups");
    if (is_changed)
        io_losses_add(losses, "numbers of regions");
}

void io_view_lose_types(const io_view_type *table, const io_view_blocks *blocks,
                        io_losses *losses) {
    int64_t n_cut = 0, n_gone = 0;
    for (int64_t b = 0; b < blocks->n; b++) {
        const io_view_type *row = io_view_find_type(table, blocks->block[b].type);
        n_gone += row ? 0 : blocks->block[b].n;
        n_cut += row && row->type != blocks->block[b].type ? blocks->block[b].n : 0;
    }
    if (n_cut > 0)
        io_losses_add(losses, "nodes of %lld elements besides their corners or mids",
                      (long long)n_cut);
    if (n_gone > 0)
        io_losses_add(losses, "%lld elements", (long long)n_gone);
}
