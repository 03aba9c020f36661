/* lattice: grids over a mesh; elements and nodes by their simplices. */
#include "improve/lattice_places.h"

#include "base/memory.h"
#include "geometry/simplex.h"
#include "plan/ghosts.h"

#include <string.h>

enum { CHUNK = 1024 };

/* ---- which grids ----------------------------------------------------------------------------- */

/* Most vertices of the finest grid per star, which bounds memory; and in all, as each process has all
 * vertices: they take a gigabyte. */
#define VERTICES_PER_STAR 0.25
#define VERTICES_MOST     0x1p20
/* A grid suits elements whose nodes are this part of its spacing apart, or less. */
#define LARGEST_EDGE 0.8
enum { COARSEST = 4 };

/** Six times the volume of an element, or twice its area, in units. */
PL_INLINE double determinant_of(const pl_lattice *l, int64_t element, int dim) {
    const double *x[PL_CORNERS];
    double e[3][3] = {{0}};
    for (int j = 0; j <= dim; j++)
        x[j] = l->plan->scratch.coordinates + (int64_t)pl_plan_inner(l->plan, element, j) * dim;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = (x[j + 1][d] - x[0][d]) * l->per_unit;
    return fabs(pl_determinant_of_edges(dim, e));
}

/** Lengths of the edges at stars under way. */
typedef struct edge_pass {
    const planish_plan *plan;
    pl_sum sum[4]; /* of their lengths, and of their widths along each direction */
} edge_pass;

static void edge_chunk(void *context, int64_t begin, int64_t end, int thread) {
    edge_pass *p = context;
    const pl_stars *stars = &p->plan->interior.stars;
    const double *x = p->plan->scratch.coordinates;
    const int dim = p->plan->dim;
    pl_sum sum[4] = {{{0}, 0, 0, 0, 0}};
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const double *centre = x + p->plan->interior.centre[i] * (int64_t)dim;
        double of_star[4] = {0};
        for (int64_t k = stars->ring_offset[i]; k < stars->ring_offset[i + 1]; k++) {
            const double *other = x + stars->ring[k] * (int64_t)dim;
            of_star[0] += pl_distance(dim, centre, other);
            for (int d = 0; d < dim; d++)
                of_star[d + 1] += fabs(other[d] - centre[d]);
        }
        for (int d = 0; d <= dim; d++)
            pl_sum_add(&sum[d], of_star[d]);
    }
    for (int d = 0; d <= dim; d++)
        pl_sum_merge(&p->sum[d], &sum[d]);
}

/** Mean length of edges at the stars of all processes; 0 if there are none. width [3]: sums of their
 *  widths along each direction. */
static double edge_length(const planish_plan *plan, double width[3]) {
    const pl_stars *stars = &plan->interior.stars;
    edge_pass pass = {.plan = plan};
    int64_t n = stars->ring_offset[stars->n_stars];
    pl_parallel_for(plan->threads, stars->n_stars, CHUNK, edge_chunk, &pass);
    pl_parts_add_sums(pass.sum, 4);
    pl_parts_add(&n, 1);
    for (int d = 0; d < 3; d++)
        width[d] = pl_sum_value(&pass.sum[d + 1]);
    return n > 0 ? pl_sum_value(&pass.sum[0]) / (double)n : 0;
}

/* Least part that the spacing along one direction is of that along another. */
#define PART_LEAST 0x1p-6

/** Set part [3] to what the spacing along each direction is of the largest one. In the plane, edges
 *  may be less than half as wide along one direction as along the other; then so is the spacing, by a
 *  power of two. In space all are 1. */
static void find_parts(int dim, const double width[3], double part[3]) {
    const double most = fmax(width[0], width[1]);
    for (int d = 0; d < 3; d++)
        part[d] = 1;
    for (int d = 0; d < 2 && dim == 2; d++)
        while (part[d] * most > 2 * width[d] && part[d] > PART_LEAST)
            part[d] /= 2;
}

/** Set the numbers of vertices of all grids, the finest of spacing, of which each direction has its
 *  part; returns those of the finest. */
static double size_grids(pl_lattice *l, const double extent[3], double spacing,
                         const double part[3]) {
    const int dim = l->plan->dim == 3 ? 3 : 2;
    double vertices = 1;
    int64_t n[3] = {1, 1, 1}, most = 0;
    l->spacing = spacing;
    for (int d = 0; d < dim; d++) {
        const double cells = extent[d] / (spacing * part[d]) + 1;
        vertices *= cells + 1;
        n[d] = cells < 1e9 ? (int64_t)cells + 2 : 1000000000;
        most = n[d] > most ? n[d] : most;
    }
    l->n_levels = 0;
    for (double per = 1; l->n_levels < PL_LATTICE_LEVELS; per /= 2) {
        pl_grid *g = &l->grid[l->n_levels++];
        memcpy(g->n, n, sizeof n);
        for (int d = 0; d < 3; d++)
            g->per_spacing[d] = per / part[d];
        if (most <= COARSEST)
            break;
        most = 0;
        for (int d = 0; d < 3; d++) {
            n[d] = n[d] / 2 + 1; /* of 1: 1 */
            most = n[d] > most ? n[d] : most;
        }
    }
    return vertices;
}

/** Let box {upper, -lower} have the nodes at stars. */
static void widen_box(const planish_plan *plan, const pl_stars *stars, double box[6]) {
    const int dim = plan->dim;
    for (int64_t k = 0; k < stars->ring_offset[stars->n_stars]; k++)
        for (int d = 0; d < dim; d++) {
            const double x = plan->scratch.coordinates[stars->ring[k] * (int64_t)dim + d];
            box[d] = x > box[d] ? x : box[d];
            box[d + 3] = -x > box[d + 3] ? -x : box[d + 3];
        }
}

/** Set box to {upper, -lower} coordinates of the nodes at stars, in all processes; in the plane the
 *  third ones are 0. */
static void find_box(const planish_plan *plan, int slides, double box[6]) {
    for (int d = 0; d < 6; d++)
        box[d] = d % 3 < plan->dim ? -INFINITY : 0;
    widen_box(plan, &plan->interior.stars, box);
    if (slides)
        widen_box(plan, &plan->sliding.stars, box);
    pl_parts_largest(box, 6);
}

static int place_grids(pl_lattice *l, double spacing, int slides) {
    const double per_star = VERTICES_PER_STAR * (double)l->n_moving + 64;
    const double most = per_star < VERTICES_MOST ? per_star : VERTICES_MOST;
    double box[6], extent[3], width[3], part[3];
    find_box(l->plan, slides, box);
    spacing *= edge_length(l->plan, width);
    find_parts(l->plan->dim, width, part);
    for (int d = 0; d < 3; d++)
        extent[d] = box[d] + box[d + 3];
    if (!(spacing > 0) || !(spacing < INFINITY) ||
        !(fmin(extent[0], fmin(extent[1], extent[2])) >= 0) ||
        !(extent[0] + extent[1] + extent[2] < INFINITY))
        return 0;
    while (size_grids(l, extent, spacing, part) > most)
        spacing *= 1.25;
    for (int d = 0; d < 3; d++)
        l->origin[d] = -box[d + 3] - 0.5 * spacing * part[d];
    l->per_unit = 1 / spacing;
    return 1;
}

/** Elements under way. */
typedef struct element_pass {
    pl_lattice *l;
    double *largest; /* [vertices of the finest grid] determinant of those in the cube, in units */
    int32_t *simplex_of; /* [n] of elements or stars; -1: none */
    int64_t *count;      /* [n_simplices] */
    int32_t *of;         /* elements, or stars, by simplices */
    int64_t n;
} element_pass;

/** Middle of an element in units; 0 if it has no free node, or another process counts it; above
 *  PL_LATTICE_FREE if one of its nodes slides. */
PL_INLINE int middle_of(const pl_lattice *l, int64_t element, double *x, int dim) {
    const uint8_t *is_counted = l->plan->work.is_counted;
    int freedom = 0;
    double node[3];
    for (int d = 0; d < dim; d++)
        x[d] = 0;
    for (int j = 0; j <= dim; j++) {
        const int32_t inner = pl_plan_inner(l->plan, element, j);
        freedom |= l->freedom[inner];
        pl_unit_place(l, inner, node, dim);
        for (int d = 0; d < dim; d++)
            x[d] += node[d] * (1.0 / (dim + 1));
    }
    return !is_counted || is_counted[element] ? freedom : PL_LATTICE_HELD;
}

/** Whether an element is in the Hessian, by the bits of its middle: a choice that no order of the
 *  elements and no process changes. Those with a node that slides are: some such nodes have only a
 *  few. */
PL_INLINE int is_chosen(const pl_lattice *l, int freedom, const double *middle, int dim) {
    uint64_t mix = 0;
    if (freedom > PL_LATTICE_FREE)
        return 1;
    for (int d = 0; d < dim; d++) {
        uint64_t bits;
        memcpy(&bits, &middle[d], sizeof bits);
        mix = (mix ^ bits) * 0x9E3779B97F4A7C15u;
        mix ^= mix >> 32;
    }
    return mix % (uint64_t)l->one_in == 0;
}

enum { AHEAD = 12 };

/** Ask for the nodes of an element that will be looked at soon. */
PL_INLINE void fetch_element(const pl_lattice *l, int64_t element, int dim) {
    for (int j = 0; j <= dim; j++)
        __builtin_prefetch(l->plan->scratch.coordinates +
                           (int64_t)pl_plan_inner(l->plan, element, j) * dim);
}

PL_INLINE void find_largest(const element_pass *p, int64_t begin, int64_t end, int dim) {
    const pl_lattice *l = p->l;
    double x[3];
    for (int64_t i = begin; i < end; i++) {
        if (i + AHEAD < l->plan->work.n_elements)
            fetch_element(l, i + AHEAD, dim);
        p->simplex_of[i] = -1;
        const int freedom = middle_of(l, i, x, dim);
        if (freedom == PL_LATTICE_HELD)
            continue;
        const pl_cube_place place = pl_cube_at(&l->grid[0], x, dim);
        const double largest = determinant_of(l, i, dim);
        if (largest > p->largest[place.vertex]) /* seldom, and then for sure */
            pl_raise_double(&p->largest[place.vertex], largest);
        if (is_chosen(l, freedom, x, dim))
            p->simplex_of[i] =
                (int32_t)(place.vertex * pl_simplices_of(dim) + pl_find_order(place.along, dim));
    }
}

static void largest_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    (void)thread;
    if (p->l->plan->dim == 3)
        find_largest(p, begin, end, 3);
    else
        find_largest(p, begin, end, 2);
}

/** Set values [n] to the largest of the processes. */
static void find_largest_of_parts(double *values, int64_t n) {
    enum { AT_ONCE = 64 };
    if (!pl_part_here())
        return;
    for (int64_t i = 0; i < n; i += AT_ONCE)
        pl_parts_largest(values + i, (int)(n - i < AT_ONCE ? n - i : AT_ONCE));
}

/** Set which vertices are active, from the largest element in each cube; then largest is that of the
 *  next grid. */
static void activate(const pl_lattice *l, int level, double *largest) {
    const pl_grid *g = &l->grid[level];
    const int is_last = level == l->n_levels - 1, n_cubes = 1 << l->plan->dim; /* at a vertex */
    double limit = 1;
    for (int d = 0; d < l->plan->dim; d++)
        limit *= LARGEST_EDGE / g->per_spacing[d];
    for (int64_t v = 0; v < g->n_vertices; v++) {
        int64_t at[3];
        double most = 0;
        pl_find_coordinates(g, v, at);
        for (int bits = 0; bits < n_cubes; bits++) {
            const int64_t cube = pl_vertex_by(g, at, bits, -1).number;
            if (cube >= 0)
                most = fmax(most, largest[cube]);
        }
        g->is_active[v] = most > 0 && (is_last || most <= limit);
    }
    if (is_last)
        return;
    const pl_grid *next = g + 1;
    for (int64_t v = 0; v < next->n_vertices; v++) {
        int64_t twice[3];
        double most = 0;
        pl_find_coordinates(next, v, twice);
        for (int d = 0; d < 3; d++)
            twice[d] *= 2;
        for (int bits = 0; bits < n_cubes; bits++) {
            const int64_t fine = pl_vertex_by(g, twice, bits, 1).number;
            if (fine >= 0)
                most = fmax(most, largest[fine]);
        }
        largest[v] = most; /* of cubes further on: those before are not needed any more */
    }
}

/** Allocate the arrays of a grid whose n is set. Returns 0 without memory. */
static int allocate_grid(pl_grid *g, int dim) {
    const int64_t n = g->n_vertices;
    double **fields[] = {&g->force,     &g->move,   &g->residual, &g->load,
                         &g->direction, &g->change, &g->total};
    int ready = 1;
    for (size_t i = 0; i < sizeof fields / sizeof *fields; i++) {
        *fields[i] = pl_alloc_zero(n * dim, sizeof(double));
        ready = ready && *fields[i];
    }
    g->stiffness = pl_alloc((n << dim) * dim * dim, sizeof(double));
    g->inverse = pl_alloc(n * dim * dim, sizeof(double));
    g->is_active = pl_alloc_zero(n, 1);
    return ready && g->stiffness && g->inverse && g->is_active;
}

/** Allocate the lattice for grids whose sizes are known. Returns 0 without memory. */
static int allocate(pl_lattice *l, int slides) {
    const int64_t m = l->plan->work.n_elements, n_nodes = l->plan->work.n_nodes;
    const int dim = l->plan->dim;
    int ready = 1;
    for (int i = 0; i < l->n_levels; i++) {
        pl_grid *g = &l->grid[i];
        g->n_slabs = g->n[dim - 1];
        g->per_slab = pl_stride_of(g, dim - 1);
        g->n_vertices = g->per_slab * g->n_slabs;
        g->first = l->n_simplices;
        l->n_simplices += g->n_vertices * pl_simplices_of(dim);
        ready = allocate_grid(g, dim) && ready;
    }
    l->freedom = pl_alloc_zero(n_nodes, 1);
    if (slides)
        l->direction = pl_alloc_zero(n_nodes * dim, sizeof(double));
    l->simplex_of = pl_alloc(l->n_stars, sizeof(int32_t));
    l->element = pl_alloc(m, sizeof(int32_t));
    l->corner = pl_alloc(m * (dim + 1), sizeof(int32_t));
    l->of_slab = pl_alloc(l->grid[0].n_slabs, sizeof(double));
    l->element_begin = pl_alloc(l->n_simplices + 1, sizeof(int64_t));
    l->star = pl_alloc(l->n_stars, sizeof(int32_t));
    l->star_begin = pl_alloc(l->n_simplices + 1, sizeof(int64_t));
    return ready && l->freedom && (l->direction || !slides) && l->corner && l->of_slab &&
           l->simplex_of && l->element && l->element_begin && l->star && l->star_begin;
}

/** Set where nodes may go, in all processes. */
static void find_freedom(pl_lattice *l, int slides, const uint8_t *stays) {
    const planish_plan *plan = l->plan;
    const size_t size = (size_t)plan->dim * sizeof(double);
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        l->freedom[plan->inner[i]] =
            plan->work.mobility[i] == PL_INTERIOR && !(stays && stays[plan->inner[i]])
                ? PL_LATTICE_FREE
                : PL_LATTICE_HELD;
    for (int64_t s = 0; slides && s < plan->sliding.stars.n_stars; s++) {
        const int64_t node = plan->sliding.centre[s];
        if (plan->slides_by[s] != PLANISH_CONSTRAINT_ON_PLANE &&
            plan->slides_by[s] != PLANISH_CONSTRAINT_ON_LINE)
            continue;
        l->freedom[node] = plan->slides_by[s];
        memcpy(l->direction + node * plan->dim, plan->slide[s].direction, size);
    }
    pl_ghosts_update(plan, l->freedom, sizeof *l->freedom);
    if (slides)
        pl_ghosts_update(plan, l->direction, (int64_t)size);
}

int pl_lattice_create(const planish_plan *plan, double spacing, int one_in, int slides,
                      const uint8_t *stays, pl_lattice *l) {
    const pl_visits *interior = &plan->interior, *sliding = &plan->sliding;
    *l = (pl_lattice){.plan = plan,
                      .one_in = one_in,
                      .n_stars = interior->stars.n_stars + (slides ? sliding->stars.n_stars : 0),
                      .n_moving = interior->n_all + (slides ? sliding->n_all : 0)};
    if (!place_grids(l, spacing, slides))
        return 0;
    int ready = allocate(l, slides);
    double *largest = pl_alloc_zero(l->grid[0].n_vertices, sizeof *largest);
    ready = ready && largest && l->n_simplices < INT32_MAX;
    ready = !pl_parts_any(!ready) && ready; /* if the others are not reached, too */
    if (ready) {
        element_pass pass = {.l = l, .largest = largest, .simplex_of = l->corner};
        find_freedom(l, slides, stays);
        pl_parallel_for(plan->threads, plan->work.n_elements, CHUNK, largest_chunk, &pass);
        find_largest_of_parts(largest, l->grid[0].n_vertices);
        for (int i = 0; i < l->n_levels; i++)
            activate(l, i, largest);
        l->is_known = 1;
    }
    pl_free(largest);
    return ready;
}

void pl_lattice_destroy(pl_lattice *l) {
    for (int i = 0; i < l->n_levels; i++) {
        pl_grid *g = &l->grid[i];
        void *arrays[] = {g->stiffness, g->inverse, g->force, g->move, g->residual,
                          g->direction, g->change,  g->total, g->load, g->is_active};
        for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
            pl_free(arrays[k]);
    }
    pl_free(l->freedom);
    pl_free(l->direction);
    pl_free(l->simplex_of);
    pl_free(l->element);
    pl_free(l->corner);
    pl_free(l->of_slab);
    pl_free(l->element_begin);
    pl_free(l->star);
    pl_free(l->star_begin);
}

/* ---- elements and nodes by simplices --------------------------------------------------------- */

/** Whether a vertex of a simplex is active. */
PL_INLINE int is_simplex_active(const pl_grid *g, int64_t number, int dim) {
    int64_t vertex = (number - g->first) / pl_simplices_of(dim);
    const int *way = PL_ORDERS[(number - g->first) % pl_simplices_of(dim)];
    int active = g->is_active[vertex];
    for (int d = 0; d < dim; d++)
        active |= g->is_active[vertex += pl_stride_of(g, way[d])];
    return active;
}

PL_INLINE void find_simplices(const element_pass *p, int64_t begin, int64_t end, int dim) {
    const pl_lattice *l = p->l;
    double x[3];
    for (int64_t i = begin; i < end; i++) {
        int64_t of = l->is_known ? p->simplex_of[i] : -1;
        if (!l->is_known && i + AHEAD < p->n)
            fetch_element(l, i + AHEAD, dim);
        if (!l->is_known || (of >= 0 && !is_simplex_active(&l->grid[0], of, dim))) {
            const int freedom = middle_of(l, i, x, dim);
            of = freedom != PL_LATTICE_HELD && is_chosen(l, freedom, x, dim)
                     ? pl_simplex_at(l, x, dim)
                     : -1;
        }
        p->simplex_of[i] = (int32_t)of;
        if (of >= 0)
            __atomic_fetch_add(&p->count[of], 1, __ATOMIC_RELAXED);
    }
}

static void element_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    (void)thread;
    if (p->l->plan->dim == 3)
        find_simplices(p, begin, end, 3);
    else
        find_simplices(p, begin, end, 2);
}

/** Number of the simplex of a star's node. */
PL_INLINE int64_t simplex_of_star(const pl_lattice *l, int64_t star, int dim) {
    double x[3];
    pl_unit_place(l, pl_lattice_node(l, star), x, dim);
    return pl_simplex_at(l, x, dim);
}

static void star_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    const pl_lattice *l = p->l;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t of = l->plan->dim == 3 ? simplex_of_star(l, i, 3) : simplex_of_star(l, i, 2);
        p->simplex_of[i] = (int32_t)of;
        __atomic_fetch_add(&p->count[of], 1, __ATOMIC_RELAXED);
    }
}

/** Put each to its simplex, both from the end backwards: neighbours in memory stay neighbours. */
static void put_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    (void)thread;
    for (int64_t k = begin; k < end; k++) {
        const int64_t i = p->n - 1 - k;
        const int32_t of = p->simplex_of[i];
        if (of >= 0)
            p->of[__atomic_sub_fetch(&p->count[of], 1, __ATOMIC_RELAXED)] = (int32_t)i;
    }
}

/** Sort n elements or stars, whose simplices chunk finds, to array of; begin [n_simplices + 1]. */
static void sort_by_simplices(pl_lattice *l, pl_chunk_fn *chunk, int32_t *simplex_of, int64_t n,
                              int32_t *of, int64_t *begin) {
    const int threads = l->plan->threads;
    element_pass pass = {.l = l, .count = begin, .simplex_of = simplex_of, .of = of, .n = n};
    memset(begin, 0, (size_t)(l->n_simplices + 1) * sizeof *begin);
    pl_parallel_for(threads, n, CHUNK, chunk, &pass);
    /* Where each simplex ends; where it begins, when all are put. */
    int64_t sum = 0;
    for (int64_t i = 0; i <= l->n_simplices; i++)
        begin[i] = sum += begin[i];
    pl_parallel_for(threads, n, CHUNK, put_chunk, &pass);
}

/** Note the nodes of elements that are in order. */
static void corner_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_lattice *l = context;
    const int32_t *elements = l->plan->work.elements;
    const int n = l->plan->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (i + 32 < end)
            __builtin_prefetch(elements + (int64_t)l->element[i + 32] * n);
        if (i + 16 < end)
            for (int j = 0; j < n; j++)
                __builtin_prefetch(l->plan->inner + elements[(int64_t)l->element[i + 16] * n + j]);
        for (int j = 0; j < n; j++)
            l->corner[i * n + j] = pl_plan_inner(l->plan, l->element[i], j);
    }
}

/** Set which grids have elements or nodes, in any process. */
static void find_owners(pl_lattice *l) {
    int64_t n[PL_LATTICE_LEVELS] = {0};
    for (int i = 0; i < l->n_levels; i++) {
        const int64_t first = l->grid[i].first;
        const int64_t end = first + l->grid[i].n_vertices * pl_simplices_of(l->plan->dim);
        n[i] = l->element_begin[end] - l->element_begin[first];
        n[i] += l->star_begin[end] - l->star_begin[first];
    }
    pl_parts_add(n, l->n_levels);
    for (int i = 0; i < l->n_levels; i++)
        l->grid[i].has_own = n[i] > 0;
}

void pl_lattice_sort(pl_lattice *l) {
    const int64_t m = l->plan->work.n_elements;
    sort_by_simplices(l, element_chunk, l->corner, m, l->element, l->element_begin);
    l->n_terms = l->element_begin[l->n_simplices];
    pl_parallel_for(l->plan->threads, l->n_terms, CHUNK, corner_chunk, l);
    l->is_known = 0;
    sort_by_simplices(l, star_chunk, l->simplex_of, l->n_stars, l->star, l->star_begin);
    pl_parts_add(&l->n_terms, 1);
    find_owners(l);
}
