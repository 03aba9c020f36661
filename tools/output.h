/* output: the places that the program writes to.
 *
 * The mesh itself is written by planish_file_write; here are the checks that can be made before the
 * work begins, and the writing of the report.
 */
#ifndef PL_TOOLS_OUTPUT_H
#define PL_TOOLS_OUTPUT_H

#include <stddef.h>

/** Whether path is something else than a regular file or the name of a new one: a pipe, a device.
 */
int pl_output_is_stream(const char *path);

/** Whether what is written to path ends up where standard output goes. */
int pl_output_is_stdout(const char *path);

/** Whether the two paths name one existing file, or are the same words. */
int pl_output_same_file(const char *a, const char *b);

/** Whether writing to path would change a file of the mesh at mesh_path: itself, or, of TetGen's,
 *  those of the same base name beside it. */
int pl_output_hits_mesh(const char *path, const char *mesh_path);

/** Whether a file can be made or replaced at path; 0, or an exit status after a message. */
int pl_output_check(const char *path);

/** Write text [length] to path as a whole or not at all ("-": standard output; pipes and devices
 *  directly). Symbolic links are followed and the mode of a replaced file is kept. Returns 0, or
 *  the errno of what failed. */
int pl_output_write_text(const char *path, const char *text, size_t length);

#endif
