#!/usr/bin/env bash
# --onto FILE: the surface of a mesh is fitted to that of another file, and planish says how far it came.
. "$(dirname "$0")/common.sh"

# Cubes of N cells along each side as hexahedra or tetrahedra (solid), or their surface as triangles (surface), in a
# form of a size, lifted; for a Medit file. Two: two plates with a gap; lower: the lower one. Hollow: without the cell amid.
cat >make.py <<'END'
import itertools
import sys

what, form, n, size = sys.argv[1], sys.argv[2], int(sys.argv[3]), float(sys.argv[4])
lift = float(sys.argv[5]) if len(sys.argv) > 5 else 0
layers = {"two": (0, 1, 3, 4), "lower": (0, 1)}.get(form, range(n))
FACE = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
number, points = {}, []


def node(at):
    if at not in number:
        u, v, w = (2 * i / n - 1 for i in at)
        if form == "ball":
            u, v, w = (a * (1 - b * b / 2 - c * c / 2 + b * b * c * c / 3) ** 0.5
                       for a, b, c in ((u, v, w), (v, w, u), (w, u, v)))
        points.append([size * u, size * v, size * w + lift])
        number[at] = len(points)
    return number[at]


hexes, triangles = [], []
for i, j, k in itertools.product(range(n), range(n), layers):
    if form == "hollow" and i == j == k == n // 2:
        continue
    at = [(i, j, k), (i + 1, j, k), (i + 1, j + 1, k), (i, j + 1, k)]
    at += [(a, b, c + 1) for a, b, c in at]
    for face in FACE:
        side = [at[c] for c in face]
        if any(len({p[d] for p in side}) == 1 and side[0][d] in (0, n) for d in range(3)) and what == "surface":
            a, b, c, d = (node(p) for p in side)
            triangles += [(a, b, c), (a, c, d)]
    if what != "surface":
        hexes.append([node(p) for p in at])
print("MeshVersionFormatted 2\nDimension 3\nVertices", len(points))
for p in points:
    print("%.9f %.9f %.9f 0" % tuple(p))
if what == "hexes":
    elements, name = hexes, "Hexahedra"
elif what == "tets":
    ring = (1, 2, 3, 7, 4, 5, 1)
    elements, name = [(h[0], h[ring[i]], h[ring[i + 1]], h[6]) for h in hexes for i in range(6)], "Tetrahedra"
else:
    elements, name = triangles, "Triangles"
print(name, len(elements))
for e in elements:
    print(*e, 1)
print("End")
END
python3 make.py tets ball 5 0.96 >coarse.mesh
python3 make.py hexes cube 5 0.8 >block.mesh
python3 make.py tets ball 14 1 >fine.mesh
python3 make.py tets ball 12 0.5 >half.mesh
python3 make.py tets ball 8 100 >huge.mesh

# A coarse ball, inscribed in a fine one.
expect_status 0 "$program" smooth coarse.mesh --onto fine.mesh -o out.mesh --json report.json --report page.html
tr '\n' ' ' <out >text
for text in "fitted to fine.mesh before smoothing" "152 lay off that surface" "now 152 are on it, 0 not yet" "(certified)" "to slide"; do
    grep -qF "$text" text || { fail "the table says '$text'"; cat out; }
done
grep -q "other surface" page.html && grep -q "fine.mesh" page.html || fail "the page names the other surface"
expect_status 0 "$program" report report.json -o later.html
grep -q "The mesh before is not drawn: it was fitted to the other surface, and is in no file" err &&
    grep -q "The mesh before is not drawn: it was fitted" later.html || { fail "a fitted mesh is in no file"; cat err; }
python3 - <<'END' || fail "the later page draws the mesh after, as the page of the run does, and no other"
import json
import re
states = [json.loads(re.search(r'id="picture-data">\n(.*?)\n</script>', open(name).read(), re.S)[1])["states"]
          for name in ("page.html", "later.html")]
high = json.loads(re.search(r'id="picture-data">\n(.*?)\n</script>', open("page.html").read(), re.S)[1])["high"]
assert high == [1, 1, 1], high  # of the surface that nodes may still reach
assert [s["name"] for s in states[0]] == ["before", "after"], states[0]
assert [s["name"] for s in states[1]] == ["after"], [s["name"] for s in states[1]]
assert states[0][1]["codes" if "codes" in states[0][1] else "inside_codes"] == states[1][0]["inside_codes"]
END
expect_json 'r["surface"]["onto"] == "fine.mesh" and r["surface"]["off_before"] == 152 and r["surface"]["off"] == 0'
expect_json '0.03 < r["surface"]["farthest_before"] < 0.05 and r["surface"]["farthest"] == 0'
expect_json '0 < r["surface"]["distance_in_edges"] < 0.2 and r["surface"]["distance_back"] < 0.07'
expect_json 'r["certified"] and r["after"]["max_radius_ratio"] <= r["before"]["max_radius_ratio"]'
expect_json 'r["surface"]["on_patches"] == 152 and r["surface"]["held"] == r["surface"]["out_of_reach"] == 0'
expect_status 0 "$program" quality coarse.mesh --json quality.json -q
python3 - <<'END' || fail "the checksum is that of the input, and all nodes of the surface lie on the ball"
import json
import math
assert json.load(open("quality.json"))["checksum"] == json.load(open("report.json"))["input_checksum"]
lines = [open(name).read().split("\n")[3:219] for name in ("coarse.mesh", "out.mesh")]
pairs = [[math.hypot(*map(float, line.split()[:3])) for line in pair] for pair in zip(*lines)]
surface = [r for before, r in pairs if before > 0.9599]
assert len(surface) == 152 and all(abs(r - 1) < 2e-3 for r in surface), (len(surface), min(surface), max(surface))
END
for threads in 1 2; do
    expect_status 0 "$program" smooth coarse.mesh --onto fine.mesh -o $threads.mesh -j $threads -q
done
cmp -s 1.mesh 2.mesh || fail "two threads give the same mesh"

# An STL, whose facets turn inwards.
python3 make.py surface ball 14 1 >fine-surface.mesh
python3 - <<'END'
lines = open("fine-surface.mesh").read().split("\n")
n = int(lines[2].split()[1])
points = [line.split()[:3] for line in lines[3:3 + n]]
with open("fine.stl", "w") as stl:
    stl.write("solid ball\n")
    for line in lines[4 + n:-2]:
        stl.write("facet normal 0 0 0\nouter loop\n")
        for i in reversed(line.split()[:3]):
            stl.write("vertex %s %s %s\n" % tuple(points[int(i) - 1]))
        stl.write("endloop\nendfacet\n")
    stl.write("endsolid ball\n")
END
for file in fine.stl fine-surface.mesh; do
    expect_status 0 "$program" smooth coarse.mesh --onto $file -o stl.mesh --json report.json -q
    expect_json 'r["surface"]["off_before"] == 152 and r["surface"]["off"] == 0 and r["surface"]["distance_in_edges"] < 0.2'
done
# All triangles twice, or with points of their own, join as they do in fine.stl; points that differ do not.
{ sed '/^endsolid/d' fine.stl; sed '1d' fine.stl; } >twice.stl
python3 - <<'END'
lines = [line.split()[1:] for line in open("fine.stl") if line.startswith("vertex")]
for name, step in ("own", 0), ("both", 0), ("loose", 1e-7):
    with open(name + ".off", "w") as off:
        off.write("OFF\n%d %d 0\n" % (len(lines), len(lines) // 3 + 2 * (name == "both")))
        off.writelines("%.9f %.9f %.9f\n" % tuple(float(x) + step * (i % 17) for x in p) for i, p in enumerate(lines))
        off.writelines("3 %d %d %d\n" % (i, i + 1, i + 2) for i in range(0, len(lines), 3))
        if name == "both":
            off.write("3 0 1 2\n3 4 5 3\n")
END
"$program" smooth coarse.mesh --onto fine.stl -o stl.mesh --json fine.json >out 2>err
! grep -q "patches, and nodes stay in theirs\|joined\|left out" err || fail "$(cat err)"
for file in twice.stl own.off both.off; do
    expect_status 0 "$program" smooth coarse.mesh --onto $file -o joined.mesh --json report.json
    ! grep -q "patches, and nodes stay in theirs" err || fail "$(cat err)"
    expect_text "$([ $file = twice.stl ] && echo "note: 2352 triangles" || echo "note: 5878 points") of $file are"
    expect_json 'r["surface"]["unused_pieces"] == 0 and r["surface"]["off"] == 0'
    expect_json 'abs(r["surface"]["distance"] - json.load(open("fine.json"))["surface"]["distance"]) < 1e-4'
done
# So do quadrilaterals, and triangles beside one; of what is there twice one is left.
python3 - <<'END'
lines = open("fine-surface.mesh").read().split("\n")
n = int(lines[2].split()[1])
points = [" ".join(line.split()[:3]) for line in lines[3:3 + n]]
triangles = [[int(i) - 1 for i in line.split()[:3]] for line in lines[4 + n:-2]]
quads = [[*a, b[2]] for a, b in zip(triangles[::2], triangles[1::2])]  # (a, b, c), (a, c, d)


def put(name, facets, own, again=()):
    if own:
        rows = [points[i] for f in facets for i in f]
        starts = [sum(map(len, facets[:k])) for k in range(len(facets))]
        facets = [list(range(start, start + len(f))) for start, f in zip(starts, facets)]
    else:
        number = {i: k for k, i in enumerate(dict.fromkeys(i for f in facets for i in f))}
        rows = [points[i] for i in number]
        facets = [[number[i] for i in f] for f in facets]
    facets = facets + [[*facets[k][1:], facets[k][0]] for k in again]
    with open(name, "w") as off:
        print("OFF\n%d %d 0" % (len(rows), len(facets)), *rows, sep="\n", file=off)
        print(*(" ".join(map(str, [len(f), *f])) for f in facets), sep="\n", file=off)


for name, facets, again in ("one", quads[:1] + triangles[2:], (3,)), ("all", quads, (0, 5)):
    put(name + "-welded.off", facets, False)
    put(name + "-own.off", facets, True, again)
v = quads[0]
put("collapsed.off", [[v[0], v[0], v[1]], *quads[:1], *triangles[2:]], False)
poles = triangles[:1600] + [[f[0], f[0], *f[1:]] for f in triangles[1600:2000]] + [[*f, f[0]] for f in triangles[2000:]]
put("triangles.off", triangles, False)
put("poles.off", poles, False)
put("poles-own.off", poles, True)
put("line.off", [*quads[:1], *triangles[2:], [v[0], v[1], v[0], v[1]]], False)
END
for name in one all; do
    expect_status 0 "$program" smooth coarse.mesh --onto $name-welded.off -o welded.mesh -q
    expect_status 0 "$program" smooth coarse.mesh --onto $name-own.off -o joined.mesh
    ! grep -q "patches, and nodes stay in theirs" err || fail "$(cat err)"
    expect_text "points of $name-own.off are where others are, and joined"
    expect_text "note: $([ $name = one ] && echo "1 triangle of one-own.off is" || echo "2 facets of all-own.off are") left out"
    cmp -s welded.mesh joined.mesh || fail "$name: points of their own change nothing"
done
# Facets with less than three nodes are left out, also where all points are joined.
"$program" smooth coarse.mesh --onto one-welded.off -o welded.mesh -q
for name in collapsed line; do
    expect_status 0 "$program" smooth coarse.mesh --onto $name.off -o joined.mesh
    ! grep -q "points" err || fail "$(cat err)"
    expect_text "note: 1 $([ $name = line ] && echo facet || echo triangle) of $name.off is left out: without area"
    cmp -s welded.mesh joined.mesh || fail "$name.off: collapsed facets change nothing"
done
# A quadrilateral with three nodes is a triangle.
"$program" smooth coarse.mesh --onto triangles.off -o welded.mesh -q
for name in poles poles-own; do
    expect_status 0 "$program" smooth coarse.mesh --onto $name.off -o joined.mesh
    ! grep -q "patches\|pieces\|left out" err || fail "$(cat err)"
    cmp -s welded.mesh joined.mesh || fail "$name.off: quadrilaterals with three nodes are triangles"
done
printf 'OFF\n2 1 0\n0 0 0\n1 0 0\n3 0 0 1\n' >only.off
expect_status 2 "$program" smooth coarse.mesh --onto only.off -o no.mesh
expect_one_line
expect_text "remove the collapsed element"
"$program" smooth coarse.mesh --onto loose.off -o stl.mesh >out 2>err
expect_text "note: the 2352 triangles of loose.off are 2352 patches, and nodes stay in theirs: join its points"
sed 's/^vertex/vertex nan/;t;' fine.stl >nan.stl
printf 'solid none\nendsolid none\n' >empty.stl
for file in nan.stl empty.stl; do
    expect_status 2 "$program" smooth coarse.mesh --onto $file -o no.mesh
    expect_one_line
    expect_text "--onto: $file"
done
expect_status 64 "$program" smooth fine.stl --onto fine.mesh -o no.stl
expect_one_line
expect_text "--onto"

# Elements get worse where the other surface asks for it, and that is said.
python3 make.py tets cube 4 0.7 >cube.mesh
expect_status 0 "$program" smooth cube.mesh --onto fine.stl -o round.mesh --json report.json
tr '\n' ' ' <err >text
grep -q "fitting changed the worst radius ratio from 1.394 to" text || { fail "the note tells that elements got worse"; cat err; }
expect_json 'r["surface"]["worst_ratio_of_input"] < r["before"]["max_radius_ratio"] >= r["after"]["max_radius_ratio"]'

# Hexahedra that a plain projection would invert; in floats of few digits, too.
expect_status 0 "$program" smooth block.mesh --onto half.mesh -o block-out.mesh --json report.json
expect_json 'r["certified"] and r["surface"]["out_of_reach"] == 0 and r["surface"]["off"] == 0'

# A cube onto one that is higher keeps its corners; onto a roof two are left over, and that is said.
python3 - <<'END'
def put(name, points, triangles):
    with open(name, "w") as off:
        off.write("OFF\n%d %d 0\n" % (len(points), len(triangles)))
        off.writelines("%g %g %g\n" % tuple(p) for p in points)
        off.writelines("3 %d %d %d\n" % t for t in triangles)


ring = [(-0.7, -0.7), (0.7, -0.7), (0.7, 0.7), (-0.7, 0.7)]
sides = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7), (0, 2, 1), (0, 3, 2)]
put("higher.off", [(*p, z) for z in (-0.7, 0.9) for p in ring], [*sides, (4, 5, 6), (4, 6, 7)])
roof = [(*p, -0.7) for p in ring] + [(-0.7, 0, 0.7), (0.7, 0, 0.7)]
put("roof.off", roof, [(0, 1, 5), (0, 5, 4), (1, 2, 5), (2, 3, 4), (2, 4, 5), (3, 0, 4), (0, 2, 1), (0, 3, 2)])
END
expect_status 0 "$program" smooth cube.mesh --onto higher.off -o higher.mesh --json report.json
expect_json 'r["surface"]["on_corners"] == 8 and r["surface"]["cut_corners"] == 0'
expect_json 'r["surface"]["distance"] < 0.001 and r["surface"]["distance_back"] < 0.001'
# Where two materials meet on its sides nothing is cut off.
awk '/^Tetra/ { on = 1; print; next } /^End/ { on = 0 } on { $5 = n++ % 24 < 12 ? 1 : 2 } { print }' cube.mesh >halves.mesh
"$program" smooth halves.mesh --onto higher.off -o halves-out.mesh --json report.json >out 2>err
! grep -q "cut off" err || { fail "materials that meet are no corners"; cat err; }
expect_json 'r["surface"]["on_corners"] == 8 and r["surface"]["cut_corners"] == 0'
"$program" smooth cube.mesh --onto roof.off -o under-roof.mesh --json report.json >out 2>err
tr '\n' ' ' <err >text
grep -q "2 corners of the surface are not at a corner of roof.off" text || { fail "cut corners are said"; cat err; }
expect_json 'r["surface"]["on_corners"] == 6 and r["surface"]["cut_corners"] == 2'

# Nodes that cannot get there, as all nodes inside are held.
python3 - <<'END'
lines = open("block.mesh").read().split("\n")
for i in range(3, 219):
    x = lines[i].split()
    inside = all(abs(float(c)) < 0.79 for c in x[:3])
    lines[i] = " ".join(x[:3]) + (" 7" if inside else " 0")
lines.insert(len(lines) - 2, "RequiredVertices\n64\n" + "\n".join(str(i - 2) for i in range(3, 219) if lines[i].endswith(" 7")))
open("held.mesh", "w").write("\n".join(lines))
END
expect_status 1 "$program" smooth held.mesh --onto half.mesh -o held-out.mesh --json report.json
expect_text "are not on half.mesh yet"
expect_json 'r["certified"] and 0 < r["surface"]["off"] <= 152 and r["surface"]["farthest"] > 0.1'
expect_json 'r["surface"]["distance"] >= r["surface"]["farthest"] * 0.99'

# An element that is there twice is held; no node inside is one of the surface without a place.
awk '/^Tetra/ { print $1, $2 + 1; getline; print } { print }' coarse.mesh >again.mesh
expect_status 0 "$program" smooth again.mesh --onto fine.mesh -o again-out.mesh --json report.json
expect_json 'r["surface"]["held"] == 4 and r["surface"]["out_of_reach"] == 0 and r["surface"]["off"] == 0'

# Two plates go to two plates that are higher by more than the gap; not both to one.
python3 make.py tets two 5 0.7 >two.mesh
python3 make.py tets two 5 0.7 0.35 >two-higher.mesh
python3 make.py tets lower 5 0.7 0.2 >one.mesh
expect_status 0 "$program" smooth two.mesh --onto two-higher.mesh -o two-out.mesh --json report.json
expect_json 'r["surface"]["on_corners"] == 16 and r["surface"]["unclear"] == r["surface"]["unused_pieces"] == 0'
expect_json '0.3499 < r["surface"]["farthest_before"] < 0.3501 and r["surface"]["distance_back"] < 0.001'
expect_status 1 "$program" smooth two.mesh --onto one.mesh -o two-out.mesh --json report.json
tr '\n' ' ' <err >text
grep -q "nodes of the surface stay: several pieces of it are nearest to the same one of one.mesh" text || { fail "what is unclear is said"; cat err; }
expect_json 'r["surface"]["unclear"] == r["surface"]["nodes"] == r["surface"]["out_of_reach"] == 184'
expect_status 0 "$program" smooth one.mesh --onto two-higher.mesh -o one-out.mesh --json report.json
tr '\n' ' ' <err >text
grep -q "1 piece of two-higher.mesh has no node of the mesh" text || { fail "pieces without nodes are said"; cat err; }
expect_json 'r["surface"]["unused_pieces"] == 1 and r["surface"]["off"] == 0'

# A shell around one of two plates is for none of them.
python3 - <<'END'
sides = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7), (0, 2, 1), (0, 3, 2),
         (4, 5, 6), (4, 6, 7)]
boxes = [(0.7, -0.7, -0.14), (0.7, 0.14, 0.7), (0.8, -0.8, -0.04)]
with open("shell.off", "w") as off:
    off.write("OFF\n24 36 0\n")
    for a, low, high in boxes:
        off.writelines("%g %g %g\n" % (x, y, z) for z in (low, high) for x, y in ((-a, -a), (a, -a), (a, a), (-a, a)))
    for box in range(3):
        off.writelines("3 %d %d %d\n" % tuple(8 * box + v for v in t) for t in sides)
END
expect_status 0 "$program" smooth two.mesh --onto shell.off -o two-out.mesh --json report.json
expect_json 'r["surface"]["on_corners"] == 16 and r["surface"]["off_before"] == 0'
expect_json 'r["surface"]["unused_pieces"] == 1 and r["surface"]["distance"] < 0.001'

# Two bodies that touch, with nodes of their own, go to two that share a wall, which is there from both sides.
python3 - <<'END'
ring = [(-0.7, -0.7), (0.7, -0.7), (0.7, 0.7), (-0.7, 0.7)]
points = [(*p, z) for z in (-0.7, 0, 0.7) for p in ring]
around = [(k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4)]
quads = [(3, 2, 1, 0), *around, (4, 5, 6, 7), (7, 6, 5, 4), *(tuple(i + 4 for i in q) for q in around), (8, 9, 10, 11)]
with open("wall.off", "w") as off:
    off.write("OFF\n12 24 0\n")
    off.writelines("%g %g %g\n" % p for p in points)
    for a, b, c, d in quads:
        off.write("3 %d %d %d\n3 %d %d %d\n" % ((b, c, d, b, d, a) if (a, b) == (7, 6) else (a, b, c, a, c, d)))
lines = open("halves.mesh").read().split("\n")
n, at = int(lines[2].split()[-1]), next(i for i, line in enumerate(lines) if line.startswith("Tetra"))
nodes, elements, copy = lines[3:3 + n], [line.split() for line in lines[at + 1:-2]], {}
for element in elements:
    for k in range(4):
        i = int(element[k])
        if element[4] == "2" and abs(float(nodes[i - 1].split()[2])) < 1e-9:
            element[k] = str(copy.setdefault(i, n + len(copy) + 1))
with open("contact.mesh", "w") as mesh:
    rows = nodes + [nodes[i - 1] for i in copy]
    print("MeshVersionFormatted 2\nDimension 3\nVertices %d" % len(rows), *rows, sep="\n", file=mesh)
    print("Tetrahedra", len(elements), file=mesh)
    print(*(" ".join(e) for e in elements), "End", sep="\n", file=mesh)
END
expect_status 0 "$program" smooth contact.mesh --onto wall.off -o contact-out.mesh --json report.json
expect_json 'r["surface"]["out_of_reach"] == 0 and r["surface"]["off"] == 0'
! grep -q "left out" err || { fail "no side of a wall is left out"; cat err; }

# A body in a hollow of another one is not for the outside of that, where it is nearer.
python3 - <<'END'
sides = [(0, 1, 5), (0, 5, 4), (1, 2, 6), (1, 6, 5), (2, 3, 7), (2, 7, 6), (3, 0, 4), (3, 4, 7), (0, 2, 1), (0, 3, 2),
         (4, 5, 6), (4, 6, 7)]
with open("nest.off", "w") as off:
    off.write("OFF\n24 36 0\n")
    for a in (0.7, 0.63, 0.56):
        off.writelines("%g %g %g\n" % (x, y, z) for z in (-a, a) for x, y in ((-a, -a), (a, -a), (a, a), (-a, a)))
    for box in range(3):
        off.writelines("3 %d %d %d\n" % tuple(8 * box + v for v in t) for t in sides)
END
python3 make.py tets cube 5 0.7 | awk '$4 == 0 && $3 > 0.69 { $3 = 0.57 } { print }' >low.mesh
expect_status 0 "$program" smooth low.mesh --onto nest.off -o low-out.mesh --json report.json
expect_json 'r["surface"]["unused_pieces"] == 2 and r["surface"]["off"] == 0 and r["surface"]["distance"] < 1e-9'

# What is hollow does not go to the outside.
python3 make.py tets hollow 5 0.7 >hollow.mesh
python3 make.py tets cube 3 0.7 0.02 >full.mesh
expect_status 1 "$program" smooth hollow.mesh --onto full.mesh -o hollow-out.mesh --json report.json
expect_json 'r["surface"]["out_of_reach"] == 8 and r["surface"]["nodes"] == 160 and r["surface"]["off"] == 0'
expect_status 0 "$program" smooth full.mesh --onto hollow.mesh -o full-out.mesh --json report.json
expect_json 'r["surface"]["unused_pieces"] == 1 and r["surface"]["on_corners"] == 8'
expect_status 0 "$program" smooth hollow.mesh --onto hollow.mesh -o same.mesh --json report.json
expect_json 'r["surface"]["off_before"] == 0 and r["surface"]["on_corners"] == 16'

# Nodes without a place, as there is none below: that is no success.
cat >lid.off <<'LID'
OFF
4 2 0
-0.7 -0.7 0.75
0.7 -0.7 0.75
0.7 0.7 0.75
-0.7 0.7 0.75
3 0 1 2
3 0 2 3
LID
expect_status 1 "$program" smooth cube.mesh --onto lid.off -o lid.mesh --json report.json
tr '\n' ' ' <err >text
grep -q "lid.mesh: .*[0-9] nodes of the surface have no place on lid.off" text || { fail "no place is no success"; cat err; }
tr '\n' ' ' <out >text
grep -q "of 98 nodes .* 0 not yet, [0-9]* have no place there" text || { fail "the table counts nodes without a place"; cat out; }
sed 's/^-*0.7 -*0.7 0.75/0.5 0.5 0.75/' lid.off >point.off
expect_status 2 "$program" smooth cube.mesh --onto point.off -o no.mesh
expect_one_line
expect_text "no facet with an area"

# What is refused, in one line.
expect_status 2 "$program" smooth coarse.mesh --onto huge.mesh -o no.mesh
expect_one_line
expect_text "give both the same unit and place"
expect_status 2 "$program" smooth coarse.mesh --onto none.mesh -o no.mesh
expect_one_line
expect_text "--onto"
expect_status 2 "$program" smooth "$source_folder/docs/examples/beam.inp" --onto fine.mesh -o no.inp
expect_one_line
expect_text "beam.inp: element 0 is of order 2"
expect_text "(element 1 of the file)"

# Sizes are those of the mesh before it was fitted: the same as an array of the file, or of a solution.
expect_status 0 "$program" smooth coarse.mesh --onto fine.mesh -o kept.mesh --keep-sizes --size-weight 0.5 --json report.json
expect_json 'r["target"] == "sizes" and r["objective"]["size_weight"] == 0.5 and r["surface"]["off"] == 0'
expect_json '1 < r["surface"]["worst_ratio_of_input"] < 2 * r["before"]["max_aspect_ratio"]'
expect_json 'r["after"]["rms_aspect_ratio"] <= r["before"]["rms_aspect_ratio"] and r["after"]["inverted"] == 0'
n=$(sed -n 's/^Vertices //p' coarse.mesh)
{ printf 'MeshVersionFormatted 2\nDimension 3\nSolAtVertices\n%s\n1 1\n' "$n"; yes 1 | head -n "$n"; echo End; } >one.sol
expect_status 0 "$program" smooth coarse.mesh --onto fine.mesh -o out.mesh --size-from one.sol --json report.json
expect_json 'r["target"] == "sizes" and r["surface"]["off"] == 0'
python3 - <<'END'
words = open("coarse.mesh").read().split()
at = words.index("Vertices")
n, m = int(words[at + 1]), int(words[words.index("Tetrahedra") + 1])
x = words[at + 2:at + 2 + 4 * n]
corner = [int(w) - 1 for w in words[words.index("Tetrahedra") + 2:][:5 * m]]
with open("coarse.vtk", "w") as file:
    print("# vtk DataFile Version 3.0\na ball\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS", n, "double", file=file)
    print(*(" ".join(x[4 * i:4 * i + 3]) for i in range(n)), sep="\n", file=file)
    print("CELLS", m, 5 * m, file=file)
    print(*("4 %d %d %d %d" % tuple(corner[5 * i:5 * i + 4]) for i in range(m)), sep="\n", file=file)
    print(f"CELL_TYPES {m}", *[10] * m, f"POINT_DATA {n}", "SCALARS h double", "LOOKUP_TABLE default", *[1] * n,
          sep="\n", file=file)
END
expect_status 0 "$program" smooth coarse.vtk --onto fine.mesh -o out.vtk --size h --json report.json
expect_json 'r["target"] == "sizes" and r["surface"]["off"] == 0'

for option in "--slide curved" "--box 0,0,0,1,1,1" "--max-displacement 1" "--only-worse-than 2"; do
    # shellcheck disable=SC2086
    expect_status 64 "$program" smooth coarse.mesh --onto fine.mesh -o no.mesh $option
    expect_one_line
    expect_text "give --onto or --"
done
expect_status 64 "$program" smooth coarse.mesh --onto fine.mesh -o no.mesh --best
expect_one_line
expect_text "give --onto or --best, not both: --onto goes with --objective worst"
expect_no_file no.mesh no.inp
finish
