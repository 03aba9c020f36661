/* snapshots: where nodes were at the end of each sweep, as a progress function asked for it. */
#include "support/snapshots.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

snapshots snapshots_begin(const double *live, size_t length) {
    snapshots s = {.live = live, .length = length};
    s.given = malloc((length + 1) * sizeof *s.given);
    s.is_set = malloc(length + 1);
    assert_true(s.given && s.is_set);
    memcpy(s.given, live, length * sizeof *live);
    return s;
}

void snapshots_free(snapshots *s) {
    for (int i = 0; i < s->n; i++)
        free(s->x[i]);
    free(s->x);
    free(s->figures);
    free(s->given);
    free(s->is_set);
}

static void make_room(snapshots *s) {
    if (s->n < s->room)
        return;
    s->room = 2 * s->room + 8;
    s->x = realloc(s->x, (size_t)s->room * sizeof *s->x);
    s->figures = realloc(s->figures, (size_t)s->room * sizeof *s->figures);
    assert_true(s->x && s->figures);
}

static void expect_refusal(const planish_progress *progress) {
    planish_error error = {.text = ""};
    double none = 0;
    assert_null(progress->positions);
    assert_int_equal(planish_progress_get_coordinates(progress, &none, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_non_null(strstr(error.text, "sweep_done"));
    assert_true(none == 0);
}

/** Take a snapshot over numbers that are none, so that those that the library sets show. */
static void take(snapshots *s, const planish_progress *progress) {
    planish_error error = {.text = ""};
    double *x = malloc((s->length + 1) * sizeof *x);
    assert_non_null(x);
    for (size_t i = 0; i < s->length; i++)
        x[i] = NAN;
    if (planish_progress_get_coordinates(progress, x, &error))
        fail_msg("%s", error.text);
    for (size_t i = 0; i < s->length; i++) {
        const int is_set = !isnan(x[i]);
        if (s->n > 0)
            assert_int_equal(is_set, s->is_set[i]);
        s->is_set[i] = (unsigned char)is_set;
        x[i] = is_set ? x[i] : s->given[i];
    }
    s->x[s->n] = x;
    s->figures[s->n++] = *progress;
}

int snapshots_take(const planish_progress *progress, void *user) {
    snapshots *s = user;
    if (!progress->sweep_done) {
        expect_refusal(progress);
        s->n_refused++;
        return 0;
    }
    make_room(s);
    take(s, progress);
    assert_memory_equal(s->live, s->given, s->length * sizeof *s->given);
    return 0;
}

void snapshots_assert_same(const snapshots *a, const snapshots *b) {
    assert_int_equal(a->n, b->n);
    assert_int_equal(a->length, b->length);
    for (int i = 0; i < a->n; i++)
        assert_memory_equal(a->x[i], b->x[i], a->length * sizeof **a->x);
}
