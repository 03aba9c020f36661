/* Threads of the caller: a pool, several plans at once, parallel regions around calls. */
#include "support/meshes.h"
#include "support/run.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#ifdef _OPENMP
#include <omp.h>
#endif

#include <cmocka.h>

enum { CELLS = TEST_THREADS_CELLS };

/* ---- threads of the caller ------------------------------------------------------------------ */

typedef struct pool {
    int kind; /* 0: one after the other, 1: from the last to the first, 2: threads */
    _Atomic int calls;
} pool;

typedef struct job {
    planish_task_fn *task;
    void *data;
    int index;
} job;

static void *run_job(void *a_job) {
    job *j = a_job;
    j->task(j->data, j->index);
    return NULL;
}

static void pool_run(int n_tasks, planish_task_fn *task, void *data, void *user) {
    enum { MOST = 8 };
    pool *p = user;
    pthread_t thread[MOST];
    job jobs[MOST];
    p->calls++;
    assert_true(n_tasks <= MOST);
    for (int i = 0; i < n_tasks; i++) {
        jobs[i] = (job){task, data, p->kind == 1 ? n_tasks - 1 - i : i};
        if (p->kind < 2)
            run_job(&jobs[i]);
        else
            assert_int_equal(pthread_create(&thread[i], NULL, run_job, &jobs[i]), 0);
    }
    for (int i = 0; p->kind == 2 && i < n_tasks; i++)
        pthread_join(thread[i], NULL);
}

static void threads_may_be_the_callers(void **state) {
    (void)state;
    for (int dim = 2; dim <= 3; dim++)
        for (int which = 0; which < 2; which++) {
            test_mesh box;
            planish_options options = test_options(2);
            planish_plan *plan;
            (which ? test_tangled_box_for_threads : test_bad_box_for_threads)(&box, dim);
            options.max_sweeps = 5;
            double *expected = test_copy_of(&box.mesh);
            assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
            assert_int_equal(planish_smooth(plan, expected, &options, NULL, NULL), 0);
            planish_plan_destroy(plan);
            for (int kind = 0; kind < 3; kind++)
                for (options.threads = 1; options.threads < 6; options.threads += 2) {
                    if (which && kind == 2)
                        continue; /* untangling has very many loops, each of which makes threads */
                    pool p = {.kind = kind};
                    planish_plan_info info;
                    double *x = test_copy_of(&box.mesh);
                    options.parallel = pool_run;
                    options.parallel_user = &p;
                    options.bind = 1;
                    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
                    planish_plan_get_info(plan, &info);
                    assert_int_equal(info.threads, options.threads);
                    assert_int_equal(planish_smooth(plan, x, &options, NULL, NULL), 0);
                    planish_plan_destroy(plan);
                    assert_memory_equal(x, expected, test_bytes_of(&box.mesh));
                    assert_true((p.calls > 0) == (options.threads > 1));
                    free(x);
                }
            free(expected);
            test_mesh_destroy(&box);
        }
}

/** Several meshes at once, each on a thread of its own. */
typedef struct customer {
    test_mesh box;
    double *x, *expected;
    planish_plan *plan;
    int status;
} customer;

static void *smooth_often(void *a_customer) {
    customer *u = a_customer;
    planish_options options = test_options(2);
    options.threads = 0;
    for (int i = 0; i < 5 && !u->status; i++) {
        memcpy(u->x, u->box.mesh.coordinates, test_bytes_of(&u->box.mesh));
        u->status = planish_plan_create(&u->box.mesh, &options, &u->plan, NULL);
        if (!u->status)
            u->status = planish_smooth(u->plan, u->x, &options, NULL, NULL);
        planish_plan_destroy(u->plan);
        u->status =
            u->status ? u->status : memcmp(u->x, u->expected, test_bytes_of(&u->box.mesh)) != 0;
    }
    return NULL;
}

enum { USERS = 6 };

static void create_users(customer *users) {
    for (int i = 0; i < USERS; i++) {
        customer *u = &users[i];
        planish_plan *plan;
        u->status = 0;
        test_mesh_box(&u->box, 2 + i % 2, CELLS + i);
        test_mesh_perturb(&u->box, 0.12, (unsigned)i + 1);
        u->x = test_copy_of(&u->box.mesh);
        u->expected = test_copy_of(&u->box.mesh);
        assert_int_equal(planish_plan_create(&u->box.mesh, NULL, &plan, NULL), 0);
        assert_int_equal(planish_smooth(plan, u->expected, NULL, NULL, NULL), 0);
        planish_plan_destroy(plan);
    }
}

static void destroy_users(customer *users) {
    for (int i = 0; i < USERS; i++) {
        assert_int_equal(users[i].status, 0);
        free(users[i].x);
        free(users[i].expected);
        test_mesh_destroy(&users[i].box);
    }
}

static void meshes_may_be_smoothed_at_once(void **state) {
    (void)state;
    customer users[USERS];
    pthread_t thread[USERS];
    create_users(users);
    for (int i = 0; i < USERS; i++)
        assert_int_equal(pthread_create(&thread[i], NULL, smooth_often, &users[i]), 0);
    for (int i = 0; i < USERS; i++)
        pthread_join(thread[i], NULL);
    destroy_users(users);
}

#ifdef _OPENMP
/** And inside of a parallel region of the caller's. */
static void regions_may_be_around(void **state) {
    (void)state;
    customer users[USERS];
    create_users(users);
    for (int levels = 1; levels < 3; levels++) {
        omp_set_max_active_levels(levels);
#pragma omp parallel for num_threads(3) schedule(dynamic, 1)
        for (int i = 0; i < USERS; i++)
            smooth_often(&users[i]);
    }
    omp_set_max_active_levels(1);
    destroy_users(users);
}

/** The caller's own number of threads is what 0 means, and stays. */
static void the_number_of_threads_is_the_callers(void **state) {
    (void)state;
    test_mesh box;
    planish_plan *plan;
    planish_plan_info info;
    planish_options options = test_options(2);
    test_mesh_box(&box, 3, 16);
    options.threads = 0;
    omp_set_num_threads(3);
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    planish_plan_get_info(plan, &info);
    assert_int_equal(info.threads, 3);
    planish_plan_destroy(plan);
    assert_int_equal(omp_get_max_threads(), 3);
    test_mesh_destroy(&box);

    /* A small mesh is not worth more than one. */
    test_mesh_box(&box, 3, 4);
    assert_int_equal(planish_plan_create(&box.mesh, &options, &plan, NULL), 0);
    planish_plan_get_info(plan, &info);
    assert_int_equal(info.threads, 1);
    planish_plan_destroy(plan);
    test_mesh_destroy(&box);
}
#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_may_be_the_callers),
        cmocka_unit_test(meshes_may_be_smoothed_at_once),
#ifdef _OPENMP
        cmocka_unit_test(regions_may_be_around),
        cmocka_unit_test(the_number_of_threads_is_the_callers),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
