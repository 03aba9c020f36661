/* kernel_avx512: the star kernel as vectors of four doubles and 32 registers, compiled for
 * x86-64-v4. */
#define PL_PACK    4
#define PL_ISA     avx512
#define PL_GUARDED 0
#include "star/kernel_entry.h"
