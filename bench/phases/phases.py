#!/usr/bin/env python3
"""phases: run planish from file to file.   phases.py PROGRAMS RESULT.json BOX ..."""
import itertools
import json
import mmap
import os
import subprocess
import sys
import tempfile
import time

import machine

REPEATS, MANY, REPEATS_OF_MANY = 5, 3_000_000, 3  # from so many elements on
MEMORY = 4  # times the file: what a run takes, and what it writes


def smooth(programs, mesh, threads, *options):
    """What the program reports of one run, in short."""
    with tempfile.TemporaryDirectory(dir=os.path.dirname(mesh)) as folder:
        out = os.path.join(folder, "out" + os.path.splitext(mesh)[1])
        done = subprocess.run([f"{programs}/planish", "smooth", mesh, "-o", out, "-j", str(threads),
                               "-q", "--json", "-", *options], stdout=subprocess.PIPE, check=True)
    report = json.loads(done.stdout)
    return {"file": os.path.basename(mesh), "bytes": os.path.getsize(mesh), "threads": threads,
            "elements": report["mesh"]["elements"], "free_nodes": report["mesh"]["free_nodes"],
            "sweeps": len(report["sweeps"]), "visits": sum(s["visits"] for s in report["sweeps"]),
            "sweeps_s": sum(s["seconds"] for s in report["sweeps"]),
            "seconds": report["seconds"], "peak_bytes": report["peak_memory_bytes"],
            "rms": [report[when]["rms_radius_ratio"] for when in ("before", "after")]}


def warm(path):
    """Read a file once, so that it is in the disk cache."""
    with open(path, "rb") as file:
        while file.read(1 << 24):
            pass


def touch(size):
    """Use so much memory for a moment, and say how long that took. A virtual machine's host has to
    find it otherwise, seconds for a gigabyte, which the runs of small meshes have behind them."""
    begin = time.monotonic()
    with mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS) as memory:
        memory.madvise(mmap.MADV_HUGEPAGE)
        memory[::mmap.PAGESIZE] = bytes(-(-size // mmap.PAGESIZE))
    return time.monotonic() - begin


def copy(path):
    """Write what a file holds to another one, as a run does, and say how long that took: no run can
    write faster."""
    with open(path, "rb") as file, tempfile.TemporaryFile(dir=os.path.dirname(path)) as out:
        begin = time.monotonic()
        while data := file.read(1 << 20):
            out.write(data)
        return time.monotonic() - begin


def middle(runs):
    """The run that took the median time in all, of an odd number."""
    return sorted(runs, key=lambda run: run["seconds"]["total"])[len(runs) // 2]


def main():
    programs, result = sys.argv[1:3]
    about = machine.description()
    threads = sorted({1, about["cpus"]})
    runs, touched, copied = {}, [], []
    # In rounds: where the machine is slower for a minute, it is so for meshes of all sizes.
    for _ in range(REPEATS):
        for mesh, n in itertools.product(sys.argv[3:], threads):
            of_mesh = runs.setdefault((mesh, n), [])
            if len(of_mesh) == REPEATS_OF_MANY and of_mesh[0]["elements"] > MANY:
                continue
            warm(mesh)
            size = MEMORY * os.path.getsize(mesh)
            touched.append({"bytes": size, "seconds": touch(size)})
            of_mesh.append(smooth(programs, mesh, n))
            copied.append({"bytes": os.path.getsize(mesh), "seconds": copy(mesh)})
    growth = [middle(of_mesh) for of_mesh in runs.values()]
    with open(result, "w") as file:
        json.dump({"machine": about, "growth": growth, "touched": touched,
                   "copied": copied}, file, indent=1)


if __name__ == "__main__":
    main()
