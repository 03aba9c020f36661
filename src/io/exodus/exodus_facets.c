/* exodus_facets: facets of a mesh that is written, as sides of its elements. The corners of all facets
 * are sorted, and the sides of elements whose corners all are on facets are looked up among them.
 */
#include "io/exodus/exodus_facets.h"

#include "io/core/elements.h"
#include "io/core/parts.h"
#include "io/exodus/exodus_format.h"

#include "base/memory.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

enum { MOST_CORNERS = 4 };

/** A facet by its corners. */
typedef struct facet_key {
    int32_t corner[MOST_CORNERS]; /* ascending, behind -1 for those that there are not */
    int32_t n_nodes;
    int64_t facet; /* its index */
} facet_key;

typedef struct facet_search {
    const io_view *view;
    const io_view_blocks *blocks;
    const io_view_type *types;
    int is_space;
    facet_key *key;     /* [n] sorted */
    uint8_t *is_on;     /* [n_nodes] nodes of facets */
    int64_t n_elements; /* that have been looked at */
    exodus_facets *facets;
} facet_search;

static int compare_keys(const void *a, const void *b) {
    const facet_key *x = a, *y = b;
    for (int i = 0; i < MOST_CORNERS; i++)
        if (x->corner[i] != y->corner[i])
            return x->corner[i] < y->corner[i] ? -1 : 1;
    return (x->facet > y->facet) - (x->facet < y->facet);
}

/** Make the key of n corners. */
static facet_key key_of(const int32_t *corner, int n, int n_nodes, int64_t facet) {
    facet_key key = {{-1, -1, -1, -1}, n_nodes, facet};
    for (int i = 0; i < n; i++) {
        int at = MOST_CORNERS - n + i;
        for (; at > 0 && key.corner[at - 1] > corner[i]; at--)
            key.corner[at] = key.corner[at - 1];
        key.corner[at] = corner[i];
    }
    return key;
}

/** Sort the facets by their corners. */
static int sort_facets(facet_search *s, planish_error *error) {
    int64_t n = 0;
    io_view_cell cell;
    s->key = pl_alloc(s->facets->n, sizeof *s->key);
    s->is_on = pl_alloc_zero(s->view->model->n_nodes, 1);
    if (!s->key || !s->is_on)
        return pl_fail_memory(error, "the sides of elements");
    for (int64_t b = 0; b < s->blocks->n; b++) {
        const io_view_block *block = &s->blocks->block[b];
        for (int64_t i = 0; i < block->n && block->dim == s->facets->dim; i++, n++) {
            io_view_cell_at(s->view, block->cell[i], &cell);
            const int corners = cell.dim == 1 ? 2 : io_cell_type_corners(cell.type);
            for (int k = 0; k < corners; k++)
                s->is_on[cell.node[k]] = 1;
            s->key[n] = key_of(cell.node, corners, cell.n_nodes, n);
        }
    }
    qsort(s->key, (size_t)n, sizeof *s->key, compare_keys);
    return PLANISH_OK;
}

/** Note all facets that have the corners of a side, and no nodes that it does not have. */
static void look_up(facet_search *s, const int32_t *corner, int n, int n_nodes, int number) {
    const facet_key key = key_of(corner, n, n_nodes, -1);
    int64_t low = 0, high = s->facets->n;
    while (low < high) {
        const int64_t middle = low + (high - low) / 2;
        if (compare_keys(&s->key[middle], &key) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < s->facets->n && memcmp(s->key[low].corner, key.corner, sizeof key.corner) == 0;
         low++) {
        exodus_side *side = &s->facets->side[s->key[low].facet];
        if (side->element == 0 && s->key[low].n_nodes <= n_nodes)
            *side = (exodus_side){(int32_t)s->n_elements, number};
    }
}

/** Return the nodes of a side of n corners of a type. */
static int side_nodes(int type, int n) {
    const int is_straight = type == io_cell_type_straight(type);
    const int has_middle = n == MOST_CORNERS && io_cell_type_without_faces(type) != type;
    return is_straight ? n : n == 2 ? 3 : 2 * n + has_middle;
}

/** Return Exodus' number of a face or edge (io_parts) of an element. */
static int number_of(const facet_search *s, int dim, int corners, int part) {
    int side = 0;
    if (dim == 2)
        return part + 1 + (s->is_space ? 2 : 0);
    while (exodus_side_faces[corners][side] != part)
        side++;
    return side + 1;
}

/** Look up the sides of an element. */
static void look_at_element(facet_search *s, const io_view_cell *cell) {
    const int corners = io_cell_type_corners(cell->type);
    const io_parts *parts = io_parts_of(cell->dim, corners);
    const int n_parts = cell->dim == 2 ? parts->n_edges : parts->n_faces;
    for (int part = 0; part < n_parts; part++) {
        const int8_t *at = cell->dim == 2 ? parts->edge[part] : parts->face[part];
        const int n = cell->dim == 2 ? 2 : io_part_corners(parts, part);
        int32_t corner[MOST_CORNERS];
        int n_on = 0;
        for (int k = 0; k < n; k++) {
            corner[k] = cell->node[at[k]];
            n_on += s->is_on[corner[k]];
        }
        if (n_on == n)
            look_up(s, corner, n, side_nodes(cell->type, n),
                    number_of(s, cell->dim, corners, part));
    }
}

static void look_at_elements(facet_search *s) {
    io_view_cell cell;
    for (int64_t b = 0; b < s->blocks->n; b++) {
        const io_view_block *block = &s->blocks->block[b];
        const io_view_type *type = io_view_find_type(s->types, block->type);
        for (int64_t i = 0; i < block->n && block->dim == s->facets->dim + 1; i++) {
            io_view_cell_at(s->view, block->cell[i], &cell);
            io_view_fit_cell(s->view, type, NULL, &cell);
            s->n_elements++;
            look_at_element(s, &cell);
        }
    }
}

int exodus_facets_find(const io_view *view, const io_view_blocks *blocks, const io_view_type *types,
                       int is_space, exodus_facets *facets, planish_error *error) {
    *facets = (exodus_facets){.dim = io_model_dim(view->model) - 1};
    facet_search s = {
        .view = view, .blocks = blocks, .types = types, .is_space = is_space, .facets = facets};
    for (int64_t b = 0; b < blocks->n; b++)
        facets->n += blocks->block[b].dim == facets->dim ? blocks->block[b].n : 0;
    facets->side = pl_alloc_zero(facets->n, sizeof *facets->side);
    int status = facets->side ? PLANISH_OK : pl_fail_memory(error, "the sides of elements");
    if (!status && facets->n > 0)
        status = sort_facets(&s, error);
    if (!status && facets->n > 0)
        look_at_elements(&s);
    pl_free(s.key);
    pl_free(s.is_on);
    return status;
}

void exodus_facets_release(exodus_facets *facets) {
    pl_free(facets->side);
    facets->side = NULL;
}
