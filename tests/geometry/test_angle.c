/* Tests of src/geometry/angle.h: acuteness against angles by the inverse tangent, and that a radius
 * ratio that is called blunt is. */
#include "geometry/angle.h"

#include "support/meshes.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

typedef double simplex[4][3];

/** Angle between the facets opposite i and j, radians, in long double: between what is orthogonal
 *  to their common edge. */
static long double angle_between(int dim, const simplex x, int i, int j) {
    const int k = dim == 2 ? 3 - i - j : i != 0 && j != 0 ? 0 : i != 1 && j != 1 ? 1 : 2;
    const int l = dim == 2 ? k : 6 - i - j - k;
    long double e[3] = {0}, u[3] = {0}, v[3] = {0}, c[3];
    long double ee = 0, ue = 0, ve = 0, uv = 0, cross = 0;
    for (int d = 0; d < dim; d++) {
        e[d] = (long double)x[l][d] - x[k][d];
        u[d] = (long double)x[i][d] - x[k][d];
        v[d] = (long double)x[j][d] - x[k][d];
        ee += e[d] * e[d];
        ue += u[d] * e[d];
        ve += v[d] * e[d];
    }
    for (int d = 0; dim == 3 && d < 3; d++) {
        u[d] -= ue / ee * e[d];
        v[d] -= ve / ee * e[d];
    }
    for (int d = 0; d < 3; d++) {
        const int a = (d + 1) % 3, b = (d + 2) % 3;
        c[d] = u[a] * v[b] - u[b] * v[a];
        cross += c[d] * c[d];
        uv += u[d] * v[d];
    }
    return atan2l(sqrtl(cross), uv);
}

static long double smallest_angle(int dim, const simplex x) {
    long double smallest = INFINITY;
    for (int i = 0; i < dim; i++)
        for (int j = i + 1; j <= dim; j++)
            smallest = fminl(smallest, angle_between(dim, x, i, j));
    return smallest;
}

static double acuteness_of(int dim, const simplex x) {
    const double *vertex[4] = {x[0], x[1], x[2], x[3]};
    double edges[3][3];
    pl_edges(dim, vertex, edges);
    return pl_acuteness(dim, edges, pl_determinant_of_edges(dim, edges));
}

static double ratio_square_of(int dim, const simplex x) {
    const double *vertex[4] = {x[0], x[1], x[2], x[3]};
    return pl_radius_ratio_square(dim, vertex);
}

/** Vertices in the unit cube, some of them flattened, needles or wedges. */
static void random_simplex(int dim, unsigned *seed, simplex x) {
    const double thin = pow(10, -3 * test_random(seed));
    const int kind = (int)(4 * test_random(seed));
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = test_random(seed);
    for (int j = 0; j <= dim; j++)
        if (kind == 1)
            x[j][dim - 1] *= thin;
    for (int d = 0; d < dim; d++)
        if (kind == 2) /* a short edge */
            x[1][d] = x[0][d] + thin * (x[1][d] - x[0][d]);
        else if (kind == 3 && dim == 3) /* a vertex near the opposite face */
            x[0][d] = (x[1][d] + x[2][d] + x[3][d]) / 3 + thin * (x[0][d] - x[1][d]);
}

static void acuteness_is_that_of_the_smallest_angle(void **state) {
    enum { ELEMENTS = 20000 };
    (void)state;
    unsigned seed = 3;
    for (int dim = 2; dim <= 3; dim++)
        for (int i = 0; i < ELEMENTS; i++) {
            simplex x;
            random_simplex(dim, &seed, x);
            const long double sine = sinl(smallest_angle(dim, (const double(*)[3])x));
            const double acuteness = acuteness_of(dim, (const double(*)[3])x);
            if (ratio_square_of(dim, (const double(*)[3])x) < 1e12)
                assert_true(fabsl(acuteness * (sine * sine) - 1) < 1e-8L);
        }
}

/** Two edges of length 1 and width, orthogonal and distance apart: of all elements with a small
 *  angle the ones with the best RR are like that. */
static void wedge(int dim, double width, double distance, simplex x) {
    const double corner[4][3] = {
        {0, 0, 0.5}, {0, 0, -0.5}, {distance, width / 2, 0}, {distance, -width / 2, 0}};
    const double triangle[3][2] = {{0, 0}, {1, -width / 2}, {1, width / 2}};
    for (int j = 0; j <= dim; j++)
        for (int d = 0; d < dim; d++)
            x[j][d] = dim == 3 ? corner[j][d] : triangle[j][d];
}

static void blunt_elements_have_no_smaller_angle(void **state) {
    enum { ELEMENTS = 300000 };
    (void)state;
    unsigned seed = 4;
    for (int dim = 2; dim <= 3; dim++) {
        double nearest = INFINITY; /* RR^2 by the largest that is still blunt */
        for (int i = 0; i < ELEMENTS; i++) {
            simplex x;
            if (i % 2)
                random_simplex(dim, &seed, x);
            else
                wedge(dim, pow(10, -3 * test_random(&seed)), 0.1 + test_random(&seed), x);
            const double acuteness = acuteness_of(dim, (const double(*)[3])x);
            const double blunt = pl_blunt_ratio_square(dim, acuteness);
            const double quotient = ratio_square_of(dim, (const double(*)[3])x) / blunt;
            assert_true(blunt >= 1 - 1e-8 && quotient >= 1);
            if (acuteness > 30)
                nearest = fmin(nearest, quotient);
        }
        assert_true(nearest < (dim == 3 ? 1.6 : 1 + 1e-6)); /* in the plane it is sharp */
    }
}

/** Two facets at an edge along z enclose the angle whose cosine and sine are c and s: a
 * tetrahedron, or in the plane a triangle with that angle. */
static pl_shape with_angle(int dim, double c, double s) {
    const double solid[3][3] = {{0, 0, 1}, {1, 0, 0.5}, {c, s, 0.5}};
    const double flat[3][3] = {{1, 0, 0}, {c, s, 0}, {0}};
    return pl_shape_of_edges(dim, dim == 3 ? solid : flat);
}

static void tiny_and_flat_angles_have_all_their_digits(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (double degrees = 40; degrees > 1e-9; degrees *= 0.37) {
            const double radians = degrees / 57.295779513082320877;
            const double c = cos(radians), s = sin(radians);
            const long double angle = atan2l((long double)s, (long double)c);
            const pl_shape tiny = with_angle(dim, c, s), wide = with_angle(dim, -c, s);
            assert_true(fabsl(pl_smallest_angle(&tiny) / angle - 1) < 1e-15L);
            const long double rest = 3.14159265358979323846264338327950288L - angle;
            assert_true(fabsl(pl_largest_angle(&wide) - rest) < 1e-15L);
        }
}

static void blunt_has_its_ends(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++) {
        assert_true(pl_blunt_ratio_square(dim, INFINITY) == INFINITY);
        assert_true(pl_blunt_ratio_square(dim, 0) == 0);
        assert_true(pl_blunt_ratio_square(dim, 1) == 0);
        double last = 0;
        for (double acuteness = 4.0 / 3; acuteness < 1e20; acuteness *= 1.1) {
            const double blunt = pl_blunt_ratio_square(dim, acuteness);
            assert_true(blunt >= last * (1 - 1e-12) && blunt < INFINITY);
            last = blunt;
        }
        assert_true(pl_blunt_ratio_square(dim, 1e40) == 0); /* rounding: nothing is known */
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(acuteness_is_that_of_the_smallest_angle),
        cmocka_unit_test(blunt_elements_have_no_smaller_angle),
        cmocka_unit_test(tiny_and_flat_angles_have_all_their_digits),
        cmocka_unit_test(blunt_has_its_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
