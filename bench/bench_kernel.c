/* bench_kernel: nanoseconds per star of each kernel variant, as JSON.
 *
 *   bench_kernel MESH [REPEAT]
 *
 * value: gather a star and evaluate its sum of RR^2; derivatives: the same with gradient and
 * Hessian; visit: one whole visit (a Newton step with its search) of every star, on the mesh as it
 * is; later: the same in the sixth sweep, when most stars have kept their Hessian. First the plain
 * problem, then the guarded kernel with each objective and a minimum volume that is far away. One
 * thread; each figure is the best of the repeats. "check" must be the same for all variants of a
 * problem. bytes_per_star: of the plan, which a visit reads from one end to the other; coordinates,
 * which stars share, come on top.
 */
#include "base/sum.h"
#include "plan/plan.h"

#include <planish/planish_io.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { SWEEPS = 6 };

typedef struct figures {
    double value, derivatives, visit, later; /* seconds for all stars */
    uint64_t check;                          /* of the coordinates after the visits */
} figures;

static double seconds_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

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
    int which = plan->dim - 2;
    pl_star_evaluate_fn *evaluate =
        problem->guard ? kernel->guarded->evaluate[which] : kernel->evaluate[which];
    pl_star_visit_fn *visit = problem->guard ? kernel->guarded->visit[which] : kernel->visit[which];
    for (int derivatives = 0; derivatives < 2; derivatives++) {
        pl_star_value value;
        double begin = seconds_now();
        for (int64_t i = 0; i < plan->interior.stars.n_stars; i++)
            evaluate(problem, i, plan->scratch.kernels, derivatives, &value);
        double *figure = derivatives ? &best->derivatives : &best->value;
        *figure = least(seconds_now() - begin, *figure);
    }
    memcpy(problem->coordinates, start,
           (size_t)plan->work.n_nodes * (size_t)plan->dim * sizeof(double));
    if (problem->kept)
        memset(problem->kept, 0, (size_t)plan->interior.stars.n_stars * sizeof *problem->kept);
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        memset(problem->changed, 1, (size_t)plan->work.n_nodes);
        double begin = seconds_now();
        for (int c = 0; c < plan->interior.n_colours; c++)
            visit(problem, plan->interior.colour_begin[c], plan->interior.colour_begin[c + 1],
                  plan->scratch.kernels, &plan->scratch.tally->of);
        const double seconds = seconds_now() - begin;
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
        const double begin = seconds_now();
        pl_sum exact = {.n_added = 0};
        double plain = 0;
        for (int64_t i = 0; i < n && is_exact; i++)
            pl_sum_add(&exact, terms[i]);
        for (int64_t i = 0; i < n && !is_exact; i++)
            plain += terms[i];
        volatile double sum = is_exact ? pl_sum_value(&exact) : plain; /* somebody wants it */
        (void)sum;
        best = least(seconds_now() - begin, best);
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
    const char *separator = "";
    printf("  \"ns_per_star\": [");
    problem.kept = plan->scratch.kept;
    measure_variants(plan, &problem, "plain", start, repeat, &separator);
    problem.kept = NULL;
    problem.guard = &guard;
    for (int i = 0; i < N_OBJECTIVES; i++) {
        guard.objective = i;
        measure_variants(plan, &problem, names[i], start, repeat, &separator);
    }
    printf(" ],\n  \"ns_per_term\": { \"exact_sum\": %.2f, \"plain_sum\": %.2f }\n}\n",
           1e9 / (double)values * time_sum(start, values, 1, repeat),
           1e9 / (double)values * time_sum(start, values, 0, repeat));
    free(start);
    return 0;
}

int main(int argc, char **argv) {
    planish_error error = {.text = ""};
    planish_options options;
    planish_file *file = NULL;
    planish_plan *plan = NULL;
    if (argc < 2 || argc > 3) {
        fprintf(stderr, "usage: bench_kernel MESH [REPEAT]\n");
        return 64;
    }
    planish_options_init(&options);
    options.threads = 1;
    options.bind = 1;
    int status = planish_file_open(argv[1], NULL, 0, &file, &error);
    if (!status) {
        planish_mesh mesh = planish_file_mesh(file);
        status = planish_plan_create(&mesh, &options, &plan, &error);
        if (!status) {
            const int64_t n = plan->interior.stars.n_stars;
            const double per_star = n ? 1 / (double)n : 0;
            const double facets = (double)plan->interior.stars.link_offset[n] * per_star;
            const double ring = (double)plan->interior.stars.ring_offset[n] * per_star;
            const double link_bytes = (double)pl_link_positions(plan->dim) * facets;
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
    return status || fflush(stdout) ? 2 : 0;
}
