/* placement: the number of threads, and their cores. The only user of hwloc.
 *
 *   pl_placement_create, _destroy, _forget_machine    choose cores; forget the machine
 *   pl_placement_cpu                                  the CPU of a thread
 *   pl_placement_enter, _leave                        bind the threads of a call
 */
#ifndef PL_PLAN_PLACEMENT_H
#define PL_PLAN_PLACEMENT_H

enum { PL_PLACEMENT_TEXT = 160 };

/** Threads, and where they are. */
typedef struct pl_placement {
    int threads; /* number of them */
    int is_near; /* all memory is known to be as near to one thread as to another, so that it does
                    not matter which touches it first: there is one thread, or the cores of all are
                    in one NUMA node */
    char text[PL_PLACEMENT_TEXT]; /* for people: "one thread per core, on CPUs 0-1", "not bound" */
    struct pl_cores *cores;       /* chosen, owned; NULL: none */
} pl_placement;

/** Decide on threads (0: with bind one for each core that the process may use, at most as many as
 *  OpenMP would use; without bind as many as OpenMP would use) and, with bind, on a core for each.
 *  Fewer threads than cores are not bound: two processes would meet on the same ones while
 *  others idle. Without hwloc, or where its topology is not this machine's, nothing is ever bound.
 *  Always succeeds but for memory: NULL then. */
pl_placement *pl_placement_create(int threads, int bind);

/** Free placement; NULL: do nothing. */
void pl_placement_destroy(pl_placement *placement);

/** Free the map of the machine that all placements share; no placement may be left; the next
 *  one looks again. Called when the library is unloaded, and by tests that change machines. */
void pl_placement_forget_machine(void) __attribute__((destructor));

/** Return the CPU chosen for a thread, by the system's number; -1: none. On a machine that is only
 * described (HWLOC_SYNTHETIC) it is chosen, too, but not used: for tests. */
int pl_placement_cpu(const pl_placement *placement, int thread);

/** Bind the threads; pl_placement_leave gives them back the places they had. */
void pl_placement_enter(pl_placement *placement);

/** Give the bound threads back the places that they had before. */
void pl_placement_leave(pl_placement *placement);

#endif
