/* write_plex IN OUT.h5: a mesh with faces and edges, as programs that use DMPlex write it. IN:
 * PETSc's own file, or what DMPlexCreateFromFile reads (Gmsh's); each process writes its part of
 * that.
 */
#include <petscdmplex.h>
#include <petscsf.h>
#include <petscviewer.h>

#include <string.h>

static PetscErrorCode open_viewer(const char *path, PetscFileMode mode, PetscViewer *viewer) {
    PetscCall(PetscViewerCreate(PETSC_COMM_WORLD, viewer));
    PetscCall(PetscViewerSetType(*viewer, PETSCVIEWERHDF5));
    PetscCall(PetscViewerFileSetMode(*viewer, mode));
    PetscCall(PetscViewerFileSetName(*viewer, path));
    return PetscViewerPushFormat(*viewer, PETSC_VIEWER_HDF5_PETSC);
}

static PetscErrorCode load(const char *path, DM *whole) {
    DM dm;
    PetscSF sf;
    PetscViewer viewer;
    PetscCall(DMCreate(PETSC_COMM_WORLD, &dm));
    PetscCall(DMSetType(dm, DMPLEX));
    PetscCall(PetscObjectSetName((PetscObject)dm, "plex"));
    PetscCall(open_viewer(path, FILE_MODE_READ, &viewer));
    PetscCall(DMPlexTopologyLoad(dm, viewer, &sf));
    PetscCall(DMPlexCoordinatesLoad(dm, viewer, sf));
    PetscCall(DMPlexLabelsLoad(dm, viewer, sf));
    PetscCall(PetscViewerDestroy(&viewer));
    PetscCall(PetscSFDestroy(&sf));
    PetscCall(DMPlexInterpolate(dm, whole));
    PetscCall(DMCopyLabels(dm, *whole, PETSC_COPY_VALUES, PETSC_FALSE, DM_COPY_LABELS_REPLACE));
    return DMDestroy(&dm);
}

static PetscErrorCode read_other(const char *path, DM *whole) {
    DM parts;
    PetscCall(DMPlexCreateFromFile(PETSC_COMM_WORLD, path, "plex", PETSC_TRUE, whole));
    PetscCall(DMPlexDistribute(*whole, 0, NULL, &parts));
    if (!parts)
        return 0;
    PetscCall(DMDestroy(whole));
    *whole = parts;
    return 0;
}

static PetscErrorCode convert(const char *from, const char *to) {
    DM dm;
    PetscViewer viewer;
    const char *extension = strrchr(from, '.');
    const int is_own = extension && strcmp(extension, ".h5") == 0;
    PetscCall(is_own ? load(from, &dm) : read_other(from, &dm));
    PetscCall(PetscObjectSetName((PetscObject)dm, "plex"));
    PetscCall(open_viewer(to, FILE_MODE_WRITE, &viewer));
    PetscCall(DMView(dm, viewer));
    PetscCall(PetscViewerDestroy(&viewer));
    return DMDestroy(&dm);
}

int main(int argc, char **argv) {
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    if (argc != 3)
        return 64;
    PetscCall(convert(argv[1], argv[2]));
    return PetscFinalize();
}
