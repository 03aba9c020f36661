/* The kernels' sums over stars of elements of all shapes, from regular to nearly degenerate,
 * against 113 bits: value, gradient and Hessian of all objectives and of the energy of untangling.
 *
 * What is asked for. With u = 2^-53 an element's D = (x - p0) . (b x c), b and c the edges of its
 * link facet from p0, is known to u |x - p0| |b|_1 |c|_1, and the area |e x r| of a face at x to
 * u |e| |r|, r the longer one of its edges at x. What is made of them is as well known as both:
 *
 *     kappa = 1 + |x - p0| |b|_1 |c|_1 / |D| + largest |e| |r| / |e x r|
 *
 * without the areas where there are none, and without D for the smoothed edge ratio. The energy's
 * u + sqrt(u^2 + epsilon^2) is the better known the larger epsilon is:
 *
 *     kappa = 1 + |b|_1 |c|_1 / |b x c| + |x - p0| |b|_1 |c|_1 / D* (1 + 1 / sqrt(u^2 + epsilon^2))
 *
 * In the plane there is no c. Errors are compared with the sizes of jets.h: of value, gradient and
 * Hessian with the terms of calculus taken absolutely, as they cancel in any formula,
 *
 *     |error| <= multiple * u * sum over the elements of kappa * size
 *
 * The multiples are stated below; figures tell the largest ones seen. Stars with u kappa above LOST
 * are known by nothing but their signs. Besides, `error` of a kernel, which is that of D, bounds
 * with that of the areas the relative error of its sum and largest value, and `certain` means that
 * all elements are positive. */
#include "star/star.h"

#include "support/effort.h"
#include "support/small_star.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#ifdef PLANISH_HAVE_QUADMATH
#include "support/element_jets.h"

static const long double U = 0x1p-53L, LOST = 1e-4L;
static const double THINNEST = 1e-9;

/** What is evaluated: the plain kernel's sum, the guarded kernel's, the energy. */
enum { PLAIN, RADIUS, MEAN, EDGE, WORST_OF_RATIOS, WORST_OF_ANGLES, ENERGY, FUNCTIONS };
static const char *const function_name[FUNCTIONS] = {
    "plain",       "guarded radius ratio", "mean ratio", "edge ratio",
    "worst ratio", "worst angle",          "energy"};
static const int measure_of[FUNCTIONS] = {0,
                                          PLANISH_OBJECTIVE_RADIUS_RATIO,
                                          PLANISH_OBJECTIVE_MEAN_RATIO,
                                          PLANISH_OBJECTIVE_EDGE_RATIO,
                                          PL_WORST_RATIO,
                                          PL_WORST_ANGLE,
                                          PLANISH_OBJECTIVE_RADIUS_RATIO};
/* The multiples of value, gradient and Hessian; 32nd powers, and so the shares of edges in the
 * smoothed ratio, have 32 times the error. */
static const double allowed[FUNCTIONS][3] = {
    {8, 8, 8}, {8, 8, 8}, {8, 8, 8}, {8, 256, 256}, {256, 256, 256}, {256, 256, 256}, {8, 8, 8}};

/* ---- stars ---------------------------------------------------------------------------------- */

/** A star with all that is asked of it. */
typedef struct star_case {
    hand_star s;
    pl_star_guard guard;
    pl_star_untangling asked;
    uint8_t in_patch[HAND_STAR_MAX_NODES];
    double size[HAND_STAR_MAX_NODES];
    int exponent; /* the reference computes with coordinates times 2^-exponent */
} star_case;

/** Corner j of the link, or the node. */
static const double *corner(const star_case *c, int64_t facet, int j) {
    const int dim = c->s.dim;
    return c->s.coordinates + (j < dim ? (1 + c->s.link[facet * dim + j]) * dim : 0);
}

static void ask(star_case *c, uint64_t *random) {
    memset(c->in_patch, 0, sizeof c->in_patch);
    c->in_patch[0] = 1;
    for (int i = 0; i < HAND_STAR_MAX_NODES; i++)
        c->size[i] = ldexp(random_between(random, 0.3, 3), c->exponent);
    c->guard = (pl_star_guard){.ratio_weight = 1, .worst_limit = 1};
    c->asked = (pl_star_untangling){
        .in_patch = c->in_patch, .size = c->size, .epsilon = exp2(random_between(random, -20, 1))};
}

/* ---- elements as jets ----------------------------------------------------------------------- */

/** Coordinates relative to the node, in the star's scale. */
static element_jets jets_of(const star_case *c, int64_t facet) {
    const int dim = c->s.dim;
    element_jets e = {.dim = dim};
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++) {
            const quad a = (quad)corner(c, facet, j)[d] - (quad)corner(c, facet, dim)[d];
            e.vertex[j][d] = jet_constant(ldexpq(a, -c->exponent));
            if (j == dim)
                e.vertex[j][d] = jet_variable(0, d);
        }
    for (int d = dim; d < 3; d++)
        for (int j = 0; j <= dim; j++)
            e.vertex[j][d] = jet_constant(0);
    return e;
}

/** |b|_1 |c|_1, see above. */
static long double base_of(const element_jets *e) {
    quad product = 1;
    for (int j = 1; j < e->dim; j++) {
        quad norm = 0;
        for (int d = 0; d < e->dim; d++)
            norm += fabsq(e->vertex[j][d].value - e->vertex[0][d].value);
        product *= norm;
    }
    return (long double)product;
}

/** kappa |D|. */
static long double permanent_of(const element_jets *e) {
    quad square = 0;
    for (int d = 0; d < e->dim; d++)
        square += e->vertex[0][d].value * e->vertex[0][d].value;
    return (long double)sqrtq(square) * base_of(e);
}

/** The largest |e| |r| / |e x r| of the faces at x, r the longer edge from x. */
static long double face_kappa_of(const element_jets *e) {
    long double largest = 0;
    for (int j = 0; e->dim == 3 && j < 3; j++) {
        const int next = (j + 1) % 3;
        const quad longer = fmaxq(element_square(e, j, 3).value, element_square(e, next, 3).value);
        const quad square = element_square(e, j, next).value * longer;
        largest =
            fmaxl(largest, (long double)sqrtq(square / element_area_square(e, j, next, 3).value));
    }
    return largest;
}

/** What grad D = n is known to. */
static long double slope_kappa_of(const element_jets *e) {
    return base_of(e) / element_determinant(e).size[1];
}

/** What an element adds to a star's function. */
typedef struct part {
    jet f;
    long double kappa, faces; /* faces: the part of kappa that areas have */
} part;

static jet sum_of_powers(const jet *angle, int n, double limit) {
    jet sum = jet_constant(0);
    for (int k = 0; k < n; k++)
        sum = jet_sum(sum, 1, jet_power_32(jet_scaled(1 / (quad)limit, angle[k])));
    return sum;
}

static jet aspect_of(const star_case *c, const element_jets *e, int function) {
    jet angle[6];
    switch (function) {
    case MEAN:
        return element_mean_ratio_square(e);
    case EDGE:
        return element_edge_ratio_square(e);
    case WORST_OF_RATIOS:
        return jet_power_32(
            jet_scaled(1 / (quad)c->guard.worst_limit, element_radius_ratio_square(e)));
    case WORST_OF_ANGLES:
        element_angles(e, angle);
        return sum_of_powers(angle, element_n_edges(e->dim), c->guard.worst_limit);
    default:
        return element_radius_ratio_square(e);
    }
}

/* ---- the energy of untangling --------------------------------------------------------------- */

/** T chi^(-2/dim) + (1 + m^2) / (2 chi) with chi = (u + sqrt(u^2 + epsilon^2)) / 2, m = u. */
static jet barrier_of(jet u, jet t, quad epsilon, int dim) {
    const quad s = sqrtq(u.value * u.value + epsilon * epsilon);
    const quad chi = u.value > 0 ? (u.value + s) / 2 : epsilon * epsilon / (s - u.value) / 2;
    /* log chi has the derivative 1 / s */
    const quad of_log = -u.value / (s * s * s), p = (quad)2 / dim, power = powq(chi, -p);
    const jet first = jet_function(u, power, -p * power / s, p * power * (p / (s * s) - of_log));
    const jet second = jet_function(u, 1 / chi, -1 / (chi * s), 1 / chi * (1 / (s * s) - of_log));
    const jet square = jet_sum(jet_constant(1), 1, jet_product(u, u));
    return jet_sum(jet_product(t, first), 0.5Q, jet_product(square, second));
}

static part energy_of(const star_case *c, const element_jets *e, int64_t facet) {
    const int dim = e->dim, n = element_n_edges(dim);
    quad h = c->size[0], epsilon = c->asked.epsilon;
    jet square[6], t = jet_constant(0);
    for (int j = 0; j < dim; j++)
        h += c->size[1 + c->s.link[facet * dim + j]];
    h = ldexpq(h / (dim + 1), -c->exponent);
    const quad target = (dim == 3 ? sqrtq(2) / 2 * h : sqrtq(3) / 2) * h * h;
    const jet u = jet_scaled(1 / target, element_determinant(e));
    element_squares(e, square);
    for (int k = 0; k < n; k++)
        t = jet_sum(t, 1 / (n * h * h), square[k]);
    part p = {.f = barrier_of(u, t, epsilon, dim)};
    /* the same as a function of u alone: its curvature is left out where it is negative */
    const quad bend =
        barrier_of(jet_variable(u.value, 0), jet_constant(t.value), epsilon, dim).hessian[0];
    for (int k = 0; k < 6 && bend < 0; k++)
        p.f.hessian[k] -= bend * u.gradient[jet_row[k]] * u.gradient[jet_column[k]];
    const quad s = sqrtq(u.value * u.value + epsilon * epsilon);
    p.kappa =
        1 + slope_kappa_of(e) + permanent_of(e) / (long double)target * (1 + 1 / (long double)s);
    return p;
}

static int is_of_faces(int function) {
    return function != MEAN && function != EDGE && function != ENERGY;
}

static part part_of(const star_case *c, int64_t facet, int function) {
    const element_jets e = jets_of(c, facet);
    if (function == ENERGY)
        return energy_of(c, &e, facet);
    part p = {.f = aspect_of(c, &e, function), .kappa = 1};
    p.faces = is_of_faces(function) ? face_kappa_of(&e) : 0;
    p.kappa += p.faces;
    if (function != EDGE)
        p.kappa += permanent_of(&e) / (long double)fabsq(element_determinant(&e).value);
    return p;
}

/** All elements of the star; errors are to be compared with the sizes. */
typedef struct expected {
    jet f;
    quad largest;
    long double kappa, faces, least; /* the largest of both; the smallest D */
} expected;

static expected expected_of(const star_case *c, int function) {
    expected sum = {.f = jet_constant(0), .largest = 0, .least = INFINITY};
    for (int64_t i = 0; i < c->s.link_offset[1]; i++) {
        part p = part_of(c, i, function);
        const element_jets e = jets_of(c, i);
        for (int k = 0; k < 3; k++)
            p.f.size[k] *= p.kappa;
        sum.f = jet_sum(sum.f, 1, p.f);
        sum.largest = fmaxq(sum.largest, p.f.value);
        sum.kappa = fmaxl(sum.kappa, p.kappa);
        sum.faces = fmaxl(sum.faces, p.faces);
        sum.least = fminl(sum.least, (long double)element_determinant(&e).value);
    }
    return sum;
}

/* ---- comparisons ---------------------------------------------------------------------------- */

/** The largest multiples seen, of value, gradient and Hessian. */
typedef struct figures {
    long double multiple[3], of_error; /* and of the error that a kernel states */
    int64_t n, lost, uncertain;
} figures;

/** Where everything comes to, with coordinates times 2^-exponent. */
typedef struct found {
    double sum, gradient[3], hessian[6];
} found;

static void rescale(found *f, int exponent) {
    for (int d = 0; d < 3; d++)
        f->gradient[d] = ldexp(f->gradient[d], exponent);
    for (int k = 0; k < 6; k++)
        f->hessian[k] = ldexp(f->hessian[k], 2 * exponent);
}

static void show(const star_case *c, int function, const expected *e, const long double *multiple) {
    print_error("%s: %Lg %Lg %Lg times kappa u, kappa %Lg; node, then link:\n",
                function_name[function], multiple[0], multiple[1], multiple[2], e->kappa);
    for (int i = 0; i <= c->s.ring_offset[1]; i++)
        for (int d = 0; d < c->s.dim; d++)
            print_error("%a%s", c->s.coordinates[i * c->s.dim + d], d + 1 < c->s.dim ? ", " : "\n");
}

static void compare(const star_case *c, int function, const expected *e, const found *f,
                    figures *seen) {
    long double error[3] = {(long double)fabsq(f->sum - e->f.value), 0, 0}, multiple[3];
    for (int d = 0; d < c->s.dim; d++)
        error[1] = fmaxl(error[1], (long double)fabsq(f->gradient[d] - e->f.gradient[d]));
    for (int k = 0, at = 0; k < 6; k++)
        if (jet_column[k] < c->s.dim) {
            error[2] = fmaxl(error[2], (long double)fabsq(f->hessian[at] - e->f.hessian[k]));
            at++;
        }
    int fine = 1;
    for (int k = 0; k < 3; k++) {
        multiple[k] = error[k] / (U * e->f.size[k]);
        fine &= multiple[k] <= allowed[function][k];
        seen->multiple[k] = fmaxl(seen->multiple[k], multiple[k]);
    }
    if (!fine)
        show(c, function, e, multiple);
    assert_true(fine);
}

/** The relative errors of sum and largest value are below the one that the kernel states, which is
 *  of D, and what the areas add. */
static void compare_error(const star_case *c, int function, const expected *e,
                          const pl_star_value *value, figures *seen) {
    const long double of_sum = fabsl((long double)(value->sum / e->f.value - 1));
    const long double of_max = fabsl((long double)(value->max / e->largest - 1));
    const long double of_areas = (long double)allowed[function][0] * U * e->faces;
    const long double part_of_it = fmaxl(of_sum, of_max) / (value->error + of_areas);
    seen->of_error = fmaxl(seen->of_error, part_of_it);
    if (part_of_it > 1)
        show(c, function, e, (long double[3]){of_sum / U, of_max / U, value->error / U});
    assert_true(part_of_it <= 1);
}

static pl_star_value evaluate(star_case *c, int function, int with_derivatives) {
    pl_star_value value;
    const pl_star_kernel *kernel = pl_star_kernel_select(PLANISH_ISA_AUTO);
    c->guard.objective = measure_of[function];
    c->s.problem.guard = function == PLAIN ? NULL : &c->guard;
    (function == PLAIN ? kernel->evaluate : kernel->guarded->evaluate)[c->s.dim - 2](
        &c->s.problem, 0, c->s.scratch, with_derivatives, &value);
    return value;
}

/** Without the Hessian the plain kernel has another formula for the gradient. */
static void check_gradient_alone(star_case *c, const expected *e, const found *both,
                                 figures *seen) {
    const pl_star_value value = evaluate(c, PLAIN, PL_GRADIENT_ALONE);
    found f = *both;
    assert_true(value.sum == both->sum);
    memcpy(f.gradient, value.gradient, sizeof f.gradient);
    for (int d = 0; d < 3; d++)
        f.gradient[d] = ldexp(f.gradient[d], c->exponent);
    compare(c, PLAIN, e, &f, seen);
}

static found energy(star_case *c) {
    pl_star_slope slope;
    found f = {0};
    c->s.problem.guard = &c->guard;
    c->s.problem.untangling = &c->asked;
    const pl_star_energy of_star =
        pl_star_kernel_select(PLANISH_ISA_AUTO)
            ->guarded->energy[c->s.dim - 2](&c->s.problem, 0, 1, c->s.scratch, &slope);
    f.sum = pl_sum_value(&of_star.sum);
    c->s.problem.untangling = NULL;
    memcpy(f.gradient, slope.gradient, sizeof f.gradient);
    memcpy(f.hessian, slope.hessian, sizeof f.hessian);
    return f;
}

static void check_energy(star_case *c, figures *seen) {
    const expected e = expected_of(c, ENERGY);
    found f = energy(c);
    seen->n += c->s.link_offset[1];
    if (U * e.kappa > LOST) {
        seen->lost += c->s.link_offset[1];
        return;
    }
    rescale(&f, c->exponent);
    compare(c, ENERGY, &e, &f, seen);
}

/** With a limit for the worst that they are around. */
static void check_aspect(star_case *c, int function, uint64_t *random, figures *seen) {
    c->guard.worst_limit = 1;
    if (function == WORST_OF_RATIOS)
        c->guard.worst_limit =
            (double)expected_of(c, RADIUS).largest * random_between(random, 0.3, 1.5);
    if (function == WORST_OF_ANGLES)
        c->guard.worst_limit = (double)powq(expected_of(c, WORST_OF_ANGLES).largest, 1 / 32.0Q) *
                               random_between(random, 0.3, 1.5);
    const expected e = expected_of(c, function);
    const pl_star_value value = evaluate(c, function, 1);
    seen->n += c->s.link_offset[1];
    assert_true(!value.certain || e.least > 0);
    seen->uncertain += value.certain ? 0 : c->s.link_offset[1];
    /* elements that are positive by their true measure alone have no part in the derivatives */
    if (!(e.least > 0) || U * e.kappa > LOST || (function == EDGE && !value.certain)) {
        seen->lost += c->s.link_offset[1];
        return;
    }
    found f = {.sum = value.sum};
    memcpy(f.gradient, value.gradient, sizeof f.gradient);
    memcpy(f.hessian, value.hessian, sizeof f.hessian);
    rescale(&f, c->exponent);
    compare(c, function, &e, &f, seen);
    compare_error(c, function, &e, &value, seen);
    if (function == PLAIN)
        check_gradient_alone(c, &e, &f, seen);
}

static void check(star_case *c, int function, uint64_t *random, figures *seen) {
    if (function == ENERGY)
        check_energy(c, seen);
    else
        check_aspect(c, function, random, seen);
}

static void print_figures(int dim, int function, const figures *seen) {
    figure("%d-D %-20s %7lld elements (%.1f %% lost, %.1f %% uncertain): value %.2Lf, gradient "
           "%.2Lf, Hessian %.2Lf times kappa u; %.3Lf of the error stated",
           dim, function_name[function], (long long)seen->n,
           100 * (double)seen->lost / (double)seen->n,
           100 * (double)seen->uncertain / (double)seen->n, seen->multiple[0], seen->multiple[1],
           seen->multiple[2], seen->of_error);
}

static void stars_are_those_of_113_bits(void **state) {
    const int dim = *(int *)*state;
    const int64_t stars = effort(30, 2000);
    star_case c;
    hand_star_create(&c.s, dim, 0, 1);
    for (int function = 0; function < FUNCTIONS; function++) {
        uint64_t random = effort_seed((uint64_t)(100 * dim + function));
        figures seen = {{0}, 0, 0, 0, 0};
        for (shape_kind kind = 0; kind < SHAPE_KINDS; kind++)
            for (int64_t i = 0; i < stars; i++) {
                const double thin = pow(THINNEST, random_unit(&random));
                c.exponent = small_star_draw(&c.s, kind, thin, &random);
                ask(&c, &random);
                check(&c, function, &random, &seen);
            }
        print_figures(dim, function, &seen);
    }
    hand_star_destroy(&c.s);
}

#else

static void stars_are_those_of_113_bits(void **state) {
    (void)state;
    print_message("built without libquadmath\n");
    skip();
}

#endif

int main(void) {
    static int two = 2, three = 3;
    const struct CMUnitTest tests[] = {
        {"stars 2-D", stars_are_those_of_113_bits, NULL, NULL, &two},
        {"stars 3-D", stars_are_those_of_113_bits, NULL, NULL, &three},
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
