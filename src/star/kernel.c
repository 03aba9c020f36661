/* kernel: which variant of the star kernel runs on this CPU, the scratch they need, and the places
 * that a node may have. */
#define PL_PACK 1
#include "star/kernel_local.h"

int64_t pl_star_scratch_size(int dim, int64_t max_ring, int64_t max_link, int64_t max_more) {
    const int64_t padded = padded_to_lanes(max_link + max_more);
    const int64_t padded_edges = padded_to_lanes(pl_link_edges(dim, max_link));
    const int64_t rows = (padded + SPARE_ROWS) * ROW_LENGTH, ring = (max_ring + 1) * PL_ROW;
    const int64_t doubles =
        more_doubles(max_more) + column_doubles(padded) + padded_edges * EDGE_DOUBLES +
        position_doubles(padded, padded_edges, dim) + (rows > ring ? rows : ring);
    return (doubles * (int64_t)sizeof(double) + 63) / 64 * 64;
}

int pl_star_admit(const pl_star_problem *problem, int32_t node, int dim, double *x) {
    bounds b = {.any = 0};
    if (problem->guard)
        bounds_init(&b, problem, node, 1, dim);
    clamp(&b, x, dim);
    for (int d = 0; d < dim; d++)
        x[d] = pl_store(&problem->storage, x[d]);
    return within_bounds(&b, x, dim); /* rounding may have left them */
}

const pl_star_kernel *pl_star_kernel_select(planish_isa isa) {
    const pl_star_kernel *kernel = NULL;
    switch (isa) {
    case PLANISH_ISA_AUTO:
        kernel = pl_star_kernel_select(PLANISH_ISA_AVX512);
        kernel = kernel ? kernel : pl_star_kernel_select(PLANISH_ISA_AVX2);
        return kernel ? kernel : &pl_star_kernel_vector;
    case PLANISH_ISA_PLAIN:
        return &pl_star_kernel_plain;
    case PLANISH_ISA_VECTOR:
        return &pl_star_kernel_vector;
#ifdef PL_X86_KERNELS
    case PLANISH_ISA_AVX2:
        if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") &&
            __builtin_cpu_supports("fma"))
            kernel = &pl_star_kernel_avx2;
        return kernel;
    case PLANISH_ISA_AVX512:
        if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
            __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
            __builtin_cpu_supports("avx512cd"))
            kernel = &pl_star_kernel_avx512;
        return kernel;
#endif
    default:
        return NULL;
    }
}
