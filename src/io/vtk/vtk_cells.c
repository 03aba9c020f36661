/* vtk_cells: the cells of VTK's grids, whatever file they stand in. */
#include "io/vtk/vtk_cells.h"

#include "io/core/elements.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/records.h"

#include <stdio.h>
#include <string.h>

typedef enum cell_class {
    CELL_LINE,
    CELL_LOWER,
    CELL_OTHER,
    CELL_TRIANGLE,
    CELL_TETRAHEDRON,
    CELL_REFUSED, /* of higher order */
    CELL_WRONG
} cell_class;

enum {
    VTK_VERTEX = 1,
    VTK_POLY_VERTEX = 2,
    VTK_LINE = 3,
    VTK_POLY_LINE = 4,
    VTK_TRIANGLE = 5,
    VTK_TRIANGLE_STRIP = 6,
    VTK_POLYGON = 7,
    VTK_TETRAHEDRON = 10,
    VTK_POLYHEDRON = 42,
    VTK_LAST_TYPE = 255 /* VTK keeps types in bytes */
};

/** By VTK's number of the type; nodes 0: cells say how many they have. A cell of any type that is
 *  not here, known to VTK or not, holds its nodes. */
static const io_element_type types[] = {
    [VTK_VERTEX] = {"vertex", IO_POINT, 1, 1, NULL},
    [VTK_POLY_VERTEX] = {"polyvertex", IO_POINT, 1, 0, NULL},
    [VTK_LINE] = {"line", IO_LINE, 1, 2, NULL},
    [VTK_POLY_LINE] = {"polyline", IO_LINE, 1, 0, NULL},
    [VTK_TRIANGLE] = {"triangle", IO_TRIANGLE, 1, 3, NULL},
    [VTK_TRIANGLE_STRIP] = {"triangle strip", IO_POLYGON, 1, 0, NULL},
    [VTK_POLYGON] = {"polygon", IO_POLYGON, 1, 0, NULL},
    [VTK_TETRAHEDRON] = {"tetrahedron", IO_TETRAHEDRON, 1, 4, NULL},
    [21] = {"quadratic edge", IO_LINE, 2, 3, NULL},
    [22] = {"quadratic triangle", IO_TRIANGLE, 2, 6, NULL},
    [24] = {"quadratic tetrahedron", IO_TETRAHEDRON, 2, 10, NULL},
    [34] = {"biquadratic triangle", IO_TRIANGLE, 2, 7, NULL},
    [35] = {"cubic line", IO_LINE, 3, 4, NULL},
    [51] = {"parametric curve", IO_LINE, 2, 0, NULL},
    [60] = {"higher order edge", IO_LINE, 2, 0, NULL},
    [61] = {"higher order triangle", IO_TRIANGLE, 3, 10, NULL},
    [64] = {"higher order tetrahedron", IO_TETRAHEDRON, 3, 20, NULL},
    [68] = {"Lagrange curve", IO_LINE, 2, 0, NULL},
    [69] = {"Lagrange triangle", IO_TRIANGLE, 2, 0, NULL},
    [71] = {"Lagrange tetrahedron", IO_TETRAHEDRON, 2, 0, NULL},
    [75] = {"Bezier curve", IO_LINE, 2, 0, NULL},
    [76] = {"Bezier triangle", IO_TRIANGLE, 2, 0, NULL},
    [78] = {"Bezier tetrahedron", IO_TETRAHEDRON, 2, 0, NULL},
};
enum { N_TYPES = sizeof types / sizeof *types };

/** Find the row of a type, borrowed; NULL: the table has none. */
static const io_element_type *find_type(int32_t type) {
    return type >= 0 && type < N_TYPES && types[type].shape != IO_NO_SHAPE ? &types[type] : NULL;
}

/** The class of a cell of n nodes. A type whose cells say how many nodes they have (and each line)
 *  is straight if these are its corners. */
static cell_class class_of(int32_t type, int64_t n) {
    static const cell_class kept[] = {CELL_LOWER, CELL_LINE, CELL_TRIANGLE, CELL_TETRAHEDRON};
    const io_element_type *row = find_type(type);
    if (!row)
        return type < 0 || type > VTK_LAST_TYPE ? CELL_WRONG : CELL_OTHER;
    const int dim = io_element_dim(row), has_corners = n == dim + 1;
    if (dim == 0 || row->shape == IO_LINE)
        return dim == 1 && has_corners ? CELL_LINE : CELL_LOWER;
    if (row->shape == IO_POLYGON)
        return has_corners ? CELL_TRIANGLE : CELL_OTHER;
    if (io_element_use(row) == IO_KEEP)
        return has_corners ? kept[dim] : CELL_WRONG;
    return has_corners && row->nodes == 0 ? kept[dim] : CELL_REFUSED;
}

/** A walk over the cells; nodes and n are those of the cell that next_cell came to. */
typedef struct cell_walk {
    const io_model *model;
    const vtk_grid *cells;
    planish_error *error;
    int64_t index; /* of the next cell */
    int64_t place; /* of its nodes in connectivity */
    const int32_t *nodes;
    int64_t n;
} cell_walk;

/** About the cell that next_cell came to. */
static int fail_cell(const cell_walk *walk, const char *text) {
    const int64_t cell = walk->cells->first_cell + walk->index - 1;
    return pl_fail_at(walk->error, PLANISH_ERROR_FORMAT, cell, -1, "%s: cell %lld (from 0): %s",
                      walk->model->input.path, (long long)cell, text);
}

/** The same with the cell's type. */
static int fail_type(const cell_walk *walk, const char *text) {
    const int32_t type = walk->cells->type[walk->index - 1];
    const io_element_type *known = find_type(type);
    char all[192];
    snprintf(all, sizeof all, "type %d%s%s%s%s", (int)type, known ? " (" : "",
             known ? known->name : "", known ? ")" : "", text);
    return fail_cell(walk, all);
}

static int next_cell(cell_walk *walk) {
    const vtk_grid *cells = walk->cells;
    const int64_t cell = walk->index++;
    if (cells->offset) {
        walk->nodes = cells->connectivity + cells->offset[cell];
        walk->n = cells->offset[cell + 1] - cells->offset[cell];
        return 0;
    }
    int64_t left = cells->n_connectivity - walk->place;
    walk->n = left > 0 ? cells->connectivity[walk->place] : -1;
    if (walk->n < 0 || walk->n > left - 1)
        return fail_cell(walk, "its nodes are not in the list of CELLS");
    walk->nodes = cells->connectivity + walk->place + 1;
    walk->place += 1 + walk->n;
    return 0;
}

/** What was found of one class: how many, and the first and last of them. */
typedef struct cell_tally {
    int64_t n, first, last;
} cell_tally;

static cell_class class_at(const cell_walk *walk) {
    return class_of(walk->cells->type[walk->index - 1], walk->n);
}

static int is_point(const cell_walk *walk) {
    const int32_t type = walk->cells->type[walk->index - 1];
    return type == VTK_VERTEX || type == VTK_POLY_VERTEX;
}

static void count_in(cell_tally *tally, int64_t cell) {
    if (tally->n++ == 0)
        tally->first = cell;
    tally->last = cell;
}

static int is_stream(const cell_walk *walk) {
    return walk->cells->has_streams && walk->cells->type[walk->index - 1] == VTK_POLYHEDRON;
}

static int check_cell(const cell_walk *walk) {
    const int32_t type = walk->cells->type[walk->index - 1];
    const cell_class class = class_at(walk);
    if (class == CELL_WRONG && type != VTK_TRIANGLE && type != VTK_TETRAHEDRON)
        return fail_type(walk, " is none of VTK's, which are 0 to 255");
    if (class == CELL_REFUSED)
        return fail_type(walk, ": triangles and tetrahedra of higher order are not smoothed, only "
                               "straight ones; mesh again with first order");
    if (class == CELL_WRONG)
        return fail_cell(walk, "it has not as many nodes as its type");
    for (int64_t i = 0; i < walk->n && !is_stream(walk); i++)
        if (walk->nodes[i] < 0 || walk->nodes[i] >= walk->cells->n_points)
            return fail_cell(walk, "one of its nodes is not among the points");
    return 0;
}

int vtk_nodes_hold(io_model *model, const vtk_grid *cells, const int32_t *nodes, int64_t n) {
    for (int64_t i = 0; i < n; i++) {
        if (nodes[i] < 0 || nodes[i] >= cells->n_points)
            return -1;
        io_hold_node(model, cells->first_point + nodes[i], IO_HELD_BY_OTHER);
    }
    return 0;
}

int vtk_faces_hold(io_model *model, const vtk_grid *cells, const int32_t *stream, int64_t n) {
    int64_t at = 1;
    if (n < 1 || stream[0] < 0)
        return -1;
    for (int32_t face = 0; face < stream[0]; face++) {
        const int64_t size = at < n ? stream[at++] : -1;
        if (size < 0 || size > n - at || vtk_nodes_hold(model, cells, stream + at, size))
            return -1;
        at += size;
    }
    return at == n ? 0 : -1;
}

/** The nodes of a cell that is no simplex. */
static int hold_cell(io_model *model, const cell_walk *walk) {
    if (is_stream(walk))
        return !vtk_faces_hold(model, walk->cells, walk->nodes, walk->n)
                   ? 0
                   : fail_cell(walk,
                               "its faces are not what a polyhedron's list has: how many, and "
                               "of each how many nodes, and which");
    const uint8_t reason = is_point(walk) ? IO_HELD_BY_POINT : IO_HELD_BY_OTHER;
    for (int64_t i = 0; i < walk->n; i++)
        io_hold_node(model, walk->cells->first_point + walk->nodes[i], reason);
    return 0;
}

/** Check all cells, count the simplices, hold the nodes of all others. */
static int survey_cells(io_model *model, cell_walk walk, cell_tally *lines, cell_tally *triangles,
                        cell_tally *tetrahedra) {
    while (walk.index < walk.cells->n) {
        const int64_t cell = walk.cells->first_cell + walk.index;
        int status = next_cell(&walk);
        if (!status)
            status = check_cell(&walk);
        if (status)
            return status;
        cell_class class = class_at(&walk);
        if (class == CELL_TETRAHEDRON) {
            count_in(tetrahedra, cell);
        } else if (class == CELL_TRIANGLE) {
            count_in(triangles, cell);
        } else if (class == CELL_LINE) {
            count_in(lines, cell);
        } else {
            *(class == CELL_LOWER ? &model->n_lower : &model->n_other) += 1;
            status = hold_cell(model, &walk);
        }
        if (status)
            return status;
    }
    return 0;
}

/** Room for the cells counted, numbered by VTK's count of all cells. */
static int reserve(const vtk_grid *cells, io_cells *to, int dim, const cell_tally *tally,
                   planish_error *error) {
    int gaps = tally->n > 0 && tally->last - tally->first + 1 != tally->n;
    if (to->n == 0)
        to->first_number = tally->first;
    return io_cells_reserve(to, dim, tally->n, 0, gaps || cells->is_piece, error);
}

static void store(io_cells *to, int corners, const cell_walk *walk) {
    int32_t *nodes = to->nodes + to->n * corners;
    for (int k = 0; k < corners; k++)
        nodes[k] = (int32_t)(walk->cells->first_point + walk->nodes[k]);
    if (to->number)
        to->number[to->n] = walk->cells->first_cell + walk->index - 1;
    to->n++;
}

int vtk_cells_store(io_model *model, const vtk_grid *cells, planish_error *error) {
    cell_tally lines = {0, 0, 0}, triangles = {0, 0, 0}, tetrahedra = {0, 0, 0};
    cell_walk walk = {.model = model, .cells = cells, .error = error};
    int status = survey_cells(model, walk, &lines, &triangles, &tetrahedra);
    if (!status)
        status = reserve(cells, &model->line, 1, &lines, error);
    if (!status)
        status = reserve(cells, &model->triangle, 2, &triangles, error);
    if (!status)
        status = reserve(cells, &model->tetrahedron, 3, &tetrahedra, error);
    while (!status && walk.index < cells->n) {
        status = next_cell(&walk);
        cell_class class = class_at(&walk);
        if (!status && class == CELL_TRIANGLE)
            store(&model->triangle, 3, &walk);
        else if (!status && class == CELL_LINE)
            store(&model->line, 2, &walk);
        else if (!status && class == CELL_TETRAHEDRON)
            store(&model->tetrahedron, 4, &walk);
    }
    return status;
}
