/* options: the command lines of the program's commands. */
#include "options/options.h"

#include "options/commands.h"
#include "terminal/message.h"
#include "terminal/text.h"

#include "base/parallel.h"

#include <errno.h>
#include <float.h>
#include <getopt.h>
#include <limits.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

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

typedef struct option_row option_row;
typedef const char *option_setter(pl_arguments *arguments, const option_row *row,
                                  const char *value);

struct option_row {
    int letter;        /* short option, or 0 */
    const char *name;  /* long option */
    const char *value; /* what its value is called, or NULL: takes none */
    unsigned commands; /* bits of pl_command, and OPTIMISES, OF_WORST */
    option_setter *set;
    size_t at;          /* offset in pl_arguments of the field that it sets */
    double low, high;   /* of a number; of an option without a value low is what is set */
    const char *wanted; /* what a value must be; NULL: one of values */
    const char *help;   /* lines separated by '\n' */
    const char *values; /* words that the value may be, separated by blanks; "file": a file's name;
                           NULL: anything else */
};

/** The field that row sets. */
static void *field_of(pl_arguments *arguments, const option_row *row) {
    return (char *)arguments + row->at;
}

static const char *set_flag(pl_arguments *arguments, const option_row *row, const char *value) {
    (void)value;
    *(int *)field_of(arguments, row) = (int)row->low;
    return NULL;
}

static const char *set_integer(pl_arguments *arguments, const option_row *row, const char *value) {
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

static const char *set_real(pl_arguments *arguments, const option_row *row, const char *value) {
    double *number = field_of(arguments, row);
    return parse_real(value, number) || *number < row->low || *number > row->high ? row->wanted
                                                                                  : NULL;
}

static const char *set_text(pl_arguments *arguments, const option_row *row, const char *value) {
    *(const char **)field_of(arguments, row) = value;
    return value[0] ? NULL : row->wanted;
}

/** Index of value among the words of row, or -1. */
static int find_value(const option_row *row, const char *value) {
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
static const char *set_choice(pl_arguments *arguments, const option_row *row, const char *value) {
    const int i = find_value(row, value);
    *(int *)field_of(arguments, row) = i;
    return i < 0 ? NOT_LISTED : NULL;
}

/** Set a text that is one of the words of row. */
static const char *set_word(pl_arguments *arguments, const option_row *row, const char *value) {
    *(const char **)field_of(arguments, row) = value;
    return find_value(row, value) < 0 ? NOT_LISTED : NULL;
}

static const char *set_objective(pl_arguments *arguments, const option_row *row,
                                 const char *value) {
    arguments->has_objective = 1;
    arguments->worst = strcmp(value, "worst") == 0;
    const int i = arguments->worst ? PLANISH_OBJECTIVE_RADIUS_RATIO : find_value(row, value);
    arguments->library.objective = (planish_objective)i;
    return i < 0 ? NOT_LISTED : NULL;
}

static const char *set_worst_measure(pl_arguments *arguments, const option_row *row,
                                     const char *value) {
    const int i = find_value(row, value);
    arguments->worst_measure = worst_names[i < 0 ? 0 : i].worst;
    return i < 0 ? NOT_LISTED : NULL;
}

static const char *set_layers(pl_arguments *arguments, const option_row *row, const char *value) {
    static const pl_layers_asked asked[] = {PL_LAYERS_HELD, PL_LAYERS_KEPT, PL_LAYERS_IGNORED};
    const int i = find_value(row, value);
    arguments->layers = asked[i < 0 ? 0 : i];
    if (value[0] && value[strspn(value, "0123456789")] == '\0')
        return "must be hold, keep or ignore; for rings of elements around give --rings";
    return i < 0 ? NOT_LISTED : NULL;
}

/** V for all elements; the last '=' ends a tag, which may have others in its name. */
static const char *set_min_volume(pl_arguments *arguments, const option_row *row,
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

static const char *set_box(pl_arguments *arguments, const option_row *row, const char *value) {
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

static const char *set_max_displacement(pl_arguments *arguments, const option_row *row,
                                        const char *value) {
    planish_options *library = &arguments->library;
    return set_distance(value, &library->max_displacement, &library->displacement_unit)
               ? NULL
               : row->wanted;
}

static const char *set_surface_tolerance(pl_arguments *arguments, const option_row *row,
                                         const char *value) {
    planish_options *library = &arguments->library;
    return set_distance(value, &library->surface_tolerance, &library->surface_tolerance_unit)
               ? NULL
               : row->wanted;
}

static const char *set_fix(pl_arguments *arguments, const option_row *row, const char *value) {
    arguments->fix[arguments->n_fix++] = value;
    return value[0] ? NULL : row->wanted;
}

static const char *set_slide(pl_arguments *arguments, const option_row *row, const char *value) {
    const int is_none = strcmp(value, "none") == 0, is_curved = strcmp(value, "curved") == 0;
    const int is_plain = is_none || strcmp(value, "auto") == 0;
    arguments->slide = !is_none;
    arguments->slide_given = 1;
    arguments->slides_none = is_none;
    arguments->slide_curved = is_curved || (arguments->slide_curved && !is_plain);
    if (is_plain)
        arguments->n_slide_tags = 0;
    else if (!is_curved)
        arguments->slide_tag[arguments->n_slide_tags++] = value;
    return value[0] ? NULL : row->wanted;
}

/** --regions NAME, and --ignore-regions. */
static const char *set_regions(pl_arguments *arguments, const option_row *row, const char *value) {
    arguments->ignore_regions = !value || strcmp(value, "none") == 0;
    if (arguments->ignore_regions)
        arguments->n_regions = 0;
    else
        arguments->regions[arguments->n_regions++] = value;
    return !value || value[0] ? NULL : row->wanted;
}

static const char *set_verbose(pl_arguments *arguments, const option_row *row, const char *value) {
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
    BOTH = SMOOTH | QUALITY,
    ALL = PL_COMMANDS_ALL,
    OPTIMISES = 16, /* heeded by no Laplacian method */
    OF_WORST = 32,  /* has an effect with --objective worst alone */
    OF_CURVED =
        64 /* has an effect on smooth with --slide curved, and on surfaces in space, alone */
};

#define AT(field) offsetof(pl_arguments, field)
/* Bounds that are not reached: the doubles next to 0 and 1. */
#define ABOVE_0        0x1p-1074
#define BELOW_1        (1 - DBL_EPSILON / 2)
#define FILE_OR_STDOUT "must be the name of a file, or - for standard output"

static const option_row option_table[] = {
    {'o', "output", "OUT", SMOOTH, set_text, AT(output), 0, 0, "must be the name of a file",
     "write the smoothed mesh to OUT, which may be IN; keep\n"
     "the format of IN and change coordinates only; convert\n"
     "to another format that planish convert writes if OUT\n"
     "ends as its files do",
     "file"},
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
     "medit, abaqus, nastran, stl, obj or ply (default: by\n"
     "the extension of OUT)",
     "vtu vtk gmsh gmsh22 medit abaqus nastran stl obj ply"},
    {0, "format", "NAME", BOTH | CONVERT, set_word, AT(format), 0, 0, NULL,
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
    {0, "fix", "TAG", BOTH, set_fix, 0, 0, 0, "must be the NAME, N or DIM:N of a group",
     "hold all nodes of group TAG: its NAME, N or DIM:N;\n"
     "repeatable",
     NULL},
    {0, "layers", "HOW", BOTH, set_layers, 0, 0, 0, NULL,
     "hold or ignore boundary layers, elements that are\n"
     "thin in layers, or keep their heights while nodes\n"
     "move along them (default: keep those with wedges,\n"
     "hexahedra or quadrilaterals)",
     "hold keep ignore"},
    {0, "fix-layers", NULL, BOTH, set_flag, AT(fix_layers), 1, 0, NULL, "same as --layers hold",
     NULL},
    {0, "regions", "NAME", BOTH, set_regions, 0, 0, 0,
     "must be the name of an array of the file, or none",
     "hold nodes between the values of array NAME (default:\n"
     "all arrays that look like regions); repeatable;\n"
     "none: let nodes between regions move",
     "none"},
    {0, "ignore-regions", NULL, BOTH, set_regions, 0, 0, 0, NULL,
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
     "auto curved none"},
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
    {0, "like", "FILE", BOTH | OPTIMISES, set_text, AT(like), 0, 0, "must be the name of a file",
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
    {0, "slide-tolerance", "T", BOTH, set_real, AT(slide_tolerance), ABOVE_0, 1e-3,
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
    {'j', "threads", "N", BOTH | CONVERT, set_integer, AT(library.threads), 1, PL_MAX_THREADS,
     "must be a whole number from 1 to 1024",
     "run on N threads (default: OMP_NUM_THREADS, else one\n"
     "for each core, fewer for a small mesh)",
     NULL},
    {0, "bind", "HOW", BOTH, set_choice, AT(leave_unbound), 0, 0, NULL,
     "bind one thread to each core if there are enough\n"
     "cores and OpenMP's variables say nothing (auto,\n"
     "default), or leave threads unbound (none)",
     "auto none"},
    {0, "json", "FILE", BOTH, set_text, AT(json), 0, 0, FILE_OR_STDOUT,
     "write the result as JSON to FILE, - for standard\n"
     "output",
     "file"},
    {0, "report", "FILE.html", BOTH, set_text, AT(report), 0, 0, FILE_OR_STDOUT,
     "write an HTML report with tables, histograms,\n"
     "convergence and a picture to FILE.html, - for\n"
     "standard output",
     "file"},
    {0, "worst", "N", QUALITY, set_integer, AT(n_worst), 1, INT_MAX,
     "must be a whole number, 1 or more",
     "list the N worst elements, here and in the reports\n"
     "(default: none here, 10 in the reports)",
     NULL},
    {'v', "verbose", NULL, SMOOTH, set_verbose, 0, 0, 0, NULL,
     "print one line per sweep, and the placement of the\n"
     "threads; -vv: one line per colour as well",
     NULL},
    {'q', "quiet", NULL, ALL, set_flag, AT(verbosity), PL_QUIET, 0, NULL,
     "print nothing but errors", NULL},
    {'h', "help", NULL, ALL, set_flag, AT(help), 1, 0, NULL, "show this help and exit", NULL},
    {0, "version", NULL, ALL, set_flag, AT(version), 1, 0, NULL, "show the version and exit", NULL},
};

enum { N_OPTIONS = sizeof option_table / sizeof option_table[0] };

/* ---- parsing -------------------------------------------------------------------------------- */

/** Code that getopt_long returns for row i: its letter, or a number beyond all characters. */
static int option_code(int i) {
    return option_table[i].letter ? option_table[i].letter : UCHAR_MAX + 1 + i;
}

/** The rows of command in getopt's terms: letters [3 * N_OPTIONS + 2], rows [N_OPTIONS + 1]. */
static void make_getopt_table(pl_command command, char *letters, struct option *rows) {
    *letters++ = ':'; /* tells a missing value from an unknown option */
    for (int i = 0; i < N_OPTIONS; i++) {
        const option_row *row = &option_table[i];
        if (!(row->commands & command))
            continue;
        *rows++ = (struct option){row->name, row->value ? required_argument : no_argument, NULL,
                                  option_code(i)};
        if (row->letter) {
            *letters++ = (char)row->letter;
            if (row->value)
                *letters++ = ':';
        }
    }
    *letters = '\0';
    *rows = (struct option){NULL, 0, NULL, 0};
}

static const option_row *find_row(pl_command command, int code) {
    for (int i = 0; i < N_OPTIONS; i++)
        if (option_code(i) == code && (option_table[i].commands & command))
            return &option_table[i];
    return NULL;
}

/** Message for an option --word (which may have "=VALUE" behind it) that getopt does not know. */
static int complain_unknown(pl_command command, const char *name, const char *word) {
    char typed[64], others[128] = "";
    snprintf(typed, sizeof typed, "%.*s", (int)strcspn(word, "="), word);
    const char *nearest = NULL;
    const option_row *elsewhere = NULL;
    size_t used = 0;
    for (int i = 0; i < N_OPTIONS; i++) {
        const option_row *row = &option_table[i];
        const int is_here = (row->commands & command) != 0;
        if (is_here)
            nearest = pl_text_nearer(typed, nearest, row->name);
        else if (strcmp(row->name, typed) == 0)
            elsewhere = row;
        if (is_here && typed[0] && strncmp(row->name, typed, strlen(typed)) == 0 &&
            used < sizeof others)
            used += (size_t)snprintf(others + used, sizeof others - used, "%s--%s",
                                     used ? ", " : "", row->name);
    }
    if (used)
        return pl_complain_usage(name, "option '--%s' is ambiguous: %s", typed, others);
    if (elsewhere)
        return pl_complain_usage(name, "planish %s has no option --%s", name, typed);
    if (nearest)
        return pl_complain_usage(name, "unknown option '--%s'; did you mean --%s?", typed, nearest);
    return pl_complain_usage(name, "unknown option '--%s'", typed);
}

/** Message for a value that a setter has refused, as it must be wanted; "": one of the row's words.
 */
static int complain_value(const char *name, const option_row *row, const char *value,
                          const char *wanted) {
    char list[256] = "must be ";
    size_t used = strlen(list);
    for (const char *word = row->values; !wanted[0] && *word;) {
        const size_t n = strcspn(word, " "), next = n + strspn(word + n, " ");
        const char *joint = !word[next] ? "" : strchr(word + next, ' ') ? ", " : " or ";
        used += (size_t)snprintf(list + used, sizeof list - used, "%.*s%s", (int)n, word, joint);
        word += next;
    }
    return pl_complain_usage(name, "--%s '%s' %s", row->name, value, wanted[0] ? wanted : list);
}

/** Message for what getopt refused; word: the argument it was looking at. */
static int complain_option(pl_command command, const char *name, int refusal, int code,
                           const char *word) {
    const option_row *row = find_row(command, code);
    if (refusal == ':' && row)
        return pl_complain_usage(name, "option --%s needs a value (%s)", row->name, row->value);
    if (row)
        return pl_complain_usage(name, "option --%s takes no value", row->name);
    if (code)
        return pl_complain_usage(name, "unknown option '-%c'", code);
    return complain_unknown(command, name, word + strspn(word, "-"));
}

/** Take the operands that stand at argv[optind ...] and check that all is there. */
static int take_operands(pl_arguments *arguments, int argc, char **argv) {
    const pl_command_text *command = pl_command_row(arguments->command);
    if (optind == argc)
        return pl_complain_usage(command->name, "no %s is named", command->operand);
    if (arguments->command == PL_COMMAND_CONVERT && optind + 2 == argc && argv[argc - 1][0])
        arguments->output = argv[--argc];
    else if (optind + 1 < argc && !command->takes_many) {
        const char *second = argv[optind + 1];
        if (!arguments->output && arguments->command == PL_COMMAND_SMOOTH)
            return pl_complain_usage(command->name, "unexpected argument '%s'; did you mean -o %s?",
                                     second, second);
        return pl_complain_usage(command->name, "unexpected argument '%s': give one %s", second,
                                 command->operand);
    }
    for (int i = optind; i < argc; i++) {
        if (argv[i][0] == '\0')
            return pl_complain_usage(command->name, "the name of the %s is empty",
                                     command->operand);
        arguments->inputs[arguments->n_inputs++] = argv[i];
    }
    arguments->input = arguments->inputs[0];
    if (arguments->command == PL_COMMAND_SMOOTH && !arguments->output)
        return pl_complain_usage(command->name, "no output file is named: give -o OUT");
    if (arguments->command == PL_COMMAND_CONVERT && !arguments->output)
        return pl_complain_usage(command->name, "no output file is named: give IN and OUT");
    return 0;
}

int pl_arguments_bound_volumes(const pl_arguments *arguments) {
    const planish_options *library = &arguments->library;
    return library->min_volume > 0 || library->min_volume_fraction > 0 ||
           arguments->n_min_volumes > 0;
}

/** The copy for viewing of the command quality. */
static int check_view(const pl_arguments *arguments) {
    const char *path = arguments->output;
    const size_t length = strlen(path), n = strlen(".vtu");
    const char *end = path + (length > n ? length - n : 0);
    if (strcasecmp(end, ".vtu") != 0 && strcasecmp(end, ".vtk") != 0)
        return pl_complain_usage("quality", "--output '%s' must end in .vtu or .vtk", path);
    if (arguments->n_inputs > 1)
        return pl_complain_usage("quality", "--output takes one mesh, but %d are named",
                                 arguments->n_inputs);
    return 0;
}

/** Options that have no place beside --onto. */
static int check_onto(const pl_arguments *arguments) {
    const planish_options *library = &arguments->library;
    const char *command = pl_command_name(arguments->command);
    const char *name = arguments->slide                ? "slide"
                       : arguments->n_box > 0          ? "box"
                       : library->max_displacement > 0 ? "max-displacement"
                       : library->only_worse_than > 0  ? "only-worse-than"
                       : arguments->surface_of         ? "surface-of"
                                                       : NULL;
    return name ? pl_complain_usage(command, "give --onto or --%s, not both", name) : 0;
}

/** Find the options that say what elements are to become like: targets [5] in the order in which they are
 *  named. Returns how many are given. */
static int find_targets(const pl_arguments *arguments, const char **targets) {
    int n = 0;
    if (arguments->like)
        targets[n++] = "--like";
    if (arguments->layers == PL_LAYERS_KEPT)
        targets[n++] = "--layers keep";
    if (arguments->size)
        targets[n++] = "--size";
    if (arguments->size_from)
        targets[n++] = "--size-from";
    if (arguments->keep_sizes)
        targets[n++] = "--keep-sizes";
    return n;
}

int pl_arguments_have_sizes(const pl_arguments *arguments) {
    return arguments->size || arguments->size_from || arguments->keep_sizes;
}

const char *pl_arguments_target(const pl_arguments *arguments) {
    const char *targets[5];
    return find_targets(arguments, targets) > 0 ? targets[0] : NULL;
}

/** Check what stands beside options of targets. */
static int check_targets(const pl_arguments *arguments) {
    const planish_objective objective = arguments->library.objective;
    const char *command = pl_command_name(arguments->command), *targets[5] = {NULL};
    const int n = find_targets(arguments, targets);
    const int is_sized = pl_arguments_have_sizes(arguments);
    if (arguments->library.size_weight > 0 && !is_sized && !arguments->like)
        return pl_complain_usage(command, "--size-weight has no effect without --like or sizes "
                                          "(--size, --size-from, --keep-sizes)");
    if (arguments->library.size_weight == 0 && arguments->keep_sizes)
        return pl_complain_usage(command,
                                 "--size-weight 0 leaves --keep-sizes without effect: give more");
    if (n > 1)
        return pl_complain_usage(command, "give %s or %s, not both", targets[0], targets[1]);
    if (n == 1 && is_sized && arguments->n_inputs > 1)
        return pl_complain_usage(command, "%s takes one mesh, but %d are named", targets[0],
                                 arguments->n_inputs);
    if (n == 0 || !arguments->has_objective ||
        (objective == PLANISH_OBJECTIVE_MEAN_RATIO && !arguments->worst))
        return 0;
    return pl_complain_usage(command, "%s minimises the mean-ratio: leave out --objective %s",
                             targets[0], arguments->worst ? "worst" : pl_objective_name(objective));
}

/** Options that exclude or need one another. */
static int check_combinations(const pl_arguments *arguments) {
    const planish_options *library = &arguments->library;
    const char *command = pl_command_name(arguments->command);
    if (library->min_volume > 0 && library->min_volume_fraction > 0)
        return pl_complain_usage(command, "give --min-volume for all elements or "
                                          "--min-volume-fraction, not both");
    if (library->area_weight > 0 && !pl_arguments_bound_volumes(arguments))
        return pl_complain_usage(command, "--area-weight needs a minimum volume: --min-volume or "
                                          "--min-volume-fraction");
    if (arguments->fix_layers &&
        (arguments->layers == PL_LAYERS_IGNORED || arguments->layers == PL_LAYERS_KEPT))
        return pl_complain_usage(command, "give --fix-layers or --layers %s, not both",
                                 arguments->layers == PL_LAYERS_KEPT ? "keep" : "ignore");
    if (library->rings > 0 && !(library->only_worse_than > 0))
        return pl_complain_usage(command, "--rings has no effect without --only-worse-than");
    if (arguments->of_worst && !arguments->worst)
        return pl_complain_usage(command, "--%s has no effect without --objective worst",
                                 arguments->of_worst);
    if (arguments->onto && check_onto(arguments))
        return PL_EXIT_USAGE;
    if (check_targets(arguments))
        return PL_EXIT_USAGE;
    if (arguments->surface_of && arguments->n_inputs > 1)
        return pl_complain_usage(command, "--surface-of takes one mesh, but %d are named",
                                 arguments->n_inputs);
    if (arguments->command == PL_COMMAND_QUALITY && arguments->output && check_view(arguments))
        return PL_EXIT_USAGE;
    if (arguments->report && arguments->n_inputs > 1)
        return pl_complain_usage(command, "--report takes one mesh, but %d are named",
                                 arguments->n_inputs);
    if (arguments->n_worst > 0 && arguments->verbosity == PL_QUIET && !arguments->json &&
        !arguments->report)
        return pl_complain_usage(command, "--worst has no effect with --quiet and no report");
    if (library->method != PLANISH_METHOD_PLANISH && arguments->optimiser)
        return pl_complain_usage(command, "--%s has no effect with --method %s",
                                 arguments->optimiser, pl_method_name(library->method));
    return 0;
}

/** Room for as many tags as there are words. */
static int make_room(pl_arguments *arguments, int argc) {
    const size_t n = (size_t)argc;
    arguments->inputs = calloc(n, sizeof *arguments->inputs);
    arguments->fix = calloc(n, sizeof *arguments->fix);
    arguments->slide_tag = calloc(n, sizeof *arguments->slide_tag);
    arguments->regions = calloc(n, sizeof *arguments->regions);
    arguments->min_volume_tag = calloc(n, sizeof *arguments->min_volume_tag);
    arguments->min_volume_value = calloc(n, sizeof *arguments->min_volume_value);
    if (arguments->inputs && arguments->fix && arguments->slide_tag && arguments->regions &&
        arguments->min_volume_tag && arguments->min_volume_value)
        return 0;
    return pl_complain(PL_EXIT_FAILED, "out of memory for the command line");
}

/* A size weight that no option gives; and what it is with sizes. */
#define NOT_GIVEN       (-1.0)
#define WEIGHT_OF_SIZES 0.9

/** Choose the size weight where no option gives it. */
static void take_size_weight(pl_arguments *arguments) {
    double *weight = &arguments->library.size_weight;
    if (*weight < 0)
        *weight = pl_arguments_have_sizes(arguments) ? WEIGHT_OF_SIZES : 0;
}

int pl_arguments_parse(pl_arguments *arguments, pl_command command, int argc, char **argv) {
    memset(arguments, 0, sizeof *arguments);
    arguments->command = command;
    planish_options_init(&arguments->library);
    arguments->library.size_weight = NOT_GIVEN;
    int status = make_room(arguments, argc);
    if (status)
        return status;

    char letters[3 * N_OPTIONS + 2];
    struct option rows[N_OPTIONS + 1];
    make_getopt_table(command, letters, rows);
    opterr = 0;
    optind = 1;
    int code;
    while ((code = getopt_long(argc, argv, letters, rows, NULL)) != -1) {
        if (code == '?' || code == ':')
            return complain_option(command, argv[0], code, optopt, argv[optind - 1]);
        const option_row *row = find_row(command, code);
        const char *wanted = row->set(arguments, row, optarg);
        if (wanted)
            return complain_value(argv[0], row, optarg, wanted);
        if (row->commands & OF_WORST)
            arguments->of_worst = row->name;
        if (row->commands & OF_CURVED)
            arguments->of_curved = row->name;
        if (row->commands & OPTIMISES)
            arguments->optimiser = row->name;
        if (arguments->help || arguments->version)
            return 0;
    }
    take_size_weight(arguments);
    status = take_operands(arguments, argc, argv);
    if (!status)
        status = check_combinations(arguments);
    if (arguments->fix_layers)
        arguments->layers = PL_LAYERS_HELD;
    if (arguments->worst)
        arguments->library.worst = arguments->worst_measure != PLANISH_WORST_NONE
                                       ? arguments->worst_measure
                                       : PLANISH_WORST_ANGLE;
    return status;
}

void pl_arguments_free(pl_arguments *arguments) {
    for (int i = 0; i < arguments->n_min_volumes; i++)
        free(arguments->min_volume_tag[i]);
    free(arguments->min_volume_tag);
    free(arguments->min_volume_value);
    free(arguments->regions);
    free(arguments->slide_tag);
    free(arguments->fix);
    free(arguments->inputs);
}

/* ---- for the help and the manual ------------------------------------------------------------ */

int pl_option_describe(int i, pl_option_text *text) {
    if (i >= N_OPTIONS)
        return 0;
    const option_row *row = &option_table[i];
    *text = (pl_option_text){.letter = row->letter,
                             .name = row->name,
                             .value = row->value,
                             .commands = row->commands & ALL,
                             .help = row->help,
                             .values = row->values,
                             .is_doubled = row->set == set_verbose};
    return 1;
}
