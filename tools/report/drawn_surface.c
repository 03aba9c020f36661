/* drawn_surface: the triangles that a picture draws.
 *
 * Coarsening is by clustering (Rossignac and Borrel, Multi-resolution 3D approximations for
 * rendering complex scenes, 1993): nodes in one cell of a grid become one point, and triangles
 * between fewer than three cells vanish. The grid is made coarser until few enough are left.
 */
#include "report/drawn_surface.h"

#include "base/memory.h"
#include "base/status.h"
#include "topology/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cells of the finest grid along the longest side, and the share that is left from grid to grid. */
static const double FINEST_GRID = 700;
static const double COARSER = 0.85;

/* ---- all triangles -------------------------------------------------------------------------- */

/** Facets of tetrahedra as they are found. */
typedef struct collection {
    const planish_mesh *mesh;
    pl_drawn_surface *surface;
    int64_t capacity;
    int failed;
} collection;

static int make_room(collection *c) {
    pl_drawn_surface *s = c->surface;
    if (s->n_triangles < c->capacity)
        return 1;
    const int64_t capacity = c->capacity ? 2 * c->capacity : 4096;
    int32_t *triangle = realloc(s->triangle, (size_t)capacity * 3 * sizeof *triangle);
    if (triangle)
        s->triangle = triangle;
    int32_t *element = realloc(s->element, (size_t)capacity * sizeof *element);
    if (element)
        s->element = element;
    if (!triangle || !element)
        return !(c->failed = 1);
    c->capacity = capacity;
    return 1;
}

/** Whether triangle, a facet of the tetrahedron with the further node opposite, faces inwards. */
static int faces_inwards(const planish_mesh *mesh, const int32_t *triangle, int32_t opposite) {
    const double *x = mesh->coordinates, *o = x + 3 * (int64_t)opposite;
    double e[3][3];
    for (int i = 0; i < 3; i++)
        for (int d = 0; d < 3; d++)
            e[i][d] = x[3 * (int64_t)triangle[i] + d] - o[d];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
               e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
               e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]) <
           0;
}

/** Take the facets of node that no second element has. */
static void take_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                        int thread) {
    collection *c = context;
    (void)thread;
    for (int32_t i = 0; i < n_facets; i++) {
        if (facets[i].count != 1 || c->failed || !make_room(c))
            continue;
        int32_t *triangle = c->surface->triangle + 3 * c->surface->n_triangles;
        triangle[0] = node;
        triangle[1] = facets[i].node[0];
        triangle[2] = facets[i].node[1];
        if (faces_inwards(c->mesh, triangle, facets[i].opposite)) {
            triangle[1] = facets[i].node[1];
            triangle[2] = facets[i].node[0];
        }
        c->surface->element[c->surface->n_triangles++] = facets[i].element[0];
    }
}

static int find_facets(const planish_mesh *mesh, pl_drawn_surface *surface, planish_error *error) {
    enum { ONE_THREAD = 1 }; /* so that the order is that of the nodes */
    pl_incidence incidence = {0};
    collection c = {mesh, surface, 0, 0};
    int status = pl_incidence_create(mesh, NULL, ONE_THREAD, &incidence, error);
    if (!status)
        status = pl_facets_match(mesh, &incidence, NULL, ONE_THREAD, take_facets, &c, error);
    pl_incidence_destroy(&incidence);
    return status || !c.failed ? status : pl_fail_memory(error, "the picture");
}

/* ---- fewer ---------------------------------------------------------------------------------- */

/** Keep the triangles between three cells, in number and then (if compact) in place. */
static int64_t count_kept(pl_drawn_surface *s, const int64_t *cell, int compact) {
    int64_t kept = 0;
    for (int64_t i = 0; i < s->n_triangles; i++) {
        const int32_t *t = s->triangle + 3 * i;
        const int64_t a = cell[t[0]], b = cell[t[1]], c = cell[t[2]];
        if (a == b || b == c || c == a)
            continue;
        if (compact) {
            memmove(s->triangle + 3 * kept, t, 3 * sizeof *t);
            s->element[kept] = s->element[i];
        }
        kept++;
    }
    return kept;
}

/** Fill cell [n_nodes] so that at most most triangles are between three cells: at first each node
 *  is a cell of its own. */
static void find_cells(const planish_mesh *mesh, pl_drawn_surface *s, int64_t most, int64_t *cell) {
    const int dim = mesh->dim;
    double low[3], extent[3], longest = 0;
    for (int d = 0; d < dim; d++) {
        double high = -INFINITY;
        low[d] = INFINITY;
        for (int64_t i = 0; i < mesh->n_nodes; i++) {
            low[d] = fmin(low[d], mesh->coordinates[i * dim + d]);
            high = fmax(high, mesh->coordinates[i * dim + d]);
        }
        extent[d] = high - low[d];
        longest = fmax(longest, extent[d]);
    }
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        cell[i] = i;
    for (double n = FINEST_GRID; count_kept(s, cell, 0) > most; n *= COARSER) {
        const double size = longest > 0 && isfinite(longest) ? longest / n : 1;
        for (int64_t i = 0; i < mesh->n_nodes; i++) {
            cell[i] = 0;
            for (int d = 0; d < dim; d++) {
                const int64_t n_cells = (int64_t)fmin(extent[d] / size, n) + 1;
                const double at = (mesh->coordinates[i * dim + d] - low[d]) / size;
                cell[i] = cell[i] * n_cells + (int64_t)fmin(at, (double)(n_cells - 1));
            }
        }
    }
    s->n_triangles = count_kept(s, cell, 1);
}

typedef struct cell_node {
    int64_t cell;
    int32_t node;
} cell_node;

static int compare_cells(const void *a, const void *b) {
    const cell_node *x = a, *y = b;
    return x->cell != y->cell ? (x->cell > y->cell) - (x->cell < y->cell)
                              : (x->node > y->node) - (x->node < y->node);
}

/** Number the cells of the nodes that the triangles have; all nodes of such a cell on the surface
 *  share its point. order [n_nodes]: scratch. */
static void number_points(const planish_mesh *mesh, pl_drawn_surface *s, const int64_t *cell,
                          cell_node *order) {
    int64_t n = 0;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        s->point[i] = -1;
    for (int64_t i = 0; i < 3 * s->n_triangles; i++) {
        const int32_t node = s->triangle[i];
        if (s->point[node] < 0) {
            s->point[node] = 0;
            order[n++] = (cell_node){cell[node], node};
        }
    }
    qsort(order, (size_t)n, sizeof *order, compare_cells);
    for (int64_t i = 0; i < n; i++) {
        s->n_points += i == 0 || order[i].cell != order[i - 1].cell;
        s->point[order[i].node] = (int32_t)(s->n_points - 1);
    }
    for (int64_t i = 0; i < 3 * s->n_triangles; i++)
        s->triangle[i] = s->point[s->triangle[i]];
}

/** The surface of a mesh that has elements. */
static int find_surface(const planish_mesh *mesh, int64_t most, pl_drawn_surface *surface,
                        planish_error *error) {
    const size_t n = (size_t)mesh->n_nodes + 1, m = (size_t)mesh->n_elements;
    int64_t *cell = malloc(n * sizeof *cell);
    cell_node *order = malloc(n * sizeof *order);
    *surface = (pl_drawn_surface){.point = malloc(n * sizeof *surface->point)};
    int status = PLANISH_OK;
    if (mesh->dim == 3) {
        status = find_facets(mesh, surface, error);
    } else {
        surface->triangle = malloc((3 * m + 1) * sizeof *surface->triangle);
        surface->element = malloc((m + 1) * sizeof *surface->element);
        surface->n_triangles = mesh->n_elements;
        if (!surface->triangle || !surface->element)
            status = pl_fail_memory(error, "the picture");
        for (size_t i = 0; i < m && !status; i++)
            surface->element[i] = (int32_t)i;
        if (m > 0 && !status)
            memcpy(surface->triangle, mesh->elements, 3 * m * sizeof *surface->triangle);
    }
    if (!status && (!cell || !order || !surface->point))
        status = pl_fail_memory(error, "the picture");
    surface->n_all = surface->n_triangles;
    if (!status) {
        find_cells(mesh, surface, most, cell);
        number_points(mesh, surface, cell, order);
    } else {
        pl_drawn_surface_free(surface);
    }
    free(cell);
    free(order);
    return status;
}

int pl_drawn_surface_find(const planish_mesh *mesh, int64_t most, pl_drawn_surface *surface,
                          planish_error *error) {
    const planish_cells *cells = mesh->cells;
    const int k = mesh->dim + 1;
    planish_mesh of_corners = *mesh;
    if (!cells)
        return find_surface(mesh, most, surface, error);
    int32_t *corner = malloc(((size_t)cells->n * (size_t)k + 1) * sizeof *corner);
    *surface = (pl_drawn_surface){.n_all = 0};
    if (!corner)
        return pl_fail_memory(error, "the picture");
    for (int64_t i = 0; i < cells->n; i++)
        memcpy(corner + i * k, cells->node + cells->offset[i], (size_t)k * sizeof *corner);
    of_corners.cells = NULL;
    of_corners.elements = corner;
    const int status = find_surface(&of_corners, most, surface, error);
    free(corner);
    return status;
}

void pl_drawn_surface_free(pl_drawn_surface *surface) {
    free(surface->triangle);
    free(surface->element);
    free(surface->point);
    memset(surface, 0, sizeof *surface);
}
