"""check_untangled.py REPORT.json IN.mesh OUT.mesh LIKE.mesh WHAT: OUT is the tangled IN with other nodes
inside, and REPORT says what is so, by formulas and exact arithmetic of this script's own. WHAT:

solved     all elements are valid
flawed     all but the report's list of unfixable ones, of which there are some
left       there are no more inverted ones than before

The first elements of IN are those of LIKE; but for left, the RMS radius ratio of those among them that
are valid and have an inner node is nearly what it is in LIKE.
"""
import json
import sys
from fractions import Fraction

import mesh_file


def is_positive(corners):
    measure = mesh_file.volume(corners)
    if abs(measure) > 1e-9:
        return measure > 0
    first, *others = [[Fraction(x) for x in point] for point in corners]
    edges = [[x - y for x, y in zip(point, first)] for point in others]
    if len(edges) == 2:
        (a, b), (c, d) = edges
        return a * d - b * c > 0
    a, b, c = edges
    return sum(a[i] * (b[i - 2] * c[i - 1] - b[i - 1] * c[i - 2]) for i in range(3)) > 0


def inverted(mesh):
    return [number for number, corners in zip(mesh.numbers, mesh_file.corners(mesh))
            if not is_positive(corners)]


def rms(mesh, chosen):
    corners = mesh_file.corners(mesh)
    return mesh_file.rms(mesh_file.radius_ratio(corners[i]) for i in chosen)


report = json.load(open(sys.argv[1]))
old, new, like = map(mesh_file.read, sys.argv[2:5])
what = sys.argv[5]
assert what in ("solved", "flawed", "left")

before, after = inverted(old), inverted(new)
assert len(before) == report["before"]["inverted"] > 0
assert len(after) == report["after"]["inverted"] <= len(before)
assert report["certified"] == (not after)
assert set(report["unfixable"]) <= set(after) and report["below_min"] == []

# Only inner nodes move.
assert old.elements == new.elements and len(old.points) == len(new.points)
held = mesh_file.boundary(old)
assert all(old.points[i] == new.points[i] for i in held)

# Untangling comes first.
phases = [sweep["phase"] for sweep in report["sweeps"]]
n = report["untangling_sweeps"]
assert phases == n * ["untangle"] + (len(phases) - n) * ["smooth"], (n, phases)

if what != "left":
    assert n > 0 and phases[-1] == "smooth" and report["stop"] == "converged"
    assert report["sweeps"][-1]["inverted"] == len(after) < len(before)
    assert after == report["unfixable"] and (what == "flawed") == bool(after), after
    count = len(like.elements)
    assert new.elements[:count] == like.elements
    chosen = [i for i in range(count)
              if new.numbers[i] not in after and not held.issuperset(new.elements[i])]
    reached, possible = rms(new, chosen), rms(like, chosen)
    assert abs(reached / possible - 1) < 0.01, (reached, possible)
