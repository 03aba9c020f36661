/* kernel_vector: the star kernel as vectors of two doubles, which every 64-bit instruction set has.
 */
#define PL_PACK    2
#define PL_ISA     vector
#define PL_GUARDED 0
#include "star/kernel_entry.h"
