/* large: meshes in PETSc's files that no process has all of. */
#include "mpi/large.h"

#include "mpi/plexrows.h"
#include "mpi/slides.h"

#include "terminal/message.h"

#include "base/status.h"
#include "base/system.h"

#include <stdio.h>
#include <string.h>

int pl_large_can(const pl_arguments *a) {
    enum { SHARE = 8 }; /* of the memory: a mesh takes two to four times its file there */
    PetscBool wants = PETSC_FALSE, is_given = PETSC_FALSE;
    pl_file_status status;
    pl_plexform form;
    if (!pl_plexfile_is(a->input))
        return 0;
    PetscOptionsGetBool(NULL, NULL, "-planish_load_in_parts", &wants, &is_given);
    if (!is_given)
        wants = pl_file_find(a->input, &status) == 0 && status.size > pl_system_memory() / SHARE
                    ? PETSC_TRUE
                    : PETSC_FALSE;
    if (!wants)
        return 0;
    const int asks_for_all = a->n_fix > 0 || a->layers == PL_LAYERS_HELD || a->n_slide_tags > 0 ||
                             a->n_min_volumes > 0 || a->n_regions > 0 || a->report ||
                             (a->format && strcmp(a->format, "dmplex") != 0);
    const int is_curved = a->slide && a->slide_curved;
    const char *why = !pl_plexfile_is(a->output) ? "the output is not a .h5 file"
                      : asks_for_all ? "the options name groups, an HTML report or another format"
                      : is_curved    ? "nodes slide on curved surfaces"
                                     : pl_plexrows_refusal(a->input, &form);
    if (why && why[0] && a->verbosity != PL_QUIET)
        pl_note(stderr, "%s: one process has all of the mesh: %s", a->input, why);
    return !why;
}

int pl_large_read(pl_crew *crew, const char *path, planish_error *error) {
    pl_plexform form = {.name = ""};
    int code = PLANISH_OK;
    crew->is_large = 1;
    pl_crew_path(crew, path, crew->input);
    if (path && pl_plexrows_refusal(path, &form))
        code = pl_fail(error, PLANISH_ERROR_FILE,
                       "%s: was changed while it was read; run again when it is complete", path);
    code = pl_crew_agree(crew, code, error);
    if (code)
        return code;
    MPI_Bcast(&form, sizeof form, MPI_BYTE, 0, crew->comm);
    code = pl_plexfile_read(&crew->file, crew->exchange_comm, crew->input, &form, error);
    crew->is_broken = crew->file.is_broken;
    return pl_crew_agree(crew, code, error);
}

int pl_large_share(pl_crew *crew, const pl_arguments *arguments, planish_error *error) {
    double said[3] = {0}; /* by the options */
    pl_piece piece;
    if (arguments) {
        said[0] = arguments->ignore_regions;
        said[1] = arguments->slide;
        said[2] = arguments->slide_tolerance;
    }
    MPI_Bcast(said, 3, MPI_DOUBLE, 0, crew->comm);
    crew->file.ignore_regions = said[0] != 0;
    crew->file.slides = said[1] != 0;
    int code = pl_crew_agree(crew, pl_plexfile_cut(&crew->file, &piece, error), error);
    if (!code)
        code = pl_crew_agree(crew, pl_share_take(&crew->share, crew->exchange_comm, &piece, error),
                             error);
    pl_piece_destroy(&piece);
    return !code && crew->file.slides ? pl_surface_slide(crew, said[2], error) : code;
}

int pl_large_write(pl_crew *crew, const char *path, uint64_t *checksums, planish_error *error) {
    uint64_t sums[2];
    int wanted = checksums != NULL;
    pl_plexout out;
    MPI_Bcast(&wanted, 1, MPI_INT, 0, crew->comm);
    const int code = pl_crew_agree(
        crew, pl_plexfile_write(&crew->file, &crew->share, path, &out, wanted ? sums : NULL, error),
        error);
    if (checksums && !code)
        memcpy(checksums, sums, sizeof sums);
    return pl_crew_agree(crew, pl_plexfile_finish(&out, code, error), error);
}
