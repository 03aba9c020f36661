/* picture_start: which bad elements of a picture are seen at first. */
#include "report/picture_start.h"

#include "report/bytes.h"

double pl_picture_start(const pl_picture *picture) {
    enum { FEW = 10 };
    const double usual = 3;
    double worst = 1, start = 1;
    for (int i = 0; i < picture->n_states; i++) {
        const pl_drawn_state *s = &picture->states[i];
        const double first = s->n_bad > 0 ? pl_bytes_get_float(s->bad_ratio) : 1;
        double ratio = first;
        if (!(first > 0) || first > usual)
            return usual;
        for (int64_t k = FEW; k < s->n_bad && ratio == first; k++)
            ratio = pl_bytes_get_float(s->bad_ratio + 4 * k);
        if (first > worst) {
            worst = first;
            start = ratio < first ? ratio : 1;
        }
    }
    return start;
}
