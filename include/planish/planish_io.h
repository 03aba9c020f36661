/* planish_io: mesh files for planish. Read one, smooth its coordinates, write it back with every
 * byte but the coordinates of the moved nodes as it was. planish_file_ stands before each name:
 *
 *     open, open_isolated, open_with, close         read a file into memory, free it
 *     formats, get_info, unterminated_path          the format, how the file stores coordinates
 *     mesh, coordinates                             the arrays to smooth; the file owns them
 *     plane, space_coordinates, round_in_plane      triangles: their plane, from it to space
 *     cell_arrays, region_arrays, choose_regions    arrays of numbers that tell regions
 *     data_info, data                               arrays of numbers: sizes, metrics, results
 *     groups                                        tags of what may be held, slide, have volumes
 *     constraints, get_held, get_marked, surface    held nodes, the reasons, where nodes slide
 *     min_volumes, get_parametric                   minimum volumes of groups; nodes on curves
 *     get_supported, supported_groups, included     boundary conditions; included files
 *     element_number, node_number, element_region   how the file calls an element or node
 *     can_write, check_output, write                write the file with the new coordinates
 *     can_convert, convert, target                  write the mesh in another format
 *
 * planish_sol_read reads the sizes that Medit has beside its meshes, planish_data_free frees data.
 *
 * Formats: docs/formats.md lists them; planish_file_formats has their names. Meshes of Elmer and OpenFOAM
 * are folders: a path is then that of the folder. Calls on different files may run at the same time,
 * but of files in HDF5 (CGNS, MED, VTKHDF, DMPlex, Exodus, XDMF) one at a time, unless the HDF5 library is built for
 * threads. Error convention as in planish.h; the text says file, line or byte, and what to do.
 * Functions that cannot fail return 0, NULL or -1 where the file or path is NULL.
 */
#ifndef PLANISH_IO_H
#define PLANISH_IO_H

#include <planish/planish.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A mesh file that has been read. The file should not change while it is open: planish_file_write
 *  refuses to write what it has become then. Files of up to 64 MB, and files in HDF5, are read into
 *  memory. Larger ones are mapped: whatever is written to such a file meanwhile, no call reads or
 *  writes beyond its arrays, but where it becomes shorter the system sends the process SIGBUS. */
typedef struct planish_file planish_file;

/** Read the file at path, or the mesh in the folder at path. format: a name of planish_file_formats, or NULL to tell it by content,
 *  then by extension. threads: 0 as many as OpenMP would use.
 *  Errors: _FILE, _FORMAT, _MEMORY, _ARGUMENT (unknown format). */
PLANISH_API int planish_file_open(const char *path, const char *format, int threads,
                                  planish_file **file, planish_error *error);

/** Open an untrusted file as planish_file_open does, in a process that must not die. The HDF5
 *  library (1.10) crashes on some damaged files, and takes memory without end for others. A file
 *  that needs HDF5 (CGNS, MED, VTKHDF, DMPlex) is therefore first opened in a child process.
 *  Packed coordinates are later changed in a child process, too. Either failure becomes a
 *  _FORMAT error. On Linux the child may take 1 GB, and 4 kB for each byte of the file, but no
 *  more than three quarters of the machine's memory.
 *
 *  Opening these files takes twice the time; planish_file_open opens all other files. The child
 *  is a fork of the caller, of the calling thread alone: no other thread may be within the HDF5
 *  library then. If the caller ignores SIGCHLD or waits for any child elsewhere, the signal in
 *  the error's text is 0. Errors besides: _MEMORY: no process could be started. */
PLANISH_API int planish_file_open_isolated(const char *path, const char *format, int threads,
                                           planish_file **file, planish_error *error);

/** How a file is opened. */
typedef struct planish_open_options {
    const char *format;     /* as for planish_file_open */
    int threads;            /* as for planish_file_open */
    int isolated;           /* not 0: as planish_file_open_isolated does */
    double plane_tolerance; /* of flat elements alone: how far off their plane nodes may be, as a
                               fraction of the diagonal of their bounding box, 0 .. 1e-3; 0: what
                               planish_file_surface says of the file. Beyond they are a surface */
    const void *reserved[6];
} planish_open_options;

/** Open a file as planish_file_open does, with options (NULL: all 0). Errors besides: _ARGUMENT
 *  (plane_tolerance). */
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
    const char *reads;             /* the parts of it that are read */
    int is_read;                   /* 0: this planish was built without the library that it needs */
    const void *reserved[4];
} planish_format_info;

/** Find out what format i, 0 and up, is, in the order of planish_file_formats. Returns 1, or 0 where
 *  there is none. */
PLANISH_API int planish_file_format_info(int i, planish_format_info *info);

typedef struct planish_file_info {
    const char *format;          /* name of the format, static text */
    planish_precision precision; /* what the file stores coordinates as, */
    planish_round_fn *round;     /* and what that rounds to, for planish_options: of the file, */
    void *round_user;            /* as long as that is open */
    int64_t
        n_other_elements; /* elements that are not smoothed: pyramids of second order, polyhedra */
    int64_t n_lower_elements; /* elements of lower dimension */
    int64_t n_regions;        /* distinct regions among the elements */
    int64_t bytes;            /* size of the input */
    int is_unterminated;      /* not 0: the format has no mark at its end, and the last line has
                                    no end: if the file was cut short there, nothing tells */
    int has_normals;          /* not 0: the file has normals of nodes (OFF, OBJ, PLY), which stay as
                                 they are, so that those of moved nodes are wrong */
    double off_plane; /* of a surface in space: how far nodes are off the plane that fits them
                               best, as a fraction of the diagonal of their bounding box; else 0 */
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

/** Return the mesh. The file owns its arrays. Its elements are those of the file's highest dimension,
 *  3 or 2, that a planish_cell_type stands for: first the triangles or tetrahedra of order 1 and 2,
 *  then the others, both in the file's order. They are mesh.cells, in VTK's order of nodes, or
 *  mesh.elements where all are triangles or tetrahedra of order 1. Flat elements have coordinates in
 *  their plane (planish_file_plane), dim 2; if they lie in none, they are a surface in space, with dim 3 and
 *  cells, for planish_smooth_surface; it has no periodic pairs, and those of the file are held. constraint is NULL: the caller sets it to the array that
 *  planish_file_constraints fills in. */
PLANISH_API planish_mesh planish_file_mesh(const planish_file *file);

/** Find the elements of planish_file_mesh as cells, for planish_measure_cells; simplices of order 1
 *  alone, too. The file owns the arrays, which are made at the first call or, where planish_file_mesh
 *  has them, when the file is opened. Errors: _MEMORY. */
PLANISH_API int planish_file_cells(planish_file *file, planish_cells *cells, planish_error *error);

/** Coordinates [n_nodes][dim] of planish_file_mesh, in the file's units, to be changed in place. */
PLANISH_API double *planish_file_coordinates(planish_file *file);

/** The plane in which a mesh of flat elements (dim 2) has its coordinates. Across an axis of the file
 *  these are two of its columns, and the third stays as it is. In a tilted plane they are those of
 *  a frame whose unit vectors are direction, so that areas and angles are the triangles' own, and
 *  each triangle has the sign that it has seen along axis[2], which is exact (but for triangles so
 *  flat that no doubles in the frame say it): nodes that are a little off the plane are off it
 *  along that axis. Nodes that have moved are written on the plane; the others keep their bytes. */
typedef struct planish_plane {
    int axis[3]; /* columns of the file, 0 .. 2 for x .. z: those that coordinates 0 and 1 go along,
                    and the one across: 0 1 2, 1 2 0 or 2 0 1 */
    int is_tilted;          /* 0: across an axis */
    double origin[3];       /* where both coordinates are 0 */
    double direction[2][3]; /* unit vectors of coordinates 0 and 1 */
    double normal[3];       /* unit normal of the plane */
    double off;             /* how far off a tilted plane nodes of the file are, at most */
    const void *reserved[8];
} planish_plane;

/** Fill in *plane (may be NULL). Returns 1 where coordinates of the mesh are not the first columns
 *  of the file, else (solids, and flat elements in the plane of x and y) 0. */
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

/** Names of those of these arrays that tell regions, NULL at the end; the file owns them. When the
 *  file is opened they are those that planish_find_regions finds; nodes between different values of
 *  any of them are held (planish_file_constraints). Entities of a Gmsh file and
 *  sections of a CGNS file tell regions besides.
 */
PLANISH_API const char *const *planish_file_region_arrays(const planish_file *file);

/** Choose the arrays that tell regions: those called names [n_names], each of
 * planish_file_cell_arrays, in place of those found. n_names 0 keeps what was found. Either way
 * the values of the arrays are released, so that names can be chosen once. What was asked of the
 * file's regions and groups before (planish_file_constraints, _surface, _min_volumes,
 * _element_region) is to be asked again. Errors: _ARGUMENT (a name that the file does not have; the
 * text lists those it has), _MEMORY. */
PLANISH_API int planish_file_choose_regions(planish_file *file, const char *const *names,
                                            int n_names, planish_error *error);

/** An array of numbers that a file has for its nodes or elements. */
typedef struct planish_data_info {
    const char *name; /* the file owns it */
    int of_elements;  /* else of nodes */
    int n_components; /* numbers of a value, as the file says */
    const void *reserved[4];
} planish_data_info;

/** Find out what array i (from 0) of the file's data is. Returns 1, or 0 where there is none: VTK's
 *  formats but HDF, Gmsh, Exodus and XDMF have data. The order is the file's. A name may occur twice, of nodes
 *  and of elements. At most 4096 arrays or parts of arrays are looked at. */
PLANISH_API int planish_file_data_info(const planish_file *file, int64_t i,
                                       planish_data_info *info);

/** Values of nodes or elements. */
typedef struct planish_data {
    int of_elements;  /* else of nodes */
    int n_components; /* 1 .. 9 numbers of a value. 1: a scalar. 6, and 3 in two dimensions: a
                         symmetric tensor, lower triangle by rows (11, 12, 22, 13, 23, 33), where
                         it is one. 9, 4: a tensor by rows. Others as the file has them */
    int64_t n;        /* nodes or elements */
    double *values;   /* [n][n_components] owned: planish_data_free */
    const void *reserved[4];
} planish_data;

/** Read the array of the file's data that is called name; the one of nodes, if there is one of elements
 *  besides. Values are those of the nodes of planish_file_mesh, or of the elements of
 *  planish_file_cells, in their order, and finite. The first time step counts. Symmetric tensors of VTK,
 *  which has the diagonal first (xx, yy, zz, xy, yz, xz), are put in the order of planish_data. The file
 *  is read again for each call, and must be as it was. data has no values after an error.
 *  Errors: _ARGUMENT (no such array: the text lists those that there are), _FORMAT (values that are
 *  missing, not finite or no numbers, and more than 9 components), _FILE (a changed file), _MEMORY. */
PLANISH_API int planish_file_data(planish_file *file, const char *name, planish_data *data,
                                  planish_error *error);

/** Read the solution at vertices of a file of Medit's, .sol (text) or .solb: sizes as Mmg and others
 *  have them. Of several solutions the first that is a scalar or a symmetric tensor counts. dim: that
 *  of the mesh; a file of three dimensions is read for a mesh of two, and its tensors have six
 *  components then. n_vertices: nodes of the mesh. data has no values after an error. Errors: _ARGUMENT,
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

/** List the groups of the file: *groups [*n], which the file owns, those with names first, then those
 *  that have elements or nodes. Two that have
 *  one name in different dimensions are listed one by one, and are one group for planish_hold. Errors:
 *  _ARGUMENT (file is NULL), _MEMORY; *n is then 0. */
PLANISH_API int planish_file_groups(planish_file *file, const planish_group **groups, int64_t *n,
                                    planish_error *error);

typedef struct planish_hold {
    const char *const *tags; /* [n_tags] "NAME", "N" or "DIM:N" (DMPlex: "LABEL:VALUE", "LABEL"):
                                hold all nodes of these groups */
    int n_tags;
    int ignore_regions; /* not 0: nodes between regions are not held */
    int ignore_marked;  /* not 0: nodes are not held for being among planish_file_get_marked */
    int slide; /* not 0: nodes that nothing holds but lines, facets (beside solids), regions and
                  periodic pairs are not held: planish_find_slides is to decide about them */
    const char *const *slide_tags; /* [n_slide_tags] groups of facets (2-D: lines) that alone */
    int n_slide_tags;              /* may be slid on; 0: all may */
    const void *reserved[4];       /* NULL */
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
 *  of each planish_file_reason of a node, 0 where the file does not hold it. hold->slide is not
 *  heeded: the reasons are those without it. planish_plan_get_held has the mesh's own reasons.
 *  Errors: _ARGUMENT (as planish_file_constraints), _MEMORY; reason is then untouched. */
PLANISH_API int planish_file_get_held(const planish_file *file, const planish_hold *hold,
                                      uint8_t *reason, planish_error *error);

/** Find the nodes that VTK's array `fixed` names: marked [n_nodes] (may be NULL) is filled with 0
 *  or 1. Return the number of these nodes. Mesquite wants all nodes of the boundary named there, so
 *  that the array may say no more than where the boundary is. */
PLANISH_API int64_t planish_file_get_marked(const planish_file *file, uint8_t *marked);

/** Find the nodes that a boundary condition of the file names (Abaqus' *BOUNDARY), which holds none: supported
 *  [n_nodes] (may be NULL) is filled with 0 or 1. Return the number of these nodes. */
PLANISH_API int64_t planish_file_get_supported(const planish_file *file, uint8_t *supported);

/** Names of the sets that these boundary conditions name, as tags of planish_hold, NULL at the end; the file
 *  owns them. Nodes may be named one by one besides. */
PLANISH_API const char *const *planish_file_supported_groups(const planish_file *file);

/** Names of the files that the file includes (Abaqus, Nastran), as it writes them, NULL at the end; the file
 *  owns them. planish_file_write does not copy them. */
PLANISH_API const char *const *planish_file_included(const planish_file *file);

/** Return the file's surface for planish_find_slides: regions, facets (triangles and quadrilaterals
 *  beside solids; 2-D: lines) and lines (of a surface in space lines alone), by their corners, with their groups as tags, and a
 *  tolerance that fits the digits of the file. Use it together with the constraints that
 *  planish_file_constraints finds for the same hold (with slide). The file owns the arrays. */
PLANISH_API planish_surface planish_file_surface(const planish_file *file,
                                                 const planish_hold *hold);

/** Find the minimum volumes of groups, for planish_mesh.min_volume. min_volume [n_elements] is
 *  filled with the largest of values [n_tags] (positive) whose group, named by tags [n_tags] as in
 *  planish_hold, has the element, and 0 for elements in none of these groups. Groups are those of
 *  elements. Errors: _ARGUMENT (a tag that the file does not have; the text
 *  lists those it has), _MEMORY; min_volume is then untouched. */
PLANISH_API int planish_file_min_volumes(const planish_file *file, const char *const *tags,
                                         const double *values, int n_tags, double *min_volume,
                                         planish_error *error);

/** Return the number that the file gives an element or node, by its index in planish_file_mesh, which
 *  is not checked. */
PLANISH_API int64_t planish_file_element_number(const planish_file *file, int64_t element);
PLANISH_API int64_t planish_file_node_number(const planish_file *file, int64_t node);

/** Find the region of an element, by its index in planish_file_mesh, as a tag for planish_hold:
 * text [size] is filled with the name of its group, or with "DIM:N" where it has none that means
 * elements of this dimension alone; with "" where the file has no regions, or no tag means this
 * one. Of an element in several groups the first that is named counts. Returns the length of the
 * tag as snprintf does (NULL and 0 ask for it alone), or PLANISH_ERROR_ARGUMENT. Time goes by the
 * number of the file's regions: elements of one region (planish_file_surface) have the same tag. */
PLANISH_API int planish_file_element_region(const planish_file *file, int64_t element, char *text,
                                            size_t size);

/** Round coordinates [n_nodes][dim] in a tilted plane (planish_file_plane) to those that the file
 *  can hold. Writing rounds them in space, which no planish_options.round can tell planish_smooth:
 *  call this function after planish_smooth and before the result is measured. A node returns to its
 *  coordinates in the file if a triangle or the corner of a quadrilateral has another sign as
 *  written, seen along plane.axis[2] (exactly), than it has in coordinates. Nodes with back [n_nodes] (may be NULL) not 0 return,
 *  too. Where a file holds less than doubles, coordinates become those that are written. *n_back
 *  (may be NULL) is the number of nodes that returned, and back is set to 1 for these. Meshes in
 *  another plane, or in none, stay as they are. Errors: _ARGUMENT, _MEMORY. */
PLANISH_API int planish_file_round_in_plane(const planish_file *file, double *coordinates,
                                            uint8_t *back, int64_t *n_back, planish_error *error);

/** Return 1 if planish_file_write takes path, else 0. It takes the extension of the input, another
 *  extension of its format, a pipe or a device; of a mesh that is a folder that folder, and names
 *  without the extension of a format. planish_file_check_output knows more. */
PLANISH_API int planish_file_can_write(const planish_file *file, const char *path);

/** Ask, before long work, what planish_file_write to path would fail for wherever nodes go: a name
 *  that planish_file_can_write does not take, files beside it that are of another mesh (TetGen),
 *  compressed coordinates that cannot be written to a pipe. Whether the place can be written is not
 *  tried. Errors: _FILE, _ARGUMENT, _MEMORY. */
PLANISH_API int planish_file_check_output(const planish_file *file, const char *path,
                                          planish_error *error);

/** Write the file to path with coordinates [n_nodes][dim]: a copy of the input in which only
 * coordinates that differ from those read are replaced. A regular file is written beside its place
 * and renamed; owner, mode, access list and attributes of the file that it replaces are kept as
 * far as that is allowed, and hard links to it are broken; symbolic links are followed where the
 * system would follow them; pipes and devices are written directly (a process that does not ignore
 * SIGPIPE ends where nobody reads them). temporary (may be NULL): a buffer of temporary_size bytes,
 * zeroed, that holds the paths of the temporary files while there are any (each ends with '\0', an
 * empty one ends the list), for a signal handler that removes them; one whose path does not fit is
 * not listed: give the length of path and 80 bytes for each file that is written. What TetGen has
 * beside .node (.ele, .face, .edge, .neigh, ..: docs/formats.md) is written along with it. A mesh that is a
 * folder is written to a new folder, which is made beside its place with all files of the mesh and
 * renamed; or, if path is the input's, its file of coordinates is replaced. temporary then lists a
 * folder before what is in it, so that paths are to be removed from the last to the first. Errors:
 * _FILE (also if the input is not what was read any more), _MEMORY, _ARGUMENT (a path that
 * planish_file_can_write does not take, coordinates that are not finite); nothing is left behind
 * then (but if one of TetGen's files cannot be renamed, those that had already been, .node the
 * last, stay where they replaced others). */
PLANISH_API int planish_file_write(const planish_file *file, const char *path,
                                   const double *coordinates, int threads, char *temporary,
                                   size_t temporary_size, planish_error *error);

/** Return the name of format i, 0 and up, that meshes can be converted to ("vtu", "gmsh", ...:
 *  docs/formats.md), or NULL behind the last. */
PLANISH_API const char *planish_file_target(int i);

/** Return that name of the format that the extension of path is of, or NULL: it is of none. */
PLANISH_API const char *planish_file_target_of(const char *path);

/** Return 1 if path has the extension of another format that the mesh can be converted to, else 0.
 *  planish_file_can_write tells those of the file's own format. */
PLANISH_API int planish_file_can_convert(const planish_file *file, const char *path);

/** Data that a converted file gets besides the mesh. VTK's formats alone have values of elements, under
 *  the names of these fields. Each array may be NULL. */
typedef struct planish_view_data {
    const double *radius_ratio; /* [n_elements of planish_file_mesh] planish_measure_elements; shown
                                   of triangles or tetrahedra alone */
    planish_cell_values cells;  /* [n_elements] planish_measure_cells; `state` is
                                   called `cell_state` */
    const char *format;         /* a name of planish_file_target; NULL: by the extension of path */
    const void *reserved[3];    /* NULL */
} planish_view_data;

/** Write what planish understands of the file, at coordinates [n_nodes][dim], to path in another
 *  format: nodes and elements with their numbers, regions, groups, and arrays of numbers of nodes and
 *  elements (planish_file_data) as far as that format has these (docs/formats.md). VTK's formats also
 *  get `fixed` where constraint [n_nodes] (may be NULL) says so, and the values of data (may be NULL).
 *  temporary as for planish_file_write. lost [lost_size] (may be NULL) is filled with what is
 *  left out, as a list in words. Errors: _FILE, _MEMORY, _ARGUMENT (an unknown format; a mesh of which
 *  the format can hold nothing); nothing is left behind then. */
PLANISH_API int planish_file_convert(planish_file *file, const char *path,
                                     const double *coordinates, const uint8_t *constraint,
                                     const planish_view_data *data, char *temporary,
                                     size_t temporary_size, char *lost, size_t lost_size,
                                     planish_error *error);

#ifdef __cplusplus
}
#endif
#endif
