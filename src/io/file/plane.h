/* plane: the plane that a mesh of triangles lies in, and the coordinates that it has there. */
#ifndef PL_IO_FILE_PLANE_H
#define PL_IO_FILE_PLANE_H

#include "io/core/format.h"

/** Find the plane of the triangles' nodes, model->plane. Fails where they lie in none. format: as
 *  for io_model_finish. */
int io_plane_find(io_model *model, const io_format *format, planish_error *error);

/** The tilted plane that fits the nodes of the triangles, within the box from low to high, best;
 *  not 0 at is_thin: they are along a line. */
int io_plane_fit(const io_model *model, const double low[3], const double high[3], io_plane *plane,
                 int *is_thin, planish_error *error);

/** Let triangles have the signs that they have in the file, and keep the coordinates read, of a
 *  tilted plane. */
int io_plane_keep(io_model *model, planish_error *error);

/** Whether a node of a tilted plane with coordinates uv is not where it was. */
int io_plane_has_moved(const io_model *model, int64_t node, const double *uv);

/** Whether coordinates in the plane are x and y, so that a writer takes them as they are. */
static inline int io_plane_is_xy(const io_plane *plane) {
    return plane->axis[2] == 2 && !plane->is_tilted;
}

/** The coordinates in the plane of a node at xyz. */
void io_plane_project(const io_plane *plane, const double xyz[3], double uv[2]);

/** Where node is with coordinates at [dim], in the file's columns. */
void io_model_place(const io_model *model, int64_t node, const double *at, double xyz[3]);

/** What a writer takes for coordinates [n_nodes][dim]: *places [n_nodes][written], which are
 *  coordinates themselves where *owned is NULL, else *owned, to be released by pl_free. */
int io_model_places(const io_model *model, const double *coordinates, int threads,
                    const double **places, double **owned, planish_error *error);

/** The same for the coordinates that were read. */
const double *io_model_places_read(const io_model *model);

#endif
