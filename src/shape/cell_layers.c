/* cell_layers: layers of elements of any types.
 *
 * Wedges, hexahedra and quadrilaterals have a family of parallel edges across the layer, their
 * uprights. They take part in the search of layers.c as corner simplices, one at each upright, which
 * is the shortest edge of that simplex. An element is in a layer if half of its simplices are.
 * Pyramids are in none.
 *
 * Many elements of tangled meshes are thin by chance. Badly shaped ones are in no layer, and nor are
 * the neighbours of many invalid ones. A few thin ones are no layer.
 */
#include "shape/drawn.h"
#include "shape/shape.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/layer_shape.h"
#include "topology/cells.h"
#include "topology/frame.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 4096 }; /* elements that one thread looks at at a time */

/* Layers beside which there are more invalid elements than one in so many are thin by chance. Valid slivers
 * stand at the ends of many layers. */
enum { FEW_INVALID = 20 };

/* ---- thin elements --------------------------------------------------------------------------- */

/* Edges of an element that are parallel in the ideal one make a family: those between the same two
 * vertices of one of the simplices whose product the shape is. */
enum { FAMILIES = 3 * PL_CELL_SIMPLICES };

typedef struct family {
    int n;
    double sum, least, most; /* of the squares of the edges */
} family;

typedef struct thin_search {
    const planish_mesh *mesh; /* dense coordinates, cells */
    pl_frame frame;
    pl_drawn drawn;
    uint8_t *thinness; /* [cells->n] */
    int64_t n_thin;    /* shared */
} thin_search;

static int is_simplex(const pl_cell_type *type) {
    return type->shape->n_simplices == 1;
}

/** Measure the families of an element. */
static void find_families(const thin_search *s, const pl_cell_shape *shape, const int32_t *node,
                          family families[FAMILIES]) {
    const int dim = s->mesh->dim;
    for (int e = 0; e < shape->n_edges; e++) {
        const int a = shape->edge[e][0], b = shape->edge[e][1], f = pl_factor_of(shape, a, b);
        const double *x = s->mesh->coordinates + (int64_t)node[a] * dim;
        const double *y = s->mesh->coordinates + (int64_t)node[b] * dim;
        family *own = &families[3 * f + shape->vertex[a][f] + shape->vertex[b][f] - 1];
        double square = 0;
        for (int d = 0; d < dim; d++) {
            const double way = pl_frame_difference(&s->frame, y[d], x[d]);
            square += way * way;
        }
        own->least = own->n == 0 || square < own->least ? square : own->least;
        own->most = square > own->most ? square : own->most;
        own->sum += square;
        own->n++;
    }
}

/** Find the uprights of an element, the shortest family of a line, and how short they are. left_out: bits
 *  of factors that do not count. */
static int thinness_without(const pl_cell_shape *shape, const family families[FAMILIES],
                            unsigned left_out) {
    double least = INFINITY, others = INFINITY;
    int factor = 0;
    for (int f = 0; f < shape->n_simplices; f++)
        if (shape->n_vertices[f] == 2 && !(left_out >> f & 1) &&
            families[3 * f].sum / families[3 * f].n < least) {
            least = families[3 * f].sum / families[3 * f].n;
            factor = f;
        }
    for (int k = 0; k < FAMILIES; k++)
        if (k != 3 * factor && families[k].n > 0 && !(left_out >> k / 3 & 1))
            others = fmin(others, families[k].sum / families[k].n);
    const family *uprights = &families[3 * factor];
    const int is_wide = least > 0 && others >= PL_WIDE * PL_WIDE * least;
    const int is_thin = is_wide && others >= PL_THIN * PL_THIN * uprights->most &&
                        uprights->most <= PL_ALIKE * PL_ALIKE * uprights->least;
    return PL_IS_GIVEN | factor | (is_thin ? PL_IS_THIN : 0) | (is_wide ? PL_IS_WIDE : 0);
}

/** The same; of a drawn solid in its plane, where wedges have no uprights. */
static int thinness_of(const thin_search *s, const pl_cell_shape *shape, const int32_t *node) {
    family families[FAMILIES] = {{0}};
    find_families(s, shape, node, families);
    const unsigned drawn = pl_drawn_factors(&s->drawn, s->mesh, shape, node);
    if (drawn && shape->n_simplices == 2)
        return thinness_without(shape, families, 0) & ~(PL_IS_THIN | PL_IS_WIDE);
    return thinness_without(shape, families, drawn);
}

static void find_thinness_chunk(void *context, int64_t begin, int64_t end, int thread) {
    thin_search *s = context;
    const planish_cells *cells = s->mesh->cells;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const pl_cell_type *type = pl_counted_type(s->mesh->cells, s->mesh->dim, i);
        s->thinness[i] = 0;
        if (type && type->shape->n_simplices > 1)
            s->thinness[i] = (uint8_t)thinness_of(s, type->shape, cells->node + cells->offset[i]);
        n += (s->thinness[i] & PL_IS_THIN) != 0;
    }
    __atomic_fetch_add(&s->n_thin, n, __ATOMIC_RELAXED);
}

int pl_find_thinness(const planish_mesh *mesh, int threads, uint8_t *thinness, int64_t *n_thin,
                     planish_error *error) {
    thin_search s = {.mesh = mesh, .drawn = pl_drawn_find(mesh), .thinness = thinness};
    const int status = pl_frame_create(mesh, NULL, threads, &s.frame, error);
    if (!status)
        pl_parallel_for(threads, mesh->cells->n, CHUNK, find_thinness_chunk, &s);
    *n_thin = s.n_thin;
    return status;
}

/* ---- elements of any types ------------------------------------------------------------------- */

/** Simplices that stand for the elements of a mesh. */
typedef struct corner_mesh {
    planish_mesh mesh; /* of the simplices */
    int32_t *node;     /* [mesh.n_elements][dim + 1] */
    uint8_t *given;    /* [mesh.n_elements] */
    int64_t *first;    /* [cells->n + 1] the first simplex of each element */
} corner_mesh;

/** Whether corner c of an element is one of its simplices: one at each upright. */
static int stands(const pl_cell_shape *shape, int c, int thinness) {
    return shape->n_simplices == 0 || shape->vertex[c][thinness & PL_SHORTEST_EDGE] == 0;
}

static int64_t count_corners(const pl_cell_shape *shape, int thinness) {
    int64_t n = 0;
    for (int c = 0; c < shape->n_measured; c++)
        n += stands(shape, c, thinness);
    return n;
}

/** Count the simplices of each element: a simplex itself, and if others are thin the corners of those
 *  that are wide or have a node of a thin one. is_near [n_nodes] is zero. */
static int64_t count_simplices(const planish_mesh *mesh, const uint8_t *thinness, uint8_t *is_near,
                               int64_t *first) {
    const planish_cells *cells = mesh->cells;
    int64_t n = 0;
    int wide = 0; /* PL_IS_WIDE if there are thin ones */
    for (int64_t i = 0; i < cells->n; i++)
        for (int c = 0; thinness[i] & PL_IS_THIN &&
                        c < pl_counted_type(mesh->cells, mesh->dim, i)->shape->n_corners;
             c++) {
            is_near[cells->node[cells->offset[i] + c]] = 1;
            wide = PL_IS_WIDE;
        }
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_counted_type(mesh->cells, mesh->dim, i);
        int is_needed = type && (is_simplex(type) || thinness[i] & wide);
        for (int c = 0; type && !is_needed && c < type->shape->n_corners; c++)
            is_needed = is_near[cells->node[cells->offset[i] + c]];
        first[i] = n;
        n += !is_needed ? 0 : is_simplex(type) ? 1 : count_corners(type->shape, thinness[i]);
    }
    return first[cells->n] = n;
}

/** Return what is given of corner c of an element: its upright is its shortest edge. */
static int given_at(const pl_cell_shape *shape, int c, int thinness) {
    static const int numbers[3] = {0, 1, 3}; /* of the edges from the corner */
    int j = 0;
    if (!(thinness & PL_IS_WIDE))
        return PL_IS_GIVEN;
    while (j < 2 && pl_factor_of(shape, c, shape->neighbour[c][j]) != (thinness & PL_SHORTEST_EDGE))
        j++;
    return (thinness & ~PL_SHORTEST_EDGE) | numbers[j];
}

/** Fill in the simplices of an element. */
static void add_simplices(const planish_mesh *mesh, int thinness, int64_t cell, corner_mesh *m) {
    const pl_cell_shape *shape = pl_counted_type(mesh->cells, mesh->dim, cell)->shape;
    const int32_t *node = mesh->cells->node + mesh->cells->offset[cell];
    const int k = mesh->dim + 1;
    int64_t at = m->first[cell];
    for (int j = 0; shape->n_simplices == 1 && j < k; j++) {
        m->node[at * k + j] = node[j];
        m->given[at] = 0;
    }
    for (int c = 0; shape->n_simplices != 1 && c < shape->n_measured; c++) {
        if (!stands(shape, c, thinness))
            continue;
        m->node[at * k] = node[c];
        for (int j = 1; j < k; j++)
            m->node[at * k + j] = node[shape->neighbour[c][j - 1]];
        m->given[at++] = (uint8_t)given_at(shape, c, thinness);
    }
}

static int make_simplices(const planish_mesh *mesh, const uint8_t *thinness, corner_mesh *m,
                          planish_error *error) {
    const int64_t n_cells = mesh->cells->n;
    uint8_t *is_near = pl_alloc_zero(mesh->n_nodes, 1);
    m->first = pl_alloc(n_cells + 1, sizeof *m->first);
    if (!is_near || !m->first) {
        pl_free(is_near);
        return pl_fail_memory(error, "thin elements");
    }
    const int64_t n = count_simplices(mesh, thinness, is_near, m->first);
    pl_free(is_near);
    if (n > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_MESH, "the mesh is too large to find its layers");
    m->node = pl_alloc(n * (mesh->dim + 1), sizeof *m->node);
    m->given = pl_alloc(n, 1);
    if (!m->node || !m->given)
        return pl_fail_memory(error, "thin elements");
    for (int64_t i = 0; i < n_cells; i++)
        if (m->first[i] < m->first[i + 1])
            add_simplices(mesh, thinness[i], i, m);
    m->mesh = *mesh;
    m->mesh.cells = NULL;
    m->mesh.elements = m->node;
    m->mesh.n_elements = n;
    return PLANISH_OK;
}

/* Layers of elements with uprights: sets of elements that nodes join. */
typedef struct layer_sets {
    int32_t *parent; /* [n_nodes] a node of the same layer; itself: it stands for the layer */
    int32_t *n;      /* [n_nodes] elements of the layer, */
    int32_t *n_bad;  /* [n_nodes] and invalid ones beside it: they have a node of it */
} layer_sets;

/** Return what stands for the layer of a node; -1: it is in none. */
static int32_t layer_of(const layer_sets *s, int32_t node) {
    while (s->parent[node] >= 0 && s->parent[node] != node) {
        const int32_t next = s->parent[s->parent[node]]; /* half of the way from now on */
        s->parent[node] = next;
        node = next;
    }
    return s->parent[node];
}

static void join_nodes(layer_sets *s, const int32_t *node, int n) {
    for (int c = 0; c < n; c++) {
        if (s->parent[node[c]] < 0)
            s->parent[node[c]] = node[c];
        s->parent[layer_of(s, node[c])] = layer_of(s, node[0]);
    }
}

/** Count an invalid element in the layers around. */
static void count_bad(layer_sets *s, const int32_t *node, int n) {
    int32_t layer[PL_CELL_CORNERS];
    for (int c = 0; c < n; c++) {
        int is_new = (layer[c] = layer_of(s, node[c])) >= 0;
        for (int k = 0; k < c; k++)
            is_new &= layer[k] != layer[c];
        if (is_new)
            s->n_bad[layer[c]]++;
    }
}

/** Remove the marks of layers with too few elements, or beside too many invalid ones. */
static void drop_bad_layers(const planish_mesh *mesh, const uint8_t *thinness, layer_sets *s,
                            uint8_t *mark) {
    const planish_cells *cells = mesh->cells;
    for (int64_t i = 0; i < cells->n; i++)
        if (mark[i] && thinness[i])
            join_nodes(s, cells->node + cells->offset[i],
                       pl_counted_type(mesh->cells, mesh->dim, i)->shape->n_corners);
    for (int64_t i = 0; i < cells->n; i++)
        if (thinness[i] & PL_IS_INVALID && !mark[i])
            count_bad(s, cells->node + cells->offset[i],
                      pl_counted_type(mesh->cells, mesh->dim, i)->shape->n_corners);
        else if (mark[i] == PL_ROW_MARKED && thinness[i])
            s->n[layer_of(s, cells->node[cells->offset[i]])]++;
    for (int64_t i = 0; i < cells->n; i++)
        if (mark[i] && thinness[i]) {
            const int32_t layer = layer_of(s, cells->node[cells->offset[i]]);
            if (s->n[layer] < PL_LEAST_OF_LAYER ||
                (int64_t)FEW_INVALID * s->n_bad[layer] > s->n[layer])
                mark[i] = 0;
        }
}

/** Remove the marks of elements that are thin by chance. */
static int drop_chance(const planish_mesh *mesh, const uint8_t *thinness, uint8_t *mark,
                       planish_error *error) {
    const int64_t n = mesh->n_nodes;
    layer_sets s = {.parent = pl_alloc(n, sizeof *s.parent),
                    .n = pl_alloc_zero(n, sizeof *s.n),
                    .n_bad = pl_alloc_zero(n, sizeof *s.n_bad)};
    const int is_there = s.parent && s.n && s.n_bad;
    if (is_there) {
        memset(s.parent, -1, (size_t)n * sizeof *s.parent);
        drop_bad_layers(mesh, thinness, &s, mark);
    }
    pl_free(s.parent);
    pl_free(s.n);
    pl_free(s.n_bad);
    return is_there ? PLANISH_OK : pl_fail_memory(error, "thin elements");
}

/** Mark the elements of which at least half of the simplices are in layers. */
static int mark_cells(const planish_mesh *mesh, const uint8_t *thinness, int threads, uint8_t *mark,
                      planish_error *error) {
    corner_mesh m = {.node = NULL};
    int64_t n_simplices;
    int status = make_simplices(mesh, thinness, &m, error);
    uint8_t *is_in = pl_alloc(status ? -1 : m.mesh.n_elements, 1);
    if (!status)
        status = is_in ? pl_find_layers(&m.mesh, m.given, threads, is_in, &n_simplices, error)
                       : pl_fail_memory(error, "thin elements");
    for (int64_t i = 0; !status && i < mesh->cells->n; i++) {
        int64_t n_in = 0;
        for (int64_t k = m.first[i]; k < m.first[i + 1]; k++)
            n_in += is_in[k];
        mark[i] = n_in > 0 && 2 * n_in >= m.first[i + 1] - m.first[i];
    }
    pl_free(is_in);
    pl_free(m.node);
    pl_free(m.given);
    pl_free(m.first);
    return status;
}

int pl_find_layers_of_cells(const planish_mesh *mesh, const uint8_t *thinness, int threads,
                            uint8_t *is_layer, int64_t *n_layer, planish_error *error) {
    const int64_t n = mesh->cells->n;
    uint8_t *mark = pl_alloc(n, 1), *of_well_shaped = pl_alloc(n, 1);
    int status = mark && of_well_shaped ? PLANISH_OK : pl_fail_memory(error, "thin elements");
    for (int64_t i = 0; !status && i < n; i++)
        of_well_shaped[i] = thinness[i] & PL_BADLY_SHAPED ? PL_BADLY_SHAPED : thinness[i];
    if (!status)
        status = mark_cells(mesh, of_well_shaped, threads, mark, error);
    if (!status && memchr(mark, 1, (size_t)n)) {
        status = pl_follow_cell_rows(mesh, thinness, mark, error);
        if (!status)
            status = drop_chance(mesh, thinness, mark, error);
    }
    *n_layer = 0;
    for (int64_t i = 0; !status && i < n; i++)
        *n_layer += is_layer[i] = mark[i] == PL_ROW_MARKED;
    pl_free(mark);
    pl_free(of_well_shaped);
    return status;
}
