/* corners: a mesh of any elements as one of simplices.
 *
 * In goes a mesh with cells. Out come the corners of its smoothed elements, arrays that go by these
 * elements, and the roles of nodes: mids of edges, corners that stay. Cells that are linear simplices
 * in order are elements as they stand.
 */
#include "topology/cells.h"
#include "topology/points.h"
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "geometry/simplex.h"

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
    int64_t *first;       /* [chunks + 1] smoothed elements of each chunk, then before it */
    uint64_t *edge;       /* [n_nodes] edge that a node is the mid of, 0: none; shared */
    uint8_t is_irregular; /* shared */
} passes;

static int is_smoothed(const passes *p, int64_t cell) {
    return pl_is_smoothed(p->cells->type[cell], p->mesh->dim);
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
    const passes *p = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n += is_smoothed(p, i);
    p->first[begin / CHUNK] = n;
}

static void list_smoothed(void *context, int64_t begin, int64_t end, int thread) {
    const passes *p = context;
    const int k = p->mesh->dim + 1;
    int64_t n = p->first[begin / CHUNK];
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (!is_smoothed(p, i))
            continue;
        for (int j = 0; j < k; j++)
            p->dense->elements[n * k + j] = p->cells->node[p->cells->offset[i] + j];
        if (p->dense->cell_of)
            p->dense->cell_of[n] = (int32_t)i;
        n++;
    }
}

/** Make the corners of the smoothed cells the elements. */
static int make_elements(passes *p, int threads, planish_error *error) {
    pl_dense *dense = p->dense;
    const int64_t n_cells = p->cells->n;
    p->first = pl_alloc(n_cells / CHUNK + 2, sizeof *p->first);
    if (!p->first)
        return pl_fail_memory(error, "the elements");
    pl_parallel_for(threads, n_cells, CHUNK, count_smoothed, p);
    const int64_t n = pl_prefix_sum(threads, (n_cells - 1) / CHUNK + 1, p->first);
    if (n == 0)
        return pl_fail(error, PLANISH_ERROR_MESH,
                       "mesh.cells has no %s; elements of other types are measured "
                       "(planish_measure_cells), but not smoothed",
                       p->mesh->dim == 3 ? "tetrahedron" : "triangle");
    dense->elements = pl_alloc(n * (p->mesh->dim + 1), sizeof *dense->elements);
    dense->cell_of = n < n_cells ? pl_alloc(n, sizeof *dense->cell_of) : NULL;
    if (!dense->elements || (n < n_cells && !dense->cell_of))
        return pl_fail_memory(error, "the elements");
    pl_parallel_for(threads, n_cells, CHUNK, list_smoothed, p);
    dense->mesh.elements = dense->elements;
    dense->mesh.n_elements = n;
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

/** Note whose mid a node is: of one edge, or of several. */
static void note_mid(const passes *p, int32_t mid, int32_t a, int32_t b) {
    const uint64_t edge = (uint64_t)(a < b ? a : b) << 32 | (uint64_t)(a < b ? b : a);
    uint64_t before = 0;
    add_role(p, mid, PL_OF_MID);
    if (!__atomic_compare_exchange_n(&p->edge[mid], &before, edge, 0, __ATOMIC_RELAXED,
                                     __ATOMIC_RELAXED) &&
        before != edge)
        add_role(p, mid, PL_OF_EDGES);
}

/** Note the roles that nodes have in a cell. */
static void note_cell(const passes *p, int64_t cell) {
    const planish_cells *cells = p->cells;
    const int32_t *node = cells->node + cells->offset[cell];
    const int64_t n = cells->offset[cell + 1] - cells->offset[cell];
    if (!is_smoothed(p, cell)) {
        for (int64_t j = 0; j < n; j++)
            add_role(p, node[j], PL_OF_OTHER);
        return;
    }
    const pl_cell_type *type = pl_cell_type_of(cells->type[cell]);
    for (int j = 0; j <= p->mesh->dim; j++)
        add_role(p, node[j], PL_OF_CORNER);
    for (int64_t j = p->mesh->dim + 1; j < n; j++)
        if (node[j] >= 0)
            note_mid(p, node[j], node[type->between[j][0]], node[type->between[j][1]]);
}

/** Note which corners of a smoothed cell stay. */
static void hold_corners(const passes *p, int64_t cell) {
    const planish_cells *cells = p->cells;
    const pl_cell_type *type = pl_cell_type_of(cells->type[cell]);
    const int32_t *node = cells->node + cells->offset[cell];
    const uint8_t *constraint = p->mesh->constraint;
    for (int j = 0; j <= p->mesh->dim; j++)
        if (role_of(p, node[j]) & PL_OF_OTHER)
            add_role(p, node[j], PL_STAYS);
    for (int j = p->mesh->dim + 1; j < type->n_nodes; j++)
        if (node[j] >= 0 && ((role_of(p, node[j]) & (PL_OF_CORNER | PL_OF_OTHER | PL_OF_EDGES)) ||
                             (constraint && constraint[node[j]] == PLANISH_CONSTRAINT_FIXED)))
            for (int end = 0; end < 2; end++)
                add_role(p, node[type->between[j][end]], PL_STAYS);
}

static void note_cells(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        note_cell(context, i);
}

static void hold_cells(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (is_smoothed(context, i))
            hold_corners(context, i);
}

/** Find the roles of nodes, and fix those that stay. */
static int make_roles(passes *p, int threads, planish_error *error) {
    const int64_t n = p->mesh->n_nodes;
    pl_dense *dense = p->dense;
    dense->role = pl_alloc_zero(n, sizeof *dense->role);
    dense->constraint = pl_alloc_zero(n, sizeof *dense->constraint);
    p->edge = pl_alloc_zero(n, sizeof *p->edge);
    if (!dense->role || !dense->constraint || !p->edge)
        return pl_fail_memory(error, "the nodes of elements");
    pl_parallel_for(threads, p->cells->n, CHUNK, note_cells, p);
    pl_parallel_for(threads, p->cells->n, CHUNK, hold_cells, p);
    if (p->mesh->constraint)
        memcpy(dense->constraint, p->mesh->constraint, (size_t)n);
    for (int64_t i = 0; i < n; i++)
        if (dense->role[i] & PL_STAYS && dense->constraint[i] <= PLANISH_CONSTRAINT_ON_SURFACE)
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

int pl_curved_edges(const planish_mesh *mesh, int64_t cell, double rounding) {
    const planish_cells *cells = mesh->cells;
    const int32_t *node = cells->node + cells->offset[cell];
    const pl_cell_type *type = pl_cell_type_of(cells->type[cell]);
    const int k = mesh->dim + 1;
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    double x[10][3] = {{0}};
    int curved = 0;
    if (!pl_is_smoothed(cells->type[cell], mesh->dim))
        return 0;
    for (int j = 0; j < type->n_nodes; j++)
        for (int d = 0; d < mesh->dim && node[j] >= 0; d++)
            x[j][d] = mesh->coordinates[pl_point_at(&points, node[j], d)];
    for (int j = k; j < type->n_nodes; j++)
        if (node[j] >= 0 &&
            is_curved(mesh->dim, x[type->between[j][0]], x[type->between[j][1]], x[j], rounding))
            curved |= 1 << (j - k);
    return curved;
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
    if (is_regular(&p, threads)) {
        dense->mesh.elements = mesh->cells->node;
        return PLANISH_OK;
    }
    status = pl_check_cells(mesh->cells, mesh->n_nodes, threads, error);
    if (!status)
        status = make_copies(&p, threads, error);
    pl_free(p.first);
    pl_free(p.edge);
    return status;
}
