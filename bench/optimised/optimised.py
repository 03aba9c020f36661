#!/usr/bin/env python3
"""optimised: what planish adds to meshes that have been optimised already.

   optimised.py BUILD-FOLDER MESH ...

Ends with 1 if anything became worse: the worst radius ratio or the smallest angle."""
import json
import os
import subprocess
import sys

import machine

WORST = ("--objective", "worst", "--worst-measure")
RUNS = (("planish", ()),
        ("worst dihedral", (*WORST, "dihedral")),
        ("worst radius ratio", (*WORST, "radius-ratio")),
        ("slide", ("--slide", "auto")),
        ("slide, worst dihedral", ("--slide", "auto", *WORST, "dihedral")),
        ("slide, worst radius ratio", ("--slide", "auto", *WORST, "radius-ratio")))


def smooth(build, mesh, options):
    folder = f"{build}/results/optimised"
    out = f"{folder}/out{os.path.splitext(mesh)[1]}"
    command = [f"{build}/planish", "smooth", mesh, "-o", out, "-j", "1", "-q", "--json",
               f"{folder}/report.json", *options]
    if subprocess.run(command, check=False).returncode != 0:
        sys.exit(f"optimised: failed: {' '.join(command)}")
    with open(f"{folder}/report.json", encoding="utf-8") as report:
        return json.load(report)


def row(name, elements, quality, rest):
    print(f"| {name} | {elements} | {quality['rms_radius_ratio']:.4f} | {quality['max_radius_ratio']:.4g} | "
          f"{quality['max_radius_ratio_movable']:.4g} | {quality['min_dihedral_deg']:.2f} | "
          f"{quality['min_dihedral_movable_deg']:.2f} | {rest} |")


def main():
    build, meshes = sys.argv[1], sys.argv[2:]
    worse = 0
    print(machine.line(machine.description()))
    print("\n| mesh | elements | RMS of RR | worst RR | with a free node | smallest angle | with a free node | "
          "put back | smooth s |")
    print("| --- | --: | --: | --: | --: | --: | --: | --: | --: |")
    for mesh in meshes:
        for i, (name, options) in enumerate(RUNS):
            r = smooth(build, mesh, options)
            before, after = r["before"], r["after"]
            if i == 0:
                row(os.path.basename(mesh), r["mesh"]["elements"], before, " |")
            row(name, "", after, f"{r['put_back']} | {r['seconds']['smooth']:.3f}")
            worse += (after["max_radius_ratio_movable"] > before["max_radius_ratio_movable"]
                      or after["min_dihedral_movable_deg"] < before["min_dihedral_movable_deg"] - 1e-9)
    print(f"\nMade worse: {worse} of {len(meshes) * len(RUNS)} runs.")
    return int(worse > 0)


if __name__ == "__main__":
    sys.exit(main())
