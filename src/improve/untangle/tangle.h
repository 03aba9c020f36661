/* tangle: the elements to untangle, and the patch of nodes that moves for them.
 *
 *   tangle.c      pl_tangle_create, _find, _mark, _measure ...    elements, patch and its energy
 *   sizes.c       pl_tangle_find_sizes                 how large elements should be
 *
 * untangle.c has the ladder (improve.h). Where elements are corners of cells (quality/view.h), the
 * state is that of each corner; elements that are counted, given up or returned are cells.
 */
#ifndef PL_IMPROVE_UNTANGLE_TANGLE_H
#define PL_IMPROVE_UNTANGLE_TANGLE_H

#include "improve/untangle/given_up.h"
#include "sweep/rows.h"
#include "sweep/run.h"

/** Working state of untangling. Arrays are owned, and by inner numbers but for state. */
typedef struct pl_tangle {
    pl_run *run;
    pl_star_problem problem;  /* of visits that untangle */
    pl_star_guard guard;      /* bounds, and minimum volumes if elements are to be raised to them */
    pl_star_untangling asked; /* in_patch, size and link_skip point to what follows */
    uint8_t *in_patch;        /* [n_nodes] */
    double *size;             /* [n_nodes] */
    uint8_t *link_skip;       /* [link facets of all stars], or NULL: none is skipped */
    uint8_t *is_given_up;     /* [n_elements] to be given up, or NULL: none */
    uint8_t *node_is_given_up; /* [n_nodes] of pl_mark_enclosed, or NULL: none */
    uint8_t *state;            /* [n_elements] pl_tangle_state, as found last */
    uint8_t *is_inside; /* [n_elements] at the first corner of a cell that is invalid inside, with
                           positive corners: 1, as found last; NULL: nobody asks for that */
    uint8_t
        *is_marked;    /* [n_elements] likewise, of cells whose coefficients are rows of problem; */
    pl_marked marked;  /* these rows */
    double *before;    /* [n_nodes][dim] of the mesh that stands, while a rung is tried, */
    double *begin;     /* and of the mesh before all of them */
    uint8_t *is_ghost; /* [n_nodes] of a mesh in parts; NULL: there are none */
    int32_t *ghost;    /* [n_ghosts] ghosts whose nodes may move, */
    uint8_t *was_in_patch; /* [n_ghosts] and whether they were in the patch a ring ago */
    int64_t n_ghosts;
    int32_t *star_of;          /* [n_nodes] the star of each free node; else -1 */
    int32_t *queue;            /* [n_stars] */
    double scale;              /* a power of two: times it the domain is about 1 wide */
    pl_star_energy *of_thread; /* [threads] of the stars that each has looked at */
    pl_star_slope *slope;      /* [n_stars] to be filled with the energy; NULL: not asked for */
    int64_t n_tangled;     /* cells with an element whose state is PL_TANGLED, or invalid inside */
    int stopped;           /* a planish_stop: the run is to end before anything is done */
    int64_t n_patch;       /* nodes of the patch */
    int64_t n_in_vain;     /* and of one that was solved with the same rows in vain; 0: none */
    pl_star_energy energy; /* of the patch, as computed last */
} pl_tangle;

/* ---- tangle.c ------------------------------------------------------------------------------ */

/** Look at the mesh as the run has measured it: what is tangled, and what of that cannot be helped?
 *  raises: elements are to be raised to their minimum volumes, else just made positive. n_tangled
 *  0: there is nothing to be done, and nothing else is set. Errors: _MEMORY. To be destroyed in any
 *  case. */
int pl_tangle_create(pl_run *r, int raises, pl_tangle *t, planish_error *error);

/** Free the arrays of t. */
void pl_tangle_destroy(pl_tangle *t);

/** Find the tangled elements of the mesh as measured last. */
void pl_tangle_find(pl_tangle *t);

/** Whether a corner of the cell is tangled, or the cell is invalid inside, as found last; of a mesh of
 *  simplices, which are cells, whether the element is. */
int pl_tangle_is_tangled(const pl_tangle *t, int64_t cell);

/** Whether cells are invalid inside, which rounds may help, in the mesh as measured last. */
static inline int pl_tangle_has_rounds(const pl_tangle *t) {
    return t->run->plan->work.corner && t->run->sums.inside > 0 && !(t->guard.min_volume > 0) &&
           !t->guard.link_min_volume;
}

/** Look for cells that are invalid inside, too, from now on, and give up those with corners that are
 *  tangled now. The mesh has corners. Errors: _MEMORY. */
int pl_tangle_begin_rounds(pl_tangle *t, planish_error *error);

/** Add the coefficients of cells that are invalid inside, as found last, to the rows of the energy.
 *  *n: how many cells were added. Errors: _MEMORY. */
int pl_tangle_add_rows(pl_tangle *t, int64_t *n, planish_error *error);

enum { PL_ALL_RINGS = INT32_MAX };

/** Make the patch: the free nodes of tangled elements, and of so many rings of elements around. */
void pl_tangle_mark(pl_tangle *t, int rings);

/** Compute the patch's energy with the present epsilon. slope [n_stars] (may be NULL) is filled for
 *  the stars of the patch. */
void pl_tangle_measure(pl_tangle *t, pl_star_slope *slope);

/** Return the sum of the energies, as computed last. */
double pl_tangle_energy(const pl_tangle *t);

/* ---- sizes.c ------------------------------------------------------------------------------- */

/** Find how large the elements should be around each node: as they are now on average, inverted
 * ones counting negative. Without memory they do not change. */
void pl_tangle_find_sizes(pl_tangle *t);

#endif
