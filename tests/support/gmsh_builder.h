/* gmsh_builder: a small mesh in every encoding of Gmsh.
 *
 * A tetrahedron is cut into four by a node inside, with one surface triangle, one line, one point.
 */
#ifndef TEST_GMSH_BUILDER_H
#define TEST_GMSH_BUILDER_H

#include "support/file_builder.h"

/** How a test file is written. */
struct variant {
    int binary, swapped;
    int sparse;     /* node tags 1000, 990, 980, ...; else 1, 2, 3, ... */
    int parametric; /* MSH 4: u (and v) behind the coordinates of nodes on lines and surfaces */
    int wrap;       /* as in file_builder */
    int is_40;      /* MSH 4: 4.0, not 4.1 */
};

enum { N_NODES = 6, INSIDE = 4, FAR = 5 };

/** Coordinates of the nodes; nodes of the tetrahedra. */
extern const double gmsh_points[N_NODES][3];
extern const int gmsh_tets[4][4];

/** Tag of a node in the file. */
int64_t gmsh_node_tag(const struct variant *variant, int node);

/** Begin a file: its header, a comment, names of groups. */
file_builder gmsh_begin(const struct variant *variant, const char *version);

/** Write an element of MSH 2: its header if binary, number, tags, nodes. */
void gmsh_put_element2(file_builder *file, const struct variant *variant, int type, int number,
                       int physical, int elementary, int n, const int *nodes);

/** Make the mesh as MSH 2; place [N_NODES]: where the coordinates are. */
file_builder gmsh_make_msh2(const struct variant *variant, int64_t *place);

/** Make the mesh as MSH 1, which has neither a header nor names or pairs: the reader takes what
 * else it finds. place as above. */
file_builder gmsh_make_msh1(const struct variant *variant, int64_t *place);

/** Write the head of a block of MSH 4. */
void gmsh_put_head(file_builder *file, const struct variant *variant, int dim, int tag, int kind,
                   int64_t n);

/** Write four numbers of 64 bits. */
void gmsh_put_sizes(file_builder *file, int64_t a, int64_t b, int64_t c, int64_t d);

/** Write the numbers of blocks and of what is in them; MSH 4.1: and tags. */
void gmsh_put_section(file_builder *file, const struct variant *variant, int blocks, int n);

/** Make the mesh as MSH 4; place as above. */
file_builder gmsh_make_msh4(const struct variant *variant, int64_t *place);

#endif
