/* report: the command `planish report`: a page for people. */
#include "commands.h"

#include "message.h"

int pl_report_command(const pl_arguments *arguments) {
    return pl_complain(PL_EXIT_FAILED, "%s: the page is not built yet", arguments->input);
}
