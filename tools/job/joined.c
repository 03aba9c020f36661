/* joined: facets that have points of their own, joined where these are equal. */
#include "job/joined.h"

#include <stdlib.h>
#include <string.h>

/** An edge, by its lower node first. */
typedef struct edge {
    int32_t node[2];
} edge;

/** A node of a border. */
typedef struct point {
    double x[3];
    int32_t node;
} point;

/** A facet, by its nodes in their order, from the lowest one on. */
typedef struct facet {
    int32_t node[4]; /* the last one of a triangle is -1 */
    int32_t number;
} facet;

static int compare_numbers(const int32_t *a, const int32_t *b, int n) {
    for (int i = 0; i < n; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b) {
    return compare_numbers(((const edge *)a)->node, ((const edge *)b)->node, 2);
}

static int compare_facets(const void *a, const void *b) {
    const facet *f = a, *g = b;
    const int by_nodes = compare_numbers(f->node, g->node, 4);
    return by_nodes ? by_nodes : compare_numbers(&f->number, &g->number, 1);
}

static int compare_places(const point *p, const point *q) {
    for (int d = 0; d < 3; d++)
        if (p->x[d] != q->x[d])
            return p->x[d] < q->x[d] ? -1 : 1;
    return 0;
}

static int compare_points(const void *a, const void *b) {
    const point *p = a, *q = b;
    const int by_place = compare_places(p, q);
    return by_place ? by_place : compare_numbers(&p->node, &q->node, 1);
}

/** List the edges of facets. Returns their number. */
static int64_t list_edges(const planish_cells *cells, edge *edges) {
    int64_t n = 0;
    for (int64_t i = 0; i < cells->n; i++)
        for (int64_t first = cells->offset[i], k = first; k < cells->offset[i + 1]; k++) {
            const int32_t a = cells->node[k],
                          b = cells->node[k + 1 < cells->offset[i + 1] ? k + 1 : first];
            edges[n++] = (edge){{a < b ? a : b, a < b ? b : a}};
        }
    return n;
}

/** Mark the nodes of borders: of edges of one facet. edges: room for all sides of facets. */
static void mark_borders(const planish_cells *cells, edge *edges, uint8_t *is_border) {
    const int64_t n = list_edges(cells, edges);
    qsort(edges, (size_t)n, sizeof *edges, compare_edges);
    for (int64_t i = 0, next; i < n; i = next) {
        for (next = i + 1; next < n && compare_edges(&edges[i], &edges[next]) == 0;)
            next++;
        for (int k = 0; k < 2 && next == i + 1; k++)
            is_border[edges[i].node[k]] = 1;
    }
}

/** Find the lowest node at the place of each node of a border. points [nodes]: room. first [nodes] */
static void find_first(const planish_mesh *mesh, const uint8_t *is_border, point *points,
                       int32_t *first) {
    int64_t n = 0;
    for (int32_t i = 0; i < mesh->n_nodes; i++) {
        first[i] = i;
        if (!is_border[i])
            continue;
        points[n].node = i;
        memcpy(points[n++].x, mesh->coordinates + 3 * (int64_t)i, sizeof points->x);
    }
    qsort(points, (size_t)n, sizeof *points, compare_points);
    for (int64_t i = 1; i < n; i++)
        if (compare_places(&points[i - 1], &points[i]) == 0)
            first[points[i].node] = first[points[i - 1].node];
}

/** Find the corners of a facet of n nodes: of neighbours in a quadrilateral at one node, one. Returns their number. */
static int find_corners(const int32_t *node, int64_t n, int32_t corner[4]) {
    int n_corners = 0;
    for (int64_t k = 0; k < n; k++)
        if (n == 3 || node[k] != node[(k + 1) % n])
            corner[n_corners++] = node[k];
    return n_corners;
}

/** Return a facet by its corners. */
static facet facet_of(const planish_cells *cells, int64_t i) {
    facet f = {.node = {-1, -1, -1, -1}, .number = (int32_t)i};
    int32_t corner[4];
    int lowest = 0;
    const int64_t begin = cells->offset[i];
    const int n = find_corners(cells->node + begin, cells->offset[i + 1] - begin, corner);
    for (int k = 1; k < n; k++)
        lowest = corner[k] < corner[lowest] ? k : lowest;
    for (int k = 0; k < n; k++)
        f.node[k] = corner[(lowest + k) % n];
    return f;
}

/** Whether a facet has less than three corners, or two at one node. */
static int is_collapsed(const facet *f) {
    for (int k = 0; k < 4; k++)
        for (int l = 0; l < k; l++)
            if (f->node[k] == f->node[l])
                return 1;
    return 0;
}

/** Take the facets that are not out to the front, with their corners. */
static void compact(pl_joined *joined, const uint8_t *is_out) {
    planish_cells *cells = &joined->cells;
    int64_t n_left = 0, end = 0;
    for (int64_t i = 0; i < cells->n; i++) {
        const int64_t begin = end;
        int32_t corner[4];
        end = cells->offset[i + 1]; /* before it becomes that of one that is left */
        const int n = find_corners(cells->node + begin, end - begin, corner);
        if (is_out[i]) {
            joined->n_left_out++;
            joined->n_quadrilaterals_out += cells->type[i] == PLANISH_CELL_QUADRILATERAL;
            continue;
        }
        memcpy(joined->node + joined->offset[n_left], corner, (size_t)n * sizeof *corner);
        joined->type[n_left] = n == 3 ? PLANISH_CELL_TRIANGLE : PLANISH_CELL_QUADRILATERAL;
        if (joined->region)
            joined->region[n_left] = joined->region[i];
        joined->offset[n_left + 1] = joined->offset[n_left] + n;
        n_left++;
    }
    cells->n = n_left;
}

/** Leave out facets that are collapsed, or there before. Those between two bodies, which turn against
 *  each other, stay. facets and is_out [cells.n]: room. */
static void leave_out(pl_joined *joined, facet *facets, uint8_t *is_out) {
    const int64_t n = joined->cells.n;
    for (int64_t i = 0; i < n; i++)
        facets[i] = facet_of(&joined->cells, i);
    qsort(facets, (size_t)n, sizeof *facets, compare_facets);
    for (int64_t i = 0; i < n; i++)
        is_out[facets[i].number] =
            is_collapsed(&facets[i]) ||
            (i > 0 && compare_numbers(facets[i - 1].node, facets[i].node, 4) == 0);
    compact(joined, is_out);
}

static int are_facets(const planish_cells *cells) {
    for (int64_t i = 0; i < cells->n; i++)
        if (cells->type[i] != PLANISH_CELL_TRIANGLE && cells->type[i] != PLANISH_CELL_QUADRILATERAL)
            return 0;
    return cells->n < INT32_MAX;
}

/** Room for the work. */
typedef struct room {
    edge *edges;
    point *points;
    facet *facets;
    uint8_t *is_border, *is_out;
    int32_t *first;
} room;

/** Return a copy of n items, and room for one more; NULL: there is no memory. */
static void *copy_of(const void *items, int64_t n, size_t size) {
    const size_t count = n > 0 ? (size_t)n : 0;
    void *copy = calloc(count + 1, size);
    if (copy && count > 0)
        memcpy(copy, items, count * size);
    return copy;
}

/** Copy what is changed; 0: there is no memory. */
static int copy_facets(const planish_cells *cells, const planish_surface *surface,
                       pl_joined *joined) {
    joined->type = copy_of(cells->type, cells->n, sizeof *joined->type);
    joined->offset = copy_of(cells->offset, cells->n + 1, sizeof *joined->offset);
    joined->node = copy_of(cells->node, cells->offset[cells->n], sizeof *joined->node);
    if (surface->region)
        joined->region = copy_of(surface->region, cells->n, sizeof *joined->region);
    joined->edges = copy_of(surface->edges, 2 * surface->n_edges, sizeof *joined->edges);
    joined->cells = (planish_cells){
        .n = cells->n, .type = joined->type, .offset = joined->offset, .node = joined->node};
    return joined->type && joined->offset && joined->node && (joined->region || !surface->region) &&
           joined->edges;
}

/** Make room; 0: there is no memory. */
static int prepare(const planish_cells *cells, int64_t nodes, room *r) {
    const size_t n = (size_t)cells->n + 1, n_nodes = (size_t)nodes + 1;
    r->edges = malloc(((size_t)cells->offset[cells->n] + 1) * sizeof *r->edges);
    r->points = malloc(n_nodes * sizeof *r->points);
    r->facets = malloc(n * sizeof *r->facets);
    r->is_border = calloc(n_nodes, 1);
    r->is_out = calloc(n, 1);
    r->first = malloc(n_nodes * sizeof *r->first);
    return r->edges && r->points && r->facets && r->is_border && r->is_out && r->first;
}

static void free_room(room *r) {
    free(r->edges);
    free(r->points);
    free(r->facets);
    free(r->is_border);
    free(r->is_out);
    free(r->first);
}

int pl_joined_take(const planish_mesh *mesh, const planish_surface *surface, pl_joined *joined) {
    *joined = (pl_joined){.node = NULL};
    if (!are_facets(mesh->cells))
        return 1;
    uint8_t *is_out = calloc((size_t)mesh->cells->n + 1, 1);
    const int have = copy_facets(mesh->cells, surface, joined) && is_out;
    for (int64_t i = 0; have && i < joined->cells.n; i++) {
        const facet f = facet_of(&joined->cells, i);
        is_out[i] = (uint8_t)is_collapsed(&f);
    }
    if (have)
        compact(joined, is_out);
    free(is_out);
    return have;
}

int pl_joined_join(const planish_mesh *mesh, int64_t n_edges, pl_joined *joined) {
    room r = {.edges = NULL};
    const int have = prepare(&joined->cells, mesh->n_nodes, &r);
    if (have) {
        leave_out(joined, r.facets, r.is_out);
        mark_borders(&joined->cells, r.edges, r.is_border);
        find_first(mesh, r.is_border, r.points, r.first);
        for (int64_t i = 0; i < mesh->n_nodes; i++)
            joined->n_points += r.first[i] != i;
        for (int64_t i = 0; i < joined->offset[joined->cells.n]; i++)
            joined->node[i] = r.first[joined->node[i]];
        for (int64_t i = 0; i < 2 * n_edges; i++)
            joined->edges[i] = r.first[joined->edges[i]];
        leave_out(joined, r.facets, r.is_out);
    }
    free_room(&r);
    return have;
}

void pl_joined_free(pl_joined *joined) {
    free(joined->type);
    free(joined->offset);
    free(joined->node);
    free(joined->region);
    free(joined->edges);
    *joined = (pl_joined){.node = NULL};
}
