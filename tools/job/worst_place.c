/* worst_place: what there is to know of the worst elements besides their radius ratios. */
#include "job/worst_place.h"

#include "geometry/angle.h"

#include <math.h>
#include <stdlib.h>

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

/** The tag of element's region, of any length; NULL without memory. */
static char *copy_tag(const planish_file *file, int64_t element) {
    char first[1];
    const int length = planish_file_element_region(file, element, first, sizeof first);
    char *tag = malloc(length > 0 ? (size_t)length + 1 : 1);
    if (tag && length > 0)
        planish_file_element_region(file, element, tag, (size_t)length + 1);
    else if (tag)
        tag[0] = '\0';
    return tag;
}

/** Room for the tags of all regions, each asked for once: that takes time. region: the file's, or
 *  NULL: it has none. 0, or -1 without memory. */
static int make_tags(const int32_t *region, int64_t n_elements, pl_worst *worst) {
    int32_t last = -1;
    for (int64_t i = 0; region && i < n_elements; i++)
        last = region[i] > last ? region[i] : last;
    worst->tag = calloc((size_t)last + 2, sizeof *worst->tag);
    worst->n_tags = worst->tag ? (int64_t)last + 1 : 0;
    return worst->tag ? 0 : -1;
}

static int find_region(const pl_job *job, const int32_t *region, pl_worst *worst,
                       pl_bad_element *bad) {
    if (!region || region[bad->element] < 0)
        return 0;
    char **tag = &worst->tag[region[bad->element]];
    if (!*tag)
        *tag = copy_tag(job->file, bad->element);
    bad->region = *tag && **tag ? *tag : NULL;
    return *tag ? 0 : -1;
}

/** Add a corner's part of the middle, in the file's columns. */
static void add_place(const pl_job *job, int64_t node, int columns, pl_bad_element *bad) {
    const int dim = job->mesh.dim;
    const double *at = &job->mesh.coordinates[node * dim];
    double xyz[3];
    if (columns > dim && planish_file_place(job->file, node, 1, at, xyz, NULL) == PLANISH_OK)
        at = xyz;
    for (int d = 0; d < columns; d++)
        bad->place[d] += at[d] / (dim + 1);
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
        bad->is_movable |=
            is_free[node] || (job->plan_info.n_sliding > 0 &&
                              (constraint == PLANISH_ON_PLANE || constraint == PLANISH_ON_LINE));
        add_place(job, node, columns, bad);
    }
    find_angles(dim, vertex, bad);
}

int pl_worst_place(const pl_job *job, pl_worst *worst) {
    const int32_t *region = planish_file_surface(job->file, NULL).region;
    uint8_t *is_free = malloc((size_t)job->mesh.n_nodes + 1);
    int status = is_free ? make_tags(region, job->mesh.n_elements, worst) : -1;
    if (!status)
        status = pl_job_get_free(job, is_free);
    for (int64_t i = 0; i < worst->n && !status; i++) {
        place(job, is_free, worst->columns, &worst->bad[i]);
        status = find_region(job, region, worst, &worst->bad[i]);
    }
    free(is_free);
    return status;
}
