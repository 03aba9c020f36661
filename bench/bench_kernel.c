/* bench_kernel: nanoseconds per star of each kernel variant, as JSON.
 *
 *   bench_kernel MESH|TYPE [REPEAT]
 *
 * TYPE: quadrilaterals, hexahedra, wedges, pyramids: a grid of these with displaced nodes.
 *
 * value: gather a star and evaluate its sum of RR^2; derivatives: the same with gradient and
 * Hessian; visit: one whole visit (a Newton step with its search) of every star, on the mesh as it
 * is; later: the same in the sixth sweep, when most stars have kept their Hessian. First the plain
 * problem of simplices, then that of mean ratios, then the guarded kernel with each objective and a
 * minimum volume that is far away, then with bounds that are far away, and then with nodes that slide
 * on planes. One thread; each figure is the best of the repeats. "check" must be the same for all
 * variants of a problem. bytes_per_star: bytes of the plan that a visit reads, without coordinates,
 * which stars share.
 */
#include "base/sum.h"
#include "common.h"
#include "geometry/cell.h"
#include "plan/plan.h"

#include <planish/planish_io.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SWEEPS = 6 };

typedef struct figures {
    double value, derivatives, visit, later; /* seconds for all stars */
    uint64_t check;                          /* of the coordinates after the visits */
} figures;

static uint64_t checksum(const double *values, int64_t n) {
    uint64_t hash = 14695981039346656037u; /* FNV-1a over words */
    for (int64_t i = 0; i < n; i++) {
        uint64_t word;
        memcpy(&word, &values[i], sizeof word);
        hash = (hash ^ word) * 1099511628211u;
    }
    return hash;
}

static double least(double a, double b) {
    return b == 0 || a < b ? a : b;
}

static void measure(const planish_plan *plan, const pl_star_kernel *kernel,
                    pl_star_problem *problem, const double *start, figures *best) {
    pl_star_evaluate_fn *evaluate = pl_star_evaluate_of(kernel, problem, plan->dim);
    pl_star_visit_fn *visit = pl_star_visit_of(kernel, problem, plan->dim);
    pl_star_tally tally = {.gain = NULL};
    for (int derivatives = 0; derivatives < 2; derivatives++) {
        pl_star_value value;
        double begin = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
        for (int64_t i = 0; i < plan->interior.stars.n_stars; i++)
            evaluate(problem, i, plan->scratch.kernels, derivatives, &value);
        double *figure = derivatives ? &best->derivatives : &best->value;
        *figure = least(bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - begin, *figure);
    }
    memcpy(problem->coordinates, start,
           (size_t)plan->work.n_nodes * (size_t)plan->dim * sizeof(double));
    if (problem->kept)
        memset(problem->kept, 0, (size_t)plan->interior.stars.n_stars * sizeof *problem->kept);
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        memset(problem->changed, 1, (size_t)plan->work.n_nodes);
        double begin = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
        for (int c = 0; c < plan->interior.n_colours; c++)
            visit(problem, plan->interior.colour_begin[c], plan->interior.colour_begin[c + 1],
                  plan->scratch.kernels, &tally);
        const double seconds = bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - begin;
        if (sweep == 0)
            best->visit = least(seconds, best->visit);
        if (sweep == SWEEPS - 1)
            best->later = least(seconds, best->later);
    }
    best->check = checksum(problem->coordinates, plan->work.n_nodes * plan->dim);
    memcpy(problem->coordinates, start,
           (size_t)plan->work.n_nodes * (size_t)plan->dim * sizeof(double));
}

/** All variants of the kernel for one problem. */
static void measure_variants(const planish_plan *plan, pl_star_problem *problem, const char *name,
                             const double *start, int repeat, const char **separator) {
    double per_star = plan->interior.stars.n_stars ? 1e9 / (double)plan->interior.stars.n_stars : 0;
    for (int isa = PLANISH_ISA_PLAIN; isa <= PLANISH_ISA_AVX512; isa++) {
        const pl_star_kernel *kernel = pl_star_kernel_select((planish_isa)isa);
        figures best = {0};
        if (!kernel)
            continue;
        for (int i = 0; i < repeat; i++)
            measure(plan, kernel, problem, start, &best);
        printf("%s\n    { \"problem\": \"%s\", \"isa\": \"%s\", \"value\": %.1f, "
               "\"derivatives\": %.1f, \"visit\": %.1f, \"later\": %.1f, "
               "\"check\": \"%016llx\" }",
               *separator, name, kernel->name, best.value * per_star, best.derivatives * per_star,
               best.visit * per_star, best.later * per_star, (unsigned long long)best.check);
        *separator = ",";
    }
}

/** Best seconds of adding up terms [n], exactly or as doubles are added. */
static double time_sum(const double *terms, int64_t n, int is_exact, int repeat) {
    double best = 0;
    for (int r = 0; r < repeat; r++) {
        const double begin = bench_seconds(CLOCK_PROCESS_CPUTIME_ID);
        pl_sum exact = {.n_added = 0};
        double plain = 0;
        for (int64_t i = 0; i < n && is_exact; i++)
            pl_sum_add(&exact, terms[i]);
        for (int64_t i = 0; i < n && !is_exact; i++)
            plain += terms[i];
        volatile double sum = is_exact ? pl_sum_value(&exact) : plain; /* somebody wants it */
        (void)sum;
        best = least(bench_seconds(CLOCK_PROCESS_CPUTIME_ID) - begin, best);
    }
    return best;
}

/** A minimum volume that no element comes near to. */
static double far_volume(const planish_plan *plan, const planish_mesh *mesh) {
    planish_quality quality;
    planish_error error;
    if (planish_measure(plan, mesh->coordinates, &quality, &error))
        return 0;
    return quality.min_volume > 0 ? 1e-3 * quality.min_volume : 0;
}

/** Arrays of a guard: bounds far away from all nodes, and planes through them. */
typedef struct constraints {
    double *lower, *upper; /* [n_nodes][dim] */
    pl_star_slide *slide;  /* [n_stars] */
} constraints;

static int make_constraints(const planish_plan *plan, const pl_star_problem *problem,
                            const double *start, constraints *c) {
    const int64_t n_values = plan->work.n_nodes * plan->dim;
    const int64_t n_stars = plan->interior.stars.n_stars;
    c->lower = malloc((size_t)n_values * sizeof *c->lower);
    c->upper = malloc((size_t)n_values * sizeof *c->upper);
    c->slide = calloc((size_t)n_stars, sizeof *c->slide);
    if (!c->lower || !c->upper || !c->slide)
        return 0;
    for (int64_t i = 0; i < n_values; i++) {
        c->lower[i] = -1e9;
        c->upper[i] = 1e9;
    }
    for (int64_t i = 0; i < n_stars; i++) {
        pl_star_slide *slide = &c->slide[i];
        const double *place = start + (int64_t)problem->node[i] * plan->dim;
        slide->kind = PLANISH_CONSTRAINT_ON_PLANE;
        memcpy(slide->point, place, (size_t)plan->dim * sizeof *place);
        slide->direction[0] = 0.6;
        slide->direction[1] = 0.8;
    }
    return 1;
}

static void free_constraints(constraints *c) {
    free(c->lower);
    free(c->upper);
    free(c->slide);
}

static int run(const planish_plan *plan, const planish_mesh *mesh, int repeat) {
    int64_t values = plan->work.n_nodes * plan->dim;
    double *start = malloc((size_t)values * sizeof *start);
    if (!start)
        return 2;
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        for (int d = 0; d < plan->dim; d++)
            start[(int64_t)plan->inner[i] * plan->dim + d] = mesh->coordinates[i * plan->dim + d];
    memcpy(plan->scratch.coordinates, start, (size_t)values * sizeof *start);
    static const char *const names[] = {"guarded, radius ratio", "guarded, mean ratio",
                                        "guarded, edge ratio"};
    enum { N_OBJECTIVES = sizeof names / sizeof *names };
    pl_star_problem problem = pl_plan_problem(plan, &plan->interior);
    pl_star_guard guard = {.ratio_weight = 1, .min_volume = far_volume(plan, mesh)};
    constraints far = {NULL, NULL, NULL};
    if (!make_constraints(plan, &problem, start, &far)) {
        free_constraints(&far);
        free(start);
        return 2;
    }
    const char *separator = "";
    printf("  \"ns_per_star\": [");
    problem.kept = plan->scratch.kept;
    if (!plan->work.corner)
        measure_variants(plan, &problem, "plain", start, repeat, &separator);
    problem.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
    measure_variants(plan, &problem, "mean ratio", start, repeat, &separator);
    problem.guard = &guard;
    for (int i = plan->work.corner ? 1 : 0; i < N_OBJECTIVES; i++) {
        guard.objective = i;
        measure_variants(plan, &problem, names[i], start, repeat, &separator);
    }
    guard = (pl_star_guard){.objective = plan->work.corner ? PLANISH_OBJECTIVE_MEAN_RATIO : 0,
                            .ratio_weight = 1,
                            .lower = far.lower,
                            .upper = far.upper};
    measure_variants(plan, &problem, "bounds", start, repeat, &separator);
    guard.lower = guard.upper = NULL;
    problem.slide = far.slide;
    measure_variants(plan, &problem, "sliding", start, repeat, &separator);
    free_constraints(&far);
    printf(" ],\n  \"ns_per_term\": { \"exact_sum\": %.2f, \"plain_sum\": %.2f }\n}\n",
           1e9 / (double)values * time_sum(start, values, 1, repeat),
           1e9 / (double)values * time_sum(start, values, 0, repeat));
    free(start);
    return 0;
}

/* ---- grids of cells ------------------------------------------------------------------------- */

enum { SIDE_OF_SQUARES = 100, SIDE_OF_CUBES = 16 }; /* cubes or squares along a side */

/** Grid of cells of one type. Arrays are owned. */
typedef struct grid {
    int dim, side;
    double *coordinates;
    uint8_t *type;
    int64_t *offset;
    int32_t *node;
    planish_cells cells;
} grid;

/* How a cube is cut: places of corners, 8 for its middle. */
static const int8_t HEXAHEDRON[][8] = {{0, 1, 3, 2, 4, 5, 7, 6}};
static const int8_t WEDGES[][8] = {{0, 1, 3, 4, 5, 7}, {0, 3, 2, 4, 7, 6}};
static const int8_t PYRAMIDS[][8] = {{0, 1, 3, 2, 8}, {4, 6, 7, 5, 8}, {0, 4, 5, 1, 8},
                                     {2, 3, 7, 6, 8}, {0, 2, 6, 4, 8}, {1, 5, 7, 3, 8}};
static const int8_t QUADRILATERAL[][8] = {{0, 1, 3, 2}};

typedef struct cutting {
    const char *name;
    planish_cell_type type;
    const int8_t (*cell)[8];
    int n_cells;
} cutting;

static const cutting CUTTINGS[] = {{"quadrilaterals", PLANISH_CELL_QUADRILATERAL, QUADRILATERAL, 1},
                                   {"hexahedra", PLANISH_CELL_HEXAHEDRON, HEXAHEDRON, 1},
                                   {"wedges", PLANISH_CELL_WEDGE, WEDGES, 2},
                                   {"pyramids", PLANISH_CELL_PYRAMID, PYRAMIDS, 6}};

/** Cut the square or cube at place of the grid, whose number is cube. */
static void cut_cube(grid *g, const cutting *how, const int place[3], int64_t cube) {
    const int64_t row = g->side + 1, layer = row * row, n = g->dim == 3 ? layer * row : layer;
    const int n_corners = pl_cell_type_of((int)how->type)->shape->n_corners;
    for (int c = 0; c < how->n_cells; c++) {
        int32_t *node = g->node + g->offset[g->cells.n];
        for (int k = 0; k < n_corners; k++) {
            const int at = how->cell[c][k];
            const int64_t x = place[0] + (at & 1), y = place[1] + (at >> 1 & 1);
            const int64_t z = place[2] + (at >> 2 & 1);
            node[k] = (int32_t)(at == 8 ? n + cube : x + y * row + z * layer);
        }
        g->type[g->cells.n] = (uint8_t)how->type;
        g->offset[g->cells.n + 1] = g->offset[g->cells.n] + n_corners;
        g->cells.n++;
    }
}

/** Place node i of the grid, or the middle of a cube, somewhat off. */
static void place_node(grid *g, int64_t i, const double at[3], int is_inside, unsigned *random) {
    for (int d = 0; d < g->dim; d++) {
        *random = *random * 1664525u + 1013904223u;
        const double off = (double)(*random >> 8) / (1 << 24) - 0.5;
        g->coordinates[i * g->dim + d] = at[d] + (is_inside ? 0.4 * off : 0);
    }
}

/** Make a grid; returns its nodes, 0 without memory. */
static int64_t make_grid(grid *g, const cutting *how) {
    const pl_cell_shape *shape = pl_cell_type_of((int)how->type)->shape;
    g->dim = shape->dim;
    g->side = g->dim == 2 ? SIDE_OF_SQUARES : SIDE_OF_CUBES;
    const int64_t side = g->side, layers = g->dim == 3 ? side : 1, row = side + 1;
    const int64_t n_lattice = row * row * (g->dim == 3 ? row : 1), cubes = side * side * layers;
    const int64_t n_nodes = n_lattice + (how->n_cells == 6 ? cubes : 0);
    const int64_t n_cells = cubes * how->n_cells;
    unsigned random = 1;
    g->coordinates = calloc((size_t)(n_nodes * g->dim), sizeof *g->coordinates);
    g->type = calloc((size_t)n_cells, 1);
    g->offset = calloc((size_t)n_cells + 1, sizeof *g->offset);
    g->node = calloc((size_t)(n_cells * shape->n_corners), sizeof *g->node);
    if (!g->coordinates || !g->type || !g->offset || !g->node)
        return 0;
    for (int64_t i = 0; i < n_lattice; i++) {
        const int64_t at[3] = {i % row, i / row % row, i / (row * row)};
        const double x[3] = {(double)at[0], (double)at[1], (double)at[2]};
        int inside = 1;
        for (int d = 0; d < g->dim; d++)
            inside &= at[d] > 0 && at[d] < side;
        place_node(g, i, x, inside, &random);
    }
    for (int64_t i = 0; i < cubes; i++) {
        const int place[3] = {(int)(i % side), (int)(i / side % side), (int)(i / (side * side))};
        const double middle[3] = {place[0] + 0.5, place[1] + 0.5, place[2] + 0.5};
        if (n_nodes > n_lattice)
            place_node(g, n_lattice + i, middle, 1, &random);
        cut_cube(g, how, place, i);
    }
    g->cells.type = g->type;
    g->cells.offset = g->offset;
    g->cells.node = g->node;
    return n_nodes;
}

static void free_grid(grid *g) {
    free(g->coordinates);
    free(g->type);
    free(g->offset);
    free(g->node);
}

/** Open the mesh of a name: a grid, or a file. */
static int open_mesh(const char *name, grid *g, planish_file **file, planish_mesh *mesh,
                     planish_error *error) {
    for (size_t i = 0; i < sizeof CUTTINGS / sizeof *CUTTINGS; i++)
        if (!strcmp(name, CUTTINGS[i].name)) {
            const int64_t n_nodes = make_grid(g, &CUTTINGS[i]);
            *mesh = (planish_mesh){.dim = g->dim,
                                   .n_nodes = n_nodes,
                                   .n_elements = g->cells.n,
                                   .coordinates = g->coordinates,
                                   .cells = &g->cells};
            return n_nodes > 0 ? 0 : PLANISH_ERROR_MEMORY;
        }
    const int status = planish_file_open(name, NULL, 0, file, error);
    if (!status)
        *mesh = planish_file_mesh(*file);
    return status;
}

int main(int argc, char **argv) {
    planish_error error = {.text = ""};
    planish_options options;
    planish_file *file = NULL;
    planish_plan *plan = NULL;
    planish_mesh mesh;
    grid g = {.dim = 0};
    if (argc < 2 || argc > 3) {
        fprintf(stderr, "usage: bench_kernel MESH|TYPE [REPEAT]\n");
        return 64;
    }
    planish_options_init(&options);
    options.threads = 1;
    options.bind = 1;
    int status = open_mesh(argv[1], &g, &file, &mesh, &error);
    if (!status) {
        status = planish_plan_create(&mesh, &options, &plan, &error);
        if (!status) {
            const int64_t n = plan->interior.stars.n_stars;
            const double per_star = n ? 1 / (double)n : 0;
            const double facets = (double)plan->interior.stars.link_offset[n] * per_star;
            const double ring = (double)plan->interior.stars.ring_offset[n] * per_star;
            const double link_bytes =
                (double)pl_link_positions(plan->dim, plan->interior.stars.form != NULL) * facets;
            printf("{ \"planish\": \"%s\", \"mesh\": \"%s\", \"stars\": %lld, "
                   "\"facets_per_star\": %.2f, \"ring_per_star\": %.2f, "
                   "\"bytes_per_star\": %.1f,\n",
                   planish_version(), argv[1], (long long)n, facets, ring,
                   link_bytes * (plan->interior.stars.link.high ? 2 : 1) + ring * sizeof(int32_t) +
                       2 * sizeof(int64_t) + sizeof(int32_t));
            status = run(plan, &mesh, argc > 2 ? atoi(argv[2]) : 5);
        }
    }
    if (status)
        fprintf(stderr, "bench_kernel: %s\n", error.text);
    planish_plan_destroy(plan);
    planish_file_close(file);
    free_grid(&g);
    return status || fflush(stdout) ? 2 : 0;
}
