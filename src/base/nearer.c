/* nearer: suggestions for mistyped words. */
#include "base/nearer.h"

#include <stddef.h>
#include <string.h>

/** Letters between what two words begin with and what they end with: of the longer of them. */
static size_t difference_of(const char *a, const char *b) {
    const size_t n = strlen(a), m = strlen(b), most = n > m ? n : m, least = n > m ? m : n;
    size_t first = 0, last = 0;
    while (first < least && a[first] == b[first])
        first++;
    while (last < least - first && a[n - 1 - last] == b[m - 1 - last])
        last++;
    const int is_swap =
        n == m && most - first - last == 2 && a[first] == b[first + 1] && a[first + 1] == b[first];
    return most - first - last - (size_t)is_swap;
}

const char *pl_nearer(const char *typed, const char *nearest, const char *word) {
    const size_t difference = difference_of(typed, word);
    /* One letter in three may be wrong: what shares less is another word. */
    if (difference > (strlen(word) + 1) / 3)
        return nearest;
    return !nearest || difference < difference_of(typed, nearest) ? word : nearest;
}
