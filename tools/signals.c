/* signals: what the program does when it is told to stop. */
#include "signals.h"

#include "message.h"

#include <signal.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The only changing globals of the program: a signal handler can reach nothing else. */
static atomic_int stop_asked, bus_error_met, line_is_shown, is_done;
static atomic_int status_now = PL_EXIT_FAILED; /* if somebody else ends the program */
static char temporary_paths[PL_N_TEMPORARIES][PL_TEMPORARY_SIZE];

static void remove_temporaries(void) {
    for (int i = 0; i < PL_N_TEMPORARIES; i++)
        for (const char *path = temporary_paths[i]; *path; path += strlen(path) + 1)
            unlink(path);
}

static void clear_line(void) {
    static const char text[] = "\r" PL_ERASE_TO_END;
    if (!atomic_exchange(&line_is_shown, 0))
        return;
    const ssize_t written = write(STDERR_FILENO, text, sizeof text - 1);
    (void)written;
}

static void on_end(int signal_number) {
    clear_line();
    remove_temporaries();
    /* The signal is blocked in here: raised again, it ends the program as this returns, and the
     * parent sees what it was ended by. */
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

static void on_stop(int signal_number) {
    if (atomic_exchange(&stop_asked, 1))
        on_end(signal_number);
}

static void on_bus_error(int signal_number) {
    static const char text[] =
        "planish: the input became shorter while it was read; run again when it is complete\n";
    (void)signal_number;
    while (
        atomic_exchange(&bus_error_met, 1)) /* another thread met it first and ends the program */
        pause();
    clear_line();
    remove_temporaries();
    const ssize_t written = write(STDERR_FILENO, text, sizeof text - 1);
    (void)written;
    _exit(atomic_load(&status_now));
}

static void handle(int signal_number, void (*handler)(int)) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = handler;
    action.sa_flags = SA_RESTART;
    sigemptyset(&action.sa_mask);
    sigaddset(&action.sa_mask, SIGINT);
    sigaddset(&action.sa_mask, SIGTERM);
    sigaction(signal_number, &action, NULL);
}

/** A signal that the parent had ignored (a job in the background, say) stays ignored. */
static void handle_unless_ignored(int signal_number, void (*handler)(int)) {
    struct sigaction present;
    if (sigaction(signal_number, NULL, &present) == 0 && present.sa_handler != SIG_IGN)
        handle(signal_number, handler);
}

static void handle_ends(void (*handler)(int)) {
    handle_unless_ignored(SIGINT, handler);
    handle_unless_ignored(SIGTERM, handler);
    handle_unless_ignored(SIGHUP, handler);
}

/* libgomp ends the process with a line of its own and status 1 where it has no memory or no thread,
 * HDF5 with 255. The first would say that there is a mesh. */
static void on_exit_by_others(void) {
    static const char text[] =
        "planish: ended by a library that it uses, probably for want of memory or threads\n";
    if (atomic_load(&is_done))
        return;
    clear_line();
    remove_temporaries();
    const ssize_t written = write(STDERR_FILENO, text, sizeof text - 1);
    (void)written;
    _exit(atomic_load(&status_now));
}

void pl_signals_install(void) {
    atexit(on_exit_by_others);
    handle(SIGPIPE, SIG_IGN);
    handle(SIGXFSZ, SIG_IGN); /* a limit on the size of files is an error like a full disk */
    handle(SIGBUS, on_bus_error);
    handle_ends(on_end);
}

void pl_signals_install_stop(void) {
    handle_ends(on_stop);
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
