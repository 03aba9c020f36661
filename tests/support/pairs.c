/* pairs: which pairs of levels of any two factors have occurred together. */
#include "support/pairs.h"

#include "support/effort.h"

#include <stdio.h>

static int draw(const pairs_factor *factor, uint64_t *state) {
    int total = 0, level = 0;
    for (int i = 0; i < PAIRS_MAX_LEVELS; i++)
        total += factor->weight[i];
    for (int64_t at = random_below(state, total); at >= factor->weight[level]; level++)
        at -= factor->weight[level];
    return level;
}

void pairs_draw(const pairs *p, uint64_t *state, int *level) {
    for (int i = 0; i < p->n_factors; i++)
        level[i] = draw(&p->factor[i], state);
}

void pairs_note(pairs *p, const int *level) {
    for (int a = 0; a < p->n_factors; a++)
        for (int b = a + 1; b < p->n_factors; b++)
            p->seen[a][b][level[a]][level[b]] = 1;
}

/** Of factors a and b. */
static int64_t count(const pairs *p, pairs_allowed_fn *allowed, int a, int b, int say,
                     int64_t *missing) {
    int64_t n = 0;
    for (int i = 0; i < PAIRS_MAX_LEVELS; i++)
        for (int j = 0; j < PAIRS_MAX_LEVELS; j++) {
            if (p->factor[a].weight[i] == 0 || p->factor[b].weight[j] == 0 || !allowed(a, i, b, j))
                continue;
            n++;
            *missing += !p->seen[a][b][i][j];
            if (say && !p->seen[a][b][i][j])
                printf("never together: %s %d and %s %d\n", p->factor[a].name, i, p->factor[b].name,
                       j);
        }
    return n;
}

int64_t pairs_count(const pairs *p, pairs_allowed_fn *allowed, int say, int64_t *missing) {
    int64_t n = 0;
    *missing = 0;
    for (int a = 0; a < p->n_factors; a++)
        for (int b = a + 1; b < p->n_factors; b++)
            n += count(p, allowed, a, b, say, missing);
    return n;
}
