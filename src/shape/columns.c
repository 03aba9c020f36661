/* columns: uprights of layers, and the columns that they make. */
#include "shape/columns.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/shape.h"
#include "topology/cells.h"
#include "topology/points.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* An element that is not marked belongs to a layer that it lies on if it is flat, by PL_THIN, or
 * inverted: a wall that was moved leaves such elements. So many rows of them are taken in. */
enum { ROWS_TAKEN = 3 };

static const pl_cell_type *counted_type(const planish_mesh *mesh, int64_t cell) {
    const pl_cell_type *type = pl_counted_type(mesh->cells, mesh->dim, cell);
    return type && type->shape->n_simplices > 0 ? type : NULL;
}

static double square_of(const pl_columns *c, int32_t a, int32_t b) {
    double edge[3];
    pl_columns_edge(c, a, b, edge);
    return pl_dot(3, edge, edge);
}

/* ---- elements and their uprights -------------------------------------------------------------- */

/** Edges of a product by its factors. */
typedef struct factor_edges {
    double sum[PL_CELL_SIMPLICES]; /* of squares, */
    int n[PL_CELL_SIMPLICES];      /* of so many */
} factor_edges;

/** Find the uprights of a product, the shortest family of a line; whether it is flat. left_out: bits of
 *  factors that do not count. */
static int find_factor_without(const pl_cell_shape *shape, const factor_edges *edges,
                               unsigned left_out, pl_layer_cell *cell) {
    const double *sum = edges->sum;
    const int *n = edges->n;
    int best = -1, is_flat = 1;
    for (int f = 0; f < shape->n_simplices; f++)
        if (shape->n_vertices[f] == 2 && !(left_out >> f & 1) &&
            (best < 0 || sum[f] * n[best] < sum[best] * n[f]))
            best = f;
    for (int f = 0; f < shape->n_simplices; f++)
        is_flat &= f == best || left_out >> f & 1 ||
                   sum[f] * n[best] >= PL_THIN * PL_THIN * sum[best] * n[f];
    cell->factor = (uint8_t)best;
    return is_flat;
}

/** The same; of a drawn solid in its plane, where wedges are not flat (cell_layers.c). */
static int find_factor(const pl_columns *c, const pl_cell_shape *shape, const int32_t *node,
                       pl_layer_cell *cell) {
    factor_edges edges = {.n = {0}};
    for (int e = 0; e < shape->n_edges; e++) {
        const int a = shape->edge[e][0], b = shape->edge[e][1], f = pl_factor_of(shape, a, b);
        edges.sum[f] += square_of(c, node[a], node[b]);
        edges.n[f]++;
    }
    const unsigned drawn = pl_drawn_factors(&c->drawn, c->mesh, shape, node);
    const int is_wedge = shape->n_simplices == 2;
    return find_factor_without(shape, &edges, is_wedge ? 0 : drawn, cell) && !(drawn && is_wedge);
}

/** Find the upright of a simplex, its shortest edge; whether it is flat. */
static int find_shortest(const pl_columns *c, const pl_cell_shape *shape, const int32_t *node,
                         pl_layer_cell *cell) {
    double least = INFINITY, second = INFINITY;
    for (int e = 0; e < shape->n_edges; e++) {
        const double square = square_of(c, node[shape->edge[e][0]], node[shape->edge[e][1]]);
        second = fmin(second, fmax(square, least));
        if (square < least) {
            least = square;
            cell->end[0] = shape->edge[e][0];
            cell->end[1] = shape->edge[e][1];
        }
    }
    return second >= PL_THIN * PL_THIN * least;
}

/** Find the uprights of an element. */
static int find_uprights(const pl_columns *c, int64_t i, pl_layer_cell *cell) {
    const pl_cell_shape *shape = counted_type(c->mesh, i)->shape;
    const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[i];
    *cell = (pl_layer_cell){.cell = (int32_t)i};
    return shape->n_simplices == 1 ? find_shortest(c, shape, node, cell)
                                   : find_factor(c, shape, node, cell);
}

/** Whether a product lies with a facet on nodes of layers from which the edges of a factor rise. */
static int stands_on(const pl_cell_shape *shape, const int32_t *node, int factor,
                     const uint8_t *in_layer) {
    int is_on[2] = {1, 1};
    for (int k = 0; k < shape->n_corners; k++)
        if (!in_layer[node[k]])
            is_on[shape->vertex[k][factor]] = 0;
    return is_on[0] || is_on[1];
}

/** Whether an element lies with a facet along the layer on nodes of layers: of a simplex all but one
 *  end of its upright. */
static int lies_on(const pl_columns *c, const pl_layer_cell *cell, const uint8_t *in_layer) {
    const pl_cell_shape *shape = counted_type(c->mesh, cell->cell)->shape;
    const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[cell->cell];
    int n = 0;
    if (shape->n_simplices > 1)
        return stands_on(shape, node, cell->factor, in_layer);
    for (int k = 0; k < shape->n_corners; k++)
        n += in_layer[node[k]];
    return n >= shape->dim && (in_layer[node[cell->end[0]]] || in_layer[node[cell->end[1]]]);
}

/** Whether a corner of a product is inverted, or flat. */
static int is_inverted(const pl_columns *c, int64_t i, const pl_cell_shape *shape,
                       const int32_t *node) {
    int found = 0;
    for (int k = 0; k < shape->n_measured && !found; k++) {
        double edges[3][3] = {{0}};
        for (int j = 0; j < shape->dim; j++)
            pl_columns_edge(c, node[k], node[shape->neighbour[k][j]], edges[j]);
        found = !(c->sign[i] * pl_determinant_of_edges(shape->dim, (const double(*)[3])edges) > 0);
    }
    return found;
}

/** Find how a product that is inverted goes on from a layer: by the facet that it shares with the layer,
 *  as its uprights may be longer than its other edges. Return the number of the factor and 1; 0: it does
 *  not, or by several factors. */
static int rising_factor(const pl_columns *c, int64_t i, const uint8_t *in_layer) {
    const pl_cell_shape *shape = counted_type(c->mesh, i)->shape;
    const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[i];
    int found = 0, n = 0;
    for (int f = 0; f < shape->n_simplices && shape->n_simplices > 1; f++)
        if (shape->n_vertices[f] == 2 && stands_on(shape, node, f, in_layer)) {
            found = f + 1;
            n++;
        }
    return n == 1 && is_inverted(c, i, shape, node) ? found : 0;
}

static void mark_nodes(const planish_mesh *mesh, int64_t cell, uint8_t *mark) {
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell];
    for (int k = 0; k < counted_type(mesh, cell)->shape->n_corners; k++)
        mark[node[k]] = 1;
}

/** Take in the flat and inverted elements that lie on layers. in_layer [n_nodes]; is_in, factor [cells]:
 *  factor gets the number of the factor and 1 where that is found by the layer. */
static void take_in(const pl_columns *c, uint8_t *in_layer, uint8_t *is_in, uint8_t *factor) {
    enum { IN = 1, NEXT = 2 };
    const planish_mesh *mesh = c->mesh;
    int64_t n = 1;
    for (int row = 0; row < ROWS_TAKEN && n > 0; row++) {
        n = 0;
        for (int64_t i = 0; i < mesh->cells->n; i++) {
            pl_layer_cell cell;
            if (is_in[i] || !counted_type(mesh, i))
                continue;
            const int is_flat = find_uprights(c, i, &cell) && lies_on(c, &cell, in_layer);
            factor[i] = (uint8_t)(is_flat ? 0 : rising_factor(c, i, in_layer));
            if (is_flat || factor[i]) {
                is_in[i] = NEXT;
                n++;
            }
        }
        for (int64_t i = 0; i < mesh->cells->n; i++)
            if (is_in[i] == NEXT) {
                is_in[i] = IN;
                mark_nodes(mesh, i, in_layer);
            }
    }
}

/** List the elements of layers. */
static int list_cells(pl_columns *c, const uint8_t *is_layer, planish_error *error) {
    const planish_mesh *mesh = c->mesh;
    uint8_t *in_layer = pl_alloc_zero(mesh->n_nodes, 1);
    uint8_t *is_in = pl_alloc_zero(mesh->cells->n, 1);
    uint8_t *factor = pl_alloc_zero(mesh->cells->n, 1);
    const int is_there = in_layer && is_in && factor;
    for (int64_t i = 0; is_there && i < mesh->cells->n; i++)
        if (is_layer[i] && counted_type(mesh, i)) {
            is_in[i] = 1;
            mark_nodes(mesh, i, in_layer);
        }
    if (is_there)
        take_in(c, in_layer, is_in, factor);
    for (int64_t i = 0; is_there && i < mesh->cells->n; i++)
        c->n_cells += is_in[i];
    c->cell = is_there ? pl_alloc(c->n_cells, sizeof *c->cell) : NULL;
    int64_t n = 0;
    for (int64_t i = 0; c->cell && i < mesh->cells->n; i++) {
        if (!is_in[i])
            continue;
        find_uprights(c, i, &c->cell[n]);
        if (factor[i])
            c->cell[n].factor = (uint8_t)(factor[i] - 1);
        n++;
    }
    pl_free(in_layer);
    pl_free(is_in);
    pl_free(factor);
    return c->cell ? PLANISH_OK : pl_fail_memory(error, "the elements of layers");
}

/** Call of each upright of an element its nodes, the lower number first, as one number. Return how
 *  many there are. */
static int name_uprights(const pl_columns *c, const pl_layer_cell *cell,
                         int64_t name[PL_UPRIGHTS]) {
    const pl_cell_shape *shape = counted_type(c->mesh, cell->cell)->shape;
    const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[cell->cell];
    int n = 0;
    for (int e = 0; e < shape->n_edges; e++) {
        const int a = shape->edge[e][0], b = shape->edge[e][1];
        const int is_upright = shape->n_simplices == 1 ? a == cell->end[0] && b == cell->end[1]
                                                       : pl_factor_of(shape, a, b) == cell->factor;
        const int at = shape->n_simplices == 1 ? 0 : pl_upright_at(shape, cell->factor, a);
        if (!is_upright)
            continue;
        const int64_t low = node[a] < node[b] ? node[a] : node[b];
        name[at] = low << 32 | (node[a] < node[b] ? node[b] : node[a]);
        n++;
    }
    return n;
}

static int compare(const void *a, const void *b) {
    const int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

/** Number the uprights, by their nodes. */
static int number_uprights(pl_columns *c, planish_error *error) {
    int64_t *name = pl_alloc(c->n_cells * PL_UPRIGHTS, sizeof *name), n = 0;
    if (!name)
        return pl_fail_memory(error, "the edges across layers");
    for (int64_t i = 0; i < c->n_cells; i++)
        n += name_uprights(c, &c->cell[i], name + n);
    qsort(name, (size_t)n, sizeof *name, compare);
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || name[i] != name[i - 1])
            name[c->n_uprights++] = name[i];
    c->end = c->n_uprights <= INT32_MAX ? pl_alloc(2 * c->n_uprights, sizeof *c->end) : NULL;
    for (int64_t u = 0; c->end && u < c->n_uprights; u++) {
        c->end[2 * u] = (int32_t)(name[u] >> 32);
        c->end[2 * u + 1] = (int32_t)(name[u] & INT32_MAX);
    }
    for (int64_t i = 0; c->end && i < c->n_cells; i++) {
        int64_t own[PL_UPRIGHTS];
        c->cell[i].n_uprights = (uint8_t)name_uprights(c, &c->cell[i], own);
        for (int k = 0; k < c->cell[i].n_uprights; k++) {
            const int64_t *found =
                bsearch(&own[k], name, (size_t)c->n_uprights, sizeof *name, compare);
            c->cell[i].upright[k] = (int32_t)(found - name);
        }
    }
    pl_free(name);
    return c->end ? PLANISH_OK : pl_fail_memory(error, "the edges across layers");
}

/* ---- columns ---------------------------------------------------------------------------------- */

/** Uprights at a node: two at most have a place, others are counted. */
typedef struct node_uprights {
    int32_t at[2];
    int32_t n;
} node_uprights;

static int32_t other_end(const pl_columns *c, int64_t upright, int32_t node) {
    return c->end[2 * upright] == node ? c->end[2 * upright + 1] : c->end[2 * upright];
}

/** Follow a column from an end of an upright, as long as two uprights meet at each node. */
static void follow(pl_columns *c, const node_uprights *nodes, int32_t upright, int32_t from) {
    int64_t n = c->begin[c->n_columns];
    int32_t node = from;
    for (;;) {
        c->node[n + c->n_columns] = node;
        c->upright[n] = upright;
        c->column[upright] = (int32_t)c->n_columns;
        c->place[upright] = (int32_t)n++;
        node = other_end(c, upright, node);
        c->node[n + c->n_columns] = node;
        if (nodes[node].n != 2)
            break;
        upright = nodes[node].at[nodes[node].at[0] == upright];
        if (c->column[upright] >= 0)
            break;
    }
    c->begin[++c->n_columns] = n;
}

static int make_columns(pl_columns *c, planish_error *error) {
    const int64_t n = c->n_uprights;
    node_uprights *nodes = pl_alloc_zero(c->mesh->n_nodes, sizeof *nodes);
    c->begin = pl_alloc_zero(n + 1, sizeof *c->begin);
    c->upright = pl_alloc(n, sizeof *c->upright);
    c->node = pl_alloc(2 * n, sizeof *c->node);
    c->column = pl_alloc(n, sizeof *c->column);
    c->place = pl_alloc(n, sizeof *c->place);
    if (!nodes || !c->begin || !c->upright || !c->node || !c->column || !c->place) {
        pl_free(nodes);
        return pl_fail_memory(error, "the columns of layers");
    }
    for (int64_t u = 0; u < n; u++) {
        c->column[u] = -1;
        for (int k = 0; k < 2; k++) {
            node_uprights *at = &nodes[c->end[2 * u + k]];
            if (at->n < 2)
                at->at[at->n] = (int32_t)u;
            at->n++;
        }
    }
    for (int is_ring = 0; is_ring < 2; is_ring++) /* what is left then has no end */
        for (int64_t u = 0; u < n; u++)
            for (int k = 0; k < 2; k++)
                if (c->column[u] < 0 && (is_ring || nodes[c->end[2 * u + k]].n != 2))
                    follow(c, nodes, (int32_t)u, c->end[2 * u + k]);
    pl_free(nodes);
    return PLANISH_OK;
}

/* ---- corners ---------------------------------------------------------------------------------- */

int pl_columns_corner(const pl_columns *c, const pl_layer_cell *cell, int k, double along[2][3]) {
    const pl_cell_shape *shape = counted_type(c->mesh, cell->cell)->shape;
    const int32_t *node = c->mesh->cells->node + c->mesh->cells->offset[cell->cell];
    int n = 0;
    memset(along, 0, 2 * sizeof *along);
    if (shape->n_simplices > 1) {
        for (int j = 0; j < shape->dim; j++) {
            const int to = shape->neighbour[k][j];
            if (pl_factor_of(shape, k, to) != cell->factor)
                pl_columns_edge(c, node[k], node[to], along[n++]);
        }
        return pl_upright_at(shape, cell->factor, k);
    }
    for (int p = 0; p <= shape->dim; p++)
        if (p != cell->end[0] && p != cell->end[1])
            pl_columns_edge(c, node[cell->end[cell->level >> p & 1]], node[p], along[n++]);
    return 0;
}

/* ---- all of it -------------------------------------------------------------------------------- */

int pl_columns_find(const planish_mesh *mesh, const uint8_t *is_layer, int threads, pl_columns *c,
                    planish_error *error) {
    const pl_points places = {.x = mesh->coordinates,
                              .n = mesh->n_nodes,
                              .dim = mesh->dim,
                              .step = mesh->dim,
                              .apart = 1};
    *c = (pl_columns){.mesh = mesh, .drawn = pl_drawn_find(mesh), .threads = threads};
    int status = pl_points_check(&places, threads, error);
    if (!status)
        status = pl_frame_create(mesh, NULL, threads, &c->frame, error);
    c->sign = status ? NULL : pl_alloc(mesh->cells->n, sizeof *c->sign);
    if (!status)
        status = c->sign ? pl_orient_cells(mesh->cells, mesh->dim, mesh->n_nodes, mesh->coordinates,
                                           threads, c->sign, error)
                         : pl_fail_memory(error, "the columns of layers");
    if (!status)
        status = list_cells(c, is_layer, error);
    if (!status)
        status = number_uprights(c, error);
    if (!status)
        status = make_columns(c, error);
    return status;
}

void pl_columns_destroy(pl_columns *c) {
    pl_free(c->sign);
    pl_free(c->cell);
    pl_free(c->end);
    pl_free(c->begin);
    pl_free(c->upright);
    pl_free(c->node);
    pl_free(c->column);
    pl_free(c->place);
    pl_free(c->side);
    pl_free(c->height);
    pl_free(c->leans);
    pl_free(c->told);
    pl_free(c->is_moved);
}
