/* vtk_arrays: the arrays of a mesh that is written as VTK's. */
#include "io/vtk/vtk_arrays.h"

#include "base/memory.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

enum { N_OWN_DATA = 10, PYRAMID13_NODES = 13 };

static const char groups_name[] = "group";

/** Find a cell as VTK has it: there is no pyramid with a node in its base. */
static void cell_at(const io_view *view, int64_t i, io_view_cell *cell) {
    io_view_cell_at(view, i, cell);
    if (cell->type == PLANISH_CELL_PYRAMID14) {
        cell->type = PLANISH_CELL_PYRAMID13;
        cell->n_nodes = PYRAMID13_NODES;
    }
}

/* ---- values -------------------------------------------------------------------------------- */

/** Return a measure of elements, by their index in planish_file_cells; NULL: values are not real. */
static const double *measures_of(const io_view *view, vtk_out_values values) {
    const planish_convert_options *data = view->options;
    switch (values) {
    case VTK_OUT_RADIUS_RATIOS:
        return data->radius_ratio;
    case VTK_OUT_ASPECT_RATIOS:
        return data->cells.aspect_ratio;
    case VTK_OUT_SCALED_JACOBIANS:
        return data->cells.scaled_jacobian;
    case VTK_OUT_JACOBIAN_RATIOS:
        return data->cells.jacobian_ratio;
    case VTK_OUT_EDGE_RATIOS:
        return data->cells.edge_ratio;
    default:
        return NULL;
    }
}

static int64_t node_value(const io_view *view, vtk_out_values values, int64_t node) {
    return values == VTK_OUT_FIXED ? view->options->constraint[node] == PLANISH_CONSTRAINT_FIXED
                                   : io_node_number(view->model, node);
}

/** Return the number of the first group of a cell, or 0. */
static int32_t group_of(const io_view *view, const vtk_out_array *array, const io_view_cell *cell) {
    const io_entity *entity = cell->entity >= 0 ? &view->model->entity[cell->entity] : NULL;
    if (entity && array->number)
        return array->number[cell->entity];
    return entity && entity->n_physical > 0 ? entity->physical[0] : 0;
}

/** Return the whole number of a cell that an array has. */
static int64_t cell_value(const io_view *view, const vtk_out_array *array,
                          const io_view_cell *cell) {
    switch (array->values) {
    case VTK_OUT_TYPES:
        return cell->type;
    case VTK_OUT_REGIONS:
        return io_view_distinct_region(view, cell);
    case VTK_OUT_STATES:
        return cell->element >= 0 ? view->options->cells.state[cell->element]
                                  : PLANISH_CELL_STATE_NONE;
    case VTK_OUT_CURVED:
        return cell->element >= 0 && view->options->cells.is_curved[cell->element];
    case VTK_OUT_GROUPS:
        return group_of(view, array, cell);
    default:
        return cell->number;
    }
}

/** Return a measure of a cell: NAN of cells that do not have it. */
static double cell_measure(const io_view *view, vtk_out_values values, const io_view_cell *cell) {
    const int is_simplex = io_simplex_dim(cell->type) > 0;
    const int has_value = cell->element >= 0 && (values != VTK_OUT_RADIUS_RATIOS || is_simplex);
    return has_value ? measures_of(view, values)[cell->element] : (double)NAN;
}

/* ---- writing ------------------------------------------------------------------------------- */

static void put(io_writer *writer, vtk_out_type type, int swapped, double real, int64_t whole) {
    const uint8_t byte = (uint8_t)whole;
    const int32_t narrow = (int32_t)whole;
    const float single = (float)real;
    const void *const from[] = {&byte, &narrow, &whole, &single, &real};
    static const uint8_t sizes[] = {1, 4, 8, 4, 8};
    char bytes[8];
    const size_t size = sizes[type];
    memcpy(bytes, from[type], size);
    for (size_t k = 0; k < size / 2 && swapped; k++) {
        const char t = bytes[k];
        bytes[k] = bytes[size - 1 - k];
        bytes[size - 1 - k] = t;
    }
    io_put_bytes(writer, bytes, size);
}

static void put_of_nodes(io_writer *writer, const io_view *view, const vtk_out_array *array,
                         int swapped) {
    double place[3];
    for (int64_t i = 0; i < array->n; i++) {
        if (array->values != VTK_OUT_COORDINATES) {
            put(writer, array->type, swapped, 0, node_value(view, array->values, i));
            continue;
        }
        io_view_place(view, i, place);
        for (int d = 0; d < 3; d++)
            put(writer, array->type, swapped, place[d], 0);
    }
}

static void put_of_cells(io_writer *writer, const io_view *view, const vtk_out_array *array,
                         int swapped) {
    const vtk_out_values values = array->values;
    const int is_real = measures_of(view, values) != NULL;
    int64_t end = 0;
    io_view_cell cell;
    for (int64_t i = 0; i < view->n_cells; i++) {
        cell_at(view, i, &cell);
        if (values == VTK_OUT_COUNTED_NODES)
            put(writer, array->type, swapped, 0, cell.n_nodes);
        if (values == VTK_OUT_COUNTED_NODES || values == VTK_OUT_NODES)
            for (int k = 0; k < cell.n_nodes; k++)
                put(writer, array->type, swapped, 0, cell.node[k]);
        else if (values == VTK_OUT_ENDS)
            put(writer, array->type, swapped, 0, end += cell.n_nodes);
        else if (is_real)
            put(writer, array->type, swapped, cell_measure(view, values, &cell), 0);
        else
            put(writer, array->type, swapped, 0, cell_value(view, array, &cell));
    }
}

/** Put component k of a value where VTK has it: the diagonal of a symmetric tensor comes first. */
static double component(const planish_data *data, const double *value, int k) {
    static const uint8_t order[] = {0, 2, 5, 1, 4, 3}; /* xx, yy, zz, xy, yz, xz */
    return value[data->n_components == 6 ? order[k] : k];
}

/** Put the values of a field; cells of a lower dimension have none. */
static void put_field(io_writer *writer, const io_view *view, const vtk_out_array *array,
                      int swapped) {
    planish_data data;
    if (writer->status)
        return;
    writer->status = view->load(view->file, array->field, &data, writer->error);
    io_view_cell cell = {.element = -1};
    for (int64_t i = 0; i < array->n && !writer->status; i++) {
        if (array->field->of_elements)
            io_view_cell_at(view, i, &cell);
        const int64_t at = array->field->of_elements ? cell.element : i;
        for (int k = 0; k < array->width; k++) {
            const double value =
                at < 0 ? (double)NAN : component(&data, data.values + at * array->width, k);
            const int is_whole = array->type != VTK_OUT_F64 && isfinite(value);
            put(writer, array->type, swapped, value, is_whole ? (int64_t)value : 0);
        }
    }
    planish_data_free(&data);
}

void vtk_put_array(io_writer *writer, const io_view *view, const vtk_out_array *array,
                   int swapped) {
    if (array->values == VTK_OUT_FIELD)
        put_field(writer, view, array, swapped);
    else if (array->values <= VTK_OUT_NODE_NUMBERS)
        put_of_nodes(writer, view, array, swapped);
    else
        put_of_cells(writer, view, array, swapped);
}

int64_t vtk_array_bytes(const vtk_out_array *array) {
    static const uint8_t sizes[] = {1, 4, 8, 4, 8};
    return array->n * array->width * sizes[array->type];
}

/* ---- the arrays ---------------------------------------------------------------------------- */

static void add(vtk_out_array *list, int *n, const char *name, vtk_out_values values,
                vtk_out_type type, int64_t n_values) {
    list[(*n)++] = (vtk_out_array){name, values, type, n_values, 1, NULL, NULL};
}

/** Add the measures that there are. */
static void add_measures(const io_view *view, vtk_out_arrays *a) {
    static const char *const names[] = {"radius_ratio", "aspect_ratio", "scaled_jacobian",
                                        "jacobian_ratio", "edge_ratio"};
    for (int i = 0; i < (int)(sizeof names / sizeof *names); i++)
        if (measures_of(view, VTK_OUT_RADIUS_RATIOS + (unsigned)i))
            add(a->cell_data, &a->n_cell_data, names[i], VTK_OUT_RADIUS_RATIOS + (unsigned)i,
                VTK_OUT_F64, view->n_cells);
    if (view->options->cells.state)
        add(a->cell_data, &a->n_cell_data, "cell_state", VTK_OUT_STATES, VTK_OUT_U8, view->n_cells);
    if (view->options->cells.is_curved)
        add(a->cell_data, &a->n_cell_data, "is_curved", VTK_OUT_CURVED, VTK_OUT_U8, view->n_cells);
}

/** Add the numbers of nodes or cells: of 32 bits, which all programs read, where they are no larger. */
static void add_numbers(const io_view *view, int of_cells, vtk_out_array *list, int *n) {
    const int64_t n_all = of_cells ? view->n_cells : view->model->n_nodes;
    int fits = 1;
    io_view_cell cell = {.number = 0};
    for (int64_t i = 0; i < n_all && fits; i++) {
        if (of_cells)
            io_view_cell_at(view, i, &cell);
        const int64_t number = of_cells ? cell.number : io_node_number(view->model, i);
        fits = number >= INT32_MIN && number <= INT32_MAX;
    }
    add(list, n, "number", of_cells ? VTK_OUT_CELL_NUMBERS : VTK_OUT_NODE_NUMBERS,
        fits ? VTK_OUT_I32 : VTK_OUT_I64, n_all);
}

/** Return whether an array of that name is in the list: the file's own must not be there twice. */
static int has_name(const vtk_out_array *list, int n, const char *name) {
    for (int i = 0; i < n; i++)
        if (strcmp(list[i].name, name) == 0)
            return 1;
    return 0;
}

/** Add the arrays of the file; those whose names planish gives to its own are lost. */
static void add_fields(const io_view *view, io_losses *losses, vtk_out_arrays *a) {
    for (int i = 0; i < view->n_fields; i++) {
        const io_view_field *f = &view->field[i];
        vtk_out_array *list = f->of_elements ? a->cell_data : a->point_data;
        int *n = f->of_elements ? &a->n_cell_data : &a->n_point_data;
        if (has_name(list, *n, f->name)) {
            io_losses_add(losses, "the file's own array '%.64s'", f->name);
            continue;
        }
        list[(*n)++] = (vtk_out_array){f->name,
                                       VTK_OUT_FIELD,
                                       f->is_narrow    ? VTK_OUT_I32
                                       : f->is_integer ? VTK_OUT_I64
                                                       : VTK_OUT_F64,
                                       f->of_elements ? view->n_cells : view->model->n_nodes,
                                       f->width,
                                       f,
                                       NULL};
    }
}

static void add_cell_data(const io_view *view, vtk_out_arrays *a) {
    const io_model *model = view->model;
    int has_groups = 0;
    add_measures(view, a);
    if (model->n_entities > 0 || io_model_elements(model)->region ||
        io_model_other_elements(model)->region)
        add(a->cell_data, &a->n_cell_data, "region", VTK_OUT_REGIONS, VTK_OUT_I32, view->n_cells);
    for (int32_t i = 0; i < model->n_entities; i++)
        has_groups |= model->entity[i].dim > 0 && model->entity[i].n_physical > 0;
    if (has_groups)
        add(a->cell_data, &a->n_cell_data, groups_name, VTK_OUT_GROUPS, VTK_OUT_I32, view->n_cells);
    add_numbers(view, 1, a->cell_data, &a->n_cell_data);
}

/** Note solids that have a negative volume, as most of their type; VTK's wedges do. */
static void lose_volumes(const io_view *view, io_losses *losses) {
    int64_t n = 0;
    io_view_cell cell;
    for (int64_t i = 0; i < view->n_cells; i++) {
        io_view_cell_at(view, i, &cell);
        n += view->is_mirrored[cell.type] && io_cell_type_straight(cell.type) != PLANISH_CELL_WEDGE;
    }
    if (n > 0)
        io_losses_add(losses,
                      "positive volumes of %lld solids (they keep the order of their nodes)",
                      (long long)n);
}

/** Note pyramids whose node in the base is not written. */
static void lose_bases(const io_view *view, io_losses *losses) {
    int64_t n = 0;
    io_view_cell cell;
    for (int64_t i = 0; i < view->n_cells; i++) {
        io_view_cell_at(view, i, &cell);
        n += cell.type == PLANISH_CELL_PYRAMID14;
    }
    if (n > 0)
        io_losses_add(losses, "nodes in the base of %lld pyramids", (long long)n);
}

int vtk_arrays_begin(const io_view *view, io_losses *losses, vtk_out_arrays *a,
                     planish_error *error) {
    const io_model *model = view->model;
    const vtk_out_type real =
        model->precision == PLANISH_PRECISION_FLOAT ? VTK_OUT_F32 : VTK_OUT_F64;
    const int64_t n = view->n_cells;
    int64_t n_nodes = 0;
    io_view_cell cell;
    for (int64_t i = 0; i < n; i++) {
        cell_at(view, i, &cell);
        n_nodes += cell.n_nodes;
    }
    *a = (vtk_out_arrays){
        .points = {"Points", VTK_OUT_COORDINATES, real, model->n_nodes, 3, NULL, NULL},
        .connectivity = {"connectivity", VTK_OUT_NODES, VTK_OUT_I32, n_nodes, 1, NULL, NULL},
        .offsets = {"offsets", VTK_OUT_ENDS, VTK_OUT_I64, n, 1, NULL, NULL},
        .types = {"types", VTK_OUT_TYPES, VTK_OUT_U8, n, 1, NULL, NULL},
        .wide_types = {"types", VTK_OUT_TYPES, VTK_OUT_I32, n, 1, NULL, NULL},
        .counted = {"cells", VTK_OUT_COUNTED_NODES, VTK_OUT_I32, n_nodes + n, 1, NULL, NULL},
        .point_data = pl_alloc(N_OWN_DATA + view->n_fields, sizeof *a->point_data),
        .cell_data = pl_alloc(N_OWN_DATA + view->n_fields, sizeof *a->cell_data)};
    if (!a->point_data || !a->cell_data)
        return pl_fail_memory(error, "arrays to be written");
    if (view->options->constraint)
        add(a->point_data, &a->n_point_data, "fixed", VTK_OUT_FIXED, VTK_OUT_U8, model->n_nodes);
    add_numbers(view, 0, a->point_data, &a->n_point_data);
    add_cell_data(view, a);
    add_fields(view, losses, a);
    io_view_lose_further(view, losses);
    lose_volumes(view, losses);
    lose_bases(view, losses);
    return PLANISH_OK;
}

/** Return the array called as that of groups, or NULL. */
static vtk_out_array *find_groups(const vtk_out_arrays *a) {
    for (int i = 0; i < a->n_cell_data; i++)
        if (strcmp(a->cell_data[i].name, groups_name) == 0)
            return &a->cell_data[i];
    return NULL;
}

int vtk_arrays_can_have_groups(const vtk_out_arrays *arrays) {
    const vtk_out_array *found = find_groups(arrays);
    return !found || found->values == VTK_OUT_GROUPS;
}

void vtk_arrays_set_groups(const io_view *view, const int32_t *number, vtk_out_arrays *arrays) {
    if (!find_groups(arrays))
        add(arrays->cell_data, &arrays->n_cell_data, groups_name, VTK_OUT_GROUPS, VTK_OUT_I32,
            view->n_cells);
    find_groups(arrays)->number = number;
}

void vtk_arrays_end(vtk_out_arrays *arrays) {
    pl_free(arrays->point_data);
    pl_free(arrays->cell_data);
}
