/* groups: the command `planish groups`: the tags that options take. */
#include "commands/commands.h"

#include "terminal/message.h"
#include "terminal/text.h"

#include <planish/planish_io.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/** Order groups by dimension and tag; of the same ones the first in the list comes first. */
static int compare_groups(const void *a, const void *b) {
    const planish_group *p = *(const planish_group *const *)a;
    const planish_group *q = *(const planish_group *const *)b;
    const int order =
        p->dim != q->dim ? (p->dim > q->dim) - (p->dim < q->dim) : strcmp(p->tag, q->tag);
    return order ? order : (p > q) - (p < q);
}

/** Mark the groups [n] that have the tag of an earlier one, and elements of the same dimension: is_repeated
 *  [n]. Returns whether there is memory for that. */
static int mark_repeated(const planish_group *group, int64_t n, char *is_repeated) {
    const planish_group **sorted = malloc(((size_t)n + 1) * sizeof *sorted);
    for (int64_t i = 0; i < n && sorted; i++)
        sorted[i] = &group[i];
    if (sorted)
        qsort(sorted, (size_t)n, sizeof *sorted, compare_groups);
    for (int64_t i = 1; i < n && sorted; i++)
        is_repeated[sorted[i] - group] =
            sorted[i]->dim == sorted[i - 1]->dim && strcmp(sorted[i]->tag, sorted[i - 1]->tag) == 0;
    free(sorted);
    return sorted != NULL;
}

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
    char *is_repeated = calloc((size_t)n + 1, 1);
    const int has_memory = is_repeated && mark_repeated(group, n, is_repeated);
    for (int64_t i = 0; i < n && has_memory; i++)
        if (!is_repeated[i])
            put_group(&group[i]);
    free(is_repeated);
    if (!has_memory)
        return pl_complain(PL_EXIT_FAILED, "%s: out of memory for the list of groups", path);
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
