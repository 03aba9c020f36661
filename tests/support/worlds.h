/* worlds: a small mesh and options for each thing that planish.h can be asked for. */
#ifndef TEST_SUPPORT_WORLDS_H
#define TEST_SUPPORT_WORLDS_H

#include "support/meshes.h"

enum { WORLD_MOST_OWNED = 8 };

typedef struct test_world {
    const char *name;
    test_mesh box;
    planish_mesh mesh; /* of the box, or of arrays of its own */
    planish_options options;
    int has_allocator; /* the test is to give options one */
    int64_t n_doubles; /* of the coordinates */
    void *owned[WORLD_MOST_OWNED];
    int n_owned;
} test_world;

/** How many there are. */
int test_world_count(void);

/** World number of them, of triangles or tetrahedra. */
void test_world_create(test_world *w, int dim, int number);
void test_world_destroy(test_world *w);

#endif
