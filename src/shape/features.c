/* features: the edges where a surface is not smooth, and the patches, curves and corners between
 * them. docs/surfaces.md has the rules. */
#include "shape/features.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"
#include "shape/creases.h"

#include <stdlib.h>
#include <string.h>

enum { CHUNK = 512 }; /* nodes or facets that one thread takes at a time */

/* Normals of a smooth surface go on across features that turn by less: 25 degrees. */
static const double COS_SEAM = 0.90630778703664996324;
/* Curves turn by less at a node: 40 degrees, but for rounding. */
static const double COS_TURN = 0.76604444311897803520 - 0x1p-30;
/* All facets at a node of a patch are within 52 degrees of its normal. */
static const double COS_FAN = 0.61566147532565827967;
/* A triangle whose height is below so many last digits of its coordinates has no area. */
static const double FLAT = 0x1p-50;

/* ---- facets at edges ------------------------------------------------------------------------ */

/** End of an edge that begins at the node under work: edge k of a facet. */
typedef struct spoke {
    int32_t end, facet;
    int k;
} spoke;

static int compare_spokes(const void *a, const void *b) {
    const spoke *s = a, *t = b;
    return s->end != t->end ? (s->end > t->end) - (s->end < t->end)
                            : (s->facet > t->facet) - (s->facet < t->facet);
}

/** Sort spokes by ends, then facets: few, as a rule. */
static void sort_spokes(spoke *spokes, int64_t n) {
    enum { FEW = 32 };
    if (n > FEW) {
        qsort(spokes, (size_t)n, sizeof *spokes, compare_spokes);
        return;
    }
    for (int64_t i = 1; i < n; i++) {
        const spoke s = spokes[i];
        int64_t at = i;
        for (; at > 0 && compare_spokes(&spokes[at - 1], &s) > 0; at--)
            spokes[at] = spokes[at - 1];
        spokes[at] = s;
    }
}

/** List the edges at node that are of a kind (0: all), sorted. Returns how many; one for each facet. */
static int64_t list_spokes(const pl_features *w, int32_t node, int kind, spoke *spokes) {
    const planish_shape *s = w->shape;
    int64_t n = 0;
    for (int64_t i = s->offset[node]; i < s->offset[node + 1]; i++) {
        const int32_t f = s->facet_of[i];
        const int k = pl_corner_at(s, f, node), before = (k + 2) % 3;
        if (!kind || w->kind[f][k] & kind)
            spokes[n++] = (spoke){s->facet[f][(k + 1) % 3], f, k};
        if (!kind || w->kind[f][before] & kind)
            spokes[n++] = (spoke){s->facet[f][before], f, before};
    }
    sort_spokes(spokes, n);
    return n;
}

/** Return where the spokes to the end of the i-th one end. */
static int64_t same_end(const spoke *spokes, int64_t n, int64_t i) {
    int64_t next = i + 1;
    while (next < n && spokes[next].end == spokes[i].end)
        next++;
    return next;
}

/** Spokes of each thread's node. */
typedef struct spokes_pass {
    pl_features *w;
    spoke *spokes; /* [threads][most] */
    int64_t most;
} spokes_pass;

static int begin_pass(pl_features *w, spokes_pass *pass, planish_error *error) {
    const planish_shape *s = w->shape;
    *pass = (spokes_pass){.w = w};
    for (int64_t i = 0; i < s->n_nodes; i++)
        if (2 * (s->offset[i + 1] - s->offset[i]) > pass->most)
            pass->most = 2 * (s->offset[i + 1] - s->offset[i]);
    pass->spokes = pl_alloc(w->threads * pass->most, sizeof *pass->spokes);
    return pass->spokes ? PLANISH_OK : pl_fail_memory(error, "the edges of the surface");
}

static double length_between(const planish_shape *s, int32_t a, int32_t b) {
    double v[3];
    pl_from_to(3, s->x[a], s->x[b], v);
    return pl_length(v);
}

/** Whether two facets are the halves of a quadrilateral, or of one facet of second order. */
static int are_halves(const planish_shape *s, int32_t f, int32_t g) {
    return (s->half && s->half[f] == 1 && s->half[g] == 2 && g == f + 1) ||
           (s->whole && s->whole_of[f] == s->whole_of[g]);
}

/** Match the facets at edges of nodes; those at edges to higher nodes are noted. */
static void match_nodes(void *context, int64_t begin, int64_t end, int thread) {
    const spokes_pass *pass = context;
    pl_features *w = pass->w;
    planish_shape *s = w->shape;
    spoke *spokes = pass->spokes + thread * pass->most;
    for (int64_t node = begin; node < end; node++) {
        const int64_t n = list_spokes(w, (int32_t)node, 0, spokes);
        double sum = 0;
        w->n_ends[node] = 0;
        for (int64_t i = 0, next; i < n; i = next) {
            const spoke *a = spokes + i, *b = a + 1;
            next = same_end(spokes, n, i);
            const int is_diagonal = next == i + 2 && are_halves(s, a->facet, b->facet);
            if (!is_diagonal) {
                sum += length_between(s, (int32_t)node, a->end);
                w->n_ends[node]++;
            }
            if (next != i + 2 || a->end < node)
                continue;
            w->beside[a->facet][a->k] = b->facet;
            w->beside[b->facet][b->k] = a->facet;
            if (is_diagonal)
                w->kind[a->facet][a->k] = w->kind[b->facet][b->k] = PL_EDGE_DIAGONAL;
        }
        s->edge_length[node] =
            w->n_ends[node] > 0 ? (float)(sum / w->n_ends[node] * (1 - 0x1p-23)) : 0;
    }
}

int pl_features_match(pl_features *w, planish_error *error) {
    spokes_pass pass;
    const int status = begin_pass(w, &pass, error);
    memset(w->beside, -1, (size_t)w->shape->n_facets * sizeof *w->beside);
    memset(w->kind, 0, (size_t)w->shape->n_facets * sizeof *w->kind);
    if (!status)
        pl_parallel_for(w->threads, w->shape->n_nodes, CHUNK, match_nodes, &pass);
    pl_free(pass.spokes);
    return status;
}

/* ---- the way round -------------------------------------------------------------------------- */

/** Whether three nodes are in a descending order but for where it begins. */
static int is_turned(const int32_t v[3]) {
    return ((v[0] > v[1]) + (v[1] > v[2]) + (v[0] > v[2])) % 2;
}

/** Return 1 if the apex of a facet lies behind it, as its corners are now, -1 if before it. A facet that is
 *  an element is to turn as it is listed. */
static int vote(const pl_features *w, const double *coordinates, int32_t f) {
    const planish_shape *s = w->shape;
    const int32_t apex = w->surface->apex[f], node = apex < 0 ? ~apex : apex;
    if (w->surface->label[f].n_elements == 0)
        return is_turned(s->facet[f]) == apex ? 1 : -1;
    double u[3], v[3], normal[3], to[3];
    pl_from_to(3, s->x[s->facet[f][0]], s->x[s->facet[f][1]], u);
    pl_from_to(3, s->x[s->facet[f][0]], s->x[s->facet[f][2]], v);
    for (int d = 0; d < 3; d++)
        to[d] = coordinates[(int64_t)node * 3 + d] * s->scale - s->x[s->facet[f][0]][d];
    pl_cross(u, v, normal);
    const double side = pl_dot(3, normal, to);
    const int is_behind = (side < 0) - (side > 0);
    return apex < 0 ? -is_behind : is_behind;
}

/** Turn a facet the other way round. */
static void turn(pl_features *w, int32_t f) {
    int32_t *v = w->shape->facet[f], *beside = w->beside[f], t = v[1];
    uint8_t *kind = w->kind[f];
    v[1] = v[2];
    v[2] = t;
    t = beside[0];
    beside[0] = beside[2];
    beside[2] = t;
    const uint8_t b = kind[0];
    kind[0] = kind[2];
    kind[2] = b;
}

/** Turn the facets that edges of two join to the first of list, so that neighbours agree. Returns how many
 *  they are. */
static int64_t orient_component(pl_features *w, int32_t *list, uint8_t *is_done) {
    const planish_shape *s = w->shape;
    int64_t n = 1;
    is_done[list[0]] = 1;
    for (int64_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            const int32_t f = list[i], g = w->beside[f][k];
            if (g < 0)
                continue;
            const int m = pl_edge_beside(w, f, k);
            const int agree = s->facet[f][k] != s->facet[g][m];
            if (!is_done[g]) {
                if (!agree)
                    turn(w, g);
                is_done[g] = 1;
                list[n++] = g;
            } else if (!agree) {
                w->kind[f][k] |= PL_EDGE_CONFLICT;
                w->kind[g][m] |= PL_EDGE_CONFLICT;
            }
        }
    return n;
}

int pl_features_orient(pl_features *w, const double *coordinates, planish_error *error) {
    const int64_t n = w->shape->n_facets;
    int32_t *list = pl_alloc(n, sizeof *list);
    uint8_t *is_done = pl_alloc_zero(n, 1);
    if (list && is_done)
        for (int64_t first = 0; first < n; first++) {
            int64_t n_joined = 0, votes = 0;
            list[0] = (int32_t)first;
            if (!is_done[first])
                n_joined = orient_component(w, list, is_done);
            for (int64_t i = 0; i < n_joined; i++)
                votes += vote(w, coordinates, list[i]);
            for (int64_t i = 0; votes < 0 && i < n_joined; i++)
                turn(w, list[i]);
        }
    const int failed = !list || !is_done;
    pl_free(list);
    pl_free(is_done);
    return failed ? pl_fail_memory(error, "the surface") : PLANISH_OK;
}

/* ---- normals, bends, features --------------------------------------------------------------- */

/** Compute the normals of facets. */
static void compute_normals(void *context, int64_t begin, int64_t end, int thread) {
    const pl_features *w = context;
    const planish_shape *s = w->shape;
    (void)thread;
    for (int64_t f = begin; f < end; f++) {
        double side[3][3], normal[3], largest = 0, longest = 0;
        for (int k = 0; k < 3; k++) {
            const double *x = s->x[s->facet[f][k]];
            pl_from_to(3, x, s->x[s->facet[f][(k + 1) % 3]], side[k]);
            longest = fmax(longest, pl_length(side[k]));
            largest = fmax(largest, fmax(fabs(x[0]), fmax(fabs(x[1]), fabs(x[2]))));
        }
        pl_cross(side[0], side[1], normal);
        if (!(pl_length(normal) > FLAT * largest * longest) || !pl_unit(3, normal, w->normal[f]))
            memset(w->normal[f], 0, sizeof w->normal[f]);
        for (int d = 0; d < 3; d++)
            s->normal[f][d] = (float)w->normal[f][d];
    }
}

static int has_area(const planish_shape *s, int32_t f) {
    return s->normal[f][0] != 0 || s->normal[f][1] != 0 || s->normal[f][2] != 0;
}

/** Decide about edge k of f: what PL_EDGE_.. it is, beside what it is already. */
static int decide_edge(const pl_features *w, int32_t f, int k) {
    const planish_shape *s = w->shape;
    const int32_t g = w->beside[f][k];
    if (g < 0 || w->kind[f][k] & PL_EDGE_CONFLICT || !has_area(s, f) || !has_area(s, g))
        return PL_EDGE_FEATURE | PL_EDGE_APART;
    const pl_label *label = w->surface->label;
    const double cosine = pl_dot(3, w->normal[f], w->normal[g]);
    const int crease = pl_is_crease(w, f, k, cosine);
    if (label[f].n_elements > 2 || label[g].n_elements > 2)
        return PL_EDGE_FEATURE | PL_EDGE_APART;
    const int apart = crease || cosine < COS_SEAM ? PL_EDGE_APART : 0;
    if (!pl_same_label(&label[f], &label[g]) || w->kind[f][k] & PL_EDGE_FEATURE)
        return PL_EDGE_FEATURE | apart;
    return crease ? PL_EDGE_FEATURE | PL_EDGE_CREASE | PL_EDGE_APART : 0;
}

/** Decide about the edges of facets: from the lower one of two. */
static void decide_edges(void *context, int64_t begin, int64_t end, int thread) {
    pl_features *w = context;
    (void)thread;
    for (int64_t f = begin; f < end; f++)
        for (int k = 0; k < 3; k++) {
            const int32_t g = w->beside[f][k];
            if (g >= 0 && g < f)
                continue;
            const uint8_t kind = (uint8_t)(w->kind[f][k] | decide_edge(w, (int32_t)f, k));
            w->kind[f][k] = kind;
            if (g >= 0)
                w->kind[g][pl_edge_beside(w, (int32_t)f, k)] = kind;
        }
}

/** Whether fewer facets have node a than b: few have an edge's end, though a hub may be the other one. */
static int has_fewer(const planish_shape *s, int32_t a, int32_t b) {
    return s->offset[a + 1] - s->offset[a] < s->offset[b + 1] - s->offset[b];
}

/** Mark the facets' edges that are tagged. A tagged edge that the surface has not makes its nodes
 *  corners. */
static void mark_tagged(pl_features *w, const pl_tags *tagged) {
    const planish_shape *s = w->shape;
    for (const pl_tagged *t = tagged->item; t < tagged->item + tagged->n; t++) {
        const int at_first = has_fewer(s, t->node[0], t->node[1]);
        const int32_t a = t->node[!at_first], b = t->node[at_first];
        int is_met = 0;
        for (int64_t i = s->offset[a]; i < s->offset[a + 1]; i++) {
            const int32_t f = s->facet_of[i];
            const int k = pl_corner_at(s, f, a), before = (k + 2) % 3;
            const int edge = s->facet[f][(k + 1) % 3] == b ? k : before;
            if (edge == before && s->facet[f][before] != b)
                continue;
            w->kind[f][edge] |= PL_EDGE_FEATURE;
            is_met = 1;
        }
        if (!is_met)
            w->stays[a] = w->stays[b] = 1;
    }
}

/** List the tagged edges with both nodes on the surface; nodes of the others are corners. */
static void list_tagged(pl_features *w, pl_tags *tagged) {
    const planish_surface *tags = w->tags;
    for (int64_t i = 0; tags && i < tags->n_edges; i++) {
        const int32_t a = w->shape->number[tags->edges[2 * i]];
        const int32_t b = w->shape->number[tags->edges[2 * i + 1]];
        const int32_t mid =
            w->shape->whole && a >= 0 && b >= 0 ? pl_mid_between(w->surface, a, b) : -1;
        const int tag = tags->edge_tag ? tags->edge_tag[i] : 0;
        if (a >= 0 && b >= 0 && a != b) {
            tagged->item[tagged->n++] = (pl_tagged){{a, mid < 0 ? b : mid, -1, -1}, tag, 0};
            if (mid >= 0)
                tagged->item[tagged->n++] = (pl_tagged){{mid, b, -1, -1}, tag, 0};
        } else if (a >= 0 || b >= 0)
            w->stays[a >= 0 ? a : b] = 1;
    }
    pl_tags_sort(tagged);
}

/* ---- feature edges --------------------------------------------------------------------------- */

static uint64_t mixed(uint64_t value, uint64_t with) {
    value = (value ^ with) * 0x9e3779b97f4a7c15u;
    return value ^ value >> 29;
}

/** A number that labels have in common by one chance in 2^64 if they are not the same. */
static uint64_t likeness_of(const pl_label *label) {
    uint64_t value = mixed(1, (uint64_t)label->n_elements);
    value = mixed(value, (uint64_t)(int64_t)label->region[0]);
    value = mixed(value, (uint64_t)(int64_t)label->region[1]);
    return mixed(value, label->is_tagged ? (uint64_t)(int64_t)label->tag : (uint64_t)1 << 40);
}

/** Pass over the feature edges of nodes: first they are counted. */
typedef struct edges_pass {
    spokes_pass spokes;
    const pl_tags *tagged;
    int64_t *first; /* [n_nodes + 1] edges to higher nodes; counts at first */
    int is_counted;
} edges_pass;

static void note_edge(const edges_pass *pass, int32_t node, const spoke *spokes, int64_t n,
                      int64_t at) {
    pl_features *w = pass->spokes.w;
    planish_shape *s = w->shape;
    const int32_t key[] = {node, spokes->end, -1, -1};
    const pl_tagged *t = pass->tagged->n > 0 ? pl_tags_find(pass->tagged, key) : NULL;
    uint64_t likeness = t ? mixed(3, (uint64_t)(int64_t)t->tag) : 0;
    for (int64_t i = 0; i < n; i++)
        likeness += likeness_of(&w->surface->label[spokes[i].facet]);
    w->likeness[at] = likeness;
    s->edge[at][0] = node;
    s->edge[at][1] = spokes->end;
    s->edge_facet[at][0] = spokes->facet;
    s->edge_facet[at][1] = n > 1 ? spokes[1].facet : -1;
}

static void list_edges(void *context, int64_t begin, int64_t end, int thread) {
    const edges_pass *pass = context;
    spoke *spokes = pass->spokes.spokes + thread * pass->spokes.most;
    for (int64_t node = begin; node < end; node++) {
        const int64_t n = list_spokes(pass->spokes.w, (int32_t)node, PL_EDGE_FEATURE, spokes);
        int64_t n_all = 0, n_own = 0;
        for (int64_t i = 0, next; i < n; i = next, n_all++) {
            next = same_end(spokes, n, i);
            if (spokes[i].end < node)
                continue;
            if (!pass->is_counted)
                note_edge(pass, (int32_t)node, spokes + i, next - i, pass->first[node] + n_own);
            n_own++;
        }
        if (pass->is_counted)
            pass->first[node] = n_own;
        pass->spokes.w->n_features[node] = n_all;
    }
}

static int make_edges(pl_features *w, const pl_tags *tagged, planish_error *error) {
    planish_shape *s = w->shape;
    edges_pass pass = {.tagged = tagged, .is_counted = 1};
    int status = begin_pass(w, &pass.spokes, error);
    pass.first = pl_alloc_zero(s->n_nodes + 1, sizeof *pass.first);
    if (!status && !pass.first)
        status = pl_fail_memory(error, "the edges of the surface");
    if (!status) {
        pl_parallel_for(w->threads, s->n_nodes, CHUNK, list_edges, &pass);
        s->n_edges = pl_prefix_sum(w->threads, s->n_nodes, pass.first);
        s->edge = pl_alloc(s->n_edges, sizeof *s->edge);
        s->edge_facet = pl_alloc(s->n_edges, sizeof *s->edge_facet);
        s->tangent = pl_alloc(s->n_edges, sizeof *s->tangent);
        w->likeness = pl_alloc(s->n_edges, sizeof *w->likeness);
        if (!s->edge || !s->edge_facet || !s->tangent || !w->likeness)
            status = pl_fail_memory(error, "the edges of the surface");
    }
    pass.is_counted = 0;
    if (!status)
        pl_parallel_for(w->threads, s->n_nodes, CHUNK, list_edges, &pass);
    pl_free(pass.spokes.spokes);
    pl_free(pass.first);
    return status;
}

/** Note which facets edges join to patches, and number these. */
static int make_patches(pl_features *w, planish_error *error) {
    planish_shape *s = w->shape;
    int32_t n_patches = 0, *list = pl_alloc(s->n_facets, sizeof *list);
    if (!list)
        return pl_fail_memory(error, "the patches of the surface");
    for (int64_t f = 0; f < s->n_facets; f++) {
        for (int k = 0; k < 3; k++)
            s->across[f][k] = w->kind[f][k] & PL_EDGE_FEATURE ? -1 : w->beside[f][k];
        s->patch[f] = -1;
    }
    for (int64_t first = 0; first < s->n_facets; first++) {
        int64_t n = 0;
        if (s->patch[first] >= 0)
            continue;
        s->patch[first] = n_patches;
        list[n++] = (int32_t)first;
        for (int64_t i = 0; i < n; i++)
            for (int k = 0; k < 3; k++) {
                const int32_t g = s->across[list[i]][k];
                if (g < 0 || s->patch[g] >= 0)
                    continue;
                s->patch[g] = n_patches;
                list[n++] = g;
            }
        n_patches++;
    }
    pl_free(list);
    return PLANISH_OK;
}

/* ---- curves and patches ---------------------------------------------------------------------- */

/** Whether every facet at a node lies in a fan between feature edges, which is walked from its begin. */
static int all_at_features(const pl_features *w, int32_t node) {
    const planish_shape *s = w->shape;
    const int64_t n = s->offset[node + 1] - s->offset[node];
    int64_t n_passed = 0;
    for (int64_t i = 0; i < n; i++) {
        int32_t f = s->facet_of[s->offset[node] + i], before = f;
        int k = pl_corner_at(s, f, node), k_before = k;
        if (pl_fan_next(w, PL_EDGE_FEATURE, 0, &before, &k_before))
            continue;
        do
            n_passed++;
        while (n_passed <= n && pl_fan_next(w, PL_EDGE_FEATURE, 1, &f, &k));
    }
    return n_passed == n;
}

/** Whether the two feature edges at a node make a curve there. */
static int is_on_curve(const pl_features *w, int32_t node) {
    const planish_shape *s = w->shape;
    const int32_t a = s->edge_at[node][0], b = s->edge_at[node][1];
    double in[3], out[3];
    if (w->stays[node] || w->likeness[a] != w->likeness[b])
        return 0;
    pl_from_to(3, s->x[s->edge[a][s->edge[a][0] == node]], s->x[node], in);
    pl_from_to(3, s->x[node], s->x[s->edge[b][s->edge[b][0] == node]], out);
    const double length = pl_length(in) * pl_length(out);
    return length > 0 && pl_dot(3, in, out) > COS_TURN * length && all_at_features(w, node);
}

/** Find the nodes on curves, and their edges; others have no edges, or one. */
static void find_curves(pl_features *w) {
    planish_shape *s = w->shape;
    memset(s->edge_at, -1, (size_t)s->n_nodes * sizeof *s->edge_at);
    for (int64_t e = 0; e < s->n_edges; e++)
        for (int j = 0; j < 2; j++) {
            int32_t *at = s->edge_at[s->edge[e][j]];
            if (w->n_features[s->edge[e][j]] <= 2)
                at[at[0] >= 0] = (int32_t)e;
        }
    for (int32_t i = 0; i < s->n_nodes; i++) {
        const int is_curve = w->n_features[i] == 2 && is_on_curve(w, i);
        s->node_class[i] = is_curve ? PL_ON_CURVE : PL_CORNER;
        if (w->n_features[i] == 2 && !is_curve)
            s->edge_at[i][0] = s->edge_at[i][1] = -1;
    }
}

/** Nodes of facets of more than two elements, or without area, are corners. */
static void hold_unclear(pl_features *w) {
    const planish_shape *s = w->shape;
    for (int64_t f = 0; f < s->n_facets; f++)
        for (int k = 0; k < 3; k++)
            if (w->surface->label[f].n_elements > 2 || !has_area(s, (int32_t)f))
                w->stays[s->facet[f][k]] = 1;
}

/** Whether the edge with nodes a and b of a facet is a feature. */
static int is_feature(const pl_features *w, int64_t f, int32_t a, int32_t b) {
    return w->kind[f][pl_edge_with(w->shape, (int32_t)f, a, b)] & PL_EDGE_FEATURE;
}

/** Whether a facet of second order has features inside, or along half an edge. */
static int is_uneven(const pl_features *w, const pl_whole *whole) {
    const planish_shape *s = w->shape;
    const int n = whole->n_corners;
    int any = 0;
    for (int part = 0; part < whole->n_parts; part++)
        for (int k = 0; k < 3; k++) {
            const int32_t f = whole->first + part, across = w->beside[f][k];
            any |= across >= 0 && s->whole_of[across] == s->whole_of[f] &&
                   w->kind[f][k] & PL_EDGE_FEATURE;
        }
    for (int k = 0; k < n && pl_whole_has_mids(whole); k++) {
        const int32_t *v = whole->node, mid = v[n + k];
        any |= is_feature(w, pl_whole_rim(whole, k, 0), v[k], mid) !=
               is_feature(w, pl_whole_rim(whole, k, 1), mid, v[(k + 1) % n]);
    }
    return any;
}

/** Nodes of facets of second order that are uneven, or have edges with other nodes than they can use, are
 *  corners. */
static void hold_uneven(pl_features *w) {
    const planish_shape *s = w->shape;
    for (int64_t i = 0; i < s->n_wholes; i++) {
        const pl_whole *whole = &s->whole[i];
        const int n = whole->n_corners, stays = whole->is_held || is_uneven(w, whole);
        for (int k = 0; k < whole->n_nodes && stays; k++)
            w->stays[whole->node[k]] = 1;
        for (int k = 0; k < n && whole->is_held; k++) {
            const int32_t mid =
                pl_mid_between(w->surface, whole->node[k], whole->node[(k + 1) % n]);
            if (mid >= 0)
                w->stays[mid] = 1;
        }
    }
}

int pl_features_find(pl_features *w, planish_error *error) {
    planish_shape *s = w->shape;
    pl_tags tagged = {pl_alloc(w->tags ? 2 * w->tags->n_edges : 0, sizeof *tagged.item), 0};
    if (!tagged.item)
        return pl_fail_memory(error, "the tagged edges of the surface");
    list_tagged(w, &tagged);
    mark_tagged(w, &tagged);
    pl_parallel_for(w->threads, s->n_facets, CHUNK, compute_normals, w);
    int status = pl_creases_begin(w, error);
    if (!status) {
        pl_parallel_for(w->threads, s->n_facets, CHUNK, decide_edges, w);
        status = pl_creases_prune(w, error);
    }
    hold_unclear(w);
    hold_uneven(w);
    if (!status)
        status = make_patches(w, error);
    if (!status)
        status = make_edges(w, &tagged, error);
    if (!status)
        find_curves(w);
    pl_free(tagged.item);
    return status;
}

/** Whether the facets at a node are one smooth fan, within reach of one normal. */
static int is_on_patch(const pl_features *w, int32_t node) {
    const planish_shape *s = w->shape;
    const int64_t begin = s->offset[node], n = s->offset[node + 1] - begin;
    const int32_t first = s->facet_of[begin];
    int32_t f = first;
    int k = pl_corner_at(s, f, node);
    const double *normal = w->corner_normal[f][k];
    int64_t passed = 0;
    do {
        if (!(pl_dot(3, normal, w->normal[f]) > COS_FAN))
            return 0;
        passed++;
    } while (passed <= n && pl_fan_next(w, PL_EDGE_FEATURE, 1, &f, &k) && f != first);
    return passed == n && f == first;
}

static void settle_nodes(void *context, int64_t begin, int64_t end, int thread) {
    pl_features *w = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        if (w->n_features[i] == 0 && !w->stays[i] && is_on_patch(w, (int32_t)i))
            w->shape->node_class[i] = PL_ON_PATCH;
}

void pl_features_settle(pl_features *w) {
    pl_parallel_for(w->threads, w->shape->n_nodes, CHUNK, settle_nodes, w);
}

/* ---- what is odd ------------------------------------------------------------------------------ */

/** Return the number of facets at edge k of f; 0 if a lower one of them has it, too. */
static int64_t facets_at(const planish_shape *s, int32_t f, int k) {
    const int32_t from = s->facet[f][k], to = s->facet[f][(k + 1) % 3];
    const int at_first = has_fewer(s, from, to);
    const int32_t a = at_first ? from : to, b = at_first ? to : from;
    int64_t n = 0;
    for (int64_t i = s->offset[a]; i < s->offset[a + 1]; i++) {
        const int32_t g = s->facet_of[i], *v = s->facet[g];
        if (v[0] != b && v[1] != b && v[2] != b)
            continue;
        if (g < f)
            return 0;
        n++;
    }
    return n;
}

void pl_features_count(const pl_features *w, planish_shape_info *info) {
    const planish_shape *s = w->shape;
    int64_t n_conflicts = 0;
    for (int32_t f = 0; f < s->n_facets; f++) {
        info->n_flat += !has_area(s, f);
        info->n_turned +=
            w->surface->label[f].n_elements == 0 && is_turned(s->facet[f]) != w->surface->apex[f];
        for (int k = 0; k < 3; k++) {
            const int64_t n = w->beside[f][k] < 0 ? facets_at(s, f, k) : 0;
            info->n_open_edges += n == 1;
            info->n_nonmanifold_edges += n > 2;
            n_conflicts += (w->kind[f][k] & PL_EDGE_CONFLICT) != 0;
        }
    }
    info->n_conflict_edges = n_conflicts / 2;
}
