/* Hashes: those of SipHash-1-3, and of each table others. */
#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/** Begin with the key 0. */
static pl_hash begin(void) {
    return (pl_hash){{UINT64_C(0x736f6d6570736575), UINT64_C(0x646f72616e646f6d),
                      UINT64_C(0x6c7967656e657261), UINT64_C(0x7465646279746573)}};
}

/* What PYTHONHASHSEED=0 python3.11 says of hash(b"\1\2\3\4\5\6\7\10") and of hash(bytes(range(16))). */
static void test_values(void **state) {
    pl_hash one = begin(), two = begin();
    (void)state;
    pl_hash_add(&one, UINT64_C(0x0807060504030201));
    pl_hash_add(&one, UINT64_C(8) << 56); /* bytes */
    assert_true(pl_hash_end(one) == UINT64_C(0x884ccc87cb0e5fb0));
    pl_hash_add(&two, UINT64_C(0x0706050403020100));
    pl_hash_add(&two, UINT64_C(0x0f0e0d0c0b0a0908));
    pl_hash_add(&two, UINT64_C(16) << 56);
    assert_true(pl_hash_end(two) == UINT64_C(0x8972188433a5c5b7));
}

static void test_integers(void **state) {
    static const int32_t number[] = {-1, 2, 3};
    (void)state;
    for (int n = 0; n <= 3; n++) {
        pl_hash all = begin(), single = begin();
        pl_hash_add_integers(&all, number, n);
        if (n > 1)
            pl_hash_add(&single, UINT64_C(0xffffffff00000002));
        if (n % 2)
            pl_hash_add(&single, n == 1 ? UINT32_MAX : 3);
        assert_true(pl_hash_end(all) == pl_hash_end(single));
    }
}

static void test_tables(void **state) {
    enum { TABLES = 100 };
    uint64_t hash[TABLES];
    (void)state;
    for (int i = 0; i < TABLES; i++) {
        hash[i] = pl_hash_end(pl_hash_draw(&hash[i]));
        for (int k = 0; k < i; k++)
            assert_true(hash[k] != hash[i]);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_values),
        cmocka_unit_test(test_integers),
        cmocka_unit_test(test_tables),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
