/* draft: data that plan creation needs only while it runs.
 *
 *   domain.c    pl_draft_begin, _choose_scope         the mesh, or the subset to work on
 *   select.c    pl_draft_select, pl_select_around     nodes that options select
 *   draft.c     pl_draft_finish, _destroy             free nodes, their order and stars
 *   across.c    pl_rings_across                       nodes across the edges of a shape
 */
#ifndef PL_PLAN_DRAFT_H
#define PL_PLAN_DRAFT_H

#include "plan/plan.h"
#include "topology/subset.h"

/** Nodes that shall be visited, if their links allow it. */
typedef struct pl_candidates {
    int64_t n;
    int32_t *node;    /* [n] of the draft's mesh, along the curve; -1: not free after all */
    pl_rings rings;   /* of node */
    int32_t *colour;  /* [n] of node */
    int32_t *star_of; /* [n] its place among the visits, colour by colour; -1: none */
} pl_candidates;

/** Working data of plan creation. */
typedef struct pl_draft {
    planish_plan *plan;        /* that is made */
    pl_dense dense;            /* the caller's mesh, */
    pl_subset subset;          /* what of it is worked on, if not all, */
    pl_submesh submesh;        /* as a mesh, */
    const planish_mesh *mesh;  /* and the one of them that the plan is for */
    const planish_mesh *given; /* the caller's itself, or that as cells: */
    planish_mesh with_cells;
    planish_cells cells;
    const planish_options *options;
    uint8_t *mobility;       /* [n] of plan->work, while it is made */
    uint8_t *whole_mobility; /* of plan->whole, or NULL */
    uint8_t *is_selected;    /* [n] not 0: may be free; NULL: all may */
    int all_positive;        /* pl_draft_select has found no element that is not positive */
    uint8_t *is_paired;      /* [n] 1: periodic, to slide or to stay; NULL: none is */
    uint8_t *slides;         /* [n] 1: may slide; NULL: none may */
    pl_incidence incidence;
    int is_partial; /* incidence has no elements of nodes that are not selected */
    pl_boundary boundary;
    int32_t *order;                  /* [n] the nodes of mesh along the curve */
    pl_candidates interior, sliding; /* nodes that are free if inside; nodes that slide */
    int64_t *count;                  /* [chunks of nodes + 1] */
    pl_periodic periodic;            /* for nodes that slide, */
    pl_incidence around;             /* its incidence, */
    int32_t *number_of;              /* [its nodes] and their inner numbers */
} pl_draft;

/** Free the draft's arrays. */
void pl_draft_destroy(pl_draft *d);

/* ---- domain.c: the mesh, or the subset of it, that the plan works on ------------------------- */

/** Validate mesh, and begin with all of it, or with the elements around options->around. */
int pl_draft_begin(const planish_mesh *mesh, pl_draft *d, planish_error *error);

/** Find the orientation and, if asked for, the bad elements from the measures. If these are few,
 *  and all elements are positive as they stand (most often they are), the draft is then for the
 *  subset around them: elements far from a bad one are not looked at again. */
int pl_draft_choose_scope(pl_draft *d, planish_error *error);

/* ---- draft.c: free nodes, their order and their stars -------------------------------------- */

/** Give the plan all that it knows of the domain's topology. */
int pl_draft_finish(pl_draft *d, planish_error *error);

/* ---- across.c: nodes that slide on a shape --------------------------------------------------- */

/** Check that the facets of options->shape at the nodes of c are of the mesh. Make the offset and
 *  neighbour of rings: those of c, and of each node those across the smooth edges opposite to it
 *  in its facets. Both are to be released. Errors: _ARGUMENT, _MEMORY. */
int pl_rings_across(const pl_draft *d, const pl_candidates *c, pl_rings *rings,
                    planish_error *error);

/* ---- select.c: nodes that options select ----------------------------------------------------- */

/** Select the nodes that options->only_worse_than is about: the nodes of elements with a larger RR,
 *  below their minimum volume, or not positive by the boundary's sign, and of rings of elements
 *  around these. Fill is_selected and all_positive, and subset if a walk found it. Errors: _MESH
 *  (of its neighbours), _MEMORY. */
int pl_draft_select(pl_draft *d, planish_error *error);

/** Choose the nodes that options->around is about; is_selected [n] is 0 before. corners has those of
 *  mesh, if its elements are corners. */
void pl_select_around(const planish_mesh *mesh, const pl_view *corners,
                      const planish_options *options, int threads, uint8_t *is_selected);

#endif
