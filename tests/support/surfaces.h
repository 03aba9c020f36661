/* surfaces: meshes of triangles in space whose true surface is known: spheres, tori, cylinders, tees,
 * boxes with fillets, prisms. Nodes are on the surface, those inside of pieces at random. And what every shape
 * promises.
 */
#ifndef TEST_SUPPORT_SURFACES_H
#define TEST_SUPPORT_SURFACES_H

#include "shape/curved.h"

/** A mesh of triangles that owns its arrays. */
typedef struct test_surface {
    planish_mesh mesh; /* cells is &cells: a test_surface is not copied */
    planish_cells cells;
    int64_t n_nodes, n_facets;
    double (*x)[3];      /* [n_nodes] */
    int32_t (*facet)[3]; /* [n_facets], those of a piece one after the other */
    int32_t *piece;      /* [n_facets] the map that each is of */
    int64_t *offset;
    uint8_t *type;
} test_surface;

/** Where a piece has the point of parameters u and v, 0 to 1. */
typedef void test_map(int piece, double u, double v, double x[3]);

/** Make a surface of pieces, grids of nu times nv squares that are cut in two; equal points become one
 *  node, triangles with a node twice are left out. Inner nodes of pieces are moved by up to jitter squares,
 *  and diagonals are drawn, by seed. */
void test_surface_create(test_surface *surface, int n_pieces, test_map *map, int nu, int nv,
                         double jitter, unsigned seed);

void test_surface_destroy(test_surface *surface);

/** Pieces of: a sphere of radius 1 (6); a torus of radii 1 and 0.3 (1); a cylinder of radius 0.5 and height 2
 *  (side, bottom, top: nu around); a cylinder on the side of another one (2: nu around); a box with
 *  fillets (6); a prism (3 test_prism_sides: sides, then those of bottom and top). */
test_map test_sphere_map, test_torus_map, test_cylinder_map, test_tee_map, test_fillet_map,
    test_prism_map;

extern int test_prism_sides;

/** A known surface at a size, and its features: nu and nv times a size of squares for each piece. */
typedef struct known_surface {
    const char *name;
    test_map *map;
    int n_pieces, nu, nv;
    int n_rims; /* times nu: feature edges */
    int n_patches;
} known_surface;

enum { N_KNOWN_SURFACES = 5 };
extern const known_surface KNOWN_SURFACES[N_KNOWN_SURFACES];

/** Make a known surface. */
void test_surface_known(test_surface *surface, int k, int size, double jitter, unsigned seed);

/** A shape, and what is said of it. */
typedef struct made_shape {
    planish_shape *s;
    planish_shape_info info;
} made_shape;

/** Make a shape; the test fails if that fails. */
made_shape test_shape_make(const planish_mesh *mesh, const planish_surface *tags, int threads);

/** Expect what every shape promises, and the numbers of classes. */
void test_shape_expect(const made_shape *made);

#endif
