/* objective: the paper's F of a mesh and what it is made of. One element after another, each in its
 * own scale, by the plain formulas of geometry/simplex.h; corners of cells in blocks. */
#include "quality/objective.h"

#include "base/parallel.h"
#include "base/parts.h"
#include "base/sum.h"
#include "geometry/angle.h"
#include "quality/certificate.h"
#include "quality/measure_block.h"

#include <string.h>

enum {
    MIN_CHUNK = 512, /* elements that pay for being handed to a thread */
    MAX_CHUNKS = 512 /* more than threads need */
};

/* |D| above this multiple of the product of the edges' sums of absolute components is certain to
 * have the right sign: Shewchuk's bound (certificate.c), larger for the product's own rounding. */
static const double CERTAIN = 8 * 0x1p-53;

/* What underflow adds to the error: coordinates that are scaled lose up to 2^-1074 each, as their
 * products do, and meet factors below 2^50 (pl_scale_exponent) afterwards. */
static const double UNDERFLOW_ERROR = 0x1p-960;

/* |D| below this multiple of the same product: so flat that the kernels, to which D from another of
 * its nodes may be nothing but rounding, leave its stars alone. */
static const double FLAT = 0x1p-44;

/** The sums of pl_objective_sums; of the first three there are two. */
enum { RATIO = 0, RADIUS = 2, VOLUME = 4, SHORTFALL = 6, WHOLE, N_SUMS };

/** Counts of pl_objective_sums; of the first there are two. */
enum { VALID = 0, INVERTED = 2, BELOW, N_COUNTS };

/** pl_objective_sums, of a chunk or of all. */
typedef struct exact_sums {
    pl_sum sum[N_SUMS];
    int64_t n[N_COUNTS];
    double radius_max, corner_max, acuteness;
} exact_sums;

/** A pass over all chunks. */
typedef struct objective_pass {
    const pl_objective_problem *problem;
    exact_sums *sums;           /* shared */
    const pl_corner_form *form; /* with corners: [PL_N_FORMS] */
    uint8_t *state;             /* [m] or NULL */
    double flat;     /* for state: D not above this times the permanent is below, too; -1: no */
    int64_t n_below; /* for state; shared */
} objective_pass;

/** One element: its vertices relative to the first, times 2^-exponent, and its measure. */
typedef struct element {
    double x[4][3];
    int exponent;
    double determinant; /* D, scaled, positive in the mesh's orientation */
    double measure;     /* as in the mesh */
} element;

/** Product of the edges' sums of absolute components: at least D's permanent. */
static double permanent_bound(const element *e, const int dim) {
    double product = 1;
    for (int j = 1; j <= dim; j++) {
        double norm = 0;
        for (int d = 0; d < dim; d++)
            norm += fabs(e->x[j][d]);
        product *= norm;
    }
    return product;
}

/** Measure of an element from its D; of a corner the volume of an element with such corners. */
static double measure_of(const objective_pass *pass, int64_t index, double determinant,
                         const int dim) {
    const uint8_t *corner = pass->problem->mesh.corner;
    if (!corner)
        return determinant / (dim == 3 ? 6 : 2);
    return determinant * pass->form[pl_form_code(corner[index], 0, 0)].volume;
}

static element element_at(const objective_pass *pass, int64_t index, const int dim) {
    const pl_objective_problem *problem = pass->problem;
    element e;
    const int32_t *node = problem->mesh.elements + index * (dim + 1);
    const double *vertex[4], *scaled[4];
    double extent = 0;
    for (int j = 0; j <= dim; j++) {
        vertex[j] = problem->coordinates + (int64_t)node[j] * dim;
        scaled[j] = e.x[j];
        for (int d = 0; d < dim && j > 0; d++)
            extent = fmax(extent, fabs(0.5 * vertex[j][d] - 0.5 * vertex[0][d]));
    }
    frexp(extent, &e.exponent);
    e.exponent = pl_scale_exponent(e.exponent);
    const double scale = ldexp(1, -e.exponent);
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            e.x[j][d] = vertex[j][d] * scale - vertex[0][d] * scale;
    double edges[3][3] = {{0}}, sign = problem->mesh.sign ? problem->mesh.sign[index] : 1;
    pl_edges(dim, scaled, edges);
    e.determinant = sign * pl_determinant_of_edges(dim, edges);
    e.measure = ldexp(measure_of(pass, index, e.determinant, dim), dim * e.exponent);
    if (!(fabs(e.determinant) > CERTAIN * permanent_bound(&e, dim) + UNDERFLOW_ERROR)) {
        int exponent;
        double exact = sign * pl_certified_determinant(dim, vertex, &exponent);
        e.determinant = ldexp(exact, exponent - dim * e.exponent);
        if (exact > 0 && !(e.determinant > 0))
            e.determinant = 0x1p-1022; /* as flat as can be said */
        e.measure = ldexp(measure_of(pass, index, exact, dim), exponent);
    }
    return e;
}

/* g of volumes that are huge multiples of delta: so that its square is finite. */
static const double LOWEST_G = -1e100;

/** Constraint g = 1 - V / delta of element index with measure V, or -infinity for elements without a
 *  minimum volume. */
static double volume_constraint(const pl_objective_problem *problem, int64_t index,
                                double measure) {
    const double own = problem->mesh.min_volume ? problem->mesh.min_volume[index] : 0;
    const double least = own > 0 ? own : problem->min_volume;
    return least > 0 ? fmax(1 - measure / least, LOWEST_G) : -INFINITY;
}

/** Measures of an element, and whether it has a movable node. */
typedef struct measures {
    double measure;
    int is_positive, is_movable;
    double radius, aspect; /* RR^2, and AR^2 of the objective; of positive ones */
} measures;

/** Add an element to sums; but not to RATIO where that is RADIUS. */
static inline void add_measures(const pl_objective_problem *problem, int64_t index,
                                const measures *m, exact_sums *sums) {
    const double g = volume_constraint(problem, index, m->measure);
    const int movable = m->is_movable;
    pl_sum_add(&sums->sum[WHOLE], m->measure);
    sums->n[BELOW] += g > PLANISH_VOLUME_TOLERANCE;
    if (g > 0)
        pl_sum_add(&sums->sum[SHORTFALL], g * g);
    if (!m->is_positive) {
        sums->n[INVERTED]++;
        return;
    }
    sums->n[VALID + movable]++;
    pl_sum_add(&sums->sum[RADIUS + movable], m->radius);
    if (movable)
        sums->radius_max = m->radius > sums->radius_max ? m->radius : sums->radius_max;
    if (problem->objective != PLANISH_OBJECTIVE_RADIUS_RATIO)
        pl_sum_add(&sums->sum[RATIO + movable], m->aspect);
    if (g > -INFINITY)
        pl_sum_add(&sums->sum[VOLUME + movable], g * g);
}

/** Take the smallest angle of a positive element into sums. blunt: RR^2 up to which an element has no
 *  smaller angle than those so far. */
static void take_angle(const element *e, exact_sums *sums, double *blunt, const int dim) {
    const double *x[4] = {e->x[0], e->x[1], e->x[2], e->x[3]};
    double edges[3][3] = {{0}};
    pl_edges(dim, x, edges);
    const double acuteness = pl_acuteness(dim, edges, e->determinant);
    if (!(acuteness > sums->acuteness))
        return;
    sums->acuteness = acuteness;
    *blunt = pl_blunt_ratio_square(dim, acuteness);
}

/** AR^2 of the objective, of an element with this RR^2. */
static double aspect_of(planish_objective objective, const double *const x[], double radius,
                        const int dim) {
    if (objective == PLANISH_OBJECTIVE_RADIUS_RATIO)
        return radius;
    const double ratio = objective == PLANISH_OBJECTIVE_MEAN_RATIO ? 1 / fabs(pl_mean_ratio(dim, x))
                                                                   : pl_smoothed_edge_ratio(dim, x);
    return ratio * ratio;
}

/* ---- simplices in blocks --------------------------------------------------------------------- */

/* Elements of these sizes have no measures that over- or underflow, unless their edges differ by as
 * much (pl_permanent_bound). */
static const double LEAST_EXTENT = 0x1p-100;
static const double MOST_EXTENT = 0x1p100;

/** A block of elements. Once evaluated, places, RR^2 and volumes of those that are certain are those
 *  of element_at, bit for bit. */
typedef struct simplex_block {
    pl_block of;
    double determinant[PL_SUM_LANES];
    double mean[PL_SUM_LANES]; /* mu^2 */
} simplex_block;

/** Powers of two for an element with this extent: *scale brings it to a size of 1/2 to 1 as
 *  element_at does; returns its inverse. */
PL_INLINE double scales_of(double extent, double *scale) {
    uint64_t bits, exponent;
    double inverse;
    memcpy(&bits, &extent, sizeof bits);
    exponent = bits & (uint64_t)0x7ff << 52;
    bits = ((uint64_t)2045 << 52) - exponent;
    memcpy(scale, &bits, sizeof bits);
    bits = exponent + ((uint64_t)1 << 52);
    memcpy(&inverse, &bits, sizeof bits);
    return inverse;
}

PL_INLINE void evaluate_simplices(simplex_block *s, const int dim) {
    pl_block *b = &s->of;
    for (int l = 0; l < PL_SUM_LANES; l++) {
        double x[4][3] = {{0}}, edges[3][3], extent = 0, scale;
        for (int j = 1; j <= dim; j++)
            for (int d = 0; d < dim; d++)
                extent = pl_larger(extent, fabs(0.5 * b->x[j][d][l] - 0.5 * b->x[0][d][l]));
        const double unit = scales_of(extent, &scale);
        for (int j = 1; j <= dim; j++)
            for (int d = 0; d < dim; d++) {
                x[j][d] = b->x[j][d][l] * scale - b->x[0][d][l] * scale;
                b->x[j][d][l] = edges[j - 1][d] = x[j][d];
            }
        const pl_shape shape = pl_shape_of_edges(dim, edges);
        const double error = CERTAIN * pl_permanent_bound(dim, edges);
        const double ratio =
            1 / pl_mean_ratio_of(dim, fabs(shape.determinant), pl_edge_squares_of(dim, x).sum);
        double volume = b->sign[l] * shape.determinant / (dim == 3 ? 6 : 2);
        for (int d = 0; d < dim; d++)
            volume *= unit;
        s->determinant[l] = b->sign[l] * shape.determinant;
        s->mean[l] = ratio * ratio;
        b->certain[l] = fabs(shape.determinant) > error ? 1 : 0;
        b->certain[l] = extent > LEAST_EXTENT ? b->certain[l] : 0;
        b->certain[l] = extent < MOST_EXTENT ? b->certain[l] : 0;
        b->square[l] = pl_radius_ratio_square_of_shape(dim, &shape);
        b->volume[l] = volume;
    }
    memset(b->x[0], 0, sizeof b->x[0]);
}

PL_INLINE void evaluate_of_dim(simplex_block *s, int dim) {
    if (dim == 3)
        evaluate_simplices(s, 3);
    else
        evaluate_simplices(s, 2);
}

/* With wider vectors; the bits are the same. */
#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void evaluate_wide(simplex_block *s, int dim) {
    evaluate_of_dim(s, dim);
}
#endif

static void evaluate_any(simplex_block *s, int dim) {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2")) {
        evaluate_wide(s, dim);
        return;
    }
#endif
    evaluate_of_dim(s, dim);
}

/** Element in lane l, but for its measure. */
static element element_in_block(const simplex_block *s, int l, const int dim) {
    element e = {.determinant = s->determinant[l]};
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            e.x[j][d] = s->of.x[j][d][l];
    return e;
}

/** Add element index, in lane l, to sums; blunt as for take_angle. */
static inline void add_lane(const objective_pass *pass, const simplex_block *s, int l,
                            int64_t index, exact_sums *sums, double *blunt, const int dim) {
    const planish_objective objective = pass->problem->objective;
    const int is_certain = s->of.certain[l] != 0,
              is_mean = objective == PLANISH_OBJECTIVE_MEAN_RATIO;
    const int needs_aspect =
        objective != PLANISH_OBJECTIVE_RADIUS_RATIO && !(is_certain && is_mean);
    measures m = {s->of.volume[l], s->determinant[l] > 0, s->of.is_movable[l] != 0, s->of.square[l],
                  s->mean[l]};
    const int needs_angle = m.is_movable && (!is_certain || m.radius > *blunt);
    if (!is_certain || needs_aspect || needs_angle) {
        const element e = is_certain ? element_in_block(s, l, dim) : element_at(pass, index, dim);
        const double *x[4] = {e.x[0], e.x[1], e.x[2], e.x[3]};
        m.is_positive = e.determinant > 0;
        if (!is_certain) {
            m.measure = e.measure;
            m.radius = pl_radius_ratio_square(dim, x);
        }
        if (needs_aspect)
            m.aspect = aspect_of(objective, x, m.radius, dim);
        if (m.is_positive && m.is_movable && m.radius > *blunt)
            take_angle(&e, sums, blunt, dim);
    }
    add_measures(pass->problem, index, &m, sums);
}

/** Add elements first .. first + count - 1 to sums; blunt as for take_angle. */
PL_INLINE void add_block(const objective_pass *pass, int64_t first, int count, exact_sums *sums,
                         double *blunt, const int dim) {
    const pl_mesh_state mesh = {&pass->problem->mesh, pass->problem->coordinates};
    const uint8_t *is_counted = mesh.of->is_counted;
    simplex_block s;
    pl_block_gather(&mesh, first, count, &s.of);
    evaluate_any(&s, dim);
    for (int l = 0; l < count; l++)
        if (!is_counted || is_counted[first + l])
            add_lane(pass, &s, l, first + l, sums, blunt, dim);
}

/** Add the sums of a chunk to those of all. */
static void merge_sums(exact_sums *part, exact_sums *sums) {
    for (int i = 0; i < N_SUMS; i++)
        pl_sum_merge(&sums->sum[i], &part->sum[i]);
    for (int i = 0; i < N_COUNTS; i++)
        __atomic_fetch_add(&sums->n[i], part->n[i], __ATOMIC_RELAXED);
    pl_raise_double(&sums->radius_max, part->radius_max);
    pl_raise_double(&sums->corner_max, part->corner_max);
    pl_raise_double(&sums->acuteness, part->acuteness);
}

static void add_chunk(void *context, int64_t begin, int64_t end, int thread) {
    objective_pass *pass = context;
    exact_sums part;
    (void)thread;
    memset(&part, 0, sizeof part);
    /* The smallest angle that is known by now, whichever chunk it is of. */
    __atomic_load(&pass->sums->acuteness, &part.acuteness, __ATOMIC_RELAXED);
    double blunt = pl_blunt_ratio_square(pass->problem->mesh.dim, part.acuteness);
    for (int64_t i = begin; i < end; i += PL_SUM_LANES) {
        const int count = end - i < PL_SUM_LANES ? (int)(end - i) : PL_SUM_LANES;
        if (pass->problem->mesh.dim == 3)
            add_block(pass, i, count, &part, &blunt, 3);
        else
            add_block(pass, i, count, &part, &blunt, 2);
    }
    merge_sums(&part, pass->sums);
}

/* ---- cells by their corners ------------------------------------------------------------------ */

/** Sums over the corners of a cell. */
typedef struct cell_sums {
    int n_positive, is_movable, is_below;
    double ratio, radius;   /* of AR^2, and of mu^2 */
    double most, acuteness; /* largest mu^2, 1 / SJ^2 */
    double volume;          /* of cells with such corners */
    double g2, excess2;     /* of g^2, and of max(0, g)^2 */
} cell_sums;

/** Cells of a chunk being summed up. */
typedef struct cell_pass {
    const pl_objective_problem *problem;
    exact_sums sums; /* of the cells so far, but for RADIUS where RATIO is the same */
    cell_sums cell;  /* under way */
} cell_pass;

static void add_corner(void *user, const pl_corner_block *b, int l, int64_t index) {
    cell_pass *pass = user;
    const pl_objective_problem *problem = pass->problem;
    cell_sums *cell = &pass->cell;
    const double square = b->of.square[l];
    const double g = volume_constraint(problem, index, b->of.volume[l]);
    cell->n_positive += b->of.valid[l] != 0;
    cell->is_movable |= b->of.is_movable[l] != 0;
    cell->volume += b->of.volume[l];
    cell->radius += square;
    if (!pl_is_mean(problem->objective))
        cell->ratio +=
            pl_corner_edge_ratio_square(b, l, problem->mesh.dim, problem->mesh.corner[index]);
    cell->most = pl_larger(square, cell->most);
    cell->acuteness = pl_larger(b->acuteness[l], cell->acuteness);
    if (!(g > -INFINITY))
        return;
    cell->is_below |= g > PLANISH_VOLUME_TOLERANCE;
    cell->g2 += g * g;
    cell->excess2 += g > 0 ? g * g : 0;
}

/** Add a cell of n corners to sums. */
static void add_cell(const pl_objective_problem *problem, const cell_sums *cell, int n,
                     exact_sums *sums) {
    const int by_edges = !pl_is_mean(problem->objective);
    const int movable = cell->is_movable;
    const double share = 1.0 / n, radius = cell->radius * share;
    pl_sum_add(&sums->sum[WHOLE], cell->volume * share);
    sums->n[BELOW] += cell->is_below;
    if (cell->excess2 > 0)
        pl_sum_add(&sums->sum[SHORTFALL], cell->excess2 * share);
    if (cell->n_positive < n) {
        sums->n[INVERTED]++;
        return;
    }
    sums->n[VALID + movable]++;
    pl_sum_add(&sums->sum[RATIO + movable], by_edges ? cell->ratio * share : radius);
    if (by_edges)
        pl_sum_add(&sums->sum[RADIUS + movable], radius);
    if (cell->g2 > 0)
        pl_sum_add(&sums->sum[VOLUME + movable], cell->g2 * share);
    if (!movable)
        return;
    sums->radius_max = pl_larger(radius, sums->radius_max);
    sums->corner_max = pl_larger(cell->most, sums->corner_max);
    sums->acuteness = pl_larger(cell->acuteness, sums->acuteness);
}

static void end_cell(void *user, int64_t cell, int64_t first, int n) {
    cell_pass *pass = user;
    (void)cell;
    (void)first;
    add_cell(pass->problem, &pass->cell, n, &pass->sums);
    pass->cell = (cell_sums){.volume = 0};
}

static void add_cells_chunk(void *context, int64_t begin, int64_t end, int thread) {
    objective_pass *pass = context;
    const pl_mesh_state mesh = {&pass->problem->mesh, pass->problem->coordinates};
    cell_pass chunk;
    (void)thread;
    memset(&chunk, 0, sizeof chunk);
    chunk.problem = pass->problem;
    pl_cells_visit(&mesh, pass->form, begin, end, add_corner, end_cell, &chunk);
    merge_sums(&chunk.sums, pass->sums);
}

pl_objective_problem pl_objective_problem_of(const pl_view *mesh, const double *coordinates,
                                             const planish_options *options, double min_volume,
                                             int threads) {
    return (pl_objective_problem){*mesh, coordinates, options->objective, min_volume, threads};
}

void pl_sum_objective(const pl_objective_problem *problem, pl_objective_sums *sums) {
    enum { LEAST_CELLS = MIN_CHUNK / PL_CELL_CORNERS };
    exact_sums all;
    pl_corner_form form[PL_N_FORMS];
    const int has_corners = problem->mesh.corner != NULL;
    const int64_t n = has_corners ? problem->mesh.n_cells : problem->mesh.n_elements;
    const int64_t chunk = (n + MAX_CHUNKS - 1) / MAX_CHUNKS;
    const int64_t least = has_corners ? LEAST_CELLS : MIN_CHUNK;
    objective_pass pass = {.problem = problem, .sums = &all, .form = form};
    memset(&all, 0, sizeof all);
    if (has_corners)
        pl_corner_forms_make(problem->mesh.dim, form);
    pl_parallel_for(problem->threads, n, chunk < least ? least : chunk,
                    has_corners ? add_cells_chunk : add_chunk, &pass);
    if (has_corners && pl_is_mean(problem->objective))
        memcpy(&all.sum[RADIUS], &all.sum[RATIO], 2 * sizeof *all.sum);
    if (!has_corners && problem->objective == PLANISH_OBJECTIVE_RADIUS_RATIO)
        memcpy(&all.sum[RATIO], &all.sum[RADIUS], 2 * sizeof *all.sum);
    double most[] = {all.radius_max, all.acuteness};
    pl_parts_add_sums(all.sum, N_SUMS);
    pl_parts_add(all.n, N_COUNTS);
    pl_parts_largest(most, 2);
    *sums = (pl_objective_sums){.radius_max = most[0],
                                .corner_max = all.corner_max,
                                .acuteness = most[1],
                                .inverted = (double)all.n[INVERTED],
                                .below = (double)all.n[BELOW],
                                .shortfall = pl_sum_value(&all.sum[SHORTFALL]),
                                .domain = pl_sum_value(&all.sum[WHOLE])};
    for (int movable = 0; movable < 2; movable++) {
        sums->ratio[movable] = pl_sum_value(&all.sum[RATIO + movable]);
        sums->radius[movable] = pl_sum_value(&all.sum[RADIUS + movable]);
        sums->volume[movable] = pl_sum_value(&all.sum[VOLUME + movable]);
        sums->n[movable] = (double)all.n[VALID + movable];
    }
}

double pl_objective_of_all(const planish_options *options, const pl_objective_sums *sums) {
    const double n = sums->n[0] + sums->n[1], mu2 = options->area_weight, f1 = pl_rms_of_all(sums);
    return mu2 > 0 ? (1 - mu2) * f1 + mu2 * pl_rms(sums->volume[0] + sums->volume[1], n) : f1;
}

double pl_objective_of_movable(const planish_options *options, const pl_objective_sums *sums) {
    const double mu2 = options->area_weight, f1 = pl_rms_of_movable(sums);
    return mu2 > 0 ? (1 - mu2) * f1 + mu2 * pl_rms(sums->volume[1], sums->n[1]) : f1;
}

double pl_minimum_volume_of(const planish_options *options, const pl_objective_problem *problem) {
    pl_objective_sums sums;
    if (!(options->min_volume_fraction > 0))
        return options->min_volume;
    pl_sum_objective(problem, &sums);
    return options->min_volume_fraction * fabs(sums.domain);
}

static void classify_chunk(void *context, int64_t begin, int64_t end, int thread) {
    objective_pass *pass = context;
    int64_t n_below = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        element e = element_at(pass, i, pass->problem->mesh.dim);
        int below = volume_constraint(pass->problem, i, e.measure) > PLANISH_VOLUME_TOLERANCE;
        if (pass->flat >= 0)
            below |= !(e.determinant > pass->flat * permanent_bound(&e, pass->problem->mesh.dim));
        pass->state[i] = below ? PLANISH_VOLUME_BELOW : PLANISH_VOLUME_MET;
        n_below += below;
    }
    __atomic_fetch_add(&pass->n_below, n_below, __ATOMIC_RELAXED);
}

static int64_t classify(const pl_objective_problem *problem, double flat, uint8_t *state) {
    pl_corner_form form[PL_N_FORMS];
    objective_pass pass = {.problem = problem, .state = state, .flat = flat, .form = form};
    if (problem->mesh.corner)
        pl_corner_forms_make(problem->mesh.dim, form);
    pl_parallel_for(problem->threads, problem->mesh.n_elements, 8 * MIN_CHUNK, classify_chunk,
                    &pass);
    return pass.n_below;
}

int64_t pl_find_below(const pl_objective_problem *problem, uint8_t *state) {
    return classify(problem, -1, state);
}

int64_t pl_find_inverted(const pl_objective_problem *problem, uint8_t *state) {
    return classify(problem, 0, state);
}

int64_t pl_find_tangled(const pl_objective_problem *problem, uint8_t *state) {
    return classify(problem, FLAT, state);
}
