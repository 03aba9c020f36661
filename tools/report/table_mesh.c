/* table_mesh: what a mesh is: the first lines of a table, and the nodes that may move. */
#include "report/table_mesh.h"

#include "options/combinations.h"
#include "report/table_rows.h"
#include "terminal/terminal.h"
#include "terminal/text.h"

#include <inttypes.h>
#include <string.h>

void pl_table_row_mesh(FILE *stream, const pl_job *job, const char *elements) {
    enum { NAME_ROOM = 20 };
    char counts[512], name[4 * PL_TEXT_WIDTH + 1];
    const int room = pl_terminal_text_width(stream);
    const int width =
        snprintf(counts, sizeof counts, ": %s, %s, %" PRId64 " %s", job->file_info.format, elements,
                 job->mesh.n_nodes, pl_table_word_for(job->mesh.n_nodes, "node", "nodes"));
    if (width <= room - NAME_ROOM) {
        fprintf(stream, "%s%s\n",
                pl_text_fit(job->arguments->input, room - width, name, sizeof name), counts);
        return;
    }
    fprintf(stream, "%s: %s\n", pl_text_fit(job->arguments->input, room / 2, name, sizeof name),
            job->file_info.format);
    pl_terminal_wrap(stream, counts + strlen(": ") + strlen(job->file_info.format) + strlen(", "));
}

/** Whether any element has mid-side nodes. */
static int has_mids(const planish_cells *cells) {
    for (int64_t i = 0; i < cells->n; i++)
        if (cells->offset[i + 1] - cells->offset[i] >
            pl_cell_corners((planish_cell_type)cells->type[i]))
            return 1;
    return 0;
}

void pl_table_rows_cells(FILE *stream, const pl_job *job, const pl_cells_validity *validity) {
    char counts[512], text[640], name[4 * PL_TEXT_WIDTH + 1];
    const int64_t n = job->mesh.n_nodes;
    pl_cells_count(job->mesh.cells, counts, sizeof counts);
    if (!has_mids(job->mesh.cells)) {
        pl_table_row_mesh(stream, job, counts);
        return;
    }
    fprintf(stream, "%s: %s, %" PRId64 " %s\n",
            pl_text_fit(job->arguments->input, PL_TEXT_WIDTH / 2, name, sizeof name),
            job->file_info.format, n, pl_table_word_for(n, "node", "nodes"));
    snprintf(text, sizeof text, "%s, %" PRId64 " curved; mid-side nodes follow", counts,
             validity->quality.all.n_curved);
    pl_terminal_wrap(stream, text);
}

void pl_table_row_target(FILE *stream, const pl_job *job) {
    char name[4 * PL_TEXT_WIDTH + 1];
    if (job->like.is_layer)
        fprintf(stream,

                "AR compares layers with their former heights, other elements with regular ones\n");
    else if (job->like.sizes.metric)
        fprintf(stream, "AR measures lengths by %s\n",
                pl_text_fit(pl_sizes_source(job->arguments), PL_TEXT_WIDTH / 2, name, sizeof name));
    else if (job->like.place && !job->like.sizes.size)
        fprintf(stream, "AR compares each element with its shape in %s\n",
                pl_text_fit(job->arguments->like, PL_TEXT_WIDTH / 2, name, sizeof name));
}

void pl_table_row_simplices(FILE *stream, const pl_job *job) {
    char counts[64];
    pl_cell_type_count(pl_job_element_dim(job) == 3 ? PLANISH_CELL_TETRAHEDRON
                                                    : PLANISH_CELL_TRIANGLE,
                       job->mesh.n_elements, counts, sizeof counts);
    pl_table_row_mesh(stream, job, counts);
}

void pl_table_row_free(FILE *stream, const pl_job *job) {
    const int64_t n = job->plan_info.n_free;
    char text[256], sliding[128] = "";
    if (job->is_surface) {
        fprintf(stream, "%" PRId64 " of %" PRId64 " nodes move on the surface\n",
                job->plan_info.n_sliding, job->mesh.n_nodes);
        return;
    }
    if (job->arguments->slide || job->onto.fit)
        snprintf(sliding, sizeof sliding, ", %" PRId64 " to slide", job->plan_info.n_sliding);
    else if (job->could_slide > 0)
        snprintf(sliding, sizeof sliding, ", %" PRId64 " could slide (--slide auto)",
                 job->could_slide);
    snprintf(text, sizeof text, "%" PRId64 " of %" PRId64 " %s free to move%s", n,
             job->mesh.n_nodes, pl_table_word_for(n, "nodes is", "nodes are"), sliding);
    pl_terminal_wrap(stream, text);
}
