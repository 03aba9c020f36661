/* fetch: ask for memory before it is needed.
 *
 * Elements are taken in the file's order, their nodes lie anywhere: on a mesh that outgrows the
 * second-level cache each would be waited for.
 *
 *   pl_fetch_to_write, pl_fetch_all_to_write     memory that will be written
 *   pl_fetch, pl_fetch_all                       bytes that will be read
 *   pl_fetch_node, pl_fetch_nodes                coordinates that will be read
 */
#ifndef PL_GEOMETRY_FETCH_H
#define PL_GEOMETRY_FETCH_H

#include <stdint.h>

/* Inlined at once: compilers take functions that only fetch for ones without effect. */
#define PL_AT_ONCE static inline __attribute__((always_inline))

/** Ask for memory that this core alone will write. Otherwise a write waits until other cores
 *  have given up their copies, and all writes after it wait, too. */
PL_AT_ONCE void pl_fetch_to_write(const void *place) {
    __builtin_prefetch(place, 1);
}

/** Fetch all lines from begin to before end, as pl_fetch_to_write does. */
PL_AT_ONCE void pl_fetch_all_to_write(const void *begin, const void *end) {
    enum { CACHE_LINE = 64 };
    for (const char *line = begin; line < (const char *)end; line += CACHE_LINE)
        pl_fetch_to_write(line);
}

/** Ask for all lines from begin to before end. */
PL_AT_ONCE void pl_fetch_all(const void *begin, const void *end) {
    enum { CACHE_LINE = 64 };
    for (const char *line = begin; line < (const char *)end; line += CACHE_LINE)
        __builtin_prefetch(line);
}

/** Ask for the line of a place that will be read. */
PL_AT_ONCE void pl_fetch(const void *place) {
    __builtin_prefetch(place);
}

/** Ask for the coordinates [.][dim] of a node. Both ends: one in four lies in two lines of the
 * cache. */
PL_AT_ONCE void pl_fetch_node(int dim, const double *coordinates, int32_t node) {
    const double *first = coordinates + (int64_t)node * dim;
    __builtin_prefetch(first);
    __builtin_prefetch(first + dim - 1);
}

/** Ask for the coordinates of the nodes of element. */
PL_AT_ONCE void pl_fetch_nodes(int dim, const int32_t *elements, const double *coordinates,
                               int64_t element) {
    const int32_t *node = elements + element * (dim + 1);
    for (int j = 0; j <= dim; j++)
        pl_fetch_node(dim, coordinates, node[j]);
}

#endif
