/* joint_create: which nodes can be in patches, and limits. */
#include "improve/joint_create.h"
#include "improve/joint_measures.h"
#include "improve/joint_patch.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"

#include <math.h>

/** Whether a sliding node can be in a patch: on a plane or line without bounds. */
static int may_slide(const pl_run *r, int64_t star) {
    return r->plan->slide[star].kind != PLANISH_CONSTRAINT_ON_SURFACE && !r->guard.star.lower &&
           !r->guard.star.upper && !r->guard.star.radius && !r->skin.shape;
}

/** Set star_of to the plan's stars of the nodes that can be in patches. */
static void number_stars(const pl_run *r, int32_t *star_of) {
    const planish_plan *plan = r->plan;
    for (int64_t i = 0; i < plan->work.n_nodes + plan->n_images; i++)
        star_of[i] = PL_JOINT_HELD;
    for (int64_t s = 0; s < plan->interior.stars.n_stars; s++)
        if (!pl_star_is_held(&r->guard.star, plan->interior.centre[s], plan->dim))
            star_of[plan->interior.centre[s]] = (int32_t)s;
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++)
        if (may_slide(r, s))
            star_of[plan->sliding.centre[s]] = (int32_t)(-2 - s);
    for (int64_t k = 0; k < plan->sliding.n_followers; k++)
        star_of[plan->sliding.follower[k].of] = PL_JOINT_HELD;
    for (int64_t i = 0; r->watch.floor && i < plan->work.n_nodes; i++)
        if (pl_watch_has(&r->watch, (int32_t)i))
            star_of[i] = PL_JOINT_HELD;
}

/** Set number to the numbers in the whole mesh of the plan's inner nodes; images come after all. */
static void number_nodes(const planish_plan *plan, int64_t *number) {
    const planish_part *part = pl_part_here();
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int64_t node = pl_plan_node(plan, i);
        number[plan->inner[i]] = part ? part->node_number[node] : node;
    }
    for (int64_t i = 0; i < plan->n_images; i++)
        number[plan->work.n_nodes + i] = INT32_MAX + i;
}

static int create_mesh(pl_run *r, pl_joint_mesh *mesh, planish_error *error) {
    const planish_plan *plan = r->plan;
    const int64_t n = plan->work.n_nodes + plan->n_images;
    *mesh = (pl_joint_mesh){.coordinates = plan->scratch.coordinates,
                            .star_of = pl_alloc(n, sizeof *mesh->star_of),
                            .number = pl_alloc(n, sizeof *mesh->number),
                            .moved = pl_alloc_zero(n, sizeof *mesh->moved),
                            .near = pl_alloc_zero(n, sizeof *mesh->near),
                            .stars = {&plan->interior.stars, &plan->sliding.stars},
                            .slide = plan->slide,
                            .problem = r->problem};
    if (!mesh->star_of || !mesh->number || !mesh->moved || !mesh->near)
        return pl_fail_memory(error, "the worst elements");
    number_stars(r, mesh->star_of);
    number_nodes(plan, mesh->number);
    return PLANISH_OK;
}

/** Whether nodes of stars can move, but not in patches. */
static int any_is_left(const pl_run *r, const pl_visits *visits, const int32_t *star_of) {
    int any = 0;
    for (int64_t s = 0; s < visits->stars.n_stars && !any; s++)
        any = star_of[visits->centre[s]] == PL_JOINT_HELD &&
              !pl_star_is_held(&r->guard.star, visits->centre[s], r->plan->dim);
    return any;
}

int pl_joint_create(pl_run *r, const pl_star_limits limits[2], pl_joint *joint,
                    planish_error *error) {
    const planish_plan *plan = r->plan;
    const pl_joint_measure other = pl_joint_measure_of(r, 1);
    const int of_angle = other == PL_JOINT_ANGLE || other == PL_JOINT_JACOBIAN;
    *joint = (pl_joint){.run = r, .largest_angle = INFINITY};
    const int status = create_mesh(r, &joint->mesh, error);
    joint->room = pl_alloc(plan->threads, sizeof *joint->room);
    if (status || !joint->room)
        return status ? status : pl_fail_memory(error, "the worst elements");
    for (int i = 0; i < 2; i++)
        joint->kept[i] =
            pl_joint_value_of_square(other, of_angle ? limits[i].acuteness : limits[i].rr2);
    joint->leaves_nodes = pl_parts_any(any_is_left(r, &plan->interior, joint->mesh.star_of) ||
                                       any_is_left(r, &plan->sliding, joint->mesh.star_of));
    if (pl_joint_measure_of(r, 0) == PL_JOINT_ANGLE)
        joint->largest_angle = pl_joint_find_largest_angle(r);
    return PLANISH_OK;
}

void pl_joint_destroy(pl_joint *joint) {
    pl_free(joint->mesh.star_of);
    pl_free(joint->mesh.number);
    pl_free(joint->mesh.moved);
    pl_free(joint->mesh.near);
    pl_free(joint->room);
}
