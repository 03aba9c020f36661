/* folder_files: mesh files in a folder, for tests of readers that open files by their names. */
#ifndef TEST_SUPPORT_FOLDER_FILES_H
#define TEST_SUPPORT_FOLDER_FILES_H

#include "planish/planish_io.h"

/** Write a text to name in folder. */
void folder_write(const char *folder, const char *name, const char *text);

/** Open the file called name in folder; it must succeed. Close with planish_file_close. */
planish_file *folder_open(const char *folder, const char *name);

/** Open the file called name in folder, by this process and by a child: both must fail with a message
 *  of one line that holds word. */
void folder_open_fails(const char *folder, const char *name, const char *word);

#endif
