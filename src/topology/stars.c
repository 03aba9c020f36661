/* stars: the rings and links of the free nodes in the order of their visits.
 *
 * Stars are stored in that order but made in the order of the rings: along the curve, at one place
 * for each colour at a time.
 */
#include "topology/topology.h"

#include "topology/cell_star.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

enum { CHUNK = 256 }; /* rings that one thread takes at a time */

/** The copying of all stars. */
typedef struct star_copy {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const uint8_t *corner; /* [m] or NULL */
    pl_cell_kind kinds[PL_CELL_KINDS];
    pl_rings *rings;
    const int32_t *node, *star_of, *number_of;
    pl_stars *stars;
} star_copy;

/** Write lengths into the offsets. */
static void measure_stars(void *context, int64_t begin, int64_t end, int thread) {
    star_copy *copy = context;
    pl_stars *stars = copy->stars;
    int64_t max_ring = 0, max_link = 0;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        const int32_t s = copy->star_of[r];
        if (s < 0)
            continue;
        const int64_t ring = copy->rings->offset[r + 1] - copy->rings->offset[r];
        const int64_t link = copy->rings->link_offset[r + 1] - copy->rings->link_offset[r];
        stars->ring_offset[s] = ring;
        stars->link_offset[s] = link;
        max_ring = ring > max_ring ? ring : max_ring;
        max_link = link > max_link ? link : max_link;
    }
    pl_raise_to(&stars->max_ring, max_ring);
    pl_raise_to(&stars->max_link, max_link);
}

static void copy_rings(void *context, int64_t begin, int64_t end, int thread) {
    const star_copy *copy = context;
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        if (copy->star_of[r] < 0)
            continue;
        const int32_t *neighbour = copy->rings->neighbour + copy->rings->offset[r];
        const int64_t n_ring = copy->rings->offset[r + 1] - copy->rings->offset[r];
        int32_t *ring = copy->stars->ring + copy->stars->ring_offset[copy->star_of[r]];
        for (int64_t i = 0; i < n_ring; i++)
            ring[i] = copy->number_of[neighbour[i]];
    }
}

/** Find the ends of the edges of the n facets of source, for link, which has the rest; an open link
 *  has more edges than there is room for, and does not need them. (Read from link, what has just
 *  been written would be waited for.) */
static inline void write_ends(pl_link source, pl_link link, int64_t n) {
    const int64_t n_edges = pl_link_edges(3, n);
    for (int64_t f = 0; f < 3 * n; f += 3) {
        const int32_t p[3] = {pl_link_get(&source, f), pl_link_get(&source, f + 1),
                              pl_link_get(&source, f + 2)};
        for (int c = 0; c < 3; c++) {
            const int64_t edge = pl_link_get(&source, 3 * n + f + c);
            if (edge >= n_edges)
                continue;
            pl_link_set(&link, 6 * n + 2 * edge, p[c]);
            pl_link_set(&link, 6 * n + 2 * edge + 1, p[(c + 1) % 3]);
        }
    }
}

/** Copy the minimum volumes of the elements of a node, in the order of its link facets. */
static void copy_min_volumes(const star_copy *copy, int32_t node, double *min_volume) {
    const pl_incidence *incidence = copy->incidence;
    for (int64_t i = incidence->offset[node]; i < incidence->offset[node + 1]; i++) {
        const int32_t element = incidence->element[i];
        const int n = copy->corner ? pl_cell_facets(copy->kinds, copy->corner, copy->mesh->elements,
                                                    copy->mesh->dim, element, node)
                                   : 1;
        for (int k = 0; k < n; k++)
            *min_volume++ = copy->mesh->min_volume[element];
    }
}

/** Number the elements of a node's link facets, in their order. */
static void copy_elements(const star_copy *copy, int32_t node, int32_t *element) {
    const pl_incidence *incidence = copy->incidence;
    for (int64_t i = incidence->offset[node]; i < incidence->offset[node + 1]; i++)
        element += pl_cell_facet_elements(copy->kinds, copy->corner, copy->mesh->elements,
                                          copy->mesh->dim, incidence->element[i], node, element);
}

static void copy_links(void *context, int64_t begin, int64_t end, int thread) {
    const star_copy *copy = context;
    const pl_link *kept = &copy->rings->link;
    const int dim = copy->mesh->dim;
    const int64_t n_kept = pl_link_positions_kept(dim, copy->rings->form != NULL);
    (void)thread;
    for (int64_t r = begin; r < end; r++) {
        if (copy->star_of[r] < 0)
            continue;
        const int64_t from = copy->rings->link_offset[r],
                      n = copy->rings->link_offset[r + 1] - from;
        const int64_t to = copy->stars->link_offset[copy->star_of[r]];
        const pl_link source = pl_link_at(kept, n_kept, from);
        const pl_link target =
            pl_link_at(&copy->stars->link, pl_link_positions(dim, copy->stars->form != NULL), to);
        memcpy(target.low, source.low, (size_t)(n * n_kept));
        if (target.high) /* then source.high, too */
            memcpy(target.high, source.high, (size_t)(n * n_kept));
        if (copy->stars->form)
            memcpy(copy->stars->form + to, copy->rings->form + from, (size_t)n);
        else if (dim == 3 && target.high)
            write_ends(source, target, n);
        else if (dim == 3)
            write_ends((pl_link){source.low, NULL}, (pl_link){target.low, NULL}, n);
        if (copy->stars->min_volume)
            copy_min_volumes(copy, copy->node[r], copy->stars->min_volume + to);
        if (copy->stars->element)
            copy_elements(copy, copy->node[r], copy->stars->element + to);
    }
}

int pl_stars_create(const planish_mesh *mesh, const pl_incidence *incidence, const uint8_t *corner,
                    pl_rings *rings, const int32_t *node, const int32_t *star_of,
                    const int32_t *number_of, int threads, pl_stars *stars, planish_error *error) {
    const int64_t n = rings->n_free, n_rings = rings->n_rings;
    int64_t n_link = 0;
    *stars = (pl_stars){.n_stars = n};
    star_copy copy = {.mesh = mesh,
                      .incidence = incidence,
                      .corner = corner,
                      .rings = rings,
                      .node = node,
                      .star_of = star_of,
                      .number_of = number_of,
                      .stars = stars};
    if (corner)
        pl_cell_kinds_make(mesh->dim, copy.kinds);
    stars->ring_offset = pl_alloc(n + 1, sizeof *stars->ring_offset);
    stars->link_offset = pl_alloc(n + 1, sizeof *stars->link_offset);
    int done = stars->ring_offset && stars->link_offset;
    if (done) {
        pl_parallel_for(threads, n_rings, CHUNK, measure_stars, &copy);
        n_link = pl_prefix_sum(threads, n, stars->link_offset);
        stars->ring = pl_alloc(pl_prefix_sum(threads, n, stars->ring_offset), sizeof *stars->ring);
        done = stars->ring != NULL;
    }
    if (done) {
        pl_parallel_for(threads, n_rings, CHUNK, copy_rings, &copy);
        pl_free(rings->neighbour); /* before there is room for links: a tenth less memory */
        rings->neighbour = NULL;
        if (mesh->min_volume)
            stars->min_volume = pl_alloc(n_link, sizeof *stars->min_volume);
        stars->form = rings->form ? pl_alloc(n_link, sizeof *stars->form) : NULL;
        if (corner && pl_has_targets(mesh))
            stars->element = pl_alloc(n_link, sizeof *stars->element);
        done = pl_link_alloc(&stars->link, pl_link_positions(mesh->dim, rings->form != NULL),
                             n_link, rings->link.high != NULL) == 0 &&
               (!mesh->min_volume || stars->min_volume) && (!rings->form || stars->form) &&
               (!corner || !pl_has_targets(mesh) || stars->element);
    }
    if (done)
        pl_parallel_for(threads, n_rings, CHUNK, copy_links, &copy);
    pl_rings_destroy(rings);
    if (done)
        return PLANISH_OK;
    pl_stars_destroy(stars);
    return pl_fail_memory(error, "the stars of the nodes");
}

void pl_stars_destroy(pl_stars *stars) {
    pl_free(stars->ring_offset);
    pl_free(stars->ring);
    pl_free(stars->link_offset);
    pl_link_free(&stars->link);
    pl_free(stars->min_volume);
    pl_free(stars->form);
    pl_free(stars->element);
    *stars = (pl_stars){0};
}
