/* targets: elements of a plan that are to have the shapes of mesh.reference, of layers, or of a field of
 * sizes. */
#include "plan/targets.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/size_field.h"
#include "shape/layer_shapes.h"
#include "topology/frame.h"
#include "topology/topology.h"

#include <float.h>
#include <inttypes.h>
#include <math.h>

enum { CHUNK = 4096 };

/* ---- simplices as cells ---------------------------------------------------------------------- */

/** Simplices being made cells. */
typedef struct cell_copy {
    const planish_mesh *mesh;
    pl_own_cells *own;
} cell_copy;

static void copy_cells(void *context, int64_t begin, int64_t end, int thread) {
    const cell_copy *c = context;
    const int k = c->mesh->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        c->own->type[i] = k == 4 ? PLANISH_CELL_TETRAHEDRON : PLANISH_CELL_TRIANGLE;
        c->own->offset[i + 1] = (i + 1) * k;
        for (int j = 0; j < k; j++) {
            const int64_t node = pl_corner(c->mesh, i, j);
            c->own->node[i * k + j] = node >= 0 && node < c->mesh->n_nodes ? (int32_t)node : -1;
        }
    }
}

int pl_own_cells_make(const planish_mesh *mesh, int threads, pl_own_cells *own,
                      planish_cells *cells, planish_mesh *with, planish_error *error) {
    const int64_t n = mesh->n_elements;
    int status = pl_check_counts(mesh, error);
    if (status)
        return status;
    own->type = pl_alloc(n, sizeof *own->type);
    own->offset = pl_alloc_zero(n + 1, sizeof *own->offset);
    own->node = pl_alloc(n * (mesh->dim + 1), sizeof *own->node);
    if (!own->type || !own->offset || !own->node)
        return pl_fail_memory(error, "the elements");
    cell_copy copy = {mesh, own};
    pl_parallel_for(threads, n, CHUNK, copy_cells, &copy);
    for (int64_t i = 0; !status && i < n; i++)
        status = pl_check_element(mesh, i, error);
    *cells = (planish_cells){n, own->type, own->offset, own->node, {NULL}};
    *with = *mesh;
    with->cells = cells;
    with->elements = NULL;
    with->elements64 = NULL;
    with->neighbours = NULL;
    with->neighbours64 = NULL;
    return status;
}

/* ---- targets --------------------------------------------------------------------------------- */

/** Targets being made. */
typedef struct target_pass {
    const planish_plan *plan;
    const int8_t *sign;
    pl_points reference;
    pl_target *target;
    int64_t lowest; /* element that has none; shared */
} target_pass;

/** Edges of an element of the reference; returns its sign. */
static double reference_edges(const target_pass *p, int64_t element, double edges[3][3]) {
    const int dim = p->plan->dim;
    const int32_t *node = p->plan->work.elements + element * (dim + 1);
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edges[j][d] = p->reference.x[pl_point_at(&p->reference, node[j + 1], d)] -
                          p->reference.x[pl_point_at(&p->reference, node[0], d)];
    return p->sign ? p->sign[element] : 1;
}

static void make_chunk(void *context, int64_t begin, int64_t end, int thread) {
    target_pass *p = context;
    int64_t lowest = INT64_MAX;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double edges[3][3] = {{0}};
        const double sign = reference_edges(p, i, edges);
        if (!pl_target_make(p->plan->dim, (const double(*)[3])edges, sign, &p->target[i]) &&
            i < lowest)
            lowest = i;
    }
    pl_lower_to(&p->lowest, lowest);
}

/** Say what is wrong with the element that has no target. */
static int complain(const target_pass *p, planish_error *error) {
    const int64_t element = pl_plan_element(p->plan, p->lowest);
    double edges[3][3] = {{0}};
    const double sign = reference_edges(p, p->lowest, edges);
    const double D = sign * pl_determinant_of_edges(p->plan->dim, (const double(*)[3])edges);
    return pl_fail_at(error, PLANISH_ERROR_MESH, element, -1,
                      "element %" PRId64 " %s in mesh.reference; all smoothed elements must be "
                      "valid there, oriented as in the mesh",
                      element, pl_target_flaw(p->plan->dim, (const double(*)[3])edges, D));
}

int pl_targets_make(planish_plan *plan, pl_points reference, const int8_t *sign,
                    planish_error *error) {
    target_pass p = {.plan = plan, .sign = sign, .reference = reference, .lowest = INT64_MAX};
    plan->work.target = p.target = pl_alloc(plan->work.n_elements, sizeof *p.target);
    if (!p.target)
        return pl_fail_memory(error, "the targets of the elements");
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, make_chunk, &p);
    return p.lowest < INT64_MAX ? complain(&p, error) : PLANISH_OK;
}

/* ---- layers ----------------------------------------------------------------------------------- */

/** Targets being made of layers. */
typedef struct layer_pass {
    const planish_plan *plan;
    const planish_mesh *given;
    const double *x; /* [n_nodes][dim] as they were, */
    pl_frame frame;  /* in whose units layers have their sizes */
    pl_layer_shapes shapes;
    pl_target *target;
} layer_pass;

/** Sum of the squared edges of a corner, those between its neighbours, too. */
static double squares_of(int dim, const double edges[3][3]) {
    double sum = 0, between[3];
    for (int j = 0; j < dim; j++) {
        sum += pl_dot(dim, edges[j], edges[j]);
        for (int k = 0; k < j; k++) {
            pl_subtract(dim, edges[j], edges[k], between);
            sum += pl_dot(dim, between, between);
        }
    }
    return sum;
}

/** Give the target of a corner that is no layer's, an ideal one, the size that the corner has: layers have
 *  theirs, and untangling wants the sizes of all targets in one unit. */
static void give_size(const layer_pass *p, const pl_cell_shape *shape, int64_t element,
                      pl_target *target) {
    const int dim = p->plan->dim;
    const int32_t *node = p->plan->work.elements + element * (dim + 1);
    double ideal[3][3] = {{0}}, edges[3][3] = {{0}};
    pl_ideal_edges(shape, ideal);
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            edges[j][d] = pl_frame_difference(&p->frame, p->x[(int64_t)node[j + 1] * dim + d],
                                              p->x[(int64_t)node[0] * dim + d]);
    const double square =
        squares_of(dim, (const double(*)[3])edges) / squares_of(dim, (const double(*)[3])ideal);
    const double measure = (dim == 3 ? sqrt(square) : 1) * square * target->measure;
    if (!(measure > DBL_MIN && 1 / measure > DBL_MIN))
        return;
    target->measure = measure;
    target->unit = 1 / measure;
}

static void make_layer_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const layer_pass *p = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t cell = pl_plan_element(p->plan, i);
        const pl_cell_shape *shape = pl_cell_type_of(p->given->cells->type[cell])->shape;
        pl_layer_shapes_target(&p->shapes, shape, cell, pl_corner_index(p->plan->work.corner[i]),
                               &p->target[i]);
        if (p->shapes.place[cell] == -1)
            give_size(p, shape, i, &p->target[i]);
    }
}

/** Whether an element of a layer is no simplex: thin simplices are sharp. */
static int has_thin_product(const planish_mesh *mesh) {
    int found = 0;
    for (int64_t i = 0; !found && i < mesh->cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(mesh->cells->type[i]);
        found = mesh->is_layer[i] && type && type->shape->n_simplices > 1;
    }
    return found;
}

int pl_layer_targets_make(planish_plan *plan, const planish_mesh *given, planish_error *error) {
    const pl_points points =
        pl_points_of(given, given->reference ? given->reference : given->coordinates);
    double *own = NULL;
    layer_pass p = {.plan = plan, .given = given};
    planish_mesh mesh = *given;
    plan->is_blunt = has_thin_product(given);
    plan->work.target = p.target = pl_alloc(plan->work.n_elements, sizeof *p.target);
    if (!pl_points_are_dense(&points))
        own = pl_alloc(given->n_nodes * given->dim, sizeof *own);
    if (!p.target || (!own && !pl_points_are_dense(&points)))
        return pl_fail_memory(error, "the targets of the elements");
    if (own)
        pl_points_gather(&points, plan->threads, own);
    mesh.coordinates = p.x = own ? own : points.x;
    int status = pl_frame_create(&mesh, NULL, plan->threads, &p.frame, error);
    if (!status)
        status = pl_layer_shapes_find(&mesh, given->is_layer, plan->threads, &p.shapes, error);
    if (!status)
        pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, make_layer_chunk, &p);
    pl_layer_shapes_free(&p.shapes);
    pl_free(own);
    return status;
}

/* ---- sizes ------------------------------------------------------------------------------------ */

int pl_size_targets_make(planish_plan *plan, const planish_mesh *given, const double *x,
                         planish_error *error) {
    plan->sizes = pl_alloc_zero(1, sizeof *plan->sizes);
    const int n_numbers = given->metric ? pl_symmetric_count(plan->dim) : 1;
    plan->scratch.sizes = pl_alloc(given->n_nodes * n_numbers, sizeof *plan->scratch.sizes);
    plan->work.target = pl_alloc(plan->work.n_elements, sizeof *plan->work.target);
    if (given->metric)
        plan->work.metric = pl_alloc(plan->work.n_elements, sizeof *plan->work.metric);
    if (!plan->sizes || !plan->scratch.sizes || !plan->work.target ||
        !plan->work.metric != !given->metric)
        return pl_fail_memory(error, "the field of sizes");
    const int status = pl_size_field_create(given, x, plan->threads, plan->sizes, error);
    if (!status)
        pl_plan_fit_sizes(plan, x, NULL);
    return status;
}
