/* cluster: nodes that are moved together, and whether their new places are taken. */
#include "improve/mend/cluster.h"

#include "base/memory.h"
#include "base/status.h"
#include "geometry/angle.h"

#include <math.h>
#include <string.h>

enum {
    SWEEPS = 200,
    STALLED = 15, /* sweeps that do not help */
    SMOOTH_SWEEPS = 30
};

/* A star is at rest when its function falls by less than this, relative. */
#define AT_REST 1e-4

/* ---- nodes and elements ---------------------------------------------------------------------- */

int pl_cluster_create(pl_mend *curve, pl_cluster *c, planish_error *error) {
    const int64_t n = curve->plan->whole.n_nodes;
    *c = (pl_cluster){.curve = curve,
                      .handle_of = pl_alloc(n, sizeof *c->handle_of),
                      .is_member = pl_alloc_zero(curve->plan->work.n_elements, 1)};
    const int status = pl_mend_star_create(curve, &c->star, error);
    if (status || !c->handle_of || !c->is_member)
        return pl_fail_memory(error, "curved elements");
    memset(c->handle_of, -1, (size_t)n * sizeof *c->handle_of);
    return PLANISH_OK;
}

void pl_cluster_destroy(pl_cluster *c) {
    pl_mend_star_destroy(&c->star);
    pl_free(c->handle);
    pl_free(c->element);
    pl_free(c->was_valid);
    pl_free(c->handle_of);
    pl_free(c->is_member);
}

void pl_cluster_empty(pl_cluster *c) {
    for (int64_t i = 0; i < c->n_handles; i++)
        c->handle_of[c->handle[i].node] = -1;
    for (int64_t i = 0; i < c->n_elements; i++)
        c->is_member[c->element[i]] = 0;
    c->n_handles = c->n_elements = 0;
    pl_free(c->was_valid);
    c->was_valid = NULL;
}

void pl_cluster_add_element(pl_cluster *c, int32_t element) {
    if (c->is_member[element])
        return;
    if (pl_append(&c->element, &c->n_elements, &c->element_room, &element, sizeof element))
        c->is_member[element] = 1;
    else
        c->curve->lacks_memory = 1;
}

/** Add a node that moves, and the elements at it. */
static void add_handle(pl_cluster *c, int32_t node) {
    pl_mend *curve = c->curve;
    if (c->handle_of[node] >= 0)
        return;
    const pl_handle h = pl_handle_of(curve, node);
    if (!pl_append(&c->handle, &c->n_handles, &c->handle_room, &h, sizeof h)) {
        curve->lacks_memory = 1;
        return;
    }
    c->handle_of[node] = (int32_t)(c->n_handles - 1);
    for (int64_t k = curve->begin[node]; k < curve->begin[node + 1]; k++)
        pl_cluster_add_element(c, curve->at[k]);
}

void pl_cluster_add_nodes(pl_cluster *c, int64_t element, int with_corners) {
    int n;
    const int32_t *of = pl_mend_nodes(c->curve, element, &n);
    for (int i = 0; i < n; i++) {
        const pl_mend_kind kind = pl_mend_kind_of(c->curve, of[i]);
        if (kind == PL_MEND_MID || (with_corners && kind == PL_MEND_CORNER))
            add_handle(c, of[i]);
    }
}

/** Handle of a node of the mesh (-1: a missing mid), or NULL: it does not move. */
static pl_handle *handle_of(const pl_cluster *c, int32_t node) {
    return node >= 0 && c->handle_of[node] >= 0 ? &c->handle[c->handle_of[node]] : NULL;
}

/* ---- what is taken ------------------------------------------------------------------------- */

static int is_valid(const pl_cluster *c, int64_t i) {
    return pl_mend_decide(c->curve, c->element[i]) == PL_VALID;
}

void pl_cluster_note_valid(pl_cluster *c) {
    if (!c->was_valid)
        c->was_valid = pl_alloc(c->n_elements, 1);
    if (!c->was_valid)
        c->curve->lacks_memory = 1;
    for (int64_t i = 0; c->was_valid && i < c->n_elements; i++)
        c->was_valid[i] = (uint8_t)is_valid(c, i);
}

void pl_cluster_begin(pl_cluster *c) {
    double sum = 0;
    for (int64_t i = 0; i < c->n_elements; i++)
        sum += fabs(pl_mend_straight(c->curve, c->element[i]));
    const double mean = sum / (double)(c->n_elements > 0 ? c->n_elements : 1);
    for (int64_t i = 0; i < c->n_elements; i++) {
        const double D = pl_mend_straight(c->curve, c->element[i]);
        c->star.target[c->element[i]] = D > 1e-3 * mean ? D : mean;
    }
    pl_cluster_note_valid(c);
}

void pl_cluster_save(pl_cluster *c) {
    for (int64_t i = 0; i < c->n_handles; i++)
        pl_handle_save(c->curve, &c->handle[i]);
}

void pl_cluster_restore(const pl_cluster *c) {
    for (int64_t i = 0; i < c->n_handles; i++)
        pl_handle_restore(c->curve, &c->handle[i]);
}

void pl_cluster_restore_invalid(const pl_cluster *c) {
    for (int is_fine = 0; !is_fine;) {
        is_fine = 1;
        for (int64_t i = 0; i < c->n_elements; i++) {
            int n;
            const int32_t *of = pl_mend_nodes(c->curve, c->element[i], &n);
            if (!c->was_valid[i] || is_valid(c, i))
                continue;
            is_fine = 0;
            for (int j = 0; j < n; j++)
                if (handle_of(c, of[j]))
                    pl_handle_restore(c->curve, handle_of(c, of[j]));
        }
    }
}

/** Whether an element with free corners is worse than any was at the start. */
static int is_worse(const pl_mend *c, int64_t element) {
    const pl_star_limits *limits = &c->run->limits_at_start;
    double x[PL_CELL_NODES * 3], edges[3][3] = {{0}};
    const double *vertex[4] = {x, x + c->dim, x + 2 * c->dim, x + 3 * c->dim};
    if (!(limits->rr2 < INFINITY || limits->acuteness < INFINITY))
        return 0;
    pl_places_of_element(c->watch, element, x, NULL);
    pl_edges(c->dim, vertex, edges);
    const double D = pl_determinant_of_edges(c->dim, edges);
    return pl_radius_ratio_square(c->dim, vertex) > limits->rr2 * PL_LIMIT_MARGIN ||
           pl_acuteness(c->dim, edges, D) > limits->acuteness * PL_LIMIT_MARGIN;
}

int pl_cluster_can_be_taken(const pl_cluster *c, int or_as_many) {
    int64_t n_before = 0, n_after = 0;
    int moves_corners = 0;
    for (int64_t i = 0; i < c->n_handles; i++)
        moves_corners |= c->handle[i].inner >= 0;
    for (int64_t i = 0; i < c->n_elements; i++) {
        const int now = is_valid(c, i);
        if ((c->was_valid[i] && !now) || (moves_corners && is_worse(c->curve, c->element[i])))
            return 0;
        n_before += !c->was_valid[i];
        n_after += !now;
    }
    return n_after < n_before || (or_as_many && n_after == n_before);
}

/* ---- sweeps ---------------------------------------------------------------------------------- */

/** Number of elements that are not given up and have a coefficient that is not positive. */
static int64_t count_tangled(const pl_cluster *c) {
    const pl_mend *curve = c->curve;
    int64_t n = 0;
    for (int64_t i = 0; i < c->n_elements; i++)
        n += !curve->is_given_up[c->element[i]] && !(pl_mend_quality(curve, c->element[i]) > 0);
    return n;
}

/** Sum and least D of all stars, with the energy's epsilon. */
static double sum_energy(pl_cluster *c, double epsilon, double *least) {
    double sum = 0;
    *least = INFINITY;
    for (int64_t i = 0; i < c->n_handles; i++) {
        double of_star;
        sum += pl_mend_star_energy(&c->star, &c->handle[i], epsilon, &of_star);
        *least = fmin(*least, of_star);
    }
    return sum;
}

/** Return a lower epsilon, by how much the energy has fallen. */
static double lower(double epsilon, double before, double after, double least) {
    const double sigma = fmax(0.1, before > 0 ? 1 - after / before : 0.1);
    const double root = sqrt(least * least + epsilon * epsilon);
    epsilon *= least >= 0 ? 1 - sigma : 1 - sigma * root / (fabs(least) + root);
    return fmax(epsilon, 1e-9);
}

void pl_cluster_untangle(pl_cluster *c, int64_t *effort) {
    const pl_mend *curve = c->curve;
    double least, best = -INFINITY, before = 0;
    int64_t n = count_tangled(c), fewest = n;
    sum_energy(c, 1, &least);
    double epsilon = sqrt(1e-12 + 0.04 * least * least);
    for (int sweep = 0, stalled = 0; sweep < SWEEPS && n > 0 && stalled < STALLED; sweep++) {
        for (int64_t i = 0; i < c->n_handles; i++)
            pl_mend_star_visit(&c->star, &c->handle[i], epsilon);
        *effort -= 2 * c->n_handles;
        const double after = sum_energy(c, epsilon, &least);
        n = count_tangled(c);
        epsilon = lower(epsilon, before, after, least);
        stalled = n < fewest || least > best + 1e-3 * fabs(best) ? 0 : stalled + 1;
        fewest = n < fewest ? n : fewest;
        best = fmax(best, least);
        before = after;
        if (curve->lacks_memory || *effort < 0 || pl_limit_is_reached(curve->limit))
            break;
    }
}

/** Let the next sweep visit the nodes of all elements at h. */
static void activate_around(pl_cluster *c, const pl_handle *h) {
    const pl_mend *curve = c->curve;
    for (int64_t k = curve->begin[h->node]; k < curve->begin[h->node + 1]; k++) {
        int n;
        const int32_t *of = pl_mend_nodes(curve, curve->at[k], &n);
        for (int j = 0; j < n; j++)
            if (handle_of(c, of[j]))
                handle_of(c, of[j])->is_active = 1;
    }
}

void pl_cluster_smooth(pl_cluster *c) {
    int goes_on = 1;
    for (int64_t i = 0; i < c->n_handles; i++)
        c->handle[i].is_active = 1;
    for (int sweep = 0; sweep < SMOOTH_SWEEPS && goes_on; sweep++) {
        goes_on = 0;
        for (int64_t i = 0; i < c->n_handles; i++) {
            pl_handle *h = &c->handle[i];
            if (!h->is_active)
                continue;
            h->is_active = 0;
            if (!(pl_mend_star_visit(&c->star, h, 0) > AT_REST))
                continue;
            goes_on = 1;
            activate_around(c, h);
        }
        if (c->curve->lacks_memory || pl_limit_is_reached(c->curve->limit))
            return;
    }
}
