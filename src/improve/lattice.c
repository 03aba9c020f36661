/* lattice: grids over a mesh, their stiffness, and a V-cycle. All loops write in an order that does
 * not depend on threads: layers of cells or vertices with one between them share nothing.
 */
#include "improve/lattice.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "geometry/cube_root.h"
#include "geometry/simplex.h"
#include "improve/bend.h"
#include "star/kernel_direction.h"

#include <math.h>
#include <string.h>

enum { CHUNK = 1024, MAX_CORNERS = 4, MAX_ORDERS = 6 };

/* Directions in which a simplex goes from its first vertex to its last. */
static const int ORDER_3D[MAX_ORDERS][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                            {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

/* ---- places -------------------------------------------------------------------------------- */

static int orders_of(int dim) {
    return dim == 3 ? 6 : 2;
}

/** Order of directions for dim 2 is that of 3-D's 0 and 2: their last direction is the third. */
static const int *order_of(int dim, int64_t order) {
    return ORDER_3D[dim == 3 ? order : 2 * order];
}

static int64_t stride_of(const pl_grid *g, int direction) {
    return direction == 0 ? 1 : direction == 1 ? g->n[0] : g->n[0] * g->n[1];
}

/** Number of the vertex at offset bits from the first. */
static int64_t offset_of(const pl_grid *g, int bits) {
    return (bits & 1) + (bits >> 1 & 1) * g->n[0] + (bits >> 2 & 1) * g->n[0] * g->n[1];
}

/** Coordinates of a node in the unit of the lattice. */
PL_INLINE void unit_place(const pl_lattice *l, int64_t inner, double *x, const int dim) {
    const double *from = l->plan->scratch.coordinates + inner * dim;
    for (int d = 0; d < dim; d++)
        x[d] = (from[d] - l->origin[d]) * l->per_unit;
}

/** Place in a cube: which, and how far along each direction. */
typedef struct cube_place {
    int64_t vertex;
    double along[3];
} cube_place;

PL_INLINE cube_place cube_at(const pl_grid *g, const double *x, const int dim) {
    cube_place p = {0, {0, 0, 0}};
    for (int d = 0; d < dim; d++) {
        const double t = x[d] * g->per_spacing;
        int64_t i = (int64_t)t;
        i = i < 0 ? 0 : i > g->n[d] - 2 ? g->n[d] - 2 : i;
        p.along[d] = t - (double)i;
        p.vertex += i * stride_of(g, d);
    }
    return p;
}

static int find_order(const double f[3], int dim) {
    if (dim == 2)
        return f[0] < f[1];
    if (f[0] >= f[1])
        return f[1] >= f[2] ? 0 : f[0] >= f[2] ? 1 : 4;
    return f[0] >= f[2] ? 2 : f[1] >= f[2] ? 3 : 5;
}

/** Number of the simplex at x, of the finest grid that is active there; and its level. */
PL_INLINE int64_t simplex_at(const pl_lattice *l, const double *x, const int dim) {
    for (int level = 0;; level++) {
        const pl_grid *g = &l->grid[level];
        const cube_place p = cube_at(g, x, dim);
        const int order = find_order(p.along, dim), *way = order_of(dim, order);
        int64_t vertex = p.vertex;
        int active = g->is_active[vertex];
        for (int d = 0; d < dim; d++)
            active |= g->is_active[vertex += stride_of(g, way[d])];
        if (active || level == l->n_levels - 1)
            return g->first + p.vertex * orders_of(dim) + order;
    }
}

/** A simplex. */
typedef struct simplex {
    const pl_grid *g;
    const int *way;
    int64_t vertex[MAX_CORNERS];
    int bits[MAX_CORNERS]; /* offsets of these from the first */
    double corner[3];      /* place of the first, in spacings */
} simplex;

PL_INLINE simplex simplex_of_number(const pl_grid *g, int64_t number, const int dim) {
    const int64_t of_grid = number - g->first;
    simplex s = {.g = g, .way = order_of(dim, of_grid % orders_of(dim))};
    const int64_t first = of_grid / orders_of(dim);
    s.vertex[0] = first;
    s.corner[0] = (double)(first % g->n[0]);
    s.corner[1] = (double)(first / g->n[0] % g->n[1]);
    s.corner[2] = (double)(first / g->n[0] / g->n[1]);
    for (int d = 0; d < dim; d++) {
        s.bits[d + 1] = s.bits[d] | 1 << s.way[d];
        s.vertex[d + 1] = s.vertex[d] + stride_of(g, s.way[d]);
    }
    return s;
}

/** Weights of the vertices of a simplex at x, which may be outside. */
PL_INLINE void weights_at(const simplex *s, const double *x, double *weight, const int dim) {
    double along[3] = {0};
    for (int d = 0; d < dim; d++)
        along[d] = x[d] * s->g->per_spacing - s->corner[d];
    weight[0] = 1 - along[s->way[0]];
    for (int d = 1; d < dim; d++)
        weight[d] = along[s->way[d - 1]] - along[s->way[d]];
    weight[dim] = along[s->way[dim - 1]];
}

/* ---- which grids ----------------------------------------------------------------------------- */

/* Vertices of the finest grid for each star at most; stars without any would be too few for one. */
#define VERTICES_PER_STAR 0.5
/* A grid suits elements whose nodes are this part of its spacing apart, or less. */
#define LARGEST_EDGE 0.8
enum { SAMPLES = 4096, COARSEST = 4 };

/** Twice, or six times, the measure of an element, in the mesh's unit. */
static double determinant_of(const planish_plan *plan, int64_t element) {
    const int dim = plan->dim;
    const double *x[MAX_CORNERS];
    double e[3][3] = {{0}};
    for (int j = 0; j <= dim; j++)
        x[j] = plan->scratch.coordinates + (int64_t)pl_plan_inner(plan, element, j) * dim;
    for (int j = 0; j < dim; j++)
        for (int d = 0; d < dim; d++)
            e[j][d] = x[j + 1][d] - x[0][d];
    return fabs(pl_determinant_of_edges(dim, e));
}

/** Mean distance of nodes: that of a grid with as many. */
static double node_distance(const planish_plan *plan) {
    const int64_t m = plan->work.n_elements, step = m > SAMPLES ? m / SAMPLES : 1;
    double sum = 0, n = 0;
    for (int64_t i = 0; i < m; i += step, n++) {
        const double measure = determinant_of(plan, i);
        sum += plan->dim == 3 ? pl_cube_root(measure) : sqrt(measure);
    }
    return n > 0 ? sum / n : 0;
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
    const double most = VERTICES_PER_STAR * (double)plan->interior.stars.n_stars + 64;
    double lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    double extent[3] = {0};
    for (int64_t i = 0; i < plan->work.n_nodes; i++)
        for (int d = 0; d < l->dim; d++) {
            const double x = plan->scratch.coordinates[i * l->dim + d];
            lower[d] = x < lower[d] ? x : lower[d];
            upper[d] = x > upper[d] ? x : upper[d];
        }
    spacing *= node_distance(plan);
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
        unit_place(l, inner, node, dim);
        for (int d = 0; d < dim; d++)
            x[d] += node[d] * (1.0 / (dim + 1));
    }
    return any;
}

static void largest_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    const pl_lattice *l = p->l;
    double unit = 1, x[3];
    (void)thread;
    for (int d = 0; d < l->dim; d++)
        unit *= l->spacing;
    for (int64_t i = begin; i < end; i++)
        if (middle_of(l, i, x, l->dim))
            pl_raise_double(&p->largest[cube_at(&l->grid[0], x, l->dim).vertex],
                            determinant_of(l->plan, i) / unit);
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
                most = fmax(most, largest[v - offset_of(g, bits)]);
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
                fine += i * stride_of(g, d);
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
        l->n_simplices += g->n_vertices * orders_of(dim);
        g->stiffness = pl_alloc(g->n_vertices * PL_LATTICE_BLOCKS * entries, sizeof(double));
        g->inverse = pl_alloc(g->n_vertices * entries, sizeof(double));
        g->force = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->move = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->rest = pl_alloc_zero(g->n_vertices * dim, sizeof(double));
        g->is_active = pl_alloc_zero(g->n_vertices, 1);
        ready = ready && g->stiffness && g->inverse && g->force && g->move && g->rest &&
                g->is_active;
    }
    l->is_free = pl_alloc_zero(plan->work.n_nodes, 1);
    l->simplex_of = pl_alloc(m > n_stars ? m : n_stars, sizeof(int32_t));
    l->element = pl_alloc(m, sizeof(int32_t));
    l->element_begin = pl_alloc(l->n_simplices + 1, sizeof(int64_t));
    l->star = pl_alloc(n_stars, sizeof(int32_t));
    l->star_begin = pl_alloc(l->n_simplices + 1, sizeof(int64_t));
    double *largest = pl_alloc_zero(l->grid[0].n_vertices, sizeof *largest);
    ready = ready && l->is_free && l->simplex_of && l->element && l->element_begin && l->star &&
            l->star_begin && largest && l->n_simplices < INT32_MAX;
    if (ready) {
        element_pass pass = {.l = l, .largest = largest};
        for (int64_t i = 0; i < n_stars; i++)
            l->is_free[plan->interior.centre[i]] = 1;
        pl_parallel_for(plan->threads, m, CHUNK, largest_chunk, &pass);
        for (int i = 0; i < l->n_levels; i++)
            activate(l, i, largest);
    }
    pl_free(largest);
    return ready;
}

void pl_lattice_destroy(pl_lattice *l) {
    for (int i = 0; i < l->n_levels; i++) {
        pl_grid *g = &l->grid[i];
        void *arrays[] = {g->stiffness, g->inverse, g->force, g->move, g->rest, g->is_active};
        for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
            pl_free(arrays[k]);
    }
    pl_free(l->is_free);
    pl_free(l->simplex_of);
    pl_free(l->element);
    pl_free(l->element_begin);
    pl_free(l->star);
    pl_free(l->star_begin);
}

/* ---- elements and nodes by simplices --------------------------------------------------------- */

static void element_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const element_pass *p = context;
    const pl_lattice *l = p->l;
    double x[3];
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const int any = l->dim == 3 ? middle_of(l, i, x, 3) : middle_of(l, i, x, 2);
        const int64_t of = !any ? -1 : l->dim == 3 ? simplex_at(l, x, 3) : simplex_at(l, x, 2);
        l->simplex_of[i] = (int32_t)of;
        if (any)
            __atomic_fetch_add(&p->count[of], 1, __ATOMIC_RELAXED);
    }
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
            unit_place(l, node, x, 3);
            of = simplex_at(l, x, 3);
        } else {
            unit_place(l, node, x, 2);
            of = simplex_at(l, x, 2);
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
static void sort_by_simplices(pl_lattice *l, pl_chunk_fn *chunk, int64_t n, int32_t *of,
                              int64_t *begin) {
    const int threads = l->plan->threads;
    element_pass pass = {.l = l, .count = begin, .of = of, .n = n};
    memset(begin, 0, (size_t)(l->n_simplices + 1) * sizeof *begin);
    pl_parallel_for(threads, n, CHUNK, chunk, &pass);
    /* Where each simplex ends; where it begins, when all are put. */
    int64_t sum = 0;
    for (int64_t i = 0; i <= l->n_simplices; i++)
        begin[i] = sum += begin[i];
    pl_parallel_for(threads, n, CHUNK, put_chunk, &pass);
    pl_parallel_for(threads, l->n_simplices, CHUNK, order_chunk, &pass);
}

/* ---- stiffness ------------------------------------------------------------------------------- */

/** Work on the layers of a grid along its last direction: those of one parity share no vertices that
 *  are written. */
typedef struct layer_pass {
    pl_lattice *l;
    const pl_grid *g;
    void (*body)(const struct layer_pass *pass, int64_t layer);
    int64_t parity;
    int is_backward;
    const double *from; /* [n_stars][dim] */
    double *to;         /* [n_stars][dim] */
    double shift;
} layer_pass;

static void layer_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const layer_pass *p = context;
    (void)thread;
    for (int64_t i = begin; i < end; i++)
        p->body(p, 2 * i + p->parity);
}

/** Visit n layers: those of one parity, then the others. */
static void visit_layers(layer_pass *p, int64_t n) {
    const int threads = pl_paying_threads(p->l->plan->threads, p->g->n_vertices * 16);
    for (int k = 0; k < 2; k++) {
        p->parity = k ^ p->is_backward;
        pl_parallel_for(threads, (n + 1 - p->parity) / 2, 1, layer_chunk, p);
    }
}

/** Four elements of a simplex: their nodes, and the weights of its vertices at these; 0 at nodes that
 *  are not free. */
typedef struct four {
    bend_pack x[MAX_CORNERS][3], weight[MAX_CORNERS][MAX_CORNERS];
} four;

PL_INLINE void gather_four(const pl_lattice *l, const simplex *s, const int32_t *element, int64_t n,
                           four *f, const int dim) {
    for (int lane = 0; lane < 4; lane++) {
        const int32_t e = element[lane < n ? lane : 0];
        for (int j = 0; j <= dim; j++) {
            const int32_t inner = pl_plan_inner(l->plan, e, j);
            double x[3], weight[MAX_CORNERS] = {0};
            unit_place(l, inner, x, dim);
            if (l->is_free[inner] && lane < n)
                weights_at(s, x, weight, dim);
            for (int d = 0; d < dim; d++)
                f->x[j][d][lane] = x[d];
            for (int a = 0; a <= dim; a++)
                f->weight[j][a][lane] = weight[a];
        }
    }
}

/** Sums over elements of a simplex: blocks of its vertices a <= b, in this order. */
typedef struct simplex_sums {
    bend_pack block[10][9];
} simplex_sums;

PL_INLINE void add_four(const four *f, simplex_sums *sums, const int dim) {
    const int n = dim * dim;
    bend_block h[BEND_BLOCKS];
    bend_vector e[3];
    bend_pack by_edge[3][MAX_CORNERS], half[3][MAX_CORNERS][9];
    for (int k = 0; k < dim; k++) {
        e[k].x = f->x[k + 1][0] - f->x[0][0];
        e[k].y = f->x[k + 1][1] - f->x[0][1];
        e[k].z = dim == 3 ? f->x[k + 1][2] - f->x[0][2] : bend_of(0);
        for (int a = 0; a <= dim; a++)
            by_edge[k][a] = f->weight[k + 1][a] - f->weight[0][a];
    }
    if (dim == 3)
        bend_tetrahedra(e, h);
    else
        bend_triangles(e, h);
    for (int i = 0; i < dim; i++)
        for (int a = 0; a <= dim; a++)
            for (int c = 0; c < n; c++) {
                bend_pack sum = bend_of(0);
                for (int j = 0; j < dim; j++) {
                    const int low = i < j ? i : j, high = i < j ? j : i;
                    const int at = low * dim - low * (low - 1) / 2 + high - low;
                    sum += by_edge[j][a] * h[at][i <= j ? c : c % dim * dim + c / dim];
                }
                half[i][a][c] = sum;
            }
    for (int a = 0, at = 0; a <= dim; a++)
        for (int b = a; b <= dim; b++, at++)
            for (int c = 0; c < n; c++) {
                bend_pack sum = by_edge[0][a] * half[0][b][c];
                for (int i = 1; i < dim; i++)
                    sum += by_edge[i][a] * half[i][b][c];
                sums->block[at][c] += sum;
            }
}

PL_INLINE void add_simplex(const pl_lattice *l, const pl_grid *g, int64_t number, const int dim) {
    const int64_t begin = l->element_begin[number], end = l->element_begin[number + 1];
    const int n = dim * dim;
    if (begin == end)
        return;
    const simplex s = simplex_of_number(g, number, dim);
    simplex_sums sums;
    four f;
    memset(&sums, 0, sizeof sums);
    for (int64_t i = begin; i < end; i += 4) {
        gather_four(l, &s, l->element + i, end - i, &f, dim);
        add_four(&f, &sums, dim);
    }
    for (int a = 0, at = 0; a <= dim; a++)
        for (int b = a; b <= dim; b++, at++) {
            double *to = g->stiffness +
                         (s.vertex[a] * PL_LATTICE_BLOCKS + (s.bits[a] ^ s.bits[b])) * n;
            for (int c = 0; c < n; c++)
                to[c] += (sums.block[at][c][0] + sums.block[at][c][1]) +
                         (sums.block[at][c][2] + sums.block[at][c][3]);
        }
}

PL_INLINE void add_layer(const layer_pass *p, int64_t layer, const int dim) {
    const int64_t stride = stride_of(p->g, dim - 1) * orders_of(dim);
    for (int64_t i = layer * stride; i < (layer + 1) * stride; i++)
        add_simplex(p->l, p->g, p->g->first + i, dim);
}

static void add_layer_3d(const layer_pass *p, int64_t layer) {
    add_layer(p, layer, 3);
}

static void add_layer_2d(const layer_pass *p, int64_t layer) {
    add_layer(p, layer, 2);
}

#if defined(PL_X86_KERNELS)
__attribute__((target("avx2"))) static void add_layer_3d_wide(const layer_pass *p, int64_t layer) {
    add_layer(p, layer, 3);
}
#endif

/** Function that adds the elements of a layer. */
static void (*adder_of(int dim))(const layer_pass *, int64_t) {
#if defined(PL_X86_KERNELS)
    if (dim == 3 && __builtin_cpu_supports("avx2"))
        return add_layer_3d_wide;
#endif
    return dim == 3 ? add_layer_3d : add_layer_2d;
}

/** Vertex of a finer grid, or of this one, by coordinates. */
typedef struct vertex_at {
    int64_t at[3], number; /* number is -1 outside of the grid */
} vertex_at;

static vertex_at vertex_by(const pl_grid *g, const int64_t at[3], int bits, int sign) {
    vertex_at v = {.number = 0};
    for (int d = 0; d < 3; d++) {
        v.at[d] = at[d] + sign * (bits >> d & 1);
        if (v.at[d] < 0 || v.at[d] >= g->n[d])
            return (vertex_at){.number = -1};
        v.number += v.at[d] * stride_of(g, d);
    }
    return v;
}

/** Coordinates of vertex number of a grid. */
static void find_coordinates(const pl_grid *g, int64_t number, int64_t at[3]) {
    at[0] = number % g->n[0];
    at[1] = number / g->n[0] % g->n[1];
    at[2] = number / g->n[0] / g->n[1];
}

/** Add block K, or its transpose, of fine vertex i, of weight for coarse vertex a, and j. */
static void add_block(const pl_grid *coarse, int64_t vertex, const int64_t a[3], const vertex_at *j,
                      double weight, const double *K, int is_transposed, int dim) {
    int parity = 0;
    for (int d = 0; d < dim; d++)
        parity |= (int)(j->at[d] & 1) << d;
    for (int end = 0; end < (parity ? 2 : 1); end++) {
        int bits = 0, fits = 1;
        for (int d = 0; d < dim; d++) {
            const int64_t way = j->at[d] / 2 + (end ? parity >> d & 1 : 0) - a[d];
            fits &= way == 0 || way == 1;
            bits |= (way == 1) << d;
        }
        if (!fits)
            continue;
        double *to = coarse->stiffness + (vertex * PL_LATTICE_BLOCKS + bits) * dim * dim;
        const double w = parity ? 0.5 * weight : weight;
        for (int r = 0; r < dim; r++)
            for (int c = 0; c < dim; c++)
                to[r * dim + c] += w * K[is_transposed ? c * dim + r : r * dim + c];
    }
}

/** Set the stiffness of coarse vertices from the finer grid. */
static void coarsen_layer(const layer_pass *p, int64_t layer) {
    const pl_grid *g = p->g, *fine = g - 1;
    const int dim = p->l->dim, n = dim * dim, corners = 1 << dim;
    const int64_t stride = stride_of(g, dim - 1);
    for (int64_t v = layer * stride; v < (layer + 1) * stride; v++) {
        int64_t a[3], twice[3];
        find_coordinates(g, v, a);
        for (int d = 0; d < 3; d++)
            twice[d] = 2 * a[d];
        for (int k = 0; k < 2 * corners - 1; k++) {
            const int bits = k < corners ? k : k - corners + 1, sign = k < corners ? 1 : -1;
            const vertex_at i = vertex_by(fine, twice, bits, sign);
            if (i.number < 0)
                continue;
            for (int q = 0; q < 2 * corners - 1; q++) {
                const int to = q < corners ? q : q - corners + 1;
                const vertex_at j = vertex_by(fine, i.at, to, q < corners ? 1 : -1);
                if (j.number < 0)
                    continue;
                const int64_t row = q < corners ? i.number : j.number;
                add_block(g, v, a, &j, bits ? 0.5 : 1,
                          fine->stiffness + (row * PL_LATTICE_BLOCKS + to) * n, q >= corners, dim);
            }
        }
    }
}

/** Invert a block; 0 unless it is positive definite. */
static int invert_block(const double *k, double *inverse, int dim) {
    if (dim == 2) {
        const double determinant = k[0] * k[3] - k[1] * k[2];
        if (!(k[0] > 0 && determinant > 0))
            return 0;
        const double factor = 1 / determinant;
        inverse[0] = k[3] * factor;
        inverse[1] = inverse[2] = -k[1] * factor;
        inverse[3] = k[0] * factor;
        return 1;
    }
    const double packed_block[6] = {k[0], k[1], k[2], k[4], k[5], k[8]};
    double six[6];
    if (!invert(packed_block, six))
        return 0;
    const double all[9] = {six[0], six[1], six[2], six[1], six[3], six[4], six[2], six[4], six[5]};
    memcpy(inverse, all, sizeof all);
    return 1;
}

/* First shift of a vertex's block that is not positive definite, of its largest entry. */
#define SHIFT 0x1p-6

static void invert_layer(const layer_pass *p, int64_t layer) {
    const pl_grid *g = p->g;
    const int dim = p->l->dim, n = dim * dim;
    const int64_t stride = stride_of(g, dim - 1);
    for (int64_t v = layer * stride; v < (layer + 1) * stride; v++) {
        double *k = g->stiffness + v * PL_LATTICE_BLOCKS * n, largest = 0;
        for (int d = 0; d < dim; d++) {
            largest = fmax(largest, k[d * (dim + 1)]);
            k[d * (dim + 1)] *= 1 + p->shift;
        }
        memset(g->inverse + v * n, 0, (size_t)n * sizeof(double));
        double shift = largest * SHIFT;
        for (int i = 0; largest > 0 && !invert_block(k, g->inverse + v * n, dim) && i < 16; i++) {
            for (int d = 0; d < dim; d++)
                k[d * (dim + 1)] += shift;
            shift *= 4;
        }
    }
}

void pl_lattice_assemble(pl_lattice *l, double shift) {
    const int64_t m = l->plan->work.n_elements, n_stars = l->plan->interior.stars.n_stars;
    sort_by_simplices(l, element_chunk, m, l->element, l->element_begin);
    sort_by_simplices(l, star_chunk, n_stars, l->star, l->star_begin);
    for (int i = 0; i < l->n_levels; i++) {
        const pl_grid *g = &l->grid[i];
        layer_pass pass = {.l = l, .g = g, .shift = shift};
        memset(g->stiffness, 0,
               (size_t)(g->n_vertices * PL_LATTICE_BLOCKS * l->dim * l->dim) * sizeof(double));
        if (i > 0) {
            pass.body = coarsen_layer;
            visit_layers(&pass, g->n[l->dim - 1]);
        }
        pass.body = adder_of(l->dim);
        visit_layers(&pass, g->n[l->dim - 1] - 1);
    }
    /* Shifts of one grid are none of the next. */
    for (int i = 0; i < l->n_levels; i++) {
        layer_pass pass = {.l = l, .g = &l->grid[i], .shift = shift, .body = invert_layer};
        visit_layers(&pass, l->grid[i].n[l->dim - 1]);
    }
}

/* ---- forces and moves of nodes --------------------------------------------------------------- */

PL_INLINE void restrict_layer(const layer_pass *p, int64_t layer, const int dim) {
    const pl_lattice *l = p->l;
    const int64_t stride = stride_of(p->g, dim - 1) * orders_of(dim);
    for (int64_t i = p->g->first + layer * stride; i < p->g->first + (layer + 1) * stride; i++) {
        if (l->star_begin[i] == l->star_begin[i + 1])
            continue;
        const simplex s = simplex_of_number(p->g, i, dim);
        for (int64_t k = l->star_begin[i]; k < l->star_begin[i + 1]; k++) {
            double x[3], weight[MAX_CORNERS];
            unit_place(l, l->plan->interior.centre[l->star[k]], x, dim);
            weights_at(&s, x, weight, dim);
            for (int a = 0; a <= dim; a++)
                for (int d = 0; d < dim; d++) {
                    if (p->to)
                        p->to[l->star[k] * (int64_t)dim + d] +=
                            weight[a] * p->g->move[s.vertex[a] * dim + d] * l->spacing;
                    else
                        p->g->force[s.vertex[a] * dim + d] +=
                            weight[a] * p->from[l->star[k] * (int64_t)dim + d] * l->spacing;
                }
        }
    }
}

static void nodes_of_layer(const layer_pass *p, int64_t layer) {
    if (p->l->dim == 3)
        restrict_layer(p, layer, 3);
    else
        restrict_layer(p, layer, 2);
}

void pl_lattice_restrict(pl_lattice *l, const double *force) {
    for (int i = 0; i < l->n_levels; i++) {
        const pl_grid *g = &l->grid[i];
        layer_pass pass = {.l = l, .g = g, .from = force, .body = nodes_of_layer};
        memset(g->force, 0, (size_t)(g->n_vertices * l->dim) * sizeof(double));
        visit_layers(&pass, g->n[l->dim - 1] - 1);
    }
}

void pl_lattice_prolong(const pl_lattice *l, double *move) {
    memset(move, 0, (size_t)(l->plan->interior.stars.n_stars * l->dim) * sizeof(double));
    for (int i = 0; i < l->n_levels; i++) {
        layer_pass pass = {
            .l = (pl_lattice *)l, .g = &l->grid[i], .to = move, .body = nodes_of_layer};
        visit_layers(&pass, l->grid[i].n[l->dim - 1] - 1);
    }
}

/* ---- multigrid ------------------------------------------------------------------------------- */

/** Set rest to force - K move of vertex v, without its own block unless with_own. */
PL_INLINE void rest_at(const pl_grid *g, int64_t v, int with_own, double *rest, const int dim) {
    const int n = dim * dim, corners = 1 << dim;
    for (int d = 0; d < dim; d++)
        rest[d] = g->force[v * dim + d];
    for (int bits = with_own ? 0 : 1; bits < corners; bits++) {
        const int64_t way = offset_of(g, bits), after = v + way, before = v - way;
        /* Blocks to vertices outside of the grid are 0. */
        if (after < g->n_vertices) {
            const double *k = g->stiffness + (v * PL_LATTICE_BLOCKS + bits) * n;
            for (int r = 0; r < dim; r++)
                for (int c = 0; c < dim; c++)
                    rest[r] -= k[r * dim + c] * g->move[after * dim + c];
        }
        if (bits > 0 && before >= 0) {
            const double *k = g->stiffness + (before * PL_LATTICE_BLOCKS + bits) * n;
            for (int r = 0; r < dim; r++)
                for (int c = 0; c < dim; c++)
                    rest[r] -= k[c * dim + r] * g->move[before * dim + c];
        }
    }
}

PL_INLINE void relax_layer(const layer_pass *p, int64_t layer, const int dim) {
    const pl_grid *g = p->g;
    const int64_t stride = stride_of(g, dim - 1);
    for (int64_t i = 0; i < stride; i++) {
        const int64_t v = layer * stride + (p->is_backward ? stride - 1 - i : i);
        double rest[3];
        if (!g->is_active[v])
            continue;
        rest_at(g, v, 0, rest, dim);
        for (int r = 0; r < dim; r++) {
            double sum = 0;
            for (int c = 0; c < dim; c++)
                sum += g->inverse[v * dim * dim + r * dim + c] * rest[c];
            g->move[v * dim + r] = sum;
        }
    }
}

static void relax_layer_of(const layer_pass *p, int64_t layer) {
    if (p->l->dim == 3)
        relax_layer(p, layer, 3);
    else
        relax_layer(p, layer, 2);
}

static void rest_layer_of(const layer_pass *p, int64_t layer) {
    const int dim = p->l->dim;
    const int64_t stride = stride_of(p->g, dim - 1);
    for (int64_t v = layer * stride; v < (layer + 1) * stride; v++)
        if (dim == 3)
            rest_at(p->g, v, 1, p->g->rest + v * 3, 3);
        else
            rest_at(p->g, v, 1, p->g->rest + v * 2, 2);
}

/** Add the rest of the finer grid to the forces of this one. */
static void restrict_rest(const layer_pass *p, int64_t layer) {
    const pl_grid *g = p->g, *fine = g - 1;
    const int dim = p->l->dim, corners = 1 << dim;
    const int64_t stride = stride_of(g, dim - 1);
    for (int64_t v = layer * stride; v < (layer + 1) * stride; v++) {
        int64_t twice[3];
        find_coordinates(g, v, twice);
        for (int d = 0; d < 3; d++)
            twice[d] *= 2;
        for (int k = 0; k < 2 * corners - 1; k++) {
            const int bits = k < corners ? k : k - corners + 1;
            const vertex_at i = vertex_by(fine, twice, bits, k < corners ? 1 : -1);
            for (int d = 0; i.number >= 0 && d < dim; d++)
                g->force[v * dim + d] += (bits ? 0.5 : 1) * fine->rest[i.number * dim + d];
        }
    }
}

/** Add the moves of the coarser grid to those of this one. */
static void prolong_layer(const layer_pass *p, int64_t layer) {
    const pl_grid *g = p->g, *coarse = g + 1;
    const int dim = p->l->dim;
    const int64_t stride = stride_of(g, dim - 1);
    for (int64_t v = layer * stride; v < (layer + 1) * stride; v++) {
        int64_t at[3], from = 0;
        int parity = 0;
        find_coordinates(g, v, at);
        for (int d = 0; d < dim; d++) {
            from += at[d] / 2 * stride_of(coarse, d);
            parity |= (int)(at[d] & 1) << d;
        }
        const int64_t to = from + offset_of(coarse, parity);
        for (int d = 0; d < dim; d++)
            g->move[v * dim + d] +=
                0.5 * (coarse->move[from * dim + d] + coarse->move[to * dim + d]);
    }
}

static void visit_vertices(pl_lattice *l, int level, int is_backward,
                           void (*body)(const layer_pass *, int64_t)) {
    layer_pass pass = {.l = l, .g = &l->grid[level], .body = body, .is_backward = is_backward};
    visit_layers(&pass, l->grid[level].n[l->dim - 1]);
}

void pl_lattice_solve(pl_lattice *l) {
    enum { SMOOTHINGS = 2, OF_COARSEST = 8 };
    const int last = l->n_levels - 1;
    for (int i = 0; i <= last; i++)
        memset(l->grid[i].move, 0, (size_t)(l->grid[i].n_vertices * l->dim) * sizeof(double));
    for (int i = 0; i <= last; i++) {
        if (i > 0)
            visit_vertices(l, i, 0, restrict_rest);
        for (int k = 0; k < (i == last ? OF_COARSEST : SMOOTHINGS); k++)
            visit_vertices(l, i, 0, relax_layer_of);
        if (i < last)
            visit_vertices(l, i, 0, rest_layer_of);
    }
    for (int i = last; i >= 0; i--) {
        if (i < last)
            visit_vertices(l, i, 0, prolong_layer);
        for (int k = 0; k < (i == last ? OF_COARSEST : SMOOTHINGS); k++)
            visit_vertices(l, i, 1, relax_layer_of);
    }
}
