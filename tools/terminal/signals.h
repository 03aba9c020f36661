/* signals: the program when it is told to stop.
 *
 * Before smoothing begins, SIGINT, SIGTERM and SIGHUP end the program with a line. Then the first one
 * asks the smoothing to stop after the colour it is at; the second one ends the program at once,
 * temporary files removed. An input that shrinks while it is
 * mapped, as large ones are (SIGBUS), ends it with one line that names it. A reader that goes away
 * makes writing fail (SIGPIPE is ignored), so that it is reported like any other failure to write.
 *
 *     pl_signals_install, _install_stop, _done         for main and the commands
 *     pl_signals_stop_asked                            for the smoothing
 *     pl_signals_set_input, _set_before_smoothing,
 *     _set_written, _temporary                         state that a signal has to know
 *     the others                                       between signals.c and the systems' files
 */
#ifndef PL_TOOLS_SIGNALS_H
#define PL_TOOLS_SIGNALS_H

/** Files that are removed when the program is ended by a signal. */
typedef enum pl_temporary {
    PL_TEMPORARY_MESH,
    PL_TEMPORARY_REPORT, /* as JSON */
    PL_TEMPORARY_PAGE,   /* the report for people */
    PL_N_TEMPORARIES
} pl_temporary;

/* Of 15 files (TetGen's) with paths as long as the system takes; of hundreds in a folder with usual
 * ones. */
enum { PL_TEMPORARY_SIZE = 16 * 4096 };
/* A longer name is cut. */
enum { PL_INPUT_NAME_SIZE = 1024 };

/** Sequence that erases a line on a terminal, from its cursor on. */
#define PL_ERASE_TO_END "\033[K"

/** For every command: SIGPIPE and SIGBUS; and SIGINT, SIGTERM and SIGHUP, unless the parent had
 *  them ignored, end the program at once, with nothing half written left behind. So does a library
 *  that calls exit, which is then a failure. */
void pl_signals_install(void);

/** For smooth, when there is something to save: the first of SIGINT, SIGTERM and SIGHUP asks to
 *  stop. */
void pl_signals_install_stop(void);

/* For signals_posix.c and signals_windows.c, and by them: */

/** Let signals end the program. */
void pl_signals_install_ends(void);

/** Take the shown line away, and remove half-written files. */
void pl_signals_clean_up(void);

/** Print one line that a signal ends the program; nothing where no input is named. */
void pl_signals_say_ended(void);

/** Ask to stop. Returns whether that had been asked before. */
int pl_signals_ask_stop(void);

/** Name the input that is in use from now on, for the lines about a signal and about an input that
 *  shrinks; NULL: none is. */
void pl_signals_set_input(const char *path);

/** Say whether the mesh is going to be smoothed, and nothing of it has been written. */
void pl_signals_set_before_smoothing(int is_before);

/** For the two files that meet signals: end because the input has become shorter. */
void pl_signals_end_shorter(void);

/** Whether a signal asked to stop. */
int pl_signals_stop_asked(void);

/** The mesh has been written: whatever ends the program now, that is so. */
void pl_signals_set_written(void);

/** The program ends by itself; returns status. */
int pl_signals_done(int status);

/** The place where the paths of temporary files and folders (each before what is in it) are kept
 *  while there are any: PL_TEMPORARY_SIZE
 *  bytes, each path ends with '\0' and an empty one ends the list (as in planish_file_write). */
char *pl_signals_temporary(pl_temporary which);

/** Whether a line that must be cleared (terminal.h) is shown from now on; returns whether one was
 *  before. */
int pl_signals_set_line(int is_shown);

#endif
