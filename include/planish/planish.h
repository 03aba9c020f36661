/* planish: smooth meshes of triangles, tetrahedra and elements of other types by moving their
 * interior nodes.
 *
 * The caller owns all arrays; the library changes coordinates in place. It prints nothing and
 * installs no signal handler. Its only global state is hwloc's view of the machine, if threads are
 * bound. Only hwloc and OpenMP read environment variables. Two threads may work on two plans at the
 * same time; one plan serves one thread at a time.
 *
 * Error convention: functions return 0 on success and a negative planish_status on failure; then
 * *error (may be NULL) says what and where, and outputs are untouched unless stated otherwise. Calls
 * that create or open set their pointer to NULL then. Success leaves *error as it was: look at the
 * status first.
 *
 * Conventions:
 * - Node and element indices start at 0.
 * - Floating-point environment: the library computes in round-to-nearest, with subnormals and
 *   without traps. Each thread has its own environment again, flags included, when the call or task
 *   returns. Callbacks run in the library's environment and must keep it. They must return: no
 *   longjmp, no C++ exception.
 * - Names: n_ begins the number of nodes, elements, facets or other things. Plain nouns count work:
 *   sweeps, visits, evaluations, threads. -1 stands for "not counted". The enumerators of a type
 *   have a common prefix: PLANISH_ROLE_OWN is a planish_role. "Infeasible" means proved impossible,
 *   "given up" means left out of the energy of untangling.
 * - Zero structures before you fill them in: {0}, designated initialisers, or planish_options_init
 *   for options. All versions with one soname (0.2.x; from 1.0 on all of 1) have the same sizes:
 *   later ones use the reserved fields. Calls refuse reserved fields that are not 0, as they would not
 *   know what another version means by them. planish_options also begins with its size, so that the
 *   library refuses options that were not initialised, or that another version of this header
 *   describes.
 * - "Radius ratio" (RR) is the normalised one: R/(3r) of a tetrahedron, R/(2r) of a triangle, R the
 *   circumradius and r the inradius; 1 for the equilateral element and larger for any other. RR is
 *   the measure for meshes of simplices alone.
 * - A mesh is "mixed" if a smoothed element has another type. There the aspect ratio AR of
 *   planish_cell_measures, from the mean ratios mu of corners, replaces RR (docs/elements.md).
 *
 * Sections, with functions and main types; each name begins with planish_:
 *
 *     Version                    version, has_feature
 *     Errors                     status, error
 *     Mesh                       constraint, cell_type, cells, mesh
 *     Mesh in several processes  role, part
 *     Nodes that can slide       surface, find_slides
 *     Curved surfaces            shape_create, shape_destroy, shape_get_classes, shape_get_edges,
 *                                shape_measure
 *     Regions                    cell_array, rank_region_name, find_regions, combine_regions,
 *                                find_interfaces
 *     Elements thin in layers    find_layers
 *     Options                    progress, progress_fn, project_fn, options, options_init_sized
 *     Another surface            fit_create, fit_destroy, fit_move, fit_constrain, fit_project,
 *                                fit_measure
 *     Plan                       plan_create, plan_destroy, plan_get_info, plan_get_free,
 *                                plan_get_held, find_wrapped
 *     Quality                    quality, measure, measure_elements, find_reversed, measure_mesh,
 *                                cell_quality, cell_values, measure_cells, measure_surface,
 *                                checksum
 *     Heights of layers          measure_layers
 *     Sizes                      measure_sizes, find_sizes
 *     Smoothing                  result, smooth, progress_get_coordinates, smooth_surface,
 *                                find_held, find_held_on_surface, check_volumes, find_infeasible
 */
#ifndef PLANISH_H
#define PLANISH_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(PLANISH_BUILDING_SHARED) && defined(__GNUC__)
#define PLANISH_API __attribute__((visibility("default")))
#else
#define PLANISH_API
#endif

/* ---- Version --------------------------------------------------------------------------------- */

#define PLANISH_VERSION "0.2.0"
/* The same as numbers, for #if. */
#define PLANISH_VERSION_MAJOR 0
#define PLANISH_VERSION_MINOR 2
#define PLANISH_VERSION_PATCH 0

/** Version of the library that is linked, "MAJOR.MINOR.PATCH"; static text. */
PLANISH_API const char *planish_version(void);

typedef enum planish_feature {
    PLANISH_FEATURE_OPENMP = 0, /* threads of OpenMP; without, a plan has one thread, or those of
                                   options.parallel */
    PLANISH_FEATURE_HWLOC = 1,  /* options.bind has an effect */
    PLANISH_FEATURE_X86_KERNELS = 2 /* PLANISH_ISA_AVX2 and _AVX512, where the CPU has them */
} planish_feature;

/** Return 1 if the linked library was built with feature, else 0. */
PLANISH_API int planish_has_feature(planish_feature feature);

/* ---- Errors ------------------------------------------------------------------------------- */

typedef enum planish_status {
    PLANISH_OK = 0,
    PLANISH_ERROR_ARGUMENT = -1, /* an argument or option is out of its range */
    PLANISH_ERROR_MESH = -2,     /* the mesh is not valid: index out of range, NaN, ... */
    PLANISH_ERROR_MEMORY = -3,   /* memory could not be allocated */
    PLANISH_ERROR_FILE = -4,     /* a file could not be opened, read or written */
    PLANISH_ERROR_FORMAT = -5,   /* a file's content contradicts its format */
    PLANISH_ERROR_PROCESS = -6,  /* another process that has a part of the mesh was not reached */
    PLANISH_ERROR_PARTS = -7     /* the call needs the whole mesh, but the mesh is in parts */
} planish_status;

typedef struct planish_error {
    int code;        /* a planish_status */
    int64_t element; /* the element in question, or -1 */
    int64_t node;    /* the node in question, or -1; as given, so it may be out of range */
    char text[512];  /* one line: what, where, what to do */
} planish_error;

/* ---- Mesh --------------------------------------------------------------------------------- */

/** How a node may move. On the mesh's boundary only sliding nodes move; interior nodes may slide,
 * too. A node does not slide if a facet of more than two elements, a duplicate element or more than
 * 21845 elements meet at it. A node slides while its elements are positive, and is held while they
 * are untangled. Boundaries that are planar around each sliding node, and straight along each line,
 * keep their shape, up to the rounding of coordinates (to floats with PLANISH_PRECISION_FLOAT).
 * planish_find_slides finds nodes that can slide. */
typedef enum planish_constraint {
    PLANISH_CONSTRAINT_FREE = 0,       /* anywhere, unless the node is on the boundary */
    PLANISH_CONSTRAINT_FIXED = 1,      /* nowhere */
    PLANISH_CONSTRAINT_ON_PLANE = 2,   /* on the plane (in 2-D the line) through its place whose
                                         normal is that of planish_mesh.direction */
    PLANISH_CONSTRAINT_ON_LINE = 3,    /* on the line through its place along that direction */
    PLANISH_CONSTRAINT_ON_SURFACE = 4, /* where planish_options.project says */
    PLANISH_CONSTRAINT_ON_PATCH = 5,   /* on its patch of planish_options.shape */
    PLANISH_CONSTRAINT_ON_CURVE = 6    /* on its curve of planish_options.shape */
} planish_constraint;

/** Type of an element. The numbers, and the order of nodes, are VTK's. */
typedef enum planish_cell_type {
    PLANISH_CELL_VERTEX = 1,
    PLANISH_CELL_LINE = 3,
    PLANISH_CELL_TRIANGLE = 5,
    PLANISH_CELL_QUADRILATERAL = 9,
    PLANISH_CELL_TETRAHEDRON = 10,
    PLANISH_CELL_HEXAHEDRON = 12,
    PLANISH_CELL_WEDGE = 13,
    PLANISH_CELL_PYRAMID = 14,
    PLANISH_CELL_LINE3 = 21,
    PLANISH_CELL_TRIANGLE6 = 22,
    PLANISH_CELL_QUADRILATERAL8 = 23,
    PLANISH_CELL_TETRAHEDRON10 = 24,
    PLANISH_CELL_HEXAHEDRON20 = 25,
    PLANISH_CELL_WEDGE15 = 26,
    PLANISH_CELL_PYRAMID13 = 27,
    PLANISH_CELL_QUADRILATERAL9 = 28,
    PLANISH_CELL_HEXAHEDRON27 = 29,
    PLANISH_CELL_WEDGE18 = 32,
    PLANISH_CELL_PYRAMID14 = 128 /* VTK has none: PYRAMID13 and the middle of the base */
} planish_cell_type;

/** Elements of any types. Only elements of the mesh's dimension count. Elements may have either
 *  handedness. The right one is the handedness of most elements that facets join. For an element
 *  without such neighbours it is that of most elements of its type; for a triangle or tetrahedron
 *  without neighbours both are right. */
typedef struct planish_cells {
    int64_t n;             /* elements */
    const uint8_t *type;   /* [n] of planish_cell_type */
    const int64_t *offset; /* [n + 1] nodes of element i are node[offset[i]] .. node[offset[i + 1] -
                              1] */
    const int32_t *node;   /* [offset[n]] -1: a mid in the middle of its straight edge */
    const void *reserved[4]; /* NULL */
} planish_cells;

/** A view of the caller's mesh; nothing in it is owned by the library. */
typedef struct planish_mesh {
    int dim;                   /* 2: elements in the plane, 3: solids, and surfaces in space */
    int64_t n_nodes;           /* at most INT32_MAX */
    int64_t n_elements;        /* at most INT32_MAX */
    const double *coordinates; /* [n_nodes][dim], finite */
    const int32_t *elements;   /* [n_elements][dim + 1], any consistent or mixed orientation */
    const uint8_t *constraint; /* [n_nodes] of planish_constraint, or NULL: all free */
    const double *direction;   /* [n_nodes][dim] of nodes on planes and lines, of any length but 0,
                                  whatever the strides; entries of other nodes are ignored. NULL
                                  if there are none */
    int64_t n_periodic;        /* 0: none */
    const int32_t *periodic;   /* [n_periodic][2] pairs of nodes on periodic boundaries: a
                                  translation takes one to the other. The nodes that pairs join are
                                  a group. A group moves by one vector if all its nodes slide in the
                                  same directions. Each translation needs at least two pairs. The
                                  coordinates to be smoothed must fit the pairs, too. These are held:
                                  - groups with a node that does not slide, such as a free node
                                    inside the mesh
                                  - groups with two nodes of one element
                                  - groups with an ON_SURFACE node
                                  - groups of more than 64 nodes
                                  - groups with a translation of only one pair
                                  - groups with a translation beyond the 64th */
    const double *min_volume;  /* [n_elements] minimum volume (area in 2-D) of each element, finite,
                                  0 or more; 0: that of the options. NULL: 0 for all */
    const int64_t *elements64; /* [n_elements][dim + 1] in place of elements (which is NULL then);
                                  a plan keeps a copy of 32 bits of those that it works on */
    /* Coordinate d of node i is coordinates[i * node_stride + d * component_stride], here and in
       all that is given to a plan of this mesh: 4 and 1 for x y z padded, 1 and n_nodes for x x ..
       y y .. z z .. 0: dim for the first, 1 for the second. */
    int64_t node_stride, component_stride;
    const int32_t *neighbours;   /* [n_elements][dim + 1] the element across the facet opposite that
                                    corner, -1: none. Or NULL; planish_plan_create says what
                                    neighbours save */
    const int64_t *neighbours64; /* neighbours in 64 bits, in place of neighbours */
    const struct planish_part *part; /* what this process has of the mesh; NULL: all of it */
    /* Elements of any types, in place of elements, which are NULL then; NULL: none. n_elements is
       cells->n. Arrays per element, and planish_error.element, are in the order of cells. Elements of
       dimension dim are smoothed by their corners, except pyramids of order 2 and elements with a
       node twice; there must be at least one. Counts and measures are those of smoothed elements.
       All other elements hold their nodes; their entries are ignored on input, and 0 on output.
       A mid follows its edge, by half of the displacement of each end: a straight edge stays
       straight, a curved edge keeps its offset. Nodes in the middle of faces and cells follow all
       corners of these by 1/4 and 1/8. Orders may be mixed: an edge has a mid if one of its elements
       has. FIXED holds mids; other constraints but FREE only say that they do not move on their own
       (planish_options.curve_quality). Bounds are for corners. These are held:
       - corners that are nodes of another element
       - both ends of an edge whose mid is FIXED, a node of another element, a corner elsewhere or
         the mid of another edge
       - nodes that slide at a curved edge (planish_options.rounding) whose other end is not free,
         or at a face whose middle is off their plane
       - nodes of a quadrilateral with triangles on its other side: it is a boundary.
       Pairs of mids in periodic are ignored: mids follow. neighbours and part do not go with cells. */
    const planish_cells *cells;
    /* [n_nodes][dim], with the strides of coordinates: the mesh as it should be. NULL: targets are
       regular. The target of each element is its shape there; its place, rotation and size do not
       matter (planish_options.size_weight makes sizes count). All elements are then measured by mean
       ratios, as with cells of several types: mu is that of T = A W^-1, where A and W are the edges
       of a corner here and there (docs/targets.md). Only calls that make a plan, planish_measure_cells,
       planish_measure_layers and planish_measure_sizes read this array. Every corner of a smoothed element
       must be positive there. Not possible with part or periodic. */
    const double *reference;
    /* [n_elements] not 0: the element belongs to a layer, as planish_find_layers finds them. NULL:
       layers do not count. If no element is marked, neither layers nor reference count. The target of
       an element of a layer has the height across the layer from reference (NULL: from coordinates),
       smoothed along the layer, and regular edges along it (docs/targets.md). Other elements should be
       regular. Flat elements on a layer belong to it. Where a wall was moved into its layers, the rows
       inside give the first heights.
       No element needs to be valid. To measure the mesh after smoothing, give planish_measure_cells
       the mesh before it as reference. */
    const uint8_t *is_layer;
    /* [n_nodes] the edge lengths that elements should have at the nodes of reference (NULL: of
       coordinates). NULL: sizes do not count. Sizes are linear between the nodes, and follow the place
       of an element while it moves. Elements should be regular, with these sizes relative to one
       another: one factor scales all sizes so that the domain would hold the number of elements that it
       has (docs/targets.md). planish_options.size_weight says how much sizes count; it must be above 0 in
       planish_plan_create and planish_fit_move, and with 0 planish_measure_mesh ignores size and reference.
       Beside these only planish_measure_sizes reads this array. planish_measure compares with the sizes at
       the places that elements had when the plan was made, or after the plan's last smoothing. Sizes are
       positive and finite, none larger than 1e12 times another. Not with is_layer, part, or periodic. */
    const double *size;
    /* [n_nodes][dim (dim + 1) / 2] or NULL: like size, but lengths depend on the direction. An edge e
       should have e^T M e = 1, where M is the symmetric matrix m11, m12, m22, m13, m23, m33 of the
       place (in the plane m11, m12, m22). Elements should be regular in these lengths. M^(-1/2), whose
       eigenvalues are edge lengths, is linear between the nodes. One factor scales all metrics, as for
       sizes. planish_options.size_weight may be 0: then only directions and proportions count. Each M
       must be positive definite, and no edge length larger than 1e12 times another. Not with size, nor
       with any field that size excludes. */
    const double *metric;
    const void *reserved[8]; /* NULL */
} planish_mesh;

/* ---- Mesh in several processes -------------------------------------------------------------- */

/** Role of a node in a process that has a part of the mesh. */
typedef enum planish_role {
    PLANISH_ROLE_OWN = 0,    /* this process moves the node, and no other process has it */
    PLANISH_ROLE_SHARED = 1, /* this process moves the node, and others have it as a ghost */
    PLANISH_ROLE_GHOST = 2   /* another process moves it */
} planish_role;

/** Function that takes the value of a ghost that has arrived. */
typedef void planish_take_fn(int32_t ghost, const void *value, void *taker);

/** Part of a mesh that several processes share, and how this process reaches the others: for MPI
 *  or the like (docs/distributed.md). Every node of the mesh is OWN or SHARED in exactly one
 *  process, its owner. The owner has all elements of the node, with all their nodes; those of other
 *  processes are the owner's GHOSTs. The nodes and elements of a part are in the order of the whole
 *  mesh.
 *
 *  All processes make the same calls on their plans, with the same options, at the same time.
 *  Each call then gives the result that it would give with the whole mesh in one process, to the
 *  last bit. Its results (planish_result, planish_quality, planish_progress but for
 *  colour_visits, planish_plan_info but for threads and bytes) are those of the whole mesh.
 *  Results about single nodes and elements, and the counts of planish_check_volumes and
 *  planish_find_infeasible, are those of this process. The arrays given here must stay until the
 *  plan is destroyed.
 *
 *  The thread that called the library calls the functions, in the same order on all processes.
 *  They return 0, or any other number if other processes were not reached. The call then fails
 *  with PLANISH_ERROR_PROCESS, and so does every later call on the plan that needs the other
 *  processes: the plan can then only be destroyed. If a call fails in one process only, the others
 *  wait for it: end them all (MPI_Abort). */
typedef struct planish_part {
    const int64_t *node_number; /* [n_nodes] ascending: numbers of the nodes in the whole mesh */
    const uint8_t *node_role;   /* [n_nodes] of planish_role */
    const uint8_t *is_counted; /* [n_elements] 1 in one of the processes that have the element, that
                                  counts it; 0 in the others */
    /** Set values [n] to their sums over the processes. */
    int (*add)(int64_t *values, int n, void *user);
    /** Set each of values [n] to its largest over the processes. */
    int (*largest)(int64_t *values, int n, void *user);
    /** Send values [n][size] (bytes) of the n nodes node [n], all of them SHARED, to the processes
     *  that have them as ghosts. The neighbours know nothing but these values. At most one send is
     *  open. node and values stay unchanged until receive returns, so communication may overlap
     *  work. */
    int (*send)(const int32_t *node, int64_t n, const void *values, int64_t size, void *user);
    /** Wait for what others have sent; call take(ghost, its value [size], taker) for each. */
    int (*receive)(planish_take_fn *take, void *taker, void *user);
    void *user;
    const void *reserved[4]; /* NULL */
} planish_part;

/* ---- Nodes that can slide ------------------------------------------------------------------- */

/** Knowledge of the surface of a mesh besides its elements; all fields may be 0. Facets are
 *  triangles of tetrahedra, or edges of triangles. */
typedef struct planish_surface {
    const int32_t *region; /* [n_elements] numbers of regions; facets between two of them belong to
                              the surface. NULL: there is one region */
    int64_t n_facets;
    const int32_t *facets;    /* [n_facets][dim] nodes of facets with tags: the shape has an edge
                                 where tags change. Such facets inside the mesh belong to the
                                 surface, too */
    const int32_t *facet_tag; /* [n_facets], or NULL: all 0 */
    int64_t n_edges;
    const int32_t *edges;     /* [n_edges][2] 3-D: nodes of edges that are edges of the shape */
    const int32_t *edge_tag;  /* [n_edges], or NULL: all 0 */
    const uint8_t *is_inside; /* [n_nodes] 1: the caller knows that the node is on no facet of the
                                 surface, interfaces included; this saves time. The nodes of
                                 planish_plan_get_free qualify if none of them is on an interface or
                                 tagged facet. NULL: nothing is known */
    int tagged_only;          /* not 0: a node slides only if all of its facets have tags */
    int slide_interfaces;     /* not 0: nodes of curved interfaces between regions slide, too */
    double tolerance;         /* how far off a plane or line its nodes may be, as a fraction of the
                                 diagonal of the bounding box, 0 .. 1e-3; 0: 1e-8 */
    /* [n_facets + 1] from 0: the nodes of facet i are facets[facet_offset[i]] ..
       facets[facet_offset[i + 1] - 1], in the order of VTK: 3, 4, 6, 8 or 9, in 2-D 2 or 3. Mids
       are not looked at. Corners of quadrilaterals become FIXED. NULL: dim nodes each. */
    const int64_t *facet_offset;
    const struct planish_shape *shape; /* planish_find_slides: nodes that do not slide on a plane or
                                          line slide on its patches and curves; NULL: they stay */
    double crease_angle; /* planish_shape_create: an edge where facets turn by more than this angle,
                            in degrees, 0 .. 180, is a feature; other edges are features only by
                            their tags. 0: the library finds features (docs/surfaces.md) */
    const void *reserved[4]; /* NULL */
} planish_surface;

typedef struct planish_slide_info {
    int64_t n_surface;  /* nodes of the surface */
    int64_t n_on_plane; /* nodes that can slide on planes */
    int64_t n_on_line;  /* on lines */
    int64_t n_on_patch; /* on curved patches */
    int64_t n_on_curve; /* on curves */
    int64_t reserved[2];
} planish_slide_info;

/** Find the nodes that can slide without a change of the mesh's shape: nodes within planar pieces of
 *  the boundary or of interfaces between regions, and nodes within straight edges between such pieces.
 *  Fill constraint [n_nodes] and direction [n_nodes][dim] for planish_mesh.
 *  - A node that mesh->constraint does not call FREE keeps its constraint (NULL: all nodes are FREE).
 *  - Nodes of the surface that cannot slide become FIXED. So do nodes of interfaces that cannot slide,
 *    nodes of tagged facets and edges that the mesh does not have, and nodes at the place of another
 *    node (for example where two parts each have the nodes between them).
 *  - With mesh->cells these become FIXED, too: corners that cells hold, ends of a curved edge of the
 *    surface, and corners of a triangle that such an edge makes curved. An edge is curved if its mid
 *    is off the middle by more than tolerance. Mids keep their constraints, but FREE ones of facets
 *    between elements get that of an end, so that they follow and do not move on their own.
 *  - With surface->shape a node that only curved facets or edges hold becomes ON_PATCH or ON_CURVE
 *    instead of FIXED, if it lies on a patch or curve of the shape. Second-order facets and edges
 *    need a shape with mids (planish_shape_info), facets between regions need slide_interfaces.
 *    Nodes where facets of first and second order meet become FIXED.
 *  surface and info may be NULL. threads: as in planish_options. Errors: _ARGUMENT (also a shape of
 *  another number of nodes), _MESH, _MEMORY. */
PLANISH_API int planish_find_slides(const planish_mesh *mesh, const planish_surface *surface,
                                    int threads, uint8_t *constraint, double *direction,
                                    planish_slide_info *info, planish_error *error);

/* ---- Curved surfaces ------------------------------------------------------------------------ */

/** Original shape of a surface in space: patches of smooth triangles, the curves between them, and
 *  corners. No call changes a shape. */
typedef struct planish_shape planish_shape;

typedef struct planish_shape_info {
    int64_t n_nodes;   /* of the surface */
    int64_t n_facets;  /* triangles; a quadrilateral is two, but with mids one */
    int64_t n_patches; /* pieces between features */
    int64_t n_edges;   /* edges of features */
    int64_t n_creases; /* edges of n_edges that are features only because the surface bends there */
    int64_t n_on_patch; /* nodes that can slide on patches */
    int64_t n_on_curve; /* nodes that can slide on curves */
    int64_t n_corners;  /* nodes that cannot slide */
    double edge_length; /* mean length of the edges, in units of the coordinates */
    int64_t
        n_mids; /* nodes in the middle of edges or facets of second order; the surface is then the
                           curved one of these facets, edges count as two, and corners alone are in
                           n_on_patch, n_on_curve and n_corners */
    int64_t n_open_edges;        /* edges of one facet */
    int64_t n_nonmanifold_edges; /* edges of more than two facets */
    int64_t n_conflict_edges; /* edges of two facets that cannot be oriented alike, as in a Moebius
                                 strip */
    int64_t n_turned; /* facets that are elements and list their nodes in the opposite order to most
                         facets that edges join to them */
    int64_t n_flat;   /* facets without area */
    int64_t reserved[8];
} planish_shape_info;

/** Make the shape of the surface of mesh, which is in space: the boundary, interfaces between
 *  regions, and tagged facets. surface (may be NULL) gives tags, regions and crease_angle; its shape
 *  is ignored. The shape keeps a copy of mesh->coordinates, so that many calls cause no drift; it does
 *  not refer to the arrays of mesh. A quadrilateral is two triangles there, as a rule cut at its corner of the
 *  lowest index. threads: as in planish_options. info may be NULL.
 *  Errors: _ARGUMENT, _MESH, _MEMORY, _PARTS (mesh->part). */
PLANISH_API int planish_shape_create(const planish_mesh *mesh, const planish_surface *surface,
                                     int threads, planish_shape **shape, planish_shape_info *info,
                                     planish_error *error);

/** Free shape; NULL is allowed. */
PLANISH_API void planish_shape_destroy(planish_shape *shape);

/** Class of a node of a shape. */
typedef enum planish_shape_class {
    PLANISH_SHAPE_NONE = 0, /* it is not on the surface */
    PLANISH_SHAPE_PATCH = 1,
    PLANISH_SHAPE_CURVE = 2,
    PLANISH_SHAPE_CORNER = 3 /* end of curves, or the surface is unclear there: the node stays */
} planish_shape_class;

/** Fill node_class [nodes of the mesh] with planish_shape_class. */
PLANISH_API void planish_shape_get_classes(const planish_shape *shape, uint8_t *node_class);

/** Fill edge [planish_shape_info.n_edges][2] with the nodes, in the mesh, of the edges of features. */
PLANISH_API void planish_shape_get_edges(const planish_shape *shape, int32_t *edge);

/** How far a surface is off its shape. Bounds are proved for every point, not sampled. */
typedef struct planish_shape_distance {
    double distance;      /* largest distance of a point of the surface from the shape, in units of
                             the coordinates; infinite: not proved */
    double distance_back; /* largest distance of a point of the shape from the surface */
    double in_edges, back_in_edges; /* largest distances, in mean edge lengths of the shape there */
    int64_t n_unproved;             /* facets of surface and shape without a proved bound */
    double max_bend; /* largest angle between facets at an edge that is not a feature, degrees */
    double max_bend_before; /* largest such angle of the shape */
    int64_t reserved[8];
} planish_shape_distance;

/** Bound how far the surface of mesh, at mesh->coordinates, is off shape, which was made of a mesh of the
 *  same elements. Errors: _ARGUMENT (another number of nodes), _MESH, _MEMORY. */
PLANISH_API int planish_shape_measure(const planish_shape *shape, const planish_mesh *mesh,
                                      int threads, planish_shape_distance *distance,
                                      planish_error *error);

/* ---- Regions ------------------------------------------------------------------------------- */

/** Type of the numbers of an array. */
typedef enum planish_number {
    PLANISH_NUMBER_INT32 = 0,
    PLANISH_NUMBER_INT64 = 1,
    PLANISH_NUMBER_INT8 = 2,
    PLANISH_NUMBER_INT16 = 3,
    PLANISH_NUMBER_UINT8 = 4,
    PLANISH_NUMBER_UINT16 = 5,
    PLANISH_NUMBER_UINT32 = 6,
    PLANISH_NUMBER_UINT64 = 7,
    PLANISH_NUMBER_FLOAT32 = 8,
    PLANISH_NUMBER_FLOAT64 = 9
} planish_number;

/** Array of one number per element, as files have them. The caller owns all of it. */
typedef struct planish_cell_array {
    const char *name;        /* or NULL */
    const void *values;      /* [n_elements] numbers of type, one after the other */
    planish_number type;     /* of the numbers */
    int is_region;           /* 1: the array tells regions; 0: it does not */
    const void *reserved[4]; /* NULL */
} planish_cell_array;

/** Return the rank of an array's name as that of regions, letter case ignored. Above 0: arrays of
 * that name tell regions ("gmsh:physical", "MaterialIDs", ...); a clearer name has a lower rank.
 * -1: the array tells which process has an element, or where elements come from ("partition",
 * "rank", "vtkGhostType", "vtkOriginalCellIds", ...); it tells regions only if the caller says so.
 * 0: the name says nothing, or is NULL. */
PLANISH_API int planish_rank_region_name(const char *name);

/** Find the arrays that tell regions (docs/algorithm.md, "Regions"): is_region of each of arrays
 *  [n_arrays] becomes 1 or 0. An array tells regions under three conditions: all its values are
 *  whole numbers within 64 bits, at least two values differ, and at most half of the facets between
 *  two elements lie between different values. Its name may decide (planish_rank_region_name): an array
 *  of -1 does not tell regions; of the arrays above 0 the one with the lowest rank does if its
 *  values differ. The mesh's coordinates are not used. mesh may be a surface in space; its facets are
 *  then the edges of elements. threads: as in planish_options. Errors, with arrays untouched: _ARGUMENT,
 *  _MESH, _MEMORY, _PARTS (mesh->part: ask for the whole mesh). */
PLANISH_API int planish_find_regions(const planish_mesh *mesh, planish_cell_array *arrays,
                                     int n_arrays, int threads, planish_error *error);

/** Combine the arrays whose is_region is not 0 into one region per element: two elements have the
 * same region where they have the same value in each array. region [n_elements] is filled with
 * numbers from 0 in the order in which they first appear; all 0 if no array tells regions.
 * *n_regions (may be NULL) counts them. planish_surface.region and planish_find_interfaces take
 * the result. Errors, with region untouched: _ARGUMENT (a value is no whole number within 64 bits),
 * _MEMORY. */
PLANISH_API int planish_combine_regions(int64_t n_elements, const planish_cell_array *arrays,
                                        int n_arrays, int32_t *region, int64_t *n_regions,
                                        planish_error *error);

/** Find the nodes between regions: is_between [n_nodes] is filled with 1 for nodes, mids too, whose
 *  elements have different numbers in region [n_elements], else with 0. *n_between (may be NULL)
 *  counts the ones. Hold these nodes (PLANISH_CONSTRAINT_FIXED) to keep interfaces where they are.
 *  mesh may be a surface in space; there a shape made with planish_surface.region keeps interfaces,
 *  too, and their nodes slide along them. A part of a mesh finds the nodes between its own
 *  elements. threads: as in planish_options. Errors: _ARGUMENT, _MESH, _MEMORY. */
PLANISH_API int planish_find_interfaces(const planish_mesh *mesh, const int32_t *region,
                                        int threads, uint8_t *is_between, int64_t *n_between,
                                        planish_error *error);

/* ---- Elements thin in layers ---------------------------------------------------------------- */

/** Find the elements that are thin in layers, as in a boundary layer or in a stretched mesh. Such
 * elements are thin on purpose, and smoothing would make them regular. The shortest edge of a
 * simplex in a layer is at most a quarter of its longest edge. The shortest edges of neighbouring
 * elements are parallel to it, and some of these elements lie beside it in the layer. Slivers,
 * elements that are bad by chance, and slices around an axis do not count. The rows above and below
 * belong to the layer while the shortest edge of their elements continues across the layer. This
 * edge must be shorter than the other edges by a factor of 1.2. In a mesh that is stretched everywhere in
 * one direction, all simplices that are thin in that direction count (docs/algorithm.md).
 * Of mesh->cells, wedges, hexahedra and quadrilaterals of order 1 and 2 count, too. The short edges
 * of such an element are those between the triangles of a wedge, or one family of parallel edges of
 * the others. They are at most a quarter of all other edges, and the element is valid with a scaled
 * Jacobian of at least 0.3. Rows continue along the layer, up to 16 elements, over valid elements
 * with a factor of 1.2. They continue across the layer over valid elements that lean. A layer does
 * not count if it has fewer than 8 elements. Nor does it if it touches more than one badly shaped
 * element per twenty of its own; elements stacked on the layer are not among these.
 * is_layer [n_elements] is filled with 0 or 1; *n_layer (may be NULL) counts the ones. The call
 * costs little where few elements are thin. threads: as in planish_options. Errors: _ARGUMENT,
 * _MESH, _MEMORY, _PARTS (mesh->cells and part). */
PLANISH_API int planish_find_layers(const planish_mesh *mesh, int threads, uint8_t *is_layer,
                                    int64_t *n_layer, planish_error *error);

/* ---- Options ------------------------------------------------------------------------------ */

/** How nodes are moved. The paper compares with the Laplacian methods. They check nothing and may
 *  invert elements. Of the promises of planish_smooth only those on fixed nodes, bounds and bits
 *  hold for them. */
typedef enum planish_method {
    PLANISH_METHOD_PLANISH = 0,         /* constrained optimisation of each star */
    PLANISH_METHOD_LAPLACIAN = 1,       /* to the mean of the neighbours */
    PLANISH_METHOD_AREA_LAPLACIAN = 2,  /* to the mean of the elements' centroids, by their
                                           volumes */
    PLANISH_METHOD_LENGTH_LAPLACIAN = 3 /* to the mean of the neighbours, by their distances */
} planish_method;

/** Aspect ratio AR of an element that is minimised: 1 for the regular element and larger for any
 *  other. In a mixed mesh AR^2 is the mean over the corners of an element. */
typedef enum planish_objective {
    PLANISH_OBJECTIVE_RADIUS_RATIO = 0, /* R/(3r), R/(2r) in 2-D: the paper's; in a mixed mesh the
                                           mean ratio */
    PLANISH_OBJECTIVE_MEAN_RATIO = 1,   /* inverse mean ratio: mean square edge to that of the
                                           regular element of the same volume */
    PLANISH_OBJECTIVE_EDGE_RATIO = 2    /* longest edge to shortest, smoothed: 0.946 to 1 of it, see
                                           docs/algorithm.md; in a mixed mesh of a corner's edges */
} planish_objective;

/** Quantity that a last phase improves after the objective has converged: the worst value in the
 *  mesh. planish_smooth, not planish_plan_create, checks that the elements have that measure. */
typedef enum planish_worst {
    PLANISH_WORST_NONE = 0,           /* no such phase */
    PLANISH_WORST_RADIUS_RATIO = 1,   /* the largest radius ratios */
    PLANISH_WORST_ANGLE = 2,          /* the smallest and largest angles, dihedral in 3-D, by their
                                       sines. For a mesh of simplices alone, as the radius ratio */
    PLANISH_WORST_ASPECT_RATIO = 3,   /* the largest mean ratios of corners */
    PLANISH_WORST_SCALED_JACOBIAN = 4 /* the smallest scaled Jacobians of corners */
} planish_worst;

/** Unit of a length. */
typedef enum planish_length_unit {
    PLANISH_UNIT_MESH = 0, /* units of the coordinates */
    PLANISH_UNIT_EDGE = 1  /* mean length of the node's edges at the start */
} planish_length_unit;

/** Directions along which a node's local problem is searched. */
typedef enum planish_search {
    PLANISH_SEARCH_NEWTON = 0,         /* shifted Newton steps, mostly one or two per visit */
    PLANISH_SEARCH_FLETCHER_REEVES = 1 /* conjugate directions, the paper's (its equation 3) */
} planish_search;

/** Tolerance of minimum volumes, the paper's threshold: an element meets its minimum volume delta
 * unless g = 1 - V/delta is above this. */
#define PLANISH_VOLUME_TOLERANCE 0.003

/** planish_options.surface_tolerance if it is 0, in edges of the shape. */
#define PLANISH_SURFACE_TOLERANCE 0.05

/** Format in which a coordinate is stored in the end. The positions of moving nodes are rounded
 *  to this format before they are judged. With PLANISH_PRECISION_FLOAT the coordinates given should
 *  be floats, too: fixed nodes keep their coordinates unrounded. */
typedef enum planish_precision {
    PLANISH_PRECISION_DOUBLE = 0,
    PLANISH_PRECISION_FLOAT = 1,
    PLANISH_PRECISION_ROUNDED = 2 /* what planish_options.round says */
} planish_precision;

/** Purpose of a sweep. */
typedef enum planish_phase {
    PLANISH_PHASE_SMOOTH = 0, /* to lower the objective */
    PLANISH_PHASE_UNTANGLE,   /* this sweep, or the last one, untangled elements or brought them
                                 above their minimum volume; F may have risen */
    PLANISH_PHASE_WORST       /* to improve the worst elements (options.worst); the values are those
                                 before the sweep until the sweep's result is accepted */
} planish_phase;

/** Kernel variants; all of them give the same bits. */
typedef enum planish_isa {
    PLANISH_ISA_AUTO = 0,   /* the fastest that the CPU has */
    PLANISH_ISA_PLAIN = 1,  /* scalar C, the reference */
    PLANISH_ISA_VECTOR = 2, /* vectors of the compiler's base instruction set */
    PLANISH_ISA_AVX2 = 3,   /* x86-64-v3 */
    PLANISH_ISA_AVX512 = 4  /* x86-64-v4 */
} planish_isa;

typedef struct planish_progress {
    int sweep;      /* sweeps begun so far, from 1; 0 in calls before the first: colour is 0 */
    int colour;     /* colours done in this sweep, 1 .. n_colours; where untangling moves many nodes
                       together it stays n_colours for many calls; 0: between two sweeps */
    int n_colours;  /* colours of the plan */
    int sweep_done; /* not 0: the last call of this sweep, which may have been cut short */
    double rms;     /* RMS of AR (RR by default) over the valid elements after the last sweep:
                       measured at first and when it has fallen much, else tracked by what
                       the visits report */
    double rms_movable;         /* rms over the valid elements with a movable node */
    double objective;           /* F over the valid elements after the last sweep; rms by default */
    int64_t n_inverted;         /* elements that are not positive, after the last sweep */
    int64_t n_below_min_volume; /* elements below 0.997 of their minimum volume after it */
    planish_phase phase;        /* known when the sweep is done; until then, and between two sweeps,
                                   that of the sweep before, or _SMOOTH once untangling or
                                   options.worst has ended */
    int64_t visits;             /* nodes visited in this sweep; 0 until sweep_done */
    double seconds;             /* time of this sweep so far */
    double elapsed;             /* time of planish_smooth so far, seconds */
    int64_t colour_visits; /* nodes visited in the colour that this call is after, or those that
                              were moved together; 0 on the last call of a sweep */
    const struct planish_positions
        *positions; /* where the nodes are, for planish_progress_get_coordinates, until this call
                       returns; NULL unless sweep_done */
    int64_t reserved[2];
} planish_progress;

/** Function that planish_smooth calls on the caller's thread after every colour and once more at the
 * end of every sweep. During a long search for proofs between two sweeps it is called 20 times a
 * second. A result other than 0 ends the smoothing there: the mesh is then no worse than before,
 * and valid if it was valid. A sweep that is cut short (by this function or the time limit) still
 * gets its last call, whose result does not matter. The caller's coordinates change only when
 * planish_smooth returns; planish_progress_get_coordinates has those at the end of a sweep. The
 * function must not use the plan, except for planish_measure, planish_measure_elements and, with
 * options whose progress is NULL, planish_check_volumes. With bind, the calling thread is bound
 * meanwhile, and threads that the function starts inherit that.
 */
typedef int planish_progress_fn(const planish_progress *progress, void *user);

/** Project a node that slides onto its surface. point [dim] is near the surface: change it to the
 *  nearest place that the node may have. Fill direction [dim], of any length but 0, with
 *  - the surface's normal there, and return PLANISH_CONSTRAINT_ON_PLANE
 *  - or the curve's direction there, and return PLANISH_CONSTRAINT_ON_LINE
 *  - or nothing, and return PLANISH_CONSTRAINT_FIXED: the node may not be near there.
 *  Called from several threads at a time. Answers must depend on node and point alone, or the bits of
 *  the result depend on the number of threads. */
typedef planish_constraint planish_project_fn(int64_t node, double *point, double *direction,
                                              void *user);

/** Return the number nearest to value that can be stored, for example in a field of text with few
 *  digits. round(round(x)) is round(x), and round(x) <= round(y) for x <= y. Called from several
 *  threads at a time. Answers must depend on value alone. */
typedef double planish_round_fn(double value, void *user);

/** Source of a plan's memory; by default the system's. Any of the threads that work for the plan
 *  may call the functions, several at a time. */
typedef struct planish_allocator {
    void *(*allocate)(size_t bytes, void *user); /* as malloc: NULL if there is none */
    void (*release)(void *block, void *user);    /* as free, but never of NULL */
    void *user;                                  /* handed to both */
} planish_allocator;

/** Task number index, 0 .. n_tasks - 1. */
typedef void planish_task_fn(void *data, int index);

/** Function that runs tasks on threads of the caller. Call task(data, index) once for each index
 *  below n_tasks, on any number of threads at a time, and return when all tasks have returned. The
 *  result has the same bits however tasks are spread, also one after the other. The library calls
 *  this function on the thread that called the library. */
typedef void planish_parallel_fn(int n_tasks, planish_task_fn *task, void *data, void *user);

typedef enum planish_log_level {
    PLANISH_LOG_NOTE = 1,  /* something about the mesh or the result that is worth knowing */
    PLANISH_LOG_DETAIL = 2 /* what is being done */
} planish_log_level;

/** Function that takes one line of text, without a line end, on the thread that called the library.
 *  It must not use the plan. */
typedef void planish_log_fn(planish_log_level level, const char *text, void *user);

typedef struct planish_options {
    size_t struct_size; /* set by planish_options_init; calls refuse another size than theirs */
    int threads; /* 1 .. 1024; 0: as many as OpenMP would use, fewer for a small mesh, with bind at
                    most one per core. If the system cannot start that many, libgomp ends the
                    process: see docs/architecture.md */
    int bind;    /* not 0: bind each thread to a core while the library runs, if
                    there are as many threads as cores, more than one, and hwloc */
    planish_isa isa;             /* kernel variant */
    planish_method method;       /* how nodes are moved */
    planish_objective objective; /* AR in F = mu1 RMS(AR) + mu2 RMS(g) */
    planish_search search;       /* search direction of the local problem */
    double min_volume;           /* delta, the minimum volume (area in 2-D) of every element; or */
    double min_volume_fraction;  /* delta as a fraction of the domain's volume. Set at most one of
                                    the two; 0: no minimum, elements only stay positive */
    double area_weight;          /* mu2 = 1 - mu1, 0 .. 1: weight of g = 1 - V/delta in F; if it is
                                    above 0, every element needs a delta */
    const double *lower, *upper; /* [n_nodes][dim] whatever the strides: bounds, or NULL: none */
    double box_lower[3];         /* bounds for all nodes, -INFINITY and INFINITY: none; a node */
    double box_upper[3];         /* that starts outside of its bounds stays where it is; mids follow
                                    their ends */
    double max_displacement;     /* how far from its start a node may go; 0: any distance */
    double rounding; /* elements of order 2: largest distance of a mid from the middle of
                                    a straight edge; 1e-6 of the element's longest edge is always
                                    allowed. Beyond, an element is curved; within rounding it is if it
                                    is not valid, or its least Bezier coefficient of det J at most half
                                    of their mean. With mesh.cells a call refuses another value than
                                    that of the plan */
    planish_length_unit displacement_unit; /* of max_displacement */
    planish_precision precision;           /* format in which coordinates are stored in the end */
    int untangle;           /* not 0 (the default): repair elements that are not positive first,
                               where possible, and elements below their minimum volume during
                               smoothing; 0: leave them alone */
    planish_worst worst;    /* measure of the worst elements that is improved in the end, by
                               rounds of joint steps that max_sweeps does not count */
    double worst_rise;      /* largest relative rise of F for the worst elements; 0.01 */
    int max_sweeps;         /* largest number of smoothing sweeps, 0 or more, and as many again
                               after nodes were put back (planish_result); untangling has its
                               own bound. In a slow mesh each Newton step and each iteration of
                               L-BFGS counts as a sweep */
    double tolerance;       /* relative fall of the movable RMS that counts as converged; a star
                               that falls by less than half of it sets off no visits around it */
    double time_limit;      /* seconds, 0: none */
    double only_worse_than; /* move only nodes of bad elements: elements with an RR (AR) above this,
                               below their minimum volume, or not positive; 0: all nodes.
                               planish_smooth visits only stars with a bad element.
                               planish_plan_create lets only nodes of bad elements move, so that
                               a plan for few nodes is cheap; sweeps then end a little earlier */
    int rings;              /* also move nodes of this many rings of elements around, 0 .. 100;
                               ignored without only_worse_than and around. With
                               only_worse_than, elements that are not positive have at least 4 */
    /* In planish_plan_create: only these nodes can move, and the nodes of `rings` rings of elements
       around them. The plan knows nothing about the rest of the mesh; see there. */
    int64_t n_around;               /* at least 1 with around, 0 without */
    const int64_t *around;          /* [n_around] nodes, in any order; NULL: all nodes */
    const int64_t *around_elements; /* [n_around] an element of each; NULL: the plan finds them */
    planish_progress_fn *progress;  /* or NULL */
    void *progress_user;            /* handed to progress */
    planish_project_fn
        *project;       /* for nodes with PLANISH_CONSTRAINT_ON_SURFACE; NULL: these nodes do not
                           move, but count as sliding */
    void *project_user; /* handed to project */
    /* These reach plans, which keep them (planish_plan_create, planish_measure_mesh, planish_fit_move),
       and planish_smooth_surface. All other calls have the system's memory and OpenMP's threads, and log
       nothing: */
    const planish_allocator *allocator; /* copied; NULL: the system's */
    planish_parallel_fn *parallel;      /* NULL: OpenMP's threads. Else threads is the number of
                                           tasks, and none is bound */
    void *parallel_user;                /* handed to parallel */
    planish_log_fn *log;                /* or NULL */
    void *log_user;                     /* handed to log */
    planish_round_fn *round;            /* with PLANISH_PRECISION_ROUNDED */
    void *round_user;                   /* handed to round */
    double curve_quality; /* 0 .. 1: mids move on their own in curved elements whose least Bezier
                             coefficient of det J is below this fraction of the coefficients' mean;
                             on the boundary they only follow their edges. 0.3 by default, 0: none */
    const struct planish_shape *
        shape; /* for nodes with PLANISH_CONSTRAINT_ON_PATCH and _ON_CURVE, made from a mesh with the
                  same nodes. Give plan and call the same shape. NULL: these nodes do not move, but
                  count as sliding */
    double surface_tolerance; /* largest distance of the surface from the shape; 0:
                                 PLANISH_SURFACE_TOLERANCE edges */
    planish_length_unit surface_tolerance_unit; /* unit of surface_tolerance; edges are those of the
                                                   shape at the node */
    double
        size_weight; /* 0 .. 1, for planish_plan_create with planish_mesh.reference, size or metric: w in
                        (1 - w) mu^2 + w (tau + 1 / tau) / 2, which replaces mu^2 in F and in AR as
                        planish_smooth bounds it; tau is the measure of a corner divided by that of
                        its target */
    const void *reserved[8]; /* NULL */
} planish_options;

/** Fill in the defaults: as many threads as OpenMP would use, fewer for a small mesh, not bound; the
 * fastest kernel; radius ratios by constrained optimisation with Newton's direction; no minimum
 * volume, no bounds; doubles; untangling; worst NONE, worst_rise 0.01; 200 sweeps, tolerance 1e-5,
 * no time limit; all nodes; no callback. */
#define planish_options_init(options) planish_options_init_sized((options), sizeof *(options))

/** Do the work of planish_options_init for a structure of size bytes: the caller's sizeof. No byte
 *  beyond is written, whatever size the library's structure has. options may be NULL. */
PLANISH_API void planish_options_init_sized(planish_options *options, size_t size);

/* ---- Another surface ------------------------------------------------------------------------ */

/** Fit of the surface of a mesh of solids to another surface, made of other triangles: the place of each
 *  node there. A node of a patch belongs at the nearest point of the other surface that faces the same
 *  way. A node of a curve belongs on a curve, a corner at a corner, with such sides. If none is in reach,
 *  the node belongs on a patch, and stays there. */
typedef struct planish_fit planish_fit;

typedef struct planish_fit_info {
    int64_t n_nodes;        /* nodes of the mesh's boundary */
    int64_t n_on_patch;     /* nodes that belong on patches of the other surface */
    int64_t n_on_curve;     /* nodes that belong on curves */
    int64_t n_on_corner;    /* nodes that belong at corners */
    int64_t n_out_of_reach; /* nodes without a place; they stay */
    int64_t n_held;         /* nodes that the caller, or elements that are not smoothed, hold */
    int64_t n_off;          /* nodes that are not at their places yet */
    double farthest; /* largest distance of a node from its place, in units of the coordinates */
    int64_t n_cut; /* corners of three bends or more that have no corner, though one is in reach */
    int64_t
        n_unclear; /* of n_out_of_reach: several pieces of the surface would cover the same one, and are held */
    int64_t
        n_unused; /* pieces of the other surface, each joined by edges, where no node has a place */
    int64_t reserved[5];
} planish_fit_info;

/** Find the places of the boundary nodes of mesh on the shape onto. mesh has solids of order 1, and
 *  shape is its shape. onto is made from other triangles (planish_shape_create of a mesh of faces,
 *  or of another mesh of solids). Keep both shapes as long as fit. reach: largest distance of a
 *  node from its place, in mean lengths of its edges; 0: 3. options (NULL: defaults): threads,
 *  precision, round. Nodes that mesh->constraint calls FIXED stay. info may be NULL.
 *  Errors: _ARGUMENT (elements of order 2, periodic pairs, a plane mesh), _MESH (a wrong node number or
 *  coordinate; no node is in reach; one is more than 1e30 times as large), _MEMORY, _PARTS. */
PLANISH_API int planish_fit_create(const planish_mesh *mesh, const planish_shape *shape,
                                   const planish_shape *onto, double reach,
                                   const planish_options *options, planish_fit **fit,
                                   planish_fit_info *info, planish_error *error);

/** Free fit; NULL is allowed. */
PLANISH_API void planish_fit_destroy(planish_fit *fit);

/** Move the nodes of mesh to their places, as far as elements stay valid. The call works in rounds, and
 *  smooths the other nodes between them; nodes on the other surface slide along it. Elements may get
 *  worse, but none becomes invalid. mesh is the mesh of fit; coordinates have its strides, and may
 *  differ from those of an earlier call. options (NULL: defaults) are as for planish_smooth, except that
 *  project, shape, method, worst, max_sweeps, only_worse_than and around are ignored, and bounds hold for
 *  the smoothing only; progress is called in its sweeps. time_limit is for the whole call. info (may be
 *  NULL) tells how many nodes are not at their places; planish_smooth, or another call, may make room for
 *  them.
 *  Errors: as of planish_plan_create and planish_smooth; coordinates are then untouched. */
PLANISH_API int planish_fit_move(planish_fit *fit, const planish_mesh *mesh, double *coordinates,
                                 const planish_options *options, planish_fit_info *info,
                                 planish_error *error);

/** Fill constraint [n_nodes] for the nodes of the mesh's surface, interfaces between regions included:
 *  nodes that slide along the other surface become ON_SURFACE, all others FIXED. Smooth with
 *  options.project = planish_fit_project and project_user = fit. Entries of other nodes do not change. */
PLANISH_API void planish_fit_constrain(const planish_fit *fit, uint8_t *constraint);

/** Project a node on the other surface: a planish_project_fn whose user is a fit. */
PLANISH_API planish_constraint planish_fit_project(int64_t node, double *point, double *direction,
                                                   void *fit);

/** Bound the distance of the boundary of mesh, at mesh->coordinates, from the other surface (distance),
 *  and the distance back; edge lengths are those of the mesh's boundary. Bends are 0. The bounds are
 *  proved, as those of planish_shape_measure. Errors: _ARGUMENT, _MESH, _MEMORY. */
PLANISH_API int planish_fit_measure(const planish_fit *fit, const planish_mesh *mesh,
                                    planish_shape_distance *distance, planish_error *error);

/* ---- Plan --------------------------------------------------------------------------------- */

/** Stars, colouring, ordering and scratch of one connectivity. A function with a const plan changes
 *  no later result. const does not mean that two threads may use the plan. */
typedef struct planish_plan planish_plan;

/** Figures of a plan. -1: not counted, as a plan counts only what it needs. */
typedef struct planish_plan_info {
    int64_t n_free;           /* nodes that may move anywhere */
    int64_t n_sliding;        /* nodes that may move on a plane, line or surface */
    int64_t n_unused;         /* nodes of no element; -1 with only_worse_than or around */
    int64_t n_fixed_elements; /* elements without a movable node */
    int64_t n_components;     /* components: elements joined by facets. -1 in most meshes, where all
                                 measures have one sign and no facet contradicts it */
    int64_t n_negative_order; /* elements whose listed order contradicts the orientation that the
                                 plan has found; it does not change when nodes move
                                 (planish_quality.n_reversed compares signs of measures, which do).
                                 All elements of a mirrored mesh */
    /* These are -1 with only_worse_than or around, if all measures have one sign: */
    int64_t n_boundary_facets;    /* facets of one element */
    int64_t n_nonmanifold_facets; /* facets of more than two elements, whose nodes are held */
    int64_t n_duplicate_elements; /* elements with the corners of an earlier one, or (of other types
                                     than simplices) with a facet twice, whose nodes are held */
    int n_colours;                /* sets of free or sliding nodes that do not share an element */
    int threads;                  /* number of threads that work for the plan */
    const char *isa;              /* name of the kernel variant in use; static text */
    const char *binding;          /* where the threads are; text of the plan */
    int64_t bytes;                /* memory of the plan, including memory kept for the next call */
    int64_t n_wrapped; /* elements that wrap around a periodic domain; their nodes are held */
    int64_t reserved[7];
} planish_plan_info;

/** Make a plan for mesh: validate it, find its orientation and its boundary, order and colour its
 *  movable nodes. Uses threads, bind and isa of options (NULL: defaults), its allocator, parallel
 *  and log, and only_worse_than, around, rings and minimum volumes to choose the nodes. The plan
 *  refers to mesh->elements (not to elements64) or the arrays of mesh->cells, and to mesh->part with
 *  all that it points to: these must stay as they are until planish_plan_destroy; the other arrays
 *  are not read after the return.
 *  The plan decides the orientation of elements from these coordinates: make another plan for a
 *  mirrored copy. Nodes with more than 43690 elements are held. A mesh without elements is an error.
 *
 *  With options.around the plan covers only the elements with one of its nodes; so do its info,
 *  results and planish_measure. If around_elements and mesh->neighbours are given, time and memory
 *  depend on these elements only: nothing else of the mesh is read or checked, except periodic
 *  pairs. The elements of a node are then those that facets at the node join to the given element.
 *  Otherwise the plan looks at all elements once. The plan decides the positive orientation from its
 *  own elements, so it cannot notice if all of them are inverted. Nodes of periodic pairs stay.
 *  around excludes only_worse_than and min_volume_fraction, which need the whole mesh. The bits are
 *  the same as with a plan for the whole mesh that fixes the other nodes, unless elements are
 *  untangled, raised to a minimum volume or improved for options.worst.
 *
 *  With only_worse_than, neighbours save passes over the elements if few elements are bad; the bits
 *  are the same. A mesh in parts gives the bits of one process if it is smoothed from the coordinates
 *  that the plan was made with; from others, a process may look at fewer elements when it untangles.
 *
 *  Errors: _ARGUMENT, _MESH (element or node is set, but for a mesh without elements), _MEMORY;
 *  with mesh->part also _PROCESS, and _PARTS (around, periodic pairs). */
PLANISH_API int planish_plan_create(const planish_mesh *mesh, const planish_options *options,
                                    planish_plan **plan, planish_error *error);
/** Destroy plan, which may be NULL. */
PLANISH_API void planish_plan_destroy(planish_plan *plan);
/** Fill *info with the figures of plan. For NULL every field is 0. */
PLANISH_API void planish_plan_get_info(const planish_plan *plan, planish_plan_info *info);
/** Fill is_free [n_nodes of the mesh] with 1 for free nodes, which may move anywhere, and with 0
 *  for all others: sliding nodes and mids (which follow) included. */
PLANISH_API void planish_plan_get_free(const planish_plan *plan, uint8_t *is_free);

/** Why a node does not move, as bits: a node may have several reasons. */
typedef enum planish_hold_reason {
    PLANISH_HELD_BOUNDARY = 1,     /* on a facet of one element */
    PLANISH_HELD_FIXED = 2,        /* planish_mesh.constraint is PLANISH_CONSTRAINT_FIXED, or
                                      planish_mesh.cells hold the node */
    PLANISH_HELD_PERIODIC = 4,     /* in a pair of planish_mesh.periodic */
    PLANISH_HELD_DOUBLED = 8,      /* at exactly the place of another node that is not inside the
                                      mesh; never the only reason */
    PLANISH_HELD_NONMANIFOLD = 16, /* on a facet of more than two elements, on a duplicate element,
                                      where neighbours cannot be oriented alike, or on too many
                                      elements */
    PLANISH_HELD_WRAPPED = 32,     /* on an element that wraps around a periodic domain */
    PLANISH_HELD_NOT_CHOSEN = 64,  /* not among the nodes of options.only_worse_than or around */
    PLANISH_HELD_UNUSED = 128      /* of no element; then the only reason */
} planish_hold_reason;

/** Find out why nodes do not move. Fill reason [n_nodes of the mesh] with 0 for nodes that may move
 *  or slide, and with the bits of each planish_hold_reason of every other node. coordinates
 *  [n_nodes][dim] (or as the mesh's strides say) are needed for PLANISH_HELD_DOUBLED alone; NULL:
 *  no node has that bit. The call costs about as much as the search for the boundary in
 *  planish_plan_create. With options.around the reasons of nodes outside the plan are
 *  PLANISH_HELD_NOT_CHOSEN. A mid has no reason if an end of its edge moves, else those of both;
 *  options.curve_quality may move it nevertheless.
 *  With a mesh in parts the reasons are those of the nodes that this process moves; the call does
 *  not wait for other processes. The result is the same for any number of threads. Errors:
 *  _ARGUMENT, _MEMORY; reason is then untouched. */
PLANISH_API int planish_plan_get_held(const planish_plan *plan, const double *coordinates,
                                      uint8_t *reason, planish_error *error);

/** Find the elements that wrap around a periodic domain in which each node occurs once: drawn
 *  plainly, they reach from one side to the other. Their nodes are held, and they do not influence
 *  the orientation of other elements. planish finds them if the axes are the periodic directions,
 *  most other elements have one sign, and the domain is at least three elements wide
 *  (docs/untangling.md); it finds none in a mesh in parts or with options.around. Fill wrapped
 *  [n_elements of the mesh] (may be NULL) with 0 or 1; *n (may be NULL) counts the ones. If plan is
 *  NULL, *n is 0 and wrapped does not change. */
PLANISH_API void planish_find_wrapped(const planish_plan *plan, uint8_t *wrapped, int64_t *n);

/* ---- Quality ------------------------------------------------------------------------------ */

#define PLANISH_HISTOGRAM_BINS 12
#define PLANISH_ANGLE_BINS     15

/** Smallest, mean and largest value of a measure over the valid elements; 0 without any. */
typedef struct planish_spread {
    double min, mean, max;
} planish_spread;

/** Quality of a mesh. Definitions and sources: docs/measures.md. Ratios and angles are over the
 *  valid elements (positive measure). Here and in planish_result a movable node is a node that is
 *  free or slides.
 *  In a mixed mesh fields of RR have AR (with sizes if options.size_weight is above 0), and an
 *  element is valid if all its corners are positive (planish_measure_cells decides whether it is
 *  valid inside, too). mean_ratio is 1 / AR,
 *  scaled_jacobian the least of the corners. Volumes are means of the corners: exact but for
 *  hexahedra and wedges that are not parallelepipeds or prisms. Angles, circumradius_to_edge and
 *  edge_to_inradius are 0, as their counts are. */
typedef struct planish_quality {
    int64_t n_elements;
    int64_t n_inverted; /* elements whose measure is not positive, decided exactly */
    double min_volume;  /* signed; areas in 2-D; infinite where no double holds it */
    double max_volume;
    double total_volume; /* sum of the signed volumes; NaN if some of both signs are infinite */
    double rms_radius_ratio;
    double rms_radius_ratio_movable; /* over elements with a movable node */
    double mean_radius_ratio;
    double max_radius_ratio;
    int64_t worst_element; /* where max_radius_ratio is, or -1 */
    double min_angle_deg;  /* dihedral angles in 3-D, angles in 2-D */
    double max_angle_deg;
    double max_radius_ratio_movable; /* over elements with a movable node; 0 without any */
    double min_angle_deg_movable;    /* over elements with a movable node; 0 without any */
    int64_t n_fixed_elements;        /* elements without a movable node */
    double fixed_rms_radius_ratio;   /* 0 where there is none */
    double fixed_max_radius_ratio;   /* max_radius_ratio cannot fall below this: worst of them */
    planish_spread radius_ratio;     /* R/(3r), R/(2r) in 2-D: 1 .. inf */
    planish_spread circumradius_to_edge; /* R / longest edge; 1 if regular, not the least */
    planish_spread edge_to_inradius;     /* longest edge / r, normalised to 1 .. inf */
    planish_spread edge_ratio;           /* longest edge / shortest: 1 .. inf */
    planish_spread mean_ratio;           /* 0 .. 1, 1 for the regular element */
    planish_spread scaled_jacobian;      /* 0 .. 1, 1 for the regular element */
    planish_spread smallest_angle_deg;   /* of each element; dihedral in 3-D */
    planish_spread largest_angle_deg;
    double histogram_edges[PLANISH_HISTOGRAM_BINS + 1]; /* of RR; the last is infinite */
    int64_t histogram_counts[PLANISH_HISTOGRAM_BINS];
    double angle_edges_deg[PLANISH_ANGLE_BINS + 1]; /* of each element's smallest (dihedral) angle:
                                                       0, 5, .. 75; bins begin with their edge, and
                                                       what is below it by rounding counts there */
    int64_t angle_counts[PLANISH_ANGLE_BINS];
    int64_t n_reversed; /* elements whose measure in the listed order of their nodes has, at these
                           coordinates, the other sign than most elements'
                           (planish_find_reversed); planish_plan_info.n_negative_order compares
                           orders of nodes instead */
    int64_t reserved[7];
} planish_quality;

/** Measure coordinates [n_nodes][dim] (or as the mesh's strides say) with the plan's elements.
 *  plan is const: no later result changes. It does not mean that two threads may use the plan.
 *  Errors: _ARGUMENT, _MESH, _MEMORY, with mesh->part also _PROCESS. */
PLANISH_API int planish_measure(const planish_plan *plan, const double *coordinates,
                                planish_quality *quality, planish_error *error);

/** Compute the radius ratio (AR in a mixed mesh) of each element, 1 or more, at coordinates
 *  [n_nodes][dim] (or as the mesh's strides say). radius_ratio [n_elements] is 0 for elements that
 *  are not positive, and NAN for elements that a plan with options.around does not know.
 *  Errors: _ARGUMENT, _MESH, _MEMORY, with mesh->part also _PROCESS; radius_ratio is then untouched. */
PLANISH_API int planish_measure_elements(const planish_plan *plan, const double *coordinates,
                                         double *radius_ratio, planish_error *error);

/** Find the reversed elements, which a solver may reject. The measure of an element at coordinates
 *  [n_nodes][dim] (or as the mesh's strides say), in the listed order of its nodes, has a sign. An
 *  element is reversed if its sign is not that of most elements. Signs are exact. An element of
 *  measure 0 has none. If both signs are equally frequent, the positive one counts as that of most
 *  elements. A mesh that is mirrored as a whole has no reversed elements. In a mixed mesh most
 *  elements are those of the same shape; an element with corners of both signs has none.
 *  The library never renumbers elements: smoothing can repair an inverted element whose nodes are
 *  listed in the wrong order, and the element is reversed from then on.
 *  reversed [n_elements] (may be NULL) is filled with 0 or 1. *n (may be NULL) counts the ones; for
 *  a mesh in parts those of the whole mesh, and most elements are those of the whole mesh, too. A
 *  plan with options.around counts its own elements only; the others are 0.
 *  Errors: _ARGUMENT, _MESH, _MEMORY, with mesh->part also _PROCESS; reversed and *n are then untouched. */
PLANISH_API int planish_find_reversed(const planish_plan *plan, const double *coordinates,
                                      uint8_t *reversed, int64_t *n, planish_error *error);

/** Measure mesh->coordinates as planish_measure does, with a temporary plan that is made with
 *  options (NULL: defaults). Errors: _ARGUMENT, _MESH, _MEMORY. */
PLANISH_API int planish_measure_mesh(const planish_mesh *mesh, const planish_options *options,
                                     planish_quality *quality, planish_error *error);

/** Measures of elements of one type, or of all types. Aspect ratios are those of the valid elements
 *  without inverted corners. Without any the mean and the largest are 0. */
typedef struct planish_cell_measures {
    int64_t n_elements;
    int64_t n_inverted;    /* elements that are not valid: det J <= 0 somewhere. Decided, not
                                  sampled (docs/measures.md) */
    int64_t n_uncertified; /* elements whose validity is not decided; they count as not valid */
    int64_t n_inverted_corners; /* corners whose edges, taken as straight, have a determinant <= 0;
                                   decided exactly */
    int64_t n_curved;           /* curved elements (planish_options.rounding) */
    double rms_aspect_ratio;    /* AR: root of the mean over the corners of the squared mean ratio,
                                  1 for the ideal element */
    double mean_aspect_ratio;
    double max_aspect_ratio;
    int64_t worst_element;      /* where that is, or -1 */
    double min_scaled_jacobian; /* over the corners of all elements: det J over the product of the
                                   edges' lengths, over that of the ideal corner */
    double min_jacobian_ratio;  /* over curved elements: least Bezier coefficient of det J over
                                   the absolute value of their mean; 1 without any */
    double max_edge_ratio;      /* longest edge / shortest, between corners */
    double reserved[4];
} planish_cell_measures;

enum { PLANISH_N_CELL_TYPES = 16 };

/** Quality of a mesh of any types of elements. */
typedef struct planish_cell_quality {
    planish_cell_measures all;
    int n_types;
    planish_cell_type type[PLANISH_N_CELL_TYPES];        /* [n_types] ascending, */
    planish_cell_measures by_type[PLANISH_N_CELL_TYPES]; /* and their measures */
    int64_t reserved[8];
} planish_cell_quality;

/** State of an element of any type. */
typedef enum planish_cell_state {
    PLANISH_CELL_STATE_NONE = 0,       /* of another dimension than the mesh: not measured */
    PLANISH_CELL_STATE_VALID = 1,      /* det J > 0 everywhere */
    PLANISH_CELL_STATE_INVERTED = 2,   /* det J <= 0 somewhere */
    PLANISH_CELL_STATE_UNCERTIFIED = 3 /* not decided */
} planish_cell_state;

/** Measures of single elements, as arrays of the caller's to be filled; each may be NULL. 0 stands
 *  for a measure that an element does not have. */
typedef struct planish_cell_values {
    uint8_t *state;          /* [n_elements] of planish_cell_state */
    uint8_t *is_curved;      /* [n_elements] 1: it is curved (planish_options.rounding) */
    double *aspect_ratio;    /* [n_elements] AR of valid elements without inverted corners */
    double *scaled_jacobian; /* [n_elements] least of the corners */
    double
        *jacobian_ratio; /* [n_elements] least Bezier coefficient of det J over the absolute value
                               of their mean; 1 for elements that are not curved */
    double *edge_ratio;  /* [n_elements] longest edge / shortest, between corners */
    void *reserved[4];   /* NULL */
} planish_cell_values;

/** Measure the elements of mesh, of any types (mesh->cells) or simplices alone; those of dimension
 *  mesh->dim count. rounding and threads: as in planish_options. values (may be NULL) are filled.
 *  With mesh->reference AR compares elements with their shapes there, of order 2 by their corners.
 *  Every corner must be positive there, and all other measures are as without reference. With
 *  mesh->metric AR measures lengths by the metric. On failure quality is as before, and values are unspecified. Errors:
 *  _ARGUMENT, _MESH, _MEMORY, _PARTS (mesh->part). */
PLANISH_API int planish_measure_cells(const planish_mesh *mesh, double rounding, int threads,
                                      planish_cell_quality *quality,
                                      const planish_cell_values *values, planish_error *error);

/** Measure mesh->coordinates of a surface in space: areas, angles and ratios of the elements, each in its
 *  own plane. shape was made of the same elements. Movable nodes are those of planish_smooth_surface.
 *  An element is inverted if it has no area, or has turned over against the shape. quality: as of
 *  planish_measure for such elements in a plane. ratio [n_elements] (may be NULL): RR, with
 *  quadrilaterals AR; 0 for inverted elements. cells and values (may be NULL): as of
 *  planish_measure_cells, with elements of order 2 by their corners. threads: as in planish_options.
 *  Errors: _ARGUMENT, _MESH, _MEMORY, _PARTS; all outputs but values are then untouched. */
PLANISH_API int planish_measure_surface(const planish_shape *shape, const planish_mesh *mesh,
                                        int threads, planish_quality *quality, double *ratio,
                                        planish_cell_quality *cells,
                                        const planish_cell_values *values, planish_error *error);

/** Return a checksum of 64 bits of mesh->coordinates in the order of the nodes, whatever the strides.
 *  Equal bits have equal checksums; different bits have different ones, except with a chance of
 *  about 1 in 2^64. 0 for no coordinates. */
PLANISH_API uint64_t planish_checksum(const planish_mesh *mesh);

/* ---- Heights of layers ---------------------------------------------------------------------- */

enum { PLANISH_LAYER_ROWS = 32 };

/** Heights of a row of a layer beside those that are wanted. */
typedef struct planish_layer_row {
    int64_t n;               /* edges across the layer that count; 0: all numbers are 0 */
    double min, median, max; /* height / wanted height; below 0: the layer is inverted there */
} planish_layer_row;

/** Heights of layers. The wanted height of an edge across a layer is that in planish_mesh.reference. Where
 *  a wall was moved there, it is the height by which the rows inside go on. Where a node inside a layer was
 *  displaced through others, the rows there share their heights as the other rows tell. Heights are at right
 *  angles to the layer. */
typedef struct planish_layer_heights {
    planish_layer_row all;
    planish_layer_row reference; /* of all in the reference: 1 but where nodes were displaced */
    int64_t n_told;              /* edges whose wanted heights other rows have told */
    int n_rows; /* rows in use: they are counted from thin ends, and from surfaces inside, */
    planish_layer_row row[PLANISH_LAYER_ROWS]; /* and the last one has all beyond it */
    int64_t n_at_moved_walls; /* of n_told: first edges at walls that were moved; 0: none was */
    double reserved[1];
} planish_layer_heights;

/** Compare the heights of the layers that mesh->is_layer marks with those in mesh->reference (NULL: in
 *  mesh->coordinates). off [n_nodes] (may be NULL) is filled with the largest |height / wanted - 1| of
 *  the edges at each node. Edges whose heights are told do not count, nor do others of a side whose wall was
 *  moved far. It is 0 without a layer. threads: as in planish_options. On failure heights is all 0, and
 *  off is untouched. Errors: _ARGUMENT, _MESH, _MEMORY, _PARTS (mesh->part). */
PLANISH_API int planish_measure_layers(const planish_mesh *mesh, int threads,
                                       planish_layer_heights *heights, double *off,
                                       planish_error *error);

/* ---- Sizes ---------------------------------------------------------------------------------- */

/** Sizes of elements compared with planish_mesh.size or metric. The size of an element is the edge
 *  length of the ideal element of the same measure; for cells it is the mean of this length over the
 *  corners. With a metric, lengths are measured by the metric, and the wanted size is 1. */
typedef struct planish_size_quality {
    int64_t n_elements;        /* that have a size: all but flat ones */
    double factor;             /* factor on the given sizes with which the domain would hold the
                                  number of elements that it has */
    double rms_log;            /* RMS of log(size / (factor * wanted)) */
    double min, max;           /* size / (factor * wanted); 0 without elements */
    int64_t smallest, largest; /* elements that have these, or -1 */
    double reserved[2];
} planish_size_quality;

/** Compare the sizes of the elements of mesh with mesh->size or mesh->metric. These are given at
 *  the nodes in mesh->reference (NULL: in mesh->coordinates). ratio [n_elements] (may be NULL) is
 *  filled with size / (factor * wanted), 0 for elements that do not count. threads: as in
 *  planish_options. Errors: _ARGUMENT, _MESH, _MEMORY, _PARTS. */
PLANISH_API int planish_measure_sizes(const planish_mesh *mesh, int threads,
                                      planish_size_quality *quality, double *ratio,
                                      planish_error *error);

/** Fill size [n_nodes] with the sizes of mesh: at each node the mean size of its elements that are not
 *  flat, or of all such elements if the node has none. With these as planish_mesh.size, smoothing keeps
 *  the sizes of a mesh where they are. Errors: as of planish_measure_sizes. */
PLANISH_API int planish_find_sizes(const planish_mesh *mesh, int threads, double *size,
                                   planish_error *error);

/* ---- Smoothing ---------------------------------------------------------------------------- */

typedef enum planish_stop {
    PLANISH_STOP_CONVERGED = 0,
    PLANISH_STOP_MAX_SWEEPS = 1,
    PLANISH_STOP_TIME_LIMIT = 2,
    PLANISH_STOP_INTERRUPTED = 3, /* the progress callback said so */
    PLANISH_STOP_INFEASIBLE = 4   /* converged, with elements that cannot reach their minimum
                                     volume */
} planish_stop;

typedef struct planish_result {
    planish_stop stop;
    int sweeps;              /* sweeps begun */
    int untangling_sweeps;   /* those of them that only untangled */
    int worst_sweeps;        /* those of them for options.worst */
    int64_t visits;          /* local problems looked at */
    int64_t n_moved_nodes;   /* nodes that have moved */
    double max_displacement; /* largest displacement of a node, in units of the coordinates */
    int64_t n_put_back;      /* times that a node went back to its start, because its elements had
                                a smaller angle than the mesh before; F may have risen there, but
                                not above its value at the start */
    int64_t n_inverted;      /* elements not positive in doubles, where planish_measure is exact; of
                                order 2, hexahedra and wedges: not valid */
    double rms;              /* RMS of AR over the valid elements at the end */
    double rms_movable;      /* rms over the valid elements with a movable node */
    double min_volume;       /* delta of elements for which the mesh gives none; 0: none */
    int64_t n_below_min_volume; /* elements below 0.997 of their minimum volume at the end */
    int64_t n_held_outside;     /* movable nodes that started outside of their bounds: held */
    double objective_before;    /* F over the valid elements at the start */
    double objective;           /* F over the valid elements at the end */
    double objective_of_worst;  /* F when sweeps for options.worst began; 0: there were none */
    double
        worst_before;   /* measure options.worst of the worst element with a movable node when these
                            sweeps began: RR, degrees; of the worst corner: mu, SJ */
    double worst_after; /* the same measure at the end */
    int64_t evaluations; /* of the function of a star, with or without derivatives */
    /* With a minimum volume, bounds or an objective other than the default: first-order optimality
       at the end, over the nodes whose stars are feasible; else 0. f is the function of the node's
       star, h the star's size, P the projection of -grad f on the directions that no active
       constraint forbids: |P| h / f is about the relative fall of f that a move by h promises. */
    double kkt_residual;   /* largest |P| h / f of a node; not a number if no star is feasible */
    double kkt_rms;        /* root mean square of these */
    double max_multiplier; /* largest Lagrange multiplier of a g = 1 - V/delta, in units of F */
    int64_t n_active;      /* constraints with a multiplier, counted at each node */
    double seconds;        /* wall time of the call */
    int64_t
        n_not_enclosed; /* elements that untangling gave up at once, in components whose boundary
                               encloses no positive volume */
    int64_t n_curved;   /* curved elements of order 2 at the start */
    int64_t n_inverted_inside; /* elements of n_inverted with positive corners: they are inverted
                                  elsewhere, and could not be repaired */
    int64_t n_refused;       /* moves that would have inverted an element with positive corners, or
                                  made it worse than the worst was */
    int64_t n_released_mids; /* mids that have moved on their own (options.curve_quality) */
    int64_t n_infeasible_curved; /* curved elements of n_inverted_inside that are proved invalid
                                    wherever their free nodes go */
    int64_t n_off_shape; /* moves that were shortened or refused because the surface would have been
                            too far off the shape, or bent */
    int64_t reserved[8];
} planish_result;

/** Smooth coordinates [n_nodes][dim] (or as the mesh's strides say) in place, after untangling them
 *  where need be.
 *
 *  Promised:
 *  - Only movable nodes move, and within their bounds; mids follow their ends.
 *  - The number of inverted elements never rises (valid: det J > 0 everywhere, decided). A mesh without
 *    inverted elements stays valid. Without untangling no valid element becomes inverted. Untangling
 *    may invert others, but repairs more.
 *  - In a mesh without inverted elements no element gets a worse RR (AR) than the worst element with
 *    a movable node had. With options.size_weight above 0 this AR counts sizes; that of shapes alone
 *    may get worse. With RR alone as objective, none gets a smaller angle (dihedral in 3-D); in a
 *    mixed mesh no corner gets a smaller scaled Jacobian, unless targets may have sharp ones
 *    (docs/targets.md). Minimum volumes may break these promises.
 *  - F never rises once no element is inverted or below its minimum volume. Only options.worst may
 *    raise F, by at most worst_rise of the value that F had converged to.
 *  - The bits are the same for any number of threads, isa and compiler (gcc and clang are tested).
 *
 *  Not promised: some meshes that could be untangled may stay tangled. Stars with an element that
 *  is left not positive stay as they are. Stars with an element below its minimum volume are first
 *  brought above it where that can be done. Untangling ends by a bound on its work, which takes
 *  minutes on large meshes that cannot be repaired: set time_limit if that matters.
 *
 *  options (NULL: defaults, with the plan's rounding): threads, bind, isa, allocator, parallel and log
 *  are those of the plan.
 *  result may be NULL. Errors: _ARGUMENT, _MESH (a coordinate is not finite), _MEMORY; coordinates
 *  are then untouched. With a mesh in parts also _PROCESS, as of all calls that look at
 *  coordinates. */
PLANISH_API int planish_smooth(planish_plan *plan, double *coordinates,
                               const planish_options *options, planish_result *result,
                               planish_error *error);

/** Fill coordinates [n_nodes][dim] (or as the mesh's strides say) with the positions of the nodes at the
 *  end of a sweep. Only a planish_progress_fn may call this, with the progress that it was given, on the
 *  last call of a sweep (sweep_done). Entries of nodes that do not move may stay as they are: begin with a
 *  copy of the coordinates that are smoothed. coordinates must be another array than these.
 *  The positions are those that the figures of progress describe:
 *  - Sweeps that smooth: the mesh after the sweep. It is valid if the mesh was valid.
 *  - Sweeps that untangle: the mesh after the sweep, which planish may undo later.
 *  - Sweeps of a trial, as for the worst elements: the mesh that was accepted last, until planish accepts
 *    the trial. Sweeps of one trial have the same positions.
 *  - planish_smooth_surface: the mesh after the sweep, in trials, too. Where a run begins anew its sweeps
 *    count from 1 again, and positions before that do not lead to the result.
 *  - planish_fit_move: the mesh after the sweep. Sweeps count from 1 in each round.
 *  Positions are rounded as the result is (planish_options.precision). The result may differ from the
 *  positions of the last sweep: planish may accept a trial, or put nodes back, after that sweep.
 *  With a mesh in parts the entries of ghosts are unspecified. The call allocates nothing, and changes no
 *  result. Errors: _ARGUMENT; coordinates are then untouched. */
PLANISH_API int planish_progress_get_coordinates(const planish_progress *progress,
                                                 double *coordinates, planish_error *error);

/** Smooth coordinates [n_nodes][3] (or as the mesh's strides say) of a mesh that is a surface in space:
 *  mesh->cells has triangles and quadrilaterals, and no solids. Nodes move along options->shape, which
 *  was made of the same cells. mesh->constraint says how; where it is FREE or NULL, the shape says.
 *  ON_SURFACE nodes stay.
 *
 *  The objective F is the RMS of AR (RR of a mesh of triangles alone) over the elements. Promised:
 *  - Each facet stays within options->surface_tolerance of the shape, proved (planish_shape_measure
 *    measures the whole surface, both ways). Corners stay, and nodes of curves move along their curves.
 *  - No facet turns by more than 60 degrees from its first direction. No smooth edge bends above 40
 *    degrees, nor further if it does so at the start.
 *  - No element gets a worse AR (RR), or a smaller angle (scaled Jacobian), than the worst element with a
 *    movable node had.
 *  - F never rises. Only options->worst may raise it, by at most worst_rise.
 *  - No facet comes to cross another one. If some would, the run begins anew and holds their nodes. If
 *    some still would in the fourth run, or in a run that the caller stops, nothing moves.
 *  - The bits are the same for any number of threads.
 *  Nodes of elements of order 2 stay. Elements that have turned over against the shape stay as they are,
 *  and so do their nodes.
 *
 *  options (not NULL): as for planish_plan_create and planish_smooth. Minimum volumes, Laplacian methods,
 *  PLANISH_OBJECTIVE_EDGE_RATIO and project are errors; isa, bind and search have no effect. worst: for triangles
 *  RADIUS_RATIO or ANGLE, else ASPECT_RATIO or SCALED_JACOBIAN. result may be NULL. Errors:
 *  _ARGUMENT, _MESH, _MEMORY, _PARTS; coordinates are then untouched. */
PLANISH_API int planish_smooth_surface(const planish_mesh *mesh, double *coordinates,
                                       const planish_options *options, planish_result *result,
                                       planish_error *error);

/** Why planish_smooth, or planish_smooth_surface, holds a movable node from its start to its end. */
typedef enum planish_held_by {
    PLANISH_HELD_BY_NONE = 0, /* not held so: it may move, if only a little, or it is not movable */
    PLANISH_HELD_BY_BOUNDS = 1,    /* the node starts outside of its bounds; or, without
                                   options.untangle, in a periodic group at an element that is not
                                   positive */
    PLANISH_HELD_BY_TOLERANCE = 2, /* a facet at the node starts farther off options.shape than
                                      options.surface_tolerance */
    PLANISH_HELD_BY_SHEET = 3, /* another sheet of the surface is nearer than two such tolerances */
    PLANISH_HELD_BY_SURFACE = 4 /* options.shape or project cannot say where the node may go: it is
                                   NULL, or the node is a corner, of a periodic pair, or beside a
                                   node that slides in another way */
} planish_held_by;

/** Find the movable nodes that planish_smooth with these arguments would hold from its start to its end.
 *  Fill held [n_nodes of the mesh] with a planish_held_by of each: the first reason that applies. All
 *  other movable nodes may move, although limits can stop a node at its first step. planish_smooth
 *  holds sliding nodes also while it untangles; they do not count here. coordinates [n_nodes][dim] (or as
 *  the mesh's strides say) do not change. options (NULL: defaults): as for planish_smooth. The call costs
 *  about as much as the beginning of planish_smooth. With a mesh in parts entries of ghosts are
 *  unspecified. Errors: _ARGUMENT, _MESH, _MEMORY, and with a mesh in parts _PROCESS; held is then
 *  untouched. */
PLANISH_API int planish_find_held(planish_plan *plan, const double *coordinates,
                                  const planish_options *options, uint8_t *held,
                                  planish_error *error);

/** Do so for planish_smooth_surface at mesh->coordinates; options (not NULL): as there. Nodes that
 *  planish_smooth_surface holds later, because facets have come to cross, are _NONE, and so are nodes
 *  that options.only_worse_than leaves out. Errors: _ARGUMENT, _MESH, _MEMORY, _PARTS; held is then
 *  untouched. */
PLANISH_API int planish_find_held_on_surface(const planish_mesh *mesh,
                                             const planish_options *options, uint8_t *held,
                                             planish_error *error);

/** State of an element as planish_check_volumes reports it. */
typedef enum planish_volume_state {
    PLANISH_VOLUME_MET = 0,       /* at least 0.997 of its minimum volume, or it has none */
    PLANISH_VOLUME_BELOW = 1,     /* below that */
    PLANISH_VOLUME_INFEASIBLE = 2 /* below that, and proved unable to reach it wherever the movable
                                     nodes go: by itself, or together with the elements around its
                                     only movable node, which is free */
} planish_volume_state;

/** Compare the elements of coordinates [n_nodes][dim] with their minimum volumes: those of options
 *  (NULL: defaults) and of the plan's mesh. In a mixed mesh each corner of an element has the
 *  volume of the parallelepiped, prism or pyramid with its edges; here the least one counts. state
 *  [n_elements] (may be NULL) is filled with planish_volume_state; elements that a plan with
 *  options.around does not know are MET. *n_below counts the elements that are not MET.
 *
 *  The search for proofs that elements are infeasible takes long around nodes with thousands of
 *  elements. Limits of options end it: time_limit in seconds of this call, and progress, which is
 *  called 20 times a second with a planish_progress that has nothing but elapsed and n_colours; a
 *  result other than 0 ends the search. The search is never shorter than 0.05 seconds.
 *  *n_undecided (may be NULL) is the number of elements that the search did not decide, 0 without
 *  limits: their state stays _BELOW; the states of all others are certain. If one process ends the
 *  search in a mesh in parts, all do. In one process there is no search if state and n_undecided are
 *  NULL.
 *  Errors: _ARGUMENT, _MESH, _MEMORY; all outputs are then untouched. */
PLANISH_API int planish_check_volumes(const planish_plan *plan, const double *coordinates,
                                      const planish_options *options, uint8_t *state,
                                      int64_t *n_below, int64_t *n_undecided, planish_error *error);

/** Find the infeasible elements of coordinates [n_nodes][dim]: elements that are not positive and are
 *  proved unable to become positive all together, wherever the movable nodes go; in a mixed mesh
 *  elements with such a corner. These are
 *  - elements without a movable node, or with two fixed nodes at one place
 *  - elements that contradict each other, by more than 1e-9 of their measures, around one free node
 *    whose link there is fixed (docs/algorithm.md)
 *  - with options.curve_quality the curved triangles and tetrahedra of planish_result.n_infeasible_curved, by
 *    det J at points.
 *
 *  infeasible [n_elements] (may be NULL) is filled with 0 or 1; *n counts the ones. The value is 0 for
 *  elements without a proof, and for those that a plan with options.around does not know. options
 *  (NULL: defaults) limit the search as in planish_check_volumes, and *n_undecided (may be NULL)
 *  counts the inverted elements that it left. Errors: _ARGUMENT, _MESH, _MEMORY; all outputs are then
 *  untouched. */
PLANISH_API int planish_find_infeasible(const planish_plan *plan, const double *coordinates,
                                        const planish_options *options, uint8_t *infeasible,
                                        int64_t *n, int64_t *n_undecided, planish_error *error);

#ifdef __cplusplus
}
#endif
#endif
