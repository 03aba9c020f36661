/* formats: the formats that there are, and the texts about them. */
#include "io/file/file.h"

#include <string.h>

/* ---- the table of formats ----------------------------------------------------------------- */

/* The first that recognises a file reads it. VTK's are before all others, because their binary
 * numbers may look like the mark of another format; Nastran is before Gmsh, because its comments
 * may look like Gmsh's sections. */
static const io_format *const formats[] = {
    &io_format_vtk,    &io_format_vtu,    &io_format_nastran, &io_format_gmsh,   &io_format_medit,
    &io_format_vtkhdf, &io_format_tetgen, &io_format_netgen,  &io_format_abaqus, &io_format_cgns,
    &io_format_med,    &io_format_plex,   &io_format_off,     &io_format_ply,    &io_format_stl,
    &io_format_obj,    &io_format_mfem,   &io_format_exodus,  &io_format_ucd,    &io_format_su2,
    &io_format_unv,    &io_format_xdmf,   &io_format_elmer,   &io_format_foam};
enum { N_FORMATS = sizeof formats / sizeof *formats };

/** Formats in the order of the documentation. */
static const struct {
    const io_format *format;
    const char *title;
    const char *note;  /* on its extensions, or "" */
    const char *reads; /* what of it is read */
} texts[] = {
    {&io_format_gmsh, "Gmsh MSH 1, 2.0 to 2.2, 4.0 and 4.1, ASCII and binary", "",
     "several blocks, sparse and permuted tags, partitions, periodic"},
    {&io_format_medit, "Medit, ASCII and binary, versions 1 to 4", "",
     "sections in any order, comments; binary in either byte order"},
    {&io_format_vtk, "VTK legacy 1.0 to 5.1, ASCII and binary", "",
     "`UNSTRUCTURED_GRID`; `float` and `double` points"},
    {&io_format_vtu, "VTK XML", "",
     "arrays as text, base64, appended raw or base64; packed by zlib, LZ4 or LZMA; `Float32` and "
     "`Float64`; headers of 32 and 64 bits; either byte order; several pieces"},
    {&io_format_vtkhdf, "VTKHDF", "",
     "`UnstructuredGrid`, one or several partitions, one time step"},
    {&io_format_med, "MED 2.3 to 4 (Salome, Code_Aster)", "",
     "one mesh of one step, nodal connectivity"},
    {&io_format_cgns, "CGNS 2 to 4 in HDF5", "",
     "one base, one unstructured zone; fixed and MIXED sections"},
    {&io_format_plex, "DMPlex of PETSc in HDF5, by `DMView`: storage versions 1 to 3", "",
     "one mesh, with faces and edges or without"},
    {&io_format_tetgen, "TetGen .node + .ele (Triangle's in 2-D)", "",
     ".face and .edge too if they lie beside; others are written along"},
    {&io_format_netgen, "Netgen", "",
     "two and three dimensions, names of materials and boundaries; not .vol.gz"},
    {&io_format_abaqus, "Abaqus input file (also for CalculiX)", "",
     "`*NODE`, `*ELEMENT`, sets, sections; flat, or one part or instance that has nodes"},
    {&io_format_nastran, "Nastran bulk data", "any other (.dat) by content",
     "fields of 8 and 16 columns and free fields, mixed"},
    {&io_format_off, "OFF, ASCII and binary", "", "OFF, COFF, NOFF, STOFF and their combinations"},
    {&io_format_stl, "STL, ASCII and binary", "", "one or several solids"},
    {&io_format_obj, "Wavefront OBJ", "", "polygons in all notations, groups, objects, materials"},
    {&io_format_ply, "PLY, ASCII and binary in either byte order", "",
     "any properties and elements"},
    {&io_format_mfem, "MFEM mesh v1.0 to v1.3", "",
     "straight and of second order (`nodes`), periodic, parts of parallel meshes; named sets of "
     "attributes"},
    {&io_format_exodus,
     "Exodus II (Cubit, Sierra, MOOSE, libMesh) in netCDF classic (CDF-1, CDF-2, CDF-5) and "
     "netCDF-4",
     "any other by content",
     "blocks of elements, node sets, side sets, names; files of processors (Nemesis)"},
    {&io_format_ucd, "AVS UCD, ASCII and binary in either byte order",
     ".inp (Abaqus', too) by content",
     "linear cells of all types; data of nodes and cells pass through"},
    {&io_format_su2, "SU2", "",
     "two and three dimensions, sections in any order, one or several zones"},
    {&io_format_unv, "UNV, universal files of I-DEAS (Salome, Gmsh, FreeCAD)",
     "any other by content",
     "nodes 2411, 781, 15; elements 2412, 780; groups 2467, 2477, 2452, 2435, 2432, 2430, 2429, "
     "2417"},
    {&io_format_xdmf, "XDMF 2 and 3 (FEniCS, meshio, ParaView)", "",
     "unstructured grids, with numbers in the XML, in HDF5 or binary files beside; several pieces, "
     "steps in time with one mesh"},
    {&io_format_elmer, "Elmer", "[a folder](#folders)",
     "mesh.header, .nodes, .elements, .boundary, .names"},
    {&io_format_foam, "OpenFOAM's polyMesh, ASCII and binary", "[a folder](#folders)",
     "labels of 32 and 64 bits, single and double precision, either byte order, files packed by "
     "gzip; patches and zones"},
};
_Static_assert(sizeof texts / sizeof *texts == N_FORMATS, "each format has its texts");

const char *const *planish_file_formats(void) {
    static const char *names[N_FORMATS + 1];
    for (int i = 0; i < N_FORMATS; i++) /* the same in every call, on every thread */
        __atomic_store_n(&names[i], texts[i].format->name, __ATOMIC_RELAXED);
    return names;
}

int planish_file_format_info(int i, planish_format_info *info) {
    if (i < 0 || i >= N_FORMATS || !info)
        return 0;
    const io_format *format = texts[i].format;
    *info = (planish_format_info){.name = format->name,
                                  .title = texts[i].title,
                                  .extensions = format->extensions,
                                  .note = texts[i].note,
                                  .reads = texts[i].reads,
                                  .is_read = format->read != NULL};
    return 1;
}

const io_format *io_format_at(int i) {
    return i >= 0 && i < N_FORMATS ? formats[i] : NULL;
}

const io_format *io_format_by_name(const char *name) {
    for (int i = 0; i < N_FORMATS; i++)
        if (strcmp(formats[i]->name, name) == 0)
            return formats[i];
    return NULL;
}

const io_format *io_format_by_extension(const char *path) {
    for (int i = 0; i < N_FORMATS; i++)
        if (io_format_has_extension(formats[i], path))
            return formats[i];
    return NULL;
}

const io_format *io_format_find(const char *path, const char *data, int64_t size) {
    /* The beginning of a file of any format but HDF5 is not farther: most can be before it in
     * Nastran's, comments and cases. */
    enum { LOOKED_AT = 1 << 18 };
    if (size > LOOKED_AT && !io_is_hdf5(data, size))
        size = LOOKED_AT;
    for (int i = 0; i < N_FORMATS; i++)
        if (formats[i]->recognise && formats[i]->recognise(data, size))
            return formats[i];
    return io_format_by_extension(path);
}
