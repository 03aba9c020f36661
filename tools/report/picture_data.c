/* picture_data: a picture as JSON for the viewer (viewer/data.js). All numbers of arrays are little-endian,
 * in base64. */
#include "report/bytes.h"
#include "report/picture_state.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static void put_array(pl_markup *page, const char *name, const void *bytes, int64_t n) {
    pl_markup_put(page, ",\n\"%s\":\"", name);
    pl_markup_put_base64(page, bytes, n);
    pl_markup_put(page, "\"");
}

/** Put n numbers of points, in 16 bits if that is enough. */
static void put_points(pl_markup *page, const char *name, const pl_drawn_surface *surface,
                       const int32_t *point, int64_t n) {
    const int size = surface->n_points <= 65536 ? 2 : 4;
    uint8_t *bytes = malloc((size_t)(n * size) + 1);
    if (!bytes) {
        page->failed = 1;
        return;
    }
    for (int64_t i = 0; i < n; i++)
        pl_bytes_put((uint32_t)point[i], size, bytes + i * size);
    put_array(page, name, bytes, n * size);
    free(bytes);
}

/** Corners of the triangles, and features. */
static void put_triangles(pl_markup *page, const pl_picture *picture) {
    const pl_drawn_surface *surface = &picture->surface;
    pl_markup_put(page, ",\n\"index_bits\":%d", surface->n_points <= 65536 ? 16 : 32);
    put_points(page, "triangles", surface, surface->triangle, 3 * surface->n_triangles);
    if (surface->sides)
        put_array(page, "sides", surface->sides, surface->n_triangles);
    if (!picture->has_features)
        return;
    put_points(page, "features", surface, picture->edge, 2 * picture->n_edges);
    put_points(page, "corners", surface, picture->corner, picture->n_corners);
}

static void put_reals(pl_markup *page, const char *name, const double *value, int n) {
    pl_markup_put(page, ",\"%s\":[", name);
    for (int i = 0; i < n; i++)
        pl_markup_put(page, isfinite(value[i]) ? "%s%.17g" : "%snull", i ? "," : "", value[i]);
    pl_markup_put(page, "]");
}

/** Put the measures by which elements are coloured. */
static void put_measures(pl_markup *page, const pl_picture *picture) {
    pl_markup_put(page, ",\n\"codes\":%d,\"measures\":[", PL_DRAWN_CODES);
    for (int m = 0; m < picture->n_measures; m++) {
        const pl_drawn_measure *of = picture->measure[m];
        pl_markup_put(
            page, "%s{\"key\":\"%s\",\"name\":\"%s\",\"unit\":\"%s\",\"more_is_better\":%s",
            m ? ",\n" : "", of->key, of->name, of->unit, of->more_is_better ? "true" : "false");
        put_reals(page, "edges", of->edge, of->n_bins + 1);
        put_reals(page, "limits", of->limit, PL_DRAWN_CLASSES - 1);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]");
}

/** Put the elements inside, which states have in common. */
static void put_inside(pl_markup *page, const pl_picture *picture) {
    const pl_drawn_inside *inside = &picture->inside;
    const int size = inside->n_points <= 65536 ? 2 : 4;
    uint8_t *bytes = malloc((size_t)(inside->n_corners * size) + 1);
    if (!bytes) {
        page->failed = 1;
        return;
    }
    for (int64_t i = 0; i < inside->n_corners; i++)
        pl_bytes_put((uint32_t)inside->corner[i], size, bytes + i * size);
    pl_markup_put(page, ",\n\"stride\":%" PRId64 ",\"inside_bits\":%d", inside->stride, 8 * size);
    put_array(page, "inside_corners", bytes, inside->n_corners * size);
    if (picture->has_types)
        put_array(page, "inside_sizes", inside->size, inside->n);
    if (inside->stride > 1)
        pl_markup_put(page, ",\n\"grid\":{\"n\":[%d,%d,%d],\"size\":%.17g}", picture->grid.n[0],
                      picture->grid.n[1], picture->grid.n[2], picture->grid.size);
    free(bytes);
}

/** Put what a state draws of the elements inside. */
static void put_state_inside(pl_markup *page, const pl_picture *picture, const pl_drawn_state *s) {
    put_array(page, "inside", s->inside, 6 * picture->inside.n_points);
    put_array(page, "inside_codes", s->inside_code, picture->n_measures * picture->inside.n);
    if (s->cube)
        put_array(page, "cubes", s->cube, picture->n_measures * picture->grid.n_cells);
}

void pl_picture_put(pl_markup *page, const pl_picture *picture) {
    const double *low = picture->low, *high = picture->high;
    const int64_t dim = picture->dim, size = 2 * picture->surface.n_points * dim;
    const int solid = dim == 3;
    pl_markup_put(page, "{\"dim\":%d,\"low\":[%.17g,%.17g,%.17g],\"high\":[%.17g,%.17g,%.17g]",
                  picture->dim, low[0], low[1], solid ? low[2] : 0, high[0], high[1],
                  solid ? high[2] : 0);
    pl_markup_put(page, ",\"elements\":%" PRId64 ",\"coarse\":%s", picture->n_elements,
                  picture->surface.n_triangles < picture->surface.n_all ? "true" : "false");
    if (picture->is_surface)
        pl_markup_put(page, ",\"flat\":true");
    if (picture->has_plane) { /* which takes places of the file to those of the picture */
        const double *u = picture->plane.direction[0], *v = picture->plane.direction[1];
        const double *o = picture->plane.origin;
        pl_markup_put(page, ",\"origin\":[%.17g,%.17g,%.17g]", o[0], o[1], o[2]);
        pl_markup_put(page, ",\"directions\":[[%.17g,%.17g,%.17g],[%.17g,%.17g,%.17g]]", u[0], u[1],
                      u[2], v[0], v[1], v[2]);
    }
    put_measures(page, picture);
    put_triangles(page, picture);
    if (picture->is_solid)
        put_inside(page, picture);
    pl_markup_put(page, ",\n\"start\":%.17g,\"states\":[", pl_picture_start(picture));
    for (int i = 0; i < picture->n_states; i++) {
        const pl_drawn_state *s = &picture->states[i];
        pl_markup_put(page, "%s{\"name\":\"%s\",\"inverted\":%" PRId64, i ? ",\n" : "", s->name,
                      s->n_inverted);
        /* Surfaces before and after are most often the same. */
        if (i == 0 || memcmp(s->point, picture->states[0].point, (size_t)size) != 0)
            put_array(page, "points", s->point, size);
        if (s->code)
            put_array(page, "codes", s->code, picture->n_measures * picture->surface.n_triangles);
        put_array(page, "corners", s->corner, 4 * s->n_corners * dim);
        if (picture->has_types || picture->is_surface)
            put_array(page, "sizes", s->size, s->n_bad);
        put_array(page, "bad_ratios", s->bad_ratio, 4 * s->n_bad);
        put_array(page, "bad_codes", s->bad_code, picture->n_measures * s->n_bad);
        if (picture->is_solid)
            put_state_inside(page, picture, s);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]}");
}
