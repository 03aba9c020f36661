/* part_numbers: edges and quadrilaterals by their vertices, numbered as they first occur. MFEM numbers
 * the nodes on edges and faces so, element after element.
 *
 *   io_part_numbers_find, _add, _release
 *   io_sort_vertices                        the vertices of one
 */
#ifndef PL_IO_CORE_PART_NUMBERS_H
#define PL_IO_CORE_PART_NUMBERS_H

#include <planish/planish.h>

#include "base/hash.h"

#include <stdint.h>

/** Distinct edges (of 2 vertices) or quadrilaterals (4), numbered as they first occur. */
typedef struct io_part_numbers {
    int width; /* vertices of each */
    int64_t n, capacity;
    int32_t *vertex; /* [n][width] owned, ascending */
    int32_t *slot;   /* [n_slots] owned hash table: index or -1 */
    int64_t n_slots; /* a power of two, or 0 */
    pl_hash hash;
} io_part_numbers;

/** Put n vertices into sorted, in ascending order. */
void io_sort_vertices(const int32_t *vertices, int n, int32_t *sorted);

/** Find the number of a part by its vertices, in any order; -1: there is none. */
int64_t io_part_numbers_find(const io_part_numbers *parts, const int32_t *vertices);

/** Find the number of a part, made if new. Error: _MEMORY. */
int io_part_numbers_add(io_part_numbers *parts, const int32_t *vertices, int32_t *number,
                        planish_error *error);

/** Release the table. */
void io_part_numbers_release(io_part_numbers *parts);

#endif
