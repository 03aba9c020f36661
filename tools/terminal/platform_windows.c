/* platform: as Windows has it. */
#include "terminal/platform.h"

#include <fcntl.h>
#include <io.h>
#include <stdlib.h>
#include <string.h>
#include <wchar.h>
#include <windows.h>
/* Behind windows.h. */
#include <psapi.h>
#include <shellapi.h>

static char *utf8_of(const wchar_t *wide) {
    const int size = WideCharToMultiByte(CP_UTF8, 0, wide, -1, NULL, 0, NULL, NULL);
    char *text = malloc((size_t)size);
    if (text)
        WideCharToMultiByte(CP_UTF8, 0, wide, -1, text, size, NULL, NULL);
    return text;
}

/** The command line in UTF-8; it lasts as long as the program. */
static char **find_arguments(int argc) {
    int n = 0;
    wchar_t **wide = CommandLineToArgvW(GetCommandLineW(), &n);
    char **text = wide && n == argc ? calloc((size_t)argc + 1, sizeof *text) : NULL;
    int failed = !text;
    for (int i = 0; i < argc && !failed; i++)
        failed = !(text[i] = utf8_of(wide[i]));
    LocalFree(wide);
    return failed ? NULL : text;
}

static HANDLE handle_of(FILE *stream) {
    return (HANDLE)_get_osfhandle(_fileno(stream));
}

/** Let the console move its cursor and show colours when told so; older ones cannot. */
static void let_obey(FILE *stream) {
    DWORD mode;
    if (GetConsoleMode(handle_of(stream), &mode))
        SetConsoleMode(handle_of(stream), mode | ENABLE_VIRTUAL_TERMINAL_PROCESSING);
}

char **pl_platform_begin(int argc, char **argv) {
    FILE *const streams[] = {stdin, stdout, stderr};
    (void)argv;
    for (int i = 0; i < 3; i++)
        if (_fileno(streams[i]) >= 0)
            _setmode(_fileno(streams[i]), _O_BINARY); /* line ends are those that are written */
    let_obey(stdout);
    let_obey(stderr);
    SetConsoleOutputCP(CP_UTF8);
    return find_arguments(argc);
}

int pl_console_is(FILE *stream) {
    DWORD mode;
    return GetConsoleMode(handle_of(stream), &mode) != 0;
}

int pl_console_obeys(void) {
    DWORD mode;
    return GetConsoleMode(GetStdHandle(STD_ERROR_HANDLE), &mode)
               ? (mode & ENABLE_VIRTUAL_TERMINAL_PROCESSING) != 0
               : 1; /* the other stream is the console */
}

int pl_console_is_utf8(void) {
    return GetConsoleOutputCP() == CP_UTF8;
}

int pl_console_columns(FILE *stream) {
    CONSOLE_SCREEN_BUFFER_INFO about;
    if (!GetConsoleScreenBufferInfo(handle_of(stream), &about))
        return 0;
    return about.srWindow.Right - about.srWindow.Left + 1;
}

int64_t pl_peak_memory_bytes(void) {
    PROCESS_MEMORY_COUNTERS counters;
    if (!GetProcessMemoryInfo(GetCurrentProcess(), &counters, sizeof counters))
        return 0;
    return (int64_t)counters.PeakWorkingSetSize;
}

/** There are no streams in memory: a file that goes as it is closed. */
void pl_memory_stream_open(pl_memory_stream *stream) {
    wchar_t folder[MAX_PATH + 1], path[MAX_PATH + 1];
    *stream = (pl_memory_stream){NULL};
    if (GetTempPathW(MAX_PATH, folder) && GetTempFileNameW(folder, L"pla", 0, path))
        stream->file = _wfopen(path, L"w+bTD");
}

char *pl_memory_stream_close(pl_memory_stream *stream) {
    const long length = stream->file ? ftell(stream->file) : -1;
    char *text = length >= 0 ? calloc((size_t)length + 1, 1) : NULL;
    if (text) {
        rewind(stream->file);
        stream->length = fread(text, 1, (size_t)length, stream->file);
    }
    if (stream->file)
        fclose(stream->file);
    return text;
}
