/* joint_steps: steps of a patch. */
#include "improve/joint_steps.h"
#include "improve/joint_measures.h"
#include "improve/joint_patch.h"

#include <math.h>
#include <string.h>

enum {
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

/** Places of the nodes of a patch. */
typedef double places[PL_JOINT_NODES][3];

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

/** Return the least measure where the nodes are now; -INFINITY if the nodes may not be there. Once it is not
 *  above enough it is of no interest. */
static double least_now(const pl_joint *joint, pl_joint_room *w, double enough) {
    const pl_run *r = joint->run;
    const int dim = r->plan->dim;
    const pl_joint_measure raised = pl_joint_measure_of(r, 0), other = pl_joint_measure_of(r, 1);
    double least = INFINITY;
    for (int i = 0; i < w->n_elements && least > enough; i++) {
        const pl_joint_member *e = &w->element[i];
        double x[4][3] = {{0}};
        pl_slope slope[PL_MOST_SLOPES];
        int certain;
        w->work++;
        pl_joint_find_vertices(joint, &e->of, x);
        if (pl_joint_determinant_of(dim, (const double(*)[3])x, &certain) < e->floor || !certain)
            return -INFINITY;
        const int n = pl_joint_measures_of(r, raised, e->of.form, (const double(*)[3])x, 0, slope);
        for (int k = 0; k < n; k++) {
            if (e->is_pinned && !(slope[k].value >= e->least))
                return -INFINITY;
            if (raised == PL_JOINT_ANGLE && !(slope[k].value <= joint->largest_angle))
                return -INFINITY;
            least = !e->is_pinned && slope[k].value < least ? slope[k].value : least;
        }
        if (!(pl_joint_least_measure(r, other, e->of.form, (const double(*)[3])x) >= w->kept))
            return -INFINITY;
    }
    return least > enough && !cells_are_kept(r, w) ? -INFINITY : least;
}

/** Add a row: value + slope . x is raised, or kept above 0; sign -1: of the slope's negative. */
static void add_row(const pl_run *r, pl_joint_room *w, int element, int is_raised, double value,
                    double sign, const pl_slope *slope) {
    const pl_joint_member *e = &w->element[element];
    const int dim = r->plan->dim;
    if (w->problem.m == PL_JOINT_ROWS)
        return;
    w->element_of[w->problem.m] = element;
    pl_maxmin_row *row = &w->row[w->problem.m++];
    row->is_raised = (uint8_t)is_raised;
    row->value = value > 0 ? value : 0;
    row->n_blocks = 0;
    for (int v = 0; v <= dim; v++) {
        if (e->own[v] < 0)
            continue;
        const pl_joint_node *node = &w->node[e->own[v]];
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
static row_kind kind_of_row(const pl_joint *joint, const pl_joint_member *e, double least,
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
    const pl_joint_member *e = &w->element[element];
    const pl_joint_measure kind = pl_joint_measure_of(joint->run, 0);
    pl_slope slope[PL_MOST_SLOPES];
    int any = 0;
    const int n = pl_joint_measures_of(joint->run, kind, e->of.form, x, 0, slope);
    for (int k = 0; k < n; k++)
        any |= kind_of_row(joint, e, least, slope[k].value) != NO_ROW;
    w->work++;
    if (!any)
        return;
    pl_joint_measures_of(joint->run, kind, e->of.form, x, 1, slope);
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
    const pl_joint_measure kind = pl_joint_measure_of(joint->run, 1);
    const double margin = kind == PL_JOINT_ANGLE ? MARGIN_ANGLE : MARGIN_RATIO * w->kept;
    pl_slope slope[PL_MOST_SLOPES];
    if (pl_joint_least_measure(joint->run, kind, form, x) >= w->kept + margin + BAND)
        return;
    const int n = pl_joint_measures_of(joint->run, kind, form, x, 1, slope);
    for (int k = 0; k < n; k++)
        if (slope[k].value < w->kept + margin + BAND)
            add_row(joint->run, w, element, 0, slope[k].value - w->kept - margin, 1, &slope[k]);
}

/** Make the rows of the problem around the nodes' places; least: the least measure there. */
static void make_rows(const pl_joint *joint, pl_joint_room *w, double least) {
    w->problem.m = 0;
    for (int i = 0; i < w->n_elements; i++) {
        double x[4][3] = {{0}};
        pl_joint_find_vertices(joint, &w->element[i].of, x);
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

/** Move the nodes by w->x from start. Return 0 if they may not be there. */
static int move_nodes(const pl_joint *joint, const pl_joint_room *w, places start) {
    const int dim = joint->run->plan->dim;
    for (int i = 0; i < w->n_nodes; i++) {
        const pl_joint_node *node = &w->node[i];
        const double scale = node->scale / joint->run->measure_scale;
        double *x = pl_joint_place(joint, node->node), to[3] = {0};
        for (int d = 0; d < dim; d++) {
            to[d] = start[i][d];
            for (int j = 0; j < node->n; j++)
                to[d] += w->x[node->first + j] * node->direction[j][d] * scale;
        }
        if (node->slide)
            pl_star_slide_to(node->slide, dim, to);
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
        const double now = move_nodes(joint, w, start) ? least_now(joint, w, enough) : -INFINITY;
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
        const int n =
            pl_joint_movable_nodes(joint, &w->element[w->element_of[problem->active[a]]].of, node);
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
    if (!pl_joint_gather(joint, p, w)) {
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
    const double before = pl_joint_judge(joint, w);
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
