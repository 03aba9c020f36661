/* vtu_builder: a small mesh in every encoding of VTU. */
#ifndef TEST_VTU_BUILDER_H
#define TEST_VTU_BUILDER_H

#include "io/core/binary.h"
#include "io/vtk/compression.h"
#include "support/file_builder.h"

enum { N_NODES = 6, N_CELLS = 6, N_ARRAYS = 8, MOST_VALUES = 32 };

typedef enum form { ASCII, INLINE, APPENDED_RAW, APPENDED_BASE64 } form;

/** How a test file is written. */
typedef struct variant {
    form form;
    int is_float, header_size, is_big;
    io_compression compression;
    int block;       /* bytes of a block, if packed */
    int keys;        /* information keys in the elements: 1 before the numbers, 2 behind them */
    int tells_whole; /* the size of a last block that is whole is told, in place of 0 */
    int surplus;     /* numbers that each array has behind those that are promised */
} variant;

/** An array of the file. */
typedef struct array {
    const char *section, *name, *type;
    int size, is_real, n;
    double value[MOST_VALUES];
} array;

extern const double vtu_points[N_NODES][3];
/* A line, a tetrahedron, a triangle, and the other tetrahedra: nodes, VTK's types, materials. */
extern const int vtu_cells[N_CELLS][4], vtu_types[N_CELLS], vtu_regions[N_CELLS];

/** Make the array as it stands in the file. */
file_builder vtu_written(const variant *v, const array *a);

/** Fill a with the arrays of the file, without surplus of v. */
void vtu_make_arrays(const variant *v, array a[N_ARRAYS]);

/** Write the values of an array. */
void vtu_put_values(file_builder *f, const array *a);

/** Write raw bytes, whatever they are. */
void vtu_put_bytes(file_builder *f, const char *data, int64_t n);

/** Make header and data of a binary array: blocks with compression. *header: bytes of the header.
 */
file_builder vtu_encode_array(const variant *v, const array *a, int64_t *header);

/** Whether the data stand at the end of the file. */
int vtu_is_appended(const variant *v);

/** Make the file. */
file_builder vtu_make_file(const variant *v);

#endif
