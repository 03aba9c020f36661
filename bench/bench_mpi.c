/* bench_mpi: cost of messages between the first process and the last one: latency in seconds, bytes
 * per second, and the time of a sum over all processes. Prints a line of JSON.
 *
 *   mpirun -n 2 build/bench/bench_mpi
 */
#include <mpi.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

enum { REPEATS = 9, LARGE = 1 << 22, SUM = 71 /* integers of an exact sum */ };

static int rank, n_ranks;

/** Best time of one way, of count round trips with so many bytes. */
static double trip(char *message, int bytes, int count) {
    const int other = n_ranks - 1;
    double best = 1e300;
    for (int r = 0; r < REPEATS; r++) {
        MPI_Barrier(MPI_COMM_WORLD);
        const double begin = MPI_Wtime();
        for (int i = 0; i < count; i++) {
            if (rank == 0) {
                MPI_Send(message, bytes, MPI_BYTE, other, 0, MPI_COMM_WORLD);
                MPI_Recv(message, bytes, MPI_BYTE, other, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
            } else if (rank == other) {
                MPI_Recv(message, bytes, MPI_BYTE, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
                MPI_Send(message, bytes, MPI_BYTE, 0, 0, MPI_COMM_WORLD);
            }
        }
        const double seconds = (MPI_Wtime() - begin) / (2 * count);
        best = seconds < best ? seconds : best;
    }
    return best;
}

static double sum_time(int count) {
    int64_t values[SUM] = {0};
    double best = 1e300;
    for (int r = 0; r < REPEATS; r++) {
        MPI_Barrier(MPI_COMM_WORLD);
        const double begin = MPI_Wtime();
        for (int i = 0; i < count; i++)
            MPI_Allreduce(MPI_IN_PLACE, values, SUM, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
        const double seconds = (MPI_Wtime() - begin) / count;
        best = seconds < best ? seconds : best;
    }
    return best;
}

int main(int argc, char **argv) {
    MPI_Init(&argc, &argv);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &n_ranks);
    if (n_ranks < 2) {
        fprintf(stderr, "bench_mpi: needs 2 processes at least (mpirun -n 2)\n");
        MPI_Abort(MPI_COMM_WORLD, 64);
    }
    char *message = calloc(LARGE, 1);
    if (!message)
        MPI_Abort(MPI_COMM_WORLD, 1);
    const double latency = trip(message, 8, 10000), large = trip(message, LARGE, 50);
    const double sum = sum_time(10000);
    if (rank == 0)
        printf("{\"processes\": %d, \"latency\": %.3g, \"bandwidth\": %.4g, \"sum\": %.3g}\n",
               n_ranks, latency, LARGE / (large - latency), sum);
    free(message);
    return MPI_Finalize();
}
