/* unv_elements: elements of universal files.
 *
 * An element has a line of numbers (its own, its type, a property, a material, a colour and how many
 * nodes it has), if it is a beam a line of three numbers, and lines of nodes. The type (the FE
 * descriptor) tells the shape. Nodes of second order go round: a corner, a mid, a corner, and so on,
 * in rings from below. Gmsh has elements with nodes in the middle of faces, too, under the numbers
 * of linear types, in its own order.
 */
#include "io/unv/unv_reader.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { MOST_WORDS = 8, MOST_NODES = 27, N_ORIENTATION = 3 };

/** Known types of elements, by shape and number of nodes. */
static const io_element_type types[] = {
    {"line", IO_LINE, 1, 2},
    {"line", IO_LINE, 2, 3},
    {"triangle", IO_TRIANGLE, 1, 3},
    {"triangle", IO_TRIANGLE, 2, 6},
    {"triangle", IO_TRIANGLE, 2, 7},
    {"triangle", IO_TRIANGLE, 3, 9},
    {"triangle", IO_TRIANGLE, 3, 10},
    {"quadrilateral", IO_QUADRILATERAL, 1, 4},
    {"quadrilateral", IO_QUADRILATERAL, 2, 8},
    {"quadrilateral", IO_QUADRILATERAL, 2, 9},
    {"tetrahedron", IO_TETRAHEDRON, 1, 4},
    {"tetrahedron", IO_TETRAHEDRON, 2, 10},
    {"pyramid", IO_PYRAMID, 1, 5},
    {"pyramid", IO_PYRAMID, 2, 13},
    {"wedge", IO_PRISM, 1, 6},
    {"wedge", IO_PRISM, 2, 15},
    {"wedge", IO_PRISM, 2, 18},
    {"brick", IO_HEXAHEDRON, 1, 8},
    {"brick", IO_HEXAHEDRON, 2, 20},
    {"brick", IO_HEXAHEDRON, 2, 27},
    {"point", IO_POINT, 1, 1},
};

enum { N_TYPES = sizeof types / sizeof *types };

/** Orders of second order: corners and mids alternate in a ring. Those of 18 and 27 nodes: Gmsh's. */
const io_node_order unv_node_orders[] = {
    {PLANISH_CELL_LINE3, {0, 2, 1}},
    {PLANISH_CELL_TRIANGLE6, {0, 2, 4, 1, 3, 5}},
    {PLANISH_CELL_QUADRILATERAL8, {0, 2, 4, 6, 1, 3, 5, 7}},
    {PLANISH_CELL_QUADRILATERAL9, {0, 2, 4, 6, 1, 3, 5, 7, 8}},
    {PLANISH_CELL_TETRAHEDRON10, {0, 2, 4, 9, 1, 3, 5, 6, 7, 8}},
    {PLANISH_CELL_PYRAMID13, {0, 2, 4, 6, 12, 1, 3, 5, 7, 8, 9, 10, 11}},
    {PLANISH_CELL_WEDGE15, {0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8}},
    {PLANISH_CELL_WEDGE18, {0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16}},
    {PLANISH_CELL_HEXAHEDRON20,
     {0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11}},
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  11, 13, 9,  16, 18,
                                 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26}},
    {0, {0}}};

/** Return the shape of an FE descriptor. Flat ones come in families of ten: plane stress, plane
 *  strain, plates, membranes, axisymmetric solids, thin shells. */
static io_shape shape_of(int64_t type) {
    if (type >= 41 && type <= 99) {
        const int64_t unit = type % 10;
        if (type == 71 || type == 74) /* membranes have the linear ones the other way round */
            return type == 71 ? IO_QUADRILATERAL : IO_TRIANGLE;
        return unit >= 1 && unit <= 3   ? IO_TRIANGLE
               : unit >= 4 && unit <= 6 ? IO_QUADRILATERAL
                                        : IO_ANY_SHAPE;
    }
    switch (type) {
    case 11: /* rod, beams, pipes */
    case 21:
    case 22:
    case 23:
    case 24:
    case 25:
    case 31:
    case 32:
    case 171: /* axisymmetric shells */
    case 172:
        return IO_LINE;
    case 300: /* libMesh's */
        return IO_QUADRILATERAL;
    case 101: /* thick shells */
    case 102:
    case 112:
    case 113:
        return IO_PRISM;
    case 104:
    case 105:
    case 115:
    case 116:
        return IO_HEXAHEDRON;
    case 111:
    case 118:
        return IO_TETRAHEDRON;
    case 114: /* of cubic wedges, but with 13 nodes Salome's pyramids */
    case 312:
        return IO_PYRAMID;
    case 161: /* lumped mass */
        return IO_POINT;
    default:
        return IO_ANY_SHAPE;
    }
}

/** Return whether an FE descriptor, of a linear element, with so many nodes is Gmsh's: 9 nodes of a
 *  quadrilateral, 18 of a wedge, 27 of a brick. */
static int is_of_gmsh(int64_t type, int64_t n) {
    enum { SHELL = 94, WEDGE = 112, BRICK = 115 };
    return (type == SHELL && n == 9) || (type == WEDGE && n == 18) || (type == BRICK && n == 27);
}

/** Find the row of an FE descriptor with that many nodes; -1: its nodes are held. */
static int find_row(int64_t type, int64_t n) {
    const io_shape shape = shape_of(type);
    if ((n == 18 || n == 27) && !is_of_gmsh(type, n))
        return -1;
    for (int i = 0; i < N_TYPES; i++)
        if (types[i].shape == shape && types[i].nodes == n)
            return i;
    return -1;
}

/* ---- lines of an element -------------------------------------------------------------------- */

/** The first line of an element. */
typedef struct heading {
    const char *at;
    int64_t number, type, property, material, n_nodes;
} heading;

static int take_heading(const unv_reader *r, io_cursor *cursor, heading *h, planish_error *error) {
    const unv_dataset *d = r->dataset;
    int64_t word[MOST_WORDS];
    io_cursor line = io_take_line(cursor);
    h->at = line.at;
    for (int i = 0; i < d->words; i++)
        if (io_integer(&line, &word[i]))
            return io_fail_at(r->model, h->at, error,
                              "an element's line of %d whole numbers expected", d->words);
    *h = (heading){
        h->at, word[0], word[d->type], word[d->property], word[d->material], word[d->words - 1]};
    if (h->n_nodes < 1 || h->n_nodes > io_left(cursor))
        return io_fail_at(r->model, h->at, error, "element %lld cannot have %lld nodes",
                          (long long)h->number, (long long)h->n_nodes);
    if (h->property <= INT32_MIN || h->property > INT32_MAX || h->material < INT32_MIN ||
        h->material > INT32_MAX)
        return io_fail_at(r->model, h->at, error,
                          "element %lld: a property or material beyond 32 bits",
                          (long long)h->number);
    return PLANISH_OK;
}

static int count_words(io_cursor line) {
    int n = 0;
    while (io_slice_length(io_next_word(&line)) > 0)
        n++;
    return n;
}

/** Return whether a line of three numbers stands before the nodes of a line element, as it does
 *  for beams; some programs leave it out. */
static int has_orientation(io_cursor cursor, int64_t n_nodes) {
    const int first = count_words(io_take_line(&cursor));
    return first == N_ORIENTATION &&
           (n_nodes != N_ORIENTATION || count_words(io_take_line(&cursor)) == N_ORIENTATION);
}

static int take_node(const unv_reader *r, io_cursor *cursor, const heading *h, int32_t *node,
                     planish_error *error) {
    int64_t number;
    if (io_integer(cursor, &number))
        return io_fail_at(r->model, cursor->at, error, "element %lld: %lld nodes expected",
                          (long long)h->number, (long long)h->n_nodes);
    *node = (int32_t)io_node_index(r->model, number);
    return *node < 0 ? io_fail_no_node(r->model, h->at, "element", h->number, number, error)
                     : PLANISH_OK;
}

/** Bring Gmsh's nodes of a quadrilateral, corners before mids, into a ring. */
static void make_ring(int32_t *node) {
    int32_t ring[8];
    for (int k = 0; k < 4; k++) {
        ring[2 * k] = node[k];
        ring[2 * k + 1] = node[4 + k];
    }
    memcpy(node, ring, sizeof ring);
}

/* ---- runs ----------------------------------------------------------------------------------- */

/** Hold the nodes of an element of no known type: rigid elements, springs, gaps and others. */
static int hold_element(unv_reader *r, io_cursor *cursor, const heading *h) {
    r->model->n_other++;
    for (int64_t k = 0; k < h->n_nodes; k++) {
        int32_t node;
        const int status = take_node(r, cursor, h, &node, r->error);
        if (status)
            return status;
        io_hold_node(r->model, node, IO_HELD_BY_OTHER);
    }
    return PLANISH_OK;
}

/** Note a record of an element of a known type, and what its material says. is_first: no such record
 *  stands before it, so that a run begins. */
static int add_to_run(unv_reader *r, const heading *h, int row, int64_t tokens, const char *end,
                      int is_first) {
    const io_section run = {
        .keyword = row, .count = 1, .data = h->at, .end = end, .tokens = tokens};
    const int64_t n = r->runs.n;
    int status = is_first ? io_sections_add(&r->runs, run, r->error)
                          : io_runs_add(&r->runs, row, tokens, h->at, end, r->error);
    if (!status && r->runs.n > n &&
        !pl_append(&r->run_dataset, &r->n_run_datasets, &r->run_capacity, &r->dataset,
                   sizeof r->dataset))
        status = pl_fail_memory(r->error, "the elements");
    const io_element_type *type = &types[row];
    const int dim = io_element_dim(type);
    if (io_element_use(type) == IO_KEEP)
        r->n_of_list[dim]++;
    else if (io_element_other(type))
        r->n_of_list[io_others_list(dim)]++;
    r->has_materials |= r->has_material && h->material != r->material;
    r->material = h->material;
    r->has_material = 1;
    return status;
}

int unv_find_runs(unv_reader *r, const io_section *s) {
    io_cursor cursor = {s->data, s->end};
    int status = PLANISH_OK, is_first = 1;
    for (io_skip_space(&cursor); cursor.at < cursor.end && !status; io_skip_space(&cursor)) {
        heading h;
        status = take_heading(r, &cursor, &h, r->error);
        if (status)
            return status;
        const int row = find_row(h.type, h.n_nodes), is_line = shape_of(h.type) == IO_LINE;
        const int is_beam = is_line && has_orientation(cursor, h.n_nodes);
        if (row >= 0 && io_element_use(&types[row]) == IO_REFUSE)
            return io_fail_order(r->model, h.at, types[row].name, "", r->error);
        for (int i = 0; i < (is_beam ? N_ORIENTATION : 0); i++)
            io_next_word(&cursor);
        if (row < 0) {
            status = hold_element(r, &cursor, &h);
            is_first = 1;
            continue;
        }
        for (int64_t k = 0; k < h.n_nodes; k++)
            if (io_slice_length(io_next_word(&cursor)) == 0)
                return io_fail_at(r->model, cursor.at, r->error,
                                  "element %lld: %lld nodes expected", (long long)h.number,
                                  (long long)h.n_nodes);
        const int64_t n_before = r->dataset->words + (is_beam ? N_ORIENTATION : 0);
        status = add_to_run(r, &h, row, n_before + h.n_nodes, cursor.at, is_first);
        is_first = 0;
    }
    return status;
}

/* ---- elements ------------------------------------------------------------------------------- */

static int read_run(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                    planish_error *error) {
    const unv_reader *r = context;
    const int list = r->run.dim ? r->run.dim : io_others_list(io_element_dim(r->run.row));
    int32_t *material = *io_model_regions(r->model, list);
    for (int64_t i = begin; i < end; i++) {
        heading h;
        int32_t nodes[MOST_NODES];
        int status = take_heading(r, cursor, &h, error);
        if (status)
            return status;
        if (find_row(h.type, h.n_nodes) != r->row)
            return io_fail_at(r->model, h.at, error, "element %lld: a %s expected",
                              (long long)h.number, types[r->row].name);
        for (int k = 0; r->has_orientation && k < N_ORIENTATION; k++)
            io_next_word(cursor);
        for (int k = 0; k < types[r->row].nodes && !status; k++)
            status = take_node(r, cursor, &h, &nodes[k], error);
        if (status)
            return status;
        if (h.n_nodes == 9 && is_of_gmsh(h.type, h.n_nodes))
            make_ring(nodes);
        io_run_set(&r->run, i, nodes, (int32_t)h.property, h.number);
        if (material && (r->run.dim || r->run.type))
            material[r->run.first + i] = (int32_t)h.material;
    }
    return PLANISH_OK;
}

/** Make room for the materials of all elements, where they differ. */
static int reserve_materials(unv_reader *r) {
    for (int k = IO_FIRST_LIST; r->has_materials && k < IO_N_LISTS; k++) {
        if (r->n_of_list[k] == 0)
            continue;
        int32_t *material = pl_alloc_zero(r->n_of_list[k], sizeof *material);
        if (!material)
            return pl_fail_memory(r->error, "the materials of elements");
        *io_model_regions(r->model, k) = material;
    }
    return PLANISH_OK;
}

int unv_read_elements(unv_reader *r) {
    int status = reserve_materials(r);
    for (int64_t i = 0; i < r->runs.n && !status; i++) {
        const io_section *s = &r->runs.section[i];
        r->dataset = r->run_dataset[i];
        r->row = s->keyword;
        r->has_orientation = s->tokens > r->dataset->words + types[r->row].nodes;
        status = io_run_read(r->model, &r->text, s, &types[r->row], read_run, r, &r->run, r->error);
    }
    return status;
}
