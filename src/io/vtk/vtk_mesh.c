/* vtk_mesh: POINTS, CELLS and CELL_TYPES of legacy VTK files.
 *
 * CELLS and CELL_TYPES are read to lists first, by several threads where they are long; when both
 * are there, simplices go to the model and all other cells hold their nodes.
 */
#include "io/vtk/vtk.h"

#include "io/vtk/vtk_cells.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"

/* ---- points ------------------------------------------------------------------------------- */

typedef struct point_block {
    vtk_reader *reader;
    int size; /* bytes of a coordinate */
} point_block;

static int read_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                       planish_error *error) {
    const point_block *points = context;
    io_model *model = points->reader->model;
    for (int64_t node = begin; node < end; node++) {
        int status;
        if (model->is_binary) {
            status = io_load_point(model, cursor->at, points->size, points->reader->swapped, node,
                                   error);
            cursor->at += 3 * points->size;
        } else {
            status = io_read_point(model, cursor, node, error);
        }
        if (status)
            return status;
    }
    return PLANISH_OK;
}

int vtk_points(vtk_reader *reader) {
    int64_t n;
    vtk_word name;
    if (reader->have_points)
        return vtk_fail_here(reader, "there is a second POINTS");
    if (io_integer(&reader->cursor, &n))
        return vtk_fail_here(reader, "POINTS: number of points expected");
    name.at = io_word(&reader->cursor, &name.length);
    const vtk_type *type = vtk_find_type(name);
    if (!type || type->kind != VTK_REAL)
        return io_fail_at(reader->model, name.at, reader->error,
                          "POINTS of this type are not read: float or double expected");
    if (reader->model->is_binary)
        vtk_end_line(&reader->cursor);
    const int stride = 3 * type->size;
    int status = io_check_count(reader->model, reader->cursor, n,
                                reader->model->is_binary ? stride : 6, "points", reader->error);
    if (!status)
        status = io_model_points(reader->model, n, type->size, stride, reader->swapped,
                                 reader->cursor.at, reader->error);
    if (status)
        return status;
    reader->have_points = 1;
    point_block points = {reader, type->size};
    return io_records(&reader->text, &reader->cursor, n, 3, stride, read_points, &points,
                      reader->error);
}

/* ---- lists of integers -------------------------------------------------------------------- */

typedef struct integer_list {
    vtk_reader *reader;
    int size;        /* bytes of a number in a binary file: 4 or 8 */
    int32_t *narrow; /* where numbers go: here (those that do not fit fail) */
    int64_t *wide;   /* or here */
} integer_list;

static int read_list(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                     planish_error *error) {
    const integer_list *list = context;
    const int swapped = list->reader->swapped;
    const io_model *model = list->reader->model;
    for (int64_t i = begin; i < end; i++) {
        const char *at = cursor->at;
        int64_t value;
        if (model->is_binary) {
            value = list->size == 4 ? io_load_i32(cursor->at, swapped)
                                    : io_load_i64(cursor->at, swapped);
            cursor->at += list->size;
        } else if (io_integer(cursor, &value)) {
            return io_fail_at(model, cursor->at, error,
                              "CELLS or CELL_TYPES: integer expected (the file may be cut short)");
        }
        if (list->wide)
            list->wide[i] = value;
        else if (value >= INT32_MIN && value <= INT32_MAX)
            list->narrow[i] = (int32_t)value;
        else
            return io_fail_at(model, model->is_binary ? at : cursor->at, error,
                              "an index or type is out of range");
    }
    return PLANISH_OK;
}

/** n integers from the cursor to a new array: *narrow or *wide, the other is NULL. */
static int read_integers(vtk_reader *reader, int64_t n, int size, int32_t **narrow,
                         int64_t **wide) {
    int status =
        io_check_room(reader->model, reader->cursor, n, reader->model->is_binary ? size : 2,
                      "numbers of CELLS or CELL_TYPES", reader->error);
    if (status)
        return status;
    integer_list list = {reader, size, NULL, NULL};
    if (narrow)
        *narrow = list.narrow = pl_alloc(n, sizeof **narrow);
    else
        *wide = list.wide = pl_alloc(n, sizeof **wide);
    if (!list.narrow && !list.wide)
        return pl_fail_memory(reader->error, "the cells");
    return io_records(&reader->text, &reader->cursor, n, 1, size, read_list, &list, reader->error);
}

/* ---- cells -------------------------------------------------------------------------------- */

/** Behind OFFSETS or CONNECTIVITY: the type of the numbers. */
static int take_list_type(vtk_reader *reader, int *size) {
    vtk_word name;
    name.at = io_word(&reader->cursor, &name.length);
    const vtk_type *type = vtk_find_type(name);
    if (!type || type->kind != VTK_SIGNED || type->size < 4)
        return io_fail_at(reader->model, name.at, reader->error,
                          "OFFSETS and CONNECTIVITY of this type are not read: "
                          "vtktypeint64 or vtktypeint32 expected");
    if (reader->model->is_binary)
        vtk_end_line(&reader->cursor);
    *size = type->size;
    return 0;
}

static int check_offsets(const vtk_reader *reader) {
    const int64_t *offset = reader->offset;
    int ordered = offset[0] == 0 && offset[reader->n_cells] <= reader->n_connectivity;
    for (int64_t i = 0; ordered && i < reader->n_cells; i++)
        ordered = offset[i] <= offset[i + 1];
    return ordered ? 0 : vtk_fail_here(reader, "OFFSETS do not rise from 0 to the size of CELLS");
}

/** CELLS of version 5, behind the word OFFSETS. */
static int read_offset_cells(vtk_reader *reader, int64_t n_offsets) {
    int size = 0; /* for compilers that do not see that a failure is not 0 */
    int64_t length;
    if (n_offsets < 1)
        return vtk_fail_here(reader, "CELLS: at least one offset expected");
    int status = take_list_type(reader, &size);
    if (!status)
        status = read_integers(reader, n_offsets, size, NULL, &reader->offset);
    if (status)
        return status;
    reader->n_cells = n_offsets - 1;
    const char *at = io_word(&reader->cursor, &length);
    if (!io_word_is(at, length, "CONNECTIVITY", 1))
        return io_fail_at(reader->model, at, reader->error, "CONNECTIVITY expected");
    status = take_list_type(reader, &size);
    if (!status)
        status = read_integers(reader, reader->n_connectivity, size, &reader->connectivity, NULL);
    return status ? status : check_offsets(reader);
}

int vtk_cells(vtk_reader *reader) {
    int64_t n;
    if (reader->connectivity || reader->offset)
        return vtk_fail_here(reader, "there is a second CELLS");
    if (io_integer(&reader->cursor, &n) || io_integer(&reader->cursor, &reader->n_connectivity))
        return vtk_fail_here(reader, "CELLS: number of cells and size of the list expected");
    if (reader->model->is_binary)
        vtk_end_line(&reader->cursor);
    if (vtk_take_if(reader, "OFFSETS"))
        return read_offset_cells(reader, n);
    if (n < 0 || n > reader->n_connectivity)
        return vtk_fail_here(reader, "CELLS: more cells than numbers in their list");
    reader->n_cells = n;
    return read_integers(reader, reader->n_connectivity, 4, &reader->connectivity, NULL);
}

void vtk_release_lists(vtk_reader *reader) {
    pl_free(reader->connectivity);
    pl_free(reader->offset);
    pl_free(reader->type);
    reader->connectivity = NULL;
    reader->offset = NULL;
    reader->type = NULL;
}

int vtk_cell_types(vtk_reader *reader) {
    int64_t n;
    if (reader->have_types || !reader->have_points || !reader->connectivity)
        return vtk_fail_here(reader, "CELL_TYPES must come once, behind POINTS and CELLS");
    if (io_integer(&reader->cursor, &n) || n != reader->n_cells)
        return vtk_fail_here(reader, "CELL_TYPES: as many types as cells expected");
    if (reader->model->is_binary)
        vtk_end_line(&reader->cursor);
    int status = read_integers(reader, n, 4, &reader->type, NULL);
    const vtk_grid cells = {.n = reader->n_cells,
                            .connectivity = reader->connectivity,
                            .n_connectivity = reader->n_connectivity,
                            .offset = reader->offset,
                            .type = reader->type,
                            .n_points = reader->model->n_nodes,
                            .has_streams = 1};
    if (!status)
        status = vtk_cells_store(reader->model, &cells, reader->error);
    reader->have_types = 1;
    vtk_release_lists(reader);
    return status;
}
