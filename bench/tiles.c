/* tiles: a box of any size with the irregular stars of a real mesh, for benchmarks of scale.
 *
 *   tiles [--hexahedra] TILE OUT NX NY NZ
 *
 * TILE: tetrahedra that fill the cube from 0 to 1, such as those of bench/tile.geo, in any format
 * that planish reads. OUT: NX x NY x NZ of them in binary MSH 4.1. Every other tile is mirrored, so
 * that neighbours meet at the same face of the cube and share its nodes. Nothing is kept in memory
 * but the tile. --hexahedra: every tetrahedron becomes four hexahedra, between the middles of its
 * edges, faces and of itself.
 */
#include <planish/planish_io.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_TILES 1000000                /* along all axes; a mesh has less than 2^31 elements */
#define ON_FACE    1e-9                   /* of the side of the cube */
enum { TETRAHEDRON = 4, HEXAHEDRON = 5 }; /* of MSH */

/** On which face of the cube a node lies, by axis. */
typedef enum face { FACE_NONE, FACE_LOW, FACE_HIGH } face;

/** Tiles of one kind share the same faces with the tiles before them, and own the same nodes. */
enum { FIRST, EVEN, ODD, KINDS_OF_AXIS, KINDS = KINDS_OF_AXIS * KINDS_OF_AXIS * KINDS_OF_AXIS };

/** Elements that are repeated. */
typedef struct tile {
    int64_t n_nodes, n_elements;
    int n_corners;
    double *coordinates; /* [n_nodes][3] */
    int32_t *elements;   /* [n_elements][n_corners] */
} tile;

typedef struct box {
    tile tile;
    int64_t n[3];                /* tiles along the axes */
    uint8_t (*faces)[3];         /* [n_nodes] face */
    int64_t owned[KINDS];        /* nodes of a tile that none before it has */
    int32_t *number[KINDS];      /* [n_nodes] of an owned node among them, else -1 */
    int64_t *first;              /* [tiles + 1] number of each tile's first own node */
    int64_t n_nodes, n_elements; /* of the box */
} box;

static int fail(const char *what) {
    fprintf(stderr, "tiles: %s\n", what);
    return 2;
}

static int kind_on_axis(int64_t place) {
    return place == 0 ? FIRST : place % 2 == 0 ? EVEN : ODD;
}

static int kind_of(const int64_t at[3]) {
    return (kind_on_axis(at[0]) * KINDS_OF_AXIS + kind_on_axis(at[1])) * KINDS_OF_AXIS +
           kind_on_axis(at[2]);
}

/* ---- hexahedra ---------------------------------------------------------------------------- */

/** Middle of two or three nodes, of which as many tetrahedra ask as have them. */
typedef struct middle {
    int32_t node[3]; /* ascending; the first is -1 of two */
    int64_t place;   /* where its number goes */
} middle;

static int compare_middles(const void *a, const void *b) {
    const middle *x = a, *y = b;
    for (int i = 0; i < 3; i++)
        if (x->node[i] != y->node[i])
            return x->node[i] < y->node[i] ? -1 : 1;
    return (x->place > y->place) - (x->place < y->place);
}

static middle middle_of(int32_t a, int32_t b, int32_t c, int64_t place) {
    middle m = {{a, b, c}, place};
    for (int i = 0; i < 2; i++)
        for (int j = 0; j < 2 - i; j++)
            if (m.node[j] > m.node[j + 1]) {
                const int32_t other = m.node[j];
                m.node[j] = m.node[j + 1];
                m.node[j + 1] = other;
            }
    return m;
}

enum { EDGES = 6, MIDDLES = 10 }; /* of a tetrahedron; its faces are those opposite corner i */
static const int edge_ends[EDGES][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

/** Number the middles of edges and faces of tetrahedra [m] behind the nodes, and put them in their
 *  places: number [m][MIDDLES]. There is room for their coordinates. */
static void number_middles(tile *t, middle *wanted, int64_t m, int32_t *number) {
    const size_t n = (size_t)m * MIDDLES;
    for (int64_t i = 0; i < (int64_t)n; i++) {
        const int32_t *node = t->elements + i / MIDDLES * 4;
        const int k = (int)(i % MIDDLES), opposite = k - EDGES;
        if (k < EDGES)
            wanted[i] = middle_of(-1, node[edge_ends[k][0]], node[edge_ends[k][1]], i);
        else
            wanted[i] = middle_of(node[opposite == 0], node[opposite <= 1 ? 2 : 1],
                                  node[opposite <= 2 ? 3 : 2], i);
    }
    qsort(wanted, n, sizeof *wanted, compare_middles);
    for (size_t i = 0; i < n; i++) {
        const int32_t *node = wanted[i].node;
        const int first = node[0] < 0;
        double *at = t->coordinates + 3 * t->n_nodes;
        if (i == 0 || memcmp(node, wanted[i - 1].node, sizeof wanted[i].node) != 0) {
            for (int d = 0; d < 3; d++) {
                at[d] = 0;
                for (int k = first; k < 3; k++)
                    at[d] += t->coordinates[3 * (int64_t)node[k] + d] / (3 - first);
            }
            t->n_nodes++;
        }
        number[wanted[i].place] = (int32_t)(t->n_nodes - 1);
    }
}

/** Number of the middle between corners i and j of a tetrahedron. */
static int32_t on_edge(const int32_t *number, int i, int j) {
    for (int k = 0; k < EDGES; k++)
        if ((edge_ends[k][0] == i && edge_ends[k][1] == j) ||
            (edge_ends[k][0] == j && edge_ends[k][1] == i))
            return number[k];
    return -1;
}

/** Replace each tetrahedron by four hexahedra, one at each corner. */
static int make_hexahedra(tile *t) {
    static const int around[4][4] = {{0, 1, 2, 3}, {1, 2, 0, 3}, {2, 0, 1, 3}, {3, 0, 2, 1}};
    const int64_t m = t->n_elements;
    const size_t n_more = (size_t)m * (MIDDLES + 1);
    middle *wanted = malloc(n_more * sizeof *wanted);
    int32_t *number = malloc(n_more * sizeof *number), *hexahedra = malloc(32 * (size_t)m * 4);
    double *x = realloc(t->coordinates, ((size_t)t->n_nodes + n_more) * 3 * sizeof *x);
    t->coordinates = x ? x : t->coordinates;
    const int failed = !wanted || !number || !hexahedra || !x;
    if (!failed)
        number_middles(t, wanted, m, number);
    for (int64_t i = 0; i < m && !failed; i++) {
        const int32_t *node = t->elements + 4 * i, *between = number + MIDDLES * i;
        const int32_t centre = (int32_t)t->n_nodes++;
        for (int d = 0; d < 3; d++) {
            x[3 * (int64_t)centre + d] = 0;
            for (int k = 0; k < 4; k++)
                x[3 * (int64_t)centre + d] += x[3 * (int64_t)node[k] + d] / 4;
        }
        for (int k = 0; k < 4; k++) {
            const int v = around[k][0], a = around[k][1], b = around[k][2], c = around[k][3];
            const int32_t row[8] = {node[v],
                                    on_edge(between, v, a),
                                    between[EDGES + c],
                                    on_edge(between, v, b),
                                    on_edge(between, v, c),
                                    between[EDGES + b],
                                    centre,
                                    between[EDGES + a]};
            memcpy(hexahedra + 8 * (4 * i + k), row, sizeof row);
        }
    }
    free(wanted);
    free(number);
    free(t->elements);
    t->elements = hexahedra;
    t->n_elements = 4 * m;
    t->n_corners = 8;
    return failed ? fail("out of memory") : 0;
}

/** Copy the tile, and cut it up if hexahedra are wanted. */
static int take_tile(const planish_mesh *mesh, int is_cut, tile *t) {
    const size_t n = (size_t)mesh->n_nodes * 3 * sizeof *t->coordinates;
    const size_t m = (size_t)mesh->n_elements * 4 * sizeof *t->elements;
    *t = (tile){mesh->n_nodes, mesh->n_elements, 4, malloc(n), malloc(m)};
    if (!t->coordinates || !t->elements)
        return fail("out of memory");
    memcpy(t->coordinates, mesh->coordinates, n);
    memcpy(t->elements, mesh->elements, m);
    return is_cut ? make_hexahedra(t) : 0;
}

/** The face of the cube that a tile shares with the one before it on an axis: odd tiles are
 *  mirrored. */
static face shared_face(int kind) {
    return kind == FIRST ? FACE_NONE : kind == EVEN ? FACE_LOW : FACE_HIGH;
}

static int64_t tile_index(const box *b, const int64_t at[3]) {
    return (at[2] * b->n[1] + at[1]) * b->n[0] + at[0];
}

/** Number from 0 in the box of a node of the tile at a place: of the first tile that has it. */
static int64_t number_of(const box *b, const int64_t at[3], int32_t node) {
    int64_t owner[3];
    for (int d = 0; d < 3; d++) {
        face shared = shared_face(kind_on_axis(at[d]));
        owner[d] = at[d] - (shared != FACE_NONE && b->faces[node][d] == shared);
    }
    return b->first[tile_index(b, owner)] + b->number[kind_of(owner)][node];
}

/* ---- what is known before writing --------------------------------------------------------- */

static int find_faces(box *b) {
    for (int64_t i = 0; i < b->tile.n_nodes; i++)
        for (int d = 0; d < 3; d++) {
            double x = b->tile.coordinates[3 * i + d];
            if (!(x > -ON_FACE && x < 1 + ON_FACE))
                return 0;
            b->faces[i][d] = x < ON_FACE ? FACE_LOW : x > 1 - ON_FACE ? FACE_HIGH : FACE_NONE;
        }
    return 1;
}

static void number_owned(box *b, int kind) {
    const int on_axis[3] = {kind / (KINDS_OF_AXIS * KINDS_OF_AXIS),
                            kind / KINDS_OF_AXIS % KINDS_OF_AXIS, kind % KINDS_OF_AXIS};
    for (int64_t i = 0; i < b->tile.n_nodes; i++) {
        int is_shared = 0;
        for (int d = 0; d < 3; d++) {
            face shared = shared_face(on_axis[d]);
            is_shared |= shared != FACE_NONE && b->faces[i][d] == shared;
        }
        b->number[kind][i] = is_shared ? -1 : (int32_t)b->owned[kind]++;
    }
}

static int prepare(box *b) {
    size_t nodes = (size_t)b->tile.n_nodes;
    int64_t tiles = b->n[0] * b->n[1] * b->n[2], at[3];
    b->faces = malloc(nodes * sizeof *b->faces);
    b->first = malloc(((size_t)tiles + 1) * sizeof *b->first);
    int32_t *numbers = malloc(KINDS * nodes * sizeof *numbers);
    b->number[0] = numbers;
    if (!b->faces || !b->first || !numbers)
        return fail("out of memory");
    if (!find_faces(b))
        return fail("the tile must fill the cube from 0 to 1");
    for (int kind = 0; kind < KINDS; kind++) {
        b->number[kind] = numbers + (size_t)kind * nodes;
        number_owned(b, kind);
    }
    int64_t *next = b->first;
    *next = 0;
    for (at[2] = 0; at[2] < b->n[2]; at[2]++)
        for (at[1] = 0; at[1] < b->n[1]; at[1]++)
            for (at[0] = 0; at[0] < b->n[0]; at[0]++, next++)
                next[1] = next[0] + b->owned[kind_of(at)];
    b->n_nodes = b->first[tiles];
    b->n_elements = tiles * b->tile.n_elements;
    return 0;
}

/* ---- the file ----------------------------------------------------------------------------- */

/** Call write_tile for every tile, in the order of their numbers. */
static void for_tiles(const box *b, void (*write_tile)(const box *, const int64_t[3], FILE *),
                      FILE *out) {
    int64_t at[3];
    for (at[2] = 0; at[2] < b->n[2]; at[2]++)
        for (at[1] = 0; at[1] < b->n[1]; at[1]++)
            for (at[0] = 0; at[0] < b->n[0]; at[0]++)
                write_tile(b, at, out);
}

static void write_numbers(const int64_t *numbers, size_t n, FILE *out) {
    fwrite(numbers, sizeof *numbers, n, out);
}

/** "entity" of MSH 4.1: the volume 1, and which is what of it. */
static void write_block(int32_t what, int64_t n, FILE *out) {
    fwrite((int32_t[3]){3, 1, what}, sizeof(int32_t), 3, out);
    write_numbers(&n, 1, out);
}

static void write_points(const box *b, const int64_t at[3], FILE *out) {
    const int32_t *number = b->number[kind_of(at)];
    for (int64_t i = 0; i < b->tile.n_nodes; i++) {
        double point[3];
        for (int d = 0; d < 3; d++) {
            double x = b->tile.coordinates[3 * i + d];
            if (b->faces[i][d] != FACE_NONE)
                x = b->faces[i][d] == FACE_HIGH;
            point[d] = (double)at[d] + (at[d] % 2 ? 1 - x : x);
        }
        if (number[i] >= 0)
            fwrite(point, sizeof *point, 3, out);
    }
}

static void write_elements(const box *b, const int64_t at[3], FILE *out) {
    int64_t first = tile_index(b, at) * b->tile.n_elements;
    int mirrored = (at[0] + at[1] + at[2]) % 2 != 0;
    for (int64_t k = 0; k < b->tile.n_elements; k++) {
        static const int turned[] = {0, 1, 3, 2}, turned_hexahedron[] = {0, 3, 2, 1, 4, 7, 6, 5};
        const int n = b->tile.n_corners, *order = n == 4 ? turned : turned_hexahedron;
        const int32_t *node = b->tile.elements + n * k;
        int64_t row[9] = {first + k + 1};
        for (int j = 0; j < n; j++)
            row[1 + j] = number_of(b, at, node[mirrored ? order[j] : j]) + 1;
        write_numbers(row, (size_t)n + 1, out);
    }
}

static void write_box(const box *b, FILE *out) {
    fputs("$MeshFormat\n4.1 1 8\n", out);
    fwrite(&(int32_t){1}, sizeof(int32_t), 1, out);
    fputs("\n$EndMeshFormat\n$Nodes\n", out);
    write_numbers((int64_t[4]){1, b->n_nodes, 1, b->n_nodes}, 4, out);
    write_block(0, b->n_nodes, out);
    for (int64_t i = 1; i <= b->n_nodes; i++)
        write_numbers(&i, 1, out);
    for_tiles(b, write_points, out);
    fputs("\n$EndNodes\n$Elements\n", out);
    write_numbers((int64_t[4]){1, b->n_elements, 1, b->n_elements}, 4, out);
    write_block(b->tile.n_corners == 4 ? TETRAHEDRON : HEXAHEDRON, b->n_elements, out);
    for_tiles(b, write_elements, out);
    fputs("\n$EndElements\n", out);
}

static int write_file(const box *b, const char *path) {
    FILE *out = fopen(path, "wb");
    if (!out)
        return fail("cannot write the output");
    write_box(b, out);
    int bad = ferror(out);
    if (fclose(out) != 0 || bad)
        return fail("cannot write all of the output");
    printf("%s: %" PRId64 " %s, %" PRId64 " nodes\n", path, b->n_elements,
           b->tile.n_corners == 4 ? "tetrahedra" : "hexahedra", b->n_nodes);
    return 0;
}

int main(int argc, char **argv) {
    box b = {.n_nodes = 0};
    planish_error error;
    planish_file *file = NULL;
    const int is_cut = argc > 1 && strcmp(argv[1], "--hexahedra") == 0;
    argv += is_cut;
    if (argc - is_cut != 6)
        return fail("usage: tiles [--hexahedra] TILE OUT NX NY NZ"), 64;
    int64_t tiles = 1;
    for (int d = 0; d < 3; d++) {
        char *end;
        b.n[d] = strtoll(argv[3 + d], &end, 10);
        if (*end || b.n[d] < 1 || b.n[d] > MOST_TILES / tiles)
            return fail("NX, NY and NZ must be whole numbers from 1, and no more than a million "
                        "tiles"),
                   64;
        tiles *= b.n[d];
    }
    if (planish_file_open(argv[1], NULL, 0, &file, &error))
        return fail(error.text);
    const planish_mesh mesh = planish_file_mesh(file);
    int status = 0;
    if (mesh.dim != 3 || mesh.cells)
        status = fail("the tile must be of straight tetrahedra");
    else if (mesh.n_elements > INT32_MAX / tiles / (is_cut ? 4 : 1))
        status = fail("the box would have more elements than 32 bits can number");
    else
        status = take_tile(&mesh, is_cut, &b.tile);
    if (!status)
        status = prepare(&b);
    if (!status)
        status = write_file(&b, argv[2]);
    free(b.faces);
    free(b.first);
    free(b.number[0]);
    free(b.tile.coordinates);
    free(b.tile.elements);
    planish_file_close(file);
    return status;
}
