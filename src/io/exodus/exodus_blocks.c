/* exodus_blocks: blocks of elements of Exodus files. A block has one type, which a name and the number
 * of nodes tell. Those without a planish_cell_type hold their nodes.
 */
#include "io/exodus/exodus_reader.h"

#include "base/memory.h"
#include "base/status.h"
#include "io/core/elements.h"
#include "io/core/records.h"

#include <string.h>

/* ---- types of elements ---------------------------------------------------------------------- */

enum { TYPE_NAME_SIZE = 40, MOST_NODES = 27 };

/** Families of types, by the first letters of their names. */
static const struct {
    char name[10];
    uint8_t shape, corners, most; /* most: nodes up to second order */
} families[] = {
    {"HEXSHELL", IO_ANY_SHAPE, 8, 8}, /* solid shells: as thick as the mesh says */
    {"HEX", IO_HEXAHEDRON, 8, 27},    {"TET", IO_TETRAHEDRON, 4, 15},  {"TRI", IO_TRIANGLE, 3, 7},
    {"QUA", IO_QUADRILATERAL, 4, 9},  {"SHE", IO_QUADRILATERAL, 4, 9}, {"WED", IO_PRISM, 6, 21},
    {"PYR", IO_PYRAMID, 5, 19},       {"BAR", IO_LINE, 2, 3},          {"BEA", IO_LINE, 2, 3},
    {"TRU", IO_LINE, 2, 3},           {"ROD", IO_LINE, 2, 3},          {"EDG", IO_LINE, 2, 3},
    {"SPR", IO_LINE, 2, 3},           {"SPH", IO_POINT, 1, 1},         {"CIR", IO_POINT, 1, 1},
    {"NSI", IO_POLYGON, 0, 0}};
enum { N_FAMILIES = sizeof families / sizeof *families };

static int begins_with(const char *text, const char *name) {
    while (*name && io_upper(*text) == *name)
        text++, name++;
    return *name == '\0';
}

/** Find the type that a name in the file and a number of nodes tell, in a mesh of so many columns. A
 *  shell of 3, 6 or 7 nodes is a triangle; in a plane shells of 2 and 3 nodes are lines. */
static io_element_type find_type(const char *name, int64_t nodes, int columns) {
    io_element_type type = {name, IO_ANY_SHAPE, 1, nodes <= MOST_NODES ? (uint16_t)nodes : 0};
    int k = 0;
    while (k < N_FAMILIES && !begins_with(name, families[k].name))
        k++;
    if (k == N_FAMILIES)
        return type;
    int corners = families[k].corners, most = families[k].most;
    type.shape = families[k].shape;
    if (begins_with(name, "SHE") && (nodes == 2 || (nodes == 3 && columns == 2))) {
        type.shape = IO_LINE;
        corners = 2;
        most = 3;
    } else if (begins_with(name, "SHE") && (nodes == 3 || nodes == 6 || nodes == 7)) {
        type.shape = IO_TRIANGLE;
        corners = 3;
        most = 7;
    }
    type.order = nodes < corners ? 0 : nodes == corners ? 1 : nodes <= most ? 2 : 3;
    return type;
}

/* ---- elements of a block -------------------------------------------------------------------- */

/** A block while its elements are read. */
typedef struct block_walk {
    exodus_reader *r;
    exodus_block *block;
    exodus_name name; /* of the list of nodes */
    io_hdf5_integers nodes;
    int64_t width; /* nodes of an element */
    io_element_type type;
    int cell_type;   /* of others, or 0 */
    int64_t node_at; /* where the nodes of the first of others begin */
} block_walk;

static int64_t number_of(const exodus_reader *r, int64_t element) {
    return element < r->numbers.n ? io_hdf5_integer(&r->numbers, element) : element + 1;
}

/** Read elements begin .. end-1 of a block: io_records_fn. */
static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    block_walk *w = context;
    io_model *model = w->r->model;
    const exodus_block *block = w->block;
    const int dim = block->dim, width = (int)w->width;
    io_cells *cells = io_model_cells(model, dim);
    int status = PLANISH_OK;
    (void)cursor;
    for (int64_t i = begin; i < end && !status; i++) {
        int32_t node[MOST_NODES];
        const int64_t at = block->at + i, number = number_of(w->r, block->first + i);
        for (int j = 0; j < width && !status; j++)
            status =
                exodus_take_node(w->r, w->name.text, &w->nodes, i * width + j, &node[j], error);
        if (status)
            return status;
        if (w->cell_type) {
            io_others_set(model, at, w->node_at + i * width, w->cell_type, node, number);
            continue;
        }
        memcpy(cells->nodes + at * (dim + 1), node, (size_t)(dim + 1) * sizeof *node);
        cells->number[at] = number;
        if (width > dim + 1)
            io_cells_set_mids(model, dim, at, node);
    }
    return status;
}

/** Hold nodes begin .. end-1 of a list: io_records_fn. */
static int hold_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    block_walk *w = context;
    int status = PLANISH_OK;
    (void)cursor;
    for (int64_t i = begin; i < end && !status; i++) {
        int32_t node;
        status = exodus_take_node(w->r, w->name.text, &w->nodes, i, &node, error);
        if (!status)
            io_hold_node(w->r->model, node, io_element_reason(&w->type));
    }
    return status;
}

/** Let n records of the list of nodes be read, by several threads. */
static int read_records(block_walk *w, int64_t n, int64_t width, io_records_fn *read) {
    const int64_t size = width * w->nodes.size;
    if (n == 0)
        return PLANISH_OK;
    io_cursor cursor = {w->nodes.data, w->nodes.data + n * size};
    return io_binary_records(io_model_threads(w->r->model), &cursor, n, size, read, w, w->r->error);
}

/** Read the elements of a block into their list; entity: of all. */
static int store_elements(block_walk *w, int32_t entity) {
    io_model *model = w->r->model;
    exodus_block *block = w->block;
    const int dim = block->dim, is_other = w->cell_type != 0;
    io_cells *cells = io_model_cells(model, dim);
    io_others *others = io_model_others(model, dim);
    int status = is_other ? io_others_reserve(model, dim, block->n, w->nodes.n, 1, w->r->error)
                          : io_cells_reserve(model, dim, block->n, 1, 1, w->r->error);
    if (!status && !is_other && w->width > dim + 1)
        status = io_cells_reserve_mids(model, dim, w->r->error);
    if (status)
        return status;
    block->list = is_other ? io_others_list(dim) : dim;
    block->at = is_other ? others->n : cells->n;
    w->node_at = others->n_nodes;
    status = read_records(w, block->n, w->width, read_elements);
    int32_t *of = is_other ? others->entity : cells->entity;
    for (int64_t i = 0; i < block->n && !status; i++)
        of[block->at + i] = entity;
    if (status)
        return status;
    *(is_other ? &others->n : &cells->n) += block->n;
    others->n_nodes += is_other ? w->nodes.n : 0;
    return PLANISH_OK;
}

/* ---- blocks --------------------------------------------------------------------------------- */

/** Find the size of a block: elements, and nodes of each (0: they differ), from its list of nodes. */
static int find_size(block_walk *w, int64_t k) {
    exodus_reader *r = w->r;
    netcdf_shape nodes, counts;
    int status = netcdf_shape_of(r->file, w->name.text, &nodes);
    if (!status)
        status = netcdf_shape_of(r->file, exodus_name_of("ebepecnt", k).text, &counts);
    if (status)
        return status;
    if (nodes.is_there && nodes.rank == 2) {
        w->block->n = nodes.dims[0];
        w->width = nodes.dims[1];
    } else if (counts.is_there) { /* polygons, or polyhedra, which have no list of nodes */
        w->block->n = counts.n;
    } else if (nodes.is_there) {
        w->block->n = nodes.n;
        w->width = 1;
    } else { /* it must be empty */
        int64_t n = 0;
        status = netcdf_dimension(r->file, exodus_name_of("num_el_in_blk", k).text, &n);
        if (!status && n > 0)
            status = netcdf_fail(r->file, w->name.text,
                                 "the nodes of %lld elements are missing; the file may be damaged",
                                 (long long)n);
    }
    if (!status && (w->block->n < 0 || w->block->n > INT32_MAX - r->n_elements))
        return netcdf_fail(r->file, w->name.text,
                           "there are more elements than the %lld that planish can handle",
                           (long long)INT32_MAX);
    return status;
}

static int read_block(exodus_reader *r, int64_t k) {
    char name[TYPE_NAME_SIZE];
    exodus_block block = {.first = r->n_elements};
    block_walk w = {.r = r, .block = &block, .name = exodus_name_of("connect", k)};
    int status = find_size(&w, k);
    if (!status)
        status = netcdf_text_attribute(r->file, w.name.text, "elem_type", name, sizeof name);
    if (!status && block.n > 0)
        status = netcdf_integers_read(r->file, w.name.text, &w.nodes);
    if (status)
        return status;
    w.type = find_type(name, w.width, r->model->columns);
    block.dim = io_element_dim(&w.type);
    block.is_shell = block.dim == 2 && (r->model->columns == 3 || begins_with(name, "SHE") ||
                                        begins_with(name, "TRIS"));
    const io_element_treatment use = io_element_use(&w.type);
    w.cell_type = io_element_other(&w.type);
    if (begins_with(name, "BEX")) {
        status =
            netcdf_fail(r->file, w.name.text,
                        "elements of type %s (Bezier extraction) are not read: their nodes are "
                        "those of a spline",
                        name);
    } else if (use == IO_REFUSE) {
        status = netcdf_fail(r->file, w.name.text, "type %s of %lld nodes: " IO_OF_THIRD_ORDER,
                             name, (long long)w.width);
    } else if (w.nodes.n > 0 && (use == IO_KEEP || w.cell_type)) {
        const int32_t entity =
            io_model_entity(r->model, block.dim, (int32_t)k + 1, 1, &r->labels.number[k], r->error);
        status = entity < 0 ? entity : store_elements(&w, entity);
        if (!status)
            status = exodus_labels_name(r, &r->labels, k, block.dim);
    } else {
        status = read_records(&w, w.nodes.n, 1, hold_nodes);
    }
    if (use != IO_KEEP)
        io_element_count(r->model, &w.type, block.n);
    netcdf_integers_release(&w.nodes);
    if (!status && !pl_append(&r->block, &r->n_blocks, &r->block_capacity, &block, sizeof block))
        status = pl_fail_memory(r->error, "the blocks of elements");
    r->n_elements += block.n;
    return status;
}

/** Hold the nodes of polyhedra, whose faces are in blocks of their own. */
static int hold_faces(exodus_reader *r) {
    exodus_labels faces = {0};
    netcdf_shape shape;
    int has_polyhedra = 0, status = PLANISH_OK;
    for (int64_t k = 0; k < r->n_blocks && !status && !has_polyhedra; k++) {
        status = netcdf_shape_of(r->file, exodus_name_of("facconn", k).text, &shape);
        has_polyhedra = shape.is_there;
    }
    if (!status && has_polyhedra)
        status = exodus_labels_read(r, "fa_prop1", "fa_names", &faces);
    for (int64_t k = 0; k < faces.n && !status; k++) {
        block_walk w = {.r = r, .name = exodus_name_of("fbconn", k), .type = {.shape = IO_POLYGON}};
        status = netcdf_integers_read(r->file, w.name.text, &w.nodes);
        if (!status)
            status = read_records(&w, w.nodes.n, 1, hold_nodes);
        netcdf_integers_release(&w.nodes);
    }
    exodus_labels_release(&faces);
    return status;
}

/** Check that no two blocks have the same number: they would be one region. */
static int check_numbers(exodus_reader *r) {
    const exodus_labels *labels = &r->labels;
    io_numbers *table = NULL;
    int64_t *number = pl_alloc(labels->n, sizeof *number);
    for (int64_t k = 0; number && k < labels->n; k++)
        number[k] = labels->number[k];
    const int status = number ? io_numbers_create(r->model->input.path, "element block", number,
                                                  labels->n, &table, r->error)
                              : pl_fail_memory(r->error, "the blocks of elements");
    io_numbers_destroy(table);
    pl_free(number);
    return status;
}

int exodus_read_blocks(exodus_reader *r) {
    static const char map[] = "elem_num_map";
    r->model->node_order = exodus_node_orders;
    int status = exodus_labels_read(r, "eb_prop1", "eb_names", &r->labels);
    if (!status)
        status = check_numbers(r);
    if (!status)
        status = netcdf_integers_read(r->file, map, &r->numbers);
    for (int64_t k = 0; k < r->labels.n && !status; k++)
        status = read_block(r, k);
    if (!status && r->numbers.n > 0 && r->numbers.n != r->n_elements)
        status = netcdf_fail(r->file, map, "%lld numbers for %lld elements",
                             (long long)r->numbers.n, (long long)r->n_elements);
    return status ? status : hold_faces(r);
}
