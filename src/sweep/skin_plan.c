/* skin_plan: the skin of a plan's mesh. */
#include "sweep/skin.h"

#include "base/memory.h"
#include "base/status.h"

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
        skin->moves[node] = leader >= 0 && skin->moves[leader] == PLANISH_CONSTRAINT_FIXED
                                ? PLANISH_CONSTRAINT_FIXED
                            : pl_skin_is_curved(skin, node) ? PL_SKIN_LOOSE
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
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int32_t node = shape->number[pl_plan_node(plan, i)];
        if (node < 0)
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

int pl_skin_create(planish_plan *plan, const planish_options *options, const double *coordinates,
                   pl_skin *skin, planish_error *error) {
    *skin = (pl_skin){.plan = plan,
                      .shape = options->shape,
                      .coordinates = plan->scratch.coordinates,
                      .slide = plan->slide,
                      .n_stars = plan->sliding.stars.n_stars,
                      .threads = plan->threads,
                      .project = options->project,
                      .project_user = options->project_user,
                      .storage = pl_storage_of(options)};
    if (skin->shape) {
        const pl_points points = pl_plan_all_points(plan, coordinates);
        int status = pl_skin_make(options, skin, error);
        if (status)
            return status;
        number_nodes(skin);
        pl_skin_find_moves(skin, plan->slides_by);
        if (!find_followers(skin))
            return pl_fail_memory(error, "the surface of a mesh");
        status = pl_skin_begin(skin, &points, error);
        if (status)
            return status;
    }
    set_slides(plan, skin);
    return PLANISH_OK;
}

int64_t pl_skin_put_back(pl_skin *skin, const double *given) {
    const planish_plan *plan = skin->plan;
    int64_t n = 0;
    if (pl_skin_check(skin) == 0)
        return 0;
    for (int64_t i = 0; skin->shape && i < plan->work.n_nodes; i++) {
        const int32_t node = skin->shape->number[pl_plan_node(plan, i)];
        double *x = plan->scratch.coordinates + (int64_t)plan->inner[i] * 3;
        if (node < 0 || pl_skin_is_at(x, given + 3 * i) || !pl_skin_is_off(skin, node))
            continue;
        memcpy(x, given + 3 * i, 3 * sizeof *x);
        n++;
    }
    return n;
}
