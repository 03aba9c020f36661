/* still: a still picture of triangles, as SVG. */
#include "report/still.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Pixels. */
enum { WIDTH = 300, HEIGHT = 225, N_PIXELS = WIDTH * HEIGHT };
enum { NO_COLOUR = 255, N_COLOURS = PL_STILL_CLASSES + 1 + PL_STILL_SHADES };

/* Those of viewer/data.js, and of a surface in the light of the camera. */
static const char *const colours[N_COLOURS] = {
    "#e6eef6", "#bcd5ea", "#86b6da", "#fde6a9", "#fdbb63", "#f5853f", "#dd3d2d", "#8f0d1d",
    "#d600c8", "#5f6b75", "#717e89", "#83919d", "#95a4b0", "#a7b6c3", "#b8c7d4"};

struct pl_still {
    int is_flat;       /* seen from above */
    double scale;      /* pixels per unit of the picture's plane */
    double eye[3];     /* place of the camera, */
    double axis[3][3]; /* and its directions: right, up, forwards */
    uint8_t *colour;   /* [N_PIXELS] row by row from the top */
    float *depth;      /* [N_PIXELS] */
};

/* As in viewer/camera.js; MARGIN: of the view that a mesh fills. */
static const double MARGIN = 0.94;
static const double HALF_FIELD_OF_VIEW = 17.5 / 57.295779513082320877;

static void turn_camera(pl_still *still, const double extent[3]) {
    const double direction[3] = {0.45, -0.75, 0.48}; /* towards the camera */
    const double half = MARGIN * tan(HALF_FIELD_OF_VIEW), breadth = (double)WIDTH / HEIGHT;
    double square = 0, distance = 0;
    double(*axis)[3] = still->axis;
    for (int d = 0; d < 3; d++)
        square += direction[d] * direction[d];
    for (int d = 0; d < 3; d++)
        axis[2][d] = -direction[d] / sqrt(square);
    const double across = hypot(axis[2][0], axis[2][1]);
    axis[0][0] = axis[2][1] / across;
    axis[0][1] = -axis[2][0] / across;
    axis[1][0] = axis[0][1] * axis[2][2];
    axis[1][1] = -axis[0][0] * axis[2][2];
    axis[1][2] = axis[0][0] * axis[2][1] - axis[0][1] * axis[2][0];
    still->scale = HEIGHT / 2 / tan(HALF_FIELD_OF_VIEW);
    for (int i = 0; i < 8; i++) { /* corners of the box */
        double at[3] = {0};
        for (int d = 0; d < 9; d++)
            at[d / 3] += axis[d / 3][d % 3] * (i >> d % 3 & 1 ? 0.5 : -0.5) * extent[d % 3];
        distance = fmax(distance, fmax(fabs(at[0]) / breadth, fabs(at[1])) / half - at[2]);
    }
    for (int d = 0; d < 3; d++)
        still->eye[d] = -distance * axis[2][d];
}

pl_still *pl_still_begin(const double extent[3]) {
    pl_still *still = calloc(1, sizeof *still);
    if (!still)
        return NULL;
    still->colour = malloc(N_PIXELS);
    still->depth = malloc(N_PIXELS * sizeof *still->depth);
    if (!still->colour || !still->depth) {
        pl_still_free(still);
        return NULL;
    }
    still->is_flat = extent[2] == 0;
    if (still->is_flat)
        still->scale = MARGIN * fmin(WIDTH / fmax(extent[0], 1e-6), HEIGHT / fmax(extent[1], 1e-6));
    else
        turn_camera(still, extent);
    memset(still->colour, NO_COLOUR, N_PIXELS);
    pl_still_cover(still);
    return still;
}

void pl_still_cover(pl_still *still) {
    for (int i = 0; i < N_PIXELS; i++)
        still->depth[i] = INFINITY;
}

/** Find the place in pixels, from the top left, and the depth. */
static void project(const pl_still *still, const double place[3], double at[3]) {
    double seen[3] = {place[0], place[1], 0};
    for (int i = 0; i < 3 && !still->is_flat; i++) {
        seen[i] = 0;
        for (int d = 0; d < 3; d++)
            seen[i] += still->axis[i][d] * (place[d] - still->eye[d]);
    }
    const double scale = still->is_flat ? still->scale : still->scale / fmax(seen[2], 1e-6);
    at[0] = WIDTH / 2.0 + scale * seen[0];
    at[1] = HEIGHT / 2.0 - scale * seen[1];
    at[2] = seen[2];
}

static void put_pixel(pl_still *still, int x, int y, double depth, int colour) {
    const int i = y * WIDTH + x;
    if (x < 0 || x >= WIDTH || y < 0 || y >= HEIGHT || !(depth <= still->depth[i]))
        return;
    still->depth[i] = (float)depth;
    still->colour[i] = (uint8_t)colour;
}

/** Colour of a surface with a normal along u x v. */
static int shade_of(const pl_still *still, const double place[3][3]) {
    double u[3], v[3];
    for (int d = 0; d < 3; d++) {
        u[d] = place[1][d] - place[0][d];
        v[d] = place[2][d] - place[0][d];
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const double along =
        n[0] * still->axis[2][0] + n[1] * still->axis[2][1] + n[2] * still->axis[2][2];
    const int shade = length > 0 ? (int)(fabs(along) / length * PL_STILL_SHADES) : 0;
    return PL_STILL_INVERTED + 1 + (shade < PL_STILL_SHADES ? shade : PL_STILL_SHADES - 1);
}

void pl_still_draw(pl_still *still, const double place[3][3], int colour) {
    double at[3][3], low[2] = {WIDTH, HEIGHT}, high[2] = {0, 0};
    for (int i = 0; i < 3; i++) {
        project(still, place[i], at[i]);
        for (int d = 0; d < 2; d++) {
            low[d] = fmin(low[d], at[i][d]);
            high[d] = fmax(high[d], at[i][d]);
        }
    }
    const double area = (at[1][0] - at[0][0]) * (at[2][1] - at[0][1]) -
                        (at[2][0] - at[0][0]) * (at[1][1] - at[0][1]);
    if (colour < 0)
        colour = shade_of(still, place);
    if (!isfinite(area) || area == 0)
        return;
    for (int y = (int)fmax(low[1], 0); y <= (int)fmin(high[1], HEIGHT - 1); y++)
        for (int x = (int)fmax(low[0], 0); x <= (int)fmin(high[0], WIDTH - 1); x++) {
            double share[3], depth = 0;
            int is_inside = 1;
            for (int i = 0; i < 3; i++) {
                const double *b = at[(i + 1) % 3], *c = at[(i + 2) % 3];
                share[i] = ((b[0] - (x + 0.5)) * (c[1] - (y + 0.5)) -
                            (c[0] - (x + 0.5)) * (b[1] - (y + 0.5))) /
                           area;
                is_inside &= share[i] >= 0;
                depth += share[i] * at[i][2];
            }
            if (is_inside)
                put_pixel(still, x, y, depth, colour);
        }
}

void pl_still_dot(pl_still *still, const double place[3], int colour) {
    double at[3];
    project(still, place, at);
    if (isfinite(at[0]) && isfinite(at[1]) && fabs(at[0]) < N_PIXELS && fabs(at[1]) < N_PIXELS)
        for (int i = 0; i < 4; i++)
            put_pixel(still, (int)(at[0] - 0.5) + i % 2, (int)(at[1] - 0.5) + i / 2, at[2], colour);
}

/** Put the runs of one colour as lines. */
static void put_runs(pl_markup *page, const pl_still *still, int colour) {
    int is_begun = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const uint8_t *row = still->colour + y * WIDTH;
            int end = x;
            while (end < WIDTH && row[end] == colour)
                end++;
            if (end == x)
                continue;
            if (!is_begun++)
                pl_markup_put(page, "<path stroke=\"%s\" d=\"", colours[colour]);
            pl_markup_put(page, "M%d %dh%d", x, y, end - x);
            x = end;
        }
    if (is_begun)
        pl_markup_put(page, "\"/>\n");
}

void pl_still_put(pl_markup *page, const pl_still *still, const char *title) {
    pl_markup_put(page, "<svg class=\"still\" viewBox=\"0 -0.5 %d %d\" role=\"img\" aria-label=\"",
                  WIDTH, HEIGHT);
    pl_markup_put_text(page, title);
    pl_markup_put(page, "\">\n");
    for (int colour = 0; colour < N_COLOURS; colour++)
        put_runs(page, still, colour);
    pl_markup_put(page, "<text x=\"6\" y=\"14\">");
    pl_markup_put_text(page, title);
    pl_markup_put(page, "</text>");
    pl_markup_put(page, "</svg>\n");
}

void pl_still_free(pl_still *still) {
    if (!still)
        return;
    free(still->colour);
    free(still->depth);
    free(still);
}
