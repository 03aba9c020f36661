/* joint: steps of a patch. */
#include "improve/joint.h"
#include "improve/maxmin.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"
#include "geometry/slope.h"
#include "quality/measure_block.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    ELEMENTS = 1000, /* of a patch, at most */
    ROWS = 1000,
    VARIABLES = 3 * PL_JOINT_NODES,
    STEPS = 8,  /* of one try */
    TRIALS = 4, /* of one step */
    SOLVES = 6  /* of one trial, until the step is as long as its radius */
};

/* Rows of elements up to so much better than the least are in a problem: radians, or parts of 1. */
#define BAND 0.35
/* Steps aim at no more than this beyond the least, and beyond what is wanted by this part of it. */
#define AIM       0.3
#define OVERSHOOT 0.02
/* Lengths of steps, in parts of the mean distance of the neighbours of a node: the longest at first and
 * at all. */
#define RADIUS      0.2
#define RADIUS_MOST 0.5
/* maxmin.h: reach at first, and at most */
#define REACH      0.1
#define REACH_MOST 1e6
/* A step is taken if it brings this part of its promise; one that brings this part lets the radius
 * double. */
#define TAKEN 0.1
#define GOOD  0.7
/* A promise below this is none; a try that brings less has not gained. */
#define NOTHING 1e-5
#define LITTLE  1e-4
/* Linearised limits are farther in than the true ones, which curved measures could exceed: by this in
 * radians, or this part of a ratio. */
#define MARGIN_ANGLE 0.01
#define MARGIN_RATIO 0.02
/** Kinds of measures, as geometry/slope.h has them. */
typedef enum measure { ANGLE, RATIO, MEAN, JACOBIAN } measure;

/** Node of a patch. */
typedef struct patch_node {
    int32_t node;
    const pl_star_slide *slide; /* NULL: it may go anywhere */
    int n, first;               /* variables */
    double direction[3][3];     /* [n] of unit length */
    double scale;               /* root mean square distance of the ring */
} patch_node;

/** Element of a patch. */
typedef struct patch_element {
    pl_joint_element of;
    int8_t own[4];     /* places of its vertices in the patch, -1: not in it */
    uint8_t is_pinned; /* not raised, only kept */
    double least;      /* where it is pinned, of the measure that is raised: limit */
    double floor;      /* D that it shall not fall below */
} patch_element;

/** Room of a thread: the patch under way. */
typedef struct pl_joint_room {
    patch_node node[PL_JOINT_NODES];
    patch_element element[ELEMENTS];
    int n_nodes, n_elements, n_variables;
    int64_t work; /* of the try: evaluations of elements */
    double kept;  /* limit of the other measure */
    double cell;  /* limit of AR^2 of cells */
    pl_maxmin_row row[ROWS];
    int element_of[ROWS];
    pl_maxmin problem;
    double x[VARIABLES], multiplier[VARIABLES + 1];
    int active[VARIABLES + 1];
    double room[2 * (VARIABLES + 1) * (VARIABLES + 1) + 5 * (VARIABLES + 1)];
} pl_joint_room;

/** Places of the nodes of a patch. */
typedef double places[PL_JOINT_NODES][3];

/* ---- measures ------------------------------------------------------------------------------- */

/** The measure that is raised (other 0), or kept (1). */
static measure measure_of(const pl_run *r, int other) {
    const planish_worst worst = r->options->worst;
    const int is_angle =
        (worst == PLANISH_WORST_ANGLE || worst == PLANISH_WORST_SCALED_JACOBIAN) != (other != 0);
    if (r->plan->work.corner)
        return is_angle ? JACOBIAN : MEAN;
    return is_angle ? ANGLE : RATIO;
}

/** Value of a measure whose limit is square: 1 / sin^2 of an acute angle, or 1 / measure^2. */
static double value_of_square(measure kind, double square) {
    if (!(square < INFINITY))
        return 0;
    return kind == ANGLE ? pl_angle_between(1, sqrt(fmax(square - 1, 0))) : 1 / sqrt(square);
}

double pl_joint_value_of(const pl_run *r, double square) {
    return value_of_square(measure_of(r, 0), square);
}

/** Find the vertices x of an element, in the scale of measuring. */
static void find_vertices(const pl_joint *joint, const pl_joint_element *e, double x[4][3]) {
    const int dim = joint->run->plan->dim;
    for (int v = 0; v <= dim; v++)
        for (int d = 0; d < dim; d++)
            x[v][d] = pl_joint_place(joint, e->node[v])[d] * joint->run->measure_scale;
}

/** Compute the measures of a kind; return how many. */
static int measures_of(const pl_run *r, measure kind, uint8_t form, const double x[4][3],
                       int derive, pl_slope slope[]) {
    const int dim = r->plan->dim;
    const pl_corner_form *of = &r->plan->form[form];
    if (kind == ANGLE)
        return dim == 3 ? pl_angle_slopes(3, x, derive, slope)
                        : pl_angle_slopes(2, x, derive, slope);
    if (kind == JACOBIAN)
        return pl_jacobian_slopes(dim, x, of, pl_corner_kind(form) == PL_KIND_SIMPLEX, derive,
                                  slope);
    if (kind == MEAN)
        pl_mean_slope(dim, x, of, derive, slope);
    else
        pl_ratio_slope(dim, x, derive, slope);
    return 1;
}

/** Return the least measure of a kind. */
static double least_measure(const pl_run *r, measure kind, uint8_t form, const double x[4][3]) {
    pl_slope slope[PL_MOST_SLOPES];
    const int n = measures_of(r, kind, form, x, 0, slope);
    double least = INFINITY;
    for (int k = 0; k < n; k++)
        least = slope[k].value < least ? slope[k].value : least;
    return least;
}

double pl_joint_value(const pl_joint *joint, const pl_joint_element *e) {
    double x[4][3] = {{0}};
    find_vertices(joint, e, x);
    return least_measure(joint->run, measure_of(joint->run, 0), e->form, (const double(*)[3])x);
}

/** D of vertices, and in *certain whether it is positive beyond doubt of rounding. */
static double determinant_of(int dim, const double x[4][3], int *certain) {
    double edge[3][3], product = 1;
    for (int j = 0; j < dim; j++) {
        double norm = 0;
        for (int d = 0; d < dim; d++) {
            edge[j][d] = x[j + 1][d] - x[0][d];
            norm += fabs(edge[j][d]);
        }
        product *= norm;
    }
    const double D = pl_determinant_of_edges(dim, (const double(*)[3])edge);
    *certain = D > (dim == 3 ? PL_ERROR_3D : PL_ERROR_2D) * product;
    return D;
}

/* ---- elements at their limits --------------------------------------------------------------- */

pl_joint_pinned pl_joint_pin(const pl_joint *joint, const pl_joint_element *e) {
    pl_joint_pinned pinned = {.value = pl_joint_value(joint, e)};
    for (int n = 0; n <= joint->run->plan->dim; n++) {
        const int64_t number = joint->mesh.number[e->node[n]];
        int i = n;
        for (; i > 0 && pinned.node[i - 1] > number; i--)
            pinned.node[i] = pinned.node[i - 1];
        pinned.node[i] = number;
    }
    return pinned;
}

int pl_joint_compare(const void *a, const void *b) {
    const pl_joint_pinned *x = a, *y = b;
    for (int i = 0; i < 4; i++)
        if (x->node[i] != y->node[i])
            return x->node[i] < y->node[i] ? -1 : 1;
    return 0;
}

/** Return the element of those at their limits, NULL: it is none. */
static const pl_joint_pinned *find_pinned(const pl_joint *joint, const pl_joint_element *e) {
    if (joint->n_pinned == 0)
        return NULL;
    const pl_joint_pinned key = pl_joint_pin(joint, e);
    return bsearch(&key, joint->pinned, (size_t)joint->n_pinned, sizeof key, pl_joint_compare);
}

/* ---- the patch ------------------------------------------------------------------------------ */

/** Set e to facet number i of the star of node. */
static void element_of_star(const pl_joint_star *star, int64_t i, int32_t node, int dim,
                            pl_joint_element *e) {
    const pl_stars *stars = star->stars;
    const int64_t first = stars->link_offset[star->at], ring = stars->ring_offset[star->at];
    const pl_link link =
        pl_link_at(&stars->link, pl_link_positions(dim, stars->form != NULL), first);
    for (int j = 0; j < dim; j++)
        e->node[j] = stars->ring[ring + pl_link_get(&link, i * dim + j)];
    e->node[dim] = node;
    e->form = stars->form ? stars->form[first + i] : 0;
    e->facet = first + i;
}

/** Write the movable nodes of an element to node; return how many. */
static int movable_nodes(const pl_joint *joint, const pl_joint_element *e, int32_t node[4]) {
    int n = 0;
    for (int v = 0; v <= joint->run->plan->dim; v++)
        if (joint->mesh.star_of[e->node[v]] != PL_JOINT_HELD)
            node[n++] = e->node[v];
    return n;
}

/** Whether the vertices of e are the nodes node [dim + 1]. */
static int has_nodes(const pl_joint_element *e, const int32_t *node, int dim) {
    for (int v = 0; v < dim; v++) { /* the last one is the star's */
        int found = 0;
        for (int j = 0; j <= dim; j++)
            found |= node[j] == e->node[v];
        if (!found)
            return 0;
    }
    return 1;
}

int pl_joint_seed(const pl_joint *joint, const int32_t *node, pl_joint_patch *patch) {
    const int dim = joint->run->plan->dim;
    int32_t first = -1;
    for (int v = 0; v <= dim && first < 0; v++)
        first = joint->mesh.star_of[node[v]] != PL_JOINT_HELD ? node[v] : -1;
    if (first < 0)
        return 0;
    const pl_joint_star star = pl_joint_star_of(joint, first);
    const int64_t n = star.stars->link_offset[star.at + 1] - star.stars->link_offset[star.at];
    *patch = (pl_joint_patch){.state = PL_JOINT_OPEN};
    for (int64_t i = 0; i < n; i++) {
        element_of_star(&star, i, first, dim, &patch->seed);
        if (!has_nodes(&patch->seed, node, dim))
            continue;
        patch->n = movable_nodes(joint, &patch->seed, patch->node);
        patch->of = pl_joint_pin(joint, &patch->seed);
        patch->value = patch->of.value;
        return patch->value < joint->wanted && !find_pinned(joint, &patch->seed);
    }
    return 0;
}

/** Set the directions of a node that slides on a plane or line. */
static void find_directions(const pl_star_slide *slide, int dim, patch_node *node) {
    const double *normal = slide->direction;
    if (slide->kind == PLANISH_CONSTRAINT_ON_LINE) {
        node->n = 1;
        memcpy(node->direction[0], normal, sizeof node->direction[0]);
        return;
    }
    node->n = dim - 1;
    if (dim == 2) {
        node->direction[0][0] = -normal[1];
        node->direction[0][1] = normal[0];
        return;
    }
    double axis[3] = {0, 0, 0};
    int small = 0;
    for (int d = 1; d < 3; d++)
        small = fabs(normal[d]) < fabs(normal[small]) ? d : small;
    axis[small] = 1;
    pl_cross(normal, axis, node->direction[0]);
    const double length = sqrt(pl_dot(3, node->direction[0], node->direction[0]));
    for (int d = 0; d < 3; d++)
        node->direction[0][d] /= length;
    pl_cross(normal, node->direction[0], node->direction[1]);
}

/** Set node to a node of a patch, whose star is given. */
static void take_node(const pl_joint *joint, const pl_joint_star *star, int32_t number, int first,
                      patch_node *node) {
    const int dim = joint->run->plan->dim;
    const double *x = pl_joint_place(joint, number);
    const int64_t begin = star->stars->ring_offset[star->at],
                  end = star->stars->ring_offset[star->at + 1];
    double square = 0;
    *node = (patch_node){.node = number, .n = dim, .first = first};
    for (int d = 0; d < dim; d++)
        node->direction[d][d] = 1;
    for (int64_t k = begin; k < end; k++)
        for (int d = 0; d < dim; d++) {
            const double way =
                (pl_joint_place(joint, star->stars->ring[k])[d] - x[d]) * joint->run->measure_scale;
            square += way * way;
        }
    node->scale = sqrt(square / (double)(end - begin));
    node->slide = star->slide;
    if (node->slide)
        find_directions(node->slide, dim, node);
}

/** D that an element shall not fall below: its minimum volume's, or its own where that is less. */
static double floor_of(const pl_joint *joint, const pl_stars *stars, const pl_joint_element *e) {
    const pl_run *r = joint->run;
    const planish_plan *plan = r->plan;
    const double own = stars->min_volume ? stars->min_volume[e->facet] : 0;
    const double volume = own > 0 ? own : r->guard.star.min_volume;
    if (!(volume > 0))
        return 0;
    const double per_volume = stars->form ? 1 / plan->form[e->form].volume : plan->dim == 3 ? 6 : 2;
    double x[4][3] = {{0}}, scale = 1;
    int certain;
    find_vertices(joint, e, x);
    for (int d = 0; d < plan->dim; d++)
        scale *= r->measure_scale;
    return fmin(volume * per_volume * scale,
                determinant_of(plan->dim, (const double(*)[3])x, &certain));
}

/** Note where the vertices of an element are in the patch; return 0 if the element is that of an
 *  earlier node, too. */
static int find_own(const pl_joint_patch *p, int dim, int i, patch_element *e) {
    int is_new = 1;
    for (int v = 0; v <= dim; v++) {
        e->own[v] = -1;
        for (int o = 0; o < p->n; o++)
            if (p->node[o] == e->of.node[v])
                e->own[v] = (int8_t)o;
        is_new &= e->own[v] < 0 || e->own[v] >= i;
    }
    return is_new;
}

/** Gather the patch in w; return 0 if it has too many elements. */
static int gather_patch(const pl_joint *joint, const pl_joint_patch *p, pl_joint_room *w) {
    const planish_plan *plan = joint->run->plan;
    w->n_nodes = p->n;
    w->n_elements = w->n_variables = 0;
    w->kept = joint->kept[p->is_loose != 0];
    for (int i = 0; i < p->n; i++) {
        const pl_joint_star star = pl_joint_star_of(joint, p->node[i]);
        const int64_t n = star.stars->link_offset[star.at + 1] - star.stars->link_offset[star.at];
        take_node(joint, &star, p->node[i], w->n_variables, &w->node[i]);
        w->n_variables += w->node[i].n;
        for (int64_t k = 0; k < n; k++) {
            patch_element *e = &w->element[w->n_elements];
            if (w->n_elements == ELEMENTS)
                return 0;
            element_of_star(&star, k, p->node[i], plan->dim, &e->of);
            if (!find_own(p, plan->dim, i, e))
                continue;
            e->floor = floor_of(joint, star.stars, &e->of);
            w->n_elements++;
        }
    }
    return 1;
}

/** Judge the elements before the first step: which are pinned, and that limits are not exceeded
 *  already. Return the least measure of the others. */
static double judge_elements(const pl_joint *joint, pl_joint_room *w) {
    const pl_run *r = joint->run;
    double least = INFINITY;
    for (int i = 0; i < w->n_elements; i++) {
        patch_element *e = &w->element[i];
        double x[4][3] = {{0}};
        find_vertices(joint, &e->of, x);
        const double own = least_measure(r, measure_of(r, 0), e->of.form, (const double(*)[3])x);
        const double other = least_measure(r, measure_of(r, 1), e->of.form, (const double(*)[3])x);
        const pl_joint_pinned *pinned = own < joint->wanted ? find_pinned(joint, &e->of) : NULL;
        e->is_pinned = pinned != NULL;
        if (pinned)
            e->least = fmin(own, fmax(joint->least, pinned->value * (1 - PL_JOINT_LOSS)));
        w->kept = other < w->kept ? other : w->kept;
        least = !pinned && own < least ? own : least;
    }
    w->work += w->n_elements;
    return least;
}

/* ---- watched cells -------------------------------------------------------------------------- */

/** Largest AR^2 of the watched cells at the patch's nodes, of a plan with corners. */
static double worst_cell(const pl_run *r, const pl_joint_room *w) {
    double worst = 0;
    for (int i = 0; r->plan->work.corner && i < w->n_nodes; i++)
        worst = fmax(worst, pl_watch_worst(&r->watch, w->node[i].node, 0).ar2);
    return worst;
}

/** Whether all watched cells at the patch's nodes that were valid still are, and none is worse than the
 *  worst may be. */
static int cells_are_kept(const pl_run *r, const pl_joint_room *w) {
    const pl_watch *watch = &r->watch;
    if (watch->n == 0)
        return 1;
    for (int i = 0; pl_watch_is_on(watch) && i < w->n_nodes; i++)
        for (int64_t k = watch->begin[w->node[i].node]; k < watch->begin[w->node[i].node + 1];
             k++) {
            const int32_t cell = watch->watched[k];
            if (watch->type[cell] && pl_watch_is_valid(watch, cell) &&
                pl_watch_decide(watch, pl_watch_cell(watch, cell)) != PL_VALID)
                return 0;
        }
    return worst_cell(r, w) <= w->cell;
}

/* ---- steps ---------------------------------------------------------------------------------- */

/** Return the least measure where the nodes are now; -1 if the nodes may not be there. Once it is not
 *  above enough it is of no interest. */
static double least_now(const pl_joint *joint, pl_joint_room *w, double enough) {
    const pl_run *r = joint->run;
    const int dim = r->plan->dim;
    const measure raised = measure_of(r, 0), other = measure_of(r, 1);
    double least = INFINITY;
    for (int i = 0; i < w->n_elements && least > enough; i++) {
        const patch_element *e = &w->element[i];
        double x[4][3] = {{0}};
        pl_slope slope[PL_MOST_SLOPES];
        int certain;
        w->work++;
        find_vertices(joint, &e->of, x);
        if (determinant_of(dim, (const double(*)[3])x, &certain) < e->floor || !certain)
            return -1;
        const int n = measures_of(r, raised, e->of.form, (const double(*)[3])x, 0, slope);
        for (int k = 0; k < n; k++) {
            if (e->is_pinned && !(slope[k].value >= e->least))
                return -1;
            if (raised == ANGLE && !(slope[k].value <= joint->largest_angle))
                return -1;
            least = !e->is_pinned && slope[k].value < least ? slope[k].value : least;
        }
        if (!(least_measure(r, other, e->of.form, (const double(*)[3])x) >= w->kept))
            return -1;
    }
    return least > enough && !cells_are_kept(r, w) ? -1 : least;
}

/** Add a row: value + slope . x is raised, or kept above 0; sign -1: of the slope's negative. */
static void add_row(const pl_run *r, pl_joint_room *w, int element, int is_raised, double value,
                    double sign, const pl_slope *slope) {
    const patch_element *e = &w->element[element];
    const int dim = r->plan->dim;
    if (w->problem.m == ROWS)
        return;
    w->element_of[w->problem.m] = element;
    pl_maxmin_row *row = &w->row[w->problem.m++];
    row->is_raised = (uint8_t)is_raised;
    row->value = value > 0 ? value : 0;
    row->n_blocks = 0;
    for (int v = 0; v <= dim; v++) {
        if (e->own[v] < 0)
            continue;
        const patch_node *node = &w->node[e->own[v]];
        const int b = row->n_blocks++;
        row->first[b] = node->first;
        row->width[b] = (uint8_t)node->n;
        for (int j = 0; j < node->n; j++)
            row->slope[b][j] = sign * node->scale * pl_dot(dim, slope->by[v], node->direction[j]);
    }
}

/** How a measure of an element is in the problem. */
typedef enum row_kind { NO_ROW, RAISED, KEPT, KEPT_FROM_ABOVE } row_kind;

/** Return how a value of the measure that is raised is in the problem; least: of the patch. */
static row_kind kind_of_row(const pl_joint *joint, const patch_element *e, double least,
                            double value) {
    if (e->is_pinned && value < e->least + BAND)
        return KEPT;
    if (value < least + BAND)
        return RAISED;
    return value > joint->largest_angle - MARGIN_ANGLE - BAND ? KEPT_FROM_ABOVE : NO_ROW;
}

/** Make the rows of an element for the measure that is raised. */
static void make_raised_rows(const pl_joint *joint, pl_joint_room *w, int element, double least,
                             const double x[4][3]) {
    const patch_element *e = &w->element[element];
    const measure kind = measure_of(joint->run, 0);
    pl_slope slope[PL_MOST_SLOPES];
    int any = 0;
    const int n = measures_of(joint->run, kind, e->of.form, x, 0, slope);
    for (int k = 0; k < n; k++)
        any |= kind_of_row(joint, e, least, slope[k].value) != NO_ROW;
    w->work++;
    if (!any)
        return;
    measures_of(joint->run, kind, e->of.form, x, 1, slope);
    w->work++;
    for (int k = 0; k < n; k++) {
        const double value = slope[k].value;
        const row_kind is = kind_of_row(joint, e, least, value);
        if (is == RAISED)
            add_row(joint->run, w, element, 1, value - least, 1, &slope[k]);
        else if (is == KEPT)
            add_row(joint->run, w, element, 0, value - e->least, 1, &slope[k]);
        else if (is == KEPT_FROM_ABOVE)
            add_row(joint->run, w, element, 0, joint->largest_angle - MARGIN_ANGLE - value, -1,
                    &slope[k]);
    }
}

/** Make the rows of an element for the other measure. */
static void make_other_rows(const pl_joint *joint, pl_joint_room *w, int element,
                            const double x[4][3]) {
    const uint8_t form = w->element[element].of.form;
    const measure kind = measure_of(joint->run, 1);
    const double margin = kind == ANGLE ? MARGIN_ANGLE : MARGIN_RATIO * w->kept;
    pl_slope slope[PL_MOST_SLOPES];
    if (least_measure(joint->run, kind, form, x) >= w->kept + margin + BAND)
        return;
    const int n = measures_of(joint->run, kind, form, x, 1, slope);
    for (int k = 0; k < n; k++)
        if (slope[k].value < w->kept + margin + BAND)
            add_row(joint->run, w, element, 0, slope[k].value - w->kept - margin, 1, &slope[k]);
}

/** Make the rows of the problem around the nodes' places; least: the least measure there. */
static void make_rows(const pl_joint *joint, pl_joint_room *w, double least) {
    w->problem.m = 0;
    for (int i = 0; i < w->n_elements; i++) {
        double x[4][3] = {{0}};
        find_vertices(joint, &w->element[i].of, x);
        make_raised_rows(joint, w, i, least, (const double(*)[3])x);
        make_other_rows(joint, w, i, (const double(*)[3])x);
    }
}

/** Copy the places of the patch's nodes. */
static void save_places(const pl_joint *joint, const pl_joint_room *w, places at) {
    for (int i = 0; i < w->n_nodes; i++)
        memcpy(at[i], pl_joint_place(joint, w->node[i].node),
               (size_t)joint->run->plan->dim * sizeof **at);
}

static void restore_places(const pl_joint *joint, const pl_joint_room *w, places at) {
    for (int i = 0; i < w->n_nodes; i++)
        memcpy(pl_joint_place(joint, w->node[i].node), at[i],
               (size_t)joint->run->plan->dim * sizeof **at);
}

/** Bring x [dim] to the plane or line on which it slides. */
static void slide_to(const pl_star_slide *slide, int dim, double *x) {
    double way[3], along;
    pl_subtract(dim, x, slide->point, way);
    along = pl_dot(dim, way, slide->direction);
    for (int d = 0; d < dim; d++)
        x[d] = slide->kind == PLANISH_CONSTRAINT_ON_LINE
                   ? slide->point[d] + slide->direction[d] * along
                   : slide->point[d] + (way[d] - slide->direction[d] * along);
}

/** Move the nodes by w->x from start. Return 0 if they may not be there. */
static int move_nodes(const pl_joint *joint, const pl_joint_room *w, places start) {
    const int dim = joint->run->plan->dim;
    for (int i = 0; i < w->n_nodes; i++) {
        const patch_node *node = &w->node[i];
        const double scale = node->scale / joint->run->measure_scale;
        double *x = pl_joint_place(joint, node->node), to[3] = {0};
        for (int d = 0; d < dim; d++) {
            to[d] = start[i][d];
            for (int j = 0; j < node->n; j++)
                to[d] += w->x[node->first + j] * node->direction[j][d] * scale;
        }
        if (node->slide)
            slide_to(node->slide, dim, to);
        if (!pl_star_admit(&joint->mesh.problem, node->node, dim, to))
            return 0;
        memcpy(x, to, (size_t)dim * sizeof *x);
    }
    return 1;
}

/** The longest way of a node in w->x. */
static double longest_way(const pl_joint_room *w) {
    double longest = 0;
    for (int i = 0; i < w->n_nodes; i++) {
        double square = 0;
        for (int j = 0; j < w->node[i].n; j++)
            square += w->x[w->node[i].first + j] * w->x[w->node[i].first + j];
        longest = square > longest ? square : longest;
    }
    return sqrt(longest);
}

/** Solve the problem with a reach by which the longest way comes near to radius, unless shorter ones
 *  will do; return that way. */
static double solve_within(pl_joint_room *w, double radius) {
    pl_maxmin *p = &w->problem;
    double way = 0;
    for (int i = 0; i < SOLVES; i++) {
        pl_maxmin_solve(p);
        way = longest_way(w);
        if (way > radius)
            p->reach *= fmax(0.05, 0.8 * radius / way);
        else if (way < 0.5 * radius && p->t < 0.9 * p->target && p->reach < REACH_MOST)
            p->reach *= 0.8 * radius > 10 * way ? 10 : 0.8 * radius / way;
        else
            break;
    }
    for (int i = 0; way > radius && i < p->n; i++)
        p->x[i] *= radius / way;
    return fmin(way, radius);
}

/** Take a step that raises the least measure. Return that measure then, or *least if there is no step. */
static double step(const pl_joint *joint, pl_joint_room *w, double least, double *radius) {
    places start;
    pl_maxmin *p = &w->problem;
    make_rows(joint, w, least);
    save_places(joint, w, start);
    p->target = fmin(joint->wanted * (1 + OVERSHOOT) - least, AIM);
    for (int i = 0; i < TRIALS; i++) {
        const double way = solve_within(w, *radius);
        if (!(p->t > NOTHING))
            break;
        const double enough = least + TAKEN * p->t;
        const double now = move_nodes(joint, w, start) ? least_now(joint, w, enough) : -1;
        if (now > enough) {
            if (now > least + GOOD * p->t)
                *radius = fmin(2 * *radius, RADIUS_MOST);
            return now;
        }
        restore_places(joint, w, start);
        *radius = 0.3 * way;
    }
    return least;
}

/** Add to the patch the movable nodes of the elements whose rows hold the step back. */
static void grow(const pl_joint *joint, const pl_joint_room *w, pl_joint_patch *p) {
    const pl_maxmin *problem = &w->problem;
    for (int a = 0; a < problem->n_active; a++) {
        int32_t node[4];
        const int n = movable_nodes(joint, &w->element[w->element_of[problem->active[a]]].of, node);
        for (int v = 0; v < n; v++) {
            int is_known = p->n == PL_JOINT_NODES;
            for (int o = 0; o < p->n && !is_known; o++)
                is_known = p->node[o] == node[v];
            if (!is_known)
                p->node[p->n++] = node[v];
        }
    }
}

/** The patch neither gains nor grows: loosen it, once, or it is at its limit. */
static void give_up(const pl_joint *joint, pl_joint_patch *p) {
    if (!p->is_loose && joint->kept[1] < joint->kept[0])
        p->is_loose = 1;
    else
        p->state = PL_JOINT_PINNED;
}

/** Take steps from a least measure; return that after them. */
static double take_steps(const pl_joint *joint, pl_joint_room *w, double least) {
    double radius = RADIUS;
    for (int i = 0; i < STEPS && least < joint->wanted; i++) {
        const double now = step(joint, w, least, &radius);
        if (!(now > least))
            break;
        least = now;
    }
    return least;
}

void pl_joint_improve(const pl_joint *joint, int thread, pl_joint_patch *p) {
    pl_joint_room *w = &joint->room[thread];
    p->has_moved = 0;
    w->work = p->work = 0;
    if (!gather_patch(joint, p, w)) {
        p->state = PL_JOINT_PINNED;
        return;
    }
    w->cell = fmax(worst_cell(joint->run, w), joint->most_of_cell);
    w->problem = (pl_maxmin){.n = w->n_variables,
                             .row = w->row,
                             .reach = REACH,
                             .spread = AIM,
                             .room = w->room,
                             .x = w->x,
                             .active = w->active,
                             .multiplier = w->multiplier};
    const double before = judge_elements(joint, w);
    const double least = take_steps(joint, w, before);
    p->has_moved = least > before;
    p->work = w->work + w->problem.work / PL_JOINT_MULTIPLICATIONS;
    for (int i = 0; joint->run->watch.n > 0 && i < p->n; i++)
        pl_watch_forget(&joint->run->watch, p->node[i]);
    if (least >= joint->wanted) {
        p->state = PL_JOINT_DONE;
        return;
    }
    const int n = p->n;
    grow(joint, w, p);
    if (p->n == n && !(least > before + LITTLE))
        give_up(joint, p);
}

/* ---- all patches ---------------------------------------------------------------------------- */

enum { LANES = 8 }; /* elements whose angles are found at once */

/** Search for the largest angle: the smallest cosine. */
typedef struct angle_search {
    const pl_run *run;
    const double *coordinates; /* [.][dim] */
    const int32_t *number;     /* of the mesh's nodes in them; NULL: the same */
    double *cosine;            /* [threads] */
} angle_search;

/** Lower s->cosine of the thread to those of the elements from first to first + LANES - 1 that are
 *  before end and have a movable node. */
PL_INLINE void search_elements(const angle_search *s, int64_t first, int64_t end, int thread,
                               const int dim) {
    const planish_plan *plan = s->run->plan;
    double x[4][3][LANES], cosine[LANES];
    for (int l = 0; l < LANES; l++) {
        const int64_t i = first + l < end ? first + l : first;
        const int32_t *node = plan->work.elements + i * (dim + 1);
        for (int v = 0; v <= dim; v++)
            for (int d = 0; d < dim; d++)
                x[v][d][l] =
                    s->coordinates[(s->number ? s->number[node[v]] : node[v]) * (int64_t)dim + d] *
                    s->run->measure_scale;
    }
    for (int l = 0; l < LANES; l++) {
        double edge[3][3];
        for (int j = 0; j < dim; j++)
            for (int d = 0; d < dim; d++)
                edge[j][d] = x[j + 1][d][l] - x[0][d][l];
        cosine[l] = pl_shape_of_edges(dim, (const double(*)[3])edge).smallest_cosine;
    }
    for (int l = 0; l < LANES && first + l < end; l++)
        if (cosine[l] < s->cosine[thread] &&
            pl_any_moves(plan->work.mobility, plan->work.elements + (first + l) * (dim + 1),
                         dim + 1))
            s->cosine[thread] = cosine[l];
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const angle_search *s = context;
    for (int64_t i = begin; i < end; i += LANES)
        if (s->run->plan->dim == 3)
            search_elements(s, i, end, thread, 3);
        else
            search_elements(s, i, end, thread, 2);
}

/** Return the largest angle of an element with a movable node, at the start of the run and now. */
static double find_largest_angle(const pl_run *r) {
    enum { CHUNK = 4096 };
    const planish_plan *plan = r->plan;
    double cosine[PL_MAX_THREADS] = {0}, least = 1;
    const angle_search now = {r, plan->scratch.coordinates, plan->inner, cosine},
                       start = {r, r->given, NULL, cosine};
    for (int t = 0; t < plan->threads; t++)
        cosine[t] = 1;
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, search_chunk,
                    (void *)(uintptr_t)&now);
    pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, search_chunk,
                    (void *)(uintptr_t)&start);
    for (int t = 0; t < plan->threads; t++)
        least = cosine[t] < least ? cosine[t] : least;
    pl_parts_smallest(&least, 1);
    return pl_arc_cosine(least);
}

/** Whether a sliding node can be in a patch: on a plane or line without bounds. */
static int may_slide(const pl_run *r, int64_t star) {
    return r->plan->slide[star].kind != PLANISH_CONSTRAINT_ON_SURFACE && !r->guard.star.lower &&
           !r->guard.star.upper && !r->guard.star.radius && !r->skin.shape;
}

/** Set star_of to the plan's stars of the nodes that can be in patches. */
static void number_stars(const pl_run *r, int32_t *star_of) {
    const planish_plan *plan = r->plan;
    for (int64_t i = 0; i < plan->work.n_nodes + plan->n_images; i++)
        star_of[i] = PL_JOINT_HELD;
    for (int64_t s = 0; s < plan->interior.stars.n_stars; s++)
        if (!pl_star_is_held(&r->guard.star, plan->interior.centre[s], plan->dim))
            star_of[plan->interior.centre[s]] = (int32_t)s;
    for (int64_t s = 0; s < plan->sliding.stars.n_stars; s++)
        if (may_slide(r, s))
            star_of[plan->sliding.centre[s]] = (int32_t)(-2 - s);
    for (int64_t k = 0; k < plan->sliding.n_followers; k++)
        star_of[plan->sliding.follower[k].of] = PL_JOINT_HELD;
    for (int64_t i = 0; r->watch.floor && i < plan->work.n_nodes; i++)
        if (pl_watch_has(&r->watch, (int32_t)i))
            star_of[i] = PL_JOINT_HELD;
}

/** Set number to the numbers in the whole mesh of the plan's inner nodes; images come after all. */
static void number_nodes(const planish_plan *plan, int64_t *number) {
    const planish_part *part = pl_part_here();
    for (int64_t i = 0; i < plan->work.n_nodes; i++) {
        const int64_t node = pl_plan_node(plan, i);
        number[plan->inner[i]] = part ? part->node_number[node] : node;
    }
    for (int64_t i = 0; i < plan->n_images; i++)
        number[plan->work.n_nodes + i] = INT32_MAX + i;
}

static int create_mesh(pl_run *r, pl_joint_mesh *mesh, planish_error *error) {
    const planish_plan *plan = r->plan;
    const int64_t n = plan->work.n_nodes + plan->n_images;
    *mesh = (pl_joint_mesh){.coordinates = plan->scratch.coordinates,
                            .star_of = pl_alloc(n, sizeof *mesh->star_of),
                            .number = pl_alloc(n, sizeof *mesh->number),
                            .moved = pl_alloc_zero(n, sizeof *mesh->moved),
                            .near = pl_alloc_zero(n, sizeof *mesh->near),
                            .stars = {&plan->interior.stars, &plan->sliding.stars},
                            .slide = plan->slide,
                            .problem = r->problem};
    if (!mesh->star_of || !mesh->number || !mesh->moved || !mesh->near)
        return pl_fail_memory(error, "the worst elements");
    number_stars(r, mesh->star_of);
    number_nodes(plan, mesh->number);
    return PLANISH_OK;
}

/** Whether nodes of stars can move, but not in patches. */
static int any_is_left(const pl_run *r, const pl_visits *visits, const int32_t *star_of) {
    int any = 0;
    for (int64_t s = 0; s < visits->stars.n_stars && !any; s++)
        any = star_of[visits->centre[s]] == PL_JOINT_HELD &&
              !pl_star_is_held(&r->guard.star, visits->centre[s], r->plan->dim);
    return any;
}

int pl_joint_create(pl_run *r, const pl_star_limits limits[2], pl_joint *joint,
                    planish_error *error) {
    const planish_plan *plan = r->plan;
    const measure other = measure_of(r, 1);
    const int of_angle = other == ANGLE || other == JACOBIAN;
    *joint = (pl_joint){.run = r, .largest_angle = INFINITY};
    const int status = create_mesh(r, &joint->mesh, error);
    joint->room = pl_alloc(plan->threads, sizeof *joint->room);
    if (status || !joint->room)
        return status ? status : pl_fail_memory(error, "the worst elements");
    for (int i = 0; i < 2; i++)
        joint->kept[i] = value_of_square(other, of_angle ? limits[i].acuteness : limits[i].rr2);
    joint->leaves_nodes = pl_parts_any(any_is_left(r, &plan->interior, joint->mesh.star_of) ||
                                       any_is_left(r, &plan->sliding, joint->mesh.star_of));
    if (measure_of(r, 0) == ANGLE)
        joint->largest_angle = find_largest_angle(r);
    return PLANISH_OK;
}

void pl_joint_destroy(pl_joint *joint) {
    pl_free(joint->mesh.star_of);
    pl_free(joint->mesh.number);
    pl_free(joint->mesh.moved);
    pl_free(joint->mesh.near);
    pl_free(joint->room);
}
