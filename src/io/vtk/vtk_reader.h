/* vtk_reader: declarations that the parts of the reader of legacy VTK files share; for vtk.c
 * (header, points, cells) and vtk_data.c (attributes).
 *
 * The function of a keyword stands behind the keyword and leaves the cursor behind its data. All
 * functions return 0 or a negative planish_status, *reader->error filled in.
 */
#ifndef PL_IO_VTK_VTK_READER_H
#define PL_IO_VTK_VTK_READER_H

#include "io/core/records.h"
#include "io/vtk/vtk_cells.h"

typedef struct vtk_reader {
    io_model *model;
    planish_error *error;
    io_cursor cursor;
    io_text text;
    int swapped; /* this machine is not big-endian */
    int have_points, have_types, done;
    vtk_grid grid;    /* its lists until CELL_TYPES has been read */
    int64_t n_tuples; /* of the attributes of POINT_DATA or CELL_DATA; -1: in neither */
    int on_points;    /* in POINT_DATA */
} vtk_reader;

/** Fail at the cursor. */
int vtk_fail_here(const vtk_reader *reader, const char *text);

/** Move the cursor to the start of the next line; data follow there. */
void vtk_end_line(io_cursor *cursor);

/** Skip the next word if it is name; return whether it was. In binary files nothing is skipped
 *  before it, as the next bytes may be data. */
int vtk_take_if(vtk_reader *reader, const char *name);

/** Read the data behind a keyword: hold nodes, take arrays, or pass over it. Anything
 *  unknown is the end if the mesh is there, and an error if it is not. */
int vtk_read_data(vtk_reader *reader, io_slice keyword);

/** Read the values of an array: io_format.read_data. */
int vtk_read_values(io_model *model, const io_data *data, double *values, planish_error *error);

#endif
