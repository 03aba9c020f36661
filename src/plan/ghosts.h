/* ghosts: nodes that other processes move, and messages about this process's nodes. Everything is
 * empty where the whole mesh is in one process.
 *
 *   pl_ghosts_create, _destroy            the ghosts of a plan
 *   pl_ghosts_note, _send, _receive       before and after the visits of a colour
 *   pl_ghosts_wake, _update               stars around ghosts that have moved
 */
#ifndef PL_PLAN_GHOSTS_H
#define PL_PLAN_GHOSTS_H

#include "topology/topology.h"

struct planish_plan;
struct pl_visits;

/** Ghosts of a plan, and their neighbours; inner numbers are those of the plan's arrays. Owned. */
typedef struct pl_ghosts {
    int32_t *node;       /* [n_nodes] the mesh's number of each inner one */
    int64_t *offset;     /* [n_nodes + 1] by the mesh's numbers: where a ghost's neighbours begin */
    int32_t *neighbour;  /* inner numbers of those that are no ghosts */
    uint8_t *is_movable; /* [n_elements] see pl_measure_by */
    double *before;      /* [most SHARED nodes of a colour][dim] where they were */
    int32_t *moved;      /* [likewise] those of them that have moved, and */
    char *message;       /* what is said of them: coordinates, and whether neighbours were told */
} pl_ghosts;

/** order [n_nodes]: the mesh's numbers by inner ones. To be destroyed in any case. */
int pl_ghosts_create(struct planish_plan *plan, const planish_mesh *mesh, const int32_t *order,
                     planish_error *error);

/** Free the arrays of ghosts. */
void pl_ghosts_destroy(pl_ghosts *ghosts);

/** Before the SHARED stars begin .. end - 1 of visits are visited; after that: tell the others of
 *  those that have moved; and later: take what these have told. */
void pl_ghosts_note(const struct planish_plan *plan, const struct pl_visits *visits, int64_t begin,
                    int64_t end);

/** After the visit: tell the other processes which SHARED nodes have moved. */
void pl_ghosts_send(const struct planish_plan *plan, const struct pl_visits *visits, int64_t begin,
                    int64_t end);

/** Take the places of ghosts that the other processes have sent. */
void pl_ghosts_receive(const struct planish_plan *plan);

/** Wake the stars around ghosts that are not where they were before: [n_nodes][dim] by inner
 * numbers.
 */
void pl_ghosts_wake(const struct planish_plan *plan, const double *before);

/** Fetch a value of size bytes for each ghost, by inner numbers. */
void pl_ghosts_update(const struct planish_plan *plan, void *values, int64_t size);

#endif
