/* planish_shape: layers, regions, interfaces, and the surface that nodes may slide on. */
#include "shape/create.h"
#include "shape/distance.h"
#include "shape/shape.h"
#include "shape/walk.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/arc_cosine.h"
#include "topology/cells.h"
#include "topology/no_node.h"
#include "topology/points.h"
#include "topology/topology.h"

#include <inttypes.h>
#include <string.h>

/* The largest tolerance of planish_find_slides: beyond it much of any surface would be plane. */
#define LARGEST_TOLERANCE 1e-3

/** A call on a mesh. */
typedef struct shape_call {
    const planish_mesh *mesh; /* the caller's, or bare */
    planish_mesh bare;        /* the same without targets, which would turn simplices to cells */
    int threads;
    pl_outside outside;
    pl_dense dense;             /* the mesh, owned */
    const planish_cells *cells; /* that facets are of; NULL: simplices */
    planish_mesh flat;          /* what mesh is, if the caller's is a surface that counts as flat */
} shape_call;

/** Whether a mesh in space is a surface. */
static int is_surface_mesh(const planish_mesh *mesh) {
    return mesh && mesh->dim == 3 && mesh->cells && mesh->cells->type &&
           pl_is_of_faces(mesh->cells, 3);
}

/** Take the mesh, which may be NULL, without targets: surfaces have none. */
static void take_bare(const planish_mesh *mesh, shape_call *call) {
    call->mesh = mesh;
    if (!mesh)
        return;
    call->bare = *mesh;
    call->bare.reference = NULL;
    call->bare.is_layer = NULL;
    call->bare.size = NULL;
    call->bare.metric = NULL;
    call->mesh = &call->bare;
}

/** Check threads and the mesh, and enter; end_call follows unless that fails. takes_surfaces: also one that is
 *  a surface itself, whose elements are call->cells alone. */
static int begin_call(const planish_mesh *mesh, int threads, int takes_surfaces, shape_call *call,
                      planish_error *error) {
    int status = pl_check_threads(threads, error);
    if (status)
        return status;
    take_bare(mesh, call);
    mesh = call->mesh;
    call->dense = (pl_dense){.corner = NULL};
    call->threads = pl_thread_count(threads);
    call->outside = pl_call_enter(NULL);
    if (takes_surfaces && is_surface_mesh(mesh)) {
        call->cells = mesh->cells;
        status = pl_dense_create_cells(mesh, call->threads, &call->dense, error);
        if (status)
            pl_dense_destroy(&call->dense);
    } else {
        status = pl_dense_create(mesh, call->threads, &call->dense, error);
        call->cells = !status && call->dense.corner ? mesh->cells : NULL;
    }
    if (status)
        pl_call_leave(&call->outside);
    return status;
}

/** Check a surface in space, and set flat to the same elements in a plane, by x and y. */
static int flatten(const planish_mesh *mesh, int threads, planish_mesh *flat,
                   planish_error *error) {
    const int status = pl_check_counts(mesh, error);
    if (status)
        return status;
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    *flat = (planish_mesh){.dim = 2,
                           .n_nodes = mesh->n_nodes,
                           .n_elements = mesh->n_elements,
                           .coordinates = mesh->coordinates,
                           .cells = mesh->cells,
                           .node_stride = points.step,
                           .component_stride = points.apart};
    return pl_points_check(&points, threads, error);
}

/** Begin a call that asks which elements join, not where they are: a surface in space counts as flat. */
static int begin_call_on_joints(const planish_mesh *mesh, int threads, shape_call *call,
                                planish_error *error) {
    if (!is_surface_mesh(mesh))
        return begin_call(mesh, threads, 0, call, error);
    int status = pl_check_threads(threads, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    status = flatten(mesh, pl_thread_count(threads), &call->flat, error);
    pl_call_leave(&outside);
    return status ? status : begin_call(&call->flat, threads, 0, call, error);
}

static void end_call(shape_call *call) {
    pl_dense_destroy(&call->dense);
    pl_call_leave(&call->outside);
}

/* ---- layers ------------------------------------------------------------------------------- */

/* Elements that are no simplices make layers only if they are valid and their least scaled Jacobian is so
 * much: those of tangled meshes are thin by chance. */
static const double LEAST_SCALED_JACOBIAN = 0.3;

/** Elements of any types, thin ones among which are sought. */
typedef struct cells_call {
    pl_dense dense;    /* the mesh with its cells, owned */
    uint8_t *thinness; /* [cells->n] */
    uint8_t *state;    /* [cells->n] or NULL */
    double *scaled_jacobian;
} cells_call;

/** Mark thin elements that are not valid, or badly shaped. */
static int mark_badly_shaped(int threads, cells_call *c, planish_error *error) {
    const int64_t n = c->dense.mesh.cells->n;
    planish_cell_quality quality;
    c->state = pl_alloc(n, sizeof *c->state);
    c->scaled_jacobian = pl_alloc(n, sizeof *c->scaled_jacobian);
    if (!c->state || !c->scaled_jacobian)
        return pl_fail_memory(error, "thin elements");
    const planish_cell_values values = {.state = c->state, .scaled_jacobian = c->scaled_jacobian};
    planish_mesh mesh = c->dense.mesh;
    mesh.reference = NULL;
    mesh.is_layer = NULL;
    const int status = planish_measure_cells(&mesh, 0, threads, &quality, &values, error);
    for (int64_t i = 0; !status && i < n; i++) {
        const int is_valid = c->state[i] == PLANISH_CELL_STATE_VALID;
        if (c->thinness[i] && !(is_valid && c->scaled_jacobian[i] >= LEAST_SCALED_JACOBIAN))
            c->thinness[i] |= (uint8_t)(PL_BADLY_SHAPED | (is_valid ? 0 : PL_IS_INVALID));
    }
    return status;
}

static int find_layers_of_cells(const planish_mesh *mesh, int threads, uint8_t *is_layer,
                                int64_t *n_layer, planish_error *error) {
    cells_call c = {.thinness = NULL};
    int64_t n_thin = 0;
    int status = pl_check_threads(threads, error);
    if (status)
        return status;
    threads = pl_thread_count(threads);
    const pl_outside outside = pl_call_enter(NULL);
    status = pl_dense_create_cells(mesh, threads, &c.dense, error);
    if (!status && !(c.thinness = pl_alloc(mesh->cells->n, sizeof *c.thinness)))
        status = pl_fail_memory(error, "thin elements");
    if (!status)
        status = pl_find_thinness(&c.dense.mesh, threads, c.thinness, &n_thin, error);
    if (!status && n_thin > 0)
        status = mark_badly_shaped(threads, &c, error);
    if (!status)
        status =
            pl_find_layers_of_cells(&c.dense.mesh, c.thinness, threads, is_layer, n_layer, error);
    pl_dense_destroy(&c.dense);
    pl_free(c.thinness);
    pl_free(c.state);
    pl_free(c.scaled_jacobian);
    pl_call_leave(&outside);
    return status;
}

int planish_find_layers(const planish_mesh *mesh, int threads, uint8_t *is_layer, int64_t *n_layer,
                        planish_error *error) {
    shape_call call;
    int64_t n = 0;
    if (!is_layer)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "is_layer must not be NULL");
    int status = PLANISH_OK;
    if (mesh && mesh->cells) {
        status = find_layers_of_cells(mesh, threads, is_layer, &n, error);
    } else if (!(status = begin_call(mesh, threads, 0, &call, error))) {
        status = pl_find_layers(&call.dense.mesh, NULL, call.threads, is_layer, &n, error);
        end_call(&call);
    }
    if (!status && n_layer)
        *n_layer = n;
    return status;
}

/* ---- regions ------------------------------------------------------------------------------ */

int planish_rank_region_name(const char *name) {
    return pl_region_name(name);
}

/** Find regions with the values of the mesh's elements alone. */
static int find_regions(const shape_call *call, planish_cell_array *arrays, int n_arrays,
                        planish_error *error) {
    const planish_mesh *mesh = call->dense.corner ? call->mesh : &call->dense.mesh;
    if (call->dense.corner || !call->dense.cell_of)
        return pl_find_regions(mesh, arrays, n_arrays, call->threads, error);
    planish_cell_array *taken = pl_alloc_zero(n_arrays, sizeof *taken);
    int failed = !taken;
    for (int i = 0; taken && i < n_arrays; i++) {
        taken[i] = arrays[i];
        taken[i].values = pl_rows_take(arrays[i].values, call->dense.cell_of, mesh->n_elements,
                                       pl_number_size(arrays[i].type), call->threads, &failed);
    }
    const int status = failed ? pl_fail_memory(error, "the arrays of elements")
                              : pl_find_regions(mesh, taken, n_arrays, call->threads, error);
    for (int i = 0; !status && i < n_arrays; i++)
        arrays[i].is_region = taken[i].is_region;
    for (int i = 0; taken && i < n_arrays; i++)
        pl_free((void *)taken[i].values);
    pl_free(taken);
    return status;
}

int planish_find_regions(const planish_mesh *mesh, planish_cell_array *arrays, int n_arrays,
                         int threads, planish_error *error) {
    shape_call call;
    if (mesh && mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "regions are found in the whole mesh, not in a part of it");
    int status = begin_call_on_joints(mesh, threads, &call, error);
    if (status)
        return status;
    status = pl_check_cell_arrays(arrays, n_arrays, mesh->n_elements, error);
    if (!status)
        status = find_regions(&call, arrays, n_arrays, error);
    end_call(&call);
    return status;
}

int planish_combine_regions(int64_t n_elements, const planish_cell_array *arrays, int n_arrays,
                            int32_t *region, int64_t *n_regions, planish_error *error) {
    if (n_elements < 0 || n_elements > INT32_MAX || !region)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "n_elements is %" PRId64 ": it must be 0 to %d, and region not NULL",
                       n_elements, INT32_MAX);
    int64_t n = 0;
    int status = pl_check_cell_arrays(arrays, n_arrays, n_elements, error);
    if (status)
        return status;
    const pl_outside outside = pl_call_enter(NULL);
    int32_t *found = pl_alloc_zero(n_elements, sizeof *found);
    status = found ? pl_combine_regions(n_elements, arrays, n_arrays, found, &n, error)
                   : pl_fail_memory(error, "the regions of elements");
    if (!status)
        memcpy(region, found, (size_t)n_elements * sizeof *found);
    if (!status && n_regions)
        *n_regions = n;
    pl_free(found);
    pl_call_leave(&outside);
    return status;
}

/** Make *region, by the caller's elements, one by the mesh's: *taken, owned, is set if it is a copy.
 *  NULL stays. */
static int take_regions(const shape_call *call, const int32_t **region, int32_t **taken,
                        planish_error *error) {
    int failed = 0;
    if (!call->dense.cell_of)
        return PLANISH_OK;
    *taken = pl_rows_take(*region, call->dense.cell_of, call->dense.mesh.n_elements, sizeof **taken,
                          call->threads, &failed);
    *region = *taken;
    return failed ? pl_fail_memory(error, "the regions of elements") : PLANISH_OK;
}

int planish_find_interfaces(const planish_mesh *mesh, const int32_t *region, int threads,
                            uint8_t *is_between, int64_t *n_between, planish_error *error) {
    shape_call call;
    int64_t n = 0;
    if (!region || !is_between)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "region and is_between must not be NULL");
    int status = begin_call_on_joints(mesh, threads, &call, error);
    if (status)
        return status;
    status = pl_find_interfaces(call.mesh->cells ? call.mesh : &call.dense.mesh, region, is_between,
                                &n, error);
    end_call(&call);
    if (!status && n_between)
        *n_between = n;
    return status;
}

/* ---- slides ------------------------------------------------------------------------------- */

/** Whether nodes [n] are those of the mesh. */
static int check_nodes(const planish_mesh *mesh, const int32_t *nodes, int64_t n, const char *what,
                       planish_error *error) {
    char there[PL_NODES_TEXT];
    if (n > 0 && !nodes)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "surface.%s must not be NULL", what);
    for (int64_t i = 0; i < n; i++)
        if (nodes[i] < 0 || nodes[i] >= mesh->n_nodes)
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, nodes[i],
                              "surface.%s has the node %" PRId32 " at %" PRId64
                              ", but the mesh has %s",
                              what, nodes[i], i, pl_nodes_there(mesh->n_nodes, there));
    return PLANISH_OK;
}

/** Facets and edges that are listed: more than any mesh of INT32_MAX nodes has. */
static const int64_t MOST_LISTED = (int64_t)8 * INT32_MAX;

/** Number of corners of a facet of n nodes; 0: no facet has so many. */
static int corners_of(int dim, int64_t n) {
    if (dim == 2)
        return n == 2 || n == 3 ? 2 : 0;
    return n == 3 || n == 6 ? 3 : n == 4 || n == 8 || n == 9 ? 4 : 0;
}

/** Check facets of any numbers of nodes: offsets, and corners. */
static int check_facets(const planish_mesh *mesh, const planish_surface *tags,
                        planish_error *error) {
    const int64_t *offset = tags->facet_offset;
    if (!offset)
        return check_nodes(mesh, tags->facets, tags->n_facets * mesh->dim, "facets", error);
    if (tags->n_facets > 0 && !tags->facets)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "surface.facets must not be NULL");
    for (int64_t i = 0; i < tags->n_facets; i++) {
        const int n = offset[0] == 0 && offset[i + 1] > offset[i]
                          ? corners_of(mesh->dim, offset[i + 1] - offset[i])
                          : 0;
        if (n == 0)
            return pl_fail(
                error, PLANISH_ERROR_ARGUMENT,
                "surface.facet_offset of facet %" PRId64 " is %" PRId64 ", of the next one %" PRId64
                "; offsets begin at 0, and facets have %s nodes",
                i, offset[i], offset[i + 1], mesh->dim == 3 ? "3, 4, 6, 8 or 9" : "2 or 3");
        const int status = check_nodes(mesh, tags->facets + offset[i], n, "facets", error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

static int check_tags(const planish_mesh *mesh, const planish_surface *tags, planish_error *error) {
    if (!tags)
        return PLANISH_OK;
    if (tags->n_facets < 0 || tags->n_edges < 0)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "surface.n_facets and n_edges must not be negative");
    if (tags->n_facets > MOST_LISTED || tags->n_edges > MOST_LISTED)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "surface.%s is %" PRId64 "; it must be at most %" PRId64,
                       tags->n_facets > MOST_LISTED ? "n_facets" : "n_edges",
                       tags->n_facets > MOST_LISTED ? tags->n_facets : tags->n_edges, MOST_LISTED);
    if (!(tags->tolerance >= 0 && tags->tolerance <= LARGEST_TOLERANCE))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "surface.tolerance is %g; give 0 to %g of the diagonal of the bounding box",
                       tags->tolerance, LARGEST_TOLERANCE);
    int status = pl_check_reserved("planish_surface", tags->reserved, sizeof tags->reserved, error);
    if (!status)
        status = check_facets(mesh, tags, error);
    return status ? status : check_nodes(mesh, tags->edges, tags->n_edges * 2, "edges", error);
}

/** Whether a shape, which may be NULL, can be one of mesh. */
static int check_shape_of(const planish_mesh *mesh, const planish_shape *shape,
                          planish_error *error) {
    if (!shape)
        return PLANISH_OK;
    if (mesh->dim != 3)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "surface.shape is that of a mesh in space, but mesh.dim is %d", mesh->dim);
    if (shape->n_mesh != mesh->n_nodes)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "surface.shape was made of a mesh of %" PRId64
                       " nodes, but this one has %" PRId64 "; make a shape of it",
                       shape->n_mesh, mesh->n_nodes);
    return PLANISH_OK;
}

static int find_slides(shape_call *call, const planish_surface *surface, uint8_t *constraint,
                       double *direction, planish_slide_info *info, planish_error *error) {
    planish_surface tags = surface ? *surface : (planish_surface){0};
    int32_t *taken = NULL;
    call->dense.mesh.constraint = call->mesh->constraint;
    int status = call->cells ? PLANISH_OK : take_regions(call, &tags.region, &taken, error);
    if (!status)
        status = pl_find_slides(&call->dense, call->mesh, surface ? &tags : NULL, call->threads,
                                constraint, direction, info, error);
    pl_free(taken);
    return status;
}

int planish_find_slides(const planish_mesh *mesh, const planish_surface *surface, int threads,
                        uint8_t *constraint, double *direction, planish_slide_info *info,
                        planish_error *error) {
    planish_slide_info found = {0};
    shape_call call;
    if (!constraint || !direction)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "constraint and direction must not be NULL");
    int status = begin_call(mesh, threads, 1, &call, error);
    if (status)
        return status;
    status = check_tags(mesh, surface, error);
    if (!status)
        status = check_shape_of(mesh, surface ? surface->shape : NULL, error);
    for (int64_t i = 0; !status && mesh->constraint && i < mesh->n_nodes; i++)
        if (mesh->constraint[i] > PLANISH_CONSTRAINT_ON_CURVE)
            status = pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i,
                                "mesh.constraint of node %" PRId64
                                " is %d; give a planish_constraint, 0 to %d",
                                i, mesh->constraint[i], PLANISH_CONSTRAINT_ON_CURVE);
    if (!status)
        status = find_slides(&call, surface, constraint, direction, &found, error);
    end_call(&call);
    if (!status && info)
        *info = found;
    return status;
}

/* ---- curved surfaces ------------------------------------------------------------------------ */

/** Check the arguments of planish_shape_create that no other call checks. */
static int check_shape(const planish_mesh *mesh, const planish_surface *surface,
                       planish_shape **shape, planish_error *error) {
    const double angle = surface ? surface->crease_angle : 0;
    if (!shape)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "shape must not be NULL");
    *shape = NULL;
    if (!(angle >= 0 && angle <= 180))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "surface.crease_angle is %g degrees; give 0 to 180", angle);
    if (mesh && mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "the shape of a surface is made of the whole mesh, not of a part of it");
    if (mesh && mesh->dim == 2)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.dim is 2; shapes are of meshes in space: give dim 3");
    return PLANISH_OK;
}

int planish_shape_create(const planish_mesh *mesh, const planish_surface *surface, int threads,
                         planish_shape **shape, planish_shape_info *info, planish_error *error) {
    planish_shape_info found = {0};
    shape_call call;
    int status = check_shape(mesh, surface, shape, error);
    if (status)
        return status;
    status = begin_call(mesh, threads, 1, &call, error);
    if (status)
        return status;
    planish_surface tags = surface ? *surface : (planish_surface){0};
    const planish_cells *cells = call.cells;
    int32_t *taken = NULL;
    status = check_tags(mesh, surface, error);
    if (!status && !cells)
        status = take_regions(&call, &tags.region, &taken, error);
    if (!status)
        status = pl_shape_create(&call.dense.mesh, mesh, cells, &tags, call.threads, shape, &found,
                                 error);
    pl_free(taken);
    end_call(&call);
    if (!status && info)
        *info = found;
    return status;
}

void planish_shape_destroy(planish_shape *shape) {
    pl_shape_destroy(shape);
}

void planish_shape_get_classes(const planish_shape *shape, uint8_t *node_class) {
    static const uint8_t CLASS[] = {[PL_CORNER] = PLANISH_SHAPE_CORNER,
                                    [PL_ON_PATCH] = PLANISH_SHAPE_PATCH,
                                    [PL_ON_CURVE] = PLANISH_SHAPE_CURVE};
    for (int64_t i = 0; shape && node_class && i < shape->n_mesh; i++)
        node_class[i] =
            shape->number[i] < 0 ? PLANISH_SHAPE_NONE : CLASS[shape->node_class[shape->number[i]]];
}

void planish_shape_get_edges(const planish_shape *shape, int32_t *edge) {
    for (int64_t i = 0; shape && edge && i < 2 * shape->n_edges; i++)
        edge[i] = shape->node[shape->edge[i / 2][i % 2]];
}

/** Present places of a shape's nodes. */
typedef struct moved_shape {
    const planish_shape *shape;
    const pl_points *points; /* of the mesh's nodes */
    double (*x)[3];          /* [n_nodes] in the shape's units */
    pl_place *place;         /* [n_nodes] */
} moved_shape;

static void place_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const moved_shape *m = context;
    const planish_shape *s = m->shape;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int is_there = 1;
        for (int d = 0; d < 3; d++) {
            m->x[i][d] = m->points->x[pl_point_at(m->points, s->node[i], d)] * s->scale;
            is_there &= m->x[i][d] == s->x[i][d];
        }
        m->place[i] = pl_shape_first_place(s, (int32_t)i);
        if (m->place[i].at >= 0 && !is_there)
            pl_shape_walk(s, s->node_class[i], m->x[i], &m->place[i]);
    }
}

static int measure_shape(const planish_shape *shape, const pl_points *points, int threads,
                         planish_shape_distance *distance, planish_error *error) {
    enum { CHUNK = 512 };
    static const double DEGREES = 180 / 3.1415926535897932385;
    pl_shape_distance d = {0};
    moved_shape m = {shape, points, pl_alloc(shape->n_nodes, sizeof *m.x),
                     pl_alloc(shape->n_nodes, sizeof *m.place)};
    int status = m.x && m.place ? PLANISH_OK : pl_fail_memory(error, "the nodes of the surface");
    if (!status) {
        pl_parallel_for(threads, shape->n_nodes, CHUNK, place_nodes, &m);
        status = pl_shape_measure(shape, (const double(*)[3])m.x, m.place, threads, &d, error);
    }
    if (!status)
        *distance = (planish_shape_distance){
            .distance = d.there / shape->scale,
            .distance_back = d.back / shape->scale,
            .in_edges = d.there_h,
            .back_in_edges = d.back_h,
            .n_unproved = d.n_unproved,
            .max_bend = DEGREES * pl_arc_cosine(d.sharpest),
            .max_bend_before = DEGREES * pl_arc_cosine(pl_shape_sharpest(shape, threads))};
    pl_free(m.x);
    pl_free(m.place);
    return status;
}

int planish_shape_measure(const planish_shape *shape, const planish_mesh *mesh, int threads,
                          planish_shape_distance *distance, planish_error *error) {
    if (!shape || !distance)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "shape and distance must not be NULL");
    int status = pl_check_nodes(mesh, error);
    if (!status)
        status = pl_check_threads(threads, error);
    if (status)
        return status;
    if (mesh->dim != 3 || mesh->n_nodes != shape->n_mesh)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "the mesh has %" PRId64
                       " nodes of dimension %d, but the shape was made of one "
                       "of %" PRId64 " nodes in space",
                       mesh->n_nodes, mesh->dim, shape->n_mesh);
    const pl_outside outside = pl_call_enter(NULL);
    const pl_points points = pl_points_of(mesh, mesh->coordinates);
    threads = pl_thread_count(threads);
    status = pl_points_check(&points, threads, error);
    if (!status)
        status = measure_shape(shape, &points, threads, distance, error);
    pl_call_leave(&outside);
    return status;
}
