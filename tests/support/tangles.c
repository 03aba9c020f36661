/* tangles: valid meshes of several shapes, and ways to tangle them.
 *
 * A shape is a part of a lattice of cells, whose inner nodes are pushed about a little before all
 * nodes are mapped.
 */
#include "support/tangles.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

/* ---- shapes -------------------------------------------------------------------------------- */

/** The lattice of a shape: cells in each direction, those of the hole are from .. to - 1. */
typedef struct lattice {
    int dim, cells, width, from, to; /* width: in all directions but the first */
} lattice;

static lattice lattice_of(int dim, test_shape shape, int fineness) {
    lattice l = {dim, dim == 3 ? 6 : 12, 0, 0, 0};
    if (shape == TEST_BAR)
        l.cells = dim == 3 ? 16 : 40;
    if (shape == TEST_GRADED)
        l.cells = dim == 3 ? 8 : 16;
    if (shape == TEST_RING) {
        l.cells = dim == 3 ? 7 : 12;
        l.from = dim == 3 ? 3 : 5;
        l.to = dim == 3 ? 4 : 7;
    }
    l.width = shape == TEST_BAR ? 4 : l.cells;
    l.cells *= fineness;
    l.width *= fineness;
    l.from *= fineness;
    l.to *= fineness;
    return l;
}

static int has_cell(const lattice *l, const int *cell) {
    int in_hole = l->to > 0, inside = 1;
    for (int d = 0; d < l->dim; d++) {
        in_hole &= cell[d] >= l->from && cell[d] < l->to;
        inside &= cell[d] >= 0 && cell[d] < (d == 0 ? l->cells : l->width);
    }
    return inside && !in_hole;
}

/** Whether all cells around the node at x are there. */
static int is_inner(const lattice *l, const double *x) {
    int inner = 1;
    for (int corner = 0; corner < 1 << l->dim; corner++) {
        int cell[3];
        for (int d = 0; d < l->dim; d++)
            cell[d] = (int)x[d] - (corner >> d & 1);
        inner &= has_cell(l, cell);
    }
    return inner;
}

/** The cell of an element of the lattice: that of its lowest corner. */
static int has_element(const lattice *l, const test_mesh *mesh, int64_t element) {
    int cell[3] = {l->cells, l->cells, l->cells};
    for (int j = 0; j <= l->dim; j++)
        for (int d = 0; d < l->dim; d++) {
            const int32_t node = mesh->elements[element * (l->dim + 1) + j];
            const int x = (int)mesh->coordinates[(int64_t)node * l->dim + d];
            cell[d] = x < cell[d] ? x : cell[d];
        }
    return has_cell(l, cell);
}

/** Drop what the lattice does not have. */
static void carve(const lattice *l, test_mesh *mesh) {
    const int dim = l->dim;
    int32_t *number = malloc((size_t)mesh->mesh.n_nodes * sizeof *number);
    double *x = malloc((size_t)(mesh->mesh.n_nodes * dim) * sizeof *x);
    int32_t *element = malloc((size_t)(mesh->mesh.n_elements * (dim + 1)) * sizeof *element);
    int32_t n = 0;
    int64_t m = 0;
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++)
        number[i] = -1;
    for (int64_t i = 0; i < mesh->mesh.n_elements; i++) {
        if (!has_element(l, mesh, i))
            continue;
        for (int j = 0; j <= dim; j++) {
            const int32_t node = mesh->elements[i * (dim + 1) + j];
            if (number[node] < 0) {
                memcpy(x + n * dim, mesh->coordinates + node * dim, (size_t)dim * sizeof *x);
                number[node] = n++;
            }
            element[m * (dim + 1) + j] = number[node];
        }
        m++;
    }
    test_mesh_destroy(mesh);
    test_mesh_create(mesh, dim, n, x, m, element);
    free(number);
    free(x);
    free(element);
}

/** Turn x in the plane of the first two directions around (middle, middle). */
static void turn(double *x, double middle, double angle) {
    const double a = x[0] - middle, b = x[1] - middle;
    x[0] = middle + cos(angle) * a - sin(angle) * b;
    x[1] = middle + sin(angle) * a + cos(angle) * b;
}

/** The node at x of the lattice, in the shape. */
static void deform(const lattice *l, test_shape shape, double *x) {
    const int dim = l->dim;
    const double half = 0.5 * l->cells, hole = 0.5 * (l->to - l->from);
    double far = 0, largest = 0;
    for (int d = 0; d < dim; d++) {
        largest = fmax(largest, fabs(x[d] / l->cells));
        far = fmax(far, fabs(x[d] - half));
    }
    if (shape == TEST_GRADED) /* along the rays from the corner */
        for (int d = 0; d < dim; d++)
            x[d] *= exp(log(1e4) * (largest - 1));
    if (shape == TEST_RING)
        turn(x, half, (dim == 3 ? 0.9 : 0.6) * (half - fmax(far, hole)) / (half - hole));
    if (shape == TEST_BENT) {
        const double radius = 0.4 * l->cells + x[1], angle = 0.5 * PI * (1 - x[0] / l->cells);
        x[0] = radius * cos(angle);
        x[1] = radius * sin(angle);
    }
    if (shape == TEST_WAVY && dim == 2)
        x[1] += 0.3 * l->cells * sin(2 * PI * x[0] / l->cells);
    if (shape == TEST_WAVY && dim == 3)
        turn(x, half, 0.5 * PI * x[2] / l->cells);
    if (shape == TEST_PINCHED) {
        const double middle = sin(PI * x[0] / l->cells);
        for (int d = 1; d < dim; d++)
            x[d] = half + (x[d] - half) * (1 - 0.7 * middle);
    }
}

int test_shape_is_deformed(test_shape shape) {
    return shape == TEST_RING || shape == TEST_BENT || shape == TEST_WAVY || shape == TEST_PINCHED;
}

/** Mean length of the edges of each node; an edge counts once for each of its elements. */
static void find_sizes(test_tangle *t) {
    const int dim = t->mesh.mesh.dim;
    const int64_t n = t->mesh.mesh.n_nodes;
    int *edges = calloc((size_t)n, sizeof *edges);
    memset(t->size, 0, (size_t)n * sizeof *t->size);
    for (int64_t i = 0; i < t->mesh.mesh.n_elements * (dim + 1); i++)
        for (int k = 0; k <= dim; k++) {
            const int32_t a = t->mesh.elements[i];
            const int32_t b = t->mesh.elements[i / (dim + 1) * (dim + 1) + k];
            double far = 0;
            for (int d = 0; d < dim; d++)
                far = hypot(far, t->valid[a * dim + d] - t->valid[b * dim + d]);
            t->size[a] += far;
            edges[a] += a != b;
        }
    for (int64_t i = 0; i < n; i++)
        t->size[i] /= edges[i];
    free(edges);
}

void test_tangle_create(test_tangle *t, int dim, test_shape shape, int fineness, unsigned seed) {
    const lattice l = lattice_of(dim, shape, fineness);
    test_mesh_box(&t->mesh, dim, l.cells);
    carve(&l, &t->mesh);
    const int64_t n = t->mesh.mesh.n_nodes;
    int32_t *number = malloc((size_t)n * sizeof *number);
    test_mesh_renumber(&t->mesh, seed * 2654435761u, number);
    t->is_inner = malloc((size_t)n);
    t->size = malloc((size_t)n * sizeof *t->size);
    t->valid = malloc((size_t)(n * dim) * sizeof *t->valid);
    t->before = malloc((size_t)(n * dim) * sizeof *t->before);
    for (int64_t i = 0; i < n; i++) {
        double *x = t->mesh.coordinates + i * dim;
        t->is_inner[i] = (uint8_t)is_inner(&l, x);
        for (int d = 0; d < dim; d++)
            x[d] += t->is_inner[i] ? 0.2 * (test_random(&seed) - 0.5) : 0;
        memcpy(t->before + i * dim, x, (size_t)dim * sizeof *x);
        deform(&l, shape, x);
        memcpy(t->valid + i * dim, x, (size_t)dim * sizeof *x);
    }
    find_sizes(t);
    free(number);
}

void test_tangle_destroy(test_tangle *t) {
    test_mesh_destroy(&t->mesh);
    free(t->valid);
    free(t->before);
    free(t->size);
    free(t->is_inner);
}

/* ---- tangles ------------------------------------------------------------------------------- */

static int32_t random_inner_node(const test_tangle *t, unsigned *random) {
    for (;;) {
        const int32_t node = (int32_t)(test_random(random) * (double)t->mesh.mesh.n_nodes);
        if (t->is_inner[node])
            return node;
    }
}

/** Put an inner node where another one is. */
static void join(test_tangle *t, int32_t node, int32_t other) {
    const int dim = t->mesh.mesh.dim;
    if (t->is_inner[node])
        memmove(t->mesh.coordinates + node * dim, t->mesh.coordinates + other * dim,
                (size_t)dim * sizeof(double));
}

static double distance(const test_tangle *t, int32_t a, int32_t b) {
    const int dim = t->mesh.mesh.dim;
    double far = 0;
    for (int d = 0; d < dim; d++)
        far = hypot(far, t->valid[a * dim + d] - t->valid[b * dim + d]);
    return far;
}

/** Move each inner node with this probability, but at least one, by up to three sizes. */
static void move(test_tangle *t, double part, unsigned *random) {
    const int dim = t->mesh.mesh.dim;
    const int32_t certain = random_inner_node(t, random);
    for (int32_t i = 0; i < t->mesh.mesh.n_nodes; i++)
        if (t->is_inner[i] && (i == certain || test_random(random) < part))
            for (int d = 0; d < dim; d++)
                t->mesh.coordinates[i * dim + d] +=
                    t->size[i] * ((i == certain && d == 0 ? 5 : 4 * test_random(random)) - 2);
}

/** A random element with an inner node; its nodes. */
static const int32_t *random_element(const test_tangle *t, int *inner, unsigned *random) {
    const int dim = t->mesh.mesh.dim;
    for (;;) {
        const int64_t i = (int64_t)(test_random(random) * (double)t->mesh.mesh.n_elements);
        *inner = (int)(test_random(random) * (dim + 1));
        if (t->is_inner[t->mesh.elements[i * (dim + 1) + *inner]])
            return t->mesh.elements + i * (dim + 1);
    }
}

/** Put a node of an element to a neighbour, or to the middle of the facet opposite. */
static void flatten(test_tangle *t, int to_neighbour, unsigned *random) {
    const int dim = t->mesh.mesh.dim;
    int inner;
    const int32_t *node = random_element(t, &inner, random);
    if (to_neighbour) {
        join(t, node[inner], node[(inner + 1) % (dim + 1)]);
        return;
    }
    for (int d = 0; d < dim; d++) {
        double sum = 0;
        for (int j = 0; j <= dim; j++)
            sum += j == inner ? 0 : t->mesh.coordinates[node[j] * dim + d];
        t->mesh.coordinates[node[inner] * dim + d] = sum / dim;
    }
}

static void swap(test_tangle *t, int32_t a, int32_t b) {
    const int dim = t->mesh.mesh.dim;
    for (int d = 0; d < dim; d++) {
        const double x = t->mesh.coordinates[a * dim + d];
        t->mesh.coordinates[a * dim + d] = t->mesh.coordinates[b * dim + d];
        t->mesh.coordinates[b * dim + d] = x;
    }
}

void test_tangle_apply(test_tangle *t, test_tangling tangling, unsigned seed) {
    enum { TIMES = 5 };
    const int dim = t->mesh.mesh.dim;
    const int64_t n = t->mesh.mesh.n_nodes;
    unsigned random = seed * 2246822519u + 3;
    memcpy(t->mesh.coordinates, t->valid, (size_t)(n * dim) * sizeof *t->valid);
    const int32_t one = random_inner_node(t, &random);
    if (tangling == TEST_MOVED_FEW || tangling == TEST_MOVED_HALF || tangling == TEST_MOVED_ALL)
        move(t, tangling == TEST_MOVED_FEW ? 0.01 : tangling == TEST_MOVED_HALF ? 0.5 : 1, &random);
    if (tangling == TEST_THROWN)
        t->mesh.coordinates[one * dim] += 1e3 * t->size[one];
    if (tangling == TEST_ALL_IN_ONE)
        for (int32_t i = 0; i < n; i++)
            join(t, i, one);
    if (tangling == TEST_LEFT_BEHIND)
        for (int32_t i = 0; i < n; i++)
            if (t->is_inner[i])
                memcpy(t->mesh.coordinates + i * dim, t->before + i * dim,
                       (size_t)dim * sizeof(double));
    for (int k = 0; k < TIMES; k++) {
        if (tangling == TEST_DUPLICATES || tangling == TEST_FLAT)
            flatten(t, tangling == TEST_DUPLICATES, &random);
        if (tangling == TEST_SWAPPED)
            swap(t, random_inner_node(t, &random), random_inner_node(t, &random));
        const int32_t middle = random_inner_node(t, &random);
        for (int32_t i = 0; tangling == TEST_GROUPS && i < n; i++)
            if (distance(t, i, middle) < 2 * t->size[middle])
                join(t, i, middle);
    }
}
