/* delaunay: Delaunay meshes of few points on a grid, by exact arithmetic. */
#include "support/delaunay.h"

#include <stdlib.h>
#include <string.h>

static void *grown(void *memory, int64_t bytes) {
    void *block = realloc(memory, (size_t)bytes);
    if (!block)
        abort();
    return block;
}

static void reserve(delaunay *d, int64_t n_elements) {
    if (n_elements <= d->room)
        return;
    d->room = 2 * n_elements + 64;
    d->element = grown(d->element, d->room * 4 * (int64_t)sizeof *d->element);
    d->is_hit = grown(d->is_hit, d->room);
}

/* ---- determinants -------------------------------------------------------------------------- */

static int64_t determinant(int n, const int64_t m[4][4]) {
    int64_t sum = 0;
    if (n == 2)
        return m[0][0] * m[1][1] - m[0][1] * m[1][0];
    for (int k = 0; k < n; k++) { /* by the last column */
        int64_t rest[4][4];
        for (int i = 0, at = 0; i < n; i++)
            if (i != k)
                memcpy(rest[at++], m[i], sizeof rest[0]);
        sum += ((k + n - 1) % 2 ? -1 : 1) * m[k][n - 1] * determinant(n - 1, rest);
    }
    return sum;
}

/** dim! times the measure of a simplex. */
static int64_t measure(const delaunay *d, const int32_t *const vertex[4]) {
    int64_t m[4][4] = {{0}};
    for (int i = 0; i < d->dim; i++)
        for (int k = 0; k < d->dim; k++)
            m[i][k] = vertex[i + 1][k] - vertex[0][k];
    return determinant(d->dim, m);
}

int64_t delaunay_depth(const delaunay *d, int64_t element, const int32_t *p) {
    int64_t m[4][4] = {{0}};
    for (int i = 0; i <= d->dim; i++) {
        const int32_t *v = d->point + 3 * d->element[4 * element + i];
        for (int k = 0; k < d->dim; k++) {
            m[i][k] = v[k] - p[k];
            m[i][d->dim] += m[i][k] * m[i][k];
        }
    }
    return (d->dim == 3 ? -1 : 1) * determinant(d->dim + 1, m);
}

/* ---- insertion ----------------------------------------------------------------------------- */

/** Whether element has all nodes of another one but that at corner. */
static int has_facet(const delaunay *d, const int32_t *element, const int32_t *of, int corner) {
    int common = 0;
    for (int i = 0; i <= d->dim; i++)
        for (int j = 0; j <= d->dim; j++)
            common += j != corner && element[i] == of[j];
    return common == d->dim;
}

/** Whether another hit element has the facet of one opposite to corner. */
static int is_inside(const delaunay *d, int64_t element, int corner) {
    for (int64_t i = 0; i < d->n_elements; i++)
        if (d->is_hit[i] && i != element &&
            has_facet(d, d->element + 4 * i, d->element + 4 * element, corner))
            return 1;
    return 0;
}

/** Whether all vertices but that at corner are on one side of the box. */
static int is_on_side(const delaunay *d, const int32_t *const vertex[4], int corner) {
    for (int k = 0; k < d->dim; k++)
        for (int32_t side = 0; side <= DELAUNAY_GRID; side += DELAUNAY_GRID) {
            int on = 0;
            for (int i = 0; i <= d->dim; i++)
                on += i != corner && vertex[i][k] == side;
            if (on == d->dim)
                return 1;
        }
    return 0;
}

/** Append the element of a facet of the cavity and the new point; 0 if that is not possible. */
static int join(delaunay *d, int64_t element, int corner) {
    const int32_t *vertex[4], node = d->n_points - 1;
    for (int i = 0; i <= d->dim; i++)
        vertex[i] = d->point + 3 * (i == corner ? node : d->element[4 * element + i]);
    const int64_t m = measure(d, vertex);
    if (m <= 0)
        return m == 0 && is_on_side(d, vertex, corner);
    reserve(d, d->n_elements + 1);
    memcpy(d->element + 4 * d->n_elements, d->element + 4 * element, 4 * sizeof *d->element);
    d->element[4 * d->n_elements + corner] = node;
    d->is_hit[d->n_elements++] = 0;
    return 1;
}

static void remove_hit(delaunay *d) {
    int64_t n = 0;
    for (int64_t i = 0; i < d->n_elements; i++)
        if (!d->is_hit[i])
            memmove(d->element + 4 * n++, d->element + 4 * i, 4 * sizeof *d->element);
    d->n_elements = n;
}

int delaunay_insert(delaunay *d, const int32_t *point) {
    const int64_t n = d->n_elements;
    int64_t n_hit = 0;
    int possible = 1;
    d->point = grown(d->point, (d->n_points + 1) * 3 * (int64_t)sizeof *d->point);
    for (int64_t i = 0; i < n; i++)
        n_hit += d->is_hit[i] = delaunay_depth(d, i, point) > 0;
    if (n_hit == 0)
        return 0;
    memcpy(d->point + 3 * d->n_points++, point, (size_t)d->dim * sizeof *point);
    for (int64_t i = 0; i < n && possible; i++)
        for (int j = 0; d->is_hit[i] && j <= d->dim && possible; j++)
            possible = is_inside(d, i, j) || join(d, i, j);
    if (possible) {
        remove_hit(d);
    } else {
        d->n_elements = n;
        d->n_points--;
    }
    return possible;
}

/* ---- the mesh ------------------------------------------------------------------------------ */

void delaunay_begin(delaunay *d, int dim) {
    test_mesh box;
    *d = (delaunay){.dim = dim};
    test_mesh_box(&box, dim, 1);
    d->n_points = (int32_t)box.mesh.n_nodes;
    d->point = grown(NULL, d->n_points * 3 * (int64_t)sizeof *d->point);
    for (int32_t i = 0; i < d->n_points; i++)
        for (int k = 0; k < dim; k++)
            d->point[3 * i + k] = (int32_t)box.coordinates[i * dim + k] * DELAUNAY_GRID;
    reserve(d, box.mesh.n_elements);
    for (int64_t i = 0; i < box.mesh.n_elements; i++)
        for (int j = 0; j <= dim; j++)
            d->element[4 * i + j] = box.elements[i * (dim + 1) + j];
    d->n_elements = box.mesh.n_elements;
    test_mesh_destroy(&box);
}

void delaunay_end(delaunay *d) {
    free(d->point);
    free(d->element);
    free(d->is_hit);
    *d = (delaunay){0};
}

void delaunay_take(const delaunay *d, test_mesh *mesh) {
    const int dim = d->dim;
    double *x = grown(NULL, d->n_points * dim * (int64_t)sizeof *x);
    int32_t *element = grown(NULL, d->n_elements * (dim + 1) * (int64_t)sizeof *element);
    for (int32_t i = 0; i < d->n_points; i++)
        for (int k = 0; k < dim; k++)
            x[i * dim + k] = (double)d->point[3 * i + k] / DELAUNAY_GRID;
    for (int64_t i = 0; i < d->n_elements; i++)
        for (int j = 0; j <= dim; j++)
            element[i * (dim + 1) + j] = d->element[4 * i + j];
    test_mesh_create(mesh, dim, d->n_points, x, d->n_elements, element);
    free(x);
    free(element);
}
