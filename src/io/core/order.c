/* order: the order of things in a list; see the header. */
#include "io/core/order.h"

#include "base/memory.h"

#include <string.h>

int64_t io_order_find(const io_order *order, const void *key, const void *list,
                      io_order_compare *compare, int64_t *place) {
    int64_t low = 0, high = order->n;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        const int sign = compare(key, list, order->index[middle]);
        if (sign == 0) {
            *place = middle;
            return order->index[middle];
        }
        low = sign > 0 ? middle + 1 : low;
        high = sign > 0 ? high : middle;
    }
    *place = low;
    return -1;
}

int io_order_insert(io_order *order, int64_t place, int64_t index) {
    if (!pl_append(&order->index, &order->n, &order->capacity, &index, sizeof index))
        return 0;
    int64_t *at = order->index + place;
    memmove(at + 1, at, (size_t)(order->n - 1 - place) * sizeof *at);
    *at = index;
    return 1;
}

void io_order_release(io_order *order) {
    pl_free(order->index);
    *order = (io_order){.n = 0};
}
