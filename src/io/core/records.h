/* records: many records of numbers read by several threads, in text and in binary.
 *
 *   io_text, io_text_init, ...       a text and the index of its tokens
 *   io_records                       read records of a text or binary file
 *   io_text_records, io_binary_...   read records of the one or the other
 *   io_section, io_sections_add ...  places of records that a first walk over a file notes
 *   io_read_node, io_load_node       coordinates of a node from text or binary
 *   io_node_records, io_read_nodes   and of many
 *   io_nodes_begin, _next, ...       nodes with numbers, counted in one walk and read in another
 *   io_number, io_take_whole         take a whole number, in text and in binary
 *   io_left, io_hold_node            small helpers of readers
 *
 * A reader gives a function that reads records begin .. end-1 from a cursor that stands on the
 * first of them. Where records are many, io_text_records finds the places between (by an index of
 * the file's tokens) and threads read chunks of them; otherwise, and when any chunk fails, the same
 * function reads all of them in order, so that errors are those of the first bad record. Before a
 * comment nothing is read by threads: its words are tokens to the index, but not to the reader, and
 * notes of a pass on misplaced records (held nodes) could not be taken back. Nothing is assumed
 * about lines: records are as many tokens as the caller says.
 */
#ifndef PL_IO_CORE_RECORDS_H
#define PL_IO_CORE_RECORDS_H

#include "io/core/binary.h"
#include "io/core/text.h"

/** Read records begin .. end-1 of context; the cursor ends behind the last. error is NULL when the
 *  records will be read once more should they fail. Called on several threads at once. */
typedef int io_records_fn(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                          planish_error *error);

/** A text file and, once a large section was met, the index of its tokens. */
typedef struct io_text {
    const io_model *model;
    const char *begin, *end;
    int threads;
    char comment;    /* what comments begin with: '#' by default */
    int64_t *before; /* [pieces + 1] tokens that start before each piece of bytes, or NULL */
} io_text;

/** Begin a text: the whole input. */
void io_text_init(io_text *text, const io_model *model);
/** Release the index. */
void io_text_release(io_text *text);

/** Read n records of tokens tokens each from *cursor; the cursor ends at the next token. */
int io_text_records(io_text *text, io_cursor *cursor, int64_t n, int64_t tokens,
                    io_records_fn *read, void *context, planish_error *error);

/** Read n records of size bytes each from *cursor; the caller has checked that they are there. */
int io_binary_records(int threads, io_cursor *cursor, int64_t n, int64_t size, io_records_fn *read,
                      void *context, planish_error *error);

/** Read n records from *cursor: of tokens tokens each, or of size bytes each where the model is
 *  binary (the caller has checked that they are there). */
int io_records(io_text *text, io_cursor *cursor, int64_t n, int64_t tokens, int64_t size,
               io_records_fn *read, void *context, planish_error *error);

/** Place of the records of a section, noted by a first walk over the file. */
typedef struct io_section {
    int keyword; /* its row in the reader's table of keywords */
    int64_t count;
    const char *data, *end; /* end: binary: behind the records; text: at the next keyword */
    int64_t tokens;         /* words of each record, where the walk knows; else 0 */
} io_section;

/** Sections of a file. */
typedef struct io_sections {
    io_section *section; /* [n] owned, in the file's order */
    int64_t n, capacity;
} io_sections;

/** Note a section behind the others. Error: _MEMORY. */
int io_sections_add(io_sections *sections, io_section section, planish_error *error);
/** Release the list. */
void io_sections_release(io_sections *sections);

/** Read the records of a section as io_records does; tokens 0: in order, as records of text differ
 *  or make a list. In text nothing but comments may be left before its end. name: for the
 *  message. */
int io_section_records(io_text *text, const io_section *section, const char *name, int64_t tokens,
                       int64_t size, io_records_fn *read, void *context, planish_error *error);

/** Read the three coordinates of node from binary reals at at, size bytes (4, 8) each, one behind
 *  the other; an error if one is not finite. error may be NULL. */
int io_load_node(const io_model *model, const char *at, int size, int swapped, int64_t node,
                 planish_error *error);

/** Read the coordinates of node, model->columns, from text, note their place, round them to the
 *  model's precision; an error (of text) if they are no finite numbers. */
int io_read_node(io_model *model, io_cursor *cursor, int64_t node, planish_error *error);

/** Points that are records of their own: three coordinates, and nothing else. */
typedef struct io_node_records {
    io_model *model;
    int64_t first;     /* node of the first record */
    int size, swapped; /* binary: bytes of a coordinate; its byte order is the other one */
} io_node_records;

/** Read points of an io_node_records, the context, from text or binary: io_records_fn. */
int io_read_nodes(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                  planish_error *error);

/** Begin n nodes of text, which have numbers and coordinates of field_width characters. */
int io_nodes_begin(io_model *model, int64_t n, int field_width, planish_error *error);
/** Take the next node: its number; where its coordinates, which are 0 so far, begin. */
int io_nodes_next(io_model *model, int64_t number, const char *at, planish_error *error);
/** Take coordinate d of that node, 0 where field is empty. */
int io_nodes_coordinate(io_model *model, int d, io_slice field, planish_error *error);
/** End the nodes: fail if there are fewer, reduce their numbers. */
int io_nodes_end(io_model *model, planish_error *error);

/** Return the bytes from the cursor to the end. */
static inline int64_t io_left(const io_cursor *cursor) {
    return cursor->end - cursor->at;
}

/** Take the whole number at the cursor, of 4 or 8 bytes, or text (bytes 0). Return 0 or -1. */
static inline int io_number(io_cursor *cursor, int bytes, int swapped, int64_t *value) {
    if (bytes == 0)
        return io_integer(cursor, value);
    if (io_left(cursor) < bytes)
        return -1;
    *value = bytes == 4 ? io_load_i32(cursor->at, swapped) : io_load_i64(cursor->at, swapped);
    cursor->at += bytes;
    return 0;
}

/** Records of one kind: what they are called in messages, and how whole numbers stand in them. */
typedef struct io_record_kind {
    const io_model *model;
    const char *what;
    int bytes, swapped; /* as for io_number */
} io_record_kind;

/** Fail as io_take_whole does; the cursor is still at at where there is no whole number. */
int io_fail_whole(const io_record_kind *kind, const char *at, const io_cursor *cursor,
                  int64_t record, int64_t first, int64_t last, const int64_t *value,
                  planish_error *error);

/** Take the whole number at the cursor, behind comments ('#') in text. It must be one of first ..
 *  last; the error names its place and the record, by that number. */
static inline int io_take_whole(const io_record_kind *kind, io_cursor *cursor, int64_t record,
                                int64_t first, int64_t last, int64_t *value, planish_error *error) {
    if (kind->bytes == 0)
        io_skip_space_comments(cursor, '#');
    const char *at = cursor->at;
    return io_number(cursor, kind->bytes, kind->swapped, value) == 0 && *value >= first &&
                   *value <= last
               ? PLANISH_OK
               : io_fail_whole(kind, at, cursor, record, first, last, value, error);
}

/** Let the file hold node for reason (an IO_HELD_ bit); threads may do so at the same time. */
static inline void io_hold_node(io_model *model, int64_t node, uint8_t reason) {
    uint8_t *hold = &model->hold[node];
    if ((__atomic_load_n(hold, __ATOMIC_RELAXED) & reason) == 0)
        __atomic_fetch_or(hold, reason, __ATOMIC_RELAXED);
}

#endif
