#!/usr/bin/env bash
# --layers keep: nodes move along layers, whose heights stay, and a wall that was moved gets its first heights back. The
# table, JSON and page say that ratios are against the layers. It is the default for quadrilaterals, hexahedra and prisms.
. "$(dirname "$0")/common.sh"

# make.py KIND DEPTH PUSH [ROWS]: N cells along each side and ROWS rows, which grow by 1.3 from the wall. The wall is moved by
# DEPTH first heights in its middle, and columns inside are bent along the layer by up to PUSH cells.
cat >make.py <<'END2'
import itertools
import math
import random
import sys
import box_file

kind, depth, push = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
N, GROWTH, FIRST = 8, 1.2, 0.01
ROWS = int(sys.argv[4]) if len(sys.argv) > 4 else 24
dim = box_file.dimension(kind)
sides = [N] * (dim - 1) + [ROWS]
random.seed(3)
off = {at: [push * random.uniform(-1, 1) if all(0 < c < N for c in at) else 0 for _ in at]
       for at in itertools.product(range(N + 1), repeat=dim - 1)}
number, points = {}, []
for at in itertools.product(*(range(n + 1) for n in sides)):
    height = (GROWTH ** at[-1] - 1) / (GROWTH ** ROWS - 1)
    p = [c + 4 * height * (1 - height) * d for c, d in zip(at, off[at[:-1]])]
    p.append(FIRST * (GROWTH ** at[-1] - 1) / (GROWTH - 1))
    if at[-1] == 0:
        p[-1] += depth * FIRST * math.prod(math.sin(math.pi * c / N) for c in p[:-1])
    number[at] = len(points) + 1
    points.append(p)
print(box_file.medit(kind, points, box_file.elements(kind, sides, number)))
END2

# heights.py KIND MESH ROWS [ALL]: the largest relative error of the heights of the first rows, of ALL.
cat >heights.py <<'END2'
import itertools
import sys

N, GROWTH, FIRST = 8, 1.2, 0.01
ROWS = int(sys.argv[4]) if len(sys.argv) > 4 else 24
dim = 2 if sys.argv[1] in ("quads", "triangles") else 3
lines = iter(open(sys.argv[2]).read().split("\n"))
for line in lines:
    if line.startswith("Vertices"):
        break
points = [list(map(float, next(lines).split()[:dim])) for _ in range((N + 1) ** (dim - 1) * (ROWS + 1))]
index = {at: i for i, at in enumerate(itertools.product(*[range(N + 1)] * (dim - 1), range(ROWS + 1)))}
print(max(abs((points[index[at + (row + 1,)]][-1] - points[index[at + (row,)]][-1]) / (FIRST * GROWTH ** row) - 1)
          for row in range(int(sys.argv[3])) for at in itertools.product(range(1, N), repeat=dim - 1)))
END2

# tangle.py KIND MESH: a node in the middle goes from the third row down, through the one under it.
cat >tangle.py <<'END2'
import sys

N, ROWS, GROWTH, FIRST = 8, 24, 1.2, 0.01
lines = open(sys.argv[2]).read().split("\n")
first = next(i for i, line in enumerate(lines) if line.startswith("Vertices")) + 1
column = N // 2 if sys.argv[1] in ("quads", "triangles") else N // 2 * (N + 1) + N // 2
at = first + column * (ROWS + 1) + 3
words = lines[at].split()
words[-2] = repr(float(words[-2]) - 1.5 * FIRST * GROWTH ** 3)
lines[at] = " ".join(words)
print("\n".join(lines))
END2

# below X MOST: X is at most that.
below() {
    python3 -c "import sys; x, most = map(float, sys.argv[1:]); sys.exit(not x <= most)" "$@"
}

# With PLANISH_QUICK each kind comes here or below.
for kind in tets triangles $(unless_quick quads hexes prisms); do
    # ---- pushed along the layer
    python3 make.py $kind 0 0.3 >pushed.mesh
    for threads in 1 2; do
        expect_status 0 "$program" smooth pushed.mesh -o out-$threads.mesh --layers keep -j $threads --json report.json
    done
    cmp -s out-1.mesh out-2.mesh || fail "$kind: threads change the bits"
    expect_text "are thin in layers, and keep their heights"
    grep -q "AR compares layers with their former heights" out || fail "$kind: the table says the target"
    expect_json 'r["target"] == "layers" and "like" not in r and r["mesh"]["layer_elements"] > 0'
    # No node of a layer is held but where its heights would change by more than a tenth.
    expect_json 'r["mesh"]["held"]["layers"] <= r["layer_heights"]["held_nodes"] < r["mesh"]["free_nodes"] / 2'
    expect_json '0.9 <= r["layer_heights"]["min"] and r["layer_heights"]["max"] <= 1.1'
    expect_json 'r["after"]["rms_aspect_ratio"] < r["before"]["rms_aspect_ratio"]'
    expect_json 'r["objective"]["name"] == "mean-ratio" and r["after"]["inverted"] == 0'
    worst=$(python3 heights.py $kind out-1.mesh 10)
    below "$worst" 0.1 || fail "$kind: heights $worst"
    # The heights that are told are those that are measured here.
    expect_json 'r["layer_heights"]["wanted"] == "before" and r["layer_heights"]["told_by_rows_inside"] == 0'
    expect_json 'r["layer_heights"]["before"]["min"] == r["layer_heights"]["before"]["max"] == 1'
    expect_json "abs(max(max(1 - h['min'], h['max'] - 1) for h in r['layer_heights']['rows'][:10]) - $worst) < 0.02"
    grep -q "^heights of layers: .* off those before, median" out || fail "$kind: the table says the heights"
    ! grep -q "heights of layers are" err || fail "$kind: there is nothing to note: $(cat err)"
    expect_status 0 "$program" compare pushed.mesh out-1.mesh --json compared.json
    python3 - <<'END2' || fail "$kind: compare and smooth measure heights alike"
import json
a, b = (json.load(open(n))["layer_heights"] for n in ("report.json", "compared.json"))
assert a["edges"] >= b["edges"] > 0 and abs(a["max"] - b["max"]) < 0.01, (a, b)
END2
    # A row without a height has the sign of all tables for what is not known.
    python3 - <<'END2' >unknown.json
import json
r = json.load(open("report.json"))
r["layer_heights"]["rows"][0]["median"] = None
print(json.dumps(r))
END2
    expect_status 0 "$program" report unknown.json -o unknown.html
    sed -n '/<section id="layers"/,/<\/section>/p' unknown.html | grep -qE '<td>(–|&ndash;|&#8211;)</td>' || fail "$kind: a height that is not known"
    "$program" quality pushed.mesh --layers keep --json quality.json -q
    python3 - <<'END2' || fail "$kind: quality and smooth measure alike"
import json
a, b = (json.load(open(n)) for n in ("report.json", "quality.json"))
assert b["target"] == "layers"
assert abs(a["before"]["rms_aspect_ratio"] / b["quality"]["rms_aspect_ratio"] - 1) < 1e-12
END2
    # ---- a wall that was moved
    python3 make.py $kind 1.4 0 >moved.mesh
    expect_status 0 "$program" smooth moved.mesh -o out.mesh --layers keep --json report.json
    expect_json 'r["before"]["inverted"] > 0 and r["after"]["inverted"] == 0'
    below "$(python3 heights.py $kind out.mesh 5)" 0.1 || fail "$kind: first heights $(python3 heights.py $kind out.mesh 5)"
    expect_json 'r["layer_heights"]["told_by_rows_inside"] > 0 and r["layer_heights"]["before"]["min"] < 0'
    expect_json 'all(0.9 < h["min"] and h["max"] < 1.1 for h in r["layer_heights"]["rows"][:5])'
    grep -q "^A wall was moved: .* heights are told by the rows inside" out || fail "$kind: the table says that a wall was moved"
    expect_json 'r["layer_heights"]["at_moved_walls"] == r["layer_heights"]["told_by_rows_inside"]'
    # A node inside was displaced: no wall was moved, and held layers would stay inverted.
    python3 make.py $kind 0 0 >start.mesh
    python3 tangle.py $kind start.mesh >tangled.mesh
    expect_status 0 "$program" smooth tangled.mesh -o out.mesh --layers keep --json report.json --report page.html
    expect_json 'r["before"]["inverted"] > 0 and r["after"]["inverted"] == 0'
    expect_json 'r["layer_heights"]["told_by_rows_inside"] == 2 and r["layer_heights"]["at_moved_walls"] == 0'
    expect_json '0.99 < r["layer_heights"]["min"] and r["layer_heights"]["max"] < 1.01'
    below "$(python3 heights.py $kind out.mesh 5)" 0.02 || fail "$kind: heights of displaced nodes $(python3 heights.py $kind out.mesh 5)"
    grep -q "^Nodes of layers were displaced: 2 of .* heights are told by other rows" out || fail "$kind: the table says what was displaced"
    grep -q "Nodes of layers were displaced: 2 wanted heights are told by other rows" page.html || fail "$kind: the page says what was displaced"
    ! grep -qE "wall was moved|layers hold" out err page.html || fail "$kind: no wall was moved: $(cat err)"
    # The same against the mesh before: it tells all heights.
    expect_status 0 "$program" smooth moved.mesh -o liked.mesh --like start.mesh --json report.json
    expect_json 'r["layer_heights"]["wanted"] == "like" and r["layer_heights"]["told_by_rows_inside"] == 0'
    grep -q "off those in the mesh of --like" out || fail "$kind: the table says the heights with --like"
    "$program" quality out.mesh --like start.mesh --json report.json >out
    expect_json 'all(0.9 < h["min"] and h["max"] < 1.1 for h in r["layer_heights"]["rows"][:5])'
done

# ---- without an option

for kind in quads hexes $(unless_quick prisms); do
    python3 make.py $kind 0 0.3 >pushed.mesh
    expect_status 0 "$program" smooth pushed.mesh -o kept.mesh --layers keep -q
    expect_status 0 "$program" smooth pushed.mesh -o out.mesh --json report.json
    cmp -s kept.mesh out.mesh || fail "$kind: keep is the default"
    expect_text "are thin in layers, and keep their heights; --layers hold holds their nodes"
    grep "thin in layers" err >noted
    grep -q "AR compares layers with their former heights" out || fail "$kind: the table says the target by default"
    expect_json 'r["target"] == "layers" and r["mesh"]["held"]["layers"] <= r["layer_heights"]["held_nodes"]'
    expect_json 'r["mesh"]["kept_layer_elements"] == r["mesh"]["layer_elements"] > 100'
    expect_json 'r["after"]["min_scaled_jacobian"] >= r["before"]["min_scaled_jacobian"] - 1e-9'
    expect_status 0 "$program" quality pushed.mesh --json report.json
    expect_text "$(cat noted)"
    expect_json 'r["target"] == "regular" and r["mesh"]["kept_layer_elements"] > 100 and r["mesh"]["held_layer_elements"] == 0'
    # A wall was moved through one of few rows: more than a twentieth of the elements at the layer are inverted. Of
    # quadrilaterals these are so many that keep has to be asked for.
    python3 make.py $kind 1.4 0 8 >moved.mesh
    asked=()
    [ $kind != quads ] || asked=(--layers keep)
    expect_status 0 "$program" smooth moved.mesh -o out.mesh --json report.json "${asked[@]}"
    expect_json 'r["before"]["inverted"] > 0 and r["after"]["inverted"] == 0 and r["target"] == "layers"'
    below "$(python3 heights.py $kind out.mesh 3 8)" 0.1 ||
        fail "$kind: first heights of few rows $(python3 heights.py $kind out.mesh 3 8)"
    # Held layers would be in the way of the repair where a wall was moved through rows.
    python3 make.py $kind 3 0 8 >moved.mesh
    expect_status 0 "$program" smooth moved.mesh -o out.mesh --objective worst --json report.json
    expect_json 'r["after"]["inverted"] == 0 and r["mesh"]["held"]["layers"] == 0 and r["target"] == "regular"'
    expect_status 1 "$program" smooth moved.mesh -o out.mesh --layers hold --json report.json
    expect_text "are thin in layers, and held"
    expect_json 'r["after"]["inverted"] == r["before"]["inverted"] == r["inverted_held"]["fix_layers"] > 0'
    expect_json 'r["mesh"]["held"]["layers"] > 0 and r["mesh"]["held_layer_elements"] > 20'
    # So many inverted elements may be those of a tangled mesh: keep has to be asked for.
    expect_status 0 "$program" smooth moved.mesh -o out.mesh --json report.json
    expect_json 'r["after"]["inverted"] == 0 and r["mesh"]["kept_layer_elements"] == 0 and r["target"] == "regular"'
    if [ $kind != quads ]; then
        expect_text "are thin in layers (did a wall move?): --layers keep keeps their heights"
        grep "did a wall move" err >noted
        # Heights are told also where few of these elements have a node that moves.
        { grep -v "^End" moved.mesh; seq 625 | sed "1i RequiredVertices\n625"; echo End; } >few.mesh
        expect_status 1 "$program" smooth few.mesh -o out.mesh --json report.json
        expect_json '0 < r["mesh"]["free_layer_elements"] < 100 < r["mesh"]["layer_elements"]'
        expect_json 'r["layer_heights"] is not None'
        expect_text "did a wall move"
        expect_status 0 "$program" quality moved.mesh
        expect_text "$(cat noted)"
    fi
    expect_status 0 "$program" smooth moved.mesh -o out.mesh --layers keep --json report.json
    expect_json 'r["after"]["inverted"] == 0 and r["target"] == "layers"'
done
# A corner that is flat for good: what holds heights is not the reason.
python3 make.py quads 0 0.45 | sed '5s/.*/0.5 0 0/' >flat.mesh
expect_status 1 "$program" smooth flat.mesh -o out.mesh --json report.json
expect_text "cannot be made valid by moving free nodes (element 1)"
expect_json 'r["layer_heights"]["held_nodes"] > 0 and r["inverted_held"]["fix_layers"] == 0'
for kind in triangles $(unless_quick tets); do # layers of these have a note, as before
    python3 make.py $kind 0 0.1 >pushed.mesh
    expect_status 0 "$program" smooth pushed.mesh -o out.mesh --json report.json
    expect_json 'r["target"] == "regular" and r["mesh"]["kept_layer_elements"] == 0'
    expect_json 'r["mesh"]["held"]["layers"] == 0 and r["mesh"]["free_layer_elements"] > 100'
    expect_text "(a boundary layer?): --fix-layers keeps them"
    grep -q "^note: heights of layers are .* off those before, most in row .*: --layers keep, or --fix-layers, keeps them" err ||
        fail "$kind: heights that changed have a note: $(cat err)"
    expect_json 'r["layer_heights"]["max"] > 1.1'
    # Ways to smooth are compared by the layers, and keeping them is one.
    expect_status 0 "$program" advise pushed.mesh
    grep -q "^All figures are against the layers of the mesh" out || fail "$kind: what figures are against"
    grep -q "^Run: planish smooth pushed.mesh OUT --layers keep$" out || fail "$kind: $(grep ^Run: out)"
done
# Held layers are measured as kept ones are: their aspect ratios are not those of thin elements.
kind=prisms
[ -z "${PLANISH_QUICK-}" ] || kind=quads
python3 make.py $kind 0 0.3 >pushed.mesh
expect_status 0 "$program" advise pushed.mesh
! grep -q -e "with --layers keep" out || fail "layers are kept without an option"
python3 - <<'END2' || fail "figures of advise: $(cat out)"
best = [line.split() for line in open("out") if line.startswith("  with --best")][0]
assert float(best[5]) < 2, best
END2

# ---- layers on both sides of a surface that is wavy, and a wall that was moved in a valid mesh

# sides.py KIND DEPTH: ROWS rows rise to both sides of a surface in the middle. Columns inside are bent along the layer.
# The lowest wall is moved by DEPTH of the heights there.
cat >sides.py <<'END2'
import itertools
import math
import random
import sys
import box_file

kind, depth = sys.argv[1], float(sys.argv[2])
N, ROWS, GROWTH, FIRST = 10, 9, 1.25, 0.02
sides = [N] * (box_file.dimension(kind) - 1) + [2 * ROWS]
random.seed(1)
number, points = {}, []
for at in itertools.product(*(range(n + 1) for n in sides)):
    is_inside = all(0 < a < n for a, n in zip(at, sides))
    p = [c + 0.03 * random.uniform(-1, 1) * is_inside for c in at[:-1]]
    level = at[-1] - ROWS
    height = math.copysign(FIRST * (GROWTH ** abs(level) - 1) / (GROWTH - 1), level)
    p.append(height + 0.3 * math.sin(0.6 * p[0]))
    number[at] = len(points) + 1
    points.append(p)
print(box_file.medit(kind, points, box_file.elements(kind, sides, number)))
END2
for kind in quads $(unless_quick hexes prisms); do
    python3 sides.py $kind 0 >sides.mesh
    expect_status 0 "$program" smooth sides.mesh -o out.mesh --json report.json
    expect_json 'r["before"]["inverted"] == 0 and r["layer_heights"]["told_by_rows_inside"] == 0'
    expect_json '0.9 <= r["layer_heights"]["min"] and r["layer_heights"]["max"] <= 1.1'
    expect_json 'len(r["layer_heights"]["rows"]) <= 9'
    ! grep -q "heights of layers are" err || fail "$kind: there is nothing to note: $(cat err)"
    ! grep -q "A wall was moved" out || fail "$kind: no wall was moved"
    # Where nothing needs to move nothing is said of walls.
    expect_status 0 "$program" smooth sides.mesh -o out.mesh --only-worse-than 1000
    ! grep -q "those wanted" out err || fail "$kind: heights are those before: $(cat err)"
    # First heights that were moved come back, also in a valid mesh.
    for depth in 0.6 -1 -3; do
        python3 make.py $kind $depth 0 >moved.mesh
        expect_status 0 "$program" smooth moved.mesh -o out.mesh --json report.json
        expect_json 'r["before"]["inverted"] == 0 and r["layer_heights"]["told_by_rows_inside"] > 0'
        expect_json 'r["layer_heights"]["held_nodes"] == 0'
        below "$(python3 heights.py $kind out.mesh 3)" 0.15 || fail "$kind: heights $(python3 heights.py $kind out.mesh 3)"
    done
done
# Where elements are inverted, holding layers is no advice.
python3 make.py quads 9 0 8 >moved.mesh
expect_status 0 "$program" smooth moved.mesh -o out.mesh --layers keep
expect_text ": --like FILE, the mesh before its wall moved, keeps them better"
! grep -q "layers hold" err || fail "held layers would stay inverted: $(cat err)"
# There may be no mesh from before.
python3 make.py quads -9 0 8 >moved.mesh
expect_status 0 "$program" smooth moved.mesh -o out.mesh --layers keep
expect_text ": --like FILE, the mesh before its wall moved, keeps them better, and --layers hold keeps them as they are"

# ---- prisms over a wall, tetrahedra over these: all that are thin keep their heights

python3 - >mixed.mesh <<'END2'
import itertools
import box_file

N, ROWS, PRISMS = 8, 24, 5
number, points = {}, []
for at in itertools.product(range(N + 1), range(N + 1), range(ROWS + 1)):
    number[at] = len(points) + 1
    bend = 0.03 * all(0 < a < n for a, n in zip(at, (N, N, ROWS))) * (-1) ** at[0]
    points.append([at[0] / N + bend, at[1] / N, 0.01 * (1.2 ** at[2] - 1) / 0.2])
above = {at: number[at[0], at[1], at[2] + PRISMS] for at in number if at[2] + PRISMS <= ROWS}
text = box_file.medit("prisms", points, box_file.elements("prisms", [N, N, PRISMS], number))
tets = box_file.elements("tets", [N, N, ROWS - PRISMS], above)
print(text[:-len("End")] + "Tetrahedra %d" % len(tets))
print("\n".join(" ".join(map(str, e)) + " 1" for e in tets) + "\nEnd")
END2
expect_status 0 "$program" smooth mixed.mesh -o out.mesh --json report.json
expect_json 'r["target"] == "layers" and r["mesh"]["kept_layer_elements"] == r["mesh"]["layer_elements"] > 1640'
# What pulls at rows by more than a tenth of their heights is undone: the nodes there are held.
expect_json '0 < r["mesh"]["held"]["layers"] <= r["layer_heights"]["held_nodes"] and r["mesh"]["free_nodes"] > 200'
expect_json '0.9 <= r["layer_heights"]["min"] and r["layer_heights"]["max"] <= 1.1'
expect_json 'r["after"]["rms_aspect_ratio"] < r["before"]["rms_aspect_ratio"] and r["mesh"]["free_layer_elements"] == 0'
expect_json 'r["after"]["max_aspect_ratio_movable"] <= r["before"]["max_aspect_ratio_movable"] * (1 + 1e-9)'
grep -q "nodes of layers are held, as heights would change by more than 10 %" out || fail "the table says what is held"
expect_text "are thin in layers, and keep their heights"
expect_status 0 "$program" smooth mixed.mesh -o told.mesh -q -j 2
cmp -s out.mesh told.mesh || fail "what is told, and threads, change the bits"
below "$(python3 heights.py prisms out.mesh 12)" 0.1 || fail "mixed: all heights $(python3 heights.py prisms out.mesh 12)"
below "$(python3 heights.py prisms out.mesh 4)" 0.1 || fail "mixed: heights $(python3 heights.py prisms out.mesh 4)"
# Where the nodes beside those would change heights in their turn, all of layers are held in the end.
python3 "$cli/uneven_mesh.py" >uneven.mesh
expect_status 0 "$program" smooth uneven.mesh -o out.mesh --json report.json
expect_json '0.9 <= r["layer_heights"]["min"] and r["layer_heights"]["max"] <= 1.1 and r["moved_nodes"] > 100'
# Sizes keep no layers, and that is told.
expect_status 0 "$program" smooth uneven.mesh -o out.mesh --keep-sizes --json report.json
expect_text "are thin in layers"
expect_json 'r["mesh"]["layer_elements"] > 1000 and r["layer_heights"] is not None'
expect_status 0 "$program" smooth mixed.mesh -o out.mesh --layers hold --json report.json
expect_json 'r["target"] == "regular" and r["mesh"]["held_layer_elements"] == r["mesh"]["layer_elements"] > 1640'

# ---- the page; meshes without layers

expect_status 0 "$program" smooth pushed.mesh -o out.mesh --layers keep --report page.html -q
grep -q 'id="target">The layers should keep their heights' page.html || fail "the page says the target"
grep -q 'id="layers" class="whole"><h2>Heights of layers' page.html || fail "the page tells the heights"
grep -q "former heights of the layers" page.html || fail "the page has the target among its facts"
python3 make.py prisms 0 0.3 >pushed.mesh
expect_status 0 "$program" smooth pushed.mesh -o out.mesh --json report.json --report page.html -q
expect_status 0 "$program" report report.json -o later.html
cmp -s page.html later.html || fail "the page of a result is that of its run"
expect_status 0 "$program" quality pushed.mesh --layers keep --json report.json --report page.html
expect_status 0 "$program" report report.json -o later.html
cmp -s page.html later.html || fail "the page of qualities is that of their measurement"
rm out.mesh
expect_status 0 "$program" smooth pushed.mesh -o out.mesh --json report.json -q
rm pushed.mesh
expect_status 0 "$program" report report.json -o later.html
expect_text "is drawn only beside its targets"
expect_status 0 "$program" smooth "$sample" -o plain.vtk --layers ignore
expect_status 0 "$program" smooth "$sample" -o kept.vtk --layers keep --json report.json
expect_json 'r["target"] == "regular" and r["mesh"]["layer_elements"] == 0'
cmp -s plain.vtk kept.vtk || fail "without layers keep changes nothing"
for method in laplacian area-laplacian length-laplacian; do
    expect_status 64 "$program" smooth "$sample" -o wrong.vtk --layers keep --method $method
    expect_text "--layers keep has no effect with --method $method"
done

finish
