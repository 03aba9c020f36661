/* local_map: a small hash map that numbers the keys it meets; see the header. */
#include "topology/local_map.h"

#include "base/memory.h"

_Static_assert(sizeof(pl_local_map) == 64, "a map is a cache line");

pl_local_map *pl_local_maps_create(int threads) {
    return pl_alloc_zero(threads, sizeof(pl_local_map));
}

void pl_local_map_destroy(pl_local_map *map) {
    pl_free(map->entry);
    *map = (pl_local_map){0};
}

void pl_local_maps_destroy(pl_local_map *maps, int threads) {
    for (int i = 0; maps && i < threads; i++)
        pl_local_map_destroy(maps + i);
    pl_free(maps);
}

int pl_local_maps_failed(const pl_local_map *maps, int threads) {
    int failed = 0;
    for (int i = 0; i < threads; i++)
        failed |= maps[i].failed;
    return failed;
}

int pl_local_map_reserve(pl_local_map *map, int64_t needed) {
    int64_t capacity = PL_LOCAL_MAP_SIZE;
    while (capacity <= needed)
        capacity *= 2;
    pl_free(map->entry);
    /* positions are 32-bit numbers */
    map->entry = needed > INT32_MAX ? NULL : pl_alloc_zero(capacity, sizeof *map->entry);
    map->capacity = map->entry ? capacity : 0;
    map->failed |= !map->entry;
    map->stamp = 1; /* no entry has it yet */
    return map->entry ? 0 : -1;
}
