/* table: the rows of the table of options, for the parser and all that tells of options.
 *
 *     pl_option, pl_option_at, pl_section_title        the table (options.c)
 */
#ifndef PL_TOOLS_OPTIONS_TABLE_H
#define PL_TOOLS_OPTIONS_TABLE_H

#include "options/options.h"

#include <stddef.h>

/** No table has more rows. */
enum { PL_MOST_OPTIONS = 80 };

/* Bits beside those of pl_command, of an option that has an effect */
enum {
    PL_OPTION_OPTIMISES = 256,  /* with no Laplacian method */
    PL_OPTION_OF_WORST = 512,   /* with --objective worst alone */
    PL_OPTION_OF_CURVED = 1024, /* on smooth with --slide curved, and on surfaces in space, alone */
    PL_OPTION_DOUBLED = 2048    /* and another one if its letter is given twice, as in -vv */
};

/** Sections of the help, in the order of the table. */
typedef enum {
    PL_SECTION_FILES,
    PL_SECTION_OBJECTIVE,
    PL_SECTION_CONSTRAINTS,
    PL_SECTION_NODES,
    PL_SECTION_END,
    PL_SECTION_OTHERS
} pl_section;

typedef struct pl_option pl_option;

/** Take value (NULL: the option has none) into arguments. Returns NULL, or what the value must be; "":
 *  one of the option's words. */
typedef const char *pl_option_setter(pl_arguments *arguments, const pl_option *option,
                                     const char *value);

/** Option of the command line. */
struct pl_option {
    pl_section section;
    int letter;        /* short option, or 0 */
    const char *name;  /* long option */
    const char *value; /* what its value is called, or NULL: takes none */
    unsigned commands; /* bits of pl_command, and those above */
    pl_option_setter *set;
    size_t at;          /* offset in pl_arguments of the field that it sets */
    double low, high;   /* of a number; of an option without a value low is what is set */
    const char *wanted; /* what a value must be; NULL: one of values */
    const char *help;   /* lines separated by '\n' */
    const char *values; /* words that the value may be, separated by blanks; "file": a file's name;
                           "group" at the end: a group of the mesh;
                           NULL: anything else */
};

/** Option i, 0 and up, or NULL behind the last. */
const pl_option *pl_option_at(int i);

/** "Nodes that move", for example. */
const char *pl_section_title(pl_section section);

#endif
