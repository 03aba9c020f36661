#!/usr/bin/env python3
"""badness: smooth one mesh from worse and worse starts; print the work as CSV.

   badness.py BUILD MESH.msh OUT.csv

Starts: the mesh as it is and as smoothed; and from the smoothed one, by bench/spoil, with all nodes
moved at random; with one node in a hundred pushed towards a facet of its star, so that few stars are
bad; and with every node pushed, so that none is good. The meshes are kept beside MESH."""
import csv
import os
import subprocess
import sys

from program import best_of, smooth, sweep_seconds

REPEATS = 5
NEAR = 1.004  # times the RMS where it converges: where the curve bends
MOVES = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 1)
FEW_LEFT = (0.3, 0.1, 0.03, 0.01, 0.001, 0.0001)
FEW = "100"  # one node in so many
SEED = "1"
LEFT = (0.9, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.15, 0.1, 0.05, 0.02, 0.01, 0.001)
BAD = 10  # an element of a larger radius ratio is counted as bad


def spoiled(build, mesh, *amount):
    out = f"{os.path.splitext(mesh)[0]}_{'_'.join(amount)}.msh"
    subprocess.run([f"{build}/bench/spoil", mesh, out, *amount], check=True)
    return out


def starts(build, mesh):
    """series, amount and mesh of each start."""
    good = f"{os.path.splitext(mesh)[0]}_smooth.msh"
    smooth(build, mesh, good)
    yield "as Gmsh made it", "", mesh
    yield "smoothed before", "", good
    for amount in MOVES:
        yield "moved", amount, spoiled(build, good, str(amount))
    for left in FEW_LEFT:
        yield "1 % pushed", left, spoiled(build, good, "push", str(left), SEED, FEW)
    for left in LEFT:
        yield "pushed", left, spoiled(build, good, "push", str(left))


def bad_elements(quality):
    histogram = quality["histogram"]
    bins = zip(histogram["edges"], histogram["counts"])
    return sum(count for edge, count in bins if edge >= BAD)


def work(build, mesh):
    """One row: the start, the way to 0.4 % of the end, and to the end."""
    out = f"{os.path.splitext(mesh)[0]}.out.msh"
    report = best_of(REPEATS, lambda: smooth(build, mesh, out), sweep_seconds)
    os.remove(out)
    before, after, sweeps = report["before"], report["after"], report["sweeps"]
    limit = NEAR * after["rms_radius_ratio"]
    near = 0
    if before["rms_radius_ratio"] > limit:
        near = next(i for i, sweep in enumerate(sweeps, 1) if sweep["rms"] <= limit)
    return {"rms": before["rms_radius_ratio"], "max_rr": before["max_radius_ratio"],
            "bad": bad_elements(before), "elements": report["mesh"]["elements"],
            "sweeps_near": near, "visits_near": sum(sweep["visits"] for sweep in sweeps[:near]),
            "seconds_near": sweep_seconds(report, near), "sweeps": len(sweeps),
            "visits": report["node_visits"], "evaluations": report["evaluations"],
            "seconds": sweep_seconds(report), "final_rms": after["rms_radius_ratio"],
            "final_max_rr": after["max_radius_ratio"]}


def main():
    build, mesh, path = sys.argv[1:]
    rows = [{"series": series, "amount": amount, **work(build, start)}
            for series, amount, start in starts(build, mesh)]
    with open(path, "w", encoding="ascii", newline="") as file:
        table = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
