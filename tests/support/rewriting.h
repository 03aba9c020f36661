/* rewriting: what is written of a mesh file, for tests of readers. */
#ifndef TEST_SUPPORT_REWRITING_H
#define TEST_SUPPORT_REWRITING_H

#include "io/file.h"

/** Read size bytes at data, and write them: unchanged they are the same bytes; with some
 *  coordinates changed all read as written, and nothing but coordinates of the nodes differs.
 * folder: for the output, which is removed. */
void rewriting_keeps_the_rest(const io_format *format, const char *data, int64_t size,
                              const char *folder);

#endif
