/* groups: the command `planish groups`: the tags that options take. */
#include "commands/commands.h"

#include "terminal/message.h"
#include "terminal/text.h"

#include <planish/planish_io.h>

#include <inttypes.h>
#include <stdio.h>

static void put_group(const planish_group *group) {
    static const char *const names[] = {"nodes", "lines", "faces", "solids"};
    printf("%-7s %9" PRId64 "  ", group->dim >= 0 && group->dim <= 3 ? names[group->dim] : "any",
           group->n);
    pl_text_put(stdout, group->tag);
    putchar('\n');
}

static int list_groups(const char *path, planish_file *file) {
    const planish_group *group;
    planish_error error;
    int64_t n;
    if (planish_file_groups(file, &group, &n, &error))
        return pl_complain(PL_EXIT_FAILED, "%s", error.text);
    for (int64_t i = 0; i < n; i++)
        put_group(&group[i]);
    if (n == 0)
        pl_note(stderr, "%s: has no groups", path);
    return 0;
}

int pl_groups_command(const pl_arguments *arguments) {
    const planish_open_options how = {.format = arguments->format, .isolated = 1};
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open_with(arguments->input, &how, &file, &error))
        return pl_complain(PL_EXIT_FAILED, "%s", error.text);
    const int status = list_groups(arguments->input, file);
    planish_file_close(file);
    return pl_flush_stdout(status, PL_EXIT_FAILED);
}
