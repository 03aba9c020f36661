/* layers: planish_find_layers, which elements are thin in layers.
 *
 * In goes a mesh, out comes a mark for each element. An element that is thin has a shortest edge
 * across its layer; in a layer those of the elements around it are parallel to it and about as
 * long, on each other and side by side, elsewhere they are not. From the elements found so their
 * rows are followed to those that are hardly thin any more: most layers grow until they are not.
 * Nothing is asked of the boundary, so that layers may be anywhere, and in one or many. A mesh that
 * is stretched throughout need not have edges across: its elements are known by its one direction.
 *
 * Elements of other types take part as simplices whose shortest edges are given: cell_layers.c.
 */
#include "shape/shape.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/frame.h"
#include "topology/topology.h"

#include <math.h>
#include <string.h>

/* Shortest edges go along with each other if they are alike (PL_ALIKE) and have at least this cosine,
 * of 25 degrees: walls are curved, and have corners. */
static const double PARALLEL = 0.906;
/* The part of the elements around an edge whose shortest edge has to go along with it. Around the
 * edges of a single layer two fifths do, with as many elements on the other side. */
static const double COMPANY = 0.25;
/* For so many of these one has a shortest edge beside it, not before or behind it, within a cosine
 * of 60 degrees, as walls turn that much between coarse elements. A chain of short edges, as along
 * a curve with many nodes, is no layer. */
static const double BESIDE = 0.1, TURNED = 0.5;

/* A mesh is stretched throughout if its elements together are so many times as long as high. */
static const double STRETCHED = 4;

enum {
    CHUNK = 8192,   /* elements or nodes that one thread looks at at a time, */
    ROW_CHUNK = 512 /* and elements of layers, which have more to look at */
};

/* What becomes of an element. */
enum {
    IN_LAYER = 1,
    WENT_ON = 2 /* from its shortest edge, which may be that of others */
};

/* Of a node with more elements no more than about so many are looked at: each thin one asks. */
enum { MOST_LOOKED_AT = 256 };

/** Edges of an element by their corners; those of a triangle come first. */
static const uint8_t corners_of[6][2] = {{0, 1}, {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3}};

typedef struct layer_search {
    const planish_mesh *mesh; /* dense */
    const uint8_t *given;     /* [n_elements] of shortest, 0: to be found; NULL: all are */
    pl_frame frame;
    uint8_t *shortest;       /* [n_elements] the shortest edge, and how short it is */
    uint8_t *mark;           /* [n_elements] */
    uint8_t asks;            /* elements of which shortest says so ask for what is around them: */
    uint8_t *unasked;        /* [n_nodes] 0 for the ends of their edges, else 1 */
    pl_incidence incidence;  /* of the ends */
    int32_t *row;            /* [n_elements] the first n_layer: those marked IN_LAYER, by row */
    int64_t n_followed;      /* of those, in rows before the one that is being followed */
    int64_t n_thin, n_layer; /* so far; shared */
    double *moments;         /* [chunks][6] sums of the elements' moments */
    double across[3];        /* unit: the direction in which all of the mesh is thin */
} layer_search;

/** The nodes of an edge, the one of the lower number first. */
typedef struct ends {
    int32_t node[2];
} ends;

/** Edge from the first of its nodes to the other. */
typedef struct edge {
    ends at;
    double way[3], square; /* in units of the frame */
} edge;

static inline ends ends_of(const layer_search *s, int64_t element, int number, const int dim) {
    const int32_t *node = s->mesh->elements + element * (dim + 1);
    const int32_t a = node[corners_of[number][0]], b = node[corners_of[number][1]];
    return (ends){{a < b ? a : b, a < b ? b : a}};
}

static inline ends shortest_of(const layer_search *s, int64_t element, const int dim) {
    return ends_of(s, element, s->shortest[element] & PL_SHORTEST_EDGE, dim);
}

static inline int are_same(const ends *a, const ends *b) {
    return a->node[0] == b->node[0] && a->node[1] == b->node[1];
}

static inline edge edge_between(const layer_search *s, ends at, const int dim) {
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

/** Find the shortest edge of each element, and whether it is thin or wide. */
static inline void find_thin(layer_search *s, int64_t begin, int64_t end, const int dim) {
    int64_t n = 0;
    for (int64_t i = begin; i < end; i++) {
        double least = INFINITY, second = INFINITY, most = 0;
        int shortest = 0;
        if (s->given && s->given[i]) {
            s->shortest[i] = s->given[i];
            n += (s->given[i] & PL_IS_THIN) != 0;
            continue;
        }
        for (int k = 0; k < dim * (dim + 1) / 2; k++) {
            const double square = edge_between(s, ends_of(s, i, k, dim), dim).square;
            const double larger = square > least ? square : least;
            second = larger < second ? larger : second;
            shortest = square < least ? k : shortest;
            least = square < least ? square : least;
            most = square > most ? square : most;
        }
        const int is_thin = least > 0 && most >= PL_THIN * PL_THIN * least;
        const int is_wide = least > 0 && second >= PL_WIDE * PL_WIDE * least;
        s->shortest[i] =
            (uint8_t)(shortest | (is_thin ? PL_IS_THIN : 0) | (is_wide ? PL_IS_WIDE : 0));
        n += is_thin;
    }
    __atomic_fetch_add(&s->n_thin, n, __ATOMIC_RELAXED);
}

static void find_thin_chunk(void *context, int64_t begin, int64_t end, int thread) {
    layer_search *s = context;
    (void)thread;
    if (s->mesh->dim == 3)
        find_thin(s, begin, end, 3);
    else
        find_thin(s, begin, end, 2);
}

/* ---- elements around ------------------------------------------------------------------------ */

static void ask_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const layer_search *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (s->shortest[i] & s->asks) {
            const ends at = shortest_of(s, i, s->mesh->dim);
            for (int j = 0; j < 2; j++)
                pl_set_flag(&s->unasked[at.node[j]], 0);
        }
}

/** The incidence of the ends of the edges of those that ask; of more than before, or the first. */
static int ask(layer_search *s, uint8_t asks, int threads, planish_error *error) {
    pl_incidence_destroy(&s->incidence);
    s->asks = asks;
    pl_parallel_for(threads, s->mesh->n_elements, CHUNK, ask_chunk, s);
    return pl_incidence_create(s->mesh, s->unasked, threads, &s->incidence, error);
}

/* ---- layers --------------------------------------------------------------------------------- */

static inline double product(const edge *a, const edge *b, const int dim) {
    double sum = 0;
    for (int d = 0; d < dim; d++)
        sum += a->way[d] * b->way[d];
    return sum;
}

/** Whether two edges are of about the same length, and the cosine between them is at least cosine.
 */
static inline int are_alike(const edge *a, const edge *b, double cosine, const int dim) {
    const double p = product(a, b, dim);
    return a->square <= PL_ALIKE * PL_ALIKE * b->square &&
           b->square <= PL_ALIKE * PL_ALIKE * a->square &&
           p * p >= cosine * cosine * a->square * b->square;
}

/** Whether the middle of edge b is as far from the line of edge a as that is long. */
static inline int is_beside(const layer_search *s, const edge *a, const edge *b, const int dim) {
    edge from = edge_between(s, (ends){{a->at.node[0], b->at.node[0]}}, dim);
    from.square = 0;
    for (int d = 0; d < dim; d++) {
        from.way[d] += (b->way[d] - a->way[d]) / 2;
        from.square += from.way[d] * from.way[d];
    }
    const double along = product(&from, a, dim);
    return (from.square - a->square) * a->square >= along * along;
}

/** Whether enough of the elements around an edge, but for those whose shortest edge it is, have a
 *  shortest edge that goes along with it, and enough of these have it beside. */
static inline int has_company(const layer_search *s, const edge *e, const int dim) {
    int64_t n = 0, n_along = 0, n_beside = 0;
    for (int j = 0; j < 2; j++) {
        const int64_t *offset = s->incidence.offset + e->at.node[j];
        const int64_t step = (offset[1] - offset[0]) / MOST_LOOKED_AT + 1;
        for (int64_t i = offset[0]; i < offset[1]; i += step) {
            const int32_t element = s->incidence.element[i];
            if (!(s->shortest[element] & PL_IS_THIN)) {
                n++;
                continue;
            }
            const ends at = shortest_of(s, element, dim);
            if (are_same(&at, &e->at))
                continue;
            const edge other = edge_between(s, at, dim);
            /* Of the corners of such an element half are here. */
            const int weight = s->shortest[element] & PL_IS_GIVEN ? 2 : 1;
            n += weight;
            n_along += weight * are_alike(e, &other, PARALLEL, dim);
            n_beside +=
                weight * (are_alike(e, &other, TURNED, dim) && is_beside(s, e, &other, dim));
        }
    }
    return n_along > 0 && (double)n_along >= COMPANY * (double)n &&
           (double)n_beside >= BESIDE * (double)n_along;
}

/** Decide about the elements whose shortest edge begins at node. Elements of one edge are often
 *  next to each other in the list: what was found of the last few edges is kept. */
static inline int64_t decide(const layer_search *s, int32_t node, const int dim) {
    enum { KEPT = 8 };
    struct {
        int32_t end;
        uint8_t is_layer;
    } kept[KEPT];
    int n_kept = 0;
    int64_t n = 0;
    for (int64_t i = s->incidence.offset[node]; i < s->incidence.offset[node + 1]; i++) {
        const int32_t element = s->incidence.element[i];
        if (!(s->shortest[element] & PL_IS_THIN))
            continue;
        const ends at = shortest_of(s, element, dim);
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
        s->mark[element] = kept[k].is_layer ? IN_LAYER : 0;
        n += kept[k].is_layer;
    }
    return n;
}

static void decide_chunk(void *context, int64_t begin, int64_t end, int thread) {
    layer_search *s = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (!s->unasked[i])
            n += s->mesh->dim == 3 ? decide(s, (int32_t)i, 3) : decide(s, (int32_t)i, 2);
    __atomic_fetch_add(&s->n_layer, n, __ATOMIC_RELAXED);
}

/* ---- their rows ----------------------------------------------------------------------------- */

/** List the elements of layers in s->row; n_layer becomes how many there are, again. */
static void list_chunk(void *context, int64_t begin, int64_t end, int thread) {
    layer_search *s = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n += s->mark[i];
    n = __atomic_fetch_add(&s->n_layer, n, __ATOMIC_RELAXED);
    for (int64_t i = begin; i < end; i++)
        if (s->mark[i])
            s->row[n++] = (int32_t)i;
}

static inline int has_mark(const layer_search *s, int64_t element, uint8_t mark) {
    return __atomic_load_n(&s->mark[element], __ATOMIC_RELAXED) & mark;
}

/** Mark an element IN_LAYER, and perhaps more; if it was not, it is one of the next row. */
static inline void put_in(layer_search *s, int32_t element, uint8_t mark) {
    const uint8_t old = __atomic_fetch_or(&s->mark[element], mark, __ATOMIC_RELAXED);
    if (!(old & IN_LAYER))
        s->row[__atomic_fetch_add(&s->n_layer, 1, __ATOMIC_RELAXED)] = element;
}

/** Follow a row: from the shortest edge of an element to those of the rows before and behind it. */
static inline void follow_row(layer_search *s, int64_t element, const int dim) {
    if (has_mark(s, element, WENT_ON))
        return;
    const edge e = edge_between(s, shortest_of(s, element, dim), dim);
    for (int j = 0; j < 2; j++) {
        const int32_t node = e.at.node[j];
        const int64_t begin = s->incidence.offset[node], end = s->incidence.offset[node + 1];
        const int64_t step = (end - begin) / MOST_LOOKED_AT + 1;
        for (int64_t i = begin; i < end; i += step) {
            const int32_t around = s->incidence.element[i];
            if (!(s->shortest[around] & PL_IS_WIDE) || has_mark(s, around, WENT_ON))
                continue;
            const ends at = shortest_of(s, around, dim);
            if (are_same(&at, &e.at)) {
                put_in(s, around, IN_LAYER | WENT_ON);
            } else if (at.node[0] == node || at.node[1] == node) {
                /* it goes on from their common node if it points the same way */
                const edge other = edge_between(s, at, dim);
                const int is_turned = other.at.node[1 - j] != node;
                if ((product(&e, &other, dim) < 0) == is_turned &&
                    are_alike(&e, &other, PARALLEL, dim))
                    put_in(s, around, IN_LAYER);
            }
        }
    }
}

/** Follow a chunk of rows. All reachable elements are found, by any way: the result does not
 *  depend on which thread comes first. */
static void follow_chunk(void *context, int64_t begin, int64_t end, int thread) {
    layer_search *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (s->mesh->dim == 3)
            follow_row(s, s->row[s->n_followed + i], 3);
        else
            follow_row(s, s->row[s->n_followed + i], 2);
}

/* ---- meshes stretched throughout ------------------------------------------------------------- */

/** Places of the moments of dim coordinates in a row of 6. */
static const uint8_t place_of[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

/** Add the sum of e e^T over the edges e of an element, divided by its trace. */
static inline void add_moments(const layer_search *s, int64_t element, double *sum, const int dim) {
    double of[6] = {0}, trace = 0;
    for (int k = 0; k < dim * (dim + 1) / 2; k++) {
        const edge e = edge_between(s, ends_of(s, element, k, dim), dim);
        for (int i = 0; i < dim; i++)
            for (int j = i; j < dim; j++)
                of[place_of[i][j]] += e.way[i] * e.way[j];
        trace += e.square;
    }
    for (int i = 0; trace > 0 && i < 6; i++)
        sum[i] += of[i] / trace;
}

static void add_moments_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const layer_search *s = context;
    double *sum = s->moments + begin / CHUNK * 6;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (s->mesh->dim == 3)
            add_moments(s, i, sum, 3);
        else
            add_moments(s, i, sum, 2);
}

/** Turn rows and columns p and q of the symmetric matrix a so that a[p][q] becomes 0; v turns along
 *  (Jacobi 1846). */
static void turn(double a[3][3], double v[3][3], int p, int q) {
    if (a[p][q] == 0)
        return;
    const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
    const double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1));
    const double c = 1 / sqrt(t * t + 1), sine = t * c;
    for (int k = 0; k < 3; k++) {
        const double x = a[k][p], y = a[k][q];
        a[k][p] = c * x - sine * y;
        a[k][q] = sine * x + c * y;
    }
    for (int k = 0; k < 3; k++) {
        const double x = a[p][k], y = a[q][k];
        a[p][k] = c * x - sine * y;
        a[q][k] = sine * x + c * y;
    }
    for (int k = 0; k < 3; k++) {
        const double x = v[k][p], y = v[k][q];
        v[k][p] = c * x - sine * y;
        v[k][q] = sine * x + c * y;
    }
}

/** The direction of the smallest moment of the matrix of sum into across; whether it is so small
 *  that all of the mesh is stretched. */
static int find_across(const double *sum, int dim, double *across) {
    enum { ROUNDS = 12 };
    double a[3][3] = {{0}}, v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, most = 0;
    int least = 0;
    for (int i = 0; i < dim; i++)
        for (int j = 0; j < dim; j++)
            a[i][j] = sum[place_of[i][j]];
    for (int round = 0; round < ROUNDS; round++)
        for (int p = 0; p < dim; p++)
            for (int q = p + 1; q < dim; q++)
                turn(a, v, p, q);
    for (int i = 0; i < dim; i++) {
        least = a[i][i] < a[least][least] ? i : least;
        most = fmax(most, a[i][i]);
    }
    for (int d = 0; d < 3; d++)
        across[d] = v[d][least];
    return a[least][least] * STRETCHED * STRETCHED <= most;
}

/** Mark the simplices that are thin across. */
static void mark_flat_chunk(void *context, int64_t begin, int64_t end, int thread) {
    layer_search *s = context;
    const int dim = s->mesh->dim;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double extent = 0, most = 0;
        if (s->shortest[i] & PL_IS_GIVEN)
            continue;
        for (int k = 0; k < dim * (dim + 1) / 2 && !(s->mark[i] & IN_LAYER); k++) {
            const edge e = edge_between(s, ends_of(s, i, k, dim), dim);
            double height = 0;
            for (int d = 0; d < dim; d++)
                height += e.way[d] * s->across[d];
            extent = fmax(extent, fabs(height));
            most = fmax(most, e.square);
        }
        if (extent > 0 && most >= PL_THIN * PL_THIN * extent * extent) {
            s->mark[i] |= IN_LAYER;
            n++;
        }
    }
    __atomic_fetch_add(&s->n_layer, n, __ATOMIC_RELAXED);
}

/** If all of the mesh is stretched, the elements that are thin in that direction are of layers. The
 *  moments of chunks are added in their order. */
static int add_stretched(layer_search *s, int threads, planish_error *error) {
    const int64_t n = s->mesh->n_elements, n_chunks = (n + CHUNK - 1) / CHUNK;
    double sum[6] = {0};
    s->moments = pl_alloc_zero(n_chunks, 6 * sizeof *s->moments);
    if (!s->moments)
        return pl_fail_memory(error, "thin elements");
    pl_parallel_for(threads, n, CHUNK, add_moments_chunk, s);
    for (int64_t i = 0; i < 6 * n_chunks; i++)
        sum[i % 6] += s->moments[i];
    pl_free(s->moments);
    if (find_across(sum, s->mesh->dim, s->across))
        pl_parallel_for(threads, n, CHUNK, mark_flat_chunk, s);
    return PLANISH_OK;
}

/* ---- all of it ------------------------------------------------------------------------------ */

/** Find layers with edges across: their thin elements, and then row by row those around. */
static int find_rows(layer_search *s, int threads, planish_error *error) {
    const int64_t n = s->mesh->n_elements;
    s->unasked = pl_alloc(s->mesh->n_nodes, 1);
    if (!s->unasked)
        return pl_fail_memory(error, "thin elements");
    memset(s->unasked, 1, (size_t)s->mesh->n_nodes);
    int status = ask(s, PL_IS_THIN, threads, error);
    if (status)
        return status;
    pl_parallel_for(threads, s->mesh->n_nodes, CHUNK, decide_chunk, s);
    if (s->n_layer == 0)
        return PLANISH_OK;
    s->row = pl_alloc(n, sizeof *s->row);
    if (!s->row)
        return pl_fail_memory(error, "thin elements");
    status = ask(s, PL_IS_THIN | PL_IS_WIDE, threads, error);
    if (status)
        return status;
    s->n_layer = 0;
    pl_parallel_for(threads, n, CHUNK, list_chunk, s);
    while (s->n_followed < s->n_layer) {
        const int64_t n_row = s->n_layer - s->n_followed;
        pl_parallel_for(threads, n_row, ROW_CHUNK, follow_chunk, s);
        s->n_followed += n_row;
    }
    return PLANISH_OK;
}

int pl_find_layers(const planish_mesh *mesh, const uint8_t *given, int threads, uint8_t *is_layer,
                   int64_t *n_layer, planish_error *error) {
    const int64_t n = mesh->n_elements;
    layer_search s = {.mesh = mesh, .given = given};
    int status = pl_frame_create(mesh, NULL, threads, &s.frame, error);
    s.shortest = pl_alloc(n, 1);
    s.mark = pl_alloc_zero(n, 1);
    if (!status && (!s.shortest || !s.mark))
        status = pl_fail_memory(error, "thin elements");
    if (!status)
        pl_parallel_for(threads, n, CHUNK, find_thin_chunk, &s);
    if (!status && s.n_thin > 0)
        status = find_rows(&s, threads, error);
    if (!status)
        status = add_stretched(&s, threads, error);
    for (int64_t i = 0; !status && i < n; i++)
        is_layer[i] = s.n_layer > 0 && s.mark[i] & IN_LAYER;
    *n_layer = s.n_layer;
    pl_incidence_destroy(&s.incidence);
    pl_free(s.row);
    pl_free(s.unasked);
    pl_free(s.mark);
    pl_free(s.shortest);
    return status;
}
