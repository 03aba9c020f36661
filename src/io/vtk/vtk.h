/* vtk: what the parts of the reader of legacy VTK files share; for vtk.c, vtk_mesh.c, vtk_data.c.
 *
 * The function of a keyword stands behind the keyword and leaves the cursor behind its data. All
 * functions return 0 or a negative planish_status, *reader->error filled in.
 */
#ifndef PL_IO_VTK_VTK_H
#define PL_IO_VTK_VTK_H

#include "io/core/records.h"

typedef enum vtk_kind {

    VTK_SIGNED,
    VTK_UNSIGNED,
    VTK_REAL,
    VTK_BIT,
    VTK_STRING
} vtk_kind;

/* How a number of a VTK type stands in a binary file. */
typedef struct vtk_type {
    const char *name;
    vtk_kind kind;
    int size; /* bytes; 0: not whole bytes, or of different lengths */
} vtk_type;

typedef struct vtk_reader {
    io_model *model;
    planish_error *error;
    io_cursor cursor;
    io_text text;
    int swapped; /* this machine is not big-endian */
    int have_points, have_types, done;
    int64_t n_cells;
    int32_t *connectivity; /* [n_connectivity], owned: nodes of the cells; before version 5 each
                              cell's are led by their count */
    int64_t n_connectivity;
    int64_t *offset;  /* [n_cells + 1], owned: first node of each cell; NULL before version 5 */
    int32_t *type;    /* [n_cells], owned: VTK's cell types */
    int64_t n_tuples; /* of the attributes of POINT_DATA or CELL_DATA; -1: in neither */
    int on_points;    /* in POINT_DATA */
} vtk_reader;

/* ---- vtk.c: words and lines --------------------------------------------------------------- */

enum { VTK_MAX_WORDS = 8 };

typedef struct vtk_word {
    const char *at;
    int64_t length;
} vtk_word;

/** Fail at the cursor. */
int vtk_fail_here(const vtk_reader *reader, const char *text);

/** Cursor to the start of the next line; data follow there. */
void vtk_end_line(io_cursor *cursor);

/** The words of the rest of this line; at most VTK_MAX_WORDS. Cursor to the next line. */
int vtk_take_words(io_cursor *cursor, vtk_word *words);

/** The integer that a word is; 0 or -1. */
int vtk_word_number(vtk_word text, int64_t *value);

/** The type called name, or NULL. */
const vtk_type *vtk_find_type(vtk_word name);

/** Whether the next word is name; then the cursor goes behind it. In binary files nothing is
 *  skipped before it, as the next bytes may be data. */
int vtk_take_if(vtk_reader *reader, const char *name);

/* ---- vtk_mesh.c ---------------------------------------------------------------------------- */

int vtk_points(vtk_reader *reader);
int vtk_cells(vtk_reader *reader);
int vtk_cell_types(vtk_reader *reader);

/** Release the lists that CELLS and CELL_TYPES were read to. */
void vtk_release_lists(vtk_reader *reader);

/* ---- vtk_data.c ---------------------------------------------------------------------------- */

/** Something unknown: the end if the mesh is there, an error if it is not. */
int vtk_stop(vtk_reader *reader);

int vtk_point_data(vtk_reader *reader);
int vtk_cell_data(vtk_reader *reader);
int vtk_scalars(vtk_reader *reader);
int vtk_vectors(vtk_reader *reader);
int vtk_tensors(vtk_reader *reader);
int vtk_symmetric_tensors(vtk_reader *reader);
int vtk_ids(vtk_reader *reader);
int vtk_texture(vtk_reader *reader);
int vtk_colours(vtk_reader *reader);
int vtk_lookup_table(vtk_reader *reader);
int vtk_field(vtk_reader *reader);
int vtk_metadata(vtk_reader *reader);

#endif
