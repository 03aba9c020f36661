#!/usr/bin/env python3
"""Compare --objective worst with the limit of the worst element.

    worst.py BUILD MESH ...

A row for each mesh and measure: the worst value of elements with a movable node after the default run, after
--objective worst, and with --worst-rise 10; the limit that a sequential linear program over all free nodes reaches
from there; the rises of the RMS; smoothing times on one thread.
"""
import json
import os
import subprocess
import sys
import tempfile

import limit
import machine

MEASURES = {"dihedral": "smallest angle", "radius-ratio": "largest RR"}


def smooth(build, mesh, out, *options):
    """Return the JSON result of a run of planish, and write its mesh to out."""
    report = out + ".json"
    subprocess.run(
        [os.path.join(build, "planish"), "smooth", mesh, "-o", out, "-j", "1", "--json", report, "-q", *options],
        check=True)
    with open(report, encoding="utf-8") as f:
        return json.load(f)


def row(build, mesh, measure, folder):
    """Return the cells of a row."""
    out = os.path.join(folder, "out" + os.path.splitext(mesh)[1])
    worst = ("--objective", "worst", "--worst-measure", measure)
    plain = smooth(build, mesh, out)
    default = smooth(build, mesh, out, *worst)
    free = smooth(build, mesh, out, *worst, "--worst-rise", "10")
    best = limit.limit_of(out, measure) if limit.is_possible() else None

    def value(result):
        return result["worst"]["after"]

    def rise(result):
        return f'{100 * (result["worst"]["objective_after"] / result["worst"]["objective_before"] - 1):.2f} %'

    cells = [os.path.basename(mesh), MEASURES[measure], f'{default["worst"]["before"]:.3f}', f"{value(default):.3f}",
             f"{value(free):.3f}", "" if best is None else f"{best:.3f}", rise(default), rise(free)]
    return cells + [f'{r["seconds"]["smooth"]:.3f}' for r in (plain, default, free)]


def main():
    build, meshes = sys.argv[1], sys.argv[2:]
    print(machine.line(machine.description()) + "\n")
    print("| mesh | measure | default run | worst | rise 10 | limit | rise of the RMS | with rise 10 "
          "| s, default run | s, worst | s, rise 10 |")
    print("| --- | --- " + "| --: " * 9 + "|")
    with tempfile.TemporaryDirectory() as folder:
        for mesh in meshes:
            for measure in MEASURES:
                print("| " + " | ".join(row(build, mesh, measure, folder)) + " |", flush=True)


if __name__ == "__main__":
    main()
