/* worst: the worst elements of a mesh, for lists and pictures. */
#include "job/worst.h"

#include "job/worst_place.h"

#include "terminal/message.h"

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

/** Put element in the place of heap [n]'s first, which is the best of them, and find its place. */
static void replace_best(pl_bad_element *heap, int64_t n, pl_bad_element element) {
    int64_t at = 0;
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

/** The n worst of ratio [n_elements], in a heap whose first is the best of them. */
static void select_worst(const double *ratio, int64_t n_elements, pl_worst *worst) {
    pl_bad_element *heap = worst->bad;
    const int64_t n = worst->n;
    for (int64_t i = 0; i < n; i++) /* elements that any other replaces */
        heap[i] = (pl_bad_element){.element = INT64_MAX, .radius_ratio = 1e-300};
    for (int64_t i = 0; i < n_elements; i++) {
        const pl_bad_element element = {.element = i, .radius_ratio = ratio[i]};
        worst->n_inverted += ratio[i] == 0;
        if (is_worse(&element, &heap[0]))
            replace_best(heap, n, element);
    }
    qsort(heap, (size_t)n, sizeof *heap, compare);
}

static int complain_memory(const pl_job *job) {
    return pl_complain(PL_EXIT_FAILED, "%s: out of memory for the worst elements",
                       job->arguments->input);
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
        status = complain_memory(job);
    else if (job->engine->measure_elements(job, ratio, &error))
        status = pl_job_complain(job, PL_EXIT_FAILED, &error);
    else if (worst->n > 0)
        select_worst(ratio, n_elements, worst);
    free(ratio);
    return status;
}

int pl_worst_find(const pl_job *job, int64_t n, pl_worst *worst) {
    int status = pl_worst_select(job, n, worst);
    if (!status)
        status = pl_worst_place(job, worst);
    return status < 0 ? complain_memory(job) : status;
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
