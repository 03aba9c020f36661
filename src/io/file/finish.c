/* finish: a model as a reader leaves it becomes a mesh to be smoothed.
 *
 * In: nodes and cells. Out: the dimension, the plane of flat elements, coordinates, and which nodes
 * lines, facets, points and elements that are not smoothed hold.
 *
 * Lists of all facets, or all edges, of a mesh put no constraint on its nodes: cells that are in
 * the file only because it lists all there are become plain ones (io_cells.n_plain), behind the
 * others. If lines or triangles are all facets of the elements, those inside that have the tag of
 * most inside are plain: what the list tells apart has other tags, and these hold. So nodes with
 * facets of several tags are held. Facets on the boundary stay what they are. If lines are all
 * edges of tetrahedra, the rule holds for lines inside, and for lines on the boundary.
 */
#include "io/core/cell_types.h"
#include "io/file/file.h"
#include "io/file/plane.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <string.h>

enum { CHUNK = 1 << 14, MOST_CORNERS = 3 };

/* ---- cells that are there only because the file lists all ----------------------------------- */

/* Place of a listed cell: no facet or edge of the elements; inside; or on the boundary. */
enum { NOWHERE, INSIDE, BOUNDARY, N_PLACES };

/** Hash table of the cells of a list by their nodes, and what the elements say of them. */
typedef struct listing {
    const io_cells *cells, *solids; /* the list; the elements */
    int corners, solid_corners;
    int32_t *slot; /* [mask + 1] a cell, or -1; of equal cells any one */
    int64_t mask;
    uint64_t *around; /* [n] bit 0: elements have it; the others are 0 if these close around it */
    uint8_t *where;   /* [n] where each cell is, then whether it is plain */
    int is_missing;   /* elements have one that is not listed */
} listing;

static uint64_t mix(uint64_t value) {
    value *= 0x9e3779b97f4a7c15u;
    value = (value ^ value >> 32) * 0xd6e8feb86659fd93u;
    return value ^ value >> 29;
}

/** Put nodes in the order of their numbers in sorted. */
static void sort_nodes(const int32_t *nodes, int corners, int32_t *sorted) {
    for (int i = 0; i < corners; i++) {
        int k = i;
        for (; k > 0 && sorted[k - 1] > nodes[i]; k--)
            sorted[k] = sorted[k - 1];
        sorted[k] = nodes[i];
    }
}

/** Find the cell of these nodes, in any order. -1: there is none, and then cell, if not -1, takes
 *  its slot. */
static int32_t find_or_add(const listing *l, const int32_t *nodes, int32_t cell) {
    int32_t sorted[MOST_CORNERS], other[MOST_CORNERS];
    uint64_t hash = 0;
    sort_nodes(nodes, l->corners, sorted);
    for (int i = 0; i < l->corners; i++)
        hash = mix(hash + (uint64_t)(uint32_t)sorted[i] + 1);
    for (int64_t at = (int64_t)(hash & (uint64_t)l->mask);; at = (at + 1) & l->mask) {
        int32_t there = __atomic_load_n(&l->slot[at], __ATOMIC_RELAXED);
        if (there < 0 &&
            (cell < 0 || __atomic_compare_exchange_n(&l->slot[at], &there, cell, 0,
                                                     __ATOMIC_RELAXED, __ATOMIC_RELAXED)))
            return -1;
        sort_nodes(l->cells->nodes + (int64_t)there * l->corners, l->corners, other);
        if (memcmp(other, sorted, (size_t)l->corners * sizeof *other) == 0)
            return there;
    }
}

static void add_cells(void *context, int64_t begin, int64_t end, int thread) {
    const listing *l = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        find_or_add(l, l->cells->nodes + i * l->corners, (int32_t)i);
}

/** Note at the cells that are facets or edges of an element (all choices of corners of its nodes)
 *  that it has them. The nodes behind each, of all elements together, come twice if elements close
 *  around it. Returns 0 if one is not listed. */
static int note_element(listing *l, const int32_t *element) {
    for (unsigned set = 1; set < 1u << l->solid_corners; set++) {
        int32_t nodes[4], others[4];
        int n = 0, n_others = 0;
        for (int i = 0; i < l->solid_corners; i++)
            if (set >> i & 1)
                nodes[n++] = element[i];
            else
                others[n_others++] = element[i];
        if (n != l->corners)
            continue;
        const int32_t cell = find_or_add(l, nodes, -1);
        if (cell < 0)
            return 0;
        uint64_t behind = n_others == 1 ? 2 : 0; /* a facet: two elements */
        for (int i = 0; i < n_others && n_others > 1; i++)
            behind ^= mix((uint64_t)(uint32_t)others[i] + 1) & ~(uint64_t)1;
        __atomic_fetch_xor(&l->around[cell], behind, __ATOMIC_RELAXED);
        __atomic_fetch_or(&l->around[cell], 1, __ATOMIC_RELAXED);
    }
    return 1;
}

static void note_elements(void *context, int64_t begin, int64_t end, int thread) {
    listing *l = context;
    (void)thread;
    for (int64_t i = begin; i < end && !__atomic_load_n(&l->is_missing, __ATOMIC_RELAXED); i++)
        if (!note_element(l, l->solids->nodes + i * l->solid_corners))
            __atomic_store_n(&l->is_missing, 1, __ATOMIC_RELAXED);
}

static void place_cells(void *context, int64_t begin, int64_t end, int thread) {
    const listing *l = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const uint64_t around = l->around[find_or_add(l, l->cells->nodes + i * l->corners, -1)];
        l->where[i] = around == 0 ? NOWHERE : around == 1 ? INSIDE : BOUNDARY;
    }
}

static int32_t tag_of(const io_cells *cells, int64_t i) {
    return cells->entity && cells->entity[i] >= 0 ? cells->entity[i] + 1 : 0;
}

/** Make of the places of cells whether they are plain: of n_tags tags the one of most cells is, at
 *  each place where cells can be plain; of several as many the first. */
static int mark_plain(listing *l, int64_t n_tags, planish_error *error) {
    const int has_boundary = l->solid_corners - l->corners > 1; /* edges of tetrahedra */
    int32_t usual[N_PLACES] = {0};
    int64_t *count = pl_alloc_zero(N_PLACES * n_tags, sizeof *count);
    if (!count)
        return pl_fail_memory(error, "the groups of facets");
    for (int64_t i = 0; i < l->cells->n; i++)
        count[l->where[i] * n_tags + tag_of(l->cells, i)]++;
    for (int p = 0; p < N_PLACES; p++)
        for (int32_t k = 1; k < n_tags; k++)
            if (count[p * n_tags + k] > count[p * n_tags + usual[p]])
                usual[p] = k;
    pl_free(count);
    for (int64_t i = 0; i < l->cells->n; i++) {
        const int at = l->where[i];
        l->where[i] =
            (at == INSIDE || (at == BOUNDARY && has_boundary)) && tag_of(l->cells, i) == usual[at];
    }
    return PLANISH_OK;
}

/** Put the plain cells of dimension dim behind the others, each in their order; they keep their
 *  numbers. */
static int move_behind(io_model *model, int dim, const uint8_t *is_plain, planish_error *error) {
    io_cells *cells = io_model_cells(model, dim), old = *cells;
    const size_t size = (size_t)(dim + 1) * sizeof *old.nodes;
    *cells = (io_cells){.first_number = old.first_number};
    const size_t mids = (size_t)io_n_mids(dim);
    int status = io_cells_reserve(model, dim, old.n, old.entity != NULL, 1, error);
    if (!status && old.mid)
        status = io_cells_reserve_mids(model, dim, error);
    if (!status && old.region && !(cells->region = pl_alloc(old.n, sizeof *old.region)))
        status = pl_fail_memory(error, "the elements of the file");
    for (int64_t i = 0; i < old.n; i++)
        cells->n_plain += is_plain[i];
    int64_t to[2] = {0, old.n - cells->n_plain};
    for (int64_t i = 0; i < old.n && !status; i++) {
        const int64_t k = to[is_plain[i]]++;
        memcpy(cells->nodes + k * (dim + 1), old.nodes + i * (dim + 1), size);
        if (old.mid)
            memcpy(cells->mid + (size_t)k * mids, old.mid + (size_t)i * mids,
                   mids * sizeof *old.mid);
        cells->number[k] = io_cell_number(&old, i);
        if (old.entity)
            cells->entity[k] = old.entity[i];
        if (old.region)
            cells->region[k] = old.region[i];
    }
    cells->n = old.n;
    io_cells_release(&old);
    return status;
}

/** Find plain cells of dimension dim: there are any if cells are all that elements of solid_dim
 *  have. */
static int find_plain(io_model *model, int dim, int solid_dim, planish_error *error) {
    io_cells *cells = io_model_cells(model, dim);
    const io_cells *solids = io_model_cells(model, solid_dim);
    /* Of facets there are half as many as elements have, and more for the boundary; of edges at
     * least as many as tetrahedra. */
    const int64_t least = solid_dim - dim == 1 ? (solid_dim + 1) * solids->n / 2 : solids->n;
    if (cells->n == 0 || solids->n == 0 || cells->n < least)
        return PLANISH_OK;
    int64_t n_slots = 1;
    while (n_slots < 2 * cells->n)
        n_slots *= 2;
    listing l = {.cells = cells,
                 .solids = solids,
                 .corners = dim + 1,
                 .solid_corners = solid_dim + 1,
                 .slot = pl_alloc(n_slots, sizeof *l.slot),
                 .mask = n_slots - 1,
                 .around = pl_alloc_zero(cells->n, sizeof *l.around),
                 .where = pl_alloc(cells->n, 1)};
    int status = PLANISH_OK;
    if (!l.slot || !l.around || !l.where) {
        status = pl_fail_memory(error, "the facets of the file");
    } else {
        memset(l.slot, -1, (size_t)n_slots * sizeof *l.slot);
        pl_parallel_for(model->threads, cells->n, CHUNK, add_cells, &l);
        pl_parallel_for(model->threads, solids->n, CHUNK, note_elements, &l);
        if (!l.is_missing) {
            pl_parallel_for(model->threads, cells->n, CHUNK, place_cells, &l);
            status = mark_plain(&l, (int64_t)model->n_entities + 1, error);
            if (!status)
                status = move_behind(model, dim, l.where, error);
        }
    }
    pl_free(l.slot);
    pl_free(l.around);
    pl_free(l.where);
    return status;
}

/* ---- the mesh ------------------------------------------------------------------------------- */

/** Let the cells of dimension dim hold their nodes, mids among them, for reason. */
static void hold_nodes(io_model *model, int dim, uint8_t reason) {
    const io_cells *cells = io_model_cells(model, dim);
    for (int64_t i = 0; i < (dim + 1) * io_cells_telling(cells); i++)
        model->hold[cells->nodes[i]] |= reason;
    for (int64_t i = 0; cells->mid && i < io_n_mids(dim) * io_cells_telling(cells); i++)
        if (cells->mid[i] >= 0)
            model->hold[cells->mid[i]] |= reason;
}

/** Let others hold their nodes, but (but_smoothed) those whose nodes may move. */
static void hold_others(io_model *model, const io_others *others, int but_smoothed,
                        uint8_t reason) {
    for (int64_t i = 0; i < others->n; i++) {
        if (but_smoothed && io_cell_type_is_smoothed(others->type[i]))
            continue;
        for (int64_t k = others->offset[i]; k < others->offset[i + 1]; k++)
            if (others->node[k] >= 0)
                model->hold[others->node[k]] |= reason;
    }
}

/** Find the plane of a mesh in two dimensions and the coordinates there. The file's own places are
 *  kept where its columns are not those of the coordinates. */
static int finish_plane(io_model *model, const io_format *format, planish_error *error) {
    int status = io_plane_find(model, format, error);
    if (status)
        return status;
    model->dim = 2;
    model->written = io_plane_is_xy(&model->plane) ? 2 : 3;
    model->coordinates = pl_alloc(model->n_nodes, 2 * sizeof *model->coordinates);
    if (!model->coordinates)
        return pl_fail_memory(error, "coordinates");
    for (int64_t i = 0; i < model->n_nodes; i++)
        io_plane_project(&model->plane, model->xyz + 3 * i, model->coordinates + 2 * i);
    if (model->plane.is_tilted)
        return io_plane_keep(model, error);
    if (model->written == 3)
        return PLANISH_OK;
    int has_z = 0; /* z is not smoothed, but shown (io/view) */
    for (int64_t i = 0; i < model->n_nodes; i++)
        has_z |= model->xyz[3 * i + 2] != 0;
    if (has_z) {
        model->z = pl_alloc(model->n_nodes, sizeof *model->z);
        if (!model->z)
            return pl_fail_memory(error, "coordinates");
        for (int64_t i = 0; i < model->n_nodes; i++)
            model->z[i] = model->xyz[3 * i + 2];
    }
    pl_free(model->xyz);
    model->xyz = NULL;
    return PLANISH_OK;
}

int io_model_finish(io_model *model, const io_format *format, planish_error *error) {
    const int dim = model->dim = io_model_dim(model);
    model->n_other -= model->flat.n + model->solid.n; /* which readers have counted, too */
    int status = PLANISH_OK;
    for (int d = 1; d < dim && !status; d++)
        status = find_plain(model, d, dim, error);
    if (status)
        return status;
    /* Points that name every node say nothing of any: Mmg writes all vertices so, and others vertex
     * cells. */
    int64_t n_named = 0;
    for (int64_t i = 0; i < model->n_nodes; i++)
        n_named += (model->hold[i] & IO_HELD_BY_POINT) != 0;
    for (int64_t i = 0; i < model->n_nodes && n_named == model->n_nodes; i++)
        model->hold[i] &= (uint8_t)~IO_HELD_BY_POINT;
    model->n_lower += model->line.n;
    hold_nodes(model, 1, IO_HELD_BY_LINE);
    if (dim == 2 && io_model_n_elements(model) > 0)
        return finish_plane(model, format, error);
    if (dim == 2)
        return pl_fail(
            error, PLANISH_ERROR_FORMAT,
            "%s: no element of two or three dimensions in it: there is nothing to smooth",
            model->input.path);
    if (model->columns < 3)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: solid elements in two dimensions; a third coordinate is missing",
                       model->input.path);
    model->dim = model->written = 3;
    model->coordinates = model->xyz;
    model->n_lower += model->triangle.n + model->flat.n;
    hold_nodes(model, 2, IO_HELD_BY_FACE);
    hold_others(model, &model->flat, 0, IO_HELD_BY_FACE);
    hold_others(model, &model->solid, 1, IO_HELD_BY_OTHER);
    return PLANISH_OK;
}
