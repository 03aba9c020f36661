/* vtu: what the parts of the reader and writer of VTK's XML files (.vtu) share; for vtu.c,
 * vtu_xml.c, vtu_array.c, vtu_points.c and vtu_encode.c.
 *
 * The XML is walked once by Expat, which sees the markup only: the numbers between are passed over.
 * Of that remains a list of the file's data arrays, each with the place of its bytes. Functions
 * return 0 or a negative planish_status with *error filled in.
 */
#ifndef PL_IO_VTK_VTU_PARTS_H
#define PL_IO_VTK_VTU_PARTS_H

#include "io/core/format.h"
#include "io/vtk/compression.h"
#include "io/core/records.h"
#include "io/vtk/vtk.h"

/** What an array is to planish. */
typedef enum vtu_role {
    VTU_OTHER,
    VTU_POINTS,
    VTU_CONNECTIVITY,
    VTU_OFFSETS,
    VTU_TYPES,
    VTU_FACES, /* of polyhedra: streams of faces, and where each ends, */
    VTU_FACE_OFFSETS,
    VTU_POLYHEDRON_OFFSETS, /* or, since version 2.3, the faces of each, and the nodes of these */
    VTU_POLYHEDRON_TO_FACES,
    VTU_FACE_ENDS,
    VTU_FACE_NODES,
    VTU_FIXED,    /* point data called `fixed` */
    VTU_CELL_DATA /* cell data with a name */
} vtu_role;

/** How the numbers of an array stand in the file. */
typedef enum vtu_form {
    VTU_ASCII,
    VTU_BASE64, /* in the element, or appended */
    VTU_RAW     /* appended */
} vtu_form;

/** A DataArray element. */
typedef struct vtu_array {
    vtu_role role;
    char *name;           /* of cell data, owned, or NULL */
    int piece;            /* number of the Piece it is in, or -1 */
    const vtk_type *type; /* NULL: of a type that is not read */
    int64_t n_components;
    vtu_form form;
    int is_appended;
    int64_t tag;        /* byte of the file where its tag begins, for messages */
    int64_t begin, end; /* bytes of its text; appended: from its first byte to the file's end, */
    int64_t data_end;   /* and where it ends, if it has been decoded; else 0 */
    int64_t offset;     /* appended: from the beginning of the appended data, */
    int64_t offset_begin, offset_end; /* as the file says there */
} vtu_array;

typedef struct vtu_piece {
    int64_t n_points, n_cells;
    int64_t first_point, first_cell; /* in the file's count of all */
    int64_t first_array;             /* of the document's; its own end before the next piece's */
} vtu_piece;

/** A file, as its markup tells. */
typedef struct vtu_document {
    int is_grid;     /* inside of VTKFile there is an UnstructuredGrid */
    int swapped;     /* numbers are not in this machine's byte order */
    int header_size; /* bytes of the numbers in headers of arrays: 4 or 8 */
    io_compression compression;
    vtu_piece *piece; /* [n_pieces] owned */
    int64_t n_pieces, piece_capacity;
    vtu_array *array; /* [n_arrays] owned, in the file's order */
    int64_t n_arrays, array_capacity;
    int64_t appended; /* byte of the file where appended data begin, or -1 */
    vtu_form appended_form;
    int64_t unpacked; /* bytes that packed arrays have become: vtu_array.c bounds it */
} vtu_document;

/** The numbers of an array, decoded. */
typedef struct vtu_values {
    const char *data;
    char *owned;     /* NULL: they are the file's own bytes */
    int64_t n;       /* numbers that were asked for, */
    int64_t n_bytes; /* and bytes of all that the array has */
    const vtk_type *type;
    int swapped;
} vtu_values;

/** Numbers that packed arrays begin with, before the blocks' sizes. */
enum { VTU_HEADER_NUMBERS = 3 };

/** Where the packed blocks of an array are. */
typedef struct vtu_blocks {
    int64_t n, size, last_size; /* bytes of all blocks but the last, and of that, unpacked */
    int64_t bytes;              /* of all, unpacked */
    int64_t last_told; /* the latter as the header has it: 0 if the last is whole, or not */
    int64_t *packed;   /* [n + 1] owned: where each begins among the packed bytes */
    const char *data;  /* packed bytes of all blocks */
    char *owned;       /* what data is if they were base64, else NULL */
    int64_t text_end;  /* byte of the file behind the array */
} vtu_blocks;

/** The piece that an array is of. */
static inline const vtu_piece *vtu_piece_of(const vtu_document *document, const vtu_array *array) {
    return &document->piece[array->piece];
}

/* ---- vtu_xml.c ----------------------------------------------------------------------------- */

/** Fill in the document; released by vtu_document_release, also on failure. */
int vtu_read_markup(io_model *model, vtu_document *document, planish_error *error);
void vtu_document_release(vtu_document *document);

/* ---- vtu_array.c --------------------------------------------------------------------------- */

/** Decode a binary array of at least n numbers; tells its data_end. */
int vtu_decode(const io_model *model, vtu_document *document, vtu_array *array, int64_t n,
               vtu_values *values, planish_error *error);
void vtu_values_release(vtu_values *values);

/** Number i. */
double vtu_real(const vtu_values *values, int64_t i);
int64_t vtu_integer(const vtu_values *values, int64_t i);

/** The first n integers of an array of any form, as int64_t or (those that do not fit are an error)
 *  int32_t: *wide or *narrow is allocated, the other is NULL. */
int vtu_read_integers(io_model *model, vtu_document *document, vtu_array *array, int64_t n,
                      int64_t **wide, int32_t **narrow, planish_error *error);

/** An array of point or cell data: its first n numbers as doubles, allocated. */
int vtu_read_reals(io_model *model, vtu_document *document, vtu_array *array, int64_t n,
                   double **values, planish_error *error);

/** The blocks of a packed array of at least bytes bytes. */
int vtu_find_blocks(const io_model *model, vtu_document *document, const vtu_array *array,
                    int64_t bytes, vtu_blocks *blocks, planish_error *error);
void vtu_blocks_release(vtu_blocks *blocks);

/** Bytes that all arrays that are used may be, unpacked: more is a small file that expands without
 *  bound, and no mesh. */
int64_t vtu_most_unpacked(const io_model *model, const vtu_document *document);

/** "FILE:LINE: text" about an array. */
int vtu_fail(const io_model *model, const vtu_array *array, planish_error *error, const char *text);

/* ---- vtu_points.c -------------------------------------------------------------------------- */

/** Read the points of all pieces, note where they stand. */
int vtu_read_points(io_model *model, vtu_document *document, planish_error *error);

/** Whether the bytes of appended points are theirs alone, so that they can be replaced. */
int vtu_check_overlaps(const io_model *model, const vtu_document *document, planish_error *error);

/* ---- vtu_encode.c -------------------------------------------------------------------------- */

/** What the points that no span tells the place of become (io_format.encode). */
int vtu_encode_points(const io_model *model, const double *coordinates, int threads,
                      io_edits *edits, planish_error *error);

#endif
