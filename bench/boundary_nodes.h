/* boundary_nodes: the nodes of facets of one element alone, by sorting all facets. */
#ifndef BENCH_BOUNDARY_NODES_H
#define BENCH_BOUNDARY_NODES_H

#include <planish/planish.h>

#include <stdlib.h>

typedef struct bench_facet {
    int32_t node[3]; /* ascending, -1 first in 2-D */
} bench_facet;

static inline int bench_compare_facets(const void *a, const void *b) {
    const bench_facet *f = a, *g = b;
    for (int j = 0; j < 3; j++)
        if (f->node[j] != g->node[j])
            return f->node[j] < g->node[j] ? -1 : 1;
    return 0;
}

/** The facet of a simplex [dim + 1] that is opposite to a corner. */
static inline bench_facet bench_facet_of(const int32_t *element, int dim, int opposite) {
    bench_facet f = {{-1, -1, -1}};
    int n = 3 - dim;
    for (int j = 0; j <= dim; j++)
        if (j != opposite)
            f.node[n++] = element[j];
    for (int i = 1; i < 3; i++)
        for (int j = i; j > 0 && f.node[j] < f.node[j - 1]; j--) {
            int32_t t = f.node[j];
            f.node[j] = f.node[j - 1];
            f.node[j - 1] = t;
        }
    return f;
}

/** Set is_on_boundary [n_nodes] to 1 for the nodes of facets that one simplex alone has. Returns 0 without
 *  memory. */
static inline int bench_find_boundary(const planish_mesh *mesh, uint8_t *is_on_boundary) {
    const int dim = mesh->dim;
    const int64_t n = mesh->n_elements * (dim + 1);
    bench_facet *all = malloc((size_t)n * sizeof *all);
    if (!all)
        return 0;
    for (int64_t i = 0; i < n; i++)
        all[i] =
            bench_facet_of(mesh->elements + i / (dim + 1) * (dim + 1), dim, (int)(i % (dim + 1)));
    qsort(all, (size_t)n, sizeof *all, bench_compare_facets);
    for (int64_t i = 0; i < n; i++) {
        const int is_single = (i == 0 || bench_compare_facets(&all[i - 1], &all[i])) &&
                              (i + 1 == n || bench_compare_facets(&all[i], &all[i + 1]));
        for (int j = 3 - dim; is_single && j < 3; j++)
            is_on_boundary[all[i].node[j]] = 1;
    }
    free(all);
    return 1;
}

#endif
