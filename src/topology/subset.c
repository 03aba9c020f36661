/* subset: the elements around some nodes, as a mesh of its own. */
#include "topology/subset.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "topology/points.h"

#include <string.h>

enum { CHUNK = 8192 };

/* ---- by marks ------------------------------------------------------------------------------ */

/** Passes over all elements and all nodes. */
typedef struct passes {
    const planish_mesh *mesh;
    const uint8_t *selected;
    int none_selected; /* 1: the first element is taken all the same */
    pl_subset *subset;
    int64_t *elements, *nodes; /* [chunks + 1] how many are taken in each, then before it */
    uint8_t *is_in;  /* [n_nodes] 1: node of an element that is taken. Threads may store the same */
    int32_t *number; /* [n_nodes] in the subset, of these nodes */
} passes;

static int is_taken(const passes *p, int64_t element) {
    const int32_t *node = p->mesh->elements + element * (p->mesh->dim + 1);
    int any = p->none_selected && element == 0;
    for (int j = 0; j <= p->mesh->dim; j++)
        any |= p->selected[node[j]];
    return any;
}

static void count_elements(void *context, int64_t begin, int64_t end, int thread) {
    const passes *p = context;
    const int corners = p->mesh->dim + 1;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (!is_taken(p, i))
            continue;
        n++;
        for (int j = 0; j < corners; j++)
            pl_set_flag(&p->is_in[p->mesh->elements[i * corners + j]], 1);
    }
    p->elements[begin / CHUNK] = n;
}

static void count_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const passes *p = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n += p->is_in[i];
    p->nodes[begin / CHUNK] = n;
}

static void list_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const passes *p = context;
    int64_t n = p->nodes[begin / CHUNK];
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (p->is_in[i]) {
            p->subset->node[n] = (int32_t)i;
            p->subset->is_selected[n] = p->selected[i] != 0;
            p->number[i] = (int32_t)n++;
        }
}

static void list_elements(void *context, int64_t begin, int64_t end, int thread) {
    const passes *p = context;
    const int corners = p->mesh->dim + 1;
    int64_t n = p->elements[begin / CHUNK];
    (void)thread;
    for (int64_t i = begin; n < p->elements[begin / CHUNK + 1] && i < end; i++) {
        if (!is_taken(p, i))
            continue;
        for (int j = 0; j < corners; j++)
            p->subset->elements[n * corners + j] = p->number[p->mesh->elements[i * corners + j]];
        p->subset->element[n++] = (int32_t)i;
    }
}

int pl_subset_by_marks(const planish_mesh *mesh, const uint8_t *selected, int threads, pl_subset *s,
                       planish_error *error) {
    const int64_t n = mesh->n_nodes, m = mesh->n_elements;
    passes p = {.mesh = mesh,
                .selected = selected,
                .subset = s,
                .elements = pl_alloc(m / CHUNK + 2, sizeof *p.elements),
                .nodes = pl_alloc(n / CHUNK + 2, sizeof *p.nodes),
                .is_in = pl_alloc_zero(n, sizeof *p.is_in),
                .number = pl_alloc(n, sizeof *p.number)};
    *s = (pl_subset){0};
    int done = p.elements && p.nodes && p.is_in && p.number;
    for (int pass = 0; done && pass < 2 && s->n_elements == 0; pass++) {
        p.none_selected = pass;
        pl_parallel_for(threads, m, CHUNK, count_elements, &p);
        s->n_elements = pl_prefix_sum(threads, (m - 1) / CHUNK + 1, p.elements);
    }
    if (done) {
        pl_parallel_for(threads, n, CHUNK, count_nodes, &p);
        s->n_nodes = pl_prefix_sum(threads, (n - 1) / CHUNK + 1, p.nodes);
        s->node = pl_alloc(s->n_nodes, sizeof *s->node);
        s->is_selected = pl_alloc(s->n_nodes, sizeof *s->is_selected);
        s->element = pl_alloc(s->n_elements, sizeof *s->element);
        s->elements = pl_alloc(s->n_elements * (mesh->dim + 1), sizeof *s->elements);
        done = s->node && s->is_selected && s->element && s->elements;
    }
    if (done) {
        pl_parallel_for(threads, n, CHUNK, list_nodes, &p);
        pl_parallel_for(threads, m, CHUNK, list_elements, &p);
    }
    pl_free(p.elements);
    pl_free(p.nodes);
    pl_free(p.is_in);
    pl_free(p.number);
    if (done)
        return PLANISH_OK;
    pl_subset_destroy(s);
    return pl_fail_memory(error, "the subset of the mesh that is worked on");
}

void pl_subset_destroy(pl_subset *subset) {
    pl_free(subset->node);
    pl_free(subset->element);
    pl_free(subset->elements);
    pl_free(subset->is_selected);
    *subset = (pl_subset){0};
}

int64_t pl_subset_find_node(const pl_subset *subset, int64_t node) {
    int64_t begin = 0, end = subset->n_nodes;
    while (begin < end) {
        const int64_t middle = begin + (end - begin) / 2;
        if (subset->node[middle] < node)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin < subset->n_nodes && subset->node[begin] == node ? begin : -1;
}

/* ---- as a mesh ----------------------------------------------------------------------------- */

int pl_submesh_create(const planish_mesh *whole, const pl_subset *subset, int threads,
                      pl_submesh *mesh, planish_error *error) {
    const size_t point = (size_t)whole->dim * sizeof(double);
    const int32_t *node = subset->node, *element = subset->element;
    pl_points points = pl_points_of(whole, whole->coordinates);
    int failed = 0;
    points.n = subset->n_nodes;
    points.node_of = node;
    mesh->constraint = pl_rows_take(whole->constraint, node, points.n, 1, threads, &failed);
    mesh->direction = pl_rows_take(whole->direction, node, points.n, point, threads, &failed);
    mesh->min_volume = pl_rows_take(whole->min_volume, element, subset->n_elements, sizeof(double),
                                    threads, &failed);
    mesh->coordinates = pl_alloc(points.n, point);
    mesh->mesh = (planish_mesh){.dim = whole->dim,
                                .n_nodes = subset->n_nodes,
                                .n_elements = subset->n_elements,
                                .coordinates = mesh->coordinates,
                                .elements = subset->elements,
                                .constraint = mesh->constraint,
                                .direction = mesh->direction,
                                .min_volume = mesh->min_volume};
    if (!mesh->coordinates || failed) {
        pl_submesh_destroy(mesh);
        return pl_fail_memory(error, "the subset of the mesh that is worked on");
    }
    const int status = pl_points_check(&points, threads, error);
    if (status)
        pl_submesh_destroy(mesh);
    else
        pl_points_gather(&points, threads, mesh->coordinates);
    return status;
}

void pl_submesh_destroy(pl_submesh *mesh) {
    pl_free(mesh->coordinates);
    pl_free(mesh->direction);
    pl_free(mesh->min_volume);
    pl_free(mesh->constraint);
    *mesh = (pl_submesh){0};
}
