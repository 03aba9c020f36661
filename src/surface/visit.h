/* visit: one node's local problem on a surface.
 *
 *   visit.c   pl_surface_visit       visit a range of stars
 */
#ifndef PL_SURFACE_VISIT_H
#define PL_SURFACE_VISIT_H

#include "sweep/skin.h"
#include "surface/surface_mesh.h"

/** Data that all visits of a sweep share. Nodes have the shape's numbers, coordinates the mesh's units. */
typedef struct pl_surface_problem {
    const pl_surface_mesh *mesh;
    double (*x)[3];             /* [n_nodes] */
    const double (*start)[3];   /* [n_nodes] where they began */
    const pl_star_slide *slide; /* [n_stars] planes and lines */
    pl_skin *skin;              /* of all stars that change the shape of the surface */
    const double (*lower)[3];   /* [n_nodes] bounds, or NULL */
    const double (*upper)[3];
    const double *radius; /* [n_nodes] how far from start each may go, or NULL */
    uint8_t *changed;     /* [n_nodes] 1: the node's star is to be visited */
    pl_storage storage;
    pl_facet_measure measure; /* that is lowered */
    double limit;             /* 0: its sum; else that of the eighth powers of measure / limit */
    double worst;             /* no ratio, */
    double acuteness;         /* and no acuteness shall be above these */
    double calm;              /* a move that brings less of the star's sum wakes nobody */
    double skip;              /* stars whose measure is nowhere above it are left alone */
} pl_surface_problem;

/** Visit the changed ones of stars begin .. end - 1, which are of one colour, on a thread; adds to
 *  *tally. */
void pl_surface_visit(const pl_surface_problem *problem, int64_t begin, int64_t end, int thread,
                      pl_star_tally *tally);

#endif
