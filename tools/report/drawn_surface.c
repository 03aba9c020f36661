/* drawn_surface: the triangles that a picture draws, coarser where they are many.
 *
 * Coarsening is by clustering (Rossignac and Borrel, Multi-resolution 3D approximations for
 * rendering complex scenes, 1993): nodes in one cell of a grid become one point, and triangles
 * between fewer than three cells vanish. The grid is made coarser until few enough are left.
 */
#include "report/drawn_surface.h"

#include "base/status.h"
#include "geometry/cell.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cells of the finest grid along the longest side, and the share that is left from grid to grid. */
static const double FINEST_GRID = 700;
static const double COARSER = 0.85;

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
            if (s->sides)
                s->sides[kept] = s->sides[i];
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
    const size_t n = (size_t)mesh->n_nodes + 1;
    int64_t *cell = malloc(n * sizeof *cell);
    cell_node *order = malloc(n * sizeof *order);
    *surface = (pl_drawn_surface){.point = malloc(n * sizeof *surface->point)};
    int status = pl_drawn_triangles_find(mesh, surface, error);
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

/** Whether all elements are simplices of the mesh's dimension. */
static int are_simplices(const planish_mesh *mesh) {
    const int dim = mesh->dim;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[i]);
        if (!type || type->shape->dim != dim || type->shape->n_corners != dim + 1)
            return 0;
    }
    return 1;
}

int pl_drawn_surface_find(const planish_mesh *mesh, int64_t most, pl_drawn_surface *surface,
                          planish_error *error) {
    const planish_cells *cells = mesh->cells;
    const int k = mesh->dim + 1;
    planish_mesh of_corners = *mesh;
    if (!cells || !are_simplices(mesh))
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
    free(surface->sides);
    free(surface->point);
    memset(surface, 0, sizeof *surface);
}
