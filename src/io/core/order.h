/* order: the order of things in a list, by which one is found without a look at all others.
 *
 *   io_order_find      find a thing
 *   io_order_insert    add one that is not there yet
 */
#ifndef PL_IO_CORE_ORDER_H
#define PL_IO_CORE_ORDER_H

#include <stdint.h>

/** Indices of the things in ascending order. All 0 is an empty one. */
typedef struct io_order {
    int64_t *index; /* [n] owned */
    int64_t n, capacity;
} io_order;

/** Compare a key with the thing of that index in a list: negative, 0 or positive, as by strcmp. */
typedef int io_order_compare(const void *key, const void *list, int64_t index);

/** Find the thing of the list that is equal to key: its index, or -1. *place: where its index stands in
 *  the order, or belongs. */
int64_t io_order_find(const io_order *order, const void *key, const void *list,
                      io_order_compare *compare, int64_t *place);

/** Insert an index at the place that io_order_find told. Return whether there is memory for that. Each takes
 *  time in proportion to all behind it: for some 10 000 things. */
int io_order_insert(io_order *order, int64_t place, int64_t index);

/** Release the indices. */
void io_order_release(io_order *order);

#endif
