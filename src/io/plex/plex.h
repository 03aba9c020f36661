/* plex: what the parts of the reader of PETSc's DMPlex files share; for plex.c, plex_topology.c,
 * plex_labels.c and plex_copies.c.
 *
 * In a DMPlex everything is a point with a number: elements first, then nodes, then faces and
 * edges, if the mesh has them. The cone of a point are the points that bound it: of an element its
 * faces (or its nodes, in a mesh without faces and edges), of a face its edges, of an edge its
 * nodes. Orientations say in which sense, and from which on, an element goes round its face.
 *
 * DMView of PETSc writes three forms, version 1 to 3 of its attribute dmplex_storage_version.
 */
#ifndef PL_IO_PLEX_PLEX_H
#define PL_IO_PLEX_PLEX_H

#include "io/hdf5/hdf5.h"

enum { PLEX_MOST_STRATA = 4, PLEX_MOST_NODES = 64 };

/** Points whose cones stand one after another: all of them (versions 1 and 2), or those of one
 *  dimension (3). */
typedef struct plex_stratum {
    int64_t first, n;                     /* points */
    int64_t below;                        /* the point that is 0 in these cones */
    io_hdf5_integers cones, orientations; /* likewise long */
} plex_stratum;

typedef struct plex_reader {
    io_model *model;
    io_hdf5 *file;
    planish_error *error;
    char root[IO_HDF5_PATH_SIZE]; /* group of topology and labels: "" or /topologies/NAME */
    char coordinates[IO_HDF5_PATH_SIZE];
    int version; /* 1: root is "" */
    int dim;     /* of the elements */
    plex_stratum stratum[PLEX_MOST_STRATA];
    int n_strata;
    int64_t n_points, n_elements, n_nodes; /* elements and nodes are the first points */
    int64_t *start;    /* [n_points] where a point's cone begins in its stratum's, */
    uint8_t *size;     /* [n_points] and how many points it has; 0: a node */
    int32_t *of_point; /* [n_points] index among the cells of its dimension of a point that is one
                          of the model's; else -1 */
    int64_t first_face, n_faces; /* all faces are among these points */
    int32_t *triangle;           /* [n_faces][3] nodes of those that have three edges; else -1 */
} plex_reader;

/* ---- plex_topology.c ----------------------------------------------------------------------- */

/** Cones, and what is an element and what a node. */
int plex_read_topology(plex_reader *r);
void plex_release_topology(plex_reader *r);

/** Elements become cells of the model; those that are no simplices hold their nodes. Then
 *  plex_nodes_of knows triangles. */
int plex_read_elements(plex_reader *r);

/** The dimension of a point. */
int plex_dim_of(const plex_reader *r, int64_t point);

/** Whether all elements are simplices, and all points are bounded by points of the right kind. */
int plex_has_simplices_alone(const plex_reader *r);

/** Nodes (indices) of a point in the order in which DMPlexGetTransitiveClosure has them: node
 *  [PLEX_MOST_NODES]. Returns how many, or -1: the file is damaged. */
int plex_nodes_of(const plex_reader *r, int64_t point, int32_t *node);

/** A point is bounded by what it cannot be bounded by. */
int plex_fail_point(plex_reader *r, int64_t point);

/** An edge or face becomes a cell of the model, if it is none yet; room has been made. */
int plex_add_cell(plex_reader *r, int64_t point);

/* ---- plex_labels.c ------------------------------------------------------------------------- */

/** Labels become regions, surfaces, lines and groups. */
int plex_read_labels(plex_reader *r);

/** Whether there are no labels but that of regions, of which each element has one at the most, and
 *  those that programs make for themselves. Fails if any says something of what is no point. */
int plex_check_labels(plex_reader *r, int *has_regions_alone);

/* ---- plex_copies.c ------------------------------------------------------------------------- */

/** Where a mesh of Firedrake has its coordinates, if there are no others: r->coordinates, and
 *  section [IO_HDF5_PATH_SIZE], the group that tells their layout; *found. */
int plex_find_function(plex_reader *r, char *section, int *found);

/** After the coordinates have been read: all copies of them are coordinates, too. Fails on others
 *  that would stay behind. */
int plex_read_copies(plex_reader *r);

/** How many arrays there are that may be copies. */
int plex_count_copies(plex_reader *r, int *n);

/* ---- for those who load such files with PETSc ----------------------------------------------- */

typedef struct io_plex_outline {
    int version;
    char name[256];                      /* of the mesh; "": version 1 has none */
    char coordinates[IO_HDF5_PATH_SIZE]; /* path of their dataset */
    int dim, columns;                    /* of the elements; coordinates of a node */
    int64_t n_nodes;
    int has_simplices_alone; /* as elements, and all points are bounded as they must be */
    int has_copies;          /* of the coordinates, or other arrays that are as long */
    int has_regions_alone;   /* no labels but that of regions; an element is of one, never of -1 */
} io_plex_outline;

/** What stands in the file at path; but for places of nodes, nothing in it can be out of range
 *  then. */
int io_plex_outline_of(const char *path, io_plex_outline *outline, planish_error *error);

#endif
