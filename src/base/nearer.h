/* nearer: suggestions for mistyped words. */
#ifndef PL_BASE_NEARER_H
#define PL_BASE_NEARER_H

/** Return the word that typed is nearer to: word, if few letters differ and fewer than with nearest
 *  (NULL: none so far), else nearest. */
const char *pl_nearer(const char *typed, const char *nearest, const char *word);

#endif
