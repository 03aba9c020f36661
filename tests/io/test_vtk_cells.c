/* Tests of all types of cells in VTK's files: an element of each type, bent so that it is valid in one
 * order of its nodes alone, is read from each format, measured, and kept by copies for viewing. */
#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/file_builder.h"
#include "support/files.h"
#include "support/hdf5_builder.h"
#include "support/bent_elements.h"
#include "support/reading.h"

/* ---- elements ------------------------------------------------------------------------------- */

/** Count the inverted elements of cells at coordinates [n_nodes][dim]. */
static int64_t count_inverted(const planish_cells *cells, int dim, int64_t n_nodes,
                              const double *coordinates) {
    planish_cell_quality quality;
    planish_error error = {.text = ""};
    const planish_mesh mesh = {.dim = dim,
                               .n_nodes = n_nodes,
                               .n_elements = cells->n,
                               .coordinates = coordinates,
                               .cells = cells};
    if (planish_measure_cells(&mesh, 0, 1, &quality, NULL, &error))
        fail_msg("%s", error.text);
    assert_int_equal(quality.all.n_uncertified, 0);
    return quality.all.n_inverted;
}

/** Whether an element may stay valid when nodes i < k are exchanged: unless both are mids, or
 *  corners at the ends of an edge along an axis. Pyramids are measured by their base. */
static int may_be_exchanged(const bent_element *e, int i, int k) {
    int n_apart = 0;
    if (k >= (e->n_corners == 5 ? 4 : e->n_corners))
        return i < e->n_corners || e->n_corners == 5;
    for (int d = 0; d < 3; d++)
        n_apart += e->places[4 * i + d] != e->places[4 * k + d];
    return n_apart != 1;
}

/** The elements are valid, and are not when two of their nodes are exchanged. */
static void another_order_is_not_valid(void **state) {
    (void)state;
    for (int t = 0; t < N_BENT_ELEMENTS; t++) {
        const bent_element *e = &bent_elements[t];
        const uint8_t type = (uint8_t)e->type;
        const int64_t offset[] = {0, e->n_nodes};
        int32_t node[BENT_MOST_NODES];
        double x[3 * BENT_MOST_NODES];
        const planish_cells cells = {.n = 1, .type = &type, .offset = offset, .node = node};
        for (int i = 0; i < e->n_nodes; i++) {
            double place[3];
            node[i] = i;
            bent_element_place(e, i, place);
            memcpy(x + e->dim * i, place, (size_t)e->dim * sizeof *x);
        }
        assert_int_equal(count_inverted(&cells, e->dim, e->n_nodes, x), 0);
        for (int k = 1; k < e->n_nodes; k++)
            for (int i = 0; i < k; i++) {
                if (may_be_exchanged(e, i, k))
                    continue;
                node[i] = k;
                node[k] = i;
                if (count_inverted(&cells, e->dim, e->n_nodes, x) == 0)
                    fail_msg("type %d is valid with nodes %d and %d exchanged", type, i, k);
                node[i] = i;
                node[k] = k;
            }
    }
}

/* ---- files ---------------------------------------------------------------------------------- */

/** Cells of a file, each with nodes of its own. */
typedef struct cell_list {
    int n;
    struct listed_cell {
        const bent_element *element;
        int type;             /* VTK's number in the file */
        const uint8_t *order; /* node i of the file is the element's node order[i]; NULL: i */
    } cell[N_BENT_ELEMENTS + 8];
    int n_nodes; /* of all */
} cell_list;

static void list_cell(cell_list *list, const bent_element *element, int type,
                      const uint8_t *order) {
    list->cell[list->n++] = (struct listed_cell){element, type, order};
    list->n_nodes += element->n_nodes;
}

/** Find the place of node i of a cell of the list, apart from the other cells. */
static void listed_place(const cell_list *list, int cell, int i, double place[3]) {
    const struct listed_cell *c = &list->cell[cell];
    bent_element_place(c->element, c->order ? c->order[i] : i, place);
    place[0] += 2 * cell;
}

static void put_places(file_builder *b, const cell_list *list) {
    for (int c = 0; c < list->n; c++)
        for (int i = 0; i < list->cell[c].element->n_nodes; i++) {
            double place[3];
            listed_place(list, c, i, place);
            for (int d = 0; d < 3; d++)
                builder_real(b, place[d], 8);
        }
}

/** A legacy file, or one of version 5. */
static file_builder make_vtk(const cell_list *list, int version) {
    file_builder b = {.binary = 0};
    int at = 0;
    builder_text(&b, "# vtk DataFile Version %d.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n", version);
    builder_text(&b, "POINTS %d double\n", list->n_nodes);
    put_places(&b, list);
    if (version == 3)
        builder_text(&b, "\nCELLS %d %d\n", list->n, list->n + list->n_nodes);
    else
        builder_text(&b, "\nCELLS %d %d\nOFFSETS vtktypeint64\n", list->n + 1, list->n_nodes);
    for (int c = 0; c <= list->n && version == 5; c++) {
        builder_integer(&b, at, 8);
        at += c < list->n ? list->cell[c].element->n_nodes : 0;
    }
    if (version == 5)
        builder_text(&b, "\nCONNECTIVITY vtktypeint64\n");
    at = 0;
    for (int c = 0; c < list->n; c++) {
        if (version == 3)
            builder_integer(&b, list->cell[c].element->n_nodes, 4);
        for (int i = 0; i < list->cell[c].element->n_nodes; i++)
            builder_integer(&b, at++, 4);
    }
    builder_text(&b, "\nCELL_TYPES %d\n", list->n);
    for (int c = 0; c < list->n; c++)
        builder_integer(&b, list->cell[c].type, 4);
    return b;
}

/** Put a piece of an XML file with the cells from begin to end. */
static void put_piece(file_builder *b, const cell_list *list, int begin, int end) {
    cell_list piece = {.n = 0};
    for (int c = begin; c < end; c++)
        list_cell(&piece, list->cell[c].element, list->cell[c].type, list->cell[c].order);
    builder_text(b,
                 "<Piece NumberOfPoints=\"%d\" NumberOfCells=\"%d\"><Points><DataArray "
                 "type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">",
                 piece.n_nodes, piece.n);
    put_places(b, &piece);
    builder_text(b, "</DataArray></Points><Cells><DataArray type=\"Int64\" Name=\"connectivity\" "
                    "format=\"ascii\">");
    for (int i = 0; i < piece.n_nodes; i++)
        builder_integer(b, i, 8);
    builder_text(b, "</DataArray><DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">");
    for (int c = 0, at = 0; c < piece.n; c++)
        builder_integer(b, at += piece.cell[c].element->n_nodes, 8);
    builder_text(b, "</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">");
    for (int c = 0; c < piece.n; c++)
        builder_integer(b, piece.cell[c].type, 1);
    builder_text(b, "</DataArray></Cells></Piece>");
}

static file_builder make_vtu(const cell_list *list) {
    file_builder b = {.binary = 0};
    builder_text(&b, "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                     "byte_order=\"LittleEndian\"><UnstructuredGrid>");
    put_piece(&b, list, 0, list->n / 2);
    put_piece(&b, list, list->n / 2, list->n);
    builder_text(&b, "</UnstructuredGrid></VTKFile>");
    return b;
}

#ifdef PL_HDF5
static file_builder make_vtkhdf(const cell_list *list) {
    hdf5_builder b;
    double xyz[3 * BENT_MOST_NODES * N_BENT_ELEMENTS];
    int nodes[BENT_MOST_NODES * N_BENT_ELEMENTS],
        offsets[N_BENT_ELEMENTS + 9] = {0}, types[N_BENT_ELEMENTS + 8], n = 0;
    assert_in_range(list->n_nodes, 1, BENT_MOST_NODES * N_BENT_ELEMENTS);
    for (int c = 0; c < list->n; c++) {
        for (int i = 0; i < list->cell[c].element->n_nodes; i++, n++) {
            listed_place(list, c, i, xyz + 3 * n);
            nodes[n] = n;
        }
        offsets[c + 1] = n;
        types[c] = list->cell[c].type;
    }
    hdf5_begin(&b, 0);
    hdf5_group(&b, "/VTKHDF");
    hdf5_text_attribute(&b, "/VTKHDF", "Type", "UnstructuredGrid");
    hdf5_array(&b, "/VTKHDF/Points", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, (hsize_t)n, 3, xyz);
    hdf5_integers(&b, "/VTKHDF/NumberOfPoints", 1, &n);
    hdf5_integers(&b, "/VTKHDF/NumberOfCells", 1, &list->n);
    hdf5_integers(&b, "/VTKHDF/NumberOfConnectivityIds", 1, &n);
    hdf5_integers(&b, "/VTKHDF/Connectivity", (hsize_t)n, nodes);
    hdf5_integers(&b, "/VTKHDF/Offsets", (hsize_t)list->n + 1, offsets);
    hdf5_integers(&b, "/VTKHDF/Types", (hsize_t)list->n, types);
    return hdf5_end(&b);
}
#endif

/** Write a file to the folder, open it by its path, and release it. */
static planish_file *open_file(const char *folder, const char *name, file_builder *b) {
    char path[TEST_PATH_SIZE];
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    test_write(folder, name, b->data, (size_t)b->size);
    builder_release(b);
    if (planish_file_open(test_path(path, folder, name), NULL, 1, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

/** Open the list in format number f; NULL: there is no such format, or not in this build. */
static planish_file *open_list(const char *folder, const cell_list *list, int f) {
    file_builder b = {.binary = 0};
    if (f < 2)
        b = make_vtk(list, f == 0 ? 3 : 5);
    else if (f == 2 && reading_knows_vtu())
        b = make_vtu(list);
#ifdef PL_HDF5
    else if (f == 3)
        b = make_vtkhdf(list);
#endif
    static const char *const names[] = {"a.vtk", "b.vtk", "c.vtu", "d.vtkhdf"};
    return b.data ? open_file(folder, names[f], &b) : NULL;
}

enum { N_FORMATS = 4 };

/* ---- reading -------------------------------------------------------------------------------- */

/** List an element of each type of that dimension (0: none). */
static cell_list list_types(int dim) {
    cell_list list = {.n = 0};
    for (int i = 0; i < N_BENT_ELEMENTS; i++)
        if (bent_elements[i].dim == dim)
            list_cell(&list, &bent_elements[i], bent_elements[i].type, NULL);
    return list;
}

static int is_simplex(const cell_list *list, int cell) {
    const int type = list->cell[cell].element->type;
    return type == PLANISH_CELL_TRIANGLE6 || type == PLANISH_CELL_TETRAHEDRON10;
}

static int is_smoothed(const cell_list *list, int cell) {
    const int type = list->cell[cell].element->type;
    return type != PLANISH_CELL_PYRAMID13 && type != PLANISH_CELL_PYRAMID14;
}

/** Put the cells of the list in the order that the file has them in: triangles and tetrahedra first.
 *  Returns how many these are. */
static int order_list(const cell_list *list, int order[N_BENT_ELEMENTS + 8]) {
    int n_simplices = 0, n = 0;
    for (int pass = 1; pass >= 0; pass--)
        for (int c = 0; c < list->n; c++)
            if (is_simplex(list, c) == pass) {
                order[n++] = c;
                n_simplices += pass;
            }
    return n_simplices;
}

/** Expect that all cells of the list are in the file, with their numbers, and are right. A copy has
 *  them in the order of the file's. */
static void check_list(planish_file *file, const cell_list *list, int is_copy) {
    planish_cells cells;
    int order[N_BENT_ELEMENTS + 8];
    order_list(list, order);
    assert_int_equal(planish_file_mesh(file).n_elements, list->n);
    assert_int_equal(file->model.n_other, 0);
    assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
    assert_int_equal(cells.n, list->n);
    for (int c = 0; c < list->n; c++) {
        assert_int_equal(cells.type[c], list->cell[order[c]].element->type);
        assert_int_equal(planish_file_element_number(file, c), is_copy ? c : order[c]);
    }
    const planish_mesh mesh = planish_file_mesh(file);
    assert_int_equal(count_inverted(&cells, mesh.dim, mesh.n_nodes, mesh.coordinates), 0);
}

static void all_types_are_read(void **state) {
    for (int f = 0; f < N_FORMATS; f++)
        for (int dim = 2; dim <= 3; dim++) {
            const cell_list list = list_types(dim);
            planish_file *file = open_list(*state, &list, f);
            if (!file)
                continue;
            check_list(file, &list, 0);
            for (int c = 0, node = 0; c < list.n; c++)
                for (int i = 0; i < list.cell[c].element->n_nodes; i++)
                    assert_int_equal(file->model.hold[node++],
                                     is_smoothed(&list, c) ? 0 : IO_HELD_BY_OTHER);
            planish_file_close(file);
        }
}

/** Pixels and voxels have their nodes row by row; Lagrange cells of low order are as others. */
static void other_names_of_types_are_read(void **state) {
    static const uint8_t rows[] = {0, 1, 3, 2, 4, 5, 7, 6};
    static const int lagrange[][2] = {
        {PLANISH_CELL_QUADRILATERAL, 70},  {PLANISH_CELL_TRIANGLE6, 69},
        {PLANISH_CELL_QUADRILATERAL9, 70}, {PLANISH_CELL_TETRAHEDRON10, 71},
        {PLANISH_CELL_HEXAHEDRON, 72},     {PLANISH_CELL_WEDGE, 73}};
    for (int f = 0; f < N_FORMATS; f++)
        for (int dim = 2; dim <= 3; dim++) {
            cell_list list = {.n = 0};
            for (int i = 0; i < N_BENT_ELEMENTS; i++) {
                const bent_element *e = &bent_elements[i];
                if (e->dim != dim)
                    continue;
                if (e->n_nodes == 1 << dim)
                    list_cell(&list, e, dim == 2 ? 8 : 11, rows);
                for (size_t k = 0; k < sizeof lagrange / sizeof *lagrange; k++)
                    if (lagrange[k][0] == e->type)
                        list_cell(&list, e, lagrange[k][1], NULL);
            }
            planish_file *file = open_list(*state, &list, f);
            if (!file)
                continue;
            check_list(file, &list, 0);
            planish_file_close(file);
        }
}

/** Types that planish does not measure hold their nodes, beside others. */
static void unmeasured_types_are_held(void **state) {
    static const struct {
        int type, nodes; /* VTK's, and those of an element of that type here */
    } held[] = {{7, PLANISH_CELL_QUADRILATERAL},   {30, PLANISH_CELL_WEDGE},
                {31, PLANISH_CELL_QUADRILATERAL8}, {36, PLANISH_CELL_QUADRILATERAL8},
                {72, PLANISH_CELL_HEXAHEDRON27},   {73, PLANISH_CELL_WEDGE18},
                {74, PLANISH_CELL_PYRAMID},        {77, PLANISH_CELL_QUADRILATERAL9},
                {79, PLANISH_CELL_HEXAHEDRON},     {71, PLANISH_CELL_WEDGE}};
    for (size_t i = 0; i < sizeof held / sizeof *held; i++)
        for (int f = 0; f < N_FORMATS; f++) {
            cell_list list = list_types(3);
            const int n = list.n, n_nodes = list.n_nodes;
            for (int k = 0; k < N_BENT_ELEMENTS; k++)
                if (bent_elements[k].type == held[i].nodes)
                    list_cell(&list, &bent_elements[k], held[i].type, NULL);
            planish_file *file = open_list(*state, &list, f);
            if (!file)
                continue;
            planish_cells cells;
            assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
            assert_int_equal(cells.n, n);
            assert_int_equal(file->model.n_other, 1);
            assert_int_equal(file->model.hold[n_nodes], IO_HELD_BY_OTHER);
            planish_file_close(file);
        }
}

/* ---- copies for viewing --------------------------------------------------------------------- */

/** Convert file to name in folder, and open that. */
static planish_file *convert(const char *folder, planish_file *file, const char *name,
                             char lost[256]) {
    char path[TEST_PATH_SIZE];
    planish_file *copy = NULL;
    planish_error error = {.text = ""};
    test_path(path, folder, name);
    if (planish_file_convert(file, path, file->model.coordinates,
                             &(planish_convert_options){.lost = lost, .lost_size = 256}, &error) ||
        planish_file_open(path, NULL, 1, &copy, &error))
        fail_msg("%s", error.text);
    return copy;
}

/** Expect the same cells in both. */
static void check_same_cells(planish_file *a, planish_file *b) {
    planish_cells p, q;
    assert_int_equal(planish_file_cells(a, &p, NULL), 0);
    assert_int_equal(planish_file_cells(b, &q, NULL), 0);
    assert_int_equal(p.n, q.n);
    assert_memory_equal(p.type, q.type, (size_t)p.n);
    assert_memory_equal(p.offset, q.offset, (size_t)(p.n + 1) * sizeof *p.offset);
    assert_memory_equal(p.node, q.node, (size_t)p.offset[p.n] * sizeof *p.node);
}

static void copies_keep_all_types(void **state) {
    for (int dim = 2; dim <= 3; dim++) {
        char lost[256];
        const cell_list list = list_types(dim);
        planish_file *file = open_list(*state, &list, 3);
        file = file ? file : open_list(*state, &list, 2);
        if (!file)
            skip();
        planish_file *vtk = convert(*state, file, "copy.vtk", lost);
        assert_null(strstr(lost, "elements"));
        check_same_cells(file, vtk);
        check_list(vtk, &list, 1);
        if (reading_knows_vtu()) {
            planish_file *vtu = convert(*state, vtk, "copy.vtu", lost);
            assert_null(strstr(lost, "elements"));
            check_same_cells(file, vtu);
            planish_file_close(vtu);
        }
        planish_file_close(vtk);
        planish_file_close(file);
    }
}

/** Without a mid an element is straight, as VTK has none of it with fewer nodes; the middle of a
 *  pyramid's base is left out. Polygons are lost. */
static void copies_do_without_missing_nodes(void **state) {
    static const int32_t pyramid[] = {0, 1, 2, 3, 4, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    char lost[256];
    cell_list list = list_types(3);
    for (int k = 0; k < N_BENT_ELEMENTS; k++)
        if (bent_elements[k].type == PLANISH_CELL_QUADRILATERAL)
            list_cell(&list, &bent_elements[k], 7, NULL);
    file_builder b = make_vtk(&list, 3);
    planish_file *file = open_file(*state, "in.vtk", &b);
    if (!reading_knows_vtu()) {
        planish_file_close(file);
        skip();
    }
    io_others *others = &file->model.solid;
    int order[N_BENT_ELEMENTS + 8];
    const int n_simplices = order_list(&list, order), n = n_simplices + (int)others->n;
    file->model.tetrahedron.mid[5] = -1;
    for (int i = n_simplices; i < n; i++) {
        const int64_t end = others->offset[i - n_simplices + 1];
        const bent_element *e = list.cell[order[i]].element;
        if (e->n_nodes > e->n_corners)
            others->node[end - 1] = -1;
    }
    assert_int_equal(
        io_model_add_other(&file->model, PLANISH_CELL_PYRAMID14, pyramid, IO_NO_ENTITY, 99, NULL),
        0);
    planish_file *vtu = convert(*state, file, "copy.vtu", lost);
    assert_non_null(
        strstr(lost, "nodes in the base of 1 pyramids, 1 elements of other types, mids of "));
    assert_non_null(strstr(lost, " elements that have not all of them"));
    planish_cells p, q;
    assert_int_equal(planish_file_cells(file, &p, NULL), 0);
    assert_int_equal(planish_file_cells(vtu, &q, NULL), 0);
    assert_int_equal(q.n, n + 1);
    for (int i = 0; i < n; i++) {
        const bent_element *e = list.cell[order[i]].element;
        assert_int_equal(q.offset[i + 1] - q.offset[i], e->n_corners);
        assert_memory_equal(q.node + q.offset[i], p.node + p.offset[i],
                            (size_t)e->n_corners * sizeof *q.node);
    }
    assert_int_equal(q.type[n], PLANISH_CELL_PYRAMID13);
    assert_memory_equal(q.node + q.offset[n], pyramid, 13 * sizeof *pyramid);
    planish_file_close(vtu);
    planish_file_close(file);
}

/** Lines and triangles of second order beside tetrahedra are kept with their mids, among straight
 *  ones, and so do copies; a straight facet of an element gets its mids. A polyline of three nodes is no
 *  line of second order. */
static void lower_cells_have_mids(void **state) {
    static const char head[] =
        "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 11 double\n"
        "0 0 0 1 0 0 0 1 0 0 0 1 .5 0 0 .5 .5 0 0 .5 0 0 0 .5 .5 0 .5 0 .5 .5 2 2 2\n";
    static const char cells[] =
        "CELLS 7 38\n3 0 1 4\n6 0 1 2 4 5 6\n10 0 1 2 3 4 5 6 7 8 9\n2 1 10\n3 1 2 3\n"
        "3 0 2 10\n4 1 2 3 10\nCELL_TYPES 7\n21 22 24 3 5 4 10\n";
    static const int32_t line[] = {4, -1}, triangle[] = {4, 5, 6, 5, 9, 8};
    static const int32_t tetrahedron[] = {4, 5, 6, 7, 8, 9, -1, -1, -1, -1, -1, -1};
    char lost[256];
    file_builder b = {.binary = 0};
    builder_text(&b, "%s", head);
    builder_text(&b, "%s", cells);
    planish_file *file = open_file(*state, "in.vtk", &b), *copy = NULL;
    for (int i = 0; i < 2 && file; i++) {
        const io_model *m = &file->model;
        assert_int_equal(m->line.n, 2);
        assert_int_equal(m->triangle.n, 2);
        assert_int_equal(m->tetrahedron.n, 2);
        assert_memory_equal(m->line.mid, line, sizeof line);
        assert_memory_equal(m->triangle.mid, triangle, sizeof triangle);
        assert_memory_equal(m->tetrahedron.mid, tetrahedron, sizeof tetrahedron);
        assert_int_equal(m->hold[4], IO_HELD_BY_LINE | IO_HELD_BY_FACE);
        assert_int_equal(m->hold[9], IO_HELD_BY_FACE);
        assert_int_equal(m->hold[7], 0);
        assert_int_equal(m->hold[10], IO_HELD_BY_LINE | (i == 0 ? IO_HELD_BY_OTHER
                                                                : 0)); /* the polyline is lost */
        copy = reading_knows_vtu() && i == 0 ? convert(*state, file, "copy.vtu", lost) : NULL;
        planish_file_close(file);
        file = copy;
    }
    planish_file_close(file);
}

/** Find the values of an array of a legacy file with n cells: name, type, size bytes each. */
static const uint8_t *find_values(const char *data, size_t length, const char *name, int n,
                                  const char *type, size_t size) {
    char head[64];
    const size_t of_head = (size_t)snprintf(head, sizeof head, "%s 1 %d %s\n", name, n, type);
    for (size_t i = 0; i + of_head + (size_t)n * size <= length; i++)
        if (memcmp(data + i, head, of_head) == 0)
            return (const uint8_t *)data + i + of_head;
    fail_msg("no array %s", name);
    return NULL;
}

/** Copies have the values of elements at these, and none at lower ones between them. */
static void copies_have_values(void **state) {
    enum {
        N = 5,
        N_CELLS = 8
    }; /* two tetrahedra, of which one has mids, before others in a copy */
    static const int index_of[N_CELLS] = {0, 1, -1, -1, -1, 2, 3, 4};
    double value[5][N], bits_of_value;
    uint8_t small[2][N];
    char path[TEST_PATH_SIZE];
    size_t length;
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < 5; k++)
            value[k][i] = 100 * k + i + 0.5;
        small[0][i] = (uint8_t)(1 + i % 3);
        small[1][i] = i & 1;
    }
    file_builder b = {.binary = 0};
    builder_text(&b,
                 "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                 "POINTS 18 double\n0 0 0 4 0 0 0 4 0 0 0 4 2 0 0 2 2 0 0 2 0 0 0 2 2 0 2 0 2 2\n"
                 "4 4 4 9 0 0 9 1 0 8 1 0 8 0 1 9 0 1 9 1 1 8 1 1\n");
    builder_text(&b, "CELLS 8 47\n6 11 12 13 14 15 16\n3 0 1 2\n10 0 1 2 3 4 5 6 7 8 9\n2 1 2\n"
                     "4 1 2 3 10\n3 1 2 3\n6 17 12 13 14 15 16\n5 11 12 13 14 16\n"
                     "CELL_TYPES 8\n13 5 24 3 10 5 13 14\n");
    planish_file *file = open_file(*state, "in.vtk", &b);
    const planish_convert_options data = {.radius_ratio = value[0],
                                          .cells = {.aspect_ratio = value[1],
                                                    .scaled_jacobian = value[2],
                                                    .jacobian_ratio = value[3],
                                                    .edge_ratio = value[4],
                                                    .state = small[0],
                                                    .is_curved = small[1]}};
    static const char *const names[] = {"radius_ratio", "aspect_ratio", "scaled_jacobian",
                                        "jacobian_ratio", "edge_ratio"};
    assert_int_equal(planish_file_convert(file, test_path(path, *state, "values.vtk"),
                                          file->model.coordinates, &data, NULL),
                     0);
    char *copy = test_read(path, &length);
    for (int k = 0; k < 5; k++) {
        const uint8_t *at = find_values(copy, length, names[k], N_CELLS, "double", 8);
        for (int i = 0; i < N_CELLS; i++, at += 8) {
            uint64_t bits = 0;
            for (int j = 0; j < 8; j++)
                bits = bits << 8 | at[j];
            memcpy(&bits_of_value, &bits, sizeof bits);
            const int of = k == 0 && index_of[i] > 1 ? -1 : index_of[i]; /* of simplices alone */
            assert_true(of < 0 ? isnan(bits_of_value) : bits_of_value == value[k][of]);
        }
    }
    const uint8_t *states = find_values(copy, length, "cell_state", N_CELLS, "unsigned_char", 1);
    const uint8_t *curved = find_values(copy, length, "is_curved", N_CELLS, "unsigned_char", 1);
    for (int i = 0; i < N_CELLS; i++) {
        assert_int_equal(states[i], index_of[i] < 0 ? 0 : small[0][index_of[i]]);
        assert_int_equal(curved[i], index_of[i] < 0 ? 0 : small[1][index_of[i]]);
    }
    free(copy);
    planish_file_close(file);
}

/* ---- quadrilaterals beside triangles -------------------------------------------------------- */

/** Quadrilaterals that are not in one plane with the triangles make a surface in space of both. */
static void a_plane_is_for_all_elements(void **state) {
    for (int is_off = 0; is_off < 2; is_off++) {
        file_builder b = {.binary = 0};
        planish_cells cells;
        builder_text(&b,
                     "# vtk DataFile Version 3.0\n\nASCII\nDATASET UNSTRUCTURED_GRID\n"
                     "POINTS 5 double\n0 0 1 1 0 2 1 1 2 0 1 1 2 0 %d\n"
                     "CELLS 2 9\n4 0 1 2 3\n3 1 4 2\nCELL_TYPES 2\n9 5\n",
                     is_off ? 4 : 3);
        planish_file *file = open_file(*state, "in.vtk", &b);
        assert_int_equal(planish_file_mesh(file).dim, is_off ? 3 : 2);
        assert_int_equal(planish_file_cells(file, &cells, NULL), 0);
        assert_int_equal(cells.n, 2);
        assert_int_equal(planish_file_mesh(file).n_elements, 2);
        planish_file_close(file);
    }
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(another_order_is_not_valid), IN_A_FOLDER(all_types_are_read),
        IN_A_FOLDER(other_names_of_types_are_read),   IN_A_FOLDER(unmeasured_types_are_held),
        IN_A_FOLDER(copies_keep_all_types),           IN_A_FOLDER(copies_do_without_missing_nodes),
        IN_A_FOLDER(lower_cells_have_mids),           IN_A_FOLDER(copies_have_values),
        IN_A_FOLDER(a_plane_is_for_all_elements),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
