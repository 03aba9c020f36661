/* Child processes: what comes back from one, whatever becomes of it; and mesh files that only such
 * a process should open. */
#include "io/core/child.h"
#include "support/files.h"
#include "support/hdf5_builder.h"

#include <planish/planish_io.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

static const io_bytes a = {.path = "a"}, a_med = {.path = "a.med"};

static int succeed(void *data, planish_error *error) {
    (void)error;
    *(int *)data = 7;
    return PLANISH_OK;
}

static int fail_here(void *data, planish_error *error) {
    (void)data;
    *error = (planish_error){.code = PLANISH_ERROR_MESH, .element = 4, .text = "no mesh"};
    return PLANISH_ERROR_MESH;
}

static int end_by(void *data, planish_error *error) {
    (void)error;
    raise(*(int *)data);
    return PLANISH_OK;
}

static int leave(void *data, planish_error *error) {
    (void)error;
    _exit(*(int *)data);
}

static int write_file(void *data, planish_error *error) {
    const int file = open(data, O_WRONLY | O_CREAT, 0600);
    (void)error;
    return file >= 0 && write(file, "done", 4) == 4 ? PLANISH_OK : PLANISH_ERROR_FILE;
}

static int count_descriptors(void) {
    DIR *folder = opendir("/proc/self/fd");
    int n = 0;
    while (folder && readdir(folder))
        n++;
    if (folder)
        closedir(folder);
    return n;
}

/** No child is left to be waited for. */
static void none_is_left(void) {
    assert_int_equal(waitpid(-1, NULL, WNOHANG), -1);
    assert_int_equal(errno, ECHILD);
}

static void result_and_files_come_back(void **state) {
    char path[TEST_PATH_SIZE];
    planish_error error = {.text = ""};
    int memory = 3;
    const int n = count_descriptors();
    assert_int_equal(io_child_run(succeed, &memory, &a, &error), PLANISH_OK);
    assert_int_equal(memory, 3);
    assert_int_equal(io_child_run(fail_here, NULL, &a, &error), PLANISH_ERROR_MESH);
    assert_int_equal(error.element, 4);
    assert_string_equal(error.text, "no mesh");
    assert_int_equal(io_child_run(fail_here, NULL, &a, NULL), PLANISH_ERROR_MESH);
    test_path(path, *state, "file");
    assert_int_equal(io_child_run(write_file, path, &a, &error), PLANISH_OK);
    char *text = test_read(path, NULL);
    assert_string_equal(text, "done");
    free(text);
    assert_int_equal(count_descriptors(), n);
    none_is_left();
}

static void any_end_is_an_error(void **state) {
    static const int signals[] = {SIGSEGV, SIGABRT, SIGBUS,  SIGFPE,
                                  SIGKILL, SIGILL,  SIGPIPE, SIGXCPU};
    const int n = count_descriptors();
    (void)state;
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
        planish_error error = {.text = ""};
        char wanted[32];
        int number = signals[i];
        assert_int_equal(io_child_run(end_by, &number, &a_med, &error), PLANISH_ERROR_FORMAT);
        snprintf(wanted, sizeof wanted, "(signal %d,", number);
        assert_non_null(strstr(error.text, wanted));
        assert_non_null(strstr(error.text, "a.med: "));
        assert_int_equal(strstr(error.text, "did not finish") != NULL, number == SIGXCPU);
    }
    for (int status = 0; status < 2; status++)
        assert_int_equal(io_child_run(leave, &status, &a_med, NULL), PLANISH_ERROR_FORMAT);
    assert_int_equal(count_descriptors(), n);
    none_is_left();
}

/** Whether a child's memory is limited: on Linux, if no emulator of another machine is between. */
static int memory_is_limited(void) {
#ifdef __linux__
    enum { PLENTY = 64 << 20 };
    struct rlimit before, none;
    getrlimit(RLIMIT_DATA, &before);
    none = before;
    none.rlim_cur = 1; /* 0 would mean any, for Valgrind */
    setrlimit(RLIMIT_DATA, &none);
    void *memory = mmap(NULL, PLENTY, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    setrlimit(RLIMIT_DATA, &before);
    return memory == MAP_FAILED || munmap(memory, PLENTY);
#else
    return 0;
#endif
}

/** What takes memory without end is told that there is no more. */
static int take_all(void *data, planish_error *error) {
    enum { PIECE = 1 << 20 };
    int64_t n = 0;
    (void)data;
    while (mmap(NULL, PIECE, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) !=
           MAP_FAILED)
        n++;
    *error = (planish_error){.code = PLANISH_ERROR_MEMORY, .element = n};
    return PLANISH_ERROR_MEMORY;
}

static void memory_has_an_end(void **state) {
    planish_error error = {.text = ""};
    const io_bytes none = {.path = "a"}, some = {.path = "a", .size = 1 << 16};
    (void)state;
    if (!memory_is_limited())
        skip();
    assert_int_equal(io_child_run(take_all, NULL, &none, &error), PLANISH_ERROR_MEMORY);
    assert_in_range(error.element, 900, 1024);
    assert_int_equal(io_child_run(take_all, NULL, &some, &error), PLANISH_ERROR_MEMORY);
    assert_in_range(error.element, 900 + 256, 1024 + 256);
}

/** What people end programs by reaches all processes of a terminal: the caller answers it. */
static void signals_of_people_are_the_callers(void **state) {
    static const int signals[] = {SIGINT, SIGTERM, SIGHUP};
    (void)state;
    for (size_t i = 0; i < sizeof signals / sizeof *signals; i++) {
        planish_error error = {.text = ""};
        int number = signals[i];
        assert_int_equal(io_child_run(end_by, &number, &a_med, &error), PLANISH_OK);
    }
    none_is_left();
}

static void ignored_children_are_no_trouble(void **state) {
    int number = SIGSEGV, memory = 0;
    (void)state;
    signal(SIGCHLD, SIG_IGN);
    assert_int_equal(io_child_run(succeed, &memory, &a, NULL), PLANISH_OK);
    assert_int_equal(io_child_run(end_by, &number, &a, NULL), PLANISH_ERROR_FORMAT);
    signal(SIGCHLD, SIG_DFL);
}

static void other_formats_need_no_child(void **state) {
    planish_file *file;
    char path[TEST_PATH_SIZE];
    (void)state;
    assert_int_equal(planish_file_open_with(test_path_from(path, "PLANISH_TEST_DATA", "medit.mesh"),
                                            &(planish_open_options){.threads = 1, .isolated = 1},
                                            &file, NULL),
                     PLANISH_OK);
    planish_file_close(file);
    assert_int_equal(planish_file_open_with("nowhere",
                                            &(planish_open_options){.threads = 1, .isolated = 1},
                                            &file, NULL),
                     PLANISH_ERROR_FILE);
}

#ifdef PL_HDF5

/** HDF5 1.10.8 looks for the name of an object outside of the local heap that should have it. */
static void what_the_library_crashes_on_is_refused(void **state) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    char path[TEST_PATH_SIZE];
    const int n = count_descriptors();
    (void)state;
    test_path_from(path, "PLANISH_TEST_DATA", "damaged.med");
    for (int named = 0; named < 2; named++) {
        assert_int_equal(
            planish_file_open_with(path,
                                   &(planish_open_options){
                                       .format = named ? "med" : NULL, .threads = 1, .isolated = 1},
                                   &file, &error),
            PLANISH_ERROR_FORMAT);
        assert_non_null(strstr(error.text, "damaged.med: "));
        assert_null(file);
    }
    assert_int_equal(count_descriptors(), n);
    none_is_left();
}

/** Its list of the free parts of a local heap leads back to itself. */
static void what_the_library_never_ends_on_is_refused(void **state) {
    planish_file *file = NULL;
    planish_error error = {.text = ""};
    char path[TEST_PATH_SIZE];
    (void)state;
    if (!memory_is_limited())
        skip();
    test_path_from(path, "PLANISH_TEST_DATA", "damaged_endless.med");
    assert_true(planish_file_open_with(path, &(planish_open_options){.threads = 1, .isolated = 1},
                                       &file, &error) < 0);
    assert_non_null(strstr(error.text, "damaged_endless.med: "));
    assert_null(file);
    none_is_left();
}

enum { N = 5 };

/** Two tetrahedra in VTKHDF, their points deflated. */
static void put_packed(const char *folder) {
    static const double points[3 * N] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
    static const int nodes[] = {0, 1, 2, 3, 1, 2, 3, 4}, ends[] = {0, 4, 8}, types[] = {10, 10};
    static const int n_points = N, n_cells = 2, n_nodes = 8;
    hdf5_builder b;
    hdf5_begin(&b, 0);
    hdf5_group(&b, "/VTKHDF");
    hdf5_text_attribute(&b, "/VTKHDF", "Type", "UnstructuredGrid");
    b.chunk[0] = N, b.chunk[1] = 3, b.is_packed = 1;
    hdf5_array(&b, "/VTKHDF/Points", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, N, 3, points);
    b.chunk[0] = 0;
    hdf5_integers(&b, "/VTKHDF/NumberOfPoints", 1, &n_points);
    hdf5_integers(&b, "/VTKHDF/NumberOfCells", 1, &n_cells);
    hdf5_integers(&b, "/VTKHDF/NumberOfConnectivityIds", 1, &n_nodes);
    hdf5_integers(&b, "/VTKHDF/Connectivity", 8, nodes);
    hdf5_integers(&b, "/VTKHDF/Offsets", 3, ends);
    hdf5_array(&b, "/VTKHDF/Types", H5T_STD_U8LE, H5T_NATIVE_INT, 2, 0, types);
    file_builder bytes = hdf5_end(&b);
    test_write(folder, "in.vtkhdf", bytes.data, (size_t)bytes.size);
    builder_release(&bytes);
}

static planish_file *open_isolated(const char *folder, const char *name) {
    planish_file *file;
    planish_error error;
    char path[TEST_PATH_SIZE];
    if (planish_file_open_with(test_path(path, folder, name),
                               &(planish_open_options){.threads = 2, .isolated = 1}, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

static void packed_coordinates_are_changed(void **state) {
    planish_error error;
    char path[TEST_PATH_SIZE];
    put_packed(*state);
    planish_file *file = open_isolated(*state, "in.vtkhdf");
    planish_file_coordinates(file)[12] = 1.25;
    if (planish_file_write(file, test_path(path, *state, "out.vtkhdf"),
                           planish_file_coordinates(file), &(planish_write_options){.threads = 2},
                           &error))
        fail_msg("%s", error.text);
    planish_file *again = open_isolated(*state, "out.vtkhdf");
    assert_memory_equal(planish_file_coordinates(again), planish_file_coordinates(file),
                        3 * N * sizeof(double));
    assert_int_equal(planish_file_write(file, "/dev/null", planish_file_coordinates(file),
                                        &(planish_write_options){.threads = 2}, &error),
                     PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, "cannot be written to a pipe"));
    planish_file_close(again);
    planish_file_close(file);
    none_is_left();
}

#endif

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(result_and_files_come_back, test_folder_create,
                                        test_folder_remove),
        cmocka_unit_test(any_end_is_an_error),
        cmocka_unit_test(memory_has_an_end),
        cmocka_unit_test(signals_of_people_are_the_callers),
        cmocka_unit_test(ignored_children_are_no_trouble),
        cmocka_unit_test(other_formats_need_no_child),
#ifdef PL_HDF5
        cmocka_unit_test(what_the_library_crashes_on_is_refused),
        cmocka_unit_test(what_the_library_never_ends_on_is_refused),
        cmocka_unit_test_setup_teardown(packed_coordinates_are_changed, test_folder_create,
                                        test_folder_remove),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
