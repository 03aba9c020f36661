/* The bits of results: every mesh of a list smoothed with every option of another, and compared
 * with tests/api/checksums.txt, on whatever compiler and machine this runs.
 *
 * Who changes results on purpose writes a new list, PLANISH_CHECKSUMS=FILE test_api_checksums,
 * and commits it with the reason. Input is rounded to multiples of 2^-20, so that it does not
 * depend on the system's sine.
 */
#include "support/cell_meshes.h"
#include "support/effort.h"
#include "support/run.h"
#include "support/surfaces.h"
#include "support/tangles.h"
#include "geometry/cell.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- meshes ------------------------------------------------------------------------------- */

/** What is smoothed; all arrays are owned. */
typedef struct subject {
    test_mesh base;
    planish_mesh mesh;
    uint8_t *constraint; /* [n] as planish_find_slides says */
    double *direction;   /* [n][dim] */
    double *min_volume;  /* [n_elements] */
    int32_t *pair;       /* [n_pairs][2] the opposite nodes of a box along x */
    int64_t n_pairs;
} subject;

enum { BOX = -1 };

/** A shape of tangles.h and how it is tangled; shape BOX: shaken by at most 0.14 of its cells. */
static const struct {
    const char *name;
    int dim, shape, tangling; /* TEST_TANGLINGS: valid */
    int size;                 /* cells of a box, else fineness */
} shapes[] = {
    {"box", 3, BOX, TEST_TANGLINGS, 5},
    {"square", 2, BOX, TEST_TANGLINGS, 10},
    {"large-box", 3, BOX, TEST_TANGLINGS, 8},
    {"graded", 3, TEST_GRADED, TEST_TANGLINGS, 1},
    {"graded-2", 2, TEST_GRADED, TEST_TANGLINGS, 1},
    {"wavy", 3, TEST_WAVY, TEST_TANGLINGS, 1},
    {"few", 3, TEST_BOX, TEST_MOVED_FEW, 1},
    {"few-2", 2, TEST_BAR, TEST_MOVED_FEW, 2},
    {"bent", 3, TEST_BENT, TEST_LEFT_BEHIND, 1},
    {"ring-2", 2, TEST_RING, TEST_LEFT_BEHIND, 1},
    {"flat", 3, TEST_RING, TEST_FLAT, 1},
    {"together", 3, TEST_BAR, TEST_ALL_IN_ONE, 1},
    {"swapped-2", 2, TEST_BENT, TEST_SWAPPED, 1},
};

static void *checked(void *memory) {
    assert_non_null(memory);
    return memory;
}

/** Nodes at x = 0 with those at x = size: both sides have the same lattice. */
static void pair_sides(subject *s, int size) {
    const int dim = s->mesh.dim, n = size + 1;
    for (int64_t i = 0; i < s->mesh.n_nodes; i += n)
        if (s->base.coordinates[i * dim] == 0) {
            s->pair[2 * s->n_pairs] = (int32_t)i;
            s->pair[2 * s->n_pairs++ + 1] = (int32_t)(i + size);
        }
}

static void subject_create(subject *s, int which) {
    const int dim = shapes[which].dim, size = shapes[which].size;
    *s = (subject){.n_pairs = 0};
    if (shapes[which].shape == BOX) {
        test_mesh_box(&s->base, dim, size);
        test_mesh_perturb(&s->base, 0.14, 3);
    } else {
        test_tangle t;
        test_tangle_create(&t, dim, (test_shape)shapes[which].shape, size, 7);
        if (shapes[which].tangling != TEST_TANGLINGS)
            test_tangle_apply(&t, (test_tangling)shapes[which].tangling, 7);
        test_mesh_create(&s->base, dim, t.mesh.mesh.n_nodes, t.mesh.coordinates,
                         t.mesh.mesh.n_elements, t.mesh.elements);
        test_tangle_destroy(&t);
    }
    s->mesh = s->base.mesh;
    const size_t n = (size_t)s->mesh.n_nodes, m = (size_t)s->mesh.n_elements;
    for (size_t i = 0; i < n * (size_t)dim; i++)
        s->base.coordinates[i] = round(s->base.coordinates[i] * 0x1p20) * 0x1p-20;
    s->constraint = checked(malloc(n));
    s->direction = checked(calloc(n * (size_t)dim, sizeof *s->direction));
    s->min_volume = checked(malloc(m * sizeof *s->min_volume));
    s->pair = checked(malloc(2 * n * sizeof *s->pair));
    for (size_t i = 0; i < m; i++)
        s->min_volume[i] = (i % 3 == 0) * (0.06 + 0.01 * (double)(i % 5));
    if (shapes[which].shape == BOX)
        pair_sides(s, size);
    assert_int_equal(
        planish_find_slides(&s->mesh, NULL, 1, s->constraint, s->direction, NULL, NULL), 0);
}

static void subject_destroy(subject *s) {
    free(s->constraint);
    free(s->direction);
    free(s->min_volume);
    free(s->pair);
    test_mesh_destroy(&s->base);
}

/** Make a subject of a box of cells of a kind, with inner nodes pushed about until some are inverted;
 *  of order 2 every eleventh node between corners is bent. */
static cell_box *subject_of_cells(subject *s, int kind, int order) {
    cell_box *low = cell_box_create((cell_box_kind)kind, kind < BOX_HEXAHEDRA ? 9 : 3);
    cell_box *b = low;
    cell_box_shake(low, kind % 3 == 0 ? 0.35 : 0.2, 5);
    for (int64_t i = 0; i < low->mesh.n_nodes * low->mesh.dim; i++)
        low->x[i] = round(low->x[i] * 0x1p20) * 0x1p-20;
    if (order == 2) {
        b = cell_box_raise(low, kind % 2);
        for (int64_t i = low->mesh.n_nodes; i < b->mesh.n_nodes; i++)
            for (int d = 0; i % 11 == 0 && d < b->mesh.dim; d++)
                b->x[i * b->mesh.dim + d] += (double)((i + d) % 3 - 1) / 8;
        cell_box_destroy(low);
    }
    const size_t n = (size_t)b->mesh.n_nodes, m = (size_t)b->cells.n;
    *s = (subject){.base.mesh = b->mesh, .mesh = b->mesh};
    s->constraint = checked(malloc(n));
    s->direction = checked(calloc(n * (size_t)b->mesh.dim, sizeof *s->direction));
    s->min_volume = checked(malloc(m * sizeof *s->min_volume));
    for (size_t i = 0; i < m; i++)
        s->min_volume[i] = (i % 3 == 0) * (0.06 + 0.01 * (double)(i % 5));
    assert_int_equal(
        planish_find_slides(&s->mesh, NULL, 1, s->constraint, s->direction, NULL, NULL), 0);
    return b;
}

/* ---- options ------------------------------------------------------------------------------ */

static double to_hundredths(double x, void *user) {
    (void)user;
    return floor(x * 128 + 0.5) / 128;
}

/** Onto the plane x + y = its start's, as nodes of a surface would be. */
static planish_constraint project(int64_t node, double *point, double *direction, void *user) {
    const subject *s = user;
    const double *start = s->mesh.coordinates + node * s->mesh.dim;
    const double off = (point[0] + point[1] - start[0] - start[1]) / 2;
    point[0] -= off;
    point[1] -= off;
    memset(direction, 0, (size_t)s->mesh.dim * sizeof *direction);
    direction[0] = direction[1] = 1;
    return PLANISH_CONSTRAINT_ON_PLANE;
}

static void slide(subject *s) {
    s->mesh.constraint = s->constraint;
    s->mesh.direction = s->direction;
}

static const int64_t around[] = {70, 40};

/** Bits of a way to smooth; all that are set are done. */
enum {
    SLIDE = 1,
    FLETCHER_REEVES = 1 << 1,
    MEAN_RATIO = 1 << 2,
    EDGE_RATIO = 1 << 3,
    WORST = 1 << 4,
    WORST_ANGLE = 1 << 5,
    MIN_VOLUME = 1 << 6,
    MIN_VOLUMES = 1 << 7,
    WEIGHT = 1 << 8,
    BOUNDS = 1 << 9,
    DISPLACEMENT = 1 << 10,
    FLOATS = 1 << 11,
    ROUNDED = 1 << 12,
    SELECT = 1 << 13,
    SELECT_LATER = 1 << 14,
    AROUND = 1 << 15,
    SURFACE = 1 << 16,
    PERIODIC = 1 << 17,
    FEW_SWEEPS = 1 << 18,
    TANGLED = 1 << 19,
    LAPLACIAN = 1 << 20
};

static const struct {
    const char *name;
    unsigned how;
} ways[] = {
    {"plain", 0},
    {"slide", SLIDE},
    {"fletcher-reeves", FLETCHER_REEVES},
    {"mean-ratio", MEAN_RATIO},
    {"edge-ratio", EDGE_RATIO},
    {"slide-mean-ratio", SLIDE | MEAN_RATIO},
    {"slide-edge-ratio", SLIDE | EDGE_RATIO | FLETCHER_REEVES},
    {"worst", WORST},
    {"worst-angle", WORST_ANGLE},
    {"slide-worst", SLIDE | WORST},
    {"slide-worst-angle", SLIDE | WORST_ANGLE},
    {"min-volume", MIN_VOLUME},
    {"min-volumes", MIN_VOLUMES},
    {"weight", MIN_VOLUME | WEIGHT},
    {"weight-mean-ratio", MIN_VOLUME | WEIGHT | MEAN_RATIO | FLETCHER_REEVES},
    {"slide-min-volume", SLIDE | MIN_VOLUME},
    {"bounds", BOUNDS},
    {"bounds-min-volume", BOUNDS | MIN_VOLUME | DISPLACEMENT},
    {"displacement", DISPLACEMENT},
    {"slide-displacement", SLIDE | DISPLACEMENT},
    {"float", FLOATS},
    {"slide-float-worst", SLIDE | FLOATS | WORST},
    {"rounded", ROUNDED},
    {"select", SELECT},
    {"select-later", SELECT_LATER},
    {"select-slide", SELECT | SLIDE},
    {"around", AROUND},
    {"around-edge-ratio", AROUND | EDGE_RATIO | FEW_SWEEPS},
    {"surface", SLIDE | SURFACE},
    {"periodic", SLIDE | PERIODIC},
    {"periodic-worst-angle", SLIDE | PERIODIC | WORST_ANGLE},
    {"few-sweeps", FEW_SWEEPS},
    {"tangled", TANGLED},
    {"laplacian", LAPLACIAN},
    {"area-laplacian", LAPLACIAN | WORST},
    {"length-laplacian", LAPLACIAN | WORST_ANGLE | SLIDE},
};

static void set_objective(planish_options *options, unsigned how) {
    options->search =
        how & FLETCHER_REEVES ? PLANISH_SEARCH_FLETCHER_REEVES : PLANISH_SEARCH_NEWTON;
    options->objective = how & MEAN_RATIO   ? PLANISH_OBJECTIVE_MEAN_RATIO
                         : how & EDGE_RATIO ? PLANISH_OBJECTIVE_EDGE_RATIO
                                            : PLANISH_OBJECTIVE_RADIUS_RATIO;
    options->worst = how & WORST         ? PLANISH_WORST_RADIUS_RATIO
                     : how & WORST_ANGLE ? PLANISH_WORST_ANGLE
                                         : PLANISH_WORST_NONE;
    if (how & LAPLACIAN) {
        options->method = how & WORST         ? PLANISH_METHOD_AREA_LAPLACIAN
                          : how & WORST_ANGLE ? PLANISH_METHOD_LENGTH_LAPLACIAN
                                              : PLANISH_METHOD_LAPLACIAN;
        options->worst = PLANISH_WORST_NONE;
    }
}

static void set_limits(planish_options *options, unsigned how) {
    if (how & MIN_VOLUME)
        options->min_volume = 0.08;
    if (how & WEIGHT)
        options->area_weight = 0.25;
    if (how & BOUNDS) {
        options->box_lower[0] = 0.9;
        options->box_upper[1] = 2.9;
    }
    if (how & DISPLACEMENT) {
        options->max_displacement = 0.05;
        options->displacement_unit = PLANISH_UNIT_EDGE;
    }
    if (how & FEW_SWEEPS)
        options->max_sweeps = 2;
    options->untangle = !(how & TANGLED);
}

/** Whether the mesh can be smoothed this way at all. */
static int set_way(subject *s, unsigned how, planish_options *options) {
    planish_options_init(options);
    options->max_sweeps = 30;
    set_objective(options, how);
    set_limits(options, how);
    s->mesh = s->base.mesh;
    if (how & SLIDE)
        slide(s);
    if (how & MIN_VOLUMES)
        s->mesh.min_volume = s->min_volume;
    if (how & FLOATS)
        options->precision = PLANISH_PRECISION_FLOAT;
    if (how & ROUNDED) {
        options->precision = PLANISH_PRECISION_ROUNDED;
        options->round = to_hundredths;
    }
    if (how & (SELECT | SELECT_LATER))
        options->only_worse_than = 1.5;
    options->rings = how & (SELECT | AROUND) ? 1 : 0;
    if (how & AROUND) {
        options->around = around;
        options->n_around = 2;
    }
    if (how & SURFACE) {
        options->project = project;
        options->project_user = s;
    }
    if (how & PERIODIC) {
        s->mesh.periodic = s->pair;
        s->mesh.n_periodic = s->n_pairs;
    }
    return !(how & PERIODIC) || s->n_pairs > 0;
}

/** Turn the nodes that slide on planes into those of a surface. */
static void to_surface(subject *s, uint8_t *constraint) {
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        constraint[i] = s->constraint[i] == PLANISH_CONSTRAINT_FREE && i % 4 == 0
                            ? PLANISH_CONSTRAINT_ON_SURFACE
                            : s->constraint[i];
    s->mesh.constraint = constraint;
}

/* ---- results ------------------------------------------------------------------------------ */

/** FNV-1a over the bits of what a result says, but for the time. */
static uint64_t hash_result(const planish_result *r) {
    const double values[] = {r->max_displacement, r->rms,         r->rms_movable,
                             r->min_volume,       r->objective,   r->objective_before,
                             r->worst_before,     r->worst_after, r->objective_of_worst,
                             r->kkt_residual,     r->kkt_rms,     r->max_multiplier};
    const int64_t counts[] = {(int64_t)r->stop,  r->sweeps,      r->untangling_sweeps,
                              r->worst_sweeps,   r->visits,      r->n_moved_nodes,
                              r->n_put_back,     r->n_inverted,  r->n_below_min_volume,
                              r->n_held_outside, r->evaluations, r->n_active};
    uint64_t hash = 0xcbf29ce484222325u, word;
    for (size_t i = 0; i < sizeof values / sizeof *values; i++) {
        const double value = isnan(values[i]) ? -1 : values[i]; /* NaNs have many forms */
        memcpy(&word, &value, sizeof word);
        hash = (hash ^ word) * 0x100000001b3u;
    }
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        hash = (hash ^ (uint64_t)counts[i]) * 0x100000001b3u;
    return hash;
}

enum { LINE = 128, ENOUGH = 5 /* differences to show */ };

/** One line of the list: mesh, way, checksum of the coordinates, hash of the result. */
static void smooth_line(subject *s, const char *shape, int way, const planish_options *options,
                        char *line) {
    uint8_t *constraint = checked(malloc((size_t)s->mesh.n_nodes));
    if (ways[way].how & SURFACE)
        to_surface(s, constraint);
    planish_options later = *options;
    if (ways[way].how & SELECT_LATER)
        later.only_worse_than = 0;
    planish_plan *plan;
    planish_error error = {.text = ""};
    planish_result result;
    const size_t bytes = (size_t)(s->mesh.n_nodes * s->mesh.dim) * sizeof(double);
    double *x = checked(malloc(bytes));
    memcpy(x, s->mesh.coordinates, bytes);
    if (planish_plan_create(&s->mesh, &later, &plan, &error) ||
        planish_smooth(plan, x, options, &result, &error))
        fail_msg("%s %s: %s", shape, ways[way].name, error.text);
    planish_mesh smoothed = s->mesh;
    smoothed.coordinates = x;
    snprintf(line, LINE, "%s %s %016llx %016llx", shape, ways[way].name,
             (unsigned long long)planish_checksum(&smoothed),
             (unsigned long long)hash_result(&result));
    planish_plan_destroy(plan);
    free(constraint);
    free(x);
}

static FILE *open_list(const char *write) {
    char path[4096];
    if (write)
        return fopen(write, "w");
    snprintf(path, sizeof path, "%s/tests/api/checksums.txt", getenv("PLANISH_SOURCE"));
    return fopen(path, "r");
}

/** How many lines differ; with write, they are written and none does. */
static int compare_line(FILE *list, const char *line, const char *write) {
    char wanted[LINE] = "";
    if (write) {
        fprintf(list, "%s\n", line);
        return 0;
    }
    if (!fgets(wanted, sizeof wanted, list))
        snprintf(wanted, sizeof wanted, "nothing");
    wanted[strcspn(wanted, "\n")] = 0;
    if (strcmp(wanted, line) == 0)
        return 0;
    print_message("%s\n  instead of %s\n", line, wanted);
    return 1;
}

/** Untangling takes long: each tangled mesh takes its third of the ways. */
static int is_asked(int shape, int way) {
    return shapes[shape].tangling == TEST_TANGLINGS || way % 3 == shape % 3;
}

/** The lines of cells of every type, of both orders; each takes its sixth of the ways. */
static int expect_cells(FILE *list, int threads, planish_isa isa, const char *write) {
    static const char *const names[N_BOX_KINDS] = {"quadrilaterals", "mixed-2",  "hexahedra",
                                                   "wedges",         "pyramids", "mixed"};
    char line[LINE], name[LINE / 2];
    int different = 0, n = 0;
    for (int kind = 0; kind < N_BOX_KINDS; kind++)
        for (int order = 1; order <= 2; order++) {
            subject s;
            cell_box *b = subject_of_cells(&s, kind, order);
            snprintf(name, sizeof name, "%s-of-order-%d", names[kind], order);
            for (size_t way = 0; way < sizeof ways / sizeof *ways && different < ENOUGH; way++) {
                planish_options options;
                if ((int)way % 6 != (2 * kind + order) % 6 ||
                    ways[way].how & (SURFACE | PERIODIC | ROUNDED) ||
                    !set_way(&s, ways[way].how, &options))
                    continue;
                if (n++ % effort_step(4) > 0) {
                    assert_non_null(fgets(line, sizeof line, list));
                    continue;
                }
                options.worst = options.worst == PLANISH_WORST_NONE ? PLANISH_WORST_NONE
                                : options.worst == PLANISH_WORST_ANGLE
                                    ? PLANISH_WORST_SCALED_JACOBIAN
                                    : PLANISH_WORST_ASPECT_RATIO;
                options.threads = threads;
                options.isa = isa;
                smooth_line(&s, name, (int)way, &options, line);
                different += compare_line(list, line, write);
            }
            free(s.constraint);
            free(s.direction);
            free(s.min_volume);
            cell_box_destroy(b);
        }
    return different;
}

/* ---- shapes ------------------------------------------------------------------------------- */

/** A mesh and the shape of its surface; arrays are owned. */
typedef struct shaped {
    subject s;
    cell_box *box;        /* NULL: of tetrahedra, or a known surface */
    planish_cells facets; /* of a surface */
    test_surface known;   /* likewise */
    planish_shape *shape;
    int is_surface;
} shaped;

enum { BALL, CYLINDER, SIZE = 5 };

/** Bodies, and surfaces in space: of boxes of cells that are made round, or known ones. */
static const struct {
    const char *name;
    int is_surface, form, kind; /* N_BOX_KINDS: of tetrahedra, or a known surface form */
} rounds[] = {
    {"ball", 0, BALL, N_BOX_KINDS},
    {"cylinder", 0, CYLINDER, N_BOX_KINDS},
    {"hexahedral-cylinder", 0, CYLINDER, BOX_HEXAHEDRA},
    {"hexahedral-ball", 0, BALL, BOX_HEXAHEDRA},
    {"wedges-in-cylinder", 0, CYLINDER, BOX_WEDGES},
    {"mixed-ball", 0, BALL, BOX_MIXED},
    {"sphere-in-space", 1, 0, N_BOX_KINDS},
    {"torus-in-space", 1, 1, N_BOX_KINDS},
    {"cylinder-in-space", 1, 2, N_BOX_KINDS},
    {"fillets-in-space", 1, 4, N_BOX_KINDS},
    {"quadrilaterals-of-ball", 1, BALL, BOX_HEXAHEDRA},
    {"facets-of-cylinder", 1, CYLINDER, BOX_MIXED},
};

/** Push what is within the box, and sides along themselves; take it to a ball, or its y and z to a disc. */
static void make_round(const planish_mesh *mesh, double *x, int form) {
    unsigned seed = 11;
    for (int64_t i = 0; i < 3 * mesh->n_nodes; i++)
        if (x[i] > 0 && x[i] < SIZE)
            x[i] += 0.4 * (test_random(&seed) - 0.5);
    for (int64_t i = 0; i < 3 * mesh->n_nodes; i += 3) {
        double g[3], square[3];
        for (int d = 0; d < 3; d++) {
            g[d] = 2 * x[i + d] / SIZE - 1;
            square[d] = form == CYLINDER && d == 0 ? 0 : g[d] * g[d] / 2;
        }
        for (int d = form == CYLINDER; d < 3; d++) {
            const double a = square[(d + 1) % 3], b = square[(d + 2) % 3];
            x[i + d] = SIZE / 2. * (g[d] * sqrt(1 - a - b + 4 * a * b / 3) + 1);
        }
    }
}

/** Make the facets of a box that are in its sides, which are round already: start has its nodes before. */
static void list_facets(shaped *t, const double *start) {
    const planish_cells *cells = &t->box->cells;
    uint8_t *type = checked(calloc((size_t)cells->n * PL_CELL_FACES, 1));
    int64_t *offset = checked(calloc((size_t)cells->n * PL_CELL_FACES + 1, sizeof *offset));
    int32_t *node = checked(calloc((size_t)cells->n * PL_CELL_FACES * 4, sizeof *node));
    int64_t n = 0;
    for (int64_t c = 0; c < cells->n; c++) {
        const pl_cell_shape *shape = pl_cell_type_of(cells->type[c])->shape;
        for (int f = 0; f < shape->n_facets; f++) {
            const int corners = shape->facet[f][3] < shape->n_corners ? 4 : 3;
            int is_on[6] = {0};
            for (int j = 0; j < corners; j++) {
                const int32_t v = cells->node[cells->offset[c] + shape->facet[f][j]];
                node[offset[n] + j] = v;
                for (int side = 0; side < 6; side++)
                    is_on[side] += start[3 * v + side / 2] == (side % 2) * SIZE;
            }
            int on = 0;
            for (int side = 0; side < 6; side++)
                on |= is_on[side] == corners;
            if (!on)
                continue;
            type[n] = corners == 4 ? PLANISH_CELL_QUADRILATERAL : PLANISH_CELL_TRIANGLE;
            offset[n + 1] = offset[n] + corners;
            n++;
        }
    }
    t->facets = (planish_cells){.n = n, .type = type, .offset = offset, .node = node};
}

static void shaped_create(shaped *t, int which) {
    const int form = rounds[which].form, is_surface = rounds[which].is_surface;
    double *x;
    memset(t, 0, sizeof *t);
    t->is_surface = is_surface;
    if (rounds[which].kind < N_BOX_KINDS) {
        t->box = cell_box_create((cell_box_kind)rounds[which].kind, SIZE);
        t->s.base.mesh = t->box->mesh;
        x = t->box->x;
    } else if (is_surface) {
        test_surface_known(&t->known, form, 4, 0.3, 5);
        t->s.base.mesh = t->known.mesh;
        x = t->known.x[0];
    } else {
        test_mesh_box(&t->s.base, 3, SIZE);
        x = t->s.base.coordinates;
    }
    planish_mesh *mesh = &t->s.base.mesh;
    const size_t n = (size_t)mesh->n_nodes;
    if (t->box && is_surface) {
        list_facets(t, x);
        mesh->cells = &t->facets;
        mesh->n_elements = t->facets.n;
    }
    if (t->box || !is_surface)
        make_round(mesh, x, form);
    for (size_t i = 0; i < 3 * n; i++)
        x[i] = round(x[i] * 0x1p20) * 0x1p-20;
    assert_int_equal(planish_shape_create(mesh, NULL, 1, &t->shape, NULL, NULL), 0);
    if (is_surface)
        return;
    t->s.constraint = checked(malloc(n));
    t->s.direction = checked(calloc(3 * n, sizeof *t->s.direction));
    const planish_surface surface = {.shape = t->shape};
    assert_int_equal(
        planish_find_slides(mesh, &surface, 1, t->s.constraint, t->s.direction, NULL, NULL), 0);
    mesh->constraint = t->s.constraint;
    mesh->direction = t->s.direction;
}

static void shaped_destroy(shaped *t) {
    planish_shape_destroy(t->shape);
    free(t->s.constraint);
    free(t->s.direction);
    if (t->box) {
        free((void *)t->facets.type);
        free((void *)t->facets.offset);
        free((void *)t->facets.node);
        cell_box_destroy(t->box);
    } else if (t->is_surface) {
        test_surface_destroy(&t->known);
    } else {
        test_mesh_destroy(&t->s.base);
    }
}

/** A line as smooth_line's, and how many moves were shortened or refused for the shape's sake. */
static void shape_line(const shaped *t, const char *name, const char *way,
                       const planish_options *options, char *line) {
    planish_plan *plan = NULL;
    planish_error error = {.text = ""};
    planish_result result;
    planish_mesh mesh = t->s.mesh;
    double *x = test_copy_of(&mesh);
    if (t->is_surface ? planish_smooth_surface(&mesh, x, options, &result, &error)
                      : planish_plan_create(&mesh, options, &plan, &error) ||
                            planish_smooth(plan, x, options, &result, &error))
        fail_msg("%s %s: %s", name, way, error.text);
    mesh.coordinates = x;
    snprintf(line, LINE, "%s %s %016llx %016llx %lld", name, way,
             (unsigned long long)planish_checksum(&mesh), (unsigned long long)hash_result(&result),
             (long long)result.n_off_shape);
    planish_plan_destroy(plan);
    free(x);
}

/** Whether a way is one of nodes on a shape: each mesh takes some of them. */
static int is_way_on_shape(const shaped *t, size_t which, size_t way) {
    const unsigned how = ways[way].how;
    const unsigned never = SLIDE | SURFACE | PERIODIC | MIN_VOLUMES | AROUND | LAPLACIAN | TANGLED;
    const unsigned of_plans = EDGE_RATIO | FLETCHER_REEVES | MIN_VOLUME | WEIGHT | SELECT_LATER;
    if (how & never || (t->is_surface && how & of_plans) || (how & BOUNDS && how & MIN_VOLUME))
        return 0;
    return how == 0 || way % 3 == which % 3;
}

/** The lines of nodes that slide on the shape of their surface, and of surfaces in space. */
static int expect_shapes(FILE *list, int threads, planish_isa isa, const char *write) {
    char line[LINE];
    int different = 0, n = 0;
    for (size_t which = 0; which < sizeof rounds / sizeof *rounds; which++) {
        shaped t;
        shaped_create(&t, (int)which);
        for (size_t way = 0; way < sizeof ways / sizeof *ways && different < ENOUGH; way++) {
            planish_options options;
            if (!is_way_on_shape(&t, which, way) || !set_way(&t.s, ways[way].how, &options))
                continue;
            if (n++ % effort_step(4) > 0) {
                assert_non_null(fgets(line, sizeof line, list));
                continue;
            }
            if (options.worst != PLANISH_WORST_NONE && t.box)
                options.worst = options.worst == PLANISH_WORST_ANGLE ? PLANISH_WORST_SCALED_JACOBIAN
                                                                     : PLANISH_WORST_ASPECT_RATIO;
            options.shape = t.shape;
            options.threads = threads;
            options.isa = isa;
            shape_line(&t, rounds[which].name, ways[way].name, &options, line);
            different += compare_line(list, line, write);
        }
        shaped_destroy(&t);
    }
    return different;
}

/* ---- all ------------------------------------------------------------------------------------ */

/** All lines with these threads and this kernel. */
static void expect_list(int threads, planish_isa isa, const char *write) {
    char line[LINE];
    int different = 0, n = 0;
    FILE *list = checked(open_list(write));
    for (size_t shape = 0; shape < sizeof shapes / sizeof *shapes; shape++) {
        subject s;
        subject_create(&s, (int)shape);
        for (size_t way = 0; way < sizeof ways / sizeof *ways && different < ENOUGH; way++) {
            planish_options options;
            if (!is_asked((int)shape, (int)way) || !set_way(&s, ways[way].how, &options))
                continue;
            if (n++ % effort_step(4) > 0) {
                assert_non_null(fgets(line, sizeof line, list));
                continue;
            }
            options.threads = threads;
            options.isa = isa;
            smooth_line(&s, shapes[shape].name, (int)way, &options, line);
            different += compare_line(list, line, write);
        }
        subject_destroy(&s);
    }
    if (different < ENOUGH)
        different += expect_cells(list, threads, isa, write);
    if (different < ENOUGH)
        different += expect_shapes(list, threads, isa, write);
    assert_true(write || different || fgetc(list) == EOF);
    assert_int_equal(fclose(list), 0);
    assert_int_equal(different, 0);
}

static void results_have_the_same_bits_as_ever(void **state) {
    (void)state;
    expect_list(1, PLANISH_ISA_AUTO, getenv("PLANISH_CHECKSUMS"));
}

static void so_they_have_with_other_kernels_and_threads(void **state) {
    (void)state;
    if (!effort(0, 1))
        skip();
    expect_list(3, PLANISH_ISA_PLAIN, NULL);
    expect_list(2, PLANISH_ISA_VECTOR, NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(results_have_the_same_bits_as_ever),
        cmocka_unit_test(so_they_have_with_other_kernels_and_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
