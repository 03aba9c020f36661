/* boundary_reference: the boundary of a mesh by its definition, every facet against every other
 * one. */
#include "support/boundary_reference.h"

#include "support/meshes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Parity of the permutation that sorts node [n]. */
static int inversions(const int32_t *node, int n) {
    int count = 0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            count += node[j] > node[i];
    return count % 2;
}

static int ascending(const void *a, const void *b) {
    int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/** Facet opposite node j: its own order, preceded by node j, is a permutation of the element. */
static test_facet facet_of(const planish_mesh *mesh, int64_t element, int j) {
    test_facet f = {{-1, -1, -1}, element, 0};
    int dim = mesh->dim;
    for (int i = 0, n = 0; i <= dim; i++)
        if (i != j)
            f.node[n++] = mesh->elements[element * (dim + 1) + i];
    f.direction = (inversions(f.node, dim) + j) % 2;
    qsort(f.node, (size_t)dim, sizeof f.node[0], ascending);
    return f;
}

static int same_nodes(const planish_mesh *mesh, int64_t a, int64_t b) {
    int32_t x[4], y[4];
    size_t k = (size_t)mesh->dim + 1;
    memcpy(x, mesh->elements + a * (int64_t)k, k * sizeof *x);
    memcpy(y, mesh->elements + b * (int64_t)k, k * sizeof *y);
    qsort(x, k, sizeof *x, ascending);
    qsort(y, k, sizeof *y, ascending);
    return memcmp(x, y, k * sizeof *x) == 0;
}

static void hold(boundary_reference *r, const int32_t *node, int n) {
    for (int i = 0; i < n; i++)
        r->boundary.on_boundary[node[i]] = 1;
}

/** The facet that joins facet i's element to another one, or -1. *count: elements of facet i. */
static int64_t partner(const planish_mesh *mesh, const boundary_reference *r, int64_t i, int *count,
                       int *first) {
    int64_t other = -1;
    *count = 0;
    *first = 1;
    for (int64_t j = 0; j < r->n_facets; j++) {
        if (memcmp(r->facet[i].node, r->facet[j].node, sizeof r->facet[i].node) != 0)
            continue;
        ++*count;
        *first &= j >= i;
        other = j == i ? other : j;
    }
    int joins = *count == 2 && !same_nodes(mesh, r->facet[i].element, r->facet[other].element);
    return joins ? other : -1;
}

/** Spread an orientation from the first element of each component until nothing changes; component
 *  [m] gets its first element, sign [m] the order relative to that. */
static void spread(const planish_mesh *mesh, const boundary_reference *r, const int64_t *partners,
                   int64_t *component, int8_t *sign) {
    int k = mesh->dim + 1;
    for (int64_t e = 0; e < mesh->n_elements; e++) {
        if (component[e] >= 0)
            continue;
        component[e] = e;
        sign[e] = 1;
        for (int changed = 1; changed;) {
            changed = 0;
            for (int64_t i = 0; i < r->n_facets; i++) {
                int64_t a = i / k, b = partners[i] / k;
                if (partners[i] < 0 || component[a] != e || component[b] >= 0)
                    continue;
                int same = r->facet[i].direction == r->facet[partners[i]].direction;
                component[b] = e;
                sign[b] = (int8_t)(same ? -sign[a] : sign[a]);
                changed = 1;
            }
        }
    }
}

/** Signs from the components: those in which facets contradict one another keep the file's order,
 *  and hold the nodes of the facets that do. */
static void orient(const planish_mesh *mesh, boundary_reference *r, const int64_t *partners) {
    size_t m = (size_t)mesh->n_elements;
    int64_t *component = malloc(m * sizeof *component);
    int8_t *bad = calloc(m, 1), *sign = malloc(m);
    double *sum = calloc(m, sizeof *sum);
    assert_true(component && bad && sum && sign);
    memset(component, -1, m * sizeof *component);
    spread(mesh, r, partners, component, sign);
    int k = mesh->dim + 1;
    for (int64_t i = 0; i < r->n_facets; i++) {
        int64_t j = partners[i];
        if (j >= 0 &&
            (sign[i / k] != sign[j / k]) != (r->facet[i].direction == r->facet[j].direction))
            bad[component[i / k]] = 1;
    }
    for (int64_t i = 0; i < r->n_facets; i++)
        if (partners[i] >= 0 && bad[component[i / k]] &&
            r->facet[i].direction == r->facet[partners[i]].direction)
            hold(r, r->facet[i].node, mesh->dim);
    for (size_t e = 0; e < m; e++) {
        sign[e] = bad[component[e]] ? 1 : sign[e];
        sum[component[e]] += sign[e] * test_measure_of(mesh, mesh->coordinates, (int64_t)e);
    }
    for (size_t e = 0; e < m; e++) {
        sign[e] = (int8_t)(sum[component[e]] < 0 ? -sign[e] : sign[e]);
        r->boundary.n_reversed += sign[e] < 0;
        r->boundary.n_components += component[e] == (int64_t)e;
    }
    r->boundary.sign = sign;
    free(component);
    free(bad);
    free(sum);
}

static void find_duplicates(const planish_mesh *mesh, boundary_reference *r) {
    for (int64_t a = 0; a < mesh->n_elements; a++) {
        int duplicate = 0;
        for (int64_t b = 0; b < a && !duplicate; b++)
            duplicate = same_nodes(mesh, a, b);
        r->boundary.n_duplicate_elements += duplicate;
        if (duplicate)
            hold(r, mesh->elements + a * (mesh->dim + 1), mesh->dim + 1);
    }
}

void boundary_reference_create(const planish_mesh *mesh, boundary_reference *r) {
    int k = mesh->dim + 1;
    *r = (boundary_reference){.n_facets = mesh->n_elements * k};
    r->facet = malloc((size_t)r->n_facets * sizeof *r->facet);
    int64_t *partners = malloc((size_t)r->n_facets * sizeof *partners);
    r->boundary.on_boundary = calloc((size_t)mesh->n_nodes, 1);
    assert_true(r->facet && partners && r->boundary.on_boundary);
    for (int64_t i = 0; i < r->n_facets; i++)
        r->facet[i] = facet_of(mesh, i / k, (int)(i % k));
    for (int64_t i = 0; i < r->n_facets; i++) {
        int count, first;
        partners[i] = partner(mesh, r, i, &count, &first);
        r->boundary.n_boundary_facets += count == 1;
        r->boundary.n_nonmanifold_facets += first && count > 2;
        if (count != 2)
            hold(r, r->facet[i].node, mesh->dim);
    }
    find_duplicates(mesh, r);
    orient(mesh, r, partners);
    free(partners);
}

void boundary_reference_destroy(boundary_reference *r) {
    free(r->boundary.on_boundary);
    free(r->boundary.sign);
    free(r->facet);
}
