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

/** Return the key of a slot's cell. */
static corner_key key_of(const xdmf_table *t, int64_t slot) {
    int32_t node[IO_CELL_NODES];
    int corners;
    io_list_nodes(&t->list[slot % 2], slot / 2, node, &corners);
    return make_key(node, corners, 0);
}

/** Return the slot of a key, or the free one where it belongs. */
static int64_t *find_slot(const xdmf_table *t, const corner_key *key) {
    pl_hash hash = t->hash;
    pl_hash_add_integers(&hash, key->node, MOST_CORNERS);
    for (uint64_t at = pl_hash_end(hash) & (uint64_t)(t->n_slots - 1);;
         at = (at + 1) & (uint64_t)(t->n_slots - 1)) {
        const corner_key other = t->slot[at] < 0 ? *key : key_of(t, t->slot[at]);
        if (memcmp(&other, key, sizeof other) == 0)
            return &t->slot[at];
    }
}

/** Make room for n cells: the table is at most half full, and empty if it has been made larger. */
static int make_room(xdmf_table *t, int64_t n, planish_error *error) {
    int64_t n_slots = t->n_slots > 0 ? t->n_slots : 64;
    while (n_slots < 2 * n)
        n_slots *= 2;
    if (n_slots == t->n_slots)
        return PLANISH_OK;
    int64_t *slot = pl_alloc(n_slots, sizeof *slot);
    if (!slot)
        return pl_fail_memory(error, "the cells");
    memset(slot, -1, (size_t)n_slots * sizeof *slot);
    pl_free(t->slot);
    t->slot = slot;
    t->hash = pl_hash_draw(slot);
    t->n_slots = n_slots;
    t->n_entered[0] = t->n_entered[1] = 0;
    return PLANISH_OK;
}

/** Enter the cells of numbers below end that are not there yet. */
static int enter_cells(xdmf_table *t, const io_model *model, int dim, int64_t end,
                       planish_error *error) {
    t->list[0] = io_model_list(model, dim);
    t->list[1] = io_model_list(model, io_others_list(dim));
    const int status = make_room(t, t->list[0].n + t->list[1].n, error);
    for (int k = 0; k < 2 && !status; k++) {
        int64_t *i = &t->n_entered[k];
        for (; *i < t->list[k].n && io_list_number(&t->list[k], *i) < end; ++*i) {
            const corner_key key = key_of(t, 2 * *i + k);
            int64_t *slot = find_slot(t, &key);
            *slot = *slot < 0 ? 2 * *i + k : *slot;
        }
    }
    return status;
}

/** Find the number of the cell with the corners of cell i of the grid, or -1. */
static int64_t find_cell(const xdmf_table *t, const vtk_grid *grid, int64_t i) {
    int dim = 0, corners = 0;
    const int32_t *node = grid->connectivity + grid->offset[i];
    const int64_t n = grid->offset[i + 1] - grid->offset[i];
    if (!xdmf_parts_of(grid->type[i], &dim, &corners) || dim != t->list[0].dim || n < corners)
        return -1;
    for (int64_t k = 0; k < n; k++) /* mids, too: nobody else looks at a cell that is there */
        if (node[k] < 0 || node[k] >= grid->n_points)
            return -1;
    const corner_key key = make_key(node, corners, grid->first_point);
    const int64_t slot = *find_slot(t, &key);
    return slot < 0 ? -1 : io_list_number(&t->list[slot % 2], slot / 2);
}

int xdmf_find_map(xdmf_tables *tables, const io_model *model, const vtk_grid *grid, int64_t end,
                  int64_t **map, planish_error *error) {
    int dim = 0, corners;
    *map = NULL;
    if (grid->n == 0 || end == 0 || !xdmf_parts_of(grid->type[0], &dim, &corners))
        return PLANISH_OK;
    xdmf_table *t = &tables->table[dim - 2];
    const int status = enter_cells(t, model, dim, end, error);
    if (status || find_cell(t, grid, 0) < 0)
        return status;
    *map = pl_alloc(grid->n, sizeof **map);
    if (!*map)
        return pl_fail_memory(error, "the cells");
    for (int64_t i = 0; i < grid->n && *map; i++) {
        (*map)[i] = find_cell(t, grid, i);
        if ((*map)[i] < 0) {
            pl_free(*map);
            *map = NULL;
        }
    }
    return PLANISH_OK;
}

void xdmf_tables_release(xdmf_tables *tables) {
    pl_free(tables->table[0].slot);
    pl_free(tables->table[1].slot);
}
