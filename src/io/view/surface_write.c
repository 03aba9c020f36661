/* surface_write: surfaces as STL, OBJ and PLY. Solid elements and lines are left out, and so are nodes
 * that are on no triangle or quadrilateral.
 */
#include "io/view/surface_write.h"

#include "io/core/binary.h"
#include "io/view/view_blocks.h"
#include "io/view/writer.h"

#include "base/memory.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const io_view_type types[] = {
    {PLANISH_CELL_TRIANGLE, "", 0}, {PLANISH_CELL_QUADRILATERAL, "", 0}, {0, NULL, 0}};

typedef struct surface_out {
    const io_view *view;
    io_writer writer;
    io_view_blocks blocks;
    int64_t n_facets, n_nodes;
    int32_t *number; /* [n_nodes of the model] from 1, in order; 0: not on the surface; owned */
    int is_float;
} surface_out;

/* ---- facets and their nodes ---------------------------------------------------------------- */

/** Find facet i of a block, by its corners. */
static void facet_at(const surface_out *s, const io_view_block *block, int64_t i,
                     io_view_cell *cell) {
    io_view_cell_at(s->view, block->cell[i], cell);
    io_view_fit_cell(s->view, io_view_find_type(types, cell->type), NULL, cell);
}

/** Return whether a block is of facets. */
static int has_facets(const io_view_block *block) {
    return block->dim == 2;
}

/** Number the nodes of facets, and count both. */
static int find_nodes(surface_out *s, planish_error *error) {
    const int64_t n = s->view->model->n_nodes;
    io_view_cell cell;
    s->number = pl_alloc_zero(n, sizeof *s->number);
    if (!s->number)
        return pl_fail_memory(error, "nodes of the surface");
    for (int64_t b = 0; b < s->blocks.n; b++) {
        const io_view_block *block = &s->blocks.block[b];
        s->n_facets += has_facets(block) ? block->n : 0;
        for (int64_t i = 0; i < block->n && has_facets(block); i++) {
            facet_at(s, block, i, &cell);
            for (int k = 0; k < cell.n_nodes; k++)
                s->number[cell.node[k]] = 1;
        }
    }
    for (int64_t i = 0; i < n; i++)
        if (s->number[i])
            s->number[i] = (int32_t)++s->n_nodes;
    return PLANISH_OK;
}

/** Whether a name has '_' in place of a character: names are one word. */
static int is_replaced(char c) {
    return (unsigned char)c <= ' ';
}

/** Put the name of the set of a block: its first group, or its number; in one word. */
static void put_name(surface_out *s, const io_view_block *block) {
    const io_model *model = s->view->model;
    const int32_t g = io_view_next_group(s->view, block->entity, -1);
    if (g < 0) {
        io_put_format(&s->writer, "region%" PRId32, block->property);
        return;
    }
    const char *name = model->group[g].name;
    const int length = io_view_name_length(name, IO_VIEW_MOST_NAME);
    for (int i = 0; i < length; i++)
        io_put_bytes(&s->writer, is_replaced(name[i]) ? "_" : name + i, 1);
}

static void put_place(surface_out *s, int32_t node, const char *lead) {
    double place[3];
    io_view_place(s->view, node, place);
    io_put_text(&s->writer, lead);
    for (int d = 0; d < 3; d++)
        io_put_real(&s->writer, ' ', place[d], s->is_float);
    io_put_text(&s->writer, "\n");
}

/* ---- STL ----------------------------------------------------------------------------------- */

/** Find the unit normal of a triangle; 0 of one without an area. */
static void find_normal(const io_view *view, const int32_t node[3], double normal[3]) {
    double x[3][3];
    for (int k = 0; k < 3; k++)
        io_view_place(view, node[k], x[k]);
    double length = 0;
    for (int d = 0; d < 3; d++) {
        const int e = (d + 1) % 3, f = (d + 2) % 3;
        normal[d] =
            (x[1][e] - x[0][e]) * (x[2][f] - x[0][f]) - (x[1][f] - x[0][f]) * (x[2][e] - x[0][e]);
        length += normal[d] * normal[d];
    }
    length = sqrt(length);
    for (int d = 0; d < 3; d++)
        normal[d] = length > 0 && isfinite(length) ? normal[d] / length : 0;
}

static void put_stl_triangle(surface_out *s, const int32_t node[3]) {
    double normal[3];
    find_normal(s->view, node, normal);
    io_put_text(&s->writer, "facet normal");
    for (int d = 0; d < 3; d++)
        io_put_real(&s->writer, ' ', normal[d], 1);
    io_put_text(&s->writer, "\nouter loop\n");
    for (int k = 0; k < 3; k++)
        put_place(s, node[k], "vertex");
    io_put_text(&s->writer, "endloop\nendfacet\n");
}

/** Put each set as a solid; a quadrilateral as two triangles. */
static void put_stl(surface_out *s) {
    const io_view_block *block = s->blocks.block;
    io_view_cell cell;
    for (int64_t b = 0; b < s->blocks.n; b++) {
        if (!has_facets(&block[b]))
            continue;
        if (block[b].begins_set) {
            io_put_text(&s->writer, "solid ");
            put_name(s, &block[b]);
            io_put_text(&s->writer, "\n");
        }
        for (int64_t i = 0; i < block[b].n; i++) {
            facet_at(s, &block[b], i, &cell);
            put_stl_triangle(s, cell.node);
            if (cell.n_nodes == 4)
                put_stl_triangle(s, (const int32_t[]){cell.node[0], cell.node[2], cell.node[3]});
        }
        const int is_last = b + 1 == s->blocks.n || block[b + 1].begins_set;
        if (is_last) {
            io_put_text(&s->writer, "endsolid ");
            put_name(s, &block[b]);
            io_put_text(&s->writer, "\n");
        }
    }
}

/* ---- OBJ ----------------------------------------------------------------------------------- */

static void put_obj(surface_out *s) {
    io_view_cell cell;
    io_put_text(&s->writer, "# written by planish\n");
    for (int64_t i = 0; i < s->view->model->n_nodes; i++)
        if (s->number[i])
            put_place(s, (int32_t)i, "v");
    for (int64_t b = 0; b < s->blocks.n; b++) {
        const io_view_block *block = &s->blocks.block[b];
        if (has_facets(block) && block->begins_set) {
            io_put_text(&s->writer, "g ");
            put_name(s, block);
            io_put_text(&s->writer, "\n");
        }
        for (int64_t i = 0; i < block->n && has_facets(block); i++) {
            facet_at(s, block, i, &cell);
            io_put_text(&s->writer, "f");
            for (int k = 0; k < cell.n_nodes; k++)
                io_put_integer(&s->writer, ' ', s->number[cell.node[k]]);
            io_put_text(&s->writer, "\n");
        }
    }
}

/* ---- PLY ----------------------------------------------------------------------------------- */

static void put_ply_header(surface_out *s) {
    const char *real = s->is_float ? "float" : "double";
    io_put_format(&s->writer,
                  "ply\nformat %s 1.0\ncomment written by planish\nelement vertex %" PRId64
                  "\nproperty %s x\nproperty %s y\nproperty %s z\nelement face %" PRId64
                  "\nproperty list uchar int vertex_indices\nend_header\n",
                  io_machine_is_little() ? "binary_little_endian" : "binary_big_endian", s->n_nodes,
                  real, real, real, s->n_facets);
}

static void put_ply_facet(surface_out *s, const io_view_block *block, int64_t i) {
    io_view_cell cell;
    facet_at(s, block, i, &cell);
    const uint8_t n = (uint8_t)cell.n_nodes;
    io_put_bytes(&s->writer, &n, 1);
    for (int k = 0; k < cell.n_nodes; k++) {
        const int32_t node = s->number[cell.node[k]] - 1;
        io_put_bytes(&s->writer, &node, sizeof node);
    }
}

static void put_ply(surface_out *s) {
    put_ply_header(s);
    for (int64_t i = 0; i < s->view->model->n_nodes; i++) {
        double place[3];
        if (!s->number[i])
            continue;
        io_view_place(s->view, i, place);
        const float single[] = {(float)place[0], (float)place[1], (float)place[2]};
        if (s->is_float)
            io_put_bytes(&s->writer, single, sizeof single);
        else
            io_put_bytes(&s->writer, place, sizeof place);
    }
    for (int64_t b = 0; b < s->blocks.n; b++)
        for (int64_t i = 0; i < s->blocks.block[b].n && has_facets(&s->blocks.block[b]); i++)
            put_ply_facet(s, &s->blocks.block[b], i);
}

/* ---- the formats --------------------------------------------------------------------------- */

/** Note names of facets that are other words now, some of which may be the same. */
static void lose_blanks(const io_model *model, io_losses *losses) {
    int64_t n = 0;
    for (int32_t g = 0; g < model->n_groups; g++) {
        const char *c = model->group[g].name;
        while (*c && !is_replaced(*c))
            c++;
        n += model->group[g].dim == 2 && *c;
    }
    if (n > 0)
        io_losses_add(losses,
                      "blanks and control characters (now '_') in the names of %" PRId64 " group%s",
                      n, n > 1 ? "s" : "");
}

static void list_losses(const surface_out *s, int has_names, io_losses *losses) {
    const io_view *view = s->view;
    int64_t n_curved = 0;
    for (int64_t b = 0; b < s->blocks.n; b++)
        n_curved += has_facets(&s->blocks.block[b]) &&
                            !(s->blocks.block[b].type == PLANISH_CELL_TRIANGLE ||
                              s->blocks.block[b].type == PLANISH_CELL_QUADRILATERAL)
                        ? s->blocks.block[b].n
                        : 0;
    if (s->n_facets < view->n_cells)
        io_losses_add(losses, "%" PRId64 " solid elements and lines", view->n_cells - s->n_facets);
    if (n_curved > 0)
        io_losses_add(losses, "mids of %" PRId64 " elements", n_curved);
    if (s->n_nodes < view->model->n_nodes)
        io_losses_add(losses, "%" PRId64 " nodes that are corners of no facet",
                      view->model->n_nodes - s->n_nodes);
    if (has_names) {
        lose_blanks(view->model, losses);
        io_view_lose_others(view, losses);
        io_view_lose_tags(view, &s->blocks, 1, 1, losses);
    } else {
        io_view_lose_groups(view, losses);
        io_view_lose_references(view, losses);
    }
    io_view_lose_numbers(view, losses);
    io_view_lose_fields(view, losses);
}

static int write_surface(const io_view *view, void (*put)(surface_out *), int has_names,
                         pl_output *output, io_losses *losses, planish_error *error) {
    surface_out s = {.view = view, .is_float = view->model->precision == PLANISH_PRECISION_FLOAT};
    io_writer_begin(&s.writer, output, error);
    int status = io_view_blocks_make(view, &s.blocks, error);
    if (!status)
        status = find_nodes(&s, error);
    if (!status) {
        put(&s);
        list_losses(&s, has_names, losses);
    }
    io_view_blocks_release(&s.blocks);
    pl_free(s.number);
    return io_writer_end(&s.writer) ? s.writer.status : status;
}

static int stl_write(const io_view *view, pl_output *output, io_losses *losses,
                     planish_error *error) {
    return write_surface(view, put_stl, 1, output, losses, error);
}

static int obj_write(const io_view *view, pl_output *output, io_losses *losses,
                     planish_error *error) {
    return write_surface(view, put_obj, 1, output, losses, error);
}

static int ply_write(const io_view *view, pl_output *output, io_losses *losses,
                     planish_error *error) {
    return write_surface(view, put_ply, 0, output, losses, error);
}

int io_surface_check(const io_model *model, planish_error *error) {
    if (io_model_list(model, 2).n + io_model_list(model, IO_FLAT_LIST).n > 0)
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                   "%s: has no triangles or quadrilaterals, which are all that STL, OBJ and PLY "
                   "hold; convert to another format",
                   model->input.path);
}

const io_target stl_targets[] = {{"stl", stl_write}, {NULL, NULL}};
const io_target obj_targets[] = {{"obj", obj_write}, {NULL, NULL}};
const io_target ply_targets[] = {{"ply", ply_write}, {NULL, NULL}};
