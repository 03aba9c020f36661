/* kernel_plain: the star kernel as scalar C, the reference for all the others. */
#define PL_PACK    1
#define PL_ISA     plain
#define PL_GUARDED 0
#include "star/kernel_entry.h"
