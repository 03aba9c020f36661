/* child: a function run in a process of its own, so that it may crash.
 *
 * fork alone makes one that has the bytes of the file, of a pipe too, and all that was found out so
 * far. The caller may have threads, which the child has not: it must use nothing that they may have
 * been at. The C library sees to its own memory and streams.
 */
#define _GNU_SOURCE /* for pipe2, which not all systems have */
#include "io/core/child.h"

#include "base/status.h"
#include "base/system.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

/** The result that the child sends in the end. */
typedef struct child_answer {
    int status;
    planish_error error;
} child_answer;

/** A crash is to end the child as the system does it: without the caller's handlers, a core file or
 *  text. What ends the caller ends the child; a signal that both get (Ctrl-C) is for the caller to
 *  answer, who may want the result all the more. */
static void become_quiet(void) {
    static const int of_crashes[] = {SIGSEGV, SIGBUS,    SIGABRT, SIGFPE,  SIGILL,
                                     SIGSYS,  SIGTRAP,   SIGPIPE, SIGQUIT, SIGXCPU,
                                     SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2};
    static const int of_people[] = {SIGINT, SIGTERM, SIGHUP};
    const struct rlimit none = {0, 0};
    for (size_t i = 0; i < sizeof of_crashes / sizeof *of_crashes; i++)
        signal(of_crashes[i], SIG_DFL);
    for (size_t i = 0; i < sizeof of_people / sizeof *of_people; i++)
        signal(of_people[i], SIG_IGN);
    setrlimit(RLIMIT_CORE, &none);
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    const int nowhere = open("/dev/null", O_RDWR | O_CLOEXEC);
    if (nowhere >= 0) {
        dup2(nowhere, STDOUT_FILENO);
        dup2(nowhere, STDERR_FILENO);
    }
}

#ifdef __linux__

/** Let the child have, besides the memory that the caller had, no more than a mesh in size bytes
 * can need, and of the machine's memory not all: in damaged files the HDF5 library follows lists
 * that have no end, and takes memory for each entry. */
static void limit_memory(int64_t size) {
    const int64_t least = INT64_C(1) << 30;
    const int64_t growth = 4096; /* a byte unpacks to a thousand at most, which are held as four */
    const int64_t most = pl_system_memory() / 4 * 3;
    const int64_t more = size < (most - least) / growth ? least + size * growth : most;
    char text[128];
    long long pages; /* of memory that are this process's own */
    struct rlimit limit;
    const int file = open("/proc/self/statm", O_RDONLY | O_CLOEXEC);
    const ssize_t length = file >= 0 ? read(file, text, sizeof text - 1) : -1;
    if (file >= 0)
        close(file);
    text[length > 0 ? length : 0] = '\0';
    if (sscanf(text, "%*s %*s %*s %*s %*s %lld", &pages) != 1 || getrlimit(RLIMIT_DATA, &limit))
        return;
    const int64_t before = pages * sysconf(_SC_PAGESIZE);
    if (before < 0 || more > INT64_MAX - before)
        return;
    const rlim_t now = (rlim_t)(before + more);
    if (now < limit.rlim_cur) { /* RLIM_INFINITY is the largest number */
        limit.rlim_cur = now;
        setrlimit(RLIMIT_DATA, &limit);
    }
}

#else
static void limit_memory(int64_t size) {
    (void)size;
}
#endif

/** Call the function, tell the parent, and end. */
static void be_child(io_child_fn *function, void *data, int64_t size, int to_parent) {
    child_answer a;
    struct rlimit limit;
    size_t n = 0;
    memset(&a, 0, sizeof a);
    become_quiet();
    limit_memory(size);
    /* In damaged files the library may also turn in circles. Let it have a minute of CPU, and a
     * second more for each megabyte: a thousand times what it takes for a sound file. */
    const rlim_t seconds = 60 + (rlim_t)(size >> 20);
    if (!getrlimit(RLIMIT_CPU, &limit) && seconds < limit.rlim_cur) {
        limit.rlim_cur = seconds;
        setrlimit(RLIMIT_CPU, &limit);
    }
    a.status = function(data, &a.error);
    /* A parent that is not told all of it takes it for a crash. */
    while (n < sizeof a) {
        const ssize_t put = write(to_parent, (const char *)&a + n, sizeof a - n);
        if (put >= 0)
            n += (size_t)put;
        else if (errno != EINTR)
            break;
    }
    _exit(0); /* nothing of the caller's is flushed or called */
}

/** Make a pipe that programs started meanwhile by other threads do not get, or not for long. */
static int make_pipe(int ends[2]) {
#ifdef __linux__
    return pipe2(ends, O_CLOEXEC);
#else
    return pipe(ends) || fcntl(ends[0], F_SETFD, FD_CLOEXEC) || fcntl(ends[1], F_SETFD, FD_CLOEXEC);
#endif
}

int io_child_run(io_child_fn *function, void *data, const io_bytes *input, planish_error *error) {
    child_answer a;
    int ends[2], how = 0;
    size_t n = 0;
    if (make_pipe(ends))
        return pl_fail_errno(error, input->path, "no process could be started to try it in");
    const pid_t child = fork();
    if (child == 0)
        be_child(function, data, input->size, ends[1]);
    const int why = errno;
    close(ends[1]);
    if (child < 0) {
        close(ends[0]);
        errno = why;
        return pl_fail_errno(error, input->path, "no process could be started to try it in");
    }
    while (n < sizeof a) {
        const ssize_t got = read(ends[0], (char *)&a + n, sizeof a - n);
        if (got > 0)
            n += (size_t)got;
        else if (got == 0 || errno != EINTR)
            break;
    }
    /* A caller that ignores SIGCHLD is not told how the child ended. */
    pid_t ended;
    do
        ended = waitpid(child, &how, 0);
    while (ended < 0 && errno == EINTR);
    close(ends[0]);
    const int signal_number = ended == child && WIFSIGNALED(how) ? WTERMSIG(how) : 0;
    if (n < sizeof a)
        return pl_fail(error, PLANISH_ERROR_FORMAT,
                       signal_number == SIGXCPU
                           ? "%s: the HDF5 library did not finish reading it (signal %d, in a "
                             "process of its own); the file is damaged"
                           : "%s: the HDF5 library crashed on it (signal %d, in a process of its "
                             "own); the file is damaged, or memory was short",
                       input->path, signal_number);
    if (a.status && error)
        *error = a.error;
    return a.status;
}
