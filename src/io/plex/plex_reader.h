/* plex_reader: declarations that the files of the reader of PETSc's DMPlex files share; for plex*.c only.
 *
 *   plex_reader                             a file while it is read
 *   plex_read_integers, plex_list_group     lists of numbers and names (plex_lists.c)
 *   plex_read_topology, plex_nodes_of, ...  points, cones and elements (plex_topology.c)
 *   plex_read_labels, plex_check_labels     regions, surfaces, lines, groups (plex_labels.c)
 *
 * In a DMPlex everything is a point with a number: elements first, then nodes, then faces and
 * edges, if the mesh has them. The cone of a point are the points that bound it: of an element its
 * faces (or its nodes, in a mesh without faces and edges), of a face its edges, of an edge its
 * nodes. Orientations say in which sense, and from which on, an element goes round its face.
 *
 * DMView of PETSc writes three forms, version 1 to 3 of its attribute dmplex_storage_version.
 */
#ifndef PL_IO_PLEX_PLEX_READER_H
#define PL_IO_PLEX_PLEX_READER_H

#include "io/hdf5/hdf5.h"

enum { PLEX_MOST_STRATA = 4, PLEX_MOST_NODES = 64 };

/** Points whose cones stand one after another: all of them (versions 1 and 2), or those of one
 *  dimension (3). */
typedef struct plex_stratum {
    int64_t first, n;                     /* points */
    int64_t below;                        /* the point that is 0 in these cones */
    io_hdf5_integers cones, orientations; /* of the same length */
    io_hdf5_integers sizes;               /* of cones, [n]; until plex_read_topology returns */
} plex_stratum;

typedef struct plex_reader {
    io_model *model;
    io_hdf5 *file;
    planish_error *error;
    const char *name;         /* of the mesh; "": version 1 has none */
    io_hdf5_path root;        /* group of topology and labels: "" or /topologies/NAME */
    io_hdf5_path topology;    /* group of the points */
    io_hdf5_path section;     /* group that tells the layout of the coordinates, */
    io_hdf5_path coordinates; /* and their path */
    int version;              /* 1: root is "" */
    int dim;                  /* of the elements */
    plex_stratum stratum[PLEX_MOST_STRATA];
    int64_t n_points, n_elements, n_nodes; /* elements and nodes are the first points */
    int64_t *start;     /* [n_points] where a point's cone begins in its stratum's, */
    uint8_t *size;      /* [n_points] and how many points it has; 0: a node */
    int32_t *of_point;  /* [n_points] index in its list (plex_list_of) of a point that is an element
                           of the model; else -1 */
    int64_t first_face; /* all faces are among the points from here on */
    int32_t *triangle;  /* [faces][3] nodes of those that have three edges, else -1; of meshes of
                           tetrahedra, once plex_read_elements has found them */
} plex_reader;

/* ---- plex_lists.c -------------------------------------------------------------------------- */

/** Read the whole numbers called name in a group; released by io_hdf5_integers_release in any
 *  case. */
int plex_read_integers(plex_reader *r, const char *group, const char *name, io_hdf5_integers *list);

/** List the group called name in another group, path parent: its path and its names, none if it is
 *  not there. */
int plex_list_group(plex_reader *r, const char *parent, const char *name, io_hdf5_path *path,
                    io_hdf5_names *names);

/* ---- plex_topology.c ----------------------------------------------------------------------- */

/** Read cones, and find the elements and the nodes among the points. */
int plex_read_topology(plex_reader *r);

/** Release all that plex_read_topology and plex_read_elements have made. */
void plex_release_topology(plex_reader *r);

/** Make elements cells of the model, or others; those of no planish_cell_type hold their nodes. Then
 *  plex_nodes_of knows triangles. */
int plex_read_elements(plex_reader *r);

/** Return the dimension of a point. */
int plex_dim_of(const plex_reader *r, int64_t point);

/** Return the list of the model (io_model_list) that a point of that dimension is in, if in any. */
int plex_list_of(const plex_reader *r, int64_t point);

/** Return whether all elements are simplices, and all points are bounded by points of the right
 *  kind. */
int plex_has_simplices_alone(const plex_reader *r);

/** Find the nodes (indices) of a point in the order in which DMPlexGetTransitiveClosure has them:
 *  node [PLEX_MOST_NODES]. Return how many, or -1: the file is damaged. */
int plex_nodes_of(const plex_reader *r, int64_t point, int32_t *node);

/** Fail: a point is bounded by what it cannot be bounded by. */
int plex_fail_point(plex_reader *r, int64_t point);

/** Make an edge or face an element of the model, if it is none yet; for simplices room has been made.
 */
int plex_add_cell(plex_reader *r, int64_t point);

/* ---- plex_labels.c ------------------------------------------------------------------------- */

/** Make regions, surfaces, lines and groups of the labels. */
int plex_read_labels(plex_reader *r);

/** Check whether all labels are that of regions, which names each element once at most, or are made
 *  by programs for their own use. Fail if one names a number that is not a point. */
int plex_check_labels(plex_reader *r, int *has_regions_alone);

#endif
