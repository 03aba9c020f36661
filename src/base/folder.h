/* folder: make a folder complete beside its place, and rename it.
 *
 *   pl_folder_begin               the folder, under a temporary name
 *   pl_folder_add, pl_folder_file a folder or file in it
 *   pl_folder_commit, _release    rename it, or remove all of it
 */
#ifndef PL_BASE_FOLDER_H
#define PL_BASE_FOLDER_H

#include "base/output.h"

typedef struct pl_folder_output {
    char *target;    /* where the folder will be; owned */
    char *temporary; /* where it is now, owned; NULL: nowhere */
    char **made;     /* [n] owned paths of all that is in it, each behind the folder that has it */
    int64_t n, capacity;
} pl_folder_output;

/** Begin a folder that is to be at path, where nothing may be yet. Its temporary name, and those of all
 *  that comes into it, are listed in temporaries, each behind the folder that has it. */
int pl_folder_begin(const char *path, pl_temporaries temporaries, pl_folder_output *folder,
                    planish_error *error);

/** Make a folder called name within; name may have separators, for folders that are there. */
int pl_folder_add(pl_folder_output *folder, const char *name, pl_temporaries temporaries,
                  planish_error *error);

/** Begin to write a file called name within. Errors name the place where it will be. */
int pl_folder_file(pl_folder_output *folder, const char *name, pl_temporaries temporaries,
                   pl_output *output, planish_error *error);

/** Rename the folder to its place. All files in it are finished. */
int pl_folder_commit(pl_folder_output *folder, pl_temporaries temporaries, planish_error *error);

/** Remove the folder with all that is in it, unless it was renamed, and release. */
void pl_folder_release(pl_folder_output *folder, pl_temporaries temporaries);

#endif
