/* frame: the bounding box of a mesh, and lengths in units of it; see the header. */
#include "topology/frame.h"

#include "base/parallel.h"
#include "base/parts.h"

#include <math.h>
#include <stdlib.h>

enum {
    CHUNK = 4096,        /* nodes that one thread looks at at a time */
    MOST_EXPONENT = 1000 /* of a power of two whose inverse is a number with room to spare */
};

/* Coordinates beyond it are made smaller before they are subtracted. */
#define HUGE_COORDINATE 0x1p1000
#define SHRINK          0x1p-64

/** The search for the bounding box. */
typedef struct box_search {
    const planish_mesh *mesh;
    const uint8_t *which; /* [n_nodes], or NULL: all */
    double most[2 * 3];   /* largest coordinates so far, then largest of their opposites */
} box_search;

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    box_search *s = context;
    const int dim = s->mesh->dim;
    (void)thread;
    for (int d = 0; d < dim; d++) {
        double low = INFINITY, high = -INFINITY;
        for (int64_t i = begin; i < end; i++) {
            const double x = s->mesh->coordinates[i * dim + d];
            if (s->which && !s->which[i])
                continue;
            low = x < low ? x : low;
            high = x > high ? x : high;
        }
        pl_raise_double(&s->most[d], high);
        pl_raise_double(&s->most[3 + d], -low);
    }
}

int pl_frame_create(const planish_mesh *mesh, const uint8_t *which, int threads, pl_frame *frame,
                    planish_error *error) {
    box_search s = {.mesh = mesh, .which = which};
    for (int i = 0; i < 2 * 3; i++)
        s.most[i] = -INFINITY;
    pl_parallel_for(threads, mesh->n_nodes, CHUNK, search_chunk, &s);
    pl_parts_largest(s.most, 2 * 3);
    *frame = (pl_frame){.shrink = 1};
    double extent = 0;
    for (int d = 0; d < mesh->dim && isfinite(s.most[d]); d++) /* there are nodes */
        if (s.most[d] > HUGE_COORDINATE || s.most[3 + d] > HUGE_COORDINATE)
            frame->shrink = SHRINK;
    for (int d = 0; d < mesh->dim && isfinite(s.most[d]); d++) {
        const double side = s.most[d] * frame->shrink + s.most[3 + d] * frame->shrink;
        extent = side > extent ? side : extent;
        frame->low[d] = -s.most[3 + d];
    }
    int exponent = 0;
    if (extent > 0)
        frexp(extent, &exponent);
    const int second = abs(exponent) > MOST_EXPONENT ? exponent / 2 : 0;
    frame->scale[0] = ldexp(1, second - exponent);
    frame->scale[1] = ldexp(1, -second);
    return pl_parts_check(error);
}
