/* fuzz_options: the options that bytes decide on: most as they are by default, some of any value.
 */
#ifndef FUZZ_OPTIONS_H
#define FUZZ_OPTIONS_H

#include "fuzz_mesh.h"

enum { FUZZ_ENOUGH_SWEEPS = 12 };

/** What callbacks are given. */
typedef struct fuzz_user {
    int64_t calls_left; /* of progress, until it says stop */
    int64_t permitted;  /* allocations that succeed; negative: all */
    int64_t n_held;     /* blocks that have not been released */
    planish_allocator allocator;
} fuzz_user;

static int fuzz_progress(const planish_progress *progress, void *user) {
    fuzz_user *u = user;
    fuzz_require(progress->sweep > 0 && progress->colour <= progress->n_colours,
                 "progress is within bounds");
    return u->calls_left-- == 0;
}

static void *fuzz_allocate(size_t bytes, void *user) {
    fuzz_user *u = user;
    if (__atomic_fetch_sub(&u->permitted, 1, __ATOMIC_RELAXED) == 0)
        return NULL;
    __atomic_fetch_add(&u->n_held, 1, __ATOMIC_RELAXED);
    return malloc(bytes);
}

static void fuzz_release(void *block, void *user) {
    fuzz_user *u = user;
    fuzz_require(block != NULL, "NULL is not released");
    __atomic_fetch_sub(&u->n_held, 1, __ATOMIC_RELAXED);
    free(block);
}

/** The last task first, all on one thread. */
static void fuzz_parallel(int n_tasks, planish_task_fn *task, void *data, void *user) {
    (void)user;
    for (int i = n_tasks - 1; i >= 0; i--)
        task(data, i);
}

/** The plane z = 0 (y = 0) of nodes of even number, circles of others; some may not move. */
static planish_constraint fuzz_project(int64_t node, double *point, double *direction, void *user) {
    const int last = *(const int *)user - 1;
    direction[0] = direction[1] = direction[last] = 0;
    if (node % 8 == 7)
        return PLANISH_CONSTRAINT_FIXED;
    if (node % 2) {
        const double length = hypot(point[0], point[1]);
        direction[0] = point[0];
        direction[1] = point[1];
        point[0] /= length;
        point[1] /= length;
        return PLANISH_CONSTRAINT_ON_PLANE;
    }
    point[last] = 0;
    direction[node % 4 ? 0 : last] = 1;
    return node % 4 ? PLANISH_CONSTRAINT_ON_LINE : PLANISH_CONSTRAINT_ON_PLANE;
}

/** To 1/1024 as long as that makes a difference. */
static double fuzz_round(double value, void *user) {
    (void)user;
    return fabs(value) < 0x1p40 ? nearbyint(value * 1024) / 1024 : value;
}

static void fuzz_log(planish_log_level level, const char *text, void *user) {
    (void)user;
    fuzz_require(level >= PLANISH_LOG_NOTE && level <= PLANISH_LOG_DETAIL && text[0] &&
                     !strchr(text, '\n'),
                 "the log is lines");
}

/* ---- parts of the options ------------------------------------------------------------------- */

static inline void fuzz_choose(fuzz_bytes *bytes, planish_options *o) {
    o->method = take_chance(bytes, 4) ? (planish_method)take_below(bytes, 5) : o->method;
    o->objective = (planish_objective)(take_below(bytes, 4) % 3);
    o->worst = take_chance(bytes, 4) ? (planish_worst)take_below(bytes, 3) : o->worst;
    o->search = (planish_search)(take_below(bytes, 3) / 2);
    o->precision = (planish_precision)(take_below(bytes, 8) % 3);
    if (!take_chance(bytes, 16))
        o->round = fuzz_round;
    o->untangle = !take_chance(bytes, 4);
}

static inline void fuzz_bound(fuzz_bytes *bytes, fuzz_mesh *m, planish_options *o) {
    const planish_mesh *mesh = &m->mesh;
    const int64_t n = mesh->n_nodes * mesh->dim;
    double *lower = fuzz_block(m, n, sizeof *lower), *upper = fuzz_block(m, n, sizeof *upper);
    for (int64_t i = 0; i < n; i++) { /* strides may mean nothing */
        const int64_t at = fuzz_at(mesh, i / mesh->dim, (int)(i % mesh->dim));
        const double x = at >= 0 && at < m->n_coordinates ? mesh->coordinates[at] : 0;
        lower[i] = x - take_below(bytes, 16) / 16.0;
        upper[i] = x + take_below(bytes, 16) / 16.0;
    }
    double *changed = take_below(bytes, 2) ? lower : upper;
    if (n > 0 && take_chance(bytes, 4))
        take_change(bytes, changed, n);
    o->lower = take_chance(bytes, 4) ? NULL : lower;
    o->upper = take_chance(bytes, 4) ? NULL : upper;
}

static inline void fuzz_limit(fuzz_bytes *bytes, planish_options *o) {
    for (int d = 0; d < 3; d++) {
        if (take_chance(bytes, 4))
            o->box_lower[d] = take_real(bytes);
        if (take_chance(bytes, 4))
            o->box_upper[d] = take_real(bytes);
    }
    if (take_chance(bytes, 3))
        o->max_displacement = take_real(bytes);
    o->displacement_unit = (planish_length_unit)(take_below(bytes, 16) / 7);
}

static inline void fuzz_ask(fuzz_bytes *bytes, planish_options *o) {
    const int what = take_byte(bytes);
    if (what & 1)
        o->min_volume = take_real(bytes);
    if ((what & 6) == 6)
        o->min_volume_fraction = take_real(bytes) / 1000;
    if (what & 8)
        o->area_weight = take_below(bytes, 65) / 64.0;
    if ((what & 48) == 48)
        o->only_worse_than = 1 + fabs(take_real(bytes));
    if (what & 64)
        o->rings = take_below(bytes, 5);
}

static inline void fuzz_stop(fuzz_bytes *bytes, planish_options *o) {
    o->max_sweeps = take_chance(bytes, 3) ? take_below(bytes, 8) : FUZZ_ENOUGH_SWEEPS;
    if (take_chance(bytes, 4))
        o->tolerance = take_real(bytes);
    if (take_chance(bytes, 8))
        o->worst_rise = take_real(bytes);
}

/** Nodes, and an element of each perhaps; some that are not there. */
static inline void fuzz_look_around(fuzz_bytes *bytes, fuzz_mesh *m, planish_options *o) {
    const int n = 1 + take_below(bytes, 8);
    int64_t *nodes = fuzz_block(m, n, sizeof *nodes), *elements = fuzz_block(m, n, sizeof *nodes);
    for (int i = 0; i < n; i++) {
        elements[i] = take_integer(bytes);
        const int64_t e = elements[i], k = take_below(bytes, m->mesh.dim + 1);
        const int known = m->mesh.elements && e >= 0 && e < m->mesh.n_elements;
        nodes[i] = known ? m->mesh.elements[e * (m->mesh.dim + 1) + k] : take_integer(bytes);
    }
    o->n_around = n;
    o->around = nodes;
    o->around_elements = take_below(bytes, 2) ? elements : NULL;
}

/** A number or two of any value. */
static inline void fuzz_garble(fuzz_bytes *bytes, planish_options *o) {
    switch (take_below(bytes, 12)) {
    case 0:
        o->threads = -1 - take_below(bytes, 2) * 2000000000;
        break;
    case 1:
        o->isa = (planish_isa)take_integer(bytes);
        break;
    case 2:
        o->method = (planish_method)take_integer(bytes);
        break;
    case 3:
        o->objective = (planish_objective)take_integer(bytes);
        break;
    case 4:
        o->worst = (planish_worst)take_integer(bytes);
        break;
    case 5:
        o->rings = (int)take_integer(bytes);
        break;
    case 6:
        o->max_sweeps = -1;
        break;
    case 7:
        o->time_limit = take_finite(bytes) > 0 ? NAN : -1;
        break;
    case 8:
        o->struct_size = (size_t)take_integer(bytes);
        break;
    case 9:
        o->only_worse_than = take_real(bytes);
        break;
    case 10:
        o->area_weight = take_real(bytes);
        break;
    default:
        o->n_around = take_integer(bytes) % 2 - 1;
    }
}

static inline void fuzz_options_make(fuzz_bytes *bytes, fuzz_mesh *m, fuzz_user *user,
                                     planish_options *o) {
    planish_options_init(o);
    o->threads = 1;
    *user = (fuzz_user){.calls_left = -1, .permitted = -1};
    user->allocator = (planish_allocator){fuzz_allocate, fuzz_release, user};
    const int what = take_byte(bytes);
    fuzz_stop(bytes, o);
    if (what & 1)
        fuzz_choose(bytes, o);
    if ((what & 6) == 6)
        fuzz_bound(bytes, m, o);
    if ((what & 10) == 10)
        fuzz_limit(bytes, o);
    if (what & 16)
        fuzz_ask(bytes, o);
    if ((what & 96) == 96)
        fuzz_look_around(bytes, m, o);
    const int calls = take_byte(bytes);
    o->threads = 1 + calls % 3 % 2 * 2;
    if (calls & 4)
        o->parallel = fuzz_parallel;
    if (calls & 8)
        o->log = fuzz_log;
    if (!(calls & 16)) {
        o->project = fuzz_project;
        o->project_user = &m->mesh.dim;
    }
    if ((calls & 96) == 96) {
        o->progress = fuzz_progress;
        o->progress_user = user;
        user->calls_left = take_byte(bytes);
    }
    if (calls & 128) {
        o->allocator = &user->allocator;
        user->permitted = take_chance(bytes, 3) ? take_byte(bytes) : -1;
    }
    if (what == 128)
        fuzz_garble(bytes, o);
}

#endif
