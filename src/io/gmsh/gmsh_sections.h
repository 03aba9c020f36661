/* gmsh_sections: the sections of MSH files, as gmsh.c reads them one after the other.
 *
 *   gmsh_names.c                      names of groups
 *   gmsh_data.c                       values of nodes and elements
 *   gmsh2.c, gmsh_copies.c, gmsh4.c   sections of MSH 1 and 2, and of MSH 4
 */
#ifndef PL_IO_GMSH_GMSH_SECTIONS_H
#define PL_IO_GMSH_GMSH_SECTIONS_H

#include "io/gmsh/gmsh_reader.h"

/** Read $PhysicalNames; and, when all is read, give names without a dimension theirs. */
int gmsh_names(gmsh_reader *reader);
int gmsh_complete_names(gmsh_reader *reader);

/** Skip the binary values of $NodeData and the like, by their count. with_nodes: each value is of
 *  as many nodes as it says. Return 0, or -1: they are not what they should be; the cursor has not
 *  moved then. */
int gmsh_skip_data(gmsh_reader *reader, int with_nodes);

/** Note the section $NodeData or $ElementData behind whose name begin is, and whose end mark is at end.
 *  Only a lack of memory is an error. */
int gmsh_note_data(gmsh_reader *reader, int of_elements, const char *begin, const char *end);

/** Make arrays (arrays.h) of the sections that gmsh_note_data has kept and that may be regions.
 *  Call this when all has been read and the elements' numbers are reduced; and give the places of
 *  all sections to the model (data.h). Malformed sections are passed over. */
int gmsh_read_data(gmsh_reader *reader);

/** Read the values of an array: io_format.read_data. */
int gmsh_read_values(io_model *model, const io_data *data, double *values, planish_error *error);

/** Read sections of MSH 1 and 2, and of MSH 4; gmsh2_merge_copies follows the elements of MSH 2. */
int gmsh2_nodes(gmsh_reader *reader);
int gmsh2_elements(gmsh_reader *reader);
int gmsh2_merge_copies(gmsh_reader *reader);
int gmsh4_entities(gmsh_reader *reader);
int gmsh4_partitioned_entities(gmsh_reader *reader);
int gmsh4_nodes(gmsh_reader *reader);
int gmsh4_elements(gmsh_reader *reader);

#endif
