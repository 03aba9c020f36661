/* bench_smooth: how fast a mesh is smoothed, as JSON.
 *
 *   bench_smooth MESH [--target RMS] [--only-worse-than RR] [--max-sweeps N] [--repeat N]
 *                     [--threads LIST] [--isa LIST]
 *                     [--direction D] [--no-bind]
 *
 * For every kernel and number of threads: time of the set-up (planish_plan_create), of the sweeps
 * until the RMS is at most the target and until convergence, node visits per second, and the most
 * memory that the library took beyond the caller's arrays (Linux only). Each other figure is
 * the best of the repeats, since other load only adds; repeats take turns, so that such load falls
 * on all alike. Everything is measured on one mesh in one process, so ratios are fair. Times
 * exclude reading the file, which is reported by itself; memory that a run takes was touched
 * before, and what a process has once for all meshes (code, most of it hwloc's plug-ins, and
 * threads) is there already: loaded_bytes.
 */
#include "common.h"

#include <planish/planish_io.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

enum { MAX_LIST = 16, MAX_SWEEPS = 1000 };

typedef struct settings {
    const char *path;
    double target; /* RMS of RR over all elements; 0: none */
    double only_worse_than;
    int repeat, max_sweeps, bind;
    int threads[MAX_LIST], n_threads;
    planish_isa isa[MAX_LIST];
    int n_isa;
    planish_search direction;
} settings;

/** One smoothing, sweep by sweep. */
typedef struct history {
    int n;
    double rms[MAX_SWEEPS], seconds[MAX_SWEEPS];
    int64_t visits;
} history;

/** Times of sweeps: all sweeps together, and the mean of the first ones, in which nearly all nodes
 *  are visited. */
typedef struct figures {
    double setup, whole, first_sweep, early_sweep, to_target, sweeps, visits_per_second, rms;
    int n_sweeps, sweeps_to_target;
    int64_t visits, bytes;
} figures;

static const char *const isa_names[] = {"auto", "plain", "vector", "avx2", "avx512"};

/* ---- memory ------------------------------------------------------------------------------- */

/** A line of /proc/self/status in bytes; 0 where there is none. */
static int64_t status_bytes(const char *key) {
    char line[256];
    long long kilobytes = 0;
    FILE *status = fopen("/proc/self/status", "r");
    if (!status)
        return 0;
    while (fgets(line, sizeof line, status))
        if (!strncmp(line, key, strlen(key)))
            sscanf(line + strlen(key), "%lld", &kilobytes);
    fclose(status);
    return kilobytes * 1024;
}

/** Forget the peak so far; returns what is resident now. */
static int64_t begin_peak(void) {
    FILE *clear = fopen("/proc/self/clear_refs", "w");
    if (clear) {
        fputs("5", clear);
        fclose(clear);
    }
    return status_bytes("VmRSS:");
}

enum { BYTES_PER_ELEMENT = 150 }; /* more than a plan and its making take */

/** Use as much memory as a run will, for a moment: of a virtual machine the host takes back what is
 *  free, within seconds, and finding it again can take as long as a set-up. (Not by malloc, which
 *  would keep what follows for itself.) */
static void touch_memory(int64_t n_elements) {
    const size_t size = (size_t)n_elements * BYTES_PER_ELEMENT;
    char *memory = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED)
        return;
#ifdef MADV_HUGEPAGE
    madvise(memory, size, MADV_HUGEPAGE); /* as the plan's are */
#endif
    memset(memory, 1, size);
    munmap(memory, size);
}

/* ---- one run ------------------------------------------------------------------------------ */

static int fail(const char *what, const planish_error *error) {
    fprintf(stderr, "bench_smooth: %s%s%s\n", what, error ? ": " : "", error ? error->text : "");
    return 2;
}

static int record(const planish_progress *progress, void *user) {
    history *h = user;
    if (progress->sweep_done && h->n < MAX_SWEEPS) {
        h->rms[h->n] = progress->rms;
        h->seconds[h->n++] = progress->seconds;
        h->visits += progress->visits;
    }
    return 0;
}

static double smaller(double a, double b) {
    return b == 0 || a < b ? a : b;
}

/** Fold one run into the best figures. */
static void fold(figures *best, double setup, double whole, int64_t bytes, const history *h,
                 double target) {
    enum { EARLY = 10 };
    double total = 0, early = 0, reached = 0;
    int sweeps_to_target = 0;
    for (int i = 0; i < h->n; i++) {
        total += h->seconds[i];
        early = i < EARLY ? total / (i + 1) : early;
        if (target > 0 && sweeps_to_target == 0 && h->rms[i] <= target) {
            reached = total;
            sweeps_to_target = i + 1;
        }
    }
    best->setup = smaller(setup, best->setup);
    best->whole = smaller(whole, best->whole);
    best->sweeps = smaller(total, best->sweeps);
    best->first_sweep = h->n ? smaller(h->seconds[0], best->first_sweep) : 0;
    best->early_sweep = smaller(early, best->early_sweep);
    best->to_target = reached > 0 ? smaller(reached, best->to_target) : 0;
    best->sweeps_to_target = sweeps_to_target;
    best->n_sweeps = h->n;
    best->visits = h->visits;
    best->visits_per_second = best->sweeps > 0 ? (double)h->visits / best->sweeps : 0;
    best->bytes = bytes > best->bytes ? bytes : best->bytes; /* later runs find memory at hand */
    best->rms = h->n ? h->rms[h->n - 1] : 0;
}

static planish_options options_of(const settings *s, int threads, planish_isa isa) {
    planish_options options;
    planish_options_init(&options);
    options.threads = threads;
    options.bind = s->bind;
    if (s->max_sweeps)
        options.max_sweeps = s->max_sweeps;
    options.only_worse_than = s->only_worse_than;
    options.isa = isa;
    options.search = s->direction;
    return options;
}

/** Smooth a star of four tetrahedra, with all kernels and places of threads; the bytes that it
 *  leaves: most of it code. */
static int64_t load(const settings *s) {
    static const int32_t elements[] = {0, 1, 2, 4, 0, 3, 1, 4, 1, 3, 2, 4, 2, 3, 0, 4};
    double coordinates[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, .2, .2, .2};
    const planish_mesh star = {
        .dim = 3, .n_nodes = 5, .n_elements = 4, .elements = elements, .coordinates = coordinates};
    const int64_t before = status_bytes("VmRSS:");
    for (int k = 0; k < s->n_isa; k++)
        for (int t = 0; t < s->n_threads; t++) {
            const planish_options options = options_of(s, s->threads[t], s->isa[k]);
            planish_plan *plan = NULL;
            if (planish_plan_create(&star, &options, &plan, NULL))
                continue; /* the run will say why */
            planish_smooth(plan, coordinates, &options, NULL, NULL);
            planish_plan_destroy(plan);
        }
    return status_bytes("VmRSS:") - before;
}

static int measure_once(const settings *s, const planish_mesh *mesh, int threads, planish_isa isa,
                        double *coordinates, figures *best) {
    planish_error error;
    planish_options options = options_of(s, threads, isa);
    planish_plan *plan = NULL;
    history h = {.n = 0};
    options.progress = record;
    options.progress_user = &h;
    memcpy(coordinates, mesh->coordinates,
           (size_t)mesh->n_nodes * (size_t)mesh->dim * sizeof(double));
    touch_memory(mesh->n_elements);
    int64_t resident = begin_peak();
    double start = bench_seconds(CLOCK_MONOTONIC);
    if (planish_plan_create(mesh, &options, &plan, &error))
        return fail("plan", &error);
    double setup = bench_seconds(CLOCK_MONOTONIC) - start;
    int status = planish_smooth(plan, coordinates, &options, NULL, &error);
    const double whole = bench_seconds(CLOCK_MONOTONIC) - start;
    planish_plan_destroy(plan);
    if (status)
        return fail("smooth", &error);
    fold(best, setup, whole, status_bytes("VmHWM:") - resident, &h, s->target);
    return 0;
}

static void print_figures(const settings *s, const planish_mesh *mesh, const figures *f,
                          int threads, planish_isa isa, int first) {
    printf("%s\n    { \"isa\": \"%s\", \"threads\": %d, \"setup_s\": %.6f, \"whole_s\": %.6f, "
           "\"first_sweep_s\": %.6f, "
           "\"setup_in_early_sweeps\": %.2f, \"setup_in_sweeps\": %.2f,\n      \"sweeps\": %d, "
           "\"sweeps_s\": %.6f, \"visits\": %lld, "
           "\"visits_per_s\": %.0f, \"rms\": %.6f, \"bytes_per_element\": %.1f",
           first ? "" : ",", isa_names[isa], threads, f->setup, f->whole, f->first_sweep,
           f->sweeps > 0 ? f->setup / f->early_sweep : 0,
           f->sweeps > 0 ? f->setup / f->sweeps * f->n_sweeps : 0, f->n_sweeps, f->sweeps,
           (long long)f->visits, f->visits_per_second, f->rms,
           (double)f->bytes / (double)mesh->n_elements);
    if (s->target > 0)
        printf(",\n      \"sweeps_to_target\": %d, \"to_target_s\": %.6f", f->sweeps_to_target,
               f->to_target);
    printf(" }");
}

static int run_all(const settings *s, const planish_mesh *mesh) {
    double *coordinates = malloc((size_t)mesh->n_nodes * (size_t)mesh->dim * sizeof(double));
    if (!coordinates)
        return fail("out of memory", NULL);
    int status = 0, first = 1;
    printf("  \"runs\": [");
    for (int k = 0; k < s->n_isa && !status; k++) {
        figures best[MAX_LIST] = {{0}};
        for (int i = 0; i < s->repeat && !status; i++)
            for (int t = 0; t < s->n_threads && !status; t++)
                status = measure_once(s, mesh, s->threads[t], s->isa[k], coordinates, &best[t]);
        for (int t = 0; t < s->n_threads && !status; t++) {
            print_figures(s, mesh, &best[t], s->threads[t], s->isa[k], first);
            first = 0;
        }
    }
    printf(" ]\n}\n");
    free(coordinates);
    return status;
}

static int parse_threads(settings *s, char *list) {
    s->n_threads = 0;
    for (char *word = strtok(list, ","); word && s->n_threads < MAX_LIST; word = strtok(NULL, ","))
        s->threads[s->n_threads++] = atoi(word);
    return s->n_threads > 0;
}

static int parse_isa(settings *s, char *list) {
    s->n_isa = 0;
    for (char *word = strtok(list, ","); word && s->n_isa < MAX_LIST; word = strtok(NULL, ",")) {
        int found = 0;
        for (int i = 0; i < (int)(sizeof isa_names / sizeof *isa_names); i++)
            if (!strcmp(word, isa_names[i])) {
                s->isa[s->n_isa++] = (planish_isa)i;
                found = 1;
            }
        if (!found)
            return 0;
    }
    return s->n_isa > 0;
}

static int parse(settings *s, int argc, char **argv) {
    *s = (settings){.repeat = 5,
                    .bind = 1,
                    .threads = {1},
                    .n_threads = 1,
                    .isa = {PLANISH_ISA_AUTO},
                    .n_isa = 1};
    for (int i = 1; i < argc; i++) {
        int last = i + 1 == argc;
        if (argv[i][0] != '-')
            s->path = argv[i];
        else if (!strcmp(argv[i], "--no-bind"))
            s->bind = 0;
        else if (last)
            return 0;
        else if (!strcmp(argv[i], "--target"))
            s->target = atof(argv[++i]);
        else if (!strcmp(argv[i], "--only-worse-than"))
            s->only_worse_than = atof(argv[++i]);
        else if (!strcmp(argv[i], "--max-sweeps"))
            s->max_sweeps = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--repeat"))
            s->repeat = atoi(argv[++i]);
        else if (!strcmp(argv[i], "--direction"))
            s->direction = strcmp(argv[++i], "newton") ? PLANISH_SEARCH_FLETCHER_REEVES
                                                       : PLANISH_SEARCH_NEWTON;
        else if (!strcmp(argv[i], "--threads") ? !parse_threads(s, argv[++i])
                 : !strcmp(argv[i], "--isa")   ? !parse_isa(s, argv[++i])
                                               : 1)
            return 0;
    }
    return s->path && s->repeat > 0;
}

int main(int argc, char **argv) {
    settings s;
    planish_error error;
    planish_file *file = NULL;
    if (!parse(&s, argc, argv)) {
        fprintf(stderr,
                "usage: bench_smooth MESH [--target RMS] [--only-worse-than RR] [--max-sweeps N] "
                "[--repeat N] "
                "[--threads 1,2,...] [--isa plain,vector,avx2,avx512] "
                "[--direction newton|fletcher-reeves] [--no-bind]\n");
        return 64;
    }
    double start = bench_seconds(CLOCK_MONOTONIC);
    if (planish_file_open(s.path, NULL, 0, &file, &error))
        return fail("read", &error);
    double read = bench_seconds(CLOCK_MONOTONIC) - start;
    planish_mesh mesh = planish_file_mesh(file);
    uint8_t *constraint = malloc((size_t)mesh.n_nodes + 1);
    int status = constraint ? planish_file_constraints(file, NULL, constraint, &error)
                            : PLANISH_ERROR_MEMORY;
    if (status) {
        planish_file_close(file);
        free(constraint);
        return fail("constraints", constraint ? &error : NULL);
    }
    mesh.constraint = constraint;
    printf("{ \"planish\": \"%s\", \"mesh\": \"%s\", \"nodes\": %lld, \"elements\": %lld, "
           "\"read_s\": %.6f, \"target\": %g, \"loaded_bytes\": %lld,\n",
           planish_version(), s.path, (long long)mesh.n_nodes, (long long)mesh.n_elements, read,
           s.target, (long long)load(&s));
    status = run_all(&s, &mesh);
    free(constraint);
    planish_file_close(file);
    return fflush(stdout) ? fail("cannot write the results", NULL) : status;
}
