/* stages: invalid elements in clusters, with more and more nodes; poor elements. */
#include "improve/mend/stages.h"

#include "base/memory.h"
#include "base/status.h"
#include "improve/mend/cluster.h"

#include <math.h>

enum {
    STAGES = 4,       /* of untangling: with more and more nodes */
    EFFORT = 2000,    /* visits that untangling may take in all, */
    EFFORT_EACH = 300 /* and so many more for each invalid element */
};

/** The work. Arrays are owned. */
typedef struct mending {
    pl_mend *curve;
    pl_cluster cluster;
    int moves_corners;
    uint8_t *tried; /* [elements of the plan] 1 + stage in which they were not mended */
    int64_t effort; /* visits that untangling may still take */
} mending;

/** Make the cluster of the invalid elements that share free nodes with seed, for a stage of
 *  untangling. */
static void gather(mending *m, int64_t seed, int stage) {
    pl_mend *curve = m->curve;
    pl_cluster *c = &m->cluster;
    pl_cluster_empty(c);
    pl_cluster_add_element(c, (int32_t)seed);
    for (int64_t i = 0; i < c->n_elements; i++) /* grows meanwhile */
        if (!curve->is_given_up[c->element[i]] && pl_mend_decide(curve, c->element[i]) != PL_VALID)
            pl_cluster_add_nodes(c, c->element[i], m->moves_corners && stage > 0);
    for (int ring = 2; ring <= stage; ring++) {
        const int64_t n = c->n_elements;
        for (int64_t i = 0; i < n; i++)
            pl_cluster_add_nodes(c, c->element[i], m->moves_corners);
    }
    pl_cluster_begin(c);
}

/** Untangle the cluster, and smooth it if fewer elements are invalid; else all nodes return. Returns
 *  whether fewer are. */
static int mend_cluster(mending *m) {
    pl_mend *curve = m->curve;
    pl_cluster *c = &m->cluster;
    if (c->n_handles == 0 || curve->lacks_memory)
        return 0;
    pl_cluster_untangle(c, &m->effort);
    const int is_taken = !curve->lacks_memory && pl_cluster_can_be_taken(c, 0);
    if (is_taken) {
        pl_cluster_save(c);
        pl_cluster_note_valid(c);
        pl_cluster_smooth(c);
    }
    if (!is_taken || curve->lacks_memory || !pl_cluster_can_be_taken(c, 1))
        pl_cluster_restore(c);
    return is_taken;
}

/** Note that the invalid elements of the cluster of seed have been tried in a stage. Returns the worst of
 *  them. */
static int64_t note_tried(mending *m, int64_t seed, int stage) {
    const pl_cluster *c = &m->cluster;
    int64_t worst = seed;
    double lowest = INFINITY;
    for (int64_t i = 0; i < c->n_elements && !m->curve->lacks_memory; i++) {
        const int32_t element = c->element[i];
        if (c->was_valid[i] || m->curve->is_given_up[element])
            continue;
        const double quality = pl_mend_quality(m->curve, element);
        m->tried[element] = (uint8_t)(stage + 1);
        worst = quality < lowest ? element : worst;
        lowest = fmin(quality, lowest);
    }
    return worst;
}

/** Mend the invalid elements that are not given up, in one stage. Once a cluster has failed it is not
 *  tried again, or (gives_up) not without another element that is given up: the worst. */
static void mend_stage(mending *m, int stage, int gives_up) {
    pl_mend *curve = m->curve;
    for (int64_t i = 0; i < curve->watch->n; i++) {
        const int64_t element = pl_mend_watched_invalid(curve, i);
        while (element >= 0 && !curve->is_given_up[element] &&
               pl_mend_decide(curve, element) != PL_VALID &&
               (gives_up || m->tried[element] != stage + 1) && m->effort > 0) {
            if (curve->lacks_memory || pl_limit_is_reached(curve->limit))
                return;
            gather(m, element, stage);
            if (mend_cluster(m))
                continue;
            const int64_t worst = note_tried(m, element, stage);
            if (!gives_up)
                break;
            curve->is_given_up[worst] = 1;
        }
    }
}

int pl_mend_invalid(pl_mend *c, int moves_corners, planish_error *error) {
    const int last = moves_corners ? STAGES - 1 : 0;
    mending m = {.curve = c,
                 .moves_corners = moves_corners,
                 .tried = pl_alloc_zero(c->plan->work.n_elements, 1),
                 .effort = EFFORT};
    int status = pl_cluster_create(c, &m.cluster, error);
    if (status || !m.tried)
        c->lacks_memory = 1;
    for (int64_t i = 0; i < c->watch->n; i++)
        m.effort += pl_mend_watched_invalid(c, i) >= 0 ? EFFORT_EACH : 0;
    for (int stage = 0; stage <= last && !c->lacks_memory; stage++)
        mend_stage(&m, stage, 0);
    if (!c->lacks_memory)
        mend_stage(&m, last, 1);
    if (c->lacks_memory)
        status = pl_fail_memory(error, "curved elements");
    pl_cluster_destroy(&m.cluster);
    pl_free(m.tried);
    return status;
}

int pl_mend_poor(pl_mend *curve, planish_error *error) {
    pl_cluster c;
    int status = pl_cluster_create(curve, &c, error);
    for (int64_t i = 0; !status && i < curve->watch->n; i++) {
        const int64_t element = pl_mend_watched(curve, i);
        if (element >= 0 && pl_mend_quality(curve, element) < curve->options->curve_quality)
            pl_cluster_add_nodes(&c, element, 0);
    }
    if (!status)
        pl_cluster_begin(&c);
    if (!status && !curve->lacks_memory)
        pl_cluster_smooth(&c);
    if (!status && !curve->lacks_memory)
        pl_cluster_restore_invalid(&c);
    if (!status && curve->lacks_memory)
        status = pl_fail_memory(error, "curved elements");
    pl_cluster_destroy(&c);
    return status;
}
