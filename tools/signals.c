/* signals: what the program does when it is told to stop; how it is told is in signals_posix.c and
 * signals_windows.c. */
#include "signals.h"

#include "base/system.h"

#include <stdatomic.h>
#include <stddef.h>
#include <string.h>
#include <unistd.h>

/* The only changing globals of the program: a signal handler can reach nothing else. */
static atomic_int stop_asked, line_is_shown;
static char temporary_paths[PL_N_TEMPORARIES][PL_TEMPORARY_SIZE];

static void clear_line(void) {
    static const char text[] = "\r" PL_ERASE_TO_END;
    if (!atomic_exchange(&line_is_shown, 0))
        return;
    const ssize_t written = write(STDERR_FILENO, text, sizeof text - 1);
    (void)written;
}

void pl_signals_clean_up(void) {
    clear_line();
    for (int i = 0; i < PL_N_TEMPORARIES; i++)
        for (const char *path = temporary_paths[i]; *path; path += strlen(path) + 1)
            pl_file_remove(path);
}

int pl_signals_ask_stop(void) {
    return atomic_exchange(&stop_asked, 1);
}

int pl_signals_stop_asked(void) {
    return atomic_load(&stop_asked);
}

char *pl_signals_temporary(pl_temporary which) {
    return temporary_paths[which];
}

int pl_signals_set_line(int is_shown) {
    return atomic_exchange(&line_is_shown, is_shown);
}
