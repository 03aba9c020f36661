/* layers: planish_find_layers, which elements are thin in layers.
 *
 * In goes a mesh, out comes a mark for each element. An element that is thin has a shortest edge
 * across its layer; in a layer those of the elements around it are parallel to it and about as
 * long, on each other and side by side, elsewhere they are not. Nothing is asked of the boundary,
 * so that layers may be anywhere, and in one or many.
 */
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/frame.h"
#include "topology/topology.h"

#include <string.h>

/* An element is thin if its longest edge is at least so many times its shortest: beyond what
 * unstructured meshes of any quality have often, below what layers are made for. */
#define THIN 4.0
/* Shortest edges go along with each other if they are within such a factor of each other, as those
 * of layers that grow, */
#define ALIKE 2.5
/* and have at least this cosine, of 25 degrees: walls are curved, and have corners. */
#define PARALLEL 0.906
/* The part of the elements around an edge whose shortest edge has to go along with it. Around the
 * edges of a single layer two fifths do, with as many elements on the other side. */
#define COMPANY 0.25

enum {
    CHUNK = 8192,  /* elements or nodes that one thread looks at at a time */
    NOT_THIN = 255 /* in place of a shortest edge */
};

/* Of a node with more elements no more than about so many are looked at: each thin one asks. */
enum { MOST_LOOKED_AT = 256 };

/** Edges of an element by their corners; those of a triangle come first. */
static const uint8_t corners_of[6][2] = {{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3}};

typedef struct search {
    const planish_mesh *mesh; /* dense */
    pl_frame frame;
    uint8_t *shortest; /* [n_elements] number of the shortest edge of thin elements, or NOT_THIN */
    uint8_t *unasked;  /* [n_nodes] 0 for the ends of these edges, else 1 */
    pl_incidence incidence;  /* of the ends */
    uint8_t *is_layer;       /* [n_elements] the caller's */
    int64_t n_thin, n_layer; /* so far; shared */
} search;

/** The nodes of an edge, the one of the lower number first. */
typedef struct ends {
    int32_t node[2];
} ends;

/** From the first of its nodes to the other. */
typedef struct edge {
    ends at;
    double way[3], square; /* in units of the frame */
} edge;

static inline ends ends_of(const search *s, int64_t element, int number, const int dim) {
    const int32_t *node = s->mesh->elements + element * (dim + 1);
    const int32_t a = node[corners_of[number][0]], b = node[corners_of[number][1]];
    return (ends){{a < b ? a : b, a < b ? b : a}};
}

static inline edge edge_between(const search *s, ends at, const int dim) {
    edge e = {.at = at};
    for (int d = 0; d < dim; d++) {
        const double *x = s->mesh->coordinates + d;
        e.way[d] = pl_frame_difference(&s->frame, x[(int64_t)at.node[1] * dim],
                                       x[(int64_t)at.node[0] * dim]);
        e.square += e.way[d] * e.way[d];
    }
    return e;
}

/* ---- thin elements -------------------------------------------------------------------------- */

/** Number of the shortest edge of an element, or NOT_THIN. */
static inline uint8_t thin_edge(const search *s, int64_t element, const int dim) {
    double least = 0, most = 0;
    int shortest = 0;
    for (int k = 0; k < dim * (dim + 1) / 2; k++) {
        const double square = edge_between(s, ends_of(s, element, k, dim), dim).square;
        shortest = k == 0 || square < least ? k : shortest;
        least = k == 0 || square < least ? square : least;
        most = square > most ? square : most;
    }
    return least > 0 && most >= THIN * THIN * least ? (uint8_t)shortest : NOT_THIN;
}

static inline void find_thin(search *s, int64_t begin, int64_t end, const int dim) {
    int64_t n = 0;
    for (int64_t i = begin; i < end; i++) {
        s->shortest[i] = thin_edge(s, i, dim);
        n += s->shortest[i] != NOT_THIN;
    }
    __atomic_fetch_add(&s->n_thin, n, __ATOMIC_RELAXED);
}

static void find_thin_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    (void)thread;
    if (s->mesh->dim == 3)
        find_thin(s, begin, end, 3);
    else
        find_thin(s, begin, end, 2);
}

static void ask_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const search *s = context;
    const int corners = s->mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        for (int j = 0; s->shortest[i] != NOT_THIN && j < 2; j++) {
            const int32_t *node = s->mesh->elements + i * corners;
            __atomic_store_n(&s->unasked[node[corners_of[s->shortest[i]][j]]], 0, __ATOMIC_RELAXED);
        }
}

/* ---- layers --------------------------------------------------------------------------------- */

/** The elements around an edge, but for those whose shortest it is. */
typedef struct company {
    int64_t n, n_along; /* those that were looked at, whose shortest edge goes along */
} company;

static inline int go_along(const edge *a, const edge *b, const int dim) {
    double product = 0;
    for (int d = 0; d < dim; d++)
        product += a->way[d] * b->way[d];
    return a->square <= ALIKE * ALIKE * b->square && b->square <= ALIKE * ALIKE * a->square &&
           product * product >= PARALLEL * PARALLEL * a->square * b->square;
}

static inline void look_around(const search *s, int32_t node, const edge *e, company *c,
                               const int dim) {
    const int64_t begin = s->incidence.offset[node], end = s->incidence.offset[node + 1];
    const int64_t step = (end - begin) / MOST_LOOKED_AT + 1;
    for (int64_t i = begin; i < end; i += step) {
        const int32_t element = s->incidence.element[i];
        const uint8_t number = s->shortest[element];
        if (number == NOT_THIN) {
            c->n++;
            continue;
        }
        const ends at = ends_of(s, element, number, dim);
        if (at.node[0] == e->at.node[0] && at.node[1] == e->at.node[1])
            continue;
        const edge other = edge_between(s, at, dim);
        c->n++;
        c->n_along += go_along(e, &other, dim);
    }
}

static inline int has_company(const search *s, const edge *e, const int dim) {
    company c = {0, 0};
    for (int j = 0; j < 2; j++)
        look_around(s, e->at.node[j], e, &c, dim);
    return c.n_along > 0 && (double)c.n_along >= COMPANY * (double)c.n;
}

/** Decide about the elements whose shortest edge begins at node. Elements of one edge are often
 *  next to each other in the list: what was found of the last few edges is kept. */
static inline int64_t decide(const search *s, int32_t node, const int dim) {
    enum { KEPT = 8 };
    struct {
        int32_t end;
        uint8_t is_layer;
    } kept[KEPT];
    int n_kept = 0;
    int64_t n = 0;
    for (int64_t i = s->incidence.offset[node]; i < s->incidence.offset[node + 1]; i++) {
        const int32_t element = s->incidence.element[i];
        if (s->shortest[element] == NOT_THIN)
            continue;
        const ends at = ends_of(s, element, s->shortest[element], dim);
        if (at.node[0] != node)
            continue;
        int k = 0;
        while (k < n_kept && k < KEPT && kept[k].end != at.node[1])
            k++;
        if (k == n_kept || k == KEPT) {
            const edge e = edge_between(s, at, dim);
            k = n_kept++ % KEPT;
            kept[k].end = at.node[1];
            kept[k].is_layer = (uint8_t)has_company(s, &e, dim);
        }
        s->is_layer[element] = kept[k].is_layer;
        n += kept[k].is_layer;
    }
    return n;
}

static void decide_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (!s->unasked[i])
            n += s->mesh->dim == 3 ? decide(s, (int32_t)i, 3) : decide(s, (int32_t)i, 2);
    __atomic_fetch_add(&s->n_layer, n, __ATOMIC_RELAXED);
}

/** Nothing can fail any more when the caller's array is written to. */
static int decide_all(search *s, int threads, planish_error *error) {
    const planish_mesh *mesh = s->mesh;
    int status = PLANISH_OK;
    s->unasked = pl_alloc(mesh->n_nodes, 1);
    if (!s->unasked)
        return pl_fail_memory(error, "thin elements");
    memset(s->unasked, 1, (size_t)mesh->n_nodes);
    pl_parallel_for(threads, mesh->n_elements, CHUNK, ask_chunk, s);
    status = pl_incidence_create(mesh, s->unasked, threads, &s->incidence, error);
    if (!status) {
        memset(s->is_layer, 0, (size_t)mesh->n_elements);
        pl_parallel_for(threads, mesh->n_nodes, CHUNK, decide_chunk, s);
    }
    return status;
}

static int find_layers(search *s, int threads, planish_error *error) {
    const int64_t n = s->mesh->n_elements;
    int status = pl_frame_create(s->mesh, threads, &s->frame, error);
    s->shortest = pl_alloc(n, 1);
    if (!status && !s->shortest)
        status = pl_fail_memory(error, "thin elements");
    if (!status) {
        pl_parallel_for(threads, n, CHUNK, find_thin_chunk, s);
        if (s->n_thin > 0)
            status = decide_all(s, threads, error);
        else
            memset(s->is_layer, 0, (size_t)n);
    }
    pl_incidence_destroy(&s->incidence);
    pl_free(s->unasked);
    pl_free(s->shortest);
    return status;
}

int planish_find_layers(const planish_mesh *mesh, int threads, uint8_t *is_layer, int64_t *n_layer,
                        planish_error *error) {
    if (threads < 0 || threads > PL_MAX_THREADS)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "threads is %d; give 1 to %d, or 0 for as many as OpenMP would use", threads,
                       PL_MAX_THREADS);
    if (!is_layer)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "is_layer must not be NULL");
    const int used = pl_thread_count(threads);
    pl_dense dense;
    int status = pl_dense_create(mesh, used, &dense, error);
    if (status)
        return status;
    search s = {.mesh = &dense.mesh, .is_layer = is_layer};
    status = find_layers(&s, used, error);
    pl_dense_destroy(&dense);
    if (!status && n_layer)
        *n_layer = s.n_layer;
    return status;
}
