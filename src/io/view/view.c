/* view: the arrays of a mesh that is shown in another file. */
#include "io/view/view.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/elements.h"
#include "io/vtk/vtk_cells.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { VALUES_AT_ONCE = 1 << 16, N_KINDS = 5 };

/* ---- cells --------------------------------------------------------------------------------- */

/* Cells stand in the order of their kinds: tetrahedra, triangles, lines, other solids, other flat
 * elements. */

/** A cell, or the place behind those of its kind; zeroed: before all. */
typedef struct view_cell {
    int kind, is_found;
    io_list list;               /* that it is in */
    const io_cells *of;         /* of the list; NULL: it is one of the others */
    int64_t index;              /* in it */
    int size;                   /* nodes of it, */
    int type;                   /* and VTK's type of it */
    int n_first;                /* how many of the nodes are in first */
    const int32_t *first, *mid; /* [n_first], [size - n_first] */
    int64_t n_before;           /* nodes of all cells before it */
    int64_t first_value;        /* of the array that it was found in */
    int value;                  /* which of the cell's values */
} view_cell;

static const io_cells *cells_of(const io_model *model, int kind) {
    const io_cells *const kinds[N_KINDS] = {&model->tetrahedron, &model->triangle, &model->line};
    return kinds[kind];
}

static int64_t count_kind(const io_model *model, int kind) {
    const io_cells *of = cells_of(model, kind);
    return of ? of->n : kind == N_KINDS - 1 ? model->flat.n : model->solid.n;
}

/** Return VTK's type of an element with those nodes. It is straight where a mid is missing. */
static int other_type(int type, const int32_t *node) {
    static const uint8_t straight[] = {[PLANISH_CELL_TRIANGLE6] = PLANISH_CELL_TRIANGLE,
                                       [PLANISH_CELL_QUADRILATERAL8] = PLANISH_CELL_QUADRILATERAL,
                                       [PLANISH_CELL_QUADRILATERAL9] = PLANISH_CELL_QUADRILATERAL,
                                       [PLANISH_CELL_TETRAHEDRON10] = PLANISH_CELL_TETRAHEDRON,
                                       [PLANISH_CELL_HEXAHEDRON20] = PLANISH_CELL_HEXAHEDRON,
                                       [PLANISH_CELL_HEXAHEDRON27] = PLANISH_CELL_HEXAHEDRON,
                                       [PLANISH_CELL_WEDGE15] = PLANISH_CELL_WEDGE,
                                       [PLANISH_CELL_WEDGE18] = PLANISH_CELL_WEDGE,
                                       [PLANISH_CELL_PYRAMID13] = PLANISH_CELL_PYRAMID,
                                       [PLANISH_CELL_PYRAMID14] = PLANISH_CELL_PYRAMID};
    const int as = type == PLANISH_CELL_PYRAMID14 ? PLANISH_CELL_PYRAMID13 : type;
    for (int i = 0; i < io_cell_type_nodes(as); i++)
        if (node[i] < 0)
            return straight[type];
    return as;
}

static void set_other(const io_others *others, int64_t i, view_cell *cell) {
    cell->first = others->node + others->offset[i];
    cell->type = other_type(others->type[i], cell->first);
    cell->n_first = cell->size = io_cell_type_nodes(cell->type);
}

/** Fill in a simplex. Like other elements it is written as straight where a mid is missing. */
static void set_simplex(const io_cells *of, int dim, int64_t i, view_cell *cell) {
    static const uint8_t types[][2] = {{VTK_LINE, PLANISH_CELL_LINE3},
                                       {VTK_TRIANGLE, PLANISH_CELL_TRIANGLE6},
                                       {VTK_TETRAHEDRON, PLANISH_CELL_TETRAHEDRON10}};
    const int n_mids = io_n_mids(dim);
    int has_mids = of->mid != NULL;
    cell->first = of->nodes + i * (dim + 1);
    cell->mid = of->mid ? of->mid + i * n_mids : NULL;
    for (int k = 0; has_mids && k < n_mids; k++)
        has_mids = cell->mid[k] >= 0;
    cell->type = types[dim - 1][has_mids];
    cell->n_first = dim + 1;
    cell->size = dim + 1 + (has_mids ? n_mids : 0);
}

/** Go to cell i of a kind, but for first_value and n_before. */
static void set_cell(const io_model *model, int kind, int64_t i, view_cell *cell) {
    static const uint8_t list_of[N_KINDS] = {3, 2, 1, IO_SOLID_LIST, IO_FLAT_LIST};
    cell->is_found = 1;
    cell->kind = kind;
    cell->list = io_model_list(model, list_of[kind]);
    cell->of = cell->list.cells;
    cell->index = i;
    if (i == count_kind(model, kind))
        return;
    if (cell->of)
        set_simplex(cell->of, 3 - kind, i, cell);
    else
        set_other(cell->list.others, i, cell);
}

/** Find the cell, and which of its values, that value number i of an array is. Cells have one value
 *  each, their nodes, or these led by their number. cell: the cell of a value of that array before,
 *  or zeroed. */
static void find_cell(const io_view *view, io_view_values values, int64_t i, view_cell *cell) {
    const io_model *model = view->model;
    const int is_counted = values == IO_VIEW_COUNTED_NODES;
    const int has_nodes = is_counted || values == IO_VIEW_NODES;
    if (!cell->is_found)
        set_cell(model, 0, 0, cell);
    for (;;) {
        const int64_t n_kind = count_kind(model, cell->kind), ahead = i - cell->first_value;
        const int64_t n = has_nodes ? cell->size + is_counted : 1;
        const int is_end = cell->index == n_kind;
        if (is_end && cell->kind < N_KINDS - 1) {
            set_cell(model, cell->kind + 1, 0, cell);
            continue;
        }
        cell->value = (int)ahead;
        if (is_end || ahead < n)
            return;
        /* Cells of one size are passed at once. */
        const int64_t left = n_kind - cell->index, many = ahead / n < left ? ahead / n : left;
        const int64_t passed = cell->of && !cell->of->mid ? many : 1;
        cell->first_value += passed * n;
        cell->n_before += passed * cell->size;
        set_cell(model, cell->kind, cell->index + passed, cell);
    }
}

/** Return node k of a cell. */
static int32_t node_of(const view_cell *cell, int k) {
    return k < cell->n_first ? cell->first[k] : cell->mid[k - cell->n_first];
}

/** Count the nodes of all cells. */
static int64_t count_nodes(const io_model *model) {
    int64_t n = 0;
    view_cell cell = {0};
    for (int kind = 0; kind < N_KINDS; kind++) {
        const io_cells *of = cells_of(model, kind);
        if (of && !of->mid) {
            n += (4 - kind) * of->n;
            continue;
        }
        for (int64_t i = 0; i < count_kind(model, kind); i++) {
            set_cell(model, kind, i, &cell);
            n += cell.size;
        }
    }
    return n;
}

/* ---- values -------------------------------------------------------------------------------- */

/** Return the index of a cell in planish_file_cells, or -1: it is of a lower dimension. */
static int64_t index_of(const io_view *view, const view_cell *cell) {
    const io_model *model = view->model;
    if (cell->list.dim != io_model_dim(model))
        return -1;
    return cell->of ? cell->index : io_model_elements(model)->n + cell->index;
}

/** Return value i of the whole numbers of nodes or cells. cell: as in find_cell. */
static int64_t whole_value(const io_view *view, io_view_values values, int64_t i, view_cell *cell) {
    if (values == IO_VIEW_FIXED)
        return view->constraint[i] == PLANISH_CONSTRAINT_FIXED;
    if (values == IO_VIEW_NODE_NUMBERS)
        return io_node_number(view->model, i);
    find_cell(view, values, i, cell);
    const io_list *list = &cell->list;
    const int64_t index = index_of(view, cell);
    const int32_t at = list->entity ? list->entity[cell->index] : -1;
    const io_entity *const entity = at >= 0 ? &view->model->entity[at] : NULL;
    switch (values) {
    case IO_VIEW_NODES:
        return node_of(cell, cell->value);
    case IO_VIEW_COUNTED_NODES:
        return cell->value == 0 ? cell->size : node_of(cell, cell->value - 1);
    case IO_VIEW_ENDS:
        return cell->n_before + cell->size;
    case IO_VIEW_TYPES:
        return cell->type;
    case IO_VIEW_REGIONS:
        return list->region ? list->region[cell->index] : entity ? entity->tag : 0;
    case IO_VIEW_STATES:
        return index >= 0 ? view->data.cells.state[index] : PLANISH_CELL_STATE_NONE;
    case IO_VIEW_CURVED:
        return index >= 0 && view->data.cells.is_curved[index];
    case IO_VIEW_GROUPS:
        return entity && entity->n_physical > 0 ? entity->physical[0] : 0;
    default:
        return io_list_number(list, cell->index);
    }
}

/** Return a measure of elements, by their index in planish_file_cells; NULL: values are not real. */
static const double *measures_of(const io_view *view, io_view_values values) {
    const planish_view_data *data = &view->data;
    switch (values) {
    case IO_VIEW_RADIUS_RATIOS:
        return data->radius_ratio;
    case IO_VIEW_ASPECT_RATIOS:
        return data->cells.aspect_ratio;
    case IO_VIEW_SCALED_JACOBIANS:
        return data->cells.scaled_jacobian;
    case IO_VIEW_JACOBIAN_RATIOS:
        return data->cells.jacobian_ratio;
    case IO_VIEW_EDGE_RATIOS:
        return data->cells.edge_ratio;
    default:
        return NULL;
    }
}

/** Return value i of the coordinates, or of a measure: NAN of cells that do not have it. cell: as
 *  in find_cell. */
static double real_value(const io_view *view, io_view_values values, int64_t i, view_cell *cell) {
    const io_model *model = view->model;
    if (values == IO_VIEW_COORDINATES) {
        const int64_t node = i / 3;
        const int d = (int)(i % 3);
        if (d < model->written)
            return view->coordinates[node * model->written + d];
        return model->z ? model->z[node] : 0;
    }
    find_cell(view, values, i, cell);
    const int64_t index = index_of(view, cell);
    const int has_value = index >= 0 && (values != IO_VIEW_RADIUS_RATIOS || cell->of);
    return has_value ? measures_of(view, values)[index] : (double)NAN;
}

/* ---- the arrays ---------------------------------------------------------------------------- */

io_view io_view_of(const io_model *model, const double *coordinates, const uint8_t *constraint,
                   const planish_view_data *data) {
    return (io_view){.model = model,
                     .coordinates = coordinates,
                     .constraint = constraint,
                     .data = data ? *data : (planish_view_data){.radius_ratio = NULL},
                     .n_cells = model->tetrahedron.n + model->triangle.n + model->line.n +
                                model->solid.n + model->flat.n};
}

/** Add the measures that there are to the cell data of a. */
static void add_measures(const io_view *view, io_view_arrays *a) {
    static const struct {
        const char *name;
        io_view_values values;
    } measures[] = {{"radius_ratio", IO_VIEW_RADIUS_RATIOS},
                    {"aspect_ratio", IO_VIEW_ASPECT_RATIOS},
                    {"scaled_jacobian", IO_VIEW_SCALED_JACOBIANS},
                    {"jacobian_ratio", IO_VIEW_JACOBIAN_RATIOS},
                    {"edge_ratio", IO_VIEW_EDGE_RATIOS}};
    const int64_t n = view->n_cells;
    for (size_t i = 0; i < sizeof measures / sizeof *measures; i++)
        if (measures_of(view, measures[i].values))
            a->cell_data[a->n_cell_data++] =
                (io_view_array){measures[i].name, measures[i].values, IO_VIEW_F64, n, 1};
    if (view->data.cells.state)
        a->cell_data[a->n_cell_data++] =
            (io_view_array){"cell_state", IO_VIEW_STATES, IO_VIEW_U8, n, 1};
    if (view->data.cells.is_curved)
        a->cell_data[a->n_cell_data++] =
            (io_view_array){"is_curved", IO_VIEW_CURVED, IO_VIEW_U8, n, 1};
}

/** Return the array of n numbers: of 32 bits, which all programs read, where they are no larger. */
static io_view_array numbers_of(const io_view *view, io_view_values values, int64_t n) {
    int fits = 1;
    view_cell cell = {0};
    for (int64_t i = 0; i < n; i++) {
        const int64_t value = whole_value(view, values, i, &cell);
        fits &= value >= INT32_MIN && value <= INT32_MAX;
    }
    return (io_view_array){"number", values, fits ? IO_VIEW_I32 : IO_VIEW_I64, n, 1};
}

io_view_arrays io_view_arrays_of(const io_view *view) {
    const io_model *model = view->model;
    const io_view_type real =
        model->precision == PLANISH_PRECISION_FLOAT ? IO_VIEW_F32 : IO_VIEW_F64;
    const int64_t n_nodes = model->n_nodes, n = view->n_cells;
    const int64_t n_of_cells = count_nodes(model);
    int has_groups = 0;
    io_view_arrays a = {
        .points = {"Points", IO_VIEW_COORDINATES, real, 3 * n_nodes, 3},
        .connectivity = {"connectivity", IO_VIEW_NODES, IO_VIEW_I32, n_of_cells, 1},
        .offsets = {"offsets", IO_VIEW_ENDS, IO_VIEW_I64, n, 1},
        .types = {"types", IO_VIEW_TYPES, IO_VIEW_U8, n, 1},
        .wide_types = {"types", IO_VIEW_TYPES, IO_VIEW_I32, n, 1},
        .counted = {"cells", IO_VIEW_COUNTED_NODES, IO_VIEW_I32, n_of_cells + n, 1}};
    if (view->constraint)
        a.point_data[a.n_point_data++] =
            (io_view_array){"fixed", IO_VIEW_FIXED, IO_VIEW_U8, n_nodes, 1};
    a.point_data[a.n_point_data++] = numbers_of(view, IO_VIEW_NODE_NUMBERS, n_nodes);
    add_measures(view, &a);
    if (model->n_entities > 0 || io_model_elements(model)->region ||
        io_model_other_elements(model)->region)
        a.cell_data[a.n_cell_data++] =
            (io_view_array){"region", IO_VIEW_REGIONS, IO_VIEW_I32, n, 1};
    for (int32_t i = 0; i < model->n_entities; i++)
        has_groups |= model->entity[i].dim > 0 && model->entity[i].n_physical > 0;
    if (has_groups)
        a.cell_data[a.n_cell_data++] = (io_view_array){"group", IO_VIEW_GROUPS, IO_VIEW_I32, n, 1};
    a.cell_data[a.n_cell_data++] = numbers_of(view, IO_VIEW_CELL_NUMBERS, n);
    return a;
}

int io_view_type_size(io_view_type type) {
    static const int size[] = {1, 4, 8, 4, 8};
    return size[type];
}

/** Store value i of an array at at. cell: as in find_cell. */
static void store_value(const io_view *view, const io_view_array *array, int64_t i, view_cell *cell,
                        char *at) {
    const int is_real = array->values == IO_VIEW_COORDINATES || measures_of(view, array->values);
    const double real = is_real ? real_value(view, array->values, i, cell) : 0;
    const int64_t integer = is_real ? 0 : whole_value(view, array->values, i, cell);
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
    view_cell cell = {0};
    int status = block ? PLANISH_OK : pl_fail_memory(error, "the values to be written");
    for (int64_t begin = 0; begin < array->n && !status; begin += VALUES_AT_ONCE) {
        const int64_t left = array->n - begin;
        const int64_t n = left < VALUES_AT_ONCE ? left : VALUES_AT_ONCE;
        for (int64_t i = 0; i < n; i++) {
            char *at = block + i * size;
            store_value(view, array, begin + i, &cell, at);
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
