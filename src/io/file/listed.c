/* listed: lists of all facets, or all edges, of a mesh put no constraint on its nodes.
 *
 * In: the cells of a model. Out: io_cells.n_plain of its lines and triangles: how many of them, put
 * behind the others, are in the file only because it lists all there are.
 *
 * If lines or triangles are all facets of the elements, those inside that have the tag of most
 * inside are plain: what the list tells apart has other tags, which hold as ever. So where nodes
 * have facets of several tags, they are held. Facets on the boundary stay what they are. If lines
 * are all edges of tetrahedra, the same is said of those inside, and of those on the boundary.
 */
#include "io/core/model.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <stdatomic.h>
#include <string.h>

enum { CHUNK = 1 << 14, MOST_CORNERS = 3 };

/* What a listed cell is to the elements: none of their facets or edges; inside; or on the boundary.
 */
typedef enum place { NOWHERE, INSIDE, BOUNDARY, N_PLACES } place;

/** The cells of a list by their nodes, and what the elements say of them. */
typedef struct table {
    const io_cells *cells;
    int corners;
    int32_t *slot; /* [mask + 1] a cell, or -1; of equal cells any one */
    int64_t mask;
    uint64_t *around; /* [n] bit 0: elements have it; the others are 0 if these close around it */
    const io_cells *solids; /* the elements */
    int solid_corners;
    uint8_t *place;        /* [n] where each cell is, then whether it is plain */
    atomic_int is_missing; /* elements have one that is not listed */
} table;

/* ---- the table ------------------------------------------------------------------------------ */

static uint64_t mix(uint64_t value) {
    value *= 0x9e3779b97f4a7c15u;
    value = (value ^ value >> 32) * 0xd6e8feb86659fd93u;
    return value ^ value >> 29;
}

/** Nodes in the order of their numbers. */
static void sort_nodes(const int32_t *nodes, int corners, int32_t *sorted) {
    for (int i = 0; i < corners; i++) {
        int k = i;
        for (; k > 0 && sorted[k - 1] > nodes[i]; k--)
            sorted[k] = sorted[k - 1];
        sorted[k] = nodes[i];
    }
}

static int64_t first_slot(const table *t, const int32_t *sorted) {
    uint64_t hash = 0;
    for (int i = 0; i < t->corners; i++)
        hash = mix(hash + (uint64_t)(uint32_t)sorted[i] + 1);
    return (int64_t)(hash & (uint64_t)t->mask);
}

static int is_cell(const table *t, int32_t cell, const int32_t *sorted) {
    int32_t nodes[MOST_CORNERS];
    sort_nodes(t->cells->nodes + (int64_t)cell * t->corners, t->corners, nodes);
    return memcmp(nodes, sorted, (size_t)t->corners * sizeof *nodes) == 0;
}

/** The cell of these nodes; -1: there is none, and then cell, if not -1, takes its slot. */
static int32_t find_or_add(const table *t, const int32_t *sorted, int32_t cell) {
    for (int64_t at = first_slot(t, sorted);; at = (at + 1) & t->mask) {
        int32_t there = __atomic_load_n(&t->slot[at], __ATOMIC_RELAXED);
        if (there < 0 &&
            (cell < 0 || __atomic_compare_exchange_n(&t->slot[at], &there, cell, 0,
                                                     __ATOMIC_RELAXED, __ATOMIC_RELAXED)))
            return -1;
        if (is_cell(t, there, sorted))
            return there;
    }
}

static void add_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const table *t = context;
    int32_t sorted[MOST_CORNERS];
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        sort_nodes(t->cells->nodes + i * t->corners, t->corners, sorted);
        find_or_add(t, sorted, (int32_t)i);
    }
}

static int make_table(table *t, int threads, planish_error *error) {
    int64_t n_slots = 1;
    while (n_slots < 2 * t->cells->n)
        n_slots *= 2;
    t->mask = n_slots - 1;
    t->slot = pl_alloc(n_slots, sizeof *t->slot);
    t->around = pl_alloc_zero(t->cells->n, sizeof *t->around);
    if (!t->slot || !t->around)
        return pl_fail_memory(error, "the facets of the file");
    memset(t->slot, -1, (size_t)n_slots * sizeof *t->slot);
    pl_parallel_for(threads, t->cells->n, CHUNK, add_chunk, t);
    return PLANISH_OK;
}

static void release_table(table *t) {
    pl_free(t->slot);
    pl_free(t->around);
    pl_free(t->place);
}

/* ---- what elements say of the list ---------------------------------------------------------- */

/** An element has the facet or edge of these nodes, and behind it those of others [n_others]: each
 *  of these comes twice if elements close around it. */
static int note(table *t, const int32_t *nodes, const int32_t *others, int n_others) {
    int32_t sorted[MOST_CORNERS];
    sort_nodes(nodes, t->corners, sorted);
    const int32_t cell = find_or_add(t, sorted, -1);
    if (cell < 0)
        return -1;
    uint64_t behind = n_others == 1 ? 2 : 0; /* a facet: two elements */
    for (int i = 0; i < n_others && n_others > 1; i++)
        behind ^= mix((uint64_t)(uint32_t)others[i] + 1) & ~(uint64_t)1;
    __atomic_fetch_xor(&t->around[cell], behind, __ATOMIC_RELAXED);
    __atomic_fetch_or(&t->around[cell], 1, __ATOMIC_RELAXED);
    return 0;
}

/** The facets or edges of an element: all choices of corners of its nodes. */
static int note_element(table *t, const int32_t *element) {
    for (unsigned set = 1; set < 1u << t->solid_corners; set++) {
        int32_t nodes[4], others[4];
        int n = 0, n_others = 0;
        for (int i = 0; i < t->solid_corners; i++)
            if (set >> i & 1)
                nodes[n++] = element[i];
            else
                others[n_others++] = element[i];
        if (n == t->corners && note(t, nodes, others, n_others))
            return -1;
    }
    return 0;
}

static void note_chunk(void *context, int64_t begin, int64_t end, int thread) {
    table *t = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (atomic_load_explicit(&t->is_missing, memory_order_relaxed) ||
            note_element(t, t->solids->nodes + i * t->solid_corners)) {
            atomic_store_explicit(&t->is_missing, 1, memory_order_relaxed);
            return;
        }
}

/** Whether the list has all that elements have. */
static int has_all(table *t, int threads) {
    pl_parallel_for(threads, t->solids->n, CHUNK, note_chunk, t);
    return !atomic_load(&t->is_missing);
}

static void place_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const table *t = context;
    int32_t sorted[MOST_CORNERS];
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        sort_nodes(t->cells->nodes + i * t->corners, t->corners, sorted);
        const uint64_t around = t->around[find_or_add(t, sorted, -1)];
        t->place[i] = around == 0 ? NOWHERE : around == 1 ? INSIDE : BOUNDARY;
    }
}

/* ---- which of them are plain ---------------------------------------------------------------- */

static int32_t tag_of(const io_cells *cells, int64_t i) {
    return cells->entity && cells->entity[i] >= 0 ? cells->entity[i] + 1 : 0;
}

/** The tag of most cells at each place: the first of those that are as many. */
static int find_tags(const table *t, int64_t n_tags, int32_t tag[N_PLACES], planish_error *error) {
    int64_t *count = pl_alloc_zero(N_PLACES * n_tags, sizeof *count);
    if (!count)
        return pl_fail_memory(error, "the groups of facets");
    for (int64_t i = 0; i < t->cells->n; i++)
        count[t->place[i] * n_tags + tag_of(t->cells, i)]++;
    for (int p = 0; p < N_PLACES; p++) {
        tag[p] = 0;
        for (int32_t k = 1; k < n_tags; k++)
            if (count[p * n_tags + k] > count[p * n_tags + tag[p]])
                tag[p] = k;
    }
    pl_free(count);
    return PLANISH_OK;
}

/** Put the plain cells behind the others, each in their order; they keep their numbers. */
static int move_behind(io_cells *cells, int corners, const uint8_t *is_plain,
                       planish_error *error) {
    int64_t n_plain = 0, to[2] = {0, 0};
    for (int64_t i = 0; i < cells->n; i++)
        n_plain += is_plain[i];
    to[1] = cells->n - n_plain;
    int32_t *nodes = pl_alloc(cells->n, (size_t)corners * sizeof *nodes);
    int32_t *entity = pl_alloc(cells->entity ? cells->n : 0, sizeof *entity);
    int32_t *region = pl_alloc(cells->region ? cells->n : 0, sizeof *region);
    int64_t *number = pl_alloc(cells->n, sizeof *number);
    if (!nodes || !entity || !region || !number) {
        pl_free(nodes);
        pl_free(entity);
        pl_free(region);
        pl_free(number);
        return pl_fail_memory(error, "the facets of the file");
    }
    for (int64_t i = 0; i < cells->n; i++) {
        const int64_t k = to[is_plain[i]]++;
        memcpy(nodes + k * corners, cells->nodes + i * corners, (size_t)corners * sizeof *nodes);
        number[k] = cells->number ? cells->number[i] : cells->first_number + i;
        if (cells->entity)
            entity[k] = cells->entity[i];
        if (cells->region)
            region[k] = cells->region[i];
    }
    const int has_entity = cells->entity != NULL, has_region = cells->region != NULL;
    io_cells_release(cells);
    cells->nodes = nodes;
    cells->number = number;
    cells->n_plain = n_plain;
    cells->capacity = cells->n;
    if (has_entity)
        cells->entity = entity;
    else
        pl_free(entity);
    if (has_region)
        cells->region = region;
    else
        pl_free(region);
    return PLANISH_OK;
}

static int take_plain(table *t, io_cells *cells, int64_t n_tags, int threads,
                      planish_error *error) {
    const int has_boundary = t->solid_corners - t->corners > 1; /* edges of tetrahedra */
    int32_t tag[N_PLACES];
    t->place = pl_alloc(cells->n, 1);
    if (!t->place)
        return pl_fail_memory(error, "the facets of the file");
    pl_parallel_for(threads, cells->n, CHUNK, place_chunk, t);
    int status = find_tags(t, n_tags, tag, error);
    if (status)
        return status;
    for (int64_t i = 0; i < cells->n; i++) {
        const int at = t->place[i];
        t->place[i] =
            (at == INSIDE || (at == BOUNDARY && has_boundary)) && tag_of(cells, i) == tag[at];
    }
    return move_behind(cells, t->corners, t->place, error);
}

/** The cells of dimension dim, if they are all that elements of solid_dim have. */
static int find_plain(io_model *model, int dim, int solid_dim, planish_error *error) {
    io_cells *cells = io_model_cells(model, dim);
    const io_cells *solids = io_model_cells(model, solid_dim);
    /* Of facets there are half as many as elements have, and more for the boundary; of edges at
     * least as many as tetrahedra. */
    const int64_t least = solid_dim - dim == 1 ? (solid_dim + 1) * solids->n / 2 : solids->n;
    if (cells->n == 0 || solids->n == 0 || cells->n < least)
        return PLANISH_OK;
    table t = {
        .cells = cells, .corners = dim + 1, .solids = solids, .solid_corners = solid_dim + 1};
    int status = make_table(&t, model->threads, error);
    if (!status && has_all(&t, model->threads))
        status = take_plain(&t, cells, (int64_t)model->n_entities + 1, model->threads, error);
    release_table(&t);
    return status;
}

int io_model_find_plain(io_model *model, planish_error *error) {
    const int dim = model->tetrahedron.n > 0 ? 3 : 2;
    int status = find_plain(model, 1, dim, error);
    if (!status && dim == 3)
        status = find_plain(model, 2, dim, error);
    return status;
}
