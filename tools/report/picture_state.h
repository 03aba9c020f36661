/* picture_state: what a picture keeps, for the files that draw it.
 *
 * Places are taken relative to the box of the mesh: those of the surface in 16 bits for each axis,
 * finer than any screen, those of bad elements, which may be tiny, as floats.
 */
#ifndef PL_REPORT_PICTURE_STATE_H
#define PL_REPORT_PICTURE_STATE_H

#include "report/drawn_inside.h"
#include "report/drawn_surface.h"
#include "report/drawn_values.h"

/* Places on each side of the box, for points. */
enum { PL_PICTURE_PLACES = 65535 };

typedef struct pl_drawn_state {
    char name[16];      /* "before"; of a step "", */
    int sweep;          /* after which it was, from 1 */
    uint8_t *point;     /* [n_points][dim] of 16 bits */
    uint8_t *code;      /* [n_measures][n_triangles] of flat elements, else NULL */
    int64_t n_inverted; /* in the mesh, */
    int64_t n_bad;      /* and bad elements that are drawn */
    uint8_t *corner;    /* [n_corners][dim] floats, those of an element one after the other, */
    uint8_t *place;     /* or of 16 bits; NULL: likewise, or all elements are inside */
    uint8_t *size;      /* [n_bad] corners of each */
    int64_t n_corners;
    uint8_t *bad_ratio;   /* [n_bad] floats; 0: inverted */
    uint8_t *bad_code;    /* [n_measures][n_bad] */
    uint8_t *inside;      /* [inside.n_points][3] of 16 bits, of solid elements, or NULL; */
    uint8_t *inside_code; /* [n_measures][inside.n] theirs, */
    uint8_t *cube;        /* and [n_measures][grid.n_cells], or NULL */
} pl_drawn_state;

enum { PL_PICTURE_MOST_STATES = 2 };

typedef struct pl_picture {
    int dim;
    int is_surface; /* of flat elements in space */
    int has_types;  /* elements are not all simplices: ratios are aspect ratios */
    int has_plane;  /* it is drawn in a plane other than that of x and y, */
    planish_plane plane;
    int64_t n_nodes, n_elements; /* of the mesh */
    double low[3], high[3];      /* the box of its states, as far as these are known at first */
    double size;                 /* the longest side of that */
    pl_drawn_surface surface;
    int is_solid; /* has solid elements: */
    pl_drawn_inside inside;
    pl_drawn_grid grid;
    const pl_drawn_measure *measure[PL_DRAWN_MEASURES]; /* [n_measures] */
    int n_measures;
    int has_features; /* of the shape of its surface: */
    int32_t *edge;    /* [n_edges][2] points of edges of features, owned */
    int64_t n_edges;
    int32_t *corner; /* [n_corners] points of corners, owned */
    int64_t n_corners;
    pl_drawn_state states[PL_PICTURE_MOST_STATES];
    int n_states;
    pl_drawn_state *step;  /* [n_steps] between the two states, owned, */
    int n_steps, n_sweeps; /* of so many sweeps */
} pl_picture;

/** Free the arrays of a state. */
void pl_drawn_state_free(pl_drawn_state *state);

/** Return how many characters pl_picture_put puts without steps, and how many a step takes at most, about
 *  (picture_data.c). */
int64_t pl_picture_length(const pl_picture *picture);
int64_t pl_picture_step_length(const pl_picture *picture, const pl_drawn_state *step);

#endif
