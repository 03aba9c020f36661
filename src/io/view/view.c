/* view: the cells, nodes and groups of a mesh that another format is to have. */
#include "io/view/view.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/elements.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- cells --------------------------------------------------------------------------------- */

static const uint8_t list_of_kind[IO_VIEW_KINDS] = {3, 2, 1, IO_SOLID_LIST, IO_FLAT_LIST};

/** Set an element that is no simplex; it is straight where a mid is missing. */
static void set_other(const io_others *others, int64_t i, io_view_cell *cell) {
    const int32_t *from = others->node + others->offset[i];
    const int n = io_cell_type_nodes(others->type[i]);
    const int straight = io_cell_type_straight(others->type[i]),
              n_corners = io_cell_type_nodes(straight);
    int n_there = 0;
    for (int k = 0; k < n; k++)
        n_there += from[k] >= 0;
    cell->type = n_there == n ? others->type[i] : straight;
    cell->n_nodes = io_cell_type_nodes(cell->type);
    cell->loses_mids = n_there < n && n_there > n_corners;
    memcpy(cell->node, from, (size_t)cell->n_nodes * sizeof *from);
}

static void set_simplex(const io_cells *cells, int dim, int64_t i, io_view_cell *cell) {
    const int n_mids = io_n_mids(dim);
    const int32_t *mid = cells->mid ? cells->mid + i * n_mids : NULL;
    int n_there = 0;
    for (int k = 0; mid && k < n_mids; k++)
        n_there += mid[k] >= 0;
    const int has_mids = mid && n_there == n_mids;
    cell->loses_mids = n_there > 0 && !has_mids;
    cell->type = io_simplex_type(dim, has_mids);
    cell->n_nodes = dim + 1 + (has_mids ? n_mids : 0);
    memcpy(cell->node, cells->nodes + i * (dim + 1), (size_t)(dim + 1) * sizeof *mid);
    if (has_mids)
        memcpy(cell->node + dim + 1, mid, (size_t)n_mids * sizeof *mid);
}

void io_view_cell_at(const io_view *view, int64_t index, io_view_cell *cell) {
    const io_model *model = view->model;
    int kind = 0;
    while (index >= view->first[kind + 1])
        kind++;
    const int64_t i = index - view->first[kind];
    const io_list list = io_model_list(model, list_of_kind[kind]);
    if (list.cells)
        set_simplex(list.cells, list.dim, i, cell);
    else
        set_other(list.others, i, cell);
    cell->dim = list.dim;
    cell->entity = list.entity ? list.entity[i] : -1;
    cell->region = list.region         ? list.region[i]
                   : cell->entity >= 0 ? model->entity[cell->entity].tag
                                       : 0;
    cell->number = io_list_number(&list, i);
    cell->element = list.dim != io_model_dim(model) ? -1
                    : list.cells                    ? i
                                                    : io_model_elements(model)->n + i;
}

/* ---- regions ------------------------------------------------------------------------------- */

static int compare_numbers(const void *a, const void *b) {
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

/** Set the bytes of the entities of cells of a dimension, from 1 (none: 0). Returns whether its regions
 *  are entities. */
static int mark_entities(const io_model *model, int dim, uint8_t *mark) {
    int are_entities = 1;
    for (int number = IO_FIRST_LIST; number < IO_N_LISTS; number++) {
        const io_list list = io_model_list(model, number);
        are_entities &= list.dim != dim || !list.region;
        for (int64_t i = 0; list.dim == dim && i < list.n; i++)
            mark[list.entity ? list.entity[i] + 1 : 0] = 1;
    }
    return are_entities;
}

/** Return whether two marked entities have one tag; tag: room for those of all. */
static int share_tags(const io_model *model, const uint8_t *mark, int64_t *tag) {
    int64_t n = 0;
    int shares = 0;
    for (int32_t e = -1; e < model->n_entities; e++)
        if (mark[e + 1])
            tag[n++] = e >= 0 ? model->entity[e].tag : 0;
    qsort(tag, (size_t)n, sizeof *tag, compare_numbers);
    for (int64_t i = 1; i < n; i++)
        shares |= tag[i] == tag[i - 1];
    return shares;
}

/** Find the dimensions whose regions are told by entities, but not by their tags. */
static int look_at_regions(io_view *view, planish_error *error) {
    const int64_t n = (int64_t)view->model->n_entities + 1;
    uint8_t *mark = pl_alloc(n, 1);
    int64_t *tag = pl_alloc(n, sizeof *tag);
    const int status = mark && tag ? PLANISH_OK : pl_fail_memory(error, "regions");
    for (int dim = 1; dim <= 3 && !status; dim++) {
        memset(mark, 0, (size_t)n);
        if (mark_entities(view->model, dim, mark))
            view->shares_tags[dim] = (uint8_t)share_tags(view->model, mark, tag);
    }
    pl_free(mark);
    pl_free(tag);
    return status;
}

int64_t io_view_distinct_region(const io_view *view, const io_view_cell *cell) {
    return view->shares_tags[cell->dim] ? (int64_t)cell->entity + 1 : cell->region;
}

/* ---- cells of a format --------------------------------------------------------------------- */

/* Nodes of the mirror image of a solid: those of its bottom and its top change places, or the bottom
 * goes round the other way. */
static const io_node_order mirrored[] = {
    {PLANISH_CELL_TETRAHEDRON, {1, 0, 2, 3}},
    {PLANISH_CELL_TETRAHEDRON10, {1, 0, 2, 3, 4, 6, 5, 8, 7, 9}},
    {PLANISH_CELL_PYRAMID, {0, 3, 2, 1, 4}},
    {PLANISH_CELL_PYRAMID13, {0, 3, 2, 1, 4, 8, 7, 6, 5, 9, 12, 11, 10}},
    {PLANISH_CELL_PYRAMID14, {0, 3, 2, 1, 4, 8, 7, 6, 5, 9, 12, 11, 10, 13}},
    {PLANISH_CELL_WEDGE, {3, 4, 5, 0, 1, 2}},
    {PLANISH_CELL_WEDGE15, {3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8, 12, 13, 14}},
    {PLANISH_CELL_WEDGE18, {3, 4, 5, 0, 1, 2, 9, 10, 11, 6, 7, 8, 12, 13, 14, 15, 16, 17}},
    {PLANISH_CELL_HEXAHEDRON, {4, 5, 6, 7, 0, 1, 2, 3}},
    {PLANISH_CELL_HEXAHEDRON20,
     {4, 5, 6, 7, 0, 1, 2, 3, 12, 13, 14, 15, 8, 9, 10, 11, 16, 17, 18, 19}},
    {PLANISH_CELL_HEXAHEDRON27, {4,  5,  6,  7,  0,  1,  2,  3,  12, 13, 14, 15, 8, 9,
                                 10, 11, 16, 17, 18, 19, 20, 21, 22, 23, 25, 24, 26}},
    {0, {0}}};

static void reorder(const io_node_order *orders, io_view_cell *cell) {
    int32_t node[IO_CELL_NODES];
    for (const io_node_order *order = orders; order && order->type; order++)
        if (order->type == cell->type) {
            memcpy(node, cell->node, sizeof node);
            for (int k = 0; k < cell->n_nodes; k++)
                cell->node[order->at[k]] = node[k];
            return;
        }
}

void io_view_fit_cell(const io_view *view, const io_view_type *type, const io_node_order *orders,
                      io_view_cell *cell) {
    if (view->is_mirrored[cell->type])
        reorder(mirrored, cell);
    cell->type = type->type;
    cell->n_nodes = cell->dim == 1 ? 2 + io_has_mids(cell->type) : io_cell_type_nodes(cell->type);
    reorder(orders, cell);
}

const io_view_type *io_view_find_type(const io_view_type *table, int type) {
    const int is_line = io_simplex_dim(type) == 1;
    const int types[] = {type, is_line ? type : io_cell_type_without_faces(type),
                         is_line ? PLANISH_CELL_LINE : io_cell_type_straight(type)};
    for (int k = 0; k < 3; k++)
        for (const io_view_type *row = table; row->type; row++)
            if (row->type == types[k])
                return row;
    return NULL;
}

/** Return six times the volume of a solid at its first corner, the way that its nodes go. */
static double corner_volume(const io_view *view, const io_view_cell *cell) {
    const int corners = io_cell_type_corners(cell->type);
    const int at[] = {0, 1, corners == 8 || corners == 5 ? 3 : 2,
                      corners == 8 || corners == 5 ? 4 : 3};
    double x[4][3];
    for (int k = 0; k < 4; k++) {
        io_view_place(view, cell->node[at[k]], x[k]);
        for (int d = 0; d < 3 && k > 0; d++)
            x[k][d] -= x[0][d];
    }
    return x[1][0] * (x[2][1] * x[3][2] - x[2][2] * x[3][1]) +
           x[1][1] * (x[2][2] * x[3][0] - x[2][0] * x[3][2]) +
           x[1][2] * (x[2][0] * x[3][1] - x[2][1] * x[3][0]);
}

/** Find the types whose solids are mostly negative, as TetGen's are. */
static void look_at_volumes(io_view *view) {
    int64_t more[PLANISH_CELL_PYRAMID14 + 1] = {0};
    io_view_cell cell;
    for (int64_t i = 0; i < view->n_cells; i++) {
        io_view_cell_at(view, i, &cell);
        if (cell.dim < 3)
            continue;
        const double volume = corner_volume(view, &cell);
        more[cell.type] += (volume < 0) - (volume > 0);
    }
    for (int type = 0; type <= PLANISH_CELL_PYRAMID14; type++)
        view->is_mirrored[type] = more[type] > 0;
}

/* ---- nodes and numbers --------------------------------------------------------------------- */

void io_view_place(const io_view *view, int64_t node, double place[3]) {
    const io_model *model = view->model;
    for (int d = 0; d < model->written; d++)
        place[d] = view->coordinates[node * model->written + d];
    if (model->written == 2)
        place[2] = model->z ? model->z[node] : 0;
}

int64_t io_view_node_number(const io_view *view, int64_t node) {
    return view->has_numbers[0] ? io_node_number(view->model, node) : node + 1;
}

int64_t io_view_cell_number(const io_view *view, int64_t index, const io_view_cell *cell) {
    return view->has_numbers[1] ? cell->number : index + 1;
}

int io_view_are_numbers(int64_t *number, int64_t n) {
    int is_sorted = 1;
    for (int64_t i = 1; i < n; i++)
        is_sorted &= number[i] > number[i - 1];
    if (!is_sorted)
        qsort(number, (size_t)n, sizeof *number, compare_numbers);
    for (int64_t i = 1; i < n; i++)
        if (number[i] == number[i - 1])
            return 0;
    return n == 0 || (number[0] >= 1 && number[n - 1] <= IO_VIEW_MOST_NUMBER);
}

int io_view_fill_numbers(int64_t *number, int64_t n, planish_error *error) {
    int64_t *used = pl_alloc(n, sizeof *used), at = 0, next = 1;
    if (!used)
        return pl_fail_memory(error, "numbers of groups");
    if (n > 0) {
        memcpy(used, number, (size_t)n * sizeof *used);
        qsort(used, (size_t)n, sizeof *used, compare_numbers);
    }
    for (int64_t i = 0; i < n; i++) {
        if (number[i] != 0)
            continue;
        for (; at < n && used[at] <= next; at++)
            next += used[at] == next;
        number[i] = next++;
    }
    pl_free(used);
    return PLANISH_OK;
}

/** A number, and whose it is. */
typedef struct old_number {
    int64_t number, at;
} old_number;

static int compare_old(const void *a, const void *b) {
    const old_number *x = a, *y = b;
    if (x->number != y->number)
        return x->number < y->number ? -1 : 1;
    return (x->at > y->at) - (x->at < y->at);
}

int io_view_distinct_numbers(int64_t *number, int64_t n, int64_t most, planish_error *error) {
    old_number *old = pl_alloc(n, sizeof *old);
    if (!old)
        return pl_fail_memory(error, "numbers of regions");
    for (int64_t i = 0; i < n; i++)
        old[i] = (old_number){number[i], i};
    if (n > 0)
        qsort(old, (size_t)n, sizeof *old, compare_old);
    for (int64_t i = 0; i < n; i++)
        if (old[i].number < 1 || old[i].number > most ||
            (i > 0 && old[i].number == old[i - 1].number))
            number[old[i].at] = 0;
    pl_free(old);
    return io_view_fill_numbers(number, n, error);
}

/** Find out whether the file's numbers can be kept. */
static int look_at_numbers(io_view *view, planish_error *error) {
    const io_model *model = view->model;
    const int64_t most = model->n_nodes > view->n_cells ? model->n_nodes : view->n_cells;
    int64_t *number = pl_alloc(most, sizeof *number), n = 0;
    if (!number)
        return pl_fail_memory(error, "numbers of nodes and elements");
    for (int64_t i = 0; i < model->n_nodes; i++)
        number[i] = io_node_number(model, i);
    view->has_numbers[0] = io_view_are_numbers(number, model->n_nodes);
    for (int kind = 0; kind < IO_VIEW_KINDS; kind++) {
        const io_list list = io_model_list(model, list_of_kind[kind]);
        for (int64_t i = 0; i < list.n; i++)
            number[n++] = io_list_number(&list, i);
    }
    view->has_numbers[1] = io_view_are_numbers(number, n);
    pl_free(number);
    return PLANISH_OK;
}

/* ---- the view ------------------------------------------------------------------------------ */

int io_view_begin(const io_model *model, const double *coordinates,
                  const planish_convert_options *options, io_view *view, planish_error *error) {
    *view = (io_view){.model = model, .coordinates = coordinates, .options = options};
    for (int kind = 0; kind < IO_VIEW_KINDS; kind++)
        view->first[kind + 1] = view->first[kind] + io_model_list(model, list_of_kind[kind]).n;
    view->n_cells = view->first[IO_VIEW_KINDS];
    look_at_volumes(view);
    int status = look_at_numbers(view, error);
    if (!status)
        status = look_at_regions(view, error);
    return status ? status : io_view_groups_begin(view, error);
}

void io_view_end(io_view *view) {
    io_view_groups_end(view);
}

/* ---- losses -------------------------------------------------------------------------------- */

void io_losses_add(io_losses *losses, const char *format, ...) {
    va_list arguments;
    if (losses->length > 0 && losses->length < sizeof losses->text)
        losses->length += (size_t)snprintf(losses->text + losses->length,
                                           sizeof losses->text - losses->length, ", ");
    va_start(arguments, format);
    if (losses->length < sizeof losses->text)
        losses->length += (size_t)vsnprintf(
            losses->text + losses->length, sizeof losses->text - losses->length, format, arguments);
    va_end(arguments);
}

static void lose_further(int is_lost, io_losses *losses) {
    if (is_lost)
        io_losses_add(losses, "all but the first group of elements that are in several");
}

/** Return whether entities from a dimension on have several numbers of groups. */
static int have_several(const io_model *model, int dim) {
    int several = 0;
    for (int32_t e = 0; e < model->n_entities; e++)
        several |= model->entity[e].dim >= dim && model->entity[e].n_physical > 1;
    return several;
}

void io_view_lose_groups(const io_view *view, io_losses *losses) {
    if (view->model->n_groups > 0)
        io_losses_add(losses, "names of groups");
    lose_further(have_several(view->model, 0), losses);
}

void io_view_lose_ends(const io_model *model, io_losses *losses) {
    int is_cut = 0;
    for (int64_t i = 0; i < model->n_groups; i++)
        is_cut |= strlen(model->group[i].name) > IO_VIEW_MOST_NAME;
    if (is_cut)
        io_losses_add(losses, "the ends of names of more than %d bytes", IO_VIEW_MOST_NAME);
}

void io_view_lose_quotes(const io_model *model, int first_dim, io_losses *losses) {
    int64_t n = 0;
    for (int64_t i = 0; i < model->n_groups; i++) {
        const char *c = model->group[i].name;
        while (*c && *c != '"' && (unsigned char)*c >= ' ')
            c++;
        n += model->group[i].dim >= first_dim && *c;
    }
    if (n > 0)
        io_losses_add(losses,
                      "quotes and control characters (now '_') in the names of %lld group%s",
                      (long long)n, n > 1 ? "s" : "");
}

void io_view_lose_references(const io_view *view, io_losses *losses) {
    const io_model *model = view->model;
    const int has_numbers = model->node_entity && !model->groups_by_name;
    int is_lost = 0;
    for (int64_t i = 0; i < model->n_nodes && has_numbers && !is_lost; i++) {
        const int32_t entity = model->node_entity[i];
        const io_entity *e = entity >= 0 ? &model->entity[entity] : NULL;
        const int is_numbered = e && (e->n_physical > 0 || e->tag != 0);
        is_lost = is_numbered && io_view_next_group(view, entity, -1) < 0;
    }
    if (is_lost)
        io_losses_add(losses, "references of nodes");
}

/** Note groups of nodes, and references of nodes in no named group. */
static void lose_nodes(const io_view *view, io_losses *losses) {
    const io_model *model = view->model;
    int n_of_nodes = 0;
    for (int64_t i = 0; i < model->n_groups; i++)
        n_of_nodes += model->group[i].dim == 0;
    if (n_of_nodes > 0)
        io_losses_add(losses, "groups of nodes");
    io_view_lose_references(view, losses);
}

void io_view_lose_further(const io_view *view, io_losses *losses) {
    lose_nodes(view, losses);
    lose_further(have_several(view->model, 1), losses);
}

void io_view_lose_others(const io_view *view, io_losses *losses) {
    const io_model *model = view->model;
    int several = 0;
    for (int32_t e = 0; e < model->n_entities; e++) {
        const int32_t first = model->entity[e].dim > 0 ? io_view_next_group(view, e, -1) : -1;
        several |= first >= 0 && io_view_next_group(view, e, first) >= 0;
    }
    lose_nodes(view, losses);
    lose_further(several, losses);
    io_view_lose_ends(model, losses);
}

void io_view_lose_numbers(const io_view *view, io_losses *losses) {
    const io_model *model = view->model;
    int is_lost = model->node_number != NULL;
    io_view_cell cell;
    for (int64_t i = 1; i < view->n_cells && !is_lost && view->has_numbers[1]; i++) {
        io_view_cell_at(view, i - 1, &cell);
        const int64_t before = cell.number;
        io_view_cell_at(view, i, &cell);
        is_lost = cell.number != before + 1;
    }
    if (is_lost)
        io_losses_add(losses, "numbers of nodes or elements");
}

void io_view_lose_fields(const io_view *view, io_losses *losses) {
    if (view->n_fields > 0)
        io_losses_add(losses, "data of nodes or elements");
}
