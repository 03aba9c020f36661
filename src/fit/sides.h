/* sides: features of two shapes are alike if what they bound is. */
#ifndef PL_FIT_SIDES_H
#define PL_FIT_SIDES_H

#include "fit/fit.h"

enum { PL_FIT_MOST_NORMALS = 24 };

/** What the outside at an edge or node looks like. Normals point out of the body. */
typedef struct pl_fit_sides {
    int n; /* normals of the facets; more than one of nearly the same is not listed */
    double normal[PL_FIT_MOST_NORMALS][3];
    int is_open; /* facets end there, or it is not known that none does */
    int bend;    /* 1: it stands out; -1: it lies in; 0: neither, or that is not known */
} pl_fit_sides;

/** Look at an edge, which is a feature. turn [patches]: NULL: facets turn out of the body. */
void pl_fit_look_at_edge(const planish_shape *shape, const int8_t *turn, int32_t edge,
                         pl_fit_sides *sides);

/** Look at a node. */
void pl_fit_look_at_node(const planish_shape *shape, const int8_t *turn, int32_t node,
                         pl_fit_sides *sides);

/** Whether each normal of one has one of the other within an angle of a cosine, and they do not bend against each
 *  other. Facets that the other one lacks as it is open do not count. */
int pl_fit_are_alike(const pl_fit_sides *own, const pl_fit_sides *other, double cosine);

#endif
