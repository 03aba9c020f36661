/* elements: the table of element types that each format fills in. */
#include "io/core/elements.h"

#include "io/core/text.h"

const io_element_type *io_element_find(const io_element_type *table, int n, const char *name,
                                       int64_t length) {
    for (int i = 0; i < n; i++)
        if (table[i].name && io_word_is(name, length, table[i].name, 0))
            return &table[i];
    return NULL;
}
