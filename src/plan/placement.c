/* placement: how many threads, and on which cores. The only user of hwloc. */
#if defined(__linux__) && !defined(_GNU_SOURCE)
#define _GNU_SOURCE /* for sched_setaffinity */
#endif
#include "plan/placement.h"

#include "base/memory.h"
#include "base/parallel.h"

#include <stdio.h>

#ifdef PL_HWLOC
#include <hwloc.h>
#ifdef __linux__
#include <sched.h>

#include <hwloc/glibc-sched.h>
#endif
#endif

#ifdef PL_HWLOC

/** One hardware thread for each thread. Arrays are owned, the topology is the machine's. */
struct pl_cores {
    hwloc_topology_t topology;
    int n;                  /* threads */
    int binds;              /* 0: threads stay where they are all the same */
    hwloc_cpuset_t *core;   /* [n] where each thread belongs */
    hwloc_cpuset_t *former; /* [n] where it was before */
};

/** This machine, loaded for the first plan that asks and kept for all: hwloc needs milliseconds
 *  for it, most of them to load its plug-ins. It is only read. */
static hwloc_topology_t machine;

/** Load the machine; NULL if hwloc does not know it. Of threads that come at once, one's stays. */
static hwloc_topology_t find_machine(void) {
    hwloc_topology_t known = __atomic_load_n(&machine, __ATOMIC_ACQUIRE), loaded;
    if (known || hwloc_topology_init(&loaded))
        return known;
#if HWLOC_API_VERSION >= 0x00020000
    hwloc_topology_set_all_types_filter(loaded, HWLOC_TYPE_FILTER_KEEP_NONE);
    hwloc_topology_set_type_filter(loaded, HWLOC_OBJ_CORE, HWLOC_TYPE_FILTER_KEEP_ALL);
#endif
#if defined __linux__ && HWLOC_API_VERSION >= 0x00020100
    /* The system knows the cores: no need to go from one to the next and ask each. */
    hwloc_topology_set_components(loaded, HWLOC_TOPOLOGY_COMPONENTS_FLAG_BLACKLIST, "x86");
#endif
    if (!hwloc_topology_load(loaded) &&
        __atomic_compare_exchange_n(&machine, &known, loaded, 0, __ATOMIC_ACQ_REL,
                                    __ATOMIC_ACQUIRE))
        return loaded;
    hwloc_topology_destroy(loaded);
    return known;
}

/** Return the core after core (NULL: the first) that has an allowed hardware thread; a hardware
 * thread is one where hwloc knows no cores. */
static hwloc_obj_t next_core(hwloc_topology_t topology, hwloc_const_cpuset_t allowed,
                             hwloc_obj_t core) {
    hwloc_obj_type_t type =
        hwloc_get_nbobjs_by_type(topology, HWLOC_OBJ_CORE) > 0 ? HWLOC_OBJ_CORE : HWLOC_OBJ_PU;
    do
        core = hwloc_get_next_obj_by_type(topology, type, core);
    while (core && !hwloc_bitmap_intersects(core->cpuset, allowed));
    return core;
}

static void release_cores(struct pl_cores *cores) {
    for (int t = 0; cores && t < cores->n; t++) {
        if (cores->core)
            hwloc_bitmap_free(cores->core[t]);
        if (cores->former)
            hwloc_bitmap_free(cores->former[t]);
    }
    if (cores) {
        pl_free(cores->core);
        pl_free(cores->former);
    }
    pl_free(cores);
}

/** Choose the first allowed hardware thread of each core, as many as n. The calling thread, which
 * is the first, stays on its core: moved to another one, where the system has just woken the thread
 * that belongs to the first's, it can be in the way of that for 4 ms. NULL without memory. */
static struct pl_cores *choose_cores(hwloc_topology_t topology, hwloc_const_cpuset_t allowed,
                                     int n) {
    struct pl_cores *cores = pl_alloc_zero(1, sizeof *cores);
    hwloc_cpuset_t here = hwloc_bitmap_alloc();
    hwloc_obj_t before = NULL, core = NULL;
    /* The core before the one that the calling thread runs on, so that this comes next. */
    if (here && hwloc_topology_is_thissystem(topology) &&
        !hwloc_get_last_cpu_location(topology, here, HWLOC_CPUBIND_THREAD))
        while ((core = next_core(topology, allowed, core)) &&
               !hwloc_bitmap_intersects(core->cpuset, here))
            before = core;
    hwloc_bitmap_free(here);
    core = core ? before : NULL;
    if (!cores)
        return NULL;
    *cores = (struct pl_cores){.topology = topology,
                               .n = n,
                               .core = pl_alloc_zero(n, sizeof *cores->core),
                               .former = pl_alloc_zero(n, sizeof *cores->former)};
    int done = cores->core && cores->former;
    for (int t = 0; done && t < n; t++) {
        core = next_core(topology, allowed, core);
        if (!core)
            core = next_core(topology, allowed, NULL);
        cores->core[t] = hwloc_bitmap_dup(core->cpuset);
        cores->former[t] = hwloc_bitmap_alloc();
        done = cores->core[t] && cores->former[t];
        if (done) {
            hwloc_bitmap_and(cores->core[t], cores->core[t], allowed);
            hwloc_bitmap_singlify(cores->core[t]);
        }
    }
    if (done)
        return cores;
    release_cores(cores);
    return NULL;
}

/** Decide on the number of threads, unless it was given, and on their cores. */
static void prepare_binding(pl_placement *placement, int threads) {
    hwloc_topology_t topology = find_machine();
    if (!topology)
        return;
    /* The hardware threads that the process may use, those of another machine all. */
    const int is_here = hwloc_topology_is_thissystem(topology);
    hwloc_cpuset_t allowed = hwloc_bitmap_dup(hwloc_topology_get_topology_cpuset(topology));
    hwloc_cpuset_t set = hwloc_bitmap_alloc();
    if (allowed && set && is_here && !hwloc_get_cpubind(topology, set, HWLOC_CPUBIND_PROCESS))
        hwloc_bitmap_and(allowed, allowed, set);
    int n_cores = 0, n_nodes = 0;
    for (hwloc_obj_t core = NULL; allowed && (core = next_core(topology, allowed, core));)
        n_cores++;
    for (hwloc_obj_t node = NULL;
         allowed && (node = hwloc_get_next_obj_by_type(topology, HWLOC_OBJ_NUMANODE, node));)
        n_nodes += hwloc_bitmap_intersects(node->cpuset, allowed);
    placement->is_near = allowed && n_nodes <= 1;
    if (is_here && threads <= 0 && n_cores > 0 && n_cores < placement->threads)
        placement->threads = n_cores;
    if (n_cores >= 2 && placement->threads == n_cores)
        placement->cores = choose_cores(topology, allowed, n_cores);
    if (placement->cores && is_here) {
        char list[PL_PLACEMENT_TEXT / 2];
        placement->cores->binds = 1;
        if (set)
            hwloc_bitmap_zero(set);
        for (int t = 0; set && t < n_cores; t++)
            hwloc_bitmap_or(set, set, placement->cores->core[t]);
        if (set && hwloc_bitmap_list_snprintf(list, sizeof list, set) > 0)
            snprintf(placement->text, sizeof placement->text, "one thread per core, on CPUs %s",
                     list);
    }
    hwloc_bitmap_free(set);
    hwloc_bitmap_free(allowed);
}

/** Bind the calling thread to cpus: by the system's own call where that is possible, as
 *  hwloc_set_cpubind writes to what malloc returned on Linux (2.9), be it NULL. */
static void bind_to(hwloc_topology_t topology, hwloc_const_cpuset_t cpus) {
#if defined(HWLOC_GLIBC_SCHED_H) && defined(HWLOC_HAVE_CPU_SET)
    const int last = hwloc_bitmap_last(cpus);
    cpu_set_t set;
    if (last >= 0 && last < CPU_SETSIZE) {
        hwloc_cpuset_to_glibc_sched_affinity(topology, cpus, &set, sizeof set);
        sched_setaffinity(0, sizeof set, &set);
        return;
    }
#endif
    hwloc_set_cpubind(topology, cpus, HWLOC_CPUBIND_THREAD);
}

static void bind_thread(void *context, int64_t begin, int64_t end, int thread) {
    const struct pl_cores *cores = context;
    hwloc_bitmap_t former = cores->former[thread];
    (void)begin;
    (void)end;
    if (!hwloc_get_cpubind(cores->topology, former, HWLOC_CPUBIND_THREAD))
        bind_to(cores->topology, cores->core[thread]);
    else
        hwloc_bitmap_zero(former); /* it could not be brought back */
}

static void restore_thread(void *context, int64_t begin, int64_t end, int thread) {
    const struct pl_cores *cores = context;
    (void)begin;
    (void)end;
    if (!hwloc_bitmap_iszero(cores->former[thread]))
        bind_to(cores->topology, cores->former[thread]);
}

#endif

pl_placement *pl_placement_create(int threads, int bind) {
    pl_placement *placement = pl_alloc_zero(1, sizeof *placement);
    if (!placement)
        return NULL;
    placement->threads = pl_thread_count(threads);
    snprintf(placement->text, sizeof placement->text, "not bound");
#ifdef PL_HWLOC
    if (bind && placement->threads > 1) /* one is never bound: not to look costs less */
        prepare_binding(placement, threads);
#else
    (void)bind;
#endif
    placement->is_near |= placement->threads == 1;
    return placement;
}

void pl_placement_destroy(pl_placement *placement) {
    if (!placement)
        return;
#ifdef PL_HWLOC
    release_cores(placement->cores);
#endif
    pl_free(placement);
}

void pl_placement_forget_machine(void) {
#ifdef PL_HWLOC
    if (machine)
        hwloc_topology_destroy(machine);
    machine = NULL;
#endif
}

int pl_placement_cpu(const pl_placement *placement, int thread) {
#ifdef PL_HWLOC
    if (placement->cores)
        return hwloc_bitmap_first(placement->cores->core[thread]);
#else
    (void)placement;
    (void)thread;
#endif
    return -1;
}

void pl_placement_enter(pl_placement *placement) {
#ifdef PL_HWLOC
    if (placement->cores && placement->cores->binds)
        pl_on_each_thread(placement->threads, bind_thread, placement->cores);
#else
    (void)placement;
#endif
}

void pl_placement_leave(pl_placement *placement) {
#ifdef PL_HWLOC
    if (placement->cores && placement->cores->binds)
        pl_on_each_thread(placement->threads, restore_thread, placement->cores);
#else
    (void)placement;
#endif
}
