/* picture_still: a state of a picture as a still one, for pages without WebGL. */
#include "report/bytes.h"
#include "report/picture.h"
#include "report/picture_start.h"
#include "report/still.h"

#include <math.h>
#include <string.h>

/** Draw the surface: of flat elements in the colours of their ratios, without inverted ones if elements wrap. */
static void draw_surface(const pl_picture *picture, const pl_drawn_state *s, const double *extent,
                         int wraps, pl_still *still) {
    const int dim = picture->dim;
    for (int64_t i = 0; i < picture->surface.n_triangles; i++) {
        double place[3][3] = {{0}};
        if (wraps && s->code && s->code[i] == 0)
            continue;
        for (int k = 0; k < 3 * dim; k++) {
            const int64_t point = picture->surface.triangle[3 * i + k / dim];
            const uint32_t at = pl_bytes_get(s->point + 2 * (point * dim + k % dim), 2);
            place[k / dim][k % dim] = ((double)at / PL_PICTURE_PLACES - 0.5) * extent[k % dim];
        }
        pl_still_draw(still, place, s->code ? pl_drawn_class(picture->measure[0], s->code[i]) : -1);
    }
}

/** Draw a bad element: all triangles between its corners cover it; or a dot in its middle alone. */
static void draw_element(int dim, const uint8_t *corner, int n, int colour, int is_dot,
                         pl_still *still) {
    double at[8][3] = {{0}}, middle[3] = {0};
    for (int k = 0; k < n; k++)
        for (int d = 0; d < dim; d++) {
            at[k][d] = pl_bytes_get_float(corner + 4 * (k * dim + d));
            middle[d] += at[k][d] / n;
        }
    for (int a = 0; a < n && !is_dot; a++)
        for (int b = a + 1; b < n; b++)
            for (int c = b + 1; c < n; c++) {
                double place[3][3];
                memcpy(place[0], at[a], sizeof at[a]);
                memcpy(place[1], at[b], sizeof at[b]);
                memcpy(place[2], at[c], sizeof at[c]);
                pl_still_draw(still, (const double(*)[3])place, colour);
            }
    pl_still_dot(still, middle, colour);
}

/** Draw the elements that the viewer shows at first; of flat meshes inverted ones, as dots where elements wrap
 *  around the whole mesh. */
static void draw_bad(const pl_picture *picture, const pl_drawn_state *s, int wraps,
                     pl_still *still) {
    const double worse_than = picture->is_solid ? pl_picture_start(picture) : INFINITY;
    const uint8_t *corner = s->corner;
    for (int64_t i = 0; i < s->n_bad; corner += 4 * picture->dim * s->size[i++]) {
        const double ratio = pl_bytes_get_float(s->bad_ratio + 4 * i);
        if (!(ratio > 0) || ratio > worse_than)
            draw_element(picture->dim, corner, s->size[i],
                         pl_drawn_class(picture->measure[0], s->bad_code[i]),
                         wraps && !picture->is_solid, still);
    }
}

void pl_picture_put_still(pl_markup *page, const pl_picture *picture, int i, int wraps,
                          const char *title) {
    const pl_drawn_state *s = &picture->states[i];
    double extent[3] = {0};
    for (int d = 0; d < picture->dim; d++)
        extent[d] = (picture->high[d] - picture->low[d]) / picture->size;
    pl_still *still = pl_still_begin(extent);
    if (!still) {
        page->failed = 1;
        return;
    }
    draw_surface(picture, s, extent, wraps, still);
    pl_still_cover(still);
    draw_bad(picture, s, wraps, still);
    pl_still_put(page, still, title);
    pl_still_free(still);
}
