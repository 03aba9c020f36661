/* xdmf_grids: the one mesh that the grids of an XDMF file are. */
#include "io/xdmf/xdmf_grids.h"

#include "base/memory.h"
#include "base/status.h"

#include <string.h>
#include <strings.h>

enum { MOST_LEVELS = 32, MOST_PIECES = 16384 };

typedef struct grid_walk {
    xdmf_reader *r;
    xdmf_mesh *mesh;
    int is_later; /* in a step that is not the first */
    int level;
    int64_t n_taken; /* grids, once for each reference to them */
    io_order geometries, pieces;
} grid_walk;

/* ---- one grid ------------------------------------------------------------------------------- */

/** Find the first element of that name in another, behind references; -1: there is none. */
static int find_only(xdmf_reader *r, int64_t element, const char *name, int64_t *found) {
    xdmf_list list = {0};
    int status = xdmf_children(&r->document, element, name, &list);
    *found = -1;
    if (!status && list.n > 1)
        status = xdmf_fail(&r->document, element, "there is more than one %s in it", name);
    if (!status && list.n == 1)
        status = xdmf_resolve(&r->document, list.element[0], found);
    pl_free(list.element);
    return status;
}

/** Find what a Geometry element says. */
static int take_geometry(xdmf_reader *r, int64_t element, xdmf_geometry *g) {
    static const struct {
        const char *name;
        int columns, is_apart;
    } types[] = {{"XYZ", 3, 0}, {"XY", 2, 0}, {"X_Y_Z", 3, 1}, {"X_Y", 2, 1}};
    const xdmf_document *d = &r->document;
    const char *name = xdmf_attribute(d, element, "GeometryType");
    name = name ? name : xdmf_attribute(d, element, "Type");
    name = name ? name : "XYZ";
    *g = (xdmf_geometry){.element = element};
    const int status = xdmf_items_in(r, element, g->item, &g->n_items);
    if (status)
        return status;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcasecmp(name, types[i].name) != 0)
            continue;
        g->columns = types[i].columns;
        const int n_wanted = types[i].is_apart ? g->columns : 1;
        return g->n_items == n_wanted
                   ? PLANISH_OK
                   : xdmf_fail(d, element,
                               "%d DataItem elements were expected in it, and there "
                               "are %d",
                               n_wanted, g->n_items);
    }
    return xdmf_fail(d, element,
                     "the type %.40s is not read; planish reads points: XYZ, XY, X_Y_Z "
                     "or X_Y",
                     name);
}

static int compare_geometry(const void *key, const void *list, int64_t index) {
    const xdmf_geometry *a = key, *b = (const xdmf_geometry *)list + index;
    int order = a->columns != b->columns ? a->columns - b->columns : a->n_items - b->n_items;
    for (int i = 0; i < a->n_items && !order; i++)
        order = xdmf_compare(&a->item[i], &b->item[i]);
    return order;
}

/** Find the number of the geometry of a grid, a new one if there is none like it. */
static int find_geometry(grid_walk *w, int64_t element, int64_t *index) {
    xdmf_mesh *m = w->mesh;
    xdmf_geometry g;
    const int status = take_geometry(w->r, element, &g);
    if (status)
        return status;
    int64_t place;
    *index = io_order_find(&w->geometries, &g, m->geometry, compare_geometry, &place);
    if (*index >= 0)
        return PLANISH_OK;
    *index = m->n_geometries;
    return w->is_later || (pl_append(&m->geometry, &m->n_geometries, &m->geometry_capacity, &g,
                                     sizeof g) &&
                           io_order_insert(&w->geometries, place, *index))
               ? PLANISH_OK
               : pl_fail_memory(w->r->error, "the grids of the file");
}

static int fail_moving(const grid_walk *w, int64_t grid) {
    return xdmf_fail(&w->r->document, grid,
                     "this time step has points or elements of its own; write the step that is to "
                     "be smoothed to a file of its own");
}

static int compare_piece(const void *key, const void *list, int64_t index) {
    const xdmf_piece *a = key, *b = (const xdmf_piece *)list + index;
    if (a->geometry != b->geometry)
        return a->geometry < b->geometry ? -1 : 1;
    if (a->has_item != b->has_item)
        return a->has_item - b->has_item;
    return a->has_item ? xdmf_compare(&a->item, &b->item)
                       : (a->topology > b->topology) - (a->topology < b->topology);
}

/** Find the piece that a grid is of, and add the grid to it; a new one if there is none like it. */
static int add_to_piece(grid_walk *w, int64_t grid, xdmf_piece *new) {
    xdmf_mesh *m = w->mesh;
    int64_t place;
    const int64_t i = io_order_find(&w->pieces, new, m->piece, compare_piece, &place);
    xdmf_piece *piece = i < 0 ? NULL : &m->piece[i];
    if (w->is_later)
        return piece ? PLANISH_OK : fail_moving(w, grid);
    if (!piece && m->n_pieces == MOST_PIECES)
        return xdmf_fail(&w->r->document, grid, "there are more than %d pieces", MOST_PIECES);
    if (!piece && io_order_insert(&w->pieces, place, m->n_pieces))
        piece = pl_append(&m->piece, &m->n_pieces, &m->piece_capacity, new, sizeof *new);
    return piece && pl_append(&piece->grids.element, &piece->grids.n, &piece->grids.capacity, &grid,
                              sizeof grid)
               ? PLANISH_OK
               : pl_fail_memory(w->r->error, "the grids of the file");
}

static int take_uniform(grid_walk *w, int64_t grid) {
    xdmf_reader *r = w->r;
    xdmf_piece piece = {.topology = -1};
    xdmf_item item[XDMF_MOST_ITEMS];
    int64_t geometry = -1;
    int n = 0;
    int status = find_only(r, grid, "Topology", &piece.topology);
    if (!status)
        status = find_only(r, grid, "Geometry", &geometry);
    if (!status && (piece.topology < 0 || geometry < 0))
        return xdmf_fail(&r->document, grid, "a Topology and a Geometry were expected in it");
    if (!status)
        status = xdmf_items_in(r, piece.topology, item, &n);
    if (!status && n > 1)
        status = xdmf_fail(&r->document, piece.topology, "one DataItem was expected in it");
    if (!status)
        status = find_geometry(w, geometry, &piece.geometry);
    if (status)
        return status;
    piece.has_item = n == 1;
    if (n == 1)
        piece.item = item[0];
    return add_to_piece(w, grid, &piece);
}

/* ---- grids in grids -------------------------------------------------------------------------- */

static int take_grid(grid_walk *w, int64_t grid);

/** Take the grids in a domain, a collection or a tree. is_series: they are steps in time. */
static int take_grids(grid_walk *w, int64_t element, int is_series) {
    const int was_later = w->is_later;
    xdmf_list list = {0};
    int status = xdmf_children(&w->r->document, element, "Grid", &list);
    if (!status && ++w->level > MOST_LEVELS)
        status = xdmf_fail(&w->r->document, element, "grids are in grids too many times");
    for (int64_t i = 0; i < list.n && !status; i++) {
        w->is_later = was_later || (is_series && i > 0);
        status = take_grid(w, list.element[i]);
    }
    w->is_later = was_later;
    w->level--;
    pl_free(list.element);
    return status;
}

static int take_grid(grid_walk *w, int64_t grid) {
    const xdmf_document *d = &w->r->document;
    int64_t element;
    /* Each is in one other grid. References can make many of a few, as they lead to grids with others. */
    if (++w->n_taken > d->n)
        return xdmf_fail(d, grid, "grids are referred to over and over");
    const int status = xdmf_resolve(&w->r->document, grid, &element);
    if (status)
        return status;
    const char *type = xdmf_attribute(d, element, "GridType");
    const char *collection = xdmf_attribute(d, element, "CollectionType");
    type = type ? type : xdmf_attribute(d, element, "Type");
    if (!type || strcasecmp(type, "Uniform") == 0)
        return take_uniform(w, element);
    if (strcasecmp(type, "Tree") == 0)
        return take_grids(w, element, 0);
    if (strcasecmp(type, "Collection") == 0)
        return take_grids(w, element, collection && strcasecmp(collection, "Temporal") == 0);
    return xdmf_fail(d, element, "GridType %.30s is not read", type);
}

int xdmf_mesh_find(xdmf_reader *r, xdmf_mesh *mesh) {
    grid_walk w = {.r = r, .mesh = mesh};
    xdmf_list domains = {0};
    *mesh = (xdmf_mesh){.n_pieces = 0};
    int status = xdmf_children(&r->document, 0, "Domain", &domains);
    if (!status && domains.n > 1)
        status = xdmf_fail(&r->document, domains.element[1],
                           "there is more than one; write each to a file of its own");
    if (!status && domains.n == 1)
        status = take_grids(&w, domains.element[0], 0);
    if (!status && mesh->n_pieces == 0)
        status = xdmf_fail(&r->document, 0, "there is no Grid in a Domain");
    pl_free(domains.element);
    io_order_release(&w.geometries);
    io_order_release(&w.pieces);
    return status;
}

void xdmf_mesh_release(xdmf_mesh *mesh) {
    for (int64_t i = 0; i < mesh->n_pieces; i++)
        pl_free(mesh->piece[i].grids.element), pl_free(mesh->piece[i].map);
    pl_free(mesh->piece);
    pl_free(mesh->geometry);
}
