/* drawn_inside: what a picture shows of the inside of a solid mesh. */
#include "report/drawn_inside.h"

#include "geometry/cell.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/** Shape of an element, or NULL if it is not solid. */
static const pl_cell_shape *shape_of(const pl_job *job, int64_t element) {
    const planish_cells *cells = job->mesh.cells;
    const pl_cell_type *type =
        pl_cell_type_of(cells ? cells->type[element] : PLANISH_CELL_TETRAHEDRON);
    return type && type->shape->dim == 3 ? type->shape : NULL;
}

/* ---- elements ------------------------------------------------------------------------------- */

/** Number the nodes of the elements as points, in the order in which they come. point [n_nodes]:
 *  scratch. */
static void number_points(const pl_job *job, pl_drawn_inside *inside, int32_t *point) {
    for (int64_t i = 0; i < job->mesh.n_nodes; i++)
        point[i] = -1;
    for (int64_t i = 0; i < inside->n; i++) {
        int n;
        const int32_t *node = pl_job_corners(job, inside->element[i], &n);
        inside->size[i] = (uint8_t)n;
        for (int k = 0; k < n; k++) {
            if (point[node[k]] < 0) {
                point[node[k]] = (int32_t)inside->n_points;
                inside->node[inside->n_points++] = node[k];
            }
            inside->corner[inside->n_corners++] = point[node[k]];
        }
    }
}

int pl_drawn_inside_find(const pl_job *job, int64_t most, int64_t few, pl_drawn_inside *inside) {
    int64_t n_solid = 0, at = 0;
    for (int64_t i = 0; i < job->mesh.n_elements; i++)
        n_solid += shape_of(job, i) != NULL;
    *inside = (pl_drawn_inside){.stride = n_solid > most ? (n_solid + few - 1) / few : 1};
    const size_t n = (size_t)((n_solid + inside->stride - 1) / inside->stride);
    const size_t n_corners = n * PL_CELL_CORNERS;
    int32_t *point = malloc(((size_t)job->mesh.n_nodes + 1) * sizeof *point);
    inside->element = malloc((n + 1) * sizeof *inside->element);
    inside->size = malloc(n + 1);
    inside->corner = malloc((n_corners + 1) * sizeof *inside->corner);
    inside->node = malloc((n_corners + 1) * sizeof *inside->node);
    const int failed =
        !point || !inside->element || !inside->size || !inside->corner || !inside->node;
    for (int64_t i = 0; i < job->mesh.n_elements && !failed; i++)
        if (shape_of(job, i) && at++ % inside->stride == 0)
            inside->element[inside->n++] = (int32_t)i;
    if (!failed)
        number_points(job, inside, point);
    free(point);
    return failed ? pl_job_complain_memory(job, "the picture") : 0;
}

void pl_drawn_inside_free(pl_drawn_inside *inside) {
    free(inside->element);
    free(inside->size);
    free(inside->corner);
    free(inside->node);
    *inside = (pl_drawn_inside){0};
}

/* ---- the grid ------------------------------------------------------------------------------- */

pl_drawn_grid pl_drawn_grid_find(const double *low, const double *high, int64_t most) {
    pl_drawn_grid grid = {.n_cells = 1};
    double volume = 1, longest = 0;
    for (int d = 0; d < 3; d++)
        longest = fmax(longest, high[d] - low[d]);
    for (int d = 0; d < 3; d++) /* a flat box has one layer of cubes */
        volume *= fmax(high[d] - low[d], longest / 100) / longest;
    grid.size = longest * cbrt(volume / (double)most);
    for (int d = 0; d < 3; d++) {
        grid.low[d] = low[d];
        grid.n[d] = (int32_t)fmax(1, ceil((high[d] - low[d]) / grid.size - 0.5));
        grid.n_cells *= grid.n[d];
    }
    return grid;
}

/** Cube along axis d that coordinate x is in. */
static int cube_at(const pl_drawn_grid *grid, int d, double x) {
    return (int)fmin(fmax(floor((x - grid->low[d]) / grid->size), 0), grid->n[d] - 1);
}

/** An element by its corners. */
typedef struct solid {
    const pl_cell_shape *shape;
    const double *corner[PL_CELL_CORNERS];
    double middle[3], low[3], high[3];
} solid;

static solid solid_at(const pl_job *job, const pl_cell_shape *shape, int64_t element) {
    solid s = {.shape = shape};
    int n;
    const int32_t *node = pl_job_corners(job, element, &n);
    for (int d = 0; d < 3; d++) {
        s.low[d] = INFINITY;
        s.high[d] = -INFINITY;
    }
    for (int k = 0; k < n; k++) {
        s.corner[k] = job->mesh.coordinates + 3 * (int64_t)node[k];
        for (int d = 0; d < 3; d++) {
            s.middle[d] += s.corner[k][d] / n;
            s.low[d] = fmin(s.low[d], s.corner[k][d]);
            s.high[d] = fmax(s.high[d], s.corner[k][d]);
        }
    }
    return s;
}

/** Whether place is on the same side of every facet as the middle is. */
static int contains(const solid *s, const double *place) {
    for (int f = 0; f < s->shape->n_facets; f++) {
        const int8_t *at = s->shape->facet[f];
        const double *a = s->corner[at[0]], *b = s->corner[at[1]], *c = s->corner[at[2]];
        double u[3], v[3], of_place = 0, of_middle = 0;
        for (int d = 0; d < 3; d++) {
            u[d] = b[d] - a[d];
            v[d] = c[d] - a[d];
        }
        const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                             u[0] * v[1] - u[1] * v[0]};
        for (int d = 0; d < 3; d++) {
            of_place += n[d] * (place[d] - a[d]);
            of_middle += n[d] * (s->middle[d] - a[d]);
        }
        if (of_place * of_middle < 0)
            return 0;
    }
    return 1;
}

/** Give a cube the codes of an element where these are worse. */
static void take_worse(const pl_drawn_grid *grid, const pl_drawn_values *values, int64_t element,
                       int64_t cube, uint8_t *code) {
    for (int m = 0; m < values->n_measures; m++) {
        const uint8_t of_element = values->code[m * values->n + element];
        uint8_t *of_cube = code + m * grid->n_cells + cube;
        if (pl_drawn_worse(values->measure[m], of_element, *of_cube))
            *of_cube = of_element;
    }
}

void pl_drawn_grid_take(const pl_drawn_grid *grid, const pl_job *job, const pl_drawn_values *values,
                        uint8_t *code) {
    /* Elements of a tangled mesh may be as large as all of it: these are in the cube of their middle alone
     * once so many cubes have been looked at. */
    int64_t cubes_left = 20000000;
    memset(code, PL_DRAWN_NOTHING, (size_t)(values->n_measures * grid->n_cells));
    for (int64_t i = 0; i < job->mesh.n_elements; i++) {
        const pl_cell_shape *shape = shape_of(job, i);
        if (!shape)
            continue;
        const solid s = solid_at(job, shape, i);
        int from[3], to[3], own[3], k[3];
        int64_t n_cubes = 1;
        for (int d = 0; d < 3; d++) {
            from[d] = cube_at(grid, d, s.low[d]);
            to[d] = cube_at(grid, d, s.high[d]);
            own[d] = cube_at(grid, d, s.middle[d]);
            n_cubes *= to[d] - from[d] + 1;
        }
        cubes_left -= n_cubes;
        for (int d = 0; d < 3 && cubes_left < 0; d++)
            from[d] = to[d] = own[d];
        for (k[2] = from[2]; k[2] <= to[2]; k[2]++)
            for (k[1] = from[1]; k[1] <= to[1]; k[1]++)
                for (k[0] = from[0]; k[0] <= to[0]; k[0]++) {
                    double place[3];
                    for (int d = 0; d < 3; d++)
                        place[d] = grid->low[d] + (k[d] + 0.5) * grid->size;
                    if (memcmp(k, own, sizeof k) == 0 || contains(&s, place))
                        take_worse(grid, values, i,
                                   ((int64_t)k[2] * grid->n[1] + k[1]) * grid->n[0] + k[0], code);
                }
    }
}
