/* foam_builder: OpenFOAM meshes from elements: their faces, in every encoding. */
#include "support/foam_builder.h"

#include "support/file_builder.h"
#include "support/files.h"

#include <planish/planish.h>

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* ---- faces ---------------------------------------------------------------------------------- */

typedef struct face {
    int n, node[4], sorted[4]; /* -1 behind the last */
    int owner, neighbour, patch;
} face;

typedef struct faces {
    face *face; /* [n] */
    int n;
} faces;

/* Faces of elements, whose normals leave them, by nodes in VTK's order. */
static const char *const faces_of[] = {
    [PLANISH_CELL_TETRAHEDRON] = "021 013 123 203",
    [PLANISH_CELL_PYRAMID] = "0321 014 124 234 304",
    [PLANISH_CELL_WEDGE] = "021 345 0143 1254 2035",
    [PLANISH_CELL_HEXAHEDRON] = "0321 4567 0154 1265 2376 3047",
};

static int compare_ints(const void *a, const void *b) {
    return *(const int *)a - *(const int *)b;
}

static int compare_nodes(const void *a, const void *b) {
    return memcmp(((const face *)a)->sorted, ((const face *)b)->sorted, sizeof((face *)0)->sorted);
}

/** Inner faces by owner and neighbour, then those of the boundary by patch. */
static int compare_order(const void *a, const void *b) {
    const face *p = a, *q = b;
    if (p->patch != q->patch)
        return p->patch - q->patch;
    return p->owner != q->owner ? p->owner - q->owner : p->neighbour - q->neighbour;
}

static int smallest(const face *f) {
    int node = f->node[0];
    for (int k = 1; k < f->n; k++)
        node = f->node[k] < node ? f->node[k] : node;
    return node;
}

/** List the faces of all elements, twice where two meet. */
static void list_faces(const foam_cells *cells, faces *f) {
    int cell = -1;
    f->face = calloc((size_t)cells->n_cells * 6, sizeof *f->face);
    assert_non_null(f->face);
    for (int i = 0; i < cells->n_cells; i++) {
        cell += !cells->merged[i];
        for (const char *c = faces_of[cells->type[i]]; *c; c += *c == ' ') {
            face *to = &f->face[f->n++];
            memset(to->sorted, -1, sizeof to->sorted);
            to->owner = cell;
            for (; *c && *c != ' '; c++)
                to->node[to->n] = to->sorted[to->n] = cells->node[i][*c - '0'], to->n++;
            while (to->node[0] != smallest(to)) { /* where two sides are alike, faces are, too */
                const int first = to->node[0];
                memmove(to->node, to->node + 1, (size_t)(to->n - 1) * sizeof first);
                to->node[to->n - 1] = first;
            }
            qsort(to->sorted, (size_t)to->n, sizeof *to->sorted, compare_ints);
        }
    }
}

/** Make one face of two that meet; none where they are of one cell. */
static void join_faces(faces *f) {
    int n = 0;
    qsort(f->face, (size_t)f->n, sizeof *f->face, compare_nodes);
    for (int i = 0; i < f->n; i++) {
        face *a = &f->face[i];
        a->neighbour = -1;
        if (i + 1 < f->n && compare_nodes(a, a + 1) == 0) {
            face *owner = a->owner < a[1].owner ? a : a + 1, *other = owner == a ? a + 1 : a;
            face joined = *owner;
            i++;
            if (owner->owner == other->owner)
                continue;
            joined.neighbour = other->owner;
            joined.patch = -1;
            f->face[n++] = joined;
        } else {
            f->face[n++] = *a;
        }
    }
    f->n = n;
}

static void find_patches(const foam_cells *cells, faces *f, foam_patch_of *patch_of) {
    for (int i = 0; i < f->n; i++) {
        face *a = &f->face[i];
        double middle[3] = {0, 0, 0};
        for (int k = 0; k < a->n; k++)
            for (int d = 0; d < 3; d++)
                middle[d] += cells->x[a->node[k]][d] / a->n;
        if (a->neighbour < 0)
            a->patch = patch_of(middle);
    }
    qsort(f->face, (size_t)f->n, sizeof *f->face, compare_order);
}

/* ---- files ---------------------------------------------------------------------------------- */

static void begin(file_builder *b, const foam_form *form, const char *class, const char *object) {
    const char *order = form->swapped ? "MSB" : "LSB";
    b->binary = form->binary;
    b->swapped = form->swapped;
    builder_text(
        b, "/*---- a mesh ( ----*/\nFoamFile\n{\n    version 2.0; // of the form\n    format %s;\n",
        form->binary ? "binary" : "ascii");
    if (!form->has_no_arch)
        builder_text(b, "    arch \"%s;label=%d;scalar=%d\";\n", order, 8 * form->label_size,
                     8 * form->scalar_size);
    builder_text(
        b, "    class %s;\n    location \"constant/polyMesh\";\n    object %s;\n}\n// ***\n\n",
        class, object);
}

static void end(file_builder *b, const char *folder, const char *name) {
    char path[TEST_PATH_SIZE];
    builder_text(b, "\n// the end\n");
    unlink(test_path(path, folder,
                     name)); /* the system may wait for the disk where a file is emptied */
    test_write(folder, name, b->data, (size_t)b->size);
    builder_release(b);
}

static void write_labels(const char *folder, const char *name, const foam_form *form,
                         const faces *f, int of_neighbours) {
    file_builder b = {0};
    int n = 0;
    for (int i = 0; i < f->n; i++)
        n += !of_neighbours || f->face[i].neighbour >= 0;
    begin(&b, form, "labelList", name);
    builder_text(&b, form->binary ? "%d\n(" : "%d\n(\n", n);
    for (int i = 0; i < n; i++) {
        builder_integer(&b, of_neighbours ? f->face[i].neighbour : f->face[i].owner,
                        form->label_size);
        builder_line(&b);
    }
    builder_text(&b, ")");
    end(&b, folder, name);
}

static void write_faces(const char *folder, const foam_form *form, const faces *f) {
    file_builder b = {0};
    const int is_compact = form->binary && !form->single_faces;
    int n_nodes = 0;
    begin(&b, form, is_compact ? "faceCompactList" : "faceList", "faces");
    if (is_compact) {
        builder_text(&b, "%d\n(", f->n + 1);
        for (int i = 0; i <= f->n; i++) {
            builder_integer(&b, n_nodes, form->label_size);
            n_nodes += i < f->n ? f->face[i].n : 0;
        }
        builder_text(&b, ")\n\n%d\n(", n_nodes);
    } else {
        builder_text(&b, "%d\n(\n", f->n);
    }
    for (int i = 0; i < f->n; i++) {
        const face *a = &f->face[i];
        if (!is_compact)
            builder_text(&b, "%d(", a->n);
        for (int k = 0; k < a->n; k++)
            if (form->binary)
                builder_integer(&b, a->node[k], form->label_size);
            else
                builder_text(&b, k ? " %d" : "%d", a->node[k]);
        if (!is_compact)
            builder_text(&b, ")\n");
    }
    builder_text(&b, ")");
    end(&b, folder, "faces");
}

static void write_points(const char *folder, const foam_cells *cells, const foam_form *form) {
    file_builder b = {0};
    begin(&b, form, "vectorField", "points");
    builder_text(&b, form->binary ? "%d\n(" : "%d\n(\n", cells->n_points);
    for (int i = 0; i < cells->n_points; i++) {
        const double *x = cells->x[i];
        if (!form->binary)
            builder_text(&b, "(%.17g %.17g %.17g)\n", x[0], x[1], x[2]);
        for (int d = 0; d < 3 && form->binary; d++)
            builder_real(&b, x[d], form->scalar_size);
    }
    builder_text(&b, ")");
    end(&b, folder, "points");
}

static void write_patches(const char *folder, const foam_form *form, const faces *f,
                          const char *const *patches) {
    file_builder b = {0};
    int n = 0, at = 0;
    while (patches[n])
        n++;
    while (at < f->n && f->face[at].neighbour >= 0)
        at++;
    begin(&b, form, "polyBoundaryMesh", "boundary");
    b.binary = 0;
    builder_text(&b, "%d\n(\n", n);
    for (int i = 0; i < n; i++) {
        char name[64] = "", type[64] = "";
        int used = 0, first = at;
        assert_int_equal(sscanf(patches[i], "%63s %63s %n", name, type, &used), 2);
        while (at < f->n && f->face[at].patch == i)
            at++;
        builder_text(&b,
                     "    %s\n    {\n        type %s;\n        nFaces %d;\n        startFace %d;\n"
                     "        %s\n    }\n",
                     name, type, at - first, first, patches[i] + used);
    }
    builder_text(&b, ")");
    end(&b, folder, "boundary");
}

void foam_build(const char *folder, const foam_cells *cells, const foam_form *form,
                const char *const *patches, foam_patch_of *patch_of) {
    faces f = {.n = 0};
    list_faces(cells, &f);
    join_faces(&f);
    find_patches(cells, &f, patch_of);
    write_points(folder, cells, form);
    write_faces(folder, form, &f);
    write_labels(folder, "owner", form, &f, 0);
    write_labels(folder, "neighbour", form, &f, 1);
    write_patches(folder, form, &f, patches);
    free(f.face);
}

/* ---- bricks --------------------------------------------------------------------------------- */

void foam_make_bricks(foam_cells *cells, int nx, int ny, int nz) {
    const int n[3] = {nx, ny, nz};
    memset(cells, 0, sizeof *cells);
    for (int k = 0; k <= nz; k++)
        for (int j = 0; j <= ny; j++)
            for (int i = 0; i <= nx; i++) {
                const int at[3] = {i, j, k};
                double *x = cells->x[cells->n_points];
                int is_inside = 1;
                for (int d = 0; d < 3; d++)
                    is_inside &= at[d] > 0 && at[d] < n[d];
                for (int d = 0; d < 3; d++)
                    x[d] = at[d] + (is_inside ? 0.25 * sin(7.0 * cells->n_points + d) : 0);
                cells->n_points++;
            }
    for (int k = 0; k < nz; k++)
        for (int j = 0; j < ny; j++)
            for (int i = 0; i < nx; i++) {
                const int a = (k * (ny + 1) + j) * (nx + 1) + i, up = (ny + 1) * (nx + 1);
                const int node[8] = {a,      a + 1,      a + nx + 2,      a + nx + 1,
                                     a + up, a + up + 1, a + up + nx + 2, a + up + nx + 1};
                memcpy(cells->node[cells->n_cells], node, sizeof node);
                cells->type[cells->n_cells++] = PLANISH_CELL_HEXAHEDRON;
            }
}

void foam_split_brick(foam_cells *cells, int i) {
    int *a = cells->node[i], *b = cells->node[cells->n_cells];
    const int h[8] = {a[0], a[1], a[2], a[3], a[4], a[5], a[6], a[7]};
    const int first[6] = {h[0], h[1], h[2], h[4], h[5], h[6]};
    const int second[6] = {h[0], h[2], h[3], h[4], h[6], h[7]};
    memcpy(a, first, sizeof first);
    memcpy(b, second, sizeof second);
    cells->type[i] = cells->type[cells->n_cells++] = PLANISH_CELL_WEDGE;
}
