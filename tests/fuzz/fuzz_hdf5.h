/* fuzz_hdf5: any bytes given to a reader of a format in HDF5.
 *
 *     #include "fuzz_hdf5.h"
 *     FUZZ_HDF5(io_format_NAME)
 *
 * As fuzz_reader.h, but for what comes back: in a damaged file the library's records may say that
 * coordinates stand among other data, and what is written then changes these; and what it finds in
 * such a file may depend on what was asked before, so that packed coordinates are read but refused
 * when they are to be written. Unchanged coordinates that are written give the same bytes.
 *
 * The library itself (1.10) is not proof against all damage: it asks for memory of any size and
 * uses it without looking whether it came, loses memory when it fails, reads beyond what it has
 * allocated, and follows lists that have no end. These are not reported here, so that what is, is
 * planish's. Where it crashes, or takes memory again and again, the fuzzing ends with status 0, and
 * the input is left as hdf5-crash-PID in the folder that PLANISH_FUZZ_CRASHES names, if it does:
 * planish_open_options.isolated is for such files.
 */
#ifndef FUZZ_HDF5_H
#define FUZZ_HDF5_H

#define _GNU_SOURCE /* for dladdr */

#include "fuzz_reader.h"

#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <unistd.h>
#ifdef PLANISH_FUZZ
#include <sanitizer/allocator_interface.h>
#endif

const char *__asan_default_options(void);
const char *__asan_default_suppressions(void);
int __lsan_is_turned_off(void);

const char *__asan_default_options(void) {
    return "allocator_may_return_null=1:max_allocation_size_mb=256";
}

const char *__asan_default_suppressions(void) {
    return "interceptor_via_lib:libhdf5";
}

int __lsan_is_turned_off(void) {
    return 1;
}

#ifdef PLANISH_FUZZ
/** Whether the innermost calls, past the handler and functions like memcpy, are of libhdf5. */
static int is_in_library(void) {
    enum { INNERMOST = 7 };
    void *frame[INNERMOST];
    const int n = backtrace(frame, INNERMOST);
    for (int i = 0; i < n; i++) {
        Dl_info info;
        if (dladdr(frame[i], &info) && info.dli_fname && strstr(info.dli_fname, "libhdf5"))
            return 1;
    }
    return 0;
}

static struct sigaction reporter; /* what reports crashes */
static const uint8_t *input;      /* [input_size], for the handler */
static size_t input_size;

static void keep_input(void) {
    const char *folder = getenv("PLANISH_FUZZ_CRASHES");
    char path[256];
    snprintf(path, sizeof path, "%s/hdf5-crash-%ld", folder, (long)getpid());
    const int file = folder ? open(path, O_WRONLY | O_CREAT | O_TRUNC, 0644) : -1;
    const ssize_t written = file >= 0 ? write(file, input, input_size) : 0;
    (void)written;
}

static void end_if_in_library(void) {
    static const char text[] = "the HDF5 library failed: end of the fuzzing\n";
    if (!is_in_library())
        return;
    const ssize_t written = write(STDERR_FILENO, text, sizeof text - 1);
    (void)written;
    keep_input();
    _exit(0);
}

/** What no suppression covers, like a memcpy of -1 bytes; called before the report. */
void __asan_on_error(void);
void __asan_on_error(void) {
    end_if_in_library();
}

static void on_crash(int signal_number) {
    end_if_in_library();
    sigaction(signal_number, &reporter, NULL); /* and the crash happens again */
}

static _Thread_local size_t n_allocations; /* for this input */

static void on_allocation(const volatile void *memory, size_t size) {
    enum { MANY = 1 << 22 }; /* of files of kilobytes: a thousand times what one needs */
    (void)memory;
    (void)size;
    if (++n_allocations % MANY == 0)
        end_if_in_library();
}

static void on_release(const volatile void *memory) {
    (void)memory;
}

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerInitialize(int *argc, char ***argv) {
    struct sigaction action = {.sa_handler = on_crash};
    (void)argc;
    (void)argv;
    __sanitizer_install_malloc_and_free_hooks(on_allocation, on_release);
    return sigaction(SIGSEGV, &action, &reporter);
}

static inline void fuzz_hdf5_remember(const uint8_t *data, size_t size) {
    input = data;
    input_size = size;
    n_allocations = 0;
}
#else
static inline void fuzz_hdf5_remember(const uint8_t *data, size_t size) {
    (void)data;
    (void)size;
}
#endif

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define FUZZ_HDF5(format)                                                                          \
    int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {                                 \
        fuzz_hdf5_remember(data, size);                                                            \
        return fuzz_reader(&format, data, size, 0);                                                \
    }

#endif
