/* random_meshes: small meshes of all kinds, drawn at random. */
#include "support/random_meshes.h"

#include "quality/certificate.h"
#include "support/delaunay.h"
#include "support/effort.h"
#include "support/facets.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void *checked(void *memory) {
    if (!memory)
        abort();
    return memory;
}

static int chance(uint64_t *state, double probability) {
    return random_unit(state) < probability;
}

/* ---- shapes -------------------------------------------------------------------------------- */

/** A random coordinate on the grid. */
static int32_t draw_place(random_shape shape, uint64_t *state) {
    enum { LATTICE = DELAUNAY_GRID / 4 };
    double x = random_unit(state);
    if (shape == RANDOM_GRADED)
        x = x * x * x;
    const int32_t place = (int32_t)(x * (DELAUNAY_GRID + 1));
    return shape == RANDOM_LATTICE ? (place + LATTICE / 2) / LATTICE * LATTICE : place;
}

/** Insert a point, and with it those on the opposite sides if that is asked for. */
static void insert(delaunay *d, const random_choice *c, int32_t *point, int axis) {
    if (axis == c->dim) {
        delaunay_insert(d, point);
        return;
    }
    const int32_t x = point[axis];
    insert(d, c, point, axis + 1);
    if (c->is_periodic && (x == 0 || x == DELAUNAY_GRID)) {
        point[axis] = DELAUNAY_GRID - x;
        insert(d, c, point, axis + 1);
        point[axis] = x;
    }
}

static void make_delaunay(test_mesh *mesh, const random_choice *c, uint64_t *state) {
    delaunay d;
    delaunay_begin(&d, c->dim);
    for (int i = 0; i < 4 * c->n_points && d.n_points < c->n_points; i++) {
        int32_t point[3] = {0};
        for (int k = 0; k < c->dim; k++) {
            point[k] = draw_place(c->shape, state);
            if (chance(state, 0.15))
                point[k] = chance(state, 0.5) ? 0 : DELAUNAY_GRID;
        }
        insert(&d, c, point, 0);
    }
    delaunay_take(&d, mesh);
    delaunay_end(&d);
}

static void make_box(test_mesh *mesh, const random_choice *c) {
    const double cells = c->dim == 3 ? cbrt(c->n_points) : sqrt(c->n_points);
    const int n = cells < 3 ? 2 : (int)cells - 1;
    test_mesh_box(mesh, c->dim, n);
    test_mesh_transform(mesh, 1.0 / n, 0);
}

/** One element, or its star around a node in its middle. */
static void make_one(test_mesh *mesh, int dim, uint64_t *state) {
    static const double x[5][3] = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0.25, 1}};
    static const int32_t one[4] = {0, 1, 2, 3};
    const int n = chance(state, 0.5) ? 1 : dim + 1;
    double places[5 * 3];
    int32_t elements[4 * 4];
    for (int i = 0; i <= dim + 1; i++)
        for (int d = 0; d < dim; d++)
            places[i * dim + d] = i <= dim ? x[i][d] : random_between(state, 0.25, 0.3);
    places[(dim + 1) * dim] += 0.2;
    for (int i = 0; i < n; i++)
        for (int j = 0; j <= dim; j++)
            elements[i * (dim + 1) + j] = n > 1 && i == j ? dim + 1 : one[j];
    test_mesh_create(mesh, dim, dim + 2, places, n, elements);
}

static void make_shape(test_mesh *mesh, const random_choice *c, uint64_t *state) {
    if (c->shape == RANDOM_BOX)
        make_box(mesh, c);
    else if (c->shape == RANDOM_ONE)
        make_one(mesh, c->dim, state);
    else if (c->shape == RANDOM_GARBAGE)
        test_mesh_garbage(mesh, c->dim, c->n_points, 2 * c->n_points, (unsigned)random_bits(state));
    else
        make_delaunay(mesh, c, state);
}

/* ---- periodic nodes ------------------------------------------------------------------------ */

/** Nodes of opposite sides of the unit box: they differ by 1 in one coordinate. */
static int is_pair(const test_mesh *mesh, int64_t a, int64_t b) {
    const int dim = mesh->mesh.dim;
    int across = 0, same = 0;
    for (int d = 0; d < dim; d++) {
        const double x = mesh->coordinates[a * dim + d], y = mesh->coordinates[b * dim + d];
        across += x == 0 && y == 1;
        same += x == y;
    }
    return across == 1 && same == dim - 1;
}

static void find_pairs(random_mesh *mesh) {
    const int64_t n = mesh->base.mesh.n_nodes;
    mesh->periodic = checked(malloc((size_t)(n * 3) * 2 * sizeof *mesh->periodic + 1));
    for (int64_t a = 0; a < n; a++)
        for (int64_t b = 0; b < n; b++)
            if (is_pair(&mesh->base, a, b)) {
                mesh->periodic[2 * mesh->n_periodic] = (int32_t)a;
                mesh->periodic[2 * mesh->n_periodic++ + 1] = (int32_t)b;
            }
}

/* ---- bad elements -------------------------------------------------------------------------- */

/** Whether all elements of a node are positive. */
static int is_valid_around(const test_mesh *mesh, int64_t node) {
    const int dim = mesh->mesh.dim, corners = dim + 1;
    for (int64_t i = 0; i < mesh->mesh.n_elements; i++) {
        const double *x[4];
        int has = 0;
        for (int j = 0; j < corners; j++) {
            has |= mesh->elements[i * corners + j] == node;
            x[j] = mesh->coordinates + (int64_t)mesh->elements[i * corners + j] * dim;
        }
        if (has && pl_measure_sign(dim, x) <= 0)
            return 0;
    }
    return 1;
}

/** Move a node by way; back if that is not valid. */
static void try_move(test_mesh *mesh, int64_t node, const double *way) {
    double *x = mesh->coordinates + node * mesh->mesh.dim, before[3];
    const size_t size = (size_t)mesh->mesh.dim * sizeof *x;
    memcpy(before, x, size);
    for (int d = 0; d < mesh->mesh.dim; d++)
        x[d] += way[d];
    if (!is_valid_around(mesh, node))
        memcpy(x, before, size);
}

/** Move the inner nodes by about amount, valid as before. */
static void shake(test_mesh *mesh, const uint8_t *is_inner, double amount, uint64_t *state) {
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        double way[3];
        for (int d = 0; d < mesh->mesh.dim; d++)
            way[d] = random_between(state, -amount, amount);
        if (is_inner[i])
            try_move(mesh, i, way);
    }
}

/** Move inner nodes as near to flat elements as random steps of all sizes can. */
static void spoil(test_mesh *mesh, const uint8_t *is_inner, uint64_t *state) {
    enum { STEPS = 60 };
    for (int64_t i = 0; i < mesh->mesh.n_nodes; i++) {
        double to[3], step = random_between(state, 0.05, 0.5);
        for (int d = 0; d < mesh->mesh.dim; d++)
            to[d] = random_between(state, -1, 1);
        for (int k = 0; is_inner[i] && k < STEPS; k++, step *= 0.8) {
            const double way[3] = {to[0] * step, to[1] * step,
                                   mesh->mesh.dim == 3 ? to[2] * step : 0};
            try_move(mesh, i, way);
        }
    }
}

static void make_bad(test_mesh *mesh, const random_choice *c, const uint8_t *is_inner,
                     uint64_t *state) {
    const double edge = 1 / fmax(1, pow(c->n_points, 1.0 / c->dim));
    if (c->shape == RANDOM_BOX)
        shake(mesh, is_inner, random_unit(state) * edge, state);
    if (c->shape == RANDOM_LATTICE)
        shake(mesh, is_inner, pow(10, random_between(state, -9, -2)), state);
    if (c->shape == RANDOM_SPOILED)
        spoil(mesh, is_inner, state);
    const double flat = pow(10, random_between(state, -6, -1));
    for (int64_t i = 0; c->shape == RANDOM_STRETCHED && i < mesh->mesh.n_nodes; i++)
        mesh->coordinates[i * c->dim] *= flat;
}

/* ---- torn meshes --------------------------------------------------------------------------- */

/** Take out the elements in a ball, or some. At least one is left. */
static void cut(test_mesh *mesh, random_cut how, uint64_t *state) {
    const int dim = mesh->mesh.dim, corners = dim + 1;
    const double radius = random_between(state, 0.1, 0.4), part = random_between(state, 0.02, 0.4);
    const int64_t m = mesh->mesh.n_elements;
    double centre[3];
    int64_t n = 0;
    for (int d = 0; d < dim; d++)
        centre[d] = random_unit(state);
    for (int64_t i = 0; i < m; i++) {
        const double *x = mesh->coordinates + (int64_t)mesh->elements[i * corners] * dim;
        double far = 0;
        for (int d = 0; d < dim; d++)
            far += (x[d] - centre[d]) * (x[d] - centre[d]);
        const int out = how == RANDOM_CAVITY ? far < radius * radius : chance(state, part);
        if (out && n + m - i > 1)
            continue;
        memmove(mesh->elements + n++ * corners, mesh->elements + i * corners,
                (size_t)corners * sizeof *mesh->elements);
    }
    mesh->mesh.n_elements = n;
}

/** A node of an element, an inner one if there is any and it is wanted. */
static int32_t node_of_part(const test_mesh *mesh, int64_t begin, int64_t end,
                            const uint8_t *is_inner, int inner, uint64_t *state) {
    const int corners = mesh->mesh.dim + 1;
    int32_t node = mesh->elements[begin * corners];
    for (int i = 0; i < 100; i++) {
        node = mesh->elements[random_below(state, (end - begin) * corners) + begin * corners];
        if (is_inner[node] == inner)
            break;
    }
    return node;
}

/** Put the mesh a second time beside it; both may have a node, or an edge, in common. */
static void add_part(test_mesh *mesh, random_parts how, uint64_t *state) {
    const int64_t n = mesh->mesh.n_nodes, m = mesh->mesh.n_elements;
    test_mesh other;
    test_mesh_create(&other, mesh->mesh.dim, n, mesh->coordinates, m, mesh->elements);
    test_mesh_append(mesh, &other, 1.25);
    test_mesh_destroy(&other);
    uint8_t *is_inner = checked(malloc((size_t)mesh->mesh.n_nodes));
    test_inside(&mesh->mesh, NULL, is_inner);
    const int inner = how == RANDOM_AT_INNER_NODE;
    const int32_t a = node_of_part(mesh, 0, m, is_inner, inner, state);
    const int32_t b = node_of_part(mesh, m, 2 * m, is_inner, 0, state);
    free(is_inner);
    if (how != RANDOM_APART)
        test_mesh_join(mesh, a, b);
    if (how == RANDOM_AT_EDGE && mesh->mesh.dim == 3) {
        const int32_t c = mesh->elements[random_below(state, m) * 4];
        const int32_t d = mesh->elements[(m + random_below(state, m)) * 4];
        if (a != c && d != a)
            test_mesh_join(mesh, c, d);
    }
}

/** Elements twice, in another order; or with a facet of another one and a node from anywhere. */
static void add_extra(test_mesh *mesh, random_extra what, uint64_t *state) {
    const int corners = mesh->mesh.dim + 1;
    const int64_t m = mesh->mesh.n_elements, more = 1 + random_below(state, 3);
    const size_t bytes = (size_t)((m + more) * corners) * sizeof *mesh->elements;
    mesh->elements = checked(realloc(mesh->elements, bytes));
    mesh->mesh.elements = mesh->elements;
    for (int64_t i = 0; i < more; i++) {
        int32_t *e = mesh->elements + (m + i) * corners;
        memcpy(e, mesh->elements + random_below(state, m) * corners, (size_t)corners * sizeof *e);
        const int32_t node = (int32_t)random_below(state, mesh->mesh.n_nodes);
        int has = 0;
        for (int j = 0; j < corners; j++)
            has |= e[j] == node;
        if (what == RANDOM_THIRDS && !has)
            e[random_below(state, corners)] = node;
        mesh->mesh.n_elements++;
        if (chance(state, 0.5))
            test_mesh_reverse(mesh, m + i);
    }
}

/* ---- tangles ------------------------------------------------------------------------------- */

/** Which nodes a tangle moves: inner ones, and others if that is wanted. */
typedef struct victims {
    test_mesh *mesh;
    const uint8_t *is_inner;
    int all;
    double edge; /* about as long as edges are */
    uint64_t *state;
} victims;

static double *victim(const victims *v) {
    int64_t node = 0;
    for (int i = 0; i < 100; i++) {
        node = random_below(v->state, v->mesh->mesh.n_nodes);
        if (v->all || v->is_inner[node])
            return v->mesh->coordinates + node * v->mesh->mesh.dim;
    }
    return NULL;
}

static void move(const victims *v, double amount) {
    double *x = victim(v);
    for (int d = 0; x && d < v->mesh->mesh.dim; d++)
        x[d] += random_between(v->state, -amount, amount);
}

/** Bring a node to the place of another one of its elements, or into it if they swap. */
static void collapse(const victims *v, int swap) {
    const int dim = v->mesh->mesh.dim;
    const int32_t *e =
        v->mesh->elements + random_below(v->state, v->mesh->mesh.n_elements) * (dim + 1);
    const int32_t a = e[0], b = e[1 + random_below(v->state, dim)];
    double *x = v->mesh->coordinates + (int64_t)a * dim;
    double *y = v->mesh->coordinates + (int64_t)b * dim;
    if (!v->all && (!v->is_inner[a] || (swap && !v->is_inner[b])))
        return;
    for (int d = 0; d < dim; d++) {
        const double before = x[d];
        x[d] = y[d];
        y[d] = swap ? before : y[d];
    }
}

static void all_in_one(const victims *v) {
    const int dim = v->mesh->mesh.dim;
    const double *place = victim(v);
    for (int64_t i = 0; place && i < v->mesh->mesh.n_nodes; i++)
        if (v->all || v->is_inner[i])
            memmove(v->mesh->coordinates + i * dim, place, (size_t)dim * sizeof *place);
}

static void tangle(const victims *v, random_tangle how) {
    const int64_t n = 1 + random_below(v->state, 4);
    const int64_t many = v->mesh->mesh.n_nodes / 3 + 1;
    const double amount = v->edge * random_between(v->state, 0.3, 3);
    for (int64_t i = 0; i < (how == RANDOM_MOVED_MANY ? many : n); i++) {
        if (how == RANDOM_MOVED_FEW || how == RANDOM_MOVED_MANY)
            move(v, amount);
        if (how == RANDOM_COLLAPSED || how == RANDOM_SWAPPED)
            collapse(v, how == RANDOM_SWAPPED);
    }
    if (how == RANDOM_THROWN)
        move(v, 1000 * v->edge);
    if (how == RANDOM_ALL_IN_ONE)
        all_in_one(v);
}

/* ---- the mesh ------------------------------------------------------------------------------ */

/** Turn the mesh in the first two directions, scale and shift it. */
static void put(random_mesh *mesh, random_place place, uint64_t *state) {
    const int dim = mesh->base.mesh.dim;
    const double angle = random_between(state, 0, 6), c = cos(angle), s = sin(angle);
    static const double scales[] = {1, 1, 1, 0x1p-100, 1e30};
    mesh->size = scales[place];
    for (int64_t i = 0; place == RANDOM_ROTATED && i < mesh->base.mesh.n_nodes; i++) {
        double *x = mesh->base.coordinates + i * dim, before = x[0];
        x[0] = c * before - s * x[1];
        x[1] = s * before + c * x[1];
    }
    test_mesh_transform(&mesh->base, mesh->size, place == RANDOM_FAR ? 1e6 : 0);
}

void random_mesh_create(random_mesh *mesh, const random_choice *c, uint64_t *state) {
    test_mesh *base = &mesh->base;
    *mesh = (random_mesh){.size = 1};
    make_shape(base, c, state);
    if (c->is_periodic)
        find_pairs(mesh);
    uint8_t *is_inner = checked(calloc(2 * (size_t)base->mesh.n_nodes, 1));
    test_inside(&base->mesh, NULL, is_inner);
    make_bad(base, c, is_inner, state);
    if (c->cut != RANDOM_WHOLE)
        cut(base, c->cut, state);
    if (c->parts != RANDOM_ALONE)
        add_part(base, c->parts, state);
    if (c->extra != RANDOM_NOTHING)
        add_extra(base, c->extra, state);
    test_inside(&base->mesh, NULL, is_inner);
    const double edge = 1 / fmax(1, pow(c->n_points, 1.0 / c->dim));
    const victims v = {base, is_inner, !c->is_periodic && chance(state, 0.2), edge, state};
    tangle(&v, c->tangle);
    free(is_inner);
    if (c->order == RANDOM_MIXED)
        test_mesh_reverse_some(base, 3, (unsigned)random_bits(state));
    for (int64_t i = 0; c->order == RANDOM_NEGATIVE && i < base->mesh.n_elements; i++)
        test_mesh_reverse(base, i);
    put(mesh, c->place, state);
}

void random_mesh_destroy(random_mesh *mesh) {
    test_mesh_destroy(&mesh->base);
    free(mesh->periodic);
}

void random_mesh_to_floats(random_mesh *mesh) {
    const int64_t n = mesh->base.mesh.n_nodes * mesh->base.mesh.dim;
    for (int64_t i = 0; i < n; i++) {
        volatile float rounded = (float)mesh->base.coordinates[i];
        mesh->base.coordinates[i] = (double)rounded;
    }
}
