/* vtu: declarations that the parts of the reader and writer of VTK's XML files (.vtu) share.
 *
 *   vtu_document, vtu_piece, vtu_array   a file, as its markup tells
 *   vtu_xml.c      reads the markup
 *   vtu_array.c    decodes the numbers of arrays
 *   vtu.c          makes the model of them
 *   vtu_encode.c   writes points
 *
 * The XML is walked once by Expat, which sees the markup only: the numbers between are passed over.
 * Of that remains a list of the file's data arrays, each with the place of its bytes. Functions
 * return 0 or a negative planish_status with *error filled in.
 */
#ifndef PL_IO_VTK_VTU_PARTS_H
#define PL_IO_VTK_VTU_PARTS_H

#include "io/core/records.h"
#include "io/vtk/compression.h"
#include "io/vtk/vtk_numbers.h"

/** Meaning of an array to planish. */
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
    VTU_FIXED,      /* point data called `fixed` */
    VTU_POINT_DATA, /* other point data, and cell data, with a name */
    VTU_CELL_DATA
} vtu_role;

/** Names of arrays by their role, of cells as in the file, for messages. */
extern const char *const vtu_role_names[];

/** Form of the numbers of an array in the file. */
typedef enum vtu_form {
    VTU_ASCII,
    VTU_BASE64, /* in the element, or appended */
    VTU_RAW     /* appended */
} vtu_form;

/** A DataArray element. */
typedef struct vtu_array {
    vtu_role role;
    char *name;           /* of point data and cell data, owned, or NULL */
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
    const io_model *model; /* of the call under way, */
    planish_error *error;  /* and its error */
    int is_grid;           /* inside of VTKFile there is an UnstructuredGrid */
    int swapped;           /* numbers are not in this machine's byte order */
    int header_size;       /* bytes of the numbers in headers of arrays: 4 or 8 */
    io_compression compression;
    vtu_piece *piece; /* [n_pieces] owned */
    int64_t n_pieces, piece_capacity;
    vtu_array *array; /* [n_arrays] owned, in the file's order */
    int64_t n_arrays, array_capacity;
    int64_t appended; /* byte of the file where appended data begin, or -1 */
    vtu_form appended_form;
    int64_t unpacked; /* bytes that packed arrays have become: vtu_array.c bounds it */
} vtu_document;

/** The bytes of an array, decoded. */
typedef struct vtu_values {
    const char *data;
    char *owned;     /* NULL: they are the file's own bytes */
    int64_t n_bytes; /* of all that the array has */
} vtu_values;

/** Numbers that packed arrays begin with, before the blocks' sizes. */
enum { VTU_HEADER_NUMBERS = 3 };

/** Places of the packed blocks of an array. */
typedef struct vtu_blocks {
    int64_t n, size, last_size; /* bytes of all blocks but the last, and of that, unpacked */
    int64_t bytes;              /* of all, unpacked */
    int64_t last_told; /* the latter as the header has it: 0 if the last is whole, or not */
    int64_t *packed;   /* [n + 1] owned: where each begins among the packed bytes */
    const char *data;  /* packed bytes of all blocks */
    char *owned;       /* what data is if they were base64, else NULL */
    int64_t text_end;  /* byte of the file behind the array */
} vtu_blocks;

/* ---- vtu_xml.c ----------------------------------------------------------------------------- */

/** Fill in the document; released by vtu_document_release, also on failure. */
int vtu_read_markup(vtu_document *document);
void vtu_document_release(vtu_document *document);

/* ---- vtu_array.c --------------------------------------------------------------------------- */

/** Fail about an array: "FILE:LINE: ARRAY: text". */
int vtu_fail(const vtu_document *document, const vtu_array *array, const char *text);

/** Decode a binary array of at least n numbers, and note its data_end. Release values in any case.
 */
int vtu_decode(vtu_document *document, vtu_array *array, int64_t n, vtu_values *values);
void vtu_values_release(vtu_values *values);

/** Read n records of tokens words each from an array of text. */
int vtu_read_text(const vtu_document *document, const vtu_array *array, int64_t n, int64_t tokens,
                  io_records_fn *read, void *context);

/** Read the first n numbers of an array of any form to a new array: *wide, *narrow (numbers that do
 *  not fit are an error) or *real, whichever pointer is not NULL. The first two want whole numbers.
 */
int vtu_read_numbers(vtu_document *document, vtu_array *array, int64_t n, int64_t **wide,
                     int32_t **narrow, double **real);

/** Find the blocks of a packed array of at least bytes bytes. Release them in any case. */
int vtu_find_blocks(const vtu_document *document, const vtu_array *array, int64_t bytes,
                    vtu_blocks *blocks);
void vtu_blocks_release(vtu_blocks *blocks);

/** Bytes that all arrays that are used may be, unpacked: more is a small file that expands without
 *  bound, and no mesh. */
int64_t vtu_most_unpacked(const vtu_document *document);

/* ---- vtu_encode.c -------------------------------------------------------------------------- */

/** Encode the points that no span tells the place of (io_format.encode). */
int vtu_encode_points(const io_model *model, const double *coordinates, int threads,
                      io_edits *edits, planish_error *error);

#endif
