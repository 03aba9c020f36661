/* records: many records of numbers read by several threads, in text and in binary.
 *
 * A reader gives a function that reads records begin .. end-1 from a cursor that stands on the
 * first of them. Where records are many, io_text_records finds the places between (by an index of
 * the file's tokens) and threads read chunks of them; otherwise, and when any chunk fails, the
 * same function reads all of them in order, so that errors are those of the first bad record.
 * Before a comment nothing is read by threads: its words are tokens to the index and none to the
 * reader, and what a pass notes of misplaced records (nodes that are held) could not be taken back.
 * Nothing is assumed about lines: records are as many tokens as the caller says.
 */
#ifndef PL_IO_CORE_RECORDS_H
#define PL_IO_CORE_RECORDS_H

#include "io/core/text.h"

/** Read records begin .. end-1 of context; the cursor ends behind the last. error is NULL when the
 *  records will be read once more should they fail. Called on several threads at once. */
typedef int io_records_fn(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                          planish_error *error);

/** A text file and, once a large section was met, the index of its tokens. */
typedef struct io_text {
    const char *begin, *end;
    int threads;
    int64_t *before; /* [pieces + 1] tokens that start before each piece of bytes, or NULL */
} io_text;

void io_text_init(io_text *text, const io_model *model);
void io_text_release(io_text *text);

/** Read n records of tokens tokens each from *cursor; the cursor ends at the next token. */
int io_text_records(io_text *text, io_cursor *cursor, int64_t n, int64_t tokens,
                    io_records_fn *read, void *context, planish_error *error);

/** Read n records of size bytes each from *cursor; the caller has checked that they are there. */
int io_binary_records(int threads, io_cursor *cursor, int64_t n, int64_t size, io_records_fn *read,
                      void *context, planish_error *error);

/** Read the three coordinates of node from text, note their place, round them to the model's
 *  precision; an error (of text) if they are no finite numbers. */
int io_read_point(io_model *model, io_cursor *cursor, int64_t node, planish_error *error);

/** Bytes from the cursor to the end. */
static inline int64_t io_left(const io_cursor *cursor) {
    return cursor->end - cursor->at;
}

/** Let the file hold node for reason (an IO_HELD_ bit); threads may do so at the same time. */
static inline void io_hold_node(io_model *model, int64_t node, uint8_t reason) {
    uint8_t *hold = &model->hold[node];
    if ((__atomic_load_n(hold, __ATOMIC_RELAXED) & reason) == 0)
        __atomic_fetch_or(hold, reason, __ATOMIC_RELAXED);
}

#endif
