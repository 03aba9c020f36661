/* suggest: what a mistyped word may have meant. */
#include "terminal/suggest.h"

#include <limits.h>
#include <string.h>

enum { WORD_SIZE = 32 };

static int least(int a, int b) {
    return a < b ? a : b;
}

int pl_word_distance(const char *a, const char *b) {
    const int n = (int)strnlen(a, WORD_SIZE), m = (int)strnlen(b, WORD_SIZE);
    int cost[WORD_SIZE][WORD_SIZE]; /* of the first i letters of a and the first j of b */
    if (n == WORD_SIZE || m == WORD_SIZE)
        return INT_MAX;
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= m; j++) {
            if (i == 0 || j == 0) {
                cost[i][j] = i + j;
                continue;
            }
            const int changed = cost[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            cost[i][j] = least(changed, 1 + least(cost[i - 1][j], cost[i][j - 1]));
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                cost[i][j] = least(cost[i][j], cost[i - 2][j - 2] + 1);
        }
    return cost[n][m];
}

void pl_suggest(pl_suggestion *suggestion, const char *word) {
    const int distance = pl_word_distance(suggestion->typed, word);
    /* One letter in three may be wrong: what shares less is another word. */
    if (distance > ((int)strlen(word) + 1) / 3)
        return;
    if (suggestion->nearest && distance >= suggestion->distance)
        return;
    suggestion->nearest = word;
    suggestion->distance = distance;
}
