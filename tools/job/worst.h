/* worst: the worst elements of a mesh, for lists and pictures: of the simplices by radius ratio, or
 * of elements of every type by aspect ratio.
 *
 *     pl_worst_select        which they are
 *     pl_worst_find_asked    as many as the command line asks for, and their angles, places, nodes
 *                            and regions
 */
#ifndef PL_TOOLS_WORST_H
#define PL_TOOLS_WORST_H

#include "job/cells.h"
#include "job/job.h"

/** How many the reports name if --worst does not say. */
enum { PL_USUAL_WORST = 10 };

/** An element, what it is worth, and where it is: as it was when it was found. */
typedef struct pl_bad_element {
    int64_t element; /* index in job->mesh, or the file's cells */
    double ratio;    /* 0: inverted, or flat */
    planish_cell_type type;
    int64_t number;                               /* the file's */
    double smallest_angle_deg, largest_angle_deg; /* dihedral in 3-D; NAN where it is too
                                                     flat, and of elements of every type */
    double place[3];                              /* [columns] its centroid in the file */
    const int64_t *node;                          /* [n_nodes] the file's numbers, of
                                                     pl_worst.node; a missing mid is left out */
    int n_nodes;
    const char *region; /* a tag of the file, of pl_worst.tag, or NULL: it has none */
    int is_movable;     /* it has a movable node; -1: that is not known */
    planish_held_by
        held_by; /* why smoothing holds all of these, by the first reason; _NONE: it does
                                not, or is not asked */
} pl_bad_element;

typedef struct pl_worst {
    pl_bad_element *bad; /* [n] owned; inverted ones first (in the file's order), then the largest
                            ratios; equals in the file's order */
    int64_t n;
    int is_aspect_ratio; /* 1: elements of every type and their aspect ratios; 0: simplices and
                            their radius ratios */
    int64_t n_inverted;  /* in the mesh, also where these are fewer */
    int dim;
    int columns;   /* of places: 2 in the plane of x and y, else 3 */
    int64_t *node; /* nodes of the elements, owned */
    char **tag;    /* [n_tags] of the file's regions, owned; NULL: not looked for, or none */
    int64_t n_tags;
} pl_worst;

/** Find the n worst simplices of the mesh as it is now, or all if there are fewer; of each only
 * which it is and its radius ratio. Returns 0, or an exit status after a message. */
int pl_worst_select(const pl_job *job, int64_t n, pl_worst *worst);

/** Find as many of the worst elements as --worst says, or as the reports name if one is asked for;
 *  else none. All fields are filled in. cells: elements of every type as measured, or NULL for the
 *  simplices alone. */
int pl_worst_find_asked(const pl_job *job, const pl_cells *cells, pl_worst *worst);

void pl_worst_free(pl_worst *worst);

#endif
