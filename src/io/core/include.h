/* include: files that a mesh file names, which stand beside it or below its folder.
 *
 *   io_include_find        the path of one
 *   io_include_open        open one
 *   io_include_compare     whether two names are of one file
 *   io_include_leads_up    whether a name has '..' in it
 *   io_include_is_hidden   whether a name is of a hidden file
 *   io_include_has         whether a place is in one
 *   io_include_fail_node   an error: it has nodes
 *   io_include_close       release all
 *
 * A file may not make planish read another one wherever it is: the path must not lead out of the
 * folder of the file, through links neither.
 */
#ifndef PL_IO_CORE_INCLUDE_H
#define PL_IO_CORE_INCLUDE_H

#include "io/core/text.h"

enum { IO_MOST_INCLUDED = 256 };

/** Make the path of the file called name, which the input names: *path, owned; NULL: it leads out of
 *  the folder. Error: _MEMORY. */
int io_include_find(const io_model *model, io_slice name, char **path, planish_error *error);

/** Open the file called name, which the file at the place at names; *content is all of it, until
 *  io_include_close. Places of errors (io_fail_at) may be in it. Errors: _FORMAT (it leads out of the
 *  folder, or there are more than IO_MOST_INCLUDED), _FILE, _MEMORY. */
int io_include_open(io_model *model, const char *at, io_slice name, io_cursor *content,
                    planish_error *error);

/** Compare two names, or paths in a file, by their parts between slashes or backslashes: 0 if they
 *  are one but for "./" and repeated slashes, else their order. */
int io_include_compare(io_slice a, io_slice b);

/** Return whether '..' is a part of a name. */
int io_include_leads_up(io_slice name);

/** Return whether a part of a name begins with a point, as those of hidden files and folders do. */
int io_include_is_hidden(io_slice name);

/** Return whether at is in an included file. */
int io_include_has(const io_model *model, const char *at);

/** Fail with _FORMAT: a node is at that place of an included file, but the input alone is written. */
int io_include_fail_node(const io_model *model, const char *at, planish_error *error);

/** Release the included files. */
void io_include_close(io_model *model);

#endif
