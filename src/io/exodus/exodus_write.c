/* exodus_write: a mesh as an Exodus II file in classic netCDF.
 *
 * Cells of one type, entity and region are a block. Facets that are sides of elements are in side
 * sets; others are blocks, and so are lines in space. Arrays of numbers are variables at one time
 * step, one for each component.
 */
#include "io/exodus/exodus_write.h"

#include "io/core/data.h"
#include "io/exodus/exodus_format.h"
#include "io/exodus/exodus_groups.h"
#include "io/netcdf/netcdf_write.h"

#include "base/memory.h"
#include "base/status.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* TETRA, WEDGE and PYRAMID are the names that all readers know, meshio among them; the numbers of nodes
 * tell the rest. In space QUAD is SHELL: its sides begin with its two faces. */
static const io_view_type types[] = {{PLANISH_CELL_LINE, "BAR2", 0},
                                     {PLANISH_CELL_LINE3, "BAR3", 0},
                                     {PLANISH_CELL_TRIANGLE, "TRI3", 0},
                                     {PLANISH_CELL_TRIANGLE6, "TRI6", 0},
                                     {PLANISH_CELL_QUADRILATERAL, "QUAD4", 0},
                                     {PLANISH_CELL_QUADRILATERAL8, "QUAD8", 0},
                                     {PLANISH_CELL_QUADRILATERAL9, "QUAD9", 0},
                                     {PLANISH_CELL_TETRAHEDRON, "TETRA", 0},
                                     {PLANISH_CELL_TETRAHEDRON10, "TETRA10", 0},
                                     {PLANISH_CELL_PYRAMID, "PYRAMID", 0},
                                     {PLANISH_CELL_PYRAMID13, "PYRAMID13", 0},
                                     {PLANISH_CELL_PYRAMID14, "PYRAMID14", 0},
                                     {PLANISH_CELL_WEDGE, "WEDGE", 0},
                                     {PLANISH_CELL_WEDGE15, "WEDGE15", 0},
                                     {PLANISH_CELL_WEDGE18, "WEDGE18", 0},
                                     {PLANISH_CELL_HEXAHEDRON, "HEX8", 0},
                                     {PLANISH_CELL_HEXAHEDRON20, "HEX20", 0},
                                     {PLANISH_CELL_HEXAHEDRON27, "HEX27", 0},
                                     {0, NULL, 0}};

/* Names are at least that long in all files, and at most so, as the Exodus library says. */
enum { LEAST_NAME = 32, MOST_NAME = 256, TYPE_NAME_SIZE = 16 };

static const char axes[][2] = {"x", "y", "z"};

/** A block that is written. */
typedef struct out_block {
    const io_view_block *of;
    const io_view_type *type;
    char type_name[TYPE_NAME_SIZE];
    int64_t n;     /* elements: all of the block, but facets that are sides */
    int64_t facet; /* index of its first facet; -1: it is none of facets */
    int32_t group; /* that it is called by, or -1, */
    int is_first;  /* which no block before it is */
    int32_t id;
    int dim; /* of the file: its elements */
} out_block;

/** A component of a field, which is a variable. */
typedef struct out_component {
    const io_view_field *field;
    int at;             /* of the values */
    const char *suffix; /* of its name */
} out_component;

/** What a variable of the file has. */
typedef enum out_kind {
    OUT_TIME,
    OUT_ONES,
    OUT_BLOCK_IDS,
    OUT_BLOCK_NAMES,
    OUT_SET_IDS, /* of: 0 node sets, 1 side sets; as OUT_SET_NAMES */
    OUT_SET_NAMES,
    OUT_COORDINATES, /* of: the axis */
    OUT_AXIS_NAMES,
    OUT_NODE_NUMBERS,
    OUT_ELEMENT_NUMBERS,
    OUT_NODES,     /* of: the block */
    OUT_SET_NODES, /* of: the set; as the next ones */
    OUT_SET_ELEMENTS,
    OUT_SET_SIDES,
    OUT_COMPONENT_NAMES, /* of: 0 of nodes, 1 of elements */
    OUT_TRUTH,
    OUT_NODE_VALUES,   /* of: the component */
    OUT_ELEMENT_VALUES /* of: the component and the block */
} out_kind;

typedef struct exodus_out {
    const io_view *view;
    netcdf_out file;
    io_view_blocks blocks;
    exodus_facets facets;
    exodus_groups sets[2]; /* of nodes; of sides */
    out_block *block;      /* [n_blocks] owned */
    int64_t n_blocks, capacity;
    int64_t n_elements;
    out_component *component[2]; /* of nodes; of elements: [n_components] owned */
    int64_t n_components[2];
    int64_t component_capacity[2];
    planish_data data; /* of the field that was asked for last */
    const io_view_field *loaded;
    int columns, is_float;
    int has_numbers[2]; /* nodes, elements: other ones than 1, 2, ... */
    int64_t name_size;  /* bytes of each name */
} exodus_out;

/* ---- blocks --------------------------------------------------------------------------------- */

/** Find the next cell of a block that is an element of the file, from cell *i on, and its index.
 *  Returns 0 at the end. */
static int next_cell(const exodus_out *e, const out_block *block, int64_t *i, int64_t *index,
                     io_view_cell *cell) {
    const io_view_block *of = block->of;
    while (*i < of->n && block->facet >= 0 && e->facets.side[block->facet + *i].element > 0)
        ++*i;
    if (*i >= of->n)
        return 0;
    *index = of->cell[(*i)++];
    io_view_cell_at(e->view, *index, cell);
    return 1;
}

/** Add a block, if any of its cells is an element. facet: index of its first one, or -1. */
static int add_block(exodus_out *e, const io_view_block *of, int64_t facet) {
    out_block block = {.of = of,
                       .type = io_view_find_type(types, of->type),
                       .n = of->n,
                       .facet = facet,
                       .group = exodus_next_group(e->view, of->entity, -1)};
    const int is_shell = e->columns == 3 && strncmp(block.type->name, "QUAD", 4) == 0;
    snprintf(block.type_name, sizeof block.type_name, "%s%s", is_shell ? "SHELL" : "",
             block.type->name + (is_shell ? 4 : 0));
    for (int64_t i = 0; i < of->n && facet >= 0; i++)
        block.n -= e->facets.side[facet + i].element > 0;
    e->n_elements += block.n;
    return block.n == 0 ||
           pl_append(&e->block, &e->n_blocks, &e->capacity, &block, sizeof block) != NULL;
}

/** Give the blocks their ids, and find the first ones of each group. */
static int number_blocks(exodus_out *e, planish_error *error) {
    int64_t *wanted = pl_alloc(e->n_blocks, sizeof *wanted);
    int32_t *id = pl_alloc(e->n_blocks, sizeof *id);
    uint8_t *is_used = pl_alloc_zero(e->view->model->n_groups, 1);
    int status = wanted && id && is_used ? PLANISH_OK : pl_fail_memory(error, "blocks");
    for (int64_t b = 0; b < e->n_blocks && !status; b++)
        wanted[b] = e->block[b].of->reference;
    if (!status)
        status = exodus_give_ids(wanted, e->n_blocks, id, error);
    for (int64_t b = 0; b < e->n_blocks && !status; b++) {
        out_block *block = &e->block[b];
        block->id = id[b];
        block->is_first = block->group >= 0 && !is_used[block->group];
        if (block->group >= 0)
            is_used[block->group] = 1;
    }
    pl_free(wanted);
    pl_free(id);
    pl_free(is_used);
    return status;
}

static int find_blocks(exodus_out *e, planish_error *error) {
    int64_t facet = 0;
    int is_done = 1;
    for (int64_t b = 0; b < e->blocks.n && is_done; b++) {
        const io_view_block *block = &e->blocks.block[b];
        const int is_of_facets = block->dim == e->facets.dim;
        is_done = add_block(e, block, is_of_facets ? facet : -1);
        facet += is_of_facets ? block->n : 0;
    }
    return is_done ? number_blocks(e, error) : pl_fail_memory(error, "blocks of elements");
}

/** Make the name of a block: its group's, with its id if another block has that name. */
static void name_block(const exodus_out *e, const out_block *block, char name[MOST_NAME + 1]) {
    name[0] = '\0';
    if (block->group < 0)
        return;
    const char *of_group = e->view->model->group[block->group].name;
    if (block->is_first)
        snprintf(name, MOST_NAME + 1, "%s", of_group);
    else
        snprintf(name, MOST_NAME + 1, "%.240s_%" PRId32, of_group, block->id);
}

/* ---- components ----------------------------------------------------------------------------- */

/** Add the components of a field, by the names and in the order that SEACAS (and so
 *  ParaView) joins to vectors and symmetric tensors. */
static int add_components(exodus_out *e, const io_view_field *field) {
    static const char suffixes[IO_MOST_WIDTH + 1][IO_MOST_WIDTH][4] = {
        [1] = {""},
        [2] = {"_x", "_y"},
        [3] = {"_x", "_y", "_z"},
        [4] = {"_xx", "_xy", "_yx", "_yy"},
        [5] = {"_1", "_2", "_3", "_4", "_5"},
        [6] = {"_xx", "_xy", "_yy", "_zx", "_yz", "_zz"},
        [7] = {"_1", "_2", "_3", "_4", "_5", "_6", "_7"},
        [8] = {"_1", "_2", "_3", "_4", "_5", "_6", "_7", "_8"},
        [9] = {"_xx", "_xy", "_xz", "_yx", "_yy", "_yz", "_zx", "_zy", "_zz"}};
    static const uint8_t as_seacas[] = {0, 2, 5, 1, 4, 3}; /* xx, yy, zz, xy, yz, zx */
    const int k = field->of_elements;
    for (int i = 0; i < field->width; i++) {
        const int at = field->width == 6 ? as_seacas[i] : i;
        const out_component component = {field, at, suffixes[field->width][at]};
        if (!pl_append(&e->component[k], &e->n_components[k], &e->component_capacity[k], &component,
                       sizeof component))
            return 0;
    }
    return 1;
}

static int find_components(exodus_out *e, planish_error *error) {
    int is_done = 1;
    for (int i = 0; i < e->view->n_fields && is_done; i++)
        is_done = add_components(e, &e->view->field[i]);
    return is_done ? PLANISH_OK : pl_fail_memory(error, "arrays to be written");
}

/** Read the values of a field, if they are not there yet. Returns 0 after an error. */
static int load(exodus_out *e, const io_view_field *field) {
    io_writer *writer = &e->file.writer;
    if (e->loaded == field)
        return 1;
    planish_data_free(&e->data);
    e->loaded = NULL;
    const int status = e->view->load(e->view->file, field, &e->data, writer->error);
    if (status)
        writer->status = status;
    else
        e->loaded = field;
    return !status;
}

/* ---- what is written ------------------------------------------------------------------------ */

/** Return whether the nodes all are in the plane of x and y, at z = 0. */
static int is_plane(const io_model *model) {
    int is = model->dim == 2 && model->written == 2;
    for (int64_t i = 0; i < model->n_nodes && model->z && is; i++)
        is = model->z[i] == 0;
    return is;
}

/** Return the number of the next element of a block as next_cell finds it; 0 at the end. */
static int64_t next_number(const exodus_out *e, const out_block *block, int64_t *i) {
    io_view_cell cell;
    int64_t index;
    return next_cell(e, block, i, &index, &cell) ? cell.number : 0;
}

/** Find out whether nodes and elements have other numbers than 1, 2, ... that can be kept. Facets that
 *  are sides have none. */
static int look_at_numbers(exodus_out *e, planish_error *error) {
    int64_t *number = pl_alloc(e->n_elements, sizeof *number), n = 0, next;
    if (!number)
        return pl_fail_memory(error, "numbers of elements");
    for (int64_t i = 0; i < e->view->model->n_nodes; i++)
        e->has_numbers[0] |= io_view_node_number(e->view, i) != i + 1;
    for (int64_t b = 0; b < e->n_blocks; b++)
        for (int64_t i = 0; (next = next_number(e, &e->block[b], &i)) > 0; n++) {
            number[n] = next;
            e->has_numbers[1] |= next != n + 1;
        }
    e->has_numbers[1] &= n == e->n_elements && io_view_are_numbers(number, n);
    pl_free(number);
    return PLANISH_OK;
}

/** Find the room that names need. */
static void measure_names(exodus_out *e) {
    enum { LONGEST_SUFFIX = 12 };
    size_t most = LEAST_NAME;
    for (int32_t g = 0; g < e->view->model->n_groups; g++) {
        const size_t length = strlen(e->view->model->group[g].name) + LONGEST_SUFFIX;
        most = length > most ? length : most;
    }
    for (int i = 0; i < e->view->n_fields; i++) {
        const size_t length = strlen(e->view->field[i].name) + LONGEST_SUFFIX;
        most = length > most ? length : most;
    }
    e->name_size = (int64_t)(most < MOST_NAME ? most : MOST_NAME) + 1;
}

static int prepare(exodus_out *e, planish_error *error) {
    int status = io_view_blocks_make(e->view, &e->blocks, error);
    if (!status)
        status = exodus_facets_find(e->view, &e->blocks, types, e->columns == 3, &e->facets, error);
    if (!status)
        status = exodus_groups_of_nodes(e->view, &e->sets[0], error);
    if (!status)
        status = exodus_groups_of_facets(e->view, &e->blocks, &e->facets, &e->sets[1], error);
    if (!status)
        status = find_blocks(e, error);
    if (!status)
        status = find_components(e, error);
    if (!status)
        status = look_at_numbers(e, error);
    measure_names(e);
    return status;
}

/* ---- dimensions and variables --------------------------------------------------------------- */

/** Indices of the file's dimensions. */
typedef struct out_dims {
    int time, name, four, columns, nodes, elements, blocks, sets[2], components[2];
} out_dims;

/** Add a dimension of block or set k (from 0); of all: k is -1. Without a length there is none. */
static int dimension(exodus_out *e, const char *name, int64_t k, int64_t length) {
    return length > 0
               ? netcdf_out_dimension(&e->file, k < 0 ? name : exodus_name_of(name, k).text, length)
               : -1;
}

/** Add a variable of one or two (dim2 not -1) dimensions. */
static void add(exodus_out *e, const char *name, netcdf_type type, int dim1, int dim2,
                out_kind kind, int64_t of1, int64_t of2) {
    netcdf_out_variable v = {.type = type,
                             .n_dims = dim2 < 0 ? 1 : 2,
                             .dim = {dim1, dim2},
                             .kind = (int)kind,
                             .of = {of1, of2}};
    snprintf(v.name, sizeof v.name, "%s", name);
    if (kind == OUT_BLOCK_IDS || kind == OUT_SET_IDS) {
        v.attribute = "name";
        v.text = "ID";
    } else if (kind == OUT_NODES) {
        v.attribute = "elem_type";
        v.text = e->block[of1].type_name;
    }
    netcdf_out_variable_add(&e->file, &v);
}

static out_dims add_dimensions(exodus_out *e) {
    enum { STRING = 33, LINE = 81, FOUR = 4 };
    out_dims d = {0};
    dimension(e, "len_string", -1, STRING);
    dimension(e, "len_line", -1, LINE);
    dimension(e, "four", -1, FOUR);
    d.name = dimension(e, "len_name", -1, e->name_size);
    d.time = netcdf_out_dimension(&e->file, "time_step", 0);
    d.columns = dimension(e, "num_dim", -1, e->columns);
    d.nodes = dimension(e, "num_nodes", -1, e->view->model->n_nodes);
    d.elements = dimension(e, "num_elem", -1, e->n_elements);
    d.blocks = dimension(e, "num_el_blk", -1, e->n_blocks);
    d.sets[0] = dimension(e, "num_node_sets", -1, e->sets[0].n);
    d.sets[1] = dimension(e, "num_side_sets", -1, e->sets[1].n);
    d.components[0] = dimension(e, "num_nod_var", -1, e->n_components[0]);
    d.components[1] = dimension(e, "num_elem_var", -1, e->n_components[1]);
    return d;
}

static void add_mesh(exodus_out *e, const out_dims *d) {
    static const char *const places[] = {"coordx", "coordy", "coordz"};
    add(e, "eb_status", NETCDF_INT, d->blocks, -1, OUT_ONES, e->n_blocks, 0);
    add(e, "eb_prop1", NETCDF_INT, d->blocks, -1, OUT_BLOCK_IDS, 0, 0);
    add(e, "eb_names", NETCDF_CHAR, d->blocks, d->name, OUT_BLOCK_NAMES, 0, 0);
    for (int axis = 0; axis < e->columns; axis++)
        add(e, places[axis], e->is_float ? NETCDF_FLOAT : NETCDF_DOUBLE, d->nodes, -1,
            OUT_COORDINATES, axis, 0);
    add(e, "coor_names", NETCDF_CHAR, d->columns, d->name, OUT_AXIS_NAMES, 0, 0);
    if (e->has_numbers[0])
        add(e, "node_num_map", NETCDF_INT, d->nodes, -1, OUT_NODE_NUMBERS, 0, 0);
    if (e->has_numbers[1])
        add(e, "elem_num_map", NETCDF_INT, d->elements, -1, OUT_ELEMENT_NUMBERS, 0, 0);
    for (int64_t b = 0; b < e->n_blocks; b++) {
        const int type = e->block[b].type->type;
        const int nodes =
            io_simplex_dim(type) == 1 ? 2 + io_has_mids(type) : io_cell_type_nodes(type);
        const int dim = dimension(e, "num_el_in_blk", b, e->block[b].n);
        e->block[b].dim = dim;
        add(e, exodus_name_of("connect", b).text, NETCDF_INT, dim,
            dimension(e, "num_nod_per_el", b, nodes), OUT_NODES, b, 0);
    }
}

static void add_sets(exodus_out *e, const out_dims *d) {
    static const char *const names[2][4] = {{"ns_status", "ns_prop1", "ns_names", "num_nod_ns"},
                                            {"ss_status", "ss_prop1", "ss_names", "num_side_ss"}};
    for (int k = 0; k < 2; k++) {
        const int dim = d->sets[k];
        if (dim < 0)
            continue;
        add(e, names[k][0], NETCDF_INT, dim, -1, OUT_ONES, e->sets[k].n, 0);
        add(e, names[k][1], NETCDF_INT, dim, -1, OUT_SET_IDS, k, 0);
        add(e, names[k][2], NETCDF_CHAR, dim, d->name, OUT_SET_NAMES, k, 0);
        for (int64_t i = 0; i < e->sets[k].n; i++) {
            const int members = dimension(e, names[k][3], i, e->sets[k].group[i].n);
            if (k == 0) {
                add(e, exodus_name_of("node_ns", i).text, NETCDF_INT, members, -1, OUT_SET_NODES, i,
                    0);
                continue;
            }
            add(e, exodus_name_of("elem_ss", i).text, NETCDF_INT, members, -1, OUT_SET_ELEMENTS, i,
                0);
            add(e, exodus_name_of("side_ss", i).text, NETCDF_INT, members, -1, OUT_SET_SIDES, i, 0);
        }
    }
}

/** Return whether a block has values of elements: those of the mesh's dimension have. */
static int has_values(const exodus_out *e, int64_t b) {
    return e->block[b].of->dim > e->facets.dim;
}

static void add_values(exodus_out *e, const out_dims *d) {
    static const char *const names[] = {"name_nod_var", "name_elem_var"};
    for (int k = 0; k < 2; k++)
        if (e->n_components[k] > 0)
            add(e, names[k], NETCDF_CHAR, d->components[k], d->name, OUT_COMPONENT_NAMES, k, 0);
    if (e->n_components[1] > 0)
        add(e, "elem_var_tab", NETCDF_INT, d->blocks, d->components[1], OUT_TRUTH, 0, 0);
    add(e, "time_whole", NETCDF_DOUBLE, d->time, -1, OUT_TIME, 0, 0);
    for (int64_t i = 0; i < e->n_components[0]; i++)
        add(e, exodus_name_of("vals_nod_var", i).text, NETCDF_DOUBLE, d->time, d->nodes,
            OUT_NODE_VALUES, i, 0);
    for (int64_t i = 0; i < e->n_components[1]; i++)
        for (int64_t b = 0; b < e->n_blocks && has_values(e, b); b++)
            add(e, exodus_values_name(1, i, b).text, NETCDF_DOUBLE, d->time, e->block[b].dim,
                OUT_ELEMENT_VALUES, i, b);
}

static void describe(exodus_out *e) {
    enum { LARGE = 1 }; /* each coordinate is a variable of its own */
    static const float version = 5.14f;
    netcdf_out *file = &e->file;
    netcdf_out_float(file, "api_version", version);
    netcdf_out_float(file, "version", version);
    netcdf_out_integer(file, "floating_point_word_size", e->is_float ? 4 : 8);
    netcdf_out_integer(file, "file_size", LARGE);
    netcdf_out_integer(file, "maximum_name_length", (int32_t)e->name_size - 1);
    netcdf_out_integer(file, "int64_status", 0);
    netcdf_out_text(file, "title", "written by planish");
    file->n_records = e->n_components[0] + e->n_components[1] > 0;
    const out_dims dims = add_dimensions(e);
    add_mesh(e, &dims);
    add_sets(e, &dims);
    add_values(e, &dims);
}

/* ---- values --------------------------------------------------------------------------------- */

static void put_coordinates(exodus_out *e, int64_t axis) {
    double place[3];
    for (int64_t i = 0; i < e->view->model->n_nodes; i++) {
        io_view_place(e->view, i, place);
        if (e->is_float)
            netcdf_put_float(&e->file, (float)place[axis]);
        else
            netcdf_put_double(&e->file, place[axis]);
    }
}

static void put_element_numbers(exodus_out *e) {
    int64_t number;
    for (int64_t b = 0; b < e->n_blocks; b++)
        for (int64_t i = 0; (number = next_number(e, &e->block[b], &i)) > 0;)
            netcdf_put_integer(&e->file, (int32_t)number);
}

static void put_nodes(exodus_out *e, const out_block *block) {
    io_view_cell cell;
    int64_t index;
    for (int64_t i = 0; next_cell(e, block, &i, &index, &cell);) {
        io_view_fit_cell(e->view, block->type, exodus_node_orders, &cell);
        for (int k = 0; k < cell.n_nodes; k++)
            netcdf_put_integer(&e->file, cell.node[k] + 1);
    }
}

/** Put the members of a set as a kind says: nodes, or elements or sides of facets. */
static void put_members(exodus_out *e, out_kind kind, int64_t set) {
    const exodus_groups *sets = &e->sets[kind != OUT_SET_NODES];
    const exodus_member *member = sets->member + sets->group[set].first;
    for (int64_t i = 0; i < sets->group[set].n; i++)
        netcdf_put_integer(&e->file, kind == OUT_SET_SIDES ? member[i].side : member[i].place);
}

static void put_names(exodus_out *e, out_kind kind, int64_t of) {
    char name[MOST_NAME + 1];
    for (int64_t b = 0; b < e->n_blocks && kind == OUT_BLOCK_NAMES; b++) {
        name_block(e, &e->block[b], name);
        netcdf_put_text(&e->file, name, e->name_size);
    }
    for (int64_t i = 0; kind == OUT_SET_NAMES && i < e->sets[of].n; i++) {
        snprintf(name, sizeof name, "%s", e->sets[of].group[i].name);
        netcdf_put_text(&e->file, name, e->name_size);
    }
    for (int64_t i = 0; kind == OUT_COMPONENT_NAMES && i < e->n_components[of]; i++) {
        const out_component *component = &e->component[of][i];
        snprintf(name, sizeof name, "%.250s%s", component->field->name, component->suffix);
        netcdf_put_text(&e->file, name, e->name_size);
    }
    for (int axis = 0; axis < e->columns && kind == OUT_AXIS_NAMES; axis++)
        netcdf_put_text(&e->file, axes[axis], e->name_size);
}

static void put_node_values(exodus_out *e, const out_component *component) {
    const int width = component->field->width;
    for (int64_t i = 0; i < e->view->model->n_nodes && load(e, component->field); i++)
        netcdf_put_double(&e->file, e->data.values[i * width + component->at]);
}

static void put_element_values(exodus_out *e, const out_component *component,
                               const out_block *block) {
    const int width = component->field->width;
    io_view_cell cell;
    int64_t index;
    for (int64_t i = 0; load(e, component->field) && next_cell(e, block, &i, &index, &cell);)
        netcdf_put_double(&e->file, e->data.values[cell.element * width + component->at]);
}

/** Put ids, numbers and flags. */
static void put_integers(exodus_out *e, out_kind kind, int64_t of) {
    for (int64_t i = 0; kind == OUT_ONES && i < of; i++)
        netcdf_put_integer(&e->file, 1);
    for (int64_t b = 0; kind == OUT_BLOCK_IDS && b < e->n_blocks; b++)
        netcdf_put_integer(&e->file, e->block[b].id);
    for (int64_t i = 0; kind == OUT_SET_IDS && i < e->sets[of].n; i++)
        netcdf_put_integer(&e->file, e->sets[of].group[i].id);
    for (int64_t i = 0; kind == OUT_NODE_NUMBERS && i < e->view->model->n_nodes; i++)
        netcdf_put_integer(&e->file, (int32_t)io_view_node_number(e->view, i));
    for (int64_t b = 0; kind == OUT_TRUTH && b < e->n_blocks; b++)
        for (int64_t i = 0; i < e->n_components[1]; i++)
            netcdf_put_integer(&e->file, has_values(e, b));
}

/** Put the values of a variable: netcdf_out_values. */
static void put_values(void *context, netcdf_out *file, const netcdf_out_variable *variable) {
    exodus_out *e = context;
    const out_kind kind = (out_kind)variable->kind;
    const int64_t of = variable->of[0];
    switch (kind) {
    case OUT_TIME:
        netcdf_put_double(file, 0);
        break;
    case OUT_BLOCK_NAMES:
    case OUT_SET_NAMES:
    case OUT_COMPONENT_NAMES:
    case OUT_AXIS_NAMES:
        put_names(e, kind, of);
        break;
    case OUT_COORDINATES:
        put_coordinates(e, of);
        break;
    case OUT_ELEMENT_NUMBERS:
        put_element_numbers(e);
        break;
    case OUT_NODES:
        put_nodes(e, &e->block[of]);
        break;
    case OUT_SET_NODES:
    case OUT_SET_ELEMENTS:
    case OUT_SET_SIDES:
        put_members(e, kind, of);
        break;
    case OUT_NODE_VALUES:
        put_node_values(e, &e->component[0][of]);
        break;
    case OUT_ELEMENT_VALUES:
        put_element_values(e, &e->component[1][of], &e->block[variable->of[1]]);
        break;
    default:
        put_integers(e, kind, of);
    }
}

/* ---- losses --------------------------------------------------------------------------------- */

/** Return whether a group of that name has members in the file. */
static int has_members(const exodus_out *e, const char *name) {
    const io_model *model = e->view->model;
    int is = 0;
    for (int k = 0; k < 2; k++)
        for (int64_t i = 0; i < e->sets[k].n && !is; i++)
            is = strcmp(e->sets[k].group[i].name, name) == 0;
    for (int32_t g = 0; g < model->n_groups && !is; g++)
        if (strcmp(model->group[g].name, name) == 0)
            for (int64_t b = 0; b < e->n_blocks && !is; b++)
                is = io_view_is_in_group(e->view, e->block[b].of->entity, g);
    return is;
}

static void list_losses(const exodus_out *e, io_losses *losses) {
    const io_model *model = e->view->model;
    int has_several = 0, has_empty = 0, is_divided = 0, has_parts = 0;
    for (int64_t b = 0; b < e->n_blocks; b++) {
        const out_block *block = &e->block[b];
        has_several |=
            block->group >= 0 && exodus_next_group(e->view, block->of->entity, block->group) >= 0;
        is_divided |= block->group >= 0 && !block->is_first;
        has_parts |= has_values(e, b) && !block->of->begins_set;
    }
    for (int32_t g = 0; g < model->n_groups; g++)
        has_empty |= !has_members(e, model->group[g].name);
    if (has_several)
        io_losses_add(losses, "all but the first group of elements that are in several");
    if (is_divided)
        io_losses_add(losses, "groups of several blocks as one");
    if (has_parts)
        io_losses_add(losses, "regions of several types as one");
    if (has_empty)
        io_losses_add(losses, "names of groups without elements");
}

/* ---- the file ------------------------------------------------------------------------------- */

static int exodus_write(const io_view *view, pl_output *output, io_losses *losses,
                        planish_error *error) {
    exodus_out e = {.view = view,
                    .columns = is_plane(view->model) ? 2 : 3,
                    .is_float = view->model->precision == PLANISH_PRECISION_FLOAT};
    netcdf_out_begin(&e.file, output, error);
    const int status = prepare(&e, error);
    if (!status) {
        describe(&e);
        netcdf_out_write(&e.file, put_values, &e);
        list_losses(&e, losses);
    }
    planish_data_free(&e.data);
    exodus_groups_release(&e.sets[0]);
    exodus_groups_release(&e.sets[1]);
    exodus_facets_release(&e.facets);
    io_view_blocks_release(&e.blocks);
    for (int k = 0; k < 2; k++)
        pl_free(e.component[k]);
    pl_free(e.block);
    return netcdf_out_end(&e.file) ? e.file.writer.status : status;
}

const io_target exodus_targets[] = {{"exodus", exodus_write}, {NULL, NULL}};
