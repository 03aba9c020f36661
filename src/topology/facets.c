/* facets: match the facets of the elements, each at its smallest node.
 *
 * A facet belongs to the smallest of its nodes, whose elements are all known: so a map of the size
 * of one neighbourhood finds its partners. An element with the sorted nodes s has its facets
 * opposite s[1] .. s[dim] at s[0], and the one opposite s[0] at s[1].
 */
#include "topology/facets.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/element_walk.h"
#include "topology/local_map.h"

enum {
    CHUNK = 256, /* nodes that one thread takes at a time */
    AT_ONCE = 32 /* elements */
};

/** A matching under way. */
typedef struct matching {
    const planish_mesh *mesh;
    const pl_incidence *incidence;
    const uint8_t *is_inside; /* [n] facets at such nodes are left out, or NULL */
    pl_facets_fn *body;
    void *context;
    pl_local_map *maps; /* [threads] facets of one node */
    struct list {
        pl_facet *facet; /* [capacity] by position in the map */
        int64_t capacity;
        char padding[48]; /* lists of different threads share no cache line */
    } * lists;            /* [threads] */
} matching;

/** Add the facet of element opposite s[k], of whose sorted nodes s parity is the order. */
static inline void add_facet(int dim, pl_local_map *map, pl_facet *facets, const int32_t *s, int k,
                             int32_t element, int parity) {
    const int32_t node0 = s[k <= 1 ? 2 : 1], node1 = dim == 3 ? s[k <= 2 ? 3 : 2] : -1;
    const uint8_t order = (uint8_t)((parity + k) % 2);
    int32_t known = map->count;
    int32_t at = pl_local_map_add(map, (uint64_t)(uint32_t)node0 << 32 | (uint32_t)node1);
    pl_facet *facet = facets + at;
    if (at == known) {
        *facet = (pl_facet){.node = {node0, node1},
                            .count = 1,
                            .element = {element, -1},
                            .opposite = s[k],
                            .parity = {order, 0}};
        return;
    }
    if (facet->count++ == 1) {
        facet->element[1] = element;
        facet->parity[1] = order;
    }
    facet->twin |= facet->opposite == s[k];
}

/** Whether an element has facets without inside nodes of which node is the smallest node: of its
 *  nodes that are outside one may be below node, if none is inside. No branch: nothing could
 *  predict it. */
static inline int has_facets(int dim, const uint8_t *is_inside, const int32_t *nodes,
                             int32_t node) {
    uint32_t below = 0, inside = 0;
    for (int j = 0; j <= dim; j++) {
        const uint32_t is = is_inside ? is_inside[nodes[j]] != 0 : 0;
        below += (uint32_t)(nodes[j] - node) >> 31 & (is ^ 1);
        inside += is;
    }
    return (int)((below + inside - 2) >> 31); /* less than 2 of both */
}

/** Add those facets of element, which has some, whose smallest node is node: that opposite the node
 *  that is inside, if there is one. */
static inline void add_element(int dim, pl_local_map *map, pl_facet *facets,
                               const uint8_t *is_inside, const int32_t *nodes, int32_t node,
                               int32_t element) {
    int32_t s[4];
    const int parity = pl_sort_element(dim, nodes, s);
    int inside = 0, place = 0;
    for (int k = 0; is_inside && k <= dim; k++) {
        const int is = is_inside[s[k]] != 0;
        inside += is;
        place += k * is;
    }
    if (inside > 0) {
        add_facet(dim, map, facets, s, place, element, parity);
    } else if (s[1] == node) {
        add_facet(dim, map, facets, s, 0, element, parity);
    } else {
        for (int k = 1; k <= dim; k++)
            add_facet(dim, map, facets, s, k, element, parity);
    }
}

/** Add those facets of the elements of node whose smallest node it is: first collect the elements
 *  that have any. */
static inline void add_elements(const matching *m, int dim, pl_local_map *map, pl_facet *facets,
                                int32_t node) {
    const pl_incidence *incidence = m->incidence;
    const int32_t *elements = m->mesh->elements;
    const int64_t end = incidence->offset[node + 1];
    for (int64_t from = incidence->offset[node]; from < end; from += AT_ONCE) {
        int32_t found[AT_ONCE];
        int n = 0;
        for (int64_t i = from; i < end && i < from + AT_ONCE; i++) {
            const int32_t element = incidence->element[i];
            found[n] = element;
            n += has_facets(dim, m->is_inside, elements + (int64_t)element * (dim + 1), node);
        }
        for (int i = 0; i < n; i++)
            add_element(dim, map, facets, m->is_inside, elements + (int64_t)found[i] * (dim + 1),
                        node, found[i]);
    }
}

static inline void match_nodes(matching *m, int dim, int64_t begin, int64_t end, int thread) {
    const pl_incidence *incidence = m->incidence;
    pl_local_map *map = m->maps + thread;
    struct list *list = m->lists + thread;
    for (int64_t node = begin; node < end; node++) {
        if (node + PL_AHEAD_ELEMENTS < end &&
            !(m->is_inside && m->is_inside[node + PL_AHEAD_ELEMENTS]))
            pl_fetch_elements(m->mesh, dim, incidence, node + PL_AHEAD_ELEMENTS);
        const int64_t most = (incidence->offset[node + 1] - incidence->offset[node]) * dim;
        if (most == 0 || (m->is_inside && m->is_inside[node]))
            continue;
        if (pl_local_map_empty(map, most) != 0)
            return;
        if (most > list->capacity) {
            pl_facet *facet = pl_grow(list->facet, 0, most, &list->capacity, sizeof *facet);
            map->failed |= !facet;
            if (!facet)
                return;
            list->facet = facet;
        }
        add_elements(m, dim, map, list->facet, (int32_t)node);
        if (map->count)
            m->body(m->context, (int32_t)node, list->facet, map->count, thread);
    }
}

static void match_chunk(void *context, int64_t begin, int64_t end, int thread) {
    matching *m = context;
    if (m->mesh->dim == 3)
        match_nodes(m, 3, begin, end, thread);
    else
        match_nodes(m, 2, begin, end, thread);
}

int pl_facets_match(const planish_mesh *mesh, const pl_incidence *incidence,
                    const uint8_t *is_inside, int threads, pl_facets_fn *body, void *context,
                    planish_error *error) {
    matching m = {.mesh = mesh,
                  .incidence = incidence,
                  .is_inside = is_inside,
                  .body = body,
                  .context = context,
                  .maps = pl_local_maps_create(threads),
                  .lists = pl_alloc_zero(threads, sizeof *m.lists)};
    int done = m.maps && m.lists;
    if (done) {
        pl_parallel_for(threads, mesh->n_nodes, CHUNK, match_chunk, &m);
        done = !pl_local_maps_failed(m.maps, threads);
    }
    for (int i = 0; m.lists && i < threads; i++)
        pl_free(m.lists[i].facet);
    pl_free(m.lists);
    pl_local_maps_destroy(m.maps, threads);
    return done ? PLANISH_OK : pl_fail_memory(error, "the facets of a node");
}
