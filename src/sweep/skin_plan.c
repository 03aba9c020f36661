/* skin_plan: the skin of a plan's mesh. */
#include "sweep/skin.h"

#include "base/memory.h"
#include "geometry/cell.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/** Find how nodes move that follow others. Returns 0 without memory. */
static int find_followers(pl_skin *skin) {
    const planish_plan *plan = skin->plan;
    const pl_visits *visits = &plan->sliding;
    int32_t *of_inner =
        visits->n_followers > 0 ? pl_alloc(plan->work.n_nodes, sizeof *of_inner) : NULL;
    for (int64_t i = 0; of_inner && i < plan->work.n_nodes; i++)
        of_inner[plan->inner[i]] = skin->shape->number[pl_plan_node(plan, i)];
    for (int64_t k = 0; of_inner && k < visits->n_followers; k++) {
        const pl_follower *f = &visits->follower[k];
        const int32_t node = f->node < plan->work.n_nodes ? of_inner[f->node] : -1;
        const int32_t leader = of_inner[f->of];
        if (node < 0)
            continue;
        skin->moves[node] = leader >= 0 && skin->moves[leader] == PL_SKIN_STAYS ? PL_SKIN_STAYS
                            : pl_skin_is_curved(skin, node)                     ? PL_SKIN_LOOSE
                                                                                : PL_SKIN_FLAT;
    }
    pl_free(of_inner);
    return of_inner || visits->n_followers == 0;
}

/** Number the nodes of the shape that the plan has, with those that it may move, and their stars. */
static void number_nodes(pl_skin *skin) {
    const planish_plan *plan = skin->plan;
    const planish_shape *shape = skin->shape;
    memset(skin->inner, -1, (size_t)shape->n_nodes * sizeof *skin->inner);
    memset(skin->star, -1, (size_t)shape->n_nodes * sizeof *skin->star);
    for (int32_t i = 0; shape->whole && i < shape->n_nodes; i++)
        if (shape->star_offset[i + 1] == shape->star_offset[i])
            skin->inner[i] = PL_SKIN_MID;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t node = shape->number[pl_plan_node(plan, i)];
        if (node < 0 || skin->inner[node] == PL_SKIN_MID)
            continue;
        skin->inner[node] = plan->inner[i];
        skin->moves[node] = plan->work.mobility[i] == PL_HELD ? PLANISH_CONSTRAINT_FIXED
                            : plan->is_used[i] & PL_IN_PAIR   ? PL_SKIN_PAIRED
                                                              : PL_SKIN_LOOSE;
    }
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++) {
        skin->node[s] = shape->number[plan->slide[s].node];
        if (skin->node[s] >= 0)
            skin->star[skin->node[s]] = (int32_t)s;
    }
}

/** Tell the plan how its nodes slide in this run. */
static void set_slides(planish_plan *plan, const pl_skin *skin) {
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++) {
        const planish_constraint by = (planish_constraint)plan->slides_by[s];
        plan->slide[s].kind = by < PLANISH_CONSTRAINT_ON_PATCH ? by : PLANISH_CONSTRAINT_ON_LINE;
        if (!skin->shape)
            continue;
        const int32_t node = skin->node[s];
        if (node >= 0 && skin->moves[node] < PL_SKIN_FLAT)
            plan->slide[s].kind = PLANISH_CONSTRAINT_ON_SURFACE;
        if (node >= 0 && !pl_skin_has(skin, node))
            skin->node[s] = -1;
    }
}

/** Whether an element has a mid that goes to the shape. */
static int has_placed(const pl_skin *skin, int64_t element) {
    const planish_plan *plan = skin->plan;
    const int32_t *number = skin->shape->number;
    const int64_t cell = pl_plan_element(plan, element);
    const int32_t *node = plan->cells.node + plan->cells.offset[cell];
    const pl_cell_type *type = pl_cell_type_of(plan->cells.type[cell]);
    int any = 0;
    for (int i = type->shape->n_corners; i < type->n_nodes; i++) {
        const int32_t mid = node[i] < 0 ? -1 : number[node[i]];
        const uint8_t parents = pl_cell_parents(type, i);
        int32_t parent[PL_CELL_CORNERS];
        int n = 0, are_there = mid >= 0 && skin->inner[mid] == PL_SKIN_MID;
        for (int j = 0; j < type->shape->n_corners; j++)
            if (parents >> j & 1) {
                parent[n] = number[node[j]];
                are_there &= parent[n++] >= 0;
            }
        any |= are_there && pl_skin_is_placed(skin, mid, parent, n);
    }
    return any;
}

/** Let mids go to the shape, and watch their cells. */
static int release_mids(pl_skin *skin, pl_watch *watch, planish_error *error) {
    const planish_plan *plan = skin->plan;
    int32_t *element = pl_alloc(plan->work.n_elements, sizeof *element);
    int64_t n = 0;
    if (!element)
        return pl_fail_memory(error, "the elements to be watched");
    for (int64_t e = 0; e < plan->work.n_elements; e++)
        if (has_placed(skin, e))
            element[n++] = (int32_t)e;
    int status = pl_mids_release(&watch->mids, error);
    if (!status)
        status = pl_watch_add(watch, n, element, error);
    pl_free(element);
    return status;
}

int pl_skin_create(planish_plan *plan, const planish_options *options, const double *coordinates,
                   pl_watch *watch, pl_skin *skin, planish_error *error) {
    *skin = (pl_skin){.plan = plan,
                      .shape = options->shape,
                      .coordinates = plan->scratch.coordinates,
                      .slide = plan->slide,
                      .n_stars = plan->sliding.stars.n_stars,
                      .threads = plan->threads,
                      .project = options->project,
                      .project_user = options->project_user,
                      .storage = pl_storage_of(options),
                      .mids = pl_watch_has_mids(watch) ? &watch->mids : NULL};
    if (skin->shape && skin->shape->whole && !skin->mids)
        return pl_fail(
            error, PLANISH_ERROR_ARGUMENT,
            "options.shape is of facets of second order, and the mesh has none; make the "
            "shape of this mesh");
    if (skin->shape) {
        pl_points points = pl_plan_all_points(plan, coordinates);
        points.n = options->shape->n_mesh;
        points.node_of =
            NULL; /* the shape has the caller's numbers, also where a plan is of a part */
        int status = pl_skin_make(options, skin, error);
        if (status)
            return status;
        number_nodes(skin);
        pl_skin_find_moves(skin, plan->slides_by);
        if (!find_followers(skin))
            return pl_fail_memory(error, "the surface of a mesh");
        status = pl_skin_begin(skin, &points, error);
        if (!status && skin->shape->whole)
            status = release_mids(skin, watch, error);
        if (status)
            return status;
    }
    set_slides(plan, skin);
    return PLANISH_OK;
}

/** Compute the unit normal of a facet; of [n_nodes]: numbers in given, NULL: where nodes are now. Returns 0
 *  if it has no area. */
static int normal_of(const pl_skin *skin, int32_t facet, const int32_t *of, const double *given,
                     double normal[3]) {
    double x[3][3], a[3], b[3];
    for (int j = 0; j < 3; j++) {
        const int32_t node = skin->shape->facet[facet][j];
        pl_skin_place_of(skin, node, x[j]);
        for (int d = 0; of && of[node] >= 0 && d < 3; d++)
            x[j][d] = given[3 * (int64_t)of[node] + d] * skin->shape->scale;
    }
    pl_from_to(3, x[0], x[1], a);
    pl_from_to(3, x[0], x[2], b);
    pl_cross(a, b, normal);
    return pl_unit(3, normal, normal);
}

/** Whether a node of a facet, of second order one of its corners, is not where it was given. */
static int is_elsewhere(const pl_skin *skin, int32_t facet, const int32_t *of,
                        const double *given) {
    int any = 0, n;
    const int32_t *corner = pl_shape_corners(skin->shape, facet, &n);
    for (int j = 0; j < n; j++) {
        const int32_t node = corner[j];
        any |=
            of[node] >= 0 && !pl_skin_is_at(pl_skin_at(skin, node), given + 3 * (int64_t)of[node]);
    }
    return any;
}

/** Whether the smooth edge between two facets bends too much, and did not so where the nodes were given. */
static int is_bent(const pl_skin *skin, int32_t t, int32_t other, const int32_t *of,
                   const double *given) {
    double a[3], b[3];
    if (!normal_of(skin, t, NULL, given, a) || !normal_of(skin, other, NULL, given, b))
        return 1;
    const double now = pl_dot(3, a, b);
    return now < PL_SKIN_BEND && !(normal_of(skin, t, of, given, a) &&
                                   normal_of(skin, other, of, given, b) && now >= pl_dot(3, a, b));
}

/** Take for too far off the facets that have moved at such edges. Returns how many edges there are. */
static int64_t mark_bent(pl_skin *skin, const int32_t *of, const double *given) {
    int64_t n = 0;
    for (int32_t t = 0; t < skin->shape->n_facets; t++)
        for (int k = 0; k < 3; k++) {
            const int32_t other = skin->shape->across[t][k];
            const int has_gone = is_elsewhere(skin, t, of, given);
            const int other_has = other > t && is_elsewhere(skin, other, of, given);
            if (other < t || !(has_gone || other_has) || !is_bent(skin, t, other, of, given))
                continue;
            skin->bound[t] = has_gone ? INFINITY : skin->bound[t];
            skin->bound[other] = other_has ? INFINITY : skin->bound[other];
            n++;
        }
    return n;
}

/** Number the nodes of the skin by given; NULL: there is no memory. */
static int32_t *number_given(const pl_skin *skin) {
    const planish_plan *plan = skin->plan;
    int32_t *of = pl_alloc(skin->shape->n_nodes, sizeof *of);
    if (!of)
        return NULL;
    memset(of, -1, (size_t)skin->shape->n_nodes * sizeof *of);
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t node = skin->shape->number[pl_plan_node(plan, i)];
        if (node >= 0)
            of[node] = (int32_t)i;
    }
    return of;
}

int64_t pl_skin_check_bends(pl_skin *skin, const double *given) {
    if (!skin->shape)
        return 0;
    int32_t *of = number_given(skin);
    const int64_t n = of ? mark_bent(skin, of, given) : 1;
    pl_free(of);
    return n;
}

int64_t pl_skin_put_back(pl_skin *skin, const double *given) {
    const planish_plan *plan = skin->plan;
    int64_t n = 0;
    if (!skin->shape || pl_skin_check(skin) + pl_skin_check_bends(skin, given) == 0)
        return 0;
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t node = skin->shape->number[pl_plan_node(plan, i)];
        double *x = plan->scratch.coordinates + (int64_t)plan->inner[i] * 3;
        if (node < 0 || pl_skin_is_at(x, given + 3 * i) || !pl_skin_is_off(skin, node))
            continue;
        memcpy(x, given + 3 * i, 3 * sizeof *x);
        n++;
    }
    pl_skin_follow(skin); /* mids go back with them */
    return n;
}
