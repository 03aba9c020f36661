/* picture_data: a picture as JSON for the viewer (viewer/data.js). All numbers of arrays are little-endian,
 * in base64. */
#include "report/bytes.h"
#include "report/picture.h"
#include "report/picture_start.h"

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

/** An array of a state, for the viewer. */
typedef struct array {
    const char *name;
    const uint8_t *bytes; /* NULL: the state has none */
    int64_t n;
} array;

enum { N_ARRAYS = 10 };

/** List the arrays of a state; points only where they are not those of first (may be NULL): surfaces are most
 *  often the same. */
static void list_arrays(const pl_picture *picture, const pl_drawn_state *s,
                        const pl_drawn_state *first, array list[N_ARRAYS]) {
    const int64_t dim = picture->dim, of_points = 2 * picture->surface.n_points * dim,
                  m = picture->n_measures;
    const int is_same = first && memcmp(s->point, first->point, (size_t)of_points) == 0;
    const int has_sizes = picture->has_types || picture->is_surface;
    const array all[N_ARRAYS] = {
        {"points", is_same ? NULL : s->point, of_points},
        {"codes", s->code, m * picture->surface.n_triangles},
        {"corners", s->corner, 4 * s->n_corners * dim},
        {"places", s->place, 2 * s->n_corners * dim},
        {"sizes", has_sizes ? s->size : NULL, s->n_bad},
        {"bad_ratios", s->bad_ratio, 4 * s->n_bad},
        {"bad_codes", s->bad_code, m * s->n_bad},
        {"inside", s->inside, 6 * picture->inside.n_points},
        {"inside_codes", s->inside_code, m * picture->inside.n},
        {"cubes", s->cube, m * picture->grid.n_cells},
    };
    memcpy(list, all, sizeof all);
}

/** Put the fields of a state, each behind a comma. */
static void put_state(pl_markup *page, const pl_picture *picture, const pl_drawn_state *s,
                      const pl_drawn_state *first) {
    array list[N_ARRAYS];
    list_arrays(picture, s, first, list);
    pl_markup_put(page, ",\"inverted\":%" PRId64, s->n_inverted);
    for (int i = 0; i < N_ARRAYS; i++)
        if (list[i].bytes)
            put_array(page, list[i].name, list[i].bytes, list[i].n);
}

/** Put the states, and the steps between them. */
static void put_states(pl_markup *page, const pl_picture *picture) {
    const pl_drawn_state *first = &picture->states[0];
    pl_markup_put(page, ",\n\"start\":%.17g,\"states\":[", pl_picture_start(picture));
    for (int i = 0; i < picture->n_states; i++) {
        pl_markup_put(page, "%s{\"name\":\"%s\"", i ? ",\n" : "", picture->states[i].name);
        put_state(page, picture, &picture->states[i], i ? first : NULL);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]");
    if (picture->n_steps == 0)
        return;
    pl_markup_put(page, ",\n\"sweeps\":%d,\"steps\":[", picture->n_sweeps);
    for (int i = 0; i < picture->n_steps; i++) {
        pl_markup_put(page, "%s{\"sweep\":%d", i ? ",\n" : "", picture->step[i].sweep);
        put_state(page, picture, &picture->step[i], first);
        pl_markup_put(page, "}");
    }
    pl_markup_put(page, "]");
}

static int64_t length_of(const pl_picture *picture, const pl_drawn_state *state,
                         const pl_drawn_state *first) {
    array list[N_ARRAYS];
    int64_t length = 0;
    list_arrays(picture, state, first, list);
    for (int i = 0; i < N_ARRAYS; i++)
        length += list[i].bytes ? list[i].n / 3 * 4 + 30 : 0;
    return length;
}

int64_t pl_picture_step_length(const pl_picture *picture, const pl_drawn_state *step) {
    return length_of(picture, step, &picture->states[0]);
}

int64_t pl_picture_length(const pl_picture *picture) {
    const int64_t n = 3 * picture->surface.n_triangles + 2 * picture->n_edges + picture->n_corners +
                      picture->inside.n_corners; /* numbers of points, of up to 4 bytes */
    int64_t length = n * 4 / 3 * 4;
    for (int i = 0; i < picture->n_states; i++)
        length += length_of(picture, &picture->states[i], i ? &picture->states[0] : NULL);
    return length;
}

void pl_picture_put(pl_markup *page, const pl_picture *picture) {
    const double *low = picture->low, *high = picture->high;
    const int solid = picture->dim == 3;
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
    put_states(page, picture);
    pl_markup_put(page, "}");
}
