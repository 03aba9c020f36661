/* gmsh_write: a mesh as a file of Gmsh's, of version 4.1 or 2.2, text.
 *
 * Cells of one entity of the model and of one region are an entity of Gmsh's.
 */
#include "io/gmsh/gmsh_write.h"

#include "io/gmsh/gmsh_reader.h"
#include "io/gmsh/gmsh_write_groups.h"
#include "io/view/view_blocks.h"
#include "io/view/writer.h"

#include "base/memory.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static const io_view_type types[] = {{PLANISH_CELL_LINE, "", 1},
                                     {PLANISH_CELL_TRIANGLE, "", 2},
                                     {PLANISH_CELL_QUADRILATERAL, "", 3},
                                     {PLANISH_CELL_TETRAHEDRON, "", 4},
                                     {PLANISH_CELL_HEXAHEDRON, "", 5},
                                     {PLANISH_CELL_WEDGE, "", 6},
                                     {PLANISH_CELL_PYRAMID, "", 7},
                                     {PLANISH_CELL_LINE3, "", 8},
                                     {PLANISH_CELL_TRIANGLE6, "", 9},
                                     {PLANISH_CELL_QUADRILATERAL9, "", 10},
                                     {PLANISH_CELL_TETRAHEDRON10, "", 11},
                                     {PLANISH_CELL_HEXAHEDRON27, "", 12},
                                     {PLANISH_CELL_WEDGE18, "", 13},
                                     {PLANISH_CELL_PYRAMID14, "", 14},
                                     {PLANISH_CELL_QUADRILATERAL8, "", 16},
                                     {PLANISH_CELL_HEXAHEDRON20, "", 17},
                                     {PLANISH_CELL_WEDGE15, "", 18},
                                     {PLANISH_CELL_PYRAMID13, "", 19},
                                     {0, NULL, 0}};

/** An entity that is written: blocks first .. last of the view. */
typedef struct out_entity {
    int dim;
    int64_t tag;
    int64_t first, last;
    double low[3], high[3]; /* the box of its nodes */
} out_entity;

typedef struct gmsh_out {
    const io_view *view;
    io_writer writer;
    io_view_blocks blocks;
    gmsh_groups groups;
    out_entity *entity; /* [n_entities] owned, by dimension, solids first */
    int64_t n_entities, capacity;
    int is_float;
} gmsh_out;

/* ---- entities ------------------------------------------------------------------------------ */

/** Join the box of an entity and a node. */
static void take_place(const io_view *view, int32_t node, out_entity *e) {
    double place[3];
    io_view_place(view, node, place);
    for (int d = 0; d < 3; d++) {
        e->low[d] = place[d] < e->low[d] ? place[d] : e->low[d];
        e->high[d] = place[d] > e->high[d] ? place[d] : e->high[d];
    }
}

static void find_box(const gmsh_out *g, out_entity *e) {
    io_view_cell cell;
    for (int d = 0; d < 3; d++) {
        e->low[d] = HUGE_VAL;
        e->high[d] = -HUGE_VAL;
    }
    for (int64_t b = e->first; b <= e->last; b++)
        for (int64_t i = 0; i < g->blocks.block[b].n; i++) {
            io_view_cell_at(g->view, g->blocks.block[b].cell[i], &cell);
            for (int k = 0; k < cell.n_nodes; k++)
                take_place(g->view, cell.node[k], e);
        }
}

/** Find the numbers [n] of entities of one dimension: the file's, or free ones. */
static int find_numbers(const out_entity *entity, int64_t n, int64_t *number,
                        planish_error *error) {
    for (int64_t i = 0; i < n; i++)
        number[i] = entity[i].tag;
    return io_view_distinct_numbers(number, n, INT64_MAX, error);
}

/** Number the entities of each dimension, and note whether numbers that the user may know change. */
static int number_entities(gmsh_out *g, io_losses *losses, planish_error *error) {
    int64_t *number = pl_alloc(g->n_entities, sizeof *number);
    int is_changed = 0, status = number ? PLANISH_OK : pl_fail_memory(error, "numbers of entities");
    for (int64_t first = 0, end; first < g->n_entities && !status; first = end) {
        for (end = first; end < g->n_entities && g->entity[end].dim == g->entity[first].dim;)
            end++;
        status = find_numbers(g->entity + first, end - first, number + first, error);
    }
    for (int64_t i = 0; i < g->n_entities && !status; i++) {
        is_changed |= g->entity[i].tag != 0 && g->entity[i].tag != number[i];
        g->entity[i].tag = number[i];
    }
    pl_free(number);
    if (is_changed && !g->view->model->groups_by_name)
        io_losses_add(losses, "numbers of regions");
    return status;
}

/** Find the entities: sets of blocks. */
static int find_entities(gmsh_out *g, io_losses *losses, planish_error *error) {
    for (int64_t b = 0; b < g->blocks.n; b++) {
        const io_view_block *block = &g->blocks.block[b];
        const out_entity e = {.dim = block->dim, .tag = block->region, .first = b};
        if (block->begins_set && !pl_append(&g->entity, &g->n_entities, &g->capacity, &e, sizeof e))
            return pl_fail_memory(error, "entities");
        g->entity[g->n_entities - 1].last = b;
    }
    return number_entities(g, losses, error);
}

/* ---- groups -------------------------------------------------------------------------------- */

/** Put a name between quotes. */
static void put_name(gmsh_out *g, const char *name) {
    io_put_text(&g->writer, "\"");
    for (const char *c = name; *c; c++)
        io_put_bytes(&g->writer, *c == '"' || (unsigned char)*c < ' ' ? "_" : c, 1);
    io_put_text(&g->writer, "\"\n");
}

static void put_names(gmsh_out *g) {
    const gmsh_groups *groups = &g->groups;
    int64_t n = 0;
    for (int64_t i = 0; i < groups->n; i++)
        n += groups->group[i].name && groups->number[i] > 0;
    if (n == 0)
        return;
    io_put_format(&g->writer, "$PhysicalNames\n%" PRId64 "\n", n);
    for (int64_t i = 0; i < groups->n; i++) {
        if (!groups->group[i].name || groups->number[i] < 0)
            continue;
        io_put_format(&g->writer, "%d %" PRId64 " ", groups->group[i].dim, groups->number[i]);
        put_name(g, groups->group[i].name);
    }
    io_put_text(&g->writer, "$EndPhysicalNames\n");
}

/* ---- nodes and elements -------------------------------------------------------------------- */

static void put_place(gmsh_out *g, int64_t node, char lead) {
    double place[3];
    io_view_place(g->view, node, place);
    for (int d = 0; d < 3; d++)
        io_put_real(&g->writer, d == 0 ? lead : ' ', place[d], g->is_float);
    io_put_text(&g->writer, "\n");
}

/** Put the number and the nodes of a cell, with what stands between them. */
static void put_cell(gmsh_out *g, int64_t index, const io_view_type *type, const char *between) {
    io_view_cell cell;
    io_view_cell_at(g->view, index, &cell);
    io_view_fit_cell(g->view, type, gmsh_node_orders, &cell);
    io_put_integer(&g->writer, 0, io_view_cell_number(g->view, index, &cell));
    io_put_text(&g->writer, between);
    for (int k = 0; k < cell.n_nodes; k++)
        io_put_integer(&g->writer, ' ', io_view_node_number(g->view, cell.node[k]));
    io_put_text(&g->writer, "\n");
}

/** Find the smallest and the largest of the numbers of nodes or cells. */
static void find_range(const io_view *view, int of_cells, int64_t range[2]) {
    const int64_t n = of_cells ? view->n_cells : view->model->n_nodes;
    io_view_cell cell;
    range[0] = n > 0 ? INT64_MAX : 0;
    range[1] = 0;
    for (int64_t i = 0; i < n; i++) {
        if (of_cells)
            io_view_cell_at(view, i, &cell);
        const int64_t number =
            of_cells ? io_view_cell_number(view, i, &cell) : io_view_node_number(view, i);
        range[0] = number < range[0] ? number : range[0];
        range[1] = number > range[1] ? number : range[1];
    }
}

/* ---- version 4.1 --------------------------------------------------------------------------- */

static void put_entity(gmsh_out *g, out_entity *e) {
    const int32_t entity = g->blocks.block[e->first].entity;
    const int64_t n = gmsh_groups_count(&g->groups, entity);
    find_box(g, e);
    io_put_integer(&g->writer, 0, e->tag);
    for (int k = 0; k < 6; k++)
        io_put_real(&g->writer, ' ', k < 3 ? e->low[k] : e->high[k - 3], 0);
    io_put_integer(&g->writer, ' ', n);
    for (int64_t k = 0; k < n; k++)
        io_put_integer(&g->writer, ' ', gmsh_groups_number(&g->groups, entity, k));
    io_put_text(&g->writer, " 0\n");
}

static void put_entities(gmsh_out *g) {
    int64_t n[4] = {0};
    for (int64_t i = 0; i < g->n_entities; i++)
        n[g->entity[i].dim]++;
    io_put_format(&g->writer, "$Entities\n0 %" PRId64 " %" PRId64 " %" PRId64 "\n", n[1], n[2],
                  n[3]);
    for (int dim = 1; dim <= 3; dim++)
        for (int64_t i = 0; i < g->n_entities; i++)
            if (g->entity[i].dim == dim)
                put_entity(g, &g->entity[i]);
    io_put_text(&g->writer, "$EndEntities\n");
}

/** Put all nodes as those of the first entity of the highest dimension. */
static void put_nodes41(gmsh_out *g) {
    const int64_t n = g->view->model->n_nodes;
    int64_t range[2];
    find_range(g->view, 0, range);
    io_put_format(&g->writer,
                  "$Nodes\n1 %" PRId64 " %" PRId64 " %" PRId64 "\n%d %" PRId64 " 0 %" PRId64 "\n",
                  n, range[0], range[1], g->entity[0].dim, g->entity[0].tag, n);
    for (int64_t i = 0; i < n; i++) {
        io_put_integer(&g->writer, 0, io_view_node_number(g->view, i));
        io_put_text(&g->writer, "\n");
    }
    for (int64_t i = 0; i < n; i++)
        put_place(g, i, 0);
    io_put_text(&g->writer, "$EndNodes\n");
}

static void put_elements41(gmsh_out *g) {
    int64_t range[2];
    find_range(g->view, 1, range);
    io_put_format(&g->writer, "$Elements\n%" PRId64 " %" PRId64 " %" PRId64 " %" PRId64 "\n",
                  g->blocks.n, g->view->n_cells, range[0], range[1]);
    for (int64_t e = 0; e < g->n_entities; e++)
        for (int64_t b = g->entity[e].first; b <= g->entity[e].last; b++) {
            const io_view_block *block = &g->blocks.block[b];
            const io_view_type *type = io_view_find_type(types, block->type);
            io_put_format(&g->writer, "%d %" PRId64 " %d %" PRId64 "\n", block->dim,
                          g->entity[e].tag, type->number, block->n);
            for (int64_t i = 0; i < block->n; i++)
                put_cell(g, block->cell[i], type, "");
        }
    io_put_text(&g->writer, "$EndElements\n");
}

/* ---- version 2.2 --------------------------------------------------------------------------- */

static void put_nodes22(gmsh_out *g) {
    const int64_t n = g->view->model->n_nodes;
    io_put_format(&g->writer, "$Nodes\n%" PRId64 "\n", n);
    for (int64_t i = 0; i < n; i++) {
        io_put_integer(&g->writer, 0, io_view_node_number(g->view, i));
        put_place(g, i, ' ');
    }
    io_put_text(&g->writer, "$EndNodes\n");
}

/** Put elements, each with two tags: the first physical group, 0 without any, and the entity. */
static void put_elements22(gmsh_out *g) {
    io_put_format(&g->writer, "$Elements\n%" PRId64 "\n", g->view->n_cells);
    for (int64_t e = 0; e < g->n_entities; e++)
        for (int64_t b = g->entity[e].first; b <= g->entity[e].last; b++) {
            const io_view_block *block = &g->blocks.block[b];
            const io_view_type *type = io_view_find_type(types, block->type);
            char between[64];
            snprintf(between, sizeof between, " %d 2 %" PRId64 " %" PRId64, type->number,
                     gmsh_groups_number(&g->groups, block->entity, 0), g->entity[e].tag);
            for (int64_t i = 0; i < block->n; i++)
                put_cell(g, block->cell[i], type, between);
        }
    io_put_text(&g->writer, "$EndElements\n");
}

static void lose_groups22(const gmsh_out *g, io_losses *losses) {
    int several = 0;
    for (int64_t b = 0; b < g->blocks.n; b++)
        several |= gmsh_groups_count(&g->groups, g->blocks.block[b].entity) > 1;
    if (several)
        io_losses_add(losses, "all but the first group of elements that are in several");
}

/* ---- data ---------------------------------------------------------------------------------- */

/** Return the numbers that a value must have: Gmsh shows 1, 3 and 9. */
static int out_width(int width) {
    return width == 1 ? 1 : width <= 3 ? 3 : 9;
}

/** Put the numbers of a value; tensors that are symmetric, or of two dimensions, have all nine. */
static void put_value(gmsh_out *g, const double *value, int width) {
    enum { ZERO = 9 };
    static const uint8_t as_it_is[] = {0, 1, 2, 3, 4, 5, 6, 7, 8};
    static const uint8_t symmetric[] = {0, 1, 3, 1, 2, 4, 3, 4, 5};
    static const uint8_t plane[] = {0, 1, ZERO, 2, 3, ZERO, ZERO, ZERO, ZERO};
    const uint8_t *at = width == 6 ? symmetric : width == 4 ? plane : as_it_is;
    for (int k = 0; k < out_width(width); k++)
        io_put_real(&g->writer, ' ', at[k] < width ? value[at[k]] : 0, 0);
    io_put_text(&g->writer, "\n");
}

static void put_field(gmsh_out *g, const io_view_field *field) {
    const io_view *view = g->view;
    const char *section = field->of_elements ? "ElementData" : "NodeData";
    planish_data data;
    if (g->writer.status)
        return;
    g->writer.status = view->load(view->file, field, &data, g->writer.error);
    io_put_format(&g->writer, "$%s\n1\n", section);
    put_name(g, field->name);
    io_put_format(&g->writer, "1\n0\n3\n0\n%d\n%" PRId64 "\n", out_width(field->width), data.n);
    for (int64_t i = 0; i < view->model->n_nodes && !field->of_elements && !g->writer.status; i++) {
        io_put_integer(&g->writer, 0, io_view_node_number(view, i));
        put_value(g, data.values + i * field->width, field->width);
    }
    io_view_cell cell;
    for (int64_t i = 0; i < view->n_cells && field->of_elements && !g->writer.status; i++) {
        io_view_cell_at(view, i, &cell);
        if (cell.element < 0)
            continue;
        io_put_integer(&g->writer, 0, io_view_cell_number(view, i, &cell));
        put_value(g, data.values + cell.element * field->width, field->width);
    }
    planish_data_free(&data);
    io_put_format(&g->writer, "$End%s\n", section);
}

/* ---- a file -------------------------------------------------------------------------------- */

static void put_file(gmsh_out *g, int is_41) {
    io_put_text(&g->writer, is_41 ? "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
                                  : "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n");
    put_names(g);
    if (is_41) {
        put_entities(g);
        put_nodes41(g);
        put_elements41(g);
    } else {
        put_nodes22(g);
        put_elements22(g);
    }
    for (int i = 0; i < g->view->n_fields; i++)
        put_field(g, &g->view->field[i]);
}

static int write_file(const io_view *view, pl_output *output, io_losses *losses, int is_41,
                      planish_error *error) {
    gmsh_out g = {.view = view, .is_float = view->model->precision == PLANISH_PRECISION_FLOAT};
    io_writer_begin(&g.writer, output, error);
    int status = io_view_blocks_make(view, &g.blocks, error);
    if (!status)
        status = gmsh_groups_make(view, &g.blocks, &g.groups, losses, error);
    if (!status)
        status = find_entities(&g, losses, error);
    if (!status) {
        put_file(&g, is_41);
        if (!is_41)
            lose_groups22(&g, losses);
    }
    gmsh_groups_release(&g.groups);
    io_view_blocks_release(&g.blocks);
    pl_free(g.entity);
    return io_writer_end(&g.writer) ? g.writer.status : status;
}

static int write_41(const io_view *view, pl_output *output, io_losses *losses,
                    planish_error *error) {
    return write_file(view, output, losses, 1, error);
}

static int write_22(const io_view *view, pl_output *output, io_losses *losses,
                    planish_error *error) {
    return write_file(view, output, losses, 0, error);
}

const io_target gmsh_targets[] = {{"gmsh", write_41}, {"gmsh22", write_22}, {NULL, NULL}};
