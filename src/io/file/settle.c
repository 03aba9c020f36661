/* settle: triangles of a tilted plane have the signs that they have in the file, before and after.
 *
 * A sign is that of the triangle seen along the column that is nearest to the plane's normal, of
 * the coordinates as they are written, and exact; where two columns are as near, it is that along
 * both. In the frame of the plane coordinates are rounded, and so are places in space.
 */
#include "io/file/plane.h"

#include "base/context.h"
#include "base/exact.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { CHUNK = 1 << 13, MOST_VIEWS = 3 };

/** A column that triangles are seen along, and the sign of the normal there. */
typedef struct view {
    int axis, sign;
} view;

/** Those nearest to the normal: that of the plane first. Returns how many they are. */
static int find_views(const io_plane *plane, view views[MOST_VIEWS]) {
    const double as_near = 1 - 1e-6;
    int n = 0;
    views[n++] = (view){plane->axis[2], 1};
    for (int d = 0; d < 2; d++)
        if (fabs(plane->slope[d]) >= as_near)
            views[n++] = (view){plane->axis[d], plane->slope[d] < 0 ? 1 : -1};
    return n;
}

/** The sign of a triangle of places in space. */
static int sign_in_space(const double *places, const int32_t *nodes, view v) {
    double at[3][2];
    for (int k = 0; k < 3; k++) {
        at[k][0] = places[3 * (int64_t)nodes[k] + (v.axis + 1) % 3];
        at[k][1] = places[3 * (int64_t)nodes[k] + (v.axis + 2) % 3];
    }
    return v.sign * pl_exact_turn(at[0], at[1], at[2]);
}

static int sign_in_plane(const double *uv, const int32_t *nodes) {
    return pl_exact_turn(uv + 2 * (int64_t)nodes[0], uv + 2 * (int64_t)nodes[1],
                         uv + 2 * (int64_t)nodes[2]);
}

/* ---- after smoothing ------------------------------------------------------------------------- */

typedef struct settling {
    const io_model *model;
    double *uv;     /* [n_nodes][2] */
    double *places; /* [n_nodes][3] as written, owned */
    int8_t *sign;   /* [n_elements] in uv at first, owned */
    uint8_t *back;  /* [n_nodes] 1: goes back, 2: has gone */
    view views[MOST_VIEWS];
    int n_views;
    int any; /* node has to go back */
} settling;

static void find_signs(void *context, int64_t begin, int64_t end, int thread) {
    settling *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        s->sign[i] = (int8_t)sign_in_plane(s->uv, s->model->triangle.nodes + 3 * i);
}

/** Where a file holds less, coordinates are those of what it holds, if they lead back to it. */
static void place_nodes(void *context, int64_t begin, int64_t end, int thread) {
    settling *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        double *uv = s->uv + 2 * i, *place = s->places + 3 * i, again[3];
        io_model_place(s->model, i, uv, place);
        if (s->model->precision == PLANISH_DOUBLE || !io_plane_has_moved(s->model, i, uv))
            continue;
        const double before[2] = {uv[0], uv[1]};
        int same = 1;
        io_plane_project(&s->model->plane, place, uv);
        io_model_place(s->model, i, uv, again);
        for (int d = 0; d < 3; d++)
            same &= pl_is_same(place[d], again[d]);
        if (!same) /* what is held has nearly the digits of doubles */
            memcpy(uv, before, sizeof before);
    }
}

/** Let nodes that are to go back do so; *n counts them. */
static void go_back(settling *s, int64_t *n) {
    for (int64_t i = 0; i < s->model->n_nodes; i++) {
        if (s->back[i] != 1)
            continue;
        *n += io_plane_has_moved(s->model, i, s->uv + 2 * i);
        s->back[i] = 2;
        memcpy(s->uv + 2 * i, s->model->uv_read + 2 * i, 2 * sizeof *s->uv);
        memcpy(s->places + 3 * i, s->model->xyz + 3 * i, 3 * sizeof *s->places);
    }
}

/** Whether a triangle has another sign as written. Seen along a column as near as the plane's it
 *  may have had one before. */
static int is_harmed(const settling *s, int64_t element) {
    const int32_t *nodes = s->model->triangle.nodes + 3 * element;
    const int sign = s->sign[element];
    if (sign_in_space(s->places, nodes, s->views[0]) != sign || sign_in_plane(s->uv, nodes) != sign)
        return 1;
    for (int i = 1; i < s->n_views; i++)
        if (sign_in_space(s->places, nodes, s->views[i]) != sign &&
            sign_in_space(s->model->xyz, nodes, s->views[i]) == sign)
            return 1;
    return 0;
}

static void look_at_elements(void *context, int64_t begin, int64_t end, int thread) {
    settling *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *nodes = s->model->triangle.nodes + 3 * i;
        int has_moved = 0;
        for (int k = 0; k < 3; k++)
            has_moved |= io_plane_has_moved(s->model, nodes[k], s->uv + 2 * (int64_t)nodes[k]);
        if (!has_moved || !is_harmed(s, i))
            continue;
        for (int k = 0; k < 3; k++)
            if (io_plane_has_moved(s->model, nodes[k], s->uv + 2 * (int64_t)nodes[k])) {
                __atomic_store_n(&s->back[nodes[k]], 1, __ATOMIC_RELAXED);
                __atomic_store_n(&s->any, 1, __ATOMIC_RELAXED);
            }
    }
}

/** Ends, as each round takes nodes back. */
static void settle(settling *s, int64_t *n) {
    const io_model *model = s->model;
    const int64_t n_elements = model->triangle.n;
    s->n_views = find_views(&model->plane, s->views);
    pl_parallel_for(model->threads, n_elements, CHUNK, find_signs, s);
    pl_parallel_for(model->threads, model->n_nodes, CHUNK, place_nodes, s);
    do {
        go_back(s, n);
        s->any = 0;
        pl_parallel_for(model->threads, n_elements, CHUNK, look_at_elements, s);
    } while (s->any);
}

static int settle_tilted(const io_model *model, double *coordinates, uint8_t *back, int64_t *n,
                         planish_error *error) {
    settling s = {.model = model,
                  .uv = coordinates,
                  .places = pl_alloc(model->n_nodes, 3 * sizeof *s.places),
                  .sign = pl_alloc(model->triangle.n, sizeof *s.sign),
                  .back = pl_alloc_zero(model->n_nodes, 1)};
    const int has_room = s.places && s.sign && s.back;
    for (int64_t i = 0; has_room && back && i < model->n_nodes; i++)
        s.back[i] = back[i] != 0;
    if (has_room)
        settle(&s, n);
    for (int64_t i = 0; has_room && back && i < model->n_nodes; i++)
        back[i] = s.back[i] != 0;
    pl_free(s.back);
    pl_free(s.sign);
    pl_free(s.places);
    return has_room ? PLANISH_OK : pl_fail_memory(error, "the places of nodes");
}

int planish_file_settle(const planish_file *file, double *coordinates, uint8_t *back,
                        int64_t *n_back, planish_error *error) {
    int64_t n = 0;
    int status = PLANISH_OK;
    if (!file || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and coordinates must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    if (file->model.uv_read)
        status = settle_tilted(&file->model, coordinates, back, &n, error);
    pl_call_leave(&outside);
    if (!status && n_back)
        *n_back = n;
    return status;
}

/* ---- after reading --------------------------------------------------------------------------- */

/* Few triangles are so flat that rounding in the frame gives them another sign: nodes are moved by
 * a few units of the last place until all triangles around have their own. */
enum { FARTHEST = 6, MOST_NUDGED = 1000 };

typedef struct reading {
    io_model *model;
    view along;
    int usual;      /* the sign that most triangles have */
    uint8_t *wrong; /* [n_elements] owned */
    int64_t n_positive, n_negative, n_wrong;
    int64_t *first;  /* [n_nodes + 1] where the elements of a node begin in, owned, */
    int32_t *around; /* [3 n_elements] owned */
} reading;

/** Flat triangles are as good with the sign that is not usual: they count as inverted. */
static int is_wrong(const reading *r, int64_t element) {
    const int32_t *nodes = r->model->triangle.nodes + 3 * element;
    const int wanted = sign_in_space(r->model->xyz, nodes, r->along);
    const int sign = sign_in_plane(r->model->coordinates, nodes);
    return wanted == 0 ? sign == r->usual : sign != wanted;
}

static void count_usual(void *context, int64_t begin, int64_t end, int thread) {
    reading *r = context;
    int64_t n[3] = {0, 0, 0};
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n[1 + sign_in_plane(r->model->coordinates, r->model->triangle.nodes + 3 * i)]++;
    __atomic_fetch_add(&r->n_negative, n[0], __ATOMIC_RELAXED);
    __atomic_fetch_add(&r->n_positive, n[2], __ATOMIC_RELAXED);
}

static void find_wrong(void *context, int64_t begin, int64_t end, int thread) {
    reading *r = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n += r->wrong[i] = (uint8_t)is_wrong(r, i);
    __atomic_fetch_add(&r->n_wrong, n, __ATOMIC_RELAXED);
}

/** Which elements each node has. 0, or -1 without memory. */
static int find_around(reading *r) {
    const int64_t n_nodes = r->model->n_nodes, n = 3 * r->model->triangle.n;
    const int32_t *nodes = r->model->triangle.nodes;
    r->first = pl_alloc_zero(n_nodes + 2, sizeof *r->first);
    r->around = pl_alloc(n, sizeof *r->around);
    if (!r->first || !r->around)
        return -1;
    for (int64_t i = 0; i < n; i++)
        r->first[nodes[i] + 2]++;
    for (int64_t i = 0; i < n_nodes; i++)
        r->first[i + 2] += r->first[i + 1];
    for (int64_t i = 0; i < n; i++)
        r->around[r->first[nodes[i] + 1]++] = (int32_t)(i / 3);
    return 0;
}

static int count_wrong_around(const reading *r, int32_t node) {
    int n = 0;
    for (int64_t i = r->first[node]; i < r->first[node + 1]; i++)
        n += is_wrong(r, r->around[i]);
    return n;
}

/** Try the places at a distance of so many units; not 0: one is better. */
static int try_ring(reading *r, int64_t element, int32_t node, int distance, int before) {
    const double unit = DBL_EPSILON / 2 * r->model->plane.size;
    double *uv = r->model->coordinates + 2 * (int64_t)node;
    const double u = uv[0], v = uv[1];
    for (int i = -distance; i <= distance; i++)
        for (int k = -distance; k <= distance; k++) {
            if (i != -distance && i != distance && k != -distance && k != distance)
                continue;
            uv[0] = u + i * unit;
            uv[1] = v + k * unit;
            if (!is_wrong(r, element) && count_wrong_around(r, node) < before)
                return 1;
        }
    uv[0] = u;
    uv[1] = v;
    return 0;
}

static void nudge(reading *r, int64_t element) {
    const int32_t *nodes = r->model->triangle.nodes + 3 * element;
    int before[3];
    if (!is_wrong(r, element)) /* any more */
        return;
    for (int k = 0; k < 3; k++)
        before[k] = count_wrong_around(r, nodes[k]);
    for (int distance = 1; distance <= FARTHEST; distance++)
        for (int k = 0; k < 3; k++)
            if (try_ring(r, element, nodes[k], distance, before[k]))
                return;
}

static int give_signs(reading *r) {
    const int64_t n = r->model->triangle.n;
    int64_t n_nudged = 0;
    r->wrong = pl_alloc(n, 1);
    if (!r->wrong)
        return -1;
    pl_parallel_for(r->model->threads, n, CHUNK, count_usual, r);
    r->usual = r->n_negative > r->n_positive ? -1 : 1;
    pl_parallel_for(r->model->threads, n, CHUNK, find_wrong, r);
    if (r->n_wrong == 0)
        return 0;
    if (find_around(r))
        return -1;
    for (int64_t i = 0; i < n && n_nudged < MOST_NUDGED; i++)
        if (r->wrong[i]) {
            nudge(r, i);
            n_nudged++;
        }
    return 0;
}

int io_plane_keep(io_model *model, planish_error *error) {
    view views[MOST_VIEWS];
    find_views(&model->plane, views);
    reading r = {.model = model, .along = views[0]};
    const int failed = give_signs(&r);
    pl_free(r.wrong);
    pl_free(r.first);
    pl_free(r.around);
    model->uv_read = failed ? NULL : pl_alloc(model->n_nodes, 2 * sizeof *model->uv_read);
    if (!model->uv_read)
        return pl_fail_memory(error, "coordinates");
    memcpy(model->uv_read, model->coordinates, (size_t)model->n_nodes * 2 * sizeof(double));
    return PLANISH_OK;
}
