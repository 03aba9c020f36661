#include "support/bent_elements.h"

#include <planish/planish.h>

#define TRIANGLE  "000 400 040 "
#define SQUARE    "000 400 440 040 "
#define TETRA     "000 400 040 004 "
#define CUBE      "000 400 440 040 004 404 444 044 "
#define WEDGE     "000 400 040 004 404 044 "
#define PYRAMID   "000 400 440 040 004 "
#define CUBE20    CUBE "200 420 240 020 204 424 244 024 002 402 442 042 "
#define WEDGE15   WEDGE "200 220 020 204 224 024 002 402 042 "
#define PYRAMID13 PYRAMID "200 420 240 020 002 202 222 022 "

const bent_element bent_elements[N_BENT_ELEMENTS] = {
    {PLANISH_CELL_QUADRILATERAL, 2, 4, 4, SQUARE},
    {PLANISH_CELL_HEXAHEDRON, 3, 8, 8, CUBE},
    {PLANISH_CELL_WEDGE, 3, 6, 6, WEDGE},
    {PLANISH_CELL_PYRAMID, 3, 5, 5, PYRAMID},
    {PLANISH_CELL_TRIANGLE6, 2, 6, 3, TRIANGLE "200 220 020 "},
    {PLANISH_CELL_QUADRILATERAL8, 2, 8, 4, SQUARE "200 420 240 020 "},
    {PLANISH_CELL_TETRAHEDRON10, 3, 10, 4, TETRA "200 220 020 002 202 022 "},
    {PLANISH_CELL_HEXAHEDRON20, 3, 20, 8, CUBE20},
    {PLANISH_CELL_WEDGE15, 3, 15, 6, WEDGE15},
    {PLANISH_CELL_PYRAMID13, 3, 13, 5, PYRAMID13},
    {PLANISH_CELL_QUADRILATERAL9, 2, 9, 4, SQUARE "200 420 240 020 220 "},
    {PLANISH_CELL_HEXAHEDRON27, 3, 27, 8, CUBE20 "022 422 202 242 220 224 222 "},
    {PLANISH_CELL_WEDGE18, 3, 18, 6, WEDGE15 "202 222 022 "},
};

void bent_element_place(const bent_element *element, int i, double place[3]) {
    const double bend = 0.1;
    double x[3];
    for (int d = 0; d < 3; d++)
        x[d] = (element->places[4 * i + d] - '0') / 4.0;
    place[0] = x[0] + bend * (x[1] * x[1] + x[0] * x[2]);
    place[1] = x[1] + bend * (x[2] * x[2] + x[0] * x[1]);
    place[2] = element->dim == 2 ? 0 : x[2] + bend * (x[0] * x[0] + x[1] * x[2]);
}
