/* gmsh4: entities, nodes, elements and periodic pairs of MSH 4.1 and 4.0, ASCII and binary.
 *
 * MSH 4.0 differs in this: points have a box; sections of nodes and elements do not say their
 * smallest and largest tag; a block has the entity before its dimension; the tag of a node stands
 * before its coordinates, not apart; tags of nodes and elements, and counts of parts, are of 32
 * bits in binary files; transforms of periodic pairs are marked by a word, or by a count of -1.
 *
 * Nodes and elements stand in blocks, one or more for each entity of the geometry; the physical
 * groups are those of the entities. Parametric nodes have up to three more numbers behind their
 * coordinates: the place on their curve or surface. They are passed over and stay in the file as
 * they are; nodes on curves and surfaces of the geometry hardly ever move.
 *
 * In a partitioned mesh the elements are on partitioned entities, which count as their parents.
 * Those between parts, whose parent is of a higher dimension, are nothing of the geometry: their
 * elements hold no nodes.
 */
#include "io/gmsh/gmsh_reader.h"

#include <stdlib.h>

#include "base/memory.h"
#include "base/status.h"
#include "io/core/binary.h"

enum {
    NODE_TEXT = 7,     /* bytes of the shortest node: its tag and three coordinates */
    NODE_SIZE = 4 * 8, /* bytes of a node in a binary file, at least; of MSH 4.0: */
    NODE_SIZE_40 = 4 + 3 * 8,
    ELEMENT_TEXT = 3,     /* bytes of the shortest element: its tag and a node */
    ELEMENT_SIZE = 2 * 8, /* bytes of an element in a binary file, at least; of MSH 4.0: */
    ELEMENT_SIZE_40 = 2 * 4,
    N_KINDS = 4 /* points, curves, surfaces, volumes */
};

static int is_40(const gmsh_reader *reader) {
    return reader->version == 40;
}

/** A count or tag that is of 32 bits in binary files of MSH 4.0. */
static int take_short(gmsh_reader *reader, int64_t *value, const char *what) {
    int32_t narrow = 0;
    if (!is_40(reader))
        return gmsh_take_size(reader, value, what);
    const int status = gmsh_take_int(reader, &narrow, what);
    *value = narrow;
    return status;
}

/* ---- entities ----------------------------------------------------------------------------- */

static int compare_places(const void *left, const void *right) {
    const gmsh_place *a = left, *b = right;
    if (a->dim != b->dim)
        return a->dim < b->dim ? -1 : 1;
    return (a->tag > b->tag) - (a->tag < b->tag);
}

static const gmsh_place *find_place(const gmsh_reader *reader, int dim, int32_t tag) {
    gmsh_place key = {.dim = dim, .tag = tag};
    if (reader->n_places == 0)
        return NULL;
    return bsearch(&key, reader->place, (size_t)reader->n_places, sizeof key, compare_places);
}

static void sort_places(gmsh_reader *reader) {
    if (reader->n_places > 0)
        qsort(reader->place, (size_t)reader->n_places, sizeof *reader->place, compare_places);
}

/** A list of n int32 at the cursor, to be released by pl_free. */
static int take_list(gmsh_reader *reader, int64_t n, int32_t **list) {
    int status = gmsh_check_count(reader, n, 2, 4, "physical groups");
    *list = NULL;
    if (status)
        return status;
    *list = pl_alloc(n, sizeof **list);
    if (!*list)
        return pl_fail_memory(reader->error, "physical groups");
    for (int64_t i = 0; !status && i < n; i++) {
        status = gmsh_take_int(reader, &(*list)[i], "physical group");
        /* The sign is the orientation of the entity in the group. */
        if (!status && (*list)[i] < 0 && (*list)[i] != INT32_MIN)
            (*list)[i] = -(*list)[i];
    }
    return status;
}

/** The box (a point: its coordinates), physical groups and boundary of an entity: *entity is the
 * model's entity of tag and these groups. */
static int take_description(gmsh_reader *reader, int dim, int32_t tag, int32_t *entity) {
    int64_t n_physical, n_boundary;
    int32_t *physical, ignored;
    int status = gmsh_skip_reals(reader, dim == 0 && !is_40(reader) ? 3 : 6, "box of an entity");
    if (!status)
        status = gmsh_take_size(reader, &n_physical, "number of physical groups");
    if (status)
        return status;
    status = take_list(reader, n_physical, &physical);
    if (!status) {
        *entity =
            io_model_entity(reader->model, dim, tag, (int)n_physical, physical, reader->error);
        status = *entity < 0 ? *entity : 0;
    }
    pl_free(physical);
    if (!status && dim > 0) {
        status = gmsh_take_size(reader, &n_boundary, "number of bounding entities");
        for (int64_t i = 0; !status && i < n_boundary; i++)
            status = gmsh_take_int(reader, &ignored, "bounding entity");
    }
    return status;
}

static int add_place(gmsh_reader *reader, gmsh_place place) {
    void *grown = pl_grow(reader->place, reader->n_places, reader->n_places + 1,
                          &reader->place_capacity, sizeof place);
    if (!grown)
        return pl_fail_memory(reader->error, "entities");
    reader->place = grown;
    reader->place[reader->n_places++] = place;
    return 0;
}

typedef int entity_fn(gmsh_reader *reader, int dim);

/** The numbers of points, curves, surfaces and volumes, and then all of these. */
static int read_entities(gmsh_reader *reader, entity_fn *read) {
    int64_t n[N_KINDS];
    int status = 0;
    for (int dim = 0; !status && dim < N_KINDS; dim++)
        status = gmsh_take_size(reader, &n[dim], "number of entities");
    for (int dim = 0; !status && dim < N_KINDS; dim++)
        for (int64_t i = 0; !status && i < n[dim]; i++)
            status = read(reader, dim);
    sort_places(reader);
    return status;
}

static int read_entity(gmsh_reader *reader, int dim) {
    gmsh_place place = {.dim = dim};
    int status = gmsh_take_int(reader, &place.tag, "tag of an entity");
    if (!status)
        status = take_description(reader, dim, place.tag, &place.entity);
    return status ? status : add_place(reader, place);
}

int gmsh4_entities(gmsh_reader *reader) {
    return reader->model->is_binary && gmsh_end_line(reader) ? PLANISH_ERROR_FORMAT
                                                             : read_entities(reader, read_entity);
}

static int read_partitioned(gmsh_reader *reader, int dim) {
    gmsh_place place = {.dim = dim};
    int32_t parent_dim, parent_tag, part;
    int64_t n_parts;
    int status = gmsh_take_int(reader, &place.tag, "tag of a partitioned entity");
    if (!status)
        status = gmsh_take_int(reader, &parent_dim, "dimension of a parent entity");
    if (!status)
        status = gmsh_take_int(reader, &parent_tag, "tag of a parent entity");
    if (!status)
        status = take_short(reader, &n_parts, "number of parts");
    for (int64_t i = 0; !status && i < n_parts; i++)
        status = gmsh_take_int(reader, &part, "part");
    if (status)
        return status;
    place.interface = parent_dim > dim;
    status = take_description(reader, dim, place.interface ? place.tag : parent_tag, &place.entity);
    return status ? status : add_place(reader, place);
}

/** $PartitionedEntities: number of parts, ghost entities (tag and part of each), entities. */
int gmsh4_partitioned_entities(gmsh_reader *reader) {
    int64_t n_parts, n_ghosts;
    int32_t ignored;
    int status = reader->model->is_binary ? gmsh_end_line(reader) : 0;
    if (!status)
        status = take_short(reader, &n_parts, "number of parts");
    if (!status)
        status = take_short(reader, &n_ghosts, "number of ghost entities");
    for (int64_t i = 0; !status && i < n_ghosts; i++) {
        status = gmsh_take_int(reader, &ignored, "tag of a ghost entity");
        if (!status)
            status = gmsh_take_int(reader, &ignored, "part of a ghost entity");
    }
    return status ? status : read_entities(reader, read_partitioned);
}

/* ---- blocks ------------------------------------------------------------------------------- */

/** The head of a section and of each of its blocks. kind: parametric, or the element type. */
typedef struct section_head {
    int64_t n_blocks, n;
} section_head;

typedef struct block_head {
    const char *at;
    int32_t dim, tag, kind;
    int64_t n;
} block_head;

static int take_section_head(gmsh_reader *reader, section_head *head) {
    int64_t ignored;
    int status = reader->model->is_binary ? gmsh_end_line(reader) : 0;
    if (!status)
        status = gmsh_take_size(reader, &head->n_blocks, "number of blocks");
    if (!status)
        status = gmsh_take_size(reader, &head->n, "number of nodes or elements");
    if (!status && !is_40(reader))
        status = gmsh_take_size(reader, &ignored, "smallest tag");
    if (!status && !is_40(reader))
        status = gmsh_take_size(reader, &ignored, "largest tag");
    return status;
}

/** done: nodes or elements of the blocks before. */
static int take_block_head(gmsh_reader *reader, const section_head *section, int64_t done,
                           block_head *head) {
    int status;
    if (!reader->model->is_binary)
        io_skip_space(&reader->cursor);
    head->at = reader->cursor.at;
    status = gmsh_take_int(reader, is_40(reader) ? &head->tag : &head->dim,
                           "dimension and entity of a block");
    if (!status)
        status = gmsh_take_int(reader, is_40(reader) ? &head->dim : &head->tag,
                               "dimension and entity of a block");
    if (!status)
        status = gmsh_take_int(reader, &head->kind, "kind of a block");
    if (!status)
        status = gmsh_take_size(reader, &head->n, "size of a block");
    if (!status && (head->dim < 0 || head->dim > 3))
        return io_fail_at(reader->model, head->at, reader->error, "block of dimension %d",
                          head->dim);
    if (!status && (head->n < 0 || head->n > section->n - done))
        return io_fail_at(reader->model, head->at, reader->error,
                          "the blocks have more than the %lld nodes or elements of the section",
                          (long long)section->n);
    return status;
}

static int check_total(const gmsh_reader *reader, const section_head *section, int64_t done) {
    if (done == section->n)
        return 0;
    return io_fail_at(reader->model, reader->cursor.at, reader->error,
                      "the blocks have %lld of the %lld nodes or elements of the section",
                      (long long)done, (long long)section->n);
}

/* ---- nodes -------------------------------------------------------------------------------- */

typedef struct node_block {
    const gmsh_reader *reader;
    int64_t first; /* index of the block's first node */
    int extra;     /* parametric coordinates of a node */
} node_block;

static int read_text_tags(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                          planish_error *error) {
    const node_block *block = context;
    int64_t *number = block->reader->model->node_number + block->first;
    for (int64_t i = begin; i < end; i++)
        if (io_integer(cursor, &number[i]))
            return io_fail_at(block->reader->model, cursor->at, error,
                              "node tag expected (the file may be cut short)");
    return 0;
}

static int read_text_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                            planish_error *error) {
    const node_block *block = context;
    double ignored;
    for (int64_t i = begin; i < end; i++) {
        if (is_40(block->reader) && read_text_tags(context, cursor, i, i + 1, error) != 0)
            return PLANISH_ERROR_FORMAT;
        int status = io_read_point(block->reader->model, cursor, block->first + i, error);
        if (status)
            return status;
        for (int k = 0; k < block->extra; k++)
            if (io_real(cursor, &ignored))
                return io_fail_at(block->reader->model, cursor->at, error,
                                  "parametric coordinate expected (the file may be cut short)");
    }
    return 0;
}

static int read_binary_tags(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                            planish_error *error) {
    const node_block *block = context;
    int64_t *number = block->reader->model->node_number + block->first;
    (void)error;
    for (int64_t i = begin; i < end; i++, cursor->at += 8)
        number[i] = io_load_i64(cursor->at, block->reader->swapped);
    return 0;
}

/** Bytes before the coordinates of a node, and in all. */
static int64_t tag_size(const gmsh_reader *reader) {
    return is_40(reader) ? 4 : 0;
}

static int64_t point_size(const node_block *block) {
    return tag_size(block->reader) + 8 * (3 + block->extra);
}

static int read_binary_points(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                              planish_error *error) {
    const node_block *block = context;
    const gmsh_reader *reader = block->reader;
    for (int64_t i = begin; i < end; i++, cursor->at += point_size(block)) {
        if (is_40(reader))
            reader->model->node_number[block->first + i] = io_load_i32(cursor->at, reader->swapped);
        int status =
            gmsh_load_point(reader, cursor->at + tag_size(reader), block->first + i, error);
        if (status)
            return status;
    }
    return 0;
}

static int read_text_block(gmsh_reader *reader, node_block *block, int64_t n) {
    int status = 0;
    if (!is_40(reader))
        status = io_text_records(&reader->text, &reader->cursor, n, 1, read_text_tags, block,
                                 reader->error);
    if (!status)
        status =
            io_text_records(&reader->text, &reader->cursor, n, is_40(reader) + 3 + block->extra,
                            read_text_points, block, reader->error);
    return status;
}

static int read_binary_block(gmsh_reader *reader, node_block *block, int64_t n) {
    io_model *model = reader->model;
    io_cursor *cursor = &reader->cursor;
    const int64_t size = point_size(block), apart = is_40(reader) ? 0 : 8;
    if (n == 0)
        return 0;
    if (n > io_left(cursor) / (apart + size))
        return io_fail_at(reader->model, cursor->at, reader->error,
                          "%lld nodes cannot be in the rest of the file", (long long)n);
    int status = 0;
    if (apart > 0)
        status = io_binary_records(model->threads, cursor, n, apart, read_binary_tags, block,
                                   reader->error);
    if (status)
        return status;
    io_span span = {.first_node = block->first,
                    .n_nodes = n,
                    .encoding = IO_FLOAT64,
                    .swapped = reader->swapped,
                    .offset = cursor->at - model->input.data + tag_size(reader),
                    .stride = size};
    status = io_model_span(model, span, reader->error);
    if (!status)
        status = io_binary_records(model->threads, cursor, n, size, read_binary_points, block,
                                   reader->error);
    return status;
}

int gmsh4_nodes(gmsh_reader *reader) {
    section_head section;
    block_head head;
    int64_t done = 0;
    int status = take_section_head(reader, &section);
    if (!status)
        status =
            gmsh_make_nodes(reader, section.n, NODE_TEXT, is_40(reader) ? NODE_SIZE_40 : NODE_SIZE);
    for (int64_t i = 0; !status && i < section.n_blocks; i++) {
        status = take_block_head(reader, &section, done, &head);
        if (status)
            break;
        node_block block = {reader, done, head.kind != 0 ? head.dim : 0};
        status = reader->model->is_binary ? read_binary_block(reader, &block, head.n)
                                          : read_text_block(reader, &block, head.n);
        for (int64_t k = 0; !status && block.extra > 0 && k < head.n; k++)
            io_hold_node(reader->model, (int32_t)(done + k), IO_HAS_PARAMETERS);
        done += !status ? head.n : 0;
    }
    if (!status)
        status = check_total(reader, &section, done);
    return status ? status : gmsh_index_nodes(reader);
}

/* ---- elements ----------------------------------------------------------------------------- */

typedef struct element_block {
    const gmsh_reader *reader;
    const io_element_type *type;
    io_cells *cells; /* NULL: nodes are held, not stored */
    int64_t first;   /* index of the block's first cell */
    uint8_t reason;  /* why nodes are held; 0: they are not */
    int32_t entity;
} element_block;

/** Node number i of the element that is put at index. */
static int put_node(const element_block *block, const char *at, int64_t index, int i,
                    int64_t number, planish_error *error) {
    int64_t node = io_node_index(block->reader->model, block->reader->numbers, number);
    if (node < 0)
        return io_fail_at(block->reader->model, at, error, "there is no node %lld",
                          (long long)number);
    if (block->cells)
        block->cells->nodes[index * block->type->nodes + i] = (int32_t)node;
    else if (block->reason != 0)
        io_hold_node(block->reader->model, node, block->reason);
    return 0;
}

static void put_number(const element_block *block, int64_t index, int64_t number) {
    if (!block->cells)
        return;
    block->cells->number[index] = number;
    block->cells->entity[index] = block->entity;
}

static int read_text_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                              planish_error *error) {
    const element_block *block = context;
    int64_t number;
    for (int64_t index = block->first + begin; index < block->first + end; index++) {
        for (int i = -1; i < block->type->nodes; i++) {
            if (io_integer(cursor, &number))
                return io_fail_at(block->reader->model, cursor->at, error,
                                  "element tag or node expected (the file may be cut short)");
            if (i < 0)
                put_number(block, index, number);
            else if (put_node(block, cursor->at, index, i, number, error))
                return PLANISH_ERROR_FORMAT;
        }
    }
    return 0;
}

/** Bytes of a tag among elements. */
static int64_t number_size(const gmsh_reader *reader) {
    return is_40(reader) ? 4 : 8;
}

static int64_t load_number(const gmsh_reader *reader, const char *at) {
    return is_40(reader) ? io_load_i32(at, reader->swapped) : io_load_i64(at, reader->swapped);
}

static int read_binary_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                                planish_error *error) {
    const element_block *block = context;
    const gmsh_reader *reader = block->reader;
    const int64_t size = number_size(reader);
    for (int64_t index = block->first + begin; index < block->first + end; index++) {
        put_number(block, index, load_number(reader, cursor->at));
        cursor->at += size;
        for (int i = 0; i < block->type->nodes; i++, cursor->at += size)
            if (put_node(block, cursor->at, index, i, load_number(reader, cursor->at), error))
                return PLANISH_ERROR_FORMAT;
    }
    return 0;
}

/** Where the elements of a block go and what they hold. */
static int open_block(gmsh_reader *reader, const block_head *head, element_block *block) {
    io_model *model = reader->model;
    const gmsh_place *place = find_place(reader, head->dim, head->tag);
    int interface = place && place->interface;
    int status = gmsh_find_type(reader, head->kind, head->at, &block->type, reader->error);
    if (!status)
        status =
            gmsh_check_count(reader, head->n, 2 * (1 + block->type->nodes),
                             number_size(reader) * (1 + block->type->nodes), "elements of a block");
    if (status)
        return status;
    block->reader = reader;
    block->entity = place ? place->entity
                          : io_model_entity(model, head->dim, head->tag, 0, NULL, reader->error);
    if (block->entity < 0)
        return block->entity;
    block->reason = interface ? 0 : io_element_reason(block->type);
    block->cells = interface ? NULL : io_element_cells(model, block->type);
    if (interface)
        model->n_lower += head->n;
    else if (!block->cells)
        io_element_count(model, block->type, head->n);
    if (!block->cells)
        return 0;
    block->first = block->cells->n;
    return io_cells_reserve(block->cells, io_element_dim(block->type), head->n, 1, 1,
                            reader->error);
}

static int read_elements(gmsh_reader *reader, const block_head *head) {
    element_block block = {.first = 0};
    int status = open_block(reader, head, &block);
    if (status)
        return status;
    const int width = 1 + block.type->nodes;
    if (reader->model->is_binary)
        status = io_binary_records(reader->model->threads, &reader->cursor, head->n,
                                   number_size(reader) * width, read_binary_elements, &block,
                                   reader->error);
    else
        status = io_text_records(&reader->text, &reader->cursor, head->n, width, read_text_elements,
                                 &block, reader->error);
    if (!status && block.cells)
        block.cells->n += head->n;
    return status;
}

int gmsh4_elements(gmsh_reader *reader) {
    section_head section;
    block_head head;
    int64_t done = 0;
    int status = take_section_head(reader, &section);
    if (!status && reader->have_elements)
        status = io_fail_at(reader->model, reader->cursor.at, reader->error,
                            "there is a second $Elements");
    if (!status)
        status = gmsh_check_count(reader, section.n, ELEMENT_TEXT,
                                  is_40(reader) ? ELEMENT_SIZE_40 : ELEMENT_SIZE, "elements");
    reader->have_elements = 1;
    for (int64_t i = 0; !status && i < section.n_blocks; i++) {
        status = take_block_head(reader, &section, done, &head);
        if (!status)
            status = read_elements(reader, &head);
        done += !status ? head.n : 0;
    }
    return status ? status : check_total(reader, &section, done);
}

/* ---- periodic pairs ----------------------------------------------------------------------- */

/** Over the transform; *n: the number of pairs, which follows. */
static int skip_transform(gmsh_reader *reader, int64_t *n) {
    int status = gmsh_take_size(reader, n, "size of a periodic transform");
    if (!status)
        status = gmsh_skip_reals(reader, *n, "periodic transform");
    return status ? status : gmsh_take_size(reader, n, "number of periodic nodes");
}

/** The same in MSH 4.0: a word or a count below 0, and 16 numbers, where there is a transform. */
static int skip_transform_40(gmsh_reader *reader, int64_t *n) {
    enum { TRANSFORM = 16 };
    gmsh_skip_affine(reader);
    int status = gmsh_take_size(reader, n, "number of periodic nodes");
    if (status || *n >= 0 || !reader->model->is_binary)
        return status;
    status = gmsh_skip_reals(reader, TRANSFORM, "periodic transform");
    return status ? status : gmsh_take_size(reader, n, "number of periodic nodes");
}

/** One pair of entities: dimension and tags, transform, pairs of nodes. */
static int read_link(gmsh_reader *reader) {
    const int number_bytes = !reader->model->is_binary ? 0 : is_40(reader) ? 4 : 8;
    int32_t ignored;
    int64_t n;
    int status = 0;
    for (int i = 0; !status && i < 3; i++)
        status = gmsh_take_int(reader, &ignored, "dimension and tags of a periodic entity");
    if (!status)
        status = is_40(reader) ? skip_transform_40(reader, &n) : skip_transform(reader, &n);
    if (!status)
        status = gmsh_check_count(reader, n, 4, 2 * number_size(reader), "periodic nodes");
    return status ? status : gmsh_hold_pairs(reader, n, number_bytes);
}

int gmsh4_periodic(gmsh_reader *reader) {
    int64_t links;
    int status = reader->model->is_binary ? gmsh_end_line(reader) : 0;
    if (!status)
        status = take_short(reader, &links, "number of periodic entities");
    for (int64_t i = 0; !status && i < links; i++)
        status = read_link(reader);
    return status;
}
