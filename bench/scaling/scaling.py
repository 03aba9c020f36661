#!/usr/bin/env python3
"""scaling: measure boxes by threads.

    scaling.py PROGRAMS RESULT.json THREADS BOX ... -- N=BOX ...

THREADS: a list as in 1,2,4, for each BOX (strong scaling); N=BOX: a box for N threads (weak).
"""
import json
import subprocess
import sys

import machine

SWEEPS, REPEATS = "10", "5"


def smooth(programs, mesh, threads, *options):
    """The report of bench_smooth, one entry in runs for each number of threads."""
    done = subprocess.run([f"{programs}/bench_smooth", mesh, "--threads", threads, "--max-sweeps",
                           SWEEPS, "--repeat", REPEATS, *options], stdout=subprocess.PIPE, check=True)
    return json.loads(done.stdout)


def rows(report, **common):
    return [dict(common, elements=report["elements"], **run) for run in report["runs"]]


def main():
    programs, result, threads = sys.argv[1:4]
    split = sys.argv.index("--")
    strong, weak = [], []
    for mesh in sys.argv[4:split]:
        for bound, options in ((True, ()), (False, ("--no-bind",))):
            strong += rows(smooth(programs, mesh, threads, *options), bound=bound)
    for pair in sys.argv[split + 1:]:
        n, mesh = pair.split("=", 1)
        weak += rows(smooth(programs, mesh, n), bound=True)
    with open(result, "w") as file:
        json.dump({"machine": machine.description(), "strong": strong, "weak": weak}, file, indent=1)


if __name__ == "__main__":
    main()
