/* signals: the console's, which come in a thread of their own. */
#include "terminal/signals.h"

#include <stdatomic.h>
#include <windows.h>

static atomic_int first_asks; /* the first of them asks to stop */

/** FALSE: the program is ended. As the window closes, or the user leaves, it will be in any case.
 */
static BOOL WINAPI on_event(DWORD event) {
    const int is_key = event == CTRL_C_EVENT || event == CTRL_BREAK_EVENT;
    if (is_key && atomic_load(&first_asks) && !pl_signals_ask_stop())
        return TRUE;
    pl_signals_clean_up();
    pl_signals_say_ended();
    return FALSE;
}

void pl_signals_install_ends(void) {
    SetConsoleCtrlHandler(on_event, TRUE);
}

void pl_signals_install_stop(void) {
    pl_signals_set_before_smoothing(0);
    atomic_store(&first_asks, 1);
}
