/* chart: histograms and curves as SVG within a page. */
#include "report/chart.h"

#include "report/figures.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The drawing and the frame of its axes, in units of the view box. */
enum { WIDTH = 640, HEIGHT = 300, LEFT = 64, RIGHT = 12, TOP = 30, BOTTOM = 52 };

static const double FRAME_WIDTH = WIDTH - LEFT - RIGHT;
static const double FRAME_HEIGHT = HEIGHT - TOP - BOTTOM;
static const double FOOT = HEIGHT - BOTTOM;

/* Ticks that an axis has at most, and significant digits that they have at least. */
enum { MOST_TICKS = 8, DIGITS = 6 };

/* ---- parts that all drawings have ----------------------------------------------------------- */

static void begin_drawing(pl_markup *page, const char *title) {
    pl_markup_put(page, "<svg viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"", WIDTH, HEIGHT);
    pl_markup_put_text(page, title);
    pl_markup_put(page, "\">\n");
}

static void end_drawing(pl_markup *page) {
    pl_markup_put(page, "<path class=\"axis\" d=\"M%d %dV%.0fH%d\"/>\n</svg>\n", LEFT, TOP, FOOT,
                  WIDTH - RIGHT);
}

/** Names of the series with their colours, above the frame. */
static void put_legend(pl_markup *page, int n, const char *const *name, const char *shape) {
    double x = LEFT;
    for (int i = 0; i < n; i++) {
        pl_markup_put(page, "<path class=\"%s s%d\" d=\"M%.1f 14h18\"/><text x=\"%.1f\" y=\"18\">",
                      shape, i, x, x + 24);
        pl_markup_put_text(page, name[i]);
        pl_markup_put(page, "</text>\n");
        x += 44 + 9.5 * (double)strlen(name[i]); /* as wide as on a phone */
    }
}

static void put_x_title(pl_markup *page, const char *axis) {
    pl_markup_put(page, "<text class=\"middle\" x=\"%.1f\" y=\"%d\">", LEFT + FRAME_WIDTH / 2,
                  HEIGHT - 8);
    pl_markup_put_text(page, axis);
    pl_markup_put(page, "</text>\n");
}

/** digits: significant ones. */
static void put_y_tick(pl_markup *page, double y, double value, int digits) {
    pl_markup_put(page,
                  "<path class=\"grid\" d=\"M%d %.1fH%d\"/><text class=\"end\" x=\"%d\" "
                  "y=\"%.1f\">%.*g</text>\n",
                  LEFT, y, WIDTH - RIGHT, LEFT - 6, y + 4, digits, value);
}

/** A number at the right end that has no room below its tick ends with the drawing. */
static void put_x_tick(pl_markup *page, double x, double value, int digits) {
    const double half_digit = 5.5; /* on a phone */
    char text[32];
    const int n = snprintf(text, sizeof text, "%.*g", digits, value);
    const int has_room = x + half_digit * n < WIDTH;
    pl_markup_put(page,
                  "<path class=\"axis\" d=\"M%.1f %.0fv5\"/><text class=\"%s\" x=\"%.1f\" "
                  "y=\"%.0f\">%s</text>\n",
                  x, FOOT, has_room ? "middle" : "end", has_room ? x : WIDTH - 1, FOOT + 20, text);
}

/* ---- histograms ----------------------------------------------------------------------------- */

/** Height of a bar: one element shows, none does not. */
static double bar_height(double count, double most) {
    const double lowest = log10(0.5);
    return count >= 1 ? FRAME_HEIGHT * (log10(count) - lowest) / (log10(most) - lowest) : 0;
}

static void put_bar(pl_markup *page, const pl_histogram *h, int series, int bin, double most) {
    const double step = FRAME_WIDTH / h->n_bins, width = 0.8 * step / h->n_series;
    const double x = LEFT + step * (bin + 0.1) + width * series;
    const double count = h->count[series][bin], height = bar_height(count, most);
    if (!(count >= 1)) /* NAN: the result says none */
        return;
    pl_markup_put(page,
                  "<rect class=\"bar s%d\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" "
                  "height=\"%.1f\"><title>",
                  series, x, FOOT - height, width, height);
    pl_markup_put_text(page, h->name[series]);
    if (isfinite(h->edges[bin + 1]))
        pl_markup_put(page, ", %.6g to %.6g: ", h->edges[bin], h->edges[bin + 1]);
    else
        pl_markup_put(page, ", %.6g and more: ", h->edges[bin]);
    pl_markup_put_count(page, pl_figure_whole(count));
    pl_markup_put(page, "</title></rect>\n");
}

pl_chart_frame pl_chart_frame_of_bins(void) {
    return (pl_chart_frame){LEFT, WIDTH - RIGHT};
}

void pl_chart_histogram(pl_markup *page, const pl_histogram *h) {
    double most = 10;
    for (int s = 0; s < h->n_series; s++)
        for (int i = 0; i < h->n_bins; i++)
            most = fmax(most, h->count[s][i]);
    begin_drawing(page, h->title);
    pl_markup_put(page, "<rect class=\"mark\" y=\"%d\" width=\"0\" height=\"%.0f\"/>\n", TOP,
                  FRAME_HEIGHT); /* the bins that are chosen */
    for (double tick = 1; tick <= most; tick *= 10)
        put_y_tick(page, FOOT - bar_height(tick, most), tick, DIGITS);
    for (int s = 0; s < h->n_series; s++)
        for (int i = 0; i < h->n_bins; i++)
            put_bar(page, h, s, i, most);
    for (int i = 0; i <= h->n_bins; i++)
        if (isfinite(h->edges[i]))
            put_x_tick(page, LEFT + FRAME_WIDTH * i / h->n_bins, h->edges[i], DIGITS);
    put_legend(page, h->n_series, h->name, "bar");
    put_x_title(page, h->axis);
    end_drawing(page);
}

/* What is smaller counts as 0. */
static const double SMALLEST = 1e-100;

/* ---- curves --------------------------------------------------------------------------------- */

/** From a value to a place along an axis of length 1. */
typedef struct scale {
    double low, high;
    int logarithmic;
    double step; /* between ticks at least */
} scale;

static double place(const scale *s, double value) {
    if (s->logarithmic)
        return log(value / s->low) / log(s->high / s->low);
    return (value - s->low) / (s->high - s->low);
}

typedef void put_tick_fn(pl_markup *page, double at, double value, int digits);

/** Ticks at even steps; origin and length: where the axis is in the drawing. */
static void put_even_ticks(pl_markup *page, const scale *s, double origin, double length,
                           put_tick_fn *put) {
    const double range = s->high - s->low;
    double step = pow(10, floor(log10(range / MOST_TICKS))); /* 1, 2, 5, 10 ... */
    while (range / step > MOST_TICKS)
        step *= range / step > 5 * MOST_TICKS ? 10 : range / step > 2 * MOST_TICKS ? 5 : 2;
    step = fmax(step, s->step);
    const double first = ceil(s->low / step - 1e-9);
    const double to_tell = log10(fmax(fabs(s->high), step) / step) + 2; /* digits, ticks apart */
    const int digits = to_tell > DIGITS ? (int)to_tell : DIGITS;
    for (int i = 0; i <= MOST_TICKS + 1; i++) {
        const double value = (first + i) * step;
        if (value <= s->high * (1 + 1e-12))
            put(page, origin + length * place(s, value), value, digits);
    }
}

/** Ticks at powers of ten, every second or third one if there are many. */
static void put_decade_ticks(pl_markup *page, const scale *s, double origin, double length,
                             put_tick_fn *put) {
    const double first = ceil(log10(s->low) - 1e-9), last = floor(log10(s->high) + 1e-9);
    const double step = ceil((last - first + 1) / MOST_TICKS);
    for (double decade = first; decade <= last; decade += step)
        put(page, origin + length * place(s, pow(10, decade)), pow(10, decade), DIGITS);
}

static int is_drawn(double y) {
    return isfinite(y) && y > SMALLEST;
}

/** The range of all values, somewhat widened. */
static scale find_range(const pl_curves *c) {
    scale s = {INFINITY, 0, 1, 0};
    for (int k = 0; k < c->n_series; k++)
        for (int64_t i = 0; i < c->n; i++)
            if (is_drawn(c->y[k][i])) {
                s.low = fmin(s.low, c->y[k][i]);
                s.high = fmax(s.high, c->y[k][i]);
            }
    if (s.high == 0)
        return (scale){1, 2, 1, c->y_step};
    if (s.high / s.low < 1 + 1e-6) /* all but the same: a range that shows it as a line */
        s = (scale){s.low * 0.99, s.high * 1.01, 1, 0};
    const double margin = pow(s.high / s.low, 0.06);
    return (scale){c->floor > 0 ? c->floor : s.low / margin, s.high * margin, 1, c->y_step};
}

/** Shade stretches of points whose phase is not the plain one, unless they are too narrow. */
static void put_phases(pl_markup *page, const pl_curves *c, const scale *x) {
    static const double NARROWEST = 1;
    int64_t first = 0;
    for (int64_t i = 1; c->phase && i <= c->n; i++) {
        const char *phase = c->phase[first];
        if (i < c->n && strcmp(c->phase[i], phase) == 0)
            continue;
        const int64_t from = first > 0 ? first - 1 : 0;
        const double begin = LEFT + FRAME_WIDTH * place(x, c->x[from]);
        const double end = LEFT + FRAME_WIDTH * place(x, c->x[i - 1]);
        first = i;
        if (strcmp(phase, "smooth") == 0 || phase[0] == '\0' || end - begin < NARROWEST)
            continue;
        pl_markup_put(page,
                      "<rect class=\"phase\" x=\"%.1f\" y=\"%d\" width=\"%.1f\" height=\"%.0f\"/>"
                      "<text class=\"quiet\" x=\"%.1f\" y=\"%d\">",
                      begin, TOP, end - begin, FRAME_HEIGHT, begin + 4, TOP + 14);
        pl_markup_put_text(page, phase);
        pl_markup_put(page, "</text>\n");
    }
}

/** A line through the points of series k; of thousands as many as can be told apart. */
static void put_curve(pl_markup *page, const pl_curves *c, const scale *x, const scale *y, int k) {
    enum { MOST_POINTS = 1000 };
    const int64_t stride = c->n / MOST_POINTS + 1;
    int drawn = 0;
    pl_markup_put(page, "<path class=\"line s%d\" d=\"", k);
    for (int64_t i = 0; i < c->n; i++) {
        if (!is_drawn(c->y[k][i]) || (i % stride != 0 && i != c->n - 1))
            continue;
        pl_markup_put(page, "%c%.1f %.1f", drawn++ ? 'L' : 'M',
                      LEFT + FRAME_WIDTH * place(x, c->x[i]),
                      FOOT - FRAME_HEIGHT * place(y, c->y[k][i]));
    }
    pl_markup_put(page, "\"/>\n");
}

void pl_chart_curves(pl_markup *page, const pl_curves *c) {
    const scale y = find_range(c);
    const double end = c->n > 0 ? c->x[c->n - 1] : 0;
    const scale x = {0, end > SMALLEST ? end : 1, 0, c->x_step};
    begin_drawing(page, c->title);
    put_phases(page, c, &x);
    if (y.high / y.low < 20)
        put_even_ticks(page, &y, FOOT, -FRAME_HEIGHT, put_y_tick);
    else
        put_decade_ticks(page, &y, FOOT, -FRAME_HEIGHT, put_y_tick);
    put_even_ticks(page, &x, LEFT, FRAME_WIDTH, put_x_tick);
    for (int k = 0; k < c->n_series; k++)
        put_curve(page, c, &x, &y, k);
    put_legend(page, c->n_series, c->name, "line");
    put_x_title(page, c->x_axis);
    end_drawing(page);
}
