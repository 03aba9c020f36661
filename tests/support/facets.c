/* facets: what the elements of a small mesh share, found by sorting. */
#include "support/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Measures of a component that sum up to less than this of their absolute values cancel. */
#define CANCELLED 1e-9L
/* So do those below this of the products of their edges, which doubles lose. */
#define ROUNDING 1e-14L

static void *checked(void *memory) {
    if (!memory)
        abort();
    return memory;
}

static int compare(const void *a, const void *b) {
    const test_facet *f = a, *g = b;
    const int order = memcmp(f->node, g->node, sizeof f->node);
    return order != 0 ? order : (f->element > g->element) - (f->element < g->element);
}

static test_facet facet_of(const planish_mesh *mesh, int64_t element, int corner) {
    test_facet f = {.node = {-1, -1, -1}, .element = element, .corner = corner};
    const int dim = mesh->dim;
    f.is_odd = (dim - corner) % 2; /* as if the corner were moved to the end */
    for (int j = 0, n = 3 - dim; j <= dim; j++) {
        if (j == corner)
            continue;
        int at = n++;
        for (f.node[at] = mesh->elements[element * (dim + 1) + j];
             at > 3 - dim && f.node[at] < f.node[at - 1]; at--) {
            const int32_t swapped = f.node[at];
            f.node[at] = f.node[at - 1];
            f.node[at - 1] = swapped;
            f.is_odd = !f.is_odd;
        }
    }
    return f;
}

test_facets test_facets_of(const planish_mesh *mesh, const uint8_t *is_known) {
    const int corners = mesh->dim + 1;
    test_facets facets = {0};
    facets.facet = checked(malloc((size_t)(mesh->n_elements * corners) * sizeof *facets.facet + 1));
    for (int64_t i = 0; i < mesh->n_elements; i++)
        for (int j = 0; (!is_known || is_known[i]) && j < corners; j++)
            facets.facet[facets.n++] = facet_of(mesh, i, j);
    qsort(facets.facet, (size_t)facets.n, sizeof *facets.facet, compare);
    return facets;
}

int64_t test_facet_count(const test_facets *facets, int64_t i) {
    int64_t n = 1;
    while (i + n < facets->n &&
           memcmp(facets->facet[i].node, facets->facet[i + n].node, sizeof(int32_t[3])) == 0)
        n++;
    return n;
}

/** Whether two elements of a facet have the same nodes: then their other corners are one. */
static int are_duplicates(const planish_mesh *mesh, const test_facet *f, const test_facet *g) {
    const int corners = mesh->dim + 1;
    return mesh->elements[f->element * corners + f->corner] ==
           mesh->elements[g->element * corners + g->corner];
}

/** Whether the facets from i on are one between two neighbours. */
static int joins(const planish_mesh *mesh, const test_facets *facets, int64_t i, int64_t n) {
    return n == 2 && !are_duplicates(mesh, &facets->facet[i], &facets->facet[i + 1]);
}

void test_neighbours(const planish_mesh *mesh, int32_t *neighbour) {
    const int corners = mesh->dim + 1;
    const test_facets facets = test_facets_of(mesh, NULL);
    for (int64_t i = 0, n; i < facets.n; i += n) {
        n = test_facet_count(&facets, i);
        for (int64_t k = 0; k < n; k++) {
            const test_facet *f = &facets.facet[i + k], *other = &facets.facet[i + (k + 1) % n];
            neighbour[f->element * corners + f->corner] = n == 2 ? (int32_t)other->element : -1;
        }
    }
    free(facets.facet);
}

void test_inside(const planish_mesh *mesh, const uint8_t *is_known, uint8_t *is_inside) {
    const test_facets facets = test_facets_of(mesh, is_known);
    memset(is_inside, 0, (size_t)mesh->n_nodes);
    for (int64_t i = 0; i < mesh->n_elements * (mesh->dim + 1); i++)
        if (!is_known || is_known[i / (mesh->dim + 1)])
            is_inside[mesh->elements[i]] = 1;
    for (int64_t i = 0, n; i < facets.n; i += n) {
        n = test_facet_count(&facets, i);
        for (int j = 3 - mesh->dim; j < 3 && !joins(mesh, &facets, i, n); j++)
            is_inside[facets.facet[i].node[j]] = 0;
    }
    free(facets.facet);
}

/* ---- orientation --------------------------------------------------------------------------- */

/** Of elements: a forest whose links say whether the orders at both ends are opposite. */
typedef struct forest {
    int64_t *parent; /* [m] */
    uint8_t *parity; /* [m] */
    uint8_t *failed; /* [m] of roots: neighbours contradict one another */
    long double *sum,
        *doubt; /* [m] of roots: of the measures, and of what may be wrong with them */
} forest;

static int64_t root_of(const forest *f, int64_t i, int *parity) {
    for (*parity = 0; f->parent[i] != i; i = f->parent[i])
        *parity ^= f->parity[i];
    return i;
}

static void join(forest *f, const test_facet *a, const test_facet *b) {
    int of_a, of_b;
    const int64_t root_a = root_of(f, a->element, &of_a), root_b = root_of(f, b->element, &of_b);
    const int parity = of_a ^ of_b ^ (a->is_odd == b->is_odd);
    if (root_a == root_b) {
        f->failed[root_a] |= (uint8_t)parity;
        return;
    }
    f->parent[root_b] = root_a;
    f->parity[root_b] = (uint8_t)parity;
    f->failed[root_a] |= f->failed[root_b];
}

static long double length(const long double *v, int dim) {
    long double square = 0;
    for (int d = 0; d < dim; d++)
        square += v[d] * v[d];
    return sqrtl(square);
}

/** dim! times the signed measure in the file's order; *product: of the edges. */
static long double measure(const planish_mesh *mesh, const double *x, int64_t element,
                           long double *product) {
    const int dim = mesh->dim;
    const int32_t *node = mesh->elements + element * (dim + 1);
    long double e[3][3];
    *product = 1;
    for (int j = 0; j < dim; j++) {
        for (int d = 0; d < dim; d++)
            e[j][d] = (long double)x[node[j + 1] * dim + d] - (long double)x[node[0] * dim + d];
        *product *= length(e[j], dim);
    }
    if (dim == 2)
        return e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

static void forest_create(forest *f, int64_t m) {
    const size_t n = (size_t)m + 1;
    *f = (forest){.parent = checked(malloc(n * sizeof *f->parent)),
                  .parity = checked(calloc(n, 1)),
                  .failed = checked(calloc(n, 1)),
                  .sum = checked(calloc(n, sizeof *f->sum)),
                  .doubt = checked(calloc(n, sizeof *f->doubt))};
    for (int64_t i = 0; i < m; i++)
        f->parent[i] = i;
}

static void forest_destroy(forest *f) {
    free(f->parent);
    free(f->parity);
    free(f->failed);
    free(f->sum);
    free(f->doubt);
}

/** The order of an element against that of its root; the file's where that makes no sense. */
static int order_of(const forest *f, int64_t element, int64_t *root) {
    int parity;
    *root = root_of(f, element, &parity);
    return parity && !f->failed[*root] ? -1 : 1;
}

int64_t test_orient(const planish_mesh *mesh, const double *coordinates, const uint8_t *is_known,
                    int8_t *sign) {
    const test_facets facets = test_facets_of(mesh, is_known);
    const int64_t m = mesh->n_elements;
    int64_t root, doubtful = 0;
    forest f;
    forest_create(&f, m);
    for (int64_t i = 0, n; i < facets.n; i += n) {
        n = test_facet_count(&facets, i);
        if (joins(mesh, &facets, i, n))
            join(&f, &facets.facet[i], &facets.facet[i + 1]);
    }
    for (int64_t i = 0; i < m; i++) {
        long double product;
        const long double v = order_of(&f, i, &root) * measure(mesh, coordinates, i, &product);
        f.sum[root] += v;
        f.doubt[root] += CANCELLED * fabsl(v) + ROUNDING * product;
    }
    for (int64_t i = 0; i < m; i++) {
        const int order = order_of(&f, i, &root);
        sign[i] = (int8_t)(f.sum[root] < 0 ? -order : order);
        doubtful += (!is_known || is_known[i]) && fabsl(f.sum[root]) <= f.doubt[root];
    }
    forest_destroy(&f);
    free(facets.facet);
    return doubtful;
}
