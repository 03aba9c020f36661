/* corners: a mesh of any elements as one of simplices.
 *
 * In goes a mesh with cells. Out come the simplices that its smoothed elements are, or if there are
 * elements of other types the corners of all of them (geometry/corner.h), arrays that go by these, and
 * the roles of nodes: mids of edges, corners that stay. Cells that are linear simplices in order are
 * elements as they stand.
 */
#include "topology/cells.h"
#include "topology/points.h"
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "geometry/corner.h"
#include "geometry/simplex.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK = 8192 };
/* A mid within this fraction of the edge off its middle is in the middle. */
#define STRAIGHT 1e-6

/** Passes over cells and nodes. */
typedef struct passes {
    const planish_mesh *mesh;
    const planish_cells *cells;
    pl_dense *dense;
    int64_t *first;        /* [chunks + 1] smoothed cells of each chunk, then before it, */
    int64_t *first_corner; /* and their corners */
    uint64_t *edge;        /* [n_nodes] edge that a node is the mid of, 0: none; shared; NULL: there
                              are no mids */
    uint8_t *is_smoothed;  /* [cells] */
    uint8_t is_irregular;  /* shared */
    uint8_t has_corners;   /* a smoothed cell is no simplex, or has a target, */
    uint8_t has_mids;      /* has nodes beside its corners, */
    uint8_t has_others;    /* and a cell is not smoothed; shared */
} passes;

int pl_is_smoothed(const planish_cells *cells, int64_t cell, int dim) {
    const pl_cell_type *type = pl_cell_type_of(cells->type[cell]);
    const int32_t *node = cells->node + cells->offset[cell];
    if (!type || type->shape->dim != dim || (type->shape->n_simplices == 0 && type->order > 1))
        return 0;
    int repeated = 0;
    for (int i = 1; type->shape->n_simplices != 1 && i < type->shape->n_corners; i++)
        for (int j = 0; j < i; j++)
            repeated |= node[i] == node[j];
    return !repeated;
}

/** Type of a cell that is smoothed. */
static const pl_cell_type *type_of(const passes *p, int64_t cell) {
    return pl_cell_type_of(p->cells->type[cell]);
}

/** Number of corners of a smoothed cell: of simplices there is one. */
static int corners_of(const pl_cell_type *type) {
    return type->shape->n_simplices == 1 ? 1 : type->shape->n_measured;
}

/* ---- cells that are elements as they stand -------------------------------------------------- */

static void find_irregular(void *context, int64_t begin, int64_t end, int thread) {
    passes *p = context;
    const int k = p->mesh->dim + 1;
    const int type = k == 4 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE;
    int other = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        other |= p->cells->type[i] != type || p->cells->offset[i] != i * k;
    if (other)
        pl_set_flag(&p->is_irregular, 1);
}

/** Whether all cells are linear simplices, one after the other. */
static int is_regular(passes *p, int threads) {
    const int64_t n = p->cells->n;
    if (p->cells->offset[n] != n * (p->mesh->dim + 1))
        return 0;
    pl_parallel_for(pl_paying_threads(threads, n), n, CHUNK, find_irregular, p);
    return !p->is_irregular;
}

/* ---- elements ------------------------------------------------------------------------------- */

static void count_smoothed(void *context, int64_t begin, int64_t end, int thread) {
    passes *p = context;
    int64_t n = 0, n_corners = 0;
    (void)thread;
    int has_corners = 0, has_mids = 0;
    for (int64_t i = begin; i < end; i++) {
        p->is_smoothed[i] = (uint8_t)pl_is_smoothed(p->cells, i, p->mesh->dim);
        if (!p->is_smoothed[i])
            continue;
        const pl_cell_type *type = type_of(p, i);
        n++;
        n_corners += corners_of(type);
        has_corners |= type->shape->n_simplices != 1;
        has_mids |= type->order > 1;
    }
    p->first[begin / CHUNK] = n;
    p->first_corner[begin / CHUNK] = n_corners;
    if (has_corners)
        pl_set_flag(&p->has_corners, 1);
    if (has_mids)
        pl_set_flag(&p->has_mids, 1);
    if (n < end - begin)
        pl_set_flag(&p->has_others, 1);
}

/** Write the corners of a cell, or the simplex that it is, as elements from e on. Returns where the next
 *  cell's begin. */
static int64_t write_corners(const passes *p, int64_t cell, int64_t e) {
    const pl_cell_type *type = type_of(p, cell);
    const pl_cell_shape *shape = type->shape;
    const int32_t *node = p->cells->node + p->cells->offset[cell];
    const int dim = p->mesh->dim, n = corners_of(type), kind = pl_kind_of_shape(shape);
    for (int c = 0; c < n; c++, e++) {
        int32_t *element = p->dense->elements + e * (dim + 1);
        element[0] = node[c];
        for (int j = 0; j < dim; j++)
            element[j + 1] = node[n == 1 ? j + 1 : shape->neighbour[c][j]];
        if (p->dense->cell_of)
            p->dense->cell_of[e] = (int32_t)cell;
        if (p->dense->corner)
            p->dense->corner[e] = pl_corner_code(kind, c);
    }
    return e;
}

static void list_smoothed(void *context, int64_t begin, int64_t end, int thread) {
    const passes *p = context;
    int64_t n = p->first[begin / CHUNK], e = p->first_corner[begin / CHUNK];
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (!p->is_smoothed[i])
            continue;
        if (p->dense->cell_begin)
            p->dense->cell_begin[n++] = (int32_t)e;
        e = write_corners(p, i, e);
    }
}

/** Count the smoothed cells and their corners. */
static int count_all(passes *p, int threads, int64_t *n, int64_t *n_corners, planish_error *error) {
    const int64_t n_cells = p->cells->n, n_chunks = (n_cells - 1) / CHUNK + 1;
    p->first = pl_alloc(n_chunks + 1, sizeof *p->first);
    p->first_corner = pl_alloc(n_chunks + 1, sizeof *p->first_corner);
    p->is_smoothed = pl_alloc(n_cells, 1);
    if (!p->first || !p->first_corner || !p->is_smoothed)
        return pl_fail_memory(error, "the elements");
    pl_parallel_for(threads, n_cells, CHUNK, count_smoothed, p);
    *n = pl_prefix_sum(threads, n_chunks, p->first);
    *n_corners = pl_prefix_sum(threads, n_chunks, p->first_corner);
    if (*n == 0)
        return pl_fail(error, PLANISH_ERROR_MESH,
                       "mesh.cells has no %s; other elements are measured (planish_measure_cells), "
                       "but not smoothed%s",
                       p->mesh->dim == 3
                           ? "tetrahedron, hexahedron or wedge, and no pyramid of order 1"
                           : "triangle or quadrilateral",
                       p->mesh->dim == 3 ? "; surfaces in space: planish_smooth_surface" : "");
    if (*n_corners >= INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "the elements of mesh.cells have %" PRId64
                       " corners; at most %d can be smoothed",
                       *n_corners, INT32_MAX - 1);
    return PLANISH_OK;
}

/** Make the smoothed cells the elements: as simplices, or by their corners. */
static int make_elements(passes *p, int threads, planish_error *error) {
    pl_dense *dense = p->dense;
    const int64_t n_cells = p->cells->n;
    int64_t n, n_elements;
    int status = count_all(p, threads, &n, &n_elements, error);
    if (status)
        return status;
    p->has_corners |= (uint8_t)pl_has_targets(p->mesh);
    const int maps = p->has_corners || p->has_others;
    dense->elements = pl_alloc(n_elements * (p->mesh->dim + 1), sizeof *dense->elements);
    dense->cell_of = maps ? pl_alloc(n_elements, sizeof *dense->cell_of) : NULL;
    if (p->has_corners) {
        dense->n_cells = n;
        dense->corner = pl_alloc(n_elements, sizeof *dense->corner);
        dense->cell_begin = pl_alloc(n + 1, sizeof *dense->cell_begin);
    }
    if (!dense->elements || (maps && !dense->cell_of) ||
        (p->has_corners && (!dense->corner || !dense->cell_begin)))
        return pl_fail_memory(error, "the elements");
    if (dense->cell_begin)
        dense->cell_begin[n] = (int32_t)n_elements;
    pl_parallel_for(threads, n_cells, CHUNK, list_smoothed, p);
    dense->mesh.elements = dense->elements;
    dense->mesh.n_elements = n_elements;
    return PLANISH_OK;
}

/* ---- nodes ---------------------------------------------------------------------------------- */

static int role_of(const passes *p, int32_t node) {
    return __atomic_load_n(&p->dense->role[node], __ATOMIC_RELAXED);
}

static void add_role(const passes *p, int32_t node, uint8_t role) {
    if (node >= 0 && (role_of(p, node) & role) != role)
        __atomic_fetch_or(&p->dense->role[node], role, __ATOMIC_RELAXED);
}

/** Find the corners of a cell that node place of it, which is no corner, is in the middle of: both
 *  ends of an edge, the corners of a face, or all. Returns how many. */
static int find_parents(const pl_cell_type *type, int place, uint8_t parent[PL_CELL_CORNERS]) {
    const pl_cell_shape *shape = type->shape;
    const uint8_t *pair = type->between[place];
    for (int e = 0; e < shape->n_edges; e++)
        if ((shape->edge[e][0] == pair[0] && shape->edge[e][1] == pair[1]) ||
            (shape->edge[e][0] == pair[1] && shape->edge[e][1] == pair[0])) {
            memcpy(parent, pair, 2);
            return 2;
        }
    for (int k = 0; shape->dim == 3 && k < shape->n_facets; k++) {
        const int8_t *facet = shape->facet[k];
        int n = 0;
        for (int i = 0; i < 4 && facet[3] >= 0; i++)
            n += facet[i] == pair[0] || facet[i] == pair[1];
        if (n == 2) {
            for (int i = 0; i < 4; i++)
                parent[i] = (uint8_t)facet[i];
            return 4;
        }
    }
    for (int i = 0; i < shape->n_corners; i++)
        parent[i] = (uint8_t)i;
    return shape->n_corners;
}

/** Key of what the corners parent [n] of a cell make: of an edge both ends; of a face its lowest
 *  node and the opposite one; of a cell its first node. */
static uint64_t key_of(const int32_t *node, const uint8_t *parent, int n) {
    int lowest = 0;
    for (int i = 1; n <= 4 && i < n; i++)
        lowest = node[parent[i]] < node[parent[lowest]] ? i : lowest;
    const int other = n == 2 ? 1 - lowest : (lowest + 2) % n;
    return (uint64_t)node[parent[lowest]] << 32 | (uint64_t)(uint32_t)node[parent[other]];
}

/** Note whose mid a node is: of one edge, face or cell, or of several. */
static void note_mid(const passes *p, const pl_cell_type *type, const int32_t *node, int place) {
    uint8_t parent[PL_CELL_CORNERS];
    const int n = find_parents(type, place, parent);
    const uint64_t key = key_of(node, parent, n);
    uint64_t before = 0;
    add_role(p, node[place], PL_OF_MID);
    if (!__atomic_compare_exchange_n(&p->edge[node[place]], &before, key, 0, __ATOMIC_RELAXED,
                                     __ATOMIC_RELAXED) &&
        before != key)
        add_role(p, node[place], PL_OF_EDGES);
}

/** Note the roles that nodes have in a cell. */
static void note_cell(const passes *p, int64_t cell) {
    const planish_cells *cells = p->cells;
    const int32_t *node = cells->node + cells->offset[cell];
    const int64_t n = cells->offset[cell + 1] - cells->offset[cell];
    if (!p->is_smoothed[cell]) {
        for (int64_t j = 0; j < n; j++)
            add_role(p, node[j], PL_OF_OTHER);
        return;
    }
    const pl_cell_type *type = type_of(p, cell);
    for (int j = 0; j < type->shape->n_corners; j++)
        add_role(p, node[j], PL_OF_CORNER);
    for (int j = type->shape->n_corners; j < n; j++)
        if (node[j] >= 0)
            note_mid(p, type, node, j);
}

/** Whether corners stay because of the node in their middle. */
static int holds_parents(const passes *p, int32_t mid) {
    const uint8_t *constraint = p->mesh->constraint;
    return (role_of(p, mid) & (PL_OF_CORNER | PL_OF_OTHER | PL_OF_EDGES)) ||
           (constraint && constraint[mid] == PLANISH_CONSTRAINT_FIXED);
}

/** Note which corners of a smoothed cell stay. */
static void hold_corners(const passes *p, int64_t cell) {
    const pl_cell_type *type = type_of(p, cell);
    const int32_t *node = p->cells->node + p->cells->offset[cell];
    uint8_t parent[PL_CELL_CORNERS];
    for (int j = 0; j < type->shape->n_corners; j++)
        if (role_of(p, node[j]) & PL_OF_OTHER)
            add_role(p, node[j], PL_STAYS);
    for (int j = type->shape->n_corners; j < type->n_nodes; j++)
        if (node[j] >= 0 && holds_parents(p, node[j]))
            for (int k = find_parents(type, j, parent); k-- > 0;)
                add_role(p, node[parent[k]], PL_STAYS);
}

static void note_cells(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        note_cell(context, i);
}

static void hold_cells(void *context, int64_t begin, int64_t end, int thread) {
    const passes *p = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (p->is_smoothed[i])
            hold_corners(p, i);
}

/** Find the roles of nodes, and fix those that stay. */
static int make_roles(passes *p, int threads, planish_error *error) {
    const int64_t n = p->mesh->n_nodes;
    pl_dense *dense = p->dense;
    dense->role = pl_alloc_zero(n, sizeof *dense->role);
    dense->constraint = pl_alloc_zero(n, sizeof *dense->constraint);
    p->edge = p->has_mids ? pl_alloc_zero(n, sizeof *p->edge) : NULL;
    if (!dense->role || !dense->constraint || (p->has_mids && !p->edge))
        return pl_fail_memory(error, "the nodes of elements");
    pl_parallel_for(threads, p->cells->n, CHUNK, note_cells, p);
    if (p->has_mids || p->has_others)
        pl_parallel_for(threads, p->cells->n, CHUNK, hold_cells, p);
    if (p->mesh->constraint)
        memcpy(dense->constraint, p->mesh->constraint, (size_t)n);
    for (int64_t i = 0; i < n; i++)
        if (dense->constraint[i] != PLANISH_CONSTRAINT_FREE && dense->role[i] != 0)
            dense->role[i] |= PL_BOUND;
    for (int64_t i = 0; i < n; i++)
        if (dense->role[i] & PL_STAYS && dense->constraint[i] <= PLANISH_CONSTRAINT_ON_CURVE)
            dense->constraint[i] = PLANISH_CONSTRAINT_FIXED;
    dense->mesh.constraint = dense->constraint;
    return PLANISH_OK;
}

/** Leave out periodic pairs of mids, which follow corners. */
static int make_pairs(passes *p, planish_error *error) {
    const planish_mesh *mesh = p->mesh;
    pl_dense *dense = p->dense;
    int status = pl_check_periodic(mesh, error);
    if (status || mesh->n_periodic == 0)
        return status;
    dense->periodic = pl_alloc(2 * mesh->n_periodic, sizeof *dense->periodic);
    if (!dense->periodic)
        return pl_fail_memory(error, "periodic nodes");
    dense->mesh.n_periodic = 0;
    for (int64_t i = 0; i < mesh->n_periodic; i++) {
        const int32_t *pair = mesh->periodic + 2 * i;
        if (pl_follows(dense->role[pair[0]]) && pl_follows(dense->role[pair[1]]))
            continue;
        memcpy(dense->periodic + 2 * dense->mesh.n_periodic++, pair, 2 * sizeof *pair);
    }
    dense->mesh.periodic = dense->periodic;
    return PLANISH_OK;
}

/* ---- curved edges ---------------------------------------------------------------------------- */

/** The largest absolute number of a [n]. */
static double largest_of(const double *a, int n) {
    double largest = 0;
    for (int i = 0; i < n; i++)
        largest = fmax(largest, fabs(a[i]));
    return largest;
}

/** Whether mid is farther off the middle of a and b than planish_options.rounding says. */
static int is_curved(int dim, const double *a, const double *b, const double *mid,
                     double rounding) {
    double half[3] = {0}, off[3] = {0};
    for (int d = 0; d < dim; d++) {
        half[d] = b[d] / 2 - a[d] / 2;
        off[d] = mid[d] - (a[d] / 2 + b[d] / 2);
    }
    const double size = fmax(largest_of(half, 3), largest_of(off, 3)); /* squares could overflow */
    if (!(size > 0))
        return 0;
    for (int d = 0; d < 3; d++) {
        half[d] /= size;
        off[d] /= size;
    }
    const double distance = sqrt(pl_dot(3, off, off)), edge = 2 * sqrt(pl_dot(3, half, half));
    return distance > STRAIGHT * edge && distance > rounding / size;
}

/** Put a and b, opposite corners of a face or cell of which node i of a type is the middle, so that the
 *  middle between them is that of all corners of it. x: of all nodes. */
static void centre_pair(const pl_cell_type *type, int i, int dim, double (*x)[3], double *a,
                        double *b) {
    const uint8_t parents = pl_cell_parents(type, i);
    const int n = __builtin_popcount(parents);
    for (int d = 0; d < dim && n > 2; d++) {
        double middle = 0;
        for (int c = 0; c < type->shape->n_corners; c++)
            middle += parents >> c & 1 ? x[c][d] / n : 0;
        const double half = b[d] / 2 - a[d] / 2;
        a[d] = middle - half;
        b[d] = middle + half;
    }
}

int pl_curved_edges(const planish_mesh *mesh, int64_t cell, double rounding) {
    const planish_cells *cells = mesh->cells;
    const int32_t *node = cells->node + cells->offset[cell];
    const pl_cell_type *type = pl_cell_type_of(cells->type[cell]);
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    double x[PL_CELL_NODES][3] = {{0}};
    int curved = 0;
    if (!pl_is_smoothed(cells, cell, mesh->dim))
        return 0;
    const int k = type->shape->n_corners;
    for (int j = 0; j < type->n_nodes; j++)
        for (int d = 0; d < mesh->dim && node[j] >= 0; d++)
            x[j][d] = mesh->coordinates[pl_point_at(&points, node[j], d)];
    for (int j = k; j < type->n_nodes; j++) {
        double end[2][3];
        memcpy(end[0], x[type->between[j][0]], sizeof end[0]);
        memcpy(end[1], x[type->between[j][1]], sizeof end[1]);
        centre_pair(type, j, mesh->dim, x, end[0], end[1]);
        if (node[j] >= 0 && is_curved(mesh->dim, end[0], end[1], x[j], rounding))
            curved |= 1 << (j - k);
    }
    return curved;
}

/** Whether a point is farther off the plane of a, b and c than planish_options.rounding says. */
static int is_off_plane(const double *a, const double *b, const double *c, const double *point,
                        double rounding) {
    double side[2][3], way[3], normal[3];
    for (int d = 0; d < 3; d++) {
        side[0][d] = b[d] - a[d];
        side[1][d] = c[d] - a[d];
        way[d] = point[d] - a[d];
    }
    const double size = fmax(fmax(largest_of(side[0], 3), largest_of(side[1], 3)),
                             largest_of(way, 3)); /* products could overflow */
    if (!(size > 0))
        return 0;
    for (int d = 0; d < 3; d++) {
        side[0][d] /= size;
        side[1][d] /= size;
        way[d] /= size;
    }
    pl_cross(side[0], side[1], normal);
    const double distance = fabs(pl_dot(3, normal, way)), length = sqrt(pl_dot(3, normal, normal));
    const double edge = sqrt(pl_dot(3, side[0], side[0]));
    return !(distance <= fmax(STRAIGHT * edge, rounding / size) * length);
}

int pl_is_off_face(const planish_mesh *mesh, int64_t cell, int i, double rounding) {
    const planish_cells *cells = mesh->cells;
    const int32_t *node = cells->node + cells->offset[cell];
    const pl_cell_type *type = pl_cell_type_of(cells->type[cell]);
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    const int a = type->between[i][0], b = type->between[i][1];
    const uint8_t parents = pl_cell_parents(type, i);
    double x[PL_CELL_NODES][3] = {{0}};
    int is_off = 0;
    for (int j = 0; j < type->n_nodes; j++)
        for (int d = 0; d < mesh->dim && node[j] >= 0; d++)
            x[j][d] = mesh->coordinates[pl_point_at(&points, node[j], d)];
    for (int j = 0; j < type->shape->n_corners; j++)
        if (j != a && j != b && parents >> j & 1)
            is_off |= is_off_plane(x[a], x[b], x[j], x[i], rounding);
    return is_off;
}

/* ---- all of it ------------------------------------------------------------------------------ */

/** Make all copies that dense needs for cells, which are valid. */
static int make_copies(passes *p, int threads, planish_error *error) {
    pl_dense *dense = p->dense;
    int failed = 0;
    int status = make_elements(p, threads, error);
    if (!status)
        status = make_roles(p, threads, error);
    if (!status)
        status = make_pairs(p, error);
    if (status || !dense->cell_of)
        return status;
    dense->min_volume = pl_rows_take(p->mesh->min_volume, dense->cell_of, dense->mesh.n_elements,
                                     sizeof *dense->min_volume, threads, &failed);
    dense->mesh.min_volume = dense->min_volume;
    return failed ? pl_fail_memory(error, "the minimum volumes of the elements") : PLANISH_OK;
}

int pl_corners_take(const planish_mesh *mesh, int threads, pl_dense *dense, planish_error *error) {
    passes p = {.mesh = mesh, .cells = mesh->cells, .dense = dense};
    int status = pl_check_cell_fields(mesh->cells, error);
    if (status)
        return status;
    dense->mesh.cells = NULL;
    if (!pl_has_targets(mesh) && is_regular(&p, threads)) {
        dense->mesh.elements = mesh->cells->node;
        return PLANISH_OK;
    }
    status = pl_check_cells(mesh->cells, mesh->n_nodes, threads, error);
    if (!status)
        status = make_copies(&p, threads, error);
    pl_free(p.first);
    pl_free(p.first_corner);
    pl_free(p.is_smoothed);
    pl_free(p.edge);
    return status;
}
