/* planish_plan: make a plan, destroy it, and tell its figures. */
#include "plan/plan.h"

#include "base/status.h"
#include "plan/make.h"
#include "shape/curved.h"

#include <inttypes.h>
#include <string.h>

static void say_plan(const planish_plan *plan) {
    planish_plan_info info;
    planish_plan_get_info(plan, &info);
    pl_log(PLANISH_LOG_DETAIL,
           "%" PRId64 " of %" PRId64 " nodes may move, %" PRId64
           " of them slide; %d colours; %d %s, "
           "%s; kernels %s; %.3g MB",
           info.n_free + info.n_sliding, plan->whole.n_nodes, info.n_sliding, info.n_colours,
           info.threads, info.threads == 1 ? "thread" : "threads", info.binding, info.isa,
           (double)info.bytes * 1e-6);
    if (info.n_nonmanifold_facets > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " facets belong to more than two elements: their nodes stay",
               info.n_nonmanifold_facets);
    if (info.n_duplicate_elements > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " elements have the nodes of an earlier one: these stay",
               info.n_duplicate_elements);
    if (info.n_wrapped > 0)
        pl_log(PLANISH_LOG_NOTE,
               "%" PRId64 " elements wrap around a periodic domain, from one side to the other: "
               "their nodes stay",
               info.n_wrapped);
}

/** Check options->shape against the mesh whose surface it is to be. */
static int check_shape(const planish_mesh *mesh, const planish_options *options,
                       planish_error *error) {
    const planish_shape *shape = options->shape;
    if (!shape)
        return PLANISH_OK;
    if (mesh->part)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "options.shape is not possible with a mesh in parts; do without it, or in "
                       "one process");
    if (mesh->dim != 3)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.shape is for meshes in space, but mesh.dim is %d", mesh->dim);
    if (shape->n_mesh != mesh->n_nodes)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.shape was made of a mesh of %" PRId64 " nodes, but this one has "
                       "%" PRId64 "; make the shape of this mesh",
                       shape->n_mesh, mesh->n_nodes);
    return PLANISH_OK;
}

/** Check the options that say which nodes the plan is for. */
static int check_neighbourhood(const planish_options *options, planish_error *error) {
    if (options->n_around != 0 && !options->around)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.n_around is %" PRId64
                       ", but options.around is NULL; give the nodes",
                       options->n_around);
    return PLANISH_OK;
}

static int create_plan(const planish_mesh *mesh, const planish_options *options, planish_plan **out,
                       planish_error *error) {
    int status = pl_options_check(options, error);
    if (!status)
        status = check_neighbourhood(options, error);
    if (status)
        return status;
    if (!pl_star_kernel_select(options->isa))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "options.isa %d is not a kernel that this CPU can run; use "
                       "PLANISH_ISA_AUTO",
                       (int)options->isa);
    status = pl_check_counts(mesh, error);
    if (!status)
        status = check_shape(mesh, options, error);
    if (status)
        return status;
    pl_context *context = pl_context_create(options);
    if (!context)
        return pl_fail_memory(error, "a plan");
    context->part = mesh->part;
    pl_context *before = pl_context_enter(context);
    planish_plan *plan = pl_plan_make(mesh, options, context, &status, error);
    if (plan)
        say_plan(plan);
    pl_context_enter(before);
    if (!plan) {
        pl_context_destroy(context);
        return status;
    }
    pl_context_keep_blocks(context);
    *out = plan;
    return PLANISH_OK;
}

int planish_plan_create(const planish_mesh *mesh, const planish_options *options,
                        planish_plan **out, planish_error *error) {
    planish_options defaults;
    if (out)
        *out = NULL;
    if (!mesh || !out)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "mesh and plan must not be NULL");
    planish_options_init(&defaults);
    const pl_outside outside = pl_call_enter(NULL);
    const int status = create_plan(mesh, options ? options : &defaults, out, error);
    pl_call_leave(&outside);
    return status;
}

void planish_plan_destroy(planish_plan *plan) {
    if (!plan)
        return;
    const pl_outside outside = pl_call_enter(NULL);
    pl_context *context = plan->context;
    pl_forget_kept(context);
    pl_plan_destroy(plan);
    pl_context_destroy(context);
    pl_call_leave(&outside);
}

void planish_plan_get_free(const planish_plan *plan, uint8_t *is_free) {
    if (!plan || !is_free)
        return;
    if (plan->scope != PL_ALL)
        memset(is_free, 0, (size_t)plan->whole.n_nodes);
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        is_free[pl_plan_node(plan, i)] = plan->work.mobility[i] == PL_INTERIOR;
}

void planish_find_wrapped(const planish_plan *plan, uint8_t *wrapped, int64_t *n) {
    if (n)
        *n = plan ? plan->n_wrapped : 0;
    if (!plan || !wrapped)
        return;
    memset(wrapped, 0, (size_t)pl_plan_given(plan));
    for (int64_t i = 0; i < plan->n_wrapped; i++)
        wrapped[pl_plan_element(plan, plan->wrapped[i])] = 1;
}

void planish_plan_get_info(const planish_plan *plan, planish_plan_info *info) {
    if (!info)
        return;
    *info = plan ? plan->info : (planish_plan_info){0};
    if (plan)
        info->bytes = __atomic_load_n(&plan->context->bytes, __ATOMIC_RELAXED);
}
