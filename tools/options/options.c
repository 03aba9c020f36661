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

#define AT(field) offsetof(pl_arguments, field)
/* Bounds that are not reached: the doubles next to 0 and 1. */
#define ABOVE_0        0x1p-1074
#define BELOW_1        (1 - DBL_EPSILON / 2)
#define FILE_OR_STDOUT "must be the name of a file, or - for standard output"

static const pl_option option_table[] = {
    {'o', "output", "OUT", SMOOTH, set_text, AT(output), 0, 0, "must be the name of a file",
     "write the smoothed mesh to OUT, which may be IN; keep\n"
     "the format of IN and change coordinates only; convert\n"
     "to another format that planish convert writes if OUT\n"
     "ends as its files do",
     "file"},
    {'o', "output", "OUT", CONVERT, set_text, AT(output), 0, 0, "must be the name of a file",
     "write the converted mesh to OUT; without -o, OUT must\n"
     "not be there yet",
     "file"},
    {0, "output-dir", "DIR", SMOOTH, set_text, AT(output_dir), 0, 0, "must be the name of a folder",
     "write each smoothed mesh to folder DIR, under the\n"
     "name that it has, and replace files there; IN may be\n"
     "several meshes",
     "file"},
    {0, "in-place", NULL, SMOOTH, set_flag, AT(in_place), 1, 0, NULL,
     "replace IN by the smoothed mesh; IN may be several\nmeshes", NULL},
    {0, "best", NULL, SMOOTH | OPTIMISES, set_best, 0, 0, 0, NULL,
     "reach the best worst elements, which takes longer:\n"
     "same as --slide curved --objective worst, in a plane\n"
     "--slide auto --objective worst",
     NULL},
    {0, "fast", NULL, SMOOTH, set_fast, 0, 0, 0, NULL, "stop early: same as --tolerance 1e-3",
     NULL},
    {'o', "output", "VIEW", QUALITY, set_text, AT(output), 0, 0, "must be the name of a file",
     "write a copy for viewing to VIEW, which ends in .vtu\n"
     "or .vtk, with the measures of all elements",
     "file"},
    {'o', "output", "FILE", REPORT, set_text, AT(output), 0, 0, "must be the name of a file",
     "write the HTML report to FILE, - for standard output\n"
     "(default: RESULT.html beside RESULT.json)",
     "file"},
    {0, "to", "NAME", CONVERT, set_word, AT(to), 0, 0, NULL,
     "write the format NAME: vtu, vtk, gmsh (4.1), gmsh22,\n"
     "medit, abaqus, nastran, exodus, stl, obj or ply\n"
     "(default: by the extension of OUT)",
     "vtu vtk gmsh gmsh22 medit abaqus nastran exodus stl obj ply"},
    {0, "format", "NAME", MEASURE | CONVERT | GROUPS, set_word, AT(format), 0, 0, NULL,
     "set the format of the input: gmsh, medit, vtk, vtu,\n"
     "vtkhdf, med, cgns, dmplex, tetgen, netgen, abaqus,\n"
     "nastran, off, stl, obj, ply, mfem, exodus, ucd, su2,\n"
     "unv, xdmf, elmer or openfoam (default: detect it by\n"
     "content, then by name)",
     "gmsh medit vtk vtu vtkhdf med cgns dmplex tetgen netgen abaqus nastran off stl obj ply mfem "
     "exodus ucd su2 unv xdmf elmer openfoam"},
    {0, "method", "NAME", SMOOTH, set_choice, AT(library.method), 0, 0, NULL,
     "move nodes by planish (default) or, for comparison,\n"
     "laplacian, area-laplacian or length-laplacian, which\n"
     "may invert elements",
     "planish laplacian area-laplacian length-laplacian"},
    {0, "objective", "NAME", SMOOTH | OPTIMISES, set_objective, 0, 0, 0, NULL,
     "minimise the RMS of radius-ratio (default of\n"
     "triangles and tetrahedra), mean-ratio (default of\n"
     "other elements) or edge-ratio; or worst: minimise the\n"
     "default, then improve the worst elements",
     "radius-ratio mean-ratio edge-ratio worst"},
    {0, "worst-measure", "NAME", SMOOTH | OPTIMISES | OF_WORST, set_worst_measure, 0, 0, 0, NULL,
     "improve this with --objective worst: dihedral (the\n"
     "smallest and largest angles, default) or radius-ratio\n"
     "of triangles and tetrahedra; scaled-jacobian\n"
     "(default) or aspect-ratio of other elements",
     "dihedral radius-ratio aspect-ratio scaled-jacobian"},
    {0, "worst-rise", "R", SMOOTH | OPTIMISES | OF_WORST, set_real, AT(library.worst_rise), 0, 1e6,
     "must be a number from 0 to 1e6",
     "allow a relative RMS increase of R for the worst\n"
     "elements (default 0.01)",
     NULL},
    {0, "direction", "NAME", SMOOTH | OPTIMISES, set_choice, AT(library.search), 0, 0, NULL,
     "use the search direction newton (default) or\n"
     "fletcher-reeves",
     "newton fletcher-reeves"},
    {0, "min-volume", "[TAG=]V", BOTH, set_min_volume, 0, 0, 0,
     "must be a volume (area in 2-D) above 0, or TAG=V with such a V",
     "require volume V (area in 2-D) or more of every\n"
     "element, or of those of group TAG (default: none);\n"
     "repeatable with a TAG",
     NULL},
    {0, "min-volume-fraction", "F", BOTH, set_real, AT(library.min_volume_fraction), ABOVE_0,
     BELOW_1, "must be a number between 0 and 1", "set V to F times the volume of all elements",
     NULL},
    {0, "area-weight", "MU2", SMOOTH | OPTIMISES, set_real, AT(library.area_weight), 0, 1,
     "must be a number from 0 to 1",
     "minimise (1 - MU2) RMS of the objective + MU2 RMS of\n1 - volume/V (default 0)", NULL},
    {0, "box", "X0,Y0[,Z0],X1,Y1[,Z1]", SMOOTH, set_box, 0, 0, 0,
     "must be X0,Y0,X1,Y1, in 3-D X0,Y0,Z0,X1,Y1,Z1",
     "keep movable nodes in the box; nodes outside stay", NULL},
    {0, "max-displacement", "D", SMOOTH, set_max_displacement, 0, 0, 0,
     "must be a distance above 0, or a number and h for that many edge lengths",
     "move no node farther than D from its place in IN, or\n"
     "with Dh than D times the mean length of its edges\n"
     "(default: no limit)",
     NULL},
    {0, "no-untangle", NULL, SMOOTH | OPTIMISES, set_flag, AT(library.untangle), 0, 0, NULL,
     "leave inverted elements alone (default: repair them\n"
     "first if possible)",
     NULL},
    {0, "max-sweeps", "N", SMOOTH, set_integer, AT(library.max_sweeps), 0, INT_MAX,
     "must be a whole number, 0 or more",
     "stop after N sweeps of the untangled mesh, and N more\n"
     "if nodes have to return (default 200)",
     NULL},
    {0, "tolerance", "T", SMOOTH, set_real, AT(library.tolerance), 0, BELOW_1,
     "must be a number from 0 to less than 1",
     "stop when the RMS falls by less than the fraction T\n"
     "per sweep (default 1e-5)",
     NULL},
    {0, "time-limit", "S", SMOOTH, set_real, AT(library.time_limit), ABOVE_0, DBL_MAX,
     "must be a number of seconds above 0",
     "stop smoothing after S seconds (reading and set-up do\n"
     "not count), write the mesh and exit with status 1\n"
     "(default: no limit)",
     NULL},
    {0, "fix", "TAG", MEASURE, set_fix, 0, 0, 0, "must be the NAME, N or DIM:N of a group",
     "hold all nodes of group TAG: its NAME, N or DIM:N\n"
     "(planish groups FILE lists them); repeatable",
     "group"},
    {0, "layers", "HOW", MEASURE, set_layers, 0, 0, 0, NULL,
     "hold or ignore boundary layers, elements that are\n"
     "thin in layers, or keep their heights while nodes\n"
     "move along them (default: keep those with wedges,\n"
     "hexahedra or quadrilaterals)",
     "hold keep ignore"},
    {0, "fix-layers", NULL, MEASURE, set_flag, AT(fix_layers), 1, 0, NULL, "same as --layers hold",
     NULL},
    {0, "regions", "NAME", MEASURE, set_regions, 0, 0, 0,
     "must be the name of an array of the file, or none",
     "hold nodes between the values of array NAME (default:\n"
     "all arrays that look like regions); repeatable;\n"
     "none: let nodes between regions move",
     "none"},
    {0, "ignore-regions", NULL, MEASURE, set_regions, 0, 0, 0, NULL,
     "let nodes between regions (materials) move; same as\n"
     "--regions none",
     NULL},
    {0, "slide", "HOW", SMOOTH | OPTIMISES, set_slide, 0, 0, 0,
     "must be auto, curved, none, or the NAME, N or DIM:N of a group",
     "let boundary nodes slide: auto (in planes and along\n"
     "straight edges, where the shape stays the same),\n"
     "curved (on curved surfaces, too; default of surfaces\n"
     "in space), none (default of others; of surfaces in\n"
     "space: not along curves), or group TAG only (NAME, N\n"
     "or DIM:N; repeatable)",
     "auto curved none group"},
    {0, "surface-tolerance", "T", SMOOTH | OPTIMISES | OF_CURVED, set_surface_tolerance, 0, 0, 0,
     "must be a distance above 0, or a number and h for that many edge lengths",
     "on curved surfaces: let no point of the surface be\n"
     "farther than T, with Th than T mean edges, off the\n"
     "original surface (default 0.05h)",
     NULL},
    {0, "slide-interfaces", NULL, SMOOTH | OPTIMISES | OF_CURVED, set_flag, AT(slide_interfaces), 1,
     0, NULL, "with --slide curved: let nodes slide on curved\ninterfaces between regions, too",
     NULL},
    {0, "surface-of", "FILE", BOTH | OF_CURVED, set_text, AT(surface_of), 0, 0,
     "must be the name of a file",
     "take the original surface from FILE, which has the\n"
     "same elements: repeated runs do not add up (default:\n"
     "IN); with quality: how far the surface is off it",
     "file"},
    {0, "onto", "FILE", SMOOTH | OPTIMISES, set_text, AT(onto), 0, 0, "must be the name of a file",
     "fit the surface to that of FILE (STL, OBJ, any\n"
     "format): its nodes are moved there as far as elements\n"
     "stay valid, and slide along it",
     "file"},
    {0, "like", "FILE", BOTH | ADVISE | OPTIMISES, set_text, AT(like), 0, 0,
     "must be the name of a file",
     "let each element become like it is in FILE, the same\n"
     "mesh before it was deformed, in any format: layers\n"
     "and gradings survive; with quality: compare with that\n"
     "(default: with regular elements)",
     "file"},
    {0, "size", "NAME", BOTH | OPTIMISES, set_text, AT(size), 0, 0,
     "must be the name of an array of the file",
     "let elements have the sizes of array NAME of IN (VTK,\n"
     "Gmsh) where they are, in relation to one another:\n"
     "lengths of edges, or metrics (symmetric tensors), at\n"
     "nodes or elements; with quality: compare with them",
     NULL},
    {0, "size-from", "FILE", BOTH | OPTIMISES, set_text, AT(size_from), 0, 0,
     "must be the name of a file",
     "let elements have the sizes or metrics of FILE, a\n"
     ".sol or .solb of Medit's for the nodes of IN",
     "file"},
    {0, "keep-sizes", NULL, SMOOTH | OPTIMISES, set_flag, AT(keep_sizes), 1, 0, NULL,
     "let elements have the sizes that those of IN have\nthere", NULL},
    {0, "size-weight", "W", SMOOTH | OPTIMISES, set_real, AT(library.size_weight), 0, 1,
     "must be a number from 0 to 1",
     "with --like or sizes: let the sizes of elements count\n"
     "by W, and their shapes by 1 - W (default 0 with\n"
     "--like, else 0.9)",
     NULL},
    {0, "crease-angle", "A", BOTH | OF_CURVED, set_real, AT(crease_angle), 0, 180,
     "must be a number of degrees from 0 to 180",
     "keep edges of curved surfaces that bend by more than\n"
     "A degrees, and no others but for groups (default:\n"
     "find creases)",
     NULL},
    {0, "slide-tolerance", "T", MEASURE, set_real, AT(slide_tolerance), ABOVE_0, 1e-3,
     "must be a fraction above 0, up to 1e-3",
     "accept nodes up to T times the diagonal of the\n"
     "bounding box off their plane or line (default 1e-8,\n"
     "more for files of few digits); also for triangles in\n"
     "a tilted plane",
     NULL},
    {0, "only-worse-than", "RR", SMOOTH | OPTIMISES, set_real, AT(library.only_worse_than), 1,
     DBL_MAX, "must be a ratio, 1 or more",
     "move only nodes of elements with a radius ratio (with\n"
     "other elements: aspect ratio) above RR (default: move\n"
     "all)",
     NULL},
    {0, "curve-quality", "Q", SMOOTH | OPTIMISES, set_real, AT(library.curve_quality), 0, 1,
     "must be a number from 0 to 1",
     "let mid-side nodes move by themselves where the least\n"
     "Jacobian of a curved element is below Q of its mean\n"
     "(default 0.3; 0: they follow)",
     NULL},
    {0, "rings", "K", SMOOTH | OPTIMISES, set_integer, AT(library.rings), 0, 100,
     "must be a whole number from 0 to 100",
     "with --only-worse-than: move K rings of elements\naround these as well (default 0)", NULL},
    {'j', "threads", "N", MEASURE | CONVERT, set_integer, AT(library.threads), 1, PL_MAX_THREADS,
     "must be a whole number from 1 to 1024",
     "run on N threads (default: OMP_NUM_THREADS, else one\n"
     "for each core, fewer for a small mesh)",
     NULL},
    {0, "bind", "HOW", MEASURE, set_choice, AT(leave_unbound), 0, 0, NULL,
     "bind one thread to each core if there are enough\n"
     "cores and OpenMP's variables say nothing (auto,\n"
     "default), or leave threads unbound (none)",
     "auto none"},
    {0, "json", "FILE", BOTH | COMPARE, set_text, AT(json), 0, 0, FILE_OR_STDOUT,
     "write the result as JSON to FILE, - for standard\n"
     "output",
     "file"},
    {0, "report", "FILE.html", BOTH | COMPARE, set_text, AT(report), 0, 0, FILE_OR_STDOUT,
     "write an HTML report with tables, histograms,\n"
     "convergence and a picture to FILE.html, - for\n"
     "standard output",
     "file"},
    {0, "worst", "N", QUALITY, set_integer, AT(n_worst), 1, INT_MAX,
     "must be a whole number, 1 or more",
     "list the N worst elements, here and in the reports\n"
     "(default: none here, 10 in the reports)",
     NULL},
    {'v', "verbose", NULL, SMOOTH | PL_OPTION_DOUBLED, set_verbose, 0, 0, 0, NULL,
     "print one line per sweep, and the placement of the\n"
     "threads; -vv: one line per colour as well",
     NULL},
    {'q', "quiet", NULL, ALL & ~(ADVISE | GROUPS), set_flag, AT(verbosity), PL_QUIET, 0, NULL,
     "print nothing but errors", NULL},
    {'h', "help", NULL, ALL, set_flag, AT(help), 1, 0, NULL, "show this help and exit", NULL},
    {0, "version", NULL, ALL, set_flag, AT(version), 1, 0, NULL, "show the version and exit", NULL},
};

enum { N_OPTIONS = sizeof option_table / sizeof option_table[0] };
_Static_assert((int)N_OPTIONS <= (int)PL_MOST_OPTIONS, "a table of that many options");

const pl_option *pl_option_at(int i) {
    return i < N_OPTIONS ? &option_table[i] : NULL;
}
