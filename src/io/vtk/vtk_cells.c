/* vtk_cells: the cells of VTK's grids, whatever file they stand in. */
#include "io/vtk/vtk_cells.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/elements.h"
#include "io/core/records.h"

#include <stdio.h>

/** By VTK's number of the type; nodes 0: cells say how many they have. A cell of any type that is
 *  not here, known to VTK or not, holds its nodes. Bezier cells are elements
 *  only as straight simplices, as their nodes do not lie on them. */
static const io_element_type types[] = {
    [VTK_VERTEX] = {"vertex", IO_POINT, 1, 1},
    [VTK_POLY_VERTEX] = {"polyvertex", IO_POINT, 1, 0},
    [VTK_LINE] = {"line", IO_LINE, 1, 2},
    [VTK_POLY_LINE] = {"polyline", IO_LINE, 1, 0},
    [VTK_TRIANGLE] = {"triangle", IO_TRIANGLE, 1, 3},
    [VTK_TRIANGLE_STRIP] = {"triangle strip", IO_POLYGON, 1, 0},
    [VTK_POLYGON] = {"polygon", IO_POLYGON, 1, 0},
    [VTK_PIXEL] = {"pixel", IO_QUADRILATERAL, 1, 4},
    [9] = {"quadrilateral", IO_QUADRILATERAL, 1, 4},
    [VTK_TETRAHEDRON] = {"tetrahedron", IO_TETRAHEDRON, 1, 4},
    [VTK_VOXEL] = {"voxel", IO_HEXAHEDRON, 1, 8},
    [12] = {"hexahedron", IO_HEXAHEDRON, 1, 8},
    [13] = {"wedge", IO_PRISM, 1, 6},
    [14] = {"pyramid", IO_PYRAMID, 1, 5},
    [21] = {"quadratic edge", IO_LINE, 2, 3},
    [22] = {"quadratic triangle", IO_TRIANGLE, 2, 6},
    [23] = {"quadratic quadrilateral", IO_QUADRILATERAL, 2, 8},
    [24] = {"quadratic tetrahedron", IO_TETRAHEDRON, 2, 10},
    [25] = {"quadratic hexahedron", IO_HEXAHEDRON, 2, 20},
    [26] = {"quadratic wedge", IO_PRISM, 2, 15},
    [27] = {"quadratic pyramid", IO_PYRAMID, 2, 13},
    [28] = {"biquadratic quadrilateral", IO_QUADRILATERAL, 2, 9},
    [29] = {"triquadratic hexahedron", IO_HEXAHEDRON, 2, 27},
    [32] = {"biquadratic quadratic wedge", IO_PRISM, 2, 18},
    [34] = {"biquadratic triangle", IO_TRIANGLE, 2, 7},
    [35] = {"cubic line", IO_LINE, 3, 4},
    [51] = {"parametric curve", IO_LINE, 2, 0},
    [60] = {"higher order edge", IO_LINE, 2, 0},
    [61] = {"higher order triangle", IO_TRIANGLE, 3, 10},
    [64] = {"higher order tetrahedron", IO_TETRAHEDRON, 3, 20},
    [VTK_LAGRANGE_CURVE] = {"Lagrange curve", IO_LINE, 2, 0},
    [VTK_LAGRANGE_TRIANGLE] = {"Lagrange triangle", IO_TRIANGLE, 2, 0},
    [70] = {"Lagrange quadrilateral", IO_QUADRILATERAL, 2, 0},
    [VTK_LAGRANGE_TETRAHEDRON] = {"Lagrange tetrahedron", IO_TETRAHEDRON, 2, 0},
    [72] = {"Lagrange hexahedron", IO_HEXAHEDRON, 2, 0},
    [VTK_LAGRANGE_WEDGE] = {"Lagrange wedge", IO_PRISM, 2, 0},
    [75] = {"Bezier curve", IO_LINE, 2, 0},
    [76] = {"Bezier triangle", IO_TRIANGLE, 2, 0},
    [78] = {"Bezier tetrahedron", IO_TETRAHEDRON, 2, 0},
};

/** Return the row of a type; a cell of any shape for one that is not in the table; NULL for a number
 *  that is no type. */
static const io_element_type *find_type(int32_t type) {
    static const io_element_type other = {NULL, IO_ANY_SHAPE, 1, 0};
    const int32_t n = sizeof types / sizeof *types;
    if (type < 0 || type > VTK_LAST_TYPE)
        return NULL;
    return type < n && types[type].shape != IO_NO_SHAPE ? &types[type] : &other;
}

enum { MOST_NODES = 27 }; /* of a cell that is an element */

/** Fates of cells that the model does not keep; of others their dimension. */
enum { CELL_HELD = 0, CELL_REFUSED = -1, CELL_WRONG = -2 };

/** Return the number of mids of a cell of n nodes, if it is a line, triangle or tetrahedron of second
 *  order, quadratic or Lagrange's, whose mids stand in the same order; else 0. */
static int mids_of(int32_t type, int64_t n) {
    const int is_lagrange = type == VTK_LAGRANGE_CURVE || type == VTK_LAGRANGE_TRIANGLE ||
                            type == VTK_LAGRANGE_TETRAHEDRON;
    const int dim = is_lagrange
                        ? 1 + (type != VTK_LAGRANGE_CURVE) + (type == VTK_LAGRANGE_TETRAHEDRON)
                    : io_has_mids(type) ? io_simplex_dim(type)
                                        : 0;
    return n == dim + 1 + io_n_mids(dim) ? io_n_mids(dim) : 0;
}

/** Find the fate of a cell of n nodes without mids. A type whose cells say how many nodes they have
 *  (each line does) is straight if these are its corners. */
static int fate_of(const io_element_type *type, int64_t n) {
    const int dim = io_element_dim(type), is_straight = n == dim + 1;
    const io_element_treatment use = io_element_use(type);
    if (type->shape == IO_LINE || type->shape == IO_POLYGON)
        return is_straight ? dim : CELL_HELD;
    if (use == IO_REFUSE)
        return CELL_REFUSED;
    if (dim > 1 && type->nodes > 0 && n != type->nodes)
        return CELL_WRONG;
    const int is_simplex = type->shape == IO_TRIANGLE || type->shape == IO_TETRAHEDRON;
    return use == IO_KEEP || (is_simplex && type->nodes == 0 && is_straight) ? dim : CELL_HELD;
}

/** A walk over the cells; what is behind index is of the cell that next_cell came to. */
typedef struct cell_walk {
    const io_model *model;
    const vtk_grid *grid;
    planish_error *error;
    int64_t place; /* of the next cell in connectivity, without offsets */
    int64_t index; /* of the next cell */
    const int32_t *nodes;
    int64_t n;
    int32_t number; /* of its type */
    const io_element_type *type;
    int fate;  /* CELL_... or the dimension, */
    int mids;  /* and how many of the nodes are mids of a cell that is kept */
    int other; /* the planish_cell_type of one that is not; 0: none stands for it */
    int is_stream;
} cell_walk;

/** Fail about the cell that next_cell came to. */
static int fail_cell(const cell_walk *walk, const char *text) {
    const int64_t cell = walk->grid->first_cell + walk->index - 1;
    return pl_fail_at(walk->error, PLANISH_ERROR_FORMAT, cell, -1, "%s: cell %lld (from 0): %s",
                      walk->model->input.path, (long long)cell, text);
}

/** Return the planish_cell_type of the cell that the walk is at; 0: none stands for it. Of
 *  Lagrange cells those are whose order follows from their number of nodes, and whose nodes are in
 *  the order of the type with that many in every version of VTK. */
static int other_type(const cell_walk *walk) {
    const int32_t type = walk->number;
    const int as = walk->n <= MOST_NODES ? io_cell_type(walk->type->shape, (int)walk->n) : 0;
    if (walk->type->nodes > 0)
        return as;
    if (type < VTK_LAGRANGE_TRIANGLE || type > VTK_LAGRANGE_WEDGE)
        return 0;
    switch (as) {
    case PLANISH_CELL_QUADRILATERAL:
    case PLANISH_CELL_HEXAHEDRON:
    case PLANISH_CELL_WEDGE:
    case PLANISH_CELL_QUADRILATERAL9:
        return as;
    default:
        return 0;
    }
}

/** Find out about the type of the cell that next_cell has come to. */
static int take_type(cell_walk *walk, int32_t number) {
    walk->number = number;
    walk->type = find_type(number);
    walk->is_stream = walk->grid->has_streams && number == VTK_POLYHEDRON;
    if (!walk->type) {
        char text[80];
        snprintf(text, sizeof text, "type %d is not a type of VTK; these are 0 to 255",
                 (int)number);
        return fail_cell(walk, text);
    }
    walk->mids = walk->type->order == 2 ? mids_of(number, walk->n) : 0;
    walk->fate = walk->mids > 0 ? io_element_dim(walk->type) : fate_of(walk->type, walk->n);
    walk->other = walk->fate == CELL_HELD ? other_type(walk) : 0;
    return PLANISH_OK;
}

static int next_cell(cell_walk *walk) {
    const vtk_grid *grid = walk->grid;
    const int64_t cell = walk->index++, n = grid->n_connectivity;
    int64_t begin = walk->place + 1, end;
    if (grid->offset) {
        begin = grid->offset[cell];
        end = grid->offset[cell + 1];
    } else {
        end = begin + (walk->place < n ? grid->connectivity[walk->place] : -1);
        walk->place = end;
    }
    if (begin < 0 || end < begin || end > n || (cell == 0 && grid->offset && begin != 0))
        return fail_cell(walk, grid->offset
                                   ? "offsets do not rise from 0 to the size of the connectivity"
                                   : "its nodes are not in the list of CELLS");
    const int is_alike = walk->type && grid->type[cell] == walk->number && end - begin == walk->n;
    walk->nodes = grid->connectivity + begin;
    walk->n = end - begin;
    return is_alike ? PLANISH_OK : take_type(walk, grid->type[cell]);
}

int vtk_nodes_hold(io_model *model, const vtk_grid *grid, const int32_t *nodes, int64_t n) {
    for (int64_t i = 0; i < n; i++) {
        if (nodes[i] < 0 || nodes[i] >= grid->n_points)
            return -1;
        io_hold_node(model, grid->first_point + nodes[i], IO_HELD_BY_OTHER);
    }
    return 0;
}

int vtk_faces_hold(io_model *model, const vtk_grid *grid, const int32_t *stream, int64_t n) {
    int64_t at = 1;
    if (n < 1 || stream[0] < 0)
        return -1;
    for (int32_t face = 0; face < stream[0]; face++) {
        const int64_t size = at < n ? stream[at++] : -1;
        if (size < 0 || size > n - at || vtk_nodes_hold(model, grid, stream + at, size))
            return -1;
        at += size;
    }
    return at == n ? 0 : -1;
}

/** How many cells of one dimension are kept, the first and last of them, and whether any has mids; and
 *  how many others there are, and nodes of these. */
typedef struct cell_tally {
    int64_t n, first, last;
    int has_mids;
    int64_t n_others, n_nodes;
} cell_tally;

/** Check all cells, count the simplices by their dimension, hold the nodes of those that no type
 *  stands for. */
static int survey_cells(io_model *model, cell_walk walk, cell_tally tally[4]) {
    while (walk.index < walk.grid->n) {
        const int64_t cell = walk.grid->first_cell + walk.index;
        const int status = next_cell(&walk);
        if (status)
            return status;
        if (walk.fate == CELL_REFUSED) {
            char text[200];
            snprintf(text, sizeof text, "type %d (%s): " IO_OF_THIRD_ORDER,
                     (int)walk.grid->type[walk.index - 1], walk.type->name);
            return fail_cell(&walk, text);
        }
        if (walk.fate == CELL_WRONG)
            return fail_cell(&walk, "its number of nodes does not fit its type");
        for (int64_t i = 0; i < walk.n && !walk.is_stream; i++)
            if (walk.nodes[i] < 0 || walk.nodes[i] >= walk.grid->n_points)
                return fail_cell(&walk, "one of its nodes is not among the points");
        if (walk.fate > 0) {
            cell_tally *kept = &tally[walk.fate];
            kept->first = kept->n++ == 0 ? cell : kept->first;
            kept->last = cell;
            kept->has_mids |= walk.mids > 0;
            continue;
        }
        io_element_count(model, walk.type, 1);
        if (walk.other) {
            cell_tally *others = &tally[io_cell_type_dim(walk.other)];
            others->n_others++;
            others->n_nodes += walk.n;
            continue;
        }
        if (walk.is_stream && vtk_faces_hold(model, walk.grid, walk.nodes, walk.n))
            return fail_cell(&walk, "its faces must be: the number of faces, then for each face "
                                    "the number of nodes and its points");
        for (int64_t i = 0; i < walk.n && !walk.is_stream; i++)
            io_hold_node(model, walk.grid->first_point + walk.nodes[i],
                         io_element_reason(walk.type));
    }
    return PLANISH_OK;
}

/** Add the cell that next_cell came to, which is no simplex, if a type stands for it. The nodes
 *  of pixels and voxels stand row by row. */
static int add_other(io_model *model, const cell_walk *walk) {
    static const uint8_t rows[] = {0, 1, 3, 2, 4, 5, 7, 6};
    const vtk_grid *grid = walk->grid;
    const int64_t cell = walk->index - 1;
    const int has_rows = grid->type[cell] == VTK_PIXEL || grid->type[cell] == VTK_VOXEL;
    int32_t nodes[MOST_NODES];
    if (walk->other == 0)
        return PLANISH_OK;
    for (int64_t k = 0; k < walk->n; k++)
        nodes[k] = (int32_t)(grid->first_point + walk->nodes[has_rows ? rows[k] : k]);
    return io_model_add_other(model, walk->other, nodes, IO_NO_ENTITY, grid->first_cell + cell,
                              walk->error);
}

/** Store the cell that next_cell came to behind those of its dimension, for which there is room. */
static void store_cell(io_model *model, const cell_walk *walk) {
    const vtk_grid *grid = walk->grid;
    io_cells *to = io_model_cells(model, walk->fate);
    const int corners = walk->fate + 1;
    int32_t *nodes = to->nodes + to->n * corners;
    for (int k = 0; k < corners; k++)
        nodes[k] = (int32_t)(grid->first_point + walk->nodes[k]);
    if (walk->mids > 0) {
        int32_t all[MOST_NODES];
        for (int64_t k = 0; k < walk->n; k++)
            all[k] = (int32_t)(grid->first_point + walk->nodes[k]);
        io_cells_set_mids(model, walk->fate, to->n, all);
    }
    if (to->number)
        to->number[to->n] = grid->first_cell + walk->index - 1;
    to->n++;
}

int vtk_cells_store(io_model *model, const vtk_grid *grid, planish_error *error) {
    cell_tally tally[4] = {{0}};
    cell_walk walk = {.model = model, .grid = grid, .error = error};
    int status = survey_cells(model, walk, tally);
    for (int dim = 1; dim <= 3 && !status; dim++) {
        /* Numbers are those of all cells; if there is no gap, the first says it. */
        const cell_tally *t = &tally[dim];
        const int has_gaps = t->n > 0 && t->last - t->first + 1 != t->n;
        io_cells *to = io_model_cells(model, dim);
        if (to->n == 0)
            to->first_number = t->first;
        status = io_cells_reserve(model, dim, t->n, 0, has_gaps || grid->is_piece, error);
        if (!status && t->has_mids)
            status = io_cells_reserve_mids(model, dim, error);
        if (!status && t->n_others > 0)
            status = io_others_reserve(model, dim, t->n_others, t->n_nodes, 0, error);
    }
    while (!status && walk.index < grid->n) {
        status = next_cell(&walk);
        if (!status && walk.fate == CELL_HELD)
            status = add_other(model, &walk);
        if (!status && walk.fate > 0)
            store_cell(model, &walk);
    }
    return status;
}

void vtk_grid_release(vtk_grid *grid) {
    pl_free(grid->connectivity);
    pl_free(grid->offset);
    pl_free(grid->type);
    grid->connectivity = grid->type = NULL;
    grid->offset = NULL;
}
