/* tree: which of many boxes meet a box, and which item is nearest to a point.
 *
 * Items lie along a space-filling curve through the middles of their boxes; PL_BRANCHES neighbours
 * make a branch, so many branches the next one, and so on.
 *
 *   tree.c   pl_tree_create, _destroy
 *            pl_tree_find                items by their boxes
 *            pl_tree_nearest             the nearest item, by the caller's distance
 */
#ifndef PL_SHAPE_TREE_H
#define PL_SHAPE_TREE_H

#include <planish/planish.h>

#include <stdint.h>

enum { PL_BRANCHES = 4, PL_TREE_LEVELS = 17 };

/** Box in space: lower x, y, z, then upper ones. */
typedef struct pl_box3 {
    double lower[3], upper[3];
} pl_box3;

typedef struct pl_tree {
    int64_t n;
    int32_t *item; /* [n] along the curve */
    pl_box3 *box;  /* of the items, in their order, then level by level up to the root */
    int n_levels;
    int64_t begin[PL_TREE_LEVELS + 1]; /* of each level in box; level 0: the items */
} pl_tree;

/** Make the tree of n boxes. Errors: _MEMORY. */
int pl_tree_create(int64_t n, const pl_box3 *box, int threads, pl_tree *tree, planish_error *error);

/** Free the arrays of tree. */
void pl_tree_destroy(pl_tree *tree);

/** An item is found; not 0 to end the search. */
typedef int pl_tree_found_fn(void *context, int32_t item);

/** Whether a search leaves out everything below a branch; index: of its box, from tree->begin[1] on. */
typedef int pl_tree_skips_fn(void *context, int64_t index);

/** Call found for the items whose boxes meet box, along the curve. skips: NULL: nothing is left out. */
void pl_tree_find(const pl_tree *tree, const pl_box3 *box, pl_tree_skips_fn *skips,
                  pl_tree_found_fn *found, void *context);

/** Squared distance of an item from a point. */
typedef double pl_tree_distance_fn(const void *context, int32_t item, const double point[3]);

/** Return the item nearest to point, of several the lowest one, and set *square to its squared
 *  distance; -1: no item is within *square. No item is nearer than its box. */
int32_t pl_tree_nearest(const pl_tree *tree, const double point[3], pl_tree_distance_fn *distance,
                        const void *context, double *square);

#endif
