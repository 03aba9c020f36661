/* elements: elements of any type by the places of their nodes, for tests of readers.
 *
 * A list of nodes says each by the corners that it is in the middle of, numbered from 1, in the
 * order of the format: "1 2 3 12 23 31" is a triangle of second order. Corners stand where those of
 * the unit element do, numbered as all formats number them. All are mapped by a polynomial, so that
 * the element is curved, and valid in that order of nodes alone.
 */
#ifndef TEST_SUPPORT_ELEMENTS_H
#define TEST_SUPPORT_ELEMENTS_H

#include "support/reading.h"

enum { ELEMENTS_NODES = 27 };

/** Nodes of an element. */
typedef struct elements_places {
    int dim, n;
    double xyz[ELEMENTS_NODES][3];
} elements_places;

/** Find the places of the nodes of a list. dim: of the element. swapped: two nodes change places, so
 *  that an element of any type is wrong (of a pyramid: corners of the base). */
elements_places elements_find(int dim, const char *nodes, int swapped);

/** Check the one element of a file, which is closed: its type (planish_cell_type) and number, that
 *  nothing is smoothed, that its n_held nodes are held, and whether it is valid. */
void elements_check(planish_file *file, int type, int64_t number, int n_held, int is_valid);

#endif
