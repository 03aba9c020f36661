/* promise_known: what can be said before a call of planish_smooth: which nodes may move, which
 * order of the elements is the positive one, what is refused. */
#include "support/promises.h"

#include "support/facets.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* RR is above a limit beyond doubt by this. */
#define BEYOND_DOUBT 1e-9L

static void *checked(void *memory) {
    if (!memory)
        abort();
    return memory;
}

int promise_break(promise *p, const char *format, ...) {
    va_list arguments;
    if (p->text[0])
        return 0;
    va_start(arguments, format);
    vsnprintf(p->text, sizeof p->text, format, arguments);
    va_end(arguments);
    return 0;
}

/* ---- which nodes may move ------------------------------------------------------------------ */

/** Nodes of elements that are bad for options.only_worse_than, beyond rounding or nearly. */
static void select_bad(const promise *p, const double *x, uint8_t *selected) {
    const planish_options *o = &p->call->plan_options;
    const planish_mesh *mesh = &p->call->dense;
    const int corners = mesh->dim + 1;
    const worth_problem problem = {.mesh = mesh, .sign = p->sign, .min_volume = o->min_volume};
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const real ratio = worth_ratio(&problem, x, i);
        const int bad = !(ratio > 0) || ratio > o->only_worse_than * (1 - BEYOND_DOUBT) ||
                        worth_least(&problem, i) > 0 || o->min_volume_fraction > 0;
        for (int j = 0; bad && j < corners; j++)
            selected[mesh->elements[i * corners + j]] = 1;
    }
}

/** The nodes of so many rings of elements around, and their partners. */
static void spread(const planish_mesh *mesh, int rings, uint8_t *selected) {
    const int corners = mesh->dim + 1;
    for (int k = 0; k < rings; k++) {
        uint8_t *before = checked(malloc((size_t)mesh->n_nodes + 1));
        memcpy(before, selected, (size_t)mesh->n_nodes);
        for (int64_t i = 0; i < mesh->n_elements; i++) {
            int has = 0;
            for (int j = 0; j < corners; j++)
                has |= before[mesh->elements[i * corners + j]];
            for (int j = 0; has && j < corners; j++)
                selected[mesh->elements[i * corners + j]] = 1;
        }
        free(before);
    }
    for (int64_t k = 0; k < 8; k++)
        for (int64_t i = 0; i < mesh->n_periodic; i++) {
            uint8_t *a = &selected[mesh->periodic[2 * i]],
                    *b = &selected[mesh->periodic[2 * i + 1]];
            *a = *b = *a | *b;
        }
}

/** selected [n_nodes]: 1 for what the plan may work on. */
static void select_nodes(const promise *p, const double *x, uint8_t *selected) {
    enum { AROUND_TANGLES = 4 };
    const planish_options *o = &p->call->plan_options;
    const int64_t n = p->call->dense.n_nodes;
    if (o->around) {
        for (int64_t i = 0; i < o->n_around; i++)
            selected[o->around[i]] = 1;
        spread(&p->call->dense, o->rings, selected);
    } else if (o->only_worse_than > 0) {
        const worth_problem problem = {
            .mesh = &p->call->dense, .sign = p->sign, .is_movable = selected, .moves = selected};
        const int tangled = worth_of(&problem, x).inverted > 0;
        select_bad(p, x, selected);
        spread(&p->call->dense, tangled && o->rings < AROUND_TANGLES ? AROUND_TANGLES : o->rings,
               selected);
    } else {
        memset(selected, 1, (size_t)n);
    }
}

/** Whether the plan knows only those elements of a node that are joined to a given one there. */
static int walks(const random_call *call) {
    return call->plan_options.around_elements &&
           (call->given.neighbours || call->given.neighbours64);
}

static void find_movable(promise *p, const double *x) {
    const planish_mesh *mesh = &p->call->dense;
    const planish_options *o = &p->call->options;
    uint8_t *inside = checked(malloc((size_t)mesh->n_nodes + 1));
    uint8_t *selected = checked(calloc((size_t)mesh->n_nodes + 1, 1));
    test_inside(mesh, walks(p->call) ? p->is_known : NULL, inside);
    select_nodes(p, x, selected);
    for (int64_t i = 0; i < mesh->n_periodic * 2; i++)
        inside[mesh->periodic[i]] = 0; /* these slide or stay */
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        const int kind = mesh->constraint ? mesh->constraint[i] : PLANISH_CONSTRAINT_FREE;
        const int slides = kind == PLANISH_CONSTRAINT_ON_PLANE ||
                           kind == PLANISH_CONSTRAINT_ON_LINE ||
                           (kind == PLANISH_CONSTRAINT_ON_SURFACE && o->project);
        p->may_move[i] = selected[i] && (slides || (kind == PLANISH_CONSTRAINT_FREE && inside[i]));
        if (p->is_free[i] && (kind != PLANISH_CONSTRAINT_FREE || !p->may_move[i]))
            promise_break(p, "node %lld is free, but must not be", (long long)i);
    }
    free(inside);
    free(selected);
}

/* ---- what is known ------------------------------------------------------------------------- */

/** The one order of the file's that all known elements are positive in: +1 or -1; 0: there is none.
 */
static int common_order(const promise *p, const double *x) {
    const planish_mesh *mesh = &p->call->dense;
    int64_t positive = 0, negative = 0, n = 0;
    int8_t *sign = checked(malloc((size_t)mesh->n_elements + 1));
    const worth_problem problem = {.mesh = mesh, .sign = sign};
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        n += p->is_known[i];
        sign[i] = 1;
        positive += p->is_known[i] && worth_is_positive(&problem, x, i);
        sign[i] = -1;
        negative += p->is_known[i] && worth_is_positive(&problem, x, i);
    }
    free(sign);
    return positive == n ? 1 : negative == n ? -1 : 0;
}

/** What the plan knows of, and the signs of these elements. Where the plan is for some nodes, and
 *  measures agree, facets are not asked. */
static void find_known(promise *p, const double *x) {
    const planish_mesh *mesh = &p->call->dense;
    const planish_options *o = &p->call->plan_options;
    double *ratio = checked(malloc((size_t)mesh->n_elements * sizeof *ratio + 1));
    if (planish_measure_elements(p->plan, p->call->coordinates, ratio, NULL))
        promise_break(p, "planish_measure_elements failed");
    for (int64_t i = 0; i < mesh->n_elements; i++)
        p->is_known[i] = (uint8_t)!isnan(ratio[i]);
    p->n_doubtful = test_orient(mesh, x, p->is_known, p->sign);
    const int order = o->around || o->only_worse_than > 0 ? common_order(p, x) : 0;
    const worth_problem problem = {.mesh = mesh, .sign = p->sign};
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        if (!p->is_known[i] || worth_is_positive(&problem, x, i) == (ratio[i] > 0))
            continue;
        p->sign[i] = (int8_t)(order ? order : -p->sign[i]);
        if (p->n_doubtful == 0 &&
            (order == 0 || worth_is_positive(&problem, x, i) != (ratio[i] > 0)))
            promise_break(p, "element %lld has RR %g", (long long)i, ratio[i]);
    }
    free(ratio);
}

void promise_create(promise *p, const random_call *call, const planish_plan *plan,
                    const double *coordinates) {
    const size_t n = (size_t)call->dense.n_nodes + 1, m = (size_t)call->dense.n_elements + 1;
    *p = (promise){.call = call, .plan = plan};
    p->sign = checked(malloc(m));
    p->is_known = checked(malloc(m));
    p->is_free = checked(malloc(n));
    p->may_move = checked(malloc(n));
    planish_plan_get_info(plan, &p->info);
    planish_plan_get_free(plan, p->is_free);
    find_known(p, coordinates);
    find_movable(p, coordinates);
}

void promise_destroy(promise *p) {
    free(p->sign);
    free(p->is_known);
    free(p->is_free);
    free(p->may_move);
}

/* ---- what is refused ----------------------------------------------------------------------- */

int promise_refusal(const random_call *call) {
    const planish_options *o = &call->options, *of_plan = &call->plan_options;
    const double *own = call->dense.min_volume;
    int all = o->min_volume > 0 || o->min_volume_fraction > 0;
    if (o->worst != PLANISH_WORST_NONE && o->method != PLANISH_METHOD_PLANISH)
        return 1;
    if (o->around && (of_plan->only_worse_than > 0 || o->min_volume_fraction > 0))
        return 1;
    if (!all && own) {
        all = 1;
        for (int64_t i = 0; i < call->dense.n_elements; i++)
            all &= own[i] > 0;
    }
    if (o->area_weight > 0 && !all)
        return o->around ? -1 : 1; /* of the elements around */
    /* Fractions of no domain, weights of volumes that differ by orders of magnitude; floats far
       from the origin may leave nothing of a mesh. */
    const int *l = call->level;
    const int may_be_nothing =
        l[OF_TANGLE] != RANDOM_VALID || l[OF_SHAPE] == RANDOM_GARBAGE ||
        (l[OF_PLACE] == RANDOM_FAR && l[OF_PRECISION] == PLANISH_PRECISION_FLOAT);
    return may_be_nothing ? -1 : 0;
}
