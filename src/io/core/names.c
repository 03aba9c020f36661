/* names: a list of texts for messages, each once, in the order in which they came. */
#include "io/core/names.h"

#include "base/memory.h"

#include <string.h>

int io_names_add(io_names *names, const char *begin, int64_t length) {
    const char *zero = length > 0 ? memchr(begin, '\0', (size_t)length) : NULL;
    length = zero ? zero - begin : length;
    for (int64_t i = 0; i < names->n; i++)
        if (strncmp(names->name[i], begin, (size_t)length) == 0 && !names->name[i][length])
            return 1;
    if (names->n == IO_MOST_NAMES) /* the search is linear */
        return 1;
    char *copy = pl_alloc(length + 1, 1);
    char **grown = pl_grow(names->name, names->n, names->n + 2, &names->capacity, sizeof *grown);
    names->name = grown ? grown : names->name;
    if (!copy || !grown) {
        pl_free(copy);
        return 0;
    }
    memcpy(copy, begin, (size_t)length);
    copy[length] = '\0';
    names->name[names->n++] = copy;
    names->name[names->n] = NULL;
    return 1;
}

const char *const *io_names_list(const io_names *names) {
    static const char *const none[] = {NULL};
    return names->name && names->n > 0 ? (const char *const *)names->name : none;
}

void io_names_release(io_names *names) {
    for (int64_t i = 0; i < names->n; i++)
        pl_free(names->name[i]);
    pl_free(names->name);
    *names = (io_names){.n = 0};
}
