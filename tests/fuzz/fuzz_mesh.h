/* fuzz_mesh: the mesh that bytes decide on, with all that planish_mesh may have: any connectivity,
 * coordinates in any order of memory, constraints, periodic pairs, minimum volumes, neighbours.
 * Each array is a block of its own that ends where the array does.
 */
#ifndef FUZZ_MESH_H
#define FUZZ_MESH_H

#include "fuzz_bytes.h"

#include "support/meshes.h"

#include <planish/planish.h>

enum { FUZZ_MOST_BLOCKS = 24 };

typedef struct fuzz_mesh {
    planish_mesh mesh;
    void *block[FUZZ_MOST_BLOCKS]; /* all that belongs to it */
    int n_blocks;
    int64_t n_coordinates; /* doubles from the first coordinate to the last, gaps included */
} fuzz_mesh;

/** n zeroed items that are released with the mesh. */
static inline void *fuzz_block(fuzz_mesh *m, int64_t n, size_t size) {
    void *block = n > 0 ? calloc((size_t)n, size) : malloc(1);
    fuzz_require(block && m->n_blocks < FUZZ_MOST_BLOCKS, "memory");
    m->block[m->n_blocks++] = block;
    return block;
}

static inline void fuzz_mesh_release(fuzz_mesh *m) {
    while (m->n_blocks > 0)
        free(m->block[--m->n_blocks]);
}

/** Where coordinate d of node i is. */
static inline int64_t fuzz_at(const planish_mesh *mesh, int64_t i, int d) {
    const int64_t step = mesh->node_stride ? mesh->node_stride : mesh->dim;
    const int64_t apart = mesh->component_stride ? mesh->component_stride : 1;
    return i * step + d * apart;
}

/* ---- connectivity --------------------------------------------------------------------------- */

/** Elements of any nodes, which may be there twice. */
static inline void fuzz_any_elements(fuzz_bytes *bytes, int dim, test_mesh *mesh) {
    int32_t elements[4 * 40];
    const int n = 1 + take_below(bytes, 40), n_nodes = 1 + take_below(bytes, 30);
    for (int i = 0; i < n * (dim + 1); i++)
        elements[i] = take_below(bytes, n_nodes);
    test_mesh_create(mesh, dim, n_nodes, NULL, n, elements);
}

static inline void fuzz_join_boxes(fuzz_bytes *bytes, int dim, test_mesh *mesh) {
    test_mesh other;
    test_mesh_box(mesh, dim, 1 + take_below(bytes, 2));
    test_mesh_box(&other, dim, 1 + take_below(bytes, 2));
    const int64_t first = mesh->mesh.n_nodes, n = other.mesh.n_nodes;
    test_mesh_append(mesh, &other, take_below(bytes, 2));
    const int32_t a = (int32_t)(take_byte(bytes) % first);
    test_mesh_join(mesh, a, (int32_t)(first + take_byte(bytes) % n));
    test_mesh_destroy(&other);
}

static inline void fuzz_connect(fuzz_bytes *bytes, int dim, test_mesh *mesh) {
    switch (take_below(bytes, 6)) {
    case 0:
    case 1:
        test_mesh_box(mesh, dim, 1 + take_below(bytes, dim == 3 ? 3 : 5));
        break;
    case 2:
        fuzz_any_elements(bytes, dim, mesh);
        break;
    case 3: {
        const int n_nodes = dim + 1 + take_below(bytes, 24), n = 1 + take_below(bytes, 32);
        test_mesh_garbage(mesh, dim, n_nodes, n, take_byte(bytes));
        break;
    }
    case 4:
        fuzz_join_boxes(bytes, dim, mesh);
        break;
    default: /* 3-D */
        test_mesh_double_pyramid(mesh, 3 + take_below(bytes, 20));
    }
}

/** Spoil places and elements. */
static inline void fuzz_deform(fuzz_bytes *bytes, test_mesh *mesh) {
    const int64_t n = mesh->mesh.n_nodes * mesh->mesh.dim;
    const double amount = take_below(bytes, 8) / 20.0;
    test_mesh_perturb(mesh, amount, take_byte(bytes));
    for (int k = take_below(bytes, 16); k > 0 && n > 0; k--)
        take_change(bytes, mesh->coordinates, n);
    for (int k = take_below(bytes, 4); k > 0; k--)
        test_mesh_reverse(mesh, take_byte(bytes) % mesh->mesh.n_elements);
    if (take_chance(bytes, 8))
        test_mesh_reverse_some(mesh, 2, take_byte(bytes));
    if (take_chance(bytes, 8)) {
        const double scale = ldexp(1, 8 * (int8_t)take_byte(bytes));
        test_mesh_transform(mesh, scale, take_finite(bytes));
    }
    if (take_chance(bytes, 8))
        test_mesh_renumber(mesh, take_byte(bytes), NULL);
    if (take_chance(bytes, 32)) { /* a node that may not be there */
        const int64_t at = take_byte(bytes) % mesh->mesh.n_elements;
        mesh->elements[at] =
            (int32_t)(take_below(bytes, 2) ? mesh->mesh.n_nodes : take_bits(bytes));
    }
}

/* ---- forms of arrays ------------------------------------------------------------------------ */

/** Coordinates with gaps, or all x before all y, or strides that mean nothing. */
static inline void fuzz_lay_out(fuzz_bytes *bytes, fuzz_mesh *m, const double *dense) {
    planish_mesh *mesh = &m->mesh;
    const int form = take_below(bytes, 8);
    if (form == 1)
        mesh->node_stride = mesh->dim + take_below(bytes, 3);
    if (form == 2) {
        mesh->node_stride = 1 + take_below(bytes, 2);
        mesh->component_stride = mesh->node_stride * mesh->n_nodes + take_below(bytes, 2);
    }
    m->n_coordinates = mesh->n_nodes > 0 ? fuzz_at(mesh, mesh->n_nodes - 1, mesh->dim - 1) + 1 : 0;
    double *x = fuzz_block(m, m->n_coordinates, sizeof *x);
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        for (int d = 0; d < mesh->dim; d++)
            x[fuzz_at(mesh, i, d)] = dense[i * mesh->dim + d];
    mesh->coordinates = x;
    if (form == 7 && take_chance(bytes, 4))
        mesh->node_stride = take_integer(bytes) % mesh->dim; /* less than a node needs */
}

/** The element with the same facet as that without corner k, the last one; -1: none. */
static inline int64_t fuzz_neighbour(const test_mesh *from, int64_t element, int k) {
    const int corners = from->mesh.dim + 1;
    int64_t found = -1;
    for (int64_t e = 0; e < from->mesh.n_elements; e++) {
        int shared = 0;
        for (int i = 0; i < corners; i++)
            for (int j = 0; j < corners; j++)
                shared += i != k &&
                          from->elements[element * corners + i] == from->elements[e * corners + j];
        if (e != element && shared >= corners - 1)
            found = e;
    }
    return found;
}

/** Neighbours by facets; a few of them wrong. */
static inline void fuzz_add_neighbours(fuzz_bytes *bytes, fuzz_mesh *m, const test_mesh *from) {
    const int corners = m->mesh.dim + 1;
    const int64_t n = m->mesh.n_elements * corners;
    int64_t *wide = fuzz_block(m, n, sizeof *wide);
    int32_t *narrow = fuzz_block(m, n, sizeof *narrow);
    for (int64_t i = 0; i < n; i++)
        wide[i] = fuzz_neighbour(from, i / corners, (int)(i % corners));
    for (int k = take_chance(bytes, 4) ? take_below(bytes, 4) : 0; k > 0; k--) {
        const int64_t at = take_byte(bytes) % n;
        wide[at] = take_integer(bytes);
    }
    for (int64_t i = 0; i < n; i++)
        narrow[i] = (int32_t)wide[i];
    if (take_below(bytes, 2))
        m->mesh.neighbours = narrow;
    else
        m->mesh.neighbours64 = wide;
}

static inline void fuzz_add_elements(fuzz_bytes *bytes, fuzz_mesh *m, const test_mesh *from) {
    const int64_t n = m->mesh.n_elements * (m->mesh.dim + 1);
    int64_t *wide = fuzz_block(m, n, sizeof *wide);
    int32_t *narrow = fuzz_block(m, n, sizeof *narrow);
    for (int64_t i = 0; i < n; i++)
        wide[i] = narrow[i] = from->elements[i];
    const int form = take_below(bytes, 16);
    m->mesh.elements = form < 8 || form == 15 ? narrow : NULL; /* of both at once, an error */
    m->mesh.elements64 = form >= 8 ? wide : NULL;
}

/* ---- what nodes and elements are told ------------------------------------------------------- */

static inline void fuzz_constrain(fuzz_bytes *bytes, fuzz_mesh *m) {
    const int64_t n = m->mesh.n_nodes;
    const int most = take_below(bytes, 8);
    uint8_t *constraint = fuzz_block(m, n, 1);
    double *direction = fuzz_block(m, n * m->mesh.dim, sizeof *direction);
    for (int64_t i = 0; i < n && bytes->at < bytes->end; i++)
        constraint[i] = (uint8_t)take_below(bytes, most < 6 ? most + 1 : 5);
    for (int64_t i = 0; i < n * m->mesh.dim; i++)
        direction[i] = (double)(i % 3 == 0);
    for (int k = take_below(bytes, 8); k > 0 && n > 0; k--)
        take_change(bytes, direction, n * m->mesh.dim);
    m->mesh.constraint = constraint;
    m->mesh.direction = take_chance(bytes, 16) ? NULL : direction;
}

static inline void fuzz_pair(fuzz_bytes *bytes, fuzz_mesh *m) {
    const int n = take_below(bytes, 16);
    int32_t *pairs = fuzz_block(m, 2 * n, sizeof *pairs);
    for (int i = 0; i < 2 * n; i++)
        pairs[i] = (int32_t)take_integer(bytes);
    m->mesh.n_periodic = take_chance(bytes, 64) ? -1 : n;
    m->mesh.periodic = pairs;
}

static inline void fuzz_ask_volumes(fuzz_bytes *bytes, fuzz_mesh *m) {
    double *least = fuzz_block(m, m->mesh.n_elements, sizeof *least);
    const double usual = take_below(bytes, 4) / 16.0;
    for (int64_t i = 0; i < m->mesh.n_elements; i++)
        least[i] = usual;
    for (int k = take_below(bytes, 6); k > 0; k--)
        take_change(bytes, least, m->mesh.n_elements);
    m->mesh.min_volume = least;
}

/** Counts and dimensions that no mesh has; nothing may be read then. */
static inline void fuzz_miscount(fuzz_bytes *bytes, planish_mesh *mesh) {
    static const int64_t bad[] = {-1, INT64_MIN, INT64_MAX, (int64_t)INT32_MAX + 1};
    const int which = take_below(bytes, 4);
    if (which == 0)
        mesh->n_nodes = bad[take_below(bytes, 4)];
    else if (which == 1)
        mesh->n_elements = bad[take_below(bytes, 4)];
    else if (which == 2)
        mesh->dim = (int)take_integer(bytes);
    else
        mesh->coordinates = NULL;
}

static inline void fuzz_mesh_make(fuzz_bytes *bytes, fuzz_mesh *m) {
    test_mesh from;
    const int dim = 2 + take_below(bytes, 2);
    fuzz_connect(bytes, dim, &from);
    fuzz_deform(bytes, &from);
    *m = (fuzz_mesh){.mesh = from.mesh};
    fuzz_lay_out(bytes, m, from.coordinates);
    fuzz_add_elements(bytes, m, &from);
    const int more = take_byte(bytes);
    if (more & 1)
        fuzz_constrain(bytes, m);
    if ((more & 6) == 6)
        fuzz_pair(bytes, m);
    if ((more & 24) == 24)
        fuzz_ask_volumes(bytes, m);
    if ((more & 96) == 96)
        fuzz_add_neighbours(bytes, m, &from);
    test_mesh_destroy(&from);
    if (more == 128)
        fuzz_miscount(bytes, &m->mesh);
}

#endif
