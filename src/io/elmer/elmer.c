/* elmer: Elmer's meshes, folders of text files.
 *
 *   mesh.header      numbers of nodes, elements and boundary elements; how many there are of each type
 *   mesh.nodes       number, -1, x y z
 *   mesh.elements    number, body, type, nodes
 *   mesh.boundary    number, boundary, two parents, type, nodes
 *   mesh.names       may be there: $ NAME = NUMBER, for bodies, then for boundaries
 *
 * A type is 100 times the family (1 point, 2 line, ... 8 hexahedron) and the number of nodes. Its nodes
 * are in VTK's order but for hexahedra of second order (elements.def of ElmerSolver). A body is a
 * region; facets have the number of their boundary as a group.
 */
#include "io/core/elements.h"
#include "io/core/folder.h"
#include "io/core/format.h"
#include "io/core/number.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { MOST_NODES = 99, CODES_PER_FAMILY = 100, N_DIMS = 4 };

static const io_node_order node_orders[] = {
    {PLANISH_CELL_HEXAHEDRON20,
     {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 16, 17,
                                 18, 19, 12, 13, 14, 15, 23, 21, 20, 22, 24, 25, 26}},
    {0, {0}}};

/** Shape of each family, and its number of corners. */
static const struct {
    uint8_t shape, corners;
} families[] = {{IO_NO_SHAPE, 0}, {IO_POINT, 1},         {IO_LINE, 2},
                {IO_TRIANGLE, 3}, {IO_QUADRILATERAL, 4}, {IO_TETRAHEDRON, 4},
                {IO_PYRAMID, 5},  {IO_PRISM, 6},         {IO_HEXAHEDRON, 8}};
enum { N_FAMILIES = sizeof families / sizeof *families };

/** Elements of one of the two files while they are read. */
typedef struct elmer_elements {
    io_model *model;
    io_folder_file file;
    io_record_kind kind;
    int words;    /* of a row before the type, its number among them */
    int group_at; /* which of these is the body or boundary */
    int64_t n;
    int is_boundary;
    int64_t uniform;           /* type that all elements have; 0: they differ */
    int64_t first, first_node; /* index of the first of these in its list, and of its first node */
    unsigned dims;             /* bits: dimensions of the elements */
} elmer_elements;

/* ---- types ---------------------------------------------------------------------------------- */

/** Return the type of that code; of no shape if there is none. */
static io_element_type type_of(int64_t code) {
    static const uint8_t of_third_order[N_DIMS] = {0, 4, 10, 20}; /* nodes of simplices */
    const int64_t family = code / CODES_PER_FAMILY, nodes = code % CODES_PER_FAMILY;
    if (family < 1 || family >= N_FAMILIES || nodes == 0)
        return (io_element_type){.shape = IO_NO_SHAPE};
    io_element_type type = {.shape = families[family].shape, .nodes = (uint16_t)nodes};
    const int corners = families[family].corners, dim = io_element_dim(&type);
    const int is_cubic = corners == dim + 1 && nodes == of_third_order[dim];
    type.order = nodes == corners ? 1 : is_cubic ? 3 : 2;
    return type;
}

/** Return the planish_cell_type that elements of a type become; 0: they hold their nodes. Pyramids and
 *  prisms with nodes of faces have no order that Elmer says. */
static int cell_type_of(const io_element_type *type) {
    const int is_known = type->nodes != 14 && type->nodes != 18;
    if (io_element_use(type) == IO_KEEP)
        return io_simplex_type(io_element_dim(type), io_element_mids(type) > 0);
    return is_known ? io_element_other(type) : 0;
}

/* ---- elements ------------------------------------------------------------------------------- */

/** Take the number of an element, which may be NUMBER/PART. */
static int take_element_number(const elmer_elements *e, io_cursor *cursor, int64_t row,
                               int64_t *number, planish_error *error) {
    io_skip_space(cursor);
    const char *at = cursor->at;
    if (io_parse_integer(&cursor->at, cursor->end, number))
        return io_fail_at(&e->file.view, at, error,
                          "%s %lld: its number expected (the file may be cut short)", e->kind.what,
                          (long long)row);
    if (cursor->at < cursor->end && *cursor->at == '/')
        io_next_word(cursor);
    if (cursor->at < cursor->end && !io_is_space(*cursor->at))
        return io_fail_at(&e->file.view, at, error, "%s %lld: its number expected", e->kind.what,
                          (long long)row);
    return PLANISH_OK;
}

/** Put an element in its place among those of its type (uniform), or behind all. */
static int add_element(elmer_elements *e, int type, const int32_t *node, int64_t row,
                       int64_t number, int32_t group, planish_error *error) {
    const int dim = io_simplex_dim(type);
    if (!e->uniform)
        return dim > 0 ? io_model_add_simplex(e->model, type, node, group, number, error)
                       : io_model_add_other(e->model, type, node, group, number, error);
    const int64_t i = e->first + row;
    if (dim > 0) {
        io_cells *cells = io_model_cells(e->model, dim);
        memcpy(cells->nodes + i * (dim + 1), node, (size_t)(dim + 1) * sizeof *node);
        if (io_has_mids(type))
            io_cells_set_mids(e->model, dim, i, node);
        cells->number[i] = number;
        cells->entity[i] = group;
        return PLANISH_OK;
    }
    io_others_set(e->model, i, e->first_node + row * io_cell_type_nodes(type), type, node, number);
    io_model_others(e->model, io_cell_type_dim(type))->entity[i] = group;
    return PLANISH_OK;
}

/** Take the nodes of an element as indices. */
static int take_nodes(const elmer_elements *e, io_cursor *cursor, int64_t number, int n,
                      int32_t *nodes, planish_error *error) {
    for (int k = 0; k < n; k++) {
        int64_t node;
        io_skip_space(cursor);
        const char *at = cursor->at;
        if (io_integer(cursor, &node))
            return io_fail_at(&e->file.view, at, error,
                              "%s %lld: node %d of %d expected (the file may be cut short)",
                              e->kind.what, (long long)number, k + 1, n);
        const int64_t index = io_node_index(e->model, node);
        nodes[k] = (int32_t)index;
        if (index < 0)
            return io_fail_no_node(&e->file.view, at, e->kind.what, number, node, error);
    }
    return PLANISH_OK;
}

/** Read one element: what is before its type, the type, its nodes. */
static int read_element(elmer_elements *e, io_cursor *cursor, int64_t row, planish_error *error) {
    const io_model *view = &e->file.view;
    int64_t number = 0, code = 0, word = 0, group = 0;
    int32_t nodes[MOST_NODES] = {0};
    int status = take_element_number(e, cursor, row + 1, &number, error);
    for (int k = 1; k < e->words && !status; k++) {
        status = io_take_whole(&e->kind, cursor, row + 1, INT32_MIN, INT32_MAX - 1, &word, error);
        group = k == e->group_at && !status ? word : group;
    }
    io_skip_space(cursor);
    const char *at = cursor->at;
    if (!status)
        status = io_take_whole(&e->kind, cursor, row + 1, 0, INT32_MAX, &code, error);
    if (status)
        return status;
    if (e->uniform && code != e->uniform)
        return PLANISH_ERROR_FORMAT; /* they differ: all are read again, in order */
    const io_element_type type = type_of(code);
    if (type.shape == IO_NO_SHAPE)
        return io_fail_at(view, at, error, "%s %lld: there is no type %lld", e->kind.what,
                          (long long)number, (long long)code);
    if (io_element_use(&type) == IO_REFUSE)
        return io_fail_order(view, at, e->kind.what, "", error);
    status = take_nodes(e, cursor, number, type.nodes, nodes, error);
    if (status)
        return status;
    const int cell = cell_type_of(&type);
    if (cell)
        return add_element(e, cell, nodes, row, number, (int32_t)group, error);
    for (int k = 0; k < type.nodes; k++)
        io_hold_node(e->model, nodes[k], io_element_reason(&type));
    io_element_count(e->model, &type, 1);
    return PLANISH_OK;
}

static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    int status = PLANISH_OK;
    for (int64_t row = begin; row < end && !status; row++)
        status = read_element(context, cursor, row, error);
    return status;
}

/** Find the type of the first element, if elements like it go into a list of the model; else 0. */
static int64_t first_type(const elmer_elements *e, io_cursor cursor) {
    int64_t code = 0;
    for (int k = 0; k < e->words; k++)
        io_next_word(&cursor);
    if (io_integer(&cursor, &code))
        return 0;
    const io_element_type type = type_of(code);
    return type.shape != IO_NO_SHAPE && io_element_use(&type) != IO_REFUSE && cell_type_of(&type)
               ? code
               : 0;
}

/** Read elements that are all of one type by threads. If they are not, e->uniform is 0 then, and nothing
 *  has been added. */
static int read_uniform(elmer_elements *e, io_text *text, io_cursor *cursor, planish_error *error) {
    const io_element_type type = type_of(e->uniform);
    const int cell = cell_type_of(&type), dim = io_element_dim(&type),
              is_simplex = io_simplex_dim(cell);
    io_cells *cells = io_model_cells(e->model, dim);
    io_others *others =
        io_model_others(e->model, dim); /* not looked at where there are simplices */
    planish_error ignored;
    int status = is_simplex ? io_cells_reserve(e->model, dim, e->n, 1, 1, error)
                            : io_others_reserve(e->model, dim, e->n, e->n * type.nodes, 1, error);
    if (!status && io_element_mids(&type) > 0)
        status = io_cells_reserve_mids(e->model, dim, error);
    if (status)
        return status;
    e->first = is_simplex ? cells->n : others->n;
    e->first_node = is_simplex ? 0 : others->n_nodes;
    if (io_text_records(text, cursor, e->n, e->words + 1 + type.nodes, read_elements, e,
                        &ignored)) {
        e->uniform = 0;
        return PLANISH_OK;
    }
    if (is_simplex) {
        cells->n += e->n;
    } else {
        others->n += e->n;
        others->n_nodes += e->n * type.nodes;
    }
    return PLANISH_OK;
}

/** Make entities of the groups of elements behind the first ones of each list, n of it. */
static int index_groups(elmer_elements *e, const int64_t *n, planish_error *error) {
    int status = PLANISH_OK;
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS && !status; k++) {
        const io_list list = io_model_list(e->model, k);
        if (list.n == n[k])
            continue;
        e->dims |= 1u << list.dim;
        if (k >= IO_FLAT_LIST)
            e->model->n_other += list.n - n[k];
        status = io_model_index_tags(e->model, list.dim, list.entity + n[k], list.n - n[k], error);
    }
    return status;
}

/** Read the file of elements of that name, n of them. */
static int read_element_file(elmer_elements *e, const char *name, planish_error *error) {
    int64_t before[IO_N_LISTS];
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++)
        before[k] = io_model_list(e->model, k).n;
    int status = io_folder_open(e->model, name, 0, e->n > 0, &e->file, error);
    if (status || e->n == 0)
        return status;
    io_model *view = &e->file.view;
    io_text text;
    io_text_init(&text, view);
    io_cursor cursor = io_begin_text(view->input.data, view->input.size);
    e->kind.model = view;
    status = io_check_count(view, cursor, e->n, 2 * (e->words + 2), e->kind.what, error);
    e->uniform = status ? 0 : first_type(e, cursor);
    if (!status && e->uniform) {
        io_cursor from = cursor;
        status = read_uniform(e, &text, &from, error);
        cursor = e->uniform ? from : cursor;
    }
    if (!status && !e->uniform)
        status = io_text_records(&text, &cursor, e->n, 1, read_elements, e, error);
    io_skip_space(&cursor); /* of the boundary more may follow, which ElmerSolver does not read */
    if (!status && cursor.at < cursor.end && !e->is_boundary)
        status = io_fail_at(view, cursor.at, error,
                            "more follows than the %lld elements of mesh.header", (long long)e->n);
    io_text_release(&text);
    return status ? status : index_groups(e, before, error);
}

/* ---- header and nodes ----------------------------------------------------------------------- */

enum { NODES, ELEMENTS, BOUNDARY, N_COUNTS };

static int read_header(io_model *model, int64_t *counts, planish_error *error) {
    io_folder_file file;
    int status = io_folder_open(model, "mesh.header", 0, 1, &file, error);
    if (status)
        return status;
    io_cursor cursor = io_begin_text(file.view.input.data, file.view.input.size);
    for (int i = 0; i < N_COUNTS && !status; i++) {
        const char *at = cursor.at;
        if (io_integer(&cursor, &counts[i]) || counts[i] < 0)
            status = io_fail_at(&file.view, at, error,
                                "numbers of nodes, elements and boundary elements expected");
    }
    io_folder_close(&file);
    return status;
}

/** Read nodes: number, a number that does not matter, coordinates. */
static int read_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                      planish_error *error) {
    io_model *model = context;
    const io_record_kind kind = {.model = model, .what = "node"};
    for (int64_t i = begin; i < end; i++) {
        int64_t part;
        int status = io_take_whole(&kind, cursor, i + 1, INT64_MIN, INT64_MAX,
                                   &model->node_number[i], error);
        if (!status)
            status = io_take_whole(&kind, cursor, i + 1, INT64_MIN, INT64_MAX, &part, error);
        if (!status)
            status = io_read_node(model, cursor, i, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_node_file(io_model *model, int64_t n, planish_error *error) {
    enum { WORDS = 5 };
    io_text text;
    io_cursor cursor = io_begin_text(model->input.data, model->input.size);
    int status = io_check_count(model, cursor, n, 2 * WORDS, "nodes", error);
    if (!status)
        status = io_model_make_nodes(model, n, 8, 0, 0, NULL, error);
    if (status)
        return status;
    model->node_number = pl_alloc_zero(n, sizeof *model->node_number);
    if (!model->node_number)
        return pl_fail_memory(error, "the numbers of nodes");
    io_text_init(&text, model);
    status = io_text_records(&text, &cursor, n, WORDS, read_nodes, model, error);
    io_text_release(&text);
    io_skip_space(&cursor);
    if (!status && cursor.at < cursor.end)
        status = io_fail_at(model, cursor.at, error,
                            "more follows than the %lld nodes of mesh.header", (long long)n);
    return status ? status : io_reduce_node_numbers(model, error);
}

/* ---- names ---------------------------------------------------------------------------------- */

/** Give the name to the groups of that number, of the dimensions that bits say. */
static int name_groups(io_model *model, unsigned dims, int64_t number, io_slice name,
                       planish_error *error) {
    int status = PLANISH_OK;
    for (int dim = 1; dim < N_DIMS && !status; dim++)
        if ((dims >> dim & 1) && number >= INT32_MIN && number < INT32_MAX &&
            io_model_has_entity(model, dim, (int32_t)number))
            status = io_model_group(model, dim, (int32_t)number, name.begin, io_slice_length(name),
                                    error);
    return status;
}

/** Return whether the line has a word. */
static int has_word(io_slice line, const char *word) {
    const int64_t length = (int64_t)strlen(word);
    for (const char *at = line.begin; at + length <= line.end; at++)
        if (memcmp(at, word, (size_t)length) == 0)
            return 1;
    return 0;
}

/** Read lines "$ NAME = NUMBER", behind comments ('!') that say of bodies and of boundaries. */
static int read_names(io_model *model, unsigned of_bodies, unsigned of_boundaries,
                      planish_error *error) {
    unsigned dims = of_bodies | of_boundaries;
    io_folder_file file;
    int status = io_folder_open(model, "mesh.names", 0, 0, &file, error);
    if (status || !file.view.input.data)
        return status;
    io_cursor cursor = io_begin_text(file.view.input.data, file.view.input.size);
    while (!status && cursor.at < cursor.end) {
        const io_slice line = io_slice_trim(io_next_line(&cursor));
        const char *equals = memchr(line.begin, '=', (size_t)io_slice_length(line));
        int64_t number;
        if (io_slice_length(line) > 0 && *line.begin == '!')
            dims = has_word(line, "bodies")       ? of_bodies
                   : has_word(line, "boundaries") ? of_boundaries
                                                  : dims;
        if (io_slice_length(line) == 0 || *line.begin != '$' || !equals)
            continue;
        const io_slice name = io_slice_trim((io_slice){line.begin + 1, equals});
        const io_slice value = io_slice_trim((io_slice){equals + 1, line.end});
        if (io_slice_length(name) > 0 && io_slice_integer(value, &number) == 0)
            status = name_groups(model, dims, number, name, error);
    }
    io_folder_close(&file);
    return status;
}

/* ---- the format ----------------------------------------------------------------------------- */

static int elmer_read(io_model *model, planish_error *error) {
    int64_t counts[N_COUNTS];
    if (!model->folder)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is one of the files of an Elmer mesh; give the folder that has them",
                       model->input.path);
    model->node_order = node_orders;
    int status = read_header(model, counts, error);
    if (!status)
        status = read_node_file(model, counts[NODES], error);
    elmer_elements elements = {
        .model = model, .kind.what = "element", .words = 2, .group_at = 1, .n = counts[ELEMENTS]};
    elmer_elements boundary = {.model = model,
                               .kind.what = "boundary element",
                               .is_boundary = 1,
                               .words = 4,
                               .group_at = 1,
                               .n = counts[BOUNDARY]};
    if (!status)
        status = read_element_file(&elements, "mesh.elements", error);
    if (!status)
        status = read_element_file(&boundary, "mesh.boundary", error);
    if (!status)
        status = read_names(model, elements.dims, boundary.dims, error);
    io_folder_close(&elements.file);
    io_folder_close(&boundary.file);
    return status;
}

/* Nothing but numbers: any table looks like that. */
static int elmer_recognise(const char *data, int64_t size) {
    (void)data;
    (void)size;
    return 0;
}

/** Results, which ElmerSolver writes into the folder of the mesh, are of the old coordinates. */
static int is_copied(const char *name) {
    return strncmp(name, "mesh.", 5) == 0 || strcmp(name, "entities.sif") == 0;
}

static const char *const files[] = {"mesh.nodes", "mesh.header", "mesh.elements", "mesh.boundary",
                                    NULL};
static const char *const places[] = {"", NULL};
static const io_folder folder = {
    .files = files, .places = places, .of_places = "partitioning.", .is_copied = is_copied};

/* Of the files in the folder, which are not named by themselves. */
static const char *const extensions[] = {".nodes", ".header", ".elements", ".boundary", NULL};

const io_format io_format_elmer = {.name = "elmer",
                                   .extensions = extensions,
                                   .has_no_end = 1,
                                   .recognise = elmer_recognise,
                                   .read = elmer_read,
                                   .folder = &folder};
