#!/usr/bin/env bash
# Bounds of coordinates and limits of moves are kept, and are what keeps the nodes.
. "$(dirname "$0")/common.sh"

python3 "$cli/make_slow_mesh.py" 12 square.mesh # nodes want to go to the right
python3 "$cli/make_mesh.py" 6 0.3 cube.mesh

# check IN OUT FREE: OUT is within the box or the distance that the environment says, while FREE,
# which comes without it, is not.
check() {
    python3 - "$@" <<'END' || fail "${bounds[*]}: $1"
import json, math, os, sys
import mesh_file
old, new, free = (mesh_file.read(name) for name in sys.argv[1:])
report = json.load(open("report.json"))
held = mesh_file.boundary(old)
inner = [i for i in range(len(old.points)) if i not in held]
assert report["mesh"]["free_nodes"] == len(inner) and report["certified"]
assert all(old.points[i] == new.points[i] for i in held)
assert report["after"]["rms_radius_ratio"] < report["before"]["rms_radius_ratio"]
if os.environ.get("BOX"):
    box = [float(x) for x in os.environ["BOX"].split(",")]
    lower, upper = box[:old.dim], box[old.dim:]

    def inside(p):
        return all(a <= x <= b for a, x, b in zip(lower, p, upper))
    outside = [i for i in inner if not inside(old.points[i])]
    assert report["held_outside"] == len(outside) > 0
    assert all(old.points[i] == new.points[i] for i in outside)
    within = [i for i in inner if inside(old.points[i])]
    assert all(inside(new.points[i]) for i in within)
    assert any(old.points[i] != new.points[i] for i in within)
    assert any(not inside(free.points[i]) for i in within), "the box is too large to matter"
else:
    distance, unit = float(os.environ["DISTANCE"].rstrip("h")), [1] * len(old.points)
    if "h" in os.environ["DISTANCE"]:
        lengths = [{} for _ in old.points]
        for element in old.elements:
            for a in element:
                for b in element:
                    if a != b:
                        lengths[a][b] = math.dist(old.points[a], old.points[b])
        unit = [sum(x.values()) / len(x) for x in lengths]
    moves = [math.dist(old.points[i], new.points[i]) / unit[i] for i in range(len(unit))]
    assert 0 < max(moves) <= distance * (1 + 1e-9), max(moves)
    # A Laplacian move that leaves the bounds is not made; an optimal node may lie on them.
    assert report["method"] != "planish" or max(moves) > 0.9 * distance, max(moves)
    assert any(math.dist(old.points[i], free.points[i]) > distance * unit[i] for i in inner)
    assert report["held_outside"] == 0
    farthest = max(math.dist(a, b) for a, b in zip(old.points, new.points))
    assert math.isclose(report["max_displacement"], farthest, rel_tol=1e-9)
END
}

for method in planish laplacian; do
    for mesh in square cube; do
        expect_status 0 "$program" smooth $mesh.mesh -o free.mesh --method "$method" --json report.json -q
        expect_json "r['held_outside'] == 0 and r['kkt'] is None"
        box=0.1,0.2,0.45,0.9
        [ $mesh = square ] || box=0.2,0.25,0.3,0.7,0.8,0.75
        for bounds in "--box $box" "--max-displacement 0.02" "--max-displacement 0.15h"; do
            read -ra bounds <<<"$bounds"
            expect_status 0 "$program" smooth $mesh.mesh -o out.mesh --method "$method" \
                --json report.json -q "${bounds[@]}"
            if [ "${bounds[0]}" = --box ]; then
                BOX=$box check $mesh.mesh out.mesh free.mesh
            else
                DISTANCE=${bounds[1]} check $mesh.mesh out.mesh free.mesh
            fi
            [ $method != planish ] || expect_json "r['kkt']['residual'] >= 0 == r['kkt']['max_multiplier']"
        done
    done
done

# Both together, told on the terminal; a box around everything changes nothing.
expect_status 0 "$program" smooth square.mesh -o out.mesh --box 0,0,0.5,1 --max-displacement 1e-3
expect_status 0 "$program" smooth square.mesh -o out.mesh --box 0.3,0,0.5,1
grep -q "outside the bounds" out || fail "nodes outside of their bounds are not told"
expect_status 0 "$program" smooth square.mesh -o free.mesh -q
expect_status 0 "$program" smooth square.mesh -o out.mesh --box=-1e9,-1e9,1e9,1e9 -q
cmp free.mesh out.mesh || fail "bounds that are far away change the mesh"
expect_status 0 "$program" smooth square.mesh -o out.mesh --box 0.99,0.99,1,1 --json report.json -q
cmp square.mesh out.mesh || fail "nodes that are all outside have moved"
expect_json "r['held_outside'] == r['mesh']['free_nodes'] and r['moved_nodes'] == 0"

# The worst elements whose movable nodes are all outside of the box: they are movable, and held.
expect_status 0 "$program" smooth cube.mesh -o out.mesh --box 0,0,0,1,1,0.5 --json report.json --report report.html -q
python3 - <<'END' || fail "which elements the box holds"
import json
import mesh_file
mesh, report = mesh_file.read("cube.mesh"), json.load(open("report.json"))
surface = mesh_file.boundary(mesh)
n_held = 0
for state in ("before", "after"):
    for element in report[state]["worst_elements"]:
        free = [n - 1 for n in element["nodes"] if n - 1 not in surface]
        held = bool(free) and all(mesh.points[i][2] > 0.5 for i in free)
        assert element["movable"] == bool(free)
        assert element["held"] == ("bounds" if held else None), element
        n_held += held
assert 0 < n_held < 20, n_held
assert open("report.html").read().count("yes, but held outside of the bounds") == n_held
END
expect_status 0 "$program" smooth cube.mesh -o out.mesh --max-displacement 0.001 --json report.json -q
expect_json "all(e['held'] is None for s in ('before', 'after') for e in r[s]['worst_elements'])"
finish
