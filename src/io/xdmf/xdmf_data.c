/* xdmf_data: attributes of nodes and cells of an XDMF file. Of a series in time those of the first
 * step count.
 */
#include "io/xdmf/xdmf.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/arrays.h"
#include "io/core/data.h"

#include <string.h>
#include <strings.h>

/** An attribute of a piece. */
typedef struct xdmf_array {
    const char *name;
    int of_cells;
    int64_t element;
} xdmf_array;

/** All attributes of a piece that have a name, each once. */
typedef struct xdmf_arrays {
    xdmf_array *array; /* [n] owned */
    int64_t n, capacity;
    io_order order;
} xdmf_arrays;

static int compare_arrays(const void *key, const void *list, int64_t index) {
    const xdmf_array *a = key, *b = (const xdmf_array *)list + index;
    return a->of_cells != b->of_cells ? a->of_cells - b->of_cells : strcmp(a->name, b->name);
}

static const xdmf_array *find_array(const xdmf_arrays *list, const char *name, int of_cells) {
    const xdmf_array key = {.name = name, .of_cells = of_cells};
    int64_t place;
    const int64_t i = io_order_find(&list->order, &key, list->array, compare_arrays, &place);
    return i < 0 ? NULL : &list->array[i];
}

static void release_arrays(xdmf_arrays *list) {
    pl_free(list->array);
    io_order_release(&list->order);
}

/** Add an array to a list, unless it is there or the list is full. */
static int enter_array(xdmf_reader *r, xdmf_array array, xdmf_arrays *list) {
    int64_t place;
    if (list->n == IO_MOST_DATA ||
        io_order_find(&list->order, &array, list->array, compare_arrays, &place) >= 0)
        return PLANISH_OK;
    return pl_append(&list->array, &list->n, &list->capacity, &array, sizeof array) &&
                   io_order_insert(&list->order, place, list->n - 1)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the names of arrays");
}

/** Add an Attribute element, if it is of nodes or cells. */
static int add_array(xdmf_reader *r, int64_t element, xdmf_arrays *list) {
    const xdmf_document *d = &r->document;
    const char *center = xdmf_attribute(d, element, "Center");
    const xdmf_array array = {.name = xdmf_attribute(d, element, "Name"),
                              .of_cells = center && strcasecmp(center, "Cell") == 0,
                              .element = element};
    if (!array.name || (center && !array.of_cells && strcasecmp(center, "Node") != 0))
        return PLANISH_OK;
    return enter_array(r, array, list);
}

static int list_arrays(xdmf_reader *r, const xdmf_piece *piece, xdmf_arrays *list) {
    int status = PLANISH_OK;
    list->n = 0;
    for (int64_t i = 0; i < piece->grids.n && !status; i++) {
        xdmf_list elements = {0};
        status = xdmf_children(&r->document, piece->grids.element[i], "Attribute", &elements);
        for (int64_t k = 0; k < elements.n && !status; k++) {
            int64_t element;
            status = xdmf_resolve(&r->document, elements.element[k], &element);
            if (!status)
                status = add_array(r, element, list);
        }
        pl_free(elements.element);
    }
    return status;
}

/** Find the numbers of an attribute, and how many each of n has. */
static int find_values(xdmf_reader *r, const xdmf_array *array, int64_t n, xdmf_item *item,
                       int64_t *width) {
    xdmf_item items[XDMF_MOST_ITEMS] = {{.n = -1}};
    int n_items = 0;
    int64_t there = 0;
    int status = xdmf_items_in(r, array->element, items, &n_items);
    if (!status && n_items != 1)
        status = xdmf_fail(&r->document, array->element, "one DataItem was expected in it");
    if (!status)
        status = xdmf_check_count(r, &items[0], &there);
    if (!status && (n <= 0 || there % n || there == 0))
        status = xdmf_fail(&r->document, array->element, "it has %lld numbers for %lld %s",
                           (long long)there, (long long)n, array->of_cells ? "cells" : "nodes");
    *item = items[0];
    *width = status ? 0 : there / n;
    return status;
}

/** Read an attribute of n as real numbers: *values [n][*width], owned by the caller. */
static int read_values(xdmf_reader *r, const xdmf_array *array, int64_t n, int64_t *width,
                       double **values) {
    xdmf_item item;
    *values = NULL;
    int status = find_values(r, array, n, &item, width);
    if (!status && !(*values = pl_alloc(n * *width, sizeof **values)))
        status = pl_fail_memory(r->error, "an array of the file");
    return status ? status : xdmf_reals(r, &item, n * *width, *values);
}

/** Data that cannot be read are left out, where nothing needs them. */
static int forgive(xdmf_reader *r, int status) {
    if (status != PLANISH_ERROR_FORMAT && status != PLANISH_ERROR_FILE)
        return status;
    if (r->error)
        *r->error = (planish_error){.code = PLANISH_OK};
    return PLANISH_OK;
}

/* ---- nodes that are held, and regions -------------------------------------------------------- */

static int hold_nodes(xdmf_reader *r, const xdmf_geometry *g, const xdmf_array *array) {
    double *values = NULL;
    int64_t width = 0;
    const int status = read_values(r, array, g->n_nodes, &width, &values);
    for (int64_t i = 0; i < g->n_nodes * width && !status; i++)
        if (values[i] != 0)
            io_hold_node(r->model, g->first_node + i / width, IO_HELD_MARKED);
    pl_free(values);
    return status;
}

/** Return whether a piece has elements that are smoothed, or values for some. */
static int has_elements(const xdmf_reader *r, const xdmf_piece *piece) {
    return piece->map || piece->n_of[io_model_dim(r->model)] > 0;
}

/** Copy values [n][width] of a piece's cells to those of all cells. */
static void place_cells(const xdmf_piece *piece, const double *values, int64_t width, double *all) {
    for (int64_t i = 0; i < piece->n; i++)
        memcpy(all + (piece->map ? piece->map[i] : piece->first_cell + i) * width,
               values + i * width, (size_t)width * sizeof *values);
}

/** Read the values of one piece's cells to those of all. *is_broken: they tell no regions. */
static int read_cells(xdmf_reader *r, const xdmf_piece *piece, const xdmf_array *array, double *all,
                      int *is_broken) {
    const int is_needed = has_elements(r, piece);
    double *values = NULL;
    int64_t width = 0;
    int status = read_values(r, array, piece->n, &width, &values);
    if (!status && width == 1)
        place_cells(piece, values, 1, all);
    *is_broken |= is_needed && (status || width != 1);
    pl_free(values);
    return is_needed && planish_rank_region_name(array->name) > 0 ? status : forgive(r, status);
}

/** Find the attribute of cells that stands for one of that name in a piece: of lines and facets it may
 *  have another name. */
static const xdmf_array *find_like(const xdmf_reader *r, const xdmf_piece *piece,
                                   const xdmf_arrays *list, const char *name) {
    const xdmf_array *array = find_array(list, name, 1);
    for (int64_t i = 0; i < list->n && !array && !has_elements(r, piece); i++)
        array = list->array[i].of_cells ? &list->array[i] : NULL;
    return array;
}

/** Read the values of all cells for the array called name: 0 where a cell has none. Pieces whose
 *  elements have a map to those of others need not have it. */
static int read_all_cells(xdmf_reader *r, const xdmf_mesh *m, const xdmf_arrays *lists,
                          const char *name, double *all, int *is_broken) {
    int status = PLANISH_OK, is_tag = 0;
    for (int64_t k = 0; k < m->n_pieces; k++)
        is_tag |= m->piece[k].map && find_array(&lists[k], name, 1);
    for (int64_t k = 0; k < m->n_pieces && !status && !*is_broken; k++) {
        const xdmf_piece *piece = &m->piece[k];
        const xdmf_array *array = find_like(r, piece, &lists[k], name);
        if (array && piece->n > 0)
            status = read_cells(r, piece, array, all, is_broken);
        else
            *is_broken |= !is_tag && !piece->map && has_elements(r, piece);
    }
    return status;
}

/** Read an array of all cells that may tell regions. */
static int read_region(xdmf_reader *r, const xdmf_mesh *m, const xdmf_arrays *lists,
                       const char *name) {
    io_array_filler filler;
    int is_broken = 0;
    double *all = pl_alloc_zero(m->n_cells, sizeof *all);
    int status = all ? io_array_begin(r->model, name, m->n_cells, &filler, r->error)
                     : pl_fail_memory(r->error, "an array of the file");
    if (status) {
        pl_free(all);
        return status;
    }
    status = read_all_cells(r, m, lists, name, all, &is_broken);
    filler.is_broken |= is_broken;
    for (int64_t i = 0; i < m->n_cells && !status && !filler.is_broken; i++) {
        int64_t value = 0;
        const int is_whole = io_array_whole(all[i], &value);
        status = io_array_put(&filler, i, is_whole, value, r->error);
    }
    pl_free(all);
    if (!status)
        return io_array_end(r->model, &filler, r->error);
    io_array_drop(&filler);
    return status;
}

/** Read the arrays of one number for each cell of a piece with elements. */
static int read_regions(xdmf_reader *r, const xdmf_mesh *m, const xdmf_arrays *lists) {
    xdmf_arrays seen = {.n = 0};
    int status = PLANISH_OK;
    for (int64_t k = 0; k < m->n_pieces && !status; k++)
        for (int64_t i = 0; i < lists[k].n && seen.n < IO_MOST_ARRAYS && !status; i++) {
            const xdmf_array *array = &lists[k].array[i];
            xdmf_item item;
            int64_t width = 0;
            if (!array->of_cells || !has_elements(r, &m->piece[k]) ||
                find_array(&seen, array->name, 1))
                continue;
            status = forgive(r, find_values(r, array, m->piece[k].n, &item, &width));
            if (!status && width == 1)
                status = read_region(r, m, lists, array->name);
            if (!status)
                status = enter_array(r, *array, &seen);
        }
    release_arrays(&seen);
    return status;
}

/** Note the arrays of a piece that nobody has noted: those that can be read. */
static int note_arrays(xdmf_reader *r, const xdmf_mesh *m, const xdmf_piece *piece,
                       const xdmf_arrays *list) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < list->n && !status; i++) {
        const xdmf_array *a = &list->array[i];
        const int64_t n = a->of_cells ? piece->n : m->geometry[piece->geometry].n_nodes;
        xdmf_item item;
        int64_t width = 0;
        if ((a->of_cells && !has_elements(r, piece)) ||
            (!a->of_cells && strcmp(a->name, "fixed") == 0) ||
            io_data_find(r->model, a->name, a->of_cells))
            continue;
        status = forgive(r, find_values(r, a, n, &item, &width));
        if (!status && width > 0)
            status = io_data_note(r->model,
                                  (io_data){.name = (char *)(uintptr_t)a->name,
                                            .of_elements = a->of_cells,
                                            .width = width,
                                            .n = n,
                                            .is_integer = item.type.kind != VTK_REAL},
                                  r->error);
    }
    return status;
}

int xdmf_read_attributes(xdmf_reader *r, xdmf_mesh *m) {
    xdmf_arrays *lists = pl_alloc_zero(m->n_pieces, sizeof *lists);
    int status = lists ? PLANISH_OK : pl_fail_memory(r->error, "the arrays of the file");
    for (int64_t k = 0; k < m->n_pieces && !status; k++) {
        status = list_arrays(r, &m->piece[k], &lists[k]);
        const xdmf_array *fixed = find_array(&lists[k], "fixed", 0);
        if (!status && fixed)
            status = hold_nodes(r, &m->geometry[m->piece[k].geometry], fixed);
    }
    if (!status)
        status = read_regions(r, m, lists);
    for (int64_t k = 0; k < m->n_pieces && !status; k++)
        status = note_arrays(r, m, &m->piece[k], &lists[k]);
    for (int64_t k = 0; k < m->n_pieces && lists; k++)
        release_arrays(&lists[k]);
    pl_free(lists);
    return status;
}

/* ---- values for whoever asks ----------------------------------------------------------------- */

/** Put the numbers of Tensor6, xx xy xz yy yz zz, into the order of planish_data. */
static void order_tensors(const xdmf_reader *r, const xdmf_array *array, int64_t n, int64_t width,
                          double *values) {
    static const int from[6] = {0, 1, 3, 2, 4, 5};
    const char *type = xdmf_attribute(&r->document, array->element, "AttributeType");
    type = type ? type : xdmf_attribute(&r->document, array->element, "Type");
    for (int64_t i = 0; i < n && width == 6 && type && strcasecmp(type, "Tensor6") == 0; i++) {
        double *at = values + 6 * i, tensor[6];
        memcpy(tensor, at, sizeof tensor);
        for (int k = 0; k < 6; k++)
            at[k] = tensor[from[k]];
    }
}

/** Read the values of a piece to all [n][width]; *has: it has them. */
static int read_piece(xdmf_reader *r, const xdmf_mesh *m, const xdmf_piece *piece,
                      const io_data *data, double *all, int *has) {
    const xdmf_geometry *g = &m->geometry[piece->geometry];
    const int64_t n = data->of_elements ? piece->n : g->n_nodes;
    xdmf_arrays list = {0};
    double *values = NULL;
    int64_t width = 0;
    int status = list_arrays(r, piece, &list);
    const xdmf_array *array = find_array(&list, data->name, data->of_elements);
    *has = !status && array && n > 0;
    if (*has)
        status = read_values(r, array, n, &width, &values);
    if (*has && !status && width != data->width)
        status = xdmf_fail(&r->document, array->element,
                           "it has %lld numbers for each, and %lld "
                           "elsewhere",
                           (long long)width, (long long)data->width);
    if (*has && !status) {
        order_tensors(r, array, n, width, values);
        if (data->of_elements)
            place_cells(piece, values, width, all);
        else
            memcpy(all + g->first_node * width, values, (size_t)(n * width) * sizeof *values);
    }
    pl_free(values);
    release_arrays(&list);
    return status;
}

/** Read the values of all pieces. One without the array must have nothing that is asked for. */
static int read_pieces(xdmf_reader *r, xdmf_mesh *m, const io_data *data, double *all) {
    uint8_t *has_nodes = pl_alloc_zero(m->n_geometries, 1);
    int status = has_nodes ? PLANISH_OK : pl_fail_memory(r->error, "an array of the file");
    for (int64_t k = 0; k < m->n_pieces && !status; k++) {
        int has;
        status = read_piece(r, m, &m->piece[k], data, all, &has);
        has_nodes[m->piece[k].geometry] |= (uint8_t)has;
    }
    for (int64_t i = 0; i < m->n_geometries && !status && !data->of_elements; i++)
        if (!has_nodes[i] && m->geometry[i].n_nodes > 0)
            status = xdmf_fail(&r->document, m->geometry[i].element,
                               "its points have no array '%.60s', which others have", data->name);
    pl_free(has_nodes);
    return status;
}

/** Return how many cells a file must have for the elements of the model. */
static int64_t least_cells(const io_model *model) {
    const int dim = io_model_dim(model), lists[] = {dim, io_others_list(dim)};
    int64_t least = 0;
    for (int k = 0; k < 2; k++) {
        const io_list list = io_model_list(model, lists[k]);
        const int64_t last = list.n > 0 ? io_list_number(&list, list.n - 1) : -1;
        least = last >= least ? last + 1 : least;
    }
    return least;
}

int xdmf_read_data(io_model *model, const io_data *data, double *values, planish_error *error) {
    xdmf_reader r;
    xdmf_mesh m = {0};
    double *all = NULL;
    int64_t n_nodes = 0;
    int status = xdmf_begin(model, &r, error);
    if (!status)
        status = xdmf_mesh_find(&r, &m);
    if (!status)
        status = xdmf_count_nodes(&r, &m, &n_nodes);
    if (!status)
        status = xdmf_count_cells(&r, &m);
    const int64_t n = data->of_elements ? m.n_cells : n_nodes;
    if (!status && (n_nodes != model->n_nodes || m.n_cells < least_cells(model)))
        status = pl_fail(error, PLANISH_ERROR_FILE,
                         "%s: was changed while it was in use; run again when it is complete",
                         r.document.view.input.path);
    if (!status && !(all = pl_alloc_zero(n * data->width, sizeof *all)))
        status = pl_fail_memory(error, "an array of the file");
    if (!status)
        status = read_pieces(&r, &m, data, all);
    if (!status && data->of_elements)
        io_data_pick(model, all, n, data->width, values);
    else if (!status)
        memcpy(values, all, (size_t)(n * data->width) * sizeof *all);
    pl_free(all);
    xdmf_mesh_release(&m);
    return xdmf_close(&r, status);
}
