/* hash: begin the hashes of a table; see the header. */
#include "base/hash.h"

#include "base/clock.h"
#include "base/system.h"

#include <string.h>

pl_hash pl_hash_draw(const void *table) {
    /* A file is made before it is read: it knows neither the moment nor the addresses. */
    const double now = pl_seconds();
    uint64_t moment;
    memcpy(&moment, &now, sizeof moment);
    pl_hash h = {{UINT64_C(0x736f6d6570736575), UINT64_C(0x646f72616e646f6d),
                  UINT64_C(0x6c7967656e657261), UINT64_C(0x7465646279746573)}};
    pl_hash_add(&h, moment);
    pl_hash_add(&h, (uint64_t)(uintptr_t)table);
    pl_hash_add(&h, (uint64_t)(uintptr_t)&h);
    pl_hash_add(&h, (uint64_t)pl_process_number());
    for (int i = 0; i < 3; i++)
        pl_hash_mix(&h);
    return h;
}
