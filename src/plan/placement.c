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

enum { TEXT_SIZE = 160 };

struct pl_placement {
    int threads;
    int is_near;
    char text[TEXT_SIZE];
#ifdef PL_HWLOC
    hwloc_topology_t topology; /* the machine; NULL: no core is chosen */
    int binds;                 /* 0: threads stay where they are all the same */
    hwloc_cpuset_t *core;      /* [threads] where each thread belongs: one hardware thread */
    hwloc_cpuset_t *former;    /* [threads] where it was before */
#endif
};

#ifdef PL_HWLOC

/** This machine, loaded for the first plan that asks and kept for all: hwloc needs milliseconds
 *  for it, most of them to load its plug-ins. It is only read. */
static hwloc_topology_t machine;

static hwloc_topology_t load_topology(void) {
    hwloc_topology_t topology;
    if (hwloc_topology_init(&topology))
        return NULL;
#if HWLOC_API_VERSION >= 0x00020000
    hwloc_topology_set_all_types_filter(topology, HWLOC_TYPE_FILTER_KEEP_NONE);
    hwloc_topology_set_type_filter(topology, HWLOC_OBJ_CORE, HWLOC_TYPE_FILTER_KEEP_ALL);
#endif
#if defined __linux__ && HWLOC_API_VERSION >= 0x00020100
    /* The system knows the cores: no need to go from one to the next and ask each. */
    hwloc_topology_set_components(topology, HWLOC_TOPOLOGY_COMPONENTS_FLAG_BLACKLIST, "x86");
#endif
    if (hwloc_topology_load(topology)) {
        hwloc_topology_destroy(topology);
        return NULL;
    }
    return topology;
}

/** The machine; NULL if hwloc does not know it. Of threads that come at once, one's stays. */
static hwloc_topology_t find_machine(void) {
    hwloc_topology_t known = __atomic_load_n(&machine, __ATOMIC_ACQUIRE);
    if (known)
        return known;
    hwloc_topology_t loaded = load_topology();
    if (loaded && !__atomic_compare_exchange_n(&machine, &known, loaded, 0, __ATOMIC_ACQ_REL,
                                               __ATOMIC_ACQUIRE)) {
        hwloc_topology_destroy(loaded);
        return known;
    }
    return loaded;
}

/** The hardware threads that the process may use, those of another machine all; NULL: out of
 *  memory. */
static hwloc_cpuset_t find_allowed(hwloc_topology_t topology) {
    hwloc_cpuset_t allowed = hwloc_bitmap_dup(hwloc_topology_get_topology_cpuset(topology));
    hwloc_cpuset_t given = hwloc_bitmap_alloc();
    if (allowed && given && hwloc_topology_is_thissystem(topology) &&
        !hwloc_get_cpubind(topology, given, HWLOC_CPUBIND_PROCESS))
        hwloc_bitmap_and(allowed, allowed, given);
    hwloc_bitmap_free(given);
    return allowed;
}

/** The core after core (NULL: the first) that has an allowed hardware thread; a hardware thread is
 *  one where hwloc knows no cores. */
static hwloc_obj_t next_core(hwloc_topology_t topology, hwloc_const_cpuset_t allowed,
                             hwloc_obj_t core) {
    hwloc_obj_type_t type =
        hwloc_get_nbobjs_by_type(topology, HWLOC_OBJ_CORE) > 0 ? HWLOC_OBJ_CORE : HWLOC_OBJ_PU;
    do
        core = hwloc_get_next_obj_by_type(topology, type, core);
    while (core && !hwloc_bitmap_intersects(core->cpuset, allowed));
    return core;
}

static int count_cores(hwloc_topology_t topology, hwloc_const_cpuset_t allowed) {
    int cores = 0;
    for (hwloc_obj_t core = NULL; (core = next_core(topology, allowed, core));)
        cores++;
    return cores;
}

/** The NUMA nodes of allowed hardware threads; 0 where hwloc knows of none. */
static int count_nodes(hwloc_topology_t topology, hwloc_const_cpuset_t allowed) {
    int nodes = 0;
    for (hwloc_obj_t node = NULL;
         (node = hwloc_get_next_obj_by_type(topology, HWLOC_OBJ_NUMANODE, node));)
        nodes += hwloc_bitmap_intersects(node->cpuset, allowed);
    return nodes;
}

/** The core before the one that the calling thread runs on, so that this comes next; NULL: the
 * first comes next. */
static hwloc_obj_t core_before(hwloc_topology_t topology, hwloc_const_cpuset_t allowed) {
    hwloc_cpuset_t here = hwloc_bitmap_alloc();
    hwloc_obj_t before = NULL, core = NULL;
    if (here && hwloc_topology_is_thissystem(topology) &&
        !hwloc_get_last_cpu_location(topology, here, HWLOC_CPUBIND_THREAD))
        while ((core = next_core(topology, allowed, core)) &&
               !hwloc_bitmap_intersects(core->cpuset, here))
            before = core;
    hwloc_bitmap_free(here);
    return core ? before : NULL;
}

/** The hardware threads of the placement's threads: the first allowed one of each core. The calling
 *  thread, which is the first, stays on its core: moved to another one, where the system has just
 *  woken the thread that belongs to the first's, it can be in the way of that for 4 ms. */
static int choose_cores(pl_placement *placement, hwloc_const_cpuset_t allowed) {
    placement->core = pl_alloc_zero(placement->threads, sizeof *placement->core);
    placement->former = pl_alloc_zero(placement->threads, sizeof *placement->former);
    if (!placement->core || !placement->former)
        return 0;
    hwloc_obj_t core = core_before(placement->topology, allowed);
    for (int t = 0; t < placement->threads; t++) {
        core = next_core(placement->topology, allowed, core);
        if (!core)
            core = next_core(placement->topology, allowed, NULL);
        placement->core[t] = hwloc_bitmap_dup(core->cpuset);
        placement->former[t] = hwloc_bitmap_alloc();
        if (!placement->core[t] || !placement->former[t])
            return 0;
        hwloc_bitmap_and(placement->core[t], placement->core[t], allowed);
        hwloc_bitmap_singlify(placement->core[t]);
    }
    return 1;
}

static void describe_binding(pl_placement *placement) {
    hwloc_cpuset_t all = hwloc_bitmap_alloc();
    char list[TEXT_SIZE / 2];
    for (int t = 0; all && t < placement->threads; t++)
        hwloc_bitmap_or(all, all, placement->core[t]);
    if (all && hwloc_bitmap_list_snprintf(list, sizeof list, all) > 0)
        snprintf(placement->text, sizeof placement->text, "one thread per core, on CPUs %s", list);
    hwloc_bitmap_free(all);
}

static void release_cores(pl_placement *placement) {
    for (int t = 0; t < placement->threads; t++) {
        if (placement->core)
            hwloc_bitmap_free(placement->core[t]);
        if (placement->former)
            hwloc_bitmap_free(placement->former[t]);
    }
    pl_free(placement->core);
    pl_free(placement->former);
    placement->core = placement->former = NULL;
    placement->topology = NULL;
}

static void prepare_binding(pl_placement *placement, int threads) {
    hwloc_topology_t topology = placement->topology = find_machine();
    hwloc_cpuset_t allowed = topology ? find_allowed(topology) : NULL;
    if (!allowed) {
        placement->topology = NULL;
        return;
    }
    const int is_here = hwloc_topology_is_thissystem(topology);
    const int cores = count_cores(topology, allowed);
    placement->is_near = count_nodes(topology, allowed) <= 1;
    if (is_here && threads <= 0 && cores > 0 && cores < placement->threads)
        placement->threads = cores;
    if (cores < 2 || placement->threads != cores || !choose_cores(placement, allowed))
        release_cores(placement);
    else if (is_here) {
        placement->binds = 1;
        describe_binding(placement);
    }
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
    pl_placement *placement = context;
    hwloc_bitmap_t former = placement->former[thread];
    (void)begin;
    (void)end;
    if (!hwloc_get_cpubind(placement->topology, former, HWLOC_CPUBIND_THREAD))
        bind_to(placement->topology, placement->core[thread]);
    else
        hwloc_bitmap_zero(former); /* it could not be brought back */
}

static void restore_thread(void *context, int64_t begin, int64_t end, int thread) {
    pl_placement *placement = context;
    (void)begin;
    (void)end;
    if (!hwloc_bitmap_iszero(placement->former[thread]))
        bind_to(placement->topology, placement->former[thread]);
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
    release_cores(placement);
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

int pl_placement_threads(const pl_placement *placement) {
    return placement->threads;
}

int pl_placement_cpu(const pl_placement *placement, int thread) {
#ifdef PL_HWLOC
    if (placement->topology)
        return hwloc_bitmap_first(placement->core[thread]);
#else
    (void)placement;
    (void)thread;
#endif
    return -1;
}

int pl_placement_is_near(const pl_placement *placement) {
    return placement->is_near;
}

const char *pl_placement_text(const pl_placement *placement) {
    return placement->text;
}

void pl_placement_enter(pl_placement *placement) {
#ifdef PL_HWLOC
    if (placement->binds)
        pl_on_each_thread(placement->threads, bind_thread, placement);
#else
    (void)placement;
#endif
}

void pl_placement_leave(pl_placement *placement) {
#ifdef PL_HWLOC
    if (placement->binds)
        pl_on_each_thread(placement->threads, restore_thread, placement);
#else
    (void)placement;
#endif
}
