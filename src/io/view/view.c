/* view: the arrays of a mesh that is shown in another file. */
#include "io/view/view.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/vtk/vtk_cells.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { VALUES_AT_ONCE = 1 << 16, N_KINDS = 3 };

/* ---- cells --------------------------------------------------------------------------------- */

/** Values that cells have in an array: one each, their nodes, or these led by their number. */
typedef enum cell_values { ONE_VALUE, NODES, COUNTED_NODES } cell_values;

/** A cell, or the place behind all. */
typedef struct cell {
    const io_cells *of;
    int64_t index;    /* in it */
    int corners;      /* nodes of a cell of the kind, */
    int type;         /* and VTK's type of it */
    int64_t n_before; /* nodes of all cells before it */
    int value;        /* which of the cell's values */
} cell;

/** Find the cell, and which of its values, that value number i of an array is. */
static cell find_cell(const io_view *view, cell_values values, int64_t i) {
    static const int types[N_KINDS] = {VTK_TETRAHEDRON, VTK_TRIANGLE, VTK_LINE};
    const io_model *model = view->model;
    const io_cells *const kinds[N_KINDS] = {&model->tetrahedron, &model->triangle, &model->line};
    int64_t n_before = 0;
    for (int k = 0;; k++) {
        const int corners = N_KINDS + 1 - k;
        const int n = values == ONE_VALUE ? 1 : corners + (values == COUNTED_NODES);
        if (k + 1 == N_KINDS || i < kinds[k]->n * n) {
            const int64_t index = i / n;
            return (cell){kinds[k],    index, corners, types[k], n_before + index * corners,
                          (int)(i % n)};
        }
        i -= kinds[k]->n * n;
        n_before += kinds[k]->n * corners;
    }
}

/* ---- values -------------------------------------------------------------------------------- */

static double coordinate(const io_view *view, int64_t i) {
    const io_model *model = view->model;
    const int64_t node = i / 3;
    const int d = (int)(i % 3);
    if (d < model->written)
        return view->coordinates[node * model->written + d];
    return model->z ? model->z[node] : 0;
}

static int64_t node_of_cell(const io_view *view, int64_t i) {
    const cell c = find_cell(view, NODES, i);
    return c.of->nodes[c.index * c.corners + c.value];
}

static int64_t counted_node(const io_view *view, int64_t i) {
    const cell c = find_cell(view, COUNTED_NODES, i);
    return c.value == 0 ? c.corners : c.of->nodes[c.index * c.corners + c.value - 1];
}

static int64_t end_of_cell(const io_view *view, int64_t i) {
    const cell c = find_cell(view, ONE_VALUE, i);
    return c.n_before + c.corners;
}

static int64_t type_of_cell(const io_view *view, int64_t i) {
    return find_cell(view, ONE_VALUE, i).type;
}

static int64_t is_fixed(const io_view *view, int64_t i) {
    return view->constraint[i] == PLANISH_FIXED;
}

static int64_t number_of_node(const io_view *view, int64_t i) {
    return io_node_number(view->model, i);
}

static int64_t number_of_cell(const io_view *view, int64_t i) {
    const cell c = find_cell(view, ONE_VALUE, i);
    return io_cell_number(c.of, c.index);
}

/** The entity of a cell, or NULL. */
static const io_entity *entity_of(const io_view *view, const cell *c) {
    const int32_t *entity = c->of->entity;
    return entity && entity[c->index] >= 0 ? &view->model->entity[entity[c->index]] : NULL;
}

static int64_t region_of_cell(const io_view *view, int64_t i) {
    const cell c = find_cell(view, ONE_VALUE, i);
    const io_entity *entity = entity_of(view, &c);
    return c.of->region ? c.of->region[c.index] : entity ? entity->tag : 0;
}

static int64_t group_of_cell(const io_view *view, int64_t i) {
    const cell c = find_cell(view, ONE_VALUE, i);
    const io_entity *entity = entity_of(view, &c);
    return entity && entity->n_physical > 0 ? entity->physical[0] : 0;
}

/** Radius ratio of the elements that are smoothed; none of those of lower dimension. */
static double ratio_of_cell(const io_view *view, int64_t i) {
    const cell c = find_cell(view, ONE_VALUE, i);
    return c.of == io_model_elements(view->model) ? view->radius_ratio[c.index] : (double)NAN;
}

/* ---- the arrays ---------------------------------------------------------------------------- */

io_view io_view_of(const io_model *model, const double *coordinates, const uint8_t *constraint,
                   const double *radius_ratio) {
    io_view view = {.model = model,
                    .coordinates = coordinates,
                    .constraint = constraint,
                    .radius_ratio = radius_ratio,
                    .n_cells = model->tetrahedron.n + model->triangle.n + model->line.n};
    view.has_regions = model->n_entities > 0 || io_model_elements(model)->region;
    for (int32_t i = 0; i < model->n_entities; i++)
        view.has_groups |= model->entity[i].dim > 0 && model->entity[i].n_physical > 0;
    return view;
}

/** The array of n numbers: of 32 bits, which all programs read, where they are no larger. */
static io_view_array numbers_of(const io_view *view, int64_t n,
                                int64_t (*number)(const io_view *view, int64_t i)) {
    int fits = 1;
    for (int64_t i = 0; i < n; i++) {
        const int64_t value = number(view, i);
        fits &= value >= INT32_MIN && value <= INT32_MAX;
    }
    return (io_view_array){"number", fits ? IO_VIEW_I32 : IO_VIEW_I64, n, 1, number, NULL};
}

io_view_arrays io_view_arrays_of(const io_view *view) {
    const io_model *model = view->model;
    const io_view_type real = model->precision == PLANISH_FLOAT ? IO_VIEW_F32 : IO_VIEW_F64;
    const int64_t n_nodes = model->n_nodes, n = view->n_cells;
    const int64_t n_corners = 4 * model->tetrahedron.n + 3 * model->triangle.n + 2 * model->line.n;
    io_view_arrays a = {
        .points = {"Points", real, 3 * n_nodes, 3, NULL, coordinate},
        .connectivity = {"connectivity", IO_VIEW_I32, n_corners, 1, node_of_cell, NULL},
        .offsets = {"offsets", IO_VIEW_I64, n, 1, end_of_cell, NULL},
        .types = {"types", IO_VIEW_U8, n, 1, type_of_cell, NULL},
        .wide_types = {"types", IO_VIEW_I32, n, 1, type_of_cell, NULL},
        .counted = {"cells", IO_VIEW_I32, n_corners + n, 1, counted_node, NULL}};
    if (view->constraint)
        a.point_data[a.n_point_data++] =
            (io_view_array){"fixed", IO_VIEW_U8, n_nodes, 1, is_fixed, NULL};
    a.point_data[a.n_point_data++] = numbers_of(view, n_nodes, number_of_node);
    if (view->radius_ratio)
        a.cell_data[a.n_cell_data++] =
            (io_view_array){"radius_ratio", IO_VIEW_F64, n, 1, NULL, ratio_of_cell};
    if (view->has_regions)
        a.cell_data[a.n_cell_data++] =
            (io_view_array){"region", IO_VIEW_I32, n, 1, region_of_cell, NULL};
    if (view->has_groups)
        a.cell_data[a.n_cell_data++] =
            (io_view_array){"group", IO_VIEW_I32, n, 1, group_of_cell, NULL};
    a.cell_data[a.n_cell_data++] = numbers_of(view, n, number_of_cell);
    return a;
}

int io_view_type_size(io_view_type type) {
    static const int size[] = {1, 4, 8, 4, 8};
    return size[type];
}

/** Store value i of an array, size bytes, at at. */
static void store_value(const io_view *view, const io_view_array *array, int64_t i, char *at) {
    const int64_t integer = array->integer ? array->integer(view, i) : 0;
    const double real = array->real ? array->real(view, i) : 0;
    const int32_t narrow = (int32_t)integer;
    const float single = (float)real;
    switch (array->type) {
    case IO_VIEW_U8:
        *at = (char)(unsigned char)integer;
        break;
    case IO_VIEW_I32:
        memcpy(at, &narrow, sizeof narrow);
        break;
    case IO_VIEW_I64:
        memcpy(at, &integer, sizeof integer);
        break;
    case IO_VIEW_F32:
        memcpy(at, &single, sizeof single);
        break;
    case IO_VIEW_F64:
        memcpy(at, &real, sizeof real);
        break;
    }
}

int io_view_write(const io_view *view, const io_view_array *array, int swapped, pl_output *output,
                  planish_error *error) {
    const int size = io_view_type_size(array->type);
    char *block = pl_alloc(VALUES_AT_ONCE, (size_t)size);
    int status = block ? PLANISH_OK : pl_fail_memory(error, "the values to be written");
    for (int64_t begin = 0; begin < array->n && !status; begin += VALUES_AT_ONCE) {
        const int64_t left = array->n - begin;
        const int64_t n = left < VALUES_AT_ONCE ? left : VALUES_AT_ONCE;
        for (int64_t i = 0; i < n; i++) {
            char *at = block + i * size;
            store_value(view, array, begin + i, at);
            for (int k = 0; k < size / 2 && swapped; k++) {
                const char t = at[k];
                at[k] = at[size - 1 - k];
                at[size - 1 - k] = t;
            }
        }
        status = pl_output_write(output, block, n * size, error);
    }
    pl_free(block);
    return status;
}

int io_view_group(const io_model *model, int32_t i, char *text, size_t size) {
    const io_group *group = &model->group[i];
    return snprintf(text, size, "%d:%ld %s", group->dim, (long)group->tag, group->name);
}
