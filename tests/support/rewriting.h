/* rewriting: what is written of a mesh file, for tests of readers. */
#ifndef TEST_SUPPORT_REWRITING_H
#define TEST_SUPPORT_REWRITING_H

#include "io/file/file.h"

/** Read size bytes at data, and write them: unchanged they are the same bytes; with some
 *  coordinates changed all read as written, and nothing but coordinates of the nodes differs.
 * folder: for the output, which is removed. */
void rewriting_keeps_the_rest(const io_format *format, const char *data, int64_t size,
                              const char *folder);

/** Write size bytes at data, a file called name in folder, from there: unchanged they are the same
 *  bytes. With two coordinates of the first five nodes changed no more than the bytes of two
 *  numbers differ (is_packed: that is not asked), and all is read as written. */
void rewriting_in_place(const char *data, int64_t size, int is_packed, const char *folder,
                        const char *name);

/** Read text, give the first node the coordinates that move names (x: 0.125, y: -1/3,
 *  z: 123456.789, as the file can hold them), write it, and fail the test unless that is expected,
 *  which reads as what was written. */
void rewriting_gives(const io_format *format, const char *text, const char *move,
                     const char *expected, const char *folder);

#endif
