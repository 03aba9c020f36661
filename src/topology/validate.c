/* validate: is this a mesh? Everything behind it relies on what is checked here. */
#include "topology/topology.h"

#include "base/parallel.h"
#include "base/status.h"

#include <inttypes.h>
#include <math.h>

enum { CHUNK = 16384 }; /* elements or nodes that one thread checks at a time */

/** A search for the lowest offender. */
typedef struct search {
    const planish_mesh *mesh;
    const double *coordinates; /* [n_nodes][dim] */
    int dim;
    int64_t lowest; /* lowest offender so far, or INT64_MAX; shared */
} search;

/** Lower s->lowest to index: the lowest of all offenders wins, whoever finds it first. */
static void report(search *s, int64_t index) {
    int64_t lowest = __atomic_load_n(&s->lowest, __ATOMIC_RELAXED);
    while (index < lowest && !__atomic_compare_exchange_n(&s->lowest, &lowest, index, 1,
                                                          __ATOMIC_RELAXED, __ATOMIC_RELAXED)) {
    }
}

/* ---- elements ----------------------------------------------------------------------------- */

static inline int element_is_bad(int dim, const int32_t *element, uint32_t n_nodes) {
    int bad = 0;
    for (int i = 0; i <= dim; i++) {
        bad |= (uint32_t)element[i] >= n_nodes; /* negative ones wrap to large ones */
        for (int j = 0; j < i; j++)
            bad |= element[i] == element[j];
    }
    return bad;
}

static inline void check_elements(search *s, int dim, int64_t begin, int64_t end) {
    const int32_t *elements = s->mesh->elements;
    uint32_t n_nodes = (uint32_t)s->mesh->n_nodes;
    for (int64_t i = begin; i < end; i++)
        if (element_is_bad(dim, elements + i * (dim + 1), n_nodes)) {
            report(s, i);
            return;
        }
}

static void check_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    (void)thread;
    if (s->dim == 3)
        check_elements(s, 3, begin, end);
    else
        check_elements(s, 2, begin, end);
}

/** Say what is wrong with element. */
static int fail_element(const planish_mesh *mesh, int64_t element, planish_error *error) {
    const int32_t *node = mesh->elements + element * (mesh->dim + 1);
    for (int i = 0; i <= mesh->dim; i++) {
        if (node[i] < 0 || node[i] >= mesh->n_nodes)
            return pl_fail_at(error, PLANISH_ERROR_MESH, element, node[i],
                              "element %" PRId64 " has node %" PRId32 ", but the mesh has the "
                              "nodes 0 to %" PRId64 "; correct the element",
                              element, node[i], mesh->n_nodes - 1);
        for (int j = 0; j < i; j++)
            if (node[i] == node[j])
                return pl_fail_at(error, PLANISH_ERROR_MESH, element, node[i],
                                  "element %" PRId64 " has node %" PRId32
                                  " twice; remove the collapsed element",
                                  element, node[i]);
    }
    return PLANISH_OK;
}

/* ---- coordinates -------------------------------------------------------------------------- */

static void check_coordinates(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    (void)thread;
    for (int64_t i = begin * s->dim; i < end * s->dim; i++)
        if (!isfinite(s->coordinates[i])) {
            report(s, i / s->dim);
            return;
        }
}

int pl_validate_coordinates(const double *coordinates, int64_t n_nodes, int dim, int threads,
                            planish_error *error) {
    search s = {.coordinates = coordinates, .dim = dim, .lowest = INT64_MAX};
    pl_parallel_for(threads, n_nodes, CHUNK, check_coordinates, &s);
    if (s.lowest == INT64_MAX)
        return PLANISH_OK;
    const double *x = coordinates + s.lowest * dim;
    int d = 0;
    while (d < dim - 1 && isfinite(x[d]))
        d++;
    return pl_fail_at(error, PLANISH_ERROR_MESH, -1, s.lowest,
                      "node %" PRId64 " has the coordinate %c = %g; all must be finite numbers",
                      s.lowest, "xyz"[d], x[d]);
}

/* ---- the mesh ----------------------------------------------------------------------------- */

static int check_arguments(const planish_mesh *mesh, planish_error *error) {
    if (!mesh)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh must not be NULL");
    if (mesh->dim != 2 && mesh->dim != 3)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.dim is %d; give 2 (triangles) or 3 (tetrahedra)", mesh->dim);
    if (mesh->n_nodes < 0 || mesh->n_nodes > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_nodes is %" PRId64 "; it must lie between 0 and %" PRId32,
                       mesh->n_nodes, INT32_MAX);
    if (mesh->n_elements < 0 || mesh->n_elements > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_elements is %" PRId64 "; it must lie between 0 and %" PRId32,
                       mesh->n_elements, INT32_MAX);
    if (mesh->n_elements == 0)
        return pl_fail(error, PLANISH_ERROR_MESH, "the mesh has no elements; give at least one");
    if (!mesh->elements)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh.elements must not be NULL");
    if (!mesh->coordinates && mesh->n_nodes > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh.coordinates must not be NULL");
    return PLANISH_OK;
}

int pl_validate_mesh(const planish_mesh *mesh, int threads, planish_error *error) {
    int status = check_arguments(mesh, error);
    if (status)
        return status;
    search s = {.mesh = mesh, .dim = mesh->dim, .lowest = INT64_MAX};
    pl_parallel_for(threads, mesh->n_elements, CHUNK, check_chunk, &s);
    if (s.lowest != INT64_MAX)
        return fail_element(mesh, s.lowest, error);
    return pl_validate_coordinates(mesh->coordinates, mesh->n_nodes, mesh->dim, threads, error);
}
