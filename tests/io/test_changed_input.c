/* A mesh file that another program changes while it is opened, asked and written: whatever it has
 * at which moment, the call gives a mesh that is sound in itself or says why not, and nothing else
 * than the input is left behind.
 *
 *     test_io_changed_input [OPENS [FILE]]
 *
 * A thread writes to the file all the time. Files are read into memory, as small ones are, or
 * mapped, as large ones are. Address sanitizer sees what is read or written out of bounds.
 */
#include "support/data_files.h"
#include "support/effort.h"
#include "support/files.h"

#include <planish/planish_io.h>

#include "io/core/bytes.h"
#include "io/file/file.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

static int64_t n_opens;      /* of each file */
static const char *only_one; /* name of the file, or NULL: all */

/* ---- who changes the file ---------------------------------------------------------------------
 */

typedef enum damage {
    FLIPS,       /* bytes and stretches change, through a mapping, which no time tells of at once */
    TRUNCATIONS, /* it becomes shorter and is written again */
    N_DAMAGES
} damage;

typedef struct changer {
    damage how;
    int fd;
    char *shared;         /* [size] mapped */
    const char *original; /* [size] */
    size_t size;
    uint64_t random;
    atomic_int has_begun, stop;
} changer;

static void wait_a_little(uint64_t *random, int64_t most) {
    const struct timespec pause = {0, (long)random_below(random, most)};
    nanosleep(&pause, NULL);
}

/** One of the changes that make trouble for readers: of lines, counts, numbers, words. */
static void change_at(changer *c, size_t at, size_t length) {
    static const char marks[] = "-+.eE9$*<>\"/#\0";
    const int kind = (int)random_below(&c->random, 6);
    const uint32_t word = (uint32_t)random_below(&c->random, kind % 2 ? 100 : UINT32_MAX);
    char *to = c->shared + at;
    if (kind == 0)
        memset(to, "\n 1,"[random_below(&c->random, 4)], length);
    else if (kind == 1)
        *to = (char)('0' + random_below(&c->random, 10));
    else if (kind == 2)
        *to = marks[random_below(&c->random, sizeof marks)];
    else if (kind == 3)
        memmove(to, c->shared + random_below(&c->random, (int64_t)(c->size - length)), length);
    else
        memcpy(to, &word, length < sizeof word ? length : sizeof word);
}

/** Change three places, and then back. */
static void flip(changer *c) {
    enum { PLACES = 3, LONGEST = 200 };
    for (int i = 0; i < PLACES; i++) {
        const int64_t length = 1 + random_below(&c->random, LONGEST);
        const int64_t most = (int64_t)c->size - length;
        const int64_t at = random_below(&c->random, i || most < 2000 ? most : 2000);
        change_at(c, (size_t)at, (size_t)length);
    }
    wait_a_little(&c->random, 80000);
    memcpy(c->shared, c->original, c->size);
    if (random_below(&c->random, 3) == 0)
        wait_a_little(&c->random, 60000);
}

static void truncate_and_write(changer *c) {
    const off_t left = (off_t)random_below(&c->random, (int64_t)c->size);
    if (ftruncate(c->fd, left) == 0)
        wait_a_little(&c->random, 200000);
    if (pwrite(c->fd, c->original + left, c->size - (size_t)left, left) > 0)
        wait_a_little(&c->random, 400000);
}

static void *change(void *data) {
    changer *c = data;
    atomic_store(&c->has_begun, 1);
    while (!atomic_load(&c->stop)) {
        if (c->how == FLIPS)
            flip(c);
        else
            truncate_and_write(c);
    }
    return NULL;
}

/* ---- who uses it ------------------------------------------------------------------------------
 */

typedef struct use {
    const char *path, *folder;
    int threads;
    int is_hdf5;
    int64_t largest_copy;
    int64_t n_opened, n_written;
} use;

/** Numbers of nodes are of nodes that there are, or of mids that are missing. A change may have made
 *  elements of second order. */
static void check_elements(const planish_mesh *mesh) {
    const planish_cells *cells = mesh->cells;
    const int64_t n = cells ? cells->offset[cells->n] : mesh->n_elements * (mesh->dim + 1);
    const int32_t *node = cells ? cells->node : mesh->elements;
    for (int64_t i = 0; i < n; i++)
        assert_true(node[i] >= (cells ? -1 : 0) && node[i] < mesh->n_nodes);
}

static void ask(const planish_file *file, const planish_mesh *mesh, int is_sliding) {
    const planish_hold hold = {.slide = is_sliding};
    uint8_t *constraint = malloc((size_t)mesh->n_nodes + 1);
    char text[200];
    planish_error error;
    planish_file_info info;
    planish_file_constraints(file, &hold, constraint, &error);
    planish_file_surface(file, &hold);
    planish_file_get_info(file, &info);
    for (int64_t i = 0; i < mesh->n_elements; i += 7) {
        planish_file_element_region(file, i, text, sizeof text);
        planish_file_element_number(file, i);
    }
    free(constraint);
}

/** Written with a third of the nodes moved. */
static int write_moved(const use *u, planish_file *file, const planish_mesh *mesh) {
    char path[TEST_PATH_SIZE], name[64], temporary[TEST_PATH_SIZE * 4] = "";
    double *x = planish_file_coordinates(file);
    planish_error error;
    for (int64_t i = 0; i < mesh->n_nodes * mesh->dim; i += 3)
        x[i] += 1e-3;
    snprintf(name, sizeof name, "out%s", strrchr(u->path, '.'));
    test_path(path, u->folder, name);
    const int status = planish_file_write(
        file, path, x,
        &(planish_write_options){
            .threads = u->threads, .temporary = temporary, .temporary_size = sizeof temporary},
        &error);
    assert_string_equal(temporary, "");
    assert_int_equal(access(path, F_OK) == 0, status == 0);
    unlink(path);
    return status == 0;
}

static void open_once(use *u, int64_t i) {
    planish_file *file = NULL;
    planish_error error;
    const int status =
        u->is_hdf5
            ? planish_file_open_with(u->path,
                                     &(planish_open_options){.threads = u->threads, .isolated = 1},
                                     &file, &error)
            : io_file_open(u->path, u->threads, u->largest_copy, &file, &error);
    if (status) {
        assert_null(file);
        assert_true(strlen(error.text) > 0);
        return;
    }
    const planish_mesh mesh = planish_file_mesh(file);
    check_elements(&mesh);
    ask(file, &mesh, (int)(i % 2));
    u->n_opened++;
    u->n_written += write_moved(u, file, &mesh);
    planish_file_close(file);
}

/** Open the file at u->path n times while it changes. */
static void use_changing(use *u, damage how, int64_t n, uint64_t seed) {
    changer c = {.how = how, .random = effort_seed(seed), .has_begun = 0, .stop = 0};
    pthread_t thread;
    char *original = test_read(u->path, &c.size);
    c.original = original;
    c.fd = open(u->path, O_RDWR);
    c.shared = mmap(NULL, c.size, PROT_READ | PROT_WRITE, MAP_SHARED, c.fd, 0);
    assert_true(c.shared != MAP_FAILED);
    assert_int_equal(pthread_create(&thread, NULL, change, &c), 0);
    while (!atomic_load(&c.has_begun)) /* a fork while the sanitizer makes a thread's memory has its
                                          lock held for good */
        sched_yield();
    for (int64_t i = 0; i < n; i++)
        open_once(u, i);
    atomic_store(&c.stop, 1);
    pthread_join(thread, NULL);
    munmap(c.shared, c.size);
    close(c.fd);
    free(original);
}

/** Undamaged again the file is read and written; besides it nothing is left. n_files: in the folder
 *  when that began. */
static void check_afterwards(use *u, int n_files) {
    const int64_t n = u->n_opened;
    u->n_written = 0;
    open_once(u, 0);
    assert_int_equal(u->n_opened, n + 1);
    assert_int_equal(u->n_written, 1);
    assert_int_equal(test_count_files(u->folder), n_files);
}

/* ---- the files --------------------------------------------------------------------------------
 */

static void copy_data(const char *name, const char *folder) {
    char path[TEST_PATH_SIZE];
    size_t size;
    char *data = test_read(test_path_from(path, "PLANISH_TEST_DATA", name), &size);
    test_write(folder, name, data, size);
    free(data);
}

/** All kinds of damage to the file called name in folder, read and (but for HDF5) mapped. */
static void try_file(const char *name, const char *folder, int threads, int64_t n) {
    char path[TEST_PATH_SIZE];
    use u = {.path = test_path(path, folder, name), .folder = folder, .threads = threads};
    if (only_one && strcmp(only_one, name) != 0)
        return;
    size_t size;
    char *data = test_read(path, &size);
    const int n_files = test_count_files(folder);
    u.is_hdf5 = io_is_hdf5(data, (int64_t)size);
    u.largest_copy = IO_LARGEST_COPY;
    for (damage how = 0; how < N_DAMAGES; how++)
        use_changing(&u, how, u.is_hdf5 ? (n + 3) / 4 : n, 100 * size + how);
    u.largest_copy = 0;
    if (!u.is_hdf5) /* a mapping of a file that is truncated would end the process */
        use_changing(&u, FLIPS, 2 * n, 100 * size + N_DAMAGES);
    const int64_t opened = u.n_opened, written = u.n_written;
    check_afterwards(&u, n_files);
    figure("%s: %lld of %lld times read, %lld times written", name, (long long)opened,
           (long long)(u.is_hdf5 ? (n + 3) / 4 * 2 : 4 * n), (long long)written);
    free(data);
}

static void every_format(void **state) {
    const int step = effort_step(2);
    int n = 0;
    for (const test_data_file *data = test_data_files; data->name; data++) {
        char path[TEST_PATH_SIZE];
        if (strcmp(data->format, "tetgen") == 0 || test_data_is_folder(data) || n++ % step != 0 ||
            !test_data_path(path, data))
            continue; /* tetgen, below, and folders have several files */
        copy_data(data->name, *state);
        try_file(data->name, *state, 1, n_opens);
    }
}

/** A mesh of two files: either changes. */
static void tetgen(void **state) {
    copy_data("tetgen.node", *state);
    copy_data("tetgen.ele", *state);
    const char *const names[] = {"tetgen.node", "tetgen.ele"};
    for (int i = 0; i < 2; i++) {
        char path[TEST_PATH_SIZE], other[TEST_PATH_SIZE];
        use u = {.path = test_path(path, *state, names[i]), .folder = *state, .threads = 1};
        if (only_one && strcmp(only_one, names[i]) != 0)
            continue;
        for (int mapped = 0; mapped < 2; mapped++) {
            u.largest_copy = mapped ? 0 : IO_LARGEST_COPY;
            use_changing(&u, mapped ? FLIPS : TRUNCATIONS, n_opens,
                         7u + (unsigned)(2 * i + mapped));
        }
        unlink(test_path(other, *state, "out.ele"));
        unlink(test_path(other, *state, "out.node"));
        assert_int_equal(test_count_files(*state), 2);
        figure("%s: %lld of %lld times read, %lld times written", names[i], (long long)u.n_opened,
               (long long)(2 * n_opens), (long long)u.n_written);
    }
}

/** A text that several threads read: a square of triangles as Gmsh 2.2 has it. */
static void write_large(const char *folder, const char *name, int width) {
    char path[TEST_PATH_SIZE];
    FILE *to = fopen(test_path(path, folder, name), "w");
    fprintf(to, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d\n", width * width);
    for (int i = 0; i < width * width; i++)
        fprintf(to, "%d %d.25 %d.5 0\n", i + 1, i % width, i / width);
    fprintf(to, "$EndNodes\n$Elements\n%d\n", 2 * (width - 1) * (width - 1));
    for (int i = 0, n = 0; i < (width - 1) * (width - 1); i++) {
        const int a = i / (width - 1) * width + i % (width - 1) + 1;
        fprintf(to, "%d 2 2 %d %d %d %d %d\n", ++n, i % 3, i % 3 + 1, a, a + 1, a + width + 1);
        fprintf(to, "%d 2 2 %d %d %d %d %d\n", ++n, i % 3, i % 3 + 1, a, a + width + 1, a + width);
    }
    fprintf(to, "$EndElements\n");
    fclose(to);
}

static void several_threads(void **state) {
    enum { WIDTH = 160, THREADS = 4 };
    write_large(*state, "large.msh", WIDTH);
    try_file("large.msh", *state, THREADS, (n_opens + 9) / 10);
}

/** A file that has become shorter is named. */
static void shorter_file_is_named(void **state) {
    static const char *const names[] = {"medit.mesh", "binary.vtk"};
    for (int i = 0; i < 4; i++) {
        char path[TEST_PATH_SIZE], out[TEST_PATH_SIZE];
        planish_file *file = NULL;
        planish_error error;
        size_t size;
        copy_data(names[i / 2], *state);
        test_path(path, *state, names[i / 2]);
        assert_int_equal(io_file_open(path, 1, i % 2 ? 0 : IO_LARGEST_COPY, &file, &error), 0);
        free(test_read(path, &size));
        assert_int_equal(truncate(path, (off_t)size / 2), 0);
        test_path(out, *state, i / 2 ? "out.vtk" : "out.mesh");
        assert_int_equal(planish_file_write(file, out, planish_file_coordinates(file),
                                            &(planish_write_options){.threads = 1}, &error),
                         PLANISH_ERROR_FILE);
        assert_non_null(strstr(error.text, path));
        assert_non_null(strstr(error.text, "became shorter"));
        assert_int_equal(test_count_files(*state), 1);
        planish_file_close(file);
        unlink(path);
    }
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(every_format, test_folder_create, test_folder_remove),
        cmocka_unit_test_setup_teardown(tetgen, test_folder_create, test_folder_remove),
        cmocka_unit_test_setup_teardown(several_threads, test_folder_create, test_folder_remove),
        cmocka_unit_test_setup_teardown(shorter_file_is_named, test_folder_create,
                                        test_folder_remove),
    };
    n_opens = argc > 1 ? strtoll(argv[1], NULL, 10) : effort(75, 10000);
    only_one = argc > 2 ? argv[2] : NULL;
    return cmocka_run_group_tests(tests, NULL, NULL);
}
