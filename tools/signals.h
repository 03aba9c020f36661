/* signals: what the program does when it is told to stop.
 *
 * The first SIGINT or SIGTERM asks the smoothing to stop after the colour it is at; the second one
 * ends the program at once, temporary files removed. An input that shrinks while it is mapped
 * (SIGBUS) ends it with one line. A reader that goes away makes writing fail (SIGPIPE is ignored),
 * so that it is reported like any other failure to write.
 */
#ifndef PL_TOOLS_SIGNALS_H
#define PL_TOOLS_SIGNALS_H

/** Files that are removed when the program is ended by a signal. */
typedef enum pl_temporary { PL_TEMPORARY_MESH, PL_TEMPORARY_REPORT, PL_N_TEMPORARIES } pl_temporary;

enum { PL_TEMPORARY_SIZE = 16384 };

/** For every command: SIGPIPE and SIGBUS. */
void pl_signals_install(void);

/** For smooth: SIGINT and SIGTERM as well, unless the parent had them ignored. */
void pl_signals_install_stop(void);

/** Whether a signal asked to stop. */
int pl_signals_stop_asked(void);

/** The place where the paths of temporary files are kept while there are any: PL_TEMPORARY_SIZE
 *  bytes, each path ends with '\0' and an empty one ends the list (as in planish_file_write). */
char *pl_signals_temporary(pl_temporary which);

#endif
