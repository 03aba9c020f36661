/* promises: whether a call of planish_smooth kept what planish.h promises of it. */
#ifndef TEST_SUPPORT_PROMISES_H
#define TEST_SUPPORT_PROMISES_H

#include "support/random_calls.h"
#include "support/worth.h"

enum { PROMISE_TEXT = 300 };

/** A plan, and what the test knows of its mesh. Arrays are owned. */
typedef struct promise {
    const random_call *call;
    const planish_plan *plan;
    planish_plan_info info;
    int8_t *sign;       /* [n_elements] */
    int64_t n_doubtful; /* elements whose measures cancel: then nothing is said of elements */
    uint8_t *is_known;  /* [n_elements] to the plan */
    uint8_t *is_free;   /* [n_nodes] that planish calls free, */
    uint8_t *may_move;  /* and those that the header lets move at all */
    char text[PROMISE_TEXT];
} promise;

/** What is known before the calls, at coordinates [n_nodes][dim]. text is "" if the plan has not
 *  contradicted the header yet, else it says in what. */
void promise_create(promise *p, const random_call *call, const planish_plan *plan,
                    const double *coordinates);
void promise_destroy(promise *p);

/** Note what is broken; the first one stands. Returns 0, for short statements. */
int promise_break(promise *p, const char *format, ...) __attribute__((format(printf, 2, 3)));

/** After a call with options (of the call, or defaults) that brought before to after, both
 *  [n_nodes][dim]: NULL if all was kept, else what was not. */
const char *promise_broken(promise *p, const planish_options *options, const double *before,
                           const double *after, const planish_result *result);

/** What of the call's and the plan's options must be refused: 1; 0: nothing; -1: perhaps. */
int promise_refusal(const random_call *call);

#endif
