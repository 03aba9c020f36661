/* exodus_sets: node sets and side sets of Exodus files.
 *
 * A side set lists sides of elements. Sides that are facets of the mesh become triangles,
 * quadrilaterals or lines of the model, one for all sets that have it, however many elements list
 * it. They hold no nodes by themselves. Of all other sides (faces and edges of shells beside solids,
 * ends of lines) the nodes are in the set, as they would be in a node set.
 *
 * Cubit numbers blocks, node sets and side sets from 1 each. io_twins_number tells those of one number apart.
 */
#include "io/exodus/exodus_reader.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/elements.h"
#include "io/core/memberships.h"
#include "io/core/mids.h"
#include "io/core/parts.h"
#include "io/core/records.h"
#include "io/core/twins.h"

#include <stdlib.h>
#include <string.h>

/* Sets that list all so many times over are no mesh's. */
enum { MOST_LISTINGS = 64, MOST_CORNERS = 4 };

/** A side that is a facet of the mesh. */
typedef struct set_side {
    int32_t corner[MOST_CORNERS]; /* ascending; -1: none */
    int32_t set;                  /* the set, from 0 */
    int32_t part;                 /* face, or edge of a flat element (io_parts), */
    int64_t block, at;            /* of this element in this block */
} set_side;

typedef struct sets {
    exodus_reader *r;
    exodus_labels nodes, sides;
    set_side *side; /* [n_sides] */
    int64_t n_sides, side_capacity;
    int64_t listed;
    uint8_t *has_others; /* [sides.n] sides that are no facets; owned */
    int dim;             /* of the elements that are smoothed */
} sets;

/* ---- sides ---------------------------------------------------------------------------------- */

/** Nodes of an element, or of one of its sides. */
typedef struct side_nodes {
    int32_t node[IO_CELL_NODES]; /* [n] corners first, then mids in VTK's order */
    int n, corners;
} side_nodes;

/** Find the nodes of an element of a block. */
static side_nodes nodes_of(const sets *s, const exodus_block *block, int64_t at) {
    side_nodes all = {.n = 0};
    const io_list list = io_model_list(s->r->model, block->list);
    all.n = io_list_nodes(&list, block->at + at, all.node, &all.corners);
    return all;
}

/** Find the node in the middle of the edge between corners a and b of an element, or -1. */
static int32_t mid_of(const io_parts *parts, const side_nodes *all, int a, int b) {
    for (int e = 0; e < parts->n_edges; e++) {
        const int8_t *edge = parts->edge[e];
        if ((edge[0] == a && edge[1] == b) || (edge[0] == b && edge[1] == a))
            return all->corners + e < all->n ? all->node[all->corners + e] : -1;
    }
    return -1;
}

/** Find the node in the middle of a face of an element, or -1. */
static int32_t middle_of(const io_parts *parts, const side_nodes *all, int face) {
    const int at = all->corners + parts->n_edges + parts->middle[face];
    return parts->middle[face] >= 0 && at < all->n ? all->node[at] : -1;
}

/** Find the nodes of face or edge part of an element of a block. Mids only if all are there, and the node
 *  in the middle of a face behind them, if it has one. */
static side_nodes nodes_of_part(const sets *s, const exodus_block *block, int64_t at, int part) {
    const side_nodes all = nodes_of(s, block, at);
    const io_parts *parts = io_parts_of(block->dim, all.corners);
    const int is_edge = block->dim == 2;
    const int8_t *corner = is_edge ? parts->edge[part] : parts->face[part];
    const int n = is_edge ? 2 : io_part_corners(parts, part), n_mids = is_edge ? 1 : n;
    side_nodes side = {.n = n, .corners = n};
    int mids = 0;
    for (int i = 0; i < n; i++)
        side.node[i] = all.node[corner[i]];
    for (int i = 0; i < n_mids; i++) {
        side.node[n + i] = mid_of(parts, &all, corner[i], corner[(i + 1) % n]);
        mids += side.node[n + i] >= 0;
    }
    side.n += mids == n_mids ? n_mids : 0;
    const int32_t middle = is_edge ? -1 : middle_of(parts, &all, part);
    if (mids == n_mids && middle >= 0)
        side.node[side.n++] = middle;
    return side;
}

/** Find the part that a side of an element is, by its number from 1; *is_whole: all of the element.
 *  -1: it has no such side. */
static int part_of(const exodus_block *block, int corners, int64_t side, int *is_whole) {
    *is_whole = block->dim < 2 || (block->is_shell && side <= 2);
    if (side < 1 || (*is_whole && side > 2))
        return -1;
    if (*is_whole)
        return 0;
    if (block->dim == 3)
        return side <= 6 ? exodus_side_faces[corners][side - 1] : -1;
    const int64_t edge = side - 1 - (block->is_shell ? 2 : 0);
    return edge < corners ? (int)edge : -1;
}

/** Note side k of a side set, which is a facet. */
static int add_side(sets *s, int64_t k, int64_t block, int64_t at, int part) {
    const side_nodes nodes = nodes_of_part(s, &s->r->block[block], at, part);
    set_side side = {{-1, -1, -1, -1}, (int32_t)k, part, block, at};
    for (int i = 0; i < nodes.corners; i++) { /* in order, behind those that there are not */
        int at_corner = MOST_CORNERS - nodes.corners + i;
        for (; at_corner > 0 && side.corner[at_corner - 1] > nodes.node[i]; at_corner--)
            side.corner[at_corner] = side.corner[at_corner - 1];
        side.corner[at_corner] = nodes.node[i];
    }
    return pl_append(&s->side, &s->n_sides, &s->side_capacity, &side, sizeof side)
               ? PLANISH_OK
               : pl_fail_memory(s->r->error, "the side sets");
}

/** Put the nodes of a side, or of an element, into the set of a tag. */
static void add_nodes(io_memberships *m, const side_nodes *nodes, int32_t tag) {
    for (int i = 0; i < nodes->n; i++)
        if (nodes->node[i] >= 0)
            io_memberships_add(m, nodes->node[i], tag);
}

/** Find the block of an element, from 0; the element is one of the file's. */
static int64_t block_of(const exodus_reader *r, int64_t element) {
    int64_t low = 0, high = r->n_blocks;
    while (high - low > 1) {
        const int64_t middle = low + (high - low) / 2;
        if (r->block[middle].first <= element)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/** Take a side of a side set: note it as a facet, or (m is not NULL) its nodes, if it is none. */
static int take_side(sets *s, int64_t k, const char *name, int64_t element, int64_t side,
                     io_memberships *m) {
    exodus_reader *r = s->r;
    if (element < 1 || element > r->n_elements)
        return netcdf_fail(r->file, name, "element %lld is not in 1 .. %lld", (long long)element,
                           (long long)r->n_elements);
    const int64_t index = block_of(r, element - 1);
    const exodus_block *block = &r->block[index];
    const int64_t at = element - 1 - block->first;
    int is_whole;
    if (block->list == 0) /* it holds its nodes in any case */
        return PLANISH_OK;
    const side_nodes all = nodes_of(s, block, at);
    const int part = part_of(block, all.corners, side, &is_whole);
    if (part < 0)
        return netcdf_fail(r->file, name, "element %lld has no side %lld", (long long)element,
                           (long long)side);
    const int is_facet = !is_whole && block->dim == s->dim;
    if (is_facet)
        return m ? PLANISH_OK : add_side(s, k, index, at, part);
    s->has_others[k] = 1;
    if (!m)
        return PLANISH_OK;
    const side_nodes nodes = is_whole ? all : nodes_of_part(s, block, at, part);
    add_nodes(m, &nodes, (int32_t)(s->nodes.n + k) + 1);
    return PLANISH_OK;
}

/** Check that sets do not list all again and again. */
static int check_listed(sets *s, const char *name, int64_t n) {
    const exodus_reader *r = s->r;
    const int64_t most =
        MOST_LISTINGS * (r->model->n_nodes + r->n_elements) + r->model->input.size / 4;
    s->listed += n;
    return s->listed <= most
               ? PLANISH_OK
               : netcdf_fail(r->file, name,
                             "sets up to this one list all nodes and elements more than %d times "
                             "over; the file is damaged",
                             MOST_LISTINGS);
}

/** Take all sides of side set k as take_side does. */
static int take_sides(sets *s, int64_t k, io_memberships *m) {
    netcdf *file = s->r->file;
    const exodus_name name = exodus_name_of("elem_ss", k);
    io_hdf5_integers elements = {0}, sides = {0};
    int status = netcdf_integers_read(file, name.text, &elements);
    if (!status)
        status = netcdf_integers_read(file, exodus_name_of("side_ss", k).text, &sides);
    if (!status && sides.n != elements.n)
        status = netcdf_fail(file, name.text, "%lld elements and %lld sides of them",
                             (long long)elements.n, (long long)sides.n);
    if (!status && !m)
        status = check_listed(s, name.text, elements.n);
    for (int64_t i = 0; i < elements.n && !status; i++)
        status = take_side(s, k, name.text, io_hdf5_integer(&elements, i),
                           io_hdf5_integer(&sides, i), m);
    netcdf_integers_release(&elements);
    netcdf_integers_release(&sides);
    return status;
}

/* ---- facets --------------------------------------------------------------------------------- */

static int compare_sides(const void *a, const void *b) {
    const set_side *x = a, *y = b;
    for (int i = 0; i < MOST_CORNERS; i++)
        if (x->corner[i] != y->corner[i])
            return x->corner[i] < y->corner[i] ? -1 : 1;
    return (x->set > y->set) - (x->set < y->set);
}

/** Make a side a facet of the model, of an entity. */
static int make_facet(sets *s, const set_side *side, int32_t entity) {
    exodus_reader *r = s->r;
    const exodus_block *block = &r->block[side->block];
    const side_nodes nodes = nodes_of_part(s, block, side->at, side->part);
    const io_list list = io_model_list(r->model, block->list);
    const int64_t number = io_list_number(&list, block->at + side->at);
    if (nodes.corners < MOST_CORNERS)
        return io_model_add_simplex(r->model,
                                    io_simplex_type(nodes.corners - 1, nodes.n > nodes.corners),
                                    nodes.node, entity, number, r->error);
    r->model->n_other++;
    return io_model_add_other(r->model, io_cell_type(IO_QUADRILATERAL, nodes.n), nodes.node, entity,
                              number, r->error);
}

/** Make facets of all sides that have been noted: one of those with the same corners. */
static int make_facets(sets *s) {
    exodus_reader *r = s->r;
    int32_t *number = pl_alloc(s->sides.n, sizeof *number);
    int status = number ? PLANISH_OK : pl_fail_memory(r->error, "the side sets");
    if (s->n_sides > 0)
        qsort(s->side, (size_t)s->n_sides, sizeof *s->side, compare_sides);
    for (int64_t i = 0, end; i < s->n_sides && !status; i = end) {
        const set_side *first = &s->side[i];
        int n = 0;
        for (end = i; end < s->n_sides &&
                      memcmp(first->corner, s->side[end].corner, sizeof first->corner) == 0;
             end++)
            if (end == i || s->side[end].set != s->side[end - 1].set)
                number[n++] = s->sides.number[s->side[end].set];
        const int32_t entity =
            io_model_entity(r->model, s->dim - 1, number[0], n, number, r->error);
        status = entity < 0 ? entity : make_facet(s, first, entity);
    }
    pl_free(number);
    return status;
}

/* ---- sets of nodes -------------------------------------------------------------------------- */

/** Put the nodes of node set k into the set of its tag. */
static int take_nodes(sets *s, int64_t k, io_memberships *m) {
    const exodus_name name = exodus_name_of("node_ns", k);
    io_hdf5_integers list = {0};
    int status = netcdf_integers_read(s->r->file, name.text, &list);
    if (!status && !m->is_counted)
        status = check_listed(s, name.text, list.n);
    for (int64_t i = 0; i < list.n && !status; i++) {
        int32_t node;
        status = exodus_take_node(s->r, name.text, &list, i, &node, s->r->error);
        if (!status)
            io_memberships_add(m, node, (int32_t)k + 1);
    }
    netcdf_integers_release(&list);
    return status;
}

/** Make the entities of nodes: of node sets, and of sides that are no facets. */
static int make_node_entities(sets *s) {
    exodus_reader *r = s->r;
    io_memberships m = {.n = 0};
    const int64_t n = s->nodes.n + s->sides.n;
    int32_t *number = pl_alloc(n, sizeof *number);
    int status = number ? io_memberships_begin(&m, r->model->n_nodes, r->error)
                        : pl_fail_memory(r->error, "the sets of nodes");
    for (int pass = 0; pass < 2 && !status; pass++) {
        for (int64_t k = 0; k < s->nodes.n && !status; k++)
            status = take_nodes(s, k, &m);
        for (int64_t k = 0; k < s->sides.n && !status; k++)
            status = s->has_others[k] ? take_sides(s, k, &m) : PLANISH_OK;
        if (pass == 0 && !status)
            status = io_memberships_counted(&m, r->error);
    }
    for (int64_t k = 0; k < n && !status; k++)
        number[k] = k < s->nodes.n ? s->nodes.number[k] : s->sides.number[k - s->nodes.n];
    if (!status) {
        io_memberships_renumber(&m, number);
        status = io_memberships_of_nodes(&m, r->model, r->error);
    }
    io_memberships_destroy(&m);
    pl_free(number);
    return status;
}

/* ---- numbers -------------------------------------------------------------------------------- */

/** Add the label k of blocks or sets to a list. */
static void add_twin(io_twin *list, int64_t *n, const exodus_labels *labels, int64_t k,
                     unsigned dims) {
    list[*n] = (io_twin){labels->number[k], dims, netcdf_text_slice(&labels->names, k), *n,
                         &labels->number[k]};
    (*n)++;
}

/** Give sets whose numbers blocks or other sets have, too, numbers of their own. */
static int number_sets(sets *s) {
    exodus_reader *r = s->r;
    int64_t n = 0;
    io_twin *twin = pl_alloc(r->n_blocks + s->nodes.n + s->sides.n, sizeof *twin);
    if (!twin)
        return pl_fail_memory(r->error, "the numbers of sets");
    for (int64_t k = 0; k < r->n_blocks; k++)
        add_twin(twin, &n, &r->labels, k, r->block[k].list ? 1u << r->block[k].dim : 0);
    for (int64_t k = 0; k < s->nodes.n; k++)
        add_twin(twin, &n, &s->nodes, k, 1);
    for (int64_t k = 0; k < s->sides.n; k++)
        add_twin(twin, &n, &s->sides, k, 1u << (s->dim - 1) | s->has_others[k]);
    const int status = io_twins_number(r->model, twin, n, r->n_blocks, r->error);
    pl_free(twin);
    return status;
}

int exodus_read_sets(exodus_reader *r) {
    io_model *model = r->model;
    sets s = {.r = r, .dim = io_model_dim(model)};
    int status = io_complete_mids(model, r->error);
    /* Blocks of lower dimension hold their nodes, and side sets do not. */
    io_model_hold_lower(model, s.dim);
    model->lower_are_held = 1;
    if (!status)
        status = exodus_labels_read(r, "ns_prop1", "ns_names", &s.nodes);
    if (!status)
        status = exodus_labels_read(r, "ss_prop1", "ss_names", &s.sides);
    if (!status && s.nodes.n + s.sides.n > INT32_MAX - 1)
        status = netcdf_fail(r->file, "ss_prop1", "there are too many sets");
    s.has_others = status ? NULL : pl_alloc_zero(s.sides.n, 1);
    if (!status && !s.has_others)
        status = pl_fail_memory(r->error, "the side sets");
    for (int64_t k = 0; k < s.sides.n && !status; k++)
        status = take_sides(&s, k, NULL);
    if (!status)
        status = number_sets(&s);
    /* Before there are facets: sides of shells are found in the lists of flat elements. */
    if (!status && s.nodes.n + s.sides.n > 0)
        status = make_node_entities(&s);
    if (!status)
        status = make_facets(&s);
    for (int64_t k = 0; k < s.nodes.n && !status; k++)
        status = exodus_labels_name(r, &s.nodes, k, 0);
    for (int64_t k = 0; k < s.sides.n && !status; k++) {
        status = exodus_labels_name(r, &s.sides, k, s.dim - 1);
        if (!status && s.has_others[k])
            status = exodus_labels_name(r, &s.sides, k, 0);
    }
    pl_free(s.has_others);
    pl_free(s.side);
    exodus_labels_release(&s.nodes);
    exodus_labels_release(&s.sides);
    return status;
}
