/* measure: what a mesh is worth, in one pass over its elements.
 *
 * Elements are taken in blocks of LANES: gather edges, evaluate all lanes at once by the plain
 * formulas of geometry/simplex.h, which the compiler turns into vectors, and add to LANES
 * accumulators. Elements whose orientation rounding could hide, or whose size could over- or
 * underflow, are looked at again one by one, scaled and with the exact sign.
 */
#include "quality/measure.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/simplex.h"
#include "quality/certificate.h"

#include <float.h>
#include <string.h>

enum {
    LANES = 8,       /* accumulators of a chunk: part of what fixes the bits of a sum */
    MIN_CHUNK = 512, /* elements that pay for being handed to a thread */
    MAX_CHUNKS = 512 /* more than threads need, few enough for their sums to live on the stack */
};

/* |D| above this multiple of |e_1|_1 |e_2|_1 .. is certain to have the right sign: Shewchuk's bound
 * (certificate.c) with 8 for 7 and 4 for 3, which pays for the rounding of the product itself. */
static const double ERROR_2D = 4 * 0x1p-53;
static const double ERROR_3D = 8 * 0x1p-53;

/* Range where no intermediate result of RR^2 over- or underflows: with the norms below
 * LARGEST_NORM, N S^2 is below 2^980; with their product above SMALLEST_PRODUCT and |D| above 2^-51
 * of it, D^4 is above 2^-930, and so is N S^2 because RR >= 1. */
static const double LARGEST_NORM = 0x1p80;
static const double SMALLEST_PRODUCT = 0x1p-180;

static const double HISTOGRAM_EDGES[PLANISH_HISTOGRAM_BINS + 1] = {
    1, 1.25, 1.5, 2, 2.5, 3, 4, 6, 10, 30, 100, 1000, INFINITY};

/** The mesh as measure.h describes it. */
typedef struct mesh_state {
    int dim;
    int64_t n_elements;
    const int32_t *elements;
    const int8_t *sign;
    const uint8_t *is_free;
    const double *coordinates;
} mesh_state;

/** LANES elements, one per lane; lanes past the last element are not present. */
typedef struct block {
    double edges[3][3][LANES]; /* [dim][dim] rows v_{j+1} - v_0 */
    double sign[LANES];        /* of the elements' orientation */
    double is_free[LANES];     /* 1: has a free node */
    double present[LANES];     /* 1, or 0 past the last element */
    double certain[LANES];     /* 1: what follows is right as it is */
    double valid[LANES];       /* 1: positive measure */
    double square[LANES];      /* RR^2 */
    double ratio[LANES];       /* RR; this and the rest for pl_measure only */
    double volume[LANES];      /* signed measure in the mesh's orientation */
    double smallest_cosine[LANES];
    double largest_cosine[LANES];
} block;

/** What both passes accumulate, one column per lane. */
typedef struct basic_lanes {
    double movable[LANES], fixed[LANES], max[LANES]; /* sums of RR^2, largest RR^2 */
    double n_movable[LANES], n_fixed[LANES], inverted[LANES];
} basic_lanes;

/** What pl_measure accumulates besides. */
typedef struct full_lanes {
    double n_unmovable[LANES]; /* elements without a free node, valid or not */
    double ratio_sum[LANES], volume_sum[LANES];
    double smallest_volume[LANES], largest_volume[LANES];
    double smallest_cosine[LANES], largest_cosine[LANES];
    double worst_ratio[LANES], worst_fixed_ratio[LANES];
    double worst_element[LANES];                    /* exact: element numbers are below 2^53 */
    double at_least[PLANISH_HISTOGRAM_BINS][LANES]; /* elements of RR >= each edge */
} full_lanes;

/** Sums of a chunk, or of the mesh, besides pl_ratio_sums. */
typedef struct full_sums {
    int64_t n_unmovable;
    double ratio_sum, volume_sum, smallest_volume, largest_volume;
    double smallest_cosine, largest_cosine;
    double worst_ratio, worst_fixed_ratio;
    int64_t worst_element;
    int64_t at_least[PLANISH_HISTOGRAM_BINS];
} full_sums;

static inline double larger(double a, double b) {
    return a > b ? a : b;
}
static inline double smaller(double a, double b) {
    return a < b ? a : b;
}

/* ---- Blocks of elements ------------------------------------------------------------------- */

/** Gather elements first .. first + count - 1; the other lanes repeat the first. */
PL_INLINE void gather(const mesh_state *mesh, int64_t first, int count, block *b, const int dim) {
    for (int l = 0; l < LANES; l++) {
        int64_t element = first + (l < count ? l : 0);
        const int32_t *node = mesh->elements + element * (dim + 1);
        const double *origin = mesh->coordinates + (int64_t)node[0] * dim;
        int is_free = mesh->is_free[node[0]];
        for (int j = 0; j < dim; j++) {
            const double *vertex = mesh->coordinates + (int64_t)node[j + 1] * dim;
            is_free |= mesh->is_free[node[j + 1]];
            for (int d = 0; d < dim; d++)
                b->edges[j][d][l] = vertex[d] - origin[d];
        }
        b->is_free[l] = is_free != 0;
        b->sign[l] = mesh->sign ? mesh->sign[element] : 1;
        b->present[l] = l < count;
    }
}

/** Product of the edges' sums of absolute components, an upper bound of D's permanent; infinite
 *  where the plain formulas could over- or underflow. */
PL_INLINE double permanent_bound(const int dim, const double edges[3][3]) {
    double product = 1, longest = 0;
    for (int j = 0; j < dim; j++) {
        double norm = fabs(edges[j][0]) + fabs(edges[j][1]);
        norm = dim == 3 ? norm + fabs(edges[j][2]) : norm;
        product *= norm;
        longest = larger(longest, norm);
    }
    product = longest < LARGEST_NORM ? product : INFINITY;
    return product > SMALLEST_PRODUCT ? product : INFINITY;
}

/** Evaluate all lanes; full: what pl_measure wants as well. */
PL_INLINE void evaluate(block *b, const int dim, const int full) {
    for (int l = 0; l < LANES; l++) {
        double edges[3][3];
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                edges[j][d] = b->edges[j][d][l];
        pl_shape shape = pl_shape_of_edges(dim, edges);
        double error = (dim == 3 ? ERROR_3D : ERROR_2D) * permanent_bound(dim, edges);
        double oriented = b->sign[l] * shape.determinant;
        b->certain[l] = fabs(oriented) > error ? 1 : 0;
        b->valid[l] = oriented > 0 ? b->present[l] : 0;
        b->square[l] = pl_radius_ratio_square_of_shape(dim, &shape);
        if (full) {
            b->ratio[l] = pl_radius_ratio_of_shape(dim, &shape);
            b->volume[l] = oriented / (dim == 3 ? 6 : 2);
            b->smallest_cosine[l] = shape.smallest_cosine;
            b->largest_cosine[l] = shape.largest_cosine;
        }
    }
}

/* ---- Elements one by one ------------------------------------------------------------------ */

/** Edges of the vertices times factor; returns the largest absolute component. */
static double differences(int dim, const double *const vertex[], double factor,
                          double edges[3][3]) {
    double largest = 0;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++) {
            edges[j][d] = vertex[j + 1][d] * factor - vertex[0][d] * factor;
            largest = larger(largest, fabs(edges[j][d]));
        }
    return largest;
}

/** Edges of the vertices times 2^-exponent, which is returned, with the largest component below 1
 *  and not below 1/2, unless all are 0. Coordinates are finite. */
static int scaled_edges(int dim, const double *const vertex[], double edges[3][3]) {
    double largest = differences(dim, vertex, 1, edges);
    int halved = largest > DBL_MAX, exponent;
    if (halved)
        largest = differences(dim, vertex, 0.5, edges);
    frexp(largest, &exponent);
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edges[j][d] = ldexp(edges[j][d], -exponent);
    return exponent + halved;
}

/** Square of the longest edge. */
static double longest_square(int dim, const double edges[3][3]) {
    double longest = 0;
    for (int j = 0; j < dim; j++) {
        longest = larger(longest, pl_dot(dim, edges[j], edges[j]));
        for (int i = 0; i < j; i++) {
            double edge[3];
            pl_subtract(dim, edges[j], edges[i], edge);
            longest = larger(longest, pl_dot(dim, edge, edge));
        }
    }
    return longest;
}

/** Evaluate lane l anew: in the element's own scale, with the exact sign. */
static inline void resolve(const mesh_state *mesh, int64_t element, int l, block *b,
                           const int dim) {
    const double *vertex[4];
    for (int j = 0; j <= dim; j++)
        vertex[j] = mesh->coordinates + (int64_t)mesh->elements[element * (dim + 1) + j] * dim;
    int exponent;
    double m = b->sign[l] * pl_certified_determinant(dim, vertex, &exponent);
    b->volume[l] = ldexp(m / (dim == 3 ? 6 : 2), exponent);
    b->valid[l] = m > 0;
    if (!(m > 0))
        return;
    double edges[3][3];
    int scale = scaled_edges(dim, vertex, edges);
    pl_shape shape = pl_shape_of_edges(dim, edges);
    shape.determinant = ldexp(m, exponent - dim * scale);
    /* R is at least half the longest edge, whatever cancelled in N. */
    double d2 = shape.determinant * shape.determinant;
    shape.circumradius_square = larger(shape.circumradius_square, d2 * longest_square(dim, edges));
    b->ratio[l] = pl_radius_ratio_of_shape(dim, &shape);
    b->square[l] = b->ratio[l] * b->ratio[l];
    b->smallest_cosine[l] = shape.smallest_cosine;
    b->largest_cosine[l] = shape.largest_cosine;
}

/** Evaluate the uncertain ones of elements first .. first + count - 1 anew. */
static void resolve_uncertain(const mesh_state *mesh, int64_t first, int count, block *b) {
    for (int l = 0; l < count; l++) {
        if (b->certain[l] != 0)
            continue;
        if (mesh->dim == 3)
            resolve(mesh, first + l, l, b, 3);
        else
            resolve(mesh, first + l, l, b, 2);
    }
}

static inline int all_certain(const block *b) {
    double n_certain = 0;
    for (int l = 0; l < LANES; l++)
        n_certain += b->certain[l];
    return n_certain == LANES;
}

/* ---- Sums --------------------------------------------------------------------------------- */

PL_INLINE void add_basic(const block *b, basic_lanes *sums) {
    for (int l = 0; l < LANES; l++) {
        double square = b->valid[l] != 0 ? b->square[l] : 0;
        sums->movable[l] += b->is_free[l] != 0 ? square : 0;
        sums->fixed[l] += b->is_free[l] != 0 ? 0 : square;
        sums->max[l] = larger(square, sums->max[l]);
        sums->n_movable[l] += b->is_free[l] != 0 ? b->valid[l] : 0;
        sums->n_fixed[l] += b->is_free[l] != 0 ? 0 : b->valid[l];
        sums->inverted[l] += b->present[l] - b->valid[l];
    }
}

PL_INLINE void add_full(const block *b, int64_t first, full_lanes *sums) {
    for (int l = 0; l < LANES; l++) {
        double ratio = b->valid[l] != 0 ? b->ratio[l] : 0;
        double fixed_ratio = b->is_free[l] != 0 ? 0 : ratio;
        int is_worst = ratio > sums->worst_ratio[l];
        double element = (double)(first + l);
        double smallest_cosine = b->valid[l] != 0 ? b->smallest_cosine[l] : 1;
        double largest_cosine = b->valid[l] != 0 ? b->largest_cosine[l] : -1;
        sums->n_unmovable[l] += b->is_free[l] != 0 ? 0 : b->present[l];
        sums->ratio_sum[l] += ratio;
        sums->worst_element[l] = is_worst ? element : sums->worst_element[l];
        sums->worst_ratio[l] = is_worst ? ratio : sums->worst_ratio[l];
        sums->worst_fixed_ratio[l] = larger(fixed_ratio, sums->worst_fixed_ratio[l]);
        sums->smallest_cosine[l] = smaller(smallest_cosine, sums->smallest_cosine[l]);
        sums->largest_cosine[l] = larger(largest_cosine, sums->largest_cosine[l]);
        double present = b->present[l];
        double low = present != 0 ? b->volume[l] : INFINITY;
        double high = present != 0 ? b->volume[l] : -INFINITY;
        sums->volume_sum[l] += present != 0 ? b->volume[l] : 0;
        sums->smallest_volume[l] = smaller(low, sums->smallest_volume[l]);
        sums->largest_volume[l] = larger(high, sums->largest_volume[l]);
    }
    for (int i = 1; i < PLANISH_HISTOGRAM_BINS; i++)
        for (int l = 0; l < LANES; l++)
            sums->at_least[i][l] += b->ratio[l] >= HISTOGRAM_EDGES[i] ? b->valid[l] : 0;
}

static void reduce_basic(const basic_lanes *lanes, pl_ratio_sums *sums) {
    memset(sums, 0, sizeof *sums);
    for (int l = 0; l < LANES; l++) {
        sums->movable += lanes->movable[l];
        sums->fixed += lanes->fixed[l];
        sums->max = larger(lanes->max[l], sums->max);
        sums->n_movable += (int64_t)lanes->n_movable[l];
        sums->n_fixed += (int64_t)lanes->n_fixed[l];
        sums->inverted += (int64_t)lanes->inverted[l];
    }
}

static const full_sums NO_SUMS = {.smallest_volume = INFINITY,
                                  .largest_volume = -INFINITY,
                                  .smallest_cosine = 1,
                                  .largest_cosine = -1,
                                  .worst_element = -1};

/** Take over ratio of element as the worst, if it is; the lowest element wins a tie. */
static void take_worst(double ratio, int64_t element, full_sums *sums) {
    if (ratio > sums->worst_ratio || (ratio == sums->worst_ratio && element < sums->worst_element))
        sums->worst_element = element;
    sums->worst_ratio = larger(ratio, sums->worst_ratio);
}

static void clear_full(full_lanes *lanes) {
    memset(lanes, 0, sizeof *lanes);
    for (int l = 0; l < LANES; l++) {
        lanes->smallest_volume[l] = NO_SUMS.smallest_volume;
        lanes->largest_volume[l] = NO_SUMS.largest_volume;
        lanes->smallest_cosine[l] = NO_SUMS.smallest_cosine;
        lanes->largest_cosine[l] = NO_SUMS.largest_cosine;
    }
}

static void reduce_full(const full_lanes *lanes, full_sums *sums) {
    *sums = NO_SUMS;
    for (int l = 0; l < LANES; l++) {
        sums->n_unmovable += (int64_t)lanes->n_unmovable[l];
        sums->ratio_sum += lanes->ratio_sum[l];
        sums->volume_sum += lanes->volume_sum[l];
        sums->smallest_volume = smaller(lanes->smallest_volume[l], sums->smallest_volume);
        sums->largest_volume = larger(lanes->largest_volume[l], sums->largest_volume);
        sums->smallest_cosine = smaller(lanes->smallest_cosine[l], sums->smallest_cosine);
        sums->largest_cosine = larger(lanes->largest_cosine[l], sums->largest_cosine);
        take_worst(lanes->worst_ratio[l], (int64_t)lanes->worst_element[l], sums);
        sums->worst_fixed_ratio = larger(lanes->worst_fixed_ratio[l], sums->worst_fixed_ratio);
        for (int i = 1; i < PLANISH_HISTOGRAM_BINS; i++)
            sums->at_least[i] += (int64_t)lanes->at_least[i][l];
    }
}

/* ---- Chunks ------------------------------------------------------------------------------- */

/** The mesh and the results of its chunks. */
typedef struct pass {
    const mesh_state *mesh;
    int64_t chunk;        /* elements of a chunk, a function of the mesh alone */
    int64_t n_chunks;     /* at most MAX_CHUNKS */
    pl_ratio_sums *basic; /* [n_chunks] */
    full_sums *full;      /* [n_chunks], or NULL: not wanted */
} pass;

static pass begin_pass(const mesh_state *mesh) {
    int64_t blocks = mesh->n_elements / ((int64_t)LANES * MAX_CHUNKS) + 1;
    int64_t chunk = blocks * LANES > MIN_CHUNK ? blocks * LANES : MIN_CHUNK;
    int64_t n_chunks = mesh->n_elements > 0 ? (mesh->n_elements - 1) / chunk + 1 : 0;
    return (pass){mesh, chunk, n_chunks, NULL, NULL};
}

/** Evaluate elements begin .. end - 1 of the pass. */
PL_INLINE void evaluate_chunk(const pass *p, int64_t begin, int64_t end, const int dim,
                              const int full) {
    basic_lanes basic;
    full_lanes more;
    block b;
    memset(&basic, 0, sizeof basic);
    if (full)
        clear_full(&more);
    for (int64_t first = begin; first < end; first += LANES) {
        int count = end - first < LANES ? (int)(end - first) : LANES;
        gather(p->mesh, first, count, &b, dim);
        evaluate(&b, dim, full);
        if (!all_certain(&b))
            resolve_uncertain(p->mesh, first, count, &b);
        add_basic(&b, &basic);
        if (full)
            add_full(&b, first, &more);
    }
    reduce_basic(&basic, &p->basic[begin / p->chunk]);
    if (full)
        reduce_full(&more, &p->full[begin / p->chunk]);
}

PL_INLINE void inline_chunk(const pass *p, int64_t begin, int64_t end) {
    if (p->mesh->dim == 3 && p->full)
        evaluate_chunk(p, begin, end, 3, 1);
    else if (p->mesh->dim == 3)
        evaluate_chunk(p, begin, end, 3, 0);
    else if (p->full)
        evaluate_chunk(p, begin, end, 2, 1);
    else
        evaluate_chunk(p, begin, end, 2, 0);
}

static void base_chunk(const pass *p, int64_t begin, int64_t end) {
    inline_chunk(p, begin, end);
}

/* The same with wider vectors, which take 0.6 of the time; the bits are the same. */
#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void wide_chunk(const pass *p, int64_t begin, int64_t end) {
    inline_chunk(p, begin, end);
}
static int has_wide(void) {
    return __builtin_cpu_supports("avx2");
}
#else
static void wide_chunk(const pass *p, int64_t begin, int64_t end) {
    base_chunk(p, begin, end);
}
static int has_wide(void) {
    return 0;
}
#endif

static void any_chunk(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    if (has_wide())
        wide_chunk(context, begin, end);
    else
        base_chunk(context, begin, end);
}

static pl_ratio_sums total_basic(const pass *p) {
    pl_ratio_sums total = {0};
    for (int64_t i = 0; i < p->n_chunks; i++) {
        const pl_ratio_sums *part = &p->basic[i];
        total.movable += part->movable;
        total.fixed += part->fixed;
        total.max = larger(part->max, total.max);
        total.n_movable += part->n_movable;
        total.n_fixed += part->n_fixed;
        total.inverted += part->inverted;
    }
    return total;
}

static full_sums total_full(const pass *p) {
    full_sums total = NO_SUMS;
    for (int64_t i = 0; i < p->n_chunks; i++) {
        const full_sums *part = &p->full[i];
        total.n_unmovable += part->n_unmovable;
        total.ratio_sum += part->ratio_sum;
        total.volume_sum += part->volume_sum;
        total.smallest_volume = smaller(part->smallest_volume, total.smallest_volume);
        total.largest_volume = larger(part->largest_volume, total.largest_volume);
        total.smallest_cosine = smaller(part->smallest_cosine, total.smallest_cosine);
        total.largest_cosine = larger(part->largest_cosine, total.largest_cosine);
        take_worst(part->worst_ratio, part->worst_element, &total);
        total.worst_fixed_ratio = larger(part->worst_fixed_ratio, total.worst_fixed_ratio);
        for (int b = 1; b < PLANISH_HISTOGRAM_BINS; b++)
            total.at_least[b] += part->at_least[b];
    }
    return total;
}

void pl_sum_radius_ratio(int dim, int64_t n_elements, const int32_t *elements, const int8_t *sign,
                         const uint8_t *is_free, const double *coordinates, int threads,
                         pl_ratio_sums *sums) {
    const mesh_state mesh = {dim, n_elements, elements, sign, is_free, coordinates};
    pl_ratio_sums part[MAX_CHUNKS];
    pass p = begin_pass(&mesh);
    p.basic = part;
    pl_parallel_for(threads, n_elements, p.chunk, any_chunk, &p);
    *sums = total_basic(&p);
}

/* ---- The public figures ------------------------------------------------------------------- */

static double root_mean(double sum, int64_t n) {
    return n > 0 ? sqrt(sum / (double)n) : 0;
}

static double degrees_of_cosine(double cosine) {
    static const double DEGREES = 57.295779513082320877; /* of a radian */
    return acos(larger(-1, smaller(1, cosine))) * DEGREES;
}

static void fill_ratios(const pl_ratio_sums *basic, const full_sums *full, planish_quality *q) {
    int64_t n_valid = basic->n_movable + basic->n_fixed;
    q->inverted = basic->inverted;
    q->rms_radius_ratio = root_mean(basic->movable + basic->fixed, n_valid);
    q->rms_radius_ratio_movable = root_mean(basic->movable, basic->n_movable);
    q->fixed_rms_radius_ratio = root_mean(basic->fixed, basic->n_fixed);
    q->n_fixed = full->n_unmovable;
    q->worst_element = -1;
    if (n_valid == 0)
        return;
    q->mean_radius_ratio = full->ratio_sum / (double)n_valid;
    q->max_radius_ratio = full->worst_ratio;
    q->worst_element = full->worst_element;
    q->fixed_max_radius_ratio = full->worst_fixed_ratio;
    q->min_angle_deg = degrees_of_cosine(full->largest_cosine);
    q->max_angle_deg = degrees_of_cosine(full->smallest_cosine);
}

static void fill_histogram(int64_t n_valid, const full_sums *full, planish_quality *q) {
    enum { BINS = PLANISH_HISTOGRAM_BINS };
    memcpy(q->histogram_edges, HISTOGRAM_EDGES, sizeof HISTOGRAM_EDGES);
    for (int i = 0; i < BINS; i++) { /* the first bin also holds what rounding puts below 1 */
        int64_t from = i > 0 ? full->at_least[i] : n_valid;
        q->histogram_counts[i] = from - (i + 1 < BINS ? full->at_least[i + 1] : 0);
    }
}

int pl_measure(int dim, int64_t n_elements, const int32_t *elements, const int8_t *sign,
               const uint8_t *is_free, const double *coordinates, int threads,
               planish_quality *quality, planish_error *error) {
    const mesh_state mesh = {dim, n_elements, elements, sign, is_free, coordinates};
    pl_ratio_sums part[MAX_CHUNKS];
    pass p = begin_pass(&mesh);
    p.basic = part;
    p.full = pl_alloc(p.n_chunks, sizeof *p.full);
    if (!p.full)
        return pl_fail_memory(error, "measuring the mesh");
    pl_parallel_for(threads, n_elements, p.chunk, any_chunk, &p);
    pl_ratio_sums basic = total_basic(&p);
    full_sums full = total_full(&p);
    pl_free(p.full);

    planish_quality q = {.n_elements = n_elements};
    fill_ratios(&basic, &full, &q);
    fill_histogram(basic.n_movable + basic.n_fixed, &full, &q);
    if (n_elements > 0) {
        q.min_volume = full.smallest_volume;
        q.max_volume = full.largest_volume;
        q.total_volume = full.volume_sum;
    }
    *quality = q;
    return 0;
}
