/* sheets: shapes of surfaces made by rule, random moves of their nodes, and distances by brute force.
 *
 * Features are where the rules put them: at borders, where not two facets meet or facets turn
 * different ways round, at bends of 40 degrees, and along the crease of a sheet.
 */
#ifndef TEST_SUPPORT_SHEETS_H
#define TEST_SUPPORT_SHEETS_H

#include "shape/curved.h"

/** Kinds of sheets. */
enum {
    SHEET_BUMPS,    /* open, with smooth bumps */
    SHEET_PLANE,    /* plane, with a round border */
    SHEET_CREASE,   /* folded along a wavy line */
    SHEET_SPHERE,   /* closed */
    SHEET_TUBE,     /* open at both ends: closed curves */
    SHEET_PLATE,    /* both sides and the rim of a plate of 0.1 edges */
    SHEET_NEEDLES,  /* bumps, stretched by up to 10^4 */
    SHEET_MOEBIUS,  /* a Moebius strip */
    SHEET_HOLES,    /* bumps, where some facets are missing */
    SHEET_CRUMPLED, /* random heights: bends of all angles */
    SHEET_TWO,      /* bumps, twice, 0.1 edges apart */
    SHEET_KINDS
};

/** Make a sheet of a kind, of some 30 to 200 facets, to be freed by planish_shape_destroy. */
planish_shape *sheet_create(int kind, uint64_t *state);

/** Make a shape of triangles [n_facets][3] between nodes at x [n_nodes][3]. edge [n_edges][2]: features
 *  beside those of borders and bends. */
planish_shape *sheet_of(int64_t n_nodes, const double (*x)[3], int64_t n_facets,
                        const int32_t (*facet)[3], int64_t n_edges, const int32_t (*edge)[2]);

/** Move nodes of patches and curves to x [n_nodes][3]: each by up to far mean edges along the shape and
 *  by up to off mean edges off it; a share of them. place [n_nodes]: where they are. */
void sheet_move(const planish_shape *shape, double far, double off, double share, uint64_t *state,
                double (*x)[3], pl_place *place);

/** A surface to which distances are found by brute force. */
typedef struct sheet_judge {
    int64_t n;
    double (*corner)[3][3]; /* [n] */
    double (*middle)[3];    /* [n] */
    double *radius;         /* [n] of the corners around the middle */
    const int32_t *patch;   /* [n] of the shape */
} sheet_judge;

/** Make a judge of a shape's facets between nodes at x [n_nodes][3]. */
sheet_judge sheet_judge_create(const planish_shape *shape, const double (*x)[3]);

void sheet_judge_destroy(sheet_judge *judge);

/** Distance of a point from a patch (-1: from all). */
double sheet_judge_distance(const sheet_judge *judge, int32_t patch, const double point[3]);

/** Largest distance from a patch (-1: from all) of points of a triangle: corners of so many divisions of
 *  its sides. */
double sheet_judge_sample(const sheet_judge *judge, int32_t patch, const double corner[3][3],
                          int divisions);

/** Whether two facets of the shape of a judge meet other than at nodes and edges that they share. What
 *  touches by rounding alone does not count. */
int sheet_cross(const sheet_judge *judge, const planish_shape *shape, int64_t a, int64_t b);

/** Cosine between two facets. */
double sheet_cosine(const sheet_judge *judge, int32_t a, int32_t b);

/** Distance of a point from the segment from a to b. */
double sheet_from_segment(const double a[3], const double b[3], const double point[3]);

#endif
