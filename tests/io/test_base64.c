/* Tests of base64 and of packing: known texts (RFC 4648, RFC 1950), streams in pieces, what is
 * wrong, and replacement in place. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/base64.h"
#include "io/vtk/vtk_base64.h"
#include "io/vtk/compression.h"

static io_base64 stream_of(const char *text) {
    return (io_base64){.cursor = {text, text + strlen(text)}};
}

static void known_texts(void **state) {
    (void)state;
    static const struct {
        const char *bytes, *text;
    } known[] = {{"", ""},
                 {"f", "Zg=="},
                 {"fo", "Zm8="},
                 {"foo", "Zm9v"},
                 {"foob", "Zm9vYg=="},
                 {"fooba", "Zm9vYmE="},
                 {"foobar", "Zm9vYmFy"},
                 {"\xff\xfe\xfb", "//77"}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        char out[16];
        const int64_t n = (int64_t)strlen(known[i].bytes);
        assert_int_equal(pl_base64_write(known[i].bytes, n, out), strlen(known[i].text));
        assert_int_equal(pl_base64_length(n), strlen(known[i].text));
        assert_memory_equal(out, known[i].text, strlen(known[i].text));
        io_base64 stream = stream_of(known[i].text);
        assert_int_equal(io_base64_read(&stream, n, out), 0);
        assert_memory_equal(out, known[i].bytes, (size_t)n);
        assert_int_equal(io_base64_read(&stream, 1, out), -1);
    }
}

/** Whatever pieces it is read in, and whatever white space and segments it is of. */
static void streams_in_pieces(void **state) {
    (void)state;
    static const char *const texts[] = {"Zm9vYmFyMTIz", "Zm 9v\nYm\r\nFyMTIz  ",
                                        "\tZg==b28=YmFyMTIz", "Zm9vYg==YXIxMjM="};
    for (size_t t = 0; t < sizeof texts / sizeof *texts; t++)
        for (int piece = 1; piece <= 9; piece++) {
            char out[9];
            io_base64 stream = stream_of(texts[t]);
            for (int at = 0; at < 9; at += piece)
                assert_int_equal(io_base64_read(&stream, 9 - at < piece ? 9 - at : piece, out + at),
                                 0);
            assert_memory_equal(out, "foobar123", 9);
        }
}

static void wrong_texts(void **state) {
    (void)state;
    static const char *const texts[] = {"Zm9",      "Zm9*", "=m9v",    "Z=9v",
                                        "Zm=v",     "Zm9v", "Zm9vYg=", "Zm9v\xc3\xa4YmFy",
                                        "Zm9v<a/>", "Zg==", "Zg= ="};
    for (size_t t = 0; t < sizeof texts / sizeof *texts; t++) {
        char out[8];
        io_base64 stream = stream_of(texts[t]);
        assert_int_equal(io_base64_read(&stream, 6, out), -1);
    }
}

static void replaced_in_place(void **state) {
    (void)state;
    /* Unused bits of the last group's third character are set: it stays unless its byte changes. */
    char text[] = " Zm9v\n YmFy Zh== rest";
    char same[sizeof text];
    memcpy(same, text, sizeof text);
    assert_int_equal(io_base64_replace(same, (int64_t)strlen(same), 2, 5, "obarf"), 16);
    assert_string_equal(same, text);
    assert_int_equal(io_base64_replace(text, (int64_t)strlen(text), 2, 3, "O-A"), 11);
    assert_string_equal(text, " Zm9P\n LUFy Zh== rest");
    assert_int_equal(io_base64_replace(text, (int64_t)strlen(text), 6, 1, "g"), 16);
    assert_string_equal(text, " Zm9P\n LUFy Zw== rest");
}

/* ---- packing ------------------------------------------------------------------------------- */

static void packed_and_unpacked(void **state) {
    (void)state;
    enum { SIZE = 100000 };
    static const io_compression all[] = {IO_ZLIB, IO_LZ4, IO_LZMA};
    char *data = malloc(SIZE), *out = malloc(SIZE + 1);
    for (int64_t i = 0; i < SIZE; i++)
        data[i] = (char)(i * i / 7 % (1 + i / 1000));
    for (size_t c = 0; c < sizeof all / sizeof *all; c++) {
        if (!io_compression_is_built(all[c]))
            continue;
        char *packed = malloc((size_t)io_pack_bound(all[c], SIZE));
        const int64_t size = io_pack(all[c], data, SIZE, "\x78\x9c", packed);
        assert_in_range(size, 1, SIZE - 1);
        assert_int_equal(io_unpack(all[c], packed, size, out, SIZE), 0);
        assert_memory_equal(out, data, SIZE);
        /* Less or more than it is, cut short, or spoiled: refused, and nothing behind out. */
        out[SIZE] = 17;
        assert_int_equal(io_unpack(all[c], packed, size, out, SIZE - 1), -1);
        assert_int_equal(io_unpack(all[c], packed, size, out, SIZE + 1), -1);
        out[SIZE] = 17;
        assert_int_equal(io_unpack(all[c], packed, size - 1, out, SIZE), -1);
        assert_int_equal(io_unpack(all[c], packed, 0, out, SIZE), -1);
        memset(packed + size / 2, 0x55, 8);
        if (all[c] != IO_LZ4) /* which has no check sum */
            assert_int_equal(io_unpack(all[c], packed, size, out, SIZE), -1);
        assert_int_equal(out[SIZE], 17);
        free(packed);
    }
    assert_int_equal(io_compression_is_built(IO_PLAIN), 1);
    free(data);
    free(out);
}

/** The level of zlib is that of the block that is replaced. */
static void packed_as_hard(void **state) {
    (void)state;
    static const char *const like[] = {"\x78\x01", "\x78\x5e", "\x78\x9c", "\x78\xda"};
    char data[4096], packed[8192];
    if (!io_compression_is_built(IO_ZLIB))
        skip();
    memset(data, 'x', sizeof data);
    for (int i = 0; i < 4; i++) {
        assert_true(io_pack_bound(IO_ZLIB, sizeof data) <= (int64_t)sizeof packed);
        assert_true(io_pack(IO_ZLIB, data, sizeof data, like[i], packed) > 0);
        assert_memory_equal(packed, like[i], 2);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_texts),         cmocka_unit_test(streams_in_pieces),
        cmocka_unit_test(wrong_texts),         cmocka_unit_test(replaced_in_place),
        cmocka_unit_test(packed_and_unpacked), cmocka_unit_test(packed_as_hard),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
