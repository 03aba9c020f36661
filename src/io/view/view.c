/* view: the arrays of a mesh that is shown in another file. */
#include "io/view/view.h"

#include "base/memory.h"
#include "base/round.h"
#include "base/status.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { VALUES_AT_ONCE = 1 << 16, MOST_CORNERS = 4, N_KINDS = 3 };

/* ---- cells --------------------------------------------------------------------------------- */

/** Cells of one kind. */
typedef struct kind {
    const io_cells *cells;
    int corners, type; /* VTK's type */
} kind;

static void kinds_of(const io_view *view, kind kinds[N_KINDS]) {
    const io_model *model = view->model;
    kinds[0] = (kind){&model->tetrahedron, 4, 10};
    kinds[1] = (kind){&model->triangle, 3, 5};
    kinds[2] = (kind){&model->line, 2, 3};
}

/** A cell by its number in the view. */
typedef struct cell {
    kind of;
    int64_t index;    /* in of.cells */
    int64_t begin;    /* of its nodes in the list of all */
    int64_t n_before; /* cells before it */
} cell;

static cell cell_at(const io_view *view, int64_t number) {
    kind kinds[N_KINDS];
    int64_t first = 0, begin = 0;
    int k = 0;
    kinds_of(view, kinds);
    while (k + 1 < N_KINDS && number >= first + kinds[k].cells->n) {
        first += kinds[k].cells->n;
        begin += kinds[k].cells->n * kinds[k].corners;
        k++;
    }
    const int64_t index = number - first;
    return (cell){kinds[k], index, begin + index * kinds[k].corners, number};
}

/** The cell that value number at of all cells' nodes is of; each led by a count if counted. */
static cell cell_with(const io_view *view, int64_t at, int counted) {
    kind kinds[N_KINDS];
    int64_t first = 0, begin = 0;
    int k = 0;
    kinds_of(view, kinds);
    while (k + 1 < N_KINDS && at >= begin + kinds[k].cells->n * (kinds[k].corners + counted)) {
        first += kinds[k].cells->n;
        begin += kinds[k].cells->n * (kinds[k].corners + counted);
        k++;
    }
    const int64_t index = (at - begin) / (kinds[k].corners + counted);
    return (cell){kinds[k], index, begin + index * (kinds[k].corners + counted), first + index};
}

static int64_t count_nodes(const io_view *view, int counted) {
    kind kinds[N_KINDS];
    int64_t n = 0;
    kinds_of(view, kinds);
    for (int k = 0; k < N_KINDS; k++)
        n += kinds[k].cells->n * (kinds[k].corners + counted);
    return n;
}

/* ---- what arrays are filled with ----------------------------------------------------------- */

static double coordinate(const io_view *view, int64_t i) {
    const io_model *model = view->model;
    const int64_t node = i / 3;
    const int d = (int)(i % 3);
    if (d < model->written)
        return view->coordinates[node * model->written + d];
    return model->z ? model->z[node] : 0;
}

static void fill_points(const io_view *view, int64_t begin, int64_t end, void *out) {
    double *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = coordinate(view, i);
}

static void fill_float_points(const io_view *view, int64_t begin, int64_t end, void *out) {
    float *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = (float)coordinate(view, i);
}

static void fill_connectivity(const io_view *view, int64_t begin, int64_t end, void *out) {
    int32_t *to = out;
    for (int64_t i = begin; i < end;) {
        const cell c = cell_with(view, i, 0);
        const int32_t *nodes = c.of.cells->nodes + c.index * c.of.corners;
        for (int64_t k = i - c.begin; k < c.of.corners && i < end; k++, i++)
            *to++ = nodes[k];
    }
}

static void fill_counted(const io_view *view, int64_t begin, int64_t end, void *out) {
    int32_t *to = out;
    for (int64_t i = begin; i < end;) {
        const cell c = cell_with(view, i, 1);
        const int32_t *nodes = c.of.cells->nodes + c.index * c.of.corners;
        for (int64_t k = i - c.begin; k <= c.of.corners && i < end; k++, i++)
            *to++ = k == 0 ? c.of.corners : nodes[k - 1];
    }
}

static void fill_offsets(const io_view *view, int64_t begin, int64_t end, void *out) {
    int64_t *to = out;
    for (int64_t i = begin; i < end; i++) {
        const cell c = cell_at(view, i);
        *to++ = c.begin + c.of.corners;
    }
}

static void fill_types(const io_view *view, int64_t begin, int64_t end, void *out) {
    uint8_t *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = (uint8_t)cell_at(view, i).of.type;
}

static void fill_wide_types(const io_view *view, int64_t begin, int64_t end, void *out) {
    int32_t *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = cell_at(view, i).of.type;
}

static void fill_fixed(const io_view *view, int64_t begin, int64_t end, void *out) {
    uint8_t *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = view->constraint[i] == PLANISH_FIXED;
}

/* ---- numbers: of 32 bits, which all programs read, where they are no larger ----------------- */

static int64_t node_number(const io_view *view, int64_t node) {
    const io_model *model = view->model;
    return model->node_number ? model->node_number[node] : model->first_number + node;
}

static void fill_node_numbers(const io_view *view, int64_t begin, int64_t end, void *out) {
    int64_t *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = node_number(view, i);
}

static void fill_narrow_node_numbers(const io_view *view, int64_t begin, int64_t end, void *out) {
    int32_t *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = (int32_t)node_number(view, i);
}

static int64_t cell_number(const io_view *view, int64_t i) {
    const cell c = cell_at(view, i);
    return c.of.cells->number ? c.of.cells->number[c.index] : c.of.cells->first_number + c.index;
}

static void fill_cell_numbers(const io_view *view, int64_t begin, int64_t end, void *out) {
    int64_t *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = cell_number(view, i);
}

static void fill_narrow_cell_numbers(const io_view *view, int64_t begin, int64_t end, void *out) {
    int32_t *to = out;
    for (int64_t i = begin; i < end; i++)
        *to++ = (int32_t)cell_number(view, i);
}

static io_view_array numbers(const io_view *view, int64_t n,
                             int64_t (*number)(const io_view *, int64_t),
                             void (*wide)(const io_view *, int64_t, int64_t, void *),
                             void (*narrow)(const io_view *, int64_t, int64_t, void *)) {
    int fits = 1;
    for (int64_t i = 0; i < n; i++) {
        const int64_t value = number(view, i);
        fits &= value >= INT32_MIN && value <= INT32_MAX;
    }
    return fits ? (io_view_array){"number", IO_VIEW_I32, n, 1, narrow}
                : (io_view_array){"number", IO_VIEW_I64, n, 1, wide};
}

/* ---- regions and ratios -------------------------------------------------------------------- */

/** The entity of a cell, or NULL. */
static const io_entity *entity_at(const io_view *view, int64_t number) {
    const cell c = cell_at(view, number);
    const int32_t *entity = c.of.cells->entity;
    return entity && entity[c.index] >= 0 ? &view->model->entity[entity[c.index]] : NULL;
}

static void fill_regions(const io_view *view, int64_t begin, int64_t end, void *out) {
    int32_t *to = out;
    for (int64_t i = begin; i < end; i++) {
        const cell c = cell_at(view, i);
        const io_entity *entity = entity_at(view, i);
        *to++ = c.of.cells->region ? c.of.cells->region[c.index] : entity ? entity->tag : 0;
    }
}

static void fill_groups(const io_view *view, int64_t begin, int64_t end, void *out) {
    int32_t *to = out;
    for (int64_t i = begin; i < end; i++) {
        const io_entity *entity = entity_at(view, i);
        *to++ = entity && entity->n_physical > 0 ? entity->physical[0] : 0;
    }
}

/** Of the elements that are smoothed; nothing for those of lower dimension. */
static void fill_ratios(const io_view *view, int64_t begin, int64_t end, void *out) {
    const io_model *model = view->model;
    const io_cells *smoothed = model->dim == 3 ? &model->tetrahedron : &model->triangle;
    double *to = out;
    for (int64_t i = begin; i < end; i++) {
        const cell c = cell_at(view, i);
        *to++ = c.of.cells == smoothed ? view->radius_ratio[c.index] : (double)NAN;
    }
}

/* ---- the arrays ---------------------------------------------------------------------------- */

io_view io_view_of(const io_model *model, const double *coordinates, const uint8_t *constraint,
                   const double *radius_ratio) {
    io_view view = {.model = model,
                    .coordinates = coordinates,
                    .constraint = constraint,
                    .radius_ratio = radius_ratio,
                    .n_cells = model->tetrahedron.n + model->triangle.n + model->line.n};
    const io_cells *elements = model->dim == 3 ? &model->tetrahedron : &model->triangle;
    view.has_regions = model->n_entities > 0 || elements->region;
    for (int32_t i = 0; i < model->n_entities; i++)
        view.has_groups |= model->entity[i].dim > 0 && model->entity[i].n_physical > 0;
    return view;
}

io_view_arrays io_view_arrays_of(const io_view *view) {
    const int is_float = view->model->precision == PLANISH_FLOAT;
    const int64_t n_nodes = view->model->n_nodes, n_cells = view->n_cells;
    const int64_t n_corners = count_nodes(view, 0), n_counted = count_nodes(view, 1);
    io_view_arrays a = {
        .points = {"Points", is_float ? IO_VIEW_F32 : IO_VIEW_F64, 3 * n_nodes, 3,
                   is_float ? fill_float_points : fill_points},
        .connectivity = {"connectivity", IO_VIEW_I32, n_corners, 1, fill_connectivity},
        .offsets = {"offsets", IO_VIEW_I64, n_cells, 1, fill_offsets},
        .types = {"types", IO_VIEW_U8, n_cells, 1, fill_types},
        .wide_types = {"types", IO_VIEW_I32, n_cells, 1, fill_wide_types},
        .counted = {"cells", IO_VIEW_I32, n_counted, 1, fill_counted}};
    if (view->constraint)
        a.point_data[a.n_point_data++] =
            (io_view_array){"fixed", IO_VIEW_U8, n_nodes, 1, fill_fixed};
    a.point_data[a.n_point_data++] =
        numbers(view, n_nodes, node_number, fill_node_numbers, fill_narrow_node_numbers);
    if (view->radius_ratio)
        a.cell_data[a.n_cell_data++] =
            (io_view_array){"radius_ratio", IO_VIEW_F64, n_cells, 1, fill_ratios};
    if (view->has_regions)
        a.cell_data[a.n_cell_data++] =
            (io_view_array){"region", IO_VIEW_I32, n_cells, 1, fill_regions};
    if (view->has_groups)
        a.cell_data[a.n_cell_data++] =
            (io_view_array){"group", IO_VIEW_I32, n_cells, 1, fill_groups};
    a.cell_data[a.n_cell_data++] =
        numbers(view, n_cells, cell_number, fill_cell_numbers, fill_narrow_cell_numbers);
    return a;
}

int io_view_type_size(io_view_type type) {
    static const int size[] = {1, 4, 8, 4, 8};
    return size[type];
}

static void swap_values(char *data, int64_t n, int size) {
    for (int64_t i = 0; i < n; i++, data += size)
        for (int k = 0; k < size / 2; k++) {
            const char t = data[k];
            data[k] = data[size - 1 - k];
            data[size - 1 - k] = t;
        }
}

int io_view_write(const io_view *view, const io_view_array *array, int swapped, io_output *output,
                  planish_error *error) {
    const int size = io_view_type_size(array->type);
    char *block = pl_alloc(VALUES_AT_ONCE, (size_t)size);
    int status = block ? PLANISH_OK : pl_fail_memory(error, "the values to be written");
    for (int64_t begin = 0; begin < array->n && !status; begin += VALUES_AT_ONCE) {
        const int64_t left = array->n - begin;
        const int64_t n = left < VALUES_AT_ONCE ? left : VALUES_AT_ONCE;
        array->fill(view, begin, begin + n, block);
        if (swapped)
            swap_values(block, n, size);
        status = io_output_write(output, block, n * size, error);
    }
    pl_free(block);
    return status;
}

int io_view_group(const io_model *model, int32_t i, char *text, size_t size) {
    const io_group *group = &model->group[i];
    return snprintf(text, size, "%d:%ld %s", group->dim, (long)group->tag, group->name);
}
