/* model: the arrays that readers fill in, and what follows from them. */
#include "io/core/bytes.h"
#include "io/core/model.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "base/system.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CHUNK_NODES = 1 << 16 };

/* ---- threads ------------------------------------------------------------------------------ */

void io_model_set_threads(io_model *model, int threads) {
    model->threads = threads;
    model->process = pl_process_number();
}

int io_model_is_inherited(const io_model *model) {
    return model->process && model->process != pl_process_number();
}

int io_model_threads(const io_model *model) {
    return io_model_is_inherited(model) ? 1 : model->threads;
}

/* ---- nodes -------------------------------------------------------------------------------- */

int io_model_alloc_nodes(io_model *model, int64_t n_nodes, int text, planish_error *error) {
    if (n_nodes > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: %lld nodes are more than the %lld that planish can handle",
                       model->input.path, (long long)n_nodes, (long long)INT32_MAX);
    model->columns = model->columns ? model->columns : 3;
    model->n_nodes = n_nodes;
    model->xyz = pl_alloc(n_nodes, 3 * sizeof *model->xyz);
    model->hold = pl_alloc_zero(n_nodes, sizeof *model->hold);
    if (text)
        model->text_offset = pl_alloc(n_nodes, sizeof *model->text_offset);
    if (!model->xyz || !model->hold || (text && !model->text_offset))
        return pl_fail_memory(error, "the nodes of the file");
    return PLANISH_OK;
}

int io_model_span(io_model *model, io_span span, planish_error *error) {
    return pl_append(&model->span, &model->n_spans, &model->span_capacity, &span, sizeof span)
               ? PLANISH_OK
               : pl_fail_memory(error, "the places of the nodes");
}

static int compare_spans(const void *a, const void *b) {
    const int64_t p = ((const io_span *)a)->offset, q = ((const io_span *)b)->offset;
    return (p > q) - (p < q);
}

void io_model_sort_spans(io_model *model) {
    if (model->n_spans > 1)
        qsort(model->span, (size_t)model->n_spans, sizeof *model->span, compare_spans);
}

int io_model_make_nodes(io_model *model, int64_t n, int size, int64_t stride, int swapped,
                        const char *at, planish_error *error) {
    io_span span = {.n_nodes = n, .encoding = IO_TEXT};
    if (model->is_binary)
        span = (io_span){.n_nodes = n,
                         .encoding = size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                         .swapped = swapped,
                         .offset = at - model->input.data,
                         .stride = stride};
    model->precision = size == 4 ? PLANISH_PRECISION_FLOAT : PLANISH_PRECISION_DOUBLE;
    const int status = io_model_alloc_nodes(model, n, !model->is_binary, error);
    return status ? status : io_model_span(model, span, error);
}

int io_model_pair(io_model *model, const int32_t pair[2], planish_error *error) {
    return pl_append(&model->periodic, &model->n_periodic, &model->periodic_capacity, pair,
                     2 * sizeof *pair)
               ? PLANISH_OK
               : pl_fail_memory(error, "the periodic nodes");
}

/* ---- edits ----------------------------------------------------------------------------------- */

int io_edits_add(io_edits *edits, io_edit edit, planish_error *error) {
    if (pl_append(&edits->edit, &edits->n, &edits->capacity, &edit, sizeof edit))
        return PLANISH_OK;
    pl_free(edit.text);
    return pl_fail_memory(error, "the coordinates to be written");
}

void io_edits_destroy(io_edits *edits) {
    for (int64_t i = 0; i < edits->n; i++)
        pl_free(edits->edit[i].text);
    pl_free(edits->edit);
    *edits = (io_edits){0};
}

/* ---- cells -------------------------------------------------------------------------------- */

/** Give cells of dimension dim mids for that many: those of the first n stay, the others are
 *  missing. */
static int grow_mids(io_cells *cells, int dim, int64_t capacity, planish_error *error) {
    const int64_t n_kept = cells->mid ? cells->n * io_n_mids(dim) : 0;
    int32_t *mid = pl_alloc(capacity * io_n_mids(dim), sizeof *mid);
    if (!mid)
        return pl_fail_memory(error, "the elements of the file");
    for (int64_t i = n_kept; i < capacity * io_n_mids(dim); i++)
        mid[i] = -1;
    if (n_kept > 0)
        memcpy(mid, cells->mid, (size_t)n_kept * sizeof *mid);
    pl_free(cells->mid);
    cells->mid = mid;
    return PLANISH_OK;
}

int io_cells_reserve(io_model *model, int dim, int64_t n, int with_entity, int with_number,
                     planish_error *error) {
    io_cells *cells = io_model_cells(model, dim);
    if (n > INT32_MAX || cells->n + n > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: %lld elements are more than the %lld that planish can handle",
                       model->input.path, (long long)n, (long long)INT32_MAX);
    int64_t needed = cells->n + n, capacity = cells->capacity;
    if (needed <= capacity && cells->nodes)
        return PLANISH_OK;
    int64_t nodes_capacity = capacity, entity_capacity = capacity, number_capacity = capacity;
    size_t size = (size_t)(dim + 1) * sizeof *cells->nodes;
    int32_t *nodes = pl_grow(cells->nodes, cells->n, needed, &nodes_capacity, size);
    if (nodes)
        cells->nodes = nodes;
    int32_t *entity = NULL;
    int64_t *number = NULL;
    if (with_entity &&
        (entity = pl_grow(cells->entity, cells->n, needed, &entity_capacity, sizeof *entity)))
        cells->entity = entity;
    if (with_number &&
        (number = pl_grow(cells->number, cells->n, needed, &number_capacity, sizeof *number)))
        cells->number = number;
    if (!nodes || (with_entity && !entity) || (with_number && !number))
        return pl_fail_memory(error, "the elements of the file");
    if (cells->mid && grow_mids(cells, dim, nodes_capacity, error))
        return PLANISH_ERROR_MEMORY;
    cells->capacity = nodes_capacity;
    return PLANISH_OK;
}

int io_cells_reserve_mids(io_model *model, int dim, planish_error *error) {
    io_cells *cells = io_model_cells(model, dim);
    return cells->mid ? PLANISH_OK : grow_mids(cells, dim, cells->capacity, error);
}

/** Find the format's order of the nodes of a type; NULL: VTK's. */
static const uint8_t *order_of(const io_model *model, int type) {
    for (const io_node_order *order = model->node_order; order && order->type; order++)
        if (order->type == type)
            return order->at;
    return NULL;
}

void io_cells_set_mids(io_model *model, int dim, int64_t cell, const int32_t *nodes) {
    static const uint8_t types[] = {0, PLANISH_CELL_LINE3, PLANISH_CELL_TRIANGLE6,
                                    PLANISH_CELL_TETRAHEDRON10};
    static const uint8_t ends[][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    const uint8_t *at = order_of(model, types[dim]);
    const io_cells *cells = io_model_cells(model, dim);
    const int n = io_n_mids(dim);
    int32_t *mid = cells->mid + cell * n;
    int has_order = at != NULL; /* of corners, as in cells->nodes */
    for (int k = 0; at && k <= dim; k++)
        has_order &= at[k] <= dim;
    for (int k = 0; at && !has_order && k <= dim; k++)
        cells->nodes[cell * (dim + 1) + k] = nodes[at[k]];
    for (int k = 0; k < n; k++) {
        const int a = ends[k][0], b = ends[k][1]; /* corners in VTK's order */
        mid[has_order ? io_edge_of(at[a], at[b]) : k] = nodes[at ? at[dim + 1 + k] : dim + 1 + k];
    }
}

int io_cells_add(io_model *model, int dim, const int32_t *nodes, int32_t entity, int64_t number,
                 planish_error *error) {
    io_cells *cells = io_model_cells(model, dim);
    const int status = io_cells_reserve(model, dim, 1, 1, 1, error);
    if (status)
        return status;
    memcpy(cells->nodes + cells->n * (dim + 1), nodes, (size_t)(dim + 1) * sizeof *nodes);
    cells->entity[cells->n] = entity;
    cells->number[cells->n++] = number;
    return PLANISH_OK;
}

int io_model_add_simplex(io_model *model, int type, const int32_t *nodes, int32_t entity,
                         int64_t number, planish_error *error) {
    const int dim = io_simplex_dim(type), has_mids = io_has_mids(type);
    int status = io_cells_add(model, dim, nodes, entity, number, error);
    if (!status && has_mids)
        status = io_cells_reserve_mids(model, dim, error);
    if (!status && has_mids)
        io_cells_set_mids(model, dim, io_model_cells(model, dim)->n - 1, nodes);
    return status;
}

void io_cells_release(io_cells *cells) {
    pl_free(cells->nodes);
    pl_free(cells->mid);
    pl_free(cells->entity);
    pl_free(cells->number);
    pl_free(cells->region);
    cells->nodes = cells->mid = cells->entity = cells->region = NULL;
    cells->number = NULL;
}

/* ---- entities and groups ------------------------------------------------------------------ */

/** The slot of the entity, or the free one where it belongs. */
static int32_t *find_entity_slot(const io_model *model, int dim, int32_t tag, int n_physical,
                                 const int32_t *physical) {
    const size_t size = (size_t)n_physical * sizeof *physical;
    const uint32_t mask = (uint32_t)model->n_slots - 1;
    pl_hash hash = model->entity_hash;
    pl_hash_add(&hash, (uint64_t)dim << 32 | (uint32_t)tag);
    pl_hash_add_integers(&hash, physical, n_physical);
    for (uint32_t at = (uint32_t)pl_hash_end(hash) & mask;; at = (at + 1) & mask) {
        int32_t *slot = &model->entity_slot[at];
        const io_entity *e = *slot < 0 ? NULL : &model->entity[*slot];
        if (!e || (e->dim == dim && e->tag == tag && e->n_physical == n_physical &&
                   (n_physical == 0 || memcmp(e->physical, physical, size) == 0)))
            return slot;
    }
}

static void fill_entity_slots(io_model *model) {
    for (int32_t i = 0; i < model->n_slots; i++)
        model->entity_slot[i] = -1;
    for (int32_t i = 0; i < model->n_entities; i++) {
        const io_entity *e = &model->entity[i];
        *find_entity_slot(model, e->dim, e->tag, e->n_physical, e->physical) = i;
    }
}

/** Keep the hash table at most half full. */
static int grow_entity_slots(io_model *model, planish_error *error) {
    enum { FIRST_SLOTS = 64 };
    if (2 * (int64_t)model->n_entities < model->n_slots)
        return PLANISH_OK;
    if (model->n_slots > INT32_MAX / 2)
        return pl_fail(error, PLANISH_ERROR_FORMAT, "%s: too many different regions",
                       model->input.path);
    int32_t n_slots = model->n_slots ? 2 * model->n_slots : FIRST_SLOTS;
    int32_t *slot = pl_alloc(n_slots, sizeof *slot);
    if (!slot)
        return pl_fail_memory(error, "the regions of the file");
    pl_free(model->entity_slot);
    model->entity_slot = slot;
    model->entity_hash = pl_hash_draw(slot);
    model->n_slots = n_slots;
    fill_entity_slots(model);
    return PLANISH_OK;
}

int32_t io_model_entity(io_model *model, int dim, int32_t tag, int n_physical,
                        const int32_t *physical, planish_error *error) {
    const int status = grow_entity_slots(model, error);
    if (status)
        return status;
    int32_t *slot = find_entity_slot(model, dim, tag, n_physical, physical);
    if (*slot >= 0)
        return *slot;
    int64_t n = model->n_entities;
    int32_t *copy = pl_alloc(n_physical, sizeof *copy);
    const io_entity entity = {dim, tag, n_physical, copy};
    if (!copy || !pl_append(&model->entity, &n, &model->entity_capacity, &entity, sizeof entity)) {
        pl_free(copy);
        return pl_fail_memory(error, "the regions of the file");
    }
    if (n_physical > 0)
        memcpy(copy, physical, (size_t)n_physical * sizeof *copy);
    return *slot = model->n_entities++;
}

void io_model_clear_entities(io_model *model) {
    int32_t n = 0;
    while (n < model->n_entities && model->entity[n].dim == 0)
        n++;
    for (int32_t i = n; i < model->n_entities; i++)
        pl_free(model->entity[i].physical);
    model->n_entities = n;
    fill_entity_slots(model);
}

int io_model_has_entity(const io_model *model, int dim, int32_t tag) {
    return model->n_slots > 0 && *find_entity_slot(model, dim, tag, 0, NULL) >= 0;
}

int io_model_index_tags(io_model *model, int dim, int32_t *tags, int64_t n, planish_error *error) {
    return io_model_index_tags_but(model, dim, INT64_MIN, tags, n, error);
}

int io_model_index_tags_but(io_model *model, int dim, int64_t none, int32_t *tags, int64_t n,
                            planish_error *error) {
    int32_t tag = 0, entity = -1;
    for (int64_t i = 0; i < n; i++) {
        if (i == 0 || tags[i] != tag) { /* most often tags are one number for long stretches */
            tag = tags[i];
            entity = tag == none ? -1 : io_model_entity(model, dim, tag, 0, NULL, error);
            if (entity < 0 && tag != none)
                return entity;
        }
        tags[i] = entity;
    }
    return PLANISH_OK;
}

int io_model_note_lost(io_model *model, int is_there, const char *what, planish_error *error) {
    return !is_there || io_names_add(&model->not_carried, what, (int64_t)strlen(what))
               ? PLANISH_OK
               : pl_fail_memory(error, "what is not converted");
}

int io_model_group(io_model *model, int dim, int32_t tag, const char *name, int64_t length,
                   planish_error *error) {
    char *copy = pl_alloc(length + 1, 1);
    const io_group group = {dim, tag, copy, 0};
    if (!copy ||
        !pl_append(&model->group, &model->n_groups, &model->group_capacity, &group, sizeof group)) {
        pl_free(copy);
        return pl_fail_memory(error, "the groups of the file");
    }
    memcpy(copy, name, (size_t)length);
    copy[length] = '\0';
    return PLANISH_OK;
}

/* ---- the end --------------------------------------------------------------------------------- */

/* ---- elements of other types ----------------------------------------------------------------- */

/** Make room for n more elements, whose arrays have one capacity. Return 0, or -1 without memory. */
static int grow_others(io_others *o, int64_t n, int with_entity) {
    const int64_t needed = o->n + n;
    int64_t capacity[4] = {o->capacity, o->capacity, o->capacity, o->capacity};
    const int is_first = !o->offset;
    uint8_t *types = pl_grow(o->type, o->n, needed, &capacity[0], sizeof *types);
    o->type = types ? types : o->type;
    int64_t *numbers = pl_grow(o->number, o->n, needed, &capacity[1], sizeof *numbers);
    o->number = numbers ? numbers : o->number;
    int64_t *offsets =
        pl_grow(o->offset, o->n + !is_first, needed + 1, &capacity[2], sizeof *offsets);
    o->offset = offsets ? offsets : o->offset;
    int32_t *entities = NULL;
    if (with_entity)
        entities = pl_grow(o->entity, o->n, needed, &capacity[3], sizeof *entities);
    o->entity = entities ? entities : o->entity;
    if (!types || !numbers || !offsets || (with_entity && !entities))
        return -1;
    if (is_first)
        offsets[0] = 0;
    o->capacity = capacity[0];
    capacity[2]--; /* one more than elements */
    for (int i = 1; i < 3 + (with_entity != 0); i++)
        o->capacity = capacity[i] < o->capacity ? capacity[i] : o->capacity;
    return 0;
}

int io_others_reserve(io_model *model, int dim, int64_t n, int64_t n_nodes, int with_entity,
                      planish_error *error) {
    io_others *o = io_model_others(model, dim);
    if (n > INT32_MAX - o->n)
        return pl_fail(error, PLANISH_ERROR_FORMAT, "%s: more than %d elements", model->input.path,
                       INT32_MAX);
    if ((o->n + n > o->capacity || !o->offset) && grow_others(o, n, with_entity))
        return pl_fail_memory(error, "elements");
    int32_t *node =
        pl_grow(o->node, o->n_nodes, o->n_nodes + n_nodes, &o->node_capacity, sizeof *node);
    if (!node)
        return pl_fail_memory(error, "elements");
    o->node = node;
    return PLANISH_OK;
}

void io_others_set(io_model *model, int64_t i, int64_t begin, int type, const int32_t *nodes,
                   int64_t number) {
    io_others *o = io_model_others(model, io_cell_type_dim(type));
    const int n = io_cell_type_nodes(type);
    const uint8_t *at = order_of(model, type);
    for (int k = 0; k < n; k++)
        o->node[begin + k] = nodes[at ? at[k] : k];
    o->type[i] = (uint8_t)type;
    o->number[i] = number;
    o->offset[i + 1] = begin + n;
}

int io_model_add_other(io_model *model, int type, const int32_t *nodes, int32_t entity,
                       int64_t number, planish_error *error) {
    const int n = io_cell_type_nodes(type), dim = io_cell_type_dim(type);
    io_others *o = io_model_others(model, dim);
    if (n == 0)
        return PLANISH_OK;
    const int status = io_others_reserve(model, dim, 1, n, entity != IO_NO_ENTITY, error);
    if (status)
        return status;
    io_others_set(model, o->n, o->n_nodes, type, nodes, number);
    if (o->entity)
        o->entity[o->n] = entity;
    o->n++;
    o->n_nodes += n;
    return PLANISH_OK;
}

int64_t io_element_number(const io_model *model, int64_t element) {
    const io_cells *cells = io_model_elements(model);
    return element < cells->n ? io_cell_number(cells, element)
                              : io_model_other_elements(model)->number[element - cells->n];
}

/* ---- lists of elements ------------------------------------------------------------------------ */

io_list io_model_list(const io_model *model, int list) {
    if (list >= IO_FLAT_LIST) {
        const io_others *o = list == IO_SOLID_LIST ? &model->solid : &model->flat;
        return (io_list){.dim = list == IO_SOLID_LIST ? 3 : 2,
                         .n = o->n,
                         .entity = o->entity,
                         .region = o->region,
                         .others = o};
    }
    const io_cells *c = list == 3   ? &model->tetrahedron
                        : list == 2 ? &model->triangle
                                    : &model->line;
    return (io_list){.dim = list, .n = c->n, .entity = c->entity, .region = c->region, .cells = c};
}

int32_t **io_model_regions(io_model *model, int list) {
    return list >= IO_FLAT_LIST ? &io_model_others(model, list == IO_SOLID_LIST ? 3 : 2)->region
                                : &io_model_cells(model, list)->region;
}

int64_t io_list_number(const io_list *list, int64_t i) {
    return list->cells ? io_cell_number(list->cells, i) : list->others->number[i];
}

int io_list_all_nodes(const io_list *list, int64_t i, int32_t *node, int *corners) {
    const io_others *o = list->others;
    int n = list->dim + 1, n_mids = 0;
    const int32_t *from, *mid = NULL;
    if (o) {
        from = o->node + o->offset[i];
        n = io_cell_type_corners(o->type[i]);
        n_mids = io_cell_type_nodes(o->type[i]) - n;
        mid = from + n;
    } else {
        from = list->cells->nodes + i * n;
        n_mids = list->cells->mid ? io_n_mids(list->dim) : 0;
        mid = n_mids ? list->cells->mid + i * n_mids : NULL;
    }
    for (int k = 0; k < n; k++)
        node[k] = from[k];
    for (int k = 0; k < n_mids; k++)
        node[n + k] = mid[k];
    if (corners)
        *corners = n;
    return n + n_mids;
}

int io_list_nodes(const io_list *list, int64_t i, int32_t *node, int *corners) {
    const int n_all = io_list_all_nodes(list, i, node, corners);
    int n = 0;
    for (int k = 0; k < n_all; k++)
        if (node[k] >= 0)
            node[n++] = node[k];
    return n;
}

/** Let the elements of a list hold their nodes, mids among them, for reason. */
static void hold_list(io_model *model, int number, uint8_t reason) {
    const io_list list = io_model_list(model, number);
    const int64_t n = list.cells ? io_cells_telling(list.cells) : io_others_telling(list.others);
    for (int64_t i = 0; i < n; i++) {
        int32_t node[IO_CELL_NODES];
        const int n_nodes = io_list_nodes(&list, i, node, NULL);
        for (int k = 0; k < n_nodes; k++)
            model->hold[node[k]] |= reason;
    }
}

void io_model_hold_lower(io_model *model, int dim) {
    hold_list(model, 1, IO_HELD_BY_LINE);
    if (dim == 3) {
        hold_list(model, 2, IO_HELD_BY_FACE);
        hold_list(model, IO_FLAT_LIST, IO_HELD_BY_FACE);
    }
}

void io_others_release(io_others *o) {
    pl_free(o->type);
    pl_free(o->number);
    pl_free(o->offset);
    pl_free(o->entity);
    pl_free(o->region);
    pl_free(o->node);
    *o = (io_others){.n = 0};
}

static void release_files(io_model *model) {
    io_bytes_close(&model->input);
    for (int i = 0; i < model->n_included; i++)
        io_bytes_close(&model->included[i]);
    pl_free(model->included);
    if (model->packed.data)
        io_bytes_close(&model->packed);
    if (model->document.data)
        io_bytes_close(&model->document);
    for (int64_t i = 0; i < model->n_beside; i++)
        pl_free(model->beside[i]);
    pl_free(model->beside);
    io_edits_destroy(&model->input_names);
    for (int i = 0; i < model->n_companions; i++)
        io_bytes_close(&model->companion[i]);
    pl_free(model->companion);
    pl_free(model->folder);
    pl_free(model->inner);
}

static void release_nodes(io_model *model) {
    if (model->coordinates != model->xyz)
        pl_free(model->coordinates);
    pl_free(model->xyz);
    pl_free(model->uv_read);
    pl_free(model->corner);
    pl_free(model->z);
    pl_free(model->node_number);
    pl_free(model->span);
    pl_free(model->text_offset);
    pl_free(model->place_node);
    pl_free(model->place_across);
    pl_free(model->hold);
    pl_free(model->node_entity);
    pl_free(model->periodic);
    pl_free(model->supported);
}

static void release_elements(io_model *model) {
    io_cells_release(&model->line);
    io_cells_release(&model->triangle);
    io_cells_release(&model->tetrahedron);
    io_others_release(&model->flat);
    io_others_release(&model->solid);
}

static void release_groups(io_model *model) {
    for (int32_t i = 0; i < model->n_entities; i++)
        pl_free(model->entity[i].physical);
    pl_free(model->entity);
    pl_free(model->entity_slot);
    for (int32_t i = 0; i < model->n_groups; i++)
        pl_free(model->group[i].name);
    pl_free(model->group);
    pl_free(model->twin);
    io_names_release(&model->strange_groups);
    io_names_release(&model->supported_group);
}

static void release_names(io_model *model) {
    io_names_release(&model->included_name);
    io_names_release(&model->not_carried);
    pl_free(model->type_name);
}

/** Release the arrays that may tell regions, and the notes of data. */
static void release_arrays(io_model *model) {
    for (int i = 0; i < model->n_arrays; i++) {
        pl_free(model->array[i].name);
        pl_free(model->array[i].narrow);
        pl_free(model->array[i].wide);
    }
    pl_free(model->array);
    pl_free(model->array_name);
    pl_free(model->region_name);
    for (int64_t i = 0; i < model->n_data; i++)
        pl_free(model->data[i].name);
    pl_free(model->data);
    io_order_release(&model->data_order);
}

void io_model_destroy(io_model *model) {
    release_files(model);
    release_nodes(model);
    release_elements(model);
    release_groups(model);
    release_arrays(model);
    release_names(model);
    memset(model, 0, sizeof *model);
}

/* ---- checks and errors --------------------------------------------------------------------- */

/** Return the file that a place is in: an included one, or the input. */
static const io_bytes *file_of(const io_model *model, const char *at) {
    const uintptr_t place = (uintptr_t)at;
    for (int i = 0; i < model->n_included; i++) {
        const io_bytes *file = &model->included[i];
        if (place >= (uintptr_t)file->data &&
            place <= (uintptr_t)file->data + (uintptr_t)file->size)
            return file;
    }
    return &model->input;
}

int(io_fail_at)(const io_model *model, const char *at, planish_error *error, const char *format,
                ...) {
    char text[384];
    if (!error)
        return PLANISH_ERROR_FORMAT;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    const io_bytes *file = file_of(model, at);
    if (model->is_binary)
        return pl_fail(error, PLANISH_ERROR_FORMAT, "%s: byte %lld: %s", file->path,
                       (long long)(at - file->data), text);
    int64_t line = 1;
    for (const char *c = file->data; c < at; c++)
        line += *c == '\n' || (*c == '\r' && (c + 1 == at || c[1] != '\n'));
    return pl_fail(error, PLANISH_ERROR_FORMAT, "%s:%lld: %s", file->path, (long long)line, text);
}

int io_check_room(const io_model *model, io_cursor rest, int64_t n, int64_t size, const char *what,
                  planish_error *error) {
    const int64_t left = rest.end - rest.at;
    if (n >= 0 && n <= (left + !model->is_binary) / size)
        return PLANISH_OK;
    return io_fail_at(model, rest.at, error,
                      "%lld %s cannot be in the %lld bytes that are left; the count is wrong or "
                      "the file is cut short",
                      (long long)n, what, (long long)left);
}

int io_check_count(const io_model *model, io_cursor rest, int64_t n, int64_t size, const char *what,
                   planish_error *error) {
    if (n > INT32_MAX && io_check_room(model, rest, n, size, what, NULL) == PLANISH_OK)
        return io_fail_at(model, rest.at, error, "%lld %s are more than planish can number",
                          (long long)n, what);
    return io_check_room(model, rest, n, size, what, error);
}

int io_fail_no_node(const io_model *model, const char *at, const char *what, int64_t element,
                    int64_t node, planish_error *error) {
    return io_fail_at(model, at, error, "%s %lld: there is no node %lld", what, (long long)element,
                      (long long)node);
}

int io_fail_order(const io_model *model, const char *at, const char *what, const char *remedy,
                  planish_error *error) {
    return io_fail_at(model, at, error, "%s: " IO_OF_THIRD_ORDER "%s", what, remedy);
}

int io_fail_infinite(const io_model *model, int64_t node, const char *at, planish_error *error) {
    return io_fail_at(model, at, error, "node %lld has a coordinate that is not finite",
                      (long long)io_node_number(model, node));
}
