#!/usr/bin/env python3
"""share: smoothing's share of the time that meshing and smoothing take together, as Markdown.

   share.py BUILD MESH.msh...      beside each mesh MESH.log: what Gmsh said when it made it

Gmsh's time is the wall time that it logs for meshing (curves, surfaces, volumes): without its start,
the geometry and the file. planish's is set-up and sweeps on one thread, without the files."""
import os
import re
import sys

from program import best_of, smooth, sweep_seconds

REPEATS = 3
FIVE_SWEEPS = 5


def meshing_seconds(log):
    with open(log, encoding="utf-8") as file:
        times = re.findall(r"Done meshing [123]D \(Wall ([0-9.e-]+)s", file.read())
    if not times:
        sys.exit(f"share: {log} names no time")
    return sum(map(float, times))


def smoothing_seconds(report):
    return report["seconds"]["setup"] + sweep_seconds(report)


def best(build, mesh, out, *options):
    return best_of(REPEATS, lambda: smooth(build, mesh, out, *options), smoothing_seconds)


def percent(part, other):
    return f"{100 * part / (part + other):.1f}"


def main():
    build, *meshes = sys.argv[1:]
    print("| mesh | elements | free nodes | Gmsh s | set-up s | 5 sweeps s | share % "
          "| all sweeps s | share % |\n| --- |" + " --: |" * 8)
    for mesh in meshes:
        stem = os.path.splitext(mesh)[0]
        out = f"{stem}.out.msh"
        gmsh = meshing_seconds(f"{stem}.log")
        all_of_it = best(build, mesh, out)
        five = best(build, mesh, out, "--max-sweeps", str(FIVE_SWEEPS))
        size = all_of_it["mesh"]
        print(f"| {os.path.basename(stem)} | {size['elements']} | {size['free_nodes']} "
              f"| {gmsh:.2f} | {all_of_it['seconds']['setup']:.3f} | {sweep_seconds(five):.3f} "
              f"| {percent(smoothing_seconds(five), gmsh)} | {sweep_seconds(all_of_it):.3f} "
              f"| {percent(smoothing_seconds(all_of_it), gmsh)} |")
        os.remove(out)


if __name__ == "__main__":
    main()
