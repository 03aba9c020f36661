/* plex_builder: a small mesh in all forms of DMPlex, with what may be wrong in it. */
#ifndef TEST_PLEX_BUILDER_H
#define TEST_PLEX_BUILDER_H

#include "support/hdf5_builder.h"

#ifdef PL_HDF5

enum { N_ELEMENTS = 6, N_NODES = 8, N_FACES = 18, N_EDGES = 19, N_POINTS = 51, N_CONES = 116 };

/* Where coordinates stand once more: as a function of Firedrake's, a vector that nobody calls
 * coordinates, for viewers; or as a function alone; or another link to the same. */
enum { FUNCTION = 1, VECTOR = 2, VIEWED = 4, FUNCTION_ALONE = 8, LINK = 16 };

typedef struct plex {
    int version;
    int copies;         /* of those above */
    int has_no_copy;    /* they have other values */
    int is_extruded;    /* and there is a mesh made of this one */
    int is_reversed;    /* the function has the last node first */
    int is_permuted;    /* points stand from the last to the first */
    int has_nodes_last; /* behind faces and edges */
    int is_flat;        /* elements are bounded by nodes, and the last one is a pyramid */
    int chunk, is_packed, is_float;
    int is_dangling;                  /* a link for a label leads nowhere */
    int is_one_chunk, has_user_block; /* all data in one chunk; bytes before HDF5's own */
    int dim, cone, order, size, labelled, row, rows, meshes;
    double x; /* of the second node */
} plex;

/** Nodes of the tetrahedra, as DMPlexGetTransitiveClosure has them; coordinates of the nodes. */
extern const int32_t plex_corners[N_ELEMENTS * 4];
extern const double plex_places[N_NODES * 3];

/** A file in which nothing is wrong. */
extern const plex plex_right;

/** Read the file of p, which is valid. */
planish_file *plex_read(const plex *p);

/** Make the file of p. */
file_builder plex_make(const plex *p);

/** Write integers to group/name. */
void plex_put(hdf5_builder *b, const char *group, const char *name, int n, const int *values);

#endif

#endif
