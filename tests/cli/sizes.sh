#!/usr/bin/env bash
# --size NAME, --size-from FILE, --keep-sizes: elements get the sizes that are wanted where they are, in relation to one
# another. The table, JSON and page say so, and sizes that do not fit are refused in one line.
. "$(dirname "$0")/common.sh"

# make.py KIND FORM [WRONG]: a square or cube of N cells along each side, with sizes that are small on a circle: the array
# h of nodes, H of elements, both of VTK, or Medit's mesh with its .sol. WRONG is the size of node 12. The array m and the
# .sol of FORM metric have metrics of elements that are thin across the circle alone; of node 12 with WRONG alike.
cat >make.py <<'END2'
import itertools
import math
import sys
import box_file

kind, form = sys.argv[1:3]
wrong = sys.argv[3] if len(sys.argv) > 3 else None
dim = box_file.dimension(kind)
N = 16 if dim == 2 else 9
number, points = {}, []
for at in itertools.product(range(N + 1), repeat=dim):
    number[at] = len(points)
    points.append([c / N for c in at])
elements = box_file.elements(kind, [N] * dim, number)
sizes = [0.1 + 2 * abs(math.hypot(p[0] - 0.5, p[1] - 0.5) - 0.25) for p in points]
text = list(map(repr, sizes))


def metric(p, size):
    """Thin by size towards the middle axis."""
    away = [p[0] - 0.5, p[1] - 0.5, 0][:dim]
    square = away[0] ** 2 + away[1] ** 2 + 1e-9
    return [[(r == c) + (size ** -2 - 1) * away[r] * away[c] / square for c in range(dim)] for r in range(dim)]


metrics = [metric(p, min(1, size + 0.1)) for p, size in zip(points, sizes)]
if wrong:
    text[11] = wrong
    metrics[11][0][0] = float(wrong)
if form == "vtk":
    print("# vtk DataFile Version 3.0\nsizes\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS %d double" % len(points))
    for p in points:
        print(*map(repr, p), *[0] * (3 - dim))
    print("CELLS %d %d" % (len(elements), sum(len(e) + 1 for e in elements)))
    for e in elements:
        print(len(e), *e)
    print("CELL_TYPES %d" % len(elements))
    print(*[{"quads": 9, "triangles": 5, "hexes": 12, "tets": 10}[kind]] * len(elements))
    print("CELL_DATA %d\nSCALARS H double 1\nLOOKUP_TABLE default" % len(elements))
    print(*[repr(sum(sizes[n] for n in e) / len(e)) for e in elements])
    print("POINT_DATA %d\nSCALARS h double 1\nLOOKUP_TABLE default" % len(points))
    print(*text)
    print("TENSORS m double")
    for m in metrics:
        for row in m + [[0, 0, 1]] * (3 - dim):
            print(*(row + [0, 0])[:3])
elif form == "metric":
    print("MeshVersionFormatted 2\nDimension %d\nSolAtVertices\n%d\n1 3" % (dim, len(points)))
    for m in metrics:
        print(*[m[r][c] for r in range(dim) for c in range(r + 1)])
    print("End")
elif form == "sol":
    print("MeshVersionFormatted 2\nDimension %d\nSolAtVertices\n%d\n1 1" % (dim, len(points)))
    print(*text, "End", sep="\n")
else:
    print(box_file.medit(kind, points, [[n + 1 for n in e] for e in elements]))
END2

for kind in quads triangles hexes tets; do
    python3 make.py $kind vtk >$kind.vtk
    python3 make.py $kind mesh >$kind.mesh
    python3 make.py $kind sol >$kind.sol
    python3 make.py $kind metric >$kind-metric.sol
done

# on_threads KIND ARRAY: smooth KIND.vtk towards the sizes ARRAY on one and two threads; the bits are the same. Leaves
# report.json.
on_threads() {
    local threads
    for threads in 1 2; do
        expect_status 0 "$program" smooth "$1.vtk" --size "$2" --slide auto -o "$1-$threads.vtk" -j $threads \
            --json report.json
    done
    cmp -s "$1-1.vtk" "$1-2.vtk" || fail "$1: threads change the bits"
}

# ---- sizes are met, of every type, and the same on any number of threads

for kind in quads tets $(unless_quick triangles hexes); do
    on_threads $kind h
    grep -q "RMS of log(size / wanted)" out || { fail "the table has sizes"; cat out; }
    expect_json 'r["target"] == "sizes" and r["sizes_of"] == "h" and r["objective"]["size_weight"] == 0.9'
    expect_json 'r["after"]["sizes"]["rms_log"] < 0.6 * r["before"]["sizes"]["rms_log"]'
    expect_json 'r["objective"]["after"] < r["objective"]["before"] and r["after"]["inverted"] == 0 and r["certified"]'
    expect_json 'r["after"]["sizes"]["max"] < r["before"]["sizes"]["max"]'
done

# ---- data of nodes is that of Medit's solution; data of elements is near to it; a weight is heeded

"$program" smooth quads.vtk --size h --slide auto -o a.vtk -q --json report.json
expect_status 0 "$program" smooth quads.mesh --size-from quads.sol --slide auto -o b.mesh -q --json sol.json
expect_status 0 "$program" smooth quads.vtk --size H --slide auto -o c.vtk -q --json cells.json
expect_status 0 "$program" smooth quads.vtk --size h --size-weight 0.1 --slide auto -o d.vtk -q --json little.json
python3 - <<'END2' || fail "sizes are the same wherever they come from"
import json
data, sol, cells, little = (json.load(open(name + ".json")) for name in ("report", "sol", "cells", "little"))
assert data["after"]["sizes"] == sol["after"]["sizes"] or abs(
    data["after"]["sizes"]["rms_log"] / sol["after"]["sizes"]["rms_log"] - 1) < 1e-9
assert abs(cells["after"]["sizes"]["rms_log"] - data["after"]["sizes"]["rms_log"]) < 0.1
assert sol["sizes_of"] == "quads.sol"
assert little["after"]["sizes"]["rms_log"] > 0.8 * little["before"]["sizes"]["rms_log"]
assert little["after"]["rms_aspect_ratio"] < data["after"]["rms_aspect_ratio"]
END2

# ---- the sizes of the input are kept: a graded mesh stays graded

python3 - <<'END2'
import math
N = 12
print("MeshVersionFormatted 2\nDimension 2\nVertices %d" % (N + 1) ** 2, file=(out := open("graded.mesh", "w")))
for i in range(N + 1):
    for j in range(N + 1):
        shift = 0.02 * math.sin(5 * i + 3 * j) * (0 < i < N) * (0 < j < N)
        print((i / N) ** 1.4 + shift, j / N, 0, file=out)
print("Quadrilaterals", N * N, file=out)
for i in range(N):
    for j in range(N):
        a = (N + 1) * i + j + 1
        print(a, a + N + 1, a + N + 2, a + 1, 1, file=out)
print("End", file=out)
END2
expect_status 0 "$program" smooth graded.mesh --keep-sizes --layers ignore --slide auto -o kept.mesh --json kept.json -q
expect_status 0 "$program" smooth graded.mesh --layers ignore --slide auto -o regular.mesh --json report.json -q
expect_json 'r["target"] == "regular" and "sizes_of" not in r and "sizes" not in r["after"]'
python3 - <<'END2' || fail "--keep-sizes keeps more of the grading than none"
import json
kept = json.load(open("kept.json"))
assert kept["target"] == "sizes" and kept["sizes_of"] == "graded.mesh"
assert kept["after"]["sizes"]["rms_log"] < 0.3


def column(name):
    lines = open(name).read().split("\n")
    return sum(float(line.split()[0]) for line in lines[3 + 4 * 13 + 1:3 + 5 * 13 - 1]) / 11


start, with_sizes, without = map(column, ("graded.mesh", "kept.mesh", "regular.mesh"))
assert abs(with_sizes - start) < 0.5 * abs(without - start), (start, with_sizes, without)
END2

# ---- metrics: thin elements where they are wanted, of every type, from either kind of file

for kind in hexes triangles $(unless_quick quads tets); do
    on_threads $kind m
    grep -q "AR measures lengths by m" out || { fail "the table has the metric"; cat out; }
    expect_json 'r["target"] == "metric" and r["sizes_of"] == "m"'
    expect_json 'r["after"]["sizes"]["rms_log"] < 0.9 * r["before"]["sizes"]["rms_log"]'
    expect_json 'r["objective"]["after"] < r["objective"]["before"] and r["after"]["inverted"] == 0 and r["certified"]'
    expect_status 0 "$program" smooth $kind.vtk --size m --size-weight 0 --slide auto -o a.vtk --json report.json
    expect_json 'r["after"]["rms_aspect_ratio"] - 1 < 0.8 * (r["before"]["rms_aspect_ratio"] - 1)'
    cp report.json data.json
    expect_status 0 "$program" smooth $kind.mesh --size-from $kind-metric.sol --size-weight 0 --slide auto -o a.mesh \
        --json report.json
    expect_json 'r["sizes_of"].endswith("-metric.sol")'
    python3 - <<'END2' || fail "$kind: metrics are the same wherever they come from"
import json
data, sol = (json.load(open(name + ".json"))["after"]["rms_aspect_ratio"] for name in ("data", "report"))
assert abs(data / sol - 1) < 1e-6, (data, sol)
END2
done

# In other planes tensors turn with the mesh. The third direction has another size, which does not matter there.
cat >turn.py <<'END2'
import sys
import numpy as np

turn = np.array({"xz": [[1, 0, 0], [0, 0, -1], [0, 1, 0]], "yz": [[0, 0, 1], [1, 0, 0], [0, 1, 0]],
                 "tilted": [[2, -1, 2], [2, 2, -1], [-1, 2, 2]]}[sys.argv[1]]) / (3 if sys.argv[1] == "tilted" else 1)
lines = open("quads.vtk").read().split("\n")
points, tensors = lines.index("POINTS 289 double") + 1, lines.index("TENSORS m double") + 1
turned = np.array([line.split() for line in lines[points:points + 289]], dtype=float) @ turn.T
lines[points:points + 289] = [" ".join(map(repr, row)) for row in turned.tolist()]
metrics = np.array([line.split() for line in lines[tensors:tensors + 867]], dtype=float).reshape(289, 3, 3)
metrics[:, 2, 2] = 100
lines[tensors:tensors + 867] = [" ".join(map(repr, row)) for row in (turn @ metrics @ turn.T).reshape(867, 3).tolist()]
print("\n".join(lines))
END2
if /usr/bin/python3 -c 'import numpy' 2>/dev/null; then
    expect_status 0 "$program" smooth quads.vtk --size m --size-weight 0 --slide auto -o a.vtk --json flat.json
    for plane in xz yz tilted; do
        /usr/bin/python3 turn.py $plane >turned.vtk
        expect_status 0 "$program" smooth turned.vtk --size m --size-weight 0 --slide auto -o a.vtk --json report.json
        expect_json 'r["mesh"]["plane"] is not None and all(
            abs(r[when]["rms_aspect_ratio"] / json.load(open("flat.json"))[when]["rms_aspect_ratio"] - 1) < limit
            for when, limit in (("before", 1e-9), ("after", 1e-4)))'
    done
    expect_status 2 "$program" smooth turned.vtk --size-from quads-metric.sol -o wrong.vtk
    expect_one_line
    expect_text "metrics of two dimensions are for meshes in the plane of x and y"
    expect_no_file wrong.vtk
fi
expect_status 0 "$program" quality quads.vtk --size m --json report.json --report page.html
expect_json 'r["target"] == "metric" and r["quality"]["rms_aspect_ratio"] > 1.2'
grep -qF 'should have the metric in <code>m</code>' page.html || fail "the page says the metric"

# ---- quality and the page

expect_status 0 "$program" quality quads.vtk --size h --json report.json --report page.html
grep -q "RMS of log(size / wanted)" out || { fail "the table of quality has sizes"; cat out; }
expect_json 'r["target"] == "sizes" and 0.3 < r["quality"]["sizes"]["rms_log"] < 0.6'
expect_status 0 "$program" smooth quads.vtk --size h -o a.vtk --json report.json --report page.html -q
expect_status 0 "$program" report report.json -o later.html
cmp -s page.html later.html || fail "the page of a result is that of its run"
grep -qF 'should have the sizes in <code>h</code>' page.html || fail "the page says the sizes"
[ "$(grep -c 'class="part"><th scope="row">with sizes, of elements with a movable node<' page.html)" -eq 2 ] ||
    fail "rows of ratios with sizes have names as those without"
! grep -q "does not hold" page.html && grep -q "worst aspect ratio with sizes of elements" page.html ||
    fail "the page claims nothing that does not hold"

# as_later COMMAND ARGUMENT...: the page of a result is that of its run.
as_later() {
    expect_status 0 "$program" "$@" --json report.json --report page.html -q
    expect_status 0 "$program" report report.json -o later.html
    cmp -s page.html later.html || fail "$*: the page of the result is that of its run"
}
for kind in tets $(unless_quick quads triangles hexes); do
    as_later smooth $kind.vtk --size h -o a.vtk
    as_later smooth $kind.vtk --keep-sizes --slide auto -o a.vtk
    as_later smooth $kind.mesh --size-from $kind.sol -o a.mesh
    as_later smooth $kind.vtk --like $kind.vtk -o a.vtk
    as_later smooth $kind.vtk --layers keep -o a.vtk
    as_later quality $kind.vtk --size h
    as_later quality $kind.vtk --like a.vtk
done

# ---- what does not fit

expect_status 64 "$program" smooth quads.vtk --size none -o wrong.vtk
expect_one_line
expect_text "h"
for size in $(some nan -1 0 1e-20); do
    python3 make.py quads vtk $size >wrong-in.vtk
    expect_status 2 "$program" smooth wrong-in.vtk --size h -o wrong.vtk
    expect_one_line
    expect_no_file wrong.vtk
done
expect_status 2 "$program" smooth quads.mesh --size-from triangles.vtk -o wrong.mesh
expect_one_line
expect_status 2 "$program" smooth quads.mesh --size-from hexes.sol -o wrong.mesh
expect_one_line
expect_status 2 "$program" smooth quads.mesh --size-from gone.sol -o wrong.mesh
expect_one_line
while read -r metric why; do
    python3 make.py quads vtk "$metric" >wrong-in.vtk
    expect_status 2 "$program" smooth wrong-in.vtk --size m -o wrong.vtk
    expect_one_line
    grep -q "$why" err || fail "$metric: $(cat err)"
    expect_no_file wrong.vtk
done <<'END2'
0 the metric at node 11 is not positive definite$
-1 the metric at node 11 is not positive definite$
1e291 the metric at node 11 has an entry that is not a number from -1e290 to 1e290$
nan not finite, for node 11$
1e-30 .
END2
awk '/^TENSORS/ { n = NR + 1 } NR == n { $2 += 1 } { print }' quads.vtk >wrong-in.vtk
expect_status 2 "$program" smooth wrong-in.vtk --size m -o wrong.vtk
grep -q "the metric at node 0 is not symmetric$" err || fail "the first metric: $(cat err)"
# Metrics are relative, however small or large they are.
for kind in $(some hexes quads); do
    for power in -996 930; do
        python3 -c 'if True:
            import sys
            scaled = False
            for line in sys.stdin:
                print(*[repr(float(v) * 2.0 ** int(sys.argv[1])) for v in line.split()] if scaled else [line.rstrip()])
                scaled = scaled or line.startswith("TENSORS")' $power <$kind.vtk >scaled.vtk
        for file in $kind scaled; do
            expect_status 0 "$program" smooth $file.vtk --size m --max-sweeps 3 -o a.vtk --json $file.json
        done
        python3 -c 'if True:
            import json, sys
            a, b = [json.load(open(name)) for name in sys.argv[1:]]
            a["after"]["sizes"].pop("factor"), b["after"]["sizes"].pop("factor")
            assert a["after"] == b["after"], "other metrics"' $kind.json scaled.json ||
            fail "$kind: metrics times 2^$power"
    done
done
expect_status 2 "$program" smooth quads.vtk --size h --size-weight 0 -o wrong.vtk
expect_one_line
mapfile -t wrong < <(some "--size h --like quads.vtk" "--size h --layers keep" "--size h --keep-sizes" "--size h --size-from quads.sol" \
    "--size h --objective worst" "--size h --objective edge-ratio" "--keep-sizes --size-weight 0" "--size-weight 0.5" \
    "--size h --method laplacian")
for options in "${wrong[@]}"; do
    # shellcheck disable=SC2086 # several words
    expect_status 64 "$program" smooth quads.vtk $options -o wrong.vtk
    expect_one_line
done
expect_no_file wrong.vtk wrong.mesh

finish
