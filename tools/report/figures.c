/* figures: what a page reads from the JSON of a run. */
#include "report/figures.h"

#include "base/system.h"

#include <math.h>
#include <string.h>
#include <stddef.h>

/* Small enough for sums of such numbers, and their quotients by what is not next to nothing. */
static const double LARGEST = 1e200;

static double value_of(const cJSON *item) {
    return cJSON_IsNumber(item) && fabs(item->valuedouble) < LARGEST ? item->valuedouble : NAN;
}

static int is_quality(const cJSON *object) {
    return cJSON_IsObject(object) && isfinite(pl_figure(object, "inverted")) &&
           cJSON_IsObject(cJSON_GetObjectItemCaseSensitive(object, "histogram"));
}

/** Whether object is the quality of elements of every type. */
static int is_quality_of_types(const cJSON *object) {
    return cJSON_IsObject(object) && isfinite(pl_figure(object, "inverted")) &&
           cJSON_IsObject(cJSON_GetObjectItemCaseSensitive(object, "counts"));
}

const char *pl_figures_find(const cJSON *result, pl_figures *figures) {
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(result, "mesh");
    const cJSON *before = cJSON_GetObjectItemCaseSensitive(result, "before");
    const cJSON *after = cJSON_GetObjectItemCaseSensitive(result, "after");
    const cJSON *quality = cJSON_GetObjectItemCaseSensitive(result, "quality");
    const cJSON *objective = cJSON_GetObjectItemCaseSensitive(result, "objective");
    const char *target = pl_figure_text(result, "target");
    const cJSON *compared = cJSON_GetObjectItemCaseSensitive(result, "compared");
    *figures = (pl_figures){.result = result,
                            .is_compared = cJSON_IsTrue(compared),
                            .is_solid = pl_figure(mesh, "dimension") == 3,
                            .like = pl_figure_text(result, "like"),
                            .of_sizes = strcmp(target, "sizes") == 0,
                            .of_metric = strcmp(target, "metric") == 0,
                            .of_layers = strcmp(target, "layers") == 0,
                            .has_targets = target[0] && strcmp(target, "regular") != 0,
                            .has_sizes = pl_figure(objective, "size_weight") > 0};
    if (!cJSON_IsObject(result))
        return "is not a JSON object";
    if (cJSON_IsArray(cJSON_GetObjectItemCaseSensitive(result, "meshes")))
        return "compares several meshes; run 'planish quality FILE --report PAGE' for one";
    const int has_types = is_quality_of_types(before) && is_quality_of_types(after);
    figures->has_types = is_quality_of_types(quality);
    if (!cJSON_IsObject(mesh) || (pl_figure_count(mesh, "elements") <= 0 && !figures->has_types))
        return "has no 'mesh' with its elements";
    if ((is_quality(before) && is_quality(after)) || has_types) {
        figures->has_types = !is_quality(before) || !is_quality(after);
        figures->n_states = 2;
        figures->state[0] = before;
        figures->name[0] = "before";
        figures->state[1] = after;
        figures->name[1] = "after";
        return NULL;
    }
    if (!figures->has_types && !is_quality(quality))
        return "has neither 'before' and 'after' nor 'quality'";
    figures->n_states = 1;
    figures->state[0] = quality;
    figures->name[0] = "mesh";
    return NULL;
}

const cJSON *pl_figures_last(const pl_figures *figures) {
    return figures->state[figures->n_states - 1];
}

/** Names of types with mid-side nodes end with the number of their nodes. */
int pl_figures_have_mids(const pl_figures *figures) {
    const cJSON *of;
    cJSON_ArrayForEach(of, cJSON_GetObjectItemCaseSensitive(figures->state[0], "counts")) {
        const char *name = of->string ? of->string : "";
        if (name[0] && strchr("0123456789", name[strlen(name) - 1]) && value_of(of) > 0)
            return 1;
    }
    return 0;
}

int pl_figures_have_simplex_mids(const pl_figures *figures) {
    const cJSON *counts = cJSON_GetObjectItemCaseSensitive(figures->state[0], "counts");
    return pl_figure(counts, "tetrahedron10") > 0 || pl_figure(counts, "triangle6") > 0;
}

pl_figures pl_figures_simplices(const pl_figures *figures) {
    pl_figures alone = *figures;
    if (!figures->has_types)
        return alone;
    alone.n_states = 0;
    if (figures->n_states > 1)
        return alone;
    const cJSON *simplices = cJSON_GetObjectItemCaseSensitive(figures->state[0], "simplices");
    alone.has_types = 0;
    alone.state[0] = simplices;
    alone.n_states = is_quality(simplices);
    return alone;
}

int64_t pl_figures_elements(const pl_figures *figures) {
    const cJSON *mesh = cJSON_GetObjectItemCaseSensitive(figures->result, "mesh"), *of_type;
    double n = 0;
    if (!figures->has_types)
        return pl_figure_count(mesh, "elements");
    cJSON_ArrayForEach(of_type, cJSON_GetObjectItemCaseSensitive(figures->state[0], "counts")) n +=
        fmax(value_of(of_type), 0); /* 0 also for NAN */
    return pl_figure_whole(n);
}

double pl_figure(const cJSON *object, const char *key) {
    return value_of(cJSON_GetObjectItemCaseSensitive(object, key));
}

int64_t pl_figure_count(const cJSON *object, const char *key) {
    return pl_figure_whole(pl_figure(object, key));
}

int64_t pl_figure_whole(double value) {
    const double largest = 9e18; /* that 64 bits hold */
    return value > 0 ? (int64_t)fmin(value, largest) : 0;
}

const char *pl_figure_text(const cJSON *object, const char *key) {
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(object, key);
    return cJSON_IsString(item) && item->valuestring ? item->valuestring : "";
}

int pl_figure_list(const cJSON *object, const char *key, double *number, int most) {
    const cJSON *list = cJSON_GetObjectItemCaseSensitive(object, key), *item;
    int n = 0;
    if (!cJSON_IsArray(list))
        return 0;
    cJSON_ArrayForEach(item, list) {
        if (n < most)
            number[n] = value_of(item);
        n++;
    }
    return n;
}

const char *pl_figures_input(const pl_figures *figures) {
    const char *input = pl_figure_text(figures->result, "input");
    const char *name = pl_path_name(input);
    return name[0] ? name : input[0] ? input : "a mesh";
}
