/* exodus_write: a mesh as an Exodus II file in classic netCDF: dimensions, variables, and their values.
 * Data are values at one time step.
 */
#include "io/exodus/exodus_write.h"

#include "io/exodus/exodus_format.h"
#include "io/exodus/exodus_mesh.h"
#include "io/netcdf/netcdf_write.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdio.h>
#include <string.h>

/** Kind of values that a variable of the file has. */
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
    exodus_mesh mesh;
    netcdf_out file;
    planish_data data; /* of the field that was asked for last */
    const io_view_field *loaded;
    int is_float;
} exodus_out;

/* ---- dimensions and variables --------------------------------------------------------------- */

/** Indices of the file's dimensions. */
typedef struct out_dims {
    int time, name, four, columns, nodes, elements, blocks, sets[2], components[2];
} out_dims;

static netcdf_out_name named(const char *text) {
    return (netcdf_out_name){{text}, {0}};
}

/** Return the name of block, set or component k (from 0): exodus_name_of. */
static netcdf_out_name numbered(const char *text, int64_t k) {
    return (netcdf_out_name){{text}, {(int32_t)k + 1}};
}

/** Return the name of a component's values in a block: exodus_values_name. */
static netcdf_out_name values_of(int64_t component, int64_t block) {
    return (netcdf_out_name){{"vals_elem_var", "eb"}, {(int32_t)component + 1, (int32_t)block + 1}};
}

/** Add a dimension of block or set k (from 0); of all: k is -1. Without a length there is none. */
static int dimension(exodus_out *e, const char *name, int64_t k, int64_t length) {
    return length > 0 ? netcdf_out_dimension(&e->file, numbered(name, k), length) : -1;
}

/** Add a variable of one or two (dim2 not -1) dimensions. */
static void add(exodus_out *e, netcdf_out_name name, netcdf_type type, int dim1, int dim2,
                out_kind kind, int64_t of1, int64_t of2) {
    netcdf_out_variable v = {.name = name,
                             .type = type,
                             .n_dims = dim2 < 0 ? 1 : 2,
                             .dim = {dim1, dim2},
                             .kind = (int)kind,
                             .of = {(int32_t)of1, (int32_t)of2}};
    if (kind == OUT_BLOCK_IDS || kind == OUT_SET_IDS) {
        v.attribute = "name";
        v.text = "ID";
    } else if (kind == OUT_NODES) {
        v.attribute = "elem_type";
        v.text = e->mesh.block[of1].type_name;
    }
    netcdf_out_variable_add(&e->file, &v);
}

static out_dims add_dimensions(exodus_out *e) {
    enum { STRING = 33, LINE = 81, FOUR = 4 };
    out_dims d = {0};
    dimension(e, "len_string", -1, STRING);
    dimension(e, "len_line", -1, LINE);
    dimension(e, "four", -1, FOUR);
    d.name = dimension(e, "len_name", -1, e->mesh.name_size);
    d.time = netcdf_out_dimension(&e->file, named("time_step"), 0);
    d.columns = dimension(e, "num_dim", -1, e->mesh.columns);
    d.nodes = dimension(e, "num_nodes", -1, e->mesh.view->model->n_nodes);
    d.elements = dimension(e, "num_elem", -1, e->mesh.n_elements);
    d.blocks = dimension(e, "num_el_blk", -1, e->mesh.n_blocks);
    d.sets[0] = dimension(e, "num_node_sets", -1, e->mesh.sets[0].n);
    d.sets[1] = dimension(e, "num_side_sets", -1, e->mesh.sets[1].n);
    d.components[0] = dimension(e, "num_nod_var", -1, e->mesh.n_components[0]);
    d.components[1] = dimension(e, "num_elem_var", -1, e->mesh.n_components[1]);
    return d;
}

static void add_mesh(exodus_out *e, const out_dims *d) {
    static const char *const places[] = {"coordx", "coordy", "coordz"};
    add(e, named("eb_status"), NETCDF_INT, d->blocks, -1, OUT_ONES, e->mesh.n_blocks, 0);
    add(e, named("eb_prop1"), NETCDF_INT, d->blocks, -1, OUT_BLOCK_IDS, 0, 0);
    add(e, named("eb_names"), NETCDF_CHAR, d->blocks, d->name, OUT_BLOCK_NAMES, 0, 0);
    for (int axis = 0; axis < e->mesh.columns; axis++)
        add(e, named(places[axis]), e->is_float ? NETCDF_FLOAT : NETCDF_DOUBLE, d->nodes, -1,
            OUT_COORDINATES, axis, 0);
    add(e, named("coor_names"), NETCDF_CHAR, d->columns, d->name, OUT_AXIS_NAMES, 0, 0);
    if (e->mesh.has_numbers[0])
        add(e, named("node_num_map"), NETCDF_INT, d->nodes, -1, OUT_NODE_NUMBERS, 0, 0);
    if (e->mesh.has_numbers[1])
        add(e, named("elem_num_map"), NETCDF_INT, d->elements, -1, OUT_ELEMENT_NUMBERS, 0, 0);
    for (int64_t b = 0; b < e->mesh.n_blocks; b++) {
        const int type = e->mesh.block[b].type->type;
        const int nodes =
            io_simplex_dim(type) == 1 ? 2 + io_has_mids(type) : io_cell_type_nodes(type);
        const int dim = dimension(e, "num_el_in_blk", b, e->mesh.block[b].n);
        e->mesh.block[b].dim = dim;
        add(e, numbered("connect", b), NETCDF_INT, dim, dimension(e, "num_nod_per_el", b, nodes),
            OUT_NODES, b, 0);
    }
}

static void add_sets(exodus_out *e, const out_dims *d) {
    static const char *const names[2][4] = {{"ns_status", "ns_prop1", "ns_names", "num_nod_ns"},
                                            {"ss_status", "ss_prop1", "ss_names", "num_side_ss"}};
    for (int k = 0; k < 2; k++) {
        const int dim = d->sets[k];
        if (dim < 0)
            continue;
        add(e, named(names[k][0]), NETCDF_INT, dim, -1, OUT_ONES, e->mesh.sets[k].n, 0);
        add(e, named(names[k][1]), NETCDF_INT, dim, -1, OUT_SET_IDS, k, 0);
        add(e, named(names[k][2]), NETCDF_CHAR, dim, d->name, OUT_SET_NAMES, k, 0);
        for (int64_t i = 0; i < e->mesh.sets[k].n; i++) {
            const int members = dimension(e, names[k][3], i, e->mesh.sets[k].group[i].n);
            if (k == 0) {
                add(e, numbered("node_ns", i), NETCDF_INT, members, -1, OUT_SET_NODES, i, 0);
                continue;
            }
            add(e, numbered("elem_ss", i), NETCDF_INT, members, -1, OUT_SET_ELEMENTS, i, 0);
            add(e, numbered("side_ss", i), NETCDF_INT, members, -1, OUT_SET_SIDES, i, 0);
        }
    }
}

static void add_values(exodus_out *e, const out_dims *d) {
    static const char *const names[] = {"name_nod_var", "name_elem_var"};
    for (int k = 0; k < 2; k++)
        if (e->mesh.n_components[k] > 0)
            add(e, named(names[k]), NETCDF_CHAR, d->components[k], d->name, OUT_COMPONENT_NAMES, k,
                0);
    if (e->mesh.n_components[1] > 0)
        add(e, named("elem_var_tab"), NETCDF_INT, d->blocks, d->components[1], OUT_TRUTH, 0, 0);
    add(e, named("time_whole"), NETCDF_DOUBLE, d->time, -1, OUT_TIME, 0, 0);
    for (int64_t i = 0; i < e->mesh.n_components[0]; i++)
        add(e, numbered("vals_nod_var", i), NETCDF_DOUBLE, d->time, d->nodes, OUT_NODE_VALUES, i,
            0);
    for (int64_t i = 0; i < e->mesh.n_components[1]; i++)
        for (int64_t b = 0; b < e->mesh.n_blocks && exodus_has_values(&e->mesh, b); b++)
            add(e, values_of(i, b), NETCDF_DOUBLE, d->time, e->mesh.block[b].dim,
                OUT_ELEMENT_VALUES, i, b);
}

/** Make room for the dimensions and variables of blocks and sets, of which there may be very many. */
static void reserve(exodus_out *e) {
    enum { OTHERS = 64 };
    const int64_t blocks = e->mesh.n_blocks, of_nodes = e->mesh.sets[0].n,
                  of_sides = e->mesh.sets[1].n;
    netcdf_out_reserve(&e->file, OTHERS + 2 * blocks + of_nodes + of_sides,
                       OTHERS + blocks + of_nodes + 2 * of_sides);
}

static void describe(exodus_out *e) {
    enum { LARGE = 1 }; /* each coordinate is a variable of its own */
    static const float version = 5.14f;
    netcdf_out *file = &e->file;
    reserve(e);
    netcdf_out_float(file, "api_version", version);
    netcdf_out_float(file, "version", version);
    netcdf_out_integer(file, "floating_point_word_size", e->is_float ? 4 : 8);
    netcdf_out_integer(file, "file_size", LARGE);
    netcdf_out_integer(file, "maximum_name_length", (int32_t)e->mesh.name_size - 1);
    netcdf_out_integer(file, "int64_status", 0);
    netcdf_out_text(file, "title", "written by planish");
    file->n_records = e->mesh.n_components[0] + e->mesh.n_components[1] > 0;
    const out_dims dims = add_dimensions(e);
    add_mesh(e, &dims);
    add_sets(e, &dims);
    add_values(e, &dims);
}

/* ---- values --------------------------------------------------------------------------------- */

/** Read the values of a field, if they are not there yet. Returns 0 after an error. */
static int load(exodus_out *e, const io_view_field *field) {
    io_writer *writer = &e->file.writer;
    if (e->loaded == field)
        return 1;
    planish_data_free(&e->data);
    e->loaded = NULL;
    const int status = e->mesh.view->load(e->mesh.view->file, field, &e->data, writer->error);
    if (status)
        writer->status = status;
    else
        e->loaded = field;
    return !status;
}

static void put_coordinates(exodus_out *e, int64_t axis) {
    double place[3];
    for (int64_t i = 0; i < e->mesh.view->model->n_nodes; i++) {
        io_view_place(e->mesh.view, i, place);
        if (e->is_float)
            netcdf_put_float(&e->file, (float)place[axis]);
        else
            netcdf_put_double(&e->file, place[axis]);
    }
}

static void put_element_numbers(exodus_out *e) {
    int64_t number;
    for (int64_t b = 0; b < e->mesh.n_blocks; b++)
        for (int64_t i = 0; (number = exodus_next_number(&e->mesh, &e->mesh.block[b], &i)) > 0;)
            netcdf_put_integer(&e->file, (int32_t)number);
}

static void put_nodes(exodus_out *e, const exodus_out_block *block) {
    io_view_cell cell;
    for (int64_t i = 0; exodus_next_cell(&e->mesh, block, &i, &cell);) {
        io_view_fit_cell(e->mesh.view, block->type, exodus_node_orders, &cell);
        for (int k = 0; k < cell.n_nodes; k++)
            netcdf_put_integer(&e->file, cell.node[k] + 1);
    }
}

/** Put the members of a set as a kind says: nodes, or elements or sides of facets. */
static void put_members(exodus_out *e, out_kind kind, int64_t set) {
    const exodus_groups *sets = &e->mesh.sets[kind != OUT_SET_NODES];
    const exodus_member *member = sets->member + sets->group[set].first;
    for (int64_t i = 0; i < sets->group[set].n; i++)
        netcdf_put_integer(&e->file, kind == OUT_SET_SIDES ? member[i].side : member[i].place);
}

static void put_names(exodus_out *e, out_kind kind, int64_t of) {
    static const char axes[][2] = {"x", "y", "z"};
    char name[EXODUS_MOST_NAME + 1];
    for (int64_t b = 0; b < e->mesh.n_blocks && kind == OUT_BLOCK_NAMES; b++) {
        exodus_name_block(&e->mesh, &e->mesh.block[b], name);
        netcdf_put_text(&e->file, name, e->mesh.name_size);
    }
    for (int64_t i = 0; kind == OUT_SET_NAMES && i < e->mesh.sets[of].n; i++) {
        const char *of_set = e->mesh.sets[of].group[i].name;
        snprintf(name, sizeof name, "%.*s", io_view_name_length(of_set, EXODUS_CUT_NAME), of_set);
        netcdf_put_text(&e->file, name, e->mesh.name_size);
    }
    for (int64_t i = 0; kind == OUT_COMPONENT_NAMES && i < e->mesh.n_components[of]; i++) {
        const exodus_component *component = &e->mesh.component[of][i];
        const char *of_field = component->field->name;
        snprintf(name, sizeof name, "%.*s%s", io_view_name_length(of_field, EXODUS_CUT_NAME),
                 of_field, component->suffix);
        netcdf_put_text(&e->file, name, e->mesh.name_size);
    }
    for (int axis = 0; axis < e->mesh.columns && kind == OUT_AXIS_NAMES; axis++)
        netcdf_put_text(&e->file, axes[axis], e->mesh.name_size);
}

static void put_node_values(exodus_out *e, const exodus_component *component) {
    const int width = component->field->width;
    for (int64_t i = 0; i < e->mesh.view->model->n_nodes && load(e, component->field); i++)
        netcdf_put_double(&e->file, e->data.values[i * width + component->at]);
}

static void put_element_values(exodus_out *e, const exodus_component *component,
                               const exodus_out_block *block) {
    const int width = component->field->width;
    io_view_cell cell;
    for (int64_t i = 0; load(e, component->field) && exodus_next_cell(&e->mesh, block, &i, &cell);)
        netcdf_put_double(&e->file, e->data.values[cell.element * width + component->at]);
}

/** Put ids, numbers and flags. */
static void put_integers(exodus_out *e, out_kind kind, int64_t of) {
    for (int64_t i = 0; kind == OUT_ONES && i < of; i++)
        netcdf_put_integer(&e->file, 1);
    for (int64_t b = 0; kind == OUT_BLOCK_IDS && b < e->mesh.n_blocks; b++)
        netcdf_put_integer(&e->file, e->mesh.block[b].id);
    for (int64_t i = 0; kind == OUT_SET_IDS && i < e->mesh.sets[of].n; i++)
        netcdf_put_integer(&e->file, e->mesh.sets[of].group[i].id);
    for (int64_t i = 0; kind == OUT_NODE_NUMBERS && i < e->mesh.view->model->n_nodes; i++)
        netcdf_put_integer(&e->file, (int32_t)io_view_node_number(e->mesh.view, i));
    for (int64_t b = 0; kind == OUT_TRUTH && b < e->mesh.n_blocks; b++)
        for (int64_t i = 0; i < e->mesh.n_components[1]; i++)
            netcdf_put_integer(&e->file, exodus_has_values(&e->mesh, b));
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
        put_nodes(e, &e->mesh.block[of]);
        break;
    case OUT_SET_NODES:
    case OUT_SET_ELEMENTS:
    case OUT_SET_SIDES:
        put_members(e, kind, of);
        break;
    case OUT_NODE_VALUES:
        put_node_values(e, &e->mesh.component[0][of]);
        break;
    case OUT_ELEMENT_VALUES:
        put_element_values(e, &e->mesh.component[1][of], &e->mesh.block[variable->of[1]]);
        break;
    default:
        put_integers(e, kind, of);
    }
}

/* ---- losses --------------------------------------------------------------------------------- */

/** Find out whether the name of a group has no members in the file: *has_empty. */
static int look_for_empty(const exodus_mesh *mesh, int *has_empty, planish_error *error) {
    const io_view *view = mesh->view;
    const int64_t n = view->model->n_groups;
    int32_t *first;
    uint8_t *is_in = pl_alloc_zero(n, 1), *has_members = pl_alloc_zero(n, 1);
    int status = io_view_find_names(view, &first, error);
    if (!status && (!is_in || !has_members))
        status = pl_fail_memory(error, "names of groups");
    for (int64_t b = 0; b < mesh->n_blocks && !status; b++)
        io_view_mark_groups(view, mesh->block[b].of->entity, is_in);
    for (int k = 0; k < 2; k++)
        for (int64_t i = 0; i < mesh->sets[k].n && !status; i++)
            if (mesh->sets[k].group[i].group >= 0)
                has_members[first[mesh->sets[k].group[i].group]] = 1;
    for (int64_t g = 0; g < n && !status; g++)
        has_members[first[g]] |= is_in[g];
    *has_empty = 0;
    for (int64_t g = 0; g < n && !status; g++)
        *has_empty |= !has_members[first[g]];
    pl_free(first);
    pl_free(is_in);
    pl_free(has_members);
    return status;
}

/** Return whether sets have other numbers than the file's, below 0. */
static int have_negative(const exodus_mesh *mesh) {
    int has_negative = 0;
    for (int k = 0; k < 2; k++)
        for (int64_t i = 0; i < mesh->sets[k].n; i++)
            has_negative |= mesh->sets[k].group[i].group < 0 && mesh->sets[k].group[i].number < 0;
    return has_negative && !mesh->view->model->groups_by_name;
}

static int list_losses(const exodus_mesh *mesh, io_losses *losses, planish_error *error) {
    int has_several = 0, has_empty = 0, is_divided = 0, has_parts = 0, has_tags = 0;
    int is_changed = have_negative(mesh);
    for (int64_t b = 0; b < mesh->n_blocks; b++) {
        const exodus_out_block *block = &mesh->block[b];
        has_several |= block->group >= 0 &&
                       io_view_next_group(mesh->view, block->of->entity, block->group) >= 0;
        is_divided |= block->group >= 0 && !block->is_first;
        has_tags |= io_view_loses_tag(mesh->view, block->of, block->of->reference, 1);
        is_changed |=
            block->of->begins_set && io_view_loses_region(mesh->view, block->of, block->id);
        has_parts |= exodus_has_values(mesh, b) && !block->of->begins_set;
    }
    const int status = look_for_empty(mesh, &has_empty, error);
    if (has_several)
        io_losses_add(losses, "all but the first group of elements that are in several");
    if (has_tags)
        io_losses_add(losses, "numbers of groups");
    if (is_changed)
        io_losses_add(losses, "numbers of regions");
    if (is_divided)
        io_losses_add(losses, "groups of several blocks as one");
    if (has_parts)
        io_losses_add(losses, "regions of several types as one");
    if (has_empty)
        io_losses_add(losses, "names of groups without elements");
    if (mesh->are_cut)
        io_losses_add(losses, "the ends of names of more than %d bytes", EXODUS_CUT_NAME);
    return status;
}

/* ---- the file ------------------------------------------------------------------------------- */

static int exodus_write(const io_view *view, pl_output *output, io_losses *losses,
                        planish_error *error) {
    exodus_out e = {.is_float = view->model->precision == PLANISH_PRECISION_FLOAT};
    netcdf_out_begin(&e.file, output, error);
    int status = exodus_mesh_make(view, &e.mesh, error);
    if (!status) {
        describe(&e);
        netcdf_out_write(&e.file, put_values, &e);
        status = list_losses(&e.mesh, losses, error);
    }
    planish_data_free(&e.data);
    exodus_mesh_release(&e.mesh);
    return netcdf_out_end(&e.file) ? e.file.writer.status : status;
}

const io_target exodus_targets[] = {{"exodus", exodus_write}, {NULL, NULL}};
