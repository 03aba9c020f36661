/* random_calls: a mesh, a plan and a call with everything that planish.h lets one choose, drawn at
 * random; and what the caller's side of it is: memory, threads, callbacks. */
#ifndef TEST_SUPPORT_RANDOM_CALLS_H
#define TEST_SUPPORT_RANDOM_CALLS_H

#include "support/pairs.h"
#include "support/random_meshes.h"

/** What is drawn: of the mesh, of how its arrays look, and of all fields of planish_options. */
typedef enum random_factor {
    OF_DIM,
    OF_SHAPE, /* to OF_PERIODIC: random_choice */
    OF_CUT,
    OF_PARTS,
    OF_EXTRA,
    OF_ORDER,
    OF_TANGLE,
    OF_PLACE,
    OF_PERIODIC,
    OF_CONSTRAINT,
    OF_LAYOUT,
    OF_WIDTH,
    OF_NEIGHBOURS,
    OF_THREADS,
    OF_BIND,
    OF_ISA,
    OF_METHOD,
    OF_OBJECTIVE,
    OF_DIRECTION,
    OF_LEAST, /* min_volume, min_volume_fraction, planish_mesh.min_volume */
    OF_AREA_WEIGHT,
    OF_LOWER,
    OF_UPPER,
    OF_BOX,
    OF_DISPLACEMENT,
    OF_UNIT,
    OF_PRECISION, /* and round */
    OF_UNTANGLE,
    OF_WORST,
    OF_WORST_RISE,
    OF_MAX_SWEEPS,
    OF_TOLERANCE,
    OF_TIME_LIMIT,
    OF_WORSE_THAN,
    OF_SCOPE, /* which calls only_worse_than is given to */
    OF_RINGS,
    OF_AROUND, /* and around_elements */
    OF_PROGRESS,
    OF_PROJECT,
    OF_ALLOCATOR,
    OF_PARALLEL,
    OF_LOG,
    N_FACTORS
} random_factor;

extern const pairs_factor random_factors[N_FACTORS];

/** Levels that are spoken of elsewhere. */
enum { LEAST_NONE, LEAST_MET, LEAST_SOME, LEAST_FRACTION, LEAST_OWN_SOME, LEAST_OWN, LEAST_BOTH };
enum {
    CONSTRAINT_NONE,
    CONSTRAINT_SOME,
    CONSTRAINT_FOUND,
    CONSTRAINT_ANY,
    CONSTRAINT_SURFACE,
    CONSTRAINT_ALL
};
enum { ALLOCATOR_SYSTEM, ALLOCATOR_OWN, ALLOCATOR_FAILING };
enum { PROGRESS_NONE, PROGRESS_WATCH, PROGRESS_STOP, PROGRESS_MEASURE };
enum { SCOPE_BOTH, SCOPE_PLAN, SCOPE_CALL };

/** A block of memory that belongs to the caller, and what was in it. */
typedef struct random_block {
    void *data, *copy; /* owned */
    size_t size;
} random_block;

enum { RANDOM_BLOCKS = 24 };

typedef struct random_heap {
    int64_t calls, live, failing; /* shared; the call that fails, or -1 */
} random_heap;

/** What the progress callback sees and does. */
typedef struct random_watch {
    const planish_plan *plan;
    const double *coordinates; /* to be measured in a call */
    int64_t calls, stop_at;    /* the call that stops it, or -1 */
    int sweep, has_stopped;
    int is_wrong; /* something in planish_progress contradicts the header */
} random_watch;

/** What a node slides on: the sphere or circle around a centre that it started on. */
typedef struct random_surface {
    int dim;
    const double *start; /* [n_nodes][dim] */
    double centre[3];
} random_surface;

typedef struct random_call {
    int level[N_FACTORS];
    random_mesh mesh;
    planish_mesh dense; /* as drawn: 32 bits, no strides, no neighbours */
    planish_mesh given; /* the same as the caller has it */
    planish_options plan_options, options;
    random_block block[RANDOM_BLOCKS];
    int n_blocks;
    double *coordinates; /* as given.coordinates, to be smoothed; a block whose values may change */
    random_heap heap;
    planish_allocator allocator;
    random_watch watch;
    random_surface surface;
    double quantum; /* of rounded coordinates */
    int64_t logged;
} random_call;

/** Whether two levels can be in a call that is not refused. */
int random_levels_allowed(int a, int level_a, int b, int level_b);

/** A number of points for a mesh of these levels, mostly a small one. */
int random_call_points(const int *level, int most, uint64_t *state);

/** n_points: of the mesh, about. */
void random_call_create(random_call *call, const int *level, int n_points, uint64_t *state);
void random_call_destroy(random_call *call);

/** Coordinates as the caller has them, from and to [n_nodes][dim]. */
void random_call_put(const random_call *call, const double *x);
void random_call_get(const random_call *call, double *x);

/** Whether all that is the caller's, but the smoothed coordinates, is as it was. */
int random_call_is_untouched(const random_call *call);

/** The callbacks of a call, whose mesh and options are drawn already. */
void random_callbacks_draw(random_call *call, uint64_t *state);

/** The progress callback; user is a random_watch. */
int random_call_progress(const planish_progress *progress, void *user);

/** Before each call: the progress callback begins anew. */
void random_call_rewind(random_call *call);

/** The nearest place on the surface that a node started on; its distance from there is 0 or what
 *  rounding makes of it. */
double random_surface_distance(const random_surface *surface, int64_t node, const double *x);

/** The levels drawn, as text. */
void random_call_describe(const random_call *call, char *text, size_t size);

#endif
