/* given_up: of a mesh in parts, the elements that other processes have given up.
 *
 * What a star proves, the process of its node finds. It tells the others, of each such node, one
 * element after another: by the numbers of the element's other nodes, as elements have no numbers
 * of their own.
 */
#include "improve/untangle/given_up.h"

#include "base/memory.h"
#include "base/parts.h"
#include "base/status.h"

#include <stdlib.h>
#include <string.h>

/** An element, by its nodes here, ascending. */
typedef struct key {
    int32_t node[4];
} key;

/** An element that is given up, and how many of its node's were so before. */
typedef struct given_up {
    int32_t node, round;
    int64_t element;
} given_up;

/** Messages about elements that are given up. Arrays are owned. */
typedef struct messages {
    const planish_plan *plan;
    const planish_part *part;
    given_up *mine; /* [n_mine] at SHARED nodes */
    int64_t n_mine;
    int32_t *node;  /* [n_mine] of a message, */
    int64_t *value; /* [n_mine][dim] and the other nodes' numbers */
    key *theirs;    /* [n_theirs] as told */
    int64_t n_theirs, capacity;
    int failed;
} messages;

/** List the elements given up by stars of SHARED nodes: the facets of a star are in the order of
 * its elements. Returns how many at most a node has; 0 without memory. */
static int32_t list_mine(messages *w, const uint8_t *of_facet) {
    const planish_plan *plan = w->plan;
    const pl_stars *stars = &plan->interior.stars;
    int64_t most = 0;
    int32_t most_rounds = 0;
    for (int64_t i = 0; i < stars->link_offset[stars->n_stars]; i++)
        most += of_facet[i] == PL_PROOF_GIVEN_UP;
    w->mine = pl_alloc(most, sizeof *w->mine);
    w->node = pl_alloc(most, sizeof *w->node);
    w->value = pl_alloc(most * plan->dim, sizeof *w->value);
    int32_t *star_of = pl_alloc(plan->work.n_nodes, sizeof *star_of);
    int32_t *seen = pl_alloc_zero(stars->n_stars, sizeof *seen);
    int32_t *rounds = pl_alloc_zero(stars->n_stars, sizeof *rounds);
    w->failed = !star_of || !seen || !rounds || !w->mine || !w->node || !w->value;
    if (!w->failed)
        pl_plan_number_stars(plan, star_of);
    for (int64_t i = 0; !w->failed && i < plan->work.n_elements; i++)
        for (int j = 0; j <= plan->dim; j++) {
            const int32_t node = plan->work.elements[i * (plan->dim + 1) + j];
            const int32_t star = star_of[plan->inner[node]];
            if (star < 0 ||
                of_facet[stars->link_offset[star] + seen[star]++] != PL_PROOF_GIVEN_UP ||
                w->part->node_role[node] != PLANISH_ROLE_SHARED)
                continue;
            w->mine[w->n_mine++] = (given_up){node, rounds[star]++, i};
            most_rounds = rounds[star] > most_rounds ? rounds[star] : most_rounds;
        }
    pl_free(star_of);
    pl_free(seen);
    pl_free(rounds);
    return most_rounds;
}

static int compare_nodes(const void *a, const void *b) {
    const int32_t p = *(const int32_t *)a, q = *(const int32_t *)b;
    return (p > q) - (p < q);
}

static int compare_keys(const void *a, const void *b) {
    return memcmp(a, b, sizeof(key));
}

static int compare_numbers(const void *a, const void *b) {
    const int64_t p = *(const int64_t *)a, q = *(const int64_t *)b;
    return (p > q) - (p < q);
}

/** Note an element of a ghost that has been given up, if it is here. */
static void note_theirs(int32_t ghost, const void *value, void *taker) {
    messages *w = taker;
    const planish_plan *plan = w->plan;
    key k = {.node = {ghost}};
    for (int j = 1; j <= plan->dim; j++) {
        int64_t number;
        memcpy(&number, (const char *)value + (size_t)(j - 1) * sizeof number, sizeof number);
        const int64_t *found = bsearch(&number, w->part->node_number, (size_t)plan->work.n_nodes,
                                       sizeof number, compare_numbers);
        if (!found)
            return; /* nobody here has that element */
        k.node[j] = (int32_t)(found - w->part->node_number);
    }
    qsort(k.node, (size_t)plan->dim + 1, sizeof *k.node, compare_nodes);
    w->failed |= !pl_append(&w->theirs, &w->n_theirs, &w->capacity, &k, sizeof k);
}

int pl_send_given_up(const planish_plan *plan, const uint8_t *of_facet, uint8_t *state,
                     planish_error *error) {
    const int dim = plan->dim;
    messages w = {.plan = plan, .part = pl_part_here()};
    if (!w.part)
        return PLANISH_OK;
    double n_rounds = list_mine(&w, of_facet);
    pl_parts_largest(&n_rounds, 1);
    /* Tell the others of the elements of each round, and hear of theirs. */
    for (int32_t round = 0; round < n_rounds && !w.failed; round++) {
        int64_t n = 0;
        for (int64_t i = 0; i < w.n_mine; i++) {
            if (w.mine[i].round != round)
                continue;
            const int32_t *corner = plan->work.elements + w.mine[i].element * (dim + 1);
            w.node[n] = w.mine[i].node;
            for (int j = 0, k = 0; j <= dim; j++)
                if (corner[j] != w.mine[i].node)
                    w.value[n * dim + k++] = w.part->node_number[corner[j]];
            n++;
        }
        pl_parts_send(w.node, n, w.value, dim * (int64_t)sizeof *w.value);
        pl_parts_receive(note_theirs, &w);
    }
    /* Give up here what others have given up. */
    if (w.n_theirs > 0)
        qsort(w.theirs, (size_t)w.n_theirs, sizeof *w.theirs, compare_keys);
    for (int64_t i = 0; !w.failed && w.n_theirs > 0 && i < plan->work.n_elements; i++) {
        key k = {.node = {0}};
        if (state[i] != PL_TANGLED)
            continue;
        memcpy(k.node, plan->work.elements + i * (dim + 1), (size_t)(dim + 1) * sizeof *k.node);
        qsort(k.node, (size_t)dim + 1, sizeof *k.node, compare_nodes);
        if (bsearch(&k, w.theirs, (size_t)w.n_theirs, sizeof k, compare_keys))
            state[i] = PL_GIVEN_UP;
    }
    pl_free(w.mine);
    pl_free(w.node);
    pl_free(w.value);
    pl_free(w.theirs);
    return w.failed ? pl_fail_memory(error, "the elements that cannot be helped") : PLANISH_OK;
}
