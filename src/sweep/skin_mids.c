/* skin_mids: visits of corners of facets of second order.
 *
 * When such a corner moves, the mids of its edges follow by half of the way, and centres of facets by a
 * quarter, as all mids do, and go from there to the nearest place of the shape. So a mid is where it was
 * first if its corners are, and no mid moves whose corners stay. All triangles of each facet at the corner
 * change.
 *
 * A facet is off the shape by what its triangles are (shape/overlay.h), and by no more than its
 * points have gone (pl_whole_way), in all or since it was certified.
 */
#include "sweep/skin.h"

#include "base/memory.h"
#include "shape/overlay.h"

#include <math.h>
#include <string.h>

/* As in skin.c. */
#define ROUNDED_UP (1 + 0x1p-40)

/** A node that follows the node of a visit: the mid of an edge, or the centre of a facet. */
typedef struct mid_of {
    int32_t mid;
    int is_placed;
    double before[3]; /* own, when the visit began */
} mid_of;

/** A facet of second order at the node. */
typedef struct whole_of {
    const pl_whole *whole;
    int first;                   /* number in the visit of its first triangle */
    double x[PL_WHOLE_NODES][3]; /* nodes where they are when the visit begins */
    pl_place place[PL_WHOLE_NODES];
    int corner; /* the node, as a place in x */
    int n_followers;
    int follower[PL_WHOLE_FOLLOWERS];  /* those of the node, as places in x, */
    int mid[PL_WHOLE_FOLLOWERS];       /* and their numbers in the visit */
    int32_t beside[PL_WHOLE_PARTS][3]; /* triangles of the visit across the edges of its own;
                                                  -1: none, or a feature; */
    int32_t beyond[PL_WHOLE_PARTS][3]; /* or of others, and their unit normals */
    double normal[PL_WHOLE_PARTS][3][3];
    uint8_t node[PL_WHOLE_PARTS][3]; /* of its triangles, as places in x */
} whole_of;

struct pl_skin_wholes {
    int n_mids, n;
    mid_of *mid;                        /* [n_mids] */
    whole_of *whole;                    /* [n] */
    double (*before)[3];                /* unit normals of all triangles when the visit began */
    pl_mid_trial *trial;                /* [PL_SKIN_TRIALS][most mids] */
    double (*moved)[PL_WHOLE_NODES][3]; /* [n] nodes on trial */
    pl_place (*place)[PL_WHOLE_NODES];
};

/* ---- room ------------------------------------------------------------------------------------- */

/** Most nodes that follow one corner. */
static int64_t most_mids(const pl_skin *skin) {
    return PL_WHOLE_FOLLOWERS * skin->max_facets;
}

int pl_skin_mids_make(pl_skin *skin) {
    const int64_t n = skin->max_facets;
    int done = 1;
    if (!skin->shape->whole)
        return 1;
    skin->mid_number = pl_alloc_zero(skin->shape->n_nodes, sizeof *skin->mid_number);
    skin->wholes = pl_alloc_zero(skin->threads, sizeof *skin->wholes);
    for (int t = 0; skin->wholes && t < skin->threads; t++) {
        struct pl_skin_wholes *w = &skin->wholes[t];
        w->mid = pl_alloc(most_mids(skin), sizeof *w->mid);
        w->whole = pl_alloc(n, sizeof *w->whole);
        w->before = pl_alloc(n, sizeof *w->before);
        w->trial = pl_alloc(PL_SKIN_TRIALS * most_mids(skin), sizeof *w->trial);
        w->moved = pl_alloc(n, sizeof *w->moved);
        w->place = pl_alloc(n, sizeof *w->place);
        done = done && w->mid && w->whole && w->before && w->trial && w->moved && w->place;
    }
    return skin->wholes && skin->mid_number && done;
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
    pl_free(skin->mid_number);
    skin->wholes = NULL;
}

void pl_skin_mids_prepare(const pl_skin *skin, int thread, pl_skin_visit *v) {
    if (!skin->wholes)
        return;
    v->wholes = &skin->wholes[thread];
    for (int i = 0; i < PL_SKIN_TRIALS; i++)
        v->trial[i].mid = v->wholes->trial + i * most_mids(skin);
}

/* ---- places of mids --------------------------------------------------------------------------- */

int pl_skin_is_placed(const pl_skin *skin, int32_t mid, const int32_t *parent, int n) {
    const planish_shape *shape = skin->shape;
    int is_moved = 0;
    for (int k = 0; k < n; k++)
        is_moved |= skin->moves[parent[k]] == PLANISH_CONSTRAINT_ON_PATCH ||
                    skin->moves[parent[k]] == PLANISH_CONSTRAINT_ON_CURVE;
    return is_moved && (shape->node_class[mid] == PL_ON_CURVE ||
                        (shape->node_class[mid] == PL_ON_PATCH &&
                         !skin->is_planar[shape->facet_of[shape->offset[mid]]]));
}

/** Whether a node of a facet, at a place of it, goes to the shape. */
static int is_placed(const pl_skin *skin, const pl_whole *whole, int place) {
    int32_t parent[4];
    int at[4];
    const int n = pl_whole_parents(whole, place, at);
    for (int k = 0; k < n; k++)
        parent[k] = whole->node[at[k]];
    return pl_skin_is_placed(skin, whole->node[place], parent, n);
}

/** Find the mean of the ways of the nodes that a mid is between, node (-1: none) being at x. Returns whether
 *  any of them is not where it was. */
static int find_way(const pl_skin *skin, int32_t mid, int32_t node, const double *x,
                    double way[3]) {
    const pl_mids *m = skin->mids;
    const planish_plan *plan = skin->plan;
    const int32_t *parent;
    const int n = pl_mid_parents(m, skin->shape->node[mid], &parent);
    int any = 0;
    memset(way, 0, 3 * sizeof *way);
    for (int j = 0; j < n; j++) {
        const int32_t inner = plan->inner[parent[j]];
        const double *now =
            node >= 0 && inner == skin->inner[node] ? x : skin->coordinates + (int64_t)inner * 3;
        for (int d = 0; d < 3; d++) {
            const double part = now[d] - m->given[(int64_t)parent[j] * 3 + d];
            way[d] = j == 0 ? part : way[d] + part;
            any |= part != 0;
        }
    }
    for (int d = 0; d < 3 && n > 0; d++)
        way[d] /= n;
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
        at[d] = pl_mid_coordinate_by(m, of_mesh, d, way[d], 0) * shape->scale;
    }
    if (trial->place.at >= 0)
        pl_shape_walk(shape, node_class, at, &trial->place);
    if (has_moved && is_placed && trial->place.at >= 0) {
        pl_shape_point(shape, node_class, &trial->place, at, direction);
        for (int d = 0; d < 3; d++) {
            const double start = m->start.x[pl_point_at(&m->start, of_mesh, d)];
            trial->own[d] = at[d] * skin->unscale - start - way[d];
        }
    }
    for (int d = 0; d < 3; d++)
        trial->x[d] = pl_mid_coordinate_by(m, of_mesh, d, way[d], trial->own[d]) * shape->scale;
}

static double *own_of(const pl_skin *skin, int32_t mid) {
    return skin->mids->own + (int64_t)skin->shape->node[mid] * 3;
}

void pl_skin_place_mids(pl_skin *skin, int32_t node) {
    const planish_shape *shape = skin->shape;
    int64_t n = 0;
    const int32_t *facet = pl_shape_star(shape, node, &n);
    for (int64_t i = 0; shape->whole && skin->mids->own && i < n;
         i += pl_shape_parts(shape, facet[i])) {
        const pl_whole *whole = pl_whole_of(shape, facet[i]);
        int follower[PL_WHOLE_FOLLOWERS];
        const int n_followers = pl_whole_followers(whole, node, follower);
        for (int j = 0; j < n_followers; j++) {
            const int32_t mid = whole->node[follower[j]];
            pl_mid_trial trial;
            find_mid(skin, mid, is_placed(skin, whole, follower[j]), -1, NULL, &trial);
            memcpy(own_of(skin, mid), trial.own, sizeof trial.own);
            pl_skin_set_place(skin, mid, &trial.place);
        }
    }
}

/* ---- distances -------------------------------------------------------------------------------- */

/** Bound how far a facet of second order is off the shape with its nodes at x, and there in place; infinite: not
 *  known, or above limit. */
static double certify(const planish_shape *shape, const pl_whole *whole, const double x[][3],
                      const pl_place *place, double limit) {
    double most = 0, first[PL_WHOLE_NODES][3];
    pl_whole_nodes(shape, whole, first);
    const double way = pl_whole_way(whole, (const double(*)[3])first, x);
    if (way <= limit)
        return way;
    for (int32_t f = whole->first; f < whole->first + whole->n_parts; f++) {
        pl_moved_facet moved = {.facet = f};
        uint8_t node[3];
        pl_find_part(shape, f, node);
        pl_set_rises(shape, x, &moved);
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
    const pl_whole *whole = pl_whole_of(skin->shape, facet);
    double x[PL_WHOLE_NODES][3];
    pl_place place[PL_WHOLE_NODES];
    for (int i = 0; i < whole->n_nodes; i++) {
        pl_skin_place_of(skin, whole->node[i], x[i]);
        place[i] = pl_skin_present_place(skin, whole->node[i]);
    }
    return certify(skin->shape, whole, (const double(*)[3])x, place, skin->tolerance[whole->first]);
}

/* ---- visits ----------------------------------------------------------------------------------- */

/** Note a node, at a place of a facet, that follows the node; returns its number. */
static int note_mid(const pl_skin_visit *v, const pl_whole *whole, int place) {
    const pl_skin *skin = v->skin;
    struct pl_skin_wholes *w = v->wholes;
    const int32_t mid = whole->node[place];
    int32_t *number = &skin->mid_number[mid];
    if (*number < w->n_mids && w->mid[*number].mid == mid)
        return *number;
    *number = w->n_mids;
    w->mid[w->n_mids] = (mid_of){.mid = mid, .is_placed = is_placed(skin, whole, place)};
    memcpy(w->mid[w->n_mids].before, own_of(skin, mid), sizeof w->mid[w->n_mids].before);
    return w->n_mids++;
}

void pl_skin_mids_begin(pl_skin_visit *v) {
    const planish_shape *shape = v->skin->shape;
    struct pl_skin_wholes *w = v->wholes;
    w->n = w->n_mids = 0;
    for (int i = 0; i < v->n; i += pl_shape_parts(shape, v->facet[i])) {
        whole_of *of = &w->whole[w->n++];
        of->whole = pl_whole_of(shape, v->facet[i]);
        of->first = i;
        of->corner = pl_whole_place(of->whole, v->node);
        of->n_followers = pl_whole_followers(of->whole, v->node, of->follower);
        for (int j = 0; j < of->n_followers; j++)
            of->mid[j] = note_mid(v, of->whole, of->follower[j]);
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
static int find_normals(const struct pl_skin_wholes *w, const double (*x)[PL_WHOLE_NODES][3],
                        double (*normal)[3]) {
    int have = 1;
    for (int i = 0; i < w->n; i++)
        for (int k = 0; k < w->whole[i].whole->n_parts; k++) {
            const uint8_t *node = w->whole[i].node[k];
            have &= normal_of(x[i][node[0]], x[i][node[1]], x[i][node[2]],
                              normal[w->whole[i].first + k]);
        }
    return have;
}

/** Find what is across the edges of triangle `part` of a facet. */
static void find_beside(const pl_skin_visit *v, whole_of *of, int part) {
    const pl_skin *skin = v->skin;
    const planish_shape *shape = skin->shape;
    for (int k = 0; k < 3; k++) {
        const int32_t other = shape->across[v->facet[of->first + part]][k];
        const int32_t at = other < 0 ? -1 : pl_skin_number_of(v, other);
        of->beside[part][k] = at;
        of->beyond[part][k] = at < 0 ? other : -1;
        if (of->beyond[part][k] < 0)
            continue;
        double x[3][3];
        for (int j = 0; j < 3; j++)
            pl_skin_place_of(skin, shape->facet[other][j], x[j]);
        normal_of(x[0], x[1], x[2], of->normal[part][k]);
    }
}

/** Learn where the facets around the node are. */
static void gather(pl_skin_visit *v) {
    const pl_skin *skin = v->skin;
    struct pl_skin_wholes *w = v->wholes;
    for (int i = 0; i < w->n; i++) {
        whole_of *of = &w->whole[i];
        const pl_whole *whole = of->whole;
        for (int j = 0; j < whole->n_nodes; j++) {
            pl_skin_place_of(skin, whole->node[j], of->x[j]);
            of->place[j] = pl_skin_present_place(skin, whole->node[j]);
            memcpy(w->moved[i][j], of->x[j], sizeof of->x[j]);
        }
        for (int k = 0; k < whole->n_parts; k++) {
            pl_find_part(skin->shape, whole->first + k, of->node[k]);
            find_beside(v, of, k);
        }
    }
    find_normals(w, (const double(*)[PL_WHOLE_NODES][3])w->moved, w->before);
}

/** Bring the nodes of the facets to where they are on trial. */
static void move_nodes(const pl_skin_visit *v, const pl_skin_trial *trial) {
    struct pl_skin_wholes *w = v->wholes;
    for (int i = 0; i < w->n; i++) {
        const whole_of *of = &w->whole[i];
        memcpy(w->moved[i], of->x, sizeof of->x);
        memcpy(w->place[i], of->place, sizeof of->place);
        for (int d = 0; d < 3; d++)
            w->moved[i][of->corner][d] = trial->x[d] * v->skin->shape->scale;
        w->place[i][of->corner] = trial->place;
        for (int j = 0; j < of->n_followers; j++) {
            double *to = w->moved[i][of->follower[j]];
            memcpy(to, trial->mid[of->mid[j]].x, sizeof trial->mid->x);
            w->place[i][of->follower[j]] = trial->mid[of->mid[j]].place;
        }
    }
}

/** Whether triangle `part` of a facet bends the smooth edges at it little, or no more than it did. */
static int keeps_edges(const pl_skin_visit *v, const pl_skin_trial *trial, const whole_of *of,
                       int part) {
    const struct pl_skin_wholes *w = v->wholes;
    const double *normal = trial->normal[of->first + part];
    for (int k = 0; k < 3; k++) {
        const int32_t beside = of->beside[part][k];
        const double *there = of->normal[part][k], *was = there;
        if (beside < 0 && of->beyond[part][k] < 0)
            continue;
        if (beside >= 0) {
            there = trial->normal[beside];
            was = w->before[beside];
        }
        const double now = pl_dot(3, normal, there);
        if (!(now >= PL_SKIN_BEND || now >= pl_dot(3, w->before[of->first + part], was)))
            return 0;
    }
    return 1;
}

/** Whether the triangles keep their normals, about, and smooth edges bend little, or no more than they
 *  did. */
static int keeps_normals(const pl_skin_visit *v, const pl_skin_trial *trial) {
    const struct pl_skin_wholes *w = v->wholes;
    if (!find_normals(w, (const double(*)[PL_WHOLE_NODES][3])w->moved, trial->normal))
        return 0;
    for (int i = 0; i < v->n; i++)
        if (!pl_skin_keeps_turn(v, trial, i))
            return 0;
    for (int i = 0; i < w->n; i++)
        for (int k = 0; k < w->whole[i].whole->n_parts; k++)
            if (!keeps_edges(v, trial, &w->whole[i], k))
                return 0;
    return 1;
}

/** Whether the facets stay within their tolerance: their bounds are in trial. */
static int keeps_near(const pl_skin_visit *v, const pl_skin_trial *trial) {
    const pl_skin *skin = v->skin;
    const struct pl_skin_wholes *w = v->wholes;
    const int is_exact = skin->moves[v->node] == PLANISH_CONSTRAINT_ON_PLANE;
    for (int i = 0; i < w->n; i++) {
        const pl_whole *whole = w->whole[i].whole;
        const int32_t facet = whole->first;
        const double(*x)[3] = (const double(*)[3])w->moved[i];
        int is_planar = is_exact;
        for (int k = 0; k < whole->n_parts; k++)
            is_planar &= skin->is_planar[facet + k];
        const double(*before)[3] = (const double(*)[3])w->whole[i].x;
        double bound = skin->bound[facet] + (is_planar ? 0 : pl_whole_way(whole, before, x));
        if (!(bound <= skin->tolerance[facet]))
            bound = certify(skin->shape, whole, x, w->place[i], skin->tolerance[facet]);
        if (!(bound <= skin->tolerance[facet]))
            return 0;
        for (int k = 0; k < whole->n_parts; k++)
            trial->bound[w->whole[i].first + k] = bound;
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
