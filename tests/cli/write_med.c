/* write_med: meshes written, and compared, with the MED library itself.
 *
 *     write_med write FILE N
 *     write_med compare A B     prints how many coordinates differ; all else must be the same
 */
#include "cube_mesh.h"

#include <med.h>
#include <stdio.h>
#include <string.h>

#define MESH "cube"

static void must(med_err status) {
    if (status < 0) {
        fprintf(stderr, "the MED library failed\n");
        exit(1);
    }
}

static void write_elements(med_idt file, med_geometry_type type, int n, int nodes, const int *list,
                           int n_first, int first, int second) {
    med_int *to = malloc((size_t)(n * nodes) * sizeof *to);
    for (int i = 0; i < n * nodes; i++)
        to[i] = list[i];
    must(MEDmeshElementConnectivityWr(file, MESH, MED_NO_DT, MED_NO_IT, 0, MED_CELL, type,
                                      MED_NODAL, MED_FULL_INTERLACE, n, to));
    for (int i = 0; i < n; i++)
        to[i] = i < n_first ? first : second;
    must(MEDmeshEntityFamilyNumberWr(file, MESH, MED_NO_DT, MED_NO_IT, MED_CELL, type, n, to));
    free(to);
}

static void write_nodes(med_idt file, const cube_mesh *m) {
    double *xyz = malloc((size_t)m->n_nodes * 3 * sizeof *xyz);
    med_int *family = calloc((size_t)m->n_nodes, sizeof *family);
    for (int i = 0; i < m->n_nodes; i++) {
        xyz[3 * i] = m->x[i];
        xyz[3 * i + 1] = m->y[i];
        xyz[3 * i + 2] = m->z[i];
    }
    must(MEDmeshNodeCoordinateWr(file, MESH, MED_NO_DT, MED_NO_IT, 0, MED_FULL_INTERLACE,
                                 m->n_nodes, xyz));
    family[m->n_nodes / 2] = 1;
    must(MEDmeshEntityFamilyNumberWr(file, MESH, MED_NO_DT, MED_NO_IT, MED_NODE, MED_NONE,
                                     m->n_nodes, family));
    free(xyz);
    free(family);
}

static void write_family(med_idt file, const char *name, int number, int n, const char *groups) {
    char padded[2 * MED_LNAME_SIZE + 1] = "";
    for (int i = 0; i < n; i++, groups += strlen(groups) + 1)
        memcpy(padded + i * MED_LNAME_SIZE, groups, strlen(groups));
    must(MEDfamilyCr(file, MESH, name, number, n, padded));
}

static int write_file(char **argument) {
    cube_mesh m = cube_make(atoi(argument[1]));
    char axes[3 * MED_SNAME_SIZE + 1] = "", units[3 * MED_SNAME_SIZE + 1] = "";
    med_idt file = MEDfileOpen(argument[0], MED_ACC_CREAT);
    must(file < 0 ? -1 : 0);
    must(MEDmeshCr(file, MESH, 3, 3, MED_UNSTRUCTURED_MESH, "a cube", "s", MED_SORT_DTIT,
                   MED_CARTESIAN, axes, units));
    write_nodes(file, &m);
    write_elements(file, MED_TETRA4, m.n_tetrahedra, 4, m.tetrahedra, m.n_lower, -1, -2);
    write_elements(file, MED_TRIA3, m.n_triangles, 3, m.triangles, m.n_triangles / 2, -3, -4);
    write_family(file, "FAMILLE_ZERO", 0, 0, "");
    write_family(file, "F1", -1, 2, "solid\0lower");
    write_family(file, "F2", -2, 2, "solid\0upper");
    write_family(file, "F3", -3, 1, "bottom");
    write_family(file, "F4", -4, 1, "top");
    write_family(file, "F5", 1, 1, "middle");
    must(MEDfileClose(file));
    return 0;
}

/* ---- comparing ----------------------------------------------------------------------------- */

static med_int count(med_idt file, med_entity_type entity, med_geometry_type type,
                     med_data_type data) {
    med_bool changes, transforms;
    return MEDmeshnEntity(file, MESH, MED_NO_DT, MED_NO_IT, entity, type, data,
                          entity == MED_CELL ? MED_NODAL : MED_NO_CMODE, &changes, &transforms);
}

static int same_elements(const med_idt file[2], med_geometry_type type, int nodes) {
    const med_int n = count(file[0], MED_CELL, type, MED_CONNECTIVITY);
    if (n < 1 || n != count(file[1], MED_CELL, type, MED_CONNECTIVITY))
        return 0;
    med_int *list[2], *family[2];
    for (int i = 0; i < 2; i++) {
        list[i] = malloc((size_t)(n * nodes) * sizeof **list);
        family[i] = malloc((size_t)n * sizeof **family);
        must(MEDmeshElementConnectivityRd(file[i], MESH, MED_NO_DT, MED_NO_IT, MED_CELL, type,
                                          MED_NODAL, MED_FULL_INTERLACE, list[i]));
        must(MEDmeshEntityFamilyNumberRd(file[i], MESH, MED_NO_DT, MED_NO_IT, MED_CELL, type,
                                         family[i]));
    }
    return memcmp(list[0], list[1], (size_t)(n * nodes) * sizeof **list) == 0 &&
           memcmp(family[0], family[1], (size_t)n * sizeof **family) == 0;
}

static int compare_files(char **path) {
    med_idt file[2];
    double *xyz[2];
    int different = 0;
    for (int i = 0; i < 2; i++) {
        file[i] = MEDfileOpen(path[i], MED_ACC_RDONLY);
        must(file[i] < 0 ? -1 : 0);
    }
    const med_int n = count(file[0], MED_NODE, MED_NONE, MED_COORDINATE);
    if (n < 1 || n != count(file[1], MED_NODE, MED_NONE, MED_COORDINATE) ||
        MEDnFamily(file[0], MESH) != 6 || MEDnFamily(file[1], MESH) != 6 ||
        !same_elements(file, MED_TETRA4, 4) || !same_elements(file, MED_TRIA3, 3))
        return 1;
    for (int i = 0; i < 2; i++) {
        xyz[i] = malloc((size_t)n * 3 * sizeof **xyz);
        must(MEDmeshNodeCoordinateRd(file[i], MESH, MED_NO_DT, MED_NO_IT, MED_FULL_INTERLACE,
                                     xyz[i]));
    }
    for (med_int i = 0; i < 3 * n; i++)
        different += xyz[0][i] != xyz[1][i];
    printf("%d\n", different);
    return 0;
}

int main(int n, char **argument) {
    if (n == 4 && strcmp(argument[1], "write") == 0)
        return write_file(argument + 2);
    return n == 4 ? compare_files(argument + 2) : 2;
}
