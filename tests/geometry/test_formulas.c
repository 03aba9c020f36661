/* The measures of src/geometry, and what planish_measure makes of them, on elements of all shapes
 * from regular to nearly degenerate, against 113 bits.
 *
 * With u = 2^-53 D is known to u |e_1|_1 |e_2|_1 |e_3|_1, e_j the edges from vertex 0, and the
 * normal of a face, as it is made of these, to u times the longest of them and the face's longest
 * edge. What is made of both is as well known as both:
 *
 *     kappa = 1 + |e_1|_1 |e_2|_1 |e_3|_1 / |D| + largest (longest e_j) (longest edge) / |n|
 *
 * In the plane there is no e_3, and facets are edges. Errors are at most a multiple of u kappa:
 * relative ones, but for cosines, which have no size of their own, and for derivatives, which are
 * compared with their terms taken absolutely (support/jets.h). Edges need no kappa. The multiples
 * are stated below, figures tell the largest ones seen; of elements with u kappa above LOST only
 * the sign is known. */
#include "geometry/angle.h"
#include "geometry/simplex.h"
#include "quality/measure.h"

#include "support/effort.h"
#include "support/shapes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#ifdef PLANISH_HAVE_QUADMATH
#define REFERENCE_IN_QUAD
#include "geometry/derivatives.h"
#include "geometry/reference.h"
#include "support/element_jets.h"

static const long double U = 0x1p-53L, LOST = 1e-4L;
static const double THINNEST = 1e-9;

enum {
    MEASURE,
    RADIUS_RATIO_SQUARE,
    RADIUS_RATIO,
    CIRCUMRADIUS_TO_EDGE,
    EDGE_TO_INRADIUS,
    EDGE_RATIO,
    SMOOTHED_EDGE_RATIO,
    MEAN_RATIO,
    SCALED_JACOBIAN,
    SMALLEST_COSINE,
    LARGEST_COSINE,
    ACUTENESS,
    DERIVED_VALUE,
    DERIVED_GRADIENT,
    DERIVED_HESSIAN,
    QUANTITIES
};

/** What is compared, and the multiple of u kappa, or of u, that errors may have. */
typedef struct quantity {
    const char *name;
    double allowed;
    int of_edges; /* kappa is 1 */
} quantity;

static const quantity quantities[QUANTITIES] = {{"measure", 2, 0},
                                                {"radius ratio^2", 10, 0},
                                                {"radius ratio", 5, 0},
                                                {"circumradius / edge", 5, 0},
                                                {"edge / inradius", 5, 0},
                                                {"edge ratio", 5, 1},
                                                {"smoothed edge ratio", 6, 1},
                                                {"mean ratio", 4, 0},
                                                {"scaled Jacobian", 4, 0},
                                                {"smallest cosine", 3, 0},
                                                {"largest cosine", 3, 0},
                                                {"acuteness", 6, 0},
                                                {"derivatives: value", 10, 0},
                                                {"gradient", 8, 0},
                                                {"Hessian", 8, 0}};

/** Of all elements. */
typedef struct figures {
    long double multiple[QUANTITIES], of_measure;
    int64_t n, lost;
} figures;

/* ---- one element ---------------------------------------------------------------------------- */

typedef struct element {
    int dim;
    double x[4][3];
    const double *vertex[4];
    element_jets jets; /* the last vertex moves */
    reference wanted;
    quad determinant;
    long double kappa;
} element;

static element_jets jets_of(int dim, double x[4][3]) {
    element_jets e = {.dim = dim};
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < 3; d++) {
            const quad a = d < dim ? (quad)x[j][d] - (quad)x[dim][d] : 0;
            e.vertex[j][d] = j == dim && d < dim ? jet_variable(a, d) : jet_constant(a);
        }
    return e;
}

static quad edge_of(const element *e, int i, int j) {
    return sqrtq(element_square(&e->jets, i, j).value);
}

/** The largest part of kappa that a face has. */
static long double face_kappa(const element *e) {
    quad from = 0, largest = 0;
    for (int j = 1; j <= 3; j++)
        from = fmaxq(from, edge_of(e, 0, j));
    for (int i = 0; i < 4; i++) {
        const int j = (i + 1) % 4, k = (i + 2) % 4;
        const quad own = fmaxq(edge_of(e, i, j), fmaxq(edge_of(e, j, k), edge_of(e, k, i)));
        const quad area = sqrtq(element_area_square(&e->jets, i, j, k).value);
        largest = fmaxq(largest, from * own / area);
    }
    return (long double)largest;
}

static long double permanent_of(const element *e) {
    quad product = 1;
    for (int j = 1; j <= e->dim; j++) {
        quad norm = 0;
        for (int d = 0; d < e->dim; d++)
            norm += fabsq((quad)e->x[j][d] - (quad)e->x[0][d]);
        product *= norm;
    }
    return (long double)product;
}

/** Sizes are those for which the plain formulas are in range. */
static void draw(shape_kind kind, uint64_t *random, element *e) {
    const shape_place place = shape_place_draw(random, 60);
    const int dim = e->dim;
    shape_draw(kind, dim, pow(THINNEST, random_unit(random)), &place, random, e->x);
    e->jets = jets_of(dim, e->x);
    e->determinant = element_determinant(&e->jets).value;
    if (e->determinant < 0) {
        double kept[3];
        memcpy(kept, e->x[0], sizeof kept);
        memcpy(e->x[0], e->x[1], sizeof kept);
        memcpy(e->x[1], kept, sizeof kept);
        e->jets = jets_of(dim, e->x);
        e->determinant = -e->determinant;
    }
    for (int j = 0; j <= dim; j++)
        e->vertex[j] = e->x[j];
    e->kappa = INFINITY;
    if (e->determinant > 0)
        e->kappa =
            1 + permanent_of(e) / (long double)e->determinant + (dim == 3 ? face_kappa(e) : 0);
}

/* ---- comparisons ---------------------------------------------------------------------------- */

static void take(const element *e, int what, quad error, long double size, figures *seen) {
    const quantity *q = &quantities[what];
    const long double kappa = q->of_edges ? 1 : e->kappa;
    const long double multiple = (long double)fabsq(error) / (U * kappa * size);
    seen->multiple[what] = fmaxl(seen->multiple[what], multiple);
    if (multiple <= q->allowed)
        return;
    print_error("%s: %Lg times u kappa, kappa %Lg\n", q->name, multiple, kappa);
    for (int j = 0; j <= e->dim; j++)
        print_error("    {%a, %a, %a},\n", e->x[j][0], e->x[j][1], e->x[j][2]);
    fail();
}

static void take_relative(const element *e, int what, double found, quad wanted, figures *seen) {
    take(e, what, found - wanted, (long double)fabsq(wanted), seen);
}

static quad cosine_of(real degrees) {
    return cosq(degrees * (M_PIq / 180));
}

/** 1 / sin^2 of the smallest angle, which is acute. */
static quad acuteness_of(const element *e) {
    const quad sine = sinq(e->wanted.smallest_angle * (M_PIq / 180));
    return 1 / (sine * sine);
}

static void compare_measures(const element *e, figures *seen) {
    const int dim = e->dim;
    const reference *r = &e->wanted;
    double edges[3][3], low, high;
    pl_edges(dim, e->vertex, edges);
    const pl_shape shape = pl_shape_of_edges(dim, edges);
    const pl_edge_squares squares = pl_edge_squares_at(dim, e->vertex);
    const double longest = sqrt(squares.longest);
    take_relative(e, MEASURE, pl_simplex_measure(dim, e->vertex),
                  e->determinant / (dim == 3 ? 6 : 2), seen);
    take_relative(e, RADIUS_RATIO_SQUARE, pl_radius_ratio_square(dim, e->vertex),
                  r->radius_ratio * r->radius_ratio, seen);
    take_relative(e, RADIUS_RATIO, pl_radius_ratio_of_shape(dim, &shape), r->radius_ratio, seen);
    take_relative(e, CIRCUMRADIUS_TO_EDGE, pl_circumradius_to_edge(dim, &shape, longest),
                  r->circumradius_to_edge, seen);
    take_relative(e, EDGE_TO_INRADIUS, pl_edge_to_inradius(dim, &shape, longest),
                  r->edge_to_inradius, seen);
    take_relative(e, EDGE_RATIO, pl_edge_ratio(dim, e->vertex), r->edge_ratio, seen);
    take_relative(e, SMOOTHED_EDGE_RATIO, pl_smoothed_edge_ratio(dim, e->vertex),
                  sqrtq(element_edge_ratio_square(&e->jets).value), seen);
    take_relative(e, MEAN_RATIO, pl_mean_ratio(dim, e->vertex), r->mean_ratio, seen);
    take_relative(e, SCALED_JACOBIAN, pl_scaled_jacobian_of(dim, shape.determinant, squares.corner),
                  r->scaled_jacobian, seen);
    pl_angle_cosines(dim, e->vertex, &low, &high);
    take(e, SMALLEST_COSINE, low - cosine_of(r->largest_angle), 1, seen);
    take(e, LARGEST_COSINE, high - cosine_of(r->smallest_angle), 1, seen);
}

/** No element of a radius ratio that is called blunt has an angle as small as that. */
static void compare_acuteness(const element *e, figures *seen) {
    double edges[3][3] = {{0}};
    const double scale = 1 / sqrt(pl_edge_squares_at(e->dim, e->vertex).longest);
    pl_edges(e->dim, e->vertex, edges);
    for (int i = 0; i < 9; i++)
        edges[i / 3][i % 3] *= scale;
    const double acuteness = pl_acuteness(e->dim, edges, pl_determinant_of_edges(e->dim, edges));
    take_relative(e, ACUTENESS, acuteness, acuteness_of(e), seen);
    assert_true(pl_blunt_ratio_square(e->dim, (double)acuteness_of(e)) <=
                e->wanted.radius_ratio * e->wanted.radius_ratio);
}

static void compare_derivatives(const element *e, figures *seen) {
    const int dim = e->dim;
    const pl_derivatives found = dim == 3 ? pl_radius_ratio_derivatives(3, e->x[3], e->vertex)
                                          : pl_radius_ratio_derivatives(2, e->x[2], e->vertex);
    const jet wanted = element_radius_ratio_square(&e->jets);
    take(e, DERIVED_VALUE, found.value - wanted.value, wanted.size[0], seen);
    for (int d = 0; d < dim; d++)
        take(e, DERIVED_GRADIENT, found.gradient[d] - wanted.gradient[d], wanted.size[1], seen);
    for (int k = 0; k < 6; k++)
        if (jet_column[k] < dim)
            take(e, DERIVED_HESSIAN, found.hessian[jet_row[k]][jet_column[k]] - wanted.hessian[k],
                 wanted.size[2], seen);
}

/** What is reported of a mesh of this element alone is what the formulas say, however it was
 *  computed. */
static void compare_report(const element *e, figures *seen) {
    static const int32_t elements[] = {0, 1, 2, 3};
    static const uint8_t is_free[4];
    const int dim = e->dim;
    const reference *r = &e->wanted;
    double coordinates[12];
    planish_quality q;
    for (int i = 0; i < dim * (dim + 1); i++)
        coordinates[i] = e->x[i / dim][i % dim];
    const pl_view view = {
        .dim = dim, .n_nodes = dim + 1, .n_elements = 1, .elements = elements, .mobility = is_free};
    assert_int_equal(pl_measure(&view, coordinates, 1, &q, NULL), 0);
    const quad ratios[][2] = {{q.min_volume, e->determinant / (dim == 3 ? 6 : 2)},
                              {q.radius_ratio.min, r->radius_ratio},
                              {q.circumradius_to_edge.min, r->circumradius_to_edge},
                              {q.edge_to_inradius.min, r->edge_to_inradius},
                              {q.edge_ratio.min, r->edge_ratio},
                              {q.mean_ratio.min, r->mean_ratio},
                              {q.scaled_jacobian.min, r->scaled_jacobian}};
    for (int i = 0; i < 7; i++) {
        const quad error = fabsq(ratios[i][0] / ratios[i][1] - 1);
        seen->of_measure = fmaxl(seen->of_measure, (long double)error / (U * e->kappa));
    }
    const quad angles[][2] = {{q.min_angle_deg, r->smallest_angle},
                              {q.max_angle_deg, r->largest_angle}};
    for (int i = 0; i < 2; i++) {
        const quad error = fabsq(cosine_of(angles[i][0]) - cosine_of(angles[i][1]));
        seen->of_measure = fmaxl(seen->of_measure, (long double)error / (U * e->kappa));
    }
    assert_true(seen->of_measure <= 6);
    assert_int_equal(q.n_inverted, 0);
}

static void check(element *e, figures *seen) {
    seen->n++;
    if (!(U * e->kappa < LOST)) {
        seen->lost++;
        return;
    }
    e->wanted = reference_of(e->dim, e->vertex);
    compare_measures(e, seen);
    compare_acuteness(e, seen);
    compare_derivatives(e, seen);
    compare_report(e, seen);
}

static void measures_are_those_of_113_bits(void **state) {
    element e = {.dim = *(int *)*state};
    const int64_t elements = effort(400, 56000);
    uint64_t random = effort_seed((uint64_t)e.dim);
    figures seen = {{0}, 0, 0, 0};
    for (shape_kind kind = 0; kind < SHAPE_KINDS; kind++)
        for (int64_t i = 0; i < elements; i++) {
            draw(kind, &random, &e);
            check(&e, &seen);
        }
    figure("%d-D: %lld elements, %.1f %% lost; times u kappa:", e.dim, (long long)seen.n,
           100 * (double)seen.lost / (double)seen.n);
    for (int i = 0; i < QUANTITIES; i++)
        figure("    %-20s %.2Lf", quantities[i].name, seen.multiple[i]);
    figure("    %-20s %.2Lf", "as reported", seen.of_measure);
    assert_true(seen.lost < seen.n / 4);
}

#else

static void measures_are_those_of_113_bits(void **state) {
    (void)state;
    print_message("built without libquadmath\n");
    skip();
}

#endif

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        {"measures 2-D", measures_are_those_of_113_bits, NULL, NULL, &two},
        {"measures 3-D", measures_are_those_of_113_bits, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
