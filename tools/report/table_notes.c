/* table_notes: notes on what is odd about a mesh. */
#include "report/table.h"

#include "job/entities.h"
#include "job/surface.h"
#include "job/unjoined.h"
#include "report/table_rows.h"
#include "terminal/message.h"

#include <inttypes.h>
#include <string.h>

/** Arrays that were taken for regions by their values: the user is told which. */
static void note_regions(FILE *stream, const pl_job *job) {
    const char *const *name = pl_job_region_arrays(job);
    char list[256] = "";
    size_t used = 0;
    int n = 0, is_expected = 1;
    for (; name[n]; n++) {
        is_expected &= planish_rank_region_name(name[n]) > 0;
        if (used < sizeof list)
            used +=
                (size_t)snprintf(list + used, sizeof list - used, "%s'%s'", n ? ", " : "", name[n]);
    }
    if (n == 0 || (n == 1 && is_expected) || job->arguments->n_regions > 0)
        return;
    pl_note(stream,
            "planish takes the values of %s %s for regions and holds the nodes between them; "
            "choose an array by --regions NAME, or let these nodes move by --regions none",
            n == 1 ? "array" : "arrays", list);
}

void pl_table_oddities(FILE *stream, const pl_job *job) {
    const planish_plan_info *info = &job->plan_info;
    const int64_t facets = info->n_nonmanifold_facets, copies = info->n_duplicate_elements;
    const int64_t others = job->file_info.n_other_elements;
    if (facets > 0)
        pl_note(stream, "%" PRId64 " %s to more than two elements; %s nodes are held", facets,
                pl_job_element_dim(job) == 3
                    ? pl_table_word_for(facets, "face belongs", "faces belong")
                    : pl_table_word_for(facets, "edge belongs", "edges belong"),
                pl_table_word_for(facets, "its", "their"));
    if (copies > 0)
        pl_note(stream, "%" PRId64 " %s the nodes of another element; %s held", copies,
                pl_table_word_for(copies, "element has", "elements have"),
                pl_table_word_for(copies, "it is", "they are"));
    if (info->n_wrapped > 0)
        pl_note(stream,
                "%" PRId64 " %s around a periodic domain, from one side to the other; %s "
                "nodes are held",
                info->n_wrapped,
                pl_table_word_for(info->n_wrapped, "element wraps", "elements wrap"),
                pl_table_word_for(info->n_wrapped, "its", "their"));
    if (others > 0)
        pl_note(stream, "%" PRId64 " %s; %s nodes are held", others,
                pl_table_word_for(others,
                                  "element of a type that planish does not smooth is copied",
                                  "elements of types that planish does not smooth are copied"),
                pl_table_word_for(others, "its", "their"));
    if (job->is_surface)
        pl_surface_note(stream, job);
    else
        note_regions(stream, job);
    pl_entities_note(stream, job);
    pl_unjoined_note(stream, job);
    if (job->file_info.is_unterminated) {
        /* Of several inputs the notes of each are named. */
        const char *open = planish_file_unterminated_path(job->file);
        const int is_named =
            job->arguments->n_inputs == 1 || strcmp(open, job->arguments->input) != 0;
        pl_note(stream,
                "the last line%s%s has no line end; if the file was cut there, the last number may "
                "be wrong",
                is_named ? " of " : "", is_named ? open : "");
    }
}

void pl_table_reversed(FILE *stream, const planish_quality *quality) {
    const int64_t n = quality->n_reversed;
    if (n > 0 && n > quality->n_inverted)
        pl_note(stream,
                "%" PRId64 " %s their nodes in the opposite order to most; planish does not "
                "renumber elements, and a solver may take these for inverted",
                n, pl_table_word_for(n, "element lists", "elements list"));
}
