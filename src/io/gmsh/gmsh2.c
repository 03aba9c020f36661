/* gmsh2: nodes and elements of MSH 2 (2.0 to 2.2), ASCII and binary, and of MSH 1.
 *
 * An element carries tags: its physical group, its elementary entity, and parts of a partition,
 * which do not make regions. In MSH 1 it has these two and the number of its nodes. The elements of
 * a text file are of different lengths, so threads take chunks of lines; each chunk is read twice,
 * to count and to store.
 */
#include "io/gmsh/gmsh_sections.h"

#include <string.h>

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "io/core/bytes.h"

enum {
    LINES_AT_ONCE = 1 << 18, /* bytes of lines that a thread takes at once */
    WORTH_THREADS = 1 << 20, /* bytes of elements from which on threads pay */
    ELEMENT_TEXT = 8         /* bytes of the shortest element: "1 15 0 1" */
};

int gmsh2_nodes(gmsh_reader *reader) {
    int64_t n;
    int status = gmsh_take(reader, 0, &n, "number of nodes");
    if (!status)
        status = gmsh_end_line(reader);
    if (!status)
        status = gmsh_make_nodes(reader, n);
    if (!status)
        status = gmsh_read_nodes(reader, 0, n, 0);
    return status ? status : gmsh_end_nodes(reader);
}

/* ---- one element -------------------------------------------------------------------------- */

/** Owner of an element: its dimension, physical group and elementary entity. */
typedef struct element_owner {
    int dim;
    int32_t physical, elementary;
} element_owner;

/** Head of an element: all but its nodes. */
typedef struct element_head {
    const char *at; /* where it stands, for messages */
    int64_t number;
    const io_element_type *type;
    element_owner owner;
} element_head;

/** Return whether an element is a point that is in a group. */
static int is_grouped_point(const element_head *head) {
    return head->type->shape == IO_POINT && head->owner.physical != 0;
}

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

/** Read an element up to its nodes: number, type, and the number of its tags and these, or in MSH 1
 *  two tags and the number of its nodes. */
static int read_head(const gmsh_reader *reader, io_cursor *cursor, element_head *head,
                     planish_error *error) {
    const int is_old = reader->version == 10;
    int64_t type, n_tags = 2, tag[2] = {0, 0}, other;
    io_skip_space(cursor);
    head->at = cursor->at;
    if (io_integer(cursor, &head->number) || io_integer(cursor, &type))
        return fail_element(reader, cursor->at, error);
    const int status = gmsh_find_type(reader, type, head->at, &head->type, error);
    if (status)
        return status;
    if (!is_old && (io_integer(cursor, &n_tags) || n_tags < 0))
        return fail_element(reader, cursor->at, error);
    for (int64_t i = 0; i < n_tags; i++) {
        int64_t *value = i < 2 ? &tag[i] : &other;
        if (io_integer(cursor, value) || *value < INT32_MIN || *value > INT32_MAX)
            return fail_element(reader, cursor->at, error);
    }
    head->owner = (element_owner){io_element_dim(head->type), (int32_t)tag[0], (int32_t)tag[1]};
    if (is_old && (io_integer(cursor, &other) || other != head->type->nodes))
        return fail_element(reader, cursor->at, error);
    return PLANISH_OK;
}

/* ---- elements of text files --------------------------------------------------------------- */

/** A run of lines, and what was counted in it. */
typedef struct element_chunk {
    io_cursor lines;
    int64_t limit;          /* elements at most */
    int64_t n;              /* elements; by dimension: */
    int64_t n_cells[4];     /* those that are kept, */
    int64_t n_held[4];      /* those that are not; */
    unsigned has_mids;      /* bit DIM: of those that are kept some are of second order */
    int64_t n_others[4];    /* those of these that are others, */
    int64_t n_nodes[4];     /* and the number of their nodes; */
    int64_t n_points;       /* points that are in a group, */
    gmsh_point *point;      /* and where they go */
    int64_t first[4];       /* index of the first cell in the model, */
    int64_t first_other[4]; /* of the first one of the others, */
    int64_t first_node[4];  /* and of its first node there */
    element_owner *owner;   /* [n_owners] one for each run of elements of the same owner */
    int32_t *entity;        /* [n_owners] index into io_model.entity */
    int64_t n_owners, owner_capacity;
    int status;
} element_chunk;

typedef int chunk_fn(const gmsh_reader *reader, element_chunk *chunk, planish_error *error);

typedef struct element_job {
    gmsh_reader *reader;
    element_chunk *chunk; /* [n] */
    int64_t n;
    planish_error *error; /* NULL while several chunks are read */
    chunk_fn *read;
} element_job;

/** Skip n tokens, which the second reading looks at. Return 0 if there are not so many. */
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

/** Count the elements of a chunk, and note the runs of elements of one owner. */
static int count_chunk(const gmsh_reader *reader, element_chunk *chunk, planish_error *error) {
    io_cursor cursor = chunk->lines;
    element_head head;
    for (; chunk->n < chunk->limit; chunk->n++) {
        io_skip_space(&cursor);
        if (cursor.at == cursor.end)
            break;
        const int status = read_head(reader, &cursor, &head, error);
        if (status)
            return status;
        if ((chunk->n_owners == 0 || !same_owner(chunk->owner[chunk->n_owners - 1], head.owner)) &&
            !pl_append(&chunk->owner, &chunk->n_owners, &chunk->owner_capacity, &head.owner,
                       sizeof head.owner))
            return pl_fail_memory(error, "the elements' tags");
        if (!skip_tokens(&cursor, head.type->nodes))
            return fail_element(reader, head.at, error);
        const int is_kept = io_element_use(head.type) == IO_KEEP;
        const int dim = io_element_dim(head.type);
        (is_kept ? chunk->n_cells : chunk->n_held)[dim]++;
        chunk->has_mids |= (unsigned)(io_element_mids(head.type) > 0) << dim;
        const int n_nodes = io_cell_type_nodes(io_element_other(head.type));
        chunk->n_others[dim] += n_nodes > 0;
        chunk->n_points += is_grouped_point(&head);
        chunk->n_nodes[dim] += n_nodes;
    }
    chunk->lines.end = cursor.at;
    return PLANISH_OK;
}

/** Store the elements of a chunk. If they are others than those that were counted, a mapped file
 *  has changed since. */
static int store_chunk(const gmsh_reader *reader, element_chunk *chunk, planish_error *error) {
    io_model *model = reader->model;
    io_cursor cursor = chunk->lines;
    int64_t run = 0, n_points = 0, next[4], other[4], node[4];
    element_head head;
    memcpy(next, chunk->first, sizeof next);
    memcpy(other, chunk->first_other, sizeof other);
    memcpy(node, chunk->first_node, sizeof node);
    for (int64_t i = 0; i < chunk->n; i++) {
        int status = read_head(reader, &cursor, &head, error);
        if (status)
            return status;
        run += !same_owner(chunk->owner[run], head.owner);
        if (run == chunk->n_owners || !same_owner(chunk->owner[run], head.owner))
            return io_bytes_fail_changed(&model->input, error);
        const int dim = io_element_dim(head.type);
        const int has_point = is_grouped_point(&head);
        const gmsh_block block = {.reader = reader,
                                  .type = head.type,
                                  .cells = io_element_cells(model, head.type),
                                  .mids = io_element_mids(head.type),
                                  .other = io_element_other(head.type),
                                  .first = other[dim],
                                  .first_node = node[dim],
                                  .point = has_point ? chunk->point + n_points : NULL,
                                  .entity = chunk->entity[run],
                                  .reason = io_element_reason(head.type)};
        const int n_nodes = io_cell_type_nodes(block.other);
        if ((has_point && n_points == chunk->n_points) ||
            (block.cells && next[dim] == chunk->first[dim] + chunk->n_cells[dim]) ||
            (block.mids > 0 && !(chunk->has_mids >> dim & 1)) ||
            (block.other && (other[dim] == chunk->first_other[dim] + chunk->n_others[dim] ||
                             n_nodes > chunk->first_node[dim] + chunk->n_nodes[dim] - node[dim])))
            return io_bytes_fail_changed(&model->input, error);
        status = gmsh_read_element(&block, &cursor, head.at, head.number,
                                   block.cells ? next[dim] : other[dim], error);
        if (status)
            return status;
        n_points += has_point;
        next[dim] += block.cells != NULL;
        other[dim] += n_nodes > 0;
        node[dim] += n_nodes;
    }
    if (n_points != chunk->n_points)
        return io_bytes_fail_changed(&model->input, error);
    for (int dim = 1; dim < 4; dim++)
        if (next[dim] != chunk->first[dim] + chunk->n_cells[dim] ||
            other[dim] != chunk->first_other[dim] + chunk->n_others[dim] ||
            node[dim] != chunk->first_node[dim] + chunk->n_nodes[dim])
            return io_bytes_fail_changed(&model->input, error);
    return PLANISH_OK;
}

static void read_chunks(void *context, int64_t begin, int64_t end, int thread) {
    element_job *job = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        job->chunk[i].status = job->read(job->reader, &job->chunk[i], job->error);
}

static int run_chunks(element_job *job, chunk_fn *read) {
    job->read = read;
    pl_parallel_for(job->reader->text.threads, job->n, 1, read_chunks, job);
    for (int64_t i = 0; i < job->n; i++)
        if (job->chunk[i].status)
            return job->chunk[i].status;
    return PLANISH_OK;
}

/** Make chunks of whole lines from the cursor to end, or one chunk of everything, with limit
 *  elements at most. */
static int make_chunks(element_job *job, const char *end, int64_t limit, int in_chunks) {
    const char *at = job->reader->cursor.at;
    const int64_t size = end - at;
    job->n = in_chunks ? (size + LINES_AT_ONCE - 1) / LINES_AT_ONCE : 1;
    job->chunk = pl_alloc_zero(job->n, sizeof *job->chunk);
    if (!job->chunk)
        return pl_fail_memory(job->reader->error, "the elements");
    for (int64_t i = 0; i < job->n; i++) {
        const char *next = end, *from = job->reader->cursor.at + (i + 1) * LINES_AT_ONCE - 1;
        if (i + 1 < job->n) {
            const char *newline = memchr(from, '\n', (size_t)(end - from));
            next = newline ? newline + 1 : end;
        }
        job->chunk[i].lines = (io_cursor){at, next};
        job->chunk[i].limit = limit;
        at = next;
    }
    return PLANISH_OK;
}

/** Lay out the cells of all chunks: entities, which are numbered in the order of the file, alike
 *  for any number of threads; room; and where each chunk's cells go. */
static int lay_out_chunks(element_job *job) {
    io_model *model = job->reader->model;
    planish_error *error = job->reader->error;
    int64_t n[4] = {0}, n_others[4] = {0}, n_nodes[4] = {0};
    unsigned has_mids = 0;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < job->n; i++) {
        element_chunk *chunk = &job->chunk[i];
        chunk->entity = pl_alloc(chunk->n_owners, sizeof *chunk->entity);
        if (!chunk->entity)
            return pl_fail_memory(error, "the elements' tags");
        for (int64_t k = 0; k < chunk->n_owners; k++) {
            chunk->entity[k] = entity_of(model, chunk->owner[k], error);
            if (chunk->entity[k] < 0)
                return chunk->entity[k];
        }
        for (int dim = 1; dim < 4; dim++) {
            chunk->first[dim] = n[dim];
            n[dim] += chunk->n_cells[dim];
            chunk->first_other[dim] = n_others[dim];
            chunk->first_node[dim] = n_nodes[dim];
            n_others[dim] += chunk->n_others[dim];
            n_nodes[dim] += chunk->n_nodes[dim];
        }
        has_mids |= chunk->has_mids;
    }
    for (int dim = 1; dim < 4 && !status; dim++) {
        status = io_cells_reserve(model, dim, n[dim], 1, 1, error);
        if (!status && (has_mids >> dim & 1))
            status = io_cells_reserve_mids(model, dim, error);
        if (!status && n_others[dim] > 0)
            status = io_others_reserve(model, dim, n_others[dim], n_nodes[dim], 1, error);
    }
    return status;
}

/** Make room for the points of all chunks. */
static int lay_out_points(element_job *job) {
    gmsh_reader *reader = job->reader;
    int64_t n = 0;
    reader->n_points = 0; /* there are some if this is read once more */
    for (int64_t i = 0; i < job->n; i++)
        n += job->chunk[i].n_points;
    gmsh_point *point = n > 0 ? gmsh_add_points(reader, n) : NULL;
    if (n > 0 && !point)
        return pl_fail_memory(job->error, "points");
    for (int64_t i = 0; i < job->n && point; i++) {
        job->chunk[i].point = point;
        point += job->chunk[i].n_points;
    }
    return PLANISH_OK;
}

/** Read n elements up to end; in chunks, the caller reads once more should it fail. */
static int read_text_elements(gmsh_reader *reader, int64_t n, const char *end, int in_chunks) {
    io_model *model = reader->model;
    element_job job = {.reader = reader, .error = in_chunks ? NULL : reader->error};
    int64_t found = 0;
    int status = make_chunks(&job, end, in_chunks ? INT64_MAX : n, in_chunks);
    if (!status)
        status = run_chunks(&job, count_chunk);
    for (int64_t i = 0; !status && i < job.n; i++)
        found += job.chunk[i].n;
    if (!status && found != n)
        status = io_fail_at(model, end, job.error,
                            "%lld elements expected, %lld found: the file is cut short",
                            (long long)n, (long long)found);
    if (!status)
        status = lay_out_chunks(&job);
    if (!status)
        status = lay_out_points(&job);
    if (!status)
        status = run_chunks(&job, store_chunk);
    for (int64_t i = 0; job.chunk && i < job.n; i++) {
        const element_chunk *chunk = &job.chunk[i];
        for (int dim = 1; !status && dim < 4; dim++)
            io_model_cells(model, dim)->n += chunk->n_cells[dim];
        if (!status) {
            model->n_lower += chunk->n_held[0] + chunk->n_held[1];
            model->n_other += chunk->n_held[2] + chunk->n_held[3];
            for (int dim = 2; dim < 4; dim++) {
                io_model_others(model, dim)->n += chunk->n_others[dim];
                io_model_others(model, dim)->n_nodes += chunk->n_nodes[dim];
            }
            reader->cursor.at = chunk->lines.end;
        }
        pl_free(chunk->owner);
        pl_free(chunk->entity);
    }
    pl_free(job.chunk);
    return status;
}

/* ---- elements of binary files ------------------------------------------------------------- */

/** Read the head of a block: its type, and the numbers of elements and tags. */
static int take_block_head(gmsh_reader *reader, const io_element_type **type, int64_t *n,
                           int64_t *n_tags) {
    const char *at = reader->cursor.at;
    int64_t number = 0;
    int status = gmsh_take(reader, 4, &number, "element type");
    if (!status)
        status = gmsh_take(reader, 4, n, "number of elements of a block");
    if (!status)
        status = gmsh_take(reader, 4, n_tags, "number of tags");
    if (!status)
        status = gmsh_find_type(reader, number, at, type, reader->error);
    if (status)
        return status;
    const int64_t left = io_left(&reader->cursor);
    return *n >= 0 && *n_tags >= 0 && *n <= left / (4 * (1 + *n_tags + (*type)->nodes))
               ? PLANISH_OK
               : io_fail_at(reader->model, at, reader->error,
                            "a block of %lld elements cannot be in the rest of the file",
                            (long long)*n);
}

/** Read a block of elements of one type and number of tags, behind *done elements of the section's
 *  total. An element is its number, tags and nodes, all of them int32. */
static int read_binary_block(gmsh_reader *reader, int64_t total, int64_t *done) {
    int64_t n = 0, n_tags = 0, number = 0, tag[2] = {0, 0}, ignored;
    element_owner last = {-1, 0, 0};
    gmsh_block block = {.reader = reader, .entity = -1, .bytes = 4};
    int status = take_block_head(reader, &block.type, &n, &n_tags);
    if (!status && n > total - *done)
        return io_fail_at(reader->model, reader->cursor.at, reader->error,
                          "the blocks have more elements than the %lld of the section",
                          (long long)total);
    if (!status)
        status = gmsh_begin_block(reader, &block, n);
    if (status)
        return status;
    for (int64_t i = 0; i < n && !status; i++) {
        const char *at = reader->cursor.at;
        io_number(&reader->cursor, 4, reader->swapped, &number);
        for (int64_t k = 0; k < n_tags; k++)
            io_number(&reader->cursor, 4, reader->swapped, k < 2 ? &tag[k] : &ignored);
        const element_owner owner = {io_element_dim(block.type), (int32_t)tag[0], (int32_t)tag[1]};
        if (!same_owner(owner, last))
            block.entity = entity_of(reader->model, owner, reader->error);
        if (block.entity < 0)
            return block.entity;
        last = owner;
        status =
            gmsh_read_element(&block, &reader->cursor, at, number, block.first + i, reader->error);
    }
    gmsh_end_block(reader, &block, n);
    *done += n;
    return status;
}

/* ---- sections ----------------------------------------------------------------------------- */

int gmsh2_elements(gmsh_reader *reader) {
    int64_t n;
    int status = gmsh_take(reader, 0, &n, "number of elements");
    if (!status && reader->have_elements)
        status = io_fail_at(reader->model, reader->cursor.at, reader->error,
                            "there is a second $Elements");
    if (!status)
        status = gmsh_end_line(reader);
    if (!status)
        status = gmsh_check_count(reader, n, ELEMENT_TEXT, 2 * 4, "elements");
    if (status)
        return status;
    reader->have_elements = 1;
    const char *begin = reader->cursor.at;
    int is_read = 0;
    if (reader->model->is_binary) {
        for (int64_t done = 0; done < n && !status;)
            status = read_binary_block(reader, n, &done);
        is_read = 1;
    } else if (reader->text.threads > 1 && io_left(&reader->cursor) > WORTH_THREADS) {
        const char *end = io_find_line(begin, reader->cursor.end, "$");
        is_read = end - begin > WORTH_THREADS && !read_text_elements(reader, n, end, 1);
    }
    if (!is_read)
        status = read_text_elements(reader, n, reader->cursor.end, 0);
    return status ? status : gmsh2_merge_copies(reader);
}
