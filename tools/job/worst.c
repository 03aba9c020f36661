/* worst: the worst elements of a mesh, for lists and pictures. */
#include "job/worst.h"

#include "terminal/message.h"

#include "geometry/angle.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/** Larger is worse; an inverted element is worse than any other. */
static double badness(const pl_bad_element *element) {
    return element->radius_ratio > 0 ? element->radius_ratio : INFINITY;
}

static int is_worse(const pl_bad_element *a, const pl_bad_element *b) {
    const double of_a = badness(a), of_b = badness(b);
    return of_a > of_b || (of_a == of_b && a->element < b->element);
}

static int compare(const void *a, const void *b) {
    return is_worse(a, b) ? -1 : is_worse(b, a);
}

/** The n worst of ratio [n_elements], in a heap whose first is the best of them. */
static void select_worst(const double *ratio, int64_t n_elements, pl_worst *worst) {
    pl_bad_element *heap = worst->bad;
    const int64_t n = worst->n;
    for (int64_t i = 0; i < n; i++) /* elements that any other replaces */
        heap[i] = (pl_bad_element){.element = INT64_MAX, .radius_ratio = 1e-300};
    for (int64_t i = 0; i < n_elements; i++) {
        const pl_bad_element element = {.element = i, .radius_ratio = ratio[i]};
        worst->n_inverted += ratio[i] == 0;
        if (!is_worse(&element, &heap[0]))
            continue;
        int64_t at = 0; /* it takes the place of the best, and sinks to its own */
        for (;;) {
            int64_t child = 2 * at + 1;
            if (child + 1 < n && is_worse(&heap[child], &heap[child + 1]))
                child++;
            if (child >= n || !is_worse(&element, &heap[child]))
                break;
            heap[at] = heap[child];
            at = child;
        }
        heap[at] = element;
    }
    qsort(heap, (size_t)n, sizeof *heap, compare);
}

int pl_worst_select(const pl_job *job, int64_t n, pl_worst *worst) {
    planish_error error;
    const int64_t n_elements = job->mesh.n_elements;
    worst->n = n < n_elements ? n : n_elements;
    worst->dim = job->mesh.dim;
    worst->columns = job->file && planish_file_plane(job->file, NULL) ? 3 : job->mesh.dim;
    worst->bad = calloc((size_t)worst->n + 1, sizeof *worst->bad);
    double *ratio = malloc(((size_t)n_elements + 1) * sizeof *ratio);
    int status = 0;
    if (!worst->bad || !ratio)
        status = pl_job_complain_memory(job, "the worst elements");
    else if (job->engine->measure_elements(job, ratio, &error))
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    else if (worst->n > 0)
        select_worst(ratio, n_elements, worst);
    free(ratio);
    return status;
}

/* ---- what there is to know of them --------------------------------------------------------------
 */

static const double DEGREES = 57.295779513082320877; /* of a radian */

/** The angles, which do not depend on the sign of the measure. Edges are scaled to about 1, so that
 *  nothing overflows. */
static void find_angles(int dim, const double *const vertex[], pl_bad_element *bad) {
    double edges[3][3] = {{0}}, largest = 0;
    pl_edges(dim, vertex, edges);
    for (int i = 0; i < dim; i++)
        for (int d = 0; d < dim; d++)
            largest = fmax(largest, fabs(edges[i][d]));
    for (int i = 0; i < dim; i++)
        for (int d = 0; d < dim; d++)
            edges[i][d] /= largest;
    const pl_shape shape = pl_shape_of_edges(dim, edges);
    const int is_known = shape.determinant != 0 && shape.smallest_cosine <= shape.largest_cosine;
    bad->smallest_angle_deg = is_known ? pl_smallest_angle(&shape) * DEGREES : NAN;
    bad->largest_angle_deg = is_known ? pl_largest_angle(&shape) * DEGREES : NAN;
}

/** Find the tag of the region of an element; region: the file's regions, or NULL. Each tag is asked
 *  for once: that takes time. 0, or -1 without memory. */
static int find_region(const pl_job *job, const int32_t *region, pl_worst *worst,
                       pl_bad_element *bad) {
    char first[1];
    if (!region || region[bad->element] < 0)
        return 0;
    char **tag = &worst->tag[region[bad->element]];
    if (!*tag) {
        const int length =
            planish_file_element_region(job->file, bad->element, first, sizeof first);
        *tag = calloc(length > 0 ? (size_t)length + 1 : 1, 1);
        if (!*tag)
            return -1;
        if (length > 0)
            planish_file_element_region(job->file, bad->element, *tag, (size_t)length + 1);
    }
    bad->region = **tag ? *tag : NULL;
    return 0;
}

static void place(const pl_job *job, const uint8_t *is_free, int columns, pl_bad_element *bad) {
    const int dim = job->mesh.dim, corners = dim + 1;
    const int32_t *nodes = &job->mesh.elements[bad->element * corners];
    const double *vertex[4];
    bad->number = planish_file_element_number(job->file, bad->element);
    for (int k = 0; k < corners; k++) {
        const int64_t node = nodes[k];
        const uint8_t constraint = job->constraint[node];
        vertex[k] = &job->mesh.coordinates[node * dim];
        bad->node[k] = planish_file_node_number(job->file, node);
        bad->is_movable |= is_free[node] || (job->plan_info.n_sliding > 0 &&
                                             (constraint == PLANISH_CONSTRAINT_ON_PLANE ||
                                              constraint == PLANISH_CONSTRAINT_ON_LINE));
        /* Its part of the middle, in the file's columns. */
        const double *at = vertex[k];
        double xyz[3];
        if (columns > dim && planish_file_space_coordinates(job->file, node, 1, at, xyz, NULL) == 0)
            at = xyz;
        for (int d = 0; d < columns; d++)
            bad->place[d] += at[d] / corners;
    }
    find_angles(dim, vertex, bad);
}

int pl_worst_find(const pl_job *job, int64_t n, pl_worst *worst) {
    const int32_t *region = planish_file_surface(job->file, NULL).region;
    int32_t last = -1;
    int status = pl_worst_select(job, n, worst);
    if (status)
        return status;
    for (int64_t i = 0; region && i < job->mesh.n_elements; i++)
        last = region[i] > last ? region[i] : last;
    uint8_t *is_free = malloc((size_t)job->mesh.n_nodes + 1);
    worst->tag = calloc((size_t)last + 2, sizeof *worst->tag);
    worst->n_tags = worst->tag ? (int64_t)last + 1 : 0;
    status = is_free && worst->tag ? pl_job_get_free(job, is_free) : -1;
    for (int64_t i = 0; i < worst->n && !status; i++) {
        place(job, is_free, worst->columns, &worst->bad[i]);
        status = find_region(job, region, worst, &worst->bad[i]);
    }
    free(is_free);
    return status < 0 ? pl_job_complain_memory(job, "the worst elements") : status;
}

int pl_worst_find_asked(const pl_job *job, pl_worst *worst) {
    const pl_arguments *arguments = job->arguments;
    int64_t n = arguments->n_worst;
    if (n == 0 && (arguments->json || arguments->report))
        n = PL_USUAL_WORST;
    return n > 0 ? pl_worst_find(job, n, worst) : 0;
}

void pl_worst_free(pl_worst *worst) {
    for (int64_t i = 0; i < worst->n_tags; i++)
        free(worst->tag[i]);
    free(worst->tag);
    free(worst->bad);
    *worst = (pl_worst){0};
}
