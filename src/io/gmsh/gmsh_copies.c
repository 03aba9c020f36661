/* gmsh_copies: an element in several physical groups stands in a MSH 2 file once for each of them,
 * under different numbers. The first is kept, in all of these groups, as MSH 4 would have it;
 * otherwise it would overlap itself and its nodes would lie between regions.
 *
 * Elements that are repeated in the same group are no such copies and stay.
 */
#include "io/gmsh/gmsh_reader.h"

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

static int same_element(const copy_candidate *a, const copy_candidate *b) {
    return a->tag == b->tag && memcmp(a->corner, b->corner, sizeof a->corner) == 0;
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

/* ---- entities in several groups ----------------------------------------------------------- */

typedef struct named_entity {
    int dim;
    int32_t tag, entity;
} named_entity;

static int compare_entities(const void *left, const void *right) {
    const named_entity *a = left, *b = right;
    if (a->dim != b->dim)
        return a->dim < b->dim ? -1 : 1;
    return (a->tag > b->tag) - (a->tag < b->tag);
}

/** shared [n_entities]: 1 where another entity has the same dimension and tag; *any: whether one
 * is.
 */
static int find_shared(const io_model *model, uint8_t *shared, int *any, planish_error *error) {
    int32_t n = model->n_entities;
    named_entity *list = pl_alloc(n, sizeof *list);
    if (!list)
        return pl_fail_memory(error, "the elements' tags");
    for (int32_t i = 0; i < n; i++)
        list[i] = (named_entity){model->entity[i].dim, model->entity[i].tag, i};
    if (n > 0)
        qsort(list, (size_t)n, sizeof *list, compare_entities);
    *any = 0;
    for (int32_t i = 1; i < n; i++) {
        if (compare_entities(&list[i - 1], &list[i]))
            continue;
        shared[list[i - 1].entity] = shared[list[i].entity] = 1;
        *any = 1;
    }
    pl_free(list);
    return 0;
}

/* ---- copies ------------------------------------------------------------------------------- */

/** The physical groups of n candidates (one element and its copies): rising, and the number of them
 * returned. Of each group the first cell is dropped, but for the first cell of all. */
static int gather_groups(io_cells *cells, const copy_candidate *copy, int64_t n, int32_t *group) {
    int n_groups = 0;
    int32_t first = copy[0].cell;
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
    return n_groups;
}

/** Make one element of n candidates with the same nodes. group: room for n numbers. */
static int merge(io_model *model, io_cells *cells, int dim, const copy_candidate *copy, int64_t n,
                 int32_t *group, planish_error *error) {
    if (copy[0].physical == copy[n - 1].physical)
        return 0;
    int n_groups = gather_groups(cells, copy, n, group);
    int32_t entity = io_model_entity(model, dim, copy[0].tag, n_groups, group, error);
    if (entity < 0)
        return entity;
    for (int64_t i = 0; i < n; i++)
        if (cells->entity[copy[i].cell] != DROPPED)
            cells->entity[copy[i].cell] = entity;
    return 0;
}

static int merge_all(io_model *model, io_cells *cells, int dim, copy_candidate *candidate,
                     int64_t n, int32_t *group, planish_error *error) {
    int status = 0;
    qsort(candidate, (size_t)n, sizeof *candidate, compare_candidates);
    for (int64_t begin = 0, end; !status && begin < n; begin = end) {
        for (end = begin + 1; end < n && same_element(&candidate[begin], &candidate[end]);)
            end++;
        if (end - begin > 1)
            status = merge(model, cells, dim, candidate + begin, end - begin, group, error);
    }
    return status;
}

/** Close the gaps that dropped cells leave. */
static void compact(io_cells *cells, int corners) {
    int64_t n = 0;
    for (int64_t i = 0; i < cells->n; i++) {
        if (cells->entity[i] == DROPPED)
            continue;
        memmove(cells->nodes + n * corners, cells->nodes + i * corners,
                (size_t)corners * sizeof *cells->nodes);
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
        return 0;
    copy_candidate *candidate = pl_alloc(n, sizeof *candidate);
    int32_t *group = pl_alloc(n, sizeof *group);
    int status = !candidate || !group ? pl_fail_memory(error, "the elements") : 0;
    if (!status) {
        int64_t filled = 0;
        for (int64_t i = 0; i < cells->n; i++)
            if (shared[cells->entity[i]])
                candidate[filled++] = make_candidate(model, cells, dim + 1, i);
        status = merge_all(model, cells, dim, candidate, n, group, error);
        compact(cells, dim + 1);
    }
    pl_free(candidate);
    pl_free(group);
    return status;
}

int gmsh2_merge_copies(gmsh_reader *reader) {
    io_model *model = reader->model;
    int any = 0;
    uint8_t *shared = pl_alloc_zero(model->n_entities, sizeof *shared);
    if (!shared)
        return pl_fail_memory(reader->error, "the elements' tags");
    int status = find_shared(model, shared, &any, reader->error);
    if (!status && any)
        status = merge_cells(model, &model->triangle, 2, shared, reader->error);
    if (!status && any)
        status = merge_cells(model, &model->tetrahedron, 3, shared, reader->error);
    pl_free(shared);
    return status;
}
