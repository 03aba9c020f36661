/* quality: the measures of a surface mesh for the caller: each triangle, and each corner of a
 * quadrilateral, is laid out in a plane of its own, where the measures of flat meshes are taken. */
#include "surface/quality.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "base/sum.h"
#include "geometry/cell.h"
#include "geometry/corner.h"
#include "quality/measure.h"
#include "surface/facet_terms.h"
#include "surface/smooth.h"
#include "surface/begin.h"
#include "topology/points.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 2048, MOST_CORNERS = 4 };

/** Elements laid out: of triangles alone one flat element for each, else one for each corner. */
typedef struct layout {
    const planish_shape *shape;
    const planish_mesh *mesh;
    const pl_points *points;
    int has_quads;
    int64_t n_cells;
    int32_t *cell;       /* [n_cells] element of the mesh */
    int32_t *facet;      /* [n_cells] its facet of the shape, the first half of a quadrilateral */
    int32_t *begin;      /* [n_cells + 1] its first flat element */
    double *place;       /* [flat elements][3][2], in the shape's units */
    int32_t *element;    /* [flat elements][3] */
    int8_t *sign;        /* [flat elements] -1: it has turned over */
    uint8_t *corner;     /* [flat elements] code */
    uint8_t *is_movable; /* [flat elements] as its cell */
    uint8_t *moves;      /* [shape->n_nodes] */
} layout;

/** One corner of an element: vectors of facet_terms.h. A triangle's first corner stands for all. */
static void take_corner(const layout *l, int64_t cell, int k, int n, pl_facet_vectors *v) {
    const int32_t *node = l->mesh->cells->node + l->mesh->cells->offset[l->cell[cell]];
    const int at[3] = {k, (k + 1) % n, (k + n - 1) % n};
    double x[3][3];
    for (int i = 0; i < 3; i++)
        for (int d = 0; d < 3; d++)
            x[i][d] = l->points->x[pl_point_at(l->points, node[at[i]], d)] * l->shape->scale;
    pl_facet_vectors_of(n == 3 ? PL_TERM_TRIANGLE : PL_TERM_OWN, x[0], x[1], x[2], v);
}

static int corners_of(const layout *l, int64_t cell) {
    return pl_cell_type_of(l->mesh->cells->type[l->cell[cell]])->shape->n_corners;
}

/** Return 1 if a corner is as its facet of the shape, -1 if it has turned over, 0 without area. The
 *  shape's facets may be listed the other way round. */
static int side_of(const layout *l, int64_t cell, const pl_facet_vectors *v) {
    const planish_shape *s = l->shape;
    const int32_t *node = l->mesh->cells->node + l->mesh->cells->offset[l->cell[cell]];
    const int32_t *facet = s->facet[l->facet[cell]];
    int at[3] = {0, 0, 0}; /* where the corners of the facet are in the element */
    for (int k = 0; k < 3; k++)
        while (s->number[node[at[k]]] != facet[k])
            at[k]++;
    const int is_turned = (at[0] > at[1]) + (at[1] > at[2]) + (at[2] > at[0]) == 2;
    double first[3];
    pl_kept_normal(s, l->facet[cell], first);
    const double side = pl_dot(3, v->n, first) * (is_turned ? -1 : 1);
    return (side > 0) - (side < 0);
}

static void lay_out_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const layout *l = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int n = corners_of(l, i), n_flat = n == 3 ? 1 : n;
        const int32_t *node = l->mesh->cells->node + l->mesh->cells->offset[l->cell[i]];
        int any = 0;
        for (int k = 0; k < n; k++)
            any |= l->moves[l->shape->number[node[k]]];
        for (int k = 0; k < n_flat; k++) {
            const int64_t e = l->begin[i] + k;
            pl_facet_vectors v;
            take_corner(l, i, k, n, &v);
            const double length = sqrt(v.la), size = length > 0 ? length : 1;
            const double place[6] = {
                0, 0, length, 0, pl_dot(3, v.a, v.b) / size, sqrt(v.nn) / size};
            memcpy(l->place + 6 * e, place, sizeof place);
            for (int j = 0; j < 3; j++)
                l->element[3 * e + j] = (int32_t)(3 * e + j);
            l->sign[e] = side_of(l, i, &v) > 0 ? 1 : -1;
            l->corner[e] = pl_corner_code(n == 3 ? PL_KIND_SIMPLEX : PL_KIND_BRICK, k);
            l->is_movable[e] = (uint8_t)any;
        }
    }
}

/** List the elements that are facets; fails if they are not those of the shape. */
static int list_cells(layout *l, planish_error *error) {
    const planish_cells *cells = l->mesh->cells;
    int64_t facet = 0, flat = 0;
    const int status = pl_surface_check_elements(l->mesh, l->shape, error);
    if (status)
        return status;
    l->cell = pl_alloc(cells->n, sizeof *l->cell);
    l->facet = pl_alloc(cells->n, sizeof *l->facet);
    l->begin = pl_alloc(cells->n + 1, sizeof *l->begin);
    if (!l->cell || !l->facet || !l->begin)
        return pl_fail_memory(error, "the measures of a surface");
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        if (!type || type->shape->dim != 2)
            continue;
        const int is_quad = type->shape->n_corners == 4;
        l->cell[l->n_cells] = (int32_t)i;
        l->facet[l->n_cells] = (int32_t)facet;
        l->begin[l->n_cells++] = (int32_t)flat;
        facet += 1 + is_quad;
        flat += is_quad ? 4 : 1;
        l->has_quads |= is_quad;
    }
    l->begin[l->n_cells] = (int32_t)flat;
    return PLANISH_OK;
}

static int lay_out(layout *l, int threads, planish_error *error) {
    int status = 4 * l->mesh->cells->n > INT32_MAX / 3
                     ? pl_fail(error, PLANISH_ERROR_ARGUMENT,
                               "the surface has %lld elements; %d can be measured",
                               (long long)l->mesh->cells->n, INT32_MAX / 12)
                     : list_cells(l, error);
    const int64_t n = status ? 0 : l->begin[l->n_cells];
    if (status)
        return status;
    l->place = pl_alloc(n, 6 * sizeof *l->place);
    l->element = pl_alloc(n, 3 * sizeof *l->element);
    l->sign = pl_alloc(n, sizeof *l->sign);
    l->corner = pl_alloc(n, sizeof *l->corner);
    l->is_movable = pl_alloc(n, sizeof *l->is_movable);
    l->moves = pl_alloc_zero(l->shape->n_nodes, sizeof *l->moves);
    if (!l->place || !l->element || !l->sign || !l->corner || !l->is_movable || !l->moves)
        return pl_fail_memory(error, "the measures of a surface");
    pl_surface_find_moves(l->mesh, l->shape, l->moves);
    pl_parallel_for(threads, l->n_cells, CHUNK, lay_out_chunk, l);
    return PLANISH_OK;
}

/** Bring areas to the mesh's units, and the worst element to its number. */
static void bring_back(const layout *l, planish_quality *quality) {
    const double unit = 1 / l->shape->scale;
    double *const area[] = {&quality->min_volume, &quality->max_volume, &quality->total_volume};
    for (int i = 0; i < 3; i++)
        *area[i] *= unit * unit;
    int64_t cell = 0, end = l->n_cells - 1;
    while (cell < end && quality->worst_element >= 0) { /* the last that begins there, or before */
        const int64_t middle = (cell + end + 1) / 2;
        if (l->begin[middle] <= quality->worst_element)
            cell = middle;
        else
            end = middle - 1;
    }
    if (quality->worst_element >= 0)
        quality->worst_element = l->cell[cell];
}

/* ---- elements one by one ---------------------------------------------------------------------- */

/** Measures of one element. */
typedef struct facet_measures {
    int n_inverted; /* corners without area, or turned over */
    double square;  /* AR^2 */
    double jacobian, edge_ratio;
} facet_measures;

static facet_measures measure_cell(const layout *l, int64_t cell) {
    const int n = corners_of(l, cell), n_flat = n == 3 ? 1 : n;
    const double ideal = n == 3 ? sqrt(3) / 2 : 1;
    facet_measures m = {0, 0, INFINITY, 0};
    double longest = 0, shortest = INFINITY;
    for (int k = 0; k < n; k++) {
        pl_facet_vectors v;
        take_corner(l, cell, k, n, &v);
        const int side = side_of(l, cell, &v);
        const double product = sqrt(v.la) * sqrt(v.lb);
        longest = fmax(longest, v.la);
        shortest = fmin(shortest, v.la);
        m.n_inverted += side <= 0;
        m.jacobian = fmin(m.jacobian, product > 0 ? side * sqrt(v.nn) / (product * ideal) : 0);
        if (k < n_flat)
            m.square += pl_facet_ratio(n == 3 ? PL_TERM_TRIANGLE : PL_TERM_OWN, 0, &v) / n_flat;
    }
    m.edge_ratio = sqrt(longest / shortest);
    return m;
}

static void put_values(const planish_cell_values *values, int64_t element,
                       const facet_measures *m) {
    const int is_valid = m->n_inverted == 0;
    if (values->state)
        values->state[element] = is_valid ? PLANISH_CELL_STATE_VALID : PLANISH_CELL_STATE_INVERTED;
    if (values->is_curved)
        values->is_curved[element] = 0;
    if (values->aspect_ratio)
        values->aspect_ratio[element] = is_valid ? sqrt(m->square) : 0;
    if (values->scaled_jacobian)
        values->scaled_jacobian[element] = m->jacobian;
    if (values->jacobian_ratio)
        values->jacobian_ratio[element] = 1;
    if (values->edge_ratio)
        values->edge_ratio[element] = m->edge_ratio;
}

/** Sums over elements of a type, or all. */
typedef struct cell_sums {
    planish_cell_measures of;
    pl_sum square, ratio;
    int64_t n_valid;
} cell_sums;

static void add_cell(cell_sums *sums, int64_t element, const facet_measures *m) {
    planish_cell_measures *of = &sums->of;
    const double ratio = sqrt(m->square);
    of->n_elements++;
    of->n_inverted += m->n_inverted > 0;
    of->n_inverted_corners += m->n_inverted;
    of->min_scaled_jacobian =
        of->n_elements == 1 ? m->jacobian : fmin(of->min_scaled_jacobian, m->jacobian);
    of->max_edge_ratio = fmax(of->max_edge_ratio, m->edge_ratio);
    if (m->n_inverted > 0)
        return;
    sums->n_valid++;
    pl_sum_add(&sums->square, m->square);
    pl_sum_add(&sums->ratio, ratio);
    if (ratio > of->max_aspect_ratio) {
        of->max_aspect_ratio = ratio;
        of->worst_element = element;
    }
}

static planish_cell_measures finish_cells(cell_sums *sums) {
    planish_cell_measures of = sums->of;
    const double n = (double)sums->n_valid;
    of.rms_aspect_ratio = n > 0 ? sqrt(pl_sum_value(&sums->square) / n) : 0;
    of.mean_aspect_ratio = n > 0 ? pl_sum_value(&sums->ratio) / n : 0;
    of.min_jacobian_ratio = 1;
    return of;
}

/** Measure the elements as those of any type are: cells and values, each of which may be NULL. */
static int measure_cells(const layout *l, planish_cell_quality *cells,
                         const planish_cell_values *values, planish_error *error) {
    cell_sums *sums = pl_alloc_zero(UINT8_MAX + 1, sizeof *sums);
    if (!sums)
        return pl_fail_memory(error, "the measures of a surface");
    for (int t = 0; t <= UINT8_MAX; t++)
        sums[t].of.worst_element = -1;
    for (int64_t i = 0; i < l->n_cells; i++) {
        const facet_measures m = measure_cell(l, i);
        const int type = l->mesh->cells->type[l->cell[i]];
        if (values)
            put_values(values, l->cell[i], &m);
        add_cell(&sums[0], l->cell[i], &m); /* no element has type 0 */
        add_cell(&sums[type], l->cell[i], &m);
    }
    if (cells)
        *cells = (planish_cell_quality){.all = finish_cells(&sums[0])};
    for (int t = 1; cells && t <= UINT8_MAX; t++)
        if (sums[t].of.n_elements > 0) {
            cells->type[cells->n_types] = (planish_cell_type)t;
            cells->by_type[cells->n_types++] = finish_cells(&sums[t]);
        }
    pl_free(sums);
    return PLANISH_OK;
}

/* ---- all of it -------------------------------------------------------------------------------- */

/** Put the ratios of flat elements to the elements of the mesh: all corners of one have the same. */
static void put_ratios(const layout *l, const double *flat, double *ratio) {
    for (int64_t i = 0; i < l->mesh->cells->n; i++)
        ratio[i] = 0;
    for (int64_t i = 0; i < l->n_cells; i++)
        ratio[l->cell[i]] = flat[l->begin[i]];
}

int pl_surface_quality(const pl_surface_measuring *m, int threads, planish_error *error) {
    layout l = {.shape = m->shape, .mesh = m->mesh, .points = m->points};
    double *flat = NULL;
    planish_quality found;
    planish_cell_quality cells;
    int status = lay_out(&l, threads, error);
    const int64_t n = status ? 0 : l.begin[l.n_cells];
    const pl_view view = {.dim = 2,
                          .n_nodes = 3 * n,
                          .n_elements = n,
                          .elements = l.element,
                          .corner = l.has_quads ? l.corner : NULL,
                          .n_cells = l.n_cells,
                          .cell_begin = l.begin,
                          .sign = l.sign,
                          .is_movable = l.is_movable};
    if (!status)
        status = pl_measure(&view, l.place, threads, &found, error);
    if (!status && m->ratio && !(flat = pl_alloc(n, sizeof *flat)))
        status = pl_fail_memory(error, "the measures of a surface");
    if (!status && (m->cells || m->values))
        status = measure_cells(&l, &cells, m->values, error);
    if (!status) {
        bring_back(&l, &found);
        *m->quality = found;
        if (m->cells)
            *m->cells = cells;
    }
    if (!status && m->ratio) {
        pl_find_ratios(&view, l.place, threads, flat);
        put_ratios(&l, flat, m->ratio);
    }
    pl_free(flat);
    pl_free(l.cell);
    pl_free(l.facet);
    pl_free(l.begin);
    pl_free(l.place);
    pl_free(l.element);
    pl_free(l.sign);
    pl_free(l.corner);
    pl_free(l.is_movable);
    pl_free(l.moves);
    return status;
}
