/* tiles: a box of any size with the irregular stars of a real mesh, for benchmarks of scale.
 *
 *   tiles TILE OUT NX NY NZ
 *
 * TILE: tetrahedra that fill the cube from 0 to 1, such as those of bench/tile.geo, in any format
 * that planish reads. OUT: NX x NY x NZ of them in binary MSH 4.1. Every other tile is mirrored, so
 * that neighbours meet at the same face of the cube and share its nodes. Nothing is kept in memory
 * but the tile.
 */
#include <planish/planish_io.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#define MOST_TILES 1000000 /* along all axes; a mesh has less than 2^31 elements */
#define ON_FACE    1e-9    /* of the side of the cube */
enum { TETRAHEDRON = 4 };

/** On which face of the cube a node lies, by axis. */
typedef enum face { FACE_NONE, FACE_LOW, FACE_HIGH } face;

/** Tiles of one kind share the same faces with the tiles before them, and own the same nodes. */
enum { FIRST, EVEN, ODD, KINDS_OF_AXIS, KINDS = KINDS_OF_AXIS * KINDS_OF_AXIS * KINDS_OF_AXIS };

typedef struct box {
    planish_mesh tile;
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
        const int32_t *node = b->tile.elements + 4 * k;
        int64_t row[5] = {first + k + 1};
        for (int j = 0; j < 4; j++)
            row[1 + j] = number_of(b, at, node[mirrored && j > 1 ? 5 - j : j]) + 1;
        write_numbers(row, 5, out);
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
    write_block(TETRAHEDRON, b->n_elements, out);
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
    printf("%s: %" PRId64 " tetrahedra, %" PRId64 " nodes\n", path, b->n_elements, b->n_nodes);
    return 0;
}

int main(int argc, char **argv) {
    box b = {.n_nodes = 0};
    planish_error error;
    planish_file *file = NULL;
    if (argc != 6)
        return fail("usage: tiles TILE OUT NX NY NZ"), 64;
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
    b.tile = planish_file_mesh(file);
    int status = 0;
    if (b.tile.dim != 3 || b.tile.cells)
        status = fail("the tile must be of straight tetrahedra");
    else if (b.tile.n_elements > INT32_MAX / tiles)
        status = fail("the box would have more elements than 32 bits can number");
    else
        status = prepare(&b);
    if (!status)
        status = write_file(&b, argv[2]);
    free(b.faces);
    free(b.first);
    free(b.number[0]);
    planish_file_close(file);
    return status;
}
