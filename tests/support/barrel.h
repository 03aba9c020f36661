/* barrel: a solid with a curved surface, of tetrahedra. */
#ifndef TEST_SUPPORT_BARREL_H
#define TEST_SUPPORT_BARREL_H

#include "support/meshes.h"

enum { BARREL_CELLS = 6 };

/** A barrel of tetrahedra on its shape: a box whose cross-section is made round. Its side is a patch,
 *  its rims are curves, and the nodes within its ends slide on planes. */
typedef struct barrel {
    test_mesh base;
    planish_mesh mesh;
    planish_shape *shape;
    planish_shape_info info;
    planish_slide_info slides;
    uint8_t *constraint;
    double *direction;
    planish_options options;
} barrel;

/** Make a barrel whose nodes inside are perturbed, and options with its shape and so many threads. */
void barrel_create(barrel *m, int threads);

void barrel_destroy(barrel *m);

#endif
