/* link: how the link of a star is stored.
 *
 * As positions: first the nodes of each facet, [n][dim] places in the star's ring; in 3-D then the
 * edges of each facet, [n][3], and the nodes of each edge, [3 n / 2][2]: every facet at a free node
 * belongs to two elements, so that every edge of its link belongs to two facets. The nodes of the
 * edges, its ends, follow from the rest: where links are only kept they are left out. Links of
 * corners, which have forms (corner.h), have no edges. Positions are
 * bytes, and where the mesh has a star that is too large for bytes there is an array of high bytes,
 * too.
 *
 *   pl_link_positions, _positions_kept, pl_link_edges     sizes
 *   pl_link_alloc, _free, _at, _get, _set                 positions
 */
#ifndef PL_GEOMETRY_LINK_H
#define PL_GEOMETRY_LINK_H

#include "base/memory.h"

#include <stdint.h>

enum {
    PL_MAX_LINK = 43690, /* facets of a link: their edges are numbered by two bytes */
    PL_BYTE_LINK = 170   /* and up to so many by one */
};

/** Positions of the whole link per facet. has_forms: the elements are corners, whose edges are not
 *  wanted. */
static inline int64_t pl_link_positions(int dim, int has_forms) {
    return dim == 3 && !has_forms ? 9 : dim;
}

/** Number of positions of a facet where a link is only kept, without the ends of edges. */
static inline int64_t pl_link_positions_kept(int dim, int has_forms) {
    return dim == 3 && !has_forms ? 6 : dim;
}

/** Edges of a link of n facets. */
static inline int64_t pl_link_edges(int dim, int64_t n) {
    return dim == 3 ? 3 * n / 2 : 0;
}

/** The low and the high bytes of the positions of one star or of all; high may be NULL. */
typedef struct pl_link {
    uint8_t *low, *high;
} pl_link;

/** Position i of a link. */
static inline uint16_t pl_link_get(const pl_link *link, int64_t i) {
    return (uint16_t)(link->low[i] | (link->high ? link->high[i] << 8 : 0));
}

/** Set position i of a link. */
static inline void pl_link_set(const pl_link *link, int64_t i, int32_t position) {
    link->low[i] = (uint8_t)position;
    if (link->high)
        link->high[i] = (uint8_t)(position >> 8);
}

/** Room for n facets with so many positions each, with high bytes if wide; 0, or -1 without memory.
 *  To be released in any case. */
static inline int pl_link_alloc(pl_link *link, int64_t positions, int64_t n, int wide) {
    link->low = pl_alloc(n, (size_t)positions);
    link->high = wide ? pl_alloc(n, (size_t)positions) : NULL;
    return link->low && (!wide || link->high) ? 0 : -1;
}

/** Free the arrays of a link. */
static inline void pl_link_free(pl_link *link) {
    pl_free(link->low);
    pl_free(link->high);
    *link = (pl_link){NULL, NULL};
}

/** The link whose first facet is that number of all, with so many positions each. */
static inline pl_link pl_link_at(const pl_link *link, int64_t positions, int64_t facet) {
    const int64_t first = facet * positions;
    return (pl_link){link->low + first, link->high ? link->high + first : link->high};
}

#endif
