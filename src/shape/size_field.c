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

enum { CHUNK = 4096 };

/* Sizes that vary by more than this are a mistake. */
#define MOST_RATIO 1e12

/* ---- the field --------------------------------------------------------------------------------- */

/** Check the sizes, and find the largest one. */
static int check_sizes(int64_t n, const double *size, double *largest, planish_error *error) {
    int64_t least = 0, most = 0;
    if (n == 0)
        return PLANISH_OK;
    for (int64_t i = 0; i < n; i++) {
        if (!(size[i] > 0 && isfinite(size[i])))
            return pl_fail_at(error, PLANISH_ERROR_MESH, -1, i,
                              "node %" PRId64 " has the size %g; give positive finite numbers", i,
                              size[i]);
        least = size[i] < size[least] ? i : least;
        most = size[i] > size[most] ? i : most;
    }
    *largest = size[most];
    return size[least] >= size[most] / MOST_RATIO
               ? PLANISH_OK
               : pl_fail_at(error, PLANISH_ERROR_MESH, -1, least,
                            "node %" PRId64 " has the size %g, and node %" PRId64
                            " %g; sizes must not vary by more than %g",
                            least, size[least], most, size[most], MOST_RATIO);
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
    *f = (pl_size_field){.largest = 1};
    int status = check_sizes(n_nodes, mesh->size, &f->largest, error);
    if (!status)
        status = make_background(mesh, x, threads, f, error);
    if (status)
        return status;
    f->size = pl_alloc(n_nodes, sizeof *f->size);
    f->at = pl_alloc(n_nodes, sizeof *f->at);
    if (!f->size || !f->at)
        return pl_fail_memory(error, "the field of sizes");
    for (int64_t i = 0; i < n_nodes; i++) {
        f->size[i] = mesh->size[i] / f->largest;
        f->at[i] = f->background.first[i];
    }
    return PLANISH_OK;
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
    const int dim = b->dim;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int32_t *at = &f->field->at[i];
        double weight[4], sum = 0;
        f->found[i] = f->field->size[i];
        if (*at < 0)
            continue;
        pl_background_find(b, f->x + (f->place ? f->place[i] : i) * dim, at, weight);
        for (int j = 0; j <= dim; j++)
            sum += weight[j] * f->field->size[b->node[(int64_t)*at * (dim + 1) + j]];
        f->found[i] = sum;
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
    pl_sum *sum;   /* of tau, and of 1 / tau; shared */
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

/** Give a corner the target of its mean size, without the factor. */
static void size_corner(const fit *f, int64_t i) {
    const int dim = f->of->dim;
    double sum = 0;
    for (int j = 0; j <= dim; j++)
        sum += f->of->size[f->of->node[i * (dim + 1) + j]];
    const double size = sum / (dim + 1);
    pl_target *t = &f->target[i];
    *t = f->ideal[kind_of(f->of, i)];
    t->measure *= dim == 3 ? size * size * size : size * size;
}

static void size_chunk(void *context, int64_t begin, int64_t end, int thread) {
    fit *f = context;
    pl_sum sum[2] = {{.n_added = 0}, {.n_added = 0}};
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        size_corner(f, i);
        const double tau = pl_sized_measure(f->of, i) / f->target[i].measure;
        const double share = f->share[kind_of(f->of, i)];
        if (!(tau > 0 && share / tau < INFINITY))
            continue;
        pl_sum_add(&sum[0], share * tau);
        pl_sum_add(&sum[1], share / tau);
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

void pl_sizes_set(const pl_sized_corners *c, int threads, pl_target *target) {
    pl_sum sum[2] = {{.n_added = 0}, {.n_added = 0}};
    fit f = {.of = c, .target = target, .sum = sum, .factor = 1};
    make_ideals(c->dim, &f);
    pl_parallel_for(threads, c->n, CHUNK, size_chunk, &f);
    pl_parallel_for(threads, c->n, CHUNK, scale_chunk, &f);
}

double pl_sizes_fit(const pl_sized_corners *c, int threads, pl_target *target) {
    pl_sum sum[2] = {{.n_added = 0}, {.n_added = 0}};
    fit f = {.of = c, .target = target, .sum = sum};
    make_ideals(c->dim, &f);
    pl_parallel_for(threads, c->n, CHUNK, size_chunk, &f);
    f.factor = sqrt(pl_sum_value(&sum[0]) / pl_sum_value(&sum[1]));
    if (!(f.factor > 0 && isfinite(f.factor)))
        f.factor = 1; /* all is flat */
    pl_parallel_for(threads, c->n, CHUNK, scale_chunk, &f);
    return c->dim == 3 ? pl_cube_root(f.factor) : sqrt(f.factor);
}
