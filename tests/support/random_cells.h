/* random_cells: a small mesh of elements of any type and order, and a call with all that can be asked of
 * it, drawn at random. */
#ifndef TEST_SUPPORT_RANDOM_CELLS_H
#define TEST_SUPPORT_RANDOM_CELLS_H

#include "support/cell_meshes.h"
#include "support/pairs.h"

/** What is drawn: of the mesh, and of planish_options. */
typedef enum cells_factor {
    CELLS_OF,     /* cells_kind */
    CELLS_ORDER,  /* 1; 2 with few nodes; 2 with all */
    CELLS_SHAKE,  /* not, a little, so that elements may be inverted */
    CELLS_BEND,   /* mids: not; inside a little; inside much; also on the boundary */
    CELLS_TORN,   /* whole; some elements missing; with lines that hold nodes */
    CELLS_TURNED, /* right; mirrored; some elements (of order 1) listed the other way round */
    CELLS_PLACE,  /* at 0; far away; tiny; huge */
    CELLS_CONSTRAINT,
    CELLS_PERIODIC,
    CELLS_LAYOUT, /* coordinates: x y z, with a gap, or x x .. y y .. */
    CELLS_TARGET,
    CELLS_WEIGHT, /* of sizes */
    CELLS_CURVE,  /* curve_quality */
    CELLS_THREADS,
    CELLS_ISA,
    CELLS_METHOD,
    CELLS_OBJECTIVE,
    CELLS_SEARCH,
    CELLS_LEAST, /* no minimum volume; met; missed by some; a fraction; one for each element */
    CELLS_AREA_WEIGHT,
    CELLS_BOX,
    CELLS_LOWER, /* bounds of nodes */
    CELLS_DISPLACEMENT,
    CELLS_UNIT,
    CELLS_PRECISION,
    CELLS_UNTANGLE,
    CELLS_WORST,
    CELLS_SWEEPS,
    CELLS_TOLERANCE,
    CELLS_TIME_LIMIT,
    CELLS_WORSE_THAN,
    CELLS_SCOPE, /* only_worse_than is of the plan, of the call */
    CELLS_RINGS,
    CELLS_AROUND,
    CELLS_PROGRESS, /* none; one that stops */
    CELLS_SURFACE,  /* of solids: held or plane; curved: 0.05 edges; 0.3 edges; a length */
    CELLS_REGIONS,  /* none; two, with nodes held between them; with nodes that slide there */
    N_CELLS_FACTORS
} cells_factor;

extern const pairs_factor cells_factors[N_CELLS_FACTORS];

enum {
    CELLS_QUADRILATERALS,
    CELLS_MIXED_2D,
    CELLS_HEXAHEDRA,
    CELLS_WEDGES,
    CELLS_PYRAMIDS,
    CELLS_MIXED,
    CELLS_TRIANGLES,
    CELLS_TETRAHEDRA
};
enum { TARGET_NONE, TARGET_BOX, TARGET_STRETCHED, TARGET_SIZE, TARGET_METRIC, TARGET_LAYER };
enum { CELLS_FREE, CELLS_SOME_FIXED, CELLS_SLIDES, CELLS_SLIDES_FIXED, CELLS_ANY };

/** A drawn call. Arrays are owned. */
typedef struct cells_call {
    int level[N_CELLS_FACTORS];
    cell_box *box;      /* box->x: dense, as before the call */
    planish_mesh given; /* with all that is drawn */
    planish_options plan_options, options;
    double *coordinates; /* as given.coordinates, to be smoothed */
    int64_t first_mid;   /* number of corners; mids come after them */
    int8_t *sign;        /* [cells] */
    uint8_t *is_outside; /* [n_nodes] on a side of the box */
    uint8_t *is_held;    /* [n_nodes] of a line */
    uint8_t *constraint, *is_layer;
    double *direction, *least, *reference, *size, *metric, *lower, *start;
    double *target; /* reference, as dense as box->x, or NULL */
    planish_shape *shape;
    planish_surface surface; /* of shape and slides */
    int32_t *region;         /* [cells] */
    int32_t *periodic;
    int64_t around[2];
    int64_t calls, stop_at; /* of the progress callback */
} cells_call;

/** Whether two levels can be in a call that is not refused. */
int cells_levels_allowed(int a, int level_a, int b, int level_b);

/** Draw a call of these levels; most that would be refused are changed. */
cells_call *cells_call_create(const int *level, uint64_t *state);
void cells_call_destroy(cells_call *call);

/** Coordinates as given at the start, and those that the call has come to, as [n_nodes][dim]. */
void cells_call_rewind(cells_call *call);
void cells_call_get(const cells_call *call, double *x);

/** The levels drawn, as text. */
void cells_call_describe(const cells_call *call, char *text, size_t size);

#endif
