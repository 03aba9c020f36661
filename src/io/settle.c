/* settle: triangles of a tilted plane have the signs that they have in the file, before and after.
 *
 * A sign is that of the triangle seen along the column that is nearest to the plane's normal, of
 * the coordinates as they are written, and exact; where two columns are as near, it is that along
 * both. In the frame of the plane coordinates are rounded, and so are places in space.
 */
#include "io/file.h"
#include "io/plane.h"

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
        io_plane_project(&s->model->plane, place, uv);
        io_model_place(s->model, i, uv, again);
        for (int d = 0; d < 3; d++)
            s->back[i] |= !pl_is_same(place[d], again[d]);
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

int io_plane_keep(io_model *model, planish_error *error) {
    model->uv_read = pl_alloc(model->n_nodes, 2 * sizeof *model->uv_read);
    if (!model->uv_read)
        return pl_fail_memory(error, "coordinates");
    memcpy(model->uv_read, model->coordinates, (size_t)model->n_nodes * 2 * sizeof(double));
    return PLANISH_OK;
}
