/* entities: Gmsh's elementary entities of one physical group, which count as regions. */
#include "job/entities.h"

#include "job/held.h"
#include "terminal/message.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

enum { TAG_SIZE = 128 }; /* Gmsh's names have at most 127 bytes: longer ones are cut */

/** A region, and the tag of its first element: the name or number of a physical group. */
typedef struct tagged {
    const char *tag;
    int32_t region;
} tagged;

static int compare_tags(const void *a, const void *b) {
    const tagged *p = a, *q = b;
    const int order = strcmp(p->tag, q->tag);
    return order ? order : (p->region > q->region) - (p->region < q->region);
}

/** Return the bytes that the tag of an element's region takes, cut if it is long. */
static size_t tag_size(const pl_job *job, int64_t element) {
    const size_t size = (size_t)planish_file_element_region(job->file, element, NULL, 0) + 1;
    return size < TAG_SIZE ? size : TAG_SIZE;
}

/** Find the first elements of regions: element [n_regions], -1 of those that have none. Returns the bytes that
 *  their tags take. */
static size_t find_first(const pl_job *job, const int32_t *region, int32_t n_regions,
                         int64_t *element) {
    size_t size = 0;
    for (int32_t i = 0; i < n_regions; i++)
        element[i] = -1;
    for (int64_t i = 0; i < job->mesh.n_elements; i++)
        if (element[region[i]] < 0) {
            element[region[i]] = i;
            size += tag_size(job, i);
        }
    return size;
}

/** List the regions that have elements: list [n_regions], their tags in text. Returns how many there are. */
static int32_t list_tags(const pl_job *job, const int64_t *element, int32_t n_regions, char *text,
                         tagged *list) {
    int32_t n = 0;
    for (int32_t i = 0; i < n_regions; i++) {
        if (element[i] < 0)
            continue;
        const size_t size = tag_size(job, element[i]);
        planish_file_element_region(job->file, element[i], text, size);
        list[n++] = (tagged){text, i};
        text += size;
    }
    return n;
}

/** Fill group [n_regions] with one number for all regions of a tag. Returns whether any regions share one, or
 *  -1: there is no memory. */
static int group_regions(const pl_job *job, const int32_t *region, int32_t n_regions,
                         int32_t *group) {
    int64_t *element = malloc(((size_t)n_regions + 1) * sizeof *element);
    tagged *list = malloc(((size_t)n_regions + 1) * sizeof *list);
    const size_t size = element ? find_first(job, region, n_regions, element) : 0;
    char *text = malloc(size + 1);
    const int has_memory = element && list && text;
    int is_shared = 0;
    const int32_t n = has_memory ? list_tags(job, element, n_regions, text, list) : 0;
    if (n > 0)
        qsort(list, (size_t)n, sizeof *list, compare_tags);
    for (int32_t i = 0, first = 0; i < n; i++) {
        if (!list[i].tag[0] || strcmp(list[i].tag, list[first].tag) != 0)
            first = i;
        is_shared |= first < i;
        group[list[i].region] = first;
    }
    free(element);
    free(list);
    free(text);
    return has_memory ? is_shared : -1;
}

/** Mark the corners between regions: bit 0 between those of one group, bit 1 between others. first and mark
 *  [n_nodes]. */
static void mark_between(const pl_job *job, const int32_t *region, const int32_t *group,
                         int32_t *first, uint8_t *mark) {
    for (int64_t i = 0; i < job->mesh.n_nodes; i++)
        first[i] = -1;
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        int n_corners;
        const int32_t *corner = pl_job_corners(job, i, &n_corners);
        for (int j = 0; j < n_corners; j++) {
            int32_t *of = &first[corner[j]];
            if (*of < 0)
                *of = region[i];
            else if (*of != region[i])
                mark[corner[j]] |= group[*of] == group[region[i]] ? 1 : 2;
        }
    }
}

/** Count the marked nodes that nothing else holds. */
static int count_held(pl_job *job, const uint8_t *mark) {
    uint16_t *bits;
    const int status = pl_held_find(job, &bits);
    for (int64_t i = 0; bits && i < job->mesh.n_nodes; i++)
        job->n_between_entities += mark[i] == 1 && bits[i] == 1 << PL_CAUSE_INTERFACE;
    free(bits);
    return status;
}

int pl_entities_count(pl_job *job) {
    const char *const *array = pl_job_region_arrays(job);
    const int32_t *region = job->file ? planish_file_surface(job->file, NULL).region : NULL;
    int32_t n_regions = 0;
    if (!region || strcmp(job->file_info.format, "gmsh") != 0 || job->arguments->ignore_regions ||
        array[0] || pl_job_lacks_types(job))
        return 0;
    for (int64_t i = 0; i < job->mesh.n_elements; i++)
        n_regions = region[i] >= n_regions ? region[i] + 1 : n_regions;
    const size_t n = (size_t)job->mesh.n_nodes + 1;
    int32_t *group = malloc(((size_t)n_regions + 1) * sizeof *group);
    int32_t *first = malloc(n * sizeof *first);
    uint8_t *mark = calloc(n, 1);
    int status = 0;
    const int is_shared =
        group && first && mark ? group_regions(job, region, n_regions, group) : -1;
    if (is_shared < 0)
        status = pl_job_complain_memory(job, "the regions of nodes");
    if (is_shared > 0) {
        mark_between(job, region, group, first, mark);
        status = count_held(job, mark);
    }
    free(group);
    free(first);
    free(mark);
    return status;
}

void pl_entities_note(FILE *stream, const pl_job *job) {
    const int64_t n = job->n_between_entities;
    if (n > 0)
        pl_note(stream,
                "%" PRId64 " %s held between elementary entities of one physical group; --regions "
                "none lets nodes between regions move",
                n, n == 1 ? "node is" : "nodes are");
}
