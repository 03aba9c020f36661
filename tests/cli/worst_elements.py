"""worst_elements.py MESH N QUALITY.json TABLE: the N worst elements of MESH by textbook formulas, compared
with those in the report and, number by number, in the table of `planish quality --worst N`."""
import json
import math
import re
import sys

import mesh_file
from mesh_file import cross, dot, minus


def angle(a, b):
    return math.degrees(math.atan2(math.hypot(*cross(a, b)), dot(a, b)))


def angles(corner):
    """Dihedral angles of a tetrahedron, between the parts of the other edges that are normal to an
    edge; angles of a triangle."""
    n = len(corner)
    for i in range(n):
        for j in range(i + 1, n) if n == 4 else [i]:
            k, l = (m for m in range(n) if m not in (i, j))
            a, b = (minus(corner[m], corner[i]) for m in (k, l))
            if n == 4:
                e = minus(corner[j], corner[i])
                a, b = (minus(x, [dot(x, e) / dot(e, e) * c for c in e]) for x in (a, b))
            yield angle(a + [0] * (3 - len(a)), b + [0] * (3 - len(b)))


mesh, n = mesh_file.read(sys.argv[1]), int(sys.argv[2])
report = json.load(open(sys.argv[3]))
found = report["quality"]["worst_elements"]
corners, volumes = mesh_file.corners(mesh), mesh_file.volumes(mesh)
by_number = {number: i for i, number in enumerate(mesh.numbers)}
ratio = [mesh_file.radius_ratio(c) if v > 0 else math.inf for c, v in zip(corners, volumes)]

assert len(found) == min(n, len(corners)) == len({e["element"] for e in found})
held = mesh_file.boundary(mesh)
worst = sorted(ratio, reverse=True)[:n]
for element, expected in zip(found, worst):
    i = by_number[element["element"]]
    told = math.inf if element["radius_ratio"] is None else element["radius_ratio"]
    assert math.isclose(ratio[i], expected, rel_tol=1e-9) and math.isclose(told, ratio[i], rel_tol=1e-6)
    of_element = list(angles(corners[i]))
    assert math.isclose(element["min_angle_deg"], min(of_element), abs_tol=1e-4)
    assert math.isclose(element["max_angle_deg"], max(of_element), abs_tol=1e-4)
    centroid = [math.fsum(x) / len(corners[i]) for x in zip(*corners[i])]
    assert len(element["place"]) == mesh.dim
    assert all(math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-14) for a, b in zip(element["place"], centroid))
    places = [mesh.points[m] for m in mesh.elements[i]]
    assert len(element["nodes"]) == mesh.dim + 1
    if sys.argv[1].endswith(".mesh"):  # numbered from 1 on
        assert element["nodes"] == [m + 1 for m in mesh.elements[i]]
        assert element["movable"] == (not held.issuperset(mesh.elements[i]))
inverted = [e["element"] for e in found if e["radius_ratio"] is None]
assert inverted == sorted(inverted) and (not inverted or found[0]["radius_ratio"] is None)

# The table has the same elements in the same order.
lines = open(sys.argv[4]).read().split("\n")
begin = next(k for k, line in enumerate(lines) if re.match(" *element +radius ratio", line))
rows = [lines[k].split() for k in range(begin + 1, begin + 1 + 2 * len(found), 2)]
nodes = [re.match(r" +nodes ([\d ]+)", lines[k]).group(1).split()
         for k in range(begin + 2, begin + 2 + 2 * len(found), 2)]
for element, row, of_row in zip(found, rows, nodes):
    assert row[0] == str(element["element"]) and of_row == list(map(str, element["nodes"]))
    assert row[1] == ("inverted" if element["radius_ratio"] is None else "%.5g" % element["radius_ratio"])
    assert row[2:4] == ["%.4g" % element[key] for key in ("min_angle_deg", "max_angle_deg")]
    assert row[4:] == ["%.5g" % x for x in element["place"]]
