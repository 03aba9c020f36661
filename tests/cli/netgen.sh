#!/usr/bin/env bash
# Meshes that Netgen generates: Netgen loads what is written, with the same elements, materials and
# boundary names; bytes other than those of points do not change. Needs python3-netgen.
. "$(dirname "$0")/common.sh"

python=/usr/bin/python3
"$python" -c "import netgen.csg, netgen.geom2d" >/dev/null 2>&1 ||
    { echo "skipped: no Netgen for Python"; exit 77; }

"$python" - <<'END' >/dev/null || fail "Netgen generates"
from netgen.csg import *
from netgen.geom2d import SplineGeometry

# Two materials.
geometry = CSGeometry()
box = OrthoBrick(Pnt(0, 0, 0), Pnt(1, 1, 1)).bc("outer")
ball = Sphere(Pnt(.5, .5, .5), .3).bc("ball")
geometry.Add((box - ball).mat("air"))
geometry.Add(ball.mat("iron"))
mesh = geometry.GenerateMesh(maxh=0.2)
mesh.Save("ball.vol")
mesh.SecondOrder()
mesh.Save("second.vol")

# Periodic in x.
geometry = CSGeometry()
left = Plane(Pnt(0, 0, 0), Vec(-1, 0, 0)).bc("left")
right = Plane(Pnt(1, 0, 0), Vec(1, 0, 0)).bc("right")
brick = OrthoBrick(Pnt(-1, 0, 0), Pnt(2, 1, 1)).bc("other")
geometry.Add((brick * left * right).mat("cube"))
geometry.PeriodicSurfaces(left, right)
geometry.GenerateMesh(maxh=0.2).Save("periodic.vol")

# Two domains of a plane.
geometry = SplineGeometry()
p = [geometry.AppendPoint(*xy) for xy in ((0, 0), (1, 0), (1, 1), (0, 1))]
for i, name in enumerate(("bottom", "right", "top", "left")):
    geometry.Append(["line", p[i], p[(i + 1) % 4]], bc=name)
geometry.AddCircle((.5, .5), .2, leftdomain=2, rightdomain=1, bc="circle")
geometry.SetMaterial(1, "outer")
geometry.SetMaterial(2, "inner")
geometry.GenerateMesh(maxh=0.1).Save("flat.vol")
END

# same BEFORE AFTER: Netgen finds the same mesh in both, at other places.
same() {
    "$python" - "$@" <<'END' >/dev/null || fail "$2: what Netgen loads"
import sys
from netgen.meshing import Mesh

def load(name):
    mesh = Mesh()
    mesh.Load(name)
    return mesh

def content(mesh):
    dim = mesh.dim
    elements = [[(e.index, [v.nr for v in e.vertices]) for e in group] for group in
                (mesh.Elements1D(), mesh.Elements2D(), mesh.Elements3D())]
    domains = {e.index for e in (mesh.Elements3D() if dim == 3 else mesh.Elements2D())}
    names = [mesh.GetMaterial(i) for i in sorted(domains)]
    n_sides = len({e.index for e in (mesh.Elements2D() if dim == 3 else mesh.Elements1D())})
    sides = [mesh.GetBCName(i) for i in range(n_sides)]
    return dim, elements, names, sides, mesh.GetIdentifications() if hasattr(
        mesh, "GetIdentifications") else None

before, after = load(sys.argv[1]), load(sys.argv[2])
assert content(before) == content(after)
names = content(after)[2]
assert all(name in names for name in sys.argv[3:]), names
assert [p.p for p in before.Points()] != [p.p for p in after.Points()]
END
    python3 - "$1" "$2" <<'END' || fail "$2: bytes that are of no point"
import re, sys
old, new = (open(name, "rb").read() for name in sys.argv[1:])

def rest(text):
    begin = re.search(rb"^points\n(\d+)\n", text, re.M)
    lines = text[begin.end():].split(b"\n")
    n = int(begin[1])
    return text[:begin.end()], [len(line.split()) for line in lines[:n]], lines[n:]

assert rest(old) == rest(new)
END
}

expect_status 0 "$program" smooth ball.vol -o ball_smooth.vol --json report.json -q
expect_json "r['certified'] and r['moved_nodes'] > 0"
same ball.vol ball_smooth.vol air iron
for options in "--fix iron" "--fix 3:2"; do
    expect_status 0 "$program" smooth ball.vol -o fixed.vol --ignore-regions $options --json report.json -q
    same ball.vol fixed.vol air iron
done
expect_status 0 "$program" smooth ball.vol -o slid.vol --slide auto --json report.json -q
expect_json "r['mesh']['sliding_nodes'] > 0"
same ball.vol slid.vol air iron
expect_status 0 "$program" smooth ball.vol -o slid.vol --slide outer --json report.json -q
expect_json "r['mesh']['sliding_nodes'] > 0"
expect_status 64 "$program" smooth ball.vol -o no.vol --fix nobody
expect_text "no group 'nobody'"
expect_text "iron"

expect_status 0 "$program" smooth flat.vol -o flat_smooth.vol -q
same flat.vol flat_smooth.vol outer inner
expect_status 0 "$program" smooth flat.vol -o flat_slid.vol --slide auto -q
same flat.vol flat_slid.vol outer inner

# Periodic nodes slide together.
expect_status 0 "$program" smooth periodic.vol -o periodic_slid.vol --slide auto --json report.json -q
expect_json "r['mesh']['sliding_nodes'] > 0"
same periodic.vol periodic_slid.vol cube
python3 - <<'END' || fail "periodic nodes are one side's and the other's"
import re
text = open("periodic_slid.vol").read()
def table(name):
    at = re.search(rf"^{name}\n(\d+)\n", text, re.M)
    return [line.split() for line in text[at.end():].split("\n")[:int(at[1])]]
points = [[float(x) for x in row] for row in table("points")]
pairs = [(points[int(a) - 1], points[int(b) - 1]) for a, b, _ in table("identifications")]
assert len(pairs) > 10
for a, b in pairs:
    assert abs(abs(b[0] - a[0]) - 1) < 1e-9 and a[1:] == b[1:], (a, b)
END

expect_status 0 "$program" quality second.vol --json report.json
expect_json "r['quality']['counts']['tetrahedron10'] > 0"
expect_json "r['quality']['inverted'] == r['quality']['uncertified'] == 0"
# Second order: corners are smoothed, mids follow, and Netgen finds the same elements in what is written.
expect_status 0 "$program" smooth second.vol -o second_smooth.vol --json report.json
grep -q "^857 quadratic tetrahedra, [0-9]* curved; mid-side nodes follow" out || fail "counts: $(cat out)"
expect_json "r['before']['counts'] == r['after']['counts'] == {'tetrahedron10': 857}"
expect_json "r['before']['inverted'] == r['after']['inverted'] == 0 and r['certified']"
expect_json "r['after']['rms_radius_ratio'] < r['before']['rms_radius_ratio'] and r['mesh']['mid_side_nodes'] > 0"
mv report.json smoothed.json
expect_status 0 "$program" quality second_smooth.vol --json report.json
expect_json "r['checksum'] == json.load(open('smoothed.json'))['checksum']"
"$python" - <<'END' >/dev/null || fail "Netgen reads another mesh"
import json
from netgen.meshing import Mesh
old, new = Mesh(), Mesh()
old.Load("second.vol")
new.Load("second_smooth.vol")
assert [[v.nr for v in e.vertices] for e in old.Elements3D()] == [[v.nr for v in e.vertices] for e in new.Elements3D()]
assert [[p.nr for p in e.points] for e in old.Elements3D()] == [[p.nr for p in e.points] for e in new.Elements3D()]
moved = sum(a.p != b.p for a, b in zip(old.Points(), new.Points()))
assert len(old.Points()) == len(new.Points())
assert moved == json.load(open("smoothed.json"))["moved_nodes"] > 100, moved
END
gzip -k ball.vol
expect_status 2 "$program" smooth ball.vol.gz -o no.vol
expect_one_line
expect_text "gunzip"
expect_no_file no.vol

# meshio's, where it is.
if "$python" -c "import meshio" 2>/dev/null; then
    expect_status 0 "$program" smooth ball.vol -o ball_smooth.vol --json report.json -q
    "$python" "$cli/same_mesh.py" ball.vol ball_smooth.vol report.json || fail "meshio reads ball"
    "$python" -c "import meshio; meshio.read('ball.vol').write('meshio.vol')" >/dev/null 2>&1 ||
        fail "meshio writes"
    expect_status 0 "$program" smooth meshio.vol -o meshio_smooth.vol --json report.json -q
    "$python" "$cli/same_mesh.py" meshio.vol meshio_smooth.vol report.json || fail "meshio's mesh"
fi
finish
