/* skin_mids: visits of corners of facets of second order.
 *
 * When such a corner moves, the mids of its edges follow by half of the way, as all mids do, and go
 * from there to the nearest place of the shape. So a mid is where it was first if its ends are, and
 * no mid moves whose ends stay. All four triangles of each facet at the corner change.
 *
 * A facet is off the shape by what its four parts are (shape/overlay.h), and by no more than its
 * points have gone (pl_whole_way), in all or since it was certified.
 */
#include "sweep/skin.h"

#include "base/memory.h"
#include "shape/overlay.h"

#include <math.h>
#include <string.h>

/* As in skin.c. */
#define TURN       0.5
#define ROUNDED_UP (1 + 0x1p-40)

/** An edge at the node of a visit. */
typedef struct mid_of {
    int32_t mid, end;
    int is_placed;
    double before[3]; /* own, when the visit began */
} mid_of;

/** A facet of second order at the node. */
typedef struct whole_of {
    double x[6][3]; /* nodes where they are when the visit begins */
    pl_place place[6];
    int corner;           /* the node */
    int mid[2];           /* numbers in the visit of the mids of its edges from and to the node */
    uint8_t node[4][3];   /* of the triangles, as places in x */
    int32_t beside[4][3]; /* triangles of the visit across their edges; -1: none, or a feature; */
    int32_t beyond[4][3]; /* or of others, and their unit normals */
    double normal[4][3][3];
} whole_of;

struct pl_skin_wholes {
    int n_mids, n;
    mid_of *mid;           /* [n_mids] */
    whole_of *whole;       /* [n] */
    double (*before)[3];   /* [4 n] unit normals of triangles when the visit began */
    pl_mid_trial *trial;   /* [PL_SKIN_TRIALS][most mids] */
    double (*moved)[6][3]; /* [n] nodes on trial */
    pl_place (*place)[6];
};

/* ---- room ------------------------------------------------------------------------------------- */

static int64_t most_wholes(const pl_skin *skin) {
    return skin->max_facets / 4;
}

int pl_skin_mids_make(pl_skin *skin) {
    const int64_t n = most_wholes(skin);
    int done = 1;
    if (!skin->shape->whole)
        return 1;
    skin->wholes = pl_alloc_zero(skin->threads, sizeof *skin->wholes);
    for (int t = 0; skin->wholes && t < skin->threads; t++) {
        struct pl_skin_wholes *w = &skin->wholes[t];
        w->mid = pl_alloc(2 * n, sizeof *w->mid);
        w->whole = pl_alloc(n, sizeof *w->whole);
        w->before = pl_alloc(4 * n, sizeof *w->before);
        w->trial = pl_alloc(PL_SKIN_TRIALS * 2 * n, sizeof *w->trial);
        w->moved = pl_alloc(n, sizeof *w->moved);
        w->place = pl_alloc(n, sizeof *w->place);
        done = done && w->mid && w->whole && w->before && w->trial && w->moved && w->place;
    }
    return skin->wholes && done;
}

void pl_skin_mids_destroy(pl_skin *skin) {
    for (int t = 0; skin->wholes && t < skin->threads; t++) {
        pl_free(skin->wholes[t].mid);
        pl_free(skin->wholes[t].whole);
        pl_free(skin->wholes[t].before);
        pl_free(skin->wholes[t].trial);
        pl_free(skin->wholes[t].moved);
        pl_free(skin->wholes[t].place);
    }
    pl_free(skin->wholes);
    skin->wholes = NULL;
}

void pl_skin_mids_prepare(const pl_skin *skin, int thread, pl_skin_visit *v) {
    if (!skin->wholes)
        return;
    v->wholes = &skin->wholes[thread];
    for (int i = 0; i < PL_SKIN_TRIALS; i++)
        v->trial[i].mid = v->wholes->trial + i * 2 * most_wholes(skin);
}

/* ---- places of mids --------------------------------------------------------------------------- */

int pl_skin_is_placed(const pl_skin *skin, int32_t mid, int32_t a, int32_t b) {
    const planish_shape *shape = skin->shape;
    const int is_moved = skin->moves[a] == PLANISH_CONSTRAINT_ON_PATCH ||
                         skin->moves[a] == PLANISH_CONSTRAINT_ON_CURVE ||
                         skin->moves[b] == PLANISH_CONSTRAINT_ON_PATCH ||
                         skin->moves[b] == PLANISH_CONSTRAINT_ON_CURVE;
    return is_moved && (shape->node_class[mid] == PL_ON_CURVE ||
                        (shape->node_class[mid] == PL_ON_PATCH &&
                         !skin->is_planar[shape->facet_of[shape->offset[mid]]]));
}

/** Find the ways of both ends of a mid together, node (-1: none) being at x. Returns whether an end is not
 *  where it was. */
static int find_way(const pl_skin *skin, int32_t mid, int32_t node, const double *x,
                    double way[3]) {
    const pl_mids *m = skin->mids;
    const planish_plan *plan = skin->plan;
    const int32_t *end = m->end[skin->shape->node[mid]];
    int any = 0;
    memset(way, 0, 3 * sizeof *way);
    for (int j = 0; j < 2 && end[0] >= 0; j++) {
        const int32_t inner = plan->inner[end[j]];
        const double *now =
            node >= 0 && inner == skin->inner[node] ? x : skin->coordinates + (int64_t)inner * 3;
        for (int d = 0; d < 3; d++) {
            const double part = now[d] - m->given[(int64_t)end[j] * 3 + d];
            way[d] += part;
            any |= part != 0;
        }
    }
    return any;
}

/** Find where a mid is to be if node (-1: none) is at x, in the mesh's units. */
static void find_mid(const pl_skin *skin, int32_t mid, int is_placed, int32_t node, const double *x,
                     pl_mid_trial *trial) {
    const planish_shape *shape = skin->shape;
    const pl_mids *m = skin->mids;
    const int32_t of_mesh = shape->node[mid];
    const int node_class = shape->node_class[mid];
    double way[3], at[3], direction[3];
    const int has_moved = find_way(skin, mid, node, x, way);
    trial->place = pl_skin_get_place(skin, mid);
    for (int d = 0; d < 3; d++) {
        trial->own[d] = 0;
        at[d] = pl_mid_coordinate_by(m, of_mesh, d, way[d] / 2, 0) * shape->scale;
    }
    if (trial->place.at >= 0)
        pl_shape_walk(shape, node_class, at, &trial->place);
    if (has_moved && is_placed && trial->place.at >= 0) {
        pl_shape_point(shape, node_class, &trial->place, at, direction);
        for (int d = 0; d < 3; d++) {
            const double start = m->start.x[pl_point_at(&m->start, of_mesh, d)];
            trial->own[d] = at[d] * skin->unscale - start - way[d] / 2;
        }
    }
    for (int d = 0; d < 3; d++)
        trial->x[d] = pl_mid_coordinate_by(m, of_mesh, d, way[d] / 2, trial->own[d]) * shape->scale;
}

static double *own_of(const pl_skin *skin, int32_t mid) {
    return skin->mids->own + (int64_t)skin->shape->node[mid] * 3;
}

/** The edges of a facet of second order at a node: the mid of each and its other end. */
static void edges_at(const int32_t *corner, int32_t node, int32_t mid[2], int32_t end[2]) {
    const int k = corner[0] == node ? 0 : corner[1] == node ? 1 : 2, before = (k + 2) % 3;
    mid[0] = corner[3 + k];
    end[0] = corner[(k + 1) % 3];
    mid[1] = corner[3 + before];
    end[1] = corner[before];
}

void pl_skin_place_mids(pl_skin *skin, int32_t node) {
    const planish_shape *shape = skin->shape;
    int64_t n = 0;
    const int32_t *facet = pl_shape_star(shape, node, &n);
    for (int64_t i = 0; shape->whole && skin->mids->own && i < n; i += 4) {
        int32_t mid[2], end[2];
        edges_at(shape->whole[facet[i] / 4], node, mid, end);
        for (int j = 0; j < 2; j++) {
            pl_mid_trial trial;
            find_mid(skin, mid[j], pl_skin_is_placed(skin, mid[j], node, end[j]), -1, NULL, &trial);
            memcpy(own_of(skin, mid[j]), trial.own, sizeof trial.own);
            pl_skin_set_place(skin, mid[j], &trial.place);
        }
    }
}

/* ---- distances -------------------------------------------------------------------------------- */

/** Bound how far a facet of second order, first its first triangle, is off the shape with its nodes at x,
 *  and there in place; infinite: not known, or above limit. */
static double certify(const planish_shape *shape, int32_t first, const double x[6][3],
                      const pl_place place[6], double limit) {
    double most = 0, first_x[6][3];
    for (int i = 0; i < 6; i++)
        memcpy(first_x[i], shape->x[shape->whole[first / 4][i]], sizeof first_x[i]);
    const double way = pl_whole_way((const double(*)[3])first_x, x);
    if (way <= limit)
        return way;
    for (int32_t f = first; f < first + 4; f++) {
        pl_moved_facet moved = {.facet = f};
        uint8_t node[3] = {0};
        pl_find_quarter(shape, f, node);
        pl_find_rises(x, node, moved.rise);
        for (int j = 0; j < 3; j++) {
            memcpy(moved.x[j], x[node[j]], sizeof moved.x[j]);
            moved.place[j] = place[node[j]];
        }
        const double lateral = pl_overlay_lateral(shape, &moved);
        if (!(lateral <= limit))
            return INFINITY;
        most = fmax(most, fmax(lateral, pl_overlay_bound(shape, &moved, lateral, limit)));
        if (!(most <= limit))
            return INFINITY;
    }
    return most * ROUNDED_UP;
}

double pl_skin_certify_whole(const pl_skin *skin, int32_t facet) {
    const int32_t *whole = skin->shape->whole[facet / 4];
    double x[6][3];
    pl_place place[6];
    for (int i = 0; i < 6; i++) {
        pl_skin_place_of(skin, whole[i], x[i]);
        place[i] = pl_skin_present_place(skin, whole[i]);
    }
    return certify(skin->shape, facet, (const double(*)[3])x, place, skin->tolerance[facet]);
}

/* ---- visits ----------------------------------------------------------------------------------- */

/** Note an edge at the node; returns its number. */
static int note_mid(const pl_skin_visit *v, int32_t mid, int32_t end) {
    const pl_skin *skin = v->skin;
    struct pl_skin_wholes *w = v->wholes;
    int i = 0;
    while (i < w->n_mids && w->mid[i].mid != mid)
        i++;
    if (i < w->n_mids)
        return i;
    w->mid[i] =
        (mid_of){.mid = mid, .end = end, .is_placed = pl_skin_is_placed(skin, mid, v->node, end)};
    memcpy(w->mid[i].before, own_of(skin, mid), sizeof w->mid[i].before);
    return w->n_mids++;
}

void pl_skin_mids_begin(pl_skin_visit *v) {
    const planish_shape *shape = v->skin->shape;
    struct pl_skin_wholes *w = v->wholes;
    w->n = v->n / 4;
    w->n_mids = 0;
    for (int i = 0; i < w->n; i++) {
        int32_t mid[2], end[2];
        const int32_t *corner = shape->whole[v->facet[4 * i] / 4];
        edges_at(corner, v->node, mid, end);
        w->whole[i].corner = corner[0] == v->node ? 0 : corner[1] == v->node ? 1 : 2;
        for (int j = 0; j < 2; j++)
            w->whole[i].mid[j] = note_mid(v, mid[j], end[j]);
    }
}

/** Compute the unit normal of a triangle; 0 if it has no area. */
static int normal_of(const double *a, const double *b, const double *c, double normal[3]) {
    double u[3], v[3], n[3];
    pl_from_to(3, a, b, u);
    pl_from_to(3, a, c, v);
    pl_cross(u, v, n);
    const double length = pl_length(n), inverse = 1 / length;
    for (int d = 0; d < 3; d++)
        normal[d] = n[d] * inverse;
    return length > 0;
}

/** Compute the normals of all triangles; x: of each facet its nodes. Returns whether all have an area. */
static int find_normals(const struct pl_skin_wholes *w, const double (*x)[6][3],
                        double (*normal)[3]) {
    int have = 1;
    for (int i = 0; i < 4 * w->n; i++) {
        const uint8_t *node = w->whole[i / 4].node[i % 4];
        const double(*at)[3] = x[i / 4];
        have &= normal_of(at[node[0]], at[node[1]], at[node[2]], normal[i]);
    }
    return have;
}

/** Find what is across the edges of triangle i of the visit. */
static void find_beside(const pl_skin_visit *v, int i) {
    const pl_skin *skin = v->skin;
    const planish_shape *shape = skin->shape;
    whole_of *of = &v->wholes->whole[i / 4];
    for (int k = 0; k < 3; k++) {
        const int32_t other = shape->across[v->facet[i]][k];
        int32_t at = -1;
        for (int j = 0; other >= 0 && j < v->n && at < 0; j++)
            at = v->facet[j] == other ? j : -1;
        of->beside[i % 4][k] = at;
        of->beyond[i % 4][k] = at < 0 ? other : -1;
        if (of->beyond[i % 4][k] < 0)
            continue;
        double x[3][3];
        for (int j = 0; j < 3; j++)
            pl_skin_place_of(skin, shape->facet[other][j], x[j]);
        normal_of(x[0], x[1], x[2], of->normal[i % 4][k]);
    }
}

/** Learn where the facets around the node are. */
static void gather(pl_skin_visit *v) {
    const pl_skin *skin = v->skin;
    struct pl_skin_wholes *w = v->wholes;
    for (int i = 0; i < w->n; i++) {
        whole_of *of = &w->whole[i];
        const int32_t *node = skin->shape->whole[v->facet[4 * i] / 4];
        for (int j = 0; j < 6; j++) {
            pl_skin_place_of(skin, node[j], of->x[j]);
            of->place[j] = pl_skin_present_place(skin, node[j]);
            memcpy(w->moved[i][j], of->x[j], sizeof of->x[j]);
        }
        for (int k = 0; k < 4; k++)
            pl_find_quarter(skin->shape, v->facet[4 * i + k], of->node[k]);
    }
    for (int i = 0; i < v->n; i++)
        find_beside(v, i);
    find_normals(w, (const double(*)[6][3])w->moved, w->before);
}

/** Bring the nodes of the facets to where they are on trial. */
static void move_nodes(const pl_skin_visit *v, const pl_skin_trial *trial) {
    struct pl_skin_wholes *w = v->wholes;
    for (int i = 0; i < w->n; i++) {
        const whole_of *of = &w->whole[i];
        const int at[2] = {3 + of->corner, 3 + (of->corner + 2) % 3};
        memcpy(w->moved[i], of->x, sizeof of->x);
        memcpy(w->place[i], of->place, sizeof of->place);
        for (int d = 0; d < 3; d++)
            w->moved[i][of->corner][d] = trial->x[d] * v->skin->shape->scale;
        w->place[i][of->corner] = trial->place;
        for (int j = 0; j < 2; j++) {
            memcpy(w->moved[i][at[j]], trial->mid[of->mid[j]].x, sizeof w->moved[i][at[j]]);
            w->place[i][at[j]] = trial->mid[of->mid[j]].place;
        }
    }
}

/** Whether the triangles keep their normals, about, and smooth edges bend little, or no more than they
 *  did. */
static int keeps_normals(const pl_skin_visit *v, const pl_skin_trial *trial) {
    const struct pl_skin_wholes *w = v->wholes;
    if (!find_normals(w, (const double(*)[6][3])w->moved, trial->normal))
        return 0;
    for (int i = 0; i < v->n; i++) {
        const whole_of *of = &w->whole[i / 4];
        const double *normal = trial->normal[i];
        if (!(pl_dot(3, normal, v->skin->shape->normal[v->facet[i]]) >= TURN))
            return 0;
        for (int k = 0; k < 3; k++) {
            const int32_t beside = of->beside[i % 4][k];
            const double *there = of->normal[i % 4][k], *was = there;
            if (beside < 0 && of->beyond[i % 4][k] < 0)
                continue;
            if (beside >= 0) {
                there = trial->normal[beside];
                was = w->before[beside];
            }
            const double now = pl_dot(3, normal, there);
            if (!(now >= PL_SKIN_BEND || now >= pl_dot(3, w->before[i], was)))
                return 0;
        }
    }
    return 1;
}

/** Whether the facets stay within their tolerance: their bounds are in trial. */
static int keeps_near(const pl_skin_visit *v, const pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    const struct pl_skin_wholes *w = v->wholes;
    const int is_exact = skin->moves[v->node] == PLANISH_CONSTRAINT_ON_PLANE;
    for (int i = 0; i < w->n; i++) {
        const int32_t facet = v->facet[4 * i];
        const double(*x)[3] = (const double(*)[3])w->moved[i];
        int is_planar = is_exact;
        for (int k = 0; k < 4; k++)
            is_planar &= skin->is_planar[facet + k];
        const double(*before)[3] = (const double(*)[3])w->whole[i].x;
        double bound = skin->bound[facet] + (is_planar ? 0 : pl_whole_way(before, x));
        if (!(bound <= skin->tolerance[facet]))
            bound = certify(skin->shape, facet, x, w->place[i], skin->tolerance[facet]);
        if (!(bound <= skin->tolerance[facet]))
            return 0;
        for (int k = 0; k < 4; k++)
            trial->bound[4 * i + k] = bound;
    }
    return 1;
}

int pl_skin_mids_try(pl_skin_visit *v, pl_skin_trial *trial) {
    const struct pl_skin_wholes *w = v->wholes;
    if (!v->has_rim)
        gather(v);
    v->has_rim = 1;
    for (int i = 0; i < w->n_mids; i++)
        find_mid(v->skin, w->mid[i].mid, w->mid[i].is_placed, v->node, trial->x, &trial->mid[i]);
    move_nodes(v, trial);
    return keeps_normals(v, trial) && keeps_near(v, trial);
}

/** The trial, of those known, that has the node at x; NULL: there is none. */
static const pl_skin_trial *find_trial(const pl_skin_visit *v, const double *x) {
    for (int i = 0; i < PL_SKIN_TRIALS; i++)
        if (v->trial[i].is_known && pl_skin_is_at(v->trial[i].x, x))
            return &v->trial[i];
    return NULL;
}

int pl_skin_move_mids(pl_skin_visit *v) {
    const pl_skin *skin = v->skin;
    const struct pl_skin_wholes *w = v->wholes;
    if (!skin->shape->whole)
        return 0;
    const double *x = skin->coordinates + (int64_t)skin->inner[v->node] * 3;
    const pl_skin_trial *trial = pl_skin_is_at(x, v->start) ? NULL : find_trial(v, x);
    int any = 0;
    for (int i = 0; i < w->n_mids; i++) {
        const double *own = trial ? trial->mid[i].own : w->mid[i].before;
        double *now = own_of(skin, w->mid[i].mid);
        any |= !pl_skin_is_at(own, now);
        memcpy(now, own, 3 * sizeof *own);
    }
    return any;
}

void pl_skin_mids_take(const pl_skin_visit *v) {
    for (int i = 0; i < v->wholes->n_mids; i++)
        pl_skin_set_place(v->skin, v->wholes->mid[i].mid, &v->trial[0].mid[i].place);
}
