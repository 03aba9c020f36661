/* plane: between a plane and the columns of the file, and the signs of triangles in it.
 *
 * In a tilted plane a node is where it is seen along the column across that is nearest to the
 * normal, so that triangles have the signs that they have there; whatever it is off the plane it is
 * off along that column. A node that moves lands on the plane; one that does not keeps its bytes.
 *
 * Triangles of a tilted plane have the signs that they have in the file, before and after. A sign
 * is that of the triangle seen along the column that is nearest to the plane's normal, of the
 * coordinates as they are written, and exact; where two columns are as near, it is that along both.
 * In the frame of the plane coordinates are rounded, and so are places in space.
 */
#include "io/file/plane.h"

#include "io/core/number.h"

#include "base/context.h"
#include "base/exact.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/round.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { CHUNK = 1 << 13, CHUNK_NODES = 1 << 14, MOST_VIEWS = 3 };

/* ---- between plane and file ------------------------------------------------------------------ */

void io_plane_project(const io_plane *plane, const double xyz[3], double uv[2]) {
    const double x = xyz[plane->axis[0]], y = xyz[plane->axis[1]];
    uv[0] = x;
    uv[1] = y;
    if (plane->is_tilted) {
        const double dx = x - plane->origin[0], dy = y - plane->origin[1];
        uv[0] = plane->xu * dx + plane->yu * dy;
        uv[1] = plane->yv * dy;
    }
}

double io_stored(const io_model *model, double value) {
    return model->precision == PLANISH_PRECISION_FLOAT ? pl_round_to_float(value)
           : model->precision == PLANISH_PRECISION_ROUNDED
               ? io_round_to_field(value, model->field_width, model->exponent)
               : value;
}

/** Return whether a node of a tilted plane with coordinates uv is not where it was. */
static int has_moved(const io_model *model, int64_t node, const double *uv) {
    const double *before = model->uv_read + 2 * node;
    return !pl_is_same(uv[0], before[0]) || !pl_is_same(uv[1], before[1]);
}

/** Find where node is with coordinates at [dim], in the file's columns. */
static void space_coordinates(const io_model *model, int64_t node, const double *at,
                              double xyz[3]) {
    const io_plane *plane = &model->plane;
    const int *axis = plane->axis;
    const double *read = model->xyz ? model->xyz + 3 * node : NULL;
    if (model->dim == 3) {
        for (int d = 0; d < 3; d++) /* at may be xyz */
            xyz[d] = at[d];
    } else if (!plane->is_tilted) {
        xyz[axis[0]] = at[0];
        xyz[axis[1]] = at[1];
        xyz[axis[2]] = read ? read[axis[2]] : model->z ? model->z[node] : 0;
    } else if (!has_moved(model, node, at)) {
        memcpy(xyz, read, 3 * sizeof *xyz);
    } else { /* on the plane, but for the roundings of the file */
        const double *origin = plane->origin;
        const double dy = at[1] / plane->yv, dx = (at[0] - plane->yu * dy) / plane->xu;
        const double x = io_stored(model, origin[0] + dx), y = io_stored(model, origin[1] + dy);
        const double up = plane->slope[0] * (x - origin[0]) + plane->slope[1] * (y - origin[1]);
        xyz[axis[0]] = x;
        xyz[axis[1]] = y;
        xyz[axis[2]] = io_stored(model, origin[2] + up);
    }
}

/** Nodes to be placed, some perhaps several times. */
typedef struct placing {
    const io_model *model;
    const double *coordinates;
    const int32_t *place_node;
    double *places;
} placing;

static void place_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const placing *p = context;
    const int dim = p->model->dim, written = p->model->written;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t node = p->place_node ? p->place_node[i] : i;
        double xyz[3];
        space_coordinates(p->model, node, p->coordinates + dim * node, xyz);
        if (p->place_node && p->model->place_across)
            xyz[p->model->plane.axis[2]] = p->model->place_across[i];
        memcpy(p->places + written * i, xyz, (size_t)written * sizeof *xyz);
    }
}

int io_check_coordinates(const io_model *model, const double *coordinates, planish_error *error) {
    for (int64_t i = 0; i < model->dim * model->n_nodes; i++)
        if (!(fabs(coordinates[i]) <= DBL_MAX))
            return pl_fail_at(error, PLANISH_ERROR_ARGUMENT, -1, i / model->dim,
                              "coordinate %d of node %lld is not finite", (int)(i % model->dim),
                              (long long)(i / model->dim));
    return PLANISH_OK;
}

int io_written_coordinates(const io_model *model, const double *coordinates,
                           const int32_t *place_node, int threads, const double **places,
                           double **owned, planish_error *error) {
    const int64_t n = place_node ? model->n_places : model->n_nodes;
    *owned = NULL;
    *places = coordinates;
    if (model->dim == model->written && !place_node)
        return PLANISH_OK;
    *places = *owned = pl_alloc(n, (size_t)model->written * sizeof **owned);
    if (!*owned)
        return pl_fail_memory(error, "the places of nodes");
    placing p = {model, coordinates, place_node, *owned};
    pl_parallel_for(threads, n, CHUNK_NODES, place_chunk, &p);
    return PLANISH_OK;
}

const double *io_written_as_read(const io_model *model) {
    return model->xyz ? model->xyz : model->coordinates;
}

int planish_file_space_coordinates(const planish_file *file, int64_t first, int64_t n,
                                   const double *coordinates, double *xyz, planish_error *error) {
    if (!file || n < 0 || (n > 0 && (!coordinates || !xyz)))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "file, coordinates and xyz must not be NULL, and n not be negative");
    if (first < 0 || first > file->model.n_nodes || n > file->model.n_nodes - first)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "nodes %lld to %lld are not all among the %lld of the file",
                       (long long)first, (long long)(first + n - 1),
                       (long long)file->model.n_nodes);
    const pl_outside outside = pl_call_enter(NULL);
    for (int64_t i = 0; i < n; i++)
        space_coordinates(&file->model, first + i, coordinates + file->model.dim * i, xyz + 3 * i);
    pl_call_leave(&outside);
    return PLANISH_OK;
}

int planish_file_plane(const planish_file *file, planish_plane *plane) {
    if (plane)
        *plane = (planish_plane){.axis = {0, 1, 2}};
    if (!file || file->model.dim == 3)
        return 0;
    const io_plane *p = &file->model.plane;
    if (!plane)
        return !io_plane_is_xy(p);
    /* In space u goes along the slope of x, v turns left of it. */
    const double *slope = p->slope;
    const double xu = p->is_tilted ? p->xu : 1, yv = p->is_tilted ? p->yv : 1;
    const double length = sqrt(1 + slope[0] * slope[0] + slope[1] * slope[1]);
    const double u[3] = {1 / xu, 0, slope[0] / xu};
    const double v[3] = {-p->yu * u[0] / yv, 1 / yv, (slope[1] - p->yu * u[2]) / yv};
    const double normal[3] = {-slope[0] / length, -slope[1] / length, 1 / length};
    plane->is_tilted = p->is_tilted;
    plane->off = p->off;
    for (int d = 0; d < 3; d++) {
        const int axis = plane->axis[d] = p->axis[d];
        plane->origin[axis] = p->origin[d];
        plane->direction[0][axis] = u[d];
        plane->direction[1][axis] = v[d];
        plane->normal[axis] = normal[d];
    }
    return !io_plane_is_xy(p);
}

/* ---- signs ----------------------------------------------------------------------------------- */

/** A column that triangles are seen along, and the sign of the normal there. */
typedef struct column_view {
    int axis, sign;
} column_view;

/** Find the columns nearest to the normal: that of the plane first. Return their number. */
static int find_views(const io_plane *plane, column_view views[MOST_VIEWS]) {
    const double as_near = 1 - 1e-6;
    int n = 0;
    views[n++] = (column_view){plane->axis[2], 1};
    for (int d = 0; d < 2; d++)
        if (fabs(plane->slope[d]) >= as_near)
            views[n++] = (column_view){plane->axis[d], plane->slope[d] < 0 ? 1 : -1};
    return n;
}

/** Find the sign of a triangle of places in space. */
static int sign_in_space(const double *places, const int32_t *nodes, column_view v) {
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

/** The triangles whose signs are looked at, and their number. */
static const int32_t *corners_of(const io_model *model) {
    return model->corner ? model->corner : model->triangle.nodes;
}

static int64_t n_corners_of(const io_model *model) {
    return model->corner ? model->n_corners : model->triangle.n;
}

/** Make the corners of quadrilaterals triangles, behind those that there are. */
static int make_corners(io_model *model, planish_error *error) {
    enum { CORNERS = 4 };
    const io_others *flat = &model->flat;
    const int64_t n = model->triangle.n;
    model->n_corners = n + CORNERS * flat->n;
    int32_t *to = model->corner = pl_alloc(3 * model->n_corners, sizeof *to);
    if (!to)
        return pl_fail_memory(error, "the corners of quadrilaterals");
    if (n > 0)
        memcpy(to, model->triangle.nodes, (size_t)(3 * n) * sizeof *to);
    to += 3 * n;
    for (int64_t i = 0; i < flat->n; i++) {
        const int32_t *node = flat->node + flat->offset[i];
        for (int k = 0; k < CORNERS; k++, to += 3) {
            to[0] = node[k];
            to[1] = node[(k + 1) % CORNERS];
            to[2] = node[(k + CORNERS - 1) % CORNERS];
        }
    }
    return PLANISH_OK;
}

/* ---- signs after smoothing ------------------------------------------------------------------- */

typedef struct rounding {
    const io_model *model;
    double *uv;     /* [n_nodes][2] */
    double *places; /* [n_nodes][3] as written, owned */
    int8_t *sign;   /* [n_elements] in uv at first, owned */
    uint8_t *back;  /* [n_nodes] 1: goes back, 2: has gone; owned */
    column_view views[MOST_VIEWS];
    int n_views;
    int any; /* node has to go back */
} rounding;

static void find_signs(void *context, int64_t begin, int64_t end, int thread) {
    rounding *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        s->sign[i] = (int8_t)sign_in_plane(s->uv, corners_of(s->model) + 3 * i);
}

/** Place a node; where a file holds less, coordinates become those of what it holds, if they lead
 *  back to it. */
static void round_node(const rounding *s, int64_t i) {
    double *uv = s->uv + 2 * i, *place = s->places + 3 * i, again[3];
    space_coordinates(s->model, i, uv, place);
    if (s->model->precision == PLANISH_PRECISION_DOUBLE || !has_moved(s->model, i, uv))
        return;
    const double before[2] = {uv[0], uv[1]};
    int same = 1;
    io_plane_project(&s->model->plane, place, uv);
    space_coordinates(s->model, i, uv, again);
    for (int d = 0; d < 3; d++)
        same &= pl_is_same(place[d], again[d]);
    if (!same) /* what is held has nearly the digits of doubles */
        memcpy(uv, before, sizeof before);
}

static void round_nodes(void *context, int64_t begin, int64_t end, int thread) {
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        round_node(context, i);
}

/** Return whether a triangle has another sign as written. Seen along a column as near as the
 *  plane's it may have had one before. */
static int is_harmed(const rounding *s, int64_t element) {
    const int32_t *nodes = corners_of(s->model) + 3 * element;
    const int sign = s->sign[element];
    if (sign_in_space(s->places, nodes, s->views[0]) != sign || sign_in_plane(s->uv, nodes) != sign)
        return 1;
    for (int i = 1; i < s->n_views; i++)
        if (sign_in_space(s->places, nodes, s->views[i]) != sign &&
            sign_in_space(s->model->xyz, nodes, s->views[i]) == sign)
            return 1;
    return 0;
}

/** Let the moved nodes of harmed triangles go back. */
static void find_harm(void *context, int64_t begin, int64_t end, int thread) {
    rounding *s = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t *nodes = corners_of(s->model) + 3 * i;
        int moved[3];
        for (int k = 0; k < 3; k++)
            moved[k] = has_moved(s->model, nodes[k], s->uv + 2 * (int64_t)nodes[k]);
        if ((!moved[0] && !moved[1] && !moved[2]) || !is_harmed(s, i))
            continue;
        for (int k = 0; k < 3; k++)
            if (moved[k])
                __atomic_store_n(&s->back[nodes[k]], 1, __ATOMIC_RELAXED);
        __atomic_store_n(&s->any, 1, __ATOMIC_RELAXED);
    }
}

/** Let a node follow n corners, by their mean way, if any of them has gone back. */
static void follow_corners(const rounding *s, int64_t node, const int32_t *corner, int n) {
    const double *before = s->model->uv_read;
    int any = 0;
    for (int k = 0; k < n; k++)
        any |= s->back[corner[k]];
    if (node < 0 || s->back[node] || !any)
        return;
    for (int d = 0; d < 2; d++) {
        double way = 0;
        for (int k = 0; k < n; k++)
            way += s->uv[2 * (int64_t)corner[k] + d] - before[2 * (int64_t)corner[k] + d];
        s->uv[2 * node + d] = before[2 * node + d] + way / n;
    }
    round_node(s, node);
}

/** Let mids and nodes inside of elements follow corners that have gone back, as planish_smooth does.
 */
static void follow_back(const rounding *s) {
    const io_cells *triangles = &s->model->triangle;
    const io_others *flat = &s->model->flat;
    for (int64_t i = 0; triangles->mid && i < 3 * triangles->n; i++) {
        const int32_t ends[] = {triangles->nodes[i], triangles->nodes[i % 3 == 2 ? i - 2 : i + 1]};
        follow_corners(s, triangles->mid[i], ends, 2);
    }
    for (int64_t i = 0; i < flat->n; i++) {
        const int32_t *node = flat->node + flat->offset[i];
        const int64_t n = flat->offset[i + 1] - flat->offset[i];
        for (int k = 4; k < n && k < 8; k++) {
            const int32_t ends[] = {node[k - 4], node[(k - 3) % 4]};
            follow_corners(s, node[k], ends, 2);
        }
        if (n > 8)
            follow_corners(s, node[8], node, 4);
    }
}

/** Round coordinates in a tilted plane; *n counts the nodes that go back. Ends, as each round
 *  takes nodes back. */
static void round_in_plane(rounding *s, int64_t *n) {
    const io_model *model = s->model;
    const int64_t n_elements = n_corners_of(model);
    s->n_views = find_views(&model->plane, s->views);
    pl_parallel_for(io_model_threads(model), n_elements, CHUNK, find_signs, s);
    pl_parallel_for(io_model_threads(model), model->n_nodes, CHUNK, round_nodes, s);
    do {
        for (int64_t i = 0; i < model->n_nodes; i++) {
            if (s->back[i] != 1)
                continue;
            *n += has_moved(model, i, s->uv + 2 * i);
            s->back[i] = 2;
            memcpy(s->uv + 2 * i, model->uv_read + 2 * i, 2 * sizeof *s->uv);
            memcpy(s->places + 3 * i, model->xyz + 3 * i, 3 * sizeof *s->places);
        }
        s->any = 0;
        pl_parallel_for(io_model_threads(model), n_elements, CHUNK, find_harm, s);
    } while (s->any);
    follow_back(s);
}

int planish_file_round_in_plane(const planish_file *file, double *coordinates, uint8_t *back,
                                int64_t *n_back, planish_error *error) {
    int64_t n = 0;
    if (!file || !coordinates)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT, "file and coordinates must not be NULL");
    const pl_outside outside = pl_call_enter(NULL);
    const io_model *model = &file->model;
    rounding s = {.model = model, .uv = coordinates};
    int status = PLANISH_OK;
    if (model->uv_read) {
        s.places = pl_alloc(model->n_nodes, 3 * sizeof *s.places);
        s.sign = pl_alloc(n_corners_of(model), sizeof *s.sign);
        s.back = pl_alloc_zero(model->n_nodes, 1);
        if (!s.places || !s.sign || !s.back)
            status = pl_fail_memory(error, "the places of nodes");
    }
    if (!status && model->uv_read) {
        for (int64_t i = 0; back && i < model->n_nodes; i++)
            s.back[i] = back[i] != 0;
        round_in_plane(&s, &n);
        for (int64_t i = 0; back && i < model->n_nodes; i++)
            back[i] = s.back[i] != 0;
    }
    pl_free(s.back);
    pl_free(s.sign);
    pl_free(s.places);
    pl_call_leave(&outside);
    if (!status && n_back)
        *n_back = n;
    return status;
}

/* ---- signs after reading --------------------------------------------------------------------- */

/* Few triangles are so flat that rounding in the frame gives them another sign: nodes are moved by
 * a few units of the last place until all triangles around have their own. */
enum { FARTHEST = 6, MOST_NUDGED = 1000 };

typedef struct flat_search {
    io_model *model;
    column_view along;
    int usual;      /* the sign that most triangles have */
    uint8_t *wrong; /* [n_elements] owned */
    int64_t n_positive, n_negative, n_wrong;
    int64_t *first;  /* [n_nodes + 2] where the elements of a node begin in, owned, */
    int32_t *around; /* [3 n_elements] owned */
} flat_search;

/** Return whether a triangle has another sign than in the file. Flat ones are as good with the sign
 *  that is not usual: they count as inverted. */
static int is_wrong(const flat_search *f, int64_t element) {
    const int32_t *nodes = corners_of(f->model) + 3 * element;
    const int wanted = sign_in_space(f->model->xyz, nodes, f->along);
    const int sign = sign_in_plane(f->model->coordinates, nodes);
    return wanted == 0 ? sign == f->usual : sign != wanted;
}

static void count_usual(void *context, int64_t begin, int64_t end, int thread) {
    flat_search *f = context;
    int64_t n[3] = {0, 0, 0};
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n[1 + sign_in_plane(f->model->coordinates, corners_of(f->model) + 3 * i)]++;
    __atomic_fetch_add(&f->n_negative, n[0], __ATOMIC_RELAXED);
    __atomic_fetch_add(&f->n_positive, n[2], __ATOMIC_RELAXED);
}

static void find_wrong(void *context, int64_t begin, int64_t end, int thread) {
    flat_search *f = context;
    int64_t n = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        n += f->wrong[i] = (uint8_t)is_wrong(f, i);
    __atomic_fetch_add(&f->n_wrong, n, __ATOMIC_RELAXED);
}

/** Find the elements of each node. Return 0, or -1 without memory. */
static int find_around(flat_search *f) {
    const int64_t n_nodes = f->model->n_nodes, n = 3 * n_corners_of(f->model);
    const int32_t *nodes = corners_of(f->model);
    f->first = pl_alloc_zero(n_nodes + 2, sizeof *f->first);
    f->around = pl_alloc(n, sizeof *f->around);
    if (!f->first || !f->around)
        return -1;
    for (int64_t i = 0; i < n; i++)
        f->first[nodes[i] + 2]++;
    for (int64_t i = 0; i < n_nodes; i++)
        f->first[i + 2] += f->first[i + 1];
    for (int64_t i = 0; i < n; i++)
        f->around[f->first[nodes[i] + 1]++] = (int32_t)(i / 3);
    return 0;
}

static int count_wrong_around(const flat_search *f, int32_t node) {
    int n = 0;
    for (int64_t i = f->first[node]; i < f->first[node + 1]; i++)
        n += is_wrong(f, f->around[i]);
    return n;
}

/** Try the places of a node at a distance of so many units; not 0: one is better. */
static int try_ring(flat_search *f, int64_t element, int32_t node, int distance, int before) {
    const double unit = DBL_EPSILON / 2 * f->model->plane.size;
    double *uv = f->model->coordinates + 2 * (int64_t)node;
    const double u = uv[0], v = uv[1];
    for (int i = -distance; i <= distance; i++)
        for (int k = -distance; k <= distance; k++) {
            if (i != -distance && i != distance && k != -distance && k != distance)
                continue;
            uv[0] = u + i * unit;
            uv[1] = v + k * unit;
            if (!is_wrong(f, element) && count_wrong_around(f, node) < before)
                return 1;
        }
    uv[0] = u;
    uv[1] = v;
    return 0;
}

/** Move a node of a wrong element, as little as does it. */
static void nudge(flat_search *f, int64_t element) {
    const int32_t *nodes = corners_of(f->model) + 3 * element;
    int before[3];
    if (!is_wrong(f, element)) /* any more */
        return;
    for (int k = 0; k < 3; k++)
        before[k] = count_wrong_around(f, nodes[k]);
    for (int distance = 1; distance <= FARTHEST; distance++)
        for (int k = 0; k < 3; k++)
            if (try_ring(f, element, nodes[k], distance, before[k]))
                return;
}

int io_plane_keep(io_model *model, planish_error *error) {
    if (model->flat.n > 0 && make_corners(model, error))
        return PLANISH_ERROR_MEMORY;
    const int64_t n = n_corners_of(model);
    column_view views[MOST_VIEWS];
    find_views(&model->plane, views);
    flat_search f = {.model = model, .along = views[0], .wrong = pl_alloc(n, 1)};
    int is_out_of_memory = !f.wrong;
    if (f.wrong) {
        pl_parallel_for(io_model_threads(model), n, CHUNK, count_usual, &f);
        f.usual = f.n_negative > f.n_positive ? -1 : 1;
        pl_parallel_for(io_model_threads(model), n, CHUNK, find_wrong, &f);
    }
    if (f.n_wrong > 0) {
        is_out_of_memory = find_around(&f);
        for (int64_t i = 0, n_nudged = 0; !is_out_of_memory && i < n && n_nudged < MOST_NUDGED; i++)
            if (f.wrong[i]) {
                nudge(&f, i);
                n_nudged++;
            }
    }
    pl_free(f.wrong);
    pl_free(f.first);
    pl_free(f.around);
    model->uv_read = is_out_of_memory ? NULL : pl_alloc(model->n_nodes, 2 * sizeof *model->uv_read);
    if (!model->uv_read)
        return pl_fail_memory(error, "coordinates");
    memcpy(model->uv_read, model->coordinates, (size_t)model->n_nodes * 2 * sizeof(double));
    return PLANISH_OK;
}
