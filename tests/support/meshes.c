/* meshes: small meshes for tests, made by rule or by hand. */
#include "support/meshes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double test_random(unsigned *state) {
    *state = *state * 1664525u + 1013904223u;
    return (double)(*state >> 8) / (1 << 24);
}

static int64_t random_below(unsigned *state, int64_t n) {
    return (int64_t)(test_random(state) * (double)n);
}

static void *checked(void *memory) {
    if (!memory)
        abort();
    return memory;
}

/** Room for the mesh; contents are the caller's. */
static void allocate(test_mesh *mesh, int dim, int64_t n_nodes, int64_t n_elements) {
    mesh->coordinates = checked(malloc((size_t)(n_nodes * dim) * sizeof(double) + 1));
    mesh->elements = checked(malloc((size_t)(n_elements * (dim + 1)) * sizeof(int32_t) + 1));
    mesh->mesh = (planish_mesh){.dim = dim,
                                .n_nodes = n_nodes,
                                .n_elements = n_elements,
                                .coordinates = mesh->coordinates,
                                .elements = mesh->elements};
}

void test_mesh_create(test_mesh *mesh, int dim, int64_t n_nodes, const double *coordinates,
                      int64_t n_elements, const int32_t *elements) {
    unsigned state = 1;
    allocate(mesh, dim, n_nodes, n_elements);
    for (int64_t i = 0; i < n_nodes * dim; i++)
        mesh->coordinates[i] = coordinates ? coordinates[i] : test_random(&state);
    memcpy(mesh->elements, elements, (size_t)(n_elements * (dim + 1)) * sizeof *elements);
}

void test_mesh_destroy(test_mesh *mesh) {
    free(mesh->coordinates);
    free(mesh->elements);
    *mesh = (test_mesh){0};
}

/* ---- the box ------------------------------------------------------------------------------ */

/** The orders in which a path from corner to corner can take the axes, odd ones second. */
static const int paths_2d[2][3] = {{0, 1}, {1, 0}};
static const int paths_3d[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1},
                                   {0, 2, 1}, {1, 0, 2}, {2, 1, 0}};

void test_mesh_box(test_mesh *mesh, int dim, int cells) {
    int n = cells + 1, n_paths = dim == 3 ? 6 : 2;
    int step[3] = {1, n, n * n}; /* in node numbers */
    int64_t n_nodes = dim == 3 ? n * n * n : n * n, at = 0;
    allocate(mesh, dim, n_nodes, (int64_t)n_paths * cells * cells * (dim == 3 ? cells : 1));
    for (int32_t node = 0; node < n_nodes; node++) {
        int inside = 1; /* the node is the first corner of a cell */
        for (int d = 0; d < dim; d++) {
            int place = node / step[d] % n;
            mesh->coordinates[node * dim + d] = place;
            inside &= place < cells;
        }
        for (int p = 0; inside && p < n_paths; p++) {
            const int *path = dim == 3 ? paths_3d[p] : paths_2d[p];
            int32_t *element = mesh->elements + at++ * (dim + 1);
            element[0] = node;
            for (int d = 0; d < dim; d++)
                element[d + 1] = element[d] + step[path[d]];
            if (p >= n_paths / 2)
                test_mesh_reverse(mesh, at - 1);
        }
    }
}

void test_mesh_wrap(test_mesh *box, int cells, unsigned directions, uint8_t *is_wrapped) {
    const int dim = box->mesh.dim, k = dim + 1;
    for (int64_t i = 0; i < box->mesh.n_elements; i++) {
        int any = 0;
        for (int j = 0; j < k; j++) {
            int32_t *node = box->elements + i * k + j;
            for (int d = 0, step = 1, rest = *node; d < dim; d++, step *= cells + 1) {
                const int place = rest % (cells + 1);
                rest /= cells + 1;
                if (place < cells || !(directions >> d & 1))
                    continue;
                *node -= cells * step;
                any = 1;
            }
        }
        if (is_wrapped)
            is_wrapped[i] = (uint8_t)any;
    }
}

/* ---- other meshes ------------------------------------------------------------------------- */

void test_mesh_garbage(test_mesh *mesh, int dim, int64_t n_nodes, int64_t n_elements,
                       unsigned seed) {
    allocate(mesh, dim, n_nodes, n_elements);
    for (int64_t i = 0; i < n_nodes * dim; i++)
        mesh->coordinates[i] = test_random(&seed);
    for (int64_t i = 0; i < n_elements; i++)
        for (int j = 0; j <= dim; j++) {
            int32_t *element = mesh->elements + i * (dim + 1);
            int again = 1;
            while (again) {
                again = 0;
                element[j] = (int32_t)random_below(&seed, n_nodes);
                for (int k = 0; k < j; k++)
                    again |= element[k] == element[j];
            }
        }
}

void test_mesh_append(test_mesh *mesh, const test_mesh *other, double shift) {
    test_mesh a = *mesh;
    int dim = a.mesh.dim;
    int64_t n = a.mesh.n_nodes * dim, n_other = other->mesh.n_nodes * dim;
    int64_t m = a.mesh.n_elements * (dim + 1), m_other = other->mesh.n_elements * (dim + 1);
    allocate(mesh, dim, a.mesh.n_nodes + other->mesh.n_nodes,
             a.mesh.n_elements + other->mesh.n_elements);
    memcpy(mesh->coordinates, a.coordinates, (size_t)n * sizeof(double));
    memcpy(mesh->elements, a.elements, (size_t)m * sizeof(int32_t));
    for (int64_t i = 0; i < n_other; i++)
        mesh->coordinates[n + i] = other->coordinates[i] + shift;
    for (int64_t i = 0; i < m_other; i++)
        mesh->elements[m + i] = other->elements[i] + (int32_t)a.mesh.n_nodes;
    test_mesh_destroy(&a);
}

/* ---- changes ------------------------------------------------------------------------------ */

void test_mesh_double_pyramid(test_mesh *mesh, int32_t n) {
    double *x = checked(calloc((size_t)n + 3, 3 * sizeof *x));
    int32_t *elements = checked(malloc((size_t)n * 8 * sizeof *elements));
    x[3 * 1 + 2] = 1;
    x[3 * 2 + 2] = -1;
    for (int32_t i = 0; i < n; i++) {
        const int32_t p = 3 + i, q = 3 + (i + 1) % n;
        x[3 * p] = cos(2 * 3.14159265358979 * i / n);
        x[3 * p + 1] = sin(2 * 3.14159265358979 * i / n);
        memcpy(elements + 8 * i, (int32_t[8]){0, p, q, 1, 0, q, p, 2}, 8 * sizeof *elements);
    }
    test_mesh_create(mesh, 3, n + 3, x, 2 * n, elements);
    free(x);
    free(elements);
}

void test_mesh_join(test_mesh *mesh, int32_t a, int32_t b) {
    int64_t n = mesh->mesh.n_elements * (mesh->mesh.dim + 1);
    for (int64_t i = 0; i < n; i++)
        if (mesh->elements[i] == b)
            mesh->elements[i] = a;
}

void test_mesh_perturb(test_mesh *mesh, double amount, unsigned seed) {
    int dim = mesh->mesh.dim;
    double low = mesh->coordinates[0], high = low;
    for (int64_t i = 0; i < mesh->mesh.n_nodes * dim; i++) {
        low = mesh->coordinates[i] < low ? mesh->coordinates[i] : low;
        high = mesh->coordinates[i] > high ? mesh->coordinates[i] : high;
    }
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        double *x = mesh->coordinates + i * dim;
        int inside = 1;
        for (int d = 0; d < dim; d++)
            inside &= x[d] > low && x[d] < high;
        for (int d = 0; inside && d < dim; d++)
            x[d] += amount * (2 * test_random(&seed) - 1);
    }
}

void test_mesh_squeezed_box(test_mesh *mesh, int dim, int cells) {
    const double power = dim == 3 ? 1.3 : 1.6;
    test_mesh_box(mesh, dim, cells);
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        double *x = mesh->coordinates + i * dim, inside = 1;
        for (int d = 0; d < dim; d++)
            inside *= 4 * x[d] / cells * (1 - x[d] / cells);
        for (int d = 0; d < dim; d++)
            x[d] = cells * pow(x[d] / cells, 1 + power * inside);
    }
}

/** A random permutation of 0 .. n-1, to be freed. */
static int32_t *permutation(int64_t n, unsigned *state) {
    int32_t *p = checked(malloc((size_t)n * sizeof *p + 1));
    for (int64_t i = 0; i < n; i++)
        p[i] = (int32_t)i;
    for (int64_t i = n - 1; i > 0; i--) {
        int64_t j = random_below(state, i + 1);
        int32_t swapped = p[i];
        p[i] = p[j];
        p[j] = swapped;
    }
    return p;
}

void test_mesh_renumber(test_mesh *mesh, unsigned seed, int32_t *new_number) {
    test_mesh old = *mesh;
    int dim = old.mesh.dim;
    int64_t n = old.mesh.n_nodes, m = old.mesh.n_elements;
    int32_t *node = permutation(n, &seed), *place = permutation(m, &seed);
    allocate(mesh, dim, n, m);
    for (int64_t i = 0; i < n; i++)
        for (int d = 0; d < dim; d++)
            mesh->coordinates[node[i] * dim + d] = old.coordinates[i * dim + d];
    for (int64_t i = 0; i < m; i++)
        for (int j = 0; j <= dim; j++)
            mesh->elements[place[i] * (dim + 1) + j] = node[old.elements[i * (dim + 1) + j]];
    if (new_number)
        memcpy(new_number, node, (size_t)n * sizeof *node);
    free(node);
    free(place);
    test_mesh_destroy(&old);
}

void test_mesh_reverse(test_mesh *mesh, int64_t element) {
    int dim = mesh->mesh.dim;
    int32_t *node = mesh->elements + element * (dim + 1);
    int32_t last = node[dim];
    node[dim] = node[dim - 1];
    node[dim - 1] = last;
}

void test_mesh_reverse_some(test_mesh *mesh, unsigned every, unsigned seed) {
    for (int64_t i = 0; i < mesh->mesh.n_elements; i++)
        if (random_below(&seed, every) == 0)
            test_mesh_reverse(mesh, i);
}

void test_mesh_transform(test_mesh *mesh, double scale, double shift) {
    for (int64_t i = 0; i < mesh->mesh.n_nodes * mesh->mesh.dim; i++)
        mesh->coordinates[i] = mesh->coordinates[i] * scale + shift;
}

double test_regular_volume(int dim) {
    return dim == 3 ? 1.0 / 6 : 0.5;
}

void test_bad_box(test_mesh *mesh, int dim, int cells, unsigned seed) {
    test_mesh_box(mesh, dim, cells);
    test_mesh_perturb(mesh, 0.14, seed * 2654435761u + 1);
}

int test_is_inside_box(const double *x, int dim, int cells) {
    int inside = 1;
    for (int d = 0; d < dim; d++)
        inside &= x[d] != 0 && x[d] != cells;
    return inside;
}

double test_measure_of(const planish_mesh *mesh, const double *coordinates, int64_t element) {
    const int dim = mesh->dim;
    const int32_t *node = mesh->elements + element * (dim + 1);
    double e[3][3] = {{0}};
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = coordinates[node[j + 1] * dim + d] - coordinates[node[0] * dim + d];
    if (dim == 2)
        return (e[0][0] * e[1][1] - e[0][1] * e[1][0]) / 2;
    return (e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
            e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
            e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0])) /
           6;
}

double test_distance(const double *x, const double *y, int dim) {
    long double square = 0;
    for (int d = 0; d < dim; d++)
        square += ((long double)x[d] - y[d]) * ((long double)x[d] - y[d]);
    return (double)sqrtl(square);
}

void test_box_for_threads(test_mesh *mesh, int dim) {
    test_mesh_box(mesh, dim, dim == 2 ? 4 * TEST_THREADS_CELLS : TEST_THREADS_CELLS);
}

void test_bad_box_for_threads(test_mesh *mesh, int dim) {
    test_box_for_threads(mesh, dim);
    test_mesh_perturb(mesh, 0.14, 12345);
}

void test_tangled_box_for_threads(test_mesh *mesh, int dim) {
    test_box_for_threads(mesh, dim);
    test_mesh_perturb(mesh, 0.7, 12345);
}

/* ---- elements of any types ------------------------------------------------------------------ */

static void allocate_cells(test_cells *m, int dim, int64_t n_nodes, int64_t n_cells) {
    enum { MOST = 20 }; /* nodes of an element */
    *m = (test_cells){.coordinates = checked(calloc((size_t)(n_nodes * dim), sizeof(double))),
                      .type = checked(calloc((size_t)n_cells, 1)),
                      .offset = checked(calloc((size_t)n_cells + 1, sizeof(int64_t))),
                      .node = checked(calloc((size_t)n_cells * MOST, sizeof(int32_t))),
                      .row = checked(calloc((size_t)n_cells, sizeof(int)))};
    m->mesh = (planish_mesh){.dim = dim, .n_nodes = n_nodes, .coordinates = m->coordinates};
    m->cells = (planish_cells){.type = m->type, .offset = m->offset, .node = m->node};
}

void test_cells_destroy(test_cells *m) {
    free(m->coordinates);
    free(m->type);
    free(m->offset);
    free(m->node);
    free(m->row);
    *m = (test_cells){0};
}

/** Add an element with the corners node [n] and n_mids missing mids. */
static void add_cell(test_cells *m, int type, int row, int n, int n_mids, const int32_t *node) {
    const int64_t i = m->cells.n++, begin = m->offset[i];
    m->type[i] = (uint8_t)type;
    m->row[i] = row;
    memcpy(m->node + begin, node, (size_t)n * sizeof *node);
    memset(m->node + begin + n, -1, (size_t)n_mids * sizeof *node);
    m->offset[i + 1] = begin + n + n_mids;
    m->mesh.n_elements = m->cells.n;
}

/** Add the elements of a type that fill the cube or square with corners c: bits are x, y, z. */
static void add_cube(test_cells *m, int type, int row, const int32_t c[8]) {
    const int32_t hexahedron[] = {c[0], c[1], c[3], c[2], c[4], c[5], c[7], c[6]};
    const int32_t wedges[2][6] = {{c[0], c[1], c[3], c[4], c[5], c[7]},
                                  {c[0], c[3], c[2], c[4], c[7], c[6]}};
    const int32_t triangles[2][3] = {{c[0], c[1], c[3]}, {c[0], c[3], c[2]}};
    switch (type) {
    case PLANISH_CELL_HEXAHEDRON:
    case PLANISH_CELL_HEXAHEDRON20:
        add_cell(m, type, row, 8, type == PLANISH_CELL_HEXAHEDRON ? 0 : 12, hexahedron);
        break;
    case PLANISH_CELL_WEDGE:
    case PLANISH_CELL_WEDGE15:
        for (int i = 0; i < 2; i++)
            add_cell(m, type, row, 6, type == PLANISH_CELL_WEDGE ? 0 : 9, wedges[i]);
        break;
    case PLANISH_CELL_QUADRILATERAL:
    case PLANISH_CELL_QUADRILATERAL8:
        add_cell(m, type, row, 4, type == PLANISH_CELL_QUADRILATERAL ? 0 : 4, hexahedron);
        break;
    case PLANISH_CELL_TETRAHEDRON:
        for (int i = 0; i < 6; i++) {
            const int *path = paths_3d[i];
            const int32_t tetrahedron[] = {c[0], c[1 << path[0]], c[1 << path[0] | 1 << path[1]],
                                           c[7]};
            add_cell(m, type, row, 4, 0, tetrahedron);
        }
        break;
    default:
        for (int i = 0; i < 2; i++)
            add_cell(m, PLANISH_CELL_TRIANGLE, row, 3, 0, triangles[i]);
    }
}

void test_cells_box(test_cells *m, int cells, int type, int n_rows) {
    const int dim = type == PLANISH_CELL_TRIANGLE || type == PLANISH_CELL_QUADRILATERAL ||
                            type == PLANISH_CELL_QUADRILATERAL8
                        ? 2
                        : 3;
    const int side = cells + 1, depth = dim == 3 ? cells : 1;
    const int64_t n_nodes = dim == 3 ? side * side * side : side * side;
    const int32_t line[] = {0, 1};
    allocate_cells(m, dim, n_nodes, 6 * n_nodes);
    for (int i = 0; i < n_nodes; i++)
        for (int d = 0, left = i; d < dim; d++, left /= side)
            m->coordinates[i * dim + d] = left % side;
    add_cell(m, PLANISH_CELL_LINE, cells, 2, 0, line);
    for (int k = 0; k < cells; k++)
        for (int j = 0; j < depth; j++)
            for (int i = 0; i < cells; i++) {
                int32_t c[8];
                for (int bits = 0; bits < 8; bits++) {
                    const int x = i + (bits & 1), y = (bits >> 1 & 1), z = k + (bits >> 2);
                    c[bits] = dim == 3 ? (z * side + j + y) * side + x : (k + y) * side + x;
                }
                const int simplex = dim == 3 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE;
                add_cube(m, k < n_rows ? type : simplex, k, c);
            }
}

void test_cells_of_simplices(test_cells *m, const test_mesh *simplices, int order) {
    const planish_mesh *mesh = &simplices->mesh;
    const int dim = mesh->dim, k = dim + 1;
    const int type = dim == 3 ? order == 1 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TETRAHEDRON10
                     : order == 1 ? PLANISH_CELL_TRIANGLE
                                  : PLANISH_CELL_TRIANGLE6;
    allocate_cells(m, dim, mesh->n_nodes, mesh->n_elements);
    memcpy(m->coordinates, simplices->coordinates,
           (size_t)(mesh->n_nodes * dim) * sizeof *m->coordinates);
    for (int64_t i = 0; i < mesh->n_elements; i++)
        add_cell(m, type, 0, k, order == 1 ? 0 : k * dim / 2, simplices->elements + i * k);
}
