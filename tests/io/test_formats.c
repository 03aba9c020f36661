/* The list of formats: its names are those of the readers, and tests have a file of each. Elements of
 * other types than simplices in files of text of every format: regions, groups and facets. */
#include "support/cell_meshes.h"
#include "support/data_files.h"
#include "support/files.h"
#include "support/reading.h"
#include "support/rewriting.h"
#include "support/unit_elements.h"

#include "geometry/cell.h"
#include "io/file/file.h"

#include <planish/planish_io.h>

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Number of names before the i-th that are the same as that. */
static int count_earlier(const char *const *names, int i) {
    int n = 0;
    for (int k = 0; k < i; k++)
        n += strcmp(names[k], names[i]) == 0;
    return n;
}

static void each_name_is_of_one_format(void **state) {
    (void)state;
    const char *const *names = planish_file_formats();
    for (int i = 0; names[i]; i++) {
        const io_format *format = io_format_by_name(names[i]);
        assert_non_null(format);
        assert_string_equal(format->name, names[i]);
        assert_int_equal(count_earlier(names, i), 0);
        for (const char *const *dot = format->extensions; *dot; dot++)
            assert_int_equal(**dot, '.');
    }
}

static void each_format_has_a_file_in_the_data(void **state) {
    (void)state;
    for (const char *const *name = planish_file_formats(); *name; name++) {
        int n = 0;
        for (const test_data_file *data = test_data_files; data->name; data++)
            n += strcmp(data->format, *name) == 0;
        if (n == 0)
            fail_msg("tests/support/data_files.c has no file of the format %s", *name);
    }
}

/** TetGen's tables of numbers are recognised by their names alone. */
static void each_file_of_the_data_is_recognised_by_its_content(void **state) {
    (void)state;
    for (const test_data_file *data = test_data_files; data->name; data++) {
        char path[TEST_PATH_SIZE];
        size_t size;
        if (test_data_is_folder(data) || !test_data_path(path, data))
            continue;
        char *bytes = test_read(path, &size);
        const char *name = strcmp(data->format, "tetgen") == 0 ? data->name : "name";
        const io_format *format = io_format_find(name, bytes, (int64_t)size);
        if (!format || strcmp(format->name, data->format) != 0)
            fail_msg("%s is read as %s", data->name, format ? format->name : "no format");
        free(bytes);
    }
}

/** The function that rounds gives what a file holds: a float, a double, or a number of few digits. */
static void numbers_are_rounded_as_they_are_stored(void **state) {
    (void)state;
    const double third = 1.0 / 3;
    int n[3] = {0}, n_changed = 0;
    for (const test_data_file *data = test_data_files; data->name; data++) {
        char path[TEST_PATH_SIZE];
        planish_file *file;
        planish_file_info info;
        if (!test_data_path(path, data) || planish_file_open(path, NULL, 1, &file, NULL))
            continue;
        planish_file_get_info(file, &info);
        n[info.precision]++;
        const double rounded = info.round(third, info.round_user);
        n_changed += rounded != third; /* Abaqus has room for it */
        if (info.precision == PLANISH_PRECISION_ROUNDED)
            assert_true(fabs(rounded - third) <= 1e-6);
        else
            assert_true(rounded == third);
        planish_file_close(file);
    }
    assert_true(n[PLANISH_PRECISION_DOUBLE] > 10 && n_changed > 0);
    planish_file_info info;
    planish_file *file =
        reading_text(&io_format_vtk, "# vtk DataFile Version 3.0\n\nASCII\nDATASET "
                                     "UNSTRUCTURED_GRID\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
                                     "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n5\n");
    planish_file_get_info(file, &info);
    assert_true(info.round(third, info.round_user) == (float)third);
    planish_file_close(file);
}

/* ---- two bricks in every format of text ------------------------------------------------------ */

/** How a format writes two bricks, see unit_expect_bricks. */
typedef struct bricks {
    const io_format *format;
    int dim;
    const char *head;                     /* up to the nodes */
    int is_numbered;                      /* nodes are, */
    const char *before, *between, *after; /* and what stands around their coordinates */
    const char *tail;                     /* behind the nodes */
    const char *facet, *second;           /* tags */
} bricks;

#define GMSH22(names)                                                                              \
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n" names "$EndPhysicalNames\n"
#define VTK_TAIL "CELL_DATA 3\nSCALARS MaterialIDs int\nLOOKUP_TABLE default\n7\n5\n8\n"

static const bricks all_bricks[] = {
    {&io_format_gmsh, 3, GMSH22("2 5 \"bottom\"\n3 8 \"right\"\n") "$Nodes\n12\n", 1, "", " ", "\n",
     "$EndNodes\n$Elements\n3\n1 5 2 7 1 1 2 5 4 7 8 11 10\n2 5 2 8 2 2 3 6 5 8 9 12 11\n"
     "3 3 2 5 1 1 2 5 4\n$EndElements\n",
     "bottom", "right"},
    {&io_format_gmsh, 2, GMSH22("1 5 \"bottom\"\n2 8 \"right\"\n") "$Nodes\n6\n", 1, "", " ", "\n",
     "$EndNodes\n$Elements\n3\n1 3 2 7 1 1 2 5 4\n2 3 2 8 2 2 3 6 5\n3 1 2 5 1 1 2\n"
     "$EndElements\n",
     "bottom", "right"},
    {&io_format_gmsh, 3,
     "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 2\n1 0 0 0 1 1 0 1 5 0\n"
     "1 0 0 0 1 1 1 1 7 0\n2 1 0 0 2 1 1 1 8 0\n$EndEntities\n"
     "$Nodes\n1 12 1 12\n3 1 0 12\n1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n11\n12\n",
     0, "", " ", "\n",
     "$EndNodes\n$Elements\n3 3 1 3\n2 1 3 1\n3 1 2 5 4\n3 1 5 1\n1 1 2 5 4 7 8 11 10\n"
     "3 2 5 1\n2 2 3 6 5 8 9 12 11\n$EndElements\n",
     "2:5", "3:8"},
    {&io_format_medit, 3, "MeshVersionFormatted 2\nDimension 3\nVertices\n12\n", 0, "", " ", " 0\n",
     "Hexahedra\n2\n1 2 5 4 7 8 11 10 7\n2 3 6 5 8 9 12 11 8\nQuadrilaterals\n1\n1 2 5 4 5\nEnd\n",
     "2:5", "3:8"},
    {&io_format_medit, 2, "MeshVersionFormatted 2\nDimension 3\nVertices\n6\n", 0, "", " ", " 0\n",
     "Quadrilaterals\n2\n1 2 5 4 7\n2 3 6 5 8\nEdges\n1\n1 2 5\nEnd\n", "1:5", "2:8"},
    {&io_format_vtk, 3,
     "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
     "POINTS 12 double\n",
     0, "", " ", "\n",
     "CELLS 3 23\n8 0 1 4 3 6 7 10 9\n4 0 1 4 3\n8 1 2 5 4 7 8 11 10\nCELL_TYPES 3\n12 9 "
     "12\n" VTK_TAIL,
     "2:5", "3:8"},
    {&io_format_vtk, 2,
     "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
     "POINTS 6 double\n",
     0, "", " ", "\n", "CELLS 3 13\n4 0 1 4 3\n2 0 1\n4 1 2 5 4\nCELL_TYPES 3\n9 3 9\n" VTK_TAIL,
     "1:5", "2:8"},
    {&io_format_netgen, 3,
     "mesh3d\ndimension\n3\ngeomtype\n0\n\nsurfaceelements\n1\n 1 5 1 0 4 1 2 5 4\n"
     "volumeelements\n2\n7 8 1 2 5 4 7 8 11 10\n8 8 2 3 6 5 8 9 12 11\npoints\n12\n",
     0, "", " ", "\n", "endmesh\n", "2:5", "3:8"},
    {&io_format_netgen, 2,
     "mesh3d\ndimension\n2\ngeomtype\n0\n\nsurfaceelements\n2\n 7 7 0 0 4 1 2 5 4\n"
     " 8 8 0 0 4 2 3 6 5\nvolumeelements\n0\nedgesegmentsgi2\n1\n 5 0 1 2 0 0 1 0 5 0 1 0.2\n"
     "points\n6\n",
     0, "", " ", "\n", "endmesh\n", "1:5", "2:8"},
    {&io_format_abaqus, 3, "*NODE\n", 1, "", ", ", "\n",
     "*ELEMENT, TYPE=C3D8, ELSET=left\n1,1,2,5,4,7,8,11,10\n*ELEMENT, TYPE=C3D8R, ELSET=right\n"
     "2,2,3,6,5,8,9,12,11\n*ELEMENT, TYPE=S4R, ELSET=bottom\n3,1,2,5,4\n",
     "bottom", "right"},
    {&io_format_abaqus, 2, "*NODE\n", 1, "", ", ", "\n",
     "*ELEMENT, TYPE=CPS4\n1,1,2,5,4\n2,2,3,6,5\n*ELEMENT, TYPE=T2D2, ELSET=bottom\n3,1,2\n"
     "*ELSET, ELSET=right, GENERATE\n2,2\n*SOLID SECTION, ELSET=right\n",
     "bottom", "right"},
    {&io_format_nastran, 3, "BEGIN BULK\n", 1, "GRID,", ",", "\n",
     "CHEXA,1,7,1,2,5,4,7,8\n,11,10\nCHEXA,2,8,2,3,6,5,8,9\n,12,11\nCQUAD4,3,5,1,2,5,4\nENDDATA\n",
     "2:5", "3:8"},
    {&io_format_nastran, 2, "BEGIN BULK\n", 1, "GRID,", ",", "\n",
     "CQUAD4,1,7,1,2,5,4\nCQUADR,2,8,2,3,6,5\nCROD,3,5,1,2\nENDDATA\n", "1:5", "2:8"},
    {&io_format_mfem, 3,
     "MFEM mesh v1.0\ndimension\n3\nelements\n2\n7 5 0 1 4 3 6 7 10 9\n8 5 1 2 5 4 7 8 11 10\n"
     "boundary\n1\n5 3 0 1 4 3\nvertices\n12\n3\n",
     0, "", " ", "\n", "", "2:5", "3:8"},
    {&io_format_mfem, 2,
     "MFEM mesh v1.0\ndimension\n2\nelements\n2\n7 3 0 1 4 3\n8 3 1 2 5 4\n"
     "boundary\n1\n5 1 0 1\nvertices\n6\n3\n",
     0, "", " ", "\n", "", "1:5", "2:8"},
    {&io_format_off, 2, "OFF\n6 2 0\n", 0, "", " ", "\n", "4 0 1 4 3\n4 1 2 5 4\n", NULL, NULL},
};

/** Write the nodes, and what is around them. */
static file_builder write_bricks(const bricks *b) {
    file_builder file = {.binary = 0};
    const int is_nastran = b->format == &io_format_nastran; /* a system behind the number */
    builder_text(&file, "%s", b->head);
    for (int i = 0; i < (b->dim == 3 ? 12 : 6); i++) {
        builder_text(&file, "%s", b->before);
        if (b->is_numbered)
            builder_text(&file, "%d%s%s", i + 1, b->between, is_nastran ? "," : "");
        builder_text(&file, "%d.0%s%d.0%s%d.0%s", i % 3, b->between, i / 3 % 2, b->between, i / 6,
                     b->after);
    }
    builder_text(&file, "%s", b->tail);
    return file;
}

static void bricks_have_regions_groups_and_facets(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof all_bricks / sizeof *all_bricks; i++) {
        const bricks *b = &all_bricks[i];
        file_builder text = write_bricks(b);
        planish_file *file = builder_file(&text, b->format);
        assert_int_equal(planish_file_mesh(file).dim, b->dim);
        unit_expect_bricks(file, b->facet, b->second);
        planish_file_close(file);
        builder_expect_same_on_threads(&text, b->format);
        builder_try_to_break(&text, b->format);
        builder_release(&text);
    }
}

/** Nothing but coordinates changes in a file of bricks. */
static void bricks_are_written(void **state) {
    for (size_t i = 0; i < sizeof all_bricks / sizeof *all_bricks; i++) {
        const bricks *b = &all_bricks[i];
        file_builder text = write_bricks(b);
        const int is_in_words = b->format != &io_format_abaqus && b->format != &io_format_nastran;
        if (is_in_words) {
            rewriting_keeps_the_rest(b->format, text.data, text.size, *state);
        } else { /* the first coordinate is the first 0.0 */
            char *whole = calloc((size_t)text.size + 1, 1);
            char *moved = calloc((size_t)text.size + 16, 1);
            memcpy(whole, text.data, (size_t)text.size);
            const char *at = strstr(whole, "0.0");
            memcpy(moved, whole, (size_t)(at - whole));
            strcat(moved, ".125");
            strcat(moved, at + 3);
            rewriting_gives(b->format, whole, "x", moved, *state);
            free(whole);
            free(moved);
        }
        builder_release(&text);
    }
}

/* ---- lists of all facets and edges ------------------------------------------------------------ */

enum { LISTED_SIDE = 3, MOST_PARTS = 2000 };

/** A facet or edge: its nodes, ascending behind those that are not there (-1), and how many elements have
 *  it. */
typedef struct part {
    int32_t node[4], around[4];
    int n, n_elements;
} part;

typedef struct part_list {
    part part[MOST_PARTS];
    int n;
} part_list;

/** Add the part of n nodes, unless it is there. */
static void add_part(part_list *list, const int32_t *around, int n) {
    part p = {.node = {-1, -1, -1, -1}, .n = n, .n_elements = 1};
    for (int i = 0; i < n; i++) {
        int k = 3;
        p.around[i] = around[i];
        while (p.node[k] > around[i])
            k--;
        for (int j = 0; j < k; j++)
            p.node[j] = p.node[j + 1];
        p.node[k] = around[i];
    }
    for (int i = 0; i < list->n; i++)
        if (memcmp(list->part[i].node, p.node, sizeof p.node) == 0) {
            list->part[i].n_elements++;
            return;
        }
    assert_true(list->n < MOST_PARTS);
    list->part[list->n++] = p;
}

/** List the facets of a box, or its edges. */
static void list_parts(const cell_box *box, int edges, part_list *list) {
    list->n = 0;
    for (int64_t i = 0; i < box->cells.n; i++) {
        const pl_cell_shape *shape = pl_cell_type_of(box->type[i])->shape;
        const int32_t *node = box->node + box->offset[i];
        const int n_parts = edges ? shape->n_edges : shape->n_facets;
        for (int k = 0; k < n_parts; k++) {
            int32_t around[4];
            int n = 0;
            for (int j = 0; j < (edges ? 2 : 4); j++)
                if (edges || shape->facet[k][j] >= 0)
                    around[n++] = node[edges ? shape->edge[k][j] : shape->facet[k][j]];
            add_part(list, around, n);
        }
    }
}

/** Write parts of n nodes as a section of Medit; part number marked has the reference 9. */
static void write_parts(file_builder *b, const char *name, const part_list *list, int n,
                        int marked) {
    int n_parts = 0;
    for (int i = 0; i < list->n; i++)
        n_parts += list->part[i].n == n;
    builder_text(b, "%s\n%d\n", name, n_parts);
    for (int i = 0; i < list->n; i++) {
        for (int j = 0; j < n && list->part[i].n == n; j++)
            builder_text(b, "%d ", (int)list->part[i].around[j] + 1);
        if (list->part[i].n == n)
            builder_text(b, "%d\n", i == marked ? 9 : 0);
    }
}

/** Write a box as Medit does, with all facets and in three dimensions all edges. */
static file_builder write_listed(const cell_box *box, const part_list *facets,
                                 const part_list *edges, int marked) {
    static const struct {
        const char *name;
        int type;
    } sections[] = {{"Hexahedra", PLANISH_CELL_HEXAHEDRON},
                    {"Prisms", PLANISH_CELL_WEDGE},
                    {"Pyramids", PLANISH_CELL_PYRAMID},
                    {"Quadrilaterals", PLANISH_CELL_QUADRILATERAL},
                    {"Triangles", PLANISH_CELL_TRIANGLE}};
    file_builder b = {.binary = 0};
    const int dim = box->mesh.dim;
    builder_text(&b, "MeshVersionFormatted 2\nDimension %d\nVertices\n%d\n", dim,
                 (int)box->mesh.n_nodes);
    for (int64_t i = 0; i < box->mesh.n_nodes * dim; i++)
        builder_text(&b, "%g%s", box->x[i], i % dim == dim - 1 ? " 0\n" : " ");
    for (size_t s = 0; s < sizeof sections / sizeof *sections; s++) {
        int n = 0;
        for (int64_t i = 0; i < box->cells.n; i++)
            n += box->type[i] == sections[s].type;
        if (n == 0)
            continue;
        builder_text(&b, "%s\n%d\n", sections[s].name, n);
        for (int64_t i = 0; i < box->cells.n; i++) {
            if (box->type[i] != sections[s].type)
                continue;
            for (int64_t k = box->offset[i]; k < box->offset[i + 1]; k++)
                builder_text(&b, "%d ", (int)box->node[k] + 1);
            builder_text(&b, "0\n");
        }
    }
    if (dim == 3) {
        write_parts(&b, "Quadrilaterals", facets, 4, marked);
        write_parts(&b, "Triangles", facets, 3, marked);
    }
    write_parts(&b, "Edges", dim == 3 ? edges : facets, 2, dim == 3 ? -1 : marked);
    builder_text(&b, "End\n");
    return b;
}

/** Facets and edges of elements that are all listed say nothing of nodes inside, but where one has
 *  another reference. */
static void lists_of_all_facets_hold_nothing_inside(void **state) {
    (void)state;
    part_list *facets = malloc(sizeof *facets), *edges = malloc(sizeof *edges);
    for (int kind = 0; kind < N_BOX_KINDS; kind++) {
        cell_box *box = cell_box_create((cell_box_kind)kind, LISTED_SIDE);
        const int dim = box->mesh.dim;
        int n_outside = 0, inside = -1;
        list_parts(box, 0, facets);
        list_parts(box, 1, edges);
        for (int i = 0; i < facets->n; i++) {
            n_outside += facets->part[i].n_elements == 1;
            inside = facets->part[i].n_elements == 2 ? i : inside;
        }
        for (int marked = -1; marked <= inside; marked += inside + 1) {
            file_builder b = write_listed(box, facets, edges, marked);
            planish_file *file = builder_file(&b, &io_format_medit);
            assert_int_equal(planish_file_mesh(file).n_elements, box->cells.n);
            for (int64_t i = 0; i < box->mesh.n_nodes; i++) {
                int is_side = 0, is_marked = 0;
                for (int d = 0; d < dim; d++)
                    is_side |= box->x[i * dim + d] == 0 || box->x[i * dim + d] == LISTED_SIDE;
                for (int k = 0; marked >= 0 && k < facets->part[marked].n; k++)
                    is_marked |= facets->part[marked].around[k] == i;
                const int held = dim == 3 ? IO_HELD_BY_FACE : IO_HELD_BY_LINE;
                assert_int_equal(file->model.hold[i], is_side || is_marked ? held : 0);
            }
            const planish_surface surface = planish_file_surface(file, NULL);
            assert_int_equal(surface.n_facets, n_outside + (marked >= 0));
            assert_int_equal(surface.n_edges, 0);
            planish_file_close(file);
            builder_expect_same_on_threads(&b, &io_format_medit);
            builder_release(&b);
        }
        /* Where one is missing all say something. */
        const part last = facets->part[--facets->n];
        file_builder b = write_listed(box, facets, edges, -1);
        planish_file *file;
        assert_int_equal(builder_read(&b, &io_format_medit, 1, &file, NULL), 0);
        int n_alike = 0;
        for (int i = 0; i < facets->n; i++)
            n_alike += facets->part[i].n == last.n;
        assert_true(planish_file_surface(file, NULL).n_facets >= n_alike);
        planish_file_close(file);
        builder_release(&b);
        cell_box_destroy(box);
    }
    free(facets);
    free(edges);
}

/** A warped quadrilateral is a surface in space. Lines alone are refused. */
static void what_cannot_be_smoothed(void **state) {
    (void)state;
    static const char shell[] = "MeshVersionFormatted 2\nDimension 3\nVertices\n4\n"
                                "0 0 0 0\n1 0 0 0\n1 1 1 0\n0 1 0 0\n"
                                "Quadrilaterals\n1\n1 2 3 4 7\nEnd\n";
    reading_gives_surface(&io_format_medit, shell);
    static const char lines[] =
        "MeshVersionFormatted 2\nDimension 3\nVertices\n2\n0 0 0 0\n1 0 0 0\n"
        "Edges\n1\n1 2 5\nEnd\n";
    reading_fails(&io_format_medit, lines, "nothing to smooth");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_name_is_of_one_format),
        cmocka_unit_test(each_format_has_a_file_in_the_data),
        cmocka_unit_test(each_file_of_the_data_is_recognised_by_its_content),
        cmocka_unit_test(numbers_are_rounded_as_they_are_stored),
        cmocka_unit_test(bricks_have_regions_groups_and_facets),
        cmocka_unit_test(bricks_are_written),
        cmocka_unit_test(lists_of_all_facets_hold_nothing_inside),
        cmocka_unit_test(what_cannot_be_smoothed),
    };
    return cmocka_run_group_tests(tests, test_folder_create, test_folder_remove);
}
