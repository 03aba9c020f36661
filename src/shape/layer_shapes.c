/* layer_shapes: from the columns of layers to the shapes of their elements. */
#include "shape/layer_shapes.h"

#include "base/memory.h"
#include "base/status.h"
#include "shape/heights.h"
#include "shape/levels.h"
#include "shape/upright_means.h"

#include <math.h>
#include <string.h>

enum { ROUNDS = 4 }; /* of averages of sizes along the rows */

/** Sizes being found. */
typedef struct search {
    const planish_mesh *mesh;
    pl_columns columns;
    double *size; /* [n_cells] length of the edges along the layer of an element as regular as its
                        area allows, */
    double *stretch; /* [n_cells] and the mean ratio of its corners there, 1 in the plane */
    double *least;   /* [n_columns] the least mean ratio of a column */
    double *value;   /* [n_uprights] */
} search;

static const pl_cell_shape *shape_of(const search *s, const pl_layer_cell *cell) {
    return pl_cell_type_of(s->mesh->cells->type[cell->cell])->shape;
}

/** Add the length of the regular corner along the layer that has the area of edges [n], and their mean
 *  ratio. */
static void add_corner(int n, const double edges[2][3], double cosine, double sum[3]) {
    double normal[3];
    if (n == 1) {
        sum[0] += sqrt(pl_dot(3, edges[0], edges[0]));
        sum[1] += 1;
        sum[2] += 1;
        return;
    }
    pl_cross(edges[0], edges[1], normal);
    const double area = sqrt(pl_dot(3, normal, normal)), sine = sqrt(1 - cosine * cosine);
    const double energy = pl_dot(3, edges[0], edges[0]) + pl_dot(3, edges[1], edges[1]) -
                          2 * cosine * pl_dot(3, edges[0], edges[1]);
    const double ratio = energy / (2 * sine * area);
    if (!(area > 0) || !isfinite(ratio))
        return;
    sum[0] += sqrt(area / sine);
    sum[1] += ratio;
    sum[2] += 1;
}

/** Cosine of the angle that edges along a layer are to have. */
static double cosine_of(const pl_cell_shape *shape, const pl_layer_cell *cell) {
    int is_triangle = shape->n_simplices == 1;
    for (int f = 0; f < shape->n_simplices; f++)
        is_triangle |= f != cell->factor && shape->n_vertices[f] == 3;
    return is_triangle ? 0.5 : 0;
}

/** Find how large each element is along the layer, and how regular. */
static void find_sizes(search *s) {
    const pl_columns *c = &s->columns;
    for (int64_t i = 0; i < c->n_cells; i++) {
        const pl_layer_cell *cell = &c->cell[i];
        const pl_cell_shape *shape = shape_of(s, cell);
        const int n = pl_layer_corners(shape, cell);
        double sum[3] = {0}, along[2][3];
        for (int k = 0; k < n; k++) {
            pl_columns_corner(c, cell, k, along);
            add_corner(shape->dim - 1, (const double(*)[3])along, cosine_of(shape, cell), sum);
        }
        s->size[i] = sum[2] > 0 ? sum[0] / sum[2] : 0;
        s->stretch[i] = sum[2] > 0 ? sum[1] / sum[2] : 1;
    }
}

/** Average sizes along the rows. */
static int smooth_sizes(search *s, planish_error *error) {
    const pl_columns *c = &s->columns;
    double *sum = pl_alloc_zero(2 * c->n_uprights, sizeof *sum);
    if (!sum)
        return pl_fail_memory(error, "the sizes of layers");
    for (int64_t i = 0; i < c->n_cells; i++)
        for (int k = 0; k < c->cell[i].n_uprights && s->size[i] > 0; k++) {
            sum[2 * (int64_t)c->cell[i].upright[k]] += s->size[i];
            sum[2 * (int64_t)c->cell[i].upright[k] + 1] += 1 / s->size[i];
        }
    for (int64_t u = 0; u < c->n_uprights; u++)
        s->value[u] = sum[2 * u + 1] > 0 ? sqrt(sum[2 * u] / sum[2 * u + 1]) : 0;
    pl_free(sum);
    return pl_columns_average(c, ROUNDS - 1, s->value, s->size, error);
}

/** Put in stretch of each element the mean of the least ones of its columns: walls that are stretched
 *  along the layer stretch all rows on them, while irregular rows become regular. */
static void find_stretch(search *s) {
    const pl_columns *c = &s->columns;
    for (int64_t k = 0; k < c->n_columns; k++)
        s->least[k] = INFINITY;
    for (int64_t i = 0; i < c->n_cells; i++)
        for (int k = 0; k < c->cell[i].n_uprights; k++) {
            double *least = &s->least[c->column[c->cell[i].upright[k]]];
            *least = fmin(*least, s->stretch[i]);
        }
    for (int64_t i = 0; i < c->n_cells; i++) {
        double sum = 0;
        for (int k = 0; k < c->cell[i].n_uprights; k++)
            sum += s->least[c->column[c->cell[i].upright[k]]];
        s->stretch[i] = sum / c->cell[i].n_uprights;
    }
}

/** Give a simplex the shape that it has, if it is in no row. */
static void keep_shape(const search *s, const pl_layer_cell *cell, pl_layer_shape *shape) {
    const int32_t *node = s->mesh->cells->node + s->mesh->cells->offset[cell->cell];
    for (int p = 1; p <= s->mesh->dim; p++)
        pl_columns_edge(&s->columns, node[0], node[p], shape->edges[p - 1]);
}

/** Give a simplex with known levels its shape: the upright is the last axis. */
static void put_simplex(const search *s, const pl_layer_cell *cell, double height, double size,
                        pl_layer_shape *shape) {
    static const double along[2][2] = {{1, 0}, {0.5, 0.8660254037844386}};
    const int dim = s->mesh->dim;
    double x[4][3] = {{0}};
    int n = 0;
    for (int p = 0; p <= dim; p++) {
        x[p][dim - 1] = cell->level >> p & 1 ? height : 0;
        if (p == cell->end[0] || p == cell->end[1])
            continue;
        for (int d = 0; d < dim - 1; d++)
            x[p][d] = size * along[n][d];
        n++;
    }
    for (int p = 1; p <= dim; p++)
        pl_subtract(3, x[p], x[0], shape->edges[p - 1]);
}

/** Put the shape that a product has in own; whether all its corners are oriented alike. */
static int take_own_shape(const search *s, const pl_layer_cell *cell, pl_own_shape *own) {
    const pl_cell_shape *shape = shape_of(s, cell);
    const int32_t *node = s->mesh->cells->node + s->mesh->cells->offset[cell->cell];
    int n_positive = 0, n_negative = 0;
    for (int k = 1; k < shape->n_corners; k++)
        pl_columns_edge(&s->columns, node[0], node[k], own->edges[k - 1]);
    for (int k = 0; k < shape->n_measured; k++) {
        double edges[3][3] = {{0}};
        const double D = pl_own_shape_edges(shape, own, k, edges);
        n_positive += D > 0;
        n_negative += D < 0;
    }
    return n_positive == shape->n_measured || n_negative == shape->n_measured;
}

/** Let valid elements with uprights that lean for good be as they are. */
static int keep_leaning(const search *s, pl_layer_shapes *shapes, planish_error *error) {
    const pl_columns *c = &s->columns;
    int64_t n = 0;
    for (int is_counted = 0; is_counted < 2; is_counted++) {
        if (is_counted && !(shapes->own = pl_alloc(n, sizeof *shapes->own)))
            return pl_fail_memory(error, "the shapes of layers");
        n = 0;
        for (int64_t i = 0; i < c->n_cells; i++) {
            const pl_layer_cell *cell = &c->cell[i];
            int is_leaning = 0;
            for (int k = 0; k < cell->n_uprights && shape_of(s, cell)->n_simplices > 1; k++)
                is_leaning |= c->leans[cell->upright[k]];
            if (is_counted && is_leaning && take_own_shape(s, cell, &shapes->own[n]))
                shapes->place[cell->cell] = (int32_t)(-2 - n);
            n += is_leaning;
        }
    }
    return PLANISH_OK;
}

/** Make the shape that element i of the layers is to have; whether all its corners are targets. */
static int make_shape(const search *s, int64_t i, pl_layer_shape *wanted) {
    const pl_columns *c = &s->columns;
    const pl_layer_cell *cell = &c->cell[i];
    const pl_cell_shape *shape = shape_of(s, cell);
    const double part = 1 / sqrt(s->stretch[i]);
    *wanted = (pl_layer_shape){.factor = cell->factor, .size = s->size[i]};
    for (int k = 0; k < cell->n_uprights; k++)
        wanted->height[k] = part * c->height[cell->upright[k]];
    if (shape->n_simplices == 1 && cell->is_level)
        put_simplex(s, cell, wanted->height[0], s->size[i], wanted);
    else if (shape->n_simplices == 1)
        keep_shape(s, cell, wanted);
    int is_target = 1;
    for (int k = 0; k < shape->n_measured; k++) {
        pl_target target;
        is_target &= pl_layer_target(shape, wanted, k, &target);
    }
    return is_target;
}

static int make_shapes(search *s, pl_layer_shapes *shapes, planish_error *error) {
    const pl_columns *c = &s->columns;
    s->size = pl_alloc(c->n_cells, sizeof *s->size);
    s->stretch = pl_alloc(c->n_cells, sizeof *s->stretch);
    s->least = pl_alloc(c->n_columns, sizeof *s->least);
    s->value = pl_alloc(c->n_uprights, sizeof *s->value);
    shapes->shape = pl_alloc(c->n_cells, sizeof *shapes->shape);
    if (!s->size || !s->stretch || !s->least || !s->value || !shapes->shape)
        return pl_fail_memory(error, "the shapes of layers");
    find_sizes(s);
    find_stretch(s);
    const int status = smooth_sizes(s, error);
    for (int64_t i = 0; !status && i < c->n_cells; i++)
        if (make_shape(s, i, &shapes->shape[i]))
            shapes->place[c->cell[i].cell] = (int32_t)i;
    return status ? status : keep_leaning(s, shapes, error);
}

int pl_layer_shapes_find(const planish_mesh *mesh, const uint8_t *is_layer, int threads,
                         pl_layer_shapes *shapes, planish_error *error) {
    search s = {.mesh = mesh};
    *shapes = (pl_layer_shapes){.place = pl_alloc(mesh->cells->n, sizeof *shapes->place)};
    if (!shapes->place)
        return pl_fail_memory(error, "the shapes of layers");
    memset(shapes->place, -1, (size_t)mesh->cells->n * sizeof *shapes->place);
    int status = pl_columns_find(mesh, is_layer, threads, &s.columns, error);
    if (!status)
        status = pl_columns_find_levels(&s.columns, error);
    if (!status)
        status = pl_columns_find_heights(&s.columns, 1, error);
    if (!status)
        status = make_shapes(&s, shapes, error);
    pl_columns_destroy(&s.columns);
    pl_free(s.size);
    pl_free(s.stretch);
    pl_free(s.least);
    pl_free(s.value);
    return status;
}

void pl_layer_shapes_free(pl_layer_shapes *shapes) {
    pl_free(shapes->place);
    pl_free(shapes->shape);
    pl_free(shapes->own);
}
