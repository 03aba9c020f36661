/* options: the table of options, and what sets the fields of a command line. */
#include "options/table.h"

#include "base/parallel.h"

#include <errno.h>
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- words for choices ---------------------------------------------------------------------- */

static const char *const method_names[] = {
    [PLANISH_METHOD_PLANISH] = "planish",
    [PLANISH_METHOD_LAPLACIAN] = "laplacian",
    [PLANISH_METHOD_AREA_LAPLACIAN] = "area-laplacian",
    [PLANISH_METHOD_LENGTH_LAPLACIAN] = "length-laplacian",
};
static const char *const objective_names[] = {
    [PLANISH_OBJECTIVE_RADIUS_RATIO] = "radius-ratio",
    [PLANISH_OBJECTIVE_MEAN_RATIO] = "mean-ratio",
    [PLANISH_OBJECTIVE_EDGE_RATIO] = "edge-ratio",
};

const char *pl_method_name(planish_method method) {
    return method_names[method];
}

const char *pl_objective_name(planish_objective objective) {
    return objective_names[objective];
}

/* In the order of the option's words. */
static const struct {
    planish_worst worst;
    const char *name;
} worst_names[] = {
    {PLANISH_WORST_ANGLE, "dihedral"},
    {PLANISH_WORST_RADIUS_RATIO, "radius-ratio"},
    {PLANISH_WORST_ASPECT_RATIO, "aspect-ratio"},
    {PLANISH_WORST_SCALED_JACOBIAN, "scaled-jacobian"},
};

const char *pl_worst_name(planish_worst worst) {
    for (size_t i = 0; i < sizeof worst_names / sizeof *worst_names; i++)
        if (worst_names[i].worst == worst)
            return worst_names[i].name;
    return "";
}

/* ---- values: strictly the whole word, in range, finite ------------------------------------- */

/** The finite decimal number that text begins with; returns what is behind it, or NULL if there is
 *  none. The program never leaves the C locale, so that the decimal point is a point. */
static const char *take_real(const char *text, double *value) {
    const size_t most = strspn(text, "0123456789+-.eE"); /* no spaces, no hexadecimals, no inf */
    char *end = NULL;
    const double number = strtod(text, &end);
    if (end == text || end > text + most || !isfinite(number))
        return NULL;
    *value = number;
    return end;
}

/** The whole of text as a finite decimal number; 0, or -1. */
static int parse_real(const char *text, double *value) {
    const char *end = take_real(text, value);
    return end && *end == '\0' ? 0 : -1;
}

/* ---- setters: each takes the value, or says what it must be --------------------------------- */

/* What it must be are the words of its row. */
static const char NOT_LISTED[] = "";

/** The field that row sets. */
static void *field_of(pl_arguments *arguments, const pl_option *row) {
    return (char *)arguments + row->at;
}

static const char *set_flag(pl_arguments *arguments, const pl_option *row, const char *value) {
    (void)value;
    *(int *)field_of(arguments, row) = (int)row->low;
    return NULL;
}

static const char *set_integer(pl_arguments *arguments, const pl_option *row, const char *value) {
    int *field = field_of(arguments, row);
    if (value[0] == '\0' || value[strspn(value, "0123456789")] != '\0')
        return row->wanted;
    errno = 0;
    const long number = strtol(value, NULL, 10);
    if (errno || (double)number < row->low || (double)number > row->high)
        return row->wanted;
    *field = (int)number;
    return NULL;
}

static const char *set_real(pl_arguments *arguments, const pl_option *row, const char *value) {
    double *number = field_of(arguments, row);
    return parse_real(value, number) || *number < row->low || *number > row->high ? row->wanted
                                                                                  : NULL;
}

static const char *set_text(pl_arguments *arguments, const pl_option *row, const char *value) {
    *(const char **)field_of(arguments, row) = value;
    return value[0] ? NULL : row->wanted;
}

/** Index of value among the words of row, or -1. */
static int find_value(const pl_option *row, const char *value) {
    const size_t length = strlen(value);
    int i = 0;
    for (const char *word = row->values; *word; i++) {
        const size_t n = strcspn(word, " ");
        if (n == length && strncmp(word, value, n) == 0)
            return i;
        word += n + strspn(word + n, " ");
    }
    return -1;
}

/** The words of row are those of an enumeration, in its order. */
static const char *set_choice(pl_arguments *arguments, const pl_option *row, const char *value) {
    const int i = find_value(row, value);
    *(int *)field_of(arguments, row) = i;
    return i < 0 ? NOT_LISTED : NULL;
}

/** Set a text that is one of the words of row. */
static const char *set_word(pl_arguments *arguments, const pl_option *row, const char *value) {
    *(const char **)field_of(arguments, row) = value;
    return find_value(row, value) < 0 ? NOT_LISTED : NULL;
}

static const char *set_objective(pl_arguments *arguments, const pl_option *row, const char *value) {
    arguments->objective_given = row->value ? "--objective" : "--best";
    arguments->worst = strcmp(value, "worst") == 0;
    const int i = arguments->worst ? PLANISH_OBJECTIVE_RADIUS_RATIO : find_value(row, value);
    arguments->library.objective = (planish_objective)i;
    return i < 0 ? NOT_LISTED : NULL;
}

static const char *set_worst_measure(pl_arguments *arguments, const pl_option *row,
                                     const char *value) {
    const int i = find_value(row, value);
    arguments->worst_measure = worst_names[i < 0 ? 0 : i].worst;
    return i < 0 ? NOT_LISTED : NULL;
}

static const char *set_layers(pl_arguments *arguments, const pl_option *row, const char *value) {
    static const pl_layers_asked asked[] = {PL_LAYERS_HELD, PL_LAYERS_KEPT, PL_LAYERS_IGNORED};
    const int i = find_value(row, value);
    arguments->layers = asked[i < 0 ? 0 : i];
    if (value[0] && value[strspn(value, "0123456789")] == '\0')
        return "must be hold, keep or ignore; for rings of elements around give --rings";
    return i < 0 ? NOT_LISTED : NULL;
}

/** V for all elements; the last '=' ends a tag, which may have others in its name. */
static const char *set_min_volume(pl_arguments *arguments, const pl_option *row,
                                  const char *value) {
    const char *sign = strrchr(value, '=');
    double volume;
    if (parse_real(sign ? sign + 1 : value, &volume) || volume <= 0 || sign == value)
        return row->wanted;
    if (!sign) {
        if (arguments->library.min_volume > 0)
            return "is a second volume for all elements; give TAG=V for a group";
        arguments->library.min_volume = volume;
        return NULL;
    }
    char *tag = strdup(value);
    if (!tag)
        return "needs too much memory";
    tag[sign - value] = '\0';
    arguments->min_volume_tag[arguments->n_min_volumes] = tag;
    arguments->min_volume_value[arguments->n_min_volumes++] = volume;
    return NULL;
}

static const char *set_box(pl_arguments *arguments, const pl_option *row, const char *value) {
    double *box = arguments->box;
    int n = 0;
    const char *end = take_real(value, &box[n++]);
    while (n < 6 && end && *end == ',')
        end = take_real(end + 1, &box[n++]);
    const int dim = n / 2;
    if (!end || *end || (n != 4 && n != 6))
        return row->wanted;
    for (int d = 0; d < dim; d++)
        if (box[d] > box[dim + d])
            return "must begin with the lower corner: X0 <= X1 and so on";
    arguments->n_box = n;
    return NULL;
}

/** Set a distance above 0, with an h behind it in edges, and its unit. Returns whether it is one. */
static int set_distance(const char *value, double *distance, planish_length_unit *unit) {
    const char *end = take_real(value, distance);
    if (!end || *distance <= 0 || (strcmp(end, "") != 0 && strcmp(end, "h") != 0))
        return 0;
    *unit = *end ? PLANISH_UNIT_EDGE : PLANISH_UNIT_MESH;
    return 1;
}

static const char *set_max_displacement(pl_arguments *arguments, const pl_option *row,
                                        const char *value) {
    planish_options *library = &arguments->library;
    return set_distance(value, &library->max_displacement, &library->displacement_unit)
               ? NULL
               : row->wanted;
}

static const char *set_surface_tolerance(pl_arguments *arguments, const pl_option *row,
                                         const char *value) {
    planish_options *library = &arguments->library;
    return set_distance(value, &library->surface_tolerance, &library->surface_tolerance_unit)
               ? NULL
               : row->wanted;
}

static const char *set_fix(pl_arguments *arguments, const pl_option *row, const char *value) {
    arguments->fix[arguments->n_fix++] = value;
    return value[0] ? NULL : row->wanted;
}

static const char *set_slide(pl_arguments *arguments, const pl_option *row, const char *value) {
    const int is_none = strcmp(value, "none") == 0, is_curved = strcmp(value, "curved") == 0;
    const int is_plain = is_none || strcmp(value, "auto") == 0;
    arguments->slide = !is_none;
    arguments->slide_given = 1;
    arguments->slides_none = is_none;
    arguments->curved_if_any = 0;
    arguments->slide_curved = is_curved || (arguments->slide_curved && !is_plain);
    if (is_plain)
        arguments->n_slide_tags = 0;
    else if (!is_curved)
        arguments->slide_tag[arguments->n_slide_tags++] = value;
    return value[0] ? NULL : row->wanted;
}

/** --regions NAME, and --ignore-regions. */
static const char *set_regions(pl_arguments *arguments, const pl_option *row, const char *value) {
    arguments->ignore_regions = !value || strcmp(value, "none") == 0;
    if (arguments->ignore_regions)
        arguments->n_regions = 0;
    else
        arguments->regions[arguments->n_regions++] = value;
    return !value || value[0] ? NULL : row->wanted;
}

static const char *set_best(pl_arguments *arguments, const pl_option *row, const char *value) {
    (void)value;
    set_slide(arguments, row, "curved");
    arguments->curved_if_any = 1;
    return set_objective(arguments, row, "worst");
}

static const char *set_fast(pl_arguments *arguments, const pl_option *row, const char *value) {
    (void)row;
    (void)value;
    arguments->library.tolerance = 1e-3;
    return NULL;
}

static const char *set_verbose(pl_arguments *arguments, const pl_option *row, const char *value) {
    (void)row;
    (void)value;
    arguments->verbosity = arguments->verbosity >= PL_VERBOSE ? PL_DETAILED : PL_VERBOSE;
    return NULL;
}

/* ---- the table ------------------------------------------------------------------------------ */

enum {
    SMOOTH = PL_COMMAND_SMOOTH,
    QUALITY = PL_COMMAND_QUALITY,
    REPORT = PL_COMMAND_REPORT,
    CONVERT = PL_COMMAND_CONVERT,
    ADVISE = PL_COMMAND_ADVISE,
    COMPARE = PL_COMMAND_COMPARE,
    GROUPS = PL_COMMAND_GROUPS,
    BOTH = SMOOTH | QUALITY,
    MEASURE = BOTH | ADVISE | COMPARE,
    ALL = PL_COMMANDS_ALL,
    OPTIMISES = PL_OPTION_OPTIMISES,
    OF_WORST = PL_OPTION_OF_WORST,
    OF_CURVED = PL_OPTION_OF_CURVED
};

#define FILES       PL_SECTION_FILES
#define OBJECTIVE   PL_SECTION_OBJECTIVE
#define CONSTRAINTS PL_SECTION_CONSTRAINTS
#define NODES       PL_SECTION_NODES
#define END         PL_SECTION_END
#define OTHERS      PL_SECTION_OTHERS

static const char *const section_titles[] = {
    [FILES] = "Files and reports",
    [OBJECTIVE] = "Objective",
    [CONSTRAINTS] = "Constraints",
    [NODES] = "Nodes that move",
    [END] = "End",
    [OTHERS] = "Threads and messages",
};

#define AT(field) offsetof(pl_arguments, field)
/* Bounds that are not reached: the doubles next to 0 and 1. */
#define ABOVE_0        0x1p-1074
#define BELOW_1        (1 - DBL_EPSILON / 2)
#define FILE_OR_STDOUT "must be the name of a file, or - for standard output"

static const pl_option option_table[] = {
    {FILES, 'o', "output", "OUT", SMOOTH, set_text, AT(output), 0, 0, "must be the name of a file",
     "write the smoothed mesh to OUT, which may be IN; keep\n"
     "the format of IN and change only coordinates; if OUT\n"
     "has the extension of another format that planish\n"
     "convert writes, convert to that format",
     "file"},
    {FILES, 'o', "output", "OUT", CONVERT, set_text, AT(output), 0, 0, "must be the name of a file",
     "write the converted mesh to OUT, and replace an\n"
     "existing file; without -o, OUT must not exist yet",
     "file"},
    {FILES, 'o', "output", "VIEW", QUALITY, set_text, AT(output), 0, 0,
     "must be the name of a file",
     "write a copy for viewing to VIEW (.vtu or .vtk), with\n"
     "the measures of every element",
     "file"},
    {FILES, 'o', "output", "FILE", REPORT, set_text, AT(output), 0, 0, "must be the name of a file",
     "write the HTML report to FILE, - for standard output\n"
     "(default: RESULT.html beside RESULT.json)",
     "file"},
    {FILES, 0, "output-dir", "DIR", SMOOTH, set_text, AT(output_dir), 0, 0,
     "must be the name of a folder",
     "write each smoothed mesh to folder DIR under its own\n"
     "name, and replace existing files there; IN may be\n"
     "several meshes",
     "file"},
    {FILES, 0, "in-place", NULL, SMOOTH, set_flag, AT(in_place), 1, 0, NULL,
     "replace IN by the smoothed mesh; IN may be several\nmeshes", NULL},
    {FILES, 0, "format", "NAME", MEASURE | CONVERT | GROUPS, set_word, AT(format), 0, 0, NULL,
     "set the format of the input: gmsh, medit, vtk, vtu,\n"
     "vtkhdf, med, cgns, dmplex, tetgen, netgen, abaqus,\n"
     "nastran, off, stl, obj, ply, mfem, exodus, ucd, su2,\n"
     "unv, xdmf, elmer or openfoam (default: detect it by\n"
     "content, then by name)",
     "gmsh medit vtk vtu vtkhdf med cgns dmplex tetgen netgen abaqus nastran off stl obj ply mfem "
     "exodus ucd su2 unv xdmf elmer openfoam"},
    {FILES, 0, "to", "NAME", CONVERT, set_word, AT(to), 0, 0, NULL,
     "write the format NAME: vtu, vtk, gmsh (4.1), gmsh22,\n"
     "medit, abaqus, nastran, exodus, stl, obj or ply\n"
     "(default: by the extension of OUT)",
     "vtu vtk gmsh gmsh22 medit abaqus nastran exodus stl obj ply"},
    {FILES, 0, "json", "FILE", BOTH | COMPARE, set_text, AT(json), 0, 0, FILE_OR_STDOUT,
     "write the result as JSON to FILE, - for standard\n"
     "output",
     "file"},
    {FILES, 0, "report", "FILE.html", BOTH | COMPARE, set_text, AT(report), 0, 0, FILE_OR_STDOUT,
     "write an HTML report with tables, histograms,\n"
     "convergence and a picture to FILE.html, - for\n"
     "standard output",
     "file"},
    {FILES, 0, "history", "K", SMOOTH, set_integer, AT(history), 3, 100,
     "must be a whole number from 3 to 100",
     "with --report: let the page play the smoothing, as at\n"
     "most K states of the mesh, the first and the last\n"
     "among them (default: these two alone)",
     NULL},
    {OBJECTIVE, 0, "best", NULL, SMOOTH | OPTIMISES, set_best, 0, 0, 0, NULL,
     "improve the worst elements most, which takes longer:\n"
     "same as --slide curved --objective worst; for a mesh\n"
     "in a plane same as --slide auto --objective worst",
     NULL},
    {OBJECTIVE, 0, "objective", "NAME", SMOOTH | OPTIMISES, set_objective, 0, 0, 0, NULL,
     "minimise the RMS of radius-ratio (default for\n"
     "triangles and tetrahedra), mean-ratio (default for\n"
     "other elements) or edge-ratio; or worst: minimise the\n"
     "default, then improve the worst elements",
     "radius-ratio mean-ratio edge-ratio worst"},
    {OBJECTIVE, 0, "worst-measure", "NAME", SMOOTH | OPTIMISES | OF_WORST, set_worst_measure, 0, 0,
     0, NULL,
     "with --objective worst, improve this measure: for\n"
     "triangles and tetrahedra dihedral (smallest and\n"
     "largest angles, default) or radius-ratio; for other\n"
     "elements scaled-jacobian (default) or aspect-ratio",
     "dihedral radius-ratio aspect-ratio scaled-jacobian"},
    {OBJECTIVE, 0, "worst-rise", "R", SMOOTH | OPTIMISES | OF_WORST, set_real,
     AT(library.worst_rise), 0, 1e6, "must be a number from 0 to 1e6",
     "with --objective worst, let the RMS rise by at most\n"
     "the fraction R (default 0.01)",
     NULL},
    {OBJECTIVE, 0, "like", "FILE", BOTH | ADVISE | OPTIMISES, set_text, AT(like), 0, 0,
     "must be the name of a file",
     "give each element the shape that it has in FILE, the\n"
     "same mesh before it was deformed, in any format:\n"
     "layers and gradings survive; with quality: measure\n"
     "against that shape (default: the regular element)",
     "file"},
    {OBJECTIVE, 0, "size", "NAME", BOTH | OPTIMISES, set_text, AT(size), 0, 0,
     "must be the name of an array of the file",
     "give elements the relative sizes in array NAME of IN\n"
     "(VTK, Gmsh, Exodus, XDMF): lengths of edges, or\n"
     "metrics (symmetric tensors), at nodes or elements;\n"
     "with quality: compare with these sizes",
     NULL},
    {OBJECTIVE, 0, "size-from", "FILE", BOTH | OPTIMISES, set_text, AT(size_from), 0, 0,
     "must be the name of a file",
     "give elements the relative sizes or metrics in FILE,\n"
     "a .sol or .solb file of Medit for the nodes of IN",
     "file"},
    {OBJECTIVE, 0, "keep-sizes", NULL, SMOOTH | OPTIMISES, set_flag, AT(keep_sizes), 1, 0, NULL,
     "keep the sizes that elements have at each place in IN", NULL},
    {OBJECTIVE, 0, "size-weight", "W", SMOOTH | OPTIMISES, set_real, AT(library.size_weight), 0, 1,
     "must be a number from 0 to 1",
     "with --like or sizes: weigh sizes by W and shapes by\n"
     "1 - W (default: 0 with --like, else 0.9); above 0\n"
     "shapes alone may get worse",
     NULL},
    {OBJECTIVE, 0, "area-weight", "MU2", SMOOTH | OPTIMISES, set_real, AT(library.area_weight), 0,
     1, "must be a number from 0 to 1",
     "minimise (1 - MU2) * RMS(objective)\n"
     "+ MU2 * RMS(1 - volume/V) (default 0)",
     NULL},
    {OBJECTIVE, 0, "curve-quality", "Q", SMOOTH | OPTIMISES, set_real, AT(library.curve_quality), 0,
     1, "must be a number from 0 to 1",
     "let mid-side nodes move on their own where the least\n"
     "Jacobian of a curved element is below Q times its\n"
     "mean (default 0.3; 0: they only follow their corners)",
     NULL},
    {OBJECTIVE, 0, "method", "NAME", SMOOTH, set_choice, AT(library.method), 0, 0, NULL,
     "move nodes by the method planish (default) or, for\n"
     "comparison only, laplacian, area-laplacian or\n"
     "length-laplacian, which may invert elements",
     "planish laplacian area-laplacian length-laplacian"},
    {OBJECTIVE, 0, "direction", "NAME", SMOOTH | OPTIMISES, set_choice, AT(library.search), 0, 0,
     NULL,
     "use the search direction newton (default) or\n"
     "fletcher-reeves",
     "newton fletcher-reeves"},
    {CONSTRAINTS, 0, "min-volume", "[TAG=]V", BOTH, set_min_volume, 0, 0, 0,
     "must be a volume (area in 2-D) above 0, or TAG=V with V above 0",
     "require at least volume V (area in 2-D) of every\n"
     "element, or of the elements in group TAG; repeatable\n"
     "with a TAG (default: no minimum)",
     NULL},
    {CONSTRAINTS, 0, "min-volume-fraction", "F", BOTH, set_real, AT(library.min_volume_fraction),
     ABOVE_0, BELOW_1, "must be a number between 0 and 1",
     "like --min-volume, with V = F times the volume of the\n"
     "whole mesh",
     NULL},
    {CONSTRAINTS, 0, "box", "X0,Y0[,Z0],X1,Y1[,Z1]", SMOOTH, set_box, 0, 0, 0,
     "must be X0,Y0,X1,Y1, in 3-D X0,Y0,Z0,X1,Y1,Z1",
     "keep movable nodes inside this box; do not move nodes\n"
     "that start outside",
     NULL},
    {CONSTRAINTS, 0, "max-displacement", "D", SMOOTH, set_max_displacement, 0, 0, 0,
     "must be a distance above 0, or a number and h for that many edge lengths",
     "move no node farther than D from its place in IN; Dh,\n"
     "such as 0.5h, means D times the mean length of the\n"
     "node's edges (default: no limit)",
     NULL},
    {CONSTRAINTS, 0, "no-untangle", NULL, SMOOTH | OPTIMISES, set_flag, AT(library.untangle), 0, 0,
     NULL,
     "leave inverted elements alone (default: repair them\n"
     "first if possible)",
     NULL},
    {NODES, 0, "only-worse-than", "RR", SMOOTH | OPTIMISES, set_real, AT(library.only_worse_than),
     1, DBL_MAX, "must be a ratio, 1 or more",
     "move only nodes of elements whose radius ratio is\n"
     "above RR; in meshes with other elements the aspect\n"
     "ratio (default: move all)",
     NULL},
    {NODES, 0, "rings", "K", SMOOTH | OPTIMISES, set_integer, AT(library.rings), 0, 100,
     "must be a whole number from 0 to 100",
     "with --only-worse-than: also move nodes of K rings of\n"
     "elements around these (default 0)",
     NULL},
    {NODES, 0, "fix", "TAG", MEASURE, set_fix, 0, 0, 0, "must be the NAME, N or DIM:N of a group",
     "hold all nodes of group TAG, given as NAME, N or\n"
     "DIM:N (planish groups FILE lists the groups);\n"
     "repeatable",
     "group"},
    {NODES, 0, "layers", "HOW", MEASURE, set_layers, 0, 0, 0, NULL,
     "treat boundary layers, which are thin on purpose:\n"
     "hold their nodes, keep their heights while nodes move\n"
     "along the layer, or ignore layers (default: keep\n"
     "layers with wedges, hexahedra or quadrilaterals, and\n"
     "ignore others)",
     "hold keep ignore"},
    {NODES, 0, "fix-layers", NULL, MEASURE, set_flag, AT(fix_layers), 1, 0, NULL,
     "same as --layers hold", NULL},
    {NODES, 0, "regions", "NAME", MEASURE, set_regions, 0, 0, 0,
     "must be the name of an array of the file, or none",
     "hold nodes between regions, the values of the element\n"
     "array NAME; repeatable; none: let these nodes move\n"
     "(default: all arrays that look like regions)",
     "none"},
    {NODES, 0, "ignore-regions", NULL, MEASURE, set_regions, 0, 0, 0, NULL,
     "let nodes between regions (materials) move; same as\n"
     "--regions none",
     NULL},
    {NODES, 0, "slide", "HOW", SMOOTH | OPTIMISES, set_slide, 0, 0, 0,
     "must be auto, curved, none, or the NAME, N or DIM:N of a group",
     "let boundary nodes slide: auto (in planes and along\n"
     "straight edges: the shape stays the same), curved (on\n"
     "curved surfaces, too), none, or only on a group\n"
     "(NAME, N or DIM:N; repeatable); default: none, for\n"
     "surface meshes in space curved, where none holds only\n"
     "the nodes on curves",
     "auto curved none group"},
    {NODES, 0, "slide-interfaces", NULL, SMOOTH | OPTIMISES | OF_CURVED, set_flag,
     AT(slide_interfaces), 1, 0, NULL,
     "with --slide curved: let nodes slide on curved\ninterfaces between regions, too", NULL},
    {NODES, 0, "surface-tolerance", "T", SMOOTH | OPTIMISES | OF_CURVED, set_surface_tolerance, 0,
     0, 0, "must be a distance above 0, or a number and h for that many edge lengths",
     "on curved surfaces: keep every point within T of the\n"
     "original surface; Th means T times the mean length of\n"
     "the edges there (default 0.05h)",
     NULL},
    {NODES, 0, "surface-of", "FILE", BOTH | OF_CURVED, set_text, AT(surface_of), 0, 0,
     "must be the name of a file",
     "take the original surface from FILE, a mesh with the\n"
     "same elements, so that the errors of repeated runs do\n"
     "not add up (default: IN); with quality: report the\n"
     "distance from that surface",
     "file"},
    {NODES, 0, "onto", "FILE", SMOOTH | OPTIMISES, set_text, AT(onto), 0, 0,
     "must be the name of a file",
     "fit the surface to the surface in FILE (STL, OBJ, any\n"
     "format): move nodes there as far as elements stay\n"
     "valid, then let these nodes slide along that surface",
     "file"},
    {NODES, 0, "crease-angle", "A", BOTH | OF_CURVED, set_real, AT(crease_angle), ABOVE_0, 180,
     "must be a number of degrees above 0, up to 180",
     "on curved surfaces: keep sharp the edges where the\n"
     "surface bends by more than A degrees, and borders of\n"
     "groups (default: find sharp edges)",
     NULL},
    {NODES, 0, "slide-tolerance", "T", MEASURE, set_real, AT(slide_tolerance), ABOVE_0, 1e-3,
     "must be a fraction above 0, up to 1e-3",
     "accept nodes that are off their plane or line by up\n"
     "to T times the diagonal of the bounding box (default\n"
     "1e-8, more if the file has few digits); also for\n"
     "triangles in a tilted plane",
     NULL},
    {END, 0, "fast", NULL, SMOOTH, set_fast, 0, 0, 0, NULL, "stop early: same as --tolerance 1e-3",
     NULL},
    {END, 0, "max-sweeps", "N", SMOOTH, set_integer, AT(library.max_sweeps), 0, INT_MAX,
     "must be a whole number, 0 or more",
     "stop after N smoothing sweeps, and N more if nodes\n"
     "must return; untangling has its own limit\n"
     "(default 200)",
     NULL},
    {END, 0, "tolerance", "T", SMOOTH, set_real, AT(library.tolerance), 0, BELOW_1,
     "must be a number from 0 to less than 1",
     "stop when the RMS falls by less than the fraction T\n"
     "per sweep (default 1e-5)",
     NULL},
    {END, 0, "time-limit", "S", SMOOTH, set_real, AT(library.time_limit), ABOVE_0, DBL_MAX,
     "must be a number of seconds above 0",
     "stop smoothing after S seconds (reading and set-up do\n"
     "not count), write the mesh and exit with status 1\n"
     "(default: no limit)",
     NULL},
    {OTHERS, 'j', "threads", "N", MEASURE | CONVERT, set_integer, AT(library.threads), 1,
     PL_MAX_THREADS, "must be a whole number from 1 to 1024",
     "run on N threads (default: OMP_NUM_THREADS, else one\n"
     "for each core, fewer for a small mesh)",
     NULL},
    {OTHERS, 0, "bind", "HOW", MEASURE, set_choice, AT(leave_unbound), 0, 0, NULL,
     "auto (default): bind one thread to each core, if\n"
     "there are enough cores and no variable of OpenMP says\n"
     "otherwise; none: leave threads unbound",
     "auto none"},
    {OTHERS, 0, "worst", "N", QUALITY, set_integer, AT(n_worst), 1, INT_MAX,
     "must be a whole number, 1 or more",
     "list the N worst elements, here and in the reports\n"
     "(default: none here, 10 in the reports)",
     NULL},
    {OTHERS, 'v', "verbose", NULL, SMOOTH | PL_OPTION_DOUBLED, set_verbose, 0, 0, 0, NULL,
     "print one line per sweep, and the placement of the\n"
     "threads; -vv: one line per colour as well",
     NULL},
    {OTHERS, 'q', "quiet", NULL, ALL & ~(ADVISE | GROUPS), set_flag, AT(verbosity), PL_QUIET, 0,
     NULL, "print nothing but errors", NULL},
    {OTHERS, 'h', "help", NULL, ALL, set_flag, AT(help), 1, 0, NULL, "show this help and exit",
     NULL},
    {OTHERS, 0, "version", NULL, ALL, set_flag, AT(version), 1, 0, NULL,
     "show the version and exit", NULL},
};

enum { N_OPTIONS = sizeof option_table / sizeof option_table[0] };
_Static_assert((int)N_OPTIONS <= (int)PL_MOST_OPTIONS, "a table of that many options");

const pl_option *pl_option_at(int i) {
    return i < N_OPTIONS ? &option_table[i] : NULL;
}

const char *pl_section_title(pl_section section) {
    return section_titles[section];
}
