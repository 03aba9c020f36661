/* Threads and places, on made-up machines: HWLOC_SYNTHETIC stands for a topology that is not
 * this system's, so nothing may be bound to it. */
#define _GNU_SOURCE /* cpu_set_t */
#include "plan/placement.h"

#include <planish/planish.h>

#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** Stand on a made-up machine; NULL: on this one. */
static void change_machine(const char *description) {
    pl_placement_forget_machine();
    if (description)
        setenv("HWLOC_SYNTHETIC", description, 1);
    else
        unsetenv("HWLOC_SYNTHETIC");
}

/** Whether the library was built with it: then it knows another machine's cores, too. */
static int has_hwloc(void) {
    change_machine("core:2 pu:1");
    pl_placement *placement = pl_placement_create(2, 1);
    const int known = pl_placement_cpu(placement, 0) >= 0;
    pl_placement_destroy(placement);
    change_machine(NULL);
    return known;
}

static void threads_asked_for_are_given(void **state) {
    (void)state;
    if (!planish_has_feature(PLANISH_FEATURE_OPENMP))
        skip();
    for (int threads = 1; threads < 9; threads++) {
        pl_placement *placement = pl_placement_create(threads, 0);
        assert_int_equal(placement->threads, threads);
        assert_string_equal(placement->text, "not bound");
        pl_placement_destroy(placement);
    }
}

/** Of two sockets with four cores of two hardware threads: one hardware thread of each core, one
 *  socket before the other; and only if there are as many threads as cores. */
static void cores_come_before_hardware_threads(void **state) {
    (void)state;
    if (!planish_has_feature(PLANISH_FEATURE_OPENMP))
        skip();
    const int hwloc = has_hwloc();
    change_machine("package:2 numanode:1 core:4 pu:2");
    for (int threads = 1; threads < 12; threads++) {
        pl_placement *placement = pl_placement_create(threads, 1);
        assert_int_equal(placement->threads, threads);
        const int chosen = hwloc && threads == 8;
        for (int t = 0; t < threads; t++)
            assert_int_equal(pl_placement_cpu(placement, t), chosen ? 2 * t : -1);
        pl_placement_destroy(placement);
    }
    change_machine(NULL);
}

static void other_machines_are_never_bound_to(void **state) {
    (void)state;
    cpu_set_t before, inside;
    pl_placement *all = pl_placement_create(0, 0);
    change_machine("core:1 pu:1");
    pl_placement *placement = pl_placement_create(0, 1); /* nor counted on */
    assert_int_equal(placement->threads, all->threads);
    pl_placement_destroy(placement);
    pl_placement_destroy(all);
    change_machine("package:2 core:4 pu:2");
    placement = pl_placement_create(8, 1);
    assert_string_equal(placement->text, "not bound");
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    pl_placement_enter(placement);
    assert_int_equal(sched_getaffinity(0, sizeof inside, &inside), 0);
    pl_placement_leave(placement);
    assert_true(CPU_EQUAL(&before, &inside));
    pl_placement_destroy(placement);
    change_machine(NULL);
}

/** Memory is near to all threads where there is one, or one NUMA node; but not where nobody looks.
 */
static void memory_is_near(void **state) {
    (void)state;
    static const struct {
        const char *machine;
        int is_near;
    } some[] = {{"numanode:1 core:4 pu:2", 1},
                {"package:2 numanode:1 core:4 pu:2", 0},
                {"package:1 numanode:4 core:2 pu:1", 0},
                {"core:8 pu:1", 1}};
    if (!planish_has_feature(PLANISH_FEATURE_OPENMP))
        skip();
    const int hwloc = has_hwloc();
    for (size_t i = 0; i < sizeof some / sizeof *some; i++) {
        change_machine(some[i].machine);
        for (int threads = 1; threads < 9; threads++)
            for (int bind = 0; bind < 2; bind++) {
                pl_placement *placement = pl_placement_create(threads, bind);
                assert_int_equal(placement->is_near,
                                 threads == 1 || (hwloc && bind && some[i].is_near));
                pl_placement_destroy(placement);
            }
    }
    change_machine(NULL);
}

/** One thread on one core has nowhere else to go. */
static void one_thread_is_not_bound(void **state) {
    (void)state;
    change_machine("core:1 pu:2");
    pl_placement *placement = pl_placement_create(1, 1);
    assert_string_equal(placement->text, "not bound");
    assert_int_equal(pl_placement_cpu(placement, 0), -1);
    pl_placement_destroy(placement);
    change_machine(NULL);
}

/** Bound while inside, as before afterwards. */
static void binding_is_undone(void **state) {
    (void)state;
    cpu_set_t before, inside, after;
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    pl_placement *placement = pl_placement_create(0, 1);
    pl_placement_enter(placement);
    assert_int_equal(sched_getaffinity(0, sizeof inside, &inside), 0);
    pl_placement_leave(placement);
    assert_int_equal(sched_getaffinity(0, sizeof after, &after), 0);
    if (pl_placement_cpu(placement, 0) >= 0) {
        char first[64]; /* of the list that is told: the lowest CPU, which is that of one core */
        int lowest = pl_placement_cpu(placement, 0);
        for (int t = 1; t < placement->threads; t++)
            lowest =
                pl_placement_cpu(placement, t) < lowest ? pl_placement_cpu(placement, t) : lowest;
        snprintf(first, sizeof first, "one thread per core, on CPUs %d", lowest);
        assert_int_equal(CPU_COUNT(&inside), 1);
        assert_non_null(strstr(placement->text, first));
    } else
        assert_true(CPU_EQUAL(&before, &inside));
    assert_true(CPU_EQUAL(&before, &after));
    pl_placement_destroy(placement);
}

/** Only the CPUs that the process may use are counted. */
static void the_cpuset_is_respected(void **state) {
    (void)state;
    const int hwloc = has_hwloc();
    cpu_set_t before, one;
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    CPU_ZERO(&one);
    for (size_t cpu = 0; CPU_COUNT(&one) == 0; cpu++)
        if (CPU_ISSET(cpu, &before))
            CPU_SET(cpu, &one);
    assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
    pl_placement *placement = pl_placement_create(0, 1);
    if (hwloc)
        assert_int_equal(placement->threads, 1);
    pl_placement_destroy(placement);
    assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
}

/** Wherever it is: that is the core of the first thread, and the others have the other cores. The
 *  system may move it at any time, so that it has several tries. */
static void the_caller_stays_on_its_core(void **state) {
    enum { TRIES = 100 };
    (void)state;
    cpu_set_t before, one;
    change_machine(NULL);
    assert_int_equal(sched_getaffinity(0, sizeof before, &before), 0);
    pl_placement *placement = pl_placement_create(0, 1);
    const int threads = placement->threads, binds = pl_placement_cpu(placement, 0) >= 0;
    pl_placement_destroy(placement);
    if (!binds || threads < CPU_COUNT(&before)) /* two hardware threads of one core would do */
        skip();
    for (size_t cpu = 0; cpu < CPU_SETSIZE; cpu++) {
        int stays = !CPU_ISSET(cpu, &before);
        for (int i = 0; i < TRIES && !stays; i++) {
            cpu_set_t all;
            CPU_ZERO(&one);
            CPU_SET(cpu, &one);
            assert_int_equal(sched_setaffinity(0, sizeof one, &one), 0);
            assert_int_equal(sched_setaffinity(0, sizeof before, &before), 0);
            placement = pl_placement_create(0, 1);
            CPU_ZERO(&all);
            for (int t = 0; t < threads; t++)
                CPU_SET((size_t)pl_placement_cpu(placement, t), &all);
            assert_true(CPU_EQUAL(&all, &before));
            stays = pl_placement_cpu(placement, 0) == (int)cpu;
            pl_placement_destroy(placement);
        }
        assert_true(stays);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_asked_for_are_given),
        cmocka_unit_test(cores_come_before_hardware_threads),
        cmocka_unit_test(other_machines_are_never_bound_to),
        cmocka_unit_test(memory_is_near),
        cmocka_unit_test(one_thread_is_not_bound),
        cmocka_unit_test(the_cpuset_is_respected), /* before there are threads of another set */
        cmocka_unit_test(binding_is_undone),
        cmocka_unit_test(the_caller_stays_on_its_core),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
