/* validate: is this a mesh? Everything behind it relies on what is checked here, and on 32 bits and
 * coordinates without gaps: where the caller has others, on a copy. */
#include "topology/points.h"
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <inttypes.h>

enum { CHUNK = 4096 }; /* elements or nodes that one thread checks at a time */

/** A search for the lowest offender. */
typedef struct search {
    const planish_mesh *mesh;
    int64_t lowest; /* lowest offender so far, or INT64_MAX; shared */
} search;

/* ---- elements ----------------------------------------------------------------------------- */

/** Whether an element has a node that is none, or one twice: then the highest bit is set, of a node
 *  that is negative, of what is left to the last node, or of one less than the bits in which two
 *  differ. Without a comparison: so a loop over elements becomes vectors. */
static inline uint32_t badness_of(int dim, const int32_t *element, uint32_t n_nodes) {
    uint32_t bits = 0;
#pragma GCC unroll 4
    for (int i = 0; i <= dim; i++) {
        const uint32_t node = (uint32_t)element[i];
        bits |= node | (n_nodes - 1 - node);
#pragma GCC unroll 3
        for (int j = 0; j < i; j++)
            bits |= (node ^ (uint32_t)element[j]) - 1;
    }
    return bits;
}

static inline int is_bad(uint32_t bits) {
    return bits >> 31 != 0;
}

static inline void check_elements(search *s, int dim, int64_t begin, int64_t end) {
    const int32_t *elements = s->mesh->elements;
    const uint32_t n_nodes = (uint32_t)s->mesh->n_nodes;
    uint32_t bits = 0;
    for (int64_t i = begin; i < end; i++)
        bits |= badness_of(dim, elements + i * (dim + 1), n_nodes);
    for (int64_t i = begin; is_bad(bits) && i < end; i++)
        if (is_bad(badness_of(dim, elements + i * (dim + 1), n_nodes))) {
            pl_lower_to(&s->lowest, i);
            return;
        }
}

static void check_chunk(void *context, int64_t begin, int64_t end, int thread) {
    search *s = context;
    (void)thread;
    if (s->mesh->dim == 3)
        check_elements(s, 3, begin, end);
    else
        check_elements(s, 2, begin, end);
}

int pl_check_element(const planish_mesh *mesh, int64_t element, planish_error *error) {
    int64_t node[4];
    for (int i = 0; i <= mesh->dim; i++) {
        node[i] = pl_corner(mesh, element, i);
        if (node[i] < 0 || node[i] >= mesh->n_nodes)
            return pl_fail_at(error, PLANISH_ERROR_MESH, element, node[i],
                              "element %" PRId64 " has node %" PRId64 ", but the mesh has the "
                              "nodes 0 to %" PRId64 "; correct the element",
                              element, node[i], mesh->n_nodes - 1);
        for (int j = 0; j < i; j++)
            if (node[i] == node[j])
                return pl_fail_at(error, PLANISH_ERROR_MESH, element, node[i],
                                  "element %" PRId64 " has node %" PRId64
                                  " twice; remove the collapsed element",
                                  element, node[i]);
    }
    return PLANISH_OK;
}

/* ---- the mesh ----------------------------------------------------------------------------- */

/** Whether each coordinate has a place of its own: nodes one after the other, or components. */
static int strides_are_sound(const planish_mesh *mesh) {
    enum { MOST_STRIDE = 1 << 30 }; /* of nodes: what is addressed stays within 64 bits */
    const pl_points p = pl_points_of(mesh, NULL);
    if (p.step < 1 || p.apart < 1 || p.step > MOST_STRIDE || p.apart > INT64_MAX / 8)
        return 0;
    return p.apart <= (p.step - 1) / (p.dim - 1) || p.apart > p.step * (p.n - 1);
}

int pl_check_nodes(const planish_mesh *mesh, planish_error *error) {
    if (!mesh)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh must not be NULL");
    if (mesh->dim != 2 && mesh->dim != 3)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.dim is %d; give 2 (triangles) or 3 (tetrahedra)", mesh->dim);
    if (mesh->n_nodes < 0 || mesh->n_nodes > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_nodes is %" PRId64 "; it must lie between 0 and %" PRId32,
                       mesh->n_nodes, INT32_MAX);
    if (!mesh->coordinates && mesh->n_nodes > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh.coordinates must not be NULL");
    if (!strides_are_sound(mesh))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.node_stride is %" PRId64 " and component_stride %" PRId64
                       ": they must be positive, no more than 2^30 for nodes, and let no two "
                       "coordinates overlap; or 0",
                       mesh->node_stride, mesh->component_stride);
    return PLANISH_OK;
}

int pl_check_counts(const planish_mesh *mesh, planish_error *error) {
    const int status = pl_check_nodes(mesh, error);
    if (status)
        return status;
    if (mesh->n_elements < 0 || mesh->n_elements > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_elements is %" PRId64 "; it must lie between 0 and %" PRId32,
                       mesh->n_elements, INT32_MAX);
    if (mesh->n_elements == 0 && !mesh->part)
        return pl_fail(error, PLANISH_ERROR_MESH, "the mesh has no elements; give at least one");
    if (!mesh->elements == !mesh->elements64)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       mesh->elements ? "mesh.elements and mesh.elements64 are both set; give one"
                                      : "mesh.elements must not be NULL");
    return PLANISH_OK;
}

/* ---- a part of a mesh ------------------------------------------------------------------------ */

static int check_nodes_of_part(const planish_mesh *mesh, planish_error *error) {
    const planish_part *part = mesh->part;
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int64_t number = part->node_number[i], before = i > 0 ? part->node_number[i - 1] : -1;
        if (number <= before || number > UINT32_MAX)
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, i,
                              "mesh.part.node_number of node %" PRId64 " is %" PRId64
                              ", behind %" PRId64 "; give ascending numbers, below 2^32",
                              i, number, before);
        if (part->node_role[i] > PLANISH_GHOST)
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, i,
                              "mesh.part.node_role of node %" PRId64
                              " is %d; give a planish_role, 0 to %d",
                              i, part->node_role[i], PLANISH_GHOST);
    }
    return PLANISH_OK;
}

/** Check that elements with a ghost have no OWN node: a process shares the nodes next to its
 *  ghosts. */
static int check_elements_of_part(const planish_mesh *mesh, planish_error *error) {
    const int corners = mesh->dim + 1;
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        int n[PLANISH_GHOST + 1] = {0};
        for (int j = 0; j < corners; j++)
            n[mesh->part->node_role[mesh->elements[i * corners + j]]]++;
        if (n[PLANISH_GHOST] == corners || (n[PLANISH_GHOST] > 0 && n[PLANISH_OWN] > 0))
            return pl_fail_at(error, PLANISH_ERROR_MESH, i, -1,
                              "element %" PRId64
                              " of mesh.part has %s; nodes at a GHOST are SHARED "
                              "or GHOSTs, not all of them GHOSTs",
                              i, n[PLANISH_OWN] > 0 ? "both GHOST and OWN nodes" : "GHOSTs only");
    }
    return PLANISH_OK;
}

int pl_check_part(const planish_mesh *mesh, planish_error *error) {
    const planish_part *part = mesh->part;
    if (!part)
        return PLANISH_OK;
    if (!part->add || !part->largest || !part->send || !part->receive)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.part must have the functions add, largest, send and receive");
    if ((!part->node_number || !part->node_role) && mesh->n_nodes > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.part.node_number and node_role must not be NULL");
    if (!part->is_counted && mesh->n_elements > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh.part.is_counted must not be NULL");
    const int status = check_nodes_of_part(mesh, error);
    return status ? status : check_elements_of_part(mesh, error);
}

/* ---- a dense copy ------------------------------------------------------------------------- */

/** The work on all elements of 64 bits. */
typedef struct narrowing {
    const planish_mesh *mesh;
    int32_t *elements;
} narrowing;

/** Copy node numbers to 32 bits; a number that is no node's becomes -1. */
static void narrow_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const narrowing *w = context;
    const int corners = w->mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin * corners; i < end * corners; i++) {
        const int64_t node = w->mesh->elements64[i];
        w->elements[i] = node >= 0 && node < w->mesh->n_nodes ? (int32_t)node : -1;
    }
}

static int copy_elements(pl_dense *dense, int threads) {
    planish_mesh *mesh = &dense->mesh;
    dense->elements = pl_alloc(mesh->n_elements * (mesh->dim + 1), sizeof *dense->elements);
    narrowing w = {mesh, dense->elements};
    if (!dense->elements)
        return -1;
    pl_parallel_for(threads, mesh->n_elements, CHUNK, narrow_chunk, &w);
    mesh->elements = dense->elements;
    return 0;
}

static int copy_coordinates(pl_dense *dense, const pl_points *points, int threads) {
    planish_mesh *mesh = &dense->mesh;
    dense->coordinates = pl_alloc(mesh->n_nodes * mesh->dim, sizeof *dense->coordinates);
    if (!dense->coordinates)
        return -1;
    pl_points_gather(points, threads, dense->coordinates);
    mesh->coordinates = dense->coordinates;
    mesh->node_stride = mesh->component_stride = 0;
    return 0;
}

/** Check the elements of dense, a copy of mesh perhaps. */
static int check_all(const planish_mesh *dense, const planish_mesh *mesh, int threads,
                     planish_error *error) {
    search s = {.mesh = dense, .lowest = INT64_MAX};
    pl_parallel_for(threads, mesh->n_elements, CHUNK, check_chunk, &s);
    return s.lowest == INT64_MAX ? PLANISH_OK : pl_check_element(mesh, s.lowest, error);
}

int pl_dense_create(const planish_mesh *mesh, int threads, pl_dense *dense, planish_error *error) {
    int status = pl_check_counts(mesh, error);
    if (status)
        return status;
    *dense = (pl_dense){.mesh = *mesh};
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    if (mesh->elements64 && copy_elements(dense, threads) != 0)
        status = pl_fail_memory(error, "the elements");
    if (!status)
        status = check_all(&dense->mesh, mesh, threads, error);
    if (!status)
        status = pl_points_check(&points, threads, error);
    if (!status && !pl_points_are_dense(&points) && copy_coordinates(dense, &points, threads) != 0)
        status = pl_fail_memory(error, "the coordinates");
    dense->mesh.elements64 = NULL;
    if (status)
        pl_dense_destroy(dense);
    return status;
}

void pl_dense_destroy(pl_dense *dense) {
    pl_free(dense->elements);
    pl_free(dense->coordinates);
    dense->elements = NULL;
    dense->coordinates = NULL;
}
