/* with_faces IN.h5 OUT.h5: the mesh of PETSc's file IN with faces and edges, as other programs that
 * use DMPlex write it. */
#include <petscdmplex.h>
#include <petscsf.h>
#include <petscviewer.h>

static PetscErrorCode open_viewer(const char *path, PetscFileMode mode, PetscViewer *viewer) {
    PetscCall(PetscViewerCreate(PETSC_COMM_WORLD, viewer));
    PetscCall(PetscViewerSetType(*viewer, PETSCVIEWERHDF5));
    PetscCall(PetscViewerFileSetMode(*viewer, mode));
    PetscCall(PetscViewerFileSetName(*viewer, path));
    return PetscViewerPushFormat(*viewer, PETSC_VIEWER_HDF5_PETSC);
}

static PetscErrorCode convert(const char *from, const char *to) {
    DM dm, whole;
    PetscSF sf;
    PetscViewer viewer;
    PetscCall(DMCreate(PETSC_COMM_WORLD, &dm));
    PetscCall(DMSetType(dm, DMPLEX));
    PetscCall(PetscObjectSetName((PetscObject)dm, "plex"));
    PetscCall(open_viewer(from, FILE_MODE_READ, &viewer));
    PetscCall(DMPlexTopologyLoad(dm, viewer, &sf));
    PetscCall(DMPlexCoordinatesLoad(dm, viewer, sf));
    PetscCall(DMPlexLabelsLoad(dm, viewer, sf));
    PetscCall(PetscViewerDestroy(&viewer));
    PetscCall(DMPlexInterpolate(dm, &whole));
    PetscCall(PetscObjectSetName((PetscObject)whole, "plex"));
    PetscCall(DMCopyLabels(dm, whole, PETSC_COPY_VALUES, PETSC_FALSE, DM_COPY_LABELS_REPLACE));
    PetscCall(open_viewer(to, FILE_MODE_WRITE, &viewer));
    PetscCall(DMView(whole, viewer));
    PetscCall(PetscViewerDestroy(&viewer));
    PetscCall(PetscSFDestroy(&sf));
    PetscCall(DMDestroy(&dm));
    return DMDestroy(&whole);
}

int main(int argc, char **argv) {
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    if (argc != 3)
        return 64;
    PetscCall(convert(argv[1], argv[2]));
    return PetscFinalize();
}
