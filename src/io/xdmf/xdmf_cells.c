/* xdmf_cells: the elements of an XDMF file, which are VTK's, and its sets.
 *
 * A set is a group of nodes: those that it lists, or those of the cells or faces in it.
 */
#include "io/xdmf/xdmf.h"
#include "io/xdmf/xdmf_tags.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/memberships.h"

#include <string.h>
#include <strings.h>

/* ---- types of elements ---------------------------------------------------------------------- */

enum { QUADRILATERAL = 9, EDGE3 = 21, OTHER_TYPE = VTK_LAST_TYPE, MOST_SETS = 16384 };
/* Nodes of sets: for each number that these list, and so many times all nodes of all cells. */
enum { PER_NUMBER = 32, TIMES = 16 };

/** Types of elements. code: in a Mixed topology; nodes 0: each element says how many there, and
 *  NodesPerElement elsewhere; vtk: VTK's type. */
typedef struct xdmf_type {
    const char *name, *short_name;
    int code, nodes, vtk;
} xdmf_type;

static const xdmf_type types[] = {{"Polyvertex", "Vertex", 1, 0, VTK_POLY_VERTEX},
                                  {"Polyline", "Line", 2, 0, VTK_POLY_LINE},
                                  {"Polygon", "Polygon", 3, 0, VTK_POLYGON},
                                  {"Triangle", "Tri", 4, 3, VTK_TRIANGLE},
                                  {"Quadrilateral", "Quad", 5, 4, QUADRILATERAL},
                                  {"Tetrahedron", "Tet", 6, 4, VTK_TETRAHEDRON},
                                  {"Pyramid", "Pyra", 7, 5, 14},
                                  {"Wedge", "Prism", 8, 6, 13},
                                  {"Hexahedron", "Hex", 9, 8, 12},
                                  {"Polyhedron", "Polyhedron", 16, 0, VTK_POLYHEDRON},
                                  {"Edge_3", "Line_3", 34, 3, EDGE3},
                                  {"Quadrilateral_9", "Quad_9", 35, 9, 28},
                                  {"Triangle_6", "Tri_6", 36, 6, 22},
                                  {"Quadrilateral_8", "Quad_8", 37, 8, 23},
                                  {"Tetrahedron_10", "Tet_10", 38, 10, 24},
                                  {"Pyramid_13", "Pyra_13", 39, 13, 27},
                                  {"Wedge_15", "Prism_15", 40, 15, 26},
                                  {"Wedge_18", "Prism_18", 41, 18, 32},
                                  {"Hexahedron_20", "Hex_20", 48, 20, 25},
                                  {"Hexahedron_24", "Hex_24", 49, 24, OTHER_TYPE},
                                  {"Hexahedron_27", "Hex_27", 50, 27, 29},
                                  {"Hexahedron_64", "Hex_64", 51, 64, OTHER_TYPE},
                                  {"Hexahedron_125", "Hex_125", 52, 125, OTHER_TYPE},
                                  {"Mixed", "Mixed", 0, 0, 0}};
enum { N_TYPES = sizeof types / sizeof *types };

static const xdmf_type *find_code(int32_t code) {
    for (int i = 0; i < N_TYPES; i++)
        if (types[i].code == code && code > 0)
            return &types[i];
    return NULL;
}

/** Return VTK's type of an element that says how many nodes it has: few make a simpler one. */
static int vtk_type_of(const xdmf_type *type, int64_t n) {
    if (type->code == 1)
        return n == 1 ? VTK_VERTEX : VTK_POLY_VERTEX;
    if (type->code == 2)
        return n == 2 ? VTK_LINE : VTK_POLY_LINE;
    if (type->code == 3)
        return n == 3 ? VTK_TRIANGLE : n == 4 ? QUADRILATERAL : VTK_POLYGON;
    return type->vtk;
}

/* ---- topologies ----------------------------------------------------------------------------- */

/** Topology of a piece. */
typedef struct xdmf_topology {
    const xdmf_type *type;
    int64_t nodes;    /* of each element; 0: of Mixed */
    int64_t n;        /* elements; of Mixed as the file says, or -1 */
    int64_t n_values; /* numbers of its list */
    int64_t base;     /* the number of the first node */
} xdmf_topology;

/** Find a whole number that an element has; -1: it has no such attribute. */
static int take_whole(xdmf_reader *r, int64_t element, const char *name, int64_t *value) {
    const char *text = xdmf_attribute(&r->document, element, name);
    const char *end = text ? text + strlen(text) : NULL;
    io_cursor cursor = {text, end};
    *value = -1;
    if (!text)
        return PLANISH_OK;
    if (io_integer(&cursor, value) || *value < 0)
        return xdmf_fail(&r->document, element, "%s is not a whole number", name);
    io_skip_space(&cursor);
    return cursor.at == end ? PLANISH_OK
                            : xdmf_fail(&r->document, element,
                                        "%s has several numbers, as of a "
                                        "structured grid",
                                        name);
}

static int find_type(xdmf_reader *r, int64_t element, const xdmf_type **type) {
    const xdmf_document *d = &r->document;
    const char *name = xdmf_attribute(d, element, "TopologyType");
    name = name ? name : xdmf_attribute(d, element, "Type");
    for (int i = 0; i < N_TYPES && name; i++)
        if (strcasecmp(name, types[i].name) == 0 || strcasecmp(name, types[i].short_name) == 0) {
            *type = &types[i];
            return PLANISH_OK;
        }
    if (!name)
        return xdmf_fail(d, element, "there is no TopologyType");
    return xdmf_fail(d, element,
                     strstr(name, "Mesh") || strstr(name, "MESH")
                         ? "a structured grid (%.30s) is not read; write its cells as Hexahedron "
                           "or Quadrilateral"
                         : "the type %.40s is not known",
                     name);
}

/** Find what a topology says of itself. */
static int take_topology(xdmf_reader *r, const xdmf_piece *piece, xdmf_topology *t) {
    const xdmf_document *d = &r->document;
    const int64_t e = piece->topology;
    int64_t given = -1, per = -1;
    *t = (xdmf_topology){.n = 0};
    int status = find_type(r, e, &t->type);
    if (status || !piece->has_item) /* a cloud of all points, or nothing */
        return status || t->type->code == 1
                   ? status
                   : xdmf_fail(d, e, "there is no DataItem with the nodes of its elements");
    if (xdmf_attribute(d, e, "Order"))
        return xdmf_fail(d, e, "an Order of nodes of its own is not read");
    status = take_whole(r, e, "BaseOffset", &t->base);
    t->base = t->base > 0 ? t->base : 0;
    if (!status)
        status = take_whole(r, e, "NumberOfElements", &given);
    if (!status && given < 0)
        status = take_whole(r, e, "Dimensions", &given);
    if (!status)
        status = take_whole(r, e, "NodesPerElement", &per);
    if (!status)
        status = xdmf_check_count(r, &piece->item, &t->n_values);
    if (status)
        return status;
    /* Some programs give the numbers of the list of a Mixed topology. */
    t->n = t->type->code == 0 && given == t->n_values && given > 0 ? -1 : given;
    t->nodes = t->type->nodes;
    if (t->type->code == 0 || t->type->code == 16)
        return PLANISH_OK;
    if (t->nodes == 0) /* of vertices and polygons the list may say it, too */
        t->nodes = per > 0 ? per : piece->item.width > 1 ? piece->item.width : t->type->code;
    t->n = t->n_values / t->nodes;
    if (per > 0 && per != t->nodes)
        return xdmf_fail(d, e,
                         "its elements have %lld nodes, and not %lld, as NodesPerElement says",
                         (long long)t->nodes, (long long)per);
    if (t->n_values % t->nodes || (given >= 0 && given != t->n))
        return xdmf_fail(d, e, "%lld numbers do not make %lld elements of %lld nodes",
                         (long long)t->n_values, (long long)(given >= 0 ? given : t->n),
                         (long long)t->nodes);
    return PLANISH_OK;
}

/* ---- cells ---------------------------------------------------------------------------------- */

static int fail_mixed(xdmf_reader *r, const xdmf_piece *piece, int64_t cell, const char *text) {
    return xdmf_fail(&r->document, piece->topology, "element %lld (from 0): %s", (long long)cell,
                     text);
}

/** Find the numbers that a polyhedron has behind its type: faces, each led by its number of nodes; -1:
 *  they are not there. */
static int64_t polyhedron_size(const int32_t *at, int64_t left) {
    int64_t size = 1;
    if (left < 1 || at[0] < 0)
        return -1;
    for (int32_t face = 0; face < at[0]; face++) {
        if (size >= left || at[size] < 0 || at[size] >= left - size)
            return -1;
        size += 1 + at[size];
    }
    return size;
}

/** Take the element at *at of a list of several types, which is led by its code, and maybe by how many
 *  nodes it has: VTK's type, and its nodes begin at *at then. -1: none is there. */
static int take_mixed(const int32_t *values, int64_t n, int64_t *at, int64_t *n_nodes) {
    const xdmf_type *type = *at < n ? find_code(values[*at]) : NULL;
    ++*at;
    *n_nodes = type ? type->nodes : -1;
    if (type && type->vtk == VTK_POLYHEDRON)
        *n_nodes = *at < n ? polyhedron_size(values + *at, n - *at) : -1;
    else if (type && type->nodes == 0)
        *n_nodes = *at < n ? values[(*at)++] : -1;
    return *n_nodes >= 0 && *n_nodes <= n - *at ? vtk_type_of(type, *n_nodes) : -1;
}

/** Take the elements of a list of several types apart: grid->connectivity has the list first. Of a
 *  list of polyhedra alone these are not led by a code. */
static int split_mixed(xdmf_reader *r, const xdmf_piece *piece, const xdmf_topology *t,
                       vtk_grid *grid) {
    int32_t *const values = grid->connectivity;
    int64_t n = 0, at = 0, n_nodes, to = 0;
    for (; at < t->n_values; n++, at += n_nodes)
        if (take_mixed(values, t->n_values, &at, &n_nodes) < 0)
            return fail_mixed(r, piece, n, "its type is not known, or its nodes are not all there");
    if (t->n >= 0 && t->n != n)
        return xdmf_fail(&r->document, piece->topology,
                         "%lld elements should be there, and there are %lld", (long long)t->n,
                         (long long)n);
    grid->n = n;
    grid->type = pl_alloc(n, sizeof *grid->type);
    grid->offset = pl_alloc(n + 1, sizeof *grid->offset);
    if (!grid->type || !grid->offset)
        return pl_fail_memory(r->error, "the cells");
    at = n = 0;
    for (; n < grid->n; n++, at += n_nodes) {
        grid->type[n] = take_mixed(values, t->n_values, &at, &n_nodes);
        grid->offset[n] = to;
        memmove(values + to, values + at, (size_t)n_nodes * sizeof *values);
        to += n_nodes;
    }
    grid->offset[n] = grid->n_connectivity = to;
    return PLANISH_OK;
}

/** Make the lists of elements of one type. */
static int fill_uniform(xdmf_reader *r, const xdmf_topology *t, vtk_grid *grid) {
    const int type = t->type->nodes > 0 ? t->type->vtk : vtk_type_of(t->type, t->nodes);
    grid->n = t->n;
    grid->type = pl_alloc(t->n, sizeof *grid->type);
    grid->offset = pl_alloc(t->n + 1, sizeof *grid->offset);
    if (!grid->type || !grid->offset)
        return pl_fail_memory(r->error, "the cells");
    for (int64_t i = 0; i < t->n; i++)
        grid->type[i] = type;
    for (int64_t i = 0; i <= t->n; i++)
        grid->offset[i] = i * t->nodes;
    return PLANISH_OK;
}

/** Let nodes count from 0. Of a polyhedron numbers stand between them: of faces, and of the nodes of
 *  each. */
static void subtract_base(const xdmf_topology *t, vtk_grid *grid) {
    for (int64_t i = 0; i < grid->n && t->base > 0; i++) {
        int64_t k = grid->offset[i], count = grid->type[i] == VTK_POLYHEDRON ? ++k : -1;
        for (; k < grid->offset[i + 1]; k++) {
            const int64_t node = grid->connectivity[k] - t->base;
            if (k == count)
                count += 1 + grid->connectivity[k];
            else
                grid->connectivity[k] = node >= 0 ? (int32_t)node : -1;
        }
    }
}

/** Read the lists of a piece's elements. */
static int read_grid(xdmf_reader *r, const xdmf_piece *piece, const xdmf_topology *t,
                     vtk_grid *grid) {
    const int is_mixed = t->type->code == 0;
    if (t->type->code == 16)
        return xdmf_fail(&r->document, piece->topology,
                         "a list of polyhedra alone is not read; write it as Mixed");
    grid->has_streams = is_mixed;
    grid->n_connectivity = t->n_values;
    grid->connectivity = pl_alloc(t->n_values, sizeof *grid->connectivity);
    if (!grid->connectivity)
        return pl_fail_memory(r->error, "the cells");
    int status = xdmf_integers(r, &piece->item, t->n_values, grid->connectivity);
    if (!status)
        status = is_mixed ? split_mixed(r, piece, t, grid) : fill_uniform(r, t, grid);
    if (!status)
        subtract_base(t, grid);
    return status;
}

/* ---- sets ----------------------------------------------------------------------------------- */

/** Set of nodes; sets of one name are one. */
typedef struct xdmf_set {
    const char *name;
    int32_t *node; /* [n] owned */
    int64_t n, capacity;
} xdmf_set;

typedef struct xdmf_sets {
    xdmf_set *set; /* [n] owned */
    int64_t n, capacity;
    io_order order;        /* of names */
    int64_t n_nodes, most; /* of all sets, and how many these may have */
} xdmf_sets;

static int add_node(xdmf_reader *r, xdmf_set *set, int64_t node) {
    const int32_t index = (int32_t)node;
    return pl_append(&set->node, &set->n, &set->capacity, &index, sizeof index)
               ? PLANISH_OK
               : pl_fail_memory(r->error, "the sets of the file");
}

static int add_cell(xdmf_reader *r, const vtk_grid *grid, int64_t cell, xdmf_set *set) {
    int status = PLANISH_OK;
    if (grid->type[cell] == VTK_POLYHEDRON) /* it holds its nodes in any case */
        return PLANISH_OK;
    for (int64_t k = grid->offset[cell]; k < grid->offset[cell + 1] && !status; k++)
        status = add_node(r, set, grid->first_point + grid->connectivity[k]);
    return status;
}

/** Add the nodes of face (of flat elements edge) number face, as VTK numbers them, of a cell. */
static int add_face(xdmf_reader *r, const vtk_grid *grid, int64_t cell, int64_t face,
                    xdmf_set *set) {
    /* Faces of io_parts, of solids of 4, 5, 6 and 8 corners. */
    static const int8_t faces[][6] = {[4] = {1, 2, 3, 0, -1, -1},
                                      [5] = {0, 1, 2, 3, 4, -1},
                                      [6] = {0, 1, 2, 3, 4, -1},
                                      [8] = {5, 3, 2, 4, 0, 1}};
    int dim = 0, corners = 0, status = PLANISH_OK;
    const io_parts *parts = xdmf_parts_of(grid->type[cell], &dim, &corners);
    const int part = !parts || face < 0 || face >= 6 ? -1
                     : dim == 3                      ? faces[corners][face]
                     : face < parts->n_edges         ? (int)face
                                                     : -1;
    if (part < 0)
        return pl_fail(r->error, PLANISH_ERROR_FORMAT,
                       "%s: the set '%.60s': cell %lld has no face %lld",
                       r->document.view.input.path, set->name, (long long)cell, (long long)face);
    const int8_t *corner = dim == 3 ? parts->face[part] : parts->edge[part];
    const int n = dim == 3 ? io_part_corners(parts, part) : 2;
    const int32_t *nodes = grid->connectivity + grid->offset[cell];
    const int64_t n_nodes = grid->offset[cell + 1] - grid->offset[cell];
    uint32_t has = 0;
    for (int i = 0; i < n; i++)
        has |= UINT32_C(1) << corner[i];
    has = io_part_nodes(parts, corners, has);
    for (int i = 0; i < n_nodes && !status; i++)
        if (has >> i & 1)
            status = add_node(r, set, grid->first_point + nodes[i]);
    return status;
}

typedef enum set_kind { SET_OF_NODES, SET_OF_CELLS, SET_OF_FACES } set_kind;

static int compare_set(const void *key, const void *list, int64_t index) {
    return strcmp(key, ((const xdmf_set *)list)[index].name);
}

/** Find the set of that name, a new one if there is none. */
static int find_set(xdmf_reader *r, xdmf_sets *sets, const char *name, xdmf_set **set) {
    const xdmf_set new = {.name = name};
    int64_t place, i = io_order_find(&sets->order, name, sets->set, compare_set, &place);
    if (i < 0 && sets->n == MOST_SETS)
        return pl_fail(r->error, PLANISH_ERROR_FORMAT, "%s: there are more than %d sets",
                       r->document.view.input.path, MOST_SETS);
    if (i < 0) {
        i = sets->n;
        if (!pl_append(&sets->set, &sets->n, &sets->capacity, &new, sizeof new) ||
            !io_order_insert(&sets->order, place, i))
            return pl_fail_memory(r->error, "the sets of the file");
    }
    *set = &sets->set[i];
    return PLANISH_OK;
}

/** Read the lists of a set: of nodes or cells, and maybe faces of these. */
static int read_lists(xdmf_reader *r, int64_t element, int64_t *n, int32_t *list[2]) {
    xdmf_item item[XDMF_MOST_ITEMS];
    int n_items = 0;
    int status = xdmf_items_in(r, element, item, &n_items);
    for (int k = 0; k < n_items && k < 2 && !status; k++) {
        int64_t here;
        status = xdmf_check_count(r, &item[k], &here);
        if (!status && k > 0 && here != *n)
            status = xdmf_fail(&r->document, element, "there are %lld cells and %lld faces of them",
                               (long long)*n, (long long)here);
        *n = here;
        list[k] = status ? NULL : pl_alloc(here, sizeof *list[k]);
        if (!status && !list[k])
            status = pl_fail_memory(r->error, "the sets of the file");
        if (!status)
            status = xdmf_integers(r, &item[k], here, list[k]);
    }
    return status;
}

/** Check that cells have not more nodes than so many listed ones can: one of many nodes, listed over and
 *  over, would fill the memory. */
static int check_nodes(xdmf_reader *r, const xdmf_sets *sets, int64_t element) {
    return sets->n_nodes <= sets->most
               ? PLANISH_OK
               : xdmf_fail(&r->document, element, "it lists cells of many nodes over and over");
}

/** Read a set of a piece: sets of edges, and of grids, are passed over. */
static int read_set(xdmf_reader *r, const vtk_grid *grid, int64_t element, xdmf_sets *sets) {
    const xdmf_document *d = &r->document;
    const char *type = xdmf_attribute(d, element, "SetType"), *name;
    int32_t *list[2] = {NULL, NULL};
    int64_t n = 0;
    type = type ? type : xdmf_attribute(d, element, "Type");
    name = xdmf_attribute(d, element, "Name");
    const set_kind kind = type && strcasecmp(type, "Cell") == 0   ? SET_OF_CELLS
                          : type && strcasecmp(type, "Face") == 0 ? SET_OF_FACES
                                                                  : SET_OF_NODES;
    if (!name || (type && kind == SET_OF_NODES && strcasecmp(type, "Node") != 0) ||
        (xdmf_attribute(d, element, "Ghost") && xdmf_attribute(d, element, "Ghost")[0] > '0'))
        return PLANISH_OK;
    xdmf_set *set = NULL;
    int status = find_set(r, sets, name, &set);
    if (!status)
        status = read_lists(r, element, &n, list);
    const int64_t n_there = kind == SET_OF_NODES ? grid->n_points : grid->n;
    sets->most += PER_NUMBER * n;
    for (int64_t i = 0; i < n && !status; i++) {
        const int64_t number = list[0][i], n_before = set->n;
        if (number < 0 || number >= n_there)
            status = xdmf_fail(d, element, "number %lld of its list, %lld, is not in 0 .. %lld",
                               (long long)i, (long long)number, (long long)n_there - 1);
        else if (kind == SET_OF_NODES)
            status = add_node(r, set, grid->first_point + number);
        else if (kind == SET_OF_FACES && list[1])
            status = add_face(r, grid, number, list[1][i], set);
        else
            status = add_cell(r, grid, number, set);
        sets->n_nodes += set->n - n_before;
        if (!status)
            status = check_nodes(r, sets, element);
    }
    pl_free(list[0]);
    pl_free(list[1]);
    return status;
}

static int read_sets(xdmf_reader *r, const xdmf_piece *piece, const vtk_grid *grid,
                     xdmf_sets *sets) {
    int status = PLANISH_OK;
    sets->most += TIMES * grid->n_connectivity;
    for (int64_t i = 0; i < piece->grids.n && !status; i++) {
        xdmf_list list = {0};
        status = xdmf_children(&r->document, piece->grids.element[i], "Set", &list);
        for (int64_t k = 0; k < list.n && !status; k++)
            status = read_set(r, grid, list.element[k], sets);
        pl_free(list.element);
    }
    return status;
}

/** Make groups of nodes of the sets. Their numbers are none of the file's: users are not to meet them. */
static int make_groups(xdmf_reader *r, const xdmf_sets *sets) {
    io_memberships m = {.n = 0};
    int32_t *number = pl_alloc(sets->n, sizeof *number);
    int status = number ? io_memberships_begin(&m, r->model->n_nodes, r->error)
                        : pl_fail_memory(r->error, "the sets of the file");
    for (int pass = 0; pass < 2 && !status; pass++) {
        for (int64_t k = 0; k < sets->n; k++)
            for (int64_t i = 0; i < sets->set[k].n; i++)
                io_memberships_add(&m, sets->set[k].node[i], (int32_t)k + 1);
        if (pass == 0)
            status = io_memberships_counted(&m, r->error);
    }
    for (int64_t k = 0; k < sets->n && !status; k++) {
        number[k] = INT32_MIN + (int32_t)k;
        status = io_model_group(r->model, 0, number[k], sets->set[k].name,
                                (int64_t)strlen(sets->set[k].name), r->error);
    }
    if (!status) {
        io_memberships_renumber(&m, number);
        status = io_memberships_of_nodes(&m, r->model, r->error);
    }
    io_memberships_destroy(&m);
    pl_free(number);
    return status;
}

static void release_sets(xdmf_sets *sets) {
    for (int64_t i = 0; i < sets->n; i++)
        pl_free(sets->set[i].node);
    pl_free(sets->set);
    io_order_release(&sets->order);
}

/* ---- pieces --------------------------------------------------------------------------------- */

/** Count the cells of each dimension that the model has. */
static void count_kept(const io_model *model, int64_t n_of[4]) {
    n_of[0] = 0;
    for (int dim = 1; dim <= 3; dim++)
        n_of[dim] = io_model_list(model, dim).n +
                    (dim > 1 ? io_model_list(model, io_others_list(dim)).n : 0);
}

/** Return whether a piece before this one has the same points. */
static int has_same_points(const xdmf_mesh *m, const xdmf_piece *piece) {
    for (const xdmf_piece *p = m->piece; p < piece; p++)
        if (p->geometry == piece->geometry)
            return 1;
    return 0;
}

/** Note how many cells the piece has, behind those of the pieces before it. */
static void count_piece(xdmf_mesh *m, xdmf_piece *piece, int64_t n) {
    piece->n = n;
    piece->first_cell = m->n_cells;
    m->n_cells += piece->map ? 0 : n;
}

static int read_piece(xdmf_reader *r, xdmf_mesh *m, xdmf_piece *piece, xdmf_tables *tables,
                      xdmf_sets *sets) {
    const xdmf_geometry *g = &m->geometry[piece->geometry];
    xdmf_topology t;
    vtk_grid grid = {.n_points = g->n_nodes,
                     .first_point = g->first_node,
                     .first_cell = m->n_cells,
                     .is_piece = m->n_pieces > 1};
    int64_t before[4];
    count_kept(r->model, before);
    int status = take_topology(r, piece, &t);
    if (!status && piece->has_item)
        status = read_grid(r, piece, &t, &grid);
    if (!status && has_same_points(m, piece))
        status = xdmf_find_map(tables, r->model, &grid, m->n_cells, &piece->map, r->error);
    if (!status && grid.n > 0 && !piece->map)
        status = vtk_cells_store(r->model, &grid, r->error);
    if (!status)
        status = read_sets(r, piece, &grid, sets);
    count_kept(r->model, piece->n_of);
    for (int dim = 1; dim <= 3; dim++)
        piece->n_of[dim] -= before[dim];
    count_piece(m, piece, grid.n);
    vtk_grid_release(&grid);
    return status;
}

int xdmf_count_cells(xdmf_reader *r, xdmf_mesh *m) {
    xdmf_tables tables = {.table = {{.n_slots = 0}}};
    int status = PLANISH_OK;
    for (int64_t i = 0; i < m->n_pieces && !status; i++) {
        xdmf_piece *piece = &m->piece[i];
        const xdmf_geometry *g = &m->geometry[piece->geometry];
        xdmf_topology t;
        vtk_grid grid = {.n_points = g->n_nodes, .first_point = g->first_node};
        status = take_topology(r, piece, &t);
        grid.n = t.n;
        const int may_have_map = has_same_points(m, piece);
        if (!status && piece->has_item && (t.n < 0 || may_have_map))
            status = read_grid(r, piece, &t, &grid);
        if (!status && may_have_map)
            status = xdmf_find_map(&tables, r->model, &grid, m->n_cells, &piece->map, r->error);
        count_piece(m, piece, grid.n);
        vtk_grid_release(&grid);
    }
    xdmf_tables_release(&tables);
    return status;
}

int xdmf_read_cells(xdmf_reader *r, xdmf_mesh *m) {
    xdmf_sets sets = {0};
    xdmf_tables tables = {.table = {{.n_slots = 0}}};
    int status = PLANISH_OK;
    for (int64_t i = 0; i < m->n_pieces && !status; i++)
        status = read_piece(r, m, &m->piece[i], &tables, &sets);
    if (!status && sets.n > 0)
        status = make_groups(r, &sets);
    release_sets(&sets);
    xdmf_tables_release(&tables);
    return status;
}
