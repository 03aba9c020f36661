/* same: whether two files have one mesh but for coordinates. */
#include "job/same.h"

#include "terminal/message.h"

#include <inttypes.h>
#include <string.h>

/** Find the nodes [*n] of an element. */
static const int32_t *nodes_of(const planish_mesh *mesh, int64_t element, int64_t *n) {
    const planish_cells *cells = mesh->cells;
    *n = cells ? cells->offset[element + 1] - cells->offset[element] : mesh->dim + 1;
    return cells ? cells->node + cells->offset[element] : mesh->elements + element * *n;
}

static int is_of_type(const planish_mesh *a, const planish_mesh *b, int64_t element) {
    return !a->cells || a->cells->type[element] == b->cells->type[element];
}

/** Find the first element that has other nodes, or another type, in b than in a; -1: there is none. */
static int64_t find_difference(const planish_mesh *a, const planish_mesh *b) {
    int64_t n, m;
    for (int64_t i = 0; i < a->n_elements; i++) {
        const int32_t *p = nodes_of(a, i, &n), *q = nodes_of(b, i, &m);
        if (!is_of_type(a, b, i) || n != m || memcmp(p, q, (size_t)n * sizeof *p) != 0)
            return i;
    }
    return -1;
}

int pl_same_meshes(const planish_mesh *a, const planish_mesh *b) {
    return a->dim == b->dim && a->n_nodes == b->n_nodes && a->n_elements == b->n_elements &&
           !a->cells == !b->cells && find_difference(a, b) < 0;
}

int pl_same_check(const pl_same_mesh *mine, const pl_same_mesh *other, const char *advice) {
    const planish_mesh *a = mine->mesh, *b = other->mesh;
    if (b->dim != a->dim)
        return pl_complain(PL_EXIT_FAILED, "%s is a mesh in %d dimensions, %s in %d; %s",
                           other->path, b->dim, mine->path, a->dim, advice);
    if (b->n_nodes != a->n_nodes)
        return pl_complain(PL_EXIT_FAILED, "%s has %" PRId64 " nodes, %s has %" PRId64 "; %s",
                           other->path, b->n_nodes, mine->path, a->n_nodes, advice);
    if (b->n_elements != a->n_elements || !a->cells != !b->cells)
        return pl_complain(PL_EXIT_FAILED, "%s has %" PRId64 " elements, %s has %" PRId64 "%s; %s",
                           other->path, b->n_elements, mine->path, a->n_elements,
                           b->n_elements == a->n_elements ? " of other types" : "", advice);
    const int64_t i = find_difference(a, b);
    if (i < 0)
        return 0;
    return pl_complain(PL_EXIT_FAILED, "element %" PRId64 " of %s %s element %" PRId64 " of %s; %s",
                       planish_file_element_number(other->file, i), other->path,
                       is_of_type(a, b, i) ? "has other nodes than" : "is of another type than",
                       planish_file_element_number(mine->file, i), mine->path, advice);
}
