#!/usr/bin/env python3
"""tables: smooth each mesh by each method, solve on the results, print Markdown.

   tables.py BUILD OUT.json MESH.mesh...    smoothed meshes beside MESH, figures in OUT.json"""
import json
import math
import os
import sys

import medit
from methods import METHODS, quality
from poisson import figures

CHECK = 1e-9  # largest error of a linear solution that rounding can explain
COLUMNS = ("inverted", "RMS RR", "max RR", "L2 error %", "H1 error %", "lambda_max(K)", "condition",
           "CG", "dt heat", "dt wave", "dt wave, free")


def step_sizes(found):
    """Stable steps of forward Euler and of central differences; none where energy can grow."""
    inner, natural = found["largest_by_mass"], found["largest_by_mass_natural"]
    if not found["definite"] or inner is None:
        return ["none"] * 3
    return [f"{2 / inner:.3g}", f"{2 / math.sqrt(inner):.3g}",
            f"{2 / math.sqrt(natural):.3g}" if natural else "none"]


def cells(worth, found):
    definite = found["definite"]
    return [str(worth["inverted"]), f"{worth['rms_radius_ratio']:.4g}",
            f"{worth['max_radius_ratio']:.4g}", f"{100 * found['l2']:.3g}",
            f"{100 * found['h1']:.3g}", f"{found['largest']:.3g}",
            f"{found['largest'] / found['smallest']:.3g}" if definite else "indefinite",
            str(found["iterations"] or "fails"), *step_sizes(found)]


def examine(build, path):
    found = figures(*medit.read(path))
    if found["linear_error"] > CHECK:
        sys.exit(f"tables: {path}: a linear solution is not met, off by {found['linear_error']:g}")
    return {"quality": quality(build, path), "figures": found}


def compare(build, path):
    """The figures of a mesh and of what each method makes of it."""
    stem = os.path.splitext(path)[0]
    results = {"the mesh as it is": examine(build, path)}
    for name, smooth in METHODS.items():
        out = f"{stem}.{name.replace(' ', '_').replace(',', '')}.mesh"
        smooth(build, path, out)
        results[name] = examine(build, out)
    return results


def print_table(name, results):
    size = results["the mesh as it is"]["figures"]
    print(f"**{name}**: {size['elements']} tetrahedra, {size['nodes']} nodes, {size['inner']} of "
          f"them inside\n\n| | {' | '.join(COLUMNS)} |\n| --- |{' --: |' * len(COLUMNS)}")
    for method, result in results.items():
        print(f"| {method} | {' | '.join(cells(result['quality'], result['figures']))} |")
    print()


def main():
    build, report, *paths = sys.argv[1:]
    everything = {}
    for path in paths:
        name = os.path.splitext(os.path.basename(path))[0]
        everything[name] = compare(build, path)
        print_table(name, everything[name])
    with open(report, "w", encoding="utf-8") as file:
        json.dump(everything, file, indent=1)


if __name__ == "__main__":
    main()
