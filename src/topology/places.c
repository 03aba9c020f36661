/* places: find the points that lie at exactly the place of another one.
 *
 * In go points, out comes a mark for each. Parts of a mesh that were written side by side have the
 * nodes between them twice, a crack has its nodes twice, and some programs give each element its
 * own points.
 */
#include "topology/points.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/** A number for the bits of a place; -0 and 0 are the same. */
static uint64_t place_hash(const pl_points *p, int64_t i) {
    uint64_t hash = 0;
    for (int d = 0; d < p->dim; d++) {
        const double coordinate = p->x[pl_point_at(p, i, d)] + 0.0;
        uint64_t bits;
        memcpy(&bits, &coordinate, sizeof bits);
        hash = (hash ^ bits) * UINT64_C(0x9E3779B97F4A7C15);
        hash ^= hash >> 32;
    }
    return hash;
}

static int same_place(const pl_points *p, int64_t a, int64_t b) {
    for (int d = 0; d < p->dim; d++)
        if (p->x[pl_point_at(p, a, d)] != p->x[pl_point_at(p, b, d)])
            return 0;
    return 1;
}

int pl_points_find_doubled(const pl_points *points, uint8_t *is_doubled, planish_error *error) {
    int64_t n_slots = 16;
    while (n_slots < 2 * points->n)
        n_slots *= 2;
    int32_t *slot = pl_alloc(n_slots, sizeof *slot);
    if (!slot)
        return pl_fail_memory(error, "the places of nodes");
    memset(slot, -1, (size_t)n_slots * sizeof *slot);
    memset(is_doubled, 0, (size_t)points->n);
    for (int32_t i = 0; i < points->n; i++) {
        int64_t at = (int64_t)(place_hash(points, i) & (uint64_t)(n_slots - 1));
        while (slot[at] >= 0 && !same_place(points, slot[at], i))
            at = (at + 1) & (n_slots - 1);
        if (slot[at] >= 0)
            is_doubled[slot[at]] = is_doubled[i] = 1;
        else
            slot[at] = i;
    }
    pl_free(slot);
    return PLANISH_OK;
}
