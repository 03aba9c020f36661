/* joint_patch: which nodes and elements a patch has. */
#include "improve/joint_patch.h"
#include "improve/joint_measures.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- elements at their limits --------------------------------------------------------------- */

/** Return the element as one that is at its limit. */
static pl_joint_pinned pin(const pl_joint *joint, const pl_joint_element *e) {
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
    const pl_joint_pinned key = pin(joint, e);
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

int pl_joint_movable_nodes(const pl_joint *joint, const pl_joint_element *e, int32_t node[4]) {
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
        patch->n = pl_joint_movable_nodes(joint, &patch->seed, patch->node);
        patch->of = pin(joint, &patch->seed);
        patch->value = patch->of.value;
        return patch->value < joint->wanted && !find_pinned(joint, &patch->seed);
    }
    return 0;
}

/** Set the directions of a node that slides on a plane or line. */
static void find_directions(const pl_star_slide *slide, int dim, pl_joint_node *node) {
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
                      pl_joint_node *node) {
    const int dim = joint->run->plan->dim;
    const double *x = pl_joint_place(joint, number);
    const int64_t begin = star->stars->ring_offset[star->at],
                  end = star->stars->ring_offset[star->at + 1];
    double square = 0;
    *node = (pl_joint_node){.node = number, .n = dim, .first = first};
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
    pl_joint_find_vertices(joint, e, x);
    for (int d = 0; d < plan->dim; d++)
        scale *= r->measure_scale;
    return fmin(volume * per_volume * scale,
                pl_joint_determinant_of(plan->dim, (const double(*)[3])x, &certain));
}

/** Note where the vertices of an element are in the patch; return 0 if the element is that of an
 *  earlier node, too. */
static int find_own(const pl_joint_patch *p, int dim, int i, pl_joint_member *e) {
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

int pl_joint_gather(const pl_joint *joint, const pl_joint_patch *p, pl_joint_room *w) {
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
            pl_joint_member *e = &w->element[w->n_elements];
            if (w->n_elements == PL_JOINT_ELEMENTS)
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

double pl_joint_judge(const pl_joint *joint, pl_joint_room *w) {
    const pl_run *r = joint->run;
    double least = INFINITY;
    for (int i = 0; i < w->n_elements; i++) {
        pl_joint_member *e = &w->element[i];
        double x[4][3] = {{0}};
        pl_joint_find_vertices(joint, &e->of, x);
        const double own =
            pl_joint_least_measure(r, pl_joint_measure_of(r, 0), e->of.form, (const double(*)[3])x);
        const double other =
            pl_joint_least_measure(r, pl_joint_measure_of(r, 1), e->of.form, (const double(*)[3])x);
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
