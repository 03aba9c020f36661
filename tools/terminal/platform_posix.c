/* platform: as POSIX has it. */
#include "terminal/platform.h"

#include <errno.h>
#include <fcntl.h>
#include <langinfo.h>
#include <locale.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <unistd.h>

char **pl_platform_begin(int argc, char **argv) {
    (void)argc;
    /* A closed standard stream would give its number to the next file opened, and messages would
     * then go into a mesh. A closed standard output stays an error for what is meant for it. */
    for (int descriptor = 0; descriptor <= 2; descriptor++)
        if (fcntl(descriptor, F_GETFD) == -1 && errno == EBADF &&
            open("/dev/null", descriptor == STDOUT_FILENO ? O_RDONLY : O_RDWR) != descriptor)
            return NULL;
    /* hwloc would print what it does not find on odd machines; placement copes without. */
    setenv("HWLOC_HIDE_ERRORS", "2", 0);
    /* Its plug-ins know graphics cards and the like, which nobody asks for: loading them takes as
     * long as smoothing some ten thousand elements. */
    setenv("HWLOC_PLUGINS_PATH", "", 0);
    return argv;
}

int pl_console_is(FILE *stream) {
    return isatty(fileno(stream));
}

int pl_console_obeys(void) {
    const char *kind = getenv("TERM");
    return kind && kind[0] && strcmp(kind, "dumb") != 0;
}

int pl_console_is_utf8(void) {
    locale_t locale = newlocale(LC_CTYPE_MASK, "", (locale_t)0); /* the program's own stays C */
    if (!locale)
        return 0;
    const int is_utf8 = strcmp(nl_langinfo_l(CODESET, locale), "UTF-8") == 0;
    freelocale(locale);
    return is_utf8;
}

int pl_console_columns(FILE *stream) {
    struct winsize size;
    return ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 ? size.ws_col : 0;
}

int64_t pl_peak_memory_bytes(void) {
    static const char key[] = "VmHWM:";
    struct rusage usage;
    char line[256];
    long long kilobytes = 0;
    /* Linux' own figure: what getrusage says may be the peak of the process that began this one. */
    FILE *status = fopen("/proc/self/status", "r");
    while (status && fgets(line, sizeof line, status))
        if (strncmp(line, key, sizeof key - 1) == 0)
            kilobytes = strtoll(line + sizeof key - 1, NULL, 10);
    if (status)
        fclose(status);
    if (kilobytes == 0 && getrusage(RUSAGE_SELF, &usage) == 0)
        kilobytes = usage.ru_maxrss;
    return kilobytes * 1024;
}

void pl_memory_stream_open(pl_memory_stream *stream) {
    stream->file = open_memstream(&stream->text, &stream->length);
}

char *pl_memory_stream_close(pl_memory_stream *stream) {
    return stream->file && fclose(stream->file) == 0 ? stream->text : NULL;
}
