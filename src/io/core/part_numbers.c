/* part_numbers: edges and quadrilaterals by their vertices, numbered as they first occur. */
#include "io/core/part_numbers.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { MOST_WIDTH = 4, FIRST_SLOTS = 1024, TOGETHER = 8 };

void io_sort_vertices(const int32_t *vertices, int n, int32_t *sorted) {
    for (int i = 0; i < n; i++) {
        int k = i;
        for (; k > 0 && sorted[k - 1] > vertices[i]; k--)
            sorted[k] = sorted[k - 1];
        sorted[k] = vertices[i];
    }
}

/** Return whether a slot is free or has the part. */
static int is_slot_of(const io_part_numbers *parts, int32_t slot, const int32_t *sorted) {
    if (slot < 0)
        return 1;
    const int32_t *there = parts->vertex + (int64_t)slot * parts->width;
    int is_same = 1;
    for (int i = 0; i < parts->width; i++)
        is_same &= there[i] == sorted[i];
    return is_same;
}

/** Find the slot of a part, or the free one where it belongs. Parts of a vertex stand together as far
 *  as there is room, so that most are in the cache; the others are all over the table. */
static int32_t *find_slot(const io_part_numbers *parts, const int32_t *sorted) {
    const uint64_t mask = (uint64_t)parts->n_slots - 1;
    int32_t *together = parts->slot + ((uint64_t)(uint32_t)sorted[0] * TOGETHER & mask);
    for (uint32_t i = 0; i < TOGETHER; i++) {
        int32_t *slot = together + (((uint32_t)sorted[1] + i) & (TOGETHER - 1));
        if (is_slot_of(parts, *slot, sorted))
            return slot;
    }
    pl_hash hash = parts->hash;
    pl_hash_add_integers(&hash, sorted, parts->width);
    for (uint64_t at = pl_hash_end(hash) & mask;; at = (at + 1) & mask)
        if (is_slot_of(parts, parts->slot[at], sorted))
            return &parts->slot[at];
}

/** Keep the hash table at most half full. */
static int grow_slots(io_part_numbers *parts, planish_error *error) {
    if (2 * parts->n < parts->n_slots)
        return PLANISH_OK;
    const int64_t n_slots = parts->n_slots ? 4 * parts->n_slots : FIRST_SLOTS;
    int32_t *slot = pl_alloc(n_slots, sizeof *slot);
    if (!slot)
        return pl_fail_memory(error, "the edges of elements");
    memset(slot, -1, (size_t)n_slots * sizeof *slot);
    pl_free(parts->slot);
    parts->slot = slot;
    parts->hash = pl_hash_draw(slot);
    parts->n_slots = n_slots;
    for (int64_t i = 0; i < parts->n; i++)
        *find_slot(parts, parts->vertex + i * parts->width) = (int32_t)i;
    return PLANISH_OK;
}

int64_t io_part_numbers_find(const io_part_numbers *parts, const int32_t *vertices) {
    int32_t sorted[MOST_WIDTH] = {0};
    io_sort_vertices(vertices, parts->width, sorted);
    return parts->n_slots > 0 ? *find_slot(parts, sorted) : -1;
}

int io_part_numbers_add(io_part_numbers *parts, const int32_t *vertices, int32_t *number,
                        planish_error *error) {
    int32_t sorted[MOST_WIDTH] = {0};
    io_sort_vertices(vertices, parts->width, sorted);
    const int status = grow_slots(parts, error);
    if (status)
        return status;
    int32_t *slot = find_slot(parts, sorted);
    if (*slot < 0) {
        const size_t size = (size_t)parts->width * sizeof *sorted;
        if (parts->n == INT32_MAX ||
            !pl_append(&parts->vertex, &parts->n, &parts->capacity, sorted, size))
            return pl_fail_memory(error, "the edges of elements");
        *slot = (int32_t)(parts->n - 1);
    }
    *number = *slot;
    return PLANISH_OK;
}

void io_part_numbers_release(io_part_numbers *parts) {
    pl_free(parts->vertex);
    pl_free(parts->slot);
    *parts = (io_part_numbers){.width = parts->width};
}
