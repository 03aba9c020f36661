/* kernel_avx2: the star kernel as vectors of four doubles, compiled for x86-64-v3. */
#define PL_PACK    4
#define PL_ISA     avx2
#define PL_GUARDED 0
#include "star/kernel_entry.h"
