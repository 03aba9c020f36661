/* kernel: which variant of the star kernel runs on this CPU, and the scratch they need. */
#define PL_PACK 1
#include "star/kernel_gather.h"

int64_t pl_star_scratch_size(int dim, int64_t max_ring, int64_t max_link) {
    int64_t bytes = scratch_doubles(dim, max_ring, max_link) * (int64_t)sizeof(double);
    return (bytes + 63) / 64 * 64;
}

static int cpu_has(planish_isa isa) {
    switch (isa) {
    case PLANISH_ISA_PLAIN:
    case PLANISH_ISA_VECTOR:
        return 1;
#ifdef PL_X86_KERNELS
    case PLANISH_ISA_AVX2:
        return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("bmi2") &&
               __builtin_cpu_supports("fma");
    case PLANISH_ISA_AVX512:
        return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
               __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
               __builtin_cpu_supports("avx512cd");
#endif
    default:
        return 0;
    }
}

static planish_isa fastest(void) {
    if (cpu_has(PLANISH_ISA_AVX512))
        return PLANISH_ISA_AVX512;
    return cpu_has(PLANISH_ISA_AVX2) ? PLANISH_ISA_AVX2 : PLANISH_ISA_VECTOR;
}

const pl_star_kernel *pl_star_kernel_select(planish_isa isa) {
    if (isa == PLANISH_ISA_AUTO)
        isa = fastest();
    if (!cpu_has(isa))
        return NULL;
    switch (isa) {
#ifdef PL_X86_KERNELS
    case PLANISH_ISA_AVX2:
        return &pl_star_kernel_avx2;
    case PLANISH_ISA_AVX512:
        return &pl_star_kernel_avx512;
#endif
    case PLANISH_ISA_VECTOR:
        return &pl_star_kernel_vector;
    default:
        return &pl_star_kernel_plain;
    }
}
