/* figures: the figures of a page, from the JSON of a run. Whatever is missing, or of another type,
 * has no value: pages of reports that were made elsewhere are as complete as these.
 *
 *     pl_figures_find, _last, _simplices              the states of the mesh
 *     pl_figures_input                                name of the input
 *     pl_figure, _count, _whole, _text, _list         values by their keys
 */
#ifndef PL_REPORT_FIGURES_H
#define PL_REPORT_FIGURES_H

#include <cjson/cJSON.h>

#include <stdint.h>

/** The states of the mesh that a result tells of: before and after, or one. */
typedef struct pl_figures {
    const cJSON *result;
    int n_states;
    int is_compared;       /* they are of two files, and planish smoothed nothing */
    const cJSON *state[2]; /* the objects of quality */
    const char *name[2];   /* "before", "after"; "mesh" */
    int is_solid;          /* tetrahedra */
    int has_types;         /* the states are those of elements of every type */
    int of_sizes;          /* elements were to have sizes, */
    int of_metric;         /* or those of a metric, */
    int of_layers;         /* or layers were to keep their heights */
    int has_targets;       /* elements are measured against other ones than regular ones */
    int has_sizes;         /* ratios of elements with a movable node count sizes, too */
    const char *like;      /* the file whose elements are the targets, or "": regular ones */
} pl_figures;

/** Find the states in result. NULL, or what is wrong with it, in words. */
const char *pl_figures_find(const cJSON *result, pl_figures *figures);

/** The last state: the result. */
const cJSON *pl_figures_last(const pl_figures *figures);

/** Whether elements have mid-side nodes, of which the picture and most measures know nothing. */
int pl_figures_have_mids(const pl_figures *figures);

/** Whether simplices have them. */
int pl_figures_have_simplex_mids(const pl_figures *figures);

/** The states of the simplices alone, by their corners; n_states is 0 if there are none, and before and
 *  after smoothing, where all elements have one measure. */
pl_figures pl_figures_simplices(const pl_figures *figures);

/** Number of the elements of a result. */
int64_t pl_figures_elements(const pl_figures *figures);

/** The number that key of object is, or NAN if there is none, or one beyond 1e200; object may be
 *  NULL. */
double pl_figure(const cJSON *object, const char *key);

/** value as a count: 0 for what is none, and no more than 64 bits hold. */
int64_t pl_figure_whole(double value);

/** pl_figure as a count. */
int64_t pl_figure_count(const cJSON *object, const char *key);

/** The text that key of object is, or "". */
const char *pl_figure_text(const cJSON *object, const char *key);

/** Numbers of the list that key of object is: up to most, NAN for those that are null. Returns how
 *  many the list has. */
int pl_figure_list(const cJSON *object, const char *key, double *number, int most);

/** Return the name of the input without its folder. */
const char *pl_figures_input(const pl_figures *figures);

#endif
