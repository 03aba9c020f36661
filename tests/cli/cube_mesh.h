/* cube_mesh: a cube of tetrahedra with its inner nodes moved, its surface, and two regions, for the
 * programs that write meshes with the libraries of their formats. Numbers from 1.
 */
#ifndef TEST_CLI_CUBE_MESH_H
#define TEST_CLI_CUBE_MESH_H

#include <stdlib.h>

typedef struct cube_mesh {
    int n, n_nodes, n_tetrahedra, n_triangles;
    double *x, *y, *z;
    int *tetrahedra, *triangles; /* triangles: z = 0, then z = 1 */
    int n_lower;                 /* the first tetrahedra are of the lower half */
} cube_mesh;

static int cube_node(const cube_mesh *m, int i, int j, int k) {
    return 1 + i + (m->n + 1) * (j + (m->n + 1) * k);
}

/** The six tetrahedra of a cell, along its diagonal. */
static void cube_cell(cube_mesh *m, int i, int j, int k) {
    static const int step[6][2] = {{1, 2}, {1, 4}, {2, 1}, {2, 4}, {4, 1}, {4, 2}};
    for (int t = 0; t < 6; t++) {
        int *nodes = &m->tetrahedra[4 * m->n_tetrahedra++];
        int corner[4] = {0, step[t][0], step[t][0] | step[t][1], 7};
        for (int c = 0; c < 4; c++)
            nodes[c] =
                cube_node(m, i + (corner[c] & 1), j + (corner[c] >> 1 & 1), k + (corner[c] >> 2));
        if (t == 1 || t == 2 || t == 5) { /* of the other orientation */
            int swap = nodes[2];
            nodes[2] = nodes[3];
            nodes[3] = swap;
        }
    }
}

static void cube_surface(cube_mesh *m, int k) {
    for (int j = 0; j < m->n; j++) {
        for (int i = 0; i < m->n; i++) {
            const int a = cube_node(m, i, j, k), b = cube_node(m, i + 1, j, k),
                      c = cube_node(m, i + 1, j + 1, k), d = cube_node(m, i, j + 1, k);
            const int nodes[6] = {a, b, c, a, c, d};
            for (int t = 0; t < 6; t++)
                m->triangles[3 * m->n_triangles + t] = nodes[t];
            m->n_triangles += 2;
        }
    }
}

static void cube_nodes(cube_mesh *m) {
    unsigned seed = 1;
    for (int k = 0; k <= m->n; k++) {
        for (int j = 0; j <= m->n; j++) {
            for (int i = 0; i <= m->n; i++) {
                const int node = cube_node(m, i, j, k) - 1;
                const int at[3] = {i, j, k};
                double *const xyz[3] = {m->x, m->y, m->z};
                int is_inner = 1;
                for (int d = 0; d < 3; d++)
                    is_inner &= at[d] > 0 && at[d] < m->n;
                for (int d = 0; d < 3; d++) {
                    seed = 1664525 * seed + 1013904223;
                    const double shift = is_inner ? (double)(seed >> 16) / 65536 - 0.5 : 0;
                    xyz[d][node] = (at[d] + 0.3 * shift) / m->n;
                }
            }
        }
    }
}

static cube_mesh cube_make(int n) {
    cube_mesh m = {.n = n, .n_nodes = (n + 1) * (n + 1) * (n + 1)};
    const size_t nodes = (size_t)m.n_nodes, cells = (size_t)n * (size_t)n * (size_t)n;
    m.x = malloc(nodes * sizeof(double));
    m.y = malloc(nodes * sizeof(double));
    m.z = malloc(nodes * sizeof(double));
    m.tetrahedra = malloc(cells * 24 * sizeof(int));
    m.triangles = malloc((size_t)n * (size_t)n * 12 * sizeof(int));
    cube_nodes(&m);
    for (int k = 0; k < n; k++) {
        for (int j = 0; j < n; j++)
            for (int i = 0; i < n; i++)
                cube_cell(&m, i, j, k);
        if (k < n / 2)
            m.n_lower = m.n_tetrahedra;
    }
    cube_surface(&m, 0);
    cube_surface(&m, n);
    return m;
}

#endif
