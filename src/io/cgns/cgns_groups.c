/* cgns_groups: which elements and nodes of a CGNS file are called what.
 *
 * A cell belongs to its section, and to each boundary condition that lists it. Cells of one section
 * and the same conditions are a class, which becomes an entity of the model; its names are those of
 * the section, of the conditions and of their families. Nodes in conditions have classes, too.
 */
#ifdef PL_HDF5
#include "io/cgns/cgns.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { NAME_SIZE = 128, NONE = -1 };

/* Conditions that list all elements so many times over are no mesh's. */
enum { MOST_LISTINGS = 64 };

/** Cells or nodes with the same names: those of class before, and condition. */
typedef struct cell_class {
    int32_t before;    /* class, or NONE */
    int32_t condition; /* or NONE: a section's class, or that of all other nodes */
    int32_t moved;     /* class that this one's members in the present condition go to, or NONE */
    int32_t moved_by;  /* the condition that this is for */
} cell_class;

typedef struct condition {
    char *name;             /* owned */
    char family[NAME_SIZE]; /* or "" */
} condition;

typedef struct groups {
    cgns_reader *r;
    cell_class *class; /* [n_classes] those of the sections first */
    int64_t n_classes, class_capacity;
    condition *condition; /* [n_conditions] */
    int64_t n_conditions, condition_capacity;
    int32_t other_nodes; /* class of nodes in no condition */
    int64_t listed;      /* elements and nodes in all conditions */
} groups;

/* ---- classes ------------------------------------------------------------------------------ */

static int add_class(groups *g, int32_t before, int32_t in_condition, int32_t *index) {
    cell_class *grown =
        g->n_classes < INT32_MAX - 1
            ? pl_grow(g->class, g->n_classes, g->n_classes + 1, &g->class_capacity, sizeof *grown)
            : NULL;
    if (!grown)
        return pl_fail_memory(g->r->error, "the groups of the file");
    g->class = grown;
    g->class[g->n_classes] = (cell_class){before, in_condition, NONE, NONE};
    *index = (int32_t)g->n_classes++;
    return PLANISH_OK;
}

/** A member of *class is in the condition, too. */
static int move_member(groups *g, int32_t in_condition, int32_t *class) {
    cell_class *now = &g->class[*class];
    if (now->condition == in_condition) /* listed twice */
        return PLANISH_OK;
    if (now->moved_by != in_condition) {
        int32_t index;
        int status = add_class(g, *class, in_condition, &index);
        if (status)
            return status;
        now = &g->class[*class]; /* the array may have moved */
        now->moved = index;
        now->moved_by = in_condition;
    }
    *class = now->moved;
    return PLANISH_OK;
}

/** Node classes, once there is a condition of nodes. */
static int begin_nodes(groups *g) {
    io_model *model = g->r->model;
    if (model->node_entity)
        return PLANISH_OK;
    int status = add_class(g, NONE, NONE, &g->other_nodes);
    if (status)
        return status;
    model->node_entity = pl_alloc(model->n_nodes, sizeof *model->node_entity);
    if (!model->node_entity)
        return pl_fail_memory(g->r->error, "the groups of nodes");
    for (int64_t i = 0; i < model->n_nodes; i++)
        model->node_entity[i] = g->other_nodes;
    return PLANISH_OK;
}

/* ---- elements by their number -------------------------------------------------------------- */

static const cgns_section *find_section(const cgns_reader *r, int64_t number) {
    int64_t low = 0, high = r->n_sections; /* the first that begins behind number is in there */
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (r->section[middle].start <= number)
            low = middle + 1;
        else
            high = middle;
    }
    return low > 0 && number <= r->section[low - 1].end ? &r->section[low - 1] : NULL;
}

/** The cell of that number: its dimension and *index, or 0 if it is not kept. */
static int find_cell(const cgns_reader *r, const cgns_section *s, int64_t number, int64_t *index) {
    for (int dim = 1; dim <= 3; dim++) {
        const io_cells *cells = io_model_cells(r->model, dim);
        int64_t low = s->first[dim], high = s->behind[dim];
        while (low < high) {
            const int64_t middle = low + (high - low) / 2;
            if (cells->number[middle] < number)
                low = middle + 1;
            else
                high = middle;
        }
        *index = low;
        if (low < s->behind[dim] && cells->number[low] == number)
            return dim;
    }
    return 0;
}

/* ---- lists of elements or nodes ------------------------------------------------------------ */

/** What is done with an element or node that a list names. */
typedef int member_fn(groups *g, const char *path, int is_nodes, int64_t number, int32_t condition);

static int put_in_condition(groups *g, const char *path, int is_nodes, int64_t number,
                            int32_t in_condition) {
    io_model *model = g->r->model;
    if (is_nodes) {
        if (number < 1 || number > model->n_nodes)
            return io_hdf5_fail(g->r->file, path, "node %lld is not in 1 .. %lld",
                                (long long)number, (long long)model->n_nodes);
        return move_member(g, in_condition, &model->node_entity[number - 1]);
    }
    const cgns_section *s = find_section(g->r, number);
    int64_t index;
    const int dim = s ? find_cell(g->r, s, number, &index) : 0;
    /* Conditions may list faces of structured or polyhedral parts that are not there. */
    return dim ? move_member(g, in_condition, &io_model_cells(g->r->model, dim)->entity[index])
               : PLANISH_OK;
}

/** Nodes that are joined with others of the zone stay. */
static int hold_member(groups *g, const char *path, int is_nodes, int64_t number,
                       int32_t in_condition) {
    io_model *model = g->r->model;
    (void)in_condition;
    if (is_nodes) {
        if (number < 1 || number > model->n_nodes)
            return io_hdf5_fail(g->r->file, path, "node %lld is not in 1 .. %lld",
                                (long long)number, (long long)model->n_nodes);
        io_hold_node(model, number - 1, IO_HELD_REQUIRED);
        return PLANISH_OK;
    }
    const cgns_section *s = find_section(g->r, number);
    int64_t index;
    const int dim = s ? find_cell(g->r, s, number, &index) : 0;
    for (int j = 0; dim && j <= dim; j++)
        io_hold_node(model, io_model_cells(g->r->model, dim)->nodes[index * (dim + 1) + j],
                     IO_HELD_REQUIRED);
    return PLANISH_OK;
}

/** Numbers so many may be listed in all. */
static int count_listed(groups *g, const char *path, int64_t n) {
    const cgns_reader *r = g->r;
    const int64_t all = r->model->n_nodes + r->model->line.n + r->model->triangle.n +
                        r->model->tetrahedron.n + r->model->n_other + r->model->n_lower;
    if (n < 0 || n > MOST_LISTINGS * all - g->listed)
        return io_hdf5_fail(r->file, path,
                            "conditions up to this one list elements and nodes more than %d times "
                            "over; the file is damaged",
                            MOST_LISTINGS);
    g->listed += n;
    return PLANISH_OK;
}

static int for_range(groups *g, const char *path, int is_nodes, const io_hdf5_integers *range,
                     member_fn *put, int32_t in_condition) {
    if (range->n != 2)
        return io_hdf5_fail(g->r->file, path, "two numbers were expected");
    const int64_t first = io_hdf5_integer(range, 0), last = io_hdf5_integer(range, 1);
    if (first < 1 || last < first - 1 || last == INT64_MAX)
        return io_hdf5_fail(g->r->file, path, "%lld to %lld is no range", (long long)first,
                            (long long)last);
    int status = count_listed(g, path, last - first + 1);
    for (int64_t i = first; i <= last && !status; i++)
        status = put(g, path, is_nodes, i, in_condition);
    return status;
}

static int for_list(groups *g, const char *path, int is_nodes, const io_hdf5_integers *list,
                    member_fn *put, int32_t in_condition) {
    int status = count_listed(g, path, list->n);
    for (int64_t i = 0; i < list->n && !status; i++)
        status = put(g, path, is_nodes, io_hdf5_integer(list, i), in_condition);
    return status;
}

/** All that a node of CGNS lists: points, which are nodes or elements by its GridLocation, and
 *  elements. */
static int for_members(groups *g, const char *path, member_fn *put, int32_t in_condition) {
    static const struct {
        const char *name;
        int is_points, is_range;
    } lists[] = {{"PointList", 1, 0},
                 {"PointRange", 1, 1},
                 {"PointListDonor", 1, 0},
                 {"ElementList", 0, 0},
                 {"ElementRange", 0, 1}};
    char child[IO_HDF5_PATH_SIZE], location[NAME_SIZE] = "";
    int status = io_hdf5_path(g->r->file, child, "%s/GridLocation", path);
    if (!status)
        status = cgns_text(g->r, child, location, sizeof location);
    const int is_vertex = !location[0] || strcmp(location, "Vertex") == 0;
    for (size_t i = 0; i < sizeof lists / sizeof *lists && !status; i++) {
        io_hdf5_integers numbers = {0};
        status = io_hdf5_path(g->r->file, child, "%s/%s", path, lists[i].name);
        if (status || io_hdf5_kind_of(g->r->file, child) != IO_HDF5_GROUP)
            continue;
        const int is_nodes = lists[i].is_points && is_vertex;
        status = cgns_integers(g->r, child, &numbers);
        if (!status && is_nodes)
            status = begin_nodes(g);
        if (!status)
            status = (lists[i].is_range ? for_range : for_list)(g, child, is_nodes, &numbers, put,
                                                                in_condition);
        io_hdf5_integers_release(&numbers);
    }
    return status;
}

/* ---- conditions and connections ------------------------------------------------------------ */

/** Takes over name, which is NULL then. */
static int add_condition(groups *g, const char *path, char **name) {
    char family[IO_HDF5_PATH_SIZE];
    condition *grown = pl_grow(g->condition, g->n_conditions, g->n_conditions + 1,
                               &g->condition_capacity, sizeof *grown);
    if (!grown)
        return pl_fail_memory(g->r->error, "the groups of the file");
    g->condition = grown;
    condition *c = &g->condition[g->n_conditions++];
    *c = (condition){.name = *name};
    *name = NULL;
    int status = io_hdf5_path(g->r->file, family, "%s/FamilyName", path);
    if (!status)
        status = cgns_text(g->r, family, c->family, sizeof c->family);
    return status ? status : for_members(g, path, put_in_condition, (int32_t)g->n_conditions - 1);
}

/** All children with a label, of children with another, of the zone. */
static int for_grandchildren(groups *g, const char *label, const char *of,
                             int (*take)(groups *g, const char *path, char **name)) {
    char group[IO_HDF5_PATH_SIZE], path[IO_HDF5_PATH_SIZE];
    io_hdf5_names outer, inner;
    int status = cgns_children(g->r, g->r->zone, of, &outer);
    for (int64_t i = 0; i < outer.n && !status; i++) {
        status = io_hdf5_path(g->r->file, group, "%s/%s", g->r->zone, outer.name[i]);
        if (status)
            break;
        status = cgns_children(g->r, group, label, &inner);
        for (int64_t j = 0; j < inner.n && !status; j++) {
            status = io_hdf5_path(g->r->file, path, "%s/%s", group, inner.name[j]);
            if (!status)
                status = take(g, path, &inner.name[j]);
        }
        io_hdf5_names_release(&inner);
    }
    io_hdf5_names_release(&outer);
    return status;
}

static int take_connection(groups *g, const char *path, char **name) {
    (void)name;
    return for_members(g, path, hold_member, NONE);
}

/* ---- entities and names -------------------------------------------------------------------- */

/** The entity of each class in a dimension, in place. */
static int index_entities(groups *g, int dim, int32_t *class, int64_t n, int32_t without) {
    int32_t last = NONE, entity = NONE;
    for (int64_t i = 0; i < n; i++) {
        if (class[i] != last) {
            last = class[i];
            entity = last == without
                         ? NONE
                         : io_model_entity(g->r->model, dim, last + 1, 0, NULL, g->r->error);
            if (entity < 0 && last != without)
                return entity;
        }
        class[i] = entity;
    }
    return PLANISH_OK;
}

static int add_name(groups *g, int32_t class, const char *name) {
    int status = PLANISH_OK;
    for (int dim = 0; dim <= 3 && !status && name[0]; dim++)
        if (io_model_has_entity(g->r->model, dim, class + 1))
            status = io_model_group(g->r->model, dim, class + 1, name, (int64_t)strlen(name),
                                    g->r->error);
    return status;
}

/** The names of a class: of its conditions, their families and its section. */
static int name_class(groups *g, int32_t class) {
    int status = PLANISH_OK;
    int32_t at = class;
    for (; g->class[at].condition != NONE && !status; at = g->class[at].before) {
        const condition *c = &g->condition[g->class[at].condition];
        status = add_name(g, class, c->name);
        if (!status && strcmp(c->family, c->name) != 0)
            status = add_name(g, class, c->family);
    }
    if (!status && at < g->r->n_sections)
        status = add_name(g, class, g->r->section[at].name);
    return status;
}

static int make_entities(groups *g) {
    io_model *model = g->r->model;
    int status = PLANISH_OK;
    for (int dim = 3; dim >= 1 && !status; dim--) {
        io_cells *cells = io_model_cells(g->r->model, dim);
        status = index_entities(g, dim, cells->entity, cells->n, NONE);
    }
    if (!status && model->node_entity)
        status = index_entities(g, 0, model->node_entity, model->n_nodes, g->other_nodes);
    for (int64_t i = 0; i < g->n_classes && !status; i++)
        status = name_class(g, (int32_t)i);
    return status;
}

static int read_groups(groups *g) {
    int32_t index;
    int status = PLANISH_OK;
    for (int64_t i = 0; i < g->r->n_sections && !status; i++)
        status = add_class(g, NONE, NONE, &index);
    if (!status)
        status = for_grandchildren(g, "BC_t", "ZoneBC_t", add_condition);
    if (!status)
        status =
            for_grandchildren(g, "GridConnectivity_t", "ZoneGridConnectivity_t", take_connection);
    return status ? status : make_entities(g);
}

int cgns_read_groups(cgns_reader *r) {
    groups g = {.r = r, .other_nodes = NONE};
    int status = read_groups(&g);
    for (int64_t i = 0; i < g.n_conditions; i++)
        pl_free(g.condition[i].name);
    pl_free(g.condition);
    pl_free(g.class);
    return status;
}

#endif
