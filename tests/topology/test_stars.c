/* Tests of src/topology/stars.c. */
#include "topology/topology.h"

#include "base/memory.h"
#include "geometry/simplex.h"
#include "support/allocations.h"
#include "support/meshes.h"
#include "support/rings.h"

#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

/** A mesh with all that stars are made of; visits and inner numbers are in reverse. */
typedef struct fixture {
    test_mesh mesh;
    test_rings rings;
    int32_t *visit;     /* [n_free] */
    int32_t *number_of; /* [n_nodes] */
} fixture;

static void fixture_create(fixture *f, test_mesh mesh, int all) {
    f->mesh = mesh;
    test_rings_create(&f->rings, &mesh.mesh, all, 1);
    int64_t n = f->rings.rings.n_free;
    f->visit = malloc((size_t)n * sizeof *f->visit + 1);
    f->number_of = malloc((size_t)mesh.mesh.n_nodes * sizeof *f->number_of);
    assert_true(f->visit && f->number_of);
    for (int64_t i = 0, left = n; left > 0; i++)
        if (f->rings.node[i] >= 0)
            f->visit[--left] = (int32_t)i;
    for (int64_t i = 0; i < mesh.mesh.n_nodes; i++)
        f->number_of[i] = (int32_t)(mesh.mesh.n_nodes - 1 - i);
}

static void fixture_destroy(fixture *f) {
    test_rings_destroy(&f->rings);
    free(f->visit);
    free(f->number_of);
    test_mesh_destroy(&f->mesh);
}

static void *copy_of(const void *array, int64_t count, size_t size) {
    void *copy = pl_alloc(count, size);
    assert_non_null(copy);
    memcpy(copy, array, (size_t)count * size);
    return copy;
}

/** The fixture's rings again: making stars consumes them. */
static pl_rings copy_of_rings(const fixture *f) {
    pl_rings r = f->rings.rings;
    const int64_t n = r.n_rings,
                  bytes = r.link_offset[n] * pl_link_positions_kept(f->mesh.mesh.dim, 0);
    r.neighbour = copy_of(r.neighbour, r.offset[n], sizeof *r.neighbour);
    r.link.low = copy_of(r.link.low, bytes, 1);
    r.link.high = r.link.high ? copy_of(r.link.high, bytes, 1) : NULL;
    r.offset = copy_of(r.offset, n + 1, sizeof *r.offset);
    r.link_offset = copy_of(r.link_offset, n + 1, sizeof *r.link_offset);
    return r;
}

/** Like pl_stars_create; permitted: allocations, or -1. */
static int try_to_create(fixture *f, int threads, int permitted, pl_stars *stars) {
    pl_rings rings = copy_of_rings(f);
    int32_t *star_of = malloc((size_t)rings.n_rings * sizeof *star_of + 1);
    assert_non_null(star_of);
    for (int64_t r = 0; r < rings.n_rings; r++)
        star_of[r] = -1;
    for (int32_t s = 0; s < rings.n_free; s++)
        star_of[f->visit[s]] = s;
    allocations_permit(permitted);
    int status = pl_stars_create(&f->mesh.mesh, &f->rings.incidence, NULL, &rings, f->rings.node,
                                 star_of, f->number_of, threads, stars, NULL);
    allocations_permit(-1);
    free(star_of);
    assert_null(rings.neighbour);
    assert_null(rings.link.low);
    return status;
}

static int create(fixture *f, int threads, pl_stars *stars) {
    return try_to_create(f, threads, -1, stars);
}

/** The rings are those given; every link facet has the other nodes of its element, and is oriented
 *  as the element is. */
static void check_star(const fixture *f, const pl_stars *stars, int64_t s) {
    const planish_mesh *mesh = &f->mesh.mesh;
    int dim = mesh->dim;
    int32_t r = f->visit[s], node = f->rings.node[r];
    const int32_t *ring = stars->ring + stars->ring_offset[s];
    const int32_t *neighbour = f->rings.rings.neighbour + f->rings.rings.offset[r];
    int64_t n_ring = stars->ring_offset[s + 1] - stars->ring_offset[s];
    int64_t first = f->rings.incidence.offset[node];
    int64_t n_link = f->rings.incidence.offset[node + 1] - first;
    assert_int_equal(n_ring, f->rings.rings.offset[r + 1] - f->rings.rings.offset[r]);
    for (int64_t i = 0; i < n_ring; i++)
        assert_int_equal(ring[i], f->number_of[neighbour[i]]);
    assert_int_equal(stars->link_offset[s + 1] - stars->link_offset[s], n_link);
    const pl_link link = pl_link_at(&stars->link, pl_link_positions(dim, stars->form != NULL),
                                    stars->link_offset[s]);
    for (int64_t i = 0; i < n_link; i++) {
        uint16_t facet[3];
        for (int d = 0; d < dim; d++)
            facet[d] = pl_link_get(&link, i * dim + d);
        int32_t element = f->rings.incidence.element[first + i];
        const double *vertex[4] = {0}, *own[4] = {0};
        /* 3-D: (p0, node, p1, p2), 2-D: (node, p0, p1) */
        for (int d = 0; d < dim; d++) {
            assert_true(facet[d] < n_ring);
            int place = dim == 3 && d == 0 ? 0 : d + 1;
            vertex[place] = mesh->coordinates + (int64_t)neighbour[facet[d]] * dim;
        }
        vertex[dim - 2] = mesh->coordinates + (int64_t)node * dim;
        for (int j = 0; j <= dim; j++)
            own[j] = mesh->coordinates + (int64_t)mesh->elements[element * (dim + 1) + j] * dim;
        double seen = pl_simplex_measure(dim, vertex), measure = pl_simplex_measure(dim, own);
        measure *= f->rings.sign ? f->rings.sign[element] : 1;
        assert_true(measure != 0);
        assert_true(fabs(seen / measure - 1) < 1e-9);
    }
}

/** Every edge of a closed link of triangles has two nodes, and they are those of the facets. */
static void check_edges(const pl_stars *stars, int64_t s) {
    const int64_t n = stars->link_offset[s + 1] - stars->link_offset[s];
    const pl_link link =
        pl_link_at(&stars->link, pl_link_positions(3, stars->form != NULL), stars->link_offset[s]);
    int *facets = calloc((size_t)n * 2 + 1, sizeof *facets);
    assert_non_null(facets);
    for (int64_t i = 0; i < 3 * n; i++) {
        int p = pl_link_get(&link, i), q = pl_link_get(&link, i % 3 < 2 ? i + 1 : i - 2);
        int edge = pl_link_get(&link, 3 * n + i);
        assert_true(edge < pl_link_edges(3, n));
        int a = pl_link_get(&link, 6 * n + 2 * edge), b = pl_link_get(&link, 6 * n + 2 * edge + 1);
        assert_true((a == p && b == q) || (a == q && b == p));
        facets[edge]++;
    }
    for (int64_t i = 0; i < pl_link_edges(3, n); i++)
        assert_int_equal(facets[i], 2);
    free(facets);
}

/** The positions that two stars say. */
static void check_same_links(const pl_stars *stars, const pl_stars *other, int dim) {
    for (int64_t s = 0; s < stars->n_stars; s++) {
        const int64_t first = stars->link_offset[s], n = stars->link_offset[s + 1] - first;
        const pl_link a =
            pl_link_at(&stars->link, pl_link_positions(dim, stars->form != NULL), first);
        const pl_link b =
            pl_link_at(&other->link, pl_link_positions(dim, stars->form != NULL), first);
        const size_t bytes = (size_t)(n * pl_link_positions(dim, stars->form != NULL));
        assert_memory_equal(a.low, b.low, bytes);
        assert_int_equal(!a.high, !b.high);
        if (a.high)
            assert_memory_equal(a.high, b.high, bytes);
    }
}

static void check(fixture *f) {
    pl_stars stars;
    assert_int_equal(create(f, 1, &stars), PLANISH_OK);
    assert_int_equal(stars.n_stars, f->rings.rings.n_free);
    int64_t max_ring = 0, max_link = 0;
    for (int64_t s = 0; s < stars.n_stars; s++) {
        int64_t n_ring = stars.ring_offset[s + 1] - stars.ring_offset[s];
        int64_t n_link = stars.link_offset[s + 1] - stars.link_offset[s];
        max_ring = n_ring > max_ring ? n_ring : max_ring;
        max_link = n_link > max_link ? n_link : max_link;
        check_star(f, &stars, s);
        if (f->mesh.mesh.dim == 3)
            check_edges(&stars, s);
    }
    assert_int_equal(stars.max_ring, max_ring);
    assert_int_equal(stars.max_link, max_link);
    for (int threads = 2; threads <= 5; threads++) {
        pl_stars other;
        assert_int_equal(create(f, threads, &other), PLANISH_OK);
        size_t n = (size_t)stars.n_stars;
        assert_memory_equal(stars.ring_offset, other.ring_offset, (n + 1) * sizeof(int64_t));
        assert_memory_equal(stars.link_offset, other.link_offset, (n + 1) * sizeof(int64_t));
        assert_memory_equal(stars.ring, other.ring, (size_t)stars.ring_offset[n] * 4);
        check_same_links(&stars, &other, f->mesh.mesh.dim);
        assert_int_equal(stars.max_ring, other.max_ring);
        assert_int_equal(stars.max_link, other.max_link);
        pl_stars_destroy(&other);
    }
    pl_stars_destroy(&stars);
}

static void boxes(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (unsigned every = 0; every < 4; every++) {
            test_mesh box;
            fixture f;
            test_mesh_box(&box, dim, dim == 3 ? 9 : 30);
            test_mesh_perturb(&box, 0.15, 1);
            test_mesh_renumber(&box, 3, NULL);
            if (every)
                test_mesh_reverse_some(&box, every, 4); /* 1: all of them */
            fixture_create(&f, box, every % 2 == 0);    /* all: not every ring has a node */
            check(&f);
            fixture_destroy(&f);
        }
}

/** By hand: four triangles around node 4, one of them in the other order. */
static void a_square(void **state) {
    (void)state;
    const double x[] = {0, 0, 2, 0, 2, 2, 0, 2, 1, 1};
    const int32_t elements[] = {4, 0, 1, 4, 2, 1, 2, 3, 4, 3, 4, 0};
    const int32_t ring[] = {4, 3, 2, 1};
    const uint8_t link[] = {0, 1, 1, 2, 2, 3, 3, 0};
    test_mesh mesh;
    fixture f;
    pl_stars stars;
    test_mesh_create(&mesh, 2, 5, x, 4, elements);
    test_mesh_reverse(&mesh, 3);
    fixture_create(&f, mesh, 0);
    assert_int_equal(create(&f, 1, &stars), PLANISH_OK);
    assert_int_equal(stars.n_stars, 1);
    assert_int_equal(stars.max_ring, 4);
    assert_int_equal(stars.max_link, 4);
    assert_memory_equal(stars.ring, ring, sizeof ring);
    assert_memory_equal(stars.link.low, link, sizeof link);
    assert_null(stars.link.high);
    pl_stars_destroy(&stars);
    fixture_destroy(&f);
}

/** Small ones and large ones, with positions of one byte and of two. */
static void links_of_any_size(void **state) {
    (void)state;
    const int32_t around[] = {3, 9, 61, 62, 63, 64, 84, 85, 86, 200};
    for (size_t i = 0; i < sizeof around / sizeof *around; i++) {
        test_mesh mesh;
        fixture f;
        test_mesh_double_pyramid(&mesh, around[i]);
        fixture_create(&f, mesh, 1);
        assert_int_equal(f.rings.rings.n_free, 1);
        check(&f);
        fixture_destroy(&f);
    }
}

/** A small star beside a large one has high bytes, too. */
static void small_beside_large(void **state) {
    (void)state;
    test_mesh mesh, small;
    fixture f;
    pl_stars stars;
    test_mesh_double_pyramid(&mesh, 100);
    test_mesh_double_pyramid(&small, 6);
    test_mesh_append(&mesh, &small, 5);
    fixture_create(&f, mesh, 1);
    assert_int_equal(f.rings.rings.n_free, 2);
    check(&f);
    assert_int_equal(create(&f, 1, &stars), PLANISH_OK);
    assert_non_null(stars.link.high);
    pl_stars_destroy(&stars);
    fixture_destroy(&f);
    test_mesh_destroy(&small);
}

/** Nor does a large star on the boundary make all links large. */
static void small_beside_an_open_large_one(void **state) {
    (void)state;
    test_mesh large, open, small;
    fixture f;
    pl_stars stars;
    test_mesh_double_pyramid(&large, 100);
    test_mesh_create(&open, 3, large.mesh.n_nodes, large.coordinates, large.mesh.n_elements - 1,
                     large.elements);
    test_mesh_double_pyramid(&small, 6);
    test_mesh_append(&open, &small, 5);
    fixture_create(&f, open, 1);
    assert_int_equal(f.rings.rings.n_free, 1);
    assert_null(f.rings.rings.link.high);
    check(&f);
    assert_int_equal(create(&f, 1, &stars), PLANISH_OK);
    assert_null(stars.link.high);
    pl_stars_destroy(&stars);
    fixture_destroy(&f);
    test_mesh_destroy(&large);
    test_mesh_destroy(&small);
}

/** Two spheres around one node. */
static void two_spheres(void **state) {
    (void)state;
    test_mesh mesh, other;
    fixture f;
    test_mesh_double_pyramid(&mesh, 7);
    test_mesh_double_pyramid(&other, 6);
    const int32_t nodes = (int32_t)mesh.mesh.n_nodes;
    test_mesh_append(&mesh, &other, 0);
    test_mesh_join(&mesh, 0, nodes);
    fixture_create(&f, mesh, 1);
    assert_int_equal(f.rings.rings.n_free, 1);
    check(&f);
    fixture_destroy(&f);
    test_mesh_destroy(&other);
}

/** Rings of all nodes, links of those on the boundary open. */
static void fixture_open(fixture *f) {
    const int64_t n = f->mesh.mesh.n_nodes;
    pl_rings_destroy(&f->rings.rings);
    for (int32_t i = 0; i < n; i++) {
        f->rings.is_free[i] = 1;
        f->rings.node[i] = i;
    }
    assert_int_equal(pl_rings_create(&f->mesh.mesh, &f->rings.incidence, f->rings.sign, NULL,
                                     f->rings.is_free, f->rings.node, n, 1, 1, &f->rings.rings,
                                     NULL),
                     PLANISH_OK);
    assert_int_equal(f->rings.rings.n_free, n);
    free(f->visit);
    f->visit = malloc((size_t)n * sizeof *f->visit);
    assert_non_null(f->visit);
    for (int32_t i = 0; i < n; i++) /* no star is beside the one that is made next */
        f->visit[(int64_t)i * 7 % n] = i;
}

/** Open links, which have more edges than there is room for, beside closed ones: these have all
 *  their edges, whichever is made first. */
static void open_links(void **state) {
    (void)state;
    test_mesh box, dented;
    fixture f;
    pl_stars stars;
    test_mesh_box(&box, 3, 4); /* of 125 nodes, which 7 does not divide */
    test_mesh_perturb(&box, 0.15, 1);
    test_mesh_create(&dented, 3, box.mesh.n_nodes, box.coordinates, box.mesh.n_elements - 1,
                     box.elements);
    test_mesh_destroy(&box);
    fixture_create(&f, dented, 1);
    uint8_t *closed = malloc((size_t)f.mesh.mesh.n_nodes);
    assert_non_null(closed);
    for (int64_t i = 0; i < f.mesh.mesh.n_nodes; i++)
        closed[i] = f.rings.node[i] >= 0;
    fixture_open(&f);
    int64_t n_closed = 0, n_odd = 0;
    assert_int_equal(create(&f, 1, &stars), PLANISH_OK);
    for (int64_t s = 0; s < stars.n_stars; s++) {
        check_star(&f, &stars, s);
        n_odd += (stars.link_offset[s + 1] - stars.link_offset[s]) % 2;
        n_closed += closed[f.visit[s]];
        if (closed[f.visit[s]])
            check_edges(&stars, s);
    }
    assert_true(n_closed > 0 && n_closed < stars.n_stars);
    assert_true(n_odd > 0);
    pl_stars_destroy(&stars);
    free(closed);
    fixture_destroy(&f);
}

static void no_star(void **state) {
    (void)state;
    test_mesh box;
    fixture f;
    pl_stars stars;
    test_mesh_box(&box, 3, 1);
    fixture_create(&f, box, 0);
    assert_int_equal(create(&f, 2, &stars), PLANISH_OK);
    assert_int_equal(stars.n_stars, 0);
    assert_int_equal(stars.ring_offset[0], 0);
    assert_int_equal(stars.link_offset[0], 0);
    assert_int_equal(stars.max_ring, 0);
    pl_stars_destroy(&stars);
    fixture_destroy(&f);
}

static void survives_without_memory(void **state) {
    (void)state;
    test_mesh box;
    fixture f;
    pl_stars stars;
    test_mesh_box(&box, 3, 4);
    fixture_create(&f, box, 0);
    int status = PLANISH_ERROR_MEMORY, permitted = 0;
    for (; status; permitted++) {
        status = try_to_create(&f, 1, permitted, &stars);
        assert_true(status == PLANISH_OK || status == PLANISH_ERROR_MEMORY);
    }
    assert_true(permitted > 4);
    pl_stars_destroy(&stars);
    fixture_destroy(&f);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(boxes),
        cmocka_unit_test(a_square),
        cmocka_unit_test(no_star),
        cmocka_unit_test(links_of_any_size),
        cmocka_unit_test(small_beside_large),
        cmocka_unit_test(small_beside_an_open_large_one),
        cmocka_unit_test(two_spheres),
        cmocka_unit_test(open_links),
        cmocka_unit_test(survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
