/* surface: what the program says of a mesh that is a surface in space. */
#include "job/surface.h"

#include "terminal/message.h"
#include "terminal/terminal.h"
#include "terminal/text.h"

#include <inttypes.h>

void pl_surface_print(FILE *stream, const pl_job *job) {
    const planish_shape_info *info = &job->curved.info;
    char text[256], open[64] = "closed";
    if (info->n_open_edges > 0)
        snprintf(open, sizeof open, "open at %" PRId64 " edge%s", info->n_open_edges,
                 info->n_open_edges == 1 ? "" : "s");
    snprintf(text, sizeof text,
             "surface in space, %s: %" PRId64 " patch%s, %" PRId64 " edges of curves (%" PRId64
             " creases), %" PRId64 " corners",
             open, info->n_patches, info->n_patches == 1 ? "" : "es", info->n_edges,
             info->n_creases, info->n_corners);
    pl_terminal_wrap(stream, text);
}

void pl_surface_note(FILE *stream, const pl_job *job) {
    const planish_shape_info *info = &job->curved.info;
    const double near = 1e-3; /* that --slide-tolerance takes */
    if (job->file_info.off_plane <= near)
        pl_note(stream,
                "the mesh is a surface in space: nodes are up to %.2g times its size off a plane; "
                "with --slide-tolerance %.1g planish takes it for a mesh in that plane",
                job->file_info.off_plane, 1.1 * job->file_info.off_plane);
    if (info->n_turned > 0)
        pl_note(
            stream,
            "%" PRId64
            " element%s listed in the opposite order to most; planish does not renumber elements",
            info->n_turned, info->n_turned == 1 ? " is" : "s are");
    if (info->n_conflict_edges > 0)
        pl_note(stream,
                "%" PRId64 " edge%s between elements that cannot be oriented alike (a Moebius "
                "strip?): their nodes stay, or move along these edges",
                info->n_conflict_edges, info->n_conflict_edges == 1 ? " is" : "s are");
    if (info->n_flat > 0)
        pl_note(stream, "%" PRId64 " triangle%s no area; %s nodes are held", info->n_flat,
                info->n_flat == 1 ? " has" : "s have", info->n_flat == 1 ? "its" : "their");
}
