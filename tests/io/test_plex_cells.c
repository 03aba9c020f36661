/* DMPlex: quadrilaterals, hexahedra, prisms and pyramids, bounded by nodes or by faces and edges, as
 * DMView of PETSc 3.18 has written them. */
#include "support/hdf5_builder.h"
#include "support/unit_elements.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#ifdef PL_HDF5

/* Sizes of cones, cones one after another, and how they are gone round (NULL: all 0). */

static const double quadrilaterals_places[] = {0, 0, 1, 0, 2, 0.5, 0, 1, 1, 1.25, 2, 1};

static const int flat_quadrilaterals_sizes[] = {4, 4, 0, 0, 0, 0, 0, 0};

static const int flat_quadrilaterals_cones[] = {2, 3, 6, 5, 7, 6, 3, 4};

static const int quadrilaterals_sizes[] = {4, 4, 0, 0, 0, 0, 0, 0, 2, 2, 2, 2, 2, 2, 2};

static const int quadrilaterals_cones[] = {8, 9, 10, 11, 12, 9, 13, 14, 2, 3, 3,
                                           6, 6, 5,  5,  2,  7, 6,  3,  4, 4, 7};

static const int quadrilaterals_turns[] = {0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0,
                                           0, 0, 0, 0, 0, 0,  0, 0, 0, 0, 0};

static const double solids_places[] = {0, 0, 0, 1, 0, 0, 1,    1, 0, 0, 1,   0,   0, 0,
                                       1, 1, 0, 1, 1, 1, 1.25, 0, 1, 1, 0.5, 0.5, 2};

static const int flat_solids_sizes[] = {8, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0};

static const int flat_solids_cones[] = {2, 5, 4, 3, 6, 7, 8, 9, 8, 7, 6, 9, 10};

static const int solids_sizes[] = {6, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 3, 3, 3, 4, 4, 4, 4,
                                   4, 4, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2};

static const int solids_cones[] = {15, 16, 17, 18, 19, 20, 16, 11, 12, 13, 14, 21, 22, 23, 24, 25,
                                   22, 26, 27, 25, 28, 23, 27, 29, 30, 31, 32, 26, 28, 21, 24, 32,
                                   33, 26, 34, 30, 35, 21, 36, 31, 36, 28, 33, 34, 24, 35, 29, 8,
                                   9,  9,  10, 10, 8,  9,  6,  6,  10, 6,  7,  7,  10, 7,  8,  2,
                                   5,  5,  4,  4,  3,  3,  2,  3,  7,  6,  2,  5,  9,  8,  4};

static const int solids_turns[] = {
    0, 0, 0, 0, 0,  0, -4, 0, 0,  0, 0,  0, 0,  0,  0,  0,  -1, 0,  0,  -1, 0, -1, -1, 0, 0, 0, 0,
    0, 0, 0, 0, -1, 0, -1, 0, -1, 0, -1, 0, -1, -1, -1, -1, -1, -1, -1, -1, 0, 0,  0,  0, 0, 0, 0,
    0, 0, 0, 0, 0,  0, 0,  0, 0,  0, 0,  0, 0,  0,  0,  0,  0,  0,  0,  0,  0, 0,  0,  0, 0};

static const double prisms_places[] = {0, 0, 0,    1, 0, 0, 0, 1, 0, 0, 0, 1,
                                       1, 0, 1.25, 0, 1, 1, 1, 1, 0, 1, 1, 1};

static const int flat_prisms_sizes[] = {6, 6, 0, 0, 0, 0, 0, 0, 0, 0};

static const int flat_prisms_cones[] = {2, 4, 3, 5, 6, 7, 4, 8, 3, 7, 6, 9};

static const int prisms_sizes[] = {5, 5, 0, 0, 0, 0, 0, 0, 0, 0, 3, 3, 3, 3, 4, 4, 4,
                                   4, 4, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2};

static const int prisms_cones[] = {
    10, 11, 14, 15, 16, 12, 13, 15, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 20, 23, 27, 28, 21, 29,
    22, 30, 20, 31, 23, 29, 19, 30, 24, 31, 26, 32, 27, 29, 25, 31, 28, 32, 2,  4,  4,  3,  3,  2,
    5,  6,  6,  7,  7,  5,  4,  8,  8,  3,  6,  9,  9,  7,  3,  6,  5,  2,  4,  7,  8,  9};

static const int prisms_turns[] = {
    0,  0, 0,  0, 0,  0,  0,  -3, 0,  0,  0,  0, 0,  0,  0,  0, 0,  0,  -1, -1, 0, 0, -1, 0,
    -1, 0, -1, 0, -1, -1, -1, -1, -1, -1, -1, 0, -1, -1, -1, 0, -1, -1, 0,  0,  0, 0, 0,  0,
    0,  0, 0,  0, 0,  0,  0,  0,  0,  0,  0,  0, 0,  0,  0,  0, 0,  0,  0,  0,  0, 0};

static const double extruded_triangles_places[] = {0, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0, 1,
                                                   1, 1, 0, 1, 1, 1, 0, 1, 0, 0, 1, 1};

static const int extruded_triangles_sizes[] = {5, 5, 0, 0, 0, 0, 0, 0, 0, 0, 3, 3, 3, 3, 4, 4, 4,
                                               4, 4, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2};

static const int extruded_triangles_cones[] = {
    10, 11, 14, 15, 16, 12, 13, 17, 16, 18, 19, 21, 23, 20, 22, 24, 25, 23, 27, 26, 24, 28, 19, 20,
    29, 30, 21, 22, 30, 31, 23, 24, 31, 29, 25, 26, 32, 29, 27, 28, 31, 32, 2,  4,  3,  5,  4,  6,
    5,  7,  6,  2,  7,  3,  8,  2,  9,  3,  6,  8,  7,  9,  2,  3,  4,  5,  6,  7,  8,  9};

static const int extruded_triangles_turns[] = {
    0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0, -1, 0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0, 0,  0, 0, 0,
    0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0, 0,  0};

static const double extruded_quadrilaterals_places[] = {0, 0,    0, 0, 0,    1, 1, 0, 0, 1, 0, 1,
                                                        2, 0.5,  0, 2, 0.5,  1, 0, 1, 0, 0, 1, 1,
                                                        1, 1.25, 0, 1, 1.25, 1, 2, 1, 0, 2, 1, 1};

static const int extruded_quadrilaterals_sizes[] = {6, 6, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4,
                                                    4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 2, 2, 2, 2, 2,
                                                    2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2};

static const int extruded_quadrilaterals_cones[] = {
    14, 15, 18, 19, 20, 21, 16, 17, 22, 19, 23, 24, 25, 27, 29, 31, 26, 28, 30, 32, 33, 27, 35, 37,
    34, 28, 36, 38, 25, 26, 39, 40, 27, 28, 40, 43, 29, 30, 43, 42, 31, 32, 42, 39, 33, 34, 44, 43,
    35, 36, 40, 41, 37, 38, 41, 44, 2,  4,  3,  5,  4,  10, 5,  11, 10, 8,  11, 9,  8,  2,  9,  3,
    12, 10, 13, 11, 4,  6,  5,  7,  6,  12, 7,  13, 2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13};

static const int extruded_quadrilaterals_turns[] = {
    0, 0,  0, 0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0, 0,
    0, -1, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0,
    0, 0,  0, 0, 0, 0, 0, 0, 0, 0,  0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0,
    0, 0,  0, 0, 0, 0, 0, 0, 0, 0,  0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,  0, 0};

enum { MOST_POINTS = 45, MOST_CONES = 96, N_ELEMENTS = 2 };

/** A mesh of two elements. */
typedef struct sample {
    int dim, n_nodes, n_points, n_cones;
    const int *sizes, *cones, *turns;
    const double *places;
    int type[N_ELEMENTS];
} sample;

static const sample meshes[] = {
    {2,
     6,
     8,
     8,
     flat_quadrilaterals_sizes,
     flat_quadrilaterals_cones,
     NULL,
     quadrilaterals_places,
     {PLANISH_CELL_QUADRILATERAL, PLANISH_CELL_QUADRILATERAL}},
    {2,
     6,
     15,
     22,
     quadrilaterals_sizes,
     quadrilaterals_cones,
     quadrilaterals_turns,
     quadrilaterals_places,
     {PLANISH_CELL_QUADRILATERAL, PLANISH_CELL_QUADRILATERAL}},
    {3,
     9,
     11,
     13,
     flat_solids_sizes,
     flat_solids_cones,
     NULL,
     solids_places,
     {PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_PYRAMID}},
    {3,
     9,
     37,
     79,
     solids_sizes,
     solids_cones,
     solids_turns,
     solids_places,
     {PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_PYRAMID}},
    {3,
     8,
     10,
     12,
     flat_prisms_sizes,
     flat_prisms_cones,
     NULL,
     prisms_places,
     {PLANISH_CELL_WEDGE, PLANISH_CELL_WEDGE}},
    {3,
     8,
     33,
     70,
     prisms_sizes,
     prisms_cones,
     prisms_turns,
     prisms_places,
     {PLANISH_CELL_WEDGE, PLANISH_CELL_WEDGE}},
    {3,
     8,
     33,
     70,
     extruded_triangles_sizes,
     extruded_triangles_cones,
     extruded_triangles_turns,
     extruded_triangles_places,
     {PLANISH_CELL_WEDGE, PLANISH_CELL_WEDGE}},
    {3,
     12,
     45,
     96,
     extruded_quadrilaterals_sizes,
     extruded_quadrilaterals_cones,
     extruded_quadrilaterals_turns,
     extruded_quadrilaterals_places,
     {PLANISH_CELL_HEXAHEDRON, PLANISH_CELL_HEXAHEDRON}},
};
enum { N_MESHES = sizeof meshes / sizeof *meshes };

/** Put the points of a sample, and its nodes. */
static void put_mesh(hdf5_builder *b, const sample *m) {
    static const int none[MOST_CONES] = {0};
    int order[MOST_POINTS];
    for (int i = 0; i < m->n_points; i++)
        order[i] = i;
    hdf5_group(b, "/topology");
    hdf5_integers(b, "/topology/order", (hsize_t)m->n_points, order);
    hdf5_integers(b, "/topology/cones", (hsize_t)m->n_points, m->sizes);
    hdf5_integers(b, "/topology/cells", (hsize_t)m->n_cones, m->cones);
    hdf5_integers(b, "/topology/orientation", (hsize_t)m->n_cones, m->turns ? m->turns : none);
    hdf5_attribute(b, "/topology/cells", "cell_dim", m->dim);
    hdf5_group(b, "/geometry");
    hdf5_array(b, "/geometry/vertices", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, (hsize_t)m->n_nodes,
               (hsize_t)m->dim, m->places);
}

static file_builder make(const sample *m) {
    hdf5_builder b;
    hdf5_begin(&b, 0);
    put_mesh(&b, m);
    return hdf5_end(&b);
}

static void elements_of_every_type_are_read(void **state) {
    (void)state;
    double aspect_ratio = 0;
    for (int i = 0; i < N_MESHES; i++) {
        const sample *m = &meshes[i];
        planish_file *file;
        planish_cells cells;
        planish_error error = {.text = ""};
        file_builder b = make(m);
        if (builder_read(&b, &io_format_plex, 1, &file, &error))
            fail_msg("mesh %d: %s", i, error.text);
        assert_int_equal(planish_file_cells(file, &cells, &error), 0);
        assert_int_equal(planish_file_mesh(file).dim, m->dim);
        for (int k = 0; k < N_ELEMENTS; k++) {
            assert_int_equal(cells.type[k], m->type[k]);
            assert_int_equal(planish_file_element_number(file, k), k);
        }
        const planish_cell_quality quality = unit_measure(file, N_ELEMENTS);
        assert_int_equal(quality.all.n_inverted, 0);
        assert_int_equal(quality.all.n_inverted_corners, 0);
        assert_true(quality.all.min_scaled_jacobian > 0.75);
        /* Of the meshes in pairs the second has the same elements. */
        if (i < 6 && i % 2)
            assert_true(fabs(quality.all.rms_aspect_ratio - aspect_ratio) < 1e-14);
        aspect_ratio = quality.all.rms_aspect_ratio;
        unit_expect_others(file, 0, 0);
        planish_file_close(file);
        builder_release(&b);
    }
}

/** Labels make regions of hexahedra and groups of their faces. */
static void labels_of_elements_and_faces_are_read(void **state) {
    (void)state;
    const sample *m = &meshes[N_MESHES - 1]; /* two hexahedra, of which face 14 is the base */
    const int points[] = {0, 1, 14};
    hdf5_builder b;
    hdf5_begin(&b, 0);
    put_mesh(&b, m);
    hdf5_group(&b, "/labels/Cell Sets/7");
    hdf5_integers(&b, "/labels/Cell Sets/7/indices", 1, points);
    hdf5_group(&b, "/labels/Cell Sets/8");
    hdf5_integers(&b, "/labels/Cell Sets/8/indices", 1, points + 1);
    hdf5_group(&b, "/labels/Face Sets/5");
    hdf5_integers(&b, "/labels/Face Sets/5/indices", 1, points + 2);
    file_builder made = hdf5_end(&b);
    planish_file *file = builder_file(&made, &io_format_plex);
    planish_file_info info;
    planish_file_get_info(file, &info);
    assert_int_equal(info.n_regions, 2);
    assert_int_equal(info.n_lower_elements, 1);
    assert_int_equal(info.n_other_elements, 0);
    char region[32];
    assert_true(planish_file_element_region(file, 1, region, sizeof region) > 0);
    assert_string_equal(region, "Cell Sets:8");
    const planish_surface surface = planish_file_surface(file, NULL);
    assert_int_equal(surface.n_facets, 1);
    assert_int_equal(surface.facet_offset[1], 4);
    const planish_cells *cells = planish_file_mesh(file).cells;
    int n_of_first = 0;
    for (int k = 0; k < 8; k++)
        for (int j = 0; j < 4; j++)
            n_of_first += surface.facets[j] == cells->node[k];
    assert_int_equal(n_of_first, 4);
    unit_expect_held(file, "Cell Sets:7", "111100111100");
    planish_file_close(file);
    builder_let_allocations_fail(&made, &io_format_plex);
    builder_release(&made);
}

/** Files with a wrong point in a cone, or a wrong sense, are refused, or read with other nodes or
 *  without that element. */
static void wrong_cones_do_no_harm(void **state) {
    (void)state;
    for (int i = 0; i < N_MESHES; i++)
        for (int k = 0; k < 2 * meshes[i].n_cones; k++) {
            sample m = meshes[i];
            int changed[MOST_CONES] = {0};
            const int at = k / 2, *from = k % 2 ? m.turns : m.cones;
            planish_file *file;
            planish_cells cells;
            planish_error error = {.text = ""};
            if (from)
                memcpy(changed, from, (size_t)m.n_cones * sizeof *changed);
            changed[at] = k % 2 ? changed[at] + (at % 3) - 4 : (changed[at] + 5 * at) % m.n_points;
            *(k % 2 ? &m.turns : &m.cones) = changed;
            file_builder b = make(&m);
            if (builder_read(&b, &io_format_plex, 1, &file, &error) == 0) {
                assert_int_equal(planish_file_cells(file, &cells, &error), 0);
                assert_in_range(cells.n, 0, N_ELEMENTS);
                unit_measure(file, cells.n);
                planish_file_close(file);
            } else {
                assert_true(error.text[0] != 0);
            }
            builder_release(&b);
        }
}

static void nothing_breaks_it(void **state) {
    (void)state;
    file_builder b = make(&meshes[3]);
    builder_expect_same_on_threads(&b, &io_format_plex);
    builder_let_allocations_fail(&b, &io_format_plex);
    builder_release(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_of_every_type_are_read),
        cmocka_unit_test(labels_of_elements_and_faces_are_read),
        cmocka_unit_test(wrong_cones_do_no_harm),
        cmocka_unit_test(nothing_breaks_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#else

int main(void) {
    return 0; /* test_vtkhdf.c sees that HDF5 is asked for */
}

#endif
