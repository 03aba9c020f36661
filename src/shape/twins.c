/* twins: nodes of the surface that lie at the same place.
 *
 * Parts of a mesh that were written side by side (the pieces of a parallel program, bodies that are
 * tied) have the nodes between them twice, and so does a crack. Each would slide for its own star,
 * and what was one would gape. So they stay.
 */
#include "shape/shape.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/** A number for the bits of a place; -0 and 0 are the same. */
static uint64_t place_hash(const double *x, int dim) {
    uint64_t hash = 0;
    for (int d = 0; d < dim; d++) {
        const double coordinate = x[d] + 0.0;
        uint64_t bits;
        memcpy(&bits, &coordinate, sizeof bits);
        hash = (hash ^ bits) * UINT64_C(0x9E3779B97F4A7C15);
        hash ^= hash >> 32;
    }
    return hash;
}

static int same_place(const pl_surface *s, int32_t a, int32_t b) {
    for (int d = 0; d < s->dim; d++)
        if (s->x[(int64_t)a * s->dim + d] != s->x[(int64_t)b * s->dim + d])
            return 0;
    return 1;
}

int pl_hold_twins(const pl_surface *surface, uint8_t *is_fixed, planish_error *error) {
    int64_t n_slots = 16;
    while (n_slots < 2 * surface->n_nodes)
        n_slots *= 2;
    int32_t *slot = pl_alloc(n_slots, sizeof *slot);
    if (!slot)
        return pl_fail_memory(error, "the surface");
    memset(slot, -1, (size_t)n_slots * sizeof *slot);
    for (int32_t node = 0; node < surface->n_nodes; node++) {
        const double *x = surface->x + (int64_t)node * surface->dim;
        int64_t at = (int64_t)(place_hash(x, surface->dim) & (uint64_t)(n_slots - 1));
        while (slot[at] >= 0 && !same_place(surface, slot[at], node))
            at = (at + 1) & (n_slots - 1);
        if (slot[at] >= 0)
            is_fixed[surface->node[slot[at]]] = is_fixed[surface->node[node]] = 1;
        else
            slot[at] = node;
    }
    pl_free(slot);
    return PLANISH_OK;
}
