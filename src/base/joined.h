/* joined: classes of indices that are joined one after the other (union-find). The smallest index names a
 * class.
 */
#ifndef PL_BASE_JOINED_H
#define PL_BASE_JOINED_H

#include <stdint.h>

/** Return the lowest member of i's class; parent [n] is that of each index, or itself. Paths become
 *  shorter. */
static inline int32_t pl_class_of(int32_t *parent, int32_t i) {
    while (parent[i] != i)
        i = parent[i] = parent[parent[i]];
    return i;
}

/** Join the classes of i and j. Return the lowest member of both. */
static inline int32_t pl_join(int32_t *parent, int32_t i, int32_t j) {
    const int32_t a = pl_class_of(parent, i), b = pl_class_of(parent, j);
    const int32_t low = a < b ? a : b;
    parent[a] = parent[b] = low;
    return low;
}

#endif
