/* cgns_elements: the sections of elements of CGNS files, of one type or MIXED, with numbers of
 * nodes from 1. Those without a planish_cell_type hold their nodes.
 */
#ifdef PL_HDF5
#include "io/cgns/cgns_reader.h"

#include "io/core/elements.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

/* ---- types of elements -------------------------------------------------------------------- */

enum { CGNS_MIXED = 20, MOST_NODES = 125 };

/** Types by CGNS's numbers. */
static const io_element_type types[] = {
    [2] = {NULL, IO_POINT, 1, 1},
    [3] = {NULL, IO_LINE, 1, 2},
    [4] = {NULL, IO_LINE, 2, 3},
    [5] = {NULL, IO_TRIANGLE, 1, 3},
    [6] = {NULL, IO_TRIANGLE, 2, 6},
    [7] = {NULL, IO_QUADRILATERAL, 1, 4},
    [8] = {NULL, IO_QUADRILATERAL, 2, 8},
    [9] = {NULL, IO_QUADRILATERAL, 2, 9},
    [10] = {NULL, IO_TETRAHEDRON, 1, 4},
    [11] = {NULL, IO_TETRAHEDRON, 2, 10},
    [12] = {NULL, IO_PYRAMID, 1, 5},
    [13] = {NULL, IO_PYRAMID, 2, 14},
    [14] = {NULL, IO_PRISM, 1, 6},
    [15] = {NULL, IO_PRISM, 2, 15},
    [16] = {NULL, IO_PRISM, 2, 18},
    [17] = {NULL, IO_HEXAHEDRON, 1, 8},
    [18] = {NULL, IO_HEXAHEDRON, 2, 20},
    [19] = {NULL, IO_HEXAHEDRON, 2, 27},
    [21] = {NULL, IO_PYRAMID, 2, 13},
    [22] = {NULL, IO_POLYGON, 1, 0},
    [23] = {NULL, IO_POLYHEDRON, 1, 0},
    [24] = {NULL, IO_LINE, 3, 4},
    [25] = {NULL, IO_TRIANGLE, 3, 9},
    [26] = {NULL, IO_TRIANGLE, 3, 10},
    [27] = {NULL, IO_QUADRILATERAL, 3, 12},
    [28] = {NULL, IO_QUADRILATERAL, 3, 16},
    [29] = {NULL, IO_TETRAHEDRON, 3, 16},
    [30] = {NULL, IO_TETRAHEDRON, 3, 20},
    [31] = {NULL, IO_PYRAMID, 3, 21},
    [32] = {NULL, IO_PYRAMID, 3, 29},
    [33] = {NULL, IO_PYRAMID, 3, 30},
    [34] = {NULL, IO_PRISM, 3, 24},
    [35] = {NULL, IO_PRISM, 3, 38},
    [36] = {NULL, IO_PRISM, 3, 40},
    [37] = {NULL, IO_HEXAHEDRON, 3, 32},
    [38] = {NULL, IO_HEXAHEDRON, 3, 56},
    [39] = {NULL, IO_HEXAHEDRON, 3, 64},
    [40] = {NULL, IO_LINE, 4, 5},
    [41] = {NULL, IO_TRIANGLE, 4, 12},
    [42] = {NULL, IO_TRIANGLE, 4, 15},
    [43] = {NULL, IO_QUADRILATERAL, 4, 16},
    [44] = {NULL, IO_QUADRILATERAL, 4, 25},
    [45] = {NULL, IO_TETRAHEDRON, 4, 22},
    [46] = {NULL, IO_TETRAHEDRON, 4, 34},
    [47] = {NULL, IO_TETRAHEDRON, 4, 35},
    [48] = {NULL, IO_PYRAMID, 4, 29},
    [49] = {NULL, IO_PYRAMID, 4, 50},
    [50] = {NULL, IO_PYRAMID, 4, 55},
    [51] = {NULL, IO_PRISM, 4, 33},
    [52] = {NULL, IO_PRISM, 4, 66},
    [53] = {NULL, IO_PRISM, 4, 75},
    [54] = {NULL, IO_HEXAHEDRON, 4, 44},
    [55] = {NULL, IO_HEXAHEDRON, 4, 98},
    [56] = {NULL, IO_HEXAHEDRON, 4, 125},
};
enum { N_TYPES = sizeof types / sizeof *types };

/** Types whose nodes stand in another order than VTK's, by the conventions of SIDS: the mids of
 *  upright edges come before those of the top, and the middles of faces from the bottom to the
 *  top. */
static const io_node_order node_order[] = {
    {PLANISH_CELL_WEDGE15, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
    {PLANISH_CELL_WEDGE18, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 15, 16, 17}},
    {PLANISH_CELL_HEXAHEDRON20,
     {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 16, 17,
                                 18, 19, 12, 13, 14, 15, 24, 22, 21, 23, 20, 25, 26}},
    {0, {0}},
};

/** Find the type of that number, which must be one of elements that can be read. */
static int take_type(cgns_reader *r, const char *path, int64_t number,
                     const io_element_type **type) {
    *type = &types[number > 0 && number < N_TYPES ? number : 0];
    if ((*type)->shape == IO_NO_SHAPE)
        return io_hdf5_fail(r->file, path, "elements of type %lld are unknown", (long long)number);
    if (io_element_use(*type) == IO_REFUSE)
        return io_hdf5_fail(r->file, path, "type %lld: " IO_OF_THIRD_ORDER, (long long)number);
    if ((*type)->nodes == 0)
        return io_hdf5_fail(r->file, path,
                            "polygons and polyhedra (NGON_n, NFACE_n) are not read; export the "
                            "mesh with elements of fixed types, as TETRA_4");
    return PLANISH_OK;
}

/* ---- a walk over the elements of a section ------------------------------------------------- */

typedef struct section_walk {
    cgns_reader *r;
    cgns_section *section;
    io_hdf5_path path; /* of the list of nodes */
    io_hdf5_integers nodes, offsets;
    int64_t n, index;            /* elements; the one that the walk came to, -1: none yet, */
    int64_t at;                  /* its nodes in the list, */
    const io_element_type *type; /* and its type: the section's, or in a mixed one its own */
} section_walk;

/** Go to the next element; not behind the last. In a mixed section its type leads its nodes. */
static int next_element(section_walk *w) {
    io_hdf5 *file = w->r->file;
    w->at += w->index >= 0 ? w->type->nodes : 0;
    w->index++;
    if (w->section->type != CGNS_MIXED)
        return PLANISH_OK;
    if (w->offsets.n > 0 && io_hdf5_integer(&w->offsets, w->index) != w->at)
        return io_hdf5_fail(file, w->path.text,
                            "element %lld begins at %lld, and ElementStartOffset says %lld",
                            (long long)(w->section->start + w->index), (long long)w->at,
                            (long long)io_hdf5_integer(&w->offsets, w->index));
    if (w->at >= w->nodes.n)
        return io_hdf5_fail(file, w->path.text,
                            "the list ends before element %lld of %lld (the file may be cut short)",
                            (long long)w->index + 1, (long long)w->n);
    int status = take_type(w->r, w->path.text, io_hdf5_integer(&w->nodes, w->at), &w->type);
    w->at++;
    if (!status && w->type->nodes > w->nodes.n - w->at)
        status = io_hdf5_fail(file, w->path.text, "the list ends within element %lld of %lld",
                              (long long)w->index + 1, (long long)w->n);
    return status;
}

/** Count the elements of each dimension that are kept, and check the length of the list. */
static int count_kept(section_walk *w, int64_t kept[4]) {
    int status = PLANISH_OK;
    memset(kept, 0, 4 * sizeof *kept);
    if (w->section->type != CGNS_MIXED) {
        kept[io_element_dim(w->type)] = io_element_use(w->type) == IO_KEEP ? w->n : 0;
        if (w->nodes.n % w->type->nodes || w->nodes.n / w->type->nodes != w->n)
            status =
                io_hdf5_fail(w->r->file, w->path.text, "%lld numbers for %lld elements of %d nodes",
                             (long long)w->nodes.n, (long long)w->n, w->type->nodes);
        return status;
    }
    if (w->offsets.n != 0 && w->offsets.n != w->n + 1)
        return io_hdf5_fail(w->r->file, w->path.text, "%lld offsets for %lld elements",
                            (long long)w->offsets.n, (long long)w->n);
    for (int64_t i = 0; i < w->n && !status; i++) {
        status = next_element(w);
        kept[io_element_dim(w->type)] += !status && io_element_use(w->type) == IO_KEEP;
    }
    const int64_t end = w->at + (w->n > 0 ? w->type->nodes : 0);
    if (!status && end != w->nodes.n)
        status = io_hdf5_fail(w->r->file, w->path.text,
                              "%lld numbers are left behind the last of %lld elements",
                              (long long)(w->nodes.n - end), (long long)w->n);
    return status;
}

/* ---- sections ----------------------------------------------------------------------------- */

/** Take node j of the element that the walk came to: its index. */
static int take_node(section_walk *w, int j, int32_t *node) {
    const int64_t number = io_hdf5_integer(&w->nodes, w->at + j), most = w->r->model->n_nodes;
    *node = (int32_t)(number - 1);
    if (number >= 1 && number <= most)
        return PLANISH_OK;
    return io_hdf5_fail(w->r->file, w->path.text, "element %lld: node %lld is not in 1 .. %lld",
                        (long long)(w->section->start + w->index), (long long)number,
                        (long long)most);
}

/** Add the element that the walk came to, which is no simplex, or hold its nodes. */
static int add_other(section_walk *w, int32_t section) {
    io_model *model = w->r->model;
    const io_element_type *t = w->type;
    const int type = io_element_other(t), list = io_others_list(io_element_dim(t));
    int32_t node[MOST_NODES];
    int status = PLANISH_OK;
    for (int j = 0; j < t->nodes && !status; j++) {
        status = take_node(w, j, &node[j]);
        if (!status && !type)
            io_hold_node(model, node[j], io_element_reason(t));
    }
    if (status)
        return status;
    io_element_count(model, t, 1);
    status =
        io_model_add_other(model, type, node, section, w->section->start + w->index, w->r->error);
    if (!status && type)
        w->section->behind[list] = io_model_list(model, list).n;
    return status;
}

/** Take the nodes of the element that the walk came to, for which there is room behind the others of
 *  dimension dim. */
static int add_kept(section_walk *w, int dim, int32_t section) {
    io_model *model = w->r->model;
    io_cells *cells = io_model_cells(model, dim);
    const int n = w->type->nodes, corners = dim + 1;
    int32_t node[MOST_NODES];
    int status = PLANISH_OK;
    for (int j = 0; j < n && !status; j++)
        status = take_node(w, j, &node[j]);
    if (!status && n > corners)
        status = io_cells_reserve_mids(model, dim, w->r->error);
    if (status)
        return status;
    memcpy(cells->nodes + cells->n * corners, node, (size_t)corners * sizeof *node);
    if (n > corners)
        io_cells_set_mids(model, dim, cells->n, node);
    cells->entity[cells->n] = section;
    cells->number[cells->n++] = w->section->start + w->index;
    w->section->behind[dim] = cells->n;
    return PLANISH_OK;
}

/** Store the elements of a section whose lists have been read; index: of the section. */
static int store_elements(section_walk *w, int32_t index) {
    io_model *model = w->r->model;
    int64_t kept[4];
    int status = count_kept(w, kept);
    for (int k = IO_FLAT_LIST; k < IO_N_LISTS; k++)
        w->section->first[k] = w->section->behind[k] = io_model_list(model, k).n;
    for (int dim = 1; dim <= 3 && !status; dim++) {
        io_cells *cells = io_model_cells(model, dim);
        w->section->first[dim] = w->section->behind[dim] = cells->n;
        if (kept[dim] > 0)
            status = io_cells_reserve(model, dim, kept[dim], 1, 1, w->r->error);
    }
    w->index = -1;
    w->at = 0;
    for (int64_t i = 0; i < w->n && !status; i++) {
        status = next_element(w);
        if (!status && io_element_use(w->type) == IO_KEEP)
            status = add_kept(w, io_element_dim(w->type), index);
        else if (!status)
            status = add_other(w, index);
    }
    return status;
}

static int read_section(cgns_reader *r, int32_t index) {
    cgns_section *section = &r->section[index];
    section_walk w = {.r = r,
                      .section = section,
                      .n = section->end - section->start + 1,
                      .index = -1,
                      .type = &types[0]};
    const io_hdf5_path path = cgns_child(r, &r->zone, section->name);
    const io_hdf5_path offsets = cgns_child(r, &path, "ElementStartOffset");
    const int is_mixed = section->type == CGNS_MIXED;
    int status = PLANISH_OK;
    w.path = cgns_child(r, &path, "ElementConnectivity");
    if (!is_mixed) /* refused before its lists are looked for */
        status = take_type(r, path.text, section->type, &w.type);
    else if (io_hdf5_kind_of(r->file, offsets.text) == IO_HDF5_GROUP)
        status = cgns_integers(r, &offsets, &w.offsets);
    if (!status)
        status = cgns_integers(r, &w.path, &w.nodes);
    if (!status)
        status = store_elements(&w, index);
    io_hdf5_integers_release(&w.nodes);
    io_hdf5_integers_release(&w.offsets);
    return status;
}

/** Add the section called name, with type and range of its elements. */
static int add_section(cgns_reader *r, const char *name) {
    io_hdf5_integers data = {0}, range = {0};
    const cgns_section named = {.name = name};
    cgns_section *s = pl_append(&r->section, &r->n_sections, &r->capacity, &named, sizeof named);
    if (!s)
        return pl_fail_memory(r->error, "the sections of elements");
    const io_hdf5_path path = cgns_child(r, &r->zone, s->name);
    const io_hdf5_path numbers = cgns_child(r, &path, "ElementRange");
    int status = cgns_integers(r, &path, &data);
    if (!status)
        status = cgns_integers(r, &numbers, &range);
    if (!status && (data.n < 1 || range.n != 2))
        status = io_hdf5_fail(r->file, path.text, "type and range of its elements were expected");
    if (!status) {
        const int64_t type = io_hdf5_integer(&data, 0);
        s->type = type > 0 && type < N_TYPES ? (int)type : 0;
        s->start = io_hdf5_integer(&range, 0);
        s->end = io_hdf5_integer(&range, 1);
        if (s->start < 1 || s->end < s->start - 1 || s->end == INT64_MAX)
            status = io_hdf5_fail(r->file, path.text,
                                  "ElementRange: elements %lld to %lld are not a range",
                                  (long long)s->start, (long long)s->end);
    }
    io_hdf5_integers_release(&data);
    io_hdf5_integers_release(&range);
    return status;
}

static int compare_sections(const void *a, const void *b) {
    const cgns_section *x = a, *y = b;
    return x->start != y->start ? (x->start < y->start ? -1 : 1)
                                : (x->end > y->end) - (x->end < y->end);
}

int cgns_read_elements(cgns_reader *r) {
    io_hdf5_names names;
    r->model->node_order = node_order;
    int status = cgns_children(r, &r->zone, "Elements_t", &names);
    for (int64_t i = 0; i < names.n && !status; i++)
        status = add_section(r, names.name[i]);
    if (!status && r->n_sections > 0)
        qsort(r->section, (size_t)r->n_sections, sizeof *r->section, compare_sections);
    for (int64_t i = 1; i < r->n_sections && !status; i++)
        if (r->section[i].start <= r->section[i - 1].end)
            status = io_hdf5_fail(
                r->file, r->zone.text, "element %lld is in two sections, %.60s and %.60s",
                (long long)r->section[i].start, r->section[i - 1].name, r->section[i].name);
    for (int64_t i = 0; i < r->n_sections && !status; i++)
        status = read_section(r, (int32_t)i);
    return status;
}

#endif
