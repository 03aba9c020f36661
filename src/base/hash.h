/* hash: hashes of keys that files and callers choose. Each table draws a number that nobody can know who
 * made the keys, so that no keys are made to collide. Numbers differ from run to run: nothing but the
 * places in a table may depend on them.
 *
 *   pl_hash_draw    begin the hashes of a table
 *   pl_hash_add     go on with a word of a key
 *   pl_hash_end     the hash of a key
 *
 * Source: SipHash-1-3, J.-P. Aumasson and D. J. Bernstein, 2012.
 */
#ifndef PL_BASE_HASH_H
#define PL_BASE_HASH_H

#include <stdint.h>

/** State of a hash. A table keeps that of pl_hash_draw, and each key begins with a copy. */
typedef struct pl_hash {
    uint64_t v[4];
} pl_hash;

/** Return the state with which the hashes of a new table begin. table: its address. */
pl_hash pl_hash_draw(const void *table);

/** Mix the state once: SipRound. */
static inline void pl_hash_mix(pl_hash *h) {
    uint64_t *v = h->v;
    v[0] += v[1];
    v[2] += v[3];
    v[1] = (v[1] << 13 | v[1] >> 51) ^ v[0];
    v[3] = (v[3] << 16 | v[3] >> 48) ^ v[2];
    v[0] = v[0] << 32 | v[0] >> 32;
    v[2] += v[1];
    v[0] += v[3];
    v[1] = (v[1] << 17 | v[1] >> 47) ^ v[2];
    v[3] = (v[3] << 21 | v[3] >> 43) ^ v[0];
    v[2] = v[2] << 32 | v[2] >> 32;
}

/** Add a word of a key. */
static inline void pl_hash_add(pl_hash *h, uint64_t word) {
    h->v[3] ^= word;
    pl_hash_mix(h);
    h->v[0] ^= word;
}

/** Add n numbers, two as one word. */
static inline void pl_hash_add_integers(pl_hash *h, const int32_t *number, int n) {
    for (int i = 0; i + 1 < n; i += 2)
        pl_hash_add(h, (uint64_t)(uint32_t)number[i] << 32 | (uint32_t)number[i + 1]);
    if (n % 2)
        pl_hash_add(h, (uint32_t)number[n - 1]);
}

/** Return the hash of the words that have been added; all its bits are as good as random. */
static inline uint64_t pl_hash_end(pl_hash h) {
    h.v[2] ^= 0xff;
    for (int i = 0; i < 3; i++)
        pl_hash_mix(&h);
    return h.v[0] ^ h.v[1] ^ h.v[2] ^ h.v[3];
}

#endif
