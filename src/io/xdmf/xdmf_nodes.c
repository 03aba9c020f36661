/* xdmf_nodes: the points of an XDMF file, and where they stand.
 *
 * All geometries are of one form, in one file: it is that which is written.
 */
#include "io/xdmf/xdmf.h"

#include "base/memory.h"
#include "base/status.h"
#include "base/round.h"
#include "io/core/components.h"
#include "io/core/include.h"

#include <stdlib.h>

/* ---- what there is -------------------------------------------------------------------------- */

/** Check that a geometry stands where the first one does, and as that does. */
static int check_alike(xdmf_reader *r, const xdmf_geometry *first, const xdmf_geometry *g) {
    const xdmf_item *a = &first->item[0];
    if (g->columns != first->columns)
        return xdmf_fail(&r->document, g->element,
                         "some points have two coordinates and some three");
    for (int k = 0; k < g->n_items; k++) {
        const xdmf_item *b = &g->item[k];
        if (b->form != a->form || io_include_compare(a->file, b->file) != 0)
            return xdmf_fail(&r->document, g->element,
                             "the coordinates of the mesh stand in several files; write them to "
                             "one");
        if (a->form != XDMF_HDF5 && ((b->type.size == 8) != (a->type.size == 8) ||
                                     (b->type.kind == VTK_REAL) != (a->type.kind == VTK_REAL)))
            return xdmf_fail(&r->document, g->element,
                             "some points are of Precision 4 and some "
                             "of 8: write them as one");
        if (a->form == XDMF_BYTES && b->type.kind != VTK_REAL)
            return xdmf_fail(&r->document, b->element, "Float numbers were expected");
    }
    return PLANISH_OK;
}

static int compare_items(const void *a, const void *b) {
    return xdmf_compare(*(const xdmf_item *const *)a, *(const xdmf_item *const *)b);
}

/** Check that no numbers are coordinates twice: these could not be changed apart. */
static int check_apart(xdmf_reader *r, const xdmf_mesh *m) {
    const xdmf_item **all = pl_alloc(m->n_geometries * XDMF_MOST_ITEMS, sizeof *all);
    int64_t n = 0;
    int status = all ? PLANISH_OK : pl_fail_memory(r->error, "the nodes of the file");
    for (int64_t i = 0; i < m->n_geometries && !status; i++)
        for (int k = 0; k < m->geometry[i].n_items; k++)
            all[n++] = &m->geometry[i].item[k];
    if (n > 0)
        qsort(all, (size_t)n, sizeof *all, compare_items);
    for (int64_t i = 1; i < n && !status; i++)
        if (compare_items(&all[i - 1], &all[i]) == 0)
            status = xdmf_fail(&r->document, all[i]->element,
                               "its numbers are coordinates twice, and cannot be changed apart; "
                               "write them once for each use");
    pl_free(all);
    return status;
}

/** Find the number of points of a geometry. */
static int count_points(xdmf_reader *r, xdmf_geometry *g) {
    const int width = g->n_items > 1 ? 1 : g->columns;
    for (int k = 0; k < g->n_items; k++) {
        int64_t n;
        const int status = xdmf_check_count(r, &g->item[k], &n);
        if (status)
            return status;
        if (n % width || (k > 0 && n != g->n_nodes))
            return xdmf_fail(&r->document, g->item[k].element,
                             "%lld numbers do not make points of %d coordinates, or not as many "
                             "points as elsewhere",
                             (long long)n, g->columns);
        g->n_nodes = n / width;
    }
    return PLANISH_OK;
}

int xdmf_count_nodes(xdmf_reader *r, xdmf_mesh *m, int64_t *n) {
    int status = PLANISH_OK;
    *n = 0;
    for (int64_t i = 0; i < m->n_geometries && !status; i++) {
        xdmf_geometry *g = &m->geometry[i];
        status = count_points(r, g);
        g->first_node = *n;
        *n += g->n_nodes;
        if (!status && *n > INT32_MAX)
            status = xdmf_fail(&r->document, g->element,
                               "there are more points than planish can "
                               "number");
    }
    return status;
}

/* ---- text ----------------------------------------------------------------------------------- */

/** One component of points. */
typedef struct component_records {
    io_model *model;
    int64_t first;
    int component;
} component_records;

/** Read a component of points, and note its places: io_records_fn. */
static int read_component(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                          planish_error *error) {
    const component_records *c = context;
    io_model *model = c->model;
    for (int64_t i = begin; i < end; i++) {
        const int64_t node = c->first + i;
        double value;
        io_skip_space(cursor);
        model->text_offset[c->component * model->n_nodes + node] = cursor->at - model->input.data;
        const char *at = cursor->at;
        if (io_real(cursor, &value))
            return io_fail_at(model, at, error,
                              "node %lld: coordinate expected (the file may be cut short)",
                              (long long)node);
        const int is_float = model->precision == PLANISH_PRECISION_FLOAT;
        model->xyz[3 * node + c->component] = is_float ? pl_round_to_float(value) : value;
        const int status = io_check_finite(model, value, node, at, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Read the points of a geometry from the XML, or one component of them. */
static int read_text(xdmf_reader *r, const xdmf_geometry *g, int k) {
    io_model *model = r->model;
    const int is_apart = g->n_items > 1;
    io_node_records points = {.model = model, .first = g->first_node};
    component_records component = {model, g->first_node, k};
    const int status =
        is_apart ? xdmf_read_text(r, &g->item[k], g->n_nodes, 1, read_component, &component)
                 : xdmf_read_text(r, &g->item[k], g->n_nodes, g->columns, io_read_nodes, &points);
    const io_span span = {.first_node = g->first_node,
                          .n_nodes = g->n_nodes,
                          .encoding = IO_TEXT,
                          .offset =
                              xdmf_text(&r->document, g->item[k].element).begin - model->input.data,
                          .component = is_apart ? k : 0,
                          .n_components = is_apart ? 1 : g->columns};
    return status ? status : io_model_span(model, span, r->error);
}

/* ---- bytes ---------------------------------------------------------------------------------- */

/** Read coordinates from a file of bytes. */
static int read_bytes(xdmf_reader *r, const xdmf_geometry *g, int k) {
    io_model *model = r->model;
    const xdmf_item *item = &g->item[k];
    const int n = g->n_items > 1 ? 1 : g->columns, size = item->type.size;
    for (int c = 0; c < n; c++) {
        const io_strided from = {.data = model->input.data + item->seek + c * size,
                                 .stride = n * size,
                                 .size = size,
                                 .swapped = item->swapped,
                                 .first = g->first_node,
                                 .n = g->n_nodes};
        const int64_t bad = io_load_component(model, from, k + c);
        if (bad >= 0)
            return io_fail_infinite(model, bad, from.data + (bad - g->first_node) * from.stride,
                                    r->error);
    }
    const io_span span = {.first_node = g->first_node,
                          .n_nodes = g->n_nodes,
                          .encoding = size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                          .swapped = item->swapped,
                          .offset = item->seek,
                          .stride = n * size,
                          .component = k,
                          .n_components = n};
    return io_model_span(model, span, r->error);
}

/* ---- all ------------------------------------------------------------------------------------ */

static int read_hdf5(xdmf_reader *r, const xdmf_geometry *g, int k) {
    xdmf_file *file = NULL;
    const int status = xdmf_open(r, &g->item[k], &file);
    return status ? status
                  : xdmf_hdf5_coordinates(file, &g->item[k], k, g->n_items > 1 ? 1 : g->columns,
                                          g->first_node, g->n_nodes);
}

static int make_nodes(xdmf_reader *r, const xdmf_geometry *first, int64_t n) {
    io_model *model = r->model;
    const xdmf_item *item = &first->item[0];
    const int is_text = item->form == XDMF_TEXT, is_apart = first->n_items > 1;
    model->columns = first->columns;
    model->precision = item->type.kind == VTK_REAL && item->type.size == 4
                           ? PLANISH_PRECISION_FLOAT
                           : PLANISH_PRECISION_DOUBLE;
    const int status = io_model_alloc_nodes(model, n, is_text && !is_apart, r->error);
    if (status || !is_text || !is_apart)
        return status;
    model->text_offset = pl_alloc(first->columns * n, sizeof *model->text_offset);
    return model->text_offset ? PLANISH_OK : pl_fail_memory(r->error, "the nodes of the file");
}

int xdmf_read_nodes(xdmf_reader *r, xdmf_mesh *m) {
    const xdmf_geometry *first = &m->geometry[0];
    const xdmf_form form = first->item[0].form;
    int64_t n = 0;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < m->n_geometries && !status; i++) {
        status = check_alike(r, first, &m->geometry[i]);
        if (!status && (m->geometry[i].n_items > 1) != (first->n_items > 1))
            status = xdmf_fail(&r->document, m->geometry[i].element,
                               "some coordinates stand apart and some not");
    }
    if (!status)
        status = check_apart(r, m);
    if (!status && form != XDMF_TEXT)
        status = xdmf_take_input(r, &first->item[0]);
    if (!status)
        status = xdmf_count_nodes(r, m, &n);
    if (!status)
        status = make_nodes(r, first, n);
    for (int64_t i = 0; i < m->n_geometries && !status; i++)
        for (int k = 0; k < m->geometry[i].n_items && m->geometry[i].n_nodes > 0 && !status; k++)
            status = form == XDMF_TEXT   ? read_text(r, &m->geometry[i], k)
                     : form == XDMF_HDF5 ? read_hdf5(r, &m->geometry[i], k)
                                         : read_bytes(r, &m->geometry[i], k);
    if (status || form != XDMF_TEXT)
        return status ? status : io_components_end(r->model, r->error);
    io_model_sort_spans(r->model);
    for (int64_t i = 0; r->model->columns < 3 && i < n; i++)
        r->model->xyz[3 * i + 2] = 0;
    return PLANISH_OK;
}
