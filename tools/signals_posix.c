/* signals: those of POSIX. */
#include "signals.h"

#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

static atomic_int bus_error_met;

static void on_end(int signal_number) {
    pl_signals_clean_up();
    /* The signal is blocked in here: raised again, it ends the program as this returns, and the
     * parent sees what it was ended by. */
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

static void on_stop(int signal_number) {
    if (pl_signals_ask_stop())
        on_end(signal_number);
}

static void on_bus_error(int signal_number) {
    static const char text[] =
        "planish: the input became shorter while it was read; run again when it is complete\n";
    (void)signal_number;
    while (
        atomic_exchange(&bus_error_met, 1)) /* another thread met it first and ends the program */
        pause();
    pl_signals_end(text);
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

void pl_signals_install_ends(void) {
    handle(SIGPIPE, SIG_IGN);
    handle(SIGXFSZ, SIG_IGN); /* a limit on the size of files is an error like a full disk */
    handle(SIGBUS, on_bus_error);
    handle_ends(on_end);
}

void pl_signals_install_stop(void) {
    handle_ends(on_stop);
}
