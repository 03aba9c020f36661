/* Writing: nothing but the coordinates that changed is another byte, and files are replaced whole
 * or not at all. */
#include "support/files.h"
#include "support/reading.h"

#include "io/file/file.h"

#include <fcntl.h>
#include <math.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

static const char small[] =
    "MeshVersionFormatted 2\n# \xc3\xa9t\xc3\xa9\nDimension\t3\r\n\nVertices 5\n"
    "0 0 0 1\n1.0 00.0e0   0 1 # a comment\n\t0 1 # 2 3\n  1e0 1\n"
    "+.5 .25 -0 9 5. 6. 7. 0\nTetrahedra\n1\n1 2 3 4 7\n"
    "Comment 5. 6. 7.\nEnd\nafter the end 5.";

static planish_file *open_file(const char *path, int threads) {
    planish_file *file = NULL;
    planish_error error;
    if (planish_file_open(path, NULL, threads, &file, &error))
        fail_msg("%s", error.text);
    return file;
}

static void write_file(const planish_file *file, const char *path, const double *coordinates,
                       int threads) {
    char temporary[TEST_PATH_SIZE] = "";
    planish_error error;
    if (planish_file_write(file, path, coordinates,
                           &(planish_write_options){.threads = threads,
                                                    .temporary = temporary,
                                                    .temporary_size = sizeof temporary},
                           &error))
        fail_msg("%s", error.text);
    assert_string_equal(temporary, "");
}

/** Open the small mesh as in.mesh of the folder. */
static planish_file *open_small(void **state) {
    char path[TEST_PATH_SIZE];
    test_write(*state, "in.mesh", small, strlen(small));
    return open_file(test_path(path, *state, "in.mesh"), 1);
}

static void check_content(const char *path, const char *expected) {
    char *content = test_read(path, NULL);
    assert_string_equal(content, expected);
    free(content);
}

/** The small mesh with the text from (which occurs once) replaced; to be freed. */
static char *small_with(const char *from, const char *to) {
    const char *at = strstr(small, from);
    assert_non_null(at);
    char *text = malloc(sizeof small + strlen(to));
    assert_non_null(text);
    sprintf(text, "%.*s%s%s", (int)(at - small), small, to, at + strlen(from));
    return text;
}

/* ---- bytes -------------------------------------------------------------------------------- */

static void only_what_changed_is_rewritten(void **state) {
    static const struct {
        int component; /* of all [n_nodes][dim] */
        double value;
        const char *from, *to;
    } cases[] = {
        {4, 0.1, "1.0 00.0e0   0 1", "1.0 0.1   0 1"},
        {3, -1.0 / 3, "1.0 00.0e0", "-0.3333333333333333 00.0e0"},
        {8, 1e-300, "  1e0 1\n+.5", "  1e-300 1\n+.5"}, /* comments between */
        {9, 3, "+.5 .25", "3 .25"},
        {14, 7.25, "6. 7. 0\n", "6. 7.25 0\n"},
        {0, 0.0, "", ""}, /* no change: the same bytes */
        {11, -0.0, "", ""},
        {11, 0.0, ".25 -0 9", ".25 0 9"}, /* zeros have signs, which are bits */
        {0, -0.0, "\n0 0 0 1", "\n-0 0 0 1"},
    };
    char path[TEST_PATH_SIZE];
    planish_file *file = open_small(state);
    double *coordinates = planish_file_coordinates(file), before[15];
    memcpy(before, coordinates, sizeof before);
    test_path(path, *state, "out.mesh");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char *expected = small_with(cases[i].from, cases[i].to);
        memcpy(coordinates, before, sizeof before);
        coordinates[cases[i].component] = cases[i].value;
        write_file(file, path, coordinates, 1);
        check_content(path, expected);
        free(expected);
    }
    planish_file_close(file);
}

static void floats_in_as_many_digits_as_they_need(void **state) {
    static const char text[] = "MeshVersionFormatted 1 Dimension 2 Vertices 3 0 0 0 1 0 0 .3 .7 0 "
                               "Triangles 1 1 2 3 0";
    char path[TEST_PATH_SIZE];
    test_write(*state, "in.mesh", text, strlen(text));
    planish_file *file = open_file(test_path(path, *state, "in.mesh"), 1);
    planish_file_info info;
    planish_file_get_info(file, &info);
    if (info.precision == PLANISH_PRECISION_FLOAT) {
        volatile float tenth = 0.1f;
        planish_file_coordinates(file)[4] = tenth;
        write_file(file, test_path(path, *state, "out.mesh"), planish_file_coordinates(file), 1);
        char *content = test_read(path, NULL);
        assert_non_null(strstr(content, "1 0 0 0.1 .7 0 Tri"));
        free(content);
    }
    planish_file_close(file);
}

static int is_space(char c) {
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/** Tokens that differ between two texts; all else must be the same. */
static int64_t count_other_tokens(const char *a, const char *b) {
    int64_t count = 0;
    for (;;) {
        while (is_space(*a) && *a == *b) {
            a++;
            b++;
        }
        if (is_space(*a) || is_space(*b))
            fail_msg("white space differs before '%.20s' and '%.20s'", a, b);
        if (!*a || !*b)
            break;
        size_t m = strcspn(a, " \t\n\v\f\r"), n = strcspn(b, " \t\n\v\f\r");
        count += m != n || memcmp(a, b, m) != 0;
        a += m;
        b += n;
    }
    assert_true(!*a && !*b);
    return count;
}

/** Bytes that differ outside of the coordinates in binary spans, which are overwritten. */
static void check_binary(const io_model *model, char *a, char *b, size_t size_a, size_t size_b) {
    assert_int_equal(size_a, size_b);
    for (int64_t i = 0; i < model->n_spans; i++) {
        const io_span *span = &model->span[i];
        size_t bytes = (size_t)model->dim * (span->encoding == IO_FLOAT32 ? 4 : 8);
        for (int64_t j = 0; j < span->n_nodes; j++) {
            memset(a + span->offset + j * span->stride, 0, bytes);
            memset(b + span->offset + j * span->stride, 0, bytes);
        }
    }
    assert_memory_equal(a, b, size_a);
}

/** Move about every third node; the number of components that changed. */
static int64_t move_nodes(planish_file *file) {
    planish_mesh mesh = planish_file_mesh(file);
    planish_file_info info;
    planish_file_get_info(file, &info);
    double *coordinates = planish_file_coordinates(file);
    int64_t changed = 0;
    for (int64_t i = 0; i < mesh.n_nodes * mesh.dim; i++) {
        double before = coordinates[i];
        if (i % 7 < 3)
            coordinates[i] = before * 1.01 + 1.0 / 128;
        volatile float single = (float)coordinates[i];
        if (info.precision == PLANISH_PRECISION_FLOAT)
            coordinates[i] = single;
        changed += coordinates[i] != before;
    }
    return changed;
}

/** Write the file at path unchanged, then with moved nodes, and compare. */
static void check_file(void **state, const char *path, const char *name) {
    char output[TEST_PATH_SIZE];
    size_t size, size_after;
    char *input = test_read(path, &size), *after;
    planish_file *file = open_file(path, 2), *again;
    test_path(output, *state, name);
    write_file(file, output, planish_file_coordinates(file), 2);
    after = test_read(output, &size_after);
    assert_int_equal(size, size_after);
    assert_memory_equal(input, after, size);
    free(after);

    int64_t changed = move_nodes(file);
    planish_mesh mesh = planish_file_mesh(file);
    write_file(file, output, mesh.coordinates, 2);
    after = test_read(output, &size_after);
    if (file->model.text_offset)
        assert_int_equal(count_other_tokens(input, after), changed);
    else
        check_binary(&file->model, input, after, size, size_after);
    again = open_file(output, 1);
    assert_memory_equal(planish_file_mesh(again).coordinates, mesh.coordinates,
                        (size_t)(mesh.n_nodes * mesh.dim) * sizeof(double));
    planish_file_close(again);
    planish_file_close(file);
    free(after);
    free(input);
}

static void every_format(void **state) {
    static const char *const names[] = {"ascii22.msh",  "ascii41.msh", "binary22.msh",
                                        "binary41.msh", "square.msh",  "ascii.vtk",
                                        "binary.vtk",   "medit.mesh",  "tetgen.node"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[TEST_PATH_SIZE];
        test_path_from(path, "PLANISH_TEST_DATA", names[i]);
        check_file(state, path, names[i]);
    }
}

static void real_meshes(void **state) {
    static const char *const names[] = {"mmg_tinyBoxt.mesh", "mmg_torus.mesh", "part_100k.mesh",
                                        "stellar_house2.node"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[TEST_PATH_SIZE];
        test_path_from(path, "PLANISH_MESHES", names[i]);
        check_file(state, path, names[i]);
    }
}

static void any_number_of_threads_writes_the_same(void **state) {
    enum { N = 50000 };
    char path[TEST_PATH_SIZE];
    FILE *out = fopen(test_path(path, *state, "in.mesh"), "w");
    assert_non_null(out);
    fprintf(out, "MeshVersionFormatted 2 Dimension 2 Vertices %d\n", N);
    for (int i = 0; i < N; i++)
        fprintf(out, "%d.%d %d 0\n", i % 100, i % 7, i / 100);
    fprintf(out, "Triangles 1 1 2 103 0\n");
    fclose(out);
    planish_file *file = open_file(path, 1);
    move_nodes(file);
    write_file(file, test_path(path, *state, "1.mesh"), planish_file_coordinates(file), 1);
    char *one = test_read(path, NULL);
    static const int threads[] = {2, 3, 7};
    for (int i = 0; i < 3; i++) {
        write_file(file, test_path(path, *state, "n.mesh"), planish_file_coordinates(file),
                   threads[i]);
        check_content(path, one);
    }
    free(one);
    planish_file_close(file);
}

/* ---- files -------------------------------------------------------------------------------- */

static mode_t mode_of(const char *path) {
    struct stat about;
    assert_int_equal(stat(path, &about), 0);
    return about.st_mode & 07777;
}

static void modes_are_kept(void **state) {
    char path[TEST_PATH_SIZE];
    planish_file *file = open_small(state);
    mode_t mask = umask(027);
    write_file(file, test_path(path, *state, "new.mesh"), planish_file_coordinates(file), 1);
    umask(mask);
    assert_int_equal(mode_of(path), 0640);
    assert_int_equal(chmod(path, 0604), 0);
    write_file(file, path, planish_file_coordinates(file), 1);
    assert_int_equal(mode_of(path), 0604);
    planish_file_close(file);
}

static void over_the_input(void **state) {
    char path[TEST_PATH_SIZE];
    char *expected = small_with("+.5 .25", "0.75 .25");
    planish_file *file = open_small(state);
    planish_file_coordinates(file)[9] = 0.75;
    test_path(path, *state, "in.mesh");
    for (int i = 0; i < 2; i++) { /* what was read stays the source, also after it was replaced */
        write_file(file, path, planish_file_coordinates(file), 1);
        check_content(path, expected);
    }
    assert_int_equal(test_count_files(*state), 1);
    planish_file_close(file);
    free(expected);
}

static void links_are_followed(void **state) {
    char path[TEST_PATH_SIZE], target[TEST_PATH_SIZE], middle[TEST_PATH_SIZE];
    struct stat about;
    planish_file *file = open_small(state);
    test_path(target, *state, "target.mesh");
    test_path(path, *state, "link.mesh");
    test_path(middle, *state, "middle.mesh");
    assert_int_equal(symlink("middle.mesh", path), 0); /* relative, then absolute */
    assert_int_equal(symlink(target, middle), 0);
    for (int i = 0; i < 2; i++) { /* first the target does not exist */
        write_file(file, path, planish_file_coordinates(file), 1);
        check_content(target, small);
        assert_true(lstat(path, &about) == 0 && S_ISLNK(about.st_mode));
        assert_true(lstat(middle, &about) == 0 && S_ISLNK(about.st_mode));
        assert_true(lstat(target, &about) == 0 && S_ISREG(about.st_mode));
    }
    planish_file_close(file);
}

static void pipes_are_written_directly(void **state) {
    char path[TEST_PATH_SIZE], copy[TEST_PATH_SIZE];
    planish_file *file = open_small(state);
    test_path(copy, *state, "copy.mesh");
    assert_int_equal(mkfifo(test_path(path, *state, "pipe.mesh"), 0600), 0);
    pid_t reader = fork();
    assert_true(reader >= 0);
    if (reader == 0) {
        char *content = test_read(path, NULL);
        test_write(*state, "copy.mesh", content, strlen(content));
        free(content);
        _exit(0);
    }
    write_file(file, path, planish_file_coordinates(file), 1);
    int status;
    assert_int_equal(waitpid(reader, &status, 0), reader);
    assert_int_equal(status, 0);
    check_content(copy, small);
    write_file(file, "/dev/null", planish_file_coordinates(file), 1);
    planish_file_close(file);
}

static void open_files_are_written_on(void **state) {
    char path[TEST_PATH_SIZE], name[64], expected[sizeof small + 4] = "old\n";
    planish_file *file = open_small(state);
    test_write(*state, "log", "old\n", 4);
    int descriptor = open(test_path(path, *state, "log"), O_WRONLY | O_APPEND);
    assert_true(descriptor >= 0);
    snprintf(name, sizeof name, "/dev/fd/%d", descriptor);
    write_file(file, name, planish_file_coordinates(file), 1);
    assert_int_equal(write(descriptor, "", 0), 0); /* still open */
    close(descriptor);
    strcat(expected, small);
    check_content(path, expected);
    planish_file_close(file);
}

/** Writing to path must fail with a message about it, and leave nothing behind. */
static void write_fails(void **state, const planish_file *file, const char *path, int files) {
    char temporary[TEST_PATH_SIZE] = "";
    planish_error error = {.code = 0};
    assert_int_equal(
        planish_file_write(file, path, file->model.coordinates,
                           &(planish_write_options){.threads = 1,
                                                    .temporary = temporary,
                                                    .temporary_size = sizeof temporary},
                           &error),
        PLANISH_ERROR_FILE);
    assert_int_equal(error.code, PLANISH_ERROR_FILE);
    assert_non_null(strstr(error.text, path));
    assert_string_equal(temporary, "");
    assert_int_equal(test_count_files(*state), files);
}

static void failures_are_reported(void **state) {
    char path[TEST_PATH_SIZE];
    planish_file *file = open_small(state);
    if (access("/dev/full", W_OK) == 0)
        write_fails(state, file, "/dev/full", 1);
    write_fails(state, file, test_path(path, *state, "no/such/folder.mesh"), 1);
    assert_int_equal(mkdir(test_path(path, *state, "folder.mesh"), 0700), 0);
    write_fails(state, file, path, 2);
    rmdir(path);
    test_path(path, *state, "loop.mesh");
    assert_int_equal(symlink("loop.mesh", path), 0);
    write_fails(state, file, path, 2);
    planish_file_close(file);
}

/** Another format's name, and coordinates that no mesh has. */
static void what_cannot_be_meant_is_refused(void **state) {
    static const char *const names[] = {"out.vtu", "out", "out.meshb", "mesh"};
    char path[TEST_PATH_SIZE];
    planish_error error;
    planish_file *file = open_small(state);
    double *coordinates = planish_file_coordinates(file);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        test_path(path, *state, names[i]);
        assert_int_equal(planish_file_can_write(file, path), 0);
        assert_int_equal(planish_file_check_output(file, path, &error), PLANISH_ERROR_ARGUMENT);
        assert_int_equal(planish_file_write(file, path, coordinates,
                                            &(planish_write_options){.threads = 1}, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_non_null(strstr(error.text, "extension of the input's format, medit (.mesh)"));
    }
    const double before = coordinates[4];
    test_path(path, *state, "out.mesh");
    for (int i = 0; i < 2; i++) {
        coordinates[4] = i ? NAN : -INFINITY;
        assert_int_equal(planish_file_write(file, path, coordinates,
                                            &(planish_write_options){.threads = 1}, &error),
                         PLANISH_ERROR_ARGUMENT);
        assert_int_equal(error.node, 4 / planish_file_mesh(file).dim);
    }
    coordinates[4] = before;
    assert_int_equal(test_count_files(*state), 1);
    planish_file_close(file);
}

static void nothing_is_asked_of_no_file(void **state) {
    planish_file *file = open_small(state);
    planish_file_info info = {.bytes = 7};
    planish_error error;
    uint8_t constraint[64];
    const planish_hold no_tags = {.n_tags = 1}, no_slides = {.slide = 1, .n_slide_tags = 1},
                       fewer = {.n_tags = -1};
    planish_file_get_info(NULL, &info);
    assert_int_equal(info.bytes, 0);
    planish_file_get_info(file, NULL);
    assert_int_equal(planish_file_mesh(NULL).n_nodes, 0);
    assert_int_equal(planish_file_surface(NULL, NULL).n_facets, 0);
    assert_null(planish_file_coordinates(NULL));
    assert_null(planish_file_unterminated_path(NULL));
    assert_int_equal(planish_file_get_marked(NULL, NULL), 0);
    assert_int_equal(planish_file_get_parametric(NULL, NULL), 0);
    assert_int_equal(planish_file_element_number(NULL, 0), -1);
    assert_int_equal(planish_file_node_number(NULL, 0), -1);
    assert_int_equal(planish_file_can_write(NULL, "a.mesh"), 0);
    assert_int_equal(planish_file_can_write(file, NULL), 0);
    assert_int_equal(planish_file_can_convert(NULL, "a.vtu"), 0);
    assert_int_equal(planish_file_can_convert(file, NULL), 0);
    assert_true(planish_file_mesh(file).n_nodes <= 64);
    assert_int_equal(planish_file_constraints(file, &no_tags, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_constraints(file, &no_slides, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    assert_int_equal(planish_file_constraints(file, &fewer, constraint, &error),
                     PLANISH_ERROR_ARGUMENT);
    planish_file_close(file);
}

/** Lists of the caller's that are too short for what goes there are not written beyond their end.
 */
static void short_buffers_stay_whole(void **state) {
    char path[TEST_PATH_SIZE], temporary[TEST_PATH_SIZE], lost[64];
    planish_file *file =
        reading_text(&io_format_medit, "MeshVersionFormatted 2 Dimension 2 Vertices 4 0 0 0 1 0 0 "
                                       "1 1 0 0 1 0 Quadrilaterals 1 1 2 3 4 0 Triangles 1 1 2 3 0 "
                                       "End");
    planish_error error = {.text = ""};
    const double *x = planish_file_coordinates(file);
    for (size_t size = 0; size < 40; size++) {
        memset(temporary, 0, sizeof temporary);
        memset(temporary + size, '#', sizeof temporary - size);
        memset(lost, '#', sizeof lost);
        if (planish_file_write(file, test_path(path, *state, "out.mesh"), x,
                               &(planish_write_options){
                                   .threads = 1, .temporary = temporary, .temporary_size = size},
                               &error) ||
            planish_file_convert(file, test_path(path, *state, "out.vtk"), x,
                                 &(planish_convert_options){.temporary = temporary,
                                                            .temporary_size = size,
                                                            .lost = lost,
                                                            .lost_size = size},
                                 &error))
            fail_msg("%s", error.text);
        for (size_t i = size; i < sizeof lost; i++)
            assert_true(temporary[i] == '#' && lost[i] == '#');
        assert_true(size == 0 || memchr(lost, '\0', size) != NULL);
    }
    assert_int_equal(strncmp(lost, "parameters and comments", 23), 0);
    planish_file_close(file);
}

/** A limit on the size of files stands in for a disk that becomes full half way. */
static void a_file_that_does_not_fit_leaves_the_old_one(void **state) {
    char path[TEST_PATH_SIZE];
    struct rlimit before, limit;
    planish_file *file = open_small(state);
    test_write(*state, "out.mesh", "old", 3);
    test_path(path, *state, "out.mesh");
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    limit = before;
    limit.rlim_cur = 100;
    void (*handler)(int) = signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
    write_fails(state, file, path, 2);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, handler);
    check_content(path, "old");
    test_path(path, *state, "in.mesh");
    check_content(path, small);
    planish_file_close(file);
}

#define IN_A_FOLDER(test)                                                                          \
    cmocka_unit_test_setup_teardown(test, test_folder_create, test_folder_remove)

/** An input that is written to while it is open is no longer what was read: nothing is written. */
static void a_changed_input_is_refused(void **state) {
    char in[TEST_PATH_SIZE], out[TEST_PATH_SIZE];
    test_path(in, *state, "in.mesh");
    test_path(out, *state, "out.mesh");
    for (int longer = 0; longer < 2; longer++) {
        planish_error error;
        planish_file *file = open_small(state);
        const double *coordinates = planish_file_coordinates(file);
        write_file(file, out, coordinates, 1);
        const struct timespec long_ago[2] = {{1000, 0}, {1000, 0}};
        if (longer) {
            FILE *input = fopen(in, "a");
            assert_non_null(input);
            fputc('\n', input);
            fclose(input);
        } else {
            assert_int_equal(utimensat(AT_FDCWD, in, long_ago, 0), 0);
        }
        test_write(*state, "out.mesh", "before", 6);
        assert_int_equal(planish_file_write(file, out, coordinates,
                                            &(planish_write_options){.threads = 1}, &error),
                         PLANISH_ERROR_FILE);
        assert_non_null(strstr(error.text, "in.mesh: was changed"));
        check_content(out, "before");
        planish_file_close(file);
    }
}

/** But it may be replaced by another file of its name: what was read is still there. */
static void a_replaced_input_is_none(void **state) {
    char in[TEST_PATH_SIZE], other[TEST_PATH_SIZE], out[TEST_PATH_SIZE];
    test_path(in, *state, "in.mesh");
    test_path(out, *state, "out.mesh");
    planish_file *file = open_small(state);
    test_write(*state, "other.mesh", "another", 7);
    assert_int_equal(rename(test_path(other, *state, "other.mesh"), in), 0);
    write_file(file, out, planish_file_coordinates(file), 1);
    check_content(out, small);
    planish_file_close(file);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(only_what_changed_is_rewritten),
        IN_A_FOLDER(floats_in_as_many_digits_as_they_need),
        IN_A_FOLDER(every_format),
        IN_A_FOLDER(real_meshes),
        IN_A_FOLDER(any_number_of_threads_writes_the_same),
        IN_A_FOLDER(modes_are_kept),
        IN_A_FOLDER(over_the_input),
        IN_A_FOLDER(links_are_followed),
        IN_A_FOLDER(pipes_are_written_directly),
        IN_A_FOLDER(open_files_are_written_on),
        IN_A_FOLDER(failures_are_reported),
        IN_A_FOLDER(what_cannot_be_meant_is_refused),
        IN_A_FOLDER(nothing_is_asked_of_no_file),
        IN_A_FOLDER(short_buffers_stay_whole),
        IN_A_FOLDER(a_file_that_does_not_fit_leaves_the_old_one),
        IN_A_FOLDER(a_changed_input_is_refused),
        IN_A_FOLDER(a_replaced_input_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
