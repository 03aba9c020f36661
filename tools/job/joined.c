/* joined: triangles that have points of their own, joined where these are equal. */
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

/** A triangle, by its nodes in their order, from the lowest one on. */
typedef struct triangle {
    int32_t node[3], number;
} triangle;

static int compare_numbers(const int32_t *a, const int32_t *b, int n) {
    for (int i = 0; i < n; i++)
        if (a[i] != b[i])
            return a[i] < b[i] ? -1 : 1;
    return 0;
}

static int compare_edges(const void *a, const void *b) {
    return compare_numbers(((const edge *)a)->node, ((const edge *)b)->node, 2);
}

static int compare_triangles(const void *a, const void *b) {
    const triangle *s = a, *t = b;
    const int by_nodes = compare_numbers(s->node, t->node, 3);
    return by_nodes ? by_nodes : compare_numbers(&s->number, &t->number, 1);
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

/** Mark the nodes of borders: of edges of one triangle. edges [3 * triangles]: room. */
static void mark_borders(const planish_cells *cells, edge *edges, uint8_t *is_border) {
    const int64_t n = 3 * cells->n;
    for (int64_t i = 0; i < n; i++) {
        const int32_t a = cells->node[i], b = cells->node[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = (edge){{a < b ? a : b, a < b ? b : a}};
    }
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

/** Return a triangle by its nodes. */
static triangle triangle_of(const int32_t *node, int32_t number) {
    int lowest = 0;
    for (int i = 1; i < 3; i++)
        lowest = node[i] < node[lowest] ? i : lowest;
    return (triangle){{node[lowest], node[(lowest + 1) % 3], node[(lowest + 2) % 3]}, number};
}

/** Leave out triangles that have a node twice, or are there before. Those between two bodies, which turn against each
 *  other, stay. triangles and is_out [cells.n]: room. */
static void leave_out(pl_joined *joined, triangle *triangles, uint8_t *is_out) {
    planish_cells *cells = &joined->cells;
    int64_t n_left = 0;
    for (int64_t i = 0; i < cells->n; i++)
        triangles[i] = triangle_of(joined->node + 3 * i, (int32_t)i);
    qsort(triangles, (size_t)cells->n, sizeof *triangles, compare_triangles);
    for (int64_t i = 0; i < cells->n; i++) {
        const int32_t *v = triangles[i].node;
        is_out[triangles[i].number] = v[0] == v[1] || v[1] == v[2] || v[2] == v[0] ||
                                      (i > 0 && compare_numbers(triangles[i - 1].node, v, 3) == 0);
    }
    for (int64_t i = 0; i < cells->n; i++) {
        if (is_out[i])
            continue;
        memmove(joined->node + 3 * n_left, joined->node + 3 * i, 3 * sizeof *joined->node);
        if (joined->region)
            joined->region[n_left] = joined->region[i];
        n_left++;
    }
    joined->n_triangles += cells->n - n_left;
    cells->n = n_left;
}

static int are_triangles(const planish_cells *cells) {
    for (int64_t i = 0; i < cells->n; i++)
        if (cells->type[i] != PLANISH_CELL_TRIANGLE)
            return 0;
    return cells->n < INT32_MAX;
}

/** Room for the work. */
typedef struct room {
    edge *edges;
    point *points;
    triangle *triangles;
    uint8_t *is_border, *is_out;
    int32_t *first;
} room;

/** Make room, and copy what is changed; 0: there is no memory. */
static int prepare(const planish_mesh *mesh, const planish_surface *surface, room *r,
                   pl_joined *joined) {
    const size_t n = (size_t)joined->cells.n + 1, n_nodes = (size_t)mesh->n_nodes + 1;
    const size_t n_ends = 2 * (size_t)surface->n_edges;
    r->edges = malloc(3 * n * sizeof *r->edges);
    r->points = malloc(n_nodes * sizeof *r->points);
    r->triangles = malloc(n * sizeof *r->triangles);
    r->is_border = calloc(n_nodes, 1);
    r->is_out = calloc(n, 1);
    r->first = malloc(n_nodes * sizeof *r->first);
    joined->node = malloc(3 * n * sizeof *joined->node);
    joined->region = surface->region ? malloc(n * sizeof *joined->region) : NULL;
    joined->edges = malloc((n_ends + 1) * sizeof *joined->edges);
    if (joined->node)
        memcpy(joined->node, joined->cells.node, 3 * (n - 1) * sizeof *joined->node);
    joined->cells.node = joined->node;
    if (joined->region)
        memcpy(joined->region, surface->region, (n - 1) * sizeof *joined->region);
    return r->edges && r->points && r->triangles && r->is_border && r->is_out && r->first &&
           joined->node && (joined->region || !surface->region) && joined->edges;
}

static void free_room(room *r) {
    free(r->edges);
    free(r->points);
    free(r->triangles);
    free(r->is_border);
    free(r->is_out);
    free(r->first);
}

int pl_join_triangles(const planish_mesh *mesh, const planish_surface *surface, pl_joined *joined) {
    const planish_cells *cells = mesh->cells;
    room r = {.edges = NULL};
    *joined = (pl_joined){.cells = *cells};
    if (!are_triangles(cells))
        return 1;
    const int have = prepare(mesh, surface, &r, joined);
    if (have) {
        leave_out(joined, r.triangles, r.is_out);
        mark_borders(&joined->cells, r.edges, r.is_border);
        find_first(mesh, r.is_border, r.points, r.first);
        for (int64_t i = 0; i < mesh->n_nodes; i++)
            joined->n_points += r.first[i] != i;
        for (int64_t i = 0; i < 3 * joined->cells.n; i++)
            joined->node[i] = r.first[joined->node[i]];
        for (int64_t i = 0; i < 2 * surface->n_edges; i++)
            joined->edges[i] = r.first[surface->edges[i]];
        leave_out(joined, r.triangles, r.is_out);
    }
    free_room(&r);
    return have;
}

void pl_joined_free(pl_joined *joined) {
    free(joined->node);
    free(joined->region);
    free(joined->edges);
    *joined = (pl_joined){.node = NULL};
}
