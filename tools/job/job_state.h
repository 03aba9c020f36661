/* job_state: a job, and what every part of it asks.
 *
 *     pl_job_hold, _region_arrays          how options hold nodes; arrays that tell regions
 *     pl_job_element_dim, _corners, _element_number    its elements
 *     pl_job_box_widen                              a box
 *     pl_job_complain, _complain_memory    messages on errors of the library, and of memory
 */
#ifndef PL_TOOLS_JOB_STATE_H
#define PL_TOOLS_JOB_STATE_H

#include "job/like.h"
#include "options/options.h"

#include <planish/planish_io.h>

struct pl_engine; /* engine.h */

/** Elements thin in layers (layers.h). */
typedef struct pl_layers {
    int64_t n;          /* in the input; -1: not looked for */
    int64_t n_kept;     /* those of them that keep their heights, */
    int64_t n_of_types; /* and wedges, hexahedra and quadrilaterals among these */
    int64_t n_held;     /* those of them that are held as layers */
    int64_t n_loose;    /* others of them with a node that moves */
    int is_tangled;     /* they are not kept by default, as too many elements are invalid */
    char not_kept[64];  /* what they could not be kept with by default, or "" */
    char fix[256];      /* options that hold them by their groups, or "" */
} pl_layers;

/** Heights that layers are to have (heights.h). */
typedef struct pl_wanted_heights {
    uint8_t *is_layer; /* [elements as of pl_job_find_layers] owned, or NULL: like.is_layer says
                          that, or nobody asks */
    double *place;  /* [n_nodes][dim] where layers have these heights, owned, or NULL: like.place */
    int64_t n_held; /* nodes that are held as heights of kept layers would change by much */
    int64_t n_faults;     /* more elements that stay inverted where all such nodes are held */
    uint8_t *constraint;  /* [n_nodes] before these are held, owned, or NULL: none was chosen */
    uint8_t *is_released; /* [n_nodes] 1: is not held, as an element needs it; owned, or NULL */
} pl_wanted_heights;

/** Why a node is held, in the order in which reasons count. A node may have several; as bits they
 * are 1 << pl_hold_cause. */
typedef enum pl_hold_cause {
    PL_CAUSE_BOUNDARY,
    PL_CAUSE_LINE, /* or point, of the file */
    PL_CAUSE_FACE, /* of the file, inside the mesh */
    PL_CAUSE_INTERFACE,
    PL_CAUSE_OTHER, /* element, of a type that is not smoothed */
    PL_CAUSE_PERIODIC,
    PL_CAUSE_FIX,
    PL_CAUSE_REQUIRED,
    PL_CAUSE_DOUBLED,
    PL_CAUSE_NONMANIFOLD,
    PL_CAUSE_LAYERS,
    PL_CAUSE_WRAPPED,
    PL_CAUSE_NOT_CHOSEN,
    PL_N_CAUSES
} pl_hold_cause;

/* Bits beside those: the node is a mid-side node, and follows; it is of no element; its
 * constraint fixes it. */
enum { PL_HELD_FOLLOWS = 1 << 13, PL_HELD_NOT_USED = 1 << 14, PL_HELD_TOLD = 1 << 15 };

/** Held nodes: each is counted once in n. n_held + n_mids + n_unused and the nodes that move or
 * slide are all nodes. */
typedef struct pl_held {
    int is_known; /* 0: nobody asked, or several processes have the mesh */
    int64_t n[PL_N_CAUSES];
    int64_t n_held;    /* their sum */
    int64_t n_mids;    /* mid-side nodes that nothing holds: they follow */
    int64_t n_unused;  /* nodes of no element */
    int64_t n_doubled; /* held nodes at the place of another one, whatever they count as */
} pl_held;

/** Shape of a curved surface, and the nodes on it. */
typedef struct pl_curved {
    planish_shape *shape; /* owned, or NULL: none was asked for */
    planish_shape_info info;
    int64_t n[PLANISH_CONSTRAINT_ON_CURVE + 1]; /* nodes by their constraint */
} pl_curved;

/** The surface of another file that the mesh's is fitted to. */
typedef struct pl_onto {
    planish_shape *own, *shape;               /* owned; NULL: there is no such file */
    planish_shape_info info;                  /* of shape */
    int64_t n_joined;                         /* points of its file (joined.h) */
    int64_t n_left_out, n_quadrilaterals_out; /* facets of it; of these */
    planish_fit *fit;                         /* owned */
    planish_fit_info before, after;
    double worst_before; /* worst ratio of the mesh as it was read */
    uint64_t input_checksum;
    planish_shape_distance distance; /* in the end */
    double seconds;
} pl_onto;

/** A box along the axes of a mesh. */
typedef struct pl_job_box {
    int is_known; /* 0: nothing else is set */
    double low[3], high[3];
} pl_job_box;

/** Messages between the processes that share a mesh, summed over them. */
typedef struct pl_traffic {
    int n_processes;     /* 0: one process works by itself, and nothing else is set */
    int in_parts;        /* 0: one has done it all, as the others could not help */
    int64_t messages;    /* values of nodes, and sums */
    int64_t nodes;       /* values of nodes in them */
    int64_t bytes;       /* of all messages */
    double wait_seconds; /* of the process that has waited longest for others */
} pl_traffic;

/* Options that would let a held node move or slide. */
enum { PL_RELEASED_BY_SLIDE = 1, PL_RELEASED_BY_LAYERS = 2 };

typedef struct pl_job {
    const pl_arguments *arguments;  /* the caller's, or own */
    const struct pl_engine *engine; /* the caller's, or that of surfaces */
    pl_arguments own;               /* what they mean for a surface in space (curved.h) */
    planish_options options;        /* those of the arguments, and what file and machine say */
    planish_file *file;
    planish_file_info file_info;
    planish_mesh mesh; /* its arrays are those of file, but for those that follow. It has cells
                            in place of elements unless all are straight simplices without targets.
                            Its reference is like.place, but not as that of the command quality, which
                            plans for regular simplices */
    planish_cells simplices; /* mesh.cells of the command quality: those of the file that are first,
                                and simplices */
    int is_surface;          /* flat elements in space, in no plane (curved.h) */
    int has_types;       /* there are smoothed elements that are no simplices, or elements that have
                            targets: ratios are the aspect ratios AR of docs/measures.md, of
                            simplices, too */
    uint8_t *constraint; /* [mesh.n_nodes] of planish_constraint, owned */
    double *direction;   /* [mesh.n_nodes][dim] of nodes that slide, owned, or NULL: none does */
    uint8_t *is_layer;   /* [mesh.n_elements] thin in layers, owned, or NULL: not looked for while
                            reading, or kept (like.is_layer) */
    uint8_t *in_layer;   /* [mesh.n_nodes] 1: held as a node of a layer; owned, or NULL: none is */
    pl_layers layers;
    pl_held held;
    uint8_t *
        held_in_run; /* [mesh.n_nodes] of planish_held_by, where nodes are when smoothing begins; owned,
                             or NULL: nobody asks, or nothing holds movable nodes */
    pl_curved curved;
    pl_onto onto;
    pl_like like;
    pl_job_box goal; /* where the nodes will be, as far as that is known beforehand; for pictures */
    int64_t could_slide;  /* nodes that would with --slide auto; -1: not looked for */
    uint8_t *released_by; /* [mesh.n_nodes] bits PL_RELEASED_BY_ of held nodes; owned, or NULL: not
                                  looked for */
    int64_t n_between_entities;                 /* see entities.h */
    int64_t n_unjoined_faces, n_unjoined_nodes; /* see unjoined.h */
    int64_t n_with_parameters; /* nodes that may move and have parameters of the geometry */
    int64_t n_supported;       /* nodes that may move and have boundary conditions */
    double *min_volume;        /* [mesh.n_elements] owned, or NULL: no group has one of its own */
    planish_plan *plan;
    planish_plan_info plan_info;
    uint8_t *wrapped;     /* [mesh.n_elements] 1: wraps around; owned, or NULL: none does */
    char binding[256];    /* its text, as the plan is gone when that is told */
    pl_traffic traffic;   /* of smoothing */
    double begin;         /* pl_seconds when the job began */
    double read_seconds;  /* file and constraints */
    double shape_seconds; /* nodes that slide, or could; layers, without --fix-layers */
    double setup_seconds; /* plan */
    pl_wanted_heights wanted;
} pl_job;

/** How the options hold nodes of the file, without slides. */
planish_hold pl_job_hold(const pl_job *job);

/** Names of the arrays between whose values nodes are held, NULL at the end. */
const char *const *pl_job_region_arrays(const pl_job *job);

/** The dimension of the elements: that of the mesh, of a surface in space 2. */
int pl_job_element_dim(const pl_job *job);

/** The corners of an element of job->mesh, of any type and order, and their number *n. */
const int32_t *pl_job_corners(const pl_job *job, int64_t element, int *n);

/** The file's number of an element; without a file its index. */
int64_t pl_job_element_number(const pl_job *job, int64_t element);

/** Widen box to hold n places x [n][dim]. */
void pl_job_box_widen(pl_job_box *box, int dim, const double *x, int64_t n);

/** Message for an error of the library: the text, and which file if it does not say so. */
int pl_job_complain(const pl_job *job, int status, const planish_error *error);

/** Message that memory is short for of. Returns PL_EXIT_FAILED. */
int pl_job_complain_memory(const pl_job *job, const char *of);

#endif
