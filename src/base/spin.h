/* spin: a lock that is held for microseconds, and seldom wanted by two threads. 0: nobody has it.
 */
#ifndef PL_BASE_SPIN_H
#define PL_BASE_SPIN_H

#include <sched.h>

/** Wait until nobody has the lock, and take it. */
static inline void pl_spin_lock(int *lock) {
    while (__atomic_exchange_n(lock, 1, __ATOMIC_ACQUIRE))
        sched_yield();
}

/** Release the lock. */
static inline void pl_spin_unlock(int *lock) {
    __atomic_store_n(lock, 0, __ATOMIC_RELEASE);
}

#endif
