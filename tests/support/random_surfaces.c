/* random_surfaces: regions and curved surfaces of random calls. */
#include "support/random_surfaces.h"

#include "support/effort.h"
#include "support/sheets.h"

#include "shape/overlay.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { DIVISIONS = 4 };

/* Tolerances: as given, or 0 for the one by default. */
static const double TOLERANCES[] = {0, 0, 0.3, 0.02};

/* ---- what is drawn ------------------------------------------------------------------------------ */

void cells_bulge(double *x, int64_t n_nodes, int cubes, uint64_t *state) {
    const double size = cubes, far = 0.6 * random_unit(state), along = 0.6 * random_unit(state),
                 across = 0.4 * random_unit(state);
    for (int64_t i = 0; i < n_nodes; i++, x += 3) {
        const double u = x[0] / size, v = x[1] / size, w = x[2] / size;
        x[1] += size * far * w * (1 - w);
        x[2] += size * (across * v * (1 - v) + along * u * (1 - u));
    }
}

/** Two regions: elements on either side of the middle of the second direction. */
static void draw_regions(cells_call *c, const double *regular) {
    const cell_box *b = c->box;
    const int dim = b->mesh.dim;
    double middle = 0;
    for (int64_t i = 0; i < b->mesh.n_nodes; i++)
        middle = fmax(middle, regular[i * dim + 1] / 2);
    c->region = calloc((size_t)b->cells.n + 1, sizeof *c->region);
    if (!c->region)
        abort();
    for (int64_t i = 0; i < b->cells.n; i++) {
        const int64_t n = b->offset[i + 1] - b->offset[i];
        double sum = 0;
        for (int64_t k = b->offset[i]; k < b->offset[i + 1]; k++)
            sum += regular[(int64_t)b->node[k] * dim + 1] - middle;
        c->region[i] = sum > 1e-9 * (double)n;
    }
    c->surface.region = c->region;
    c->surface.slide_interfaces = c->level[CELLS_REGIONS] == 2;
}

void cells_draw_surface(cells_call *c, const double *regular) {
    planish_error error = {.text = ""};
    if (c->level[CELLS_REGIONS])
        draw_regions(c, regular);
    if (!c->level[CELLS_SURFACE])
        return;
    if (planish_shape_create(&c->box->mesh, &c->surface, 1, &c->shape, NULL, &error)) {
        fprintf(stderr, "%s\n", error.text);
        abort();
    }
    c->surface.shape = c->shape;
    c->options.shape = c->shape;
    c->options.surface_tolerance = TOLERANCES[c->level[CELLS_SURFACE]];
    c->options.surface_tolerance_unit = PLANISH_UNIT_EDGE;
    if (c->level[CELLS_SURFACE] == 3) {
        c->options.surface_tolerance_unit = PLANISH_UNIT_MESH;
        c->options.surface_tolerance *= c->level[CELLS_PLACE] == 2   ? 0x1p-60
                                        : c->level[CELLS_PLACE] == 3 ? 0x1p60
                                                                     : 1;
    }
}

void cells_find_slides(cells_call *c) {
    planish_error error = {.text = ""};
    if (planish_find_slides(&c->given, &c->surface, 1, c->constraint, c->direction, NULL, &error)) {
        fprintf(stderr, "%s\n", error.text);
        abort();
    }
}

/* ---- what must hold ----------------------------------------------------------------------------- */

/** The tolerance of a triangle, in the shape's units. */
static double tolerance_of(const cells_call *c, const planish_shape *s, int32_t facet) {
    const double given = c->options.surface_tolerance;
    if (given > 0 && c->options.surface_tolerance_unit == PLANISH_UNIT_MESH)
        return given * s->scale;
    return (given > 0 ? given : PLANISH_SURFACE_TOLERANCE) * pl_shape_edge(s, facet);
}

/** The places of the shape's nodes in a mesh at x, in the shape's units; free with free. */
static double (*own_places(const planish_shape *s, const double *x))[3] {
    double(*own)[3] = malloc((size_t)s->n_nodes * sizeof *own);
    if (!own)
        abort();
    for (int64_t i = 0; i < s->n_nodes; i++)
        for (int d = 0; d < 3; d++)
            own[i][d] = x[3 * (int64_t)s->node[i] + d] * s->scale;
    return own;
}

/** Whether no sample of the surface is beyond the tolerance, and what was measured there holds. */
static int is_within(const cells_call *c, const double *x, const planish_shape_distance *d,
                     double rounding) {
    const planish_shape *s = c->shape;
    double(*now)[3] = own_places(s, x);
    sheet_judge was = sheet_judge_create(s, (const double(*)[3])s->x);
    sheet_judge is = sheet_judge_create(s, (const double(*)[3])now);
    int holds = 1;
    for (int32_t f = 0; f < s->n_facets; f++) {
        const double off =
            sheet_judge_sample(&was, s->patch[f], (const double(*)[3])is.corner[f], DIVISIONS);
        holds &= off <= tolerance_of(c, s, f) * (1 + 1e-9) + rounding;
        holds &= off <= d->distance * s->scale * (1 + 1e-9) + rounding;
    }
    sheet_judge_destroy(&was);
    sheet_judge_destroy(&is);
    free(now);
    return holds;
}

/** Whether the tolerance is proved everywhere. */
static int is_proved(const cells_call *c, const planish_shape_distance *d, double slack,
                     double rounding) {
    const double given = c->options.surface_tolerance;
    if (given > 0 && c->options.surface_tolerance_unit == PLANISH_UNIT_MESH)
        return d->distance * c->shape->scale <= given * c->shape->scale * slack + rounding;
    return d->in_edges <=
           (given > 0 ? given : PLANISH_SURFACE_TOLERANCE) * slack + rounding / c->shape->size;
}

const char *cells_check_surface(const cells_call *c, const double *x) {
    const planish_shape *s = c->shape;
    const int is_straight = s->n_wholes == 0;
    planish_mesh mesh = c->box->mesh;
    planish_shape_distance d;
    planish_error error = {.text = ""};
    mesh.coordinates = x;
    if (planish_shape_measure(s, &mesh, 1, &d, &error))
        return "the surface cannot be measured";
    const double far = c->level[CELLS_PLACE] == 1 ? 1e5 * s->scale : s->size;
    const double rounding = c->options.precision ? 2e-7 * far : fmax(1e-12 * s->size, 1e-15 * far);
    if (d.n_unproved > 0)
        return "a facet has no bound";
    /* Of curved facets less may be proved of a whole run than of its steps: test_curved_mids.c. */
    if (!is_proved(c, &d, is_straight ? 1 + 1e-9 : 2, rounding))
        return "the surface is not proved to be within the tolerance";
    if (is_straight && !is_within(c, x, &d, rounding))
        return "a sample of the surface is beyond the tolerance, or what is proved";
    return NULL;
}
