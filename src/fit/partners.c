/* partners: which piece of the other shape is for which of the mesh's surface.
 *
 * Two sheets of a mesh that are nearest to the same one would both go there. If they would cover it more than once, it
 * is not known which is right, and both are held. */
#include "fit/partners.h"

#include "base/memory.h"
#include "base/status.h"
#include "fit/pieces.h"

#include <stdlib.h>
#include <string.h>

/* The partner of a piece has more than this part of its area. */
#define MOST 0.5
/* Pieces that cover their partner more often than this do so twice in places. */
#define COVER 1.25

/** A facet of the mesh's surface at its places. */
typedef struct covering {
    int32_t own, other, facet; /* pieces; other -1: it is on none, or on several */
    double area;
} covering;

/** Return the piece of a node's place. */
static int32_t piece_at(const planish_fit *fit, int32_t node) {
    const planish_shape *onto = fit->onto;
    const int32_t at = fit->place[node].at, *piece = fit->pieces.of;
    if (fit->kind[node] == PL_ON_PATCH)
        return piece[at];
    if (fit->kind[node] == PL_ON_CURVE) {
        const int32_t *facet = onto->edge_facet[at];
        return piece[facet[0]] >= 0 || facet[1] < 0 ? piece[facet[0]] : piece[facet[1]];
    }
    for (uint32_t i = onto->offset[at]; i < onto->offset[at + 1]; i++)
        if (piece[onto->facet_of[i]] >= 0)
            return piece[onto->facet_of[i]];
    return -1;
}

/** Return the piece that all nodes of a facet have places on; -1: there is none. */
static int32_t piece_under(const planish_fit *fit, const int32_t node[3]) {
    int32_t piece = -1;
    for (int k = 0; k < 3; k++) {
        const int32_t here = fit->state[node[k]] == PL_FIT_PLACED ? piece_at(fit, node[k]) : -1;
        if (here < 0 || (k > 0 && here != piece))
            return -1;
        piece = here;
    }
    return piece;
}

static double area_at_goals(const planish_fit *fit, const int32_t node[3]) {
    double a[3], b[3], across[3];
    for (int d = 0; d < 3; d++) {
        const double from = fit->goal[node[0]][d] * fit->onto->scale;
        a[d] = fit->goal[node[1]][d] * fit->onto->scale - from;
        b[d] = fit->goal[node[2]][d] * fit->onto->scale - from;
    }
    pl_cross(a, b, across);
    return pl_length(across) / 2;
}

static int compare_coverings(const void *a, const void *b) {
    const covering *s = a, *t = b;
    if (s->own != t->own)
        return (s->own > t->own) - (s->own < t->own);
    if (s->other != t->other)
        return (s->other > t->other) - (s->other < t->other);
    return (s->facet > t->facet) - (s->facet < t->facet);
}

/** List what the facets cover, by their pieces. Returns how many there are. */
static int64_t list_coverings(const planish_fit *fit, covering *list) {
    const planish_shape *own = fit->own;
    int64_t n = 0;
    for (int32_t f = 0; f < own->n_facets; f++) {
        const int32_t other = fit->own_pieces.of[f] >= 0 ? piece_under(fit, own->facet[f]) : -1;
        if (other >= 0)
            list[n++] =
                (covering){fit->own_pieces.of[f], other, f, area_at_goals(fit, own->facet[f])};
    }
    qsort(list, (size_t)n, sizeof *list, compare_coverings);
    return n;
}

/** Find the partner of each piece from what its facets cover. */
static void choose_partners(planish_fit *fit, const covering *list, int64_t n) {
    const pl_fit_pieces *own = &fit->own_pieces;
    for (int32_t i = 0; i < own->n; i++)
        fit->partner[i] = -1;
    memset(fit->is_taken, 0, (size_t)fit->pieces.n);
    memset(fit->covered, 0, (size_t)fit->pieces.n * sizeof *fit->covered);
    for (int64_t i = 0, next; i < n; i = next) {
        double all = 0, most = 0;
        int32_t partner = -1;
        for (next = i; next < n && list[next].own == list[i].own;) {
            const int64_t begin = next;
            double area = 0;
            for (;
                 next < n && list[next].own == list[i].own && list[next].other == list[begin].other;
                 next++)
                area += list[next].area;
            all += area;
            partner = area > most ? list[begin].other : partner;
            most = fmax(most, area);
        }
        if (!(most > MOST * all))
            continue;
        fit->partner[list[i].own] = partner;
        fit->covered[partner] += most;
        fit->is_taken[partner] = fit->is_taken[partner] ? 2 : 1;
    }
}

int pl_fit_begin_partners(planish_fit *fit, planish_error *error) {
    const planish_shape *own = fit->own, *onto = fit->onto;
    const pl_fit_pieces *pieces = &fit->pieces;
    const int status = pl_fit_find_pieces(own, &fit->own_pieces, error);
    if (status)
        return status;
    fit->piece_of = pl_alloc(fit->n_nodes, sizeof *fit->piece_of);
    fit->partner = pl_alloc(fit->own_pieces.n, sizeof *fit->partner);
    fit->side = pl_alloc(pieces->n, sizeof *fit->side);
    fit->is_taken = pl_alloc_zero(pieces->n, sizeof *fit->is_taken);
    fit->covered = pl_alloc(pieces->n, sizeof *fit->covered);
    if (!fit->piece_of || !fit->partner || !fit->side || !fit->is_taken || !fit->covered)
        return pl_fail_memory(error, "the pieces of a fit");
    for (int32_t i = 0; i < fit->own_pieces.n; i++)
        fit->partner[i] = -1;
    for (int32_t i = 0; i < pieces->n; i++)
        fit->side[i] = (int8_t)(pieces->outward[i] * fit->turn[onto->patch[pieces->first[i]]]);
    for (int64_t i = 0; i < fit->n_nodes; i++)
        fit->piece_of[i] = -1;
    for (int64_t f = own->n_facets - 1; f >= 0; f--)
        for (int k = 0; k < 3 && fit->own_pieces.of[f] >= 0; k++)
            fit->piece_of[own->facet[f][k]] = fit->own_pieces.of[f];
    return PLANISH_OK;
}

int pl_fit_find_partners(planish_fit *fit, planish_error *error) {
    covering *list = pl_alloc(fit->own->n_facets, sizeof *list);
    if (!list)
        return pl_fail_memory(error, "the pieces of a fit");
    choose_partners(fit, list, list_coverings(fit, list));
    pl_free(list);
    return PLANISH_OK;
}

int32_t pl_fit_piece_of(const planish_fit *fit, int32_t node) {
    return fit->piece_of[node] + 1;
}

/** Whether a piece lies in another one, or around it, or both in a third. */
static int are_nested(const pl_fit_pieces *pieces, int32_t a, int32_t b) {
    return pieces->is_closed[a] && pieces->is_closed[b] && pieces->nest[a] >= 0 &&
           pieces->nest[a] == pieces->nest[b];
}

int pl_fit_may_use(const planish_fit *fit, int32_t own, int32_t piece) {
    const pl_fit_pieces *ours = &fit->own_pieces, *theirs = &fit->pieces;
    if (own == 0 || piece < 0)
        return own == 0;
    if (ours->is_closed[own - 1] && theirs->is_closed[piece] &&
        ours->outward[own - 1] != fit->side[piece])
        return 0;
    const int32_t partner = fit->partner[own - 1];
    return partner < 0 || partner == piece ||
           (!fit->is_taken[piece] && !are_nested(theirs, partner, piece));
}

int pl_fit_has_strays(const planish_fit *fit) {
    for (int32_t i = 0; i < fit->n_nodes; i++)
        if (fit->state[i] == PL_FIT_PLACED &&
            !pl_fit_may_use(fit, pl_fit_piece_of(fit, i), piece_at(fit, i)))
            return 1;
    return 0;
}

void pl_fit_hold_doubled(planish_fit *fit) {
    const pl_fit_pieces *pieces = &fit->pieces;
    uint8_t *is_used = fit->is_taken;
    for (int32_t i = 0; i < fit->n_nodes; i++) {
        const int32_t partner = fit->piece_of[i] >= 0 ? fit->partner[fit->piece_of[i]] : -1;
        if (fit->state[i] == PL_FIT_PLACED && partner >= 0 && fit->is_taken[partner] == 2 &&
            fit->covered[partner] > COVER * pieces->area[partner])
            fit->state[i] = PL_FIT_UNCLEAR;
    }
    for (int32_t i = 0; i < fit->n_nodes; i++) {
        const int32_t piece = fit->state[i] == PL_FIT_PLACED ? piece_at(fit, i) : -1;
        if (piece >= 0)
            is_used[piece] = 1;
    }
    fit->n_unused = 0;
    for (int32_t i = 0; i < pieces->n; i++)
        fit->n_unused += !is_used[i];
}
