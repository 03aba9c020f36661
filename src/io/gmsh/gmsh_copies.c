/* gmsh_copies: an element in several physical groups stands in a MSH 2 file once for each of them,
 * under different numbers. The first is kept, in all of these groups, as MSH 4 would have it;
 * otherwise it would overlap itself and its nodes would lie between regions.
 *
 * Elements that are repeated in the same group are no such copies and stay. Elements of model->other
 * have no groups: where others have copies, they are not repeated.
 */
#include "io/gmsh/gmsh_sections.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"

enum { CORNERS = 4, DROPPED = -1 };

/** A cell of an entity that other physical groups share. */
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

static copy_candidate make_candidate(const io_model *model, const io_cells *cells, int corners,
                                     int64_t cell) {
    const io_entity *entity = &model->entity[cells->entity[cell]];
    copy_candidate made = {.tag = entity->tag, .cell = (int32_t)cell};
    made.physical = entity->n_physical > 0 ? entity->physical[0] : 0;
    for (int i = 0; i < CORNERS; i++) {
        int32_t node = i < corners ? cells->nodes[cell * corners + i] : -1;
        int k = i;
        for (; k > 0 && made.corner[k - 1] > node; k--)
            made.corner[k] = made.corner[k - 1];
        made.corner[k] = node;
    }
    return made;
}

/** Make one element of n candidates with the same nodes, in all their physical groups. Of each
 *  group the first cell is dropped, but for the first cell of all. group: room for n numbers. */
static int merge_copies(io_model *model, io_cells *cells, int dim, const copy_candidate *copy,
                        int64_t n, int32_t *group, planish_error *error) {
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
            cells->entity[copy[i].cell] = DROPPED;
    }
    const int32_t entity = io_model_entity(model, dim, copy[0].tag, n_groups, group, error);
    for (int64_t i = 0; i < n && entity >= 0; i++)
        if (cells->entity[copy[i].cell] != DROPPED)
            cells->entity[copy[i].cell] = entity;
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

static int merge_cells(io_model *model, io_cells *cells, int dim, const uint8_t *shared,
                       planish_error *error) {
    int64_t n = 0;
    for (int64_t i = 0; i < cells->n; i++)
        n += shared[cells->entity[i]];
    if (n == 0)
        return PLANISH_OK;
    copy_candidate *candidate = pl_alloc(n, sizeof *candidate);
    int32_t *group = pl_alloc(n, sizeof *group);
    int status = candidate && group ? PLANISH_OK : pl_fail_memory(error, "the elements");
    if (!status) {
        int64_t filled = 0;
        for (int64_t i = 0; i < cells->n; i++)
            if (shared[cells->entity[i]])
                candidate[filled++] = make_candidate(model, cells, dim + 1, i);
        qsort(candidate, (size_t)n, sizeof *candidate, compare_candidates);
        for (int64_t begin = 0, end; !status && begin < n; begin = end) {
            const copy_candidate *first = &candidate[begin];
            for (end = begin + 1;
                 end < n && candidate[end].tag == first->tag &&
                 memcmp(candidate[end].corner, first->corner, sizeof first->corner) == 0;)
                end++;
            if (end - begin > 1)
                status = merge_copies(model, cells, dim, first, end - begin, group, error);
        }
        compact(cells, dim + 1);
    }
    pl_free(candidate);
    pl_free(group);
    return status;
}

/** An element of model->other. */
typedef struct other_candidate {
    const int32_t *node; /* [n] borrowed */
    int n;
    int32_t index;
} other_candidate;

static int compare_others(const void *left, const void *right) {
    const other_candidate *a = left, *b = right;
    if (a->n != b->n)
        return a->n < b->n ? -1 : 1;
    for (int i = 0; i < a->n; i++)
        if (a->node[i] != b->node[i])
            return a->node[i] < b->node[i] ? -1 : 1;
    return (a->index > b->index) - (a->index < b->index);
}

/** Close the gaps that dropped elements of model->other leave. */
static void compact_others(io_model *model, const uint8_t *is_dropped) {
    io_others *o = &model->other;
    int64_t n = 0, n_nodes = 0, begin = 0;
    for (int64_t i = 0; i < o->n; i++) {
        const int64_t from = begin, length = o->offset[i] - from;
        begin = o->offset[i];
        if (is_dropped[i])
            continue;
        memmove(o->node + n_nodes, o->node + from, (size_t)length * sizeof *o->node);
        n_nodes += length;
        o->type[n] = o->type[i];
        o->number[n] = o->number[i];
        o->offset[n++] = n_nodes;
    }
    model->n_other -= o->n - n;
    o->n = n;
    o->n_nodes = n_nodes;
}

/** Keep the first of elements of model->other that have the same nodes in the same order, whatever
 *  their groups, as these have no entities. */
static int merge_others(io_model *model, planish_error *error) {
    const io_others *o = &model->other;
    if (o->n == 0)
        return PLANISH_OK;
    other_candidate *candidate = pl_alloc(o->n, sizeof *candidate);
    uint8_t *is_dropped = pl_alloc_zero(o->n, sizeof *is_dropped);
    const int status = candidate && is_dropped ? PLANISH_OK : pl_fail_memory(error, "the elements");
    if (!status) {
        for (int64_t i = 0; i < o->n; i++) {
            const int64_t begin = i > 0 ? o->offset[i - 1] : 0;
            candidate[i] =
                (other_candidate){o->node + begin, (int)(o->offset[i] - begin), (int32_t)i};
        }
        qsort(candidate, (size_t)o->n, sizeof *candidate, compare_others);
        for (int64_t i = 1; i < o->n; i++) {
            const other_candidate *a = &candidate[i - 1], *b = &candidate[i];
            is_dropped[b->index] = a->n == b->n && o->type[a->index] == o->type[b->index] &&
                                   memcmp(a->node, b->node, (size_t)a->n * sizeof *a->node) == 0;
        }
        compact_others(model, is_dropped);
    }
    pl_free(candidate);
    pl_free(is_dropped);
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
    for (int dim = 2; dim < 4 && any && !status; dim++)
        status = merge_cells(model, io_model_cells(model, dim), dim, shared, reader->error);
    if (any && !status)
        status = merge_others(model, reader->error);
    pl_free(list);
    pl_free(shared);
    return status;
}
