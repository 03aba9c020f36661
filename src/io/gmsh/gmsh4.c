/* gmsh4: entities, nodes and elements of MSH 4.1 and 4.0, ASCII and binary.
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
#include "io/gmsh/gmsh_sections.h"

#include <stdlib.h>

#include "base/memory.h"
#include "base/status.h"

enum { N_KINDS = 4 }; /* points, curves, surfaces, volumes */

static int is_40(const gmsh_reader *reader) {
    return reader->version == 40;
}

/** Bytes of a tag or count in binary files that MSH 4.0 has in 32 bits. */
static int short_size(const gmsh_reader *reader) {
    return is_40(reader) ? 4 : 8;
}

/* ---- entities ----------------------------------------------------------------------------- */

/** Add an entity, which in the model has that tag; at the cursor are its box (a point: its
 *  coordinates), physical groups and boundary. */
static int add_entity(gmsh_reader *reader, gmsh_entity entity, int32_t tag) {
    int64_t n, group;
    int status =
        gmsh_skip_reals(reader, entity.dim == 0 && !is_40(reader) ? 3 : 6, "box of an entity");
    if (!status)
        status = gmsh_take(reader, 8, &n, "number of physical groups");
    if (!status)
        status = gmsh_check_count(reader, n, 2, 4, "physical groups");
    if (status)
        return status;
    int32_t *groups = pl_alloc(n, sizeof *groups);
    status = groups ? PLANISH_OK : pl_fail_memory(reader->error, "entities");
    for (int64_t i = 0; !status && i < n; i++) {
        status = gmsh_take(reader, 4, &group, "physical group");
        /* The sign is the orientation of the entity in the group. */
        if (!status)
            groups[i] = (int32_t)(group < 0 && group != INT32_MIN ? -group : group);
    }
    if (!status) {
        entity.index =
            io_model_entity(reader->model, entity.dim, tag, (int)n, groups, reader->error);
        status = entity.index < 0 ? entity.index : PLANISH_OK;
    }
    pl_free(groups);
    if (!status && !pl_append(&reader->entity, &reader->n_entities, &reader->entity_capacity,
                              &entity, sizeof entity))
        status = pl_fail_memory(reader->error, "entities");
    if (status || entity.dim == 0)
        return status;
    status = gmsh_take(reader, 8, &n, "number of bounding entities");
    return status ? status : gmsh_skip_integers(reader, 4, n, "bounding entity");
}

/** Take the parent and the parts of a partitioned entity; *tag becomes that of the parent, unless
 *  the entity is between parts. */
static int take_parent(gmsh_reader *reader, gmsh_entity *entity, int64_t *tag) {
    int64_t dim, parent, n_parts;
    int status = gmsh_take(reader, 4, &dim, "dimension of a parent entity");
    if (!status)
        status = gmsh_take(reader, 4, &parent, "tag of a parent entity");
    if (!status)
        status = gmsh_take(reader, short_size(reader), &n_parts, "number of parts");
    if (status)
        return status;
    entity->interface = dim > entity->dim;
    *tag = entity->interface ? *tag : parent;
    return gmsh_skip_integers(reader, 4, n_parts, "part");
}

/** Read the numbers of points, curves, surfaces and volumes, and then all of these. In a
 *  partitioned mesh each has a parent and parts. */
static int read_entities(gmsh_reader *reader, int is_partitioned) {
    int64_t n[N_KINDS] = {0}, tag = 0;
    int status = PLANISH_OK;
    for (int dim = 0; dim < N_KINDS && !status; dim++)
        status = gmsh_take(reader, 8, &n[dim], "number of entities");
    for (int dim = 0; dim < N_KINDS; dim++) {
        for (int64_t i = 0; i < n[dim] && !status; i++) {
            status = gmsh_take(reader, 4, &tag, "tag of an entity");
            gmsh_entity entity = {.dim = dim, .tag = (int32_t)tag};
            if (!status && is_partitioned)
                status = take_parent(reader, &entity, &tag);
            if (!status)
                status = add_entity(reader, entity, (int32_t)tag);
        }
    }
    if (!status && reader->n_entities > 0)
        qsort(reader->entity, (size_t)reader->n_entities, sizeof *reader->entity,
              gmsh_compare_entities);
    return status;
}

int gmsh4_entities(gmsh_reader *reader) {
    const int status = gmsh_end_line(reader);
    return status ? status : read_entities(reader, 0);
}

/** Read $PartitionedEntities: number of parts, ghost entities (tag and part of each), entities. */
int gmsh4_partitioned_entities(gmsh_reader *reader) {
    int64_t n_ghosts;
    int status = gmsh_end_line(reader);
    if (!status)
        status = gmsh_skip_integers(reader, short_size(reader), 1, "number of parts");
    if (!status)
        status = gmsh_take(reader, short_size(reader), &n_ghosts, "number of ghost entities");
    for (int64_t i = 0; !status && i < n_ghosts; i++)
        status = gmsh_skip_integers(reader, 4, 2, "tag and part of a ghost entity");
    return status ? status : read_entities(reader, 1);
}

/* ---- blocks ------------------------------------------------------------------------------- */

/** The head of a section, and of the block that is read. */
typedef struct section_head {
    int64_t n_blocks, n, done; /* nodes or elements; those of the blocks before */
    const char *at;            /* of the block, */
    int dim;
    int32_t tag;
    int64_t kind; /* parametric, or the element type */
    int64_t size;
} section_head;

static int take_section_head(gmsh_reader *reader, section_head *head) {
    *head = (section_head){.n = 0};
    int status = gmsh_end_line(reader);
    if (!status)
        status = gmsh_take(reader, 8, &head->n_blocks, "number of blocks");
    if (!status)
        status = gmsh_take(reader, 8, &head->n, "number of nodes or elements");
    return status || is_40(reader) ? status
                                   : gmsh_skip_integers(reader, 8, 2, "smallest and largest tag");
}

static int take_block_head(gmsh_reader *reader, section_head *head) {
    int64_t dim = 0, tag = 0;
    head->done += head->size;
    if (!reader->model->is_binary)
        io_skip_space(&reader->cursor);
    head->at = reader->cursor.at;
    int64_t *number[] = {is_40(reader) ? &tag : &dim, is_40(reader) ? &dim : &tag, &head->kind,
                         &head->size};
    for (int i = 0; i < 4; i++) {
        const int status = gmsh_take(reader, i < 3 ? 4 : 8, number[i],
                                     "dimension, entity, kind and size of a block");
        if (status)
            return status;
    }
    if (dim < 0 || dim > 3)
        return io_fail_at(reader->model, head->at, reader->error, "block of dimension %lld",
                          (long long)dim);
    if (head->size < 0 || head->size > head->n - head->done)
        return io_fail_at(reader->model, head->at, reader->error,
                          "the blocks have more than the %lld nodes or elements of the section",
                          (long long)head->n);
    head->dim = (int)dim;
    head->tag = (int32_t)tag;
    return PLANISH_OK;
}

typedef int block_fn(gmsh_reader *reader, const section_head *head);

/** Read all blocks of a section; together they have as many nodes or elements as it. */
static int read_blocks(gmsh_reader *reader, section_head *head, block_fn *read) {
    for (int64_t i = 0; i < head->n_blocks; i++) {
        int status = take_block_head(reader, head);
        if (!status)
            status = read(reader, head);
        if (status)
            return status;
    }
    const int64_t found = head->done + head->size;
    if (found == head->n)
        return PLANISH_OK;
    return io_fail_at(reader->model, reader->cursor.at, reader->error,
                      "the blocks have %lld of the %lld nodes or elements of the section",
                      (long long)found, (long long)head->n);
}

static int read_node_block(gmsh_reader *reader, const section_head *head) {
    const int extra = head->kind != 0 ? head->dim : 0;
    const int status = gmsh_read_nodes(reader, head->done, head->size, extra);
    for (int64_t k = 0; !status && extra > 0 && k < head->size; k++)
        io_hold_node(reader->model, head->done + k, IO_HAS_PARAMETERS);
    return status;
}

int gmsh4_nodes(gmsh_reader *reader) {
    section_head head;
    int status = take_section_head(reader, &head);
    if (!status)
        status = gmsh_make_nodes(reader, head.n);
    if (!status)
        status = read_blocks(reader, &head, read_node_block);
    return status ? status : gmsh_end_nodes(reader);
}

/* ---- elements ----------------------------------------------------------------------------- */

static int read_elements(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                         planish_error *error) {
    const gmsh_block *block = context;
    int64_t number;
    for (int64_t i = begin; i < end; i++) {
        const char *at = cursor->at;
        if (io_number(cursor, block->bytes, block->reader->swapped, &number))
            return io_fail_at(block->reader->model, at, error,
                              "number of an element expected (the file may be cut short)");
        const int status = gmsh_read_element(block, cursor, at, number, block->first + i, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int read_element_block(gmsh_reader *reader, const section_head *head) {
    io_model *model = reader->model;
    const int bytes = short_size(reader);
    gmsh_block block = {.reader = reader, .bytes = model->is_binary ? bytes : 0};
    int status = gmsh_find_type(reader, head->kind, head->at, &block.type, reader->error);
    if (status)
        return status;
    const int width = 1 + block.type->nodes;
    status = gmsh_check_count(reader, head->size, 2 * width, bytes * width, "elements of a block");
    if (status)
        return status;
    const gmsh_entity key = {.dim = head->dim, .tag = head->tag}, *entity = NULL;
    if (reader->n_entities > 0)
        entity = bsearch(&key, reader->entity, (size_t)reader->n_entities, sizeof key,
                         gmsh_compare_entities);
    block.entity = entity ? entity->index
                          : io_model_entity(model, head->dim, head->tag, 0, NULL, reader->error);
    if (block.entity < 0)
        return block.entity;
    if (entity && entity->interface)
        model->n_lower += head->size;
    else
        status = gmsh_begin_block(reader, &block, head->size);
    if (!status)
        status = io_records(&reader->text, &reader->cursor, head->size, width, bytes * width,
                            read_elements, &block, reader->error);
    if (!status)
        gmsh_end_block(reader, &block, head->size);
    return status;
}

int gmsh4_elements(gmsh_reader *reader) {
    enum { TEXT_SIZE = 3 }; /* the shortest element: its tag and a node */
    section_head head;
    int status = take_section_head(reader, &head);
    if (!status && reader->have_elements)
        status = io_fail_at(reader->model, reader->cursor.at, reader->error,
                            "there is a second $Elements");
    if (!status)
        status = gmsh_check_count(reader, head.n, TEXT_SIZE, 2 * short_size(reader), "elements");
    reader->have_elements = 1;
    return status ? status : read_blocks(reader, &head, read_element_block);
}
