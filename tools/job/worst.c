/* worst: the worst elements of a mesh, for lists and pictures. */
#include "job/worst.h"

#include "job/angles.h"
#include "terminal/message.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/** Larger is worse; an inverted element is worse than any other. */
static double badness(const pl_bad_element *element) {
    return element->ratio > 0 ? element->ratio : INFINITY;
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
        heap[i] = (pl_bad_element){.element = INT64_MAX, .ratio = 1e-300};
    for (int64_t i = 0; i < n_elements; i++) {
        const pl_bad_element element = {.element = i, .ratio = ratio[i]};
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

/** Prepare worst for the n worst of n_elements. */
static int begin(const pl_job *job, int64_t n, int64_t n_elements, pl_worst *worst) {
    worst->n = n < n_elements ? n : n_elements;
    worst->dim = pl_job_element_dim(job);
    worst->columns = job->file && planish_file_plane(job->file, NULL) ? 3 : job->mesh.dim;
    worst->bad = calloc((size_t)worst->n + 1, sizeof *worst->bad);
    return worst->bad ? 0 : pl_job_complain_memory(job, "the worst elements");
}

int pl_worst_select(const pl_job *job, int64_t n, pl_worst *worst) {
    planish_error error;
    const int64_t n_elements = job->mesh.n_elements;
    int status = begin(job, n, n_elements, worst);
    double *ratio = malloc(((size_t)n_elements + 1) * sizeof *ratio);
    if (!status && !ratio)
        status = pl_job_complain_memory(job, "the worst elements");
    else if (!status && pl_cells_measure_elements(job, ratio, &error))
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    else if (!status && worst->n > 0)
        select_worst(ratio, n_elements, worst);
    free(ratio);
    return status;
}

/** Find the n worst of cells; of each only which it is and its aspect ratio. */
static int select_cells(const pl_job *job, const pl_cells *cells, int64_t n, pl_worst *worst) {
    const int status = begin(job, n, cells->cells.n, worst);
    worst->is_aspect_ratio = 1;
    if (!status && worst->n > 0)
        select_worst(cells->aspect_ratio, cells->cells.n, worst);
    return status;
}

/* ---- what there is to know of them --------------------------------------------------------------
 */

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

/** Cells that elements are numbered by: all that the file has, those of the mesh, or NULL: all are
 *  simplices of order 1. */
static const planish_cells *cells_of(const pl_job *job, const pl_cells *cells) {
    return cells ? &cells->cells : job->mesh.cells;
}

/** Nodes of an element, as they are in the mesh. */
static const int32_t *nodes_of(const pl_job *job, const pl_cells *cells, int64_t element, int *n) {
    const planish_cells *of = cells_of(job, cells);
    *n = of ? (int)(of->offset[element + 1] - of->offset[element]) : job->mesh.dim + 1;
    return of ? of->node + of->offset[element] : job->mesh.elements + element * (job->mesh.dim + 1);
}

/** Fill in the numbers and the middle of an element, and its angles if it is one of the simplices.
 *  node [n_nodes] takes the numbers of its nodes. is_free [n_nodes of the mesh], or NULL: that is not
 *  known. */
static void place(const pl_job *job, const pl_cells *cells, const uint8_t *is_free, int columns,
                  int64_t *node, pl_bad_element *bad) {
    const int dim = job->mesh.dim, element_dim = pl_job_element_dim(job);
    const double *vertex[4] = {NULL};
    const planish_cells *of = cells_of(job, cells);
    int n, n_present = 0, may_move = 0;
    const int32_t *nodes = nodes_of(job, cells, bad->element, &n);
    for (int k = 0; k < n; k++)
        n_present += nodes[k] >= 0;
    bad->number = planish_file_element_number(job->file, bad->element);
    bad->type = of         ? (planish_cell_type)of->type[bad->element]
                : dim == 3 ? PLANISH_CELL_TETRAHEDRON
                           : PLANISH_CELL_TRIANGLE;
    bad->node = node;
    bad->is_movable = is_free ? 0 : -1;
    for (int k = 0; k < n; k++) {
        if (nodes[k] < 0)
            continue;
        const uint8_t constraint = job->constraint[nodes[k]];
        const double *at = &job->mesh.coordinates[(int64_t)nodes[k] * dim];
        double xyz[3];
        if (k <= element_dim)
            vertex[k] = at;
        node[bad->n_nodes++] = planish_file_node_number(job->file, nodes[k]);
        if (is_free && (is_free[nodes[k]] ||
                        (job->plan_info.n_sliding > 0 && constraint > PLANISH_CONSTRAINT_FIXED))) {
            const uint8_t by = job->held_in_run ? job->held_in_run[nodes[k]] : 0;
            bad->is_movable = 1;
            may_move |= by == PLANISH_HELD_BY_NONE;
            if (bad->held_by == PLANISH_HELD_BY_NONE || by < bad->held_by)
                bad->held_by = (planish_held_by)by;
        }
        /* Its part of the middle, in the file's columns. */
        if (columns > dim &&
            planish_file_space_coordinates(job->file, nodes[k], 1, at, xyz, NULL) == 0)
            at = xyz;
        for (int d = 0; d < columns; d++)
            bad->place[d] += at[d] / n_present;
    }
    if (may_move)
        bad->held_by = PLANISH_HELD_BY_NONE;
    bad->smallest_angle_deg = bad->largest_angle_deg = NAN;
    if (!cells) {
        const pl_angles angles =
            job->is_surface ? pl_angles_find_in_space(vertex) : pl_angles_find(dim, vertex);
        bad->smallest_angle_deg = angles.smallest;
        bad->largest_angle_deg = angles.largest;
    }
}

/** Find the n worst elements with all that there is to know of them. */
static int find_worst(const pl_job *job, const pl_cells *cells, int64_t n, pl_worst *worst) {
    enum { MOST_NODES = 27 };
    const int32_t *region = planish_file_surface(job->file, NULL).region;
    const int64_t most_nodes = cells_of(job, cells) ? MOST_NODES : job->mesh.dim + 1;
    const int64_t n_elements = planish_file_mesh(job->file).n_elements;
    int32_t last = -1;
    int status = cells ? select_cells(job, cells, n, worst) : pl_worst_select(job, n, worst);
    if (status)
        return status;
    for (int64_t i = 0; region && i < n_elements; i++)
        last = region[i] > last ? region[i] : last;
    uint8_t *is_free = malloc((size_t)job->mesh.n_nodes + 1);
    worst->node = malloc((size_t)(worst->n * most_nodes + 1) * sizeof *worst->node);
    worst->tag = calloc((size_t)last + 2, sizeof *worst->tag);
    worst->n_tags = worst->tag ? (int64_t)last + 1 : 0;
    if (!is_free || !worst->node || !worst->tag)
        status = -1;
    else if (job->mesh.n_elements > 0)
        status = pl_job_get_free(job, is_free);
    for (int64_t i = 0; i < worst->n && !status; i++) {
        place(job, cells, job->mesh.n_elements > 0 ? is_free : NULL, worst->columns,
              worst->node + i * most_nodes, &worst->bad[i]);
        status = find_region(job, region, worst, &worst->bad[i]);
    }
    free(is_free);
    return status < 0 ? pl_job_complain_memory(job, "the worst elements") : status;
}

int pl_worst_find_asked(const pl_job *job, const pl_cells *cells, pl_worst *worst) {
    const pl_arguments *arguments = job->arguments;
    int64_t n = arguments->n_worst;
    if (n == 0 && (arguments->json || arguments->report))
        n = PL_USUAL_WORST;
    return n > 0 ? find_worst(job, cells && cells->has_others ? cells : NULL, n, worst) : 0;
}

void pl_worst_free(pl_worst *worst) {
    for (int64_t i = 0; i < worst->n_tags; i++)
        free(worst->tag[i]);
    free(worst->tag);
    free(worst->node);
    free(worst->bad);
    *worst = (pl_worst){0};
}
