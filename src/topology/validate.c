/* validate: is this a mesh? Everything behind it relies on what is checked here, and on 32 bits and
 * coordinates without gaps: where the caller has others, on a copy. */
#include "topology/cells.h"
#include "topology/no_node.h"
#include "topology/points.h"
#include "topology/topology.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <inttypes.h>

enum { CHUNK = 4096 }; /* elements or nodes that one thread checks at a time */

/** A search for the lowest offender. */
typedef struct lowest_search {
    const planish_mesh *mesh;
    int64_t lowest; /* lowest offender so far, or INT64_MAX; shared */
} lowest_search;

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

static inline void check_elements(lowest_search *s, int dim, int64_t begin, int64_t end) {
    const int32_t *elements = s->mesh->elements;
    const uint32_t n_nodes = (uint32_t)s->mesh->n_nodes;
    uint32_t bits = 0;
    for (int64_t i = begin; i < end; i++)
        bits |= badness_of(dim, elements + i * (dim + 1), n_nodes);
    for (int64_t i = begin; bits >> 31 && i < end; i++)
        if (badness_of(dim, elements + i * (dim + 1), n_nodes) >> 31) {
            pl_lower_to(&s->lowest, i);
            return;
        }
}

static void check_chunk(void *context, int64_t begin, int64_t end, int thread) {
    lowest_search *s = context;
    (void)thread;
    if (s->mesh->dim == 3)
        check_elements(s, 3, begin, end);
    else
        check_elements(s, 2, begin, end);
}

const planish_mesh *pl_drop_targets(const planish_mesh *mesh, planish_mesh *copy) {
    for (int64_t i = 0; mesh->is_layer && i < mesh->n_elements; i++)
        if (mesh->is_layer[i])
            return mesh;
    if (!mesh->is_layer)
        return mesh;
    *copy = *mesh;
    copy->is_layer = NULL;
    copy->reference = pl_has_sizes(mesh) ? mesh->reference : NULL;
    return copy;
}

int pl_check_element(const planish_mesh *mesh, int64_t element, planish_error *error) {
    int64_t node[4];
    char there[PL_NODES_TEXT];
    for (int i = 0; i <= mesh->dim; i++) {
        node[i] = pl_corner(mesh, element, i);
        if (node[i] < 0 || node[i] >= mesh->n_nodes)
            return pl_fail_at(error, PLANISH_ERROR_MESH, element, node[i],
                              "element %" PRId64 " has node %" PRId64
                              ", but the mesh has %s; correct the element%s",
                              element, node[i], pl_nodes_there(mesh->n_nodes, there),
                              pl_no_node_hint(node[i], mesh->n_nodes));
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

int pl_check_nodes(const planish_mesh *mesh, planish_error *error) {
    if (!mesh)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh must not be NULL");
    const int status =
        pl_check_reserved("planish_mesh", mesh->reserved, sizeof mesh->reserved, error);
    if (status)
        return status;
    if (mesh->dim != 2 && mesh->dim != 3)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.dim is %d; give 2 (triangles) or 3 (tetrahedra)", mesh->dim);
    if (mesh->n_nodes < 0 || mesh->n_nodes > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_nodes is %" PRId64 "; it must lie between 0 and %" PRId32,
                       mesh->n_nodes, INT32_MAX);
    if (!mesh->coordinates && mesh->n_nodes > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh.coordinates must not be NULL");
    /* Each coordinate needs a place of its own: nodes one after the other, or components. What is
     * addressed stays within 64 bits. */
    enum { MOST_STRIDE = 1 << 30 };
    const pl_points p = pl_points_of(mesh, NULL);
    if (p.step < 1 || p.apart < 1 || p.step > MOST_STRIDE || p.apart > INT64_MAX / 8 ||
        (p.apart > (p.step - 1) / (p.dim - 1) && p.apart <= p.step * (p.n - 1)))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.node_stride is %" PRId64 " and component_stride %" PRId64
                       ": they must be positive, no more than 2^30 for nodes, and let no two "
                       "coordinates overlap; or 0",
                       mesh->node_stride, mesh->component_stride);
    return PLANISH_OK;
}

/** Check the fields that do not go with cells. */
static int check_beside_cells(const planish_mesh *mesh, planish_error *error) {
    if (mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "mesh.cells is not possible with a mesh in parts; give elements, or the "
                       "whole mesh in one process");
    if (mesh->elements || mesh->elements64)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.cells and mesh.%s are both set; give one",
                       mesh->elements ? "elements" : "elements64");
    if (mesh->neighbours || mesh->neighbours64)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.%s is set beside mesh.cells; neighbours are for elements alone, leave "
                       "them out",
                       mesh->neighbours ? "neighbours" : "neighbours64");
    if (mesh->cells->n != mesh->n_elements)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_elements is %" PRId64 ", but mesh.cells has %" PRId64
                       " elements; give the same number",
                       mesh->n_elements, mesh->cells->n);
    return PLANISH_OK;
}

int pl_check_counts(const planish_mesh *mesh, planish_error *error) {
    int status = pl_check_nodes(mesh, error);
    if (status)
        return status;
    if (mesh->n_elements < 0 || mesh->n_elements > INT32_MAX)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.n_elements is %" PRId64 "; it must lie between 0 and %" PRId32,
                       mesh->n_elements, INT32_MAX);
    if (mesh->cells && (status = check_beside_cells(mesh, error)))
        return status;
    if (mesh->n_elements == 0 && !mesh->part)
        return pl_fail(error, PLANISH_ERROR_MESH, "the mesh has no elements; give at least one");
    if (!mesh->cells && !mesh->elements == !mesh->elements64)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       mesh->elements ? "mesh.elements and mesh.elements64 are both set; give one"
                                      : "mesh.elements must not be NULL");
    return PLANISH_OK;
}

/* ---- a part of a mesh ------------------------------------------------------------------------ */

int pl_check_part(const planish_mesh *mesh, planish_error *error) {
    const planish_part *part = mesh->part;
    const int corners = mesh->dim + 1;
    if (!part)
        return PLANISH_OK;
    const int status =
        pl_check_reserved("planish_part", part->reserved, sizeof part->reserved, error);
    if (status)
        return status;
    if (!part->add || !part->largest || !part->send || !part->receive)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.part must have the functions add, largest, send and receive");
    if ((!part->node_number || !part->node_role) && mesh->n_nodes > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.part.node_number and node_role must not be NULL");
    if (!part->is_counted && mesh->n_elements > 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh.part.is_counted must not be NULL");
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int64_t number = part->node_number[i], before = i > 0 ? part->node_number[i - 1] : -1;
        if (number <= before || number > UINT32_MAX)
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, i,
                              "mesh.part.node_number of node %" PRId64 " is %" PRId64
                              ", behind %" PRId64 "; give ascending numbers, below 2^32",
                              i, number, before);
        if (part->node_role[i] > PLANISH_ROLE_GHOST)
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, i,
                              "mesh.part.node_role of node %" PRId64
                              " is %d; give a planish_role, 0 to %d",
                              i, part->node_role[i], PLANISH_ROLE_GHOST);
    }
    /* A process shares the nodes next to its ghosts. */
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        int n[PLANISH_ROLE_GHOST + 1] = {0};
        for (int j = 0; j < corners; j++)
            n[part->node_role[mesh->elements[i * corners + j]]]++;
        if (n[PLANISH_ROLE_GHOST] == corners ||
            (n[PLANISH_ROLE_GHOST] > 0 && n[PLANISH_ROLE_OWN] > 0))
            return pl_fail_at(
                error, PLANISH_ERROR_MESH, i, -1,
                "element %" PRId64 " of mesh.part has %s; nodes at a GHOST are SHARED "
                "or GHOSTs, not all of them GHOSTs",
                i, n[PLANISH_ROLE_OWN] > 0 ? "both GHOST and OWN nodes" : "GHOSTs only");
    }
    return PLANISH_OK;
}

/* ---- a dense copy ------------------------------------------------------------------------- */

/** Copy node numbers to 32 bits; a number that is no node's becomes -1. */
static void narrow_chunk(void *context, int64_t begin, int64_t end, int thread) {
    pl_dense *dense = context;
    const planish_mesh *mesh = &dense->mesh;
    const int corners = mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin * corners; i < end * corners; i++) {
        const int64_t node = mesh->elements64[i];
        dense->elements[i] = node >= 0 && node < mesh->n_nodes ? (int32_t)node : -1;
    }
}

/** Check the coordinates of mesh, and copy them to dense if they have gaps. */
static int take_points(const planish_mesh *mesh, int threads, pl_dense *dense,
                       planish_error *error) {
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    const int status = pl_points_check(&points, threads, error);
    if (status || pl_points_are_dense(&points))
        return status;
    dense->coordinates = pl_alloc(mesh->n_nodes * mesh->dim, sizeof *dense->coordinates);
    if (!dense->coordinates)
        return pl_fail_memory(error, "the coordinates");
    pl_points_gather(&points, threads, dense->coordinates);
    dense->mesh.coordinates = dense->coordinates;
    dense->mesh.node_stride = dense->mesh.component_stride = 0;
    return PLANISH_OK;
}

/** Check the elements and coordinates of mesh, and make the copies that dense needs; dense->mesh is
 *  mesh at first. */
static int make_dense(const planish_mesh *mesh, int threads, pl_dense *dense,
                      planish_error *error) {
    const int64_t m = mesh->n_elements;
    int status = mesh->cells ? pl_corners_take(mesh, threads, dense, error) : PLANISH_OK;
    if (status)
        return status;
    if (mesh->elements64) {
        dense->elements = pl_alloc(m * (mesh->dim + 1), sizeof *dense->elements);
        if (!dense->elements)
            return pl_fail_memory(error, "the elements");
        pl_parallel_for(threads, m, CHUNK, narrow_chunk, dense);
        dense->mesh.elements = dense->elements;
        dense->mesh.elements64 = NULL;
    }
    lowest_search s = {.mesh = &dense->mesh, .lowest = INT64_MAX};
    if (!dense->role)
        pl_parallel_for(threads, m, CHUNK, check_chunk, &s);
    if (s.lowest < INT64_MAX)
        return pl_check_element(mesh->elements64 ? mesh : &dense->mesh, s.lowest, error);
    return take_points(mesh, threads, dense, error);
}

int pl_dense_create(const planish_mesh *mesh, int threads, pl_dense *dense, planish_error *error) {
    int status = pl_check_counts(mesh, error);
    if (status)
        return status;
    *dense = (pl_dense){.mesh = *mesh};
    status = make_dense(mesh, threads, dense, error);
    if (status)
        pl_dense_destroy(dense);
    return status;
}

int pl_dense_create_cells(const planish_mesh *mesh, int threads, pl_dense *dense,
                          planish_error *error) {
    *dense = (pl_dense){.mesh = *mesh};
    int status = pl_check_counts(mesh, error);
    if (!status)
        status = pl_check_cells(mesh->cells, mesh->n_nodes, threads, error);
    return status ? status : take_points(mesh, threads, dense, error);
}

void pl_dense_destroy(pl_dense *dense) {
    pl_free(dense->elements);
    pl_free(dense->coordinates);
    pl_free(dense->cell_of);
    pl_free(dense->corner);
    pl_free(dense->cell_begin);
    pl_free(dense->role);
    pl_free(dense->constraint);
    pl_free(dense->min_volume);
    pl_free(dense->periodic);
    *dense = (pl_dense){.elements = NULL};
}
