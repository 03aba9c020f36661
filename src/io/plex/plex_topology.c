/* plex_topology: points of a DMPlex and their cones; its elements by their nodes. */
#ifdef PL_HDF5
#include "io/plex/plex_reader.h"
#include "io/core/elements.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

enum { MOST_IN_CONE = 48, CHUNK = 1 << 14 };

/* ---- points and their cones ---------------------------------------------------------------- */

static int make_points(plex_reader *r, int64_t n) {
    if (n > INT32_MAX)
        return io_hdf5_fail(r->file, r->topology.text,
                            "%lld points (elements, nodes, faces, edges) are more than the %d that "
                            "planish can handle",
                            (long long)n, INT32_MAX);
    r->n_points = n;
    r->start = pl_alloc(n, sizeof *r->start);
    r->size = pl_alloc_zero(n, sizeof *r->size);
    r->of_point = pl_alloc(n, sizeof *r->of_point);
    if (!r->start || !r->size || !r->of_point)
        return pl_fail_memory(r->error, "the points of the file");
    for (int64_t i = 0; i < n; i++)
        r->start[i] = r->of_point[i] = -1;
    return PLANISH_OK;
}

/** Give the points of a stratum their cones; order: the points in the order of these cones, or
 *  NULL: as they are numbered. path: of the stratum, for messages. */
static int take_cones(plex_reader *r, const char *path, const plex_stratum *s,
                      const io_hdf5_integers *order) {
    int64_t begin = 0;
    for (int64_t i = 0; i < s->n; i++) {
        const int64_t point = order ? io_hdf5_integer(order, i) : s->first + i;
        const int64_t size = io_hdf5_integer(&s->sizes, i);
        if (point < 0 || point >= r->n_points || r->start[point] >= 0)
            return io_hdf5_fail(r->file, path,
                                "point %lld (at place %lld) is not in 0 .. %lld, or is there twice",
                                (long long)point, (long long)i, (long long)r->n_points - 1);
        if (size < 0 || size > MOST_IN_CONE)
            return io_hdf5_fail(r->file, path,
                                "point %lld is bounded by %lld others; no element has so many",
                                (long long)point, (long long)size);
        if (size > s->cones.n - begin)
            return io_hdf5_fail(r->file, path, "there are only %lld points that bound others",
                                (long long)s->cones.n);
        r->start[point] = begin;
        r->size[point] = (uint8_t)size;
        begin += size;
    }
    if (begin != s->cones.n || s->orientations.n != s->cones.n)
        return io_hdf5_fail(r->file, path,
                            "points are bounded by %lld others in all; there are %lld, and %lld "
                            "orientations",
                            (long long)begin, (long long)s->cones.n, (long long)s->orientations.n);
    return PLANISH_OK;
}

/** Return the k-th point of the cone, and how it is gone round; -1: there is no such point. */
static int64_t in_cone(const plex_reader *r, int64_t point, int k, int64_t *orientation) {
    const plex_stratum *s = r->stratum;
    while (point < s->first || point >= s->first + s->n)
        s++;
    const int64_t below = io_hdf5_integer(&s->cones, r->start[point] + k);
    if (orientation)
        *orientation = io_hdf5_integer(&s->orientations, r->start[point] + k);
    return below >= 0 && below < r->n_points - s->below ? s->below + below : -1;
}

/** Place the strata among the points, in the order that the file gives. *n: points. */
static int place_strata(plex_reader *r, const io_hdf5_integers *order, int64_t *n) {
    unsigned placed = 0;
    *n = 0;
    for (int64_t i = 0; i < order->n; i++) {
        const int64_t depth = io_hdf5_integer(order, i);
        if (depth < 0 || depth >= order->n || (placed >> depth & 1))
            return io_hdf5_fail(r->file, r->topology.text, "permutation is none of the strata");
        placed |= 1u << depth;
        r->stratum[depth].first = *n;
        *n += r->stratum[depth].n;
    }
    return PLANISH_OK;
}

/** Read the points and their cones: of versions 1 and 2 in one list, which need not be in the order
 *  of their numbers; of version 3 one dimension after another, in the order that permutation
 *  gives. list: either. */
static int read_cones(plex_reader *r, io_hdf5_integers *list) {
    static const char *const names[2][4] = {{"order", "cones", "cells", "orientation"},
                                            {"permutation", "cone_sizes", "cones", "orientations"}};
    const int has_strata = r->version == 3;
    const char *const *name = names[has_strata];
    io_hdf5_path group[PLEX_MOST_STRATA];
    int status = plex_read_integers(r, r->topology.text, name[0], list);
    if (status)
        return status;
    if (has_strata && (list->n < 2 || list->n > PLEX_MOST_STRATA))
        return io_hdf5_fail(r->file, r->topology.text,
                            "%lld strata of points; 2 to %d were expected", (long long)list->n,
                            PLEX_MOST_STRATA);
    const int n_strata = has_strata ? (int)list->n : 1;
    for (int d = 0; d < n_strata; d++) {
        plex_stratum *s = &r->stratum[d];
        group[d] = has_strata ? io_hdf5_path_of(r->file, "%s/strata/%d", r->topology.text, d)
                              : r->topology;
        status = plex_read_integers(r, group[d].text, name[1], &s->sizes);
        const int has_cones = !has_strata || d > 0;
        if (!status && has_cones)
            status = plex_read_integers(r, group[d].text, name[2], &s->cones);
        if (!status && has_cones)
            status = plex_read_integers(r, group[d].text, name[3], &s->orientations);
        if (status)
            return status;
        s->n = s->sizes.n;
    }
    if (!has_strata && r->stratum[0].n != list->n)
        return io_hdf5_fail(r->file, r->topology.text, "%lld points, and the sizes of %lld cones",
                            (long long)list->n, (long long)r->stratum[0].n);
    int64_t n = list->n;
    if (has_strata)
        status = place_strata(r, list, &n);
    if (!status)
        status = make_points(r, n);
    for (int d = 0; d < n_strata && !status; d++) {
        r->stratum[d].below = d > 0 ? r->stratum[d - 1].first : 0;
        status = take_cones(r, group[d].text, &r->stratum[d], has_strata ? NULL : list);
    }
    return status;
}

/** Find elements, which are the first points, and nodes, which follow. */
static int find_kinds(plex_reader *r) {
    int64_t first = 0, last;
    while (first < r->n_points && r->size[first] > 0)
        first++;
    for (last = first; last < r->n_points && r->size[last] == 0;)
        last++;
    r->n_elements = first;
    r->n_nodes = last - first;
    for (int64_t i = last; i < r->n_points; i++)
        if (r->size[i] == 0)
            return io_hdf5_fail(r->file, r->topology.text,
                                "nodes are not numbered one after another behind the elements");
    if (r->n_elements == 0 || r->n_nodes == 0)
        return io_hdf5_fail(r->file, r->topology.text, "there are no elements, or no nodes");
    /* Whether all that bounds the first element is among the elements. */
    int is_bounded_by_elements = 1;
    for (int k = 0; k < r->size[0]; k++) {
        const int64_t below = in_cone(r, 0, k, NULL);
        is_bounded_by_elements &= below >= 0 && below < r->n_elements;
    }
    if (is_bounded_by_elements)
        return io_hdf5_fail(r->file, r->topology.text,
                            "faces or edges are numbered between elements and nodes; elements are "
                            "expected first, then nodes");
    return PLANISH_OK;
}

int plex_read_topology(plex_reader *r) {
    io_hdf5_integers list = {0};
    const int status = read_cones(r, &list);
    io_hdf5_integers_release(&list);
    for (int d = 0; d < PLEX_MOST_STRATA; d++)
        io_hdf5_integers_release(&r->stratum[d].sizes);
    return status ? status : find_kinds(r);
}

void plex_release_topology(plex_reader *r) {
    for (int d = 0; d < PLEX_MOST_STRATA; d++) {
        io_hdf5_integers_release(&r->stratum[d].cones);
        io_hdf5_integers_release(&r->stratum[d].orientations);
    }
    pl_free(r->start);
    pl_free(r->size);
    pl_free(r->of_point);
    pl_free(r->triangle);
}

/* ---- nodes of points ------------------------------------------------------------------------ */

static int is_node(const plex_reader *r, int64_t point) {
    return point >= r->n_elements && point < r->n_elements + r->n_nodes;
}

int plex_dim_of(const plex_reader *r, int64_t point) {
    return point < r->n_elements ? r->dim : is_node(r, point) ? 0 : r->size[point] == 2 ? 1 : 2;
}

int plex_list_of(const plex_reader *r, int64_t point) {
    const int dim = plex_dim_of(r, point);
    return dim < 2 || r->size[point] == dim + 1 ? dim : io_others_list(dim);
}

/** Nodes as they are met, each once. */
typedef struct node_list {
    int32_t *node; /* [PLEX_MOST_NODES] */
    int n;
    int is_broken;
} node_list;

static void add_node(const plex_reader *r, int64_t point, node_list *to) {
    const int32_t node = (int32_t)(point - r->n_elements);
    to->is_broken |= !is_node(r, point);
    for (int i = 0; i < to->n; i++)
        if (to->node[i] == node)
            return;
    if (to->n < PLEX_MOST_NODES && !to->is_broken)
        to->node[to->n++] = node;
    else
        to->is_broken = 1;
}

/** Add the nodes of a cone of nodes, in its order or the other one. */
static void add_cone(const plex_reader *r, int64_t point, int is_reversed, node_list *to) {
    const int size = r->size[point];
    for (int k = 0; k < size; k++)
        add_node(r, in_cone(r, point, is_reversed ? size - 1 - k : k, NULL), to);
}

/** Return whether a point with so many in its cone can be gone round like that. */
static int is_orientation(int64_t o, int size) {
    return o >= -size && o < size;
}

/** Add the nodes of a cone of edges. */
static void add_face(const plex_reader *r, int64_t face, node_list *to) {
    for (int k = 0; k < r->size[face]; k++) {
        int64_t o;
        const int64_t edge = in_cone(r, face, k, &o);
        if (edge < 0 || plex_dim_of(r, edge) != 1)
            to->is_broken = 1;
        else
            add_cone(r, edge, o < 0, to);
    }
}

/** Add the nodes of a cone of faces, in the order of simplices; elements of other faces than
 *  triangles are none. */
static void add_faces(const plex_reader *r, int64_t element, node_list *to) {
    for (int k = 0; k < r->size[element] && !to->is_broken; k++) {
        int64_t o;
        const int64_t face = in_cone(r, element, k, &o);
        to->is_broken =
            face < r->n_elements || plex_dim_of(r, face) != 2 || !is_orientation(o, r->size[face]);
        if (to->is_broken)
            return;
        if (r->size[face] != 3) {
            add_face(r, face, to);
            continue;
        }
        /* Edge k of a triangle leads from node k on. A cone goes from edge o on; backwards where o
         * is negative, which -1 does from edge 1 on. */
        const int32_t *node = r->triangle + 3 * (face - r->first_face);
        const int first = (int)(o < 0 ? (1 - o % 3) % 3 : o % 3);
        to->is_broken = node[0] < 0;
        for (int j = 0; j < 3 && !to->is_broken; j++)
            add_node(r, r->n_elements + node[(first + (o < 0 ? 3 - j : j)) % 3], to);
    }
}

int plex_nodes_of(const plex_reader *r, int64_t point, int32_t *node) {
    node_list to = {.node = node};
    const int dim = plex_dim_of(r, point);
    if (dim == 0)
        add_node(r, point, &to);
    else if (dim == 1 || is_node(r, in_cone(r, point, 0, NULL)))
        add_cone(r, point, 0, &to);
    else if (dim == 2)
        add_face(r, point, &to);
    else
        add_faces(r, point, &to);
    return to.is_broken ? -1 : to.n;
}

int plex_has_simplices_alone(const plex_reader *r) {
    for (int64_t i = 0; i < r->n_elements; i++)
        if (r->size[i] != r->dim + 1)
            return 0;
    /* Points are bounded by points of the next lower dimension; elements by these or by nodes. */
    for (int64_t i = 0; i < r->n_points; i++) {
        const int by_nodes = i < r->n_elements && is_node(r, in_cone(r, i, 0, NULL));
        const int wanted = by_nodes ? 0 : plex_dim_of(r, i) - 1;
        for (int k = 0; k < r->size[i]; k++) {
            int64_t orientation;
            const int64_t below = in_cone(r, i, k, &orientation);
            if (below < r->n_elements || plex_dim_of(r, below) != wanted ||
                (wanted > 0 && !is_orientation(orientation, r->size[below])))
                return 0;
        }
    }
    return 1;
}

int plex_fail_point(plex_reader *r, int64_t point) {
    return io_hdf5_fail(r->file, r->topology.text,
                        "point %lld is bounded by points of the wrong kind", (long long)point);
}

/* ---- elements that are no simplices ---------------------------------------------------------- */

/** Nodes of a triangle or quadrilateral, in the order round it. */
typedef struct ring {
    int32_t node[4];
    int n;
} ring;

/** Find the ring of a face that is bounded by edges, in the sense of its first edge; n = 0: it has
 *  none. The other edges may stand in any order, as in the faces of extruded meshes. */
static ring ring_of(const plex_reader *r, int64_t face) {
    ring to = {.n = r->size[face]};
    int32_t ends[4][2] = {{0}};
    if (to.n < 3 || to.n > 4)
        return (ring){.n = 0};
    for (int k = 0; k < to.n; k++) {
        int64_t o;
        const int64_t edge = in_cone(r, face, k, &o);
        if (edge < r->n_elements || plex_dim_of(r, edge) != 1)
            return (ring){.n = 0};
        for (int j = 0; j < 2; j++)
            ends[k][j] = (int32_t)(in_cone(r, edge, o < 0 ? 1 - j : j, NULL) - r->n_elements);
    }
    memcpy(to.node, ends[0], sizeof ends[0]);
    ends[0][0] = ends[0][1] = -1;
    for (int i = 2; i <= to.n; i++) { /* the last edge leads to the first node */
        int next = -1;
        for (int k = 1; k < to.n && next < 0; k++)
            for (int j = 0; j < 2 && next < 0; j++)
                if (ends[k][j] == to.node[i - 1]) {
                    next = ends[k][1 - j];
                    ends[k][0] = ends[k][1] = -1;
                }
        if (next < 0 || (i == to.n && next != to.node[0]))
            return (ring){.n = 0};
        if (i < to.n)
            to.node[i] = next;
    }
    return to;
}

static int is_in(const ring *of, int32_t node) {
    for (int i = 0; i < of->n; i++)
        if (of->node[i] == node)
            return 1;
    return 0;
}

/** Find the node that an edge from node leads to, away from the base; -1: there is none. */
static int32_t node_above(const ring *rings, int n, const ring *base, int32_t node) {
    for (const ring *f = rings; f < rings + n; f++)
        for (int i = 0; i < f->n && f != base; i++)
            for (int side = 1; side < f->n && f->node[i] == node; side += f->n - 2) {
                const int32_t other = f->node[(i + side) % f->n];
                if (!is_in(base, other))
                    return other;
            }
    return -1;
}

/** Find the nodes of a solid element that is bounded by faces, in VTK's order. Cones of faces go
 *  round them with the normal outwards, so that the base is gone round the other way. Of extruded
 *  elements ("tensor prisms") the first face has its normal inwards, and the sides have their
 *  edges in another order: the base is the second face, the last triangle. Returns the type, 0: none that is measured. */
static int find_solid(const plex_reader *r, int64_t element, int32_t *node) {
    ring rings[6];
    const int n = r->size[element];
    int n_triangles = 0, of_triangle = 0, of_quadrilateral = 0;
    if (n < 5 || n > 6)
        return 0;
    for (int k = 0; k < n; k++) {
        int64_t o;
        const int64_t face = in_cone(r, element, k, &o);
        if (face < r->n_elements || plex_dim_of(r, face) != 2)
            return 0;
        rings[k] = ring_of(r, face);
        if (rings[k].n == 0)
            return 0;
        if (o < 0) {
            const int32_t second = rings[k].node[1];
            rings[k].node[1] = rings[k].node[rings[k].n - 1];
            rings[k].node[rings[k].n - 1] = second;
        }
        n_triangles += rings[k].n == 3;
        *(rings[k].n == 3 ? &of_triangle : &of_quadrilateral) = k;
    }
    const int shape = n == 6 && n_triangles == 0   ? IO_HEXAHEDRON
                      : n == 5 && n_triangles == 2 ? IO_PRISM
                      : n == 5 && n_triangles == 4 ? IO_PYRAMID
                                                   : IO_NO_SHAPE;
    if (shape == IO_NO_SHAPE)
        return 0;
    const ring *base = &rings[shape == IO_HEXAHEDRON ? 1
                              : shape == IO_PRISM    ? of_triangle
                                                     : of_quadrilateral];
    int n_nodes = base->n;
    for (int i = 0; i < base->n; i++)
        node[i] = base->node[i == 0 ? 0 : base->n - i];
    for (int i = 0; i < (shape == IO_PYRAMID ? 1 : base->n); i++) {
        node[n_nodes] = node_above(rings, n, base, node[i]);
        if (node[n_nodes++] < 0)
            return 0;
    }
    for (int i = 0; i < n_nodes; i++)
        for (int j = 0; j < i; j++)
            if (node[i] == node[j])
                return 0;
    return io_cell_type(shape, n_nodes);
}

/** Find the nodes of an element that is bounded by nodes, in VTK's order: hexahedra, prisms and
 *  pyramids turn the other way round, and PETSc's order of the top of a hexahedron or prism starts
 *  over the same node as the base and goes round in the other sense. Returns the type, or 0. */
static int find_flat(const plex_reader *r, int64_t element, int32_t *node) {
    static const uint8_t orders[][8] = {
        [5] = {0, 3, 2, 1, 4}, [6] = {0, 2, 1, 3, 4, 5}, [8] = {0, 3, 2, 1, 4, 5, 6, 7}};
    const int n = r->size[element];
    const int shape = r->dim == 2 && n == 4   ? IO_QUADRILATERAL
                      : r->dim == 3 && n == 5 ? IO_PYRAMID
                      : r->dim == 3 && n == 6 ? IO_PRISM
                      : r->dim == 3 && n == 8 ? IO_HEXAHEDRON
                                              : IO_NO_SHAPE;
    for (int i = 0; i < n && shape != IO_NO_SHAPE; i++)
        node[i] = (int32_t)(in_cone(r, element, n > 4 ? orders[n][i] : i, NULL) - r->n_elements);
    return io_cell_type(shape, n);
}

/** Add an element or face to the others of its dimension. */
static int add_other(plex_reader *r, int64_t point, int type, const int32_t *node) {
    const int dim = plex_dim_of(r, point);
    const int status = io_model_add_other(r->model, type, node, 0, point, r->error);
    if (!status)
        r->of_point[point] = (int32_t)io_model_others(r->model, dim)->n - 1;
    return status;
}

/** Add the elements that are no simplices; those that nothing stands for hold their nodes. */
static int add_others(plex_reader *r) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_elements && r->model->n_other > 0 && !status; i++) {
        int32_t node[PLEX_MOST_NODES];
        int type = 0;
        if (r->of_point[i] >= 0)
            continue;
        if (is_node(r, in_cone(r, i, 0, NULL))) {
            type = find_flat(r, i, node);
        } else if (r->dim == 3) {
            type = find_solid(r, i, node);
        } else {
            const ring of = ring_of(r, i);
            memcpy(node, of.node, sizeof of.node);
            type = of.n == 4 ? PLANISH_CELL_QUADRILATERAL : 0;
        }
        if (type)
            status = add_other(r, i, type, node);
        const int n = type ? 0 : plex_nodes_of(r, i, node);
        for (int k = 0; k < n; k++)
            io_hold_node(r->model, node[k], IO_HELD_BY_OTHER);
    }
    return status;
}

/* ---- cells of the model --------------------------------------------------------------------- */

int plex_add_cell(plex_reader *r, int64_t point) {
    int32_t node[PLEX_MOST_NODES];
    const int dim = plex_dim_of(r, point);
    io_cells *cells = io_model_cells(r->model, dim);
    if (r->of_point[point] >= 0)
        return PLANISH_OK;
    const int n = plex_nodes_of(r, point, node);
    if (n < 0)
        return plex_fail_point(r, point);
    if (n != dim + 1) {
        const ring of = ring_of(r, point);
        if (of.n == 4) {
            r->model->n_other++;
            return add_other(r, point, PLANISH_CELL_QUADRILATERAL, of.node);
        }
        r->model->n_lower++; /* a polygon; its nodes may be of a group */
        return PLANISH_OK;
    }
    memcpy(cells->nodes + cells->n * n, node, (size_t)n * sizeof *node);
    r->of_point[point] = (int32_t)cells->n++;
    return PLANISH_OK;
}

/** Elements that are put into their cells by threads, whose places are known. */
typedef struct filling {
    plex_reader *r;
    int64_t first_wrong; /* element, or INT64_MAX */
} filling;

static void fill_chunk(void *context, int64_t begin, int64_t end, int thread) {
    filling *f = context;
    plex_reader *r = f->r;
    io_cells *cells = io_model_cells(r->model, r->dim);
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int32_t node[PLEX_MOST_NODES];
        const int n = plex_nodes_of(r, i, node);
        const int is_simplex = r->of_point[i] >= 0;
        if (n < 0 || (is_simplex && n != r->dim + 1)) {
            pl_lower_to(&f->first_wrong, i);
            return;
        }
        if (is_simplex)
            memcpy(cells->nodes + r->of_point[i] * n, node, (size_t)n * sizeof *node);
    }
}

/** Find the nodes of triangles, once: most are of two elements. */
static void find_triangle_chunk(void *context, int64_t begin, int64_t end, int thread) {
    plex_reader *r = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int32_t node[PLEX_MOST_NODES];
        const int64_t face = r->first_face + i;
        const int n = r->size[face] == 3 ? plex_nodes_of(r, face, node) : 0;
        for (int k = 0; k < 3; k++)
            r->triangle[3 * i + k] = n == 3 ? node[k] : -1;
    }
}

int plex_read_elements(plex_reader *r) {
    filling f = {.r = r, .first_wrong = INT64_MAX};
    int64_t n = 0, first = r->n_points, behind = 0;
    /* An element that is bounded by dim + 1 points is a simplex, with and without faces. */
    for (int64_t i = 0; i < r->n_elements; i++)
        if (r->size[i] == r->dim + 1)
            r->of_point[i] = (int32_t)n++;
    io_cells *cells = io_model_cells(r->model, r->dim);
    r->model->n_other = r->n_elements - n;
    const int status = io_cells_reserve(r->model, r->dim, n, 1, r->model->n_other > 0, r->error);
    if (status)
        return status;
    for (int64_t i = 0; i < r->n_elements && cells->number; i++)
        if (r->of_point[i] >= 0)
            cells->number[r->of_point[i]] = i;
    cells->n = n;
    for (int64_t i = r->n_elements + r->n_nodes; r->dim == 3 && i < r->n_points; i++)
        if (r->size[i] > 2) {
            first = i < first ? i : first;
            behind = i + 1;
        }
    const int64_t n_faces = behind > first ? behind - first : 0;
    r->first_face = first;
    r->triangle = pl_alloc(3 * n_faces, sizeof *r->triangle);
    if (!r->triangle)
        return pl_fail_memory(r->error, "the faces of the file");
    pl_parallel_for(io_model_threads(r->model), n_faces, CHUNK, find_triangle_chunk, r);
    pl_parallel_for(io_model_threads(r->model), r->n_elements, CHUNK, fill_chunk, &f);
    return f.first_wrong < INT64_MAX ? plex_fail_point(r, f.first_wrong) : add_others(r);
}

#endif
