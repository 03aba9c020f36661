#!/usr/bin/env bash
# Nodes of the boundary slide where the shape stays what it is, and nowhere else.
. "$(dirname "$0")/common.sh"

# Two boxes, one in the other, whose boundary nodes are anywhere on their sides: box.mesh, box.vtk
# with every node of the boundary marked, some.vtk with only one of them.
python3 - <<'END' || exit 1
import random

import mesh_file
random.seed(11)
N = 6
index = {}
points = []
for x in range(N + 1):
    for y in range(N + 1):
        for z in range(N + 1):
            index[x, y, z] = len(points)
            walls = [{0, N}, {0, N}, {0, 3, N}]  # regions meet at z = 3
            points.append([c if c in wall else c + random.uniform(-0.12, 0.12)
                           for c, wall in zip((x, y, z), walls)])
elements, regions = [], []
for x in range(N):
    for y in range(N):
        for z in range(N):
            elements += mesh_file.split_cube(index, x, y, z)
            regions += 6 * [1 if z < 3 else 2]
with open("box.mesh", "w") as out:
    print("MeshVersionFormatted 2 Dimension 3\nVertices", len(points), file=out)
    for p in points:
        print(*map(repr, p), 0, file=out)
    print("Tetrahedra", len(elements), file=out)
    for e, r in zip(elements, regions):
        print(*(n + 1 for n in e), r, file=out)
    print("End", file=out)
outer = [any(c in (0, N) for c in p) for p in points]
for name, marks in (("box.vtk", outer), ("some.vtk", [i == outer.index(True) + 9 for i in range(len(points))])):
    with open(name, "w") as out:
        print("# vtk DataFile Version 2.0\nbox\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS",
              len(points), "double", file=out)
        for p in points:
            print(*map(repr, p), file=out)
        print("CELLS", len(elements), 5 * len(elements), file=out)
        for e in elements:
            print(4, *e, file=out)
        print("CELL_TYPES", len(elements), file=out)
        print("10 " * len(elements), file=out)
        print("POINT_DATA", len(points), "\nSCALARS fixed int\nLOOKUP_TABLE default", file=out)
        print(*map(int, marks), file=out)
END

# A square in six decimals, turned: what smoothing has moved has more of them, and slides again.
python3 - <<'END' || exit 1
import math, random
random.seed(3)
N, c, s = 12, math.cos(0.4), math.sin(0.4)
with open("turned.off", "w") as out:
    print("OFF", (N + 1) ** 2, 2 * N * N, 0, file=out)
    for j in range(N + 1):
        for i in range(N + 1):
            x, y = (k / N + (random.uniform(-0.3, 0.3) / N if 0 < k < N else 0) for k in (i, j))
            print("%.6f %.6f 0" % (c * x - s * y, s * x + c * y), file=out)
    for j in range(N):
        for i in range(N):
            a = j * (N + 1) + i
            print(3, a, a + 1, a + N + 2, "\n3", a, a + N + 2, a + N + 1, file=out)
END
expect_status 0 "$program" smooth turned.off -o first.off --slide auto --json report.json -q
expect_json "r['mesh']['sliding_nodes'] > 40"
expect_status 0 "$program" smooth first.off -o second.off --slide auto --json report.json -q
expect_json "r['mesh']['sliding_nodes'] > 40"

# check IN OUT CUT: walls keep their coordinates to the bit, regions their volumes, and nodes of the
# walls have moved along them. CUT: the wall between regions, or none.
check() {
    python3 - "$@" <<'END' || fail "$*"
import math, sys
import mesh_file
old, new = (mesh_file.read(name) for name in sys.argv[1:3])
cut = [float(x) for x in sys.argv[3:]]
walls = [(0, 6), (0, 6), (0, 6, *cut)]
assert old.elements == new.elements and old.regions == new.regions
along = 0
for p, q in zip(old.points, new.points):
    on = [c in wall for c, wall in zip(p, walls)]
    assert all(a == b for a, b, w in zip(p, q, on) if w), (p, q)
    along += any(on) and p != q
assert along > 20, along
for region in set(old.regions) if cut else (0,):
    size = [math.fsum(abs(mesh_file.volume(t)) for t, r in zip(mesh_file.corners(m), m.regions)
                      if r == region or not cut) for m in (old, new)]
    assert math.isclose(*size, rel_tol=1e-14), size
assert min(mesh_file.volumes(new)) > 0
assert mesh_file.rms(map(mesh_file.radius_ratio, mesh_file.corners(new))) < \
    mesh_file.rms(map(mesh_file.radius_ratio, mesh_file.corners(old)))
END
}

expect_status 0 "$program" smooth box.mesh -o held.mesh --json report.json
expect_json "r['mesh']['sliding_nodes'] == 0 and r['mesh']['could_slide'] == 231"
grep -q "231 could slide (--slide auto)" out || fail "the program should say how many could slide"
cp report.json held.json
expect_status 0 "$program" smooth box.mesh -o slid.mesh --slide auto --json report.json
expect_json "r['mesh']['sliding_nodes'] == 231 and r['mesh']['could_slide'] is None and r['certified']"
expect_json "r['after']['rms_radius_ratio'] < json.load(open('held.json'))['after']['rms_radius_ratio']"
grep -q "231 to slide" out || fail "the program should say how many slide"
check box.mesh slid.mesh 3
for threads in 1 2 3; do
    expect_status 0 "$program" smooth box.mesh -o again.mesh --slide auto -j $threads -q
    cmp -s slid.mesh again.mesh || fail "other bytes on $threads threads"
done
expect_status 0 "$program" smooth box.mesh -o one.mesh --slide auto --ignore-regions -q
check box.mesh one.mesh
for more in "--min-volume 0.09" "--objective mean-ratio" "--direction fletcher-reeves" \
    "--max-displacement 0.5h" "--only-worse-than 1.4" "--max-sweeps 1"; do
    # shellcheck disable=SC2086 # options and their values
    expect_status 0 "$program" smooth box.mesh -o more.mesh --slide auto $more --json report.json
    check box.mesh more.mesh 3
done
expect_status 0 "$program" smooth slid.mesh -o none.mesh --slide auto --slide none -q
expect_status 0 "$program" smooth box.mesh -o none.mesh --slide auto --slide none -q
cmp -s none.mesh held.mesh || fail "--slide none should take --slide auto back"

# Files of few digits: planes are as exact as these.
python3 - <<'END' || exit 1
import mesh_file
rows = ((2, -2, 1), (1, 2, 2), (-2, -1, 2))
mesh = mesh_file.read("box.mesh")
for digits in (5, 6, 8, 17):
    with open(f"turned{digits}.mesh", "w") as out:
        print("MeshVersionFormatted 2 Dimension 3\nVertices", len(mesh.points), file=out)
        for p in mesh.points:
            print(*("%.*g" % (digits, mesh_file.dot(row, p) / 3) for row in rows), 0, file=out)
        print("Tetrahedra", len(mesh.elements), file=out)
        for e, r in zip(mesh.elements, mesh.regions):
            print(*(n + 1 for n in e), r, file=out)
        print("End", file=out)
END
for digits in 6 8 17; do
    expect_status 0 "$program" smooth turned$digits.mesh -o out.mesh --slide auto --json report.json
    expect_json "r['mesh']['sliding_nodes'] == 231"
done
expect_status 0 "$program" smooth turned5.mesh -o out.mesh --slide auto --slide-tolerance 1e-9 --json report.json
expect_json "r['mesh']['sliding_nodes'] < 20"
grep -q " to slide" out || fail "how many slide should be said, however few"
expect_status 0 "$program" smooth turned5.mesh -o out.mesh --slide auto --slide-tolerance 1e-4 --json report.json
expect_json "r['mesh']['sliding_nodes'] == 231"

# How many could slide is said where it is true.
expect_status 0 "$program" smooth box.mesh -o out.mesh --only-worse-than 1.4 --json report.json
expect_json "r['mesh']['could_slide'] is None"
grep -q "could slide" out && fail "not all of them could with --only-worse-than"

# VTK's array "fixed": where it names all of the boundary it says no more than that; where it names
# one node that one stays.
expect_status 0 "$program" smooth box.vtk -o slid.vtk --slide auto --json report.json
expect_json "r['mesh']['sliding_nodes'] == 210"
expect_status 0 "$program" smooth box.vtk -o slid.vtk --json report.json
expect_json "r['mesh']['sliding_nodes'] == 0 and r['mesh']['could_slide'] == 210"
expect_status 0 "$program" smooth some.vtk -o slid.vtk --slide auto --json report.json
expect_json "r['mesh']['sliding_nodes'] == 209"
cmp -s <(grep -n . some.vtk | sed -n 15p) <(grep -n . slid.vtk | sed -n 15p) ||
    fail "a marked node moved"

# Groups: the sample's boundary has planes and cylinders, all in one group, and curves.
expect_status 0 "$program" smooth "$sample" -o slid.msh --slide auto --json report.json
expect_json "0 < r['mesh']['sliding_nodes'] and abs(r['after']['total_volume'] / r['before']['total_volume'] - 1) < 1e-13"
for tag in skin 2:2; do
    expect_status 0 "$program" smooth "$sample" -o skin.msh --slide "$tag" -q
    cmp -s slid.msh skin.msh || fail "--slide $tag"
done
expect_status 0 "$program" smooth "$sample" -o held.msh -q
expect_status 0 "$program" smooth "$sample" -o side.msh --slide 2:1 --json report.json
expect_json "r['mesh']['sliding_nodes'] > 0"
cmp -s side.msh held.msh && fail "--slide 2:1 should move more"
cmp -s side.msh slid.msh && fail "--slide 2:1 should move less"
expect_status 0 "$program" smooth "$sample" -o last.msh --slide 2:1 --slide auto -q
cmp -s last.msh slid.msh || fail "--slide auto should take back the groups before it"
expect_status 0 "$program" smooth "$sample" -o fixed.msh --slide auto --fix skin -q
cmp -s fixed.msh held.msh || fail "--fix should come before --slide"

# Wrong words.
expect_status 64 "$program" smooth "$sample" -o no.msh --slide bracket
expect_one_line
expect_text "'bracket' is a group of solid elements, but one of triangles or quadrilaterals is needed; the file has: skin"
expect_status 64 "$program" smooth box.mesh -o no.mesh --slide ""
expect_status 64 "$program" smooth box.mesh -o no.mesh --slide auto --method laplacian
expect_text "--slide has no effect with --method laplacian"
expect_status 64 "$program" smooth box.mesh -o no.mesh --slide-tolerance 1e-6
expect_text "--slide-tolerance has no effect without --slide"
for tolerance in 0 -1 nan 0.1 1e-6x; do
    expect_status 64 "$program" smooth box.mesh -o no.mesh --slide auto --slide-tolerance $tolerance
    expect_text "must be a fraction above 0"
done
expect_no_file no.mesh no.msh

# Periodic sides move together: a cube whose sides x = 0 and x = 4 are pairs of a Gmsh file.
python3 - <<'END' || exit 1
import random

import mesh_file
random.seed(5)
N = 4
inner = lambda c: random.uniform(-0.15, 0.15) if 0 < c < N else 0
push = {(y, z): (inner(y), inner(z)) for y in range(N + 1) for z in range(N + 1)}
index, nodes, elements = {}, [], []
for x in range(N + 1):
    for y in range(N + 1):
        for z in range(N + 1):
            index[x, y, z] = len(nodes) + 1
            dy, dz = push[y, z] if x in (0, N) else (inner(y), inner(z))
            nodes.append((x + inner(x), y + dy, z + dz))
for x in range(N):
    for y in range(N):
        for z in range(N):
            elements += mesh_file.split_cube(index, x, y, z)
with open("pairs.msh", "w") as out:
    print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes", len(nodes), sep="\n", file=out)
    for i, p in enumerate(nodes):
        print(i + 1, *map(repr, p), file=out)
    print("$EndNodes\n$Elements", len(elements), sep="\n", file=out)
    for i, e in enumerate(elements):
        print(i + 1, 4, 2, 1, 1, *e, file=out)
    print("$EndElements\n$Periodic\n1\n2 2 1\nAffine 1 0 0 4 0 1 0 0 0 0 1 0 0 0 0 1", len(push), sep="\n", file=out)
    for y, z in push:
        print(index[N, y, z], index[0, y, z], file=out)
    print("$EndPeriodic", file=out)
END
# pairs OUT MOVED: the sides of OUT are still alike; MOVED or more of the pairs have moved.
pairs() {
    python3 - "$@" <<'END' || fail "pairs of $1"
import sys
import mesh_file
old, new = mesh_file.read("pairs.msh"), mesh_file.read(sys.argv[1])
words = open(sys.argv[1]).read().split()
words = words[words.index("$Periodic"):words.index("$EndPeriodic")][-50:]
moved = 0
for i in range(0, 50, 2):
    a, b = (new.points[int(n) - 1] for n in words[i:i + 2])
    assert a[1:] == b[1:] and a[0] == 4 and b[0] == 0, (a, b)
    moved += a != old.points[int(words[i]) - 1]
assert moved >= int(sys.argv[2]), moved
assert min(mesh_file.volumes(new)) > 0
END
}
expect_status 0 "$program" smooth pairs.msh -o out.msh -q
pairs out.msh 0
for more in "" "--objective worst" "--only-worse-than 1.4" "-j 1" "-j 2"; do
    # shellcheck disable=SC2086 # options and their values
    expect_status 0 "$program" smooth pairs.msh -o out.msh --slide auto --json report.json $more
    pairs out.msh 3
done
expect_json "r['mesh']['sliding_nodes'] > 80 and r['certified']"

finish
