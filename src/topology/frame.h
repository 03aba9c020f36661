/* frame: the bounding box of a mesh, and lengths in units of it. For topology and shape.
 *
 * Lengths are scaled by a power of two so that the box's longest side is between 1/2 and 1:
 * differences between coordinates of the mesh neither overflow nor underflow, and no bit of a
 * result depends on the scale of the input.
 *
 *   pl_frame_create, pl_frame_is_plain     the frame
 *   pl_frame_difference                    a length in units of it
 */
#ifndef PL_TOPOLOGY_FRAME_H
#define PL_TOPOLOGY_FRAME_H

#include <planish/planish.h>

/** Bounding box and its scale. */
typedef struct pl_frame {
    double low[3];   /* [dim] the corner of the box with the smallest coordinates */
    double shrink;   /* 1, or a power of two that lets differences of huge coordinates be numbers */
    double scale[2]; /* powers of two: the second is 1 unless the product may be out of range */
} pl_frame;

/** Find the frame of the nodes, or of those that are marked in which [n_nodes] (NULL: all); their
 *  coordinates are finite. */
int pl_frame_create(const planish_mesh *mesh, const uint8_t *which, int threads, pl_frame *frame,
                    planish_error *error);

/** Whether frame is plain; *plain then is the same, which compilers see where it is used. Nearly
 *  all are plain, and that spares half of the multiplications. */
static inline int pl_frame_is_plain(const pl_frame *frame, pl_frame *plain) {
    *plain = *frame;
    plain->shrink = plain->scale[1] = 1;
    return frame->shrink == 1 && frame->scale[1] == 1;
}

/** Difference x - y in units of the frame. */
static inline double pl_frame_difference(const pl_frame *frame, double x, double y) {
    return (x * frame->shrink - y * frame->shrink) * frame->scale[0] * frame->scale[1];
}

#endif
