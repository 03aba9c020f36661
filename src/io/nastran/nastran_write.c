/* nastran_write: a mesh as bulk data of Nastran: GRIDs in fields of 16 columns, elements in fields of
 * 8. There are no properties, materials and cases.
 *
 * Elements of one region have one property number. $HMNAME comments, which HyperMesh and others
 * write, have the names of groups.
 */
#include "io/nastran/nastran_write.h"

#include "io/core/number.h"
#include "io/view/view_blocks.h"
#include "io/view/writer.h"

#include "base/status.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { FIELD = 8, WIDE_FIELD = 16, FIELDS = 8 };

/** CHEXA and CPENTA have the mids of the uprights before those of the upper edges. */
const io_node_order nastran_node_orders[] = {
    {PLANISH_CELL_HEXAHEDRON20,
     {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
    {PLANISH_CELL_WEDGE15, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
    {0, {0}},
};

static const io_view_type types[] = {{PLANISH_CELL_TETRAHEDRON, "CTETRA", 0},
                                     {PLANISH_CELL_TETRAHEDRON10, "CTETRA", 0},
                                     {PLANISH_CELL_HEXAHEDRON, "CHEXA", 0},
                                     {PLANISH_CELL_HEXAHEDRON20, "CHEXA", 0},
                                     {PLANISH_CELL_WEDGE, "CPENTA", 0},
                                     {PLANISH_CELL_WEDGE15, "CPENTA", 0},
                                     {PLANISH_CELL_PYRAMID, "CPYRAM", 0},
                                     {PLANISH_CELL_PYRAMID13, "CPYRAM", 0},
                                     {PLANISH_CELL_TRIANGLE, "CTRIA3", 0},
                                     {PLANISH_CELL_TRIANGLE6, "CTRIA6", 0},
                                     {PLANISH_CELL_QUADRILATERAL, "CQUAD4", 0},
                                     {PLANISH_CELL_QUADRILATERAL8, "CQUAD8", 0},
                                     {PLANISH_CELL_LINE, "CROD", 0},
                                     {0, NULL, 0}};

/** A line under way. */
typedef struct nastran_out {
    const io_view *view;
    io_writer writer;
    int field; /* of the card, from 0 */
} nastran_out;

/** Put a card's name; blanks fill the field up. */
static void put_name(nastran_out *n, const char *name) {
    io_put_format(&n->writer, "%-*s", FIELD, name);
    n->field = 0;
}

/** Put a whole number into the next field of 8 columns; a card of more goes on in the next line. */
static void put_number(nastran_out *n, int64_t number) {
    if (n->field > 0 && n->field % FIELDS == 0)
        io_put_format(&n->writer, "+\n%-*s", FIELD, "+");
    io_put_format(&n->writer, "%*" PRId64, FIELD, number);
    n->field++;
}

/** Put a coordinate, as near as 16 columns can say it. */
static void put_real(nastran_out *n, double value) {
    char text[WIDE_FIELD + 1];
    const int length = io_format_field(text, value, WIDE_FIELD, IO_EXPONENT_IMPLIED);
    io_put_format(&n->writer, "%*.*s", WIDE_FIELD, length, text);
}

/** Put the nodes; their numbers have no more than eight digits, or they are counted. */
static void put_grids(nastran_out *n) {
    const int64_t n_nodes = n->view->model->n_nodes;
    double place[3];
    for (int64_t i = 0; i < n_nodes; i++) {
        io_view_place(n->view, i, place);
        put_name(n, "GRID*");
        io_put_format(&n->writer, "%*" PRId64 "%*s", WIDE_FIELD, io_view_node_number(n->view, i),
                      WIDE_FIELD, "");
        put_real(n, place[0]);
        put_real(n, place[1]);
        io_put_format(&n->writer, "*\n%-*s", FIELD, "*");
        put_real(n, place[2]);
        io_put_text(&n->writer, "\n");
    }
}

static void put_block(nastran_out *n, const io_view_block *block) {
    const io_view_type *type = io_view_find_type(types, block->type);
    io_view_cell cell;
    for (int64_t i = 0; i < block->n && type; i++) {
        io_view_cell_at(n->view, block->cell[i], &cell);
        io_view_fit_cell(n->view, type, nastran_node_orders, &cell);
        put_name(n, type->name);
        put_number(n, io_view_cell_number(n->view, block->cell[i], &cell));
        put_number(n, block->property);
        for (int k = 0; k < cell.n_nodes; k++)
            put_number(n, io_view_node_number(n->view, cell.node[k]));
        io_put_text(&n->writer, "\n");
    }
}

/** Put the name of the group that a set is the only one of its number in. */
static void put_property_name(nastran_out *n, const io_view_block *block) {
    const int32_t g = io_view_next_group(n->view, block->entity, -1);
    if (g < 0)
        return;
    const char *name = n->view->model->group[g].name;
    const int length = io_view_name_length(name, IO_VIEW_MOST_NAME);
    io_put_format(&n->writer, "$HMNAME PROP%*s%*" PRId32 "\"", FIELD + 1, "", FIELD,
                  block->property);
    for (int i = 0; i < length; i++)
        io_put_bytes(&n->writer, name[i] == '"' || (unsigned char)name[i] < ' ' ? "_" : name + i,
                     1);
    io_put_text(&n->writer, "\"\n");
}

static int nastran_write(const io_view *view, pl_output *output, io_losses *losses,
                         planish_error *error) {
    nastran_out n = {.view = view};
    io_view_blocks blocks;
    if (view->model->n_nodes > IO_VIEW_MOST_NUMBER || view->n_cells > IO_VIEW_MOST_NUMBER)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "%s: has more nodes or elements than the %d that Nastran's fields of 8 "
                       "columns can number; convert to another format",
                       view->model->input.path, IO_VIEW_MOST_NUMBER);
    int status = io_view_blocks_make(view, &blocks, error);
    io_writer_begin(&n.writer, output, error);
    if (!status) {
        io_put_text(&n.writer, "$ written by planish\nBEGIN BULK\n");
        for (int64_t b = 0; b < blocks.n; b++)
            if (blocks.block[b].begins_set)
                put_property_name(&n, &blocks.block[b]);
        put_grids(&n);
        for (int64_t b = 0; b < blocks.n; b++)
            put_block(&n, &blocks.block[b]);
        io_put_text(&n.writer, "ENDDATA\n");
        io_view_lose_types(types, &blocks, losses);
        io_view_lose_others(view, losses);
        io_view_lose_quotes(view->model, 1, losses);
        io_view_lose_tags(view, &blocks, 1, 1, losses);
        io_view_lose_fields(view, losses);
        io_losses_add(losses, "digits of coordinates beyond 16 characters");
    }
    io_view_blocks_release(&blocks);
    return io_writer_end(&n.writer) ? n.writer.status : status;
}

const io_target nastran_targets[] = {{"nastran", nastran_write}, {NULL, NULL}};
