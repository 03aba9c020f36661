/* gmsh_builder: a small mesh in every encoding of Gmsh. */
#include "support/gmsh_builder.h"

const double gmsh_points[N_NODES][3] = {{0, 0, 0}, {1, 0, 0},          {0, 1, 0},
                                        {0, 0, 1}, {0.25, 0.125, 0.2}, {5, 6, 7}};
const int gmsh_tets[4][4] = {{0, 1, 2, 4}, {0, 1, 3, 4}, {0, 2, 3, 4}, {1, 2, 3, 4}};

int64_t gmsh_node_tag(const struct variant *variant, int node) {
    return variant->sparse ? 1000 - 10 * node : node + 1;
}

static void put_names(file_builder *file) {
    builder_text(file, "$PhysicalNames\n2\n3 7 \"the part\"\n2 8 \"skin\"\n$EndPhysicalNames\n");
}

file_builder gmsh_begin(const struct variant *variant, const char *version) {
    file_builder file = {.binary = variant->binary, .swapped = variant->swapped};
    file.wrap = variant->wrap;
    builder_text(&file, "$MeshFormat\n%s %d 8\n", version, variant->binary);
    if (variant->binary) {
        builder_integer(&file, 1, 4);
        builder_text(&file, "\n");
    }
    builder_text(&file, "$EndMeshFormat\n$Comments\n$Nodes are below\n$EndComments\n");
    put_names(&file);
    return file;
}

void gmsh_put_element2(file_builder *file, const struct variant *variant, int type, int number,
                       int physical, int elementary, int n, const int *nodes) {
    const int binary[] = {type, 1, 2, number, physical, elementary};
    const int text[] = {number, type, 2, physical, elementary};
    for (int i = 0; i < (variant->binary ? 6 : 5); i++)
        builder_integer(file, variant->binary ? binary[i] : text[i], 4);
    for (int i = 0; i < n; i++)
        builder_integer(file, gmsh_node_tag(variant, nodes[i]), 4);
    builder_line(file);
}

/* An element of MSH 1: number, type, groups, number of nodes, nodes. */
static void put_element1(file_builder *file, const struct variant *variant, int type, int number,
                         int physical, int elementary, int n, const int *nodes) {
    const int head[] = {number, type, physical, elementary, n};
    for (int i = 0; i < 5; i++)
        builder_integer(file, head[i], 4);
    for (int i = 0; i < n; i++)
        builder_integer(file, gmsh_node_tag(variant, nodes[i]), 4);
    builder_line(file);
}

/* Nodes and elements of MSH 1 and 2, from the number of nodes on; between: the lines between them. */
static void
put_mesh(file_builder *file, const struct variant *variant, int64_t *place, const char *between,
         void (*put_element)(file_builder *file, const struct variant *variant, int type,
                             int number, int physical, int elementary, int n, const int *nodes)) {
    builder_text(file, "%d\n", N_NODES);
    for (int i = 0; i < N_NODES; i++) {
        builder_integer(file, gmsh_node_tag(variant, i), 4);
        place[i] = builder_place(file);
        for (int d = 0; d < 3; d++)
            builder_real(file, gmsh_points[i][d], 8);
        builder_line(file);
    }
    builder_text(file, "\n%s\n7\n", between);
    put_element(file, variant, 15, 1, 0, 1, 1, (int[]){0});
    put_element(file, variant, 1, 2, 0, 2, 2, (int[]){0, 1});
    put_element(file, variant, 2, 3, 8, 3, 3, (int[]){0, 1, 2});
    for (int i = 0; i < 4; i++)
        put_element(file, variant, 4, 10 + i * i, 7, i < 3 ? 4 : 5, 4, gmsh_tets[i]);
}

file_builder gmsh_make_msh2(const struct variant *variant, int64_t *place) {
    file_builder file = gmsh_begin(variant, "2.2");
    builder_text(&file, "$Nodes\n");
    put_mesh(&file, variant, place, "$EndNodes\n$Elements", gmsh_put_element2);
    builder_text(&file, "\n$EndElements\n$Periodic\n1\n2 1 2\n");
    builder_text(&file, "Affine 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n1\n%d %d\n$EndPeriodic\n",
                 (int)gmsh_node_tag(variant, 3), (int)gmsh_node_tag(variant, FAR));
    builder_text(&file, "$NodeData\n1\n\"$Elements\"\n$EndNodeData\n");
    return file;
}

file_builder gmsh_make_msh1(const struct variant *variant, int64_t *place) {
    file_builder file = {.wrap = variant->wrap};
    builder_text(&file, "$NOD\n");
    put_mesh(&file, variant, place, "$ENDNOD\n$ELM", put_element1);
    builder_text(&file, "\n$ENDELM\n$Periodic\n1\n2 1 2\n1\n%d %d\n$EndPeriodic\n",
                 (int)gmsh_node_tag(variant, 3), (int)gmsh_node_tag(variant, FAR));
    put_names(&file);
    return file;
}

/* $Entities: a curve, a surface of the skin, two volumes of the part. */
static void put_entity(file_builder *file, int tag, int physical) {
    builder_integer(file, tag, 4);
    for (int i = 0; i < 6; i++)
        builder_real(file, i, 8);
    builder_integer(file, physical != 0, 8);
    if (physical != 0)
        builder_integer(file, physical, 4);
    builder_integer(file, 1, 8);
    builder_integer(file, -tag, 4);
    builder_line(file);
}

void gmsh_put_sizes(file_builder *file, int64_t a, int64_t b, int64_t c, int64_t d) {
    builder_integer(file, a, 8);
    builder_integer(file, b, 8);
    builder_integer(file, c, 8);
    builder_integer(file, d, 8);
    builder_line(file);
}

void gmsh_put_head(file_builder *file, const struct variant *variant, int dim, int tag, int kind,
                   int64_t n) {
    builder_integer(file, variant->is_40 ? tag : dim, 4);
    builder_integer(file, variant->is_40 ? dim : tag, 4);
    builder_integer(file, kind, 4);
    builder_integer(file, n, 8);
    builder_line(file);
}

/* Nodes first .. first + n - 1 as a block on an entity of dim. */
static void put_nodes4(file_builder *file, const struct variant *variant, int dim, int first, int n,
                       int64_t *place) {
    int extra = variant->parametric ? dim : 0;
    gmsh_put_head(file, variant, dim, dim + 1, variant->parametric, n);
    for (int i = first; i < first + n && !variant->is_40; i++) {
        builder_integer(file, gmsh_node_tag(variant, i), 8);
        builder_line(file);
    }
    for (int i = first; i < first + n; i++) {
        if (variant->is_40)
            builder_integer(file, gmsh_node_tag(variant, i), 4);
        place[i] = builder_place(file);
        for (int d = 0; d < 3; d++)
            builder_real(file, gmsh_points[i][d], 8);
        for (int d = 0; d < extra; d++)
            builder_real(file, 99, 8);
        builder_line(file);
    }
}

static void put_element4(file_builder *file, const struct variant *variant, int number, int n,
                         const int *nodes) {
    const int size = variant->is_40 ? 4 : 8;
    builder_integer(file, number, size);
    for (int i = 0; i < n; i++)
        builder_integer(file, gmsh_node_tag(variant, nodes[i]), size);
    builder_line(file);
}

void gmsh_put_section(file_builder *file, const struct variant *variant, int blocks, int n) {
    builder_integer(file, blocks, 8);
    builder_integer(file, n, 8);
    builder_line(file);
    for (int i = 0; i < 2 && !variant->is_40; i++)
        builder_integer(file, i == 0 ? 1 : 1000, 8);
    builder_line(file);
}

static void put_elements4(file_builder *file, const struct variant *variant) {
    builder_text(file, "\n$EndNodes\n$Elements\n");
    gmsh_put_section(file, variant, 5, 7);
    gmsh_put_head(file, variant, 0, 1, 15, 1);
    put_element4(file, variant, 1, 1, (int[]){0});
    gmsh_put_head(file, variant, 1, 2, 1, 1);
    put_element4(file, variant, 2, 2, (int[]){0, 1});
    gmsh_put_head(file, variant, 2, 3, 2, 1);
    put_element4(file, variant, 3, 3, (int[]){0, 1, 2});
    gmsh_put_head(file, variant, 3, 4, 4, 3);
    for (int i = 0; i < 3; i++)
        put_element4(file, variant, 10 + i * i, 4, gmsh_tets[i]);
    gmsh_put_head(file, variant, 3, 5, 4, 1);
    put_element4(file, variant, 19, 4, gmsh_tets[3]);
}

/* An entity that is a point: in MSH 4.0 it has a box, too. */
static void put_point_entity(file_builder *file, const struct variant *variant) {
    builder_integer(file, 1, 4);
    for (int i = 0; i < (variant->is_40 ? 6 : 3); i++)
        builder_real(file, i, 8);
    builder_integer(file, 0, 8);
    builder_line(file);
}

/* A pair of surfaces with a transform, and one pair of nodes. */
static void put_periodic4(file_builder *file, const struct variant *variant) {
    const int size = variant->is_40 ? 4 : 8;
    builder_integer(file, 1, size);
    for (int i = 0; i < 3; i++)
        builder_integer(file, (const int[]){2, 1, 2}[i], 4);
    if (!variant->is_40)
        builder_integer(file, 16, 8);
    else if (variant->binary)
        builder_integer(file, -1, 8);
    else
        builder_text(file, "\nAffine ");
    const int wrap = file->wrap; /* the word and its numbers are one line */
    file->wrap = variant->is_40 ? 0 : wrap;
    for (int i = 0; i < 16; i++)
        builder_real(file, i % 5 == 0, 8);
    builder_line(file);
    file->wrap = wrap;
    builder_integer(file, 1, 8);
    builder_integer(file, gmsh_node_tag(variant, 3), size);
    builder_integer(file, gmsh_node_tag(variant, FAR), size);
}

file_builder gmsh_make_msh4(const struct variant *variant, int64_t *place) {
    file_builder file = gmsh_begin(variant, variant->is_40 ? "4" : "4.1");
    builder_text(&file, "$Entities\n");
    gmsh_put_sizes(&file, 1, 1, 1, 2);
    put_point_entity(&file, variant);
    put_entity(&file, 2, 0);
    put_entity(&file, 3, -8);
    put_entity(&file, 4, 7);
    put_entity(&file, 5, 7);
    builder_text(&file, "\n$EndEntities\n$Nodes\n");
    gmsh_put_section(&file, variant, 4, N_NODES);
    put_nodes4(&file, variant, 1, 0, 2, place);
    put_nodes4(&file, variant, 2, 2, 2, place);
    put_nodes4(&file, variant, 0, 4, 0, place);
    put_nodes4(&file, variant, 3, 4, 2, place);
    put_elements4(&file, variant);
    builder_text(&file, "\n$EndElements\n$Periodic\n");
    put_periodic4(&file, variant);
    builder_text(&file, "\n$EndPeriodic\n");
    return file;
}
