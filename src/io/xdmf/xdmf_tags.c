/* xdmf_tags: grids that list elements of another grid once more. */
#include "io/xdmf/xdmf_tags.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>

enum { MOST_CORNERS = 8 };

const io_parts *xdmf_parts_of(int type, int *dim, int *corners) {
    static const struct {
        uint8_t types[3], dim, corners;
    } shapes[] = {
        {{VTK_TRIANGLE, 22, 22}, 2, 3}, {{9, 23, 28}, 2, 4},  {{VTK_TETRAHEDRON, 24, 24}, 3, 4},
        {{14, 27, 27}, 3, 5},           {{13, 26, 32}, 3, 6}, {{12, 25, 29}, 3, 8}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++)
        for (int k = 0; k < 3; k++)
            if (shapes[i].types[k] == type) {
                *dim = shapes[i].dim;
                *corners = shapes[i].corners;
                return io_parts_of(*dim, *corners);
            }
    return NULL;
}

/** Corners of a cell in ascending order; -1 behind them. */
typedef struct corner_key {
    int32_t node[MOST_CORNERS];
} corner_key;

static corner_key make_key(const int32_t *node, int n, int64_t first) {
    corner_key key;
    for (int i = 0; i < MOST_CORNERS; i++)
        key.node[i] = -1;
    for (int i = 0; i < n; i++) {
        const int32_t value = (int32_t)(first + node[i]);
        int at = i;
        for (; at > 0 && key.node[at - 1] > value; at--)
            key.node[at] = key.node[at - 1];
        key.node[at] = value;
    }
    return key;
}

/** Cells of the model by their corners: a hash table of places in two lists. */
typedef struct cell_table {
    io_list list[2]; /* simplices and others */
    int64_t *slot;   /* [n_slots] index, those of others behind the simplices; -1 */
    int64_t n_slots;
} cell_table;

static corner_key key_of(const cell_table *t, int64_t index) {
    int32_t node[IO_CELL_NODES];
    int corners;
    const int is_other = index >= t->list[0].n;
    io_list_nodes(&t->list[is_other], is_other ? index - t->list[0].n : index, node, &corners);
    return make_key(node, corners, 0);
}

/** Return the slot of a key, or the free one where it belongs. */
static int64_t *find_slot(const cell_table *t, const corner_key *key) {
    uint64_t hash = UINT64_C(14695981039346656037);
    for (int i = 0; i < MOST_CORNERS; i++)
        hash = (hash ^ (uint32_t)key->node[i]) * UINT64_C(1099511628211);
    for (uint64_t at = (hash ^ hash >> 32) & (uint64_t)(t->n_slots - 1);;
         at = (at + 1) & (uint64_t)(t->n_slots - 1)) {
        const corner_key other = t->slot[at] < 0 ? *key : key_of(t, t->slot[at]);
        if (memcmp(&other, key, sizeof other) == 0)
            return &t->slot[at];
    }
}

/** Fill the table with the cells of numbers below end. */
static int fill_table(cell_table *t, int64_t end, planish_error *error) {
    const int64_t n = t->list[0].n + t->list[1].n;
    for (t->n_slots = 64; t->n_slots < 2 * n; t->n_slots *= 2)
        continue;
    t->slot = pl_alloc(t->n_slots, sizeof *t->slot);
    if (!t->slot)
        return pl_fail_memory(error, "the cells");
    memset(t->slot, -1, (size_t)t->n_slots * sizeof *t->slot);
    for (int64_t i = 0; i < n; i++) {
        const int is_other = i >= t->list[0].n;
        if (io_list_number(&t->list[is_other], is_other ? i - t->list[0].n : i) >= end)
            continue;
        const corner_key key = key_of(t, i);
        int64_t *slot = find_slot(t, &key);
        *slot = *slot < 0 ? i : *slot;
    }
    return PLANISH_OK;
}

/** Find the number of the cell with the corners of cell i of the grid, or -1. */
static int64_t find_cell(const cell_table *t, const vtk_grid *grid, int64_t i) {
    int dim = 0, corners = 0;
    const int32_t *node = grid->connectivity + grid->offset[i];
    if (!xdmf_parts_of(grid->type[i], &dim, &corners) || dim != t->list[0].dim ||
        grid->offset[i + 1] - grid->offset[i] < corners)
        return -1;
    for (int k = 0; k < corners; k++)
        if (node[k] < 0 || node[k] >= grid->n_points)
            return -1;
    const corner_key key = make_key(node, corners, grid->first_point);
    const int64_t at = *find_slot(t, &key);
    const int is_other = at >= t->list[0].n;
    return at < 0 ? -1 : io_list_number(&t->list[is_other], is_other ? at - t->list[0].n : at);
}

int xdmf_find_map(const io_model *model, const vtk_grid *grid, int64_t end, int64_t **map,
                  planish_error *error) {
    int dim = 0, corners;
    *map = NULL;
    if (grid->n == 0 || end == 0 || !xdmf_parts_of(grid->type[0], &dim, &corners))
        return PLANISH_OK;
    cell_table t = {.list = {io_model_list(model, dim), io_model_list(model, io_others_list(dim))}};
    int status = t.list[0].n + t.list[1].n > 0 ? fill_table(&t, end, error) : PLANISH_OK;
    if (t.slot && !status && !(*map = pl_alloc(grid->n, sizeof **map)))
        status = pl_fail_memory(error, "the cells");
    for (int64_t i = 0; i < grid->n && *map; i++) {
        (*map)[i] = find_cell(&t, grid, i);
        if ((*map)[i] < 0) {
            pl_free(*map);
            *map = NULL;
        }
    }
    pl_free(t.slot);
    return status;
}
