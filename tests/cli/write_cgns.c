/* write_cgns: meshes written, and compared, with the CGNS library itself.
 *
 *     write_cgns write FILE N float|double fixed|mixed hdf5|adf
 *     write_cgns compare A B     prints how many coordinates differ; all else must be the same
 */
#include "cube_mesh.h"

#include <cgnslib.h>
#include <stdio.h>
#include <string.h>

static void must(int status) {
    if (status)
        cg_error_exit();
}

static cgsize_t *longer(const int *from, int n) {
    cgsize_t *to = malloc((size_t)n * sizeof *to);
    for (int i = 0; i < n; i++)
        to[i] = from[i];
    return to;
}

static void write_coordinate(int file, const char *name, const double *values, int n,
                             int is_float) {
    int index;
    float *single = malloc((size_t)n * sizeof *single);
    for (int i = 0; i < n; i++)
        single[i] = (float)values[i];
    if (is_float)
        must(cg_coord_write(file, 1, 1, RealSingle, name, single, &index));
    else
        must(cg_coord_write(file, 1, 1, RealDouble, name, values, &index));
    free(single);
}

static void write_fixed(int file, const cube_mesh *m) {
    int section;
    const int lower = m->n_lower, all = m->n_tetrahedra, faces = m->n_triangles;
    cgsize_t *tetrahedra = longer(m->tetrahedra, 4 * all),
             *triangles = longer(m->triangles, 3 * faces);
    must(cg_section_write(file, 1, 1, "lower", TETRA_4, 1, lower, 0, tetrahedra, &section));
    must(cg_section_write(file, 1, 1, "upper", TETRA_4, lower + 1, all, 0, tetrahedra + 4 * lower,
                          &section));
    must(cg_section_write(file, 1, 1, "skin", TRI_3, all + 1, all + faces, 0, triangles, &section));
    free(tetrahedra);
    free(triangles);
}

static void write_mixed(int file, const cube_mesh *m) {
    int section;
    const int n = m->n_tetrahedra + m->n_triangles;
    cgsize_t *list = malloc((size_t)n * 5 * sizeof *list), at = 0;
    cgsize_t *offset = malloc(((size_t)n + 1) * sizeof *offset);
    for (int i = 0; i < n; i++) {
        const int is_triangle = i >= m->n_tetrahedra, size = is_triangle ? 3 : 4;
        const int *nodes =
            is_triangle ? m->triangles + 3 * (i - m->n_tetrahedra) : m->tetrahedra + 4 * i;
        offset[i] = at;
        list[at++] = is_triangle ? TRI_3 : TETRA_4;
        for (int j = 0; j < size; j++)
            list[at++] = nodes[j];
    }
    offset[n] = at;
    if (cg_poly_section_write(file, 1, 1, "all", MIXED, 1, n, 0, list, offset, &section))
        must(cg_section_write(file, 1, 1, "all", MIXED, 1, n, 0, list, &section));
    free(list);
    free(offset);
}

static void write_conditions(int file, const cube_mesh *m) {
    int index;
    const cgsize_t first = m->n_tetrahedra + 1, half = m->n_triangles / 2;
    const cgsize_t bottom[2] = {first, first + half - 1}, corner[2] = {1, 3};
    cgsize_t *top = malloc((size_t)half * sizeof *top);
    for (cgsize_t i = 0; i < half; i++)
        top[i] = first + half + i;
    must(cg_boco_write(file, 1, 1, "bottom", BCWall, PointRange, 2, bottom, &index));
    must(cg_boco_gridlocation_write(file, 1, 1, index, FaceCenter));
    must(cg_boco_write(file, 1, 1, "top", BCInflow, PointList, half, top, &index));
    must(cg_boco_gridlocation_write(file, 1, 1, index, FaceCenter));
    must(cg_goto(file, 1, "Zone_t", 1, "ZoneBC_t", 1, "BC_t", index, "end"));
    must(cg_famname_write("lid"));
    must(cg_boco_write(file, 1, 1, "corner", BCWall, PointList, 2, corner, &index));
    free(top);
}

static int write_file(char **argument) {
    int file, base, zone;
    cube_mesh m = cube_make(atoi(argument[1]));
    const cgsize_t size[3] = {m.n_nodes, m.n_tetrahedra, 0};
    const int is_float = strcmp(argument[2], "float") == 0;
    must(cg_set_file_type(strcmp(argument[4], "adf") == 0 ? CG_FILE_ADF : CG_FILE_HDF5));
    must(cg_open(argument[0], CG_MODE_WRITE, &file));
    must(cg_base_write(file, "Base", 3, 3, &base));
    must(cg_zone_write(file, base, "Zone", size, Unstructured, &zone));
    write_coordinate(file, "CoordinateX", m.x, m.n_nodes, is_float);
    write_coordinate(file, "CoordinateY", m.y, m.n_nodes, is_float);
    write_coordinate(file, "CoordinateZ", m.z, m.n_nodes, is_float);
    if (strcmp(argument[3], "mixed") == 0)
        write_mixed(file, &m);
    else
        write_fixed(file, &m);
    write_conditions(file, &m);
    must(cg_close(file));
    return 0;
}

/* ---- comparing ----------------------------------------------------------------------------- */

static int compare_coordinates(const int file[2], cgsize_t n) {
    static const char *const names[] = {"CoordinateX", "CoordinateY", "CoordinateZ"};
    const cgsize_t from = 1;
    int different = 0;
    for (int d = 0; d < 3; d++) {
        double *x[2];
        for (int i = 0; i < 2; i++) {
            x[i] = malloc((size_t)n * sizeof **x);
            must(cg_coord_read(file[i], 1, 1, names[d], RealDouble, &from, &n, x[i]));
        }
        for (cgsize_t i = 0; i < n; i++)
            different += x[0][i] != x[1][i];
        free(x[0]);
        free(x[1]);
    }
    return different;
}

static int same_sections(const int file[2]) {
    int n[2], same = 1;
    for (int i = 0; i < 2; i++)
        must(cg_nsections(file[i], 1, 1, &n[i]));
    for (int s = 1; s <= n[0] && n[0] == n[1]; s++) {
        char name[2][33];
        cgsize_t start, end, size[2], *list[2];
        int boundary, parents;
        ElementType_t type;
        for (int i = 0; i < 2; i++) {
            must(cg_section_read(file[i], 1, 1, s, name[i], &type, &start, &end, &boundary,
                                 &parents));
            must(cg_ElementDataSize(file[i], 1, 1, s, &size[i]));
            list[i] = calloc((size_t)size[i], sizeof **list);
            cgsize_t *offset = calloc((size_t)(end - start) + 2, sizeof *offset);
            if (type == MIXED)
                must(cg_poly_elements_read(file[i], 1, 1, s, list[i], offset, NULL));
            else
                must(cg_elements_read(file[i], 1, 1, s, list[i], NULL));
            free(offset);
        }
        same &= size[0] == size[1] && strcmp(name[0], name[1]) == 0 &&
                memcmp(list[0], list[1], (size_t)size[0] * sizeof **list) == 0;
        free(list[0]);
        free(list[1]);
    }
    return same && n[0] == n[1];
}

static int compare_files(char **path) {
    int file[2], conditions[2];
    cgsize_t size[2][3];
    char name[33];
    for (int i = 0; i < 2; i++) {
        must(cg_open(path[i], CG_MODE_READ, &file[i]));
        must(cg_zone_read(file[i], 1, 1, name, size[i]));
        must(cg_nbocos(file[i], 1, 1, &conditions[i]));
    }
    if (memcmp(size[0], size[1], sizeof size[0]) || conditions[0] != 3 || conditions[1] != 3 ||
        !same_sections(file))
        return 1;
    printf("%d\n", compare_coordinates(file, size[0][0]));
    return 0;
}

int main(int n, char **argument) {
    if (n == 7 && strcmp(argument[1], "write") == 0)
        return write_file(argument + 2);
    return n == 4 ? compare_files(argument + 2) : 2;
}
