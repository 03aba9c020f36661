/* placement: the number of threads, and their cores. The only user of hwloc.
 *
 *   pl_placement_create, _destroy, _forget_machine    choose cores; forget the machine
 *   pl_placement_threads, _cpu, _is_near, _text       the choice
 *   pl_placement_enter, _leave                        bind the threads of a call
 */
#ifndef PL_PLAN_PLACEMENT_H
#define PL_PLAN_PLACEMENT_H

typedef struct pl_placement pl_placement;

/** Decide on threads (0: with bind one for each core that the process may use, at most as many as
 *  OpenMP would use; without bind as many as OpenMP would use) and, with bind, on a core for each.
 *  Fewer threads than cores are not bound: two processes would meet on the same ones while
 *  others idle. Without hwloc, or where its topology is not this machine's, nothing is ever bound.
 * Always succeeds but for memory: NULL then. */
pl_placement *pl_placement_create(int threads, int bind);

/** Free placement; NULL: do nothing. */
void pl_placement_destroy(pl_placement *placement);

/** Free what was learnt of the machine for all placements, of which there must be none; the next
 *  one looks again. Called when the library is unloaded, and by tests that change machines. */
void pl_placement_forget_machine(void) __attribute__((destructor));

/** Number of threads of the placement. */
int pl_placement_threads(const pl_placement *placement);

/** The CPU chosen for a thread, by the system's number; -1: none. On a machine that is only
 * described (HWLOC_SYNTHETIC) it is chosen, too, but not used: for tests. */
int pl_placement_cpu(const pl_placement *placement, int thread);

/** Whether all memory is known to be as near to one thread as to another, so that it does not
 * matter which touches it first: there is one thread, or the cores of all are in one NUMA node. */
int pl_placement_is_near(const pl_placement *placement);

/** Describe the decision for people: "one thread per core, on CPUs 0-1" or "not bound".
 *  placement owns the text. */
const char *pl_placement_text(const pl_placement *placement);

/** Bind the threads; pl_placement_leave gives them back the places they had. */
void pl_placement_enter(pl_placement *placement);

/** Give the bound threads back the places that they had before. */
void pl_placement_leave(pl_placement *placement);

#endif
