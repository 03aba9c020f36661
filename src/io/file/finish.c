/* finish: a model as a reader leaves it becomes a mesh to be smoothed.
 *
 * In: nodes and cells. Out: the dimension, the plane of flat elements, coordinates, and which nodes
 * lines, facets, points and elements that are not smoothed hold.
 *
 * Lists of all facets, or all edges, of a mesh put no constraint on its nodes: cells that are in
 * the file only because it lists all there are become plain ones (io_cells.n_plain), behind the
 * others. If lines, triangles or quadrilaterals are all such facets of the elements, those inside
 * that have the tag of most inside are plain: what the list tells apart has other tags, and these
 * hold. So nodes with facets of several tags are held. Facets on the boundary stay what they are. If
 * lines are all edges of solid elements, the rule holds for lines inside, and for lines on the
 * boundary.
 */
#include "io/core/cell_types.h"
#include "io/core/mids.h"
#include "io/core/part_numbers.h"
#include "io/core/parts.h"
#include "io/file/file.h"
#include "io/file/plane.h"

#include "base/hash.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

#include <inttypes.h>
#include <string.h>

enum { CHUNK = 1 << 14, MOST_CORNERS = 4 };

/* ---- cells that are there only because the file lists all ----------------------------------- */

/* Place of a listed cell: no facet or edge of the elements; inside; or on the boundary. */
enum { NOWHERE, INSIDE, BOUNDARY, N_PLACES };

/** Hash table of the cells of a list by their corners, and what the elements say of them. */
typedef struct listing {
    io_list list;      /* lines, triangles, or other flat elements */
    io_list solids[2]; /* the elements: simplices, others */
    int corners;       /* of a cell of the list */
    int are_facets;    /* of the elements; else they are edges of solid ones */
    int32_t *slot;     /* [mask + 1] a cell, or -1; of equal cells any one */
    int64_t mask;
    pl_hash hash;
    uint64_t *around; /* [n] bit 0: elements have it; the others are 0 if these close around it */
    uint8_t *where;   /* [n] where each cell is, then whether it is plain */
    int is_missing;   /* elements have one that is not listed */
} listing;

static uint64_t mix(uint64_t value) {
    value *= 0x9e3779b97f4a7c15u;
    value = (value ^ value >> 32) * 0xd6e8feb86659fd93u;
    return value ^ value >> 29;
}

/** The corners of a cell of the list. */
static const int32_t *corners_of(const listing *l, int64_t i) {
    const io_others *others = l->list.others;
    return others ? others->node + others->offset[i] : l->list.cells->nodes + i * l->corners;
}

/** Find the cell of these nodes, in any order. -1: there is none, and then cell, if not -1, takes
 *  its slot. */
static int32_t find_or_add(const listing *l, const int32_t *nodes, int32_t cell) {
    int32_t sorted[MOST_CORNERS], other[MOST_CORNERS];
    pl_hash hash = l->hash;
    io_sort_vertices(nodes, l->corners, sorted);
    pl_hash_add_integers(&hash, sorted, l->corners);
    for (int64_t at = (int64_t)(pl_hash_end(hash) & (uint64_t)l->mask);; at = (at + 1) & l->mask) {
        int32_t there = __atomic_load_n(&l->slot[at], __ATOMIC_RELAXED);
        if (there < 0 &&
            (cell < 0 || __atomic_compare_exchange_n(&l->slot[at], &there, cell, 0,
                                                     __ATOMIC_RELAXED, __ATOMIC_RELAXED)))
            return -1;
        io_sort_vertices(corners_of(l, there), l->corners, other);
        if (memcmp(other, sorted, (size_t)l->corners * sizeof *other) == 0)
            return there;
    }
}

static void add_cells(void *context, int64_t begin, int64_t end, int thread) {
    const listing *l = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        find_or_add(l, corners_of(l, i), (int32_t)i);
}

/** Say what lies behind an edge of an element: the other corners of its faces there. */
static uint64_t behind_edge(const io_parts *parts, const int8_t edge[2], const int32_t *element) {
    uint64_t behind = 0;
    for (int f = 0; f < parts->n_faces; f++) {
        uint64_t others = 0;
        const int n = io_part_corners(parts, f);
        int n_others = 0;
        for (int i = 0; i < n; i++) {
            const int corner = parts->face[f][i];
            if (corner == edge[0] || corner == edge[1])
                continue;
            others ^= mix((uint64_t)(uint32_t)element[corner] + 1) & ~(uint64_t)1;
            n_others++;
        }
        behind ^= n_others == n - 2 ? others : 0;
    }
    return behind;
}

/** Note at a cell of the list, by its nodes, that an element has it. What is behind it, of all elements
 *  together, comes twice if elements close around it. Returns 0 if it is not listed. */
static int note_part(const listing *l, const int32_t *nodes, uint64_t behind) {
    const int32_t cell = find_or_add(l, nodes, -1);
    if (cell < 0)
        return 0;
    __atomic_fetch_xor(&l->around[cell], behind, __ATOMIC_RELAXED);
    __atomic_fetch_or(&l->around[cell], 1, __ATOMIC_RELAXED);
    return 1;
}

/** Note the facets or edges of an element that are of the list's kind. Returns 0 if one is not listed.
 */
static int note_element(const listing *l, const io_parts *parts, const int32_t *element) {
    const uint64_t of_facet = 2; /* of two elements */
    int32_t nodes[MOST_CORNERS];
    for (int e = 0; l->corners == 2 && e < parts->n_edges; e++) {
        const int8_t *edge = parts->edge[e];
        nodes[0] = element[edge[0]];
        nodes[1] = element[edge[1]];
        if (!note_part(l, nodes, l->are_facets ? of_facet : behind_edge(parts, edge, element)))
            return 0;
    }
    for (int f = 0; l->corners > 2 && f < parts->n_faces; f++) {
        for (int i = 0; i < l->corners; i++)
            nodes[i] = parts->face[f][i] < 0 ? -1 : element[parts->face[f][i]];
        if (io_part_corners(parts, f) == l->corners && !note_part(l, nodes, of_facet))
            return 0;
    }
    return 1;
}

static void note_elements(void *context, int64_t begin, int64_t end, int thread) {
    listing *l = context;
    (void)thread;
    for (int64_t i = begin; i < end && !__atomic_load_n(&l->is_missing, __ATOMIC_RELAXED); i++) {
        const io_list *of = &l->solids[i >= l->solids[0].n];
        int32_t node[IO_CELL_NODES];
        int corners;
        io_list_nodes(of, i >= l->solids[0].n ? i - l->solids[0].n : i, node, &corners);
        if (!note_element(l, io_parts_of(of->dim, corners), node))
            __atomic_store_n(&l->is_missing, 1, __ATOMIC_RELAXED);
    }
}

/** Count the parts of an element that are of the list's kind. */
static int64_t count_parts_of(const listing *l, const io_parts *parts) {
    int64_t n = l->corners == 2 ? parts->n_edges : 0;
    for (int f = 0; l->corners > 2 && f < parts->n_faces; f++)
        n += io_part_corners(parts, f) == l->corners;
    return n;
}

/** Count the parts of all elements that are of the list's kind. */
static int64_t count_parts(const listing *l) {
    const int dim = l->solids[0].dim;
    int64_t n = l->solids[0].n * count_parts_of(l, io_parts_of(dim, dim + 1));
    for (int64_t i = 0; i < l->solids[1].n; i++)
        n +=
            count_parts_of(l, io_parts_of(dim, io_cell_type_corners(l->solids[1].others->type[i])));
    return n;
}

static void place_cells(void *context, int64_t begin, int64_t end, int thread) {
    const listing *l = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const uint64_t around = l->around[find_or_add(l, corners_of(l, i), -1)];
        l->where[i] = around == 0 ? NOWHERE : around == 1 ? INSIDE : BOUNDARY;
    }
}

static int32_t tag_of(const io_list *list, int64_t i) {
    return list->entity && list->entity[i] >= 0 ? list->entity[i] + 1 : 0;
}

/** Make of the places of cells whether they are plain: of n_tags tags the one of most cells is, at
 *  each place where cells can be plain; of several as many the first. */
static int mark_plain(listing *l, int64_t n_tags, planish_error *error) {
    int32_t usual[N_PLACES] = {0};
    int64_t *count = pl_alloc_zero(N_PLACES * n_tags, sizeof *count);
    if (!count)
        return pl_fail_memory(error, "the groups of facets");
    for (int64_t i = 0; i < l->list.n; i++)
        count[l->where[i] * n_tags + tag_of(&l->list, i)]++;
    for (int p = 0; p < N_PLACES; p++)
        for (int32_t k = 1; k < n_tags; k++)
            if (count[p * n_tags + k] > count[p * n_tags + usual[p]])
                usual[p] = k;
    pl_free(count);
    for (int64_t i = 0; i < l->list.n; i++) {
        const int at = l->where[i];
        l->where[i] = (at == INSIDE || (at == BOUNDARY && !l->are_facets)) &&
                      tag_of(&l->list, i) == usual[at];
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
    if (status) {
        io_cells_release(cells);
        *cells = old;
        return status;
    }
    for (int64_t i = 0; i < old.n; i++)
        cells->n_plain += is_plain[i];
    int64_t to[2] = {0, old.n - cells->n_plain};
    for (int64_t i = 0; i < old.n; i++) {
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
    return PLANISH_OK;
}

/** Move the plain facets of other types behind the rest. */
static int move_others_behind(io_model *model, const uint8_t *is_plain, planish_error *error) {
    io_others old = model->flat, *o = &model->flat;
    *o = (io_others){.n = 0};
    int status = io_others_reserve(model, 2, old.n, old.n_nodes, old.entity != NULL, error);
    if (!status && old.region && !(o->region = pl_alloc(old.n, sizeof *old.region)))
        status = pl_fail_memory(error, "the elements of the file");
    if (status) {
        io_others_release(o);
        *o = old;
        return status;
    }
    for (int pass = 0; pass < 2; pass++)
        for (int64_t i = 0; i < old.n; i++) {
            if (is_plain[i] != pass)
                continue;
            const int64_t k = o->n++, length = old.offset[i + 1] - old.offset[i];
            memcpy(o->node + o->n_nodes, old.node + old.offset[i],
                   (size_t)length * sizeof *o->node);
            o->offset[o->n] = o->n_nodes += length;
            o->type[k] = old.type[i];
            o->number[k] = old.number[i];
            if (old.entity)
                o->entity[k] = old.entity[i];
            if (old.region)
                o->region[k] = old.region[i];
            o->n_plain += pass;
        }
    io_others_release(&old);
    return PLANISH_OK;
}

/** Find plain cells of a list: there are any if these are all that elements of solid_dim have. */
static int find_plain(io_model *model, int list, int solid_dim, planish_error *error) {
    listing l = {.list = io_model_list(model, list),
                 .solids = {io_model_list(model, solid_dim),
                            io_model_list(model, io_others_list(solid_dim))},
                 .corners = list == IO_FLAT_LIST ? 4 : list + 1};
    const int64_t n = l.list.n, n_elements = l.solids[0].n + l.solids[1].n;
    l.are_facets = solid_dim - l.list.dim == 1;
    if (n == 0)
        return PLANISH_OK;
    /* Of facets there are half as many as elements have, and more for the boundary; of edges at
     * least as many as elements. */
    const int64_t n_parts = count_parts(&l);
    if (n_parts == 0 || n < (l.are_facets ? n_parts / 2 : n_elements))
        return PLANISH_OK;
    int64_t n_slots = 1;
    while (n_slots < 2 * n)
        n_slots *= 2;
    l.slot = pl_alloc(n_slots, sizeof *l.slot);
    l.mask = n_slots - 1;
    l.hash = pl_hash_draw(l.slot);
    l.around = pl_alloc_zero(n, sizeof *l.around);
    l.where = pl_alloc(n, 1);
    int status = PLANISH_OK;
    if (!l.slot || !l.around || !l.where) {
        status = pl_fail_memory(error, "the facets of the file");
    } else {
        memset(l.slot, -1, (size_t)n_slots * sizeof *l.slot);
        pl_parallel_for(io_model_threads(model), n, CHUNK, add_cells, &l);
        pl_parallel_for(io_model_threads(model), n_elements, CHUNK, note_elements, &l);
        if (!l.is_missing) {
            pl_parallel_for(io_model_threads(model), n, CHUNK, place_cells, &l);
            status = mark_plain(&l, (int64_t)model->n_entities + 1, error);
            if (!status)
                status = list == IO_FLAT_LIST ? move_others_behind(model, l.where, error)
                                              : move_behind(model, list, l.where, error);
        }
    }
    pl_free(l.slot);
    pl_free(l.around);
    pl_free(l.where);
    return status;
}

/** Find the plain cells of all lists of lower dimension than the elements. */
static int find_all_plain(io_model *model, planish_error *error) {
    const int dim = io_model_dim(model);
    int status = PLANISH_OK;
    for (int d = 1; d < dim && !status; d++)
        status = find_plain(model, d, dim, error);
    if (!status && dim == 3)
        status = find_plain(model, IO_FLAT_LIST, dim, error);
    return status;
}

int io_model_hold_again(io_model *model, planish_error *error) {
    const unsigned by_lower = IO_HELD_BY_LINE | IO_HELD_BY_FACE;
    if (model->has_entities || model->lower_are_held)
        return PLANISH_OK;
    const int status = find_all_plain(model, error);
    for (int64_t i = 0; i < model->n_nodes && !status; i++)
        model->hold[i] &= (uint8_t)~by_lower;
    if (!status)
        io_model_hold_lower(model, io_model_dim(model));
    return status;
}

/* ---- the mesh ------------------------------------------------------------------------------- */

/** Let other solid elements hold their nodes, but those whose nodes may move. */
static void hold_others(io_model *model, const io_others *others) {
    for (int64_t i = 0; i < io_others_telling(others); i++) {
        if (io_cell_type_is_smoothed(others->type[i]))
            continue;
        for (int64_t k = others->offset[i]; k < others->offset[i + 1]; k++)
            if (others->node[k] >= 0)
                model->hold[others->node[k]] |= IO_HELD_BY_OTHER;
    }
}

/** Lay out a mesh whose coordinates are the file's. */
static int finish_space(io_model *model) {
    model->dim = model->written = 3;
    model->coordinates = model->xyz;
    return PLANISH_OK;
}

/** Find the plane of a mesh of flat elements and the coordinates there. The file's own places are
 *  kept where its columns are not those of the coordinates. Without a plane it is a surface in space. */
static int finish_plane(io_model *model, const io_format *format, planish_error *error) {
    int is_found;
    int status = io_plane_find(model, format, &is_found, error);
    if (status || !is_found)
        return status ? status : finish_space(model);
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

/** Fail for a mesh without an element of a known type. */
static int fail_empty(const io_model *model, planish_error *error) {
    const char *path = io_model_opened(model)->path;
    if (model->n_other > 0)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: its elements (%" PRId64
                       ") are all of types that planish does not read, or of third "
                       "order or higher: there is nothing to smooth",
                       path, model->n_other);
    return pl_fail(error, PLANISH_ERROR_FORMAT,
                   "%s: has no element of two or three dimensions: there is nothing to smooth",
                   path);
}

int io_model_finish(io_model *model, const io_format *format, planish_error *error) {
    const int dim = model->dim = io_model_dim(model);
    model->n_other -= model->flat.n + model->solid.n; /* which readers have counted, too */
    int status = io_complete_mids(model, error);
    if (!status)
        status = find_all_plain(model, error);
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
    if (!model->lower_are_held)
        io_model_hold_lower(model, dim);
    if (dim == 2 && io_model_n_elements(model) > 0)
        return finish_plane(model, format, error);
    if (dim == 2)
        return fail_empty(model, error);
    if (model->columns < 3)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: solid elements in two dimensions; a third coordinate is missing",
                       io_model_opened(model)->path);
    model->n_lower += model->triangle.n + model->flat.n;
    hold_others(model, &model->solid);
    return finish_space(model);
}
