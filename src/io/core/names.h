/* names: a list of texts for messages, each once, in the order in which they came. */
#ifndef PL_IO_CORE_NAMES_H
#define PL_IO_CORE_NAMES_H

#include <stdint.h>

enum { IO_MOST_NAMES = 1000 };

/** List of names. All 0 is an empty one. */
typedef struct io_names {
    char **name; /* [n] owned, NULL behind the last; or NULL: there is none */
    int64_t n, capacity;
} io_names;

/** Add the length bytes at begin, up to a '\0' among them, unless they or IO_MOST_NAMES names are there
 *  already. Return whether there is memory for that. */
int io_names_add(io_names *names, const char *begin, int64_t length);

/** Return the list, NULL at the end. */
const char *const *io_names_list(const io_names *names);

/** Release the names. */
void io_names_release(io_names *names);

#endif
