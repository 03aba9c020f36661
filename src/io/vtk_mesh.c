/* vtk_mesh: POINTS, CELLS and CELL_TYPES of legacy VTK files.
 *
 * CELLS and CELL_TYPES are read to lists first, by several threads where they are long; when both
 * are there, simplices go to the model and all other cells hold their nodes.
 */
#include "io/vtk.h"

#include <math.h>
#include <string.h>

#include "base/memory.h"
#include "base/status.h"
#include "io/binary.h"

/* Refuse counts that the rest of the file cannot hold. In text a number is two bytes. */
static int check_count(const vtk_reader *reader, int64_t n, int64_t numbers, int size) {
    int64_t bytes = reader->binary ? size * numbers : 2 * numbers;
    if (n < 0 || n > (io_left(&reader->cursor) + !reader->binary) / bytes)
        return vtk_fail_here(
            reader, "the rest of the file cannot hold that many (cut short, or wrong count)");
    return 0;
}

/* ---- points ------------------------------------------------------------------------------- */

struct points {
    vtk_reader *reader;
    int size; /* bytes of a coordinate */
};

static int read_text_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                            planish_error *error) {
    const struct points *points = context;
    int status = 0;
    for (int64_t node = begin; status == 0 && node < end; node++)
        status = io_read_point(points->reader->model, cursor, node, error);
    return status;
}

static int read_binary_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                              planish_error *error) {
    const struct points *points = context;
    io_model *model = points->reader->model;
    int swapped = points->reader->swapped;
    for (int64_t i = 3 * begin; i < 3 * end; i++, cursor->at += points->size) {
        model->xyz[i] = points->size == 4 ? (double)io_load_f32(cursor->at, swapped)
                                          : io_load_f64(cursor->at, swapped);
        if (!isfinite(model->xyz[i]))
            return io_fail_byte(model, cursor->at, error,
                                "point %lld has a coordinate that is not finite",
                                (long long)(i / 3));
    }
    return 0;
}

/* The points behind their line, n of them of size bytes a coordinate. */
static int read_points_data(vtk_reader *reader, int64_t n, int size) {
    io_model *model = reader->model;
    struct points points = {reader, size};
    io_span span = {.n_nodes = n, .encoding = IO_TEXT};
    if (reader->binary)
        span = (io_span){.n_nodes = n,
                         .encoding = size == 4 ? IO_FLOAT32 : IO_FLOAT64,
                         .swapped = reader->swapped,
                         .offset = reader->cursor.at - model->input.data,
                         .stride = 3 * size};
    int status = io_model_nodes(model, n, !reader->binary, reader->error);
    if (status == 0)
        status = io_model_span(model, span, reader->error);
    if (status == 0 && reader->binary)
        status = io_binary_records(model->threads, &reader->cursor, n, 3 * size, read_binary_points,
                                   &points, reader->error);
    else if (status == 0)
        status = io_text_records(&reader->text, &reader->cursor, n, 3, read_text_points, &points,
                                 reader->error);
    return status;
}

int vtk_points(vtk_reader *reader) {
    int64_t n;
    vtk_word name;
    if (reader->have_points)
        return vtk_fail_here(reader, "there is a second POINTS");
    if (io_integer(&reader->cursor, &n) != 0)
        return vtk_fail_here(reader, "POINTS: number of points expected");
    name.at = io_word(&reader->cursor, &name.length);
    const vtk_type *type = vtk_find_type(name);
    if (type == NULL || type->kind != VTK_REAL)
        return vtk_fail_at(reader, name.at,
                           "POINTS of this type are not read: float or double expected");
    if (reader->binary)
        vtk_end_line(&reader->cursor);
    int status = check_count(reader, n, 3, type->size);
    if (status != 0)
        return status;
    reader->have_points = 1;
    reader->model->precision = type->size == 4 ? PLANISH_FLOAT : PLANISH_DOUBLE;
    return read_points_data(reader, n, type->size);
}

/* ---- lists of integers -------------------------------------------------------------------- */

struct integers {
    vtk_reader *reader;
    int size;        /* bytes of a number in a binary file: 4 or 8 */
    int32_t *narrow; /* where numbers go: here (those that do not fit fail) */
    int64_t *wide;   /* or here */
};

static int put_integer(const struct integers *list, const char *at, int64_t index, int64_t value,
                       planish_error *error) {
    if (list->wide != NULL) {
        list->wide[index] = value;
        return 0;
    }
    list->narrow[index] = (int32_t)value;
    if (value >= INT32_MIN && value <= INT32_MAX)
        return 0;
    if (error == NULL)
        return PLANISH_ERROR_FORMAT;
    return vtk_fail_at(list->reader, at, "an index or type is out of range");
}

static int read_text_integers(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                              planish_error *error) {
    const struct integers *list = context;
    int64_t value;
    for (int64_t i = begin; i < end; i++) {
        if (io_integer(cursor, &value) != 0)
            return error == NULL
                       ? PLANISH_ERROR_FORMAT
                       : vtk_fail_at(list->reader, cursor->at,
                                     "CELLS or CELL_TYPES: integer expected (the file may be cut "
                                     "short)");
        if (put_integer(list, cursor->at, i, value, error) != 0)
            return PLANISH_ERROR_FORMAT;
    }
    return 0;
}

static int read_binary_integers(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                                planish_error *error) {
    const struct integers *list = context;
    int swapped = list->reader->swapped;
    for (int64_t i = begin; i < end; i++, cursor->at += list->size) {
        int64_t value =
            list->size == 4 ? io_load_i32(cursor->at, swapped) : io_load_i64(cursor->at, swapped);
        if (put_integer(list, cursor->at, i, value, error) != 0)
            return PLANISH_ERROR_FORMAT;
    }
    return 0;
}

/* n integers from the cursor to a new array: *narrow or *wide, the other is NULL. */
static int read_integers(vtk_reader *reader, int64_t n, int size, int32_t **narrow,
                         int64_t **wide) {
    int status = check_count(reader, n, 1, size);
    if (status != 0)
        return status;
    struct integers list = {reader, size, NULL, NULL};
    if (narrow != NULL)
        *narrow = list.narrow = pl_alloc(n, sizeof **narrow);
    else
        *wide = list.wide = pl_alloc(n, sizeof **wide);
    if (list.narrow == NULL && list.wide == NULL)
        return pl_fail_memory(reader->error, "the cells");
    if (reader->binary)
        return io_binary_records(reader->model->threads, &reader->cursor, n, size,
                                 read_binary_integers, &list, reader->error);
    return io_text_records(&reader->text, &reader->cursor, n, 1, read_text_integers, &list,
                           reader->error);
}

/* ---- cells -------------------------------------------------------------------------------- */

/* Behind OFFSETS or CONNECTIVITY: the type of the numbers. */
static int take_list_type(vtk_reader *reader, int *size) {
    vtk_word name;
    name.at = io_word(&reader->cursor, &name.length);
    const vtk_type *type = vtk_find_type(name);
    if (type == NULL || type->kind != VTK_SIGNED || type->size < 4)
        return vtk_fail_at(reader, name.at,
                           "OFFSETS and CONNECTIVITY of this type are not read: "
                           "vtktypeint64 or vtktypeint32 expected");
    if (reader->binary)
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

/* CELLS of version 5, behind the word OFFSETS. */
static int read_offset_cells(vtk_reader *reader, int64_t n_offsets) {
    int size;
    int64_t length;
    if (n_offsets < 1)
        return vtk_fail_here(reader, "CELLS: at least one offset expected");
    int status = take_list_type(reader, &size);
    if (status == 0)
        status = read_integers(reader, n_offsets, size, NULL, &reader->offset);
    if (status != 0)
        return status;
    reader->n_cells = n_offsets - 1;
    const char *at = io_word(&reader->cursor, &length);
    if (!io_word_is(at, length, "CONNECTIVITY", 1))
        return vtk_fail_at(reader, at, "CONNECTIVITY expected");
    status = take_list_type(reader, &size);
    if (status == 0)
        status = read_integers(reader, reader->n_connectivity, size, &reader->connectivity, NULL);
    return status != 0 ? status : check_offsets(reader);
}

int vtk_cells(vtk_reader *reader) {
    int64_t n;
    if (reader->connectivity != NULL || reader->offset != NULL)
        return vtk_fail_here(reader, "there is a second CELLS");
    if (io_integer(&reader->cursor, &n) != 0 ||
        io_integer(&reader->cursor, &reader->n_connectivity) != 0)
        return vtk_fail_here(reader, "CELLS: number of cells and size of the list expected");
    if (reader->binary)
        vtk_end_line(&reader->cursor);
    if (vtk_take_if(reader, "OFFSETS"))
        return read_offset_cells(reader, n);
    if (n < 0 || n > reader->n_connectivity)
        return vtk_fail_here(reader, "CELLS: more cells than numbers in their list");
    reader->n_cells = n;
    return read_integers(reader, reader->n_connectivity, 4, &reader->connectivity, NULL);
}

typedef enum cell_class {
    CELL_LINE,
    CELL_LOWER,
    CELL_OTHER,
    CELL_TRIANGLE,
    CELL_TETRAHEDRON,
    CELL_REFUSED
} cell_class;

enum { VTK_LINE = 3, VTK_TRIANGLE = 5, VTK_TETRAHEDRON = 10, VTK_LAST_TYPE = 81 };

static cell_class class_of(int32_t type) {
    switch (type) {
    case VTK_TRIANGLE:
        return CELL_TRIANGLE;
    case VTK_TETRAHEDRON:
        return CELL_TETRAHEDRON;
    case VTK_LINE:
        return CELL_LINE;
    case 1: /* vertices and lines, of any order */
    case 2:
    case 4:
    case 21:
    case 35:
    case 51:
    case 60:
    case 68:
    case 75:
        return CELL_LOWER;
    case 22: /* triangles and tetrahedra of higher order */
    case 24:
    case 34:
    case 61:
    case 64:
    case 69:
    case 71:
    case 76:
    case 78:
        return CELL_REFUSED;
    default:
        return CELL_OTHER;
    }
}

/* A walk over the cells; nodes and n are those of the cell that next_cell came to. */
struct cell_walk {
    const vtk_reader *reader;
    int64_t index; /* of the next cell */
    int64_t place; /* of its nodes in connectivity */
    const int32_t *nodes;
    int64_t n;
};

static int fail_cell(const vtk_reader *reader, int64_t cell, const char *text) {
    return pl_fail_at(reader->error, PLANISH_ERROR_FORMAT, cell, -1, "%s: cell %lld (from 0): %s",
                      reader->model->input.path, (long long)cell, text);
}

static int next_cell(struct cell_walk *walk) {
    const vtk_reader *reader = walk->reader;
    if (reader->offset != NULL) {
        walk->nodes = reader->connectivity + reader->offset[walk->index];
        walk->n = reader->offset[walk->index + 1] - reader->offset[walk->index];
    } else {
        int64_t left = reader->n_connectivity - walk->place;
        walk->n = left > 0 ? reader->connectivity[walk->place] : -1;
        if (walk->n < 0 || walk->n > left - 1)
            return fail_cell(reader, walk->index, "its nodes are not in the list of CELLS");
        walk->nodes = reader->connectivity + walk->place + 1;
        walk->place += 1 + walk->n;
    }
    walk->index++;
    return 0;
}

/* What was found of one class: how many, and the first and last of them. */
struct tally {
    int64_t n, first, last;
};

/* A line of another number of nodes than two is a polyline. */
static cell_class class_at(const vtk_reader *reader, const struct cell_walk *walk, int64_t cell) {
    cell_class class = class_of(reader->type[cell]);
    return class == CELL_LINE && walk->n != 2 ? CELL_LOWER : class;
}

static void count_in(struct tally *tally, int64_t cell) {
    if (tally->n++ == 0)
        tally->first = cell;
    tally->last = cell;
}

static int check_cell(const vtk_reader *reader, const struct cell_walk *walk, int64_t cell) {
    int32_t type = reader->type[cell];
    int64_t n_nodes = reader->model->n_nodes;
    if (type < 0 || type > VTK_LAST_TYPE || type == 42)
        return fail_cell(reader, cell, "cells of this type are not read");
    if (class_of(type) == CELL_REFUSED)
        return fail_cell(reader, cell,
                         "triangles and tetrahedra of higher order are not smoothed, only straight "
                         "ones; mesh again with first order");
    if ((type == VTK_TRIANGLE && walk->n != 3) || (type == VTK_TETRAHEDRON && walk->n != 4))
        return fail_cell(reader, cell, "it has not as many nodes as its type");
    for (int64_t i = 0; i < walk->n; i++)
        if (walk->nodes[i] < 0 || walk->nodes[i] >= n_nodes)
            return fail_cell(reader, cell, "one of its nodes is not among the points");
    return 0;
}

/* Check all cells, count the simplices, hold the nodes of all others. */
static int survey_cells(const vtk_reader *reader, struct tally *lines, struct tally *triangles,
                        struct tally *tetrahedra) {
    io_model *model = reader->model;
    struct cell_walk walk = {.reader = reader};
    for (int64_t cell = 0; cell < reader->n_cells; cell++) {
        int status = next_cell(&walk);
        if (status == 0)
            status = check_cell(reader, &walk, cell);
        if (status != 0)
            return status;
        cell_class class = class_at(reader, &walk, cell);
        if (class == CELL_TETRAHEDRON) {
            count_in(tetrahedra, cell);
        } else if (class == CELL_TRIANGLE) {
            count_in(triangles, cell);
        } else if (class == CELL_LINE) {
            count_in(lines, cell);
        } else {
            *(class == CELL_LOWER ? &model->n_lower : &model->n_other) += 1;
            for (int64_t i = 0; i < walk.n; i++)
                io_hold_node(model, walk.nodes[i],
                             class == CELL_LOWER ? IO_HELD_BY_LOWER : IO_HELD_BY_OTHER);
        }
    }
    return 0;
}

/* Room for the cells counted, numbered by VTK's count of all cells. */
static int reserve(io_cells *cells, int dim, const struct tally *tally, planish_error *error) {
    int gaps = tally->n > 0 && tally->last - tally->first + 1 != tally->n;
    cells->first_number = tally->first;
    return io_cells_reserve(cells, dim, tally->n, 0, gaps, error);
}

static void store(io_cells *cells, int corners, const int32_t *nodes, int64_t number) {
    memcpy(cells->nodes + cells->n * corners, nodes, (size_t)corners * sizeof *nodes);
    if (cells->number != NULL)
        cells->number[cells->n] = number;
    cells->n++;
}

static int store_cells(const vtk_reader *reader) {
    io_model *model = reader->model;
    struct tally lines = {0, 0, 0}, triangles = {0, 0, 0}, tetrahedra = {0, 0, 0};
    struct cell_walk walk = {.reader = reader};
    int status = survey_cells(reader, &lines, &triangles, &tetrahedra);
    if (status == 0)
        status = reserve(&model->line, 1, &lines, reader->error);
    if (status == 0)
        status = reserve(&model->triangle, 2, &triangles, reader->error);
    if (status == 0)
        status = reserve(&model->tetrahedron, 3, &tetrahedra, reader->error);
    for (int64_t cell = 0; status == 0 && cell < reader->n_cells; cell++) {
        status = next_cell(&walk);
        cell_class class = class_at(reader, &walk, cell);
        if (status == 0 && class == CELL_TRIANGLE)
            store(&model->triangle, 3, walk.nodes, cell);
        else if (status == 0 && class == CELL_LINE)
            store(&model->line, 2, walk.nodes, cell);
        else if (status == 0 && class == CELL_TETRAHEDRON)
            store(&model->tetrahedron, 4, walk.nodes, cell);
    }
    return status;
}

void vtk_release(vtk_reader *reader) {
    pl_free(reader->connectivity);
    pl_free(reader->offset);
    pl_free(reader->type);
    reader->connectivity = NULL;
    reader->offset = NULL;
    reader->type = NULL;
}

int vtk_cell_types(vtk_reader *reader) {
    int64_t n;
    if (reader->have_types || !reader->have_points || reader->connectivity == NULL)
        return vtk_fail_here(reader, "CELL_TYPES must come once, behind POINTS and CELLS");
    if (io_integer(&reader->cursor, &n) != 0 || n != reader->n_cells)
        return vtk_fail_here(reader, "CELL_TYPES: as many types as cells expected");
    if (reader->binary)
        vtk_end_line(&reader->cursor);
    int status = read_integers(reader, n, 4, &reader->type, NULL);
    if (status == 0)
        status = store_cells(reader);
    reader->have_types = 1;
    vtk_release(reader);
    return status;
}
