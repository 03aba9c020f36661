/* vtk_numbers: the numbers of VTK's arrays, whatever file they stand in.
 *
 *   vtk_type, vtk_find_type          types of numbers by their names
 *   vtk_real, ...                    a number from its bytes
 *   vtk_list, vtk_read_list          read many numbers, of text or bytes
 *   vtk_order_tensors                symmetric tensors in planish's order
 */
#ifndef PL_IO_VTK_VTK_NUMBERS_H
#define PL_IO_VTK_VTK_NUMBERS_H

#include "io/core/records.h"

typedef enum vtk_kind { VTK_SIGNED, VTK_UNSIGNED, VTK_REAL, VTK_BIT, VTK_STRING } vtk_kind;

/** How a number of a VTK type stands in a binary file. */
typedef struct vtk_type {
    const char *name;
    vtk_kind kind;
    int size; /* bytes; 0: not whole bytes, or of different lengths */
} vtk_type;

/** Return the type of a name in legacy files, in any letter case, or in XML files; or NULL. */
const vtk_type *vtk_find_type(io_slice name);
const vtk_type *vtk_find_xml_type(io_slice name);

/** Return the number at at, of whole bytes, as a real. */
double vtk_real(const char *at, const vtk_type *type, int swapped);

/** Load value number i of data, bits too: 1, or 0 if it is not a whole number. */
int vtk_whole(const char *data, int64_t i, const vtk_type *type, int swapped, int64_t *value);

/** Form of numbers in the file, and the array that they are read to. */
typedef struct vtk_list {
    const io_model *model;
    const char *name;     /* of the array, for messages */
    const vtk_type *type; /* NULL: text */
    int swapped;
    int64_t *wide; /* [n] one of these three is not NULL; numbers that do not fit are an error */
    int32_t *narrow;
    double *real;
} vtk_list;

/** Read numbers of a vtk_list, the context: io_records_fn. */
int vtk_read_list(void *context, io_cursor *cursor, int64_t begin, int64_t end,
                  planish_error *error);

/** Put the six numbers of symmetric tensors [n][width], in VTK xx, yy, zz, xy, yz, xz, into the order of
 *  planish_data: xx, xy, yy, xz, yz, zz. Values of another width stay. */
void vtk_order_tensors(double *values, int64_t n, int64_t width);

#endif
