/* unit_orders: nodes of elements counted from 1, as unit_element has them, in orders that several formats
 * share: CGNS, Exodus, MED. Solids of second order have their mids in different orders.
 */
#ifndef TEST_SUPPORT_UNIT_ORDERS_H
#define TEST_SUPPORT_UNIT_ORDERS_H

#define TRIANGLE      "1 2 3"
#define TRIANGLE6     TRIANGLE " 12 23 31"
#define QUADRILATERAL "1 2 3 4"
#define EDGES4        " 12 23 34 41"
#define TETRAHEDRON   "1 2 3 4"
#define TETRAHEDRON10 TETRAHEDRON " 12 23 31 14 24 34"
#define PYRAMID       "1 2 3 4 5"
#define PYRAMID13     PYRAMID EDGES4 " 15 25 35 45"
#define WEDGE         "1 2 3 4 5 6"
#define HEXAHEDRON    "1 2 3 4 5 6 7 8"

#endif
