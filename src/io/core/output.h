/* output: write a file beside its place and rename it, or straight into a pipe or device. */
#ifndef PL_IO_CORE_OUTPUT_H
#define PL_IO_CORE_OUTPUT_H

#include <planish/planish.h>

#include <stddef.h>
#include <stdint.h>

/** Temporary files that exist, for a signal handler to remove: paths that each end with '\0', one
 *  after another, an empty one at the end. */
typedef struct io_temporaries {
    char *paths; /* [size], the caller's, or NULL */
    size_t size;
} io_temporaries;

typedef struct io_output {
    int fd;
    char *target;    /* where the file will be: symbolic links followed; owned */
    char *temporary; /* where it is now, owned; NULL: written directly */
    int replaces;    /* there was a file in its place already */
    int is_committed;
} io_output;

/** Not 0 if path is written as it is: a pipe, a device, a name of an open file (/dev/stdout). */
int io_output_is_stream(const char *path);

/** path with a link at its end followed, also one that leads nowhere yet, but none that the system
 *  would not follow. Owned; NULL: errno. */
char *io_output_target(const char *path);

/** Begin to write path. A file that exists keeps owner, mode, access list and attributes, or as
 * much of them as is allowed (base/access.h). */
int io_output_open(const char *path, io_temporaries temporaries, io_output *output,
                   planish_error *error);
/** Write all of size bytes. */
int io_output_write(io_output *output, const char *data, int64_t size, planish_error *error);
/** Close: all bytes have been taken by the system. */
int io_output_finish(io_output *output, planish_error *error);
/** After io_output_finish: write size bytes in place of all that has been written, and finish. */
int io_output_rewrite(io_output *output, const char *data, int64_t size, planish_error *error);
/** Rename to the target, after io_output_finish. */
int io_output_commit(io_output *output, io_temporaries temporaries, planish_error *error);
/** Take back io_output_commit: remove the target, if it is a new one. */
void io_output_undo(const io_output *output);
/** Remove what is left (the temporary file, if it was not renamed) and release. */
void io_output_release(io_output *output, io_temporaries temporaries);

#endif
