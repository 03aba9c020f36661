/* arithmetic: floating-point environments that a caller may have and planish must not see. */
#ifndef TEST_SUPPORT_ARITHMETIC_H
#define TEST_SUPPORT_ARITHMETIC_H

/** An environment, which set makes that of this thread. */
typedef struct test_arithmetic {
    const char *name;
    void (*set)(void);
} test_arithmetic;

/** Ends with a name that is NULL. Those that the system has no means for are not in it. */
extern const test_arithmetic test_arithmetics[];

/** The one that every process starts with. */
void test_arithmetic_reset(void);

/** Whether exceptions of this CPU can trap: those of most ARM cores cannot. */
int test_arithmetic_can_trap(void);

/** What an environment does, and the flags it has raised. */
typedef struct test_arithmetic_state {
    int rounding, flags, traps;            /* as <fenv.h> tells them */
    int is_near;                           /* doubles are rounded to the nearest */
    int flushes_results, flushes_operands; /* subnormals become 0 */
} test_arithmetic_state;

/** Of this thread; raises no flag. */
test_arithmetic_state test_arithmetic_now(void);

/** Whether doubles are rounded to the nearest, subnormals are kept, and nothing traps. */
int test_arithmetic_is_usual(void);

#endif
