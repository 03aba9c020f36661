/* cgns: CGNS files in HDF5: one base with one unstructured zone.
 *
 * Read are the coordinates, the sections of elements, the names of boundary conditions, and values
 * of cells that may tell regions. All else (descriptors, say) is not looked at. Nodes are numbered
 * from 1, elements as their sections say.
 */
#ifdef PL_HDF5
#include "io/cgns/cgns_reader.h"
#include "io/core/arrays.h"
#include "io/core/format.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { TEXT_SIZE = 128 };

/* ---- base and zone ------------------------------------------------------------------------ */

/** Find the one child with a label. */
static int find_only(cgns_reader *r, const io_hdf5_path *path, const char *label, const char *what,
                     io_hdf5_path *child) {
    io_hdf5_names names;
    int status = cgns_children(r, path, label, &names);
    if (!status && names.n == 0)
        return io_hdf5_fail(r->file, path->text,
                            "there is no %s (no node with the label %s; files that meshio writes "
                            "have no labels and are not CGNS files)",
                            what, label);
    if (!status)
        status = io_hdf5_check_only(r->file, path->text, what, &names);
    if (!status)
        *child = cgns_child(r, path, names.name[0]);
    return status;
}

/** Find the base, and how many coordinates nodes have. */
static int read_base(cgns_reader *r) {
    const io_hdf5_path root = {"/"};
    io_hdf5_integers dims = {0};
    int status = find_only(r, &root, "CGNSBase_t", "base", &r->base);
    if (!status)
        status = cgns_integers(r, &r->base, &dims);
    if (!status && dims.n != 2)
        status =
            io_hdf5_fail(r->file, r->base.text, "two dimensions were expected, of cells and space");
    const int64_t space = status ? 0 : io_hdf5_integer(&dims, 1);
    if (!status && space != 2 && space != 3)
        status =
            io_hdf5_fail(r->file, r->base.text,
                         "a mesh in %lld dimensions; planish smooths in 2 and 3", (long long)space);
    r->model->columns = (int)space;
    io_hdf5_integers_release(&dims);
    return status;
}

/** Find the zone, and how many nodes and elements it has. */
static int read_zone(cgns_reader *r, int64_t *n_nodes) {
    char type[TEXT_SIZE] = "";
    io_hdf5_integers size = {0};
    int status = find_only(r, &r->base, "Zone_t", "zone", &r->zone);
    if (!status)
        status = cgns_text(r, &r->zone, "ZoneType", type, sizeof type);
    if (!status && strcmp(type, "Unstructured") != 0)
        status = io_hdf5_fail(r->file, r->zone.text,
                              "a zone of type '%s'; planish smooths unstructured zones of "
                              "tetrahedra or triangles",
                              type[0] ? type : "Structured");
    if (!status)
        status = cgns_integers(r, &r->zone, &size);
    if (!status && (size.n < 3 || io_hdf5_integer(&size, 0) < 0))
        status = io_hdf5_fail(r->file, r->zone.text,
                              "its size was expected: nodes, cells, nodes on the boundary");
    if (!status) {
        *n_nodes = io_hdf5_integer(&size, 0);
        r->n_elements = io_hdf5_integer(&size, 1);
    }
    io_hdf5_integers_release(&size);
    return status;
}

/** Read the coordinates of all nodes, a dataset for each direction. */
static int read_nodes(cgns_reader *r, int64_t n_nodes) {
    io_model *model = r->model;
    const io_hdf5_path grid = cgns_child(r, &r->zone, "GridCoordinates");
    io_hdf5_shape shape;
    int status = PLANISH_OK;
    if (io_hdf5_kind_of(r->file, grid.text) != IO_HDF5_GROUP)
        return io_hdf5_fail(r->file, r->zone.text, "there are no GridCoordinates");
    for (int d = 0; d < model->columns && !status; d++) {
        const io_hdf5_path node = io_hdf5_path_of(r->file, "%s/Coordinate%c", grid.text, "XYZ"[d]);
        const io_hdf5_place place = {cgns_child(r, &node, " data"), d, 1, 1, 0, 0, 0};
        if (io_hdf5_kind_of(r->file, node.text) == IO_HDF5_NONE)
            return io_hdf5_fail(r->file, node.text,
                                "there are no such coordinates (planish reads cartesian ones: "
                                "CoordinateX, CoordinateY, CoordinateZ)");
        /* The first ones tell whether there are as many nodes as the zone says, before room is made
         * for them. */
        if (d == 0)
            status = io_hdf5_shape_of(r->file, place.path.text, &shape);
        if (!status && d == 0 && shape.n != n_nodes)
            return io_hdf5_fail(r->file, place.path.text,
                                "%lld coordinates for %lld nodes (nodes beyond the zone, Rind, "
                                "are not read)",
                                (long long)shape.n, (long long)n_nodes);
        if (!status && d == 0)
            status = io_model_alloc_nodes(model, n_nodes, 0, r->error);
        if (!status)
            status = io_hdf5_coordinates(r->file, &place);
    }
    model->first_number = 1;
    return status ? status : io_hdf5_coordinates_end(r->file);
}

/* ---- solutions ----------------------------------------------------------------------------- */

/* Arrays at CellCenter of one number for each cell are read if all cells of the zone are elements.
 * Of arrays of one name, those of time steps say, the first counts. */

/** List the elements in the order of their numbers, in which both simplices and others stand: element
 *  [n]. */
static void list_in_order(const io_model *model, int64_t n, int32_t *element) {
    const int dim = io_model_dim(model);
    const io_list simplices = io_model_list(model, dim);
    const io_list others = io_model_list(model, io_others_list(dim));
    int64_t at[2] = {0, 0};
    for (int64_t i = 0; i < n; i++) {
        const int is_other = at[0] == simplices.n ||
                             (at[1] < others.n &&
                              io_list_number(&others, at[1]) < io_list_number(&simplices, at[0]));
        element[i] = (int32_t)(is_other ? simplices.n + at[1] : at[0]);
        at[is_other]++;
    }
}

/** Read the arrays of a solution, unless one of their name is seen already. */
static int read_solution(cgns_reader *r, const char *name, const int32_t *element,
                         io_hdf5_names *seen) {
    const io_hdf5_path path = cgns_child(r, &r->zone, name);
    char location[32] = "";
    io_hdf5_names arrays = {0};
    int status = cgns_text(r, &path, "GridLocation", location, sizeof location);
    if (!status && strcmp(location, "CellCenter") == 0)
        status = cgns_children(r, &path, "DataArray_t", &arrays);
    for (int64_t i = 0; i < arrays.n && !status && seen->n < IO_MOST_ARRAYS; i++) {
        int is_seen = 0;
        for (int64_t k = 0; k < seen->n && !is_seen; k++)
            is_seen = strcmp(seen->name[k], arrays.name[i]) == 0;
        if (is_seen)
            continue;
        const io_hdf5_path array = cgns_child(r, &path, arrays.name[i]);
        status = io_hdf5_cell_array(r->file, cgns_child(r, &array, " data").text, arrays.name[i],
                                    r->n_elements, 1, element);
        if (status && status != PLANISH_ERROR_FORMAT)
            break;
        status = io_hdf5_names_add(r->file, seen, arrays.name[i]);
    }
    /* What cannot be read is passed over: solutions need not be for the mesh to be. */
    return status == PLANISH_ERROR_FORMAT ? PLANISH_OK : status;
}

/** Read values of cells that may tell regions, after the groups. */
static int read_solutions(cgns_reader *r) {
    const int64_t n = io_model_n_elements(r->model);
    io_hdf5_names solutions, seen = {0}; /* names of arrays that have been looked at */
    if (n == 0 || n != r->n_elements)
        return PLANISH_OK;
    int status = cgns_children(r, &r->zone, "FlowSolution_t", &solutions);
    int32_t *element = NULL;
    if (!status && solutions.n > 0 && io_model_other_elements(r->model)->n > 0) {
        element = pl_alloc(n, sizeof *element);
        if (!element)
            return pl_fail_memory(r->error, "the arrays of elements");
        list_in_order(r->model, n, element);
    }
    for (int64_t i = 0; i < solutions.n && !status; i++)
        status = read_solution(r, solutions.name[i], element, &seen);
    pl_free(element);
    return status;
}

/* ---- the format --------------------------------------------------------------------------- */

/** Return whether a file is in ADF: its mark is behind four characters with their highest bit set. */
static int is_adf(const char *data, int64_t size) {
    static const char mark[] = "ADF Database Version";
    enum { BEFORE_MARK = 4, LENGTH = sizeof mark - 1 };
    return size >= BEFORE_MARK + LENGTH && memcmp(data + BEFORE_MARK, mark, LENGTH) == 0;
}

static int cgns_read(io_model *model, planish_error *error) {
    cgns_reader r = {.model = model, .error = error};
    int64_t n_nodes = 0;
    if (is_adf(model->input.data, model->input.size))
        return pl_fail(
            error, PLANISH_ERROR_FORMAT,
            "%s: a CGNS file in ADF, the format before HDF5; convert it: adf2hdf IN.cgns "
            "OUT.cgns",
            model->input.path);
    int status = io_hdf5_open(model, &r.file, error);
    if (!status)
        status = read_base(&r);
    if (!status)
        status = read_zone(&r, &n_nodes);
    if (!status)
        status = read_nodes(&r, n_nodes);
    if (!status)
        status = cgns_read_elements(&r);
    if (!status)
        status = cgns_read_groups(&r);
    if (!status)
        status = read_solutions(&r);
    pl_free(r.section);
    return io_hdf5_end(r.file, status);
}

static int cgns_recognise(const char *data, int64_t size) {
    return is_adf(data, size) || io_hdf5_recognise(data, size, "/CGNSLibraryVersion");
}

static const char *const extensions[] = {".cgns", NULL};

const io_format io_format_cgns = {.name = "cgns",
                                  .extensions = extensions,
                                  .recognise = cgns_recognise,
                                  .read = cgns_read,
                                  .amend = io_hdf5_amend,
                                  .release = io_hdf5_release};

#endif
