/* converting: meshes that are converted to other formats, for tests. All functions fail the test where
 * something goes wrong; files are closed by planish_file_close.
 */
#ifndef TEST_SUPPORT_CONVERTING_H
#define TEST_SUPPORT_CONVERTING_H

#include "support/file_builder.h"

/** Open the file at path. */
planish_file *converting_open(const char *path);

/** Write a file to the folder, open it, and release it. */
planish_file *converting_open_built(const char *folder, const char *name, file_builder *b);

/** Convert a file to the target called name, and open what is written: out-NAME and the extension, in
 *  the folder. lost: what it lacks. */
planish_file *converting_to(const char *folder, planish_file *file, const char *name,
                            const char *extension, char lost[512]);

/** Find the nodes that a tag holds: [n_nodes] 0 or 1, owned. */
uint8_t *converting_nodes_of(const planish_file *file, const char *tag);

#endif
