/* gather: stars of other processes' nodes. */
#include "improve/gather.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"
#include "quality/measure.h"

#include <string.h>

enum { PLACES_AT_LEAST = 1024, MOST_AT_ONCE = 1 << 24 };

/* ---- messages ------------------------------------------------------------------------------- */

/* Numbers of all processes are added up: each has 0 where another one has something to say. */

/** Whether this and all other processes can go on; is_fine: this one. */
static int all_are_fine(int is_fine) {
    return !pl_parts_any(!is_fine) && pl_parts_check(NULL) == PLANISH_OK;
}

/** Add values [n] up over the processes. */
static int add_up(int64_t *values, int64_t n) {
    for (int64_t i = 0; i < n; i += MOST_AT_ONCE)
        pl_parts_add(values + i, (int)(n - i < MOST_AT_ONCE ? n - i : MOST_AT_ONCE));
    return pl_parts_check(NULL) == PLANISH_OK;
}

/** Write a double at *to and step on. */
static void put(int64_t **to, double value) {
    memcpy((*to)++, &value, sizeof value);
}

/** Read what put has written. */
static double get(const int64_t **from) {
    double value;
    memcpy(&value, (*from)++, sizeof value);
    return value;
}

static void put_all(int64_t **to, const double *values, int n) {
    for (int i = 0; i < n; i++)
        put(to, values ? values[i] : 0);
}

static void get_all(const int64_t **from, double *values, int n) {
    for (int i = 0; i < n; i++)
        values[i] = get(from);
}

/* ---- nodes ---------------------------------------------------------------------------------- */

static int dim_of(const pl_gather *g) {
    return g->joint->run->plan->dim;
}

/** Place in the hash table where the node with a number is, or would be. */
static int64_t find_place(const pl_gather *g, int64_t number) {
    uint64_t hash = (uint64_t)number * 0x9E3779B97F4A7C15u;
    int64_t i = (int64_t)(hash >> 20) & (g->n_places - 1);
    while (g->place[i] >= 0 && g->joint->mesh.number[g->place[i]] != number)
        i = (i + 1) & (g->n_places - 1);
    return i;
}

/** Array that grows. */
typedef struct growing {
    void *array; /* a T **, */
    size_t size; /* of T */
    int64_t now, needed;
    int64_t *room; /* Ts that there is room for: of several such arrays */
} growing;

/** Make room in n arrays, not one of which has another room for the same needs. Return 0 without
 *  memory. */
static int grow_arrays(const growing *arrays, int n) {
    for (int k = 0; k < n; k++) {
        void *array;
        int64_t room = *arrays[k].room;
        memcpy(&array, arrays[k].array, sizeof array);
        array = pl_grow(array, arrays[k].now, arrays[k].needed, &room, arrays[k].size);
        if (!array)
            return 0;
        memcpy(arrays[k].array, &array, sizeof array);
        if (k == n - 1 || arrays[k + 1].room != arrays[k].room)
            *arrays[k].room = room;
    }
    return 1;
}

/** Let the views of the arrays be those that there are now. */
static void set_views(pl_gather *g) {
    pl_joint_mesh *m = &g->joint->mesh;
    const pl_star_guard *guard = g->local.problem.guard;
    m->stars[0] = m->stars[1] = &g->stars;
    m->slide = g->slide;
    m->problem = g->local.problem;
    if (!guard)
        return;
    g->guard = *guard;
    g->guard.lower = guard->lower ? g->lower : NULL;
    g->guard.upper = guard->upper ? g->upper : NULL;
    g->guard.start = guard->radius ? g->start : NULL;
    g->guard.radius = guard->radius ? g->radius : NULL;
    m->problem.guard = &g->guard;
}

/** Make room in the hash table for more nodes; return 0 without memory. */
static int reserve_places(pl_gather *g, int64_t more) {
    int64_t n = g->n_places;
    while (n < 2 * (g->n + more))
        n *= 2;
    if (n == g->n_places)
        return 1;
    int32_t *place = pl_alloc(n, sizeof *place);
    if (!place)
        return 0;
    pl_free(g->place);
    g->place = place;
    g->n_places = n;
    memset(place, -1, (size_t)n * sizeof *place);
    for (int64_t i = 0; i < g->n; i++)
        place[find_place(g, g->joint->mesh.number[i])] = (int32_t)i;
    return 1;
}

/** Make room for more nodes; return 0 without memory. */
static int reserve_nodes(pl_gather *g, int64_t more) {
    pl_joint_mesh *m = &g->joint->mesh;
    const size_t point = (size_t)dim_of(g) * sizeof(double);
    const int64_t n = g->n, needed = n + more;
    const growing arrays[] = {{&m->coordinates, point, n, needed, &g->room},
                              {&m->star_of, sizeof *m->star_of, n, needed, &g->room},
                              {&m->number, sizeof *m->number, n, needed, &g->room},
                              {&m->moved, sizeof *m->moved, n, needed, &g->room},
                              {&m->near, sizeof *m->near, n, needed, &g->room},
                              {&g->lower, point, n, needed, &g->room},
                              {&g->upper, point, n, needed, &g->room},
                              {&g->start, point, n, needed, &g->room},
                              {&g->radius, sizeof *g->radius, n, needed, &g->room}};
    const int is_done = grow_arrays(arrays, sizeof arrays / sizeof *arrays);
    set_views(g);
    return is_done && reserve_places(g, more);
}

/** Return the node with a number, a new one if there was none; there is room for it. */
static int32_t node_with(pl_gather *g, int64_t number) {
    pl_joint_mesh *m = &g->joint->mesh;
    const int64_t place = find_place(g, number);
    if (g->place[place] >= 0)
        return g->place[place];
    const int32_t node = (int32_t)g->n++;
    m->number[node] = number;
    m->star_of[node] = PL_JOINT_HELD;
    m->moved[node] = m->near[node] = 0;
    return g->place[place] = node;
}

/** Return the inner number that the plan has for a node, or -1; *is_own: this process moves it. */
static int32_t find_inner(const pl_gather *g, int64_t number, int *is_own) {
    const planish_part *part = pl_part_here();
    const planish_plan *plan = g->joint->run->plan;
    int64_t first = 0, end = plan->work.n_nodes;
    while (end - first > 1) {
        const int64_t middle = first + (end - first) / 2;
        if (part->node_number[middle] <= number)
            first = middle;
        else
            end = middle;
    }
    const int is_here = first < end && part->node_number[first] == number;
    *is_own = is_here && pl_is_own(part, first);
    return is_here ? plan->inner[first] : -1;
}

/* ---- stars ---------------------------------------------------------------------------------- */

enum { COUNTS = 3 }; /* of a star: ring, link, and whether the node slides */

/** Integers of the message about a star with these counts. */
static int64_t star_size(const pl_gather *g, const int64_t *count) {
    const int dim = dim_of(g), slide = 1 + 3 + 3;
    return 4 * dim + 1 + slide + count[0] * (2 + dim) + count[1] * (dim + 1);
}

/** Write the message about the star of an inner node of this process. */
static void put_star(const pl_gather *g, int32_t inner, int64_t *to) {
    const pl_run *r = g->joint->run;
    const pl_joint_mesh *own = &g->local;
    const pl_star_guard *guard = own->problem.guard;
    const int dim = dim_of(g), slides = own->star_of[inner] < 0;
    const int64_t at = slides ? -2 - own->star_of[inner] : own->star_of[inner];
    const pl_stars *stars = own->stars[slides];
    const double *bounds[] = {guard ? guard->lower : NULL, guard ? guard->upper : NULL,
                              guard && guard->radius ? guard->start : NULL};
    put_all(&to, r->plan->scratch.coordinates + (int64_t)inner * dim, dim);
    for (int k = 0; k < 3; k++)
        put_all(&to, bounds[k] ? bounds[k] + (int64_t)inner * dim : NULL, dim);
    put(&to, guard && guard->radius ? guard->radius[inner] : 0);
    *to++ = slides ? (int64_t)own->slide[at].kind : 0;
    put_all(&to, slides ? own->slide[at].point : NULL, 3);
    put_all(&to, slides ? own->slide[at].direction : NULL, 3);
    for (int64_t k = stars->ring_offset[at]; k < stars->ring_offset[at + 1]; k++) {
        const int32_t node = stars->ring[k];
        *to++ = own->number[node];
        *to++ = g->movable[node];
        put_all(&to, r->plan->scratch.coordinates + (int64_t)node * dim, dim);
    }
    const int64_t first = stars->link_offset[at], n = stars->link_offset[at + 1] - first;
    const pl_link link = pl_link_at(&stars->link, pl_link_positions(dim, 0), first);
    for (int64_t i = 0; i < n; i++) {
        for (int j = 0; j < dim; j++)
            *to++ = pl_link_get(&link, i * dim + j);
        put(&to, stars->min_volume ? stars->min_volume[first + i] : 0);
    }
}

/** Read the message about the star of node, for which there is room. */
static void take_star(pl_gather *g, int32_t node, const int64_t *count, const int64_t *from) {
    pl_joint_mesh *m = &g->joint->mesh;
    pl_stars *s = &g->stars;
    const int dim = dim_of(g);
    const int64_t at = s->n_stars++, first = s->link_offset[at];
    pl_star_slide *slide = &g->slide[at];
    m->star_of[node] = (int32_t)(count[2] ? -2 - at : at);
    get_all(&from, m->coordinates + (int64_t)node * dim, dim);
    get_all(&from, g->lower + (int64_t)node * dim, dim);
    get_all(&from, g->upper + (int64_t)node * dim, dim);
    get_all(&from, g->start + (int64_t)node * dim, dim);
    g->radius[node] = get(&from);
    slide->kind = (planish_constraint)*from++;
    get_all(&from, slide->point, 3);
    get_all(&from, slide->direction, 3);
    s->ring_offset[at + 1] = s->ring_offset[at] + count[0];
    for (int64_t k = s->ring_offset[at]; k < s->ring_offset[at + 1]; k++) {
        const int32_t other = s->ring[k] = node_with(g, *from++);
        if (*from++ && m->star_of[other] == PL_JOINT_HELD)
            m->star_of[other] = PL_JOINT_ELSEWHERE;
        get_all(&from, m->coordinates + (int64_t)other * dim, dim);
    }
    s->link_offset[at + 1] = first + count[1];
    const pl_link link = pl_link_at(&s->link, pl_link_positions(dim, 0), first);
    for (int64_t i = 0; i < count[1]; i++) {
        for (int j = 0; j < dim; j++)
            pl_link_set(&link, i * dim + j, (int32_t)*from++);
        s->min_volume[first + i] = get(&from);
    }
}

/** Make room for n stars with counts [n]; return 0 without memory. */
static int reserve_stars(pl_gather *g, const int64_t *count, int64_t n) {
    pl_stars *s = &g->stars;
    const int64_t stars = s->n_stars, offsets = s->ring_offset ? stars + 1 : 0;
    const int64_t more = stars + n + 1, positions = pl_link_positions(dim_of(g), 0);
    const int64_t ring = offsets > 0 ? s->ring_offset[stars] : 0,
                  link = offsets > 0 ? s->link_offset[stars] : 0;
    int64_t rings = ring, links = link;
    for (int64_t i = 0; i < n; i++) {
        rings += count[COUNTS * i];
        links += count[COUNTS * i + 1];
    }
    const growing arrays[] = {
        {&s->ring_offset, sizeof *s->ring_offset, offsets, more, &g->star_room},
        {&s->link_offset, sizeof *s->link_offset, offsets, more, &g->star_room},
        {&g->slide, sizeof *g->slide, stars, more, &g->star_room},
        {&s->ring, sizeof *s->ring, ring, rings, &g->ring_room},
        {&s->link.low, (size_t)positions, link, links, &g->link_room},
        {&s->link.high, (size_t)positions, link, links, &g->link_room},
        {&s->min_volume, sizeof *s->min_volume, link, links, &g->link_room}};
    return grow_arrays(arrays, sizeof arrays / sizeof *arrays) && reserve_nodes(g, rings - ring);
}

/** Set count [n][COUNTS] for the stars of n nodes, in all processes. */
static int count_stars(const pl_gather *g, const int32_t *node, int64_t n, int64_t *count) {
    for (int64_t i = 0; i < n; i++) {
        int is_own;
        const int32_t inner = find_inner(g, g->joint->mesh.number[node[i]], &is_own);
        if (!is_own)
            continue;
        const int slides = g->local.star_of[inner] < 0;
        const pl_stars *stars = g->local.stars[slides];
        const int64_t at = slides ? -2 - g->local.star_of[inner] : g->local.star_of[inner];
        count[COUNTS * i] = stars->ring_offset[at + 1] - stars->ring_offset[at];
        count[COUNTS * i + 1] = stars->link_offset[at + 1] - stars->link_offset[at];
        count[COUNTS * i + 2] = slides;
    }
    return add_up(count, COUNTS * n);
}

/** Gather the stars of n nodes with counts. message: room for them, all 0. */
static int exchange_stars(pl_gather *g, const int32_t *node, int64_t n, const int64_t *count,
                          int64_t *message, int64_t size) {
    int64_t at = 0;
    for (int64_t i = 0; i < n; at += star_size(g, count + COUNTS * i++)) {
        int is_own;
        const int32_t inner = find_inner(g, g->joint->mesh.number[node[i]], &is_own);
        if (is_own)
            put_star(g, inner, message + at);
    }
    if (!add_up(message, size))
        return 0;
    at = 0;
    for (int64_t i = 0; i < n; at += star_size(g, count + COUNTS * i++))
        take_star(g, node[i], count + COUNTS * i, message + at);
    return 1;
}

/** Gather the stars of n different nodes that can be in patches. */
static int gather_stars(pl_gather *g, const int32_t *node, int64_t n) {
    int64_t *count = pl_alloc_zero(COUNTS * n, sizeof *count), *message = NULL, size = 0;
    int is_fine = all_are_fine(count != NULL) && count_stars(g, node, n, count);
    for (int64_t i = 0; is_fine && i < n; i++)
        size += star_size(g, count + COUNTS * i);
    if (is_fine) {
        message = pl_alloc_zero(size, sizeof *message);
        is_fine = all_are_fine(message && reserve_stars(g, count, n));
    }
    is_fine = is_fine && exchange_stars(g, node, n, count, message, size);
    pl_free(count);
    pl_free(message);
    return is_fine;
}

/* ---- elements and patches ------------------------------------------------------------------- */

/** Return which vertex of an element is the first one that can be in a patch, -1: none can, or
 *  another process moves it. */
static int first_movable(const pl_gather *g, int64_t element) {
    const planish_plan *plan = g->joint->run->plan;
    const int32_t *node = plan->work.elements + element * (plan->dim + 1);
    for (int v = 0; v <= plan->dim; v++)
        if (g->movable[plan->inner[node[v]]])
            return pl_is_own(pl_part_here(), node[v]) ? v : -1;
    return -1;
}

/** Write the elements of this process to list, numbers of the nodes and which is the first that can
 *  move; NULL: none are written. Return how many there are. */
static int64_t list_own(const pl_gather *g, const uint8_t *state, int64_t *list) {
    const planish_plan *plan = g->joint->run->plan;
    int64_t n = 0;
    for (int64_t i = 0; i < plan->work.n_elements; i++) {
        const int first = state[i] == PL_WORSE ? first_movable(g, i) : -1;
        if (first < 0)
            continue;
        int64_t *to = list ? list + n * (plan->dim + 2) : NULL;
        for (int v = 0; list && v <= plan->dim; v++)
            to[v] = g->local.number[pl_plan_inner(plan, i, v)];
        if (list)
            to[plan->dim + 1] = first;
        n++;
    }
    return n;
}

/** Gather the elements of all processes in *list; the caller frees it. */
static int exchange_elements(pl_gather *g, const uint8_t *state, int64_t **list, int64_t *n) {
    int64_t *count = pl_alloc_zero(g->n_processes, sizeof *count), before = 0;
    *n = 0;
    int is_fine = all_are_fine(count != NULL);
    if (is_fine && g->rank >= 0)
        count[g->rank] = list_own(g, state, NULL);
    is_fine = is_fine && add_up(count, g->n_processes);
    for (int k = 0; is_fine && k < g->n_processes; k++) {
        before += k < g->rank ? count[k] : 0;
        *n += count[k];
    }
    if (is_fine) {
        *list = pl_alloc_zero(*n * (dim_of(g) + 2), sizeof **list);
        is_fine = all_are_fine(*list != NULL);
    }
    if (is_fine && g->rank >= 0)
        list_own(g, state, *list + before * (dim_of(g) + 2));
    is_fine = is_fine && add_up(*list, *n * (dim_of(g) + 2));
    pl_free(count);
    return is_fine;
}

/** Add node to those whose stars are wanted, once. */
static void want(pl_gather *g, int32_t node, int32_t *wanted, int64_t *n) {
    if (g->joint->mesh.star_of[node] == PL_JOINT_ELSEWHERE && g->joint->mesh.moved[node] >= 0) {
        g->joint->mesh.moved[node] = -1 - g->joint->mesh.moved[node];
        wanted[(*n)++] = node;
    }
}

/** Gather the wanted stars. */
static int gather_wanted(pl_gather *g, const int32_t *wanted, int64_t n) {
    for (int64_t i = 0; i < n; i++)
        g->joint->mesh.moved[wanted[i]] = -1 - g->joint->mesh.moved[wanted[i]];
    return n == 0 || gather_stars(g, wanted, n);
}

int pl_gather_elements(pl_gather *g, const uint8_t *state, int32_t **node, int64_t *n) {
    const int dim = dim_of(g);
    int64_t *list = NULL, n_wanted = 0;
    int32_t *wanted = NULL;
    *node = NULL;
    int is_fine = exchange_elements(g, state, &list, n);
    if (is_fine) {
        *node = pl_alloc(*n * (dim + 1), sizeof **node);
        wanted = pl_alloc(*n, sizeof *wanted);
        is_fine = all_are_fine(*node && wanted && reserve_nodes(g, *n * (dim + 1)));
    }
    for (int64_t i = 0; is_fine && i < *n; i++) {
        const int64_t *from = list + i * (dim + 2);
        int32_t *to = *node + i * (dim + 1);
        for (int v = 0; v <= dim; v++)
            to[v] = node_with(g, from[v]);
        const int32_t first = to[from[dim + 1]];
        g->joint->mesh.star_of[first] = PL_JOINT_ELSEWHERE;
        want(g, first, wanted, &n_wanted);
    }
    is_fine = is_fine && gather_wanted(g, wanted, n_wanted);
    pl_free(list);
    pl_free(wanted);
    return is_fine;
}

int pl_gather_patches(pl_gather *g, const pl_joint_patch *patch, int64_t n) {
    int32_t *wanted = pl_alloc(n * PL_JOINT_NODES, sizeof *wanted);
    int64_t n_wanted = 0;
    int is_fine = all_are_fine(wanted != NULL);
    for (int64_t i = 0; is_fine && i < n; i++)
        for (int k = 0; patch[i].state == PL_JOINT_OPEN && k < patch[i].n; k++)
            want(g, patch[i].node[k], wanted, &n_wanted);
    is_fine = is_fine && gather_wanted(g, wanted, n_wanted);
    pl_free(wanted);
    return is_fine;
}

int pl_gather_is_own(const pl_gather *g, const pl_joint_patch *patch) {
    int is_own;
    find_inner(g, g->joint->mesh.number[patch->node[0]], &is_own);
    return is_own;
}

/* ---- results -------------------------------------------------------------------------------- */

enum { FACTS = 4 }; /* of a patch beside its nodes: state, is_loose, n, work */

/** Integers of the message about a patch. */
static int64_t patch_size(const pl_gather *g) {
    return FACTS + PL_JOINT_NODES * (1 + dim_of(g));
}

static void put_patch(const pl_gather *g, const pl_joint_patch *p, int64_t *to) {
    *to++ = p->state;
    *to++ = p->is_loose;
    *to++ = p->n;
    *to++ = p->work;
    for (int k = 0; k < p->n; k++) {
        *to++ = p->node[k];
        put_all(&to, pl_joint_place(g->joint, p->node[k]), dim_of(g));
    }
}

/** Take the message about a patch: its nodes and their places. */
static void take_patch(pl_gather *g, const int64_t *from, pl_joint_patch *p) {
    const int dim = dim_of(g);
    p->state = (pl_joint_state)*from++;
    p->is_loose = (int)*from++;
    p->n = (int)*from++;
    p->work = *from++;
    for (int k = 0; k < p->n; k++) {
        int is_own;
        p->node[k] = (int32_t)*from++;
        double *place = pl_joint_place(g->joint, p->node[k]);
        get_all(&from, place, dim);
        const int32_t inner = find_inner(g, g->joint->mesh.number[p->node[k]], &is_own);
        if (inner >= 0)
            memcpy(g->local.coordinates + (int64_t)inner * dim, place, (size_t)dim * sizeof *place);
    }
}

int pl_gather_places(pl_gather *g, pl_joint_patch *const *patch, int64_t n) {
    const int64_t size = patch_size(g);
    int64_t *message = pl_alloc_zero(n * size, sizeof *message);
    int is_fine = all_are_fine(message != NULL);
    for (int64_t i = 0; is_fine && i < n; i++)
        if (pl_gather_is_own(g, patch[i]))
            put_patch(g, patch[i], message + i * size);
    is_fine = is_fine && add_up(message, n * size);
    for (int64_t i = 0; is_fine && i < n; i++)
        take_patch(g, message + i * size, patch[i]);
    pl_free(message);
    return is_fine;
}

/* ---- beginning and end ---------------------------------------------------------------------- */

/** Number the processes that have nodes: by the first one that each has. */
static void number_processes(pl_gather *g) {
    const planish_part *part = pl_part_here();
    const int64_t n = g->joint->run->plan->work.n_nodes;
    int64_t own = 0;
    while (own < n && !pl_is_own(part, own))
        own++;
    int64_t first = own < n ? part->node_number[own] : INT64_MAX;
    g->rank = -1;
    for (g->n_processes = 0;; g->n_processes++) {
        int64_t least = first;
        pl_parts_smallest_integers(&least, 1);
        if (least == INT64_MAX)
            return;
        if (least == first) {
            g->rank = g->n_processes;
            first = INT64_MAX;
        }
    }
}

void pl_gather_begin(pl_gather *g) {
    g->n = g->stars.n_stars = 0;
    g->stars.ring_offset[0] = g->stars.link_offset[0] = 0;
    memset(g->place, -1, (size_t)g->n_places * sizeof *g->place);
}

int pl_gather_create(pl_joint *joint, pl_gather *g, planish_error *error) {
    const planish_plan *plan = joint->run->plan;
    *g = (pl_gather){.joint = joint, .local = joint->mesh};
    joint->mesh = (pl_joint_mesh){0};
    g->movable = pl_alloc(plan->work.n_nodes, sizeof *g->movable);
    g->place = pl_alloc(PLACES_AT_LEAST, sizeof *g->place);
    g->n_places = PLACES_AT_LEAST;
    const int64_t none[COUNTS] = {0};
    if (!g->movable || !g->place || !reserve_stars(g, none, 1))
        return pl_fail_memory(error, "the worst elements");
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        g->movable[i] = g->local.star_of[i] != PL_JOINT_HELD;
    pl_parts_update(plan->inner, g->movable, sizeof *g->movable);
    pl_gather_begin(g);
    number_processes(g);
    return PLANISH_OK;
}

void pl_gather_destroy(pl_gather *g) {
    if (!g->joint)
        return;
    pl_joint_mesh *m = &g->joint->mesh;
    pl_free(m->coordinates);
    pl_free(m->star_of);
    pl_free(m->number);
    pl_free(m->moved);
    pl_free(m->near);
    *m = g->local;
    pl_stars_destroy(&g->stars);
    pl_free(g->slide);
    pl_free(g->lower);
    pl_free(g->upper);
    pl_free(g->start);
    pl_free(g->radius);
    pl_free(g->movable);
    pl_free(g->place);
}
