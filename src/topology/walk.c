/* walk: a subset of a mesh, found from neighbour to neighbour. */
#include "topology/walk.h"

#include "base/memory.h"
#include "base/status.h"
#include "topology/local_map.h"

#include <inttypes.h>
#include <stdlib.h>

/** Number met, and what came with it. */
typedef struct met {
    int32_t item, other;
} met;

/** Numbers met, each once, in the order of their first appearance. */
typedef struct list {
    met *met;         /* [map.count] */
    int64_t room;     /* of met */
    int64_t most;     /* keys that the map has room for */
    pl_local_map map; /* of items to their places */
} list;

/** The walk under way. */
typedef struct walk {
    const planish_mesh *mesh;
    list nodes; /* other: an element of each */
    list elements;
    list star; /* elements of the node that is looked at */
    planish_error *error;
    int status;
} walk;

/** Empty the list, and make its map; -1 without memory. */
static int list_empty(list *l) {
    l->most = l->most > 0 ? l->most : PL_LOCAL_MAP_SIZE / 2;
    return pl_local_map_empty(&l->map, l->most);
}

/** Add item to the list if it is new there. */
static void add_new(walk *w, list *l, int64_t item, int64_t other) {
    const int32_t n = l->map.count;
    met *grown = pl_grow(l->met, n, n + 1, &l->room, sizeof *grown);
    int done = grown != NULL;
    l->met = done ? grown : l->met;
    if (done && n >= l->most) { /* a larger map */
        l->most *= 2;
        done = pl_local_map_empty(&l->map, l->most) == 0;
        for (int32_t i = 0; done && i < n; i++)
            pl_local_map_add(&l->map, (uint64_t)(uint32_t)l->met[i].item);
    }
    if (!done) {
        w->status = pl_fail_memory(w->error, "the elements around a node");
    } else if (pl_local_map_add(&l->map, (uint64_t)item) == n) {
        l->met[n] = (met){(int32_t)item, (int32_t)other};
    }
}

static int corner_of(const walk *w, int64_t element, int64_t node) {
    for (int j = 0; j <= w->mesh->dim; j++)
        if (pl_corner(w->mesh, element, j) == node)
            return j;
    return -1;
}

/** Go on from element over its facets at node. */
static void visit_neighbours(walk *w, int64_t element, int64_t node) {
    const planish_mesh *mesh = w->mesh;
    for (int j = 0; j <= mesh->dim && !w->status; j++) {
        if (pl_corner(mesh, element, j) == node)
            continue;
        const int64_t at = element * (mesh->dim + 1) + j;
        const int64_t other = mesh->neighbours ? mesh->neighbours[at] : mesh->neighbours64[at];
        if (other == -1)
            continue;
        int is_neighbour = other >= 0 && other < mesh->n_elements && other != element;
        for (int k = 0; k <= mesh->dim && is_neighbour; k++) /* by the facet without corner j */
            is_neighbour = k == j || corner_of(w, other, pl_corner(mesh, element, k)) >= 0;
        if (is_neighbour)
            add_new(w, &w->star, other, 0);
        else
            w->status = pl_fail_at(w->error, PLANISH_ERROR_MESH, element, -1,
                                   "mesh.neighbours of element %" PRId64 " has %" PRId64
                                   " opposite corner %d, but they share no such facet; correct it, "
                                   "or give no neighbours",
                                   element, other, j);
    }
}

/** Add the elements of a node, of which element is one, and the nodes of these. */
static void visit_star(walk *w, int64_t node, int64_t element) {
    if (list_empty(&w->star) != 0)
        w->status = pl_fail_memory(w->error, "the elements around a node");
    else
        add_new(w, &w->star, element, 0);
    for (int32_t i = 0; !w->status && i < w->star.map.count; i++) {
        const int64_t e = w->star.met[i].item;
        w->status = pl_check_element(w->mesh, e, w->error);
        for (int j = 0; !w->status && j <= w->mesh->dim; j++)
            add_new(w, &w->nodes, pl_corner(w->mesh, e, j), e);
        if (!w->status)
            add_new(w, &w->elements, e, 0);
        if (!w->status)
            visit_neighbours(w, e, node);
    }
}

static int compare_numbers(const void *a, const void *b) {
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

static int32_t *sorted_items(const met *from, int64_t n) {
    int32_t *copy = pl_alloc(n, sizeof *copy);
    for (int64_t i = 0; copy && i < n; i++)
        copy[i] = from[i].item;
    if (copy)
        qsort(copy, (size_t)n, sizeof *copy, compare_numbers);
    return copy;
}

/** The subset of what was met; the first n_selected nodes are selected. */
static int make_subset(walk *w, int64_t n_selected, pl_subset *subset) {
    const int corners = w->mesh->dim + 1;
    subset->n_nodes = w->nodes.map.count;
    subset->n_elements = w->elements.map.count;
    subset->node = sorted_items(w->nodes.met, subset->n_nodes);
    subset->element = sorted_items(w->elements.met, subset->n_elements);
    subset->elements = pl_alloc(subset->n_elements * corners, sizeof *subset->elements);
    subset->is_selected = pl_alloc_zero(subset->n_nodes, sizeof *subset->is_selected);
    if (!subset->node || !subset->element || !subset->elements || !subset->is_selected)
        return -1;
    met *nodes = w->nodes.met; /* other becomes the number: elements are no longer wanted */
    for (int64_t i = 0; i < subset->n_nodes; i++) {
        const int32_t place = pl_local_map_add(&w->nodes.map, (uint64_t)subset->node[i]);
        nodes[place].other = (int32_t)i;
        subset->is_selected[i] = place < n_selected;
    }
    for (int64_t i = 0; i < subset->n_elements; i++)
        for (int j = 0; j < corners; j++) {
            const int64_t node = pl_corner(w->mesh, subset->element[i], j);
            subset->elements[i * corners + j] =
                nodes[pl_local_map_add(&w->nodes.map, (uint64_t)node)].other;
        }
    return 0;
}

int pl_subset_by_walk(const planish_mesh *mesh, const pl_seeds *seeds, int rings, pl_subset *subset,
                      planish_error *error) {
    walk w = {.mesh = mesh, .error = error};
    int64_t done = 0, n_selected = 0;
    *subset = (pl_subset){0};
    if (list_empty(&w.nodes) != 0 || list_empty(&w.elements) != 0)
        w.status = pl_fail_memory(error, "the elements around a node");
    for (int64_t i = 0; i < seeds->n && !w.status; i++) {
        const int64_t node = seeds->node[i], element = seeds->element[i];
        if (element < 0 || element >= mesh->n_elements || corner_of(&w, element, node) < 0)
            w.status =
                pl_fail_at(error, PLANISH_ERROR_ARGUMENT, element, node,
                           "options.around_elements says that node %" PRId64
                           " is one of element %" PRId64 ", which it is not; give an element of it",
                           node, element);
        else
            w.status = pl_check_element(mesh, element, error);
        if (!w.status)
            add_new(&w, &w.nodes, node, element);
    }
    for (int ring = 0; ring <= rings && !w.status; ring++) {
        n_selected = w.nodes.map.count;
        for (; done < n_selected && !w.status; done++)
            visit_star(&w, w.nodes.met[done].item, w.nodes.met[done].other);
    }
    if (!w.status && w.elements.map.count > 0 && make_subset(&w, n_selected, subset) != 0)
        w.status = pl_fail_memory(error, "the subset of the mesh that is worked on");
    if (w.status)
        pl_subset_destroy(subset);
    list *const lists[] = {&w.nodes, &w.elements, &w.star};
    for (int i = 0; i < 3; i++) {
        pl_free(lists[i]->met);
        pl_local_map_destroy(&lists[i]->map);
    }
    return w.status;
}
