/* halfspaces: whether half-spaces of the plane or of space have a point in common, decided by the
 * vertices of their intersection: slow, simple, and nothing that the library knows of. */
#ifndef TEST_SUPPORT_HALFSPACES_H
#define TEST_SUPPORT_HALFSPACES_H

enum { HALFSPACES_MAX = 40 };

/** {x : normal_i . x >= offset_i}; normals are of unit length. */
typedef struct halfspaces {
    int dim, n;
    long double normal[HALFSPACES_MAX][3], offset[HALFSPACES_MAX];
} halfspaces;

/** None but the box |x_i| <= size, so that whatever is added has vertices. */
void halfspaces_start(halfspaces *h, int dim, long double size);

/** Add {x : normal . x >= offset}; normal of any length but 0. */
void halfspaces_add(halfspaces *h, const long double *normal, long double offset);

/** Whether there is a point deeper than depth in all of them. point (may be NULL): one. */
int halfspaces_meet(const halfspaces *h, long double depth, long double *point);

#endif
