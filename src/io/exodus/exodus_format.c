/* exodus_format: what the reader and the writer of Exodus files both know. */
#include "io/exodus/exodus_format.h"

#include <stdio.h>
#include <string.h>

exodus_name exodus_name_of(const char *kind, int64_t k) {
    exodus_name name;
    snprintf(name.text, sizeof name.text, "%.16s%lld", kind, (long long)k + 1);
    return name;
}

exodus_name exodus_values_name(int of_elements, int64_t k, int64_t block) {
    exodus_name name = exodus_name_of(of_elements ? "vals_elem_var" : "vals_nod_var", k);
    const size_t used = strlen(name.text);
    if (of_elements)
        snprintf(name.text + used, sizeof name.text - used, "eb%d", (int)block + 1);
    return name;
}

/** Types whose nodes stand in another order than VTK's: the mids of upright edges come before those
 *  of the top, the centre of a hexahedron before those of its faces: bottom, top, left, right, front,
 *  back. */
const io_node_order exodus_node_orders[] = {
    {PLANISH_CELL_WEDGE15, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11}},
    {PLANISH_CELL_WEDGE18, {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 15, 16, 17}},
    {PLANISH_CELL_HEXAHEDRON20,
     {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15}},
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 16, 17,
                                 18, 19, 12, 13, 14, 15, 23, 24, 25, 26, 21, 22, 20}},
    {0, {0}},
};

const int8_t exodus_side_faces[9][6] = {[4] = {1, 2, 3, 0, -1, -1},
                                        [5] = {1, 2, 3, 4, 0, -1},
                                        [6] = {2, 3, 4, 0, 1, -1},
                                        [8] = {2, 3, 4, 5, 0, 1}};
