/* twins: groups of a file that have one number and different names.
 *
 * The model knows a group by its number. Of groups of one number the first in the file keeps it; the others
 * get numbers of planish's own, which the file has not. io_model_file_number tells the file's number.
 */
#ifndef PL_IO_CORE_TWINS_H
#define PL_IO_CORE_TWINS_H

#include "io/core/model.h"
#include "io/core/text.h"

/** A group of the file. */
typedef struct io_twin {
    int32_t number; /* in the file */
    unsigned dims;  /* dimensions of its members, bits; none: it has no members */
    io_slice name;
    int64_t at;   /* place in the file */
    int32_t *own; /* set to the number in the model; NULL: not asked for */
} io_twin;

/** Find the numbers of groups [n] in the model, and sort them. Groups of the same number and name are one.
 *  Their numbers differ if any of their dimensions is the same. most: the largest number that the file uses
 *  otherwise. If there are not enough numbers of 32 bits, each group keeps that of the file. */
int io_twins_number(io_model *model, io_twin *twin, int64_t n, int64_t most, planish_error *error);

#endif
