/* kernel_gather: a star from the mesh into scratch.
 *
 *   fetch_ahead                    ask for the memory of a later visit
 *   gather, gather_rows            the star, and its further rows
 *   column_doubles, position_doubles, padded_to_lanes    the scratch that it needs
 *   power_of_two, exponent_of      scales
 */
#ifndef PL_STAR_KERNEL_GATHER_H
#define PL_STAR_KERNEL_GATHER_H

#include "geometry/fetch.h"
#include "geometry/simplex.h"
#include "star/kernel_link_edges.h"

#include <string.h>

/** Return 2^exponent, for exponents of normal doubles. */
static inline double power_of_two(int exponent) {
    uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/** Exponent of a normal double. */
static inline int exponent_of(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return (int)(bits >> 52 & 0x7ff) - 1023;
}

/** Positions of a facet in the problem's link. */
static inline int64_t positions_of(const pl_star_problem *problem, int dim) {
    return pl_link_positions(dim, PL_KERNEL != PL_RADIUS && problem->link_form);
}

/* Stars that are asked for ahead of their visits: on meshes that outgrow the caches the visit would
 * wait for them, and for memory that a thread on a far core has written or read. */
enum { AHEAD = 3, MOST_AHEAD = 64 }; /* of a giant ring only the first nodes */

/** Ask for the memory that the visit of the star with this index reads and writes: its node, the
 *  flags around and, for mean ratios, its link; nothing from end on. */
PL_INLINE void fetch_ahead(const pl_star_problem *problem, int64_t index, int64_t end,
                           const int dim) {
    if (index >= end)
        return;
    const int64_t begin = problem->ring_offset[index];
    int64_t n = problem->ring_offset[index + 1] - begin;
    n = n < MOST_AHEAD ? n : MOST_AHEAD;
    for (int64_t i = begin; i < begin + n; i++) {
        pl_fetch_node(dim, problem->coordinates, problem->ring[i]);
        pl_fetch_to_write(&problem->changed[problem->ring[i]]);
    }
    const double *place = problem->coordinates + (int64_t)problem->node[index] * dim;
    pl_fetch_to_write(place);
    pl_fetch_to_write(place + dim - 1);
    pl_fetch_to_write(&problem->changed[problem->node[index]]);
    if (PL_KERNEL != PL_MEAN)
        return;
    /* Links follow one another. The hardware sees that while visits are all there is, but not while
     * moves of cells are judged between them. */
    const int64_t facet = problem->link_offset[index];
    const int64_t n_facets = problem->link_offset[index + 1] - facet;
    const uint8_t *low = pl_link_at(&problem->link, positions_of(problem, dim), facet).low;
    pl_fetch_all(low, low + n_facets * dim);
    if (problem->link_form)
        pl_fetch_all(problem->link_form + facet, problem->link_form + facet + n_facets);
    for (int64_t i = 0; problem->target && i < n_facets && i < MOST_AHEAD; i++)
        pl_fetch(&problem->target[problem->link_element[facet + i]]);
}

/** Choose the scale that the star has with its node at x, from half of the largest difference of a
 *  coordinate; half, because the whole could overflow. Return its exponent. */
static inline int choose_scale(const pl_star_problem *problem, const star *s, const double *x,
                               const int dim) {
    const point_row at = row_of(x, dim);
    lanes extent[PL_PACKS];
    for (int k = 0; k < PL_PACKS; k++)
        extent[k] = lanes_of(0);
    for (int64_t i = 0; i < s->n_ring; i++) {
        const point_row p = row_of(problem->coordinates + (int64_t)s->ring[i] * dim, dim);
        for (int k = 0; k < PL_PACKS; k++)
            extent[k] = lanes_max(lanes_abs(p.pack[k] * lanes_of(0.5) - at.pack[k] * lanes_of(0.5)),
                                  extent[k]);
    }
    return -pl_scale_exponent(exponent_of(lanes_largest(extent)));
}

/** Copy the ring's coordinates to ring [n_ring][PL_ROW], scaled: by 2^*exponent, or NULL, and the
 *  scale is chosen. */
PL_INLINE void gather_ring(const pl_star_problem *problem, star *s, const double *x,
                           const int *exponent, double *ring, const int dim) {
    const int power = exponent ? *exponent : choose_scale(problem, s, x, dim);
    s->scale = power_of_two(power);
    s->unscale = power_of_two(-power);
    for (int64_t i = 0; i < s->n_ring; i++) {
        const double *p = problem->coordinates + (int64_t)s->ring[i] * dim;
        double *row = ring + PL_ROW * i;
#if PL_PACK == 4 && defined(__AVX__)
        /* By pairs, as points_to_columns reads it soon after. A load that is wider than the stores
         * before it waits until these have left the core. */
        const __m128d f = _mm_set1_pd(s->scale);
        const __m128d last = dim == 3 ? _mm_load_sd(p + 2) : _mm_setzero_pd();
        _mm_store_pd(row, _mm_mul_pd(_mm_loadu_pd(p), f));
        _mm_store_pd(row + 2, _mm_mul_pd(last, f));
#else
        point_row scaled = row_of(p, dim);
        for (int k = 0; k < PL_PACKS; k++)
            scaled.pack[k] *= lanes_of(s->scale);
        row_store(row, scaled);
#endif
    }
}

/* Floors are kept within this and its inverse, of stars of a size of about 1: nothing over- or
 * underflows, and which elements are above and below is the same. */
#define FLOOR_LEAST 1e-100

/** The least D of an element with its own minimum volume, or else the general one; per_volume: D of
 *  a volume of 1. Times scale dim times, one by one: the volume is of the size of the star. */
static inline double floor_of(const pl_star_problem *problem, const star *s, double own,
                              double per_volume, const int dim) {
    double volume = own > 0 ? own : problem->guard->min_volume, least = volume;
    for (int d = 0; d < dim; d++)
        least *= s->scale;
    least *= per_volume;
    if (!(volume > 0))
        return 0;
    least = least > FLOOR_LEAST ? least : FLOOR_LEAST;
    return least < 1 / FLOOR_LEAST ? least : 1 / FLOOR_LEAST;
}

/** Fill in the columns FLOOR and INVERSE_FLOOR; first: the star's first link facet of all. By
 * packs, as they are read soon after: a load that is wider than the stores before it waits for
 * them. */
PL_INLINE void gather_floors(const pl_star_problem *problem, const star *s, int64_t first,
                             const int dim) {
    const double *own = problem->guard->link_min_volume;
    const double of_simplex = dim == 3 ? 6 : 2;
    double per_volume = s->form ? 1 / s->forms[s->form[0]].volume : of_simplex;
    double floor = floor_of(problem, s, own ? own[first] : 0, per_volume, dim);
    double inverse_floor = floor > 0 ? 1 / floor : 0;
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        store(s, FLOOR, i, lanes_of(floor)); /* of all, or of facet 0 and the padding */
        store(s, INVERSE_FLOOR, i, lanes_of(inverse_floor));
    }
    const int differ = own || (s->form && floor > 0);
    for (int64_t i = 1; differ && i < s->n_facets; i++) {
        per_volume = s->form ? 1 / s->forms[s->form[i]].volume : of_simplex;
        *entry(s, FLOOR, i) = floor_of(problem, s, own ? own[first + i] : 0, per_volume, dim);
        *entry(s, INVERSE_FLOOR, i) = *entry(s, FLOOR, i) > 0 ? 1 / *entry(s, FLOOR, i) : 0;
    }
    if (problem->guard->penalty > 0) {
        for (int64_t i = 0; i < s->padded; i++)
            *entry(s, SHIFT, i) = problem->guard->link_shift[first + (i < s->n_facets ? i : 0)];
    }
}

/* ---- scratch ------------------------------------------------------------------------------- */

/** Return n rounded up to a multiple of PL_LANES. */
static inline int64_t padded_to_lanes(int64_t n) {
    return (n + PL_LANES - 1) / PL_LANES * PL_LANES;
}

/** Size of all columns, in doubles; in 2-D the last columns are not used. */
static inline int64_t column_doubles(int64_t padded) {
    return padded * COLUMNS_3D;
}

/** Room for n further rows, in doubles; what follows is aligned as they are. */
static inline int64_t more_doubles(int64_t n) {
    return (n * (int64_t)(sizeof(pl_star_row) / sizeof(double)) + 7) / 8 * 8;
}

/* Numbers of an edge: its columns, area and shared weight, and row. */
enum { EDGE_DOUBLES = EDGE_COLUMNS + 2 + PL_ROW };

/** Room for the positions of the facets' nodes, of their edges (or their forms) and of the edges'
 *  nodes, in doubles; what follows is aligned to a row. */
static inline int64_t position_doubles(int64_t padded, int64_t padded_edges, int dim) {
    const int64_t positions = padded * (dim == 3 ? 6 : 3) + padded_edges * 2;
    return padded_to_lanes(positions * (int64_t)sizeof(uint32_t) / (int64_t)sizeof(double) + 1);
}

/* ---- the whole ----------------------------------------------------------------------------- */

/** Positions from .. from + n count of a link, as rows, padded with copies of the first count.
 * Always inlined: without knowing count, a star takes half as long again. */
PL_INLINE void unpack(const pl_link *link, int64_t from, int64_t n, int64_t padded, int count,
                      uint32_t *row) {
    const uint8_t *low = link->low + from;
    for (int64_t i = 0; i < n * count; i++)
        row[i] = (uint32_t)low[i] * PL_ROW;
    if (link->high)
        for (int64_t i = 0; i < n * count; i++)
            row[i] += ((uint32_t)link->high[from + i] << 8) * PL_ROW;
    for (int64_t i = n * count; i < padded * count; i++)
        row[i] = row[i % count];
}

/* Forms of facets of simplices, where a problem has none. */
static const pl_corner_form SIMPLEX_FORM[2] = {
    {.weight = {1, 1, 1},
     .factor = ROOT_OF_FACTOR_2D * ROOT_OF_FACTOR_2D,
     .share = 1,
     .determinant = 0.86602540378443865,
     .volume = 1.0 / 2,
     .corner = -1,
     .is_edge = {1, 1, 1},
     .row = {0.5, 0, 2 * ROOT_OF_FACTOR_2D, 1, 1.5 * ROOT_OF_FACTOR_2D}},
    {.weight = {1, 1, 1, 1, 1, 1},
     .factor = ROOT_OF_FACTOR_3D * ROOT_OF_FACTOR_3D,
     .share = 1,
     .determinant = 0.70710678118654752,
     .volume = 1.0 / 6,
     .corner = -1,
     .is_edge = {1, 1, 1, 1, 1, 1},
     .row = {1.0 / 3, 1.0 / 3, 3 * ROOT_OF_FACTOR_3D, 1, 4 * ROOT_OF_FACTOR_3D / 3,
             4 * ROOT_OF_FACTOR_3D / 3, 4 * ROOT_OF_FACTOR_3D / 3}},
};

/** Fill rows [padded] with the forms of n facets; code NULL: all are 0. */
PL_INLINE void unpack_forms(const uint8_t *code, int64_t n, int64_t padded, uint32_t *row) {
    for (int64_t i = 0; i < n; i++)
        row[i] = code ? code[i] : 0;
    for (int64_t i = n; i < padded; i++)
        row[i] = row[0];
}

/** Fill in the parts of the forms of facets that objectives of edges and scaled Jacobians need. */
PL_NOINLINE void gather_corners(const star *s, const int dim) {
    for (int64_t i = 0; i < s->padded; i++) {
        const pl_corner_form *f = &s->forms[s->form[i]];
        int count = 0;
        for (int k = 0; k < dim * (dim + 1) / 2; k++) {
            *entry(s, IS_EDGE + k, i) = f->is_edge[k];
            count += f->is_edge[k];
        }
        *entry(s, EDGE_SHARE, i) = 1.0 / count;
        for (int v = 0; v <= dim; v++) /* all nodes of a simplex */
            *entry(s, IS_CORNER + v, i) =
                f->corner == v - 1 || pl_corner_kind((uint8_t)s->form[i]) == PL_KIND_SIMPLEX;
        *entry(s, JACOBIAN, i) = f->determinant * f->determinant;
    }
}

/** Find the lengths of the normals of facets. */
PL_INLINE void gather_lengths(const star *s) {
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        const vec3 n = vec3_load(s, NX, NY, NZ, i);
        store(s, LENGTH, i, lanes_sqrt(vec3_dot(n, n)));
    }
}

/** Whether an objective is made of single edges of corners. */
static inline int is_of_edges(const pl_star_guard *guard) {
    return guard->objective == PLANISH_OBJECTIVE_EDGE_RATIO ||
           guard->objective == PL_WORST_JACOBIAN;
}

/** Fill the columns of facets with forms from their nodes in ring [.][PL_ROW]; return the sum of their
 *  weights. */
PL_INLINE double gather_forms(const star *s, const double *ring, const int guarded, const int dim) {
    lanes weight[PL_PACKS];
    if (dim == 3)
        facets_3d(s, ring, guarded, 1);
    else
        facets_2d(s, ring, 1);
    for (int64_t i = s->n_facets; i < s->padded; i++)
        *entry(s, WEIGHT, i) = *entry(s, IS_FACET, i) = 0;
    for (int k = 0; k < PL_PACKS; k++)
        weight[k] = lanes_of(0);
    for (int64_t i = 0; i < s->padded; i += PL_LANES)
        for (int k = 0; k < PL_PACKS; k++)
            weight[k] += load(s, WEIGHT, i + k * PL_PACK);
    if (guarded && dim == 3)
        gather_lengths(s);
    return lanes_sum(weight);
}

/** Gather forms for the guarded kernel: not inlined, or simplices would take a tenth longer. */
PL_NOINLINE double gather_guarded_forms(const star *s, const double *ring, const int dim) {
    return dim == 3 ? gather_forms(s, ring, 1, 3) : gather_forms(s, ring, 1, 2);
}

/* e0 of rows without weight: mu^2 underflows to 0. */
#define ROW_NOTHING 1e-200

/* Of a corner's nodes in their order, by the last three bits of a form's code: which of the facet's
 * nodes each is; SELF: that of the star. */
enum { SELF = 3 };
static const uint8_t CORNER_ORDER[2][8][4] = {
    {{SELF, 0, 1}, {SELF, 1, 0}, {0, SELF, 1}, {1, SELF, 0}, {0, 1, SELF}, {1, 0, SELF}},
    {{SELF, 0, 1, 2},
     {SELF, 0, 2, 1},
     {0, SELF, 1, 2},
     {0, SELF, 2, 1},
     {0, 1, SELF, 2},
     {0, 2, SELF, 1},
     {0, 1, 2, SELF},
     {0, 2, 1, SELF}}};

/* By the place of the star's node in the corner: what the rows of V count in its slope. */
static const _Alignas(64) double ROWS_OF_SLOPE[4][PL_ROW] = {
    {-1, -1, -1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};

/** Pack of corners with targets. */
typedef struct wanted_corners {
    uint32_t node[PL_PACK][4]; /* rows of their nodes in the ring, in the corners' order */
    lanes target[8];           /* as pl_target */
    lanes metric[8];           /* as pl_metric */
    lanes row[PL_ROW];         /* what the rows of V count in the slope of the star's node */
} wanted_corners;

/** Load the corners of the facets from i on; self: the row of the star's node. Whole rows are loaded, and
 *  exchanged in registers: to put together what single stores have left would be waited for. */
PL_INLINE void load_wanted(const star *s, const pl_star_problem *problem, int64_t first, int64_t i,
                           uint32_t self, wanted_corners *w, const int dim) {
    point_row low[PL_PACK], high[PL_PACK], slope[PL_PACK];
    for (int k = 0; k < PL_PACK; k++) {
        const int64_t facet = i + k < s->n_facets ? i + k : 0;
        const pl_target *target = &problem->target[problem->link_element[first + facet]];
        const uint32_t code = s->form[facet] & 7;
        uint32_t of_facet[4] = {[SELF] = self};
        for (int j = 0; j < dim; j++)
            of_facet[j] = s->facet[facet * dim + j];
        for (int j = 0; j <= dim; j++)
            w->node[k][j] = of_facet[CORNER_ORDER[dim - 2][code][j]];
        low[k] = row_load(target->v);
        high[k] = row_load(target->v + PL_ROW);
        slope[k] = row_load(ROWS_OF_SLOPE[code >> 1]);
    }
    rows_to_columns(low, w->target);
    rows_to_columns(high, w->target + PL_ROW);
    rows_to_columns(slope, w->row);
}

/** Load the metrics of the facets from i on into w and their columns. */
PL_INLINE void load_metric(const star *s, const pl_star_problem *problem, int64_t first, int64_t i,
                           wanted_corners *w) {
    point_row low[PL_PACK], high[PL_PACK];
    for (int k = 0; k < PL_PACK; k++) {
        const int64_t facet = i + k < s->n_facets ? i + k : 0;
        const pl_metric *metric = &problem->metric[problem->link_element[first + facet]];
        low[k] = row_load(metric->l);
        high[k] = row_load(metric->l + PL_ROW);
    }
    rows_to_columns(low, w->metric);
    rows_to_columns(high, w->metric + PL_ROW);
    for (int k = 0; k < PL_MOST_SYMMETRIC; k++)
        store(s, METRIC + k, i, w->metric[k]);
}

/** Return |L f|^2. */
PL_INLINE lanes square_in_metric(const lanes l[6], const lanes f[3], const int dim) {
    lanes square = lanes_of(0);
    for (int r = 0, k = 0; r < dim; r++) {
        lanes y = lanes_of(0);
        for (int c = r; c < dim; c++, k++)
            y += l[k] * f[c];
        square += y * y;
    }
    return square;
}

/** Compute the constants of the facets from i on, whose corners have the edges e, with the star's node at
 *  x: with its slope (pl_target_slopes) and t = T slope, x - o = t / |slope|^2, in any metric. */
PL_INLINE void store_wanted(const star *s, int64_t i, const wanted_corners *w, const lanes e[3][3],
                            const lanes *x, const int has_metric, const int dim) {
    static const uint8_t place[3] = {P0X, P0Y, P0Z};
    const lanes root = lanes_of(1.0 / dim);
    lanes t[3], c = lanes_of(0), energy = lanes_of(0), of_t = lanes_of(0);
    for (int d = 0; d < dim; d++)
        t[d] = lanes_of(0);
    for (int k = 0; k < dim; k++) {
        lanes slope = w->row[0] * w->target[k], column[3];
        for (int d = 0; d < dim; d++)
            column[d] = e[0][d] * w->target[k];
        for (int j = 1; j <= k; j++) {
            const lanes v = w->target[j * dim - j * (j + 1) / 2 + k];
            slope += w->row[j] * v;
            for (int d = 0; d < dim; d++)
                column[d] += e[j][d] * v;
        }
        c += slope * slope;
        for (int d = 0; d < dim; d++) {
            if (!has_metric)
                energy += column[d] * column[d];
            t[d] += column[d] * slope;
        }
        if (has_metric)
            energy += square_in_metric(w->metric, column, dim);
    }
    const lanes inverse = lanes_of(1) / c;
    for (int d = 0; d < dim; d++) {
        store(s, OX + d, i, (load(s, place[d], i) - x[d]) + t[d] * inverse);
        of_t += t[d] * t[d];
    }
    if (has_metric)
        of_t = square_in_metric(w->metric, t, dim);
    store(s, FORM_C, i, root * c);
    store(s, FORM_E0, i, lanes_max(root * (energy - of_t * inverse), lanes_of(ROW_NOTHING)));
}

/** Body of gather_targets, inlined where dim is constant. */
PL_INLINE void gather_targets_of(const star *s, const pl_star_problem *problem, int64_t first,
                                 double *ring, const double *place, const int has_metric,
                                 const int dim) {
    const uint32_t self = (uint32_t)s->n_ring * PL_ROW;
    double scaled[3] = {0}, measure = 1;
    lanes x[3];
    for (int d = 0; d < dim; d++) {
        scaled[d] = place[d] * s->scale;
        x[d] = lanes_of(scaled[d]);
        measure *= s->scale;
    }
    row_store(ring + self, row_of(scaled, dim));
    for (int64_t i = 0; i < s->padded; i += PL_PACK) {
        wanted_corners w;
        lanes p[4][PL_ROW], e[3][3];
        load_wanted(s, problem, first, i, self, &w, dim);
        if (has_metric)
            load_metric(s, problem, first, i, &w);
        for (int j = 0; j <= dim; j++)
            points_to_columns(ring, &w.node[0][j], 4, p[j]);
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                e[j][d] = p[j + 1][d] - p[0][d];
        store_wanted(s, i, &w, e, x, has_metric, dim);
        if (s->size_weight > 0) {
            store(s, UNIT, i, w.target[6] * lanes_of(1 / measure));
            store(s, WANTED, i, w.target[7] * lanes_of(measure));
        }
    }
}

/** Replace ideal corners by targets. place: of the star's node; ring [.][PL_ROW]: its neighbours,
 *  with room for one more behind them. Not inlined: few meshes have them. */
PL_NOINLINE void gather_targets(const star *s, const pl_star_problem *problem, int64_t first,
                                double *ring, const double *place, const int dim) {
    if (s->has_metric && dim == 3)
        gather_targets_of(s, problem, first, ring, place, 1, 3);
    else if (s->has_metric)
        gather_targets_of(s, problem, first, ring, place, 1, 2);
    else if (dim == 3)
        gather_targets_of(s, problem, first, ring, place, 0, 3);
    else
        gather_targets_of(s, problem, first, ring, place, 0, 2);
}

/* A further row is seen as a facet with p0 this far from the node, in sizes of the star: |x - p0| is
 * about the same wherever the node goes, and so is what rounding does to D. */
#define ROW_FAR 16.0
/* How well numbers of a row are known: an element's coefficients are sums of some products. */
#define ROW_ROUNDING 0x1p-46

/** Make the row a facet, with the star's node at x (scaled): P0 and n such that D = base + n . (x -
 *  p0), and o such that E = c |x - o|^2 + e0. */
static inline void gather_row(const star *s, const pl_star_row *row, int64_t i, const double *x,
                              const int dim) {
    static const uint8_t first[3] = {P0X, P0Y, P0Z};
    const double root = sqrt(row->factor), area = dim == 3 ? s->scale * s->scale : s->scale;
    const double c = row->weight > 0 ? root * row->c : 0;
    double base = row->D0 * area * s->scale, e0 = root * row->e * s->scale * s->scale;
    double n[3] = {0, 0, 0}, square = 0;
    for (int d = 0; d < dim; d++) {
        const double p = d == 0 ? x[0] - ROW_FAR : x[d];
        const double to = c > 0 ? row->slope_e[d] * s->scale / row->c : 0; /* x - o */
        n[d] = row->slope_d[d] * area;
        base -= n[d] * (x[d] - p);
        e0 -= c * to * to;
        square += n[d] * n[d];
        *entry(s, first[d], i) = p;
        *entry(s, OX + d, i) = p - x[d] + to;
    }
    if (dim == 3) {
        for (int d = 0; d < 3; d++)
            *entry(s, NX + d, i) = n[d];
    } else {
        *entry(s, P1X, i) = *entry(s, P0X, i) + n[1];
        *entry(s, P1Y, i) = *entry(s, P0Y, i) - n[0];
    }
    const double error =
        ROW_ROUNDING *
        (fabs(base) + ROW_FAR * sqrt(square) + (dim == 2 ? fabs(x[0]) + fabs(x[1]) + ROW_FAR : 0)) /
        ROW_FAR;
    *entry(s, LENGTH, i) = sqrt(square);
    *entry(s, ROUNDING, i) = error * error;
    *entry(s, BASE, i) = base;
    *entry(s, UNIT, i) = *entry(s, WANTED, i) = 0;
    for (int k = 0; s->has_metric && k < PL_MOST_SYMMETRIC; k++)
        *entry(s, METRIC + k, i) = pl_metric_identity(dim).l[k];
    *entry(s, FORM_C, i) = c;
    *entry(s, FORM_E0, i) = row->weight > 0 && e0 > 0 ? e0 : ROW_NOTHING;
    *entry(s, WEIGHT, i) = row->weight;
}

/** Fill in the guarded kernel's columns of a row: no floor, and one edge, of which no measure is. */
static inline void gather_guarded_row(const star *s, int64_t i, const int dim) {
    static const uint8_t first[3] = {P0X, P0Y, P0Z};
    for (int d = 0; dim == 3 && d < 3; d++) {
        const int column[2][3] = {{P1X, P1Y, P1Z}, {P2X, P2Y, P2Z}};
        *entry(s, column[0][d], i) = *entry(s, column[1][d], i) = *entry(s, first[d], i);
    }
    for (int k = 0; !s->has_metric && k < 6; k++)
        *entry(s, IS_EDGE + k, i) = k == 0;
    for (int j = 0; j < 4; j++)
        *entry(s, IS_CORNER + j, i) = 0;
    *entry(s, EDGE_SHARE, i) = 1;
    *entry(s, JACOBIAN, i) = 0;
    *entry(s, FLOOR, i) = *entry(s, INVERSE_FLOOR, i) = *entry(s, SHIFT, i) = 0;
}

/** Append the further rows at the start of scratch to the facets, and return the sum of all weights.
 *  Not inlined: few stars have some. */
PL_NOINLINE double gather_rows(const star *s, const pl_star_row *row, const double *place,
                               const int guarded, const int dim) {
    double x[3] = {0, 0, 0}, weight = s->weight;
    for (int d = 0; d < dim; d++)
        x[d] = place[d] * s->scale;
    for (int64_t r = 0; r < s->n_more; r++) {
        gather_row(s, &row[r], s->n_facets + r, x, dim);
        weight += row[r].weight;
        if (guarded)
            gather_guarded_row(s, s->n_facets + r, dim);
    }
    return weight;
}

/** Gather star index of problem, with its node at x (as in the mesh), into scratch; exponent of its
 * scale, or NULL. Inlined, like the sums over a star: what they return is not handed over through
 * memory then. One piece, although long: in parts that take s by address visits took longer. */
PL_INLINE star gather(const pl_star_problem *problem, int64_t index, const double *x,
                      const int *exponent, double *scratch, const int guarded, const int dim) {
    star s;
    const int64_t first = problem->link_offset[index];
    const pl_link link = pl_link_at(&problem->link, positions_of(problem, dim), first);
    pl_star_row *more = NULL;
    s.n_facets = problem->link_offset[index + 1] - first;
    s.n_more = 0;
    if (PL_KERNEL != PL_RADIUS && problem->more) {
        more = (pl_star_row *)(void *)scratch;
        scratch += more_doubles(problem->max_more);
        s.n_more = problem->has_more[index] ? problem->more(problem->more_user, index, more) : 0;
    }
    s.padded = padded_to_lanes(s.n_facets + s.n_more);
    s.ring = problem->ring + problem->ring_offset[index];
    s.n_ring = problem->ring_offset[index + 1] - problem->ring_offset[index];
    const int64_t n_edges = pl_link_edges(dim, s.n_facets);
    s.padded_edges = padded_to_lanes(n_edges);
    s.column = scratch;
    s.edge = s.column + column_doubles(s.padded);
    s.area = s.edge + s.padded_edges * EDGE_COLUMNS;
    s.shared = s.area + s.padded_edges;
    s.edge_row = s.shared + s.padded_edges;
    double *positions = s.edge_row + s.padded_edges * PL_ROW;
    s.spare = positions + position_doubles(s.padded, s.padded_edges, dim);
    uint32_t *rows = (uint32_t *)(void *)positions;
    double *ring = s.spare; /* no longer needed once the columns are filled */
    gather_ring(problem, &s, x, exponent, ring, dim);
    unpack(&link, 0, s.n_facets, s.padded, dim, rows);
    s.facet = rows;
    s.form = NULL;
    s.size_weight = problem->target ? problem->size_weight : 0;
    s.has_metric = PL_KERNEL != PL_RADIUS && problem->metric != NULL;
    s.forms = problem->form;
    if (PL_KERNEL != PL_RADIUS && (problem->link_form || more)) {
        const uint8_t *code = problem->link_form ? problem->link_form + first : NULL;
        uint32_t *of_forms = rows + dim * s.padded;
        unpack_forms(code, s.n_facets, s.padded, of_forms);
        s.form = of_forms;
        s.forms = code ? problem->form : &SIMPLEX_FORM[dim - 2];
    }
    /* What is not inlined gets a copy: s itself stays in registers. */
    s.facet_edge = NULL;
    if (guarded && has_forms(&s)) {
        const star copy = s;
        s.weight = gather_guarded_forms(&copy, ring, dim);
    } else if (has_forms(&s)) {
        s.weight = gather_forms(&s, ring, 0, dim);
    } else if (dim == 3) {
        uint32_t *of_facets = rows + 3 * s.padded, *of_edges = of_facets + 3 * s.padded;
        s.facet_edge = of_facets;
        facets_3d(&s, ring, guarded, 0);
        if (guarded) {
            for (int64_t i = 0; i < s.padded; i += PL_PACK)
                circles_3d(&s, i);
        } else {
            unpack(&link, 3 * s.n_facets, s.n_facets, s.padded, 3, of_facets);
            unpack(&link, 6 * s.n_facets, n_edges, s.padded_edges, 2, of_edges);
            /* There are no fewer edges than facets. One loop: while circles_3d divides, the points
             * of edges become columns. */
            for (int64_t i = 0; i < s.padded_edges; i += PL_PACK) {
                gather_edges(&s, of_edges, ring, i);
                if (i < s.padded)
                    circles_3d(&s, i);
            }
        }
    } else {
        facets_2d(&s, ring, 0);
    }
    if (PL_KERNEL != PL_RADIUS && problem->target && has_forms(&s)) {
        const star copy = s;
        gather_targets(&copy, problem, first, ring, x, dim);
    }
    if (!has_forms(&s)) {
        for (int64_t i = 0; i < s.padded; i += PL_PACK)
            store(&s, WEIGHT, i, lanes_of(1));
        for (int64_t i = s.n_facets; i < s.padded; i++)
            *entry(&s, WEIGHT, i) = 0;
        s.weight = (double)s.n_facets;
    }
    if (guarded && has_forms(&s) && is_of_edges(problem->guard)) {
        const star copy = s;
        gather_corners(&copy, dim);
    }
    if (guarded)
        gather_floors(problem, &s, first, dim);
    if (PL_KERNEL != PL_RADIUS && s.n_more > 0) {
        const star copy = s;
        s.weight = gather_rows(&copy, more, x, guarded, dim);
    }
    return s;
}

#endif
