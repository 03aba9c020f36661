/* slides: which nodes of a mesh that no process has all of can slide on its surface.
 *
 * A piece of the surface is plane, and an edge of it straight, as a whole: the first process looks
 * at all of the surface. It gets the nodes there and the elements that have one of them: these have
 * all facets of the surface, and every other facet has a node that is known to be inside.
 */
#include "mpi/slides.h"

#include "topology/facets.h"

#include "base/status.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/** An element at the surface, and a node of one, by numbers of the whole mesh. */
typedef struct near_element {
    int32_t number, region, node[4];
} near_element;

typedef struct near_node {
    int32_t number, is_surface;
    double x[3];
} near_node;

/** How a node can move. */
typedef struct answer {
    double direction[3];
    int64_t constraint;
} answer;

/** Nodes and elements near the surface, of one process or of all; arrays are owned. */
typedef struct near {
    int64_t n_nodes, n_elements;
    near_node *node;
    near_element *element;
    answer *answer; /* [n_nodes] */
} near;

static int near_create(near *s, int64_t n_nodes, int64_t n_elements, planish_error *error) {
    *s = (near){.n_nodes = n_nodes,
                .n_elements = n_elements,
                .node = pl_new_array(n_nodes, sizeof *s->node),
                .element = pl_new_array(n_elements, sizeof *s->element),
                .answer = pl_new_array(n_nodes, sizeof *s->answer)};
    return s->node && s->element && s->answer ? PLANISH_OK : pl_fail_memory(error, "the surface");
}

static void near_destroy(near *s) {
    free(s->node);
    free(s->element);
    free(s->answer);
    *s = (near){0};
}

/* ---- nodes of the surface -------------------------------------------------------------------- */

/** The work on the facets of this process's part. */
typedef struct marking {
    const pl_share *share;
    uint8_t *is_surface; /* [n_nodes] */
} marking;

static int is_own(const pl_share *share, int32_t node) {
    return node >= 0 && share->role[node] != PLANISH_ROLE_GHOST;
}

/** Mark the nodes of surface facets. A facet whose nodes all belong to others may lack an element
 * here: they see it. */
static void mark_facets(void *context, int32_t node, const pl_facet *facets, int32_t n_facets,
                        int thread) {
    const marking *m = context;
    (void)thread;
    const int32_t *region = m->share->region;
    for (const pl_facet *f = facets; f < facets + n_facets; f++) {
        const int32_t nodes[3] = {node, f->node[0], f->node[1]};
        if (f->count == 2 && (!region || region[f->element[0]] == region[f->element[1]]))
            continue;
        if (is_own(m->share, nodes[0]) || is_own(m->share, nodes[1]) || is_own(m->share, nodes[2]))
            for (int j = 0; j < 3 && nodes[j] >= 0; j++)
                m->is_surface[nodes[j]] = 1;
    }
}

/** Destination of values of ghosts. */
typedef struct arrival {
    char *values;
    int64_t size;
} arrival;

static void take_value(int32_t ghost, const void *value, void *taker) {
    const arrival *a = taker;
    memcpy(a->values + ghost * a->size, value, (size_t)a->size);
}

/** Values [n_nodes][size] of ghosts become those of their owners. room: for all nodes and values.
 */
static int update(const pl_share *share, void *values, int64_t size, int32_t *node, char *room,
                  planish_error *error) {
    const planish_part *part = &share->part;
    arrival a = {values, size};
    int64_t n = 0;
    for (int64_t i = 0; i < share->mesh.n_nodes; i++)
        if (share->role[i] == PLANISH_ROLE_SHARED) {
            memcpy(room + n * size, a.values + i * size, (size_t)size);
            node[n++] = (int32_t)i;
        }
    if (!part->send(node, n, room, size, part->user) && !part->receive(take_value, &a, part->user))
        return PLANISH_OK;
    return pl_fail(error, PLANISH_ERROR_PROCESS, "another process was not reached");
}

/* ---- what is near it ------------------------------------------------------------------------- */

static int has_marked(const pl_share *share, int64_t element, const uint8_t *is_marked) {
    const int corners = share->mesh.dim + 1;
    int any = 0;
    for (int j = 0; j < corners; j++)
        any |= is_marked[share->elements[element * corners + j]];
    return any;
}

/** List those that this process counts. */
static int list_near(const pl_share *share, const uint8_t *is_surface, const uint8_t *mark, near *s,
                     planish_error *error) {
    const int dim = share->mesh.dim;
    int64_t n = 0, m = 0;
    for (int64_t i = 0; i < share->mesh.n_nodes; i++)
        n += mark[i] && is_own(share, (int32_t)i);
    for (int64_t i = 0; i < share->mesh.n_elements; i++)
        m += share->is_counted[i] && has_marked(share, i, is_surface);
    if (near_create(s, n, m, error))
        return error->code;
    n = m = 0;
    for (int64_t i = 0; i < share->mesh.n_nodes; i++) {
        if (!mark[i] || !is_own(share, (int32_t)i))
            continue;
        near_node *node = &s->node[n++];
        *node = (near_node){(int32_t)share->node_number[i], is_surface[i], {0}};
        memcpy(node->x, share->coordinates + i * dim, (size_t)dim * sizeof *node->x);
    }
    for (int64_t i = 0; i < share->mesh.n_elements; i++) {
        if (!share->is_counted[i] || !has_marked(share, i, is_surface))
            continue;
        near_element *element = &s->element[m++];
        *element = (near_element){
            (int32_t)share->element_number[i], share->region ? share->region[i] : 0, {0}};
        for (int j = 0; j <= dim; j++)
            element->node[j] = (int32_t)share->node_number[share->elements[i * (dim + 1) + j]];
    }
    return PLANISH_OK;
}

/* ---- together in the first process ----------------------------------------------------------- */

/** A node's number, and where it is among those that were gathered. */
typedef struct place {
    int32_t number, at;
} place;

/** By the number that a near_element or place begins with. */
static int compare_numbers(const void *a, const void *b) {
    const int32_t *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

/** A mesh of what is near the surface, in the order of the whole mesh; owned. */
typedef struct shell {
    planish_mesh mesh;
    place *place; /* [n_nodes] */
    double *x, *direction;
    int32_t *elements, *region;
    uint8_t *is_inside, *constraint;
} shell;

/** 0, or -1 without memory. */
static int shell_create(const near *all, int dim, shell *s) {
    const int64_t n = all->n_nodes, m = all->n_elements;
    *s = (shell){.place = pl_new_array(n, sizeof *s->place),
                 .x = pl_new_array(n * dim, sizeof *s->x),
                 .direction = pl_new_array(n * dim, sizeof *s->direction),
                 .elements = pl_new_array(m * (dim + 1), sizeof *s->elements),
                 .region = pl_new_array(m, sizeof *s->region),
                 .is_inside = pl_new_array(n, 1),
                 .constraint = pl_new_array(n, 1)};
    if (!s->place || !s->x || !s->direction || !s->elements || !s->region || !s->is_inside ||
        !s->constraint)
        return -1;
    s->mesh = (planish_mesh){
        .dim = dim, .n_nodes = n, .n_elements = m, .coordinates = s->x, .elements = s->elements};
    for (int64_t i = 0; i < n; i++)
        s->place[i] = (place){all->node[i].number, (int32_t)i};
    qsort(s->place, (size_t)n, sizeof *s->place, compare_numbers);
    qsort(all->element, (size_t)m, sizeof *all->element, compare_numbers);
    for (int64_t i = 0; i < n; i++) {
        const near_node *node = &all->node[s->place[i].at];
        s->is_inside[i] = !node->is_surface;
        memcpy(s->x + i * dim, node->x, (size_t)dim * sizeof *s->x);
    }
    for (int64_t i = 0; i < m; i++) {
        s->region[i] = all->element[i].region;
        for (int j = 0; j <= dim; j++) {
            const place key = {.number = all->element[i].node[j]};
            const place *found =
                bsearch(&key, s->place, (size_t)n, sizeof *s->place, compare_numbers);
            s->elements[i * (dim + 1) + j] = (int32_t)(found - s->place);
        }
    }
    return 0;
}

/** The first process's part of it: the answers. */
static int look_at_all(const pl_crew *crew, near *all, double tolerance, planish_error *error) {
    const int dim = crew->share.mesh.dim;
    shell s;
    int code = shell_create(all, dim, &s) ? pl_fail_memory(error, "the surface") : PLANISH_OK;
    const planish_surface surface = {
        .region = s.region, .is_inside = s.is_inside, .tolerance = tolerance};
    if (!code && all->n_elements > 0)
        code = planish_find_slides(&s.mesh, &surface, crew->threads, s.constraint, s.direction,
                                   NULL, error);
    for (int64_t i = 0; !code && i < all->n_nodes; i++) {
        answer *to = &all->answer[s.place[i].at];
        to->constraint = s.constraint[i];
        memcpy(to->direction, s.direction + i * dim, (size_t)dim * sizeof *to->direction);
    }
    free(s.place);
    free(s.x);
    free(s.direction);
    free(s.elements);
    free(s.region);
    free(s.is_inside);
    free(s.constraint);
    return code;
}

/** Send what is near to the first process, and bring its answers. */
static int ask(const pl_crew *crew, near *mine, double tolerance, planish_error *error) {
    pl_gathering nodes = {0}, elements = {0};
    near all = {0};
    int code =
        pl_crew_agree(crew, pl_gathering_create(&nodes, crew->comm, mine->n_nodes, error), error);
    if (!code)
        code = pl_crew_agree(
            crew, pl_gathering_create(&elements, crew->comm, mine->n_elements, error), error);
    if (code == PLANISH_ERROR_PARTS)
        pl_fail(error, PLANISH_ERROR_PARTS,
                "the surface has too many nodes for one process; leave out --slide");
    if (!code)
        code = pl_crew_agree(crew, near_create(&all, nodes.n_all, elements.n_all, error), error);
    if (!code) {
        pl_gather(&nodes, mine->node, sizeof *mine->node, all.node);
        pl_gather(&elements, mine->element, sizeof *mine->element, all.element);
        code = pl_crew_agree(
            crew, crew->rank == 0 ? look_at_all(crew, &all, tolerance, error) : PLANISH_OK, error);
    }
    if (!code)
        pl_scatter(&nodes, all.answer, sizeof *mine->answer, mine->answer);
    near_destroy(&all);
    pl_gathering_destroy(&nodes);
    pl_gathering_destroy(&elements);
    return code;
}

/* ---- all of it ------------------------------------------------------------------------------- */

/** Working space for each node of the part; owned. */
typedef struct room {
    uint8_t *is_surface, *mark;
    int32_t *shared;
    char *values;
    answer *answer;
} room;

/** The answers for own nodes, and for ghosts. */
static int take_answers(pl_share *share, const near *mine, room *r, planish_error *error) {
    const int dim = share->mesh.dim;
    for (int64_t i = 0, k = 0; i < share->mesh.n_nodes; i++)
        if (r->mark[i] && is_own(share, (int32_t)i))
            r->answer[i] = mine->answer[k++];
    const int code = update(share, r->answer, sizeof *r->answer, r->shared, r->values, error);
    for (int64_t i = 0; i < share->mesh.n_nodes; i++) {
        share->constraint[i] = (uint8_t)r->answer[i].constraint;
        memcpy(share->direction + i * dim, r->answer[i].direction,
               (size_t)dim * sizeof *share->direction);
    }
    return code;
}

static int slide(pl_crew *crew, double tolerance, room *r, planish_error *error) {
    pl_share *share = &crew->share;
    marking m = {share, r->is_surface};
    near mine = {0};
    pl_incidence incidence;
    const int corners = share->mesh.dim + 1;
    int code = pl_incidence_create(&share->mesh, NULL, 1, &incidence, error);
    if (!code) {
        code = pl_facets_match(&share->mesh, &incidence, NULL, 1, mark_facets, &m, error);
        pl_incidence_destroy(&incidence);
    }
    code = pl_crew_agree(crew, code, error);
    if (!code)
        code = pl_crew_agree(crew, update(share, r->is_surface, 1, r->shared, r->values, error),
                             error);
    if (!code) {
        memcpy(r->mark, r->is_surface, (size_t)share->mesh.n_nodes);
        for (int64_t i = 0; i < share->mesh.n_elements; i++)
            for (int j = 0; has_marked(share, i, r->is_surface) && j < corners; j++)
                r->mark[share->elements[i * corners + j]] = 1;
        code = pl_crew_agree(crew, list_near(share, r->is_surface, r->mark, &mine, error), error);
    }
    if (!code)
        code = ask(crew, &mine, tolerance, error);
    if (!code)
        code = pl_crew_agree(crew, take_answers(share, &mine, r, error), error);
    near_destroy(&mine);
    return code;
}

int pl_surface_slide(pl_crew *crew, double tolerance, planish_error *error) {
    pl_share *share = &crew->share;
    const int64_t n = share->mesh.n_nodes;
    free(share->constraint);
    free(share->direction);
    share->constraint = pl_new_array(n, 1);
    share->direction = pl_new_array(n * share->mesh.dim, sizeof *share->direction);
    share->mesh.constraint = share->constraint;
    share->mesh.direction = share->direction;
    room r = {.is_surface = pl_new_array(n, 1),
              .mark = pl_new_array(n, 1),
              .shared = pl_new_array(n, sizeof *r.shared),
              .values = pl_new_array(n, sizeof *r.answer),
              .answer = pl_new_array(n, sizeof *r.answer)};
    const int has_room = r.is_surface && r.mark && r.shared && r.values && r.answer &&
                         share->constraint && share->direction;
    int code =
        pl_crew_agree(crew, has_room ? PLANISH_OK : pl_fail_memory(error, "the surface"), error);
    if (!code)
        code = slide(crew, tolerance, &r, error);
    free(r.is_surface);
    free(r.mark);
    free(r.shared);
    free(r.values);
    free(r.answer);
    return code;
}
