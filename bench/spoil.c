/* spoil: make a mesh bad but keep it valid, for benchmarks.
 *
 *   spoil IN OUT AMOUNT [SEED]
 *   spoil IN OUT push LEFT [SEED [EVERY]]
 *
 * Every interior node moves in a random direction by up to AMOUNT times the mean length of its
 * edges (0.3, say); where an element would lose 98 % of its measure the moves of its nodes are
 * halved, and given up after some rounds. Or (push), one node after the other moves in a random
 * direction towards the facet that stops it, until LEFT (0.01, say) of the way is left, so that no
 * star stays good; or only those nodes whose number EVERY divides. IN and OUT: any format that
 * planish writes back.
 */
#include "boundary_nodes.h"

#include <planish/planish_io.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 60, HALVINGS = 12 };
#define KEEP 0.02 /* fraction of an element's measure that must be left */

typedef struct spoiler {
    planish_mesh mesh;
    double *move;         /* [n_nodes][dim] */
    double *directions;   /* [n_nodes][dim] */
    uint8_t *bad;         /* [n_nodes] of an element that would lose too much */
    double *length;       /* [n_nodes] sum of the lengths of the node's edges, once per element */
    int32_t *edges;       /* [n_nodes] how many */
    uint8_t *on_boundary; /* [n_nodes] */
    int64_t *first;       /* [n_nodes + 1] of each node's elements in star */
    int64_t *star;        /* [n_elements (dim + 1)] */
} spoiler;

/** What the command line says. */
typedef struct request {
    int push;
    double amount; /* AMOUNT, or LEFT where push */
    uint64_t seed;
    int64_t every;
} request;

static int fail(const char *what) {
    fprintf(stderr, "spoil: %s\n", what);
    return 2;
}

static double uniform(uint64_t *state) {
    *state ^= *state << 13; /* Marsaglia's xorshift */
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(*state >> 11) * 0x1p-53;
}

/** dim! times the signed measure of an element with its nodes moved by fraction. */
static double measure(const spoiler *s, int64_t element, double fraction) {
    int dim = s->mesh.dim;
    const int32_t *node = s->mesh.elements + element * (dim + 1);
    double e[3][3];
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++) {
            int64_t p = (int64_t)node[j + 1] * dim + d, q = (int64_t)node[0] * dim + d;
            e[j][d] = s->mesh.coordinates[p] + fraction * s->move[p] -
                      (s->mesh.coordinates[q] + fraction * s->move[q]);
        }
    if (dim == 2)
        return e[0][0] * e[1][1] - e[0][1] * e[1][0];
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

static void sum_edges(spoiler *s) {
    int dim = s->mesh.dim;
    for (int64_t k = 0; k < s->mesh.n_elements; k++) {
        const int32_t *node = s->mesh.elements + k * (dim + 1);
        for (int i = 0; i <= dim; i++)
            for (int j = 0; j < i; j++) {
                double length2 = 0;
                for (int d = 0; d < dim; d++) {
                    double e = s->mesh.coordinates[(int64_t)node[i] * dim + d] -
                               s->mesh.coordinates[(int64_t)node[j] * dim + d];
                    length2 += e * e;
                }
                s->length[node[i]] += sqrt(length2);
                s->length[node[j]] += sqrt(length2);
                s->edges[node[i]]++;
                s->edges[node[j]]++;
            }
    }
}

static void draw_moves(spoiler *s, double amount, uint64_t seed) {
    int dim = s->mesh.dim;
    uint64_t state = seed * 0x9E3779B97F4A7C15u + 1;
    for (int64_t i = 0; i < s->mesh.n_nodes; i++) {
        double v[3], length2;
        do { /* uniform in the ball, then on the sphere */
            length2 = 0;
            for (int d = 0; d < dim; d++) {
                v[d] = 2 * uniform(&state) - 1;
                length2 += v[d] * v[d];
            }
        } while (length2 > 1 || length2 < 0.01);
        double far = amount * uniform(&state);
        if (s->on_boundary[i] || !s->edges[i])
            far = 0;
        else
            far *= s->length[i] / s->edges[i] / sqrt(length2);
        for (int d = 0; d < dim; d++)
            s->move[i * dim + d] = far * v[d];
    }
}

/** Shorten the moves of the elements that would lose too much; returns how many there were. */
static int64_t shorten_moves(spoiler *s, double factor) {
    int dim = s->mesh.dim;
    int64_t count = 0;
    memset(s->bad, 0, (size_t)s->mesh.n_nodes);
    for (int64_t k = 0; k < s->mesh.n_elements; k++) {
        double before = measure(s, k, 0), after = measure(s, k, 1);
        int lost = before > 0 ? after <= KEEP * before : after >= KEEP * before;
        count += lost;
        for (int j = 0; lost && j <= dim; j++)
            s->bad[s->mesh.elements[k * (dim + 1) + j]] = 1;
    }
    for (int64_t i = 0; i < s->mesh.n_nodes; i++)
        for (int d = 0; s->bad[i] && d < dim; d++)
            s->move[i * dim + d] *= factor;
    return count;
}

static void list_stars(spoiler *s) {
    int64_t corners = s->mesh.n_elements * (s->mesh.dim + 1);
    for (int64_t c = 0; c < corners; c++)
        s->first[s->mesh.elements[c]]++;
    for (int64_t i = 1; i <= s->mesh.n_nodes; i++)
        s->first[i] += s->first[i - 1];
    for (int64_t c = corners; c-- > 0;) /* from the ends of the stars to their beginnings */
        s->star[--s->first[s->mesh.elements[c]]] = c / (s->mesh.dim + 1);
}

/** How many times its move the node can go until an element of its star is flat; 0: any number. */
static double way_to_facet(const spoiler *s, int64_t node) {
    double way = 0;
    for (int64_t i = s->first[node]; i < s->first[node + 1]; i++) {
        double here = measure(s, s->star[i], 0), there = measure(s, s->star[i], 1);
        double flat = here / (here - there);
        if (flat > 0 && (way == 0 || flat < way))
            way = flat;
    }
    return way;
}

/** Move every so many nodes one by one, so that each sees where those before it went. */
static void push_nodes(spoiler *s, double *coordinates, double left, int64_t every) {
    size_t dim = (size_t)s->mesh.dim, n = (size_t)s->mesh.n_nodes;
    memcpy(s->directions, s->move, n * dim * sizeof(double));
    memset(s->move, 0, n * dim * sizeof(double));
    list_stars(s);
    for (int64_t i = 0; i < s->mesh.n_nodes; i += every) {
        size_t at = (size_t)i * dim;
        if (s->on_boundary[i])
            continue;
        memcpy(s->move + at, s->directions + at, dim * sizeof(double));
        double way = (1 - left) * way_to_facet(s, i);
        for (size_t d = 0; d < dim; d++)
            coordinates[at + d] += way * s->directions[at + d];
        memset(s->move + at, 0, dim * sizeof(double));
    }
}

/** Move all nodes at once, no farther than elements allow. */
static void move_nodes(spoiler *s, double *coordinates) {
    int64_t n = s->mesh.n_nodes * s->mesh.dim;
    for (int round = 0; round < ROUNDS; round++)
        if (!shorten_moves(s, round < HALVINGS ? 0.5 : 0))
            break;
    for (int64_t i = 0; i < n; i++)
        coordinates[i] += s->move[i];
}

static int allocate(spoiler *s) {
    size_t n = (size_t)s->mesh.n_nodes, dim = (size_t)s->mesh.dim;
    s->move = calloc(n * dim, sizeof(double));
    s->directions = calloc(n * dim, sizeof(double));
    s->length = calloc(n, sizeof(double));
    s->edges = calloc(n, sizeof *s->edges);
    s->on_boundary = calloc(n, 1);
    s->bad = malloc(n);
    s->first = calloc(n + 1, sizeof *s->first);
    s->star = malloc((size_t)s->mesh.n_elements * (dim + 1) * sizeof *s->star);
    return s->move && s->directions && s->length && s->edges && s->on_boundary && s->bad &&
           s->first && s->star;
}

static void release(spoiler *s) {
    free(s->move);
    free(s->directions);
    free(s->length);
    free(s->edges);
    free(s->on_boundary);
    free(s->bad);
    free(s->first);
    free(s->star);
}

static int spoil(planish_file *file, const request *asked) {
    spoiler s = {.mesh = planish_file_mesh(file)};
    double *coordinates = planish_file_coordinates(file);
    int ok = allocate(&s) && bench_find_boundary(&s.mesh, s.on_boundary);
    if (ok) {
        sum_edges(&s);
        draw_moves(&s, asked->push ? 1 : asked->amount, asked->seed);
        if (asked->push)
            push_nodes(&s, coordinates, asked->amount, asked->every);
        else
            move_nodes(&s, coordinates);
    }
    release(&s);
    return ok;
}

static int parse(request *asked, int argc, char **argv) {
    int push = argc > 3 && !strcmp(argv[3], "push");
    *asked = (request){.push = push, .seed = 1, .every = 1};
    if (argc < 4 + push || argc > 5 + 2 * push)
        return 0;
    char *end;
    asked->amount = strtod(argv[3 + push], &end);
    if (*end || !(asked->amount >= 0 && asked->amount <= 1))
        return 0;
    if (argc > 4 + push)
        asked->seed = (uint64_t)atoll(argv[4 + push]);
    if (argc > 6)
        asked->every = atoll(argv[6]);
    return asked->every > 0;
}

int main(int argc, char **argv) {
    request asked;
    planish_error error;
    planish_file *file = NULL;
    if (!parse(&asked, argc, argv))
        return fail("usage: spoil IN OUT AMOUNT [SEED], or IN OUT push LEFT [SEED [EVERY]]; AMOUNT "
                    "and LEFT from 0 to 1"),
               64;
    if (planish_file_open(argv[1], NULL, 0, &file, &error))
        return fail(error.text);
    int status = 0;
    if (planish_file_mesh(file).cells)
        status = fail("the mesh must be of straight elements");
    else if (!spoil(file, &asked))
        status = fail("out of memory");
    else if (planish_file_write(file, argv[2], planish_file_coordinates(file), NULL, &error))
        status = fail(error.text);
    planish_file_close(file);
    return status;
}
