/* foam_groups: facets of the faces of the boundary and of zones; entities and groups of all sets. */
#include "io/foam/foam_groups.h"

#include "io/core/memberships.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

/* ---- facets --------------------------------------------------------------------------------- */

/** Make a line of a face across a layer; of one in its plane nothing. */
static int add_line(const foam_mesh *mesh, const int32_t *point, int n, int64_t face,
                    int32_t *thing, planish_error *error) {
    int32_t node[2];
    int k = 0;
    node[0] = foam_node(mesh, point[0]);
    while (k < n && foam_node(mesh, point[k]) == node[0])
        k++;
    if (n != 4 || k == n)
        return PLANISH_OK;
    node[1] = foam_node(mesh, point[k]);
    for (k = 0; k < n; k++)
        if (foam_node(mesh, point[k]) != node[0] && foam_node(mesh, point[k]) != node[1])
            return PLANISH_OK;
    *thing = (int32_t)mesh->model->line.n;
    return io_cells_add(mesh->model, 1, node, 0, face, error);
}

/** Make facets of the faces that are of the boundary or (is_wanted) in a zone: thing [n_faces] is the
 *  index of each among the triangles (of a layer: lines), or behind them among the quadrilaterals;
 *  else -1. */
static int make_facets(const foam_mesh *mesh, const uint8_t *is_wanted, int32_t *thing,
                       planish_error *error) {
    io_model *model = mesh->model;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < mesh->n_faces && !status; i++) {
        const int32_t *node = mesh->node + mesh->start[i];
        const int64_t n = mesh->start[i + 1] - mesh->start[i];
        thing[i] = -1;
        if (foam_neighbour(mesh, i) >= 0 && !is_wanted[i])
            continue;
        if (mesh->dim == 2) {
            status = add_line(mesh, node, (int)n, i, &thing[i], error);
        } else if (n == 3) {
            thing[i] = (int32_t)model->triangle.n;
            status = io_cells_add(model, 2, node, 0, i, error);
        } else if (n == 4) {
            thing[i] = (int32_t)model->flat.n;
            status = io_model_add_other(model, PLANISH_CELL_QUADRILATERAL, node, 0, i, error);
            model->n_other++;
        } else {
            for (int64_t k = 0; k < n; k++)
                io_hold_node(model, foam_node(mesh, node[k]), IO_HELD_BY_FACE);
            model->n_lower++;
        }
    }
    for (int64_t i = 0; mesh->dim == 3 && i < model->flat.n && !status; i++)
        thing[model->flat.number[i]] += (int32_t)model->triangle.n;
    return status;
}

/** Mark the faces that zones have, which list them one by one. */
static void mark_zones(const foam_sets *sets, uint8_t *is_wanted) {
    for (int64_t i = 0; i < sets->n; i++) {
        const foam_set *s = &sets->set[i];
        for (int64_t k = 0; s->things == FOAM_FACES && s->member && k < s->n; k++)
            is_wanted[s->member[k]] = 1;
    }
}

/* ---- entities ------------------------------------------------------------------------------- */

/** Add the members of all sets of things, as what these are in the model; thing NULL: themselves. */
static void add_members(const foam_sets *sets, foam_things things, const int32_t *thing,
                        io_memberships *m) {
    for (int64_t i = 0; i < sets->n; i++) {
        const foam_set *s = &sets->set[i];
        for (int64_t k = 0; s->things == things && k < s->n; k++) {
            const int64_t at = s->member ? s->member[k] : s->first + k;
            if (!thing || thing[at] >= 0)
                io_memberships_add(m, thing ? thing[at] : at, (int32_t)i + 1);
        }
    }
}

/** Return the dimension of things in the model. */
static int dim_of(const foam_mesh *mesh, foam_things things) {
    return things == FOAM_POINTS ? 0 : things == FOAM_FACES ? mesh->dim - 1 : mesh->dim;
}

/** Make one entity of all facets or cells, which no set has. */
static int make_one_entity(io_model *model, int dim, int64_t n_others, planish_error *error) {
    const io_cells *cells = io_model_cells(model, dim);
    const int32_t entity = io_model_entity(model, dim, 0, 0, NULL, error);
    for (int64_t i = 0; i < cells->n; i++)
        cells->entity[i] = entity;
    for (int64_t i = 0; i < n_others; i++)
        io_model_others(model, dim)->entity[i] = entity;
    return entity < 0 ? entity : PLANISH_OK;
}

/** Make the entities of nodes (dim 0), facets or cells by the sets that each is in. */
static int make_entities(const foam_mesh *mesh, const foam_sets *sets, foam_things things,
                         const int32_t *thing, planish_error *error) {
    static const io_others none = {.n = 0};
    io_model *model = mesh->model;
    const int dim = dim_of(mesh, things);
    io_cells *cells = dim ? io_model_cells(model, dim) : NULL;
    const io_others *others = dim > 1 ? io_model_others(model, dim) : &none;
    io_memberships m = {.n = 0};
    int64_t n_members = 0;
    for (int64_t i = 0; i < sets->n; i++)
        n_members += sets->set[i].things == things ? sets->set[i].n : 0;
    if (dim && n_members == 0 && cells->n + others->n > 0)
        return make_one_entity(model, dim, others->n, error);
    int status = io_memberships_begin(&m, dim ? cells->n + others->n : model->n_nodes, error);
    for (int pass = 0; pass < 2 && !status; pass++) {
        add_members(sets, things, thing, &m);
        if (pass == 0)
            status = io_memberships_counted(&m, error);
    }
    if (!status && !dim)
        status = io_memberships_of_nodes(&m, model, error);
    if (!status && dim && cells->n > 0)
        status = io_memberships_entities(&m, model, dim, 0, cells->n, NULL, cells->entity, error);
    if (!status && dim && others->n > 0)
        status = io_memberships_entities(&m, model, dim, cells->n, others->n, NULL, others->entity,
                                         error);
    io_memberships_destroy(&m);
    return status;
}

/** Name the groups of the sets. */
static int name_groups(const foam_mesh *mesh, const foam_sets *sets, planish_error *error) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < sets->n && !status; i++) {
        const foam_set *s = &sets->set[i];
        status = io_model_group(mesh->model, dim_of(mesh, s->things), (int32_t)i + 1, s->name,
                                (int64_t)strlen(s->name), error);
    }
    return status;
}

int foam_make_groups(const foam_mesh *mesh, const foam_sets *sets, planish_error *error) {
    int has_points = 0;
    uint8_t *is_wanted = pl_alloc_zero(mesh->n_faces, 1);
    int32_t *facet = pl_alloc(mesh->n_faces, sizeof *facet);
    int status = is_wanted && facet ? PLANISH_OK : pl_fail_memory(error, "faces of the boundary");
    if (!status) {
        mark_zones(sets, is_wanted);
        status = make_facets(mesh, is_wanted, facet, error);
    }
    for (int64_t i = 0; i < sets->n; i++)
        has_points |= sets->set[i].things == FOAM_POINTS;
    if (!status)
        status = make_entities(mesh, sets, FOAM_FACES, facet, error);
    if (!status)
        status = make_entities(mesh, sets, FOAM_CELLS, mesh->thing, error);
    if (!status && has_points)
        status = make_entities(mesh, sets, FOAM_POINTS, mesh->model->place_node, error);
    if (!status)
        status = name_groups(mesh, sets, error);
    pl_free(is_wanted);
    pl_free(facet);
    return status;
}
