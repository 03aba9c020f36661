/* gmsh2: nodes, elements and periodic pairs of MSH 2 (2.0 to 2.2), ASCII and binary, and of MSH 1.
 *
 * An element carries tags: its physical group, its elementary entity, and parts of a partition,
 * which do not make regions. In MSH 1 it has these two and the number of its nodes. The elements of
 * a text file are of different lengths, so threads take chunks of lines; each chunk is read twice,
 * to count and to store.
 */
#include "io/gmsh/gmsh_reader.h"

#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "io/core/binary.h"
#include "io/core/bytes.h"

enum {
    LINES_AT_ONCE = 1 << 18, /* bytes of lines that a thread takes at once */
    WORTH_THREADS = 1 << 20, /* bytes of elements from which on threads pay */
    NODE_TEXT = 7,           /* bytes of the shortest node: a number and three coordinates */
    NODE_SIZE = 4 + 3 * 8,   /* bytes of a node in a binary file */
    ELEMENT_TEXT = 8         /* bytes of the shortest element: "1 15 0 1" */
};

/* ---- nodes -------------------------------------------------------------------------------- */

static int read_text_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                           planish_error *error) {
    const gmsh_reader *reader = context;
    io_model *model = reader->model;
    for (int64_t node = begin; node < end; node++) {
        if (io_integer(cursor, &model->node_number[node]))
            return io_fail_at(reader->model, cursor->at, error,
                              "number of node %lld of %lld expected (the file may be cut short)",
                              (long long)node + 1, (long long)model->n_nodes);
        int status = io_read_point(model, cursor, node, error);
        if (status)
            return status;
    }
    return 0;
}

static int read_binary_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                             planish_error *error) {
    const gmsh_reader *reader = context;
    for (int64_t node = begin; node < end; node++, cursor->at += NODE_SIZE) {
        reader->model->node_number[node] = io_load_i32(cursor->at, reader->swapped);
        int status = gmsh_load_point(reader, cursor->at + 4, node, error);
        if (status)
            return status;
    }
    return 0;
}

int gmsh2_nodes(gmsh_reader *reader) {
    io_model *model = reader->model;
    int64_t n;
    int status = gmsh_take_text(reader, &n, "number of nodes");
    if (!status && reader->model->is_binary)
        status = gmsh_end_line(reader);
    if (!status)
        status = gmsh_make_nodes(reader, n, NODE_TEXT, NODE_SIZE);
    if (status)
        return status;
    if (!reader->model->is_binary) {
        status = io_text_records(&reader->text, &reader->cursor, n, 4, read_text_nodes, reader,
                                 reader->error);
    } else {
        io_span span = {.n_nodes = n,
                        .encoding = IO_FLOAT64,
                        .swapped = reader->swapped,
                        .offset = reader->cursor.at - model->input.data + 4,
                        .stride = NODE_SIZE};
        status = io_model_span(model, span, reader->error);
        if (!status)
            status = io_binary_records(model->threads, &reader->cursor, n, NODE_SIZE,
                                       read_binary_nodes, reader, reader->error);
    }
    return status ? status : gmsh_index_nodes(reader);
}

/* ---- one element -------------------------------------------------------------------------- */

/** Where an element belongs. */
typedef struct element_owner {
    int dim;
    int32_t physical, elementary;
} element_owner;

typedef struct element_line {
    const char *at; /* where it stands, for messages */
    int64_t number;
    const io_element_type *type;
    element_owner owner;
} element_line;

static int same_owner(element_owner a, element_owner b) {
    return a.dim == b.dim && a.physical == b.physical && a.elementary == b.elementary;
}

static int32_t entity_of(io_model *model, element_owner owner, planish_error *error) {
    return io_model_entity(model, owner.dim, owner.elementary, owner.physical != 0, &owner.physical,
                           error);
}

static int fail_element(const gmsh_reader *reader, const char *at, planish_error *error) {
    return io_fail_at(reader->model, at, error,
                      "element: number, type, tags and nodes expected (the file may be cut short, "
                      "or the number of elements is wrong)");
}

/** The tags of an element: their number and as many, or in MSH 1 two and the number of its nodes.
 */
static int read_tags(const gmsh_reader *reader, io_cursor *cursor, element_line *element,
                     planish_error *error) {
    const int is_old = reader->version == 10;
    int64_t n_tags = 2, tag;
    if (!is_old && (io_integer(cursor, &n_tags) || n_tags < 0))
        return fail_element(reader, cursor->at, error);
    for (int64_t i = 0; i < n_tags; i++) {
        if (io_integer(cursor, &tag) || tag < INT32_MIN || tag > INT32_MAX)
            return fail_element(reader, cursor->at, error);
        if (i == 0)
            element->owner.physical = (int32_t)tag;
        else if (i == 1)
            element->owner.elementary = (int32_t)tag;
    }
    if (is_old && (io_integer(cursor, &tag) || tag != element->type->nodes))
        return fail_element(reader, cursor->at, error);
    return 0;
}

/** All of an element but its nodes. */
static int read_element_text(const gmsh_reader *reader, io_cursor *cursor, element_line *element,
                             planish_error *error) {
    int64_t type;
    io_skip_space(cursor);
    element->at = cursor->at;
    element->owner = (element_owner){0, 0, 0};
    if (io_integer(cursor, &element->number) || io_integer(cursor, &type))
        return fail_element(reader, cursor->at, error);
    int status = gmsh_find_type(reader, type, element->at, &element->type, error);
    if (status)
        return status;
    element->owner.dim = io_element_dim(element->type);
    return read_tags(reader, cursor, element, error);
}

static int fail_node(const gmsh_reader *reader, const char *at, int64_t number, int64_t node,
                     planish_error *error) {
    return io_fail_at(reader->model, at, error, "element %lld: there is no node %lld",
                      (long long)number, (long long)node);
}

/* ---- elements of text files --------------------------------------------------------------- */

/** A run of lines, and what was counted in it. */
typedef struct element_chunk {
    io_cursor lines;
    int64_t limit;                        /* elements at most */
    int64_t n;                            /* elements; then those of each kind: */
    int64_t n_cells[4], n_lower, n_other; /* n_cells by dimension: those that are kept */
    int64_t first[4];                     /* by dimension: index of the first in the model */
    element_owner *owner; /* [n_owners] one for each run of elements of the same owner */
    int32_t *entity;      /* [n_owners] index into io_model.entity */
    int64_t n_owners, owner_capacity;
    int status;
} element_chunk;

typedef struct element_job {
    gmsh_reader *reader;
    element_chunk *chunk; /* [n] */
    int64_t n;
    const char *begin, *end;
    planish_error *error; /* NULL while several chunks are read */
} element_job;

static int note_owner(element_chunk *chunk, element_owner owner, planish_error *error) {
    if (chunk->n_owners > 0 && same_owner(chunk->owner[chunk->n_owners - 1], owner))
        return 0;
    void *grown = pl_grow(chunk->owner, chunk->n_owners, chunk->n_owners + 1,
                          &chunk->owner_capacity, sizeof owner);
    if (!grown)
        return pl_fail_memory(error, "the elements' tags");
    chunk->owner = grown;
    chunk->owner[chunk->n_owners++] = owner;
    return 0;
}

static void count_element(io_model *model, element_chunk *chunk, const io_element_type *type) {
    chunk->n++;
    if (io_element_cells(model, type))
        chunk->n_cells[io_element_dim(type)]++;
    else
        *(io_element_dim(type) < 2 ? &chunk->n_lower : &chunk->n_other) += 1;
}

/** Over n tokens that the second reading looks at; 0 if there are not so many. */
static int skip_tokens(io_cursor *cursor, int n) {
    const char *at = cursor->at;
    for (int i = 0; i < n; i++) {
        while (at < cursor->end && (unsigned char)*at <= ' ')
            at++;
        if (at == cursor->end)
            return 0;
        while (at < cursor->end && (unsigned char)*at > ' ')
            at++;
    }
    cursor->at = at;
    return 1;
}

static int count_chunk(const gmsh_reader *reader, element_chunk *chunk, planish_error *error) {
    io_cursor cursor = chunk->lines;
    element_line element;
    while (chunk->n < chunk->limit) {
        io_skip_space(&cursor);
        if (cursor.at == cursor.end)
            break;
        int status = read_element_text(reader, &cursor, &element, error);
        if (!status)
            status = note_owner(chunk, element.owner, error);
        if (status)
            return status;
        if (!skip_tokens(&cursor, element.type->nodes))
            return fail_element(reader, element.at, error);
        count_element(reader->model, chunk, element.type);
    }
    chunk->lines.end = cursor.at;
    return 0;
}

static int store_cell(const gmsh_reader *reader, io_cursor *cursor, const element_line *element,
                      io_cells *cells, int64_t index, int32_t entity, planish_error *error) {
    int corners = element->type->nodes;
    for (int i = 0; i < corners; i++) {
        int64_t number;
        if (io_integer(cursor, &number))
            return fail_element(reader, element->at, error);
        int64_t node = io_node_index(reader->model, reader->numbers, number);
        if (node < 0)
            return fail_node(reader, element->at, element->number, number, error);
        cells->nodes[index * corners + i] = (int32_t)node;
    }
    cells->entity[index] = entity;
    cells->number[index] = element->number;
    return 0;
}

static int hold_rest(const gmsh_reader *reader, io_cursor *cursor, const element_line *element,
                     planish_error *error) {
    uint8_t reason = io_element_reason(element->type);
    for (int i = 0; i < element->type->nodes; i++) {
        int64_t number;
        if (io_integer(cursor, &number))
            return fail_element(reader, element->at, error);
        int64_t node = io_node_index(reader->model, reader->numbers, number);
        if (node < 0)
            return fail_node(reader, element->at, element->number, number, error);
        io_hold_node(reader->model, node, reason);
    }
    return 0;
}

/** Whether the element is one that was counted in the chunk: if not, a mapped file has changed
 * since. run: the run of elements of one owner that it is in. */
static int was_counted(const element_chunk *chunk, const element_line *element, int64_t run,
                       const int64_t next[4], int is_kept) {
    const int dim = io_element_dim(element->type);
    return run < chunk->n_owners && same_owner(chunk->owner[run], element->owner) &&
           (!is_kept || next[dim] < chunk->first[dim] + chunk->n_cells[dim]);
}

static int store_chunk(const gmsh_reader *reader, const element_chunk *chunk,
                       planish_error *error) {
    io_model *model = reader->model;
    io_cursor cursor = chunk->lines;
    int64_t run = 0, next[4];
    element_line element;
    memcpy(next, chunk->first, sizeof next);
    for (int64_t i = 0; i < chunk->n; i++) {
        int status = read_element_text(reader, &cursor, &element, error);
        if (status)
            return status;
        if (!same_owner(chunk->owner[run], element.owner))
            run++;
        io_cells *cells = io_element_cells(model, element.type);
        if (!was_counted(chunk, &element, run, next, cells != NULL))
            return io_bytes_fail_changed(&model->input, error);
        if (!cells)
            status = hold_rest(reader, &cursor, &element, error);
        else
            status = store_cell(reader, &cursor, &element, cells,
                                next[io_element_dim(element.type)]++, chunk->entity[run], error);
        if (status)
            return status;
    }
    for (int dim = 1; dim < 4; dim++)
        if (next[dim] != chunk->first[dim] + chunk->n_cells[dim])
            return io_bytes_fail_changed(&model->input, error);
    return 0;
}

static void count_chunks(void *context, int64_t begin, int64_t end, int thread) {
    element_job *job = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        job->chunk[i].status = count_chunk(job->reader, &job->chunk[i], job->error);
}

static void store_chunks(void *context, int64_t begin, int64_t end, int thread) {
    element_job *job = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        job->chunk[i].status = store_chunk(job->reader, &job->chunk[i], job->error);
}

static int run_chunks(element_job *job, pl_chunk_fn *body) {
    pl_parallel_for(job->reader->text.threads, job->n, 1, body, job);
    for (int64_t i = 0; i < job->n; i++)
        if (job->chunk[i].status)
            return job->chunk[i].status;
    return 0;
}

static const char *line_at_or_after(const element_job *job, int64_t offset) {
    if (offset == 0)
        return job->begin;
    if (offset >= job->end - job->begin)
        return job->end;
    const char *at = job->begin + offset - 1;
    const char *newline = memchr(at, '\n', (size_t)(job->end - at));
    return !newline ? job->end : newline + 1;
}

/** Chunks of whole lines, or one chunk of everything. */
static int make_chunks(element_job *job, int64_t limit, int in_chunks) {
    int64_t size = job->end - job->begin;
    job->n = in_chunks ? (size + LINES_AT_ONCE - 1) / LINES_AT_ONCE : 1;
    job->chunk = pl_alloc_zero(job->n, sizeof *job->chunk);
    if (!job->chunk)
        return pl_fail_memory(job->reader->error, "the elements");
    for (int64_t i = 0; i < job->n; i++) {
        job->chunk[i].lines.at = line_at_or_after(job, i * LINES_AT_ONCE);
        job->chunk[i].lines.end =
            i + 1 < job->n ? line_at_or_after(job, (i + 1) * LINES_AT_ONCE) : job->end;
        job->chunk[i].limit = limit;
    }
    return 0;
}

static void release_chunks(element_job *job) {
    for (int64_t i = 0; job->chunk && i < job->n; i++) {
        pl_free(job->chunk[i].owner);
        pl_free(job->chunk[i].entity);
    }
    pl_free(job->chunk);
}

/** In the order of the file, so that entities are numbered alike for any number of threads. */
static int find_entities(io_model *model, element_chunk *chunk, planish_error *error) {
    chunk->entity = pl_alloc(chunk->n_owners, sizeof *chunk->entity);
    if (!chunk->entity)
        return pl_fail_memory(error, "the elements' tags");
    for (int64_t i = 0; i < chunk->n_owners; i++) {
        chunk->entity[i] = entity_of(model, chunk->owner[i], error);
        if (chunk->entity[i] < 0)
            return chunk->entity[i];
    }
    return 0;
}

/** Between counting and storing: entities, room, and where each chunk's cells go. */
static int lay_out_chunks(element_job *job) {
    io_model *model = job->reader->model;
    io_cells *cells[4] = {NULL, &model->line, &model->triangle, &model->tetrahedron};
    planish_error *error = job->reader->error;
    int64_t n[4] = {0, 0, 0, 0};
    for (int64_t i = 0; i < job->n; i++) {
        element_chunk *chunk = &job->chunk[i];
        int status = find_entities(model, chunk, error);
        if (status)
            return status;
        for (int dim = 1; dim < 4; dim++) {
            chunk->first[dim] = n[dim];
            n[dim] += chunk->n_cells[dim];
        }
    }
    int status = 0;
    for (int dim = 1; dim < 4 && !status; dim++)
        status = io_cells_reserve(cells[dim], dim, n[dim], 1, 1, error);
    return status;
}

static void finish_chunks(element_job *job) {
    io_model *model = job->reader->model;
    for (int64_t i = 0; i < job->n; i++) {
        const element_chunk *chunk = &job->chunk[i];
        model->line.n += chunk->n_cells[1];
        model->triangle.n += chunk->n_cells[2];
        model->tetrahedron.n += chunk->n_cells[3];
        model->n_lower += chunk->n_lower;
        model->n_other += chunk->n_other;
    }
    job->reader->cursor.at = job->chunk[job->n - 1].lines.end;
}

/** Read n elements up to end; in chunks, the caller reads once more should it fail. */
static int read_text_elements(gmsh_reader *reader, int64_t n, const char *end, int in_chunks) {
    element_job job = {.reader = reader, .begin = reader->cursor.at, .end = end};
    job.error = in_chunks ? NULL : reader->error;
    int64_t found = 0;
    int status = make_chunks(&job, in_chunks ? INT64_MAX : n, in_chunks);
    if (!status)
        status = run_chunks(&job, count_chunks);
    for (int64_t i = 0; !status && i < job.n; i++)
        found += job.chunk[i].n;
    if (!status && found != n)
        status = io_fail_at(reader->model, end, job.error,
                            "%lld elements expected, %lld found: the file is cut short",
                            (long long)n, (long long)found);
    if (!status)
        status = lay_out_chunks(&job);
    if (!status)
        status = run_chunks(&job, store_chunks);
    if (!status)
        finish_chunks(&job);
    release_chunks(&job);
    return status;
}

/* ---- elements of binary files ------------------------------------------------------------- */

/** One element of a block: number, tags, nodes, all of them int32. */
static int store_binary(gmsh_reader *reader, const char *at, const element_line *element,
                        int32_t entity, const char *nodes) {
    io_model *model = reader->model;
    io_cells *cells = io_element_cells(model, element->type);
    int corners = element->type->nodes;
    for (int i = 0; i < corners; i++) {
        int64_t number = io_load_i32(nodes + 4 * i, reader->swapped);
        int64_t node = io_node_index(reader->model, reader->numbers, number);
        if (node < 0)
            return fail_node(reader, at, element->number, number, reader->error);
        if (!cells)
            io_hold_node(model, node, io_element_reason(element->type));
        else
            cells->nodes[cells->n * corners + i] = (int32_t)node;
    }
    if (!cells) {
        io_element_count(model, element->type, 1);
        return 0;
    }
    cells->entity[cells->n] = entity;
    cells->number[cells->n++] = element->number;
    return 0;
}

typedef struct binary_block {
    const io_element_type *type;
    int32_t n, n_tags;
    int64_t size; /* bytes of an element */
} binary_block;

static int read_block_header(gmsh_reader *reader, binary_block *block) {
    int32_t type;
    const char *at = reader->cursor.at;
    if (gmsh_take_int(reader, &type, "element type") ||
        gmsh_take_int(reader, &block->n, "number of elements of a block") ||
        gmsh_take_int(reader, &block->n_tags, "number of tags"))
        return PLANISH_ERROR_FORMAT;
    int status = gmsh_find_type(reader, type, at, &block->type, reader->error);
    if (status)
        return status;
    block->size = 4 * (1 + (int64_t)block->n_tags + block->type->nodes);
    if (block->n < 0 || block->n_tags < 0 || block->n > io_left(&reader->cursor) / block->size)
        return io_fail_at(reader->model, at, reader->error,
                          "a block of %d elements cannot be in the rest of the file", block->n);
    return 0;
}

static int read_block(gmsh_reader *reader, const binary_block *block) {
    io_cells *cells = io_element_cells(reader->model, block->type);
    element_line element = {.type = block->type};
    element_owner last = {-1, 0, 0};
    int32_t entity = -1;
    if (cells) {
        int status =
            io_cells_reserve(cells, io_element_dim(block->type), block->n, 1, 1, reader->error);
        if (status)
            return status;
    }
    for (int32_t i = 0; i < block->n; i++, reader->cursor.at += block->size) {
        const char *at = reader->cursor.at;
        element.number = io_load_i32(at, reader->swapped);
        element_owner owner = {io_element_dim(block->type), 0, 0};
        if (block->n_tags > 0)
            owner.physical = io_load_i32(at + 4, reader->swapped);
        if (block->n_tags > 1)
            owner.elementary = io_load_i32(at + 8, reader->swapped);
        if (!same_owner(owner, last)) {
            entity = entity_of(reader->model, owner, reader->error);
            if (entity < 0)
                return entity;
            last = owner;
        }
        int status =
            store_binary(reader, at, &element, entity, at + 4 + 4 * (int64_t)block->n_tags);
        if (status)
            return status;
    }
    return 0;
}

static int read_binary_elements(gmsh_reader *reader, int64_t n) {
    for (int64_t found = 0; found < n;) {
        binary_block block;
        int status = read_block_header(reader, &block);
        if (!status && block.n > n - found)
            status = io_fail_at(reader->model, reader->cursor.at, reader->error,
                                "the blocks have more elements than the %lld of the section",
                                (long long)n);
        if (!status)
            status = read_block(reader, &block);
        if (status)
            return status;
        found += block.n;
    }
    return 0;
}

/* ---- sections ----------------------------------------------------------------------------- */

static int read_elements(gmsh_reader *reader, int64_t n) {
    if (reader->model->is_binary)
        return read_binary_elements(reader, n);
    const char *begin = reader->cursor.at;
    if (reader->text.threads > 1 && io_left(&reader->cursor) > WORTH_THREADS) {
        const char *end = io_find_line(begin, reader->cursor.end, "$");
        if (end - begin > WORTH_THREADS && read_text_elements(reader, n, end, 1) == 0)
            return 0;
        reader->cursor.at = begin;
    }
    return read_text_elements(reader, n, reader->cursor.end, 0);
}

int gmsh2_elements(gmsh_reader *reader) {
    int64_t n;
    int status = gmsh_take_text(reader, &n, "number of elements");
    if (!status && reader->have_elements)
        status = io_fail_at(reader->model, reader->cursor.at, reader->error,
                            "there is a second $Elements");
    if (!status && reader->model->is_binary)
        status = gmsh_end_line(reader);
    if (!status)
        status = gmsh_check_count(reader, n, ELEMENT_TEXT, 2 * 4, "elements");
    reader->have_elements = 1;
    if (!status)
        status = read_elements(reader, n);
    return status ? status : gmsh2_merge_copies(reader);
}

int gmsh2_periodic(gmsh_reader *reader) {
    int64_t links, value, n;
    int status = gmsh_take_text(reader, &links, "number of periodic entities");
    for (int64_t i = 0; !status && i < links; i++) {
        for (int k = 0; !status && k < 3; k++)
            status = gmsh_take_text(reader, &value, "dimension and tags of a periodic entity");
        if (status)
            return status;
        gmsh_skip_affine(reader);
        status = gmsh_take_text(reader, &n, "number of periodic nodes");
        if (!status && (n < 0 || n > io_left(&reader->cursor) / 4 + 1))
            status =
                io_fail_at(reader->model, reader->cursor.at, reader->error,
                           "%lld periodic nodes cannot be in the rest of the file", (long long)n);
        if (!status)
            status = gmsh_hold_pairs(reader, n, 0);
    }
    return status;
}
