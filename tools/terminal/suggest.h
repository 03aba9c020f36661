/* suggest: what a mistyped word may have meant. */
#ifndef PL_TOOLS_SUGGEST_H
#define PL_TOOLS_SUGGEST_H

/** How many letters must be put in, left out, changed or swapped with their neighbour to make b of
 *  a; a large number where one of them is too long to be a word. */
int pl_word_distance(const char *a, const char *b);

/** The nearest of several words to one that was typed. */
typedef struct pl_suggestion {
    const char *typed;
    const char *nearest; /* NULL: none is near enough */
    int distance;
} pl_suggestion;

/** Take word into account. */
void pl_suggest(pl_suggestion *suggestion, const char *word);

#endif
