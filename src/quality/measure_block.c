/* measure_block: gathering, and elements that the plain formulas are not certain of.
 *
 * Those whose size is out of range are evaluated again by the same formulas, in a size of about 1.
 * What is uncertain still is looked at one by one. Of these the sign of D is exact (certificate.h);
 * each is looked at in its own scale, and what can still be out of a double's range, D and short
 * edges, carries its exponent along.
 */
#include "quality/measure_block.h"
#include "geometry/fetch.h"
#include "quality/certificate.h"
#include "quality/measure.h"

#include <float.h>
#include <string.h>

/* ---- Gathering ---------------------------------------------------------------------------- */

enum { AHEAD = 3 * PL_SUM_LANES }; /* elements whose nodes are asked for before they are needed */

PL_INLINE void gather(const pl_mesh_state *mesh, int64_t first, int count, pl_block *b,
                      const int dim) {
    const int32_t *node[PL_SUM_LANES];
    for (int l = 0; l < PL_SUM_LANES && first + AHEAD + l < mesh->of->n_elements; l++)
        pl_fetch_nodes(dim, mesh->of->elements, mesh->coordinates, first + AHEAD + l);
    for (int l = 0; l < PL_SUM_LANES; l++) {
        const int64_t element = first + (l < count ? l : 0);
        node[l] = mesh->of->elements + element * (dim + 1);
        for (int j = 0; j <= dim; j++)
            for (int d = 0; d < dim; d++)
                b->x[j][d][l] = mesh->coordinates[(int64_t)node[l][j] * dim + d];
        b->sign[l] = mesh->of->sign ? mesh->of->sign[element] : 1;
        b->present[l] = l < count;
    }
    if (!mesh->of->is_movable) {
        for (int l = 0; l < PL_SUM_LANES; l++)
            b->is_movable[l] = pl_any_moves(mesh->of->mobility, node[l], dim + 1);
        return;
    }
    for (int l = 0; l < PL_SUM_LANES; l++) {
        const uint8_t movable = mesh->of->is_movable[first + (l < count ? l : 0)];
        b->is_movable[l] = movable != 0;
        b->present[l] = l < count && movable != PL_ELSEWHERE;
    }
}

void pl_block_gather(const pl_mesh_state *mesh, int64_t first, int count, pl_block *b) {
    if (mesh->of->dim == 3)
        gather(mesh, first, count, b, 3);
    else
        gather(mesh, first, count, b, 2);
}

/* ---- Elements out of range ------------------------------------------------------------------ */

/** Evaluate the lanes with which the plain formulas could over- or underflow again, scaled to a
 *  size of about 1: elements that are the same but for a power of two have the same measures, bit
 *  for bit, whatever their size. */
static void evaluate_scaled(pl_block *b, int dim) {
    const pl_block before = *b;
    int exponent[PL_SUM_LANES] = {0}, n_scaled = 0;
    for (int l = 0; l < PL_SUM_LANES; l++) {
        double edges[3][3] = {{0}};
        double half = 0; /* of the longest component of an edge, because the whole could overflow */
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++) {
                edges[j][d] = b->x[j + 1][d][l] - b->x[0][d][l];
                half = pl_larger(half, fabs(b->x[j + 1][d][l] / 2 - b->x[0][d][l] / 2));
            }
        if (b->certain[l] != 0 || pl_permanent_bound(dim, edges) < INFINITY)
            continue;
        frexp(half, &exponent[l]);
        for (int j = 0; j <= dim; j++)
            for (int d = 0; d < dim; d++)
                b->x[j][d][l] = ldexp(b->x[j][d][l], -exponent[l]);
        n_scaled++;
    }
    if (n_scaled == 0)
        return;
    if (dim == 3)
        pl_block_evaluate(b, 3, 1);
    else
        pl_block_evaluate(b, 2, 1);
    for (int l = 0; l < PL_SUM_LANES; l++)
        b->volume[l] = ldexp(b->volume[l], dim * exponent[l]);
    memcpy(b->x, before.x, sizeof b->x);
}

/* ---- Elements one by one ------------------------------------------------------------------- */

/** mantissa 2^exponent; the mantissa is 0 or from 1/2 to 1. */
typedef struct scaled {
    double mantissa;
    int exponent;
} scaled;

/** An element whose longest component of an edge is from 1/2 to 1 once edges are multiplied by
 *  factor and then by 2^-exponent. */
typedef struct element {
    const double *vertex[4];
    double factor; /* 1, or 1/2 where differences of coordinates overflow */
    int exponent;
    scaled length[4][4]; /* of the edge between two vertices, in that scale */
    double longest;
} element;

static scaled scaled_of(double value, int exponent) {
    scaled s;
    s.mantissa = frexp(value, &s.exponent);
    s.exponent += exponent;
    return s;
}

/** b - a times factor and 2^-exponent; returns the largest absolute component. */
static double difference(int dim, const element *e, const double a[], const double b[],
                         double edge[3]) {
    double largest = 0;
    for (int d = 0; d < dim; d++) {
        edge[d] = ldexp(b[d] * e->factor - a[d] * e->factor, -e->exponent);
        largest = pl_larger(largest, fabs(edge[d]));
    }
    return largest;
}

/** Edges from vertex 0 in e's scale; returns the largest absolute component. */
static double differences(int dim, const element *e, double edges[3][3]) {
    double largest = 0;
    for (int j = 0; j < dim; j++)
        largest = pl_larger(largest, difference(dim, e, e->vertex[0], e->vertex[j + 1], edges[j]));
    return largest;
}

/** Find e's scale, and its edges from vertex 0 in it. Coordinates are finite. */
static void find_scale(int dim, element *e, double edges[3][3]) {
    e->factor = 1;
    e->exponent = 0;
    double largest = differences(dim, e, edges);
    if (largest > DBL_MAX) {
        e->factor = 0.5;
        largest = differences(dim, e, edges);
    }
    frexp(largest, &e->exponent);
    differences(dim, e, edges);
}

static double value_of(scaled s) {
    return ldexp(s.mantissa, s.exponent);
}

/** Find the lengths of e's edges, precise however short they are. Returns the edge ratio; *sum: of
 *  the edges' squares. */
static double find_lengths(int dim, element *e, double *sum) {
    double ratio = 1;
    e->longest = 0;
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++) {
            double edge[3];
            int exponent;
            frexp(difference(dim, e, e->vertex[i], e->vertex[j], edge), &exponent);
            for (int d = 0; d < dim; d++)
                edge[d] = ldexp(edge[d], -exponent);
            const scaled length = scaled_of(sqrt(pl_dot(dim, edge, edge)), exponent);
            e->length[i][j] = e->length[j][i] = length;
            e->longest = pl_larger(e->longest, value_of(length));
        }
    *sum = 0;
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++) {
            const double length = value_of(e->length[i][j]);
            ratio = pl_larger(ratio, e->longest / length);
            *sum += length * length;
        }
    return ratio;
}

/** Mean ratio; determinant: |D| in e's scale. */
static double mean_ratio(int dim, scaled determinant, double sum) {
    if (dim == 2)
        return pl_mean_ratio_of(2, value_of(determinant), sum);
    int rest = (determinant.exponent % 3 + 3) % 3;
    double root = pl_cube_root(ldexp(determinant.mantissa, rest) / 2);
    root = ldexp(root, (determinant.exponent - rest) / 3);
    return 12 * (root * root) / sum;
}

static double scaled_jacobian(int dim, const element *e, scaled determinant) {
    double least = INFINITY;
    for (int i = 0; i <= dim; i++) {
        scaled quotient = determinant;
        for (int j = 0; j <= dim; j++) {
            if (j == i)
                continue;
            quotient.mantissa /= e->length[i][j].mantissa;
            quotient.exponent -= e->length[i][j].exponent;
        }
        least = pl_smaller(least, value_of(quotient));
    }
    return PL_JACOBIAN_SCALE[dim] * least;
}

/** A ratio of at least about 1, infinite where factors of it have underflowed. */
static double not_lost(double ratio) {
    return ratio > 0.5 ? ratio : INFINITY;
}

/** Evaluate lane l anew: in the element's own scale, with the exact sign. */
static void resolve(const pl_mesh_state *mesh, int64_t number, int l, pl_block *b) {
    const int dim = mesh->of->dim;
    element e = {.vertex = {NULL}}; /* for compilers that do not see that dim > 0 */
    for (int j = 0; j <= dim; j++)
        e.vertex[j] = mesh->coordinates + (int64_t)mesh->of->elements[number * (dim + 1) + j] * dim;
    int exponent;
    double m = b->sign[l] * pl_certified_determinant(dim, e.vertex, &exponent);
    b->volume[l] = ldexp(m / (dim == 3 ? 6 : 2), exponent);
    b->valid[l] = m > 0 ? b->present[l] : 0;
    b->listed[l] = pl_sign_of(m) * b->sign[l] * b->present[l];
    if (!(m > 0))
        return;
    double edges[3][3] = {{0}}, sum;
    find_scale(dim, &e, edges);
    b->measure[PL_MEASURE_EDGE_RATIO][l] = find_lengths(dim, &e, &sum);
    const scaled determinant = scaled_of(m, exponent - dim * (e.exponent + (e.factor < 1)));
    pl_shape shape = pl_shape_of(dim, edges, value_of(determinant));
    /* R is at least half the longest edge, whatever cancelled in N. */
    const double d2 = shape.determinant * shape.determinant;
    shape.circumradius_square = pl_larger(shape.circumradius_square, d2 * (e.longest * e.longest));
    /* Faces that are thinner than 2^-500 times the element have no direction left. */
    if (shape.smallest_cosine > shape.largest_cosine) { /* none of them was a number */
        shape.smallest_cosine = -1;
        shape.largest_cosine = 1;
        shape.acute_square = shape.obtuse_square = 0;
    }
    pl_block_put_shape(b, l, &shape, dim);
    const double ratio = not_lost(b->measure[PL_MEASURE_RADIUS_RATIO][l]);
    const double circumradius = pl_circumradius_to_edge(dim, &shape, e.longest);
    b->square[l] = ratio * ratio;
    b->measure[PL_MEASURE_RADIUS_RATIO][l] = ratio;
    b->measure[PL_MEASURE_CIRCUMRADIUS_TO_EDGE][l] =
        pl_larger(circumradius, PL_CIRCUMRADIUS_SCALE[dim]);
    b->measure[PL_MEASURE_EDGE_TO_INRADIUS][l] =
        not_lost(pl_edge_to_inradius(dim, &shape, e.longest));
    b->measure[PL_MEASURE_MEAN_RATIO][l] = mean_ratio(dim, determinant, sum);
    b->measure[PL_MEASURE_SCALED_JACOBIAN][l] = scaled_jacobian(dim, &e, determinant);
}

void pl_block_resolve(const pl_mesh_state *mesh, int64_t first, int count, pl_block *b) {
    evaluate_scaled(b, mesh->of->dim);
    for (int l = 0; l < count; l++)
        if (b->certain[l] == 0)
            resolve(mesh, first + l, l, b);
}

double pl_block_acuteness(const pl_block *b, int l, int dim) {
    const double *vertex[4];
    double x[4][3], edges[3][3] = {{0}};
    element e;
    for (int j = 0; j <= dim; j++) {
        for (int d = 0; d < dim; d++)
            x[j][d] = b->x[j][d][l];
        e.vertex[j] = vertex[j] = x[j];
    }
    find_scale(dim, &e, edges);
    double determinant = pl_determinant_of_edges(dim, edges);
    if (b->certain[l] == 0) {
        int exponent;
        determinant = pl_certified_determinant(dim, vertex, &exponent);
        determinant = ldexp(determinant, exponent - dim * (e.exponent + (e.factor < 1)));
    }
    return pl_acuteness(dim, edges, determinant);
}

/* ---- corners --------------------------------------------------------------------------------- */

/** Product of the squares of the edges at the corner; of a simplex the largest at a vertex. */
PL_INLINE double product_of_edges(int dim, const double square[6], double is_simplex) {
    double own, most;
    if (dim == 2) {
        own = square[0] * square[1];
        most = pl_larger(square[0] * square[2], square[1] * square[2]);
    } else {
        own = square[0] * square[1] * square[2];
        most = pl_larger(square[0] * square[3] * square[4], square[1] * square[3] * square[5]);
        most = pl_larger(most, square[2] * square[4] * square[5]);
    }
    return is_simplex != 0 ? pl_larger(own, most) : own;
}

/** Return the square that a corner with a target adds, from its edges and |D|. */
PL_INLINE double square_of_target(const pl_corner_block *b, int l, const int has_metric, int dim,
                                  const double edges[3][3], double determinant) {
    double v[6], metric[6], energy;
    for (int k = 0; k < 6; k++)
        v[k] = b->weight[k][l];
    for (int k = 0; has_metric && k < 6; k++)
        metric[k] = b->metric[k][l];
    energy =
        has_metric ? pl_target_energy_in(dim, edges, v, metric) : pl_target_energy(dim, edges, v);
    return pl_target_square(dim, energy, determinant, b->target_unit[l], b->size_weight);
}

/** Gather corners, and what is ideal for them. */
PL_INLINE void gather_corners(const pl_mesh_state *mesh, const pl_corner_form *form, int64_t first,
                              int count, pl_corner_block *b) {
    pl_block_gather(mesh, first, count, &b->of);
    b->size_weight = mesh->of->size_weight;
    for (int l = 0; l < PL_SUM_LANES; l++) {
        const int kind = pl_corner_kind(mesh->of->corner[first + (l < count ? l : 0)]);
        const pl_corner_form *f = &form[pl_form_code(pl_corner_code(kind, 0), 0, 0)];
        const int64_t number = first + (l < count ? l : 0);
        const pl_target *target = mesh->of->target ? &mesh->of->target[number] : NULL;
        for (int k = 0; k < 6; k++)
            b->weight[k][l] = target ? target->v[k] : f->weight[k];
        for (int k = 0; mesh->of->metric && k < 6; k++)
            b->metric[k][l] = mesh->of->metric[number].l[k];
        b->target_unit[l] = target ? target->unit : 0;
        b->determinant[l] = f->determinant;
        b->unit[l] = f->volume;
        b->is_simplex[l] = kind == PL_KIND_SIMPLEX ? 1 : 0;
    }
}

/** Evaluate all lanes by the plain formulas. */
PL_INLINE void evaluate_corners(pl_corner_block *b, const int has_targets, const int has_metric,
                                const int dim) {
    pl_block *of = &b->of;
    for (int l = 0; l < PL_SUM_LANES; l++) {
        double edges[3][3], square[6], between[3], e = 0;
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                edges[j][d] = of->x[j + 1][d][l] - of->x[0][d][l];
        for (int j = 0; j < dim; j++)
            square[j] = pl_dot(dim, edges[j], edges[j]);
        for (int pair = 0; pair < (dim == 3 ? 3 : 1); pair++) { /* 01, 02, 12 */
            pl_subtract(dim, edges[(pair + 3) / 2], edges[pair / 2], between);
            square[dim + pair] = pl_dot(dim, between, between);
        }
        for (int k = 0; k < (dim == 3 ? 6 : 3); k++) {
            e += b->weight[k][l] * square[k];
            b->edge[k][l] = square[k];
        }
        const double determinant = pl_determinant_of_edges(dim, edges);
        const double error =
            (dim == 3 ? PL_ERROR_3D : PL_ERROR_2D) * pl_permanent_bound(dim, edges);
        const double oriented = of->sign[l] * determinant;
        const double d = fabs(determinant) / b->determinant[l];
        of->certain[l] = fabs(determinant) > error ? 1 : 0;
        of->valid[l] = oriented > 0 ? of->present[l] : 0;
        of->listed[l] = pl_sign_of(determinant) * of->present[l];
        of->volume[l] = oriented * b->unit[l];
        of->square[l] = has_targets ? square_of_target(b, l, has_metric, dim,
                                                       (const double(*)[3])edges, fabs(determinant))
                                    : pl_mean_square(dim, e, d);
        b->acuteness[l] = product_of_edges(dim, square, b->is_simplex[l]) / (d * d);
    }
}

PL_INLINE void inline_corners(const pl_mesh_state *mesh, pl_corner_block *b) {
    const pl_view *of = mesh->of;
    if (of->metric && of->dim == 3)
        evaluate_corners(b, 1, 1, 3);
    else if (of->metric)
        evaluate_corners(b, 1, 1, 2);
    else if (of->target && of->dim == 3)
        evaluate_corners(b, 1, 0, 3);
    else if (of->target)
        evaluate_corners(b, 1, 0, 2);
    else if (of->dim == 3)
        evaluate_corners(b, 0, 0, 3);
    else
        evaluate_corners(b, 0, 0, 2);
}

/* With wider vectors; the bits are the same. */
#if defined(__x86_64__) && defined(__GNUC__)
__attribute__((target("avx2"))) static void wide_corners(const pl_mesh_state *mesh,
                                                         pl_corner_block *b) {
    inline_corners(mesh, b);
}
#endif

static void any_corners(const pl_mesh_state *mesh, pl_corner_block *b) {
#if defined(__x86_64__) && defined(__GNUC__)
    if (__builtin_cpu_supports("avx2")) {
        wide_corners(mesh, b);
        return;
    }
#endif
    inline_corners(mesh, b);
}

/** Put corner number into lane l in a size of about 1, relative to its first node. Returns the
 *  exponent of the power of two by which it is larger. */
static int scale_corner(const pl_mesh_state *mesh, int64_t number, int l, pl_corner_block *b) {
    const int dim = mesh->of->dim;
    const int32_t *node = mesh->of->elements + number * (dim + 1);
    double half = 0; /* of the longest component of an edge, because the whole could overflow */
    int exponent;
    for (int j = 1; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            half = pl_larger(half, fabs(mesh->coordinates[(int64_t)node[j] * dim + d] / 2 -
                                        mesh->coordinates[(int64_t)node[0] * dim + d] / 2));
    frexp(half, &exponent);
    exponent = pl_scale_exponent(exponent);
    const double scale = ldexp(1, -exponent);
    b->target_unit[l] = ldexp(b->target_unit[l], dim * exponent);
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            b->of.x[j][d][l] = mesh->coordinates[(int64_t)node[j] * dim + d] * scale -
                               mesh->coordinates[(int64_t)node[0] * dim + d] * scale;
    return exponent;
}

/** Finish lane l, corner number, of which the plain formulas are not certain in its own scale of
 *  2^exponent: by the exact determinant. */
static void resolve_corner(const pl_mesh_state *mesh, int64_t number, int l, int exponent,
                           pl_corner_block *b) {
    const int dim = mesh->of->dim, n_edges = dim == 3 ? 6 : 3;
    const double *vertex[4];
    double square[6], e = 0;
    int of_exact;
    for (int j = 0; j <= dim; j++)
        vertex[j] = mesh->coordinates + (int64_t)mesh->of->elements[number * (dim + 1) + j] * dim;
    const double m = pl_certified_determinant(dim, vertex, &of_exact);
    b->of.valid[l] = b->of.sign[l] * m > 0 ? b->of.present[l] : 0;
    b->of.listed[l] = pl_sign_of(m) * b->of.present[l];
    b->of.volume[l] = ldexp(b->of.sign[l] * m * b->unit[l], of_exact);
    if (!(b->of.valid[l] != 0))
        return;
    for (int k = 0; k < n_edges; k++) {
        square[k] = b->edge[k][l];
        e += b->weight[k][l] * square[k];
    }
    /* As flat as can be said without an overflow. */
    const double least = 0x1p-500, d = ldexp(fabs(m), of_exact - dim * exponent);
    const double ideal = pl_larger(d / b->determinant[l], least);
    if (mesh->of->target) {
        double edges[3][3];
        for (int j = 0; j < dim; j++)
            for (int c = 0; c < dim; c++)
                edges[j][c] = b->of.x[j + 1][c][l] - b->of.x[0][c][l];
        b->of.square[l] = square_of_target(b, l, mesh->of->metric != NULL, dim,
                                           (const double(*)[3])edges, pl_larger(d, least));
    } else {
        b->of.square[l] = pl_mean_square(dim, e, ideal);
    }
    b->acuteness[l] = product_of_edges(dim, square, b->is_simplex[l]) / (ideal * ideal);
}

void pl_corners_evaluate(const pl_mesh_state *mesh, const pl_corner_form *form, int64_t first,
                         int count, pl_corner_block *b) {
    int exponent[PL_SUM_LANES];
    double certain[PL_SUM_LANES], volume[PL_SUM_LANES], n_certain = 0;
    gather_corners(mesh, form, first, count, b);
    any_corners(mesh, b);
    for (int l = 0; l < PL_SUM_LANES; l++)
        n_certain += b->of.certain[l];
    if (n_certain == PL_SUM_LANES)
        return;
    for (int l = 0; l < PL_SUM_LANES; l++) {
        certain[l] = b->of.certain[l];
        volume[l] = b->of.volume[l];
        if (!(certain[l] != 0))
            exponent[l] = scale_corner(mesh, first + (l < count ? l : 0), l, b);
    }
    any_corners(mesh, b);
    for (int l = 0; l < count; l++) {
        if (certain[l] != 0)
            b->of.volume[l] = volume[l];
        else if (b->of.certain[l] != 0)
            b->of.volume[l] = ldexp(b->of.volume[l], mesh->of->dim * exponent[l]);
        else
            resolve_corner(mesh, first + l, l, exponent[l], b);
    }
}

int pl_corner_edges(const pl_corner_block *b, int l, int dim, uint8_t code, int real[6],
                    double *shortest, double *longest) {
    /* The edges of corners: of a wedge those of the triangle, of a pyramid those to the apex. */
    static const uint8_t REAL[2][4] = {{7, 3, 0, 0}, {63, 7, 15, 55}};
    const int bits = REAL[dim - 2][pl_corner_kind(code)];
    int n = 0;
    *shortest = INFINITY;
    *longest = 0;
    for (int k = 0; k < 6; k++) {
        if (!(bits >> k & 1))
            continue;
        real[n++] = k;
        *shortest = pl_smaller(b->edge[k][l], *shortest);
        *longest = pl_larger(b->edge[k][l], *longest);
    }
    return n;
}

double pl_corner_edge_ratio_square(const pl_corner_block *b, int l, int dim, uint8_t code) {
    int real[6];
    double shortest, longest, large = 0, small = 0;
    const int n = pl_corner_edges(b, l, dim, code, real, &shortest, &longest);
    for (int i = 0; i < n; i++) {
        const double square = b->edge[real[i]][l];
        double up = square / longest, down = shortest / square;
        for (int k = 0; k < PL_EDGE_SHARPNESS; k++) {
            up *= up;
            down *= down;
        }
        large += up;
        small += down;
    }
    double means = large / n * (small / n);
    for (int k = 0; k < PL_EDGE_SHARPNESS; k++)
        means = sqrt(means);
    return longest / shortest * means;
}
