/* unjoined: quadrilateral faces against two triangles, where elements do not share faces.
 *
 * Such faces are on the boundary of the mesh by its connectivity, so that only faces without a free node are
 * compared: about n^(2/3) of n.
 */
#include "job/unjoined.h"

#include "terminal/message.h"

#include "geometry/cell.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CORNERS = 4 };

/** A face of an element: its corners, ascending. A triangle has -1 in front, so triangles are sorted first. */
typedef struct face {
    int32_t node[MOST_CORNERS];
} face;

static int compare_faces(const void *a, const void *b) {
    const face *p = a, *q = b;
    for (int i = 0; i < MOST_CORNERS; i++)
        if (p->node[i] != q->node[i])
            return p->node[i] < q->node[i] ? -1 : 1;
    return 0;
}

static void insert_node(face *f, int at, int32_t node) {
    for (; at + 1 < MOST_CORNERS && f->node[at + 1] < node; at++)
        f->node[at] = f->node[at + 1];
    f->node[at] = node;
}

/** Make face k of an element with those corners. Returns whether none of its nodes is free. */
static int make_face(const pl_cell_shape *shape, const int32_t *corner, int k,
                     const uint8_t *is_free, face *made) {
    *made = (face){{-1, -1, -1, -1}};
    for (int j = 0; j < MOST_CORNERS && shape->facet[k][j] >= 0; j++) {
        const int32_t node = corner[shape->facet[k][j]];
        if (is_free[node])
            return 0;
        insert_node(made, MOST_CORNERS - 1 - j, node);
    }
    return 1;
}

/** List the faces of solid elements that have no free node, or count them where list is NULL. */
static int64_t list_faces(const pl_job *job, const uint8_t *is_free, face *list) {
    const planish_cells *cells = job->mesh.cells;
    int64_t n = 0;
    for (int64_t i = 0; i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        face made;
        for (int k = 0; type && type->shape->dim == 3 && k < type->shape->n_facets; k++)
            if (make_face(type->shape, cells->node + cells->offset[i], k, is_free, &made)) {
                if (list)
                    list[n] = made;
                n++;
            }
    }
    return n;
}

/** Sort the faces, and remove those that two elements share. Returns how many are left. */
static int64_t keep_single(face *list, int64_t n) {
    int64_t n_kept = 0;
    qsort(list, (size_t)n, sizeof *list, compare_faces);
    for (int64_t i = 0, next; i < n; i = next) {
        for (next = i + 1; next < n && compare_faces(&list[i], &list[next]) == 0;)
            next++;
        if (next == i + 1)
            list[n_kept++] = list[i];
    }
    return n_kept;
}

/** Count the triangles [n] that have three corners of a quadrilateral. */
static int count_triangles(const face *triangle, int64_t n, const face *quadrilateral) {
    int found = 0;
    for (int leave = 0; leave < MOST_CORNERS; leave++) {
        face key = {{-1}};
        for (int j = 0, at = 1; j < MOST_CORNERS; j++)
            if (j != leave)
                key.node[at++] = quadrilateral->node[j];
        found += bsearch(&key, triangle, (size_t)n, sizeof key, compare_faces) != NULL;
    }
    return found;
}

/** Count the faces [n] that are against two triangles, and their nodes; mark [n_nodes] is all 0. */
static void count_unjoined(pl_job *job, const face *list, int64_t n, uint8_t *mark) {
    int64_t n_triangles = 0;
    while (n_triangles < n && list[n_triangles].node[0] < 0)
        n_triangles++;
    for (int64_t i = n_triangles; n_triangles > 0 && i < n; i++) {
        if (count_triangles(list, n_triangles, &list[i]) < 2)
            continue;
        job->n_unjoined_faces++;
        for (int j = 0; j < MOST_CORNERS; j++) {
            job->n_unjoined_nodes += !mark[list[i].node[j]];
            mark[list[i].node[j]] = 1;
        }
    }
}

/** Whether the mesh may have such faces: elements with quadrilateral faces and others with triangles. */
static int may_have(const pl_job *job) {
    const planish_cells *cells = job->mesh.cells;
    int has_quadrilaterals = 0, has_triangles = 0;
    for (int64_t i = 0; cells && i < cells->n; i++) {
        const pl_cell_type *type = pl_cell_type_of(cells->type[i]);
        const int n_corners = type && type->shape->dim == 3 ? type->shape->n_corners : 0;
        has_quadrilaterals |= n_corners > 4;
        has_triangles |= n_corners >= 4 && n_corners < 8;
    }
    return has_quadrilaterals && has_triangles;
}

int pl_unjoined_count(pl_job *job) {
    if (!job->file || job->is_surface || pl_job_lacks_types(job) || !may_have(job))
        return 0;
    const size_t n_nodes = (size_t)job->mesh.n_nodes + 1;
    uint8_t *is_free = malloc(n_nodes), *mark = calloc(n_nodes, 1);
    int status = is_free && mark ? pl_job_get_free(job, is_free)
                                 : pl_job_complain_memory(job, "the faces of elements");
    if (!status) {
        const int64_t n = list_faces(job, is_free, NULL);
        face *list = malloc(((size_t)n + 1) * sizeof *list);
        if (list) {
            list_faces(job, is_free, list);
            count_unjoined(job, list, keep_single(list, n), mark);
        } else {
            status = pl_job_complain_memory(job, "the faces of elements");
        }
        free(list);
    }
    free(is_free);
    free(mark);
    return status;
}

void pl_unjoined_note(FILE *stream, const pl_job *job) {
    const int64_t n = job->n_unjoined_faces;
    if (n > 0)
        pl_note(stream,
                "%" PRId64 " quadrilateral %s against two triangles each: their %" PRId64
                " nodes stay as on the boundary; pyramids between would join the elements",
                n, n == 1 ? "face lies" : "faces lie", job->n_unjoined_nodes);
}
