/* reading: mesh files from memory, for tests of readers. */
#ifndef TEST_SUPPORT_READING_H
#define TEST_SUPPORT_READING_H

#include "io/file/file.h"

/** Read text as a file of format; it must succeed. Close with planish_file_close. */
planish_file *reading_text(const io_format *format, const char *text);

/** Read text; it must fail with a message that holds word. */
void reading_fails(const io_format *format, const char *text, const char *word);

/** Read text, which is a surface in space: a mesh of dimension 3 whose cells are all flat. */
void reading_gives_surface(const io_format *format, const char *text);

/** Expect the corner of a cube in four tetrahedra around a node inside, the last one. */
void reading_gave_four(const planish_mesh *mesh);

/** Read every beginning of size bytes at data (each in memory of its own, so that a sanitizer sees
 *  any look behind the end): a mesh or an error with a text. */
void reading_every_beginning(const io_format *format, const char *data, int64_t size);

/** Return whether this build reads VTU files, for which it needs Expat. */
int reading_knows_vtu(void);

#endif
