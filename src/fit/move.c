/* move: nodes go to their places as far as their elements stay valid.
 *
 * First all go at once, as thin elements with all corners on the surface ask for: where an element or facet
 * says no, its nodes go half as far. Then one after the other goes as far as its elements let it. */
#include "fit/move.h"

#include "base/parallel.h"
#include "fit/places.h"
#include "geometry/simplex.h"

#include <math.h>
#include <string.h>

/* Steps are tried at the whole way, at half of it, and so on. */
enum { HALVINGS = 6, CHUNK = 256 };
/* In a round the least det J of an element falls to this part of what it was. */
#define FALL 0.2
/* What is no farther off is there, in sizes of the other shape. */
#define ROUNDING 0x1p-44
/* A facet at a node on a patch stays within this of the patch's normal there: cosine. */
#define UPRIGHT 0.3

/** Elements of one type, to be looked at together. */
typedef struct batch {
    int n;
    int32_t element[PL_JACOBIAN_LANES];
    double x[PL_JACOBIAN_LANES][PL_CELL_CORNERS * 3];
    double size[PL_JACOBIAN_LANES];  /* longest side of the box, cubed */
    double least[PL_JACOBIAN_LANES]; /* det J of a corner, in that size; 0: not valid */
} batch;

/** Copy the corners of an element, in own's unit. */
static void gather(const planish_fit *fit, const pl_points *points, int32_t element, batch *b) {
    const pl_fit_element *e = &fit->element[element];
    const int n = fit->rule[e->type]->type->shape->n_corners;
    double *to = b->x[b->n], longest = 0;
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int k = 0; k < n; k++) {
        pl_fit_at(points, e->node[k], fit->own->scale, to + 3 * k);
        for (int d = 0; d < 3; d++) {
            low[d] = fmin(low[d], to[3 * k + d]);
            high[d] = fmax(high[d], to[3 * k + d]);
        }
    }
    for (int d = 0; d < 3; d++)
        longest = fmax(longest, high[d] - low[d]);
    b->size[b->n] = longest * longest * longest;
    b->element[b->n++] = element;
}

/** Judge the elements of a batch, at least one. */
static void judge(const planish_fit *fit, pl_jacobian_block *block, batch *b) {
    static const int32_t CORNERS[PL_CELL_CORNERS] = {0, 1, 2, 3, 4, 5, 6, 7};
    const pl_jacobian_rule *rule = fit->rule[fit->element[b->element[0]].type];
    double sign[PL_JACOBIAN_LANES];
    for (int l = 0; l < PL_JACOBIAN_LANES; l++) {
        const int from = l < b->n ? l : 0;
        sign[l] = fit->element[b->element[from]].sign;
        for (int i = 0; i < rule->n_nodes * 3; i++)
            block->x[i / 3][i % 3][l] = b->x[from][i];
    }
    pl_jacobian_evaluate(rule, sign, block);
    for (int l = 0; l < b->n; l++) {
        double least = INFINITY;
        for (int k = 0; k < rule->n_corners; k++)
            least = fmin(least, block->coefficient[rule->corner[k]][l] / b->size[l]);
        const int is_valid =
            pl_validity_of_lane(rule, block, l, CORNERS, b->x[l], sign[l]) == PL_VALID;
        b->least[l] = is_valid && least > 0 ? least : 0;
    }
}

/** Whether an element may be so: least det J of a corner, in its size. */
static int may_be(const planish_fit *fit, int32_t element, double least, double floor) {
    const double was = fit->least[element];
    return least > 0 && least >= fmin(was, fmax(FALL * was, floor));
}

/** Whether the elements of a node are valid and above their floors. */
static int keeps_elements(const planish_fit *fit, const pl_points *points, int32_t node,
                          double floor) {
    batch b = {.n = 0};
    const int64_t end = fit->offset[node + 1];
    for (int64_t i = fit->offset[node]; i < end; i++) {
        const int32_t element = fit->element_of[i];
        gather(fit, points, element, &b);
        if (i + 1 < end && b.n < PL_JACOBIAN_LANES &&
            fit->element[fit->element_of[i + 1]].type == fit->element[element].type)
            continue;
        judge(fit, fit->block[0], &b);
        for (int l = 0; l < b.n; l++)
            if (!may_be(fit, b.element[l], b.least[l], floor))
                return 0;
        b.n = 0;
    }
    return 1;
}

/** Return the least cosine between the facets of a node on a patch and the patch's normal at its place; 1 for
 *  other nodes. */
static double least_cosine(const planish_fit *fit, const pl_points *points, int32_t node) {
    const planish_shape *own = fit->own;
    double least = 1;
    for (int64_t i = own->offset[node]; fit->kind[node] == PL_ON_PATCH && i < own->offset[node + 1];
         i++) {
        const int32_t facet = own->facet_of[i], *v = own->facet[facet];
        double x[3][3], a[3], b[3], normal[3];
        if (!pl_fit_is_outer(own, facet))
            continue;
        for (int k = 0; k < 3; k++)
            pl_fit_at(points, own->node[v[k]], own->scale, x[k]);
        pl_from_to(3, x[0], x[1], a);
        pl_from_to(3, x[0], x[2], b);
        pl_cross(a, b, normal);
        const double cosine = pl_dot(3, normal, fit->direction[node]) / pl_length(normal);
        least = cosine < least ? cosine : least;
    }
    return least;
}

/* ---- all at once ----------------------------------------------------------------------------- */

/** A step of all nodes. */
typedef struct step {
    planish_fit *fit;
    const pl_points *points;
    double floor;
    int is_start; /* learn what elements are; else mark the nodes of those that may not be so */
    int64_t n_marked;
} step;

/** Look at a stretch of elements. */
static void look(void *context, int64_t begin, int64_t end, int thread) {
    step *s = context;
    planish_fit *fit = s->fit;
    batch b = {.n = 0};
    for (int64_t i = begin; i < end; i++) {
        gather(fit, s->points, (int32_t)i, &b);
        if (i + 1 < end && b.n < PL_JACOBIAN_LANES &&
            fit->element[i + 1].type == fit->element[i].type)
            continue;
        judge(fit, fit->block[thread], &b);
        for (int l = 0; l < b.n; l++) {
            const pl_fit_element *e = &fit->element[b.element[l]];
            if (s->is_start) {
                fit->least[b.element[l]] = b.least[l];
                continue;
            }
            const int n = fit->rule[e->type]->type->shape->n_corners;
            for (int k = 0; k < n && !may_be(fit, b.element[l], b.least[l], s->floor); k++)
                if (fit->own->number[e->node[k]] >= 0)
                    pl_set_flag(&fit->is_marked[fit->own->number[e->node[k]]], 1);
        }
        b.n = 0;
    }
}

/** Mark the nodes on patches whose facets lean over more than they may. */
static void look_at_facets(void *context, int64_t begin, int64_t end, int thread) {
    const step *s = context;
    planish_fit *fit = s->fit;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const double cosine =
            fit->state[i] == PL_FIT_PLACED ? least_cosine(fit, s->points, (int32_t)i) : 1;
        if (s->is_start)
            fit->cosine[i] = cosine;
        else if (!(cosine >= fmin(UPRIGHT, fit->cosine[i])))
            pl_set_flag(&fit->is_marked[i], 1);
    }
}

static void look_at_all(step *s, int is_start) {
    planish_fit *fit = s->fit;
    s->is_start = is_start;
    memset(fit->is_marked, 0, (size_t)fit->n_nodes);
    pl_parallel_for(fit->threads, fit->n_elements, CHUNK, look, s);
    pl_parallel_for(fit->threads, fit->n_nodes, CHUNK, look_at_facets, s);
}

/** Bring a node to a part of the way from where the round began. */
static void place(planish_fit *fit, const pl_points *points, double *coordinates, int32_t node,
                  double part) {
    const double *from = fit->from[node], *goal = fit->goal[node];
    for (int d = 0; d < 3; d++)
        coordinates[pl_point_at(points, fit->own->node[node], d)] =
            part == 0  ? from[d]
            : part < 1 ? pl_store(&fit->storage, from[d] + part * (goal[d] - from[d]))
                       : goal[d];
}

/** Whether a node has a place that it is not at. */
static int is_on_its_way(const planish_fit *fit, int32_t node) {
    return fit->state[node] == PL_FIT_PLACED && !fit->is_there[node];
}

/** Move all nodes as far as may be. */
static void move_all(step *s, double *coordinates) {
    planish_fit *fit = s->fit;
    for (int32_t i = 0; i < fit->n_nodes; i++) {
        pl_fit_at(s->points, fit->own->node[i], 1, fit->from[i]);
        fit->part[i] = is_on_its_way(fit, i) ? 1 : 0;
    }
    for (int n_marked = 1; n_marked > 0;) {
        for (int32_t i = 0; i < fit->n_nodes; i++)
            if (is_on_its_way(fit, i))
                place(fit, s->points, coordinates, i, fit->part[i]);
        look_at_all(s, 0);
        n_marked = 0;
        for (int32_t i = 0; i < fit->n_nodes; i++)
            if (fit->is_marked[i] && fit->part[i] > 0) {
                fit->part[i] *= fit->part[i] > 1. / (1 << (HALVINGS - 1)) ? 0.5 : 0;
                n_marked++;
            }
    }
}

/* ---- one after the other --------------------------------------------------------------------- */

/** Move a node on from where it is. Returns the part of the rest of its way that it has gone. */
static double move(planish_fit *fit, const pl_points *points, double *coordinates, double floor,
                   int32_t node) {
    double part = 1;
    pl_fit_at(points, fit->own->node[node], 1, fit->from[node]);
    const double before = least_cosine(fit, points, node);
    for (int i = 0; i < HALVINGS; i++, part *= 0.5) {
        place(fit, points, coordinates, node, part);
        if (least_cosine(fit, points, node) >= fmin(UPRIGHT, before) &&
            keeps_elements(fit, points, node, floor))
            return part;
    }
    place(fit, points, coordinates, node, 0);
    return 0;
}

double pl_fit_round(planish_fit *fit, const pl_points *points, double *coordinates, double floor) {
    step s = {.fit = fit, .points = points, .floor = floor};
    double most = 0;
    look_at_all(&s, 1);
    move_all(&s, coordinates);
    for (int32_t i = 0; i < fit->n_nodes; i++) {
        double part = fit->part[i];
        if (is_on_its_way(fit, i) && part < 1)
            part += (1 - part) * move(fit, points, coordinates, floor, i);
        most = fmax(most, part);
    }
    return most;
}

/* ---- where nodes are ------------------------------------------------------------------------- */

/** Return how far a node is from its goal, and set x to where it is, in the mesh's units. */
static double way_of(const planish_fit *fit, const pl_points *points, int32_t node, double x[3]) {
    double way[3];
    pl_fit_at(points, fit->own->node[node], 1, x);
    for (int d = 0; d < 3; d++) /* scaled, as squares of lengths in other units may be no numbers */
        way[d] = fit->goal[node][d] * fit->onto->scale - x[d] * fit->onto->scale;
    return pl_length(way) / fit->onto->scale;
}

/** Whether a node so far from its goal is there. */
static int is_at_goal(const planish_fit *fit, double off) {
    return off <= ROUNDING * fit->onto->size / fit->onto->scale;
}

static void find_staying(void *context, int64_t begin, int64_t end, int thread) {
    const step *s = context;
    planish_fit *fit = s->fit;
    (void)thread;
    for (int32_t i = (int32_t)begin; i < end; i++) {
        double x[3];
        if (fit->state[i] == PL_FIT_PLACED && fit->is_there[i] &&
            !is_at_goal(fit, way_of(fit, s->points, i, x)))
            fit->is_there[i] = fit->slides[i] && pl_fit_is_place(fit, i, x);
    }
}

void pl_fit_stay(planish_fit *fit, const pl_points *points) {
    step s = {.fit = fit, .points = points};
    pl_parallel_for(fit->threads, fit->n_nodes, CHUNK, find_staying, &s);
}

int64_t pl_fit_arrive(planish_fit *fit, const pl_points *points, double *farthest) {
    int64_t n = 0;
    double most = 0;
    for (int32_t i = 0; i < fit->n_nodes; i++) {
        double x[3];
        if (!is_on_its_way(fit, i))
            continue;
        const double off = way_of(fit, points, i, x);
        fit->is_there[i] = (uint8_t)is_at_goal(fit, off);
        if (fit->is_there[i])
            continue;
        n++;
        most = fmax(most, off);
    }
    if (farthest)
        *farthest = most;
    return n;
}
