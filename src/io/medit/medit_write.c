/* medit_write: a mesh as a text of Medit's. References are the numbers of groups or regions. */
#include "io/medit/medit_write.h"

#include "io/view/view_blocks.h"
#include "io/view/writer.h"

#include <inttypes.h>

/** Order of the nodes where a file gives none, as SALOME reads it: VTK's, but for the faces of
 *  hexahedra, which go round from the one below to the one above. */
const io_node_order medit_usual_order[] = {
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13,
                                 14, 15, 16, 17, 18, 19, 24, 22, 21, 23, 20, 25, 26}},
    {0, {0}}};

static const io_view_type types[] = {{PLANISH_CELL_TETRAHEDRON, "Tetrahedra", 0},
                                     {PLANISH_CELL_TETRAHEDRON10, "TetrahedraP2", 0},
                                     {PLANISH_CELL_HEXAHEDRON, "Hexahedra", 0},
                                     {PLANISH_CELL_HEXAHEDRON27, "HexahedraQ2", 0},
                                     {PLANISH_CELL_WEDGE, "Prisms", 0},
                                     {PLANISH_CELL_WEDGE18, "PrismsP2", 0},
                                     {PLANISH_CELL_PYRAMID, "Pyramids", 0},
                                     {PLANISH_CELL_TRIANGLE, "Triangles", 0},
                                     {PLANISH_CELL_TRIANGLE6, "TrianglesP2", 0},
                                     {PLANISH_CELL_QUADRILATERAL, "Quadrilaterals", 0},
                                     {PLANISH_CELL_QUADRILATERAL9, "QuadrilateralsQ2", 0},
                                     {PLANISH_CELL_LINE, "Edges", 0},
                                     {PLANISH_CELL_LINE3, "EdgesP2", 0},
                                     {0, NULL, 0}};

/** Return the reference of a node: the number of its first group, or of its entity. */
static int32_t reference_of(const io_model *model, int64_t node) {
    const int32_t index = model->node_entity ? model->node_entity[node] : -1;
    const io_entity *entity = index >= 0 ? &model->entity[index] : NULL;
    const int has_group = entity && entity->n_physical > 0 && !model->groups_by_name;
    return has_group ? entity->physical[0] : entity ? entity->tag : 0;
}

static void put_vertices(io_writer *writer, const io_view *view) {
    const io_model *model = view->model;
    const int columns = model->dim == 2 && model->written == 2 && !model->z ? 2 : 3;
    const int is_float = model->precision == PLANISH_PRECISION_FLOAT;
    double place[3];
    io_put_format(writer, "MeshVersionFormatted %d\nDimension %d\nVertices\n%" PRId64 "\n",
                  is_float ? 1 : 2, columns, model->n_nodes);
    for (int64_t i = 0; i < model->n_nodes; i++) {
        io_view_place(view, i, place);
        for (int d = 0; d < columns; d++)
            io_put_real(writer, d ? ' ' : 0, place[d], is_float);
        io_put_integer(writer, ' ', reference_of(model, i));
        io_put_text(writer, "\n");
    }
}

static void put_block(io_writer *writer, const io_view *view, const io_view_block *block,
                      const io_view_type *type) {
    io_view_cell cell;
    for (int64_t i = 0; i < block->n; i++) {
        io_view_cell_at(view, block->cell[i], &cell);
        io_view_fit_cell(view, type, medit_usual_order, &cell);
        for (int k = 0; k < cell.n_nodes; k++)
            io_put_integer(writer, k ? ' ' : 0, (int64_t)cell.node[k] + 1);
        io_put_integer(writer, ' ', block->reference);
        io_put_text(writer, "\n");
    }
}

/** Put all elements of a type, some of which have more nodes in the file. */
static void put_section(io_writer *writer, const io_view *view, const io_view_blocks *blocks,
                        const io_view_type *type) {
    int64_t n = 0;
    for (int64_t b = 0; b < blocks->n; b++)
        n += io_view_find_type(types, blocks->block[b].type) == type ? blocks->block[b].n : 0;
    if (n > 0)
        io_put_format(writer, "%s\n%" PRId64 "\n", type->name, n);
    for (int64_t b = 0; b < blocks->n; b++)
        if (io_view_find_type(types, blocks->block[b].type) == type)
            put_block(writer, view, &blocks->block[b], type);
}

/** Put the nodes that the file holds. */
static void put_required(io_writer *writer, const io_view *view) {
    int64_t n = 0;
    for (int64_t i = 0; i < view->model->n_nodes && view->options->constraint; i++)
        n += view->options->constraint[i] == PLANISH_CONSTRAINT_FIXED;
    if (n > 0)
        io_put_format(writer, "RequiredVertices\n%" PRId64 "\n", n);
    for (int64_t i = 0; i < view->model->n_nodes && n > 0; i++)
        if (view->options->constraint[i] == PLANISH_CONSTRAINT_FIXED)
            io_put_format(writer, "%" PRId64 "\n", i + 1);
}

static void list_losses(const io_view *view, const io_view_blocks *blocks, io_losses *losses) {
    io_view_lose_types(types, blocks, losses);
    io_view_lose_groups(view, losses);
    io_view_lose_tags(view, blocks, 0, 0, losses);
    io_view_lose_numbers(view, losses);
    io_view_lose_fields(view, losses);
}

static int medit_write(const io_view *view, pl_output *output, io_losses *losses,
                       planish_error *error) {
    io_writer writer;
    io_view_blocks blocks;
    const int status = io_view_blocks_make(view, &blocks, error);
    io_writer_begin(&writer, output, error);
    if (!status) {
        put_vertices(&writer, view);
        for (const io_view_type *type = types; type->type; type++)
            put_section(&writer, view, &blocks, type);
        put_required(&writer, view);
        io_put_text(&writer, "End\n");
        list_losses(view, &blocks, losses);
    }
    io_view_blocks_release(&blocks);
    return io_writer_end(&writer) ? writer.status : status;
}

const io_target medit_targets[] = {{"medit", medit_write}, {NULL, NULL}};
