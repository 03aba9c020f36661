/* output: the places that the program writes to.
 *
 * The mesh itself is written by planish_file_write; here are the checks that can be made before the
 * work begins, and the writing of the report.
 *
 *     pl_output_check, _check_all, _check_still_new       whether files can be written
 *     pl_output_read_file                                 files that are read beside the inputs
 *     pl_output_takes_stdout                              what goes to standard output
 *     pl_output_same_file, _hits_mesh, _is_same_mesh      files that would be overwritten
 *     pl_output_write_text                                a report
 */
#ifndef PL_TOOLS_OUTPUT_H
#define PL_TOOLS_OUTPUT_H

#include "options/options.h"
#include "terminal/signals.h"

#include <stddef.h>

/** Whether the two paths name one file, which need not exist. */
int pl_output_same_file(const char *a, const char *b);

/** Whether writing to path would change a file that the mesh at mesh_path, of that format (NULL:
 * told by its name), can have: itself, or, of TetGen's, those of the same base name beside it. */
int pl_output_hits_mesh(const char *path, const char *mesh_path, const char *format);

/** Whether two paths are those of one mesh of that format: of one file, or of TetGen's .node and .ele. */
int pl_output_is_same_mesh(const char *a, const char *b, const char *format);

/** Whether a file can be made or replaced at path, which may be "-", standard output; 0, or an exit
 * status after a message. */
int pl_output_check(const char *path);

/** Whether the outputs and reports that the command line names can be made, and none of them would
 *  change a mesh that is read, or another one of them; 0, or an exit status after a message. */
int pl_output_check_all(const pl_arguments *arguments);

/** File that an option names, such as --like: it is read beside the inputs. */
typedef struct pl_read_file {
    const char *what; /* "the file of --like" */
    const char *path; /* NULL behind the last file */
} pl_read_file;

/** Find file i of these, 0 and up. */
pl_read_file pl_output_read_file(const pl_arguments *arguments, int i);

/** Check again, before the mesh is written, that OUT behind IN is not there yet; 0, or an exit status after
 *  a message. */
int pl_output_check_still_new(const pl_arguments *arguments);

/** Whether one of them goes to standard output, so that tables must not. */
int pl_output_takes_stdout(const pl_arguments *arguments);

/** Write text [length] to path as planish_file_write does ("-": standard output); which: of the
 *  temporary files. Returns 0, or a negative planish_status with *error filled in. */
int pl_output_write_text(const char *path, pl_temporary which, const char *text, size_t length,
                         planish_error *error);

#endif
