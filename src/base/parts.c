/* parts: what is asked of the other processes. */
#include "base/parts.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { MOST_AT_ONCE = 64 };

const planish_part *pl_part_here(void) {
    const pl_context *context = pl_context_current();
    return context ? context->part : NULL;
}

/* ---- functions of the caller's ------------------------------------------------------------- */

/** Begin to ask the others. Nothing is asked any more once they were not reached: the call ends
 *  soon, and says so. */
static pl_context *begin_asking(void) {
    pl_context *context = pl_context_current();
    if (!context || !context->part || context->unreached)
        return NULL;
    pl_context_enter(NULL);
    return context;
}

static void end_asking(pl_context *context, int failed) {
    context->unreached |= failed != 0;
    pl_context_enter(context);
}

void pl_parts_add(int64_t *values, int n) {
    pl_context *context = begin_asking();
    if (context)
        end_asking(context, context->part->add(values, n, context->part->user));
}

static void largest(int64_t *values, int n) {
    pl_context *context = begin_asking();
    if (context)
        end_asking(context, context->part->largest(values, n, context->part->user));
}

/* ---- sums and extremes ---------------------------------------------------------------------- */

enum { INTEGERS = sizeof(pl_sum) / sizeof(int64_t) };

void pl_parts_add_sums(pl_sum *sums, int n) {
    if (!pl_part_here())
        return;
    for (int i = 0; i < n; i++)
        pl_sum_carry(&sums[i]);
    pl_parts_add((int64_t *)sums, n * INTEGERS);
}

/** Map bits to integers ordered as the doubles are, and the way back (it is its own inverse but for
 * the types).
 */
static int64_t order_of(int64_t bits) {
    return bits ^ (bits < 0 ? INT64_MAX : 0);
}

static void extreme(double *values, int n, int sign) {
    int64_t order[MOST_AT_ONCE];
    if (!pl_part_here())
        return;
    for (int i = 0; i < n; i++) {
        const double value = sign * values[i];
        memcpy(&order[i], &value, sizeof value);
        order[i] = order_of(order[i]);
    }
    largest(order, n);
    for (int i = 0; i < n; i++) {
        const int64_t bits = order_of(order[i]);
        memcpy(&values[i], &bits, sizeof bits);
        values[i] *= sign;
    }
}

void pl_parts_smallest_integers(int64_t *values, int n) {
    for (int i = 0; i < n; i++)
        values[i] = -values[i];
    largest(values, n);
    for (int i = 0; i < n; i++)
        values[i] = -values[i];
}

void pl_parts_largest(double *values, int n) {
    extreme(values, n, 1);
}

void pl_parts_smallest(double *values, int n) {
    extreme(values, n, -1);
}

int pl_parts_any(int value) {
    int64_t any = value != 0;
    largest(&any, 1);
    return any != 0 && !(pl_part_here() && pl_context_current()->unreached);
}

/* ---- ghosts -------------------------------------------------------------------------------- */

int pl_parts_begin(int64_t n_nodes, planish_error *error) {
    pl_context *context = pl_context_current();
    const planish_part *part = context->part;
    int64_t n = 0;
    for (int64_t i = 0; part && i < n_nodes; i++)
        n += part->node_role[i] == PLANISH_ROLE_SHARED;
    if (!part)
        return PLANISH_OK;
    context->shared = pl_alloc(n, sizeof *context->shared);
    context->shared_values = pl_alloc(n, PL_LARGEST_VALUE);
    if (!context->shared || !context->shared_values)
        return pl_fail_memory(error, "the shared nodes");
    for (int64_t i = 0; i < n_nodes; i++)
        if (part->node_role[i] == PLANISH_ROLE_SHARED)
            context->shared[context->n_shared++] = (int32_t)i;
    return PLANISH_OK;
}

void pl_parts_end(pl_context *context) {
    pl_free(context->shared);
    pl_free(context->shared_values);
    context->shared = NULL;
    context->shared_values = NULL;
    context->n_shared = 0;
}

int64_t pl_parts_ghosts(int64_t n_nodes) {
    const planish_part *part = pl_part_here();
    int64_t n = 0;
    for (int64_t i = 0; part && i < n_nodes; i++)
        n += part->node_role[i] == PLANISH_ROLE_GHOST;
    return n;
}

int pl_parts_check(planish_error *error) {
    if (!pl_part_here() || !pl_context_current()->unreached)
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_PROCESS,
                   "another process that has a part of the mesh was not reached");
}

/** Destination of the values of ghosts. */
typedef struct arrival {
    const int32_t *inner;
    char *values;
    int64_t size;
} arrival;

static int64_t place_of(const int32_t *inner, int32_t node) {
    return inner ? inner[node] : node;
}

/** Take the value of a ghost. */
static void take_value(int32_t ghost, const void *value, void *taker) {
    const arrival *a = taker;
    memcpy(a->values + place_of(a->inner, ghost) * a->size, value, (size_t)a->size);
}

void pl_parts_send(const int32_t *node, int64_t n, const void *values, int64_t size) {
    pl_context *context = begin_asking();
    if (context)
        end_asking(context, context->part->send(node, n, values, size, context->part->user));
}

void pl_parts_receive(planish_take_fn *taken, void *taker) {
    pl_context *context = begin_asking();
    if (context)
        end_asking(context, context->part->receive(taken, taker, context->part->user));
}

void pl_parts_update(const int32_t *inner, void *values, int64_t size) {
    arrival a = {inner, values, size};
    pl_context *context = pl_context_current();
    if (!pl_part_here())
        return;
    char *room = context->shared_values;
    for (int64_t i = 0; i < context->n_shared; i++)
        memcpy(room + i * size, a.values + place_of(inner, context->shared[i]) * size,
               (size_t)size);
    pl_parts_send(context->shared, context->n_shared, room, size);
    pl_parts_receive(take_value, &a);
}
