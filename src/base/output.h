/* output: write a file beside its place and rename it, or straight into a pipe or device.
 *
 *   pl_output_open, _write, _finish, _commit, _release    one file
 *   pl_temporaries_add, _remove                           the list that a signal handler reads
 *   pl_temporary_name                                     names of what is temporary
 *
 * folder.h makes folders in the same way.
 */
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
    /* Function that packs the bytes of pl_output_write, and writes them by
     * pl_output_write_as_it_is; with data NULL, by pl_output_finish, the end. NULL: nothing does.
     * */
    int (*pack)(struct pl_output *output, const char *data, int64_t size, planish_error *error);
    void *packer; /* its state */
} pl_output;

/** List a path before there is something at it; forget it. */
void pl_temporaries_add(pl_temporaries list, const char *path);
void pl_temporaries_remove(pl_temporaries list, const char *path);

/** Make the i-th temporary name beside target: TARGET.planish-PROCESS-i, cut so that the system takes
 *  it. Owned; NULL without memory. */
char *pl_temporary_name(const char *target, int i);
enum { PL_TEMPORARY_NAMES = 1000 }; /* that are tried */

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
/** Write them past pl_output.pack. */
int pl_output_write_as_it_is(pl_output *output, const char *data, int64_t size,
                             planish_error *error);
/** Close: all bytes have been taken by the system. */
int pl_output_finish(pl_output *output, planish_error *error);
/** After pl_output_finish: write size bytes in place of all that has been written, and finish. */
int pl_output_rewrite(pl_output *output, const char *data, int64_t size, planish_error *error);
/** Rename to the target, after pl_output_finish. */
int pl_output_commit(pl_output *output, pl_temporaries temporaries, planish_error *error);
/** Take back pl_output_commit: remove the target, if it is a new one. */
void pl_output_undo(const pl_output *output);
/** Remove the temporary file, if it was not renamed, and release the memory. */
void pl_output_release(pl_output *output, pl_temporaries temporaries);

#endif
