/* share: from what DMPlex hands out to what planish wants of a part. */
#include "mpi/share.h"

#include "base/status.h"

#include <inttypes.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int pl_fail_petsc(planish_error *error, PetscErrorCode code) {
    const char *text = NULL;
    PetscErrorMessage(code, &text, NULL);
    return pl_fail(error, code == PETSC_ERR_MEM ? PLANISH_ERROR_MEMORY : PLANISH_ERROR_PROCESS,
                   "PETSc could not distribute the mesh: %s", text ? text : "unknown error");
}

/* ---- which nodes and elements --------------------------------------------------------------- */

/** Nodes and elements of the part, in the order of the whole mesh: where each is in the piece; -1:
 * a node of no element, that only the first process has. Everything is owned. */
typedef struct selection {
    int64_t n_nodes, n_elements;
    int64_t *node, *element; /* in the piece */
    int32_t *number;         /* [n_nodes] in the whole mesh */
    int32_t *here;           /* [piece's n_nodes] in the part, or -1 */
} selection;

typedef struct numbered {
    int32_t number;
    int64_t at;
} numbered;

static int compare_numbered(const void *a, const void *b) {
    const numbered *p = a, *q = b;
    return (p->number > q->number) - (p->number < q->number);
}

/** The places of the numbers [n], ascending by them; NULL without memory. */
static numbered *sort_numbers(const int32_t *number, int64_t n) {
    numbered *sorted = pl_new_array(n, sizeof *sorted);
    for (int64_t i = 0; sorted && i < n; i++)
        sorted[i] = (numbered){number[i], i};
    if (sorted)
        qsort(sorted, (size_t)n, sizeof *sorted, compare_numbered);
    return sorted;
}

/** Elements with a node of this process, and their nodes. Corners become places in the piece. */
static int select_elements(pl_piece *p, const numbered *nodes, selection *s) {
    const int corners = p->dim + 1;
    numbered *cells = sort_numbers(p->element, p->n_elements);
    s->element = pl_new_array(p->n_elements, sizeof *s->element);
    s->here = pl_new_array(p->n_nodes, sizeof *s->here);
    if (!cells || !s->element || !s->here) {
        free(cells);
        return -1;
    }
    memset(s->here, -1, (size_t)p->n_nodes * sizeof *s->here);
    for (int64_t i = 0; i < p->n_elements; i++) {
        const int64_t cell = cells[i].at;
        int32_t *corner = p->corner + cell * corners;
        int is_ours = 0;
        for (int j = 0; j < corners; j++) {
            const numbered key = {.number = corner[j]};
            const numbered *found =
                bsearch(&key, nodes, (size_t)p->n_nodes, sizeof *nodes, compare_numbered);
            corner[j] = found ? (int32_t)found->at : -1;
            is_ours |= p->owner[corner[j]] == p->rank;
        }
        for (int j = 0; is_ours && j < corners; j++)
            s->here[corner[j]] = 0;
        if (is_ours)
            s->element[s->n_elements++] = cell;
    }
    free(cells);
    return 0;
}

/** Number the nodes of the selected elements; unused [n] ones, by their numbers, are among them. */
static int select_nodes(const pl_piece *p, const numbered *nodes, const int32_t *unused, int64_t n,
                        selection *s) {
    int64_t k = 0;
    s->node = pl_new_array(p->n_nodes + n, sizeof *s->node);
    s->number = pl_new_array(p->n_nodes + n, sizeof *s->number);
    if (!s->node || !s->number)
        return -1;
    for (int64_t i = 0; i <= p->n_nodes; i++) {
        for (; k < n && (i == p->n_nodes || unused[k] < nodes[i].number); k++) {
            s->node[s->n_nodes] = -1;
            s->number[s->n_nodes++] = unused[k];
        }
        if (i == p->n_nodes || s->here[nodes[i].at] < 0)
            continue;
        s->here[nodes[i].at] = (int32_t)s->n_nodes;
        s->node[s->n_nodes] = nodes[i].at;
        s->number[s->n_nodes++] = nodes[i].number;
    }
    return 0;
}

/** The nodes of no element of whole, [*n]; NULL without memory. */
static int32_t *find_unused(const planish_mesh *whole, int64_t *n) {
    const int64_t n_nodes = whole ? whole->n_nodes : 0;
    const int64_t n_corners = whole ? whole->n_elements * (whole->dim + 1) : 0;
    uint8_t *is_used = pl_new_array(n_nodes, 1);
    *n = 0;
    for (int64_t i = 0; is_used && i < n_corners; i++)
        is_used[whole->elements[i]] = 1;
    for (int64_t i = 0; is_used && i < n_nodes; i++)
        *n += !is_used[i];
    int32_t *unused = is_used ? pl_new_array(*n, sizeof *unused) : NULL;
    *n = 0;
    for (int64_t i = 0; unused && i < n_nodes; i++)
        if (!is_used[i])
            unused[(*n)++] = (int32_t)i;
    free(is_used);
    return unused;
}

/** Values [.][size] of nodes or elements of the part, which are at [n] in those of the piece; of a
 *  node that the piece has not (at -1) in whole, by its number. NULL without memory. */
static void *take_values(int64_t n, const int64_t *at, const int32_t *number, const void *of_piece,
                         const void *whole, size_t size) {
    char *values = pl_new_array(n, size);
    for (int64_t i = 0; values && i < n; i++)
        memcpy(values + (size_t)i * size,
               at[i] >= 0 ? (const char *)of_piece + (size_t)at[i] * size
                          : (const char *)whole + (size_t)number[i] * size,
               size);
    return values;
}

/** Who has which ghosts of ours: create the exchange. */
static int make_exchange(pl_share *share, MPI_Comm comm, const pl_piece *p, const selection *s,
                         planish_error *error) {
    int *at_root = pl_new_array(p->n_points, sizeof *at_root),
        *at = pl_new_array(p->n_points, sizeof *at);
    pl_ghost *ghost = pl_new_array(s->n_nodes, sizeof *ghost);
    int64_t n = 0;
    int status = at_root && at && ghost ? 0 : pl_fail_memory(error, "the parts of the mesh");
    for (int64_t i = 0; !status && i < p->n_nodes; i++)
        at_root[p->first_point + i] = s->here[i];
    if (!status && pl_bring(p->points, MPI_INT, 1, at_root, at))
        status = pl_fail_petsc(error, PETSC_ERR_LIB);
    for (int64_t i = 0; !status && i < s->n_nodes; i++)
        if (s->node[i] >= 0 && p->owner[s->node[i]] != p->rank)
            ghost[n++] = (pl_ghost){.node = (int32_t)i,
                                    .owner = p->owner[s->node[i]],
                                    .of_node = at[p->first_point + s->node[i]]};
    if (!status)
        status = pl_exchange_create(&share->exchange, comm, ghost, n, s->n_nodes, error);
    free(at_root);
    free(at);
    free(ghost);
    return status;
}

/** Fill in elements, numbers and roles; an element is counted where its first node by number is
 *  moved. 0, or -1 without memory. */
static int number_part(pl_share *share, const pl_piece *p, const selection *s) {
    const int corners = p->dim + 1;
    const int64_t *goal_begin = share->exchange.goal_begin;
    share->elements = pl_new_array(s->n_elements * corners, sizeof *share->elements);
    share->element_number = pl_new_array(s->n_elements, sizeof *share->element_number);
    share->node_number = pl_new_array(s->n_nodes, sizeof *share->node_number);
    share->role = pl_new_array(s->n_nodes, 1);
    share->is_counted = pl_new_array(s->n_elements, 1);
    if (!share->elements || !share->element_number || !share->node_number || !share->role ||
        !share->is_counted)
        return -1;
    for (int64_t i = 0; i < s->n_nodes; i++) {
        const int is_ghost = s->node[i] >= 0 && p->owner[s->node[i]] != p->rank;
        share->node_number[i] = s->number[i];
        share->role[i] = (uint8_t)(is_ghost                            ? PLANISH_ROLE_GHOST
                                   : goal_begin[i + 1] > goal_begin[i] ? PLANISH_ROLE_SHARED
                                                                       : PLANISH_ROLE_OWN);
    }
    for (int64_t i = 0; i < s->n_elements; i++) {
        int32_t *node = share->elements + i * corners, first = INT32_MAX;
        for (int j = 0; j < corners; j++) {
            node[j] = s->here[p->corner[s->element[i] * corners + j]];
            first = node[j] < first ? node[j] : first;
        }
        share->element_number[i] = p->element[s->element[i]];
        share->is_counted[i] = share->role[first] != PLANISH_ROLE_GHOST;
    }
    return 0;
}

/** Values of nodes and elements; 0, or -1 without memory. */
static int fill_share(pl_share *share, const planish_mesh *whole, const pl_piece *p,
                      const selection *s) {
    static const planish_mesh nothing = {.dim = 0};
    const planish_mesh *w = whole ? whole : &nothing;
    const size_t row = (size_t)p->dim * sizeof(double);
    share->coordinates =
        take_values(s->n_nodes, s->node, s->number, p->coordinates, w->coordinates, row);
    if (p->constraint)
        share->constraint =
            take_values(s->n_nodes, s->node, s->number, p->constraint, w->constraint, 1);
    if (p->direction)
        share->direction =
            take_values(s->n_nodes, s->node, s->number, p->direction, w->direction, row);
    if (p->min_volume)
        share->min_volume =
            take_values(s->n_elements, s->element, NULL, p->min_volume, NULL, sizeof(double));
    if (p->region)
        share->region =
            take_values(s->n_elements, s->element, NULL, p->region, NULL, sizeof *share->region);
    return share->coordinates && (!p->constraint || share->constraint) &&
                   (!p->direction || share->direction) && (!p->min_volume || share->min_volume) &&
                   (!p->region || share->region)
               ? 0
               : -1;
}

/* ---- all of it ------------------------------------------------------------------------------ */

/** One process has the whole mesh as its part. */
static int take_all(pl_share *share, MPI_Comm comm, const planish_mesh *whole,
                    planish_error *error) {
    const int64_t n = whole->n_nodes, m = whole->n_elements;
    const int dim = whole->dim;
#define COPY(to, from, count)                                                                      \
    if (from) {                                                                                    \
        (to) = pl_new_array((count), sizeof *(to));                                                \
        if (!(to))                                                                                 \
            return pl_fail_memory(error, "the parts of the mesh");                                 \
        memcpy((to), (from), (size_t)(count) * sizeof *(to));                                      \
    }
    COPY(share->coordinates, whole->coordinates, n * dim)
    COPY(share->elements, whole->elements, m * (dim + 1))
    COPY(share->constraint, whole->constraint, n)
    COPY(share->direction, whole->direction, n * dim)
    COPY(share->min_volume, whole->min_volume, m)
#undef COPY
    share->role = pl_new_array(n, 1); /* PLANISH_ROLE_OWN */
    share->is_counted = pl_new_array(m, 1);
    share->node_number = pl_new_array(n, sizeof *share->node_number);
    share->element_number = pl_new_array(m, sizeof *share->element_number);
    if (!share->role || !share->is_counted || !share->node_number || !share->element_number)
        return pl_fail_memory(error, "the parts of the mesh");
    memset(share->is_counted, 1, (size_t)m);
    for (int64_t i = 0; i < n; i++)
        share->node_number[i] = i;
    for (int64_t i = 0; i < m; i++)
        share->element_number[i] = i;
    share->mesh.n_nodes = n;
    share->mesh.n_elements = m;
    return pl_exchange_create(&share->exchange, comm, NULL, 0, n, error);
}

/** Take the part of this process from its piece. */
static int take_piece(pl_share *share, MPI_Comm comm, const planish_mesh *whole, pl_piece *p,
                      planish_error *error) {
    selection s = {.n_nodes = 0};
    int64_t n_unused;
    numbered *nodes = sort_numbers(p->node, p->n_nodes);
    int32_t *unused = find_unused(whole, &n_unused);
    int status = PLANISH_OK;
    if (!nodes || !unused || select_elements(p, nodes, &s) ||
        select_nodes(p, nodes, unused, n_unused, &s) || fill_share(share, whole, p, &s))
        status = pl_fail_memory(error, "the parts of the mesh");
    if (!status)
        status = make_exchange(share, comm, p, &s, error);
    if (!status && number_part(share, p, &s))
        status = pl_fail_memory(error, "the parts of the mesh");
    free(nodes);
    free(unused);
    share->mesh.n_nodes = s.n_nodes;
    share->mesh.n_elements = s.n_elements;
    free(s.node);
    free(s.element);
    free(s.number);
    free(s.here);
    return status;
}

/** Collect the numbers [n] of those whose value in out is another than without. */
static int collection_create(pl_collection *c, MPI_Comm comm, const int64_t *number,
                             const uint8_t *out, int without, int64_t n, planish_error *error) {
    int32_t *mine = pl_new_array(n, sizeof *mine);
    int64_t n_mine = 0;
    for (int64_t i = 0; mine && i < n; i++)
        if (out[i] != without)
            mine[n_mine++] = (int32_t)number[i];
    int code = mine ? pl_gathering_create(&c->gathering, comm, n_mine, error)
                    : pl_fail_memory(error, "the parts of the mesh");
    if (!code && !(c->number = pl_new_array(c->gathering.n_all, sizeof *c->number)))
        code = pl_fail_memory(error, "the parts of the mesh");
    if (!code)
        pl_gather(&c->gathering, mine, sizeof *mine, c->number);
    free(mine);
    return code;
}

/** The part as planish wants it. */
static void finish(pl_share *share, int dim) {
    share->part = (planish_part){.node_number = share->node_number,
                                 .node_role = share->role,
                                 .is_counted = share->is_counted};
    pl_exchange_serve(&share->exchange, &share->part);
    share->mesh.dim = dim;
    share->mesh.coordinates = share->coordinates;
    share->mesh.elements = share->elements;
    share->mesh.constraint = share->constraint;
    share->mesh.direction = share->direction;
    share->mesh.min_volume = share->min_volume;
    share->mesh.part = &share->part;
}

int pl_share_create(pl_share *share, MPI_Comm comm, const planish_mesh *whole,
                    planish_error *error) {
    int n_ranks;
    pl_outline o = {0};
    *share = (pl_share){.mesh = {.dim = 0}};
    MPI_Comm_size(comm, &n_ranks);
    if (whole)
        o = (pl_outline){.n_nodes = whole->n_nodes,
                         .n_elements = whole->n_elements,
                         .dim = whole->dim,
                         .has_constraint = whole->constraint != NULL,
                         .has_direction = whole->direction != NULL,
                         .has_min_volume = whole->min_volume != NULL};
    MPI_Bcast(&o, sizeof o, MPI_BYTE, 0, comm);
    if (n_ranks > 1 && o.n_nodes + o.n_elements * (o.dim + 1) > PETSC_MAX_INT)
        return pl_fail(error, PLANISH_ERROR_PARTS,
                       "this mesh needs a PETSc with integers of 64 bits; this PETSc has 32 bits");
    int status;
    if (n_ranks == 1) {
        status = take_all(share, comm, whole, error);
    } else {
        pl_piece p = {.dim = 0};
        const PetscErrorCode code = pl_piece_cut(comm, &o, whole, &p);
        status = code ? pl_fail_petsc(error, code) : take_piece(share, comm, whole, &p, error);
        pl_piece_destroy(&p);
    }
    if (status)
        return status;
    finish(share, o.dim);
    /* How values are collected in the first process. */
    status = collection_create(&share->own_nodes, comm, share->node_number, share->role,
                               PLANISH_ROLE_GHOST, share->mesh.n_nodes, error);
    return status ? status
                  : collection_create(&share->counted_elements, comm, share->element_number,
                                      share->is_counted, 0, share->mesh.n_elements, error);
}

int pl_share_take(pl_share *share, MPI_Comm comm, pl_piece *piece, planish_error *error) {
    *share = (pl_share){.mesh = {.dim = 0}};
    const int status = take_piece(share, comm, NULL, piece, error);
    finish(share, piece->dim);
    return status;
}

void pl_share_destroy(pl_share *share) {
    pl_exchange_destroy(&share->exchange);
    pl_gathering_destroy(&share->own_nodes.gathering);
    pl_gathering_destroy(&share->counted_elements.gathering);
    free(share->own_nodes.number);
    free(share->counted_elements.number);
    free(share->coordinates);
    free(share->direction);
    free(share->min_volume);
    free(share->elements);
    free(share->region);
    free(share->constraint);
    free(share->role);
    free(share->is_counted);
    free(share->node_number);
    free(share->element_number);
    *share = (pl_share){.mesh = {.dim = 0}};
}

static void add_number(planish_error *error, const char *what, int64_t number) {
    const size_t length = strlen(error->text);
    snprintf(error->text + length, sizeof error->text - length,
             " (%s %" PRId64 " of the whole mesh)", what, number);
}

int pl_share_explain(const pl_share *share, int code, planish_error *error) {
    if (code && error->element >= 0 && error->element < share->mesh.n_elements) {
        error->element = share->element_number[error->element];
        add_number(error, "element", error->element);
    }
    if (code && error->node >= 0 && error->node < share->mesh.n_nodes) {
        error->node = share->node_number[error->node];
        add_number(error, "node", error->node);
    }
    return code;
}

void pl_collect(const pl_collection *c, const void *values, int size, void *room, void *whole) {
    char *all = room, *to = whole;
    pl_gather(&c->gathering, values, size, all);
    for (int64_t i = 0; i < c->gathering.n_all; i++)
        memcpy(to + (int64_t)c->number[i] * size, all + i * size, (size_t)size);
}
