/* frame: the bounding box of a mesh, and lengths in units of it; see the header. */
#include "topology/frame.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/parts.h"
#include "base/status.h"

#include <math.h>
#include <stdlib.h>

enum {
    CHUNK = 1024,        /* nodes that one thread looks at at a time */
    MOST_EXPONENT = 1000 /* of a power of two whose inverse is a number with room to spare */
};

/* Coordinates beyond it are made smaller before they are subtracted. */
#define HUGE_COORDINATE 0x1p1000
#define SHRINK          0x1p-64

typedef struct box {
    double low[3], high[3];
} box;

/** The search for the bounding box. */
typedef struct box_search {
    const planish_mesh *mesh;
    const uint8_t *which; /* [n_nodes], or NULL: all */
    box *boxes;           /* [chunks] */
} box_search;

static inline box box_of_nodes(int dim, const box_search *s, int64_t begin, int64_t end) {
    box b = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int64_t i = begin; i < end; i++)
        for (int d = 0; d < dim && (!s->which || s->which[i]); d++) {
            double x = s->mesh->coordinates[i * dim + d];
            b.low[d] = x < b.low[d] ? x : b.low[d];
            b.high[d] = x > b.high[d] ? x : b.high[d];
        }
    return b;
}

static void search_chunk(void *context, int64_t begin, int64_t end, int thread) {
    box_search *s = context;
    (void)thread;
    s->boxes[begin / CHUNK] =
        s->mesh->dim == 3 ? box_of_nodes(3, s, begin, end) : box_of_nodes(2, s, begin, end);
}

int pl_frame_create(const planish_mesh *mesh, const uint8_t *which, int threads, pl_frame *frame,
                    planish_error *error) {
    const int64_t chunks = (mesh->n_nodes - 1) / CHUNK + 1;
    box_search s = {mesh, which, pl_alloc(chunks, sizeof *s.boxes)};
    if (!s.boxes)
        return pl_fail_memory(error, "the bounding box");
    box whole = box_of_nodes(mesh->dim, &s, 0, 0);
    pl_parallel_for(threads, mesh->n_nodes, CHUNK, search_chunk, &s);
    for (int64_t i = 0; i < chunks && mesh->n_nodes > 0; i++)
        for (int d = 0; d < mesh->dim; d++) {
            const double low = s.boxes[i].low[d], high = s.boxes[i].high[d];
            whole.low[d] = low < whole.low[d] ? low : whole.low[d];
            whole.high[d] = high > whole.high[d] ? high : whole.high[d];
        }
    pl_free(s.boxes);
    pl_parts_smallest(whole.low, mesh->dim);
    pl_parts_largest(whole.high, mesh->dim);
    *frame = (pl_frame){.shrink = 1};
    double extent = 0;
    for (int d = 0; d < mesh->dim && whole.low[d] <= whole.high[d]; d++) /* there are nodes */
        if (fabs(whole.low[d]) > HUGE_COORDINATE || fabs(whole.high[d]) > HUGE_COORDINATE)
            frame->shrink = SHRINK;
    for (int d = 0; d < mesh->dim && whole.low[d] <= whole.high[d]; d++) {
        const double side = whole.high[d] * frame->shrink - whole.low[d] * frame->shrink;
        extent = side > extent ? side : extent;
        frame->low[d] = whole.low[d];
    }
    int exponent = 0;
    if (extent > 0)
        frexp(extent, &exponent);
    const int second = abs(exponent) > MOST_EXPONENT ? exponent / 2 : 0;
    frame->scale[0] = ldexp(1, second - exponent);
    frame->scale[1] = ldexp(1, -second);
    return pl_parts_check(error);
}
