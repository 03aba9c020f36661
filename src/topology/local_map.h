/* local_map: a small hash map that numbers the keys it meets, emptied at no cost.
 *
 * Neighbourhoods are small: a node has some 25 elements, 14 neighbours and 60 facets. A map of that
 * size stays in the first-level cache. A table over all nodes for each thread would not stay there,
 * and would take too much memory. Each thread has one and empties it for every node; entries of
 * another stamp than the map's count as empty.
 *
 *   pl_local_maps_create, _destroy, _failed     a map for each thread
 *   pl_local_map_empty, _add                    number keys
 *   pl_local_map_reserve, _destroy              the memory of one map
 */
#ifndef PL_TOPOLOGY_LOCAL_MAP_H
#define PL_TOPOLOGY_LOCAL_MAP_H

#include <stdint.h>

/** Key in a map. */
typedef struct pl_local_entry {
    uint64_t key;
    uint32_t stamp;
    int32_t position;
} pl_local_entry;

/** Map of one thread. */
typedef struct pl_local_map {
    pl_local_entry *entry; /* [capacity], a power of two */
    int64_t capacity;
    uint64_t mask;    /* of the entries in use since the map was emptied: a power of two less 1 */
    int shift;        /* 64 - log2(mask + 1) */
    uint32_t stamp;   /* of the entries that are in the map */
    int32_t count;    /* keys in the map */
    int failed;       /* not 0: memory ran out */
    char padding[24]; /* maps of different threads share no cache line */
} pl_local_map;

/** Make an empty map for each thread; NULL without memory. */
pl_local_map *pl_local_maps_create(int threads);

/** Free maps [threads]; NULL: do nothing. */
void pl_local_maps_destroy(pl_local_map *maps, int threads);

/** Release the entries of one map, which is {0} at first. */
void pl_local_map_destroy(pl_local_map *map);

/** Whether one of the maps has failed. */
int pl_local_maps_failed(const pl_local_map *maps, int threads);

/** Replace the entries by empty ones, more than needed; returns 0, or -1 without memory. */
int pl_local_map_reserve(pl_local_map *map, int64_t needed);

/** Entries in use at least: 8 kB, so sparse that a neighbourhood's keys hardly ever collide. */
enum { PL_LOCAL_MAP_SIZE = 512 };

/** Empty the map; up to max_keys keys may follow. Returns 0, or -1 without memory. */
static inline int pl_local_map_empty(pl_local_map *map, int64_t max_keys) {
    int64_t needed = max_keys + max_keys / 4 + 1; /* never full, so that every search ends */
    needed = needed < PL_LOCAL_MAP_SIZE ? PL_LOCAL_MAP_SIZE - 1 : needed;
    map->stamp++;
    map->count = 0;
    if ((needed >= map->capacity || map->stamp == 0) && pl_local_map_reserve(map, needed) != 0)
        return -1;
    map->shift = __builtin_clzll((uint64_t)needed);
    map->mask = UINT64_MAX >> map->shift;
    return 0;
}

/** Position of key: 0, 1, 2, ... in order of first appearance since the map was emptied; a key is
 *  new if its position is map->count as it was before the call. Whether it is new, nothing could
 *  predict: so no branch asks. Branches ask for collisions only. */
static inline int32_t pl_local_map_add(pl_local_map *map, uint64_t key) {
    uint64_t i = key * UINT64_C(0x9E3779B97F4A7C15) >> map->shift; /* Fibonacci hashing */
    pl_local_entry *entry = map->entry + i;
    uint32_t stale = entry->stamp ^ map->stamp;
    while ((stale == 0) > (entry->key == key)) {
        i = (i + 1) & map->mask;
        entry = map->entry + i;
        stale = entry->stamp ^ map->stamp;
    }
    int32_t is_new = stale != 0;
    int32_t position = (map->count & -is_new) | (entry->position & (is_new - 1));
    *entry = (pl_local_entry){key, map->stamp, position};
    map->count += is_new;
    return position;
}

#endif
