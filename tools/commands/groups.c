/* groups: the command `planish groups`: the tags that options take. */
#include "commands/commands.h"

#include "terminal/message.h"
#include "terminal/text.h"

#include <planish/planish_io.h>

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/** Whether an earlier group of the list has the tag of group i, and elements of the same dimension. */
static int is_repeated(const planish_group *group, int64_t i) {
    for (int64_t j = 0; j < i; j++)
        if (group[j].dim == group[i].dim && strcmp(group[j].tag, group[i].tag) == 0)
            return 1;
    return 0;
}

static int list_groups(planish_file *file) {
    static const char *const names[] = {"nodes", "lines", "faces", "solids"};
    const planish_group *group;
    planish_error error;
    int64_t n;
    if (planish_file_groups(file, &group, &n, &error))
        return pl_complain(PL_EXIT_FAILED, "%s", error.text);
    for (int64_t i = 0; i < n; i++) {
        if (is_repeated(group, i))
            continue;
        printf("%-7s ", group[i].dim >= 0 && group[i].dim <= 3 ? names[group[i].dim] : "any");
        pl_text_put(stdout, group[i].tag);
        putchar('\n');
    }
    return 0;
}

int pl_groups_command(const pl_arguments *arguments) {
    const planish_open_options how = {.format = arguments->format, .isolated = 1};
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open_with(arguments->input, &how, &file, &error))
        return pl_complain(PL_EXIT_FAILED, "%s", error.text);
    const int status = list_groups(file);
    planish_file_close(file);
    return pl_flush_stdout(status, PL_EXIT_FAILED);
}
