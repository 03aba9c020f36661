#!/usr/bin/env bash
# MFEM meshes, straight, as grid functions of both orderings, of second order, and periodic: what is
# written differs in values of moved nodes alone, and one mesh is smoothed alike in all its forms.
. "$(dirname "$0")/common.sh"

cat >forms.py <<'END'
"""The cube of make_mesh.py in the forms of MFEM, and a periodic square."""
import random

words = open("cube.mesh").read().split()
at = words.index("Vertices") + 1
points = [[float(x) for x in words[at + 1 + 4 * i:at + 4 + 4 * i]] for i in range(int(words[at]))]
at = words.index("Tetrahedra") + 1
tetrahedra = [[int(v) - 1 for v in words[at + 1 + 5 * i:at + 5 + 5 * i]] for i in range(int(words[at]))]


def write(name, dim, geometry, elements, n_vertices, space, values, ordering, sets=""):
    with open(name, "w") as file:
        file.write("MFEM mesh v1.%d\n\n# forms.py\ndimension\n%d\n\nelements\n%d\n" % (3 if sets else 0, dim, len(elements)))
        for e in elements:
            file.write("1 %d %s\n" % (geometry, " ".join(map(str, e))))
        file.write(sets + "\nboundary\n0\n" + ("\nbdr_attribute_sets\n0\n" if sets else "") + "\nvertices\n%d\n" % n_vertices)
        file.write("\nnodes\nFiniteElementSpace\nFiniteElementCollection: %s\nVDim: %d\nOrdering: %d\n\n" %
                   (space, dim, ordering) if space else "%d\n" % dim)
        if not space or ordering:
            file.write("".join(" ".join(map(repr, v)) + "\n" for v in values))
        else:
            file.write("".join("%r\n" % v[d] for d in range(dim) for v in values))
        file.write("\nmfem_mesh_end\n" if sets else "")


edges = {}
for t in tetrahedra:
    for a, b in ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)):
        edges.setdefault(tuple(sorted((t[a], t[b]))), len(edges))
mids = [[(a + b) / 2 for a, b in zip(points[i], points[j])] for i, j in edges]
n = len(points)
if __name__ == "__main__":
    write("straight.mfem", 3, 4, tetrahedra, n, "", points, 1, '\nattribute_sets\n1\n"the body" 1 1\n')
    write("linear0.mfem", 3, 4, tetrahedra, n, "H1_3D_P1", points, 0)
    write("linear1.mfem", 3, 4, tetrahedra, n, "Linear", points, 1)
    write("quadratic0.mfem", 3, 4, tetrahedra, n, "H1_3D_P2", points + mids, 0)
    write("quadratic1.mfem", 3, 4, tetrahedra, n, "Quadratic", points + mids, 1)
    # A square whose sides are joined: triangles have points of their own.
    m = 6
    random.seed(5)
    place = {(i, j): [i / m, j / m] if {i, j} & {0, m} else [(i + 0.3 * random.random()) / m, (j + 0.3 * random.random()) / m]
             for i in range(m + 1) for j in range(m + 1)}
    corners = [c for i in range(m) for j in range(m)
               for c in (((i, j), (i + 1, j), (i + 1, j + 1)), ((i, j), (i + 1, j + 1), (i, j + 1)))]
    for ordering in 0, 1:
        write("ring%d.mfem" % ordering, 2, 2, [[i % m + m * (j % m) for i, j in c] for c in corners], m * m,
              "L2_T1_2D_P1", [place[p] for c in corners for p in c], ordering)
END
python3 "$cli/make_mesh.py" 5 0.2 cube.mesh
python3 forms.py
cat >values.py <<'END'
"""values(FILE): the coordinates of a file of forms.py. moved(BEFORE, AFTER): the places that differ; nothing else may."""


def values(name):
    lines = open(name).read().split("\n")
    at = lines.index("", max(i for i, l in enumerate(lines) if l.startswith("Ordering"))) if "nodes" in lines else None
    dim = int(lines[lines.index("dimension") + 1])
    at = at + 1 if at else lines.index("vertices") + 3
    found = []
    for line in lines[at:]:
        if not line:
            break
        found += map(float, line.split())
    if len(lines[at].split()) == 1:
        n = len(found) // dim
        return [[found[d * n + i] for d in range(dim)] for i in range(n)]
    return [found[i:i + dim] for i in range(0, len(found), dim)]


def moved(before, after):
    old, new = open(before).read().split("\n"), open(after).read().split("\n")
    assert len(old) == len(new)
    changed = [i for i in range(len(old)) if old[i] != new[i]]
    assert all(len(old[i].split()) == len(new[i].split()) for i in changed)
    first = max(i for i, l in enumerate(old) if l.startswith(("vertices", "Ordering")))
    assert all(i > first for i in changed)
    return [i for i, (a, b) in enumerate(zip(values(before), values(after))) if a != b]
END

expect_status 0 "$program" smooth cube.mesh -o smooth.mesh -q
for form in straight linear0 linear1 quadratic0 quadratic1; do
    expect_status 0 "$program" smooth $form.mfem -o smooth_$form.mfem --json $form.json -q
done
expect_status 0 "$program" smooth straight.mfem -o held.mfem --fix "the body" -q
cmp straight.mfem held.mfem || fail "a set of attributes holds its nodes"
python3 - <<'END' || fail "forms of one mesh are smoothed alike"
import json
from forms import edges, n
from values import moved, values
words = open("smooth.mesh").read().split()
at = words.index("Vertices") + 2
medit = [[float(x) for x in words[at + 4 * i:at + 3 + 4 * i]] for i in range(n)]
for form in "straight", "linear0", "linear1":
    assert values("smooth_%s.mfem" % form) == medit, form
    report = json.load(open(form + ".json"))
    assert report["certified"] and report["moved_nodes"] == len(moved(form + ".mfem", "smooth_%s.mfem" % form)) > 0
for form in "quadratic0", "quadratic1":
    report, found = json.load(open(form + ".json")), values("smooth_%s.mfem" % form)
    assert report["certified"] and report["after"]["counts"] == {"tetrahedron10": 750}, report["after"]["counts"]
    assert moved(form + ".mfem", "smooth_%s.mfem" % form) and found == values("smooth_quadratic0.mfem")
    for k, (i, j) in enumerate(edges):
        assert all(abs((a + b) / 2 - c) < 1e-13 for a, b, c in zip(found[i], found[j], found[n + k])), (i, j)
END

for ordering in 0 1; do
    expect_status 0 "$program" smooth ring$ordering.mfem -o smooth_ring$ordering.mfem --slide auto --json report.json -q
    python3 - $ordering <<'END' || fail "a periodic square"
import json
import sys
from values import moved, values
before, after = "ring%s.mfem" % sys.argv[1], "smooth_ring%s.mfem" % sys.argv[1]
report = json.load(open("report.json"))
assert report["after"]["rms_radius_ratio"] < report["before"]["rms_radius_ratio"] and report["moved_nodes"] == 25
places = {}
for old, new in zip(values(before), values(after)):
    assert places.setdefault(tuple(old), new) == new  # all copies of a point
    assert not {0.0, 1.0} & set(old) or old == new    # the seam
assert len(moved(before, after)) == 6 * 25
END
done

for name in INLINE NURBS NC; do
    echo "MFEM $name mesh v1.0" >refused.mesh
    expect_status 2 "$program" quality refused.mesh
    expect_one_line
    expect_text "refused.mesh:1: 'MFEM $name mesh v1.0'"
done
finish
