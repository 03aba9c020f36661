/* regions: which arrays of values per element tell regions, and the regions that they make.
 *
 * In go a mesh and arrays of numbers, one for each element, as files have them. An array looks like
 * regions if its values are whole, if there are two of them at least, and if at most half of the
 * facets inside the mesh lie between different ones: numbers of elements differ at all of them.
 * Some names decide without a look at the facets. Everything is counted in whole numbers, so that
 * threads do not matter.
 */
#include "shape/shape.h"

#include "base/context.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "geometry/cell.h"
#include "topology/cells.h"
#include "topology/facets.h"
#include "topology/topology.h"

#include <inttypes.h>
#include <string.h>

enum {
    CHUNK = 1 << 16, /* values that a thread looks at at a time */
    LINE = 8         /* counters that one thread has at least, so that threads share no line */
};

/* ---- names -------------------------------------------------------------------------------- */

/** Whether the words are the same but for the case of letters. */
static int is_same(const char *a, const char *b) {
    for (; *a && *b; a++, b++) {
        const char x = *a >= 'A' && *a <= 'Z' ? (char)(*a - 'A' + 'a') : *a;
        const char y = *b >= 'A' && *b <= 'Z' ? (char)(*b - 'A' + 'a') : *b;
        if (x != y)
            return 0;
    }
    return *a == *b;
}

/** Whether an array of that name says how a mesh is shared out, or where its elements come from. */
static int is_no_region(const char *name) {
    static const char *const parts[] = {"partition", "ghost", "mpirank", "processor"};
    static const char words[] =
        " rank ranks rankid owner ownerrank owners proc procs procid procids procrank "
        "procnumber processid processids vtkprocessid pieceid metis parmetis scotch npart "
        "epart elementid elementids elemid elemids cellid cellids elementnumber cellnumber "
        "elementnumbers globalid globalids globalelementid globalcellid globalelementids "
        "globalcellids originalid originalids originalcellids vtkoriginalcellids "
        "originalelementids vtkoriginalpointids pedigreeid pedigreeids pedigreeelementid "
        "objectidelement radiusratio aspectratio scaledjacobian jacobianratio edgeratio "
        "cellstate iscurved ";
    /* its letters and digits alone, in small letters, between blanks; a long one is cut */
    char plain[66] = " ";
    size_t n = 1;
    for (; *name && n + 2 < sizeof plain; name++) {
        if (*name >= 'A' && *name <= 'Z')
            plain[n++] = (char)(*name - 'A' + 'a');
        else if ((*name >= 'a' && *name <= 'z') || (*name >= '0' && *name <= '9'))
            plain[n++] = *name;
    }
    plain[n] = ' ';
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        if (strstr(plain, parts[i]))
            return 1;
    return strstr(words, plain) != NULL;
}

int pl_region_name(const char *name) {
    /* Written by: this program; Gmsh's mesh and meshio's; Medit's by meshio; Gmsh's own VTK files;
     * dolfinx; ParaView, OpenGeoSys and MOOSE. */
    static const char *const names[] = {
        "region",    "gmsh:geometrical", "gmsh:physical", "medit:ref", "CellEntityIds",
        "cell_tags", "MaterialIDs",      "MaterialId",    "material",  "regionId",
        "RegionIds", "subdomain_id",     "BlockId",       "attribute"};
    if (!name)
        return 0;
    for (int i = 0; i < (int)(sizeof names / sizeof *names); i++)
        if (is_same(name, names[i]))
            return i + 1;
    return is_no_region(name) ? -1 : 0;
}

/* ---- values ------------------------------------------------------------------------------- */

/** Return a real number as a whole one; -1: it is none, or is out of range. */
static int take_real(double value, int64_t *whole) {
    const double limit = 9223372036854775808.0; /* 2^63 */
    if (!(value >= -limit && value < limit))
        return -1;
    *whole = (int64_t)value;
    return (double)*whole == value ? 0 : -1;
}

/** Return value i as a whole number; -1: it is none. Unsigned ones of 64 bits are taken by their
 * bits: only whether values are the same matters. */
static int take_value(const planish_cell_array *array, int64_t i, int64_t *value) {
    switch (array->type) {
    case PLANISH_NUMBER_INT8:
        *value = ((const int8_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_INT16:
        *value = ((const int16_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_INT32:
        *value = ((const int32_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_INT64:
        *value = ((const int64_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_UINT8:
        *value = ((const uint8_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_UINT16:
        *value = ((const uint16_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_UINT32:
        *value = ((const uint32_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_UINT64:
        *value = (int64_t)((const uint64_t *)array->values)[i];
        return 0;
    case PLANISH_NUMBER_FLOAT32:
        return take_real((double)((const float *)array->values)[i], value);
    case PLANISH_NUMBER_FLOAT64:
        return take_real(((const double *)array->values)[i], value);
    }
    return -1;
}

size_t pl_number_size(planish_number type) {
    static const size_t size[] = {4, 8, 1, 2, 1, 2, 4, 8, 4, 8}; /* in the order of the enum */
    return size[type];
}

int pl_check_cell_arrays(const planish_cell_array *arrays, int n_arrays, int64_t n_elements,
                         planish_error *error) {
    if (n_arrays < 0 || (n_arrays > 0 && !arrays))
        return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                       "n_arrays is %d, and arrays must have so many", n_arrays);
    for (int i = 0; i < n_arrays; i++) {
        if (!arrays[i].values && n_elements > 0)
            return pl_fail(error, PLANISH_ERROR_ARGUMENT, "array %d has no values", i);
        if ((int)arrays[i].type < PLANISH_NUMBER_INT32 ||
            (int)arrays[i].type > PLANISH_NUMBER_FLOAT64)
            return pl_fail(error, PLANISH_ERROR_ARGUMENT,
                           "array %d: its type is %d, which is not a planish_number", i,
                           (int)arrays[i].type);
        const int status = pl_check_reserved("planish_cell_array", arrays[i].reserved,
                                             sizeof arrays[i].reserved, error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Result of a scan of an array's values. */
typedef struct value_scan {
    const planish_cell_array *array;
    int64_t first; /* value 0 */
    uint8_t is_broken, differs;
} value_scan;

static void scan_chunk(void *context, int64_t begin, int64_t end, int thread) {
    value_scan *scan = context;
    int broken = 0, differs = 0;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        int64_t value = 0;
        broken |= take_value(scan->array, i, &value);
        differs |= value != scan->first;
    }
    if (broken)
        pl_set_flag(&scan->is_broken, 1);
    if (differs)
        pl_set_flag(&scan->differs, 1);
}

/** Whether all values are whole, and there are two of them at least. */
static int has_values(const planish_cell_array *array, int64_t n, int threads) {
    value_scan scan = {.array = array};
    if (n == 0 || take_value(array, 0, &scan.first))
        return 0;
    pl_parallel_for(pl_paying_threads(threads, n), n, CHUNK, scan_chunk, &scan);
    return !scan.is_broken && scan.differs;
}

/* ---- the rule ----------------------------------------------------------------------------- */

/** Facets inside the mesh, and those between different values of each array. */
typedef struct tally {
    planish_cell_array *const *array; /* [n] */
    int n;
    int64_t row;    /* counters of a thread: [n] arrays, and all facets */
    int64_t *count; /* [threads][row] */
} tally;

static void count_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                         int thread) {
    const tally *t = context;
    int64_t *count = t->count + thread * t->row;
    (void)node;
    for (const pl_facet *facet = facets; facet < facets + n_facets; facet++) {
        if (facet->count < 2)
            continue;
        count[t->n]++;
        for (int i = 0; i < t->n; i++) {
            int64_t value[2] = {0};
            for (int j = 0; j < 2; j++)
                (void)take_value(t->array[i], facet->element[j], &value[j]);
            count[i] += value[0] != value[1];
        }
    }
}

/** Count the facets of simplices. */
static int count_of_simplices(const planish_mesh *mesh, int threads, tally *t,
                              planish_error *error) {
    pl_incidence incidence;
    int status = pl_incidence_create(mesh, NULL, threads, &incidence, error);
    if (!status)
        status = pl_facets_match(mesh, &incidence, NULL, threads, count_facets, t, error);
    pl_incidence_destroy(&incidence);
    return status;
}

/** Count the facets of cells of any types. */
static int count_of_cells(const planish_mesh *mesh, int threads, tally *t, planish_error *error) {
    const planish_cells *cells = mesh->cells;
    const int64_t n = cells->n * PL_CELL_FACET_PLACES;
    int32_t *with = pl_alloc(n, sizeof *with);
    uint8_t *n_sharing = pl_alloc(n, sizeof *n_sharing);
    const int status = with && n_sharing
                           ? pl_cell_facets_find(cells, mesh->dim, mesh->n_nodes, NULL, threads,
                                                 with, n_sharing, error)
                           : pl_fail_memory(error, "the arrays of elements");
    for (int64_t i = 0; !status && i < n; i++) {
        const pl_facet facet = {.count = 2,
                                .element = {with[i], (int32_t)(i / PL_CELL_FACET_PLACES)}};
        if (with[i] >= 0)
            count_facets(t, 0, &facet, 1, 0);
    }
    pl_free(with);
    pl_free(n_sharing);
    return status;
}

/** Decide which of the arrays candidate [n] look like regions: looks [n] is filled with 0 or 1. */
static int judge(const planish_mesh *mesh, planish_cell_array *const *candidate, int n, int threads,
                 uint8_t *looks, planish_error *error) {
    tally t = {.array = candidate, .n = n, .row = pl_counts_row((int64_t)n + 1) + LINE};
    t.count = pl_alloc_zero(threads * t.row, sizeof *t.count);
    int status = !t.count      ? pl_fail_memory(error, "the arrays of elements")
                 : mesh->cells ? count_of_cells(mesh, threads, &t, error)
                               : count_of_simplices(mesh, threads, &t, error);
    for (int thread = 1; thread < threads && !status; thread++)
        for (int i = 0; i <= n; i++)
            t.count[i] += t.count[thread * t.row + i];
    for (int i = 0; i < n && !status; i++)
        looks[i] = t.count[i] <= t.count[n] - t.count[i];
    pl_free(t.count);
    return status;
}

int pl_find_regions(const planish_mesh *mesh, planish_cell_array *arrays, int n_arrays, int threads,
                    planish_error *error) {
    planish_cell_array *sure = NULL; /* its name is the most telling one: it needs no look */
    planish_cell_array **candidate = pl_alloc(n_arrays, sizeof(planish_cell_array *));
    uint8_t *looks = pl_alloc_zero(n_arrays, 1);
    int n = 0, sure_rank = 0;
    int status = candidate && looks ? PLANISH_OK : pl_fail_memory(error, "the arrays of elements");
    for (int i = 0; i < n_arrays && !status; i++) {
        planish_cell_array *array = &arrays[i];
        const int rank = pl_region_name(array->name);
        if (rank < 0 || !has_values(array, mesh->n_elements, threads))
            continue;
        if (rank > 0 && (!sure || rank < sure_rank)) {
            planish_cell_array *before = sure;
            sure = array;
            sure_rank = rank;
            array = before;
        }
        if (array)
            candidate[n++] = array;
    }
    if (!status && n > 0)
        status = judge(mesh, candidate, n, threads, looks, error);
    for (int i = 0; i < n_arrays && !status; i++)
        arrays[i].is_region = &arrays[i] == sure;
    for (int i = 0; i < n && !status; i++)
        candidate[i]->is_region = looks[i];
    pl_free(candidate);
    pl_free(looks);
    return status;
}

/* ---- combining ---------------------------------------------------------------------------- */

/** Pair of a region and the value of one more array, and the region that it makes. */
typedef struct slot {
    int64_t value;
    int32_t before, number; /* number < 0: the slot is free */
} slot;

/** Pairs by their values. */
typedef struct table {
    slot *slot;      /* [n_slots] */
    int64_t n_slots; /* a power of two, at least twice as many as there are pairs */
    int64_t n;
} table;

/** Return the slot of a pair, or the free one where it belongs. */
static slot *find_slot(const table *t, int32_t before, int64_t value) {
    const uint64_t mask = (uint64_t)t->n_slots - 1;
    uint64_t at = (uint64_t)value * 0x9e3779b97f4a7c15u + (uint32_t)before;
    at = (at ^ at >> 32) * 0xd6e8feb86659fd93u;
    at = (at ^ at >> 32) & mask;
    while (t->slot[at].number >= 0 && (t->slot[at].before != before || t->slot[at].value != value))
        at = (at + 1) & mask;
    return &t->slot[at];
}

/** Return the number of a pair, the next one if it is new; negative on failure. */
static int32_t number_of(table *t, int32_t before, int64_t value, planish_error *error) {
    enum { FIRST_SLOTS = 1 << 8 };
    if (2 * (t->n + 1) > t->n_slots) {
        const int64_t n_slots = t->n_slots ? 2 * t->n_slots : FIRST_SLOTS;
        const table old = *t, grown = {pl_alloc(n_slots, sizeof *t->slot), n_slots, t->n};
        if (!grown.slot)
            return pl_fail_memory(error, "the regions of elements");
        *t = grown;
        for (int64_t i = 0; i < n_slots; i++)
            t->slot[i].number = -1;
        for (int64_t i = 0; i < old.n_slots; i++)
            if (old.slot[i].number >= 0)
                *find_slot(t, old.slot[i].before, old.slot[i].value) = old.slot[i];
        pl_free(old.slot);
    }
    slot *s = find_slot(t, before, value);
    if (s->number < 0)
        *s = (slot){value, before, (int32_t)t->n++};
    return s->number;
}

/** Split the regions of elements by the values of one more array. */
static int split_regions(const planish_cell_array *array, int64_t n_elements, int32_t *region,
                         int64_t *n_regions, planish_error *error) {
    table t = {.n = 0};
    int32_t before = 0, number = -1;
    int64_t last = 0;
    for (int64_t i = 0; i < n_elements; i++) {
        int64_t value;
        if (take_value(array, i, &value)) {
            number =
                pl_fail_at(error, PLANISH_ERROR_ARGUMENT, i, -1,
                           "array '%s': the value of element %" PRId64 " is not a whole number",
                           array->name ? array->name : "", i);
            break;
        }
        if (number < 0 || before != region[i] || value != last) {
            before = region[i];
            last = value;
            number = number_of(&t, before, value, error);
            if (number < 0)
                break;
        }
        region[i] = number;
    }
    pl_free(t.slot);
    *n_regions = t.n;
    return number < 0 && n_elements > 0 ? number : PLANISH_OK;
}

int pl_combine_regions(int64_t n_elements, const planish_cell_array *arrays, int n_arrays,
                       int32_t *found, int64_t *n_regions, planish_error *error) {
    int status = PLANISH_OK;
    *n_regions = n_elements > 0;
    for (int i = 0; i < n_arrays && !status; i++)
        if (arrays[i].is_region)
            status = split_regions(&arrays[i], n_elements, found, n_regions, error);
    return status;
}

/* ---- interfaces --------------------------------------------------------------------------- */

enum { UNSEEN = 0, BETWEEN = 1, SEEN = 2 };

/** Nodes of elements that have been seen. */
typedef struct interfaces {
    int32_t *of_node;    /* [n_nodes] region of the first element */
    uint8_t *is_between; /* [n_nodes] UNSEEN, ... */
} interfaces;

/** Note n nodes (-1: none) of an element of a region. */
static void note_element(const interfaces *f, const int32_t *node, int64_t n, int32_t region) {
    for (int64_t k = 0; k < n; k++) {
        if (node[k] < 0)
            continue;
        uint8_t *is_between = &f->is_between[node[k]];
        if (*is_between == UNSEEN) {
            *is_between = SEEN;
            f->of_node[node[k]] = region;
        } else if (f->of_node[node[k]] != region) {
            *is_between = BETWEEN;
        }
    }
}

int pl_find_interfaces(const planish_mesh *mesh, const int32_t *region, uint8_t *is_between,
                       int64_t *n, planish_error *error) {
    const planish_cells *cells = mesh->cells;
    const interfaces f = {pl_alloc(mesh->n_nodes, sizeof *f.of_node), is_between};
    if (!f.of_node)
        return pl_fail_memory(error, "the regions of nodes");
    memset(is_between, UNSEEN, (size_t)mesh->n_nodes);
    for (int64_t i = 0; cells && i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        if (type && type->shape->dim == mesh->dim)
            note_element(&f, cells->node + cells->offset[i],
                         cells->offset[i + 1] - cells->offset[i], region[i]);
    }
    for (int64_t i = 0; !cells && i < mesh->n_elements; i++)
        note_element(&f, mesh->elements + i * (mesh->dim + 1), mesh->dim + 1, region[i]);
    *n = 0;
    for (int64_t i = 0; i < mesh->n_nodes; i++) {
        is_between[i] = is_between[i] == BETWEEN;
        *n += is_between[i];
    }
    pl_free(f.of_node);
    return PLANISH_OK;
}
