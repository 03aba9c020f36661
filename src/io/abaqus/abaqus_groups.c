/* abaqus_groups: what sets become in the model: regions, entities, and groups with names.
 *
 * Regions are told by the ELSET= of *ELEMENT and by the section that has the element; entities by
 * all sets.
 */
#include "io/abaqus/abaqus_sets.h"
#include "io/core/memberships.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

/* ---- regions ------------------------------------------------------------------------------ */

/** The sets that tell regions apart, as one number: of *ELEMENT, of the section. */
static int64_t region_key(const sets *s, int32_t block_set, int32_t section_set) {
    return (int64_t)(block_set + 1) * (s->n_sets + 1) + section_set + 1;
}

static void choose_by_blocks(const sets *s, int32_t *block_set) {
    for (int64_t i = 0; i < s->reader->n_ranges; i++) {
        const abaqus_range *range = &s->reader->range[i];
        const int32_t set =
            range->set.begin ? abaqus_find_set(s, ELEMENTS, s->reader->scope, range->set) : -1;
        for (int64_t k = range->begin; k < range->end; k++)
            block_set[s->first_cell[range->dim] + k] = set;
    }
}

/** The set that a section is of. A section in the assembly is one of an instance, so that its sets
 *  are the mesh's; or those that the instance adds. */
static int32_t set_of_section(const sets *s, const abaqus_block *b) {
    abaqus_span name;
    if (b->keyword != ABAQUS_SECTION || !abaqus_parameter(b, "ELSET", &name))
        return -1;
    const int is_of_mesh = b->scope <= 0 || b->scope == s->reader->scope;
    const int32_t set = is_of_mesh ? abaqus_find_set(s, ELEMENTS, s->reader->scope, name) : -1;
    return set < 0 ? abaqus_find_set(s, ELEMENTS, b->scope, name) : set;
}

/** The last section that has a cell tells: from the last to the first, so that no set is walked
 *  twice. section_set: -1 as yet. */
static void choose_by_sections(sets *s, int32_t *section_set) {
    for (int64_t i = s->reader->n_blocks - 1; i >= 0; i--) {
        const int32_t index = set_of_section(s, &s->reader->block[i]);
        named_set *set = index < 0 ? NULL : &s->set[index];
        if (!set || set->is_of_section)
            continue;
        for (int64_t k = 0; k < set->n; k++)
            if (section_set[set->member[k]] < 0)
                section_set[set->member[k]] = index;
        set->is_of_section = 1;
    }
}

static int compare(const void *a, const void *b) {
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/** Replace key [n] by numbers from 0; different [n] is scratch. */
static void number_keys(int64_t *key, int64_t n, int64_t *different, int32_t *region) {
    int64_t count = 0, unique = 0;
    for (int64_t i = 0; i < n; i++)
        if (i == 0 || key[i] != key[i - 1])
            different[count++] = key[i];
    qsort(different, (size_t)count, sizeof *different, compare);
    for (int64_t i = 0; i < count; i++)
        if (i == 0 || different[i] != different[i - 1])
            different[unique++] = different[i];
    for (int64_t i = 0; i < n; i++) {
        if (i > 0 && key[i] == key[i - 1]) {
            region[i] = region[i - 1];
            continue;
        }
        const int64_t *found =
            bsearch(&key[i], different, (size_t)unique, sizeof *different, compare);
        region[i] = (int32_t)(found - different);
    }
}

/** region [cells]: which region each is of. */
static int find_regions(sets *s, int32_t *region) {
    const int64_t n = s->n[ELEMENTS];
    int32_t *block_set = pl_alloc(n, sizeof *block_set);
    int32_t *section_set = pl_alloc(n, sizeof *section_set);
    int64_t *key = pl_alloc(n, sizeof *key), *different = pl_alloc(n, sizeof *different);
    int status = block_set && section_set && key && different
                     ? PLANISH_OK
                     : pl_fail_memory(s->reader->error, "the regions of the file");
    if (!status) {
        memset(section_set, -1, (size_t)n * sizeof *section_set);
        choose_by_blocks(s, block_set);
        choose_by_sections(s, section_set);
        for (int64_t i = 0; i < n; i++)
            key[i] = region_key(s, block_set[i], section_set[i]);
        number_keys(key, n, different, region);
    }
    pl_free(block_set);
    pl_free(section_set);
    pl_free(key);
    pl_free(different);
    return status;
}

/* ---- entities ----------------------------------------------------------------------------- */

/** Everything that the sets of a kind have, once. */
static void add_members(const sets *s, set_kind things, io_memberships *m) {
    for (int64_t i = 0; i < s->n_sets; i++)
        for (int64_t k = 0; s->set[i].things == things && k < s->set[i].n; k++)
            io_memberships_add(m, s->set[i].member[k], (int32_t)i + 1);
}

static int collect(const sets *s, set_kind things, io_memberships *m) {
    int status = io_memberships_begin(m, s->n[things], s->reader->error);
    if (status)
        return status;
    add_members(s, things, m);
    status = io_memberships_counted(m, s->reader->error);
    if (!status)
        add_members(s, things, m);
    return status;
}

static int make_cell_entities(sets *s, io_memberships *m, const int32_t *region) {
    io_model *model = s->reader->model;
    int32_t last = -1;
    for (int dim = 1; dim <= 3; dim++) {
        io_cells *cells = io_model_cells(model, dim);
        if (cells->n == 0)
            continue;
        cells->region = pl_alloc(cells->n, sizeof *cells->region);
        if (!cells->region)
            return pl_fail_memory(s->reader->error, "the regions of the file");
        for (int64_t i = 0; i < cells->n; i++) {
            const int64_t cell = s->first_cell[dim] + i;
            last = io_memberships_entity(m, model, cell, dim, region[cell] + 1, last,
                                         s->reader->error);
            if (last < 0)
                return last;
            cells->entity[i] = last;
            cells->region[i] = region[cell];
        }
    }
    return PLANISH_OK;
}

int abaqus_make_groups(sets *s) {
    int status = PLANISH_OK;
    for (int64_t i = 0; i < s->n_sets && !status; i++) {
        const named_set *set = &s->set[i];
        const abaqus_span name = abaqus_unquoted(set->name);
        unsigned dims = 0;
        for (int64_t k = 0; set->things == ELEMENTS && k < set->n; k++) {
            int64_t local;
            dims |= 1u << abaqus_dim_of(s, set->member[k], &local);
        }
        dims = dims ? dims : 1; /* nodes; or elements that are not kept, which hold theirs */
        for (int dim = 0; dim <= 3 && !status; dim++)
            if (dims >> dim & 1)
                status = io_model_group(s->reader->model, dim, (int32_t)i + 1, name.begin,
                                        name.end - name.begin, s->reader->error);
    }
    return status;
}

int abaqus_make_entities(sets *s, set_kind things) {
    io_memberships m = {.n = 0};
    int32_t *region = things == ELEMENTS ? pl_alloc(s->n[ELEMENTS], sizeof *region) : NULL;
    int status = collect(s, things, &m);
    if (!status && things == ELEMENTS)
        status = region ? find_regions(s, region)
                        : pl_fail_memory(s->reader->error, "the regions of the file");
    if (!status)
        status = things == ELEMENTS
                     ? make_cell_entities(s, &m, region)
                     : io_memberships_of_nodes(&m, s->reader->model, s->reader->error);
    pl_free(region);
    io_memberships_destroy(&m);
    return status;
}
