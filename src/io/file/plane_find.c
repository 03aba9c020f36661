/* plane_find: the plane that a mesh of elements of two dimensions lies in.
 *
 * Of planes across an axis the other two columns of the file are the coordinates, in the order in
 * which they turn as x and y do: y z, z x. The column across stays as it is in the file.
 *
 * A tilted plane is fitted by least squares: the normal is the direction in which the nodes spread
 * least. What spreads little is seen in a frame that goes along with it, so that a narrow strip has
 * as good a normal as a square; the frame is found again in its own coordinates. Sums are over
 * nodes in their order. How far nodes may be off the plane follows from the digits of the file.
 */
#include "io/file/plane.h"

#include "io/core/text.h"

#include "base/memory.h"
#include "base/status.h"

#include <float.h>
#include <math.h>

/* ---- how exact coordinates are -------------------------------------------------------------- */

/** Count the digits of the number that begins at text, but for leading zeros. */
static int significant_digits(const char *text, const char *end) {
    int digits = 0;
    for (; text < end && (*text == '+' || *text == '-'); text++)
        ;
    for (; text < end && ((*text >= '0' && *text <= '9') || *text == '.'); text++)
        digits += *text != '.' && (digits > 0 || *text != '0');
    return digits;
}

/** Count the digits of the longest coordinate of a node that a span has as text. */
static int digits_of_node(const io_model *model, const io_format *format, const io_span *span,
                          int64_t node) {
    io_cursor cursor = {model->input.data + io_text_place(model, span, node),
                        model->input.data + model->input.size};
    const int first = span->component,
              end = span->n_components > 0 ? first + span->n_components : model->columns;
    int most = 0;
    for (int d = first; d < end; d++) {
        io_field field;
        int digits = 0;
        if (!format->field) {
            io_skip_space(&cursor);
            digits = significant_digits(cursor.at, cursor.end);
            while (cursor.at < cursor.end && (unsigned char)*cursor.at > ' ')
                cursor.at++;
        } else if (format->field(model, &cursor, d, &field) == 0) {
            while (field.begin < field.end && *field.begin == ' ')
                field.begin++;
            digits = significant_digits(field.begin, field.end);
        }
        most = digits > most ? digits : most;
    }
    return most;
}

double io_tolerance_of_digits(const io_model *model, const io_format *format) {
    enum { LOOKED_AT_NODES = 4096, SOME = 100, SHORT = 4, LONG = 12 };
    /* Single-precision coordinates have 24 bits. Whole numbers and the like may be exact with few
     * digits, so that there is a limit. */
    const double of_float = 1e-6, smallest = 1e-8, largest = 1e-5;
    if (model->precision == PLANISH_PRECISION_FLOAT)
        return of_float;
    int most = 0, most_of_few = 0;
    int64_t n = 0, n_few = 0;
    for (int64_t i = 0; i < model->n_spans; i++) {
        const io_span *span = &model->span[i];
        for (int64_t k = 0; span->encoding == IO_TEXT && k < span->n_nodes && n < LOOKED_AT_NODES;
             k++, n++) {
            const int digits = digits_of_node(model, format, span, span->first_node + k);
            most = digits > most ? digits : most;
            if (digits > SHORT && digits <= LONG) {
                most_of_few = digits > most_of_few ? digits : most_of_few;
                n_few++;
            }
        }
    }
    /* Where some nodes have few digits, others all that a double has, the latter have been moved
     * since, by a smoother, say. */
    most = n_few * SOME >= n ? most_of_few : most;
    if (most == 0)
        return 0;
    double tolerance = 10;
    for (int d = 0; d < most; d++)
        tolerance /= 10;
    return tolerance > largest ? largest : tolerance < smallest ? 0 : tolerance;
}

/* ---- nodes of elements ---------------------------------------------------------------------- */

/** Count the corners and mids of triangles and the nodes of other elements. */
static int64_t n_listed(const io_model *model) {
    return (model->triangle.mid ? 6 : 3) * model->triangle.n + model->flat.n_nodes;
}

/** Return number i of these; -1: a missing mid. */
static int64_t listed_node(const io_model *model, int64_t i) {
    const io_cells *triangles = &model->triangle;
    const int64_t n = 3 * triangles->n, n_mids = triangles->mid ? n : 0;
    return i < n            ? triangles->nodes[i]
           : i < n + n_mids ? triangles->mid[i - n]
                            : model->flat.node[i - n - n_mids];
}

/* ---- a tilted plane ------------------------------------------------------------------------- */

/** The nodes of elements about the middle of their box, in units of its diagonal. */
typedef struct cloud {
    const io_model *model;
    uint8_t *is_used; /* [n_nodes] owned */
    int64_t n;        /* how many are */
    double middle[3], size;
} cloud;

/** Find the coordinates of a node in a frame [3][3] of unit vectors in rows. */
static void coordinates_in(const cloud *c, const double frame[3][3], int64_t node, double out[3]) {
    double x[3];
    for (int d = 0; d < 3; d++)
        x[d] = (c->model->xyz[3 * node + d] - c->middle[d]) / c->size;
    for (int i = 0; i < 3; i++)
        out[i] = frame[i][0] * x[0] + frame[i][1] * x[1] + frame[i][2] * x[2];
}

static void find_mean(const cloud *c, const double frame[3][3], double mean[3]) {
    double x[3];
    mean[0] = mean[1] = mean[2] = 0;
    for (int64_t node = 0; node < c->model->n_nodes; node++) {
        if (!c->is_used[node])
            continue;
        coordinates_in(c, frame, node, x);
        for (int d = 0; d < 3; d++)
            mean[d] += x[d];
    }
    for (int d = 0; d < 3; d++)
        mean[d] /= (double)c->n;
}

static void find_spread(const cloud *c, const double frame[3][3], double spread[3][3]) {
    double x[3], mean[3];
    find_mean(c, frame, mean);
    for (int i = 0; i < 9; i++)
        spread[i / 3][i % 3] = 0;
    for (int64_t node = 0; node < c->model->n_nodes; node++) {
        if (!c->is_used[node])
            continue;
        coordinates_in(c, frame, node, x);
        for (int i = 0; i < 9; i++)
            spread[i / 3][i % 3] += (x[i / 3] - mean[i / 3]) * (x[i % 3] - mean[i % 3]);
    }
}

/** Turn rows p and q of the frame, and the spread along with it, so that spread[p][q] vanishes. */
static void turn(double spread[3][3], double frame[3][3], int p, int q) {
    if (spread[p][q] == 0)
        return;
    const double theta = (spread[q][q] - spread[p][p]) / (2 * spread[p][q]);
    const double t = (theta >= 0 ? 1 : -1) / (fabs(theta) + sqrt(theta * theta + 1));
    const double c = 1 / sqrt(t * t + 1), s = t * c;
    for (int i = 0; i < 3; i++) {
        const double a = spread[i][p], b = spread[i][q];
        spread[i][p] = c * a - s * b;
        spread[i][q] = s * a + c * b;
    }
    for (int i = 0; i < 3; i++) {
        const double a = spread[p][i], b = spread[q][i], f = frame[p][i], g = frame[q][i];
        spread[p][i] = c * a - s * b;
        spread[q][i] = s * a + c * b;
        frame[p][i] = c * f - s * g;
        frame[q][i] = s * f + c * g;
    }
}

/** Find the normal, and how wide the nodes spread in the second narrowest direction. */
static double find_normal(const cloud *c, double normal[3]) {
    enum { PASSES = 3, SWEEPS = 30 };
    double frame[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, spread[3][3];
    int order[3] = {0, 1, 2}; /* of the rows, by their spread */
    for (int pass = 0; pass < PASSES; pass++) {
        find_spread(c, frame, spread);
        for (int i = 0; i < SWEEPS; i++) { /* Jacobi's method */
            turn(spread, frame, 0, 1);
            turn(spread, frame, 0, 2);
            turn(spread, frame, 1, 2);
        }
        for (int i = 0; i < 3; i++) {
            double *v = frame[i];
            const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
            for (int d = 0; d < 3; d++)
                v[d] /= length;
        }
    }
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            if (spread[order[k]][order[k]] > spread[order[k + 1]][order[k + 1]]) {
                const int swapped = order[k];
                order[k] = order[k + 1];
                order[k + 1] = swapped;
            }
    for (int d = 0; d < 3; d++)
        normal[d] = frame[order[0]][d];
    return c->size * sqrt(fmax(spread[order[1]][order[1]], 0) / (double)c->n);
}

/** Set the plane with normal n through the mean of the nodes, and how far nodes are off it. */
static void set_plane(const cloud *c, const double n[3], io_plane *plane) {
    const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const double equal = 1 - 1e-6, near = 2;
    double mean[3], from_mean[2], most_off = 0;
    find_mean(c, axes, mean);
    /* Across is the column that the normal is nearest to; of equals z, then x. */
    const double most = fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2])));
    int *axis = plane->axis;
    axis[2] = fabs(n[2]) >= equal * most ? 2 : fabs(n[0]) >= equal * most ? 0 : 1;
    axis[0] = (axis[2] + 1) % 3;
    axis[1] = (axis[2] + 2) % 3;
    const double p = plane->slope[0] = -n[axis[0]] / n[axis[2]];
    const double q = plane->slope[1] = -n[axis[1]] / n[axis[2]];
    plane->xu = sqrt(1 + p * p);
    plane->yu = p * q / plane->xu;
    plane->yv = sqrt((1 + p * p + q * q) / (1 + p * p));
    /* The origin is that of the columns where that is near, so that nothing is rounded. */
    for (int d = 0; d < 2; d++) {
        const double middle = c->middle[axis[d]];
        plane->origin[d] = fabs(middle) > near * c->size ? middle : 0;
        from_mean[d] = (plane->origin[d] - middle) - c->size * mean[axis[d]];
    }
    plane->origin[2] =
        c->middle[axis[2]] + (c->size * mean[axis[2]] + p * from_mean[0] + q * from_mean[1]);
    for (int64_t node = 0; node < c->model->n_nodes; node++) {
        double sum = 0;
        for (int d = 0; c->is_used[node] && d < 3; d++)
            sum += n[d] * ((c->model->xyz[3 * node + d] - c->middle[d]) / c->size - mean[d]);
        most_off = fmax(most_off, fabs(sum));
    }
    plane->is_tilted = 1;
    plane->size = c->size;
    plane->off = most_off * c->size;
}

/** Find the tilted plane that fits the nodes of the elements, within the box from low to high,
 *  best; *is_thin: they are along a line, as far as can be told. */
static int fit_plane(io_model *model, const double low[3], const double high[3], int *is_thin,
                     planish_error *error) {
    const double narrow = 1e-12, thick = 30; /* of the diagonal; times what they are off */
    io_plane *plane = &model->plane;
    double normal[3];
    cloud c = {.model = model, .size = 0};
    *plane = (io_plane){.off = INFINITY};
    *is_thin = 0;
    for (int d = 0; d < 3; d++) {
        c.middle[d] = low[d] + (high[d] - low[d]) / 2;
        c.size = hypot(c.size, high[d] - low[d]);
    }
    if (!(c.size <= DBL_MAX && c.size >= DBL_MIN))
        return PLANISH_OK;
    c.is_used = pl_alloc_zero(model->n_nodes, 1);
    if (!c.is_used)
        return pl_fail_memory(error, "the plane of the mesh");
    for (int64_t i = 0; i < n_listed(model); i++)
        if (listed_node(model, i) >= 0)
            c.is_used[listed_node(model, i)] = 1;
    for (int64_t node = 0; node < model->n_nodes; node++)
        c.n += c.is_used[node];
    const double width = find_normal(&c, normal);
    set_plane(&c, normal, plane);
    *is_thin = !(width > narrow * c.size && width > thick * plane->off);
    pl_free(c.is_used);
    return PLANISH_OK;
}

/* ---- finding it ----------------------------------------------------------------------------- */

/** Return how far nodes may be off their plane, of the diagonal. */
static double tolerance_of(const io_model *model, const io_format *format) {
    const double usual = 1e-8;           /* as planish_find_slides has it */
    const double of_narrow_field = 1e-5; /* where some numbers have fewer digits than others */
    const int narrow_field = 8;
    if (model->flatness > 0)
        return model->flatness;
    double tolerance = format ? io_tolerance_of_digits(model, format) : 0;
    tolerance = tolerance > 0 ? tolerance : usual;
    return model->precision == PLANISH_PRECISION_ROUNDED && model->field_width <= narrow_field
               ? fmax(tolerance, of_narrow_field)
               : tolerance;
}

int io_plane_find(io_model *model, const io_format *format, int *is_found, planish_error *error) {
    static const int order[] = {2, 0, 1}; /* x and y first: all meshes had to be so once */
    /* What geometry kernels and roundings leave of a constant column, as a part of the longer side
     */
    const double noise = 1e-8;
    const char *what = model->flat.n > 0 ? "elements" : "triangles";
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    *is_found = 1;
    for (int64_t i = 0; i < n_listed(model); i++)
        for (int d = 0; d < 3 && listed_node(model, i) >= 0; d++) {
            const double x = model->xyz[3 * listed_node(model, i) + d];
            low[d] = x < low[d] ? x : low[d];
            high[d] = x > high[d] ? x : high[d];
        }
    for (int i = 0; i < 3; i++) {
        const int across = order[i], p = (across + 1) % 3, q = (across + 2) % 3;
        const double first = model->xyz[3 * listed_node(model, 0) + across];
        const double most =
            fmax(noise * high[p] - noise * low[p], noise * high[q] - noise * low[q]);
        if (fabs(low[across] - first) <= most && fabs(high[across] - first) <= most) {
            model->plane = (io_plane){.axis = {p, q, across}, .origin = {0, 0, first}};
            return PLANISH_OK;
        }
    }
    const io_plane *plane = &model->plane;
    const double tolerance = tolerance_of(model, format);
    int is_thin;
    const int status = fit_plane(model, low, high, &is_thin, error);
    const int is_flat = plane->off <= tolerance * plane->size;
    if (status || (is_flat && !is_thin))
        return status;
    if (is_flat)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: %s in space whose nodes all lie near one line (up to %.3g off it): "
                       "planish cannot find their plane",
                       model->input.path, what, plane->off);
    *is_found = 0;
    return PLANISH_OK;
}
