/* facets: what the elements of a small mesh share, found by sorting: for tests, sharing nothing
 * with src/topology. */
#ifndef TEST_SUPPORT_FACETS_H
#define TEST_SUPPORT_FACETS_H

#include <planish/planish.h>

/** The facet of an element that has not one of its corners. */
typedef struct test_facet {
    int32_t node[3]; /* ascending; in 2-D the first is -1 */
    int64_t element;
    int corner;
    int is_odd; /* the order in which the element has its nodes is an odd one of ascending */
} test_facet;

/** Sorted: those that are one facet stand together. */
typedef struct test_facets {
    int64_t n;         /* n_elements (dim + 1) */
    test_facet *facet; /* owned */
} test_facets;

/** is_known [n_elements]: of these elements only; NULL: of all. Release with free(facets.facet). */
test_facets test_facets_of(const planish_mesh *mesh, const uint8_t *is_known);

/** How many from i on are the same facet. */
int64_t test_facet_count(const test_facets *facets, int64_t i);

/** neighbour [n_elements][dim + 1], -1 where not just two elements share a facet. */
void test_neighbours(const planish_mesh *mesh, int32_t *neighbour);

/** is_inside [n_nodes]: 1 for nodes all of whose facets have two elements, which are different
 *  ones, and that have any; of known elements [n_elements], or of all (NULL). */
void test_inside(const planish_mesh *mesh, const uint8_t *is_known, uint8_t *is_inside);

/** sign [n_elements]: +1 or -1, times the measure in the file's order, is positive in a valid mesh
 *  (docs/algorithm.md, and planish_plan_create), by the measures at coordinates [n_nodes][dim].
 *  What is not known gets +1. Returns how many of the elements are in components whose measures
 *  nearly cancel, where the sign is anybody's guess. */
int64_t test_orient(const planish_mesh *mesh, const double *coordinates, const uint8_t *is_known,
                    int8_t *sign);

#endif
