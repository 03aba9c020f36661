/* kernel_rows: points as rows of four doubles in memory, and their exchange with columns of lanes.
 *
 * A facet or an edge names points, which lie anywhere; lanes want one coordinate of PL_PACK points.
 * To load whole rows and to exchange rows and columns in registers takes a third of the loads that
 * picking single numbers would.
 *
 *   number_of_row, numbers_of_rows                          numbers by row
 *   row_load, row_store, row_plus, row_of                   rows
 *   rows_to_columns, columns_to_rows, points_to_columns     exchange
 */
#ifndef PL_STAR_KERNEL_ROWS_H
#define PL_STAR_KERNEL_ROWS_H

#include "geometry/inline.h"
#include "star/kernel_lanes.h"

enum { PL_ROW = 4 }; /* doubles of a row; row r is at PL_ROW r, and is named by that number */

/** The number of an array that belongs to a row: number[row / PL_ROW], without the division. */
PL_INLINE double *number_of_row(double *number, uint32_t row) {
    return (double *)(void *)((char *)number + sizeof *number / PL_ROW * row);
}

/** Numbers of the rows row[0], row[stride], ... */
PL_INLINE lanes numbers_of_rows(double *number, const uint32_t *row, int stride) {
#if PL_PACK == 4
    return (lanes){*number_of_row(number, row[0]), *number_of_row(number, row[stride]),
                   *number_of_row(number, row[2 * stride]),
                   *number_of_row(number, row[3 * stride])};
#elif PL_PACK == 2
    return (lanes){*number_of_row(number, row[0]), *number_of_row(number, row[stride])};
#else
    (void)stride;
    return *number_of_row(number, row[0]);
#endif
}

/** Row in PL_PACKS packs. */
typedef struct point_row {
    lanes pack[PL_PACKS];
} point_row;

/** Load the row at p [4], which is aligned to its size. */
PL_INLINE point_row row_load(const double *p) {
    point_row r;
    for (int k = 0; k < PL_PACKS; k++)
        r.pack[k] = lanes_load(p + k * PL_PACK);
    return r;
}

/** Store a row at p [4]. */
PL_INLINE void row_store(double *p, point_row r) {
    for (int k = 0; k < PL_PACKS; k++)
        lanes_store(p + k * PL_PACK, r.pack[k]);
}

/** Sum a + b. */
PL_INLINE point_row row_plus(point_row a, point_row b) {
    for (int k = 0; k < PL_PACKS; k++)
        a.pack[k] += b.pack[k];
    return a;
}

/** Row of a point p [dim]; the rest is 0. */
PL_INLINE point_row row_of(const double *p, const int dim) {
    const double z = dim == 3 ? p[2] : 0;
#if PL_PACK == 4
    return (point_row){{{p[0], p[1], z, 0}}};
#elif PL_PACK == 2
    return (point_row){{{p[0], p[1]}, {z, 0}}};
#else
    return (point_row){{p[0], p[1], z, 0}};
#endif
}

#if defined(__clang__) || __GNUC__ >= 12
#define PL_SHUFFLE(a, b, i, j, k, l) __builtin_shufflevector(a, b, i, j, k, l)
#else
#define PL_SHUFFLE(a, b, i, j, k, l) __builtin_shuffle(a, b, (lanes_mask){i, j, k, l})
#endif

/** Transpose PL_PACK packs. */
PL_INLINE void exchange(const lanes in[PL_PACK], lanes out[PL_PACK]) {
#if PL_PACK == 4
    lanes even01 = PL_SHUFFLE(in[0], in[1], 0, 4, 2, 6);
    lanes odd01 = PL_SHUFFLE(in[0], in[1], 1, 5, 3, 7);
    lanes even23 = PL_SHUFFLE(in[2], in[3], 0, 4, 2, 6);
    lanes odd23 = PL_SHUFFLE(in[2], in[3], 1, 5, 3, 7);
    out[0] = PL_SHUFFLE(even01, even23, 0, 1, 4, 5);
    out[1] = PL_SHUFFLE(odd01, odd23, 0, 1, 4, 5);
    out[2] = PL_SHUFFLE(even01, even23, 2, 3, 6, 7);
    out[3] = PL_SHUFFLE(odd01, odd23, 2, 3, 6, 7);
#elif PL_PACK == 2
    out[0] = (lanes){in[0][0], in[1][0]};
    out[1] = (lanes){in[0][1], in[1][1]};
#else
    out[0] = in[0];
#endif
}

/** Exchange the rows of PL_PACK points to columns of lanes. */
PL_INLINE void rows_to_columns(const point_row rows[PL_PACK], lanes column[PL_ROW]) {
    for (int k = 0; k < PL_PACKS; k++) {
        lanes in[PL_PACK];
        for (int i = 0; i < PL_PACK; i++)
            in[i] = rows[i].pack[k];
        exchange(in, column + PL_PACK * k);
    }
}

/** Exchange columns of lanes to the rows of PL_PACK points. */
PL_INLINE void columns_to_rows(const lanes column[PL_ROW], point_row rows[PL_PACK]) {
    for (int k = 0; k < PL_PACKS; k++) {
        lanes out[PL_PACK];
        exchange(column + PL_PACK * k, out);
        for (int i = 0; i < PL_PACK; i++)
            rows[i].pack[k] = out[i];
    }
}

#if PL_PACK == 4 && defined(__AVX__)
/** The pairs at a and b. By intrinsics: left to themselves compilers load both and shuffle, for
 * which a CPU has one port; to insert what is loaded it has three. */
PL_INLINE lanes lanes_of_pairs(const double *a, const double *b) {
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_load_pd(a)), _mm_load_pd(b), 1);
}
#endif

/** Columns x, y, z of the points in rows row[0], row[stride], ... of array. */
PL_INLINE void points_to_columns(const double *array, const uint32_t *row, int stride,
                                 lanes column[PL_ROW]) {
#if PL_PACK == 4 && defined(__AVX__)
    const double *p[4];
    for (int k = 0; k < 4; k++)
        p[k] = array + row[k * stride];
    const lanes xy02 = lanes_of_pairs(p[0], p[2]), xy13 = lanes_of_pairs(p[1], p[3]);
    const lanes z02 = lanes_of_pairs(p[0] + 2, p[2] + 2), z13 = lanes_of_pairs(p[1] + 2, p[3] + 2);
    column[0] = PL_SHUFFLE(xy02, xy13, 0, 4, 2, 6);
    column[1] = PL_SHUFFLE(xy02, xy13, 1, 5, 3, 7);
    column[2] = PL_SHUFFLE(z02, z13, 0, 4, 2, 6);
#else
    point_row rows[PL_PACK];
    for (int k = 0; k < PL_PACK; k++)
        rows[k] = row_load(array + row[k * stride]);
    rows_to_columns(rows, column);
#endif
}

#endif
