/* Walking the bytes of a text file. */
#include "io/core/text.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

static io_cursor cursor_on(const char *text) {
    return (io_cursor){text, text + strlen(text)};
}

static io_slice slice_on(const char *text) {
    return (io_slice){text, text + strlen(text)};
}

static void words_between_any_white_space(void **state) {
    (void)state;
    io_cursor cursor = cursor_on(" \t\r\nalpha\r\n\v\fb,c\n");
    assert_true(io_slice_is(io_next_word(&cursor), "alpha", 0));
    assert_true(io_slice_is(io_next_word(&cursor), "b,c", 0));
    assert_int_equal(io_slice_length(io_next_word(&cursor)), 0);
    assert_ptr_equal(cursor.at, cursor.end);
}

static void words_are_compared_whole(void **state) {
    (void)state;
    assert_true(io_slice_is(slice_on("Vertices"), "Vertices", 0));
    assert_false(io_slice_is(slice_on("Vertice"), "Vertices", 0));
    assert_false(io_slice_is(slice_on("Vertices2"), "Vertices", 0));
    assert_false(io_slice_is(slice_on("VERTICES"), "Vertices", 0));
    assert_true(io_slice_is(slice_on("VERTICES"), "Vertices", 1));
    assert_false(io_slice_is(slice_on(""), "Vertices", 0));
}

static void slices_are_words_and_lines(void **state) {
    (void)state;
    static const char text[] = "\xef\xbb\xbf # a comment\n\n mesh3d\nb c \r\n";
    io_cursor cursor = cursor_on("one  two\r\n 12 \n");
    int64_t value;
    assert_true(io_slice_is(io_first_word(text, (int64_t)strlen(text)), "mesh3d", 0));
    assert_int_equal(io_slice_length(io_first_word(" # nothing", 10)), 0);
    assert_true(io_slice_is(io_next_word(&cursor), "ONE", 1));
    const io_slice line = io_next_line(&cursor);
    assert_int_equal(io_slice_length(line), 5);
    assert_true(io_slice_is(io_slice_trim(line), "two", 0));
    assert_int_equal(io_slice_integer(line, &value), -1);
    assert_int_equal(io_slice_integer(io_slice_trim(io_next_line(&cursor)), &value), 0);
    assert_int_equal(value, 12);
    assert_int_equal(io_slice_length(io_next_word(&cursor)), 0);
}

static void lines_end_in_three_ways(void **state) {
    (void)state;
    io_cursor cursor = cursor_on("a\nb\r\nc\rd");
    static const char first[] = "abcd";
    for (int i = 0; i < 4; i++) {
        assert_int_equal(*cursor.at, first[i]);
        io_skip_line(&cursor);
    }
    assert_ptr_equal(cursor.at, cursor.end);
    io_skip_line(&cursor);
    assert_ptr_equal(cursor.at, cursor.end);
}

static void lines_are_taken_without_their_ends(void **state) {
    (void)state;
    static const char *const ends[] = {"\n", "\r\n", "\r", ""};
    char text[2048];
    for (size_t kind = 0; kind < 4; kind++)
        for (int length = 0; length < 600; length++) { /* about the stretches it is looked at in */
            memset(text, 'a', (size_t)length);
            strcpy(text + length, ends[kind]);
            if (kind < 3)
                strcat(text, "b");
            io_cursor cursor = cursor_on(text);
            const io_slice line = io_next_line(&cursor);
            assert_ptr_equal(line.begin, text);
            assert_ptr_equal(line.end, text + length);
            assert_int_equal(cursor.end - cursor.at, kind < 3);
        }
    io_cursor cursor = cursor_on("\r\r\n\n");
    for (int left = 3; left >= 0; left -= left == 3 ? 2 : 1) {
        assert_int_equal(io_slice_length(io_next_line(&cursor)), 0);
        assert_int_equal(cursor.end - cursor.at, left);
    }
}

/** Lines of a file that has nothing but \r cost what they are long. */
static void long_files_of_carriage_returns(void **state) {
    (void)state;
    enum { N = 1 << 22 }; /* bytes: if each line were to look for \n in all of them, hours */
    static char text[N];
    memset(text, '\r', N);
    io_cursor cursor = {text, text + N};
    int64_t lines = 0;
    for (; cursor.at < cursor.end; lines++)
        io_next_line(&cursor);
    assert_int_equal(lines, N);
}

static void comments_are_skipped(void **state) {
    (void)state;
    io_cursor cursor = cursor_on("# one\n  #two # three\r\n\t7 # not yet");
    int64_t value;
    io_skip_space_comments(&cursor, '#');
    assert_int_equal(io_integer(&cursor, &value), 0);
    assert_int_equal(value, 7);
    io_skip_space_comments(&cursor, '#');
    assert_ptr_equal(cursor.at, cursor.end);
}

static void numbers_must_end_with_space(void **state) {
    (void)state;
    int64_t integer;
    double real;
    io_cursor cursor = cursor_on("  12.5 x");
    assert_int_equal(io_integer(&cursor, &integer), -1);
    assert_ptr_equal(cursor.at, cursor.end - 6); /* white space is skipped, nothing else */
    assert_int_equal(io_real(&cursor, &real), 0);
    assert_true(real == 12.5);
    assert_int_equal(io_real(&cursor, &real), -1);
    cursor = cursor_on("1.5x");
    assert_int_equal(io_real(&cursor, &real), -1);
    cursor = cursor_on("");
    assert_int_equal(io_integer(&cursor, &integer), -1);
    assert_int_equal(io_real(&cursor, &real), -1);
}

static void lines_are_found_at_their_start(void **state) {
    (void)state;
    static const char text[] = "x $End\n$En\n$EndNodes\n";
    const char *end = text + strlen(text);
    assert_ptr_equal(io_find_line(text, end, "$End"), strstr(text, "$EndNodes"));
    assert_ptr_equal(io_find_line(text, end, "$Elements"), end);
    assert_ptr_equal(io_find_line(text, text + 12, "$End"), text + 12);
    assert_ptr_equal(io_find_line(end, end, "$End"), end);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_between_any_white_space),
        cmocka_unit_test(words_are_compared_whole),
        cmocka_unit_test(slices_are_words_and_lines),
        cmocka_unit_test(lines_end_in_three_ways),
        cmocka_unit_test(lines_are_taken_without_their_ends),
        cmocka_unit_test(long_files_of_carriage_returns),
        cmocka_unit_test(comments_are_skipped),
        cmocka_unit_test(numbers_must_end_with_space),
        cmocka_unit_test(lines_are_found_at_their_start),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
