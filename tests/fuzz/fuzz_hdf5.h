/* fuzz_hdf5: any bytes given to a reader of a format in HDF5.
 *
 *     #include "fuzz_hdf5.h"
 *     FUZZ_HDF5(io_format_NAME)
 *
 * As fuzz_reader.h, but for what comes back: in a damaged file the library's records may say that
 * coordinates stand among other data, and what is written then changes these. Unchanged coordinates
 * give the same bytes.
 *
 * The library itself (1.10) is not proof against all damage: it asks for memory of any size, loses
 * memory when it fails, and reads beyond what it has allocated. These are not reported here, so
 * that what is, is planish's.
 */
#ifndef FUZZ_HDF5_H
#define FUZZ_HDF5_H

#include "fuzz_reader.h"

const char *__asan_default_options(void);
const char *__asan_default_suppressions(void);
int __lsan_is_turned_off(void);

const char *__asan_default_options(void) {
    return "allocator_may_return_null=1";
}

const char *__asan_default_suppressions(void) {
    return "interceptor_via_lib:libhdf5";
}

int __lsan_is_turned_off(void) {
    return 1;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define FUZZ_HDF5(format)                                                                          \
    int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {                                 \
        return fuzz_reader(&format, data, size, 0);                                                \
    }

#endif
