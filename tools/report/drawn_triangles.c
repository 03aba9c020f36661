/* drawn_triangles: the triangles of a mesh that can be seen. */
#include "report/drawn_triangles.h"

#include "base/status.h"
#include "geometry/cell.h"
#include "topology/facets.h"

#include <stdlib.h>
#include <string.h>

/* ---- simplices ----------------------------------------------------------------------------------- */

/** Facets of solid elements as they are found. */
typedef struct collection {
    const planish_mesh *mesh;
    pl_drawn_surface *surface;
    int64_t capacity;
    int has_sides;
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
    uint8_t *sides = c->has_sides ? realloc(s->sides, (size_t)capacity) : NULL;
    if (sides)
        s->sides = sides;
    if (!triangle || !element || (c->has_sides && !sides))
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
    collection c = {mesh, surface, 0, 0, 0};
    int status = pl_incidence_create(mesh, NULL, ONE_THREAD, &incidence, error);
    if (!status)
        status = pl_facets_match(mesh, &incidence, NULL, ONE_THREAD, take_facets, &c, error);
    pl_incidence_destroy(&incidence);
    return status || !c.failed ? status : pl_fail_memory(error, "the picture");
}

/* ---- elements of any type ------------------------------------------------------------------------- */

enum { MOST_SIDES = 4, FACETS = 8 }; /* nodes of a facet; numbers of facets of an element */

/** Nodes of facet k of an element, around it; returns how many. */
static int find_facet(const planish_cells *cells, int64_t element, int k, int32_t *node) {
    const pl_cell_shape *shape = pl_cell_type_of(cells->type[element])->shape;
    int n = 0;
    for (; n < MOST_SIDES && shape->facet[k][n] >= 0; n++)
        node[n] = cells->node[cells->offset[element] + shape->facet[k][n]];
    return n;
}

/** A facet as it is compared. */
typedef struct cell_facet {
    int32_t sorted[MOST_SIDES]; /* nodes, ascending; -1 in front: there are three */
    int64_t number;             /* FACETS * element + facet */
} cell_facet;

static int compare_facets(const void *a, const void *b) {
    const cell_facet *x = a, *y = b;
    for (int i = 0; i < MOST_SIDES; i++)
        if (x->sorted[i] != y->sorted[i])
            return x->sorted[i] < y->sorted[i] ? -1 : 1;
    return (x->number > y->number) - (x->number < y->number);
}

static cell_facet facet_of(const planish_cells *cells, int64_t number) {
    cell_facet f = {.sorted = {-1, -1, -1, -1}, .number = number};
    int32_t node[MOST_SIDES] = {0};
    const int n = find_facet(cells, number / FACETS, (int)(number % FACETS), node);
    for (int i = 0; i < n; i++) { /* the free places are in front */
        int at = MOST_SIDES - 1 - i;
        for (; at + 1 < MOST_SIDES && f.sorted[at + 1] < node[i]; at++)
            f.sorted[at] = f.sorted[at + 1];
        f.sorted[at] = node[i];
    }
    return f;
}

/** Add the triangles of a polygon of n nodes of an element. */
static void add_polygon(collection *c, const int32_t *node, int n, int64_t element) {
    static const uint8_t SIDES[2][2] = {{7, 0}, {3, 6}}; /* of a triangle; of two with a diagonal */
    for (int i = 0; i + 2 < n && !c->failed && make_room(c); i++) {
        pl_drawn_surface *s = c->surface;
        int32_t *triangle = s->triangle + 3 * s->n_triangles;
        triangle[0] = node[0];
        triangle[1] = node[i + 1];
        triangle[2] = node[i + 2];
        s->element[s->n_triangles] = (int32_t)element;
        s->sides[s->n_triangles++] = SIDES[n - 3][i];
    }
}

/** Add a facet so that it faces outwards of its element. */
static void add_outwards(collection *c, int64_t number) {
    const planish_cells *cells = c->mesh->cells;
    const int64_t element = number / FACETS;
    const int n_corners = pl_cell_type_of(cells->type[element])->shape->n_corners;
    const double *x = c->mesh->coordinates;
    int32_t node[MOST_SIDES] = {0};
    const int n = find_facet(cells, element, (int)(number % FACETS), node);
    double middle[3] = {0}, u[3], v[3], w[3];
    for (int i = 0; i < n_corners; i++)
        for (int d = 0; d < 3; d++)
            middle[d] += x[3 * (int64_t)cells->node[cells->offset[element] + i] + d] / n_corners;
    for (int d = 0; d < 3; d++) {
        u[d] = x[3 * (int64_t)node[2] + d] - x[3 * (int64_t)node[0] + d];
        v[d] = x[3 * (int64_t)node[n - 1] + d] - x[3 * (int64_t)node[1] + d];
        w[d] = x[3 * (int64_t)node[0] + d] - middle[d];
    }
    const double outwards = w[0] * (u[1] * v[2] - u[2] * v[1]) +
                            w[1] * (u[2] * v[0] - u[0] * v[2]) + w[2] * (u[0] * v[1] - u[1] * v[0]);
    for (int i = 1, j = n - 1; outwards < 0 && i < j; i++, j--) {
        const int32_t other = node[i];
        node[i] = node[j];
        node[j] = other;
    }
    add_polygon(c, node, n, element);
}

/** Add the facets, listed by their lowest nodes, that no second element has: those of node i are
 *  number[end[i - 1]] to number[end[i]]. */
static void add_single(collection *c, const int64_t *end, const int64_t *number) {
    int64_t most = 0, begin = 0;
    for (int64_t i = 0; i < c->mesh->n_nodes; begin = end[i++])
        most = end[i] - begin > most ? end[i] - begin : most;
    cell_facet *facet = malloc(((size_t)most + 1) * sizeof *facet);
    c->failed = !facet;
    begin = 0;
    for (int64_t i = 0; i < c->mesh->n_nodes && !c->failed; begin = end[i++]) {
        const int64_t n = end[i] - begin;
        for (int64_t k = 0; k < n; k++)
            facet[k] = facet_of(c->mesh->cells, number[begin + k]);
        qsort(facet, (size_t)n, sizeof *facet, compare_facets);
        for (int64_t k = 0; k < n; k++) {
            const size_t size = sizeof facet->sorted;
            const int is_second = k > 0 && memcmp(facet[k].sorted, facet[k - 1].sorted, size) == 0;
            const int is_first =
                k + 1 < n && memcmp(facet[k].sorted, facet[k + 1].sorted, size) == 0;
            if (!is_second && !is_first)
                add_outwards(c, facet[k].number);
        }
    }
    free(facet);
}

/** Dimension of the elements: of a surface in space, whose elements are all flat, 2. */
static int dim_of(const planish_mesh *mesh) {
    const pl_cell_type *type =
        mesh->cells && mesh->cells->n > 0 ? pl_cell_type_of(mesh->cells->type[0]) : NULL;
    for (int64_t i = 0; type && i < mesh->cells->n; i++) {
        const pl_cell_type *of = pl_cell_type_of(mesh->cells->type[i]);
        if (!of || of->shape->dim != 2)
            return mesh->dim;
    }
    return type ? 2 : mesh->dim;
}

/** Shape of an element of dimension dim, or NULL. */
static const pl_cell_shape *shape_of(const planish_mesh *mesh, int dim, int64_t element) {
    const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[element]);
    return type && type->shape->dim == dim ? type->shape : NULL;
}

static int32_t lowest_of(const planish_cells *cells, int64_t element, int k) {
    int32_t node[MOST_SIDES] = {0};
    const int n = find_facet(cells, element, k, node);
    int32_t lowest = node[0];
    for (int i = 1; i < n; i++)
        lowest = node[i] < lowest ? node[i] : lowest;
    return lowest;
}

/** Add the facets of solid elements that no second element has. */
static void add_surface(collection *c) {
    const planish_mesh *mesh = c->mesh;
    int64_t n_facets = 0;
    int64_t *end = calloc((size_t)mesh->n_nodes + 1, sizeof *end), *number = NULL;
    c->failed = !end;
    for (int64_t i = 0; i < mesh->n_elements && !c->failed; i++)
        for (int k = 0; shape_of(mesh, 3, i) && k < shape_of(mesh, 3, i)->n_facets; k++, n_facets++)
            end[lowest_of(mesh->cells, i, k) + 1]++;
    if (!c->failed)
        c->failed = !(number = malloc(((size_t)n_facets + 1) * sizeof *number));
    for (int64_t i = 0; i < mesh->n_nodes && !c->failed; i++)
        end[i + 1] += end[i];
    /* end[i] is where those of node i begin, and then, one by one, where they end. */
    for (int64_t i = 0; i < mesh->n_elements && !c->failed; i++)
        for (int k = 0; shape_of(mesh, 3, i) && k < shape_of(mesh, 3, i)->n_facets; k++)
            number[end[lowest_of(mesh->cells, i, k)]++] = FACETS * i + k;
    if (!c->failed)
        add_single(c, end, number);
    free(end);
    free(number);
}

static int find_cell_triangles(const planish_mesh *mesh, pl_drawn_surface *surface,
                               planish_error *error) {
    collection c = {mesh, surface, 0, 1, 0};
    const planish_cells *cells = mesh->cells;
    const int dim = dim_of(mesh);
    if (dim == 3)
        add_surface(&c);
    for (int64_t i = 0; dim == 2 && i < cells->n && !c.failed; i++)
        if (shape_of(mesh, 2, i))
            add_polygon(&c, cells->node + cells->offset[i], shape_of(mesh, 2, i)->n_corners, i);
    return c.failed ? pl_fail_memory(error, "the picture") : PLANISH_OK;
}

/* ---- all of it ----------------------------------------------------------------------------------- */

/** List the elements of a mesh of triangles alone. */
static int list_triangles(const planish_mesh *mesh, pl_drawn_surface *surface,
                          planish_error *error) {
    const size_t m = (size_t)mesh->n_elements;
    surface->triangle = malloc((3 * m + 1) * sizeof *surface->triangle);
    surface->element = malloc((m + 1) * sizeof *surface->element);
    surface->n_triangles = mesh->n_elements;
    if (!surface->triangle || !surface->element)
        return pl_fail_memory(error, "the picture");
    for (size_t i = 0; i < m; i++)
        surface->element[i] = (int32_t)i;
    if (m > 0)
        memcpy(surface->triangle, mesh->elements, 3 * m * sizeof *surface->triangle);
    return PLANISH_OK;
}

int pl_drawn_triangles_find(const planish_mesh *mesh, pl_drawn_surface *surface,
                            planish_error *error) {
    return mesh->cells      ? find_cell_triangles(mesh, surface, error)
           : mesh->dim == 3 ? find_facets(mesh, surface, error)
                            : list_triangles(mesh, surface, error);
}
