/* table_surface: how far the surface of a mesh moved, and what that did to volumes. */
#include "report/table_surface.h"

#include "job/surface.h"
#include "report/table_rows.h"
#include "terminal/terminal.h"

#include <inttypes.h>
#include <math.h>

void pl_table_put_distance(FILE *stream, const char *start, const char *middle,
                           const planish_shape_distance *d) {
    char text[256];
    if (isfinite(d->distance) && isfinite(d->distance_back))
        snprintf(text, sizeof text,
                 "%s at most %.3g (%.3g h)%s at most %.3g (%.3g h) off (certified)", start,
                 d->distance, d->in_edges, middle, d->distance_back, d->back_in_edges);
    else
        snprintf(text, sizeof text, "%s an unknown distance: no bound is proved", start);
    pl_terminal_wrap(stream, text);
}

/** Put by how much the volumes changed: of all, and of the regions that changed most. */
static void put_volume_changes(FILE *stream, const pl_job *job, const pl_surface_state *state) {
    enum { MOST_REGIONS = 5 };
    double before = 0, after = 0;
    int64_t n = 0;
    int64_t worst[MOST_REGIONS];
    char text[320], tag[200];
    for (int64_t i = 0; i < state->n_regions; i++) {
        before += state->region[i].before;
        after += state->region[i].after;
        if (state->region[i].before == 0)
            continue;
        int64_t at = n < MOST_REGIONS ? n++ : MOST_REGIONS;
        for (; at > 0; at--) { /* the largest changes first */
            const pl_region_volume *a = &state->region[i], *b = &state->region[worst[at - 1]];
            if (fabs(a->after / a->before - 1) <= fabs(b->after / b->before - 1))
                break;
            if (at < MOST_REGIONS)
                worst[at] = worst[at - 1];
        }
        if (at < MOST_REGIONS)
            worst[at] = i;
    }
    size_t used = (size_t)snprintf(text, sizeof text, "volume changed by the fraction %+.2g",
                                   after / before - 1);
    for (int64_t k = 0; n > 1 && k < n && used < sizeof text; k++) {
        const pl_region_volume *of = &state->region[worst[k]];
        planish_file_element_region(job->file, of->element, tag, sizeof tag);
        used += (size_t)snprintf(text + used, sizeof text - used, "%s %s %+.2g",
                                 k ? "," : "; regions:", tag[0] ? tag : "(no name)",
                                 of->after / of->before - 1);
    }
    pl_terminal_wrap(stream, text);
}

void pl_table_put_surface(FILE *stream, const pl_job *job, const pl_result *result) {
    const int64_t *n = job->curved.n, n_refused = result->smooth.n_off_shape;
    char text[256];
    if (!result->surface.is_known)
        return;
    if (job->is_surface)
        pl_surface_print(stream, job);
    snprintf(text, sizeof text,
             "surface: %" PRId64 " nodes in planes, %" PRId64 " on lines, %" PRId64
             " on patches, %" PRId64 " on curves; %" PRId64 " corners",
             n[PLANISH_CONSTRAINT_ON_PLANE], n[PLANISH_CONSTRAINT_ON_LINE],
             n[PLANISH_CONSTRAINT_ON_PATCH], n[PLANISH_CONSTRAINT_ON_CURVE],
             job->curved.info.n_corners);
    pl_terminal_wrap(stream, text);
    pl_table_put_distance(stream, "surface moved by", ", the original one is",
                          &result->surface.after);
    if (n_refused > 0) {
        snprintf(text, sizeof text, "%" PRId64 " %s shortened or refused for the surface",
                 n_refused, pl_table_word_for(n_refused, "move was", "moves were"));
        pl_terminal_wrap(stream, text);
    }
    if (!job->is_surface)
        put_volume_changes(stream, job, &result->surface);
    if (job->plan_info.n_fixed_elements > 0)
        fprintf(stream, "%" PRId64 " %s no movable node\n", job->plan_info.n_fixed_elements,
                pl_table_word_for(job->plan_info.n_fixed_elements, "element still has",
                                  "elements still have"));
}

void pl_table_put_onto(FILE *stream, const pl_job *job) {
    const planish_fit_info *before = &job->onto.before, *after = &job->onto.after;
    const int64_t n = before->n_nodes - before->n_held,
                  n_on = n - after->n_off - after->n_out_of_reach;
    char text[512], without[64] = "";
    if (!job->onto.fit)
        return;
    if (after->n_out_of_reach > 0)
        snprintf(without, sizeof without, ", %" PRId64 " %s no place there", after->n_out_of_reach,
                 pl_table_word_for(after->n_out_of_reach, "has", "have"));
    snprintf(text, sizeof text,
             "fitted to %s before smoothing: of %" PRId64 " %s %" PRId64
             " lay off that surface, by at most %.3g; now %" PRId64 " %s on it, %" PRId64
             " not yet%s",
             job->arguments->onto, n, pl_table_word_for(n, "node", "nodes"), before->n_off,
             before->farthest, n_on, pl_table_word_for(n_on, "is", "are"), after->n_off, without);
    pl_terminal_wrap(stream, text);
    pl_table_put_distance(stream, "the surface is off that one by", ", that one is",
                          &job->onto.distance);
}
