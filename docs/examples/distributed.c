/* planish on a mesh that MPI processes share: plain arrays, and MPI.
 *
 *   mpicc distributed.c -lplanish -o distributed && mpirun -n 2 ./distributed 60
 *
 * The mesh is a cube of n^3 cells of 6 tetrahedra, with displaced inner nodes, cut into slabs. Each process
 * moves the nodes of some planes x = const, and has ghosts of one plane on either side. The program prints a
 * checksum of all coordinates. It is the same for any number of processes. */
#include <mpi.h>
#include <planish/planish.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int rank, n_ranks, n; /* n: cells in a row */
static int64_t plane, first, own,
    last;               /* nodes of a plane; numbers: the first one here, the first and */
static int64_t end;     /* the last of ours; behind the last one here */
static char *packet[2]; /* messages to rank - 1 and rank + 1: numbers and values */
static MPI_Request request[2];
static int n_requests;
static int64_t value_size;

static int add(int64_t *values, int count, void *user) {
    (void)user;
    return MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
}

static int largest(int64_t *values, int count, void *user) {
    (void)user;
    return MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_INT64_T, MPI_MAX, MPI_COMM_WORLD);
}

/** Send the values of our nodes: those of the first plane are ghosts of rank - 1, those of the last plane of
 *  rank + 1. */
static int send_values(const int32_t *node, int64_t count, const void *values, int64_t size,
                       void *user) {
    (void)user;
    n_requests = 0;
    value_size = size;
    for (int side = 0; side < 2; side++) {
        const int to = rank - 1 + 2 * side;
        char *next = packet[side] = malloc((size_t)(plane * (8 + size)));
        for (int64_t i = 0; i < count; i++) {
            const int64_t number = first + node[i];
            if (side == 0 ? number >= own + plane : number < last + 1 - plane)
                continue;
            memcpy(next, &number, 8);
            memcpy(next + 8, (const char *)values + i * size, (size_t)size);
            next += 8 + size;
        }
        if (to >= 0 && to < n_ranks)
            MPI_Isend(packet[side], (int)(next - packet[side]), MPI_BYTE, to, 0, MPI_COMM_WORLD,
                      &request[n_requests++]);
    }
    return 0;
}

static int receive_values(planish_take_fn *take, void *taker, void *user) {
    (void)user;
    const int64_t entry = 8 + value_size;
    char *message = malloc((size_t)(plane * entry));
    for (int from = rank - 1; from <= rank + 1; from += 2) {
        MPI_Status status;
        int bytes = 0;
        if (from < 0 || from >= n_ranks)
            continue;
        MPI_Recv(message, (int)(plane * entry), MPI_BYTE, from, 0, MPI_COMM_WORLD, &status);
        MPI_Get_count(&status, MPI_BYTE, &bytes);
        for (char *next = message; next < message + bytes; next += entry) {
            int64_t number;
            memcpy(&number, next, 8);
            take((int32_t)(number - first), next + 8, taker);
        }
    }
    MPI_Waitall(n_requests, request, MPI_STATUSES_IGNORE);
    free(message);
    free(packet[0]);
    free(packet[1]);
    return 0;
}

/** Place of a node, off its lattice inside by what its number says. */
static void place(int64_t number, double *x) {
    const int64_t at[3] = {number / plane, number / (n + 1) % (n + 1), number % (n + 1)};
    uint64_t bits = (uint64_t)number * UINT64_C(0x9e3779b97f4a7c15);
    for (int d = 0; d < 3; d++, bits = bits << 21 | bits >> 43) {
        int inside = 1;
        for (int k = 0; k < 3; k++)
            inside &= at[k] > 0 && at[k] < n;
        x[d] = (double)at[d] + inside * ((double)(bits >> 43) * 0x1p-21 - 0.5) * 0.28;
    }
}

/** The 6 tetrahedra of a cell, along its diagonal: each goes to the far corner by another order of axes. */
static void cut(int64_t cell, int32_t *elements) {
    static const int axis[6][3] = {{0, 1, 2}, {1, 0, 2}, {1, 2, 0},
                                   {2, 1, 0}, {2, 0, 1}, {0, 2, 1}};
    const int64_t step[3] = {plane, n + 1, 1};
    const int64_t corner = cell / n / n * step[0] + cell / n % n * step[1] + cell % n * step[2];
    for (int t = 0; t < 6; t++, elements += 4) {
        int64_t node = corner - first;
        for (int k = 0; k < 4; node += k < 3 ? step[axis[t][k]] : 0, k++)
            elements[t % 2 && k > 1 ? 5 - k : k] = (int32_t)node;
    }
}

int main(int argc, char **argv) {
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
    n = argc > 1 ? atoi(argv[1]) : 20;
    plane = (int64_t)(n + 1) * (n + 1);
    const int64_t low = (int64_t)rank * (n + 1) / n_ranks,
                  high = (int64_t)(rank + 1) * (n + 1) / n_ranks;
    const int64_t from = low > 0 ? low - 1 : 0, to = high < n + 1 ? high + 1 : n + 1;
    if (n < 1 || n + 1 < n_ranks)
        MPI_Abort(MPI_COMM_WORLD, 64); /* every process has a plane here */
    first = from * plane, own = low * plane, last = high * plane - 1, end = to * plane;
    const int64_t n_nodes = end - first, n_cells = (to - 1 - from) * n * n;
    double *x = malloc((size_t)n_nodes * 3 * sizeof *x);
    int32_t *elements = malloc((size_t)n_cells * 24 * sizeof *elements);
    int64_t *number = malloc((size_t)n_nodes * sizeof *number);
    uint8_t *role = malloc((size_t)n_nodes), *is_counted = malloc((size_t)n_cells * 6);
    for (int64_t i = 0; i < n_nodes; i++) {
        const int64_t at = (first + i) / plane; /* its plane */
        const int seen = (at == low && low > 0) || (at == high - 1 && high < n + 1);
        number[i] = first + i;
        role[i] = (uint8_t)(at < low || at >= high ? PLANISH_ROLE_GHOST
                            : seen                 ? PLANISH_ROLE_SHARED
                                                   : PLANISH_ROLE_OWN);
        place(number[i], x + 3 * i);
    }
    for (int64_t i = 0; i < n_cells; i++) {
        cut(from * n * n + i, elements + 24 * i);
        memset(is_counted + 6 * i, from + i / n / n >= low, 6); /* by who owns the lower plane */
    }
    const planish_part part = {.node_number = number,
                               .node_role = role,
                               .is_counted = is_counted,
                               .add = add,
                               .largest = largest,
                               .send = send_values,
                               .receive = receive_values};
    const planish_mesh mesh = {.dim = 3,
                               .n_nodes = n_nodes,
                               .n_elements = n_cells * 6,
                               .coordinates = x,
                               .elements = elements,
                               .part = &part};
    planish_options options;
    planish_options_init(&options);
    options.threads = 1;
    planish_plan *plan;
    planish_result result;
    planish_error error;
    const double start = MPI_Wtime();
    if (planish_plan_create(&mesh, &options, &plan, &error) ||
        planish_smooth(plan, x, &options, &result, &error)) {
        fprintf(stderr, "process %d: %s\n", rank, error.text);
        MPI_Abort(MPI_COMM_WORLD, 1); /* the others would wait for this one */
    }
    int64_t sum = 0; /* of hashes: in any order */
    for (int64_t i = 0; i < 3 * n_nodes; i++) {
        uint64_t bits;
        memcpy(&bits, x + i, 8);
        if (role[i / 3] != PLANISH_ROLE_GHOST)
            sum +=
                (int64_t)((bits ^ (uint64_t)(3 * first + i)) * UINT64_C(0x9e3779b97f4a7c15) >> 8);
    }
    add(&sum, 1, NULL);
    if (rank == 0)
        printf("%d processes: RMS %.15g after %d sweeps, %.3f s; checksum %016" PRIx64 "\n",
               n_ranks, result.rms, result.sweeps, MPI_Wtime() - start, (uint64_t)sum);
    planish_plan_destroy(plan);
    free(x), free(elements), free(number), free(role), free(is_counted);
    return MPI_Finalize();
}
