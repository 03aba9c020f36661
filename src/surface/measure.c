/* measure: sums over the elements of a surface mesh. */
#include "surface/surface_mesh.h"

#include "base/memory.h"
#include "base/parallel.h"
#include "base/status.h"

enum { CHUNK = 2048 };

/** Sums of one thread. */
typedef struct thread_sums {
    _Alignas(64) pl_sum ratio[PL_SURFACE_PARTS];
    int64_t n[PL_SURFACE_PARTS], n_inverted;
    double worst, acuteness;
} thread_sums;

typedef struct measurement {
    const pl_surface_mesh *mesh;
    const double (*x)[3];
    const uint8_t *moves, *is_movable;
    double *ratio; /* [n_facets], or NULL */
    thread_sums *sums;
} measurement;

/** Ratio and acuteness of an element; 0 if it, or a corner, has turned over. */
static int measure_element(const measurement *m, int32_t facet, const int32_t *corner, int n,
                           double *ratio, double *acuteness) {
    const planish_shape *s = m->mesh->shape;
    const int whole = n == 3;
    double first[3];
    pl_kept_normal(s, facet, first);
    *ratio = *acuteness = 0;
    for (int k = 0; k < (whole ? 1 : n); k++) {
        const pl_term_role role = whole ? PL_TERM_TRIANGLE : PL_TERM_OWN;
        pl_facet_vectors v;
        pl_facet_vectors_of(role, m->x[corner[k]], m->x[corner[(k + 1) % n]],
                            m->x[corner[(k + n - 1) % n]], &v);
        if (!(pl_dot(3, v.n, first) > 0))
            return 0;
        *ratio += pl_facet_ratio(role, m->mesh->by_radius, &v) / (whole ? 1 : n);
        *acuteness = fmax(*acuteness, pl_facet_acuteness(role, &v));
    }
    return *ratio < INFINITY;
}

/** The part of an element with n corners. */
static int part_of(const measurement *m, const int32_t *corner, int n) {
    int moves = 0, is_movable = 0;
    for (int k = 0; k < n; k++) {
        moves |= m->moves[corner[k]];
        is_movable |= m->is_movable[corner[k]];
    }
    return moves ? PL_SURFACE_MOVES : is_movable ? PL_SURFACE_HELD : PL_SURFACE_FIXED;
}

static void measure_chunk(void *context, int64_t begin, int64_t end, int thread) {
    const measurement *m = context;
    const planish_shape *s = m->mesh->shape;
    thread_sums *sums = &m->sums[thread];
    for (int64_t i = begin; i < end; i++) {
        const int half = s->half ? s->half[i] : 0, n = half ? 4 : 3;
        int32_t corner[4] = {s->facet[i][0], s->facet[i][1], s->facet[i][2], 0};
        double ratio, acuteness;
        if (half == 2)
            continue;
        if (half)
            pl_surface_quadrilateral(s, (int32_t)i, corner);
        const int part = part_of(m, corner, n);
        const int valid = measure_element(m, (int32_t)i, corner, n, &ratio, &acuteness);
        if (m->ratio)
            m->ratio[i] = valid ? ratio : INFINITY;
        sums->n_inverted += !valid;
        if (!valid)
            continue;
        pl_sum_add(&sums->ratio[part], ratio);
        sums->n[part]++;
        if (part != PL_SURFACE_MOVES)
            continue;
        sums->worst = fmax(sums->worst, ratio);
        sums->acuteness = fmax(sums->acuteness, acuteness);
    }
}

int pl_surface_measure(const pl_surface_mesh *mesh, const double (*x)[3], const uint8_t *moves,
                       const uint8_t *is_movable, int threads, double *ratio, pl_surface_sums *sums,
                       planish_error *error) {
    measurement m = {mesh, x, moves, is_movable, ratio, pl_alloc_zero(threads, sizeof *m.sums)};
    *sums = (pl_surface_sums){0};
    if (!m.sums)
        return pl_fail_memory(error, "the measures of a surface");
    pl_parallel_for(threads, mesh->shape->n_facets, CHUNK, measure_chunk, &m);
    for (int t = 1; t < threads; t++) {
        thread_sums *part = &m.sums[t];
        for (int k = 0; k < PL_SURFACE_PARTS; k++) {
            pl_sum_merge(&m.sums->ratio[k], &part->ratio[k]);
            m.sums->n[k] += part->n[k];
        }
        m.sums->n_inverted += part->n_inverted;
        m.sums->worst = fmax(m.sums->worst, part->worst);
        m.sums->acuteness = fmax(m.sums->acuteness, part->acuteness);
    }
    for (int k = 0; k < PL_SURFACE_PARTS; k++) {
        sums->ratio[k] = pl_sum_value(&m.sums->ratio[k]);
        sums->n[k] = (double)m.sums->n[k];
    }
    sums->n_inverted = m.sums->n_inverted;
    sums->worst = m.sums->worst;
    sums->acuteness = m.sums->acuteness;
    pl_free(m.sums);
    return PLANISH_OK;
}
