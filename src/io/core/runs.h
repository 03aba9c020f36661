/* runs: elements of one type that stand together in a file, set by several threads.
 *
 *   io_run_read, io_run_set                a run of elements becomes elements of the model
 *   io_runs_add                            runs that a first walk over the elements notes
 *   io_runs_index_tags                     tags of all elements become entities
 *
 * Readers of formats in which elements of several types are mixed (SU2, UCD, UNV) walk over the
 * elements once to find the runs, and read each run by io_text_records.
 */
#ifndef PL_IO_CORE_RUNS_H
#define PL_IO_CORE_RUNS_H

#include "io/core/elements.h"
#include "io/core/records.h"

/** A run while it is read. */
typedef struct io_run {
    io_model *model;
    const io_element_type *row;
    int dim;            /* of a simplex, else 0 */
    int type;           /* planish_cell_type of an other; 0: its nodes are held, or a simplex */
    int64_t first;      /* element of the run in its list, */
    int64_t first_node; /* and of an other its first node */
} io_run;

/** Begin a run of n elements, whose type has that row, and make room for them. Errors: _FORMAT (too
 *  many), _MEMORY. */
int io_run_begin(io_model *model, const io_element_type *row, int64_t n, io_run *run,
                 planish_error *error);

/** Read a run that io_runs_add has noted, as io_text_records does: begin *run, and end it. */
int io_run_read(io_model *model, io_text *text, const io_section *noted, const io_element_type *row,
                io_records_fn *read, void *context, io_run *run, planish_error *error);

/** Set element i of the run: its nodes [row->nodes], indices in the format's order, its tag, and its
 *  number in the file. Threads may set different elements at the same time. */
void io_run_set(const io_run *run, int64_t i, const int32_t *nodes, int32_t tag, int64_t number);

/** End a run of n elements, which all have been set. */
void io_run_end(const io_run *run, int64_t n);

/** Note an element whose type has that row of the reader's table, and which begins at at: as one more
 *  of the last run, or as the first of a new one. tokens: words of its record; runs are of one
 *  number. The last run ends at end. Error: _MEMORY. */
int io_runs_add(io_sections *runs, int row, int64_t tokens, const char *at, const char *end,
                planish_error *error);

/** Replace the tags of the elements of all lists by entities, and reduce the numbers of cells. */
int io_runs_index_tags(io_model *model, planish_error *error);

#endif
