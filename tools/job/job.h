/* job: the part that smooth and quality share: a mesh file, the nodes it holds, and a plan for it.
 *
 *     pl_job_read, _close                  the file, with constraints, minimum volumes and the box
 *     pl_job_find_slides, _count_slides    nodes that slide, or could
 *     pl_job_find_layers, _layer_mesh, _hold_layers    boundary layers
 *     pl_job_plan, _get_free, _measure     by the engine
 *     pl_job_complain, _complain_memory    messages on errors of the library, and of memory
 *
 * Every function returns 0, or an exit status after a message.
 */
#ifndef PL_TOOLS_JOB_H
#define PL_TOOLS_JOB_H

#include "job/engine.h"
#include "job/like.h"
#include "options/options.h"

#include <planish/planish_io.h>

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
} pl_wanted_heights;

/** Why a node is held, in the order in which reasons count. A node may have several; as bits they
 * are 1 << pl_held_by. */
typedef enum pl_held_by {
    PL_HELD_BY_BOUNDARY,
    PL_HELD_BY_LINE, /* or point, of the file */
    PL_HELD_BY_FACE, /* of the file, inside the mesh */
    PL_HELD_BY_INTERFACE,
    PL_HELD_BY_OTHER, /* element, of a type that is not smoothed */
    PL_HELD_BY_PERIODIC,
    PL_HELD_BY_FIX,
    PL_HELD_BY_REQUIRED,
    PL_HELD_BY_DOUBLED,
    PL_HELD_BY_NONMANIFOLD,
    PL_HELD_BY_LAYERS,
    PL_HELD_BY_WRAPPED,
    PL_HELD_BY_NOT_CHOSEN,
    PL_N_HELD_BY
} pl_held_by;

/* Bits beside those: the node is a mid-side node, and follows; it is of no element; its
 * constraint fixes it. */
enum { PL_HELD_FOLLOWS = 1 << 13, PL_HELD_NOT_USED = 1 << 14, PL_HELD_TOLD = 1 << 15 };

/** Held nodes: each is counted once in n. n_held + n_mids + n_unused and the nodes that move or
 * slide are all nodes. */
typedef struct pl_held {
    int is_known; /* 0: nobody asked, or several processes have the mesh */
    int64_t n[PL_N_HELD_BY];
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
    planish_shape *own, *shape; /* owned; NULL: there is no such file */
    planish_fit *fit;           /* owned */
    planish_fit_info before, after;
    double worst_before; /* worst ratio of the mesh as it was read */
    uint64_t input_checksum;
    planish_shape_distance distance; /* in the end */
    double seconds;
} pl_onto;

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
    const pl_arguments *arguments; /* the caller's, or own */
    const pl_engine *engine;       /* the caller's, or that of surfaces */
    pl_arguments own;              /* what they mean for a surface in space (curved.h) */
    planish_options options;       /* those of the arguments, and what file and machine say */
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
    pl_curved curved;
    pl_onto onto;
    pl_like like;
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

/** Read the file of arguments and find out which nodes it holds and what bounds there are. */
int pl_job_read(pl_job *job, const pl_arguments *arguments, const pl_engine *engine);

/** Whether the file has elements that job->mesh does not, as it is that of the command quality. */
int pl_job_lacks_types(const pl_job *job);

/** Put all elements of the file in job->mesh, in a copy of a job of the command quality. */
void pl_job_take_all(pl_job *job);

/** Find the nodes that slide, if any shall. */
int pl_job_find_slides(pl_job *job);

/** How the options hold nodes of the file, without slides. */
planish_hold pl_job_hold(const pl_job *job);

/** Find the elements of any type that are thin in layers, and their number *n: is_layer
 *  [mesh.n_elements, and one for each other element of planish_file_cells], owned by the caller also
 *  after an error. */
int pl_job_find_layers(const pl_job *job, uint8_t **is_layer, int64_t *n);

/** The mesh with all elements that are looked at for layers, in cells where it is not job->mesh. */
int pl_job_layer_mesh(const pl_job *job, planish_cells *cells, planish_mesh *mesh);

/** Fix the nodes of layers that are held, if there are any, in constraint [n_nodes]. */
void pl_job_hold_layers(const pl_job *job, uint8_t *constraint);

/** Names of the arrays between whose values nodes are held, NULL at the end. */
const char *const *pl_job_region_arrays(const pl_job *job);

/** The dimension of the elements: that of the mesh, of a surface in space 2. */
int pl_job_element_dim(const pl_job *job);

/** The corners of an element of job->mesh, of any type and order, and their number *n. */
const int32_t *pl_job_corners(const pl_job *job, int64_t element, int *n);

/** The file's number of an element; without a file its index. */
int64_t pl_job_element_number(const pl_job *job, int64_t element);

/** Whether scaled Jacobians count: elements are not to be like others that may be sharp. */
int pl_job_is_blunt(const pl_job *job);

/** Objective that is minimised: of a mesh with elements of other types the mean ratio by default. */
planish_objective pl_job_objective(const pl_job *job);

/** Whether F is another number than the RMS of the measure of the mesh, radius or aspect ratio. */
int pl_job_changes_objective(const pl_job *job);

/** Make the plan. */
int pl_job_plan(pl_job *job);

/** Whether anything is going to be said of the mesh: in a table, or a report. */
int pl_job_is_told(const pl_job *job);

/** Count, once there is a plan, the nodes that may move while parameters, or boundary conditions, in the file
 *  do not. */
int pl_job_count_bound(pl_job *job);

/** Count and mark the nodes that could slide, if none shall and any may move; there is a plan. */
int pl_job_count_slides(pl_job *job);

/** Make room for the marks of held nodes, job->released_by, unless there is room already. */
int pl_job_need_released_by(pl_job *job);

/** is_free [mesh.n_nodes] as planish_plan_get_free. */
int pl_job_get_free(const pl_job *job, uint8_t *is_free);

/** planish_checksum of the mesh as it is now; in a tilted plane, of its places in space. */
uint64_t pl_job_checksum(const pl_job *job);

/** Whether an angle in degrees is smaller than it was, by more than rounding explains: that of a
 *  sliver's is that of its volume. */
int pl_angle_is_smaller(double after, double before);

/** Measure the mesh as it is now; measures over no element are NAN. */
int pl_job_measure(const pl_job *job, planish_quality *quality);

/** Message for an error of the library: the text, and which file if it does not say so. */
int pl_job_complain(const pl_job *job, int status, const planish_error *error);

/** Message that memory is short for of. Returns PL_EXIT_FAILED. */
int pl_job_complain_memory(const pl_job *job, const char *of);

void pl_job_close(pl_job *job);

#endif
