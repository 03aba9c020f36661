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

/* ---- Cells by their corners --------------------------------------------------------------- */

enum { CHUNK_CELLS = 512 }; /* cells that one thread takes at a time */

/** Marks of cells, or of corners. */
typedef struct cell_marks {
    pl_mesh_state mesh;
    const pl_corner_form *form;
    double *ratio;              /* [corners] or NULL: */
    uint8_t *state;             /* [corners] */
    int of_corners;             /* each by itself */
    double limit2, acute_limit; /* see pass, */
    double cell_limit2;         /* and of corners the AR^2 of their cells above which they are */
    int n_positive;             /* corners of the cell under way, */
    double square, acuteness;   /* sum of its mu^2, largest 1 / SJ^2 */
} cell_marks;

static int state_of(const cell_marks *m, int is_valid, double square, double acuteness) {
    return !is_valid                                          ? PL_INVERTED
           : square > m->limit2 || acuteness > m->acute_limit ? PL_WORSE
                                                              : PL_FINE;
}

static void mark_corner(void *user, const pl_corner_block *b, int l, int64_t index) {
    cell_marks *m = user;
    if (m->of_corners)
        m->state[index] =
            (uint8_t)state_of(m, b->of.valid[l] != 0, b->of.square[l], b->acuteness[l]);
    m->n_positive += b->of.valid[l] != 0;
    m->square += b->of.square[l];
    m->acuteness = pl_larger(b->acuteness[l], m->acuteness);
}

static void mark_cell(void *user, int64_t cell, int64_t first, int n) {
    cell_marks *m = user;
    const int is_valid = m->n_positive == n;
    const double square = m->square * (1.0 / n);
    const int state = state_of(m, is_valid, square, m->acuteness);
    const int is_worse = is_valid && square > m->cell_limit2;
    (void)cell;
    for (int64_t i = first; i < first + n; i++) {
        if (m->of_corners)
            m->state[i] = is_worse ? PL_WORSE : m->state[i];
        else if (m->ratio)
            m->ratio[i] = is_valid ? sqrt(pl_larger(1, square)) : 0;
        else
            m->state[i] = (uint8_t)state;
    }
    m->n_positive = 0;
    m->square = m->acuteness = 0;
}

static void mark_chunk_of_cells(void *context, int64_t begin, int64_t end, int thread) {
    cell_marks m = *(const cell_marks *)context;
    (void)thread;
    pl_cells_visit(&m.mesh, m.form, begin, end, mark_corner, mark_cell, &m);
}

static void mark_cells(const pl_view *view, const double *coordinates, int threads, cell_marks *m) {
    pl_corner_form form[PL_N_FORMS];
    pl_corner_forms_make(view->dim, form);
    m->mesh = (pl_mesh_state){view, coordinates};
    m->form = form;
    pl_parallel_for(threads, view->n_cells, CHUNK_CELLS, mark_chunk_of_cells, m);
}

void pl_find_worse_corners(const pl_view *view, const double *coordinates, double ratio,
                           double acuteness, double cell_ratio, int threads, uint8_t *state) {
    cell_marks m = {.state = state,
                    .of_corners = 1,
                    .limit2 = ratio * ratio,
                    .acute_limit = acuteness,
                    .cell_limit2 = cell_ratio * cell_ratio};
    mark_cells(view, coordinates, threads, &m);
}

/* ---- Marks of elements --------------------------------------------------------------------- */

void pl_find_worse(const pl_view *view, const double *coordinates, double ratio, double acuteness,
                   int threads, uint8_t *state) {
    const pl_mesh_state mesh = {view, coordinates};
    if (view->corner) {
        cell_marks m = {.state = state, .limit2 = ratio * ratio, .acute_limit = acuteness};
        mark_cells(view, coordinates, threads, &m);
        return;
    }
    pass p = begin_pass(&mesh);
    p.state = state;
    p.limit2 = ratio * ratio;
    p.acute_limit = acuteness;
    p.blunt = pl_blunt_ratio_square(view->dim, acuteness);
    pl_parallel_for(threads, view->n_elements, p.chunk, any_chunk, &p);
}

void pl_find_ratios(const pl_view *view, const double *coordinates, int threads, double *ratio) {
    const pl_mesh_state mesh = {view, coordinates};
    if (view->corner) {
        cell_marks m = {.ratio = ratio, .limit2 = INFINITY, .acute_limit = INFINITY};
        mark_cells(view, coordinates, threads, &m);
        return;
    }
    pass p = begin_pass(&mesh);
    p.ratio = ratio;
    pl_parallel_for(threads, view->n_elements, p.chunk, any_chunk, &p);
}

/* ---- Elements numbered the other way round ------------------------------------------------ */

enum { FLAT = 0, POSITIVE = 1, NEGATIVE = 2 }; /* signs, between the passes */

enum { N_KINDS = 4 }; /* of cells (geometry/corner.h); simplices are the first */

/** The elements by the signs of their measures, of each kind by itself. */
typedef struct numbering {
    const pl_mesh_state *mesh;
    uint8_t *state;             /* [n_elements] */
    int64_t counts[N_KINDS][2]; /* positive and negative elements; shared */
    uint8_t rarer[N_KINDS];     /* POSITIVE or NEGATIVE */
} numbering;

static int kind_of(const pl_view *view, int64_t element) {
    return view->corner ? pl_corner_kind(view->corner[element]) : 0;
}

/** Sign of the simplex of an element. */
static int sign_of(const pl_mesh_state *mesh, int64_t element) {
    const int dim = mesh->of->dim;
    const double *vertex[4];
    for (int j = 0; j <= dim; j++)
        vertex[j] = mesh->coordinates + (int64_t)mesh->of->elements[element * (dim + 1) + j] * dim;
    return pl_measure_sign(dim, vertex);
}

/** Find the signs of cells: that of all corners, or none. */
static void cell_sign_chunk(void *context, int64_t begin, int64_t end, int thread) {
    numbering *n = context;
    const pl_view *view = n->mesh->of;
    (void)thread;
    for (int64_t cell = begin; cell < end; cell++) {
        const int64_t first = view->cell_begin[cell], last = view->cell_begin[cell + 1];
        const int sign = sign_of(n->mesh, first);
        int is_one = sign != 0;
        for (int64_t i = first + 1; i < last && is_one; i++)
            is_one = sign_of(n->mesh, i) == sign;
        memset(n->state + first,
               !is_one    ? FLAT
               : sign > 0 ? POSITIVE
                          : NEGATIVE,
               (size_t)(last - first));
        if (is_one)
            __atomic_fetch_add(&n->counts[kind_of(view, first)][sign < 0], 1, __ATOMIC_RELAXED);
    }
}

static void sign_chunk(void *context, int64_t begin, int64_t end, int thread) {
    numbering *n = context;
    const pl_view *view = n->mesh->of;
    int64_t n_positive = 0, n_negative = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int counts = !view->is_counted || view->is_counted[i];
        const int sign = sign_of(n->mesh, i);
        n->state[i] = sign > 0 ? POSITIVE : sign < 0 ? NEGATIVE : FLAT;
        n_positive += counts && sign > 0;
        n_negative += counts && sign < 0;
    }
    __atomic_fetch_add(&n->counts[0][0], n_positive, __ATOMIC_RELAXED);
    __atomic_fetch_add(&n->counts[0][1], n_negative, __ATOMIC_RELAXED);
}

static void mark_chunk(void *context, int64_t begin, int64_t end, int thread) {
    numbering *n = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n->state[i] = n->state[i] == n->rarer[kind_of(n->mesh->of, i)];
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
    int64_t n_reversed = 0;
    if (view->corner)
        pl_parallel_for(threads, view->n_cells, CHUNK, cell_sign_chunk, &n);
    else
        pl_parallel_for(threads, view->n_elements, CHUNK, sign_chunk, &n);
    pl_parts_add(n.counts[0], 2); /* a mesh in parts has simplices alone */
    for (int kind = 0; kind < N_KINDS; kind++) {
        n.rarer[kind] = n.counts[kind][0] >= n.counts[kind][1] ? NEGATIVE : POSITIVE;
        n_reversed += count_reversed(n.counts[kind][0], n.counts[kind][1]);
    }
    pl_parallel_for(threads, view->n_elements, CHUNK, mark_chunk, &n);
    return n_reversed;
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

/** Set the edges of the histograms. */
static void fill_edges(planish_quality *q) {
    memcpy(q->histogram_edges, PL_HISTOGRAM_EDGES, sizeof PL_HISTOGRAM_EDGES);
    for (int i = 0; i <= PLANISH_ANGLE_BINS; i++)
        q->angle_edges_deg[i] = PL_ANGLE_BIN_DEGREES * i;
}

/* ---- The same of cells ---------------------------------------------------------------------- */

/** Measures of a cell: AR, the mean ratio 1 / AR, and of its corners the least scaled Jacobian, of its
 *  edges the longest to the shortest. */
enum { OF_RATIO, OF_MEAN, OF_JACOBIAN, OF_EDGES, OF_VOLUME, N_OF_CELL };

/** Figures of the cells that a thread has seen. */
typedef struct cell_figures {
    pl_mesh_state mesh;
    const pl_corner_form *form;
    pl_sum square[2], sum[N_OF_CELL]; /* AR^2 by [movable] */
    double min[N_OF_CELL], max[N_OF_CELL], max_by[2];
    int64_t n[2], n_inverted, n_fixed, n_signed[N_KINDS][2], histogram[PLANISH_HISTOGRAM_BINS];
    double worst;      /* AR^2, */
    int64_t worst_one; /* and its first corner, -1: none */
    /* The cell under way: */
    int n_positive, n_listed[2], is_movable;
    double of_square, acuteness, shortest, longest, volume;
} cell_figures;

static void begin_cell(cell_figures *f) {
    f->n_positive = f->n_listed[0] = f->n_listed[1] = f->is_movable = 0;
    f->of_square = f->acuteness = f->volume = 0;
    f->shortest = INFINITY;
    f->longest = 0;
}

static void take_corner(void *user, const pl_corner_block *b, int l, int64_t index) {
    cell_figures *f = user;
    const pl_view *view = f->mesh.of;
    double shortest = INFINITY, longest = 0;
    int real[6];
    pl_corner_edges(b, l, view->dim, view->corner[index], real, &shortest, &longest);
    f->n_positive += b->of.valid[l] != 0;
    f->n_listed[0] += b->of.listed[l] > 0;
    f->n_listed[1] += b->of.listed[l] < 0;
    f->is_movable |= b->of.is_movable[l] != 0;
    f->of_square += b->of.square[l];
    f->volume += b->of.volume[l];
    f->acuteness = pl_larger(b->acuteness[l], f->acuteness);
    f->shortest = pl_smaller(shortest, f->shortest);
    f->longest = pl_larger(longest, f->longest);
}

static void add_value(cell_figures *f, int which, double value) {
    pl_sum_add(&f->sum[which], value);
    f->min[which] = pl_smaller(value, f->min[which]);
    f->max[which] = pl_larger(value, f->max[which]);
}

static void take_cell(void *user, int64_t cell, int64_t first, int n) {
    cell_figures *f = user;
    const double square = f->of_square * (1.0 / n), ratio = sqrt(square);
    const int kind = kind_of(f->mesh.of, first), movable = f->is_movable;
    int bin = 0;
    (void)cell;
    f->n_signed[kind][0] += f->n_listed[0] == n;
    f->n_signed[kind][1] += f->n_listed[1] == n;
    f->n_fixed += !movable;
    f->n_inverted += f->n_positive < n;
    add_value(f, OF_VOLUME, f->volume * (1.0 / n));
    if (f->n_positive == n) {
        while (bin + 1 < PLANISH_HISTOGRAM_BINS && ratio >= PL_HISTOGRAM_EDGES[bin + 1])
            bin++;
        f->histogram[bin]++;
        f->n[movable]++;
        pl_sum_add(&f->square[movable], square);
        f->max_by[movable] = pl_larger(ratio, f->max_by[movable]);
        add_value(f, OF_RATIO, ratio);
        add_value(f, OF_MEAN, 1 / ratio);
        add_value(f, OF_JACOBIAN, 1 / sqrt(f->acuteness));
        add_value(f, OF_EDGES, sqrt(f->longest / f->shortest));
        if (square > f->worst || (square == f->worst && first < f->worst_one)) {
            f->worst = square;
            f->worst_one = first;
        }
    }
    begin_cell(f);
}

static void figures_chunk(void *context, int64_t begin, int64_t end, int thread) {
    cell_figures *f = (cell_figures *)context + thread;
    pl_cells_visit(&f->mesh, f->form, begin, end, take_corner, take_cell, f);
}

/** Add the figures of a thread to those of all. */
static void add_figures(cell_figures *part, cell_figures *all) {
    for (int k = 0; k < 2; k++) {
        pl_sum_merge(&all->square[k], &part->square[k]);
        all->n[k] += part->n[k];
        all->max_by[k] = pl_larger(part->max_by[k], all->max_by[k]);
    }
    for (int k = 0; k < N_OF_CELL; k++) {
        pl_sum_merge(&all->sum[k], &part->sum[k]);
        all->min[k] = pl_smaller(part->min[k], all->min[k]);
        all->max[k] = pl_larger(part->max[k], all->max[k]);
    }
    for (int k = 0; k < N_KINDS * 2; k++)
        all->n_signed[k / 2][k % 2] += part->n_signed[k / 2][k % 2];
    for (int k = 0; k < PLANISH_HISTOGRAM_BINS; k++)
        all->histogram[k] += part->histogram[k];
    all->n_inverted += part->n_inverted;
    all->n_fixed += part->n_fixed;
    if (part->worst > all->worst || (part->worst == all->worst && part->worst_one < all->worst_one))
        all->worst_one = part->worst_one; /* the lowest cell wins a tie */
    all->worst = pl_larger(part->worst, all->worst);
}

static planish_spread spread_of(const cell_figures *f, int which, double n) {
    if (!(n > 0))
        return (planish_spread){0, 0, 0};
    return (planish_spread){f->min[which], pl_sum_value(&f->sum[which]) / n, f->max[which]};
}

static void fill_cells(const cell_figures *f, int64_t n_cells, planish_quality *q) {
    const double movable = pl_sum_value(&f->square[1]), fixed = pl_sum_value(&f->square[0]);
    const int64_t n = f->n[0] + f->n[1];
    *q = (planish_quality){.n_elements = n_cells,
                           .n_inverted = f->n_inverted,
                           .n_fixed_elements = f->n_fixed,
                           .rms_radius_ratio = root_mean(movable + fixed, n),
                           .rms_radius_ratio_movable = root_mean(movable, f->n[1]),
                           .fixed_rms_radius_ratio = root_mean(fixed, f->n[0]),
                           .max_radius_ratio_movable = f->max_by[1],
                           .fixed_max_radius_ratio = f->max_by[0],
                           .worst_element = f->worst_one,
                           .radius_ratio = spread_of(f, OF_RATIO, (double)n),
                           .mean_ratio = spread_of(f, OF_MEAN, (double)n),
                           .scaled_jacobian = spread_of(f, OF_JACOBIAN, (double)n),
                           .edge_ratio = spread_of(f, OF_EDGES, (double)n),
                           .min_volume = f->min[OF_VOLUME] + 0.0, /* one zero, not one of two */
                           .max_volume = f->max[OF_VOLUME] + 0.0,
                           .total_volume = pl_sum_value(&f->sum[OF_VOLUME])};
    q->mean_radius_ratio = q->radius_ratio.mean;
    q->max_radius_ratio = q->radius_ratio.max;
    memcpy(q->histogram_counts, f->histogram, sizeof f->histogram);
    for (int kind = 0; kind < N_KINDS; kind++)
        q->n_reversed += count_reversed(f->n_signed[kind][0], f->n_signed[kind][1]);
    fill_edges(q);
}

static int measure_cells(const pl_view *view, const double *coordinates, int threads,
                         planish_quality *quality, planish_error *error) {
    pl_corner_form form[PL_N_FORMS];
    cell_figures *figures = pl_alloc_zero(threads, sizeof *figures);
    if (!figures)
        return pl_fail_memory(error, "measuring the mesh");
    pl_corner_forms_make(view->dim, form);
    for (int t = 0; t < threads; t++) {
        cell_figures *f = &figures[t];
        f->mesh = (pl_mesh_state){view, coordinates};
        f->form = form;
        f->worst_one = -1;
        for (int k = 0; k < N_OF_CELL; k++) {
            f->min[k] = INFINITY;
            f->max[k] = -INFINITY;
        }
        begin_cell(f);
    }
    pl_parallel_for(threads, view->n_cells, CHUNK_CELLS, figures_chunk, figures);
    for (int t = 1; t < threads; t++)
        add_figures(&figures[t], figures);
    fill_cells(figures, view->n_cells, quality);
    pl_free(figures);
    return PLANISH_OK;
}

/* ---- The same of simplices ------------------------------------------------------------------ */

int pl_measure(const pl_view *view, const double *coordinates, int threads,
               planish_quality *quality, planish_error *error) {
    enum { BINS = PLANISH_HISTOGRAM_BINS };
    if (view->corner)
        return measure_cells(view, coordinates, threads, quality, error);
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
    fill_edges(&q);
    for (int i = 0; i < BINS; i++) { /* the first bin also holds what rounding puts below 1 */
        const int64_t from = i > 0 ? full.count[PL_AT_LEAST + i] : n_valid;
        q.histogram_counts[i] = from - (i + 1 < BINS ? full.count[PL_AT_LEAST + i + 1] : 0);
    }
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
