#include "support/worlds.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

enum { CELLS = 4, SWEEPS = 4 };

static void *own(test_world *w, int64_t count, size_t size) {
    assert_true(w->n_owned < WORLD_MOST_OWNED);
    void *array = calloc((size_t)count, size);
    assert_non_null(array);
    w->owned[w->n_owned++] = array;
    return array;
}

static void plain(test_world *w) {
    (void)w;
}

static void tangled(test_world *w) {
    test_mesh_perturb(&w->box, 0.8, 3);
}

static void left_alone(test_world *w) {
    tangled(w);
    w->options.untangle = 0;
}

static void mean_ratio(test_world *w) {
    w->options.objective = PLANISH_OBJECTIVE_MEAN_RATIO;
}

static void edge_ratio(test_world *w) {
    w->options.objective = PLANISH_OBJECTIVE_EDGE_RATIO;
}

static void fletcher_reeves(test_world *w) {
    w->options.search = PLANISH_SEARCH_FLETCHER_REEVES;
}

static void min_volume(test_world *w) {
    w->options.min_volume = w->mesh.dim == 3 ? 0.12 : 0.4;
    w->options.area_weight = 0.3;
}

/** So many are on their minimum volume that the augmented Lagrangian has a go. */
static void min_volume_fraction(test_world *w) {
    for (int64_t i = 0; i < w->n_doubles; i++)
        w->box.coordinates[i] *= 0.5 + 0.5 * w->box.coordinates[i] / CELLS;
    w->options.min_volume_fraction = w->mesh.dim == 3 ? 0.0012 : 0.02;
    w->options.max_sweeps = 60;
}

static void own_min_volumes(test_world *w) {
    double *least = own(w, w->mesh.n_elements, sizeof *least);
    for (int64_t i = 0; i < w->mesh.n_elements; i += 3)
        least[i] = w->mesh.dim == 3 ? 0.14 : 0.45;
    w->mesh.min_volume = least;
}

static void tangled_min_volume(test_world *w) {
    tangled(w);
    own_min_volumes(w);
}

static void bounds(test_world *w) {
    double *lower = own(w, w->n_doubles, sizeof *lower),
           *upper = own(w, w->n_doubles, sizeof *upper);
    for (int64_t i = 0; i < w->n_doubles; i++) {
        lower[i] = w->box.coordinates[i] - 0.02;
        upper[i] = w->box.coordinates[i] + 0.05;
    }
    w->options.lower = lower;
    w->options.upper = upper;
    w->options.box_lower[0] = 0.9;
    w->options.max_displacement = 0.5;
    w->options.displacement_unit = PLANISH_UNIT_EDGE;
}

static void floats(test_world *w) {
    for (int64_t i = 0; i < w->n_doubles; i++)
        w->box.coordinates[i] = (float)w->box.coordinates[i];
    w->options.precision = PLANISH_PRECISION_FLOAT;
}

static double to_thousandths(double value, void *user) {
    (void)user;
    return rint(value * 1000) / 1000;
}

static void rounded(test_world *w) {
    for (int64_t i = 0; i < w->n_doubles; i++)
        w->box.coordinates[i] = to_thousandths(w->box.coordinates[i], NULL);
    w->options.precision = PLANISH_PRECISION_ROUNDED;
    w->options.round = to_thousandths;
}

static void worst_ratio(test_world *w) {
    w->options.worst = PLANISH_WORST_RADIUS_RATIO;
}

static void worst_angle(test_world *w) {
    w->options.worst = PLANISH_WORST_ANGLE;
}

static void only_worse(test_world *w) {
    w->options.only_worse_than = 1.8;
    w->options.rings = 1;
}

static void only_worse_tangled(test_world *w) {
    tangled(w);
    only_worse(w);
}

static int shares_facet(const int32_t *a, const int32_t *b, int corners, int without) {
    for (int i = 0; i < corners; i++) {
        int found = i == without;
        for (int k = 0; k < corners; k++)
            found |= a[i] == b[k];
        if (!found)
            return 0;
    }
    return 1;
}

static void neighbours(test_world *w) {
    const int corners = w->mesh.dim + 1;
    int32_t *beside = own(w, w->mesh.n_elements * corners, sizeof *beside);
    only_worse(w);
    for (int64_t e = 0; e < w->mesh.n_elements; e++)
        for (int c = 0; c < corners; c++) {
            int32_t other = -1;
            for (int64_t k = 0; k < w->mesh.n_elements; k++)
                if (k != e && shares_facet(w->box.elements + e * corners,
                                           w->box.elements + k * corners, corners, c))
                    other = (int32_t)k;
            beside[e * corners + c] = other;
        }
    w->mesh.neighbours = beside;
}

static void around(test_world *w) {
    int64_t *node = own(w, 2, sizeof *node);
    node[0] = w->mesh.n_nodes / 2;
    node[1] = w->mesh.n_nodes / 3;
    w->options.n_around = 2;
    w->options.around = node;
    w->options.rings = 1;
}

static void around_known_elements(test_world *w) {
    neighbours(w);
    around(w);
    const int corners = w->mesh.dim + 1;
    int64_t *element = own(w, 2, sizeof *element);
    w->options.only_worse_than = 0;
    for (int64_t i = 0; i < w->mesh.n_elements * corners; i++)
        for (int k = 0; k < 2; k++)
            if (w->box.elements[i] == w->options.around[k])
                element[k] = i / corners;
    w->options.around_elements = element;
}

static void other_layout(test_world *w) {
    const int dim = w->mesh.dim;
    const int64_t n = w->mesh.n_nodes, n_corners = w->mesh.n_elements * (dim + 1);
    double *x = own(w, n * dim, sizeof *x);
    int64_t *elements = own(w, n_corners, sizeof *elements);
    for (int64_t i = 0; i < n * dim; i++)
        x[i % dim * n + i / dim] = w->box.coordinates[i];
    for (int64_t i = 0; i < n_corners; i++)
        elements[i] = w->box.elements[i];
    w->mesh.coordinates = x;
    w->mesh.node_stride = 1;
    w->mesh.component_stride = n;
    w->mesh.elements = NULL;
    w->mesh.elements64 = elements;
}

static void laplacian(test_world *w) {
    w->options.method = PLANISH_METHOD_LAPLACIAN;
}

static void area_laplacian(test_world *w) {
    w->options.method = PLANISH_METHOD_AREA_LAPLACIAN;
}

static void length_laplacian(test_world *w) {
    w->options.method = PLANISH_METHOD_LENGTH_LAPLACIAN;
}

static void sliding(test_world *w) {
    uint8_t *constraint = own(w, w->mesh.n_nodes, 1);
    double *direction = own(w, w->n_doubles, sizeof *direction);
    assert_int_equal(planish_find_slides(&w->mesh, NULL, 1, constraint, direction, NULL, NULL), 0);
    w->mesh.constraint = constraint;
    w->mesh.direction = direction;
}

static planish_constraint onto_side(int64_t node, double *point, double *direction, void *user) {
    const test_world *w = user;
    (void)node;
    for (int d = 0; d < w->mesh.dim; d++)
        direction[d] = d == 0;
    point[0] = 0;
    return PLANISH_CONSTRAINT_ON_PLANE;
}

/** Those within the side x = 0. */
static void on_surface(test_world *w) {
    sliding(w);
    uint8_t *constraint = own(w, w->mesh.n_nodes, 1);
    for (int64_t i = 0; i < w->mesh.n_nodes; i++)
        constraint[i] = w->mesh.constraint[i] == PLANISH_CONSTRAINT_ON_PLANE &&
                                w->box.coordinates[i * w->mesh.dim] == 0
                            ? PLANISH_CONSTRAINT_ON_SURFACE
                            : w->mesh.constraint[i];
    w->mesh.constraint = constraint;
    w->options.project = onto_side;
    w->options.project_user = w;
}

/** The sides x = 0 and x = CELLS. */
static void periodic(test_world *w) {
    const int dim = w->mesh.dim;
    const double *x = w->box.coordinates;
    int32_t *pair = own(w, 2 * w->mesh.n_nodes, sizeof *pair);
    sliding(w);
    for (int64_t i = 0; i < w->mesh.n_nodes; i++)
        for (int64_t k = 0; k < w->mesh.n_nodes; k++)
            if (x[i * dim] == 0 && x[k * dim] == CELLS && x[i * dim + 1] == x[k * dim + 1] &&
                (dim == 2 || x[i * dim + 2] == x[k * dim + 2])) {
                pair[2 * w->mesh.n_periodic] = (int32_t)i;
                pair[2 * w->mesh.n_periodic++ + 1] = (int32_t)k;
            }
    w->mesh.periodic = pair;
    assert_true(w->mesh.n_periodic > 2);
}

static int go_on(const planish_progress *progress, void *user) {
    (void)progress;
    (void)user;
    return 0;
}

static void listen(planish_log_level level, const char *text, void *user) {
    (void)level;
    (void)text;
    (void)user;
}

static void one_by_one(int n_tasks, planish_task_fn *task, void *data, void *user) {
    (void)user;
    for (int i = 0; i < n_tasks; i++)
        task(data, i);
}

static void targets(test_world *w) {
    double *reference = own(w, w->n_doubles, sizeof *reference);
    const int dim = w->mesh.dim;
    for (int64_t i = 0; i < w->n_doubles; i++)
        reference[i] = w->box.coordinates[i];
    for (int64_t i = dim - 1; i < w->n_doubles; i += dim) /* thin near one side */
        reference[i] *= 0.1 + reference[i];
    tangled(w);
    w->mesh.reference = reference;
    w->options.size_weight = 0.3;
}

static void sizes(test_world *w) {
    double *size = own(w, w->mesh.n_nodes, sizeof *size);
    for (int64_t i = 0; i < w->mesh.n_nodes; i++)
        size[i] = 0.3 + w->box.coordinates[i * w->mesh.dim];
    tangled(w);
    w->mesh.size = size;
    w->options.size_weight = 0.9;
}

static void metric(test_world *w) {
    const int dim = w->mesh.dim, n = dim * (dim + 1) / 2;
    double *values = own(w, w->mesh.n_nodes * n, sizeof *values);
    for (int64_t i = 0; i < w->mesh.n_nodes; i++) {
        values[i * n] = 4 + w->box.coordinates[i * dim];
        values[i * n + 1] = 0.5;
        values[i * n + 2] = 1;
        if (dim == 3)
            values[i * n + 5] = 2;
    }
    tangled(w);
    w->mesh.metric = values;
}

static void callbacks(test_world *w) {
    tangled(w);
    w->options.progress = go_on;
    w->options.log = listen;
    w->options.parallel = one_by_one;
    w->options.threads = 3;
}

static void threads(test_world *w) {
    tangled(w);
    w->options.threads = 3;
}

static void own_allocator(test_world *w) {
    tangled(w);
    w->has_allocator = 1;
}

/** Drawn to a corner: after twenty sweeps L-BFGS helps. */
static void slow(test_world *w) {
    const int dim = w->mesh.dim;
    for (int64_t i = 0; i < w->mesh.n_nodes; i++) {
        double *x = w->box.coordinates + i * dim, inside = 1;
        for (int d = 0; d < dim; d++)
            inside *= 4 * x[d] / CELLS * (1 - x[d] / CELLS);
        for (int d = 0; d < dim; d++)
            x[d] = CELLS * pow(x[d] / CELLS, 1 + 1.3 * inside);
    }
    w->options.max_sweeps = 40;
    w->options.tolerance = 0;
}

static const struct special {
    const char *name;
    void (*prepare)(test_world *w);
} specials[] = {
    {"plain", plain},
    {"tangled", tangled},
    {"left alone", left_alone},
    {"mean ratio", mean_ratio},
    {"edge ratio", edge_ratio},
    {"Fletcher-Reeves", fletcher_reeves},
    {"min volume", min_volume},
    {"min volume fraction", min_volume_fraction},
    {"own min volumes", own_min_volumes},
    {"tangled, min volume", tangled_min_volume},
    {"bounds", bounds},
    {"floats", floats},
    {"rounded", rounded},
    {"worst ratio", worst_ratio},
    {"worst angle", worst_angle},
    {"only worse", only_worse},
    {"only worse, tangled", only_worse_tangled},
    {"neighbours", neighbours},
    {"around", around},
    {"around known elements", around_known_elements},
    {"other layout", other_layout},
    {"Laplacian", laplacian},
    {"area Laplacian", area_laplacian},
    {"length Laplacian", length_laplacian},
    {"sliding", sliding},
    {"on surface", on_surface},
    {"periodic", periodic},
    {"targets", targets},
    {"sizes", sizes},
    {"metric", metric},
    {"callbacks", callbacks},
    {"threads", threads},
    {"own allocator", own_allocator},
    {"slow", slow},
};
enum { N_SPECIALS = sizeof specials / sizeof *specials };

int test_world_count(void) {
    return N_SPECIALS;
}

void test_world_create(test_world *w, int dim, int number) {
    const struct special *special = &specials[number];
    *w = (test_world){.name = special->name};
    test_mesh_box(&w->box, dim, CELLS);
    if (special->prepare != slow)
        test_mesh_perturb(&w->box, 0.14, 77);
    w->mesh = w->box.mesh;
    w->n_doubles = w->mesh.n_nodes * dim;
    planish_options_init(&w->options);
    w->options.threads = 1;
    w->options.max_sweeps = SWEEPS;
    special->prepare(w);
}

void test_world_destroy(test_world *w) {
    for (int i = 0; i < w->n_owned; i++)
        free(w->owned[i]);
    test_mesh_destroy(&w->box);
}
