/* gmsh_copies: an element in several physical groups stands in a MSH 2 file once for each of them,
 * under different numbers. The first is kept, in all of these groups, as MSH 4 would have it;
 * otherwise it would overlap itself and its nodes would lie between regions.
 *
 * Elements that are repeated in the same group are no such copies and stay.
 */
#include "io/gmsh/gmsh_sections.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"

enum { CORNERS = 8, DROPPED = -1 };

/** An element of an entity that other physical groups share. */
typedef struct copy_candidate {
    int32_t corner[CORNERS]; /* rising; those that are not there: -1 */
    int32_t tag;             /* elementary entity */
    int32_t physical;        /* its group, 0: none */
    int32_t cell;
} copy_candidate;

static int compare_candidates(const void *left, const void *right) {
    const copy_candidate *a = left, *b = right;
    for (int i = 0; i < CORNERS; i++)
        if (a->corner[i] != b->corner[i])
            return a->corner[i] < b->corner[i] ? -1 : 1;
    if (a->tag != b->tag)
        return a->tag < b->tag ? -1 : 1;
    if (a->physical != b->physical)
        return a->physical < b->physical ? -1 : 1;
    return (a->cell > b->cell) - (a->cell < b->cell);
}

static copy_candidate make_candidate(const io_model *model, const io_list *list, int64_t cell) {
    const io_entity *entity = &model->entity[list->entity[cell]];
    copy_candidate made = {.tag = entity->tag, .cell = (int32_t)cell};
    int32_t nodes[IO_CELL_NODES];
    int corners;
    io_list_nodes(list, cell, nodes, &corners);
    made.physical = entity->n_physical > 0 ? entity->physical[0] : 0;
    for (int i = 0; i < CORNERS; i++) {
        int32_t node = i < corners ? nodes[i] : -1;
        int k = i;
        for (; k > 0 && made.corner[k - 1] > node; k--)
            made.corner[k] = made.corner[k - 1];
        made.corner[k] = node;
    }
    return made;
}

/** Make one element of n candidates with the same nodes, in all their physical groups. Of each
 *  group the first cell is dropped, but for the first cell of all. group: room for n numbers. */
static int merge_copies(io_model *model, const io_list *list, const copy_candidate *copy, int64_t n,
                        int32_t *group, planish_error *error) {
    int n_groups = 0;
    int32_t first = copy[0].cell;
    if (copy[0].physical == copy[n - 1].physical)
        return PLANISH_OK;
    for (int64_t i = 1; i < n; i++)
        first = copy[i].cell < first ? copy[i].cell : first;
    for (int64_t i = 0; i < n; i++) {
        if (i > 0 && copy[i].physical == copy[i - 1].physical)
            continue;
        if (copy[i].physical != 0)
            group[n_groups++] = copy[i].physical;
        if (copy[i].cell != first)
            list->entity[copy[i].cell] = DROPPED;
    }
    const int32_t entity = io_model_entity(model, list->dim, copy[0].tag, n_groups, group, error);
    for (int64_t i = 0; i < n && entity >= 0; i++)
        if (list->entity[copy[i].cell] != DROPPED)
            list->entity[copy[i].cell] = entity;
    return entity < 0 ? entity : PLANISH_OK;
}

/** Close the gaps that dropped cells leave. */
static void compact(io_cells *cells, int corners) {
    const int mids = io_n_mids(corners - 1);
    int64_t n = 0;
    for (int64_t i = 0; i < cells->n; i++) {
        if (cells->entity[i] == DROPPED)
            continue;
        memmove(cells->nodes + n * corners, cells->nodes + i * corners,
                (size_t)corners * sizeof *cells->nodes);
        if (cells->mid)
            memmove(cells->mid + n * mids, cells->mid + i * mids,
                    (size_t)mids * sizeof *cells->mid);
        cells->entity[n] = cells->entity[i];
        cells->number[n] = cells->number[i];
        n++;
    }
    cells->n = n;
}

/** Remove the dropped elements of other types. */
static void compact_others(io_model *model, int dim) {
    io_others *o = io_model_others(model, dim);
    int64_t n = 0, n_nodes = 0, begin = 0;
    for (int64_t i = 0; i < o->n; i++) {
        const int64_t from = begin, length = o->offset[i + 1] - from;
        begin = o->offset[i + 1];
        if (o->entity[i] == DROPPED)
            continue;
        memmove(o->node + n_nodes, o->node + from, (size_t)length * sizeof *o->node);
        n_nodes += length;
        o->type[n] = o->type[i];
        o->entity[n] = o->entity[i];
        o->number[n] = o->number[i];
        o->offset[++n] = n_nodes;
    }
    model->n_other -= o->n - n;
    o->n = n;
    o->n_nodes = n_nodes;
}

static int merge_list(io_model *model, int number, const uint8_t *shared, planish_error *error) {
    const io_list list = io_model_list(model, number);
    int64_t n = 0;
    for (int64_t i = 0; i < list.n; i++)
        n += shared[list.entity[i]];
    if (n == 0)
        return PLANISH_OK;
    copy_candidate *candidate = pl_alloc(n, sizeof *candidate);
    int32_t *group = pl_alloc(n, sizeof *group);
    int status = candidate && group ? PLANISH_OK : pl_fail_memory(error, "the elements");
    if (!status) {
        int64_t filled = 0;
        for (int64_t i = 0; i < list.n; i++)
            if (shared[list.entity[i]])
                candidate[filled++] = make_candidate(model, &list, i);
        qsort(candidate, (size_t)n, sizeof *candidate, compare_candidates);
        for (int64_t begin = 0, end; !status && begin < n; begin = end) {
            const copy_candidate *first = &candidate[begin];
            for (end = begin + 1;
                 end < n && candidate[end].tag == first->tag &&
                 memcmp(candidate[end].corner, first->corner, sizeof first->corner) == 0;)
                end++;
            if (end - begin > 1)
                status = merge_copies(model, &list, first, end - begin, group, error);
        }
        if (list.cells)
            compact(io_model_cells(model, list.dim), list.dim + 1);
        else
            compact_others(model, list.dim);
    }
    pl_free(candidate);
    pl_free(group);
    return status;
}

int gmsh2_merge_copies(gmsh_reader *reader) {
    io_model *model = reader->model;
    const int32_t n = model->n_entities;
    int any = 0, status = PLANISH_OK;
    uint8_t *shared = pl_alloc_zero(n, sizeof *shared); /* 1: another entity has its tag, too */
    gmsh_entity *list = pl_alloc(n, sizeof *list);
    if (!shared || !list)
        status = pl_fail_memory(reader->error, "the elements' tags");
    for (int32_t i = 0; i < n && !status; i++)
        list[i] = (gmsh_entity){model->entity[i].dim, model->entity[i].tag, i, 0};
    if (n > 0 && !status)
        qsort(list, (size_t)n, sizeof *list, gmsh_compare_entities);
    for (int32_t i = 1; i < n && !status; i++) {
        if (gmsh_compare_entities(&list[i - 1], &list[i]))
            continue;
        shared[list[i - 1].index] = shared[list[i].index] = 1;
        any = 1;
    }
    for (int k = IO_FIRST_LIST + 1; k < IO_N_LISTS && any && !status; k++)
        status = merge_list(model, k, shared, reader->error);
    pl_free(list);
    pl_free(shared);
    return status;
}
