/* shape: the surface of a mesh, its regions and its boundary layers.
 *
 *   slides.c    pl_find_slides                               nodes that slide on planes and lines
 *   layers.c    pl_find_layers                               thin elements of layers
 *   cell_layers.c    pl_find_thinness, pl_find_layers_of_cells    the same for any types
 *   regions.c   pl_region_name, pl_check_cell_arrays         arrays of cells
 *               pl_find_regions, pl_combine_regions          regions of elements
 *               pl_find_interfaces                           nodes between regions
 *
 * surface.h has the facets, planes and lines that slides.c asks for.
 */
#ifndef PL_SHAPE_H
#define PL_SHAPE_H

#include "topology/topology.h"

/** Find the constraint and direction of each node of dense, which given is the caller's of. tags may
 *  be NULL; its regions go by the elements of dense, by the caller's cells where these are corners.
 *  See planish_find_slides. Errors: _MESH,
 *  _MEMORY. */
int pl_find_slides(const pl_dense *dense, const planish_mesh *given, const planish_surface *tags,
                   int threads, uint8_t *constraint, double *direction, planish_slide_info *info,
                   planish_error *error);

/* An element is thin if its longest edge is at least so many times its shortest: beyond the usual
 * ratios of unstructured meshes of any quality, below those that layers are made for. */
static const double PL_THIN = 4;
/* Rows go on while the shortest edge of an element is shorter than all others of it by this factor:
 * they are by how much a row is wider than high. */
static const double PL_WIDE = 1.2;
/* Shortest edges go along with each other if they are within such a factor of each other, as those
 * of layers that grow. */
static const double PL_ALIKE = 2.5;

/* Layers of fewer elements are thin by chance. */
enum { PL_LEAST_OF_LAYER = 8 };

/** Facts about an element that layers are sought by. */
enum {
    PL_SHORTEST_EDGE = 7, /* number of the shortest edge of a simplex: 01, 02, 12, 03, 13, 23 */
    PL_IS_THIN = 8,       /* by PL_THIN */
    PL_IS_WIDE = 16,      /* by PL_WIDE */
    PL_IS_GIVEN = 32,     /* this is given, not to be found */
    PL_BADLY_SHAPED =
        64, /* the element is to be in no layer by itself, nor are many of them near one */
    PL_IS_INVALID = 128 /* beside that: it is not valid */
};

/* Marks of pl_follow_cell_rows. */
enum {
    PL_ROW_MARKED = 1, /* the element is of a layer */
    PL_ROW_STACKED = 2 /* it is not, but lies on one and was of it before a wall was moved */
};

/** Find the elements of layers: is_layer [n_elements] becomes 1 for them, 0 for the others, and
 *  *n_layer their number. mesh is dense. given [n_elements]: facts about elements, 0 for those that
 *  are to be found; NULL: all are. See planish_find_layers. Errors: _MESH, _MEMORY. */
int pl_find_layers(const planish_mesh *mesh, const uint8_t *given, int threads, uint8_t *is_layer,
                   int64_t *n_layer, planish_error *error);

/** Find how thin the elements of mesh->cells are: thinness [cells->n], 0 for simplices, pyramids and
 *  those that do not count, and the number of thin ones. mesh has dense coordinates. Errors:
 *  _PROCESS. */
int pl_find_thinness(const planish_mesh *mesh, int threads, uint8_t *thinness, int64_t *n_thin,
                     planish_error *error);

/** Find the elements of layers as pl_find_layers does, in mesh->cells; is_layer [cells->n]. thinness:
 *  from pl_find_thinness, with PL_BADLY_SHAPED and PL_IS_INVALID where that is not 0. mesh has dense
 *  coordinates. Errors: _MESH, _MEMORY. */
int pl_find_layers_of_cells(const planish_mesh *mesh, const uint8_t *thinness, int threads,
                            uint8_t *is_layer, int64_t *n_layer, planish_error *error);

/** Follow the rows of layers, along to wide elements that share uprights and across to badly shaped ones
 *  that are stacked on them: mark [cells->n], PL_ROW_MARKED or 0 before. thinness as above. Errors:
 *  _MEMORY. */
int pl_follow_cell_rows(const planish_mesh *mesh, const uint8_t *thinness, uint8_t *mark,
                        planish_error *error);

/** Return the rank of an array's name among the names of regions, from 1 for the surest one; 0:
 *  unknown; -1: the array tells no regions. */
int pl_region_name(const char *name);

/** Check names, types and values of arrays [n_arrays] for n_elements elements. Errors: _ARGUMENT.
 */
int pl_check_cell_arrays(const planish_cell_array *arrays, int n_arrays, int64_t n_elements,
                         planish_error *error);

/** Return the size of a number of type in bytes. */
size_t pl_number_size(planish_number type);

/** Decide which of the checked arrays are regions, and set is_region of each. mesh is dense, or has
 *  checked cells. See planish_find_regions. Errors: _MESH, _MEMORY. */
int pl_find_regions(const planish_mesh *mesh, planish_cell_array *arrays, int n_arrays, int threads,
                    planish_error *error);

/** Number the combinations of values of the arrays whose is_region is set: found [n_elements],
 * which is 0 before, and their number. Errors: _ARGUMENT (a value is not whole), _MEMORY. */
int pl_combine_regions(int64_t n_elements, const planish_cell_array *arrays, int n_arrays,
                       int32_t *found, int64_t *n_regions, planish_error *error);

/** Find the nodes with elements of several regions, mids among them: is_between [n_nodes] becomes 1
 *  for them, 0 for the others, and *n their number. mesh: that of cells as the caller has it, or a dense one.
 *  region [n_elements]. Errors: _MEMORY. */
int pl_find_interfaces(const planish_mesh *mesh, const int32_t *region, uint8_t *is_between,
                       int64_t *n, planish_error *error);

#endif
