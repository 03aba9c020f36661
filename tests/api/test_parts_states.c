/* Elements of a mesh that several processes have: which are bad is found as in one. */
#include "support/meshes.h"
#include "support/processes.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/** States of the elements of a mesh, as planish_check_volumes, planish_find_infeasible and
 *  planish_find_reversed say. */
typedef struct states {
    const double *spoilt;       /* coordinates, of the whole mesh */
    uint8_t *below, *unfixable; /* [n_elements], of the whole mesh */
    uint8_t *reversed;          /* [n_elements] likewise */
    int64_t n_reversed;
    planish_options options;
} states;

/** Of mesh, whose nodes and elements have these numbers (NULL: their own): the worst that is known
 *  of each element. */
static void find_states(const planish_mesh *mesh, const int64_t *node_number,
                        const int64_t *element_number, states *s) {
    const int dim = mesh->dim;
    double *x = malloc((size_t)mesh->n_nodes * (size_t)dim * sizeof *x);
    uint8_t *below = malloc((size_t)mesh->n_elements),
            *unfixable = malloc((size_t)mesh->n_elements),
            *reversed = malloc((size_t)mesh->n_elements);
    planish_plan *plan;
    int64_t n, n_undecided = -1;
    for (int64_t i = 0; i < mesh->n_nodes; i++)
        memcpy(x + i * dim, s->spoilt + (node_number ? node_number[i] : i) * dim,
               (size_t)dim * sizeof *x);
    assert_int_equal(planish_plan_create(mesh, &s->options, &plan, NULL), 0);
    assert_int_equal(planish_check_volumes(plan, x, &s->options, below, &n, NULL, NULL), 0);
    assert_int_equal(
        planish_find_infeasible(plan, x, &s->options, unfixable, &n, &n_undecided, NULL), 0);
    assert_int_equal(n_undecided, 0);
    assert_int_equal(planish_find_reversed(plan, x, reversed, &s->n_reversed, NULL), 0);
    for (int64_t i = 0; i < mesh->n_elements; i++) {
        const int64_t at = element_number ? element_number[i] : i;
        s->reversed[at] |= reversed[i];
        if (below[i] > s->below[at])
            s->below[at] = below[i];
        if (unfixable[i] > s->unfixable[at])
            s->unfixable[at] = unfixable[i];
    }
    planish_plan_destroy(plan);
    free(x);
    free(below);
    free(unfixable);
    free(reversed);
}

static int go_on(const planish_progress *progress, void *user) {
    (void)progress;
    (void)user;
    return 0;
}

/** Find the states of a part. As with planish-mpi only one process has a callback: all search with
 *  a limit all the same, or they would wait for each other for ever. */
static void find_states_of_part(process *part, void *user) {
    static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER;
    states *all = user, mine = *all;
    const size_t n = 100000; /* more than there are */
    mine.below = calloc(n, 1);
    mine.unfixable = calloc(n, 1);
    mine.reversed = calloc(n, 1);
    mine.options.progress = part->rank == 0 ? go_on : NULL;
    find_states(&part->mesh, part->node_number, part->element_number, &mine);
    pthread_mutex_lock(&turn);
    for (int64_t i = 0; i < part->mesh.n_elements; i++) {
        const int64_t at = part->element_number[i];
        all->below[at] = mine.below[at] > all->below[at] ? mine.below[at] : all->below[at];
        all->unfixable[at] |= mine.unfixable[at];
        all->reversed[at] |= mine.reversed[at];
    }
    all->n_reversed = mine.n_reversed; /* every process counts those of all */
    pthread_mutex_unlock(&turn);
    free(mine.below);
    free(mine.unfixable);
    free(mine.reversed);
}

/** What all processes together know of elements that are inverted, or below their minimum volume,
 * is what one knows that has them all. */
static void bad_elements_are_found_together(void **state) {
    const int dim = *(int *)*state;
    int64_t n_infeasible = 0, n_unfixable = 0, n_reversed = 0;
    for (int i = 0; i < 4; i++) {
        test_mesh m;
        int owner[1000];
        processes w;
        unsigned seed = (unsigned)i + 1;
        test_mesh_box(&m, dim, dim == 3 ? 4 : 9);
        const int64_t values = m.mesh.n_nodes * dim;
        double *spoilt = malloc((size_t)values * sizeof *spoilt);
        for (int64_t k = 0; k < values; k++)
            spoilt[k] = m.coordinates[k] + (dim == 3 ? 0.8 : 1.6) * (test_random(&seed) - 0.5);
        states whole = {.spoilt = spoilt}, parts = {.spoilt = spoilt};
        planish_options_init(&whole.options);
        whole.options.threads = 1;
        whole.options.min_volume = 0.3;
        parts.options = whole.options;
        uint8_t *state_of[6];
        for (int k = 0; k < 6; k++)
            state_of[k] = calloc((size_t)m.mesh.n_elements, 1);
        whole.below = state_of[0], whole.unfixable = state_of[1];
        parts.below = state_of[2], parts.unfixable = state_of[3];
        whole.reversed = state_of[4], parts.reversed = state_of[5];
        find_states(&m.mesh, NULL, NULL, &whole);
        processes_own(&m.mesh, SCATTERED, 3, 0, owner);
        processes_create(&w, &m.mesh, 3, owner);
        processes_run(&w, find_states_of_part, &parts);
        assert_memory_equal(whole.below, parts.below, (size_t)m.mesh.n_elements);
        assert_memory_equal(whole.unfixable, parts.unfixable, (size_t)m.mesh.n_elements);
        assert_memory_equal(whole.reversed, parts.reversed, (size_t)m.mesh.n_elements);
        assert_int_equal(whole.n_reversed, parts.n_reversed);
        n_reversed += whole.n_reversed;
        for (int64_t k = 0; k < m.mesh.n_elements; k++) {
            n_infeasible += whole.below[k] == PLANISH_VOLUME_INFEASIBLE;
            n_unfixable += whole.unfixable[k];
        }
        for (int k = 0; k < 6; k++)
            free(state_of[k]);
        processes_destroy(&w);
        test_mesh_destroy(&m);
        free(spoilt);
    }
    assert_true(n_infeasible > 0 && n_unfixable > 0 && n_reversed > 0);
}

int main(void) {
    static int dims[] = {2, 3};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate(bad_elements_are_found_together, &dims[0]),
        cmocka_unit_test_prestate(bad_elements_are_found_together, &dims[1]),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
