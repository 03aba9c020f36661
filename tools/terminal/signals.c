/* signals: what the program does when it is told to stop; how it is told is in signals_posix.c and
 * signals_windows.c. */
#include "terminal/signals.h"

#include "terminal/message.h"
#include "terminal/text.h"

#include "base/system.h"

#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The only changing globals of the program: a signal handler can reach nothing else. */
static atomic_int stop_asked, line_is_shown, is_done;
static atomic_int status_now = PL_EXIT_FAILED; /* if somebody else ends the program */
static char temporary_paths[PL_N_TEMPORARIES][PL_TEMPORARY_SIZE];
static char input_name[PL_INPUT_NAME_SIZE]; /* as it can be shown */
static atomic_int input_is_named;
static atomic_int is_before_smoothing;

static void say(const char *text) {
    const ssize_t written = write(STDERR_FILENO, text, (unsigned)strlen(text));
    (void)written;
}

/** Remove what is listed from the last to the first: a folder stands before what is in it. */
static void remove_all(const char *list) {
    const char *path = list;
    while (*path)
        path += strlen(path) + 1;
    while (path > list) {
        path--; /* the end of the one before */
        while (path > list && path[-1])
            path--;
        pl_file_remove(path);
    }
}

void pl_signals_clean_up(void) {
    if (atomic_exchange(&line_is_shown, 0))
        say("\r" PL_ERASE_TO_END);
    for (int i = 0; i < PL_N_TEMPORARIES; i++)
        remove_all(temporary_paths[i]);
}

/** Clean up, print text, and end the program. */
static void end_with(const char *text) {
    pl_signals_clean_up();
    say(text);
    _exit(atomic_load(&status_now));
}

void pl_signals_say_ended(void) {
    static const char before[] =
        ": interrupted by a signal before smoothing began; nothing was written\n";
    char line[PL_INPUT_NAME_SIZE + sizeof before + 16] = "planish: ";
    if (!atomic_load(&input_is_named))
        return;
    strcat(line, input_name);
    strcat(line, atomic_load(&is_before_smoothing) ? before : ": interrupted by a signal\n");
    say(line); /* at once: another signal may end the program between two pieces */
}

void pl_signals_set_before_smoothing(int is_before) {
    atomic_store(&is_before_smoothing, is_before);
}

void pl_signals_set_input(const char *path) {
    char name[PL_INPUT_NAME_SIZE] = "";
    atomic_store(&status_now, PL_EXIT_FAILED); /* of several meshes the next one is not written */
    if (path) {
        snprintf(name, sizeof name, "%s", path);
        pl_text_clean(name);
        if (atomic_load(&input_is_named) && strcmp(name, input_name) == 0)
            return; /* no moment without a name */
    }
    atomic_store(&input_is_named, 0);
    atomic_store(&is_before_smoothing, 0);
    memcpy(input_name, name, sizeof input_name);
    atomic_store(&input_is_named, path != NULL);
}

void pl_signals_end_shorter(void) {
    pl_signals_clean_up();
    say("planish: ");
    say(atomic_load(&input_is_named) ? input_name : "the input");
    end_with(": became shorter while it was in use; run again when it is complete\n");
}

/* libgomp ends the process with a line of its own and status 1 where it has no memory or no thread,
 * HDF5 with 255. The first would say that there is a mesh. */
static void on_exit_by_others(void) {
    if (!atomic_load(&is_done))
        end_with("planish: a library ended the program, probably for lack of memory or threads\n");
}

void pl_signals_install(void) {
    atexit(on_exit_by_others);
    pl_signals_install_ends();
}

int pl_signals_ask_stop(void) {
    return atomic_exchange(&stop_asked, 1);
}

int pl_signals_stop_asked(void) {
    return atomic_load(&stop_asked);
}

void pl_signals_set_written(void) {
    atomic_store(&status_now, PL_EXIT_PARTLY);
}

int pl_signals_done(int status) {
    atomic_store(&is_done, 1);
    return status;
}

char *pl_signals_temporary(pl_temporary which) {
    return temporary_paths[which];
}

int pl_signals_set_line(int is_shown) {
    return atomic_exchange(&line_is_shown, is_shown);
}
