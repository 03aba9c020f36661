/* output: write a file beside its place and rename it, or straight into a pipe or device. */
#ifndef PL_BASE_OUTPUT_H
#define PL_BASE_OUTPUT_H

#include <planish/planish.h>

#include <stddef.h>
#include <stdint.h>

/** Temporary files that exist, for a signal handler to remove: paths that each end with '\0', one
 *  after another, an empty one at the end. */
typedef struct pl_temporaries {
    char *paths; /* [size], the caller's, or NULL */
    size_t size;
} pl_temporaries;

typedef struct pl_output {
    int fd;
    char *target;    /* where the file will be: symbolic links followed; owned */
    char *temporary; /* where it is now, owned; NULL: written directly */
    int replaces;    /* there was a file in its place already */
    int is_committed;
} pl_output;

/** Not 0 if path is written as it is: a pipe, a device, a name of an open file (/dev/stdout). */
int pl_output_is_stream(const char *path);

/** path with a link at its end followed, also one that leads nowhere yet, but none that the system
 *  would not follow. Owned; NULL: errno. */
char *pl_output_target(const char *path);

/** Begin to write path. A file that exists keeps owner, mode, access list and attributes, or as
 * much of them as is allowed (pl_file_take_access). */
int pl_output_open(const char *path, pl_temporaries temporaries, pl_output *output,
                   planish_error *error);
/** Write all of size bytes. */
int pl_output_write(pl_output *output, const char *data, int64_t size, planish_error *error);
/** Close: all bytes have been taken by the system. */
int pl_output_finish(pl_output *output, planish_error *error);
/** After pl_output_finish: write size bytes in place of all that has been written, and finish. */
int pl_output_rewrite(pl_output *output, const char *data, int64_t size, planish_error *error);
/** Rename to the target, after pl_output_finish. */
int pl_output_commit(pl_output *output, pl_temporaries temporaries, planish_error *error);
/** Take back pl_output_commit: remove the target, if it is a new one. */
void pl_output_undo(const pl_output *output);
/** Remove what is left (the temporary file, if it was not renamed) and release. */
void pl_output_release(pl_output *output, pl_temporaries temporaries);

#endif
