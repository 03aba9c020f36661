/* plane: the plane that a mesh of triangles lies in, and the coordinates that it has there.
 *
 *   io_plane_find, io_tolerance_of_digits        find the plane; how exact a file is (plane_find.c)
 *   io_plane_keep                                signs of triangles as in the file
 *   io_plane_project                             from the file's columns to the plane
 *   io_written_coordinates, io_written_as_read   what a writer takes
 *   io_stored                                    a coordinate as the file holds it
 *   io_plane_is_xy                               whether these are the same
 */
#ifndef PL_IO_FILE_PLANE_H
#define PL_IO_FILE_PLANE_H

#include "io/core/format.h"

/** Find the plane of the nodes of triangles and other elements, model->plane. *is_found: 0 where they lie
 *  in none; model->plane then is the one that fits them best. Fails where they are along a line. format:
 *  as for io_model_finish. */
int io_plane_find(io_model *model, const io_format *format, int *is_found, planish_error *error);

/** Distance that nodes of a plane may be off it by the digits that the file gives them, as a part
 *  of the diagonal of the bounding box; 0: what the library takes by itself. */
double io_tolerance_of_digits(const io_model *model, const io_format *format);

/** Let triangles have the signs that they have in the file, and keep the coordinates read, of a
 *  tilted plane. */
int io_plane_keep(io_model *model, planish_error *error);

/** Return whether coordinates in the plane are x and y, so that a writer takes them as they are. */
static inline int io_plane_is_xy(const io_plane *plane) {
    return plane->axis[2] == 2 && !plane->is_tilted;
}

/** Find the coordinates in the plane of a node at xyz. */
void io_plane_project(const io_plane *plane, const double xyz[3], double uv[2]);

/** Round a coordinate to what the file holds of it. */
double io_stored(const io_model *model, double value);

/** Check that all coordinates [n_nodes][dim] are finite. */
int io_check_coordinates(const io_model *model, const double *coordinates, planish_error *error);

/** Find the coordinates that a writer takes for coordinates [n_nodes][dim] of the mesh: *places
 *  [n_nodes][written], or, of model->place_node where that is given, [n_places][written]. They are
 *  coordinates themselves where *owned is NULL, else *owned, to be released by pl_free. */
int io_written_coordinates(const io_model *model, const double *coordinates,
                           const int32_t *place_node, int threads, const double **places,
                           double **owned, planish_error *error);

/** Return the coordinates that a writer takes for those that were read, borrowed. */
const double *io_written_as_read(const io_model *model);

#endif
