/* foam: OpenFOAM's meshes, folders polyMesh: cells by their faces.
 *
 *   points                the nodes; only this file changes
 *   faces                 their nodes
 *   owner, neighbour      the cells on the two sides of each
 *   boundary              patches: runs of faces with names and types
 *   cellZones, faceZones, pointZones     may be there
 *
 * Each file is text or binary, with labels of 32 or 64 bits and scalars of single or double precision,
 * and may be packed by gzip. Elements are found in foam_cells.c; the rest is one file for each job.
 * Cells, faces and points are numbered from 0.
 */
#include "io/core/format.h"
#include "io/foam/foam_cells.h"
#include "io/foam/foam_faces.h"
#include "io/foam/foam_flat.h"
#include "io/foam/foam_groups.h"
#include "io/foam/foam_list.h"
#include "io/foam/foam_patches.h"

#include "base/status.h"

static int foam_read(io_model *model, planish_error *error) {
    if (!model->folder)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       "%s: is a file of OpenFOAM; give the folder of the case, or its folder "
                       "constant/polyMesh",
                       model->input.path);
    foam_mesh mesh = {.model = model, .dim = 3};
    foam_patches patches = {.n = 0};
    foam_sets sets = {.n = 0};
    model->groups_by_name = 1;
    int status = foam_read_points(model, error);
    if (!status)
        status = foam_read_faces(&mesh, error);
    if (!status)
        status = foam_read_patches(&mesh, &patches, error);
    if (!status)
        status = foam_flatten(&mesh, &patches, error);
    if (!status)
        status = foam_make_cells(&mesh, error);
    if (!status)
        status = foam_use_patches(&mesh, &patches, &sets, error);
    if (!status)
        status = foam_read_zones(&mesh, &sets, error);
    if (!status)
        status = foam_make_groups(&mesh, &sets, error);
    io_reduce_cell_numbers(&model->tetrahedron);
    io_reduce_cell_numbers(&model->triangle);
    foam_release_patches(&patches);
    foam_release_sets(&sets);
    foam_release_mesh(&mesh);
    return status;
}

static int foam_recognise(const char *data, int64_t size) {
    io_cursor cursor = io_begin_text(data, size);
    return io_slice_is(foam_word(&cursor), "FoamFile", 0);
}

static const char *const files[] = {"points", "faces", "owner", "neighbour", "boundary", NULL};
static const char *const places[] = {"", "polyMesh", "*/polyMesh", "constant/*/polyMesh", NULL};
static const char *const folders[] = {"sets", NULL};
static const io_folder folder = {
    .files = files, .may_be_packed = 1, .places = places, .folders = folders};

static const char *const extensions[] = {NULL};

const io_format io_format_foam = {.name = "openfoam",
                                  .extensions = extensions,
                                  .recognise = foam_recognise,
                                  .read = foam_read,
                                  .field = foam_field,
                                  .folder = &folder};
