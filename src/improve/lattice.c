/* lattice: grids over a mesh; elements and nodes by their simplices. */
#include "improve/lattice_places.h"

#include "base/memory.h"
#include "geometry/simplex.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 1024 };

/* ---- which grids ----------------------------------------------------------------------------- */

/* Vertices of the finest grid for each star at most; stars without any would be too few for one. */
#define VERTICES_PER_STAR 0.5
/* A grid suits elements whose nodes are this part of its spacing apart, or less. */
#define LARGEST_EDGE 0.8
enum { SAMPLES = 4096, COARSEST = 4 };

/** Twice, or six times, the measure of an element, in units. */
static double determinant_of(const pl_lattice *l, int64_t element) {
    const planish_plan *plan = l->plan;
    const int dim = plan->dim;
    const double *x[PL_MAX_CORNERS];
    double e[3][3] = {{0}};
    for (int j = 0; j <= dim; j++)
        x[j] = plan->scratch.coordinates + (int64_t)pl_plan_inner(plan, element, j) * dim;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = (x[j + 1][d] - x[0][d]) * l->per_unit;
    return fabs(pl_determinant_of_edges(dim, e));
}

/** Mean length of edges at some of the stars. */
static double edge_length(const planish_plan *plan) {
    const pl_stars *stars = &plan->interior.stars;
    const int64_t step = stars->n_stars > SAMPLES ? stars->n_stars / SAMPLES : 1;
    const int dim = plan->dim;
    double mean = 0, n = 0;
    for (int64_t i = 0; i < stars->n_stars; i += step) {
        const double *x = plan->scratch.coordinates + plan->interior.centre[i] * (int64_t)dim;
        for (int64_t k = stars->ring_offset[i]; k < stars->ring_offset[i + 1]; k++, n++)
            mean += pl_distance(dim, x, plan->scratch.coordinates + stars->ring[k] * (int64_t)dim);
    }
    return n > 0 ? mean / n : 0;
}

/** Set the numbers of vertices of all grids, the finest of spacing; returns those of the finest. */
static double size_grids(pl_lattice *l, const double extent[3], double spacing) {
    double vertices = 1;
    int64_t n[3] = {1, 1, 1}, most = 0;
    l->spacing = spacing;
    for (int d = 0; d < l->dim; d++) {
        const double cells = extent[d] / spacing + 1;
        vertices *= cells + 1;
        n[d] = cells < 1e9 ? (int64_t)cells + 2 : 1000000000;
        most = n[d] > most ? n[d] : most;
    }
    l->n_levels = 0;
    for (double per = 1; l->n_levels < PL_LATTICE_LEVELS; per /= 2) {
        pl_grid *g = &l->grid[l->n_levels++];
        memcpy(g->n, n, sizeof n);
        g->per_spacing = per;
        if (most <= COARSEST)
            break;
        most = 0;
        for (int d = 0; d < l->dim; d++) {
            n[d] = n[d] / 2 + 1;
            most = n[d] > most ? n[d] : most;
        }
    }
    return vertices;
}

static int place_grids(pl_lattice *l, double spacing) {
    const planish_plan *plan = l->plan;
    const pl_stars *stars = &plan->interior.stars;
    const double most = VERTICES_PER_STAR * (double)plan->interior.stars.n_stars + 64;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    double extent[3] = {0};
    for (int64_t k = 0; k < stars->ring_offset[stars->n_stars]; k++)
        for (int d = 0; d < l->dim; d++) {
            const double x = plan->scratch.coordinates[stars->ring[k] * (int64_t)l->dim + d];
            lower[d] = x < lower[d] ? x : lower[d];
            upper[d] = x > upper[d] ? x : upper[d];
        }
    spacing *= edge_length(plan);
    for (int d = 0; d < l->dim; d++)
        extent[d] = upper[d] - lower[d];
    if (!(spacing > 0) || !(spacing < INFINITY))
        return 0;
    while (size_grids(l, extent, spacing) > most)
        spacing *= 1.25;
    for (int d = 0; d < l->dim; d++)
        l->origin[d] = lower[d] - 0.5 * spacing;
    l->per_unit = 1 / spacing;
    return 1;
}

/** Elements under way. */
typedef struct element_pass {
    pl_lattice *l;
    double *largest; /* [vertices of the finest grid] determinant of those in the cube, in units */
    int64_t *count;  /* [n_simplices] */
    int32_t *of;     /* elements, or stars, by simplices */
    int64_t n;
    int is_known; /* the simplices of the finest grid */
} element_pass;

/** Middle of an element in units; 0 if it has no free node. */
PL_INLINE int middle_of(const pl_lattice *l, int64_t element, double *x, const int dim) {
    int any = 0;
    double node[3];
    for (int d = 0; d < dim; d++)
        x[d] = 0;
    for (int j = 0; j <= dim; j++) {
        const int32_t inner = pl_plan_inner(l->plan, element, j);
        any |= l->is_free[inner];
        pl_unit_place(l, inner, node, dim);
        for (int d = 0; d < dim; d++)
            x[d] += node[d] * (1.0 / (dim + 1));
    }
    return any;
}

enum { AHEAD = 12 };

/** Ask for the nodes of an element that will be looked at soon. */
PL_INLINE void fetch_element(const pl_lattice *l, int64_t element, const int dim) {
    for (int j = 0; j <= dim; j++)
        __builtin_prefetch(l->plan->scratch.coordinates +
                           (int64_t)pl_plan_inner(l->plan, element, j) * dim);
}

static void largest_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    const pl_lattice *l = p->l;
    double x[3] = {0};
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (i + AHEAD < l->plan->work.n_elements)
            fetch_element(l, i + AHEAD, l->dim);
        const int any = l->dim == 3 ? middle_of(l, i, x, 3) : middle_of(l, i, x, 2);
        l->simplex_of[i] = -1;
        if (!any)
            continue;
        const pl_cube_place place =
            l->dim == 3 ? pl_cube_at(&l->grid[0], x, 3) : pl_cube_at(&l->grid[0], x, 2);
        const double largest = determinant_of(l, i);
        if (largest > p->largest[place.vertex]) /* seldom, and then for sure */
            pl_raise_double(&p->largest[place.vertex], largest);
        l->simplex_of[i] =
            (int32_t)(place.vertex * pl_orders_of(l->dim) + pl_find_order(place.along, l->dim));
    }
}

/** Set which vertices are active, from the largest element in each cube; then largest is that of the
 *  next grid. */
static void activate(const pl_lattice *l, int level, double *largest) {
    const pl_grid *g = &l->grid[level];
    const int is_last = level == l->n_levels - 1, corners = 1 << l->dim;
    double limit = 1;
    for (int d = 0; d < l->dim; d++)
        limit *= LARGEST_EDGE / g->per_spacing;
    for (int64_t v = 0; v < g->n_vertices; v++) {
        const int64_t at[3] = {v % g->n[0], v / g->n[0] % g->n[1], v / g->n[0] / g->n[1]};
        double most = 0;
        for (int bits = 0; bits < corners; bits++) {
            int inside = 1;
            for (int d = 0; d < l->dim; d++)
                inside &= (bits >> d & 1) == 0 || at[d] > 0;
            if (inside)
                most = fmax(most, largest[v - pl_offset_of(g, bits)]);
        }
        g->is_active[v] = most > 0 && (is_last || most <= limit);
    }
    if (is_last)
        return;
    const pl_grid *next = g + 1;
    for (int64_t v = 0; v < next->n_vertices; v++) {
        const int64_t at[3] = {v % next->n[0], v / next->n[0] % next->n[1],
                               v / next->n[0] / next->n[1]};
        double most = 0;
        for (int bits = 0; bits < corners; bits++) {
            int64_t fine = 0;
            int inside = 1;
            for (int d = 0; d < l->dim; d++) {
                const int64_t i = 2 * at[d] + (bits >> d & 1);
                inside &= i < g->n[d];
                fine += i * pl_stride_of(g, d);
            }
            if (inside)
                most = fmax(most, largest[fine]);
        }
        largest[v] = most; /* of cubes further on: those before are not needed any more */
    }
}

int pl_lattice_create(const planish_plan *plan, double spacing, pl_lattice *l) {
    const int64_t m = plan->work.n_elements, n_stars = plan->interior.stars.n_stars;
    const int dim = plan->dim, entries = dim * dim;
    int ready = 1;
    *l = (pl_lattice){.plan = plan, .dim = dim};
    if (!place_grids(l, spacing))
        return 0;
    for (int i = 0; i < l->n_levels; i++) {
        pl_grid *g = &l->grid[i];
        g->n_vertices = g->n[0] * g->n[1] * g->n[2];
        g->first = l->n_simplices;
        l->n_simplices += g->n_vertices * pl_orders_of(dim);
        g->stiffness = pl_alloc(g->n_vertices * PL_LATTICE_BLOCKS * entries, sizeof(double));
        g->inverse = pl_alloc(g->n_vertices * entries, sizeof(double));
        g->force = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->move = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->rest = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->load = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->way = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->image = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->total = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->is_active = pl_alloc_zero(g->n_vertices, 1);
        ready = ready && g->way && g->image && g->total && g->load && g->stiffness && g->inverse &&
                g->force && g->move && g->rest && g->is_active;
    }
    l->is_free = pl_alloc_zero(plan->work.n_nodes, 1);
    l->simplex_of = pl_alloc(m > n_stars ? m : n_stars, sizeof(int32_t));
    l->element = pl_alloc(m, sizeof(int32_t));
    l->corner = pl_alloc(m * (dim + 1), sizeof(int32_t));
    l->of_layer = pl_alloc(l->grid[0].n[dim - 1], sizeof(double));
    l->element_begin = pl_alloc(l->n_simplices + 1, sizeof(int64_t));
    l->star = pl_alloc(n_stars, sizeof(int32_t));
    l->star_begin = pl_alloc(l->n_simplices + 1, sizeof(int64_t));
    double *largest = pl_alloc_zero(l->grid[0].n_vertices, sizeof *largest);
    ready = ready && l->is_free && l->corner && l->of_layer && l->simplex_of && l->element &&
            l->element_begin && l->star && l->star_begin && largest && l->n_simplices < INT32_MAX;
    if (ready) {
        element_pass pass = {.l = l, .largest = largest};
        for (int64_t i = 0; i < n_stars; i++)
            l->is_free[plan->interior.centre[i]] = 1;
        pl_parallel_for(plan->threads, m, CHUNK, largest_chunk, &pass);
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
        void *arrays[] = {g->stiffness, g->inverse, g->force, g->move, g->rest,
                          g->way,       g->image,   g->total, g->load, g->is_active};
        for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
            pl_free(arrays[k]);
    }
    pl_free(l->is_free);
    pl_free(l->simplex_of);
    pl_free(l->element);
    pl_free(l->corner);
    pl_free(l->of_layer);
    pl_free(l->element_begin);
    pl_free(l->star);
    pl_free(l->star_begin);
}

/* ---- elements and nodes by simplices --------------------------------------------------------- */

/** Whether a vertex of a simplex is active. */
PL_INLINE int is_simplex_active(const pl_grid *g, int64_t number, const int dim) {
    int64_t vertex = (number - g->first) / pl_orders_of(dim);
    const int *way = pl_order_of(dim, (number - g->first) % pl_orders_of(dim));
    int active = g->is_active[vertex];
    for (int d = 0; d < dim; d++)
        active |= g->is_active[vertex += pl_stride_of(g, way[d])];
    return active;
}

PL_INLINE void element_range(const element_pass *p, int64_t begin, int64_t end, const int dim) {
    const pl_lattice *l = p->l;
    double x[3] = {0};
    for (int64_t i = begin; i < end; i++) {
        if (!p->is_known && i + AHEAD < p->n)
            fetch_element(l, i + AHEAD, dim);
        int64_t of = p->is_known ? l->simplex_of[i] : -1;
        if (p->is_known ? of >= 0 && !is_simplex_active(&l->grid[0], of, dim)
                        : middle_of(l, i, x, dim)) {
            if (p->is_known)
                middle_of(l, i, x, dim);
            of = pl_simplex_at(l, x, dim);
        }
        l->simplex_of[i] = (int32_t)of;
        if (of >= 0)
            __atomic_fetch_add(&p->count[of], 1, __ATOMIC_RELAXED);
    }
}

static void element_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    (void)thread;
    if (p->l->dim == 3)
        element_range(p, begin, end, 3);
    else
        element_range(p, begin, end, 2);
}

static void star_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    const pl_lattice *l = p->l;
    double x[3];
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int64_t node = l->plan->interior.centre[i];
        int64_t of;
        if (l->dim == 3) {
            pl_unit_place(l, node, x, 3);
            of = pl_simplex_at(l, x, 3);
        } else {
            pl_unit_place(l, node, x, 2);
            of = pl_simplex_at(l, x, 2);
        }
        l->simplex_of[i] = (int32_t)of;
        __atomic_fetch_add(&p->count[of], 1, __ATOMIC_RELAXED);
    }
}

/** Put each to its simplex, from the simplex' end backwards. */
static void put_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int32_t of = p->l->simplex_of[i];
        if (of >= 0)
            p->of[__atomic_sub_fetch(&p->count[of], 1, __ATOMIC_RELAXED)] = (int32_t)i;
    }
}

/** Sort the few of each simplex: threads have put them in any order. */
static void order_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    (void)thread;
    for (int64_t s = begin; s < end; s++)
        for (int64_t i = p->count[s] + 1; i < p->count[s + 1]; i++) {
            const int32_t value = p->of[i];
            int64_t k = i;
            for (; k > p->count[s] && p->of[k - 1] > value; k--)
                p->of[k] = p->of[k - 1];
            p->of[k] = value;
        }
}

/** Sort n elements or stars, whose simplices chunk finds, to array of; begin [n_simplices + 1]. */
static void sort_by_simplices(pl_lattice *l, pl_chunk_fn *chunk, int is_known, int64_t n,
                              int32_t *of, int64_t *begin) {
    const int threads = l->plan->threads;
    element_pass pass = {.l = l, .count = begin, .of = of, .n = n, .is_known = is_known};
    memset(begin, 0, (size_t)(l->n_simplices + 1) * sizeof *begin);
    pl_parallel_for(threads, n, CHUNK, chunk, &pass);
    /* Where each simplex ends; where it begins, when all are put. */
    int64_t sum = 0;
    for (int64_t i = 0; i <= l->n_simplices; i++)
        begin[i] = sum += begin[i];
    pl_parallel_for(threads, n, CHUNK, put_chunk, &pass);
    pl_parallel_for(threads, l->n_simplices, CHUNK, order_chunk, &pass);
    for (int i = 0; i < l->n_levels; i++) {
        const int64_t first = l->grid[i].first;
        l->grid[i].has_own |=
            begin[first + l->grid[i].n_vertices * pl_orders_of(l->dim)] > begin[first];
    }
}

/** Note the nodes of elements that are in order. */
static void corner_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const pl_lattice *l = context;
    const int32_t *elements = l->plan->work.elements;
    const int corners = l->dim + 1;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        if (i + 32 < end)
            __builtin_prefetch(elements + (int64_t)l->element[i + 32] * corners);
        if (i + 16 < end)
            for (int j = 0; j < corners; j++)
                __builtin_prefetch(l->plan->inner +
                                   elements[(int64_t)l->element[i + 16] * corners + j]);
        for (int j = 0; j < corners; j++)
            l->corner[i * corners + j] = pl_plan_inner(l->plan, l->element[i], j);
    }
}

void pl_lattice_sort(pl_lattice *l) {
    const int64_t m = l->plan->work.n_elements, n_stars = l->plan->interior.stars.n_stars;
    for (int i = 0; i < l->n_levels; i++)
        l->grid[i].has_own = 0;
    sort_by_simplices(l, element_chunk, l->is_known, m, l->element, l->element_begin);
    pl_parallel_for(l->plan->threads, l->element_begin[l->n_simplices], CHUNK, corner_chunk, l);
    l->is_known = 0;
    sort_by_simplices(l, star_chunk, 0, n_stars, l->star, l->star_begin);
}
