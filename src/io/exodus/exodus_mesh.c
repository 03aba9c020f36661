/* exodus_mesh: blocks, sets and data of a mesh that is written as an Exodus file.
 *
 * Cells of one type, entity and region are a block. Facets that are sides of elements are in side
 * sets; others are blocks, and so are lines in space. Each component of an array of numbers is a
 * variable.
 */
#include "io/exodus/exodus_mesh.h"

#include "io/core/data.h"

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

enum { LEAST_NAME = 32 }; /* room for names in all files */

/* ---- blocks --------------------------------------------------------------------------------- */

int exodus_next_cell(const exodus_mesh *mesh, const exodus_out_block *block, int64_t *i,
                     io_view_cell *cell) {
    const io_view_block *of = block->of;
    while (*i < of->n && block->facet >= 0 && mesh->facets.side[block->facet + *i].element > 0)
        ++*i;
    if (*i >= of->n)
        return 0;
    io_view_cell_at(mesh->view, of->cell[(*i)++], cell);
    return 1;
}

/** Add a block, if any of its cells is an element. facet: index of its first one, or -1. */
static void add_block(exodus_mesh *mesh, const io_view_block *of, int64_t facet) {
    exodus_out_block block = {.of = of,
                              .type = io_view_find_type(types, of->type),
                              .n = of->n,
                              .facet = facet,
                              .group = io_view_next_group(mesh->view, of->entity, -1)};
    const int is_shell = mesh->columns == 3 && strncmp(block.type->name, "QUAD", 4) == 0;
    snprintf(block.type_name, sizeof block.type_name, "%s%s", is_shell ? "SHELL" : "",
             block.type->name + (is_shell ? 4 : 0));
    for (int64_t i = 0; i < of->n && facet >= 0; i++)
        block.n -= mesh->facets.side[facet + i].element > 0;
    mesh->n_elements += block.n;
    if (block.n > 0)
        mesh->block[mesh->n_blocks++] = block;
}

/** Give the blocks their ids, and find the first ones of each group. */
static int number_blocks(exodus_mesh *mesh, planish_error *error) {
    int64_t *wanted = pl_alloc(mesh->n_blocks, sizeof *wanted);
    int32_t *id = pl_alloc(mesh->n_blocks, sizeof *id);
    uint8_t *is_used = pl_alloc_zero(mesh->view->model->n_groups, 1);
    int status = wanted && id && is_used ? PLANISH_OK : pl_fail_memory(error, "blocks");
    for (int64_t b = 0; b < mesh->n_blocks && !status; b++)
        wanted[b] = mesh->block[b].of->reference;
    if (!status)
        status = exodus_give_ids(wanted, mesh->n_blocks, id, error);
    for (int64_t b = 0; b < mesh->n_blocks && !status; b++) {
        exodus_out_block *block = &mesh->block[b];
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

static int find_blocks(exodus_mesh *mesh, planish_error *error) {
    int64_t facet = 0;
    mesh->block = pl_alloc(mesh->blocks.n, sizeof *mesh->block);
    for (int64_t b = 0; b < mesh->blocks.n && mesh->block; b++) {
        const io_view_block *block = &mesh->blocks.block[b];
        const int is_of_facets = block->dim == mesh->facets.dim;
        add_block(mesh, block, is_of_facets ? facet : -1);
        facet += is_of_facets ? block->n : 0;
    }
    return mesh->block ? number_blocks(mesh, error) : pl_fail_memory(error, "blocks of elements");
}

void exodus_name_block(const exodus_mesh *mesh, const exodus_out_block *block,
                       char name[EXODUS_MOST_NAME + 1]) {
    name[0] = '\0';
    if (block->group < 0)
        return;
    const char *of_group = mesh->view->model->group[block->group].name;
    if (block->is_first)
        snprintf(name, EXODUS_MOST_NAME + 1, "%.*s", EXODUS_CUT_NAME, of_group);
    else
        snprintf(name, EXODUS_MOST_NAME + 1, "%.*s_%" PRId32, EXODUS_CUT_NAME, of_group, block->id);
}

/* ---- components ----------------------------------------------------------------------------- */

/** Add the components of a field, by the names and in the order that SEACAS (and so
 *  ParaView) joins to vectors and symmetric tensors. */
static int add_components(exodus_mesh *mesh, const io_view_field *field) {
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
        const exodus_component component = {field, at, suffixes[field->width][at]};
        if (!pl_append(&mesh->component[k], &mesh->n_components[k], &mesh->component_capacity[k],
                       &component, sizeof component))
            return 0;
    }
    return 1;
}

static int find_components(exodus_mesh *mesh, planish_error *error) {
    int is_done = 1;
    for (int i = 0; i < mesh->view->n_fields && is_done; i++)
        is_done = add_components(mesh, &mesh->view->field[i]);
    return is_done ? PLANISH_OK : pl_fail_memory(error, "arrays to be written");
}

/* ---- what is written ------------------------------------------------------------------------ */

/** Return whether the nodes all are in the plane of x and y, at z = 0. */
static int is_plane(const io_model *model) {
    int is = model->dim == 2 && model->written == 2;
    for (int64_t i = 0; i < model->n_nodes && model->z && is; i++)
        is = model->z[i] == 0;
    return is;
}

int64_t exodus_next_number(const exodus_mesh *mesh, const exodus_out_block *block, int64_t *i) {
    io_view_cell cell;
    return exodus_next_cell(mesh, block, i, &cell) ? cell.number : 0;
}

/** Find out whether nodes and elements have other numbers than 1, 2, ... that can be kept. Facets that
 *  are sides have none. */
static int look_at_numbers(exodus_mesh *mesh, planish_error *error) {
    int64_t *number = pl_alloc(mesh->n_elements, sizeof *number), n = 0, next;
    if (!number)
        return pl_fail_memory(error, "numbers of elements");
    for (int64_t i = 0; i < mesh->view->model->n_nodes; i++)
        mesh->has_numbers[0] |= io_view_node_number(mesh->view, i) != i + 1;
    for (int64_t b = 0; b < mesh->n_blocks; b++)
        for (int64_t i = 0; (next = exodus_next_number(mesh, &mesh->block[b], &i)) > 0; n++) {
            number[n] = next;
            mesh->has_numbers[1] |= next != n + 1;
        }
    mesh->has_numbers[1] &= n == mesh->n_elements && io_view_are_numbers(number, n);
    pl_free(number);
    return PLANISH_OK;
}

/** Find the room that names need. */
static void measure_names(exodus_mesh *mesh) {
    enum { LONGEST_SUFFIX = 12 }; /* all of it fits behind a name that is cut */
    size_t most = LEAST_NAME;
    for (int32_t g = 0; g < mesh->view->model->n_groups; g++) {
        const size_t length = strlen(mesh->view->model->group[g].name) + LONGEST_SUFFIX;
        most = length > most ? length : most;
    }
    for (int i = 0; i < mesh->view->n_fields; i++) {
        const size_t length = strlen(mesh->view->field[i].name) + LONGEST_SUFFIX;
        most = length > most ? length : most;
    }
    mesh->are_cut = most > EXODUS_CUT_NAME + LONGEST_SUFFIX;
    mesh->name_size = (int64_t)(most < EXODUS_MOST_NAME ? most : EXODUS_MOST_NAME) + 1;
}

int exodus_mesh_make(const io_view *view, exodus_mesh *mesh, planish_error *error) {
    *mesh = (exodus_mesh){.view = view, .columns = is_plane(view->model) ? 2 : 3};
    int status = io_view_blocks_make(mesh->view, &mesh->blocks, error);
    if (!status)
        status = exodus_facets_find(mesh->view, &mesh->blocks, types, mesh->columns == 3,
                                    &mesh->facets, error);
    if (!status)
        status = exodus_groups_of_nodes(mesh->view, &mesh->sets[0], error);
    if (!status)
        status = exodus_groups_of_facets(mesh->view, &mesh->blocks, &mesh->facets, &mesh->sets[1],
                                         error);
    if (!status)
        status = find_blocks(mesh, error);
    if (!status)
        status = find_components(mesh, error);
    if (!status)
        status = look_at_numbers(mesh, error);
    measure_names(mesh);
    return status;
}

int exodus_has_values(const exodus_mesh *mesh, int64_t b) {
    return mesh->block[b].of->dim > mesh->facets.dim;
}

void exodus_mesh_release(exodus_mesh *mesh) {
    for (int k = 0; k < 2; k++) {
        exodus_groups_release(&mesh->sets[k]);
        pl_free(mesh->component[k]);
    }
    exodus_facets_release(&mesh->facets);
    io_view_blocks_release(&mesh->blocks);
    pl_free(mesh->block);
}
