/* signals: those of POSIX. */
#include "terminal/signals.h"

#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

static atomic_int bus_error_met;

static pthread_t main_thread; /* makes and renames the files */

/** Whether the signal is for the main thread to answer: what it is just making would not be removed
 *  by another one. */
static int is_passed_on(int signal_number) {
    return !pthread_equal(pthread_self(), main_thread) &&
           pthread_kill(main_thread, signal_number) == 0;
}

static void on_end(int signal_number) {
    if (is_passed_on(signal_number))
        return;
    pl_signals_clean_up();
    pl_signals_say_ended();
    /* The signal is blocked in here: raised again, it ends the program as this returns, and the
     * parent sees what it was ended by. */
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

/** A crash is the thread's own: it would meet it again. */
static void on_crash(int signal_number) {
    pl_signals_clean_up();
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

static void on_stop(int signal_number) {
    if (pl_signals_ask_stop())
        on_end(signal_number);
}

static void on_bus_error(int signal_number) {
    (void)signal_number;
    while (
        atomic_exchange(&bus_error_met, 1)) /* another thread met it first and ends the program */
        pause();
    pl_signals_end_shorter();
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

/** Leave alone what somebody else handles: a sanitizer that reports crashes. */
static void handle_if_default(int signal_number, void (*handler)(int)) {
    struct sigaction present;
    if (sigaction(signal_number, NULL, &present) == 0 && !(present.sa_flags & SA_SIGINFO) &&
        present.sa_handler == SIG_DFL)
        handle(signal_number, handler);
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
    static const int ends[] = {SIGQUIT, SIGXCPU, SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2};
    static const int crashes[] = {SIGSEGV, SIGABRT, SIGFPE, SIGILL, SIGSYS, SIGTRAP};
    handle(SIGPIPE, SIG_IGN);
    handle(SIGXFSZ, SIG_IGN); /* a limit on the size of files is an error like a full disk */
    main_thread = pthread_self();
    handle(SIGBUS, on_bus_error);
    handle_ends(on_end);
    /* Whatever else ends the program, no temporary file stays. */
    for (size_t i = 0; i < sizeof ends / sizeof *ends; i++)
        handle_if_default(ends[i], on_end);
    for (size_t i = 0; i < sizeof crashes / sizeof *crashes; i++)
        handle_if_default(crashes[i], on_crash);
}

void pl_signals_install_stop(void) {
    pl_signals_set_before_smoothing(0);
    handle_ends(on_stop);
}
