/* options: the command lines of the program's commands.
 *
 * One table (options.c, table.h) says which options there are; it drives the parser, the help (help.c),
 * the manual page and the completion of shells (manual.c).
 *
 *     pl_arguments                                     a command line (parse.h, combinations.h)
 *     pl_method_name, pl_objective_name, ...           words of the command line and the report
 */
#ifndef PL_TOOLS_OPTIONS_H
#define PL_TOOLS_OPTIONS_H

#include <planish/planish.h>

typedef enum pl_command {
    PL_COMMAND_SMOOTH = 1,
    PL_COMMAND_QUALITY = 2,
    PL_COMMAND_REPORT = 4,
    PL_COMMAND_CONVERT = 8,
    PL_COMMAND_ADVISE = 16,
    PL_COMMAND_COMPARE = 32,
    PL_COMMAND_GROUPS = 64,
    PL_COMMANDS_ALL = 127
} pl_command;

/** The word that names command. */
const char *pl_command_name(pl_command command);

/** The words for method and objective on the command line and in the report. */
const char *pl_method_name(planish_method method);
const char *pl_objective_name(planish_objective objective);
const char *pl_worst_name(planish_worst worst);

typedef enum pl_verbosity {
    PL_QUIET = -1,
    PL_NORMAL = 0,
    PL_VERBOSE = 1,
    PL_DETAILED = 2
} pl_verbosity;

/** Which layers of thin elements are held. */
typedef enum pl_layers_asked {
    PL_LAYERS_BY_TYPE = 0, /* by default: those with elements of some types are kept */
    PL_LAYERS_HELD = 1,    /* all, as by --fix-layers */
    PL_LAYERS_IGNORED = 2,
    PL_LAYERS_KEPT = 3 /* their nodes move along them, and heights stay */
} pl_layers_asked;

/** A command line that has been understood. Strings are those of argv. */
typedef struct pl_arguments {
    pl_command command;
    pl_command typed;       /* the command that messages are about: advise runs others */
    const char *input;      /* the first of inputs */
    const char **inputs;    /* [n_inputs] owned */
    int n_inputs;           /* 1, but for commands that take many; smooth: 1 with output */
    int output_is_operand;  /* OUT stands behind IN, without -o: nothing is replaced */
    const char *output;     /* convert: always there; compare: the second mesh; others:
                            or NULL */
    const char *output_dir; /* of smooth: the folder of all outputs, or NULL */
    int in_place;           /* of smooth: each input is replaced */
    const char *format;     /* or NULL: find out */
    const char *to;         /* the format of what is converted, or NULL: by its extension */
    const char *json;       /* a path, "-" for standard output, or NULL: no report */
    const char *report;     /* path of the page for people, or NULL: none */
    int history;            /* states of the mesh that it has at most; 0: before and after */
    int n_worst;            /* elements that --worst lists; 0: not given */
    const char **fix;       /* [n_fix] tags, owned */
    int n_fix;
    int fix_layers;         /* given: as --layers hold, */
    pl_layers_asked layers; /* which says so then */
    int slide;              /* boundary nodes slide, where they can */
    int slide_given;        /* --slide was given, */
    int slides_none;        /* and says none */
    const char **slide_tag; /* [n_slide_tags] on these groups only; none: on all; owned */
    int n_slide_tags;
    double slide_tolerance; /* 0: what fits the file */
    int slide_curved;       /* on curved patches and curves, too, */
    int curved_if_any;      /* where the mesh may have any: no error in a plane */
    int slide_interfaces;   /* those between regions among them */
    const char *surface_of; /* the file that the surface is taken from, or NULL: the input */
    const char *onto;       /* the file whose surface the mesh's is fitted to, or NULL: none */
    const char *like;       /* the file whose elements are the targets, or NULL: regular ones */
    const char *size;       /* the array of the input that has the sizes of elements, or NULL */
    const char *size_from;  /* the file that has them, or NULL */
    int keep_sizes;         /* the sizes are those of the input */
    double crease_angle;    /* in degrees; 0: features are found */
    const char *of_curved;  /* an option of smooth that is for curved surfaces alone, or NULL */
    const char *objective_given; /* the option that says the objective, as it is written, or NULL */
    int worst;                   /* --objective worst */
    const char *of_worst;        /* an option that is for it alone, or NULL */
    planish_worst worst_measure;
    int ignore_regions;
    const char **regions; /* [n_regions] arrays that tell regions; none: found by the rule; owned */
    int n_regions;
    int leave_unbound;        /* threads stay where the system puts them */
    char **min_volume_tag;    /* [n_min_volumes] groups with a minimum volume of their own, owned */
    double *min_volume_value; /* [n_min_volumes] and that volume, owned */
    int n_min_volumes;
    double box[6];         /* the lower and then the upper corner */
    int n_box;             /* numbers in box: 4 or 6; 0: no box */
    const char *optimiser; /* an option given that only PLANISH_METHOD_PLANISH heeds, or NULL */
    pl_verbosity verbosity;
    int help, version;       /* asked for: nothing else is set then */
    planish_options library; /* what goes to the library as it is */
} pl_arguments;

#endif
