/* med: MED files (Salome, Code_Aster, Code_Saturne), versions 2.3 to 4: one unstructured mesh of
 * one step, with nodal connectivity.
 *
 * Nodes and elements are numbered by their place, from 1; all nodes' x stand before all y. Read are
 * nodes, lines, triangles and tetrahedra of first and second order with their families and the
 * groups of these, and other elements of two or three dimensions. Polygons and the like hold their
 * nodes. Solid elements are mirrored to VTK's; the mids of their edges follow
 * in VTK's order. All else of the file (fields, profiles, other properties) is not looked at.
 */
#ifdef PL_HDF5
#include "io/core/elements.h"
#include "io/core/format.h"
#include "io/hdf5/hdf5.h"
#include "io/core/records.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

#define MESHES "/ENS_MAA"

typedef struct med_reader {
    io_model *model;
    io_hdf5 *file;
    planish_error *error;
    io_hdf5_path mesh; /* group of the mesh, */
    io_hdf5_path step; /* and of its nodes and elements */
    const char *name;  /* of the mesh */
} med_reader;

/* ---- types of elements -------------------------------------------------------------------- */

static const io_element_type types[] = {
    {"TE4", IO_TETRAHEDRON, 1, 4},   {"TR3", IO_TRIANGLE, 1, 3},
    {"SE2", IO_LINE, 1, 2},          {"PO1", IO_POINT, 1, 1},
    {"SE3", IO_LINE, 2, 3},          {"SE4", IO_LINE, 3, 4},
    {"T10", IO_TETRAHEDRON, 2, 10},  {"TE10", IO_TETRAHEDRON, 2, 10},
    {"TR6", IO_TRIANGLE, 2, 6},      {"TR7", IO_TRIANGLE, 2, 7},
    {"QU4", IO_QUADRILATERAL, 1, 4}, {"QU8", IO_QUADRILATERAL, 2, 8},
    {"QU9", IO_QUADRILATERAL, 2, 9}, {"PY5", IO_PYRAMID, 1, 5},
    {"P13", IO_PYRAMID, 2, 13},      {"PE6", IO_PRISM, 1, 6},
    {"P15", IO_PRISM, 2, 15},        {"P18", IO_PRISM, 2, 18},
    {"HE8", IO_HEXAHEDRON, 1, 8},    {"H20", IO_HEXAHEDRON, 2, 20},
    {"H27", IO_HEXAHEDRON, 2, 27},
};
enum { N_TYPES = sizeof types / sizeof *types, MOST_NODES = 27 };

/** Types whose nodes stand in another order than VTK's: the middles of faces come from the bottom to
 *  the top. */
static const io_node_order node_order[] = {
    {PLANISH_CELL_HEXAHEDRON27, {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11, 12, 13,
                                 14, 15, 16, 17, 18, 19, 24, 22, 21, 23, 20, 25, 26}},
    {0, {0}},
};

/* ---- the mesh ----------------------------------------------------------------------------- */

/** Fail unless there is no such attribute, or its value is the wanted one. */
static int demand(med_reader *r, const char *path, const char *name, int64_t wanted,
                  const char *otherwise) {
    int64_t value = wanted;
    const int status = io_hdf5_attribute(r->file, path, name, &value, NULL);
    return status || value == wanted ? status : io_hdf5_fail(r->file, path, "%s", otherwise);
}

/** Find the mesh called r->name, and the step of its nodes and elements. */
static int find_mesh(med_reader *r) {
    io_hdf5_names steps;
    r->mesh = r->step = io_hdf5_path_of(r->file, MESHES "/%s", r->name);
    const char *const mesh = r->mesh.text;
    int status = demand(r, mesh, "TYP", 0,
                        "a structured mesh; planish smooths unstructured meshes of tetrahedra or "
                        "triangles");
    if (!status)
        status = demand(r, mesh, "REP", 0,
                        "its coordinates are cylindrical or spherical; planish reads cartesian "
                        "ones");
    const io_hdf5_path nodes = io_hdf5_path_of(r->file, "%s/NOE", mesh);
    if (status || io_hdf5_kind_of(r->file, nodes.text) == IO_HDF5_GROUP) /* before 3: no steps */
        return status;
    status = io_hdf5_list(r->file, mesh, &steps);
    if (!status)
        status = io_hdf5_check_only(r->file, mesh, "step of computation", &steps);
    if (!status)
        r->step = io_hdf5_path_of(r->file, "%s/%s", mesh, steps.name[0]);
    return status;
}

/* ---- numbers beside elements or nodes ------------------------------------------------------ */

/** Read whole numbers called name in a group, n of them, or none if there is no such data. */
static int read_optional(med_reader *r, const char *group, const char *name, int64_t n,
                         io_hdf5_integers *numbers) {
    const io_hdf5_path path = io_hdf5_path_of(r->file, "%s/%s", group, name);
    *numbers = (io_hdf5_integers){.n = 0};
    if (io_hdf5_kind_of(r->file, path.text) == IO_HDF5_NONE)
        return PLANISH_OK;
    const int status = io_hdf5_integers_read(r->file, path.text, numbers);
    return status || numbers->n == n ? status
                                     : io_hdf5_fail(r->file, path.text, "%lld numbers for %lld",
                                                    (long long)numbers->n, (long long)n);
}

/** Find the entities of the families of n cells or nodes; none: the family that has no entity. */
static int take_families(med_reader *r, const char *group, int dim,
                         const io_hdf5_integers *families, int64_t n, int64_t none,
                         int32_t *entity) {
    for (int64_t i = 0; i < n; i++) {
        const int64_t family = families->n ? io_hdf5_integer(families, i) : 0;
        if (family < INT32_MIN || family > INT32_MAX)
            return io_hdf5_fail(r->file, group, "family %lld of number %lld is out of range",
                                (long long)family, (long long)i + 1);
        entity[i] = (int32_t)family;
    }
    return io_model_index_tags_but(r->model, dim, none, entity, n, r->error);
}

/* ---- nodes -------------------------------------------------------------------------------- */

/** Make nodes of the coordinates in their group. */
static int read_coordinates(med_reader *r, const char *group) {
    const io_hdf5_path path = io_hdf5_path_of(r->file, "%s/COO", group);
    int64_t dim = 3;
    int found;
    io_hdf5_shape shape = {0};
    int status = io_hdf5_attribute(r->file, r->mesh.text, "ESP", &dim, &found);
    if (!status && !found) /* older files: of space and mesh together */
        status = io_hdf5_attribute(r->file, r->mesh.text, "DIM", &dim, NULL);
    if (!status && dim != 2 && dim != 3)
        status =
            io_hdf5_fail(r->file, r->mesh.text,
                         "a mesh in %lld dimensions; planish smooths in 2 and 3", (long long)dim);
    if (!status)
        status = io_hdf5_shape_of(r->file, path.text, &shape);
    if (!status && shape.n % dim)
        status = io_hdf5_fail(r->file, path.text,
                              "%lld coordinates do not make nodes of %lld coordinates",
                              (long long)shape.n, (long long)dim);
    const int64_t n = shape.n / (dim > 0 ? dim : 1);
    if (!status)
        status = demand(r, path.text, "NBR", n, "its attribute NBR is another number of nodes");
    if (!status)
        status = io_model_alloc_nodes(r->model, n, 0, r->error);
    if (status)
        return status;
    r->model->columns = (int)dim;
    const io_hdf5_place place = {path, 0, (int)dim, 1, n, 0, 0};
    status = io_hdf5_coordinates(r->file, &place);
    return status ? status : io_hdf5_coordinates_end(r->file);
}

/** Read the nodes, their numbers and families. */
static int read_nodes(med_reader *r) {
    io_model *model = r->model;
    const io_hdf5_path group = io_hdf5_path_of(r->file, "%s/NOE", r->step.text);
    io_hdf5_integers families = {0}, numbers = {0};
    int64_t counted = 0; /* first nodes with the numbers 1, 2, 3 ... */
    int status = read_coordinates(r, group.text);
    if (!status)
        status = read_optional(r, group.text, "NUM", model->n_nodes, &numbers);
    model->first_number = 1;
    while (!status && counted < numbers.n && io_hdf5_integer(&numbers, counted) == counted + 1)
        counted++;
    if (!status && counted < numbers.n) {
        model->node_number = pl_alloc(model->n_nodes, sizeof *model->node_number);
        if (!model->node_number)
            status = pl_fail_memory(r->error, "the numbers of nodes");
        for (int64_t i = 0; i < numbers.n && !status; i++)
            model->node_number[i] = io_hdf5_integer(&numbers, i);
    }
    if (!status)
        status = read_optional(r, group.text, "FAM", model->n_nodes, &families);
    if (!status && families.n > 0) {
        model->node_entity = pl_alloc(model->n_nodes, sizeof *model->node_entity);
        status = model->node_entity ? take_families(r, group.text, 0, &families, model->n_nodes, 0,
                                                    model->node_entity)
                                    : pl_fail_memory(r->error, "the families of nodes");
    }
    io_hdf5_integers_release(&families);
    io_hdf5_integers_release(&numbers);
    return status;
}

/* ---- elements ----------------------------------------------------------------------------- */

/** Elements of one type: node j of element i is number j * n + i of the list. */
typedef struct element_block {
    io_hdf5_path group, path; /* path: of the list */
    const io_element_type *type;
    io_hdf5_integers nodes;
    int64_t n; /* elements */
} element_block;

/** Take number i of the list, a node: its index. */
static int take_node(med_reader *r, const element_block *b, int64_t i, int64_t *node) {
    const int64_t number = io_hdf5_integer(&b->nodes, i);
    *node = number - 1;
    if (number >= 1 && number <= r->model->n_nodes)
        return PLANISH_OK;
    return io_hdf5_fail(r->file, b->path.text, "element %lld: node %lld is not in 1 .. %lld",
                        (long long)(b->n > 0 ? i % b->n : 0) + 1, (long long)number,
                        (long long)r->model->n_nodes);
}

/** Make room for n cells of a dimension behind those of another type, which get numbers, too. */
static int reserve_more(med_reader *r, int dim, int64_t n, int with_number) {
    io_cells *cells = io_model_cells(r->model, dim);
    if (cells->nodes && !cells->number && (cells->n > 0 || with_number)) {
        cells->number = pl_alloc(cells->capacity, sizeof *cells->number);
        if (!cells->number)
            return pl_fail_memory(r->error, "the numbers of elements");
        for (int64_t i = 0; i < cells->n; i++)
            cells->number[i] = cells->first_number + i;
    }
    return io_cells_reserve(r->model, dim, n, 1, with_number || cells->number, r->error);
}

/** Read the mids of elements of second order, cells from first on. */
static int read_mids(med_reader *r, const element_block *b, int dim, int64_t first) {
    int status = io_cells_reserve_mids(r->model, dim, r->error);
    for (int64_t i = 0; i < b->n && !status; i++) {
        int32_t nodes[MOST_NODES] = {0};
        for (int64_t j = 0; j < b->type->nodes && !status; j++) {
            int64_t node;
            status = take_node(r, b, j * b->n + i, &node);
            nodes[j] = (int32_t)node;
        }
        if (!status)
            io_cells_set_mids(r->model, dim, first + i, nodes);
    }
    return status;
}

static int read_cells(med_reader *r, const element_block *b) {
    const int dim = io_element_dim(b->type), corners = dim + 1;
    io_cells *cells = io_model_cells(r->model, dim);
    const int64_t first = cells->n;
    io_hdf5_integers families = {0}, numbers = {0};
    int status = read_optional(r, b->group.text, "FAM", b->n, &families);
    if (!status)
        status = read_optional(r, b->group.text, "NUM", b->n, &numbers);
    if (!status)
        status = reserve_more(r, dim, b->n, numbers.n > 0);
    for (int64_t j = 0; j < corners; j++)
        for (int64_t i = 0; i < b->n && !status; i++) {
            int64_t node;
            status = take_node(r, b, j * b->n + i, &node);
            cells->nodes[(first + i) * corners + j] = status ? 0 : (int32_t)node;
        }
    if (!status && io_element_mids(b->type))
        status = read_mids(r, b, dim, first);
    for (int64_t i = 0; cells->number && i < b->n && !status; i++)
        cells->number[first + i] = numbers.n > 0 ? io_hdf5_integer(&numbers, i) : i + 1;
    if (!status)
        status =
            take_families(r, b->group.text, dim, &families, b->n, INT64_MIN, cells->entity + first);
    if (!status) {
        cells->first_number = 1;
        cells->n = first + b->n;
    }
    io_hdf5_integers_release(&families);
    io_hdf5_integers_release(&numbers);
    return status;
}

/** Hold the nodes of elements that have no planish_cell_type. Polygons and polyhedra list the nodes of one
 *  element after another; all are nodes. */
static int hold_nodes(med_reader *r, const element_block *b) {
    int status = PLANISH_OK;
    io_element_count(r->model, b->type, b->n);
    for (int64_t i = 0; i < b->nodes.n && !status; i++) {
        int64_t node;
        status = take_node(r, b, i, &node);
        if (!status)
            io_hold_node(r->model, node, io_element_reason(b->type));
    }
    return status;
}

/** Add elements that are no simplices of order 1 or 2. */
static int add_others(med_reader *r, const element_block *b, int type) {
    const int dim = io_element_dim(b->type);
    io_others *others = io_model_others(r->model, dim);
    const int64_t first = others->n;
    io_hdf5_integers families = {0}, numbers = {0};
    int status = read_optional(r, b->group.text, "FAM", b->n, &families);
    if (!status)
        status = read_optional(r, b->group.text, "NUM", b->n, &numbers);
    io_element_count(r->model, b->type, b->n);
    for (int64_t i = 0; i < b->n && !status; i++) {
        int32_t node[MOST_NODES];
        for (int64_t j = 0; j < b->type->nodes && !status; j++) {
            int64_t index;
            status = take_node(r, b, j * b->n + i, &index);
            node[j] = (int32_t)index;
        }
        if (!status)
            status =
                io_model_add_other(r->model, type, node, 0,
                                   numbers.n > 0 ? io_hdf5_integer(&numbers, i) : i + 1, r->error);
    }
    if (!status && b->n > 0)
        status = take_families(r, b->group.text, dim, &families, b->n, INT64_MIN,
                               others->entity + first);
    io_hdf5_integers_release(&families);
    io_hdf5_integers_release(&numbers);
    return status;
}

/** Find the number of elements in a list of nodes of which each has the same number. */
static int count_elements(med_reader *r, element_block *b) {
    const int nodes = b->type->nodes;
    b->n = b->nodes.n / nodes;
    if (b->nodes.n % nodes)
        return io_hdf5_fail(r->file, b->path.text, "%lld numbers do not make elements of %d nodes",
                            (long long)b->nodes.n, nodes);
    return demand(r, b->path.text, "NBR", b->n, "its attribute NBR is another number of elements");
}

/** Read the elements of the type with that name in the file. */
static int read_block(med_reader *r, const char *name) {
    static const io_element_type other = {NULL, IO_ANY_SHAPE, 1, 0};
    element_block b = {.type = &other};
    for (int i = 0; i < N_TYPES; i++)
        if (strcmp(types[i].name, name) == 0)
            b.type = &types[i];
    const int is_kept = io_element_use(b.type) == IO_KEEP; /* MED has none of third order */
    const int type = is_kept ? 0 : io_cell_type(b.type->shape, b.type->nodes);
    b.group = io_hdf5_path_of(r->file, "%s/MAI/%s", r->step.text, name);
    b.path = io_hdf5_path_of(r->file, "%s/NOD", b.group.text);
    if (io_hdf5_kind_of(r->file, b.path.text) != IO_HDF5_DATASET)
        return io_hdf5_fail(r->file, b.path.text,
                            "these elements list no nodes (planish reads nodal connectivity, not "
                            "descending connectivity)");
    int status = io_hdf5_integers_read(r->file, b.path.text, &b.nodes);
    if (!status && (is_kept || type)) {
        status = count_elements(r, &b);
    } else if (!status) {
        status = io_hdf5_attribute(r->file, b.path.text, "NBR", &b.n, NULL);
        if (b.n < 0 || b.n > b.nodes.n)
            b.n = 0; /* no more than a figure to be told */
    }
    if (!status)
        status = is_kept ? read_cells(r, &b) : type ? add_others(r, &b, type) : hold_nodes(r, &b);
    io_hdf5_integers_release(&b.nodes);
    return status;
}

/** Read the elements of all types. */
static int read_elements(med_reader *r) {
    const io_hdf5_path group = io_hdf5_path_of(r->file, "%s/MAI", r->step.text);
    io_hdf5_names names;
    r->model->node_order = node_order;
    if (io_hdf5_kind_of(r->file, group.text) != IO_HDF5_GROUP)
        return PLANISH_OK;
    int status = io_hdf5_list(r->file, group.text, &names);
    for (int64_t i = 0; i < names.n && !status; i++)
        status = read_block(r, names.name[i]);
    return status;
}

/* ---- groups of families ------------------------------------------------------------------- */

/** Read the groups that a family is of. io_group is of one dimension: there is one for each that the
 *  elements of the family have. */
static int read_family(med_reader *r, const char *path, int is_of_nodes) {
    const io_hdf5_path names = io_hdf5_path_of(r->file, "%s/GRO/NOM", path);
    char *text = NULL;
    int64_t family = 0, n = 0, size = 0;
    int found;
    int status = io_hdf5_attribute(r->file, path, "NUM", &family, &found);
    if (!status && !found)
        status = io_hdf5_fail(r->file, path, "a family without its number (attribute NUM)");
    if (status || family < INT32_MIN || family > INT32_MAX ||
        io_hdf5_kind_of(r->file, names.text) == IO_HDF5_NONE)
        return status;
    status = io_hdf5_strings_read(r->file, names.text, &text, &n, &size);
    for (int64_t i = 0; i < n && !status; i++) {
        const char *name = text + i * size, *end = memchr(name, '\0', (size_t)size);
        int64_t length = end ? end - name : size;
        while (length > 0 && name[length - 1] == ' ') /* zeros or blanks fill up its place */
            length--;
        for (int dim = is_of_nodes ? 0 : 1; dim <= (is_of_nodes ? 0 : 3) && !status; dim++)
            if (length > 0 && io_model_has_entity(r->model, dim, (int32_t)family))
                status = io_model_group(r->model, dim, (int32_t)family, name, length, r->error);
    }
    pl_free(text);
    return status;
}

/** Read the families of elements (ELEME) or nodes (NOEUD). */
static int read_families(med_reader *r, const char *of) {
    const io_hdf5_path group = io_hdf5_path_of(r->file, "/FAS/%s/%s", r->name, of);
    io_hdf5_names names;
    if (io_hdf5_kind_of(r->file, group.text) != IO_HDF5_GROUP)
        return PLANISH_OK;
    int status = io_hdf5_list(r->file, group.text, &names);
    for (int64_t i = 0; i < names.n && !status; i++)
        status = read_family(r, io_hdf5_path_of(r->file, "%s/%s", group.text, names.name[i]).text,
                             strcmp(of, "NOEUD") == 0);
    return status;
}

/* ---- the format --------------------------------------------------------------------------- */

static int med_read(io_model *model, planish_error *error) {
    med_reader r = {.model = model, .error = error};
    io_hdf5_names meshes = {0};
    int status = io_hdf5_open(model, &r.file, error);
    if (!status)
        status = io_hdf5_list(r.file, MESHES, &meshes);
    if (!status)
        status = io_hdf5_check_only(r.file, MESHES, "mesh", &meshes);
    if (!status) {
        r.name = meshes.name[0];
        status = find_mesh(&r);
    }
    if (!status)
        status = read_nodes(&r);
    if (!status)
        status = read_elements(&r);
    if (!status)
        status = read_families(&r, "ELEME");
    if (!status)
        status = read_families(&r, "NOEUD");
    return io_hdf5_end(r.file, status);
}

static int med_recognise(const char *data, int64_t size) {
    return io_hdf5_recognise(data, size, MESHES);
}

static const char *const extensions[] = {".med", ".mmed", ".rmed", NULL};

const io_format io_format_med = {.name = "med",
                                 .extensions = extensions,
                                 .recognise = med_recognise,
                                 .read = med_read,
                                 .amend = io_hdf5_amend,
                                 .release = io_hdf5_release};

#endif
