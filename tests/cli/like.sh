#!/usr/bin/env bash
# --like FILE: the target of each element is its shape there, so that layers and gradings of the undeformed mesh
# survive; the table, JSON and page say so, and files that do not fit are refused in one line.
. "$(dirname "$0")/common.sh"

# make.py KIND BUMP [FORMAT]: a box of 6 cells along each side, whose rows grow by 1.5 from the wall at z = 0 (in the
# plane y = 0). The wall is raised by BUMP first heights in its middle, and nothing else.
cat >make.py <<'END2'
import itertools
import math
import sys
import box_file

N, GROWTH, kind, bump = 6, 1.5, sys.argv[1], float(sys.argv[2])
form = sys.argv[3] if len(sys.argv) > 3 else "mesh"
dim = box_file.dimension(kind)
first = (GROWTH - 1) / (GROWTH ** N - 1)
number, points = {}, []
for at in itertools.product(range(N + 1), repeat=dim):
    p = [c / N for c in at[:-1]] + [first * (GROWTH ** at[-1] - 1) / (GROWTH - 1)]
    if at[-1] == 0:
        p[-1] += bump * first * math.prod(math.sin(math.pi * c) for c in p[:-1])
    number[at] = len(points) + 1
    points.append(p)
elements = box_file.elements(kind, [N] * dim, number)
if form == "mesh":
    print(box_file.medit(kind, points, elements))
else:
    code = {"quads": 3, "triangles": 2, "hexes": 5, "tets": 4}[kind]
    print("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n%d" % len(points))
    for i, p in enumerate(points):
        print(i + 1, *map(repr, p), *[0] * (3 - dim))
    print("$EndNodes\n$Elements\n%d" % len(elements))
    for i, e in enumerate(elements):
        print(i + 1, code, 2, 1, 1, *e)
    print("$EndElements")
END2

# ratios.py MESH LIKE: RMS and largest AR of the tetrahedra of MESH against those of LIKE, by themselves.
cat >ratios.py <<'END2'
import sys
import mesh_file


def edges(points, element):
    a, *others = (points[n] for n in element)
    return [[x - y for x, y in zip(p, a)] for p in others]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def ratio(a, w):
    volume = dot(w[0], cross(w[1], w[2]))
    dual = [cross(w[1], w[2]), cross(w[2], w[0]), cross(w[0], w[1])]  # of the edges, times the volume
    t = [[sum(a[j][d] * dual[j][k] for j in range(3)) / volume for k in range(3)] for d in range(3)]
    return sum(dot(row, row) for row in t) / (3 * dot(t[0], cross(t[1], t[2])) ** (2 / 3))


mesh, like = (mesh_file.read(name) for name in sys.argv[1:3])
found = [ratio(edges(mesh.points, e), edges(like.points, e)) for e in mesh.elements]
print("%.12g %.12g" % ((sum(r * r for r in found) / len(found)) ** 0.5, max(found)))
END2

# heights.py KIND MESH: the largest relative error of the heights of first cells at nodes inside.
cat >heights.py <<'END2'
import itertools
import sys
import mesh_file

N, GROWTH, dim = 6, 1.5, 2 if sys.argv[1] in ("quads", "triangles") else 3
first = (GROWTH - 1) / (GROWTH ** N - 1)
lines = iter(open(sys.argv[2]).read().split("\n"))
for line in lines:
    if line.startswith("Vertices"):
        break
points = [list(map(float, next(lines).split()[:dim])) for _ in range((N + 1) ** dim)]
index = {at: i for i, at in enumerate(itertools.product(range(N + 1), repeat=dim))}
errors = [abs((points[index[at + (1,)]][-1] - points[index[at + (0,)]][-1]) / first - 1)
          for at in itertools.product(range(1, N), repeat=dim - 1)]
print(max(errors))
END2

# within X LOW HIGH: X is between them.
within() {
    python3 -c "import sys; x, low, high = map(float, sys.argv[1:]); sys.exit(not low <= x <= high)" "$@"
}

for kind in hexes tets quads triangles; do
    python3 make.py $kind 0 >$kind.mesh
    python3 make.py $kind 0.7 >$kind-moved.mesh
done
python3 make.py tets 0 msh >tets.msh

# ---- its own copy: nothing moves

for kind in hexes tets quads triangles; do
    expect_status 0 "$program" smooth $kind.mesh --like $kind.mesh -o out.mesh --json report.json
    cmp -s $kind.mesh out.mesh || fail "$kind: a mesh that is its target stays, to the byte"
    expect_json 'r["target"] == "like" and r["like"] == "'$kind'.mesh" and r["after"]["rms_aspect_ratio"] < 1 + 1e-12'
    expect_json 'r["moved_nodes"] == 0 and r["after"]["max_aspect_ratio"] < 1 + 1e-9 and r["certified"]'
done

# ---- a wall that has moved: layers keep their heights, of every type, on any number of threads

for kind in hexes tets quads triangles; do
    for threads in 1 2; do
        expect_status 0 "$program" smooth $kind-moved.mesh --like $kind.mesh -o $kind-$threads.mesh -j $threads \
            --json report.json
    done
    cmp -s $kind-1.mesh $kind-2.mesh || fail "$kind: threads change the bits"
    grep -qF "AR compares each element with its shape in $kind.mesh" out || { fail "the table says the target"; cat out; }
    ! grep -q "thin in layers" err || fail "layers that are targets need no warning: $(cat err)"
    expect_json 'r["mesh"]["held"]["layers"] == 0 and r["mesh"]["free_nodes"] > 0'
    expect_json 'r["objective"]["measure"] == "aspect-ratio" and r["objective"]["name"] == "mean-ratio"'
    expect_json 'r["after"]["rms_aspect_ratio"] < r["before"]["rms_aspect_ratio"] and "rms_radius_ratio" in r["after"]'
    "$program" smooth $kind-moved.mesh -o regular.mesh --layers ignore -q
    within "$(python3 heights.py $kind $kind-1.mesh)" 0 0.07 || fail "$kind: the first cells keep their heights"
    within "$(python3 heights.py $kind regular.mesh)" 0.4 9 || fail "$kind: without --like they do not"
done

# ---- its figures are those of quality and of formulas of textbooks; the page says the target

expect_status 0 "$program" smooth tets-moved.mesh --like tets.mesh -o out.mesh --json smooth.json --report page.html -q
expect_status 0 "$program" quality tets-moved.mesh --like tets.mesh --json before.json --report quality.html
grep -qF "AR compares each element with its shape in tets.mesh" out || fail "the table of quality says the target"
"$program" quality out.mesh --like tets.mesh --json after.json -q
python3 - "$(python3 ratios.py tets-moved.mesh tets.mesh)" "$(python3 ratios.py out.mesh tets.mesh)" <<'END2' ||
import json
import sys
smooth, before, after = (json.load(open(name + ".json")) for name in ("smooth", "before", "after"))
assert before["target"] == smooth["target"] == "like" and before["like"] == smooth["like"] == "tets.mesh"
assert before["like_checksum"] == smooth["like_checksum"]
for state, quality, text in ((smooth["before"], before["quality"], sys.argv[1]),
                             (smooth["after"], after["quality"], sys.argv[2])):
    for key, plain in zip(("rms_aspect_ratio", "max_aspect_ratio"), text.split()):
        assert state[key] == quality[key] and abs(state[key] / float(plain) - 1) < 1e-10
    assert state["by_type"]["tetrahedron"]["rms_aspect_ratio"] == state["rms_aspect_ratio"]
    assert quality["simplices"]["rms_radius_ratio"] > 1.5
    assert state["worst_elements"][0]["aspect_ratio"] == state["max_aspect_ratio"]
    assert quality["worst_elements"][0]["aspect_ratio"] == quality["max_aspect_ratio"]
END2
    fail "smooth, quality and plain formulas agree"
for page in page.html quality.html; do
    grep -qF 'target of each element is its shape in <code>tets.mesh</code>' $page || fail "$page says the target"
done
! grep -q "does not hold" page.html || fail "the page claims nothing that does not hold"
expect_status 0 "$program" report smooth.json -o again.html
cmp -s page.html again.html || fail "the page can be made anew"
expect_status 0 "$program" report before.json -o again.html
cmp -s quality.html again.html || fail "the page of quality can be made anew"
mkdir gone
cp smooth.json tets-moved.mesh out.mesh gone
(cd gone && "$program" report smooth.json -o page.html 2>../err)
expect_text "is drawn only beside its targets"
expect_status 0 "$program" quality tets-moved.mesh out.mesh --like tets.mesh
grep -q "RMS" out && grep -q "AR" out && ! grep -q "RR" out || { fail "AR of several files"; cat out; }
"$program" quality tets.mesh --json report.json -q
expect_json 'r["target"] == "regular" and "like" not in r'

# ---- any format; a mesh that is turned, moved and larger is the same target; places and streams

expect_status 0 "$program" smooth tets-moved.mesh --like tets.msh -o msh.mesh -q
cmp -s out.mesh msh.mesh || fail "the format of the target is no matter"
"$program" smooth /dev/stdin --like tets.mesh -o /dev/stdout -q <tets-moved.mesh | cmp -s - out.mesh ||
    fail "from a stream, to a stream"
cp tets-moved.mesh in-place.mesh
expect_status 0 "$program" smooth in-place.mesh --like tets.mesh -o in-place.mesh -q
cmp -s out.mesh in-place.mesh || fail "in place"
python3 - <<'END2'
lines = open("tets.mesh").read().split("\n")
start = lines.index("Vertices 343") + 1
tets = lines.index("Tetrahedra 1296") + 1


def write(name, change):
    points = [[float(c) for c in line.split()[:3]] for line in lines[start:start + 343]]
    new = ["%r %r %r 0" % tuple(change(i, *p)) for i, p in enumerate(points)]
    open(name, "w").write("\n".join(lines[:start] + new + lines[start + 343:]))


write("turned.mesh", lambda i, x, y, z: (-8 * y, 8 * x, 8 * z))
write("inverted.mesh", lambda i, x, y, z: (x, y, z - 2 * (i == 171)))
write("flat.mesh", lambda i, x, y, z: (x, y, 0))
write("mirrored.mesh", lambda i, x, y, z: (-x, y, z))
a, b, c, d, tag = lines[tets].split()
lines[tets] = " ".join((b, c, a, d, tag))
open("renumbered.mesh", "w").write("\n".join(lines))
lines[start - 1] = "Vertices 344"
open("more.mesh", "w").write("\n".join(lines[:start] + ["7 7 7 0"] + lines[start:]))
END2
expect_status 0 "$program" smooth tets-moved.mesh --like turned.mesh -o turned-out.mesh -q --json report.json
expect_json 'r["after"]["rms_aspect_ratio"] < 1.00097'

# Triangles in the plane of x and z, and in one that is tilted and seen from behind.
python3 - <<'END2'
import mesh_file
for name, change in (("xz", lambda x, y: (x, 0, y)), ("tilted", lambda x, y: (-0.6 * x, y, 0.8 * x))):
    mesh = mesh_file.read("triangles.mesh")
    with open(name + ".mesh", "w") as file:
        file.write("MeshVersionFormatted 2\nDimension 3\nVertices %d\n" % len(mesh.points))
        file.writelines("%r %r %r 0\n" % change(*p) for p in mesh.points)
        file.write("Triangles %d\n" % len(mesh.elements))
        file.writelines("%d %d %d 1\n" % tuple(n + 1 for n in e) for e in mesh.elements)
        file.write("End\n")
END2
for plane in xz tilted; do
    expect_status 0 "$program" smooth triangles-moved.mesh --like $plane.mesh -o plane-out.mesh -q
    within "$(python3 heights.py triangles plane-out.mesh)" 0 0.07 || fail "$plane: the first cells keep their heights"
done

# ---- together with other options

expect_status 0 "$program" smooth hexes-moved.mesh --like hexes.mesh --slide auto -o slide.mesh -q --json report.json
expect_json 'r["mesh"]["sliding_nodes"] > 0 and r["after"]["rms_aspect_ratio"] < r["before"]["rms_aspect_ratio"]'
expect_status 0 "$program" smooth hexes-moved.mesh --like hexes.mesh --layers hold -o held.mesh --json report.json
expect_json 'r["mesh"]["held"]["layers"] > 0'
expect_status 0 "$program" smooth tets-moved.mesh --like tets.mesh --only-worse-than 1.2 -o only.mesh -q \
    --json report.json
expect_json '0 < r["mesh"]["free_nodes"] < 125 and r["after"]["max_aspect_ratio"] < 1.2'
expect_status 0 "$program" smooth tets-moved.mesh --like tets.mesh -o view.vtu -q
expect_status 0 "$program" smooth tets-moved.mesh --like tets.mesh --onto tets.mesh -o onto.mesh -q --json report.json
expect_json 'r["after"]["max_aspect_ratio"] < 1 + 1e-9'

# Sizes count, too, by their weight: F is what the library measures.
for threads in 1 2; do
    expect_status 0 "$program" smooth hexes-moved.mesh --like hexes.mesh --size-weight 0.5 -o sized-$threads.mesh -j $threads \
        --json report.json
    grep -qF "F (mean-ratio, sizes 0.5)" out || fail "the table says what F is"
    expect_json 'r["objective"]["size_weight"] == 0.5 and 1 < r["objective"]["after"] < r["objective"]["before"]'
done
cmp sized-1.mesh sized-2.mesh || fail "sizes: other bytes on two threads"

# ---- refused: one line, and nothing is written

# refused STATUS TEXT FILE OPTION...
refused() {
    local status=$1 text=$2 file=$3
    shift 3
    expect_status "$status" "$program" smooth "$file" -o no.mesh "$@"
    expect_one_line
    expect_text "$text"
    expect_no_file no.mesh
}
same="--like needs the same mesh before it was deformed"
refused 2 "more.mesh has 344 nodes, tets-moved.mesh has 343; $same" tets-moved.mesh --like more.mesh
refused 2 "hexes.mesh has 216 elements, tets-moved.mesh has 1296; $same" tets-moved.mesh --like hexes.mesh
refused 2 "quads.mesh is a mesh in 2 dimensions, tets-moved.mesh in 3; $same" tets-moved.mesh --like quads.mesh
refused 2 "element 1 of renumbered.mesh has other nodes than element 1 of tets-moved.mesh; $same" tets-moved.mesh \
    --like renumbered.mesh
for kind in "Prisms|1 2 3 4 5 6 1" "Tetrahedra|1 2 3 4 1"; do
    printf '%s\n' "MeshVersionFormatted 2" "Dimension 3" "Vertices 6" "0 0 0 0" "1 0 0 0" "0 1 0 0" "0 0 1 0" "1 0 1 0" \
        "0 1 1 0" "${kind%|*} 1" "${kind#*|}" End >"${kind%|*}.mesh"
done
refused 2 "element 1 of Tetrahedra.mesh is of another type than element 1 of Prisms.mesh; $same" Prisms.mesh \
    --like Tetrahedra.mesh
refused 2 "--like inverted.mesh: element 517 is inverted" tets-moved.mesh --like inverted.mesh
refused 2 "--like flat.mesh: element 1 is flat" tets-moved.mesh --like flat.mesh
refused 2 "--like mirrored.mesh: element 1 is oriented otherwise" tets-moved.mesh --like mirrored.mesh
for exponent in 150 -150; do
    awk -v e=e$exponent '/^Tetra/ { done = 1 } NF == 4 && !done { print $1 e, $2 e, $3 e, $4; next } { print }' tets.mesh >sized.mesh
    refused 2 "--like sized.mesh: element 1 is too $([ $exponent = 150 ] && echo large || echo small)" tets-moved.mesh \
        --like sized.mesh
done
refused 2 "--like: none.mesh: cannot be opened" tets-moved.mesh --like none.mesh
refused 64 "--like '' must be the name of a file" tets-moved.mesh --like ""
for objective in worst edge-ratio radius-ratio; do
    refused 64 "--like minimises the mean-ratio: leave out --objective $objective" tets-moved.mesh --like tets.mesh \
        --objective $objective
done
refused 64 "--like has no effect with --method laplacian" tets-moved.mesh --like tets.mesh --method laplacian
refused 64 "the report would overwrite the file of --like 'tets.mesh'" tets-moved.mesh --like tets.mesh --json tets.mesh
python3 make.py tets 0 msh >periodic.msh
printf '$Periodic\n1\n2 2 1\n1\n2 1\n$EndPeriodic\n' >>periodic.msh
refused 2 "periodic.msh: has periodic nodes: --like is not for such meshes yet" periodic.msh --like tets.msh
cat >ball.mesh <<'END2'
MeshVersionFormatted 2
Dimension 3
Vertices 4
1 0 0 0
0 1 0 0
0 0 1 0
-1 -1 -1 0
Triangles 4
1 2 3 1
1 3 4 1
1 4 2 1
2 4 3 1
End
END2
refused 64 "ball.mesh is a surface in space: --like has no effect there" ball.mesh --like ball.mesh
expect_status 2 "$program" quality tets.mesh --like flat.mesh
expect_one_line
expect_text "--like flat.mesh: element 1 is flat"
# quality --like: measures of triangles and tetrahedra alone are those without --like, and none is 0.
for kind in triangles tets; do
    python3 make.py $kind 0.6 >bent.mesh
    python3 make.py $kind 0 >straight.mesh
    expect_status 0 "$program" quality bent.mesh --like straight.mesh
    sed -n '/^over the elements/,$p' out >with
    expect_status 0 "$program" quality bent.mesh
    sed -n '/^over the elements/,$p' out >without
    [ "$(wc -l <with)" -gt 8 ] && cmp with without || fail "$kind: measures beside --like: $(cat with)"
    ! grep -Eq "^[a-zA-Z /(:),]*[^0-9.]0 +0 +0 " with || fail "$kind: measures that are 0: $(cat with)"
done
finish
