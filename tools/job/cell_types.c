/* cell_types: names, dimensions and corners of the types of elements. */
#include "job/cell_types.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/** Names of a type, in tables, and of one and several elements in sentences; and how it is
 *  smoothed. */
typedef struct type_name {
    planish_cell_type type;
    const char *name, *one, *many;
    int dim, n_corners;
    int is_smoothed_type; /* smoothed, and no simplex */
} type_name;

/* In the order of tables and sentences. Quadratic pyramids are held. */
static const type_name names[] = {
    {PLANISH_CELL_TETRAHEDRON, "tetrahedron", "tetrahedron", "tetrahedra", 3, 4, 0},
    {PLANISH_CELL_TETRAHEDRON10, "tetrahedron10", "quadratic tetrahedron", "quadratic tetrahedra",
     3, 4, 0},
    {PLANISH_CELL_HEXAHEDRON, "hexahedron", "hexahedron", "hexahedra", 3, 8, 1},
    {PLANISH_CELL_HEXAHEDRON20, "hexahedron20", "quadratic hexahedron", "quadratic hexahedra", 3, 8,
     1},
    {PLANISH_CELL_HEXAHEDRON27, "hexahedron27", "triquadratic hexahedron", "triquadratic hexahedra",
     3, 8, 1},
    {PLANISH_CELL_WEDGE, "wedge", "wedge", "wedges", 3, 6, 1},
    {PLANISH_CELL_WEDGE15, "wedge15", "quadratic wedge", "quadratic wedges", 3, 6, 1},
    {PLANISH_CELL_WEDGE18, "wedge18", "biquadratic wedge", "biquadratic wedges", 3, 6, 1},
    {PLANISH_CELL_PYRAMID, "pyramid", "pyramid", "pyramids", 3, 5, 1},
    {PLANISH_CELL_PYRAMID13, "pyramid13", "quadratic pyramid", "quadratic pyramids", 3, 5, 0},
    {PLANISH_CELL_PYRAMID14, "pyramid14", "biquadratic pyramid", "biquadratic pyramids", 3, 5, 0},
    {PLANISH_CELL_TRIANGLE, "triangle", "triangle", "triangles", 2, 3, 0},
    {PLANISH_CELL_TRIANGLE6, "triangle6", "quadratic triangle", "quadratic triangles", 2, 3, 0},
    {PLANISH_CELL_QUADRILATERAL, "quadrilateral", "quadrilateral", "quadrilaterals", 2, 4, 1},
    {PLANISH_CELL_QUADRILATERAL8, "quadrilateral8", "quadratic quadrilateral",
     "quadratic quadrilaterals", 2, 4, 1},
    {PLANISH_CELL_QUADRILATERAL9, "quadrilateral9", "biquadratic quadrilateral",
     "biquadratic quadrilaterals", 2, 4, 1},
};

enum { N_NAMES = sizeof names / sizeof *names };

static const type_name *name_of(planish_cell_type type) {
    static const type_name unknown = {
        PLANISH_CELL_VERTEX, "element", "element", "elements", 0, 0, 0};
    for (int i = 0; i < N_NAMES; i++)
        if (names[i].type == type)
            return &names[i];
    return &unknown;
}

int pl_cell_corners(planish_cell_type type) {
    return name_of(type)->n_corners;
}

int pl_cell_is_simplex(planish_cell_type type) {
    const type_name *name = name_of(type);
    return name->dim > 0 && name->n_corners == name->dim + 1;
}

int pl_cells_have_types(const planish_cells *cells, int dim) {
    for (int64_t i = 0; i < cells->n; i++) {
        const type_name *name = name_of((planish_cell_type)cells->type[i]);
        if (name->is_smoothed_type && name->dim == dim)
            return 1;
    }
    return 0;
}

int pl_cells_are_flat(const planish_cells *cells) {
    for (int64_t i = 0; i < cells->n; i++)
        if (name_of((planish_cell_type)cells->type[i])->dim != 2)
            return 0;
    return 1;
}

const char *pl_cell_type_name(planish_cell_type type) {
    return name_of(type)->name;
}

void pl_cell_type_count(planish_cell_type type, int64_t n, char *text, size_t size) {
    const type_name *name = name_of(type);
    snprintf(text, size, "%" PRId64 " %s", n, n == 1 ? name->one : name->many);
}

void pl_cells_count(const planish_cells *cells, char *text, size_t size) {
    int64_t n[UINT8_MAX + 1] = {0};
    for (int64_t i = 0; i < cells->n; i++)
        n[cells->type[i]]++;
    text[0] = '\0';
    for (int i = 0; i < N_NAMES; i++) {
        const size_t used = strlen(text);
        if (n[names[i].type] == 0)
            continue;
        char part[64];
        pl_cell_type_count(names[i].type, n[names[i].type], part, sizeof part);
        snprintf(text + used, size - used, "%s%s", used ? ", " : "", part);
    }
}
