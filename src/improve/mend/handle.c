/* handle: a mid or corner of a curved element that moves by itself. */
#include "improve/mend/handle.h"

#include "geometry/simplex.h"

#include <string.h>

pl_handle pl_handle_of(pl_mend *c, int32_t node) {
    const int64_t first = c->at[c->begin[node]];
    pl_handle h = {.node = node, .inner = -1, .is_active = 1};
    if (pl_mend_kind_of(c, node) == PL_MEND_CORNER)
        h.inner = c->plan->inner[pl_mend_corner(c, first, pl_mend_place(c, first, node))];
    pl_handle_save(c, &h);
    return h;
}

/** The numbers of a node that h may change [dim]: a corner's coordinates, or a mid's own way. */
static double *numbers_of(const pl_mend *c, const pl_handle *h) {
    return h->inner < 0 ? c->watch->mids.own + (int64_t)h->node * c->dim
                        : c->plan->scratch.coordinates + (int64_t)h->inner * c->dim;
}

void pl_handle_place(const pl_mend *c, const pl_handle *h, double *x) {
    if (h->inner < 0)
        pl_mid_place(&c->watch->mids, h->node, x);
    else
        memcpy(x, numbers_of(c, h), (size_t)c->dim * sizeof *x);
}

void pl_handle_save(const pl_mend *c, pl_handle *h) {
    memcpy(h->saved, numbers_of(c, h), (size_t)c->dim * sizeof *h->saved);
}

void pl_handle_restore(const pl_mend *c, const pl_handle *h) {
    memcpy(numbers_of(c, h), h->saved, (size_t)c->dim * sizeof *h->saved);
}

/** Whether a mid may be at x: within the bounds of options, and no farther from its start than both
 *  of its ends may go. */
static int mid_may_be(const pl_mend *c, int32_t mid, const double *x) {
    const planish_options *o = c->options;
    const pl_mids *mids = &c->watch->mids;
    const int64_t element = c->at[c->begin[mid]];
    const uint8_t *ends = pl_mend_ends(c, mid);
    double start[3];
    for (int d = 0; d < c->dim; d++) {
        const int64_t i = (int64_t)mid * c->dim + d;
        start[d] = mids->start.x[pl_point_at(&mids->start, mid, d)];
        if (x[d] < o->box_lower[d] || x[d] > o->box_upper[d] || (o->lower && x[d] < o->lower[i]) ||
            (o->upper && x[d] > o->upper[i]))
            return 0;
    }
    const double *radius = c->run->guard.star.radius;
    for (int k = 0; k < 2 && radius; k++)
        if (pl_distance(c->dim, x, start) >
            radius[c->plan->inner[pl_mend_corner(c, element, ends[k])]])
            return 0;
    return 1;
}

int pl_handle_put(const pl_mend *c, const pl_handle *h, double *x) {
    double now[3];
    if (h->inner >= 0) {
        if (!pl_star_admit(&c->run->problem, h->inner, c->dim, x))
            return 0;
        memcpy(numbers_of(c, h), x, (size_t)c->dim * sizeof *x);
        return 1;
    }
    pl_handle_place(c, h, now);
    for (int d = 0; d < c->dim; d++)
        numbers_of(c, h)[d] += x[d] - now[d];
    pl_handle_place(c, h, now);
    return mid_may_be(c, h->node, now);
}
