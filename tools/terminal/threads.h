/* threads: how many threads the program can have. */
#ifndef PL_TOOLS_THREADS_H
#define PL_TOOLS_THREADS_H

/** How many threads to ask the library for: wanted (0: OMP_NUM_THREADS, else 0, which leaves it to
 *  the library), but no more than the system can start at this moment. libgomp ends the process
 * where a thread cannot be started, so this is tried out before. */
int pl_threads_to_use(int wanted);

#endif
