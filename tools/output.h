/* output: the places that the program writes to.
 *
 * The mesh itself is written by planish_file_write; here are the checks that can be made before the
 * work begins, and the writing of the report.
 */
#ifndef PL_TOOLS_OUTPUT_H
#define PL_TOOLS_OUTPUT_H

#include <planish/planish.h>

#include <stddef.h>

/** Whether what is written to path ends up where standard output goes. */
int pl_output_is_stdout(const char *path);

/** Whether the two paths name one file, which need not exist. */
int pl_output_same_file(const char *a, const char *b);

/** Whether writing to path would change a file of the mesh at mesh_path: itself, or, of TetGen's,
 *  those of the same base name beside it. */
int pl_output_hits_mesh(const char *path, const char *mesh_path);

/** Whether a file can be made or replaced at path; 0, or an exit status after a message. */
int pl_output_check(const char *path);

/** Write text [length] to path as planish_file_write does ("-": standard output). Returns 0, or a
 *  negative planish_status with *error filled in. */
int pl_output_write_text(const char *path, const char *text, size_t length, planish_error *error);

#endif
