/* layers: elements thin in layers, which smoothing would make regular: held, or warned of. */
#include "job/layers.h"

#include "terminal/message.h"

#include "base/clock.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* What is said of a mesh begins with so many of its elements, and with so many at least: of bad
 * meshes one in a hundred looks like layers by chance. */
static const double MANY = 0.02;
enum { MANY_AT_LEAST = 100 };
/* Thin elements have radius ratios above this, or are inverted: about 2.3 those of triangles that
 * just count, more those of tetrahedra. Only a mesh with so many of them is looked at: their rows
 * go on with as many better ones, or more. */
static const double RATIO_OF_THIN = 2.5, MANY_OF_THIN = 0.01;
/* Groups are made of layers if so much of them is, name the layers if they hold so much, but not if
 * they leave less than the rest of the mesh. */
static const double OF_GROUP = 0.8, OF_LAYERS = 0.9, OF_MESH = 0.95;
enum { MOST_TAGS = 64, MOST_NAMED = 4, TAG_SIZE = 64 };

/* ---- groups that are made of layers --------------------------------------------------------- */

/** A group of the file, by its tag. */
typedef struct group {
    char tag[TAG_SIZE];
    int64_t n, n_loose; /* elements, thin ones that move */
} group;

typedef struct groups {
    group group[MOST_TAGS];
    int n;
    int is_useless; /* there are more, or some have no tag */
} groups;

/** Index of the group of an element, made if it is new; -1 if there is none. */
static int group_of(const pl_job *job, int64_t element, groups *g) {
    char tag[TAG_SIZE];
    const int length = planish_file_element_region(job->file, element, tag, sizeof tag);
    int i = 0;
    if (length <= 0 || length >= TAG_SIZE || strpbrk(tag, "'\n"))
        return -1;
    while (i < g->n && strcmp(g->group[i].tag, tag) != 0)
        i++;
    if (i == MOST_TAGS)
        return -1;
    if (i == g->n) {
        g->group[g->n++] = (group){.n = 0};
        memcpy(g->group[i].tag, tag, sizeof tag);
    }
    return i;
}

/** Append " --fix TAG" to text; whether there was room. */
static int add_option(char *text, size_t size, const char *tag) {
    const char *plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-:.,+";
    const char *quote = tag[strspn(tag, plain)] ? "'" : "";
    const size_t used = strlen(text);
    const int more =
        snprintf(text + used, size - used, "%s--fix %s%s%s", used ? " " : "", quote, tag, quote);
    return used + (size_t)more < size;
}

/** Find the options that hold the layers by groups: job->layers.fix, or "". is_loose [n_elements].
 */
static int find_groups(pl_job *job, const uint8_t *is_loose) {
    const int32_t *region = planish_file_surface(job->file, NULL).region;
    const int64_t n_elements = job->mesh.n_elements;
    pl_layers *layers = &job->layers;
    groups g = {.n = 0};
    int32_t last = 0;
    int64_t n_held = 0, n_in_groups = 0;
    int n = 0;
    for (int64_t i = 0; region && i < n_elements; i++)
        last = region[i] > last ? region[i] : last;
    int *group_of_region = malloc(((size_t)last + 1) * sizeof *group_of_region);
    if (!group_of_region)
        return pl_job_complain_memory(job, "values of elements");
    for (int32_t i = 0; i <= last; i++)
        group_of_region[i] = -1;
    /* Elements of one region are in one group. */
    for (int64_t i = 0; region && i < n_elements && !g.is_useless; i++) {
        int *index = &group_of_region[region[i]];
        if (*index < 0)
            *index = group_of(job, i, &g);
        g.is_useless = *index < 0;
        if (!g.is_useless) {
            g.group[*index].n++;
            g.group[*index].n_loose += is_loose[i];
        }
    }
    free(group_of_region);
    int fits = region && !g.is_useless;
    for (int i = 0; i < g.n && fits; i++)
        if ((double)g.group[i].n_loose >= OF_GROUP * (double)g.group[i].n) {
            n_held += g.group[i].n_loose;
            n_in_groups += g.group[i].n;
            fits = ++n <= MOST_NAMED && add_option(layers->fix, sizeof layers->fix, g.group[i].tag);
        }
    if (!fits || (double)n_held < OF_LAYERS * (double)layers->n_loose ||
        (double)n_in_groups > OF_MESH * (double)n_elements)
        layers->fix[0] = '\0';
    return 0;
}

/* ---- counting ------------------------------------------------------------------------------- */

/** Remove the marks of elements without a node that moves. */
static int keep_loose(pl_job *job, uint8_t *is_layer) {
    int corners;
    uint8_t *moves = malloc((size_t)job->mesh.n_nodes + 1);
    if (!moves)
        return pl_job_complain_memory(job, "values of elements");
    const int status = pl_job_get_free(job, moves);
    for (int64_t i = 0; !status && i < job->mesh.n_nodes; i++)
        moves[i] |= job->constraint[i] > PLANISH_CONSTRAINT_FIXED;
    for (int64_t i = 0; !status && i < job->mesh.n_elements; i++) {
        int is_loose = 0;
        const int32_t *corner = pl_job_corners(job, i, &corners);
        for (int j = 0; is_layer[i] && j < corners; j++)
            is_loose |= moves[corner[j]];
        is_layer[i] = (uint8_t)is_loose;
        job->layers.n_loose += is_loose;
    }
    free(moves);
    return status;
}

/** Copy the marks of elements whose heights are told. */
static int take_marks(pl_job *job, const uint8_t *is_layer) {
    planish_mesh mesh;
    planish_cells cells;
    const int status = pl_job_layer_mesh(job, &cells, &mesh);
    if (status)
        return status;
    job->wanted.is_layer = malloc((size_t)mesh.n_elements + 1);
    if (!job->wanted.is_layer)
        return pl_job_complain_memory(job, "values of elements");
    memcpy(job->wanted.is_layer, is_layer, (size_t)mesh.n_elements);
    return 0;
}

int pl_layers_are_many(int64_t n, int64_t n_elements) {
    return n >= MANY_AT_LEAST && (double)n >= MANY * (double)n_elements;
}

/** Elements of the mesh; that of the command quality has the simplices alone. */
static int64_t count_elements(const pl_job *job) {
    return job->file ? planish_file_mesh(job->file).n_elements : job->mesh.n_elements;
}

/** Elements of layers that are told of: those that move; of layers that are given up all. */
static int64_t count_told(const pl_job *job) {
    return job->layers.is_tangled ? job->layers.n : job->layers.n_loose;
}

static int are_many(const pl_job *job) {
    return pl_layers_are_many(count_told(job), count_elements(job));
}

int pl_layers_count(pl_job *job, const planish_quality *quality) {
    const double begin = pl_seconds();
    uint8_t *is_layer = NULL;
    int64_t n_thin = quality->n_inverted; /* none of these is in the histogram */
    for (int i = 0; i < PLANISH_HISTOGRAM_BINS; i++)
        n_thin += quality->histogram_edges[i] >= RATIO_OF_THIN ? quality->histogram_counts[i] : 0;
    const int may_have = job->file_info.n_other_elements > 0 || pl_job_lacks_types(job) ||
                         (double)n_thin >= MANY_OF_THIN * (double)quality->n_elements;
    const int is_like = job->like.place && !pl_like_has_sizes(&job->like); /* targets keep layers */
    if (job->arguments->layers != PL_LAYERS_BY_TYPE || !job->file || job->is_surface || is_like ||
        (!may_have && !job->is_layer))
        return 0;
    int status = 0;
    if (job->is_layer) { /* known from reading */
        is_layer = job->is_layer;
        job->is_layer = NULL;
    } else {
        status = pl_job_find_layers(job, &is_layer, &job->layers.n);
    }
    /* What becomes of heights is told: of layers that may move, and of all where meshes are compared. */
    if (!status && job->layers.n > 0 && job->arguments->command == PL_COMMAND_COMPARE)
        status = take_marks(job, is_layer);
    if (!status && job->layers.n > 0)
        status = keep_loose(job, is_layer);
    if (!status && are_many(job))
        status = find_groups(job, is_layer);
    if (!status && are_many(job) && job->layers.n_held == 0 &&
        job->arguments->command == PL_COMMAND_SMOOTH)
        status = take_marks(job, is_layer);
    free(is_layer);
    job->shape_seconds += pl_seconds() - begin;
    return status;
}

/* ---- saying --------------------------------------------------------------------------------- */

/** Write "N elements (P %)" to text. */
static void put_count(const pl_job *job, int64_t n, char *text, size_t size) {
    const int64_t of = count_elements(job) + job->file_info.n_other_elements;
    const double percent = of > 0 ? 100 * (double)n / (double)of : 0;
    if (n > 0 && percent < 0.1)
        snprintf(text, size, "%" PRId64 " elements (< 0.1 %%)", n);
    else if (percent < 9.95)
        snprintf(text, size, "%" PRId64 " elements (%.2g %%)", n, percent);
    else /* in full only if it is all */
        snprintf(text, size, "%" PRId64 " elements (%.0f %%)", n,
                 n < of && percent > 99 ? 99 : percent);
}

/** Say how many elements are held or kept by default. */
static void print_default(FILE *stream, const pl_job *job) {
    const pl_layers *layers = &job->layers;
    const int64_t n_nodes = job->held.n[PL_CAUSE_LAYERS];
    char count[64];
    put_count(job, layers->n_kept + layers->n_held, count, sizeof count); /* one of these is 0 */
    if (layers->n_kept > 0)
        pl_note(stream,
                "%s are thin in layers, and keep their heights; --layers hold holds their nodes",
                count);
    else if (layers->n_held > 0 && n_nodes > 0)
        pl_note(stream,
                "%s are thin in layers: %" PRId64 " %s held there%s%s; --layers ignore "
                "lets them move",
                count, n_nodes, n_nodes == 1 ? "node is" : "nodes are",
                layers->not_kept[0] ? ", as heights cannot be kept with " : "", layers->not_kept);
}

void pl_layers_print(FILE *stream, const pl_job *job) {
    const pl_layers *layers = &job->layers;
    const pl_layers_asked asked = job->arguments->layers;
    char count[64];
    if (asked == PL_LAYERS_HELD || asked == PL_LAYERS_KEPT) {
        put_count(job, layers->n, count, sizeof count);
        pl_note(stream, "%s are thin in layers, and %s", count,
                asked == PL_LAYERS_KEPT ? "keep their heights" : "held");
        return;
    }
    print_default(stream, job);
    if (!are_many(job))
        return;
    put_count(job, count_told(job), count, sizeof count);
    if (layers->is_tangled)
        pl_note(stream,
                "%s are thin in layers (did a wall move?): --layers keep keeps their heights",
                count);
    else if (layers->n_held == 0 && layers->n_kept == 0)
        pl_note(stream, "%s are thin in layers (a boundary layer?): %s keeps them", count,
                layers->fix[0] ? layers->fix : "--fix-layers");
}
