/* background: simplices, what lies across their facets, and walks from one to the next. */
#include "topology/background.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "topology/facets.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum {
    CHUNK = 4096,
    MOST_SIMPLICES = 6 /* of a cell */
};

/* ---- cells as simplices ----------------------------------------------------------------------- */

/** Simplices of a cell, by its corners. */
typedef struct pieces {
    int n;
    int32_t node[MOST_SIMPLICES][4];
} pieces;

/* Corners of a simplex. */
static const int WHOLE[4] = {0, 1, 2, 3};

/** Add a simplex, unless it has a node twice. */
static void add_piece(int dim, const int32_t *node, const int corner[4], pieces *p) {
    int32_t *piece = p->node[p->n];
    for (int i = 0; i <= dim; i++) {
        piece[i] = node[corner[i]];
        for (int j = 0; j < i; j++)
            if (piece[j] == piece[i])
                return;
    }
    p->n++;
}

/** Return the place of the smallest of n nodes, those of corners if not NULL. */
static int place_of_smallest(int n, const int32_t *node, const int8_t *corner) {
    int smallest = 0;
    for (int i = 1; i < n; i++)
        if (node[corner ? corner[i] : i] < node[corner ? corner[smallest] : smallest])
            smallest = i;
    return smallest;
}

/** Join a corner of a cell to a facet that does not have it. */
static void join(const pl_cell_shape *shape, const int32_t *node, int apex, const int8_t *facet,
                 pieces *p) {
    const int n = shape->dim == 2 ? 2 : facet[3] < 0 ? 3 : 4;
    for (int i = 0; i < n; i++)
        if (facet[i] == apex)
            return;
    const int from = n == 4 ? place_of_smallest(4, node, facet) : 0;
    for (int i = 1; i + shape->dim <= n + 1; i++)
        add_piece(
            shape->dim, node,
            (const int[4]){apex, facet[from], facet[(from + i) % n], facet[(from + i + 1) % n]}, p);
}

/** Cut a cell into simplices; none if it is not of dimension dim. */
static void cut_cell(const planish_cells *cells, int64_t cell, int dim, pieces *p) {
    const pl_cell_type *type = pl_cell_type_of(cells->type[cell]);
    const int32_t *node = cells->node + cells->offset[cell];
    if (!type || type->shape->dim != dim)
        return;
    const pl_cell_shape *shape = type->shape;
    if (shape->n_corners == dim + 1) {
        add_piece(dim, node, WHOLE, p);
        return;
    }
    const int apex = place_of_smallest(shape->n_corners, node, NULL);
    for (int f = 0; f < shape->n_facets; f++)
        join(shape, node, apex, shape->facet[f], p);
}

/** Cut an element of a mesh. */
static void cut(const planish_mesh *mesh, int64_t element, pieces *p) {
    int32_t node[4];
    p->n = 0;
    if (mesh->cells) {
        cut_cell(mesh->cells, element, mesh->dim, p);
        return;
    }
    for (int j = 0; j <= mesh->dim; j++)
        node[j] = (int32_t)pl_corner(mesh, element, j);
    add_piece(mesh->dim, node, WHOLE, p);
}

/** Elements being cut. */
typedef struct cutting {
    const planish_mesh *mesh;
    pl_background *background;
    int64_t *begin; /* [elements + 1] where the simplices of each begin */
} cutting;

static void count_pieces(void *context, int64_t begin, int64_t end, int thread) {
    const cutting *c = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        pieces p;
        cut(c->mesh, i, &p);
        c->begin[i] = p.n;
    }
}

static void write_pieces(void *context, int64_t begin, int64_t end, int thread) {
    const cutting *c = context;
    const int k = c->background->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        pieces p;
        cut(c->mesh, i, &p);
        for (int j = 0; j < p.n; j++)
            memcpy(c->background->node + (c->begin[i] + j) * k, p.node[j],
                   (size_t)k * sizeof **p.node);
    }
}

/** Cut all n elements. */
static int cut_all(const planish_mesh *mesh, int64_t n, int threads, pl_background *b,
                   planish_error *error) {
    cutting c = {mesh, b, pl_alloc(n + 1, sizeof *c.begin)};
    int status = c.begin ? PLANISH_OK : pl_fail_memory(error, "the field of sizes");
    if (!status) {
        pl_parallel_for(threads, n, CHUNK, count_pieces, &c);
        b->n_simplices = pl_prefix_sum(threads, n, c.begin);
        if (b->n_simplices > INT32_MAX)
            status = pl_fail(error, PLANISH_ERROR_MESH,
                             "a field of sizes would have %" PRId64
                             " simplices; it must have at most %" PRId32,
                             b->n_simplices, INT32_MAX);
    }
    if (!status) {
        b->node = pl_alloc(b->n_simplices * (b->dim + 1), sizeof *b->node);
        if (b->node)
            pl_parallel_for(threads, n, CHUNK, write_pieces, &c);
        else
            status = pl_fail_memory(error, "the field of sizes");
    }
    pl_free(c.begin);
    return status;
}

/* ---- what lies across -------------------------------------------------------------------------- */

/** Place in a simplex of the node that is not in the facet of node and f. */
static int place_opposite(const pl_background *b, int32_t simplex, int32_t node,
                          const pl_facet *f) {
    const int32_t *of = b->node + (int64_t)simplex * (b->dim + 1);
    for (int i = 0; i <= b->dim; i++)
        if (of[i] != node && of[i] != f->node[0] && (b->dim == 2 || of[i] != f->node[1]))
            return i;
    return 0;
}

static void link_facets(void *context, int32_t node, const pl_facet *facets, int32_t n,
                        int thread) {
    const pl_background *b = context;
    const int k = b->dim + 1;
    (void)thread;
    for (int32_t i = 0; i < n; i++)
        for (int side = 0; side < 2 && pl_facet_joins(&facets[i]); side++) {
            const int32_t here = facets[i].element[side];
            b->across[(int64_t)here * k + place_opposite(b, here, node, &facets[i])] =
                facets[i].element[1 - side];
        }
}

/** Fill across and first. */
static int link_simplices(int threads, pl_background *b, planish_error *error) {
    const planish_mesh mesh = {.dim = b->dim,
                               .n_nodes = b->n_nodes,
                               .n_elements = b->n_simplices,
                               .elements = b->node,
                               .coordinates = b->x};
    pl_incidence incidence;
    int status = pl_incidence_create(&mesh, NULL, threads, &incidence, error);
    if (status)
        return status;
    for (int64_t i = 0; i < b->n_nodes; i++)
        b->first[i] = incidence.offset[i] < incidence.offset[i + 1]
                          ? incidence.element[incidence.offset[i]]
                          : -1;
    status = pl_facets_match(&mesh, &incidence, NULL, threads, link_facets, b, error);
    pl_incidence_destroy(&incidence);
    return status;
}

/** Copy the points, brought to a size of about 1. */
static void take_points(const double *x, pl_background *b) {
    double extent = 0;
    int exponent = 0;
    for (int64_t i = 0; i < b->n_nodes * b->dim; i++)
        extent = fmax(extent, fabs(x[i]));
    frexp(extent, &exponent);
    b->scale = ldexp(1, -pl_scale_exponent(exponent));
    for (int64_t i = 0; i < b->n_nodes * b->dim; i++)
        b->x[i] = x[i] * b->scale;
}

int pl_background_create(const planish_mesh *mesh, const double *x, int threads, pl_background *b,
                         planish_error *error) {
    const int dim = mesh->dim;
    const int64_t n = mesh->cells ? mesh->cells->n : mesh->n_elements, n_nodes = mesh->n_nodes;
    *b = (pl_background){.dim = dim, .n_nodes = n_nodes};
    const int status = cut_all(mesh, n, threads, b, error);
    if (status)
        return status;
    const int64_t n_across = b->n_simplices * (dim + 1);
    b->x = pl_alloc(n_nodes * dim, sizeof *b->x);
    b->across = pl_alloc(n_across, sizeof *b->across);
    b->first = pl_alloc(n_nodes, sizeof *b->first);
    if (!b->x || !b->across || !b->first)
        return pl_fail_memory(error, "the field of sizes");
    take_points(x, b);
    memset(b->across, -1, (size_t)n_across * sizeof *b->across);
    return link_simplices(threads, b, error);
}

void pl_background_destroy(pl_background *b) {
    pl_free(b->x);
    pl_free(b->node);
    pl_free(b->across);
    pl_free(b->first);
}

/* ---- walks ------------------------------------------------------------------------------------- */

/* A walk that has come no nearer in so many steps has met the boundary, or goes around where the mesh is
 * tangled. */
enum { PATIENCE = 16 };

/** Fill weight with what makes point a mean of a simplex's nodes; returns 0 if it is flat. */
static int weigh(const pl_background *b, int32_t simplex, const double *point, double weight[4]) {
    const int dim = b->dim;
    const int32_t *node = b->node + (int64_t)simplex * (dim + 1);
    const double *origin = b->x + (int64_t)node[0] * dim;
    double edges[3][3] = {{0}}, way[3] = {0}, sum = 0;
    for (int j = 0; j < dim; j++)
        pl_subtract(dim, b->x + (int64_t)node[j + 1] * dim, origin, edges[j]);
    pl_subtract(dim, point, origin, way);
    const double whole = pl_determinant_of_edges(dim, (const double(*)[3])edges);
    for (int j = 0; j < dim; j++) {
        double with[3][3];
        memcpy(with, edges, sizeof with);
        memcpy(with[j], way, sizeof way);
        weight[j + 1] = pl_determinant_of_edges(dim, (const double(*)[3])with) / whole;
        sum += weight[j + 1];
    }
    weight[0] = 1 - sum;
    return isfinite(sum);
}

/** Place of the lowest weight whose facet leads on; -1: the point is inside, or no way leads to it. */
static int way_on(const pl_background *b, int32_t simplex, const double weight[4]) {
    int best = -1;
    for (int i = 0; i <= b->dim; i++)
        if (weight[i] < 0 && b->across[(int64_t)simplex * (b->dim + 1) + i] >= 0 &&
            (best < 0 || weight[i] < weight[best]))
            best = i;
    return best;
}

/** Bring weights to what is inside of a simplex; returns the square of the distance to point. */
static double clip(const pl_background *b, int32_t simplex, const double *point, double weight[4]) {
    const int dim = b->dim;
    const int32_t *node = b->node + (int64_t)simplex * (dim + 1);
    double sum = 0, square = 0;
    for (int i = 0; i <= dim; i++)
        sum += weight[i] = fmax(weight[i], 0);
    for (int i = 0; i <= dim; i++)
        weight[i] /= sum;
    for (int d = 0; d < dim; d++) {
        double way = -point[d];
        for (int i = 0; i <= dim; i++)
            way += weight[i] * b->x[(int64_t)node[i] * dim + d];
        square += way * way;
    }
    return square;
}

void pl_background_find(const pl_background *b, const double *at, int32_t *simplex,
                        double weight[4]) {
    int32_t here = *simplex;
    double nearest = INFINITY, point[3] = {0}, now[4];
    for (int d = 0; d < b->dim; d++)
        point[d] = at[d] * b->scale;
    for (int i = 0; i <= b->dim; i++)
        weight[i] = 1.0 / (b->dim + 1);
    for (int patience = PATIENCE; patience > 0 && weigh(b, here, point, now); patience--) {
        const int way = way_on(b, here, now);
        const double square = clip(b, here, point, now);
        if (square < nearest) {
            nearest = square;
            patience = PATIENCE;
            *simplex = here;
            memcpy(weight, now, sizeof now);
        }
        if (way < 0)
            return;
        here = b->across[(int64_t)here * (b->dim + 1) + way];
    }
}
