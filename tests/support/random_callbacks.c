/* random_callbacks: the caller's side of random calls: memory, threads, rounding, surfaces. */
#include "support/random_calls.h"

#include "support/effort.h"

#include <math.h>
#include <stdlib.h>

static void *allocate(size_t bytes, void *user) {
    random_heap *h = user;
    if (__atomic_fetch_add(&h->calls, 1, __ATOMIC_RELAXED) == h->failing)
        return NULL;
    char *block = malloc(bytes + 16);
    if (block)
        __atomic_fetch_add(&h->live, 1, __ATOMIC_RELAXED);
    return block ? block + 16 : NULL;
}

static void release(void *block, void *user) {
    random_heap *h = user;
    __atomic_fetch_sub(&h->live, 1, __ATOMIC_RELAXED);
    free((char *)block - 16);
}

/** Tasks one after the other, the last one first. */
static void backwards(int n_tasks, planish_task_fn *task, void *data, void *user) {
    (void)user;
    for (int i = n_tasks - 1; i >= 0; i--)
        task(data, i);
}

static void count_lines(planish_log_level level, const char *text, void *user) {
    int64_t *n = user;
    *n += level >= PLANISH_LOG_NOTE && text[0] != '\0';
}

static double to_quanta(double value, void *user) {
    const double quantum = *(const double *)user;
    return rint(value / quantum) * quantum;
}

int random_call_progress(const planish_progress *p, void *user) {
    random_watch *w = user;
    planish_quality quality;
    w->is_wrong |= w->has_stopped && !p->sweep_done; /* only the last call of the sweep is left */
    w->is_wrong |= p->sweep < w->sweep || p->sweep > w->sweep + 1 || p->colour < 0 ||
                   p->colour > p->n_colours || p->n_inverted < 0 || p->n_below_min_volume < 0 ||
                   !(p->seconds >= 0) || !(p->elapsed >= 0);
    w->sweep = p->sweep;
    if (w->coordinates)
        w->is_wrong |= planish_measure(w->plan, w->coordinates, &quality, NULL) != PLANISH_OK;
    if (w->calls++ != w->stop_at)
        return 0;
    w->has_stopped = 1;
    return 1;
}

static double radius_of(const random_surface *s, const double *x, double *way) {
    double square = 0;
    for (int d = 0; d < s->dim; d++) {
        way[d] = x[d] - s->centre[d];
        square += way[d] * way[d];
    }
    return sqrt(square);
}

static planish_constraint project(int64_t node, double *point, double *direction, void *user) {
    enum { EVERY = 7 }; /* node of this must not be anywhere */
    const random_surface *s = user;
    double way[3];
    const double wanted = radius_of(s, s->start + node * s->dim, way);
    const double radius = radius_of(s, point, way);
    if (!(wanted > 0) || !(radius > 0) || node % EVERY == 0)
        return PLANISH_CONSTRAINT_FIXED;
    for (int d = 0; d < s->dim; d++) {
        direction[d] = way[d] / radius;
        point[d] = s->centre[d] + direction[d] * wanted;
    }
    return PLANISH_CONSTRAINT_ON_PLANE;
}

double random_surface_distance(const random_surface *s, int64_t node, const double *x) {
    double way[3];
    return fabs(radius_of(s, x, way) - radius_of(s, s->start + node * s->dim, way));
}

void random_call_rewind(random_call *call) {
    call->watch.calls = 0;
    call->watch.sweep = 0;
    call->watch.has_stopped = 0;
}

void random_callbacks_draw(random_call *call, uint64_t *state) {
    const int *l = call->level;
    planish_options *o = &call->options;
    call->surface = (random_surface){.dim = call->dense.dim, .start = call->mesh.base.coordinates};
    for (int d = 0; d < call->dense.dim; d++)
        call->surface.centre[d] = call->surface.start[d] + call->mesh.size * random_unit(state);
    call->heap.failing = l[OF_ALLOCATOR] == ALLOCATOR_FAILING ? random_below(state, 150) : -1;
    call->allocator = (planish_allocator){allocate, release, &call->heap};
    call->watch.stop_at = l[OF_PROGRESS] == PROGRESS_STOP ? random_below(state, 60) : -1;
    if (l[OF_PROGRESS] != PROGRESS_NONE)
        o->progress = random_call_progress;
    o->progress_user = &call->watch;
    if (l[OF_PROJECT])
        o->project = project;
    o->project_user = &call->surface;
    if (l[OF_ALLOCATOR] != ALLOCATOR_SYSTEM)
        o->allocator = &call->allocator;
    if (l[OF_PARALLEL])
        o->parallel = backwards;
    o->round = o->precision == PLANISH_PRECISION_ROUNDED ? to_quanta : NULL;
    o->round_user = &call->quantum;
    if (l[OF_LOG])
        o->log = count_lines;
    o->log_user = &call->logged;
}
