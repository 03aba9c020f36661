/* vtk: legacy VTK files, ASCII and binary, versions 1 to 4.2 (CELLS with counts) and 5 (CELLS with
 * OFFSETS and CONNECTIVITY): unstructured grids of tetrahedra or triangles.
 *
 * A point-data array called "fixed" (Mesquite's convention) marks nodes that must not move; arrays
 * of one whole number per cell may tell regions (arrays.h). All other attributes are passed over;
 * the walk ends, without error, at anything unknown behind the mesh. Binary data are big-endian.
 * CELLS and CELL_TYPES are read to lists, by several threads where they are long; when both are
 * there, vtk_cells.c makes the elements of them.
 */
#include "io/vtk/vtk_write.h"
#include "io/vtk/vtk_reader.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"
#include "io/core/format.h"
#include "io/vtk/vtk_numbers.h"

#include <string.h>

/* ---- points ------------------------------------------------------------------------------- */

static int take_points(vtk_reader *reader) {
    io_model *model = reader->model;
    int64_t n;
    if (reader->have_points)
        return vtk_fail_here(reader, "there is a second POINTS");
    if (io_integer(&reader->cursor, &n))
        return vtk_fail_here(reader, "POINTS: number of points expected");
    const io_slice name = io_next_word(&reader->cursor);
    const vtk_type *type = vtk_find_type(name);
    if (!type || type->kind != VTK_REAL)
        return io_fail_at(model, name.begin, reader->error,
                          "POINTS of this type are not read: float or double expected");
    if (model->is_binary)
        vtk_end_line(&reader->cursor);
    const int stride = 3 * type->size;
    int status = io_check_count(model, reader->cursor, n, model->is_binary ? stride : 6, "points",
                                reader->error);
    if (!status)
        status = io_model_make_nodes(model, n, type->size, stride, reader->swapped,
                                     reader->cursor.at, reader->error);
    if (status)
        return status;
    reader->have_points = 1;
    reader->grid.n_points = n;
    io_node_records points = {model, 0, type->size, reader->swapped};
    return io_records(&reader->text, &reader->cursor, n, 3, stride, io_read_nodes, &points,
                      reader->error);
}

/* ---- cells -------------------------------------------------------------------------------- */

/** Read n integers, binary ones of that type, to a new array: *narrow or *wide, the other is NULL.
 */
static int read_integers(vtk_reader *reader, int64_t n, const vtk_type *type, int32_t **narrow,
                         int64_t **wide) {
    io_model *model = reader->model;
    vtk_list list = {.model = model,
                     .name = "CELLS or CELL_TYPES",
                     .type = model->is_binary ? type : NULL,
                     .swapped = reader->swapped};
    const int status = io_check_room(model, reader->cursor, n, model->is_binary ? type->size : 2,
                                     "numbers of CELLS or CELL_TYPES", reader->error);
    if (status)
        return status;
    if (narrow)
        *narrow = list.narrow = pl_alloc(n, sizeof **narrow);
    else
        *wide = list.wide = pl_alloc(n, sizeof **wide);
    if (!list.narrow && !list.wide)
        return pl_fail_memory(reader->error, "the cells");
    return io_records(&reader->text, &reader->cursor, n, 1, type->size, vtk_read_list, &list,
                      reader->error);
}

/** Take the type of the numbers behind OFFSETS or CONNECTIVITY. */
static int take_list_type(vtk_reader *reader, const vtk_type **type) {
    const io_slice name = io_next_word(&reader->cursor);
    *type = vtk_find_type(name);
    if (!*type || (*type)->kind != VTK_SIGNED || (*type)->size < 4)
        return io_fail_at(reader->model, name.begin, reader->error,
                          "OFFSETS and CONNECTIVITY of this type are not read: "
                          "vtktypeint64 or vtktypeint32 expected");
    if (reader->model->is_binary)
        vtk_end_line(&reader->cursor);
    return PLANISH_OK;
}

static const vtk_type integer = {"int", VTK_SIGNED, 4};

static int take_cells(vtk_reader *reader) {
    vtk_grid *grid = &reader->grid;
    const vtk_type *type;
    if (grid->connectivity || grid->offset)
        return vtk_fail_here(reader, "there is a second CELLS");
    if (io_integer(&reader->cursor, &grid->n) || io_integer(&reader->cursor, &grid->n_connectivity))
        return vtk_fail_here(reader, "CELLS: number of cells and size of the list expected");
    if (reader->model->is_binary)
        vtk_end_line(&reader->cursor);
    if (!vtk_take_if(reader, "OFFSETS")) {
        if (grid->n < 0 || grid->n > grid->n_connectivity)
            return vtk_fail_here(reader, "CELLS: more cells than numbers in their list");
        return read_integers(reader, grid->n_connectivity, &integer, &grid->connectivity, NULL);
    }
    /* Version 5: the number of cells is that of the offsets. */
    const int64_t n_offsets = grid->n--;
    if (n_offsets < 1)
        return vtk_fail_here(reader, "CELLS: at least one offset expected");
    int status = take_list_type(reader, &type);
    if (!status)
        status = read_integers(reader, n_offsets, type, NULL, &grid->offset);
    if (status)
        return status;
    const io_slice word = io_next_word(&reader->cursor);
    if (!io_slice_is(word, "CONNECTIVITY", 1))
        return io_fail_at(reader->model, word.begin, reader->error, "CONNECTIVITY expected");
    status = take_list_type(reader, &type);
    return status ? status
                  : read_integers(reader, grid->n_connectivity, type, &grid->connectivity, NULL);
}

static int take_cell_types(vtk_reader *reader) {
    int64_t n;
    if (reader->have_types || !reader->have_points || !reader->grid.connectivity)
        return vtk_fail_here(reader, "CELL_TYPES must come once, behind POINTS and CELLS");
    if (io_integer(&reader->cursor, &n) || n != reader->grid.n)
        return vtk_fail_here(reader, "CELL_TYPES: as many types as cells expected");
    if (reader->model->is_binary)
        vtk_end_line(&reader->cursor);
    int status = read_integers(reader, n, &integer, &reader->grid.type, NULL);
    if (!status)
        status = vtk_cells_store(reader->model, &reader->grid, reader->error);
    reader->have_types = 1;
    vtk_grid_release(&reader->grid);
    return status;
}

/* ---- header and keywords ------------------------------------------------------------------ */

/** Read the data of a keyword. */
static int read_keyword(vtk_reader *reader, io_slice word) {
    if (io_slice_is(word, "POINTS", 1))
        return take_points(reader);
    if (io_slice_is(word, "CELLS", 1))
        return take_cells(reader);
    if (io_slice_is(word, "CELL_TYPES", 1))
        return take_cell_types(reader);
    if (!io_slice_is(word, "DATASET", 1))
        return vtk_read_data(reader, word);
    word = io_next_word(&reader->cursor);
    return io_slice_is(word, "UNSTRUCTURED_GRID", 1)
               ? PLANISH_OK
               : io_fail_at(reader->model, word.begin, reader->error,
                            "DATASET is not an UNSTRUCTURED_GRID; convert the file, for instance "
                            "with meshio convert IN.vtk OUT.msh");
}

/** Read the first three lines (version, title, ASCII or BINARY) and the keywords behind them. */
static int read_file(vtk_reader *reader) {
    io_model *model = reader->model;
    int status = PLANISH_OK;
    vtk_end_line(&reader->cursor);
    vtk_end_line(&reader->cursor);
    io_slice word = io_next_word(&reader->cursor);
    model->is_binary = io_slice_is(word, "BINARY", 1);
    if (!model->is_binary && !io_slice_is(word, "ASCII", 1))
        return io_fail_at(model, word.begin, reader->error,
                          "ASCII or BINARY expected in the third line");
    vtk_end_line(&reader->cursor);
    while (!reader->done && !status && io_slice_length(word = io_next_word(&reader->cursor)) > 0)
        status = read_keyword(reader, word);
    if (!status && !reader->have_types)
        return vtk_fail_here(reader, "the file ends before CELL_TYPES (it may be cut short)");
    return status;
}

static int vtk_read(io_model *model, planish_error *error) {
    vtk_reader reader = {.model = model,
                         .error = error,
                         .cursor = {model->input.data, io_input_end(model)},
                         .swapped = io_machine_is_little(),
                         .grid = {.has_streams = 1},
                         .n_tuples = -1};
    io_text_init(&reader.text, model);
    const int status = read_file(&reader);
    vtk_grid_release(&reader.grid);
    io_text_release(&reader.text);
    return status;
}

static int vtk_recognise(const char *data, int64_t size) {
    static const char mark[] = "# vtk DataFile";
    const int64_t length = (int64_t)sizeof mark - 1;
    return size >= length && io_slice_is((io_slice){data, data + length}, mark, 1);
}

static const char *const vtk_extensions[] = {".vtk", NULL};

static const io_target vtk_targets[] = {{"vtk", vtk_write}, {NULL, NULL}};

const io_format io_format_vtk = {.name = "vtk",
                                 .extensions = vtk_extensions,
                                 .recognise = vtk_recognise,
                                 .read = vtk_read,
                                 .read_data = vtk_read_values,
                                 .targets = vtk_targets};
