#!/usr/bin/env python3
"""boundary: planish with the boundary held, sliding, and on bad elements alone.

   boundary.py BUILD-FOLDER MESH ..."""
import json
import os
import subprocess
import sys

import machine

WORSE, REPEATS = 3, 5


def smooth(build, mesh, *options):
    """The report of one run on one thread."""
    folder = f"{build}/results/boundary"
    out = f"{folder}/out{os.path.splitext(mesh)[1]}"
    command = [f"{build}/planish", "smooth", mesh, "-o", out, "-j", "1", "-q", "--json",
               f"{folder}/report.json", *options]
    if subprocess.run(command, check=False).returncode not in (0, 1):
        sys.exit(f"boundary: failed: {' '.join(command)}")
    with open(f"{folder}/report.json", encoding="utf-8") as report:
        return json.load(report)


def slides(build, meshes):
    print("| mesh | elements | boundary | nodes that slide | worst RR | smallest angle | RMS of RR | "
          "elements without a free node | their worst RR | shape s | smooth s |")
    print("| --- | --: | --- | --: | --: | --: | --: | --: | --: | --: | --: |")
    for mesh in meshes:
        for name, options in (("held", ()), ("slides", ("--slide", "auto"))):
            r = smooth(build, mesh, *options)
            after, fixed = r["after"], r["fixed"]
            if name == "held":
                before = r["before"]
                print(f"| {os.path.basename(mesh)} | {r['mesh']['elements']} | as it came | | "
                      f"{before['max_radius_ratio']:.4g} | {before['min_dihedral_deg']:.3g} | "
                      f"{before['rms_radius_ratio']:.4f} | | | | |")
            floor = f"{fixed['max_radius_ratio']:.4g}" if fixed["count"] else ""
            print(f"| | | {name} | {r['mesh']['sliding_nodes']} | {after['max_radius_ratio']:.4g} | "
                  f"{after['min_dihedral_deg']:.3g} | {after['rms_radius_ratio']:.4f} | "
                  f"{fixed['count']} | {floor} | {r['seconds']['shape']:.3f} | "
                  f"{r['seconds']['smooth']:.3f} |")


def gain(report):
    """How much the sum of RR^2 fell."""
    n, before, after = (report["mesh"]["elements"], report["before"], report["after"])
    return n * (before["rms_radius_ratio"] ** 2 - after["rms_radius_ratio"] ** 2)


def in_memory(build, mesh, *options):
    """Seconds of plan and smoothing on one thread, the best of the repeats."""
    command = [f"{build}/bench/bench_smooth", mesh, "--repeat", str(REPEATS), *options]
    found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return found["runs"][0]


def selection(build, meshes):
    print("| mesh | only worse than | nodes that may move | plan s | plan and smoothing s | "
          "share of the whole gain in the sum of RR^2 |")
    print("| --- | --: | --: | --: | --: | --: |")
    for mesh in meshes:
        whole = gain(smooth(build, mesh))
        for limit in (None, 2, WORSE, 6):
            options = () if limit is None else ("--only-worse-than", str(limit))
            r, run = smooth(build, mesh, *options), in_memory(build, mesh, *options)
            print(f"| {os.path.basename(mesh)} | {limit or 'all'} | {r['mesh']['free_nodes']} | "
                  f"{run['setup_s']:.3f} | {run['whole_s']:.3f} | {100 * gain(r) / whole:.1f} % |")


def main():
    build, meshes = sys.argv[1], sys.argv[2:]
    print(machine.line(machine.description()))
    print("\n#### The boundary held, and sliding\n")
    slides(build, meshes)
    print("\n#### Bad elements alone, one thread, in memory\n")
    selection(build, meshes)


if __name__ == "__main__":
    main()
