#include "support/data_files.h"

#include "support/files.h"

#include "io/file/file.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

const test_data_file test_data_files[] = {
    {"ascii22.msh", "gmsh", 1},
    {"binary22.msh", "gmsh", 1},
    {"ascii41.msh", "gmsh", 1},
    {"binary41.msh", "gmsh", 1},
    {"square.msh", "gmsh", 1},
    {"medit.mesh", "medit", 1},
    {"medit.meshb", "medit", 1},
    {"ascii.vtk", "vtk", 0},
    {"binary.vtk", "vtk", 0},
    {"ascii.vtu", "vtu", 0},
    {"base64.vtu", "vtu", 0},
    {"zlib.vtu", "vtu", 0},
    {"raw.vtu", "vtu", 0},
    {"cube.vtkhdf", "vtkhdf", 0},
    {"tetgen.node", "tetgen", 0},
    {"netgen.vol", "netgen", 1},
    {"abaqus.inp", "abaqus", 1},
    {"nastran.bdf", "nastran", 1},
    {"nastran_long.bdf", "nastran", 1},
    {"cube.cgns", "cgns", 1},
    {"cube.med", "med", 1},
    {"cube.h5", "dmplex", 1},
    {"square.off", "off", 0},
    {"square.stl", "stl", 1},
    {"square.obj", "obj", 1},
    {"square.ply", "ply", 0},
    {"cube.mfem", "mfem", 1},
    {"cube.exo", "exodus", 1},
    {"cube.avs", "ucd", 1},
    {"cube.su2", "su2", 0},
    {"cube.unv", "unv", 1},
    {"cube.xdmf", "xdmf", 0},
    {"elmer", "elmer", 1},
    {"openfoam", "openfoam", 1},
    {NULL, NULL, 0},
};

int test_data_is_folder(const test_data_file *data) {
    return io_format_by_name(data->format)->folder != NULL;
}

int test_data_path(char *text, const test_data_file *data) {
    planish_file *file = NULL;
    planish_error error;
    test_path_from(text, "PLANISH_TEST_DATA", data->name);
    const int status = planish_file_open(text, NULL, 1, &file, &error);
    planish_file_close(file);
    if (status && !strstr(error.text, "this planish was built"))
        fail_msg("%s", error.text);
    return status == PLANISH_OK;
}
