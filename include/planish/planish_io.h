/* planish_io: mesh files for planish. Read a file, smooth its coordinates and write it back: every
 * byte stays as it was, except the coordinates of moved nodes. Each name begins with planish_file_:
 *
 *     open, open_with, close                        read a file into memory, free it
 *     formats, format_info                          the formats that can be read, and written
 *     get_info, unterminated_path                   the format, how the file stores coordinates
 *     get_parametric                                nodes that the file puts on curves and surfaces
 *     mesh, cells, coordinates                      the arrays to smooth; the file owns them
 *     plane, space_coordinates                      triangles: their plane, from it to space
 *     cell_arrays, region_arrays, choose_regions    arrays of numbers that tell regions
 *     data_info, data                               arrays of numbers: sizes, metrics, results
 *     groups                                        tags of what may be held, slide, have volumes
 *     constraints, get_held, get_marked             held nodes, and the reasons
 *     get_supported, supported_groups               boundary conditions
 *     included                                      included files
 *     surface                                       what tells where nodes slide
 *     min_volumes                                   minimum volumes of groups
 *     element_number, node_number, element_region   how the file calls an element or node
 *     round_in_plane                                coordinates as the file will have them
 *     can_write, check_output, write                write the file with the new coordinates
 *     target, target_of                             the formats that meshes can be written in
 *     can_convert, check_conversion, convert        write the mesh in another format
 *
 * planish_sol_read reads the sizes that Medit keeps beside its meshes, planish_data_free frees data.
 * planish_io_version is the version of this library.
 *
 * Formats: docs/formats.md lists them; planish_file_formats returns their names. Meshes of Elmer and
 * OpenFOAM are folders: give the path of the folder. Calls on different files may run at the same
 * time, except on HDF5 files (CGNS, MED, VTKHDF, DMPlex, Exodus, XDMF), unless the HDF5 library is
 * built for threads. The error convention is that of planish.h; the text names the file, the line or
 * byte, and says what to do. Functions that cannot fail return 0, NULL, -1 or an
 * empty list if file or path is NULL.
 */
#ifndef PLANISH_IO_H
#define PLANISH_IO_H

#include <planish/planish.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Version of the planish_io library that is linked, "MAJOR.MINOR.PATCH"; static text. It must be that of
 *  the header, PLANISH_VERSION, and of the other library, planish_version. */
PLANISH_API const char *planish_io_version(void);

/** A mesh file that has been read. The file should not change while it is open: if it does,
 *  planish_file_write refuses to write. Files of up to 64 MB, and HDF5 files, are read into memory.
 *  Larger files are mapped. If another program writes to such a file meanwhile, no call reads or
 *  writes beyond its arrays. If the file becomes shorter, the system sends the process SIGBUS. */
typedef struct planish_file planish_file;

/** Read the file at path, or the mesh in the folder at path. format: a name of planish_file_formats, or
 *  NULL to detect it by content, then by extension. threads: 0 as many as OpenMP would use. In a
 *  child of fork all calls on the file use one, but for planish_write_options.threads.
 *  Errors: _FILE, _FORMAT, _MEMORY, _ARGUMENT (unknown format). */
PLANISH_API int planish_file_open(const char *path, const char *format, int threads,
                                  planish_file **file, planish_error *error);

/** How a file is opened. */
typedef struct planish_open_options {
    const char *format; /* as for planish_file_open */
    int threads;        /* as for planish_file_open */
    int isolated;       /* not 0: the file is untrusted, and this process must not die */
    double
        plane_tolerance; /* for flat elements only: largest distance of nodes from their plane, as
                               a fraction of the diagonal of their bounding box, 0 .. 1e-3; 0: the
                               tolerance of planish_file_surface. Beyond it they are a surface in
                               space */
    const void *reserved[6];
} planish_open_options;

/** Open a file as planish_file_open does, with options (NULL: all 0). Errors besides: _ARGUMENT
 *  (plane_tolerance).
 *
 *  isolated is for processes that must not die. The HDF5 library (1.10) crashes on some damaged files,
 *  and takes memory without end for others. A file that needs HDF5 (as above) is
 *  therefore first opened in a child process. Packed coordinates are later changed in a child process,
 *  too. Either failure becomes a _FORMAT error. On Linux the child may take 1 GB, and 4 kB for each byte
 *  of the file, up to three quarters of the machine's memory. Opening these files takes twice the time;
 *  for all other files isolated has no effect. The child is a fork of the caller, of the calling thread
 *  alone: no other thread may be within the HDF5 library then. If the caller ignores SIGCHLD or waits for
 *  any child elsewhere, the signal in the error's text is 0. Errors besides: _MEMORY: no process could be
 *  started. */
PLANISH_API int planish_file_open_with(const char *path, const planish_open_options *options,
                                       planish_file **file, planish_error *error);

/** Free the file and all that belongs to it: the arrays of planish_file_mesh and _surface, names,
 *  round_user. file may be NULL. */
PLANISH_API void planish_file_close(planish_file *file);

/** NULL-terminated list of the formats' names: "gmsh", "medit", "vtk", "vtu", ... */
PLANISH_API const char *const *planish_file_formats(void);

/** Texts about a format, static. */
typedef struct planish_format_info {
    const char *name;              /* one of planish_file_formats */
    const char *title;             /* its full name and its versions */
    const char *const *extensions; /* with the dot, NULL-terminated; none: folders */
    const char *note;              /* on extensions, or "" */
    const char *reads;             /* the parts of the format that planish reads */
    int is_read;                   /* 0: this planish was built without the library that it needs */
    const void *reserved[4];
} planish_format_info;

/** Describe format i, from 0, in the order of planish_file_formats. Returns 1, or 0 if there is no
 *  such format. */
PLANISH_API int planish_file_format_info(int i, planish_format_info *info);

typedef struct planish_file_info {
    const char *format;          /* name of the format, static text */
    planish_precision precision; /* format in which the file stores coordinates */
    planish_round_fn *round; /* function that rounds to it, for planish_options; valid while the */
    void *round_user;        /* file is open */
    int64_t
        n_other_elements; /* elements that are not smoothed: pyramids of second order, polyhedra */
    int64_t n_lower_elements; /* elements of lower dimension */
    int64_t n_regions;        /* distinct regions among the elements */
    int64_t bytes;            /* size of the input */
    int is_unterminated; /* not 0: the format has no end mark and the last line has no line end,
                                 so the file may have been cut short there */
    int has_normals;     /* not 0: the file has normals of nodes (OFF, OBJ, PLY). planish does not
                                 update them: the normals of moved nodes are wrong */
    double off_plane; /* of a surface in space: largest distance of nodes from the plane that fits
                         them best, as a fraction of the diagonal of their bounding box; else 0 */
    int64_t reserved[3];
} planish_file_info;

/** Fill in *info. */
PLANISH_API void planish_file_get_info(const planish_file *file, planish_file_info *info);

/** Return the path of the file that was read whose last line has no end (info.is_unterminated), or
 *  NULL if there is none. The file owns the text. */
PLANISH_API const char *planish_file_unterminated_path(const planish_file *file);

/** Find the nodes that have parameters of their curve or surface beside their coordinates (Gmsh,
 *  Netgen). The file keeps these parameters, so that those of a moved node are wrong. parametric
 *  [n_nodes] (may be NULL) is filled with 0 or 1. Returns the number of these nodes. */
PLANISH_API int64_t planish_file_get_parametric(const planish_file *file, uint8_t *parametric);

/** Return the mesh. The file owns its arrays. The elements are those of the file's highest dimension,
 *  3 or 2, that have a planish_cell_type: first the triangles or tetrahedra of order 1 and 2, then the
 *  others, both in the file's order. They are in mesh.cells, in VTK's order of nodes, or in
 *  mesh.elements if all are triangles or tetrahedra of order 1. Flat elements have coordinates in
 *  their plane (planish_file_plane), dim 2. If they lie in no plane, they are a surface in space, with
 *  dim 3 and cells, for planish_smooth_surface; such a mesh has no periodic pairs, and the nodes of the
 *  file's pairs are held. constraint is NULL: set it to the array that planish_file_constraints fills. */
PLANISH_API planish_mesh planish_file_mesh(const planish_file *file);

/** Get the elements of planish_file_mesh as cells, for planish_measure_cells, also if all of them are
 *  simplices of order 1. The file owns the arrays, and makes them at the first call, or when the file
 *  is opened if planish_file_mesh has cells. Errors: _MEMORY. */
PLANISH_API int planish_file_cells(planish_file *file, planish_cells *cells, planish_error *error);

/** Coordinates [n_nodes][dim] of planish_file_mesh, in the file's units, to be changed in place. */
PLANISH_API double *planish_file_coordinates(planish_file *file);

/** The plane in which a mesh of flat elements (dim 2) has its coordinates. If an axis of the file
 *  is normal to the plane, the coordinates are two columns of the file, and the third column does
 *  not change. In a tilted plane they belong to a frame with the unit vectors direction, so that
 *  areas and angles are true. Each triangle has the sign that it has seen along axis[2]; this sign
 *  is exact, except for triangles too flat for doubles in the frame. Nodes that are a little off
 *  the plane are off it along that axis. Moved nodes are written on the plane; the others keep
 *  their bytes. */
typedef struct planish_plane {
    int axis
        [3]; /* columns of the file, 0 .. 2 for x .. z: those of coordinates 0 and 1, and the one
                    across the plane: 0 1 2, 1 2 0 or 2 0 1 */
    int is_tilted;          /* 0: orthogonal to an axis */
    double origin[3];       /* where both coordinates are 0 */
    double direction[2][3]; /* unit vectors of coordinates 0 and 1 */
    double normal[3];       /* unit normal of the plane */
    double off;             /* largest distance of the file's nodes from a tilted plane */
    const void *reserved[8];
} planish_plane;

/** Fill in *plane (may be NULL). Returns 0 if the coordinates of the mesh are the first columns of the
 *  file (solids, and flat elements in the plane of x and y), else 1. */
PLANISH_API int planish_file_plane(const planish_file *file, planish_plane *plane);

/** Compute the coordinates in space, xyz [n][3], of nodes first .. first + n - 1 from those of the
 *  mesh [n][dim]. coordinates begins with node first, and may differ from the file's. Errors:
 *  _ARGUMENT. */
PLANISH_API int planish_file_space_coordinates(const planish_file *file, int64_t first, int64_t n,
                                               const double *coordinates, double *xyz,
                                               planish_error *error);

/** Names of the arrays of one whole number per element that the file has (VTK's formats,
 *  Gmsh, CGNS), in the file's order, NULL at the end; the file owns them. Values of other cells
 *  than the elements do not matter. At most 256 arrays are looked at. */
PLANISH_API const char *const *planish_file_cell_arrays(const planish_file *file);

/** Names of the cell arrays that tell regions, NULL at the end; the file owns them. At first they are
 *  the arrays that planish_find_regions finds; nodes between different values of any of them are held
 *  (planish_file_constraints). Entities of a Gmsh file and sections of a CGNS file also tell regions. */
PLANISH_API const char *const *planish_file_region_arrays(const planish_file *file);

/** Choose the arrays that tell regions: names [n_names], each of planish_file_cell_arrays, replace the
 * arrays that were found. n_names 0 keeps the arrays that were found. Either way the values of the
 * arrays are released, so you can choose only once. The chosen arrays also decide which of all listed
 * facets or edges hold nodes. Ask again afterwards for results that depend on regions and groups
 * (planish_file_constraints, _surface, _min_volumes, _element_region, _groups). Errors:
 * _ARGUMENT (a name that the file does not have; the text lists those it has), _MEMORY. */
PLANISH_API int planish_file_choose_regions(planish_file *file, const char *const *names,
                                            int n_names, planish_error *error);

/** An array of numbers that a file has for its nodes or elements. */
typedef struct planish_data_info {
    const char *name; /* the file owns it */
    int of_elements;  /* not 0: values of elements; 0: of nodes */
    int n_components; /* numbers per value in the file */
    const void *reserved[4];
} planish_data_info;

/** Describe array i (from 0, in the file's order) of the file's data. Returns 1, or 0 if there is no such
 *  array. VTK's formats, Gmsh, Exodus and XDMF have data. A name may occur twice, for nodes
 *  and for elements. At most 4096 arrays or parts of arrays are looked at. */
PLANISH_API int planish_file_data_info(const planish_file *file, int64_t i,
                                       planish_data_info *info);

/** Values of nodes or elements. */
typedef struct planish_data {
    int of_elements;  /* not 0: values of elements; 0: of nodes */
    int n_components; /* 1 .. 9 numbers of a value. 1: a scalar. 6, and 3 in two dimensions: a
                         symmetric tensor, lower triangle by rows (11, 12, 22, 13, 23, 33), where
                         it is one. 9, 4: a tensor by rows. Others as the file has them */
    int64_t n;        /* nodes or elements */
    double *values;   /* [n][n_components] owned: planish_data_free */
    const void *reserved[4];
} planish_data;

/** Read the array called name of the file's data. If nodes and elements both have this array, it is that
 *  of nodes. Values are finite, and in the order of the nodes of planish_file_mesh or the elements of
 *  planish_file_cells. The first time step counts. Symmetric tensors of VTK, which has the diagonal first
 *  (xx, yy, zz, xy, yz, xz), are put in the order of planish_data. Each call reads the file again, which
 *  must not have changed. data has no values after an error.
 *  Errors: _ARGUMENT (no such array: the text lists the arrays), _FORMAT (values that are missing, not
 *  finite or not numbers, or more than 9 components), _FILE (a changed file), _MEMORY. */
PLANISH_API int planish_file_data(planish_file *file, const char *name, planish_data *data,
                                  planish_error *error);

/** Read the solution at vertices in a file of Medit, .sol (text) or .solb: sizes as Mmg and other
 *  programs write them. The first solution that is a scalar or a symmetric tensor counts. dim: dimension
 *  of the mesh. A mesh of two dimensions takes a file of three dimensions, too, whose tensors have six
 *  components. n_vertices: nodes of the mesh. data has no values after an error. Errors: _ARGUMENT,
 *  _FILE, _FORMAT (another number of vertices or dimension, vectors alone, values that are missing or
 *  not finite), _MEMORY. */
PLANISH_API int planish_sol_read(const char *path, int dim, int64_t n_vertices, planish_data *data,
                                 planish_error *error);

/** Free the values, and set all fields to 0. data may be NULL. */
PLANISH_API void planish_data_free(planish_data *data);

/** Group of nodes, elements or facets that a file names or numbers. */
typedef struct planish_group {
    const char *tag; /* of planish_hold: its name, or "DIM:N" where it has none; the file owns it */
    int dim;         /* of its elements: 3 solids, 2 faces, 1 lines, 0 nodes */
    int64_t n;       /* number of these elements or nodes */
    const void *reserved[1];
} planish_group;

/** List the groups of the file: *groups [*n], which the file owns; first groups with names, then other
 *  groups with elements or nodes. A name is listed once for each dimension, with the elements of all its
 *  numbers (one in two of them counts twice); for planish_hold it is one group. Errors: _ARGUMENT (one
 *  of the pointers is NULL), _MEMORY; *n is then 0. */
PLANISH_API int planish_file_groups(planish_file *file, const planish_group **groups, int64_t *n,
                                    planish_error *error);

typedef struct planish_hold {
    const char *const *tags; /* [n_tags] "NAME", "N" or "DIM:N" (DMPlex: "LABEL:VALUE", "LABEL"):
                                hold all nodes of these groups */
    int n_tags;
    int ignore_regions; /* not 0: nodes between regions are not held */
    int ignore_marked;  /* not 0: nodes are not held for being among planish_file_get_marked */
    int slide; /* not 0: do not hold nodes that only lines, facets (beside solids), regions and
                  periodic pairs hold: planish_find_slides decides about them */
    const char *const
        *slide_tags;         /* [n_slide_tags] nodes slide only on these groups of facets (2-D: */
    int n_slide_tags;        /* lines); 0: on all */
    const void *reserved[4]; /* NULL */
} planish_hold;

/** Find the nodes that the file (and hold, may be NULL) fixes: constraint [n_nodes] is filled with
 *  planish_constraint. Nodes on the boundary are not among them unless the file says so.
 *  Errors: _ARGUMENT (a tag that the file does not have; the text lists those it has), _MEMORY. */
PLANISH_API int planish_file_constraints(const planish_file *file, const planish_hold *hold,
                                         uint8_t *constraint, planish_error *error);

/** Why a file holds a node, as bits: a node may have several reasons. */
typedef enum planish_file_reason {
    PLANISH_FILE_LINE_OR_POINT = 1, /* on a line or point that the file lists */
    PLANISH_FILE_FACE = 2,          /* on a facet that the file lists beside solids */
    PLANISH_FILE_INTERFACE = 4,     /* between regions */
    PLANISH_FILE_OTHER_ELEMENT = 8, /* on an element of a type that is not smoothed */
    PLANISH_FILE_PERIODIC = 16,     /* in a pair of periodic nodes */
    PLANISH_FILE_FIX = 32,          /* in a group of planish_hold.tags */
    PLANISH_FILE_REQUIRED = 64 /* named in the file: required, in a set, under a load, in `fixed` */
} planish_file_reason;

/** Find out why the file (and hold, may be NULL) holds nodes. Fill reason [n_nodes] with the bits
 *  of each planish_file_reason of a node, 0 if the file does not hold it. hold->slide is ignored.
 *  planish_plan_get_held returns the mesh's own reasons.
 *  Errors: _ARGUMENT (as planish_file_constraints), _MEMORY; reason is then untouched. */
PLANISH_API int planish_file_get_held(const planish_file *file, const planish_hold *hold,
                                      uint8_t *reason, planish_error *error);

/** Find the nodes that VTK's array `fixed` names: fill marked [n_nodes] (may be NULL) with 0 or 1.
 *  Returns the number of these nodes. Mesquite wants all nodes of the boundary in this array, so the
 *  array may only say where the boundary is. */
PLANISH_API int64_t planish_file_get_marked(const planish_file *file, uint8_t *marked);

/** Find the nodes that a boundary condition of the file names (Abaqus' *BOUNDARY). Such conditions
 *  hold no node. supported [n_nodes] (may be NULL) is filled with 0 or 1. Returns the number of
 *  ones. */
PLANISH_API int64_t planish_file_get_supported(const planish_file *file, uint8_t *supported);

/** Names of the first 1000 sets of these boundary conditions, as tags of planish_hold, NULL at the
 *  end; the file owns them. Boundary conditions may also name single nodes. */
PLANISH_API const char *const *planish_file_supported_groups(const planish_file *file);

/** Names of the files that the file includes (Abaqus, Nastran), as it writes them, NULL at the end;
 *  the file owns them. planish_file_write does not copy them. */
PLANISH_API const char *const *planish_file_included(const planish_file *file);

/** Return the file's surface for planish_find_slides: regions, facets (triangles and quadrilaterals
 *  beside solids; 2-D: lines) and lines, by their corners, with their groups as tags, and a tolerance
 *  that fits the digits of the file. A surface in space has only lines. Use it together with the
 *  constraints that planish_file_constraints finds for the same hold (with slide). The file owns the
 *  arrays. */
PLANISH_API planish_surface planish_file_surface(const planish_file *file,
                                                 const planish_hold *hold);

/** Find the minimum volumes of groups, for planish_mesh.min_volume. tags [n_tags] name groups of
 *  elements as in planish_hold, values [n_tags] are their minimum volumes (positive). Fill min_volume
 *  [n_elements] with the largest value of the element's groups, or 0 if it is in none of them. Errors:
 *  _ARGUMENT (a tag that the file does not have; the text
 *  lists those it has), _MEMORY; min_volume is then untouched. */
PLANISH_API int planish_file_min_volumes(const planish_file *file, const char *const *tags,
                                         const double *values, int n_tags, double *min_volume,
                                         planish_error *error);

/** Return the number that the file gives an element or node. The index is that in planish_file_mesh; it
 *  is not checked. */
PLANISH_API int64_t planish_file_element_number(const planish_file *file, int64_t element);
PLANISH_API int64_t planish_file_node_number(const planish_file *file, int64_t node);

/** Find the region of an element, by its index in planish_file_mesh, as a tag for planish_hold.
 * Fill text [size] with the name of its group, or with "DIM:N" if the name means elements of other
 * dimensions, too, or is missing. Fill it with "" if the file has no regions, or no tag for this
 * one. If an element is in several groups, the first named group counts. Returns the length of the
 * tag as snprintf does (with NULL and 0 only the length), or PLANISH_ERROR_ARGUMENT. Elements of one
 * region (planish_file_surface) have the same tag. */
PLANISH_API int planish_file_element_region(const planish_file *file, int64_t element, char *text,
                                            size_t size);

/** Round coordinates [n_nodes][dim] in a tilted plane (planish_file_plane) to those that the file
 *  can hold. Writing rounds them in space, which no planish_options.round can tell planish_smooth:
 *  call this function after planish_smooth and before the result is measured. A node returns to its
 *  coordinates in the file if a triangle or the corner of a quadrilateral has another sign as
 *  written, seen along plane.axis[2] (exactly), than it has in coordinates. Nodes with back [n_nodes]
 *  (may be NULL) not 0 return,
 *  too. Where a file holds less than doubles, coordinates become those that are written. *n_back
 *  (may be NULL) is the number of nodes that returned, and back is set to 1 for these. Meshes that are
 *  not in a tilted plane do not change. Errors: _ARGUMENT, _MEMORY. */
PLANISH_API int planish_file_round_in_plane(const planish_file *file, double *coordinates,
                                            uint8_t *back, int64_t *n_back, planish_error *error);

/** Return 1 if planish_file_write takes path, else 0. It takes a name with the extension of the input or
 *  another extension of its format, a pipe or a device. If the mesh is a folder, it takes this folder,
 *  and names without the extension of a format. planish_file_check_output checks more. */
PLANISH_API int planish_file_can_write(const planish_file *file, const char *path);

/** Check before long work whether planish_file_write to path would fail, wherever nodes go: because
 *  planish_file_can_write does not take the name, files beside it belong to another mesh (TetGen), or
 *  compressed coordinates cannot be written to a pipe. The call does not try to write there. Errors:
 *  _FILE, _ARGUMENT, _MEMORY. */
PLANISH_API int planish_file_check_output(const planish_file *file, const char *path,
                                          planish_error *error);

/** How a file is written. */
typedef struct planish_write_options {
    int threads;             /* 0: as many as OpenMP would use; after a fork one */
    char *temporary;         /* list of the paths of temporary files, or NULL */
    size_t temporary_size;   /* bytes of temporary */
    const void *reserved[4]; /* NULL */
} planish_write_options;

/** Write the file to path with coordinates [n_nodes][dim]: a copy of the input in which only
 * coordinates that differ from those read are replaced.
 * - A regular file is written beside its place and renamed. It keeps the owner, mode, access list and
 *   attributes of the file that it replaces as far as allowed; hard links to that file are broken, and
 *   symbolic links are followed where the system would follow them.
 * - Pipes and devices are written directly (if nobody reads the pipe, a process that does not ignore
 *   SIGPIPE ends).
 * - The files that TetGen has beside .node (.ele, .face, .edge, .neigh, ..: docs/formats.md) are
 *   written, too.
 * - A mesh that is a folder is written to a new folder, which is made beside its place with all files
 *   of the mesh and renamed. If path is the input, only its file of coordinates is replaced.
 * options (NULL: all 0). temporary is a zeroed buffer of the caller that holds the paths of temporary
 * files while they exist, for a signal handler that removes them. Each path ends with '\0', an empty
 * path ends the list. A folder comes before its content: remove paths from the last to the first. A
 * path that does not fit is not listed: give the length of path and 80 bytes for each written file.
 * Errors: _FILE (also if the input has changed since it was read), _MEMORY, _ARGUMENT (a path that
 * planish_file_can_write does not take, coordinates that are not finite). Nothing is left behind then,
 * except if one of TetGen's files cannot be renamed: files that were already renamed stay; .node is
 * renamed last. */
PLANISH_API int planish_file_write(const planish_file *file, const char *path,
                                   const double *coordinates, const planish_write_options *options,
                                   planish_error *error);

/** Return the name of format i, from 0, to which meshes can be converted ("vtu", "gmsh", ...:
 *  docs/formats.md), or NULL after the last. */
PLANISH_API const char *planish_file_target(int i);

/** Return the name of such a format by the extension of path, or NULL if there is none. */
PLANISH_API const char *planish_file_target_of(const char *path);

/** Return 1 if path has the extension of another format to which meshes can be converted, else 0.
 *  For the file's own format use planish_file_can_write. */
PLANISH_API int planish_file_can_convert(const planish_file *file, const char *path);

/** Check, before work is done, that planish_file_convert can write the mesh to path in the format
 *  (NULL: by the extension). Errors: _ARGUMENT as there. */
PLANISH_API int planish_file_check_conversion(const planish_file *file, const char *path,
                                              const char *format, planish_error *error);

/** How a file is converted, and the data that the new file gets besides the mesh. Only VTK's formats get
 *  values of elements, under the names of these fields. Each array may be NULL. */
typedef struct planish_convert_options {
    const char *format; /* a name of planish_file_target; NULL: by the extension of path */
    /* [n_nodes] of planish_constraint: VTK's formats get the array `fixed`, Medit's format the required
       vertices. */
    const uint8_t *constraint;
    const double *radius_ratio; /* [n_elements of planish_file_mesh] planish_measure_elements; only
                                   for triangles or tetrahedra */
    planish_cell_values cells;  /* [n_elements] planish_measure_cells; `state` is
                                   called `cell_state` */
    char *temporary;            /* as for planish_file_write */
    size_t temporary_size;      /* bytes of temporary */
    char *lost;                 /* filled with a list, in words, of the parts that are left out */
    size_t lost_size;           /* bytes of lost; a longer list is cut */
    const void *reserved[4];    /* NULL */
} planish_convert_options;

/** Convert the file, at coordinates [n_nodes][dim], to another format and write it to path: nodes and
 *  elements with their numbers, regions, groups, and arrays of numbers of nodes and elements
 *  (planish_file_data), as far as that format can hold them (docs/formats.md). options (NULL: all 0).
 *  Errors: _FILE, _MEMORY, _ARGUMENT (an unknown format; a format that can hold nothing of the mesh;
 *  coordinates that are not finite); nothing is left behind then, and lost is as before. */
PLANISH_API int planish_file_convert(planish_file *file, const char *path,
                                     const double *coordinates,
                                     const planish_convert_options *options, planish_error *error);

#ifdef __cplusplus
}
#endif
#endif
