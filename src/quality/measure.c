/* measure: the quality of a mesh, in one pass over its elements, and marks of single elements.
 *
 * Chunks of elements are handed to threads, which go through them in blocks (measure_block.h) and
 * add these up (measure_sums.h); then the sums become the public figures.
 */
#include "quality/measure.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/angle.h"
#include "quality/certificate.h"
#include "quality/measure_block.h"
#include "quality/measure_sums.h"

#include <string.h>

enum {
    MIN_CHUNK = 512, /* elements that pay for being handed to a thread */
    MAX_CHUNKS = 512 /* more than threads need, few enough for their sums */
};

/* ---- Chunks ------------------------------------------------------------------------------- */

/** The mesh and the results of its chunks: sums over elements, or what each element is. */
typedef struct pass {
    const pl_mesh_state *mesh;
    int64_t chunk;       /* elements of a chunk, a function of the mesh alone */
    int64_t n_chunks;    /* at most MAX_CHUNKS */
    pl_ratio_sums basic; /* those of all chunks so far, but for the sums of RR^2; shared */
    pl_sum sum[2];       /* of RR^2 of elements that are fixed, and movable; shared */
    pl_full_sums *full;  /* [n_chunks], or NULL: not wanted */
    uint8_t *state;      /* [n_elements] PL_FINE, ..., */
    double *ratio;       /* or [n_elements] RR, 0 of elements that are not valid; instead of sums */
    double limit2;       /* RR^2 above which an element is worse, */
    double acute_limit;  /* or the acuteness of an angle, */
    double blunt;        /* and RR^2 up to which it has no such angle */
} pass;

static pass begin_pass(const pl_mesh_state *mesh) {
    int64_t blocks = mesh->of->n_elements / ((int64_t)PL_SUM_LANES * MAX_CHUNKS) + 1;
    int64_t chunk = blocks * PL_SUM_LANES > MIN_CHUNK ? blocks * PL_SUM_LANES : MIN_CHUNK;
    int64_t n_chunks = mesh->of->n_elements > 0 ? (mesh->of->n_elements - 1) / chunk + 1 : 0;
    return (pass){.mesh = mesh, .chunk = chunk, .n_chunks = n_chunks};
}

/** RR^2 up to which an element has no smaller angle than the smallest that is known by now,
 *  whichever chunk it is of. */
static double blunt_so_far(pass *p, const int dim) {
    double acuteness;
    __atomic_load(&p->basic.acuteness, &acuteness, __ATOMIC_RELAXED);
    return pl_blunt_ratio_square(dim, acuteness);
}

/** The elements from first on, at most PL_SUM_LANES; how many. */
PL_INLINE int evaluate_block(const pass *p, int64_t first, int64_t end, pl_block *b, const int dim,
                             const int full) {
    const int count = end - first < PL_SUM_LANES ? (int)(end - first) : PL_SUM_LANES;
    double n_certain = 0;
    pl_block_gather(p->mesh, first, count, b);
    pl_block_evaluate(b, dim, full);
    for (int l = 0; l < PL_SUM_LANES; l++)
        n_certain += b->certain[l];
    if (n_certain < PL_SUM_LANES)
        pl_block_resolve(p->mesh, first, count, b);
    return count;
}

/** The state, or the ratio, of each of elements begin .. end - 1. */
PL_INLINE void classify_chunk(const pass *p, int64_t begin, int64_t end, const int dim) {
    pl_block b;
    for (int64_t first = begin; first < end; first += PL_SUM_LANES) {
        const int count = evaluate_block(p, first, end, &b, dim, 0);
        for (int l = 0; l < count; l++) {
            const int is_valid = b.valid[l] != 0;
            if (p->ratio) {
                p->ratio[first + l] = is_valid ? sqrt(pl_larger(1, b.square[l])) : 0;
                continue;
            }
            const int is_worse =
                is_valid &&
                (b.square[l] > p->limit2 ||
                 (b.square[l] > p->blunt && pl_block_acuteness(&b, l, dim) > p->acute_limit));
            p->state[first + l] = !is_valid ? PL_INVERTED : is_worse ? PL_WORSE : PL_FINE;
        }
    }
}

/** Sums over elements begin .. end - 1. */
PL_INLINE void sum_chunk(pass *p, int64_t begin, int64_t end, const int dim, const int full) {
    pl_basic_lanes basic;
    pl_full_lanes more;
    pl_sum movable, fixed;
    pl_block b;
    double blunt = blunt_so_far(p, dim);
    memset(&basic, 0, sizeof basic);
    memset(&movable, 0, sizeof movable);
    memset(&fixed, 0, sizeof fixed);
    if (full)
        pl_clear_full(&more);
    for (int64_t first = begin; first < end; first += PL_SUM_LANES) {
        double largest = 0;
        evaluate_block(p, first, end, &b, dim, full);
        pl_add_basic(&b, &basic, &movable, &fixed);
        if (full) {
            pl_add_full(&b, first, &more);
            continue;
        }
        for (int l = 0; l < PL_SUM_LANES; l++)
            largest = pl_larger(b.square[l], largest);
        for (int l = 0; largest > blunt && l < PL_SUM_LANES; l++) {
            if (b.valid[l] == 0 || b.is_movable[l] == 0 || b.square[l] <= blunt)
                continue;
            pl_raise_double(&p->basic.acuteness, pl_block_acuteness(&b, l, dim));
            blunt = blunt_so_far(p, dim);
        }
    }
    pl_merge_basic(&basic, &p->basic);
    pl_sum_merge(&p->sum[1], &movable);
    pl_sum_merge(&p->sum[0], &fixed);
    if (full)
        pl_reduce_full(&more, &p->full[begin / p->chunk]);
}

PL_INLINE void chunk_of_dim(pass *p, int64_t begin, int64_t end, const int dim) {
    if (p->state || p->ratio)
        classify_chunk(p, begin, end, dim);
    else if (p->full)
        sum_chunk(p, begin, end, dim, 1);
    else
        sum_chunk(p, begin, end, dim, 0);
}

PL_INLINE void inline_chunk(pass *p, int64_t begin, int64_t end) {
    if (p->mesh->of->dim == 3)
        chunk_of_dim(p, begin, end, 3);
    else
        chunk_of_dim(p, begin, end, 2);
}

/* With wider vectors, which take 0.6 of the time; the bits are the same. */
#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void wide_chunk(pass *p, int64_t begin, int64_t end) {
    inline_chunk(p, begin, end);
}
#endif

static void any_chunk(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2")) {
        wide_chunk(context, begin, end);
        return;
    }
#endif
    inline_chunk(context, begin, end);
}

/** Run a pass of sums. Returns the radius ratios over all processes. */
static pl_ratio_sums sum_ratios(pass *p, int threads) {
    pl_parallel_for(threads, p->mesh->of->n_elements, p->chunk, any_chunk, p);
    const pl_ratio_sums *basic = &p->basic;
    int64_t counts[] = {basic->n_movable, basic->n_fixed, basic->inverted};
    double most[] = {basic->max, basic->acuteness};
    pl_parts_add_sums(p->sum, 2);
    pl_parts_add(counts, 3);
    pl_parts_largest(most, 2);
    return (pl_ratio_sums){.movable = pl_sum_value(&p->sum[1]),
                           .fixed = pl_sum_value(&p->sum[0]),
                           .n_movable = counts[0],
                           .n_fixed = counts[1],
                           .max = most[0],
                           .acuteness = most[1],
                           .inverted = counts[2]};
}

void pl_sum_radius_ratio(const pl_view *view, const double *coordinates, int threads,
                         pl_ratio_sums *sums) {
    const pl_mesh_state mesh = {view, coordinates};
    pass p = begin_pass(&mesh);
    *sums = sum_ratios(&p, threads);
}

void pl_find_worse(const pl_view *view, const double *coordinates, double ratio, double acuteness,
                   int threads, uint8_t *state) {
    const pl_mesh_state mesh = {view, coordinates};
    pass p = begin_pass(&mesh);
    p.state = state;
    p.limit2 = ratio * ratio;
    p.acute_limit = acuteness;
    p.blunt = pl_blunt_ratio_square(view->dim, acuteness);
    pl_parallel_for(threads, view->n_elements, p.chunk, any_chunk, &p);
}

void pl_find_ratios(const pl_view *view, const double *coordinates, int threads, double *ratio) {
    const pl_mesh_state mesh = {view, coordinates};
    pass p = begin_pass(&mesh);
    p.ratio = ratio;
    pl_parallel_for(threads, view->n_elements, p.chunk, any_chunk, &p);
}

/* ---- Elements numbered the other way round ------------------------------------------------ */

enum { FLAT = 0, POSITIVE = 1, NEGATIVE = 2 }; /* signs, between the passes */

/** The elements by the signs of their measures. */
typedef struct numbering {
    const pl_mesh_state *mesh;
    uint8_t *state;    /* [n_elements] */
    int64_t counts[2]; /* positive and negative elements; shared */
    uint8_t rarer;     /* POSITIVE or NEGATIVE */
} numbering;

static void sign_chunk(void *context, int64_t begin, int64_t end, int thread) {
    numbering *n = context;
    const pl_view *view = n->mesh->of;
    int64_t n_positive = 0, n_negative = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *node = view->elements + i * (view->dim + 1);
        const int counts = !view->is_counted || view->is_counted[i];
        const double *vertex[4];
        for (int j = 0; j <= view->dim; j++)
            vertex[j] = n->mesh->coordinates + (int64_t)node[j] * view->dim;
        const int sign = pl_measure_sign(view->dim, vertex);
        n->state[i] = sign > 0 ? POSITIVE : sign < 0 ? NEGATIVE : FLAT;
        n_positive += counts && sign > 0;
        n_negative += counts && sign < 0;
    }
    __atomic_fetch_add(&n->counts[0], n_positive, __ATOMIC_RELAXED);
    __atomic_fetch_add(&n->counts[1], n_negative, __ATOMIC_RELAXED);
}

static void mark_chunk(void *context, int64_t begin, int64_t end, int thread) {
    numbering *n = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n->state[i] = n->state[i] == n->rarer;
}

/** Number of elements that do not have the sign of most; in a tie most are positive. */
static int64_t count_reversed(int64_t n_positive, int64_t n_negative) {
    return n_positive >= n_negative ? n_negative : n_positive;
}

int64_t pl_find_reversed(const pl_view *view, const double *coordinates, int threads,
                         uint8_t *reversed) {
    enum { CHUNK = 4096 }; /* elements that one thread takes at a time */
    const pl_mesh_state mesh = {view, coordinates};
    numbering n = {.mesh = &mesh, .state = reversed};
    pl_parallel_for(threads, view->n_elements, CHUNK, sign_chunk, &n);
    pl_parts_add(n.counts, 2);
    n.rarer = n.counts[0] >= n.counts[1] ? NEGATIVE : POSITIVE;
    pl_parallel_for(threads, view->n_elements, CHUNK, mark_chunk, &n);
    return count_reversed(n.counts[0], n.counts[1]);
}

/* ---- The public figures ------------------------------------------------------------------- */

static double root_mean(double sum, int64_t n) {
    return n > 0 ? sqrt(sum / (double)n) : 0;
}

static const double DEGREES = 57.295779513082320877; /* of a radian */

static void fill_ratios(const pl_ratio_sums *basic, const pl_full_sums *full, planish_quality *q) {
    int64_t n_valid = basic->n_movable + basic->n_fixed;
    q->n_inverted = basic->inverted;
    q->rms_radius_ratio = root_mean(basic->movable + basic->fixed, n_valid);
    q->rms_radius_ratio_movable = root_mean(basic->movable, basic->n_movable);
    q->fixed_rms_radius_ratio = root_mean(basic->fixed, basic->n_fixed);
    q->n_fixed_elements = full->count[PL_UNMOVABLE];
    q->worst_element = -1;
    if (n_valid == 0)
        return;
    q->mean_radius_ratio = full->sum[PL_MEASURE_RADIUS_RATIO] / (double)n_valid;
    q->max_radius_ratio = full->worst_ratio;
    q->worst_element = full->worst_element;
    q->fixed_max_radius_ratio = full->worst_fixed_ratio;
    q->min_angle_deg = full->min[PL_MEASURE_SMALLEST_ANGLE] * DEGREES;
    q->max_angle_deg = full->max[PL_MEASURE_LARGEST_ANGLE] * DEGREES;
    q->max_radius_ratio_movable = full->movable_ratio;
    if (basic->n_movable > 0)
        q->min_angle_deg_movable = full->movable_angle * DEGREES;
}

static void fill_spreads(int64_t n_valid, const pl_full_sums *full, planish_quality *q) {
    planish_spread *const spread[PL_N_MEASURES] = {
        &q->radius_ratio, &q->circumradius_to_edge, &q->edge_to_inradius,   &q->edge_ratio,
        &q->mean_ratio,   &q->scaled_jacobian,      &q->smallest_angle_deg, &q->largest_angle_deg};
    for (int m = 0; m < PL_N_MEASURES && n_valid > 0; m++) {
        const double unit = m < PL_N_RATIOS ? 1 : DEGREES;
        spread[m]->min = full->min[m] * unit;
        spread[m]->mean = full->sum[m] / (double)n_valid * unit;
        spread[m]->max = full->max[m] * unit;
    }
}

/** Add the sums of the other processes. The processes that have the worst element report it. */
static void add_full_parts(pl_full_sums *f) {
    const double worst_here = f->worst_ratio;
    pl_parts_add(f->count, PL_N_COUNTS);
    for (int k = 0; k < PL_N_QUANTITIES && pl_part_here(); k++) {
        pl_sum exact;
        memset(&exact, 0, sizeof exact);
        pl_sum_add(&exact, f->sum[k]);
        pl_parts_add_sums(&exact, 1);
        f->sum[k] = pl_sum_value(&exact);
    }
    pl_parts_smallest(f->min, PL_N_QUANTITIES);
    pl_parts_smallest(&f->movable_angle, 1);
    pl_parts_largest(f->max, PL_N_QUANTITIES);
    pl_parts_largest(&f->worst_ratio, 1);
    pl_parts_largest(&f->worst_fixed_ratio, 1);
    pl_parts_largest(&f->movable_ratio, 1);
    if (f->worst_ratio > worst_here)
        f->worst_element = -1;
}

int pl_measure(const pl_view *view, const double *coordinates, int threads,
               planish_quality *quality, planish_error *error) {
    enum { BINS = PLANISH_HISTOGRAM_BINS };
    const pl_mesh_state mesh = {view, coordinates};
    pass p = begin_pass(&mesh);
    p.full = pl_alloc(p.n_chunks, sizeof *p.full);
    if (!p.full)
        return pl_fail_memory(error, "measuring the mesh");
    const pl_ratio_sums basic = sum_ratios(&p, threads);
    pl_full_sums full = pl_no_sums();
    for (int64_t i = 0; i < p.n_chunks; i++)
        pl_add_sums(&p.full[i], &full);
    pl_free(p.full);
    add_full_parts(&full);
    int64_t n = view->n_elements;
    for (int64_t i = 0; view->is_movable && i < view->n_elements; i++)
        n -= view->is_movable[i] == PL_ELSEWHERE;
    pl_parts_add(&n, 1);

    planish_quality q = {.n_elements = n};
    const int64_t n_valid = basic.n_movable + basic.n_fixed;
    fill_ratios(&basic, &full, &q);
    fill_spreads(n_valid, &full, &q);
    memcpy(q.histogram_edges, PL_HISTOGRAM_EDGES, sizeof PL_HISTOGRAM_EDGES);
    for (int i = 0; i < BINS; i++) { /* the first bin also holds what rounding puts below 1 */
        const int64_t from = i > 0 ? full.count[PL_AT_LEAST + i] : n_valid;
        q.histogram_counts[i] = from - (i + 1 < BINS ? full.count[PL_AT_LEAST + i + 1] : 0);
    }
    for (int i = 0; i <= PLANISH_ANGLE_BINS; i++)
        q.angle_edges_deg[i] = PL_ANGLE_BIN_DEGREES * i;
    memcpy(q.angle_counts, full.count + PL_BY_ANGLE, sizeof q.angle_counts);
    q.n_reversed = count_reversed(full.count[PL_POSITIVE], full.count[PL_NEGATIVE]);
    if (n > 0) {
        q.min_volume = full.min[PL_VOLUME] + 0.0; /* one zero, not one of two */
        q.max_volume = full.max[PL_VOLUME] + 0.0;
        q.total_volume = full.sum[PL_VOLUME];
    }
    *quality = q;
    return PLANISH_OK;
}
