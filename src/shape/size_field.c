/* size_field: sizes at the places where nodes are, and targets of these sizes. */
#include "shape/size_field.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "base/sum.h"
#include "geometry/corner.h"
#include "geometry/simplex.h"
#include "topology/points.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

enum { CHUNK = 4096 };

/* Sizes that vary by more than this are a mistake. */
#define MOST_RATIO 1e12

/* ---- the field --------------------------------------------------------------------------------- */

/** The smallest and the largest size of nodes, and where they are. */
typedef struct extremes {
    double least, most;
    int64_t at_least, at_most;
} extremes;

static void widen(extremes *e, int64_t node, double least, double most) {
    if (least < e->least)
        *e = (extremes){least, e->most, node, e->at_most};
    if (most > e->most)
        *e = (extremes){e->least, most, e->at_least, node};
}

/** Take the sizes of nodes as they are. */
static int take_sizes(int64_t n, const double *given, double *size, extremes *e,
                      planish_error *error) {
    for (int64_t i = 0; i < n; i++) {
        if (!(given[i] > 0 && isfinite(given[i])))
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, i,
                              "node %" PRId64 " has the size %g; give positive finite numbers", i,
                              given[i]);
        size[i] = given[i];
        widen(e, i, given[i], given[i]);
    }
    return PLANISH_OK;
}

/** Say why a node's metric has no sizes. */
static int complain_metric(int count, int64_t node, const double *metric, planish_error *error) {
    int is_finite = 1;
    for (int k = 0; k < count; k++)
        is_finite &= isfinite(metric[k]) != 0;
    return pl_fail_at(error, PLANISH_ERROR_MESH, -1, node, "the metric of node %" PRId64 " %s",
                      node,
                      is_finite ? "is not positive definite; give such matrices"
                                : "has an entry that is not finite; give finite numbers");
}

/** Take the sizes of metrics. */
static int take_metrics(int dim, int64_t n, const double *metric, double *size, extremes *e,
                        planish_error *error) {
    const int count = pl_symmetric_count(dim);
    for (int64_t i = 0; i < n; i++) {
        double least = 0, most = 0;
        if (!pl_metric_sizes(dim, metric + i * count, size + i * count, &least, &most))
            return complain_metric(count, i, metric + i * count, error);
        widen(e, i, least, most);
    }
    return PLANISH_OK;
}

/** Fill the sizes, in units of the largest one. */
static int fill_sizes(const planish_mesh *mesh, pl_size_field *f, planish_error *error) {
    const int64_t n = mesh->n_nodes;
    extremes e = {.least = INFINITY};
    const int status = mesh->metric ? take_metrics(mesh->dim, n, mesh->metric, f->size, &e, error)
                                    : take_sizes(n, mesh->size, f->size, &e, error);
    if (status || n == 0)
        return status;
    if (!(e.least >= e.most / MOST_RATIO))
        return pl_fail_at(error, PLANISH_ERROR_MESH, -1, e.at_least,
                          "node %" PRId64 " has the size %g, and node %" PRId64
                          " %g; sizes must not vary by more than %g",
                          e.at_least, e.least, e.at_most, e.most, MOST_RATIO);
    f->largest = e.most;
    for (int64_t i = 0; i < n * f->n_numbers; i++)
        f->size[i] /= f->largest;
    return PLANISH_OK;
}

/** Make the background, at mesh->reference or at x. */
static int make_background(const planish_mesh *mesh, const double *x, int threads, pl_size_field *f,
                           planish_error *error) {
    if (!mesh->reference)
        return pl_background_create(mesh, x, threads, &f->background, error);
    const pl_points places = pl_points_of(mesh, mesh->reference);
    double *dense = pl_alloc(mesh->n_nodes * mesh->dim, sizeof *dense);
    int status = dense ? pl_points_check(&places, threads, error)
                       : pl_fail_memory(error, "the field of sizes");
    if (!status) {
        pl_points_gather(&places, threads, dense);
        status = pl_background_create(mesh, dense, threads, &f->background, error);
    }
    pl_free(dense);
    return status;
}

int pl_size_field_create(const planish_mesh *mesh, const double *x, int threads, pl_size_field *f,
                         planish_error *error) {
    const int64_t n_nodes = mesh->n_nodes;
    *f = (pl_size_field){.n_numbers = mesh->metric ? pl_symmetric_count(mesh->dim) : 1,
                         .largest = 1};
    if (!mesh->size == !mesh->metric)
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "mesh.size and mesh.metric are both given, or none of them; give one");
    f->size = pl_alloc(n_nodes * f->n_numbers, sizeof *f->size);
    f->at = pl_alloc(n_nodes, sizeof *f->at);
    if (!f->size || !f->at)
        return pl_fail_memory(error, "the field of sizes");
    int status = fill_sizes(mesh, f, error);
    if (!status)
        status = make_background(mesh, x, threads, f, error);
    if (!status)
        pl_size_field_begin(f);
    return status;
}

void pl_size_field_begin(pl_size_field *f) {
    const int64_t n = f->background.n_nodes;
    if (n > 0)
        memcpy(f->at, f->background.first, (size_t)n * sizeof *f->at);
}

void pl_size_field_destroy(pl_size_field *f) {
    pl_background_destroy(&f->background);
    pl_free(f->size);
    pl_free(f->at);
}

/** Nodes being found. */
typedef struct finding {
    pl_size_field *field;
    const double *x;
    const int32_t *place;
    double *found;
} finding;

static void find_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const finding *f = context;
    const pl_background *b = &f->field->background;
    const int dim = b->dim, n = f->field->n_numbers;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int32_t *at = &f->field->at[i];
        double weight[4];
        if (*at < 0) {
            memcpy(f->found + i * n, f->field->size + i * n, (size_t)n * sizeof *f->found);
            continue;
        }
        pl_background_find(b, f->x + (f->place ? f->place[i] : i) * dim, at, weight);
        for (int k = 0; k < n; k++) {
            double sum = 0;
            for (int j = 0; j <= dim; j++)
                sum += weight[j] *
                       f->field->size[b->node[(int64_t)*at * (dim + 1) + j] * (int64_t)n + k];
            f->found[i * n + k] = sum;
        }
    }
}

void pl_size_field_find(pl_size_field *field, const double *x, const int32_t *place, int threads,
                        double *found) {
    finding f = {field, x, place, found};
    pl_parallel_for(threads, field->background.n_nodes, CHUNK, find_chunk, &f);
}

/* ---- targets ----------------------------------------------------------------------------------- */

/** Targets being fitted. */
typedef struct fit {
    const pl_sized_corners *of;
    pl_target ideal[PL_N_FORMS / 8]; /* by kinds, with edges of 1 */
    double share[PL_N_FORMS / 8];    /* of a corner in its cell */
    pl_target *target;
    pl_metric *metric;
    pl_sum *sum;   /* of tau, and how many these are; shared */
    double factor; /* of measures */
} fit;

static int kind_of(const pl_sized_corners *c, int64_t i) {
    return c->corner ? pl_corner_kind(c->corner[i]) : PL_KIND_SIMPLEX;
}

double pl_sized_measure(const pl_sized_corners *c, int64_t i) {
    double edges[3][3] = {{0}};
    const double *vertex[4] = {NULL};
    for (int j = 0; j <= c->dim; j++) {
        const int32_t node = c->node[i * (c->dim + 1) + j];
        vertex[j] = c->x + (int64_t)(c->place ? c->place[node] : node) * c->dim;
    }
    pl_edges(c->dim, vertex, edges);
    return fabs(pl_determinant_of_edges(c->dim, (const double(*)[3])edges));
}

/** Fill mean [n_numbers] with the mean size of a corner. */
static void find_mean_size(const pl_sized_corners *c, int64_t i, double mean[PL_MOST_SYMMETRIC]) {
    for (int k = 0; k < c->n_numbers; k++) {
        double sum = 0;
        for (int j = 0; j <= c->dim; j++)
            sum += c->size[c->node[i * (c->dim + 1) + j] * (int64_t)c->n_numbers + k];
        mean[k] = sum / (c->dim + 1);
    }
}

double pl_sized_metric(const pl_sized_corners *c, int64_t i, pl_metric *metric) {
    double mean[PL_MOST_SYMMETRIC] = {0};
    find_mean_size(c, i, mean);
    return pl_metric_make(c->dim, mean, metric);
}

/** Return the measure in which a corner is to be, in units of that of the ideal one. */
static double wanted_measure(const fit *f, int64_t i) {
    double size[PL_MOST_SYMMETRIC] = {0};
    pl_metric metric;
    if (f->of->n_numbers > 1)
        return pl_sized_metric(f->of, i, f->metric ? &f->metric[i] : &metric);
    find_mean_size(f->of, i, size);
    return f->of->dim == 3 ? size[0] * size[0] * size[0] : size[0] * size[0];
}

/** Give a corner the target of its mean size, without the factor. */
static void size_corner(const fit *f, int64_t i) {
    f->target[i] = f->ideal[kind_of(f->of, i)];
    f->target[i].measure *= wanted_measure(f, i);
}

static void size_chunk(void *context, int64_t begin, int64_t end, int thread) {
    fit *f = context;
    pl_sum sum[2] = {{.n_added = 0}, {.n_added = 0}};
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        size_corner(f, i);
        const double tau = pl_sized_measure(f->of, i) / f->target[i].measure;
        const double share = f->share[kind_of(f->of, i)];
        if (!(tau > 0))
            continue;
        pl_sum_add(&sum[0], share * tau);
        pl_sum_add(&sum[1], share);
    }
    pl_sum_merge(&f->sum[0], &sum[0]);
    pl_sum_merge(&f->sum[1], &sum[1]);
}

static void scale_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const fit *f = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        f->target[i].measure *= f->factor;
        f->target[i].unit = 1 / f->target[i].measure;
    }
}

/** Make the ideal targets of all kinds of dimension dim. */
static void make_ideals(int dim, fit *f) {
    for (int kind = 0; kind < PL_N_FORMS / 8; kind++) {
        const pl_cell_shape *shape = pl_shape_of_kind(dim, kind);
        double edges[3][3] = {{0}};
        if (!shape)
            continue;
        pl_ideal_edges(shape, edges);
        pl_target_make(dim, (const double(*)[3])edges, 1, &f->ideal[kind]);
        f->share[kind] = shape->n_simplices == 1 ? 1 : 1.0 / shape->n_measured;
    }
}

/** Return the factor of measures of what has been summed. */
static double factor_of(const fit *f) {
    const double factor = pl_sum_value(&f->sum[0]) / pl_sum_value(&f->sum[1]);
    return factor > 0 && isfinite(factor) ? factor : 1; /* all is flat */
}

double pl_sizes_fit(const pl_sized_corners *c, double factor, int threads, pl_target *target,
                    pl_metric *metric) {
    pl_sum sum[2] = {{.n_added = 0}, {.n_added = 0}};
    fit f = {.of = c, .target = target, .metric = metric, .sum = sum};
    make_ideals(c->dim, &f);
    pl_parallel_for(threads, c->n, CHUNK, size_chunk, &f);
    f.factor =
        factor > 0 ? (c->dim == 3 ? factor * factor * factor : factor * factor) : factor_of(&f);
    pl_parallel_for(threads, c->n, CHUNK, scale_chunk, &f);
    return factor > 0 ? factor : c->dim == 3 ? pl_cube_root(f.factor) : sqrt(f.factor);
}
