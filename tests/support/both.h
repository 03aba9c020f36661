/* both: tests that are run in the plane and in space. */
#ifndef TEST_SUPPORT_BOTH_H
#define TEST_SUPPORT_BOTH_H

static int test_plane = 2, test_space = 3;

/** Two rows of a table of cmocka: test with the dimension 2, and 3, where *state points. */
#define BOTH(test)                                                                                 \
    {#test " 2-D", test, NULL, NULL, &test_plane}, {                                               \
#test " 3-D", test, NULL, NULL, &test_space                                                \
    }

#endif
