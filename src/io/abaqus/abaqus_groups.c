/* abaqus_groups: what sets become in the model: regions, entities, and groups with names.
 *
 * Regions are told by the ELSET= of *ELEMENT and by the section that has the element; entities by
 * all sets.
 */
#include "io/abaqus/abaqus_reader.h"
#include "io/core/memberships.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>

/* ---- regions ------------------------------------------------------------------------------ */

/** Fill key [cells], zeroed: the sets that tell a cell's region as one number. It is (1 + the set
 * of its *ELEMENT) times (n_sets + 1), plus 1 + the set of its section; 0 for no set. */
static void fill_region_keys(abaqus_reader *r, int64_t *key) {
    for (int64_t i = 0; i < r->n_ranges; i++) {
        const abaqus_range *range = &r->range[i];
        const int64_t set =
            range->set.begin ? abaqus_find_set(r, ABAQUS_ELEMENTS, r->scope, range->set) : -1;
        for (int64_t k = range->begin; k < range->end; k++)
            key[r->first_cell[range->list] + k] = (set + 1) * (r->n_sets + 1);
    }
    /* The last section that has a cell tells: from the last to the first, so that no set is walked
     * twice. A section in the assembly is one of an instance, so that its sets are the mesh's; or
     * those that the instance adds. */
    for (int64_t i = r->n_blocks - 1; i >= 0; i--) {
        const abaqus_block *b = &r->block[i];
        io_slice name;
        if (b->keyword != ABAQUS_SECTION || !abaqus_parameter(b, "ELSET", &name))
            continue;
        const int is_of_mesh = b->scope <= 0 || b->scope == r->scope;
        int32_t index = is_of_mesh ? abaqus_find_set(r, ABAQUS_ELEMENTS, r->scope, name) : -1;
        index = index < 0 ? abaqus_find_set(r, ABAQUS_ELEMENTS, b->scope, name) : index;
        abaqus_set *set = index < 0 ? NULL : &r->set[index];
        for (int64_t k = 0; set && !set->is_of_section && k < set->n; k++)
            if (key[set->member[k]] % (r->n_sets + 1) == 0)
                key[set->member[k]] += index + 1;
        if (set)
            set->is_of_section = 1;
    }
}

static int compare(const void *a, const void *b) {
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/** Replace key [n] by numbers from 0 in the order of the keys; different [n] is scratch. */
static void number_keys(int64_t *key, int64_t n, int64_t *different) {
    int64_t count = 0, unique = 0, last = 0, last_number = 0;
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || key[i] != key[i - 1])
            different[count++] = key[i];
    qsort(different, (size_t)count, sizeof *different, compare);
    for (int64_t i = 0; i < count; i++)
        if (i == 0 || different[i] != different[i - 1])
            different[unique++] = different[i];
    for (int64_t i = 0; i < n; i++) {
        if (i == 0 || key[i] != last) {
            last = key[i];
            const int64_t *found =
                bsearch(&last, different, (size_t)unique, sizeof *different, compare);
            last_number = found - different;
        }
        key[i] = last_number;
    }
}

/* ---- entities ----------------------------------------------------------------------------- */

/** Make entities and regions of cells. key [cells] is zeroed, different [cells] is scratch. */
static int make_cell_entities(abaqus_reader *r, io_memberships *m, int64_t *key,
                              int64_t *different) {
    fill_region_keys(r, key);
    number_keys(key, r->n[ABAQUS_ELEMENTS], different);
    for (int k = IO_FIRST_LIST; k < IO_N_LISTS; k++) {
        const io_list list = io_model_list(r->model, k);
        const int64_t first = r->first_cell[k];
        if (list.n == 0)
            continue;
        int32_t *region = pl_alloc(list.n, sizeof *region);
        if (!region)
            return pl_fail_memory(r->error, "the regions of the file");
        *io_model_regions(r->model, k) = region;
        for (int64_t i = 0; i < list.n; i++)
            region[i] = (int32_t)key[first + i];
        const int status = io_memberships_entities(m, r->model, list.dim, first, list.n, region,
                                                   list.entity, r->error);
        if (status)
            return status;
    }
    return PLANISH_OK;
}

/** Make entities of nodes or cells, by the sets that each is in, and regions of cells. */
static int make_entities(abaqus_reader *r, abaqus_things things) {
    const int64_t n = r->n[things];
    io_memberships m = {.n = 0};
    int status = io_memberships_begin(&m, n, r->error);
    for (int pass = 0; pass < 2 && !status; pass++) {
        for (int64_t i = 0; i < r->n_sets; i++)
            for (int64_t k = 0; r->set[i].things == things && k < r->set[i].n; k++)
                io_memberships_add(&m, r->set[i].member[k], (int32_t)i + 1);
        if (pass == 0)
            status = io_memberships_counted(&m, r->error);
    }
    if (!status && things == ABAQUS_NODES)
        status = io_memberships_of_nodes(&m, r->model, r->error);
    if (!status && things == ABAQUS_ELEMENTS) {
        int64_t *key = pl_alloc_zero(n, sizeof *key), *different = pl_alloc(n, sizeof *different);
        status = key && different ? make_cell_entities(r, &m, key, different)
                                  : pl_fail_memory(r->error, "the regions of the file");
        pl_free(key);
        pl_free(different);
    }
    io_memberships_destroy(&m);
    return status;
}

static int make_group(abaqus_reader *r, int dim, int32_t number, const abaqus_set *set) {
    io_model *model = r->model;
    const io_slice name = abaqus_unquoted(set->name);
    const int status =
        io_model_group(model, dim, number, name.begin, io_slice_length(name), r->error);
    if (!status)
        model->group[model->n_groups - 1].ignores_case = !abaqus_is_quoted(set->name);
    return status;
}

/** Make a group of each set and each dimension that its members have. */
static int make_groups(abaqus_reader *r) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < r->n_sets && !status; i++) {
        const abaqus_set *set = &r->set[i];
        unsigned dims = 0;
        for (int64_t k = 0; set->things == ABAQUS_ELEMENTS && k < set->n; k++) {
            int64_t local;
            dims |= 1u << abaqus_list_of(r, set->member[k], &local).dim;
        }
        dims = dims ? dims : 1; /* nodes; or elements that are not kept, which hold theirs */
        for (int dim = 0; dim <= 3 && !status; dim++)
            if (dims >> dim & 1)
                status = make_group(r, dim, (int32_t)i + 1, set);
    }
    return status;
}

int abaqus_make_groups(abaqus_reader *r) {
    int has_node_sets = 0;
    for (int64_t i = 0; i < r->n_sets; i++)
        has_node_sets |= r->set[i].things == ABAQUS_NODES;
    int status = make_entities(r, ABAQUS_ELEMENTS);
    if (!status && has_node_sets)
        status = make_entities(r, ABAQUS_NODES);
    return status ? status : make_groups(r);
}
