/* drawn_state: what a picture draws of a mesh in one state: places, and codes of measures.
 *
 * Places are relative to the box of the mesh: those of the surface, and of elements inside, in 16 bits for
 * each axis, finer than any screen; those of bad elements, which may be tiny, as floats. All numbers are
 * little-endian.
 *
 *     pl_drawn_state_take, _take_brief, _free   the mesh as it is now
 *     pl_drawn_state_put, _length               as JSON
 *     pl_drawn_state_triangle, _corners         places, to draw them here
 */
#ifndef PL_REPORT_DRAWN_STATE_H
#define PL_REPORT_DRAWN_STATE_H

#include "report/drawn_inside.h"
#include "report/drawn_surface.h"
#include "report/drawn_values.h"
#include "report/markup.h"

/** Parts of a mesh that all its states have in common. Arrays are owned by the picture. */
typedef struct pl_drawn_mesh {
    int dim;
    int is_surface;         /* of flat elements in space */
    int is_solid;           /* it has solid elements, of which inside and grid are known */
    int has_types;          /* elements are not all simplices: ratios are aspect ratios */
    double low[3], high[3]; /* its box as it was at first */
    double size;            /* the longest side of that */
    pl_drawn_surface surface;
    pl_drawn_inside inside;
    pl_drawn_grid grid;
    const pl_drawn_measure *measure[PL_DRAWN_MEASURES]; /* [n_measures] */
    int n_measures;
} pl_drawn_mesh;

/** A state. Arrays are owned. */
typedef struct pl_drawn_state {
    uint8_t *point;     /* [n_points of the surface][dim] of 16 bits */
    uint8_t *code;      /* [n_measures][n_triangles] of flat elements, else NULL */
    int64_t n_inverted; /* in the mesh, */
    int64_t n_bad;      /* and bad elements that are drawn */
    uint8_t *
        corner; /* [n_corners][dim] floats, those of an element one after the other, from the middle
                           of the box, whose longest side is 1; NULL: all elements are inside */
    uint8_t *size; /* [n_bad] corners of each */
    int64_t n_corners;
    uint8_t *bad_ratio;   /* [n_bad] floats; 0: inverted */
    uint8_t *bad_code;    /* [n_measures][n_bad] */
    uint8_t *inside;      /* [inside.n_points][3] of 16 bits, of solid elements, or NULL; */
    uint8_t *inside_code; /* [n_measures][inside.n] theirs, */
    uint8_t *cube;        /* and [n_measures][grid.n_cells], or NULL */
} pl_drawn_state;

/** Take the mesh of job as it is now. state, which is to be freed also after a failure, is all 0 before.
 *  Returns 0, or an exit status after a message. */
int pl_drawn_state_take(const pl_drawn_mesh *mesh, const pl_job *job, pl_drawn_state *state);

/** Take less, for one of many states: where all solid elements are drawn inside, they are without bad ones
 *  apart; else there are fewer bad elements, nothing inside, and no cubes. As pl_drawn_state_take. */
int pl_drawn_state_take_brief(const pl_drawn_mesh *mesh, const pl_job *job, pl_drawn_state *state);

/** How many bad elements pl_drawn_state_take_brief takes; 0: all elements. */
int64_t pl_drawn_state_brief_bad(const pl_drawn_mesh *mesh);

/** Put the fields of a state, each behind a comma. first: the state whose points are left out if they are the
 *  same, or NULL. */
void pl_drawn_state_put(pl_markup *page, const pl_drawn_mesh *mesh, const pl_drawn_state *state,
                        const pl_drawn_state *first);

/** Return how many characters pl_drawn_state_put puts, about. */
int64_t pl_drawn_state_length(const pl_drawn_mesh *mesh, const pl_drawn_state *state,
                              const pl_drawn_state *first);

/** Set place [3] to the corners of a triangle of the surface, from the middle of the box, whose longest side
 *  is 1. */
void pl_drawn_state_triangle(const pl_drawn_mesh *mesh, const pl_drawn_state *state,
                             int64_t triangle, double place[3][3]);

/** Set place [n] to n corners of a bad element, of which corner is the first. */
void pl_drawn_state_corners(const pl_drawn_mesh *mesh, const uint8_t *corner, int n,
                            double place[8][3]);

/** Return the ratio of bad element i; 0: it is inverted. */
double pl_drawn_state_ratio(const pl_drawn_state *state, int64_t i);

void pl_drawn_state_free(pl_drawn_state *state);

#endif
